/* Chains of capsules and ragdolls of ten bodies, with material 1, on a floor of material 0. */
#ifndef NSDAE_TESTS_ARTICULATED_H
#define NSDAE_TESTS_ARTICULATED_H

#include <math.h>
#include <nsdae/nsdae.h>

#include "random.h"

/* A floor and its contacts, and those of bodies with each other. */
static inline nsdae_bodies *articulated_world(double mu)
{
  nsdae_bodies *b = NULL;
  if (nsdae_bodies_create(3, &b, NULL) < 0) return NULL;
  nsdae_bodies_set_gravity(b, (const double[]){0, 0, -9.81});
  nsdae_bodies_add_solid(b, NSDAE_GROUND, &(nsdae_solid){.shape = NSDAE_SHAPE_PLANE});
  nsdae_bodies_set_pair(b, 0, 1, mu, 0, 0);
  nsdae_bodies_set_pair(b, 1, 1, mu, 0, 0);
  return b;
}

/* A capsule (a sphere, if it is as long as wide) of density 1000 from p to q; its number. */
static inline int articulated_capsule(nsdae_bodies *b, const double *p, const double *q,
                                      double radius)
{
  double d[3], length = 0;
  for (int i = 0; i < 3; i++) d[i] = q[i] - p[i], length += d[i] * d[i];
  length = sqrt(length);
  double inner = length - 2 * radius, sine = hypot(d[0], d[1]);
  nsdae_solid solid = {.shape = inner > 1e-9 * length ? NSDAE_SHAPE_CAPSULE : NSDAE_SHAPE_SPHERE,
                       .radius = radius,
                       .length = {0, 0, inner},
                       .material = 1};
  nsdae_rigid_body body = {.quaternion = {1, 0, 0, 0}};
  nsdae_solid_inertia(&solid, 1000, &body.mass, body.inertia, NULL);
  for (int i = 0; i < 3; i++) body.position[i] = (p[i] + q[i]) / 2;
  double half = atan2(sine, d[2]) / 2; /* about z x d */
  body.quaternion[0] = cos(half);
  body.quaternion[1] = sine > 0 ? -sin(half) * d[1] / sine : sin(half);
  body.quaternion[2] = sine > 0 ? sin(half) * d[0] / sine : 0;
  int number = nsdae_bodies_add(b, &body);
  nsdae_bodies_add_solid(b, number, &solid);
  return number;
}

static inline void articulated_joint(nsdae_bodies *b, int kind, int first, int second,
                                     const double *point, const double *axis)
{
  nsdae_joint joint = {.kind = kind, .body = {first, second}};
  for (int i = 0; i < 3; i++) joint.point[i] = point[i], joint.axis[i] = axis[i];
  nsdae_bodies_add_joint(b, &joint);
}

/* Links from a point on along a direction, each turned a little (in the plane of a hinge's axis y);
 * pinned: the first one to the ground. */
static inline void articulated_chain(nsdae_bodies *b, int kind, int links, double length,
                                     const double *from, const double *along, int pinned,
                                     uint64_t *seed)
{
  const double axis[3] = {0, 1, 0};
  double p[3] = {from[0], from[1], from[2]};
  for (int l = 0, last = NSDAE_GROUND; l < links; l++) {
    double d[3], q[3], square = 0;
    for (int i = 0; i < 3; i++) {
      d[i] = along[i] + random_between(seed, -0.01, 0.01);
      if (kind == NSDAE_JOINT_REVOLUTE && i == 1) d[i] = along[i];
      square += d[i] * d[i];
    }
    for (int i = 0; i < 3; i++) q[i] = p[i] + length * d[i] / sqrt(square);
    int body = articulated_capsule(b, p, q, 0.2 * length);
    if (l > 0 || pinned) articulated_joint(b, kind, last, body, p, axis);
    last = body;
    for (int i = 0; i < 3; i++) p[i] = q[i];
  }
}

/* A point of a ragdoll: x to its left, z up. */
static inline const double *articulated_at(const double *centre, double angle, double x, double z,
                                           double *point)
{
  point[0] = centre[0] + cos(angle) * x;
  point[1] = centre[1] + sin(angle) * x;
  point[2] = centre[2] + z;
  return point;
}

/* Torso, head, and two segments of each limb: 75 kg, 1.75 m, nine spherical joints; hinges: knees
 * and elbows are revolute. It stands on its feet at centre z = 1.2. */
static inline void articulated_ragdoll(nsdae_bodies *b, const double *centre, double angle,
                                       int hinges)
{
  static const struct {
    int parent, hinge;
    double from[2], to[2], radius, joint[2];
  } parts[] = {{-1, 0, {0, -0.3}, {0, 0.3}, 0.12, {0, 0}},
               {0, 0, {0, 0.32}, {0, 0.54}, 0.11, {0, 0.31}},
               {0, 0, {0.16, 0.22}, {0.46, 0.22}, 0.045, {0.15, 0.22}},
               {2, 1, {0.47, 0.22}, {0.77, 0.22}, 0.04, {0.465, 0.22}},
               {0, 0, {-0.16, 0.22}, {-0.46, 0.22}, 0.045, {-0.15, 0.22}},
               {4, 1, {-0.47, 0.22}, {-0.77, 0.22}, 0.04, {-0.465, 0.22}},
               {0, 0, {0.09, -0.32}, {0.09, -0.76}, 0.07, {0.09, -0.31}},
               {6, 1, {0.09, -0.78}, {0.09, -1.2}, 0.055, {0.09, -0.77}},
               {0, 0, {-0.09, -0.32}, {-0.09, -0.76}, 0.07, {-0.09, -0.31}},
               {8, 1, {-0.09, -0.78}, {-0.09, -1.2}, 0.055, {-0.09, -0.77}}};
  int number[10];
  for (int i = 0; i < 10; i++) {
    double p[3], q[3];
    const double up[3] = {0, 0, 1}, left[3] = {cos(angle), sin(angle), 0};
    articulated_at(centre, angle, parts[i].from[0], parts[i].from[1], p);
    articulated_at(centre, angle, parts[i].to[0], parts[i].to[1], q);
    number[i] = articulated_capsule(b, p, q, parts[i].radius);
    if (i == 0) continue;
    int kind = hinges && parts[i].hinge ? NSDAE_JOINT_REVOLUTE : NSDAE_JOINT_SPHERICAL;
    articulated_at(centre, angle, parts[i].joint[0], parts[i].joint[1], p);
    articulated_joint(b, kind, number[parts[i].parent], number[i], p, i < 6 ? up : left);
  }
}

#endif
