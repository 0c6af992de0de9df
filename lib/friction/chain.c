#include "chain.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include <nsdae/status.h>

#include "cone.h"
#include "conic.h"
#include "drift.h"
#include "further.h"
#include "sweep.h"

/* Sweeps between two looks at the residual; at the beginning; of a warm start, which is trapped
 * where so many have not halved the residual; accelerated ones. */
enum { BETWEEN = 20, FEW = 100, WARM = 2000, TRAPPED = 600, SOON = 20, MANY = 20000 };

/* Plain sweeps where nothing else gets further: so many items swept, ten seconds or so, and at most
 * so many sweeps; they end where half of them have not halved the residual. */
static const double SWEPT = 1.2e8;
enum { LONG = 30000 };

/* Values of J that an item has as a rule, those of two bodies. */
enum { VALUES = 36 };

/* Contacts up to which a factorisation costs less than the sweeps that it saves. */
enum { SMALL = 24 };

/* Newton steps of one attempt, of a contact by itself (one that has a solution takes 71 and fewer),
 * and between accelerated sweeps; proximal problems that may fail in the first of these; how many
 * accelerated sweeps see what they are good for; convex problems. */
enum { STEPS = 300, ALONE = 100, A_FEW = 20, FAILURES = 20 };
enum { STALLED = 300, ROUNDS = 6, SHIFTS = 3 };

/* Where FEW sweeps leave more, weights do not get to the ground by sweeps: walls, towers and arches
 * keep 0.06 and more, what slides 0.04 and less. */
static const double HYPERSTATIC = 5e-2;

/* Roundings of the scaled data that add up in a velocity. */
static const double DOUBT = 8;

void nsdae_fc_chain_layout(void *object, nsdae_arena *arena)
{
  nsdae_fc_chain *c = object;
  nsdae_fc_layout(&c->fc, arena);
  c->best = NSDAE_ARENA_DOUBLES(arena, 3L * c->fc.n);
  c->low = NSDAE_ARENA_DOUBLES(arena, 3L * c->fc.n);
  c->trap = NSDAE_ARENA_DOUBLES(arena, 3L * c->fc.n);
  c->slip = NSDAE_ARENA_DOUBLES(arena, c->fc.n);
  c->walked.point = NSDAE_ARENA_DOUBLES(arena, 3L * c->fc.n);
  c->walked.calm = NSDAE_ARENA_DOUBLES(arena, 3L * c->fc.n);
  c->walked.drift = NSDAE_ARENA_DOUBLES(arena, c->fc.n);
  nsdae_fc_anderson_layout(&c->anderson, &c->fc, arena);
  nsdae_fc_anderson_layout(&c->walked.shifts, &c->fc, arena);
  c->newton.fc = &c->fc;
  nsdae_fc_newton_layout(&c->newton, arena);
  nsdae_fc_interior_layout(&c->interior, &c->fc, arena);
  nsdae_fc_curve_layout(&c->curve, &c->fc, arena);
  nsdae_fc_precise_layout(&c->precise, &c->fc, arena);
  nsdae_fc_polyhedral_layout(&c->polyhedral, &c->fc, arena);
}

/* Keeps fc->r where it is better than all before; returns whether it is a solution. */
int nsdae_fc_judge(nsdae_fc_chain *c, int stage)
{
  nsdae_fc_velocities(&c->fc, c->fc.r, c->fc.y, c->fc.u);
  double residual = nsdae_fc_residual(&c->fc, c->fc.r, c->fc.u);
  if (!(residual < c->info.residual)) return 0;
  c->info.residual = residual;
  c->info.stage = stage;
  memcpy(c->best, c->fc.r, nsdae_fc_bytes(c));
  if (residual > c->tol) return 0;
  c->info.outcome = NSDAE_OUTCOME_SOLVED;
  return 1;
}

void nsdae_fc_start_cold(nsdae_fc_chain *c)
{
  memset(c->fc.r, 0, nsdae_fc_bytes(c));
  memset(c->slip, 0, (size_t)c->fc.n * sizeof *c->slip);
}

static int trivial(nsdae_fc_chain *c)
{
  for (int k = 0; k < c->fc.n; k++) {
    double gap = c->fc.items.q[3 * k];
    if (!(gap >= 0) || (c->fc.items.kind[k] == NSDAE_FC_BILATERAL && gap != 0)) return 0;
  }
  nsdae_fc_start_cold(c);
  return nsdae_fc_judge(c, NSDAE_FRICTION_TRIVIAL);
}

/* Sweeps from fc->r on, looked at after every BETWEEN. With patience > 0 they end where so many
 * have not halved the residual. */
