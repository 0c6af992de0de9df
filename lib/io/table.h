/* What a trajectory holds: one table entry per dataset. */
#ifndef NSDAE_IO_TABLE_H
#define NSDAE_IO_TABLE_H

#include <nsdae/sim.h>

/* How wide a row is. */
typedef enum nsdae_width {
  NSDAE_WIDTH_ONE, /* plain values */
  NSDAE_WIDTH_Q,
  NSDAE_WIDTH_V,
  NSDAE_WIDTH_M,
  NSDAE_WIDTH_K,
  NSDAE_WIDTH_KT, /* k x nt */
  NSDAE_WIDTH_T,  /* nt */
  NSDAE_WIDTH_F
} nsdae_width;

typedef struct nsdae_column {
  const char *path;
  size_t offset; /* in nsdae_record, nsdae_impact or nsdae_change */
  int pointer;   /* the field points to the row instead of being it */
  int integer;   /* int, else double */
  nsdae_width width;
  const char *units, *description;
} nsdae_column;

typedef struct nsdae_table {
  const nsdae_column *column;
  int columns;
} nsdae_table;

/* Rows are nsdae_record; the first column is the time. */
extern const nsdae_table nsdae_record_table;
/* Rows are nsdae_impact; the first column is the time. */
extern const nsdae_table nsdae_impact_table;
/* Rows are nsdae_change; the first column is the time. */
extern const nsdae_table nsdae_change_table;

/* Shape of a row behind its first dimension: its rank (0, 1, 2) and sizes. */
int nsdae_width_shape(nsdae_width width, const nsdae_dims *dims, int shape[2]);

#endif
