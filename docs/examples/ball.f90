program ball
  use nsdae
  implicit none
  type(nsdae_bodies) :: world
  type(nsdae_system) :: system
  type(nsdae_sim) :: sim
  type(nsdae_record) :: now
  type(nsdae_error) :: error
  type(nsdae_rigid_body) :: body
  real(c_double) :: q(3), v(3)  ! x, y, theta of the ball, and their rates
  integer(c_int) :: status, disc, floor
  ! kg, kg m^2, m: the ball has the radius 0.05, its lowest point is 1 m above the floor
  body = nsdae_rigid_body(mass=0.1_c_double, inertia=[0d0, 0d0, 1.25d-4], position=[0d0, 1.05d0, 0d0])
  status = nsdae_bodies_create(2, world)
  status = nsdae_bodies_set_gravity(world, [0d0, -9.81d0, 0d0])  ! m/s^2
  disc = nsdae_bodies_add_solid(world, nsdae_bodies_add(world, body), &
                                nsdae_solid(shape=NSDAE_SHAPE_DISC, radius=0.05d0))
  floor = nsdae_bodies_add_solid(world, NSDAE_GROUND, nsdae_solid(shape=NSDAE_SHAPE_PLANE))
  status = nsdae_bodies_add_contact(world, disc, floor, 0d0, 0.5d0, 0d0)  ! mu, e_N, e_T
  status = nsdae_bodies_system(world, system, error)  ! < 0: the first failure above, > 0: a warning
  if (status > 0) print '(a)', trim(error%text)
  if (status < 0) error stop trim(error%text)
  status = nsdae_bodies_get_start(world, q, v)
  status = nsdae_sim_create(system, sim, error=error)  ! default options: implicit, dt 0.005 s
  if (status < 0) error stop trim(error%text)
  status = nsdae_sim_init(sim, 0d0, q, v)
  if (status >= 0) status = nsdae_sim_run(sim, 3d0)
  error = nsdae_sim_error(sim)
  if (status > 0) print '(a)', trim(error%text)
  if (status < 0) error stop trim(error%text)
  status = nsdae_sim_get_record(sim, now)
  print '(a, i0, a, es8.1, a, es7.1, a)', 't ', nint(now%time), ' s, height ', now%gap(1), &
      ' m, velocity ', now%v(2), ' m/s'
  call nsdae_sim_destroy(sim)
  call nsdae_system_destroy(system)
  call nsdae_bodies_destroy(world)
end program
