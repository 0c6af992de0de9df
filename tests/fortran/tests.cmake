# The Fortran module: twins of the tests of C.
add_test(NAME fortran/first_program
  COMMAND ${CMAKE_CURRENT_SOURCE_DIR}/fortran/first_program.sh
          ${PROJECT_BINARY_DIR} ${PROJECT_SOURCE_DIR} ${CMAKE_INSTALL_LIBDIR})
set_tests_properties(fortran/first_program PROPERTIES ENVIRONMENT OPENBLAS_NUM_THREADS=1 TIMEOUT 300
  SKIP_RETURN_CODE 77)
if(NSDAE_SANITIZE)
  set_tests_properties(fortran/first_program PROPERTIES DISABLED TRUE) # cc has no sanitizer
endif()
