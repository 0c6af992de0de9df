! The twin of tests/conformance/state.c: a state that is set elsewhere goes on with the same bytes; one
! that is damaged, short or of other options is refused by name.
program state
  use, intrinsic :: iso_c_binding
  use nsdae
  use bead_model
  use check
  implicit none

  integer, parameter :: STEPS = 40, TAKEN = 13

  call elsewhere
  call refused
  call check_done

contains

  subroutine make(system, sim, dt)
    type(nsdae_system), intent(in) :: system
    type(nsdae_sim), intent(out) :: sim
    real(c_double), intent(in) :: dt
    type(nsdae_sim_options) :: options
    call nsdae_sim_options_default(options)
    options%method = NSDAE_METHOD_MOREAU
    options%dt = dt
    call is_int(nsdae_sim_create(system, sim, options), NSDAE_OK, 'create')
  end subroutine

  subroutine init(sim, b)
    type(nsdae_sim), intent(in) :: sim
    type(bead), intent(in) :: b
    real(c_double) :: q0(3), v0(3)
    call bead_start(b, q0, v0)
    call is_int(nsdae_sim_init(sim, 0d0, q0, v0), NSDAE_OK, 'init')
  end subroutine

  subroutine step(sim, times)
    type(nsdae_sim), intent(in) :: sim
    integer, intent(in) :: times
    integer :: i
    do i = 1, times
      call is_true(nsdae_sim_step(sim) >= 0, 'step')
    end do
  end subroutine

  function state_of(sim) result(block)
    type(nsdae_sim), intent(in) :: sim
    integer(c_int8_t), allocatable :: block(:)
    integer(c_size_t) :: bytes
    call is_int(nsdae_sim_state_size(sim, bytes), NSDAE_OK, 'size')
    allocate (block(bytes))
    call is_int(nsdae_sim_get_state(sim, block), NSDAE_OK, 'get')
  end function

  subroutine elsewhere()
    type(bead), target :: b
    type(nsdae_system) :: system
    type(nsdae_sim) :: sim, other
    integer(c_int8_t), allocatable :: block(:)
    call is_int(bead_system(b, system), NSDAE_OK, 'the bead')
    call make(system, sim, 0.01d0)
    call make(system, other, 0.01d0)
    call init(sim, b)
    call step(sim, TAKEN)
    block = state_of(sim)
    call is_int(nsdae_sim_set_state(other, block), NSDAE_OK, 'set')
    call is_true(all(state_of(other) == block), 'the same state')
    call step(sim, STEPS - TAKEN)
    call step(other, STEPS - TAKEN)
    call is_true(all(state_of(other) == state_of(sim)), 'the same bytes at the end')
    call nsdae_sim_destroy(sim)
    call nsdae_sim_destroy(other)
    call nsdae_system_destroy(system)
  end subroutine

  subroutine refused()
    type(bead), target :: b
    type(nsdae_system) :: system
    type(nsdae_sim) :: sim, other
    type(nsdae_error) :: error
    integer(c_int8_t), allocatable :: block(:)
    call is_int(bead_system(b, system), NSDAE_OK, 'the bead')
    call make(system, sim, 0.01d0)
    call make(system, other, 0.02d0)
    allocate (block(8))
    call is_int(nsdae_sim_get_state(sim, block), NSDAE_E_STATE, 'before init')
    call init(sim, b)
    call step(sim, TAKEN)
    block = state_of(sim)
    call is_int(nsdae_sim_set_state(other, block), NSDAE_E_ARGUMENT, 'another dt')
    error = nsdae_sim_error(other)
    call is_text(error%argument, 'dt', 'argument')
    call is_int(nsdae_sim_set_state(sim, block(2:)), NSDAE_E_ARGUMENT, 'short')
    block(size(block) / 2) = ieor(block(size(block) / 2), 1_c_int8_t)
    call is_int(nsdae_sim_set_state(sim, block), NSDAE_E_ARGUMENT, 'damaged')
    call nsdae_sim_destroy(sim)
    call nsdae_sim_destroy(other)
    call nsdae_system_destroy(system)
  end subroutine

end program
