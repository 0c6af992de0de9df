# Tests of the frictional contact problems.
nsdae_unit_test(friction contact)
