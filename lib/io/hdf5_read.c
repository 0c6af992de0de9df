#include "hdf5_read.h"

#include "errors.h"

/* "cannot read 'file': ..." with what is wrong with one of its datasets. */
static int unfit(nsdae_h5 *h5, const char *path, const char *wrong)
{
  return nsdae_error_set(h5->error, NSDAE_E_IO, h5->where ? h5->where : "nsdae_trajectory", "path",
                         "cannot read '%.90s': dataset %s %s", h5->path, path, wrong);
}

/* Bytes of an element, or 0 where it is no number. */
static hsize_t number_size(hid_t type)
{
  enum { LARGEST = 16 };
  H5T_class_t kind = H5Tget_class(type);
  size_t size = H5Tget_size(type);
  return (kind == H5T_FLOAT || kind == H5T_INTEGER) && size > 0 && size <= LARGEST ? size : 0;
}

/* The product of lengths and size, or 0 where it is more than most. */
static hsize_t product(int rank, const hsize_t *length, hsize_t size, hsize_t most)
{
  hsize_t bytes = size;
  for (int i = 0; i < rank; i++) {
    if (length[i] > 0 && bytes > most / length[i]) return 0;
    bytes *= length[i];
  }
  return bytes > most ? 0 : bytes;
}

static int is_empty(int rank, const hsize_t *length)
{
  int empty = 0;
  for (int i = 0; i < rank; i++) empty |= length[i] == 0;
  return empty;
}

/* Nothing was ever written, or all of it. */
static int holds(hid_t set, hsize_t bytes)
{
  hsize_t stored = H5Dget_storage_size(set);
  return stored == 0 || stored == bytes;
}

/* Whether the data can be in a file of that length. Compressed ones may be 1032 times what they
 * take, the most that deflate does. */
static const char *look_at_layout(hid_t set, int rank, const hsize_t *length, hsize_t size,
                                  hsize_t file)
{
  enum { DEFLATE_MOST = 1032 };
  const char *wrong = NULL;
  hsize_t chunk[NSDAE_H5_RANK_MAX];
  hid_t plist = H5Dget_create_plist(set);
  H5D_layout_t layout = H5Pget_layout(plist);
  hsize_t most = H5Pget_nfilters(plist) > 0 ? DEFLATE_MOST * file : file;
  if (H5Pget_external_count(plist) != 0)
    wrong = "has its data in other files";
  else if (layout == H5D_CHUNKED &&
           (H5Pget_chunk(plist, rank, chunk) != rank || product(rank, chunk, size, most) == 0))
    wrong = "has chunks that are longer than the file";
  else if (layout != H5D_CHUNKED && layout != H5D_CONTIGUOUS && layout != H5D_COMPACT)
    wrong = "is spread over other files";
  else if (!is_empty(rank, length) && product(rank, length, size, most) == 0)
    wrong = "is longer than the file";
  else if (layout != H5D_CHUNKED && !holds(set, product(rank, length, size, most)))
    wrong = "has less data than its shape says";
  H5Pclose(plist);
  return wrong;
}

static const char *look_at(hid_t set, int rank, hsize_t *length)
{
  hid_t space = H5Dget_space(set), type = H5Dget_type(set);
  hsize_t size = number_size(type);
  int found = H5Sget_simple_extent_ndims(space);
  const char *wrong = NULL;
  if (size == 0)
    wrong = "is not of numbers";
  else if (found != rank)
    wrong = rank == 1 ? "is not a vector" : rank == 2 ? "is not a matrix" : "has another shape";
  else if (H5Sget_simple_extent_dims(space, length, NULL) < 0)
    wrong = "has a shape that cannot be read";
  H5Sclose(space);
  H5Tclose(type);
  return wrong;
}

int nsdae_h5_shape(nsdae_h5 *h5, const char *path, int rank, hsize_t *length)
{
  hid_t set = H5Dopen2(h5->file, path, H5P_DEFAULT);
  if (set < 0) return unfit(h5, path, "is missing");
  const char *wrong = look_at(set, rank, length);
  H5Dclose(set);
  return wrong ? unfit(h5, path, wrong) : NSDAE_OK;
}

int nsdae_h5_fits(nsdae_h5 *h5, const char *path, int rank, const hsize_t *length)
{
  hid_t set = H5Dopen2(h5->file, path, H5P_DEFAULT);
  if (set < 0) return unfit(h5, path, "is missing");
  hid_t type = H5Dget_type(set);
  const char *wrong = look_at_layout(set, rank, length, number_size(type), h5->disk.eof);
  H5Tclose(type);
  H5Dclose(set);
  return wrong ? unfit(h5, path, wrong) : NSDAE_OK;
}

int nsdae_h5_read_as(nsdae_h5 *h5, const char *path, hid_t type, void *values)
{
  hid_t set = H5Dopen2(h5->file, path, H5P_DEFAULT);
  int status = nsdae_h5_result(h5, set, "read");
  if (status < 0) return status;
  herr_t code = H5Dread(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values);
  status = nsdae_h5_result(h5, code, "read");
  H5Dclose(set);
  return status;
}

int nsdae_h5_read(nsdae_h5 *h5, const char *path, double *values)
{
  return nsdae_h5_read_as(h5, path, H5T_NATIVE_DOUBLE, values);
}

int nsdae_h5_get_real(nsdae_h5 *h5, hid_t object, const char *name, double *value)
{
  if (H5Aexists(object, name) <= 0) return NSDAE_OK;
  hid_t attribute = H5Aopen(object, name, H5P_DEFAULT);
  int status = nsdae_h5_result(h5, attribute, "read an attribute of");
  if (status < 0) return status;
  hid_t space = H5Aget_space(attribute), type = H5Aget_type(attribute);
  if (H5Sget_simple_extent_npoints(space) == 1 && number_size(type) > 0)
    status =
        nsdae_h5_result(h5, H5Aread(attribute, H5T_NATIVE_DOUBLE, value), "read an attribute of");
  H5Tclose(type);
  H5Sclose(space);
  H5Aclose(attribute);
  return status;
}
