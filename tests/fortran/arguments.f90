! What the library calls: module procedures, so that no compiler needs trampolines.
module callbacks_of_arguments
  use nsdae
  use bead_model
  implicit none

contains

  integer(c_int) function see(record, error, user)
    type(nsdae_record), intent(in) :: record
    type(nsdae_error), intent(inout) :: error
    class(*), intent(inout) :: user
    see = 0
  end function

  ! A Jacobian whose entry (0, 1) is wrong.
  integer(c_int) function wrong_jacobian(t, q, J, user)
    real(c_double), intent(in) :: t, q(:)
    real(c_double), intent(inout) :: J(:, :)
    class(*), intent(inout) :: user
    wrong_jacobian = jacobian(t, q, J, user)
    J(1, 2) = 3
  end function

end module

! The twin of tests/anomaly/arguments.c: what is missing, outside its range or of a wrong size.
program arguments
  use, intrinsic :: ieee_arithmetic
  use nsdae
  use bead_model
  use callbacks_of_arguments
  use check
  implicit none

  call texts
  call dims
  call setters
  call create
  call options_not_initialised
  call options_by_key
  call options_table
  call methods
  call nothing_created
  call states
  call derivatives
  call nearest_names
  call check_done

contains

  subroutine texts()
    call is_text(nsdae_status_name(NSDAE_E_RANK), 'NSDAE_E_RANK', 'name')
    call is_text(nsdae_status_message(NSDAE_OK), 'done', 'message')
    call is_text(nsdae_status_message(12345), 'unknown status', 'message of no status')
    call is_text(nsdae_version(), '0.3.0', 'version')
    call is_true(len(nsdae_build_info()) > 10, 'build info')
  end subroutine

  subroutine dims()
    type(nsdae_system) :: system
    type(nsdae_error) :: error
    type(nsdae_dims) :: got
    call is_int(nsdae_system_create(nsdae_dims(), system, error), NSDAE_E_ARGUMENT, 'nq = 0')
    call is_int(error%status, NSDAE_E_ARGUMENT, 'error%status')
    call contains_text(error%text, 'dims.nq = 0', 'error%text')
    call is_int(nsdae_system_create(nsdae_dims(nq=1, nt=3), system), NSDAE_E_ARGUMENT, 'nt = 3')
    call is_int(nsdae_system_create(nsdae_dims(nq=4, nv=3, k=2), system, error), NSDAE_OK, 'create')
    call is_int(error%status, NSDAE_OK, 'error%status')
    call is_int(nsdae_system_get_dims(system, got), NSDAE_OK, 'get_dims')
    call is_true(got%nq == 4 .and. got%nv == 3 .and. got%k == 2 .and. got%m == 0, 'sizes')
    call nsdae_system_destroy(system)
    call nsdae_system_destroy(system)
    call is_int(nsdae_system_get_dims(system, got), NSDAE_E_ARGUMENT, 'get_dims after destroy')
  end subroutine

  ! A term that the system does not have, numbers and coefficients outside their ranges.
  subroutine setters()
    type(nsdae_system) :: system
    type(nsdae_error) :: error
    call is_int(nsdae_system_create(nsdae_dims(nq=1, k=2), system), NSDAE_OK, 'create')
    call is_int(nsdae_system_set_constraint(system, constraint), NSDAE_E_ARGUMENT, 'm = 0')
    error = nsdae_system_error(system)
    call is_text(error%argument, 'constraint', 'error%argument')
    call is_int(nsdae_system_set_gap_tangent(system, tangent), NSDAE_E_ARGUMENT, 'nt = 0')
    call is_int(nsdae_system_set_frictional_joint(system, 0, 0, 0.1d0), NSDAE_E_ARGUMENT, 'f = 0')
    call is_int(nsdae_system_set_contact(system, 2, 0d0, 0d0, 0d0), NSDAE_E_ARGUMENT, 'contact 2')
    error = nsdae_system_error(system)
    call contains_text(error%text, '0 .. 1', 'error%text')
    call is_int(nsdae_system_set_contact(system, 1, 0d0, 1.1d0, 0d0), NSDAE_E_ARGUMENT, 'e_n = 1.1')
    call is_int(nsdae_system_set_contact(system, 1, 0d0, 1d0, 0d0), NSDAE_OK, 'contact 1')
    error = nsdae_system_error(system)
    call is_int(error%status, NSDAE_OK, 'error%status')
    call nsdae_system_destroy(system)
  end subroutine

  subroutine create()
    type(nsdae_system) :: empty, none
    type(nsdae_sim) :: sim
    type(nsdae_error) :: error
    call is_int(nsdae_sim_create(none, sim, error=error), NSDAE_E_ARGUMENT, 'no system')
    call is_text(error%argument, 'system', 'error%argument')
    call is_int(nsdae_system_create(nsdae_dims(nq=1), empty), NSDAE_OK, 'create')
    call is_int(nsdae_sim_create(empty, sim, error=error), NSDAE_E_STATE, 'no callbacks')
    call contains_text(error%text, 'nsdae_system_set_', 'error%text')
    call is_int(nsdae_sim_create(empty, sim), NSDAE_E_STATE, 'no callbacks, no error')
    call nsdae_sim_destroy(sim)
    call nsdae_system_destroy(empty)
  end subroutine

  subroutine options_not_initialised()
    type(bead), target :: b
    type(nsdae_system) :: system
    type(nsdae_sim) :: sim
    type(nsdae_sim_options) :: options
    type(nsdae_error) :: error
    call is_int(bead_system(b, system), NSDAE_OK, 'the bead')
    call is_int(nsdae_sim_create(system, sim, options, error), NSDAE_E_ARGUMENT, 'options')
    call is_text(error%argument, 'options', 'error%argument')
    call contains_text(error%text, 'nsdae_sim_options_default', 'error%text')
    call nsdae_sim_options_default(options)
    options%dt = -1
    call is_int(nsdae_sim_create(system, sim, options, error), NSDAE_E_ARGUMENT, 'dt = -1')
    call is_text(error%argument, 'dt', 'error%argument')
    call nsdae_system_destroy(system)
  end subroutine

  subroutine options_by_key()
    type(nsdae_sim_options) :: options
    type(nsdae_error) :: error
    call nsdae_sim_options_default(options)
    call is_int(nsdae_sim_options_set(options, 'dt', '0.25', error), NSDAE_OK, 'dt')
    call is_true(options%dt == 0.25d0, 'dt = 0.25')
    call is_int(nsdae_sim_options_set(options, 'method', 'moreau'), NSDAE_OK, 'method')
    call is_int(options%method, NSDAE_METHOD_MOREAU, 'method')
    call is_int(nsdae_sim_options_set(options, 'dtt', '1', error), NSDAE_E_OPTION, 'dtt')
    call contains_text(error%text, "'dt'", 'error%text')
    call is_int(nsdae_sim_options_set(options, 'method', 'morea', error), NSDAE_E_OPTION, 'morea')
    call contains_text(error%text, "'moreau'", 'error%text')
    call is_int(nsdae_sim_options_set(options, 'dt', '0', error), NSDAE_E_ARGUMENT, 'dt = 0')
    call is_int(nsdae_sim_options_set(options, 'dt', 'nan', error), NSDAE_E_ARGUMENT, 'dt = nan')
    call is_true(options%dt == 0.25d0, 'dt is unchanged')
  end subroutine

  ! Every option, read as text through the table and set again in another variable, and the fields
  ! that have names of the keys' own.
  subroutine options_table()
    type(nsdae_sim_options), target :: options, again
    type(nsdae_params) :: table, other
    type(nsdae_param) :: param
    integer(c_int) :: i
    call nsdae_sim_options_default(options)
    table = nsdae_sim_options_table(options)
    other = nsdae_sim_options_table(again)
    call is_true(nsdae_params_size(table) > 5, 'size of the table')
    call is_int(nsdae_params_check(table), NSDAE_OK, 'defaults')
    do i = 1, nsdae_params_size(table)
      param = nsdae_params_entry(table, i)
      call is_int(nsdae_params_find(table, param%key), i, 'number of ' // param%key)
      call is_int(nsdae_params_set(other, param%key, nsdae_params_format(table, i)), NSDAE_OK, &
                  param%key)
      call is_text(nsdae_params_format(other, i), nsdae_params_format(table, i), param%key)
    end do
    call is_int(nsdae_params_find(table, 'dtt'), 0, 'no such key')
    options%polygon = 31
    options%friction_velocity = 0.75d0
    call is_text(nsdae_params_format(table, nsdae_params_find(table, 'polygon')), '31', 'polygon')
    call is_text(nsdae_params_format(table, nsdae_params_find(table, 'friction_velocity')), &
                 '0.75', 'friction_velocity')
    options%polygon = 2
    call is_int(nsdae_params_check(table), NSDAE_E_ARGUMENT, 'polygon = 2')
  end subroutine

  ! The choices of the option are the names of the methods.
  subroutine methods()
    type(nsdae_sim_options), target :: options
    type(nsdae_params) :: table
    type(nsdae_param) :: param
    character(len=:), allocatable :: all
    integer(c_int) :: i
    call nsdae_sim_options_default(options)
    table = nsdae_sim_options_table(options)
    param = nsdae_params_entry(table, nsdae_params_find(table, 'method'))
    all = nsdae_method_name(0)
    do i = 1, nint(param%max, c_int)
      all = all // ' ' // nsdae_method_name(i)
    end do
    call is_text(param%choices, all, 'choices')
    call is_text(nsdae_method_name(NSDAE_METHOD_MOREAU), 'moreau', 'NSDAE_METHOD_MOREAU')
    call is_text(nsdae_method_name(nint(param%max, c_int) + 1), '', 'past the last')
    call is_true(len(nsdae_method_summary(NSDAE_METHOD_IMPLICIT)) > 10, 'summary')
  end subroutine

  subroutine nothing_created()
    type(nsdae_sim) :: sim
    type(nsdae_system) :: system
    type(nsdae_trajectory) :: trajectory
    type(nsdae_record) :: record
    type(nsdae_stats) :: stats
    type(nsdae_dims) :: sizes
    type(nsdae_sim_options) :: options
    type(nsdae_error) :: error
    real(c_double) :: zero(3) = 0
    type(bead), target :: b
    call is_int(nsdae_sim_init(sim, 0d0, zero, zero), NSDAE_E_ARGUMENT, 'init')
    call is_int(nsdae_sim_observe(sim, see), NSDAE_E_ARGUMENT, 'observe')
    call is_int(nsdae_sim_unobserve(sim, see), NSDAE_E_ARGUMENT, 'unobserve')
    call is_int(nsdae_sim_step(sim), NSDAE_E_ARGUMENT, 'step')
    call is_int(nsdae_sim_run(sim, 1d0), NSDAE_E_ARGUMENT, 'run')
    call is_int(nsdae_sim_get_record(sim, record), NSDAE_E_ARGUMENT, 'record')
    call is_int(nsdae_sim_get_stats(sim, stats), NSDAE_E_ARGUMENT, 'stats')
    call is_int(nsdae_sim_get_dims(sim, sizes), NSDAE_E_ARGUMENT, 'dims')
    call is_int(nsdae_sim_get_options(sim, options), NSDAE_E_ARGUMENT, 'options')
    call is_true(.not. nsdae_sim_has_potential(sim), 'potential')
    error = nsdae_sim_error(sim)
    call is_int(error%status, NSDAE_E_ARGUMENT, 'error%status')
    call is_int(nsdae_system_set_user(system, b), NSDAE_E_ARGUMENT, 'user')
    call is_int(nsdae_system_set_mass(system, mass), NSDAE_E_ARGUMENT, 'mass')
    call is_int(nsdae_system_check(system, 0d0, zero, zero, 1d-5), NSDAE_E_ARGUMENT, 'check')
    call is_int(nsdae_trajectory_close(trajectory, NSDAE_OK, error), NSDAE_OK, 'close')
    call nsdae_sim_destroy(sim)
    call nsdae_system_destroy(system)
  end subroutine

  subroutine states()
    type(bead), target :: b
    type(nsdae_system) :: system
    type(nsdae_sim) :: sim
    type(nsdae_record) :: record
    type(nsdae_error) :: error
    type(nsdae_sim_options) :: options
    real(c_double) :: q0(3), v0(3), spread(6)
    call is_int(bead_system(b, system), NSDAE_OK, 'the bead')
    call bead_start(b, q0, v0)
    call is_int(nsdae_sim_create(system, sim), NSDAE_OK, 'create')
    call is_int(nsdae_sim_get_record(sim, record), NSDAE_E_STATE, 'record before init')
    call is_int(nsdae_sim_step(sim), NSDAE_E_STATE, 'step before init')
    ! sizes, which only Fortran knows
    call is_int(nsdae_sim_init(sim, 0d0, q0(1:2), v0), NSDAE_E_ARGUMENT, 'two coordinates')
    error = nsdae_sim_error(sim)
    call is_text(error%text, 'q0 has 2 entries: it must have 3', 'error%text')
    call is_text(error%argument, 'q0', 'error%argument')
    call is_int(nsdae_sim_init(sim, 0d0, q0, [v0, 0d0]), NSDAE_E_ARGUMENT, 'four velocities')
    error = nsdae_sim_error(sim)
    call is_text(error%argument, 'v0', 'error%argument')
    v0(2) = ieee_value(0d0, ieee_quiet_nan)
    call is_int(nsdae_sim_init(sim, 0d0, q0, v0), NSDAE_E_NONFINITE, 'NaN')
    error = nsdae_sim_error(sim)
    call is_int(error%index, 1, 'error%index')
    call bead_start(b, q0, v0)
    ! a section that is not contiguous
    q0(1) = q0(1) + b%speed * 0.5d0  ! where the parabola is then
    spread = 0
    spread(1::2) = q0
    call is_int(nsdae_sim_init(sim, 0.5d0, spread(1::2), v0), NSDAE_OK, 'a section')
    error = nsdae_sim_error(sim)
    call is_int(error%status, NSDAE_OK, 'error%status')
    call is_int(nsdae_sim_get_record(sim, record), NSDAE_OK, 'record')
    call is_true(all(record%q == q0) .and. all(record%v == v0) .and. record%time == 0.5d0, 'state')
    call is_true(all(shape(record%tangential_impulse) == [1, 1]) .and. size(record%gap) == 1 &
                 .and. size(record%frictional_joint_mode) == 0 .and. size(record%impact) == 0, 'shapes')
    call is_true(record%contacts%count == 1 .and. all(record%contacts%id == [0]) &
                 .and. all(record%contacts%block == -1), 'the fixed contact')
    call is_true(associated(record%contacts%gap, record%gap) &
                 .and. associated(record%contacts%mode, record%mode), 'its arrays')
    call is_true(nsdae_sim_has_potential(sim), 'potential')
    call is_int(nsdae_sim_get_options(sim, options), NSDAE_OK, 'options')
    call is_true(options%dt == 0.005d0, 'dt')
    call is_int(nsdae_sim_run(sim, 0.4d0), NSDAE_E_ARGUMENT, 'back in time')
    call nsdae_sim_destroy(sim)
    call nsdae_system_destroy(system)
  end subroutine

  subroutine derivatives()
    type(bead), target :: b
    type(nsdae_system) :: system
    type(nsdae_check) :: worst
    type(nsdae_error) :: error
    real(c_double) :: q(3) = [0.9d0, 1.1d0, 0.2d0], v(3) = [0.3d0, -0.2d0, 0.5d0]
    call is_int(bead_system(b, system), NSDAE_OK, 'the bead')
    call is_int(nsdae_system_check(system, 0.1d0, q, v, 1d-5, worst), NSDAE_OK, 'check')
    call is_true(worst%error < 1d-5, 'worst%error')
    call is_text(nsdae_system_differences(system), '', 'differences')
    call is_int(nsdae_system_check(system, 0.1d0, q(:2), v, 1d-5), NSDAE_E_ARGUMENT, 'size of q')
    error = nsdae_system_error(system)
    call is_text(error%argument, 'q', 'error%argument')
    call is_int(nsdae_system_set_constraint_jacobian(system, wrong_jacobian), NSDAE_OK, 'set')
    call is_int(nsdae_system_check(system, 0.1d0, q, v, 1d-5, worst), NSDAE_E_DERIVATIVE, 'check')
    call is_text(worst%term, 'constraint_jacobian', 'worst%term')
    call is_true(worst%row == 0 .and. worst%column == 1, 'worst%row, worst%column')
    call is_true(worst%given == 3, 'worst%given')
    call is_near(worst%difference, 1d0, 1d-6, 'worst%difference')
    call nsdae_system_destroy(system)
  end subroutine

  subroutine nearest_names()
    character(len=8) :: words(3) = [character(len=8) :: 'apple', 'pear', 'quince']
    call is_text(nsdae_suggest_name('aple', words), 'apple', 'aple')
    call is_text(nsdae_suggest_name('zzz', words), '', 'zzz')
  end subroutine

end program
