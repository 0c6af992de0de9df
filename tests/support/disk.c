#include "disk.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <time.h>
#include <unistd.h>

disk the_disk;
disk_log *the_disk_log;
double the_disk_clock = 1e9;

int __wrap_timespec_get(struct timespec *now, int base);

int __wrap_timespec_get(struct timespec *now, int base)
{
  (void)base;
  *now = (struct timespec){.tv_sec = (time_t)the_disk_clock};
  return base;
}

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

static void note(int effect, off_t at, const void *bytes, size_t size)
{
  disk_log *log = the_disk_log;
  if (!log) return;
  if (log->count == DISK_CALLS || size > DISK_BYTES - log->used) abort();
  log->call[log->count++] = (disk_call){effect, (long)at, size, log->used};
  if (size > 0) memcpy(log->bytes + log->used, bytes, size);
  log->used += size;
}

/* The system copies page by page and looks for signals between them. */
static size_t before_last_page(off_t at, size_t size)
{
  off_t page = (at + (off_t)size - 1) / 4096 * 4096;
  return page > at ? (size_t)(page - at) : 0;
}

size_t disk_torn(const disk_call *call)
{
  return call->effect == DISK_WRITE ? before_last_page(call->at, call->size) : 0;
}

void disk_apply(const disk_log *log, long number, size_t size, const char *path)
{
  const disk_call *call = &log->call[number];
  struct stat now;
  int fd = open(path, O_RDWR), failed = fd < 0 || fstat(fd, &now) != 0;
  if (!failed && call->effect == DISK_WRITE)
    failed = __real_pwrite(fd, log->bytes + call->from, size, call->at) != (ssize_t)size;
  else if (!failed && (call->effect == DISK_LENGTH || now.st_size < call->at))
    failed = __real_ftruncate(fd, call->at) != 0;
  if (failed) {
    perror(path);
    abort();
  }
  close(fd);
}

ssize_t __wrap_pwrite(int fd, const void *bytes, size_t size, off_t at)
{
  int fault = meets();
  size_t torn = before_last_page(at, size);
  if (fault == DISK_TORN && torn > 0) __real_pwrite(fd, bytes, torn, at);
  if (fails(fault)) {
    errno = the_disk.code;
    return -1;
  }
  note(DISK_WRITE, at, bytes, size);
  return __real_pwrite(fd, bytes, size, at);
}

int __wrap_ftruncate(int fd, off_t length)
{
  if (fails(meets())) {
    errno = the_disk.code;
    return -1;
  }
  note(DISK_LENGTH, length, NULL, 0);
  return __real_ftruncate(fd, length);
}

int __wrap_posix_fallocate(int fd, off_t from, off_t length)
{
  if (fails(meets())) return the_disk.code;
  note(DISK_ROOM, from + length, NULL, 0);
  return __real_posix_fallocate(fd, from, length);
}
