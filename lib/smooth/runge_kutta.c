#include "runge_kutta.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include <nsdae/status.h>

#include "vector.h"

enum { STAGES = 7, REFUSALS = 100 };

static const double c[STAGES] = {0, 0.2, 0.3, 0.8, 8.0 / 9, 1, 1};
static const double a[STAGES][STAGES - 1] = {
    {0},
    {1.0 / 5},
    {3.0 / 40, 9.0 / 40},
    {44.0 / 45, -56.0 / 15, 32.0 / 9},
    {19372.0 / 6561, -25360.0 / 2187, 64448.0 / 6561, -212.0 / 729},
    {9017.0 / 3168, -355.0 / 33, 46732.0 / 5247, 49.0 / 176, -5103.0 / 18656},
    {35.0 / 384, 0, 500.0 / 1113, 125.0 / 192, -2187.0 / 6784, 11.0 / 84}};
/* y_1 less the solution of order 4; of the continuous extension */
static const double e[STAGES] = {71.0 / 57600,      0,          -71.0 / 16695, 71.0 / 1920,
                                 -17253.0 / 339200, 22.0 / 525, -1.0 / 40};
static const double d[STAGES] = {-12715105075.0 / 11282082432,  0,
                                 87487479700.0 / 32700410799,   -10690763975.0 / 1880347072,
                                 701980252875.0 / 199316789632, -1453857185.0 / 822651844,
                                 69997945.0 / 29380423};

/* Of the step that the error's estimate asks for; how much it may change from one to the next. */
static const double SAFETY = 0.9, LEAST = 0.2, MOST = 10;

/* |h lambda| near the border of stability, which is at 3.3 (Hairer and Wanner II, IV.2), and how
 * many such steps tell: those whose lambda falls as 1 / t, as where a body begins to slide, are
 * fewer. */
static const double BORDER = 2;
enum { STIFF = 150 };

void nsdae_runge_kutta_layout(nsdae_runge_kutta *rk, nsdae_arena *arena)
{
  for (int i = 0; i < STAGES; i++) rk->k[i] = NSDAE_ARENA_DOUBLES(arena, rk->n);
  for (int i = 0; i < 5; i++) rk->dense[i] = NSDAE_ARENA_DOUBLES(arena, rk->n);
  rk->y = NSDAE_ARENA_DOUBLES(arena, rk->n);
  rk->trial = NSDAE_ARENA_DOUBLES(arena, rk->n);
  rk->sum = NSDAE_ARENA_DOUBLES(arena, rk->n);
}

/* The way of the positions, at the rates of where it is. */
static void measure_way(nsdae_runge_kutta *rk)
{
  rk->way = rk->max_step * nsdae_largest(rk->positions, rk->k[6]);
}

/* Integrals are not fed back: their error does not grow. */
static const double INTEGRAL = 10;

/* ||x|| with the weights of y; NaN and overflow are as large as can be. */
static double norm(const nsdae_runge_kutta *rk, const double *x)
{
  double sum = 0;
  for (int i = 0; i < rk->controlled; i++) {
    double scale = fabs(rk->y[i]);
    if (i < rk->positions && rk->way < scale) scale = rk->way;
    double part = x[i] / (rk->rtol * scale + rk->atol);
    sum += part * part;
  }
  return isfinite(sum) ? sqrt(sum / rk->controlled) : HUGE_VAL;
}

/* The largest error of a force's impulse over a step h, in parts of INTEGRAL rtol of what the
 * largest force makes in max_step: one that jumps within the step, as past the end of an edge,
 * shows there alone if the motion does not depend on it. */
static double impulse_error(const nsdae_runge_kutta *rk, double h)
{
  int first = rk->controlled, count = rk->forces;
  double size =
      fmax(nsdae_largest(count, rk->k[0] + first), nsdae_largest(count, rk->k[6] + first));
  double error = nsdae_largest(count, rk->sum + first);
  size = fmax(size, rk->force) * rk->max_step;
  return error > 0 ? h * error / (INTEGRAL * rk->rtol * size) : 0;
}

