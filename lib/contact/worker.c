#include "worker.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "errors.h"
#include "listed.h"

/* ---- certificates */

static void count_rank(nsdae_solved *s, int rank, double kept, double left)
{
  s->rank += rank;
  if (kept < s->kept) s->kept = kept;
  if (left > s->left) s->left = left;
}

static void raise_worst(nsdae_solved *s, const nsdae_island_residual *one)
{
  if (one->tol > 0 &&
      (s->worst.tol == 0 || !(one->left * s->worst.tol <= s->worst.left * one->tol)))
    s->worst = *one;
}

/* Of an island that was solved to tol. */
static void add_residual(nsdae_solved *s, const nsdae_natural_residual *one, double tol)
{
  nsdae_natural_residual_add(&s->residual, one);
  raise_worst(s, &(nsdae_island_residual){one->left, tol});
  s->tol = fmax(s->tol, tol);
  if (one->hidden > tol * one->speed) s->hidden = fmax(s->hidden, one->hidden / one->speed);
}

void nsdae_solved_add(nsdae_solved *sum, const nsdae_solved *one)
{
  nsdae_natural_residual_add(&sum->residual, &one->residual);
  raise_worst(sum, &one->worst);
  sum->tol = fmax(sum->tol, one->tol);
  sum->hidden = fmax(sum->hidden, one->hidden);
  sum->noise = fmax(sum->noise, one->noise);
  sum->pivots += one->pivots;
  sum->lcps += one->lcps;
  count_rank(sum, one->rank, one->kept, one->left);
  if (one->contacts > sum->contacts) sum->contacts = one->contacts;
}

/* pivot of block b, from 1. */
static int bad_mass(nsdae_worker *w, const nsdae_terms *T, int b, int pivot)
{
  const nsdae_blocks *blocks = &T->system->blocks;
  char of[32] = "";
  if (blocks->count > 1) snprintf(of, sizeof of, " of block %d", b);
  return nsdae_terms_bad_mass(T, &w->error, of, pivot, nsdae_blocks_size(blocks, b),
                              blocks->first[b] + pivot - 1);
}

int nsdae_worker_solve_block(nsdae_worker *w, const nsdae_terms *T, const double *M, int b,
                             double *x)
{
  nsdae_block_factor factor = {.L = w->L};
  int pivot = nsdae_blocks_factor(&T->system->blocks, b, M, &factor);
  if (pivot) return bad_mass(w, T, b, pivot);
  nsdae_blocks_solve(&factor, x);
  return NSDAE_OK;
}

/* ---- solvers of an island */

static int has_contacts(const nsdae_island_equations *whole, int island)
{
  return whole->with_contacts && nsdae_members_count(&whole->islands->contact, island) > 0;
}

static int has_joints(const nsdae_island_equations *whole, int island)
{
  return whole->with_contacts && nsdae_members_count(&whole->islands->joint, island) > 0;
}

/* Where a factorisation is not worth keeping. */
static int fits_blocks(const nsdae_island_equations *whole, int island)
{
  const nsdae_contact_islands *is = whole->islands;
  if (whole->with_contacts || nsdae_members_count(&is->row, island) > 0) return 0;
  for (int i = is->block.first[island]; i < is->block.first[island + 1]; i++)
    if (nsdae_blocks_size(&whole->system->blocks, is->block.of[i]) > NSDAE_CONTACT_WIDTH) return 0;
  return 1;
}

int nsdae_worker_solve_free(nsdae_worker *w, const nsdae_island_equations *whole, int b)
{
  const nsdae_blocks *blocks = &whole->system->blocks;
  int at = blocks->first[b];
  size_t bytes = (size_t)nsdae_blocks_size(blocks, b) * sizeof(double);
  memcpy(whole->v + at, whole->r + at, bytes);
  int status = nsdae_worker_solve_block(w, whole->terms, whole->M, b, whole->v + at);
  memcpy(whole->size + at, whole->v + at, bytes);
  return status;
}

