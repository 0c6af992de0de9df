! What the library calls: module procedures, so that no compiler needs trampolines.
module observers_of_callbacks
  use nsdae
  implicit none

  ! A simulation and how often it refused.
  type :: meddler
    type(nsdae_sim) :: sim
    integer :: refused = 0
  end type

contains

  ! Interrupts when it was asked as often as its user says.
  integer(c_int) function lose_patience(user)
    class(*), intent(inout) :: user
    lose_patience = 0
    select type (user)
    type is (integer)
      user = user - 1
      if (user < 0) lose_patience = 1
    end select
  end function

  ! Uses the simulation that asks; all of it is refused.
  integer(c_int) function meddle(user)
    class(*), intent(inout) :: user
    type(nsdae_record) :: record
    type(nsdae_error) :: error
    meddle = 0
    select type (user)
    type is (meddler)
      if (nsdae_sim_step(user%sim) == NSDAE_E_STATE) user%refused = user%refused + 1
      error = nsdae_sim_error(user%sim)
      if (error%where == 'nsdae_sim_step') user%refused = user%refused + 1
      if (nsdae_sim_get_record(user%sim, record) == NSDAE_E_STATE) user%refused = user%refused + 1
      if (nsdae_sim_set_interrupt(user%sim) == NSDAE_E_STATE) user%refused = user%refused + 1
      call nsdae_sim_destroy(user%sim)
    end select
  end function

  integer(c_int) function stop_at_five(record, error, user)
    type(nsdae_record), intent(in) :: record
    type(nsdae_error), intent(inout) :: error
    class(*), intent(inout) :: user
    stop_at_five = merge(1, 0, record%step == 5)
  end function

  integer(c_int) function fail_at_five(record, error, user)
    type(nsdae_record), intent(in) :: record
    type(nsdae_error), intent(inout) :: error
    class(*), intent(inout) :: user
    fail_at_five = merge(NSDAE_E_IO, 0_c_int, record%step == 5)
  end function

  ! Says why, and counts in its user.
  integer(c_int) function explain_at_three(record, error, user)
    type(nsdae_record), intent(in) :: record
    type(nsdae_error), intent(inout) :: error
    class(*), intent(inout) :: user
    explain_at_three = 0
    select type (user)
    type is (integer)
      user = user + 1
    end select
    if (record%step < 3) return
    error%status = NSDAE_E_CONVERGENCE
    error%text = 'enough is enough'
    explain_at_three = NSDAE_E_CONVERGENCE
  end function

end module

! The twin of tests/anomaly/callbacks.c: callbacks that fail or give NaN, matrices that are
! singular, observers, times.
program callbacks
  use, intrinsic :: ieee_arithmetic
  use nsdae
  use bead_model
  use observers_of_callbacks
  use check
  implicit none

  integer(c_int), parameter :: METHODS = 3  ! those with a fixed step

  call failing_callback
  call nan
  call failing_start
  call mass_not_positive_definite
  call rank
  call observers
  call interrupts
  call reentry
  call times
  call check_done

