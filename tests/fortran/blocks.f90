! Three balls on one another, each a block, the upper two glued: by blocks and by list. The floor
! carries all three, the joint the uppermost.
module stack_model
  use nsdae
  implicit none

  real(c_double), parameter :: G = 9.81d0
  integer(c_int), parameter :: BALLS = 3

  type :: stack
    real(c_double) :: mass(BALLS) = [1d0, 2d0, 3d0]
    integer :: lists = 0
    real(c_double) :: mu = 0
  end type

contains

  integer(c_int) function mass(t, q, M, user)
    real(c_double), intent(in) :: t, q(:)
    real(c_double), intent(inout) :: M(:)
    class(*), intent(inout) :: user
    mass = -1
    select type (user)
    type is (stack)
      if (size(M) == BALLS .and. size(q) == BALLS) mass = 0
      M = user%mass
    end select
  end function

  integer(c_int) function force(t, q, v, F, user)
    real(c_double), intent(in) :: t, q(:), v(:)
    real(c_double), intent(inout) :: F(:)
    class(*), intent(inout) :: user
    select type (user)
    type is (stack)
      F = -G * user%mass
    end select
    force = 0
  end function

  integer(c_int) function constraint(t, q, phi, user)
    real(c_double), intent(in) :: t, q(:)
    real(c_double), intent(inout) :: phi(:)
    class(*), intent(inout) :: user
    phi(1) = q(3) - q(2) - 1
    constraint = 0
  end function

  integer(c_int) function rows(t, q, list, user)
    real(c_double), intent(in) :: t, q(:)
    type(nsdae_row_list), intent(in) :: list
    class(*), intent(inout) :: user
    rows = nsdae_row_add(list, 0_c_int, 1_c_int, [-1d0])
    if (rows == NSDAE_OK) rows = nsdae_row_add(list, 0_c_int, 2_c_int, [1d0])
  end function

  ! The force is constant: 0, and a block that is wrong by mu.
  integer(c_int) function force_blocks(t, q, v, list, user)
    real(c_double), intent(in) :: t, q(:), v(:)
    type(nsdae_block_list), intent(in) :: list
    class(*), intent(inout) :: user
    real(c_double) :: value(1, 1)
    value = 0
    select type (user)
    type is (stack)
      value = user%mu
    end select
    force_blocks = nsdae_block_add(list, 2_c_int, 1_c_int, value)
  end function

  integer(c_int) function contacts(t, q, v, reach, list, user)
    real(c_double), intent(in) :: t, q(:), v(:), reach
    type(nsdae_contact_list), intent(in) :: list
    class(*), intent(inout) :: user
    type(nsdae_contact) :: contact
    contacts = 0
    select type (user)
    type is (stack)
      user%lists = user%lists + 1
      contact%mu = user%mu
    end select
    contact%id = 7
    contact%block = [0, -1]
    contact%gap = q(1) - 0.5d0
    contact%direction(1, 1, 1) = 1
    if (contact%gap <= reach) contacts = nsdae_contact_add(list, contact)
    contact%id = 8
    contact%block = [1, 0]
    contact%gap = q(2) - q(1) - 1
    contact%direction(1, 1, 2) = -1
    if (contact%gap <= reach .and. contacts == 0) contacts = nsdae_contact_add(list, contact)
  end function

end module

! A body in a slot: x, y are blocks, and y = 0 carries the weight. The slot moves by -1/2.
module slot_model
  use nsdae
  implicit none

