/* A rod that slides and falls, Painleve's example: see falling_rod.c. */
#ifndef NSDAE_MODEL_FALLING_ROD_H
#define NSDAE_MODEL_FALLING_ROD_H

#include "driver.h"

typedef struct falling_rod {
  double m, l, J, g, mu, e_N, p0, v_T, omega, h;
} falling_rod;

extern const driver_model falling_rod_model;

/* a and b of the sliding end's normal acceleration a lambda_N + b at the angle phi, the angular
 * velocity omega and the direction of slip, +1 or -1. */
double falling_rod_coefficient(const falling_rod *p, double phi, int slip);
double falling_rod_free(const falling_rod *p, double phi, double omega);

#endif
