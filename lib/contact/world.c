#include "world.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "errors.h"
#include "dynamic_array.h"

/* Islands that a worker takes at a time; contacts that are not worth waking others for. */
enum { PORTION = 16, FEW = 16 };

nsdae_world *nsdae_world_make(const nsdae_system *system, int threads, nsdae_error *error)
{
  nsdae_world *w = calloc(1, sizeof *w);
  if (!w) return NULL;
  w->system = system;
  w->error = error;
  w->islands.blocks = system->blocks.count;
  w->islands.rows = system->dims.m;
  w->worker = calloc((size_t)threads, sizeof *w->worker);
  if (w->worker) w->workers = threads;
  if (w->worker) w->crew = nsdae_thread_pool_make(threads);
  if (w->crew) return w;
  nsdae_world_release(w);
  return NULL;
}

void nsdae_world_release(nsdae_world *w)
{
  if (!w) return;
  const nsdae_array all[] = {NSDAE_ARRAY(w->item, 1), NSDAE_ARRAY(w->place, 1),
                             NSDAE_ARRAY(w->law, 1), NSDAE_ARRAY(w->islands.contact.of, 1)};
  nsdae_thread_pool_release(w->crew);
  nsdae_arrays_release(all, sizeof all / sizeof *all);
  nsdae_ids_release(&w->ids);
  for (int i = 0; i < w->workers; i++) nsdae_worker_release(&w->worker[i]);
  free(w->worker);
  nsdae_pile_release(&w->pile);
  free(w);
}

void nsdae_world_prepare(nsdae_world *w, const nsdae_lcp_options *options, double rank_tol,
                         int least_norm)
{
  for (int i = 0; i < w->workers; i++)
    nsdae_worker_prepare(&w->worker[i], w->system, options, rank_tol, least_norm);
}

void nsdae_world_layout(nsdae_world *w, nsdae_arena *arena)
{
  w->hit = NSDAE_ARENA_INTS(arena, w->islands.blocks);
  nsdae_graph_layout(&w->islands, arena);
  for (int i = 0; i < w->workers; i++) nsdae_worker_layout(&w->worker[i], w->system, arena);
  nsdae_pile_layout(&w->pile, w->system, arena);
}

int nsdae_world_grow(nsdae_world *w, const nsdae_room *contacts, const nsdae_room *rows)
{
  const nsdae_array all[] = {NSDAE_ARRAY(w->item, 1), NSDAE_ARRAY(w->place, 1),
                             NSDAE_ARRAY(w->law, 1), NSDAE_ARRAY(w->islands.contact.of, 1)};
  int status = nsdae_arrays_grow(all, sizeof all / sizeof *all, contacts->entries);
  for (int i = 0; i < w->workers && status == NSDAE_OK; i++)
    status = nsdae_worker_grow(&w->worker[i], contacts);
  if (status == NSDAE_OK) status = nsdae_ids_grow(&w->ids, (int)contacts->entries);
  return status < 0 ? status : nsdae_pile_grow(&w->pile, w->system, contacts, rows);
}

/* ---- what is closed */

/* No two of one id: seen at once where they ascend. */
static int distinct(nsdae_world *w, const nsdae_closed *c, double t)
{
  int i = 1;
  while (i < c->count && c->id[i - 1] < c->id[i]) i++;
  int twice = i < c->count ? nsdae_ids_fill(&w->ids, c->count, c->id) : -1;
  if (twice < 0) return NSDAE_OK;
  nsdae_error_set(w->error, NSDAE_E_ARGUMENT, "nsdae_contact_add", "id",
                  "two contacts of one list have the id %ld at t = %.17g", c->id[twice], t);
  w->error->time = t;
  return NSDAE_E_ARGUMENT;
}

static void recall(nsdae_world *w, int a, const nsdae_closed *last, const nsdae_impulses *was,
                   int from)
{
  nsdae_closed *c = w->closed;
  size_t nt = (size_t)c->nt, basis = NSDAE_CLOSED_BASIS * sizeof *c->basis;
  c->fresh[a] = from < 0 || was->normal[from] == 0;
  if (from < 0) {
    memset(c->basis + (size_t)a * NSDAE_CLOSED_BASIS, 0, basis);
    return;
  }
  memcpy(c->basis + (size_t)a * NSDAE_CLOSED_BASIS, last->basis + (size_t)from * NSDAE_CLOSED_BASIS,
         basis);
  w->results->normal[a] = was->normal[from];
  memcpy(w->results->tangential + (size_t)a * nt, was->tangential + (size_t)from * nt,
         nt * sizeof *was->tangential);
}

