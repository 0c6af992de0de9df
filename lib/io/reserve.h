/* Disk space, taken before it is needed. A write that fails half way leaves HDF5 with a file that
 * it can neither close nor open again; so what a write may need is reserved first, and a full disk
 * is met while the file is still whole. Closing gives back what was not used. */
#ifndef NSDAE_IO_RESERVE_H
#define NSDAE_IO_RESERVE_H

/* Whether bytes more can be written to a file at path, which is made where there is none.
 * Returns 0 or the errno of what failed. */
int nsdae_reserve_try(const char *path, long bytes);

/* Makes the file at least bytes long, its blocks allocated. Returns 0 or an errno. */
int nsdae_reserve(const char *path, long bytes);

/* Length of the file, or -1. */
long nsdae_reserve_length(const char *path);

#endif
