/* The models that nsdae-sweep knows: those of the drivers. */
#ifndef NSDAE_SWEEP_MODELS_H
#define NSDAE_SWEEP_MODELS_H

#include "driver.h"

extern const driver_model *const models[]; /* ends with NULL */

/* By its name, "pendulum" or "nsdae-pendulum"; NULL: none, and error names the nearest. */
const driver_model *models_find(const char *name, nsdae_error *error);

#endif
