#include "lcp_arguments.h"

#include <errno.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "safe_read.h"

enum { LARGEST = 20000 };

/* A file being read: the first error is kept. */
typedef struct reader {
  const char *path;
  FILE *stream;
  nsdae_error *error;
  int status;
} reader;

/* A square matrix of the file. */
typedef struct matrix {
  int n;
  double *value;
} matrix;

static void fail(reader *r, int status, const char *format, ...)
{
  va_list args;
  if (r->status != NSDAE_OK) return;
  r->status = status;
  if (!r->error) return;
  *r->error = (nsdae_error){.status = status, .index = -1, .time = NAN, .argument = "file"};
  snprintf(r->error->where, sizeof r->error->where, "lcp_file_read");
  size_t size = sizeof r->error->text;
  int used = snprintf(r->error->text, size, "%.150s: ", r->path);
  va_start(args, format);
  vsnprintf(r->error->text + used, size - (size_t)used, format, args);
  va_end(args);
}

static double read_real(reader *r, const char *what)
{
  char token[400], *end = token; /* the largest double by %f: 317 */
  if (r->status != NSDAE_OK) return 0;
  if (fscanf(r->stream, "%399s", token) == 1) {
    double value = strtod(token, &end);
    if (end != token && !*end && end < token + sizeof token - 1) return value;
    fail(r, NSDAE_E_IO, "'%.40s' where %s must be", token, what);
  } else {
    fail(r, NSDAE_E_IO, "ends where %s must be", what);
  }
  return 0;
}

static int read_int(reader *r, const char *what, int least, int most)
{
  double value = read_real(r, what);
  if (r->status == NSDAE_OK && !(value >= least && value <= most && value == floor(value)))
    fail(r, NSDAE_E_IO, "%s is %g, must be an integer in [%d, %d]", what, value, least, most);
  return r->status == NSDAE_OK ? (int)value : least;
}

/* count zeroed entries; NULL with an error if there is no memory. */
static void *take(reader *r, size_t count, size_t size)
{
  if (r->status != NSDAE_OK) return NULL;
  void *block = calloc(count > 0 ? count : 1, size);
  if (!block) fail(r, NSDAE_E_MEMORY, "no memory for %zu entries", count);
  return block;
}

static void read_dense(reader *r, matrix *m)
{
  size_t size = (size_t)m->n * (size_t)m->n;
  read_int(r, "number of rows", m->n, m->n);
  read_int(r, "number of columns", m->n, m->n);
  for (size_t i = 0; i < size && r->status == NSDAE_OK; i++)
    m->value[i] = read_real(r, "a matrix entry");
}

/* Ends of the blocks, rising from above 0 to n. */
static int *read_ends(reader *r, int count, int n)
{
  int *ends = take(r, (size_t)count + 1, sizeof *ends);
  for (int i = 0; i < count && r->status == NSDAE_OK; i++)
    ends[i + 1] = read_int(r, "the end of a block row or column", ends[i] + 1, n);
  if (r->status == NSDAE_OK && ends[count] != n)
    fail(r, NSDAE_E_IO, "the blocks end at %d of %d rows", ends[count], n);
  return ends;
}

static int *read_index(reader *r, int count, const char *what, int most)
{
  int *index = take(r, (size_t)count, sizeof *index);
  for (int i = 0; i < count && r->status == NSDAE_OK; i++) index[i] = read_int(r, what, 0, most);
  return index;
}

static void read_block(reader *r, matrix *m, const int *row, const int *column)
{
  for (int j = column[0]; j < column[1]; j++)
    for (int i = row[0]; i < row[1] && r->status == NSDAE_OK; i++)
      m->value[(size_t)j * (size_t)m->n + (size_t)i] = read_real(r, "a block entry");
}

static void read_blocks(reader *r, matrix *m)
{
  int n = m->n, most = n * (n < 46340 ? n : 46340);
  int count = read_int(r, "number of blocks", 0, most);
  int rows = read_int(r, "number of block rows", 0, n);
  int columns = read_int(r, "number of block columns", 0, n);
  int *row_end = read_ends(r, rows, n), *column_end = read_ends(r, columns, n);
  int pointers = read_int(r, "number of row pointers", rows + 1, rows + 1);
  read_int(r, "number of block columns stored", count, count);
  int *start = read_index(r, pointers, "a row pointer", count);
  for (int i = 0; i < rows && r->status == NSDAE_OK; i++)
    if (start[i] > start[i + 1] || start[0] != 0 || start[rows] != count)
      fail(r, NSDAE_E_IO, "the row pointers do not rise from 0 to the number of blocks");
  int *column = read_index(r, count, "a block column", columns - 1);
  for (int i = 0; i < rows && r->status == NSDAE_OK; i++)
    for (int k = start[i]; k < start[i + 1] && r->status == NSDAE_OK; k++) {
      read_int(r, "number of a block", k, k);
      read_block(r, m, row_end + i, column_end + column[k]);
    }
  free(row_end);
  free(column_end);
  free(start);
  free(column);
}

static void expect(reader *r, const char *word)
{
  char token[64];
  if (r->status != NSDAE_OK) return;
  if (fscanf(r->stream, "%63s", token) != 1)
    fail(r, NSDAE_E_IO, "ends where '%s' must be", word);
  else if (strcmp(token, word) != 0)
    fail(r, NSDAE_E_IO, "'%.40s' where '%s' must be", token, word);
}

/* "row : value" */
static void read_entry(reader *r, matrix *m, int j)
{
  int i = read_int(r, "a row", 0, m->n - 1);
  expect(r, ":");
  double value = read_real(r, "a matrix entry");
  if (r->status == NSDAE_OK) m->value[(size_t)j * (size_t)m->n + (size_t)i] += value;
}

