/* The contacts of a list near a smooth motion: which ids have a slot.
 *
 * Of a step [t0, t0 + h] the list is asked at the start, in the middle and at the end for gaps up
 * to
 *
 *   R = near + h V,   |d g_N / dt| <= V.
 *
 * A contact whose gap is at most `near` at some time of the step has at most near + h V / 4 at the
 * nearest of the three, so it is listed there, even if V is four times too small. V is the largest
 * at the three times: from the callback contact_speed, or the estimate
 *
 *   V = 2 (sum_j L_j |v_j| + w),
 *
 * over the velocities of the two fastest blocks, with L_j the largest |W_N| at velocity j so far,
 * at least 1 and the width of the block, and w the largest |w_N| so far. Open contacts have no
 * force: a step remains right whichever of them have slots.
 *
 * A step of the integrator may go beyond its first root t1, as nothing closes in it. Past t1 bodies
 * overlap, and a feature that is listed first there may have any negative gap: the motion never
 * has it. So every new contact has its slot, open and far where it is not listed, and a gap that
 * jumps from there through zero is a root as others are. Up to t1 a gap g_N in time is continuous
 * while listed, or appears at g_N >= -near, as that of another feature that touches. Hence the
 * contact is late exactly if its jump is the first root and g_N(t1) < -near. A jump after t1 is
 * none of the motion; the next step, from t1, finds it again if it is. */
#ifndef NSDAE_TRACKING_H
#define NSDAE_TRACKING_H

#include "arena.h"
#include "listed.h"
#include "state.h"

/* Moves terms to time t of the step and gives them; NSDAE_OK, or a status. */
typedef int nsdae_tracking_look(double t, nsdae_terms **terms, void *user);

typedef struct nsdae_tracking {
  const nsdae_system *model; /* with k slots; coefficients are set by slot */
  nsdae_tracked *table;      /* the model's */
  nsdae_error *error;
  double near;    /* contacts as near have a slot  */
  double longest; /* step: closed contacts are listed within its way, at every stage of it */
  nsdae_tracking_look *look;
  void *user;
  int *fresh;  /* k: 1 since the slot has its contact, until the user sets it to 0 */
  int *seen;   /* k: where the list was asked last */
  int *closes; /* k: see nsdae_tracking_close */
  /* in the method's memory */
  int *used, *block, *id;      /* k, 2 k, 2 k: both halves of the number */
  double *law, *lever, *still; /* 3 k: mu, e_n, e_t; nv: L_j; 2: w, the table's reach */
  double *anew;                /* nv + 2: lever and still of a motion without memory */
} nsdae_tracking;

void nsdae_tracking_layout(nsdae_tracking *tracking, nsdae_arena *arena);

/* Lays its arrays over a method's memory; the table to there, and back. */
void nsdae_tracking_lay(nsdae_tracking *tracking, const nsdae_system *model,
                        nsdae_memory_part *part);
void nsdae_tracking_store(const nsdae_tracking *tracking);
void nsdae_tracking_load(nsdae_tracking *tracking);
/* Whether the memory has slots that are used or not, each with blocks of the model. */
int nsdae_tracking_is_valid(const nsdae_tracking *tracking);

/* Terms are at the start of a motion, whose longest step is h: what is within R has a slot, all
 * other slots are free. The status of a callback or a list; NSDAE_ARRAYS_GROW also if a slot is
 * missing. */
int nsdae_tracking_begin(nsdae_tracking *tracking, nsdae_terms *terms, double h);

/* The same, where nothing is known and no memory is there; no slot is new. */
int nsdae_tracking_begin_anew(nsdae_tracking *tracking, nsdae_terms *terms, double h);

/* Terms are at an instant of the motion: contacts as near as `near` that have no slot, as those of
 * other features than before, get one. */
int nsdae_tracking_add(nsdae_tracking *tracking, nsdae_terms *terms);

/* Terms are at the start of a dt of the motion: frees the slots of contacts that are not within R
 * and not kept [k]. */
int nsdae_tracking_trim(nsdae_tracking *tracking, nsdae_terms *terms, double h, const int *keep);

/* Terms are at a trial point of a step up to h, where a contact is not listed that had been so at
 * the start. A gap changes by no more than h times the speed: within that, with the speed at the
 * terms' point, the list is asked from now on. A trial point of a motion that starts from rest may
 * be farther than the reach of its start. */
int nsdae_tracking_widen(nsdae_tracking *tracking, nsdae_terms *terms, double h);

/* After a step from one time to another: every contact that comes as near as `near` in it gets a
 * slot. The number of new ones, or a status; NSDAE_E_CALLBACK if a new one is below -near at the
 * start, or a contact moves faster than contact_speed says. Lists within the table's reach then
 * have the new ones from the start of the step on, if they are there. The terms that `look` moved
 * are anywhere in it. */
int nsdae_tracking_cover(nsdae_tracking *tracking, double from, double to);

/* Open contacts that are marked in `closes` close at `to`, the first root of the step from `from`:
 * NSDAE_E_CALLBACK if one was not listed at `from` and is now below -near, by more than the
 * rounding of `to` makes. Changes the marks; the terms that `look` moved are at one of both. */
int nsdae_tracking_close(nsdae_tracking *tracking, double from, double to);

/* Gaps of a dt: at its start those of the contacts that have slots now; at its end those of the
 * slots that are needed [k], too, as those that had an impulse in it and are farther than the last
 * step's way by now. One of another feature may be listed no more; its gap is then the widest reach
 * that was asked for; `seen` has which are listed. */
int nsdae_tracking_show(const nsdae_tracking *tracking, nsdae_terms *from, nsdae_terms *end,
                        const int *needed);

#endif
