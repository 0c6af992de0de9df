#include "conjugate.h"

#include <string.h>

#include "sweep.h"

void nsdae_fc_conjugate_layout(nsdae_fc_conjugate *s, const nsdae_fc *c, nsdae_arena *arena)
{
  s->before = NSDAE_ARENA_DOUBLES(arena, 3L * c->n);
  s->direction = NSDAE_ARENA_DOUBLES(arena, 3L * c->n);
  s->y_before = NSDAE_ARENA_DOUBLES(arena, c->local ? 0 : c->ny);
  s->y_direction = NSDAE_ARENA_DOUBLES(arena, c->local ? 0 : c->ny);
}

void nsdae_fc_conjugate_begin(nsdae_fc_conjugate *s)
{
  s->square = 0;
}

double nsdae_fc_conjugate_sweep(nsdae_fc_conjugate *s, nsdae_fc *c, double *slip)
{
  memcpy(s->before, c->r, 3 * (size_t)c->n * sizeof *c->r);
  if (!c->local) memcpy(s->y_before, c->y, (size_t)c->ny * sizeof *c->y);
  return nsdae_fc_sweep(c, 1, slip);
}

/* x += b p,  p := b p + (x - before) of the x before that. */
static void extrapolate(size_t n, double b, const double *before, double *p, double *x)
{
  for (size_t i = 0; i < n; i++) {
    double along = b > 0 ? b * p[i] : 0, g = x[i] - before[i];
    x[i] += along;
    p[i] = along + g;
  }
}

void nsdae_fc_conjugate_extrapolate(nsdae_fc_conjugate *s, nsdae_fc *c)
{
  double square = 0;
  for (size_t i = 0; i < 3 * (size_t)c->n; i++) {
    double g = c->r[i] - s->before[i];
    square += g * g;
  }
  double b = s->square > 0 && square <= s->square ? square / s->square : 0;
  extrapolate(3 * (size_t)c->n, b, s->before, s->direction, c->r);
  if (!c->local) extrapolate((size_t)c->ny, b, s->y_before, s->y_direction, c->y);
  s->square = square;
}
