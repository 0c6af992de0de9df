! The twin of tests/unit/system/planar.h, where the model is described: a planar body with nonlinear
! constraints and gaps that depend on time, and derivatives by hand.
module planar_model
  use nsdae
  implicit none

  real(c_double), parameter :: ARM = 0.4d0
  type(nsdae_dims), parameter :: PLANAR = nsdae_dims(nq=4, nv=3, m=2, k=2, nt=1)

  ! What is wrong: `amount` is added to an entry of a term, `code` is returned by it.
  type :: fault
    character(len=24) :: term = ''
    integer :: entry = 0  ! from 0, down the columns
    real(c_double) :: amount = 0
    integer(c_int) :: code = 0
  end type

contains

  integer(c_int) function spoil(user, term, a) result(code)
    class(*), intent(in) :: user
    character(len=*), intent(in) :: term
    real(c_double), intent(inout) :: a(:)
    code = 0
    select type (wrong => user)
    type is (fault)
      if (wrong%term /= term) return
      a(wrong%entry + 1) = a(wrong%entry + 1) + wrong%amount
      code = wrong%code
    end select
  end function

  integer(c_int) function spoil_matrix(user, term, A) result(code)
    class(*), intent(in) :: user
    character(len=*), intent(in) :: term
    real(c_double), intent(inout) :: A(:, :)
    real(c_double) :: flat(size(A))
    flat = reshape(A, [size(A)])
    code = spoil(user, term, flat)
    A = reshape(flat, shape(A))
  end function

  integer(c_int) function kinematics(t, q, v, qdot, user)
    real(c_double), intent(in) :: t, q(:), v(:)
    real(c_double), intent(inout) :: qdot(:)
    class(*), intent(inout) :: user
    qdot = [v(1), v(2), -q(4) * v(3), q(3) * v(3)]
    kinematics = spoil(user, 'kinematics', qdot)
  end function

  integer(c_int) function mass(t, q, M, user)
    real(c_double), intent(in) :: t, q(:)
    real(c_double), intent(inout) :: M(:, :)
    class(*), intent(inout) :: user
    M(1, 1) = 2
    M(2, 2) = 3
    M(3, 3) = 0.5d0 + 0.1d0 * q(3)
    M(3, 1) = -0.3d0 * q(4)
    M(1, 3) = M(3, 1)
    mass = spoil_matrix(user, 'mass', M)
  end function

  integer(c_int) function force(t, q, v, F, user)
    real(c_double), intent(in) :: t, q(:), v(:)
    real(c_double), intent(inout) :: F(:)
    class(*), intent(inout) :: user
    F(2) = -9.81d0 - 0.1d0 * v(2)
    force = spoil(user, 'force', F)
  end function

  ! -dF/dv, and -(dF/dq) H = 0
  integer(c_int) function damping(t, q, v, D, user)
    real(c_double), intent(in) :: t, q(:), v(:)
    real(c_double), intent(inout) :: D(:, :)
    class(*), intent(inout) :: user
    D(2, 2) = 0.1d0
    damping = spoil_matrix(user, 'force_damping', D)
  end function

  integer(c_int) function stiffness(t, q, v, K, user)
    real(c_double), intent(in) :: t, q(:), v(:)
    real(c_double), intent(inout) :: K(:, :)
    class(*), intent(inout) :: user
    stiffness = spoil_matrix(user, 'force_stiffness', K)
  end function

  integer(c_int) function constraint(t, q, phi, user)
    real(c_double), intent(in) :: t, q(:)
    real(c_double), intent(inout) :: phi(:)
    class(*), intent(inout) :: user
    real(c_double) :: X, Y
    X = q(1) + ARM * q(3) - sin(t)
    Y = q(2) + ARM * q(4)
    phi(1) = X * X + 2 * Y * Y - 1 - t / 10
    phi(2) = q(1) * q(3) + q(2) * q(4) + q(2) * sin(t)
    constraint = spoil(user, 'constraint', phi)
  end function

  integer(c_int) function jacobian(t, q, J, user)
    real(c_double), intent(in) :: t, q(:)
    real(c_double), intent(inout) :: J(:, :)
    class(*), intent(inout) :: user
    real(c_double) :: X, Y
    X = q(1) + ARM * q(3) - sin(t)
    Y = q(2) + ARM * q(4)
    J(1, :) = [2 * X, 4 * Y, ARM * (4 * Y * q(3) - 2 * X * q(4))]
    J(2, :) = [q(3), q(4) + sin(t), q(2) * q(3) - q(1) * q(4)]
    jacobian = spoil_matrix(user, 'constraint_jacobian', J)
  end function

  integer(c_int) function bias(t, q, v, phi_t, omega, user)
    real(c_double), intent(in) :: t, q(:), v(:)
    real(c_double), intent(inout) :: phi_t(:), omega(:)
    class(*), intent(inout) :: user
    real(c_double) :: X(0:2), Y(0:2)  ! with first and second derivatives, v constant
    associate (c => q(3), s => q(4), w => v(3))
      X = [q(1) + ARM * c - sin(t), v(1) - ARM * s * w - cos(t), -ARM * c * w * w + sin(t)]
      Y = [q(2) + ARM * s, v(2) + ARM * c * w, -ARM * s * w * w]
      phi_t = [-2 * X(0) * cos(t) - 0.1d0, q(2) * cos(t)]
      omega(1) = 2 * X(1) * X(1) + 2 * X(0) * X(2) + 4 * Y(1) * Y(1) + 4 * Y(0) * Y(2)
      omega(2) = 2 * w * (v(2) * c - v(1) * s) - w * w * (q(1) * c + q(2) * s) &
                 + 2 * v(2) * cos(t) - q(2) * sin(t)
    end associate
    bias = spoil(user, 'constraint_bias phi_t', phi_t)
    if (bias == 0) bias = spoil(user, 'constraint_bias omega', omega)
  end function

  integer(c_int) function gap(t, q, g, user)
    real(c_double), intent(in) :: t, q(:)
    real(c_double), intent(inout) :: g(:)
    class(*), intent(inout) :: user
    real(c_double) :: X, Y
    X = q(1) + ARM * q(3)
    Y = q(2) + ARM * q(4)
    g = [3 - cos(t) - X - Y * Y / 10, Y - sin(X) / 5 + t * t / 2]
    gap = spoil(user, 'gap', g)
  end function

  integer(c_int) function normal(t, q, W, user)
    real(c_double), intent(in) :: t, q(:)
    real(c_double), intent(inout) :: W(:, :)
    class(*), intent(inout) :: user
    real(c_double) :: X, Y
    X = q(1) + ARM * q(3)
    Y = q(2) + ARM * q(4)
    W(:, 1) = [-1d0, -Y / 5, ARM * q(4) - ARM * q(3) * Y / 5]
    W(:, 2) = [-cos(X) / 5, 1d0, ARM * q(3) + ARM * q(4) * cos(X) / 5]
    normal = spoil_matrix(user, 'gap_normal', W)
  end function

  integer(c_int) function tangent(t, q, W, user)
    real(c_double), intent(in) :: t, q(:)
    real(c_double), intent(inout) :: W(:, :)
    class(*), intent(inout) :: user
    W(:, 1) = [0d0, 1d0, ARM * q(3)]
    W(:, 2) = [1d0, 0d0, -ARM * q(4)]
    tangent = spoil_matrix(user, 'gap_tangent', W)
  end function

  integer(c_int) function contact_bias(t, q, w_n, w_t, user)
    real(c_double), intent(in) :: t, q(:)
    real(c_double), intent(inout) :: w_n(:), w_t(:)
    class(*), intent(inout) :: user
    w_n = [sin(t), t]
    w_t(2) = 0.1d0 * t
    contact_bias = spoil(user, 'contact_bias w_n', w_n)
  end function

  integer(c_int) function acceleration(t, q, v, omega_n, omega_t, omega_s, user)
    real(c_double), intent(in) :: t, q(:), v(:)
    real(c_double), intent(inout) :: omega_n(:), omega_t(:), omega_s(:)
    class(*), intent(inout) :: user
    real(c_double) :: X(0:2), Y(0:2)
    associate (c => q(3), s => q(4), w => v(3))
      X = [q(1) + ARM * c, v(1) - ARM * s * w, -ARM * c * w * w]
      Y = [q(2) + ARM * s, v(2) + ARM * c * w, -ARM * s * w * w]
    end associate
    omega_n(1) = cos(t) - X(2) - (Y(1) * Y(1) + Y(0) * Y(2)) / 5
    omega_n(2) = Y(2) + (sin(X(0)) * X(1) * X(1) - cos(X(0)) * X(2)) / 5 + 1
    omega_t = [Y(2), X(2) + 0.1d0]
    acceleration = spoil(user, 'contact_acceleration', omega_n)
  end function

  integer(c_int) function bound(t, q, v, b, user)
    real(c_double), intent(in) :: t, q(:), v(:)
    real(c_double), intent(inout) :: b(:)
    class(*), intent(inout) :: user
    b = 1
    bound = 0
  end function

  integer(c_int) function slide(t, q, W, w_s, user)
    real(c_double), intent(in) :: t, q(:)
    real(c_double), intent(inout) :: W(:, :), w_s(:)
    class(*), intent(inout) :: user
    W(1, :) = 1
    w_s = 1
    slide = 0
  end function

  ! What is needed, and with `all` every derivative.
  subroutine planar_system(wrong, all, system, status)
    type(fault), target, intent(inout) :: wrong
    logical, intent(in) :: all
    type(nsdae_system), intent(out) :: system
    integer(c_int), intent(out) :: status(15)
    status = NSDAE_OK
    status(1) = nsdae_system_create(PLANAR, system)
    status(2) = nsdae_system_set_user(system, wrong)
    status(3) = nsdae_system_set_kinematics(system, kinematics)
    status(4) = nsdae_system_set_mass(system, mass)
    status(5) = nsdae_system_set_force(system, force)
    status(6) = nsdae_system_set_constraint(system, constraint)
    status(7) = nsdae_system_set_gap(system, gap)
    if (.not. all) return
    status(8) = nsdae_system_set_constraint_jacobian(system, jacobian)
    status(9) = nsdae_system_set_constraint_bias(system, bias)
    status(10) = nsdae_system_set_gap_normal(system, normal)
    status(11) = nsdae_system_set_gap_tangent(system, tangent)
    status(12) = nsdae_system_set_contact_bias(system, contact_bias)
    status(13) = nsdae_system_set_contact_acceleration(system, acceleration)
    status(14) = nsdae_system_set_force_damping(system, damping)
    status(15) = nsdae_system_set_force_stiffness(system, stiffness)
  end subroutine

  ! A point of the kind that a run meets, the i-th of many.
  subroutine planar_point(i, t, q, v)
    integer, intent(in) :: i
    real(c_double), intent(out) :: t, q(4), v(3)
    t = 0.3d0 * mod(i, 7)
    q = [2 * sin(1.1d0 * i), 1.5d0 * cos(1.7d0 * i), cos(0.7d0 * i), sin(0.7d0 * i)]
    v = [3 * cos(0.9d0 * i), 2 * sin(2.3d0 * i), 4 * sin(0.5d0 * i + 1)]
  end subroutine

end module
