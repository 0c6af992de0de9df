! A ball that falls on a floor: time, height and velocity after every step, to the last bit.
module model
  use, intrinsic :: iso_fortran_env, only: int64
  use nsdae
  implicit none
contains
  integer(c_int) function mass(t, q, M, user)
    real(c_double), intent(in) :: t, q(:)
    real(c_double), intent(inout) :: M(:, :)
    class(*), intent(inout) :: user
    M(1, 1) = 0.1_c_double
    mass = 0
  end function

  integer(c_int) function force(t, q, v, F, user)
    real(c_double), intent(in) :: t, q(:), v(:)
    real(c_double), intent(inout) :: F(:)
    class(*), intent(inout) :: user
    F(1) = -0.1_c_double * 9.81_c_double
    force = 0
  end function

  integer(c_int) function gap(t, q, g, user)
    real(c_double), intent(in) :: t, q(:)
    real(c_double), intent(inout) :: g(:)
    class(*), intent(inout) :: user
    g(1) = q(1)
    gap = 0
  end function

  integer(c_int) function show(now, error, user)
    type(nsdae_record), intent(in) :: now
    type(nsdae_error), intent(inout) :: error
    class(*), intent(inout) :: user
    print '(z16.16, 1x, z16.16, 1x, z16.16)', transfer([now%time, now%q(1), now%v(1)], [0_int64])
    show = 0
  end function
end module

program ball
  use model
  implicit none
  type(nsdae_system) :: system
  type(nsdae_sim) :: sim
  integer(c_int) :: status
  status = nsdae_system_create(nsdae_dims(nq=1, k=1), system)
  status = nsdae_system_set_mass(system, mass)
  status = nsdae_system_set_force(system, force)
  status = nsdae_system_set_gap(system, gap)
  status = nsdae_system_set_contact(system, 0, 0d0, 0.5d0, 0d0)
  status = nsdae_sim_create(system, sim)
  status = nsdae_sim_observe(sim, show)
  status = nsdae_sim_init(sim, 0d0, [1d0], [0d0])
  status = nsdae_sim_run(sim, 2d0)
  call nsdae_sim_destroy(sim)
  call nsdae_system_destroy(system)
  if (status /= NSDAE_OK) stop 1
end program
