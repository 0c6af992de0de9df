/* Saddle-point equations with a border of a row and a column for each unknown force phi_a, along
 * w_a:
 *
 *   A dv + J^T l - W phi = r,    J dv = c
 *   G_a . dv + h_a l_j(a) + B_a . phi = s_a,   G_a = sum_p factor_p row_p
 *
 * [V; L] := K^-1 [W; 0] with the saddle-point matrix K gives dv = dv_0 + V phi, l = l_0 + L phi,
 * and a dense system (B + G^T V + h L) phi = s - G^T dv_0 - h l_0 of as many unknowns as forces. */
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

typedef struct nsdae_border {
  const nsdae_kkt *kkt; /* factors of K */
  int most, count;
  nsdae_border_row *row; /* most */
  double *V, *L;         /* nv x most, m x most */
  double *B;             /* most x most, then LU factors with `pivot` */
  int *pivot;            /* most */
} nsdae_border;

/* Takes the arrays for `most` forces. */
void nsdae_border_layout(nsdae_border *border, const nsdae_dims *dims, int most,
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

/* dv [nv], l [m], phi [count] from r, c, s in their places. */
int nsdae_border_solve(const nsdae_border *border, const nsdae_terms *terms, double *dv, double *l,
                       double *phi);

#endif
