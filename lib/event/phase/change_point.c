#include "change_point.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "vector.h"

/* The width in rtol^(1/3). A drift of rtol turns v by rtol / width^2 before the rows are left out,
 * which is projected: of 60 linkages of tests/system/change_points.c at 1e-8 the energy of one is
 * off by 1e-3 with 1, and by 1e-7 with 10. Its bounds, of rounding and a small angle. */
static const double WIDTH = 10, LEAST_WIDTH = 1e-3, MOST_WIDTH = 0.05;

/* Of the width, if the motion turns by more within it: 2 eps / width^3 is less than 1e-2 yet. */
static const double NARROWEST = 0.02;

/* Of rtol^(1/2), as energy is of second order: how far u' may be off. */
static const double TURNS = 0.1;

/* Of the tolerance of positions: as far as a drift may be before it is projected. */
static const double DRIFT = 10;

/* Of the sine here: beyond a change point it rises again, by as much as it fell; not so where rows
 * become redundant and stay so, as of a drive that fades out: (1 - t)^n has 3^-n of it there. */
static const double RISEN = 0.5;

/* Rounds of Newton's method: the prediction is off by the square of the width. */
enum { ROUNDS = 3 };

/* Times to measure how fast a sine falls, each a quarter of the one before. */
enum { SHORTER = 6 };

void nsdae_event_crossing_layout(nsdae_event_crossing *c, const nsdae_event_setting *s,
                                 nsdae_arena *arena)
{
  const nsdae_dims *d = &s->system->dims;
  int most = nsdae_crossing_most(d->m);
  c->basis = NSDAE_ARENA_DOUBLES(arena, d->m > 0 ? nsdae_kkt_basis_size(s->kkt) : 0);
  nsdae_terms_layout_rows(&c->rows, &s->system->blocks, most, d->nv, 1, arena);
  nsdae_arena_doubles(arena, most, (double **[]){&c->start, &c->slope, NULL});
  nsdae_arena_doubles(arena, d->nv, (double **[]){&c->room.x, &c->a, &c->a_ahead, NULL});
  c->room.l = NSDAE_ARENA_DOUBLES(arena, d->m);
  c->room.q = NSDAE_ARENA_DOUBLES(arena, d->nq > d->nv ? d->nq : d->nv);
  c->room.ahead = NSDAE_ARENA_DOUBLES(arena, s->at.n + d->nq); /* and a stage */
}

void nsdae_event_crossing_prepare(nsdae_event_crossing *c, double rtol)
{
  c->tau = c->width = fmin(fmax(WIDTH * cbrt(rtol), LEAST_WIDTH), MOST_WIDTH);
}

/* Factors the constraints at the point in work, which has the terms: no more than that rank, as a
 * drift turns redundant rows out of the others. */
static int factor_rank(nsdae_event_setting *s, int rank)
{
  s->kkt->spare = s->kkt->m - rank;
  int status = nsdae_terms_factor(s->here, s->here->M, s->kkt, 1);
  s->kkt->spare = 0;
  return status;
}

/* Of the rows that were factored. */
static double sine_of(const nsdae_event_setting *s, int rank)
{
  return s->kkt->rank < rank ? s->kkt->left : s->kkt->kept;
}

int nsdae_event_sine(nsdae_event_setting *s, int rank, double *sine)
{
  int status = nsdae_terms_need(s->here, NSDAE_TERM_MASS | NSDAE_TERM_JACOBIAN);
  if (status == NSDAE_OK) status = factor_rank(s, rank);
  if (status < 0) return status;
  *sine = sine_of(s, rank);
  return NSDAE_OK;
}

/* The independent rows at the point in work, without those of small sines. */
static int factor_reduced(nsdae_event_crossing *c, nsdae_event_setting *s)
{
  double tol = s->kkt->rank_tol;
  s->kkt->rank_tol = NSDAE_CROSSING_NEAR * c->width;
  int status = nsdae_terms_factor(s->here, s->here->M, s->kkt, 1);
  s->kkt->rank_tol = tol;
  if (s->kkt->is_sparse) s->kkt->sparse.rank.chosen = 1; /* rows that are left out do not hold */
  return status;
}

/* x := the part of M^-1 J_i^T that the rows in force and the directions so far leave open; returns
 * its share of |M^-1 J_i^T|_M. */
static double open_part(nsdae_event_crossing *c, const nsdae_event_setting *s, int i)
{
  const nsdae_blocks *b = &s->system->blocks;
  const nsdae_terms *T = s->here;
  int n = T->system->dims.nv, m = T->system->dims.m;
  memset(c->room.x, 0, (size_t)n * sizeof *c->room.x);
  nsdae_rows_add(b, &T->by.jacobian, i, 1, c->room.x);
  nsdae_kkt_solve_mass(s->kkt, c->room.x);
  double all = sqrt(nsdae_blocks_square(b, T->M, c->room.x));
  memset(c->room.x, 0, (size_t)n * sizeof *c->room.x);
  memset(c->room.l, 0, (size_t)m * sizeof *c->room.l);
  nsdae_rows_add(b, &T->by.jacobian, i, 1, c->room.x);
  if (!(all > 0) || nsdae_kkt_solve(s->kkt, 1, c->room.x, n, c->room.l, m) < 0) return 0;
  for (int j = 0; j < c->count; j++) { /* less x^T M u_j, u_j = M^-1 row_j */
    double *u = c->room.q;
    memset(u, 0, (size_t)n * sizeof *u);
    nsdae_rows_add(b, &c->rows, j, 1, u);
    nsdae_kkt_solve_mass(s->kkt, u);
    nsdae_add(n, -nsdae_rows_dot(b, &c->rows, j, c->room.x), u, c->room.x);
  }
  return sqrt(nsdae_blocks_square(b, T->M, c->room.x)) / all;
}

