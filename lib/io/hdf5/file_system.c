#ifdef __linux__
#define _DEFAULT_SOURCE /* flock */
#define _POSIX_C_SOURCE 200809L
#endif
#include "file_system.h"

#include <errno.h>
#include <fcntl.h>
#include <string.h>

typedef struct transfer {
  int fd;
  unsigned char *into;       /* read */
  const unsigned char *from; /* written */
} transfer;

/* The number of bytes done, 0: end of the file, -errno. */
static long long some(const transfer *t, size_t done, size_t size, uint64_t at);

/* Bytes done before the end of the file, or -errno. */
static long long all(const transfer *t, size_t size, uint64_t at)
{
  size_t done = 0;
  while (done < size) {
    long long more = some(t, done, size - done, at + done);
    if (more == -EINTR) continue;
    if (more < 0) return more;
    if (more == 0) break;
    done += (size_t)more;
  }
  return (long long)done;
}

int nsdae_fs_read(int fd, void *bytes, size_t size, uint64_t at)
{
  const transfer t = {.fd = fd, .into = bytes};
  long long done = all(&t, size, at);
  if (done < 0) return (int)-done;
  memset(t.into + done, 0, size - (size_t)done);
  return 0;
}

int nsdae_fs_write(int fd, const void *bytes, size_t size, uint64_t at)
{
  const transfer t = {.fd = fd, .from = bytes};
  long long done = all(&t, size, at);
  if (done < 0) return (int)-done;
  return (size_t)done < size ? EIO : 0;
}

/* The lock of a program that was killed is there until the system has ended it and its children:
 * for some 10 ms on a busy machine. [ms] */
enum { LOCK_TRIALS = 50, LOCK_PAUSE = 20 };

#ifndef _WIN32

/* ---- POSIX */

#include <sys/file.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

static long long some(const transfer *t, size_t done, size_t size, uint64_t at)
{
  ssize_t more = t->into ? pread(t->fd, t->into + done, size, (off_t)at)
                         : pwrite(t->fd, t->from + done, size, (off_t)at);
  return more < 0 ? -errno : more;
}

int nsdae_fs_open(const char *path, int writing, int create)
{
  /* a pipe does not wait for a writer: it is refused as no regular file */
  const int flags = O_CLOEXEC | O_NONBLOCK;
  int fd = open(path, (writing ? O_RDWR : O_RDONLY) | (create ? O_CREAT : 0) | flags, 0666);
  return fd < 0 ? -errno : fd;
}

int nsdae_fs_lock(int fd, int shared)
{
  const struct timespec pause = {0, LOCK_PAUSE * 1000000L};
  int code = -1;
  for (int i = 0; i < LOCK_TRIALS && code != 0; i++) {
    if (i > 0) nanosleep(&pause, NULL);
    code = flock(fd, (shared ? LOCK_SH : LOCK_EX) | LOCK_NB);
    if (code != 0 && errno != EAGAIN) break;
  }
  if (code == 0) return 0;
  return errno == ENOSYS || errno == ENOTSUP || errno == ENOLCK ? 0 : errno;
}

void nsdae_fs_unlock(int fd)
{
  flock(fd, LOCK_UN);
}

static int identity_of(int code, const struct stat *s, nsdae_fs_identity *identity)
{
  if (code != 0) return errno;
  *identity = (nsdae_fs_identity){.device = (uint64_t)s->st_dev,
                                  .number = (uint64_t)s->st_ino,
                                  .size = (uint64_t)s->st_size,
                                  .regular = S_ISREG(s->st_mode)};
  return 0;
}

int nsdae_fs_identify(int fd, nsdae_fs_identity *identity)
{
  struct stat s;
  return identity_of(fstat(fd, &s), &s, identity);
}

int nsdae_fs_identify_path(const char *path, nsdae_fs_identity *identity)
{
  struct stat s;
  return identity_of(stat(path, &s), &s, identity);
}

int nsdae_fs_reserve(int fd, uint64_t length)
{
#ifdef __APPLE__ /* without posix_fallocate: from the end of the file */
  nsdae_fs_identity now;
  int failure = nsdae_fs_identify(fd, &now);
  if (failure || now.size >= length) return failure;
  fstore_t room = {F_ALLOCATEALL, F_PEOFPOSMODE, 0, (off_t)(length - now.size), 0};
  if (fcntl(fd, F_PREALLOCATE, &room) != 0) return errno;
  return nsdae_fs_truncate(fd, length);
#else
  return posix_fallocate(fd, 0, (off_t)length);
#endif
}

