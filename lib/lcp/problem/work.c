/* Memory, scales, and the way back to the problem as it was given. */
#include "work.h"

#include <string.h>

#include "dictionary.h"
#include "vector.h"

/* The workspace that nsdae_dlemke asks for. */
static int lemke_size(int n)
{
  return nsdae_dictionary_size(n, nsdae_lemke_block(n));
}

double nsdae_lcp_work_doubles(int n)
{
  return 4.0 * n * n + 13.0 * n + lemke_size(n) + 1;
}

int nsdae_lcp_work_ints(int n)
{
  return 6 * n + 1;
}

void nsdae_lcp_work_lay_out(nsdae_lcp_work *w, double *work, int *iwork)
{
  nsdae_lcp_room *r = &w->room;
  size_t n = (size_t)w->n;
  w->scaled.A = work;
  w->scaled.b = w->scaled.A + n * n;
  w->scaled.row = w->scaled.b + n;
  w->scaled.column = w->scaled.row + n;
  w->best = w->scaled.column + n;
  r->lemke_size = lemke_size((int)n);
  r->lu = w->best + n;
  r->wide = r->lu + n * n;
  r->cover = r->wide + 2 * n * n + 4 * n;
  r->rhs = r->cover + n;
  r->sizes = r->rhs + n;
  r->point = r->sizes + n;
  r->lemke = r->point + 2 * n;
  r->trial = iwork;
  r->pivot = r->trial + n;
  r->index = r->pivot + n;
  r->allowed = r->index + 2 * n + 1;
}

void nsdae_lcp_work_scale(nsdae_lcp_work *w)
{
  size_t n = (size_t)w->n;
  for (size_t j = 0; j < n; j++)
    memcpy(w->scaled.A + j * n, w->problem->A + j * (size_t)w->problem->lda,
           n * sizeof *w->scaled.A);
  for (size_t i = 0; i < n; i++) w->scaled.b[i] = w->problem->b[i];
  nsdae_equilibrate(w->n, w->scaled.A, w->scaled.b, w->scaled.row, w->scaled.column, w->room.point,
                    w->room.index);
  double before = nsdae_largest(w->n, w->problem->b), after = nsdae_largest(w->n, w->scaled.b);
  w->scaled.out_of_range = before > 0 && !(after > 0x1p-900 && after < 0x1p900);
}
