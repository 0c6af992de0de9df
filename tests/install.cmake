# What others build on: the headers, the installed tree, the packages.
set(install_dir ${CMAKE_CURRENT_SOURCE_DIR}/install)

add_test(NAME install/headers COMMAND ${install_dir}/headers.sh ${PROJECT_SOURCE_DIR}/include)

set(languages C)
if(CMAKE_CXX_COMPILER)
  list(APPEND languages CXX)
endif()
if(NSDAE_FORTRAN)
  list(APPEND languages Fortran)
endif()
add_test(NAME install/consumers
  COMMAND ${install_dir}/consumers.sh ${PROJECT_BINARY_DIR} ${PROJECT_SOURCE_DIR} ${languages})
add_test(NAME install/first_program
  COMMAND ${install_dir}/first_program.sh ${PROJECT_BINARY_DIR} ${PROJECT_SOURCE_DIR})
add_test(NAME install/subproject
  COMMAND ${install_dir}/subproject.sh ${PROJECT_SOURCE_DIR} "-DCMAKE_PREFIX_PATH=${CMAKE_PREFIX_PATH}")
add_test(NAME install/run COMMAND ${install_dir}/run.sh ${PROJECT_BINARY_DIR} ${PROJECT_SOURCE_DIR})
set_tests_properties(install/consumers install/first_program install/run install/subproject PROPERTIES
  ENVIRONMENT "OPENBLAS_NUM_THREADS=1;CMAKE_GENERATOR=${CMAKE_GENERATOR}" TIMEOUT 1800 LABELS package)
if(NSDAE_HDF5 AND NSDAE_SUNDIALS AND NOT NSDAE_SANITIZE AND NOT NSDAE_COVERAGE)
  set(stood_on ${NSDAE_LAPACKE_INCLUDE} ${NSDAE_CBLAS_INCLUDE} ${NSDAE_AMD_INCLUDE} ${HDF5_C_INCLUDE_DIRS})
  if(TARGET SUNDIALS::ida)
    get_target_property(of_sundials SUNDIALS::ida INTERFACE_INCLUDE_DIRECTORIES)
    list(APPEND stood_on ${of_sundials})
  endif()
  add_test(NAME install/systems COMMAND ${install_dir}/systems.sh ${PROJECT_SOURCE_DIR} ${PROJECT_BINARY_DIR}
    ${CMAKE_CURRENT_BINARY_DIR}/systems ${stood_on})
  set_tests_properties(install/systems PROPERTIES TIMEOUT 1800 SKIP_RETURN_CODE 77 LABELS package)
endif()
if(NSDAE_SANITIZE) # cc has no sanitizer
  set_tests_properties(install/consumers install/first_program install/run PROPERTIES DISABLED TRUE)
endif()
add_test(NAME install/exports
  COMMAND ${install_dir}/exports.sh $<TARGET_FILE:nsdae_lib_shared> ${PROJECT_SOURCE_DIR}/include)
if(NSDAE_SANITIZE) # they bring symbols of their own
  set_tests_properties(install/exports PROPERTIES DISABLED TRUE)
endif()
set_tests_properties(install/headers PROPERTIES LABELS package)
