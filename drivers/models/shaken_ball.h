/* A ball on a shaking table: see shaken_ball.c. */
#ifndef NSDAE_MODEL_SHAKEN_BALL_H
#define NSDAE_MODEL_SHAKEN_BALL_H

#include "table_ball.h"

typedef struct shaken_ball {
  table_ball ball;
  double gamma, T, kick;
} shaken_ball;

extern const driver_model shaken_ball_model;

/* Amplitude of the table [m]. */
double shaken_ball_amplitude(const shaken_ball *p);

/* Bounds of gamma between which it bounces once a period, stably. */
void shaken_ball_stable(const shaken_ball *p, double *low, double *high);

#endif
