# What the library stands on, each as one imported target; what is missing is named with the
# package that brings it. Each also adds the names of its libraries to NSDAE_STATIC_LIBRARIES, which
# is what a program needs that links libnsdae.a: names, not paths, so that the installed files can
# be used on another machine.
include(CheckFunctionExists)
set(NSDAE_STATIC_LIBRARIES)

# nsdae_static_library(PATH...): the names of these libraries. Of one in a folder that the linker
# does not search (Debian's hdf5/serial/libhdf5.so) that of the file it is a link to.
function(nsdae_static_library)
  foreach(path IN LISTS ARGN)
    get_filename_component(folder "${path}" DIRECTORY)
    if(NOT folder IN_LIST CMAKE_C_IMPLICIT_LINK_DIRECTORIES)
      get_filename_component(path "${path}" REALPATH)
    endif()
    if(path MATCHES "/lib([^/]+)\\.(so|a|dylib)[^/]*$")
      list(APPEND NSDAE_STATIC_LIBRARIES ${CMAKE_MATCH_1})
    endif()
  endforeach()
  set(NSDAE_STATIC_LIBRARIES ${NSDAE_STATIC_LIBRARIES} PARENT_SCOPE)
endfunction()

# A file that carries everything in it: archives are found first.
if(NSDAE_STATIC_DEPENDENCIES)
  list(PREPEND CMAKE_FIND_LIBRARY_SUFFIXES .a)
  set(nsdae_sundials_kinds static shared)
else()
  set(nsdae_sundials_kinds shared static)
endif()

# Threads, where they are not the C library's own.
find_package(Threads REQUIRED)
if(CMAKE_THREAD_LIBS_INIT)
  list(APPEND NSDAE_STATIC_LIBRARIES pthread)
endif()

# LAPACKE and CBLAS: the C faces of LAPACK and BLAS. OpenBLAS brings both, but for Debian's, whose
# LAPACKE is a library of its own, as it is where BLAS is a plain reference.
find_path(NSDAE_LAPACKE_INCLUDE lapacke.h PATH_SUFFIXES openblas lapacke)
find_path(NSDAE_CBLAS_INCLUDE cblas.h PATH_SUFFIXES openblas cblas)
find_library(NSDAE_CBLAS_LIBRARY NAMES openblas cblas)
foreach(found LAPACKE_INCLUDE CBLAS_INCLUDE CBLAS_LIBRARY)
  if(NOT NSDAE_${found})
    message(FATAL_ERROR "nsdae needs LAPACKE and OpenBLAS: install liblapacke-dev and "
                        "libopenblas-dev (./run test installs all that is missing)")
  endif()
endforeach()
set(CMAKE_REQUIRED_LIBRARIES ${NSDAE_CBLAS_LIBRARY})
check_function_exists(LAPACKE_dgetrf NSDAE_CBLAS_HAS_LAPACKE)
unset(CMAKE_REQUIRED_LIBRARIES)
set(libraries ${NSDAE_CBLAS_LIBRARY})
if(NOT NSDAE_CBLAS_HAS_LAPACKE)
  find_library(NSDAE_LAPACKE_LIBRARY lapacke)
  if(NOT NSDAE_LAPACKE_LIBRARY)
    message(FATAL_ERROR "nsdae needs LAPACKE: install liblapacke-dev "
                        "(./run test installs all that is missing)")
  endif()
  list(PREPEND libraries ${NSDAE_LAPACKE_LIBRARY})
endif()
add_library(nsdae_lapack INTERFACE)
target_include_directories(nsdae_lapack SYSTEM INTERFACE
  ${NSDAE_LAPACKE_INCLUDE} ${NSDAE_CBLAS_INCLUDE})
target_link_libraries(nsdae_lapack INTERFACE ${libraries} m)
if(NSDAE_CBLAS_LIBRARY MATCHES "openblas") # its threads are set around a call
  target_compile_definitions(nsdae_lapack INTERFACE NSDAE_OPENBLAS)
endif()
if(NSDAE_CBLAS_LIBRARY MATCHES "\\.a$") # parts of it are Fortran, and it has threads
  foreach(part gfortran quadmath)
    execute_process(COMMAND ${CMAKE_C_COMPILER} -print-file-name=lib${part}.a
                    OUTPUT_VARIABLE path OUTPUT_STRIP_TRAILING_WHITESPACE)
    if(NOT EXISTS "${path}")
      set(path ${part})
    endif()
    target_link_libraries(nsdae_lapack INTERFACE ${path})
  endforeach()
  target_link_libraries(nsdae_lapack INTERFACE Threads::Threads)
endif()

# AMD: the order that keeps sparse factors sparse. SuiteSparse 5 has no configuration
# for CMake.
find_path(NSDAE_AMD_INCLUDE amd.h PATH_SUFFIXES suitesparse)
find_library(NSDAE_AMD_LIBRARY amd)
if(NOT NSDAE_AMD_INCLUDE OR NOT NSDAE_AMD_LIBRARY)
  message(FATAL_ERROR "nsdae needs SuiteSparse's AMD: install libsuitesparse-dev "
                      "(./run test installs all that is missing)")
