/* Contact laws as rows of the complementarity problem  y = A x + b,  0 <= x _|_ y >= 0.
 *
 * A contact has c columns of W: its normal and, with friction, its tangential directions. A law
 * has r rows and is three small matrices: with the impulses  [Lambda_N; Lambda_T] = E_Q x  and the
 * velocities  xi = [xi_N; xi_T]  of the contact,  y = E_P^T xi + N x.
 *
 *   frictionless (r = 1)   x = Lambda_N,                       y = xi_N
 *   planar (r = 3)         x = [Lambda_N, Lambda_R, xi_L],     y = [xi_N, xi_R, Lambda_L]
 *       Lambda_T = Lambda_R - mu Lambda_N,  Lambda_L = 2 mu Lambda_N - Lambda_R,
 *       xi_R = xi_T + xi_L                     (Zhang, Gu, Sun, Eqs. 25-29)
 *   sliding (r = 1)        x = Lambda_N,  y = xi_N,  Lambda_T = -mu Lambda_N d,  the direction d of
 *                          sliding being known
 *   polygon (r = p + 2)    x = [Lambda_N, Lambda_D, gamma],
 *                          y = [xi_N, gamma 1 + D^T xi_T, mu Lambda_N - 1^T Lambda_D]
 *       Lambda_T = D Lambda_D, the columns of D being p directions around the circle
 *                                              (Eqs. 20-23; Stewart and Trinkle 1996)
 *   cone (3)               Coulomb's cone itself, no complementarity problem: x = Lambda, y = xi;
 *                          see cones.h */
#ifndef NSDAE_CONTACT_LAW_H
#define NSDAE_CONTACT_LAW_H

#include <stddef.h>

enum { NSDAE_LAW_COLUMNS = 3, NSDAE_POLYGON_MAX = 32, NSDAE_LAW_ROWS = NSDAE_POLYGON_MAX + 2 };

/* Edges where a polygon is only where the way to the cone begins. */
enum { NSDAE_POLYGON_START = 8 };

typedef enum nsdae_law_kind {
  NSDAE_FRICTIONLESS,
  NSDAE_PLANAR,
  NSDAE_POLYGON,
  NSDAE_SLIDING,
  NSDAE_CONE
} nsdae_law_kind;

/* The matrices follow from these. */
typedef struct nsdae_law {
  nsdae_law_kind kind;
  int columns, rows;
  double mu;
  double d[2];        /* of sliding */
  const double *edge; /* the columns of D of a polygon */
} nsdae_law;

/* The columns of D of that number of edges, at most NSDAE_POLYGON_MAX. */
void nsdae_law_edges(int edges, double *edge);

/* Rows of a contact with nt tangential directions and a polygon of edges directions or, with edges
 * = 0, the cone if nt = 2; frictionless if nt = 0 or mu = 0. */
static inline int nsdae_law_rows(int nt, double mu, int edges)
{
  if (nt == 0 || mu == 0) return 1;
  return nt == 1 || edges == 0 ? 3 : edges + 2;
}

/* Its law; the columns of D must outlive it. */
static inline nsdae_law nsdae_law_make(int nt, double mu, int edges, const double *edge)
{
  nsdae_law law = {NSDAE_FRICTIONLESS, 1, nsdae_law_rows(nt, mu, edges), mu, {0}, edge};
  if (nt == 0 || mu == 0) return law;
  law.kind = nt == 1 ? NSDAE_PLANAR : edges == 0 ? NSDAE_CONE : NSDAE_POLYGON;
  law.columns = 1 + nt;
  return law;
}

/* Edges of the polygon that is the start alone. */
static inline int nsdae_law_edges_to_start(int edges)
{
  return edges > 0 ? edges : NSDAE_POLYGON_START;
}

/* Law of a contact that slides along the unit vector d [nt]. */
nsdae_law nsdae_law_sliding(int nt, double mu, const double *d);

/* [Lambda_N; Lambda_T] = E_Q x; returns the largest sum of the absolute terms of an entry. */
double nsdae_law_impulse(const nsdae_law *law, const double *x, double *impulse);
/* g E_Q of a row g, its entries this far apart; y = E_P^T xi. */
void nsdae_law_times_impulse(const nsdae_law *law, const double *g, size_t apart, double *row);
void nsdae_law_velocity(const nsdae_law *law, const double *xi, double *y);

/* Adds N to the r x r diagonal block of A. */
void nsdae_law_add_coupling(const nsdae_law *law, double *A, int lda);

/* enum nsdae_mode of the contact from its part x of a solution; not of a cone. */
int nsdae_law_mode(const nsdae_law *law, const double *x);

#endif
