! nsdae/params.h: tables that describe the fields of a variable: defaults, ranges, set-by-key,
! printing and attributes of trajectory files.
!
! nsdae_params_add adds a field to a table, which stores its address. Fields must be targets, parts
! of one variable, and outlive the table.
module nsdae_f_params
  use, intrinsic :: iso_c_binding
  use nsdae_f_status
  use nsdae_f_text
  implicit none
  private

  ! headers: constants NSDAE_PARAM_

  ! Which bound of a range is itself excluded.
  ! headers: constants NSDAE_OPEN_ NSDAE_OR_ZERO

  ! The structs of the C header.
  ! headers: type nsdae_c_param

  ! headers: type nsdae_c_params

  ! An entry for Fortran.
  type, public :: nsdae_param
    character(len=:), allocatable :: key, unit, help
    integer(c_int) :: type = NSDAE_PARAM_REAL
    real(c_double) :: initial = 0, min = 0, max = 0
    integer(c_int) :: open = 0
    character(len=:), allocatable :: choices  ! the names, separated by blanks
  end type

  ! The texts of an entry.
  type :: owned
    character(kind=c_char), pointer :: key(:) => null(), unit(:) => null(), help(:) => null()
    character(kind=c_char), pointer :: words(:, :) => null()
    type(c_ptr), pointer :: choices(:) => null()
  end type

  type, public :: nsdae_params
    private
    type(c_ptr) :: entry = c_null_ptr  ! the first of n
    integer(c_int) :: n = 0
    type(c_ptr) :: base = c_null_ptr   ! base address of the offsets
    type(nsdae_c_param), pointer :: made(:) => null()
    type(owned), pointer :: texts(:) => null()
  end type

  ! Adds a field to a table; status = nsdae_params_add(...):
  !
  !   (table, field, key, unit, help, initial, min, max, open)  a real or an integer
  !   (table, field, key, help, choices, initial)               a choice: an integer from 0
  !   (table, field, key, help)                                 a text, empty at first
  !
  ! A text is an array of NSDAE_PARAM_TEXT_SIZE characters, ended by a null character;
  ! nsdae_params_format reads it. min and max default to -infinity and infinity, open to 0.
  ! NSDAE_OK; NSDAE_E_MEMORY, or NSDAE_E_ARGUMENT for a shorter array: the table is unchanged.
  interface nsdae_params_add
    module procedure add_real, add_int, add_choice, add_text
  end interface

  public :: nsdae_params_add, nsdae_params_destroy, nsdae_params_default, nsdae_params_set, &
            nsdae_params_check, nsdae_params_find, nsdae_params_format, nsdae_params_range, nsdae_params_size, &
            nsdae_params_entry, nsdae_suggest_name
  public :: table_at, table_of, base_of

  interface
    ! headers: functions nsdae_params_ default set check format range
    ! headers: functions nsdae_ suggest_name
  end interface

