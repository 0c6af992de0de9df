/* A table of growing datasets, buffered: rows are kept until a chunk is full or a flush is due. */
#ifndef NSDAE_IO_SERIES_H
#define NSDAE_IO_SERIES_H

#include <nsdae/sim.h>
#include "hdf5_data.h"

/* ---- dataset_table.c: What a trajectory holds: one table entry per dataset. */

/* How wide a row is: first those along one axis, of its length (series.c). */
typedef enum nsdae_width {
  NSDAE_WIDTH_Q,
  NSDAE_WIDTH_V,
  NSDAE_WIDTH_M,
  NSDAE_WIDTH_K, /* fixed contacts */
  NSDAE_WIDTH_T, /* nt, if there are contacts of either kind */
  NSDAE_WIDTH_F,
  NSDAE_WIDTH_PAIR, /* 2, of a contact list */
  NSDAE_WIDTH_TWO,  /* components of sensors and forces, if there is one with as many */
  NSDAE_WIDTH_THREE,
  NSDAE_WIDTH_FOUR,
  NSDAE_AXES,
  NSDAE_WIDTH_ONE = NSDAE_AXES, /* plain values */
  NSDAE_WIDTH_POTENTIAL,
  NSDAE_WIDTH_LIST,        /* plain values of a contact list */
  NSDAE_WIDTH_CONTACTS,    /* plain values, if there are contacts of either kind */
  NSDAE_WIDTH_CONSTRAINTS, /* plain values, if there are constraints */
  NSDAE_WIDTH_FORCE        /* vectors [3] of contacts, if their forces are recorded */
} nsdae_width;

/* What the widths of rows follow from. */
typedef struct nsdae_sizes {
  int axis[NSDAE_AXES]; /* their lengths */
  int potential;        /* 1: the model gives it */
  int varies;           /* 1: contacts vary from step to step, 0: fixed contacts */
  int forces;           /* 1: points and forces of contacts are recorded */
} nsdae_sizes;

nsdae_sizes nsdae_sizes_of(const nsdae_sim *sim, int forces);

/* Types of values, in memory and in the file. */
typedef enum nsdae_value { NSDAE_VALUE_REAL, NSDAE_VALUE_INT, NSDAE_VALUE_LONG } nsdae_value;

typedef struct nsdae_column {
  const char *path;
  size_t offset; /* in nsdae_row */
  int pointer;   /* the field points to the row instead of being it */
  nsdae_value value;
  nsdae_width width;
  const char *units, *description; /* "N s|N m s": of displacements, of rotations */
} nsdae_column;

typedef struct nsdae_table {
  const nsdae_column *column;
  int columns;
  const char *scale; /* name of the first column as a dimension */
  int counts; /* 1: the length of the first column is the number of rows, and grows last; 0: another
                 table says which rows there are */
  int packed; /* the option compress is for it; the others are short */
  int by_contact; /* 1: a row is one contact of a list, or all fixed contacts of a record */
} nsdae_table;

/* What the columns are taken from. */
typedef struct nsdae_row {
  nsdae_record record;
  long first;                  /* where its contacts begin in the list of all */
  const double *point, *force; /* of its contacts, [3] each; NULL: not recorded */
  nsdae_impact impact;
  nsdae_change change;
} nsdae_row;

/* The tables of a file. The columns of contacts point into record.contacts. */
enum { NSDAE_RECORDS, NSDAE_IMPACTS, NSDAE_CHANGES, NSDAE_CONTACTS, NSDAE_TABLES };
extern const nsdae_table nsdae_tables[NSDAE_TABLES];

/* Shape of a row behind its first dimension: its rank (0, 1, 2), sizes, 0: there is none, and along
 * which axes it is. */
int nsdae_table_shape(const nsdae_table *table, nsdae_width width, const nsdae_sizes *sizes,
                      int shape[2], int axis[2]);
/* Most rows of a chunk. */
int nsdae_table_chunk(const nsdae_table *table, const nsdae_sizes *sizes);
/* Rows of the table of contacts that a record has. */
int nsdae_contact_rows(const nsdae_record *record);

