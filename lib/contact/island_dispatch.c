#include "island_dispatch.h"

#include <stdlib.h>
#include <string.h>

#include "errors.h"
#include "friction_solver.h"
#include "listed.h"

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
  for (int i = 0; i < d->workers; i++) {
    nsdae_worker *w = &d->worker[i];
    nsdae_dense_island_release(&w->dense);
    nsdae_cone_island_release(&w->cones);
    nsdae_sparse_kkt_release(&w->sparse);
    nsdae_friction_destroy(&w->solver);
  }
  free(d->worker);
  nsdae_cone_island_release(&d->kept);
}

void nsdae_island_dispatch_prepare(nsdae_island_dispatch *d, const nsdae_contacts *of,
                                   double rank_tol, int least_norm)
{
  for (int i = 0; i < d->workers; i++) {
    nsdae_worker *w = &d->worker[i];
    nsdae_dense_island_prepare(&w->dense, of, &w->error, rank_tol);
    w->accuracy = of->lcp.accuracy;
    w->least_norm = least_norm;
    w->sparse.rank_tol = rank_tol;
  }
}

void nsdae_island_dispatch_rank(nsdae_island_dispatch *d, double rank_tol, int least_norm)
{
  for (int i = 0; i < d->workers; i++) {
    d->worker[i].dense.kkt.rank_tol = d->worker[i].sparse.rank_tol = rank_tol;
    d->worker[i].least_norm = least_norm;
  }
}

void nsdae_island_dispatch_layout(nsdae_island_dispatch *d, const nsdae_system *system,
                                  nsdae_arena *arena)
{
  nsdae_contact_islands_layout(&d->islands, system, arena);
  d->factorisation.held = NSDAE_ARENA_INTS(arena, system->dims.m);
  d->factorisation.dropped = 1; /* held is made with the first one */
  for (int i = 0; i < d->workers; i++) {
    nsdae_cone_island_layout(&d->worker[i].cones, system, arena);
    d->worker[i].L = NSDAE_ARENA_DOUBLES(arena, nsdae_blocks_largest(&system->blocks));
  }
  nsdae_cone_island_layout(&d->kept, system, arena);
}

/* Room for islands of all contacts. */
static int grow(nsdae_worker *w, const nsdae_system *system, const nsdae_room *contacts,
                const nsdae_room *rows)
{
  int status = nsdae_dense_island_grow(&w->dense, rows);
  w->all_dense = nsdae_dense_island_fits_all(&w->dense);
  if (status < 0 || w->all_dense) return status;
  if (!w->solver) status = nsdae_friction_create(&w->solver);
  if (status == NSDAE_OK) status = nsdae_cone_island_grow(&w->cones, system, contacts, rows);
  if (status < 0 || system->tracked || system->blocks.count > 1) return status;
  if (nsdae_terms_most(system) == NSDAE_ANY_NUMBER) return status;
  return nsdae_cone_island_reserve(&w->cones, system, w->solver);
}

int nsdae_island_dispatch_grow(nsdae_island_dispatch *d, const nsdae_system *system,
                               const nsdae_room *contacts, const nsdae_room *rows)
{
  int status = NSDAE_OK;
  for (int i = 0; i < d->workers && status == NSDAE_OK; i++)
    status = grow(&d->worker[i], system, contacts, rows);
  if (status < 0 || d->worker[0].all_dense) return status;
  return nsdae_cone_island_grow(&d->kept, system, contacts, rows);
}

int nsdae_island_dispatch_reserve(nsdae_island_dispatch *d, const nsdae_terms *T)
{
  const nsdae_system *s = T->system;
  int status = NSDAE_OK;
  for (int i = 0; i < d->workers && status == NSDAE_OK && s->dims.m > 0; i++) {
    nsdae_worker *w = &d->worker[i];
    nsdae_kkt *kkt = &w->dense.kkt;
    const nsdae_kkt_part all = {.blocks = &s->blocks,
                                .J = &T->by.jacobian,
                                .block_count = s->blocks.count,
                                .row_count = s->dims.m,
                                .block = kkt->each,
                                .row = kkt->each};
    if (!kkt->each) continue;
    w->dense.factored = -1;
    nsdae_kkt_turn_to(kkt, &s->blocks, s->dims.nv, s->dims.m);
    status = nsdae_kkt_reserve(kkt, &T->by.jacobian);
    if (status == NSDAE_OK && !w->all_dense) status = nsdae_sparse_kkt_analyse(&w->sparse, &all);
  }
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

/* Nothing is solved yet. */
static void begin(nsdae_worker *w)
{
  if (w->error.status) nsdae_error_clear(&w->error);
  w->failed = -1;
  w->solved = (nsdae_solved){.kept = 1};
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
  begin(w);
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
  for (int i = 0; i < d->workers; i++) begin(&d->worker[i]);
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
