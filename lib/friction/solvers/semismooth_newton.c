
#include <math.h>
#include <string.h>

#include "natural_map.h"
#include "solver_contract.h"

void nsdae_fc_newton_layout(nsdae_fc_newton *s, nsdae_arena *arena)
{
  long n = s->fc->n;
  nsdae_arena_doubles(arena, 9 * n, (double **[]){&s->E, &s->A, NULL});
  nsdae_arena_doubles(arena, 3 * n,
                      (double **[]){&s->F, &s->dr, &s->trial, &s->centre, &s->u, NULL});
  s->y = NSDAE_ARENA_DOUBLES(arena, s->fc->ny);
}

/* Half the square of the map at r with velocities u; E and A if derivatives are wanted. */
static double newton_map(nsdae_fc_newton *s, const double *r, const double *u, int derivatives)
{
  const nsdae_fc_scaled *c = s->fc;
  double sum = 0;
  for (int k = 0; k < c->n; k++) {
    double v[3], x[3], low[3], A[9], B[9], *F = s->F + 3 * k, *E = s->E + 9 * (size_t)k;
    if (c->base.high) nsdae_fc_impulse(c, k, r, x, low);
    for (int j = 0; j < 3; j++)
      v[j] = u[3 * k + j] + s->alpha * (r[3 * k + j] - s->centre[3 * k + j]);
    if (s->epsilon > 0)
      nsdae_fc_smooth_map(c->items.kind[k], c->items.mu[k], s->epsilon, r + 3 * k, v, F, B, A);
    else
      nsdae_fc_natural_map(c->items.kind[k], c->items.mu[k], c->base.high ? x : r + 3 * k,
                           c->base.high ? low : NULL, v, F, B, A);
    for (int j = 0; j < 3; j++) sum += F[j] * F[j] / 2;
    if (!derivatives) continue;
    memcpy(s->A + 9 * (size_t)k, A, sizeof A);
    for (int i = 0; i < 9; i++) E[i] = B[i] + A[i] * (s->alpha + c->items.C[3 * k + i % 3]);
  }
  return sum;
}

/* E^-1 is up to 1 / alpha, and what rounding leaves of velocities is as much larger in dr: a step
 * of iterative refinement (Skeel, Math. Comp. 35 (1980) 817) takes most of it away. */
void nsdae_fc_newton_solve(nsdae_fc_newton *s, const double *b, double *dr)
{
  nsdae_fc_system_solve(s->system, b, dr);
  nsdae_fc_response(s->fc, dr, s->y, s->u);
  for (int k = 0; k < s->fc->n; k++) { /* u := b - E dr - A W dr */
    const double *E = s->E + 9 * (size_t)k, *A = s->A + 9 * (size_t)k;
    double rest[3], *u = s->u + 3 * k;
    for (int i = 0; i < 3; i++) {
      rest[i] = b[3 * k + i];
      for (int j = 0; j < 3; j++) rest[i] -= E[3 * i + j] * dr[3 * k + j] + A[3 * i + j] * u[j];
    }
    memcpy(u, rest, sizeof rest);
  }
  nsdae_fc_system_solve(s->system, s->u, s->trial);
  for (size_t i = 0; i < 3 * (size_t)s->fc->n; i++) dr[i] += s->trial[i];
}

/* One step from fc->r, with fc->y and fc->u; before is half the square of the map there. Returns it
 * at the new point; NaN if there is none, and fc as it was. */
static double fc_newton_step(nsdae_fc_newton *s, double before)
{
  nsdae_fc_scaled *c = s->fc;
  size_t m = 3 * (size_t)c->n;
  double now = INFINITY, length = 1;
  newton_map(s, c->r, c->u, 1);
  if (nsdae_fc_system_factor(s->system, s->E, s->A) != 0) return NAN;
  nsdae_fc_system_solve(s->system, s->F, s->dr);
  for (int k = 0; k < 8; k++, length /= 2) {
    for (size_t i = 0; i < m; i++) s->trial[i] = c->r[i] - length * s->dr[i];
    nsdae_fc_velocities(c, s->trial, s->y, s->u);
    now = newton_map(s, s->trial, s->u, 0);
    if (s->search ? now <= (1 - 1e-4 * length) * before : now < INFINITY) break;
  }
  if (!(now < INFINITY)) return NAN;
  memcpy(c->r, s->trial, m * sizeof *c->r);
  memcpy(c->u, s->u, m * sizeof *c->u);
  if (!c->local) memcpy(c->y, s->y, (size_t)c->ny * sizeof *c->y);
  return now;
}

