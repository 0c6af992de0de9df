/* phi_i(x) = x_i + y_i - sqrt(x_i^2 + y_i^2), y = A x + b, is zero exactly where x_i >= 0, y_i >= 0
 * and x_i y_i = 0 (Fischer, Optimization 24, 1992). Levenberg-Marquardt steps on |phi|^2 / 2 with
 * backtracking (De Luca, Facchinei, Kanzow, Math. Program. 75, 1996): a stationary point need not
 * be a solution, so the result is judged by its residual like everything else. */
#include "lcp_methods.h"

#include <math.h>
#include <stddef.h>

#include "dense.h"
#include "vector.h"

typedef struct newton {
  int n;
  const double *A, *b;
  double *J, *H;                      /* n x n: J = D_a + D_b A, H = J^T J + nu 1 */
  double *phi, *step, *trial, *spare; /* n */
} newton;

/* This number of steps must halve the norm; a step must better the worst of the last norms (Grippo,
 * Lampariello, Lucidi, SIAM J. Numer. Anal. 23, 1986), of which memory says how many. */
enum { PATIENCE = 20 };

static double evaluate_fischer(const newton *f, const double *x, double *y, double *phi)
{
  double sum = 0;
  for (int i = 0; i < f->n; i++) y[i] = f->b[i];
  nsdae_add_product(f->n, f->n, f->A, x, y);
  for (int i = 0; i < f->n; i++) {
    phi[i] = x[i] + y[i] - hypot(x[i], y[i]);
    sum += phi[i] * phi[i];
  }
  return sqrt(sum);
}

/* step = -(J^T J + nu 1)^-1 J^T phi; returns 0 when it could be made. */
static int direction(const newton *f, double nu)
{
  int n = f->n;
  nsdae_la_multiply_transposed(n, n, n, f->J, n, f->J, n, 0, f->H, n);
  nsdae_la_multiply_transposed(n, n, 1, f->J, n, f->phi, n, 0, f->step, n);
  for (int i = 0; i < n; i++) {
    f->H[(size_t)i * (size_t)n + (size_t)i] += nu;
    f->step[i] = -f->step[i];
  }
  if (nsdae_la_cholesky(n, f->H, n) != 0) return 1;
  nsdae_la_solve_lower(n, 1, f->H, n, f->step, n);
  nsdae_la_solve_lower_transposed(n, 1, f->H, n, f->step, n);
  return 0;
}

/* Halves the step until the norm is below what is to be bettered; returns the new norm, or a
 * negative number where it never is. */
static double backtrack(newton *f, double *x, double *y, double bound)
{
  for (double part = 1; part > 1e-10; part /= 2) {
    for (int i = 0; i < f->n; i++) f->trial[i] = x[i] + part * f->step[i];
    double fresh = evaluate_fischer(f, f->trial, y, f->spare);
    if (!(fresh < (1 - 1e-4 * part) * bound)) continue;
    for (int i = 0; i < f->n; i++) {
      x[i] = f->trial[i];
      f->phi[i] = f->spare[i];
    }
    return fresh;
  }
  return -1;
}

double nsdae_fischer(int n, const double *A, const double *b, int iterations, int memory, double *x,
                     double *y, double *work)
{
  size_t size = (size_t)n;
  double last[NSDAE_FISCHER_MEMORY], before = INFINITY;
  newton f = {
      .n = n, .A = A, .b = b, .J = work, .H = work + size * size, .phi = work + 2 * size * size};
  f.step = f.phi + n;
  f.trial = f.step + n;
  f.spare = f.trial + n;
  double norm = evaluate_fischer(&f, x, y, f.phi), scale = norm;
  for (int k = 0; k < memory; k++) last[k] = norm;
  for (int i = 0; i < iterations && norm > 1e-15 * scale; i++) {
    double nu = 1e-10 + 1e-6 * norm;
    for (size_t k = 0; k < size; k++) { /* J */
      double root = hypot(x[k], y[k]);
      double da = root > 0 ? 1 - x[k] / root : 1 - sqrt(0.5);
      double db = root > 0 ? 1 - y[k] / root : 1 - sqrt(0.5);
      for (size_t j = 0; j < size; j++)
        f.J[j * size + k] = db * A[j * size + k] + (k == j ? da : 0);
    }
    while (direction(&f, nu) != 0 && nu < 1) nu *= 100; /* singular to rounding */
    double fresh = nu < 1 ? backtrack(&f, x, y, nsdae_largest(memory, last)) : -1;
    if (fresh < 0) break;
    last[i % memory] = norm = fresh;
    if (i % PATIENCE != PATIENCE - 1) continue;
    if (norm > before / 2) break;
    before = norm;
  }
  evaluate_fischer(&f, x, y, f.phi);
  return norm;
}
