#include "hdf5_file.h"

#include <errno.h>
#include <hdf5_hl.h>
#include <stdio.h>
#include <string.h>

#include "errors.h"

enum { RANK_MAX = 3 };

/* Keeps the innermost message of HDF5's stack. */
static herr_t innermost(unsigned n, const H5E_error2_t *entry, void *user)
{
  if (n == 0 && entry->desc) snprintf(user, 200, "%s", entry->desc);
  return 0;
}

/* HDF5's reason for what failed just now: the next call clears its stack. */
static void reason(char text[200])
{
  strcpy(text, "unknown reason");
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, innermost, text);
}

static int because(nsdae_h5 *h5, const char *what, const char *why)
{
  int status = h5->disk.failure == ENOMEM ? NSDAE_E_MEMORY : NSDAE_E_IO;
  return nsdae_error_set(h5->error, status, h5->where ? h5->where : "nsdae_trajectory", "path",
                         "cannot %s '%.90s': %.120s", what, h5->path, why);
}

/* To be called right after the failed call. */
static int failed(nsdae_h5 *h5, const char *what)
{
  char text[200];
  reason(text);
  int failure = h5->disk.failure;
  return because(h5, what, failure ? nsdae_ordered_words(failure) : text);
}

static int result(nsdae_h5 *h5, long code, const char *what)
{
  return code < 0 ? failed(h5, what) : NSDAE_OK;
}

/* HDF5 does not see that a write failed: the disk knows. */
static int arrived(nsdae_h5 *h5, long code, const char *what)
{
  return code < 0 || h5->disk.failure ? failed(h5, what) : NSDAE_OK;
}

/* The driver under the file, then HDF5 on top of it. */
static hid_t open_disk(nsdae_h5 *h5, nsdae_ordered_mode mode)
{
  h5->file = -1;
  h5->disk.failure = nsdae_ordered_open(&h5->disk, h5->path, mode);
  return h5->disk.failure ? -1 : nsdae_ordered_access(&h5->disk);
}

static int opened(nsdae_h5 *h5, hid_t access, const char *what)
{
  int status = result(h5, h5->file, what);
  if (access >= 0) H5Pclose(access);
  if (status < 0) nsdae_ordered_close(&h5->disk);
  return status;
}

int nsdae_h5_create(nsdae_h5 *h5, int latest)
{
  hid_t access = open_disk(h5, NSDAE_ORDERED_REPLACE);
  if (latest) H5Pset_libver_bounds(access, H5F_LIBVER_LATEST, H5F_LIBVER_LATEST);
  if (access >= 0) h5->file = H5Fcreate(h5->path, H5F_ACC_TRUNC, H5P_DEFAULT, access);
  return opened(h5, access, "write");
}

int nsdae_h5_reopen(nsdae_h5 *h5)
{
  hid_t access = open_disk(h5, NSDAE_ORDERED_UPDATE);
  if (access >= 0) h5->file = H5Fopen(h5->path, H5F_ACC_RDWR, access);
  h5->disk.committed = h5->disk.eoa; /* the file may be longer than what it refers to */
  return opened(h5, access, "open");
}

int nsdae_h5_open(nsdae_h5 *h5)
{
  hid_t access = open_disk(h5, NSDAE_ORDERED_READ);
  if (access >= 0) h5->file = H5Fopen(h5->path, H5F_ACC_RDONLY, access);
  return opened(h5, access, "read");
}

int nsdae_h5_prepare(nsdae_h5 *h5, long bytes)
{
  int failure = nsdae_ordered_check(&h5->disk);
  if (failure == 0) failure = nsdae_ordered_reserve(&h5->disk, (uint64_t)bytes);
  return failure ? because(h5, "write to", nsdae_ordered_words(failure)) : NSDAE_OK;
}

int nsdae_h5_flush(nsdae_h5 *h5)
{
  h5->disk.unready = 0;
  return arrived(h5, H5Fflush(h5->file, H5F_SCOPE_LOCAL), "write to");
}

int nsdae_h5_close(nsdae_h5 *h5)
{
  int status = h5->file < 0 ? NSDAE_OK : arrived(h5, H5Fclose(h5->file), "close");
  h5->file = -1;
  if (h5->disk.path && nsdae_ordered_close(&h5->disk) != 0 && status == NSDAE_OK)
    status = failed(h5, "close");
  return status;
}

