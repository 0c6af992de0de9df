# Tests of the frictional contact problems.
foreach(name contact kernels natural_map double_double nsgs one_contact)
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
  # Consecutive steps of one system.
  add_library(test_friction_sequence OBJECT support/friction_sequence.c)
  target_include_directories(test_friction_sequence PUBLIC support)
  target_link_libraries(test_friction_sequence PUBLIC nsdae_lib_static nsdae_hdf5)
  nsdae_test(system friction_warm LINKS test_friction_families test_friction_sequence)
  target_compile_definitions(test_system_friction_warm PRIVATE
    NSDAE_SHARED_DIR="${NSDAE_SHARED_DIR}")
  if(NSDAE_DRIVERS)
    add_executable(friction_sample support/friction_sample.c)
    target_link_libraries(friction_sample PRIVATE test_friction_families)
    add_test(NAME system/friction_cli COMMAND ${CMAKE_CURRENT_SOURCE_DIR}/system/friction_cli.sh
      ${PROJECT_BINARY_DIR}/bin $<TARGET_FILE:friction_sample>)
    set_tests_properties(system/friction_cli PROPERTIES ENVIRONMENT OPENBLAS_NUM_THREADS=1
      TIMEOUT 120)
  endif()
endif()
nsdae_test(anomaly friction LINKS test_allocator)
nsdae_test(system friction_forms LINKS test_friction_families)
nsdae_test(system friction_bounded LINKS test_friction_families)
nsdae_test(system friction_families LINKS test_friction_families)
nsdae_unit_test(friction alike)
nsdae_unit_test(friction ratio_step)
nsdae_unit_test(friction socp_interior_point)
nsdae_unit_test(friction solvers)
nsdae_unit_test(friction static_condensation)
target_link_libraries(test_unit_friction_solvers PRIVATE test_friction_families)
target_link_libraries(test_unit_friction_ratio_step PRIVATE test_friction_families)
target_link_libraries(test_unit_friction_socp_interior_point PRIVATE test_friction_families)
target_link_libraries(test_unit_friction_alike PRIVATE test_friction_families)
nsdae_test(system friction_infeasible)
nsdae_test(system friction_planar)
nsdae_test(system friction_published)
target_compile_definitions(test_system_friction_published PRIVATE
  NSDAE_SHARED_DIR="${NSDAE_SHARED_DIR}")
target_compile_definitions(test_system_friction_families PRIVATE _POSIX_C_SOURCE=200809L)
