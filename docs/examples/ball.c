#include <nsdae/nsdae.h>
#include <stdio.h>
#define USED(x) ((void)(x))

static int mass(double t, const double *q, double *M, int ldm, void *user)
{ USED(t), USED(q), USED(ldm), USED(user); M[0] = 0.1; return 0; } /* kg */

static int force(double t, const double *q, const double *v, double *F, void *user)
{ USED(t), USED(q), USED(v), USED(user); F[0] = -0.1 * 9.81; return 0; } /* N */

static int gap(double t, const double *q, double *g, void *user)
{ USED(t), USED(user); g[0] = q[0]; return 0; } /* height above the floor [m] */

int main(void)
{
  const nsdae_dims dims = {.nq = 1, .k = 1}; /* one coordinate, one contact */
  const double height = 1, rest = 0;
  nsdae_system *system; nsdae_sim *sim; nsdae_record now; nsdae_error error;
  nsdae_system_create(&dims, &system, NULL);
  nsdae_system_set_mass(system, mass);
  nsdae_system_set_force(system, force);
  nsdae_system_set_gap(system, gap);
  nsdae_system_set_contact(system, 0, 0, 0.5, 0); /* mu, e_N, e_T */
  /* default options: implicit, dt 0.005 s; it also says what a setter above was refused */
  if (nsdae_sim_create(system, NULL, &sim, &error) < 0) return puts(error.text), 1;
  if (nsdae_sim_init(sim, 0, &height, &rest) < 0 || nsdae_sim_run(sim, 3) < 0)
    return puts(nsdae_sim_error(sim)->text), 1;
  nsdae_sim_get_record(sim, &now);
  printf("t %g s, height %.1e m, velocity %.1e m/s\n", now.time, now.q[0], now.v[0]);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
}
