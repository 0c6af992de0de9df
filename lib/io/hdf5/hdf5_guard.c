#include "hdf5_guard.h"

#include <stdio.h>
#include <string.h>

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
