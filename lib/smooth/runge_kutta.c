#include "runge_kutta.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "vector.h"

enum { REFUSALS = 100 };

/* Of the step that the error's estimate asks for; how much it may change from one to the next. */
static const double SAFETY = 0.9, LEAST = 0.2, MOST = 10;

/* |h lambda| near the border of stability (Hairer and Wanner II, IV.2), in parts of it, and how
 * many such steps tell: those whose lambda falls as 1 / t, as where a body begins to slide, are
 * fewer. */
static const double BORDER = 0.6;
enum { STIFF = 150 };

void nsdae_runge_kutta_layout(nsdae_runge_kutta *rk, nsdae_arena *arena)
{
  for (int i = 0; i < NSDAE_TABLEAU_WIDTH; i++) rk->k[i] = NSDAE_ARENA_DOUBLES(arena, rk->n);
  for (int i = 0; i < NSDAE_TABLEAU_DENSE; i++) rk->dense[i] = NSDAE_ARENA_DOUBLES(arena, rk->n);
  nsdae_arena_doubles(arena, rk->n, (double **[]){&rk->y, &rk->trial, &rk->sum, NULL});
}

/* f at t. */
static double *rate_here(const nsdae_runge_kutta *rk)
{
  return rk->k[rk->pair->stages];
}

/* The way of the positions, at the rates of where it is. */
static void measure_way(nsdae_runge_kutta *rk)
{
  rk->way = rk->span * nsdae_largest(rk->positions, rate_here(rk));
}

/* Integrals are not fed back: their error does not grow. */
static const double INTEGRAL = 10;

/* ||x|| with the weights of the larger of y and `other`; NaN and overflow are as large as can be.
 */
static double norm(const nsdae_runge_kutta *rk, const double *other, const double *x)
{
  double sum = 0;
  for (int i = 0; i < rk->controlled; i++) {
    double scale = fmax(fabs(rk->y[i]), fabs(other[i]));
    if (i < rk->positions && rk->way < scale) scale = rk->way;
    double part = x[i] / (rk->rtol * scale + rk->atol);
    sum += part * part;
  }
  return isfinite(sum) ? sqrt(sum / rk->controlled) : HUGE_VAL;
}

/* The largest error of a force's impulse over a step h, over h, in parts of INTEGRAL rtol of what
 * the largest force makes in a span: one that jumps within the step, as past the end of
 * an edge, shows there alone if the motion does not depend on it. */
static double impulse_error(const nsdae_runge_kutta *rk)
{
  int first = rk->controlled, count = rk->forces;
  double size =
      fmax(nsdae_largest(count, rk->k[0] + first), nsdae_largest(count, rate_here(rk) + first));
  double error = nsdae_largest(count, rk->sum + first);
  size = fmax(size, rk->force) * rk->span;
  return error > 0 ? error / (INTEGRAL * rk->rtol * size) : 0;
}

/* sum := sum_j weight_j k_j, of the first n, two terms at a time; where a weight is zero k_j may
 * not be there */
static void combine(nsdae_runge_kutta *rk, int n, int count, const double *weight)
{
  double *restrict sum = rk->sum;
  const double w = weight[0], *k = rk->k[0];
  for (int i = 0; i < n; i++) sum[i] = w * k[i];
  for (int j = 1, l; j < count; j = l + 1) {
    if (weight[l = j] == 0) continue;
    do l++;
    while (l < count && weight[l] == 0);
    const double x = weight[j], y = l < count ? weight[l] : 0, *m = rk->k[l < count ? l : j];
    k = rk->k[j];
    for (int i = 0; i < n; i++) sum[i] = sum[i] + x * k[i] + y * m[i];
  }
}

/* Of two estimates: see runge_kutta.h. */
static double joint(double five, double three)
{
  if (!isfinite(five) || !isfinite(three)) return HUGE_VAL;
  return five > 0 ? five * (five / hypot(five, 0.1 * three)) : 0;
}

static double error_of(nsdae_runge_kutta *rk, double h)
{
  int n = rk->controlled + rk->forces, count = rk->pair->stages + 1;
  combine(rk, n, count, rk->pair->e5);
  double motion = norm(rk, rk->trial, rk->sum), impulse = impulse_error(rk);
  if (rk->pair->e3) {
    combine(rk, n, count, rk->pair->e3);
    motion = joint(motion, norm(rk, rk->trial, rk->sum));
    impulse = joint(impulse, impulse_error(rk));
  }
  return h * fmax(motion, impulse);
}

