! nsdae/version.h and nsdae/status.h: status codes and the error record.
!
! Every function returns integer(c_int): 0: success; < 0: failure, nothing was done; > 0: success
! with additional information.
module nsdae_f_status
  use, intrinsic :: iso_c_binding
  use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
  use nsdae_f_text
  implicit none
  private

  integer(c_int), parameter, public :: &
      NSDAE_VERSION_MAJOR = 0, NSDAE_VERSION_MINOR = 3, NSDAE_VERSION_PATCH = 0

  ! headers: constants NSDAE_OK NSDAE_EVENT NSDAE_ZENO NSDAE_STOPPED NSDAE_E_ NSDAE_WARN_

  ! Error record.
  type, public :: nsdae_error
    integer(c_int) :: status = NSDAE_OK
    integer(c_int) :: code = 0        ! code of the origin: return value of a callback, info of LAPACK
    integer(c_int) :: index = -1      ! entry, contact or pivot, from 0; -1: not applicable
    real(c_double) :: time = 0        ! simulated time [s]; NaN: not applicable
    character(len=32) :: argument = ''
    character(len=48) :: where = ''
    character(len=256) :: text = ''   ! argument, value, bound and remedy
  end type

  ! The struct of the C header.
  type, bind(C), public :: nsdae_c_error
    integer(c_int) :: status = NSDAE_OK, code = 0, index = -1
    real(c_double) :: time = 0
    character(kind=c_char) :: argument(32) = c_null_char
    character(kind=c_char) :: where(48) = c_null_char
    character(kind=c_char) :: text(256) = c_null_char
  end type

  public :: nsdae_version, nsdae_build_info, nsdae_status_name, nsdae_status_message
  public :: error_from_c, error_at, error_to_c, refuse, check_size, no_memory

  interface
    ! headers: functions nsdae_ version build_info status_name status_message
  end interface

contains

  ! The version of the library that runs, as "major.minor.patch".
  ! headers: wrappers nsdae_ version

  ! How this library was built, in one line.
  ! headers: wrappers nsdae_ build_info

  ! "NSDAE_E_RANK"; "unknown status" where there is none.
  ! headers: wrappers nsdae_ status_name status_message

  ! For the other modules:

  subroutine error_from_c(from, error)
    type(nsdae_c_error), intent(in) :: from
    type(nsdae_error), intent(out), optional :: error
    if (.not. present(error)) return
    error%status = from%status
    error%code = from%code
    error%index = from%index
    error%time = from%time
    call from_chars(from%argument, error%argument)
    call from_chars(from%where, error%where)
    call from_chars(from%text, error%text)
  end subroutine

  ! The record that C points to.
  function error_at(p) result(error)
    type(c_ptr), intent(in) :: p
    type(nsdae_error) :: error
    integer(c_int) :: status
    type(nsdae_c_error), pointer :: from
    if (c_associated(p)) then
      call c_f_pointer(p, from)
      call error_from_c(from, error)
    else
      status = refuse('nsdae', 'handle', 'nothing was created, or it was destroyed', error)
    end if
  end function

  subroutine error_to_c(error, to)
    type(nsdae_error), intent(in) :: error
    type(nsdae_c_error), intent(inout) :: to
    to%status = error%status
    to%code = error%code
    to%index = error%index
    to%time = error%time
    call to_chars(error%argument, to%argument)
    call to_chars(error%where, to%where)
    call to_chars(error%text, to%text)
  end subroutine

  ! NSDAE_E_ARGUMENT for errors that C cannot detect: sizes of arrays.
  integer(c_int) function refuse(where, argument, text, error) result(status)
    character(len=*), intent(in) :: where, argument, text
    type(nsdae_error), intent(out), optional :: error
    status = NSDAE_E_ARGUMENT
    if (.not. present(error)) return
    error%status = status
    error%time = ieee_value(0.0_c_double, ieee_quiet_nan)
    error%argument = argument
    error%where = where
    error%text = text
  end function

  ! NSDAE_E_ARGUMENT if an array has the wrong size.
  integer(c_int) function check_size(argument, given, needed, error) result(status)
    character(len=*), intent(in) :: argument
    integer, intent(in) :: given
    integer(c_int), intent(in) :: needed
    type(nsdae_error), intent(inout) :: error
    character(len=96) :: text
    status = NSDAE_OK
    if (given == needed) return
    write (text, '(a, " has ", i0, " entries: it must have ", i0)') argument, given, needed
    status = refuse('nsdae', argument, text, error)
  end function

  integer(c_int) function no_memory(where, error) result(status)
    character(len=*), intent(in) :: where
    type(nsdae_error), intent(out), optional :: error
    status = refuse(where, '', 'out of memory', error)
    status = NSDAE_E_MEMORY
    if (present(error)) error%status = status
  end function

end module
