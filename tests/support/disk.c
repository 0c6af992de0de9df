#include "disk.h"

#include <errno.h>
#include <signal.h>
#include <stddef.h>
#include <sys/types.h>
#include <unistd.h>

disk the_disk;

ssize_t __real_pwrite(int fd, const void *bytes, size_t size, off_t at);
int __real_ftruncate(int fd, off_t length);
int __real_posix_fallocate(int fd, off_t from, off_t length);
ssize_t __wrap_pwrite(int fd, const void *bytes, size_t size, off_t at);
int __wrap_ftruncate(int fd, off_t length);
int __wrap_posix_fallocate(int fd, off_t from, off_t length);

void disk_reset(int fault, long at, int code)
{
  the_disk = (disk){.at = at, .fault = fault, .code = code};
}

/* The fault that this call meets. */
static int meets(void)
{
  long call = the_disk.calls++;
  if (call == the_disk.at && the_disk.fault == DISK_KILLED) raise(SIGKILL);
  if (call == the_disk.at) return the_disk.fault;
  return call > the_disk.at && the_disk.fault == DISK_FAILS ? DISK_FAILS : DISK_WHOLE;
}

static int fails(int fault)
{
  if (fault == DISK_TORN) raise(SIGKILL); /* not a write: nothing to tear */
  return fault == DISK_FAILS || fault == DISK_FAILS_ONCE;
}

ssize_t __wrap_pwrite(int fd, const void *bytes, size_t size, off_t at)
{
  int fault = meets();
  /* the system copies page by page and looks for signals between them */
  off_t page = (at + (off_t)size - 1) / 4096 * 4096;
  if (fault == DISK_TORN && page > at) __real_pwrite(fd, bytes, (size_t)(page - at), at);
  if (fails(fault)) {
    errno = the_disk.code;
    return -1;
  }
  return __real_pwrite(fd, bytes, size, at);
}

int __wrap_ftruncate(int fd, off_t length)
{
  if (fails(meets())) {
    errno = the_disk.code;
    return -1;
  }
  return __real_ftruncate(fd, length);
}

int __wrap_posix_fallocate(int fd, off_t from, off_t length)
{
  return fails(meets()) ? the_disk.code : __real_posix_fallocate(fd, from, length);
}
