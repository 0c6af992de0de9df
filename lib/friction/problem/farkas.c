/* The laws ask for u_N >= 0 and bilateral rows at rest, whatever the friction: a polyhedron (the
 * relaxation). With u = H^T v + w, v anything, there is no such u if and only if (Farkas)
 *
 *   l_N >= 0,  l_B free,  H l = 0,  w . l < 0,
 *
 * for then l . u = w . l < 0, but it must not be negative; W in place of H and q in place of w
 * in the local form. Rows with compliance give way to any velocity and have no part in it. Such an
 * l is found if (0, -1) is in the cone of the columns (H e; w) (nonnegative least squares),
 * few of which it takes. What is reported is then proved on the data as given, in one of two ways:
 *
 * - l rounded to a ratio of integers, or as it is, has H l = 0 and w . l < 0 in exact arithmetic:
 *   the case of normals that cancel, as those of bodies between walls.
 * - G l = (0, -1) with the k chosen columns G has as many rows that are not all zeros. With R near
 *   G^-1 and a = |1 - R G| < 1 its solution is no further from l than |R (G l - b)| / (1 - a)
 * (Rump, Acta Numerica 19 (2010) 287, theorem 10.2), roundings bounded. If that is less than the
 * least l_N, the solution satisfies the conditions, and the l returned is it to that distance: the
 * case of walls at any angle. */
#include "farkas.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "cone.h"
#include "dense.h"
#include "global_problem.h"
#include "vector.h"

/* Largest problem that is looked at: entries of v, and directions. */
enum { MOST_ROWS = 600, MOST_COLUMNS = 2000 };

/* Least distance from the cone, relative, at which the target is outside it. */
static const double OUTSIDE = 1e-9;

static int is_bilateral(const nsdae_fc_scaled *c, int i)
{
  return i >= c->global->view.p->contacts;
}

/* Whether its normal (bilateral) row gives way to any velocity. */
static int gives_way(const nsdae_fc_scaled *c, int i)
{
  const nsdae_friction_problem *p = c->global->view.p;
  return p->compliance && p->compliance[c->global->view.row[i]] > 0;
}

/* w of that row */
static double ray_velocity(const nsdae_fc_scaled *c, int i)
{
  return c->global->view.p->w[c->global->view.row[i]];
}

/* ---- columns of the alternative */

/* Their number; 0 if v = 0 obeys the laws: then there is no l. */
static int count_columns(const nsdae_fc_scaled *c)
{
  int m = 0, rests = 1;
  for (int k = 0; k < c->n; k++) {
    int i = nsdae_fc_member(c, k);
    double w = ray_velocity(c, i);
    if (gives_way(c, i)) continue;
    m += is_bilateral(c, i) ? 2 : 1;
    if (is_bilateral(c, i) ? w != 0 : w < 0) rests = 0;
  }
  return rests ? 0 : m;
}

/* n rows of l, m columns: directions of the rows, their scaled copy, the active-set method, the
 * proof. */
static void lay_out_farkas(void *object, nsdae_arena *arena)
{
  nsdae_fc_farkas *f = object;
  long n = f->cone.n, m = f->cone.m;
  nsdae_cone *c = &f->cone;
  nsdae_arena_ints(arena, m, (int **[]){&f->item, &c->allowed, &c->state, NULL});
  nsdae_arena_ints(arena, n, (int **[]){&c->order, &f->chosen, &f->pivot, &f->kept, NULL});
  nsdae_arena_doubles(arena, m, (double **[]){&f->sign, &f->by, &c->z, NULL});
  nsdae_arena_doubles(arena, n, (double **[]){&f->row, &f->target, &c->w, &c->s, NULL});
  nsdae_arena_doubles(arena, n * m, (double **[]){&f->columns, &f->scaled, NULL});
  nsdae_arena_doubles(arena, n * n, (double **[]){&c->gram, &c->factor, &f->inverse, NULL});
  f->exact = NSDAE_ARENA_DOUBLES(arena, 2 * n);
  c->C = f->scaled;
}

/* The column of direction e, sign +-1: the normal row's parts, and w below. */
static void fill_column(nsdae_fc_farkas *f, int e, int i, double sign)
{
  const nsdae_fc_scaled *c = f->fc;
  const nsdae_fc_view *view = &c->global->view;
  const nsdae_friction_problem *p = view->p;
  double *column = f->columns + (size_t)e * (size_t)f->cone.n;
  memset(column, 0, (size_t)f->cone.n * sizeof *column);
  for (int k = p->first[i]; k < p->first[i + 1]; k++) {
    if (!nsdae_fc_touches(c->global, k)) continue;
    int b = p->block[k], size = c->local ? nsdae_fc_rows(p, b) : p->size[b];
    double *to = column + c->parts.offset[c->global->islands.number[b]];
    for (int d = 0; d < size; d++) to[d] = sign * p->value[view->at[k] + (size_t)d];
  }
  column[f->cone.n - 1] = sign * ray_velocity(c, i);
  f->item[e] = i;
  f->sign[e] = sign;
  f->cone.allowed[e] = 1;
}

