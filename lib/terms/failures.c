/* What is wrong with terms and with the equations that they make: checks, and their records. */
#include <float.h>
#include <math.h>

#include "terms.h"

int nsdae_terms_outcome(const nsdae_terms *T, int code, const char *callback, const double *a,
                        int rows, int columns)
{
  double t = nsdae_terms_time(T);
  int status = nsdae_system_callback_status(code, callback, t, T->error);
  if (status == NSDAE_OK)
    status = nsdae_system_finite(T->system, a, rows, columns, callback, t, T->error);
  if (status < 0) nsdae_system_explain(T->system, t, T->q, T->v, T->error);
  return status;
}

/* Entries (i, j) and (j, i) of block b. */
static int not_symmetric(const nsdae_terms *terms, int b, size_t i, size_t j)
{
  const nsdae_system *system = terms->system;
  size_t n = (size_t)nsdae_blocks_size(&system->blocks, b), at = system->blocks.square[b];
  int row = system->blocks.first[b] + (int)i, column = system->blocks.first[b] + (int)j;
  char a[NSDAE_CALLED_SIZE], c[NSDAE_CALLED_SIZE];
  nsdae_error_set(terms->error, NSDAE_E_MASS, "nsdae_terms", "mass",
                  "the mass matrix is not symmetric at t = %g: M(%d, %d) = %g, M(%d, %d) = %g: "
                  "fill both triangles (%s, %s)",
                  nsdae_terms_time(terms), row, column, terms->M[at + j * n + i], column, row,
                  terms->M[at + i * n + j],
                  nsdae_system_called(system, NSDAE_NAME_VELOCITY, row, a),
                  nsdae_system_called(system, NSDAE_NAME_VELOCITY, column, c));
  return nsdae_error_at(terms->error, NSDAE_E_MASS, (int)(at + j * n + i), nsdae_terms_time(terms));
}

int nsdae_terms_symmetric(const nsdae_terms *terms)
{
  const nsdae_blocks *blocks = &terms->system->blocks;
  const double roundings = 1e4 * DBL_EPSILON;
  for (int b = 0; b < blocks->count; b++) {
    const double *M = terms->M + blocks->square[b];
    size_t n = (size_t)nsdae_blocks_size(blocks, b);
    for (size_t j = 0; j < n; j++)
      for (size_t i = j + 1; i < n; i++) {
        double scale = sqrt(fabs(M[i * n + i])) * sqrt(fabs(M[j * n + j]));
        if (fabs(M[j * n + i] - M[i * n + j]) > roundings * scale)
          return not_symmetric(terms, b, i, j);
      }
  }
  return NSDAE_OK;
}

int nsdae_terms_finite(const nsdae_terms *T, const char *what, int kind, const double *a)
{
  int n = nsdae_system_count(T->system, kind);
  for (int i = 0; i < n; i++) {
    if (isfinite(a[i])) continue;
    nsdae_error_set(T->error, NSDAE_E_NONFINITE, "nsdae_terms", what,
                    "%s %d is %g at t = %g: overflow; a callback returns values near the "
                    "largest double, or mass and forces differ too much in scale",
                    what, i, a[i], nsdae_terms_time(T));
    T->error->time = nsdae_terms_time(T);
    nsdae_system_name_item(T->system, kind, i, T->error);
    return NSDAE_E_NONFINITE;
  }
  return NSDAE_OK;
}

int nsdae_terms_bad_mass(const nsdae_terms *T, nsdae_error *error, const char *of, int pivot, int n,
                         int velocity)
{
  const char *callback = nsdae_system_mass_name(T->system);
  nsdae_error_set(error, NSDAE_E_MASS, "nsdae_terms", callback,
                  "the mass matrix%s is not positive definite at t = %g: pivot %d of %d is not "
                  "above rounding; check the callback %s",
                  of, nsdae_terms_time(T), pivot, n, callback);
  error->time = nsdae_terms_time(T);
  nsdae_system_name_item(T->system, NSDAE_NAME_VELOCITY, velocity, error);
  return NSDAE_E_MASS;
}

int nsdae_terms_bad_equations(const nsdae_terms *T, nsdae_error *error, const char *in, int m,
                              int status)
{
  nsdae_error_set(error, status, "nsdae_terms", nsdae_system_jacobian_name(T->system),
                  "%sthe equations of %d constraints were not solved at t = %g: %s", in, m,
                  nsdae_terms_time(T), nsdae_status_message(status));
  return nsdae_error_at(error, status, -1, nsdae_terms_time(T));
}

int nsdae_terms_bad_rank(const nsdae_terms *T, nsdae_error *error, const char *in, int rank, int m,
                         int dependent)
{
  int zero = nsdae_rows_largest(&T->system->blocks, &T->by.jacobian, dependent) == 0;
  nsdae_error_set(error, NSDAE_E_RANK, "nsdae_terms", nsdae_system_jacobian_name(T->system),
                  "%sPhi_q has rank %d of %d at t = %g: %s", in, rank, m, nsdae_terms_time(T),
                  zero ? "a gradient is zero, as that of the square of a constraint, of which no "
                         "multiplier acts: give the constraint itself"
                       : "remove the redundant constraints or set redundant = least-norm; the "
                         "first redundant one");
  error->time = nsdae_terms_time(T);
  nsdae_system_name_item(T->system, NSDAE_NAME_CONSTRAINT, dependent, error);
  return NSDAE_E_RANK;
}

int nsdae_terms_unsolved(const nsdae_terms *T, const nsdae_kkt *kkt, int status)
{
  if (status == NSDAE_E_MASS)
    return nsdae_terms_bad_mass(T, T->error, "", kkt->pivot, kkt->n, kkt->pivot - 1);
  return nsdae_terms_bad_equations(T, T->error, "", kkt->m, status);
}

int nsdae_terms_factor(nsdae_terms *T, const double *M, nsdae_kkt *kkt, int least_norm)
{
  int status = nsdae_kkt_factor(kkt, M, &T->by.jacobian);
  if (status < 0) return nsdae_terms_unsolved(T, kkt, status);
  if (kkt->rank == kkt->m || least_norm) return NSDAE_OK;
  return nsdae_terms_bad_rank(T, T->error, "", kkt->rank, kkt->m, kkt->dependent);
}
