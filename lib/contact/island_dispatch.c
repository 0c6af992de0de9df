#include "island_dispatch.h"

#include <stdlib.h>
#include <string.h>

#include "friction_solver.h"

/* Islands that a worker takes at a time; contacts that are not worth waking others for; contacts of
 * an island that is solved by all threads together. */
enum { PORTION = 16, FEW = 16, LARGE = 256 };

int nsdae_island_dispatch_make(nsdae_island_dispatch *d, const nsdae_system *system, int threads,
                               nsdae_error *error)
{
  d->error = error;
  d->solved = &d->sum;
  if (system->blocks.count == 1) threads = 1;
  d->worker = calloc((size_t)threads, sizeof *d->worker);
  if (d->worker) d->workers = threads;
  if (d->worker) d->pool = nsdae_thread_pool_make(threads);
  return d->pool ? nsdae_contact_shares_make(&d->shares, d->pool) : NSDAE_E_MEMORY;
}

void nsdae_island_dispatch_release(nsdae_island_dispatch *d)
{
  nsdae_contact_shares_release(&d->shares);
  nsdae_thread_pool_release(d->pool);
  for (int i = 0; i < d->workers; i++) nsdae_worker_release(&d->worker[i]);
  free(d->worker);
  nsdae_cone_island_release(&d->kept);
}

void nsdae_island_dispatch_prepare(nsdae_island_dispatch *d, const nsdae_contacts *of,
                                   double rank_tol, int least_norm)
{
  for (int i = 0; i < d->workers; i++)
    nsdae_worker_prepare(&d->worker[i], of, rank_tol, least_norm);
}

void nsdae_island_dispatch_layout(nsdae_island_dispatch *d, const nsdae_system *system,
                                  nsdae_arena *arena)
{
  nsdae_contact_islands_layout(&d->islands, system, arena);
  d->factorisation.held = NSDAE_ARENA_INTS(arena, system->dims.m);
  d->factorisation.dropped = 1; /* held is made with the first one */
  for (int i = 0; i < d->workers; i++) nsdae_worker_layout(&d->worker[i], system, arena);
  nsdae_cone_island_layout(&d->kept, system, arena);
}

int nsdae_island_dispatch_grow(nsdae_island_dispatch *d, const nsdae_system *system,
                               const nsdae_room *contacts, const nsdae_room *rows)
{
  int status = NSDAE_OK;
  for (int i = 0; i < d->workers && status == NSDAE_OK; i++)
    status = nsdae_worker_grow(&d->worker[i], system, contacts, rows);
  if (status < 0 || nsdae_dense_island_fits_all(&d->worker[0].dense)) return status;
  return nsdae_cone_island_grow(&d->kept, system, contacts, rows);
}

int nsdae_island_dispatch_reserve(nsdae_island_dispatch *d, const nsdae_terms *terms)
{
  int status = NSDAE_OK;
  for (int i = 0; i < d->workers && status == NSDAE_OK; i++)
    status = nsdae_worker_reserve(&d->worker[i], terms);
  return status;
}

/* With the record of the worker that failed. */
static int carry_out(nsdae_island_dispatch *d, const nsdae_worker *from)
{
  *d->error = from->error;
  return from->error.status;
}

int nsdae_island_dispatch_solve_mass(nsdae_island_dispatch *d, const nsdae_terms *T, double *r)
{
  const nsdae_system *s = T->system;
  nsdae_worker *w = &d->worker[0];
  int status = NSDAE_OK;
  if (nsdae_dense_island_solve_mass(&w->dense, d->factorisation.number, r)) return NSDAE_OK;
  for (int b = 0; b < s->blocks.count && status == NSDAE_OK; b++)
    status = nsdae_worker_solve_block(w, T, T->M, b, r + s->blocks.first[b]);
  return status < 0 ? carry_out(d, w) : status;
}

/* Blocks that no contact and no constraint touches. */
static int solve_free(nsdae_island_dispatch *d, const nsdae_island_equations *whole)
{
  int status = NSDAE_OK;
  for (int b = 0; b < d->islands.blocks && status == NSDAE_OK; b++)
    if (d->islands.of[b] < 0) status = nsdae_worker_solve_free(&d->worker[0], whole, b);
  return status < 0 ? carry_out(d, &d->worker[0]) : status;
}

/* What the passes over islands share; each writes its own places of them. */
typedef struct shared {
  nsdae_island_dispatch *by;
  const nsdae_island_equations *whole;
  int *second; /* islands: left to the second pass; then which are, in their order */
} shared;

static int note(nsdae_worker *worker, int item, int status)
{
  if (status < 0) worker->failed = item;
  return status;
}

static int first_pass(void *object, int worker, int island)
{
  const shared *s = object;
  nsdae_worker *by = &s->by->worker[worker];
  int status = nsdae_worker_solve(by, s->whole, island, 0);
  s->second[island] = status == NSDAE_NEXT;
  return note(by, island, status == NSDAE_NEXT ? NSDAE_OK : status);
}

