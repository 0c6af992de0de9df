/* What the models of many bodies share: one world each, and what the ground carries. */
#ifndef NSDAE_MODEL_WORLD_H
#define NSDAE_MODEL_WORLD_H

#include "driver.h"

/* Empties *world and begins it anew, with gravity g downwards and a floor (solid 0, material 0), a
 * half of the plane (y <= 0) or of space (z <= 0); materials 0 and 1 touch each other and 1 itself.
 */
int world_begin(nsdae_bodies **world, int dimension, double g, double mu, double e_N,
                nsdae_error *error);
/* Its system, which the world outlives; status: what the last call said that added to it, which is
 * returned where it is < 0 and the world knows nothing of it. */
int world_end(nsdae_bodies *world, int status, nsdae_system **system, nsdae_error *error);

/* Normal impulse between the bodies and the ground's solids in the step of the record; a model's
 * own contacts are not of them. */
double world_ground_impulse(const nsdae_record *record);

/* The most that any of the record's n velocities is. */
double world_fastest(const nsdae_record *record, int n);

/* Adds a planar block: corners [points x 2] in space, anticlockwise; density 1 kg/m^2 and
 * material 1. Its number, or < 0. */
int world_add_block(nsdae_bodies *world, int points, const double *corner);

#endif
