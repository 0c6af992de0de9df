#include "scaled_island.h"

#include <math.h>
#include <string.h>

#include "one_contact.h"
#include "vector.h"

/* Whether part e of item i is the island's: not all zeros, or, in the local form, its own. */
static int belongs(const nsdae_fc_scaled *c, int i, int e)
{
  int own = c->local && c->global->view.p->block[e] == i;
  return own || nsdae_fc_touches(c->global, e);
}

/* Entries of y of a block. */
static int block_size(const nsdae_fc_scaled *c, int b)
{
  const nsdae_fc_islands *all = &c->global->islands;
  return c->local ? 3 : c->global->view.p->size[all->listed[all->listed_start[c->label] + b]];
}

/* ---- memory */

void nsdae_fc_layout(void *object, nsdae_arena *arena)
{
  nsdae_fc_scaled *c = object;
  const nsdae_friction_problem *p = c->global->view.p;
  c->local = p->form == NSDAE_FRICTION_LOCAL;
  c->all_listed =
      (double)c->global->view.entries >= (double)c->global->view.items * c->global->view.items;
  /* ---- sizes of the island */
  const nsdae_fc_islands *all = &c->global->islands;
  c->n = all->start[c->label + 1] - all->start[c->label];
  c->blocks = c->local ? c->n : all->listed_start[c->label + 1] - all->listed_start[c->label];
  c->ny = c->parts.entries = 0;
  c->parts.values = 0;
  for (int b = 0; b < c->blocks; b++) c->ny += block_size(c, b);
  for (int k = 0; k < c->n; k++) {
    int i = nsdae_fc_member(c, k);
    for (int e = p->first[i]; e < p->first[i + 1]; e++) {
      if (!belongs(c, i, e)) continue;
      c->parts.entries++;
      c->parts.values += 3 * (size_t)(c->local ? 3 : p->size[p->block[e]]);
    }
  }
  /* ---- arrays */
  nsdae_fc_items *is = &c->items;
  long n = c->n;
  nsdae_arena_ints(arena, n, (int **[]){&is->item, &is->kind, NULL});
  nsdae_arena_doubles(arena, n,
                      (double **[]){&is->mu, &is->size, &is->weight, &is->rho, &is->factor, NULL});
  nsdae_arena_doubles(arena, 3 * n, (double **[]){&is->q, &is->C, &c->r, &c->u, NULL});
  nsdae_arena_doubles(arena, 9 * n, (double **[]){&is->D, &is->S, NULL});
  is->turn = NSDAE_ARENA_DOUBLES(arena, 2 * n);
  c->parts.first = NSDAE_ARENA_INTS(arena, n + 1L);
  c->parts.block = NSDAE_ARENA_INTS(arena, c->parts.entries);
  c->parts.at = nsdae_arena_take(arena, c->parts.entries + 1L, sizeof(size_t));
  c->parts.J = NSDAE_ARENA_DOUBLES(arena, c->parts.values);
  c->parts.size = NSDAE_ARENA_INTS(arena, c->blocks);
  c->parts.offset = NSDAE_ARENA_INTS(arena, c->blocks + 1L);
  c->low = NSDAE_ARENA_DOUBLES(arena, c->ny);
  c->y = c->local ? c->r : NSDAE_ARENA_DOUBLES(arena, c->ny);
}

/* ---- scaling */

double nsdae_fc_power_of_two(double x)
{
  if (!(x > 0)) return 1;
  int exponent;
  double part = frexp(x, &exponent); /* in [1/2, 1) */
  return ldexp(1, part * part < 0.5 ? exponent - 1 : exponent);
}

/* e of item number k of the whole */
static double size_of(const nsdae_fc_scaled *c, int i)
{
  return nsdae_fc_power_of_two(sqrt(c->global->d[i] / c->largest));
}

/* Item number k of the island is item i of the whole; s: unit of velocities, a power of two. */
static void fill_item(nsdae_fc_scaled *c, int k, int i, double s)
{
  const nsdae_fc_global *w = c->global;
  const nsdae_friction_problem *p = w->view.p;
  int rows = nsdae_fc_rows(p, i), row = w->view.row[i];
  double size = size_of(c, i);
  c->items.item[k] = i;
  c->items.size[k] = size;
  c->items.mu[k] = i < p->contacts && rows > 1 ? p->mu[i] : 0;
  c->items.kind[k] = i >= p->contacts     ? NSDAE_FC_BILATERAL
                     : c->items.mu[k] > 0 ? NSDAE_FC_CONE
                                          : NSDAE_FC_NORMAL;
  c->items.rho[k] = w->d[i] / c->largest / size / size;
  c->items.weight[k] = size * (s / w->scale);
  c->items.factor[k] = s / size / c->largest;
  for (int j = 0; j < 3; j++) {
    int has = j < rows;
    c->items.C[3 * k + j] =
        has && p->compliance ? p->compliance[row + j] / c->largest / size / size : 0;
  }
}

/* The parts of each item, one behind another; parts of zeros are left out. J' = J / (e sqrt(D)) of
 * part e of the whole; local: W' = W / (e_i e_j D). */
