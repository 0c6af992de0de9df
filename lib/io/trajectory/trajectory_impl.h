/* What a trajectory is made of. */
#ifndef NSDAE_IO_TRAJECTORY_IMPL_H
#define NSDAE_IO_TRAJECTORY_IMPL_H

#include <nsdae/trajectory.h>

#include "checkpoint.h"
#include "series.h"

/* The data sets /sensor/NAME: columns of the table of records, of each sensor that has a name. */
typedef struct nsdae_sensor_columns {
  nsdae_table table; /* of records, with sensors behind the others */
  nsdae_column *column;
  char *path;     /* of the sensors, one after another */
  nsdae_row *row; /* what the columns are taken from; values of sensors are behind it */
} nsdae_sensor_columns;

/* Points and forces of the contacts of a record, [3] each, if they are recorded. */
typedef struct nsdae_contact_columns {
  double *point, *force;
  int room; /* contacts */
} nsdae_contact_columns;

/* The rows of a file. */
typedef struct nsdae_trajectory_rows {
  nsdae_series series[NSDAE_TABLES];
  long every;                   /* records of such steps are kept */
  long step;                    /* of the last record that was seen */
  hsize_t before[NSDAE_TABLES]; /* rows without it */
  int extra;                /* 1: the last row is the end of a run whose step would not be kept */
  int extra_contacts;       /* that it has in the list */
  double flushed, appended; /* when */
  long committed;           /* records that the file has whatever happens now */
} nsdae_trajectory_rows;

struct nsdae_trajectory {
  nsdae_sim *sim;
  nsdae_h5 h5;
  char *path;
  nsdae_params parameters; /* the model's */
  int live, compress;
  int begun;  /* a record came: what is made in a file is made before */
  int bodies; /* were named in place of the system's */
  int resumed;
  nsdae_sizes sizes;
  nsdae_trajectory_rows rows;
  nsdae_sensor_columns sensors;
  nsdae_contact_columns contacts;
  nsdae_checkpoint checkpoint;
  int failed; /* status of a write that failed: nothing is written any more */
};

/* ---- trajectory.c */

/* A trajectory whose file `open` makes or opens, to the observers and the caller; or nothing, and
 * the status of what failed. where: the public function. */
int nsdae_trajectory_start(nsdae_sim *sim, const char *path, const nsdae_trajectory_info *info,
                           nsdae_trajectory **trajectory, nsdae_error *error, const char *where,
                           void (*open)(nsdae_trajectory *, const nsdae_trajectory_info *));

/* ---- trajectory_rows.c */

/* Memory of the rows; forces: of contacts are recorded. NSDAE_E_MEMORY, NSDAE_E_ARGUMENT: the
 * system has no solids. */
void nsdae_trajectory_allocate_rows(nsdae_trajectory *t, int forces);
void nsdae_trajectory_release_rows(nsdae_trajectory *t);

/* A record as it comes. */
void nsdae_trajectory_take(nsdae_trajectory *t, const nsdae_record *record);
/* The last state is kept in any case; a run that continues there has its row where it belongs. */
void nsdae_trajectory_append_last(nsdae_trajectory *t);
/* The state of the simulation, where all its records are in the file. */
void nsdae_trajectory_write_state(nsdae_trajectory *t);
/* The rows, and then how many there are: killed in between, a program leaves columns that are
 * longer than the first of their table, never shorter. */
void nsdae_trajectory_write_rows(nsdae_trajectory *t, nsdae_series_part part);
/* All rows that are written, as rows of the file. */
void nsdae_trajectory_count_rows(nsdae_trajectory *t);

/* ---- sensors as data sets */

/* NSDAE_OK or NSDAE_E_MEMORY. */
int nsdae_sensor_columns_init(nsdae_sensor_columns *columns, const nsdae_sim *sim);
void nsdae_sensor_columns_release(nsdae_sensor_columns *columns);

/* The values of the sensors at the record that the simulation shows. */
int nsdae_sensor_columns_read(nsdae_sensor_columns *columns, nsdae_sim *sim);

#endif
