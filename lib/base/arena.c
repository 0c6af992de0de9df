#include "arena.h"

#include <stdint.h>
#include <stdlib.h>

#include <nsdae/status.h>

enum { ALIGNMENT = 64 }; /* a cache line, and the widest vector register */

void *nsdae_arena_take(nsdae_arena *arena, long count, size_t size)
{
  if (count < 0 || (size_t)count > (SIZE_MAX / 2 - arena->used - ALIGNMENT) / size) {
    arena->overflow = 1;
    return NULL;
  }
  void *start = arena->base ? arena->base + arena->used : NULL;
  size_t bytes = (size_t)count * size;
  arena->used += (bytes + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
  return start;
}

void nsdae_arena_doubles(nsdae_arena *arena, long count, double **const list[])
{
  for (; *list; list++) **list = NSDAE_ARENA_DOUBLES(arena, count);
}

void nsdae_arena_ints(nsdae_arena *arena, long count, int **const list[])
{
  for (; *list; list++) **list = NSDAE_ARENA_INTS(arena, count);
}

static char *aligned_zeros(size_t bytes)
{
  /* calloc and an offset: portable C11, and the pages come zeroed */
  char *raw = calloc(1, bytes + ALIGNMENT + sizeof(void *));
  if (!raw) return NULL;
  uintptr_t first = (uintptr_t)raw + sizeof(void *);
  char *start = raw + sizeof(void *) + (ALIGNMENT - first % ALIGNMENT) % ALIGNMENT;
  ((void **)(void *)start)[-1] = raw;
  return start;
}

int nsdae_arena_build(nsdae_arena *arena, void (*layout)(void *object, nsdae_arena *arena),
                      void *object)
{
  *arena = (nsdae_arena){0};
  return nsdae_arena_fit(arena, layout, object);
}

int nsdae_arena_fit(nsdae_arena *arena, void (*layout)(void *object, nsdae_arena *arena),
                    void *object)
{
  nsdae_arena measured = {0};
  layout(object, &measured);
  if (measured.overflow) return NSDAE_E_MEMORY;
  if (!arena->base || arena->size < measured.used) {
    nsdae_arena_release(arena);
    arena->base = aligned_zeros(measured.used);
    if (!arena->base) return NSDAE_E_MEMORY;
    arena->size = measured.used;
  }
  arena->used = 0;
  layout(object, arena);
  return NSDAE_OK;
}

void nsdae_arena_release(nsdae_arena *arena)
{
  if (arena->base) free(((void **)(void *)arena->base)[-1]);
  *arena = (nsdae_arena){0};
}