static void fill_parts(nsdae_fc_scaled *c)
{
  const nsdae_fc_global *w = c->global;
  const nsdae_friction_problem *p = w->view.p;
  int f = 0;
  c->parts.offset[0] = 0;
  c->parts.bodies = !c->local;
  for (int b = 0; b < c->blocks; b++) {
    c->parts.size[b] = block_size(c, b);
    c->parts.bodies &= c->parts.size[b] == 6;
    c->parts.offset[b + 1] = c->parts.offset[b] + c->parts.size[b];
  }
  c->parts.at[0] = 0;
  c->parts.first[0] = 0;
  for (int k = 0; k < c->n; k++) {
    int i = c->items.item[k], rows = nsdae_fc_rows(p, i);
    for (int e = p->first[i]; e < p->first[i + 1]; e++) {
      int of = p->block[e], b = w->islands.number[of];
      if (!belongs(c, i, e)) continue;
      int n = c->parts.size[b], have = c->local ? nsdae_fc_rows(p, of) : n;
      const double *from = (c->local ? p->value : w->J) + w->view.at[e];
      double scale = 1 / c->items.size[k], *J = c->parts.J + c->parts.at[f];
      scale /= c->local ? size_of(c, of) * c->largest : sqrt(c->largest);
      if (rows < 3 || have < n) memset(J, 0, 3 * (size_t)n * sizeof *J);
      for (int j = 0; j < rows; j++)
        for (int l = 0; l < have; l++) J[j * n + l] = scale * from[j * have + l];
      c->parts.block[f] = b;
      c->parts.at[f + 1] = c->parts.at[f] + 3 * (size_t)n;
      f++;
    }
    c->parts.first[k + 1] = f;
  }
}

/* Its diagonal blocks, and r from that of the whole. */
typedef struct filling {
  nsdae_fc_scaled *fc;
  const double *r;
} filling;

static void fill_blocks(void *object, int from, int to)
{
  const filling *f = object;
  const nsdae_fc_scaled *c = f->fc;
  const nsdae_fc_global *w = c->global;
  for (int k = from; k < to; k++) {
    int rows = nsdae_fc_rows(w->view.p, c->items.item[k]), row = w->view.row[c->items.item[k]];
    double *D = c->items.D + 9 * (size_t)k, *S = c->items.S + 9 * (size_t)k;
    /* The diagonal block: C + J^T J, or (local form) the symmetric part of W_kk. */
    memset(D, 0, 9 * sizeof *D);
    for (int j = 0; j < 3; j++) D[4 * j] = c->items.C[3 * k + j];
    for (int e = c->parts.first[k]; e < c->parts.first[k + 1]; e++) {
      const double *J = nsdae_fc_part(c, e);
      int n = c->parts.size[c->parts.block[e]];
      for (int j = 0; j < 3; j++)
        for (int l = 0; l <= j; l++)
          if (!c->local)
            D[3 * j + l] += nsdae_dot(n, J + j * n, J + l * n);
          else if (c->parts.block[e] == k)
            D[3 * j + l] += (J[3 * j + l] + J[3 * l + j]) / 2;
    }
    D[1] = D[3], D[2] = D[6], D[5] = D[7];
    nsdae_fc_invert(D, S);
    memcpy(S + 6, D, 3 * sizeof *S);
    nsdae_fc_turn_matrix(D, c->items.turn + 2 * k);
    for (int j = 0; j < 3; j++) D[4 * j] += NSDAE_FC_PROXIMAL;
    for (int j = 0; j < 3; j++) {
      double own = j < rows ? f->r[row + j] / c->items.factor[k] : 0;
      c->r[3 * k + j] = isfinite(own) ? own : 0;
    }
  }
}

void nsdae_fc_fill(nsdae_fc_scaled *c, const double *r)
{
  const nsdae_fc_global *w = c->global;
  c->largest = nsdae_fc_power_of_two(sqrt(w->most_d));
  c->largest *= c->largest;
  const double s = nsdae_fc_power_of_two(w->scale);
  for (int k = 0; k < c->n; k++) fill_item(c, k, nsdae_fc_member(c, k), s);
  nsdae_fc_gather(c, w->q, c->items.q);
  fill_parts(c);
  nsdae_thread_pool_for(w->pool, c->n, NSDAE_FC_GRAIN, fill_blocks, &(filling){c, r});
}

/* ---- impulses */

void nsdae_fc_scatter(const nsdae_fc_scaled *c, const double *from, double *r)
{
  const nsdae_fc_global *w = c->global;
  for (int k = 0; k < c->n; k++)
    for (int j = 0; j < nsdae_fc_rows(w->view.p, c->items.item[k]); j++)
      r[w->view.row[c->items.item[k]] + j] = c->items.factor[k] * from[3 * k + j];
}

