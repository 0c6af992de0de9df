/* Broad phase: which solids may touch, found by a grid of cells that are as wide as the largest
 * solid of ordinary size; what is far larger, planes and holes are looked at with every solid.
 * Pairs come in an order that follows from the places alone. */
#ifndef NSDAE_BODIES_BROAD_H
#define NSDAE_BODIES_BROAD_H

#include "arena.h"
#include "bodies_impl.h"

typedef struct nsdae_grid {
  int *cell, *next; /* solids x 3: its cell; the solid before it in the same bucket */
  int *head;        /* buckets: the last solid in it, or -1 */
  int buckets;      /* a power of two */
  double width;     /* of a cell */
} nsdae_grid;

struct nsdae_broad {
  nsdae_arena arena;
  const nsdae_bodies *b;
  nsdae_pose *pose; /* of every body, and of the ground behind them */
  double *radius;   /* of each solid about its frame's origin; INFINITY of what is endless */
  double *centre;   /* solids x 3: where it is */
  nsdae_grid grid;
  double usual; /* largest radius of ordinary size */
  int *large;   /* those above it, and what is endless */
  int larges;
  long features;    /* of any pair of solids at most */
  double *excluded; /* in order: pairs of solids of nsdae_bodies_add_contact, by nsdae_broad_pair;
                       two bodies with a joint, by negative numbers */
  int excludes;
  const nsdae_bodies_pair *pair[NSDAE_MATERIALS][NSDAE_MATERIALS];
};

/* One that no other call uses, made where there is none; NULL: no memory. And back again. */
nsdae_broad *nsdae_broad_take(nsdae_bodies *bodies);
void nsdae_broad_give_back(nsdae_bodies *bodies, nsdae_broad *broad);
void nsdae_broad_release(nsdae_broad *broad);

/* Poses of all bodies (v NULL: at rest) and places of all solids. */
void nsdae_broad_place(nsdae_broad *broad, const double *q, const double *v);

/* Whether the gap of two solids, placed, may be at most reach. */
int nsdae_broad_near(const nsdae_broad *broad, int i, int j, double reach);

/* Whether two solids have no contacts by their materials: nsdae_bodies_add_contact has them, or a
 * joint connects their bodies. */
int nsdae_broad_is_excluded(const nsdae_broad *broad, int i, int j);

/* Sorts the solids, placed, into the grid. Returns the number of passes over the pairs. */
int nsdae_broad_sort(nsdae_broad *broad, double reach);

/* Pairs of solids of materials that touch, of pass i, whose gap may be at most reach, handed to
 * visit until it returns < 0, with i < j. Passes change nothing of the broad phase. */
typedef int (*nsdae_broad_fn)(void *to, const nsdae_broad *broad, int i, int j);
int nsdae_broad_pairs(const nsdae_broad *broad, int pass, double reach, nsdae_broad_fn visit,
                      void *to);

/* Whether two solids may have contacts, by their materials or nsdae_bodies_add_contact. */
int nsdae_broad_touches(const nsdae_broad *broad, int i, int j);

/* Whether a part of solid i may be as near to x as within. */
static inline int nsdae_broad_is_about(const nsdae_broad *p, int i, const double *x, double within)
{
  const double *c = p->centre + 3L * i, d[3] = {c[0] - x[0], c[1] - x[1], c[2] - x[2]};
  double most = p->radius[i] + within;
  return nsdae_dot3(d, d) <= most * most;
}

/* Solids, sorted, of which a part may be as near to x as within, until visit returns other than 0,
 * which is returned. */
typedef int (*nsdae_about_fn)(void *to, int i);
int nsdae_broad_about(const nsdae_broad *broad, const double *x, double within,
                      nsdae_about_fn visit, void *to);

/* Ids of contacts: feature i of nsdae_bodies_add_contact has i; behind them feature i of
 * solids j < k has feature.count + nsdae_broad_pair * nsdae_broad_features + i. */
long nsdae_broad_features(const nsdae_bodies *bodies);

static inline long nsdae_broad_pair(const nsdae_bodies *b, int i, int j)
{
  return i < j ? (long)i * b->solid.count + j : (long)j * b->solid.count + i;
}

/* The pose of the body of a solid. */
static inline const nsdae_pose *nsdae_broad_pose(const nsdae_broad *broad, int body)
{
  return &broad->pose[body == NSDAE_GROUND ? broad->b->body.count : body];
}

#endif
