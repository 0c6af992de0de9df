/* The certificate: the scaled natural residual of every item, with velocities from the data as
 * given. */
#include "global_problem.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "cone.h"
#include "double_double.h"
#include "vector.h"

/* Items and blocks of v; NULL: as they stand. */
typedef struct span {
  int items, blocks;
  const int *item, *block;
} span;

/* The impulses, in one part (low NULL) or two. */
typedef struct impulse {
  const double *r, *low;
} impulse;

static int place(const int *list, int k)
{
  return list ? list[k] : k;
}

/* v = M^-1 (f + H r); parts of zeros may be another island's block, which they leave as it is. */
NSDAE_INLINED void velocity(const nsdae_fc_global *c, span s, impulse x)
{
  const nsdae_friction_problem *p = c->view.p;
  for (int k = 0; k < s.blocks; k++) {
    int b = place(s.block, k), at = c->view.offset[b];
    memcpy(c->v + at, p->f + at, (size_t)p->size[b] * sizeof *c->v);
    memset(c->low + at, 0, (size_t)p->size[b] * sizeof *c->low);
  }
  for (int k = 0; k < s.items; k++) {
    int i = place(s.item, k), rows = nsdae_fc_rows(p, i), row = c->view.row[i];
    for (int e = p->first[i]; e < p->first[i + 1]; e++) {
      int n = p->size[p->block[e]], at = c->view.offset[p->block[e]];
      const double *H = p->value + c->view.at[e];
      nsdae_dd_add_product(n, rows, H, x.r + row, c->v + at, c->low + at);
      if (x.low) nsdae_dd_add_product(n, rows, H, x.low + row, c->v + at, c->low + at);
    }
  }
  for (int k = 0; k < s.blocks; k++) {
    int b = place(s.block, k), at = c->view.offset[b];
    nsdae_add(p->size[b], 1, c->low + at, c->v + at);
    nsdae_fc_divide_by_mass(c, b, c->v + at);
  }
}

/* Rows of item i: of the global form H^T v + w + C r, of the local one W r + q + C r; their sums
 * side by side, as each addition waits for the one before. */
NSDAE_INLINED void item_velocity(const nsdae_fc_global *c, int i, int rows, impulse x, double *u)
{
  const nsdae_friction_problem *p = c->view.p;
  int row = c->view.row[i], global = p->form == NSDAE_FRICTION_GLOBAL;
  double high[3] = {0}, low[3] = {0};
  for (int k = 0; k < rows; k++) high[k] = p->w[row + k];
  for (int k = 0; k < rows && p->compliance; k++) {
    nsdae_dd_add(p->compliance[row + k], x.r[row + k], high + k, low + k);
    if (x.low) low[k] += p->compliance[row + k] * x.low[row + k];
  }
  for (int e = p->first[i]; e < p->first[i + 1]; e++) {
    int b = p->block[e], n = global ? p->size[b] : nsdae_fc_rows(p, b);
    const double *value = p->value + c->view.at[e];
    const double *of = global ? c->v + c->view.offset[b] : x.r + c->view.row[b];
    for (int l = 0; l < n; l++)
      for (int k = 0; k < rows; k++) nsdae_dd_add(value[k * n + l], of[l], high + k, low + k);
    for (int l = 0; l < n && !global && x.low; l++)
      for (int k = 0; k < rows; k++) low[k] += value[k * n + l] * x.low[c->view.row[b] + l];
  }
  for (int k = 0; k < rows; k++) u[row + k] = high[k] + low[k];
}

NSDAE_INLINED void item_velocities(const nsdae_fc_global *c, span s, int from, int to, impulse x,
                                   double *u)
{
  for (int k = from; k < to; k++) {
    int i = place(s.item, k), rows = nsdae_fc_rows(c->view.p, i);
    if (rows == 3)
      item_velocity(c, i, 3, x, u); /* laid out flat */
    else
      item_velocity(c, i, rows, x, u);
  }
}

