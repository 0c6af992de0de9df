/* Rigid bodies in space and their joints as saddle-point equations: masses by blocks of 6, rows of
 * revolute (5) or spherical joints (3) that touch one or two bodies. The first block and the first
 * row are not of the mechanism. */
#ifndef NSDAE_TESTS_JOINT_FAMILIES_H
#define NSDAE_TESTS_JOINT_FAMILIES_H

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "rows.h"
#include "random.h"

enum joint_kind { CHAIN, TREE, NET, LADDER, RING };
enum { OTHER = 2 }; /* size of the block that is not of the mechanism */

typedef struct joint_family {
  random_state random;
  int bodies, rows, nv; /* nv: of the mechanism; rows likewise */
  int rank;
  nsdae_blocks blocks;
  nsdae_rows J;
  int *block, *row, *parent; /* lists; parent: of trees, by body, -1: the ground */
  double *M, *arm;           /* arm: 6 a body of trees: of its joint, in it and in its parent */
} joint_family;

static void *family_room(size_t count, size_t size)
{
  return calloc(count, size);
}

/* mass m and an inertia of 0.02 m with one axis of its own, m = 10^(spread in -1 .. 1) */
static void family_masses(joint_family *f, double spread)
{
  for (int i = 0; i < f->bodies; i++) {
    double *M = f->M + f->blocks.square[i + 1], u[3], length = 0;
    double mass = pow(10, spread * random_number(&f->random));
    double other = 0.3 + fabs(random_number(&f->random));
    for (int k = 0; k < 3; k++) u[k] = random_number(&f->random);
    for (int k = 0; k < 3; k++) length += u[k] * u[k];
    for (int k = 0; k < 3; k++) M[7 * k] = mass;
    for (int r = 0; r < 3; r++)
      for (int c = 0; c < 3; c++)
        M[(3 + c) * 6 + 3 + r] = 0.02 * mass * ((r == c) + (other - 1) * u[r] * u[c] / length);
  }
}

/* A row of bodies a and b (-1: the ground) with these values of 12. */
static void family_row(joint_family *f, int a, int b, const double *value)
{
  int row = f->J.count++, used = f->J.first[row];
  const int body[2] = {a, b};
  for (int s = 0; s < 2; s++) {
    if (body[s] < 0) continue;
    f->J.block[used] = body[s] + 1;
    f->J.at[used] = 6 * (size_t)used;
    memcpy(f->J.value + 6 * used++, value + 6 * s, 6 * sizeof *value);
  }
  f->J.first[row + 1] = used;
}

/* a's point at ra and b's at rb are one; revolute: about the axis. */
static void family_joint(joint_family *f, int a, const double *ra, int b, const double *rb,
                         const double *axis)
{
  for (int i = 0; i < 3; i++) {
    double value[12] = {0};
    int j = (i + 1) % 3, k = (i + 2) % 3;
    value[i] = 1;
    value[3 + j] = ra[k];
    value[3 + k] = -ra[j];
    value[6 + i] = -1;
    value[9 + j] = -rb[k];
    value[9 + k] = rb[j];
    family_row(f, a, b, value);
  }
  for (int i = 0, most = 0; axis && i < 3; i++) { /* two directions across the axis */
    for (int k = 1; k < 3; k++)
      if (fabs(axis[k]) > fabs(axis[most])) most = k;
    if (i == most) continue;
    double value[12] = {0};
    value[3 + i] = axis[most];
    value[3 + most] = -axis[i];
    for (int k = 0; k < 3; k++) value[9 + k] = -value[3 + k];
    family_row(f, a, b, value);
  }
}

static void family_arm(joint_family *f, double *arm, double x, double y, double z, double part)
{
  arm[0] = x + part * random_number(&f->random);
  arm[1] = y + part * random_number(&f->random);
  arm[2] = z + part * random_number(&f->random);
}

static const double *family_axis(joint_family *f, int revolute, double *axis)
{
  for (int k = 0; k < 3; k++) axis[k] = random_number(&f->random);
  return revolute ? axis : NULL;
}

static void family_trees(joint_family *f, int chain, int revolute)
{
  for (int i = 0; i < f->bodies; i++) {
    double axis[3], *arm = f->arm + 6 * i;
    f->parent[i] = chain ? i - 1 : i > 0 ? (i - 1) / 2 : -1;
    family_arm(f, arm, -0.25, 0, 0, 0.05);
    family_arm(f, arm + 3, 0.25, 0, 0, 0.05);
    family_joint(f, i, arm, f->parent[i], arm + 3, family_axis(f, revolute, axis));
  }
}

/* A square net, its first corner on the ground. */
static void family_net(joint_family *f)
{
  int wide = (int)lround(sqrt(f->bodies));
  double a[3], b[3];
  for (int k = 0; k < f->bodies; k++) {
    family_arm(f, a, 0.25, 0, 0, 0.1);
    family_arm(f, b, -0.25, 0, 0, 0.1);
    if (k == 0) family_joint(f, 0, a, -1, b, NULL);
    if (k % wide + 1 < wide) family_joint(f, k, a, k + 1, b, NULL);
    family_arm(f, a, 0, 0, 0.25, 0.1);
    family_arm(f, b, 0, 0, -0.25, 0.1);
    if (k + wide < f->bodies) family_joint(f, k, a, k + wide, b, NULL);
  }
}

