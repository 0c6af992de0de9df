/* Impacts: one problem of velocities for all that touch, with Newton's restitution and Coulomb's
 * friction; and impacts without end.
 *
 * Those of one contact or of several that alternate end in rest, in finite time. Let v- be the
 * velocity before an impact, v+ after it, v_c after it with no velocity apart where the problem of
 * accelerations then asks for forces F_N to keep closed (the set). What still parts has the energy
 *
 *   E = (v+ - v_c)^T M (v+ - v_c) / 2        E- the same with v-,  q = E / E-: what is left of it
 *
 * and comes back against F after a flight of 4 E / (F . g'), which for one contact is 2 v+ / a;
 * then after sqrt(q) of that, and so on, as at the limit the problem is linear:
 *
 *   T = 4 E / ((F . g') (1 - sqrt(q)))       one contact: q = e^2, T = 2 v+ / (a (1 - e))
 *
 * Where T is below accumulation_time, or all that parts is as slow as the integrator's errors, the
 * set is closed: v_c in place of v+, and the end is told at t + T. */
#ifndef NSDAE_EVENT_IMPACT_H
#define NSDAE_EVENT_IMPACT_H

#include "acceleration.h"
#include "account.h"
#include "projection.h"

typedef struct nsdae_event_impacts {
  nsdae_event_acceleration *acceleration;
  nsdae_event_account *account;
  nsdae_event_projection *projection;
  nsdae_contacts problem;
  nsdae_law *law;                    /* k */
  double *momentum, *multiplier;     /* nv, m: M v-; the bilateral impulses */
  double *v, *size, *parting, *lost; /* nv: v+; how large its terms are; v+ - v_c; v- - v_c */
  double *velocity, *after;          /* k: of the contacts before, and after with their e_N */
  double *closing;                   /* k: impulses of the closing; may pull */
  double *force, *xi;                /* columns: for cones */
  int *settles;                      /* k: in the set */
  double rest, closing_work;         /* T; of the closing */
  nsdae_impact *record;              /* of the step, in order of time */
  int records, records_max;
  int accumulations; /* closed in the step */
  int endless;       /* impacts of one instant that do not end */
} nsdae_event_impacts;

void nsdae_event_impacts_layout(nsdae_event_impacts *impacts, nsdae_arena *arena);
int nsdae_event_impacts_make(nsdae_event_impacts *impacts);
void nsdae_event_impacts_release(nsdae_event_impacts *impacts);

/* Impacts of what touches and approaches, until nothing does; y's v is that after them. Returns
 * how many problems there were, or a status. */
int nsdae_event_collide(nsdae_event_impacts *impacts, double *y);

/* Whether contact i touches but for the integrator's error, and does not part. */
int nsdae_event_touches(const nsdae_event_setting *setting, int i);

#endif
