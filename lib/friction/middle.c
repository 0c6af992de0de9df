/* Near a solution where items are locked in one another kinks are everywhere, and proximal points
 * creep from each to the next. Of all r with much the same u an interior point takes the middle
 * one, far from kinks: from there Newton's method gets to the solution, or to a better shift. */
#include "middle.h"

#include <string.h>

#include "further.h"

/* Convex problems whose solutions are in the middle, and of them those that have not made the
 * residual less by a factor, after which it is given up; Newton steps from each. */
enum { MIDDLES = 40, FRUITLESS = 4, FROM_MIDDLE = 150 };
static const double FRUIT = 0.7;

/* As near as that they lead to a solution. */
static const double MIDWAY = 1e-4;

/* The solution of the convex problem whose shift is that of fc->u; 0: not found. */
static int to_the_middle(nsdae_fc_chain *c)
{
  if (!nsdae_fc_ready(c)) return 0;
  for (int k = 0; k < c->fc.n; k++) c->interior.shift[k] = nsdae_fc_slip(&c->fc, k);
  int found = nsdae_fc_interior_run(&c->interior, &c->newton);
  return nsdae_fc_count(c, NSDAE_FRICTION_FURTHER) || found;
}

static int through_the_middle(nsdae_fc_chain *c)
{
  double least = c->info.residual;
  for (int k = 0, since = 0; k < MIDDLES && since < FRUITLESS; k++, since++) {
    if (!to_the_middle(c)) return 0;
    if (nsdae_fc_arrived(c)) return 1;
    if (!nsdae_fc_ready(c)) return 0;
    c->newton.most = FROM_MIDDLE;
    nsdae_fc_proximal(&c->newton, 1e-8, c->tol);
    if (nsdae_fc_count(c, NSDAE_FRICTION_FURTHER) || nsdae_fc_arrived(c)) return 1;
    if (c->info.residual < FRUIT * least) least = c->info.residual, since = -1;
    nsdae_fc_interior_locate(&c->interior, &c->fc);
  }
  return 0;
}

int nsdae_fc_middle_on(nsdae_fc_chain *c)
{
  const double before = c->info.residual;
  if (!c->patient || c->fc.local || c->options->max_iterations > 0) return 0;
  nsdae_fc_velocities(&c->fc, c->fc.r, c->fc.y, c->fc.u);
  if (!(nsdae_fc_residual(&c->fc, c->fc.r, c->fc.u) < MIDWAY)) return 0;
  memcpy(c->interior.held, c->fc.r, nsdae_fc_bytes(c));
  if (through_the_middle(c)) return 1;
  const double *from = c->info.residual < before ? c->best : c->interior.held;
  memcpy(c->fc.r, from, nsdae_fc_bytes(c));
  return 0;
}
