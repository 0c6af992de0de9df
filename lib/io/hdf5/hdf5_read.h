/* What is read from a file, which may be anybody's and corrupt: the guard bounded all sizes when it
 * was opened (hdf5_guard.h), type and rank are looked at before memory is asked for. Only numbers
 * are read: texts of variable length lead through heaps in which HDF5 follows whatever the file
 * says. */
#ifndef NSDAE_IO_HDF5_READ_H
#define NSDAE_IO_HDF5_READ_H

#include "hdf5_file.h"

enum { NSDAE_H5_RANK_MAX = 3 };

/* Lengths [rank] of a dataset of numbers, which must have that rank. NSDAE_E_IO says what is
 * wrong with it. */
int nsdae_h5_shape(nsdae_h5 *h5, const char *path, int rank, hsize_t *length);
/* Its numbers, in the order of the file, of a dataset whose shape was looked at. */
int nsdae_h5_read(nsdae_h5 *h5, const char *path, double *values);
/* The same of bytes, in memory's type `type`. */
int nsdae_h5_read_as(nsdae_h5 *h5, const char *path, hid_t type, void *values);

/* Leaves the value where there is no such attribute. */
int nsdae_h5_get_real(nsdae_h5 *h5, hid_t object, const char *name, double *value);

#endif
