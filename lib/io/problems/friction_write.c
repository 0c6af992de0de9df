/* Frictional contact problems to files of FCLIB. Matrices are written as triplets in the order of
 * the blocks, zeros included, so that what is read again is the same to the last bit. */
#include <limits.h>
#include <nsdae/friction_file.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "dense.h"
#include "hdf5_data.h"
#include "triplets.h"
#include "double_double.h"

typedef struct writer {
  nsdae_h5 *h5;
  const nsdae_friction_problem *problem;
  const char *root;
  int dim, even;     /* rows of a contact in the file; whether all have that number */
  int items, places; /* items, and rows of the file */
  int *rows;         /* items: of each */
  int *first;        /* items: its first row in the file */
  int *home;         /* items: the same in the problem */
  double *spread;    /* places: a vector on its way */
} writer;

static const char *path_of(const writer *w, char path[64], const char *name)
{
  snprintf(path, 64, "%s/%s", w->root, name);
  return path;
}

/* Rows of the items, here and in the file. */
static int measure_rows(writer *w)
{
  const nsdae_friction_problem *p = w->problem;
  w->items = p->contacts + p->bilateral;
  w->rows = calloc((size_t)w->items + 1, sizeof *w->rows);
  w->first = calloc((size_t)w->items + 1, sizeof *w->first);
  w->home = calloc((size_t)w->items + 1, sizeof *w->home);
  if (!w->rows || !w->first || !w->home) return nsdae_h5_no_memory(w->h5);
  w->dim = 2;
  for (int i = 0; i < w->items; i++) {
    w->rows[i] = i >= p->contacts ? 1 : p->rows ? p->rows[i] : 3;
    if (w->rows[i] > w->dim) w->dim = w->rows[i];
  }
  w->even = 1;
  for (int i = 0; i < w->items; i++) {
    int own = i < p->contacts ? w->dim : 1;
    w->even &= own == w->rows[i];
    w->first[i + 1] = w->first[i] + own;
    w->home[i + 1] = w->home[i] + w->rows[i];
  }
  w->places = w->first[w->items];
  w->spread = calloc((size_t)w->places + 1, sizeof *w->spread);
  return w->spread ? NSDAE_OK : nsdae_h5_no_memory(w->h5);
}

/* Of every dataset: some are FCLIB's, some stand beside those. */
static const char SEE[] = "see FCLIB and nsdae/friction_file.h";

/* ---- vectors */

static int write_reals(const writer *w, const char *path, int count, const double *values)
{
  return nsdae_h5_vector(w->h5, path, H5T_NATIVE_DOUBLE, (hsize_t)count, values, "1", SEE);
}

static int write_ints(const writer *w, const char *path, int count, const int *values)
{
  return nsdae_h5_vector(w->h5, path, H5T_NATIVE_INT, (hsize_t)count, values, "1", SEE);
}

/* A vector over the rows of the problem: its contacts to one path, bilateral rows to another. */
static int write_rows(writer *w, const char *name, const char *behind, const double *values)
{
  int m = w->dim * w->problem->contacts;
  memset(w->spread, 0, (size_t)w->places * sizeof *w->spread);
  for (int i = 0; i < w->items; i++)
    for (int d = 0; d < w->rows[i]; d++) w->spread[w->first[i] + d] = values[w->home[i] + d];
  int status = write_reals(w, name, m, w->spread);
  if (status < 0 || w->problem->bilateral == 0) return status;
  return write_reals(w, behind, w->problem->bilateral, w->spread + m);
}

/* Dense parts as triplets. */

/* ---- matrices */

/* Adds the dense part of an item in the rows from row on. */
static void add_part(nsdae_triplets *A, int row, int column, int rows, int columns,
                     const double *value)
{
  for (int j = 0; j < columns; j++)
    for (int i = 0; i < rows; i++)
      nsdae_triplets_add(A, row + i, column + j, value[(size_t)j * (size_t)rows + (size_t)i]);
}

/* Items from .. end - 1 whose blocks are in [low, high): in rows first[block] of the matrix, of
 * size[block] each. */
typedef struct range {
  int from, end, low, high;
  const int *first, *size;
} range;

