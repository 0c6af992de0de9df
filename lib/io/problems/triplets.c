#include "triplets.h"

#include <limits.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "hdf5_data.h"

enum { NAME = 96 };
enum { COLUMNS = -1, ROWS = -2 }; /* values of nz */

int nsdae_h5_refuse(nsdae_h5 *h5, const char *format, ...)
{
  char text[160];
  va_list args;
  va_start(args, format);
  vsnprintf(text, sizeof text, format, args);
  va_end(args);
  return nsdae_error_set(h5->error, NSDAE_E_IO, h5->where, "path", "cannot read '%.90s': %s",
                         h5->path, text);
}

int nsdae_h5_no_memory(nsdae_h5 *h5)
{
  return nsdae_error_set(h5->error, NSDAE_E_MEMORY, h5->where, "", "out of memory for '%.90s'",
                         h5->path);
}

static int no_memory_for(nsdae_h5 *h5, size_t count)
{
  return nsdae_error_set(h5->error, NSDAE_E_MEMORY, h5->where, "",
                         "out of memory for %zu numbers of '%.90s'", count, h5->path);
}

/* ---- vectors */

int nsdae_h5_has(nsdae_h5 *h5, const char *path)
{
  char part[NAME];
  size_t length = strlen(path);
  for (size_t i = 1; i <= length; i++) {
    if (path[i] != '/' && path[i] != '\0') continue;
    snprintf(part, sizeof part, "%.*s", (int)i, path);
    if (H5Lexists(h5->file, part, H5P_DEFAULT) <= 0) return 0;
  }
  return 1;
}

int nsdae_h5_length(nsdae_h5 *h5, const char *path, long most, int *length)
{
  hsize_t found = 0;
  *length = -1;
  if (!nsdae_h5_has(h5, path)) return NSDAE_OK;
  int status = nsdae_h5_shape(h5, path, 1, &found);
  if (status < 0) return status;
  if (found > (hsize_t)most)
    return nsdae_h5_refuse(h5, "%s has %llu numbers, at most %ld are read", path,
                           (unsigned long long)found, most);
  *length = (int)found;
  return NSDAE_OK;
}

/* Room for a vector of that length, which the file must have. */
static int allocate_vector(nsdae_h5 *h5, const char *path, int length, size_t size, void **values)
{
  int found;
  int status = nsdae_h5_length(h5, path, INT_MAX, &found);
  if (status < 0) return status;
  if (found != length)
    return found < 0 ? nsdae_h5_refuse(h5, "%s is missing", path)
                     : nsdae_h5_refuse(h5, "%s has %d numbers, must be %d", path, found, length);
  *values = calloc((size_t)length + 1, size);
  return *values ? NSDAE_OK : no_memory_for(h5, (size_t)length);
}

int nsdae_h5_take_reals(nsdae_h5 *h5, const char *path, int needed, int length, double **values)
{
  void *block = NULL;
  if (!needed && !nsdae_h5_has(h5, path)) return NSDAE_OK;
  int status = allocate_vector(h5, path, length, sizeof **values, &block);
  if (status < 0) return status;
  *values = block;
  status = nsdae_h5_read(h5, path, *values);
  for (int i = 0; i < length && status == NSDAE_OK; i++)
    if (!isfinite((*values)[i]))
      status = nsdae_h5_refuse(h5, "%s[%d] is %g, must be finite", path, i, (*values)[i]);
  return status;
}

int nsdae_h5_take_ints(nsdae_h5 *h5, const char *path, int needed, int length, int **values)
{
  void *block = NULL;
  if (!needed && !nsdae_h5_has(h5, path)) return NSDAE_OK;
  int status = allocate_vector(h5, path, length, sizeof **values, &block);
  if (status < 0) return status;
  *values = block;
  return nsdae_h5_read_as(h5, path, H5T_NATIVE_INT, *values);
}

