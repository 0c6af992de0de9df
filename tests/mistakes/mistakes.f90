! The mistakes of docs/guide/mistakes.md in Fortran: see mistakes.c.
module mistakes_model
  use nsdae
  use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
  implicit none

  enum, bind(C)
    enumerator :: CONTACT_OFF_BY_ONE = 1, RESTITUTION_ABOVE_ONE, FRICTION_WITHOUT_DIRECTION, &
        SLIDE_OF_NO_CONSTRAINT, CHANGED_WHILE_IT_RUNS, GAP_FORGOTTEN, KINEMATICS_FORGOTTEN, &
        ONE_TRIANGLE, MASS_LEFT_OUT, SIGN_OF_NORMAL, SIGN_IN_JACOBIAN, TERM_OF_OMEGA_LOST, &
        INDEX_BEYOND, ENTRY_NEVER_SET, NORMAL_AS_TANGENT, INIT_FORGOTTEN, START_IN_THE_STOP, &
        DEGREES, VELOCITY_OFF, DIVISION_BY_ZERO, RETURNS_A_COUNT, CONSTRAINT_TWICE, &
        METHOD_MISSPELT, OPTIONS_NOT_SET, COEFFICIENTS_FORGOTTEN, SIGN_OF_WALL, &
        TANGENT_LEFT_OUT, TANGENT_TWICE, ARM_LEFT_OUT, SIGN_OF_ARM, MILLIMETRES
  end enum

  type :: wrong
    integer :: w = 0
  end type

