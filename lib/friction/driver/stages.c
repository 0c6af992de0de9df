/* An island is solved by the rows of one table: each is a solver, with a condition and a budget.
 * After the first rows come rounds of solvers that improve the iterate, with growing budgets. */
#include "stages.h"

#include <float.h>
#include <limits.h>
#include <math.h>
#include <string.h>

#include "cone.h"
#include "friction_solver.h"

/* Contacts up to which a factorisation costs less than the sweeps that it saves. */
enum { SMALL = 24 };

/* Contacts from which the interior point precedes the homotopy, whose paths are lost more often the
 * longer they are. */
enum { LARGE = 3000 };

/* A larger residual after the first sweeps: sweeps do not carry weights to the ground. Of seeded
 * walls, towers and storeys at rest three quarters keep 0.07 and more, of those that are hit half
 * less than 0.04. */
static const double HYPERSTATIC = 5e-2;

/* Sweeps alone are likely to reach it; from here on iterative refinement converges. With 1e-5, 1e-6
 * and 1e-7 39 of 40 seeded problems are solved to 1e-8. */
static const double NEARLY = 1e-6;

/* Roundings of the scaled data that add up in a velocity. With 4, 8 and 16 39 of the 40 are solved.
 */
static const double DOUBT = 8;

/* Default budget, products times items: a product takes 0.024 to 0.047 us an item, and an unsolved
 * problem ends after 6 to 47 s. EACH: products for each item of an island, so that one of 50
 * contacts ends within two seconds. */
static const double WORK = 1e9, EACH = 2e4;

/* Each round of the solvers that improve an iterate may take GROWTH times as much as the one
 * before: what a shorter round cost again is at most a third. With 2, 4 and 8 39 of the 40 are
 * solved. */
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
  nsdae_arena_doubles(
      arena, 3L * s->fc.n,
      (double **[]){&s->point, &run->iterate.r, &run->iterate.low, &run->guess, NULL});
}

/* ---- conditions of the rows */

/* The largest impulse, in the units of the residual. */
static double largest(const nsdae_fc_run *run)
{
  const nsdae_fc_items *items = &run->island.fc.items;
  double most = 0;
  for (int i = 0; i < 3 * run->island.fc.n; i++)
    most = fmax(most, items->weight[i / 3] * items->rho[i / 3] * fabs(run->iterate.r[i]));
  return most;
}

static int solved(const nsdae_fc_run *run)
{
  return run->iterate.residual <= run->budget.tol;
}

/* Conditions of the table; all those of a row must be true. */
enum {
  OPENS = 1,        /* every contact opens: r = 0 is a solution */
  GUESSED = 2,      /* the iterate is not zero */
  FEW = 4,          /* at most SMALL items */
  MORE = 8,         /* more than that */
  SEVERAL = 16,     /* more than one item: else all sweeps and convex problems are alike */
  ROUGH = 32,       /* sweeps are likely to reach the tolerance */
  FINE = 64,        /* they are not: they find the states of contacts for Newton's method */
  POLYHEDRAL = 128, /* a small linear complementarity problem */
  LOADED = 256,     /* hyperstatic: sweeps do not carry weights to the ground */
  SLIDING = 512,    /* not hyperstatic */
  HUGE_PILE = 1024, /* LARGE contacts and more, in the global form */
  REFINABLE = 2048  /* near a solution, and nearer than at the last refinement */
};

