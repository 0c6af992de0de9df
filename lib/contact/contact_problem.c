#include "contact_problem.h"

#include <math.h>
#include <string.h>

#include "dynamic_array.h"
#include "errors.h"

int nsdae_problem_make(nsdae_problem *p, const nsdae_system *system, int threads,
                       nsdae_error *error)
{
  p->system = system;
  p->error = error;
  return system->by_list ? nsdae_island_dispatch_make(&p->dispatch, system, threads, error)
                         : NSDAE_OK;
}

/* The arrays of the closed contacts. */
enum { ARRAYS = 4 };

#define EACH(p)                                                                      \
  {                                                                                  \
    NSDAE_ARRAY((p)->item, 1), NSDAE_ARRAY((p)->place, 1), NSDAE_ARRAY((p)->law, 1), \
        NSDAE_ARRAY((p)->dispatch.islands.contact.of, 1)                             \
  }

void nsdae_problem_release(nsdae_problem *p)
{
  const nsdae_array each[ARRAYS] = EACH(p);
  nsdae_arrays_release(each, ARRAYS);
  nsdae_ids_release(&p->ids);
  nsdae_island_dispatch_release(&p->dispatch);
}

void nsdae_problem_prepare(nsdae_problem *p, const nsdae_lcp_options *options, double rank_tol)
{
  nsdae_island_dispatch_prepare(&p->dispatch, p->system, options, rank_tol, p->least_norm);
}

void nsdae_problem_layout(nsdae_problem *p, nsdae_arena *arena)
{
  if (!p->system->by_list) return;
  p->hit = NSDAE_ARENA_INTS(arena, p->dispatch.islands.blocks);
  nsdae_island_dispatch_layout(&p->dispatch, p->system, arena);
}

int nsdae_problem_grow(nsdae_problem *p, const nsdae_room *contacts, const nsdae_room *rows)
{
  const nsdae_array each[ARRAYS] = EACH(p);
  if (!p->system->by_list) return NSDAE_OK;
  int status = nsdae_arrays_grow(each, ARRAYS, contacts->entries);
  if (status == NSDAE_OK) status = nsdae_ids_grow(&p->ids, (int)contacts->entries);
  return status < 0 ? status : nsdae_island_dispatch_grow(&p->dispatch, p->system, contacts, rows);
}

/* ---- what is closed */

/* No two of one id: seen at once where they ascend. */
static int distinct(nsdae_problem *p, const nsdae_closed *c, const nsdae_terms *terms)
{
  int i = 1;
  while (i < c->count && c->id[i - 1] < c->id[i]) i++;
  int twice = i < c->count ? nsdae_ids_fill(&p->ids, c->count, c->id) : -1;
  return twice < 0 ? NSDAE_OK : nsdae_terms_id_twice(terms, c->id[twice]);
}

static void recall(nsdae_problem *p, int a, const nsdae_closed *last, const nsdae_impulses *was,
                   int from)
{
  nsdae_closed *c = p->closed;
  size_t nt = (size_t)c->nt, basis = NSDAE_CLOSED_BASIS * sizeof *c->basis;
  c->fresh[a] = from < 0 || was->normal[from] == 0;
  if (from < 0) {
    memset(c->basis + (size_t)a * NSDAE_CLOSED_BASIS, 0, basis);
    return;
  }
  memcpy(c->basis + (size_t)a * NSDAE_CLOSED_BASIS, last->basis + (size_t)from * NSDAE_CLOSED_BASIS,
         basis);
  p->results->normal[a] = was->normal[from];
  memcpy(p->results->tangential + (size_t)a * nt, was->tangential + (size_t)from * nt,
         nt * sizeof *was->tangential);
}

/* What each did in the step before: mostly its neighbour's neighbour there. */
static void recall_all(nsdae_problem *p, const nsdae_closed *last, const nsdae_impulses *was)
{
  nsdae_closed *c = p->closed;
  int next = 0, filled = 0;
  for (int a = 0; a < c->count; a++) {
    int from = next < last->count && last->id[next] == c->id[a] ? next : -1;
    if (from < 0 && last->count > 0) {
      if (!filled) nsdae_ids_fill(&p->ids, last->count, last->id);
      filled = 1;
      from = nsdae_ids_find(&p->ids, c->id[a]);
    }
    if (from >= 0) next = from + 1;
    recall(p, a, last, was, from);
  }
}

