# The installed tree: libraries, headers, the CMake package nsdae and the pkg-config modules nsdae
# and nsdae-static. No file in it names a folder of this machine: the tree can be moved.
include(CMakePackageConfigHelpers)
set(NSDAE_INSTALL_CMAKEDIR ${CMAKE_INSTALL_LIBDIR}/cmake/nsdae)

# One export per library, so that a package may leave one out (the static one, Fortran).
function(nsdae_install_library name export)
  if(NOT TARGET ${name})
    return()
  endif()
  get_target_property(target ${name} ALIASED_TARGET)
  install(TARGETS ${target} EXPORT ${export}
    ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
  install(EXPORT ${export} NAMESPACE nsdae:: DESTINATION ${NSDAE_INSTALL_CMAKEDIR})
endfunction()

foreach(kind shared static)
  nsdae_install_library(nsdae::${kind} nsdae-${kind})
  nsdae_install_library(nsdae::fortran_${kind} nsdae-fortran-${kind})
endforeach()
install(DIRECTORY ${PROJECT_SOURCE_DIR}/include/nsdae DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})

configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/nsdaeConfig.cmake.in
  ${PROJECT_BINARY_DIR}/nsdaeConfig.cmake
  INSTALL_DESTINATION ${NSDAE_INSTALL_CMAKEDIR} PATH_VARS CMAKE_INSTALL_LIBDIR)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/nsdaeConfigVersion.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/nsdaeConfig.cmake ${PROJECT_BINARY_DIR}/nsdaeConfigVersion.cmake
  DESTINATION ${NSDAE_INSTALL_CMAKEDIR})

list(TRANSFORM NSDAE_STATIC_LIBRARIES PREPEND "-l" OUTPUT_VARIABLE NSDAE_PC_LIBS)
list(JOIN NSDAE_PC_LIBS " " NSDAE_PC_LIBS)
file(RELATIVE_PATH NSDAE_PC_TO_PREFIX /${CMAKE_INSTALL_LIBDIR}/pkgconfig /)
string(REGEX REPLACE "/$" "" NSDAE_PC_TO_PREFIX "${NSDAE_PC_TO_PREFIX}")
foreach(module nsdae nsdae-static)
  configure_file(${CMAKE_CURRENT_LIST_DIR}/${module}.pc.in ${PROJECT_BINARY_DIR}/${module}.pc @ONLY)
  install(FILES ${PROJECT_BINARY_DIR}/${module}.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
endforeach()
