#include "worker.h"

#include <math.h>
#include <string.h>

#include "errors.h"
#include "single.h"

void nsdae_worker_prepare(nsdae_worker *w, const nsdae_system *system,
                          const nsdae_lcp_options *options, double rank_tol, int least_norm)
{
  nsdae_dense_island_prepare(&w->dense, system, &w->error, options, rank_tol);
  w->tol = options->tol;
  w->least_norm = least_norm;
  w->sparse.rank_tol = rank_tol;
}

void nsdae_worker_layout(nsdae_worker *w, const nsdae_system *system, nsdae_arena *arena)
{
  nsdae_dense_island_layout(&w->dense, arena);
  nsdae_active_set_layout(&w->active_set, system, arena);
  nsdae_cone_island_layout(&w->cones, system, arena);
  w->L = NSDAE_ARENA_DOUBLES(arena, nsdae_blocks_largest(&system->blocks));
}

int nsdae_worker_grow(nsdae_worker *w, const nsdae_system *system, const nsdae_room *contacts,
                      const nsdae_room *rows)
{
  int status = w->solver ? NSDAE_OK : nsdae_friction_create(&w->solver);
  if (status == NSDAE_OK) status = nsdae_active_set_grow(&w->active_set, contacts);
  return status < 0 ? status : nsdae_cone_island_grow(&w->cones, system, contacts, rows);
}

void nsdae_worker_release(nsdae_worker *w)
{
  nsdae_active_set_release(&w->active_set);
  nsdae_cone_island_release(&w->cones);
  nsdae_sparse_kkt_release(&w->sparse);
  nsdae_friction_destroy(&w->solver);
}

void nsdae_worker_begin(nsdae_worker *w)
{
  nsdae_error_clear(&w->error);
  w->failed = -1;
  w->solved = (nsdae_solved){.kept = 1};
}

/* ---- certificates */

static void count_rank(nsdae_solved *s, int rank, double kept, double left)
{
  s->rank += rank;
  s->kept = fmin(s->kept, kept);
  s->left = fmax(s->left, left);
}

void nsdae_solved_add(nsdae_solved *sum, const nsdae_solved *one)
{
  nsdae_natural_residual_add(&sum->residual, &one->residual);
  sum->noise = fmax(sum->noise, one->noise);
  sum->pivots += one->pivots;
  sum->lcps += one->lcps;
  count_rank(sum, one->rank, one->kept, one->left);
  if (one->contacts > sum->contacts) sum->contacts = one->contacts;
}

static int bad_mass(nsdae_worker *w, const nsdae_system *system, int b, int pivot)
{
  nsdae_error_set(&w->error, NSDAE_E_MASS, "nsdae_terms", "mass_blocks",
                  "the mass matrix of block %d is not positive definite: pivot %d of %d is not "
                  "above rounding; check the callback mass_blocks",
                  b, pivot, nsdae_blocks_size(&system->blocks, b));
  nsdae_system_name_item(system, NSDAE_NAME_VELOCITY, system->blocks.first[b] + pivot - 1,
                         &w->error);
  return NSDAE_E_MASS;
}

int nsdae_worker_solve_block(nsdae_worker *w, const nsdae_system *system, const double *M, int b,
                             double *x)
{
  nsdae_block_factor factor = {.L = w->L};
  int pivot = nsdae_blocks_factor(&system->blocks, b, M, &factor);
  if (pivot) return bad_mass(w, system, b, pivot);
  nsdae_blocks_solve(&factor, x);
  return NSDAE_OK;
}

/* ---- solvers of an island */

static int has_contacts(const nsdae_island_equations *whole, int island)
{
  return whole->with_contacts && nsdae_members_count(&whole->islands->contact, island) > 0;
}

static int fits_one_contact(const nsdae_island_equations *whole, int island)
{
  return whole->with_contacts && nsdae_single_fits(whole, island);
}

/* The next one if more than rounding is left. */
static int solve_one_contact(nsdae_worker *w, const nsdae_island_equations *whole, int island)
{
  nsdae_natural_residual residual;
  if (!nsdae_single_solve(whole, island, &residual)) return NSDAE_NEXT;
  w->solved.lcps++;
  nsdae_natural_residual_add(&w->solved.residual, &residual);
  return NSDAE_OK;
}

static int fits_active_set(const nsdae_island_equations *whole, int island)
{
  return has_contacts(whole, island) && nsdae_active_set_fits(whole, island);
}