contains

  integer(c_int) function slot_mass(t, q, M, user)
    real(c_double), intent(in) :: t, q(:)
    real(c_double), intent(inout) :: M(:)
    class(*), intent(inout) :: user
    M = 2
    slot_mass = 0
  end function

  integer(c_int) function weight(t, q, v, F, user)
    real(c_double), intent(in) :: t, q(:), v(:)
    real(c_double), intent(inout) :: F(:)
    class(*), intent(inout) :: user
    F(2) = -20
    weight = 0
  end function

  integer(c_int) function height(t, q, phi, user)
    real(c_double), intent(in) :: t, q(:)
    real(c_double), intent(inout) :: phi(:)
    class(*), intent(inout) :: user
    phi(1) = q(2)
    height = 0
  end function

  integer(c_int) function height_rows(t, q, list, user)
    real(c_double), intent(in) :: t, q(:)
    type(nsdae_row_list), intent(in) :: list
    class(*), intent(inout) :: user
    height_rows = nsdae_row_add(list, 0_c_int, 1_c_int, [1d0])
  end function

  integer(c_int) function joint_rows(t, q, list, w_s, user)
    real(c_double), intent(in) :: t, q(:)
    type(nsdae_row_list), intent(in) :: list
    real(c_double), intent(inout) :: w_s(:)
    class(*), intent(inout) :: user
    w_s(1) = 0.5d0
    joint_rows = nsdae_row_add(list, 0_c_int, 0_c_int, [1d0])
  end function

end module

