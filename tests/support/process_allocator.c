#define _GNU_SOURCE /* syscall */
#include "process_allocator.h"

process_allocator the_process = {.fail_at = -1};

void process_allocator_reset(long fail_at)
{
  the_process = (process_allocator){.fail_at = fail_at};
}

#if NSDAE_PROCESS_ALLOCATOR

#include <errno.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <unistd.h>

/* A hidden symbol would be seen by the program's own objects alone. */
#define REPLACES __attribute__((visibility("default")))

extern void *__libc_malloc(size_t size);
extern void *__libc_calloc(size_t count, size_t size);
extern void *__libc_realloc(void *old, size_t size);
extern void *__libc_memalign(size_t alignment, size_t size);
extern void __libc_free(void *old);

static int fails(void)
{
  if (the_process.exempt || the_process.calls++ != the_process.fail_at) return 0;
  the_process.failed++;
  errno = ENOMEM;
  return 1;
}

static void *count(void *got)
{
  the_process.live += got != NULL;
  return got;
}

REPLACES void *malloc(size_t size)
{
  return fails() ? NULL : count(__libc_malloc(size));
}

REPLACES void *calloc(size_t number, size_t size)
{
  return fails() ? NULL : count(__libc_calloc(number, size));
}

REPLACES void *realloc(void *old, size_t size)
{
  if (fails()) return NULL;
  return old ? __libc_realloc(old, size) : count(__libc_malloc(size));
}

REPLACES void *aligned_alloc(size_t alignment, size_t size)
{
  return fails() ? NULL : count(__libc_memalign(alignment, size));
}

REPLACES int posix_memalign(void **memory, size_t alignment, size_t size)
{
  *memory = fails() ? NULL : count(__libc_memalign(alignment, size));
  return *memory ? 0 : ENOMEM;
}

REPLACES void free(void *old)
{
  the_process.live -= old != NULL;
  __libc_free(old);
}

REPLACES void *mmap(void *address, size_t length, int protection, int flags, int file, off_t offset)
{
  if (!the_process.exempt) the_process.calls += the_process.fail_at < 0;
  return (void *)syscall(SYS_mmap, address, length, protection, flags, file, offset);
}

#endif

/* weak: none without SUNDIALS */
__attribute__((weak)) int __real_SUNContext_Create(void *comm, void *context);
int __wrap_SUNContext_Create(void *comm, void *context);
__attribute__((weak)) int SUNDIALSGetVersionNumber(int *major, int *minor, int *patch, char *label,
                                                   int length);
__attribute__((weak)) int __real_IDAInit(void *ida, int (*residual)(void), double t, void *y,
                                         void *ydot);
int __wrap_IDAInit(void *ida, int (*residual)(void), double t, void *y, void *ydot);

int __wrap_SUNContext_Create(void *comm, void *context)
{
  the_process.exempt = 1;
  int status = __real_SUNContext_Create(comm, context);
  the_process.exempt = 0;
  return status;
}

int __wrap_IDAInit(void *ida, int (*residual)(void), double t, void *y, void *ydot)
{
  int major, minor, patch;
  char label[16];
  SUNDIALSGetVersionNumber(&major, &minor, &patch, label, sizeof label);
  the_process.exempt = major >= 7;
  int status = __real_IDAInit(ida, residual, t, y, ydot);
  the_process.exempt = 0;
  return status;
}
