/* A simulation of bodies from their start. */
#ifndef TEST_RUN_BODIES_H
#define TEST_RUN_BODIES_H

#include <stdlib.h>

#include <nsdae/nsdae.h>

#include "check.h"

static inline nsdae_sim *start(nsdae_bodies *b, const nsdae_sim_options *o, nsdae_system **system)
{
  nsdae_sim *sim;
  nsdae_error error;
  nsdae_dims d;
  if (nsdae_bodies_system(b, system) < 0) fail_msg("%s", nsdae_bodies_error(b)->text);
  assert_int_equal(nsdae_bodies_get_dims(b, &d), NSDAE_OK);
  double *q = calloc((size_t)d.nq, sizeof *q), *v = calloc((size_t)d.nv, sizeof *v);
  nsdae_bodies_get_start(b, q, v);
  if (nsdae_sim_create(*system, o, &sim, &error) < 0) fail_msg("%s", error.text);
  if (nsdae_sim_init(sim, 0, q, v) < 0) fail_msg("%s", nsdae_sim_error(sim)->text);
  free(q);
  free(v);
  return sim;
}

static inline void end(nsdae_bodies *b, nsdae_system *system, nsdae_sim *sim)
{
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  nsdae_bodies_destroy(&b);
}

#endif
