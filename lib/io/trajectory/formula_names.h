/* What the formulas of a simulation's bodies may name, with the coordinates in alphabetical order.
 */
#ifndef NSDAE_IO_NAMES_H
#define NSDAE_IO_NAMES_H

#include <nsdae/sim.h>

#include "formula.h"
#include "hdf5_file.h"

/* parameters: as in nsdae_formula_names. */
void nsdae_names_make(nsdae_formula_names *names, nsdae_h5 *h5, const nsdae_sim *sim,
                      const nsdae_params *parameters);
void nsdae_names_release(nsdae_formula_names *names);

#endif
