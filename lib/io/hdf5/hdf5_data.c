#include "hdf5_data.h"

#include <hdf5_hl.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

const char *nsdae_h5_join(char path[NSDAE_H5_PATH], const char *group, const char *name)
{
  snprintf(path, NSDAE_H5_PATH, "%s/%s", group, name);
  return path;
}

int nsdae_h5_group(nsdae_h5 *h5, const char *name)
{
  if (h5->status < 0) return h5->status;
  hid_t group = H5Gcreate2(h5->file, name, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
  nsdae_h5_result(h5, group, "make a group in");
  if (group >= 0) H5Gclose(group);
  return h5->status;
}

/* ---- attributes */

/* < 0 if it cannot be made: another size would take the texts' addresses for their letters. */
static hid_t text_type(void)
{
  hid_t type = H5Tcopy(H5T_C_S1);
  if (H5Tset_size(type, H5T_VARIABLE) >= 0 && H5Tset_cset(type, H5T_CSET_UTF8) >= 0) return type;
  H5Tclose(type);
  return -1;
}

static int set_attribute(nsdae_h5 *h5, hid_t object, const char *name, hid_t type,
                         const void *value)
{
  hid_t attribute;
  if (h5->status < 0) return h5->status;
  if (H5Aexists(object, name) > 0) {
    attribute = H5Aopen(object, name, H5P_DEFAULT);
  } else {
    hid_t space = H5Screate(H5S_SCALAR);
    attribute = H5Acreate2(object, name, type, space, H5P_DEFAULT, H5P_DEFAULT);
    H5Sclose(space);
  }
  if (nsdae_h5_result(h5, attribute, "make an attribute in") < 0) return h5->status;
  nsdae_h5_result(h5, H5Awrite(attribute, type, value), "write an attribute in");
  H5Aclose(attribute);
  return h5->status;
}

/* A text that is replaced is deleted first: then it stays in its heap, as long as the file on disk
 * refers to it. HDF5 1.14 removes one that is written over from the heap. */
int nsdae_h5_set_text(nsdae_h5 *h5, hid_t object, const char *name, const char *text)
{
  hid_t type = text_type();
  if (h5->status >= 0 && H5Aexists(object, name) > 0)
    nsdae_h5_result(h5, H5Adelete(object, name), "replace an attribute in");
  set_attribute(h5, object, name, type, &text);
  H5Tclose(type);
  return h5->status;
}

int nsdae_h5_set_int(nsdae_h5 *h5, hid_t object, const char *name, int value)
{
  return set_attribute(h5, object, name, H5T_NATIVE_INT, &value);
}

void nsdae_h5_set_origin(nsdae_h5 *h5, double time, long step, double tol, const char *method)
{
  set_attribute(h5, h5->file, "time", H5T_NATIVE_DOUBLE, &time);
  nsdae_h5_set_int(h5, h5->file, "step", (int)step);
  set_attribute(h5, h5->file, "tol", H5T_NATIVE_DOUBLE, &tol);
  if (method) nsdae_h5_set_text(h5, h5->file, "method", method);
}

/* ---- datasets */

/* Rows come in bunches already; so they go to the file at once, themselves alone and not the chunk
 * around them, and their space is taken when they are written. */
static hid_t uncached(void)
{
  hid_t access = H5Pcreate(H5P_DATASET_ACCESS);
  H5Pset_chunk_cache(access, 1, 0, H5D_CHUNK_CACHE_W0_DEFAULT);
  return access;
}

hid_t nsdae_h5_dataset(nsdae_h5 *h5, const char *path, hid_t type, const nsdae_h5_layout *layout,
                       const char *units, const char *description)
{
  if (h5->status < 0) return -1;
  hid_t links = H5Pcreate(H5P_LINK_CREATE), storage = H5Pcreate(H5P_DATASET_CREATE);
  hid_t space = H5Screate_simple(layout->rank, layout->size, layout->most), access = uncached();
  H5Pset_create_intermediate_group(links, 1);
  if (layout->chunk[0] > 0) H5Pset_chunk(storage, layout->rank, layout->chunk);
  if (layout->early) H5Pset_alloc_time(storage, H5D_ALLOC_TIME_EARLY);
  if (layout->deflate > 0) {
    H5Pset_shuffle(storage);
    H5Pset_deflate(storage, (unsigned)layout->deflate);
  }
  hid_t set = H5Dcreate2(h5->file, path, type, space, links, storage, access);
  nsdae_h5_result(h5, set, "make a dataset in");
  H5Sclose(space);
  H5Pclose(access);
  H5Pclose(storage);
  H5Pclose(links);
  nsdae_h5_set_text(h5, set, "units", units);
  nsdae_h5_set_text(h5, set, "description", description);
  return set;
}

hid_t nsdae_h5_open_dataset(nsdae_h5 *h5, const char *path)
{
  if (h5->status < 0) return -1;
  hid_t access = uncached(), set = H5Dopen2(h5->file, path, access);
  nsdae_h5_result(h5, set, "open a dataset of");
  H5Pclose(access);
  return set;
}

int nsdae_h5_array(nsdae_h5 *h5, const char *path, hid_t type, int rank, const hsize_t *size,
                   const void *values, const char *units, const char *description)
{
  hid_t own = type == H5T_C_S1 ? text_type() : type;
  nsdae_h5_layout layout = {.rank = rank};
  for (int i = 0; i < rank; i++) layout.size[i] = layout.most[i] = size[i];
  hid_t set = nsdae_h5_dataset(h5, path, own, &layout, units, description);
  if (h5->status == NSDAE_OK)
    nsdae_h5_result(h5, H5Dwrite(set, own, H5S_ALL, H5S_ALL, H5P_DEFAULT, values), "write to");
  if (set >= 0) H5Dclose(set);
  if (own != type) H5Tclose(own);
  return h5->status;
}

int nsdae_h5_vector(nsdae_h5 *h5, const char *path, hid_t type, hsize_t n, const void *values,
                    const char *units, const char *description)
{
  return nsdae_h5_array(h5, path, type, 1, &n, values, units, description);
}

int nsdae_h5_make_scale(nsdae_h5 *h5, hid_t set, const char *name)
{
  if (h5->status < 0) return h5->status;
  return nsdae_h5_result(h5, H5DSset_scale(set, name), "make a dimension scale in");
}

int nsdae_h5_attach_scale(nsdae_h5 *h5, hid_t set, hid_t scale, int dimension)
{
  if (h5->status < 0) return h5->status;
  return nsdae_h5_result(h5, H5DSattach_scale(set, scale, (unsigned)dimension),
                         "attach a dimension scale in");
}

/* ---- rows */

/* The rank of a dataset, and its lengths. */
static int extent(nsdae_h5 *h5, hid_t set, hsize_t size[NSDAE_H5_RANK])
{
  hid_t space = H5Dget_space(set);
  int rank = H5Sget_simple_extent_dims(space, size, NULL);
  nsdae_h5_result(h5, rank, "read the size of");
  H5Sclose(space);
  return rank;
}

int nsdae_h5_resize(nsdae_h5 *h5, hid_t set, const hsize_t *size)
{
  if (h5->status < 0) return h5->status;
  return nsdae_h5_result(h5, H5Dset_extent(set, size), "write to");
}

int nsdae_h5_cut(nsdae_h5 *h5, hid_t set, hsize_t rows)
{
  hsize_t size[NSDAE_H5_RANK] = {0};
  if (h5->status < 0 || extent(h5, set, size) < 0 || size[0] <= rows) return h5->status;
  size[0] = rows;
  return nsdae_h5_result(h5, H5Dset_extent(set, size), "shorten");
}

int nsdae_h5_write_part(nsdae_h5 *h5, hid_t set, hid_t type, int rank, const hsize_t *start,
                        const hsize_t *size, const void *values)
{
  if (h5->status < 0) return h5->status;
  hid_t file = H5Dget_space(set), memory = H5Screate_simple(rank, size, NULL);
  H5Sselect_hyperslab(file, H5S_SELECT_SET, start, NULL, size, NULL);
  nsdae_h5_result(h5, H5Dwrite(set, type, memory, file, H5P_DEFAULT, values), "write to");
  H5Sclose(memory);
  H5Sclose(file);
  return h5->status;
}

int nsdae_h5_append(nsdae_h5 *h5, hid_t set, hid_t type, hsize_t from, hsize_t count,
                    const void *rows)
{
  hsize_t size[NSDAE_H5_RANK] = {0}, start[NSDAE_H5_RANK] = {from};
  int rank = h5->status < 0 ? -1 : extent(h5, set, size);
  if (rank >= 0 && size[0] < from + count) {
    size[0] = from + count;
    nsdae_h5_resize(h5, set, size);
  }
  size[0] = count;
  return nsdae_h5_write_part(h5, set, type, rank, start, size, rows);
}

/* ---- reading */

int nsdae_h5_has(nsdae_h5 *h5, const char *path)
{
  return H5LTpath_valid(h5->file, path, 0) > 0;
}

/* Whether it is one of numbers, of at most 16 bytes. */
static int is_number(hid_t type)
{
  H5T_class_t kind = H5Tget_class(type);
  size_t size = H5Tget_size(type);
  return (kind == H5T_FLOAT || kind == H5T_INTEGER) && size > 0 && size <= 16;
}

int nsdae_h5_shape(nsdae_h5 *h5, const char *path, int rank, hsize_t *length)
{
  if (h5->status < 0) return h5->status;
  hid_t set = H5Dopen2(h5->file, path, H5P_DEFAULT);
  if (set < 0) return nsdae_h5_refuse(h5, "read", "dataset %s is missing", path);
  hid_t space = H5Dget_space(set), type = H5Dget_type(set);
  int found = H5Sget_simple_extent_ndims(space);
  const char *wrong = NULL;
  if (!is_number(type))
    wrong = "is not of numbers";
  else if (found != rank)
    wrong = rank == 1 ? "is not a vector" : rank == 2 ? "is not a matrix" : "has another shape";
  else if (H5Sget_simple_extent_dims(space, length, NULL) < 0)
    wrong = "has a shape that cannot be read";
  H5Sclose(space);
  H5Tclose(type);
  H5Dclose(set);
  return wrong ? nsdae_h5_refuse(h5, "read", "dataset %s %s", path, wrong) : NSDAE_OK;
}

int nsdae_h5_read(nsdae_h5 *h5, const char *path, hid_t type, void *values)
{
  if (h5->status < 0) return h5->status;
  hid_t set = H5Dopen2(h5->file, path, H5P_DEFAULT);
  if (nsdae_h5_result(h5, set, "read") < 0) return h5->status;
  nsdae_h5_result(h5, H5Dread(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values), "read");
  H5Dclose(set);
  return h5->status;
}

double nsdae_h5_get_real(nsdae_h5 *h5, hid_t object, const char *name)
{
  static const char what[] = "read an attribute of";
  double value = 0;
  if (h5->status < 0 || H5Aexists(object, name) <= 0) return 0;
  hid_t attribute = H5Aopen(object, name, H5P_DEFAULT);
  if (nsdae_h5_result(h5, attribute, what) < 0) return 0;
  hid_t space = H5Aget_space(attribute), type = H5Aget_type(attribute);
  if (H5Sget_simple_extent_npoints(space) == 1 && is_number(type))
    nsdae_h5_result(h5, H5Aread(attribute, H5T_NATIVE_DOUBLE, &value), what);
  H5Tclose(type);
  H5Sclose(space);
  H5Aclose(attribute);
  return value;
}

/* ---- vectors */

int nsdae_h5_length(nsdae_h5 *h5, const char *group, const char *name, long most)
{
  char path[NSDAE_H5_PATH];
  hsize_t found = 0;
  nsdae_h5_join(path, group, name);
  if (h5->status < 0 || !nsdae_h5_has(h5, path) || nsdae_h5_shape(h5, path, 1, &found) < 0)
    return -1;
  if (found <= (hsize_t)most) return (int)found;
  nsdae_h5_refuse(h5, "read", "%s has %llu numbers, at most %ld are read", path,
                  (unsigned long long)found, most);
  return -1;
}

static void *take(nsdae_h5 *h5, const char *group, const char *name, int needed, int *length,
                  hid_t type, size_t size)
{
  char path[NSDAE_H5_PATH];
  int found = nsdae_h5_length(h5, group, name, INT_MAX);
  nsdae_h5_join(path, group, name);
  if (found < 0) {
    if (needed) nsdae_h5_refuse(h5, "read", "%s is missing", path);
    return NULL;
  }
  if (*length >= 0 && found != *length)
    nsdae_h5_refuse(h5, "read", "%s has %d numbers, must be %d", path, found, *length);
  *length = found;
  void *values = nsdae_h5_allocate(h5, (size_t)found, size);
  nsdae_h5_read(h5, path, type, values);
  return values;
}

int *nsdae_h5_take_ints(nsdae_h5 *h5, const char *group, const char *name, int needed, int *length)
{
  return take(h5, group, name, needed, length, H5T_NATIVE_INT, sizeof(int));
}

double *nsdae_h5_take_reals(nsdae_h5 *h5, const char *group, const char *name, int needed,
                            int *length)
{
  double *value = take(h5, group, name, needed, length, H5T_NATIVE_DOUBLE, sizeof *value);
  for (int i = 0; value && i < *length && h5->status == NSDAE_OK; i++)
    if (!isfinite(value[i]))
      nsdae_h5_refuse(h5, "read", "%s/%s[%d] is %g, must be finite", group, name, i, value[i]);
  return value;
}

int nsdae_h5_take_int(nsdae_h5 *h5, const char *group, const char *name, int least, int most)
{
  int one = 1, *read = nsdae_h5_take_ints(h5, group, name, NSDAE_H5_NEEDED, &one);
  int value = h5->status < 0 ? 0 : *read;
  free(read);
  if (value < least || value > most)
    nsdae_h5_refuse(h5, "read", "%s/%s is %d, must be in [%d, %d]", group, name, value, least,
                    most);
  return value;
}
