# Tests of the frictional contact problems.
foreach(name contact map)
  nsdae_unit_test(friction ${name})
endforeach()
nsdae_test(anomaly friction LINKS test_allocator)
nsdae_test(system friction_families)
target_sources(test_system_friction_families PRIVATE support/friction_families.c)
target_include_directories(test_system_friction_families PRIVATE support)