/* One integer of the group, in [least, most]. */
static int read_size(nsdae_h5 *h5, const char *group, const char *name, int least, int most,
                     int *value)
{
  char path[NAME];
  int *one = NULL;
  snprintf(path, sizeof path, "%s/%s", group, name);
  int status = nsdae_h5_take_ints(h5, path, 1, 1, &one);
  if (status == NSDAE_OK) {
    *value = one[0];
    if (*value < least || *value > most)
      status = nsdae_h5_refuse(h5, "%s is %d, must be in [%d, %d]", path, *value, least, most);
  }
  free(one);
  return status;
}

static void path_of(char path[NAME], const char *group, const char *name)
{
  snprintf(path, NAME, "%s/%s", group, name);
}

/* ---- compressed matrices */

/* Pointers of a compressed form: from zero, not decreasing. */
static int check_pointers(nsdae_h5 *h5, const char *group, int count, const int *p)
{
  if (p[0] != 0) return nsdae_h5_refuse(h5, "%s/p[0] is %d, must be 0", group, p[0]);
  for (int j = 0; j < count; j++)
    if (p[j + 1] < p[j])
      return nsdae_h5_refuse(h5, "%s/p[%d] = %d is below p[%d] = %d", group, j + 1, p[j + 1], j,
                             p[j]);
  return NSDAE_OK;
}

/* Of the n + 1 pointers of a compressed form, the index of each of its entries. */
static int expand(nsdae_h5 *h5, const char *group, int n, int **index, int *count)
{
  char path[NAME];
  int *p = NULL;
  path_of(path, group, "p");
  int status = nsdae_h5_take_ints(h5, path, 1, n + 1, &p);
  if (status == NSDAE_OK) status = check_pointers(h5, group, n, p);
  if (status == NSDAE_OK) {
    *count = p[n];
    *index = malloc(((size_t)p[n] + 1) * sizeof **index);
    if (!*index) status = no_memory_for(h5, (size_t)p[n]);
  }
  for (int j = 0; j < n && status == NSDAE_OK; j++)
    for (int k = p[j]; k < p[j + 1]; k++) (*index)[k] = j;
  free(p);
  return status;
}

/* The length of i and x, which may be longer than what is used of them. */
static int stored(nsdae_h5 *h5, const char *group, const char *name, int *length)
{
  char path[NAME];
  path_of(path, group, name);
  int status = nsdae_h5_length(h5, path, INT_MAX, length);
  return status == NSDAE_OK && *length < 0 ? nsdae_h5_refuse(h5, "%s is missing", path) : status;
}

static int read_used(nsdae_h5 *h5, const char *group, nsdae_triplets *t, int **index)
{
  char path[NAME];
  int of_i, of_x;
  int status = stored(h5, group, "i", &of_i);
  if (status == NSDAE_OK) status = stored(h5, group, "x", &of_x);
  if (status < 0) return status;
  if (of_i < t->count || of_x < t->count)
    return nsdae_h5_refuse(h5, "%s has %d entries, but %d indices and %d values", group, t->count,
                           of_i, of_x);
  path_of(path, group, "i");
  status = nsdae_h5_take_ints(h5, path, 1, of_i, index);
  path_of(path, group, "x");
  return status < 0 ? status : nsdae_h5_take_reals(h5, path, 1, of_x, &t->value);
}

static int check_indices(nsdae_h5 *h5, const char *group, const nsdae_triplets *t)
{
  for (int k = 0; k < t->count; k++)
    if (t->row[k] < 0 || t->row[k] >= t->rows || t->column[k] < 0 || t->column[k] >= t->columns)
      return nsdae_h5_refuse(h5, "%s: entry %d is at (%d, %d) of %d x %d", group, k, t->row[k],
                             t->column[k], t->rows, t->columns);
  return NSDAE_OK;
}

