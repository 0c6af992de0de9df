/* The file of a sweep: a dataset for each kept quantity, with a place for every run.
 *
 * It is created complete, with a place for every run. The results of a run are written to its
 * place, its status last. The file is therefore valid at any time, its bytes do not depend on the
 * order of completion, and after a kill each run is either complete or pending. */
#ifndef NSDAE_SWEEP_TABLE_H
#define NSDAE_SWEEP_TABLE_H

#include "outputs.h"
#include "sampling.h"

enum { TABLE_REASON_SIZE = 160, TABLE_NOT_DONE = 1 };

/* Attributes of the file. */
typedef struct table_about {
  const char *model, *method;
  const char *setting;            /* all that the results depend on, as text: lines "key=value" */
  const nsdae_system *system;     /* for names and units */
  const nsdae_params *parameters; /* of the model, for units */
} table_about;

/* A run that failed. */
typedef struct table_failure {
  long run;
  char reason[TABLE_REASON_SIZE];
} table_failure;

typedef struct sweep_table sweep_table;

/* Creates the file, or opens an existing one: then *done is [runs], 1 for completed runs. The file
 * of another sweep is NSDAE_E_ARGUMENT. */
int table_open(const char *path, const sweep_plan *plan, const sweep_keep *keep,
               const table_about *about, sweep_table **made, nsdae_error *error);

/* Not 0 if the run is in the file. A failed run is repeated, for its reason. */
int table_has(const sweep_table *t, long run);
/* 1: the file was there and is complete. */
int table_complete(const sweep_table *t);

/* Results of a run; status of the run: 0 or < 0. */
int table_put(sweep_table *t, long run, int status, const double *row, nsdae_error *error);

/* Ends the sweep: writes the failures in order of runs and sets the status "complete". */
int table_finish(sweep_table *t, table_failure *failure, long failures, nsdae_error *error);

void table_close(sweep_table **t);

#endif
