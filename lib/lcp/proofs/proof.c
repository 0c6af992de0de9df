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

#include <float.h>
#include <math.h>
#include <stddef.h>
#include <string.h>

#include "dense.h"
#include "vector.h"

/* On a secondary ray the variables grow along a direction (x, z0, y) >= 0, x not zero, with
 *
 *   y = A x + d z0,   x_i y_i = 0
 *
 * (Cottle, Pang, Stone, "The Linear Complementarity Problem", 1992, theorem 4.4.1), so that (A x)_i
 * = -d_i z0 wherever x_i > 0. Where z0 > 0 that is negative: then x^T A x < 0, and A is neither
 * copositive nor semimonotone. Where z0 = 0, x^T A x = 0 and A is not strictly so. The basis names
 * the x_i that grow, except the pair that has no part in it: every pair is tried for it, and the
 * result is checked in exact arithmetic. */

/* The direction, to the problem's own scale, in w->room.cover: index[size] is the pair out of the
 * basis, of which x (or y) grows at the rate one. */
static void direction(nsdae_lcp_work *w, int size, int of_x)
{
  int k = w->room.index[size];
  for (int i = 0; i <= size; i++) {
    const double *column = w->scaled.A + (size_t)k * (size_t)w->n;
    w->room.rhs[i] = of_x ? -column[w->room.index[i]] : i == size;
  }
  nsdae_la_lu_solve(size + 1, w->room.lu, size + 1, w->room.pivot, w->room.rhs);
  memset(w->room.cover, 0, (size_t)w->n * sizeof *w->room.cover);
  for (int i = 0; i < size; i++)
    w->room.cover[w->room.index[i]] = w->room.rhs[i] * w->scaled.column[w->room.index[i]];
  if (of_x) w->room.cover[k] = w->scaled.column[k];
}

/* What x proves: x >= 0, not zero, and where it is positive A x is negative, or not positive. */
static int proves(const nsdae_lcp_work *w, const double *x)
{
  const nsdae_lcp_problem *p = w->problem;
  int any = 0, proof = NSDAE_LCP_RAY_NOT_COPOSITIVE;
  for (int i = 0; i < w->n; i++) {
    if (!(x[i] >= 0 && isfinite(x[i]))) return NSDAE_LCP_RAY_NOTHING;
    if (x[i] == 0) continue;
    int sign = nsdae_exact_sign(w->n, p->A + i, p->lda, x);
    if (sign > 0) return NSDAE_LCP_RAY_NOTHING;
    if (sign == 0) proof = NSDAE_LCP_RAY_NOT_STRICTLY_COPOSITIVE;
    any = 1;
  }
  return any ? proof : NSDAE_LCP_RAY_NOTHING;
}

void nsdae_lcp_read_ray(nsdae_lcp_work *w)
{
  int size = 0;
  for (int i = 0; i < w->n; i++)
    if (w->room.trial[i]) w->room.index[size++] = i;
  if (w->n > NSDAE_RAY_MAX || size == w->n) return;
  for (int k = 0; k < w->n; k++) {
    if (w->room.trial[k]) continue;
    w->room.index[size] = k;
    /* Rows index[0 .. size] of the columns index[0 .. size - 1] of A and of d = 1, factored. */
    double *to = w->room.lu;
    for (int j = 0; j <= size; j++)
      for (int i = 0; i <= size; i++) {
        size_t column = (size_t)w->room.index[j] * (size_t)w->n;
        *to++ = j == size ? 1 : w->scaled.A[column + (size_t)w->room.index[i]];
      }
    if (nsdae_la_lu(size + 1, w->room.lu, size + 1, w->room.pivot) != 0) continue;
    for (int of_x = 0; of_x < 2; of_x++) {
      direction(w, size, of_x);
      /* Small negative entries are rounding: the point with zeros for them is a candidate as good.
       */
      double most = 0;
      for (int i = 0; i < w->n; i++) most = fmax(most, w->room.cover[i]);
      for (int i = 0; i < w->n; i++)
        if (fabs(w->room.cover[i]) < 1e-12 * most) w->room.cover[i] = 0;
      int proof = proves(w, w->room.cover);
      if (proof == NSDAE_LCP_RAY_NOTHING) continue;
      w->info->ray = proof;
      if (proof == NSDAE_LCP_RAY_NOT_COPOSITIVE) return;
    }
  }
}

