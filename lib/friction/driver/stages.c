#include "stages.h"

#include <float.h>
#include <limits.h>
#include <math.h>
#include <string.h>

#include "cone.h"

/* Contacts up to which a factorisation costs less than the sweeps that it saves. */
enum { SMALL = 24 };

/* Contacts from which the interior point comes before everything else that factors. */
enum { LARGE = 3000 };

/* A larger residual after the first sweeps: weights do not get to the ground by sweeps. Of seeded
 * walls, towers and storeys at rest three quarters keep 0.07 and more, of those that are hit half
 * less than 0.04. */
static const double HYPERSTATIC = 5e-2;

/* Sweeps alone are likely to reach it; from here on iterative refinement converges. */
static const double NEARLY = 1e-6;

/* Roundings of the scaled data that add up in a velocity. */
static const double DOUBT = 8;

/* Default budget, products times items: a product takes 0.024 to 0.047 us an item, and what is not
 * solved ends after 6 to 47 s. Products for each item of an island, so
 * that one of 50 contacts ends within a second or two. */
static const double WORK = 1e9, EACH = 2e4;

/* Each round of the solvers that improve an iterate may take GROWTH times as much as the one
 * before: what a shorter round cost again is at most a third. */
static const double GROWTH = 4;

void nsdae_fc_run_layout(void *object, nsdae_arena *arena)
{
  nsdae_fc_run *run = object;
  nsdae_fc_island *s = &run->island;
  nsdae_fc_layout(&s->fc, arena);
  s->newton.fc = &s->fc;
  nsdae_fc_newton_layout(&s->newton, arena);
  nsdae_fc_anderson_layout(&s->anderson, &s->fc, arena);
  nsdae_fc_socp_layout(&s->socp, &s->fc, arena);
  nsdae_fc_refinement_layout(&s->refinement, &s->fc, arena);
  nsdae_fc_as_lcp_layout(&s->as_lcp, &s->fc, arena);
  s->slip = NSDAE_ARENA_DOUBLES(arena, s->fc.n);
  s->point = NSDAE_ARENA_DOUBLES(arena, 3L * s->fc.n);
  run->iterate.r = NSDAE_ARENA_DOUBLES(arena, 3L * s->fc.n);
  run->iterate.low = NSDAE_ARENA_DOUBLES(arena, 3L * s->fc.n);
  run->guess = NSDAE_ARENA_DOUBLES(arena, 3L * s->fc.n);
}

/* The largest impulse, in the units of the residual. */
static double largest(const nsdae_fc_run *run)
{
  const nsdae_fc_items *items = &run->island.fc.items;
  double most = 0;
  for (int i = 0; i < 3 * run->island.fc.n; i++)
    most = fmax(most, items->weight[i / 3] * items->rho[i / 3] * fabs(run->iterate.r[i]));
  return most;
}

/* Whether the residual is what rounding r to doubles leaves: half a unit in the last place of the
 * largest impulse moves the velocities by as much, and others may make up for half of that. Of
 * several items there may be smaller impulses that do the same, which are looked for. */
static int at_rounding_level(const nsdae_fc_run *run)
{
  double small = run->island.fc.n > 1 ? 1e-12 : INFINITY;
  return run->iterate.residual <= fmin(DBL_EPSILON / 4 * largest(run), small);
}

/* The residual is of scaled data, rounded: of large impulses it is not that of the data as given.
 */
static int doubtful(const nsdae_fc_run *run)
{
  return DOUBT * DBL_EPSILON * largest(run) > run->options->tol - run->budget.tol;
}

static int solved(const nsdae_fc_run *run)
{
  return run->iterate.residual <= run->budget.tol;
}

/* Conditions of the table. */

static int always(const nsdae_fc_run *run)
{
  (void)run;
  return 1;
}

/* Every contact opens. */
static int opens(const nsdae_fc_run *run)
{
  const nsdae_fc_scaled *c = &run->island.fc;
  for (int k = 0; k < c->n; k++) {
    double gap = c->items.q[3 * k];
    if (!(gap >= 0) || (c->items.kind[k] == NSDAE_FC_BILATERAL && gap != 0)) return 0;
  }
  return 1;
}

