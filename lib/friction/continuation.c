/* The smoothed problem with compliance, followed along its curve whichever way that turns.
 *
 *   F(r, l) = 0:  the smoothed map of r and u + a (r - z), epsilon = e^l, a = stiffness epsilon
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
 * A curve whose z is nearly a solution begins next to it, at a small epsilon, and has few folds
 * left where one from z = 0 has thousands: a, which keeps it near z, falls as the root of epsilon.
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

enum { TRIES = 40, CORRECTIONS = 7, POLISH = 2, AGAIN = 4, SETTLE = 60, DOWN = 12 };

/* Of a step: its first correction relative to it, and each correction to the one before, at most;
 * the least cosine between the tangents at its ends; the last correction relative to it, and what
 * it leaves of the map, at most. Each of them keeps it from another branch, which may be as near as
 * one likes. Corrections that are slight may do as they like. */
static const double FIRST = 0.3, CONTRACTION = 0.3, COSINE = 0.9, CLOSE = 1e-3, ON_CURVE = 1e-5,
                    SLIGHT = 1e-3;

/* What rounding leaves of F, of the largest impulse; the end of epsilon; least a of the matrix;
 * shortest and longest step; by how much the next one may be longer. */
static const double ROUNDING = 1e-15, END = 1e-15, REGULAR = 1e-7, SHORTEST = 1e-11, LONGEST = 3,
                    GROWTH = 2;

/* l of the beginning: by how much it is higher where Newton's method did not get to the curve, and
 * at most; from there, that of a curve that returns to where it came from: an anchored one has no
 * other end above. */
static const double HIGHER = 3.5, HIGHEST = 14, BACK = 0.7, FAR_BACK = 3.7;

void nsdae_fc_curve_layout(nsdae_fc_curve *c, const nsdae_fc *fc, nsdae_arena *arena)
{
  long n = fc->n;
  c->tangent = NSDAE_ARENA_DOUBLES(arena, 3 * n);
  c->next = NSDAE_ARENA_DOUBLES(arena, 3 * n);
  c->bend = NSDAE_ARENA_DOUBLES(arena, 3 * n);
  c->slope = NSDAE_ARENA_DOUBLES(arena, 3 * n);
  c->turn = NSDAE_ARENA_DOUBLES(arena, 3 * n);
  c->start = NSDAE_ARENA_DOUBLES(arena, 3 * n);
  c->aim = NSDAE_ARENA_DOUBLES(arena, 3 * n);
  c->origin = NSDAE_ARENA_DOUBLES(arena, 3 * n);
  c->weight = NSDAE_ARENA_DOUBLES(arena, n);
}

/* F at fc->r and this l, and its derivatives where they are wanted; its mean square relative to
 * epsilon. u + a (r - z) is u + alpha (r - centre) with an alpha that is no smaller than REGULAR.
 */
static double map_at(nsdae_fc_curve *c, nsdae_fc_newton *s, double l, int derivatives)
{
  size_t m = 3 * (size_t)s->fc->n;
  double epsilon = exp(l), compliance = c->stiffness * pow(epsilon, c->power);
  s->epsilon = epsilon;
  s->alpha = fmax(compliance, REGULAR);
  const double share = compliance / s->alpha;
  for (size_t i = 0; i < m; i++) s->centre[i] = s->fc->r[i] + share * (c->origin[i] - s->fc->r[i]);
  double half = nsdae_fc_newton_map(s, s->fc->r, s->fc->u, derivatives);
  return sqrt(2 * half / (double)m) / epsilon;
}

