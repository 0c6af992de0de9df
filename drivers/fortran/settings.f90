! Command line and parameter files of the pendulum's driver, in the contract of all drivers.
module pendulum_settings
  use nsdae
  use pendulum_model
  use pendulum_probe
  implicit none
  private
  public :: settings, settings_default, settings_parse, settings_usage, settings_release

  integer, parameter :: TEXT = 512

  type :: flag
    character(len=12) :: name
    character(len=10) :: takes  ! placeholder of its value, or ''
    character(len=8) :: key     ! name of the setting, or ''
    character(len=72) :: help
  end type

  type(flag), parameter :: flags(16) = [ &
      flag('--method', 'NAME', 'method', 'one of the methods below'), &
      flag('--dt', 'S', 'dt', 'step [s]'), &
      flag('--t-end', 'S', 't_end', 'end time [s]'), &
      flag('--rtol', 'X', 'rtol', 'relative tolerance of integrators with error control'), &
      flag('--atol', 'X', 'atol', 'absolute tolerance of these'), &
      flag('--set', 'NAME=VALUE', '', 'a parameter or option listed below; repeatable'), &
      flag('--params', 'FILE', '', 'read NAME = VALUE lines from a file'), &
      flag('--output', 'FILE.h5', 'output', 'trajectory file'), &
      flag('--restart', 'FILE.h5', '', 'continue the run of this trajectory file'), &
      flag('--every', 'N', 'every', 'record every N-th step, all impacts and the end'), &
      flag('--compress', 'LEVEL', 'compress', 'compression level: 1 (fast) .. 9 (small)'), &
      flag('--no-output', '', '', 'write no trajectory'), &
      flag('--live', '', '', 'allow concurrent readers of the trajectory (SWMR)'), &
      flag('--quiet', '', '', 'print errors only'), &
      flag('--help', '', '', 'this text'), &
      flag('--version', '', '', 'version and build')]

  type :: settings
    type(pendulum) :: model
    type(nsdae_sim_options) :: options
    real(c_double) :: t_end = 7
    integer(c_int) :: every = 1, compress = 0
    character(len=TEXT) :: output = 'pendulum.h5', restart = ''
    logical :: output_named = .false., quiet = .false., live = .false.
    logical :: help = .false., version = .false.
    type(nsdae_params) :: parameters, run, library  ! tables over the above
  end type

