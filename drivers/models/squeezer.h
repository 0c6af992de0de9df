/* Andrews' squeezing mechanism: see squeezer.c. */
#ifndef NSDAE_MODEL_SQUEEZER_H
#define NSDAE_MODEL_SQUEEZER_H

#include "published.h"

typedef struct squeezer {
  double torque, stiffness, rest;
  last_record last;
} squeezer;

extern const driver_model squeezer_model;
extern const published squeezer_published;

#endif
