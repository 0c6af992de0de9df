#include "newton_kkt.h"

#include <math.h>
#include <string.h>

#include "errors.h"
#include "vector.h"

/* Relative error of a linear solution that Newton's iteration corrects as well: far below the share
 * of a third of rtol that it stops at, for rtol of 1e-9 and more. */
static const double ENOUGH = 1e-10;

void nsdae_newton_kkt_layout(nsdae_newton_kkt *b, const nsdae_system *system, int most,
                             double rank_tol, nsdae_arena *arena)
{
  b->matrix.system = system;
  b->kkt.n = system->dims.nv;
  b->kkt.m = system->dims.m;
  b->kkt.blocks = &system->blocks;
  b->kkt.rank_tol = rank_tol;
  b->kkt.sparse.enough = ENOUGH;
  b->border.kkt = &b->kkt;
  nsdae_newton_matrix_layout(&b->matrix, arena);
  nsdae_kkt_layout(&b->kkt, arena);
  nsdae_border_layout(&b->border, system, most, arena);
  b->border.coupling = &b->matrix.coupling;
}

int nsdae_newton_kkt_make(nsdae_newton_kkt *b)
{
  b->started = 0;
  return nsdae_newton_matrix_make(&b->matrix);
}

void nsdae_newton_kkt_release(nsdae_newton_kkt *b)
{
  nsdae_block_pairs_release(&b->matrix.pairs);
  nsdae_kkt_release(&b->kkt);
}

int nsdae_newton_kkt_start(nsdae_newton_kkt *b, nsdae_terms *T)
{
  nsdae_newton_matrix *N = &b->matrix;
  if (b->started || T->system->blocks.count == 1) return NSDAE_OK;
  int status = nsdae_newton_matrix_start(N, T);
  if (status == NSDAE_OK) status = nsdae_terms_need(T, NSDAE_TERM_MASS | NSDAE_TERM_JACOBIAN);
  if (status < 0) return status;
  memset(N->pairs.value, 0, N->pairs.values * sizeof *N->pairs.value);
  status = nsdae_kkt_factor_coupled(&b->kkt, T->M, &N->coupling, &T->by.jacobian, NULL, b->kkt.m);
  if (status == NSDAE_E_MEMORY) return nsdae_terms_unsolved(T, &b->kkt, status);
  b->started = 1; /* dependent rows do not matter here */
  return NSDAE_OK;
}

int nsdae_newton_kkt_factor(nsdae_newton_kkt *b, nsdae_terms *T, double cj, const double *basis,
                            int rank)
{
  b->border.count = 0;
  int status = nsdae_terms_newton_matrix(T, cj, &b->matrix);
  if (status < 0) return status;
  status = nsdae_kkt_factor_coupled(&b->kkt, b->matrix.A, &b->matrix.coupling, &T->by.jacobian,
                                    basis, rank);
  return status < 0 ? nsdae_terms_unsolved(T, &b->kkt, status) : NSDAE_OK;
}

/* ---- the equations */

int nsdae_newton_kkt_move(nsdae_terms *T, double t, const double *y, const double *ydot, double cj,
                          double *room, double *r)
{
  int nq = T->system->dims.nq;
  nsdae_terms_at(T, t, y, y + nq);
  int status = nsdae_kinematics_at(T, T->v, room);
  for (int i = 0; i < nq; i++) r[i] = ydot[i] - room[i];
  nsdae_move(nq, y, -1 / cj, r, room);
  memcpy(room + nq, y + nq, (size_t)T->system->dims.nv * sizeof *y);
  return status;
}

void nsdae_newton_kkt_residual(const nsdae_terms *T, double alpha, double beta, const double *y,
                               const double *ydot, double *r)
{
  const nsdae_blocks *blocks = &T->system->blocks;
  const nsdae_dims *d = &T->system->dims;
  const double *lambda = y + d->nq + d->nv, *acceleration = ydot + d->nq;
  double *v = r + d->nq, *of = v + d->nv;
  for (int i = 0; i < d->nv; i++) v[i] = -T->F[i];
  nsdae_blocks_add_product(blocks, T->M, acceleration, v);
  for (int i = 0; i < d->m; i++) {
    nsdae_rows_add(blocks, &T->by.jacobian, i, lambda[i], v);
    of[i] = nsdae_terms_rate(T, &T->by.jacobian, T->constraint.omega, i, acceleration) +
            2 * alpha * nsdae_terms_constraint_rate(T, i, T->v) +
            beta * beta * T->constraint.phi[i];
  }
}

