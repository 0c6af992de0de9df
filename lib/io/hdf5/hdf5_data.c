#include "hdf5_data.h"

#include <hdf5_hl.h>
#include <stdint.h>

enum { RANK_MAX = 3 };

int nsdae_h5_group(nsdae_h5 *h5, const char *name)
{
  hid_t group = H5Gcreate2(h5->file, name, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
  int status = nsdae_h5_result(h5, group, "make a group in");
  if (group >= 0) H5Gclose(group);
  return status;
}

/* ---- attributes */

/* < 0 where it cannot be made: another size would take the texts' addresses for their letters. */
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
  if (H5Aexists(object, name) > 0) {
    attribute = H5Aopen(object, name, H5P_DEFAULT);
  } else {
    hid_t space = H5Screate(H5S_SCALAR);
    attribute = H5Acreate2(object, name, type, space, H5P_DEFAULT, H5P_DEFAULT);
    H5Sclose(space);
  }
  int status = nsdae_h5_result(h5, attribute, "make an attribute in");
  if (status < 0) return status;
  status = nsdae_h5_result(h5, H5Awrite(attribute, type, value), "write an attribute in");
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

int nsdae_h5_describe(nsdae_h5 *h5, hid_t series, const char *units, const char *description)
{
  int status = nsdae_h5_set_text(h5, series, "units", units);
  return status < 0 ? status : nsdae_h5_set_text(h5, series, "description", description);
}

/* ---- datasets that are written once */

static int write_whole(nsdae_h5 *h5, const char *path, hid_t type, hid_t space, const void *value,
                       const char *units, const char *description)
{
  hid_t links = H5Pcreate(H5P_LINK_CREATE);
  H5Pset_create_intermediate_group(links, 1);
  hid_t set = H5Dcreate2(h5->file, path, type, space, links, H5P_DEFAULT, H5P_DEFAULT);
  int status = nsdae_h5_result(h5, set, "make a dataset in");
  H5Pclose(links);
  if (status < 0) return status;
  status =
      nsdae_h5_result(h5, H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, value), "write to");
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

int nsdae_h5_remove(nsdae_h5 *h5, const char *path)
{
  H5Ldelete(h5->file, path, H5P_DEFAULT); /* fails where there is none */
  return NSDAE_OK;
}

int nsdae_h5_matrix(nsdae_h5 *h5, const char *path, hsize_t n, hsize_t columns, const double *rows,
                    const char *units, const char *description)
{
  const hsize_t size[2] = {n, columns};
  return write_typed(h5, path, H5T_NATIVE_DOUBLE, H5Screate_simple(2, size, NULL), rows, units,
                     description);
}

/* ---- datasets that grow */

/* Rows come in bunches already; so they go to the file at once, themselves alone and not the chunk
 * around them, and their space is taken when they are written. */
static hid_t uncached(void)
{
  hid_t access = H5Pcreate(H5P_DATASET_ACCESS);
  H5Pset_chunk_cache(access, 1, 0, H5D_CHUNK_CACHE_W0_DEFAULT);
  return access;
}

/* Chunks, and their compression. */
static hid_t chunked(int rank, const hsize_t *chunks, int deflate)
{
  hid_t layout = H5Pcreate(H5P_DATASET_CREATE);
  H5Pset_chunk(layout, rank, chunks);
  if (deflate > 0) {
    H5Pset_shuffle(layout);
    H5Pset_deflate(layout, (unsigned)deflate);
  }
  return layout;
}

int nsdae_h5_series(nsdae_h5 *h5, const char *path, hid_t type, const hsize_t *width, int rank,
                    hsize_t chunk, int deflate, hid_t *series)
{
  hsize_t now[RANK_MAX] = {0}, most[RANK_MAX] = {H5S_UNLIMITED}, chunks[RANK_MAX] = {chunk};
  for (int i = 1; i < rank; i++) now[i] = most[i] = chunks[i] = width[i - 1];
  hid_t space = H5Screate_simple(rank, now, most), layout = chunked(rank, chunks, deflate);
  hid_t access = uncached();
  *series = H5Dcreate2(h5->file, path, type, space, H5P_DEFAULT, layout, access);
  int status = nsdae_h5_result(h5, *series, "make a dataset in");
  H5Pclose(access);
  H5Pclose(layout);
  H5Sclose(space);
  return status;
}

int nsdae_h5_make_scale(nsdae_h5 *h5, hid_t series, const char *name)
{
  return nsdae_h5_result(h5, H5DSset_scale(series, name), "make a dimension scale in");
}

int nsdae_h5_attach_scale(nsdae_h5 *h5, hid_t series, hid_t scale, int dimension)
{
  return nsdae_h5_result(h5, H5DSattach_scale(series, scale, (unsigned)dimension),
                         "attach a dimension scale in");
}

int nsdae_h5_open_dataset(nsdae_h5 *h5, const char *path, hid_t *set)
{
  *set = H5Dopen2(h5->file, path, H5P_DEFAULT);
  return nsdae_h5_result(h5, *set, "open a dataset of");
}

int nsdae_h5_open_series(nsdae_h5 *h5, const char *path, hid_t *set)
{
  hid_t access = uncached();
  *set = H5Dopen2(h5->file, path, access);
  H5Pclose(access);
  return nsdae_h5_result(h5, *set, "open a dataset of");
}

/* Its space is taken at once: later only bytes change. */
static hid_t taken_at_once(int grows)
{
  const hsize_t chunk[2] = {1, 1 << 16};
  hid_t layout = H5Pcreate(H5P_DATASET_CREATE);
  if (grows) H5Pset_chunk(layout, 2, chunk);
  H5Pset_alloc_time(layout, H5D_ALLOC_TIME_EARLY);
  return layout;
}

int nsdae_h5_bytes(nsdae_h5 *h5, const char *path, const hsize_t size[2], int grows,
                   const char *description, hid_t *set)
{
  const hsize_t most[2] = {size[0], grows ? H5S_UNLIMITED : size[1]};
  hid_t links = H5Pcreate(H5P_LINK_CREATE), layout = taken_at_once(grows), access = uncached();
  hid_t space = H5Screate_simple(2, size, most);
  H5Pset_create_intermediate_group(links, 1);
  *set = H5Dcreate2(h5->file, path, H5T_NATIVE_UCHAR, space, links, layout, access);
  int status = nsdae_h5_result(h5, *set, "make a dataset in");
  H5Pclose(access);
  H5Sclose(space);
  H5Pclose(layout);
  H5Pclose(links);
  return status < 0 ? status : nsdae_h5_describe(h5, *set, "1", description);
}

/* ---- rows */

int nsdae_h5_resize(nsdae_h5 *h5, hid_t set, const hsize_t *size)
{
  return nsdae_h5_result(h5, H5Dset_extent(set, size), "write to");
}

typedef enum direction { WRITE, READ } direction;

static int move_row(nsdae_h5 *h5, hid_t set, hsize_t row, hsize_t width, void *bytes, direction to)
{
  const hsize_t start[2] = {row, 0}, count[2] = {1, width};
  hid_t file = H5Dget_space(set), memory = H5Screate_simple(1, &width, NULL);
  H5Sselect_hyperslab(file, H5S_SELECT_SET, start, NULL, count, NULL);
  herr_t code = to == WRITE ? H5Dwrite(set, H5T_NATIVE_UCHAR, memory, file, H5P_DEFAULT, bytes)
                            : H5Dread(set, H5T_NATIVE_UCHAR, memory, file, H5P_DEFAULT, bytes);
  int status = nsdae_h5_result(h5, code, to == WRITE ? "write to" : "read");
  H5Sclose(memory);
  H5Sclose(file);
  return status;
}

int nsdae_h5_write_row(nsdae_h5 *h5, hid_t set, hsize_t row, hsize_t width, const void *bytes)
{
  return move_row(h5, set, row, width, (void *)(uintptr_t)bytes, WRITE);
}

int nsdae_h5_read_row(nsdae_h5 *h5, hid_t set, hsize_t row, hsize_t width, void *bytes)
{
  return move_row(h5, set, row, width, bytes, READ);
}

int nsdae_h5_cut(nsdae_h5 *h5, hid_t series, hsize_t rows)
{
  hsize_t size[RANK_MAX] = {0};
  hid_t space = H5Dget_space(series);
  int rank = H5Sget_simple_extent_dims(space, size, NULL);
  H5Sclose(space);
  if (rank < 0) return nsdae_h5_result(h5, rank, "read the size of");
  if (size[0] <= rows) return NSDAE_OK;
  size[0] = rows;
  return nsdae_h5_result(h5, H5Dset_extent(series, size), "shorten");
}

int nsdae_h5_append(nsdae_h5 *h5, hid_t series, hid_t type, hsize_t from, hsize_t count,
                    const void *rows)
{
  hsize_t size[RANK_MAX] = {0}, start[RANK_MAX] = {from};
  hid_t file_space = H5Dget_space(series);
  int rank = H5Sget_simple_extent_dims(file_space, size, NULL);
  H5Sclose(file_space);
  int status = nsdae_h5_result(h5, rank, "read the size of");
  if (status < 0) return status;
  if (size[0] < from + count) {
    size[0] = from + count;
    status = nsdae_h5_result(h5, H5Dset_extent(series, size), "write to");
  }
  if (status < 0) return status;
  size[0] = count;
  file_space = H5Dget_space(series);
  hid_t memory = H5Screate_simple(rank, size, NULL);
  H5Sselect_hyperslab(file_space, H5S_SELECT_SET, start, NULL, size, NULL);
  status = nsdae_h5_result(h5, H5Dwrite(series, type, memory, file_space, H5P_DEFAULT, rows),
                           "write to");
  H5Sclose(memory);
  H5Sclose(file_space);
  return status;
}
