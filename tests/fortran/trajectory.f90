! What the library calls: module procedures, so that no compiler needs trampolines.
module observer_of_trajectory
  use nsdae
  implicit none

  integer, parameter :: STEPS = 1500

  type :: tape
    integer :: n = 0
    real(c_double) :: time(0:STEPS), q(3, 0:STEPS)
  end type

contains

  integer(c_int) function remember(record, error, user) result(status)
    type(nsdae_record), intent(in) :: record
    type(nsdae_error), intent(inout) :: error
    class(*), intent(inout) :: user
    status = 0
    select type (user)
    type is (tape)
      user%time(user%n) = record%time
      user%q(:, user%n) = record%q
      user%n = user%n + 1
    end select
  end function

end module

! The twin of tests/system/trajectory.c, as far as it is of the module: what was recorded is in the
! file, byte for byte; datasets of one's own; what is refused.
program trajectory_test
  use nsdae
  use bead_model
  use observer_of_trajectory
  use check
  implicit none

  type(bead), target :: b
  type(nsdae_system) :: system
  type(nsdae_sim) :: sim
  type(nsdae_sim_options) :: options
  type(nsdae_params) :: table
  real(c_double) :: q0(3), v0(3)

  call nsdae_sim_options_default(options)
  options%dt = 0.001d0
  call bead_start(b, q0, v0)
  call is_int(nsdae_params_add(table, b%speed, 'speed', 'm/s', 'of the parabola', 0.3d0), &
              NSDAE_OK, 'table')
  call is_int(bead_system(b, system), NSDAE_OK, 'the bead')
  call is_int(nsdae_sim_create(system, sim, options), NSDAE_OK, 'create')
  call refused
  call contents
  call resumed
  call failed_run
  call bodies_of_system
  call nsdae_sim_destroy(sim)
  call nsdae_system_destroy(system)
  call nsdae_params_destroy(table)
  call check_done

