#include "crash_safe_vfd.h"

#include <stdlib.h>
#include <string.h>

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
