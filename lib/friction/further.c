#include "further.h"

#include <limits.h>
#include <math.h>
#include <string.h>

#include "conic.h"
#include "curves.h"
#include "middle.h"
#include "sweep.h"

/* Sweeps of tolerances that they are likely to reach. */
enum { MANY = 20000 };

/* Sweeps with Newton's steps between them: so many items swept, a minute or so, and at most so many
 * sweeps; */
static const double ROAMED = 7e8;
enum { ROAM = 650000 };

/* sweeps between two looks; Newton steps of one attempt, and what sweeps one of them costs. */
enum { BLOCK = 2500, ATTEMPT = 150, STEP_IN_SWEEPS = 130 };

/* Contacts up to which curves are short. */
enum { SMALL = 24 };

/* Newton steps times items that an island may take until its short curves end, half as many for a
 * row of paths, and one curve: fifteen seconds or so; one curve of the last resort, and all of
 * them, which is one of a large island: half a minute or so. */
static const double BUDGET = 2.2e6, CURVE = 1e6, LONG_CURVE = 2e7, LONG_CURVES = 2e7;

/* The same of convex problems, and of those of the last resort, and of its first walk; at most so
 * many of the first. */
static const double SHIFTED = 1e7, LONG_SHIFTED = 6e8, SOON = 1.5e8;
enum { MANY_SHIFTS = 600 };

/* The same of a contact by itself, of which there may be many in an instant: what few steps more do
 * not solve has, but for one in thousands, no solution. */
static const double ALONE = 1500;

/* Newton steps that have not halved what is nearly solved, after which its last digits are given
 * up, for few items and times items; as many times that are enough in any case. */
enum { IDLE = 4000, LONGER = 10 };

/* The same of all the steps that creep, times items: five minutes or so. */
static const double CREPT = 3e8;

/* What is so near is not given up before. */
static const double NEAR = 1e-5;

/* What the best point is worth by the data as given. */
static int value(nsdae_fc_chain *c, double residual)
{
  c->info.residual = residual;
  c->info.outcome = residual <= c->tol ? NSDAE_OUTCOME_SOLVED : NSDAE_OUTCOME_UNSOLVED;
  return residual <= c->tol;
}

/* A better point, in one part or two. */
static int take(nsdae_fc_chain *c, double residual, const double *low)
{
  memcpy(c->best, c->precise.high, nsdae_fc_bytes(c));
  if (low) memcpy(c->low, low, nsdae_fc_bytes(c));
  c->info.stage = NSDAE_FRICTION_FURTHER;
  return value(c, residual);
}

/* The last digits from a point on, by the data as given, in two parts where one does not hold them:
 * who takes one gets that, if it is better than the best. creep, times: see precise.h. */
static int refine(nsdae_fc_chain *c, const double *from, int creep, int times)
{
  memcpy(c->precise.high, from, nsdae_fc_bytes(c));
  memset(c->precise.low, 0, nsdae_fc_bytes(c));
  const double before = nsdae_fc_precise_residual(&c->precise, &c->fc);
  if (from == c->best) value(c, before);
  if (c->info.outcome == NSDAE_OUTCOME_SOLVED) return 1;
  nsdae_fc_interior *interior = c->patient && !c->fc.local ? &c->interior : NULL;
  double residual = nsdae_fc_precise_run(&c->precise, &c->newton, interior, c->tol, creep, times);
  c->info.iterations += c->newton.steps;
  c->info.factorisations += c->newton.steps;
  c->seen.spent += c->newton.steps;
  c->seen.held = residual <= c->tol;
  if (c->seen.held && c->twice) return take(c, residual, c->precise.low);
  memset(c->precise.low, 0, nsdae_fc_bytes(c));
  residual = nsdae_fc_precise_residual(&c->precise, &c->fc);
  return residual < c->info.residual && take(c, residual, NULL);
}

/* Whoever asks goes on from its own point, with its own steps. */
int nsdae_fc_precisely(nsdae_fc_chain *c)
{
  const nsdae_fc_newton asks = c->newton;
  if (!(c->info.residual <= NSDAE_FC_NEARLY) || !nsdae_fc_ready(c)) return 0;
  int found = refine(c, c->best, 0, 0);
  c->newton = asks;
  return found;
}

/* Nothing is left to be done: the best point is a solution, or what rounding leaves of one. Looked
 * at closely where it is nearly one, and better than when it was the last time. */
int nsdae_fc_arrived(nsdae_fc_chain *c)
{
  if (c->info.outcome == NSDAE_OUTCOME_SOLVED || nsdae_fc_exhausted(c)) return 1;
  if (!(c->info.residual <= NSDAE_FC_NEARLY) || !(c->info.residual < 0.5 * c->seen.looked))
    return 0;
  c->seen.looked = c->info.residual;
  return nsdae_fc_precisely(c);
}

