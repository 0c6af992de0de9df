! The twin of tests/anomaly/certificate.c: the residual that is the certificate of every step does not
! pass a point that is none, whatever else is in the problem.
program certificate
  use nsdae
  use check
  implicit none

  call far_apart
  call scaled_rows
  call check_done

contains

  real(c_double) function residual_of(A, b, x) result(residual)
    real(c_double), intent(in) :: A(:, :), b(:), x(:)
    real(c_double) :: y(size(b)), work(size(b))
    integer(c_int) :: n
    n = size(b, kind=c_int)
    residual = -1
    call is_int(nsdae_dlcpres(n, A, n, b, x, y, residual, work), 0, 'dlcpres')
  end function

  ! Row 1 has nothing to do with the others, which are nearly dependent and have the solution
  ! x_2 = 2^e + 1, x_3 = 2^e. A wrong x_1 is wrong however large the others are. All numbers are
  ! exact.
  subroutine far_apart()
    real(c_double), parameter :: b(3) = [-1d0, -1d0, 0d0], first(3) = [0d0, 0.5d0, 2d0]
    real(c_double) :: A(3, 3), x(3), large
    integer :: e, i
    do e = 0, 46
      large = 2d0**e
      A = reshape([1d0, 0d0, 0d0, 0d0, 1d0, -1d0, 0d0, -1d0, 1 + 1 / large], [3, 3])
      x = [1d0, large + 1, large]
      call is_true(residual_of(A, b, x) <= 0, 'exact')
      do i = 1, 3
        x(1) = first(i)
        call is_true(residual_of(A, b, x) > 1d-3, 'a wrong x_1 shows')
      end do
    end do
  end subroutine

  ! The other way round it is the same problem: the solution (1, 2), rows scaled.
  subroutine scaled_rows()
    real(c_double) :: A(2, 2), b(2), scale
    integer :: e
    do e = -14, 14, 2
      scale = 10d0**e
      A = reshape([2d0, scale, 1d0, 2 * scale], [2, 2])
      b = [-4d0, -5 * scale]
      call is_near(residual_of(A, b, [1d0, 2d0]), 0d0, 1d-15, 'the solution')
      call is_true(residual_of(A, b, [1.5d0, 1.5d0]) > 1d-3, 'no solution')
    end do
  end subroutine

end program
