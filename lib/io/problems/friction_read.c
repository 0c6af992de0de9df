/* Frictional contact problems from files of FCLIB. A file may be anybody's: what it says of sizes
 * is compared before memory is asked for. */
#include <limits.h>
#include <nsdae/friction_file.h>
#include <stdlib.h>

#include "to_blocks.h"

/* A problem on its way: contacts of dim rows in the file, the rest of each row's length. */
typedef struct reader {
  nsdae_h5 *h5;
  nsdae_friction_file *out;
  int local;         /* the form */
  const char *root;  /* "/fclib_local" or "/fclib_global" */
  int dim, contacts; /* rows of a contact in the file */
  int bilateral;
  nsdae_triplets A; /* W, or H, with the bilateral rows behind */
  nsdae_triplets M;
  nsdae_partition items;  /* of the rows of the file */
  nsdae_partition blocks; /* global: of v */
} reader;

/* ---- form and contacts */

/* Which form the file has; rolling friction is refused. */
static void read_form(reader *r)
{
  nsdae_h5 *h5 = r->h5;
  r->local = nsdae_h5_has(h5, "/fclib_local");
  r->root = r->local ? "/fclib_local" : "/fclib_global";
  r->out->problem.form = r->local ? NSDAE_FRICTION_LOCAL : NSDAE_FRICTION_GLOBAL;
  if (nsdae_h5_has(h5, "/fclib_global_rolling") || nsdae_h5_has(h5, "/fclib_local_rolling"))
    nsdae_h5_refuse(h5, "read",
                    "a problem of rolling friction (dimension 5); contacts must have 2 or 3 rows");
  if (r->local == nsdae_h5_has(h5, "/fclib_global"))
    nsdae_h5_refuse(h5, "read", "it has %s /fclib_local %s /fclib_global",
                    r->local ? "both" : "neither", r->local ? "and" : "nor");
}

/* The rows of a contact in the file, and of each contact where they differ. */
static void read_contacts(reader *r)
{
  nsdae_h5 *h5 = r->h5;
  nsdae_friction_problem *p = &r->out->problem;
  r->dim = nsdae_h5_take_int(h5, r->root, "spacedim", INT_MIN, INT_MAX);
  if (r->dim != 2 && r->dim != 3)
    nsdae_h5_refuse(h5, "read", "%s/spacedim is %d, must be 2 or 3", r->root, r->dim);
  r->contacts = nsdae_h5_length(h5, r->root, "vectors/mu", INT_MAX / 8);
  p->mu = nsdae_h5_take_reals(h5, r->root, "vectors/mu", NSDAE_H5_NEEDED, &r->contacts);
  for (int c = 0; c < r->contacts && h5->status == NSDAE_OK; c++)
    if (p->mu[c] < 0)
      nsdae_h5_refuse(h5, "read", "%s/vectors/mu[%d] is %g, must not be negative", r->root, c,
                      p->mu[c]);
  int *rows = nsdae_h5_take_ints(h5, r->root, "vectors/rows", NSDAE_H5_OPTIONAL, &r->contacts);
  for (int c = 0; rows && c < r->contacts && h5->status == NSDAE_OK; c++)
    if (rows[c] < 1 || rows[c] > r->dim)
      nsdae_h5_refuse(h5, "read", "%s/vectors/rows[%d] is %d, must be in [1, %d]", r->root, c,
                      rows[c], r->dim);
  if (!rows && r->dim == 2) { /* all have 3 if there are none */
    rows = nsdae_h5_allocate(h5, (size_t)r->contacts, sizeof *rows);
    for (int c = 0; rows && c < r->contacts; c++) rows[c] = 2;
  }
  p->contacts = r->contacts;
  p->rows = rows;
}

/* The items of the rows of the file; a contact's rows beyond its own belong to none. */
static void make_items(reader *r)
{
  const int *rows = r->out->problem.rows;
  int m = r->dim * r->contacts, n = m + r->bilateral;
  if (nsdae_partition_create(r->h5, n, r->contacts + r->bilateral, &r->items) < 0) return;
  for (int k = 0; k < n; k++) {
    int item = k < m ? k / r->dim : r->contacts + k - m;
    r->items.at[k] = k < m ? k % r->dim : 0;
    r->items.size[item] = k >= m ? 1 : rows ? rows[item] : r->dim;
    r->items.of[k] = r->items.at[k] < r->items.size[item] ? item : -1;
  }
}

/* ---- matrices */

static void check_shape(const reader *r, const char *name, const nsdae_triplets *A, int rows,
                        int columns)
{
  if (A->rows != rows || A->columns != columns)
    nsdae_h5_refuse(r->h5, "read", "%s/%s is %d x %d, must be %d x %d", r->root, name, A->rows,
                    A->columns, rows, columns);
}

