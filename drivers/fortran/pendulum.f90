! nsdae-pendulum-fortran: the driver of the pendulum without a line of C.
program pendulum_driver
  use, intrinsic :: iso_fortran_env, only: error_unit
  use nsdae
  use pendulum_model
  use pendulum_report
  use pendulum_restart
  use pendulum_settings
  implicit none
  type(settings), target, save :: s
  type(report), target, save :: r
  type(nsdae_system) :: system
  type(nsdae_sim) :: sim
  type(nsdae_trajectory) :: trajectory
  type(nsdae_error) :: error
  integer(c_int) :: status
  logical :: writes

  status = settings_default(s)
  if (status == NSDAE_OK) status = settings_parse(s, error)
  if (status < 0) call finish(2)
  if (s%help) call settings_usage(s)
  if (s%version .and. .not. s%help) print '(2a)', 'nsdae-pendulum-fortran ', nsdae_build_info()
  if (s%help .or. s%version) call finish(0)

  status = prepare()
  if (status == NSDAE_OK) status = open_trajectory()
  ! usage error for wrong values, else a failed computation
  if (status == NSDAE_E_ARGUMENT .or. status == NSDAE_E_OPTION) call finish(2)
  if (status == NSDAE_OK) status = run()
  if (status < 0) call finish(1)
  call finish(0)

contains

  integer(c_int) function prepare() result(status)
    real(c_double) :: q0(3), v0(3)
    status = pendulum_build(s%model, system, error)
    if (status == NSDAE_OK) status = nsdae_sim_create(system, sim, s%options, error)
    if (status < 0) return
    call pendulum_start(s%model, q0, v0)
    status = nsdae_sim_init(sim, 0d0, q0, v0)
    if (status < 0) error = nsdae_sim_error(sim)
  end function

  integer(c_int) function resume(info) result(status)
    type(nsdae_trajectory_info), intent(in) :: info
    type(nsdae_record) :: record
    writes = .false.
    status = restart_probe(sim, s%restart, info, error)
    if (status == NSDAE_OK) status = nsdae_trajectory_resume(sim, s%restart, info, trajectory, error)
    writes = status == NSDAE_OK
    if (.not. writes) return
    status = nsdae_sim_get_record(sim, record)
    if (s%t_end < record%time) then
      status = nsdae_trajectory_close(trajectory, NSDAE_OK)
      error%text = "'" // trim(s%restart) // "' is at t = " // text_of(record%time) // &
                   ' s, past t_end = ' // text_of(s%t_end) // ' s'
      status = NSDAE_E_ARGUMENT
    else if (.not. s%quiet) then
      print '(4a)', 'continues at t = ', text_of(record%time), ' s in ', trim(s%restart)
    end if
  end function

  ! In as many digits as it has.
  function text_of(time) result(text)
    real(c_double), intent(in) :: time
    character(len=:), allocatable :: text
    real(c_double) :: kept
    kept = s%t_end
    s%t_end = time
    text = trim(nsdae_params_format(s%run, 1))
    s%t_end = kept
  end function

  ! A library without HDF5 still runs the example, unless a file was asked for.
  integer(c_int) function open_trajectory() result(status)
    type(nsdae_trajectory_info) :: info
    status = NSDAE_OK
    writes = .false.
    if (s%output == '') return
    info = nsdae_trajectory_info('pendulum', s%parameters, s%live, s%every, s%compress, s%t_end)
    if (s%restart /= '') then
      status = resume(info)
      return
    end if
    status = nsdae_trajectory_create(sim, s%output, info, trajectory, error)
    writes = status == NSDAE_OK
    if (writes) status = pendulum_bodies(s%model, trajectory, error)
    if (status /= NSDAE_E_UNSUPPORTED .or. s%output_named) return
    if (.not. s%quiet) print '(2a)', 'no trajectory: ', trim(error%text)
    status = NSDAE_OK
  end function

  ! The first failure is reported.
  integer(c_int) function run() result(status)
    type(nsdae_error) :: why
    integer(c_int) :: closed
    if (.not. s%quiet) then
      status = nsdae_sim_observe(sim, report_observe, r)
      call report_begin(r, s, sim)
    end if
    status = nsdae_sim_run(sim, s%t_end)
    if (.not. s%quiet) call report_end(r, sim)
    if (status < 0) error = nsdae_sim_error(sim)
    if (.not. writes) return
    closed = nsdae_trajectory_close(trajectory, status, why)
    if (closed == NSDAE_OK .and. .not. s%quiet) print '(2a)', 'trajectory in ', trim(s%output)
    if (status < 0) return
    status = closed
    error = why
  end function

  subroutine finish(code)
    integer, intent(in) :: code
    if (code /= 0) write (error_unit, '(2a)') 'nsdae-pendulum-fortran: error: ', trim(error%text)
    call nsdae_sim_destroy(sim)
    call nsdae_system_destroy(system)
    call settings_release(s)
    stop code, quiet=.true.
  end subroutine

end program