int nsdae_h5_start_swmr(nsdae_h5 *h5)
{
  int status = nsdae_h5_flush(h5);
  h5->disk.direct = 1;
  return status < 0 ? status : arrived(h5, H5Fstart_swmr_write(h5->file), "let readers into");
}

int nsdae_h5_group(nsdae_h5 *h5, const char *name)
{
  hid_t group = H5Gcreate2(h5->file, name, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
  int status = result(h5, group, "make a group in");
  if (group >= 0) H5Gclose(group);
  return status;
}

static hid_t text_type(void)
{
  hid_t type = H5Tcopy(H5T_C_S1);
  H5Tset_size(type, H5T_VARIABLE);
  H5Tset_cset(type, H5T_CSET_UTF8);
  return type;
}

static int set_attribute(nsdae_h5 *h5, hid_t object, const char *name, hid_t type,
                         const void *value)
{
  hid_t attribute;
  if (H5Aexists(object, name) > 0) {
    attribute = H5Aopen(object, name, H5P_DEFAULT);
  } else {
    hid_t space = H5Screate(H5S_SCALAR);
    attribute = H5Acreate2(object, name, type, space, H5P_DEFAULT, H5P_DEFAULT);
    H5Sclose(space);
  }
  int status = result(h5, attribute, "make an attribute in");
  if (status < 0) return status;
  status = result(h5, H5Awrite(attribute, type, value), "write an attribute in");
  H5Aclose(attribute);
  return status;
}

int nsdae_h5_set_text(nsdae_h5 *h5, hid_t object, const char *name, const char *text)
{
  hid_t type = text_type();
  int status = set_attribute(h5, object, name, type, &text);
  H5Tclose(type);
  return status;
}

int nsdae_h5_set_int(nsdae_h5 *h5, hid_t object, const char *name, int value)
{
  return set_attribute(h5, object, name, H5T_NATIVE_INT, &value);
}

int nsdae_h5_set_real(nsdae_h5 *h5, hid_t object, const char *name, double value)
{
  return set_attribute(h5, object, name, H5T_NATIVE_DOUBLE, &value);
}

int nsdae_h5_get_real(nsdae_h5 *h5, hid_t object, const char *name, double *value)
{
  if (H5Aexists(object, name) <= 0) return NSDAE_OK;
  hid_t attribute = H5Aopen(object, name, H5P_DEFAULT);
  int status = result(h5, attribute, "read an attribute of");
  if (status < 0) return status;
  hid_t space = H5Aget_space(attribute);
  hssize_t count = H5Sget_simple_extent_npoints(space);
  H5Sclose(space);
  if (count == 1)
    status = result(h5, H5Aread(attribute, H5T_NATIVE_DOUBLE, value), "read an attribute of");
  H5Aclose(attribute);
  return status;
}

int nsdae_h5_describe(nsdae_h5 *h5, hid_t series, const char *units, const char *description)
{
  int status = nsdae_h5_set_text(h5, series, "units", units);
  return status < 0 ? status : nsdae_h5_set_text(h5, series, "description", description);
}

static int write_whole(nsdae_h5 *h5, const char *path, hid_t type, hid_t space, const void *value,
                       const char *units, const char *description)
{
  hid_t links = H5Pcreate(H5P_LINK_CREATE);
  H5Pset_create_intermediate_group(links, 1);
  hid_t set = H5Dcreate2(h5->file, path, type, space, links, H5P_DEFAULT, H5P_DEFAULT);
  int status = result(h5, set, "make a dataset in");
  H5Pclose(links);
  if (status < 0) return status;
  status = result(h5, H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, value), "write to");
  if (status == NSDAE_OK) status = nsdae_h5_describe(h5, set, units, description);
  H5Dclose(set);
  return status;
}

static int write_typed(nsdae_h5 *h5, const char *path, hid_t type, hid_t space, const void *value,
                       const char *units, const char *description)
{
  hid_t own = type == H5T_C_S1 ? text_type() : H5Tcopy(type);
  int status = write_whole(h5, path, own, space, value, units, description);
  H5Tclose(own);
  H5Sclose(space);
  return status;
}

int nsdae_h5_scalar(nsdae_h5 *h5, const char *path, hid_t type, const void *value,
                    const char *units, const char *description)
{
  const void *at = type == H5T_C_S1 ? (const void *)&value : value;
  return write_typed(h5, path, type, H5Screate(H5S_SCALAR), at, units, description);
}