static int solve_second(const shared *s, int worker, int item)
{
  nsdae_worker *by = &s->by->worker[worker];
  return note(by, item, nsdae_worker_solve(by, s->whole, s->second[item], 1));
}

static int is_large(const nsdae_island_dispatch *d, int island)
{
  return nsdae_members_count(&d->islands.contact, island) >= LARGE;
}

static int second_pass(void *object, int worker, int item)
{
  const shared *s = object;
  return is_large(s->by, s->second[item]) ? NSDAE_OK : solve_second(s, worker, item);
}

/* The record of pass `failed`. */
static int report(nsdae_island_dispatch *d, int failed)
{
  int by = 0;
  while (d->worker[by].failed != failed) by++;
  d->sum.problem = d->worker[by].solved.problem;
  return carry_out(d, &d->worker[by]);
}

/* Passes 0 .. count - 1; the first failure is reported, as on one thread. */
static int share(nsdae_island_dispatch *d, shared *s, int count, int portion,
                 nsdae_thread_pool_pass *pass)
{
  const nsdae_contact_islands *is = &d->islands;
  int alone = is->contact.first[is->count] + is->rows + is->joints < FEW;
  int failed = nsdae_thread_pool_run(d->pool, alone, count, portion, pass, s);
  return failed < 0 ? NSDAE_OK : report(d, failed);
}

/* Solves an island by all threads together. */
static int solve_large(const shared *s, int item)
{
  nsdae_worker *first = &s->by->worker[0];
  nsdae_fc_set_pool(first->solver, s->by->pool);
  int status = solve_second(s, 0, item);
  nsdae_fc_set_pool(first->solver, NULL);
  return status;
}

/* The large islands, then the others before one that failed. */
static int share_second(nsdae_island_dispatch *d, shared *s, int count)
{
  int end = 0;
  while (end < count && (!is_large(d, s->second[end]) || solve_large(s, end) >= 0)) end++;
  int status = share(d, s, end, 1, second_pass);
  return status < 0 || end == count ? status : report(d, end);
}

/* Those of the second pass, in place of their marks; how many. The problem of the largest is kept:
 * without any, that of before. */
static int list_second(nsdae_island_dispatch *d, nsdae_island_equations *whole, int *second)
{
  int count = 0, most = -1;
  for (int i = 0; i < d->islands.count; i++) {
    if (!second[i]) continue;
    int contacts = nsdae_members_count(&d->islands.contact, i);
    second[count++] = i;
    if (contacts <= most) continue;
    most = contacts;
    whole->kept_island = i;
  }
  whole->kept = &d->kept;
  if (count > 0) d->sum.cones = &d->kept;
  return count;
}

/* One island by the thread that calls. */
static int solve_one(nsdae_island_dispatch *d, nsdae_island_equations *whole)
{
  nsdae_worker *w = &d->worker[0];
  nsdae_worker_begin(w);
  int status = nsdae_worker_solve(w, whole, 0, 0);
  if (status == NSDAE_NEXT) {
    whole->kept = &d->kept;
    whole->kept_island = 0;
    w->solved.cones = &d->kept;
    nsdae_fc_set_pool(w->solver, d->pool);
    status = nsdae_worker_solve(w, whole, 0, 1);
    nsdae_fc_set_pool(w->solver, NULL);
  }
  w->solved.islands = 1;
  return status < 0 ? carry_out(d, w) : status;
}

/* The marks are in place of the parents, which are not read after the islands are found. */
static int solve_all(nsdae_island_dispatch *d, nsdae_island_equations *whole)
{
  shared s = {d, whole, d->islands.parent};
  for (int i = 0; i < d->workers; i++) nsdae_worker_begin(&d->worker[i]);
  int status = share(d, &s, d->islands.count, PORTION, first_pass);
  if (status == NSDAE_OK) status = share_second(d, &s, list_second(d, whole, s.second));
  /* which islands were solved beside one that failed depends on the threads */
  for (int i = 0; i < d->workers && status == NSDAE_OK; i++)
    nsdae_solved_add(&d->sum, &d->worker[i].solved);
  return status;
}

int nsdae_island_dispatch_solve(nsdae_island_dispatch *d, nsdae_island_equations *whole)
{
  int count = d->islands.count, status = NSDAE_OK;
  d->solved = count == 1 ? &d->worker[0].solved : &d->sum;
  if (count != 1) d->sum = (nsdae_solved){.islands = count, .kept = 1};
  if (count == 0 || d->islands.blocks > 1) status = solve_free(d, whole);
  if (status < 0 || count == 0) return status;
  status = count == 1 ? solve_one(d, whole) : solve_all(d, whole);
  d->factorisation.dropped = d->solved->rank < d->islands.rows;
  return status;
}
