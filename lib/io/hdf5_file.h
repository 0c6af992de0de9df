/* The calls to HDF5 that a trajectory needs, each with its failure as a status. HDF5's own error
 * printing must be off (NSDAE_H5_QUIETLY) while they run; its innermost message goes to the record.
 */
#ifndef NSDAE_IO_HDF5_FILE_H
#define NSDAE_IO_HDF5_FILE_H

#include <hdf5.h>

#include <nsdae/status.h>

#include "ordered.h"

/* status = expression, with HDF5's error printing off and put back after. */
#define NSDAE_H5_QUIETLY(status, expression) \
  H5E_BEGIN_TRY                              \
  {                                          \
    status = (expression);                   \
  }                                          \
  H5E_END_TRY

typedef struct nsdae_h5 {
  hid_t file;
  nsdae_ordered disk; /* under it; must stay where it is while the file is open */
  const char *path;
  const char *where;  /* public function at work; NULL: nsdae_trajectory */
  nsdae_error *error; /* of the call at work */
} nsdae_h5;

/* Makes the file, which takes the place of one of that name at the first nsdae_h5_flush and is gone
 * where there is none; latest: in the format that SWMR needs. */
int nsdae_h5_create(nsdae_h5 *h5, int latest);
/* Opens it to be changed. */
int nsdae_h5_reopen(nsdae_h5 *h5);
/* Opens it to be read. */
int nsdae_h5_open(nsdae_h5 *h5);
/* Before rows are written: whether what was written so far arrived, the file is still the one that
 * has its name, and the disk has room for so many bytes more. */
int nsdae_h5_prepare(nsdae_h5 *h5, long bytes);
/* After it the file on disk has all that was written; a program killed within it leaves what was
 * there at the flush before. */
int nsdae_h5_flush(nsdae_h5 *h5);
int nsdae_h5_close(nsdae_h5 *h5);
/* Lets readers in: from here on nothing can be made in the file. */
int nsdae_h5_start_swmr(nsdae_h5 *h5);

int nsdae_h5_group(nsdae_h5 *h5, const char *name);

/* Attribute of an object of the file, made or written anew. */
int nsdae_h5_set_text(nsdae_h5 *h5, hid_t object, const char *name, const char *text);
int nsdae_h5_set_int(nsdae_h5 *h5, hid_t object, const char *name, int value);
int nsdae_h5_set_real(nsdae_h5 *h5, hid_t object, const char *name, double value);
/* Leaves the value where there is no such attribute. */
int nsdae_h5_get_real(nsdae_h5 *h5, hid_t object, const char *name, double *value);

/* A scalar dataset with units and description; text: type H5T_C_S1, value a string. */
int nsdae_h5_scalar(nsdae_h5 *h5, const char *path, hid_t type, const void *value,
                    const char *units, const char *description);

/* A dataset of n values, in groups that are made as needed; text: type H5T_C_S1, values strings. */
int nsdae_h5_vector(nsdae_h5 *h5, const char *path, hid_t type, hsize_t n, const void *values,
                    const char *units, const char *description);

/* A dataset of n x columns values, row by row. */
int nsdae_h5_matrix(nsdae_h5 *h5, const char *path, hsize_t n, hsize_t columns, const double *rows,
                    const char *units, const char *description);

/* Lengths [rank] of a dataset, which must have that rank; its numbers, in the order of the file. */
int nsdae_h5_shape(nsdae_h5 *h5, const char *path, int rank, hsize_t *length);
int nsdae_h5_read(nsdae_h5 *h5, const char *path, double *values);

/* A growing dataset: rows of width values (0: plain values), in chunks of chunk rows. */
int nsdae_h5_series(nsdae_h5 *h5, const char *path, hid_t type, const hsize_t *width, int rank,
                    hsize_t chunk, hid_t *series);
int nsdae_h5_describe(nsdae_h5 *h5, hid_t series, const char *units, const char *description);
int nsdae_h5_make_scale(nsdae_h5 *h5, hid_t series, const char *name);
int nsdae_h5_attach_scale(nsdae_h5 *h5, hid_t series, hid_t scale);

/* Writes count rows behind the first `from`. */
int nsdae_h5_append(nsdae_h5 *h5, hid_t series, hid_t type, hsize_t from, hsize_t count,
                    const void *rows);

#endif
