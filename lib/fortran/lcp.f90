! nsdae/lcp.h and nsdae/lcp_file.h: linear complementarity problems
!
!   y = A x + b,  x >= 0,  y >= 0,  x'y = 0.
module nsdae_f_lcp
  use, intrinsic :: iso_c_binding
  use nsdae_f_status
  use nsdae_f_text
  implicit none
  private

  ! Stages of the chain, in the order in which they are tried: options%stages is a sum of these. NSDAE_LCP_RAY_: what
  ! the secondary ray on which Lemke's method ended proves about A.
  ! headers: constants NSDAE_LCP_

  ! Initialise with nsdae_lcp_options_default.
  type, bind(C), public :: nsdae_lcp_options
    real(c_double) :: tol            ! tolerance of the scaled natural residual
    integer(c_int) :: max_pivots     ! per run of Lemke's method; 0: 50 n + 100
    integer(c_int) :: stages
    integer(c_int) :: enumerate_max  ! largest n for enumeration
  end type

  type, bind(C), public :: nsdae_lcp_info
    integer(c_int) :: outcome
    integer(c_int) :: stage     ! the solver that ended it
    integer(c_int) :: proof
    integer(c_int) :: ray
    integer(c_int) :: pivots    ! of all stages
    real(c_double) :: residual  ! of the equilibrated problem; infinity without an x
  end type

  ! Origin of a problem in a file.
  type, public :: nsdae_lcp_origin
    real(c_double) :: time = 0       ! [s]
    integer(c_long) :: step = 0      ! number of the failed step, from 1
    real(c_double) :: tol = 1d-10    ! tolerance of the residual, > 0
    character(len=32) :: method = ''
  end type

  ! The structs of the C headers.
  ! headers: type nsdae_c_lcp_origin

  ! headers: type nsdae_c_lcp_file

  ! headers: type nsdae_c_lcp_problem

  public :: nsdae_lcp_options_default, nsdae_lcp_stage_name, &
            nsdae_lcp_ray_name, nsdae_lcp_solve, nsdae_lcp_solve_in, &
            nsdae_lcp_workspace, nsdae_lcp_write, nsdae_lcp_read
  public :: shape_problem

  interface
    subroutine nsdae_lcp_options_default(options) bind(C)
      import
      type(nsdae_lcp_options), intent(out) :: options
    end subroutine

    ! Sizes of the workspace of nsdae_lcp_solve_in for n rows.
    integer(c_int) function nsdae_lcp_workspace(n, lwork, liwork) bind(C)
      import
      integer(c_int), value :: n
      integer(c_int), intent(out) :: lwork, liwork
    end function

    ! headers: functions nsdae_lcp_file_ release
    ! headers: functions nsdae_lcp_ stage_name ray_name write read solve solve_in
  end interface

