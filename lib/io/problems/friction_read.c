/* Frictional contact problems from files of FCLIB. A file may be anybody's: what it says of sizes
 * is compared before memory is asked for. */
#include <limits.h>
#include <nsdae/friction_file.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "to_blocks.h"

/* A problem on its way: contacts of dim rows in the file, the rest of each row's length. */
typedef struct reader {
  nsdae_h5 *h5;
  nsdae_friction_file *out;
  const char *root;  /* "/fclib_local" or "/fclib_global" */
  int dim, contacts; /* rows of a contact in the file */
  int bilateral;
  int *rows;        /* contacts: of each, or NULL */
  nsdae_triplets A; /* W, or H, with the bilateral rows behind */
  nsdae_triplets M;
  nsdae_partition items;  /* of the rows of the file */
  nsdae_partition blocks; /* global: of v */
  nsdae_blocked_problem gathered;
} reader;

static const char *path_of(const reader *r, char path[64], const char *name)
{
  snprintf(path, 64, "%s/%s", r->root, name);
  return path;
}

static int take_reals(const reader *r, const char *name, int length, const double **values)
{
  char path[64];
  double *block = NULL;
  int status = nsdae_h5_take_reals(r->h5, path_of(r, path, name), 1, length, &block);
  *values = block;
  return status;
}

/* ---- form and contacts */

/* Which form the file has; rolling friction is refused. */
static int read_form(reader *r)
{
  nsdae_h5 *h5 = r->h5;
  if (nsdae_h5_has(h5, "/fclib_global_rolling") || nsdae_h5_has(h5, "/fclib_local_rolling"))
    return nsdae_h5_refuse(h5,
                           "a problem of rolling friction (dimension 5); contacts must have 2 or "
                           "3 rows");
  int local = nsdae_h5_has(h5, "/fclib_local"), global = nsdae_h5_has(h5, "/fclib_global");
  if (local == global)
    return nsdae_h5_refuse(h5, "%s",
                           local ? "it has both /fclib_local and /fclib_global"
                                 : "it has neither /fclib_local nor /fclib_global");
  r->root = local ? "/fclib_local" : "/fclib_global";
  r->out->problem.form = local ? NSDAE_FRICTION_LOCAL : NSDAE_FRICTION_GLOBAL;
  return NSDAE_OK;
}

static int read_dimension(reader *r)
{
  char path[64];
  int *dim = NULL;
  int status = nsdae_h5_take_ints(r->h5, path_of(r, path, "spacedim"), 1, 1, &dim);
  if (status == NSDAE_OK && dim[0] != 2 && dim[0] != 3)
    status = nsdae_h5_refuse(r->h5, "%s is %d, must be 2 or 3", path, dim[0]);
  if (status == NSDAE_OK) r->dim = dim[0];
  free(dim);
  if (status < 0) return status;
  status = nsdae_h5_length(r->h5, path_of(r, path, "vectors/mu"), INT_MAX / 8, &r->contacts);
  if (status == NSDAE_OK && r->contacts < 0) status = nsdae_h5_refuse(r->h5, "%s is missing", path);
  return status;
}

static int check_mu(const reader *r)
{
  for (int c = 0; c < r->contacts; c++)
    if (r->out->problem.mu[c] < 0)
      return nsdae_h5_refuse(r->h5, "%s/vectors/mu[%d] is %g, must not be negative", r->root, c,
                             r->out->problem.mu[c]);
  return NSDAE_OK;
}

/* mu, and the rows of each contact where they differ. */
static int read_contacts(reader *r)
{
  char path[64];
  int status = take_reals(r, "vectors/mu", r->contacts, &r->out->problem.mu);
  if (status == NSDAE_OK) status = check_mu(r);
  if (status < 0) return status;
  status = nsdae_h5_take_ints(r->h5, path_of(r, path, "vectors/rows"), 0, r->contacts, &r->rows);
  for (int c = 0; r->rows && c < r->contacts && status == NSDAE_OK; c++)
    if (r->rows[c] < 1 || r->rows[c] > r->dim)
      status =
          nsdae_h5_refuse(r->h5, "%s[%d] is %d, must be in [1, %d]", path, c, r->rows[c], r->dim);
  return status;
}

static int rows_of(const reader *r, int item)
{
  if (item >= r->contacts) return 1;
  return r->rows ? r->rows[item] : r->dim;
}

