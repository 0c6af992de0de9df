#include "hdf5_file.h"
#include "hdf5_guard.h"

#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

void nsdae_h5_start(nsdae_h5 *h5, nsdae_error *error)
{
  h5->error = error;
  h5->status = NSDAE_OK;
}

/* ---- errors */

/* Keeps the innermost message of HDF5's stack. */
static herr_t innermost(unsigned n, const H5E_error2_t *entry, void *user)
{
  if (n == 0 && entry->desc) snprintf(user, 200, "%s", entry->desc);
  return 0;
}

int nsdae_h5_refuse(nsdae_h5 *h5, const char *what, const char *format, ...)
{
  char text[200];
  va_list args;
  if (h5->status < 0) return h5->status;
  va_start(args, format);
  vsnprintf(text, sizeof text, format, args);
  va_end(args);
  int status = h5->disk.failure == ENOMEM ? NSDAE_E_MEMORY : NSDAE_E_IO;
  h5->status = nsdae_error_set(h5->error, status, h5->where, "path", "cannot %s '%.90s': %s", what,
                               h5->path, text);
  return h5->status;
}

/* The reason is the disk's; else HDF5's, whose next call clears its stack. */
static int report_failure(nsdae_h5 *h5, const char *what)
{
  char text[200] = "unknown reason";
  if (h5->disk.failure)
    return nsdae_h5_refuse(h5, what, "%.120s", nsdae_vfd_words(h5->disk.failure));
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, innermost, text);
  return nsdae_h5_refuse(h5, what, "%.120s", text);
}

int nsdae_h5_result(nsdae_h5 *h5, long code, const char *what)
{
  return code < 0 ? report_failure(h5, what) : h5->status;
}

int nsdae_h5_no_memory(nsdae_h5 *h5)
{
  if (h5->status == NSDAE_OK)
    h5->status = nsdae_error_set(h5->error, NSDAE_E_MEMORY, h5->where, "",
                                 "out of memory for '%.90s'", h5->path);
  return h5->status;
}

void *nsdae_h5_allocate(nsdae_h5 *h5, size_t count, size_t size)
{
  void *block = h5->status < 0 ? NULL : calloc(count + 1, size);
  if (!block) nsdae_h5_no_memory(h5);
  return block;
}

/* ---- creating and opening */

/* HDF5 does not see that a write failed: the disk knows. */
static int arrived(nsdae_h5 *h5, long code, const char *what)
{
  return nsdae_h5_result(h5, h5->disk.failure ? -1 : code, what);
}

/* The driver under the file, then HDF5 on top of it. */
static hid_t open_disk(nsdae_h5 *h5, nsdae_vfd_mode mode)
{
  h5->file = -1;
  h5->disk.failure = nsdae_vfd_open(&h5->disk, h5->path, mode);
  return h5->disk.failure ? -1 : nsdae_vfd_access(&h5->disk);
}

/* Whether it is one that is read along: it is marked as open until its writer closes it, which a
 * writer that was killed never did. */
static int is_live(const nsdae_h5 *h5)
{
  hid_t file = H5Fopen(h5->path, H5F_ACC_RDONLY | H5F_ACC_SWMR_READ, H5P_DEFAULT);
  if (file >= 0) H5Fclose(file);
  return file >= 0;
}

static int opened(nsdae_h5 *h5, hid_t access, const char *what)
{
  nsdae_h5_result(h5, h5->file, what);
  if (access >= 0) H5Pclose(access);
  if (h5->file >= 0) return h5->status;
  int failure = h5->disk.failure;
  nsdae_vfd_close(&h5->disk); /* and its lock */
  if (failure || !is_live(h5)) return h5->status;
  h5->status = NSDAE_OK;
  return nsdae_h5_refuse(h5, what,
                         "a live run writes it, or was killed: h5clear -s makes it readable; a "
                         "live file cannot be resumed");
}

/* What was opened: nothing in it may lead out of it. */
static int guarded(nsdae_h5 *h5)
{
  char reason[NSDAE_GUARD_REASON];
  if (h5->status < 0) return h5->status;
  if (nsdae_h5_guard(h5->file, h5->disk.eof, reason) == 0) return NSDAE_OK;
  if (*reason)
    nsdae_h5_refuse(h5, "read", "%s", reason);
  else
    report_failure(h5, "read");
  return nsdae_h5_close(h5);
}

int nsdae_h5_create(nsdae_h5 *h5, nsdae_h5_kind kind)
{
  hid_t access = open_disk(h5, NSDAE_VFD_REPLACE), creation = H5Pcreate(H5P_FILE_CREATE);
  if (kind == NSDAE_H5_LIVE) H5Pset_libver_bounds(access, H5F_LIBVER_LATEST, H5F_LIBVER_LATEST);
  if (kind == NSDAE_H5_PACKED) H5Pset_file_space_strategy(creation, H5F_FSPACE_STRATEGY_AGGR, 0, 1);
  if (access >= 0) h5->file = H5Fcreate(h5->path, H5F_ACC_TRUNC, creation, access);
  opened(h5, access, "write");
  H5Pclose(creation);
  return h5->status;
}

/* HDF5 takes back space that becomes free at the end of a file, to use it at once for what takes
 * its place: with this behind it, it is not at the end. */
enum { GAP = 8 };

int nsdae_h5_reopen(nsdae_h5 *h5, int on_trial)
{
  if (h5->status < 0) return h5->status;
  hid_t access = open_disk(h5, NSDAE_VFD_UPDATE);
  h5->disk.unready = on_trial;
  if (access >= 0) h5->file = H5Fopen(h5->path, H5F_ACC_RDWR, access);
  h5->disk.committed = h5->disk.eoa; /* the file may be longer than what it refers to */
  h5->disk.eoa += GAP;
  opened(h5, access, "open");
  return guarded(h5);
}

int nsdae_h5_open(nsdae_h5 *h5)
{
  hid_t access = open_disk(h5, NSDAE_VFD_READ);
  if (access >= 0) h5->file = H5Fopen(h5->path, H5F_ACC_RDONLY, access);
  opened(h5, access, "read");
  return guarded(h5);
}

/* ---- flushing and closing */

int nsdae_h5_prepare(nsdae_h5 *h5, long bytes)
{
  if (h5->status < 0) return h5->status;
  int failure = nsdae_vfd_check(&h5->disk);
  if (failure == 0) failure = nsdae_vfd_reserve(&h5->disk, (uint64_t)bytes);
  return failure ? nsdae_h5_refuse(h5, "write to", "%.120s", nsdae_vfd_words(failure)) : NSDAE_OK;
}

int nsdae_h5_flush(nsdae_h5 *h5)
{
  if (h5->status < 0) return h5->status;
  h5->disk.unready = 0;
  return arrived(h5, H5Fflush(h5->file, H5F_SCOPE_LOCAL), "write to");
}

int nsdae_h5_close(nsdae_h5 *h5)
{
  if (h5->file >= 0) arrived(h5, H5Fclose(h5->file), "close");
  h5->file = -1;
  if (h5->disk.path && nsdae_vfd_close(&h5->disk) != 0) report_failure(h5, "close");
  return h5->status;
}

int nsdae_h5_start_swmr(nsdae_h5 *h5)
{
  if (nsdae_h5_flush(h5) < 0) return h5->status;
  h5->disk.direct = 1;
  return arrived(h5, H5Fstart_swmr_write(h5->file), "let readers into");
}
