/* Calls of BLAS and LAPACK by one thread: NSDAE_ALONE(cblas_dgemm(...)). The matrices of a step are
 * too small for several, which would wait for each other and spin between two calls. The number of
 * threads of the program is restored after each call. */
#ifndef NSDAE_LINALG_BLAS_H
#define NSDAE_LINALG_BLAS_H

#include <cblas.h>
#include <lapacke.h>

#define NSDAE_ALONE(call)             \
  do {                                \
    int program = nsdae_blas_enter(); \
    call;                             \
    nsdae_blas_leave(program);        \
  } while (0)

/* Threads of the calling thread's team to be restored; 0: none. */
int nsdae_blas_enter(void);
void nsdae_blas_leave(int program);

#endif
