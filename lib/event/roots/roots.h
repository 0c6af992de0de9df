/* The functions whose falls through zero end a phase, each above zero while its mode holds:
 *
 *   normal     open: g_N, the gap closes;  closed: F_N, the contact lets go
 *   tangent    sliding: d . v_T, it stops; with two directions d is that after the last step
 *              sticking: mu F_N - |F_T|, friction is used up
 *   held       closed by other contacts alone: tolerance of positions - |g_N|, it leaves zero
 *   sign       of a frictional joint: s lambda, lambda changes sign
 *   slip       of a frictional joint: as tangent, with v_S and mu |lambda| - |F_S|
 *   jam        of the phase: det A / det A(t_0) of its border, whose zeros are those of the forces'
 *              poles: forces are without bound (Painleve's paradox); with relations that less 1/2,
 *              as relations that lie along what they leave open have a pole, too: new ones are due
 *   change     of the phase: smallest sine of the constraints - width: a change point is near;
 *              while it is crossed 3/2 width - that sine (change_point.h)
 *
 * One that is zero at the start of a phase would be found there again and again. With a known rate
 * r > 0 it is divided by t - t_0, which makes it r at t_0 and leaves its further zeros where they
 * are (what rounding left at t_0 is taken off); without, it is lifted by the tolerance
 * until it has left zero. */
#ifndef NSDAE_EVENT_ROOTS_H
#define NSDAE_EVENT_ROOTS_H

#include "phase.h"

typedef enum nsdae_root_kind {
  NSDAE_ROOT_NORMAL, /* of contact `index` */
  NSDAE_ROOT_TANGENT,
  NSDAE_ROOT_HELD,
  NSDAE_ROOT_SIGN, /* of slide `index` */
  NSDAE_ROOT_SLIP,
  NSDAE_ROOT_JAM, /* of the phase */
  NSDAE_ROOT_CHANGE
} nsdae_root_kind;

typedef enum nsdae_root_state {
  NSDAE_ROOT_OFF,    /* has nothing to say in this phase */
  NSDAE_ROOT_LIVE,   /* above zero */
  NSDAE_ROOT_RISING, /* zero at `since` with a known rate: divided by t - since it is above */
  NSDAE_ROOT_MASKED  /* zero to rounding: lifted above until it has left zero */
} nsdae_root_state;

typedef struct nsdae_event_root {
  nsdae_root_kind kind;
  int index;
  nsdae_root_state state;
  int found;                 /* an instant is here for it */
  int moved;                 /* it was above the tolerance */
  double since, start, rate; /* of one that is rising: when, from what rounding left, how fast; of
                                the phase: log |det A|, its sign */
  double size;               /* the tolerance */
} nsdae_event_root;

typedef struct nsdae_event_roots {
  nsdae_event_phase *phase;
  int count;
  nsdae_event_root *entry; /* count: kind by kind */
  double *at;              /* n: y with the forces of its q and v */
  int short_steps;         /* of the phase up to here */
} nsdae_event_roots;

void nsdae_event_roots_layout(nsdae_event_roots *roots, nsdae_arena *arena);
/* Kind and index of every entry: once. */
void nsdae_event_roots_name(nsdae_event_roots *roots);

static inline nsdae_event_root *nsdae_event_root_of(const nsdae_event_roots *roots,
                                                    nsdae_root_kind kind, int index)
{
  const nsdae_dims *d = &roots->phase->setting->system->dims;
  int first[] = {
      0, d->k, 2 * d->k, 3 * d->k, 3 * d->k + d->f, 3 * d->k + 2 * d->f, 3 * d->k + 2 * d->f + 1};
  return roots->entry + first[kind] + index;
}

/* g [count] at y [n], where a step begins or not; 0, or -1 if it could not be evaluated. */
int nsdae_event_root_values(nsdae_event_roots *roots, double t, const double *y, int begins,
                            double *g);

/* The states for the phase that starts now at y, with the accelerations a [nv]. */
int nsdae_event_set_roots(nsdae_event_roots *roots, double t, const double *y, const double *a);

/* Roots of the contacts that are marked [k]: open, and not zero at t. */
void nsdae_event_start_late(nsdae_event_roots *roots, double t, const int *marked);

/* The entry whose force contradicts its mode the most as the phase starts: a contact that is closed
 * and pulls, what sticks beyond its cone; -1: none. The problem of accelerations found none, so
 * that the rows of the phase nearly depend on each other. */
int nsdae_event_inconsistent(const nsdae_event_roots *roots);

/* After a step to t, y: turns the directions of sliding, makes those live that left zero, and marks
 * as found what fell below it or asks for an instant. Returns how many, or a status. */
int nsdae_event_watch_roots(nsdae_event_roots *roots, double t, const double *y);

/* The contact, or -1, that slides and where a unit of force gives the least, no more than that part
 * of what it would give alone. */
int nsdae_event_unbounded(const nsdae_event_roots *roots, double part);

/* Marks as found, of what slides and did so faster before, what hardly does at t, y: where its
 * direction leads no further it has stopped. Returns how many, or a status. */
int nsdae_event_stop_slow(nsdae_event_roots *roots, double t, const double *y);

#endif
