/* Frictional contact problems to files of FCLIB. Matrices are written as triplets in the order of
 * the blocks, zeros included, so that what is read again is the same to the last bit. */
#include <limits.h>
#include <nsdae/friction_file.h>
#include <stdlib.h>
#include <string.h>

#include "dense.h"
#include "double_double.h"
#include "global_problem.h"
#include "to_blocks.h"

typedef struct writer {
  nsdae_h5 h5;
  const nsdae_friction_problem *p;
  nsdae_fc_view view; /* of it */
  int local;          /* the form */
  const char *root;
  int dim;        /* rows of a contact in the file */
  double *spread; /* rows of the file: a vector on its way */
} writer;

/* The first row of an item in the file. */
static int row_in_file(const writer *w, int item)
{
  int nc = w->p->contacts;
  return item < nc ? w->dim * item : w->dim * nc + item - nc;
}

/* Of every dataset: some are FCLIB's, some stand beside those. */
static const char SEE[] = "see FCLIB and nsdae/friction_file.h";

/* ---- vectors */

static void write_vector(writer *w, const char *root, const char *name, hid_t type, int count,
                         const void *values)
{
  char path[NSDAE_H5_PATH];
  nsdae_h5_vector(&w->h5, nsdae_h5_join(path, root, name), type, (hsize_t)count, values, "1", SEE);
}

/* A vector over the rows of the problem, if it is given: its contacts to one dataset, bilateral
 * rows to another. */
static void write_rows(writer *w, const char *root, const char *name, const char *behind,
                       const double *values)
{
  int m = row_in_file(w, w->p->contacts);
  if (!values) return;
  memset(w->spread, 0, (size_t)(m + w->p->bilateral) * sizeof *w->spread);
  for (int i = 0; i < w->view.items; i++)
    memcpy(w->spread + row_in_file(w, i), values + w->view.row[i],
           (size_t)nsdae_fc_rows(w->p, i) * sizeof *values);
  write_vector(w, root, name, H5T_NATIVE_DOUBLE, m, w->spread);
  if (w->p->bilateral > 0)
    write_vector(w, root, behind, H5T_NATIVE_DOUBLE, w->p->bilateral, w->spread + m);
}

/* ---- matrices */

static nsdae_triplets make_triplets(writer *w, const char *name, int rows, int columns,
                                    long long count)
{
  nsdae_h5 *h5 = &w->h5;
  nsdae_triplets A = {.rows = rows, .columns = columns};
  if (count > INT_MAX / 2 && h5->status == NSDAE_OK)
    h5->status =
        nsdae_error_set(h5->error, NSDAE_E_ARGUMENT, h5->where, "problem",
                        "%s has %lld entries, FCLIB's files hold %d", name, count, INT_MAX / 2);
  if (h5->status == NSDAE_OK) nsdae_triplets_grow(h5, &A, (int)count);
  return A;
}

static void write_triplets(writer *w, const char *name, nsdae_triplets *A)
{
  nsdae_triplets_write(&w->h5, w->root, name, A);
  nsdae_triplets_release(A);
}

/* Adds a dense part in the rows from row on. */
static void add_part(nsdae_triplets *A, int row, int column, int rows, int columns,
                     const double *value)
{
  for (int j = 0; j < columns; j++)
    for (int i = 0; i < rows; i++)
      nsdae_triplets_add(A, row + i, column + j, value[(size_t)j * (size_t)rows + (size_t)i]);
}

/* The first row of a block in the file, and its rows: of W those of the item, of H those of v. */
static int block_row(const writer *w, int b)
{
  return w->local ? row_in_file(w, b) : w->view.offset[b];
}

static int block_size(const writer *w, int b)
{
  return w->local ? nsdae_fc_rows(w->p, b) : w->p->size[b];
}

