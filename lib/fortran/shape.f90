! nsdae/shape.h: shapes of bodies, and the bodies of a system.
module nsdae_f_shape
  use, intrinsic :: iso_c_binding
  use nsdae_f_status
  use nsdae_f_system
  use nsdae_f_text
  implicit none
  private

  ! Shapes of bodies.
  ! headers: constants NSDAE_SHAPE_

  ! Shape and pose of a body; nsdae/shape.h describes sizes and formulas. Coordinates in formulas
  ! count from 0, as in C ("q0 + L/2*sin(q2)"). Blank texts are not given.
  type, public :: nsdae_body
    character(len=64) :: name = ''
    integer(c_int) :: shape = NSDAE_SHAPE_POINT
    real(c_double) :: size(3) = 0
    real(c_double), allocatable :: point(:, :)  ! (3, points), of polygons and paths
    character(len=256) :: position(3) = '', angle = '', quaternion(4) = '', end(3) = ''
    character(len=8) :: colour = ''
  end type

  ! The struct of the C header.
  ! headers: type nsdae_c_body

  ! The texts of a body, each ended by a null character.
  type, public :: nsdae_body_words
    character(kind=c_char) :: name(65), position(257, 3), angle(257), quaternion(257, 4), &
                              end(257, 3), colour(9)
  end type

  public :: nsdae_system_add_body, nsdae_system_get_bodies, body_of

  interface
    ! headers: functions nsdae_system_ add_body get_bodies
  end interface

contains

  ! Adds a body to the trajectory files of this system. nsdae_trajectory_create checks its formulas.
  ! nsdae_bodies_system adds every solid. NSDAE_E_STATE, NSDAE_E_MEMORY.
  integer(c_int) function nsdae_system_add_body(system, body) result(status)
    type(nsdae_system), intent(in) :: system
    type(nsdae_body), intent(in), target :: body
    type(nsdae_body_words), target :: text
    status = c_add_body(nsdae_system_handle(system), body_of(body, text))
  end function

  ! The bodies of a system.
  function nsdae_system_get_bodies(system) result(bodies)
    type(nsdae_system), intent(in) :: system
    type(nsdae_body), allocatable :: bodies(:)
    type(nsdae_c_body), pointer :: body(:)
    type(c_ptr) :: first
    integer(c_int) :: i, n
    first = c_get_bodies(nsdae_system_handle(system), n)
    allocate (bodies(n))
    if (n == 0) return
    call c_f_pointer(first, body, [n])
    do i = 1, n
      call read_body(body(i), bodies(i))
    end do
  end function

  subroutine read_body(from, body)
    type(nsdae_c_body), intent(in) :: from
    type(nsdae_body), intent(inout) :: body
    real(c_double), pointer :: point(:, :)
    integer :: i
    body%name = from_c(from%name)
    body%shape = from%shape
    body%size = from%size
    body%angle = from_c(from%angle)
    body%colour = from_c(from%colour)
    do i = 1, 4
      body%quaternion(i) = from_c(from%quaternion(i))
    end do
    do i = 1, 3
      body%position(i) = from_c(from%position(i))
      body%end(i) = from_c(from%end(i))
    end do
    if (from%points == 0) return
    call c_f_pointer(from%point, point, [3, int(from%points)])
    body%point = point
  end subroutine

  ! The C struct of a body; text has its texts.
  type(nsdae_c_body) function body_of(from, text) result(body)
    type(nsdae_body), intent(in), target :: from
    type(nsdae_body_words), intent(inout), target :: text
    integer :: i
    call to_chars(from%name, text%name)
    call to_chars(from%angle, text%angle)
    call to_chars(from%colour, text%colour)
    body%name = c_loc(text%name)
    body%angle = c_loc(text%angle)
    body%colour = c_loc(text%colour)
    body%shape = from%shape
    body%size = from%size
    if (allocated(from%point)) then
      body%points = size(from%point, 2, kind=c_int)
      body%point = c_loc(from%point)
    end if
    do i = 1, 4
      call to_chars(from%quaternion(i), text%quaternion(:, i))
      body%quaternion(i) = c_loc(text%quaternion(1, i))
    end do
    do i = 1, 3
      call to_chars(from%position(i), text%position(:, i))
      call to_chars(from%end(i), text%end(:, i))
      body%position(i) = c_loc(text%position(1, i))
      body%end(i) = c_loc(text%end(1, i))
    end do
  end function

end module
