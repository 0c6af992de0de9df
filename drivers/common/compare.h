/* Comparison of all methods with the reference of the model. */
#ifndef NSDAE_DRIVER_COMPARE_H
#define NSDAE_DRIVER_COMPARE_H

#include "settings.h"

enum { COMPARE_IMPACTS = 64, COMPARE_METHODS = 16 };

/* Result of one run. */
typedef struct comparison_run {
  int status;
  char text[256]; /* why it failed */
  nsdae_stats stats;
  int impacts;
  nsdae_impact impact[COMPARE_IMPACTS];
  /* against the reference; NaN if there is none */
  double first_impulse, first_error, impulse_error, time_error, state_error;
} comparison_run;

/* Runs the model as it is set up now with the settings' options but this method. */
void compare_one(const settings *s, int method, comparison_run *run);

/* NSDAE_OK, or NSDAE_E_STATE after Ctrl-C during a comparison. */
int compare_status(nsdae_error *error);

/* Prints the table of all methods, unless the settings are quiet, and puts it into the trajectory
 * (which may be NULL) as the group /compare; then the additions of the model. */
int compare_all(const settings *s, nsdae_trajectory *trajectory, nsdae_error *error);

#endif
