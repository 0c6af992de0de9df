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
#include <stddef.h>
#include <string.h>

#include "cone.h"
#include "exact.h"
#include "judge.h"
#include "vector.h"

/* allowed[j]: y_j may be positive; allowed[n + j]: x_j may. */
static nsdae_cone cone_of(nsdae_chain *c)
{
  return (nsdae_cone){.n = c->n,
                      .m = 2 * c->n,
                      .C = c->wide,
                      .allowed = c->allowed,
                      .z = c->point,
                      .w = c->cover,
                      .gram = c->lu,
                      .factor = c->lemke,
                      .s = c->rhs,
                      .order = c->trial,
                      .state = c->index};
}

static double norm(int n, const double *v)
{
  return sqrt(nsdae_dot(n, v, v));
}

/* C / |C_j| + eta b / |b| in wide, b / |b| behind it. */
static void fill_columns(nsdae_chain *c, double eta)
{
  size_t n = (size_t)c->n;
  double *b = c->wide + 2 * n * n, size = norm(c->n, c->b);
  for (size_t i = 0; i < n; i++) b[i] = c->b[i] / size;
  for (size_t j = 0; j < 2 * n; j++) {
    double *column = c->wide + j * n;
    for (size_t i = 0; i < n; i++) column[i] = j < n ? i == j : -c->A[(j - n) * n + i];
    size = norm(c->n, column);
    for (size_t i = 0; i < n && size > 0; i++) column[i] = column[i] / size + eta * b[i];
  }
}

/* Whether u proves, by exact arithmetic on the problem as it was given, that no solution has only
 * the allowed entries. */
static int holds(const nsdae_chain *c, const double *u)
{
  const nsdae_lcp_problem *p = c->problem;
  int n = c->n;
  for (int i = 0; i < n; i++) {
    if (c->allowed[i] && !(u[i] >= 0)) return 0;
    if (!isfinite(u[i])) return 0;
  }
  if (nsdae_exact_sign(n, p->b, 1, u) != -1) return 0;
  for (int j = 0; j < n; j++)
    if (c->allowed[n + j] && nsdae_exact_sign(n, p->A + (size_t)j * (size_t)p->lda, 1, u) > 0)
      return 0;
  return 1;
}

static int is_whole(int n, const double *w, double factor)
{
  for (int i = 0; i < n; i++)
    if (fabs(factor * w[i] - round(factor * w[i])) > 1e-6) return 0;
  return 1;
}

/* Data that are small integers have a w whose entries are in the ratio of integers: those, the
 * least ones, or else 24 places below the largest entry. */
static void simplify(int n, double *w)
{
  enum { LARGEST = 4096 };
  double most = 0;
  int k = 1;
  for (int i = 0; i < n; i++) most = fmax(most, fabs(w[i]));
  while (k <= LARGEST && !is_whole(n, w, k / most)) k++;
  double factor = k <= LARGEST ? k : 0x1p24;
  for (int i = 0; i < n; i++) w[i] = round(factor / most * w[i]);
}

/* u from the nearest point with columns so tilted; in c->cover. */
static int separates(nsdae_chain *c, double eta)
{
  nsdae_cone cone = cone_of(c);
  fill_columns(c, eta);
  if (nsdae_cone_separate(&cone, c->wide + 2 * (size_t)c->n * (size_t)c->n) != 0) return 0;
  if (norm(c->n, c->cover) < 1e-12) return 0;
  if (eta == 0) simplify(c->n, c->cover);
  for (int i = 0; i < c->n; i++) {
    c->cover[i] *= c->row[i];
    if (eta == 0 && c->allowed[i]) c->cover[i] = fmax(c->cover[i], 0);
  }
  return holds(c, c->cover);
}

static int excluded(nsdae_chain *c)
{
  return separates(c, 1e-8) || separates(c, 1e-4) || separates(c, 0);
}

/* A row without a positive entry: y_i <= b_i < 0. */
static int hopeless_row(const nsdae_chain *c)
{
  const nsdae_lcp_problem *p = c->problem;
  for (int i = 0; i < c->n; i++) {
    int j = 0;
    if (!(p->b[i] < 0)) continue;
    while (j < c->n && p->A[(size_t)j * (size_t)p->lda + (size_t)i] <= 0) j++;
    if (j == c->n) return i;
  }
  return -1;
}

static int proved(nsdae_chain *c, int proof, int stage)
{
  c->info->outcome = NSDAE_LCP_INFEASIBLE;
  c->info->proof = proof;
  c->info->stage = stage;
  if (proof == NSDAE_LCP_PROOF_FARKAS) memcpy(c->point, c->cover, (size_t)c->n * sizeof *c->point);
  return 1;
}

static void allow_all(nsdae_chain *c)
{
  for (int j = 0; j < 2 * c->n; j++) c->allowed[j] = 1;
}

int nsdae_chain_prove(nsdae_chain *c)
{
  int row = hopeless_row(c);
  for (int i = 0; i < c->n; i++) c->cover[i] = i == row;
  if (row >= 0) return proved(c, NSDAE_LCP_PROOF_FARKAS, NSDAE_LCP_PROVE);
  if (c->n > NSDAE_PROOF_MAX) return 0;
  allow_all(c);
  return excluded(c) && proved(c, NSDAE_LCP_PROOF_FARKAS, NSDAE_LCP_PROVE);
}

/* The index of those free to be either whose two parts are both largest; -1 where none is free. */
static int branch_index(const nsdae_chain *c)
{
  double most = -1;
  int n = c->n, best = -1;
  for (int i = 0; i < n; i++) {
    double both = fmin(c->point[i], c->point[n + i]);
    if (!c->allowed[i] || !c->allowed[n + i] || both <= most) continue;
    most = both;
    best = i;
  }
  return best;
}

/* What the nearest point takes for positive, solved at once; and the point itself, for the block of
 * the x_i that make a solution may be singular. */
static void judge_point(nsdae_chain *c)
{
  int n = c->n;
  double size = norm(n, c->b);
  for (int i = 0; i < n; i++) c->trial[i] = c->point[n + i] > c->point[i];
  if (nsdae_chain_judge_basis(c, c->trial, NSDAE_LCP_ENUMERATE)) return;
  for (int j = 0; j < n; j++) {
    double of_column = norm(n, c->A + (size_t)j * (size_t)n), z = c->point[n + j];
    c->x[j] = z > 0 ? z * size / of_column : 0;
  }
  nsdae_chain_judge(c, c->trial, NSDAE_LCP_ENUMERATE);
}

enum { OPEN, EMPTY, FOUND };

static int search(nsdae_chain *c)
{
  int all = EMPTY;
  if (excluded(c)) return EMPTY;
  int i = branch_index(c);
  judge_point(c);
  if (c->info->outcome == NSDAE_LCP_SOLVED) return FOUND;
  if (i < 0) return OPEN;
  for (int side = 0; side < 2 && all == EMPTY; side++) {
    c->allowed[side == 0 ? i : c->n + i] = 0;
    all = search(c);
    c->allowed[i] = c->allowed[c->n + i] = 1;
  }
  return all;
}

int nsdae_chain_prove_all(nsdae_chain *c)
{
  allow_all(c);
  int found = search(c);
  if (found == EMPTY) return proved(c, NSDAE_LCP_PROOF_ENUMERATED, NSDAE_LCP_ENUMERATE);
  return found == FOUND;
}
