#include "change_point.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "vector.h"

/* Bounds of the width: rounding 2 eps / tau^3 of accelerations, and a small angle. */
static const double LEAST_WIDTH = 1e-4, MOST_WIDTH = 0.02;

/* Of the tolerance of positions: as far as a drift may be before it is projected. */
static const double DRIFT = 10;

/* Rounds of Newton's method: the prediction is off by the square of the width. */
enum { ROUNDS = 3 };

void nsdae_event_crossing_layout(nsdae_event_crossing *c, const nsdae_event_setting *s,
                                 nsdae_arena *arena)
{
  const nsdae_dims *d = &s->system->dims;
  c->most = d->m < NSDAE_CROSSING_MOST ? d->m : NSDAE_CROSSING_MOST;
  c->basis = NSDAE_ARENA_DOUBLES(arena, d->m > 0 ? nsdae_kkt_basis_size(s->kkt) : 0);
  nsdae_terms_layout_rows(&c->rows, &s->system->blocks, c->most, d->nv, 1, arena);
  c->rate = NSDAE_ARENA_DOUBLES(arena, c->most);
  nsdae_arena_doubles(arena, d->nv, (double **[]){&c->x, &c->a, NULL});
  c->l = NSDAE_ARENA_DOUBLES(arena, d->m);
  c->q = NSDAE_ARENA_DOUBLES(arena, 2L * d->nq + d->nv);
}

void nsdae_event_crossing_prepare(nsdae_event_crossing *c, double rtol)
{
  c->width = fmin(fmax(cbrt(rtol), LEAST_WIDTH), MOST_WIDTH);
}

int nsdae_event_sine(nsdae_event_setting *s, int rank, double *sine)
{
  int status = nsdae_terms_need(s->here, NSDAE_TERM_MASS | NSDAE_TERM_JACOBIAN);
  if (status == NSDAE_OK) status = nsdae_terms_factor(s->here, s->here->M, s->kkt, 1);
  if (status < 0) return status;
  *sine = s->kkt->rank < rank ? s->kkt->left : s->kkt->kept;
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
  memset(c->x, 0, (size_t)n * sizeof *c->x);
  nsdae_rows_add(b, &T->by.jacobian, i, 1, c->x);
  nsdae_kkt_solve_mass(s->kkt, c->x);
  double all = sqrt(nsdae_blocks_square(b, T->M, c->x));
  memset(c->x, 0, (size_t)n * sizeof *c->x);
  memset(c->l, 0, (size_t)m * sizeof *c->l);
  nsdae_rows_add(b, &T->by.jacobian, i, 1, c->x);
  if (!(all > 0) || nsdae_kkt_solve(s->kkt, 1, c->x, n, c->l, m) < 0) return 0;
  for (int j = 0; j < c->count; j++) { /* less x^T M u_j, u_j = M^-1 row_j */
    double *u = c->q;
    memset(u, 0, (size_t)n * sizeof *u);
    nsdae_rows_add(b, &c->rows, j, 1, u);
    nsdae_kkt_solve_mass(s->kkt, u);
    nsdae_add(n, -nsdae_rows_dot(b, &c->rows, j, c->x), u, c->x);
  }
  return sqrt(nsdae_blocks_square(b, T->M, c->x)) / all;
}

/* Row j of the directions: (M x)^T / |x|_M. */
static void hold(nsdae_event_crossing *c, const nsdae_event_setting *s, const double *a)
{
  const nsdae_blocks *b = &s->system->blocks;
  const nsdae_terms *T = s->here;
  int n = T->system->dims.nv, j = c->count++;
  double *row = c->rows.value + (size_t)j * (size_t)n, size = sqrt(nsdae_blocks_square(b, T->M, c->x));
  memset(row, 0, (size_t)n * sizeof *row);
  nsdae_blocks_add_product(b, T->M, c->x, row);
  for (int i = 0; i < n; i++) row[i] /= size;
  c->rows.first[0] = 0;
  c->rows.first[j + 1] = (j + 1) * b->count;
  for (int k = 0; k < b->count; k++) {
    c->rows.block[j * b->count + k] = k;
    c->rows.at[j * b->count + k] = (size_t)j * (size_t)n + (size_t)b->first[k];
  }
  c->rate[j] = nsdae_rows_dot(b, &c->rows, j, a);
}

