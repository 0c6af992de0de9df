/* The calls to HDF5 that a trajectory needs, each with its failure as a status. HDF5's own error
 * printing must be off (NSDAE_H5_QUIETLY) while they run; its innermost message goes to the record.
 */
#ifndef NSDAE_IO_HDF5_FILE_H
#define NSDAE_IO_HDF5_FILE_H

#include <hdf5.h>

#include <nsdae/status.h>

#include "crash_safe_vfd.h"

/* How the program has HDF5 print its errors. */
typedef struct nsdae_h5_voice {
  unsigned is_new; /* set by H5Eset_auto2, else by H5Eset_auto1 */
  H5E_auto2_t print;
  H5E_auto1_t print_old;
  void *user;
} nsdae_h5_voice;

/* Turns it off; puts it back. */
nsdae_h5_voice nsdae_h5_hush(void);
void nsdae_h5_speak(const nsdae_h5_voice *voice);

/* status = expression, with HDF5's error printing off and put back after. */
#define NSDAE_H5_QUIETLY(status, expression)          \
  {                                                   \
    const nsdae_h5_voice voice_was = nsdae_h5_hush(); \
    status = (expression);                            \
    nsdae_h5_speak(&voice_was);                       \
  }

typedef struct nsdae_h5 {
  hid_t file;
  nsdae_vfd disk; /* under it; must stay where it is while the file is open */
  const char *path;
  const char *where;  /* public function at work; NULL: nsdae_trajectory */
  nsdae_error *error; /* of the call at work */
} nsdae_h5;

typedef enum nsdae_h5_kind {
  NSDAE_H5_PLAIN, /* any HDF5 from 1.8 on reads it */
  NSDAE_H5_LIVE,  /* in the format that SWMR needs */
  NSDAE_H5_PACKED /* for compressed rows: space that becomes free is not used again, so that a chunk
                     that is packed anew does not overwrite what the file refers to */
} nsdae_h5_kind;

/* Makes the file, which takes the place of one of that name at the first nsdae_h5_flush and is gone
 * where there is none. */
int nsdae_h5_create(nsdae_h5 *h5, nsdae_h5_kind kind);
/* Opens it to be changed. */
int nsdae_h5_reopen(nsdae_h5 *h5);
/* Opens it to be read. */
int nsdae_h5_open(nsdae_h5 *h5);
/* Before rows are written: whether what was written so far arrived, the file is still the one that
 * has its name, and the disk has room for this number of bytes more. */
int nsdae_h5_prepare(nsdae_h5 *h5, long bytes);
/* After it the file on disk has all that was written; a program killed within it leaves what was
 * there at the flush before. */
int nsdae_h5_flush(nsdae_h5 *h5);
int nsdae_h5_close(nsdae_h5 *h5);
/* Lets readers in: from here on nothing can be made in the file. */
int nsdae_h5_start_swmr(nsdae_h5 *h5);

/* status of a call to HDF5 that returned code, < 0 where it failed; to be called right after it.
 * what: "write to", ... */
int nsdae_h5_result(nsdae_h5 *h5, long code, const char *what);

#endif
