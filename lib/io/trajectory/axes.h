/* The second dimensions of a trajectory: which coordinate, velocity, constraint, contact, tangent,
 * slide, side of a listed contact. Each is a dataset of the names, a dimension scale of HDF5, so
 * that tools select by name (in xarray q.sel(coordinate="theta")). */
#ifndef NSDAE_IO_AXES_H
#define NSDAE_IO_AXES_H

#include <nsdae/sim.h>

#include "hdf5_data.h"
#include "dataset_table.h"

enum { NSDAE_AXES = 7 };

typedef struct nsdae_axes {
  hid_t scale[NSDAE_AXES]; /* < 0: the model has none of it */
} nsdae_axes;

/* None is open. */
void nsdae_axes_init(nsdae_axes *axes);

/* Makes them in the file of a simulation; the groups are there. */
int nsdae_axes_create(nsdae_axes *axes, nsdae_h5 *h5, const nsdae_sim *sim);

/* The scale of a row's dimension i = 0, 1, or < 0. */
hid_t nsdae_axes_of(const nsdae_axes *axes, nsdae_width width, int i);

/* The scales, not the file. */
void nsdae_axes_close(nsdae_axes *axes);

#endif
