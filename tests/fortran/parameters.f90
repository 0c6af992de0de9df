! The twin of tests/unit/base/params.c: tables over a variable of one's own.
program parameters
  use nsdae
  use check
  implicit none

  type :: rod
    integer(c_int) :: shape = -1
    real(c_double) :: L = 0, m = 0
    integer(c_int) :: parts = 0
    character(kind=c_char) :: name(NSDAE_PARAM_TEXT_SIZE) = 'x', short(NSDAE_PARAM_TEXT_SIZE - 1)
  end type

  type(rod), target :: r
  type(nsdae_params) :: table
  type(nsdae_error) :: error
  type(nsdae_param) :: param

  ! not in the order of the fields
  call is_int(nsdae_params_add(table, r%m, 'm', 'kg', 'mass', 4.9d0, min=0d0, &
                               open=NSDAE_OPEN_MIN), NSDAE_OK, 'add')
  call is_int(nsdae_params_add(table, r%L, 'L', 'm', 'length', 1d0, min=0d0, max=2d0), &
              NSDAE_OK, 'add')
  call is_int(nsdae_params_add(table, r%parts, 'parts', '1', 'how many', 3, min=1), NSDAE_OK, 'add')
  call is_int(nsdae_params_add(table, r%shape, 'shape', 'cross-section', &
                               [character(len=6) :: 'round', 'square'], 1), NSDAE_OK, 'add')
  call is_int(nsdae_params_size(table), 4, 'size')
  call nsdae_params_default(table)
  call is_true(r%m == 4.9d0 .and. r%L == 1 .and. r%parts == 3 .and. r%shape == 1, 'defaults')
  call is_int(nsdae_params_set(table, 'L', '1.5'), NSDAE_OK, 'L')
  call is_int(nsdae_params_set(table, 'shape', 'round'), NSDAE_OK, 'shape')
  call is_true(r%m == 4.9d0 .and. r%L == 1.5d0 .and. r%parts == 3 .and. r%shape == 0, 'set')
  call is_text(nsdae_params_format(table, nsdae_params_find(table, 'm')), '4.9', 'm')
  call is_text(nsdae_params_format(table, 4), 'round', 'shape')
  call is_text(nsdae_params_range(table, 2), 'at least 0 and at most 2', 'range of L')
  call is_text(nsdae_params_range(table, 4), 'round or square', 'range of shape')
  call is_int(nsdae_params_set(table, 'm', '0', error), NSDAE_E_ARGUMENT, 'm = 0')
  call contains_text(error%text, 'greater than 0', 'error%text')
  call is_int(nsdae_params_set(table, 'L', '2.5', error), NSDAE_E_ARGUMENT, 'L = 2.5')
  call is_int(nsdae_params_set(table, 'part', '2', error), NSDAE_E_OPTION, 'part')
  call contains_text(error%text, "'parts'", 'error%text')
  call is_int(nsdae_params_set(table, 'shape', 'squar', error), NSDAE_E_OPTION, 'squar')
  call contains_text(error%text, "'square'", 'error%text')
  call is_int(nsdae_params_check(table, error), NSDAE_OK, 'check')
  r%parts = 0
  call is_int(nsdae_params_check(table, error), NSDAE_E_ARGUMENT, 'parts = 0')
  call is_text(error%argument, 'parts', 'error%argument')
  param = nsdae_params_entry(table, 1)
  call is_text(param%key // ' ' // param%unit // ' ' // param%help, 'm kg mass', 'entry 1')
  call is_int(param%open, NSDAE_OPEN_MIN, 'open')
  param = nsdae_params_entry(table, 4)
  call is_text(param%choices, 'round square', 'choices')
  r%parts = 1
  call texts
  call not_numbers
  call formats
  call nsdae_params_destroy(table)
  call is_int(nsdae_params_size(table), 0, 'size after destroy')
  call is_int(nsdae_params_find(table, 'm'), 0, 'find after destroy')
  call nsdae_params_destroy(table)
  call check_done

contains

  subroutine texts()
    integer(c_int) :: i
    call is_int(nsdae_params_add(table, r%short, 'short', 'too short'), NSDAE_E_ARGUMENT, 'short')
    call is_int(nsdae_params_size(table), 4, 'the table is as it was')
    call is_int(nsdae_params_add(table, r%name, 'name', 'what it is called'), NSDAE_OK, 'add')
    call nsdae_params_default(table)
    i = nsdae_params_find(table, 'name')
    call is_text(nsdae_params_format(table, i), '', 'default')
    call is_int(nsdae_params_set(table, 'name', 'a b c'), NSDAE_OK, 'name')
    call is_text(nsdae_params_format(table, i), 'a b c', 'name')
    call is_int(nsdae_params_set(table, 'name', repeat('a', 256), error), NSDAE_E_ARGUMENT, 'long')
    call contains_text(error%text, 'longer than 255', 'error%text')
    call is_int(nsdae_params_set(table, 'name', repeat('a', 255)), NSDAE_OK, 'not too long')
    call is_true(len(nsdae_params_format(table, i)) == 255, 'length')
    param = nsdae_params_entry(table, i)
    call is_int(param%type, NSDAE_PARAM_TEXT, 'type')
    call is_int(nsdae_params_check(table, error), NSDAE_OK, 'check')
  end subroutine

  ! Refused, and nothing changed. Blanks at the end are those of Fortran.
  subroutine refused(key, val, status, says)
    character(len=*), intent(in) :: key, val, says
    integer(c_int), intent(in) :: status
    type(rod) :: before
    before = r
    call is_int(nsdae_params_set(table, key, val, error), status, key // ' = ' // val)
    call is_int(error%status, status, 'error%status')
    call is_text(error%argument, key, 'error%argument')
    call contains_text(error%text, says, 'error%text')
    call is_true(r%L == before%L .and. r%m == before%m .and. r%parts == before%parts .and. &
                 r%shape == before%shape, 'nothing changed')
  end subroutine

  subroutine not_numbers()
    character(len=*), parameter :: bad(9) = [character(len=5) :: '', 'x', '1x', '1,5', '1e', &
        '--1', '1.0.0', '0x', 'one']
    character(len=*), parameter :: broken(4) = [character(len=6) :: '1.5', '0.9999', '1e10', '-3e9']
    character(len=*), parameter :: endless(4) = [character(len=5) :: 'nan', 'inf', '-inf', '1e999']
    integer :: i
    do i = 1, size(bad)
      call refused('m', bad(i), NSDAE_E_ARGUMENT, 'not a number')
      call refused('parts', bad(i), NSDAE_E_ARGUMENT, 'not a number')
    end do
    do i = 1, size(broken)
      call refused('parts', broken(i), NSDAE_E_ARGUMENT, 'whole number')
    end do
    do i = 1, size(endless)
      call refused('m', endless(i), NSDAE_E_ARGUMENT, 'outside its range')
      call refused('parts', endless(i), NSDAE_E_ARGUMENT, 'outside its range')
    end do
    call refused('m', '-1e-300', NSDAE_E_ARGUMENT, 'greater than 0')
    call refused('L', '2.0000001', NSDAE_E_ARGUMENT, 'at least 0 and at most 2')
    call refused('parts', '0', NSDAE_E_ARGUMENT, 'at least 1')
    call refused('Parts', '1', NSDAE_E_OPTION, "did you mean 'parts'?")
    call refused('qqqqqqqqqq', '1', NSDAE_E_OPTION, "unknown name 'qqqqqqqqqq'")
    call refused('shape', '1', NSDAE_E_OPTION, 'round, square')
  end subroutine

  ! What is written reads back as the same value.
  subroutine formats()
    real(c_double), parameter :: awkward(8) = [0.1d0, 1d0 / 3, tiny(1d0), huge(1d0), 1d23, &
        9007199254740993d0, 3.141592653589793d0, 1 + epsilon(1d0)]
    character(len=:), allocatable :: text
    integer :: i
    do i = 1, size(awkward)
      r%m = awkward(i)
      text = nsdae_params_format(table, 1)
      r%m = 0
      call is_int(nsdae_params_set(table, 'm', text), NSDAE_OK, text)
      call is_near(r%m, awkward(i), 0d0, text)
    end do
  end subroutine

end program
