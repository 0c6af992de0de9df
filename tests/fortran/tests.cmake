# The Fortran module: twins of the tests of C.
add_test(NAME fortran/first_program
  COMMAND ${CMAKE_CURRENT_SOURCE_DIR}/fortran/first_program.sh
          ${PROJECT_BINARY_DIR} ${PROJECT_SOURCE_DIR} ${CMAKE_INSTALL_LIBDIR})
set_tests_properties(fortran/first_program PROPERTIES ENVIRONMENT OPENBLAS_NUM_THREADS=1 TIMEOUT 300
  SKIP_RETURN_CODE 77)
if(NSDAE_SANITIZE)
  set_tests_properties(fortran/first_program PROPERTIES DISABLED TRUE) # cc has no sanitizer
endif()

# What the tests share: checks, the bead. Callbacks do not use all of their arguments, and what must be
# equal to the last bit is compared so.
add_library(fortran_support OBJECT fortran/check.f90 fortran/bead.f90 fortran/planar.f90)
nsdae_uses_module(fortran_support)
target_compile_options(fortran_support PUBLIC
  $<$<COMPILE_LANGUAGE:Fortran>:-Wno-unused-dummy-argument>
  $<$<COMPILE_LANGUAGE:Fortran>:-Wno-compare-reals>)
target_link_libraries(fortran_support PUBLIC nsdae_module_static)
set_target_properties(fortran_support PROPERTIES
  Fortran_MODULE_DIRECTORY ${CMAKE_CURRENT_BINARY_DIR}/modules)
target_include_directories(fortran_support PUBLIC ${CMAKE_CURRENT_BINARY_DIR}/modules)

# nsdae_fortran_test(NAME [SOURCES ...] [LINKS ...] [ARGUMENTS ...]): tests/fortran/NAME.f90
function(nsdae_fortran_test name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LINKS;ARGUMENTS" ${ARGN})
  list(TRANSFORM ARG_SOURCES PREPEND fortran/)
  add_executable(test_fortran_${name} fortran/${name}.f90 ${ARG_SOURCES})
  nsdae_uses_module(test_fortran_${name} ${PROJECT_SOURCE_DIR}/drivers/fortran/pendulum_model.f90)
  target_link_libraries(test_fortran_${name} PRIVATE fortran_support ${ARG_LINKS})
  set_target_properties(test_fortran_${name} PROPERTIES LINKER_LANGUAGE Fortran
    RUNTIME_OUTPUT_DIRECTORY ${CMAKE_CURRENT_BINARY_DIR}
    Fortran_MODULE_DIRECTORY ${CMAKE_CURRENT_BINARY_DIR}/modules/${name})
  add_test(NAME fortran/${name} COMMAND ${own_folder} $<TARGET_FILE:test_fortran_${name}> ${ARG_ARGUMENTS})
  set_tests_properties(fortran/${name} PROPERTIES ENVIRONMENT OPENBLAS_NUM_THREADS=1 TIMEOUT 300)
endfunction()

nsdae_fortran_test(layout SOURCES layout.c)
nsdae_fortran_test(bodies ARGUMENTS ${PROJECT_SOURCE_DIR}/data)
add_test(NAME fortran/complete
  COMMAND ${CMAKE_CURRENT_SOURCE_DIR}/fortran/complete.sh
          ${PROJECT_SOURCE_DIR}/include ${PROJECT_BINARY_DIR}/modules ${CMAKE_Fortran_COMPILER}
          ${PROJECT_SOURCE_DIR})
nsdae_fortran_test(between)
nsdae_fortran_test(blocks)
nsdae_fortran_test(callbacks)
nsdae_fortran_test(certificate)
nsdae_fortran_test(kinematics)
nsdae_fortran_test(kernels)
nsdae_fortran_test(description)
nsdae_fortran_test(derivatives)
nsdae_fortran_test(arguments)
nsdae_fortran_test(friction)
nsdae_fortran_test(friction_file)
nsdae_fortran_test(lcp)
nsdae_fortran_test(parameters)
nsdae_fortran_test(state)
nsdae_fortran_test(memory LINKS test_allocator)
if(NSDAE_HDF5)
  nsdae_fortran_test(trajectory)
endif()

if(NSDAE_DRIVERS)
  nsdae_fortran_test(pendulum LINKS nsdae_driver_fortran ARGUMENTS ${PROJECT_SOURCE_DIR}/data)
  add_test(NAME fortran/twin COMMAND ${CMAKE_CURRENT_SOURCE_DIR}/fortran/twin.sh
    ${PROJECT_BINARY_DIR}/bin ${PROJECT_SOURCE_DIR}/data ${NSDAE_HDF5})
  set_tests_properties(fortran/twin PROPERTIES ENVIRONMENT OPENBLAS_NUM_THREADS=1 TIMEOUT 300)
endif()
