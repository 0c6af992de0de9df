/* Everything that a command line or a parameter file can set, in three tables: the model's
 * parameters, the run, the library's options. */
#ifndef NSDAE_DRIVER_SETTINGS_H
#define NSDAE_DRIVER_SETTINGS_H

#include "driver.h"

typedef struct settings {
  const driver_model *model;
  nsdae_sim_options options;
  double t_end;
  char output[NSDAE_PARAM_TEXT_SIZE];                       /* "": none */
  int output_named, projection_named, dt_named, file_named; /* by the user, not by default */
  char restart[NSDAE_PARAM_TEXT_SIZE];  /* "": a new run; else the file that it goes on in */
  int every, compress, contact_forces;  /* of the trajectory */
  char lcp_dump[NSDAE_PARAM_TEXT_SIZE]; /* "": none */
  char friction_dump[NSDAE_PARAM_TEXT_SIZE];
  int friction_step;
  int quiet, live, compare;
  int brief; /* one line; then quiet is set too */
  int help, version;
} settings;

/* The table of what belongs to the run alone. */
extern const nsdae_params settings_run_table;

void settings_default(settings *s, const driver_model *model);

/* Sets a parameter of the model, of the run or of the library, whichever has the name. */
int settings_set(settings *s, const char *name, const char *value, nsdae_error *error);

/* Puts the method into options, with the projection that the model has for it unless the user named
 * one. */
void settings_choose_method(const settings *s, int method, nsdae_sim_options *options);

/* Reads "name = value" lines; '#' and ';' begin comments, [section] lines are for the reader. */
int settings_read(settings *s, const char *path, nsdae_error *error);

/* The command line: the file of --restart first, then parameter files, whatever their place, then
 * the rest in its order. */
int settings_parse(settings *s, int argc, char **argv, nsdae_error *error);

void settings_usage(const settings *s);

#endif