/* The items of the rows of the file; a contact's rows beyond its own belong to none. */
static int make_items(reader *r)
{
  size_t count = (size_t)r->contacts + (size_t)r->bilateral;
  int *size = malloc((count + 1) * sizeof *size), places = r->dim * r->contacts + r->bilateral;
  if (!size) return nsdae_h5_no_memory(r->h5);
  for (int i = 0; i < (int)count; i++) size[i] = i < r->contacts ? r->dim : 1;
  int status = nsdae_partition_make(r->h5, places, (int)count, size, &r->items);
  free(size);
  if (status < 0 || !r->rows) return status;
  for (int k = 0; k < places; k++) {
    int item = r->items.of[k];
    if (r->items.at[k] >= rows_of(r, item)) r->items.of[k] = -1;
  }
  for (int i = 0; i < (int)count; i++) r->items.size[i] = rows_of(r, i);
  return NSDAE_OK;
}

static int check_shape(const reader *r, const char *name, const nsdae_triplets *A, int rows,
                       int columns)
{
  if (A->rows == rows && A->columns == columns) return NSDAE_OK;
  return nsdae_h5_refuse(r->h5, "%s/%s is %d x %d, must be %d x %d", r->root, name, A->rows,
                         A->columns, rows, columns);
}

/* ---- matrices */

/* Reads a matrix; of one that need not be there and is not, an empty one. */
static int read_matrix(const reader *r, const char *name, int needed, nsdae_triplets *A)
{
  char path[64];
  *A = (nsdae_triplets){0};
  if (!needed && !nsdae_h5_has(r->h5, path_of(r, path, name))) return NSDAE_OK;
  return nsdae_triplets_read(r->h5, path_of(r, path, name), A);
}

/* Adds B at (row, column) of A, and its transpose at (column, row). */
static int join(const reader *r, nsdae_triplets *A, const nsdae_triplets *B, int row, int column,
                int transposed)
{
  if (B->count > INT_MAX / 2) return nsdae_h5_refuse(r->h5, "more than %d entries", INT_MAX / 2);
  int status = nsdae_triplets_grow(r->h5, A, transposed ? 2 * B->count : B->count);
  for (int k = 0; k < B->count && status == NSDAE_OK; k++) {
    nsdae_triplets_add(A, row + B->row[k], column + B->column[k], B->value[k]);
    if (transposed) nsdae_triplets_add(A, column + B->column[k], row + B->row[k], B->value[k]);
  }
  return status;
}

/* The vector over the bilateral rows is in the file, and as long as the matrices claim: memory is
 * asked for by their number. */
static int check_bilateral(const reader *r, const char *name)
{
  char path[64];
  int length = 0;
  if (r->bilateral == 0) return NSDAE_OK;
  int status = nsdae_h5_length(r->h5, path_of(r, path, name), INT_MAX, &length);
  if (status == NSDAE_OK && length != r->bilateral)
    status = nsdae_h5_refuse(r->h5, "%s has %d numbers, must have %d", path,
                             length < 0 ? 0 : length, r->bilateral);
  return status;
}

/* ---- local form */

/* W, and where there are bilateral rows [W V; V^T R]. */
static int read_local(reader *r)
{
  nsdae_triplets V = {0}, R = {0};
  int m = r->dim * r->contacts, status = read_matrix(r, "W", 1, &r->A);
  if (status == NSDAE_OK) status = check_shape(r, "W", &r->A, m, m);
  if (status == NSDAE_OK) status = read_matrix(r, "V", 0, &V);
  if (status == NSDAE_OK) status = read_matrix(r, "R", 0, &R);
  r->bilateral = V.columns > R.columns ? V.columns : R.columns;
  if (status == NSDAE_OK && V.rows + V.columns > 0)
    status = check_shape(r, "V", &V, m, r->bilateral);
  if (status == NSDAE_OK && R.rows + R.columns > 0)
    status = check_shape(r, "R", &R, r->bilateral, r->bilateral);
  if (status == NSDAE_OK) status = check_bilateral(r, "vectors/s");
  if (status == NSDAE_OK) status = join(r, &r->A, &V, 0, m, 1);
  if (status == NSDAE_OK) status = join(r, &r->A, &R, m, m, 0);
  r->A.rows = r->A.columns = m + r->bilateral;
  nsdae_triplets_release(&V);
  nsdae_triplets_release(&R);
  if (status == NSDAE_OK) status = nsdae_symmetrise(r->h5, &r->A, &r->out->asymmetry);
  if (status == NSDAE_OK) status = make_items(r);
  return status < 0 ? status : nsdae_to_blocks(r->h5, &r->A, &r->items, &r->items, &r->gathered);
}

/* ---- global form */

