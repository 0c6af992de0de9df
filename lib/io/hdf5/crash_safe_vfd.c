#include "crash_safe_vfd.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "file_system.h"

/* Several functions of HDF5's driver interface need only some of its arguments. */
#pragma GCC diagnostic ignored "-Wunused-parameter"

/* ---- the file ---- */

/* HDF5 reads a structure once; one that a corrupt file lets refer to itself, for ever. */
enum { READS_MOST = 1 << 20 };

const char *nsdae_vfd_words(int failure)
{
  if (failure == NSDAE_VFD_REPLACED)
    return "another program removed, replaced or changed it while it was written";
  if (failure == NSDAE_VFD_NO_FILE) return "it is not a regular file";
  return failure == EAGAIN ? "another program has it open" : strerror(failure);
}

static int lock(const nsdae_vfd *f)
{
  const char *wanted = getenv("HDF5_USE_FILE_LOCKING");
  if (wanted && (strcmp(wanted, "FALSE") == 0 || strcmp(wanted, "0") == 0)) return 0;
  return nsdae_fs_lock(f->fd, f->reading);
}

static int open_path(nsdae_vfd *f, nsdae_vfd_mode mode)
{
  f->fd = nsdae_fs_open(f->path, mode != NSDAE_VFD_READ, 0);
  if (f->fd == -ENOENT && mode == NSDAE_VFD_REPLACE) {
    f->made = 1;
    f->fd = nsdae_fs_open(f->path, 1, 1);
  }
  return f->fd < 0 ? -f->fd : 0;
}

int nsdae_vfd_open(nsdae_vfd *file, const char *path, nsdae_vfd_mode mode)
{
  nsdae_fs_identity found;
  *file = (nsdae_vfd){.path = path, .reading = mode == NSDAE_VFD_READ};
  int failure = open_path(file, mode);
  if (failure) return failure;
  failure = nsdae_fs_identify(file->fd, &found);
  if (failure == 0 && !found.regular) failure = NSDAE_VFD_NO_FILE;
  if (failure == 0) failure = lock(file);
  if (failure) {
    nsdae_fs_close(file->fd);
    file->fd = -1;
    return failure;
  }
  file->device = found.device;
  file->number = found.number;
  file->budget = READS_MOST;
  file->unready = mode == NSDAE_VFD_REPLACE;
  file->old = found.size;
  if (!file->unready) file->eof = file->committed = file->old;
  return 0;
}

int nsdae_vfd_check(nsdae_vfd *file)
{
  nsdae_fs_identity named;
  unsigned char head[NSDAE_VFD_HEAD];
  if (file->failure || file->head_size == 0) return file->failure;
  int same = nsdae_fs_identify_path(file->path, &named) == 0 && named.device == file->device &&
             named.number == file->number && named.size >= file->committed &&
             nsdae_fs_read(file->fd, head, file->head_size, 0) == 0 &&
             memcmp(head, file->head, file->head_size) == 0;
  if (!same) file->failure = NSDAE_VFD_REPLACED;
  return file->failure;
}

/* Its first bytes hold the address that all else is found from, and the length. */
static void keep_head(nsdae_vfd *f, uint64_t at, size_t size, const void *bytes)
{
  if (at != 0) return;
  f->head_size = size < NSDAE_VFD_HEAD ? size : NSDAE_VFD_HEAD;
  memcpy(f->head, bytes, f->head_size);
}

/* Where a block stands in a commit. Every prefix of this order is a whole file:
 *   the superblock, whose length only grows (the file was made that long before);
 *   blocks behind what the file refers to: nobody sees them yet;
 *   heaps, which only gain: texts of attributes, names of groups;
 *   trees from the root down. A split leaves a new right node (written above) and takes its part
 *     from the left one: once the parent knows of the new node the left one may lose that part;
 *   headers of objects: the lengths of datasets, when all their rows can be found.
 * The first commit makes the file: superblock last, without it nothing is there. */