/* Semismooth Newton on the natural map (Qi and Sun, Math. Program. 58 (1993) 353) inside the
 * proximal point method (Rockafellar, SIAM J. Control Optim. 14 (1976) 877), which replaces u by
 * u + alpha (r - z), and z by the solution of that, with alpha -> 0. With more impulses than
 * freedoms each of these problems still has one solution near z. Steps are whole: each is a choice
 * of which items are open, stick and slide; a line search stalls at the first kink. The first alpha
 * is a share of the residual, as in Levenberg-Marquardt methods (Fan and Yuan, Computing 74 (2005)
 * 23). */

/* Steps of one problem. With 15, 30 and 60 of 40 seeded problems 39 are solved. */
enum { INNER = 30 };

/* Steps in which the residual has to be halved. With 75, 150 and 300 of 40 seeded problems 39, 39
 * and 40 are solved to 1e-8. */
enum { IDLE = 150 };

/* Reduction of the square of its map that solves a problem. With 1e-2, 1e-4 and 1e-6 39 of the 40
 * are solved. */
static const double GAIN = 1e-4;

/* The first alpha over the residual. With 1e-3, 1e-2, 0.1 and 1 of 60 seeded problems 51, 51, 50
 * and 52 are solved to 1e-8; from 0.1 on the last problem may leave 1e-10. */
static const double SHARE = 1e-2;

/* A proximal term that changes velocities by rounding, and keeps the matrix of a step from a
 * solution regular if that is degenerate; 1e-13 does not. */
static const double SLIGHT = 1e-10;

/* A failed problem is repeated with ten times alpha, up to this one. With 1e2, 1e3 and 1e4 39 of
 * the 40 are solved. */
static const double LARGEST = 1e3;

/* Solves with the centre at fc.r, or goes back there; returns the steps, 0 if it failed. */
static int solve_problem(nsdae_fc_island *s, nsdae_fc_iterate *it, const nsdae_fc_budget *b)
{
  nsdae_fc_newton *newton = &s->newton;
  memcpy(newton->centre, s->fc.r, nsdae_fc_bytes(s));
  double start = newton_map(newton, s->fc.r, s->fc.u, 0), now = start;
  double goal = fmax(GAIN * start, 1e-2 * b->tol * b->tol), most = 1e4 * fmax(start, 1e-3);
  int steps = 0;
  while (now > goal && now <= most && steps < INNER && nsdae_fc_spend_step(s, it, b)) {
    now = fc_newton_step(newton, now);
    steps++;
  }
  if (now <= goal && steps > 0) return steps;
  nsdae_fc_set_point(s, newton->centre);
  return 0;
}

static void begin_proximal(nsdae_fc_newton *newton, double alpha)
{
  newton->alpha = alpha;
  newton->epsilon = 0;
  newton->search = 0;
}

double nsdae_fc_proximal_points(nsdae_fc_island *s, nsdae_fc_iterate *it, const nsdae_fc_budget *b)
{
  nsdae_fc_newton *newton = &s->newton;
  double factor = 0.1, half = INFINITY, best;
  int mark = it->work.steps;
  nsdae_fc_velocities(&s->fc, s->fc.r, s->fc.y, s->fc.u);
  double residual = best = nsdae_fc_offer(s, it);
  memcpy(s->point, s->fc.r, nsdae_fc_bytes(s));
  begin_proximal(newton, fmax(SHARE * residual, NSDAE_FC_REGULAR));
  while (!(residual <= b->tol) && it->work.steps - mark < IDLE) {
    if (it->work.steps >= b->steps || it->work.products >= b->products || it->work.interrupted)
      break;
    int steps = solve_problem(s, it, b);
    if (steps == 0) {
      newton->alpha *= 10;
      factor = sqrt(factor);
      if (newton->alpha > LARGEST) break;
      continue;
    }
    double before = residual;
    residual = nsdae_fc_offer(s, it);
    if (residual < best) {
      best = residual;
      memcpy(s->point, s->fc.r, nsdae_fc_bytes(s));
    }
    if (best < half) half = best / 2, mark = it->work.steps;
    if (steps <= 5 || residual > 0.3 * before)
      newton->alpha = fmax(newton->alpha * factor, NSDAE_FC_REGULAR);
    factor = fmax(factor * factor, 0.1);
  }
  if (!(residual <= best)) nsdae_fc_set_point(s, s->point);
  return best;
}

int nsdae_fc_semismooth_newton(nsdae_fc_island *s, nsdae_fc_iterate *it, const nsdae_fc_budget *b)
{
  if (!nsdae_fc_system_ready(s)) return NSDAE_FC_NO_MEMORY;
  memcpy(s->fc.r, it->r, nsdae_fc_bytes(s));
  nsdae_fc_proximal_points(s, it, b);
  return it->residual <= b->tol;
}

