/* Vectors whose clones come from a pool: nothing is to be allocated after creation. The pool is
 * large enough for all that an integrator clones when it is made, too: N_VClone does not survive a
 * clone that fails. And its vectors live until it is closed, so that one may be destroyed twice:
 * CVodeInit that finds no memory does so. */
#ifndef NSDAE_SMOOTH_POOL_H
#define NSDAE_SMOOTH_POOL_H

#include <sundials/sundials_nvector.h>

enum { NSDAE_POOL_MAX = 40 };

typedef struct nsdae_pool {
  N_Vector kept[NSDAE_POOL_MAX];
  int count;
} nsdae_pool;

/* A serial vector of n entries whose clones, and theirs, are those of the pool that are not in
 * use, new ones where it has none; NULL without memory. It is its owner's to destroy. */
N_Vector nsdae_pool_vector(nsdae_pool *pool, int n, SUNContext context);

/* Fills the pool with clones of the vector; 0 when it is full. */
int nsdae_pool_fill(nsdae_pool *pool, N_Vector like);

/* Releases the pool's vectors, when what cloned them is gone. */
void nsdae_pool_close(nsdae_pool *pool);

#endif