/* A product of two doubles is the sum of two doubles, p = fl(a u) and fma(a, u, -p) (Dekker, Numer.
 * Math. 18, 1971). Sums are kept as expansions: doubles that do not overlap, smallest first, whose
 * exact sum is meant and whose sign is that of the last (Shewchuk, Discrete Comput. Geom. 18, 1997,
 * Grow-Expansion with zeros left out). */

/* Nonadjacent doubles hold at least two of the 2098 binary places each. */
enum { LONGEST = 1056 };

typedef struct expansion {
  double part[LONGEST];
  int size;
} expansion;

static void add_exactly(expansion *e, double value)
{
  int size = 0;
  for (int i = 0; i < e->size; i++) { /* sum + error = value + part, exactly */
    double part = e->part[i], sum = value + part;
    double shadow = sum - value, error = (value - (sum - shadow)) + (part - shadow);
    if (error != 0) e->part[size++] = error;
    value = sum;
  }
  if (value != 0) e->part[size++] = value;
  e->size = size;
}

/* Sum of the exponents of the factors, or NONE where one is zero. */
enum { NONE = -10000, SPAN = 900 };

static int power_of(double a, double u)
{
  return a == 0 || u == 0 ? NONE : ilogb(a) + ilogb(u);
}

void nsdae_to_integers(int n, double *w)
{
  enum { LARGEST = 4096 };
  double most = nsdae_largest(n, w), factor = 0;
  for (int k = 1, whole = 0; k <= LARGEST && !whole; k++) {
    factor = k / most;
    whole = 1;
    for (int i = 0; i < n && whole; i++)
      whole = !(fabs(factor * w[i] - round(factor * w[i])) > 1e-6);
    if (!whole && k == LARGEST) factor = 0x1p24 / most;
  }
  for (int i = 0; i < n; i++) w[i] = round(factor * w[i]);
}

int nsdae_exact_sign(int n, const double *a, int stride, const double *u)
{
  expansion e = {.size = 0};
  int largest = NONE;
  for (int i = 0; i < n; i++) {
    double factor = a[(size_t)i * (size_t)stride];
    if (!isfinite(factor) || !isfinite(u[i])) return NSDAE_SIGN_UNKNOWN;
    int power = power_of(factor, u[i]);
    if (power > largest) largest = power;
  }
  for (int i = 0; i < n; i++) {
    double factor = a[(size_t)i * (size_t)stride];
    int power = power_of(factor, u[i]), own = power == NONE ? 0 : ilogb(factor);
    if (power == NONE) continue;
    if (power < largest - SPAN) return NSDAE_SIGN_UNKNOWN;
    double one = ldexp(factor, -own), other = ldexp(u[i], own - largest), product = one * other;
    add_exactly(&e, fma(one, other, -product));
    add_exactly(&e, product);
  }
  if (e.size == 0) return 0;
  return e.part[e.size - 1] > 0 ? 1 : -1;
}

/* Nonnegative least squares by active sets (Lawson and Hanson, "Solving Least Squares Problems",
 * 1974, chapter 23), on the normal equations of the passive columns. */

enum { OUT, PASSIVE, BANNED };

static const double *cone_column(const nsdae_cone *c, int j)
{
  return c->C + (size_t)j * (size_t)c->n;
}

/* ---- Cholesky factor of the passive columns */

/* Row p of the lower triangle of the products of the passive columns. */
static void border(const nsdae_cone *c, int p)
{
  for (int k = 0; k <= p; k++)
    c->gram[(size_t)k * (size_t)c->n + (size_t)p] =
        nsdae_dot(c->n, cone_column(c, c->order[p]), cone_column(c, c->order[k]));
}