/* What each did in the step before: mostly its neighbour's neighbour there. */
static void recall_all(nsdae_world *w, const nsdae_closed *last, const nsdae_impulses *was)
{
  nsdae_closed *c = w->closed;
  int next = 0, filled = 0;
  for (int a = 0; a < c->count; a++) {
    int from = next < last->count && last->id[next] == c->id[a] ? next : -1;
    if (from < 0 && last->count > 0) {
      if (!filled) nsdae_ids_fill(&w->ids, last->count, last->id);
      filled = 1;
      from = nsdae_ids_find(&w->ids, c->id[a]);
    }
    if (from >= 0) next = from + 1;
    recall(w, a, last, was, from);
  }
}

/* The entries with a gap up to touch. */
static void pick(nsdae_world *w, const nsdae_contact_list *list, double touch)
{
  nsdae_closed *c = w->closed;
  c->count = 0;
  for (int i = 0; i < list->count; i++) {
    if (list->gap[i] > touch) continue;
    int a = c->count++;
    c->id[a] = list->id[i];
    c->gap[a] = list->gap[i];
    memcpy(c->block + 2 * (size_t)a, list->block + 2 * (size_t)i, 2 * sizeof *c->block);
    w->item[a] = i;
    w->law[a] = list->law[i];
  }
}

int nsdae_world_close(nsdae_world *w, nsdae_terms *terms, nsdae_closed *closed,
                      nsdae_impulses *results, const nsdae_closed *last, const nsdae_impulses *was)
{
  double touch = nsdae_terms_touch(terms);
  int status = nsdae_terms_contacts(terms, touch);
  if (status < 0) return status;
  w->closed = closed;
  w->results = results;
  w->home = terms;
  pick(w, &terms->by.list, touch);
  status = distinct(w, closed, nsdae_terms_time(terms));
  if (status < 0) return status;
  nsdae_closed_clear(closed, results);
  recall_all(w, last, was);
  nsdae_terms_select(terms, closed->count, w->item);
  return NSDAE_OK;
}

/* Entry of closed contact a in the list; next: where it is likely. */
static int entry_of(nsdae_world *w, const nsdae_contact_list *list, int a, int *next, int *filled)
{
  long id = w->closed->id[a];
  int i = *next < list->count && list->id[*next] == id ? *next : -1;
  if (i < 0) {
    if (!*filled) nsdae_ids_fill(&w->ids, list->count, list->id);
    *filled = 1;
    i = nsdae_ids_find(&w->ids, id);
  }
  if (i >= 0) *next = i + 1;
  return i;
}

int nsdae_world_meet(nsdae_world *w, nsdae_terms *terms, double reach)
{
  nsdae_contact_list *list = &terms->by.list;
  int next = 0, filled = 0, missing = 0;
  if (terms == w->home) return NSDAE_OK;
  int status = nsdae_terms_contacts(terms, reach);
  if (status < 0) return status;
  for (int a = 0; a < w->closed->count; a++) {
    w->place[a] = entry_of(w, list, a, &next, &filled);
    missing += w->place[a] < 0;
  }
  for (int a = 0; missing > 0 && a < w->closed->count; a++) {
    if (w->place[a] >= 0) continue;
    w->place[a] = list->count;
    nsdae_contact_list_copy(list, &w->home->by.list, w->item[a], reach);
  }
  if (!nsdae_room_enough(&list->room, &list->taken)) {
    terms->have &= ~(unsigned)NSDAE_TERM_CONTACTS;
    return NSDAE_ARRAYS_GROW;
  }
  nsdae_terms_select(terms, w->closed->count, w->place);
  memcpy(w->closed->gap, terms->gap, (size_t)w->closed->count * sizeof *terms->gap);
  return NSDAE_OK;
}