static int solve_active_set(nsdae_worker *w, const nsdae_island_equations *whole, int island)
{
  nsdae_active_set_island *c = &w->active_set;
  if (!nsdae_active_set_solve(c, whole, island, w->tol, w->L)) return NSDAE_NEXT;
  w->solved.lcps++;
  w->solved.pivots += c->rounds;
  nsdae_natural_residual_add(&w->solved.residual, &c->residual);
  return NSDAE_OK;
}

static int unsolved(nsdae_worker *w, const nsdae_island_equations *whole, int island, int status)
{
  const nsdae_contact_islands *is = whole->islands;
  double t = nsdae_terms_time(whole->terms);
  nsdae_error_set(
      &w->error, status, "nsdae_terms", "constraint_rows",
      "the equations of the island of block %d, with %d constraints, were not solved at "
      "t = %.17g: %s",
      is->block.of[is->block.first[island]], nsdae_members_count(&is->row, island), t,
      nsdae_status_message(status));
  w->error.time = t;
  return status;
}

/* dependent: the first row that depends on others. */
static int bad_rank(nsdae_worker *w, const nsdae_island_equations *whole, int island, int rank,
                    int dependent)
{
  const nsdae_contact_islands *is = whole->islands;
  double t = nsdae_terms_time(whole->terms);
  nsdae_error_set(&w->error, NSDAE_E_RANK, "nsdae_terms", "constraint_rows",
                  "in the island of block %d: Phi_q has rank %d of %d at t = %.17g: leave out the "
                  "redundant constraints or set redundant = least-norm; the first that depends on "
                  "others",
                  is->block.of[is->block.first[island]], rank,
                  nsdae_members_count(&is->row, island), t);
  w->error.time = t;
  nsdae_system_name_item(whole->system, NSDAE_NAME_CONSTRAINT, dependent, &w->error);
  return NSDAE_E_RANK;
}

/* Pivot of the island's M, from 1, as one of a block. */
static int bad_local_mass(nsdae_worker *w, const nsdae_island_equations *whole, int island,
                          int pivot)
{
  const int *block = whole->islands->block.of + whole->islands->block.first[island];
  for (; pivot > nsdae_blocks_size(&whole->system->blocks, *block); block++)
    pivot -= nsdae_blocks_size(&whole->system->blocks, *block);
  return bad_mass(w, whole->system, *block, pivot);
}

/* The record of the contact problem, with the island in front of it. */
static int name_island(nsdae_worker *w, const nsdae_island_equations *whole, int island, int status)
{
  const nsdae_contact_islands *is = whole->islands;
  const nsdae_error was = w->error;
  int b = is->block.of[is->block.first[island]], count = nsdae_members_count(&is->contact, island);
  if (count == 0)
    nsdae_error_set(&w->error, status, was.where, was.argument, "in the island of block %d: %.200s",
                    b, was.text);
  else
    nsdae_error_set(&w->error, status, was.where, was.argument,
                    "in the island of block %d (%d contacts, first id %ld): %.150s", b, count,
                    whole->closed->id[is->contact.of[is->contact.first[island]]], was.text);
  w->error.time = was.time;
  w->error.index = b;
  return status;
}

static int solve_dense(nsdae_worker *w, const nsdae_island_equations *whole, int island)
{
  nsdae_dense_island *l = &w->dense;
  nsdae_solved *s = &w->solved;
  const nsdae_kkt *kkt = &l->kkt;
  nsdae_natural_residual residual = {0};
  int status = nsdae_dense_island_solve(l, whole, island, w->least_norm, &residual);
  count_rank(s, kkt->rank, kkt->kept, kkt->left);
  if (nsdae_contacts_any(&l->contacts)) {
    s->lcps++;
    s->pivots += l->contacts.lcp.info.pivots;
    nsdae_natural_residual_add(&s->residual, &residual);
  }
  if (status == NSDAE_OK) return status;
  if (status == NSDAE_E_MASS) return bad_local_mass(w, whole, island, kkt->pivot);
  if (status == NSDAE_E_RANK)
    return bad_rank(w, whole, island, kkt->rank,
                    whole->islands->row.of[whole->islands->row.first[island] + kkt->dependent]);
  s->problem = &l->contacts;
  return name_island(w, whole, island, status);
}

