/* Which of the rows that are closed or stick have an equation of their own. Where a body rests on
 * more points than it has freedoms, the rows w of W_C depend on each other: the motion is
 * determined, how its forces share is not. The rows are taken in turn, contacts by their normal
 * force and what sticks after them, and depend as dependence.h says, w_p = sum c_l w_l. The forces
 * z_p = (1 in p, -c_l in l) then move nothing, and in place of its row p has a relation F_p = sum
 * r_l F_l:
 *
 *   even   r_l = c_l D_l / D_p       z_p^T D F = 0, so that F^T D F is least; D = 1 for normal
 *                                    forces, 1 / (mu F_N) for friction
 *   kept   F_N = s sum F_N of those taken, F_T = r F_N: the parts that the problem of
 *          accelerations gave it
 *
 * Even is tried first, and taken if with F + Z a that fulfils it nothing pulls and no friction
 * leaves its cone. Each of them is a solution. Where the dependence ends, the gap of such a contact
 * leaves zero and ends the phase. */
#ifndef NSDAE_EVENT_SHARING_H
#define NSDAE_EVENT_SHARING_H

#include "acceleration.h"
#include "dependence.h"

/* Rows by the columns of the problem of accelerations, n of them; those of slides come last. */
typedef struct nsdae_event_sharing {
  nsdae_event_acceleration *acceleration;
  nsdae_dependence rows;
  int *normal, *force_number; /* n: column of the same contact's normal; of the phase's forces */
  double *relation;           /* n x n, by rows */
  double *force, *weight;     /* n */
  double *emphasis;           /* k, by place among the active */
  double *solved;             /* n: forces of the problem's solution */
  int *solved_mode;           /* k */
  double *system, *shift;     /* n x n, n: of fulfil_relations */
  int *pivot;                 /* n */
} nsdae_event_sharing;

void nsdae_event_sharing_layout(nsdae_event_sharing *sharing, nsdae_arena *arena);

/* The modes' rows and relations, from the problem's solution; the forces there may be shared
 * differently afterwards. NSDAE_OK or NSDAE_E_CONVERGENCE with the record. */
int nsdae_event_share(nsdae_event_sharing *sharing);

/* A contact at rest whose friction is all used, and which does not begin to slide, sticks: others
 * hold it. Where one just broke away its neighbours are about to. */
void nsdae_event_hold_resting(nsdae_event_acceleration *acceleration);

#endif
