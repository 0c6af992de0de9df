#include "newton_step.h"

#include <math.h>
#include <string.h>

#include "natural_map.h"

void nsdae_fc_newton_layout(nsdae_fc_newton *s, nsdae_arena *arena)
{
  long n = s->fc->n;
  nsdae_arena_doubles(arena, 9 * n, (double **[]){&s->E, &s->A, NULL});
  nsdae_arena_doubles(arena, 3 * n,
                      (double **[]){&s->F, &s->dr, &s->trial, &s->centre, &s->u, NULL});
  s->y = NSDAE_ARENA_DOUBLES(arena, s->fc->ny);
}

double nsdae_fc_newton_map(nsdae_fc_newton *s, const double *r, const double *u, int derivatives)
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

double nsdae_fc_newton_step(nsdae_fc_newton *s, double before)
{
  nsdae_fc_scaled *c = s->fc;
  size_t m = 3 * (size_t)c->n;
  double now = INFINITY, length = 1;
  nsdae_fc_newton_map(s, c->r, c->u, 1);
  if (nsdae_fc_system_factor(s->system, s->E, s->A) != 0) return NAN;
  nsdae_fc_system_solve(s->system, s->F, s->dr);
  for (int k = 0; k < 8; k++, length /= 2) {
    for (size_t i = 0; i < m; i++) s->trial[i] = c->r[i] - length * s->dr[i];
    nsdae_fc_velocities(c, s->trial, s->y, s->u);
    now = nsdae_fc_newton_map(s, s->trial, s->u, 0);
    if (s->search ? now <= (1 - 1e-4 * length) * before : now < INFINITY) break;
  }
  if (!(now < INFINITY)) return NAN;
  memcpy(c->r, s->trial, m * sizeof *c->r);
  memcpy(c->u, s->u, m * sizeof *c->u);
  if (!c->local) memcpy(c->y, s->y, (size_t)c->ny * sizeof *c->y);
  return now;
}
