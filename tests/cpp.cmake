# nsdae.hpp: run as the oldest C++ that it promises; a recent one reads the same source.
if(NOT CMAKE_CXX_COMPILER)
  message(STATUS "no C++ compiler: nsdae.hpp is not tested")
  return()
endif()
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
find_package(Threads REQUIRED)

add_executable(test_cpp11 cpp/handles.cpp cpp/cpp_pendulum.c)
set_target_properties(test_cpp11 PROPERTIES CXX_STANDARD 11 RUNTIME_OUTPUT_DIRECTORY ${CMAKE_CURRENT_BINARY_DIR})
target_compile_definitions(test_cpp11 PRIVATE NSDAE_DATA_DIR="${PROJECT_SOURCE_DIR}/data")
target_link_libraries(test_cpp11 PRIVATE nsdae_lib_shared Threads::Threads m)
add_test(NAME cpp/handles-c++11 COMMAND ${own_folder} $<TARGET_FILE:test_cpp11>)
# nothing in nsdae.hpp depends on the standard: other instructions are not expected, other errors of the compiler are
add_test(NAME cpp/handles-c++20 COMMAND ${CMAKE_CXX_COMPILER} -std=c++20 -fsyntax-only -I${PROJECT_SOURCE_DIR}/include
  -DNSDAE_DATA_DIR="" ${CMAKE_CURRENT_SOURCE_DIR}/cpp/handles.cpp)

add_executable(test_anomaly_jumps anomaly/jumps.cpp)
set_target_properties(test_anomaly_jumps PROPERTIES CXX_STANDARD 11 RUNTIME_OUTPUT_DIRECTORY ${CMAKE_CURRENT_BINARY_DIR})
target_link_libraries(test_anomaly_jumps PRIVATE nsdae_lib_shared)
add_test(NAME anomaly/jumps COMMAND ${own_folder} $<TARGET_FILE:test_anomaly_jumps>)
set_tests_properties(cpp/handles-c++11 cpp/handles-c++20 anomaly/jumps PROPERTIES ENVIRONMENT OPENBLAS_NUM_THREADS=1 TIMEOUT 300)
