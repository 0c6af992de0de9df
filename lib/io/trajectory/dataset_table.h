/* What a trajectory holds: one table entry per dataset. */
#ifndef NSDAE_IO_TABLE_H
#define NSDAE_IO_TABLE_H

#include <nsdae/sim.h>

/* How wide a row is: first those along one axis, of its length (axes.c). */
typedef enum nsdae_width {
  NSDAE_WIDTH_Q,
  NSDAE_WIDTH_V,
  NSDAE_WIDTH_M,
  NSDAE_WIDTH_K, /* fixed contacts */
  NSDAE_WIDTH_T, /* nt, if there are contacts of either kind */
  NSDAE_WIDTH_F,
  NSDAE_WIDTH_PAIR, /* 2, of a contact list */
  NSDAE_AXES,
  NSDAE_WIDTH_ONE = NSDAE_AXES, /* plain values */
  NSDAE_WIDTH_POTENTIAL,
  NSDAE_WIDTH_LIST,       /* plain values of a contact list */
  NSDAE_WIDTH_CONTACTS,   /* plain values, if there are contacts of either kind */
  NSDAE_WIDTH_CONSTRAINTS /* plain values, if there are constraints */
} nsdae_width;

/* What the widths of rows follow from. */
typedef struct nsdae_sizes {
  int axis[NSDAE_AXES]; /* their lengths */
  int potential;        /* 1: the model gives it */
  int varies;           /* 1: contacts vary from step to step, 0: fixed contacts */
} nsdae_sizes;

nsdae_sizes nsdae_sizes_of(const nsdae_sim *sim);

/* Types of values, in memory and in the file. */
typedef enum nsdae_value { NSDAE_VALUE_REAL, NSDAE_VALUE_INT, NSDAE_VALUE_LONG } nsdae_value;

typedef struct nsdae_column {
  const char *path;
  size_t offset; /* in nsdae_row */
  int pointer;   /* the field points to the row instead of being it */
  nsdae_value value;
  nsdae_width width;
  const char *units, *description;
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
  long first; /* where its contacts begin in the list of all */
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

#endif