/* The factors of the constraints of a large island, and their rank. */
static int factor_sparse(nsdae_worker *w, const nsdae_island_equations *whole, int island)
{
  const nsdae_contact_islands *is = whole->islands;
  nsdae_sparse_kkt *k = &w->sparse;
  const nsdae_kkt_part part = {.blocks = &whole->system->blocks,
                               .J = &whole->terms->by.jacobian,
                               .block_count = nsdae_members_count(&is->block, island),
                               .row_count = nsdae_members_count(&is->row, island),
                               .block = is->block.of + is->block.first[island],
                               .row = is->row.of + is->row.first[island]};
  int status = nsdae_sparse_kkt_analyse(k, &part);
  if (status == NSDAE_OK) status = nsdae_sparse_kkt_factor(k, whole->M);
  if (status == NSDAE_E_MASS) return bad_mass(w, whole->system, k->bad_block, k->pivot);
  if (status < 0) return unsolved(w, whole, island, status);
  count_rank(&w->solved, k->rank.count, k->rank.kept, k->rank.left);
  return k->rank.count < part.row_count && !w->least_norm
             ? bad_rank(w, whole, island, k->rank.count, k->rank.dependent)
             : NSDAE_OK;
}

static int fits_constraints(const nsdae_island_equations *whole, int island)
{
  return !has_contacts(whole, island);
}

static int solve_constraints(nsdae_worker *w, const nsdae_island_equations *whole, int island)
{
  int status = factor_sparse(w, whole, island);
  if (status < 0) return status;
  status = nsdae_sparse_kkt_solve(&w->sparse, whole->r, whole->v, whole->lambda);
  if (status < 0) return unsolved(w, whole, island, status);
  const nsdae_blocks *blocks = &whole->system->blocks;
  const nsdae_members *members = &whole->islands->block;
  for (int i = members->first[island]; i < members->first[island + 1]; i++) {
    int b = members->of[i], at = blocks->first[b];
    memcpy(whole->size + at, whole->v + at, (size_t)nsdae_blocks_size(blocks, b) * sizeof(double));
  }
  return NSDAE_OK;
}

/* What stopped the problem: a mass, where one is not positive definite. */
static int cause_of(nsdae_worker *w, const nsdae_island_equations *whole, int island, int status)
{
  const nsdae_members *members = &whole->islands->block;
  nsdae_block_factor factor = {.L = w->L};
  for (int i = members->first[island]; i < members->first[island + 1]; i++) {
    int b = members->of[i];
    int pivot = nsdae_blocks_factor(&whole->system->blocks, b, whole->M, &factor);
    if (pivot) return bad_mass(w, whole->system, b, pivot);
  }
  return status;
}

static int fits_cones(const nsdae_island_equations *whole, int island)
{
  (void)whole, (void)island;
  return 1;
}

static int solve_cones(nsdae_worker *w, const nsdae_island_equations *whole, int island)
{
  nsdae_solved *s = &w->solved;
  nsdae_cone_work work = {.solver = w->solver, .L = w->L, .tol = w->tol, .error = &w->error};
  int rows = nsdae_members_count(&whole->islands->row, island);
  int status = rows > 0 ? factor_sparse(w, whole, island) : NSDAE_OK;
  if (status < 0) return status;
  status = nsdae_cone_island_solve(island == whole->kept_island ? whole->kept : &w->cones, whole,
                                   island, &work);
  if (status < 0) status = cause_of(w, whole, island, status);
  s->lcps++;
  s->pivots += work.info.sweeps + work.info.iterations;
  nsdae_natural_residual_add(&s->residual, &work.residual);
  s->noise = fmax(s->noise, 1e2 * fmax(work.info.residual, w->tol));
  return status;
}

/* ---- the table */

typedef struct island_solver {
  int pass;
  int (*fits)(const nsdae_island_equations *whole, int island);
  int (*solve)(nsdae_worker *worker, const nsdae_island_equations *whole, int island);
} island_solver;

static const island_solver solvers[] = {{0, fits_one_contact, solve_one_contact},
                                        {0, nsdae_dense_island_fits, solve_dense},
                                        {0, fits_constraints, solve_constraints},
                                        {0, fits_active_set, solve_active_set},
                                        {1, fits_cones, solve_cones}};

int nsdae_worker_solve(nsdae_worker *w, const nsdae_island_equations *whole, int island, int pass)
{
  int status = NSDAE_NEXT, contacts = nsdae_members_count(&whole->islands->contact, island);
  if (contacts > w->solved.contacts) w->solved.contacts = contacts;
  for (size_t i = 0; status == NSDAE_NEXT && i < sizeof solvers / sizeof *solvers; i++)
    if (solvers[i].pass == pass && solvers[i].fits(whole, island))
      status = solvers[i].solve(w, whole, island);
  return status;
}
