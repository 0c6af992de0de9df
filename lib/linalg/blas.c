#include "blas.h"

#include <stdatomic.h>

#ifdef NSDAE_OPENBLAS

int openblas_get_parallel(void);
int openblas_get_num_threads(void);
void openblas_set_num_threads(int threads);

/* Of an OpenBLAS built with OpenMP: those of the calling thread, NULL without OpenMP. The builds of
 * OpenBLAS replace each other at run time. */
#ifdef __ELF__
extern int omp_get_max_threads(void) __attribute__((weak));
extern void omp_set_num_threads(int threads) __attribute__((weak));
#else
static int (*const omp_get_max_threads)(void) = 0;
static void (*const omp_set_num_threads)(int) = 0;
#endif

enum { OPENMP = 2 }; /* of openblas_get_parallel */

/* OpenBLAS with threads of its own has one number for the process, so what restores it is one, too.
 * The first of several callers sets it, the last restores it, unless the program has set it
 * meanwhile. Whatever their order, the last restores what the first found; a caller between two
 * others may have several threads. */
static atomic_int callers, of_program;

int nsdae_blas_enter(void)
{
  if (openblas_get_parallel() == OPENMP) {
    int threads = omp_get_max_threads && omp_set_num_threads ? omp_get_max_threads() : 1;
    if (threads > 1) omp_set_num_threads(1);
    return threads > 1 ? threads : 0;
  }
  if (atomic_fetch_add(&callers, 1) > 0) return 0;
  int threads = openblas_get_num_threads();
  if (threads <= 1) return 0;
  atomic_store(&of_program, threads);
  openblas_set_num_threads(1);
  return 0;
}

void nsdae_blas_leave(int program)
{
  if (openblas_get_parallel() == OPENMP) {
    if (program > 0) omp_set_num_threads(program);
    return;
  }
  if (atomic_fetch_sub(&callers, 1) > 1) return;
  int threads = atomic_exchange(&of_program, 0);
  if (threads > 1 && openblas_get_num_threads() == 1) openblas_set_num_threads(threads);
}

#else /* others have no threads, or no way to set them for one caller */

int nsdae_blas_enter(void)
{
  return 0;
}

void nsdae_blas_leave(int program)
{
  (void)program;
}

#endif
