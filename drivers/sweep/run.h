/* Settings of a sweep, and one run of it. */
#ifndef NSDAE_SWEEP_JOB_H
#define NSDAE_SWEEP_JOB_H

#include "progress.h"
#include "outputs.h"
#include "sampling.h"
#include "settings.h"
#include "sweep_table.h"

typedef struct job {
  settings settings; /* of the driver */
  sweep_plan plan;
  sweep_keep keep;
  int processes; /* 0: as many as there are cores */
  char *base;    /* fixed parameters, a copy of settings.model->base */
  size_t base_size;
  double period; /* of the samples */
} job;

/* Keeps the driver's parameters for every run and the sizes of the model. Each varied parameter
 * must exist. The model of the first run is made, so that an error of all runs is reported once. */
int job_prepare(job *j, nsdae_error *error);

/* Run number run: its status, 0 or < 0; row [keep.width]. */
int job_run(job *j, long run, double *row, char reason[TABLE_REASON_SIZE]);

/* All that the results depend on, as lines "key=value"; the caller frees it. NULL: no memory. */
char *job_setting(const job *j);

void job_release(job *j);

#endif
