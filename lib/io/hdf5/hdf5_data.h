/* What is written to a file and read from it: groups, attributes, datasets. After a failure nothing
 * is done, a handle is -1, a number read 0.
 *
 * What is read may be anybody's and corrupt: the guard bounded all sizes when the file was opened
 * (hdf5_file.c), type and rank are looked at before memory is asked for. Only numbers are read:
 * texts of variable length lead through heaps in which HDF5 follows whatever the file says. */
#ifndef NSDAE_IO_HDF5_DATA_H
#define NSDAE_IO_HDF5_DATA_H

#include "hdf5_file.h"

enum { NSDAE_H5_RANK = 3, NSDAE_H5_PATH = 128 };

/* "GROUP/NAME", in path. */
const char *nsdae_h5_join(char path[NSDAE_H5_PATH], const char *group, const char *name);

/* ---- writing */

int nsdae_h5_group(nsdae_h5 *h5, const char *name);

/* Attribute of an object of the file, made or written anew. */
int nsdae_h5_set_text(nsdae_h5 *h5, hid_t object, const char *name, const char *text);
int nsdae_h5_set_int(nsdae_h5 *h5, hid_t object, const char *name, int value);

/* Attributes of the root of a file of a problem: where it comes from. */
void nsdae_h5_set_origin(nsdae_h5 *h5, double time, long step, double tol, const char *method);

/* How a dataset lies in the file. */
typedef struct nsdae_h5_layout {
  int rank;
  hsize_t size[NSDAE_H5_RANK], most[NSDAE_H5_RANK]; /* now, and as far as it may grow */
  hsize_t chunk[NSDAE_H5_RANK];                     /* zeros: not in chunks */
  int deflate; /* level of compression, after the bytes of each place were put together (shuffle) */
  int early;   /* its space is taken at once: later only bytes change */
} nsdae_h5_layout;

/* A dataset, in groups that are made as needed; H5Dclose closes it. */
hid_t nsdae_h5_dataset(nsdae_h5 *h5, const char *path, hid_t type, const nsdae_h5_layout *layout,
                       const char *units, const char *description);
/* One that is there, to write more into it. */
hid_t nsdae_h5_open_dataset(nsdae_h5 *h5, const char *path);

/* A dataset of these values, of rank 0, 1 or 2, row by row; text: type H5T_C_S1, values strings. */
int nsdae_h5_array(nsdae_h5 *h5, const char *path, hid_t type, int rank, const hsize_t *size,
                   const void *values, const char *units, const char *description);
int nsdae_h5_vector(nsdae_h5 *h5, const char *path, hid_t type, hsize_t n, const void *values,
                    const char *units, const char *description);

int nsdae_h5_make_scale(nsdae_h5 *h5, hid_t set, const char *name);
int nsdae_h5_attach_scale(nsdae_h5 *h5, hid_t set, hid_t scale, int dimension);

int nsdae_h5_resize(nsdae_h5 *h5, hid_t set, const hsize_t *size);
/* Shortens a dataset to this number of rows; longer ones stay. */
int nsdae_h5_cut(nsdae_h5 *h5, hid_t set, hsize_t rows);
/* Writes the part of the dataset that begins at start. */
int nsdae_h5_write_part(nsdae_h5 *h5, hid_t set, hid_t type, int rank, const hsize_t *start,
                        const hsize_t *size, const void *values);
/* Writes count rows behind the first `from`. */
int nsdae_h5_append(nsdae_h5 *h5, hid_t set, hid_t type, hsize_t from, hsize_t count,
                    const void *rows);

/* ---- reading */

/* Whether there is an object of that name, each group on the way looked at. */
int nsdae_h5_has(nsdae_h5 *h5, const char *path);
/* Lengths [rank] of a dataset of numbers, which must have that rank. */
int nsdae_h5_shape(nsdae_h5 *h5, const char *path, int rank, hsize_t *length);
/* Its numbers, in the order of the file, of a dataset whose shape was looked at. */
int nsdae_h5_read(nsdae_h5 *h5, const char *path, hid_t type, void *values);
/* 0 if there is no such attribute. */
double nsdae_h5_get_real(nsdae_h5 *h5, hid_t object, const char *name);

/* The length of the vector GROUP/NAME, at most most; -1 if it is not there. */
int nsdae_h5_length(nsdae_h5 *h5, const char *group, const char *name, long most);

/* Such vectors, read; NULL: not there and not needed. *length: what it must be, or -1, and it comes
 * back. */
enum { NSDAE_H5_OPTIONAL, NSDAE_H5_NEEDED };
int *nsdae_h5_take_ints(nsdae_h5 *h5, const char *group, const char *name, int needed, int *length);
/* Finite ones. */
double *nsdae_h5_take_reals(nsdae_h5 *h5, const char *group, const char *name, int needed,
                            int *length);
/* A vector of one number, in [least, most]. */
int nsdae_h5_take_int(nsdae_h5 *h5, const char *group, const char *name, int least, int most);

#endif
