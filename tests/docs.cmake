# The documentation: man pages, reference, links, and all code in the guide.
set(docs_dir ${CMAKE_CURRENT_SOURCE_DIR}/docs)
add_test(NAME docs/man COMMAND ${docs_dir}/man.sh
  ${CMAKE_BINARY_DIR}/bin ${CMAKE_BINARY_DIR}/share/man/man1)
add_test(NAME docs/reference COMMAND ${docs_dir}/reference.sh
  ${PROJECT_SOURCE_DIR} ${CMAKE_BINARY_DIR}/docs/Doxyfile)
set_tests_properties(docs/man docs/reference PROPERTIES
  ENVIRONMENT OPENBLAS_NUM_THREADS=1 TIMEOUT 300 SKIP_RETURN_CODE 77)
