#include "hdf5_file.h"

#include "hdf5_guard.h"

#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- hdf5 guard */

/* depth: groups in groups; a cycle of links is deeper than any bound. deflate: bytes out for a
 * byte in (zlib, Technical Details). link: bytes of a file that one takes, an object's address. */
enum { DEPTH_MOST = 32, DEFLATE_MOST = 1032, LINK_LEAST = 8, RANK_MOST = H5S_MAX_RANK };

static const hsize_t ENDLESS = ~(hsize_t)0; /* a size that no file has */

typedef struct walk {
  hsize_t length; /* of the file */
  hsize_t links;  /* that may still be followed */
  int depth;
  char *reason;
} walk;

static int refuse_file(const walk *w, hid_t item, const char *name, const char *why)
{
  char path[64] = "";
  H5Iget_name(item, path, sizeof path);
  const char *slash = strcmp(path, "/") == 0 || !*name ? "" : "/";
  snprintf(w->reason, NSDAE_GUARD_REASON, "%s%s%.40s %s", path, slash, name, why);
  return -1;
}

static hsize_t product(int rank, const hsize_t *length, hsize_t size)
{
  for (int i = 0; i < rank; i++) {
    if (length[i] > 0 && size > ENDLESS / length[i]) return ENDLESS;
    size *= length[i];
  }
  return size;
}

/* How many bytes one that is stored may stand for; 0: a filter that needs a plugin. */
static hsize_t most_of_filters(hid_t plist)
{
  hsize_t most = 1;
  int count = H5Pget_nfilters(plist);
  for (int i = 0; i < count; i++) {
    unsigned flags;
    size_t values = 0;
    H5Z_filter_t filter = H5Pget_filter2(plist, (unsigned)i, &flags, &values, NULL, 0, NULL, NULL);
    if (filter == H5Z_FILTER_DEFLATE)
      most = DEFLATE_MOST;
    else if (filter != H5Z_FILTER_SHUFFLE && filter != H5Z_FILTER_FLETCHER32)
      return 0;
  }
  return count < 0 ? 0 : most;
}

/* Bytes by the shape, or of a chunk if that is more: a chunk is read whole. */
static hsize_t claimed(hid_t set, hid_t plist)
{
  hsize_t length[RANK_MOST], chunk[RANK_MOST];
  hid_t space = H5Dget_space(set), type = H5Dget_type(set);
  hsize_t size = H5Tget_size(type), bytes = ENDLESS;
  int rank = H5Sget_simple_extent_dims(space, length, NULL);
  if (rank >= 0 && size > 0) bytes = product(rank, length, size);
  if (bytes > 0 && H5Pget_layout(plist) == H5D_CHUNKED) {
    hsize_t whole =
        H5Pget_chunk(plist, RANK_MOST, chunk) == rank ? product(rank, chunk, size) : ENDLESS;
    if (whole > bytes) bytes = whole;
  }
  H5Tclose(type);
  H5Sclose(space);
  return bytes;
}

/* A dataset without storage reads as its fill value, and may be as long as the file. */
static const char *look_at_data(const walk *w, hid_t set, hid_t plist)
{
  H5D_layout_t layout = H5Pget_layout(plist);
  hsize_t bytes = claimed(set, plist), stored = H5Dget_storage_size(set);
  hsize_t most = most_of_filters(plist);
  if (H5Pget_external_count(plist) != 0) return "has its data in other files";
  if (layout != H5D_CHUNKED && layout != H5D_CONTIGUOUS && layout != H5D_COMPACT)
    return "is spread over other files";
  if (most == 0) return "is packed by a filter that is not deflate";
  if (layout == H5D_CHUNKED && bytes / most > stored) return "is longer than its data";
  if (layout != H5D_CHUNKED && (bytes > w->length || (stored > 0 && stored < bytes)))
    return "has less data than its shape says";
  return NULL;
}

static int look_at_dataset(const walk *w, hid_t set)
{
  hid_t plist = H5Dget_create_plist(set);
  const char *wrong = look_at_data(w, set, plist);
  H5Pclose(plist);
  return wrong ? refuse_file(w, set, "", wrong) : 0;
}

static herr_t look_at_link(hid_t group, const char *name, const H5L_info_t *link, void *user);

static int look_at_group(walk *w, hid_t group)
{
  if (w->depth == DEPTH_MOST)
    return refuse_file(w, group, "", "is in too many groups, or in itself");
  w->depth++;
  herr_t code = H5Literate(group, H5_INDEX_NAME, H5_ITER_NATIVE, NULL, look_at_link, w);
  w->depth--;
  return code < 0 ? -1 : 0;
}

static herr_t look_at_link(hid_t group, const char *name, const H5L_info_t *link, void *user)
{
  walk *w = user;
  if (link->type != H5L_TYPE_HARD) return refuse_file(w, group, name, "is a soft or external link");
  if (w->links == 0) return refuse_file(w, group, name, "is one of more links than the file has");
  w->links--;
  hid_t item = H5Oopen(group, name, H5P_DEFAULT);
  H5I_type_t kind = H5Iget_type(item);
  int status = item < 0               ? -1
               : kind == H5I_GROUP    ? look_at_group(w, item)
               : kind == H5I_DATASET  ? look_at_dataset(w, item)
               : kind == H5I_DATATYPE ? 0
                                      : -1;
  if (item >= 0) H5Oclose(item);
  return status;
}

int nsdae_h5_guard(hid_t file, hsize_t length, char *reason)
{
  walk w = {.length = length, .links = length / LINK_LEAST, .reason = reason};
  *reason = '\0';
  hid_t root = H5Gopen2(file, "/", H5P_DEFAULT);
  int status = root < 0 ? -1 : look_at_group(&w, root);
  if (root >= 0) H5Gclose(root);
  return status;
}

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
  return on_trial ? guarded(h5) : h5->status;
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
