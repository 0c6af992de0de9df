#include "dip.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* Of a time in a step: to the last digits. */
enum { BISECTIONS = 60 };

/* Of the way at the ends' rates, how far a cubic may be off within a piece of a step. */
static const double NEAR = 0.1;

void nsdae_dip_layout(nsdae_dip *p, nsdae_arena *arena)
{
  p->value = NSDAE_ARENA_DOUBLES(arena, (NSDAE_DIP_PIECES + 2L) * p->count);
  p->rate = NSDAE_ARENA_DOUBLES(arena, (NSDAE_DIP_PIECES + 2L) * p->count);
}

void nsdae_dip_start(nsdae_dip *p)
{
  p->known = NAN;
}

/* As the point number of the step. */
static int look(nsdae_dip *p, double t, int point)
{
  return p->look(t, p->value + point * p->count, p->rate + point * p->count, p->user);
}

/* Function i at t; its rate in *rate. */
static double value_at(nsdae_dip *p, int i, double t, double *rate, int *status)
{
  const int last = NSDAE_DIP_PIECES + 1;
  *status = look(p, t, last);
  *rate = p->rate[last * p->count + i];
  return p->value[last * p->count + i];
}

/* Where function i, above zero at low and falling at a, is below at b, or, above and rising there,
 * is below zero in between: its fall through zero, or INFINITY. Lowest point and fall by bisection.
 */
static double fall_of(nsdae_dip *p, int i, double low, double a, double b, double deep, int *status)
{
  double rate = 0, value = value_at(p, i, b, &rate, status);
  for (int n = 0; n < BISECTIONS && value > -deep && *status == 0; n++) {
    double t = (a + b) / 2;
    value = value_at(p, i, t, &rate, status);
    *(rate < 0 ? &a : &b) = t;
    if (value <= -deep) b = t;
  }
  if (value > -deep || *status < 0) return INFINITY;
  for (int n = 0; n < BISECTIONS && *status == 0; n++) {
    double t = (low + b) / 2;
    *(value_at(p, i, t, &rate, status) > 0 ? &low : &b) = t;
  }
  return b;
}

/* Whether the parabola through what is known at both ends, points first and first + 1 of the step,
 * could come near zero in between. */
static int may_touch(const nsdae_dip *p, int i, int first, double h)
{
  int k = p->count;
  const double *value = p->value + first * k + i, *rate = p->rate + first * k + i;
  if (value[0] > 0 && value[k] <= 0) return 1;
  if (!(value[0] > 0 && value[k] > 0 && rate[0] < 0 && rate[k] > 0)) return 0;
  return fmin(value[0], value[k]) < h * fmax(-rate[0], rate[k]);
}

/* A function that rises at both ends of a piece, but by less in between: the cubic through both
 * values and rates, v_0 + c s + b s^2 + a s^3 with s from 0 to 1, has a top and then a lowest
 * point. Whether that is near zero, and where the top is and a place between the two. */
static int has_hump(const nsdae_dip *p, int i, int first, double h, double *top, double *down)
{
  int k = p->count;
  const double *value = p->value + first * k + i, *rate = p->rate + first * k + i;
  double rise = value[k] - value[0], c = h * rate[0], a = h * (rate[0] + rate[k]) - 2 * rise;
  double b = 3 * rise - h * (2 * rate[0] + rate[k]), square = b * b - 3 * a * c;
  if (!(rate[0] > 0 && rate[k] > 0 && a > 0 && square > 0)) return 0;
  double s = (sqrt(square) - b) / (3 * a); /* the lowest */
  *top = (-sqrt(square) - b) / (3 * a);
  *down = (s + *top) / 2;
  double least = value[0] + s * (c + s * (b + s * a));
  double most = value[0] + *top * (c + *top * (b + *top * a));
  return *top > 0 && s < 1 && most > 0 && least < NEAR * h * fmax(rate[0], rate[k]);
}

/* Whether, at the rates of the step's ends, function i could come to zero within h. */
static int may_reach(const nsdae_dip *p, int i, double h)
{
  int end = NSDAE_DIP_PIECES * p->count + i;
  double fastest = fmax(fabs(p->rate[i]), fabs(p->rate[end]));
  return fmin(p->value[i], p->value[end]) < h * fastest;
}