/* Rows to entries of about one, then columns to lengths of about one; by powers of two. */
static void scale(nsdae_fc_farkas *f)
{
  size_t n = (size_t)f->cone.n, m = (size_t)f->cone.m;
  for (size_t i = 0; i < n; i++) {
    double most = 0;
    for (size_t j = 0; j < m; j++) most = fmax(most, fabs(f->columns[j * n + i]));
    f->row[i] = 1 / nsdae_fc_power_of_two(most);
  }
  for (size_t j = 0; j < m; j++) {
    double *to = f->scaled + j * n;
    for (size_t i = 0; i < n; i++) to[i] = f->row[i] * f->columns[j * n + i];
    f->by[j] = 1 / nsdae_fc_power_of_two(sqrt(nsdae_dot(f->cone.n, to, to)));
    for (size_t i = 0; i < n; i++) to[i] *= f->by[j];
  }
  memset(f->target, 0, n * sizeof *f->target);
  f->target[n - 1] = -1;
}

/* ---- proof by exact arithmetic */

/* Whether the l of the chosen directions, in exact + n, is a proof to the last bit. */
static int holds(nsdae_fc_farkas *f, int k)
{
  double *a = f->exact, *l = f->exact + f->cone.n;
  for (int i = 0; i < f->cone.n; i++) {
    for (int e = 0; e < k; e++)
      a[e] = f->columns[(size_t)f->chosen[e] * (size_t)f->cone.n + (size_t)i];
    if (nsdae_exact_sign(k, a, 1, l) != (i < f->cone.n - 1 ? 0 : -1)) return 0;
  }
  return 1;
}

/* ---- proof by a bound on the error of the combination */

/* Rows in which a chosen column is not zero, into kept; how many; -1 if scaling the chosen columns
 * lost something: products with powers of two, above 1e-290. */
static int keep_rows(nsdae_fc_farkas *f, int k)
{
  int rows = 0;
  for (int i = 0; i < f->cone.n; i++) {
    int any = 0;
    for (int e = 0; e < k; e++) {
      size_t at = (size_t)f->chosen[e] * (size_t)f->cone.n + (size_t)i;
      if (f->columns[at] == 0) continue;
      if (!(fabs(f->scaled[at]) > 1e-290)) return -1;
      any = 1;
    }
    if (any) f->kept[rows++] = i;
  }
  return rows;
}

/* G [k x k] of the kept rows into gram, R = G^-1 into inverse; 1 if G is singular. */
static int invert(nsdae_fc_farkas *f, int k)
{
  size_t n = (size_t)k;
  for (size_t e = 0; e < n; e++)
    for (size_t i = 0; i < n; i++)
      f->cone.gram[e * n + i] =
          f->scaled[(size_t)f->chosen[e] * (size_t)f->cone.n + (size_t)f->kept[i]];
  memcpy(f->cone.factor, f->cone.gram, n * n * sizeof *f->cone.factor);
  if (nsdae_la_lu(k, f->cone.factor, k, f->pivot) != 0) return 1;
  memset(f->inverse, 0, n * n * sizeof *f->inverse);
  for (size_t j = 0; j < n; j++) {
    f->inverse[j * n + j] = 1;
    nsdae_la_lu_solve(k, f->cone.factor, k, f->pivot, f->inverse + j * n);
  }
  return 0;
}

/* A bound on |1 - R G|, the largest sum of a row. */
static double bound_defect(const nsdae_fc_farkas *f, int k)
{
  size_t n = (size_t)k;
  double most = 0, unit = (k + 4) * DBL_EPSILON;
  for (size_t i = 0; i < n; i++) {
    double sum = 0;
    for (size_t j = 0; j < n; j++) {
      double defect = i == j ? -1 : 0, size = 1;
      for (size_t e = 0; e < n; e++) {
        double term = f->inverse[e * n + i] * f->cone.gram[j * n + e];
        defect += term;
        size += fabs(term);
      }
      sum += fabs(defect) + unit * size;
    }
    if (!(sum <= most)) most = sum;
  }
  return most * (1 + unit);
}

