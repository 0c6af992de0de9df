#include "newton_system.h"

#include <math.h>
#include <nsdae/status.h>
#include <string.h>

#include "dense.h"
#include "vector.h"

/* Contacts of a local form up to which dense algebra is the faster. */
enum { DENSE = 24 };

static void lay_out_system(void *object, nsdae_arena *arena)
{
  nsdae_fc_system *m = object;
  const nsdae_fc_scaled *c = m->fc;
  m->pairs = 0;
  for (int k = 0; k < c->n && !m->dense; k++) {
    size_t parts = (size_t)(c->parts.first[k + 1] - c->parts.first[k]);
    m->pairs += c->local ? parts : parts * parts;
  }
  m->lu = NSDAE_ARENA_DOUBLES(arena, m->dense ? 9L * c->n * c->n : 0);
  m->pivot = NSDAE_ARENA_INTS(arena, m->dense ? 3L * c->n : 0);
  m->couple = NSDAE_ARENA_INTS(arena, c->local ? 2 * (long)m->pairs : 0);
  m->begin = NSDAE_ARENA_INTS(arena, c->local ? (long)m->pairs + 1 : 0);
  m->place = nsdae_arena_take(arena, (long)m->pairs, sizeof(size_t));
  nsdae_arena_doubles(arena, 9L * c->n, (double **[]){&m->E, &m->K, &m->E_inverse, NULL});
  m->dy = NSDAE_ARENA_DOUBLES(arena, c->ny);
}

/* ---- matrices of three rows, row-major */

/* y = A x */
static inline void apply(const double *A, const double *x, double *y)
{
  for (int i = 0; i < 3; i++) y[i] = A[3 * i] * x[0] + A[3 * i + 1] * x[1] + A[3 * i + 2] * x[2];
}

/* C = A B */
static inline void multiply(const double *A, const double *B, double *C)
{
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++)
      C[3 * i + j] = A[3 * i] * B[j] + A[3 * i + 1] * B[3 + j] + A[3 * i + 2] * B[6 + j];
}

/* Gauss-Jordan elimination with row pivoting. Returns 0, or 1 if A is singular or not finite. */
static inline int invert(const double *A, double *inverse)
{
  double a[3][6];
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 6; j++) a[i][j] = j < 3 ? A[3 * i + j] : j == i + 3;
  for (int k = 0; k < 3; k++) {
    int p = k;
    for (int i = k + 1; i < 3; i++)
      if (fabs(a[i][k]) > fabs(a[p][k])) p = i;
    double pivot = a[p][k];
    if (!(fabs(pivot) > 0 && fabs(pivot) < INFINITY)) return 1;
    for (int j = 0; j < 6; j++) {
      double held = a[p][j] / pivot;
      a[p][j] = a[k][j];
      a[k][j] = held;
    }
    for (int i = 0; i < 3; i++) {
      double factor = a[i][k];
      for (int j = 0; j < 6 && i != k; j++) a[i][j] -= factor * a[k][j];
    }
  }
  for (int i = 0; i < 9; i++) inverse[i] = a[i / 3][3 + i % 3];
  return 0;
}

/* ---- symbolic analysis */

/* Blocks that share an item are neighbours; of the local form items of which one has a part of the
 * other: the transposed part of W may be zero and missing. */
static int build_graph(nsdae_fc_system *m)
{
  const nsdae_fc_scaled *c = m->fc;
  nsdae_joined lists = {c->n, c->parts.first, c->parts.block};
  if (c->local) m->begin[0] = 0;
  for (int k = 0; k < c->n && c->local; k++)
    for (int e = c->parts.first[k]; e < c->parts.first[k + 1]; e++) {
      m->couple[2 * e] = k;
      m->couple[2 * e + 1] = c->parts.block[e];
      m->begin[e + 1] = 2 * (e + 1);
    }
  if (c->local) lists = (nsdae_joined){c->parts.entries, m->begin, m->couple};
  return nsdae_adjacency_build(&m->graph, &lists, c->blocks, 0);
}