/* The blocks of v: those that are written down, or found. */
static int read_blocks(reader *r)
{
  char path[64];
  int *size = NULL, parts, n = r->M.rows;
  int status = nsdae_h5_length(r->h5, path_of(r, path, "blocks"), n, &parts);
  if (status < 0) return status;
  if (parts < 0) return nsdae_partition_find(r->h5, &r->M, r->dim == 3 ? 6 : 3, &r->blocks);
  status = nsdae_h5_take_ints(r->h5, path, 1, parts, &size);
  if (status == NSDAE_OK) status = nsdae_partition_make(r->h5, n, parts, size, &r->blocks);
  free(size);
  return status;
}

/* H, and where there are bilateral rows [H G]. */
static int read_H(reader *r)
{
  nsdae_triplets G = {0};
  int m = r->dim * r->contacts, n = r->M.rows, status = read_matrix(r, "H", 1, &r->A);
  if (status == NSDAE_OK) status = check_shape(r, "H", &r->A, n, m);
  if (status == NSDAE_OK) status = read_matrix(r, "G", 0, &G);
  r->bilateral = G.columns;
  if (status == NSDAE_OK && G.rows + G.columns > 0)
    status = check_shape(r, "G", &G, n, r->bilateral);
  if (status == NSDAE_OK) status = check_bilateral(r, "vectors/b");
  if (status == NSDAE_OK) status = join(r, &r->A, &G, 0, m, 0);
  r->A.columns = m + r->bilateral;
  nsdae_triplets_release(&G);
  return status;
}

/* f of the file, and where its entries come from, in the order of the blocks. */
static int order_velocities(reader *r, const double *f)
{
  int n = r->blocks.n, parts = r->blocks.parts;
  size_t room = (size_t)n + 1;
  double *ordered = malloc(room * sizeof *ordered);
  int *home = calloc((size_t)parts + 1, sizeof *home);
  r->out->velocity = malloc(room * sizeof *r->out->velocity);
  r->out->problem.f = ordered;
  int missing = !ordered || !home || !r->out->velocity;
  for (int b = 1; !missing && b < parts; b++) home[b] = home[b - 1] + r->blocks.size[b - 1];
  for (int i = 0; !missing && i < n; i++) {
    int place = home[r->blocks.of[i]] + r->blocks.at[i];
    ordered[place] = f[i];
    r->out->velocity[place] = i;
  }
  free(home);
  if (!missing) return NSDAE_OK;
  return nsdae_h5_no_memory(r->h5);
}

static int read_global(reader *r)
{
  const double *f = NULL;
  double *M = NULL;
  int status = read_matrix(r, "M", 1, &r->M);
  if (status == NSDAE_OK) status = check_shape(r, "M", &r->M, r->M.rows, r->M.rows);
  if (status == NSDAE_OK) status = take_reals(r, "vectors/f", r->M.rows, &f);
  if (status == NSDAE_OK) status = read_H(r);
  if (status == NSDAE_OK) status = nsdae_symmetrise(r->h5, &r->M, &r->out->asymmetry);
  if (status == NSDAE_OK) status = read_blocks(r);
  if (status == NSDAE_OK) status = make_items(r);
  if (status == NSDAE_OK) status = nsdae_to_blocks_diagonal(r->h5, &r->M, &r->blocks, &M);
  r->out->problem.M = M;
  if (status == NSDAE_OK) status = order_velocities(r, f);
  free((void *)f);
  return status < 0 ? status : nsdae_to_blocks(r->h5, &r->A, &r->blocks, &r->items, &r->gathered);
}

/* ---- vectors */

/* A vector over the contacts, with that over the bilateral rows behind it, compressed; NULL where
 * it is not there and need not be. */
static int read_rows(const reader *r, const char *name, const char *behind, int needed,
                     double **values)
{
  double *head = NULL, *tail = NULL;
  int m = r->dim * r->contacts, p = r->bilateral;
  int status = nsdae_h5_take_reals(r->h5, name, needed, m, &head);
  if (status == NSDAE_OK && head && p > 0)
    status = nsdae_h5_take_reals(r->h5, behind, needed, p, &tail);
  double *both = head ? realloc(head, ((size_t)m + (size_t)p + 1) * sizeof *both) : NULL;
  if (head && !both) {
    free(head);
    status = nsdae_h5_no_memory(r->h5);
  }
  for (int i = 0; both && i < p; i++) both[m + i] = tail ? tail[i] : 0;
  if (both && r->items.n == m + p) {
    /* Of the rows of the file those that items have, in place; the bilateral ones come behind. */
    int k = 0;
    for (int i = 0; i < r->items.n; i++)
      if (r->items.of[i] >= 0) both[k++] = both[i];
  }
  free(tail);
  *values = both;
  return status;
}

