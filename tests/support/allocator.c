#include "allocator.h"

#include <stddef.h>

allocator the_allocator = {.fail_at = -1};
call_places the_allocations;

void *__real_malloc(size_t size);
void *__real_calloc(size_t count, size_t size);
void *__real_realloc(void *old, size_t size);
void __real_free(void *old);
void *__wrap_malloc(size_t size);
void *__wrap_calloc(size_t count, size_t size);
void *__wrap_realloc(void *old, size_t size);
void __wrap_free(void *old);

void allocator_reset(long fail_at)
{
  the_allocator = (allocator){.fail_at = fail_at};
}

void allocator_list(int addresses)
{
  the_allocator = (allocator){.fail_at = -1, .listing = addresses};
  the_allocations.count = 0;
}

__attribute__((noinline)) static int fails(void)
{
  if (the_allocator.listing && the_allocations.count < CALL_PLACES)
    the_allocations.at[the_allocations.count++] = call_place(the_allocator.listing);
  return the_allocator.calls++ == the_allocator.fail_at;
}

static void *count(void *got)
{
  the_allocator.live += got != NULL;
  return got;
}

void *__wrap_malloc(size_t size)
{
  return fails() ? NULL : count(__real_malloc(size));
}

void *__wrap_calloc(size_t number, size_t size)
{
  return fails() ? NULL : count(__real_calloc(number, size));
}

void *__wrap_realloc(void *old, size_t size)
{
  if (fails()) return NULL;
  if (!old) return count(__real_realloc(old, size));
  return __real_realloc(old, size);
}

void __wrap_free(void *old)
{
  the_allocator.live -= old != NULL;
  __real_free(old);
}
