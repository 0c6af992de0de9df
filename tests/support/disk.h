/* The disk under the library's feet: counts what changes a file, and from some call on fails, or
 * kills the program. A test that uses it is linked with --wrap of the three functions. */
#ifndef NSDAE_TESTS_DISK_H
#define NSDAE_TESTS_DISK_H

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

/* From here on. */
void disk_reset(int fault, long at, int code);

#endif
