/* Spheres in a loose column that collapses to a heap.
 *
 * Momentum: what a floor that is a plane gave is the weight times the time and the momentum of the
 * spheres, Lambda = g t sum m + sum m z'.
 *
 * Volume: spheres do not go into each other; their lenses of overlap are little of their volume.
 *
 * Slope: that of a cone with the heap's centre of mass and mean square of the distance from the
 * axis, which are H / 4 and 3 R^2 / 10 of a cone of height H and radius R. It grows with friction
 * (Y. C. Zhou, B. H. Xu, A. B. Yu, P. Zulli, Numerical investigation of the angle of repose of
 * monosized spheres, Phys. Rev. E 64, 021301, 2001). */
#include "heap.h"

#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "world.h"

static const double pi = 3.14159265358979323846;

/* A hash of the number, in -1 .. 1: the same heap every time. */
static double scatter(uint32_t i)
{
  i = (i ^ i >> 16) * 0x45d9f3bu;
  i = (i ^ i >> 16) * 0x45d9f3bu;
  return (double)(i ^ i >> 16) / 2147483648.0 - 1;
}

/* A rough floor: spheres side by side that stand still, far wider than the column; on a plane those
 * that roll freely would all part. */
static void add_grit(heap *p, int side)
{
  int wide = 6 * side;
  for (int i = 0; i < wide * wide; i++) {
    const double at[2] = {i % wide - (wide - 1) / 2.0, i / wide - (wide - 1) / 2.0};
    nsdae_bodies_add_solid(p->world, NSDAE_GROUND,
                           &(nsdae_solid){.shape = NSDAE_SHAPE_SPHERE,
                                          .radius = p->r,
                                          .position = {2 * p->r * at[0], 2 * p->r * at[1], 0}});
  }
}

/* Layers of square grids, about twice as high as wide, off by up to a tenth of the radius. */
static int build(void *base, nsdae_system **system, nsdae_error *error)
{
  heap *p = base;
  int side = (int)ceil(cbrt(p->spheres / 2.0));
  double m = 4 * pi / 3 * p->r * p->r * p->r * 1000, J = 0.4 * m * p->r * p->r, step = 2.25 * p->r;
  int status = world_begin(&p->world, 3, p->g, p->mu, p->e_N, error);
  if (status < 0) return status;
  if (p->rough) add_grit(p, side);
  p->mass = m;
  p->weight = m * p->g * p->spheres;
  p->impulse = p->worst_momentum = 0;
  for (int i = 0; i < p->spheres; i++) {
    const int at[3] = {i % side, i / side % side, i / (side * side)};
    nsdae_rigid_body body = {.mass = m, .inertia = {J, J, J}};
    for (int j = 0; j < 3; j++)
      body.position[j] = (at[j] - (j < 2      ? (side - 1) / 2.0
                                   : p->rough ? -1
                                              : -0.5)) *
                             step +
                         0.1 * p->r * scatter((uint32_t)(3 * i + j));
    nsdae_bodies_add(p->world, &body);
    nsdae_bodies_add_solid(
        p->world, i, &(nsdae_solid){.shape = NSDAE_SHAPE_SPHERE, .radius = p->r, .material = 1});
  }
  return world_end(p->world, NSDAE_OK, system, error);
}

static void start(const void *base, double *q0, double *v0)
{
  const heap *p = base;
  nsdae_bodies_get_start(p->world, q0, v0);
}

/* Of a lens of two spheres of radius r whose surfaces overlap by d: pi d^2 (3 r - d / 2) / 6, over
 * a sphere's volume (of heights d / 2 each: 2 pi (d/2)^2 (r - d/6)). */
static double lens(double r, double d)
{
  return d * d * (r - d / 6) / 2 / (4 * r * r * r / 3);
}

static void follow(void *base, const nsdae_record *r)
{
  heap *p = base;
  double top = 0, square = 0, overlap = 0;
  if (r->step > 0) p->impulse += world_ground_impulse(r);
  p->momentum = 0;
  for (int i = 0; i < p->spheres; i++) {
    const double *x = r->q + 7 * i;
    p->momentum += p->mass * r->v[6 * i + 2];
    top += (x[2] - p->r) / p->spheres;
    square += (x[0] * x[0] + x[1] * x[1]) / p->spheres;
  }
  for (int i = 0; i < r->contacts.count; i++)
    if (r->contacts.gap[i] < 0) overlap += lens(p->r, -r->contacts.gap[i]);
  p->filled = overlap / p->spheres;
  p->worst_momentum = fmax(p->worst_momentum, fabs(p->impulse - p->weight * r->time - p->momentum));
  p->angle = atan2(4 * top, sqrt(10 * square / 3));
}

static void conclude(const void *base)
{
  const heap *p = base;
  printf("%.1e of the volume lies in other spheres\n", p->filled);
  if (!p->rough) {
    printf("momentum balance %.1e of the floor's impulse\n",
           p->impulse > 0 ? p->worst_momentum / p->impulse : p->worst_momentum);
    return;
  }
  printf("slope of the heap %.1f degrees; it grows with friction (Zhou et al. 2001)\n",
         p->angle * 180 / pi);
}

#define AT(field) offsetof(heap, field)

static const nsdae_param entries[] = {
    {"spheres", "1", "how many", NSDAE_PARAM_INT, AT(spheres), 100, 1, 1e6, 0, NULL},
    {"r", "m", "radius", NSDAE_PARAM_REAL, AT(r), 0.01, 0, INFINITY, NSDAE_OPEN_MIN, NULL},
    {"rough", "1", "1: the floor is of spheres, 0: a plane, on which they part", NSDAE_PARAM_INT,
     AT(rough), 1, 0, 1, 0, NULL},
    {"mu", "1", "friction", NSDAE_PARAM_REAL, AT(mu), 0.5, 0, INFINITY, 0, NULL},
    {"e_N", "1", "restitution", NSDAE_PARAM_REAL, AT(e_N), 0, 0, 1, 0, NULL},
    {"g", "m/s^2", "gravity", NSDAE_PARAM_REAL, AT(g), 9.81, 0, INFINITY, 0, NULL},
};

static const nsdae_params table = {entries, (int)(sizeof entries / sizeof *entries)};
static heap parameters;

const driver_model heap_model = {.name = "heap",
                                 .summary = "a loose column of spheres collapses to a heap",
                                 .parameters = &table,
                                 .base = &parameters,
                                 .t_end = 0.5,
                                 .dt = 2e-3,
                                 .method = NSDAE_METHOD_MOREAU,
                                 .lcp_tol = 1e-4,
                                 .build = build,
                                 .start = start,
                                 .follow = follow,
                                 .conclude = conclude};
