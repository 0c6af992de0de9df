#include "result.h"

#include <string.h>

#include "arena.h"
#include "listed.h"

/* Impacts of a step that are kept apart; and changes, after which it ends. The number of contacts
 * that there may be says nothing about it: fixed contacts and lists have the same steps. */
enum { SEPARATE = 64 };

void nsdae_memory_copy(nsdae_memory *to, const nsdae_memory *from)
{
  if (from->reals > 0) memcpy(to->real, from->real, from->reals * sizeof *from->real);
  if (from->wholes > 0) memcpy(to->whole, from->whole, from->wholes * sizeof *from->whole);
  to->stamp = from->stamp;
  to->slots = from->slots;
}

static size_t length_of(const nsdae_memory_part *part, nsdae_memory_length length)
{
  return length.fixed + part->slots * (length.slot + part->slots * length.pair);
}

/* Copies an array that two memories have. */
static void copy_shared(const nsdae_memory_part *part, nsdae_memory_length length, size_t each,
                        void *at, const void *from)
{
  const nsdae_memory_part *fewer = part->from->slots < part->slots ? part->from : part;
  size_t bytes = each * length_of(fewer, length);
  if (bytes > 0) memcpy(at, from, bytes);
}

double *nsdae_memory_reals(nsdae_memory_part *part, nsdae_memory_length length)
{
  double *at = part->real ? part->real + part->reals : NULL;
  if (part->from) copy_shared(part, length, sizeof *at, at, nsdae_memory_reals(part->from, length));
  part->reals += length_of(part, length);
  return at;
}

int *nsdae_memory_wholes(nsdae_memory_part *part, nsdae_memory_length length)
{
  int *at = part->whole ? part->whole + part->wholes : NULL;
  if (part->from)
    copy_shared(part, length, sizeof *at, at, nsdae_memory_wholes(part->from, length));
  part->wholes += length_of(part, length);
  return at;
}

void nsdae_count_rank(nsdae_counters *c, int rank, double kept, double left)
{
  if (rank < c->rank) c->rank = rank;
  if (rank > c->rank_most) c->rank_most = rank;
  if (kept < c->rank_retained) c->rank_retained = kept;
  c->rank_discarded = nsdae_larger(c->rank_discarded, left);
}

/* Tracked contacts are as many as there are slots; those of a list grow with it. */
static void lay_out_closed(nsdae_closed *closed, const nsdae_terms *end, nsdae_arena *arena)
{
  int k = end->system->dims.k, tracked = end->system->tracked != NULL;
  if (nsdae_terms_most(end->system) == NSDAE_ANY_NUMBER) return;
  closed->id = nsdae_arena_take(arena, k, sizeof *closed->id);
  closed->block = NSDAE_ARENA_INTS(arena, 2L * k);
  closed->gap = tracked ? NSDAE_ARENA_DOUBLES(arena, k) : end->gap;
  closed->fresh = NSDAE_ARENA_INTS(arena, k);
  closed->basis = NSDAE_ARENA_INTS(arena, tracked ? (long)closed->rows * k : 0);
  for (int i = 0; arena->base && !tracked && i < k; i++) {
    closed->id[i] = i;
    closed->block[2 * i] = closed->block[2 * i + 1] = -1;
  }
}

void nsdae_result_layout(nsdae_result *r, nsdae_arena *arena)
{
  const nsdae_dims *dims = &r->end.system->dims;
  nsdae_terms_layout(&r->end, arena);
  r->closed.nt = dims->nt;
  lay_out_closed(&r->closed, &r->end, arena);
  nsdae_impulses_layout(&r->impulses, dims, arena);
  r->multiplier = NSDAE_ARENA_DOUBLES(arena, dims->m);
  if (nsdae_terms_most(r->end.system) < NSDAE_ANY_NUMBER) { /* else they grow with the list */
    r->impacts_max = SEPARATE + 2 * dims->k;
    r->changes_max = r->impacts_max + 2 * dims->f;
    r->impact = nsdae_arena_take(arena, r->impacts_max, sizeof *r->impact);
  }
  r->change = nsdae_arena_take(arena, r->changes_max, sizeof *r->change);
  r->memory.real = NSDAE_ARENA_DOUBLES(arena, r->memory.reals);
  r->memory.whole = NSDAE_ARENA_INTS(arena, r->memory.wholes);
}

void nsdae_result_clear(nsdae_result *r)
{
  nsdae_result_begin(r, 0);
}