/* The part of the problem of items from .. end - 1 and blocks low .. high - 1, as a matrix. */
static void write_range(writer *w, const char *name, int from, int end, int low, int high)
{
  const nsdae_friction_problem *p = w->p;
  int row = block_row(w, low), column = row_in_file(w, from);
  nsdae_triplets A = {0};
  for (int pass = 0; pass < 2 && w->h5.status == NSDAE_OK; pass++) {
    long long count = 0;
    for (int i = from; i < end; i++)
      for (int e = p->first[i]; e < p->first[i + 1]; e++) {
        int b = p->block[e], size = block_size(w, b), columns = nsdae_fc_rows(p, i);
        if (b < low || b >= high) continue;
        count += (long long)size * columns;
        if (pass == 1)
          add_part(&A, block_row(w, b) - row, row_in_file(w, i) - column, size, columns,
                   p->value + w->view.at[e]);
      }
    if (pass == 0)
      A = make_triplets(w, name, block_row(w, high) - row, row_in_file(w, end) - column, count);
  }
  write_triplets(w, name, &A);
}

/* W, V and R. */
static void write_local(writer *w)
{
  int nc = w->p->contacts, items = w->view.items;
  write_range(w, "W", 0, nc, 0, nc);
  if (items > nc) write_range(w, "V", nc, items, 0, nc);
  if (items > nc) write_range(w, "R", nc, items, nc, items);
}

/* M, H, G, f and the sizes of the blocks. */
static void write_global(writer *w)
{
  const nsdae_friction_problem *p = w->p;
  int nc = p->contacts, n = w->view.nv;
  nsdae_triplets M = make_triplets(w, "M", n, n, (long long)w->view.mass_at[p->blocks]);
  for (int b = 0; b < p->blocks && w->h5.status == NSDAE_OK; b++)
    add_part(&M, w->view.offset[b], w->view.offset[b], p->size[b], p->size[b],
             p->M + w->view.mass_at[b]);
  write_triplets(w, "M", &M);
  write_range(w, "H", 0, nc, 0, p->blocks);
  if (p->bilateral > 0) write_range(w, "G", nc, w->view.items, 0, p->blocks);
  write_vector(w, w->root, "vectors/f", H5T_NATIVE_DOUBLE, n, p->f);
  write_vector(w, w->root, "blocks", H5T_NATIVE_INT, p->blocks, p->size);
}

/* ---- contacts */

/* mu, and the rows of each contact where they differ. */
static void write_contacts(writer *w)
{
  const nsdae_friction_problem *p = w->p;
  int even = 1;
  for (int c = 0; c < p->contacts; c++) {
    even &= nsdae_fc_rows(p, c) == w->dim;
    w->spread[c] = nsdae_fc_rows(p, c) > 1 ? p->mu[c] : 0;
  }
  write_vector(w, w->root, "spacedim", H5T_NATIVE_INT, 1, &w->dim);
  write_vector(w, w->root, "vectors/mu", H5T_NATIVE_DOUBLE, p->contacts, w->spread);
  if (!even) write_vector(w, w->root, "vectors/rows", H5T_NATIVE_INT, p->contacts, p->rows);
}

/* ---- solution */

/* f + H r in twice the precision, high + low, as impulses cancel. */
static void add_impulses(const writer *w, const double *r, double *high, double *low)
{
  const nsdae_friction_problem *p = w->p;
  for (int i = 0; r && i < w->view.items; i++)
    for (int e = p->first[i]; e < p->first[i + 1]; e++) {
      int at = w->view.offset[p->block[e]];
      nsdae_dd_add_product(p->size[p->block[e]], nsdae_fc_rows(p, i), p->value + w->view.at[e],
                           r + w->view.row[i], high + at, low + at);
    }
}

