#include "disks.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static const double gravity = 9.81;

void disks_create(disks *d, int n, int columns)
{
  *d = (disks){.n = n, .columns = columns, .radius = 0.05, .mass = 1, .mu = 0.4, .e = 0.3};
  d->width = 2.4 * d->radius * columns;
  d->cells[0] = (int)(d->width / (2 * d->radius)) + 2;
  d->cells[1] = 2 * (n / columns) + 8;
  d->first = malloc((size_t)d->cells[0] * (size_t)d->cells[1] * sizeof *d->first);
  d->next = malloc((size_t)n * sizeof *d->next);
  if (!d->first || !d->next) abort();
}

void disks_destroy(disks *d)
{
  free(d->first);
  free(d->next);
}

long disks_pair_id(const disks *d, int i, int j)
{
  return 3L * d->n + (long)i * d->n + j;
}

long disks_ground_id(const disks *d, int i, int which)
{
  (void)d;
  return 3L * i + which;
}

static int mass_blocks(double t, const double *q, double *M, void *user)
{
  const disks *d = user;
  (void)t;
  (void)q;
  for (int i = 0; i < d->n; i++) {
    double *block = M + 9 * (size_t)i;
    block[0] = block[4] = d->mass;
    block[8] = d->mass * d->radius * d->radius / 2;
  }
  return 0;
}

static int force(double t, const double *q, const double *v, double *F, void *user)
{
  const disks *d = user;
  (void)t;
  (void)q;
  (void)v;
  for (int i = 0; i < d->n; i++) F[3 * i + 1] = -d->mass * gravity;
  return 0;
}

static int potential(double t, const double *q, double *V, void *user)
{
  const disks *d = user;
  (void)t;
  *V = 0;
  for (int i = 0; i < d->n; i++) *V += d->mass * gravity * q[3 * i + 1];
  return 0;
}

/* Along the normal (x, y), from side 0 to side 1, and across it: a disk at the end of -n (side 0)
 * or of n has the lever -sign r. */
static void set_side(nsdae_contact *c, int side, double x, double y, double radius)
{
  double sign = side == 0 ? -1 : 1, (*W)[NSDAE_CONTACT_WIDTH] = c->direction[side];
  W[0][0] = sign * x;
  W[0][1] = sign * y;
  W[1][0] = -sign * y;
  W[1][1] = sign * x;
  W[1][2] = -radius;
}

static int add_ground(const disks *d, nsdae_contact_list *list, int i, int which, double gap,
                      double x, double y, double reach)
{
  nsdae_contact c = {
      .id = disks_ground_id(d, i, which), .block = {-1, i}, .gap = gap, .mu = d->mu, .e_n = d->e};
  if (gap > reach) return 0;
  set_side(&c, 1, x, y, d->radius);
  return nsdae_contact_add(list, &c);
}

static int add_pair(const disks *d, nsdae_contact_list *list, int i, int j, const double *q,
                    double reach)
{
  double x = q[3 * j] - q[3 * i], y = q[3 * j + 1] - q[3 * i + 1], apart = hypot(x, y);
  nsdae_contact c = {.id = disks_pair_id(d, i, j),
                     .block = {i, j},
                     .gap = apart - 2 * d->radius,
                     .mu = d->mu,
                     .e_n = d->e};
  if (c.gap > reach) return 0;
  set_side(&c, 0, x / apart, y / apart, d->radius);
  set_side(&c, 1, x / apart, y / apart, d->radius);
  return nsdae_contact_add(list, &c);
}

/* The cell along an axis; what is outside is in the outermost. */
static int cell_of(const disks *d, int axis, const double *q, double edge)
{
  return (int)fmax(0, fmin(floor(q[axis] / edge), d->cells[axis] - 1));
}

static void sort_into_cells(disks *d, const double *q, double edge)
{
  for (int c = 0; c < d->cells[0] * d->cells[1]; c++) d->first[c] = -1;
  for (int i = d->n - 1; i >= 0; i--) {
    int *cell =
        &d->first[cell_of(d, 1, q + 3 * i, edge) * d->cells[0] + cell_of(d, 0, q + 3 * i, edge)];
    d->next[i] = *cell;
    *cell = i;
  }
}

