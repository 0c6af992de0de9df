/* What is written to a file: groups, attributes, datasets. */
#ifndef NSDAE_IO_HDF5_DATA_H
#define NSDAE_IO_HDF5_DATA_H

#include "hdf5_file.h"

int nsdae_h5_group(nsdae_h5 *h5, const char *name);

/* Attribute of an object of the file, made or written anew. */
int nsdae_h5_set_text(nsdae_h5 *h5, hid_t object, const char *name, const char *text);
int nsdae_h5_set_int(nsdae_h5 *h5, hid_t object, const char *name, int value);
int nsdae_h5_set_real(nsdae_h5 *h5, hid_t object, const char *name, double value);

/* A scalar dataset with units and description; text: type H5T_C_S1, value a string. */
int nsdae_h5_scalar(nsdae_h5 *h5, const char *path, hid_t type, const void *value,
                    const char *units, const char *description);

/* A dataset of n values, in groups that are made as needed; text: type H5T_C_S1, values strings. */
int nsdae_h5_vector(nsdae_h5 *h5, const char *path, hid_t type, hsize_t n, const void *values,
                    const char *units, const char *description);

/* Takes a dataset out of the file, where there is one. */
int nsdae_h5_remove(nsdae_h5 *h5, const char *path);

/* A dataset of n x columns values, row by row. */
int nsdae_h5_matrix(nsdae_h5 *h5, const char *path, hsize_t n, hsize_t columns, const double *rows,
                    const char *units, const char *description);

/* A growing dataset: rows of width values (0: plain values), in chunks of chunk rows; deflate:
 * level of compression, after the bytes of each place were put together (shuffle), 0 for none. */
int nsdae_h5_series(nsdae_h5 *h5, const char *path, hid_t type, const hsize_t *width, int rank,
                    hsize_t chunk, int deflate, hid_t *series);
int nsdae_h5_describe(nsdae_h5 *h5, hid_t series, const char *units, const char *description);
int nsdae_h5_make_scale(nsdae_h5 *h5, hid_t series, const char *name);
int nsdae_h5_attach_scale(nsdae_h5 *h5, hid_t series, hid_t scale, int dimension);
int nsdae_h5_open_dataset(nsdae_h5 *h5, const char *path, hid_t *set);
/* To write more rows into it. */
int nsdae_h5_open_series(nsdae_h5 *h5, const char *path, hid_t *set);

/* A dataset of size[0] rows of size[1] bytes, which are written and read one by one. grows: rows
 * may become longer (nsdae_h5_resize). */
int nsdae_h5_bytes(nsdae_h5 *h5, const char *path, const hsize_t size[2], int grows,
                   const char *description, hid_t *set);
int nsdae_h5_resize(nsdae_h5 *h5, hid_t set, const hsize_t *size);
int nsdae_h5_write_row(nsdae_h5 *h5, hid_t set, hsize_t row, hsize_t width, const void *bytes);
int nsdae_h5_read_row(nsdae_h5 *h5, hid_t set, hsize_t row, hsize_t width, void *bytes);

/* Shortens a series to this number of rows; longer ones stay. */
int nsdae_h5_cut(nsdae_h5 *h5, hid_t series, hsize_t rows);

/* Writes count rows behind the first `from`. */
int nsdae_h5_append(nsdae_h5 *h5, hid_t series, hid_t type, hsize_t from, hsize_t count,
                    const void *rows);

#endif