NSDAE_DD_DISPATCH(body_velocities, velocity, (const nsdae_fc_global *c, span s, impulse x),
                  (c, s, x))
NSDAE_DD_DISPATCH(relative_velocities, item_velocities,
                  (const nsdae_fc_global *c, span s, int from, int to, impulse x, double *u),
                  (c, s, from, to, x, u))

/* A point, and its velocities. */
typedef struct evaluation {
  const nsdae_fc_global *global;
  span of;
  impulse x;
  double *u;
} evaluation;

static void evaluate_items(void *object, int from, int to)
{
  const evaluation *v = object;
  relative_velocities(v->global, v->of, from, to, v->x, v->u);
}

static void evaluate(evaluation *v)
{
  const nsdae_fc_global *c = v->global;
  if (c->view.p->form == NSDAE_FRICTION_GLOBAL) body_velocities(c, v->of, v->x);
  nsdae_thread_pool_for(c->pool, v->of.items, NSDAE_FC_GRAIN, evaluate_items, v);
}

/* ---- velocities */

void nsdae_fc_island_velocities(const nsdae_fc_global *c, int island, const double *r,
                                const double *low, double *u)
{
  int from = c->islands.start[island], first = c->islands.listed_start[island];
  const span one = {.items = c->islands.start[island + 1] - from,
                    .item = c->islands.member + from,
                    .blocks = c->islands.listed_start[island + 1] - first,
                    .block = c->islands.listed + first};
  evaluate(&(evaluation){c, one, {r, low}, u});
}

/* ---- residual */

/* That of one item; frictionless ones have a residual of their one row. K is a cone: the map of
 * (r d / s, u / s) is a times that of (r d / (s a), u / (s a)), and with a = d / s over the power
 * of two next to it r is not rounded. Of r + low the first part is made the larger one. */
static double item_residual(const nsdae_fc_global *c, int i, impulse of, const double *u)
{
  int rows = nsdae_fc_rows(c->view.p, i), row = c->view.row[i], kind = NSDAE_FC_CONE;
  double x[3] = {0}, low[3] = {0}, y[3] = {0}, d = c->d[i], scale = c->scale;
  double by = d / scale, power = by, left = 1;
  if (of.low && by > 0 && by <= DBL_MAX) {
    power = ldexp(1, ilogb(by));
    left = by / power;
  }
  for (int k = 0; k < rows; k++) {
    x[k] = of.r[row + k] * power;
    y[k] = u[k] / scale / left;
    if (of.low) nsdae_dd_add(power, of.low[row + k], x + k, low + k);
  }
  if (i >= c->view.p->contacts) kind = NSDAE_FC_BILATERAL;
  if (kind == NSDAE_FC_CONE && rows == 1) kind = NSDAE_FC_NORMAL;
  double mu = kind == NSDAE_FC_CONE ? c->view.p->mu[i] : 0;
  return left * nsdae_fc_natural(kind, mu, x, of.low ? low : NULL, y);
}

static double largest_residual(void *object, int from, int to)
{
  const evaluation *v = object;
  double most = 0;
  for (int i = from; i < to && most == most; i++) {
    double one = item_residual(v->global, i, v->x, v->u + v->global->view.row[i]);
    if (!(one <= most)) most = one;
  }
  return most;
}

double nsdae_fc_global_residual(const nsdae_fc_global *c, const double *r, const double *low,
                                double *u)
{
  evaluation all = {c, {.items = c->view.items, .blocks = c->view.p->blocks}, {r, low}, u};
  evaluate(&all);
  for (int k = 0; k < c->view.m; k++)
    if (!(fabs(r[k]) <= DBL_MAX) || (low && !(fabs(low[k]) <= DBL_MAX))) return NAN;
  return nsdae_thread_pool_most(c->pool, c->view.items, NSDAE_FC_GRAIN, largest_residual, &all);
}
