/* Damped Newton on the semismooth equations from several starts; what it takes for positive is
 * solved at once, or else where Lemke's method starts. */
#include "lcp_methods.h"

#include <math.h>
#include <nsdae/kernels.h>
#include <stddef.h>
#include <string.h>

#include "dense.h"
#include "enumerate.h"
#include "vector.h"

/* phi_i(x) = x_i + y_i - sqrt(x_i^2 + y_i^2), y = A x + b, is zero exactly where x_i >= 0, y_i >= 0
 * and x_i y_i = 0 (Fischer, Optimization 24, 1992). Levenberg-Marquardt steps on |phi|^2 / 2 with
 * backtracking (De Luca, Facchinei, Kanzow, Math. Program. 75, 1996): a stationary point need not
 * be a solution, so the result is judged by its residual like everything else. */

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
  nsdae_la_multiply_transposed(n, n, n, 1, f->J, n, f->J, n, 0, f->H, n);
  nsdae_la_multiply_transposed(n, n, 1, 1, f->J, n, f->phi, n, 0, f->step, n);
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

/* memory: how many norms back a step may rise to, in [1, NSDAE_FISCHER_MEMORY]; 1: always lower.
 * x, y [n] in: the start (y is made from x); out: the last iterate. A is n x n with leading
 * dimension n; work has 2 n^2 + 4 n. Returns the norm of the residual. */
static double fischer(int n, const double *A, const double *b, int iterations, int memory,
                      double *x, double *y, double *work)
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

/* Lemke's method, with the covering vector of ones and with others. */

enum { COVERINGS = 12 };

/* Residual of a solution that cannot be better. */
static const double ROUNDING = 1e-15;

int nsdae_lcp_lemke_once(nsdae_lcp_work *w, const double *cover, int *pivots)
{
  int n = w->n;
  int most = w->options->max_pivots > 0 ? w->options->max_pivots : 50 * n + 100;
  return nsdae_dlemke(n, w->scaled.A, n, w->scaled.b, cover, most, w->x, w->room.trial, pivots,
                      w->room.lemke, w->room.lemke_size, w->room.index);
}

static int lemke_with(nsdae_lcp_work *w, const double *cover, int stage)
{
  int pivots = 0, info = nsdae_lcp_lemke_once(w, cover, &pivots);
  w->info->pivots += pivots;
  if (!cover) w->ray = info == 1;
  if (info != 0) return 0;
  nsdae_lcp_judge(w, w->room.trial, stage);
  /* the basis solved at once has less rounding than its pivots */
  if (!(w->info->residual < ROUNDING)) nsdae_lcp_judge_basis(w, w->room.trial, stage);
  return nsdae_lcp_is_settled(w);
}

int nsdae_lcp_try_lemke(nsdae_lcp_work *w)
{
  return lemke_with(w, NULL, NSDAE_LCP_LEMKE);
}

int nsdae_lcp_try_coverings(nsdae_lcp_work *w)
{
  unsigned long long seed = 1;
  for (int k = 0; k < COVERINGS; k++) {
    nsdae_lcp_scatter(w->n, w->room.cover, &seed);
    if (lemke_with(w, w->room.cover, NSDAE_LCP_COVERING)) return 1;
  }
  return 0;
}

/* Cottle, Pang, Stone, "The Linear Complementarity Problem", 1992, section 2.3. Column by column: a
 * column (A_B, A_N) that stays becomes (-X, A_N - A_NB X) with X = A_BB^-1 A_B, one that changes
 * places (X, A_NB X) with X = A_BB^-1 e_k. */

/* T [n x n], t [n] := the problem in which x_i and y_i have changed places where basis[i] is not 0:
 *   T = [A_BB^-1  -A_BB^-1 A_BN;  A_NB A_BB^-1  A_NN - A_NB A_BB^-1 A_BN]
 *   t = [-A_BB^-1 b_B;  b_N - A_NB A_BB^-1 b_B]
 * A is n x n with leading dimension n. Returns 0, or 1 where A_BB is singular. work [n^2 + n],
 * pivot [n], index [n] */
