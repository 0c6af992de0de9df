/* Offsets in z = [q, v, Lambda, I_N, I_T, I_S, E, A] of the equations, and its length; those of the
 * forces in y = [q, v, lambda, F_N, F_T, F_S] are the same. */
#ifndef NSDAE_PENALTY_PLACES_H
#define NSDAE_PENALTY_PLACES_H

#include <nsdae/system.h>

static inline int nsdae_penalty_at_lambda(const nsdae_dims *d)
{
  return d->nq + d->nv;
}

static inline int nsdae_penalty_at_normal(const nsdae_dims *d)
{
  return nsdae_penalty_at_lambda(d) + d->m;
}

static inline int nsdae_penalty_at_tangential(const nsdae_dims *d)
{
  return nsdae_penalty_at_normal(d) + d->k;
}

static inline int nsdae_penalty_at_slide(const nsdae_dims *d)
{
  return nsdae_penalty_at_tangential(d) + d->k * d->nt;
}

static inline int nsdae_penalty_at_work(const nsdae_dims *d)
{
  return nsdae_penalty_at_slide(d) + d->f;
}

static inline int nsdae_penalty_size(const nsdae_dims *d)
{
  return nsdae_penalty_at_work(d) + 2;
}

#endif
