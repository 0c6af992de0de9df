#include "law.h"

#include <math.h>

#include <nsdae/contact.h>

static nsdae_law frictionless(void)
{
  nsdae_law law = {.kind = NSDAE_FRICTIONLESS, .columns = 1, .rows = 1};
  law.E_Q[0][0] = law.E_P[0][0] = 1;
  return law;
}

static nsdae_law planar(double mu)
{
  nsdae_law law = {.kind = NSDAE_PLANAR, .columns = 2, .rows = 3, .mu = mu};
  law.E_Q[0][0] = law.E_P[0][0] = 1;
  law.E_Q[1][0] = -mu;
  law.E_Q[1][1] = law.E_P[1][1] = 1;
  return law;
}

/* cos and sin of a turn leave 6e-17 where there is nothing: a direction of its own to friction. */
static double clean(double value)
{
  return fabs(value) < 1e-15 ? 0 : value;
}

static nsdae_law polygon(double mu, int edges)
{
  const double turn = 6.283185307179586477;
  nsdae_law law = {.kind = NSDAE_POLYGON, .columns = 3, .rows = edges + 2, .mu = mu};
  law.E_Q[0][0] = law.E_P[0][0] = 1;
  for (int j = 0; j < edges; j++) {
    law.E_Q[1][1 + j] = law.E_P[1][1 + j] = clean(cos(turn * j / edges));
    law.E_Q[2][1 + j] = law.E_P[2][1 + j] = clean(sin(turn * j / edges));
  }
  return law;
}

static nsdae_law cone(double mu)
{
  nsdae_law law = {.kind = NSDAE_CONE, .columns = 3, .rows = 3, .mu = mu};
  for (int j = 0; j < 3; j++) law.E_Q[j][j] = law.E_P[j][j] = 1;
  return law;
}

int nsdae_law_rows(int nt, double mu, int edges)
{
  if (nt == 0 || mu == 0) return 1;
  return nt == 1 || edges == 0 ? 3 : edges + 2;
}

nsdae_law nsdae_law_make(int nt, double mu, int edges)
{
  if (nt == 0 || mu == 0) return frictionless();
  if (nt == 1) return planar(mu);
  return edges == 0 ? cone(mu) : polygon(mu, edges);
}

nsdae_law nsdae_law_sliding(int nt, double mu, const double *d)
{
  nsdae_law law = {.kind = NSDAE_SLIDING, .columns = 1 + nt, .rows = 1, .mu = mu};
  law.E_Q[0][0] = law.E_P[0][0] = 1;
  for (int l = 0; l < nt; l++) law.E_Q[1 + l][0] = -mu * d[l];
  return law;
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
