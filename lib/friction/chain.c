#include "chain.h"

#include <math.h>
#include <string.h>

#include "cone.h"
#include "sweep.h"

enum { MOST_SWEEPS = 20000, BETWEEN = 20 };

void nsdae_fc_chain_layout(void *object, nsdae_arena *arena)
{
  nsdae_fc_chain *c = object;
  nsdae_fc_layout(&c->fc, arena);
  c->best = NSDAE_ARENA_DOUBLES(arena, 3L * c->fc.n);
  c->slip = NSDAE_ARENA_DOUBLES(arena, c->fc.n);
}

/* Keeps fc->r where it is better than all before; returns whether it is a solution. */
static int judge(nsdae_fc_chain *c, int stage)
{
  nsdae_fc_velocities(&c->fc, c->fc.r, c->fc.y, c->fc.u);
  double residual = nsdae_fc_residual(&c->fc, c->fc.r, c->fc.u);
  if (!(residual < c->info.residual)) return 0;
  c->info.residual = residual;
  memcpy(c->best, c->fc.r, 3 * (size_t)c->fc.n * sizeof *c->best);
  if (residual > c->tol) return 0;
  c->info.outcome = NSDAE_OUTCOME_SOLVED;
  c->info.stage = stage;
  return 1;
}

static void start_cold(nsdae_fc_chain *c)
{
  memset(c->fc.r, 0, 3 * (size_t)c->fc.n * sizeof *c->fc.r);
  memset(c->slip, 0, (size_t)c->fc.n * sizeof *c->slip);
}

/* The point on entry is kept in best while r = 0 is looked at. */
static int trivial(nsdae_fc_chain *c)
{
  for (int k = 0; k < c->fc.n; k++) {
    double gap = c->fc.q[3 * k];
    if (!(gap >= 0) || (c->fc.kind[k] == NSDAE_FC_BILATERAL && gap != 0)) return 0;
  }
  start_cold(c);
  return judge(c, NSDAE_FRICTION_TRIVIAL);
}

/* Sweeps from fc->r on, looked at after every BETWEEN. */
static int sweeps(nsdae_fc_chain *c, int most, int stage)
{
  if (judge(c, stage)) return 1;
  for (int done = 0; done < most; done += BETWEEN) {
    nsdae_fc_sweep(&c->fc, BETWEEN, c->slip);
    c->info.sweeps += BETWEEN;
    if (judge(c, stage)) return 1;
  }
  return 0;
}

static int most_sweeps(const nsdae_fc_chain *c)
{
  return c->options->max_sweeps > 0 ? c->options->max_sweeps : MOST_SWEEPS;
}

static int warm(nsdae_fc_chain *c)
{
  double most = 0;
  for (int k = 0; k < 3 * c->fc.n; k++) most = fmax(most, fabs(c->fc.r[k]));
  if (!(most > 0)) return 0;
  memset(c->slip, 0, (size_t)c->fc.n * sizeof *c->slip);
  return sweeps(c, most_sweeps(c) / 10, NSDAE_FRICTION_WARM);
}

static int gauss_seidel(nsdae_fc_chain *c)
{
  start_cold(c);
  return sweeps(c, most_sweeps(c), NSDAE_FRICTION_GAUSS_SEIDEL);
}

void nsdae_fc_chain_run(nsdae_fc_chain *c)
{
  static const struct {
    int stage;
    int (*run)(nsdae_fc_chain *);
  } all[] = {{NSDAE_FRICTION_TRIVIAL, trivial},
             {NSDAE_FRICTION_WARM, warm},
             {NSDAE_FRICTION_GAUSS_SEIDEL, gauss_seidel}};
  c->info = (nsdae_friction_info){.residual = INFINITY};
  memset(c->best, 0, 3 * (size_t)c->fc.n * sizeof *c->best);
  for (size_t i = 0; i < sizeof all / sizeof *all; i++)
    if ((c->options->stages & all[i].stage) && all[i].run(c)) return;
}
