! What the library calls: module procedures, so that no compiler needs trampolines.
module observer_of_pendulum
  use nsdae
  use pendulum_model
  implicit none

  type :: history
    type(pendulum) :: model
    integer :: impacts = 0
    type(nsdae_impact) :: impact(64)
    real(c_double) :: theta = 0, omega = 0, residual = 0, energy = 0
    real(c_double) :: gain = -huge(0d0)  ! worst growth of the energy over a step with an impact
    type(nsdae_stats) :: stats
  end type

contains

  integer(c_int) function observe(record, error, user) result(status)
    type(nsdae_record), intent(in) :: record
    type(nsdae_error), intent(inout) :: error
    class(*), intent(inout) :: user
    real(c_double) :: L, energy
    integer :: i
    status = 0
    energy = record%kinetic + record%potential
    select type (user)
    type is (history)
      do i = 1, min(record%impacts, 64 - user%impacts)
        user%impacts = user%impacts + 1
        user%impact(user%impacts) = record%impact(i)
      end do
      if (record%impacts > 0) user%gain = max(user%gain, energy - user%energy)
      user%energy = energy
      user%theta = record%q(3)
      user%omega = record%v(3)
      ! max |Phi_q v|, Phi_q written out
      L = user%model%L
      user%residual = max(user%residual, &
                          abs(record%v(1) - L / 2 * cos(record%q(3)) * record%v(3)), &
                          abs(record%v(2) - L / 2 * sin(record%q(3)) * record%v(3)))
    end select
  end function

end module

! The twin of tests/system/pendulum.c: the model in Fortran against its exact solution.
program pendulum_test
  use nsdae
  use pendulum_model
  use observer_of_pendulum
  use check
  implicit none

  integer(c_int), parameter :: METHODS = 3

  call closed_form
  call moreau_published
  call impulse_order
  call smooth_order
  call drift
  call impact_energy
  call newton_law
  call check_done