void nsdae_fc_gather(const nsdae_fc_scaled *c, const double *u, double *to)
{
  const nsdae_fc_global *w = c->global;
  const double s = nsdae_fc_power_of_two(w->scale);
  for (int k = 0; k < c->n; k++) {
    int i = c->items.item[k], rows = nsdae_fc_rows(w->view.p, i);
    for (int j = 0; j < 3; j++)
      to[3 * k + j] = j < rows ? u[w->view.row[i] + j] / s / c->items.size[k] : 0;
  }
}

/* y = J r */
NSDAE_INLINED void sum_parts(const nsdae_fc_scaled *c, const double *r, double *y)
{
  memset(y, 0, (size_t)c->ny * sizeof *y);
  memset(c->low, 0, (size_t)c->ny * sizeof *y);
  for (int k = 0; k < c->n; k++)
    for (int e = c->parts.first[k]; e < c->parts.first[k + 1]; e++) {
      int at = c->parts.offset[c->parts.block[e]];
      nsdae_dd_add_product(c->parts.size[c->parts.block[e]], 3, nsdae_fc_part(c, e), r + 3 * k,
                           y + at, c->low + at);
    }
  for (int i = 0; i < c->ny; i++) y[i] += c->low[i];
}

NSDAE_DD_DISPATCH(sum_impulses, sum_parts, (const nsdae_fc_scaled *c, const double *r, double *y),
                  (c, r, y))

/* ---- velocities */

/* u = J^T y of item k, and whole: + q + C r; in the local form the sum is that of impulses */
static void relative_velocity(const nsdae_fc_scaled *c, int k, int whole, const double *r,
                              const double *y, double *u)
{
  for (int j = 0; j < 3; j++) {
    double high = whole ? c->items.q[3 * k + j] : 0, low = 0;
    if (whole) nsdae_dd_add(c->items.C[3 * k + j], r[3 * k + j], &high, &low);
    for (int e = c->parts.first[k]; e < c->parts.first[k + 1]; e++) {
      int n = c->parts.size[c->parts.block[e]];
      const double *J = nsdae_fc_part(c, e) + j * n, *part = y + c->parts.offset[c->parts.block[e]];
      if (!c->local)
        high += nsdae_dot(n, J, part);
      else
        for (int l = 0; l < n; l++) nsdae_dd_add(J[l], part[l], &high, &low);
    }
    u[3 * k + j] = high + low;
  }
}

/* A point r, y and its velocities. */
typedef struct point {
  const nsdae_fc_scaled *fc;
  const double *r, *y;
  double *u;
} point;

static void whole_velocities(void *object, int from, int to)
{
  const point *p = object;
  for (int k = from; k < to; k++) relative_velocity(p->fc, k, 1, p->r, p->y, p->u);
}

void nsdae_fc_velocities(const nsdae_fc_scaled *c, const double *r, double *y, double *u)
{
  if (!c->local) sum_impulses(c, r, y);
  point at = {c, r, c->local ? r : y, u};
  nsdae_thread_pool_for(c->global->pool, c->n, NSDAE_FC_GRAIN, whole_velocities, &at);
}

void nsdae_fc_response(const nsdae_fc_scaled *c, const double *dr, double *dy, double *du)
{
  if (!c->local) sum_impulses(c, dr, dy);
  for (int k = 0; k < c->n; k++) relative_velocity(c, k, 0, dr, c->local ? dr : dy, du);
}

void nsdae_fc_impulse(const nsdae_fc_scaled *c, int k, const double *r, double x[3], double low[3])
{
  for (int j = 0; j < 3; j++) {
    x[j] = c->base.high[3 * k + j];
    low[j] = c->base.low[3 * k + j];
    nsdae_dd_add(1, r[3 * k + j], x + j, low + j);
  }
}

/* ---- residual */

/* With a base r is a double-double: K is a cone, and so u is scaled in its place. */
double nsdae_fc_item_residual(const nsdae_fc_scaled *c, int k, const double *r, const double *u)
{
  const int based = c->base.high != NULL;
  double x[3], low[3], y[3], rho = c->items.rho[k], by = based ? rho : 1;
  if (based) nsdae_fc_impulse(c, k, r, x, low);
  for (int j = 0; j < 3; j++) {
    if (!based) x[j] = rho * r[3 * k + j];
    y[j] = u[j] / by;
  }
  return c->items.weight[k] *
         (by * nsdae_fc_natural(c->items.kind[k], c->items.mu[k], x, based ? low : NULL, y));
}

typedef struct residual_of {
  const nsdae_fc_scaled *fc;
  const double *r, *u;
} residual_of;

static double largest_residual(void *object, int from, int to)
{
  const residual_of *p = object;
  double most = 0;
  for (int k = from; k < to && most == most; k++) {
    double one = nsdae_fc_item_residual(p->fc, k, p->r, p->u + 3 * k);
    if (!(one <= most)) most = one;
  }
  return most;
}

double nsdae_fc_residual(const nsdae_fc_scaled *c, const double *r, const double *u)
{
  residual_of at = {c, r, u};
  return nsdae_thread_pool_most(c->global->pool, c->n, NSDAE_FC_GRAIN, largest_residual, &at);
}