int nsdae_newton_kkt_solve(const nsdae_newton_kkt *b, nsdae_terms *T, double cj, double alpha,
                           double beta, const double *r, double *x, double *phi)
{
  const nsdae_dims *d = &T->system->dims;
  double *dv = x + d->nq, *l = dv + d->nv;
  for (int i = 0; i < d->nv; i++) dv[i] = r[d->nq + i] / cj;
  for (int i = 0; i < d->m; i++) l[i] = r[d->nq + d->nv + i] / (cj + 2 * alpha + beta * beta / cj);
  int status = nsdae_border_solve(&b->border, T, dv, l, phi);
  if (status == NSDAE_OK) status = nsdae_kinematics_at(T, dv, x);
  for (int i = 0; i < d->m; i++) l[i] *= cj;
  for (int i = 0; i < d->nq; i++) x[i] = (x[i] + r[i]) / cj;
  return status;
}

/* ---- newton matrix */

void nsdae_newton_matrix_layout(nsdae_newton_matrix *N, nsdae_arena *arena)
{
  const nsdae_system *s = N->system;
  const nsdae_dims *d = &s->dims;
  int dense = s->call.force_damping || s->call.force_stiffness;
  N->A = NSDAE_ARENA_DOUBLES(arena, s->blocks.square[s->blocks.count]);
  N->colour = NSDAE_ARENA_INTS(arena, s->blocks.count);
  N->last = NSDAE_ARENA_INTS(arena, s->blocks.count + 1L);
  nsdae_arena_doubles(arena, d->nq, (double **[]){&N->q, &N->qdot, NULL});
  nsdae_arena_doubles(arena, d->nv, (double **[]){&N->v, &N->unit, &N->F, NULL});
  N->X = NSDAE_ARENA_DOUBLES(arena, dense ? (long)d->nv * d->nv : 0);
}

/* ---- callbacks */

/* A += scale (X + X^T) / 2 with X = D or K of a system without blocks */
static int add_dense(const nsdae_terms *T, nsdae_newton_matrix *N, nsdae_force_damping_fn callback,
                     const char *name, double scale)
{
  int n = T->system->dims.nv;
  memset(N->X, 0, (size_t)n * (size_t)n * sizeof *N->X);
  int code = callback(nsdae_terms_time(T), T->q, T->v, N->X, n, T->system->user);
  int status = nsdae_terms_outcome(T, code, name, N->X, n, n);
  N->list.scale = scale;
  return status < 0 ? status : nsdae_block_add(&N->list, 0, 0, N->X);
}

static int add_listed(const nsdae_terms *T, nsdae_newton_matrix *N, nsdae_force_blocks_fn callback,
                      const char *name, double scale)
{
  nsdae_block_list *list = &N->list;
  list->error = T->error;
  list->callback = name;
  list->scale = scale;
  list->status = NSDAE_OK;
  int code = callback(nsdae_terms_time(T), T->q, T->v, list, T->system->user);
  if (list->status == NSDAE_OK) return nsdae_terms_outcome(T, code, name, NULL, 0, 0);
  if (T->error) T->error->time = nsdae_terms_time(T);
  return list->status;
}

/* d D + k K of the user. */
static int add_given(const nsdae_terms *T, nsdae_newton_matrix *N, double d, double k)
{
  const nsdae_calls *call = &T->system->call;
  int status = NSDAE_OK;
  if (call->force_damping)
    status = add_dense(T, N, call->force_damping, "force_damping", d);
  else if (call->force_damping_blocks)
    status = add_listed(T, N, call->force_damping_blocks, "force_damping_blocks", d);
  if (status < 0) return status;
  if (call->force_stiffness)
    status = add_dense(T, N, call->force_stiffness, "force_stiffness", k);
  else if (call->force_stiffness_blocks)
    status = add_listed(T, N, call->force_stiffness_blocks, "force_stiffness_blocks", k);
  return status;
}

/* ---- differences */

static int any_damping(const nsdae_system *s)
{
  return s->call.force_damping || s->call.force_damping_blocks;
}

static int any_stiffness(const nsdae_system *s)
{
  return s->call.force_stiffness || s->call.force_stiffness_blocks;
}

