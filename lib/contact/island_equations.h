/* The equations of a step, of which a solver reads the part of its island, and where it writes. */
#ifndef NSDAE_ISLAND_EQUATIONS_H
#define NSDAE_ISLAND_EQUATIONS_H

#include "impulses.h"
#include "contact_islands.h"
#include "contacts.h"
#include "natural_residual.h"

/* Velocities of an island at rest below this count as zero, relative to the fastest contact without
 * impulses, if contact_tol is larger. */
#define NSDAE_STILL 1e-9

/* One factorisation, which a solver may keep from one solution to the next. */
typedef struct nsdae_factorisation {
  long number; /* it is another one if this changed */
  long closed; /* other contacts are closed if this changed */
  int hold;    /* of redundant rows those that held in the one before */
  int dropped; /* some were redundant there */
  int *held;   /* rows: 1 for each that was independent */
} nsdae_factorisation;

/* How many of these rows the one before left out, where they are to be held; else 0. */
static inline int nsdae_factorisation_spare(const nsdae_factorisation *f, int rows, const int *row)
{
  int spare = 0;
  for (int i = 0; f->hold && f->dropped && i < rows; i++) spare += !f->held[row[i]];
  return spare;
}

/* Contacts are known by number: their rows in the terms, their places in all that follows. */
typedef struct nsdae_island_equations {
  const nsdae_system *system;
  const nsdae_contact_islands *islands;
  const nsdae_terms *terms;      /* rows of Phi_q, of contacts and frictional joints */
  const nsdae_coefficients *law; /* by number */
  const long *id;                /* by number, of a list */
  const double *joint_bound;     /* f: largest impulse of a frictional joint without a load */
  const nsdae_joint_row *beside; /* f */
  nsdae_contact_warm warm;
  nsdae_factorisation *factorisation;
  const double *M, *r; /* by blocks; nv */
  nsdae_impulses *results;
  double *v, *size, *lambda;      /* nv, nv, m */
  int with_contacts;              /* 0: as if none were closed */
  struct nsdae_cone_island *kept; /* the problem of kept_island, for nsdae_sim_get_friction */
  int kept_island;
} nsdae_island_equations;

static inline const char *nsdae_island_called(const nsdae_island_equations *w, int contact,
                                              char *called)
{
  return nsdae_system_called_contact(w->system, w->id, contact, called);
}

/* Velocities of an island. */
static inline int nsdae_island_size(const nsdae_island_equations *w, int island)
{
  const nsdae_members *block = &w->islands->block;
  int n = 0;
  for (int i = block->first[island]; i < block->first[island + 1]; i++)
    n += nsdae_blocks_size(&w->system->blocks, block->of[i]);
  return n;
}

#endif
