/* The hinge with clearance: see clearance_hinge.c. */
#ifndef NSDAE_MODEL_CLEARANCE_HINGE_H
#define NSDAE_MODEL_CLEARANCE_HINGE_H

#include "driver.h"

enum clearance_slip { SURFACE_SLIP, HINGE_ANGLE };

typedef struct clearance_hinge {
  double l, m, R, r, mu, dX, dY, theta_0, e_N, e_T, g;
  int slip; /* enum clearance_slip */
} clearance_hinge;

extern const driver_model clearance_hinge_model;

#endif