contains

  integer function mistake(user)
    class(*), intent(in) :: user
    mistake = 0
    select type (user)
    type is (wrong)
      mistake = user%w
    end select
  end function

  integer(c_int) function mass(t, q, M, user) result(status)
    real(c_double), intent(in) :: t, q(:)
    real(c_double), intent(inout) :: M(:, :)
    class(*), intent(inout) :: user
    integer :: w
    w = mistake(user)
    M(1, 1) = 1
    M(2, 2) = 1
    if (w /= MASS_LEFT_OUT) M(3, 3) = 1d0 / 12
    if (w == ONE_TRIANGLE) M(1, 3) = 0.1d0
    status = 0
  end function

  integer(c_int) function force(t, q, v, F, user) result(status)
    real(c_double), intent(in) :: t, q(:), v(:)
    real(c_double), intent(inout) :: F(:)
    class(*), intent(inout) :: user
    F(2) = -9.81d0
    if (mistake(user) == DIVISION_BY_ZERO .and. t > 0.1d0) F(3) = ieee_value(0d0, ieee_quiet_nan)
    status = merge(3, 0, mistake(user) == RETURNS_A_COUNT)
  end function

  integer(c_int) function constraint(t, q, phi, user) result(status)
    real(c_double), intent(in) :: t, q(:)
    real(c_double), intent(inout) :: phi(:)
    class(*), intent(inout) :: user
    integer :: w
    w = mistake(user)
    phi(1) = q(1) - sin(q(3)) / 2
    if (w == CONSTRAINT_TWICE) then
      phi(2) = 2 * phi(1)
    else if (w /= ENTRY_NEVER_SET) then
      phi(2) = q(2) + cos(q(3)) / 2
    end if
    status = 0
  end function

  integer(c_int) function jacobian(t, q, J, user) result(status)
    real(c_double), intent(in) :: t, q(:)
    real(c_double), intent(inout) :: J(:, :)
    class(*), intent(inout) :: user
    integer :: w
    w = mistake(user)
    J(1, :) = [1d0, 0d0, -cos(q(3)) / 2]
    J(2, :) = [0d0, 1d0, -sin(q(3)) / 2]
    if (w == SIGN_IN_JACOBIAN) J(2, 3) = -J(2, 3)
    if (w == CONSTRAINT_TWICE) J(2, :) = 2 * J(1, :)
    status = 0
  end function

  integer(c_int) function bias(t, q, v, phi_t, omega, user) result(status)
    real(c_double), intent(in) :: t, q(:), v(:)
    real(c_double), intent(inout) :: phi_t(:), omega(:)
    class(*), intent(inout) :: user
    integer :: w
    w = mistake(user)
    omega(1) = sin(q(3)) / 2 * v(3) * v(3)
    omega(2) = -cos(q(3)) / 2 * v(3) * v(3)
    if (w == CONSTRAINT_TWICE) omega(2) = 2 * omega(1)
    if (w == TERM_OF_OMEGA_LOST) omega(2) = 0
    status = 0
  end function

  ! The array has its shape, so that -fcheck=bounds finds an index beyond it; here it is not compiled in.
  integer(c_int) function gap(t, q, g, user) result(status)
    real(c_double), intent(in) :: t, q(:)
    real(c_double), intent(inout) :: g(:)
    class(*), intent(inout) :: user
    g(merge(2, 1, mistake(user) == INDEX_BEYOND)) = &
        sin(q(3)) + merge(0.1d0, 0d0, mistake(user) == SIGN_OF_WALL) * t
    status = 0
  end function

  integer(c_int) function wall(t, q, w_n, w_t, user) result(status)
    real(c_double), intent(in) :: t, q(:)
    real(c_double), intent(inout) :: w_n(:), w_t(:)
    class(*), intent(inout) :: user
    w_n(1) = -0.1d0
    status = 0
  end function

  integer(c_int) function normal(t, q, W, user) result(status)
    real(c_double), intent(in) :: t, q(:)
    real(c_double), intent(inout) :: W(:, :)
    class(*), intent(inout) :: user
    W(3, 1) = cos(q(3))
    if (mistake(user) == SIGN_OF_NORMAL) W(3, 1) = -W(3, 1)
    status = 0
  end function

  integer(c_int) function tangent(t, q, W, user) result(status)
    real(c_double), intent(in) :: t, q(:)
    real(c_double), intent(inout) :: W(:, :)
    class(*), intent(inout) :: user
    if (mistake(user) == NORMAL_AS_TANGENT) then
      status = normal(t, q, W, user)
    else
      if (mistake(user) /= TANGENT_LEFT_OUT) W(1, 1) = 1
      status = 0
    end if
  end function

  integer(c_int) function ends(t, q, g, user) result(status)
    real(c_double), intent(in) :: t, q(:)
    real(c_double), intent(inout) :: g(:)
    class(*), intent(inout) :: user
    g = merge(1d3, 1d0, mistake(user) == MILLIMETRES) * (q(2) + [-0.5d0, 0.5d0] * cos(q(3)))
    status = 0
  end function

  integer(c_int) function ends_tangent(t, q, W, user) result(status)
    real(c_double), intent(in) :: t, q(:)
    real(c_double), intent(inout) :: W(:, :)
    class(*), intent(inout) :: user
    W(1, :) = 1
    W(3, :) = [0.5d0, -0.5d0] * cos(q(3))
    if (mistake(user) == TANGENT_TWICE) W = 2 * W
    if (mistake(user) == ARM_LEFT_OUT) W(3, 1) = 0
    if (mistake(user) == SIGN_OF_ARM) W(3, 2) = -W(3, 2)
    status = 0
  end function

  subroutine describe_falling(user, system)
    type(wrong), target, intent(inout) :: user
    type(nsdae_system), intent(out) :: system
    integer(c_int) :: status
    integer :: i
    status = nsdae_system_create(nsdae_dims(nq=3, nv=3, m=0, k=2, nt=1, f=0), system)
    status = nsdae_system_set_user(system, user)
    status = nsdae_system_set_mass(system, mass)
    status = nsdae_system_set_force(system, force)
    status = nsdae_system_set_gap(system, ends)
    status = nsdae_system_set_gap_tangent(system, ends_tangent)
    do i = 0, 1
      status = nsdae_system_set_contact(system, i, 0.3d0, 0.5d0, 0d0)
    end do
    status = nsdae_system_set_name(system, NSDAE_NAME_COORDINATE, 0, 'x', 'm')
    status = nsdae_system_set_name(system, NSDAE_NAME_COORDINATE, 2, 'theta', 'rad')
    status = nsdae_system_set_name(system, NSDAE_NAME_CONTACT, 0, 'foot', 'm')
    status = nsdae_system_set_name(system, NSDAE_NAME_CONTACT, 1, 'head', 'm')
  end subroutine

  subroutine describe(user, system)
    type(wrong), target, intent(inout) :: user
    type(nsdae_system), intent(out) :: system
    integer(c_int) :: status
    integer :: w
    w = user%w
    status = nsdae_system_create( &
        nsdae_dims(nq=3, nv=merge(2, 3, w == KINEMATICS_FORGOTTEN), m=2, k=1, &
                   nt=merge(0, 1, w == FRICTION_WITHOUT_DIRECTION), &
                   f=merge(1, 0, w == SLIDE_OF_NO_CONSTRAINT)), system)
    status = nsdae_system_set_user(system, user)
    status = nsdae_system_set_mass(system, mass)
    status = nsdae_system_set_force(system, force)
    status = nsdae_system_set_constraint(system, constraint)
    status = nsdae_system_set_constraint_jacobian(system, jacobian)
    status = nsdae_system_set_constraint_bias(system, bias)
    if (w /= GAP_FORGOTTEN) status = nsdae_system_set_gap(system, gap)
    status = nsdae_system_set_gap_normal(system, normal)
    if (w /= FRICTION_WITHOUT_DIRECTION) status = nsdae_system_set_gap_tangent(system, tangent)
    if (w == SIGN_OF_WALL) status = nsdae_system_set_contact_bias(system, wall)
    if (w /= COEFFICIENTS_FORGOTTEN) &
        status = nsdae_system_set_contact(system, merge(1, 0, w == CONTACT_OFF_BY_ONE), 0.3d0, &
                                          merge(1.5d0, 0.5d0, w == RESTITUTION_ABOVE_ONE), 0d0)
    if (w == SLIDE_OF_NO_CONSTRAINT) status = nsdae_system_set_frictional_joint(system, 0, 2, 0.1d0)
    status = nsdae_system_set_name(system, NSDAE_NAME_COORDINATE, 2, 'theta', 'rad')
    status = nsdae_system_set_name(system, NSDAE_NAME_CONSTRAINT, 1, 'pivot_y', 'm')
    status = nsdae_system_set_name(system, NSDAE_NAME_CONTACT, 0, 'stop', 'm')
  end subroutine

  ! What fails first of a run with that mistake.
  integer(c_int) function run(w, system, error) result(status)
    integer, intent(in) :: w
    type(nsdae_system), intent(in) :: system
    type(nsdae_error), intent(out) :: error
    type(nsdae_sim) :: sim
    type(nsdae_sim_options) :: options
    real(c_double) :: theta, q0(3)
    if (w /= OPTIONS_NOT_SET) call nsdae_sim_options_default(options)
    if (w == METHOD_MISSPELT) then
      status = nsdae_sim_options_set(options, 'method', 'implict', error)
    else
      status = nsdae_sim_create(system, sim, options, error)
    end if
    if (status < 0) return
    if (w == CHANGED_WHILE_IT_RUNS) then
      status = nsdae_system_set_contact(system, 0, 0.6d0, 0.5d0, 0d0)
      error = nsdae_system_error(system)
    else
      theta = merge(-0.1d0, 0.7d0, w == START_IN_THE_STOP)
      q0 = [sin(theta) / 2, -cos(theta) / 2, merge(40d0, theta, w == DEGREES)]
      if (w /= INIT_FORGOTTEN) &
          status = nsdae_sim_init(sim, 0d0, q0, [0d0, 0d0, merge(1d0, 0d0, w == VELOCITY_OFF)])
      if (status >= 0) status = nsdae_sim_run(sim, 0.5d0)
      error = nsdae_sim_error(sim)
    end if
    call nsdae_sim_destroy(sim)
  end function

  subroutine make(w, checked)
    integer, intent(in) :: w
    logical, intent(in) :: checked
    type(wrong), target, save :: user
    type(nsdae_system) :: system
    type(nsdae_error) :: error
    character(len=:), allocatable :: unseen
    integer(c_int) :: status
    user%w = w
    if (w < TANGENT_TWICE) then
      call describe(user, system)
    else
      call describe_falling(user, system)
    end if
    status = NSDAE_OK
    if (checked .and. ((w >= SIGN_OF_NORMAL .and. w <= NORMAL_AS_TANGENT) .or. &
                       w >= TANGENT_TWICE)) then
      status = nsdae_system_check(system, 0d0, [0.3d0, -0.4d0, 0.7d0], [0.5d0, 0.6d0, -0.8d0], &
                                  1d-5)
      error = nsdae_system_error(system)
    end if
    if (w < ARM_LEFT_OUT) then
      if (status == NSDAE_OK) status = run(w, system, error)
      print '(a, ": ", a)', nsdae_status_name(status), trim(error%text)
    else
      unseen = nsdae_system_unseen(system)  ! what is doubted is the last of it
      print '(a)', 'doubted: ' // unseen(index(unseen, ';', back=.true.) + 2:)
    end if
    call nsdae_system_destroy(system)
  end subroutine

end module

program mistakes
  use mistakes_model
  implicit none
  integer :: w
  do w = 1, MILLIMETRES
    call make(w, .true.)
  end do
  do w = SIGN_OF_NORMAL, NORMAL_AS_TANGENT  ! without the check
    call make(w, .false.)
  end do
end program
