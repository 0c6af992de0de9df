# What others build on: the headers, the installed tree, the packages.
set(install_dir ${CMAKE_CURRENT_SOURCE_DIR}/install)

add_test(NAME install/headers COMMAND ${install_dir}/headers.sh ${PROJECT_SOURCE_DIR}/include)

add_test(NAME install/first_program
  COMMAND ${install_dir}/first_program.sh ${PROJECT_BINARY_DIR} ${PROJECT_SOURCE_DIR})
if(NSDAE_SANITIZE)
  set_tests_properties(install/first_program PROPERTIES DISABLED TRUE) # cc has no sanitizer
endif()
