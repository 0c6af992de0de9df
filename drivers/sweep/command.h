/* The command line of nsdae-sweep: its own words, and those of the driver. */
#ifndef NSDAE_SWEEP_COMMAND_H
#define NSDAE_SWEEP_COMMAND_H

#include "run.h"

enum { COMMAND_GO = 0, COMMAND_HELP = 1, COMMAND_VERSION = 2 };

/* COMMAND_..., or < 0. */
int command_parse(job *j, int argc, char **argv, nsdae_error *error);

void command_usage(void);

#endif
