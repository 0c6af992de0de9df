/* A small model whose every callback can be made to fail: a bead on a moving parabola above a
 * rising floor, planar, so that constraints and gaps are rheonomic and nonlinear. */
#ifndef NSDAE_TESTS_BEAD_H
#define NSDAE_TESTS_BEAD_H

#include <nsdae/nsdae.h>

enum bead_term {
  BEAD_MASS,
  BEAD_FORCE,
  BEAD_CONSTRAINT,
  BEAD_JACOBIAN,
  BEAD_BIAS,
  BEAD_GAP,
  BEAD_NORMAL,
  BEAD_TANGENT,
  BEAD_CONTACT_BIAS,
  BEAD_POTENTIAL,
  BEAD_TERMS
};

typedef struct bead {
  double speed, floor_speed; /* of the parabola, of the floor */
  /* faults: in the call of that number of that term */
  int term, at, code; /* term < 0: none; code: what the callback returns */
  double value;       /* written to its first entry where code is 0 */
  double mass_scale;  /* of M, e.g. -1 */
  int repeated;       /* the constraint stands twice (m = 2) */
  int calls[BEAD_TERMS];
} bead;

extern const char *const bead_names[BEAD_TERMS];

void bead_default(bead *b);
/* q = [x, y, theta], m = 1 (or 2), k = 1, nt = 1. */
nsdae_system *bead_system(bead *b);
/* A state on the constraint, above the floor. */
void bead_start(const bead *b, double q0[3], double v0[3]);

#endif
