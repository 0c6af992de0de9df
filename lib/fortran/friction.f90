! nsdae/friction.h: frictional contact problems, in the global form M v = f + H r, u = H^T v + w + C
! r or the local form u = W r + q + C r, with Coulomb's second-order cone for each contact.
module nsdae_f_friction
  use, intrinsic :: iso_c_binding
  use nsdae_f_status
  use nsdae_f_text
  implicit none
  private

  ! Forms of a problem, and solvers of an island: options%stages is a sum of those.
  ! headers: constants NSDAE_FRICTION_

  ! A problem: the arrays of the C struct, as pointers to the caller's arrays (attribute target).
  ! rows, compliance and, in the local form, size, M and f may be null. first and block count from
  ! 0, as in C.
  type, public :: nsdae_friction_problem
    integer(c_int) :: form = NSDAE_FRICTION_GLOBAL
    integer(c_int) :: contacts = 0, bilateral = 0, blocks = 0
    integer(c_int), pointer, contiguous :: rows(:) => null(), size(:) => null()
    integer(c_int), pointer, contiguous :: first(:) => null(), block(:) => null()
    real(c_double), pointer, contiguous :: mu(:) => null(), w(:) => null(), compliance(:) => null()
    real(c_double), pointer, contiguous :: M(:) => null(), f(:) => null(), value(:) => null()
  end type

  ! Initialise with nsdae_friction_options_default. Limits apply to an island, over all its solvers.
  type, bind(C), public :: nsdae_friction_options
    real(c_double) :: tol             ! tolerance of the residual
    integer(c_int) :: stages
    integer(c_int) :: max_sweeps      ! 0: limited by budget only
    integer(c_int) :: max_iterations  ! 0: limited by budget only
    integer(c_int) :: refine          ! Newton steps after convergence, while the residual decreases
    real(c_double) :: budget          ! multiplications by J; 0: the default
    ! c_funloc of a nsdae_friction_progress_fn
    type(c_funptr) :: progress
    type(c_ptr) :: user
  end type

  ! State of a solve.
  type, bind(C), public :: nsdae_friction_progress
    integer(c_int) :: stage
    integer(c_int) :: island          ! from 0
    integer(c_int) :: islands
    integer(c_int) :: contacts        ! contacts and bilateral rows of this island
    real(c_double) :: residual        ! of its best iterate
    real(c_double) :: share           ! fraction of its budget used
    integer(c_long) :: sweeps
    integer(c_int) :: iterations
  end type

  abstract interface
    ! Called at the start of every solver of an island, and about ten times a second; not 0:
    ! interrupt.
    integer(c_int) function nsdae_friction_progress_fn(progress, user) bind(C)
      import
      type(nsdae_friction_progress), intent(in) :: progress
      type(c_ptr), value :: user
    end function
  end interface
  public :: nsdae_friction_progress_fn

  type, bind(C), public :: nsdae_friction_info
    integer(c_int) :: outcome
    integer(c_int) :: stage           ! the largest of all islands
    integer(c_int) :: proof
    integer(c_int) :: islands
    integer(c_long) :: sweeps
    integer(c_int) :: iterations
    integer(c_int) :: factorisations
    real(c_double) :: residual        ! of the returned r
  end type

  ! A solver that reuses its memory from problem to problem.
  type, bind(C), public :: nsdae_friction_solver
    private
    type(c_ptr) :: handle = c_null_ptr
  end type

  ! The struct of the C header.
  ! headers: type nsdae_c_friction_problem

  public :: nsdae_friction_options_default, nsdae_friction_stage_name, &
            nsdae_friction_check, nsdae_friction_solve, nsdae_friction_solve_twice, &
            nsdae_friction_residual, nsdae_friction_residual_twice, nsdae_friction_create, &
            nsdae_friction_solver_solve, nsdae_friction_destroy
  public :: problem_to_c, problem_from_c, rows_of_problem

  interface
    subroutine nsdae_friction_options_default(options) bind(C)
      import
      type(nsdae_friction_options), intent(out) :: options
    end subroutine

    ! NSDAE_OK or NSDAE_E_MEMORY.
    integer(c_int) function nsdae_friction_create(solver) bind(C)
      import
      type(nsdae_friction_solver), intent(out) :: solver
    end function

    subroutine nsdae_friction_destroy(solver) bind(C)
      import
      type(nsdae_friction_solver), intent(inout) :: solver
    end subroutine

    ! headers: functions nsdae_friction_ stage_name check solve solve_twice solver_solve residual
    ! headers: functions nsdae_friction_ residual_twice
  end interface

