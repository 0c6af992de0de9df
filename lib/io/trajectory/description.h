/* What a trajectory file says of the run: attributes of the root, options, parameters. */
#ifndef NSDAE_IO_DESCRIPTION_H
#define NSDAE_IO_DESCRIPTION_H

#include <nsdae/trajectory.h>

#include "hdf5_data.h"

/* Writes it into a new file. */
void nsdae_description_write(nsdae_h5 *h5, const nsdae_sim *sim, const nsdae_trajectory_info *info);

/* The attribute status of the root, of a run that returned run_status. */
void nsdae_description_set_ended(nsdae_h5 *h5, int run_status);

#endif
