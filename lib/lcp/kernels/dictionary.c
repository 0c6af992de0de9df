#include "dictionary.h"

#include <stddef.h>

#include "dense.h"
#include "vector.h"

/* Quotients are divided, not multiplied with 1 / c_r: what is equal then cancels to zero. */

int nsdae_dictionary_size(int n, int block)
{
  return n * (n + 2) + (block > 0 ? (2 * n + 1) * (block + 1) + block : 0);
}

static double *dictionary_column(const nsdae_dictionary *t, int j)
{
  return t->D + (size_t)j * (size_t)t->n;
}

/* y += factor x */
static void add_scaled(int n, double factor, const double *restrict x, double *restrict y)
{
  for (int i = 0; i < n; i++) y[i] += factor * x[i];
}

/* out = a + factor d; mark becomes NaN where a is not finite */
static void start_column(int n, const double *restrict a, double factor, const double *restrict d,
                         double *restrict out, double *restrict mark)
{
  for (int i = 0; i < n; i++) {
    out[i] = a[i] + factor * d[i];
    mark[i] += 0 * a[i];
  }
}

int nsdae_dictionary_start(nsdae_dictionary *t, int n, int block, const double *a, int lda,
                           const double *b, const double *d, int r, double *work)
{
  size_t size = (size_t)n, wide = (size_t)block;
  *t = (nsdae_dictionary){.n = n, .block = block, .D = work, .q = work + size * (size + 1)};
  if (block > 0) {
    t->U = t->q + size;
    t->V = t->U + size * wide;
    t->column = t->V + (size + 1) * wide;
    t->row = t->column + size;
    t->along = t->row + size + 1;
  }
  double *cover = dictionary_column(t, n), by = d ? d[r] : 1;
  for (int i = 0; i < n; i++) {
    cover[i] = d ? d[i] : 1;
    t->q[i] = 0;
  }
  for (int j = 0; j < n; j++) {
    const double *from = a + (size_t)j * (size_t)lda;
    double factor = -from[r] / by;
    start_column(n, from, factor, cover, dictionary_column(t, j), t->q);
    dictionary_column(t, j)[r] = factor;
  }
  if (!nsdae_all_finite((size_t)n, t->q)) return 1;
  for (int i = 0; i < n; i++) t->q[i] = b[i];
  nsdae_dictionary_move(t, r, cover);
  for (int i = 0; d && i < n; i++) cover[i] /= by;
  cover[r] = 1 / by;
  return 0;
}

/* ---- reading */

const double *nsdae_dictionary_column(nsdae_dictionary *t, int j)
{
  const double *from = dictionary_column(t, j);
  if (t->pending == 0) return from;
  for (int i = 0; i < t->n; i++) t->column[i] = from[i];
  for (int k = 0; k < t->pending; k++)
    t->along[k] = t->V[(size_t)k * ((size_t)t->n + 1) + (size_t)j];
  nsdae_la_add_product(t->n, t->pending, 1, t->U, t->n, t->along, t->column);
  return t->column;
}

double nsdae_dictionary_entry(const nsdae_dictionary *t, int i, int j)
{
  double sum = dictionary_column(t, j)[i];
  for (int k = 0; k < t->pending; k++)
    sum += t->U[(size_t)k * (size_t)t->n + (size_t)i] *
           t->V[(size_t)k * ((size_t)t->n + 1) + (size_t)j];
  return sum;
}

void nsdae_dictionary_move(nsdae_dictionary *t, int r, const double *c)
{
  double step = -t->q[r] / c[r];
  add_scaled(t->n, step, c, t->q);
  t->q[r] = step;
}

/* ---- pivots, at once or delayed */

static void pivot_later(nsdae_dictionary *t, int r, int e, const double *c)
{
  int n = t->n;
  double *u = t->U + (size_t)t->pending * (size_t)n;
  double *v = t->V + (size_t)t->pending * ((size_t)n + 1);
  double by = c[r];
  for (int i = 0; i < n; i++) u[i] = c[i];
  u[r] = 1;
  /* t->row = row r of C; row r of D and U become zero. */
  for (int j = 0; j <= n; j++) {
    double *at = dictionary_column(t, j) + r;
    t->row[j] = *at;
    *at = 0;
  }
  for (int k = 0; k < t->pending; k++) {
    double *at = t->U + (size_t)k * (size_t)n + (size_t)r;
    t->along[k] = *at;
    *at = 0;
  }
  nsdae_la_add_product(n + 1, t->pending, 1, t->V, n + 1, t->along, t->row);
  /* Column e is zero from now on. */
  double *column = dictionary_column(t, e);
  for (int i = 0; i < t->n; i++) column[i] = 0;
  for (int k = 0; k < t->pending; k++) t->V[(size_t)k * ((size_t)t->n + 1) + (size_t)e] = 0;
  for (int j = 0; j <= n; j++) v[j] = -t->row[j] / by;
  v[e] = 1 / by;
  if (++t->pending < t->block) return;
  nsdae_la_add_outer(n, n + 1, t->pending, t->U, n, t->V, n + 1, t->D, n);
  t->pending = 0;
}

void nsdae_dictionary_pivot(nsdae_dictionary *t, int r, int e, const double *c)
{
  int n = t->n;
  nsdae_dictionary_move(t, r, c);
  if (t->block > 0) {
    pivot_later(t, r, e, c);
    return;
  }
  double *entering = dictionary_column(t, e), by = entering[r];
  for (int j = 0; j <= n; j++) {
    double *column = dictionary_column(t, j), factor = -column[r] / by;
    if (j == e || factor == 0) continue;
    add_scaled(n, factor, entering, column);
    column[r] = factor;
  }
  for (int i = 0; i < n; i++) entering[i] /= by;
  entering[r] = 1 / by;
}