static int guessed(const nsdae_fc_run *run)
{
  for (int k = 0; k < 3 * run->island.fc.n; k++)
    if (run->iterate.r[k] != 0) return 1;
  return 0;
}

static int guessed_small(const nsdae_fc_run *run)
{
  return run->island.fc.n <= SMALL && guessed(run);
}

/* Tolerances that sweeps are likely to reach. To others they only find which contacts are open,
 * stick and slide: Newton's method then converges to rounding, so that bodies at rest have no
 * velocity.
 */
static int rough(const nsdae_fc_run *run)
{
  return run->options->tol >= NEARLY;
}

static int fine(const nsdae_fc_run *run)
{
  return !rough(run);
}

static int guessed_rough(const nsdae_fc_run *run)
{
  return rough(run) && guessed(run);
}

static int guessed_fine(const nsdae_fc_run *run)
{
  return fine(run) && guessed(run);
}

static int polyhedral(const nsdae_fc_run *run)
{
  return run->island.as_lcp.m > 0;
}

static int large_hyperstatic(const nsdae_fc_run *run)
{
  return run->island.fc.n >= LARGE && !run->island.fc.local && run->first > HYPERSTATIC;
}

static int rough_sliding(const nsdae_fc_run *run)
{
  return rough(run) && run->island.fc.n > SMALL && run->first <= HYPERSTATIC;
}

/* Not again from where it did not help. */
static int nearly_solved(const nsdae_fc_run *run)
{
  return run->iterate.residual <= NEARLY && run->iterate.residual < 0.5 * run->refined &&
         (!solved(run) || doubtful(run));
}

/* Of one contact a sweep is what the one before was, and its convex problems are it. */
static int several(const nsdae_fc_run *run)
{
  return run->island.fc.n > 1;
}

/* The one place that knows the order. A budget of 1 and more is in products, else it is a share of
 * that of the run. Rows from FIRST_OF_ROUND on are repeated. */
typedef struct row {
  int bit;
  nsdae_fc_solve *solve;
  int (*when)(const nsdae_fc_run *);
  double budget;
} row;

static const row table[] = {
    {NSDAE_FRICTION_TRIVIAL, nsdae_fc_trivial, opens, 10},
    {NSDAE_FRICTION_WARM, nsdae_fc_semismooth_newton, guessed_small, 1.0 / 8},
    {NSDAE_FRICTION_WARM, nsdae_fc_nsgs, guessed_rough, 2400},
    {NSDAE_FRICTION_WARM, nsdae_fc_nsgs, guessed_fine, 60},
    {NSDAE_FRICTION_WARM, nsdae_fc_semismooth_newton, guessed, 1.0 / 8},
    {NSDAE_FRICTION_AS_LCP, nsdae_fc_lcp, polyhedral, 1.0 / 8},
    {NSDAE_FRICTION_NSGS, nsdae_fc_nsgs_plain, rough, 200},
    {NSDAE_FRICTION_NSGS, nsdae_fc_nsgs, fine, 60},
    {NSDAE_FRICTION_ACLM, nsdae_fc_aclm, large_hyperstatic, 1.0 / 4},
    {NSDAE_FRICTION_NSGS, nsdae_fc_nsgs, rough_sliding, 1.0 / 4},
    {NSDAE_FRICTION_NSGS, nsdae_fc_nsgs_plain, rough_sliding, 1.0 / 8},
    {NSDAE_FRICTION_SMOOTHING_HOMOTOPY, nsdae_fc_smoothing_homotopy, always, 1.0 / 8},
    {NSDAE_FRICTION_FARKAS, nsdae_fc_infeasible, always, 1.0 / 8},
    {NSDAE_FRICTION_ITERATIVE_REFINEMENT, nsdae_fc_refine, nearly_solved, 1.0 / 8},
    {NSDAE_FRICTION_NSGS, nsdae_fc_nsgs, several, 1.0 / 128},
    {NSDAE_FRICTION_NSGS, nsdae_fc_nsgs_plain, several, 1.0 / 128},
    {NSDAE_FRICTION_SEMISMOOTH_NEWTON, nsdae_fc_semismooth_newton, always, 1.0 / 64},
    {NSDAE_FRICTION_SOCP_INTERIOR_POINT, nsdae_fc_socp_interior_point, several, 1.0 / 64},
    {NSDAE_FRICTION_ACLM, nsdae_fc_aclm, several, 1.0 / 64},
    {NSDAE_FRICTION_SMOOTHING_HOMOTOPY, nsdae_fc_smoothing_homotopy, always, 1.0 / 64},
};
enum { STAGES = sizeof table / sizeof *table, FIRST_OF_ROUND = 13 };

