/* What the parts of nsdae_system_check share. */
#ifndef NSDAE_SYSTEM_DERIVATIVE_CHECK_H
#define NSDAE_SYSTEM_DERIVATIVE_CHECK_H

#include "moment_arms.h"
#include "differences.h"
#include "system_impl.h"

typedef struct nsdae_derivative_check {
  nsdae_system *system;
  nsdae_differences differences;
  double t, tol;
  const double *q, *v;
  double *given, *differenced, *spare; /* a matrix each, of nv at least, or M by blocks */
  double *trial;                       /* nv: a velocity */
  int *first;                          /* m + 1: of rows of Phi_q */
  nsdae_directions directions;         /* where there is friction */
  nsdae_check worst;
  int worst_rows; /* of its matrix */
} nsdae_derivative_check;

/* A callback's return as a status, with the system's error; of differences of a callback. */
int nsdae_check_callback(nsdae_derivative_check *check, int code, const char *callback);
int nsdae_check_difference(nsdae_derivative_check *check, int code, const char *callback);

/* Keeps the entry as the worst if its error is larger. */
void nsdae_check_keep(nsdae_derivative_check *check, const char *term, int row, int column,
                      double given, double difference);

/* The part that large systems have: M by blocks, rows of Phi_q, lists; and the callbacks for D and
 * K, dense or by blocks. NSDAE_OK, also with a wrong entry; NSDAE_E_CALLBACK, NSDAE_E_MEMORY and
 * what a list refuses, with the system's error. */
int nsdae_check_lists(nsdae_derivative_check *check);
int nsdae_check_forces(nsdae_derivative_check *check);

#endif
