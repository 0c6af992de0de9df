! The progress bar of the drivers (drivers/common/progress.h): what a terminal is has no face in Fortran.
module pendulum_bar
  use, intrinsic :: iso_c_binding, only: c_double, c_int
  implicit none
  private
  public :: bar, bar_begin, bar_move, bar_clear

  type, bind(C) :: bar
    real(c_double) :: started = 0, shown = 0, begin = 0
    integer(c_int) :: terminal = 0, visible = 0
  end type

  interface
    subroutine bar_begin(b, quiet) bind(C)
      import
      type(bar), intent(out) :: b
      integer(c_int), value :: quiet
    end subroutine

    subroutine bar_move(b, part, time) bind(C)
      import
      type(bar), intent(inout) :: b
      real(c_double), value :: part, time
    end subroutine

    subroutine bar_clear(b) bind(C)
      import
      type(bar), intent(inout) :: b
    end subroutine
  end interface

end module
