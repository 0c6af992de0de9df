/* The maker of a system, as the kit of rigid bodies: it knows the rows by its own words, and which
 * derivatives are its own formulas. Where there is none the system is the user's alone. */
#ifndef NSDAE_BASE_MAKER_H
#define NSDAE_BASE_MAKER_H

#include <stddef.h>

#include <nsdae/sim.h>

/* A state. */
typedef struct nsdae_moved {
  const double *q, *v;
} nsdae_moved;

/* Quantities that are read from a record. Rotations that count their turns, `angles`, are followed
 * from step to step. */
typedef struct nsdae_maker_sensors {
  int count, angles;
  int (*size)(const void *of, int i); /* number of values, at most NSDAE_VALUES_MAX */
  /* The angles after a step of length h from those before it; before NULL: at the start, `to`. */
  void (*follow)(const void *of, const nsdae_moved *from, const nsdae_moved *to, double h,
                 const double *before, double *angle);
  /* linear [3 count]: impulse of each contact of the record on the block of the larger number, in
   * its first velocities */
  void (*sense)(const void *of, int i, const nsdae_record *record, const double *linear,
                const double *angle, double *value);
  /* nsdae_sim_get_contact_forces */
  void (*contact_forces)(const void *of, const nsdae_record *record, const double *linear,
                         double *point, double *force);
} nsdae_maker_sensors;

/* Why a callback has no value at a point. */
typedef struct nsdae_reason {
  const char *element; /* "joint", "spring", "load", "contact" */
  int index;
  char text[512];
} nsdae_reason;

/* Last argument of the callbacks of its system: what was made, and the controls. Those of a
 * simulation are its own. */
typedef struct nsdae_maker_user {
  const void *of;
  const double *control;
  int rows; /* position motors are frictional joints, and no forces: time stepping */
} nsdae_maker_user;

/* A position motor: F = -kp e - kd e', |F| <= limit, of the error e. */
typedef struct nsdae_gains {
  double kp, kd, limit;
} nsdae_gains;

/* Two bodies that may pass through each other in a step. */
typedef struct nsdae_tunnelling {
  long contact;      /* its number, or its id in a list; -1: none */
  double way, least; /* by which its gap closes in the step; that is reported */
} nsdae_tunnelling;

/* Bodies that spin, with omega' = a = J^-1 (J omega x omega) of no torque. Motion across a steady
 * spin turns with Omega in the axes of the body. */
typedef struct nsdae_spin {
  double across; /* its energy, a J a / (2 Omega^2), of all bodies */
  double gain;   /* a J a / 2 of all: what a step h of Euler's rule makes of it, over h^2 */
  double rate;   /* |omega| of the body with the largest energy across */
  int body;      /* that; -1: there is none */
} nsdae_spin;

typedef struct nsdae_maker {
  const void *of; /* handed to each; owned by the system */
  void (*release)(const void *of);
  /* Whether the derivatives of row i of a kind (enum nsdae_name_kind) are the maker's formulas. */
  int (*exact)(const void *of, int kind, int i);
  /* The element of row i: "revolute joint 2 of bodies 0, 1". A contact of a list by its id. 0:
   * none.
   */
  int (*words)(const void *of, int kind, long i, char *text, size_t size);
  /* The first element that is degenerate at the point for that callback, or whose drive has wrong
   * derivatives for "drive": 1; 0: none. */
  int (*explain)(const void *of, const char *callback, double t, const double *q, const double *v,
                 nsdae_reason *reason);
  /* NSDAE_OK, or why methods other than time stepping cannot have the system. */
  int (*check_rates)(const void *of, nsdae_error *error);
  int controls;
  const double *control; /* [controls] at first */
  /* NULL, or why a simulation cannot set control i. */
  const char *(*fixed)(const void *of, int i);
  int turns; /* a contact of the list may have a rotation as its gap */
  nsdae_maker_sensors sensors;
  /* Whether frictional joint j is a position motor, with its gains; the errors e [f] of these, 0 or
   * what a drive returned. */
  int (*position)(const void *of, int j, nsdae_gains *gains);
  int (*errors)(double t, const double *q, double *e, const void *user);
  /* The fastest of these contacts whose gaps close in a step h by more than a share of the widths
   * of both bodies. NSDAE_OK or NSDAE_E_MEMORY. */
  int (*tunnelling)(const double *q, const double *v, double h, double share,
                    nsdae_tunnelling *worst, const void *user);
  /* Whether a contact may get deeper in h than the slop, by these velocities. */
  int (*may_enter)(const double *v, double h, const void *user);
  /* Whether an element is too stiff for a step h of time stepping: the worst; or NULL. */
  int (*stiff)(const double *q, const double *v, double h, nsdae_reason *reason, const void *user);
  int (*idle)(const void *of); /* whether it has no force and no drive at all */
  void (*spin)(const double *v, nsdae_spin *spin, const void *user); /* NULL: of the plane */
} nsdae_maker;

/* Whether the caller reads omega of the contacts: time stepping does not, and a long list is filled
 * without it. */
int nsdae_contact_list_reads_omega(const nsdae_contact_list *list);

/* Adds the contacts of passes 0 .. count - 1 to the list in the order of the passes, on the threads
 * of the simulation: `add` hands those of pass i to nsdae_contact_add. Returns 0; negative if a
 * pass did, the first one with its record. */
typedef int nsdae_contact_pass(void *to, nsdae_contact_list *list, int i);
int nsdae_contact_list_share(nsdae_contact_list *list, int count, nsdae_contact_pass *add,
                             void *to);

void nsdae_system_set_maker(nsdae_system *system, const nsdae_maker *maker);

#endif
