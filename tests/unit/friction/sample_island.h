/* The first island of a seeded problem, at r = 0: what tests of the parts of its solver begin with.
 * It points into itself, and stays where it was made. */
#ifndef NSDAE_TESTS_SAMPLE_ISLAND_H
#define NSDAE_TESTS_SAMPLE_ISLAND_H

#include "check.h"

#include <stdlib.h>

#include "friction_families.h"
#include "island.h"

typedef struct sample_island {
  nsdae_arena whole_memory, memory;
  nsdae_fc_whole whole;
  nsdae_fc fc;
} sample_island;

static inline void sample_island_make(sample_island *s, const friction_sample *sample)
{
  double *r = calloc(3 * (size_t)sample->problem.contacts + 1, sizeof *r);
  *s = (sample_island){.whole = {.view.p = &sample->problem}};
  assert_non_null(r);
  assert_int_equal(nsdae_arena_fit(&s->whole_memory, nsdae_fc_whole_layout, &s->whole), NSDAE_OK);
  assert_int_equal(nsdae_fc_whole_fill(&s->whole, NULL), NSDAE_OK);
  s->fc = (nsdae_fc){.whole = &s->whole};
  assert_int_equal(nsdae_arena_fit(&s->memory, nsdae_fc_layout, &s->fc), NSDAE_OK);
  nsdae_fc_fill(&s->fc, r);
  free(r);
}

static inline void sample_island_release(sample_island *s)
{
  nsdae_arena_release(&s->memory);
  nsdae_arena_release(&s->whole_memory);
}

#endif