/* G l - b into s, in twice the precision; size: what its rounding is relative to. */
static void residual_of_gram(const nsdae_fc_farkas *f, int k, double *s, double *size)
{
  for (int i = 0; i < k; i++) {
    double high = f->kept[i] == f->cone.n - 1 ? 1 : 0, low = 0;
    size[i] = high;
    for (int e = 0; e < k; e++) {
      double g = f->cone.gram[(size_t)e * (size_t)k + (size_t)i];
      nsdae_dd_add(g, f->target[e], &high, &low);
      size[i] += fabs(g * f->target[e]);
    }
    s[i] = high + low;
  }
}

/* A bound on |R| |G l - b| / (1 - defect), the largest entry. */
static double bound_distance(nsdae_fc_farkas *f, int k, double defect)
{
  double worst = 0, unit = (k + 4) * DBL_EPSILON;
  residual_of_gram(f, k, f->cone.s, f->exact);
  for (int i = 0; i < k; i++)
    f->cone.s[i] = fabs(f->cone.s[i]) * (1 + unit) + unit * unit * f->exact[i];
  for (size_t i = 0; i < (size_t)k; i++) {
    double sum = 0;
    for (size_t j = 0; j < (size_t)k; j++)
      sum += fabs(f->inverse[j * (size_t)k + i]) * f->cone.s[j];
    if (!(sum <= worst)) worst = sum;
  }
  return worst * (1 + unit) / (1 - defect);
}

/* Whether the exact combination near l is positive where it must be. */
static int is_verified(nsdae_fc_farkas *f, int k)
{
  if (keep_rows(f, k) != k || f->kept[k - 1] != f->cone.n - 1) return 0;
  if (invert(f, k) != 0) return 0;
  double defect = bound_defect(f, k);
  if (!(defect < 0.5)) return 0;
  /* l, in target, to rounding: normal equations left it with half the digits. */
  for (int e = 0; e < k; e++) f->target[e] = f->cone.z[f->chosen[e]];
  residual_of_gram(f, k, f->cone.s, f->exact);
  nsdae_la_lu_solve(k, f->cone.factor, k, f->pivot, f->cone.s);
  for (int e = 0; e < k; e++) f->target[e] -= f->cone.s[e];
  double distance = bound_distance(f, k, defect);
  for (int e = 0; e < k; e++) {
    int free = is_bilateral(f->fc, f->item[f->chosen[e]]);
    if (!(f->target[e] > 2 * distance) && !(free && distance < 1)) return 0;
    f->exact[f->cone.n + e] = f->target[e] * f->by[f->chosen[e]];
  }
  return 1;
}

int nsdae_fc_farkas_find(nsdae_fc_farkas *f, const nsdae_fc_scaled *fc, double *l)
{
  f->fc = fc;
  f->cone.n = fc->ny + 1;
  f->cone.m = count_columns(fc);
  if (f->cone.n > MOST_ROWS || f->cone.m > MOST_COLUMNS || f->cone.m == 0) return 0;
  if (nsdae_arena_fit(&f->memory, lay_out_farkas, f) != NSDAE_OK) return NSDAE_E_MEMORY;
  for (int k = 0, e = 0; k < fc->n; k++) {
    int i = nsdae_fc_member(fc, k);
    if (gives_way(fc, i)) continue;
    fill_column(f, e++, i, 1);
    if (is_bilateral(fc, i)) fill_column(f, e++, i, -1);
  }
  scale(f);
  /* ---- the combination of scaled columns, its directions in chosen */
  int k = 0;
  if (nsdae_cone_separate(&f->cone, f->target) != 0) return 0;
  if (!(sqrt(nsdae_dot(f->cone.n, f->cone.w, f->cone.w)) < OUTSIDE)) return 0;
  for (int j = 0; j < f->cone.m; j++)
    if (f->cone.z[j] > 0 && k < f->cone.n) f->chosen[k++] = j;
  double *exact = f->exact + f->cone.n;
  for (int e = 0; e < k; e++) exact[e] = f->cone.z[f->chosen[e]] * f->by[f->chosen[e]];
  /* ---- the proof */
  if (k == 0) return 0;
  if (!holds(f, k)) {
    nsdae_to_integers(k, exact);
    if (!holds(f, k) && !is_verified(f, k)) return 0;
  }
  /* ---- in the rows of the whole, its largest entry about one */
  double most = nsdae_fc_power_of_two(nsdae_largest(k, exact));
  memset(l, 0, (size_t)fc->global->view.m * sizeof *l);
  for (int e = 0; e < k; e++) {
    int j = f->chosen[e];
    l[fc->global->view.row[f->item[j]]] += f->sign[j] * (exact[e] / most);
  }
  return 1;
}

/* The certificate: the scaled natural residual of every item, with velocities from the data as
 * given. */

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
