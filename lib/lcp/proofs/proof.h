/* Proofs that a problem has no solution, and what a ray of Lemke's method proves. */
#ifndef NSDAE_PROOF_H
#define NSDAE_PROOF_H

#include "work.h"

/* The distance of a point from a polyhedral cone. */

/* The cone of all C z with z >= 0, and z_j = 0 where j is not allowed; workspace. */

typedef struct nsdae_cone {
  int n, m;
  const double *C; /* n x m, column-major, columns of norm one or zero */
  int *allowed;    /* m */
  double *z;       /* m, out */
  double *w;       /* n, out */
  double *gram;    /* n x n */
  double *factor;  /* n x n */
  double *s;       /* n */
  int *order;      /* n */
  int *state;      /* m */
} nsdae_cone;

/* w = C z - b for the z that makes its norm least, |b| = 1. Then C_j^T w >= 0 for all allowed j and
 * b^T w = -|w|^2: w separates b from the cone, or is of rounding size where b is in it. Returns 0;
 * 1 where the iteration came to no end. */
int nsdae_cone_separate(const nsdae_cone *c, const double *b);

/* ---- Signs of sums of products, without rounding. */

enum { NSDAE_SIGN_UNKNOWN = 2 };

/* Sign -1, 0 or 1 of the exact value of sum_i a_i u_i, i < n, with the entries of a stride apart;
 * NSDAE_SIGN_UNKNOWN where products are too far apart in size for it, or a factor is not finite. */
int nsdae_exact_sign(int n, const double *a, int stride, const double *u);

/* Data that are small integers have a w whose entries are in the ratio of integers: w becomes
 * those, the least ones, or else is rounded 24 places below its largest entry. */
void nsdae_to_integers(int n, double *w);

/* Largest problem for which a separating vector is looked for. */
enum { NSDAE_PROOF_MAX = 400 };

/* Stage NSDAE_LCP_PROVE. Returns whether the chain has ended: proved, or a solution found by the
 * way. */
int nsdae_lcp_prove(nsdae_lcp_work *w);

/* Every choice of active sets, cut short where a partial one is proved empty. Returns as above. */
int nsdae_lcp_prove_all(nsdae_lcp_work *w);

/* Largest problem whose ray is looked at. */
enum { NSDAE_RAY_MAX = 60 };

/* Sets info->ray from the basis in w->trial, on which Lemke's method with the covering vector of
 * ones ended without a blocking row. */
void nsdae_lcp_read_ray(nsdae_lcp_work *w);

#endif
