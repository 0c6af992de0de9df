/* What is refused in an HDF5 file of unknown origin before anything in it is read: links and data
 * that lead to other files, filters that need a plugin, and shapes of more bytes than are stored.
 * HDF5 itself follows the first two and allocates what a shape claims. */
#ifndef NSDAE_IO_HDF5_GUARD_H
#define NSDAE_IO_HDF5_GUARD_H

#include <hdf5.h>

enum { NSDAE_GUARD_REASON = 120 };

/* Walks the whole file, of that length in bytes. 0, or < 0: refused, with reason
 * [NSDAE_GUARD_REASON], or empty where HDF5 itself failed. */
int nsdae_h5_guard(hid_t file, hsize_t length, char *reason);

#endif
