! nsdae/trajectory.h: trajectories in HDF5 files. The layout is in docs/trajectory.md.
module nsdae_f_trajectory
  use, intrinsic :: iso_c_binding
  use nsdae_f_params
  use nsdae_f_shape
  use nsdae_f_sim
  use nsdae_f_status
  use nsdae_f_text
  implicit none
  private

  ! What the file says of the model.
  type, public :: nsdae_trajectory_info
    character(len=64) :: model = ''   ! e.g. "pendulum"
    type(nsdae_params) :: parameters = nsdae_params()  ! table of the model's parameters; empty: none
    logical :: live = .false.         ! can be read while it is written (HDF5's SWMR mode)
    integer(c_int) :: every = 1       ! keeps each such step's record; impacts and changes all
    integer(c_int) :: compress = 0    ! 1 (fast) .. 9 (small), 0: not; not with live
    real(c_double) :: t_end = 0       ! where the run is to end [s]; 0: not known
  end type

  ! The struct of the C header.
  ! headers: type nsdae_c_trajectory_info

  ! A file; nothing until nsdae_trajectory_create.
  type, public :: nsdae_trajectory
    private
    type(c_ptr) :: handle = c_null_ptr
  end type

  public :: nsdae_trajectory_create, nsdae_trajectory_put, nsdae_trajectory_put_texts, &
            nsdae_trajectory_set_bodies, nsdae_trajectory_flush, nsdae_trajectory_resume, &
            nsdae_trajectory_read_params, nsdae_trajectory_close

  interface
    ! headers: functions nsdae_trajectory_ create put put_texts set_bodies resume read_params flush close
  end interface

contains

  ! Makes the file (replacing one of that name) and adds itself to the observers of sim, which must
  ! live until it is closed. NSDAE_E_IO: the file cannot be made, the text says why;
  ! NSDAE_E_UNSUPPORTED: the library was built without HDF5; NSDAE_E_MEMORY; NSDAE_E_ARGUMENT.
  integer(c_int) function nsdae_trajectory_create(sim, path, info, trajectory, error) &
      result(status)
    type(nsdae_sim), intent(in) :: sim
    character(len=*), intent(in) :: path
    type(nsdae_trajectory_info), intent(in) :: info
    type(nsdae_trajectory), intent(out) :: trajectory
    type(nsdae_error), intent(out), optional :: error
    status = make(sim, path, info, .false., trajectory, error)
  end function

  ! Goes on in the file of an earlier run, which may have been killed at any moment: sets sim to the
  ! newest state in it and adds itself to the observers. sim and info must be those of the run that
  ! made the file, but for t_end; every and compress are the file's. NSDAE_E_ARGUMENT names what is
  ! another one; NSDAE_E_IO: the file cannot be read or has no whole state.
  integer(c_int) function nsdae_trajectory_resume(sim, path, info, trajectory, error) &
      result(status)
    type(nsdae_sim), intent(in) :: sim
    character(len=*), intent(in) :: path
    type(nsdae_trajectory_info), intent(in) :: info
    type(nsdae_trajectory), intent(out) :: trajectory
    type(nsdae_error), intent(out), optional :: error
    status = make(sim, path, info, .true., trajectory, error)
  end function

  integer(c_int) function make(sim, path, info, again, trajectory, error) result(status)
    type(nsdae_sim), intent(in) :: sim
    character(len=*), intent(in) :: path
    type(nsdae_trajectory_info), intent(in) :: info
    logical, intent(in) :: again
    type(nsdae_trajectory), intent(inout) :: trajectory
    type(nsdae_error), intent(out), optional :: error
    character(kind=c_char), target :: model(len(info%model) + 1)
    character(kind=c_char) :: c_path(len_trim(path) + 1)
    type(nsdae_c_params), target :: table
    type(nsdae_c_trajectory_info) :: to
    type(nsdae_c_error) :: why
    call to_chars(info%model, model)
    call to_chars(path, c_path)
    table = table_of(info%parameters)
    to%model = c_loc(model)
    if (table%n > 0) then
      to%parameters = c_loc(table)
      to%parameters_base = base_of(info%parameters)
    end if
    if (info%live) to%live = 1
    to%every = info%every
    to%compress = info%compress
    to%t_end = info%t_end
    if (again) then
      status = c_resume(nsdae_sim_handle(sim), c_path, to, trajectory%handle, why)
    else
      status = c_create(nsdae_sim_handle(sim), c_path, to, trajectory%handle, why)
    end if
    call error_from_c(why, error)
  end function

  ! Reads what the run that made a file was told into the fields of the table: of the group
  ! "options", "parameters" or "run" (t_end, every, compress) those keys that the table has.
  integer(c_int) function nsdae_trajectory_read_params(path, group, table, error) result(status)
    character(len=*), intent(in) :: path, group
    type(nsdae_params), intent(in) :: table
    type(nsdae_error), intent(out), optional :: error
    character(kind=c_char) :: c_path(len_trim(path) + 1), c_group(len_trim(group) + 1)
    type(nsdae_c_error) :: why
    call to_chars(path, c_path)
    call to_chars(group, c_group)
    status = c_read_params(c_path, c_group, table_of(table), base_of(table), why)
    call error_from_c(why, error)
  end function

  ! Adds a dataset of one's own, at a path such as "/compare/error". Not while the file is live.
  integer(c_int) function nsdae_trajectory_put(trajectory, path, values, units, description, &
                                               error) result(status)
    type(nsdae_trajectory), intent(in) :: trajectory
    character(len=*), intent(in) :: path, units, description
    real(c_double), intent(in), contiguous :: values(:)
    type(nsdae_error), intent(out), optional :: error
    character(kind=c_char) :: c_path(len_trim(path) + 1), c_units(len_trim(units) + 1), &
                              c_description(len_trim(description) + 1)
    type(nsdae_c_error) :: why
    call to_chars(path, c_path)
    call to_chars(units, c_units)
    call to_chars(description, c_description)
    status = c_put(trajectory%handle, c_path, size(values, kind=c_int), values, c_units, &
                   c_description, why)
    call error_from_c(why, error)
  end function

  ! The same of texts.
  integer(c_int) function nsdae_trajectory_put_texts(trajectory, path, texts, description, error) &
      result(status)
    type(nsdae_trajectory), intent(in) :: trajectory
    character(len=*), intent(in) :: path, texts(:), description
    type(nsdae_error), intent(out), optional :: error
    character(kind=c_char), target :: words(len(texts) + 1, size(texts))
    character(kind=c_char) :: c_path(len_trim(path) + 1), c_description(len_trim(description) + 1)
    type(c_ptr) :: pointers(size(texts))
    type(nsdae_c_error) :: why
    integer :: i
    call to_chars(path, c_path)
    call to_chars(description, c_description)
    do i = 1, size(texts)
      call to_chars(texts(i), words(:, i))
      pointers(i) = c_loc(words(1, i))
    end do
    status = c_put_texts(trajectory%handle, c_path, size(texts, kind=c_int), pointers, &
                         c_description, why)
    call error_from_c(why, error)
  end function

  ! Names the bodies, once and before the first step, in place of the system's. NSDAE_E_ARGUMENT: the text names the body, what
  ! of it and what is wrong, index is its number from 0; NSDAE_E_STATE; NSDAE_E_MEMORY; NSDAE_E_IO.
  integer(c_int) function nsdae_trajectory_set_bodies(trajectory, bodies, error) result(status)
    type(nsdae_trajectory), intent(in) :: trajectory
    type(nsdae_body), intent(in), target :: bodies(:)
    type(nsdae_error), intent(out), optional :: error
    type(nsdae_body_words), target :: text(size(bodies))
    type(nsdae_c_body) :: body(size(bodies))
    type(nsdae_c_error) :: why
    integer :: i
    do i = 1, size(bodies)
      body(i) = body_of(bodies(i), text(i))
    end do
    status = c_set_bodies(trajectory%handle, size(bodies, kind=c_int), body, why)
    call error_from_c(why, error)
  end function

  ! Writes what is buffered: from here on the file has every record so far, whatever becomes of the
  ! program. Runs do it four times a second by themselves. NSDAE_E_IO.
  integer(c_int) function nsdae_trajectory_flush(trajectory, error) result(status)
    type(nsdae_trajectory), intent(in) :: trajectory
    type(nsdae_error), intent(out), optional :: error
    type(nsdae_c_error) :: why
    status = c_flush(trajectory%handle, why)
    call error_from_c(why, error)
  end function

  ! Writes what is buffered, sets the attribute `status` to how the run ended, "complete",
  ! "stopped", "interrupted" or "failed", and closes the file. NSDAE_E_IO: not all could be written; the text says what the
  ! file holds. One that was not made is allowed.
  integer(c_int) function nsdae_trajectory_close(trajectory, run_status, error) result(status)
    type(nsdae_trajectory), intent(inout) :: trajectory
    integer(c_int), intent(in) :: run_status
    type(nsdae_error), intent(out), optional :: error
    type(nsdae_c_error) :: why
    status = c_close(trajectory%handle, run_status, why)
    call error_from_c(why, error)
  end function

end module
