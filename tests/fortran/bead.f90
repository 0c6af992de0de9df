! The twin of tests/support/bead.c: a bead on a moving parabola above a rising floor, whose every
! callback can be made to fail.
module bead_model
  use nsdae
  implicit none

  integer, parameter :: TERMS = 10
  integer, parameter :: MASS_ = 1, FORCE_ = 2, CONSTRAINT_ = 3, JACOBIAN_ = 4, BIAS_ = 5, &
                        GAP_ = 6, NORMAL_ = 7, TANGENT_ = 8, CONTACT_BIAS_ = 9, POTENTIAL_ = 10
  character(len=20), parameter :: NAMES(TERMS) = [character(len=20) :: 'mass', 'force', &
      'constraint', 'constraint_jacobian', 'constraint_bias', 'gap', 'gap_normal', 'gap_tangent', &
      'contact_bias', 'potential']

  type :: bead
    real(c_double) :: speed = 0.3d0, floor_speed = 0.05d0  ! of the parabola, of the floor
    ! faults: in the call of that number (from 0) of that term
    integer :: term = 0, at = 0
    integer(c_int) :: code = 0       ! what the callback returns
    real(c_double) :: value = 0      ! written to its first entry where code is 0
    real(c_double) :: mass_scale = 1
    logical :: repeated = .false.    ! the constraint stands twice (m = 2)
    integer :: calls(TERMS) = 0
  end type

