/* Seeded frictional contact problems of rigid bodies: walls, piles, towers, at rest, tilted or hit,
 * built from their geometry and with more contact rows than freedoms as a rule.
 *
 * Bodies have six freedoms (velocity of the centre, angular velocity, in the axes of the world). A
 * contact at p with the normal e from body A to body B has the velocity u = d . (v_B + omega_B x (p
 * - c_B) - v_A - omega_A x (p - c_A)) along each direction d of its frame, f = M v + h g m, w_N =
 * gap / h >= 0. With v = 0 there is u = w in K*, so that every problem has a solution (Acary,
 * Cadoux, Lemarechal, Malick, ZAMM 91 (2011) 155). */
#ifndef NSDAE_TESTS_FRICTION_FAMILIES_H
#define NSDAE_TESTS_FRICTION_FAMILIES_H

#include <nsdae/friction.h>

enum friction_family {
  FRICTION_WALL,    /* bricks in running bond, four corners a joint */
  FRICTION_SPHERES, /* each on three others or on the ground */
  FRICTION_TOWER,   /* layers of crossed planks, the corners of each crossing */
  FRICTION_STOREYS, /* slabs on layers of spheres */
  FRICTION_FAMILIES
};

/* What happens to them. */
enum friction_motion { FRICTION_AT_REST, FRICTION_TILTED, FRICTION_HIT, FRICTION_MOTIONS };

/* Their coefficients of friction. */
enum friction_grip {
  FRICTION_ALIKE,  /* one for all, in [0, 2] */
  FRICTION_MIXED,  /* each in [0, 2] */
  FRICTION_BESIDE, /* 0 or 1 */
  FRICTION_GRIPS
};

typedef struct friction_sample {
  int family, motion, grip;
  double mass_ratio;              /* of densities, 1 .. 1e6 */
  nsdae_friction_problem problem; /* global form, three rows a contact */
  int bodies;
  struct friction_body *body;
  unsigned long long state;  /* of the random numbers */
  int *first, *block, *size; /* what problem points to */
  double *mu, *w, *M, *f, *value;
  int room; /* contacts that there is room for */
} friction_sample;

const char *friction_family_name(int family);
const char *friction_motion_name(int motion);
const char *friction_grip_name(int grip);

/* A problem with about so many contacts (of 20 or more: within a factor of 1.5), all else drawn by
 * the seed. Ends the program where there is no memory. */
void friction_sample_draw(friction_sample *s, int family, int contacts, unsigned long long seed);
void friction_sample_release(friction_sample *s);

/* Every force by so much of itself at most, drawn on by the seed: the same contacts an instant on.
 */
void friction_sample_change(friction_sample *s, double by);

/* The residual of r + low (low NULL: of r), free of units, in quadruple precision where there is
 * such, else in long double: with d_c the mean of the diagonal of
 * W for contact c and s = max |q|, x = r d / s, y = (u + mu |u_T| e_N) / s, max |x - P_K(x - y)|.
 * NaN where r is not finite. */
double friction_sample_residual(const friction_sample *s, const double *r, const double *low);

/* The largest |x_i|: an evaluation in double rounds x - P_K(x - y) to 1e-16 of it. */
double friction_sample_largest(const friction_sample *s, const double *r);

/* W and q of the local form by blocks, packed as problem wants them; freed by
 * friction_local_release. mu is that of the sample. */
typedef struct friction_local {
  nsdae_friction_problem problem;
  int *first, *block;
  double *value, *q;
} friction_local;

void friction_sample_local(const friction_sample *s, friction_local *local);
void friction_local_release(friction_local *local);

#endif