/* Of a factorisation, without its assembly: LAPACK does about FASTER times as many operations in a
 * second as the loops of a product. With 12 products for all else of a step, a step is counted as
 * 15 to 32 products; on walls, towers and storeys of 1000 and 8000 contacts it takes 16 to 40. LU
 * of p columns of a front of p + r. */
static double price(const nsdae_fc_system *m)
{
  static const double FASTER = 4;
  double n = 3.0 * m->fc->n, operations = m->dense ? 2 * n * n * n / 3 : 0;
  for (int s = 0; s < m->fronts.super.count && !m->dense; s++) {
    double p = m->fronts.super.pivots[s], r = m->fronts.super.rest[s];
    operations += 2 * p * (p * p / 3 + p * r + r * r);
  }
  return operations / (2.0 * (double)m->fc->parts.values + 1) / FASTER;
}

int nsdae_fc_system_analyse(nsdae_fc_system *m, const nsdae_fc_scaled *c)
{
  m->fc = c;
  m->dense = c->local && (c->all_listed || c->n <= DENSE);
  int status = nsdae_arena_fit(&m->memory, lay_out_system, m);
  if (status == NSDAE_OK && !m->dense) {
    status = build_graph(m);
    if (status == NSDAE_OK)
      status = nsdae_multifrontal_analyse(&m->fronts, c->blocks, c->parts.size, m->graph.first,
                                          m->graph.index);
    /* Where the blocks of the pairs are: of all pairs of an item, or (local form) of it with each.
     */
    const int *block = c->parts.block;
    size_t *place = m->place;
    for (int k = 0; k < c->n && status == NSDAE_OK; k++)
      for (int e = c->parts.first[k]; e < c->parts.first[k + 1]; e++) {
        if (c->local) *place++ = nsdae_multifrontal_block(&m->fronts, k, block[e]);
        for (int f = c->parts.first[k]; f < c->parts.first[k + 1] && !c->local; f++)
          *place++ = nsdae_multifrontal_block(&m->fronts, block[e], block[f]);
      }
  }
  if (status == NSDAE_OK) m->cost = price(m);
  return status;
}

/* ---- assembly and factorisation */

/* T [a x b] += Ja K Jb^T, Ja [a x 3] and Jb [b x 3] column-major, K row-major */
static void add_product(int a, int b, const double *Ja, const double *K, const double *Jb,
                        double *T)
{
  for (int j = 0; j < b; j++) {
    double k[3];
    for (int l = 0; l < 3; l++)
      k[l] = K[3 * l] * Jb[j] + K[3 * l + 1] * Jb[b + j] + K[3 * l + 2] * Jb[2 * b + j];
    for (int i = 0; i < a; i++)
      T[j * a + i] += Ja[i] * k[0] + Ja[a + i] * k[1] + Ja[2 * a + i] * k[2];
  }
}

/* 1 + J K J^T */
static void assemble_global(nsdae_fc_system *m)
{
  const nsdae_fc_scaled *c = m->fc;
  const size_t *place = m->place;
  double *T = m->fronts.A;
  for (int b = 0; b < c->blocks; b++)
    for (int j = 0; j < c->parts.size[b]; j++)
      T[m->fronts.graph.diagonal[b] + (size_t)j * ((size_t)c->parts.size[b] + 1)] = 1;
  for (int k = 0; k < c->n; k++)
    for (int e = c->parts.first[k]; e < c->parts.first[k + 1]; e++)
      for (int f = c->parts.first[k]; f < c->parts.first[k + 1]; f++)
        add_product(c->parts.size[c->parts.block[e]], c->parts.size[c->parts.block[f]],
                    nsdae_fc_part(c, e), m->K + 9 * (size_t)k, nsdae_fc_part(c, f), T + *place++);
}

