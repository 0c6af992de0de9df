# Tests of the complementarity problems: kernels, solver, published problems, seeded families.
nsdae_test(anomaly lcp LINKS test_allocator)

# Published problems are read where they lie; the test is skipped where they are not.
set(NSDAE_SHARED_DIR "${PROJECT_SOURCE_DIR}/../shared" CACHE PATH
    "Folder with lcp_problems/, the complementarity problems of others")
if(NSDAE_DRIVERS)
  nsdae_test(system lcp_published LINKS driver_common)
  target_compile_definitions(test_system_lcp_published PRIVATE
    NSDAE_SHARED_DIR="${NSDAE_SHARED_DIR}")
endif()
foreach(name enumerate pgs principal)
  nsdae_unit_test(lcp ${name})
endforeach()

nsdae_test(anomaly kernels)