/* w or q, the compliance, the first guess and the solution. */
static int read_vectors(reader *r)
{
  char first[64], second[64];
  int local = r->out->problem.form == NSDAE_FRICTION_LOCAL;
  double *w = NULL, *compliance = NULL;
  int status = read_rows(r, path_of(r, first, local ? "vectors/q" : "vectors/w"),
                         path_of(r, second, local ? "vectors/s" : "vectors/b"), 1, &w);
  r->out->problem.w = w;
  if (status == NSDAE_OK)
    status = read_rows(r, path_of(r, first, "vectors/compliance"),
                       path_of(r, second, "vectors/compliance_l"), 0, &compliance);
  r->out->problem.compliance = compliance;
  if (status == NSDAE_OK) status = read_rows(r, "/guesses/1/r", "/guesses/1/l", 0, &r->out->guess);
  if (status == NSDAE_OK) status = read_rows(r, "/solution/r", "/solution/l", 0, &r->out->r);
  if (status < 0 || !r->out->r) return status;
  return read_rows(r, "/solution/r_low", "/solution/l_low", 0, &r->out->low);
}

/* Hands the arrays over to the file. */
static void hand_over_arrays(reader *r)
{
  nsdae_friction_problem *p = &r->out->problem;
  p->contacts = r->contacts;
  p->bilateral = r->bilateral;
  p->rows = r->rows;
  if (!r->rows && r->dim == 2) { /* all 3 where there are none */
    memcpy(r->items.at, r->items.size, (size_t)r->contacts * sizeof *r->items.at);
    p->rows = r->items.at;
    r->items.at = NULL;
  }
  p->blocks = r->blocks.parts;
  p->size = r->blocks.size;
  p->first = r->gathered.first;
  p->block = r->gathered.block;
  p->value = r->gathered.value;
  r->rows = NULL;
  r->blocks.size = NULL;
  r->gathered = (nsdae_blocked_problem){0};
}

/* ---- the file */

/* Form, contacts, matrices, vectors, tolerances; all of it is released if one of them fails. */
static int read_problem(nsdae_h5 *h5, nsdae_friction_file *out)
{
  reader r = {.h5 = h5, .out = out};
  int status = read_form(&r);
  if (status == NSDAE_OK) status = read_dimension(&r);
  if (status == NSDAE_OK) status = read_contacts(&r);
  if (status == NSDAE_OK)
    status = out->problem.form == NSDAE_FRICTION_LOCAL ? read_local(&r) : read_global(&r);
  if (status == NSDAE_OK) status = read_vectors(&r);
  double refine = 0;
  if (status == NSDAE_OK) status = nsdae_h5_get_real(h5, h5->file, "tol", &out->tol);
  if (status == NSDAE_OK) status = nsdae_h5_get_real(h5, h5->file, "refine", &refine);
  out->refine = refine >= 0 && refine <= 1000 ? (int)refine : 0;
  if (status == NSDAE_OK) hand_over_arrays(&r);
  free(r.rows);
  nsdae_triplets_release(&r.A);
  nsdae_triplets_release(&r.M);
  nsdae_partition_release(&r.items);
  nsdae_partition_release(&r.blocks);
  nsdae_blocked_problem_release(&r.gathered);
  return status;
}

static int read_file(nsdae_h5 *h5, nsdae_friction_file *file)
{
  int status = nsdae_h5_open(h5);
  if (status < 0) return status;
  status = read_problem(h5, file);
  int closed = nsdae_h5_close(h5);
  return status < 0 ? status : closed;
}

int nsdae_friction_read(const char *path, nsdae_friction_file *file, nsdae_error *error)
{
  int status;
  nsdae_error_clear(error);
  if (!path || !file)
    return nsdae_error_set(error, NSDAE_E_ARGUMENT, "nsdae_friction_read", path ? "file" : "path",
                           "%s is NULL", path ? "file" : "path");
  *file = (nsdae_friction_file){0};
  nsdae_h5 h5 = {.file = -1, .path = path, .where = "nsdae_friction_read", .error = error};
  NSDAE_H5_QUIETLY(status, read_file(&h5, file));
  if (status < 0) nsdae_friction_file_release(file);
  return status;
}

void nsdae_friction_file_release(nsdae_friction_file *file)
{
  if (!file) return;
  const void *const held[] = {file->problem.rows,      file->problem.mu,    file->problem.w,
                              file->problem.size,      file->problem.M,     file->problem.f,
                              file->problem.first,     file->problem.block, file->problem.value,
                              file->problem.compliance};
  for (size_t i = 0; i < sizeof held / sizeof *held; i++) free((void *)held[i]);
  free(file->guess);
  free(file->r);
  free(file->low);
  free(file->velocity);
  *file = (nsdae_friction_file){0};
}
