#include "dip.h"

#include <float.h>
#include <math.h>

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
