/* Impacts without end. Those of one contact, or of several that alternate, come to rest in finite
 * time. Let v- be the velocity before an impact, v+ after it, and [v] what of a velocity v the
 * least change takes that leaves nothing apart, nor along where friction holds, in the set of
 * contacts for which the problem of accelerations then asks for forces F_N. What still parts has
 * the energy
 *
 *   E = [v+]^T M [v+] / 2    E- the same with v-,  q = E / E-: the remaining share
 *
 * and comes back against F after a flight of 4 E / (F . g'), which for one contact is 2 v+ / a;
 * then after sqrt(q) of that, and so on, as at the limit the problem is linear:
 *
 *   T = 4 E / ((F . g') (1 - sqrt(q)))           one contact: q = e^2, T = 2 v+ / (a (1 - e))
 *
 * Where T is below accumulation_time, or all that parts is as slow as the integrator's errors, or
 * of several contacts comes no further than they, so that the next hit is undecided, the set
 * is closed, to v_c with none of it, and the end is reported at t + T. While one contact is in a
 * long flight others may come to rest in many short ones: where the set of all does not end, that
 * of those that part much slower than its fastest is asked. */
#ifndef NSDAE_EVENT_ACCUMULATION_H
#define NSDAE_EVENT_ACCUMULATION_H

#include "acceleration.h"
#include "least.h"
#include "phase.h"

/* Back to the constraints, to what is closed and to what sticks, by the change of least kinetic
 * energy. */

typedef struct nsdae_event_projection {
  nsdae_event_phase *phase;
  nsdae_least least; /* the change of q along H, or of v */
  double *qdot;      /* nq */
} nsdae_event_projection;

void nsdae_event_projection_layout(nsdae_event_projection *projection, nsdae_arena *arena);

/* y's q to the constraints and to the gaps that are marked [k], by Newton's method along H; y's v
 * to the rates of the constraints, of what is closed and of what sticks in the phase's modes.
 * moving [k] is 0 where a contact begins to slide: beside one that sticks, in two directions, its
 * velocity is none, too; NULL: nothing begins. The point in work is y then. A status of the
 * factorisation or a callback. */
int nsdae_event_project_positions(nsdae_event_projection *projection, double t, const int *closed,
                                  double *y);
int nsdae_event_project_velocities(nsdae_event_projection *projection, const int *moving,
                                   double *y);

/* The friction of what slides in the set, T = -mu P d: linear in the normal impulses P, which are
 * linear in it, P = P_0 + sum_j P_j dP/dP_j. */
typedef struct nsdae_event_closing_friction {
  double *value;       /* k nt: T */
  int *slider, *pivot; /* k: contacts of the set that slide, in turn; of the matrix */
  double *feed, *P;    /* k x k by columns: 1 - dP_i/dP_j; k: P */
} nsdae_event_closing_friction;

typedef struct nsdae_event_accumulation {
  nsdae_event_acceleration *acceleration;
  nsdae_event_projection *projection;
  const int *rattles;          /* k: instants of each in a row */
  int *settles, *sticks;       /* k: in the set; and held by friction */
  double *after;               /* k: normal velocities with v+ */
  double *parting, *lost;      /* nv: v+; in work */
  double *flight;              /* nv: accelerations before the impact */
  double left, all;            /* E, E- */
  double *reaction;            /* m: bilateral impulses of a guess */
  double *normal, *tangential; /* k, k nt: impulses of the closing, which may pull */
  nsdae_event_closing_friction friction;
  double work;          /* of the closing */
  double slow;          /* velocities up to this are none at the limit */
  double rest, fastest; /* T; of the set, the velocity apart */
  int early;            /* it ends before accumulation_time says */
} nsdae_event_accumulation;

void nsdae_event_accumulation_layout(nsdae_event_accumulation *accumulation, nsdae_arena *arena);

/* Nothing settles. */
void nsdae_event_unsettle(nsdae_event_accumulation *accumulation);

/* For nsdae_event_find_set, before the impacts of an instant: from y with the forces of the phase
 * that ends. A status of the solution. */
int nsdae_event_take_flight(nsdae_event_accumulation *accumulation, const double *y);

/* The set at v+ [nv]: of what touches, or has just left, and parts slowly, not faster than `most`.
 * Returns whether any of it parts; or a callback's status. */
int nsdae_event_find_set(nsdae_event_accumulation *accumulation, const double *v, double most);

/* v [nv], with e_N = 0 in the set, to v_c: others may have pushed it apart, what follows pushes
 * back. before [nv] is v-, impulse [k] what led to v. Adds to multiplier [m]. */
int nsdae_event_close_set(nsdae_event_accumulation *accumulation, const double *before,
                          const double *impulse, double *v, double *multiplier);

/* Whether it ends, with v_c and the impulses before the closing; `rest` is T, or 0 where it is
 * closed before. The closing may pull where the force that it is ahead of, F_N T, presses as much.
 */
int nsdae_event_ends(nsdae_event_accumulation *accumulation, const double *closed,
                     const nsdae_impulses *impact);

#endif
