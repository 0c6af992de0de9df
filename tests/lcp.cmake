# Tests of the complementarity problems: kernels, solver, published problems, seeded families.
nsdae_test(anomaly lcp LINKS test_allocator)
nsdae_unit_test(lcp exact)
nsdae_unit_test(lcp proof)
nsdae_unit_test(lcp warm)

if(NSDAE_DRIVERS)
  nsdae_test(system lcp_published LINKS nsdae_driver_common)
  target_compile_definitions(test_system_lcp_published PRIVATE NSDAE_TEST_DATA="${CMAKE_CURRENT_SOURCE_DIR}/data")
endif()
foreach(name enumerate pgs principal)
  nsdae_unit_test(lcp ${name})
endforeach()

nsdae_test(anomaly kernels)

if(NSDAE_HDF5)
  nsdae_unit_test(io formula)
  nsdae_unit_test(io write_queue)
  target_link_libraries(test_unit_io_write_queue PRIVATE nsdae_hdf5)
  nsdae_unit_test(io lcp_file)
  target_compile_definitions(test_unit_io_lcp_file PRIVATE _POSIX_C_SOURCE=200809L)
  target_link_libraries(test_unit_io_lcp_file PRIVATE nsdae_hdf5 test_allocator)
endif()
if(NSDAE_DRIVERS)
  # the speeds of a pendulum at rest on its stop are below 1e-308 from 1055 s on
  foreach(method implicit implicit-printed moreau)
    add_test(NAME system/rest_${method} COMMAND nsdae-pendulum --method ${method} --t-end 1100
      --no-output --quiet)
  endforeach()
  nsdae_test(system failed_lcp)
  add_test(NAME system/lcp_cli COMMAND ${CMAKE_CURRENT_SOURCE_DIR}/system/lcp_cli.sh
    ${PROJECT_BINARY_DIR}/bin $<IF:$<BOOL:${NSDAE_HDF5}>,ON,OFF>
    $<IF:$<BOOL:${NSDAE_SUNDIALS}>,ON,OFF>)
  set_tests_properties(system/lcp_cli PROPERTIES ENVIRONMENT OPENBLAS_NUM_THREADS=1 TIMEOUT 300)
endif()
nsdae_unit_test(lcp lemke)
target_sources(test_unit_lcp_lemke PRIVATE bench/bench_lcp_families.c)


add_library(test_lcp_families OBJECT support/lcp_families.c)
target_include_directories(test_lcp_families PUBLIC support)
nsdae_test(system lcp_families LINKS test_lcp_families)
target_compile_definitions(test_system_lcp_families PRIVATE _POSIX_C_SOURCE=200809L)
nsdae_test(system lcp_range LINKS test_lcp_families)
nsdae_test(system decay)