static int transform(int n, const double *A, const double *b, const int *basis, double *T,
                     double *t, double *work, int *pivot, int *index)
{
  double *lu = work, *part = work + (size_t)n * (size_t)n;
  int size = nsdae_lcp_gather(n, A, n, basis, lu, index);
  if (nsdae_la_lu(size, lu, size, pivot) != 0) return 1;
  for (int j = 0; j <= n; j++) {
    const double *from = j < n ? A + (size_t)j * (size_t)n : b;
    double *out = j < n ? T + (size_t)j * (size_t)n : t;
    int changes = j < n && basis[j];
    double sign = changes ? 1 : -1;
    for (int k = 0; k < size; k++) part[k] = changes ? index[k] == j : from[index[k]];
    nsdae_la_lu_solve(size, lu, size, pivot, part); /* X */
    for (int i = 0; i < n; i++) out[i] = changes ? 0 : from[i];
    for (int k = 0; k < size; k++)
      nsdae_add(n, sign * part[k], A + (size_t)index[k] * (size_t)n, out);
    for (int k = 0; k < size; k++) out[index[k]] = sign * part[k];
  }
  return 0;
}

/* Starts of the semismooth Newton method. */
enum { STARTS = 24, EARLY = 4, ITERATIONS = 60, LARGE = 100 };

/* Lemke's method from the active set in w->room.trial, which need not be right: on the problem in
 * which its x and y have changed places. */
static int lemke_from_trial(nsdae_lcp_work *w, int stage)
{
  int n = w->n, pivots = 0;
  int most = w->options->max_pivots > 0 ? w->options->max_pivots : 50 * n + 100;
  int *set = w->room.allowed;
  double *T = w->room.wide, *t = w->room.point;
  memcpy(set, w->room.trial, (size_t)n * sizeof *set);
  if (transform(n, w->scaled.A, w->scaled.b, set, T, t, T + (size_t)n * (size_t)n, w->room.pivot,
                w->room.index) != 0)
    return 0;
  int info = nsdae_dlemke(n, T, n, t, NULL, most, w->x, w->room.trial, &pivots, w->room.lemke,
                          w->room.lemke_size, w->room.index);
  w->info->pivots += pivots;
  if (info != 0) return 0;
  for (int i = 0; i < n; i++) w->room.trial[i] = w->room.trial[i] != (set[i] != 0);
  return nsdae_lcp_judge_basis(w, w->room.trial, stage);
}

/* The method from the starts first .. end - 1: x = 0, the size of b, then at random up to it. What
 * an iterate takes for positive is solved at once, then the iterate itself is judged. */
static int run_starts(nsdae_lcp_work *w, int first, int end, int stage)
{
  unsigned long long seed = 7 + (unsigned long long)first;
  double *x = w->room.point, *y = w->room.point + w->n, most = nsdae_largest(w->n, w->scaled.b);
  for (int k = first; k < end; k++) {
    nsdae_lcp_scatter(w->n, w->room.cover, &seed);
    for (int i = 0; i < w->n; i++)
      x[i] = k == 0 ? 0 : k == 1 ? fmax(-w->scaled.b[i], 0) : most * w->room.cover[i];
    int memory = k % 2 == 0 ? 1 : NSDAE_FISCHER_MEMORY;
    fischer(w->n, w->scaled.A, w->scaled.b, ITERATIONS, memory, x, y, w->room.wide);
    for (int i = 0; i < w->n; i++) w->room.trial[i] = x[i] > y[i];
    if (nsdae_lcp_judge_basis(w, w->room.trial, stage)) return 1;
    for (int i = 0; i < w->n; i++) w->x[i] = fmax(x[i], 0);
    if (nsdae_lcp_judge(w, w->room.trial, stage) || lemke_from_trial(w, stage)) return 1;
  }
  return 0;
}

/* Of a large problem, the first starts before all that takes as many runs of Lemke's method. */
int nsdae_lcp_try_newton(nsdae_lcp_work *w)
{
  return w->n >= LARGE && run_starts(w, 0, EARLY, NSDAE_LCP_NEWTON);
}

/* Those that are left. */
int nsdae_lcp_try_further(nsdae_lcp_work *w)
{
  int tried = w->n >= LARGE && (w->options->stages & NSDAE_LCP_NEWTON);
  return run_starts(w, tried ? EARLY : 0, STARTS, NSDAE_LCP_FURTHER);
}
