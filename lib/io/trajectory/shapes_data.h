/* The bodies that a trajectory file names, and its groups /bodies and /shapes. */
#ifndef NSDAE_IO_BODIES_H
#define NSDAE_IO_BODIES_H

#include <nsdae/trajectory.h>

#include "formula.h"
#include "hdf5_data.h"

/* NSDAE_E_ARGUMENT with the first body that is not as the header wants it. */
void nsdae_bodies_check(nsdae_h5 *h5, int n, const nsdae_body *body,
                        const nsdae_formula_names *names);

/* Writes those that passed the check; apart: what is placed by coordinates alone goes to the group
 * /shapes, in numbers. */
void nsdae_bodies_write(nsdae_h5 *h5, int n, const nsdae_body *body,
                        const nsdae_formula_names *names, int apart);

#endif
