/* A random mechanism, fixed by its seed, that is described several times: dense, and by blocks with
 * the same contacts numbered or by list.
 *
 *   M constant by blocks,  F = -g - c v - s q,   phi_i = sum a_j (q_j + sin(q_j) / 10) - r_i t -
 * o_i g_N the same over two blocks or one and the ground, W_T and W_S of frictional joints constant
 */
#ifndef NSDAE_TESTS_TWIN_H
#define NSDAE_TESTS_TWIN_H

#include <stdint.h>

#include <nsdae/nsdae.h>

enum { TWIN_BLOCKS = 48, TWIN_V = 160, TWIN_M = 48, TWIN_K = 64, TWIN_WIDE = 7 };

typedef struct twin_row {
  int block[2]; /* -1: none */
  double a[2][TWIN_WIDE], rate, offset;
} twin_row;

typedef struct twin {
  int blocks, nv, m, k, nt, f;
  int size[TWIN_BLOCKS], first[TWIN_BLOCKS];
  double M[TWIN_BLOCKS][TWIN_WIDE * TWIN_WIDE];
  double g[TWIN_V], c[TWIN_V], s[TWIN_V];
  twin_row phi[TWIN_M], gap[TWIN_K], tangent[TWIN_K], slide[TWIN_M];
  double mu[TWIN_K], e_n[TWIN_K], slide_mu[TWIN_M];
  double q0[TWIN_V], v0[TWIN_V];
  long id_of_first; /* contact i has the id id_of_first - 3 i */
  /* of the list: a call that fails, from 0 (-1: none), with this code; calls so far */
  long fail_at, calls;
  int fail_code;
  int wrong_row, wrong_contact; /* whose first entry is off by 1e-3; -1: none */
  nsdae_contact spoil;          /* added by the call that fails where its mu is not 0 */
} twin;

/* What is drawn. */
typedef struct twin_kind {
  int blocks,
      largest; /* size of a block: 1 .. largest, and one of TWIN_WIDE where that is larger */
  int joined;  /* rows of constraints between neighbours: all of them, or none */
  int k, nt;
  double friction, restitution; /* upper ends */
  int f;                        /* frictional joints: the first constraints */
} twin_kind;

void twin_draw(twin *t, uint64_t seed, const twin_kind *kind);

/* How Phi_q and W_S are given; by differences: W_S as a matrix. */
enum { TWIN_BY_ROWS, TWIN_BY_MATRIX, TWIN_BY_DIFFERENCES };

/* The descriptions; t must outlive them. NULL without memory. */
nsdae_system *twin_dense(twin *t);
nsdae_system *twin_blocks(twin *t);
nsdae_system *twin_numbered(twin *t, int constraints);

#endif
