module ball_model
  use nsdae
  implicit none
contains
  integer(c_int) function mass(t, q, M, user)
    real(c_double), intent(in) :: t, q(:)
    real(c_double), intent(inout) :: M(:, :)
    class(*), intent(inout) :: user
    M(1, 1) = 0.1_c_double  ! kg
    mass = 0
  end function

  integer(c_int) function force(t, q, v, F, user)
    real(c_double), intent(in) :: t, q(:), v(:)
    real(c_double), intent(inout) :: F(:)
    class(*), intent(inout) :: user
    F(1) = -0.1_c_double * 9.81_c_double  ! N
    force = 0
  end function

  integer(c_int) function gap(t, q, g, user)
    real(c_double), intent(in) :: t, q(:)
    real(c_double), intent(inout) :: g(:)
    class(*), intent(inout) :: user
    g(1) = q(1)  ! height above the floor [m]
    gap = 0
  end function
end module

program ball
  use nsdae
  use ball_model
  implicit none
  type(nsdae_system) :: system
  type(nsdae_sim) :: sim
  type(nsdae_record) :: now
  type(nsdae_error) :: error
  integer(c_int) :: status
  status = nsdae_system_create(nsdae_dims(nq=1, k=1), system)  ! one coordinate, one contact
  status = nsdae_system_set_mass(system, mass)
  status = nsdae_system_set_force(system, force)
  status = nsdae_system_set_gap(system, gap)
  status = nsdae_system_set_contact(system, 0, 0d0, 0.5d0, 0d0)  ! mu, e_N, e_T
  ! default options: implicit, dt 0.005 s; it also says what a setter above was refused
  status = nsdae_sim_create(system, sim, error=error)
  if (status < 0) error stop trim(error%text)
  status = nsdae_sim_init(sim, 0d0, [1d0], [0d0])  ! at 1 m, at rest
  if (status >= 0) status = nsdae_sim_run(sim, 3d0)
  error = nsdae_sim_error(sim)
  if (status < 0) error stop trim(error%text)
  status = nsdae_sim_get_record(sim, now)
  print '(a, i0, a, es8.1, a, es7.1, a)', 't ', nint(now%time), ' s, height ', now%q(1), &
      ' m, velocity ', now%v(1), ' m/s'
  call nsdae_sim_destroy(sim)
  call nsdae_system_destroy(system)
end program
