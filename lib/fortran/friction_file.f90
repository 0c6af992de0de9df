! nsdae/friction_file.h: frictional contact problems in HDF5 files, in the layout of FCLIB.
module nsdae_f_friction_file
  use, intrinsic :: iso_c_binding
  use nsdae_f_friction
  use nsdae_f_status
  use nsdae_f_text
  implicit none
  private

  ! Origin of a problem.
  type, public :: nsdae_friction_origin
    real(c_double) :: time = 0       ! [s]
    integer(c_long) :: step = 0      ! number of the step, from 1
    real(c_double) :: tol = 1d-10    ! tolerance of the residual, > 0
    integer(c_int) :: refine = 0     ! see nsdae_friction_options
    character(len=32) :: method = ''
  end type

  ! The structs of the C header.
  ! headers: type nsdae_c_friction_origin

  ! headers: type nsdae_c_friction_points

  ! headers: type nsdae_c_friction_file

  ! A problem read from a file; nsdae_friction_file_release frees its arrays. guess, r and low (of a
  ! double-double solution r + low) are not associated if the file has none; velocity counts from 0,
  ! as in C.
  type, public :: nsdae_friction_file
    type(nsdae_friction_problem) :: problem
    real(c_double), pointer, contiguous :: guess(:) => null(), r(:) => null(), low(:) => null()
    real(c_double) :: tol = 0, asymmetry = 0
    integer(c_int) :: refine = 0
    integer(c_int), pointer, contiguous :: velocity(:) => null()
    type(nsdae_c_friction_file), private :: held
  end type

  public :: nsdae_friction_write, nsdae_friction_read, nsdae_friction_file_release

  interface
    ! headers: functions nsdae_friction_file_ release
    ! headers: functions nsdae_friction_ write read
  end interface

contains

  ! Writes a problem and replaces an existing file; guess, r, u and low (of a solution r + low) have
  ! an entry for each row.
  integer(c_int) function nsdae_friction_write(path, problem, guess, r, u, origin, error, low) &
      result(status)
    character(len=*), intent(in) :: path
    type(nsdae_friction_problem), intent(in) :: problem
    real(c_double), intent(in), contiguous, target, optional :: guess(:), r(:), u(:), low(:)
    type(nsdae_friction_origin), intent(in), optional :: origin
    type(nsdae_error), intent(out), optional :: error
    character(kind=c_char) :: c_path(len_trim(path) + 1)
    character(kind=c_char), target :: method(33)
    type(nsdae_c_friction_origin) :: from
    type(nsdae_c_friction_points) :: points
    type(nsdae_c_error) :: why
    logical :: enough
    integer :: rows
    rows = rows_of_problem(problem)
    enough = .true.
    points = nsdae_c_friction_points(c_null_ptr, c_null_ptr, c_null_ptr, c_null_ptr)
    if (present(guess)) then
      enough = size(guess) >= rows
      points%guess = c_loc(guess)
    end if
    if (present(r)) then
      enough = enough .and. size(r) >= rows
      points%r = c_loc(r)
    end if
    if (present(u)) then
      enough = enough .and. size(u) >= rows
      points%u = c_loc(u)
    end if
    if (present(low)) then
      enough = enough .and. size(low) >= rows
      points%low = c_loc(low)
    end if
    if (.not. enough) then
      status = refuse('nsdae_friction_write', 'r', 'guess, r, u or low has fewer entries than rows', &
                      error)
      return
    end if
    call to_chars(path, c_path)
    if (present(origin)) then
      call to_chars(origin%method, method)
      from = nsdae_c_friction_origin(origin%time, origin%step, origin%tol, &
                                     origin%refine, c_loc(method))
      status = c_write(c_path, problem_to_c(problem), points, from, why)
    else
      status = c_write(c_path, problem_to_c(problem), points, error=why)
    end if
    call error_from_c(why, error)
  end function

  ! Reads a problem; on an error file is empty.
  integer(c_int) function nsdae_friction_read(path, file, error) result(status)
    character(len=*), intent(in) :: path
    type(nsdae_friction_file), intent(out) :: file
    type(nsdae_error), intent(out), optional :: error
    character(kind=c_char) :: c_path(len_trim(path) + 1)
    type(nsdae_c_error) :: why
    integer :: m
    call to_chars(path, c_path)
    status = c_read(c_path, file%held, why)
    call error_from_c(why, error)
    if (status < 0) return
    call problem_from_c(file%held%problem, file%problem)
    m = rows_of_problem(file%problem)
    if (c_associated(file%held%guess)) call c_f_pointer(file%held%guess, file%guess, [m])
    if (c_associated(file%held%r)) call c_f_pointer(file%held%r, file%r, [m])
    if (c_associated(file%held%low)) call c_f_pointer(file%held%low, file%low, [m])
    if (c_associated(file%held%velocity)) &
        call c_f_pointer(file%held%velocity, file%velocity, [sum(file%problem%size)])
    file%tol = file%held%tol
    file%refine = file%held%refine
    file%asymmetry = file%held%asymmetry
  end function

  ! Frees what was read and nullifies its pointers.
  subroutine nsdae_friction_file_release(file)
    type(nsdae_friction_file), intent(inout) :: file
    type(nsdae_friction_file) :: empty
    type(nsdae_c_friction_file) :: held
    held = file%held
    if (associated(file%problem%first)) call c_release(held)
    empty%held = held
    file = empty
  end subroutine

end module
