! The module's constants have the values, its types the sizes and the places of their fields, that
! the C headers give them; and it has all of them.
program layout
  use, intrinsic :: iso_c_binding
  use nsdae_f_certificate
  use nsdae_f_friction
  use nsdae_f_friction_file
  use nsdae_f_bodies
  use nsdae_f_lcp
  use nsdae_f_params
  use nsdae_f_sim
  use nsdae_f_status
  use nsdae_f_system
  use nsdae_f_shape
  use nsdae_f_trajectory
  use check
  implicit none

  interface
    integer(c_int) function layout_count() bind(C)
      import
    end function
    integer(c_long) function layout_value(name) bind(C)
      import
      character(kind=c_char), intent(in) :: name(*)
    end function
  end interface

  integer :: compared = 0

  call statuses
  call constants
  call error_fields
  call dims_fields
  call check_fields
  call param_fields
  call params_fields
  call sim_options_fields
  call impact_fields
  call change_fields
  call record_fields
  call stats_fields
  call certificate_fields
  call contact_set_fields
  call contact_fields
  call rigid_body_fields
  call scene_fields
  call solid_fields
  call joint_fields
  call spring_fields
  call limit_fields
  call rope_fields
  call joint_spring_fields
  call motor_fields
  call sensor_fields
  call coupler_fields
  call torsion_fields
  call trajectory_info_fields
  call body_fields
  call own_fields
  call lcp_problem_fields
  call lcp_options_fields
  call lcp_info_fields
  call lcp_origin_fields
  call lcp_file_fields
  call friction_problem_fields
  call friction_file_fields
  call step_friction_fields
  call friction_options_fields
  call friction_progress_fields
  call friction_info_fields
  ! nothing that C has is missing here
  call is_int(compared, layout_count(), 'number of values, sizes and places')
  call check_done