contains

  subroutine refused()
    type(nsdae_trajectory) :: t
    type(nsdae_sim) :: none
    type(nsdae_error) :: error
    call is_int(nsdae_trajectory_create(sim, 'no/such/folder/x.h5', nsdae_trajectory_info('bead'), &
                                        t, error), NSDAE_E_IO, 'no folder')
    call contains_text(error%text, 'no/such/folder/x.h5', 'error%text')
    call is_int(nsdae_trajectory_create(none, 'x.h5', nsdae_trajectory_info('bead'), t), &
                NSDAE_E_ARGUMENT, 'no simulation')
    call is_int(nsdae_trajectory_create(sim, 'x.h5', nsdae_trajectory_info('bead', contact_forces=.true.), t, &
                                        error), NSDAE_E_ARGUMENT, 'no solids')
    call is_text(error%argument, 'contact_forces', 'error%argument')
    call is_int(nsdae_trajectory_put(t, '/x', [1d0], 'm', 'nothing'), NSDAE_E_ARGUMENT, 'no file')
    call is_int(nsdae_trajectory_close(t, NSDAE_OK), NSDAE_OK, 'close nothing')
  end subroutine

  subroutine contents()
    type(nsdae_trajectory) :: t
    type(nsdae_error) :: error
    type(tape), target, save :: seen
    type(nsdae_trajectory_info) :: info
    integer(c_int) :: status
    info = nsdae_trajectory_info('bead', table, .false.)
    call is_int(nsdae_trajectory_create(sim, 'fortran.h5', info, t, error), NSDAE_OK, error%text)
    call bodies(t)
    call is_int(nsdae_sim_init(sim, 0d0, q0, v0), NSDAE_OK, 'init')
    call is_int(nsdae_sim_observe(sim, remember, seen), NSDAE_OK, 'observe')
    status = nsdae_sim_run(sim, STEPS * 0.001d0)
    call is_int(status, NSDAE_OK, 'run')
    call is_int(nsdae_trajectory_put(t, '/mine/numbers', [1d0, 2d0, 3.5d0], 'm', 'mine', error), &
                NSDAE_OK, 'put ' // error%text)
    call is_int(nsdae_trajectory_put_texts(t, '/mine/words', [character(len=5) :: 'one', 'two'], &
                                           'mine too', error), NSDAE_OK, 'texts ' // error%text)
    call is_int(nsdae_trajectory_flush(t, error), NSDAE_OK, 'flush')
    call is_int(nsdae_trajectory_close(t, status, error), NSDAE_OK, 'close')
    call is_int(nsdae_sim_unobserve(sim, remember, seen), NSDAE_OK, 'unobserve')
    call is_int(seen%n, STEPS + 1, 'records')
    call is_true(all(stored('/time', STEPS + 1) == seen%time), 'time')
    call is_true(all(stored('/q', 3 * (STEPS + 1)) == reshape(seen%q, [3 * (STEPS + 1)])), 'q')
    call is_true(all(stored('/mine/numbers', 3) == [1d0, 2d0, 3.5d0]), 'numbers')
    call is_true(all(stored('/parameters/speed', 1) == [0.3d0]), 'speed')
    call is_true(all(stored('/bodies/point', 9) == [0, 0, 0, 1, 0, 0, 0, 2, 0]), 'corners')
    call is_true(all(stored('/bodies/size', 9) == [0d0, 0d0, 0d0, 0.1d0, 0d0, 0d0, 0d0, 0d0, 0d0]), &
                 'sizes')
    call shows('-d /bodies/name', '"wing", "bead", "thread"')
    call shows('-d /bodies/x', '"q0 + speed*t", "q0", "0"')
    call shows('-d /bodies/angle', '"q2", "", ""')
    call shows('-d /bodies/quaternion_z', '"", "sin(q2/2)", ""')
    call shows('-d /bodies/end_y', '"", "", "q1"')
    call shows('-d /mine/words', '"one", "two"')
    call shows('-a /status', '"complete"')
    call shows('-a /model', '"bead"')
  end subroutine

  ! One of each way to be placed; a fault is named first.
  subroutine bodies(t)
    type(nsdae_trajectory), intent(in) :: t
    type(nsdae_body) :: body(3)
    type(nsdae_error) :: error
    body(1)%name = 'wing'
    body(1)%shape = NSDAE_SHAPE_POLYGON
    body(1)%position(1) = 'q0 + speed*t'
    body(1)%angle = 'q2'
    body(2)%name = 'bead'
    body(2)%shape = NSDAE_SHAPE_SPHERE
    body(2)%size(1) = 0.1d0
    body(2)%position(1) = 'q0'
    body(2)%quaternion = [character(len=10) :: 'cos(q2/2)', '0', '0', 'sin(q2/2)']
    body(3)%name = 'thread'
    body(3)%shape = NSDAE_SHAPE_SEGMENT
    body(3)%end(2) = 'q1'
    call is_int(nsdae_trajectory_set_bodies(t, body, error), NSDAE_E_ARGUMENT, 'no corners')
    call contains_text(error%text, "body 0 'wing'", 'error%text')
    call is_int(error%index, 0, 'error%index')
    body(1)%point = reshape([real(c_double) :: 0, 0, 0, 1, 0, 0, 0, 2, 0], [3, 3])
    call is_int(nsdae_trajectory_set_bodies(t, body, error), NSDAE_OK, error%text)
    call is_int(nsdae_trajectory_set_bodies(t, body, error), NSDAE_E_STATE, 'again')
  end subroutine

  ! A system has what it was given.
  subroutine bodies_of_system()
    type(nsdae_system) :: world
    type(nsdae_body) :: wing
    type(nsdae_body), allocatable :: body(:)
    call is_int(nsdae_system_create(nsdae_dims(2, 2, 0, 0, 0, 0), world), NSDAE_OK, 'world')
    call is_int(size(nsdae_system_get_bodies(world)), 0, 'none')
    wing%name = 'wing'
    wing%shape = NSDAE_SHAPE_POLYGON
    wing%size(1) = 0.5d0
    wing%position(2) = 'q1 + 1'
    wing%angle = 'q0'
    wing%point = reshape([real(c_double) :: 0, 0, 0, 1, 0, 0, 0, 2, 0], [3, 3])
    call is_int(nsdae_system_add_body(world, wing), NSDAE_OK, 'add')
    allocate (body, source=nsdae_system_get_bodies(world))
    call is_int(size(body), 1, 'one')
    call is_true(body(1)%name == 'wing' .and. body(1)%shape == NSDAE_SHAPE_POLYGON, 'what it is')
    call is_true(body(1)%position(2) == 'q1 + 1' .and. body(1)%angle == 'q0', 'where it is')
    call is_true(all(body(1)%size == wing%size) .and. all(body(1)%point == wing%point), 'its size')
    call nsdae_system_destroy(world)
  end subroutine

  ! In two parts what contents has in one.
  subroutine resumed()
    type(nsdae_trajectory) :: t
    type(nsdae_error) :: error
    type(nsdae_trajectory_info) :: info
    real(c_double) :: one(3 * (STEPS + 1))
    integer :: i
    one = stored('/q', 3 * (STEPS + 1))
    info = nsdae_trajectory_info('bead', table, .false., t_end=STEPS * 0.001d0)
    call is_int(nsdae_trajectory_create(sim, 'fortran.h5', info, t, error), NSDAE_OK, error%text)
    call is_int(nsdae_sim_init(sim, 0d0, q0, v0), NSDAE_OK, 'init')
    do i = 1, STEPS / 2
      call is_true(nsdae_sim_step(sim) >= NSDAE_OK, 'step')
    end do
    call is_int(nsdae_trajectory_close(t, NSDAE_STOPPED), NSDAE_OK, 'close')
    call shows('-a /status', '"stopped"')
    call is_int(nsdae_sim_init(sim, 0d0, q0, v0), NSDAE_OK, 'init')
    call is_int(nsdae_trajectory_resume(sim, 'fortran.h5', info, t, error), NSDAE_OK, error%text)
    call is_int(nsdae_sim_run(sim, STEPS * 0.001d0), NSDAE_OK, 'run')
    call is_int(nsdae_trajectory_close(t, NSDAE_OK), NSDAE_OK, 'close')
    call is_true(all(stored('/q', 3 * (STEPS + 1)) == one), 'the same in two parts')
    info%model = 'pearl'
    call is_int(nsdae_trajectory_resume(sim, 'fortran.h5', info, t, error), NSDAE_E_ARGUMENT, 'another model')
    call is_true(error%argument == 'model', error%text)
    call is_int(nsdae_trajectory_read_params('fortran.h5', 'parameters', table, error), NSDAE_OK, error%text)
    call is_int(nsdae_trajectory_read_params('none.h5', 'parameters', table, error), NSDAE_E_IO, 'no file')
  end subroutine

  subroutine failed_run()
    type(nsdae_trajectory) :: t
    integer(c_int) :: status
    b%term = FORCE_
    b%calls = 0
    b%at = 400
    b%code = -1
    call is_int(nsdae_trajectory_create(sim, 'fortran.h5', nsdae_trajectory_info('bead'), t), &
                NSDAE_OK, 'create')
    call is_int(nsdae_sim_init(sim, 0d0, q0, v0), NSDAE_OK, 'init')
    status = nsdae_sim_run(sim, 3d0)
    call is_int(status, NSDAE_E_CALLBACK, 'run')
    call is_int(nsdae_trajectory_close(t, status), NSDAE_OK, 'close')
    call shows('-a /status', '"failed"')
  end subroutine

  ! The doubles of a dataset, as h5dump writes them.
  function stored(path, n) result(values)
    character(len=*), intent(in) :: path
    integer, intent(in) :: n
    real(c_double) :: values(n)
    integer :: file, failed
    values = -1
    call execute_command_line('h5dump -d ' // path // ' -b LE -o fortran.bin fortran.h5 >/dev/null')
    open (newunit=file, file='fortran.bin', access='stream', form='unformatted', status='old')
    read (file, iostat=failed) values
    call is_int(failed, 0, 'reading ' // path)
    close (file, status='delete')
  end function

  ! h5dump's text with these options has the word in it.
  subroutine shows(options, word)
    character(len=*), intent(in) :: options, word
    integer :: code
    code = -1
    call execute_command_line('h5dump ' // options // ' fortran.h5 | grep -qF ''' // word // '''', &
                              exitstat=code)
    call is_int(code, 0, 'h5dump ' // options // ': ' // word)
  end subroutine

end program
