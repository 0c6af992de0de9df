/* Random drops: a body of points with radii (boxes, rods, discs), or several discs, in the plane or
 * in space, over walls (a floor, a groove, a corner). */
#ifndef DROP_H
#define DROP_H

#include <stdint.h>

#include <nsdae/nsdae.h>

enum { DROP_POINTS = 8, DROP_WALLS = 3, DROP_BODIES = 3 };
enum { DROP_THROWN = 8, DROP_NQ = 3 * DROP_THROWN, DROP_NV = DROP_NQ }; /* most bodies */

typedef struct drop {
  uint64_t seed;
  int space, bodies, points, walls;
  double m, J[3], half[3];              /* of each body; of a box or rod: half its edges */
  double point[DROP_POINTS][3], radius; /* of the body; of a point, or of each disc */
  double normal[DROP_WALLS][3], g;
  double tangent[DROP_WALLS][2][3]; /* of the walls, for the system */
  double mu, e, rtol;
  double q0[DROP_NQ], v0[DROP_NV], size; /* the start; the largest length */
  char name[160];
} drop;

/* The drop of that seed. */
void drop_make(drop *d, unsigned long seed);
/* Many discs that are thrown at each other over walls, and spin. */
void drop_throw(drop *d, unsigned long seed);
/* Its system, which keeps d; NULL without memory. */
nsdae_system *drop_system(drop *d);

enum { DROP_CONTACTS = DROP_THROWN * DROP_WALLS + DROP_THROWN * (DROP_THROWN - 1) / 2 };

/* What its callbacks say at a state: gaps, rows of W_N and W_T, omega; F. */
typedef struct drop_terms {
  int count; /* of contacts */
  double gap[DROP_CONTACTS], W_N[DROP_CONTACTS][DROP_NV], W_T[2 * DROP_CONTACTS][DROP_NV];
  double omega_N[DROP_CONTACTS], omega_T[2 * DROP_CONTACTS], F[DROP_NV];
} drop_terms;

void drop_find_terms(const drop *d, const double *q, const double *v, drop_terms *to);

#endif