/* Adds the part of the problem in that range, at the corner of it, or only counts. */
static long long gather_entries(const writer *w, const range *r, nsdae_triplets *A)
{
  const nsdae_friction_problem *p = w->problem;
  const double *value = p->value;
  long long count = 0;
  for (int i = 0; i < r->end; i++)
    for (int k = p->first[i]; k < p->first[i + 1]; k++) {
      int b = p->block[k], size = r->size[b], inside = i >= r->from && b >= r->low && b < r->high;
      if (inside) count += (long long)size * w->rows[i];
      if (inside && A)
        add_part(A, r->first[b] - r->first[r->low], w->first[i] - w->first[r->from], size,
                 w->rows[i], value);
      value += (size_t)size * (size_t)w->rows[i];
    }
  return count;
}

static int write_range(const writer *w, const char *name, const range *r, int rows, int columns)
{
  char path[64];
  long long count = gather_entries(w, r, NULL);
  nsdae_triplets A = {.rows = rows, .columns = columns};
  if (count > INT_MAX / 2)
    return nsdae_error_set(w->h5->error, NSDAE_E_ARGUMENT, w->h5->where, "problem",
                           "%s has %lld entries, FCLIB's files hold %d", name, count, INT_MAX / 2);
  int status = nsdae_triplets_grow(w->h5, &A, (int)count);
  if (status == NSDAE_OK) {
    gather_entries(w, r, &A);
    status = nsdae_triplets_write(w->h5, path_of(w, path, name), &A);
  }
  nsdae_triplets_release(&A);
  return status;
}

/* W, V and R. */
static int write_local(const writer *w)
{
  int nc = w->problem->contacts, p = w->problem->bilateral, m = w->dim * nc;
  const range of_W = {0, nc, 0, nc, w->first, w->rows};
  const range of_V = {nc, w->items, 0, nc, w->first, w->rows};
  const range of_R = {nc, w->items, nc, w->items, w->first, w->rows};
  int status = write_range(w, "W", &of_W, m, m);
  if (status == NSDAE_OK && p > 0) status = write_range(w, "V", &of_V, m, p);
  if (status == NSDAE_OK && p > 0) status = write_range(w, "R", &of_R, p, p);
  return status;
}

/* The mass matrix as one sparse matrix of its diagonal blocks. */
static int write_M(const writer *w, int n)
{
  char path[64];
  const nsdae_friction_problem *p = w->problem;
  const double *value = p->M;
  nsdae_triplets M = {.rows = n, .columns = n};
  long long count = 0;
  for (int b = 0; b < p->blocks; b++) count += (long long)p->size[b] * p->size[b];
  if (count > INT_MAX / 2)
    return nsdae_error_set(w->h5->error, NSDAE_E_ARGUMENT, w->h5->where, "problem",
                           "M has %lld entries, FCLIB's files hold %d", count, INT_MAX / 2);
  int status = nsdae_triplets_grow(w->h5, &M, (int)count);
  for (int b = 0, row = 0; b < p->blocks && status == NSDAE_OK; row += p->size[b++]) {
    add_part(&M, row, row, p->size[b], p->size[b], value);
    value += (size_t)p->size[b] * (size_t)p->size[b];
  }
  if (status == NSDAE_OK) status = nsdae_triplets_write(w->h5, path_of(w, path, "M"), &M);
  nsdae_triplets_release(&M);
  return status;
}

/* M, H, G, f and the sizes of the blocks. */
static int write_global(const writer *w)
{
  char path[64];
  const nsdae_friction_problem *p = w->problem;
  int nc = p->contacts, *first = calloc((size_t)p->blocks + 1, sizeof *first);
  if (!first) return nsdae_h5_no_memory(w->h5);
  for (int b = 0; b < p->blocks; b++) first[b + 1] = first[b] + p->size[b];
  int n = first[p->blocks];
  const range of_H = {0, nc, 0, p->blocks, first, p->size};
  const range of_G = {nc, w->items, 0, p->blocks, first, p->size};
  int status = write_M(w, n);
  if (status == NSDAE_OK) status = write_range(w, "H", &of_H, n, w->dim * nc);
  if (status == NSDAE_OK && p->bilateral > 0) status = write_range(w, "G", &of_G, n, p->bilateral);
  if (status == NSDAE_OK) status = write_reals(w, path_of(w, path, "vectors/f"), n, p->f);
  if (status == NSDAE_OK) status = write_ints(w, path_of(w, path, "blocks"), p->blocks, p->size);
  free(first);
  return status;
}