static int rate(nsdae_runge_kutta *rk, double t, const double *y, int whole, double *ydot)
{
  return nsdae_progress_note(&rk->progress, rk->rate(t, y, ydot, whole, rk->user));
}

/* Of the first step by its rule: the next step before the start is not shorter than that to be of
 * use. */
static const double HINT = 0.03;

/* The first step's length (Hairer, Norsett and Wanner, II.4), with k[1] for f after a short one; or
 * that of the next step before the start, as restarts by events change it less. */
static int first_step(nsdae_runge_kutta *rk)
{
  const double *f = rate_here(rk);
  double size = norm(rk, rk->y, rk->y), slope = norm(rk, rk->y, f);
  double h = size < 1e-5 || slope < 1e-5 ? 1e-6 : 0.01 * size / slope;
  h = fmin(fmax(h, 64 * DBL_EPSILON * fabs(rk->t)), rk->max_step);
  nsdae_move(rk->controlled, rk->y, h, f, rk->trial);
  int code = rate(rk, rk->t + h, rk->trial, 0, rk->k[1]);
  for (int i = 0; i < rk->controlled && code == 0; i++) rk->sum[i] = (rk->k[1][i] - f[i]) / h;
  double hint = rk->h, curve = code == 0 ? fmax(slope, norm(rk, rk->y, rk->sum)) : HUGE_VAL;
  rk->h =
      fmin(rk->max_step, fmin(100 * h, curve <= 1e-15    ? fmax(1e-6, h * 1e-3)
                                       : isfinite(curve) ? pow(0.01 / curve, 1.0 / rk->pair->order)
                                                         : h));
  if (hint < rk->h && hint > HINT * rk->h) rk->h = hint;
  return code < 0 ? nsdae_progress_status(code) : NSDAE_OK;
}

int nsdae_runge_kutta_start(nsdae_runge_kutta *rk, double t, const double *y)
{
  rk->progress = (nsdae_progress){0};
  rk->t = rk->from = t;
  rk->last = 0;
  rk->border = rk->is_dense = 0;
  memcpy(rk->y, y, (size_t)rk->n * sizeof *y);
  memcpy(rk->dense[0], y, (size_t)rk->n * sizeof *y);
  int code = rate(rk, t, rk->y, 1, rate_here(rk));
  if (code != 0) return nsdae_progress_status(code);
  measure_way(rk);
  return first_step(rk);
}

/* Stage s of a step h from y, the first n of its point in trial; a callback's code. */
static int stage(nsdae_runge_kutta *rk, double t, const double *y, double h, int n, int s)
{
  combine(rk, n, s, rk->pair->a[s]);
  nsdae_move(n, y, h, rk->sum, rk->trial);
  return rate(rk, t + rk->pair->c[s] * h, rk->trial, s > rk->pair->part, rk->k[s]);
}

/* All stages of a step h, the last at its end; a callback's code. */
static int stages(nsdae_runge_kutta *rk, double h)
{
  int code = 0, last = rk->pair->stages;
  size_t controlled = (size_t)rk->controlled; /* what f depends on */
  rk->is_dense = 0;
  memcpy(rk->k[0], rk->k[last], (size_t)rk->n * sizeof *rk->sum);
  for (int s = 1; s < last && code == 0; s++) code = stage(rk, rk->t, rk->y, h, rk->controlled, s);
  memcpy(rk->dense[1], rk->trial, controlled * sizeof *rk->sum);
  return code != 0 ? code : stage(rk, rk->t, rk->y, h, rk->n, last);
}

/* The step becomes the last one; trial is y at its end. */
static void accept(nsdae_runge_kutta *rk, double h)
{
  /* h |lambda|, from the two stages at the step's end; the earlier one's point is in dense[1]. */
  const double *f = rate_here(rk), *before = rk->k[rk->pair->stages - 1];
  double change = 0, way = 0;
  for (int i = 0; i < rk->controlled; i++) {
    change += (f[i] - before[i]) * (f[i] - before[i]);
    way += (rk->trial[i] - rk->dense[1][i]) * (rk->trial[i] - rk->dense[1][i]);
  }
  if (way > 0 && h * sqrt(change / way) > BORDER * rk->pair->border)
    rk->border++;
  else if (rk->border > 0)
    rk->border--;
  memcpy(rk->dense[0], rk->y, (size_t)rk->n * sizeof *rk->y);
  memcpy(rk->y, rk->trial, (size_t)rk->n * sizeof *rk->y);
  rk->from = rk->t;
  rk->t += h;
  rk->last = h;
  measure_way(rk);
}