/* The directions of the rows that are left out at the point in work; whether all are found. */
static int find_directions(nsdae_event_crossing *c, const nsdae_event_setting *s, int count,
                           const double *a)
{
  for (c->count = 0; c->count < count;) {
    double most = 0;
    int best = -1;
    for (int i = 0; i < s->system->dims.m; i++) {
      double part = open_part(c, s, i);
      if (part > most) most = part, best = i;
    }
    if (best < 0 || !(open_part(c, s, best) > 1e3 * DBL_EPSILON)) return 0;
    hold(c, s, a);
  }
  return 1;
}

/* The point h ahead, by the midpoint rule, to s->here; v is kept. */
static int move_ahead(nsdae_event_crossing *c, nsdae_event_setting *s, const double *from, double h,
                      const double *a)
{
  nsdae_terms *T = s->here;
  int nq = T->system->dims.nq, n = T->system->dims.nv;
  double *rate = c->q, *to = c->q + nq, *v = c->x;
  memcpy(to + nq, from + nq, (size_t)n * sizeof *to);
  double t = T->t;
  nsdae_terms_at(T, t, from, from + nq);
  for (int half = 1; half <= 2; half++) {
    for (int i = 0; i < n; i++) v[i] = from[nq + i] + h * half / 4 * a[i];
    int status = nsdae_kinematics_at(T, v, rate);
    if (status < 0) return status;
    nsdae_move(nq, from, h * half / 2, rate, to);
    nsdae_terms_at(T, t + h * half / 2, to, from + nq);
  }
  return NSDAE_OK;
}

/* Whether the point in work fulfils all constraints, once those in force do. */
static int meets_constraints(nsdae_event_crossing *c, nsdae_event_setting *s, double tol)
{
  nsdae_terms *T = s->here;
  int nq = T->system->dims.nq, n = T->system->dims.nv, m = T->system->dims.m;
  double *to = c->q + nq;
  for (int round = 0; round < ROUNDS; round++) {
    int status = nsdae_terms_need(T, NSDAE_TERM_MASS | NSDAE_TERM_PHI | NSDAE_TERM_JACOBIAN);
    if (status == NSDAE_OK) status = factor_reduced(c, s);
    if (status < 0) return status;
    memset(c->x, 0, (size_t)n * sizeof *c->x);
    for (int i = 0; i < m; i++) c->l[i] = -T->constraint.phi[i];
    status = nsdae_kkt_solve(s->kkt, 1, c->x, n, c->l, m);
    if (status == NSDAE_OK) status = nsdae_kinematics_at(T, c->x, c->q);
    if (status < 0) return status;
    nsdae_add(nq, 1, c->q, to);
    nsdae_terms_at(T, T->t, to, to + nq);
  }
  int status = nsdae_terms_need(T, NSDAE_TERM_PHI);
  return status < 0 ? status : nsdae_largest(m, T->constraint.phi) <= tol;
}

int nsdae_event_cross(nsdae_event_crossing *c, nsdae_event_setting *s, int rank, const double *y,
                      const double *a)
{
  double t = s->here->t, here, there, tol = DRIFT * nsdae_event_position_size(s);
  c->count = 0;
  int status = nsdae_event_sine(s, rank, &here);
  if (status < 0 || !(here < NSDAE_CROSSING_NEAR * c->width) || !(here > 0)) return status;
  /* how fast the sine falls, from the time in which nothing turns by more than the width / 8 */
  double speed = nsdae_largest(s->system->dims.nv, s->here->v), h = c->width / (8 * speed);
  if (!(speed > 0)) return 0;
  status = move_ahead(c, s, y, h, a);
  if (status == NSDAE_OK) status = nsdae_event_sine(s, rank, &there);
  int crosses = status == NSDAE_OK && there < here;
  h = crosses ? 2 * here * h / (here - there) : 0;
  if (crosses) status = move_ahead(c, s, y, h, a);
  if (crosses && status == NSDAE_OK) status = meets_constraints(c, s, tol);
  crosses = crosses && status > 0;
  s->here->t = t;
  nsdae_event_move(s, t, y);
  if (status < 0 || !crosses) return status < 0 ? status : 0;
  status = nsdae_terms_need(s->here, NSDAE_TERM_MASS | NSDAE_TERM_JACOBIAN);
  if (status == NSDAE_OK) status = factor_reduced(c, s);
  if (status < 0) return status;
  int count = rank - s->kkt->rank;
  c->rank = rank;
  c->redundant = s->system->dims.m - s->kkt->rank;
  nsdae_kkt_basis(s->kkt, c->basis);
  if (count < 1 || count > c->most || !find_directions(c, s, count, a)) c->count = 0;
  return c->count > 0;
}
