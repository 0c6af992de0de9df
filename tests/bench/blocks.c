/* The wall, the arch and the dominoes as their programs have them, written with the kit, beside the
 * same by hand (blocks, contacts by list, every pair looked at, corners against edges of convex
 * polygons and nothing else): whole steps in runs that take turns. Both begin alike and are to come
 * to the same. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "arch.h"
#include "dominoes.h"
#include "wall.h"
#include "ratio.h"

enum { BLOCKS_MAX = 128, RUNS = 7, CORNERS = 4 };

/* ---- by hand */

typedef struct blocks {
  int count;
  double g, mu, floor_mu, m[BLOCKS_MAX], J[BLOCKS_MAX], own[BLOCKS_MAX][CORNERS][2];
  double centre[BLOCKS_MAX][2], radius[BLOCKS_MAX];
} blocks;

static void add(blocks *p, const double *corner)
{
  int n = p->count++;
  double area = 0, *c = p->centre[n];
  for (int i = 0; i < CORNERS; i++) {
    const double *a = corner + 2 * i, *b = corner + 2 * ((i + 1) % CORNERS);
    double cross = a[0] * b[1] - a[1] * b[0];
    area += cross / 2;
    for (int j = 0; j < 2; j++) c[j] += cross * (a[j] + b[j]) / 6;
  }
  for (int j = 0; j < 2; j++) c[j] /= area;
  p->m[n] = area;
  for (int i = 0; i < CORNERS; i++) {
    for (int j = 0; j < 2; j++) p->own[n][i][j] = corner[2 * i + j] - c[j];
    p->radius[n] = fmax(p->radius[n], hypot(p->own[n][i][0], p->own[n][i][1]));
  }
  for (int i = 0; i < CORNERS; i++) {
    const double *a = p->own[n][i], *b = p->own[n][(i + 1) % CORNERS];
    double cross = a[0] * b[1] - a[1] * b[0];
    for (int j = 0; j < 2; j++) p->J[n] += cross * (a[j] * a[j] + a[j] * b[j] + b[j] * b[j]) / 12;
  }
}

static int mass(double t, const double *q, double *M, void *user)
{
  const blocks *p = user;
  (void)t, (void)q;
  for (int i = 0; i < p->count; i++, M += 9) {
    M[0] = M[4] = p->m[i];
    M[8] = p->J[i];
  }
  return 0;
}

static int force(double t, const double *q, const double *v, double *F, void *user)
{
  const blocks *p = user;
  (void)t, (void)q, (void)v;
  for (int i = 0; i < p->count; i++) F[3 * i + 1] = -p->m[i] * p->g;
  return 0;
}

static int potential(double t, const double *q, double *energy, void *user)
{
  const blocks *p = user;
  double sum = 0;
  (void)t;
  for (int i = 0; i < p->count; i++) sum += p->m[i] * p->g * q[3 * i + 1];
  *energy = sum;
  return 0;
}

/* Block i above the normal n of block j (or the floor), with the point x in common. */
static int touch(const blocks *p, nsdae_contact_list *list, const double *q, int i, int j, int part,
                 double gap, const double *n, const double *x)
{
  nsdae_contact c = {.id = ((long)i * (BLOCKS_MAX + 1) + j + 1) * CORNERS + part,
                     .block = {i, j},
                     .gap = gap,
                     .mu = j < 0 ? p->floor_mu : p->mu};
  const double d[2][2] = {{n[0], n[1]}, {-n[1], n[0]}};
  for (int side = 0; side < 2 && c.block[side] >= 0; side++)
    for (int k = 0; k < 2; k++) {
      const double *centre = q + 3 * c.block[side];
      double sign = side ? -1 : 1, arm[2] = {x[0] - centre[0], x[1] - centre[1]};
      double *row = c.direction[side][k];
      row[0] = sign * d[k][0];
      row[1] = sign * d[k][1];
      row[2] = sign * (arm[0] * d[k][1] - arm[1] * d[k][0]);
    }
  return nsdae_contact_add(list, &c);
}

typedef double corners[CORNERS][2];

/* The edge of block j that separates it the most from block i: its normal, a point and length. */
typedef struct edge {
  double separation, n[2], x[2], length;
} edge;

