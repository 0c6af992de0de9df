#include "result.h"

#include <string.h>

void nsdae_memory_copy(nsdae_memory *to, const nsdae_memory *from)
{
  memcpy(to->real, from->real, from->reals * sizeof *from->real);
  memcpy(to->whole, from->whole, from->wholes * sizeof *from->whole);
  to->stamp = from->stamp;
}

void nsdae_count_rank(nsdae_counters *counters, int rank)
{
  if (rank < counters->rank) counters->rank = rank;
  if (rank > counters->rank_most) counters->rank_most = rank;
}

void nsdae_result_layout(nsdae_result *r, nsdae_arena *arena)
{
  const nsdae_dims *dims = &r->end.system->dims;
  nsdae_terms_layout(&r->end, arena);
  nsdae_impulses_layout(&r->impulses, dims, arena);
  r->multiplier = NSDAE_ARENA_DOUBLES(arena, dims->m);
  r->impacts_max = 64 + 2 * dims->k;
  r->changes_max = r->impacts_max + 2 * dims->f;
  r->impact = nsdae_arena_take(arena, r->impacts_max, sizeof *r->impact);
  r->change = nsdae_arena_take(arena, r->changes_max, sizeof *r->change);
  r->memory.real = NSDAE_ARENA_DOUBLES(arena, r->memory.reals);
  r->memory.whole = NSDAE_ARENA_INTS(arena, r->memory.wholes);
}

void nsdae_result_clear(nsdae_result *r)
{
  const nsdae_dims *dims = &r->end.system->dims;
  memset(r->multiplier, 0, (size_t)dims->m * sizeof *r->multiplier);
  nsdae_impulses_clear(&r->impulses, dims);
  r->impacts = r->changes = 0;
  r->work = r->worst_residual = 0;
  r->smooth = r->located = r->given_up = 0;
  r->problem = NULL;
  r->counters = (nsdae_counters){.rank = dims->m};
}