void nsdae_world_before(nsdae_world *w, const nsdae_terms *T, const double *v, int impacts_only)
{
  nsdae_impulses *r = w->results;
  int nt = w->system->dims.nt;
  for (int a = 0; a < w->closed->count; a++) {
    if (impacts_only && !r->impact[a]) continue;
    r->before[a] = nsdae_terms_normal_rate(T, a, v);
    for (int j = a * nt; j < (a + 1) * nt; j++) r->before_t[j] = nsdae_terms_tangent_rate(T, j, v);
  }
}

/* ---- the equations */

static int no_block(nsdae_world *w, const nsdae_terms *T, int row)
{
  char called[NSDAE_CALLED_SIZE];
  nsdae_error_set(w->error, NSDAE_E_RANK, "nsdae_terms", "constraint_rows",
                  "constraint_rows has no entry for %s at t = %.17g",
                  nsdae_system_called(w->system, NSDAE_NAME_CONSTRAINT, row, called),
                  nsdae_terms_time(T));
  w->error->time = nsdae_terms_time(T);
  w->error->index = row;
  return NSDAE_E_RANK;
}

int nsdae_world_join(nsdae_world *w, const nsdae_terms *T)
{
  int row = nsdae_graph_find(&w->islands, w->closed->count, w->closed->block, &T->by.jacobian);
  memset(w->hit, 0, (size_t)w->islands.count * sizeof *w->hit);
  return row < 0 ? NSDAE_OK : no_block(w, T, row);
}

static int island_of(const nsdae_world *w, int a)
{
  const int *pair = w->closed->block + 2 * (size_t)a;
  return w->islands.of[pair[0] >= 0 ? pair[0] : pair[1]];
}

void nsdae_world_mark_hit(nsdae_world *w)
{
  for (int a = 0; a < w->closed->count; a++)
    if (w->results->impact[a]) w->hit[island_of(w, a)] = 1;
}

/* With the record of the worker that failed. */
static int carry_out(nsdae_world *w, const nsdae_worker *from)
{
  *w->error = from->error;
  return from->error.status;
}

int nsdae_world_solve_mass(nsdae_world *w, const double *M, double *r)
{
  int status = NSDAE_OK;
  for (int b = 0; b < w->islands.blocks && status == NSDAE_OK; b++)
    status =
        nsdae_worker_solve_block(&w->worker[0], w->system, M, b, r + w->system->blocks.first[b]);
  return status < 0 ? carry_out(w, &w->worker[0]) : status;
}

/* What no contact and no constraint holds. */
static int solve_free(nsdae_world *w, const nsdae_whole *whole)
{
  const nsdae_blocks *blocks = &w->system->blocks;
  int status = NSDAE_OK;
  for (int b = 0; b < blocks->count && status == NSDAE_OK; b++) {
    if (w->islands.of[b] >= 0) continue;
    int at = blocks->first[b];
    size_t bytes = (size_t)nsdae_blocks_size(blocks, b) * sizeof(double);
    memcpy(whole->v + at, whole->r + at, bytes);
    status = nsdae_worker_solve_block(&w->worker[0], w->system, whole->M, b, whole->v + at);
    memcpy(whole->size + at, whole->v + at, bytes);
  }
  return status < 0 ? carry_out(w, &w->worker[0]) : status;
}

/* What the passes over islands share; each writes its own places of them. */
typedef struct shared {
  nsdae_world *world;
  const nsdae_whole *whole;
  int with_contacts;
  int *cones; /* islands: left to the pile; then which are, in their order */
} shared;

static int note(nsdae_worker *worker, int pass, int status)
{
  if (status < 0) worker->failed = pass;
  return status;
}

static int solve_island(void *object, int worker, int island)
{
  const shared *s = object;
  nsdae_worker *by = &s->world->worker[worker];
  return note(by, island,
              nsdae_worker_solve(by, s->whole, island, s->with_contacts, &s->cones[island]));
}

static int solve_part(void *object, int worker, int part)
{
  const shared *s = object;
  nsdae_worker *by = &s->world->worker[worker];
  return note(by, part, nsdae_worker_solve_cones(by, &s->world->pile, s->whole, part));
}

