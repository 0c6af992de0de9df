# The full forms of the families that the suite has in short ones, of minutes to hours: ./run families, which is
# ctest -C Families -R ^families/.
function(nsdae_family test)
  string(REPLACE "/" "_" target test_${test})
  if(TARGET ${target})
    add_test(NAME families/${test} CONFIGURATIONS Families COMMAND ${own_folder} $<TARGET_FILE:${target}>)
    set_tests_properties(families/${test} PROPERTIES ENVIRONMENT "OPENBLAS_NUM_THREADS=1;NSDAE_TEST_SHARE=1;${ARGN}" TIMEOUT 28800)
  endif()
endfunction()

foreach(test IN ITEMS anomaly/file_memory anomaly/hdf5 anomaly/disk unit/bodies/continuity unit/bodies/controls
    unit/bodies/derivatives unit/bodies/distance unit/bodies/limited unit/bodies/limits unit/bodies/meshes unit/bodies/motors
    unit/bodies/pins unit/bodies/polyhedra unit/bodies/position_motors system/lcp_families system/projection system/seams system/slop
    system/structures)
  nsdae_family(${test} NSDAE_LONG=1)
endforeach()
nsdae_family(anomaly/corrupt NSDAE_LONG=100000) # files of each program
nsdae_family(anomaly/mesh_files NSDAE_LONG=1000000) # damaged files of each format
nsdae_family(system/long_runs NSDAE_LONG=1000000) # steps
nsdae_family(conformance/failing NSDAE_EVERY_CALL=1)
if(NSDAE_DRIVERS AND NSDAE_HDF5)
  add_test(NAME families/system/restart CONFIGURATIONS Families COMMAND ${CMAKE_CURRENT_SOURCE_DIR}/system/restart.sh
    ${PROJECT_BINARY_DIR}/bin ${PROJECT_SOURCE_DIR}/data 20) # kills of each run
  set_tests_properties(families/system/restart PROPERTIES ENVIRONMENT OPENBLAS_NUM_THREADS=1 TIMEOUT 28800)
endif()