/* Of disk i with those of greater number in the cells around its own. */
static int add_pairs(const disks *d, nsdae_contact_list *list, int i, const double *q, double edge,
                     double reach)
{
  int x = cell_of(d, 0, q + 3 * i, edge), y = cell_of(d, 1, q + 3 * i, edge), status = 0;
  for (int row = y > 0 ? y - 1 : 0; row <= y + 1 && row < d->cells[1]; row++)
    for (int column = x > 0 ? x - 1 : 0; column <= x + 1 && column < d->cells[0]; column++)
      for (int j = d->first[row * d->cells[0] + column]; j >= 0 && status == 0; j = d->next[j])
        if (j > i) status = add_pair(d, list, i, j, q, reach);
  return status;
}

static int contacts(double t, const double *q, const double *v, double reach,
                    nsdae_contact_list *list, void *user)
{
  disks *d = user;
  double edge = 2 * d->radius + reach;
  int status = 0;
  (void)t;
  (void)v;
  sort_into_cells(d, q, edge);
  for (int i = 0; i < d->n && status == 0; i++) {
    const double *at = q + 3 * i;
    status = add_ground(d, list, i, 0, at[1] - d->radius, 0, 1, reach);
    if (status == 0) status = add_ground(d, list, i, 1, at[0] - d->radius, 1, 0, reach);
    if (status == 0) status = add_ground(d, list, i, 2, d->width - at[0] - d->radius, -1, 0, reach);
    if (status == 0) status = add_pairs(d, list, i, q, edge, reach);
  }
  return status;
}

/* By their coordinates alone, with the spoke that shows how they turn. */
static void add_bodies(const disks *d, nsdae_system *system)
{
  char name[24], x[24], y[24], angle[24], far[24];
  for (int i = 0; i < d->n; i++) {
    snprintf(name, sizeof name, "disk %d", i);
    snprintf(x, sizeof x, "q%d", 3 * i);
    snprintf(y, sizeof y, "q%d", 3 * i + 1);
    snprintf(angle, sizeof angle, "q%d", 3 * i + 2);
    nsdae_system_add_body(system, &(nsdae_body){.name = name,
                                                .shape = NSDAE_SHAPE_DISC,
                                                .size = {d->radius},
                                                .position = {x, y},
                                                .angle = angle});
  }
  snprintf(far, sizeof far, "%.17g", d->width);
  nsdae_system_add_body(system,
                        &(nsdae_body){.name = "floor", .shape = NSDAE_SHAPE_PLANE, .size = {0, 1}});
  nsdae_system_add_body(
      system, &(nsdae_body){.name = "left wall", .shape = NSDAE_SHAPE_PLANE, .size = {1}});
  nsdae_system_add_body(system, &(nsdae_body){.name = "right wall",
                                              .shape = NSDAE_SHAPE_PLANE,
                                              .size = {-1},
                                              .position = {far}});
}

nsdae_system *disks_system(disks *d)
{
  nsdae_system *system;
  const nsdae_dims dims = {.nq = 3 * d->n, .nt = 1};
  int *three = malloc((size_t)d->n * sizeof *three);
  if (!three || nsdae_system_create(&dims, &system, NULL) < 0) abort();
  for (int i = 0; i < d->n; i++) three[i] = 3;
  nsdae_system_set_user(system, d);
  nsdae_system_set_blocks(system, d->n, three, three);
  nsdae_system_set_mass_blocks(system, mass_blocks);
  nsdae_system_set_force(system, force);
  nsdae_system_set_potential(system, potential);
  nsdae_system_set_contacts(system, contacts);
  add_bodies(d, system);
  free(three);
  return system;
}

/* In rows, each shifted a little against the one below so that columns do not stand. */
void disks_start(const disks *d, double *q0, double *v0)
{
  for (int i = 0; i < d->n; i++) {
    int row = i / d->columns, column = i % d->columns;
    q0[3 * i] = d->radius * (1.2 + 2.4 * column + 0.15 * (row % 2));
    q0[3 * i + 1] = d->radius * (1.1 + 2.2 * row);
    q0[3 * i + 2] = 0;
    v0[3 * i] = v0[3 * i + 1] = v0[3 * i + 2] = 0;
  }
}
