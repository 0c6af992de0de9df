#include "safe_read.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#ifdef __linux__
#include <signal.h>
#include <sys/prctl.h>
#endif
#include <unistd.h>

/* Bytes that a program has beside the file's, of which numbers are read as doubles: four times
 * those of a file of bytes, and again in another order; seconds that a small file takes, and bytes
 * of a large one in a second. */
enum {
  BASE_BYTES = 512 << 20,
  BYTES_PER_BYTE = 32,
  BASE_SECONDS = 10,
  BYTES_PER_SECOND = 20 << 20
};

#if defined(__SANITIZE_ADDRESS__)
#define ADDRESS_SANITIZER
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define ADDRESS_SANITIZER
#endif
#endif

static void set_limits(const char *path)
{
  struct stat status = {0};
  struct rlimit most;
  stat(path, &status);
  most.rlim_cur = most.rlim_max = BASE_BYTES + (rlim_t)BYTES_PER_BYTE * (rlim_t)status.st_size;
#ifndef ADDRESS_SANITIZER /* whose own map of the memory is larger than any limit */
  setrlimit(RLIMIT_AS, &most);
#endif
  most.rlim_cur = most.rlim_max = 0;
  setrlimit(RLIMIT_CORE, &most);
  alarm((unsigned)(BASE_SECONDS + status.st_size / BYTES_PER_SECOND));
}

static void in_child(const char *path, probe_fn read_it, void *user, int out)
{
  nsdae_error error;
  memset(&error, 0, sizeof error);
#ifdef __linux__
  prctl(PR_SET_PDEATHSIG, SIGKILL); /* of a killed parent it would keep the lock on the file */
#endif
  set_limits(path);
  fclose(stderr); /* HDF5 prints there */
  error.status = read_it(path, user, &error);
  if (write(out, &error, sizeof error) != sizeof error) _exit(1);
  _exit(0); /* without the exit handlers of HDF5, which may hang */
}

static int came_to_no_end(const char *path, nsdae_error *error)
{
  memset(error, 0, sizeof *error);
  snprintf(error->text, sizeof error->text, "cannot read '%.90s': it is damaged", path);
  snprintf(error->argument, sizeof error->argument, "path");
  return error->status = NSDAE_E_IO;
}

int probe(const char *path, probe_fn read_it, void *user, nsdae_error *error)
{
  int ends[2], state;
  fflush(NULL);
  if (pipe(ends) != 0) return read_it(path, user, error);
  pid_t child = fork();
  if (child == 0) in_child(path, read_it, user, ends[1]);
  close(ends[1]);
  ssize_t got = child < 0 ? 0 : read(ends[0], error, sizeof *error);
  close(ends[0]);
  if (child < 0) return read_it(path, user, error);
  waitpid(child, &state, 0);
  return got == sizeof *error ? error->status : came_to_no_end(path, error);
}

FILE *open_regular(const char *path, const char **why)
{
  struct stat status;
  FILE *file = NULL;
  int fd = open(path, O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  if (fd >= 0 && fstat(fd, &status) == 0 && !S_ISREG(status.st_mode)) {
    *why = S_ISDIR(status.st_mode) ? strerror(EISDIR) : "it must be a regular file";
  } else {
    file = fd >= 0 ? fdopen(fd, "rb") : NULL;
    *why = strerror(errno);
  }
  if (fd >= 0 && !file) close(fd);
  return file;
}
