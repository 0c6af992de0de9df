#include "impulses.h"

#include <string.h>

void nsdae_impulses_layout(nsdae_impulses *r, const nsdae_dims *dims, nsdae_arena *arena)
{
  long k = dims->k, kt = k * dims->nt, f = dims->f;
  r->impact = NSDAE_ARENA_INTS(arena, k);
  r->before = NSDAE_ARENA_DOUBLES(arena, k);
  r->before_t = NSDAE_ARENA_DOUBLES(arena, kt);
  r->after = NSDAE_ARENA_DOUBLES(arena, k);
  r->after_t = NSDAE_ARENA_DOUBLES(arena, kt);
  r->normal = NSDAE_ARENA_DOUBLES(arena, k);
  r->tangential = NSDAE_ARENA_DOUBLES(arena, kt);
  r->mode = NSDAE_ARENA_INTS(arena, k);
  r->slide_before = NSDAE_ARENA_DOUBLES(arena, f);
  r->slide_after = NSDAE_ARENA_DOUBLES(arena, f);
  r->slide_impulse = NSDAE_ARENA_DOUBLES(arena, f);
  r->slide_mode = NSDAE_ARENA_INTS(arena, f);
}

void nsdae_impulses_clear(nsdae_impulses *r, const nsdae_dims *dims)
{
  size_t k = (size_t)dims->k, kt = k * (size_t)dims->nt, f = (size_t)dims->f;
  memset(r->impact, 0, k * sizeof *r->impact);
  memset(r->before, 0, k * sizeof *r->before);
  memset(r->before_t, 0, kt * sizeof *r->before_t);
  memset(r->after, 0, k * sizeof *r->after);
  memset(r->after_t, 0, kt * sizeof *r->after_t);
  memset(r->normal, 0, k * sizeof *r->normal);
  memset(r->tangential, 0, kt * sizeof *r->tangential);
  memset(r->mode, 0, k * sizeof *r->mode);
  memset(r->slide_before, 0, f * sizeof *r->slide_before);
  memset(r->slide_after, 0, f * sizeof *r->slide_after);
  memset(r->slide_impulse, 0, f * sizeof *r->slide_impulse);
  memset(r->slide_mode, 0, f * sizeof *r->slide_mode);
}
