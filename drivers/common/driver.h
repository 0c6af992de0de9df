/* What the example drivers share: command line, run, tables. A driver describes its model and
 * hands it to driver_main. */
#ifndef NSDAE_DRIVER_H
#define NSDAE_DRIVER_H

#include <nsdae/nsdae.h>

/* One impact as an exact solution has it. */
typedef struct driver_exact {
  double time, normal_impulse;
} driver_exact;

/* One coordinate at one time as a reference has it. */
typedef struct driver_state {
  double time, value;
  int coordinate;
} driver_state;

struct settings;

typedef struct driver_model {
  const char *name;    /* "pendulum": the program is nsdae-pendulum */
  const char *summary; /* one line */
  const nsdae_params *parameters;
  void *base; /* the struct that the table describes; user pointer of the callbacks */
  double t_end;
  double dt;          /* the step by default; 0: the library's */
  int method;         /* by default; enum nsdae_method */
  double contact_tol; /* by default; 0: the library's */
  int projection;     /* by default, with implicit-printed and moreau; enum nsdae_projection */
  /* Makes the system from the parameters at base. */
  int (*build)(void *base, nsdae_system **system, nsdae_error *error);
  /* Fills the start state; both come zeroed. */
  void (*start)(const void *base, double *q0, double *v0);
  /* Names the bodies in the trajectory, once it is made; NULL: none. */
  int (*bodies)(const void *base, nsdae_trajectory *trajectory, nsdae_error *error);
  /* What a reader of the table would stumble over, in one sentence, or NULL; NULL: nothing. */
  const char *(*remark)(const void *base);
  /* Exact impact of that number from 0; returns 0 where there is none. NULL: nothing is known. */
  int (*exact)(const void *base, int number, driver_exact *impact);
  /* Reference state of that number, in the order of time; returns 0 past the last. NULL: none. */
  int (*state)(const void *base, int number, driver_state *state);
  /* Sees every record of a run; NULL: need not. */
  void (*follow)(void *base, const nsdae_record *record);
  /* Prints behind the summary what came out beside what is known of it; NULL: nothing. */
  void (*conclude)(const void *base);
  int coordinates; /* how many coordinates the reference states may speak of, at most 8 */
  /* What --compare has to add for this model, printed and put into the trajectory (or NULL). */
  int (*compare_more)(const struct settings *settings, nsdae_trajectory *trajectory,
                      nsdae_error *error);
} driver_model;

enum { DRIVER_DONE = 0, DRIVER_FAILED = 1, DRIVER_USAGE = 2 };

/* The whole program; returns its exit status. */
int driver_main(const driver_model *model, int argc, char **argv);

#endif
