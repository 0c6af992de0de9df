/* Farkas: no x >= 0 has A x + b >= 0 if and only if there is
 *
 *   u >= 0,  A^T u <= 0,  b^T u < 0
 *
 * (Cottle, Pang, Stone, "The Linear Complementarity Problem", 1992, theorem 2.7.8). A solution is a
 * z >= 0 with [1, -A] z = b, z = (y, x), and of z_i and z_(n+i) one is zero. So a choice of which
 * columns may take part, S, has no solution where some u has u^T C_j >= 0 for all j in S, C = [1,
 * -A], and b^T u < 0. Such a u is where the nearest point of the cone lies from b, and is then
 * checked in exact arithmetic: what is reported as proved is proved.
 *
 * In the residual of the nearest point the columns that span it have product zero, which rounding
 * makes negative. With columns tilted towards b, C_j + eta b, it is positive by eta |b^T u|. */
#include "proof.h"

#include <math.h>
#include <string.h>

#include "separation.h"
#include "vector.h"

static double norm(int n, const double *v)
{
  return sqrt(nsdae_dot(n, v, v));
}

/* Whether u proves, by exact arithmetic on the problem as it was given, that no solution has only
 * the allowed entries. */
static int holds(const nsdae_lcp_work *w, const double *u)
{
  const nsdae_lcp_problem *p = w->problem;
  int n = w->n;
  for (int i = 0; i < n; i++) {
    if (w->room.allowed[i] && !(u[i] >= 0)) return 0;
    if (!isfinite(u[i])) return 0;
  }
  if (nsdae_exact_sign(n, p->b, 1, u) != -1) return 0;
  for (int j = 0; j < n; j++)
    if (w->room.allowed[n + j] && nsdae_exact_sign(n, p->A + (size_t)j * (size_t)p->lda, 1, u) > 0)
      return 0;
  return 1;
}

/* ---- nearest point */

/* u from the nearest point with columns so tilted; in w->room.cover. */
static int separates(nsdae_lcp_work *w, double eta)
{
  /* allowed[j]: y_j may be positive; allowed[n + j]: x_j may. */
  nsdae_cone cone = (nsdae_cone){.n = w->n,
                                 .m = 2 * w->n,
                                 .C = w->room.wide,
                                 .allowed = w->room.allowed,
                                 .z = w->room.point,
                                 .w = w->room.cover,
                                 .gram = w->room.lu,
                                 .factor = w->room.lemke,
                                 .s = w->room.rhs,
                                 .order = w->room.trial,
                                 .state = w->room.index};
  /* C / |C_j| + eta b / |b| in wide, b / |b| behind it. */
  size_t n = (size_t)w->n;
  double *b = w->room.wide + 2 * n * n, size = norm(w->n, w->scaled.b);
  for (size_t i = 0; i < n; i++) b[i] = w->scaled.b[i] / size;
  for (size_t j = 0; j < 2 * n; j++) {
    double *column = w->room.wide + j * n;
    for (size_t i = 0; i < n; i++) column[i] = j < n ? i == j : -w->scaled.A[(j - n) * n + i];
    size = norm(w->n, column);
    for (size_t i = 0; i < n && size > 0; i++) column[i] = column[i] / size + eta * b[i];
  }
  if (nsdae_cone_separate(&cone, w->room.wide + 2 * (size_t)w->n * (size_t)w->n) != 0) return 0;
  if (norm(w->n, w->room.cover) < 1e-12) return 0;
  if (eta == 0) nsdae_to_integers(w->n, w->room.cover);
  for (int i = 0; i < w->n; i++) {
    w->room.cover[i] *= w->scaled.row[i];
    if (eta == 0 && w->room.allowed[i]) w->room.cover[i] = fmax(w->room.cover[i], 0);
  }
  return holds(w, w->room.cover);
}

static int excluded(nsdae_lcp_work *w)
{
  return separates(w, 1e-8) || separates(w, 1e-4) || separates(w, 0);
}

static int proved(nsdae_lcp_work *w, int proof, int stage)
{
  w->info->outcome = NSDAE_OUTCOME_INFEASIBLE;
  w->info->proof = proof;
  w->info->stage = stage;
  if (proof == NSDAE_PROOF_FARKAS)
    memcpy(w->room.point, w->room.cover, (size_t)w->n * sizeof *w->room.point);
  return 1;
}

static void allow_all(nsdae_lcp_work *w)
{
  for (int j = 0; j < 2 * w->n; j++) w->room.allowed[j] = 1;
}

int nsdae_lcp_prove(nsdae_lcp_work *w)
{
  const nsdae_lcp_problem *p = w->problem;
  for (int i = 0; i < w->n; i++) { /* a row without a positive entry: y_i <= b_i < 0 */
    int j = p->b[i] < 0 ? 0 : w->n + 1;
    while (j < w->n && p->A[(size_t)j * (size_t)p->lda + (size_t)i] <= 0) j++;
    if (j != w->n) continue;
    for (int k = 0; k < w->n; k++) w->room.cover[k] = k == i;
    return proved(w, NSDAE_PROOF_FARKAS, NSDAE_LCP_PROVE);
  }
  if (w->n > NSDAE_PROOF_MAX) return 0;
  allow_all(w);
  return excluded(w) && proved(w, NSDAE_PROOF_FARKAS, NSDAE_LCP_PROVE);
}

/* ---- branches over the indices that are free */

/* What the nearest point takes for positive, solved at once; and the point itself, for the block of
 * the x_i that make a solution may be singular. */
static void judge_point(nsdae_lcp_work *w)
{
  int n = w->n;
  double size = norm(n, w->scaled.b);
  for (int i = 0; i < n; i++) w->room.trial[i] = w->room.point[n + i] > w->room.point[i];
  if (nsdae_lcp_judge_basis(w, w->room.trial, NSDAE_LCP_ENUMERATE)) return;
  for (int j = 0; j < n; j++) {
    double of_column = norm(n, w->scaled.A + (size_t)j * (size_t)n), z = w->room.point[n + j];
    w->x[j] = z > 0 ? z * size / of_column : 0;
  }
  nsdae_lcp_judge(w, w->room.trial, NSDAE_LCP_ENUMERATE);
}

enum { OPEN, EMPTY, FOUND };

static int search(nsdae_lcp_work *w)
{
  int all = EMPTY, i = -1, n = w->n;
  double most = -1;
  if (excluded(w)) return EMPTY;
  /* The index of those free to be either whose two parts are both largest; -1 where none is free.
   */
  for (int k = 0; k < n; k++) {
    double both = fmin(w->room.point[k], w->room.point[n + k]);
    if (!w->room.allowed[k] || !w->room.allowed[n + k] || both <= most) continue;
    most = both;
    i = k;
  }
  judge_point(w);
  if (w->info->outcome == NSDAE_OUTCOME_SOLVED) return FOUND;
  if (i < 0) return OPEN;
  for (int side = 0; side < 2 && all == EMPTY; side++) {
    w->room.allowed[side == 0 ? i : w->n + i] = 0;
    all = search(w);
    w->room.allowed[i] = w->room.allowed[w->n + i] = 1;
  }
  return all;
}

int nsdae_lcp_prove_all(nsdae_lcp_work *w)
{
  allow_all(w);
  int found = search(w);
  if (found == EMPTY) return proved(w, NSDAE_PROOF_ENUMERATED, NSDAE_LCP_ENUMERATE);
  return found == FOUND;
}
