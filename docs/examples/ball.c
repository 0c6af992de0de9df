#include <nsdae/nsdae.h>
#include <stdio.h>

int main(void)
{
  const double gravity[3] = {0, -9.81, 0}; /* m/s^2 */
  /* kg, kg m^2, m: the ball has the radius 0.05, its lowest point is 1 m above the floor */
  const nsdae_rigid_body body = {.mass = 0.1, .inertia = {0, 0, 1.25e-4}, .position = {0, 1.05}};
  const nsdae_solid disc = {.shape = NSDAE_SHAPE_DISC, .radius = 0.05};
  const nsdae_solid plane = {.shape = NSDAE_SHAPE_PLANE};
  nsdae_bodies *world; nsdae_system *system; nsdae_sim *sim; nsdae_record now; nsdae_error error;
  double q[3], v[3]; /* x, y, theta of the ball, and their rates */
  if (nsdae_bodies_create(2, &world, &error) < 0) return puts(error.text), 1;
  nsdae_bodies_set_gravity(world, gravity);
  int ball = nsdae_bodies_add_solid(world, nsdae_bodies_add(world, &body), &disc);
  int floor = nsdae_bodies_add_solid(world, NSDAE_GROUND, &plane);
  nsdae_bodies_add_contact(world, ball, floor, 0, 0.5, 0); /* mu, e_N, e_T */
  int status = nsdae_bodies_system(world, &system); /* < 0: the first failure above, > 0: a warning */
  if (status != NSDAE_OK) puts(nsdae_bodies_error(world)->text);
  if (status < 0) return 1;
  nsdae_bodies_get_start(world, q, v);
  /* default options: implicit, dt 0.005 s */
  if (nsdae_sim_create(system, NULL, &sim, &error) < 0) return puts(error.text), 1;
  status = nsdae_sim_init(sim, 0, q, v);
  if (status >= 0) status = nsdae_sim_run(sim, 3);
  if (status != NSDAE_OK) puts(nsdae_sim_error(sim)->text);
  if (status < 0) return 1;
  nsdae_sim_get_record(sim, &now);
  printf("t %g s, height %.1e m, velocity %.1e m/s\n", now.time, now.gap[0], now.v[1]);
  nsdae_sim_destroy(&sim), nsdae_system_destroy(&system), nsdae_bodies_destroy(&world);
}
