/* The slider crank with a flexible rod: see flexible_crank.c. */
#ifndef NSDAE_MODEL_FLEXIBLE_CRANK_H
#define NSDAE_MODEL_FLEXIBLE_CRANK_H

#include "published.h"

typedef struct flexible_crank {
  double omega, axial;
  last_record last;
} flexible_crank;

extern const driver_model flexible_crank_model;
extern const published flexible_crank_published;

#endif