int nsdae_fs_truncate(int fd, uint64_t length)
{
  return ftruncate(fd, (off_t)length) == 0 ? 0 : errno;
}

int nsdae_fs_close(int fd)
{
  return close(fd) == 0 ? 0 : errno;
}

#else

/* ---- Windows */

#include <io.h>
#include <sys/stat.h>
#include <windows.h>

static HANDLE handle_of(int fd)
{
  return (HANDLE)_get_osfhandle(fd);
}

static OVERLAPPED place(uint64_t at)
{
  return (OVERLAPPED){.Offset = (DWORD)at, .OffsetHigh = (DWORD)(at >> 32)};
}

static long long some(const transfer *t, size_t done, size_t size, uint64_t at)
{
  OVERLAPPED o = place(at);
  DWORD more = 0, most = size < 1u << 30 ? (DWORD)size : 1u << 30;
  BOOL well = t->into ? ReadFile(handle_of(t->fd), t->into + done, most, &more, &o)
                      : WriteFile(handle_of(t->fd), t->from + done, most, &more, &o);
  if (well || GetLastError() == ERROR_HANDLE_EOF) return more;
  return GetLastError() == ERROR_DISK_FULL ? -ENOSPC : -EIO;
}

int nsdae_fs_open(const char *path, int writing, int create)
{
  int fd = _open(
      path, (writing ? _O_RDWR : _O_RDONLY) | (create ? _O_CREAT : 0) | _O_BINARY | _O_NOINHERIT,
      _S_IREAD | _S_IWRITE);
  return fd < 0 ? -errno : fd;
}

/* Locks of Windows also stop reads and writes: this one is of a byte that no file has. */
static const uint64_t LOCKED = (uint64_t)1 << 62;

int nsdae_fs_lock(int fd, int shared)
{
  OVERLAPPED o = place(LOCKED);
  DWORD kind = LOCKFILE_FAIL_IMMEDIATELY | (shared ? 0u : LOCKFILE_EXCLUSIVE_LOCK);
  for (int i = 0; i < LOCK_TRIALS; i++) {
    if (i > 0) Sleep(LOCK_PAUSE);
    if (LockFileEx(handle_of(fd), kind, 0, 1, 0, &o)) return 0;
    if (GetLastError() != ERROR_LOCK_VIOLATION) return 0;
  }
  return EAGAIN;
}

void nsdae_fs_unlock(int fd)
{
  OVERLAPPED o = place(LOCKED);
  UnlockFileEx(handle_of(fd), 0, 1, 0, &o);
}

int nsdae_fs_identify(int fd, nsdae_fs_identity *identity)
{
  BY_HANDLE_FILE_INFORMATION i;
  if (!GetFileInformationByHandle(handle_of(fd), &i)) return EIO;
  *identity = (nsdae_fs_identity){.device = i.dwVolumeSerialNumber,
                                  .number = (uint64_t)i.nFileIndexHigh << 32 | i.nFileIndexLow,
                                  .size = (uint64_t)i.nFileSizeHigh << 32 | i.nFileSizeLow,
                                  .regular = GetFileType(handle_of(fd)) == FILE_TYPE_DISK &&
                                             !(i.dwFileAttributes & FILE_ATTRIBUTE_DIRECTORY)};
  return 0;
}

int nsdae_fs_identify_path(const char *path, nsdae_fs_identity *identity)
{
  int fd = nsdae_fs_open(path, 0, 0);
  if (fd < 0) return -fd;
  int failure = nsdae_fs_identify(fd, identity);
  nsdae_fs_close(fd);
  return failure;
}

int nsdae_fs_reserve(int fd, uint64_t length)
{
  nsdae_fs_identity now;
  int failure = nsdae_fs_identify(fd, &now);
  return failure || now.size >= length ? failure : nsdae_fs_truncate(fd, length);
}

int nsdae_fs_truncate(int fd, uint64_t length)
{
  return (int)_chsize_s(fd, (long long)length);
}

int nsdae_fs_close(int fd)
{
  return _close(fd) == 0 ? 0 : errno;
}

#endif
