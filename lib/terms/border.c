#include "border.h"

#include <math.h>
#include <string.h>

#include "dense.h"
#include "disjoint_sets.h"

void nsdae_border_layout(nsdae_border *b, const nsdae_system *system, int most, nsdae_arena *arena)
{
  const nsdae_dims *d = &system->dims;
  nsdae_border_islands *is = &b->islands;
  int blocks = system->blocks.count;
  b->most = most;
  b->row = nsdae_arena_take(arena, most, sizeof *b->row);
  b->V = NSDAE_ARENA_DOUBLES(arena, (long)d->nv * most);
  b->L = NSDAE_ARENA_DOUBLES(arena, (long)d->m * most);
  b->B = NSDAE_ARENA_DOUBLES(arena, (long)most * most);
  nsdae_arena_ints(arena, most, (int **[]){&b->pivot, &is->column, &is->force, NULL});
  nsdae_arena_ints(arena, blocks, (int **[]){&is->parent, &is->of_block, NULL});
  is->first = NSDAE_ARENA_INTS(arena, most + 1L);
  is->LU = NSDAE_ARENA_DOUBLES(arena, blocks > 1 ? (long)most * most : 0);
  is->part = NSDAE_ARENA_DOUBLES(arena, most);
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

/* ---- islands */

static void join_row(const nsdae_border *b, const nsdae_rows *rows, int i, int block)
{
  for (int p = rows->first[i]; p < rows->first[i + 1]; p++)
    nsdae_sets_join(b->islands.parent, block, rows->block[p]);
}

/* The first block of row i of those; -1: it is zero. */
static int block_of(const nsdae_rows *rows, int i)
{
  return rows->first[i] < rows->first[i + 1] ? rows->block[rows->first[i]] : -1;
}

/* Sets of blocks. 0: a force has no block, all are one. */
static int join_blocks(nsdae_border *b, const nsdae_terms *T)
{
  const nsdae_rows *J = &T->by.jacobian;
  int *parent = b->islands.parent;
  nsdae_sets_begin(parent, T->system->blocks.count);
  for (int i = 0; i < b->kkt->m; i++)
    if (block_of(J, i) >= 0) join_row(b, J, i, block_of(J, i));
  for (int i = 0; b->coupling && i < b->coupling->count; i++)
    nsdae_sets_join(parent, b->coupling->pair[2 * i], b->coupling->pair[2 * i + 1]);
  for (int a = 0; a < b->count; a++) {
    const nsdae_border_row *row = &b->row[a];
    int block = block_of(row->rows, row->index);
    if (block < 0) return 0;
    join_row(b, row->rows, row->index, block);
    for (int p = 0; p < row->parts; p++) join_row(b, row->part[p].rows, row->part[p].index, block);
    if (row->multiplier >= 0) join_row(b, J, row->multiplier, block);
    for (int c = 0; c < a; c++)
      if (*nsdae_border_entry(b, a, c) != 0 || *nsdae_border_entry(b, c, a) != 0)
        nsdae_sets_join(parent, block, block_of(b->row[c].rows, b->row[c].index));
  }
  return 1;
}

static void find_islands(nsdae_border *b, const nsdae_terms *T)
{
  nsdae_border_islands *is = &b->islands;
  int blocks = T->system->blocks.count, one = blocks == 1 || !join_blocks(b, T);
  is->count = is->columns = 0;
  for (int i = 0; i < blocks; i++) is->of_block[i] = one ? 0 : -1;
  memset(is->first, 0, (size_t)(b->count + 1) * sizeof *is->first);
  for (int a = 0; a < b->count; a++) {
    int *of =
        &is->of_block[one ? 0
                          : nsdae_sets_root(is->parent, block_of(b->row[a].rows, b->row[a].index))];
    if (*of < 0 || is->count == 0) *of = is->count++;
    is->column[a] = is->first[*of + 1]++;
    if (is->column[a] >= is->columns) is->columns = is->column[a] + 1;
  }
  for (int i = 0; i < is->count; i++) is->first[i + 1] += is->first[i];
  for (int i = 0; i < blocks && !one; i++)
    is->of_block[i] = is->of_block[nsdae_sets_root(is->parent, i)];
  for (int a = 0; a < b->count; a++) {
    int island = one ? 0 : is->of_block[block_of(b->row[a].rows, b->row[a].index)];
    is->force[is->first[island] + is->column[a]] = a;
  }
}

/* Of an island: its LU factors, with this leading dimension; where those of the next one are. */
static double *factors_of(const nsdae_border *b, int island, double *at, int *ld)
{
  const nsdae_border_islands *is = &b->islands;
  *ld = is->count == 1 ? b->most : is->first[island + 1] - is->first[island];
  return at + (size_t)*ld * (size_t)*ld;
}

/* ---- factors and solution */

/* The dense system of one island. */
static int factor_island(nsdae_border *b, const nsdae_terms *T, int island, double *LU, int ld)
{
  const nsdae_border_islands *is = &b->islands;
  const int *force = is->force + is->first[island];
  size_t n = (size_t)b->kkt->n, m = (size_t)b->kkt->m;
  int count = is->first[island + 1] - is->first[island];
  for (int c = 0; c < count; c++)
    for (int a = 0; a < count; a++) {
      double *entry = nsdae_border_entry(b, force[a], force[c]);
      *entry += product(b, T, force[a], b->V + (size_t)c * n, b->L + (size_t)c * m);
      LU[(size_t)c * (size_t)ld + (size_t)a] = *entry;
    }
  return nsdae_la_lu(count, LU, ld, b->pivot + is->first[island]);
}

int nsdae_border_factor(nsdae_border *b, const nsdae_terms *T)
{
  nsdae_border_islands *is = &b->islands;
  size_t n = (size_t)b->kkt->n, m = (size_t)b->kkt->m;
  if (b->count == 0) return NSDAE_OK;
  find_islands(b, T);
  memset(b->V, 0, (size_t)is->columns * n * sizeof *b->V);
  memset(b->L, 0, (size_t)is->columns * m * sizeof *b->L);
  for (int a = 0; a < b->count; a++)
    nsdae_rows_add(&T->system->blocks, b->row[a].rows, b->row[a].index, 1,
                   b->V + (size_t)is->column[a] * n);
  int status = nsdae_kkt_solve(b->kkt, is->columns, b->V, b->kkt->n, b->L, b->kkt->m), ld;
  double *LU = is->count == 1 ? b->B : is->LU;
  for (int i = 0; i < is->count && status == NSDAE_OK; i++) {
    double *next = factors_of(b, i, LU, &ld);
    if (factor_island(b, T, i, LU, ld) != 0) status = NSDAE_E_CONVERGENCE;
    LU = next;
  }
  return status;
}

double nsdae_border_determinant(const nsdae_border *b, int *sign)
{
  const nsdae_border_islands *is = &b->islands;
  const double *LU = is->count == 1 ? b->B : is->LU;
  double sum = 0;
  *sign = 1;
  for (int i = 0, ld; i < is->count && b->count > 0; i++) {
    const double *next = factors_of(b, i, (double *)LU, &ld);
    for (int a = 0; a < is->first[i + 1] - is->first[i]; a++) {
      double entry = LU[(size_t)a * (size_t)(ld + 1)];
      if ((entry < 0) != (b->pivot[is->first[i] + a] != a + 1)) *sign = -*sign;
      sum += log(fabs(entry));
    }
    LU = next;
  }
  return sum;
}

/* dv += V phi and l += L phi, in the blocks and rows of each island. */
static void add_forces(const nsdae_border *b, const nsdae_terms *T, const double *phi, double *dv,
                       double *l)
{
  const nsdae_border_islands *is = &b->islands;
  const nsdae_blocks *blocks = &T->system->blocks;
  for (int block = 0; block < blocks->count; block++) {
    int island = is->of_block[block], at = blocks->first[block];
    for (int i = island < 0 ? 0 : is->first[island]; island >= 0 && i < is->first[island + 1]; i++)
      nsdae_add(nsdae_blocks_size(blocks, block), phi[is->force[i]],
                b->V + (size_t)(i - is->first[island]) * (size_t)b->kkt->n + at, dv + at);
  }
  for (int j = 0; j < b->kkt->m; j++) {
    int block = block_of(&T->by.jacobian, j), island = block < 0 ? -1 : is->of_block[block];
    for (int i = island < 0 ? 0 : is->first[island]; island >= 0 && i < is->first[island + 1]; i++)
      l[j] +=
          phi[is->force[i]] * b->L[(size_t)(i - is->first[island]) * (size_t)b->kkt->m + (size_t)j];
  }
}

int nsdae_border_solve(const nsdae_border *b, const nsdae_terms *T, double *dv, double *l,
                       double *phi)
{
  const nsdae_border_islands *is = &b->islands;
  int status = nsdae_kkt_solve(b->kkt, 1, dv, b->kkt->n, l, b->kkt->m);
  if (status < 0 || b->count == 0) return status;
  for (int a = 0; a < b->count; a++) phi[a] -= product(b, T, a, dv, l);
  double *LU = is->count == 1 ? b->B : is->LU;
  for (int i = 0, ld; i < is->count; i++) {
    const int *force = is->force + is->first[i], count = is->first[i + 1] - is->first[i];
    double *next = factors_of(b, i, LU, &ld);
    for (int a = 0; a < count; a++) is->part[a] = phi[force[a]];
    nsdae_la_lu_solve(count, LU, ld, b->pivot + is->first[i], is->part);
    for (int a = 0; a < count; a++) phi[force[a]] = is->part[a];
    LU = next;
  }
  add_forces(b, T, phi, dv, l);
  return NSDAE_OK;
}
