! The twin of tests/anomaly/kernels.c: every kernel through the module, with each argument broken that
! Fortran can break (its arrays are always there), asked for its workspace, at n = 0, and with data
! that are not finite or overflow.
program kernels
  use, intrinsic :: ieee_arithmetic
  use nsdae
  use check
  implicit none

  integer, parameter :: N = 3, WORK = N * (N + 2)
  integer, parameter :: RESIDUAL = 1, LEMKE = 2, PGS = 3, PRINCIPAL = 4, ENUMERATE = 5, KERNELS_ = 5
  character(len=*), parameter :: NAMES(KERNELS_) = [character(len=8) :: 'dlcpres', 'dlemke', &
                                                    'dlcppgs', 'dlcpppm', 'dlcpenum']
  integer(c_int), parameter :: NEEDS(KERNELS_) = [0, WORK, 2 * N, WORK, WORK]
  real(c_double), parameter :: SOLUTION(N) = [1d0, 0d0, 2d0]

  ! All arguments of all kernels; the solution is x = (1, 0, 2), y = (0, 1, 0).
  type :: call
    integer(c_int) :: n = N, lda = N, max = 100, block = 10, lwork = WORK
    real(c_double) :: omega = 1, tol = 1d-12
    real(c_double) :: a(N, N) = reshape([4d0, 1d0, 1d0, 1d0, 5d0, -1d0, 1d0, -1d0, 6d0], [N, N])
    real(c_double) :: b(N) = [-6d0, 2d0, -13d0], d(N) = 1, x(N) = 0, y(N) = 0
    real(c_double) :: work(WORK) = 0, residual = 0
    integer(c_int) :: basis(N) = 0, iwork(3 * N) = 0, count = 0, set = 0
  end type

  real(c_double) :: nan, infinity
  integer :: k

  nan = ieee_value(nan, ieee_quiet_nan)
  infinity = ieee_value(nan, ieee_positive_inf)
  do k = 1, KERNELS_
    call good(k)
    call matrix(k)
    call not_finite(k)
    call overflow(k)
    call empty(k)
    if (k > RESIDUAL) call workspace(k)
  end do
  call others
  call friction
  call check_done

