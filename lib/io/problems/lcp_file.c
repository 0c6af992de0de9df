/* Complementarity problems to and from HDF5. */
#include <nsdae/lcp_file.h>
#include <stdlib.h>
#include <string.h>

#include "errors.h"
#include "hdf5_data.h"
#include "hdf5_read.h"

/* The most rows that nsdae_lcp_solve takes. */
enum { LARGEST = 20000 };

/* out(i, j) := in(j, i); n x n from leading dimension ld to n. */
static void transpose(int n, const double *in, int ld, double *out)
{
  for (size_t j = 0; j < (size_t)n; j++)
    for (size_t i = 0; i < (size_t)n; i++) out[i * (size_t)n + j] = in[j * (size_t)ld + i];
}

static double *allocate(size_t count, nsdae_error *error, const char *where)
{
  double *block = malloc((count + 1) * sizeof *block);
  if (!block)
    nsdae_error_set(error, NSDAE_E_MEMORY, where, "", "out of memory for %zu numbers", count);
  return block;
}

/* ---- writing */

static int write_origin(nsdae_h5 *h5, const nsdae_lcp_origin *origin)
{
  if (!origin) return NSDAE_OK;
  int status = nsdae_h5_set_real(h5, h5->file, "time", origin->time);
  if (status == NSDAE_OK) status = nsdae_h5_set_int(h5, h5->file, "step", (int)origin->step);
  if (status == NSDAE_OK) status = nsdae_h5_set_real(h5, h5->file, "tol", origin->tol);
  if (status == NSDAE_OK && origin->method)
    status = nsdae_h5_set_text(h5, h5->file, "method", origin->method);
  return status;
}

/* Attributes, A by rows, b; the file is flushed and closed whatever happened. */
static int write_problem(nsdae_h5 *h5, int n, const double *rows, const double *b,
                         const nsdae_lcp_origin *origin)
{
  int status = nsdae_h5_create(h5, NSDAE_H5_PLAIN);
  if (status < 0) return status;
  status = nsdae_h5_set_text(h5, h5->file, "format", "nsdae-lcp");
  if (status == NSDAE_OK) status = nsdae_h5_set_int(h5, h5->file, "format_version", 1);
  if (status == NSDAE_OK)
    status = nsdae_h5_set_text(h5, h5->file, "library_version", nsdae_version());
  if (status == NSDAE_OK) status = write_origin(h5, origin);
  if (status == NSDAE_OK)
    status = nsdae_h5_matrix(h5, "/A", (hsize_t)n, (hsize_t)n, rows, "1",
                             "y = A x + b, A(i, j) at [i, j]");
  if (status == NSDAE_OK)
    status = nsdae_h5_vector(h5, "/b", H5T_NATIVE_DOUBLE, (hsize_t)n, b, "1",
                             "find x >= 0 with y >= 0 and x'y = 0");
  if (status == NSDAE_OK) status = nsdae_h5_flush(h5);
  int closed = nsdae_h5_close(h5);
  return status < 0 ? status : closed;
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
  double *rows = allocate((size_t)n * (size_t)n, error, h5.where);
  if (!rows) return NSDAE_E_MEMORY;
  transpose(n, problem->A, problem->lda, rows);
  NSDAE_H5_QUIETLY(status, write_problem(&h5, n, rows, problem->b, origin));
  free(rows);
  return status;
}

/* ---- reading */

/* n of /A and /b, which must fit. */
static int read_size(nsdae_h5 *h5, int *n)
{
  hsize_t a[2] = {0}, b[2] = {0};
  int status = nsdae_h5_shape(h5, "/A", 2, a);
  if (status == NSDAE_OK) status = nsdae_h5_shape(h5, "/b", 1, b);
  if (status < 0) return status;
  if (a[0] != a[1] || a[0] != b[0] || a[0] > LARGEST)
    return nsdae_error_set(h5->error, NSDAE_E_IO, h5->where, "path",
                           "cannot read '%.90s': /A is %llu x %llu and /b has %llu entries, must "
                           "be n x n and n with n <= %d",
                           h5->path, (unsigned long long)a[0], (unsigned long long)a[1],
                           (unsigned long long)b[0], LARGEST);
  *n = (int)a[0];
  return NSDAE_OK;
}

static int read_problem(nsdae_h5 *h5, nsdae_lcp_file *file)
{
  int status = read_size(h5, &file->n);
  if (status < 0) return status;
  size_t n = (size_t)file->n;
  double *rows = allocate(n * n, h5->error, h5->where);
  file->A = allocate(n * n, h5->error, h5->where);
  file->b = allocate(n, h5->error, h5->where);
  if (!rows || !file->A || !file->b) {
    free(rows);
    return NSDAE_E_MEMORY;
  }
  status = nsdae_h5_read(h5, "/A", rows);
  if (status == NSDAE_OK) status = nsdae_h5_read(h5, "/b", file->b);
  if (status == NSDAE_OK) transpose(file->n, rows, file->n, file->A);
  free(rows);
  return status < 0 ? status : nsdae_h5_get_real(h5, h5->file, "tol", &file->tol);
}

static int read_file(nsdae_h5 *h5, nsdae_lcp_file *file)
{
  int status = nsdae_h5_open(h5);
  if (status < 0) return status;
  status = read_problem(h5, file);
  int closed = nsdae_h5_close(h5);
  return status < 0 ? status : closed;
}

int nsdae_lcp_read(const char *path, nsdae_lcp_file *file, nsdae_error *error)
{
  int status;
  nsdae_error_clear(error);
  if (!path || !file)
    return nsdae_error_set(error, NSDAE_E_ARGUMENT, "nsdae_lcp_read", path ? "file" : "path",
                           "%s is NULL", path ? "file" : "path");
  *file = (nsdae_lcp_file){0};
  nsdae_h5 h5 = {.file = -1, .path = path, .where = "nsdae_lcp_read", .error = error};
  NSDAE_H5_QUIETLY(status, read_file(&h5, file));
  if (status < 0) nsdae_lcp_file_release(file);
  return status;
}

void nsdae_lcp_file_release(nsdae_lcp_file *file)
{
  if (!file) return;
  free(file->A);
  free(file->b);
  *file = (nsdae_lcp_file){0};
}