/* Parallelograms on each other, 3 bodies each: two cranks and a coupler; 3 of the 20 rows of
 * each depend on others. */
static void family_ladder(joint_family *f)
{
  const double axis[3] = {0, 1, 0};
  for (int l = 0; l < f->bodies / 3; l++) {
    double x = 0.2 * cos(0.9 + 0.01 * l), z = 0.2 * sin(0.9 + 0.01 * l);
    const double low[3] = {-x, 0, -z}, high[3] = {x, 0, z};
    for (int s = -1; s < 2; s += 2) {
      const double at[3] = {0.3 * s, 0, 0};
      int crank = 3 * l + (s > 0);
      family_joint(f, crank, low, l > 0 ? 3 * l - 1 : -1, at, axis);
      family_joint(f, crank, high, 3 * l + 2, at, axis);
    }
  }
  f->rank -= 3 * (f->bodies / 3);
}

/* The half of link i of a ring, each half a length long, from its centre to its end. */
static void ring_half(const joint_family *f, int i, double *half)
{
  double turn = 8 * atan(1) / f->bodies, radius = 0.25 / sin(turn / 2);
  half[0] = radius * (cos((i + 1) * turn) - cos(i * turn)) / 2;
  half[1] = 0;
  half[2] = radius * (sin((i + 1) * turn) - sin(i * turn)) / 2;
}

/* A ring of links on parallel axes, the first also on the ground: of the ring 3 rows depend on
 * others. */
static void family_ring(joint_family *f)
{
  const double axis[3] = {0, 1, 0};
  for (int i = 0; i < f->bodies; i++) {
    int next = (i + 1) % f->bodies;
    double tail[3], head[3];
    ring_half(f, i, tail);
    ring_half(f, next, head);
    for (int k = 0; k < 3; k++) head[k] = -head[k];
    if (i == 0) family_joint(f, 0, tail, -1, head, axis);
    family_joint(f, i, tail, next, head, axis);
  }
  f->rank -= 3;
}

static void family_make(joint_family *f, int kind, int bodies, int revolute, double spread,
                        uint64_t seed)
{
  size_t n = (size_t)bodies, rows = 12 * n + 12;
  *f = (joint_family){.random = {seed}, .bodies = bodies, .nv = 6 * bodies};
  f->blocks.count = bodies + 1;
  f->blocks.first = family_room(n + 2, sizeof(int));
  f->blocks.square = family_room(n + 2, sizeof(size_t));
  f->J.first = family_room(rows + 1, sizeof(int));
  f->J.block = family_room(2 * rows, sizeof(int));
  f->J.at = family_room(2 * rows, sizeof(size_t));
  f->J.value = family_room(12 * rows, sizeof(double));
  f->J.stride = 1;
  f->M = family_room(36 * n + OTHER * OTHER, sizeof(double));
  f->arm = family_room(6 * n, sizeof(double));
  f->parent = family_room(n, sizeof(int));
  f->block = family_room(n, sizeof(int));
  f->row = family_room(rows, sizeof(int));
  for (int b = 0; b <= bodies; b++) {
    f->blocks.first[b + 1] = OTHER + 6 * b;
    f->blocks.square[b + 1] = OTHER * OTHER + 36 * (size_t)b;
  }
  f->J.count = f->J.first[1] = 1; /* a row of the other block */
  family_masses(f, spread);
  if (kind == CHAIN || kind == TREE) family_trees(f, kind == CHAIN, revolute);
  if (kind == NET) family_net(f);
  if (kind == LADDER) family_ladder(f);
  if (kind == RING) family_ring(f);
  f->rows = f->J.count - 1;
  f->rank += f->rows;
  for (int b = 0; b < bodies; b++) f->block[b] = b + 1;
  for (int i = 0; i < f->rows; i++) f->row[i] = i + 1;
}

static void family_release(joint_family *f)
{
  void *all[] = {f->blocks.first, f->blocks.square, f->J.first, f->J.block,
                 f->J.at,         f->J.value,       f->M,       f->arm,
                 f->parent,       f->block,         f->row};
  for (size_t i = 0; i < sizeof all / sizeof *all; i++) free(all[i]);
}

/* r += scale (M x + J^T l), c += scale J x: vectors of the whole system. */
static void family_apply(const joint_family *f, double scale, const double *x, const double *l,
                         double *r, double *c)
{
  for (int b = 1; b <= f->bodies; b++)
    for (int j = 0; j < 6; j++)
      for (int i = 0; i < 6; i++)
        r[f->blocks.first[b] + i] +=
            scale * f->M[f->blocks.square[b] + (size_t)(6 * j + i)] * x[f->blocks.first[b] + j];
  for (int i = 1; i <= f->rows; i++)
    for (int p = f->J.first[i]; p < f->J.first[i + 1]; p++)
      for (int j = 0; j < 6; j++) {
        double value = f->J.value[f->J.at[p] + (size_t)j];
        int at = f->blocks.first[f->J.block[p]] + j;
        r[at] += scale * value * l[i];
        c[i] += scale * value * x[at];
      }
}

#endif