/* How a solver ended the last time: at what residual it began, and if the budget ended it. */
typedef struct ended {
  double began;
  int limited;
} ended;

/* The first row of the same solver. */
static int same_solver(int i)
{
  int k = 0;
  while (table[k].solve != table[i].solve) k++;
  return k;
}

/* A solver that ended before its budget did is of no use again, unless it begins elsewhere. */
static int in_vain(const nsdae_fc_run *run, int i, const ended *last)
{
  const int elsewhere =
      table[i].solve == nsdae_fc_smoothing_homotopy || run->iterate.residual != last->began;
  return !last->limited && !elsewhere;
}

/* Nothing is left to be done but in double-double arithmetic. */
static int done(const nsdae_fc_run *run)
{
  return solved(run) || at_rounding_level(run);
}

/* Where the guess led is put aside if that is no solution: what follows begins as without one, so
 * that no guess is worse than none. */
static void put_guess_aside(nsdae_fc_run *run)
{
  memcpy(run->guess, run->iterate.r, nsdae_fc_bytes(&run->island));
  run->guessed = run->iterate.residual;
  run->has_guess = 0;
  run->iterate.residual = INFINITY;
  memset(run->iterate.r, 0, nsdae_fc_bytes(&run->island));
}

/* One row; what its solver returns. */
static int run_row(nsdae_fc_run *run, const row *at, double growth, ended *last)
{
  nsdae_fc_budget budget = run->budget;
  const double more = at->budget < 1 ? at->budget * budget.products : at->budget;
  const double before = run->iterate.residual;
  budget.products = fmin(budget.products, run->iterate.work.products + growth * more);
  run->stage = at->bit;
  if (budget.watch && budget.watch(&run->iterate, run) != 0) {
    run->iterate.work.interrupted = 1;
    return NSDAE_FC_UNSOLVED;
  }
  int result = at->solve(&run->island, &run->iterate, &budget);
  *last = (ended){before, run->iterate.work.products >= budget.products};
  if (run->iterate.residual < before && !(before <= run->budget.tol)) run->info.stage = at->bit;
  if (at->solve == nsdae_fc_refine) run->refined = before;
  if (at->bit == NSDAE_FRICTION_NSGS && run->first == INFINITY) run->first = run->iterate.residual;
  return result;
}

/* Rows from i to before to, once. Returns whether the run is over. */
static int run_rows(nsdae_fc_run *run, int i, int to, double growth, ended *last)
{
  for (; i < to; i++) {
    const row *at = &table[i];
    ended *before = &last[same_solver(i)];
    if (at->bit > NSDAE_FRICTION_WARM && run->has_guess && !done(run)) put_guess_aside(run);
    if (!(run->options->stages & at->bit) || !at->when(run) || in_vain(run, i, before)) continue;
    if (done(run) && at->solve != nsdae_fc_refine) continue;
    int result = run_row(run, at, growth, before);
    run->lost |= result == NSDAE_FC_NO_MEMORY;
    if (result == NSDAE_FC_INFEASIBLE) run->info.outcome = NSDAE_OUTCOME_INFEASIBLE;
    if (result == NSDAE_FC_INFEASIBLE || run->iterate.work.interrupted) return 1;
  }
  return run->iterate.work.products >= run->budget.products;
}

/* The caller's view of a run. */
static int watch(const nsdae_fc_iterate *it, void *user)
{
  const nsdae_fc_run *run = user;
  const nsdae_friction_progress now = {.stage = run->stage,
                                       .island = run->island.fc.label,
                                       .islands = run->islands,
                                       .contacts = run->island.fc.n,
                                       .residual = fmin(it->residual, run->guessed),
                                       .share = it->work.products / run->budget.products,
                                       .sweeps = it->work.sweeps,
                                       .iterations = it->work.steps};
  return run->options->progress(&now, run->options->user);
}