/* Row j of the directions: (M x)^T / |x|_M. */
static void add_direction(nsdae_event_crossing *c, const nsdae_event_setting *s)
{
  const nsdae_blocks *b = &s->system->blocks;
  const nsdae_terms *T = s->here;
  int n = T->system->dims.nv, j = c->count++;
  double *row = c->rows.value + (size_t)j * (size_t)n,
         size = sqrt(nsdae_blocks_square(b, T->M, c->room.x));
  memset(row, 0, (size_t)n * sizeof *row);
  nsdae_blocks_add_product(b, T->M, c->room.x, row);
  for (int i = 0; i < n; i++) row[i] /= size;
  c->rows.first[0] = 0;
  c->rows.first[j + 1] = (j + 1) * b->count;
  for (int k = 0; k < b->count; k++) {
    c->rows.block[j * b->count + k] = k;
    c->rows.at[j * b->count + k] = (size_t)j * (size_t)n + (size_t)b->first[k];
  }
  c->start[j] = nsdae_rows_dot(b, &c->rows, j, c->a);
  c->slope[j] = (nsdae_rows_dot(b, &c->rows, j, c->a_ahead) - c->start[j]) / c->span;
}

/* The directions of the rows that are left out at the point in work; whether all are found. */
static int find_directions(nsdae_event_crossing *c, const nsdae_event_setting *s, int count)
{
  for (c->count = 0; c->count < count;) {
    double most = 0;
    int best = -1;
    for (int i = 0; i < s->system->dims.m; i++) {
      double part = open_part(c, s, i);
      if (part > most) most = part, best = i;
    }
    if (best < 0 || !(open_part(c, s, best) > 1e3 * DBL_EPSILON)) return 0;
    add_direction(c, s);
  }
  return 1;
}

/* q and v h ahead of the state `from`, to `ahead` and the point in work: by the classical
 * Runge-Kutta method for q' = H(q) v, with v' on the straight line from a to a_ahead. */
static int move_ahead(nsdae_event_crossing *c, nsdae_event_setting *s, double t, const double *from,
                      double h)
{
  const double at[] = {0, 0.5, 0.5, 1}, weight[] = {1, 2, 2, 1};
  nsdae_terms *T = s->here;
  int nq = T->system->dims.nq, n = T->system->dims.nv;
  double *sum = c->room.ahead, *v = c->room.x;
  nsdae_event_move(s, t, from);
  memcpy(sum, from, (size_t)nq * sizeof *sum);
  for (int k = 0; k < 4; k++) {
    double x = at[k];
    for (int i = 0; i < n; i++)
      v[i] = from[nq + i] + h * x * (c->a[i] + x / 2 * (c->a_ahead[i] - c->a[i]));
    int status = nsdae_kinematics_at(T, v, c->room.q);
    if (status < 0) return status;
    nsdae_add(nq, h * weight[k] / 6, c->room.q, sum);
    if (k == 3) break;
    nsdae_move(nq, from, h * at[k + 1], c->room.q, sum + nq);
    nsdae_terms_at(T, t, sum + nq, from + nq);
  }
  memcpy(sum + nq, v, (size_t)n * sizeof *v);
  nsdae_event_move(s, t + h, sum);
  return NSDAE_OK;
}

/* x := the least velocity with Phi_q x = -missing, from l = -missing, of the rows that were
 * factored. */
static int solve_rows(nsdae_event_crossing *c, nsdae_event_setting *s)
{
  const nsdae_dims *d = &s->system->dims;
  memset(c->room.x, 0, (size_t)d->nv * sizeof *c->room.x);
  return nsdae_kkt_solve(s->kkt, 1, c->room.x, d->nv, c->room.l, d->m);
}

/* A round of Newton's method on the constraints for q of `ahead`, by all rows or without those of
 * small sines. */
static int correct(nsdae_event_crossing *c, nsdae_event_setting *s, int all)
{
  nsdae_terms *T = s->here;
  int m = T->system->dims.m, nq = T->system->dims.nq;
  int status = nsdae_terms_need(T, NSDAE_TERM_MASS | NSDAE_TERM_PHI | NSDAE_TERM_JACOBIAN);
  if (status == NSDAE_OK) status = all ? factor_rank(s, c->rank) : factor_reduced(c, s);
  for (int i = 0; i < m; i++) c->room.l[i] = -T->constraint.phi[i];
  if (status == NSDAE_OK) status = solve_rows(c, s);
  if (status == NSDAE_OK) status = nsdae_kinematics_at(T, c->room.x, c->room.q);
  if (status < 0) return status;
  nsdae_add(nq, 1, c->room.q, c->room.ahead);
  nsdae_event_move(s, T->t, c->room.ahead);
  return nsdae_terms_need(T, NSDAE_TERM_PHI);
}

