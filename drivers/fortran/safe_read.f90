! A file that may be damaged is read once in a process of its own first, which may end or hang
! (drivers/common/safe_read.h, whose function does it here).
module pendulum_probe
  use, intrinsic :: iso_c_binding
  use nsdae_f_status, only: nsdae_error, nsdae_c_error, error_from_c, error_to_c
  implicit none
  private
  public :: reading, probe

  abstract interface
    ! Reads the file at path, with user; returns a status.
    integer(c_int) function reading(path, user, error) result(status)
      import
      character(len=*), intent(in) :: path
      class(*), intent(inout) :: user
      type(nsdae_error), intent(inout) :: error
    end function
  end interface

  type :: call_of
    procedure(reading), pointer, nopass :: read_it => null()
    class(*), pointer :: user => null()
    character(len=:), allocatable :: path
  end type

  interface
    integer(c_int) function c_probe(path, read_it, user, error) bind(C, name='probe')
      import
      character(kind=c_char), intent(in) :: path(*)
      type(c_funptr), value :: read_it
      type(c_ptr), value :: user
      type(nsdae_c_error), intent(inout) :: error
    end function
  end interface

contains

  ! The status and error of read_it in a process of its own; NSDAE_E_IO where that did not come
  ! through.
  integer(c_int) function probe(path, read_it, user, error) result(status)
    character(len=*), intent(in) :: path
    procedure(reading) :: read_it
    class(*), target, intent(inout) :: user
    type(nsdae_error), intent(inout) :: error
    type(call_of), target :: what
    type(nsdae_c_error) :: why
    what%read_it => read_it
    what%user => user
    what%path = trim(path)
    status = c_probe(what%path // c_null_char, c_funloc(in_child), c_loc(what), why)
    if (status < 0) call error_from_c(why, error)
  end function

  integer(c_int) function in_child(path, user, error) result(status) bind(C)
    character(kind=c_char), intent(in) :: path(*) ! what%path is the same
    type(c_ptr), value :: user
    type(nsdae_c_error), intent(inout) :: error
    type(call_of), pointer :: what
    type(nsdae_error) :: why
    call c_f_pointer(user, what)
    status = what%read_it(what%path, what%user, why)
    call error_to_c(why, error)
  end function

end module
