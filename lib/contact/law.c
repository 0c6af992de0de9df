#include "law.h"

#include <math.h>

#include <nsdae/contact.h>

/* cos and sin of a turn leave 6e-17 where there is nothing: a direction of its own to friction. */
static double clean(double value)
{
  return fabs(value) < 1e-15 ? 0 : value;
}

void nsdae_law_edges(int edges, double *edge)
{
  const double turn = 6.283185307179586477;
  for (int j = 0; j < edges; j++) {
    edge[2 * j] = clean(cos(turn * j / edges));
    edge[2 * j + 1] = clean(sin(turn * j / edges));
  }
}

int nsdae_law_rows(int nt, double mu, int edges)
{
  if (nt == 0 || mu == 0) return 1;
  return nt == 1 || edges == 0 ? 3 : edges + 2;
}

nsdae_law nsdae_law_make(int nt, double mu, int edges, const double *edge)
{
  nsdae_law_kind kind = nt == 0 || mu == 0 ? NSDAE_FRICTIONLESS
                        : nt == 1          ? NSDAE_PLANAR
                        : edges == 0       ? NSDAE_CONE
                                           : NSDAE_POLYGON;
  return (nsdae_law){.kind = kind,
                     .columns = kind == NSDAE_FRICTIONLESS ? 1 : 1 + nt,
                     .rows = nsdae_law_rows(nt, mu, edges),
                     .mu = mu,
                     .edge = edge};
}

nsdae_law nsdae_law_sliding(int nt, double mu, const double *d)
{
  nsdae_law law = {.kind = NSDAE_SLIDING, .columns = 1 + nt, .rows = 1, .mu = mu};
  for (int l = 0; l < nt; l++) law.d[l] = d[l];
  return law;
}

/* Sums in the order of x, from zero: bits of a solution depend on it. */
double nsdae_law_impulse(const nsdae_law *law, const double *x, double *impulse)
{
  double size = fabs(x[0]), terms[2] = {0};
  impulse[0] = x[0];
  for (int l = 1; l < law->columns; l++) {
    double *F = impulse + l;
    *F = 0;
    if (law->kind == NSDAE_PLANAR) {
      *F = -law->mu * x[0] + x[1];
      terms[0] = fabs(law->mu * x[0]) + fabs(x[1]);
    } else if (law->kind == NSDAE_SLIDING) {
      *F = -law->mu * law->d[l - 1] * x[0];
      terms[l - 1] = fabs(*F);
    } else if (law->kind == NSDAE_CONE) {
      *F = x[l];
      terms[l - 1] = fabs(*F);
    }
    for (int j = 1; law->kind == NSDAE_POLYGON && j < law->rows - 1; j++) {
      *F += law->edge[2 * (j - 1) + l - 1] * x[j];
      terms[l - 1] += fabs(law->edge[2 * (j - 1) + l - 1] * x[j]);
    }
  }
  return fmax(size, fmax(terms[0], terms[1]));
}

void nsdae_law_times_impulse(const nsdae_law *law, const double *g, size_t apart, double *row)
{
  row[0] = g[0];
  if (law->kind == NSDAE_PLANAR) {
    row[0] -= law->mu * g[apart];
    row[1] = g[apart];
    row[2] = 0;
  } else if (law->kind == NSDAE_SLIDING) {
    for (int l = 1; l < law->columns; l++)
      row[0] += g[(size_t)l * apart] * (-law->mu * law->d[l - 1]);
  } else if (law->kind == NSDAE_CONE) {
    row[1] = g[apart];
    row[2] = g[2 * apart];
  } else if (law->kind == NSDAE_POLYGON) {
    for (int j = 1; j < law->rows - 1; j++)
      row[j] = g[apart] * law->edge[2 * j - 2] + g[2 * apart] * law->edge[2 * j - 1];
    row[law->rows - 1] = 0;
  }
}

void nsdae_law_velocity(const nsdae_law *law, const double *xi, double *y)
{
  y[0] = xi[0];
  if (law->kind == NSDAE_PLANAR || law->kind == NSDAE_CONE) y[1] = xi[1];
  if (law->kind == NSDAE_PLANAR) y[2] = 0;
  if (law->kind == NSDAE_CONE) y[2] = xi[2];
  if (law->kind != NSDAE_POLYGON) return;
  for (int j = 1; j < law->rows - 1; j++)
    y[j] = xi[1] * law->edge[2 * j - 2] + xi[2] * law->edge[2 * j - 1];
  y[law->rows - 1] = 0;
}

void nsdae_law_add_coupling(const nsdae_law *law, double *A, int lda)
{
  int last = law->rows - 1;
  if (law->kind == NSDAE_PLANAR) {
    A[2 * lda + 1] += 1; /* xi_L in xi_R */
    A[2] += 2 * law->mu; /* Lambda_N in Lambda_L */
    A[lda + 2] -= 1;     /* Lambda_R in Lambda_L */
  } else if (law->kind == NSDAE_POLYGON) {
    A[last] += law->mu; /* Lambda_N in the friction margin */
    for (int j = 1; j < last; j++) {
      A[last * lda + j] += 1; /* gamma */
      A[j * lda + last] -= 1; /* Lambda_D in the friction margin */
    }
  }
}

int nsdae_law_mode(const nsdae_law *law, const double *x)
{
  if (!(x[0] > 0)) return NSDAE_MODE_OPEN;
  /* stick: Lambda_R and Lambda_L may both be positive, xi_R and xi_L are zero */
  if (law->kind == NSDAE_PLANAR) return x[1] > 0 && x[2] == 0 ? NSDAE_MODE_STICK : NSDAE_MODE_SLIP;
  if (law->kind == NSDAE_POLYGON) return x[law->rows - 1] > 0 ? NSDAE_MODE_SLIP : NSDAE_MODE_STICK;
  return NSDAE_MODE_SLIP;
}
