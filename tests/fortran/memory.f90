! The allocator under the library's feet: tests/support/allocator.h.
module allocations
  use, intrinsic :: iso_c_binding, only: c_long
  implicit none

  type, bind(C) :: allocator
    integer(c_long) :: calls, live, fail_at
  end type
  type(allocator), bind(C) :: the_allocator

  interface
    subroutine allocator_reset(fail_at) bind(C)
      import
      integer(c_long), value :: fail_at
    end subroutine
  end interface
end module


! What the library calls: module procedures, so that no compiler needs trampolines.
module observer_of_memory
  use allocations
  use nsdae
  implicit none

contains

  integer(c_int) function last_calls(record, error, user) result(status)
    type(nsdae_record), intent(in) :: record
    type(nsdae_error), intent(inout) :: error
    class(*), intent(inout) :: user
    select type (user)
    type is (integer(c_long))
      user = the_allocator%calls
    end select
    status = 0
  end function

end module

! The twin of tests/anomaly/memory.c: no allocation after creation, none kept after destruction,
! every lost one survived; the same run gives the same bytes.
program memory
  use, intrinsic :: iso_c_binding, only: c_long
  use nsdae
  use allocations
  use bead_model
  use observer_of_memory
  use check
  implicit none

  call none_after_creation
  call every_lost_allocation
  call lost_by_a_table
  call same_bytes
  call check_done

contains

  ! Steps, observers, records: three seconds with impacts.
  subroutine none_after_creation()
    type(bead), target :: b
    type(nsdae_system) :: system
    type(nsdae_sim) :: sim
    type(nsdae_sim_options) :: options
    type(nsdae_stats) :: stats
    type(nsdae_record) :: record
    real(c_double) :: q0(3), v0(3)
    integer(c_long), target :: last
    integer(c_int) :: method, started, stepped, ran, got
    do method = 0, 2
      b = bead()
      last = -1
      call bead_start(b, q0, v0)
      call nsdae_sim_options_default(options)
      options%method = method
      call is_int(bead_system(b, system), NSDAE_OK, 'the bead')
      call is_int(nsdae_sim_create(system, sim, options), NSDAE_OK, 'create')
      call is_int(nsdae_sim_observe(sim, last_calls, last), NSDAE_OK, 'observe')
      call allocator_reset(-1_c_long)
      started = nsdae_sim_init(sim, 0d0, q0, v0)
      stepped = nsdae_sim_step(sim)
      ran = nsdae_sim_run(sim, 3d0)
      got = nsdae_sim_get_record(sim, record)
      call is_int(int(the_allocator%calls, c_int), 0, 'allocations')
      call is_true(last == 0, 'allocations seen by the observer')
      call is_true(all([started, stepped, ran, got] == NSDAE_OK), 'statuses')
      call is_int(nsdae_sim_get_stats(sim, stats), NSDAE_OK, 'stats')
      call is_true(stats%impacts > 0 .and. stats%lcps > 10, 'impacts and LCPs')
      call nsdae_sim_destroy(sim)
      call nsdae_system_destroy(system)
    end do
  end subroutine

  ! Creates, runs and destroys; the first status below zero.
  integer(c_int) function life(states) result(status)
    real(c_double), intent(out) :: states(6, 300)
    type(bead), target :: b
    type(nsdae_system) :: system
    type(nsdae_sim) :: sim
    type(nsdae_record) :: record
    real(c_double) :: q0(3), v0(3)
    integer :: i
    states = 0
    call bead_start(b, q0, v0)
    status = bead_system(b, system)
    if (status >= 0) status = nsdae_sim_create(system, sim)
    if (status >= 0) status = nsdae_sim_init(sim, 0d0, q0, v0)
    do i = 1, 300
      if (status >= 0) status = nsdae_sim_step(sim)
      if (status >= 0) status = min(0, nsdae_sim_get_record(sim, record))
      if (status < 0) exit
      states(:3, i) = record%q
      states(4:, i) = record%v
    end do
    call nsdae_sim_destroy(sim)
    call nsdae_system_destroy(system)
  end function

  subroutine every_lost_allocation()
    real(c_double), save :: states(6, 300)
    integer(c_int) :: status
    integer(c_long) :: tried, live
    do tried = 0, 100
      call allocator_reset(tried)
      status = life(states)
      live = the_allocator%live
      call allocator_reset(-1_c_long)
      call is_true(status == NSDAE_OK .or. status == NSDAE_E_MEMORY, nsdae_status_name(status))
      call is_int(int(live, c_int), 0, 'allocated and not freed')
      if (status == NSDAE_OK) exit
    end do
    ! system 3, simulation 4: those of C and one of the module each
    call is_true(tried > 5 .and. tried < 100, 'allocations tried')
  end subroutine

  ! A table keeps what it has, and says so.
  subroutine lost_by_a_table()
    type :: pair
      real(c_double) :: a = 0
      integer(c_int) :: b = 0
    end type
    type(pair), target :: p
    type(nsdae_params) :: table
    character(len=3) :: words(2) = ['one', 'two']
    integer(c_int) :: first, status, entries
    integer(c_long) :: tried, live, kept, left
    ! checks come after the counting: texts of the runtime library are freed here
    do tried = 0, 100
      call allocator_reset(-1_c_long)
      first = nsdae_params_add(table, p%a, 'a', 'm', 'a length', 1d0)
      live = the_allocator%live
      the_allocator%fail_at = the_allocator%calls + tried
      status = nsdae_params_add(table, p%b, 'b', 'a choice', words, 1)
      the_allocator%fail_at = -1
      kept = the_allocator%live
      entries = nsdae_params_size(table)
      call nsdae_params_destroy(table)
      left = the_allocator%live
      call is_int(first, NSDAE_OK, 'first')
      call is_int(int(left, c_int), 0, 'allocated and not freed')
      if (status == NSDAE_OK) exit
      call is_int(status, NSDAE_E_MEMORY, 'second')
      call is_int(entries, 1, 'size')
      call is_true(kept == live, 'nothing is kept of what failed')
    end do
    call is_int(status, NSDAE_OK, 'second at last')
    call is_int(entries, 2, 'size')
    call is_true(tried == 7, 'three texts, two of the choices, two of the table')
  end subroutine

  subroutine same_bytes()
    real(c_double), save :: once(6, 300), again(6, 300)
    call is_int(life(once), NSDAE_OK, 'once')
    call is_int(life(again), NSDAE_OK, 'again')
    call is_true(all(once == again) .and. any(once(5, :) > 0), 'the same bytes')
  end subroutine

end program
