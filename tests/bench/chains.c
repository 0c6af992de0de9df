/* Constraints of large mechanisms: factorisation and solution; steps of moreau and implicit with
 * linear constraints J q = 0. Least CPU time of several runs, in ms. Then event: one second of a
 * chain on spherical joints without and with viscous friction in the joints. usage: bench_chains */
#include <math.h>
#include <stdio.h>

#include <nsdae/nsdae.h>

#include "ratio.h"

#include "sparse_kkt.h"
#include "support/joint_families.h"
#include "support/stiff_chain.h"

enum { RUNS = 7 };

static joint_family f; /* the callbacks' */

static double *right_hand_side(void)
{
  size_t n = (size_t)(f.nv + OTHER), m = (size_t)f.rows + 1;
  double *b = calloc(2 * (n + m), sizeof *b), *x = b + n + m, *l = x + n;
  for (size_t i = OTHER; i < n; i++) x[i] = random_number(&f.random);
  for (size_t i = 1; i < m; i++) l[i] = random_number(&f.random);
  family_apply(&f, 1, x, l, b, b + n);
  return b;
}

/* Factor and solve; INFINITY: not solved. */
static double solution(void)
{
  nsdae_sparse_kkt k = {.rank_tol = 1e-8};
  const nsdae_kkt_part part = {&f.blocks, &f.J, f.bodies, f.rows, f.block, f.row};
  size_t n = (size_t)(f.nv + OTHER), m = (size_t)f.rows + 1;
  double *b = right_hand_side(), *v = calloc(n + m, sizeof *v), least = INFINITY;
  int status = nsdae_sparse_kkt_analyse(&k, &part);
  for (int i = 0; i < RUNS && status == NSDAE_OK; i++) {
    memcpy(v + n, b + n, m * sizeof *v);
    double start = 1e3 * ratio_cpu();
    status = nsdae_sparse_kkt_analyse(&k, &part);
    if (status == NSDAE_OK) status = nsdae_sparse_kkt_factor(&k, f.M);
    if (status == NSDAE_OK) status = nsdae_sparse_kkt_solve(&k, b, v, v + n);
    least = fmin(least, 1e3 * ratio_cpu() - start);
  }
  nsdae_sparse_kkt_release(&k);
  free(b), free(v);
  return status == NSDAE_OK ? least : INFINITY;
}

static int mass(double t, const double *q, double *M, void *user)
{
  (void)t, (void)q, (void)user;
  memcpy(M, f.M, f.blocks.square[f.blocks.count] * sizeof *M);
  M[0] = M[3] = 1; /* the block that is not of the mechanism */
  return 0;
}

static int force(double t, const double *q, const double *v, double *F, void *user)
{
  (void)t, (void)q, (void)v, (void)user;
  memset(F, 0, (size_t)(f.nv + OTHER) * sizeof *F);
  for (int b = 0; b < f.bodies; b++)
    F[OTHER + 6 * b + 2] = -9.81 * f.M[OTHER * OTHER + 36 * b + 14];
  return 0;
}

static int phi(double t, const double *q, double *value, void *user)
{
  (void)t, (void)user;
  for (int i = 0; i <= f.rows; i++) value[i] = nsdae_rows_dot(&f.blocks, &f.J, i, q);
  return 0;
}

static int rows(double t, const double *q, nsdae_row_list *list, void *user)
{
  int status = 0;
  (void)t, (void)q, (void)user;
  for (int i = 0; i <= f.rows && status == 0; i++)
    for (int p = f.J.first[i]; p < f.J.first[i + 1] && status == 0; p++)
      status = nsdae_row_add(list, i, f.J.block[p], f.J.value + f.J.at[p]);
  return status;
}

static int bias(double t, const double *q, const double *v, double *phi_t, double *omega,
                void *user)
{
  (void)t, (void)q, (void)v, (void)user;
  memset(phi_t, 0, ((size_t)f.rows + 1) * sizeof *phi_t);
  memset(omega, 0, ((size_t)f.rows + 1) * sizeof *omega);
  return 0;
}