static edge best_edge(const double (*of)[2], const double (*other)[2])
{
  edge best = {.separation = -INFINITY};
  for (int e = 0; e < CORNERS; e++) {
    const double *a = of[e], *b = of[(e + 1) % CORNERS];
    double length = hypot(b[0] - a[0], b[1] - a[1]), least = INFINITY;
    double n[2] = {(b[1] - a[1]) / length, (a[0] - b[0]) / length};
    for (int i = 0; i < CORNERS; i++)
      least = fmin(least, n[0] * (other[i][0] - a[0]) + n[1] * (other[i][1] - a[1]));
    if (least > best.separation) best = (edge){least, {n[0], n[1]}, {a[0], a[1]}, length};
  }
  return best;
}

/* Corners of block i over an edge of block j. */
static int over(const blocks *p, nsdae_contact_list *list, const double *q, int i, int j,
                const double (*at)[2], const edge *e, double least, double reach)
{
  int status = 0;
  for (int k = 0; k < CORNERS && status >= 0; k++) {
    double x[2] = {at[k][0] - e->x[0], at[k][1] - e->x[1]};
    double gap = e->n[0] * x[0] + e->n[1] * x[1], along = -e->n[1] * x[0] + e->n[0] * x[1];
    if (gap > reach || gap < least || along < -1e-4 * e->length || along > 1.0001 * e->length)
      continue;
    const double common[2] = {at[k][0] - gap * e->n[0], at[k][1] - gap * e->n[1]};
    status = touch(p, list, q, i, j, k, gap, e->n, common);
  }
  return status;
}

static int contacts(double t, const double *q, const double *v, double reach,
                    nsdae_contact_list *list, void *user)
{
  const blocks *p = user;
  static corners at[BLOCKS_MAX];
  const double up[2] = {0, 1};
  (void)t, (void)v;
  for (int i = 0; i < p->count; i++) {
    double c = cos(q[3 * i + 2]), s = sin(q[3 * i + 2]);
    for (int k = 0; k < CORNERS; k++) {
      const double *own = p->own[i][k];
      at[i][k][0] = q[3 * i] + c * own[0] - s * own[1];
      at[i][k][1] = q[3 * i + 1] + s * own[0] + c * own[1];
      const double foot[2] = {at[i][k][0], 0};
      if (at[i][k][1] <= reach) touch(p, list, q, i, -1, k, at[i][k][1], up, foot);
    }
    for (int j = 0; j < i; j++) {
      double dx = q[3 * i] - q[3 * j], dy = q[3 * i + 1] - q[3 * j + 1];
      double most = p->radius[i] + p->radius[j] + reach;
      if (dx * dx + dy * dy > most * most) continue;
      const double(*a)[2] = (const double(*)[2])at[i], (*b)[2] = (const double(*)[2])at[j];
      edge of_j = best_edge(b, a), of_i = best_edge(a, b);
      double least = fmax(of_j.separation, of_i.separation) - 1e-6 * of_j.length;
      if (least > reach) continue;
      over(p, list, q, i, j, a, &of_j, least, reach);
      over(p, list, q, j, i, b, &of_i, least, reach);
    }
  }
  return 0;
}

static int by_hand(blocks *p, nsdae_system **system)
{
  static int sizes[BLOCKS_MAX];
  for (int i = 0; i < p->count; i++) sizes[i] = 3;
  const nsdae_dims dims = {.nq = 3 * p->count, .nt = 1};
  if (nsdae_system_create(&dims, system, NULL) < 0) return -1;
  nsdae_system_set_user(*system, p);
  nsdae_system_set_blocks(*system, p->count, sizes, sizes);
  nsdae_system_set_mass_blocks(*system, mass);
  nsdae_system_set_force(*system, force);
  nsdae_system_set_potential(*system, potential);
  return nsdae_system_set_contacts(*system, contacts);
}

/* ---- the blocks of the three */

static void wall_blocks(const void *base, blocks *p)
{
  const wall *w = base;
  p->mu = p->floor_mu = w->mu;
  p->g = w->g;
  for (int row = 0; row < w->courses; row++)
    for (int i = 0; i < w->length + row % 2; i++) {
      double low = row * w->height, x = (i - row % 2 / 2.) * w->width;
      double left = fmax(x, 0) + w->gap / 2,
             right = fmin(x + w->width, w->length * w->width) - w->gap / 2;
      add(p, (double[]){left, low, right, low, right, low + w->height, left, low + w->height});
    }
}

