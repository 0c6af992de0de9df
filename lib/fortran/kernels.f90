! nsdae/kernels.h: kernels on plain arrays; the C header documents every argument. Without the
! module they are external subroutines with info as an additional last argument.
module nsdae_f_kernels
  use, intrinsic :: iso_c_binding
  implicit none
  private
  public :: nsdae_dfcbgs, nsdae_dfccon, nsdae_dfcnwt, nsdae_dfcres
  public :: nsdae_dlcpenum, nsdae_dlcppgs, nsdae_dlcpppm, nsdae_dlcpres, nsdae_dlemke

  interface
    integer(c_int) function nsdae_dlcpres(n, a, lda, b, x, y, residual, work) bind(C)
      import
      integer(c_int), value :: n, lda
      real(c_double), intent(in) :: a(lda, *), b(*), x(*)
      real(c_double), intent(inout) :: y(*), residual, work(*)
    end function

    ! d is optional; default: ones.
    integer(c_int) function nsdae_dlemke(n, a, lda, b, d, max_pivots, x, basis, pivots, work, &
                                         lwork, iwork) bind(C)
      import
      integer(c_int), value :: n, lda, max_pivots, lwork
      real(c_double), intent(in) :: a(lda, *), b(*)
      real(c_double), intent(in), optional :: d(*)
      real(c_double), intent(inout) :: x(*), work(*)
      integer(c_int), intent(inout) :: basis(*), iwork(*)
      integer(c_int), intent(inout) :: pivots
    end function

    integer(c_int) function nsdae_dlcppgs(n, a, lda, b, omega, tol, max_iter, x, iterations, &
                                          residual, work, lwork) bind(C)
      import
      integer(c_int), value :: n, lda, max_iter, lwork
      real(c_double), intent(in) :: a(lda, *), b(*)
      real(c_double), value :: omega, tol
      real(c_double), intent(inout) :: x(*), residual, work(*)
      integer(c_int), intent(inout) :: iterations
    end function

    integer(c_int) function nsdae_dlcpppm(n, a, lda, b, tol, block, max_pivots, x, basis, pivots, &
                                          residual, work, lwork, iwork) bind(C)
      import
      integer(c_int), value :: n, lda, block, max_pivots, lwork
      real(c_double), intent(in) :: a(lda, *), b(*)
      real(c_double), value :: tol
      real(c_double), intent(inout) :: x(*), residual, work(*)
      integer(c_int), intent(inout) :: basis(*), pivots, iwork(*)
    end function

    integer(c_int) function nsdae_dlcpenum(n, a, lda, b, tol, set, x, residual, work, lwork, &
                                           iwork) bind(C)
      import
      integer(c_int), value :: n, lda, lwork
      real(c_double), intent(in) :: a(lda, *), b(*)
      real(c_double), value :: tol
      integer(c_int), intent(inout) :: set, iwork(*)
      real(c_double), intent(inout) :: x(*), residual, work(*)
    end function

    ! rows is optional; default: three each.
    integer(c_int) function nsdae_dfcres(nc, rows, a, lda, q, mu, r, u, residual) bind(C)
      import
      integer(c_int), value :: nc, lda
      integer(c_int), intent(in), optional :: rows(*)
      real(c_double), intent(in) :: a(lda, *), q(*), mu(*), r(*)
      real(c_double), intent(inout) :: u(*), residual
    end function

    integer(c_int) function nsdae_dfccon(rows, a, lda, q, mu, r, u, residual) bind(C)
      import
      integer(c_int), value :: rows, lda
      real(c_double), intent(in) :: a(lda, *), q(*)
      real(c_double), value :: mu
      real(c_double), intent(inout) :: r(*), u(*), residual
    end function

    integer(c_int) function nsdae_dfcbgs(nc, rows, a, lda, q, mu, tol, max_iter, r, iterations, &
                                         residual, work, lwork) bind(C)
      import
      integer(c_int), value :: nc, lda, max_iter, lwork
      integer(c_int), intent(in), optional :: rows(*)
      real(c_double), intent(in) :: a(lda, *), q(*), mu(*)
      real(c_double), value :: tol
      real(c_double), intent(inout) :: r(*), residual, work(*)
      integer(c_int), intent(inout) :: iterations
    end function

    integer(c_int) function nsdae_dfcnwt(nc, rows, a, lda, q, mu, alpha, tol, max_iter, r, &
                                         iterations, residual, work, lwork, iwork) bind(C)
      import
      integer(c_int), value :: nc, lda, max_iter, lwork
      integer(c_int), intent(in), optional :: rows(*)
      real(c_double), intent(in) :: a(lda, *), q(*), mu(*)
      real(c_double), value :: alpha, tol
      real(c_double), intent(inout) :: r(*), residual, work(*)
      integer(c_int), intent(inout) :: iterations, iwork(*)
    end function
  end interface

end module