int nsdae_fc_sweeps(nsdae_fc_chain *c, int most, int patience, int stage)
{
  double mark = INFINITY;
  int since = 0;
  if (c->options->max_sweeps > 0 && c->options->max_sweeps < most) most = c->options->max_sweeps;
  if (nsdae_fc_judge(c, stage)) return 1;
  for (int done = 0; done < most; done += BETWEEN) {
    nsdae_fc_sweep(&c->fc, BETWEEN, c->slip);
    c->info.sweeps += BETWEEN;
    if (nsdae_fc_judge(c, stage)) return 1;
    since += BETWEEN;
    if (c->info.residual <= 0.5 * mark) mark = c->info.residual, since = 0;
    if (patience > 0 && since >= patience) return 0;
  }
  return 0;
}

/* Sweeps by Anderson's method from fc->r on, judged where they seem to have got there, and now and
 * then; they end where so many have not halved what a sweep changes, or one changes nothing. From a
 * guess drift is most of what is left, and is taken at a stride. */
static int accelerated(nsdae_fc_chain *c, int most, int patience, int stage)
{
  const int strides = stage == NSDAE_FRICTION_WARM && c->tol >= NSDAE_FC_ROUGH;
  double mark = INFINITY;
  int since = 0, judged = 0, seen = 0;
  if (c->options->max_sweeps > 0 && c->options->max_sweeps < most) most = c->options->max_sweeps;
  nsdae_fc_anderson_begin(&c->anderson);
  for (int done = 1; done <= most && since < patience; done++, since++) {
    double change = nsdae_fc_anderson_sweep(&c->anderson, &c->fc, c->slip);
    c->info.sweeps++;
    if (nsdae_fc_sweep_arrived(&c->fc, c->tol, &seen) || done - judged >= FEW) {
      if (nsdae_fc_judge(c, stage)) return 1;
      judged = done;
    }
    if (!(change > 0)) break;
    if (change <= 0.5 * mark) mark = change, since = 0;
    if (done == most || since >= patience - 1) continue;
    nsdae_fc_anderson_extrapolate(&c->anderson, &c->fc);
    if (strides) nsdae_fc_drift(&c->anderson, &c->fc);
  }
  return nsdae_fc_judge(c, stage);
}

/* Whether there are factorisations for this island. */
int nsdae_fc_ready(nsdae_fc_chain *c)
{
  if (c->seen.analysed == 0)
    c->seen.analysed = nsdae_fc_matrix_analyse(c->kept.matrix, &c->fc) == NSDAE_OK ? 1 : -1;
  c->newton.matrix = c->kept.matrix;
  c->newton.steps = 0;
  c->newton.most = c->fc.n > 1 ? STEPS : ALONE;
  if (c->options->max_iterations > 0) c->newton.most = c->options->max_iterations;
  c->newton.failures = FAILURES;
  c->seen.lost |= c->seen.analysed < 0;
  return c->seen.analysed == 1;
}

int nsdae_fc_count(nsdae_fc_chain *c, int stage)
{
  c->info.iterations += c->newton.steps;
  c->seen.spent += c->newton.steps;
  c->info.factorisations += c->newton.steps;
  return nsdae_fc_judge(c, stage);
}

/* From the best point so far, at most so many steps, as long as none of its problems fails; 0: as
 * many as one attempt has. */
int nsdae_fc_try_proximal(nsdae_fc_chain *c, double alpha, int most, int stage)
{
  if (!nsdae_fc_ready(c)) return 0;
  if (most > 0) c->newton.failures = 0;
  if (most > 0 && most < c->newton.most) c->newton.most = most;
  memcpy(c->fc.r, c->best, nsdae_fc_bytes(c));
  nsdae_fc_proximal(&c->newton, alpha, c->tol);
  return nsdae_fc_count(c, stage);
}

/* What a sweep costs, in items of two bodies: of a local form it grows with the square of n. */
double nsdae_fc_work(const nsdae_fc_chain *c)
{
  return fmax(c->fc.n, (double)c->fc.parts.values / VALUES);
}

/* Sweeps and Newton's method in turn. Sweeps bring most contacts to rest and drift where few of
 * them are locked: r grows along what hardly moves u, by as much in each sweep, until one opens.
 * Newton's method takes that way in a step, but finds it only where little else changes. Where it
 * does not, much slides, and extrapolated sweeps go astray as well: plain ones get further. */
static int alternate(nsdae_fc_chain *c, int stage)
{
  for (int k = 0; k < ROUNDS; k++) {
    memcpy(c->fc.r, c->best, nsdae_fc_bytes(c));
    nsdae_fc_velocities(&c->fc, c->fc.r, c->fc.y, c->fc.u);
    if (accelerated(c, MANY, STALLED, stage)) return 1;
    double before = c->info.residual;
    if (nsdae_fc_try_proximal(c, 1e-4, A_FEW, stage)) return 1;
    if (!(c->info.residual < before)) break;
  }
  memcpy(c->fc.r, c->best, nsdae_fc_bytes(c));
  nsdae_fc_sweep_begin(&c->fc);
  int most = (int)fmin(LONG, SWEPT / nsdae_fc_work(c));
  return nsdae_fc_sweeps(c, most, most / 2, stage);
}

