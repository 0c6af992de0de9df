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

  ! Model and settings of a trajectory file.
  type, public :: nsdae_trajectory_info
    character(len=64) :: model = ''   ! e.g. "pendulum"
    type(nsdae_params) :: parameters = nsdae_params()  ! table of the model's parameters; empty: none
    logical :: live = .false.         ! readable during the run (SWMR mode of HDF5)
    integer(c_int) :: every = 1       ! every n-th record; all impacts and mode transitions
    integer(c_int) :: compress = 0    ! 1 (fast) .. 9 (small), 0: none; not with live
    real(c_double) :: t_end = 0       ! end time of the run [s]; 0: unknown
    logical :: contact_forces = .false. ! points and forces of contacts, of a system of the kit
  end type

  ! The struct of the C header.
  ! headers: type nsdae_c_trajectory_info

  ! A trajectory file; empty before nsdae_trajectory_create.
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

  ! Creates the file (replaces an existing one) and adds an observer to sim, which must live until
  ! the file is closed. NSDAE_E_IO: the file cannot be created, the text has the cause;
  ! NSDAE_E_UNSUPPORTED: built without HDF5; NSDAE_E_MEMORY; NSDAE_E_ARGUMENT.
  integer(c_int) function nsdae_trajectory_create(sim, path, info, trajectory, error) &
      result(status)
    type(nsdae_sim), intent(in) :: sim
    character(len=*), intent(in) :: path
    type(nsdae_trajectory_info), intent(in) :: info
    type(nsdae_trajectory), intent(out) :: trajectory
    type(nsdae_error), intent(out), optional :: error
    status = make(sim, path, info, .false., trajectory, error)
  end function

  ! Resumes the file of an earlier run, which may have been killed at any time: sets sim to its
  ! newest state and adds an observer. sim and info must be those of the run that created the file,
  ! except t_end; every, compress and contact_forces are those of the file. NSDAE_E_ARGUMENT: the
  ! text names the difference; NSDAE_E_IO: the file cannot be read, has no complete state, or was made by version 0.2.
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
    if (info%contact_forces) to%contact_forces = 1
    if (again) then
      status = c_resume(nsdae_sim_handle(sim), c_path, to, trajectory%handle, why)
    else
      status = c_create(nsdae_sim_handle(sim), c_path, to, trajectory%handle, why)
    end if
    call error_from_c(why, error)
  end function

  ! Reads the settings of the run that created a file into the fields of the table. group is
  ! "options", "parameters" or "run" (t_end, every, compress,
  ! contact_forces). Only keys of the table are read.
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

  ! Adds a dataset at a path such as "/compare/error". Not available with live.
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

  ! Adds a dataset of texts.
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

  ! Sets the bodies in place of the system's, once and before the first step. NSDAE_E_ARGUMENT: the
  ! text names the body, its field and the error; index is its number, from 0; NSDAE_E_STATE;
  ! NSDAE_E_MEMORY; NSDAE_E_IO.
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

  ! Writes buffered data. All records so far are then in the file, even if the program crashes. Runs
  ! flush four times a second. NSDAE_E_IO.
  integer(c_int) function nsdae_trajectory_flush(trajectory, error) result(status)
    type(nsdae_trajectory), intent(in) :: trajectory
    type(nsdae_error), intent(out), optional :: error
    type(nsdae_c_error) :: why
    status = c_flush(trajectory%handle, why)
    call error_from_c(why, error)
  end function

  ! Writes buffered data, sets the attribute `status` to "complete", "stopped", "interrupted" or
  ! "failed", and closes the file. NSDAE_E_IO: not all data were written; the text says what the
  ! file contains. An empty one is allowed.
  integer(c_int) function nsdae_trajectory_close(trajectory, run_status, error) result(status)
    type(nsdae_trajectory), intent(inout) :: trajectory
    integer(c_int), intent(in) :: run_status
    type(nsdae_error), intent(out), optional :: error
    type(nsdae_c_error) :: why
    status = c_close(trajectory%handle, run_status, why)
    call error_from_c(why, error)
  end function

end module
