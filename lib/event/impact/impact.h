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

/* The impacts of one instant, one after the other. Each with e_N multiplies the determinant of the
 * linear map from the first velocities to the present ones by -e_N. In a sequence that ends, the d
 * velocities of its contacts shrink alike: they are (product of e_N)^(1/d) of the first. A sequence
 * that still goes on if this is below rtol has no end. Its velocities of approach go to zero, as
 * the sum of their energies is finite: its limit is the plastic impact of all its contacts. */
typedef struct nsdae_event_sequence {
  int *hit;     /* k: it had an impact */
  int hits;     /* d */
  double decay; /* ln of the product of e_N */
  int together; /* the next impact is the limit: no contact that parts is driven together */
  int endless;  /* it has more than events_max impacts */
} nsdae_event_sequence;

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
  nsdae_event_sequence sequence;
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