void nsdae_result_begin(nsdae_result *r, int impulses_follow)
{
  const nsdae_dims *dims = &r->end.system->dims;
  for (int i = 0; i < dims->m; i++) r->multiplier[i] = 0;
  r->closed.count = 0;
  if (!impulses_follow) nsdae_impulses_clear(&r->impulses, dims);
  r->impacts = r->changes = 0;
  r->work = r->lifted = r->raised = r->gain = r->turnover = r->carried = 0;
  r->worst_residual = r->contact_tol = r->above.hidden = 0;
  r->smooth = r->located = r->given_up = 0;
  r->twofold.frictional_joint = -1;
  r->unresolved.velocity = 0;
  r->crossed = (nsdae_crossed){.constraint = -1};
  r->rate = (nsdae_rate){0, -1, 0};
  r->problem = NULL;
  r->single = NULL;
  r->cones = NULL;
  r->counters = (nsdae_counters){.rank = dims->m, .rank_retained = 1};
}

void nsdae_result_rate(nsdae_result *r, const nsdae_terms *T, const double *v)
{
  r->rate = (nsdae_rate){1, -1, 0};
  for (int i = 0; i < T->system->dims.m; i++) {
    double rate = fabs(nsdae_terms_constraint_rate(T, i, v));
    if (rate > r->rate.most) r->rate = (nsdae_rate){1, i, rate};
  }
}

int nsdae_result_takes_part(const nsdae_result *r, int i)
{
  const nsdae_impulses *p = &r->impulses;
  int nt = r->end.system->dims.nt, any = p->mode[i] != NSDAE_MODE_OPEN || p->normal[i] != 0;
  for (int j = i * nt; j < (i + 1) * nt; j++) any |= p->tangential[j] != 0;
  for (int j = 0; j < r->impacts; j++) any |= r->impact[j].contact == i;
  for (int j = 0; j < r->changes; j++) any |= r->change[j].contact == i;
  return any;
}

int nsdae_result_room(const nsdae_result *r)
{
  return r->impacts <= SEPARATE && r->changes <= SEPARATE;
}

/* Id and blocks of a contact: of one in a slot those of the list. */
static void name_contact(const nsdae_system *s, int contact, long *id, int block[2])
{
  int in_slot = s->tracked && contact >= 0;
  *id = in_slot ? s->tracked->id[contact] : contact;
  for (int i = 0; i < 2; i++) block[i] = in_slot ? s->tracked->block[2 * contact + i] : -1;
}

nsdae_impact *nsdae_result_impact(nsdae_result *r, double t, int contact, double before)
{
  t = nsdae_system_time(r->end.system, t);
  int last = r->impacts - 1, at = r->impacts;
  int full = r->impacts >= SEPARATE;
  while (full && last >= 0 && (r->impact[last].contact != contact || r->impact[last].time != t))
    last--;
  if (full && last >= 0) return &r->impact[last];
  for (; at > 0 && r->impact[at - 1].time > t; at--) r->impact[at] = r->impact[at - 1];
  r->impacts++;
  r->impact[at] = (nsdae_impact){.time = t, .contact = contact, .velocity_before = before};
  name_contact(r->end.system, contact, &r->impact[at].id, r->impact[at].block);
  return &r->impact[at];
}

void nsdae_result_change(nsdae_result *r, double t, int contact, int frictional_joint, int before,
                         int after)
{
  if (before == after) return;
  t = nsdae_system_time(r->end.system, t);
  nsdae_change *change = &r->change[r->changes++];
  *change = (nsdae_change){.time = t,
                           .contact = contact,
                           .frictional_joint = frictional_joint,
                           .mode_before = before,
                           .mode_after = after};
  name_contact(r->end.system, contact, &change->id, change->block);
}

int nsdae_result_grow(nsdae_result *r, const nsdae_room *contacts)
{
  int room = (int)contacts->entries;
  const nsdae_array impacts[] = {NSDAE_ARRAY(r->impact, 1)};
  if (nsdae_terms_most(r->end.system) < NSDAE_ANY_NUMBER) return NSDAE_OK;
  int status = nsdae_closed_grow(&r->closed, &r->impulses, room);
  if (status == NSDAE_OK) status = nsdae_arrays_grow(impacts, 1, contacts->entries);
  if (status == NSDAE_OK) r->impacts_max = room;
  return status;
}

void nsdae_result_release(nsdae_result *r)
{
  const nsdae_array impacts[] = {NSDAE_ARRAY(r->impact, 1)};
  nsdae_terms_release(&r->end);
  if (!r->end.system || nsdae_terms_most(r->end.system) < NSDAE_ANY_NUMBER) return;
  nsdae_closed_release(&r->closed, &r->impulses);
  nsdae_arrays_release(impacts, 1);
}
