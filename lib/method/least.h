/* The least change d, in the metric of M, that meets rows:
 *
 *   min d^T M d / 2 - r^T d,  J d = c        M d + J^T l = r,  J d = c
 *
 * of positions along H, or of velocities (Ascher and Petzold, "Computer Methods for Ordinary
 * Differential Equations", 1998, section 9.2). Rows may depend on each other. */
#ifndef NSDAE_METHOD_LEAST_H
#define NSDAE_METHOD_LEAST_H

#include "terms.h"

typedef struct nsdae_least {
  nsdae_kkt kkt;
  int most, rows;          /* that there is room for; appended so far */
  nsdae_rows J;            /* copies of the rows */
  const nsdae_room *given; /* room in J of a list, set before; NULL: room for dense rows */
  nsdae_room room;         /* in J */
  int grows;               /* J has memory of its own */
  int status;              /* NSDAE_E_MEMORY: a row was lost */
  double *c;               /* most: right-hand side, then l */
  double *change;          /* nv: r, then d */
} nsdae_least;

/* The largest Phi of the terms' point as an angle, by the arm of its constraint, which is worst
 * (-1: none). By this sine it turns a dependent row out of the others, at most. Up to the last sine
 * a row is dependent, rank_tol at least. The terms have Phi and Phi_q. */
double nsdae_least_drift(const nsdae_terms *terms, int *worst);
double nsdae_least_turned(double drift);
double nsdae_least_sine(double rank_tol, double drift);

/* most: rows; 0: nothing is projected. */
void nsdae_least_layout(nsdae_least *least, const nsdae_system *system, int most, double rank_tol,
                        nsdae_arena *arena);
void nsdae_least_release(nsdae_least *least);

/* Without rows, and with r = 0. */
void nsdae_least_start(nsdae_least *least);

/* Appends row i, row_i . d = -missing. */
void nsdae_least_append(nsdae_least *least, const nsdae_rows *rows, int i, double missing);

/* So that no step takes memory: for the rows of the constraints at the terms' point, of the normals
 * of its contacts, and of their tangents and the frictional joints, or a part of them. Nothing if
 * these terms are not there, or if there are more than 2 nv rows. NSDAE_OK or NSDAE_E_MEMORY with
 * the record. */
enum nsdae_least_rows { NSDAE_LEAST_CONSTRAINTS, NSDAE_LEAST_NORMALS, NSDAE_LEAST_ALL };
int nsdae_least_reserve(nsdae_least *least, const nsdae_terms *terms, enum nsdae_least_rows rows);

/* change and c, with the terms' M. A status of nsdae_kkt_solve, with the record. */
int nsdae_least_solve(nsdae_least *least, const nsdae_terms *terms);

#endif
