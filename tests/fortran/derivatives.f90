! The twin of tests/unit/system/check.c: right derivatives pass nsdae_system_check, and each one that is
! wrong is named.
program derivatives
  use, intrinsic :: ieee_arithmetic
  use nsdae
  use planar_model
  use check
  implicit none

  ! The comment of nsdae_system_check: good to 1e-7 for values of order one (here up to 10), and the
  ! bound that it calls fair.
  real(c_double), parameter :: GOOD_TO = 1d-6, TOL = 1d-5
  real(c_double) :: t, q(4), v(3)

  call right
  call each_wrong_entry
  call mass_not_symmetric
  call failing_callback
  call refused
  call nothing_given
  call check_done

contains

  subroutine make(wrong, system)
    type(fault), target, intent(inout) :: wrong
    type(nsdae_system), intent(out) :: system
    integer(c_int) :: status(15)
    call planar_system(wrong, .true., system, status)
    call is_true(all(status == NSDAE_OK), 'the planar body')
    call planar_point(3, t, q, v)
  end subroutine

  subroutine right()
    type(fault), target :: none
    type(nsdae_system) :: system
    type(nsdae_check) :: worst
    type(nsdae_error) :: error
    integer :: i
    call make(none, system)
    do i = 0, 39
      call planar_point(i, t, q, v)
      call is_int(nsdae_system_check(system, t, q, v, TOL, worst), NSDAE_OK, 'right')
      call is_near(worst%error, 0d0, GOOD_TO, 'worst%error')
      call is_int(nsdae_system_check(system, t, q, v, TOL), NSDAE_OK, 'right')
    end do
    error = nsdae_system_error(system)
    call is_int(error%status, NSDAE_OK, 'error%status')
    call nsdae_system_destroy(system)
  end subroutine

  ! An entry of a term with that many rows is off by a little or is NaN: it is the one named.
  subroutine wrong_entry(term, rows, entry, amount)
    character(len=*), intent(in) :: term
    integer, intent(in) :: rows, entry
    real(c_double), intent(in) :: amount
    type(fault), target :: wrong
    type(nsdae_system) :: system
    type(nsdae_check) :: worst
    type(nsdae_error) :: error
    character(len=32) :: place
    wrong = fault(term, entry, amount)
    call make(wrong, system)
    call is_int(nsdae_system_check(system, t, q, v, TOL, worst), NSDAE_E_DERIVATIVE, term)
    call is_text(worst%term, term, 'worst%term')
    call is_true(worst%row == mod(entry, rows) .and. worst%column == entry / rows, &
                 'worst%row, worst%column of ' // term)
    if (ieee_is_finite(amount)) &
        call is_near(worst%given - worst%difference, amount, GOOD_TO * 10, term)
    call is_true(worst%error > TOL, 'worst%error')
    error = nsdae_system_error(system)
    call is_int(error%status, NSDAE_E_DERIVATIVE, 'error%status')
    write (place, '("entry (", i0, ", ", i0, ")")') worst%row, worst%column
    call contains_text(error%text, term, 'error%text')
    call contains_text(error%text, trim(place), 'error%text')
    call nsdae_system_destroy(system)
  end subroutine

  subroutine each_wrong_entry()
    character(len=*), parameter :: terms(8) = [character(len=21) :: 'constraint_jacobian', &
        'constraint_bias phi_t', 'constraint_bias omega', 'gap_normal', 'contact_bias w_n', &
        'contact_acceleration', 'force_damping', 'force_stiffness']
    integer, parameter :: rows(8) = [2, 2, 2, 3, 2, 2, 3, 3], entries(8) = [6, 2, 2, 6, 2, 2, 9, 9]
    integer :: i, entry
    do i = 1, size(terms)
      do entry = 0, entries(i) - 1
        call wrong_entry(trim(terms(i)), rows(i), entry, 1d-2)
        call wrong_entry(trim(terms(i)), rows(i), entry, -1d0)
        call wrong_entry(trim(terms(i)), rows(i), entry, ieee_value(0d0, ieee_quiet_nan))
        call wrong_entry(trim(terms(i)), rows(i), entry, ieee_value(0d0, ieee_positive_inf))
      end do
    end do
  end subroutine

  ! Either of the two entries that differ is the wrong one.
  subroutine mass_not_symmetric()
    type(fault), target :: wrong
    type(nsdae_system) :: system
    type(nsdae_check) :: worst
    integer(c_int) :: row, column
    do column = 0, 2
      do row = 0, 2
        wrong = fault('mass', row + 3 * column, 1d-2)
        call make(wrong, system)
        call is_int(nsdae_system_check(system, t, q, v, TOL, worst), &
                    merge(NSDAE_OK, NSDAE_E_DERIVATIVE, row == column), 'mass')
        if (row /= column) then
          call is_text(worst%term, 'mass', 'worst%term')
          call is_true(min(worst%row, worst%column) == min(row, column) .and. &
                       max(worst%row, worst%column) == max(row, column), 'entry of the mass')
        end if
        wrong%amount = ieee_value(0d0, ieee_quiet_nan)
        call is_int(nsdae_system_check(system, t, q, v, TOL), NSDAE_E_DERIVATIVE, 'NaN in the mass')
        call nsdae_system_destroy(system)
      end do
    end do
  end subroutine

  subroutine failing_callback()
    character(len=*), parameter :: terms(8) = [character(len=19) :: 'mass', 'constraint', &
        'constraint_jacobian', 'gap_normal', 'gap', 'kinematics', 'force_damping', 'force_stiffness']
    type(fault), target :: wrong
    type(nsdae_system) :: system
    type(nsdae_error) :: error
    integer(c_int) :: code
    integer :: i
    do i = 1, size(terms)
      do code = -3, 3, 6
        wrong = fault(terms(i), code=code)
        call make(wrong, system)
        call is_int(nsdae_system_check(system, t, q, v, TOL), NSDAE_E_CALLBACK, terms(i))
        error = nsdae_system_error(system)
        call is_int(error%code, code, 'error%code')
        call is_text(error%argument, trim(terms(i)), 'error%argument')
        call is_near(error%time, t, 0d0, 'error%time')
        wrong%code = 0
        call is_int(nsdae_system_check(system, t, q, v, TOL), NSDAE_OK, 'afterwards')
        call nsdae_system_destroy(system)
      end do
    end do
  end subroutine

  subroutine refused()
    type(fault), target :: none
    type(nsdae_system) :: system
    type(nsdae_error) :: error
    real(c_double) :: bad(3)
    integer :: i
    call is_int(nsdae_system_check(system, t, q, v, TOL), NSDAE_E_ARGUMENT, 'no system')
    call make(none, system)
    call is_int(nsdae_system_check(system, t, q(:3), v, TOL), NSDAE_E_ARGUMENT, 'size of q')
    error = nsdae_system_error(system)
    call is_text(error%argument, 'q', 'error%argument')
    call is_int(nsdae_system_check(system, t, q, q, TOL), NSDAE_E_ARGUMENT, 'size of v')
    error = nsdae_system_error(system)
    call is_text(error%argument, 'v', 'error%argument')
    bad = [0d0, -1d0, ieee_value(0d0, ieee_quiet_nan)]
    do i = 1, 3
      call is_int(nsdae_system_check(system, t, q, v, bad(i)), NSDAE_E_ARGUMENT, 'tol')
      error = nsdae_system_error(system)
      call is_text(error%argument, 'tol', 'error%argument')
    end do
    call nsdae_system_destroy(system)
  end subroutine

  ! With nothing but what is needed there is only the mass matrix to check.
  subroutine nothing_given()
    type(fault), target :: none
    type(nsdae_system) :: system
    type(nsdae_check) :: worst
    integer(c_int) :: status(15)
    call is_int(nsdae_system_create(PLANAR, system), NSDAE_OK, 'create')
    call planar_point(3, t, q, v)
    call is_int(nsdae_system_check(system, t, q, v, TOL, worst), NSDAE_E_STATE, 'nothing')
    call nsdae_system_destroy(system)
    call planar_system(none, .false., system, status)
    call is_int(nsdae_system_check(system, t, q, v, TOL, worst), NSDAE_OK, 'what is needed')
    call is_near(worst%error, 0d0, 0d0, 'worst%error')
    call nsdae_system_destroy(system)
  end subroutine

end program