contains

  integer(c_int) function settings_default(s) result(status)
    type(settings), target, intent(inout) :: s
    call nsdae_sim_options_default(s%options)
    s%options%projection = NSDAE_PROJECTION_NONE ! as the program in C, whose figures are those of the method alone
    s%library = nsdae_sim_options_table(s%options)
    status = pendulum_parameters(s%model, s%parameters)
    if (status == NSDAE_OK) &
        status = nsdae_params_add(s%run, s%t_end, 't_end', 's', 'end time', 7d0, 0d0, &
                                  open=NSDAE_OPEN_MIN)
    if (status == NSDAE_OK) &
        status = nsdae_params_add(s%run, s%every, 'every', '1', &
                                  'record every N-th step in the trajectory', 1, 1, 1000000000)
    if (status == NSDAE_OK) &
        status = nsdae_params_add(s%run, s%compress, 'compress', '1', &
                                  'compression of the trajectory: 1 (fast) to 9 (small)', 0, 0, 9)
  end function

  subroutine settings_release(s)
    type(settings), intent(inout) :: s
    call nsdae_params_destroy(s%parameters)
    call nsdae_params_destroy(s%run)
  end subroutine

  ! NSDAE_E_OPTION with a text.
  integer(c_int) function complain(error, message) result(status)
    type(nsdae_error), intent(inout) :: error
    character(len=*), intent(in) :: message
    error%text = message
    error%status = NSDAE_E_OPTION
    status = NSDAE_E_OPTION
  end function

  ! Sets a parameter of the model, of the run or of the library, whichever has the name.
  integer(c_int) function set(s, name, val, error) result(status)
    type(settings), intent(inout) :: s
    character(len=*), intent(in) :: name, val
    type(nsdae_error), intent(inout) :: error
    if (nsdae_params_find(s%parameters, name) > 0) then
      status = nsdae_params_set(s%parameters, name, val, error)
    else if (nsdae_params_find(s%run, name) > 0) then
      status = nsdae_params_set(s%run, name, val, error)
    else if (nsdae_params_find(s%library, name) > 0) then
      status = nsdae_params_set(s%library, name, val, error)
    else if (name == 'output') then
      s%output = val
      s%output_named = .true.
      status = NSDAE_OK
    else
      status = unknown_name(s, name, error)
    end if
  end function

  integer(c_int) function unknown_name(s, name, error) result(status)
    type(settings), intent(in) :: s
    character(len=*), intent(in) :: name
    type(nsdae_error), intent(inout) :: error
    character(len=32) :: names(64)
    integer :: n
    n = 1
    names(1) = 'output'
    call collect(s%parameters, names, n)
    call collect(s%run, names, n)
    call collect(s%library, names, n)
    if (nsdae_suggest_name(name, names(:n)) == '') then
      ! the library also searches the descriptions of the model's parameters
      status = nsdae_params_set(s%parameters, name, '', error)
      if (index(error%text, '?') > 0) return
    end if
    status = unknown('name', name, names(:n), error)
  end function

  subroutine collect(table, names, n)
    type(nsdae_params), intent(in) :: table
    character(len=*), intent(inout) :: names(:)
    integer, intent(inout) :: n
    type(nsdae_param) :: param
    integer(c_int) :: i
    do i = 1, nsdae_params_size(table)
      param = nsdae_params_entry(table, i)
      n = min(n + 1, size(names))
      names(n) = param%key
    end do
  end subroutine

  integer(c_int) function unknown(what, word, names, error) result(status)
    character(len=*), intent(in) :: what, word, names(:)
    type(nsdae_error), intent(inout) :: error
    character(len=:), allocatable :: near
    near = nsdae_suggest_name(word, names)
    if (near /= '') then
      near = "; did you mean '" // near // "'?"
    else
      near = '; --help lists all'
    end if
    status = complain(error, 'unknown ' // what // " '" // trim(word) // "'" // near)
  end function

  ! Splits "name = value" and sets it.
  integer(c_int) function assign(s, word, error) result(status)
    type(settings), intent(inout) :: s
    character(len=*), intent(in) :: word
    type(nsdae_error), intent(inout) :: error
    integer :: equals
    equals = index(word, '=')
    if (equals == 0) then
      status = complain(error, "'" // trim(word) // "' is not of the form NAME=VALUE")
    else
      status = set(s, trim(adjustl(word(:equals - 1))), trim(adjustl(word(equals + 1:))), error)
    end if
  end function

  ! Reads "name = value" lines; '#' and ';' begin comments, [section] lines are for the reader.
  integer(c_int) function read_file(s, path, error) result(status)
    type(settings), intent(inout) :: s
    character(len=*), intent(in) :: path
    type(nsdae_error), intent(inout) :: error
    character(len=TEXT) :: line, why
    character(len=12) :: place
    integer :: file, ended, number, comment
    open (newunit=file, file=trim(path), status='old', action='read', iostat=ended, iomsg=why)
    if (ended /= 0) then
      status = complain(error, "cannot read '" // trim(path) // "': " // trim(why))
      return
    end if
    status = NSDAE_OK
    number = 0
    do while (status == NSDAE_OK)
      read (file, '(a)', iostat=ended, iomsg=why) line
      if (ended /= 0) exit
      number = number + 1
      comment = scan(line, '#;')
      if (comment > 0) line(comment:) = ''
      line = adjustl(line)
      if (line /= '' .and. line(1:1) /= '[') status = assign(s, line, error)
    end do
    close (file)
    if (status < 0) then
      write (place, '(i0)') number
      error%text = trim(path) // ' line ' // trim(place) // ': ' // error%text
    else if (.not. is_iostat_end(ended)) then
      status = complain(error, "cannot read '" // trim(path) // "': " // trim(why))
    end if
  end function

  ! Settings of the run that made the file; user is the settings.
  integer(c_int) function read_saved(path, user, error) result(status)
    character(len=*), intent(in) :: path
    class(*), intent(inout) :: user
    type(nsdae_error), intent(inout) :: error
    status = NSDAE_E_STATE
    select type (user)
    type is (settings)
      status = nsdae_trajectory_read_params(path, 'options', user%library, error)
      if (status == NSDAE_OK) &
          status = nsdae_trajectory_read_params(path, 'parameters', user%parameters, error)
      if (status == NSDAE_OK) status = nsdae_trajectory_read_params(path, 'run', user%run, error)
    end select
  end function

  integer(c_int) function read_restart(s, path, error) result(status)
    type(settings), intent(inout) :: s
    character(len=*), intent(in) :: path
    type(nsdae_error), intent(inout) :: error
    s%restart = path
    s%output = path
    status = probe(s%restart, read_saved, s, error)
    if (status == NSDAE_OK) status = read_saved(trim(s%restart), s, error)
  end function

  ! The command line: the file of --restart first, then parameter files, whatever their place, then
  ! the rest in its order.
  integer(c_int) function settings_parse(s, error) result(status)
    type(settings), intent(inout) :: s
    type(nsdae_error), intent(out) :: error
    integer :: pass, i
    do pass = 1, 3
      i = 1
      do while (i <= command_argument_count())
        status = parse_one(s, i, pass, error)
        if (status < 0) return
        i = i + 1
      end do
    end do
    status = NSDAE_OK
    if (s%restart /= '' .and. (s%live .or. s%restart /= s%output)) &
        status = complain(error, "--restart continues '" // trim(s%restart) // &
                          "': --output, --no-output and --live are not allowed")
  end function

  integer(c_int) function parse_one(s, i, pass, error) result(status)
    type(settings), intent(inout) :: s
    integer, intent(inout) :: i
    integer, intent(in) :: pass
    type(nsdae_error), intent(inout) :: error
    character(len=TEXT) :: word, val
    logical :: given
    integer :: f, equals
    call get_command_argument(i, word)
    val = ''
    equals = index(word, '=')
    given = equals > 0
    if (given) then
      val = word(equals + 1:)
      word(equals:) = ''
    end if
    if (word == '-h') word = '--help'
    do f = 1, size(flags)
      if (flags(f)%name == word) exit
    end do
    if (f > size(flags)) then
      status = unknown('option', trim(word), flags%name, error)
    else if (flags(f)%takes == '' .and. given) then
      status = complain(error, trim(word) // ' takes no value')
    else if (flags(f)%takes /= '' .and. .not. given .and. i == command_argument_count()) then
      status = complain(error, trim(word) // ' needs a value: ' // trim(word) // ' ' // &
                        flags(f)%takes)
    else
      if (flags(f)%takes /= '' .and. .not. given) then
        i = i + 1
        call get_command_argument(i, val)
      end if
      status = NSDAE_OK
      if (pass == 1 .and. flags(f)%name == '--restart') status = read_restart(s, val, error)
      if (pass == 2 .and. flags(f)%name == '--params') status = read_file(s, val, error)
      if (pass == 3) status = act(s, flags(f), val, error)
    end if
  end function

  integer(c_int) function act(s, f, val, error) result(status)
    type(settings), intent(inout) :: s
    type(flag), intent(in) :: f
    character(len=*), intent(in) :: val
    type(nsdae_error), intent(inout) :: error
    status = NSDAE_OK
    select case (f%name)
    case ('--params', '--restart')
      continue  ! read before
    case ('--set')
      status = assign(s, val, error)
    case ('--output')
      if (val == '') then
        status = complain(error, '--output needs a file name; --no-output writes none')
      else
        status = set(s, trim(f%key), trim(val), error)
      end if
    case ('--no-output')
      s%output = ''
    case ('--live')
      s%live = .true.
    case ('--quiet')
      s%quiet = .true.
    case ('--help')
      s%help = .true.
    case ('--version')
      s%version = .true.
    case default
      status = set(s, trim(f%key), trim(val), error)
    end select
  end function

  subroutine settings_usage(s)
    type(settings), intent(in) :: s
    character(len=24) :: left
    integer(c_int) :: i
    print '(a)', 'nsdae-pendulum-fortran: a uniform rod that swings and hits a stop', '', &
        'usage: nsdae-pendulum-fortran [OPTION]...', ''
    do i = 1, size(flags)
      left = trim(flags(i)%name) // ' ' // flags(i)%takes
      if (flags(i)%name == '--help') left = '-h, --help'
      print '(2x, a24, 1x, a)', left, trim(flags(i)%help)
    end do
    print '(/, a)', 'methods'
    i = 0
    do while (nsdae_method_name(i) /= '')
      left = nsdae_method_name(i)
      print '(2x, a24, 1x, a)', left, nsdae_method_summary(i)
      i = i + 1
    end do
    call print_table('parameters (name, value, meaning)', s%parameters)
    call print_table('run', s%run)
    call print_table('options', s%library)
    print '(/, a)', 'Exit status: 0 done, 1 the computation failed, 2 wrong usage.'
  end subroutine

  subroutine print_table(title, table)
    character(len=*), intent(in) :: title
    type(nsdae_params), intent(in) :: table
    type(nsdae_param) :: param
    character(len=17) :: key ! as wide as the longest name and choice of the library's options
    character(len=19) :: val
    character(len=:), allocatable :: about
    integer(c_int) :: i
    print '(/, a)', title
    do i = 1, nsdae_params_size(table)
      param = nsdae_params_entry(table, i)
      key = param%key
      val = nsdae_params_format(table, i)
      about = param%help
      if (param%unit /= '1' .and. param%unit /= '') about = about // ' [' // param%unit // ']'
      if (nsdae_params_range(table, i) /= '') about = about // ': ' // nsdae_params_range(table, i)
      print '(2x, a17, 1x, a19, 1x, a)', key, val, about
    end do
  end subroutine

end module
