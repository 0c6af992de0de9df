#include "island_dispatch.h"

#include <stdlib.h>
#include <string.h>

/* Islands that a worker takes at a time; contacts that are not worth waking others for. */
enum { PORTION = 16, FEW = 16 };

int nsdae_island_dispatch_make(nsdae_island_dispatch *d, const nsdae_system *system, int threads,
                               nsdae_error *error)
{
  d->error = error;
  d->islands.blocks = system->blocks.count;
  d->islands.rows = system->dims.m;
  d->worker = calloc((size_t)threads, sizeof *d->worker);
  if (d->worker) d->workers = threads;
  if (d->worker) d->pool = nsdae_thread_pool_make(threads);
  return d->pool ? NSDAE_OK : NSDAE_E_MEMORY;
}

void nsdae_island_dispatch_release(nsdae_island_dispatch *d)
{
  nsdae_thread_pool_release(d->pool);
  for (int i = 0; i < d->workers; i++) nsdae_worker_release(&d->worker[i]);
  free(d->worker);
  nsdae_cone_island_release(&d->kept);
}

void nsdae_island_dispatch_prepare(nsdae_island_dispatch *d, const nsdae_system *system,
                                   const nsdae_lcp_options *options, double rank_tol,
                                   int least_norm)
{
  for (int i = 0; i < d->workers; i++)
    nsdae_worker_prepare(&d->worker[i], system, options, rank_tol, least_norm);
}

void nsdae_island_dispatch_layout(nsdae_island_dispatch *d, const nsdae_system *system,
                                  nsdae_arena *arena)
{
  nsdae_contact_islands_layout(&d->islands, arena);
  for (int i = 0; i < d->workers; i++) nsdae_worker_layout(&d->worker[i], system, arena);
  nsdae_cone_island_layout(&d->kept, system, arena);
}

int nsdae_island_dispatch_grow(nsdae_island_dispatch *d, const nsdae_system *system,
                               const nsdae_room *contacts, const nsdae_room *rows)
{
  int status = NSDAE_OK;
  for (int i = 0; i < d->workers && status == NSDAE_OK; i++)
    status = nsdae_worker_grow(&d->worker[i], system, contacts, rows);
  return status < 0 ? status : nsdae_cone_island_grow(&d->kept, system, contacts, rows);
}

/* With the record of the worker that failed. */
static int carry_out(nsdae_island_dispatch *d, const nsdae_worker *from)
{
  *d->error = from->error;
  return from->error.status;
}

int nsdae_island_dispatch_solve_mass(nsdae_island_dispatch *d, const nsdae_system *system,
                                     const double *M, double *r)
{
  int status = NSDAE_OK;
  for (int b = 0; b < system->blocks.count && status == NSDAE_OK; b++)
    status = nsdae_worker_solve_block(&d->worker[0], system, M, b, r + system->blocks.first[b]);
  return status < 0 ? carry_out(d, &d->worker[0]) : status;
}

/* Blocks that no contact and no constraint touches. */
static int solve_free(nsdae_island_dispatch *d, const nsdae_island_equations *whole)
{
  const nsdae_blocks *blocks = &whole->system->blocks;
  int status = NSDAE_OK;
  for (int b = 0; b < blocks->count && status == NSDAE_OK; b++) {
    if (d->islands.of[b] >= 0) continue;
    int at = blocks->first[b];
    size_t bytes = (size_t)nsdae_blocks_size(blocks, b) * sizeof(double);
    memcpy(whole->v + at, whole->r + at, bytes);
    status = nsdae_worker_solve_block(&d->worker[0], whole->system, whole->M, b, whole->v + at);
    memcpy(whole->size + at, whole->v + at, bytes);
  }
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

static int second_pass(void *object, int worker, int item)
{
  const shared *s = object;
  nsdae_worker *by = &s->by->worker[worker];
  return note(by, item, nsdae_worker_solve(by, s->whole, s->second[item], 1));
}

/* Passes 0 .. count - 1; the first failure is reported, as on one thread. */
static int share(nsdae_island_dispatch *d, shared *s, int count, int portion,
                 nsdae_thread_pool_pass *pass)
{
  int alone = s->whole->closed->count + s->whole->system->dims.m < FEW;
  int failed = nsdae_thread_pool_run(d->pool, alone, count, portion, pass, s);
  if (failed < 0) return NSDAE_OK;
  int by = 0;
  while (d->worker[by].failed != failed) by++;
  d->solved.problem = d->worker[by].solved.problem;
  return carry_out(d, &d->worker[by]);
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
  if (count > 0) d->solved.cones = &d->kept;
  return count;
}

/* The marks are in place of the parents, which are not read after the islands are found. */
int nsdae_island_dispatch_solve(nsdae_island_dispatch *d, nsdae_island_equations *whole)
{
  shared s = {d, whole, d->islands.parent};
  d->solved = (nsdae_solved){.islands = d->islands.count, .kept = 1};
  int status = solve_free(d, whole);
  if (status < 0) return status;
  for (int i = 0; i < d->workers; i++) nsdae_worker_begin(&d->worker[i]);
  status = share(d, &s, d->islands.count, PORTION, first_pass);
  if (status == NSDAE_OK) status = share(d, &s, list_second(d, whole, s.second), 1, second_pass);
  for (int i = 0; i < d->workers; i++) nsdae_solved_add(&d->solved, &d->worker[i].solved);
  return status;
}