static void begin(nsdae_fc_run *run)
{
  const nsdae_friction_options *o = run->options;
  const double n = run->island.fc.n, own = fmin(WORK / n, EACH * n);
  nsdae_fc_iterate *it = &run->iterate;
  run->info = (nsdae_friction_info){.residual = INFINITY};
  run->budget.products = o->budget > 0 ? o->budget : own;
  run->budget.sweeps = o->max_sweeps > 0 ? o->max_sweeps : LONG_MAX;
  run->budget.steps = o->max_iterations > 0 ? o->max_iterations : INT_MAX;
  run->budget.watch = o->progress ? watch : NULL;
  run->budget.user = run;
  run->island.lost_paths = 0;
  run->guessed = run->first = run->refined = INFINITY;
  run->lost = 0;
  memcpy(it->r, run->island.fc.r, nsdae_fc_bytes(&run->island));
  memset(it->low, 0, nsdae_fc_bytes(&run->island));
  it->residual = INFINITY;
  run->has_guess = guessed(run);
  if (!(o->stages & NSDAE_FRICTION_WARM)) put_guess_aside(run);
  it->work = (nsdae_fc_work){0};
}

/* The better of where the guess led and of the best point without it. */
static void choose(nsdae_fc_run *run)
{
  nsdae_fc_iterate *it = &run->iterate;
  if (it->residual == INFINITY) {
    nsdae_fc_go_to(&run->island, it->r);
    nsdae_fc_offer(&run->island, it);
  }
  if (!(run->guessed < it->residual)) return;
  memcpy(it->r, run->guess, nsdae_fc_bytes(&run->island));
  memset(it->low, 0, nsdae_fc_bytes(&run->island));
  it->residual = run->guessed;
  run->info.stage = NSDAE_FRICTION_WARM;
}

/* options.refine: the solution better still, and inside the cones to the last bit, whose nearest
 * point is no further away than the residual. */
static void polish(nsdae_fc_run *run)
{
  nsdae_fc_island *s = &run->island;
  nsdae_fc_scaled *c = &s->fc;
  nsdae_fc_iterate *it = &run->iterate;
  nsdae_fc_budget budget = run->budget;
  for (int i = 0; i < 3 * c->n; i++)
    if (it->low[i] != 0) return;
  if (!nsdae_fc_system_ready(s)) return;
  budget.products = INFINITY;
  nsdae_fc_polish(s, it, &budget, run->options->refine);
  memcpy(c->r, it->r, nsdae_fc_bytes(s));
  for (int k = 0; k < c->n; k++)
    if (c->items.kind[k] != NSDAE_FC_BILATERAL) nsdae_fc_project(c->items.mu[k], c->r + 3 * k);
  nsdae_fc_go_to(s, c->r);
  double residual = nsdae_fc_residual(c, c->r, c->u);
  if (!(residual <= run->budget.tol)) return;
  it->residual = residual;
  memcpy(it->r, c->r, nsdae_fc_bytes(s));
}

/* What a run without an answer returns. */
static int failure(const nsdae_fc_run *run)
{
  if (run->iterate.work.interrupted) return NSDAE_E_INTERRUPTED;
  return run->lost && !solved(run) ? NSDAE_E_MEMORY : NSDAE_OK;
}

int nsdae_fc_run_stages(nsdae_fc_run *run)
{
  ended last[STAGES];
  double before = -1, growth = 1;
  for (int i = 0; i < STAGES; i++) last[i] = (ended){NAN, 1};
  begin(run);
  int over = run_rows(run, 0, FIRST_OF_ROUND, 1, last);
  for (; !over && run->iterate.work.products > before; growth *= GROWTH) {
    before = run->iterate.work.products;
    over = run_rows(run, FIRST_OF_ROUND, STAGES, growth, last);
  }
  if (run->info.outcome == NSDAE_OUTCOME_INFEASIBLE) {
    run->info.proof = NSDAE_PROOF_FARKAS;
    return NSDAE_OK;
  }
  choose(run);
  if (solved(run) && run->options->refine > 0) polish(run);
  run->info.outcome = solved(run) ? NSDAE_OUTCOME_SOLVED : NSDAE_OUTCOME_UNSOLVED;
  run->info.residual = run->iterate.residual;
  run->info.sweeps = run->iterate.work.sweeps;
  run->info.iterations = run->info.factorisations = run->iterate.work.steps;
  return failure(run);
}
