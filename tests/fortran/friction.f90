! Frictional contact by itself: solved in one part and in two, with a guess and with a solver, what
! comes out of it judged here, and what is refused.
program friction
  use, intrinsic :: iso_c_binding
  use nsdae
  use check
  implicit none

  ! A light body on the ground carries one of mass 1, by contacts of two rows, normal and tangential;
  ! a wind blows from the side. r_1 - r_2, both near 0.1 or 0.03, has to be the momentum of the light
  ! one, which is no multiple of their last digit, 1e-17.
  real(c_double), parameter :: mass = 3d-7, weight = 0.1d0, wind = 0.03d0, tol = 1d-12
  type(nsdae_friction_problem) :: problem
  integer(c_int), target :: rows(2) = 2, size_(2) = 2, first(3) = [0, 1, 3], block(3) = [0, 0, 1]
  real(c_double), target :: M(8) = [mass, 0d0, 0d0, mass, 1d0, 0d0, 0d0, 1d0]
  real(c_double), target :: f(4) = [-mass * weight, mass * wind, -weight, wind]
  real(c_double), target :: w(4) = 0, mu(2) = 0.5d0
  real(c_double), target :: H(12) = [1d0, 0d0, 0d0, 1d0, -1d0, 0d0, 0d0, -1d0, 1d0, 0d0, 0d0, 1d0]
  type(nsdae_friction_options) :: options

  problem%contacts = 2
  problem%blocks = 2
  problem%rows => rows
  problem%mu => mu
  problem%w => w
  problem%size => size_
  problem%M => M
  problem%f => f
  problem%first => first
  problem%block => block
  problem%value => H
  call nsdae_friction_options_default(options)
  options%tol = tol

  call in_one_part
  call in_two_parts
  call easy
  call infeasible
  call too_short
  call interrupted
  call check_done

