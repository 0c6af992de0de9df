# The documentation: man pages, reference, links, and all code in the guide.
function(nsdae_docs_test name)
  add_test(NAME docs/${name} COMMAND ${CMAKE_CURRENT_SOURCE_DIR}/docs/${name}.sh ${ARGN})
  set_tests_properties(docs/${name} PROPERTIES
    ENVIRONMENT "OPENBLAS_NUM_THREADS=1;CMAKE_GENERATOR=${CMAKE_GENERATOR}" TIMEOUT 300 SKIP_RETURN_CODE 77)
endfunction()

nsdae_docs_test(links ${PROJECT_SOURCE_DIR})
find_package(Python3 COMPONENTS Interpreter)
if(Python3_FOUND)
  foreach(name prose reference)
    add_test(NAME docs/${name} COMMAND ${Python3_EXECUTABLE} -B ${CMAKE_CURRENT_SOURCE_DIR}/docs/${name}.py ${PROJECT_SOURCE_DIR})
    set_tests_properties(docs/${name} PROPERTIES SKIP_RETURN_CODE 77)
  endforeach()
  if(NSDAE_DRIVERS AND NSDAE_HDF5 AND NSDAE_SUNDIALS AND NOT NSDAE_SANITIZE AND NOT NSDAE_COVERAGE)
    # after the package's test, whose wheel it takes
    add_test(NAME docs/site COMMAND ${Python3_EXECUTABLE} -B ${CMAKE_CURRENT_SOURCE_DIR}/docs/site.py ${PROJECT_SOURCE_DIR}
      ${PROJECT_BINARY_DIR})
    set_tests_properties(docs/site PROPERTIES ENVIRONMENT "OPENBLAS_NUM_THREADS=1" TIMEOUT 3600 SKIP_RETURN_CODE 77
      DEPENDS python/package LABELS package)
  endif()
endif()
if(NSDAE_DRIVERS)
  nsdae_docs_test(man ${PROJECT_BINARY_DIR}/bin ${PROJECT_BINARY_DIR}/share/man/man1)
  set_tests_properties(docs/man PROPERTIES TIMEOUT 1800 LABELS package) # it runs the examples of each page
endif()
if(NSDAE_DRIVERS AND NSDAE_HDF5 AND NSDAE_SUNDIALS AND NOT NSDAE_SANITIZE) # cc has no sanitizer
  nsdae_docs_test(guide ${PROJECT_BINARY_DIR} ${PROJECT_SOURCE_DIR})
  set_tests_properties(docs/guide PROPERTIES TIMEOUT 1800 LABELS package)
endif()