/* The entries with a gap up to touch. */
static void pick(nsdae_problem *p, const nsdae_contact_list *list, double touch)
{
  nsdae_closed *c = p->closed;
  c->count = 0;
  for (int i = 0; i < list->count; i++) {
    if (list->gap[i] > touch) continue;
    int a = c->count++;
    c->id[a] = list->id[i];
    c->gap[a] = list->gap[i];
    memcpy(c->block + 2 * (size_t)a, list->block + 2 * (size_t)i, 2 * sizeof *c->block);
    p->item[a] = i;
    p->law[a] = list->law[i];
  }
}

int nsdae_problem_close_list(nsdae_problem *p, nsdae_terms *terms, const nsdae_closed *last,
                             const nsdae_impulses *was)
{
  double touch = nsdae_terms_touch(terms);
  int status = nsdae_terms_contacts(terms, touch);
  if (status < 0) return status;
  pick(p, &terms->by.list, touch);
  status = distinct(p, p->closed, terms);
  if (status < 0) return status;
  nsdae_closed_clear(p->closed, p->results);
  recall_all(p, last, was);
  nsdae_terms_select(terms, p->closed->count, p->item);
  return NSDAE_OK;
}

/* Entry of closed contact a in the list; next: where it is likely. */
static int entry_of(nsdae_problem *p, const nsdae_contact_list *list, int a, int *next, int *filled)
{
  long id = p->closed->id[a];
  int i = *next < list->count && list->id[*next] == id ? *next : -1;
  if (i < 0) {
    if (!*filled) nsdae_ids_fill(&p->ids, list->count, list->id);
    *filled = 1;
    i = nsdae_ids_find(&p->ids, id);
  }
  if (i >= 0) *next = i + 1;
  return i;
}

int nsdae_problem_update(nsdae_problem *p, nsdae_terms *terms, double reach)
{
  nsdae_contact_list *list = &terms->by.list;
  int next = 0, filled = 0, missing = 0;
  if (terms == p->home) return NSDAE_OK;
  int status = nsdae_terms_contacts(terms, reach);
  if (status < 0) return status;
  for (int a = 0; a < p->closed->count; a++) {
    p->place[a] = entry_of(p, list, a, &next, &filled);
    missing += p->place[a] < 0;
  }
  for (int a = 0; missing > 0 && a < p->closed->count; a++) {
    if (p->place[a] >= 0) continue;
    p->place[a] = list->count;
    nsdae_contact_list_copy(list, &p->home->by.list, p->item[a], reach);
  }
  if (!nsdae_room_enough(&list->room, &list->taken)) {
    terms->have &= ~(unsigned)NSDAE_TERM_CONTACTS;
    return NSDAE_ARRAYS_GROW;
  }
  nsdae_terms_select(terms, p->closed->count, p->place);
  memcpy(p->closed->gap, terms->gap, (size_t)p->closed->count * sizeof *terms->gap);
  return NSDAE_OK;
}

void nsdae_problem_before(nsdae_problem *p, const nsdae_terms *T, const double *v, int impacts_only)
{
  if (p->contacts)
    nsdae_contacts_before(p->contacts, T, v, impacts_only);
  else
    nsdae_contacts_approach(T, p->closed->count, NULL, v, impacts_only, p->results);
}

/* ---- the equations */

static int no_block(nsdae_problem *p, const nsdae_terms *T, int row)
{
  char called[NSDAE_CALLED_SIZE];
  nsdae_error_set(p->error, NSDAE_E_RANK, "nsdae_terms", "constraint_rows",
                  "constraint_rows has no entry for %s at t = %.17g",
                  nsdae_system_called(p->system, NSDAE_NAME_CONSTRAINT, row, called),
                  nsdae_terms_time(T));
  p->error->time = nsdae_terms_time(T);
  p->error->index = row;
  return NSDAE_E_RANK;
}

int nsdae_problem_find_islands(nsdae_problem *p, const nsdae_terms *T)
{
  nsdae_contact_islands *islands = &p->dispatch.islands;
  int row =
      nsdae_contact_islands_find(islands, p->closed->count, p->closed->block, &T->by.jacobian);
  memset(p->hit, 0, (size_t)islands->count * sizeof *p->hit);
  return row < 0 ? NSDAE_OK : no_block(p, T, row);
}

void nsdae_problem_mark_hit(nsdae_problem *p)
{
  for (int a = 0; !p->contacts && a < p->closed->count; a++) {
    const int *pair = p->closed->block + 2 * (size_t)a;
    if (p->results->impact[a]) p->hit[p->dispatch.islands.of[pair[0] >= 0 ? pair[0] : pair[1]]] = 1;
  }
}

