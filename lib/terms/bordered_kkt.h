/* Newton's equations of an index-1 problem of mechanics, with the saddle-point matrix of
 * A = M + D / cj + K / cj^2 (newton_matrix.h) and Phi_q = J, and a border of a row and a column for
 * each force phi that is unknown:
 *
 *   A dv + J^T l - W phi = r,    J dv = c
 *   G_a . dv + h_a l_j(a) + B_a . phi = s_a
 *
 * [V; L] := K^-1 [W; 0] with the saddle-point matrix K gives dv = dv_0 + V phi, l = l_0 + L phi,
 * and a dense system (B + G^T V + h L) phi = s - G^T dv_0 - h l_0 of as many unknowns as forces. */
#ifndef NSDAE_TERMS_BORDERED_KKT_H
#define NSDAE_TERMS_BORDERED_KKT_H

#include "newton_matrix.h"

typedef struct nsdae_bordered_kkt {
  nsdae_newton_matrix matrix;
  nsdae_kkt kkt;
  int most, count; /* forces */
  int started;     /* the pattern is known */
  double *V, *L;   /* nv x most, m x most */
  double *G, *h;   /* nv x most, most */
  int *row;        /* most: j(a) */
  double *B;       /* most x most, then LU factors with `pivot` */
  int *pivot;      /* most */
} nsdae_bordered_kkt;

/* Takes the arrays; make allocates more, which release frees. NSDAE_OK or NSDAE_E_MEMORY. */
void nsdae_bordered_layout(nsdae_bordered_kkt *b, const nsdae_system *system, int most,
                           double rank_tol, nsdae_arena *arena);
int nsdae_bordered_make(nsdae_bordered_kkt *b);
void nsdae_bordered_release(nsdae_bordered_kkt *b);

/* The pattern of A and the sparse factors' analysis at the terms' point, once: allocates what a run
 * needs. NSDAE_OK, NSDAE_E_MEMORY, what the terms and callbacks return. */
int nsdae_bordered_start(nsdae_bordered_kkt *b, nsdae_terms *terms);

/* Factors K at the terms' point, with the independent rows of a basis (nsdae_kkt_factor_in); no
 * force yet. A status with the record. */
int nsdae_bordered_factor(nsdae_bordered_kkt *b, nsdae_terms *terms, double cj, const double *basis,
                          int rank);

/* Appends a force along row i; its G, h and B are zero. Returns its number. */
int nsdae_bordered_add(nsdae_bordered_kkt *b, const nsdae_terms *terms, const nsdae_rows *rows,
                       int i);
/* G_a += factor row_i; entry of B. */
void nsdae_bordered_depend(nsdae_bordered_kkt *b, const nsdae_terms *terms, int a,
                           const nsdae_rows *rows, int i, double factor);
static inline double *nsdae_bordered_entry(nsdae_bordered_kkt *b, int a, int c)
{
  return &b->B[(size_t)c * (size_t)b->most + (size_t)a];
}

/* Factors the border. NSDAE_E_CONVERGENCE if it is singular. */
int nsdae_bordered_finish(nsdae_bordered_kkt *b, const nsdae_terms *terms);

/* dv [nv], l [m], phi [count] from r, c, s in their places. */
int nsdae_bordered_solve(const nsdae_bordered_kkt *b, const nsdae_terms *terms, double *dv,
                         double *l, double *phi);

#endif
