/* The woodpecker toy: see woodpecker.c. */
#ifndef NSDAE_MODEL_WOODPECKER_H
#define NSDAE_MODEL_WOODPECKER_H

#include "driver.h"

enum woodpecker_contact { WOODPECKER_BEAK, WOODPECKER_LOWER_EDGE, WOODPECKER_UPPER_EDGE };

/* Number of the peck from which on the cycle is the limit cycle, to 1e-5 s. */
enum { WOODPECKER_SETTLED = 5 };

typedef struct woodpecker {
  double r_0, r_M, h_M, l_M, l_G, h_S, l_S, m_M, m_S, J_M, J_S, c, g;
  double e_beak, e_sleeve, e_T, mu;
  double phi_S, v, omega_S; /* at the start */
  int pecks;                /* impacts of the beak so far */
  double settled, last;     /* times of the peck WOODPECKER_SETTLED and of the last one [s] */
} woodpecker;

extern const driver_model woodpecker_model;

#endif