/* The system as one island, which is factored. */
static int solve_system(nsdae_problem *p, const nsdae_terms *terms, const double *r,
                        int with_contacts, double *v, double *size, double *lambda)
{
  nsdae_contacts *c = p->contacts;
  nsdae_solved *s = &p->dispatch.solved;
  int any = with_contacts && nsdae_contacts_any(c);
  s->problem = any ? c : NULL;
  s->lcps = any;
  s->pivots = 0;
  if (any) {
    int status = nsdae_contacts_step(c, terms, p->kkt, r, v, size, lambda);
    s->pivots = c->lcp.info.pivots;
    return status;
  }
  memcpy(v, r, (size_t)p->kkt->n * sizeof *v);
  return nsdae_terms_solve(terms, p->kkt, 1, v, lambda);
}

int nsdae_problem_solve(nsdae_problem *p, const nsdae_terms *terms, const double *M,
                        const double *r, int with_contacts, double *v, double *size, double *lambda)
{
  if (p->kkt) return solve_system(p, terms, r, with_contacts, v, size, lambda);
  nsdae_island_equations whole = {.system = p->system,
                                  .islands = &p->dispatch.islands,
                                  .terms = terms,
                                  .law = p->law,
                                  .M = M,
                                  .r = r,
                                  .closed = p->closed,
                                  .results = p->results,
                                  .v = v,
                                  .size = size,
                                  .lambda = lambda,
                                  .with_contacts = with_contacts};
  return nsdae_island_dispatch_solve(&p->dispatch, &whole);
}

int nsdae_problem_solve_mass(nsdae_problem *p, const double *M, double *r)
{
  if (!p->kkt) return nsdae_island_dispatch_solve_mass(&p->dispatch, p->system, M, r);
  nsdae_kkt_solve_mass(p->kkt, r);
  return NSDAE_OK;
}

/* ---- what the impulses did */

void nsdae_problem_add_constraints(const nsdae_problem *p, const nsdae_terms *T, double scale,
                                   int any_impact, const double *lambda, double *y)
{
  const nsdae_rows *J = &T->by.jacobian;
  const nsdae_contact_islands *islands = &p->dispatch.islands;
  if (p->kkt && !any_impact) nsdae_terms_add_constraints(T, scale, lambda, y);
  for (int i = 0; !p->kkt && i < J->count; i++)
    if (!p->hit[islands->of[J->block[J->first[i]]]])
      nsdae_rows_add(&p->system->blocks, J, i, scale * lambda[i], y);
}

void nsdae_problem_add_impulse(const nsdae_problem *p, const nsdae_terms *T, double scale,
                               int skip_impacts, double *y)
{
  const nsdae_impulses *r = p->results;
  const nsdae_blocks *blocks = &p->system->blocks;
  int nt = p->system->dims.nt, skipped = 0;
  for (int a = 0; a < nsdae_problem_count(p); a++) {
    int i = nsdae_problem_contact(p, a), skip = skip_impacts && r->impact[i];
    skipped |= skip;
    if (skip) continue;
    nsdae_rows_add(blocks, &T->by.normal, i, scale * r->normal[i], y);
    for (int j = i * nt; j < (i + 1) * nt; j++)
      nsdae_rows_add(blocks, &T->by.tangent, j, scale * r->tangential[j], y);
  }
  for (int i = 0; p->contacts && !skipped && i < p->contacts->slides.count; i++) {
    int j = p->contacts->slides.number[i];
    nsdae_rows_add(blocks, &T->by.frictional_joint, j, scale * r->frictional_joint_impulse[j], y);
  }
}

double nsdae_problem_work(const nsdae_problem *p)
{
  if (p->contacts) return nsdae_contacts_work(p->contacts);
  return nsdae_impulses_work(p->results, p->system->dims.nt, p->closed->count, NULL);
}

double nsdae_problem_carried(const nsdae_problem *p, const nsdae_terms *T)
{
  if (p->contacts) return 0;
  int k = p->closed->count;
  return nsdae_dot(k, p->results->normal, T->w_N) +
         nsdae_dot(k * p->system->dims.nt, p->results->tangential, T->w_T);
}

double nsdae_problem_residual(const nsdae_problem *p)
{
  return p->contacts ? p->contacts->lcp.info.residual
                     : nsdae_natural_residual_scaled(&p->dispatch.solved.residual);
}
