/* Blocks that are coupled, so that the Schur complement of their rows is
 * dense. The whole matrix is factored,
 *
 *     [ A   J^T                       ]
 *     [ J   -eps diag(J diag(A)^-1 J^T) ]      diag(A): blocks
 *
 * which is quasi-definite for eps > 0: it has factors L S L^T, with signs S by rows, in every order
 * (Vanderbei, SIAM J. Optim. 5 (1995) 100). Rows are eliminated after one of their blocks, so that
 * their pivots are seldom as small as eps. */
#include "sparse_schur.h"

#include <string.h>

#include <nsdae/status.h>

#include "vector.h"

/* The regularisation, in parts of what it is added to. Refinement removes it: each round leaves the
 * part eps / sine^2 of the error, with the smallest sine of a row to the others, which is 1e-6 at
 * least (sparse_kkt.h). Rounding is the least that it can be: 50 DBL_EPSILON. */
static const double EPS = 1e-14;

static int size_of(const nsdae_sparse_kkt *k, int block)
{
  return nsdae_blocks_size(&k->at.blocks, block);
}

/* ---- the graph */

static size_t values_of(const nsdae_sparse_kkt *k, const nsdae_coupling *C)
{
  size_t values = 0;
  for (int p = 0; p < C->count; p++)
    values += (size_t)size_of(k, C->pair[2 * p]) * (size_t)size_of(k, C->pair[2 * p + 1]);
  return values;
}

typedef struct layout {
  nsdae_sparse_kkt *k;
  const nsdae_coupling *C;
} layout;

static void lay_out(void *object, nsdae_arena *arena)
{
  const layout *of = object;
  const nsdae_sparse_kkt *k = of->k;
  nsdae_kkt_whole *w = &of->k->whole;
  long nodes = (long)k->at.blocks.count + k->nodes.count, pairs = of->C->count,
       edges = pairs + k->nodes.part[k->nodes.count];
  w->pair = NSDAE_ARENA_INTS(arena, 2 * pairs);
  w->value = NSDAE_ARENA_DOUBLES(arena, values_of(k, of->C));
  w->size = NSDAE_ARENA_INTS(arena, nodes);
  w->edge = NSDAE_ARENA_INTS(arena, 2 * edges);
  w->begin = NSDAE_ARENA_INTS(arena, edges + 1);
  w->left_out = NSDAE_ARENA_INTS(arena, k->part.row_count);
  w->x = NSDAE_ARENA_DOUBLES(arena, k->at.blocks.first[k->at.blocks.count] + k->part.row_count);
}

/* Keeps what was analysed for the same pairs. */
static int analyse_pairs(nsdae_sparse_kkt *k, const nsdae_coupling *C)
{
  nsdae_kkt_whole *w = &k->whole;
  const nsdae_kkt_nodes *n = &k->nodes;
  int blocks = k->at.blocks.count, nodes = blocks + n->count, edges = C->count;
  size_t bytes = 2 * (size_t)C->count * sizeof *C->pair;
  if (w->ready && w->count == C->count && memcmp(w->pair, C->pair, bytes) == 0) return NSDAE_OK;
  w->ready = 0;
  if (nsdae_arena_fit(&w->arena, lay_out, &(layout){k, C}) != NSDAE_OK) return NSDAE_E_MEMORY;
  w->count = C->count;
  memcpy(w->pair, C->pair, bytes);
  for (int b = 0; b < blocks; b++) w->size[b] = size_of(k, b);
  for (int i = 0; i < n->count; i++) w->size[blocks + i] = n->size[i];
  /* Pairs of neighbours: coupled blocks, and each node of rows with the blocks that it touches. */
  memcpy(w->edge, w->pair, bytes);
  for (int i = 0; i < n->count; i++)
    for (int p = n->part[i]; p < n->part[i + 1]; p++, edges++) {
      w->edge[2 * edges] = n->block[p];
      w->edge[2 * edges + 1] = blocks + i;
    }
  for (int e = 0; e <= edges; e++) w->begin[e] = 2 * e;
  const nsdae_joined joined = {edges, w->begin, w->edge};
  w->fronts.negative = blocks;
  int status = nsdae_adjacency_build(&w->graph, &joined, nodes, 0);
  if (status == NSDAE_OK)
    status = nsdae_multifrontal_analyse(&w->fronts, nodes, w->size, w->graph.first, w->graph.index);
  w->ready = status == NSDAE_OK;
  return status;
}

/* ---- the matrix */

