# nsdae.hpp, as the oldest C++ that it promises and a recent one.
if(NOT CMAKE_CXX_COMPILER)
  message(STATUS "no C++ compiler: nsdae.hpp is not tested")
  return()
endif()
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
find_package(Threads REQUIRED)

foreach(standard 11 20)
  add_executable(test_cpp${standard} cpp/handles.cpp cpp/cpp_pendulum.c)
  set_target_properties(test_cpp${standard} PROPERTIES CXX_STANDARD ${standard}
    RUNTIME_OUTPUT_DIRECTORY ${CMAKE_CURRENT_BINARY_DIR})
  target_compile_definitions(test_cpp${standard} PRIVATE NSDAE_DATA_DIR="${PROJECT_SOURCE_DIR}/data")
  target_link_libraries(test_cpp${standard} PRIVATE test_own_folder nsdae_lib_shared Threads::Threads m)
  add_test(NAME cpp/handles-c++${standard} COMMAND test_cpp${standard})
  set_tests_properties(cpp/handles-c++${standard} PROPERTIES
    ENVIRONMENT OPENBLAS_NUM_THREADS=1 TIMEOUT 300)
endforeach()

add_executable(test_anomaly_jumps anomaly/jumps.cpp)
set_target_properties(test_anomaly_jumps PROPERTIES CXX_STANDARD 11
  RUNTIME_OUTPUT_DIRECTORY ${CMAKE_CURRENT_BINARY_DIR})
target_link_libraries(test_anomaly_jumps PRIVATE nsdae_lib_shared)
add_test(NAME anomaly/jumps COMMAND test_anomaly_jumps)
set_tests_properties(anomaly/jumps PROPERTIES ENVIRONMENT OPENBLAS_NUM_THREADS=1 TIMEOUT 300)
