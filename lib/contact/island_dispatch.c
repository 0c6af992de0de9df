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
  nsdae_pile_release(&d->pile);
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
  nsdae_graph_layout(&d->islands, arena);
  for (int i = 0; i < d->workers; i++) nsdae_worker_layout(&d->worker[i], system, arena);
  nsdae_pile_layout(&d->pile, system, arena);
}

int nsdae_island_dispatch_grow(nsdae_island_dispatch *d, const nsdae_system *system,
                               const nsdae_room *contacts, const nsdae_room *rows)
{
  int status = NSDAE_OK;
  for (int i = 0; i < d->workers && status == NSDAE_OK; i++)
    status = nsdae_worker_grow(&d->worker[i], contacts);
  return status < 0 ? status : nsdae_pile_grow(&d->pile, system, contacts, rows);
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
static int solve_free(nsdae_island_dispatch *d, const nsdae_whole *whole)
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
  nsdae_worker *by = &s->by->worker[worker];
  return note(by, island,
              nsdae_worker_solve(by, s->whole, island, s->with_contacts, &s->cones[island]));
}

static int solve_part(void *object, int worker, int part)
{
  const shared *s = object;
  nsdae_worker *by = &s->by->worker[worker];
  return note(by, part, nsdae_worker_solve_cones(by, &s->by->pile, s->whole, part));
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

/* Those that have cones or are large, one part each; how many. Without any the last pile of the
 * step stays as it was. */
static int gather_pile(nsdae_island_dispatch *d, const nsdae_whole *whole, const int *cones)
{
  int first = 0;
  while (first < d->islands.count && !cones[first]) first++;
  if (first == d->islands.count) return 0;
  nsdae_pile_begin(&d->pile);
  for (int i = first; i < d->islands.count; i++)
    if (cones[i]) nsdae_pile_add(&d->pile, whole, i);
  d->solved.pile = &d->pile;
  return d->pile.parts;
}

/* The marks are in place of the parents, which are not read after the islands are found. */
int nsdae_island_dispatch_solve(nsdae_island_dispatch *d, const nsdae_whole *whole,
                                int with_contacts)
{
  shared s = {d, whole, with_contacts, d->islands.parent};
  d->solved = (nsdae_solved){.islands = d->islands.count, .kept = 1};
  int status = solve_free(d, whole);
  if (status < 0) return status;
  for (int i = 0; i < d->workers; i++) nsdae_worker_begin(&d->worker[i]);
  status = share(d, &s, d->islands.count, PORTION, solve_island);
  if (status == NSDAE_OK) status = share(d, &s, gather_pile(d, whole, s.cones), 1, solve_part);
  for (int i = 0; i < d->workers; i++) nsdae_solved_add(&d->solved, &d->worker[i].solved);
  return status;
}
