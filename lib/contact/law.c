#include "law.h"

#include <math.h>

#include <nsdae/contact.h>

#include "vector.h"

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

nsdae_law nsdae_law_sliding(int nt, double mu, const double *d)
{
  nsdae_law law = {.kind = NSDAE_SLIDING, .columns = 1 + nt, .rows = 1, .mu = mu};
  for (int l = 0; l < nt; l++) law.d[l] = d[l];
  return law;
}

/* E_Q of entry l of the impulse; with mu = 0 it is E_P. */
static inline double entry(const nsdae_law *law, double mu, int l, int row)
{
  if (l == 0) return row == 0;
  if (law->kind == NSDAE_CONE) return row == l;
  if (row == 0)
    return law->kind == NSDAE_PLANAR ? -mu : law->kind == NSDAE_SLIDING ? -mu * law->d[l - 1] : 0;
  if (law->kind == NSDAE_PLANAR) return row == 1;
  return row < law->rows - 1 ? law->edge[2 * (row - 1) + l - 1] : 0;
}

double nsdae_law_impulse(const nsdae_law *law, const double *x, double *impulse)
{
  double size = fabs(x[0]);
  impulse[0] = x[0];
  if (law->kind == NSDAE_PLANAR) { /* the most of many */
    impulse[1] = x[1] - law->mu * x[0];
    return nsdae_larger(size, fabs(law->mu * x[0]) + fabs(x[1]));
  }
  for (int l = 1; l < law->columns; l++) {
    double terms = 0;
    impulse[l] = 0;
    for (int i = 0; i < law->rows; i++) {
      double term = entry(law, law->mu, l, i) * x[i];
      impulse[l] += term;
      terms += fabs(term);
    }
    size = fmax(size, terms);
  }
  return size;
}

void nsdae_law_times_impulse(const nsdae_law *law, const double *g, size_t apart, double *row)
{
  for (int i = 0; i < law->rows; i++) {
    row[i] = 0;
    for (int l = 0; l < law->columns; l++)
      row[i] += g[(size_t)l * apart] * entry(law, law->mu, l, i);
  }
}

void nsdae_law_velocity(const nsdae_law *law, const double *xi, double *y)
{
  y[0] = xi[0];
  if (law->kind == NSDAE_PLANAR) { /* the most of many */
    y[1] = xi[1];
    y[2] = 0;
    return;
  }
  for (int i = 1; i < law->rows; i++) {
    y[i] = 0;
    for (int l = 1; l < law->columns; l++) y[i] += xi[l] * entry(law, 0, l, i);
  }
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
