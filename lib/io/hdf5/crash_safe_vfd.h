/* The file under HDF5: a driver of its own (a "VFD") between HDF5 and the system, so that the file
 * on disk can be opened at any moment, whatever becomes of the program or of the disk.
 *
 * HDF5 writes its structures in the order of their addresses, in place: a program killed between
 * two of these writes leaves a tree whose parts do not fit. Here what the file on disk refers to is
 * held back until HDF5 has written all of a flush, and goes out in an order in which every state on
 * the way is a whole file (see rank_of in crash_safe_vfd.c). Rows go out at once: nothing refers to
 * them yet, or they are there already and are written again as they were.
 *
 * HDF5 1.10 can neither close a file whose last writes failed nor end the program after that. So
 * a write never fails for HDF5: the first failure is kept here, nothing more is written, and the
 * file stays as the last commit left it. */
#ifndef NSDAE_IO_ORDERED_H
#define NSDAE_IO_ORDERED_H

#include <hdf5.h>
#if H5_VERSION_GE(1, 13, 0)
#include <H5FDdevelop.h>
#endif
#include <stddef.h>
#include <stdint.h>

/* ---- Writes that are held back: blocks of bytes with their place in a file. */

typedef struct nsdae_block {
  uint64_t at; /* address in the file */
  size_t size;
  int kind; /* the caller's; that of the first write to these bytes */
  long rank;
  unsigned char *bytes;
} nsdae_block;

/* No two blocks have a byte in common: the later write won. */
typedef struct nsdae_write_queue {
  nsdae_block *block;
  size_t count, room;
} nsdae_write_queue;

/* Holds a copy of the bytes. 0, or -1 where there is no memory for it and nothing changed. */
int nsdae_write_queue_add(nsdae_write_queue *pending, uint64_t at, size_t size, int kind,
                          const void *bytes);

/* Puts what is held of [at, at + size) over what the buffer has from the file. */
void nsdae_write_queue_overlay(const nsdae_write_queue *pending, uint64_t at, size_t size,
                               void *buffer);

/* By rank, then by address. */
void nsdae_write_queue_sort(nsdae_write_queue *pending);

/* Drops all blocks, keeps the list's memory. */
void nsdae_write_queue_clear(nsdae_write_queue *pending);
void nsdae_write_queue_release(nsdae_write_queue *pending);

/* ---- crash_safe_vfd.c */

enum {
  NSDAE_VFD_REPLACED = -1, /* another file has its name, or others wrote into it */
  NSDAE_VFD_NO_FILE = -2   /* not a regular file */
};

typedef enum nsdae_vfd_mode {
  NSDAE_VFD_READ,
  NSDAE_VFD_UPDATE,
  NSDAE_VFD_REPLACE /* what there is of that name stays as it is until the first commit */
} nsdae_vfd_mode;

enum { NSDAE_VFD_HEAD = 96 };

/* HDF5 has its address: it must stay where it is while the file is open. */
typedef struct nsdae_vfd {
  H5FD_t own;   /* HDF5's part, first */
  hid_t driver; /* HDF5's number of the driver, 0 where it has none */
  int fd;       /* -1: closed */
  const char *path;
  uint64_t device, number; /* of the file, see nsdae_fs_identity */
  int made;                /* there was none of that name */
  int direct;  /* what HDF5 writes goes out at once, in its order: that of SWMR's writer */
  int failure; /* the first errno of a write, or one of those above; 0: none */
  int reading;
  int unready;        /* nothing is committed while it is set, as it is of a new file */
  long budget;        /* calls that may still read, where reading */
  uint64_t eoa, eof;  /* end of what HDF5 allocated, of what it wrote */
  uint64_t old;       /* length of the file that is to be replaced, until the first commit */
  uint64_t committed; /* end of what the file on disk refers to; 0: nothing yet */
  uint64_t reserved;  /* length that the disk has room for */
  nsdae_write_queue pending;
  unsigned char head[NSDAE_VFD_HEAD]; /* of the file on disk, as written here */
  size_t head_size;
} nsdae_vfd;

/* Opens the file, and locks it as HDF5 does (HDF5_USE_FILE_LOCKING is heeded). 0, or an errno or
 * one of the codes above, with nothing left open. */
int nsdae_vfd_open(nsdae_vfd *file, const char *path, nsdae_vfd_mode mode);

/* A file access list for H5Fcreate and H5Fopen with this file under it. < 0: failed. */
hid_t nsdae_vfd_access(nsdae_vfd *file);

/* Whether name and content are still this file's: 0 or NSDAE_VFD_REPLACED, then kept. */
int nsdae_vfd_check(nsdae_vfd *file);

/* Room on the disk for this number of bytes more than HDF5 has allocated. 0, or an errno: then
 * nothing has failed yet, and what was written so far can still be committed. */
int nsdae_vfd_reserve(nsdae_vfd *file, uint64_t bytes);

/* After H5Fclose. Returns the failure, if there was one. A file that was made and has nothing in
 * it is removed again. */
int nsdae_vfd_close(nsdae_vfd *file);

/* In words, without the file's name. */
const char *nsdae_vfd_words(int failure);

#endif