/* v = M^-1 (f + H (r + low)) of the global form. */
static void write_velocities(writer *w, const nsdae_friction_points *points)
{
  const nsdae_friction_problem *p = w->p;
  size_t nv = (size_t)w->view.nv, largest = 0;
  for (int b = 0; b < p->blocks; b++) {
    size_t entries = w->view.mass_at[b + 1] - w->view.mass_at[b];
    if (entries > largest) largest = entries;
  }
  double *v = nsdae_h5_allocate(&w->h5, 2 * nv + largest, sizeof *v);
  if (!v) return;
  double *low = v + nv, *factor = low + nv;
  memcpy(v, p->f, nv * sizeof *v);
  add_impulses(w, points->r, v, low);
  add_impulses(w, points->low, v, low);
  for (size_t i = 0; i < nv; i++) v[i] += low[i];
  for (int b = 0; b < p->blocks; b++) {
    int n = p->size[b], at = w->view.offset[b];
    memcpy(factor, p->M + w->view.mass_at[b], (size_t)n * (size_t)n * sizeof *factor);
    nsdae_la_cholesky(n, factor, n); /* the problem was checked */
    nsdae_la_solve_lower(n, 1, factor, n, v + at, n);
    nsdae_la_solve_lower_transposed(n, 1, factor, n, v + at, n);
  }
  write_vector(w, "/solution", "v", H5T_NATIVE_DOUBLE, w->view.nv, v);
  free(v);
}

/* The guess, and the solution r, in one part or two, v and u. */
static void write_points(writer *w, const nsdae_friction_points *points)
{
  const int one = 1;
  if (points->guess) write_vector(w, "/guesses", "number_of_guesses", H5T_NATIVE_INT, 1, &one);
  write_rows(w, "/guesses/1", "r", "l", points->guess);
  write_rows(w, "/solution", "r", "l", points->r);
  if (points->r) write_rows(w, "/solution", "r_low", "l_low", points->low);
  if (points->r && !w->local) write_velocities(w, points);
  write_rows(w, "/solution", "u", "u_l", points->u);
}

/* ---- the file */

static void write_problem(writer *w, const nsdae_friction_points *points,
                          const nsdae_friction_origin *origin)
{
  const nsdae_friction_problem *p = w->p;
  write_contacts(w);
  if (w->local)
    write_local(w);
  else
    write_global(w);
  write_rows(w, w->root, w->local ? "vectors/q" : "vectors/w", w->local ? "vectors/s" : "vectors/b",
             w->view.m > 0 ? p->w : w->spread);
  write_rows(w, w->root, "vectors/compliance", "vectors/compliance_l", p->compliance);
  if (points) write_points(w, points);
  nsdae_h5_set_text(&w->h5, w->h5.file, "library_version", nsdae_version());
  if (!origin) return;
  nsdae_h5_set_origin(&w->h5, origin->time, origin->step, origin->tol, origin->method);
  nsdae_h5_set_int(&w->h5, w->h5.file, "refine", origin->refine);
}

/* The arrays of the writer. */
static void layout(void *writer_of, nsdae_arena *arena)
{
  writer *w = writer_of;
  nsdae_fc_view_layout(&w->view, arena);
  w->spread = nsdae_arena_take(arena, (long)row_in_file(w, w->view.items) + 1, sizeof *w->spread);
}

int nsdae_friction_write(const char *path, const nsdae_friction_problem *problem,
                         const nsdae_friction_points *points, const nsdae_friction_origin *origin,
                         nsdae_error *error)
{
  nsdae_arena arena;
  writer w = {.h5 = {.file = -1, .path = path, .where = "nsdae_friction_write", .error = error}};
  nsdae_error_clear(error);
  if (!path) return nsdae_error_set(error, NSDAE_E_ARGUMENT, w.h5.where, "path", "path is NULL");
  int status = nsdae_friction_check(problem, error);
  if (status < 0) return status;
  w.p = w.view.p = problem;
  w.local = problem->form == NSDAE_FRICTION_LOCAL;
  w.root = w.local ? "/fclib_local" : "/fclib_global";
  w.dim = 2;
  for (int c = 0; c < problem->contacts; c++)
    if (nsdae_fc_rows(problem, c) == 3) w.dim = 3;
  if (nsdae_arena_build(&arena, layout, &w) < 0) return nsdae_h5_no_memory(&w.h5);
  nsdae_fc_view_fill(&w.view);
  H5E_BEGIN_TRY
    if (nsdae_h5_create(&w.h5, NSDAE_H5_PLAIN) == NSDAE_OK) write_problem(&w, points, origin);
    nsdae_h5_flush(&w.h5);
    nsdae_h5_close(&w.h5);
  H5E_END_TRY
  nsdae_arena_release(&arena);
  return w.h5.status;
}