/* Row p of the Cholesky factor from the rows above it; 1 where the column depends on the others. */
static int extend(const nsdae_cone *c, int p)
{
  size_t n = (size_t)c->n, row = (size_t)p;
  double square = c->gram[row * n + row], rest = square;
  for (size_t k = 0; k < row; k++) c->s[k] = c->gram[k * n + row];
  nsdae_la_solve_lower(p, 1, c->factor, c->n, c->s, c->n);
  for (size_t k = 0; k < row; k++) {
    c->factor[k * n + row] = c->s[k];
    rest -= c->s[k] * c->s[k];
  }
  c->factor[row * n + row] = sqrt(rest);
  return !(rest > c->n * DBL_EPSILON * square);
}

/* s = least squares on the passive columns. */
static void solve_passive(const nsdae_cone *c, int size, const double *b)
{
  for (int k = 0; k < size; k++) c->s[k] = nsdae_dot(c->n, cone_column(c, c->order[k]), b);
  nsdae_la_solve_lower(size, 1, c->factor, c->n, c->s, c->n);
  nsdae_la_solve_lower_transposed(size, 1, c->factor, c->n, c->s, c->n);
}

/* ---- active-set method */

/* Moves z towards s as far as it stays >= 0; what becomes zero leaves. Returns the new size. */
static int retreat(const nsdae_cone *c, int size)
{
  double part = 1;
  int kept = 0, blocking = -1;
  for (int k = 0; k < size; k++) {
    double z = c->z[c->order[k]];
    if (c->s[k] > 0 || z / (z - c->s[k]) >= part) continue;
    part = z / (z - c->s[k]);
    blocking = k;
  }
  for (int k = 0; k < size; k++) {
    int j = c->order[k];
    c->z[j] += part * (c->s[k] - c->z[j]);
    if (k != blocking && c->z[j] > 0) {
      c->order[kept++] = j;
    } else {
      c->z[j] = 0;
      c->state[j] = OUT;
    }
  }
  for (int k = 0; kept < size && k < kept; k++) border(c, k);
  return kept;
}

static int all_positive(const double *s, int size)
{
  for (int k = 0; k < size; k++)
    if (!(s[k] > 0)) return 0;
  return 1;
}

/* Takes column j in and makes z the least squares of what stays; returns how many that are. */
static int add_column(const nsdae_cone *c, int size, int j, const double *b)
{
  c->order[size] = j;
  border(c, size);
  int dependent = extend(c, size);
  if (!dependent) solve_passive(c, size + 1, b);
  if (dependent || !(c->s[size] > 0)) { /* or gains nothing but rounding */
    c->state[j] = BANNED;
    return size;
  }
  c->state[j] = PASSIVE;
  size++;
  while (size > 0 && !all_positive(c->s, size)) {
    size = retreat(c, size);
    for (int k = 0; k < size; k++) { /* the factor anew */
      size_t from = (size_t)k * (size_t)c->n + (size_t)k;
      memcpy(c->factor + from, c->gram + from, (size_t)(size - k) * sizeof *c->gram);
    }
    if (nsdae_la_cholesky(size, c->factor, c->n) != 0) return -1;
    solve_passive(c, size, b);
  }
  for (int k = 0; k < size; k++) c->z[c->order[k]] = c->s[k];
  for (int i = 0; i < c->m; i++)
    if (c->state[i] == BANNED) c->state[i] = OUT;
  return size;
}

int nsdae_cone_separate(const nsdae_cone *c, const double *b)
{
  int size = 0;
  memset(c->z, 0, (size_t)c->m * sizeof *c->z);
  for (int j = 0; j < c->m; j++) c->state[j] = OUT;
  for (int i = 0; i < 10 * c->m + 10; i++) {
    for (int k = 0; k < c->n; k++) c->w[k] = -b[k];
    for (int k = 0; k < c->m; k++)
      if (c->z[k] > 0) nsdae_add(c->n, c->z[k], cone_column(c, k), c->w);
    /* The column along which the norm falls fastest; -1 where it falls along none. */
    double most = 1e-13;
    int j = -1;
    for (int k = 0; k < c->m && size < c->n; k++) {
      if (!c->allowed[k] || c->state[k] != OUT) continue;
      double slope = -nsdae_dot(c->n, cone_column(c, k), c->w);
      if (!(slope > most)) continue;
      most = slope;
      j = k;
    }
    if (j < 0) return 0;
    size = add_column(c, size, j, b);
    if (size < 0) return 1;
  }
  return 1;
}

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