/* The block of nodes a and b in the rows of the one that is eliminated last; by_b: those of b. */
static double *block_of(const nsdae_kkt_whole *w, int a, int b, int *by_b)
{
  *by_b = w->fronts.tree.number[b] > w->fronts.tree.number[a];
  return w->fronts.A + nsdae_multifrontal_block(&w->fronts, *by_b ? b : a, *by_b ? a : b);
}

/* Row `row` of a node of rows in its blocks, zeros if it is left out. */
static void put_row(const nsdae_sparse_kkt *k, int node, int row)
{
  const nsdae_kkt_whole *w = &k->whole;
  const nsdae_kkt_nodes *n = &k->nodes;
  int at = row - n->row[node], size = n->size[node], by_rows;
  double own = 0, part = w->left_out[row] ? 0 : 1;
  for (int p = n->part[node]; p < n->part[node + 1]; p++) {
    int columns = size_of(k, n->block[p]);
    const double *J = k->at.J + n->at[p] + at * columns, *Y = k->at.Y + n->at[p] + at * columns;
    double *to = block_of(w, n->block[p], k->at.blocks.count + node, &by_rows);
    for (int j = 0; j < columns; j++) to[by_rows ? j * size + at : at * columns + j] = part * J[j];
    own += nsdae_dot(columns, Y, Y);
  }
  double *diagonal = w->fronts.A + w->fronts.graph.diagonal[k->at.blocks.count + node];
  for (int j = 0; j < size; j++) diagonal[at * size + j] = 0;
  diagonal[at * (size + 1)] = part > 0 && own > 0 ? -EPS * own : -1;
}

int nsdae_sparse_kkt_factor_coupled(nsdae_sparse_kkt *k, const double *A, const nsdae_coupling *C,
                                    const double *keep)
{
  nsdae_kkt_whole *w = &k->whole;
  int rows = k->part.row_count;
  int status = analyse_pairs(k, C);
  if (status == NSDAE_OK) status = nsdae_sparse_kkt_transform_rows(k, A);
  if (status < 0) return status;
  memcpy(w->value, C->value, values_of(k, C) * sizeof *w->value);
  k->coupled = 1;
  k->rank = (nsdae_kkt_rank){.count = rows, .chosen = 1, .dependent = -1, .kept = 1};
  for (int i = 0; i < rows; i++) k->rank.count -= w->left_out[i] = keep && keep[i] == 0;
  const nsdae_blocks *b = &k->at.blocks;
  const double *value = w->value;
  for (int i = 0; i < b->count; i++)
    memcpy(w->fronts.A + w->fronts.graph.diagonal[i], k->at.M + b->square[i],
           (b->square[i + 1] - b->square[i]) * sizeof *value);
  for (int p = 0; p < w->count; p++) {
    int i = w->pair[2 * p], j = w->pair[2 * p + 1], n = size_of(k, i), by_column;
    double *to = block_of(w, i, j, &by_column);
    for (int c = 0; c < size_of(k, j); c++)
      for (int r = 0; r < n; r++) to[by_column ? r * size_of(k, j) + c : c * n + r] = *value++;
  }
  for (int i = 0; i < k->nodes.count; i++)
    for (int row = k->nodes.row[i]; row < k->nodes.row[i + 1]; row++) put_row(k, i, row);
  return nsdae_multifrontal_factor(&w->fronts, 1) == 0 ? NSDAE_OK : NSDAE_E_MASS;
}

/* ---- products and solutions */

void nsdae_sparse_whole_add_product(const nsdae_sparse_kkt *k, const double *x, double *g)
{
  const nsdae_kkt_whole *w = &k->whole;
  const double *value = w->value;
  for (int p = 0; p < w->count; p++) {
    int i = w->pair[2 * p], j = w->pair[2 * p + 1], rows = size_of(k, i), columns = size_of(k, j);
    int row = k->at.blocks.first[i], column = k->at.blocks.first[j];
    for (int c = 0; c < columns; c++, value += rows) {
      nsdae_add(rows, x[column + c], value, g + row);
      g[column + c] += nsdae_dot(rows, value, x + row);
    }
  }
}

void nsdae_sparse_whole_solve(const nsdae_sparse_kkt *k)
{
  const nsdae_kkt_whole *w = &k->whole;
  const nsdae_kkt_values *a = &k->at;
  size_t n = (size_t)a->blocks.first[a->blocks.count], m = (size_t)k->part.row_count;
  memcpy(w->x, a->g, n * sizeof *w->x);
  for (size_t i = 0; i < m; i++) w->x[n + i] = w->left_out[i] ? 0 : a->d[i];
  nsdae_multifrontal_solve(&w->fronts, w->x);
  memcpy(a->z, w->x, n * sizeof *a->z);
  memcpy(a->h, w->x + n, m * sizeof *a->h);
}
