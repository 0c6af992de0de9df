# Tests of the frictional contact problems.
foreach(name contact kernels map sweeps sliding)
  nsdae_unit_test(friction ${name})
endforeach()

# Seeded problems of rigid bodies.
add_library(test_friction_families OBJECT support/friction_families.c)
target_include_directories(test_friction_families PUBLIC support)
target_link_libraries(test_friction_families PUBLIC nsdae_lib_static)

if(NSDAE_HDF5)
  nsdae_unit_test(io friction_file)
  target_compile_definitions(test_unit_io_friction_file PRIVATE _POSIX_C_SOURCE=200809L)
  target_link_libraries(test_unit_io_friction_file PRIVATE nsdae_hdf5 test_friction_families)
  if(NSDAE_DRIVERS)
    add_executable(friction_sample support/friction_sample.c)
    target_link_libraries(friction_sample PRIVATE test_friction_families)
    add_test(NAME system/friction_cli COMMAND ${CMAKE_CURRENT_SOURCE_DIR}/system/friction_cli.sh
      ${CMAKE_BINARY_DIR}/bin $<TARGET_FILE:friction_sample>)
    set_tests_properties(system/friction_cli PROPERTIES ENVIRONMENT OPENBLAS_NUM_THREADS=1
      TIMEOUT 120)
  endif()
endif()
nsdae_test(anomaly friction LINKS test_allocator)
nsdae_test(system friction_forms LINKS test_friction_families)
nsdae_test(system friction_bounded LINKS test_friction_families)
nsdae_test(system friction_families LINKS test_friction_families)
nsdae_unit_test(friction alike)
target_link_libraries(test_unit_friction_alike PRIVATE test_friction_families)
nsdae_test(system friction_infeasible)
nsdae_test(system friction_planar)
nsdae_test(system friction_published)
target_compile_definitions(test_system_friction_published PRIVATE
  NSDAE_SHARED_DIR="${NSDAE_SHARED_DIR}")
target_compile_definitions(test_system_friction_families PRIVATE _POSIX_C_SOURCE=200809L)
if(NSDAE_SANITIZE)
  target_compile_definitions(test_system_friction_families PRIVATE NSDAE_TEST_SHARE=8)
endif()