/* Adds B at (row, column) of A, and its transpose at (column, row). */
static void join(reader *r, const nsdae_triplets *B, int row, int column, int transposed)
{
  if (B->count > INT_MAX / 2) nsdae_h5_refuse(r->h5, "read", "more than %d entries", INT_MAX / 2);
  if (r->h5->status == NSDAE_OK) /* else the count may be that of a refused matrix */
    nsdae_triplets_grow(r->h5, &r->A, transposed ? 2 * B->count : B->count);
  for (int k = 0; k < B->count && r->h5->status == NSDAE_OK; k++) {
    int i = row + B->row[k], j = column + B->column[k];
    nsdae_triplets_add(&r->A, i, j, B->value[k]);
    if (transposed) nsdae_triplets_add(&r->A, j, i, B->value[k]);
  }
}

/* The vector over the bilateral rows is in the file, and as long as the matrices claim: memory is
 * asked for by their number. */
static void check_bilateral(const reader *r, const char *name)
{
  if (r->bilateral == 0) return;
  int length = nsdae_h5_length(r->h5, r->root, name, INT_MAX);
  if (length != r->bilateral)
    nsdae_h5_refuse(r->h5, "read", "%s/%s has %d numbers, must have %d", r->root, name,
                    length < 0 ? 0 : length, r->bilateral);
}

/* ---- local form */

/* W, and with bilateral rows [W V; V^T R]. */
static void read_local(reader *r)
{
  nsdae_triplets V, R;
  int m = r->dim * r->contacts;
  nsdae_triplets_read(r->h5, r->root, "W", NSDAE_H5_NEEDED, &r->A);
  check_shape(r, "W", &r->A, m, m);
  nsdae_triplets_read(r->h5, r->root, "V", NSDAE_H5_OPTIONAL, &V);
  nsdae_triplets_read(r->h5, r->root, "R", NSDAE_H5_OPTIONAL, &R);
  r->bilateral = V.columns > R.columns ? V.columns : R.columns;
  if (V.rows + V.columns > 0) check_shape(r, "V", &V, m, r->bilateral);
  if (R.rows + R.columns > 0) check_shape(r, "R", &R, r->bilateral, r->bilateral);
  check_bilateral(r, "vectors/s");
  join(r, &V, 0, m, 1);
  join(r, &R, m, m, 0);
  r->A.rows = r->A.columns = m + r->bilateral;
  nsdae_triplets_release(&V);
  nsdae_triplets_release(&R);
  r->out->asymmetry = nsdae_symmetrise(r->h5, &r->A);
  make_items(r);
  nsdae_to_blocks(r->h5, &r->A, &r->items, &r->items, &r->out->problem);
}

/* ---- global form */

/* The blocks of v: those that are written down, or found. */
static void read_blocks(reader *r)
{
  int n = r->M.rows, parts = nsdae_h5_length(r->h5, r->root, "blocks", n);
  int *size = nsdae_h5_take_ints(r->h5, r->root, "blocks", NSDAE_H5_OPTIONAL, &parts);
  if (size)
    nsdae_partition_make(r->h5, n, parts, size, &r->blocks);
  else
    nsdae_partition_find(r->h5, &r->M, r->dim == 3 ? 6 : 3, &r->blocks);
  free(size);
}

/* H, and with bilateral rows [H G]. */
static void read_H(reader *r)
{
  nsdae_triplets G;
  int m = r->dim * r->contacts, n = r->M.rows;
  nsdae_triplets_read(r->h5, r->root, "H", NSDAE_H5_NEEDED, &r->A);
  check_shape(r, "H", &r->A, n, m);
  nsdae_triplets_read(r->h5, r->root, "G", NSDAE_H5_OPTIONAL, &G);
  r->bilateral = G.columns;
  if (G.rows + G.columns > 0) check_shape(r, "G", &G, n, r->bilateral);
  check_bilateral(r, "vectors/b");
  join(r, &G, 0, m, 0);
  r->A.columns = m + r->bilateral;
  nsdae_triplets_release(&G);
}

/* f of the file, and where its entries come from, in the order of the blocks. */
static void order_velocities(reader *r, const double *f)
{
  const nsdae_partition *v = &r->blocks;
  double *ordered = nsdae_h5_allocate(r->h5, (size_t)v->n, sizeof *ordered);
  int *home = nsdae_h5_allocate(r->h5, (size_t)v->parts, sizeof *home);
  int *velocity = nsdae_h5_allocate(r->h5, (size_t)v->n, sizeof *velocity);
  for (int b = 1; velocity && b < v->parts; b++) home[b] = home[b - 1] + v->size[b - 1];
  for (int i = 0; velocity && i < v->n; i++) {
    int place = home[v->of[i]] + v->at[i];
    ordered[place] = f[i];
    velocity[place] = i;
  }
  free(home);
  r->out->problem.f = ordered;
  r->out->velocity = velocity;
}

