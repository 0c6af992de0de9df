/* A simulation of a model at its start, from the parameters at the model's base. */
#ifndef NSDAE_DRIVER_SIMULATION_H
#define NSDAE_DRIVER_SIMULATION_H

#include "driver.h"

/* Also where it fails, what was made is in *system and *sim, for simulation_release. */
int simulation_make(const driver_model *model, const nsdae_sim_options *options,
                    nsdae_system **system, nsdae_sim **sim, nsdae_error *error);

void simulation_release(nsdae_system **system, nsdae_sim **sim);

/* nsdae_sim_run; NSDAE_E_STATE where it was interrupted. */
int simulation_run(nsdae_sim *sim, double t_end, nsdae_error *error);

#endif
