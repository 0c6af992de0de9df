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

int nsdae_h5_shape(nsdae_h5 *h5, const char *path, int rank, hsize_t *length)
{
  hid_t set = H5Dopen2(h5->file, path, H5P_DEFAULT);
  if (set < 0) return unfit(h5, path, "is missing");
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