/* One step of the method; INFINITY: refused. */
static double step(int method)
{
  enum { STEPS = 10 };
  const nsdae_dims dims = {.nq = f.nv + OTHER, .nv = f.nv + OTHER, .m = f.rows + 1, .nt = 2};
  int *size = calloc((size_t)f.blocks.count, sizeof *size);
  double *q = calloc(2 * (size_t)dims.nv, sizeof *q), least = INFINITY;
  nsdae_system *system = NULL;
  nsdae_sim_options options;
  nsdae_sim *sim = NULL;
  for (int b = 0; b < f.blocks.count; b++) size[b] = nsdae_blocks_size(&f.blocks, b);
  f.J.value[0] = 1; /* of the other block */
  nsdae_system_create(&dims, &system, NULL);
  nsdae_system_set_blocks(system, f.blocks.count, size, size);
  nsdae_system_set_mass_blocks(system, mass);
  nsdae_system_set_force(system, force);
  nsdae_system_set_constraint(system, phi);
  nsdae_system_set_constraint_rows(system, rows);
  nsdae_system_set_constraint_bias(system, bias);
  nsdae_sim_options_default(&options);
  options.method = method;
  options.redundant = NSDAE_REDUNDANT_LEAST_NORM;
  options.dt = 1e-3;
  int status = nsdae_sim_create(system, &options, &sim, NULL);
  if (status >= 0) status = nsdae_sim_init(sim, 0, q, q + dims.nv);
  for (int i = 0; i < STEPS && status >= 0; i++) {
    double start = 1e3 * ratio_cpu();
    status = nsdae_sim_step(sim);
    least = fmin(least, 1e3 * ratio_cpu() - start);
  }
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  free(size), free(q);
  return status < 0 ? INFINITY : least;
}

static void table(const char *name, int kind, int revolute, const int *sizes)
{
  for (; *sizes > 0; sizes++) {
    family_make(&f, kind, *sizes, revolute, 0, 1);
    printf("%-18s %6d %6d %10.3f %10.3f %10.3f\n", name, f.bodies, f.rows, solution(),
           step(NSDAE_METHOD_MOREAU), step(NSDAE_METHOD_IMPLICIT));
    family_release(&f);
  }
}

/* One second of a chain by event at rtol 1e-6. */
static void smooth(int n, double damping, const char *integrator)
{
  stiff_chain chain = {n, damping};
  nsdae_system *system = stiff_chain_system(&chain, 1);
  double *q = calloc(13 * (size_t)n, sizeof *q), *v = q + 7 * (size_t)n;
  nsdae_sim_options options;
  nsdae_stats stats = {0};
  nsdae_error error;
  nsdae_sim *sim = NULL;
  nsdae_sim_options_default(&options);
  nsdae_sim_options_set(&options, "method", "event", NULL);
  nsdae_sim_options_set(&options, "integrator", integrator, NULL);
  options.dt = 0.1;
  options.rtol = 1e-6;
  options.atol = 1e-8;
  options.inner_steps_max = 1000000;
  stiff_chain_start(&chain, q, v);
  int status = nsdae_sim_create(system, &options, &sim, &error);
  if (status >= 0) status = nsdae_sim_init(sim, 0, q, v);
  double start = 1e3 * ratio_cpu();
  if (status >= 0) status = nsdae_sim_run(sim, 1);
  double time = 1e3 * ratio_cpu() - start;
  if (status < 0 && sim) error = *nsdae_sim_error(sim);
  nsdae_sim_get_stats(sim, &stats);
  if (status < 0)
    printf("%6d %8g %-7s %s\n", n, damping, integrator, error.text);
  else
    printf("%6d %8g %-7s %8ld %10.2f %10.4f\n", n, damping, integrator, stats.force_evals, time,
           time / (double)stats.force_evals);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  free(q);
}

int main(void)
{
  const int chains[] = {10, 100, 1000, 10000, 0}, nets[] = {9, 100, 2500, 0};
  const int ladders[] = {99, 999, 0};
  printf("%-18s %6s %6s %10s %10s %10s\n", "ms", "bodies", "rows", "solution", "moreau",
         "implicit");
  table("chain, spherical", CHAIN, 0, chains);
  table("chain, revolute", CHAIN, 1, chains);
  table("tree, spherical", TREE, 0, chains);
  table("tree, revolute", TREE, 1, chains);
  table("net, spherical", NET, 0, nets);
  table("ladder, revolute", LADDER, 1, ladders);
  table("ring, revolute", RING, 1, ladders);
  printf("\n%6s %8s %-7s %8s %10s %10s\n", "links", "friction", "event", "forces", "ms", "ms each");
  for (int n = 10; n <= 1000; n *= 10) {
    smooth(n, 0, "dopri5"), smooth(n, 0, "dop853");
    smooth(n, 10, "auto"), smooth(n, 10, "ida");
  }
  return 0;
}