contains

  function bead_of(user) result(b)
    class(*), target, intent(in) :: user
    type(bead), pointer :: b
    b => null()
    select type (user)
    type is (bead)
      b => user
    end select
  end function

  ! Counts the call and spoils it where that is asked for.
  integer(c_int) function spoil(b, term, first) result(status)
    type(bead), intent(inout) :: b
    integer, intent(in) :: term
    real(c_double), intent(inout) :: first
    integer :: number
    status = 0
    number = b%calls(term)
    b%calls(term) = number + 1
    if (number /= b%at .or. b%term /= term) return
    if (b%code == 0) first = b%value
    status = b%code
  end function

  integer(c_int) function mass(t, q, M, user)
    real(c_double), intent(in) :: t, q(:)
    real(c_double), intent(inout) :: M(:, :)
    class(*), intent(inout) :: user
    type(bead), pointer :: b
    b => bead_of(user)
    M(1, 1) = 2 * b%mass_scale
    M(2, 2) = 2 * b%mass_scale
    M(3, 3) = 1 + 0.1d0 * sin(q(3))
    mass = spoil(b, MASS_, M(1, 1))
  end function

  integer(c_int) function force(t, q, v, F, user)
    real(c_double), intent(in) :: t, q(:), v(:)
    real(c_double), intent(inout) :: F(:)
    class(*), intent(inout) :: user
    F(2) = -2 * 9.81d0
    F(3) = -q(3) - 0.05d0 * cos(q(3)) * v(3) * v(3)
    force = spoil(bead_of(user), FORCE_, F(1))
  end function

  ! The parabola moves to the right: Phi = y - (x - s t)^2.
  integer(c_int) function constraint(t, q, phi, user)
    real(c_double), intent(in) :: t, q(:)
    real(c_double), intent(inout) :: phi(:)
    class(*), intent(inout) :: user
    type(bead), pointer :: b
    real(c_double) :: u
    b => bead_of(user)
    u = q(1) - b%speed * t
    phi(1) = q(2) - u * u
    if (b%repeated) phi(2) = 2 * phi(1)
    constraint = spoil(b, CONSTRAINT_, phi(1))
  end function

  integer(c_int) function jacobian(t, q, J, user)
    real(c_double), intent(in) :: t, q(:)
    real(c_double), intent(inout) :: J(:, :)
    class(*), intent(inout) :: user
    type(bead), pointer :: b
    b => bead_of(user)
    J(1, 1) = -2 * (q(1) - b%speed * t)
    J(1, 2) = 1
    if (b%repeated) J(2, 1:2) = 2 * J(1, 1:2)
    jacobian = spoil(b, JACOBIAN_, J(1, 1))
  end function

  ! Phi_t = 2 u s, omega = -2 (v_x - s)^2.
  integer(c_int) function bias(t, q, v, phi_t, omega, user)
    real(c_double), intent(in) :: t, q(:), v(:)
    real(c_double), intent(inout) :: phi_t(:), omega(:)
    class(*), intent(inout) :: user
    type(bead), pointer :: b
    b => bead_of(user)
    phi_t(1) = 2 * (q(1) - b%speed * t) * b%speed
    omega(1) = -2 * (v(1) - b%speed) * (v(1) - b%speed)
    if (b%repeated) phi_t(2) = 2 * phi_t(1)
    if (b%repeated) omega(2) = 2 * omega(1)
    bias = spoil(b, BIAS_, phi_t(1))
  end function

  ! The floor rises and is wavy: g = y - 0.2 - r t - 0.05 sin x.
  integer(c_int) function gap(t, q, g, user)
    real(c_double), intent(in) :: t, q(:)
    real(c_double), intent(inout) :: g(:)
    class(*), intent(inout) :: user
    type(bead), pointer :: b
    b => bead_of(user)
    g(1) = q(2) - 0.2d0 - b%floor_speed * t - 0.05d0 * sin(q(1))
    gap = spoil(b, GAP_, g(1))
  end function

  integer(c_int) function normal(t, q, W, user)
    real(c_double), intent(in) :: t, q(:)
    real(c_double), intent(inout) :: W(:, :)
    class(*), intent(inout) :: user
    W(1, 1) = -0.05d0 * cos(q(1))
    W(2, 1) = 1
    normal = spoil(bead_of(user), NORMAL_, W(1, 1))
  end function

  integer(c_int) function tangent(t, q, W, user)
    real(c_double), intent(in) :: t, q(:)
    real(c_double), intent(inout) :: W(:, :)
    class(*), intent(inout) :: user
    W(1, 1) = 1
    W(3, 1) = 0.1d0
    tangent = spoil(bead_of(user), TANGENT_, W(1, 1))
  end function

  integer(c_int) function contact_bias(t, q, w_n, w_t, user)
    real(c_double), intent(in) :: t, q(:)
    real(c_double), intent(inout) :: w_n(:), w_t(:)
    class(*), intent(inout) :: user
    type(bead), pointer :: b
    b => bead_of(user)
    w_n(1) = -b%floor_speed
    w_t(1) = 0
    contact_bias = spoil(b, CONTACT_BIAS_, w_n(1))
  end function

  ! g_N'' = W_N^T v' + 0.05 sin x x'^2; the direction of W_T is constant.
  integer(c_int) function contact_acceleration(t, q, v, omega_n, omega_t, omega_s, user) &
      result(status)
    real(c_double), intent(in) :: t, q(:), v(:)
    real(c_double), intent(inout) :: omega_n(:), omega_t(:), omega_s(:)
    class(*), intent(inout) :: user
    omega_n(1) = 0.05d0 * sin(q(1)) * v(1) * v(1)
    omega_t(1) = 0
    status = 0
  end function

  integer(c_int) function potential(t, q, energy, user)
    real(c_double), intent(in) :: t, q(:)
    real(c_double), intent(inout) :: energy
    class(*), intent(inout) :: user
    energy = 2 * 9.81d0 * q(2) + q(3) * q(3) / 2
    potential = spoil(bead_of(user), POTENTIAL_, energy)
  end function

  ! q = [x, y, theta], m = 1 (or 2), k = 1, nt = 1. The least of the statuses.
  integer(c_int) function bead_system(b, system) result(status)
    type(bead), target, intent(inout) :: b
    type(nsdae_system), intent(out) :: system
    status = nsdae_system_create(nsdae_dims(nq=3, m=merge(2, 1, b%repeated), k=1, nt=1), system)
    if (status < 0) return
    status = min(nsdae_system_set_user(system, b), &
                 nsdae_system_set_mass(system, mass), &
                 nsdae_system_set_force(system, force), &
                 nsdae_system_set_constraint(system, constraint), &
                 nsdae_system_set_constraint_jacobian(system, jacobian), &
                 nsdae_system_set_constraint_bias(system, bias), &
                 nsdae_system_set_gap(system, gap), &
                 nsdae_system_set_gap_normal(system, normal), &
                 nsdae_system_set_gap_tangent(system, tangent), &
                 nsdae_system_set_contact_bias(system, contact_bias), &
                 nsdae_system_set_contact_acceleration(system, contact_acceleration), &
                 nsdae_system_set_potential(system, potential), &
                 nsdae_system_set_contact(system, 0, 0.2d0, 0.5d0, 0d0))
  end function

  ! A state on the constraint, above the floor.
  subroutine bead_start(b, q0, v0)
    type(bead), intent(in) :: b
    real(c_double), intent(out) :: q0(3), v0(3)
    q0 = [1d0, 1d0, 0.3d0]
    v0 = [0d0, -2 * b%speed, 0d0]  ! y' = 2 u (x' - s)
  end subroutine

end module