static long rank_of(const nsdae_vfd *f, const nsdae_block *b)
{
  enum { SUPER, FRESH, TEXTS, NAMES, TREE, LEAF = TREE + 256, HEADER, MADE };
  enum { LEVEL = 5 }; /* byte of a node that says how far it is from the leaves */
  if (b->at == 0) return f->committed ? SUPER : MADE;
  if (b->at >= f->committed) return FRESH;
  if (b->kind == H5FD_MEM_GHEAP) return TEXTS;
  if (b->kind == H5FD_MEM_LHEAP) return NAMES;
  if (b->kind != H5FD_MEM_BTREE) return HEADER;
  return b->size > LEVEL && memcmp(b->bytes, "TREE", 4) == 0 ? TREE + 255 - b->bytes[LEVEL] : LEAF;
}

/* The disk has room for the whole of a new file before the old one of that name is touched. */
static int reserve_disk(nsdae_vfd *f)
{
  static const unsigned char nothing[8];
  nsdae_fs_identity now;
  if (f->committed == 0) {
    int failure = nsdae_fs_reserve(f->fd, f->eoa);
    return failure || f->old == 0 ? failure : nsdae_fs_write(f->fd, nothing, sizeof nothing, 0);
  }
  int failure = nsdae_fs_identify(f->fd, &now);
  return failure || now.size >= f->eoa ? failure : nsdae_fs_truncate(f->fd, f->eoa);
}

int nsdae_vfd_reserve(nsdae_vfd *file, uint64_t bytes)
{
  if (file->failure) return file->failure;
  uint64_t length = file->eoa + bytes;
  int failure = length > file->reserved ? nsdae_fs_reserve(file->fd, length) : 0;
  if (failure == 0 && length > file->reserved) file->reserved = length;
  return failure;
}

static int write_pending(nsdae_vfd *f)
{
  nsdae_write_queue *p = &f->pending;
  for (size_t i = 0; i < p->count; i++) p->block[i].rank = rank_of(f, &p->block[i]);
  nsdae_write_queue_sort(p);
  for (size_t i = 0; i < p->count; i++) {
    const nsdae_block *b = &p->block[i];
    int failure = nsdae_fs_write(f->fd, b->bytes, b->size, b->at);
    if (failure) return failure;
    keep_head(f, b->at, b->size, b->bytes);
  }
  return 0;
}

/* What is held stays where that fails: HDF5 goes on reading what it wrote. */
static void commit(nsdae_vfd *f)
{
  if (f->reading || f->unready || nsdae_vfd_check(f) != 0) return;
  if (f->pending.count > 0) f->failure = reserve_disk(f);
  if (f->failure == 0) f->failure = write_pending(f);
  if (f->failure) return;
  f->committed = f->eoa;
  nsdae_write_queue_clear(&f->pending);
}

/* To what the file refers to, which after a failure may be more than was committed; a file that
 * never came to be leaves the old one as it was, as does one that was not to be resumed. */
static void trim(nsdae_vfd *f)
{
  uint64_t length = f->committed ? f->committed : f->old;
  if ((f->failure || f->unready) && f->committed) return;
  int failure = nsdae_fs_truncate(f->fd, length);
  if (f->failure == 0) f->failure = failure;
}

int nsdae_vfd_close(nsdae_vfd *file)
{
  if (file->fd < 0) return 0;
  /* not before: HDF5 1.10 reads the driver's class once more after it gave up its own hold on it */
  if (file->driver > 0) H5FDunregister(file->driver);
  file->driver = 0;
  commit(file);
  if (!file->reading && file->failure != NSDAE_VFD_REPLACED) trim(file);
  if (file->made && file->committed == 0) remove(file->path);
  int failure = nsdae_fs_close(file->fd);
  if (file->failure == 0 && !file->reading) file->failure = failure;
  file->fd = -1;
  nsdae_write_queue_release(&file->pending);
  return file->failure;
}

/* ---- the driver: what HDF5 calls ---- */

static nsdae_vfd *file_of(H5FD_t *own)
{
  return (nsdae_vfd *)(void *)own;
}

static H5FD_t *driver_open(const char *name, unsigned flags, hid_t access, haddr_t most)
{
  nsdae_vfd *const *file = H5Pget_driver_info(access); /* of which HDF5 has a copy */
  if (!file) return NULL;
  (*file)->own = (H5FD_t){0};
  return &(*file)->own;
}

