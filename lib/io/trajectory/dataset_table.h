/* What a trajectory holds: one table entry per dataset. */
#ifndef NSDAE_IO_TABLE_H
#define NSDAE_IO_TABLE_H

#include <nsdae/sim.h>

/* What the widths of rows follow from. */
typedef struct nsdae_sizes {
  nsdae_dims dims;
  int potential; /* 1: the model gives it */
  int listed;    /* 1: contact list, 0: fixed contacts */
} nsdae_sizes;

void nsdae_sizes_of(nsdae_sizes *sizes, const nsdae_sim *sim);

/* How wide a row is. */
typedef enum nsdae_width {
  NSDAE_WIDTH_ONE, /* plain values */
  NSDAE_WIDTH_POTENTIAL,
  NSDAE_WIDTH_NUMBERED,    /* plain values of fixed contacts */
  NSDAE_WIDTH_LISTED,      /* plain values of a contact list */
  NSDAE_WIDTH_CONTACTS,    /* plain values, where there are contacts of either kind */
  NSDAE_WIDTH_CONSTRAINTS, /* plain values, where there are constraints */
  NSDAE_WIDTH_PAIR,        /* 2, there */
  NSDAE_WIDTH_LISTED_T,    /* nt, there */
  NSDAE_WIDTH_Q,
  NSDAE_WIDTH_V,
  NSDAE_WIDTH_M,
  NSDAE_WIDTH_K,
  NSDAE_WIDTH_KT, /* k x nt */
  NSDAE_WIDTH_T,  /* nt */
  NSDAE_WIDTH_F
} nsdae_width;

/* Types of values, in memory and in the file. */
typedef enum nsdae_value { NSDAE_VALUE_REAL, NSDAE_VALUE_INT, NSDAE_VALUE_LONG } nsdae_value;

typedef struct nsdae_column {
  const char *path;
  size_t offset; /* in the struct of a row */
  int pointer;   /* the field points to the row instead of being it */
  nsdae_value value;
  nsdae_width width;
  const char *units, *description;
} nsdae_column;

typedef struct nsdae_table {
  const nsdae_column *column;
  int columns;
  int counts; /* 1: the length of the first column is the number of rows, and grows last; 0: another
                 table says which rows there are */
  int chunk;  /* most rows of a chunk */
} nsdae_table;

/* A record, and where its contacts begin in the list of all. */
typedef struct nsdae_record_row {
  nsdae_record record;
  long first;
} nsdae_record_row;

/* An impact, with the id of its contact if contacts are listed. */
typedef struct nsdae_impact_row {
  nsdae_impact impact;
  long id;
  int block[2];
} nsdae_impact_row;

/* Rows are nsdae_record_row; the first column is the time. */
extern const nsdae_table nsdae_record_table;
/* Rows are nsdae_impact_row; the first column is the time. */
extern const nsdae_table nsdae_impact_table;
/* Rows are nsdae_change; the first column is the time. */
extern const nsdae_table nsdae_change_table;
/* Rows are those of an nsdae_contact_set, which all its columns point into. */
extern const nsdae_table nsdae_contact_table;

/* Shape of a row behind its first dimension: its rank (0, 1, 2) and sizes, 0: there is none. */
int nsdae_width_shape(nsdae_width width, const nsdae_sizes *sizes, int shape[2]);

#endif
