/* The second dimensions of a trajectory: which coordinate, velocity, constraint, fixed contact,
 * tangent, frictional joint, side of a listed contact. Each is a dataset of the names, a dimension
 * scale of HDF5, so that tools select by name (in xarray q.sel(coordinate="theta")). */
#ifndef NSDAE_IO_AXES_H
#define NSDAE_IO_AXES_H

#include <nsdae/sim.h>

#include "dataset_table.h"
#include "hdf5_data.h"

/* Makes them in the file of a simulation, by their widths (dataset_table.h). < 0: the model has
 * none of it. */
void nsdae_axes_create(hid_t scale[NSDAE_AXES], nsdae_h5 *h5, const nsdae_sim *sim);

#endif
