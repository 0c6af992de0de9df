! What a run prints: parameters, the table of impacts as they come, the summary.
module pendulum_report
  use nsdae
  use pendulum_bar
  use pendulum_model
  use pendulum_settings
  implicit none
  private
  public :: report, report_begin, report_observe, report_end

  ! An impact table of this length says what there is to say; the file holds all.
  integer, parameter :: ROWS_MAX = 40

  type :: report
    type(pendulum) :: model
    integer :: rows = 0
    integer(c_int) :: method = 0
    real(c_double) :: dt = 0, fastest = 0  ! closing velocity of the impacts
    real(c_double) :: t_end = 1
    type(bar) :: bar
  end type

contains

  subroutine report_begin(r, s, sim)
    type(report), intent(inout) :: r
    type(settings), intent(in) :: s
    type(nsdae_sim), intent(in) :: sim
    type(nsdae_record) :: now
    type(nsdae_param) :: param
    character(len=10) :: key
    character(len=12) :: val
    character(len=6) :: unit
    integer(c_int) :: i
    r%model = s%model
    r%method = s%options%method
    r%dt = s%options%dt
    r%t_end = s%t_end
    call bar_begin(r%bar, 0)
    if (nsdae_sim_get_record(sim, now) == NSDAE_OK) r%bar%begin = now%time / r%t_end
    print '(a)', 'pendulum: a uniform rod that swings and hits a stop'
    do i = 1, nsdae_params_size(s%parameters)
      param = nsdae_params_entry(s%parameters, i)
      key = param%key
      val = nsdae_params_format(s%parameters, i)
      unit = param%unit
      if (unit == '1') unit = ''
      print '(2x, a, 1x, a, 1x, a, 1x, a)', key, adjustr(val), unit, param%help
    end do
    print '(5a)', 'method ', nsdae_method_name(s%options%method), ' (', &
        nsdae_method_summary(s%options%method), ')'
    i = nsdae_params_find(s%library, 'dt')
    print '(5a, /)', 'dt ', nsdae_params_format(s%library, i), ' s, to ', &
        nsdae_params_format(s%run, 1), ' s'
    print '(a6, 1x, a12, 5(1x, a14), 1x, a10)', 'impact', 'time [s]', 'impulse [N s]', &
        'before [m/s]', 'after [m/s]', 'exact time', 'exact impulse', 'error'
  end subroutine

  ! Observer: adds impacts to the table and moves the bar. user is the report.
  integer(c_int) function report_observe(record, error, user) result(status)
    type(nsdae_record), intent(in) :: record
    type(nsdae_error), intent(inout) :: error
    class(*), intent(inout) :: user
    integer :: i
    status = 0
    select type (user)
    type is (report)
      if (record%impacts > 0) call bar_clear(user%bar)
      do i = 1, record%impacts
        user%rows = user%rows + 1
        user%fastest = max(user%fastest, -record%impact(i)%velocity_before)
        if (user%rows <= ROWS_MAX) call print_impact(user, record%impact(i))
      end do
      call bar_move(user%bar, record%time / user%t_end, record%time)
    end select
  end function

  subroutine print_impact(r, impact)
    type(report), intent(in) :: r
    type(nsdae_impact), intent(in) :: impact
    real(c_double) :: time, impulse
    write (*, '(i6, 1x, f12.6, 3(1x, f14.7))', advance='no') r%rows - 1, impact%time, &
        impact%normal_impulse, impact%velocity_before, impact%velocity_after
    if (pendulum_exact(r%model, r%rows, time, impulse)) &
        write (*, '(2(1x, f14.9), 1x, f9.3, a)', advance='no') time, impulse, &
            100 * (impact%normal_impulse - impulse) / impulse, '%'
    print *
  end subroutine

  subroutine report_end(r, sim)
    type(report), intent(inout) :: r
    type(nsdae_sim), intent(in) :: sim
    type(nsdae_stats) :: stats
    integer(c_int) :: status
    call bar_clear(r%bar)
    status = nsdae_sim_get_stats(sim, stats)
    if (status < 0) return
    if (r%rows > ROWS_MAX) print '(a, i0, a)', '  ... and ', r%rows - ROWS_MAX, ' more'
    if (r%rows == 0) print '(a)', '  none'
    print '(/, 6(i0, a))', stats%steps, ' steps (', stats%smooth_steps, ' smooth, ', &
        stats%contact_steps, ' with contact), ', stats%lcps, ' LCPs, ', stats%iterations, &
        ' iterations, ', stats%impacts, ' impacts'
    print '(6a)', 'worst LCP residual ', number(stats%worst_residual, '(es8.2)'), &
        ' (tolerance ' // number(stats%contact_tol, '(es7.1)') // '), constraint drift ', &
        number(stats%worst_drift, '(es8.2)'), ' m, penetration ', &
        number(stats%worst_penetration, '(es8.2)') // ' m'
    call print_certificate(stats%certificate)
    call say_warnings(sim, stats)
    call print_remarks(r, stats)
    print '(3a)', 'energy balance ', number(stats%energy_balance, '(sp, es10.3)'), &
        ' J (energy + dissipated - start)'
    call print_energy(stats%certificate)
    print '(5a)', 'time ', number(stats%wall_time, '(es8.2)'), ' s, ', &
        number(1d6 * stats%wall_time / max(1_c_long, stats%steps), '(es8.2)'), ' us a step'
  end subroutine

  ! Largest residuals of all records, with their contacts and constraints.
  subroutine print_certificate(c)
    type(nsdae_certificate), intent(in) :: c
    print '(7a)', 'worst pull ', number(c%pull, '(es8.2)'), ' N s' // place('contact', c%pull_contact), &
        ', friction outside its cone ', number(c%cone_excess, '(es8.2)'), &
        ' N s' // place('contact', c%cone_contact) // ', complementarity ', &
        number(c%complementarity, '(es8.2)') // ' J' // place('contact', c%complementarity_contact)
    print '(3a)', 'worst constraint rate ', number(c%constraint_rate, '(es8.2)'), &
        place('constraint', c%rate_constraint)
  end subroutine

  function place(kind, item) result(text)
    character(len=*), intent(in) :: kind
    integer(c_int), intent(in) :: item
    character(len=:), allocatable :: text
    character(len=12) :: digits
    text = ''
    if (item < 0) return
    write (digits, '(i0)') item
    text = ' (' // kind // ' ' // trim(digits) // ')'
  end function

  subroutine print_energy(c)
    type(nsdae_certificate), intent(in) :: c
    print '(7a)', 'energy: work ', number(c%work, '(sp, es10.3)'), ' J, dissipated ', &
        number(c%dissipated, '(es10.3)'), ' J, unexplained ', number(c%unexplained, '(sp, es10.3)'), &
        ' J (< 0: lost by the method)'
  end subroutine

  ! Warnings of the run; the first has its values.
  subroutine say_warnings(sim, stats)
    type(nsdae_sim), intent(in) :: sim
    type(nsdae_stats), intent(in) :: stats
    character(len=*), parameter :: kinds(0:2) = [character(len=11) :: 'energy', 'penetration', 'drift']
    type(nsdae_error) :: first
    integer :: i
    first = nsdae_sim_error(sim)
    if (first%status > 0) print '(2a)', 'warning: ', trim(first%text)
    do i = 0, size(kinds) - 1
      if (btest(stats%warnings, i)) &
          print '(3a)', 'warning: ', trim(kinds(i)), ' of this run exceeds the bound of the method'
    end do
    if (btest(stats%warnings, 3)) print '(a)', 'warning: friction forces of this run are not unique'
  end subroutine

  ! Time-stepping methods detect a contact up to a step after it closes, and record its impact at the end of the next step.
  subroutine print_remarks(r, stats)
    type(report), intent(in) :: r
    type(nsdae_stats), intent(in) :: stats
    if (r%rows == 0 .or. .not. any(r%method == [NSDAE_METHOD_IMPLICIT, NSDAE_METHOD_IMPLICIT_PRINTED, &
                                                NSDAE_METHOD_MOREAU])) return
    print '(2a)', 'impact times are up to two steps late with this method; ', &
        'the errors grow if impacts follow each other soon'
    if (stats%worst_penetration > 0) &
        print '(3a)', 'penetration up to ', number(2 * r%fastest * r%dt, '(es7.1)'), &
            ' m is expected with time stepping: two steps of travel'
    print '(a)', 'a smaller --dt reduces both errors, --method event locates the impacts'
  end subroutine

  ! With a small e.
  function number(x, form) result(text)
    real(c_double), intent(in) :: x
    character(len=*), intent(in) :: form
    character(len=:), allocatable :: text
    character(len=16) :: padded
    integer :: e
    write (padded, form) x
    e = index(padded, 'E')
    if (e > 0) padded(e:e) = 'e'
    text = trim(adjustl(padded))
  end function

end module