static void read_global(reader *r)
{
  nsdae_friction_problem *p = &r->out->problem;
  nsdae_triplets_read(r->h5, r->root, "M", NSDAE_H5_NEEDED, &r->M);
  check_shape(r, "M", &r->M, r->M.rows, r->M.rows);
  double *f = nsdae_h5_take_reals(r->h5, r->root, "vectors/f", NSDAE_H5_NEEDED, &r->M.rows);
  read_H(r);
  r->out->asymmetry = nsdae_symmetrise(r->h5, &r->M);
  read_blocks(r);
  make_items(r);
  p->M = nsdae_to_blocks_diagonal(r->h5, &r->M, &r->blocks);
  order_velocities(r, f);
  free(f);
  nsdae_to_blocks(r->h5, &r->A, &r->blocks, &r->items, p);
  p->blocks = r->blocks.parts;
  p->size = r->blocks.size;
  r->blocks.size = NULL;
}

/* ---- vectors */

/* A vector over the contacts, with that over the bilateral rows behind it, of the rows that items
 * have; NULL if it is not there and need not be. */
static double *read_rows(const reader *r, const char *root, const char *name, const char *behind,
                         int needed)
{
  int m = r->dim * r->contacts, p = r->bilateral, k = 0;
  double *both = NULL, *tail = NULL;
  double *head = nsdae_h5_take_reals(r->h5, root, name, needed, &m);
  if (head && p > 0) tail = nsdae_h5_take_reals(r->h5, root, behind, needed, &p);
  if (head) both = nsdae_h5_allocate(r->h5, (size_t)r->items.n, sizeof *both);
  for (int i = 0; both && i < r->items.n; i++)
    if (r->items.of[i] >= 0) both[k++] = i < m ? head[i] : tail ? tail[i - m] : 0;
  free(head);
  free(tail);
  return both;
}

/* w or q, the compliance, the first guess and the solution. */
static void read_vectors(const reader *r)
{
  nsdae_friction_file *out = r->out;
  out->problem.w = read_rows(r, r->root, r->local ? "vectors/q" : "vectors/w",
                             r->local ? "vectors/s" : "vectors/b", NSDAE_H5_NEEDED);
  out->problem.compliance =
      read_rows(r, r->root, "vectors/compliance", "vectors/compliance_l", NSDAE_H5_OPTIONAL);
  out->guess = read_rows(r, "/guesses/1", "r", "l", NSDAE_H5_OPTIONAL);
  out->r = read_rows(r, "/solution", "r", "l", NSDAE_H5_OPTIONAL);
  if (out->r) out->low = read_rows(r, "/solution", "r_low", "l_low", NSDAE_H5_OPTIONAL);
}

/* ---- the file */

/* Form, contacts, matrices, vectors, tolerances. */
static void read_problem(nsdae_h5 *h5, nsdae_friction_file *out)
{
  reader r = {.h5 = h5, .out = out};
  read_form(&r);
  read_contacts(&r);
  if (h5->status < 0) return;
  if (r.local)
    read_local(&r);
  else
    read_global(&r);
  read_vectors(&r);
  out->problem.bilateral = r.bilateral;
  out->tol = nsdae_h5_get_real(h5, h5->file, "tol");
  double refine = nsdae_h5_get_real(h5, h5->file, "refine");
  out->refine = refine >= 0 && refine <= 1000 ? (int)refine : 0;
  nsdae_triplets_release(&r.A);
  nsdae_triplets_release(&r.M);
  nsdae_partition_release(&r.items);
  nsdae_partition_release(&r.blocks);
}

int nsdae_friction_read(const char *path, nsdae_friction_file *file, nsdae_error *error)
{
  nsdae_error_clear(error);
  if (!path || !file)
    return nsdae_error_set(error, NSDAE_E_ARGUMENT, "nsdae_friction_read", path ? "file" : "path",
                           "%s is NULL", path ? "file" : "path");
  *file = (nsdae_friction_file){0};
  nsdae_h5 h5 = {.file = -1, .path = path, .where = "nsdae_friction_read", .error = error};
  H5E_BEGIN_TRY
    if (nsdae_h5_open(&h5) == NSDAE_OK) read_problem(&h5, file);
    if (nsdae_h5_close(&h5) < 0) nsdae_friction_file_release(file);
  H5E_END_TRY
  return h5.status;
}
