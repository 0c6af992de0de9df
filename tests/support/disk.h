/* The disk under the library's feet: counts what changes a file, and from some call on fails, or
 * kills the program. A test that uses it is linked with --wrap of the three functions. */
#ifndef NSDAE_TESTS_DISK_H
#define NSDAE_TESTS_DISK_H

#include <stddef.h>

enum disk_fault {
  DISK_WHOLE,
  DISK_FAILS,      /* this call and all after it, with code */
  DISK_FAILS_ONCE, /* this call alone */
  DISK_KILLED,     /* the program ends before this call */
  DISK_TORN        /* it ends in this call, with what came before the last page of it written */
};

typedef struct disk {
  long calls; /* pwrite, ftruncate, posix_fallocate so far */
  long at;    /* the call of this number, from 0 */
  int fault;  /* enum disk_fault */
  int code;   /* errno */
} disk;

extern disk the_disk;

/* The seconds of every clock: a run flushes without being asked if more than 0.25 s have passed
 * since the last record. */
extern double the_disk_clock;

/* From here on. */
void disk_reset(int fault, long at, int code);

/* The calls of a run without a fault: a file as it was before, with the first n of them applied, is
 * that of a program that was killed before call n. In memory that a forked process shares. */
enum { DISK_CALLS = 2048, DISK_BYTES = 1 << 25 };

enum disk_effect { DISK_WRITE, DISK_LENGTH, DISK_ROOM }; /* bytes; a length; at least a length */

typedef struct disk_call {
  int effect;
  long at; /* of the first byte; the length */
  size_t size, from;
} disk_call;

typedef struct disk_log {
  long count;
  size_t used;
  disk_call call[DISK_CALLS];
  unsigned char bytes[DISK_BYTES];
} disk_log;

/* NULL: calls are not noted. */
extern disk_log *the_disk_log;

/* Of a write: the bytes before the last page of it, which it has in one piece; 0 if that is all. */
size_t disk_torn(const disk_call *call);

/* Applies a call to a file; of a write the first `size` bytes. */
void disk_apply(const disk_log *log, long call, size_t size, const char *path);

#endif
