/* The smoothed problem with compliance, followed along its curve whichever way that turns.
 *
 *   F(r, l) = 0:  the smoothed map of r and u + a r, with epsilon = e^l and a = stiffness epsilon
 *
 * has one solution for large epsilon, none escapes to infinity while the problem itself has one in
 * bounds, and that of epsilon -> 0 is a solution of the problem. Where friction makes the problem
 * nonmonotone (impacts, avalanches) the curve between them folds: epsilon has to grow for a while.
 * So it is followed by its arc length (Keller, "Numerical solution of bifurcation and nonlinear
 * eigenvalue problems", 1977; Allgower and Georg, "Introduction to Numerical Continuation Methods",
 * 2003): the tangent (t, t_l) from F_r t + F_l t_l = 0, in the sense in which the last step went; a
 * step along it; Newton's method on F and on the plane through the predicted point across the
 * tangent, by two solutions with F_r (bordering). Lengths are relative to the impulses.
 *
 * At rest as many contacts lie on the edge of their cone without sliding as not: there the map
 * itself is singular, and Newton's method on it goes from kink to kink. The curve arrives all the
 * same, in proportion to epsilon; so it is followed to its end. Below, a is smaller than what keeps
 * F_r from being singular in doubles, and the matrix is that of a larger one: what that leaves of
 * an error is along directions in which r alone moves, and by as little as a does. */
#include "continuation.h"

#include <float.h>
#include <math.h>
#include <string.h>

enum { TRIES = 40, CORRECTIONS = 7, POLISH = 2, SETTLE = 60, DOWN = 12, ROUNDS = 20, STRETCH = 20 };

/* Longest correction relative to the step, and to the one before. */
static const double AWAY = 0.5, GAIN = 0.5;

/* Relative to epsilon, what rounding leaves of F; where folds are behind, as a rule; the end; least
 * a of the matrix; shortest and longest step; l of a curve that returns to where it came from. */
static const double ROUNDING = 1e-13, STRAIGHT = 1e-6, END = 1e-15, REGULAR = 1e-7,
                    SHORTEST = 1e-11, LONGEST = 3, BACK = 0.7;

void nsdae_fc_curve_layout(nsdae_fc_curve *c, const nsdae_fc *fc, nsdae_arena *arena)
{
  long n = fc->n;
  c->tangent = NSDAE_ARENA_DOUBLES(arena, 3 * n);
  c->slope = NSDAE_ARENA_DOUBLES(arena, 3 * n);
  c->turn = NSDAE_ARENA_DOUBLES(arena, 3 * n);
  c->start = NSDAE_ARENA_DOUBLES(arena, 3 * n);
  c->aim = NSDAE_ARENA_DOUBLES(arena, 3 * n);
  c->weight = NSDAE_ARENA_DOUBLES(arena, n);
}

/* F at fc->r and this l, and its derivatives where they are wanted; its mean square relative to
 * epsilon. u + a r is u + alpha (r - centre) with an alpha that is no smaller than REGULAR. */
static double map_at(nsdae_fc_curve *c, nsdae_fc_newton *s, double l, int derivatives)
{
  size_t m = 3 * (size_t)s->fc->n;
  double epsilon = exp(l), compliance = c->stiffness * epsilon;
  s->epsilon = epsilon;
  s->alpha = fmax(compliance, REGULAR);
  for (size_t i = 0; i < m; i++) s->centre[i] = s->fc->r[i] * (1 - compliance / s->alpha);
  double half = nsdae_fc_newton_map(s, s->fc->r, s->fc->u, derivatives);
  return sqrt(2 * half / (double)m) / epsilon;
}

static int is_close(const nsdae_fc_curve *c, double distance)
{
  return distance < fmin(0.1, c->close + ROUNDING * exp(-c->l));
}

/* F_l, by a difference that leaves ten digits; then F_r and its factors. Returns 0 where that went
 * well. */
static int factor(nsdae_fc_curve *c, nsdae_fc_newton *s)
{
  const double d = 1e-5;
  size_t m = 3 * (size_t)s->fc->n;
  map_at(c, s, c->l + d, 0);
  memcpy(c->slope, s->F, m * sizeof *c->slope);
  map_at(c, s, c->l - d, 0);
  for (size_t i = 0; i < m; i++) c->slope[i] = (c->slope[i] - s->F[i]) / (2 * d);
  map_at(c, s, c->l, 1);
  s->steps++;
  if (nsdae_fc_matrix_factor(s->matrix, s->E, s->A, 0) != 0) return 1;
  nsdae_fc_matrix_solve(s->matrix, c->slope, c->turn);
  return 0;
}

