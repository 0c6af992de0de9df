/* Consecutive steps of one system as frictional contact problems: the files step00.hdf5,
 * step01.hdf5 and so on of a folder, in the layout of FCLIB; /contacts/geom1, geom2 and index say
 * which contact is the same as before. */
#ifndef NSDAE_FRICTION_SEQUENCE_H
#define NSDAE_FRICTION_SEQUENCE_H

#include <nsdae/nsdae.h>

typedef struct friction_instant {
  nsdae_friction_file file;
  int *key[3]; /* [contacts] the two bodies, and the number between them */
  double *r;   /* [3 x contacts] begins as 0 */
} friction_instant;

/* 1: it was read; 0: there is no such file; -1: it holds no such problem. To be released in each
 * case. */
int friction_instant_read(const char *folder, int number, friction_instant *s);

/* r of each contact that there was before; 0 of those that are new. */
void friction_instant_hand_on(const friction_instant *before, friction_instant *s);

void friction_instant_release(friction_instant *s);

#endif
