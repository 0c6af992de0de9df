/* The problem with its shift mu |u_T| fixed is convex: its path has no folds. Its solution says
 * what the next shift is; where that is the same, the problem is solved (De Saxce and Feng 1998;
 * Acary, Cadoux, Lemarechal, Malick 2011: such a fixed point exists). Where little slides few of
 * them are enough, and of bodies that rest the first one is zero. Else they go there slowly, by
 * much the same step each time where bodies gather speed: so steps in the direction of the one
 * before get longer. Newton's method goes on from where the residual has shrunk. Where the shift
 * does not settle, as of impacts that make walls of blocks slide, it wanders near solutions, none
 * of which keeps it: shorter steps get to some of them, as they do not go round what turns, and
 * curves that begin at the calmest point lead to others. */
#include "conic.h"

#include <math.h>
#include <string.h>

#include "curves.h"
#include "further.h"
#include "middle.h"

/* Newton's method is tried at the first shifts, and then where the residual is so much smaller than
 * where it was tried before; its steps. */
enum { FIRST = 3, ATTEMPT = 150 };
static const double SHRUNK = 0.7;

/* Convex problems in which the residual has to shrink by a factor, else the walk is stuck: as many
 * more the next time; its pace then. */
enum { WINDOW = 50 };
static const double PROGRESS = 0.8, PATIENCE = 1.25, SLOW = 0.3;

/* So many curves begin from early on, wherever the residual is less by a factor than at the one
 * before, or after so many Newton steps: many walls need no more. */
enum { EARLY = 8, SETTLED = 40, MEANWHILE = 2500 };

/* Near a solution: there proximal points may get to it. */
static const double NEAR = 1e-4;

/* The residual of where a curve usually begins; nearer to a solution it begins further down. */
static const double USUAL = 5e-4;

/* Epsilon from which on the path of the second convex problem is followed. */
static const double MARK = 0.1;

/* A step is along the one before where the cosine between them is above the first of these; then it
 * is longer by the second one, up to the third. */
static const double ALONG = 0.8, STRETCH = 1.5, LONGEST = 10;

/* c->slip to the next shift, pace and stride times as far as mu |u_T|; returns the next stride. */
static double move_shift(nsdae_fc_chain *c, double stride, double pace)
{
  double now = 0, before = 0, both = 0;
  for (int k = 0; k < c->fc.n; k++) {
    double step = nsdae_fc_slip(&c->fc, k) - c->slip[k];
    now += step * step;
    before += c->walked.drift[k] * c->walked.drift[k];
    both += step * c->walked.drift[k];
    c->walked.drift[k] = step;
  }
  if (both > ALONG * sqrt(now) * sqrt(before))
    stride = fmin(STRETCH * stride, LONGEST);
  else
    stride = both > 0 ? fmax(1, stride / 2) : 1;
  const double far = stride > 1 ? stride : pace * stride;
  for (int k = 0; k < c->fc.n; k++) c->slip[k] = fmax(0, c->slip[k] + far * c->walked.drift[k]);
  return stride;
}

/* The convex problem, by a path from a place of that of the one before: quick while shifts are far
 * off. It ends at 1e-6, which near a solution is as much as they are off. */
static void solve_quickly(nsdae_fc_chain *c)
{
  c->newton.shift = c->slip;
  nsdae_fc_path(&c->newton, 1e-3, c->tol);
  c->newton.shift = NULL;
}

/* The same by an interior point, from the solution of the one before. */
static void solve_exactly(nsdae_fc_chain *c)
{
  memcpy(c->interior.shift, c->slip, (size_t)c->fc.n * sizeof *c->slip);
  memcpy(c->fc.r, c->walked.point, nsdae_fc_bytes(c));
  nsdae_fc_velocities(&c->fc, c->fc.r, c->fc.y, c->fc.u);
  nsdae_fc_interior_run(&c->interior, &c->newton);
  memcpy(c->walked.point, c->fc.r, nsdae_fc_bytes(c));
}

static int try_newton(nsdae_fc_chain *c, int most, int stage)
{
  if (!nsdae_fc_ready(c)) return 0;
  if (most > 0 && most < c->newton.most) c->newton.most = most;
  nsdae_fc_proximal(&c->newton, 1e-8, c->tol);
  return nsdae_fc_count(c, stage) || nsdae_fc_arrived(c);
}

/* The convex problems so far: their residuals as points of the problem itself. */
typedef struct nsdae_fc_walk {
  double tried;   /* where Newton's method was tried last */
  double least;   /* the least one, but for a factor; */
  double calmest; /* and since the last curve, that of c->walked.calm */
  double pace;    /* share of a step that is made */
  int window;     /* problems that it has time to get less */
  int since;      /* the first of them */
  double begun;   /* where the last early curve began */
  int curves;     /* so far */
  int spent;      /* Newton steps when the last one ended */
  int returns;    /* where it is stuck it goes on from the calmest point */
} nsdae_fc_walk;