/* Output of cs_print of CSparse: two lines of heading, then "col j : locations p to q" and that
 * many lines "row : value". */
static void read_sparse(reader *r, matrix *m)
{
  read_int(r, "origin of the sparse matrix", 0, 2);
  expect(r, "CSparse");
  if (r->status == NSDAE_OK && (fscanf(r->stream, "%*[^\n]") < 0 || fgetc(r->stream) < 0 ||
                                fscanf(r->stream, "%*[^\n]") < 0))
    fail(r, NSDAE_E_IO, "ends in the heading of a sparse matrix");
  for (int j = 0; j < m->n && r->status == NSDAE_OK; j++) {
    expect(r, "col");
    read_int(r, "number of a column", j, j);
    expect(r, ":");
    expect(r, "locations");
    int from = read_int(r, "start of a column", 0, 1 << 30);
    expect(r, "to");
    int to = read_int(r, "end of a column", from - 1, 1 << 30);
    for (int k = from; k <= to && r->status == NSDAE_OK; k++) read_entry(r, m, j);
  }
}

static void read_matrix(reader *r, int storage, matrix *m)
{
  m->value = take(r, (size_t)m->n * (size_t)m->n, sizeof *m->value);
  if (r->status != NSDAE_OK) return;
  if (storage == 0) read_dense(r, m);
  if (storage == 1) read_blocks(r, m);
  if (storage == 2) read_sparse(r, m);
}

static double *read_vector(reader *r, int n, const char *what)
{
  double *value = take(r, (size_t)n, sizeof *value);
  for (int i = 0; i < n && r->status == NSDAE_OK; i++) value[i] = read_real(r, what);
  return value;
}

/* One contact's rows i and another's columns j of
 *   A = E_P^T W E_Q + N,  Lambda_T = Lambda_R - mu Lambda_N,  xi_R = xi_T + xi_L,
 *   Lambda_L = 2 mu Lambda_N - Lambda_R. */
static void couple(lcp_file *f, const matrix *w, int i, int j, double mu)
{
  size_t rows = (size_t)w->n, n = (size_t)f->n;
  const double *W = w->value + (2 * (size_t)j) * rows + 2 * (size_t)i;
  double *A = f->A + (3 * (size_t)j) * n + 3 * (size_t)i;
  for (size_t k = 0; k < 2; k++) {
    A[k] = W[k] - mu * W[rows + k];
    A[n + k] = W[rows + k];
  }
  if (i != j) return;
  A[2 * n + 1] = 1;
  A[2] = 2 * mu;
  A[n + 2] = -1;
}

/* Planar contacts as a complementarity problem. */
static void read_contacts(reader *r, int contacts, int storage, lcp_file *f)
{
  matrix w = {.n = 2 * contacts};
  read_matrix(r, storage, &w);
  double *q = read_vector(r, 2 * contacts, "an entry of q");
  double *mu = read_vector(r, contacts, "a friction coefficient");
  for (int j = 0; j < contacts && r->status == NSDAE_OK; j++)
    if (mu[j] < 0) fail(r, NSDAE_E_IO, "friction coefficient %d is %g, must be >= 0", j + 1, mu[j]);
  f->n = 3 * contacts;
  f->contacts = contacts;
  f->A = take(r, (size_t)f->n * (size_t)f->n, sizeof *f->A);
  f->b = take(r, (size_t)f->n, sizeof *f->b);
  for (int j = 0; j < contacts && r->status == NSDAE_OK; j++) {
    for (int i = 0; i < contacts; i++) couple(f, &w, i, j, mu[j]);
    for (int k = 0; k < 2; k++) f->b[3 * j + k] = q[2 * j + k];
  }
  free(w.value);
  free(q);
  free(mu);
}

static void read_problem(reader *r, int n, int storage, lcp_file *f)
{
  matrix m = {.n = n};
  read_matrix(r, storage, &m);
  f->n = n;
  f->A = m.value;
  f->b = read_vector(r, n, "an entry of q");
}

/* A complementarity problem starts n, storage, n, n; contacts 2, k, storage, 2 k, 2 k. */
static void read_file(reader *r, lcp_file *f)
{
  int head[4];
  for (int i = 0; i < 4; i++) head[i] = read_int(r, "a size", 0, LARGEST);
  if (r->status != NSDAE_OK) return;
  if (head[2] == head[0] && head[3] == head[0] && head[1] <= 2)
    read_problem(r, head[0], head[1], f);
  else if (head[0] == 3 && head[2] <= 2 && head[3] == 3 * head[1])
    fail(r, NSDAE_E_UNSUPPORTED, "spatial contacts; their friction cones are no LCP");
  else if (head[0] == 2 && head[2] <= 2 && head[3] == 2 * head[1]) {
    read_int(r, "number of columns", head[3], head[3]);
    read_contacts(r, head[1], head[2], f);
  } else
    fail(r, NSDAE_E_IO,
         "starts %d %d %d %d, which is neither n, storage, n, n nor 2, contacts, "
         "storage, 2 contacts",
         head[0], head[1], head[2], head[3]);
}

int lcp_file_read(const char *path, lcp_file *file, nsdae_error *error)
{
  reader r = {.path = path, .error = error};
  *file = (lcp_file){0};
  const char *why;
  r.stream = open_regular(path, &why);
  if (!r.stream) {
    fail(&r, NSDAE_E_IO, "%s", why);
    return r.status;
  }
  read_file(&r, file);
  fclose(r.stream);
  if (r.status != NSDAE_OK) lcp_file_release(file);
  return r.status;
}

void lcp_file_release(lcp_file *file)
{
  free(file->A);
  free(file->b);
  *file = (lcp_file){0};
}
