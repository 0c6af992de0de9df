/* Directions of contacts at a place against what gap, mass and kinematics tell of them: see
 * tangent_check.h, moment_arms.h and moment_arm_check.c. */
#ifndef NSDAE_SYSTEM_DIRECTIONS_H
#define NSDAE_SYSTEM_DIRECTIONS_H

#include "moment_arms.h"

typedef struct nsdae_directions {
  nsdae_differences *differences; /* whose system it is; set before */
  nsdae_moment_arms arms;
  double *M, *normal, *other, *tangent; /* as in the terms; nv x k, nv x k, nv x k nt */
  double *mass, *place, *q;             /* nv: diagonal of M, see below; nq: elsewhere, and here */
  double *turn;                         /* 3 nq */
  int *turns, *set;                     /* nv */
  const char *callback;                 /* the one that failed */
} nsdae_directions;

void nsdae_directions_layout(nsdae_directions *directions, nsdae_arena *arena);

/* Evaluates them at (t, q), W_N by differences where it is not given (and right, as far as anybody
 * looked), and W_N and M a little elsewhere. A callback's code. */
int nsdae_directions_at(nsdae_directions *directions, double t, const double *q);

/* The first column of W_T, of a contact with friction, that is wrong as far as translations of
 * bodies tell, and why; -1: none. */
int nsdae_directions_wrong(const nsdae_directions *directions, double tol,
                           char why[NSDAE_TANGENT_TEXT]);

/* The first doubt, of arms and of gaps that are no lengths, as text; "": none. A callback's code.
 */
int nsdae_directions_doubt(nsdae_directions *directions, double tol, char *text, size_t size);

#endif