static void look(nsdae_fc_walk *w, nsdae_fc_chain *c, int k, double residual)
{
  if (residual < PROGRESS * w->least) {
    w->least = residual;
    w->since = k;
  }
  if (!(residual < w->calmest)) return;
  memcpy(c->walked.calm, c->fc.r, nsdae_fc_bytes(c));
  w->calmest = residual;
}

static void return_to_calm(nsdae_fc_chain *c)
{
  memcpy(c->fc.r, c->walked.calm, nsdae_fc_bytes(c));
  nsdae_fc_velocities(&c->fc, c->fc.r, c->fc.y, c->fc.u);
}

/* Whether a curve may be followed: it takes long, and the caller's bounds are not its own. */
static int may_follow(const nsdae_fc_chain *c)
{
  return c->patient && c->options->max_sweeps == 0 && c->options->max_iterations == 0;
}

static int follow(nsdae_fc_walk *w, nsdae_fc_chain *c, double usual)
{
  int found = nsdae_fc_anchored_curves(c, w->curves++, usual);
  w->spent = c->seen.spent;
  return found;
}

/* A curve from the point at hand, or where Newton's method ended. */
static int begin_early(nsdae_fc_walk *w, nsdae_fc_chain *c, double residual)
{
  if (!(residual < SHRUNK * w->begun) && c->seen.spent - w->spent < MEANWHILE) return 0;
  w->begun = fmin(residual, w->begun);
  return follow(w, c, 0);
}

/* The walk goes on from fc.r and its shift. */
static void begin_anew(nsdae_fc_chain *c)
{
  nsdae_fc_shift(&c->fc, c->slip);
  memcpy(c->walked.point, c->fc.r, nsdae_fc_bytes(c));
  memset(c->walked.drift, 0, (size_t)c->fc.n * sizeof *c->walked.drift);
}

/* Where the walk is stuck: from the calmest point of late what gets there from near a solution, and
 * a curve; then on at the other pace. */
static int leave(nsdae_fc_walk *w, nsdae_fc_chain *c, int k)
{
  w->since = k;
  w->window = (int)(PATIENCE * w->window);
  w->pace = w->pace < 1 ? 1 : SLOW;
  if (!may_follow(c) || !(w->calmest < INFINITY)) return 0;
  return_to_calm(c);
  if (w->calmest < NEAR && nsdae_fc_creep_on(c)) return 1;
  return_to_calm(c);
  w->calmest = INFINITY;
  if (w->returns) begin_anew(c);
  return follow(w, c, USUAL);
}

/* What goes on from the solution of the convex problem k: Newton's method, or a curve. */
static int go_on(nsdae_fc_walk *w, nsdae_fc_chain *c, int k, double residual, int stage)
{
  look(w, c, k, residual);
  if (k < FIRST || residual < SHRUNK * w->tried) {
    w->tried = residual;
    if (try_newton(c, k < FIRST ? 0 : ATTEMPT, stage)) return 1;
    const int creep = c->patient && residual <= NSDAE_FC_NEARLY;
    if (creep ? nsdae_fc_creep_on(c) : nsdae_fc_middle_on(c)) return 1;
  }
  if (k >= SETTLED && w->curves < EARLY && may_follow(c) && begin_early(w, c, residual)) return 1;
  return k - w->since >= w->window && leave(w, c, k);
}

/* Newton steps that its budget is for: what creeps has one of its own. */
static int steps_walked(const nsdae_fc_chain *c)
{
  return c->seen.spent - c->seen.creeping;
}

int nsdae_fc_conic(nsdae_fc_chain *c, int how, int most, double budget, int stage)
{
  nsdae_fc_walk walk = {.tried = INFINITY,
                        .least = INFINITY,
                        .calmest = INFINITY,
                        .begun = INFINITY,
                        .pace = 1,
                        .window = WINDOW,
                        .returns = how == NSDAE_FC_RETURNING};
  double stride = 1;
  const int before = steps_walked(c);
  memset(c->walked.drift, 0, (size_t)c->fc.n * sizeof *c->walked.drift);
  memcpy(c->walked.point, c->fc.r, nsdae_fc_bytes(c));
  c->newton.mark_epsilon = 0;
  c->newton.mark_at = MARK;
  for (int k = 0; k < most && (steps_walked(c) - before) * (double)c->fc.n < budget; k++) {
    if (!nsdae_fc_ready(c)) return 0;
    if (how == NSDAE_FC_QUICKLY)
      solve_quickly(c);
    else
      solve_exactly(c);
    nsdae_fc_velocities(&c->fc, c->fc.r, c->fc.y, c->fc.u);
    stride = move_shift(c, stride, walk.pace);
    if (nsdae_fc_count(c, stage)) return 1;
    double residual = nsdae_fc_residual(&c->fc, c->fc.r, c->fc.u);
    if (go_on(&walk, c, k, residual, stage)) return 1;
  }
  return 0;
}
