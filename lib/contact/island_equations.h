/* The equations of a step, of which a solver reads the part of its island, and where it writes. */
#ifndef NSDAE_ISLAND_EQUATIONS_H
#define NSDAE_ISLAND_EQUATIONS_H

#include "closed.h"
#include "contact_islands.h"
#include "contacts.h"
#include "natural_residual.h"

/* Velocities of an island at rest below this count as zero, relative to the fastest contact without
 * impulses, if contact_tol is larger. */
#define NSDAE_STILL 1e-9

typedef struct nsdae_island_equations {
  const nsdae_system *system;
  const nsdae_contact_islands *islands;
  const nsdae_terms *terms;      /* rows of Phi_q and of the closed contacts */
  const nsdae_coefficients *law; /* of the closed contacts, by number */
  const double *M, *r;           /* by blocks; nv */
  nsdae_closed *closed;
  nsdae_impulses *results;
  double *v, *size, *lambda;      /* nv, nv, m */
  int with_contacts;              /* 0: as if none were closed */
  struct nsdae_cone_island *kept; /* the problem of kept_island, for nsdae_sim_get_friction */
  int kept_island;
} nsdae_island_equations;

#endif
