# Benchmarks: built and run by the target bench (./run bench) alone. Those that have a peer
# add what they measured to build/bench.json (bench/ratio.h); an empty list where none was found.
set(bench_json ${PROJECT_BINARY_DIR}/bench.json)
file(WRITE ${CMAKE_CURRENT_BINARY_DIR}/bench_none.json "[\n]\n")
set(bench_programs)
set(bench_commands COMMAND ${CMAKE_COMMAND} -E copy ${CMAKE_CURRENT_BINARY_DIR}/bench_none.json ${bench_json})

# nsdae_bench(NAME SOURCES file... ARGUMENTS word... LINKS library...): a program that the target bench runs
function(nsdae_bench name)
  cmake_parse_arguments(ARG "" "" "SOURCES;ARGUMENTS;LINKS" ${ARGN})
  add_executable(bench_${name} EXCLUDE_FROM_ALL bench/${name}.c bench/ratio.c ${ARG_SOURCES})
  target_compile_options(bench_${name} PRIVATE $<$<CONFIG:Release>:-O3>)
  target_link_libraries(bench_${name} PRIVATE nsdae_lib_static ${ARG_LINKS} m)
  set(bench_commands ${bench_commands} COMMAND ${CMAKE_COMMAND} -E env OPENBLAS_NUM_THREADS=1
    NSDAE_BENCH_JSON=${bench_json} $<TARGET_FILE:bench_${name}> ${ARG_ARGUMENTS} PARENT_SCOPE)
  set(bench_programs ${bench_programs} bench_${name} PARENT_SCOPE)
endfunction()

# Siconos, the peer to be timed beside, where it is found (libsiconos-numerics-dev).
find_path(SICONOS_INCLUDE_DIR LCP_Solvers.h PATH_SUFFIXES siconos/numerics)
find_library(SICONOS_NUMERICS siconos_numerics)
if(SICONOS_INCLUDE_DIR AND SICONOS_NUMERICS)
  add_library(bench_rival OBJECT EXCLUDE_FROM_ALL bench/lcp_siconos.c)
  target_include_directories(bench_rival SYSTEM PRIVATE ${SICONOS_INCLUDE_DIR} ${SICONOS_INCLUDE_DIR}/..)
  target_link_libraries(bench_rival PUBLIC ${SICONOS_NUMERICS})
else()
  add_library(bench_rival OBJECT EXCLUDE_FROM_ALL bench/lcp_alone.c)
endif()

nsdae_bench(lcp SOURCES bench/bench_lcp_families.c LINKS bench_rival)

# Problems of others are no part of the benchmarks; they are solved too if this folder has them.
set(NSDAE_BENCH_PROBLEMS "" CACHE PATH
    "Folder with friction/*.hdf5 in the layout of FCLIB, and consecutive steps in friction/steps/step00.hdf5 and so on")
set(piles)
set(steps_of_pile)
if(NSDAE_BENCH_PROBLEMS)
  set(piles ${NSDAE_BENCH_PROBLEMS}/friction)
  set(steps_of_pile ${NSDAE_BENCH_PROBLEMS}/friction/steps)
endif()

# Frictional contact: problems of a folder, and generated ones.
if(NSDAE_HDF5)
  if(SICONOS_INCLUDE_DIR AND SICONOS_NUMERICS)
    add_library(bench_friction_rival OBJECT EXCLUDE_FROM_ALL bench/friction_siconos.c)
    target_include_directories(bench_friction_rival SYSTEM PRIVATE
      ${SICONOS_INCLUDE_DIR} ${SICONOS_INCLUDE_DIR}/..)
    target_link_libraries(bench_friction_rival PUBLIC ${SICONOS_NUMERICS})
    target_include_directories(bench_friction_rival PRIVATE ${PROJECT_SOURCE_DIR}/include)
  else()
    add_library(bench_friction_rival OBJECT EXCLUDE_FROM_ALL bench/friction_alone.c)
    target_include_directories(bench_friction_rival PRIVATE ${PROJECT_SOURCE_DIR}/include)
  endif()
  nsdae_bench(friction ARGUMENTS ${piles} LINKS test_friction_families bench_friction_rival)
  target_compile_definitions(bench_friction PRIVATE _DEFAULT_SOURCE _POSIX_C_SOURCE=200809L)
  nsdae_bench(warm SOURCES bench/friction_sequence.c ARGUMENTS ${steps_of_pile} LINKS test_friction_families nsdae_hdf5)
endif()