/* Each block takes the least colour that no block at distance two or less has. */
static void colour_blocks(nsdae_newton_matrix *N)
{
  const nsdae_block_pairs *p = &N->pairs;
  for (int b = 0; b <= p->blocks; b++) N->last[b] = -1;
  for (int b = 0; b < p->blocks; b++) N->colour[b] = p->blocks;
  N->colours = 0;
  for (int b = 0; b < p->blocks; b++) {
    for (int e = p->first[b]; e < p->first[b + 1]; e++) {
      int r = p->neighbour[e];
      N->last[N->colour[r]] = b;
      for (int f = p->first[r]; f < p->first[r + 1]; f++) N->last[N->colour[p->neighbour[f]]] = b;
    }
    int colour = 0;
    while (N->last[colour] == b) colour++;
    N->colour[b] = colour;
    if (colour >= N->colours) N->colours = colour + 1;
  }
}

/* Columns of A take the symmetric part of weight (F - F_displaced): block b's velocity l in the
 * rows of b and of its neighbours. */
static void add_column(nsdae_newton_matrix *N, int b, int l, double weight, const double *F)
{
  const nsdae_blocks *blocks = &N->system->blocks;
  const nsdae_block_pairs *p = &N->pairs;
  int n = nsdae_blocks_size(blocks, b), at = blocks->first[b];
  double *A = N->A + blocks->square[b], half = weight / 2;
  for (int i = 0; i < n; i++) {
    double x = half * (F[at + i] - N->F[at + i]);
    A[i + l * n] += x;
    A[l + i * n] += x;
  }
  for (int e = p->first[b]; e < p->first[b + 1]; e++) {
    int r = p->neighbour[e], m = nsdae_blocks_size(blocks, r);
    double *value = p->value + p->at[p->slot[e]];
    at = blocks->first[r];
    for (int i = 0; i < m; i++)
      value[r > b ? i + l * m : l + i * n] += half * (F[at + i] - N->F[at + i]);
  }
}

/* Velocity l of each block of the colour by step_v, and the coordinates by step_q along its H e. */
static int add_displaced(nsdae_terms *T, nsdae_newton_matrix *N, int colour, int l, double step_v,
                         double step_q, double weight)
{
  const nsdae_system *s = T->system;
  double t = nsdae_terms_time(T);
  for (int i = 0; i < s->dims.nq; i++) N->q[i] = T->q[i] + step_q * N->qdot[i];
  for (int j = 0; j < s->dims.nv; j++) N->v[j] = T->v[j] + step_v * N->unit[j];
  memset(N->F, 0, (size_t)s->dims.nv * sizeof *N->F);
  T->evals->force++;
  int status = nsdae_terms_outcome(T, s->call.force(t, N->q, N->v, N->F, s->user), "force", N->F,
                                   s->dims.nv, 1);
  for (int b = 0; b < s->blocks.count && status == NSDAE_OK; b++)
    if (N->colour[b] == colour && l < nsdae_blocks_size(&s->blocks, b))
      add_column(N, b, l, weight, T->F);
  return status;
}

/* A step along q' for one-sided differences: no coordinate moves by more than
 * 2^-26 sqrt(1 + |q_i|), between sqrt(eps) and what rounding of q_i far from zero asks for. */
static double step_along(int nq, const double *q, const double *qdot)
{
  double fastest = 0, far = 0; /* max q'_i^2 / (1 + |q_i|), max |q_i| of those that move */
  for (int i = 0; i < nq; i++) {
    if (qdot[i] == 0) continue;
    far = nsdae_larger(far, fabs(q[i]));
    fastest = nsdae_larger(fastest, qdot[i] * qdot[i] / (1 + fabs(q[i])));
  }
  return ldexp(0x1p-26, ilogb(1 / sqrt(nsdae_larger(fastest, 1 / (1 + far)))));
}

/* Steps: 2^-26 = sqrt(eps) of the largest velocity, or of 1, because a sum of velocities is known
 * to eps of the largest only; along q see above. If both D and K are missing one displacement (s e,
 * s H e / c_j) has D + K / c_j, unless its step along q is too far from the best one: below 2^-16
 * of it rounding is more than 2^-10 of K, beyond 2^10 truncation is. */