/* Of the last coefficient of DOP853's extension, which counts for x^4 (1 - x)^3 <= 0.0083 of it, in
 * the norm of the error. Smooth systems have 2e3 at most (measured at rtol 1e-5 to 1e-12); a kink
 * of f that the error's estimate of a step allows may have 1e7, as the coefficients d are large. */
static const double ROUGH = 1e3;

int nsdae_runge_kutta_is_rough(const nsdae_runge_kutta *rk)
{
  return rk->pair == &nsdae_dop853 && rk->is_dense && rk->rough > ROUGH;
}

/* The continuous extension of the last step (II.6; II.10 for the order 8). */
static int make_dense(nsdae_runge_kutta *rk)
{
  const nsdae_tableau *p = rk->pair;
  double h = rk->last;
  int code = 0;
  if (rk->is_dense) return NSDAE_OK;
  for (int s = p->stages + 1; s < p->all && code == 0; s++)
    code = stage(rk, rk->from, rk->dense[0], h, rk->controlled, s);
  if (code != 0) return code < 0 ? nsdae_progress_status(code) : NSDAE_E_CONVERGENCE;
  for (int i = 0; i < rk->n; i++) {
    double change = rk->y[i] - rk->dense[0][i], bend = h * rk->k[0][i] - change;
    rk->dense[1][i] = change;
    rk->dense[2][i] = bend;
    rk->dense[3][i] = change - h * rk->k[p->stages][i] - bend;
  }
  for (int j = 4; j < p->dense; j++) {
    combine(rk, rk->n, p->all, p->d[j - 4]);
    for (int i = 0; i < rk->n; i++) rk->dense[j][i] = h * rk->sum[i];
  }
  rk->is_dense = 1;
  rk->rough = h * fmax(norm(rk, rk->dense[0], rk->sum), INTEGRAL * impulse_error(rk));
  return NSDAE_OK;
}

int nsdae_runge_kutta_advance(nsdae_runge_kutta *rk)
{
  double most = MOST;
  nsdae_progress_begin(&rk->progress);
  for (int refused = 0; refused < REFUSALS; refused++) {
    double h = rk->h, error = HUGE_VAL;
    if (!(rk->t + h > rk->t)) break;
    int code = stages(rk, h);
    if (code == 0) error = error_of(rk, h);
    double factor = error > 0 ? SAFETY * pow(error, -1.0 / rk->pair->order) : MOST;
    rk->h = fmin(rk->max_step, h * fmax(LEAST, fmin(most, factor)));
    if (error <= 1) {
      accept(rk, h);
      return NSDAE_OK;
    }
    most = 1; /* after a refusal no step grows */
    memcpy(rate_here(rk), rk->k[0], (size_t)rk->n * sizeof *rk->sum);
    if (code < 0) break;
  }
  rk->last = 0; /* its stages are lost */
  if (rk->progress.failed) return nsdae_progress_status(rk->progress.failed);
  return rk->progress.refused ? NSDAE_E_CALLBACK : NSDAE_E_CONVERGENCE;
}

void nsdae_runge_kutta_retreat(nsdae_runge_kutta *rk, double part)
{
  memcpy(rk->y, rk->dense[0], (size_t)rk->n * sizeof *rk->y);
  memcpy(rate_here(rk), rk->k[0], (size_t)rk->n * sizeof *rk->sum);
  rk->h = part * rk->last;
  rk->t = rk->from;
  rk->last = 0;
  measure_way(rk);
}

int nsdae_runge_kutta_land(nsdae_runge_kutta *rk, double t)
{
  double from = rk->from, next = rk->h;
  nsdae_runge_kutta_retreat(rk, 1);
  rk->h = next;
  int code = stages(rk, t - from);
  if (code != 0) return code;
  accept(rk, t - from);
  rk->t = t;
  return 0;
}

int nsdae_runge_kutta_read(nsdae_runge_kutta *rk, double t, int count, double *y)
{
  const double *at = t == rk->t ? rk->y : rk->dense[0];
  int inside = t != rk->t && t != rk->from && rk->last > 0;
  int status = inside ? make_dense(rk) : NSDAE_OK;
  double x = inside ? (t - rk->from) / rk->last : 0;
  if (status < 0) return status;
  for (int i = 0; i < count; i++) {
    double sum = 0;
    for (int j = rk->pair->dense - 1; j > 0 && inside; j--)
      sum = (rk->dense[j][i] + sum) * (j % 2 ? x : 1 - x);
    y[i] = at[i] + sum;
  }
  return NSDAE_OK;
}

int nsdae_runge_kutta_stiff(const nsdae_runge_kutta *rk)
{
  return rk->border >= STIFF;
}