# Sparse constraints of chains, trees, nets and ladders.
nsdae_bench(chains SOURCES support/stiff_chain.c)
target_include_directories(bench_chains PRIVATE ${CMAKE_CURRENT_SOURCE_DIR}
  $<TARGET_PROPERTY:nsdae_linalg,INTERFACE_INCLUDE_DIRECTORIES>)
target_compile_definitions(bench_chains PRIVATE _POSIX_C_SOURCE=200809L)

# Whole steps beside Siconos (libsiconos-kernel-dev) and MuJoCo 3.2 or later: the Python package that
# python3 finds, or the one in a folder of one's own.
set(steps_peers)
find_path(SICONOS_KERNEL_INCLUDE_DIR SiconosKernel.hpp PATH_SUFFIXES siconos/kernel)
find_library(SICONOS_KERNEL siconos_kernel)
if(SICONOS_KERNEL_INCLUDE_DIR AND SICONOS_KERNEL AND SICONOS_NUMERICS AND CMAKE_CXX_COMPILER)
  foreach(peer steps disks)
    add_library(bench_${peer}_siconos OBJECT EXCLUDE_FROM_ALL bench/${peer}_siconos.cpp)
    target_include_directories(bench_${peer}_siconos SYSTEM PRIVATE
      ${SICONOS_KERNEL_INCLUDE_DIR} ${SICONOS_KERNEL_INCLUDE_DIR}/.. ${SICONOS_INCLUDE_DIR})
    target_compile_features(bench_${peer}_siconos PRIVATE cxx_std_17)
    target_link_libraries(bench_${peer}_siconos PUBLIC ${SICONOS_KERNEL} ${SICONOS_NUMERICS})
  endforeach()
  list(APPEND steps_peers bench_steps_siconos)
  set(disks_peer LINKS bench_disks_siconos)
else()
  list(APPEND steps_sources bench/steps_no_siconos.c)
  set(disks_peer SOURCES bench/disks_no_siconos.c)