/* Where much slides, sweeps go on getting better, slowly; and Newton starts elsewhere. */
static int patience(nsdae_fc_chain *c, int most)
{
  nsdae_fc_start_cold(c);
  return nsdae_fc_sweeps(c, most, 0, NSDAE_FRICTION_FURTHER) ||
         nsdae_fc_try_proximal(c, 1e-2, 0, NSDAE_FRICTION_FURTHER);
}

/* Creeping steps that are allowed from here on: few where nothing is near, else ten times as many,
 * as long as the island has not had all of its own. */
static int creeping_steps(const nsdae_fc_chain *c, int *few)
{
  *few = c->options->max_iterations > 0 ? c->newton.most : (int)fmin(IDLE, BUDGET / c->fc.n);
  const int many = c->patient && c->options->max_iterations == 0 ? LONGER * *few : *few;
  return (int)fmin(many, fmax(0, CREPT / c->fc.n - c->seen.creeping));
}

/* In one part, and from where that ends in two, if it is nearer than before: the best point may be
 * what rounding leaves of one that has no solution beside it. */
static int creep_twice(nsdae_fc_chain *c)
{
  int few, many = creeping_steps(c, &few);
  if (many == 0) return 0;
  nsdae_fc_velocities(&c->fc, c->fc.r, c->fc.y, c->fc.u);
  c->newton.most = many;
  const int near = nsdae_fc_residual(&c->fc, c->fc.r, c->fc.u) < NEAR;
  nsdae_fc_creep(&c->newton, near ? many : few, c->tol);
  if (nsdae_fc_count(c, NSDAE_FRICTION_FURTHER)) return 1;
  const double here = nsdae_fc_residual(&c->fc, c->fc.r, c->fc.u);
  if (nsdae_fc_arrived(c)) return 1;
  const int nearer = here <= NSDAE_FC_NEARLY && here < 0.5 * c->seen.crept;
  if (!c->patient || !nearer || !nsdae_fc_ready(c)) return 0;
  c->seen.crept = here;
  return refine(c, c->fc.r, few, many / few);
}

int nsdae_fc_creep_on(nsdae_fc_chain *c)
{
  if (c->fc.n == 1) return 0;
  if (nsdae_fc_middle_on(c)) return 1;
  if (!nsdae_fc_ready(c)) return 0;
  const int before = c->seen.spent, found = creep_twice(c);
  c->seen.creeping += c->seen.spent - before;
  return found;
}

/* The last digits, from the best point, where it is better than when they were sought last. */
static int creep(nsdae_fc_chain *c)
{
  if (!(c->info.residual <= NSDAE_FC_NEARLY)) return 0;
  if (!(c->info.residual < 0.5 * c->seen.crept)) return 0;
  memcpy(c->fc.r, c->best, nsdae_fc_bytes(c));
  return nsdae_fc_creep_on(c);
}

/* Proximal points from fc->r on, as long as each attempt leaves half of what there was. */
static int attempt(nsdae_fc_chain *c, double residual, long *spent)
{
  double before, alpha = 1e-4;
  do {
    if (!nsdae_fc_ready(c)) return 0;
    if (c->newton.most > ATTEMPT) c->newton.most = ATTEMPT;
    before = residual;
    residual = nsdae_fc_proximal(&c->newton, alpha, c->tol);
    alpha = c->newton.alpha;
    *spent += c->newton.steps;
    if (nsdae_fc_count(c, NSDAE_FRICTION_FURTHER) || nsdae_fc_arrived(c)) return 1;
  } while (residual <= 0.5 * before);
  return creep(c);
}

/* Of an impact in which nearly all slides the residual of sweeps falls for a while and rises again:
 * impulses drift along what hardly moves u, until a contact opens and many others follow. Now and
 * then the drift goes to a solution; a calm shows it, and Newton's method takes what is left. */
static int roam(nsdae_fc_chain *c)
{
  double *here = c->anderson.before, lowest = INFINITY;
  const double price = fmax(STEP_IN_SWEEPS, c->fc.local ? c->fc.n : 0); /* dense: n^3 to n^2 */
  long spent = 0, most = (long)fmin(ROAM, ROAMED / nsdae_fc_work(c));
  if (c->options->max_sweeps > 0 && c->options->max_sweeps < most) most = c->options->max_sweeps;
  nsdae_fc_start_cold(c);
  nsdae_fc_sweep_begin(&c->fc);
  for (long done = BLOCK; done <= most; done += BLOCK) {
    nsdae_fc_sweep(&c->fc, BLOCK, c->slip);
    c->info.sweeps += BLOCK;
    if (nsdae_fc_judge(c, NSDAE_FRICTION_FURTHER)) return 1;
    double residual = nsdae_fc_residual(&c->fc, c->fc.r, c->fc.u);
    lowest = fmin(lowest, residual);
    if (residual > 2 * lowest || price * (double)spent > (double)done) continue;
    memcpy(here, c->fc.r, nsdae_fc_bytes(c));
    if (attempt(c, residual, &spent)) return 1;
    memcpy(c->fc.r, here, nsdae_fc_bytes(c));
    nsdae_fc_sweep_begin(&c->fc);
  }
  return 0;
}

