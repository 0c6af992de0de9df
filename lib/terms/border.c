#include "border.h"

#include <string.h>

#include "dense.h"

void nsdae_border_layout(nsdae_border *b, const nsdae_dims *d, int most, nsdae_arena *arena)
{
  b->most = most;
  b->row = nsdae_arena_take(arena, most, sizeof *b->row);
  b->V = NSDAE_ARENA_DOUBLES(arena, (long)d->nv * most);
  b->L = NSDAE_ARENA_DOUBLES(arena, (long)d->m * most);
  b->B = NSDAE_ARENA_DOUBLES(arena, (long)most * most);
  b->pivot = NSDAE_ARENA_INTS(arena, most);
}

int nsdae_border_add(nsdae_border *b, const nsdae_rows *rows, int i)
{
  int a = b->count++;
  b->row[a] = (nsdae_border_row){.rows = rows, .index = i, .multiplier = -1};
  for (int c = 0; c <= a; c++) *nsdae_border_entry(b, a, c) = *nsdae_border_entry(b, c, a) = 0;
  return a;
}

void nsdae_border_depend(nsdae_border *b, int a, const nsdae_rows *rows, int i, double factor)
{
  nsdae_border_row *row = &b->row[a];
  row->part[row->parts].rows = rows;
  row->part[row->parts].index = i;
  row->part[row->parts++].factor = factor;
}

/* G_a . x + h_a l_j(a) */
static double product(const nsdae_border *b, const nsdae_terms *T, int a, const double *x,
                      const double *l)
{
  const nsdae_border_row *row = &b->row[a];
  double sum = 0;
  for (int p = 0; p < row->parts; p++)
    sum += row->part[p].factor *
           nsdae_rows_dot(&T->system->blocks, row->part[p].rows, row->part[p].index, x);
  return row->multiplier < 0 ? sum : sum + row->h * l[row->multiplier];
}

int nsdae_border_factor(nsdae_border *b, const nsdae_terms *T)
{
  size_t n = (size_t)b->kkt->n, m = (size_t)b->kkt->m;
  if (b->count == 0) return NSDAE_OK;
  memset(b->V, 0, (size_t)b->count * n * sizeof *b->V);
  memset(b->L, 0, (size_t)b->count * m * sizeof *b->L);
  for (int a = 0; a < b->count; a++)
    nsdae_rows_add(&T->system->blocks, b->row[a].rows, b->row[a].index, 1, b->V + (size_t)a * n);
  int status = nsdae_kkt_solve(b->kkt, b->count, b->V, b->kkt->n, b->L, b->kkt->m);
  if (status < 0) return status;
  for (int c = 0; c < b->count; c++)
    for (int a = 0; a < b->count; a++)
      *nsdae_border_entry(b, a, c) += product(b, T, a, b->V + (size_t)c * n, b->L + (size_t)c * m);
  return nsdae_la_lu(b->count, b->B, b->most, b->pivot) == 0 ? NSDAE_OK : NSDAE_E_CONVERGENCE;
}

int nsdae_border_solve(const nsdae_border *b, const nsdae_terms *T, double *dv, double *l,
                       double *phi)
{
  int status = nsdae_kkt_solve(b->kkt, 1, dv, b->kkt->n, l, b->kkt->m);
  if (status < 0 || b->count == 0) return status;
  for (int a = 0; a < b->count; a++) phi[a] -= product(b, T, a, dv, l);
  nsdae_la_lu_solve(b->count, b->B, b->most, b->pivot, phi);
  nsdae_add_product(b->kkt->n, b->count, b->V, phi, dv);
  nsdae_add_product(b->kkt->m, b->count, b->L, phi, l);
  return NSDAE_OK;
}
