/* A ball above a table: what bouncing_ball and shaken_ball have in common; see table_ball.c. */
#ifndef NSDAE_MODEL_TABLE_BALL_H
#define NSDAE_MODEL_TABLE_BALL_H

#include "driver.h"

/* The first member of a model's parameters. */
typedef struct table_ball table_ball;
struct table_ball {
  double m, e_N, g;
  /* h[0..2] := height of the table [m], its rate and acceleration; NULL: at rest at 0 */
  void (*table)(const table_ball *ball, double t, double h[3]);
};

/* The system, with ball as its user pointer and the table's name for its contact. */
int table_ball_build(table_ball *ball, const char *table_name, nsdae_system **system,
                     nsdae_error *error);

#endif
