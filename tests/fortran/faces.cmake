# The faces of the kernels, from Fortran 77 where there is a compiler for it.
include(CheckLanguage)
check_language(Fortran)
if(CMAKE_Fortran_COMPILER AND NOT NSDAE_SANITIZE) # Fortran's main starts without the sanitizer's runtime first
  enable_language(Fortran)
  add_executable(test_fortran_kernels77 fortran/kernels77.f)
  set_target_properties(test_fortran_kernels77 PROPERTIES
    COMPILE_OPTIONS "" LINKER_LANGUAGE Fortran # the options of the project are for C
    RUNTIME_OUTPUT_DIRECTORY ${CMAKE_CURRENT_BINARY_DIR})
  target_link_libraries(test_fortran_kernels77 PRIVATE nsdae_lib_shared)
  add_test(NAME fortran/kernels77 COMMAND test_fortran_kernels77)
  set_tests_properties(fortran/kernels77 PROPERTIES ENVIRONMENT OPENBLAS_NUM_THREADS=1 TIMEOUT 300)
endif()
