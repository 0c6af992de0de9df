/* Common part of the example drivers: command line, run, tables. A driver describes its model and
 * calls driver_main. */
#ifndef NSDAE_DRIVER_H
#define NSDAE_DRIVER_H

#include <nsdae/nsdae.h>

/* One impact of an exact solution. */
typedef struct driver_exact {
  double time, normal_impulse;
} driver_exact;

/* One coordinate of a reference at one time. */
typedef struct driver_state {
  double time, value;
  int coordinate;
} driver_state;

/* A result of a run beside its exact value, or that of a theory. unit: "" is none. */
typedef struct driver_figure {
  const char *name, *unit;
  double value, exact;
} driver_figure;

struct settings;

typedef struct driver_model {
  const char *name;    /* "pendulum": the program is nsdae-pendulum */
  const char *summary; /* one line */
  const nsdae_params *parameters;
  void *base; /* the struct that the table describes; user pointer of the callbacks */
  double t_end;
  double dt;           /* the step by default; 0: the library's */
  int method;          /* by default; enum nsdae_method */
  double contact_work; /* by default; 0: the library's */
  int projection;      /* by default, with implicit-printed and moreau; enum nsdae_projection */
  /* Reads the file of the parameter "file", which the command line names by a plain word. *dt, NULL
   * if the user gave one: its step. NULL: the model has no file. */
  int (*read)(void *base, double *dt, nsdae_error *error);
  /* Makes the system from the parameters at base. */
  int (*build)(void *base, nsdae_system **system, nsdae_error *error);
  /* Fills the start state; both come zeroed. */
  void (*start)(const void *base, double *q0, double *v0);
  /* Names the bodies in the trajectory, once it is made; NULL: none. */
  int (*bodies)(const void *base, nsdae_trajectory *trajectory, nsdae_error *error);
  /* A remark on the table of impacts, or NULL; NULL: none. */
  const char *(*remark)(const void *base);
  /* Exact impact of that number from 0; returns 0 if there is none. NULL: no exact solution. */
  int (*exact)(const void *base, int number, driver_exact *impact);
  /* Reference state of that number, in order of time; returns 0 past the last. NULL: none. */
  int (*state)(const void *base, int number, driver_state *state);
  /* Called with every record of a run; NULL: not needed. */
  void (*follow)(void *base, const nsdae_record *record);
  /* The result that shows best whether a run is right; returns 0 if there is none. NULL: the first
   * impact, the last reference state or the energy, see brief.c. */
  int (*figure)(const void *base, driver_figure *figure);
  /* Prints results beside their references after the summary; NULL: nothing. */
  void (*conclude)(const void *base);
  int coordinates; /* number of coordinates of the reference states, at most 8 */
  /* Additional output of --compare for this model, printed and put into the trajectory (or NULL).
   */
  int (*compare_more)(const struct settings *settings, nsdae_trajectory *trajectory,
                      nsdae_error *error);
} driver_model;

enum { DRIVER_DONE = 0, DRIVER_FAILED = 1, DRIVER_USAGE = 2 };

/* The whole program; returns its exit status. */
int driver_main(const driver_model *model, int argc, char **argv);

#endif
