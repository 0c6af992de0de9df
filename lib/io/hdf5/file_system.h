/* Files of the system, by descriptor: positioned reads and writes, locks, room on the disk. POSIX
 * (IEEE Std 1003.1-2008) with flock, and Windows. All but nsdae_fs_open return 0 or an errno. */
#ifndef NSDAE_IO_FILE_SYSTEM_H
#define NSDAE_IO_FILE_SYSTEM_H

#include <stddef.h>
#include <stdint.h>

typedef struct nsdae_fs_identity {
  uint64_t device, number; /* same file, same numbers */
  uint64_t size;
  int regular;
} nsdae_fs_identity;

/* A descriptor, or -errno. */
int nsdae_fs_open(const char *path, int writing, int create);

/* EAGAIN if another program has it for a second. 0 on a file system without locks. */
int nsdae_fs_lock(int fd, int shared);
void nsdae_fs_unlock(int fd);

int nsdae_fs_identify(int fd, nsdae_fs_identity *identity);
int nsdae_fs_identify_path(const char *path, nsdae_fs_identity *identity);

/* Behind the end of the file zeros are read. */
int nsdae_fs_read(int fd, void *bytes, size_t size, uint64_t at);
int nsdae_fs_write(int fd, const void *bytes, size_t size, uint64_t at);

/* Room on the disk for this length; the file is not made shorter. */
int nsdae_fs_reserve(int fd, uint64_t length);
int nsdae_fs_truncate(int fd, uint64_t length);
int nsdae_fs_close(int fd);

#endif
