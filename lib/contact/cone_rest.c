/* Rest of an island with true cones:
 *
 *   of several solutions, u = 0 if it is one and all rested before
 *   at rest, the impulses to rounding: J r + q = 0 to 1e-2 NSDAE_STILL */
#include "cone_island.h"

#include <math.h>
#include <string.h>

#include "friction_solver.h"
#include "vector.h"

/* Newton steps to rounding. */
enum { STEPS = 10 };

/* The natural residual of a contact that sticks is its velocity: bodies at rest move as fast,
 * within an order of magnitude. Faster motion goes on after the residual is 0: a ball that rolls in
 * a heap. */
static const double FROM_RESIDUAL = 10;

/* Whether the residual explains all velocities of contacts. */
static int all_stick(const nsdae_cone_island *c, const nsdae_cone_work *work)
{
  const double most = FROM_RESIDUAL * work->info.residual * nsdae_fc_speed(work->solver);
  return nsdae_largest(c->m, c->at.u) <= most;
}

/* Whether it explains those of bodies, too: one that rolls moves no item. Over n bodies, one upon
 * the other, random errors add up to sqrt(n) times one. */
static int is_at_rest(nsdae_cone_island *c, const nsdae_island_equations *w,
                      const nsdae_cone_work *work)
{
  const int *first = w->system->blocks.first;
  const double most = FROM_RESIDUAL * work->info.residual * nsdae_fc_speed(work->solver);
  if (!all_stick(c, work) || nsdae_cone_form_velocities(c, w, work->L) < 0) return 0;
  const double stacked = most * sqrt(c->problem.blocks);
  for (int i = 0; i < c->problem.blocks; i++)
    for (int b = c->at.member[i], j = first[b]; j < first[b + 1]; j++)
      if (!(fabs(w->v[j]) * c->lever[j] <= stacked)) return 0;
  return 1;
}

/* A warm start within tol has a residual up to tol, which moves bodies at rest for ever. If it is
 * taken as it is and nothing else moves, Newton's method solves it to rounding, once: from then on
 * the impulses are those of rest. Walls take 4 to 7 steps of it. */
int nsdae_cone_solve_rest(nsdae_cone_island *c, const nsdae_island_equations *w,
                          nsdae_cone_work *work, double budget)
{
  if (c->driven || work->info.sweeps + work->info.iterations > 0 ||
      !(work->info.residual > NSDAE_STILL) || !is_at_rest(c, w, work))
    return NSDAE_OK;
  c->options.stages = NSDAE_FRICTION_WARM;
  c->options.max_iterations = STEPS;
  int status = nsdae_cone_solve_to(c, work, 1e-2 * NSDAE_STILL, budget);
  return status == NSDAE_E_LCP && work->info.residual <= work->tol ? NSDAE_OK : status;
}

/* Whether nothing moves before the step, up to the velocities that residuals leave. */
static int rested(const nsdae_cone_island *c, const nsdae_island_equations *w,
                  const nsdae_cone_work *work)
{
  const nsdae_impulses *r = w->results;
  const int nt = w->system->dims.nt;
  double most = 0;
  for (int i = 0; i < c->contacts; i++) {
    int a = c->at.item[i];
    most = fmax(most, fmax(fabs(r->before[a]), nsdae_largest(nt, r->before_t + a * nt)));
  }
  return most <= FROM_RESIDUAL * work->tol * nsdae_fc_speed(work->solver);
}

/* Coulomb's law may have several solutions where contacts are hyperstatic, as of a body in a grip.
 * If all rested, and rest is one, it is the one that is used: that of the convex problem with s = 0
 * (Acary, Cadoux, Lemarechal, Malick 2011), which has the least |u|, if it has u = 0. All that have
 * it have the same v: J M^-1 J' dr = 0 only if J' dr = 0. */
int nsdae_cone_prefer_rest(nsdae_cone_island *c, const nsdae_island_equations *w,
                           nsdae_cone_work *work, double budget)
{
  if (c->driven || c->contacts < 2 || !rested(c, w, work) || all_stick(c, work)) return NSDAE_OK;
  const nsdae_friction_info before = work->info;
  const nsdae_friction_options options = c->options;
  c->options.stages = NSDAE_FRICTION_SOCP_INTERIOR_POINT | NSDAE_FRICTION_ITERATIVE_REFINEMENT;
  int status = nsdae_cone_solve_to(c, work, work->tol, budget);
  if (status == NSDAE_OK && all_stick(c, work)) return status;
  /* back to the other one, which is a solution */
  memcpy(c->at.r, c->at.guess, (size_t)c->m * sizeof *c->at.r);
  work->info = before;
  c->options = options;
  return nsdae_cone_solve_to(c, work, work->tol, budget);
}