static int solve_blocks(nsdae_worker *w, const nsdae_island_equations *whole, int island)
{
  const nsdae_members *block = &whole->islands->block;
  int status = NSDAE_OK;
  for (int i = block->first[island]; i < block->first[island + 1] && status == NSDAE_OK; i++)
    status = nsdae_worker_solve_free(w, whole, block->of[i]);
  return status;
}

/* The next one if more than rounding is left. */
static int solve_one_contact(nsdae_worker *w, const nsdae_island_equations *whole, int island)
{
  nsdae_natural_residual residual;
  if (!nsdae_single_solve(&w->single, whole, island, &residual)) return NSDAE_NEXT;
  w->solved.lcps++;
  w->solved.single = &w->single;
  add_residual(&w->solved, &residual, nsdae_accuracy_tol(&w->accuracy));
  return NSDAE_OK;
}

/* Which part of a system of several blocks is meant. */
static const char *where(const nsdae_island_equations *whole, int island, char text[48])
{
  const nsdae_members *block = &whole->islands->block;
  text[0] = '\0';
  if (whole->islands->blocks > 1)
    snprintf(text, 48, "in the island of block %d: ", block->of[block->first[island]]);
  return text;
}

static int unsolved(nsdae_worker *w, const nsdae_island_equations *whole, int island, int status)
{
  char in[48];
  return nsdae_terms_bad_equations(whole->terms, &w->error, where(whole, island, in),
                                   nsdae_members_count(&whole->islands->row, island), status);
}

static int bad_rank(nsdae_worker *w, const nsdae_island_equations *whole, int island, int rank,
                    int dependent)
{
  char in[48];
  return nsdae_terms_bad_rank(whole->terms, &w->error, where(whole, island, in), rank,
                              nsdae_members_count(&whole->islands->row, island), dependent);
}

/* Pivot of the island's M, from 1, as one of a block. */
static int bad_local_mass(nsdae_worker *w, const nsdae_island_equations *whole, int island,
                          int pivot)
{
  const int *block = whole->islands->block.of + whole->islands->block.first[island];
  for (; pivot > nsdae_blocks_size(&whole->system->blocks, *block); block++)
    pivot -= nsdae_blocks_size(&whole->system->blocks, *block);
  return bad_mass(w, whole->terms, *block, pivot);
}

/* The record of the contact problem, with the island in front of it. */
static int name_island(nsdae_worker *w, const nsdae_island_equations *whole, int island, int status)
{
  const nsdae_contact_islands *is = whole->islands;
  const nsdae_error was = w->error;
  int b = is->block.of[is->block.first[island]], count = nsdae_members_count(&is->contact, island);
  char in[48], first[NSDAE_CALLED_SIZE];
  if (is->blocks == 1) return status;
  if (count == 0)
    nsdae_error_set(&w->error, status, was.where, was.argument, "%s%.200s",
                    where(whole, island, in), was.text);
  else
    nsdae_error_set(&w->error, status, was.where, was.argument,
                    "in the island of block %d (%d contacts, first %s): %.150s", b, count,
                    nsdae_island_called(whole, is->contact.of[is->contact.first[island]], first),
                    was.text);
  return nsdae_error_at(&w->error, status, b, was.time);
}