contains

  integer(c_int) function run(k, c) result(info)
    integer, intent(in) :: k
    type(call), intent(inout) :: c
    select case (k)
    case (RESIDUAL)
      info = nsdae_dlcpres(c%n, c%a, c%lda, c%b, c%x, c%y, c%residual, c%work)
    case (LEMKE)
      info = nsdae_dlemke(c%n, c%a, c%lda, c%b, c%d, c%max, c%x, c%basis, c%count, c%work, &
                          c%lwork, c%iwork)
    case (PGS)
      info = nsdae_dlcppgs(c%n, c%a, c%lda, c%b, c%omega, c%tol, c%max, c%x, c%count, c%residual, &
                           c%work, c%lwork)
    case (PRINCIPAL)
      info = nsdae_dlcpppm(c%n, c%a, c%lda, c%b, c%tol, c%block, c%max, c%x, c%basis, c%count, &
                           c%residual, c%work, c%lwork, c%iwork)
    case default
      info = nsdae_dlcpenum(c%n, c%a, c%lda, c%b, c%tol, c%set, c%x, c%residual, c%work, c%lwork, &
                            c%iwork)
    end select
  end function

  subroutine good(k)
    integer, intent(in) :: k
    type(call) :: c
    if (k == RESIDUAL) c%x = SOLUTION
    call is_int(run(k, c), 0, NAMES(k))
    call is_near(maxval(abs(c%x - SOLUTION)), 0d0, 1d-11, 'x of ' // NAMES(k))
    call is_true(c%residual <= c%tol, 'residual of ' // NAMES(k))
  end subroutine

  ! The argument of that number is broken in c: nothing is done.
  subroutine broken(k, c, argument)
    integer, intent(in) :: k
    type(call), intent(in) :: c
    integer(c_int), intent(in) :: argument
    type(call) :: after
    after = c
    call is_int(run(k, after), -argument, NAMES(k))
    call is_true(same(after%x, c%x) .and. same([after%residual], [c%residual]) .and. &
                 all(after%basis == c%basis) .and. after%count == c%count .and. &
                 after%set == c%set .and. same(after%work, c%work), 'as it was: ' // NAMES(k))
  end subroutine

  logical function same(a, b)
    real(c_double), intent(in) :: a(:), b(:)
    same = all(a == b .or. (ieee_is_nan(a) .and. ieee_is_nan(b)))
  end function

  ! What all have: n, the leading dimension.
  subroutine matrix(k)
    integer, intent(in) :: k
    call broken(k, call(n=-1), 1)
    call broken(k, call(lda=N - 1), 3)
    call broken(k, call(lda=0), 3)
  end subroutine

  ! What only some have.
  subroutine others()
    real(c_double) :: d(N), x(N)
    integer(c_int) :: basis(N)
    integer :: i
    call broken(LEMKE, call(n=40000, lda=40000), 1)
    call broken(PGS, call(n=huge(1_c_int), lda=huge(1_c_int)), 1)
    call broken(PRINCIPAL, call(n=40000, lda=40000), 1)
    call broken(ENUMERATE, call(n=21, lda=21), 1)
    do i = 1, 3
      d = 1
      d(i) = merge(nan, merge(0d0, -1d0, i == 1), i == 3)
      call broken(LEMKE, call(d=d), 5)
    end do
    call broken(LEMKE, call(max=-1), 6)
    call broken(LEMKE, call(lwork=WORK - 1), 11)
    call broken(LEMKE, call(lwork=-2), 11)
    call broken(PGS, call(omega=0d0), 5)
    call broken(PGS, call(omega=2d0), 5)
    call broken(PGS, call(omega=-1d0), 5)
    call broken(PGS, call(omega=nan), 5)
    call broken(PGS, call(tol=-1d-9), 6)
    call broken(PGS, call(tol=nan), 6)
    call broken(PGS, call(max=-1), 7)
    x = [0d0, nan, 0d0]
    call broken(PGS, call(x=x), 8)
    call broken(PGS, call(lwork=2 * N - 1), 12)
    call broken(PGS, call(lwork=-2), 12)
    call broken(PRINCIPAL, call(tol=-1d-9), 5)
    call broken(PRINCIPAL, call(tol=nan), 5)
    call broken(PRINCIPAL, call(block=-1), 6)
    call broken(PRINCIPAL, call(max=-1), 7)
    basis = [0, 2, 0]
    call broken(PRINCIPAL, call(basis=basis), 9)
    basis = [0, 0, -1]
    call broken(PRINCIPAL, call(basis=basis), 9)
    call broken(PRINCIPAL, call(lwork=WORK - 1), 13)
    call broken(PRINCIPAL, call(lwork=-2), 13)
    call broken(ENUMERATE, call(tol=-1d-9), 5)
    call broken(ENUMERATE, call(tol=nan), 5)
    call broken(ENUMERATE, call(set=-1), 6)
    call broken(ENUMERATE, call(set=2**N + 1), 6)
    call broken(ENUMERATE, call(lwork=WORK - 1), 10)
    call broken(ENUMERATE, call(lwork=-2), 10)
  end subroutine

  ! Those of friction, the twin of tests/unit/friction/kernels.c: a contact that slides along
  ! -(3, 4), r_N = 2, |r_T| = 1, and one without friction; the same in three rows, rows left out.
  subroutine friction()
    integer(c_int), parameter :: M = 6, ROWS(2) = [3, 1]
    real(c_double) :: a(M, M), q(M), mu(2), r(M), u(M), work(M * (M + 12)), residual
    real(c_double) :: wanted(M), bad(2)
    integer(c_int) :: iwork(M), count, info
    integer :: i
    a = 0
    do i = 1, M
      a(i, i) = 1
    end do
    a(1, 1) = 2
    q = [-4d0, 3d0, 4d0, -3d0, 0d0, 0d0]
    mu = [0.5d0, 0d0]
    wanted = [2d0, -0.6d0, -0.8d0, 3d0, 0d0, 0d0]
    call is_int(nsdae_dfccon(3, a, M, q, mu(1), r, u, residual), 0, 'dfccon')
    call is_near(maxval(abs(r(1:3) - wanted(1:3))), 0d0, 1d-14, 'r of dfccon')
    r = 0
    info = nsdae_dfcbgs(2, ROWS, a, M, q, mu, 1d-12, 9, r, count, residual, work, size(work))
    call is_int(info, 0, 'dfcbgs')
    call is_near(maxval(abs(r - wanted)), 0d0, 1d-12, 'r of dfcbgs')
    r = wanted + 1d-2
    info = nsdae_dfcnwt(2, lda=M, a=a, q=q, mu=mu, alpha=0d0, tol=1d-12, max_iter=9, r=r, &
                        iterations=count, residual=residual, work=work, lwork=size(work), &
                        iwork=iwork)
    call is_int(info, 0, 'dfcnwt')
    call is_near(maxval(abs(r - wanted)), 0d0, 1d-12, 'r of dfcnwt')
    info = nsdae_dfcres(2, a=a, lda=M, q=q, mu=mu, r=wanted, u=u, residual=residual)
    call is_int(info, 0, 'dfcres')
    call is_near(residual, 0d0, 1d-15, 'residual of dfcres')
    bad = [-1d0, 0d0]
    call is_int(nsdae_dfcres(-1, ROWS, a, M, q, mu, r, u, residual), -1, 'nc of dfcres')
    call is_int(nsdae_dfcres(2, ROWS, a, M, q, bad, r, u, residual), -6, 'mu of dfcres')
    call is_int(nsdae_dfccon(4, a, M, q, mu(1), r, u, residual), -1, 'rows of dfccon')
    info = nsdae_dfcbgs(2, ROWS, a, M, q, mu, nan, 9, r, count, residual, work, size(work))
    call is_int(info, -7, 'tol of dfcbgs')
    info = nsdae_dfcnwt(2, ROWS, a, M, q, mu, -1d0, 1d-12, 9, r, count, residual, work, &
                        size(work), iwork)
    call is_int(info, -7, 'alpha of dfcnwt')
    info = nsdae_dfcnwt(2, ROWS, a, M, q, mu, 0d0, 1d-12, 9, r, count, residual, work, -1, iwork)
    call is_int(info, 0, 'query of dfcnwt')
    call is_int(nint(work(1), c_int), 4 * 7, 'workspace of dfcnwt')
  end subroutine

  subroutine workspace(k)
    integer, intent(in) :: k
    type(call) :: c
    c%lwork = -1
    call is_int(run(k, c), 0, 'query of ' // NAMES(k))
    call is_int(nint(c%work(1), c_int), NEEDS(k), 'workspace of ' // NAMES(k))
    c = call(lwork=NEEDS(k))
    call is_int(run(k, c), 0, 'and that is enough: ' // NAMES(k))
  end subroutine

  subroutine empty(k)
    integer, intent(in) :: k
    type(call) :: c
    c = call(n=0, lda=1, lwork=0, residual=7d0, count=7)
    call is_int(run(k, c), 0, 'n = 0: ' // NAMES(k))
    if (k /= LEMKE) call is_near(c%residual, 0d0, 0d0, 'residual of nothing: ' // NAMES(k))
    if (k /= RESIDUAL .and. k /= ENUMERATE) call is_int(c%count, 0, 'count of ' // NAMES(k))
    c%lda = 0
    call is_int(run(k, c), -3, 'n = 0, lda = 0: ' // NAMES(k))
  end subroutine

  ! NaN and infinities in every entry of A, b and x in turn; x only where it comes in.
  subroutine not_finite(k)
    integer, intent(in) :: k
    type(call) :: c
    real(c_double) :: bad(3)
    integer :: i, j, kind
    bad = [nan, infinity, -infinity]
    do kind = 1, 3
      do i = 1, N
        do j = 1, N
          c = call()
          c%a(i, j) = bad(kind)
          call is_true(run(k, c) /= 0, 'A is not finite: ' // NAMES(k))
        end do
        c = call()
        c%b(i) = bad(kind)
        call is_true(run(k, c) /= 0, 'b is not finite: ' // NAMES(k))
        if (k /= RESIDUAL .and. k /= PGS) cycle
        c = call()
        c%x(i) = bad(kind)
        call is_true(run(k, c) /= 0, 'x is not finite: ' // NAMES(k))
      end do
    end do
  end subroutine

  ! Finite data whose products overflow.
  subroutine overflow(k)
    integer, intent(in) :: k
    type(call) :: c
    c%x = 1d200
    c%a = c%a * merge(1d200, 1d-100, k == RESIDUAL)
    if (k /= RESIDUAL) c%b = c%b * 1d250
    call is_true(run(k, c) /= 0, 'overflow: ' // NAMES(k))
  end subroutine

end program
