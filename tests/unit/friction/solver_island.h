/* The first island of a problem with the memory of its solvers, and an iterate at r = 0: what tests
 * of one solver begin with. It points into itself, and stays where it was made. */
#ifndef NSDAE_TESTS_SOLVER_ISLAND_H
#define NSDAE_TESTS_SOLVER_ISLAND_H

#include "check.h"

#include <limits.h>
#include <stdlib.h>

#include "stages.h"

typedef struct solver_island {
  nsdae_arena global_memory, memory;
  nsdae_fc_global global;
  nsdae_fc_system system;
  nsdae_fc_farkas farkas;
  nsdae_fc_run run;
} solver_island;

static inline nsdae_fc_budget unbounded(double tol)
{
  return (nsdae_fc_budget){
      .tol = tol, .products = 1e7, .sweeps = LONG_MAX, .steps = INT_MAX, .double_double = 1};
}

static inline void solver_island_make(solver_island *s, const nsdae_friction_problem *p)
{
  *s = (solver_island){.global = {.view.p = p}};
  assert_int_equal(nsdae_arena_fit(&s->global_memory, nsdae_fc_global_layout, &s->global),
                   NSDAE_OK);
  assert_int_equal(nsdae_fc_global_fill(&s->global, NULL), NSDAE_OK);
  s->run.island = (nsdae_fc_island){.fc = {.global = &s->global, .exact = 1e-15},
                                    .system = &s->system,
                                    .farkas = &s->farkas,
                                    .proof = s->global.r};
  assert_int_equal(nsdae_arena_fit(&s->memory, nsdae_fc_run_layout, &s->run), NSDAE_OK);
  memset(s->global.r, 0, (size_t)s->global.view.m * sizeof *s->global.r);
  nsdae_fc_fill(&s->run.island.fc, s->global.r);
  memset(s->run.iterate.r, 0, nsdae_fc_bytes(&s->run.island));
  memset(s->run.iterate.low, 0, nsdae_fc_bytes(&s->run.island));
  s->run.iterate.residual = INFINITY;
}

static inline void solver_island_release(solver_island *s)
{
  nsdae_fc_system_release(&s->system);
  nsdae_arena_release(&s->farkas.memory);
  nsdae_arena_release(&s->memory);
  nsdae_arena_release(&s->global_memory);
}

#endif
