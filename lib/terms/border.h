/* Saddle-point equations with a border of a row and a column for each unknown force phi_a, along
 * w_a:
 *
 *   A dv + J^T l - W phi = r,    J dv = c
 *   G_a . dv + h_a l_j(a) + B_a . phi = s_a,   G_a = sum_p factor_p row_p
 *
 * [V; L] := K^-1 [W; 0] with the saddle-point matrix K gives dv = dv_0 + V phi, l = l_0 + L phi,
 * and a dense system (B + G^T V + h L) phi = s - G^T dv_0 - h l_0 of as many unknowns as forces.
 *
 * Blocks that share a row of J, a force or an entry of B are an island: V, L and the dense system
 * are zero between islands. One solution with K serves a force of each of them. */
#ifndef NSDAE_TERMS_BORDER_H
#define NSDAE_TERMS_BORDER_H

#include "terms.h"

/* The row and column of a force; up to a normal and two tangents in its row of G. */
typedef struct nsdae_border_row {
  const nsdae_rows *rows; /* w_a: row index of these */
  int index, parts;
  struct {
    const nsdae_rows *rows;
    int index;
    double factor;
  } part[3];
  int multiplier; /* j(a), or -1 */
  double h;
} nsdae_border_row;

typedef struct nsdae_border_islands {
  int count, columns; /* islands with a force; the most forces of one */
  int *parent;        /* blocks: sets of them */
  int *of_block;      /* blocks: the island, -1 without a force */
  int *column;        /* most: of V and L, which a force of each island shares */
  int *first, *force; /* most + 1, most: the forces of each island, in their order */
  double *LU, *part;  /* most x most, of one after another; most */
} nsdae_border_islands;

typedef struct nsdae_border {
  const nsdae_kkt *kkt;           /* factors of K */
  const nsdae_coupling *coupling; /* of blocks in A; or NULL */
  int most, count;
  nsdae_border_row *row; /* most */
  double *V, *L;         /* nv x most, m x most */
  double *B;             /* most x most; of one island, then LU factors */
  int *pivot;            /* most, of each island from 1 */
  nsdae_border_islands islands;
} nsdae_border;

/* Takes the arrays for `most` forces. */
void nsdae_border_layout(nsdae_border *border, const nsdae_system *system, int most,
                         nsdae_arena *arena);

/* Appends a force along row i; its row of G, h and B is zero. Returns its number; count = 0 begins
 * anew. */
int nsdae_border_add(nsdae_border *border, const nsdae_rows *rows, int i);
/* G_a += factor row_i; entry of B. */
void nsdae_border_depend(nsdae_border *border, int a, const nsdae_rows *rows, int i, double factor);
static inline double *nsdae_border_entry(nsdae_border *border, int a, int c)
{
  return &border->B[(size_t)c * (size_t)border->most + (size_t)a];
}

/* Solves for V and L and factors the border. NSDAE_E_CONVERGENCE if it is singular. */
int nsdae_border_factor(nsdae_border *border, const nsdae_terms *terms);

/* log |det| of the border that is factored, and its sign. */
double nsdae_border_determinant(const nsdae_border *border, int *sign);

/* K^-1 w_a [nv], with those of other islands. */
static inline const double *nsdae_border_response(const nsdae_border *border, int a)
{
  return border->V + (size_t)border->islands.column[a] * (size_t)border->kkt->n;
}

/* dv [nv], l [m], phi [count] from r, c, s in their places. */
int nsdae_border_solve(const nsdae_border *border, const nsdae_terms *terms, double *dv, double *l,
                       double *phi);

#endif