contains

  ! Penalty needs SUNDIALS.
  logical function is_built(method)
    integer(c_int), intent(in) :: method
    type(bead), target :: b
    type(nsdae_system) :: system
    type(nsdae_sim) :: sim
    type(nsdae_sim_options) :: options
    integer(c_int) :: status
    status = bead_system(b, system)
    call nsdae_sim_options_default(options)
    options%method = method
    status = nsdae_sim_create(system, sim, options)
    is_built = status /= NSDAE_E_UNSUPPORTED
    call nsdae_sim_destroy(sim)
    call nsdae_system_destroy(system)
  end function

  subroutine make(b, method, redundant, system, sim)
    type(bead), target, intent(inout) :: b
    integer(c_int), intent(in) :: method, redundant
    type(nsdae_system), intent(out) :: system
    type(nsdae_sim), intent(out) :: sim
    type(nsdae_sim_options) :: options
    call is_int(bead_system(b, system), NSDAE_OK, 'the bead')
    call nsdae_sim_options_default(options)
    options%method = method
    options%redundant = redundant
    options%dt = 0.01d0
    call is_int(nsdae_sim_create(system, sim, options), NSDAE_OK, 'nsdae_sim_create')
  end subroutine

  subroutine unmake(system, sim)
    type(nsdae_system), intent(inout) :: system
    type(nsdae_sim), intent(inout) :: sim
    call nsdae_sim_destroy(sim)
    call nsdae_system_destroy(system)
  end subroutine

  integer(c_int) function start(sim, b) result(status)
    type(nsdae_sim), intent(in) :: sim
    type(bead), intent(in) :: b
    real(c_double) :: q0(3), v0(3)
    call bead_start(b, q0, v0)
    status = nsdae_sim_init(sim, 0d0, q0, v0)
  end function

  ! Runs until the fault; then checks state and record, and runs again without it.
  subroutine fail_in_a_run(b, method, wanted)
    type(bead), target, intent(inout) :: b
    integer(c_int), intent(in) :: method, wanted
    type(nsdae_system) :: system
    type(nsdae_sim) :: sim
    type(nsdae_record) :: before, after
    type(nsdae_error) :: error
    real(c_double) :: q(3), v(3)
    integer(c_int) :: status
    integer :: steps
    call make(b, method, NSDAE_REDUNDANT_ERROR, system, sim)
    call is_int(start(sim, b), NSDAE_OK, 'start')
    status = NSDAE_OK
    do steps = 1, 2000
      call is_int(nsdae_sim_get_record(sim, before), NSDAE_OK, 'record')
      q = before%q
      v = before%v
      status = nsdae_sim_step(sim)
      if (status < 0) exit
    end do
    error = nsdae_sim_error(sim)
    if (.not. (method == NSDAE_METHOD_PENALTY .and. b%code > 0 .and. status >= 0)) then
      call is_int(status, wanted, 'step')
      call is_int(error%status, wanted, 'error%status')
      call is_text(error%argument, trim(NAMES(b%term)), 'error%argument')
      call contains_text(error%text, trim(NAMES(b%term)), 'error%text')
      call is_true(ieee_is_finite(error%time), 'error%time')
      if (wanted == NSDAE_E_CALLBACK) call is_int(error%code, b%code, 'error%code')
      call is_int(nsdae_sim_get_record(sim, after), NSDAE_OK, 'record')
      call is_true(after%step == before%step .and. all(after%q == q) .and. all(after%v == v), &
                   'the state is the one before')
    end if
    b%term = 0
    call is_int(start(sim, b), NSDAE_OK, 'start anew')
    ! the law of penalty does not give e_N = 0
    call is_int(nsdae_sim_run(sim, 0.5d0), &
                merge(NSDAE_WARN_RESTITUTION, NSDAE_OK, method == NSDAE_METHOD_PENALTY), 'run anew')
    call unmake(system, sim)
  end subroutine

  subroutine failing_callback()
    type(bead), target :: b
    integer(c_int) :: method, code
    integer :: term
    do method = 0, NSDAE_METHOD_PENALTY
      if (.not. is_built(method)) cycle
      do term = 1, TERMS
        do code = -1, 1, 2
          b = bead(term=term, at=37, code=code)
          call fail_in_a_run(b, method, NSDAE_E_CALLBACK)
        end do
      end do
    end do
  end subroutine

  subroutine nan()
    type(bead), target :: b
    integer(c_int) :: method
    integer :: term
    do method = 0, NSDAE_METHOD_PENALTY
      if (.not. is_built(method)) cycle
      do term = 1, TERMS
        b = bead(term=term, at=20, value=ieee_value(0d0, ieee_quiet_nan))
        if (mod(term, 2) == 0) b%value = ieee_value(0d0, ieee_positive_inf)
        call fail_in_a_run(b, method, NSDAE_E_NONFINITE)
      end do
    end do
  end subroutine

  ! Every term is evaluated at the start, so what is wrong shows there.
  subroutine failing_start()
    type(bead), target :: b
    type(nsdae_system) :: system
    type(nsdae_sim) :: sim
    type(nsdae_error) :: error
    integer :: term
    do term = 1, TERMS
      b = bead()
      call make(b, NSDAE_METHOD_IMPLICIT, NSDAE_REDUNDANT_ERROR, system, sim)
      b%term = term
      b%code = -7
      call is_int(start(sim, b), NSDAE_E_CALLBACK, 'start')
      error = nsdae_sim_error(sim)
      call is_int(error%code, -7, 'error%code')
      call is_text(error%argument, trim(NAMES(term)), 'error%argument')
      call is_int(nsdae_sim_step(sim), NSDAE_E_STATE, 'step')
      call unmake(system, sim)
    end do
  end subroutine

  subroutine mass_not_positive_definite()
    type(bead), target :: b
    type(nsdae_system) :: system
    type(nsdae_sim) :: sim
    type(nsdae_error) :: error
    integer :: scale
    do scale = -1, 0
      b = bead(mass_scale=scale)
      call make(b, NSDAE_METHOD_IMPLICIT, NSDAE_REDUNDANT_ERROR, system, sim)
      call is_int(start(sim, b), NSDAE_E_MASS, 'start')
      error = nsdae_sim_error(sim)
      call contains_text(error%text, 'positive definite', 'error%text')
      call contains_text(error%text, 'pivot 1 of 3', 'error%text')
      call unmake(system, sim)
    end do
  end subroutine

  ! A constraint that stands twice: refused with its rank, or run with least-norm reactions, which
  ! then give the same motion as the constraint alone.
  subroutine rank()
    type(bead), target :: twice, once
    type(nsdae_system) :: system, plain
    type(nsdae_sim) :: sim, alone
    type(nsdae_record) :: two, one
    type(nsdae_stats) :: stats
    type(nsdae_error) :: error
    integer(c_int) :: method
    real(c_double) :: bound
    twice%repeated = .true.
    call make(twice, NSDAE_METHOD_IMPLICIT, NSDAE_REDUNDANT_ERROR, system, sim)
    call is_int(start(sim, twice), NSDAE_E_RANK, 'start')
    error = nsdae_sim_error(sim)
    call contains_text(error%text, 'rank 1 of 2', 'error%text')
    call unmake(system, sim)
    do method = 0, METHODS - 1
      call make(twice, method, NSDAE_REDUNDANT_LEAST_NORM, system, sim)
      call make(once, method, NSDAE_REDUNDANT_ERROR, plain, alone)
      call is_int(start(sim, twice), NSDAE_OK, 'start')
      call is_int(start(alone, once), NSDAE_OK, 'start')
      call is_int(nsdae_sim_run(sim, 0.3d0), NSDAE_OK, 'run')
      call is_int(nsdae_sim_run(alone, 0.3d0), NSDAE_OK, 'run')
      call is_int(nsdae_sim_get_record(sim, two), NSDAE_OK, 'record')
      call is_int(nsdae_sim_get_record(alone, one), NSDAE_OK, 'record')
      call is_int(nsdae_sim_get_stats(sim, stats), NSDAE_OK, 'stats')
      call is_int(stats%rank, 1, 'stats%rank')
      call is_true(size(two%multiplier) == 2 .and. size(one%multiplier) == 1, 'shapes')
      ! rounding of thirty smooth steps
      call is_near(maxval(abs(two%q - one%q)), 0d0, 1d-12, 'q')
      ! Phi_2 = 2 Phi_1 shares the force as 1 : 2, and l1 + 2 l2 is the plain force
      bound = 1d-9 * (1 + abs(one%multiplier(1)))
      call is_near(two%multiplier(2), 2 * two%multiplier(1), bound, 'multiplier')
      call is_near(two%multiplier(1) + 2 * two%multiplier(2), one%multiplier(1), bound, 'their sum')
      call unmake(system, sim)
      call unmake(plain, alone)
    end do
  end subroutine

  subroutine observers()
    type(bead), target :: b
    type(nsdae_system) :: system
    type(nsdae_sim) :: sim
    type(nsdae_record) :: record
    type(nsdae_error) :: error
    integer, target :: seen, other
    integer :: i
    call make(b, NSDAE_METHOD_MOREAU, NSDAE_REDUNDANT_ERROR, system, sim)
    call is_int(start(sim, b), NSDAE_OK, 'start')
    call is_int(nsdae_sim_observe(sim, stop_at_five), NSDAE_OK, 'observe')
    call is_int(nsdae_sim_run(sim, 1d0), NSDAE_STOPPED, 'run')
    call is_int(nsdae_sim_get_record(sim, record), NSDAE_OK, 'record')
    call is_true(record%step == 5, 'stopped at step 5')
    ! it goes on from there, on the same grid
    call is_int(nsdae_sim_unobserve(sim, fail_at_five), NSDAE_OK, 'unobserve another')
    call is_int(nsdae_sim_unobserve(sim, stop_at_five), NSDAE_OK, 'unobserve')
    call is_int(nsdae_sim_run(sim, 1d0), NSDAE_OK, 'run on')
    call is_int(nsdae_sim_get_record(sim, record), NSDAE_OK, 'record')
    call is_true(record%step == 100 .and. record%time == 1d0, 'at 1 s after 100 steps')
    seen = 0
    other = 0
    call is_int(start(sim, b), NSDAE_OK, 'start')
    call is_int(nsdae_sim_observe(sim, explain_at_three, seen), NSDAE_OK, 'observe')
    call is_int(nsdae_sim_observe(sim, explain_at_three, other), NSDAE_OK, 'observe')
    call is_int(nsdae_sim_unobserve(sim, explain_at_three, other), NSDAE_OK, 'unobserve')
    call is_int(nsdae_sim_run(sim, 1d0), NSDAE_E_CONVERGENCE, 'run')
    error = nsdae_sim_error(sim)
    call is_text(error%text, 'enough is enough', 'error%text')
    call is_int(seen, 4, 'records seen')
    call is_int(other, 0, 'records seen by the one that was taken out')
    call is_int(nsdae_sim_unobserve(sim, explain_at_three, seen), NSDAE_OK, 'unobserve')
    call is_int(start(sim, b), NSDAE_OK, 'start')
    call is_int(nsdae_sim_observe(sim, fail_at_five), NSDAE_OK, 'observe')
    call is_int(nsdae_sim_run(sim, 1d0), NSDAE_E_IO, 'run')
    error = nsdae_sim_error(sim)
    call is_text(error%argument, 'observer', 'error%argument')
    do i = 2, NSDAE_OBSERVERS_MAX
      call is_int(nsdae_sim_observe(sim, stop_at_five), NSDAE_OK, 'observe')
    end do
    call is_int(nsdae_sim_observe(sim, stop_at_five), NSDAE_E_ARGUMENT, 'one observer too many')
    call unmake(system, sim)
  end subroutine

  subroutine interrupts()
    type(bead), target :: b
    type(nsdae_system) :: system
    type(nsdae_sim) :: sim
    type(nsdae_record) :: record
    integer, target :: patience
    patience = 4
    call make(b, NSDAE_METHOD_MOREAU, NSDAE_REDUNDANT_ERROR, system, sim)
    call is_int(nsdae_sim_set_interrupt(sim, lose_patience, patience), NSDAE_OK, 'set interrupt')
    call is_int(start(sim, b), NSDAE_OK, 'start')
    call is_int(nsdae_sim_run(sim, 1d0), NSDAE_E_INTERRUPTED, 'interrupted')
    call is_int(nsdae_sim_get_record(sim, record), NSDAE_OK, 'record')
    call is_true(record%step == 4, 'interrupted after step 4')
    call is_int(nsdae_sim_set_interrupt(sim), NSDAE_OK, 'nobody is asked')
    call is_int(nsdae_sim_run(sim, 1d0), NSDAE_OK, 'goes on')
    call nsdae_sim_destroy(sim)
    call nsdae_system_destroy(system)
  end subroutine

  ! A simulation is used while it steps: refused, and it goes on.
  subroutine reentry()
    type(bead), target :: b
    type(nsdae_system) :: system
    type(nsdae_sim) :: sim
    type(nsdae_record) :: record
    type(meddler), target :: other
    call make(b, NSDAE_METHOD_MOREAU, NSDAE_REDUNDANT_ERROR, system, sim)
    other%sim = sim
    call is_int(nsdae_sim_set_interrupt(sim, meddle, other), NSDAE_OK, 'set interrupt')
    call is_int(start(sim, b), NSDAE_OK, 'start')
    call is_int(nsdae_sim_run(sim, 0.1d0), NSDAE_OK, 'run')
    call is_int(nsdae_sim_get_record(sim, record), NSDAE_OK, 'record')
    call is_true(record%step == 10, 'ten steps')
    call is_int(other%refused, 40, 'refused')
    call nsdae_sim_destroy(sim)
    call nsdae_system_destroy(system)
  end subroutine

  ! A last step that is shortened ends at t_end; the next run starts a new grid there.
  subroutine times()
    type(bead), target :: b
    type(nsdae_system) :: system
    type(nsdae_sim) :: sim
    type(nsdae_record) :: record
    type(nsdae_error) :: error
    call make(b, NSDAE_METHOD_IMPLICIT, NSDAE_REDUNDANT_ERROR, system, sim)
    call is_int(nsdae_sim_run(sim, 1d0), NSDAE_E_STATE, 'run before init')
    call is_int(start(sim, b), NSDAE_OK, 'start')
    call is_int(nsdae_sim_run(sim, 0.034d0), NSDAE_OK, 'run')
    call is_int(nsdae_sim_get_record(sim, record), NSDAE_OK, 'record')
    call is_true(record%time == 0.034d0 .and. record%step == 4, 'at 0.034 s')
    call is_int(nsdae_sim_step(sim), NSDAE_OK, 'step')
    call is_int(nsdae_sim_get_record(sim, record), NSDAE_OK, 'record')
    call is_near(record%time, 0.044d0, 1d-15, 'time')
    call is_int(nsdae_sim_run(sim, 0.01d0), NSDAE_E_ARGUMENT, 'run back')
    error = nsdae_sim_error(sim)
    call is_text(error%argument, 't_end', 'error%argument')
    call is_int(nsdae_sim_run(sim, ieee_value(0d0, ieee_quiet_nan)), NSDAE_E_ARGUMENT, 'run to NaN')
    call unmake(system, sim)
  end subroutine

end program
