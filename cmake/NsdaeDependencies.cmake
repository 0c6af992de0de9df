# What the library stands on, each as one imported target; what is missing is named with the
# package that brings it.
find_package(PkgConfig REQUIRED)

function(nsdae_pkg target module package)
  pkg_check_modules(${target} QUIET IMPORTED_TARGET ${module})
  if(NOT ${target}_FOUND)
    message(FATAL_ERROR "nsdae needs ${module}: install ${package} "
                        "(./run test installs all that is missing)")
  endif()
endfunction()

# LAPACKE and CBLAS: the C faces of LAPACK and BLAS. OpenBLAS brings both; where it is a plain
# reference LAPACK, liblapacke and libcblas do.
nsdae_pkg(NSDAE_LAPACKE lapacke liblapacke-dev)
nsdae_pkg(NSDAE_BLAS openblas libopenblas-dev)
add_library(nsdae_lapack INTERFACE)
target_link_libraries(nsdae_lapack INTERFACE PkgConfig::NSDAE_LAPACKE PkgConfig::NSDAE_BLAS m)

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
endif()

# SUNDIALS 6.4 to 7.x: stiff smooth phases.
set(NSDAE_SUNDIALS_VERSION none)
if(NSDAE_SUNDIALS)
  find_package(SUNDIALS QUIET COMPONENTS cvode ida nvecserial sunmatrixdense sunmatrixsparse
               sunlinsoldense sunlinsolklu)
  if(NOT SUNDIALS_FOUND)
    message(FATAL_ERROR "nsdae needs SUNDIALS (libsundials-dev) for penalty and event; "
                        "-DNSDAE_SUNDIALS=OFF builds without")
  endif()
  set(NSDAE_SUNDIALS_VERSION ${SUNDIALS_VERSION})
  add_library(nsdae_sundials INTERFACE)
  target_link_libraries(nsdae_sundials INTERFACE
    SUNDIALS::cvode_shared SUNDIALS::ida_shared SUNDIALS::nvecserial_shared
    SUNDIALS::sunmatrixdense_shared SUNDIALS::sunmatrixsparse_shared
    SUNDIALS::sunlinsoldense_shared SUNDIALS::sunlinsolklu_shared)
  if(TARGET SUNDIALS::core_shared) # from version 7 on
    target_link_libraries(nsdae_sundials INTERFACE SUNDIALS::core_shared)
  endif()
endif()