int nsdae_h5_vector(nsdae_h5 *h5, const char *path, hid_t type, hsize_t n, const void *values,
                    const char *units, const char *description)
{
  return write_typed(h5, path, type, H5Screate_simple(1, &n, NULL), values, units, description);
}

int nsdae_h5_matrix(nsdae_h5 *h5, const char *path, hsize_t n, hsize_t columns, const double *rows,
                    const char *units, const char *description)
{
  const hsize_t size[2] = {n, columns};
  return write_typed(h5, path, H5T_NATIVE_DOUBLE, H5Screate_simple(2, size, NULL), rows, units,
                     description);
}

/* "cannot read 'file': ..." with what is wrong with one of its datasets. */
static int unfit(nsdae_h5 *h5, const char *path, const char *wrong)
{
  return nsdae_error_set(h5->error, NSDAE_E_IO, h5->where, "path",
                         "cannot read '%.90s': dataset %s %s", h5->path, path, wrong);
}

int nsdae_h5_shape(nsdae_h5 *h5, const char *path, int rank, hsize_t *length)
{
  hid_t set = H5Dopen2(h5->file, path, H5P_DEFAULT);
  if (set < 0) return unfit(h5, path, "is missing");
  hid_t space = H5Dget_space(set);
  int found = H5Sget_simple_extent_ndims(space);
  if (found == rank) H5Sget_simple_extent_dims(space, length, NULL);
  H5Sclose(space);
  H5Dclose(set);
  if (found == rank) return NSDAE_OK;
  return unfit(h5, path, rank == 1 ? "is not a vector" : "is not a matrix");
}

int nsdae_h5_read(nsdae_h5 *h5, const char *path, double *values)
{
  hid_t set = H5Dopen2(h5->file, path, H5P_DEFAULT);
  int status = result(h5, set, "read");
  if (status < 0) return status;
  status =
      result(h5, H5Dread(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values), "read");
  H5Dclose(set);
  return status;
}

/* Rows come in bunches already; so they go to the file at once, themselves alone and not the chunk
 * around them, and their space is taken when they are written. */
static hid_t uncached(void)
{
  hid_t access = H5Pcreate(H5P_DATASET_ACCESS);
  H5Pset_chunk_cache(access, 1, 0, H5D_CHUNK_CACHE_W0_DEFAULT);
  return access;
}

int nsdae_h5_series(nsdae_h5 *h5, const char *path, hid_t type, const hsize_t *width, int rank,
                    hsize_t chunk, hid_t *series)
{
  hsize_t now[RANK_MAX] = {0}, most[RANK_MAX] = {H5S_UNLIMITED}, chunks[RANK_MAX] = {chunk};
  for (int i = 1; i < rank; i++) now[i] = most[i] = chunks[i] = width[i - 1];
  hid_t space = H5Screate_simple(rank, now, most), layout = H5Pcreate(H5P_DATASET_CREATE);
  hid_t access = uncached();
  H5Pset_chunk(layout, rank, chunks);
  *series = H5Dcreate2(h5->file, path, type, space, H5P_DEFAULT, layout, access);
  int status = result(h5, *series, "make a dataset in");
  H5Pclose(access);
  H5Pclose(layout);
  H5Sclose(space);
  return status;
}

int nsdae_h5_make_scale(nsdae_h5 *h5, hid_t series, const char *name)
{
  return result(h5, H5DSset_scale(series, name), "make a dimension scale in");
}

int nsdae_h5_attach_scale(nsdae_h5 *h5, hid_t series, hid_t scale)
{
  return result(h5, H5DSattach_scale(series, scale, 0), "attach a dimension scale in");
}

int nsdae_h5_append(nsdae_h5 *h5, hid_t series, hid_t type, hsize_t from, hsize_t count,
                    const void *rows)
{
  hsize_t size[RANK_MAX], start[RANK_MAX] = {from};
  hid_t file_space = H5Dget_space(series);
  int rank = H5Sget_simple_extent_dims(file_space, size, NULL);
  H5Sclose(file_space);
  size[0] = from + count;
  int status = result(h5, H5Dset_extent(series, size), "write to");
  if (status < 0) return status;
  size[0] = count;
  file_space = H5Dget_space(series);
  hid_t memory = H5Screate_simple(rank, size, NULL);
  H5Sselect_hyperslab(file_space, H5S_SELECT_SET, start, NULL, size, NULL);
  status = result(h5, H5Dwrite(series, type, memory, file_space, H5P_DEFAULT, rows), "write to");
  H5Sclose(memory);
  H5Sclose(file_space);
  return status;
}