/* What rounding leaves of that. */
static double rounding(const nsdae_fc_curve *c, const nsdae_fc *fc)
{
  double most = 1;
  for (int i = 0; i < 3 * fc->n; i++) most = fmax(most, fabs(fc->r[i]));
  return ROUNDING * most * exp(-c->l);
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

/* Lengths are those of the point at hand from here on. */
static void weigh(nsdae_fc_curve *c, const nsdae_fc *fc)
{
  for (int k = 0; k < fc->n; k++) {
    const double *r = fc->r + 3 * k;
    double size = exp(c->l) + sqrt(r[0] * r[0] + r[1] * r[1] + r[2] * r[2]);
    c->weight[k] = 1 / (3.0 * fc->n * size * size);
  }
}

/* The tangent here, from F_r^-1 F_l: of r into c->next, of l into rate. Returns the cosine between
 * it and the one before. */
static double find_tangent(nsdae_fc_curve *c, const nsdae_fc *fc, double *rate)
{
  double along = c->rate - product(c, fc->n, c->turn, c->tangent);
  double length = copysign(sqrt(product(c, fc->n, c->turn, c->turn) + 1), along);
  double before = sqrt(product(c, fc->n, c->tangent, c->tangent) + c->rate * c->rate);
  for (int i = 0; i < 3 * fc->n; i++) c->next[i] = -c->turn[i] / length;
  *rate = 1 / length;
  return along / (length * before);
}

/* Goes on from here along that tangent. bend is what it changes by along a step of that length; 0:
 * there was none. */
static void turn(nsdae_fc_curve *c, const nsdae_fc *fc, double rate, double step)
{
  size_t m = 3 * (size_t)fc->n;
  weigh(c, fc);
  double length = sqrt(product(c, fc->n, c->next, c->next) + rate * rate);

  for (size_t i = 0; i < m; i++) {
    c->bend[i] = step > 0 ? (c->next[i] - c->tangent[i]) / (step * length * length) : 0;
    c->tangent[i] = c->next[i] / length;
  }
  c->bend_rate = step > 0 ? (rate - c->rate) / (step * length * length) : 0;
  c->rate = rate / length;
}

static void move(nsdae_fc_newton *s)
{
  nsdae_fc_velocities(s->fc, s->fc->r, s->fc->y, s->fc->u);
}

/* One correction: dr = -F_r^-1 (F + F_l dl), and (dr, dl) leads back to the plane through aim. Its
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

/* Back to the curve, in the plane through aim. Returns by how much the step was too long for its
 * corrections, less than 1 where the curve was found. Corrections are compared with the step and
 * with each other, whatever the map's scale (Deuflhard, "Newton Methods for Nonlinear Problems",
 * 2011). */
static double find(nsdae_fc_curve *c, nsdae_fc_newton *s, double aim)
{
  double before = 0, ratio = 0;
  for (int k = 0; k < CORRECTIONS; k++) {
    double size = correct(c, s, aim), by = size / (k == 0 ? c->length : before);
    if (!(size < 1)) return INFINITY;
    if (k == 0 || size > SLIGHT * c->length)
      ratio = fmax(ratio, by / (k == 0 ? FIRST : CONTRACTION));
    if (!(ratio < 1) || !(k == 0 || by < 1)) return INFINITY;
    double distance = map_at(c, s, c->l, 0), floor = rounding(c, s->fc);
    if (distance < floor) return ratio;
    if (by * size < CLOSE * fmin(1, c->length) && distance < ON_CURVE) return ratio;
    before = size;
  }
  return INFINITY;
}

/* From c->start along the tangent, with its bend, or straight; and back to the curve. */
static double try(nsdae_fc_curve *c, nsdae_fc_newton *s, double from, int straight)
{
  size_t m = 3 * (size_t)s->fc->n;
  double h = c->length, half = straight ? 0 : h * h / 2, aim = from + h * c->rate;
  for (size_t i = 0; i < m; i++) {
    c->aim[i] = c->start[i] + h * c->tangent[i];
    s->fc->r[i] = c->aim[i] + half * c->bend[i];
  }
  c->l = aim + half * c->bend_rate;
  move(s);
  return find(c, s, aim);
}

/* Where steps begin, once more, and the tangent there: short ones are no longer than what was left
 * of it. Returns its l. */
static double polish(nsdae_fc_curve *c, nsdae_fc_newton *s, double from)
{
  size_t bytes = 3 * (size_t)s->fc->n * sizeof *c->start;
  double rate;
  c->l = from;
  memcpy(s->fc->r, c->start, bytes);
  memcpy(c->aim, c->start, bytes);
  move(s);
  for (int k = 0; k < POLISH; k++)
    if (!(correct(c, s, from) < 1)) return from;
  if (factor(c, s) != 0) return from;
  memcpy(c->start, s->fc->r, bytes);
  find_tangent(c, s->fc, &rate);
  turn(c, s->fc, rate, 0);
  return c->l;
}

/* The next point of the curve; 0 where none was found. */
static int advance(nsdae_fc_curve *c, nsdae_fc_newton *s)
{
  size_t bytes = 3 * (size_t)s->fc->n * sizeof *c->start;
  double from = c->l, rate;
  memcpy(c->start, s->fc->r, bytes);
  for (int k = 1; k <= TRIES && c->length > SHORTEST && s->steps < s->most; k++) {
    double ratio = try(c, s, from, k % 2 == 0), step = c->length;
    double cosine = ratio < 1 ? find_tangent(c, s->fc, &rate) : -1;
    if (cosine > COSINE) {
      double angle = acos(fmin(1, cosine)) / acos(COSINE);
      double factor = fmin(sqrt(0.5 / (ratio + 1e-9)), 0.7 / (angle + 1e-9));
      c->length = fmin(step * fmin(fmax(factor, 0.3), GROWTH), LONGEST);
      turn(c, s->fc, rate, step);
      return 1;
    }
    c->length /= 2;
    if (k % AGAIN == 0) from = polish(c, s, from);
  }
  memcpy(s->fc->r, c->start, bytes);
  c->l = from;
  move(s);
  return 0;
}

/* Random numbers in [-1, 1], the same each time (xorshift64*: Vigna, ACM Trans. Math. Softw. 42,
 * 2016). */
static double draw(unsigned long long *state)
{
  *state ^= *state >> 12;
  *state ^= *state << 25;
  *state ^= *state >> 27;
  return (double)((*state * 2685821657736338717ull) >> 11) * 0x1p-52 - 1;
}

/* Newton's method with a search, from fc->r, at this l; 0 where it does not get to the curve. */
static int reach(nsdae_fc_curve *c, nsdae_fc_newton *s, double l)
{
  size_t bytes = 3 * (size_t)s->fc->n * sizeof *s->centre;
  c->l = l;
  c->top = l + BACK;
  s->search = 1;
  move(s);
  for (int k = 0; k < SETTLE && s->steps < s->most && !(map_at(c, s, l, 0) < CLOSE); k++) {
    memcpy(s->centre, c->origin, bytes);
    if (isnan(nsdae_fc_newton_step(s, nsdae_fc_newton_map(s, s->fc->r, s->fc->u, 0)))) break;
  }
  s->search = 0;
  return map_at(c, s, l, 0) < CLOSE;
}

/* The first tangent, downwards; 0 where there is none. */
static int set_out(nsdae_fc_curve *c, nsdae_fc_newton *s)
{
  double rate;
  memset(c->tangent, 0, 3 * (size_t)s->fc->n * sizeof *c->tangent);
  c->rate = -1;
  c->length = 0.3;
  weigh(c, s->fc);
  if (factor(c, s) != 0) return 0;
  find_tangent(c, s->fc, &rate);
  turn(c, s->fc, rate, 0);
  return 1;
}

int nsdae_fc_curve_begin(nsdae_fc_curve *c, nsdae_fc_newton *s, double stiffness, int number)
{
  size_t m = 3 * (size_t)s->fc->n;
  unsigned long long state = 0x9e3779b97f4a7c15ull * (unsigned long long)number;
  int found = 0;
  for (size_t i = 0; i < m; i++) c->origin[i] = number > 0 ? draw(&state) : 0;
  c->stiffness = stiffness;
  c->power = 1;
  for (double l = 0; !found && l <= HIGHEST && s->steps < s->most; l += HIGHER) {
    memset(s->fc->r, 0, m * sizeof *s->fc->r);
    found = reach(c, s, l);
  }
  return found && set_out(c, s);
}

int nsdae_fc_curve_anchor(nsdae_fc_curve *c, nsdae_fc_newton *s, double epsilon, double compliance)
{
  memcpy(c->origin, s->fc->r, 3 * (size_t)s->fc->n * sizeof *c->origin);
  c->power = 0.5;
  c->stiffness = compliance / sqrt(epsilon);
  int found = reach(c, s, log(epsilon));
  c->top = c->l + FAR_BACK;
  return found && set_out(c, s);
}

int nsdae_fc_curve_follow(nsdae_fc_curve *c, nsdae_fc_newton *s, double lower)
{
  while (c->l > lower)
    if (s->steps >= s->most || !advance(c, s) || c->l > c->top) return 0;
  return 1;
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

double nsdae_fc_curve_descend(nsdae_fc_curve *c, nsdae_fc_newton *s, double tol)
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