/* ---- contacts */

/* mu, and the rows of each contact where they differ. */
static int write_contacts(writer *w)
{
  char path[64];
  const nsdae_friction_problem *p = w->problem;
  for (int c = 0; c < p->contacts; c++) w->spread[c] = w->rows[c] > 1 ? p->mu[c] : 0;
  int status = write_ints(w, path_of(w, path, "spacedim"), 1, &w->dim);
  if (status == NSDAE_OK)
    status = write_reals(w, path_of(w, path, "vectors/mu"), p->contacts, w->spread);
  if (status == NSDAE_OK && !w->even)
    status = write_ints(w, path_of(w, path, "vectors/rows"), p->contacts, w->rows);
  return status;
}

/* Velocities on their way: f + H r in twice the precision, high + low, as impulses cancel. */
typedef struct motion {
  int n, largest; /* rows of v, and of its largest block */
  int *first;     /* blocks: the first row of each */
  double *high;   /* n */
  double *low;    /* n */
  double *factor; /* largest x largest: of a block of M */
} motion;

/* ---- solution */

/* Begins at f. */
static int make_motion(const writer *w, motion *v)
{
  const nsdae_friction_problem *p = w->problem;
  *v = (motion){.largest = 1, .first = calloc((size_t)p->blocks + 1, sizeof *v->first)};
  for (int b = 0; b < p->blocks; b++) {
    if (v->first) v->first[b] = v->n;
    v->n += p->size[b];
    if (p->size[b] > v->largest) v->largest = p->size[b];
  }
  v->high = calloc(2 * (size_t)v->n + 1, sizeof *v->high);
  v->factor = malloc((size_t)v->largest * (size_t)v->largest * sizeof *v->factor);
  if (!v->first || !v->high || !v->factor) return nsdae_h5_no_memory(w->h5);
  v->low = v->high + v->n;
  memcpy(v->high, p->f, (size_t)v->n * sizeof *v->high);
  return NSDAE_OK;
}

/* Adds H r; without r nothing. */
static void add_impulses(const writer *w, const double *r, motion *v)
{
  const nsdae_friction_problem *p = w->problem;
  const double *value = p->value;
  for (int i = 0; r && i < w->items; i++)
    for (int k = p->first[i]; k < p->first[i + 1]; k++) {
      int b = p->block[k];
      nsdae_dd_add_product(p->size[b], w->rows[i], value, r + w->home[i], v->high + v->first[b],
                           v->low + v->first[b]);
      value += (size_t)p->size[b] * (size_t)w->rows[i];
    }
}

/* high = M^-1 (high + low) */
static void divide_by_mass(const writer *w, motion *v)
{
  const nsdae_friction_problem *p = w->problem;
  const double *M = p->M;
  for (int i = 0; i < v->n; i++) v->high[i] += v->low[i];
  for (int b = 0; b < p->blocks; b++) {
    int n = p->size[b];
    memcpy(v->factor, M, (size_t)n * (size_t)n * sizeof *v->factor);
    M += (size_t)n * (size_t)n;
    nsdae_la_cholesky(n, v->factor, n); /* the problem was checked */
    nsdae_la_solve_lower(n, 1, v->factor, n, v->high + v->first[b], n);
    nsdae_la_solve_lower_transposed(n, 1, v->factor, n, v->high + v->first[b], n);
  }
}

/* v = M^-1 (f + H (r + low)) of the global form. */
static int write_velocities(const writer *w, const nsdae_friction_points *points)
{
  motion v;
  int status = make_motion(w, &v);
  if (status == NSDAE_OK) {
    add_impulses(w, points->r, &v);
    add_impulses(w, points->low, &v);
    divide_by_mass(w, &v);
    status = write_reals(w, "/solution/v", v.n, v.high);
  }
  free(v.first);
  free(v.high);
  free(v.factor);
  return status;
}

