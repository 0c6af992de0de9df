# Tests of the frictional contact problems.
nsdae_unit_test(friction contact)

# Seeded problems of rigid bodies.
add_library(test_friction_families OBJECT support/friction_families.c)
target_include_directories(test_friction_families PUBLIC support)
target_link_libraries(test_friction_families PUBLIC nsdae_lib_static)

if(NSDAE_HDF5)
  nsdae_unit_test(io friction_file)
  target_compile_definitions(test_unit_io_friction_file PRIVATE _POSIX_C_SOURCE=200809L)
  target_link_libraries(test_unit_io_friction_file PRIVATE nsdae_hdf5 test_friction_families)
endif()