/* Newton steps times items */
static double budget(const nsdae_fc_chain *c)
{
  return c->fc.n > 1 ? BUDGET : ALONE;
}

/* Which items stand where a path ends depends on how closely it is followed; so others are tried,
 * fewer of larger islands. */
static int paths(nsdae_fc_chain *c, int from, int to)
{
  int before = c->seen.spent;
  static const double loose[] = {1e-5, 1e-2, 1e-4, 0.1,  3e-3, 1e-6, 3e-4, 3e-2, 3e-5, 3e-6,
                                 5e-2, 2e-3, 2e-4, 2e-5, 5e-3, 0.2,  5e-4, 2e-2, 5e-5, 1e-7};
  for (int k = from; k < to && (c->seen.spent - before) * 2.0 * c->fc.n < budget(c); k++) {
    if (nsdae_fc_try_path(c, loose[k], NSDAE_FRICTION_FURTHER)) return 1;
    if (nsdae_fc_arrived(c)) return 1;
  }
  return 0;
}

/* Curves within what the budget of an island leaves. */
static int short_curves(nsdae_fc_chain *c)
{
  return nsdae_fc_curves(c, CURVE, fmax(0, budget(c) - (double)c->seen.spent * c->fc.n));
}

/* Convex problems until their shift is theirs, from none on: many steps, which dense factors make
 * dear. */
static int shifts(nsdae_fc_chain *c)
{
  if (c->fc.local) return 0;
  nsdae_fc_start_cold(c);
  return nsdae_fc_conic(c, NSDAE_FC_QUICKLY, MANY_SHIFTS, c->patient ? SHIFTED : budget(c) / 4,
                        NSDAE_FRICTION_FURTHER);
}

/* The same from the shift of the best point on. */
static int walk_on(nsdae_fc_chain *c, int how, double most)
{
  memcpy(c->fc.r, c->best, nsdae_fc_bytes(c));
  nsdae_fc_velocities(&c->fc, c->fc.r, c->fc.y, c->fc.u);
  nsdae_fc_shift(&c->fc, c->slip);
  c->seen.crept = INFINITY;
  return nsdae_fc_conic(c, how, INT_MAX, most, NSDAE_FRICTION_FURTHER);
}

/* Most walks that lead to a solution do so soon, and the others stray: then a second one. Not where
 * the caller counts sweeps or steps. */
static int long_shifts(nsdae_fc_chain *c)
{
  if (c->fc.local || c->info.residual <= NSDAE_FC_NEARLY) return 0;
  if (c->options->max_sweeps > 0 || c->options->max_iterations > 0) return 0;
  return walk_on(c, NSDAE_FC_EXACTLY, SOON) || walk_on(c, NSDAE_FC_RETURNING, LONG_SHIFTED - SOON);
}

/* Long curves; what is nearly solved lacks digits, which no other curve has. Dense factors cost n
 * times as much. */
static int long_curves(nsdae_fc_chain *c)
{
  const double share = c->fc.local ? 1.0 / c->fc.n : 1;
  return c->info.residual > NSDAE_FC_NEARLY &&
         nsdae_fc_curves(c, share * LONG_CURVE, share * LONG_CURVES);
}

/* The last resort. Of few contacts the short curves have seen all there is. Where most of it
 * slides, curves have folds without end, and sweeps get further. */
static int last(nsdae_fc_chain *c)
{
  if (!c->patient || c->fc.n <= SMALL || c->seen.held) return 0;
  if (c->seen.slides) return roam(c) || long_shifts(c) || long_curves(c);
  return long_shifts(c) || roam(c) || long_curves(c);
}

/* Sweeps reach a few digits, paths many, and curves get round what stops both. Of one contact a
 * sweep is what the one before was. */
int nsdae_fc_further(nsdae_fc_chain *c)
{
  if (nsdae_fc_arrived(c)) return 1;
  if (c->fc.n == 1) return paths(c, 0, 2) || short_curves(c);
  if (c->tol >= NSDAE_FC_ROUGH)
    return patience(c, MANY) || paths(c, 0, 20) || short_curves(c) || last(c);
  return creep(c) || patience(c, MANY / 10) || paths(c, 0, 2) || (!c->seen.slides && shifts(c)) ||
         short_curves(c) || paths(c, 2, 20) || last(c);
}
