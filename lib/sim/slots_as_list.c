/* What a step by slots did, as a contact list has it: of the contacts that were closed in it, that
 * overlap at its end, or that had an impulse, an impact or a change of mode, in the order of the
 * slots. Impulses, impacts, changes and certificate then have places in this list. */
#include <string.h>

#include "sim_impl.h"

/* Entry `from` becomes entry `to`, which does not come after it. */
static void move(nsdae_impulses *r, size_t nt, int from, int to)
{
  double *const one[] = {r->before, r->after, r->normal};
  double *const along[] = {r->before_t, r->after_t, r->tangential};
  for (int i = 0; i < 3; i++) {
    one[i][to] = one[i][from];
    memmove(along[i] + (size_t)to * nt, along[i] + (size_t)from * nt, nt * sizeof **along);
  }
  memmove(r->linear + 3 * (size_t)to, r->linear + 3 * (size_t)from, 3 * sizeof *r->linear);
  r->mode[to] = r->mode[from];
  r->impact[to] = r->impact[from];
}

/* The contact of an impact or a change gets its place, which says who it is. */
static void rename_event(const nsdae_closed *closed, const int *place, int *contact, long *id,
                         int *block)
{
  if (*contact < 0) return;
  *contact = place[*contact];
  *id = closed->id[*contact];
  memcpy(block, closed->block + 2 * *contact, 2 * sizeof *block);
}

static void rename_contact(int *contact, const int *place)
{
  if (*contact >= 0) *contact = place[*contact];
}

/* Of this step, and in the statistics if they are of this step. */
static void rename_worst(nsdae_certificate *c, nsdae_certificate *most, const int *place)
{
  int *const now[] = {&c->pull_contact, &c->cone_contact, &c->penetration_contact,
                      &c->complementarity_contact},
             *const ever[] = {&most->pull_contact, &most->cone_contact, &most->penetration_contact,
                              &most->complementarity_contact};
  const double values[][2] = {{c->pull, most->pull},
                              {c->cone_excess, most->cone_excess},
                              {c->penetration, most->penetration},
                              {c->complementarity, most->complementarity}};
  for (int i = 0; i < 4; i++) {
    if (*now[i] == *ever[i] && values[i][0] == values[i][1]) rename_contact(ever[i], place);
    rename_contact(now[i], place);
  }
}

void nsdae_point_list(nsdae_point *p, int *place)
{
  nsdae_result *r = &p->result;
  const nsdae_tracked *tracked = r->end.system->tracked;
  nsdae_closed *closed = &r->closed;
  int k = r->end.system->dims.k, count = 0;
  for (int i = 0; i < k; i++)
    place[i] = nsdae_result_takes_part(r, i) || r->end.gap[i] < 0 ? count++ : -1;
  for (int i = 0; i < k; i++) {
    if (place[i] < 0) continue;
    closed->id[place[i]] = tracked->id[i];
    closed->gap[place[i]] = r->end.gap[i];
    closed->fresh[place[i]] = 0;
    memcpy(closed->block + 2 * place[i], tracked->block + 2 * i, 2 * sizeof *closed->block);
    move(&r->impulses, (size_t)closed->nt, i, place[i]);
  }
  for (int j = 0; j < r->impacts; j++)
    rename_event(closed, place, &r->impact[j].contact, &r->impact[j].id, r->impact[j].block);
  for (int j = 0; j < r->changes; j++)
    rename_event(closed, place, &r->change[j].contact, &r->change[j].id, r->change[j].block);
  rename_worst(&p->record.certificate, &p->accounts.stats.certificate, place);
  closed->count = p->record.contacts.count = count;
}
