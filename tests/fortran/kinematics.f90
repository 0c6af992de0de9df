! A wheel that turns: its orientation is the unit vector (c, s), so nq = 3, nv = 2.
module wheel_model
  use nsdae
  implicit none

  type :: wheel
    integer :: calls = 0, at = -1    ! the call, from 0, that goes wrong
    integer(c_int) :: code = 0       ! what it returns
    real(c_double) :: value = 0      ! written to qdot(2) where code is 0
  end type

contains

  integer(c_int) function mass(t, q, M, user)
    real(c_double), intent(in) :: t, q(:)
    real(c_double), intent(inout) :: M(:, :)
    class(*), intent(inout) :: user
    M(1, 1) = 2
    M(2, 2) = 0.1d0
    mass = 0
  end function

  integer(c_int) function force(t, q, v, F, user)
    real(c_double), intent(in) :: t, q(:), v(:)
    real(c_double), intent(inout) :: F(:)
    class(*), intent(inout) :: user
    F = [-0.1d0 * v(1), -0.01d0 * v(2)]
    force = 0
  end function

  integer(c_int) function kinematics(t, q, v, qdot, user)
    real(c_double), intent(in) :: t, q(:), v(:)
    real(c_double), intent(inout) :: qdot(:)
    class(*), intent(inout) :: user
    qdot = [v(1), -q(3) * v(2), q(2) * v(2)]
    kinematics = 0
    select type (w => user)
    type is (wheel)
      if (w%calls == w%at .and. w%code == 0) qdot(2) = w%value
      if (w%calls == w%at) kinematics = w%code
      w%calls = w%calls + 1
    end select
  end function

end module

! The twin of tests/anomaly/kinematics.c: a kinematics callback that fails or gives NaN in the middle
! of a run is named, and the state is the one before.
program kinematic
  use, intrinsic :: ieee_arithmetic
  use nsdae
  use wheel_model
  use check
  implicit none
  real(c_double), parameter :: START_Q(3) = [0d0, 1d0, 0d0], START_V(2) = [1d0, 3d0]
  real(c_double) :: nan
  integer(c_int) :: method
  integer :: at

  nan = ieee_value(nan, ieee_quiet_nan)
  method = 0
  do while (nsdae_method_name(method) /= '')
    do at = 50, 52
      call fails(method, wheel(at=at, code=-2))
      call fails(method, wheel(at=at, code=2))
      call fails(method, wheel(at=at, value=merge(ieee_value(nan, ieee_positive_inf), nan, at == 51)))
    end do
    method = method + 1
  end do
  call is_true(method >= 5, 'methods')
  call check_done

contains

  subroutine fails(method, wrong)
    integer(c_int), intent(in) :: method
    type(wheel), intent(in) :: wrong
    type(wheel), target :: w
    type(nsdae_system) :: system
    type(nsdae_sim) :: sim
    type(nsdae_sim_options) :: options
    integer(c_int) :: status
    w = wrong
    call is_int(nsdae_system_create(nsdae_dims(nq=3, nv=2), system), NSDAE_OK, 'create')
    call is_int(nsdae_system_set_user(system, w), NSDAE_OK, 'user')
    call is_int(nsdae_system_set_mass(system, mass), NSDAE_OK, 'mass')
    call is_int(nsdae_system_set_force(system, force), NSDAE_OK, 'force')
    call is_int(nsdae_system_set_kinematics(system, kinematics), NSDAE_OK, 'kinematics')
    call nsdae_sim_options_default(options)
    options%method = method
    options%dt = 0.01d0
    status = nsdae_sim_create(system, sim, options)
    if (status /= NSDAE_E_UNSUPPORTED) then  ! built without SUNDIALS
      call is_int(status, NSDAE_OK, 'nsdae_sim_create')
      call run_into_it(sim, method, wrong)
    end if
    call nsdae_sim_destroy(sim)
    call nsdae_system_destroy(system)
  end subroutine

  subroutine run_into_it(sim, method, wrong)
    type(nsdae_sim), intent(in) :: sim
    integer(c_int), intent(in) :: method
    type(wheel), intent(in) :: wrong
    type(nsdae_record) :: now
    type(nsdae_error) :: error
    real(c_double) :: q(3), v(2)
    integer(c_int) :: status
    integer(c_long) :: step
    integer :: i
    call is_int(nsdae_sim_init(sim, 0d0, START_Q, START_V), NSDAE_OK, 'init')
    do i = 1, 300
      status = nsdae_sim_get_record(sim, now)
      q = now%q
      v = now%v
      step = now%step
      status = nsdae_sim_step(sim)
      if (status < 0) exit
    end do
    if (method >= NSDAE_METHOD_PENALTY .and. wrong%code >= 0 .and. status >= 0) then
      call is_near(norm2(q(2:)), 1d0, 1d-2, 'smaller steps got around it')
      return
    end if
    call is_int(status, merge(NSDAE_E_NONFINITE, NSDAE_E_CALLBACK, wrong%code == 0), &
                nsdae_method_name(method))
    error = nsdae_sim_error(sim)
    call is_text(error%argument, 'kinematics', 'error%argument')
    call is_int(error%code, wrong%code, 'error%code')
    call is_true(ieee_is_finite(error%time), 'error%time')
    call is_int(nsdae_sim_get_record(sim, now), NSDAE_OK, 'record')
    call is_true(now%step == step .and. all(now%q == q) .and. all(now%v == v), 'the state before')
    call is_int(nsdae_sim_init(sim, 0d0, START_Q, START_V), NSDAE_OK, 'init again')
    call is_int(nsdae_sim_run(sim, 1d0), NSDAE_OK, 'run again')
  end subroutine

end program
