#ifndef _WIN32
#define _POSIX_C_SOURCE 200809L
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#endif

#include "regular_file.h"

FILE *nsdae_regular_file(const char *path, const char **why)
{
  *why = "is there such a file?";
#ifdef _WIN32
  return fopen(path, "rb");
#else
  struct stat s;
  int fd = open(path, O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  if (fd < 0) return NULL;
  int regular = fstat(fd, &s) == 0 && S_ISREG(s.st_mode);
  FILE *file = regular ? fdopen(fd, "rb") : NULL;
  if (!regular) *why = "it must be a regular file";
  if (!file) close(fd);
  return file;
#endif
}
