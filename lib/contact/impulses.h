/* What contacts and frictional joints did in a step or instant: the results of a contact problem,
 * or of an integration over forces. Zero where a contact is open. */
#ifndef NSDAE_IMPULSES_H
#define NSDAE_IMPULSES_H

#include <nsdae/system.h>

#include "arena.h"

typedef struct nsdae_impulses {
  int *impact;                 /* k: contacts that hit, as the method decided */
  double *before, *before_t;   /* v_N(-), v_T(-): k, k nt */
  double *after, *after_t;     /* v_N(+), v_T(+) */
  double *normal, *tangential; /* Lambda_N, Lambda_T */
  int *mode;                   /* enum nsdae_mode */

  double *slide_before, *slide_after; /* f: sliding velocity */
  double *frictional_joint_impulse;   /* f: Lambda_T */
  int *frictional_joint_mode;         /* f */
} nsdae_impulses;

/* Of k = 0 those of the frictional joints alone: a list has the others. */
void nsdae_impulses_layout(nsdae_impulses *impulses, const nsdae_dims *dims, nsdae_arena *arena);
void nsdae_impulses_clear(nsdae_impulses *impulses, const nsdae_dims *dims);

/* Those of the first contacts, and of the frictional joints, of impulses of other dimensions; of
 * the rest none. */
void nsdae_impulses_carry(nsdae_impulses *to, const nsdae_dims *dims, int count,
                          const nsdae_impulses *from);

/* sum of Lambda (v(+) + v(-)) / 2 over contacts and frictional joints of these numbers. */
double nsdae_impulses_work(const nsdae_impulses *impulses, int nt, int contacts, const int *contact,
                           int joints, const int *joint);

/* Impulses, and velocities before and after: += share (from - to) */
void nsdae_impulses_blend(nsdae_impulses *to, const nsdae_dims *dims, double share,
                          const nsdae_impulses *from);

#endif