static double product(const nsdae_fc_curve *c, int n, const double *a, const double *b)
{
  double sum = 0;
  for (int k = 0; k < n; k++)
    for (int j = 3 * k; j < 3 * k + 3; j++) sum += c->weight[k] * a[j] * b[j];
  return sum;
}

/* The tangent here, from F_r^-1 F_l. */
static void find_tangent(nsdae_fc_curve *c, const nsdae_fc *fc)
{
  for (int k = 0; k < fc->n; k++) {
    const double *r = fc->r + 3 * k;
    double size = exp(c->l) + sqrt(r[0] * r[0] + r[1] * r[1] + r[2] * r[2]);
    c->weight[k] = 1 / (3.0 * fc->n * size * size);
  }
  double along = c->rate - product(c, fc->n, c->turn, c->tangent);
  double length = copysign(sqrt(product(c, fc->n, c->turn, c->turn) + 1), along);
  for (int i = 0; i < 3 * fc->n; i++) c->tangent[i] = -c->turn[i] / length;
  c->rate = 1 / length;
}

static void move(nsdae_fc_newton *s)
{
  nsdae_fc_velocities(s->fc, s->fc->r, s->fc->y, s->fc->u);
}

/* One correction: dr = -F_r^-1 (F + F_l dl), and (dr, dl) leads back to the plane. Returns its
 * length; NaN where there is none. */
static double correct(nsdae_fc_curve *c, nsdae_fc_newton *s, double aim)
{
  nsdae_fc *fc = s->fc;
  size_t m = 3 * (size_t)fc->n;
  if (factor(c, s) != 0) return NAN;
  nsdae_fc_matrix_solve(s->matrix, s->F, s->dr);
  for (size_t i = 0; i < m; i++) s->trial[i] = fc->r[i] - s->dr[i] - c->aim[i];
  double off = product(c, fc->n, c->tangent, s->trial) + c->rate * (c->l - aim);
  double dl = off / (product(c, fc->n, c->tangent, c->turn) - c->rate);
  for (size_t i = 0; i < m; i++) {
    s->dr[i] += c->turn[i] * dl;
    fc->r[i] -= s->dr[i];
  }
  c->l += dl;
  move(s);
  return sqrt(product(c, fc->n, s->dr, s->dr) + dl * dl);
}

/* From c->start along the tangent, and back to the curve; the number of corrections, 0 where it was
 * not found. Corrections are compared with the step and with each other, whatever the map's scale
 * (Deuflhard, "Newton Methods for Nonlinear Problems", 2011): near a kink the map may be as small
 * as one likes on another branch. */
static int try(nsdae_fc_curve *c, nsdae_fc_newton *s, double from)
{
  size_t m = 3 * (size_t)s->fc->n;
  double aim = c->l = from + c->length * c->rate, before = AWAY * c->length / GAIN;
  for (size_t i = 0; i < m; i++) s->fc->r[i] = c->aim[i] = c->start[i] + c->length * c->tangent[i];
  move(s);
  for (int k = 1; k <= CORRECTIONS; k++) {
    double size = correct(c, s, aim);
    if (!(size < GAIN * before) || !(size < 1)) return 0;
    if (size < c->close * fmin(1, c->length) || map_at(c, s, c->l, 0) < ROUNDING * exp(-c->l))
      return k;
    before = size;
  }
  return 0;
}

/* The point where steps begin, once more: short ones are no longer than what was left of it. */
static double polish(nsdae_fc_curve *c, nsdae_fc_newton *s, double from)
{
  size_t bytes = 3 * (size_t)s->fc->n * sizeof *c->start;
  c->l = from;
  memcpy(s->fc->r, c->start, bytes);
  memcpy(c->aim, c->start, bytes);
  move(s);
  for (int k = 0; k < POLISH; k++)
    if (!(correct(c, s, from) < 1)) return from;
  memcpy(c->start, s->fc->r, bytes);
  return c->l;
}

