/* Executor of the runs: one process, or the ranks of MPI. */
#ifndef NSDAE_SWEEP_RANKS_H
#define NSDAE_SWEEP_RANKS_H

#include "sweep_table.h"

/* Callbacks of a run. */
typedef struct ranks_job {
  void *user;
  int width; /* numbers in a row */
  /* Does it: its status, 0 or < 0; row [width]; reason: why it failed. */
  int (*work)(void *user, long run, double *row, char reason[TABLE_REASON_SIZE]);
  /* On rank 0, for every run that is done; < 0 ends it all. */
  int (*take)(void *user, long run, int status, const double *row, const char *reason);
  /* "r=0.01" */
  void (*describe)(void *user, long run, char *text, size_t size);
} ranks_job;

/* Before all else. */
void ranks_begin(int *argc, char ***argv);
int ranks_rank(void);
int ranks_size(void);

/* Not 0 where the program was built with MPI. */
int ranks_available(void);
/* Not 0 where an mpirun, of whatever kind, has started this process. */
int ranks_launched(void);

/* Rank 0 says what all do: how it went so far. */
int ranks_agree(int status);

/* Executes every run of todo [n] (known to rank 0) and passes its result to take. Returns the
 * status of take, or NSDAE_E_INTERRUPTED after a signal. */
int ranks_go(const ranks_job *job, const long *todo, long n);

/* To be called now and then inside a run: rank 0 hears the others. Not 0: end the run. */
int ranks_listen(void *user);

/* After all else; a status < 0 ends the others too. */
void ranks_end(int status);

#endif