/* Passes 0 .. count - 1; the first failure is reported, as on one thread. */
static int share(nsdae_world *w, shared *s, int count, int portion, nsdae_thread_pool_pass *pass)
{
  int alone = w->closed->count + w->system->dims.m < FEW;
  int failed = nsdae_thread_pool_run(w->crew, alone, count, portion, pass, s);
  if (failed < 0) return NSDAE_OK;
  int by = 0;
  while (w->worker[by].failed != failed) by++;
  w->solved.problem = w->worker[by].solved.problem;
  return carry_out(w, &w->worker[by]);
}

/* Those that have cones or are large, one part each; how many. Without any the last pile of the
 * step stays as it was. */
static int gather_pile(nsdae_world *w, const nsdae_whole *whole, const int *cones)
{
  int first = 0;
  while (first < w->islands.count && !cones[first]) first++;
  if (first == w->islands.count) return 0;
  nsdae_pile_begin(&w->pile);
  for (int i = first; i < w->islands.count; i++)
    if (cones[i]) nsdae_pile_add(&w->pile, whole, i);
  w->solved.pile = &w->pile;
  return w->pile.parts;
}

/* Every island by what fits it. The marks are in place of the parents, which nobody asks any more.
 */
static int solve_islands(nsdae_world *w, const nsdae_whole *whole, int with_contacts)
{
  shared s = {w, whole, with_contacts, w->islands.parent};
  for (int i = 0; i < w->workers; i++) nsdae_worker_begin(&w->worker[i]);
  int status = share(w, &s, w->islands.count, PORTION, solve_island);
  if (status == NSDAE_OK) status = share(w, &s, gather_pile(w, whole, s.cones), 1, solve_part);
  for (int i = 0; i < w->workers; i++) nsdae_solved_add(&w->solved, &w->worker[i].solved);
  return status;
}

int nsdae_world_solve(nsdae_world *w, const nsdae_terms *terms, const double *M, const double *r,
                      int with_contacts, double *v, double *size, double *lambda)
{
  const nsdae_whole whole = {.system = w->system,
                             .islands = &w->islands,
                             .terms = terms,
                             .law = w->law,
                             .M = M,
                             .r = r,
                             .closed = w->closed,
                             .results = w->results,
                             .v = v,
                             .size = size,
                             .lambda = lambda};
  w->solved = (nsdae_solved){.islands = w->islands.count, .kept = 1};
  int status = solve_free(w, &whole);
  return status < 0 ? status : solve_islands(w, &whole, with_contacts);
}

/* ---- what the impulses did */

void nsdae_world_add_constraints(const nsdae_world *w, const nsdae_terms *T, double scale,
                                 const double *lambda, double *y)
{
  const nsdae_rows *J = &T->by.jacobian;
  for (int i = 0; i < J->count; i++)
    if (!w->hit[w->islands.of[J->block[J->first[i]]]])
      nsdae_rows_add(&w->system->blocks, J, i, scale * lambda[i], y);
}

void nsdae_world_add_impulse(const nsdae_world *w, const nsdae_terms *T, double scale,
                             int skip_impacts, double *y)
{
  const nsdae_impulses *r = w->results;
  const nsdae_blocks *blocks = &w->system->blocks;
  int nt = w->system->dims.nt;
  for (int a = 0; a < w->closed->count; a++) {
    if (skip_impacts && r->impact[a]) continue;
    nsdae_rows_add(blocks, &T->by.normal, a, scale * r->normal[a], y);
    for (int j = a * nt; j < (a + 1) * nt; j++)
      nsdae_rows_add(blocks, &T->by.tangent, j, scale * r->tangential[j], y);
  }
}

double nsdae_world_work(const nsdae_world *w)
{
  const nsdae_impulses *r = w->results;
  int k = w->closed->count, kt = k * w->system->dims.nt;
  double work = 0;
  for (int a = 0; a < k; a++) work += r->normal[a] * (r->after[a] + r->before[a]) / 2;
  for (int j = 0; j < kt; j++) work += r->tangential[j] * (r->after_t[j] + r->before_t[j]) / 2;
  return work;
}

double nsdae_world_carried(const nsdae_world *w, const nsdae_terms *T)
{
  int k = w->closed->count;
  return nsdae_dot(k, w->results->normal, T->w_N) +
         nsdae_dot(k * w->system->dims.nt, w->results->tangential, T->w_T);
}
