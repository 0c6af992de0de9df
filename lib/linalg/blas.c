#include "blas.h"

#include <pthread.h>

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

/* OpenBLAS with threads of its own has one number for the process, so what restores it is one, too:
 * the first of several callers sets it, the last restores it, unless the program has set it
 * meanwhile. */
static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static int callers, of_program;

static void enter_process(void)
{
  pthread_mutex_lock(&lock);
  if (callers++ == 0) {
    of_program = openblas_get_num_threads();
    if (of_program > 1) openblas_set_num_threads(1);
  }
  pthread_mutex_unlock(&lock);
}

static void leave_process(void)
{
  pthread_mutex_lock(&lock);
  if (--callers == 0 && of_program > 1 && openblas_get_num_threads() == 1)
    openblas_set_num_threads(of_program);
  pthread_mutex_unlock(&lock);
}

int nsdae_blas_enter(void)
{
  if (openblas_get_parallel() != OPENMP) {
    enter_process();
    return 0;
  }
  int threads = omp_get_max_threads && omp_set_num_threads ? omp_get_max_threads() : 1;
  if (threads > 1) omp_set_num_threads(1);
  return threads > 1 ? threads : 0;
}

void nsdae_blas_leave(int program)
{
  if (openblas_get_parallel() != OPENMP)
    leave_process();
  else if (program > 0)
    omp_set_num_threads(program);
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
