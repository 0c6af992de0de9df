/* nsdae: complementarity problems in HDF5 files. BSD-3-Clause.
 *
 * A file has two datasets of numbers: /A [n, n], with A(i, j) at [i, j] as NumPy writes a matrix,
 * and /b [n]. Optional attributes of the root give the origin: time [s], step, method, and tol, the
 * tolerance of the residual. */
#ifndef NSDAE_LCP_FILE_H
#define NSDAE_LCP_FILE_H

#include <nsdae/lcp.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Origin of a problem. */
typedef struct nsdae_lcp_origin {
  double time;        /* [s] */
  long step;          /* number of the failed step, from 1 */
  double tol;         /* tolerance of the residual, > 0 */
  const char *method; /* name of the method */
} nsdae_lcp_origin;

/* A problem read from a file. */
typedef struct nsdae_lcp_file {
  int n;      /* rows */
  double *A;  /* n x n, column-major, lda = max(1, n) */
  double *b;  /* [n]; A and b are from malloc, freed by nsdae_lcp_file_release */
  double tol; /* attribute tol; 0 if missing */
} nsdae_lcp_file;

/* Writes a problem and replaces an existing file. origin and error may be NULL. NSDAE_E_IO: the
 * text has the cause; NSDAE_E_ARGUMENT; NSDAE_E_MEMORY; NSDAE_E_UNSUPPORTED: built without HDF5. */
NSDAE_API int nsdae_lcp_write(const char *path, const nsdae_lcp_problem *problem,
                              const nsdae_lcp_origin *origin, nsdae_error *error);

/* Reads a problem with n <= 20000; on an error the struct is empty. Errors are those of
 * nsdae_lcp_write. NSDAE_E_IO also if a dataset is missing or has another shape. */
NSDAE_API int nsdae_lcp_read(const char *path, nsdae_lcp_file *file, nsdae_error *error);

/* Frees what was read; NULL is allowed. */
NSDAE_API void nsdae_lcp_file_release(nsdae_lcp_file *file);

#ifdef __cplusplus
}
#endif
#endif
