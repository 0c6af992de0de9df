# The mistakes of docs/guide/mistakes.md, in each language.
function(nsdae_mistakes_test language source)
  add_executable(test_mistakes_${language} mistakes/${source})
  set_target_properties(test_mistakes_${language} PROPERTIES
    RUNTIME_OUTPUT_DIRECTORY ${CMAKE_CURRENT_BINARY_DIR}/mistakes
    Fortran_MODULE_DIRECTORY ${CMAKE_CURRENT_BINARY_DIR}/modules/mistakes)
  add_test(NAME mistakes/${language} COMMAND ${CMAKE_CURRENT_SOURCE_DIR}/mistakes/mistakes.sh
    ${PROJECT_SOURCE_DIR}/docs/guide/mistakes.md $<TARGET_FILE:test_mistakes_${language}> ${ARGN})
  set_tests_properties(mistakes/${language} PROPERTIES ENVIRONMENT OPENBLAS_NUM_THREADS=1 TIMEOUT 300)
endfunction()

nsdae_mistakes_test(c mistakes.c)
target_link_libraries(test_mistakes_c PRIVATE nsdae_lib_static m)
if(CMAKE_CXX_COMPILER)
  nsdae_mistakes_test(cpp mistakes.cpp AT_ONCE)
  target_link_libraries(test_mistakes_cpp PRIVATE nsdae_lib_shared m)
  set_target_properties(test_mistakes_cpp PROPERTIES CXX_STANDARD 11)
endif()
if(NSDAE_FORTRAN)
  nsdae_mistakes_test(fortran mistakes.f90)
  nsdae_uses_module(test_mistakes_fortran)
  target_link_libraries(test_mistakes_fortran PRIVATE nsdae_module_static)
  target_compile_options(test_mistakes_fortran PRIVATE -Wno-unused-dummy-argument)
  set_target_properties(test_mistakes_fortran PROPERTIES LINKER_LANGUAGE Fortran)
endif()

# Those of its first table, with the kit.
function(nsdae_kit_mistakes_test language)
  add_test(NAME mistakes/kit_${language} COMMAND ${CMAKE_CURRENT_SOURCE_DIR}/mistakes/kit.sh
    ${PROJECT_SOURCE_DIR}/docs/guide/mistakes.md ${ARGN})
  set_tests_properties(mistakes/kit_${language} PROPERTIES ENVIRONMENT OPENBLAS_NUM_THREADS=1 TIMEOUT 300)
endfunction()

add_executable(test_mistakes_kit_c mistakes/kit.c)
target_link_libraries(test_mistakes_kit_c PRIVATE nsdae_lib_static m)
nsdae_kit_mistakes_test(c $<TARGET_FILE:test_mistakes_kit_c>)
