! The twin of tests/anomaly/lcp.c and tests/unit/io/lcp_file.c: solutions known by hand, what is
! proved, what is refused, what is not finite or extreme, names, files; the kernels on arrays.
program lcp
  use, intrinsic :: ieee_arithmetic
  use nsdae
  use bead_model
  use check
  implicit none

  ! Positive definite: with b = (-1, 1), x_1 alone is positive: x = (1/2, 0), y = (0, 3/2).
  real(c_double), parameter :: A(2, 2) = reshape([2d0, 1d0, 1d0, 2d0], [2, 2])
  real(c_double), parameter :: b(2) = [-1d0, 1d0]
  real(c_double), parameter :: solution(2) = [0.5d0, 0d0], slack(2) = [0d0, 1.5d0]

  call solved
  call infeasible
  call refused
  call options
  call guess
  call not_finite
  call extreme
  call names_of
  call workspace
  call kernels
  call files
  call of_a_step
  call check_done

contains

  subroutine is_solution(x, what)
    real(c_double), intent(in) :: x(:)
    character(len=*), intent(in) :: what
    ! one division by 2
    call is_near(maxval(abs(x - solution)), 0d0, 1d-15, what)
  end subroutine

  subroutine solved()
    type(nsdae_lcp_info) :: info
    type(nsdae_lcp_options) :: options
    real(c_double) :: wide(4, 4), x(2), y(2), none(0), empty(0, 0)
    x = 0
    call is_int(nsdae_lcp_solve(A, b, x, y, info=info), NSDAE_OK, 'solve')
    call is_solution(x, 'x')
    call is_near(maxval(abs(y - slack)), 0d0, 1d-15, 'y')
    call is_int(info%outcome, NSDAE_OUTCOME_SOLVED, 'outcome')
    call is_true(info%residual <= 1d-15, 'residual')
    call is_text(nsdae_outcome_name(info%outcome), 'solved', 'name of the outcome')
    ! a guess is tried first, a leading dimension that is larger is a section's
    wide = ieee_value(0d0, ieee_quiet_nan)
    wide(:2, :2) = A
    call is_int(nsdae_lcp_solve(wide(:2, :2), b, x, y, info=info), NSDAE_OK, 'guess')
    call is_int(info%stage, NSDAE_LCP_WARM, 'stage')
    call is_text(nsdae_lcp_stage_name(info%stage), 'warm', 'name of the stage')
    ! what lies between the columns is nobody's
    call is_int(nsdae_lcp_solve(wide, b, x, y), NSDAE_OK, 'leading dimension 4')
    call is_solution(x, 'x')
    call nsdae_lcp_options_default(options)
    options%stages = NSDAE_LCP_ENUMERATE
    x = 0
    call is_int(nsdae_lcp_solve(A, b, x, y, options, info), NSDAE_OK, 'enumeration')
    call is_int(info%stage, NSDAE_LCP_ENUMERATE, 'stage')
    call is_solution(x, 'x')
    call is_int(nsdae_lcp_solve(empty, none, none, none), NSDAE_OK, 'n = 0')
  end subroutine

  ! y = -1 - x has no x >= 0 with y >= 0.
  subroutine infeasible()
    type(nsdae_lcp_info) :: info
    real(c_double) :: x(1), y(1)
    x = 0
    call is_int(nsdae_lcp_solve(reshape([-1d0], [1, 1]), [-1d0], x, y, info=info), &
                NSDAE_E_INFEASIBLE, 'solve')
    call is_int(info%outcome, NSDAE_OUTCOME_INFEASIBLE, 'outcome')
    call is_int(info%proof, NSDAE_PROOF_FARKAS, 'proof')
    call is_text(nsdae_proof_name(info%proof), 'farkas', 'name of the proof')
    call is_text(nsdae_lcp_ray_name(NSDAE_LCP_RAY_NOT_COPOSITIVE), 'not copositive', 'of the ray')
  end subroutine

  subroutine refused()
    type(nsdae_lcp_options) :: options
    real(c_double) :: x(2), y(2), bad(2)
    x = 7
    y = 8
    call is_int(nsdae_lcp_solve(A(:1, :), b, x, y), NSDAE_E_ARGUMENT, 'one row')
    call is_int(nsdae_lcp_solve(A(:, :1), b, x, y), NSDAE_E_ARGUMENT, 'one column')
    call is_int(nsdae_lcp_solve(A, b, x(:1), y), NSDAE_E_ARGUMENT, 'x of one')
    call is_int(nsdae_lcp_solve(A, b, x, y(:1)), NSDAE_E_ARGUMENT, 'y of one')
    call nsdae_lcp_options_default(options)
    options%tol = -1
    call is_int(nsdae_lcp_solve(A, b, x, y, options), NSDAE_E_ARGUMENT, 'tol = -1')
    bad = [ieee_value(0d0, ieee_quiet_nan), 1d0]
    call is_int(nsdae_lcp_solve(A, bad, x, y), NSDAE_E_NONFINITE, 'NaN in b')
    call is_true(all(x == 7) .and. all(y == 8), 'x and y are as they were')
  end subroutine

  subroutine options()
    type(nsdae_lcp_options) :: good, bad(10)
    type(nsdae_lcp_info) :: info
    real(c_double) :: x(2), y(2)
    integer :: i
    call nsdae_lcp_options_default(good)
    bad = good
    bad(1)%tol = 0
    bad(2)%tol = ieee_value(0d0, ieee_quiet_nan)
    bad(3)%tol = nearest(1d0, 2d0)
    bad(4)%max_pivots = -1
    bad(5)%stages = -1
    bad(6)%stages = NSDAE_LCP_ALL + 1
    bad(7)%enumerate_max = -1
    bad(8)%enumerate_max = 25
    bad(9) = nsdae_lcp_options(0d0, 0, 0, 0)
    bad(10)%tol = -huge(0d0)
    x = -7
    y = -7
    do i = 1, size(bad)
      call is_int(nsdae_lcp_solve(A, b, x, y, bad(i), info), NSDAE_E_ARGUMENT, 'options')
      call is_int(info%outcome, NSDAE_OUTCOME_UNSOLVED, 'outcome')
      call is_true(info%residual > huge(0d0), 'residual')
      call is_true(all(x == -7) .and. all(y == -7), 'x and y are as they were')
    end do
  end subroutine

  ! The guess names the active set: any positive value, NaN none.
  subroutine guess()
    type(nsdae_lcp_options) :: warm
    type(nsdae_lcp_info) :: info
    real(c_double) :: x(2), y(2)
    call nsdae_lcp_options_default(warm)
    warm%stages = NSDAE_LCP_WARM
    x = [1d-300, ieee_value(0d0, ieee_quiet_nan)]
    call is_int(nsdae_lcp_solve(A, b, x, y, warm, info), NSDAE_OK, 'a right guess')
    call is_int(info%stage, NSDAE_LCP_WARM, 'stage')
    call is_solution(x, 'x')
    x = [0d0, ieee_value(0d0, ieee_positive_inf)]
    call is_int(nsdae_lcp_solve(A, b, x, y, warm, info), NSDAE_E_LCP, 'a wrong guess')
    call is_int(info%outcome, NSDAE_OUTCOME_UNSOLVED, 'outcome')
  end subroutine

  subroutine not_finite()
    real(c_double) :: bad(3), bad_A(2, 2), bad_b(2), x(2), y(2)
    integer :: i, j, k
    bad = [ieee_value(0d0, ieee_quiet_nan), ieee_value(0d0, ieee_positive_inf), &
           ieee_value(0d0, ieee_negative_inf)]
    x = -7
    y = -7
    do k = 1, 3
      do i = 1, 2
        do j = 1, 2
          bad_A = A
          bad_A(i, j) = bad(k)
          call is_int(nsdae_lcp_solve(bad_A, b, x, y), NSDAE_E_NONFINITE, 'A is not finite')
        end do
        bad_b = b
        bad_b(i) = bad(k)
        call is_int(nsdae_lcp_solve(A, bad_b, x, y), NSDAE_E_NONFINITE, 'b is not finite')
      end do
    end do
    call is_true(all(x == -7) .and. all(y == -7), 'x and y are as they were')
  end subroutine

  ! Numbers at the ends of the range: solved, or said not to be, and never a NaN for a solution.
  subroutine extreme()
    real(c_double) :: x(2), y(2)
    integer(c_int) :: status(2)
    integer :: e, k
    do e = -1070, 1020, 10
      x = 0
      status(1) = nsdae_lcp_solve(scale(A, e), b, x, y)
      if (status(1) == NSDAE_OK) call is_true(all(ieee_is_finite(x) .and. x >= 0), 'x')
      x = 0
      status(2) = nsdae_lcp_solve(A, scale(b, e), x, y)
      if (status(2) == NSDAE_OK) call is_true(all(ieee_is_finite(x) .and. x >= 0), 'x')
      do k = 1, 2
        call is_true(status(k) == NSDAE_OK .or. status(k) == NSDAE_E_LCP, 'solved, or said')
        if (abs(e) < 900) call is_int(status(k), NSDAE_OK, 'solved')
      end do
    end do
  end subroutine

  subroutine names_of()
    integer(c_int), parameter :: stages(9) = [NSDAE_LCP_NONE, NSDAE_LCP_TRIVIAL, NSDAE_LCP_WARM, &
        NSDAE_LCP_LEMKE, NSDAE_LCP_NEWTON, NSDAE_LCP_COVERING, NSDAE_LCP_FURTHER, NSDAE_LCP_PROVE, &
        NSDAE_LCP_ENUMERATE]
    character(len=*), parameter :: named(9) = [character(len=9) :: 'none', 'trivial', 'warm', &
        'lemke', 'newton', 'covering', 'further', 'prove', 'enumerate']
    integer :: i
    do i = 1, size(stages)
      call is_text(nsdae_lcp_stage_name(stages(i)), trim(named(i)), 'stage')
    end do
    call is_text(nsdae_lcp_stage_name(NSDAE_LCP_ALL), 'unknown', 'no stage')
    call is_text(nsdae_lcp_stage_name(-1), 'unknown', 'no stage')
    call is_text(nsdae_outcome_name(NSDAE_OUTCOME_UNSOLVED), 'unsolved', 'outcome')
    call is_text(nsdae_outcome_name(NSDAE_OUTCOME_INFEASIBLE), 'infeasible', 'outcome')
    call is_text(nsdae_outcome_name(3), 'unknown', 'no outcome')
    call is_text(nsdae_proof_name(NSDAE_PROOF_NONE), 'none', 'proof')
    call is_text(nsdae_proof_name(NSDAE_PROOF_ENUMERATED), 'enumerated', 'proof')
    call is_text(nsdae_proof_name(3), 'unknown', 'no proof')
    call is_text(nsdae_lcp_ray_name(NSDAE_LCP_RAY_NOTHING), 'nothing', 'ray')
    call is_text(nsdae_lcp_ray_name(NSDAE_LCP_RAY_NOT_STRICTLY_COPOSITIVE), &
                 'not strictly copositive', 'ray')
    call is_text(nsdae_lcp_ray_name(-1), 'unknown', 'no ray')
  end subroutine

  subroutine workspace()
    type(nsdae_lcp_info) :: info
    real(c_double), allocatable :: work(:)
    integer(c_int), allocatable :: iwork(:)
    real(c_double) :: x(2), y(2)
    integer(c_int) :: basis(2), lwork, liwork
    call is_int(nsdae_lcp_workspace(-1, lwork, liwork), NSDAE_E_ARGUMENT, 'n = -1')
    call is_int(nsdae_lcp_workspace(20001, lwork, liwork), NSDAE_E_ARGUMENT, 'n = 20001')
    call is_int(nsdae_lcp_workspace(2, lwork, liwork), NSDAE_OK, 'sizes')
    allocate (work(lwork), iwork(liwork))
    basis = 0
    x = 0
    call is_int(nsdae_lcp_solve_in(A, b, basis, x, y, work, iwork, info=info), NSDAE_OK, 'solve_in')
    call is_solution(x, 'x')
    call is_true(all(basis == [1, 0]), 'basis')
    call is_int(nsdae_lcp_solve_in(A, b, basis, x, y, work(:lwork - 1), iwork), NSDAE_E_ARGUMENT, &
                'work too short')
    call is_int(nsdae_lcp_solve_in(A, b, basis, x, y, work, iwork(:liwork - 1)), &
                NSDAE_E_ARGUMENT, 'iwork too short')
    call is_int(nsdae_lcp_solve_in(A, b, basis(:1), x, y, work, iwork), NSDAE_E_ARGUMENT, &
                'basis too short')
  end subroutine

  subroutine kernels()
    real(c_double) :: x(2), y(2), work(8), residual
    integer(c_int) :: basis(2), iwork(6), count, set
    x = solution
    call is_int(nsdae_dlcpres(2, A, 2, b, x, y, residual, work), 0, 'dlcpres')
    call is_true(all(y == slack) .and. residual == 0, 'y and residual')
    call is_int(nsdae_dlcpres(2, A, 1, b, x, y, residual, work), -3, 'lda = 1')
    x = -1
    call is_int(nsdae_dlemke(2, A, 2, b, max_pivots=9, x=x, basis=basis, pivots=count, work=work, &
                             lwork=8, iwork=iwork), 0, 'dlemke, without d')
    call is_solution(x, 'dlemke')
    call is_int(nsdae_dlemke(2, A, 2, b, [1d0, 3d0], 9, x, basis, count, work, 8, iwork), 0, &
                'dlemke')
    call is_solution(x, 'dlemke')
    call is_int(nsdae_dlemke(2, A, 2, b, [1d0, 3d0], 9, x, basis, count, work, -1, iwork), 0, &
                'dlemke, lwork')
    call is_true(work(1) == 8, 'lwork of dlemke')
    x = 0
    call is_int(nsdae_dlcppgs(2, A, 2, b, 1d0, 1d-15, 100, x, count, residual, work, 8), 0, &
                'dlcppgs')
    call is_solution(x, 'dlcppgs')
    basis = 0
    call is_int(nsdae_dlcpppm(2, A, 2, b, 1d-14, 10, 100, x, basis, count, residual, work, 8, &
                              iwork), 0, 'dlcpppm')
    call is_solution(x, 'dlcpppm')
    set = 0
    call is_int(nsdae_dlcpenum(2, A, 2, b, 1d-14, set, x, residual, work, 8, iwork), 0, 'dlcpenum')
    call is_solution(x, 'dlcpenum')
    call is_int(set, 1, 'the set of x_1')
  end subroutine

  subroutine files()
    real(c_double), allocatable :: got_A(:, :), got_b(:)
    real(c_double) :: tol
    type(nsdae_error) :: error
    integer(c_int) :: status
    integer :: file
    real(c_double) :: lopsided(2, 2), none(0), empty(0, 0)
    lopsided = reshape([1d0, 2d0, 3d0, 4d0], [2, 2])
    status = nsdae_lcp_write('fortran_lcp.h5', lopsided, b, &
                             nsdae_lcp_origin(1.5d0, 7, 1d-9, 'moreau'), error)
    if (status == NSDAE_E_UNSUPPORTED) return  ! built without HDF5
    call is_int(status, NSDAE_OK, 'write ' // error%text)
    call is_int(nsdae_lcp_read('fortran_lcp.h5', got_A, got_b, tol, error), NSDAE_OK, error%text)
    call is_true(all(got_A == lopsided) .and. all(got_b == b) .and. tol == 1d-9, 'what was read')
    call is_int(nsdae_lcp_write('fortran_lcp.h5', A, b), NSDAE_OK, 'write without origin')
    call is_int(nsdae_lcp_read('fortran_lcp.h5', got_A, got_b, tol), NSDAE_OK, 'read')
    call is_true(tol == 0, 'no tol')
    call is_int(nsdae_lcp_write('fortran_lcp.h5', A(:, :1), b, error=error), NSDAE_E_ARGUMENT, 'A')
    call is_int(nsdae_lcp_read('no/such/file.h5', got_A, got_b, error=error), NSDAE_E_IO, 'no file')
    call contains_text(error%text, 'no/such/file.h5', 'error%text')
    call is_true(.not. allocated(got_A) .and. .not. allocated(got_b), 'nothing was read')
    call is_int(nsdae_lcp_write('no/such/folder/x.h5', A, b, error=error), NSDAE_E_IO, 'no folder')
    call contains_text(error%text, 'No such file or directory', 'error%text')
    call is_int(nsdae_lcp_write('fortran_lcp.h5', empty, none), NSDAE_OK, 'write n = 0')
    call is_int(nsdae_lcp_read('fortran_lcp.h5', got_A, got_b), NSDAE_OK, 'read n = 0')
    call is_true(size(got_A) == 0 .and. size(got_b) == 0, 'n = 0')
    ! no HDF5 file at all
    open (newunit=file, file='fortran_lcp.h5', status='replace')
    write (file, '(a)') 'a text'
    close (file)
    call is_int(nsdae_lcp_read('fortran_lcp.h5', got_A, got_b, error=error), NSDAE_E_IO, 'a text')
    call contains_text(error%text, 'fortran_lcp.h5', 'error%text')
    open (newunit=file, file='fortran_lcp.h5')
    close (file, status='delete')
  end subroutine

  ! The problem of a failed step, where none has failed.
  subroutine of_a_step()
    type(bead), target :: bb
    type(nsdae_system) :: system
    type(nsdae_sim) :: sim
    type(nsdae_step_friction) :: friction
    real(c_double), pointer :: step_A(:, :), step_b(:)
    real(c_double), allocatable :: r(:), u(:)
    real(c_double) :: q0(3), v0(3)
    integer :: step, status
    call bead_start(bb, q0, v0)
    call is_int(nsdae_sim_get_failed_lcp(sim, step_A, step_b), NSDAE_E_ARGUMENT, 'no simulation')
    call is_int(bead_system(bb, system), NSDAE_OK, 'the bead')
    call is_int(nsdae_sim_create(system, sim), NSDAE_OK, 'create')
    call is_int(nsdae_sim_get_failed_lcp(sim, step_A, step_b), NSDAE_E_STATE, 'no failed step')
    call is_true(.not. associated(step_A) .and. .not. associated(step_b), 'nothing to see')
    call is_int(nsdae_sim_get_friction(sim, friction), NSDAE_E_STATE, 'not started')
    call is_int(nsdae_sim_init(sim, 0d0, q0, v0), NSDAE_OK, 'init')
    status = NSDAE_E_STATE
    do step = 1, 400
      call is_true(nsdae_sim_step(sim) >= 0, 'step')
      status = nsdae_sim_get_friction(sim, friction)
      if (status == NSDAE_OK) exit
    end do
    call is_int(status, NSDAE_OK, 'a step with a contact')
    call is_int(friction%problem%contacts, 1, 'its contact')
    allocate (r(size(friction%r)), u(size(friction%r)))
    r = 0
    call is_int(nsdae_friction_solve(friction%problem, r, u, friction%options), NSDAE_OK, 'again')
    call is_true(maxval(abs(r - friction%r)) <= 1d-9 * maxval(abs(friction%r)), 'the same impulses')
    call nsdae_sim_destroy(sim)
    call nsdae_system_destroy(system)
  end subroutine

end program