/* r, in one part or two, v and u. */
static int write_solution(writer *w, const nsdae_friction_points *points)
{
  int status = NSDAE_OK;
  if (points->r) status = write_rows(w, "/solution/r", "/solution/l", points->r);
  if (status == NSDAE_OK && points->r && points->low)
    status = write_rows(w, "/solution/r_low", "/solution/l_low", points->low);
  if (status == NSDAE_OK && points->r && w->problem->form == NSDAE_FRICTION_GLOBAL)
    status = write_velocities(w, points);
  if (status == NSDAE_OK && points->u)
    status = write_rows(w, "/solution/u", "/solution/u_l", points->u);
  return status;
}

/* The guess and the solution. */
static int write_points(writer *w, const nsdae_friction_points *points)
{
  int one = 1, status = NSDAE_OK;
  if (points->guess) {
    status = write_ints(w, "/guesses/number_of_guesses", 1, &one);
    if (status == NSDAE_OK) status = write_rows(w, "/guesses/1/r", "/guesses/1/l", points->guess);
  }
  return status < 0 ? status : write_solution(w, points);
}

/* ---- the file */

static int write_origin(nsdae_h5 *h5, const nsdae_friction_origin *origin)
{
  int status = nsdae_h5_set_text(h5, h5->file, "library_version", nsdae_version());
  if (status < 0 || !origin) return status;
  status = nsdae_h5_set_real(h5, h5->file, "time", origin->time);
  if (status == NSDAE_OK) status = nsdae_h5_set_int(h5, h5->file, "step", (int)origin->step);
  if (status == NSDAE_OK) status = nsdae_h5_set_real(h5, h5->file, "tol", origin->tol);
  if (status == NSDAE_OK) status = nsdae_h5_set_int(h5, h5->file, "refine", origin->refine);
  if (status == NSDAE_OK && origin->method)
    status = nsdae_h5_set_text(h5, h5->file, "method", origin->method);
  return status;
}

static int write_problem(writer *w, const nsdae_friction_points *points,
                         const nsdae_friction_origin *origin)
{
  char first[64], second[64];
  const nsdae_friction_problem *p = w->problem;
  int local = p->form == NSDAE_FRICTION_LOCAL;
  w->root = local ? "/fclib_local" : "/fclib_global";
  int status = write_contacts(w);
  if (status == NSDAE_OK) status = local ? write_local(w) : write_global(w);
  if (status == NSDAE_OK)
    status = write_rows(w, path_of(w, first, local ? "vectors/q" : "vectors/w"),
                        path_of(w, second, local ? "vectors/s" : "vectors/b"), p->w);
  if (status == NSDAE_OK && p->compliance)
    status = write_rows(w, path_of(w, first, "vectors/compliance"),
                        path_of(w, second, "vectors/compliance_l"), p->compliance);
  if (status == NSDAE_OK && points) status = write_points(w, points);
  return status < 0 ? status : write_origin(w->h5, origin);
}

static int write_file(writer *w, const nsdae_friction_points *points,
                      const nsdae_friction_origin *origin)
{
  int status = nsdae_h5_create(w->h5, NSDAE_H5_PLAIN);
  if (status < 0) return status;
  status = write_problem(w, points, origin);
  if (status == NSDAE_OK) status = nsdae_h5_flush(w->h5);
  int closed = nsdae_h5_close(w->h5);
  return status < 0 ? status : closed;
}

int nsdae_friction_write(const char *path, const nsdae_friction_problem *problem,
                         const nsdae_friction_points *points, const nsdae_friction_origin *origin,
                         nsdae_error *error)
{
  nsdae_error_clear(error);
  if (!path)
    return nsdae_error_set(error, NSDAE_E_ARGUMENT, "nsdae_friction_write", "path", "path is NULL");
  int status = nsdae_friction_check(problem, error);
  if (status < 0) return status;
  nsdae_h5 h5 = {.file = -1, .path = path, .where = "nsdae_friction_write", .error = error};
  writer w = {.h5 = &h5, .problem = problem};
  status = measure_rows(&w);
  if (status == NSDAE_OK) NSDAE_H5_QUIETLY(status, write_file(&w, points, origin));
  free(w.rows);
  free(w.first);
  free(w.home);
  free(w.spread);
  return status;
}
