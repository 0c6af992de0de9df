#define _POSIX_C_SOURCE 200809L
#include "reserve.h"

#include <errno.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

static off_t length(int fd)
{
  struct stat status;
  return fstat(fd, &status) == 0 ? status.st_size : 0;
}

int nsdae_reserve_try(const char *path, long bytes)
{
  int fd = open(path, O_RDWR | O_CREAT | O_CLOEXEC, 0666);
  if (fd < 0) return errno;
  off_t before = length(fd);
  int failure = posix_fallocate(fd, before, bytes);
  if (ftruncate(fd, before) != 0 && failure == 0) failure = errno;
  close(fd);
  return failure;
}

int nsdae_reserve(const char *path, long bytes)
{
  int fd = open(path, O_RDWR | O_CLOEXEC);
  if (fd < 0) return errno;
  int failure = posix_fallocate(fd, 0, bytes);
  close(fd);
  return failure;
}

long nsdae_reserve_length(const char *path)
{
  struct stat status;
  return stat(path, &status) == 0 ? (long)status.st_size : -1;
}
