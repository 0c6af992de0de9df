! What a simulation takes between steps: a run to its next event, the state inside the last step, other
! options and coefficients, a user of its own; a start that is put right. Free fall and a block in a slot, whose
! motion is known.
program between
  use, intrinsic :: iso_c_binding
  use nsdae
  use check
  implicit none

  type :: world
    real(c_double) :: g = 10
  end type

  call events
  call inside
  call options
  call own_user
  call slot
  call put_right
  call check_done

contains

  integer(c_int) function mass(t, q, M, user)
    real(c_double), intent(in) :: t, q(:)
    real(c_double), intent(inout) :: M(:, :)
    class(*), intent(inout) :: user
    integer :: i
    do i = 1, size(q)
      M(i, i) = 1
    end do
    mass = 0
  end function

  ! Gravity along the last coordinate, and 5 N along the one before it.
  integer(c_int) function force(t, q, v, F, user)
    real(c_double), intent(in) :: t, q(:), v(:)
    real(c_double), intent(inout) :: F(:)
    class(*), intent(inout) :: user
    if (size(q) > 1) F(1) = 5
    select type (user)
    type is (world)
      F(size(q)) = -user%g
    end select
    force = 0
  end function

  integer(c_int) function gap(t, q, g, user)
    real(c_double), intent(in) :: t, q(:)
    real(c_double), intent(inout) :: g(:)
    class(*), intent(inout) :: user
    g(1) = q(1)
    gap = 0
  end function

  integer(c_int) function constraint(t, q, phi, user)
    real(c_double), intent(in) :: t, q(:)
    real(c_double), intent(inout) :: phi(:)
    class(*), intent(inout) :: user
    phi(1) = q(2)
    constraint = 0
  end function

  integer(c_int) function slide(t, q, W, w_s, user)
    real(c_double), intent(in) :: t, q(:)
    real(c_double), intent(inout) :: W(:, :), w_s(:)
    class(*), intent(inout) :: user
    W(1, 1) = 1
    slide = 0
  end function

  subroutine make_ball(w, system, sim)
    type(world), target, intent(inout) :: w
    type(nsdae_system), intent(out) :: system
    type(nsdae_sim), intent(out) :: sim
    type(nsdae_sim_options) :: with
    call is_int(nsdae_system_create(nsdae_dims(nq=1, k=1), system), NSDAE_OK, 'system')
    call is_int(nsdae_system_set_user(system, w), NSDAE_OK, 'user')
    call is_int(nsdae_system_set_mass(system, mass), NSDAE_OK, 'mass')
    call is_int(nsdae_system_set_force(system, force), NSDAE_OK, 'force')
    call is_int(nsdae_system_set_gap(system, gap), NSDAE_OK, 'gap')
    call is_int(nsdae_system_set_contact(system, 0, 0d0, 0.5d0, 0d0), NSDAE_OK, 'contact')
    call nsdae_sim_options_default(with)
    with%method = NSDAE_METHOD_MOREAU
    with%dt = 0.01d0
    call is_int(nsdae_sim_create(system, sim, with), NSDAE_OK, 'sim')
    call is_int(nsdae_sim_init(sim, 0d0, [1d0], [0d0]), NSDAE_OK, 'init')
  end subroutine

  function now(sim) result(record)
    type(nsdae_sim), intent(in) :: sim
    type(nsdae_record) :: record
    call is_int(nsdae_sim_get_record(sim, record), NSDAE_OK, 'record')
  end function

  subroutine release(system, sim)
    type(nsdae_system), intent(inout) :: system
    type(nsdae_sim), intent(inout) :: sim
    call nsdae_sim_destroy(sim)
    call nsdae_system_destroy(system)
  end subroutine

  ! From 1 m the ball is down after sqrt(2 / g) = 0.447 s; without restitution it stays there.
  subroutine events()
    type(world), target :: w
    type(nsdae_system) :: system
    type(nsdae_sim) :: sim
    type(nsdae_record) :: record
    call make_ball(w, system, sim)
    call is_int(nsdae_sim_run_to_event(sim, 3d0), NSDAE_EVENT, 'the first impact')
    record = now(sim)
    call is_near(record%time, sqrt(2 / w%g), 0.02d0, 'its time')
    call is_true(record%v(1) > 2, 'it rebounds')
    call is_int(nsdae_sim_set_contact(sim, 1, 0d0, 0d0, 0d0), NSDAE_E_ARGUMENT, 'no such contact')
    call is_int(nsdae_sim_set_contact(sim, 0, 0d0, 0d0, 0d0), NSDAE_OK, 'e_n = 0')
    call is_int(nsdae_sim_run_to_event(sim, 3d0), NSDAE_EVENT, 'the second impact')
    record = now(sim)
    call is_near(record%v(1), 0d0, 1d-12, 'it does not rebound')
    call is_int(nsdae_sim_run_to_event(sim, 1.2d0), NSDAE_OK, 'no impact any more')
    record = now(sim)
    call is_true(record%time == 1.2d0 .or. record%impacts > 0, 'to the end')
    call release(system, sim)
  end subroutine

  ! q = 1 - g t^2 / 2 is what the parabola through the ends of a step gives, v = -g t the line.
  subroutine inside()
    type(world), target :: w
    type(nsdae_system) :: system
    type(nsdae_sim) :: sim
    real(c_double) :: q(1), v(1), short(0)
    call make_ball(w, system, sim)
    call is_int(nsdae_sim_interpolate(sim, 0d0, q, v), NSDAE_E_STATE, 'before the first step')
    call is_int(nsdae_sim_run(sim, 0.2d0), NSDAE_OK, 'run')
    call is_int(nsdae_sim_interpolate(sim, 0.193d0, q, v), NSDAE_OK, 'interpolate')
    call is_near(q(1), 1 - w%g * 0.193d0**2 / 2, 1d-12, 'q')
    call is_near(v(1), -w%g * 0.193d0, 1d-12, 'v')
    call is_int(nsdae_sim_interpolate(sim, 0.1d0, q, v), NSDAE_E_ARGUMENT, 'an earlier step')
    call is_int(nsdae_sim_interpolate(sim, 0.193d0, short, v), NSDAE_E_ARGUMENT, 'q is too short')
    call release(system, sim)
  end subroutine

  subroutine options()
    type(world), target :: w
    type(nsdae_system) :: system
    type(nsdae_sim) :: sim
    type(nsdae_sim_options) :: with
    type(nsdae_record) :: record
    type(nsdae_error) :: error
    call make_ball(w, system, sim)
    call is_int(nsdae_sim_run(sim, 0.1d0), NSDAE_OK, 'run')
    call is_int(nsdae_sim_get_options(sim, with), NSDAE_OK, 'get')
    with%dt = 0.04d0
    call is_int(nsdae_sim_set_options(sim, with), NSDAE_OK, 'another dt')
    call is_int(nsdae_sim_step(sim), NSDAE_OK, 'step')
    record = now(sim)
    call is_near(record%time, 0.14d0, 1d-15, 'its end')
    call is_near(record%duration, 0.04d0, 1d-15, 'its length')
    call is_near(record%q(1), 1 - w%g * 0.14d0**2 / 2, 1d-12, 'q')
    with%method = NSDAE_METHOD_IMPLICIT
    call is_int(nsdae_sim_set_options(sim, with), NSDAE_E_ARGUMENT, 'another method')
    error = nsdae_sim_error(sim)
    call is_text(error%argument, 'method', 'argument')
    call release(system, sim)
  end subroutine

  ! Two simulations of one system, one of them on the moon.
  subroutine own_user()
    type(world), target :: w, moon
    type(nsdae_system) :: system
    type(nsdae_sim) :: sim, other
    type(nsdae_sim_options) :: with
    type(nsdae_record) :: record
    call make_ball(w, system, sim)
    call is_int(nsdae_sim_get_options(sim, with), NSDAE_OK, 'get')
    call is_int(nsdae_sim_create(system, other, with), NSDAE_OK, 'another one')
    moon%g = 2
    call is_int(nsdae_sim_set_user(other, moon), NSDAE_OK, 'set')
    call is_int(nsdae_sim_init(other, 0d0, [1d0], [0d0]), NSDAE_OK, 'init')
    call is_int(nsdae_sim_run(sim, 0.3d0), NSDAE_OK, 'run')
    call is_int(nsdae_sim_run(other, 0.3d0), NSDAE_OK, 'run')
    record = now(sim)
    call is_near(record%q(1), 1 - 10 * 0.3d0**2 / 2, 1d-12, 'of the system')
    record = now(other)
    call is_near(record%q(1), 1 - 2 * 0.3d0**2 / 2, 1d-12, 'of its own')
    call nsdae_sim_destroy(other)
    call release(system, sim)
  end subroutine

  ! A block of weight 10 N in a slot, drawn with 5 N: v' = 5 - 10 mu.
  subroutine slot()
    type(world), target :: w
    type(nsdae_system) :: system
    type(nsdae_sim) :: sim
    type(nsdae_sim_options) :: with
    type(nsdae_record) :: record
    call is_int(nsdae_system_create(nsdae_dims(nq=2, m=1, f=1), system), NSDAE_OK, 'system')
    call is_int(nsdae_system_set_user(system, w), NSDAE_OK, 'user')
    call is_int(nsdae_system_set_mass(system, mass), NSDAE_OK, 'mass')
    call is_int(nsdae_system_set_force(system, force), NSDAE_OK, 'force')
    call is_int(nsdae_system_set_constraint(system, constraint), NSDAE_OK, 'constraint')
    call is_int(nsdae_system_set_frictional_joint_tangent(system, slide), NSDAE_OK, 'slide')
    call is_int(nsdae_system_set_frictional_joint(system, 0, 0, 0.2d0), NSDAE_OK, 'mu')
    call is_int(nsdae_system_set_friction_bound(system, 0, 0d0), NSDAE_OK, 'bound')
    call nsdae_sim_options_default(with)
    with%method = NSDAE_METHOD_MOREAU
    with%dt = 0.01d0
    call is_int(nsdae_sim_create(system, sim, with), NSDAE_OK, 'sim')
    call is_int(nsdae_sim_init(sim, 0d0, [0d0, 0d0], [0d0, 0d0]), NSDAE_OK, 'init')
    call is_int(nsdae_sim_run(sim, 0.1d0), NSDAE_OK, 'run')
    record = now(sim)
    call is_near(record%v(1), 0.3d0, 1d-9, 'with mu = 0.2')
    call is_int(nsdae_sim_set_frictional_joint(sim, 0, 0.4d0), NSDAE_OK, 'mu = 0.4')
    call is_int(nsdae_sim_run(sim, 0.2d0), NSDAE_OK, 'run')
    record = now(sim)
    call is_near(record%v(1), 0.4d0, 1d-9, 'with mu = 0.4')
    call is_int(nsdae_sim_set_frictional_joint(sim, 1, 0.4d0), NSDAE_E_ARGUMENT, 'no such frictional joint')
    call is_int(nsdae_sim_set_frictional_joint(sim, 0, -1d0), NSDAE_E_ARGUMENT, 'mu < 0')
    call is_int(nsdae_sim_set_friction_bound(sim, 0, 2d0), NSDAE_OK, 'bound = 2')
    call is_int(nsdae_sim_run(sim, 0.3d0), NSDAE_OK, 'run')
    record = now(sim)
    call is_near(record%v(1), 0.3d0, 1d-9, 'with mu = 0.4 and bound = 2')
    call is_int(nsdae_sim_set_friction_bound(sim, 1, 2d0), NSDAE_E_ARGUMENT, 'no such frictional joint')
    call is_int(nsdae_sim_set_friction_bound(sim, 0, -1d0), NSDAE_E_ARGUMENT, 'bound < 0')
    call release(system, sim)
  end subroutine

  subroutine put_right()
    type(world), target :: w
    type(nsdae_system) :: system
    type(nsdae_sim) :: sim
    real(c_double) :: q(1), v(1), long(2)
    call make_ball(w, system, sim)
    q = -0.3d0
    v = 1
    call is_int(nsdae_sim_project(sim, 0d0, q, v), NSDAE_OK, 'project')
    call is_near(q(1), 0d0, 1d-9, 'on the floor')
    call is_near(v(1), 1d0, 1d-9, 'what leaves it, leaves')
    q = 0.7d0
    call is_int(nsdae_sim_project(sim, 0d0, q, v), NSDAE_OK, 'nothing to do')
    call is_near(q(1), 0.7d0, 0d0, 'as it was')
    call is_int(nsdae_sim_project(sim, 0d0, long, v), NSDAE_E_ARGUMENT, 'q0 is too long')
    call release(system, sim)
  end subroutine

end program