static int opens(const nsdae_fc_scaled *c)
{
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

/* If it is solved, the rounding of scaled data may decide: of large impulses the residual is not
 * that of the data as given. */
static int refinable(const nsdae_fc_run *run)
{
  return run->iterate.residual <= NEARLY && run->iterate.residual < 0.5 * run->refined &&
         (!solved(run) || DOUBT * DBL_EPSILON * largest(run) > run->options->tol - run->budget.tol);
}

static int applies(nsdae_fc_run *run, int when)
{
  const nsdae_fc_scaled *c = &run->island.fc;
  return !((when & OPENS && !opens(c)) || (when & GUESSED && !guessed(run)) ||
           (when & FEW && c->n > SMALL) || (when & MORE && c->n <= SMALL) ||
           (when & SEVERAL && c->n == 1) || (when & ROUGH && run->options->tol < NEARLY) ||
           (when & FINE && run->options->tol >= NEARLY) ||
           (when & POLYHEDRAL && run->island.as_lcp.m == 0) ||
           (when & LOADED && run->first <= HYPERSTATIC) ||
           (when & SLIDING && run->first > HYPERSTATIC) ||
           (when & HUGE_PILE && (c->n < LARGE || c->local)) ||
           (when & REFINABLE && !refinable(run)));
}

/* The one place that knows the order. A budget of 1 and more is in products, else it is a share of
 * that of the run. Rows from FIRST_OF_ROUND on are repeated. Of 31 warm starts of
 * sliding heaps and walls, most of them hard, 3000 sweeps solve 23; on walls Newton's method after
 * 1200 sweeps takes three times as long. Bodies that are placed at rest take the homotopy 9 to 15
 * steps. */
typedef struct row {
  int bit;
  nsdae_fc_solve *solve;
  int when;
  double budget;
} row;

static const row table[] = {
    {NSDAE_FRICTION_TRIVIAL, nsdae_fc_trivial, OPENS, 10},
    {NSDAE_FRICTION_WARM, nsdae_fc_semismooth_newton, GUESSED | FEW, 1.0 / 8},
    {NSDAE_FRICTION_WARM, nsdae_fc_nsgs, GUESSED | ROUGH, 8000},
    {NSDAE_FRICTION_WARM, nsdae_fc_nsgs, GUESSED | FINE, 60},
    {NSDAE_FRICTION_WARM, nsdae_fc_semismooth_newton, GUESSED, 1.0 / 8},
    {NSDAE_FRICTION_AS_LCP, nsdae_fc_lcp, POLYHEDRAL, 1.0 / 8},
    {NSDAE_FRICTION_SMOOTHING_HOMOTOPY, nsdae_fc_smoothing_homotopy, ROUGH | MORE, 500},
    {NSDAE_FRICTION_NSGS, nsdae_fc_nsgs_plain, ROUGH, 200},
    {NSDAE_FRICTION_NSGS, nsdae_fc_nsgs, FINE, 60},
    {NSDAE_FRICTION_ACLM, nsdae_fc_aclm, HUGE_PILE | LOADED, 1.0 / 4},
    {NSDAE_FRICTION_NSGS, nsdae_fc_nsgs, ROUGH | MORE | SLIDING, 1.0 / 4},
    {NSDAE_FRICTION_NSGS, nsdae_fc_nsgs_plain, ROUGH | MORE | SLIDING, 1.0 / 8},
    {NSDAE_FRICTION_SMOOTHING_HOMOTOPY, nsdae_fc_smoothing_homotopy, 0, 1.0 / 8},
    {NSDAE_FRICTION_FARKAS, nsdae_fc_infeasible, 0, 1.0 / 8},
    {NSDAE_FRICTION_ITERATIVE_REFINEMENT, nsdae_fc_refine, REFINABLE, 1.0 / 8},
    {NSDAE_FRICTION_NSGS, nsdae_fc_nsgs, SEVERAL, 1.0 / 128},
    {NSDAE_FRICTION_NSGS, nsdae_fc_nsgs_plain, SEVERAL, 1.0 / 128},
    {NSDAE_FRICTION_SEMISMOOTH_NEWTON, nsdae_fc_semismooth_newton, 0, 1.0 / 64},
    {NSDAE_FRICTION_SOCP_INTERIOR_POINT, nsdae_fc_socp_interior_point, SEVERAL, 1.0 / 64},
    {NSDAE_FRICTION_ACLM, nsdae_fc_aclm, SEVERAL, 1.0 / 64},
    {NSDAE_FRICTION_SMOOTHING_HOMOTOPY, nsdae_fc_smoothing_homotopy, 0, 1.0 / 64},
};
enum { STAGES = sizeof table / sizeof *table, FIRST_OF_ROUND = 14 };

/* How a solver ended the last time: at what residual it began, and if the budget ended it. */
typedef struct ended {
  double began;
  int limited;
} ended;

/* ---- one row */

/* Whether only double-double arithmetic can reduce the residual further: it is solved, or at
 * rounding level. Half a unit in the last place of the largest impulse changes velocities by as
 * much, half of which other impulses may compensate. Several items may have a solution with smaller
 * impulses, so that their bound is 1e-12 too. */
static int done(const nsdae_fc_run *run)
{
  double small = run->island.fc.n > 1 ? 1e-12 : INFINITY;
  return solved(run) || run->iterate.residual <= fmin(DBL_EPSILON / 4 * largest(run), small);
}

/* A guess that leads to no solution is put aside: the solvers that follow begin at r = 0, so that
 * no guess is worse than none. */
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
    int first = 0; /* the first row of the same solver */
    while (table[first].solve != at->solve) first++;
    ended *before = &last[first];
    if (at->bit > NSDAE_FRICTION_WARM && run->has_guess && !done(run)) put_guess_aside(run);
    /* A solver that ended before its budget did is of no use again from the same point. The
     * homotopy always begins at r = 0, more closely each time. */
    int in_vain = !before->limited && at->solve != nsdae_fc_smoothing_homotopy &&
                  run->iterate.residual == before->began;
    if (!(run->options->stages & at->bit) || in_vain) continue;
    if (done(run) && at->solve != nsdae_fc_refine) continue;
    if (!applies(run, at->when)) continue;
    int result = run_row(run, at, growth, before);
    run->lost |= result == NSDAE_FC_NO_MEMORY;
    if (result == NSDAE_FC_INFEASIBLE) run->info.outcome = NSDAE_OUTCOME_INFEASIBLE;
    if (result == NSDAE_FC_INFEASIBLE || run->iterate.work.interrupted) return 1;
  }
  return run->iterate.work.products >= run->budget.products;
}