/* sum := sum_j weight_j k_j, of the first n, two terms at a time; the weight of k_2 is zero, and
 * that may not be there, where n is all */
static void combine(nsdae_runge_kutta *rk, int n, int count, const double *weight)
{
  double *restrict sum = rk->sum;
  const double *k = rk->k[0], *l = k, w = weight[0];
  int j = count > 1 && weight[1] == 0 ? 2 : 1;
  for (int i = 0; i < n; i++) sum[i] = w * k[i];
  for (; j < count; j += 2) {
    const double x = weight[j], y = j + 1 < count ? weight[j + 1] : 0;
    k = rk->k[j];
    if (y != 0) l = rk->k[j + 1];
    for (int i = 0; i < n; i++) sum[i] = sum[i] + x * k[i] + y * l[i];
  }
}

static int rate(nsdae_runge_kutta *rk, double t, const double *y, int whole, double *ydot)
{
  return nsdae_progress_note(&rk->progress, rk->rate(t, y, ydot, whole, rk->user));
}

/* The first step's length (Hairer, Norsett and Wanner, II.4), with k[1] for f after a short one. */
static int first_step(nsdae_runge_kutta *rk)
{
  double size = norm(rk, rk->y), slope = norm(rk, rk->k[6]);
  double h = size < 1e-5 || slope < 1e-5 ? 1e-6 : 0.01 * size / slope;
  h = fmin(fmax(h, 64 * DBL_EPSILON * fabs(rk->t)), rk->max_step);
  nsdae_move(rk->controlled, rk->y, h, rk->k[6], rk->trial);
  int code = rate(rk, rk->t + h, rk->trial, 0, rk->k[1]);
  for (int i = 0; i < rk->controlled && code == 0; i++)
    rk->sum[i] = (rk->k[1][i] - rk->k[6][i]) / h;
  double curve = code == 0 ? fmax(slope, norm(rk, rk->sum)) : HUGE_VAL;
  rk->h = fmin(rk->max_step, fmin(100 * h, curve <= 1e-15    ? fmax(1e-6, h * 1e-3)
                                           : isfinite(curve) ? pow(0.01 / curve, 0.2)
                                                             : h));
  return code < 0 ? NSDAE_E_CALLBACK : NSDAE_OK;
}

int nsdae_runge_kutta_start(nsdae_runge_kutta *rk, double t, const double *y)
{
  rk->progress = (nsdae_progress){0};
  rk->t = t;
  rk->last = 0;
  rk->border = 0;
  memcpy(rk->y, y, (size_t)rk->n * sizeof *y);
  for (int i = 0; i < 5; i++) memset(rk->dense[i], 0, (size_t)rk->n * sizeof *y);
  memcpy(rk->dense[0], y, (size_t)rk->n * sizeof *y);
  if (rate(rk, t, rk->y, 1, rk->k[6]) != 0) return NSDAE_E_CALLBACK;
  measure_way(rk);
  return first_step(rk);
}

/* All stages of a step h, the last at its end; a callback's code. */
static int stages(nsdae_runge_kutta *rk, double h)
{
  int code = 0;
  memcpy(rk->k[0], rk->k[6], (size_t)rk->n * sizeof *rk->sum);
  for (int s = 1; s < STAGES && code == 0; s++) {
    int last = s == STAGES - 1, n = last ? rk->n : rk->controlled; /* what f depends on */
    if (last) memcpy(rk->dense[4], rk->trial, (size_t)rk->controlled * sizeof *rk->sum);
    combine(rk, n, s, a[s]);
    nsdae_move(n, rk->y, h, rk->sum, rk->trial);
    code = rate(rk, rk->t + c[s] * h, rk->trial, s != 1, rk->k[s]); /* k_2 has no weight in y_1 */
  }
  return code;
}

