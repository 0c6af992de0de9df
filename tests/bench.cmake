# Benchmarks: built with the rest, run by the target bench (./run bench) alone.
set(bench_commands)

# nsdae_bench(NAME SOURCES file... ARGUMENTS word... LINKS library...): a program that the target bench runs
function(nsdae_bench name)
  cmake_parse_arguments(ARG "" "" "SOURCES;ARGUMENTS;LINKS" ${ARGN})
  add_executable(bench_${name} bench/${name}.c ${ARG_SOURCES})
  target_link_libraries(bench_${name} PRIVATE nsdae_lib_static ${ARG_LINKS} m)
  set(bench_commands ${bench_commands} COMMAND bench_${name} ${ARG_ARGUMENTS} PARENT_SCOPE)
endfunction()

# Siconos, the peer to be timed beside, where it is found (libsiconos-numerics-dev).
find_path(SICONOS_INCLUDE_DIR LCP_Solvers.h PATH_SUFFIXES siconos/numerics)
find_library(SICONOS_NUMERICS siconos_numerics)
if(SICONOS_INCLUDE_DIR AND SICONOS_NUMERICS)
  add_library(bench_rival OBJECT bench/lcp_siconos.c)
  target_include_directories(bench_rival SYSTEM PRIVATE ${SICONOS_INCLUDE_DIR} ${SICONOS_INCLUDE_DIR}/..)
  target_link_libraries(bench_rival PUBLIC ${SICONOS_NUMERICS})
else()
  add_library(bench_rival OBJECT bench/lcp_alone.c)
endif()

nsdae_bench(lcp SOURCES bench/lcp_families.c LINKS bench_rival)
if(NSDAE_DRIVERS)
  # 667 planar contacts of a granular flow on a wall, a problem of the Siconos project
  set(granular ${NSDAE_SHARED_DIR}/lcp_problems/fc2d_granularflowonwall_00667_00000.dat)
  if(NOT EXISTS ${granular})
    set(granular)
  endif()
  nsdae_bench(lcp_file ARGUMENTS ${granular} LINKS driver_common bench_rival)
  nsdae_bench(orders LINKS driver_common)
  if(NSDAE_SUNDIALS)
    nsdae_bench(precision LINKS driver_common)
  endif()
endif()
add_custom_target(bench ${bench_commands} USES_TERMINAL)