contains

  ! headers: wrappers nsdae_lcp_ stage_name ray_name

  ! Solves a problem. A is [n, n] (its first dimension may be larger); b, x and y are [n], n =
  ! size(b). x: in, initial guess whose positive entries are tried first; out, the solution or the
  ! best iterate. NSDAE_OK: solved; NSDAE_E_INFEASIBLE: no solution exists (proved); NSDAE_E_LCP: no
  ! solution found; NSDAE_E_ARGUMENT (shapes or options), NSDAE_E_NONFINITE, NSDAE_E_MEMORY.
  integer(c_int) function nsdae_lcp_solve(A, b, x, y, options, info) result(status)
    real(c_double), intent(in), contiguous, target :: A(:, :), b(:)
    real(c_double), intent(inout), contiguous :: x(:), y(:)
    type(nsdae_lcp_options), intent(in), optional :: options
    type(nsdae_lcp_info), intent(out), optional :: info
    status = NSDAE_E_ARGUMENT
    if (.not. fits(A, b, x, y)) return
    status = c_solve(problem_of(A, b), options, x, y, info)
  end function

  ! nsdae_lcp_solve in the caller's workspace, without allocation. basis [n]: in, 1 if x_i is
  ! expected to be positive, 0 if y_i is; out, basis of the solution. work and iwork: see
  ! nsdae_lcp_workspace.
  integer(c_int) function nsdae_lcp_solve_in(A, b, basis, x, y, work, iwork, options, info) &
      result(status)
    real(c_double), intent(in), contiguous, target :: A(:, :), b(:)
    integer(c_int), intent(inout), contiguous :: basis(:)
    real(c_double), intent(inout), contiguous :: x(:), y(:), work(:)
    integer(c_int), intent(inout), contiguous :: iwork(:)
    type(nsdae_lcp_options), intent(in), optional :: options
    type(nsdae_lcp_info), intent(out), optional :: info
    status = NSDAE_E_ARGUMENT
    if (.not. fits(A, b, x, y) .or. size(basis) < size(b)) return
    status = c_solve_in(problem_of(A, b), options, basis, x, y, info, work, &
                        size(work, kind=c_int), iwork, size(iwork, kind=c_int))
  end function

  ! Writes a problem to an HDF5 file and replaces an existing one. NSDAE_E_IO, NSDAE_E_ARGUMENT,
  ! NSDAE_E_MEMORY, NSDAE_E_UNSUPPORTED (built without HDF5).
  integer(c_int) function nsdae_lcp_write(path, A, b, origin, error) result(status)
    character(len=*), intent(in) :: path
    real(c_double), intent(in), contiguous, target :: A(:, :), b(:)
    type(nsdae_lcp_origin), intent(in), optional :: origin
    type(nsdae_error), intent(out), optional :: error
    character(kind=c_char) :: c_path(len_trim(path) + 1)
    character(kind=c_char), target :: method(33)
    type(nsdae_c_lcp_origin) :: from
    type(nsdae_c_error) :: why
    if (.not. fits(A, b, b, b)) then
      status = refuse('nsdae_lcp_write', 'A', 'A has fewer rows or columns than b', error)
      return
    end if
    call to_chars(path, c_path)
    if (present(origin)) then
      call to_chars(origin%method, method)
      from = nsdae_c_lcp_origin(origin%time, origin%step, origin%tol, c_loc(method))
      status = c_write(c_path, problem_of(A, b), from, why)
    else
      status = c_write(c_path, problem_of(A, b), error=why)
    end if
    call error_from_c(why, error)
  end function

  ! Reads a problem. tol: that of the file, 0 if missing. On an error A and b are not allocated.
  integer(c_int) function nsdae_lcp_read(path, A, b, tol, error) result(status)
    character(len=*), intent(in) :: path
    real(c_double), allocatable, intent(out) :: A(:, :), b(:)
    real(c_double), intent(out), optional :: tol
    type(nsdae_error), intent(out), optional :: error
    character(kind=c_char) :: c_path(len_trim(path) + 1)
    real(c_double), pointer :: from_A(:, :), from_b(:)
    type(nsdae_c_lcp_file) :: file
    type(nsdae_c_error) :: why
    integer :: failed
    call to_chars(path, c_path)
    status = c_read(c_path, file, why)
    call error_from_c(why, error)
    if (status < 0) return
    if (present(tol)) tol = file%tol
    allocate (A(file%n, file%n), b(file%n), stat=failed)
    if (failed /= 0) then
      if (allocated(A)) deallocate (A)
      status = no_memory('nsdae_lcp_read', error)
    else if (file%n > 0) then
      call shape_problem(nsdae_c_lcp_problem(file%n, file%A, file%n, file%b), from_A, from_b)
      A = from_A
      b = from_b
    end if
    call c_release(file)
  end function

  ! The arrays of a C problem with their shapes, for the other modules too.
  subroutine shape_problem(problem, A, b)
    type(nsdae_c_lcp_problem), intent(in) :: problem
    real(c_double), pointer, intent(out) :: A(:, :), b(:)
    call c_f_pointer(problem%A, A, [problem%lda, problem%n])
    A => A(:problem%n, :)
    call c_f_pointer(problem%b, b, [problem%n])
  end subroutine

  pure logical function fits(A, b, x, y)
    real(c_double), intent(in) :: A(:, :), b(:), x(:), y(:)
    integer :: n
    n = size(b)
    fits = size(A, 1) >= n .and. size(A, 2) >= n .and. size(x) >= n .and. size(y) >= n
  end function

  type(nsdae_c_lcp_problem) function problem_of(A, b) result(problem)
    real(c_double), intent(in), contiguous, target :: A(:, :), b(:)
    real(c_double), target, save :: nothing(1) = 0
    problem%n = size(b, kind=c_int)
    problem%lda = max(1_c_int, size(A, 1, kind=c_int))
    problem%A = c_loc(nothing)
    problem%b = c_loc(nothing)
    if (size(b) == 0) return
    problem%A = c_loc(A)
    problem%b = c_loc(b)
  end function

end module
