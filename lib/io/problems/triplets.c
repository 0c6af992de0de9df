#include "to_blocks.h"

#include <limits.h>
#include <stdlib.h>

#include "arena.h"

enum { COLUMNS = -1, ROWS = -2 }; /* values of nz */

/* ---- reading */

/* Pointers of a compressed form: from zero, not decreasing. */
static int check_pointers(nsdae_h5 *h5, const char *group, int count, const int *p)
{
  if (h5->status == NSDAE_OK && p[0] != 0)
    nsdae_h5_refuse(h5, "read", "%s/p[0] is %d, must be 0", group, p[0]);
  for (int j = 0; j < count && h5->status == NSDAE_OK; j++)
    if (p[j + 1] < p[j])
      nsdae_h5_refuse(h5, "read", "%s/p[%d] = %d is below p[%d] = %d", group, j + 1, p[j + 1], j,
                      p[j]);
  return h5->status;
}

static int check_count(nsdae_h5 *h5, const char *group, int count, int there, const char *what)
{
  if (there < count)
    nsdae_h5_refuse(h5, "read", "%s has %d entries, but %d %s", group, count, there, what);
  return h5->status;
}

/* Of the n + 1 pointers of a compressed form, the index of each of its entries. */
static int *expand(nsdae_h5 *h5, const char *group, int n, int there, int *count)
{
  int pointers = n + 1, *index = NULL;
  int *p = nsdae_h5_take_ints(h5, group, "p", NSDAE_H5_NEEDED, &pointers);
  if (check_pointers(h5, group, n, p) == NSDAE_OK &&
      check_count(h5, group, p[n], there, "indices and values") == NSDAE_OK) {
    *count = p[n];
    index = nsdae_h5_allocate(h5, (size_t)p[n], sizeof *index);
  }
  for (int j = 0; index && j < n; j++)
    for (int k = p[j]; k < p[j + 1]; k++) index[k] = j;
  free(p);
  return index;
}

/* Triplets: p has the columns; it must be as long as they are many. */
static int *read_columns(nsdae_h5 *h5, const char *group, int count, int there)
{
  int length = -1;
  int *column = nsdae_h5_take_ints(h5, group, "p", NSDAE_H5_NEEDED, &length);
  check_count(h5, group, count, there, "indices and values");
  check_count(h5, group, count, length, "columns of them");
  return column;
}

void nsdae_triplets_read(nsdae_h5 *h5, const char *root, const char *name, int needed,
                         nsdae_triplets *t)
{
  char group[NSDAE_H5_PATH];
  nsdae_h5_join(group, root, name);
  *t = (nsdae_triplets){0};
  if (h5->status < 0 || (!needed && !nsdae_h5_has(h5, group))) return;
  t->rows = nsdae_h5_take_int(h5, group, "m", 0, INT_MAX / 2);
  t->columns = nsdae_h5_take_int(h5, group, "n", 0, INT_MAX / 2);
  int form = nsdae_h5_take_int(h5, group, "nz", ROWS, INT_MAX - 1);
  /* i and x, which may be longer than what is used of them; i into index. Returns how many there
   * are of both. */
  int **index = form == ROWS ? &t->column : &t->row;
  int of_i = -1, of_x = -1;
  *index = nsdae_h5_take_ints(h5, group, "i", NSDAE_H5_NEEDED, &of_i);
  t->value = nsdae_h5_take_reals(h5, group, "x", NSDAE_H5_NEEDED, &of_x);
  int there = of_i < of_x ? of_i : of_x;
  t->count = form > 0 ? form : 0;
  if (form == COLUMNS)
    t->column = expand(h5, group, t->columns, there, &t->count);
  else if (form == ROWS)
    t->row = expand(h5, group, t->rows, there, &t->count);
  else
    t->column = read_columns(h5, group, form, there);
  for (int k = 0; k < t->count && h5->status == NSDAE_OK; k++)
    if (t->row[k] < 0 || t->row[k] >= t->rows || t->column[k] < 0 || t->column[k] >= t->columns)
      nsdae_h5_refuse(h5, "read", "%s: entry %d is at (%d, %d) of %d x %d", group, k, t->row[k],
                      t->column[k], t->rows, t->columns);
}

/* ---- building and writing */

int nsdae_triplets_grow(nsdae_h5 *h5, nsdae_triplets *t, int count)
{
  const nsdae_array arrays[] = {NSDAE_ARRAY(t->row, 1), NSDAE_ARRAY(t->column, 1),
                                NSDAE_ARRAY(t->value, 1)};
  if (count > INT_MAX - t->count)
    nsdae_h5_refuse(h5, "read", "more than %d entries in its matrices", INT_MAX);
  size_t room = (size_t)t->count + (size_t)count;
  if (h5->status == NSDAE_OK && nsdae_arrays_grow(arrays, 3, room) < 0) nsdae_h5_no_memory(h5);
  return h5->status;
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

int nsdae_triplets_write(nsdae_h5 *h5, const char *root, const char *name, const nsdae_triplets *t)
{
  const struct {
    const char *name;
    hid_t type;
    int count;
    const void *values;
  } part[] = {{"m", H5T_NATIVE_INT, 1, &t->rows},          {"n", H5T_NATIVE_INT, 1, &t->columns},
              {"nz", H5T_NATIVE_INT, 1, &t->count},        {"nzmax", H5T_NATIVE_INT, 1, &t->count},
              {"p", H5T_NATIVE_INT, t->count, t->column},  {"i", H5T_NATIVE_INT, t->count, t->row},
              {"x", H5T_NATIVE_DOUBLE, t->count, t->value}};
  char group[NSDAE_H5_PATH], path[NSDAE_H5_PATH];
  nsdae_h5_join(group, root, name);
  for (size_t i = 0; i < sizeof part / sizeof *part; i++)
    nsdae_h5_vector(h5, nsdae_h5_join(path, group, part[i].name), part[i].type,
                    (hsize_t)part[i].count, part[i].values, "1", "see FCLIB");
  return h5->status;
}