/* ---- series.c */

/* Rows that are kept of a first column that counts, for it is written at flushes only; of the
 * others as many as a chunk of the datasets has. */
enum { NSDAE_SERIES_ROWS_MAX = 16 * 1024 };

/* A column whose rows are not empty. */
typedef struct nsdae_series_column {
  const nsdae_column *of;
  int rank, shape[2], axis[2]; /* of a row */
  size_t bytes;                /* of a row */
  char *buffer;
  hid_t set; /* < 0: not open */
} nsdae_series_column;

typedef struct nsdae_series {
  const nsdae_table *table;
  nsdae_series_column *column;
  int columns;
  hsize_t chunk;         /* rows, so that no column has a chunk of more than some MiB */
  hsize_t written, held; /* rows in the file, rows in the buffers; except in a column that counts */
  hsize_t counted;       /* rows of the first column in the file, if it counts, else 0 */
  int deflate;           /* as in nsdae_h5_layout; of packed rows whole chunks go to the file */
} nsdae_series;

/* Allocates for the table's rows; NSDAE_E_MEMORY. Columns whose rows are empty stay out. compress:
 * the option. */
int nsdae_series_init(nsdae_series *series, const nsdae_table *table, const nsdae_sizes *sizes,
                      int compress);
void nsdae_series_release(nsdae_series *series);

/* Makes the datasets. The scale of their rows is `rows`, or the first of them if rows < 0; those of
 * the other dimensions are the axes. */
void nsdae_series_create(nsdae_series *series, nsdae_h5 *h5, const nsdae_system *system,
                         const hid_t axes[NSDAE_AXES], hid_t rows);

/* Opens the datasets of a file, which must have the table's shapes; the rows of the shortest. */
hsize_t nsdae_series_open(nsdae_series *series, nsdae_h5 *h5);
/* Continues behind this number of rows, whatever the file has. */
void nsdae_series_resume(nsdae_series *series, hsize_t rows);
/* Drops what the file has behind the rows that are written, of the first column and then of the
 * others. */
void nsdae_series_cut(nsdae_series *series, nsdae_h5 *h5);

/* Adds rows `from` and on of those at `row` to the buffers; as many as given, or those up to the
 * end of a chunk, if that is less: how many they were. Fields that are the row itself have the one,
 * 0.
 */
int nsdae_series_append(nsdae_series *series, const nsdae_row *row, int from, int rows);
/* Whether the rows so far end where a chunk does. */
int nsdae_series_ends_chunk(const nsdae_series *series);

/* Rows so far, in the file and in the buffers. */
hsize_t nsdae_series_rows(const nsdae_series *series);
/* Back to fewer rows: the next one takes the place of the first that is dropped. */
void nsdae_series_rewind(nsdae_series *series, hsize_t rows);

typedef enum nsdae_series_part {
  NSDAE_SERIES_CHUNKS, /* of packed rows only whole chunks */
  NSDAE_SERIES_ALL
} nsdae_series_part;

/* Writes the rows held, without the first column. */
void nsdae_series_write(nsdae_series *series, nsdae_h5 *h5, nsdae_series_part part);
/* Writes the first column up to the rows that are written. */
void nsdae_series_count(nsdae_series *series, nsdae_h5 *h5);
/* No row more before nsdae_series_count. */
int nsdae_series_is_full(const nsdae_series *series);
/* What the file may grow by when the rows held are written: whole chunks, and HDF5's own records of
 * them. */
long nsdae_series_held_bytes(const nsdae_series *series);

/* ---- The second dimensions of a trajectory: which coordinate, velocity, constraint, fixed
 * contact, tangent, frictional joint, side of a listed contact. Each is a dataset of the names, a
 * dimension scale of HDF5, so that tools select by name (in xarray q.sel(coordinate="theta")). */

/* Makes them in the file of a simulation, by their widths (dataset_table.c). < 0: the model has
 * none of it. */
void nsdae_axes_create(hid_t scale[NSDAE_AXES], nsdae_h5 *h5, const nsdae_system *system,
                       const nsdae_sizes *sizes);

#endif
