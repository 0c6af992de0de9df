#include "allocator.h"

#include <stddef.h>

allocator the_allocator = {.fail_at = -1};

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

static int fails(void)
{
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