/* ---- a run */

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

double nsdae_fc_own_budget(int items)
{
  const double n = items > 0 ? items : 1;
  return fmin(WORK / n, EACH * n);
}

/* Budget, no work yet, residual infinite; a guess that is not allowed is put aside. */
static void begin_run(nsdae_fc_run *run)
{
  const nsdae_friction_options *o = run->options;
  nsdae_fc_iterate *it = &run->iterate;
  run->info = (nsdae_friction_info){.residual = INFINITY};
  run->budget.products = o->budget > 0 ? o->budget : nsdae_fc_own_budget(run->island.fc.n);
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

/* options.refine: Newton steps from the solution on, then the projection into the cones, which
 * moves it by no more than its residual. */
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
  nsdae_fc_set_point(s, c->r);
  double residual = nsdae_fc_residual(c, c->r, c->u);
  if (!(residual <= run->budget.tol)) return;
  it->residual = residual;
  memcpy(it->r, c->r, nsdae_fc_bytes(s));
}

int nsdae_fc_run_stages(nsdae_fc_run *run)
{
  ended last[STAGES];
  double before = -1, growth = 1;
  for (int i = 0; i < STAGES; i++) last[i] = (ended){NAN, 1};
  begin_run(run);
  int over = run_rows(run, 0, FIRST_OF_ROUND, 1, last);
  for (; !over && run->iterate.work.products > before; growth *= GROWTH) {
    before = run->iterate.work.products;
    over = run_rows(run, FIRST_OF_ROUND, STAGES, growth, last);
  }
  if (run->info.outcome == NSDAE_OUTCOME_INFEASIBLE) {
    run->info.proof = NSDAE_PROOF_FARKAS;
    return NSDAE_OK;
  }
  /* The better one of the best points with and without the guess. */
  nsdae_fc_iterate *it = &run->iterate;
  if (it->residual == INFINITY) {
    nsdae_fc_set_point(&run->island, it->r);
    nsdae_fc_offer(&run->island, it);
  }
  if (run->guessed < it->residual) {
    memcpy(it->r, run->guess, nsdae_fc_bytes(&run->island));
    memset(it->low, 0, nsdae_fc_bytes(&run->island));
    it->residual = run->guessed;
    run->info.stage = NSDAE_FRICTION_WARM;
  }
  if (solved(run) && run->options->refine > 0) polish(run);
  run->info.outcome = solved(run) ? NSDAE_OUTCOME_SOLVED : NSDAE_OUTCOME_UNSOLVED;
  run->info.residual = run->iterate.residual;
  run->info.sweeps = run->iterate.work.sweeps;
  run->info.iterations = run->info.factorisations = run->iterate.work.steps;
  if (run->iterate.work.interrupted) return NSDAE_E_INTERRUPTED;
  return run->lost && !solved(run) ? NSDAE_E_MEMORY : NSDAE_OK;
}
