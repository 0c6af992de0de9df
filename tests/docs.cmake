# The documentation: man pages, links, and all code in the guide.
set(docs_dir ${CMAKE_CURRENT_SOURCE_DIR}/docs)
add_test(NAME docs/man COMMAND ${docs_dir}/man.sh
  ${CMAKE_BINARY_DIR}/bin ${CMAKE_BINARY_DIR}/share/man/man1)
set_tests_properties(docs/man PROPERTIES
  ENVIRONMENT OPENBLAS_NUM_THREADS=1 TIMEOUT 300 SKIP_RETURN_CODE 77)
