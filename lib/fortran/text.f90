! Texts between Fortran and C: blank-padded here, ended by a null character there.
module nsdae_f_text
  use, intrinsic :: iso_c_binding
  implicit none
  private
  public :: from_c, from_chars, to_chars

  interface
    pure integer(c_size_t) function c_strlen(s) bind(C, name='strlen')
      import
      type(c_ptr), value :: s
    end function
  end interface

contains

  ! The text that a char pointer points to; '' for NULL.
  function from_c(p) result(text)
    type(c_ptr), intent(in) :: p
    character(len=:), allocatable :: text
    character(kind=c_char), pointer :: s(:)
    integer :: i, n
    n = 0
    if (c_associated(p)) n = int(c_strlen(p))
    allocate (character(len=n) :: text)
    if (n == 0) return
    call c_f_pointer(p, s, [n])
    do i = 1, n
      text(i:i) = s(i)
    end do
  end function

  ! A char array up to its null character, blank-padded.
  pure subroutine from_chars(s, text)
    character(kind=c_char), intent(in) :: s(:)
    character(len=*), intent(out) :: text
    integer :: i
    text = ''
    do i = 1, min(size(s), len(text))
      if (s(i) == c_null_char) exit
      text(i:i) = s(i)
    end do
  end subroutine

  ! A text as char array, without trailing blanks, truncated if the array is too short. The array is
  ! on the caller's stack, so that no allocation is necessary.
  pure subroutine to_chars(text, s)
    character(len=*), intent(in) :: text
    character(kind=c_char), intent(out) :: s(:)
    integer :: i, n
    n = min(len_trim(text), size(s) - 1)
    do i = 1, n
      s(i) = text(i:i)
    end do
    s(n + 1) = c_null_char
  end subroutine

end module
