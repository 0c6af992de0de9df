/* Complementarity problems to and from HDF5. */
#include <nsdae/lcp_file.h>
#include <stdlib.h>

#include "hdf5_data.h"

/* The most rows that nsdae_lcp_solve takes. */
enum { LARGEST = 20000 };

/* out(i, j) := in(j, i); n x n from leading dimension ld to n. */
static void transpose(int n, const double *in, int ld, double *out)
{
  for (size_t j = 0; out && j < (size_t)n; j++)
    for (size_t i = 0; i < (size_t)n; i++) out[i * (size_t)n + j] = in[j * (size_t)ld + i];
}

/* ---- writing */

/* Attributes, A by rows, b. */
static void write_problem(nsdae_h5 *h5, int n, const double *rows, const double *b,
                          const nsdae_lcp_origin *origin)
{
  const hsize_t size[2] = {(hsize_t)n, (hsize_t)n};
  nsdae_h5_set_text(h5, h5->file, "format", "nsdae-lcp");
  nsdae_h5_set_int(h5, h5->file, "format_version", 1);
  nsdae_h5_set_text(h5, h5->file, "library_version", nsdae_version());
  if (origin) nsdae_h5_set_origin(h5, origin->time, origin->step, origin->tol, origin->method);
  nsdae_h5_array(h5, "/A", H5T_NATIVE_DOUBLE, 2, size, rows, "1", "y = A x + b, A(i, j) at [i, j]");
  nsdae_h5_vector(h5, "/b", H5T_NATIVE_DOUBLE, size[0], b, "1",
                  "find x >= 0 with y >= 0 and x'y = 0");
  nsdae_h5_flush(h5);
}

static int check_write(const char *path, const nsdae_lcp_problem *p, nsdae_error *error)
{
  const char *bad = NULL;
  if (!path)
    bad = "path";
  else if (!p || p->n < 0 || p->n > LARGEST || p->lda < 1 || p->lda < p->n ||
           (p->n > 0 && (!p->A || !p->b)))
    bad = "problem";
  if (!bad) return NSDAE_OK;
  return nsdae_error_set(error, NSDAE_E_ARGUMENT, "nsdae_lcp_write", bad,
                         "%s is missing or outside its range", bad);
}

int nsdae_lcp_write(const char *path, const nsdae_lcp_problem *problem,
                    const nsdae_lcp_origin *origin, nsdae_error *error)
{
  nsdae_error_clear(error);
  int status = check_write(path, problem, error);
  if (status < 0) return status;
  nsdae_h5 h5 = {.file = -1, .path = path, .where = "nsdae_lcp_write", .error = error};
  int n = problem->n;
  double *rows = nsdae_h5_allocate(&h5, (size_t)n * (size_t)n, sizeof *rows);
  transpose(n, problem->A, problem->lda, rows);
  H5E_BEGIN_TRY
    if (rows && nsdae_h5_create(&h5, NSDAE_H5_PLAIN) == NSDAE_OK)
      write_problem(&h5, n, rows, problem->b, origin);
    nsdae_h5_close(&h5);
  H5E_END_TRY
  free(rows);
  return h5.status;
}

/* ---- reading */

/* A and b, which must fit. */
static void read_problem(nsdae_h5 *h5, nsdae_lcp_file *file)
{
  hsize_t a[2] = {0}, b[1] = {0};
  nsdae_h5_shape(h5, "/A", 2, a);
  nsdae_h5_shape(h5, "/b", 1, b);
  if (a[0] != a[1] || a[0] != b[0] || a[0] > LARGEST)
    nsdae_h5_refuse(
        h5, "read", "/A is %llu x %llu and /b has %llu entries, must be n x n and n with n <= %d",
        (unsigned long long)a[0], (unsigned long long)a[1], (unsigned long long)b[0], LARGEST);
  if (h5->status < 0) return;
  size_t n = (size_t)a[0];
  double *rows = nsdae_h5_allocate(h5, n * n, sizeof *rows);
  file->n = (int)n;
  file->A = nsdae_h5_allocate(h5, n * n, sizeof *file->A);
  file->b = nsdae_h5_allocate(h5, n, sizeof *file->b);
  nsdae_h5_read(h5, "/A", H5T_NATIVE_DOUBLE, rows);
  nsdae_h5_read(h5, "/b", H5T_NATIVE_DOUBLE, file->b);
  if (h5->status == NSDAE_OK) transpose(file->n, rows, file->n, file->A);
  free(rows);
  file->tol = nsdae_h5_get_real(h5, h5->file, "tol");
}

int nsdae_lcp_read(const char *path, nsdae_lcp_file *file, nsdae_error *error)
{
  nsdae_error_clear(error);
  if (!path || !file)
    return nsdae_error_set(error, NSDAE_E_ARGUMENT, "nsdae_lcp_read", path ? "file" : "path",
                           "%s is NULL", path ? "file" : "path");
  *file = (nsdae_lcp_file){0};
  nsdae_h5 h5 = {.file = -1, .path = path, .where = "nsdae_lcp_read", .error = error};
  H5E_BEGIN_TRY
    if (nsdae_h5_open(&h5) == NSDAE_OK) read_problem(&h5, file);
    if (nsdae_h5_close(&h5) < 0) nsdae_lcp_file_release(file);
  H5E_END_TRY
  return h5.status;
}