/* Along the path, cold, and from its end on. */
int nsdae_fc_try_path(nsdae_fc_chain *c, double loose, int stage)
{
  if (!nsdae_fc_ready(c)) return 0;
  nsdae_fc_start_cold(c);
  c->newton.mark_at = 0;
  c->newton.mark_epsilon = 0;
  double residual = nsdae_fc_path(&c->newton, loose, c->tol);
  int lost = c->tol >= NSDAE_FC_ROUGH && residual > 1e-2; /* sweeps get there sooner */
  if (!(residual <= c->tol) && !lost) nsdae_fc_proximal(&c->newton, 1e-8, c->tol);
  return nsdae_fc_count(c, stage);
}

/* Sweeps from fc->r on, the guess, whose y is current; it is looked at where they fail. */
static int sweep_guess(nsdae_fc_chain *c)
{
  memcpy(c->trap, c->fc.r, nsdae_fc_bytes(c));
  if (accelerated(c, WARM, c->tol < NSDAE_FC_ROUGH ? SOON : TRAPPED, NSDAE_FRICTION_WARM)) return 1;
  memcpy(c->fc.r, c->trap, nsdae_fc_bytes(c));
  return nsdae_fc_judge(c, NSDAE_FRICTION_WARM);
}

/* The impulses of the step before are near; where sweeps are trapped, Newton may not be. */
static int from_guess(nsdae_fc_chain *c)
{
  int seen = 0;
  memset(c->slip, 0, (size_t)c->fc.n * sizeof *c->slip);
  nsdae_fc_sweep_begin(&c->fc);
  int look = c->fc.n <= SMALL || nsdae_fc_sweep_arrived(&c->fc, c->tol, &seen);
  if (look && nsdae_fc_judge(c, NSDAE_FRICTION_WARM)) return 1;
  if (c->fc.n <= SMALL) {
    if (nsdae_fc_try_proximal(c, 1e-5, 0, NSDAE_FRICTION_WARM)) return 1;
    memcpy(c->fc.r, c->best, nsdae_fc_bytes(c));
    nsdae_fc_sweep_begin(&c->fc);
  }
  return sweep_guess(c) || nsdae_fc_try_proximal(c, 1e-5, 0, NSDAE_FRICTION_WARM);
}

/* The largest impulse, as the residual sees it. */
static double largest(const nsdae_fc_chain *c)
{
  double most = 0;
  for (int i = 0; i < 3 * c->fc.n; i++)
    most = fmax(most, c->fc.items.weight[i / 3] * c->fc.items.rho[i / 3] * fabs(c->best[i]));
  return most;
}

/* Whether the residual is what rounding r to doubles leaves: half a unit in the last place of the
 * largest impulse moves the velocities by as much, and others may make up for half of that. Of
 * several items there may be smaller impulses that do the same, which are looked for. */
int nsdae_fc_exhausted(const nsdae_fc_chain *c)
{
  double small = c->fc.n > 1 ? 1e-12 : INFINITY;
  return c->info.residual <= fmin(DBL_EPSILON / 4 * largest(c), small);
}

/* A guess that leads nowhere is put aside: what comes next begins as if there had been none, and so
 * no start is worse than a cold one. */
static int warm(nsdae_fc_chain *c)
{
  double most = 0;
  for (int k = 0; k < 3 * c->fc.n; k++) most = fmax(most, fabs(c->fc.r[k]));
  if (!(most > 0)) return 0;
  if (from_guess(c)) return 1;
  if (nsdae_fc_exhausted(c)) return 0;
  memcpy(c->trap, c->best, nsdae_fc_bytes(c));
  c->seen.trapped = c->info.residual;
  memset(c->best, 0, nsdae_fc_bytes(c));
  c->info.residual = INFINITY;
  return 0;
}

/* Where nothing was found, the better of the two ends. */
static void look_back(nsdae_fc_chain *c)
{
  if (c->info.outcome != NSDAE_OUTCOME_UNSOLVED || !(c->seen.trapped < c->info.residual)) return;
  memcpy(c->best, c->trap, nsdae_fc_bytes(c));
  c->info.residual = c->seen.trapped;
  c->info.stage = NSDAE_FRICTION_WARM;
}

/* Exact where it applies, and few unknowns: what iterates would take longer. */
static int pivoting(nsdae_fc_chain *c)
{
  return nsdae_fc_polyhedral_solve(&c->polyhedral, &c->fc, c->tol, c->newton.y) &&
         nsdae_fc_judge(c, NSDAE_FRICTION_PIVOTING);
}