static int add_columns(nsdae_terms *T, nsdae_newton_matrix *N, double cj, int colour, int l)
{
  const nsdae_system *s = T->system;
  int code = nsdae_kinematics(s, nsdae_terms_time(T), T->q, N->unit, N->qdot);
  int status = nsdae_terms_outcome(T, code, "kinematics", N->qdot, s->dims.nq, 1);
  if (status < 0) return status;
  double step_v = ldexp(0x1p-26, ilogb(fmax(1, nsdae_largest(s->dims.nv, T->v))));
  double step_q = step_along(s->dims.nq, T->q, N->qdot);
  double both = step_v / cj, weight = 1 / cj / step_v;
  int damping = !any_damping(s), stiffness = !any_stiffness(s);
  if (damping && stiffness && both >= 0x1p-16 * step_q && both <= 0x1p10 * step_q)
    return add_displaced(T, N, colour, l, step_v, both, weight);
  if (damping) status = add_displaced(T, N, colour, l, step_v, 0, weight);
  if (status < 0 || !stiffness) return status;
  return add_displaced(T, N, colour, l, 0, step_q, 1 / (cj * cj) / step_q);
}

static int add_differences(nsdae_terms *T, nsdae_newton_matrix *N, double cj)
{
  const nsdae_blocks *blocks = &T->system->blocks;
  int status = nsdae_terms_need(T, NSDAE_TERM_FORCE);
  for (int colour = 0; colour < N->colours; colour++)
    for (int l = 0, moved = 1; moved && status == NSDAE_OK; l++) {
      memset(N->unit, 0, (size_t)T->system->dims.nv * sizeof *N->unit);
      moved = 0;
      for (int b = 0; b < blocks->count; b++) {
        if (N->colour[b] != colour || l >= nsdae_blocks_size(blocks, b)) continue;
        N->unit[blocks->first[b] + l] = 1;
        moved = 1;
      }
      if (moved) status = add_columns(T, N, cj, colour, l);
    }
  return status;
}

/* ---- the matrix */

int nsdae_newton_matrix_grow(nsdae_newton_matrix *N)
{
  nsdae_block_pairs *p = &N->pairs;
  int status = nsdae_block_pairs_grow(p, &N->system->blocks);
  if (status < 0) return status;
  N->coupling = (nsdae_coupling){p->count, p->pair, p->value};
  if (!any_damping(N->system) || !any_stiffness(N->system)) colour_blocks(N);
  return NSDAE_OK;
}

/* Blocks of a row of Phi_q are coupled by friction of its joint. A row of more blocks than ROW_MOST
 * is none of a joint. */
static void find_rows(nsdae_newton_matrix *N, const nsdae_rows *rows)
{
  enum { ROW_MOST = 8 };
  for (int i = 0; i < rows->count; i++) {
    const int first = rows->first[i], end = rows->first[i + 1];
    for (int a = first; a < end && end - first <= ROW_MOST; a++)
      for (int b = first; b < a; b++)
        nsdae_block_pairs_find(&N->pairs, rows->block[a], rows->block[b]);
  }
}

int nsdae_newton_matrix_make(nsdae_newton_matrix *N)
{
  int status = nsdae_block_pairs_make(&N->pairs, N->system->blocks.count);
  N->list = (nsdae_block_list){.system = N->system, .diagonal = N->A, .pairs = &N->pairs};
  return status < 0 ? status : nsdae_newton_matrix_grow(N);
}

int nsdae_newton_matrix_start(nsdae_newton_matrix *N, nsdae_terms *T)
{
  nsdae_block_pairs *p = &N->pairs;
  int coupled = N->system->dims.m > 0 && N->system->blocks.count > 1;
  int status = nsdae_newton_matrix_make(N);
  if (status == NSDAE_OK && coupled) status = nsdae_terms_need(T, NSDAE_TERM_JACOBIAN);
  for (int any = 1; any && status == NSDAE_OK;) {
    p->missed = 0;
    if (coupled) find_rows(N, &T->by.jacobian);
    status = add_given(T, N, 1, 1);
    any = p->missed > 0;
    if (any && status == NSDAE_OK) status = nsdae_newton_matrix_grow(N);
  }
  if (status == NSDAE_E_MEMORY) nsdae_error_memory(T->error, "nsdae_newton_matrix");
  return status;
}

int nsdae_terms_newton_matrix(nsdae_terms *T, double cj, nsdae_newton_matrix *N)
{
  nsdae_block_pairs *p = &N->pairs;
  int status = nsdae_terms_need(T, NSDAE_TERM_MASS);
  if (status < 0) return status;
  memcpy(N->A, T->M, T->system->blocks.square[T->system->blocks.count] * sizeof *N->A);
  memset(p->value, 0, p->values * sizeof *p->value);
  p->missed = 0;
  status = add_given(T, N, 1 / cj, 1 / (cj * cj));
  if (status == NSDAE_OK && N->colours > 0) status = add_differences(T, N, cj);
  return status;
}