contains

  ! The parameters' defaults.
  subroutine defaults(p)
    type(pendulum), target, intent(out) :: p
    type(nsdae_params) :: table
    call is_int(pendulum_parameters(p, table), NSDAE_OK, 'parameters')
    call nsdae_params_destroy(table)
  end subroutine

  subroutine integrate(p, method, dt, t_end, h)
    type(pendulum), target, intent(inout) :: p
    integer(c_int), intent(in) :: method
    real(c_double), intent(in) :: dt, t_end
    type(history), target, intent(out) :: h
    type(nsdae_system) :: system
    type(nsdae_sim) :: sim
    type(nsdae_sim_options) :: options
    type(nsdae_error) :: error
    real(c_double) :: q0(3), v0(3)
    call nsdae_sim_options_default(options)
    options%method = method
    options%dt = dt
    h%model = p
    call is_int(pendulum_build(p, system, error), NSDAE_OK, 'build')
    call pendulum_start(p, q0, v0)
    call is_int(nsdae_sim_create(system, sim, options), NSDAE_OK, 'create')
    call is_int(nsdae_sim_init(sim, 0d0, q0, v0), NSDAE_OK, 'init')
    call is_int(nsdae_sim_observe(sim, observe, h), NSDAE_OK, 'observe')
    call is_int(nsdae_sim_run(sim, t_end), NSDAE_OK, 'run')
    call is_int(nsdae_sim_get_stats(sim, h%stats), NSDAE_OK, 'stats')
    call nsdae_sim_destroy(sim)
    call nsdae_system_destroy(system)
  end subroutine

  ! The closed form against the table of data/, which was made by another program. It has 15
  ! digits; a sum of eight times and the means of K add a few roundings to that.
  subroutine closed_form()
    type(pendulum) :: p
    character(len=256) :: path, line
    real(c_double) :: time, impulse, exact_time, exact_impulse, skipped
    integer :: file, ended, number, rows
    call defaults(p)
    call get_command_argument(1, path)
    open (newunit=file, file=trim(path) // '/pendulum_impacts.csv', status='old', action='read')
    rows = 0
    do
      read (file, '(a)', iostat=ended) line
      if (ended /= 0) exit
      read (line, *, iostat=ended) number, time, skipped, skipped, impulse
      if (ended /= 0) cycle
      call is_true(pendulum_exact(p, number, exact_time, exact_impulse), 'exact')
      call is_near(exact_time, time, 2d-14 * time, 'time')
      call is_near(exact_impulse, impulse, 1d-14 * 16, 'impulse')
      rows = rows + 1
    end do
    close (file)
    call is_int(rows, 8, 'rows')
  end subroutine

  ! Values of an independent program for Moreau's rule at dt 0.005, given to 4 decimals.
  subroutine moreau_published()
    real(c_double), parameter :: impulse(3) = [13.6877d0, 7.6258d0, 4.2631d0]
    real(c_double), parameter :: time(3) = [0.490d0, 1.350d0, 2.185d0]
    type(pendulum), target :: p
    type(history), target :: h
    integer :: i
    call defaults(p)
    call integrate(p, NSDAE_METHOD_MOREAU, 0.005d0, 2.5d0, h)
    call is_int(h%impacts, 3, 'impacts')
    do i = 1, 3
      call is_near(h%impact(i)%normal_impulse, impulse(i), 0.5d-4, 'impulse')
      call is_near(h%impact(i)%time, time(i), 1d-12, 'time')
    end do
  end subroutine

  ! Mean over eleven steps around dt of the worst relative error of the first three impulses: an
  ! impact is found up to a step late, at a place that jumps with dt.
  real(c_double) function mean_impulse_error(p, method, dt) result(mean)
    type(pendulum), target, intent(inout) :: p
    integer(c_int), intent(in) :: method
    real(c_double), intent(in) :: dt
    type(history), target :: h
    real(c_double) :: worst, time, impulse
    integer :: i, j
    mean = 0
    do i = 0, 10
      call integrate(p, method, dt * (0.9d0 + 0.02d0 * i), 2.5d0, h)
      call is_true(h%impacts >= 3, 'three impacts')
      worst = 0
      do j = 1, 3
        call is_true(pendulum_exact(p, j, time, impulse), 'exact')
        worst = max(worst, abs(h%impact(j)%normal_impulse / impulse - 1))
      end do
      mean = mean + worst / 11
    end do
  end function

  ! Order 1 or better, as in the test in C, with its bounds.
  subroutine impulse_order()
    type(pendulum), target :: p
    integer(c_int) :: method
    real(c_double) :: coarse, fine
    call defaults(p)
    do method = 0, METHODS - 1
      coarse = mean_impulse_error(p, method, 0.008d0)
      fine = mean_impulse_error(p, method, 0.001d0)
      call is_true(fine <= coarse / 6, 'order of the impulses')
      call is_true(fine <= 4 * 0.001d0, 'error of the impulses')
    end do
  end subroutine

  ! theta(t) and omega(t) before the first impact: with w^2 = 3 g / 2 L, theta is that of a
  ! mathematical pendulum. An independent method: the classical Runge-Kutta solution
  ! with steps of 10 us, whose error, of order (w h)^4, is far below rounding.
  subroutine swing(p, t, theta, omega)
    type(pendulum), intent(in) :: p
    real(c_double), intent(in) :: t
    real(c_double), intent(out) :: theta, omega
    real(c_double) :: y(2), k1(2), k2(2), k3(2), k4(2), h
    integer :: i, n
    n = nint(t / 1d-5)
    h = t / n
    y = [p%theta_0, 0d0]
    do i = 1, n
      k1 = rate(p, y)
      k2 = rate(p, y + h / 2 * k1)
      k3 = rate(p, y + h / 2 * k2)
      k4 = rate(p, y + h * k3)
      y = y + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    end do
    theta = y(1)
    omega = y(2)
  end subroutine

  pure function rate(p, y)
    type(pendulum), intent(in) :: p
    real(c_double), intent(in) :: y(2)
    real(c_double) :: rate(2)
    rate = [y(2), -3 * p%g / (2 * p%L) * sin(y(1))]
  end function

  real(c_double) function swing_error(p, method, dt)
    type(pendulum), target, intent(inout) :: p
    integer(c_int), intent(in) :: method
    real(c_double), intent(in) :: dt
    type(history), target :: h
    real(c_double) :: theta, omega
    call integrate(p, method, dt, 0.44d0, h)
    call swing(p, 0.44d0, theta, omega)
    swing_error = max(abs(h%theta - theta), abs(h%omega - omega))
  end function

  ! Order of the smooth motion, from four halvings of dt.
  subroutine smooth_order()
    real(c_double), parameter :: order(0:METHODS - 1) = [2d0, 2d0, 1d0]
    type(pendulum), target :: p
    integer(c_int) :: method
    real(c_double) :: ratio
    call defaults(p)
    do method = 0, METHODS - 1
      ratio = swing_error(p, method, 0.01d0) / swing_error(p, method, 0.000625d0)
      call is_near(log(ratio) / log(2d0) / 4, order(method), 0.15d0, nsdae_method_name(method))
    end do
  end subroutine

  ! Drift of implicit: order 2; v stays on the constraint to rounding (|v| is at most 5.4). The
  ! printed scheme's velocity leaves it.
  subroutine drift()
    type(pendulum), target :: p
    type(history), target :: h
    real(c_double) :: worst(0:3)
    integer :: i
    call defaults(p)
    do i = 0, 3
      call integrate(p, NSDAE_METHOD_IMPLICIT, 0.01d0 / 2**i, 3d0, h)
      worst(i) = h%stats%worst_drift
      call is_true(h%residual <= 1d-14 * 6, 'velocity on the constraint')
      call certificate(h)
    end do
    call is_near(log(worst(0) / worst(3)) / log(2d0) / 3, 2d0, 0.15d0, 'order of the drift')
    call integrate(p, NSDAE_METHOD_IMPLICIT_PRINTED, 0.005d0, 3d0, h)
    call is_true(h%stats%worst_drift > worst(1), 'drift of implicit-printed')
    call is_true(h%residual > 1d-6, 'velocity of implicit-printed')
    call certificate(h)
  end subroutine

  ! The figures of the records: the rate by the observer's own formula, and where the energy went.
  subroutine certificate(h)
    type(history), intent(in) :: h
    associate (c => h%stats%certificate)
      call is_near(c%constraint_rate, h%residual, 1d-13, 'rate of the certificate')
      call is_true(c%rate_constraint >= 0 .and. c%rate_constraint <= 1, 'its constraint')
      call is_near(h%stats%energy_start + c%work - c%dissipated + c%unexplained, h%energy, 1d-12, 'energy')
      call is_true(abs(c%unexplained) > 1d-9 .and. abs(c%work) < 1d-8, 'energy of the method')
      call is_int(c%pull_contact, -1, 'no contact pulls')
    end associate
  end subroutine

  ! Total energy never grows over an impact: 1e-12 of the 13 J that turn over is rounding.
  subroutine impact_energy()
    real(c_double), parameter :: e(3) = [0d0, 0.56d0, 1d0]
    type(pendulum), target :: p
    type(history), target :: h
    integer(c_int) :: method
    integer :: i, j
    call defaults(p)
    do method = 0, METHODS - 1
      do i = 1, 3
        do j = 0, 3
          p%e_N = e(i)
          call integrate(p, method, 0.01d0 / 2**j, 3d0, h)
          call is_true(h%impacts > 0, 'impacts')
          call is_true(h%gain <= 1d-12 * 13, 'energy over an impact')
        end do
      end do
    end do
  end subroutine

  ! Complementarity: every impact leaves with -e times the velocity it came with.
  subroutine newton_law()
    type(pendulum), target :: p
    type(history), target :: h
    integer(c_int) :: method
    integer :: i
    call defaults(p)
    do method = 0, METHODS - 1
      call integrate(p, method, 0.005d0, 3d0, h)
      do i = 1, h%impacts
        call is_near(h%impact(i)%velocity_after, -0.56d0 * h%impact(i)%velocity_before, &
                     1d-14 * 6, 'velocity after')
        call is_int(h%impact(i)%contact, 0, 'contact')
      end do
      call is_true(h%stats%worst_residual <= 1d-10, 'residual')
    end do
  end subroutine

end program
