/* Files that may be damaged: HDF5 1.10 can end, or hang, on what it does not expect. So such a file
 * is read once in a process of its own first, which may. */
#ifndef NSDAE_DRIVER_PROBE_H
#define NSDAE_DRIVER_PROBE_H

#include <stdio.h>

#include <nsdae/nsdae.h>

/* Reads the file at path, with user; returns a status. */
typedef int (*probe_fn)(const char *path, void *user, nsdae_error *error);

/* The status and error of read in a process of its own, with memory and time for a file of that
 * length; NSDAE_E_IO where the process did not come through it. */
int probe(const char *path, probe_fn read, void *user, nsdae_error *error);

/* A regular file, open to be read; NULL with the reason in *why. Of a pipe it would wait for a
 * writer. */
FILE *open_regular(const char *path, const char **why);

#endif
