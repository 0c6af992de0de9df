#include "region.h"

#include <math.h>
#include <string.h>

#include "cone.h"
#include "solver.h"
#include "vector.h"

/* Of the island's items so many may be in the region: Newton's method over all of them costs little
 * more, and sweeps may yet settle some. */
static const double SHARE = 0.6;

/* What the rest of the island may add to the residual; and what is asked at least. */
static const double CLOSE = 0.5, LOOSEST = 1e-2;

void nsdae_fc_region_release(nsdae_fc_region *g)
{
  nsdae_friction_destroy(&g->solver);
  nsdae_arena_release(&g->marks);
  nsdae_arena_release(&g->memory);
}

static void lay_out_marks(void *object, nsdae_arena *arena)
{
  nsdae_fc_region *g = object;
  g->mark = NSDAE_ARENA_INTS(arena, g->fc->n);
  g->number = NSDAE_ARENA_INTS(arena, g->fc->blocks);
  g->offset = NSDAE_ARENA_INTS(arena, g->fc->blocks);
}

static int rows_of(const nsdae_fc *c, int k)
{
  return c->items.kind[k] == NSDAE_FC_CONE ? 3 : 1;
}

/* Whether item k changed in the sweep, or is not solved. */
static int unsettled(const nsdae_fc *c, int k, const double *before, double tol)
{
  const double *r = c->r + 3 * k, rho = c->items.rho[k], weight = c->items.weight[k];
  const double x[3] = {rho * r[0], rho * r[1], rho * r[2]};
  for (int j = 0; j < 3; j++)
    if (weight * fabs(r[j] - before[3 * k + j]) > tol) return 1;
  return weight * nsdae_fc_natural(c->items.kind[k], c->items.mu[k], x, NULL, c->u + 3 * k) > tol;
}

static int touches_marked(const nsdae_fc_region *g, int k)
{
  const nsdae_fc_parts *p = &g->fc->parts;
  for (int e = p->first[k]; e < p->first[k + 1]; e++)
    if (g->number[p->block[e]] >= 0) return 1;
  return 0;
}

/* Items that are unsettled, and their neighbours; how many. */
static int mark_items(nsdae_fc_region *g, const double *before, double tol)
{
  const nsdae_fc *c = g->fc;
  int count = 0;
  for (int b = 0; b < c->blocks; b++) g->number[b] = -1;
  for (int k = 0; k < c->n; k++) {
    if (!unsettled(c, k, before, tol)) continue;
    for (int e = c->parts.first[k]; e < c->parts.first[k + 1]; e++)
      g->number[c->parts.block[e]] = 0;
  }
  for (int k = 0; k < c->n; k++) count += g->mark[k] = touches_marked(g, k);
  return count;
}

/* Sizes of the problem; its blocks in the order of the island's. */
static void measure(nsdae_fc_region *g)
{
  const nsdae_fc *c = g->fc;
  nsdae_friction_problem *p = &g->problem;
  *p = (nsdae_friction_problem){.form = NSDAE_FRICTION_GLOBAL};
  g->m = g->nv = g->entries = 0;
  g->values = g->square = 0;
  for (int k = 0; k < c->n; k++) {
    if (!g->mark[k]) continue;
    *(c->items.kind[k] == NSDAE_FC_BILATERAL ? &p->bilateral : &p->contacts) += 1;
    g->m += rows_of(c, k);
    for (int e = c->parts.first[k]; e < c->parts.first[k + 1]; e++, g->entries++) {
      g->values += (size_t)c->parts.size[c->parts.block[e]] * (size_t)rows_of(c, k);
      g->number[c->parts.block[e]] = 0;
    }
  }
  for (int b = 0; b < c->blocks; b++) {
    if (g->number[b] < 0) continue;
    g->number[b] = p->blocks++;
    g->offset[b] = g->nv;
    g->nv += c->parts.size[b];
    g->square += (size_t)c->parts.size[b] * (size_t)c->parts.size[b];
  }
}

static void lay_out(void *object, nsdae_arena *arena)
{
  nsdae_fc_region *g = object;
  long items = g->problem.contacts + g->problem.bilateral;
  g->rows = NSDAE_ARENA_INTS(arena, items);
  g->first = NSDAE_ARENA_INTS(arena, items + 1);
  g->block = NSDAE_ARENA_INTS(arena, g->entries);
  g->size = NSDAE_ARENA_INTS(arena, g->problem.blocks);
  g->mu = NSDAE_ARENA_DOUBLES(arena, items);
  g->w = NSDAE_ARENA_DOUBLES(arena, g->m);
  g->compliance = NSDAE_ARENA_DOUBLES(arena, g->m);
  g->M = NSDAE_ARENA_DOUBLES(arena, g->square);
  g->f = NSDAE_ARENA_DOUBLES(arena, g->nv);
  g->value = NSDAE_ARENA_DOUBLES(arena, g->values);
  g->r = NSDAE_ARENA_DOUBLES(arena, g->m);
  g->u = NSDAE_ARENA_DOUBLES(arena, g->m);
}

