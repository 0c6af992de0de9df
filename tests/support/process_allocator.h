/* malloc and its family replaced for the whole process, shared libraries included: every call is
 * counted, and one of them can be made to fail. Linked by a test where NSDAE_PROCESS_ALLOCATOR is
 * 1: with glibc, and where no sanitizer has malloc.
 *
 * The calls of two functions are exempt. SUNContext_Create of SUNDIALS 6.4.1 does not look whether
 * its logger's table was allocated (sundials_logger.c, SUNLogger_Create), and follows the null
 * pointer. IDAInit of 7.1.1 loses one or two blocks if the second or third of its Newton iteration
 * is not to be had (SUNNonlinSolNewEmpty, SUNNonlinSol_Newton): 6.4.1 frees them. */
#ifndef NSDAE_TESTS_PROCESS_ALLOCATOR_H
#define NSDAE_TESTS_PROCESS_ALLOCATOR_H

#include <stdlib.h> /* __GLIBC__ */

#if defined(__SANITIZE_ADDRESS__)
#define NSDAE_SANITIZED 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define NSDAE_SANITIZED 1
#endif
#endif

#if defined(__GLIBC__) && !defined(NSDAE_SANITIZED)
#define NSDAE_PROCESS_ALLOCATOR 1
#else
#define NSDAE_PROCESS_ALLOCATOR 0
#endif

typedef struct process_allocator {
  volatile long calls;   /* allocations asked for, mmap included, while none is exempt */
  volatile long live;    /* blocks allocated and not freed */
  volatile long fail_at; /* the number, from 0, of the call that fails; -1: none */
  volatile long failed;  /* calls that did */
  volatile int exempt;   /* calls are neither counted nor failed */
} process_allocator;

extern process_allocator the_process;

/* Counts from 0 again. mmap is counted and never fails: the libraries do not call it, threads and
 * BLAS do. */
void process_allocator_reset(long fail_at);

#endif