/* Triplets: p has the columns; it must be as long as they are many. */
static int read_columns(nsdae_h5 *h5, const char *group, nsdae_triplets *t)
{
  char path[NAME];
  int length;
  int status = stored(h5, group, "p", &length);
  if (status < 0) return status;
  if (length < t->count)
    return nsdae_h5_refuse(h5, "%s has %d entries, but %d columns of them", group, t->count,
                           length);
  path_of(path, group, "p");
  return nsdae_h5_take_ints(h5, path, 1, length, &t->column);
}

/* ---- reading */

int nsdae_triplets_read(nsdae_h5 *h5, const char *group, nsdae_triplets *t)
{
  int form = ROWS;
  *t = (nsdae_triplets){0};
  int status = read_size(h5, group, "m", 0, INT_MAX / 2, &t->rows);
  if (status == NSDAE_OK) status = read_size(h5, group, "n", 0, INT_MAX / 2, &t->columns);
  if (status == NSDAE_OK) status = read_size(h5, group, "nz", ROWS, INT_MAX - 1, &form);
  if (status < 0) return status;
  t->count = form;
  if (form == COLUMNS)
    status = expand(h5, group, t->columns, &t->column, &t->count);
  else if (form == ROWS)
    status = expand(h5, group, t->rows, &t->row, &t->count);
  else
    status = read_columns(h5, group, t);
  if (status == NSDAE_OK) status = read_used(h5, group, t, form == ROWS ? &t->column : &t->row);
  if (status == NSDAE_OK) status = check_indices(h5, group, t);
  if (status < 0) nsdae_triplets_release(t);
  return status;
}

/* ---- building and writing */

int nsdae_triplets_grow(nsdae_h5 *h5, nsdae_triplets *t, int count)
{
  if (count > INT_MAX - t->count)
    return nsdae_h5_refuse(h5, "more than %d entries in its matrices", INT_MAX);
  size_t room = (size_t)t->count + (size_t)count + 1;
  int *row = realloc(t->row, room * sizeof *row);
  if (row) t->row = row;
  int *column = realloc(t->column, room * sizeof *column);
  if (column) t->column = column;
  double *value = realloc(t->value, room * sizeof *value);
  if (value) t->value = value;
  return row && column && value ? NSDAE_OK : no_memory_for(h5, room);
}

void nsdae_triplets_add(nsdae_triplets *t, int row, int column, double value)
{
  t->row[t->count] = row;
  t->column[t->count] = column;
  t->value[t->count++] = value;
}

void nsdae_triplets_release(nsdae_triplets *t)
{
  free(t->row);
  free(t->column);
  free(t->value);
  *t = (nsdae_triplets){0};
}

static int write_part(nsdae_h5 *h5, const char *group, const char *name, hid_t type, int count,
                      const void *values)
{
  char path[NAME];
  path_of(path, group, name);
  return nsdae_h5_vector(h5, path, type, (hsize_t)count, values, "1", "see FCLIB");
}

int nsdae_triplets_write(nsdae_h5 *h5, const char *group, const nsdae_triplets *t)
{
  int status = write_part(h5, group, "m", H5T_NATIVE_INT, 1, &t->rows);
  if (status == NSDAE_OK) status = write_part(h5, group, "n", H5T_NATIVE_INT, 1, &t->columns);
  if (status == NSDAE_OK) status = write_part(h5, group, "nz", H5T_NATIVE_INT, 1, &t->count);
  if (status == NSDAE_OK) status = write_part(h5, group, "nzmax", H5T_NATIVE_INT, 1, &t->count);
  if (status == NSDAE_OK) status = write_part(h5, group, "p", H5T_NATIVE_INT, t->count, t->column);
  if (status == NSDAE_OK) status = write_part(h5, group, "i", H5T_NATIVE_INT, t->count, t->row);
  if (status < 0) return status;
  return write_part(h5, group, "x", H5T_NATIVE_DOUBLE, t->count, t->value);
}