/* Both ends of the step: its start is where the one before ended, if that is known. */
static int look_at_ends(nsdae_dip *p, double from, double to, int pieces)
{
  size_t size = (size_t)p->count * sizeof *p->value;
  const int end = NSDAE_DIP_PIECES * p->count; /* the last point is kept there, too */
  int status = 0;
  if (p->known == from) {
    memcpy(p->value, p->value + end, size);
    memcpy(p->rate, p->rate + end, size);
  } else {
    status = look(p, from, 0);
  }
  p->known = to;
  if (status == 0) status = look(p, to, NSDAE_DIP_PIECES);
  memmove(p->value + pieces * p->count, p->value + end, size);
  memmove(p->rate + pieces * p->count, p->rate + end, size);
  return status;
}

int nsdae_dip_find(nsdae_dip *p, double from, double to, int pieces, const int *out, double deep,
                   double *when, int *which)
{
  double h = (to - from) / pieces;
  int any = 0, status = 0;
  *when = INFINITY;
  for (int i = 0; i < p->count; i++) any |= !out[i];
  if (any) status = look_at_ends(p, from, to, pieces);
  any = 0;
  for (int i = 0; i < p->count && status == 0; i++) any |= !out[i] && may_reach(p, i, to - from);
  for (int j = 1; j < pieces && any && status == 0; j++) status = look(p, from + j * h, j);
  for (int i = 0; i < p->count && any && status == 0; i++)
    for (int piece = 0; piece < pieces && !out[i] && status == 0; piece++) {
      double top = 0, down = 0;
      if (!may_touch(p, i, piece, h) && !has_hump(p, i, piece, h, &top, &down)) continue;
      double a = from + piece * h, b = piece == pieces - 1 ? to : a + h;
      double t = fall_of(p, i, a + top * h, a + down * h, b, deep, &status);
      if (t < *when) *when = t, *which = i;
    }
  return status;
}

/* ---- fall */

enum { ROUNDS = 200 };

void nsdae_fall_layout(nsdae_fall *f, nsdae_arena *arena)
{
  nsdae_arena_doubles(arena, f->count, (double **[]){&f->low, &f->high, &f->middle, NULL});
}

static int falls(double before, double after)
{
  return before > 0 && !(after > 0);
}

/* The function that falls deepest for its height: its zero, by the secant, is the first or near. */
static int deepest(const nsdae_fall *f)
{
  double most = -1;
  int at = -1;
  for (int i = 0; i < f->count; i++) {
    double depth = falls(f->low[i], f->high[i]) ? -f->high[i] / (f->low[i] - f->high[i]) : -1;
    if (depth > most || (at < 0 && falls(f->low[i], f->high[i]))) at = i, most = depth;
  }
  return at;
}

/* Where the secant has its zero, with the value at low times weight; not nearer to an end than a
 * tenth of the bracket or what rounding allows. */
static double secant(double low, double high, double at_low, double at_high, double least)
{
  double t = high - (high - low) * at_high / (at_high - at_low);
  double margin = fmin(0.5 * (high - low), fmax(0.5 * least, 1e-3 * (high - low)));
  return fmin(fmax(t, low + margin), high - margin);
}

int nsdae_fall_find(nsdae_fall *f, double from, double *to, int *found)
{
  double low = from, high = *to, least = 100 * DBL_EPSILON * (fabs(*to) + (*to - from));
  double weight = 1;
  int code = f->values(high, f->high, f->user), side = 0, count = 0;
  if (code < 0) return code;
  for (int i = deepest(f), round = 0; i >= 0 && high - low > least && round < ROUNDS; round++) {
    double t = secant(low, high, weight * f->low[i], f->high[i], least);
    if (round > 20) t = low + (high - low) / 2;
    code = f->values(t, f->middle, f->user);
    if (code < 0) return code;
    int any = 0;
    for (int j = 0; j < f->count; j++) any |= falls(f->low[j], f->middle[j]);
    for (int j = 0; j < f->count; j++) (any ? f->high : f->low)[j] = f->middle[j];
    *(any ? &high : &low) = t;
    weight = side == (any ? 1 : 2) ? (any ? weight / 2 : weight * 2) : 1;
    side = any ? 1 : 2;
    i = deepest(f);
  }
  for (int i = 0; i < f->count; i++) count += found[i] = falls(f->low[i], f->high[i]);
  if (count > 0) *to = high;
  return count;
}
