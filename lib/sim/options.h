/* Checking a simulation's options. */
#ifndef NSDAE_SIM_OPTIONS_H
#define NSDAE_SIM_OPTIONS_H

#include <nsdae/sim.h>

/* NSDAE_OK, or NSDAE_E_ARGUMENT naming the first option outside its range. */
int nsdae_sim_options_check(const nsdae_sim_options *options, nsdae_error *error);

/* An option as a number. */
double nsdae_sim_option_value(const nsdae_sim_options *options, const nsdae_param *param);

/* Whether a run of this method depends on it. */
int nsdae_sim_option_matters(const char *key, int method);

#endif
