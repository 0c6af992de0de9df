/* Impacts: one problem of velocities for all that touch, with Newton's restitution and Coulomb's
 * friction; those without end in one. Newton's law with friction is not always possible:
 *
 *   Its problem has no solution where bodies jam, as a wedge between two walls, since e_N v- on
 *   self-equilibrated impulses does work. Then e_N = 0 in this impact, which always has one
 *   (Stewart and Trinkle 1996).
 *   It gains energy where friction turns a body's spin into a bounce (Kane and Levinson 1985).
 *   Then the impulses are between those with e_N and those with e_N = 0, as near to e_N as the work
 *   allows, which is quadratic in between: no energy is gained. */
#ifndef NSDAE_EVENT_IMPACT_H
#define NSDAE_EVENT_IMPACT_H

#include "account.h"
#include "accumulation.h"

typedef struct nsdae_event_impacts {
  nsdae_event_acceleration *acceleration;
  nsdae_event_account *account;
  nsdae_event_accumulation accumulation;
  nsdae_contacts problem;
  nsdae_impulses solution, plastic; /* the second with e_N = 0 */
  double *momentum, *multiplier;    /* nv, m: M v-; the bilateral impulses */
  double *v, *size;                 /* nv: v+; how large its terms are */
  double *elastic, *reaction;       /* nv, m: v+ and the bilateral impulses with e_N */
  double *velocity, *coming;        /* k: normal, of the contacts before; as the problem has it */
  double *force, *xi;               /* columns: for cones */
  double *bound;                    /* f: of the friction circles */
  double *blur; /* k: multiple of the threshold below which an impact is plastic */
  int together; /* what parts already is to go on parting */
  int endless;  /* impacts of one instant that nothing ends */
} nsdae_event_impacts;

void nsdae_event_impacts_layout(nsdae_event_impacts *impacts, nsdae_arena *arena);
/* Sizes, before the layout; the laws after it, and again after options or coefficients changed. */
void nsdae_event_impacts_prepare(nsdae_event_impacts *impacts);

/* Impacts of what touches and approaches, until nothing does; y's v is that after them. Returns
 * how many problems there were, or a status. */
int nsdae_event_collide(nsdae_event_impacts *impacts, double *y);

/* Whether contact i touches up to the integrator's error, and does not part. */
int nsdae_event_touches(const nsdae_event_setting *setting, int i);

#endif
