#include "sparse_schur.h"

#include <math.h>
#include <string.h>

#include <nsdae/status.h>

#include "dense.h"
#include "vector.h"

/* ---- L, Y, S */

int nsdae_sparse_kkt_transform_rows(nsdae_sparse_kkt *k, const double *M)
{
  const nsdae_kkt_nodes *n = &k->nodes;
  const nsdae_rows *J = k->part.J;
  nsdae_kkt_values *a = &k->at;
  /* ---- M = L L^T */
  for (int i = 0; i < a->blocks.count; i++) {
    size_t from = k->part.blocks->square[k->part.block[i]], to = a->blocks.square[i];
    size_t square = a->blocks.square[i + 1] - to;
    int size = nsdae_blocks_size(&a->blocks, i);
    memcpy(a->M + to, M + from, square * sizeof *M);
    memcpy(a->L + to, a->M + to, square * sizeof *M);
    k->pivot = nsdae_la_cholesky(size, a->L + to, size);
    k->bad_block = k->part.block[i];
    if (k->pivot) return NSDAE_E_MASS;
  }
  /* ---- J, and Y = L^-1 J^T */
  for (int i = 0; i < n->count; i++)
    for (int p = n->part[i]; p < n->part[i + 1]; p++) {
      int size = nsdae_blocks_size(&a->blocks, n->block[p]);
      double *to = a->J + n->at[p], *Y = a->Y + n->at[p];
      for (int row = n->row[i]; row < n->row[i + 1]; row++) {
        int entry = J->first[k->part.row[row]] + p - n->part[i];
        const double *value = J->value + J->at[entry];
        for (int j = 0; j < size; j++) *to++ = value[(size_t)j * J->stride];
      }
      memcpy(Y, a->J + n->at[p], (size_t)(n->size[i] * size) * sizeof *Y);
      nsdae_la_solve_lower(size, n->size[i], a->L + a->blocks.square[n->block[p]], size, Y, size);
    }
  return NSDAE_OK;
}

/* C [rows x columns] += A^T B of columns of this size. */
static inline void add_gram(int size, int rows, int columns, const double *A, const double *B,
                            double *C)
{
  for (int c = 0; c < columns; c++, B += size, C += rows)
    for (int r = 0; r < rows; r++) C[r] += nsdae_dot(size, A + (size_t)r * (size_t)size, B);
}

/* The block of S in the rows of node a and the columns of node b. */
static void form_block(const nsdae_sparse_kkt *k, int a, int b, double *C)
{
  const nsdae_kkt_nodes *n = &k->nodes;
  const double *Y = k->at.Y;
  int rows = n->size[a], columns = n->size[b];
  memset(C, 0, (size_t)(rows * columns) * sizeof *C);
  for (int p = n->part[a]; p < n->part[a + 1]; p++)
    for (int q = n->part[b]; q < n->part[b + 1]; q++) {
      int size = nsdae_blocks_size(&k->at.blocks, n->block[p]);
      if (n->block[p] != n->block[q]) continue;
      if (size == 6) /* a body in space: the compiler unrolls the loop */
        add_gram(6, rows, columns, Y + n->at[p], Y + n->at[q], C);
      else
        add_gram(size, rows, columns, Y + n->at[p], Y + n->at[q], C);
    }
}

/* S = Y^T Y: its diagonal blocks, and those whose rows are eliminated after their columns. */
int nsdae_sparse_kkt_form_schur(nsdae_sparse_kkt *k, const double *M)
{
  const nsdae_multifrontal *f = &k->schur;
  int status = nsdae_sparse_kkt_transform_rows(k, M);
  k->coupled = 0;
  for (int i = 0; i < k->nodes.count && status == NSDAE_OK; i++) {
    form_block(k, i, i, f->A + f->graph.diagonal[i]);
    for (int e = f->graph.first[i]; e < f->graph.first[i + 1]; e++)
      if (f->tree.number[f->graph.index[e]] > f->tree.number[i])
        form_block(k, f->graph.index[e], i, f->A + f->graph.at[e]);
  }
  return status;
}

/* ---- products and solutions */

/* out [rows] = J x, or Y^T x */
void nsdae_sparse_kkt_times(const nsdae_sparse_kkt *k, const double *J, const double *x,
                            double *out)
{
  const nsdae_kkt_nodes *n = &k->nodes;
  memset(out, 0, (size_t)k->part.row_count * sizeof *out);
  for (int i = 0; i < n->count; i++)
    for (int p = n->part[i]; p < n->part[i + 1]; p++) {
      int size = nsdae_blocks_size(&k->at.blocks, n->block[p]);
      const double *value = J + n->at[p], *of = x + k->at.blocks.first[n->block[p]];
      for (int row = n->row[i]; row < n->row[i + 1]; row++, value += size)
        out[row] += nsdae_dot(size, value, of);
    }
}

/* out [nv] += scale J^T l, or Y l; size, if not NULL, += |J^T| |l| */
void nsdae_sparse_kkt_add_transposed(const nsdae_sparse_kkt *k, const double *J, double scale,
                                     const double *l, double *out, double *size)
{
  const nsdae_kkt_nodes *n = &k->nodes;
  for (int i = 0; i < n->count; i++)
    for (int p = n->part[i]; p < n->part[i + 1]; p++) {
      int at = k->at.blocks.first[n->block[p]], end = k->at.blocks.first[n->block[p] + 1];
      const double *value = J + n->at[p];
      for (int row = n->row[i]; row < n->row[i + 1]; row++)
        for (int j = at; j < end; j++, value++) {
          out[j] += scale * l[row] * *value;
          if (size) size[j] += fabs(l[row] * *value);
        }
    }
}