endif()
set(MUJOCO_ROOT "" CACHE PATH "Folder of MuJoCo's Python package: include/ and libmujoco.so.*")
if(NOT MUJOCO_ROOT)
  execute_process(COMMAND python3 -c "import importlib.util as u; print(u.find_spec('mujoco').submodule_search_locations[0])"
    OUTPUT_VARIABLE mujoco_root OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
endif()
file(GLOB mujoco_library ${MUJOCO_ROOT}${mujoco_root}/libmujoco.so.*)
find_path(MUJOCO_INCLUDE_DIR mujoco/mujoco.h HINTS ${MUJOCO_ROOT}${mujoco_root}/include)
if(MUJOCO_INCLUDE_DIR AND mujoco_library)
  include(CheckSymbolExists)
  set(CMAKE_REQUIRED_INCLUDES ${MUJOCO_INCLUDE_DIR})
  set(CMAKE_REQUIRED_LIBRARIES ${mujoco_library})
  check_symbol_exists(mj_addBufferVFS mujoco/mujoco.h NSDAE_HAS_MUJOCO)
  unset(CMAKE_REQUIRED_INCLUDES)
  unset(CMAKE_REQUIRED_LIBRARIES)
endif()
if(NSDAE_HAS_MUJOCO)
  add_library(bench_steps_mujoco OBJECT EXCLUDE_FROM_ALL bench/steps_mujoco.c)
  add_library(bench_heaps_mujoco OBJECT EXCLUDE_FROM_ALL bench/heaps_mujoco.c)
  add_library(bench_scenes_mujoco OBJECT EXCLUDE_FROM_ALL bench/scenes_mujoco.c)
  add_library(bench_walkers_mujoco OBJECT EXCLUDE_FROM_ALL bench/walkers_mujoco.c)
  target_include_directories(bench_scenes_mujoco PRIVATE ${PROJECT_SOURCE_DIR}/include)
  foreach(peer bench_steps_mujoco bench_heaps_mujoco bench_scenes_mujoco bench_walkers_mujoco)
    target_include_directories(${peer} SYSTEM PRIVATE ${MUJOCO_INCLUDE_DIR})
    target_compile_definitions(${peer} PRIVATE _POSIX_C_SOURCE=200809L)
    target_link_libraries(${peer} PUBLIC ${mujoco_library})
  endforeach()
  list(APPEND steps_peers bench_steps_mujoco)
  set(heaps_peer LINKS bench_heaps_mujoco)
  set(scenes_peer LINKS bench_scenes_mujoco)
  set(walkers_peer LINKS bench_walkers_mujoco)
else()
  list(APPEND steps_sources bench/steps_no_mujoco.c)
  set(heaps_peer SOURCES bench/heaps_no_mujoco.c)
  set(scenes_peer SOURCES bench/scenes_no_mujoco.c)
  set(walkers_peer SOURCES bench/walkers_no_mujoco.c)
endif()
nsdae_bench(steps SOURCES ${steps_sources} LINKS ${steps_peers})
nsdae_bench(heaps ${heaps_peer})
nsdae_bench(disks ${disks_peer})
nsdae_bench(scenes ${scenes_peer})
nsdae_bench(walkers ${walkers_peer})
find_package(Threads REQUIRED)
target_link_libraries(bench_walkers PRIVATE Threads::Threads)
target_compile_definitions(bench_walkers PRIVATE _POSIX_C_SOURCE=200809L)
target_include_directories(bench_scenes PRIVATE support)
target_compile_definitions(bench_scenes PRIVATE _POSIX_C_SOURCE=200809L)
target_compile_definitions(bench_heaps PRIVATE _DEFAULT_SOURCE _POSIX_C_SOURCE=200809L)

# A heap written with the kit of bodies beside the same by hand.
nsdae_bench(kit)
target_compile_definitions(bench_kit PRIVATE _POSIX_C_SOURCE=200809L)

# Contacts of boxes beside libccd and ODE's collision part, where both are (libccd-dev, libode-dev).
find_path(CCD_INCLUDE_DIR ccd/ccd.h)
find_library(CCD_LIBRARY ccd)
find_path(ODE_INCLUDE_DIR ode/ode.h)
find_library(ODE_LIBRARY ode)
if(CCD_INCLUDE_DIR AND CCD_LIBRARY AND ODE_INCLUDE_DIR AND ODE_LIBRARY)
  nsdae_bench(shapes LINKS ${CCD_LIBRARY} ${ODE_LIBRARY})
  target_include_directories(bench_shapes SYSTEM PRIVATE ${CCD_INCLUDE_DIR} ${ODE_INCLUDE_DIR})
  target_include_directories(bench_shapes PRIVATE ${PROJECT_SOURCE_DIR}/lib/bodies ${PROJECT_SOURCE_DIR}/lib/base)
  target_compile_definitions(bench_shapes PRIVATE _POSIX_C_SOURCE=200809L)
endif()

if(NSDAE_DRIVERS)
  # a step of a few bodies beside that of another build, in instructions: bench/cost.sh, by hand
  add_executable(bench_cost EXCLUDE_FROM_ALL bench/cost.c)
  target_link_libraries(bench_cost PRIVATE nsdae_driver_common)
  # 667 planar contacts of a granular flow on a wall, a problem of the Siconos project
  nsdae_bench(lcp_file ARGUMENTS ${CMAKE_CURRENT_SOURCE_DIR}/data/lcp/fc2d_granularflowonwall_00667_00000.dat
    LINKS nsdae_driver_common bench_rival)
  nsdae_bench(orders LINKS nsdae_driver_common)
  # the wall, the arch and the dominoes beside the same by hand
  nsdae_bench(blocks LINKS nsdae_driver_common)
  # the mechanisms of the Test Set for IVP Solvers
  nsdae_bench(dae LINKS nsdae_driver_common)
  target_compile_definitions(bench_dae PRIVATE _POSIX_C_SOURCE=200809L)
  # hashes of steps, to compare two builds: bench/bytes.sh, by hand
  add_executable(bench_bytes EXCLUDE_FROM_ALL bench/bytes.c support/disks.c support/random_system.c support/twin.c)
  target_include_directories(bench_bytes PRIVATE support)
  target_link_libraries(bench_bytes PRIVATE nsdae_driver_common)
  # the event-driven method by each integrator: bench/phases.py, by hand
  add_executable(bench_phases EXCLUDE_FROM_ALL bench/phases.c bench/ratio.c)
  target_link_libraries(bench_phases PRIVATE nsdae_driver_common)
  if(NSDAE_SUNDIALS AND GSL_FOUND)
    nsdae_bench(precision LINKS nsdae_driver_common GSL::gsl GSL::gslcblas)
  endif()
endif()
add_custom_target(bench ${bench_commands}
  COMMAND ${CMAKE_COMMAND} -E echo "ratios to peers, for programs to read: ${bench_json}" USES_TERMINAL)
add_dependencies(bench ${bench_programs})
