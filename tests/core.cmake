# Unit tests of base, linalg, system, terms, contact, and the anomaly tests.
foreach(name arena nearest params status)
  nsdae_unit_test(base ${name})
endforeach()

foreach(name dense kkt)
  nsdae_unit_test(linalg ${name})
  target_link_libraries(test_unit_linalg_${name} PRIVATE nsdae_lapack)
endforeach()
