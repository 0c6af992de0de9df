/* The file of a sweep: a dataset for each kept quantity, with a place for every run.
 *
 * It is made at once, whole, with every place; what a run gives is then written where it belongs,
 * its status last. So the file is a whole HDF5 file at any instant, its bytes do not depend on who
 * computed what when, and of a sweep that was killed each run is either there or was not done. */
#ifndef NSDAE_SWEEP_TABLE_H
#define NSDAE_SWEEP_TABLE_H

#include "outputs.h"
#include "sampling.h"

enum { TABLE_REASON_SIZE = 160, TABLE_NOT_DONE = 1 };

/* What the file says of itself. */
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

/* Makes the file, or takes up the one that is there: then *done is [runs], 1 where a run need not
 * be done again. Another sweep's file is NSDAE_E_ARGUMENT. */
int table_open(const char *path, const sweep_plan *plan, const sweep_keep *keep,
               const table_about *about, sweep_table **made, nsdae_error *error);

/* Not 0 where the run is in the file. A run that failed is done again, for its reason. */
int table_has(const sweep_table *t, long run);
/* 1: the file was there and is complete. */
int table_complete(const sweep_table *t);

/* What a run gave; status of the run: 0 or < 0. */
int table_put(sweep_table *t, long run, int status, const double *row, nsdae_error *error);

/* The sweep is done: writes the failures, in the order of runs, and says "complete". */
int table_finish(sweep_table *t, table_failure *failure, long failures, nsdae_error *error);

void table_close(sweep_table **t);

#endif
