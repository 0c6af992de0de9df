/* Newton's cradle: see newtons_cradle.c. */
#ifndef NSDAE_MODEL_NEWTONS_CRADLE_H
#define NSDAE_MODEL_NEWTONS_CRADLE_H

#include "driver.h"

enum { NEWTONS_CRADLE_MAX = 16 };

typedef struct newtons_cradle {
  int n;
  double m, L, g, gap, v0, e_N;
} newtons_cradle;

extern const driver_model newtons_cradle_model;

/* Velocities [n] after impact 0, 1, ... of balls that touch where they hang (gap = 0). */
void newtons_cradle_exact(const newtons_cradle *p, int impact, double *v);

#endif
