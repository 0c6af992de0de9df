! Counts what is not as it should be; the program fails at its end.
module check
  use, intrinsic :: iso_c_binding, only: c_double, c_int
  implicit none
  private
  public :: is_true, is_int, is_near, is_text, contains_text, check_done

  integer :: failures = 0, checks = 0

contains

  subroutine is_true(condition, what)
    logical, intent(in) :: condition
    character(len=*), intent(in) :: what
    checks = checks + 1
    if (condition) return
    failures = failures + 1
    print '(2a)', 'not so: ', what
  end subroutine

  subroutine is_int(given, wanted, what)
    integer(c_int), intent(in) :: given, wanted
    character(len=*), intent(in) :: what
    character(len=64) :: values
    write (values, '(": ", i0, ", not ", i0)') given, wanted
    call is_true(given == wanted, what // trim(values))
  end subroutine

  subroutine is_near(given, wanted, bound, what)
    real(c_double), intent(in) :: given, wanted, bound
    character(len=*), intent(in) :: what
    character(len=120) :: values
    write (values, '(": ", es23.16, ", not within ", es8.1, " of ", es23.16)') given, bound, wanted
    call is_true(abs(given - wanted) <= bound, what // trim(values))
  end subroutine

  subroutine is_text(given, wanted, what)
    character(len=*), intent(in) :: given, wanted, what
    call is_true(given == wanted, what // ": '" // trim(given) // "', not '" // wanted // "'")
  end subroutine

  subroutine contains_text(text, part, what)
    character(len=*), intent(in) :: text, part, what
    call is_true(index(text, part) > 0, what // ": '" // trim(text) // "' without '" // part // "'")
  end subroutine

  subroutine check_done()
    print '(i0, a, i0, a)', checks, ' checks, ', failures, ' failed'
    if (failures > 0 .or. checks == 0) error stop 1
  end subroutine

end module