/* M = 1, and f = y as it is. */
static void fill_blocks(nsdae_fc_region *g)
{
  const nsdae_fc *c = g->fc;
  double *M = g->M;
  memset(M, 0, g->square * sizeof *M);
  for (int b = 0; b < c->blocks; b++) {
    int n = c->parts.size[b];
    if (g->number[b] < 0) continue;
    g->size[g->number[b]] = n;
    memcpy(g->f + g->offset[b], c->y + c->parts.offset[b], (size_t)n * sizeof *g->f);
    for (int j = 0; j < n; j++) M[j * (n + 1)] = 1;
    M += n * n;
  }
}

/* Part e of item k: H = J', and f without J' r'. */
static double *fill_part(nsdae_fc_region *g, int k, int e, double *value)
{
  const nsdae_fc *c = g->fc;
  int b = c->parts.block[e], n = c->parts.size[b], rows = rows_of(c, k);
  double *f = g->f + g->offset[b];
  memcpy(value, nsdae_fc_part(c, e), (size_t)n * (size_t)rows * sizeof *value);
  for (int j = 0; j < rows; j++, value += n)
    for (int l = 0; l < n; l++) f[l] -= value[l] * c->r[3 * k + j];
  return value;
}

static void fill(nsdae_fc_region *g)
{
  const nsdae_fc *c = g->fc;
  double *value = g->value;
  int item = 0, row = 0, entry = 0;
  fill_blocks(g);
  g->first[0] = 0;
  for (int k = 0; k < c->n; k++) {
    if (!g->mark[k]) continue;
    size_t bytes = (size_t)rows_of(c, k) * sizeof(double);
    g->rows[item] = rows_of(c, k);
    g->mu[item] = c->items.mu[k];
    memcpy(g->w + row, c->items.q + 3 * k, bytes);
    memcpy(g->compliance + row, c->items.C + 3 * k, bytes);
    memcpy(g->r + row, c->r + 3 * k, bytes);
    for (int e = c->parts.first[k]; e < c->parts.first[k + 1]; e++) {
      value = fill_part(g, k, e, value);
      g->block[entry++] = g->number[c->parts.block[e]];
    }
    g->first[++item] = entry;
    row += rows_of(c, k);
  }
  g->problem.rows = g->rows;
  g->problem.mu = g->mu;
  g->problem.w = g->w;
  g->problem.compliance = c->compliant ? g->compliance : NULL;
  g->problem.size = g->size;
  g->problem.M = g->M;
  g->problem.f = g->f;
  g->problem.first = g->first;
  g->problem.block = g->block;
  g->problem.value = g->value;
}

/* max |q| of the problem, times the largest weight: what a residual of one is in the island. */
static double scale(const nsdae_fc_region *g)
{
  const nsdae_fc *c = g->fc;
  double most = 0, weight = 0;
  for (int k = 0; k < c->n; k++) {
    if (!g->mark[k]) continue;
    weight = fmax(weight, c->items.weight[k]);
    for (int j = 0; j < rows_of(c, k); j++) {
      double q = c->items.q[3 * k + j];
      for (int e = c->parts.first[k]; e < c->parts.first[k + 1]; e++) {
        int b = c->parts.block[e], n = c->parts.size[b];
        q += nsdae_dot(n, nsdae_fc_part(c, e) + j * n, g->f + g->offset[b]);
      }
      most = fmax(most, fabs(q));
    }
  }
  return most * weight;
}

static void scatter(const nsdae_fc_region *g, nsdae_fc *c)
{
  const double *r = g->r;
  for (int k = 0; k < c->n; k++) {
    if (!g->mark[k]) continue;
    for (int j = 0; j < rows_of(c, k); j++) c->r[3 * k + j] = *r++;
  }
}

static int ready(nsdae_fc_region *g)
{
  if (!g->solver && nsdae_fc_create_inner(&g->solver) != NSDAE_OK) return 0;
  return nsdae_arena_fit(&g->memory, lay_out, g) == NSDAE_OK;
}

int nsdae_fc_region_solve(nsdae_fc_region *g, nsdae_fc *c, const double *before, double tol,
                          nsdae_friction_info *info)
{
  nsdae_friction_options options;
  nsdae_friction_info own = {.residual = INFINITY};
  g->fc = c;
  if (nsdae_arena_fit(&g->marks, lay_out_marks, g) != NSDAE_OK) return 0;
  int count = mark_items(g, before, tol);
  if (count == 0 || count > SHARE * c->n) return 0;
  measure(g);
  if (!ready(g)) return -1;
  fill(g);
  nsdae_friction_options_default(&options);
  options.tol = fmin(CLOSE * tol / scale(g), LOOSEST);
  options.stages = NSDAE_FRICTION_TRIVIAL | NSDAE_FRICTION_WARM | NSDAE_FRICTION_PIVOTING;
  int status = nsdae_friction_solver_solve(g->solver, &g->problem, &options, g->r, g->u, &own);
  info->sweeps += own.sweeps;
  info->iterations += own.iterations;
  info->factorisations += own.factorisations;
  if (status != NSDAE_OK && !(own.residual <= options.tol / CLOSE)) return -1;
  scatter(g, c);
  return 1;
}
