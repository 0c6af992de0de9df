/* Bricard's mechanism: problem A04 of the IFToMM library of computational benchmark problems. Five
 * rods and the ground between them six revolute joints, along six edges of a cube: one degree of
 * freedom where Gruebler's formula counts none, so that one constraint is redundant everywhere. */
#ifndef NSDAE_TESTS_BRICARD_H
#define NSDAE_TESTS_BRICARD_H

#include <nsdae/nsdae.h>

enum { BRICARD_NQ = 24, BRICARD_M = 24, BRICARD_RANK = 23 };

typedef struct bricard {
  double L, m, a, g; /* length, mass and edge of the square section of a rod; gravity along -y */
} bricard;

void bricard_default(bricard *p);
nsdae_system *bricard_system(bricard *p);
void bricard_start(const bricard *p, double q0[BRICARD_NQ], double v0[BRICARD_NQ]);

/* M [24 x 24], F [24], Phi_q [24 x 24], column-major, for a test's own algebra. */
void bricard_mass(const bricard *p, double *M);
void bricard_force(const bricard *p, double *F);
void bricard_jacobian(const bricard *p, const double *q, double *J);

/* Cosine of the turn at joint i = 0 .. 5 from one link to the next. */
double bricard_cosine(const bricard *p, const double *q, int joint);

#endif