/* nsdae_vfd_close does it. */
static herr_t driver_close(H5FD_t *own)
{
  return 0;
}

static herr_t driver_query(const H5FD_t *own, unsigned long *flags)
{
  /* without H5FD_FEAT_ACCUMULATE_METADATA: each block comes for itself, with its kind */
  *flags = H5FD_FEAT_AGGREGATE_METADATA | H5FD_FEAT_DATA_SIEVE | H5FD_FEAT_AGGREGATE_SMALLDATA |
           H5FD_FEAT_SUPPORTS_SWMR_IO | H5FD_FEAT_DEFAULT_VFD_COMPATIBLE;
  return 0;
}

static haddr_t driver_get_eoa(const H5FD_t *own, H5FD_mem_t kind)
{
  return ((const nsdae_vfd *)(const void *)own)->eoa;
}

static herr_t driver_set_eoa(H5FD_t *own, H5FD_mem_t kind, haddr_t at)
{
  file_of(own)->eoa = at;
  return 0;
}

static haddr_t driver_get_eof(const H5FD_t *own, H5FD_mem_t kind)
{
  return ((const nsdae_vfd *)(const void *)own)->eof;
}

static herr_t driver_read(H5FD_t *own, H5FD_mem_t kind, hid_t transfer, haddr_t at, size_t size,
                          void *buffer)
{
  nsdae_vfd *f = file_of(own);
  if (f->reading && (at + size > f->eof || --f->budget < 0)) return -1;
  if (nsdae_fs_read(f->fd, buffer, size, at) != 0) return -1;
  nsdae_write_queue_overlay(&f->pending, at, size, buffer);
  return 0;
}

static herr_t driver_write(H5FD_t *own, H5FD_mem_t kind, hid_t transfer, haddr_t at, size_t size,
                           const void *bytes)
{
  nsdae_vfd *f = file_of(own);
  int rows = kind == H5FD_MEM_DRAW && (f->committed > 0 || at >= f->old);
  if (at + size > f->eof) f->eof = at + size;
  if (f->failure == 0 && (rows || f->direct)) {
    f->failure = nsdae_fs_write(f->fd, bytes, size, at);
    if (f->failure == 0) {
      keep_head(f, at, size, bytes);
      return 0;
    }
  }
  if (!rows && nsdae_write_queue_add(&f->pending, at, size, kind, bytes) < 0 && f->failure == 0)
    f->failure = ENOMEM;
  return 0;
}

static herr_t driver_flush(H5FD_t *own, hid_t transfer, hbool_t closing)
{
  commit(file_of(own));
  return 0;
}

static herr_t driver_truncate(H5FD_t *own, hid_t transfer, hbool_t closing)
{
  nsdae_vfd *f = file_of(own);
  f->eof = f->eoa;
  return 0;
}

/* The lock was taken when the file was opened. */
static herr_t driver_lock(H5FD_t *own, hbool_t writing)
{
  return 0;
}

/* Before the file is closed this lets the readers of SWMR in. */
static herr_t driver_unlock(H5FD_t *own)
{
  nsdae_vfd *f = file_of(own);
  if (f->direct) nsdae_fs_unlock(f->fd);
  return 0;
}

static const H5FD_class_t driver = {
#ifdef H5FD_CLASS_VERSION
    .version = H5FD_CLASS_VERSION,
    .value = (H5FD_class_value_t)600,
#endif
    .name = "nsdae",
    .maxaddr = (haddr_t)INT64_MAX,
    .fc_degree = H5F_CLOSE_STRONG,
    .fapl_size = sizeof(nsdae_vfd *),
    .open = driver_open,
    .close = driver_close,
    .query = driver_query,
    .get_eoa = driver_get_eoa,
    .set_eoa = driver_set_eoa,
    .get_eof = driver_get_eof,
    .read = driver_read,
    .write = driver_write,
    .flush = driver_flush,
    .truncate = driver_truncate,
    .lock = driver_lock,
    .unlock = driver_unlock,
    .fl_map = H5FD_FLMAP_DICHOTOMY,
};

/* What is written in place after it was made lies in one page of memory, and is there whole or not
 * at all when the program is killed: nodes of trees, of 2 to 3 KiB, begin where a page does. */