endif()
add_library(nsdae_amd INTERFACE)
target_include_directories(nsdae_amd SYSTEM INTERFACE ${NSDAE_AMD_INCLUDE})
target_link_libraries(nsdae_amd INTERFACE ${NSDAE_AMD_LIBRARY})
if(NSDAE_AMD_LIBRARY MATCHES "\\.a$")
  find_library(NSDAE_SUITESPARSECONFIG_LIBRARY suitesparseconfig REQUIRED)
  target_link_libraries(nsdae_amd INTERFACE ${NSDAE_SUITESPARSECONFIG_LIBRARY})
endif()
nsdae_static_library(${NSDAE_AMD_LIBRARY})

set(NSDAE_HDF5_VERSION none)
if(NSDAE_HDF5)
  set(HDF5_PREFER_PARALLEL FALSE) # the serial build: Debian's parallel one wants MPI's headers
  find_package(HDF5 COMPONENTS C HL)
  if(NOT HDF5_FOUND)
    message(FATAL_ERROR "nsdae needs HDF5 (libhdf5-dev) to write trajectories; "
                        "-DNSDAE_HDF5=OFF builds without")
  endif()
  set(NSDAE_HDF5_VERSION ${HDF5_VERSION})
  add_library(nsdae_hdf5 INTERFACE)
  target_include_directories(nsdae_hdf5 SYSTEM INTERFACE ${HDF5_C_INCLUDE_DIRS})
  target_link_libraries(nsdae_hdf5 INTERFACE ${HDF5_HL_LIBRARIES} ${HDF5_C_LIBRARIES})
  foreach(library IN LISTS HDF5_HL_LIBRARIES HDF5_C_LIBRARIES)
    if(library MATCHES "hdf5[^/]*$")
      nsdae_static_library(${library})
    endif()
  endforeach()
endif()

# SUNDIALS 6.4 to 7.x: stiff smooth phases. core exists from version 7 on.
set(NSDAE_SUNDIALS_VERSION none)
if(NSDAE_SUNDIALS)
  set(modules ida nvecserial)
  # The configuration of Debian 12's asks for OpenMP if there is no such target. The modules do not use it.
  if(NOT TARGET OpenMP::OpenMP_C)
    add_library(OpenMP::OpenMP_C INTERFACE IMPORTED)
  endif()
  find_package(SUNDIALS QUIET COMPONENTS ${modules})
  if(SUNDIALS_FOUND)
    set(NSDAE_SUNDIALS ON)
  elseif(NSDAE_SUNDIALS STREQUAL AUTO)
    message(STATUS "SUNDIALS (libsundials-dev) was not found: ida, the integrator for stiff phases, is not built")
    set(NSDAE_SUNDIALS OFF)
  else()
    message(FATAL_ERROR "nsdae needs SUNDIALS (libsundials-dev) for stiff phases; "
                        "-DNSDAE_SUNDIALS=OFF builds without. ${SUNDIALS_NOT_FOUND_MESSAGE}")
  endif()
endif()
if(NSDAE_SUNDIALS)
  set(NSDAE_SUNDIALS_VERSION ${SUNDIALS_VERSION})
  add_library(nsdae_sundials INTERFACE)
  foreach(module ${modules} core)
    foreach(kind ${nsdae_sundials_kinds})
      if(TARGET SUNDIALS::${module}_${kind})
        target_link_libraries(nsdae_sundials INTERFACE SUNDIALS::${module}_${kind})
        list(APPEND NSDAE_STATIC_LIBRARIES sundials_${module})
        get_target_property(links SUNDIALS::${module}_${kind} INTERFACE_LINK_LIBRARIES)
        if(links MATCHES "MPI::") # as Debian's version 7 does
          nsdae_static_library(${MPI_C_LIBRARIES})
        endif()
        break()
      endif()
    endforeach()
  endforeach()
endif()

# Qhull: polyhedra from points. Debian's archive cannot be part of a shared library (it is no
# position-independent code): the shared one is taken always.
if(NSDAE_QHULL)
  find_path(NSDAE_QHULL_INCLUDE libqhull_r/qhull_ra.h)
  find_library(NSDAE_QHULL_LIBRARY qhull_r)
  if(NSDAE_QHULL_INCLUDE AND NSDAE_QHULL_LIBRARY)
    add_library(nsdae_qhull INTERFACE)
    target_include_directories(nsdae_qhull SYSTEM INTERFACE ${NSDAE_QHULL_INCLUDE})
    target_link_libraries(nsdae_qhull INTERFACE ${NSDAE_QHULL_LIBRARY} m)
    nsdae_static_library(${NSDAE_QHULL_LIBRARY})
  else()
    message(STATUS "Qhull (libqhull-dev) was not found: polyhedra from points are not built")
  endif()
endif()

nsdae_static_library(${libraries})
list(APPEND NSDAE_STATIC_LIBRARIES m)
list(REMOVE_DUPLICATES NSDAE_STATIC_LIBRARIES)
