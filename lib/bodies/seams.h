/* Seams: where solids lie flush, what a face of one covers of another has no contact of its own.
 *
 * A contact at the place a of a solid, with the direction n out of it, is hidden by another solid C
 * that may touch the same, if a is in C or beside it by no more than eps, and n goes into C:
 *
 *   an edge or corner   max over C of n . (x - a) > 0: n is not in the normal cone of both together
 *   a face              a + 2 eps n is in C, too
 *
 * unless the solid comes out of C near a: along its plane across n, no deeper than 8 eps beneath a
 * face of C. So a step that is higher than 2 eps stops what hits it, and a wall on a floor has its
 * contacts down to the corner. It must come out of what else covers that place, as well.
 *
 * (Of one mesh the same is known from its triangles: see mesh_contact.c.) Nothing depends on the
 * motion but poses; a hidden contact reappears where the solids touch, with the gap of the contact
 * that it takes over from. */
#ifndef NSDAE_BODIES_SEAMS_H
#define NSDAE_BODIES_SEAMS_H

#include "broad_phase.h"

/* A contact of two solids, with where it is. */
typedef int (*nsdae_seen_fn)(void *to, long number, const nsdae_closest *closest,
                             const nsdae_still *at, const nsdae_couple *two);

/* Contacts of two solids i < j, placed and sorted, whose gap is at most the reach and that nothing
 * hides, as nsdae_pair_contacts gives them. fine: poses are known to rounding, not to the depth at
 * which time stepping has bodies rest; eps is that much smaller. */
int nsdae_seen_contacts(const nsdae_broad *broad, int i, int j, double reach, int fine,
                        nsdae_seen_fn add, void *to);
/* The same of nsdae_bodies_add_contact: they are a request, and nothing hides them. */
int nsdae_named_contacts(const nsdae_broad *broad, int i, int j, double reach, nsdae_seen_fn add,
                         void *to);

#endif