contains

  ! headers: wrappers nsdae_friction_ stage_name

  ! Validates a problem: NSDAE_OK, or NSDAE_E_ARGUMENT, NSDAE_E_NONFINITE, NSDAE_E_MASS,
  ! NSDAE_E_MEMORY with the argument, its value and its bound in error.
  integer(c_int) function nsdae_friction_check(problem, error) result(status)
    type(nsdae_friction_problem), intent(in) :: problem
    type(nsdae_error), intent(out), optional :: error
    type(nsdae_c_error) :: why
    status = c_check(problem_to_c(problem), why)
    call error_from_c(why, error)
  end function

  ! Solves a problem. r and u have an entry for each row. r: in, initial guess; out, the solution or
  ! the best iterate; u: out, its velocities. NSDAE_OK: solved; NSDAE_E_INFEASIBLE: no solution
  ! exists (proved); NSDAE_E_LCP: no solution found; else as nsdae_friction_check, or
  ! NSDAE_E_ARGUMENT (r or u too short).
  integer(c_int) function nsdae_friction_solve(problem, r, u, options, info) result(status)
    type(nsdae_friction_problem), intent(in) :: problem
    real(c_double), intent(inout), contiguous :: r(:), u(:)
    type(nsdae_friction_options), intent(in), optional :: options
    type(nsdae_friction_info), intent(out), optional :: info
    status = NSDAE_E_ARGUMENT
    if (.not. fits(problem, r, u)) return
    status = c_solve(problem_to_c(problem), options, r, u, info)
  end function

  ! nsdae_friction_solve for a double-double solution r + low. low has an entry for each row; out:
  ! trailing part, zero if r alone is a solution. The certificate applies to r + low; with
  ! NSDAE_E_INFEASIBLE low is unchanged. NSDAE_E_ARGUMENT: also if low is too short.
  integer(c_int) function nsdae_friction_solve_twice(problem, r, low, u, options, info) result(status)
    type(nsdae_friction_problem), intent(in) :: problem
    real(c_double), intent(inout), contiguous :: r(:), low(:), u(:)
    type(nsdae_friction_options), intent(in), optional :: options
    type(nsdae_friction_info), intent(out), optional :: info
    status = NSDAE_E_ARGUMENT
    if (.not. fits(problem, r, u, low)) return
    status = c_solve_twice(problem_to_c(problem), options, r, low, u, info)
  end function

  ! nsdae_friction_solve with the memory of a solver.
  integer(c_int) function nsdae_friction_solver_solve(solver, problem, r, u, options, info) &
      result(status)
    type(nsdae_friction_solver), intent(in) :: solver
    type(nsdae_friction_problem), intent(in) :: problem
    real(c_double), intent(inout), contiguous :: r(:), u(:)
    type(nsdae_friction_options), intent(in), optional :: options
    type(nsdae_friction_info), intent(out), optional :: info
    status = NSDAE_E_ARGUMENT
    if (.not. fits(problem, r, u)) return
    status = c_solver_solve(solver%handle, problem_to_c(problem), options, r, u, info)
  end function

  ! Residual of r, and its velocities u.
  integer(c_int) function nsdae_friction_residual(problem, r, u, residual) result(status)
    type(nsdae_friction_problem), intent(in) :: problem
    real(c_double), intent(in), contiguous :: r(:)
    real(c_double), intent(inout), contiguous :: u(:)
    real(c_double), intent(out) :: residual
    residual = 0
    status = NSDAE_E_ARGUMENT
    if (.not. fits(problem, r, u)) return
    status = c_residual(problem_to_c(problem), r, u, residual)
  end function

  ! Residual of r + low, and its velocities u.
  integer(c_int) function nsdae_friction_residual_twice(problem, r, low, u, residual) result(status)
    type(nsdae_friction_problem), intent(in) :: problem
    real(c_double), intent(in), contiguous :: r(:), low(:)
    real(c_double), intent(inout), contiguous :: u(:)
    real(c_double), intent(out) :: residual
    residual = 0
    status = NSDAE_E_ARGUMENT
    if (.not. fits(problem, r, u, low)) return
    status = c_residual_twice(problem_to_c(problem), r, low, u, residual)
  end function

  pure integer function rows_of_problem(problem) result(m)
    type(nsdae_friction_problem), intent(in) :: problem
    m = 3 * problem%contacts
    if (associated(problem%rows)) m = sum(problem%rows(:problem%contacts))
    m = m + problem%bilateral
  end function

  pure logical function fits(problem, r, u, low)
    type(nsdae_friction_problem), intent(in) :: problem
    real(c_double), intent(in) :: r(:), u(:)
    real(c_double), intent(in), optional :: low(:)
    integer :: m
    m = rows_of_problem(problem)
    fits = size(r) >= m .and. size(u) >= m
    if (present(low)) fits = fits .and. size(low) >= m
  end function

  type(nsdae_c_friction_problem) function problem_to_c(p) result(c)
    type(nsdae_friction_problem), intent(in) :: p
    c = nsdae_c_friction_problem(p%form, p%contacts, p%bilateral, integers(p%rows), reals(p%mu), &
                                 reals(p%w), reals(p%compliance), p%blocks, integers(p%size), &
                                 reals(p%M), reals(p%f), integers(p%first), integers(p%block), &
                                 reals(p%value))
  end function

  ! Pointers to the arrays of a C problem, with their shapes.
  subroutine problem_from_c(c, p)
    type(nsdae_c_friction_problem), intent(in) :: c
    type(nsdae_friction_problem), intent(out) :: p
    integer :: items, m
    items = c%contacts + c%bilateral
    p%form = c%form
    p%contacts = c%contacts
    p%bilateral = c%bilateral
    p%blocks = c%blocks
    if (c_associated(c%rows)) call c_f_pointer(c%rows, p%rows, [c%contacts])
    m = rows_of_problem(p)
    call c_f_pointer(c%mu, p%mu, [c%contacts])
    call c_f_pointer(c%w, p%w, [m])
    if (c_associated(c%compliance)) call c_f_pointer(c%compliance, p%compliance, [m])
    call c_f_pointer(c%first, p%first, [items + 1])
    call c_f_pointer(c%block, p%block, [p%first(items + 1)])
    if (c_associated(c%size)) call c_f_pointer(c%size, p%size, [c%blocks])
    if (c_associated(c%M)) call c_f_pointer(c%M, p%M, [sum(p%size**2)])
    if (c_associated(c%f)) call c_f_pointer(c%f, p%f, [sum(p%size)])
    call c_f_pointer(c%value, p%value, [values_of(p)])
  end subroutine

  ! Numbers in the blocks of all items.
  integer function values_of(p) result(count)
    type(nsdae_friction_problem), intent(in) :: p
    integer :: i, k
    count = 0
    do i = 1, p%contacts + p%bilateral
      do k = p%first(i) + 1, p%first(i + 1)
        if (p%form == NSDAE_FRICTION_LOCAL) then
          count = count + rows_of_item(p, i) * rows_of_item(p, p%block(k) + 1)
        else
          count = count + rows_of_item(p, i) * p%size(p%block(k) + 1)
        end if
      end do
    end do
  end function

  pure integer function rows_of_item(p, i) result(rows)
    type(nsdae_friction_problem), intent(in) :: p
    integer, intent(in) :: i
    rows = 1
    if (i > p%contacts) return
    rows = 3
    if (associated(p%rows)) rows = p%rows(i)
  end function

  type(c_ptr) function reals(array)
    real(c_double), pointer, contiguous, intent(in) :: array(:)
    reals = c_null_ptr
    if (associated(array)) reals = c_loc(array)
  end function

  type(c_ptr) function integers(array)
    integer(c_int), pointer, contiguous, intent(in) :: array(:)
    integers = c_null_ptr
    if (associated(array)) integers = c_loc(array)
  end function

end module
