# The documentation: man pages, reference, links, and all code in the guide.
function(nsdae_docs_test name)
  add_test(NAME docs/${name} COMMAND ${CMAKE_CURRENT_SOURCE_DIR}/docs/${name}.sh ${ARGN})
  set_tests_properties(docs/${name} PROPERTIES
    ENVIRONMENT "OPENBLAS_NUM_THREADS=1;CMAKE_GENERATOR=${CMAKE_GENERATOR}" TIMEOUT 300 SKIP_RETURN_CODE 77)
endfunction()

nsdae_docs_test(links ${PROJECT_SOURCE_DIR})
find_package(Python3 COMPONENTS Interpreter)
if(Python3_FOUND)
  add_test(NAME docs/prose COMMAND ${Python3_EXECUTABLE} ${CMAKE_CURRENT_SOURCE_DIR}/docs/prose.py ${PROJECT_SOURCE_DIR})
endif()
nsdae_docs_test(reference ${PROJECT_SOURCE_DIR} ${CMAKE_BINARY_DIR}/docs/Doxyfile)
if(NSDAE_DRIVERS)
  nsdae_docs_test(man ${CMAKE_BINARY_DIR}/bin ${CMAKE_BINARY_DIR}/share/man/man1)
endif()
if(NSDAE_DRIVERS AND NSDAE_HDF5 AND NSDAE_SUNDIALS AND NOT NSDAE_SANITIZE) # cc has no sanitizer
  nsdae_docs_test(guide ${PROJECT_BINARY_DIR} ${PROJECT_SOURCE_DIR})
endif()
