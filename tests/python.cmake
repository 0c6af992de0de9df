# The package for Python, built as pip builds it: what it needs comes from the package index.
if(NSDAE_DRIVERS AND NSDAE_HDF5 AND NSDAE_SUNDIALS AND NOT NSDAE_SANITIZE AND NOT NSDAE_COVERAGE)
  add_test(NAME python/package COMMAND ${CMAKE_CURRENT_SOURCE_DIR}/python/package.sh
    ${PROJECT_SOURCE_DIR} ${PROJECT_BINARY_DIR}/bin ${CMAKE_CURRENT_BINARY_DIR}/python/wheel)
  set_tests_properties(python/package PROPERTIES
    ENVIRONMENT OPENBLAS_NUM_THREADS=1 TIMEOUT 3600 SKIP_RETURN_CODE 77 LABELS package)
endif()
