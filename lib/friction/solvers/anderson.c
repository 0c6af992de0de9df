#include "anderson.h"

#include <string.h>

#include "simd.h"

enum { WINDOW = NSDAE_FC_WINDOW };

/* Growth of |f|^2 from sweep to sweep at which the method restarts. With 1 and 4 the work of 108
 * warm starts is 1.11 and 1.00 times as much. */
static const double GROWN = 2;

/* A column is dependent if the others leave less than this share of its square. With 1e-8 and 1e-12
 * the same sweeps follow. */
static const double DEPENDENT = 1e-10;

void nsdae_fc_anderson_layout(nsdae_fc_anderson *s, const nsdae_fc_scaled *c, nsdae_arena *arena)
{
  long n = 3L * c->n, ny = c->local ? 0 : c->ny;
  nsdae_arena_doubles(arena, n, (double **[]){&s->before, &s->f, &s->g, NULL});
  nsdae_arena_doubles(arena, WINDOW * n, (double **[]){&s->F, &s->G, NULL});
  s->y = NSDAE_ARENA_DOUBLES(arena, ny);
  s->Y = NSDAE_ARENA_DOUBLES(arena, WINDOW * ny);
}

void nsdae_fc_anderson_begin(nsdae_fc_anderson *s)
{
  s->held = s->next = s->begun = 0;
}

NSDAE_INLINED double *column(double *A, int rows, int k)
{
  return A + (size_t)k * (size_t)rows;
}

/* x -= A c; columns that are not held have c = 0. */
NSDAE_INLINED void subtract(int n, double *A, int held, const double *c, double *x)
{
  const double *a[WINDOW];
  double by[WINDOW];
  int i = 0;
  for (int k = 0; k < WINDOW; k++) {
    a[k] = column(A, n, k < held ? k : 0);
    by[k] = k < held ? c[k] : 0;
  }
  for (; i + 4 <= n; i += 4) {
    nsdae_four sum = by[0] * *(const nsdae_four *)(a[0] + i);
    for (int k = 1; k < WINDOW; k++) sum += by[k] * *(const nsdae_four *)(a[k] + i);
    *(nsdae_four *)(x + i) -= sum;
  }
  for (; i < n; i++) {
    double sum = by[0] * a[0][i];
    for (int k = 1; k < WINDOW; k++) sum += by[k] * a[k][i];
    x[i] -= sum;
  }
}

/* to = x - before, before = x */
NSDAE_INLINED void difference(int n, const double *x, double *before, double *to)
{
  int i = 0;
  for (; i + 4 <= n; i += 4) {
    nsdae_four now = *(const nsdae_four *)(x + i);
    *(nsdae_four *)(to + i) = now - *(const nsdae_four *)(before + i);
    *(nsdae_four *)(before + i) = now;
  }
  for (; i < n; i++) {
    to[i] = x[i] - before[i];
    before[i] = x[i];
  }
}

/* x := A^-1 x, A positive semidefinite, by LDL^T without pivoting; dependent columns get x = 0. */
static void solve_gram(int m, const double *gram, double *x)
{
  double A[WINDOW * WINDOW];
  memcpy(A, gram, sizeof A);
  for (int k = 0; k < m; k++) {
    double pivot = A[k * WINDOW + k];
    int use = pivot > DEPENDENT * gram[k * WINDOW + k];
    for (int i = k + 1; i < m; i++) {
      double by = use ? A[i * WINDOW + k] / pivot : 0;
      for (int j = k + 1; j < m; j++) A[i * WINDOW + j] -= by * A[k * WINDOW + j];
      x[i] -= by * x[k];
    }
    A[k * WINDOW + k] = use ? pivot : 0;
  }
  for (int k = m - 1; k >= 0; k--) {
    for (int j = k + 1; j < m; j++) x[k] -= A[k * WINDOW + j] * x[j];
    x[k] = A[k * WINDOW + k] > 0 ? x[k] / A[k * WINDOW + k] : 0;
  }
}

NSDAE_INLINED void collect_lanes(nsdae_fc_anderson *s, nsdae_fc_scaled *c)
{
  int n = 3 * c->n, ny = c->local ? 0 : c->ny, j = s->next;
  double *f = s->before;
  nsdae_simd_subtract(n, c->r, f, f);
  double square = nsdae_simd_dot(n, f, f);
  if (s->begun && square <= GROWN * s->square) {
    /* The differences between this sweep, which changed r by f, and the one before. */
    double *F = column(s->F, n, j);
    difference(n, f, s->f, F);
    difference(n, c->r, s->g, column(s->G, n, j));
    difference(ny, c->y, s->y, column(s->Y, ny, j));
    if (s->held < WINDOW) s->held++;
    s->next = (j + 1) % WINDOW;
    for (int k = 0; k < s->held; k++)
      s->gram[j * WINDOW + k] = s->gram[k * WINDOW + j] = nsdae_simd_dot(n, column(s->F, n, k), F);
  } else {
    s->held = s->next = 0;
    memcpy(s->f, f, (size_t)n * sizeof *f);
    memcpy(s->g, c->r, (size_t)n * sizeof *f);
    memcpy(s->y, c->y, (size_t)ny * sizeof *f);
  }
  s->begun = 1;
  s->square = square;
  s->left = 1;
}

NSDAE_INLINED void extrapolate_lanes(nsdae_fc_anderson *s, nsdae_fc_scaled *c)
{
  int n = 3 * c->n, ny = c->local ? 0 : c->ny;
  double product[WINDOW];
  if (s->held == 0) return;
  for (int k = 0; k < s->held; k++)
    s->share[k] = product[k] = nsdae_simd_dot(n, column(s->F, n, k), s->f);
  solve_gram(s->held, s->gram, s->share);
  for (int k = 0; k < s->held; k++) s->left -= s->share[k] * product[k] / s->square;
  subtract(n, s->G, s->held, s->share, c->r);
  subtract(ny, s->Y, s->held, s->share, c->y);
}

NSDAE_DISPATCH("avx2", collect, collect_lanes, (nsdae_fc_anderson * s, nsdae_fc_scaled *c), (s, c))

NSDAE_DISPATCH("avx2", extrapolate, extrapolate_lanes, (nsdae_fc_anderson * s, nsdae_fc_scaled *c),
               (s, c))

double nsdae_fc_anderson_sweep(nsdae_fc_anderson *s, nsdae_fc_scaled *c, double *slip)
{
  memcpy(s->before, c->r, 3 * (size_t)c->n * sizeof *c->r);
  double change = nsdae_fc_sweep(c, slip);
  collect(s, c);
  return change;
}

void nsdae_fc_anderson_collect(nsdae_fc_anderson *s, nsdae_fc_scaled *c)
{
  collect(s, c);
}

void nsdae_fc_anderson_extrapolate(nsdae_fc_anderson *s, nsdae_fc_scaled *c)
{
  extrapolate(s, c);
}

void nsdae_fc_anderson_remainder(nsdae_fc_anderson *s, const nsdae_fc_scaled *c)
{
  subtract(3 * c->n, s->F, s->held, s->share, s->before);
}
