/* Checking a simulation's options. */
#ifndef NSDAE_SIM_OPTIONS_H
#define NSDAE_SIM_OPTIONS_H

#include <nsdae/sim.h>

/* NSDAE_OK, or NSDAE_E_ARGUMENT naming the first option outside its range. */
int nsdae_sim_options_check(const nsdae_sim_options *options, nsdae_error *error);

#endif