/* E + A W, into the fronts or the dense matrix. W_kj row-major is the part of item k. */
static void assemble_local(nsdae_fc_system *m)
{
  const nsdae_fc_scaled *c = m->fc;
  size_t ld = m->dense ? 3 * (size_t)c->n : 3;
  for (int k = 0; k < c->n; k++) {
    const double *A = m->K + 9 * (size_t)k, *E = m->E + 9 * (size_t)k;
    double *row = m->lu + 3 * k; /* of the dense matrix */
    double *D = m->dense ? row + 3 * (size_t)k * ld : m->fronts.A + m->fronts.graph.diagonal[k];
    for (int e = c->parts.first[k]; e < c->parts.first[k + 1]; e++) {
      double *T = m->dense ? row + 3 * (size_t)c->parts.block[e] * ld : m->fronts.A + m->place[e];
      const double *W = nsdae_fc_part(c, e);
      for (size_t i = 0; i < 3; i++)
        for (size_t l = 0; l < 3; l++)
          T[ld * l + i] += A[3 * i] * W[l] + A[3 * i + 1] * W[3 + l] + A[3 * i + 2] * W[6 + l];
    }
    for (size_t i = 0; i < 3; i++)
      for (size_t l = 0; l < 3; l++) D[ld * l + i] += E[3 * i + l];
  }
}

int nsdae_fc_system_factor(nsdae_fc_system *m, const double *E, const double *A)
{
  const nsdae_fc_scaled *c = m->fc;
  size_t values = m->dense ? 9 * (size_t)c->n * (size_t)c->n : m->fronts.values;
  memset(m->dense ? m->lu : m->fronts.A, 0, values * sizeof *m->lu);
  memcpy(m->E, E, 9 * (size_t)c->n * sizeof *E);
  for (int k = 0; k < c->n; k++) {
    const double *block = A + 9 * (size_t)k;
    double *K = m->K + 9 * (size_t)k, *inverse = m->E_inverse + 9 * (size_t)k;
    if (c->local)
      memcpy(K, block, 9 * sizeof *K);
    else {
      if (invert(E + 9 * (size_t)k, inverse) != 0) return 1;
      multiply(inverse, block, K);
    }
  }
  if (c->local)
    assemble_local(m);
  else
    assemble_global(m);
  if (m->dense) return nsdae_la_lu(3 * c->n, m->lu, 3 * c->n, m->pivot);
  return nsdae_multifrontal_factor(&m->fronts, 0);
}

/* ---- solution */

/* dr = E^-1 b - K J^T dy with (1 + J K J^T) dy = J E^-1 b: see newton_system.h. */
void nsdae_fc_system_solve(nsdae_fc_system *m, const double *b, double *dr)
{
  const nsdae_fc_scaled *c = m->fc;
  if (c->local) {
    memcpy(dr, b, 3 * (size_t)c->n * sizeof *dr);
    if (m->dense)
      nsdae_la_lu_solve(3 * c->n, m->lu, 3 * c->n, m->pivot, dr);
    else
      nsdae_multifrontal_solve(&m->fronts, dr);
    return;
  }
  memset(m->dy, 0, (size_t)c->ny * sizeof *m->dy);
  for (int k = 0; k < c->n; k++) {
    apply(m->E_inverse + 9 * (size_t)k, b + 3 * k, dr + 3 * k);
    for (int e = c->parts.first[k]; e < c->parts.first[k + 1]; e++)
      nsdae_add_product(c->parts.size[c->parts.block[e]], 3, nsdae_fc_part(c, e), dr + 3 * k,
                        m->dy + c->parts.offset[c->parts.block[e]]);
  }
  nsdae_multifrontal_solve(&m->fronts, m->dy);
  for (int k = 0; k < c->n; k++) {
    double u[3] = {0}, x[3];
    for (int e = c->parts.first[k]; e < c->parts.first[k + 1]; e++)
      nsdae_add_transposed(c->parts.size[c->parts.block[e]], 3, 1, nsdae_fc_part(c, e),
                           m->dy + c->parts.offset[c->parts.block[e]], u);
    apply(m->K + 9 * (size_t)k, u, x);
    for (int j = 0; j < 3; j++) dr[3 * k + j] -= x[j];
  }
}

void nsdae_fc_system_release(nsdae_fc_system *m)
{
  nsdae_adjacency_release(&m->graph);
  nsdae_multifrontal_release(&m->fronts);
  nsdae_arena_release(&m->memory);
}