void nsdae_fc_polish(nsdae_fc_island *s, nsdae_fc_iterate *it, const nsdae_fc_budget *b, int steps)
{
  begin_proximal(&s->newton, SLIGHT);
  nsdae_fc_set_point(s, it->r);
  for (int k = 0; k < steps && it->residual > 0; k++) {
    double before = it->residual;
    memcpy(s->newton.centre, s->fc.r, nsdae_fc_bytes(s));
    if (!nsdae_fc_spend_step(s, it, b) || isnan(fc_newton_step(&s->newton, INFINITY))) break;
    if (!(nsdae_fc_offer(s, it) < before)) break;
  }
}

/* Homotopy from a smooth neighbour of the natural map to the map itself (Fukushima, Luo, Tseng,
 * SIAM J. Optim. 12 (2002) 436): eigenvalues l of r - u^ go to (l + sqrt(l^2 + 4 e^2)) / 2 in place
 * of max(0, l), |u_T| to sqrt(|u_T|^2 + e^2) - e. Its points have r o u^ = e^2, the central path of
 * an interior point with s = mu |u_T| among the unknowns: no outer iteration over s. e falls from 1
 * to 1e-6, two to five Newton steps each, the faster the fewer were needed; e = 0 is left to
 * semismooth Newton. A call follows one path; the next call follows it ten times as closely. */

/* Newton steps of one point; five are usual. With 8, 15 and 30 of 40 seeded problems 39 are solved
 * to 1e-8. */
enum { CORRECTOR_STEPS = 15 };

/* Distance from the path relative to e, of the first path; each path that is lost is followed again
 * at a tenth, at most this number of times. With 1e-2, 1e-3 and 1e-4 40, 39 and 40 of the 40 are
 * solved; with 1, 3 and 6 times 39. */
static const double LOOSE = 1e-3;
enum { TIGHTER = 3 };

/* Last e: below, rounding decides. With 1e-5, 1e-6 and 1e-7 39 of the 40 are solved. */
static const double LAST = 1e-6;

/* First e: a point of the path has r o u^ = e^2, and Newton's method does not get from zero to
 * impulses that are larger by far than e, as those of unlike masses are. */
static const double FIRST[] = {1, 1e3, 1e6};

/* Newton steps until the map is small for this e; their number, 0 if there was none. */
static int correct(nsdae_fc_island *s, nsdae_fc_iterate *it, const nsdae_fc_budget *b, double loose)
{
  nsdae_fc_newton *newton = &s->newton;
  memcpy(newton->centre, s->fc.r, nsdae_fc_bytes(s));
  double now = newton_map(newton, s->fc.r, s->fc.u, 0);
  double goal = loose * s->fc.n * newton->epsilon * newton->epsilon;
  int steps = 0;
  do {
    if (!nsdae_fc_spend_step(s, it, b)) return 0;
    now = fc_newton_step(newton, now);
    steps++;
  } while (now > goal && steps < CORRECTOR_STEPS);
  return isnan(now) ? 0 : steps;
}

/* Along the path to its end; returns the residual there. */
static double follow(nsdae_fc_island *s, nsdae_fc_iterate *it, const nsdae_fc_budget *b,
                     double loose)
{
  double shrink = 0.3, residual = INFINITY;
  int steps = CORRECTOR_STEPS;
  s->newton.alpha = NSDAE_FC_REGULAR;
  s->newton.search = 1;
  for (size_t k = 0; k < sizeof FIRST / sizeof *FIRST && steps == CORRECTOR_STEPS; k++) {
    memset(s->fc.r, 0, nsdae_fc_bytes(s)); /* the first point, from r = 0 */
    nsdae_fc_set_point(s, s->fc.r);
    s->newton.epsilon = FIRST[k];
    steps = correct(s, it, b, loose);
  }
  while (steps > 0) {
    residual = nsdae_fc_offer(s, it);
    if (residual <= b->tol) break;
    if (steps <= 2) shrink = fmax(0.6 * shrink, 0.03);
    if (steps >= 5) shrink = fmin(1.5 * shrink, 0.7);
    if (!(s->newton.epsilon * shrink > LAST)) break;
    s->newton.epsilon *= shrink;
    steps = correct(s, it, b, loose);
  }
  return residual;
}

int nsdae_fc_smoothing_homotopy(nsdae_fc_island *s, nsdae_fc_iterate *it, const nsdae_fc_budget *b)
{
  if (!nsdae_fc_system_ready(s)) return NSDAE_FC_NO_MEMORY;
  if (s->lost_paths > TIGHTER) return it->residual <= b->tol;
  double end = follow(s, it, b, LOOSE * pow(0.1, s->lost_paths));
  if (end <= b->tol || (end < NSDAE_FC_NEAR && nsdae_fc_proximal_points(s, it, b) <= b->tol))
    return 1;
  if (nsdae_fc_spend(s, it, b, 0)) s->lost_paths++;
  return it->residual <= b->tol;
}
