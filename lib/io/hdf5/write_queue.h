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

#endif