contains

  integer(c_int) function add_real(table, field, key, unit, help, initial, min, max, open) &
      result(status)
    type(nsdae_params), intent(inout) :: table
    real(c_double), pointer, intent(in) :: field
    character(len=*), intent(in) :: key, unit, help
    real(c_double), intent(in) :: initial
    real(c_double), intent(in), optional :: min, max
    integer(c_int), intent(in), optional :: open
    type(nsdae_c_param) :: param
    param = blank(NSDAE_PARAM_REAL, initial)
    if (present(min)) param%min = min
    if (present(max)) param%max = max
    if (present(open)) param%open = open
    status = append(table, c_loc(field), param, key, unit, help)
  end function

  integer(c_int) function add_int(table, field, key, unit, help, initial, min, max) result(status)
    type(nsdae_params), intent(inout) :: table
    integer(c_int), pointer, intent(in) :: field
    character(len=*), intent(in) :: key, unit, help
    integer(c_int), intent(in) :: initial
    integer(c_int), intent(in), optional :: min, max
    type(nsdae_c_param) :: param
    param = blank(NSDAE_PARAM_INT, real(initial, c_double))
    param%min = -huge(0_c_int)
    param%max = huge(0_c_int)
    if (present(min)) param%min = min
    if (present(max)) param%max = max
    status = append(table, c_loc(field), param, key, unit, help)
  end function

  integer(c_int) function add_choice(table, field, key, help, choices, initial) result(status)
    type(nsdae_params), intent(inout) :: table
    integer(c_int), pointer, intent(in) :: field
    character(len=*), intent(in) :: key, help, choices(:)
    integer(c_int), intent(in), optional :: initial
    type(nsdae_c_param) :: param
    param = blank(NSDAE_PARAM_CHOICE, 0.0_c_double)
    if (present(initial)) param%initial = initial
    param%min = 0
    param%max = size(choices) - 1
    status = append(table, c_loc(field), param, key, '', help, choices)
  end function

  integer(c_int) function add_text(table, field, key, help) result(status)
    type(nsdae_params), intent(inout) :: table
    character(kind=c_char), pointer, contiguous, intent(in) :: field(:)
    character(len=*), intent(in) :: key, help
    type(c_ptr) :: at
    status = NSDAE_E_ARGUMENT
    if (size(field) < NSDAE_PARAM_TEXT_SIZE) return
    at = c_loc(field)  ! as an argument gfortran 12 gives it a length, and key and help the wrong ones
    status = append(table, at, blank(NSDAE_PARAM_TEXT, 0.0_c_double), key, '', help)
  end function

  type(nsdae_c_param) function blank(kind, initial) result(param)
    use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_negative_inf, ieee_positive_inf
    integer(c_int), intent(in) :: kind
    real(c_double), intent(in) :: initial
    param = nsdae_c_param(c_null_ptr, c_null_ptr, c_null_ptr, kind, 0, initial, &
                          ieee_value(initial, ieee_negative_inf), &
                          ieee_value(initial, ieee_positive_inf), 0, c_null_ptr)
  end function

  ! Adds an entry. All operations that can fail precede the change of the table.
  integer(c_int) function append(table, field, param, key, unit, help, choices) result(status)
    type(nsdae_params), intent(inout) :: table
    type(c_ptr), intent(in) :: field
    type(nsdae_c_param), intent(in) :: param
    character(len=*), intent(in) :: key, unit, help
    character(len=*), intent(in), optional :: choices(:)
    type(nsdae_c_param), pointer :: made(:)
    type(owned), pointer :: texts(:)
    type(owned) :: last
    integer :: n, failed
    status = NSDAE_E_MEMORY
    n = table%n
    call keep(last, key, unit, help, choices, failed)
    if (failed /= 0) return
    allocate (made(n + 1), texts(n + 1), stat=failed)
    if (failed /= 0) then
      if (associated(made)) deallocate (made)
      call let_go(last)
      return
    end if
    if (n > 0) then
      made(:n) = table%made
      texts(:n) = table%texts
      deallocate (table%made, table%texts)
    end if
    made(n + 1) = param
    made(n + 1)%key = c_loc(last%key)
    made(n + 1)%unit = c_loc(last%unit)
    made(n + 1)%help = c_loc(last%help)
    if (associated(last%choices)) made(n + 1)%choices = c_loc(last%choices)
    texts(n + 1) = last
    table%made => made
    table%texts => texts
    table%n = table%n + 1_c_int
    table%entry = c_loc(made)
    call place(table, field)
    status = NSDAE_OK
  end function

  ! The offset of the last entry, or new offsets for all if its address is the lowest.
  subroutine place(table, field)
    type(nsdae_params), intent(inout) :: table
    type(c_ptr), intent(in) :: field
    integer(c_intptr_t) :: shift
    if (table%n == 1) table%base = field
    shift = transfer(field, shift) - transfer(table%base, shift)
    if (shift < 0) then
      table%base = field
      table%made%offset = table%made%offset - shift
      shift = 0
    end if
    table%made(table%n)%offset = shift
  end subroutine

  ! Copies of the texts; on an error none is kept.
  subroutine keep(texts, key, unit, help, choices, failed)
    type(owned), intent(out) :: texts
    character(len=*), intent(in) :: key, unit, help
    character(len=*), intent(in), optional :: choices(:)
    integer, intent(out) :: failed
    allocate (texts%key(len_trim(key) + 1), texts%unit(len_trim(unit) + 1), &
              texts%help(len_trim(help) + 1), stat=failed)
    if (failed == 0 .and. present(choices)) &
        allocate (texts%words(len(choices) + 1, size(choices)), &
                  texts%choices(size(choices) + 1), stat=failed)
    if (failed /= 0) then
      call let_go(texts)
      return
    end if
    call to_chars(key, texts%key)
    call to_chars(unit, texts%unit)
    call to_chars(help, texts%help)
    if (present(choices)) call c_names(choices, texts%words, texts%choices)
  end subroutine

  subroutine let_go(texts)
    type(owned), intent(inout) :: texts
    if (associated(texts%key)) deallocate (texts%key)
    if (associated(texts%unit)) deallocate (texts%unit)
    if (associated(texts%help)) deallocate (texts%help)
    if (associated(texts%words)) deallocate (texts%words)
    if (associated(texts%choices)) deallocate (texts%choices)
  end subroutine

  ! Names for C: pointers to the words, the last one NULL.
  subroutine c_names(names, words, pointers)
    character(len=*), intent(in) :: names(:)
    character(kind=c_char), target, intent(out) :: words(:, :)
    type(c_ptr), intent(out) :: pointers(:)
    integer :: i
    do i = 1, size(names)
      call to_chars(names(i), words(:, i))
      pointers(i) = c_loc(words(1, i))
    end do
    pointers(size(names) + 1) = c_null_ptr
  end subroutine

  ! Frees the entries; the table is then empty.
  subroutine nsdae_params_destroy(table)
    type(nsdae_params), intent(inout) :: table
    integer :: i
    if (associated(table%made)) then
      do i = 1, table%n
        call let_go(table%texts(i))
      end do
      deallocate (table%made, table%texts)
    end if
    table = nsdae_params()
  end subroutine

  ! Sets all fields to their defaults.
  subroutine nsdae_params_default(table)
    type(nsdae_params), intent(in) :: table
    call c_default(table_of(table), table%base)
  end subroutine

  ! Sets one field from text. NSDAE_E_OPTION: no such key (the text suggests the nearest one) or no
  ! such choice. NSDAE_E_ARGUMENT: not a number, or out of range; the field is unchanged.
  integer(c_int) function nsdae_params_set(table, key, val, error) result(status)
    type(nsdae_params), intent(in) :: table
    character(len=*), intent(in) :: key, val
    type(nsdae_error), intent(out), optional :: error
    character(kind=c_char) :: c_key(len_trim(key) + 1), c_val(len_trim(val) + 1)
    type(nsdae_c_error) :: why
    call to_chars(key, c_key)
    call to_chars(val, c_val)
    status = c_set(table_of(table), table%base, c_key, c_val, why)
    call error_from_c(why, error)
  end function

  ! Checks every field against its range. NSDAE_E_ARGUMENT: the text names the first field out of
  ! range.
  integer(c_int) function nsdae_params_check(table, error) result(status)
    type(nsdae_params), intent(in) :: table
    type(nsdae_error), intent(out), optional :: error
    type(nsdae_c_error) :: why
    status = c_check(table_of(table), table%base, why)
    call error_from_c(why, error)
  end function

  integer(c_int) function nsdae_params_size(table)
    type(nsdae_params), intent(in) :: table
    nsdae_params_size = table%n
  end function

  ! Number of the entry of a key, 1 .. nsdae_params_size; 0 if there is none.
  integer(c_int) function nsdae_params_find(table, key) result(i)
    type(nsdae_params), intent(in) :: table
    character(len=*), intent(in) :: key
    type(nsdae_c_param), pointer :: entries(:)
    entries => entries_of(table)
    do i = 1, table%n
      if (from_c(entries(i)%key) == key) return
    end do
    i = 0
  end function

  ! Entry i, 1 .. nsdae_params_size.
  type(nsdae_param) function nsdae_params_entry(table, i) result(param)
    type(nsdae_params), intent(in) :: table
    integer(c_int), intent(in) :: i
    type(nsdae_c_param), pointer :: entries(:), from
    entries => entries_of(table)
    from => entries(i)
    param%key = from_c(from%key)
    param%unit = from_c(from%unit)
    param%help = from_c(from%help)
    param%type = from%type
    param%initial = from%initial
    param%min = from%min
    param%max = from%max
    param%open = from%open
    param%choices = ''
    if (from%type == NSDAE_PARAM_CHOICE) param%choices = joined(from%choices, nint(from%max) + 1)
  end function

  function joined(names, n) result(text)
    type(c_ptr), intent(in) :: names
    integer, intent(in) :: n
    character(len=:), allocatable :: text
    type(c_ptr), pointer :: name(:)
    integer :: i
    call c_f_pointer(names, name, [n])
    text = ''
    do i = 1, n
      text = trim(text // ' ' // from_c(name(i)))
    end do
    text = trim(adjustl(text))
  end function

  ! Range of entry i as text: "greater than 0", "at least 1 and at most 5", "a finite number". For a
  ! choice its names; empty for a text.
  function nsdae_params_range(table, i) result(text)
    type(nsdae_params), intent(in) :: table
    integer(c_int), intent(in) :: i
    character(len=:), allocatable :: text
    character(len=NSDAE_PARAM_TEXT_SIZE) :: padded
    character(kind=c_char) :: s(NSDAE_PARAM_TEXT_SIZE)
    type(nsdae_c_param), pointer :: entries(:)
    entries => entries_of(table)
    call c_range(entries(i), s, size(s, kind=c_size_t))
    call from_chars(s, padded)
    text = trim(padded)
  end function

  ! Value of entry i as text; nsdae_params_set reads it back to the same value.
  function nsdae_params_format(table, i) result(text)
    type(nsdae_params), intent(in) :: table
    integer(c_int), intent(in) :: i
    character(len=:), allocatable :: text
    character(len=NSDAE_PARAM_TEXT_SIZE) :: padded
    character(kind=c_char) :: s(NSDAE_PARAM_TEXT_SIZE)
    type(nsdae_c_param), pointer :: entries(:)
    entries => entries_of(table)
    call c_format(entries(i), table%base, s, size(s, kind=c_size_t))
    call from_chars(s, padded)
    text = trim(padded)
  end function

  ! The entry of names nearest to word by edit distance; '' if none is near enough.
  function nsdae_suggest_name(word, names) result(near)
    character(len=*), intent(in) :: word, names(:)
    character(len=:), allocatable :: near
    character(kind=c_char), target :: words(len(names) + 1, size(names))
    character(kind=c_char) :: c_word(len_trim(word) + 1)
    type(c_ptr) :: pointers(size(names) + 1)
    call c_names(names, words, pointers)
    call to_chars(word, c_word)
    near = from_c(c_suggest_name(c_word, pointers))
  end function

  ! For the other modules:

  ! A table of the library, for the variable at base.
  type(nsdae_params) function table_at(p, base) result(table)
    type(c_ptr), intent(in) :: p, base
    type(nsdae_c_params), pointer :: from
    call c_f_pointer(p, from)
    table%entry = from%entry
    table%n = from%n
    table%base = base
  end function

  type(nsdae_c_params) function table_of(table)
    type(nsdae_params), intent(in) :: table
    table_of = nsdae_c_params(table%entry, table%n)
  end function

  type(c_ptr) function base_of(table)
    type(nsdae_params), intent(in) :: table
    base_of = table%base
  end function

  function entries_of(table) result(entries)
    type(nsdae_params), intent(in) :: table
    type(nsdae_c_param), pointer :: entries(:)
    entries => null()
    if (table%n > 0) call c_f_pointer(table%entry, entries, [table%n])
  end function

end module
