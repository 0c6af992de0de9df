/* Files that are read: a pipe, a device or a folder is refused, as opening a pipe waits for a
 * writer. */
#ifndef NSDAE_REGULAR_FILE_H
#define NSDAE_REGULAR_FILE_H

#include <stdio.h>

/* The file, open to be read; NULL with the reason in *why. */
FILE *nsdae_regular_file(const char *path, const char **why);

#endif