static void arch_blocks(const void *base, blocks *p)
{
  const arch *a = base;
  const double step = acos(-1) / a->blocks, in = a->R * (1 - a->t / 2), out = a->R * (1 + a->t / 2);
  p->mu = p->floor_mu = a->mu;
  p->g = a->g;
  for (int i = 0; i < a->blocks; i++) {
    double c0 = cos(step * i), s0 = sin(step * i), c1 = cos(step * (i + 1)),
           s1 = i + 1 == a->blocks ? 0 : sin(step * (i + 1));
    add(p, (double[]){in * c0, in * s0, out * c0, out * s0, out * c1, out * s1, in * c1, in * s1});
  }
}

static void domino_blocks(const void *base, blocks *p)
{
  const dominoes *d = base;
  p->mu = d->mu;
  p->floor_mu = d->floor_mu;
  p->g = d->g;
  for (int i = 0; i < d->n; i++) {
    double x = i * (d->s + d->d);
    add(p, (double[]){x - d->d, 0, x, 0, x, d->h, x - d->d, d->h});
  }
}

/* ---- both */

/* Time of the steps from the model's start, or -1; q at the end. */
static double run(const driver_model *model, const nsdae_system *system, int steps, double *q)
{
  static double v[3 * BLOCKS_MAX];
  nsdae_sim *sim;
  nsdae_record r;
  nsdae_dims dims;
  nsdae_sim_options options;
  nsdae_sim_options_default(&options);
  options.method = model->method;
  options.dt = model->dt;
  memset(v, 0, sizeof v);
  model->start(model->base, q, v);
  if (nsdae_sim_create(system, &options, &sim, NULL) < 0) return -1;
  double from = ratio_cpu();
  int status = nsdae_sim_init(sim, 0, q, v);
  for (int i = 0; i < steps && status >= 0; i++) status = nsdae_sim_step(sim);
  double took = status < 0 ? -1 : ratio_cpu() - from;
  if (status < 0) printf("%s: %s\n", model->name, nsdae_sim_error(sim)->text);
  nsdae_sim_get_record(sim, &r);
  nsdae_sim_get_dims(sim, &dims);
  memcpy(q, r.q, (size_t)dims.nq * sizeof *q);
  nsdae_sim_destroy(&sim);
  return took;
}

static int compare(const void *a, const void *b)
{
  const double *x = a, *y = b;
  return (*x > *y) - (*x < *y);
}

static int measure(const driver_model *model, void (*lay)(const void *, blocks *), int steps)
{
  static blocks p;
  static double q[2][3 * BLOCKS_MAX];
  nsdae_system *system[2];
  double took[2][RUNS], apart = 0;
  memset(&p, 0, sizeof p);
  nsdae_params_default(model->parameters, model->base);
  lay(model->base, &p);
  if (model->build(model->base, &system[0], NULL) < 0 || by_hand(&p, &system[1]) < 0) return 1;
  for (int i = 0; i < RUNS; i++)
    for (int k = 0; k < 2; k++)
      if ((took[k][i] = run(model, system[k], steps, q[k])) < 0) return 1;
  for (int i = 0; i < 3 * p.count; i++) apart = fmax(apart, fabs(q[0][i] - q[1][i]));
  for (int k = 0; k < 2; k++) qsort(took[k], RUNS, sizeof(double), compare);
  printf("%-8s %3d blocks, %d steps: with the kit %.3f ms a step, by hand %.3f: ratio %.3f; "
         "coordinates differ by %.1e at the end\n",
         model->name, p.count, steps, 1e3 * took[0][RUNS / 2] / steps,
         1e3 * took[1][RUNS / 2] / steps, took[0][RUNS / 2] / took[1][RUNS / 2], apart);
  for (int k = 0; k < 2; k++) nsdae_system_destroy(&system[k]);
  return 0;
}

int main(void)
{
  printf("moreau, medians of %d runs that take turns\n", RUNS);
  return measure(&wall_model, wall_blocks, 100) || measure(&arch_model, arch_blocks, 200) ||
         measure(&dominoes_model, domino_blocks, 500);
}
