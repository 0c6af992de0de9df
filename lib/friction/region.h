/* Where sweeps come to no end a few contacts keep them from it: locked in one another, their
 * impulses move on by as much in each sweep, along what hardly moves u. These, with all that share
 * a block with one of them, are a problem of their own in which the impulses of the others are
 * forces (overlapping Schwarz, multiplicative: Smith, Bjorstad, Gropp, Domain Decomposition, 1996,
 * chapter 1): of the same laws, and small enough for Newton's method, a step of which would take
 * the whole island otherwise. In units of the island (island.h),
 *
 *   M = 1,  H = J',  f = y' - J' r' over the region,  w = q'. */
#ifndef NSDAE_FRICTION_REGION_H
#define NSDAE_FRICTION_REGION_H

#include "island.h"

typedef struct nsdae_fc_region {
  nsdae_friction_solver *solver; /* made when it is first needed */
  nsdae_arena marks, memory;
  const nsdae_fc *fc;
  int *mark;   /* items of the island: whether it is in the region */
  int *number; /* its blocks: their number in the region; -1: in none */
  int *offset; /* its blocks: where they begin in f */
  nsdae_friction_problem problem;
  int m, nv, entries; /* of the problem */
  size_t values, square;
  int *rows, *first, *block, *size; /* its arrays */
  double *mu, *w, *compliance, *M, *f, *value, *r, *u;
} nsdae_fc_region;

void nsdae_fc_region_release(nsdae_fc_region *region);

/* Solves the region of the items of fc, of the global form, that are above tol or changed by more
 * in the sweep from before [3 n] to fc->r, y and u being current. Returns 1 with the new r in
 * fc->r; with r as it was 0 where the region is none or most of the island, and -1 where it was not
 * solved, or there is no memory. The work is added to info. */
int nsdae_fc_region_solve(nsdae_fc_region *region, nsdae_fc *fc, const double *before, double tol,
                          nsdae_friction_info *info);

#endif
