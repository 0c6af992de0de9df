/* Nonnegative least squares by active sets (Lawson and Hanson, "Solving Least Squares Problems",
 * 1974, chapter 23), on the normal equations of the passive columns. */
#include "separation.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "dense.h"
#include "vector.h"

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
