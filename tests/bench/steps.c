/* Time of a step beside Siconos's and MuJoCo's, on a column of balls that falls and comes to rest;
 * medians of runs that take turns, and their ratio. Siconos steps with the same scheme (Moreau and
 * Jean, theta 1/2, an LCP of all contacts), by the faster of its Lemke and its block Gauss-Seidel.
 * MuJoCo's contacts are soft, and it finds them itself. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include <nsdae/nsdae.h>

#include "ratio.h"
#include "steps_rival.h"

enum { MOST = 1000, RUNS = 5 };

static int mass(double t, const double *q, double *M, void *user)
{
  const column *c = user;
  (void)t;
  (void)q;
  for (int i = 0; i < c->balls; i++) M[i] = c->mass;
  return 0;
}

static int force(double t, const double *q, const double *v, double *F, void *user)
{
  const column *c = user;
  (void)t;
  (void)q;
  (void)v;
  for (int i = 0; i < c->balls; i++) F[i] = -c->mass * c->gravity;
  return 0;
}

static int contacts(double t, const double *q, const double *v, double reach,
                    nsdae_contact_list *list, void *user)
{
  const column *c = user;
  nsdae_contact contact = {.e_n = c->e, .direction = {{{1}}, {{-1}}}};
  (void)t;
  (void)v;
  for (int i = 0; i < c->balls; i++) {
    contact.id = contact.block[0] = i;
    contact.block[1] = i - 1;
    contact.gap = i > 0 ? q[i] - q[i - 1] - 2 * c->radius : q[0] - c->radius;
    if (contact.gap <= reach) nsdae_contact_add(list, &contact);
  }
  return 0;
}

static nsdae_sim *create(column *c, nsdae_system **system)
{
  const nsdae_dims dims = {.nq = c->balls};
  static double q0[MOST], v0[MOST];
  static int ones[MOST];
  nsdae_sim_options options;
  nsdae_sim *sim;
  if (nsdae_system_create(&dims, system, NULL) < 0) return NULL;
  for (int i = 0; i < c->balls; i++) {
    ones[i] = 1;
    q0[i] = column_height(c, i);
  }
  nsdae_system_set_user(*system, c);
  nsdae_system_set_blocks(*system, c->balls, ones, ones);
  nsdae_system_set_mass_blocks(*system, mass);
  nsdae_system_set_force(*system, force);
  nsdae_system_set_contacts(*system, contacts);
  nsdae_sim_options_default(&options);
  options.method = NSDAE_METHOD_MOREAU;
  options.dt = c->dt;
  if (nsdae_sim_create(*system, &options, &sim, NULL) < 0) return NULL;
  if (nsdae_sim_init(sim, 0, q0, v0) < 0) nsdae_sim_destroy(&sim);
  return sim;
}

static double own_column(column *c, double *top)
{
  nsdae_system *system = NULL;
  double taken = -1;
  nsdae_record record;
  nsdae_sim *sim = create(c, &system);
  double start = ratio_cpu();
  if (sim && nsdae_sim_run(sim, c->steps * c->dt) == NSDAE_OK) {
    taken = ratio_cpu() - start;
    nsdae_sim_get_record(sim, &record);
    *top = record.q[c->balls - 1];
  }
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  return taken;
}

/* -1: what is left for programs to read cannot be written. */
static int print_peer(const char *name, double *time, double *own, double top, const column *c)
{
  char title[80];
  double theirs = ratio_median(RUNS, time), ours = ratio_median(RUNS, own);
  if (theirs < 0) {
    printf("  %s: not here\n", name);
    return 0;
  }
  printf("  %s %.3f us, ratio %.3f, top %.4f m\n", name, 1e6 * theirs / c->steps, ours / theirs,
         top);
  snprintf(title, sizeof title, "step, column of balls, %d", c->balls);
  return ratio_add(title, ours / c->steps, name, theirs / c->steps);
}

int main(void)
{
  const int balls[] = {1, 10, 100, 1000};
  printf("A column of balls, time of a step; ratio: ours to theirs, medians of %d.\n", RUNS);
  for (int i = 0; i < 4; i++) {
    column c = {balls[i], balls[i] < 1000 ? 2000 : 400, 0.1, 1, 9.81, 0.5, 1e-3};
    double own[RUNS], siconos[RUNS], mujoco[RUNS];
    double top = NAN, top_siconos = NAN, top_mujoco = NAN;
    for (int j = 0; j < RUNS; j++) {
      own[j] = own_column(&c, &top);
      siconos[j] = siconos_column(&c, &top_siconos);
      mujoco[j] = mujoco_column(&c, &top_mujoco);
      if (own[j] < 0) return 1;
    }
    printf("%d: nsdae %.3f us, top %.4f m\n", balls[i], 1e6 * ratio_median(RUNS, own) / c.steps,
           top);
    if (print_peer("Siconos", siconos, own, top_siconos, &c) < 0) return 1;
    if (print_peer("MuJoCo", mujoco, own, top_mujoco, &c) < 0) return 1;
  }
  return 0;
}