program blocks
  use nsdae
  use check
  use stack_model
  use slot_model
  implicit none

  real(c_double), parameter :: DT = 1d-3
  integer(c_int), parameter :: ONES(BALLS) = 1
  type(nsdae_system) :: system
  type(nsdae_sim) :: sim
  type(nsdae_sim_options) :: options
  type(nsdae_record) :: record
  type(nsdae_stats) :: stats
  type(nsdae_error) :: error
  type(nsdae_check) :: worst
  type(stack), target :: balls_of
  integer :: i, method

  call is_int(nsdae_system_create(nsdae_dims(nq=BALLS, m=1), system), NSDAE_OK, 'create')
  call is_int(nsdae_system_get_blocks(system), 1_c_int, 'one block')
  call is_int(nsdae_system_set_user(system, balls_of), NSDAE_OK, 'user')
  call is_int(nsdae_system_set_blocks(system, ONES, ONES(:2)), NSDAE_E_ARGUMENT, 'sizes differ')
  call is_int(nsdae_system_set_blocks(system, ONES, ONES), NSDAE_OK, 'blocks')
  call is_int(nsdae_system_get_blocks(system), BALLS, 'three blocks')
  call is_int(nsdae_system_set_mass_blocks(system, mass), NSDAE_OK, 'mass')
  call is_int(nsdae_system_set_force(system, force), NSDAE_OK, 'force')
  call is_int(nsdae_system_set_constraint(system, constraint), NSDAE_OK, 'constraint')
  call is_int(nsdae_system_set_constraint_rows(system, rows), NSDAE_OK, 'rows')
  call is_int(nsdae_system_set_contacts(system, contacts), NSDAE_OK, 'contacts')
  call is_int(nsdae_system_check(system, 0d0, [0.6d0, 1.7d0, 2.7d0], [0d0, 0d0, 0d0], 1d-6), &
              NSDAE_OK, 'check')

  ! derivatives of the force by blocks
  call is_int(nsdae_system_set_force_damping_blocks(system, force_blocks), NSDAE_OK, 'damping')
  call is_int(nsdae_system_set_force_stiffness_blocks(system, force_blocks), NSDAE_OK, 'stiffness')
  call is_int(nsdae_system_check(system, 0d0, [0.6d0, 1.7d0, 2.7d0], [0d0, 0d0, 0d0], 1d-6), &
              NSDAE_OK, 'check')
  balls_of%mu = 0.5d0
  call is_int(nsdae_system_check(system, 0d0, [5d0, 7d0, 8d0], [0d0, 0d0, 0d0], 1d-6, worst), &
              NSDAE_E_DERIVATIVE, 'a wrong block')
  call is_true(worst%row == 2 .and. worst%column == 1, 'its entry')
  call is_text(trim(worst%term), 'force_damping_blocks', 'its callback')
  balls_of%mu = 0

  do method = NSDAE_METHOD_IMPLICIT, NSDAE_METHOD_MOREAU
    call nsdae_sim_options_default(options)
    options%method = method
    options%dt = DT
    call is_int(nsdae_sim_create(system, sim, options, error), NSDAE_OK, 'simulation: '//error%text)
    call is_int(nsdae_sim_init(sim, 0d0, [0.5d0, 1.5d0, 2.5d0], [0d0, 0d0, 0d0]), NSDAE_OK, 'init')
    do i = 1, 10
      call is_int(nsdae_sim_step(sim), NSDAE_OK, 'step')
    end do
    call is_int(nsdae_sim_get_record(sim, record), NSDAE_OK, 'record')
    call is_int(record%contacts%count, 2_c_int, 'contacts')
    call is_true(all(record%contacts%id == [7, 8]), 'ids')
    call is_true(.not. (associated(record%gap) .or. associated(record%mode) &
                        .or. associated(record%normal_force)), 'no fixed contacts')
    call is_true(all(record%contacts%block == reshape([0, -1, 1, 0], [2, 2])), 'blocks of contacts')
    call is_near(record%contacts%normal_impulse(1), 6 * G * DT, 1d-12, 'floor')
    call is_near(record%contacts%normal_impulse(2), 5 * G * DT, 1d-12, 'second ball')
    call is_near(record%multiplier(1), -3 * G, 1d-9, 'joint')
    call is_true(all(abs(record%v) < 1d-14), 'rest')
    call is_true(all(abs(record%contacts%gap) < 1d-12), 'gaps')
    call is_int(size(record%contacts%tangential_impulse), 0, 'no tangents')
    call is_int(record%contacts%mode(1), NSDAE_MODE_SLIP, 'mode')
    call is_int(nsdae_sim_get_stats(sim, stats), NSDAE_OK, 'statistics')
    call is_true(stats%contact_capacity >= 2 .and. stats%islands == 1 &
                 .and. stats%island_contacts == 2, 'islands')
    call nsdae_sim_destroy(sim)
  end do

  ! what a list refuses is told, whatever the callback returns
  balls_of%mu = 0.5d0
  call is_int(nsdae_sim_create(system, sim, options), NSDAE_OK, 'again')
  call is_int(nsdae_sim_init(sim, 0d0, [0.5d0, 1.5d0, 2.5d0], [0d0, 0d0, 0d0]), NSDAE_E_ARGUMENT, &
              'friction without a direction')
  error = nsdae_sim_error(sim)
  call is_text(trim(error%argument), 'mu', 'its argument')
  call is_true(balls_of%lists > 0, 'lists were asked for')
  call nsdae_sim_destroy(sim)
  call is_int(nsdae_system_set_joint_friction_rows(system, joint_rows), NSDAE_E_ARGUMENT, 'f = 0')
  call nsdae_system_destroy(system)

  ! v = v_0 - mu g t along the slot, until the body moves with it
  call is_int(nsdae_system_create(nsdae_dims(nq=2, m=1, f=1), system), NSDAE_OK, 'slot')
  call is_int(nsdae_system_set_blocks(system, ONES(:2), ONES(:2)), NSDAE_OK, 'its blocks')
  call is_int(nsdae_system_set_mass_blocks(system, slot_mass), NSDAE_OK, 'its mass')
  call is_int(nsdae_system_set_force(system, weight), NSDAE_OK, 'its force')
  call is_int(nsdae_system_set_constraint(system, height), NSDAE_OK, 'its constraint')
  call is_int(nsdae_system_set_constraint_rows(system, height_rows), NSDAE_OK, 'its rows')
  call is_int(nsdae_system_set_joint_friction_rows(system, joint_rows), NSDAE_OK, 'joint rows')
  call is_int(nsdae_system_set_frictional_joint(system, 0_c_int, 0_c_int, 0.25d0), NSDAE_OK, 'mu')
  options%dt = 1d-2
  call is_int(nsdae_sim_create(system, sim, options), NSDAE_OK, 'its simulation')
  call is_int(nsdae_sim_init(sim, 0d0, [0d0, 0d0], [1d0, 0d0]), NSDAE_OK, 'its start')
  do i = 1, 80
    call is_int(nsdae_sim_step(sim), NSDAE_OK, 'its step')
    call is_int(nsdae_sim_get_record(sim, record), NSDAE_OK, 'its record')
    if (i == 20) call is_near(record%v(1), 0.5d0, 1d-12, 'slip')
  end do
  call is_near(record%v(1), -0.5d0, 1d-12, 'stick')
  call nsdae_sim_destroy(sim)
  call nsdae_system_destroy(system)
  call check_done()
end program
