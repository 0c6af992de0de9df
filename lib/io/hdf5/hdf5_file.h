/* The calls to HDF5 that a file needs. The first failure of a public call stays in status: after it
 * nothing more is read or written, and all functions return it. They run between
 * H5E_BEGIN_TRY and H5E_END_TRY, which turn HDF5's own error printing off; its innermost message
 * goes to the record. */
#ifndef NSDAE_IO_HDF5_FILE_H
#define NSDAE_IO_HDF5_FILE_H

#include <hdf5.h>

#include "crash_safe_vfd.h"
#include "errors.h"

typedef struct nsdae_h5 {
  hid_t file;
  nsdae_vfd disk; /* under it; must stay where it is while the file is open */
  const char *path;
  const char *where;  /* public function at work, for errors */
  nsdae_error *error; /* of the call at work; may be NULL */
  int status;         /* of the call at work: its first failure, or NSDAE_OK */
} nsdae_h5;

/* Before all that a public call does: no failure yet. */
void nsdae_h5_start(nsdae_h5 *h5, nsdae_error *error);

typedef enum nsdae_h5_kind {
  NSDAE_H5_PLAIN, /* any HDF5 from 1.8 on reads it */
  NSDAE_H5_LIVE,  /* in the format that SWMR needs */
  NSDAE_H5_PACKED /* for compressed rows: space that becomes free is not used again, so that a chunk
                     that is packed anew does not overwrite what the file refers to */
} nsdae_h5_kind;

/* Makes the file, which takes the place of one of that name at the first nsdae_h5_flush and is gone
 * if there is none. */
int nsdae_h5_create(nsdae_h5 *h5, nsdae_h5_kind kind);
/* Opens it to be changed; on trial: not before the first nsdae_h5_flush, so that a file which is
 * refused stays as it was. Other files are one's own, which may be the part of a flush that failed.
 */
int nsdae_h5_reopen(nsdae_h5 *h5, int on_trial);
/* Opens it to be read. */
int nsdae_h5_open(nsdae_h5 *h5);
/* Before rows are written: whether what was written so far arrived, the file is still the one that
 * has its name, and the disk has room for this number of bytes more. */
int nsdae_h5_prepare(nsdae_h5 *h5, long bytes);
/* After it the file on disk has all that was written; a program killed within it leaves what was
 * there at the flush before. */
int nsdae_h5_flush(nsdae_h5 *h5);
/* In any case, after a failure too; datasets that are open in it are closed as well. */
int nsdae_h5_close(nsdae_h5 *h5);
/* Lets readers in: from here on nothing can be made in the file. */
int nsdae_h5_start_swmr(nsdae_h5 *h5);

/* Of a call to HDF5 that returned code, < 0 if it failed; to be called right after it. what: "write
 * to", ... */
int nsdae_h5_result(nsdae_h5 *h5, long code, const char *what);
/* NSDAE_E_IO, "cannot WHAT 'FILE': ..." */
int nsdae_h5_refuse(nsdae_h5 *h5, const char *what, const char *format, ...) NSDAE_PRINTF(3, 4);
/* NSDAE_E_MEMORY */
int nsdae_h5_no_memory(nsdae_h5 *h5);
/* Zeros, from calloc: count and one more. NULL after a failure. */
void *nsdae_h5_allocate(nsdae_h5 *h5, size_t count, size_t size);

#endif