/* The next point of the curve; 0 where none was found. */
static int advance(nsdae_fc_curve *c, nsdae_fc_newton *s)
{
  size_t bytes = 3 * (size_t)s->fc->n * sizeof *c->start;
  double from = c->l;
  int corrections = 0;
  memcpy(c->start, s->fc->r, bytes);
  if (factor(c, s) != 0) return 0;
  find_tangent(c, s->fc);
  for (int k = 1; k <= TRIES && c->length > SHORTEST; k++) {
    corrections = try(c, s, from);
    if (corrections > 0) break;
    c->length *= 0.4;
    if (k % 4 == 0) from = polish(c, s, from);
  }
  if (corrections == 0) {
    memcpy(s->fc->r, c->start, bytes);
    c->l = from;
    move(s);
    return 0;
  }
  double factor = corrections <= 2 ? 2 : corrections == 3 ? 1.4 : corrections > 4 ? 0.7 : 1;
  c->length = fmin(factor * c->length, LONGEST);
  return 1;
}

/* The beginning of the curve: epsilon = 1, where Newton's method with a search gets to. */
static void begin(nsdae_fc_curve *c, nsdae_fc_newton *s)
{
  size_t m = 3 * (size_t)s->fc->n;
  memset(s->fc->r, 0, m * sizeof *s->fc->r);
  memset(c->tangent, 0, m * sizeof *c->tangent);
  c->l = 0;
  c->rate = -1;
  c->length = 0.3;
  s->search = 1;
  move(s);
  for (int k = 0; k < SETTLE && !is_close(c, map_at(c, s, 0, 0)); k++) {
    memset(s->centre, 0, m * sizeof *s->centre);
    nsdae_fc_newton_step(s, nsdae_fc_newton_map(s, s->fc->r, s->fc->u, 0));
  }
  s->search = 0;
}

/* Newton's method at this l; the steps, or 0 where it failed and r is as it was. */
static int settle(nsdae_fc_curve *c, nsdae_fc_newton *s, double l)
{
  size_t bytes = 3 * (size_t)s->fc->n * sizeof *c->start;
  memcpy(c->start, s->fc->r, bytes);
  for (int k = 1; k <= DOWN; k++) {
    map_at(c, s, l, 0);
    if (isnan(nsdae_fc_newton_step(s, INFINITY))) break;
    if (map_at(c, s, l, 0) < 0.03) return k;
  }
  memcpy(s->fc->r, c->start, bytes);
  move(s);
  return 0;
}

/* What is left of the curve once it is straight: epsilon down to rounding. */
static double descend(nsdae_fc_curve *c, nsdae_fc_newton *s, double tol)
{
  double shrink = 0.5, residual = nsdae_fc_residual(s->fc, s->fc->r, s->fc->u);
  for (int failures = 0; residual > tol && c->l > log(END) && failures < 8 && s->steps < s->most;) {
    int steps = settle(c, s, c->l + log(shrink));
    if (steps > 0) {
      c->l += log(shrink);
      residual = nsdae_fc_residual(s->fc, s->fc->r, s->fc->u);
    } else
      failures++;
    if (steps > 0 && steps <= 3) shrink = fmax(shrink * shrink, 0.1);
    if (steps == 0 || steps > 6) shrink = sqrt(shrink);
  }
  return residual;
}

/* Steps along the curve until the end is straight, or STRETCH of them where it was not. */
static double follow(nsdae_fc_curve *c, nsdae_fc_newton *s, double tol, int least)
{
  double residual = INFINITY;
  for (int k = 0; s->steps < s->most && (k < least || c->l > log(STRAIGHT)); k++) {
    if (!advance(c, s) || c->l > BACK) return NAN;
    residual = nsdae_fc_residual(s->fc, s->fc->r, s->fc->u);
    if (residual <= tol) return residual;
  }
  return residual;
}

double nsdae_fc_continue(nsdae_fc_curve *c, nsdae_fc_newton *s, double stiffness, double close,
                         double tol)
{
  double residual = INFINITY;
  c->stiffness = stiffness;
  c->close = close;
  begin(c, s);
  for (int round = 0; round < ROUNDS && s->steps < s->most; round++) {
    residual = follow(c, s, tol, round > 0 ? STRETCH : 0);
    if (!(residual > tol)) break;
    residual = descend(c, s, tol);
    if (residual <= tol) break;
    c->length = 0.01;
  }
  return nsdae_fc_residual(s->fc, s->fc->r, s->fc->u);
}
