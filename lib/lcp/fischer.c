/* phi_i(x) = x_i + y_i - sqrt(x_i^2 + y_i^2), y = A x + b, is zero exactly where x_i >= 0, y_i >= 0
 * and x_i y_i = 0 (Fischer, Optimization 24, 1992). Levenberg-Marquardt steps on |phi|^2 / 2 with
 * backtracking (De Luca, Facchinei, Kanzow, Math. Program. 75, 1996): a stationary point need not
 * be a solution, so what comes out is judged by its residual like everything else. */
#include "fischer.h"

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

/* So many steps must halve the norm. */
enum { PATIENCE = 8 };

static double evaluate(const newton *f, const double *x, double *y, double *phi)
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

static void jacobian(const newton *f, const double *x, const double *y)
{
  size_t n = (size_t)f->n;
  for (size_t i = 0; i < n; i++) {
    double norm = hypot(x[i], y[i]);
    double da = norm > 0 ? 1 - x[i] / norm : 1 - sqrt(0.5);
    double db = norm > 0 ? 1 - y[i] / norm : 1 - sqrt(0.5);
    for (size_t j = 0; j < n; j++) f->J[j * n + i] = db * f->A[j * n + i] + (i == j ? da : 0);
  }
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

/* Halves the step until the norm falls; returns the new norm, or the old one where it never does.
 */
static double backtrack(newton *f, double *x, double *y, double norm)
{
  for (double part = 1; part > 1e-10; part /= 2) {
    for (int i = 0; i < f->n; i++) f->trial[i] = x[i] + part * f->step[i];
    double fresh = evaluate(f, f->trial, y, f->spare);
    if (!(fresh < (1 - 1e-4 * part) * norm)) continue;
    for (int i = 0; i < f->n; i++) {
      x[i] = f->trial[i];
      f->phi[i] = f->spare[i];
    }
    return fresh;
  }
  return norm;
}

double nsdae_fischer(int n, const double *A, const double *b, int iterations, double *x, double *y,
                     double *work)
{
  size_t size = (size_t)n;
  newton f = {
      .n = n, .A = A, .b = b, .J = work, .H = work + size * size, .phi = work + 2 * size * size};
  f.step = f.phi + n;
  f.trial = f.step + n;
  f.spare = f.trial + n;
  double norm = evaluate(&f, x, y, f.phi), scale = norm, before = INFINITY;
  for (int i = 0; i < iterations && norm > 1e-15 * scale; i++) {
    jacobian(&f, x, y);
    double nu = 1e-10 + 1e-6 * norm;
    while (direction(&f, nu) != 0 && nu < 1) nu *= 100;
    if (nu >= 1) break;
    double fresh = backtrack(&f, x, y, norm);
    if (fresh >= norm) break;
    norm = fresh;
    if (i % PATIENCE != PATIENCE - 1) continue;
    if (norm > before / 2) break;
    before = norm;
  }
  evaluate(&f, x, y, f.phi);
  return norm;
}