/* h |lambda|, from the two stages at the step's end; the earlier one's point is in dense[4]. */
static void watch_stability(nsdae_runge_kutta *rk, double h)
{
  double change = 0, way = 0;
  for (int i = 0; i < rk->controlled; i++) {
    change += (rk->k[6][i] - rk->k[5][i]) * (rk->k[6][i] - rk->k[5][i]);
    way += (rk->trial[i] - rk->dense[4][i]) * (rk->trial[i] - rk->dense[4][i]);
  }
  if (way > 0 && h * sqrt(change / way) > BORDER)
    rk->border++;
  else if (rk->border > 0)
    rk->border--;
}

/* The step becomes the last one; trial is y at its end. */
static void accept(nsdae_runge_kutta *rk, double h)
{
  watch_stability(rk, h);
  combine(rk, rk->n, STAGES, d);
  for (int i = 0; i < rk->n; i++) {
    double change = rk->trial[i] - rk->y[i], bend = h * rk->k[0][i] - change;
    rk->dense[0][i] = rk->y[i];
    rk->dense[1][i] = change;
    rk->dense[2][i] = bend;
    rk->dense[3][i] = change - h * rk->k[6][i] - bend;
    rk->dense[4][i] = h * rk->sum[i];
  }
  memcpy(rk->y, rk->trial, (size_t)rk->n * sizeof *rk->y);
  rk->t += h;
  rk->last = h;
  measure_way(rk);
}

int nsdae_runge_kutta_advance(nsdae_runge_kutta *rk)
{
  double most = MOST;
  nsdae_progress_begin(&rk->progress);
  for (int refused = 0; refused < REFUSALS; refused++) {
    double h = rk->h, error = HUGE_VAL;
    if (!(rk->t + h > rk->t)) break;
    int code = stages(rk, h);
    if (code < 0) return NSDAE_E_CALLBACK;
    if (code == 0) {
      combine(rk, rk->controlled + rk->forces, STAGES, e);
      error = fmax(h * norm(rk, rk->sum), impulse_error(rk, h));
    }
    double factor = error > 0 ? SAFETY * pow(error, -0.2) : MOST;
    rk->h = fmin(rk->max_step, h * fmax(LEAST, fmin(most, factor)));
    if (error <= 1) {
      accept(rk, h);
      return NSDAE_OK;
    }
    most = 1; /* after a refusal no step grows */
    memcpy(rk->k[6], rk->k[0], (size_t)rk->n * sizeof *rk->sum);
  }
  return rk->progress.refused ? NSDAE_E_CALLBACK : NSDAE_E_CONVERGENCE;
}

void nsdae_runge_kutta_retreat(nsdae_runge_kutta *rk, double t, double part)
{
  memcpy(rk->y, rk->dense[0], (size_t)rk->n * sizeof *rk->y);
  memcpy(rk->k[6], rk->k[0], (size_t)rk->n * sizeof *rk->sum);
  rk->h = part * rk->last;
  rk->t = t;
  rk->last = 0;
  measure_way(rk);
}

int nsdae_runge_kutta_land(nsdae_runge_kutta *rk, double from, double t)
{
  nsdae_runge_kutta_retreat(rk, from, 1);
  int code = stages(rk, t - from);
  if (code != 0) return code;
  accept(rk, t - from);
  rk->t = t;
  return 0;
}

void nsdae_runge_kutta_read(const nsdae_runge_kutta *rk, double t, int count, double *y)
{
  double x = rk->last > 0 ? (t - (rk->t - rk->last)) / rk->last : 0, z = 1 - x;
  const double *const *r = (const double *const *)rk->dense;
  if (t == rk->t) {
    memcpy(y, rk->y, (size_t)count * sizeof *y);
    return;
  }
  for (int i = 0; i < count; i++)
    y[i] = r[0][i] + x * (r[1][i] + z * (r[2][i] + x * (r[3][i] + z * r[4][i])));
}

int nsdae_runge_kutta_stiff(const nsdae_runge_kutta *rk)
{
  return rk->border >= STIFF;
}
