! nsdae: the complete Fortran interface. Each C header has a module of the same name; its
! documentation applies here. Pointers with sizes become arrays, structs that the caller fills
! become optional last arguments, texts become characters.
module nsdae
  use, intrinsic :: iso_c_binding, only: c_char, c_double, c_int, c_long
  use nsdae_f_bodies
  use nsdae_f_certificate
  use nsdae_f_friction
  use nsdae_f_friction_file
  use nsdae_f_kernels
  use nsdae_f_lcp
  use nsdae_f_params
  use nsdae_f_shape
  use nsdae_f_sim
  use nsdae_f_status
  use nsdae_f_system
  use nsdae_f_trajectory
  implicit none

  ! shared by the modules only
  private :: body_of, nsdae_body_words, nsdae_c_check, nsdae_c_error, nsdae_c_friction_file, nsdae_c_friction_origin, &
             nsdae_c_friction_points, nsdae_c_friction_problem, nsdae_c_lcp_file, nsdae_c_lcp_origin, &
             nsdae_c_lcp_problem, nsdae_c_param, nsdae_c_params, nsdae_c_record, nsdae_c_contact_set, &
             nsdae_c_solid, nsdae_c_trajectory_info, base_of, check_size, check_state, error_at, error_from_c, error_to_c, &
             no_memory, no_user, problem_from_c, problem_to_c, refuse, rows_of_problem, shape_problem, &
             system_of, table_at, table_of
end module