static int solve_dense(nsdae_worker *w, const nsdae_island_equations *whole, int island)
{
  nsdae_dense_island *l = &w->dense;
  nsdae_solved *s = &w->solved;
  const nsdae_kkt *kkt = &l->kkt;
  nsdae_natural_residual residual = {0};
  int status = nsdae_dense_island_solve(l, whole, island, w->least_norm, &residual);
  if (status == NSDAE_ARRAYS_GROW) w->error.status = status;
  if (status == NSDAE_ARRAYS_GROW) return status;
  count_rank(s, kkt->rank, kkt->kept, kkt->left);
  if (l->solves) {
    s->lcps++;
    s->pivots += l->contacts.lcp.info.pivots;
    s->problem = &l->contacts;
    if (status == NSDAE_OK && l->contacts.lcp.accepted)
      s->noise = fmax(s->noise, 1e2 * l->contacts.lcp.info.residual);
    add_residual(s, &residual, l->contacts.lcp.options.tol);
  }
  if (status == NSDAE_OK) return status;
  if (status == NSDAE_E_MASS) return bad_local_mass(w, whole, island, kkt->pivot);
  if (status == NSDAE_E_RANK)
    return bad_rank(w, whole, island, kkt->rank,
                    whole->islands->row.of[whole->islands->row.first[island] + kkt->dependent]);
  return l->solves ? name_island(w, whole, island, status) : unsolved(w, whole, island, status);
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
  const nsdae_factorisation *f = whole->factorisation;
  int status = nsdae_sparse_kkt_analyse(k, &part);
  k->spare = nsdae_factorisation_spare(f, part.row_count, part.row);
  if (status == NSDAE_OK) status = nsdae_sparse_kkt_factor(k, whole->M);
  if (status == NSDAE_E_MASS) return bad_mass(w, whole->terms, k->bad_block, k->pivot);
  if (status < 0) return unsolved(w, whole, island, status);
  count_rank(&w->solved, k->rank.count, k->rank.kept, k->rank.left);
  for (int i = 0; i < part.row_count && (f->dropped || k->rank.count < part.row_count); i++)
    f->held[part.row[i]] = !nsdae_sparse_kkt_is_dropped(k, i);
  return k->rank.count < part.row_count && !w->least_norm
             ? bad_rank(w, whole, island, k->rank.count, k->rank.dependent)
             : NSDAE_OK;
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
    if (pivot) return bad_mass(w, whole->terms, b, pivot);
  }
  return status;
}

static int solve_cones(nsdae_worker *w, const nsdae_island_equations *whole, int island)
{
  nsdae_solved *s = &w->solved;
  nsdae_cone_work work = {
      .solver = w->solver, .L = w->L, .accuracy = &w->accuracy, .error = &w->error};
  int rows = nsdae_members_count(&whole->islands->row, island);
  int status = rows > 0 ? factor_sparse(w, whole, island) : NSDAE_OK;
  if (status < 0) return status;
  status = nsdae_cone_island_solve(island == whole->kept_island ? whole->kept : &w->cones, whole,
                                   island, &work);
  if (status < 0) status = cause_of(w, whole, island, status);
  s->lcps++;
  s->pivots += work.info.sweeps + work.info.iterations;
  add_residual(s, &work.residual, work.tol);
  s->noise = fmax(s->noise, 1e2 * fmax(work.info.residual, work.tol));
  return status;
}

/* ---- the first that fits */

int nsdae_worker_solve(nsdae_worker *w, const nsdae_island_equations *whole, int island, int pass)
{
  int contacts = nsdae_members_count(&whole->islands->contact, island);
  if (contacts > w->solved.contacts) w->solved.contacts = contacts;
  if (pass == 1) return solve_cones(w, whole, island);
  /* found sooner */
  if (w->all_dense && ((contacts > 1 && whole->with_contacts) || whole->islands->rows > 0))
    return solve_dense(w, whole, island);
  if (fits_blocks(whole, island)) return solve_blocks(w, whole, island);
  if (whole->with_contacts && nsdae_single_fits(whole, island)) {
    int status = solve_one_contact(w, whole, island);
    if (status != NSDAE_NEXT) return status;
  }
  if (nsdae_dense_island_fits(&w->dense, whole, island)) return solve_dense(w, whole, island);
  if (!has_contacts(whole, island) && !has_joints(whole, island))
    return solve_constraints(w, whole, island);
  return NSDAE_NEXT;
}
