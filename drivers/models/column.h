/* A column of balls: see column.c. */
#ifndef NSDAE_MODEL_COLUMN_H
#define NSDAE_MODEL_COLUMN_H

#include "driver.h"

typedef struct column {
  int balls;
  double m, ratio, r, mu, e_N, g;
  nsdae_bodies *world;
  double weight, carried, dt; /* [N]; what the floor carried in the last step */
  double fastest;             /* |v| of the last record */
} column;

extern const driver_model column_model;

#endif