static int gauss_seidel(nsdae_fc_chain *c)
{
  nsdae_fc_start_cold(c);
  if (nsdae_fc_sweeps(c, FEW, 0, NSDAE_FRICTION_GAUSS_SEIDEL)) return 1;
  c->seen.slides = c->info.residual <= HYPERSTATIC;
  int likely = c->tol >= NSDAE_FC_ROUGH && c->fc.n > SMALL && c->seen.slides;
  return likely && alternate(c, NSDAE_FRICTION_GAUSS_SEIDEL);
}

static int smoothing(nsdae_fc_chain *c)
{
  if (nsdae_fc_try_path(c, 1e-3, NSDAE_FRICTION_SMOOTHING)) return 1;
  nsdae_fc_start_cold(c);
  return nsdae_fc_conic(c, NSDAE_FC_QUICKLY, SHIFTS, INFINITY, NSDAE_FRICTION_SMOOTHING);
}

/* Before all that takes long. */
static int prove(nsdae_fc_chain *c)
{
  int found = nsdae_fc_prove(c->kept.proof, &c->fc, c->l);
  c->seen.lost |= found == NSDAE_FC_NO_MEMORY;
  if (found != NSDAE_FC_PROVED) return 0;
  c->info.outcome = NSDAE_OUTCOME_INFEASIBLE;
  c->info.proof = NSDAE_PROOF_FARKAS;
  c->info.stage = NSDAE_FRICTION_PROVE;
  return 1;
}

/* The solution better still, where that was asked for, and inside the cones to the last bit: their
 * nearest point is no further away than the residual. One in two parts is as good as it gets. */
static void refine(nsdae_fc_chain *c)
{
  nsdae_fc *fc = &c->fc;
  if (c->options->refine == 0 || c->info.outcome != NSDAE_OUTCOME_SOLVED || c->seen.held) return;
  if (!nsdae_fc_ready(c)) return;
  memcpy(fc->r, c->best, nsdae_fc_bytes(c));
  nsdae_fc_refine(&c->newton, c->options->refine);
  nsdae_fc_count(c, c->info.stage);
  memcpy(fc->r, c->best, nsdae_fc_bytes(c));
  for (int k = 0; k < fc->n; k++)
    if (fc->items.kind[k] != NSDAE_FC_BILATERAL) nsdae_fc_project(fc->items.mu[k], fc->r + 3 * k);
  nsdae_fc_velocities(fc, fc->r, fc->y, fc->u);
  double residual = nsdae_fc_residual(fc, fc->r, fc->u);
  if (!(residual <= c->tol)) return;
  c->info.residual = residual;
  memcpy(c->best, fc->r, nsdae_fc_bytes(c));
}

static void run_stages(nsdae_fc_chain *c)
{
  static const struct {
    int stage;
    int (*run)(nsdae_fc_chain *);
  } all[] = {{NSDAE_FRICTION_TRIVIAL, trivial},         {NSDAE_FRICTION_WARM, warm},
             {NSDAE_FRICTION_PIVOTING, pivoting},       {NSDAE_FRICTION_GAUSS_SEIDEL, gauss_seidel},
             {NSDAE_FRICTION_SMOOTHING, smoothing},     {NSDAE_FRICTION_PROVE, prove},
             {NSDAE_FRICTION_FURTHER, nsdae_fc_further}};
  c->info = (nsdae_friction_info){.residual = INFINITY};
  c->seen.trapped = c->seen.looked = c->seen.crept = INFINITY;
  c->seen.spent = c->seen.creeping = c->seen.held = c->seen.slides = 0;
  memset(c->best, 0, nsdae_fc_bytes(c));
  memset(c->low, 0, nsdae_fc_bytes(c));
  for (size_t i = 0; i < sizeof all / sizeof *all; i++)
    if ((c->options->stages & all[i].stage) && all[i].run(c)) return;
}

/* The island's residual is of scaled data, rounded: where impulses are large it is not that of the
 * data as given. */
static void check(nsdae_fc_chain *c)
{
  int doubtful = DOUBT * DBL_EPSILON * largest(c) > c->options->tol - c->tol;
  if (c->info.outcome == NSDAE_OUTCOME_INFEASIBLE || c->seen.held) return;
  if ((c->options->stages & NSDAE_FRICTION_FURTHER) &&
      (c->info.outcome == NSDAE_OUTCOME_UNSOLVED || doubtful))
    nsdae_fc_precisely(c);
}

void nsdae_fc_chain_run(nsdae_fc_chain *c)
{
  run_stages(c);
  look_back(c);
  check(c);
  refine(c);
}