contains

  ! The velocities at the contacts, u_1 of the light body and u_2 of the other one relative to it, by
  ! plain sums that are exact: r_1 - r_2 and r_2 - 0.1, of numbers near each other, and what remains,
  ! all of one size (Sterbenz).
  function velocities(r, low) result(u)
    real(c_double), intent(in) :: r(4), low(4)
    real(c_double) :: u(4), heavy(2)
    heavy = (r(3:) + f(3:)) + low(3:)
    u(:2) = (((r(:2) - r(3:)) + f(:2)) + (low(:2) - low(3:))) / mass
    u(3:) = heavy - u(:2)
  end function

  ! Where both bodies stick, r inside the cones with room, the residual is max |u| / s, s the largest
  ! velocity of bodies that are let go.
  real(c_double) function standing(r, low) result(residual)
    real(c_double), intent(in) :: r(4), low(4)
    residual = huge(residual)
    if (any(abs(r(2::2)) > 0.4d0 * r(1::2))) return
    residual = maxval(abs(velocities(r, low))) / weight
  end function

  subroutine in_one_part()
    type(nsdae_friction_info) :: info
    type(nsdae_friction_solver) :: solver
    real(c_double) :: r(4), u(4), residual
    r = 0
    call is_int(nsdae_friction_solve(problem, r, u, options, info), NSDAE_E_LCP, 'one part to 1e-12')
    call is_int(info%outcome, NSDAE_OUTCOME_UNSOLVED, 'outcome')
    call is_int(nsdae_friction_residual(problem, r, u, residual), NSDAE_OK, 'residual of r')
    call is_true(residual > tol .and. residual < 1d-9, 'what doubles can say')
    call is_true(standing(r, [0d0, 0d0, 0d0, 0d0]) > tol, 'it is none')
    options%tol = 1d-9
    call is_int(nsdae_friction_create(solver), NSDAE_OK, 'solver')
    r = 0
    call is_int(nsdae_friction_solver_solve(solver, problem, r, u, options, info), NSDAE_OK, 'to 1e-9')
    call nsdae_friction_destroy(solver)
    call is_true(info%residual <= 1d-9 .and. standing(r, [0d0, 0d0, 0d0, 0d0]) <= 1d-9, 'residual')
    options%tol = tol
  end subroutine

  subroutine in_two_parts()
    type(nsdae_friction_info) :: info
    real(c_double) :: r(4), low(4), u(4), again(4), residual, single
    r = 0
    low = 7
    call is_int(nsdae_friction_solve_twice(problem, r, low, u, options, info), NSDAE_OK, 'two parts')
    call is_int(info%outcome, NSDAE_OUTCOME_SOLVED, 'outcome')
    call is_true(any(low > 0 .or. low < 0), 'r alone does not hold it')
    call is_true(all(abs(low) <= 0.5d0 * spacing(r)), 'low is below half a digit of r')
    call is_true(standing(r, low) <= tol, 'a solution')
    call is_true(maxval(abs(u - velocities(r, low))) <= 1d-3 * tol * weight, 'its velocities')
    call is_int(nsdae_friction_residual_twice(problem, r, low, again, residual), NSDAE_OK, 'residual')
    call is_true(residual <= tol, 'of r + low')
    call is_near(residual, info%residual, 0d0, 'as the certificate says')
    call is_true(all(u == again), 'the same velocities')
    call is_int(nsdae_friction_residual(problem, r, again, single), NSDAE_OK, 'residual of r')
    call is_true(single > 10 * tol, 'r alone is none')
    low = 0
    call is_int(nsdae_friction_residual_twice(problem, r, low, again, residual), NSDAE_OK, 'low = 0')
    call is_near(residual, single, 1d-15, 'as of r alone')
  end subroutine

  ! A problem that r alone solves has low = 0, and the same bits.
  subroutine easy()
    type(nsdae_friction_info) :: info
    real(c_double) :: r(4), low(4), u(4), one(4)
    options%tol = 1d-8
    one = 0
    call is_int(nsdae_friction_solve(problem, one, u, options), NSDAE_OK, 'one part to 1e-8')
    r = 0
    low = 7
    call is_int(nsdae_friction_solve_twice(problem, r, low, u, options, info), NSDAE_OK, 'to 1e-8')
    call is_true(all(low == 0), 'low = 0')
    call is_true(all(r == one), 'the same r')
    r = 0
    call is_int(nsdae_friction_solve_twice(problem, r, low, u), NSDAE_OK, 'by default')
    options%tol = tol
  end subroutine

  ! A bar that is driven and held to be at rest: proved, and low is as it was.
  subroutine infeasible()
    type(nsdae_friction_problem) :: none
    type(nsdae_friction_info) :: info
    integer(c_int), target :: nothing(2) = 0, empty(0)
    real(c_double), target :: driven(1) = [-1d0], zeros(0)
    real(c_double) :: r(1), low(1), u(1)
    none%form = NSDAE_FRICTION_LOCAL
    none%bilateral = 1
    none%mu => zeros
    none%w => driven
    none%first => nothing
    none%block => empty
    none%value => zeros
    r = 0
    low = 7
    call is_int(nsdae_friction_solve_twice(none, r, low, u, info=info), NSDAE_E_INFEASIBLE, 'driven')
    call is_int(info%proof, NSDAE_PROOF_FARKAS, 'proof')
    call is_true(low(1) == 7, 'low is as it was')
  end subroutine

  ! Arrays that are too short are refused before anything is written.
  subroutine too_short()
    real(c_double) :: r(4), low(4), u(4), residual
    r = 1
    low = 2
    u = 3
    call is_int(nsdae_friction_solve_twice(problem, r(:3), low, u), NSDAE_E_ARGUMENT, 'r')
    call is_int(nsdae_friction_solve_twice(problem, r, low(:3), u), NSDAE_E_ARGUMENT, 'low')
    call is_int(nsdae_friction_solve_twice(problem, r, low, u(:3)), NSDAE_E_ARGUMENT, 'u')
    call is_int(nsdae_friction_residual_twice(problem, r(:3), low, u, residual), NSDAE_E_ARGUMENT, 'r')
    call is_int(nsdae_friction_residual_twice(problem, r, low(:3), u, residual), NSDAE_E_ARGUMENT, &
                'low')
    call is_int(nsdae_friction_residual_twice(problem, r, low, u(:3), residual), NSDAE_E_ARGUMENT, 'u')
    options%tol = -1
    call is_int(nsdae_friction_solve_twice(problem, r, low, u, options), NSDAE_E_ARGUMENT, 'tol = -1')
    options%tol = tol
    call is_true(all(r == 1) .and. all(low == 2) .and. all(u == 3), 'r, low and u are as they were')
  end subroutine

  ! The callback is called with what the solve is doing, and ends it.
  subroutine interrupted()
    type(nsdae_friction_info) :: info
    real(c_double) :: r(4), u(4)
    integer(c_int), target :: calls
    calls = 0
    options%progress = c_funloc(count_calls)
    options%user = c_loc(calls)
    r = 0
    call is_int(nsdae_friction_solve(problem, r, u, options, info), NSDAE_E_INTERRUPTED, 'interrupted')
    call is_int(calls, 2, 'two calls')
    call is_true(all(abs(r) < 1) .and. info%outcome == NSDAE_OUTCOME_UNSOLVED, 'the best point so far')
    options%progress = c_null_funptr
  end subroutine

  integer(c_int) function count_calls(progress, user) bind(C) result(stop_now)
    type(nsdae_friction_progress), intent(in) :: progress
    type(c_ptr), value :: user
    integer(c_int), pointer :: calls
    call c_f_pointer(user, calls)
    calls = calls + 1
    call is_int(progress%islands, 1, 'one island')
    call is_int(progress%contacts, 2, 'of two contacts')
    stop_now = merge(1_c_int, 0_c_int, calls == 2)
  end function

end program
