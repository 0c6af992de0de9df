/* Results of a run: a row of numbers, in columns. */
#ifndef NSDAE_SWEEP_KEEP_H
#define NSDAE_SWEEP_KEEP_H

#include <nsdae/nsdae.h>

enum { KEEP_COLUMNS_MAX = 32 };

/* A quantity: [rows][columns] numbers of the row, each 0 where it has no such dimension. */
typedef struct keep_column {
  const char *path; /* of its dataset */
  int rows, columns;
  const char *unit, *description;
  const char *scale; /* of its columns: "coordinate", "velocity"; NULL: none */
  int offset;        /* in the row */
} keep_column;

typedef struct keep {
  int final, statistics, extremes;
  int impacts;        /* number of last impacts; 0: none */
  int samples;        /* number of last samples; 0: none */
  double period;      /* of the samples [s] */
  char period_of[64]; /* or the parameter that it is */
  nsdae_dims dims;
  keep_column column[KEEP_COLUMNS_MAX];
  int columns, width; /* width: numbers in a row */
} sweep_keep;

/* Adds "final", "statistics", "extremes", "impacts=N" or "samples=N@PERIOD", where PERIOD is a
 * number or a parameter. */
int keep_add(sweep_keep *k, const char *word, nsdae_error *error);

/* When everything is added and the sizes of the model are known. */
int keep_complete(sweep_keep *k, const nsdae_dims *dims, nsdae_error *error);

int keep_size(const keep_column *c);

/* Observer that collects the row of one run. */
typedef struct keeper {
  const sweep_keep *keep;
  nsdae_sim *sim;
  double *row;
  double t_end, period;
  int sampled; /* samples taken so far */
  long hits;   /* impacts so far */
} keeper;

/* Before the run: the row is all NaN. */
void keeper_begin(keeper *k, const sweep_keep *what, nsdae_sim *sim, double t_end, double period,
                  double *row);
int keeper_observe(const nsdae_record *record, nsdae_error *error, void *user);
/* After it. */
void keeper_end(keeper *k);

#endif
