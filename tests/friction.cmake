# Tests of the frictional contact problems.
foreach(name contact map)
  nsdae_unit_test(friction ${name})
endforeach()
