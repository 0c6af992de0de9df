! A uniform rod that swings about one end and hits a stop where it hangs (Zhang, Gu and Sun,
! section 4.1). q = [x, y, theta]: its centre and its angle from the vertical.
!
!   M = diag(m, m, m L^2/12),  F = [0, -m g, 0]
!   Phi = [x - (L/2) sin theta, y + (L/2) cos theta],  g_N = L sin theta
!
! The twin of drivers/models/pendulum.c, operation by operation: the same bytes come out.
module pendulum_model
  use nsdae
  implicit none
  private
  public :: pendulum, pendulum_parameters, pendulum_build, pendulum_start, pendulum_exact

  type :: pendulum
    real(c_double) :: L, m, g, e_N, theta_0
  end type

contains

  ! The variable behind user.
  function pendulum_of(user) result(p)
    class(*), target, intent(in) :: user
    type(pendulum), pointer :: p
    p => null()
    select type (user)
    type is (pendulum)
      p => user
    end select
  end function

  integer(c_int) function mass(t, q, M, user) result(status)
    real(c_double), intent(in) :: t, q(:)
    real(c_double), intent(inout) :: M(:, :)
    class(*), intent(inout) :: user
    type(pendulum), pointer :: p
    p => pendulum_of(user)
    M(1, 1) = p%m
    M(2, 2) = p%m
    M(3, 3) = p%m * p%L * p%L / 12
    status = 0
  end function

  integer(c_int) function force(t, q, v, F, user) result(status)
    real(c_double), intent(in) :: t, q(:), v(:)
    real(c_double), intent(inout) :: F(:)
    class(*), intent(inout) :: user
    type(pendulum), pointer :: p
    p => pendulum_of(user)
    F(2) = -p%m * p%g
    status = 0
  end function

  integer(c_int) function constraint(t, q, phi, user) result(status)
    real(c_double), intent(in) :: t, q(:)
    real(c_double), intent(inout) :: phi(:)
    class(*), intent(inout) :: user
    type(pendulum), pointer :: p
    p => pendulum_of(user)
    phi(1) = q(1) - p%L / 2 * sin(q(3))
    phi(2) = q(2) + p%L / 2 * cos(q(3))
    status = 0
  end function

  integer(c_int) function constraint_jacobian(t, q, J, user) result(status)
    real(c_double), intent(in) :: t, q(:)
    real(c_double), intent(inout) :: J(:, :)
    class(*), intent(inout) :: user
    type(pendulum), pointer :: p
    p => pendulum_of(user)
    J(1, 1) = 1
    J(2, 2) = 1
    J(1, 3) = -p%L / 2 * cos(q(3))
    J(2, 3) = -p%L / 2 * sin(q(3))
    status = 0
  end function

  integer(c_int) function constraint_bias(t, q, v, phi_t, omega, user) result(status)
    real(c_double), intent(in) :: t, q(:), v(:)
    real(c_double), intent(inout) :: phi_t(:), omega(:)
    class(*), intent(inout) :: user
    type(pendulum), pointer :: p
    p => pendulum_of(user)
    omega(1) = p%L / 2 * sin(q(3)) * v(3) * v(3)
    omega(2) = -p%L / 2 * cos(q(3)) * v(3) * v(3)
    status = 0
  end function

  integer(c_int) function gap(t, q, g, user) result(status)
    real(c_double), intent(in) :: t, q(:)
    real(c_double), intent(inout) :: g(:)
    class(*), intent(inout) :: user
    type(pendulum), pointer :: p
    p => pendulum_of(user)
    g(1) = p%L * sin(q(3))
    status = 0
  end function

  integer(c_int) function gap_normal(t, q, W, user) result(status)
    real(c_double), intent(in) :: t, q(:)
    real(c_double), intent(inout) :: W(:, :)
    class(*), intent(inout) :: user
    type(pendulum), pointer :: p
    p => pendulum_of(user)
    W(3, 1) = p%L * cos(q(3))
    status = 0
  end function

  integer(c_int) function contact_bias(t, q, w_n, w_t, user) result(status)
    real(c_double), intent(in) :: t, q(:)
    real(c_double), intent(inout) :: w_n(:), w_t(:)
    class(*), intent(inout) :: user
    w_n(1) = 0
    status = 0
  end function

  integer(c_int) function potential(t, q, energy, user) result(status)
    real(c_double), intent(in) :: t, q(:)
    real(c_double), intent(inout) :: energy
    class(*), intent(inout) :: user
    type(pendulum), pointer :: p
    p => pendulum_of(user)
    energy = p%m * p%g * q(2)
    status = 0
  end function

  ! The table of the parameters of p, which gets its defaults.
  integer(c_int) function pendulum_parameters(p, table) result(status)
    type(pendulum), target, intent(inout) :: p
    type(nsdae_params), intent(out) :: table
    real(c_double), parameter :: pi = 3.1415926535897931d0
    integer(c_int), parameter :: between = NSDAE_OPEN_MIN + NSDAE_OPEN_MAX
    status = nsdae_params_add(table, p%L, 'L', 'm', 'length of the rod', 1d0, 0d0, &
                              open=NSDAE_OPEN_MIN)
    if (status == NSDAE_OK) &
        status = nsdae_params_add(table, p%m, 'm', 'kg', 'mass of the rod', 4.9d0, 0d0, &
                                  open=NSDAE_OPEN_MIN)
    if (status == NSDAE_OK) &
        status = nsdae_params_add(table, p%g, 'g', 'm/s^2', 'gravity', 9.8d0, 0d0, &
                                  open=NSDAE_OPEN_MIN)
    if (status == NSDAE_OK) &
        status = nsdae_params_add(table, p%e_N, 'e_N', '1', 'restitution at the stop', 0.56d0, &
                                  0d0, 1d0)
    if (status == NSDAE_OK) &
        status = nsdae_params_add(table, p%theta_0, 'theta_0', 'rad', &
                                  'angle at the start, from the vertical, at rest', 1.57d0, 0d0, &
                                  pi, between)
    if (status == NSDAE_OK) call nsdae_params_default(table)
  end function

  integer(c_int) function pendulum_build(p, system, error) result(status)
    type(pendulum), target, intent(inout) :: p
    type(nsdae_system), intent(out) :: system
    type(nsdae_error), intent(out) :: error
    status = nsdae_system_create(nsdae_dims(nq=3, m=2, k=1), system, error)
    if (status < 0) return
    status = nsdae_system_set_user(system, p)
    status = nsdae_system_set_name(system, NSDAE_NAME_COORDINATE, 0, 'x', 'm')
    status = nsdae_system_set_name(system, NSDAE_NAME_COORDINATE, 1, 'y', 'm')
    status = nsdae_system_set_name(system, NSDAE_NAME_COORDINATE, 2, 'theta', 'rad')
    status = nsdae_system_set_name(system, NSDAE_NAME_CONSTRAINT, 0, 'pivot_x', 'm')
    status = nsdae_system_set_name(system, NSDAE_NAME_CONSTRAINT, 1, 'pivot_y', 'm')
    status = nsdae_system_set_name(system, NSDAE_NAME_CONTACT, 0, 'stop', 'm')
    status = nsdae_system_set_mass(system, mass)
    status = nsdae_system_set_force(system, force)
    status = nsdae_system_set_constraint(system, constraint)
    status = nsdae_system_set_constraint_jacobian(system, constraint_jacobian)
    status = nsdae_system_set_constraint_bias(system, constraint_bias)
    status = nsdae_system_set_gap(system, gap)
    status = nsdae_system_set_gap_normal(system, gap_normal)
    status = nsdae_system_set_contact_bias(system, contact_bias)
    status = nsdae_system_set_potential(system, potential)
    status = nsdae_system_set_contact(system, 0, 0d0, p%e_N, 0d0)
    if (status < 0) error = nsdae_system_error(system)
  end function

  subroutine pendulum_start(p, q0, v0)
    type(pendulum), intent(in) :: p
    real(c_double), intent(out) :: q0(3), v0(3)
    q0 = [p%L / 2 * sin(p%theta_0), -p%L / 2 * cos(p%theta_0), p%theta_0]
    v0 = 0
  end subroutine

  ! Impact of that number from 1. theta'' = -(3 g / 2 L) sin theta: a swing of amplitude theta_m
  ! from rest to the stop takes sqrt(2 L / 3 g) K(k), k = sin(theta_m / 2) (Landau and Lifshitz,
  ! Mechanics, section 11); it arrives with omega = k sqrt(6 g / L) and leaves with e_N omega, so
  ! with the amplitude e_N k. The impulse at the tip is (m L^2 / 3) (1 + e_N) omega / L.
  logical function pendulum_exact(p, number, time, impulse) result(known)
    type(pendulum), intent(in) :: p
    integer, intent(in) :: number
    real(c_double), intent(out) :: time, impulse
    real(c_double) :: quarter, k
    integer :: i
    quarter = sqrt(2 * p%L / (3 * p%g))
    k = sin(p%theta_0 / 2)
    time = quarter * elliptic_K(k)
    do i = 2, number
      k = k * p%e_N
      time = time + 2 * quarter * elliptic_K(k)
    end do
    impulse = p%m * p%L / 3 * (1 + p%e_N) * k * sqrt(6 * p%g / p%L)
    known = k > 0
  end function

  ! K(k) = pi / (2 agm(1, sqrt(1 - k^2))) (Gauss; Abramowitz and Stegun, 17.6). The means converge
  ! quadratically: seven steps are enough for every k below 1 - 1e-16.
  pure real(c_double) function elliptic_K(k)
    real(c_double), intent(in) :: k
    real(c_double) :: a, b, mean
    integer :: i
    a = 1
    b = sqrt((1 - k) * (1 + k))
    do i = 1, 7
      mean = (a + b) / 2
      b = sqrt(a * b)
      a = mean
    end do
    elliptic_K = acos(-1d0) / (2 * a)
  end function

end module