contains

  subroutine same(name, value)
    character(len=*), intent(in) :: name
    integer(c_int), intent(in) :: value
    compared = compared + 1
    call is_int(value, int(layout_value(name // c_null_char), c_int), name)
  end subroutine

  subroutine same_size(name, bytes)
    character(len=*), intent(in) :: name
    integer(c_size_t), intent(in) :: bytes
    call same(name, int(bytes, c_int))
  end subroutine

  ! The place of a field in what begins at base.
  subroutine same_place(name, base, field)
    character(len=*), intent(in) :: name
    type(c_ptr), intent(in) :: base, field
    integer(c_intptr_t) :: start
    call same(name, int(transfer(field, start) - transfer(base, start), c_int))
  end subroutine

  subroutine statuses()
    call same('NSDAE_OK', NSDAE_OK)
    call same('NSDAE_EVENT', NSDAE_EVENT)
    call same('NSDAE_ZENO', NSDAE_ZENO)
    call same('NSDAE_STOPPED', NSDAE_STOPPED)
    call same('NSDAE_E_MEMORY', NSDAE_E_MEMORY)
    call same('NSDAE_E_ARGUMENT', NSDAE_E_ARGUMENT)
    call same('NSDAE_E_OPTION', NSDAE_E_OPTION)
    call same('NSDAE_E_STATE', NSDAE_E_STATE)
    call same('NSDAE_E_CALLBACK', NSDAE_E_CALLBACK)
    call same('NSDAE_E_NONFINITE', NSDAE_E_NONFINITE)
    call same('NSDAE_E_MASS', NSDAE_E_MASS)
    call same('NSDAE_E_RANK', NSDAE_E_RANK)
    call same('NSDAE_E_LCP', NSDAE_E_LCP)
    call same('NSDAE_E_INFEASIBLE', NSDAE_E_INFEASIBLE)
    call same('NSDAE_E_CONVERGENCE', NSDAE_E_CONVERGENCE)
    call same('NSDAE_E_DERIVATIVE', NSDAE_E_DERIVATIVE)
    call same('NSDAE_E_IO', NSDAE_E_IO)
    call same('NSDAE_E_UNSUPPORTED', NSDAE_E_UNSUPPORTED)
    call same('NSDAE_E_PAINLEVE', NSDAE_E_PAINLEVE)
    call same('NSDAE_E_INTERRUPTED', NSDAE_E_INTERRUPTED)
    call same('NSDAE_WARN_ENERGY', NSDAE_WARN_ENERGY)
    call same('NSDAE_WARN_PENETRATION', NSDAE_WARN_PENETRATION)
    call same('NSDAE_WARN_DRIFT', NSDAE_WARN_DRIFT)
    call same('NSDAE_WARN_PAINLEVE', NSDAE_WARN_PAINLEVE)
    call same('NSDAE_WARN_IMPACTS', NSDAE_WARN_IMPACTS)
    call same('NSDAE_WARN_RESTITUTION', NSDAE_WARN_RESTITUTION)
    call same('NSDAE_WARN_CONTACT', NSDAE_WARN_CONTACT)
    call same('NSDAE_WARN_MODEL', NSDAE_WARN_MODEL)
    call same('NSDAE_WARN_SINGULAR', NSDAE_WARN_SINGULAR)
  end subroutine

  subroutine constants()
    call same('NSDAE_VERSION_MAJOR', NSDAE_VERSION_MAJOR)
    call same('NSDAE_VERSION_MINOR', NSDAE_VERSION_MINOR)
    call same('NSDAE_VERSION_PATCH', NSDAE_VERSION_PATCH)
    call same('NSDAE_GROUND', NSDAE_GROUND)
    call same('NSDAE_MATERIALS', NSDAE_MATERIALS)
    call same('NSDAE_SHAPE_POINT', NSDAE_SHAPE_POINT)
    call same('NSDAE_SHAPE_DISC', NSDAE_SHAPE_DISC)
    call same('NSDAE_SHAPE_SEGMENT', NSDAE_SHAPE_SEGMENT)
    call same('NSDAE_SHAPE_POLYGON', NSDAE_SHAPE_POLYGON)
    call same('NSDAE_SHAPE_PATH', NSDAE_SHAPE_PATH)
    call same('NSDAE_SHAPE_SPHERE', NSDAE_SHAPE_SPHERE)
    call same('NSDAE_SHAPE_CAPSULE', NSDAE_SHAPE_CAPSULE)
    call same('NSDAE_SHAPE_BOX', NSDAE_SHAPE_BOX)
    call same('NSDAE_SHAPE_PLANE', NSDAE_SHAPE_PLANE)
    call same('NSDAE_SHAPE_POLYHEDRON', NSDAE_SHAPE_POLYHEDRON)
    call same('NSDAE_SHAPE_CYLINDER', NSDAE_SHAPE_CYLINDER)
    call same('NSDAE_SHAPE_CONE', NSDAE_SHAPE_CONE)
    call same('NSDAE_SHAPE_ELLIPSOID', NSDAE_SHAPE_ELLIPSOID)
    call same('NSDAE_JOINT_REVOLUTE', NSDAE_JOINT_REVOLUTE)
    call same('NSDAE_JOINT_PRISMATIC', NSDAE_JOINT_PRISMATIC)
    call same('NSDAE_JOINT_WELD', NSDAE_JOINT_WELD)
    call same('NSDAE_JOINT_DISTANCE', NSDAE_JOINT_DISTANCE)
    call same('NSDAE_JOINT_SLOT', NSDAE_JOINT_SLOT)
    call same('NSDAE_JOINT_GEAR', NSDAE_JOINT_GEAR)
    call same('NSDAE_JOINT_SPHERICAL', NSDAE_JOINT_SPHERICAL)
    call same('NSDAE_JOINT_CYLINDRICAL', NSDAE_JOINT_CYLINDRICAL)
    call same('NSDAE_JOINT_UNIVERSAL', NSDAE_JOINT_UNIVERSAL)
    call same('NSDAE_METHOD_IMPLICIT', NSDAE_METHOD_IMPLICIT)
    call same('NSDAE_METHOD_IMPLICIT_PRINTED', NSDAE_METHOD_IMPLICIT_PRINTED)
    call same('NSDAE_METHOD_MOREAU', NSDAE_METHOD_MOREAU)
    call same('NSDAE_METHOD_PENALTY', NSDAE_METHOD_PENALTY)
    call same('NSDAE_METHOD_EVENT', NSDAE_METHOD_EVENT)
    call same('NSDAE_PENALTY_HERTZ', NSDAE_PENALTY_HERTZ)
    call same('NSDAE_PENALTY_KELVIN_VOIGT', NSDAE_PENALTY_KELVIN_VOIGT)
    call same('NSDAE_PENALTY_HUNT_CROSSLEY', NSDAE_PENALTY_HUNT_CROSSLEY)
    call same('NSDAE_PENALTY_LANKARANI_NIKRAVESH', NSDAE_PENALTY_LANKARANI_NIKRAVESH)
    call same('NSDAE_PENALTY_FLORES', NSDAE_PENALTY_FLORES)
    call same('NSDAE_INTEGRATOR_AUTO', NSDAE_INTEGRATOR_AUTO)
    call same('NSDAE_INTEGRATOR_DOPRI5', NSDAE_INTEGRATOR_DOPRI5)
    call same('NSDAE_INTEGRATOR_DOP853', NSDAE_INTEGRATOR_DOP853)
    call same('NSDAE_INTEGRATOR_IDA', NSDAE_INTEGRATOR_IDA)
    call same('NSDAE_REDUNDANT_ERROR', NSDAE_REDUNDANT_ERROR)
    call same('NSDAE_REDUNDANT_LEAST_NORM', NSDAE_REDUNDANT_LEAST_NORM)
    call same('NSDAE_MODE_OPEN', NSDAE_MODE_OPEN)
    call same('NSDAE_MODE_SLIP', NSDAE_MODE_SLIP)
    call same('NSDAE_MODE_STICK', NSDAE_MODE_STICK)
    call same('NSDAE_OBSERVERS_MAX', NSDAE_OBSERVERS_MAX)
    call same('NSDAE_PROJECTION_NONE', NSDAE_PROJECTION_NONE)
    call same('NSDAE_PROJECTION_CONSTRAINTS', NSDAE_PROJECTION_CONSTRAINTS)
    call same('NSDAE_PROJECTION_CONTACTS', NSDAE_PROJECTION_CONTACTS)
    call same('NSDAE_PROJECTION_DEPTHS', NSDAE_PROJECTION_DEPTHS)
    call same('NSDAE_NAME_COORDINATE', NSDAE_NAME_COORDINATE)
    call same('NSDAE_NAME_VELOCITY', NSDAE_NAME_VELOCITY)
    call same('NSDAE_NAME_CONSTRAINT', NSDAE_NAME_CONSTRAINT)
    call same('NSDAE_NAME_CONTACT', NSDAE_NAME_CONTACT)
    call same('NSDAE_NAME_FRICTIONAL_JOINT', NSDAE_NAME_FRICTIONAL_JOINT)
    call same('NSDAE_NAME_SIZE', NSDAE_NAME_SIZE)
    call same('NSDAE_CONTACT_WIDTH', NSDAE_CONTACT_WIDTH)
    call same('NSDAE_UNIT_SIZE', NSDAE_UNIT_SIZE)
    call same('NSDAE_PARAM_REAL', NSDAE_PARAM_REAL)
    call same('NSDAE_PARAM_INT', NSDAE_PARAM_INT)
    call same('NSDAE_PARAM_CHOICE', NSDAE_PARAM_CHOICE)
    call same('NSDAE_PARAM_TEXT', NSDAE_PARAM_TEXT)
    call same('NSDAE_PARAM_TEXT_SIZE', NSDAE_PARAM_TEXT_SIZE)
    call same('NSDAE_OPEN_MIN', NSDAE_OPEN_MIN)
    call same('NSDAE_OPEN_MAX', NSDAE_OPEN_MAX)
    call same('NSDAE_OR_ZERO', NSDAE_OR_ZERO)
    call same('NSDAE_FRICTION_GLOBAL', NSDAE_FRICTION_GLOBAL)
    call same('NSDAE_FRICTION_LOCAL', NSDAE_FRICTION_LOCAL)
    call same('NSDAE_FRICTION_NONE', NSDAE_FRICTION_NONE)
    call same('NSDAE_FRICTION_TRIVIAL', NSDAE_FRICTION_TRIVIAL)
    call same('NSDAE_FRICTION_WARM', NSDAE_FRICTION_WARM)
    call same('NSDAE_FRICTION_NSGS', NSDAE_FRICTION_NSGS)
    call same('NSDAE_FRICTION_AS_LCP', NSDAE_FRICTION_AS_LCP)
    call same('NSDAE_FRICTION_SMOOTHING_HOMOTOPY', NSDAE_FRICTION_SMOOTHING_HOMOTOPY)
    call same('NSDAE_FRICTION_FARKAS', NSDAE_FRICTION_FARKAS)
    call same('NSDAE_FRICTION_SEMISMOOTH_NEWTON', NSDAE_FRICTION_SEMISMOOTH_NEWTON)
    call same('NSDAE_FRICTION_ACLM', NSDAE_FRICTION_ACLM)
    call same('NSDAE_FRICTION_SOCP_INTERIOR_POINT', NSDAE_FRICTION_SOCP_INTERIOR_POINT)
    call same('NSDAE_FRICTION_ITERATIVE_REFINEMENT', NSDAE_FRICTION_ITERATIVE_REFINEMENT)
    call same('NSDAE_FRICTION_ALL', NSDAE_FRICTION_ALL)
    call same('NSDAE_OUTCOME_UNSOLVED', NSDAE_OUTCOME_UNSOLVED)
    call same('NSDAE_OUTCOME_SOLVED', NSDAE_OUTCOME_SOLVED)
    call same('NSDAE_OUTCOME_INFEASIBLE', NSDAE_OUTCOME_INFEASIBLE)
    call same('NSDAE_PROOF_NONE', NSDAE_PROOF_NONE)
    call same('NSDAE_PROOF_FARKAS', NSDAE_PROOF_FARKAS)
    call same('NSDAE_LCP_NONE', NSDAE_LCP_NONE)
    call same('NSDAE_LCP_TRIVIAL', NSDAE_LCP_TRIVIAL)
    call same('NSDAE_LCP_WARM', NSDAE_LCP_WARM)
    call same('NSDAE_LCP_LEMKE', NSDAE_LCP_LEMKE)
    call same('NSDAE_LCP_NEWTON', NSDAE_LCP_NEWTON)
    call same('NSDAE_LCP_COVERING', NSDAE_LCP_COVERING)
    call same('NSDAE_LCP_PROVE', NSDAE_LCP_PROVE)
    call same('NSDAE_LCP_FURTHER', NSDAE_LCP_FURTHER)
    call same('NSDAE_LCP_ENUMERATE', NSDAE_LCP_ENUMERATE)
    call same('NSDAE_LCP_ALL', NSDAE_LCP_ALL)
    call same('NSDAE_PROOF_ENUMERATED', NSDAE_PROOF_ENUMERATED)
    call same('NSDAE_LCP_RAY_NOTHING', NSDAE_LCP_RAY_NOTHING)
    call same('NSDAE_LCP_RAY_NOT_COPOSITIVE', NSDAE_LCP_RAY_NOT_COPOSITIVE)
    call same('NSDAE_LCP_RAY_NOT_STRICTLY_COPOSITIVE', NSDAE_LCP_RAY_NOT_STRICTLY_COPOSITIVE)
  end subroutine

  subroutine error_fields()
    type(nsdae_c_error), target :: x
    call same_size('nsdae_error', c_sizeof(x))
    call same_place('nsdae_error%code', c_loc(x), c_loc(x%code))
    call same_place('nsdae_error%index', c_loc(x), c_loc(x%index))
    call same_place('nsdae_error%time', c_loc(x), c_loc(x%time))
    call same_place('nsdae_error%argument', c_loc(x), c_loc(x%argument))
    call same_place('nsdae_error%where', c_loc(x), c_loc(x%where))
    call same_place('nsdae_error%text', c_loc(x), c_loc(x%text))
  end subroutine

  subroutine dims_fields()
    type(nsdae_dims), target :: x
    call same_size('nsdae_dims', c_sizeof(x))
    call same_place('nsdae_dims%nv', c_loc(x), c_loc(x%nv))
    call same_place('nsdae_dims%m', c_loc(x), c_loc(x%m))
    call same_place('nsdae_dims%k', c_loc(x), c_loc(x%k))
    call same_place('nsdae_dims%nt', c_loc(x), c_loc(x%nt))
    call same_place('nsdae_dims%f', c_loc(x), c_loc(x%f))
  end subroutine

  subroutine check_fields()
    type(nsdae_c_check), target :: x
    call same_size('nsdae_check', c_sizeof(x))
    call same_place('nsdae_check%row', c_loc(x), c_loc(x%row))
    call same_place('nsdae_check%column', c_loc(x), c_loc(x%column))
    call same_place('nsdae_check%given', c_loc(x), c_loc(x%given))
    call same_place('nsdae_check%difference', c_loc(x), c_loc(x%difference))
    call same_place('nsdae_check%error', c_loc(x), c_loc(x%error))
  end subroutine

  subroutine param_fields()
    type(nsdae_c_param), target :: x
    call same_size('nsdae_param', c_sizeof(x))
    call same_place('nsdae_param%unit', c_loc(x), c_loc(x%unit))
    call same_place('nsdae_param%help', c_loc(x), c_loc(x%help))
    call same_place('nsdae_param%type', c_loc(x), c_loc(x%type))
    call same_place('nsdae_param%offset', c_loc(x), c_loc(x%offset))
    call same_place('nsdae_param%initial', c_loc(x), c_loc(x%initial))
    call same_place('nsdae_param%min', c_loc(x), c_loc(x%min))
    call same_place('nsdae_param%max', c_loc(x), c_loc(x%max))
    call same_place('nsdae_param%open', c_loc(x), c_loc(x%open))
    call same_place('nsdae_param%choices', c_loc(x), c_loc(x%choices))
  end subroutine

  subroutine params_fields()
    type(nsdae_c_params), target :: x
    call same_size('nsdae_params', c_sizeof(x))
    call same_place('nsdae_params%n', c_loc(x), c_loc(x%n))
  end subroutine

  subroutine sim_options_fields()
    type(nsdae_sim_options), target :: x
    call same_size('nsdae_sim_options', c_sizeof(x))
    call same_place('nsdae_sim_options%dt', c_loc(x), c_loc(x%dt))
    call same_place('nsdae_sim_options%baumgarte_alpha', c_loc(x), c_loc(x%baumgarte_alpha))
    call same_place('nsdae_sim_options%baumgarte_beta', c_loc(x), c_loc(x%baumgarte_beta))
    call same_place('nsdae_sim_options%iteration_tol', c_loc(x), c_loc(x%iteration_tol))
    call same_place('nsdae_sim_options%iteration_max', c_loc(x), c_loc(x%iteration_max))
    call same_place('nsdae_sim_options%redundant', c_loc(x), c_loc(x%redundant))
    call same_place('nsdae_sim_options%rank_tol', c_loc(x), c_loc(x%rank_tol))
    call same_place('nsdae_sim_options%contact_tol', c_loc(x), c_loc(x%contact_tol))
    call same_place('nsdae_sim_options%contact_work', c_loc(x), c_loc(x%contact_work))
    call same_place('nsdae_sim_options%contact_give', c_loc(x), c_loc(x%contact_give))
    call same_place('nsdae_sim_options%polygon', c_loc(x), c_loc(x%polygon))
    call same_place('nsdae_sim_options%impact_velocity', c_loc(x), c_loc(x%impact_velocity))
    call same_place('nsdae_sim_options%rtol', c_loc(x), c_loc(x%rtol))
    call same_place('nsdae_sim_options%atol', c_loc(x), c_loc(x%atol))
    call same_place('nsdae_sim_options%penalty_law', c_loc(x), c_loc(x%penalty_law))
    call same_place('nsdae_sim_options%penalty_stiffness', c_loc(x), c_loc(x%penalty_stiffness))
    call same_place('nsdae_sim_options%penalty_exponent', c_loc(x), c_loc(x%penalty_exponent))
    call same_place('nsdae_sim_options%friction_velocity', c_loc(x), c_loc(x%friction_velocity))
    call same_place('nsdae_sim_options%integrator', c_loc(x), c_loc(x%integrator))
    call same_place('nsdae_sim_options%step_max', c_loc(x), c_loc(x%step_max))
    call same_place('nsdae_sim_options%accumulation_time', c_loc(x), c_loc(x%accumulation_time))
    call same_place('nsdae_sim_options%events_max', c_loc(x), c_loc(x%events_max))
    call same_place('nsdae_sim_options%projection', c_loc(x), c_loc(x%projection))
    call same_place('nsdae_sim_options%start_tol', c_loc(x), c_loc(x%start_tol))
    call same_place('nsdae_sim_options%inner_steps_max', c_loc(x), c_loc(x%inner_steps_max))
    call same_place('nsdae_sim_options%start_check', c_loc(x), c_loc(x%start_check))
    call same_place('nsdae_sim_options%contacts_max', c_loc(x), c_loc(x%contacts_max))
    call same_place('nsdae_sim_options%threads', c_loc(x), c_loc(x%threads))
    call same_place('nsdae_sim_options%initialised', c_loc(x), c_loc(x%initialised))
  end subroutine

  subroutine impact_fields()
    type(nsdae_impact), target :: x
    call same_size('nsdae_impact', c_sizeof(x))
    call same_place('nsdae_impact%contact', c_loc(x), c_loc(x%contact))
    call same_place('nsdae_impact%normal_impulse', c_loc(x), c_loc(x%normal_impulse))
    call same_place('nsdae_impact%tangential_impulse', c_loc(x), c_loc(x%tangential_impulse))
    call same_place('nsdae_impact%velocity_before', c_loc(x), c_loc(x%velocity_before))
    call same_place('nsdae_impact%velocity_after', c_loc(x), c_loc(x%velocity_after))
    call same_place('nsdae_impact%peak_force', c_loc(x), c_loc(x%peak_force))
    call same_place('nsdae_impact%accumulation', c_loc(x), c_loc(x%accumulation))
    call same_place('nsdae_impact%id', c_loc(x), c_loc(x%id))
    call same_place('nsdae_impact%block', c_loc(x), c_loc(x%block))
  end subroutine

  subroutine change_fields()
    type(nsdae_change), target :: x
    call same_size('nsdae_change', c_sizeof(x))
    call same_place('nsdae_change%contact', c_loc(x), c_loc(x%contact))
    call same_place('nsdae_change%frictional_joint', c_loc(x), c_loc(x%frictional_joint))
    call same_place('nsdae_change%mode_before', c_loc(x), c_loc(x%mode_before))
    call same_place('nsdae_change%mode_after', c_loc(x), c_loc(x%mode_after))
    call same_place('nsdae_change%id', c_loc(x), c_loc(x%id))
    call same_place('nsdae_change%block', c_loc(x), c_loc(x%block))
  end subroutine

  subroutine record_fields()
    type(nsdae_c_record), target :: x
    call same_size('nsdae_record', c_sizeof(x))
    call same_place('nsdae_record%time', c_loc(x), c_loc(x%time))
    call same_place('nsdae_record%duration', c_loc(x), c_loc(x%duration))
    call same_place('nsdae_record%acceleration', c_loc(x), c_loc(x%acceleration))
    call same_place('nsdae_record%normal_force', c_loc(x), c_loc(x%normal_force))
    call same_place('nsdae_record%tangential_force', c_loc(x), c_loc(x%tangential_force))
    call same_place('nsdae_record%frictional_joint_force', c_loc(x), c_loc(x%frictional_joint_force))
    call same_place('nsdae_record%q', c_loc(x), c_loc(x%q))
    call same_place('nsdae_record%v', c_loc(x), c_loc(x%v))
    call same_place('nsdae_record%multiplier', c_loc(x), c_loc(x%multiplier))
    call same_place('nsdae_record%gap', c_loc(x), c_loc(x%gap))
    call same_place('nsdae_record%normal_impulse', c_loc(x), c_loc(x%normal_impulse))
    call same_place('nsdae_record%tangential_impulse', c_loc(x), c_loc(x%tangential_impulse))
    call same_place('nsdae_record%mode', c_loc(x), c_loc(x%mode))
    call same_place('nsdae_record%frictional_joint_impulse', c_loc(x), c_loc(x%frictional_joint_impulse))
    call same_place('nsdae_record%frictional_joint_mode', c_loc(x), c_loc(x%frictional_joint_mode))
    call same_place('nsdae_record%contacts', c_loc(x), c_loc(x%contacts))
    call same_place('nsdae_record%kinetic', c_loc(x), c_loc(x%kinetic))
    call same_place('nsdae_record%potential', c_loc(x), c_loc(x%potential))
    call same_place('nsdae_record%dissipated', c_loc(x), c_loc(x%dissipated))
    call same_place('nsdae_record%projection_energy', c_loc(x), c_loc(x%projection_energy))
    call same_place('nsdae_record%lcp_residual', c_loc(x), c_loc(x%lcp_residual))
    call same_place('nsdae_record%contact_tol', c_loc(x), c_loc(x%contact_tol))
    call same_place('nsdae_record%constraint_drift', c_loc(x), c_loc(x%constraint_drift))
    call same_place('nsdae_record%penetration', c_loc(x), c_loc(x%penetration))
    call same_place('nsdae_record%impact', c_loc(x), c_loc(x%impact))
    call same_place('nsdae_record%impacts', c_loc(x), c_loc(x%impacts))
    call same_place('nsdae_record%change', c_loc(x), c_loc(x%change))
    call same_place('nsdae_record%changes', c_loc(x), c_loc(x%changes))
    call same_place('nsdae_record%certificate', c_loc(x), c_loc(x%certificate))
  end subroutine

  subroutine stats_fields()
    type(nsdae_stats), target :: x
    call same_size('nsdae_stats', c_sizeof(x))
    call same_place('nsdae_stats%smooth_steps', c_loc(x), c_loc(x%smooth_steps))
    call same_place('nsdae_stats%contact_steps', c_loc(x), c_loc(x%contact_steps))
    call same_place('nsdae_stats%lcps', c_loc(x), c_loc(x%lcps))
    call same_place('nsdae_stats%lcp_pivots', c_loc(x), c_loc(x%lcp_pivots))
    call same_place('nsdae_stats%iterations', c_loc(x), c_loc(x%iterations))
    call same_place('nsdae_stats%mass_evals', c_loc(x), c_loc(x%mass_evals))
    call same_place('nsdae_stats%force_evals', c_loc(x), c_loc(x%force_evals))
    call same_place('nsdae_stats%jacobian_evals', c_loc(x), c_loc(x%jacobian_evals))
    call same_place('nsdae_stats%impacts', c_loc(x), c_loc(x%impacts))
    call same_place('nsdae_stats%events', c_loc(x), c_loc(x%events))
    call same_place('nsdae_stats%accumulations', c_loc(x), c_loc(x%accumulations))
    call same_place('nsdae_stats%fallback_steps', c_loc(x), c_loc(x%fallback_steps))
    call same_place('nsdae_stats%inexact_steps', c_loc(x), c_loc(x%inexact_steps))
    call same_place('nsdae_stats%frozen_steps', c_loc(x), c_loc(x%frozen_steps))
    call same_place('nsdae_stats%accumulations_early', c_loc(x), c_loc(x%accumulations_early))
    call same_place('nsdae_stats%rank_retained', c_loc(x), c_loc(x%rank_retained))
    call same_place('nsdae_stats%rank_discarded', c_loc(x), c_loc(x%rank_discarded))
    call same_place('nsdae_stats%rank', c_loc(x), c_loc(x%rank))
    call same_place('nsdae_stats%rank_most', c_loc(x), c_loc(x%rank_most))
    call same_place('nsdae_stats%worst_residual', c_loc(x), c_loc(x%worst_residual))
    call same_place('nsdae_stats%contact_tol', c_loc(x), c_loc(x%contact_tol))
    call same_place('nsdae_stats%worst_drift', c_loc(x), c_loc(x%worst_drift))
    call same_place('nsdae_stats%worst_penetration', c_loc(x), c_loc(x%worst_penetration))
    call same_place('nsdae_stats%energy_start', c_loc(x), c_loc(x%energy_start))
    call same_place('nsdae_stats%energy_balance', c_loc(x), c_loc(x%energy_balance))
    call same_place('nsdae_stats%warnings', c_loc(x), c_loc(x%warnings))
    call same_place('nsdae_stats%wall_time', c_loc(x), c_loc(x%wall_time))
    call same_place('nsdae_stats%contact_capacity', c_loc(x), c_loc(x%contact_capacity))
    call same_place('nsdae_stats%contact_growths', c_loc(x), c_loc(x%contact_growths))
    call same_place('nsdae_stats%islands', c_loc(x), c_loc(x%islands))
    call same_place('nsdae_stats%island_contacts', c_loc(x), c_loc(x%island_contacts))
    call same_place('nsdae_stats%certificate', c_loc(x), c_loc(x%certificate))
  end subroutine

  subroutine certificate_fields()
    type(nsdae_certificate), target :: x
    call same_size('nsdae_certificate', c_sizeof(x))
    call same_place('nsdae_certificate%pull', c_loc(x), c_loc(x%pull))
    call same_place('nsdae_certificate%cone_excess', c_loc(x), c_loc(x%cone_excess))
    call same_place('nsdae_certificate%penetration', c_loc(x), c_loc(x%penetration))
    call same_place('nsdae_certificate%constraint_drift', c_loc(x), c_loc(x%constraint_drift))
    call same_place('nsdae_certificate%constraint_rate', c_loc(x), c_loc(x%constraint_rate))
    call same_place('nsdae_certificate%complementarity', c_loc(x), c_loc(x%complementarity))
    call same_place('nsdae_certificate%energy', c_loc(x), c_loc(x%energy))
    call same_place('nsdae_certificate%work', c_loc(x), c_loc(x%work))
    call same_place('nsdae_certificate%dissipated', c_loc(x), c_loc(x%dissipated))
    call same_place('nsdae_certificate%unexplained', c_loc(x), c_loc(x%unexplained))
    call same_place('nsdae_certificate%pull_contact', c_loc(x), c_loc(x%pull_contact))
    call same_place('nsdae_certificate%cone_contact', c_loc(x), c_loc(x%cone_contact))
    call same_place('nsdae_certificate%penetration_contact', c_loc(x), c_loc(x%penetration_contact))
    call same_place('nsdae_certificate%drift_constraint', c_loc(x), c_loc(x%drift_constraint))
    call same_place('nsdae_certificate%rate_constraint', c_loc(x), c_loc(x%rate_constraint))
    call same_place('nsdae_certificate%complementarity_contact', c_loc(x), c_loc(x%complementarity_contact))
  end subroutine

  subroutine contact_set_fields()
    type(nsdae_c_contact_set), target :: x
    call same_size('nsdae_contact_set', c_sizeof(x))
    call same_place('nsdae_contact_set%id', c_loc(x), c_loc(x%id))
    call same_place('nsdae_contact_set%block', c_loc(x), c_loc(x%block))
    call same_place('nsdae_contact_set%gap', c_loc(x), c_loc(x%gap))
    call same_place('nsdae_contact_set%normal_impulse', c_loc(x), c_loc(x%normal_impulse))
    call same_place('nsdae_contact_set%tangential_impulse', c_loc(x), c_loc(x%tangential_impulse))
    call same_place('nsdae_contact_set%mode', c_loc(x), c_loc(x%mode))
  end subroutine

  subroutine contact_fields()
    type(nsdae_contact), target :: x
    call same_size('nsdae_contact', c_sizeof(x))
    call same_place('nsdae_contact%block', c_loc(x), c_loc(x%block))
    call same_place('nsdae_contact%gap', c_loc(x), c_loc(x%gap))
    call same_place('nsdae_contact%mu', c_loc(x), c_loc(x%mu))
    call same_place('nsdae_contact%e_n', c_loc(x), c_loc(x%e_n))
    call same_place('nsdae_contact%e_t', c_loc(x), c_loc(x%e_t))
    call same_place('nsdae_contact%w', c_loc(x), c_loc(x%w))
    call same_place('nsdae_contact%omega', c_loc(x), c_loc(x%omega))
    call same_place('nsdae_contact%omega_given', c_loc(x), c_loc(x%omega_given))
    call same_place('nsdae_contact%direction', c_loc(x), c_loc(x%direction))
    call same_place('nsdae_contact%wide', c_loc(x), c_loc(x%wide))
  end subroutine

  subroutine rigid_body_fields()
    type(nsdae_rigid_body), target :: x
    call same_size('nsdae_rigid_body', c_sizeof(x))
    call same_place('nsdae_rigid_body%inertia', c_loc(x), c_loc(x%inertia))
    call same_place('nsdae_rigid_body%product', c_loc(x), c_loc(x%product))
    call same_place('nsdae_rigid_body%position', c_loc(x), c_loc(x%position))
    call same_place('nsdae_rigid_body%angle', c_loc(x), c_loc(x%angle))
    call same_place('nsdae_rigid_body%quaternion', c_loc(x), c_loc(x%quaternion))
    call same_place('nsdae_rigid_body%velocity', c_loc(x), c_loc(x%velocity))
    call same_place('nsdae_rigid_body%spin', c_loc(x), c_loc(x%spin))
  end subroutine

  subroutine scene_fields()
    type(nsdae_scene), target :: x
    call same_size('nsdae_scene', c_sizeof(x))
    call same_place('nsdae_scene%body', c_loc(x), c_loc(x%body))
    call same_place('nsdae_scene%solid', c_loc(x), c_loc(x%solid))
    call same_place('nsdae_scene%wall', c_loc(x), c_loc(x%wall))
    call same_place('nsdae_scene%floor', c_loc(x), c_loc(x%floor))
    call same_place('nsdae_scene%mu', c_loc(x), c_loc(x%mu))
    call same_place('nsdae_scene%e_n', c_loc(x), c_loc(x%e_n))
    call same_place('nsdae_scene%g', c_loc(x), c_loc(x%g))
    call same_place('nsdae_scene%dt', c_loc(x), c_loc(x%dt))
  end subroutine

  subroutine solid_fields()
    type(nsdae_c_solid), target :: x
    call same_size('nsdae_solid', c_sizeof(x))
    call same_place('nsdae_solid%radius', c_loc(x), c_loc(x%radius))
    call same_place('nsdae_solid%length', c_loc(x), c_loc(x%length))
    call same_place('nsdae_solid%hollow', c_loc(x), c_loc(x%hollow))
    call same_place('nsdae_solid%points', c_loc(x), c_loc(x%points))
    call same_place('nsdae_solid%point', c_loc(x), c_loc(x%point))
    call same_place('nsdae_solid%triangles', c_loc(x), c_loc(x%triangles))
    call same_place('nsdae_solid%triangle', c_loc(x), c_loc(x%triangle))
    call same_place('nsdae_solid%grid', c_loc(x), c_loc(x%grid))
    call same_place('nsdae_solid%position', c_loc(x), c_loc(x%position))
    call same_place('nsdae_solid%angle', c_loc(x), c_loc(x%angle))
    call same_place('nsdae_solid%quaternion', c_loc(x), c_loc(x%quaternion))
    call same_place('nsdae_solid%material', c_loc(x), c_loc(x%material))
    call same_place('nsdae_solid%group', c_loc(x), c_loc(x%group))
    call same_place('nsdae_solid%exclude', c_loc(x), c_loc(x%exclude))
  end subroutine

  subroutine joint_fields()
    type(nsdae_joint), target :: x
    call same_size('nsdae_joint', c_sizeof(x))
    call same_place('nsdae_joint%body', c_loc(x), c_loc(x%body))
    call same_place('nsdae_joint%point', c_loc(x), c_loc(x%point))
    call same_place('nsdae_joint%end', c_loc(x), c_loc(x%end))
    call same_place('nsdae_joint%axis', c_loc(x), c_loc(x%axis))
    call same_place('nsdae_joint%cross', c_loc(x), c_loc(x%cross))
    call same_place('nsdae_joint%ratio', c_loc(x), c_loc(x%ratio))
    call same_place('nsdae_joint%drive', c_loc(x), c_loc(x%drive))
    call same_place('nsdae_joint%user', c_loc(x), c_loc(x%user))
    call same_place('nsdae_joint%mu', c_loc(x), c_loc(x%mu))
    call same_place('nsdae_joint%radius', c_loc(x), c_loc(x%radius))
    call same_place('nsdae_joint%collide_connected', c_loc(x), c_loc(x%collide_connected))
  end subroutine

  subroutine spring_fields()
    type(nsdae_spring), target :: x
    call same_size('nsdae_spring', c_sizeof(x))
    call same_place('nsdae_spring%point', c_loc(x), c_loc(x%point))
    call same_place('nsdae_spring%end', c_loc(x), c_loc(x%end))
    call same_place('nsdae_spring%stiffness', c_loc(x), c_loc(x%stiffness))
    call same_place('nsdae_spring%damping', c_loc(x), c_loc(x%damping))
    call same_place('nsdae_spring%rest', c_loc(x), c_loc(x%rest))
  end subroutine

  subroutine limit_fields()
    type(nsdae_limit), target :: x
    call same_size('nsdae_limit', c_sizeof(x))
    call same_place('nsdae_limit%coordinate', c_loc(x), c_loc(x%coordinate))
    call same_place('nsdae_limit%low', c_loc(x), c_loc(x%low))
    call same_place('nsdae_limit%high', c_loc(x), c_loc(x%high))
    call same_place('nsdae_limit%e_n', c_loc(x), c_loc(x%e_n))
  end subroutine

  subroutine rope_fields()
    type(nsdae_rope), target :: x
    call same_size('nsdae_rope', c_sizeof(x))
    call same_place('nsdae_rope%point', c_loc(x), c_loc(x%point))
    call same_place('nsdae_rope%end', c_loc(x), c_loc(x%end))
    call same_place('nsdae_rope%length', c_loc(x), c_loc(x%length))
    call same_place('nsdae_rope%e_n', c_loc(x), c_loc(x%e_n))
  end subroutine

  subroutine joint_spring_fields()
    type(nsdae_joint_spring), target :: x
    call same_size('nsdae_joint_spring', c_sizeof(x))
    call same_place('nsdae_joint_spring%coordinate', c_loc(x), c_loc(x%coordinate))
    call same_place('nsdae_joint_spring%stiffness', c_loc(x), c_loc(x%stiffness))
    call same_place('nsdae_joint_spring%damping', c_loc(x), c_loc(x%damping))
    call same_place('nsdae_joint_spring%rest', c_loc(x), c_loc(x%rest))
  end subroutine

  subroutine motor_fields()
    type(nsdae_motor), target :: x
    call same_size('nsdae_motor', c_sizeof(x))
    call same_place('nsdae_motor%coordinate', c_loc(x), c_loc(x%coordinate))
    call same_place('nsdae_motor%kind', c_loc(x), c_loc(x%kind))
    call same_place('nsdae_motor%target', c_loc(x), c_loc(x%target))
    call same_place('nsdae_motor%limit', c_loc(x), c_loc(x%limit))
    call same_place('nsdae_motor%kp', c_loc(x), c_loc(x%kp))
    call same_place('nsdae_motor%kd', c_loc(x), c_loc(x%kd))
    call same_place('nsdae_motor%drive', c_loc(x), c_loc(x%drive))
    call same_place('nsdae_motor%vary', c_loc(x), c_loc(x%vary))
    call same_place('nsdae_motor%user', c_loc(x), c_loc(x%user))
    call same_place('nsdae_motor%vary_user', c_loc(x), c_loc(x%vary_user))
  end subroutine

  subroutine sensor_fields()
    type(nsdae_sensor), target :: x
    call same_size('nsdae_sensor', c_sizeof(x))
    call same_place('nsdae_sensor%kind', c_loc(x), c_loc(x%kind))
    call same_place('nsdae_sensor%body', c_loc(x), c_loc(x%body))
    call same_place('nsdae_sensor%joint', c_loc(x), c_loc(x%joint))
    call same_place('nsdae_sensor%coordinate', c_loc(x), c_loc(x%coordinate))
    call same_place('nsdae_sensor%solid', c_loc(x), c_loc(x%solid))
    call same_place('nsdae_sensor%point', c_loc(x), c_loc(x%point))
  end subroutine

  subroutine coupler_fields()
    type(nsdae_coupler), target :: x
    call same_size('nsdae_coupler', c_sizeof(x))
    call same_place('nsdae_coupler%coordinate', c_loc(x), c_loc(x%coordinate))
    call same_place('nsdae_coupler%p', c_loc(x), c_loc(x%p))
  end subroutine

  subroutine torsion_fields()
    type(nsdae_torsion), target :: x
    call same_size('nsdae_torsion', c_sizeof(x))
    call same_place('nsdae_torsion%axis', c_loc(x), c_loc(x%axis))
    call same_place('nsdae_torsion%stiffness', c_loc(x), c_loc(x%stiffness))
    call same_place('nsdae_torsion%damping', c_loc(x), c_loc(x%damping))
    call same_place('nsdae_torsion%rest', c_loc(x), c_loc(x%rest))
  end subroutine

  subroutine own_fields()
    type(nsdae_user_rows), target :: x
    call same_size('nsdae_user_rows', c_sizeof(x))
    call same_place('nsdae_user_rows%mass', c_loc(x), c_loc(x%mass))
    call same_place('nsdae_user_rows%force', c_loc(x), c_loc(x%force))
    call same_place('nsdae_user_rows%constraint', c_loc(x), c_loc(x%constraint))
    call same_place('nsdae_user_rows%constraint_jacobian', c_loc(x), c_loc(x%constraint_jacobian))
    call same_place('nsdae_user_rows%constraint_bias', c_loc(x), c_loc(x%constraint_bias))
    call same_place('nsdae_user_rows%gap', c_loc(x), c_loc(x%gap))
    call same_place('nsdae_user_rows%gap_normal', c_loc(x), c_loc(x%gap_normal))
    call same_place('nsdae_user_rows%gap_tangent', c_loc(x), c_loc(x%gap_tangent))
    call same_place('nsdae_user_rows%contact_bias', c_loc(x), c_loc(x%contact_bias))
    call same_place('nsdae_user_rows%contact_acceleration', c_loc(x), c_loc(x%contact_acceleration))
    call same_place('nsdae_user_rows%frictional_joint_tangent', c_loc(x), c_loc(x%frictional_joint_tangent))
    call same_place('nsdae_user_rows%kinematics', c_loc(x), c_loc(x%kinematics))
    call same_place('nsdae_user_rows%constraint_rows', c_loc(x), c_loc(x%constraint_rows))
    call same_place('nsdae_user_rows%contacts', c_loc(x), c_loc(x%contacts))
    call same_place('nsdae_user_rows%potential', c_loc(x), c_loc(x%potential))
    call same_place('nsdae_user_rows%user', c_loc(x), c_loc(x%user))
  end subroutine

  subroutine trajectory_info_fields()
    type(nsdae_c_trajectory_info), target :: x
    call same_size('nsdae_trajectory_info', c_sizeof(x))
    call same_place('nsdae_trajectory_info%parameters', c_loc(x), c_loc(x%parameters))
    call same_place('nsdae_trajectory_info%parameters_base', c_loc(x), c_loc(x%parameters_base))
    call same_place('nsdae_trajectory_info%live', c_loc(x), c_loc(x%live))
    call same_place('nsdae_trajectory_info%every', c_loc(x), c_loc(x%every))
    call same_place('nsdae_trajectory_info%compress', c_loc(x), c_loc(x%compress))
    call same_place('nsdae_trajectory_info%t_end', c_loc(x), c_loc(x%t_end))
    call same_place('nsdae_trajectory_info%contact_forces', c_loc(x), c_loc(x%contact_forces))
  end subroutine

  subroutine body_fields()
    type(nsdae_c_body), target :: x
    call same_size('nsdae_body', c_sizeof(x))
    call same_place('nsdae_body%shape', c_loc(x), c_loc(x%shape))
    call same_place('nsdae_body%size', c_loc(x), c_loc(x%size))
    call same_place('nsdae_body%points', c_loc(x), c_loc(x%points))
    call same_place('nsdae_body%point', c_loc(x), c_loc(x%point))
    call same_place('nsdae_body%position', c_loc(x), c_loc(x%position))
    call same_place('nsdae_body%angle', c_loc(x), c_loc(x%angle))
    call same_place('nsdae_body%quaternion', c_loc(x), c_loc(x%quaternion))
    call same_place('nsdae_body%end', c_loc(x), c_loc(x%end))
    call same_place('nsdae_body%colour', c_loc(x), c_loc(x%colour))
  end subroutine

  subroutine lcp_problem_fields()
    type(nsdae_c_lcp_problem), target :: x
    call same_size('nsdae_lcp_problem', c_sizeof(x))
    call same_place('nsdae_lcp_problem%A', c_loc(x), c_loc(x%A))
    call same_place('nsdae_lcp_problem%lda', c_loc(x), c_loc(x%lda))
    call same_place('nsdae_lcp_problem%b', c_loc(x), c_loc(x%b))
  end subroutine

  subroutine lcp_options_fields()
    type(nsdae_lcp_options), target :: x
    call same_size('nsdae_lcp_options', c_sizeof(x))
    call same_place('nsdae_lcp_options%max_pivots', c_loc(x), c_loc(x%max_pivots))
    call same_place('nsdae_lcp_options%stages', c_loc(x), c_loc(x%stages))
    call same_place('nsdae_lcp_options%enumerate_max', c_loc(x), c_loc(x%enumerate_max))
  end subroutine

  subroutine lcp_info_fields()
    type(nsdae_lcp_info), target :: x
    call same_size('nsdae_lcp_info', c_sizeof(x))
    call same_place('nsdae_lcp_info%stage', c_loc(x), c_loc(x%stage))
    call same_place('nsdae_lcp_info%proof', c_loc(x), c_loc(x%proof))
    call same_place('nsdae_lcp_info%ray', c_loc(x), c_loc(x%ray))
    call same_place('nsdae_lcp_info%pivots', c_loc(x), c_loc(x%pivots))
    call same_place('nsdae_lcp_info%residual', c_loc(x), c_loc(x%residual))
  end subroutine

  subroutine lcp_origin_fields()
    type(nsdae_c_lcp_origin), target :: x
    call same_size('nsdae_lcp_origin', c_sizeof(x))
    call same_place('nsdae_lcp_origin%step', c_loc(x), c_loc(x%step))
    call same_place('nsdae_lcp_origin%tol', c_loc(x), c_loc(x%tol))
    call same_place('nsdae_lcp_origin%method', c_loc(x), c_loc(x%method))
  end subroutine

  subroutine lcp_file_fields()
    type(nsdae_c_lcp_file), target :: x
    call same_size('nsdae_lcp_file', c_sizeof(x))
    call same_place('nsdae_lcp_file%A', c_loc(x), c_loc(x%A))
    call same_place('nsdae_lcp_file%b', c_loc(x), c_loc(x%b))
    call same_place('nsdae_lcp_file%tol', c_loc(x), c_loc(x%tol))
  end subroutine

  subroutine friction_problem_fields()
    type(nsdae_c_friction_problem), target :: x
    call same_size('nsdae_friction_problem', c_sizeof(x))
    call same_place('nsdae_friction_problem%contacts', c_loc(x), c_loc(x%contacts))
    call same_place('nsdae_friction_problem%bilateral', c_loc(x), c_loc(x%bilateral))
    call same_place('nsdae_friction_problem%rows', c_loc(x), c_loc(x%rows))
    call same_place('nsdae_friction_problem%mu', c_loc(x), c_loc(x%mu))
    call same_place('nsdae_friction_problem%w', c_loc(x), c_loc(x%w))
    call same_place('nsdae_friction_problem%compliance', c_loc(x), c_loc(x%compliance))
    call same_place('nsdae_friction_problem%blocks', c_loc(x), c_loc(x%blocks))
    call same_place('nsdae_friction_problem%size', c_loc(x), c_loc(x%size))
    call same_place('nsdae_friction_problem%M', c_loc(x), c_loc(x%M))
    call same_place('nsdae_friction_problem%f', c_loc(x), c_loc(x%f))
    call same_place('nsdae_friction_problem%first', c_loc(x), c_loc(x%first))
    call same_place('nsdae_friction_problem%block', c_loc(x), c_loc(x%block))
    call same_place('nsdae_friction_problem%value', c_loc(x), c_loc(x%value))
  end subroutine

  subroutine friction_file_fields()
    type(nsdae_c_friction_origin), target :: from
    type(nsdae_c_friction_points), target :: points
    type(nsdae_c_friction_file), target :: x
    call same_size('nsdae_friction_origin', c_sizeof(from))
    call same_place('nsdae_friction_origin%step', c_loc(from), c_loc(from%step))
    call same_place('nsdae_friction_origin%tol', c_loc(from), c_loc(from%tol))
    call same_place('nsdae_friction_origin%refine', c_loc(from), c_loc(from%refine))
    call same_place('nsdae_friction_origin%method', c_loc(from), c_loc(from%method))
    call same_size('nsdae_friction_points', c_sizeof(points))
    call same_place('nsdae_friction_points%r', c_loc(points), c_loc(points%r))
    call same_place('nsdae_friction_points%u', c_loc(points), c_loc(points%u))
    call same_place('nsdae_friction_points%low', c_loc(points), c_loc(points%low))
    call same_size('nsdae_friction_file', c_sizeof(x))
    call same_place('nsdae_friction_file%guess', c_loc(x), c_loc(x%guess))
    call same_place('nsdae_friction_file%r', c_loc(x), c_loc(x%r))
    call same_place('nsdae_friction_file%low', c_loc(x), c_loc(x%low))
    call same_place('nsdae_friction_file%tol', c_loc(x), c_loc(x%tol))
    call same_place('nsdae_friction_file%refine', c_loc(x), c_loc(x%refine))
    call same_place('nsdae_friction_file%asymmetry', c_loc(x), c_loc(x%asymmetry))
    call same_place('nsdae_friction_file%velocity', c_loc(x), c_loc(x%velocity))
  end subroutine

  subroutine step_friction_fields()
    type(nsdae_c_step_friction), target :: x
    call same_size('nsdae_step_friction', c_sizeof(x))
    call same_place('nsdae_step_friction%options', c_loc(x), c_loc(x%options))
    call same_place('nsdae_step_friction%guess', c_loc(x), c_loc(x%guess))
    call same_place('nsdae_step_friction%r', c_loc(x), c_loc(x%r))
    call same_place('nsdae_step_friction%u', c_loc(x), c_loc(x%u))
  end subroutine

  subroutine friction_options_fields()
    type(nsdae_friction_options), target :: x
    call same_size('nsdae_friction_options', c_sizeof(x))
    call same_place('nsdae_friction_options%stages', c_loc(x), c_loc(x%stages))
    call same_place('nsdae_friction_options%max_sweeps', c_loc(x), c_loc(x%max_sweeps))
    call same_place('nsdae_friction_options%max_iterations', c_loc(x), c_loc(x%max_iterations))
    call same_place('nsdae_friction_options%refine', c_loc(x), c_loc(x%refine))
    call same_place('nsdae_friction_options%budget', c_loc(x), c_loc(x%budget))
    call same_place('nsdae_friction_options%progress', c_loc(x), c_loc(x%progress))
    call same_place('nsdae_friction_options%user', c_loc(x), c_loc(x%user))
  end subroutine

  subroutine friction_progress_fields()
    type(nsdae_friction_progress), target :: x
    call same_size('nsdae_friction_progress', c_sizeof(x))
    call same_place('nsdae_friction_progress%island', c_loc(x), c_loc(x%island))
    call same_place('nsdae_friction_progress%islands', c_loc(x), c_loc(x%islands))
    call same_place('nsdae_friction_progress%contacts', c_loc(x), c_loc(x%contacts))
    call same_place('nsdae_friction_progress%residual', c_loc(x), c_loc(x%residual))
    call same_place('nsdae_friction_progress%share', c_loc(x), c_loc(x%share))
    call same_place('nsdae_friction_progress%sweeps', c_loc(x), c_loc(x%sweeps))
    call same_place('nsdae_friction_progress%iterations', c_loc(x), c_loc(x%iterations))
  end subroutine

  subroutine friction_info_fields()
    type(nsdae_friction_info), target :: x
    call same_size('nsdae_friction_info', c_sizeof(x))
    call same_place('nsdae_friction_info%stage', c_loc(x), c_loc(x%stage))
    call same_place('nsdae_friction_info%proof', c_loc(x), c_loc(x%proof))
    call same_place('nsdae_friction_info%islands', c_loc(x), c_loc(x%islands))
    call same_place('nsdae_friction_info%sweeps', c_loc(x), c_loc(x%sweeps))
    call same_place('nsdae_friction_info%iterations', c_loc(x), c_loc(x%iterations))
    call same_place('nsdae_friction_info%factorisations', c_loc(x), c_loc(x%factorisations))
    call same_place('nsdae_friction_info%residual', c_loc(x), c_loc(x%residual))
  end subroutine

end program