enum { ALIGNED_FROM = 1024, PAGE = 4096 };

hid_t nsdae_vfd_access(nsdae_vfd *file)
{
  hid_t access = H5Pcreate(H5P_FILE_ACCESS);
  file->driver = H5FDregister(&driver);
  herr_t code = H5Pset_driver(access, file->driver, &file);
  if (code >= 0 && !file->reading) code = H5Pset_alignment(access, ALIGNED_FROM, PAGE);
  /* a file that is closed is closed, whatever was left open in it: HDF5 must not come back to us */
  if (code >= 0) code = H5Pset_fclose_degree(access, H5F_CLOSE_STRONG);
  if (code >= 0) return access;
  H5Pclose(access);
  return -1;
}

/* ---- write queue */

static uint64_t end_of(const nsdae_block *b)
{
  return b->at + b->size;
}

/* The block that has all of [at, at + size), or NULL. */
static nsdae_block *holder(const nsdae_write_queue *p, uint64_t at, size_t size)
{
  for (size_t i = 0; i < p->count; i++)
    if (p->block[i].at <= at && at + size <= end_of(&p->block[i])) return &p->block[i];
  return NULL;
}

/* Takes [at, end) out of the blocks; none of them has all of it. */
static void make_way(nsdae_write_queue *p, uint64_t at, uint64_t end)
{
  for (size_t i = p->count; i-- > 0;) {
    nsdae_block *b = &p->block[i];
    if (end_of(b) <= at || end <= b->at) continue;
    if (at <= b->at && end_of(b) <= end) {
      free(p->block[i].bytes);
      p->block[i] = p->block[--p->count];
    } else if (b->at < at) {
      b->size = (size_t)(at - b->at);
    } else {
      size_t cut = (size_t)(end - b->at);
      memmove(b->bytes, b->bytes + cut, b->size - cut);
      b->at += cut;
      b->size -= cut;
    }
  }
}

static int grow(nsdae_write_queue *p)
{
  if (p->count < p->room) return 0;
  size_t room = 2 * p->room + 64;
  nsdae_block *more = realloc(p->block, room * sizeof *more);
  if (!more) return -1;
  p->block = more;
  p->room = room;
  return 0;
}

int nsdae_write_queue_add(nsdae_write_queue *pending, uint64_t at, size_t size, int kind,
                          const void *bytes)
{
  nsdae_block *old = holder(pending, at, size);
  if (old) {
    memcpy(old->bytes + (at - old->at), bytes, size);
    return 0;
  }
  unsigned char *copy = malloc(size);
  if (!copy || grow(pending) < 0) {
    free(copy);
    return -1;
  }
  make_way(pending, at, at + size);
  memcpy(copy, bytes, size);
  pending->block[pending->count++] =
      (nsdae_block){.at = at, .size = size, .kind = kind, .bytes = copy};
  return 0;
}

void nsdae_write_queue_overlay(const nsdae_write_queue *pending, uint64_t at, size_t size,
                               void *buffer)
{
  uint64_t end = at + size;
  for (size_t i = 0; i < pending->count; i++) {
    const nsdae_block *b = &pending->block[i];
    uint64_t from = b->at > at ? b->at : at, to = end_of(b) < end ? end_of(b) : end;
    if (from < to)
      memcpy((unsigned char *)buffer + (from - at), b->bytes + (from - b->at), (size_t)(to - from));
  }
}

static int compare_blocks(const void *one, const void *other)
{
  const nsdae_block *a = one, *b = other;
  if (a->rank != b->rank) return a->rank < b->rank ? -1 : 1;
  return a->at < b->at ? -1 : a->at > b->at;
}

void nsdae_write_queue_sort(nsdae_write_queue *pending)
{
  if (pending->count > 0)
    qsort(pending->block, pending->count, sizeof *pending->block, compare_blocks);
}

void nsdae_write_queue_clear(nsdae_write_queue *pending)
{
  for (size_t i = 0; i < pending->count; i++) free(pending->block[i].bytes);
  pending->count = 0;
}

void nsdae_write_queue_release(nsdae_write_queue *pending)
{
  nsdae_write_queue_clear(pending);
  free(pending->block);
  *pending = (nsdae_write_queue){0};
}