/* `ahead` to the constraints. 1 if those of small sines hold once the others do and are independent
 * again, else 0. */
static int meet_constraints(nsdae_event_crossing *c, nsdae_event_setting *s, double tol)
{
  nsdae_terms *T = s->here;
  int m = T->system->dims.m, nq = T->system->dims.nq, status = NSDAE_OK;
  for (int i = 0; i < ROUNDS && status == NSDAE_OK; i++) status = correct(c, s, 0);
  if (status < 0 || nsdae_largest(m, T->constraint.phi) > tol) return status < 0 ? status : 0;
  for (int i = 0; i < ROUNDS && status == NSDAE_OK; i++) status = correct(c, s, 1);
  if (status == NSDAE_OK)
    status = nsdae_terms_need(T, NSDAE_TERM_MASS | NSDAE_TERM_JACOBIAN | NSDAE_TERM_PHI_T);
  if (status == NSDAE_OK) status = factor_rank(s, c->rank);
  for (int i = 0; i < m; i++) c->room.l[i] = -nsdae_terms_constraint_rate(T, i, T->v);
  if (status == NSDAE_OK) status = solve_rows(c, s);
  if (status < 0) return status;
  nsdae_add(T->system->dims.nv, 1, c->room.x, c->room.ahead + nq);
  return sine_of(s, c->rank) > RISEN * c->width;
}

/* The time in which the motion from y crosses the change point, by how fast the smallest sine
 * falls. 1, 0 if it does not fall, or a status. */
static int find_span(nsdae_event_crossing *c, nsdae_event_setting *s, double t, const double *y)
{
  double here = 0, there = 0;
  int status = nsdae_event_sine(s, c->rank, &here);
  c->width = fmin(c->tau, here);
  if (status < 0 || !(here < NSDAE_CROSSING_NEAR * c->tau) || !(here > 0)) return status;
  /* at first in a time in which nothing turns by more than a part of the sine */
  double speed = nsdae_largest(s->system->dims.nv, s->here->v), h = here / (8 * speed);
  if (!(speed > 0)) return 0;
  for (int i = 0; i < SHORTER && !(there > here / 2 && there < here); i++, h /= 4) {
    status = move_ahead(c, s, t, y, h);
    if (status == NSDAE_OK) status = nsdae_event_sine(s, c->rank, &there);
    if (status < 0) return status;
  }
  h *= 4;
  c->width = here;
  c->begin = t;
  c->span = 2 * here * h / (here - there);
  return there < here;
}

int nsdae_event_foresee(nsdae_event_crossing *c, nsdae_event_setting *s, double t, const double *y,
                        int again)
{
  double tol = DRIFT * nsdae_event_position_size(s);
  int crosses = again ? 1 : find_span(c, s, t, y);
  int status = crosses > 0 ? move_ahead(c, s, t, y, c->span) : crosses;
  if (status < 0 || crosses == 0) return status;
  return meet_constraints(c, s, again ? tol : INFINITY);
}

int nsdae_event_is_straight(nsdae_event_crossing *c, const nsdae_event_setting *s, const double *y)
{
  const nsdae_terms *T = s->here;
  for (int i = 0; i < T->system->dims.nv; i++) c->room.x[i] = c->a_ahead[i] - c->a[i];
  double change = nsdae_terms_energy(T, c->room.x), a = nsdae_terms_energy(T, c->a),
         v = nsdae_terms_energy(T, y + T->system->dims.nq);
  /* the remainder of a linear interpolation, |a''| span^2 / 12 in the mean, with a'' span^2 about
   * change^2 / a */
  return c->span / 12 * change <= TURNS * sqrt(s->options->rtol) * sqrt(a * v);
}

void nsdae_event_narrow(nsdae_event_crossing *c)
{
  if (c->width / 2 > NARROWEST * c->tau) c->width /= 2;
}

void nsdae_event_widen(nsdae_event_crossing *c)
{
  c->width = fmin(c->tau, fmax(c->width, c->least / 2));
}

int nsdae_event_hold(nsdae_event_crossing *c, nsdae_event_setting *s, const double *y)
{
  nsdae_event_move(s, c->begin, y);
  int status = nsdae_terms_need(s->here, NSDAE_TERM_MASS | NSDAE_TERM_JACOBIAN);
  if (status == NSDAE_OK) status = factor_reduced(c, s);
  if (status < 0) return status;
  int count = c->rank - s->kkt->rank;
  c->redundant = s->system->dims.m - s->kkt->rank;
  nsdae_kkt_basis(s->kkt, c->basis);
  if (count < 1 || count > nsdae_crossing_most(s->system->dims.m) || !find_directions(c, s, count))
    c->count = 0;
  return c->count > 0;
}
