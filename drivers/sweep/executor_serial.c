/* Built without MPI: one process. */
#include "executor.h"

#include <stdlib.h>

#include "interrupt_signal.h"

void ranks_begin(int *argc, char ***argv)
{
  (void)argc;
  (void)argv;
}

int ranks_rank(void)
{
  return 0;
}

int ranks_size(void)
{
  return 1;
}

int ranks_available(void)
{
  return 0;
}

int ranks_launched(void)
{
  return 0;
}

int ranks_agree(int status)
{
  return status;
}

int ranks_go(const ranks_job *job, const long *todo, long n)
{
  double *row = malloc((size_t)job->width * sizeof *row);
  int status = row ? NSDAE_OK : NSDAE_E_MEMORY;
  for (long i = 0; i < n && status >= 0; i++) {
    char reason[TABLE_REASON_SIZE] = "";
    int ended = job->work(job->user, todo[i], row, reason);
    status =
        interrupt_came() ? NSDAE_E_INTERRUPTED : job->take(job->user, todo[i], ended, row, reason);
  }
  free(row);
  return status;
}

int ranks_listen(void *user)
{
  (void)user;
  return interrupt_came();
}

void ranks_end(int status)
{
  (void)status;
}
