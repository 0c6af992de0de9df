# Unit tests of base, linalg, system, terms, contact, smooth, and the anomaly tests.
foreach(name arena disjoint_sets suggest thread_pool params status)
  nsdae_unit_test(base ${name})
endforeach()

target_compile_definitions(test_unit_base_params PRIVATE _POSIX_C_SOURCE=200809L)

foreach(name dense multifrontal kkt rows sparse_kkt)
  nsdae_unit_test(linalg ${name})
  target_link_libraries(test_unit_linalg_${name} PRIVATE nsdae_lapack)
endforeach()

target_link_libraries(test_unit_linalg_multifrontal PRIVATE test_allocator)
target_link_libraries(test_unit_linalg_sparse_kkt PRIVATE test_allocator)

foreach(name callback_guard check differences moment_arms moment_arm_check setters system)
  nsdae_unit_test(system ${name})
endforeach()

nsdae_unit_test(system stiff_chain)
target_link_libraries(test_unit_system_stiff_chain PRIVATE test_support)

add_test(NAME unit/system/callbacks COMMAND sh ${PROJECT_SOURCE_DIR}/lib/system/callbacks.sh)
add_test(NAME structure/includes COMMAND python3 ${CMAKE_CURRENT_SOURCE_DIR}/structure.py ${PROJECT_SOURCE_DIR})

nsdae_unit_test(terms terms)
nsdae_unit_test(terms slots)
target_link_libraries(test_unit_terms_slots PRIVATE test_as_list test_support)
nsdae_unit_test(terms newton_matrix)
target_link_libraries(test_unit_terms_newton_matrix PRIVATE test_allocator)

foreach(name contact_islands law contacts random slides)
  nsdae_unit_test(contact ${name})
endforeach()

nsdae_unit_test(tracking tracking)
target_include_directories(test_unit_tracking_tracking PRIVATE support)
nsdae_unit_test(smooth runge_kutta)
nsdae_unit_test(smooth ida)
target_link_libraries(test_unit_smooth_ida PRIVATE test_process_allocator)

foreach(name continuity controls derivatives distance flush forces inertia joints limited limits listed meshes motors position_motors names one_source pins polyhedra user_rows refused sensors)
  nsdae_unit_test(bodies ${name})
  target_include_directories(test_unit_bodies_${name} PRIVATE ${PROJECT_SOURCE_DIR}/lib/system ${PROJECT_SOURCE_DIR}/lib/linalg
                             ${PROJECT_SOURCE_DIR}/lib/base)
endforeach()

target_link_libraries(test_unit_bodies_polyhedra PRIVATE test_allocator)

nsdae_test(anomaly arguments LINKS test_support)
nsdae_test(anomaly integrators)
nsdae_test(anomaly named)
nsdae_test(anomaly kinematics)
nsdae_test(anomaly lists)
nsdae_test(anomaly bodies LINKS test_allocator)
nsdae_test(anomaly sizes LINKS test_support)
nsdae_test(system blocks LINKS test_support test_allocator)
nsdae_test(system mechanisms LINKS test_dense test_support)
nsdae_test(system numbered LINKS test_support test_allocator)
nsdae_test(system listed_projection LINKS test_support test_as_list test_allocator)
nsdae_test(system certificate)
nsdae_test(system scene LINKS test_allocator)
target_compile_definitions(test_system_scene PRIVATE _POSIX_C_SOURCE=200809L)
nsdae_test(system slop LINKS test_support)
nsdae_test(system meshes LINKS test_support)
nsdae_test(system polyhedra LINKS test_support)
nsdae_test(system cylinder LINKS test_support)
nsdae_test(system contact_work LINKS test_support)
nsdae_test(system chains)
nsdae_test(system figures LINKS test_support)
nsdae_test(system threads LINKS test_support)
nsdae_test(system spare_contacts LINKS test_support test_spare_contacts)
nsdae_test(anomaly blas LINKS test_allocator test_process_allocator)
nsdae_test(anomaly certificate)
