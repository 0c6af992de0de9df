! The twin of tests/unit/system/system.c: making a description; sizes, setters, coefficients, what is
! missing.
program description
  use, intrinsic :: ieee_arithmetic
  use nsdae
  use planar_model
  use check
  implicit none

  real(c_double) :: nan, infinity

  nan = ieee_value(nan, ieee_quiet_nan)
  infinity = ieee_value(nan, ieee_positive_inf)
  call sizes_outside
  call sizes_inside
  call all_setters
  call coefficients
  call slides
  call missing_callbacks
  call differences_text
  call check_done

contains

  subroutine refused_dims(dims, name)
    type(nsdae_dims), intent(in) :: dims
    character(len=*), intent(in) :: name
    type(nsdae_system) :: system
    type(nsdae_error) :: error
    call is_int(nsdae_system_create(dims, system, error), NSDAE_E_ARGUMENT, name)
    call is_int(error%status, NSDAE_E_ARGUMENT, 'error%status')
    call is_text(error%argument, name, 'error%argument')
    call contains_text(error%text, name, 'error%text')
    call is_int(nsdae_system_create(dims, system), NSDAE_E_ARGUMENT, name)
    call nsdae_system_destroy(system)
  end subroutine

  subroutine sizes_outside()
    integer(c_int), parameter :: most = huge(0_c_int)
    call refused_dims(nsdae_dims(nq=0), 'nq')
    call refused_dims(nsdae_dims(nq=-1), 'nq')
    call refused_dims(nsdae_dims(nq=most), 'nq')
    call refused_dims(nsdae_dims(nq=3, nv=4), 'nv')
    call refused_dims(nsdae_dims(nq=3, nv=-1), 'nv')
    call refused_dims(nsdae_dims(nq=3, m=-1), 'm')
    call refused_dims(nsdae_dims(nq=3, m=most), 'm')
    call refused_dims(nsdae_dims(nq=3, k=-1), 'k')
    call refused_dims(nsdae_dims(nq=3, k=most), 'k')
    call refused_dims(nsdae_dims(nq=3, nt=-1), 'nt')
    call refused_dims(nsdae_dims(nq=3, nt=3), 'nt')
    call refused_dims(nsdae_dims(nq=3, f=most), 'f')
    call refused_dims(nsdae_dims(nq=3, f=-1), 'f')
  end subroutine

  subroutine sizes_inside()
    type(nsdae_dims) :: good(5), got
    type(nsdae_system) :: system
    type(nsdae_error) :: error
    integer :: i
    good = [nsdae_dims(nq=1), nsdae_dims(nq=4, nv=3), nsdae_dims(nq=3, nv=3, m=7, f=7), &
            nsdae_dims(nq=3, k=100, nt=2), nsdae_dims(nq=3, nt=2)]
    do i = 1, size(good)
      call is_int(nsdae_system_create(good(i), system), NSDAE_OK, 'create')
      call is_int(nsdae_system_get_dims(system, got), NSDAE_OK, 'get_dims')
      call is_int(got%nv, merge(good(i)%nv, good(i)%nq, good(i)%nv > 0), 'nv')
      call is_int(got%k, good(i)%k, 'k')
      error = nsdae_system_error(system)
      call is_int(error%status, NSDAE_OK, 'error%status')
      call nsdae_system_destroy(system)
      call nsdae_system_destroy(system)
    end do
  end subroutine

  ! A setter gave this; whether the system has such a term.
  subroutine was(status, system, name, has)
    integer(c_int), intent(in) :: status
    type(nsdae_system), intent(in) :: system
    character(len=*), intent(in) :: name
    logical, intent(in) :: has
    type(nsdae_error) :: error
    call is_int(status, merge(NSDAE_OK, NSDAE_E_ARGUMENT, has), name)
    error = nsdae_system_error(system)
    call is_text(error%argument, merge(name, repeat(' ', len(name)), .not. has), 'error%argument')
  end subroutine

  subroutine setters(dims, constraints, gaps, tangents, slides)
    type(nsdae_dims), intent(in) :: dims
    logical, intent(in) :: constraints, gaps, tangents, slides
    type(nsdae_system) :: s
    call is_int(nsdae_system_create(dims, s), NSDAE_OK, 'create')
    call was(nsdae_system_set_mass(s, mass), s, 'mass', .true.)
    call was(nsdae_system_set_force(s, force), s, 'force', .true.)
    call was(nsdae_system_set_constraint(s, constraint), s, 'constraint', constraints)
    call was(nsdae_system_set_constraint_jacobian(s, jacobian), s, 'constraint_jacobian', &
             constraints)
    call was(nsdae_system_set_constraint_bias(s, bias), s, 'constraint_bias', constraints)
    call was(nsdae_system_set_gap(s, gap), s, 'gap', gaps)
    call was(nsdae_system_set_gap_normal(s, normal), s, 'gap_normal', gaps)
    call was(nsdae_system_set_gap_tangent(s, tangent), s, 'gap_tangent', tangents)
    call was(nsdae_system_set_contact_bias(s, contact_bias), s, 'contact_bias', gaps)
    call was(nsdae_system_set_frictional_joint_tangent(s, slide), s, 'frictional_joint_tangent', slides)
    call was(nsdae_system_set_joint_friction_bound(s, bound), s, 'joint_friction_bound', slides)
    call was(nsdae_system_set_kinematics(s, kinematics), s, 'kinematics', .true.)
    call nsdae_system_destroy(s)
    call is_int(nsdae_system_set_mass(s, mass), NSDAE_E_ARGUMENT, 'no system')
    call is_int(nsdae_system_set_gap_normal(s, normal), NSDAE_E_ARGUMENT, 'no system')
  end subroutine

  subroutine all_setters()
    call setters(nsdae_dims(nq=4), .false., .false., .false., .false.)
    call setters(nsdae_dims(nq=4, nt=2), .false., .false., .false., .false.)
    call setters(nsdae_dims(nq=4, m=2), .true., .false., .false., .false.)
    call setters(nsdae_dims(nq=4, m=2, f=1), .true., .false., .false., .true.)
    call setters(nsdae_dims(nq=4, k=1), .false., .true., .false., .false.)
    call setters(nsdae_dims(nq=4, k=1, nt=1), .false., .true., .true., .false.)
    call setters(nsdae_dims(nq=4, m=2, k=1, nt=2, f=2), .true., .true., .true., .true.)
  end subroutine

  subroutine coefficients()
    type(nsdae_system) :: s
    call is_int(nsdae_system_create(nsdae_dims(nq=2, k=2, nt=1), s), NSDAE_OK, 'create')
    call contact(s, 0, 0d0, 0d0, 0d0, '')
    call contact(s, 1, 100d0, 1d0, 1d0, '')
    call contact(s, -1, 0d0, 0d0, 0d0, 'i')
    call contact(s, 2, 0d0, 0d0, 0d0, 'i')
    call contact(s, 0, -1d-300, 0d0, 0d0, 'mu')
    call contact(s, 0, nan, 0d0, 0d0, 'mu')
    call contact(s, 0, infinity, 0d0, 0d0, 'mu')
    call contact(s, 0, 0d0, -0.1d0, 0d0, 'e_n')
    call contact(s, 0, 0d0, 1.0000001d0, 0d0, 'e_n')
    call contact(s, 0, 0d0, nan, 0d0, 'e_n')
    call contact(s, 0, 0d0, 0d0, -0.1d0, 'e_t')
    call contact(s, 0, 0d0, 0d0, 1.1d0, 'e_t')
    call contact(s, 0, 0d0, 0d0, nan, 'e_t')
    call nsdae_system_destroy(s)
    call is_int(nsdae_system_set_contact(s, 0, 0d0, 0d0, 0d0), NSDAE_E_ARGUMENT, 'no system')
  end subroutine

  subroutine contact(s, i, mu, e_n, e_t, wrong)
    type(nsdae_system), intent(in) :: s
    integer(c_int), intent(in) :: i
    real(c_double), intent(in) :: mu, e_n, e_t
    character(len=*), intent(in) :: wrong
    type(nsdae_error) :: error
    call is_int(nsdae_system_set_contact(s, i, mu, e_n, e_t), &
                merge(NSDAE_OK, NSDAE_E_ARGUMENT, wrong == ''), 'contact')
    error = nsdae_system_error(s)
    call is_text(error%argument, wrong, 'error%argument')
  end subroutine

  subroutine slides()
    type(nsdae_system) :: s
    call is_int(nsdae_system_create(nsdae_dims(nq=3, m=2, f=1), s), NSDAE_OK, 'create')
    call one_slide(s, 0, 1, 0.3d0, '')
    call one_slide(s, 1, 0, 0.3d0, 'j')
    call one_slide(s, -1, 0, 0.3d0, 'j')
    call one_slide(s, 0, 2, 0.3d0, 'constraint')
    call one_slide(s, 0, -1, 0.3d0, 'constraint')
    call one_slide(s, 0, 0, -0.1d0, 'mu')
    call one_slide(s, 0, 0, nan, 'mu')
    call one_slide(s, 0, 0, infinity, 'mu')
    call is_int(nsdae_system_set_friction_bound(s, 0, 0d0), NSDAE_OK, 'bound')
    call is_int(nsdae_system_set_friction_bound(s, 0, -1d0), NSDAE_E_ARGUMENT, 'bound < 0')
    call is_int(nsdae_system_set_friction_bound(s, 1, 1d0), NSDAE_E_ARGUMENT, 'no such joint')
    call is_int(nsdae_system_set_friction_circle(s, 0, 0, 2, 0d0), NSDAE_OK, 'circle')
    call is_int(nsdae_system_set_friction_circle(s, 0, 1, 2, 0d0), NSDAE_E_ARGUMENT, 'circle: rows')
    call nsdae_system_destroy(s)
    call is_int(nsdae_system_set_frictional_joint(s, 0, 0, 0d0), NSDAE_E_ARGUMENT, 'no system')
  end subroutine

  subroutine one_slide(s, j, constraint, mu, wrong)
    type(nsdae_system), intent(in) :: s
    integer(c_int), intent(in) :: j, constraint
    real(c_double), intent(in) :: mu
    character(len=*), intent(in) :: wrong
    type(nsdae_error) :: error
    call is_int(nsdae_system_set_frictional_joint(s, j, constraint, mu), &
                merge(NSDAE_OK, NSDAE_E_ARGUMENT, wrong == ''), 'slide')
    error = nsdae_system_error(s)
    call is_text(error%argument, wrong, 'error%argument')
  end subroutine

  ! All callbacks that are needed but one, 1 .. 7: that one is named. 0: all are there.
  subroutine without(number, name)
    integer, intent(in) :: number
    character(len=*), intent(in) :: name
    type(nsdae_system) :: s
    type(nsdae_sim) :: sim
    type(nsdae_error) :: error
    integer(c_int) :: status(9)
    status = NSDAE_OK
    status(1) = nsdae_system_create(nsdae_dims(nq=4, nv=3, m=2, k=2, nt=1, f=1), s)
    status(2) = nsdae_system_set_contact(s, 0, 0.1d0, 0d0, 0d0)
    if (number /= 1) status(3) = nsdae_system_set_mass(s, mass)
    if (number /= 2) status(4) = nsdae_system_set_force(s, force)
    if (number /= 3) status(5) = nsdae_system_set_constraint(s, constraint)
    if (number /= 4) status(6) = nsdae_system_set_gap(s, gap)
    if (number /= 5) status(7) = nsdae_system_set_gap_tangent(s, tangent)
    if (number /= 6) status(8) = nsdae_system_set_frictional_joint_tangent(s, slide)
    if (number /= 7) status(9) = nsdae_system_set_kinematics(s, kinematics)
    call is_true(all(status == NSDAE_OK), 'setters')
    call is_int(nsdae_system_set_frictional_joint(s, 0, 0, 0.1d0), NSDAE_OK, 'slide')
    if (number == 0) then
      call is_int(nsdae_sim_create(s, sim, error=error), NSDAE_E_STATE, 'a contact not told of')
      call contains_text(error%text, 'nsdae_system_set_contact', 'what to call')
    end if
    call is_int(nsdae_system_set_contact(s, 1, 0d0, 0d0, 0d0), NSDAE_OK, 'the other contact')
    call is_int(nsdae_system_set_size(s, NSDAE_NAME_CONTACT, 1, 0.1d0), NSDAE_OK, 'a size')
    call is_int(nsdae_sim_create(s, sim, error=error), &
                merge(NSDAE_OK, NSDAE_E_STATE, number == 0), 'without ' // name)
    call is_text(error%argument, name, 'error%argument')
    call contains_text(error%text, name, 'error%text')
    call nsdae_sim_destroy(sim)
    call nsdae_system_destroy(s)
  end subroutine

  subroutine missing_callbacks()
    call without(0, '')
    call without(1, 'mass')
    call without(2, 'force')
    call without(3, 'constraint')
    call without(4, 'gap')
    call without(5, 'gap_tangent')
    call without(6, 'frictional_joint_tangent')
    call without(7, 'kinematics')
  end subroutine

  subroutine differences_text()
    type(nsdae_system) :: s
    call is_text(nsdae_system_differences(s), '', 'no system')
    call is_int(nsdae_system_create(PLANAR, s), NSDAE_OK, 'create')
    call is_text(nsdae_system_differences(s), 'constraint_jacobian constraint_bias gap_normal ' // &
                 'contact_bias contact_acceleration', 'nothing given')
    call is_int(nsdae_system_set_constraint_jacobian(s, jacobian), NSDAE_OK, 'set')
    call is_int(nsdae_system_set_contact_bias(s, contact_bias), NSDAE_OK, 'set')
    call is_text(nsdae_system_differences(s), 'constraint_bias gap_normal contact_acceleration', &
                 'two given')
    call is_int(nsdae_system_set_constraint_bias(s, bias), NSDAE_OK, 'set')
    call is_int(nsdae_system_set_gap_normal(s, normal), NSDAE_OK, 'set')
    call is_int(nsdae_system_set_contact_acceleration(s, acceleration), NSDAE_OK, 'set')
    call is_text(nsdae_system_differences(s), '', 'all given')
    call nsdae_system_destroy(s)
  end subroutine

end program
