/* Writes that are held back: blocks of bytes with their place in a file. */
#ifndef NSDAE_IO_PENDING_H
#define NSDAE_IO_PENDING_H

#include <stddef.h>
#include <stdint.h>

typedef struct nsdae_block {
  uint64_t at; /* address in the file */
  size_t size;
  int kind; /* the caller's; that of the first write to these bytes */
  long rank;
  unsigned char *bytes;
} nsdae_block;

/* No two blocks have a byte in common: the later write won. */
typedef struct nsdae_pending {
  nsdae_block *block;
  size_t count, room;
} nsdae_pending;

/* Holds a copy of the bytes. 0, or -1 where there is no memory for it and nothing changed. */
int nsdae_pending_add(nsdae_pending *pending, uint64_t at, size_t size, int kind,
                      const void *bytes);

/* Puts what is held of [at, at + size) over what the buffer has from the file. */
void nsdae_pending_overlay(const nsdae_pending *pending, uint64_t at, size_t size, void *buffer);

/* By rank, then by address. */
void nsdae_pending_sort(nsdae_pending *pending);

/* Drops all blocks, keeps the list's memory. */
void nsdae_pending_clear(nsdae_pending *pending);
void nsdae_pending_release(nsdae_pending *pending);

#endif
