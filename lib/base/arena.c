#include "arena.h"

#include <nsdae/status.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

/* ---- dynamic array */

int nsdae_arrays_grow(const nsdae_array *arrays, size_t count, size_t room)
{
  for (size_t i = 0; i < count; i++) {
    void *array; /* pointers to objects of all types look alike wherever this is built */
    memcpy(&array, arrays[i].at, sizeof array);
    if (arrays[i].entry > 0 && room > SIZE_MAX / 2 / arrays[i].entry) return NSDAE_E_MEMORY;
    void *grown = realloc(array, room * arrays[i].entry + 1);
    if (!grown) return NSDAE_E_MEMORY;
    memcpy(arrays[i].at, &grown, sizeof grown);
  }
  return NSDAE_OK;
}

void nsdae_arrays_release(const nsdae_array *arrays, size_t count)
{
  for (size_t i = 0; i < count; i++) {
    void *array;
    memcpy(&array, arrays[i].at, sizeof array);
    free(array);
    memset(arrays[i].at, 0, sizeof array);
  }
}

enum { ALIGNMENT = 64 }; /* a cache line, and the widest vector register */

static size_t aligned(size_t bytes)
{
  return (bytes + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
}

/* The next array of a layout: counted, noted, or copied from the block of before. */
static void note(nsdae_arena_log *log, void *start, size_t bytes)
{
  size_t *had = log->bytes ? &log->bytes[log->count] : NULL;
  log->count++;
  if (!had) return;
  if (!log->from) *had = bytes;
  if (!log->from || !start) return;
  if (*had > 0) memcpy(start, log->from + log->at, *had < bytes ? *had : bytes);
  log->at += aligned(*had);
}

void *nsdae_arena_take(nsdae_arena *arena, long count, size_t size)
{
  if (count < 0 || (size_t)count > (SIZE_MAX / 2 - arena->used - ALIGNMENT) / size) {
    arena->overflow = 1;
    return NULL;
  }
  void *start = arena->base ? arena->base + arena->used : NULL;
  size_t bytes = (size_t)count * size;
  arena->used += aligned(bytes);
  if (arena->log) note(arena->log, start, bytes);
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

/* The layout over a block that is there. */
static void lay_over(nsdae_arena *arena, void (*layout)(void *object, nsdae_arena *arena),
                     void *object, nsdae_arena_log *log)
{
  arena->used = 0;
  arena->log = log;
  layout(object, arena);
  arena->log = NULL;
}

int nsdae_arena_resize(nsdae_arena *arena, void (*layout)(void *object, nsdae_arena *arena),
                       void (*change)(void *object, int back), void *object, nsdae_arena *old)
{
  nsdae_arena_log log = {0};
  nsdae_arena larger = {0};
  lay_over(arena, layout, object, &log);
  log.bytes = malloc((log.count + 1) * sizeof *log.bytes);
  log.count = 0;
  if (log.bytes) lay_over(arena, layout, object, &log);
  change(object, 0);
  lay_over(&larger, layout, object, NULL);
  larger.base = log.bytes && !larger.overflow ? aligned_zeros(larger.used) : NULL;
  larger.size = larger.used;
  *old = *arena;
  *arena = larger;
  log = (nsdae_arena_log){.bytes = log.bytes, .from = old->base};
  if (arena->base)
    lay_over(arena, layout, object, &log);
  else
    nsdae_arena_restore(arena, layout, change, object, old);
  free(log.bytes);
  return log.count > 0 ? NSDAE_OK : NSDAE_E_MEMORY;
}

void nsdae_arena_restore(nsdae_arena *arena, void (*layout)(void *object, nsdae_arena *arena),
                         void (*change)(void *object, int back), void *object, nsdae_arena *old)
{
  change(object, 1);
  nsdae_arena_release(arena);
  *arena = *old;
  *old = (nsdae_arena){0};
  lay_over(arena, layout, object, NULL);
}
