/* The bodies that a trajectory file names, and its group /bodies. */
#ifndef NSDAE_IO_BODIES_H
#define NSDAE_IO_BODIES_H

#include <nsdae/trajectory.h>

#include "formula.h"
#include "hdf5_data.h"

/* NSDAE_OK, or NSDAE_E_ARGUMENT with the first body that is not as the header wants it. */
int nsdae_bodies_check(int n, const nsdae_body *body, const nsdae_formula_names *names,
                       nsdae_error *error);

/* Writes those that passed the check. */
int nsdae_bodies_write(nsdae_h5 *h5, int n, const nsdae_body *body);

#endif
