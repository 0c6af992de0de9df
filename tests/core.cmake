# Unit tests of base, linalg, system, terms, contact, and the anomaly tests.
foreach(name arena nearest params status)
  nsdae_unit_test(base ${name})
endforeach()
