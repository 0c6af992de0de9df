/* Time of a step of disks that rest on a floor, beside Siconos's by block Gauss-Seidel: contacts
 * that know nothing of each other should cost what one costs, times their number. Medians of runs
 * that take turns, and their ratio. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include <nsdae/nsdae.h>

#include "disks_rival.h"
#include "ratio.h"

enum { MOST = 1000, RUNS = 5 };

static int mass(double t, const double *q, double *M, void *user)
{
  const disks *d = user;
  (void)t;
  (void)q;
  for (int i = 0; i < d->count; i++, M += 9) {
    M[0] = M[4] = d->mass;
    M[8] = d->mass * d->radius * d->radius / 2;
  }
  return 0;
}

static int force(double t, const double *q, const double *v, double *F, void *user)
{
  const disks *d = user;
  (void)t;
  (void)q;
  (void)v;
  for (int i = 0; i < d->count; i++) {
    F[3 * i] = F[3 * i + 2] = 0;
    F[3 * i + 1] = -d->mass * d->gravity;
  }
  return 0;
}

/* The lowest point moves by x' + r theta' along the floor. */
static int contacts(double t, const double *q, const double *v, double reach,
                    nsdae_contact_list *list, void *user)
{
  const disks *d = user;
  (void)t;
  (void)v;
  for (int i = 0; i < d->count; i++) {
    nsdae_contact contact = {.id = i,
                             .block = {i, -1},
                             .gap = q[3 * i + 1] - d->radius,
                             .mu = d->mu,
                             .direction = {{{0, 1, 0}, {1, 0, d->radius}}}};
    if (contact.gap <= reach) nsdae_contact_add(list, &contact);
  }
  return 0;
}

static nsdae_sim *create(disks *d, nsdae_system **system)
{
  const nsdae_dims dims = {.nq = 3 * d->count, .nt = 1};
  static double q0[3 * MOST], v0[3 * MOST];
  static int threes[MOST];
  nsdae_sim_options options;
  nsdae_sim *sim;
  if (nsdae_system_create(&dims, system, NULL) < 0) return NULL;
  for (int i = 0; i < d->count; i++) {
    threes[i] = 3;
    q0[3 * i] = 3 * d->radius * i;
    q0[3 * i + 1] = d->radius;
  }
  nsdae_system_set_user(*system, d);
  nsdae_system_set_blocks(*system, d->count, threes, threes);
  nsdae_system_set_mass_blocks(*system, mass);
  nsdae_system_set_force(*system, force);
  nsdae_system_set_contacts(*system, contacts);
  nsdae_sim_options_default(&options);
  options.method = NSDAE_METHOD_MOREAU;
  options.dt = d->dt;
  if (nsdae_sim_create(*system, &options, &sim, NULL) < 0) return NULL;
  if (nsdae_sim_init(sim, 0, q0, v0) < 0) nsdae_sim_destroy(&sim);
  return sim;
}

static double own_disks(disks *d, double *fastest)
{
  nsdae_system *system = NULL;
  double taken = -1;
  nsdae_record record;
  nsdae_sim *sim = create(d, &system);
  double start = ratio_cpu();
  if (sim && nsdae_sim_run(sim, d->steps * d->dt) == NSDAE_OK) {
    taken = ratio_cpu() - start;
    nsdae_sim_get_record(sim, &record);
    *fastest = 0;
    for (int i = 0; i < 3 * d->count; i++) *fastest = fmax(*fastest, fabs(record.v[i]));
  }
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  return taken;
}

int main(void)
{
  const int counts[] = {10, 100, 300, 1000};
  printf("Disks at rest on a floor, time of a step; ratio: ours to theirs, medians of %d.\n", RUNS);
  for (int i = 0; i < 4; i++) {
    disks d = {counts[i], counts[i] < 1000 ? 300 : 100, 0.1, 1, 9.81, 0.5, 1e-3};
    double own[RUNS], peer[RUNS], fastest = NAN, theirs = NAN;
    char title[80];
    for (int j = 0; j < RUNS; j++) {
      own[j] = own_disks(&d, &fastest);
      peer[j] = siconos_disks(&d, &theirs);
      if (own[j] < 0) return 1;
    }
    double a = ratio_median(RUNS, own) / d.steps, b = ratio_median(RUNS, peer) / d.steps;
    printf("%d: nsdae %.3f us, fastest %g m/s\n", d.count, 1e6 * a, fastest);
    if (b < 0)
      printf("  Siconos: not here\n");
    else
      printf("  Siconos %.3f us, ratio %.4f, fastest %g m/s\n", 1e6 * b, a / b, theirs);
    snprintf(title, sizeof title, "step, disks at rest, %d", d.count);
    if (ratio_add(title, a, "Siconos", b) < 0) return 1;
  }
  return 0;
}
