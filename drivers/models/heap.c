/* Spheres in a loose column that collapses to a heap. With an aspect ratio they settle in a smooth
 * cylinder, which is removed at one time.
 *
 * Momentum: the impulse of a plane floor is the weight times the time plus the change of momentum
 * of the spheres, Lambda = g t sum m + sum m (z' - z'_0). A smooth cylinder has none.
 *
 * Volume: the overlaps of spheres are a small part of their volume.
 *
 * Slope: that of a cone with the heap's centre of mass and mean square of the distance from the
 * axis, which are H / 4 and 3 R^2 / 10 of a cone of height H and radius R. It grows with friction
 * (Y. C. Zhou, B. H. Xu, A. B. Yu, P. Zulli, Numerical investigation of the angle of repose of
 * monosized spheres, Phys. Rev. E 64, 021301, 2001).
 *
 * Runout and height: deposit.h has the published laws for columns of many grains. If the cylinder
 * is few grains wide, the runout depends on their number too (J. M. Warnett, P. Denissenko, P. J.
 * Thomas, E. Kiraci, M. A. Williams, Scalings of axisymmetric granular column collapse, Granular
 * Matter 16, 115-124, 2014): tests/system/structures.c. */
#include "heap.h"

#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include "deposit.h"
#include "scene.h"

static const double pi = 3.14159265358979323846;

/* A hash of the number, in -1 .. 1: the same heap every time. */
static double scatter(uint32_t i)
{
  i = (i ^ i >> 16) * 0x45d9f3bu;
  i = (i ^ i >> 16) * 0x45d9f3bu;
  return (double)(i ^ i >> 16) / 2147483648.0 - 1;
}

/* A rough floor: fixed spheres side by side. On a plane freely rolling spheres would all separate.
 */
static void add_grit(heap *p, int wide)
{
  for (int i = 0; i < wide * wide; i++) {
    const double at[2] = {i % wide - (wide - 1) / 2.0, i / wide - (wide - 1) / 2.0};
    nsdae_bodies_add_solid(p->world, NSDAE_GROUND,
                           &(nsdae_solid){.shape = NSDAE_SHAPE_SPHERE,
                                          .radius = p->r,
                                          .position = {2 * p->r * at[0], 2 * p->r * at[1], 0}});
  }
}

static void add_sphere(heap *p, int i, nsdae_rigid_body body)
{
  body.mass = p->mass;
  for (int j = 0; j < 3; j++) body.inertia[j] = 0.4 * p->mass * p->r * p->r;
  nsdae_bodies_add(p->world, &body);
  nsdae_bodies_add_solid(
      p->world, i, &(nsdae_solid){.shape = NSDAE_SHAPE_SPHERE, .radius = p->r, .material = 1});
}

/* Layers of square grids, off by up to a tenth of the radius; the floor is far wider. */
static void stack(heap *p)
{
  int side = (int)ceil(cbrt(p->spheres / 2.0)); /* about twice as high as wide */
  double step = 2.25 * p->r;
  if (p->rough) add_grit(p, 6 * side);
  for (int i = 0; i < p->spheres; i++) {
    const int at[3] = {i % side, i / side % side, i / (side * side)};
    nsdae_rigid_body body = {.mass = 0};
    for (int j = 0; j < 3; j++)
      body.position[j] = (at[j] - (j < 2      ? (side - 1) / 2.0
                                   : p->rough ? -1
                                              : -0.5)) *
                             step +
                         0.1 * p->r * scatter((uint32_t)(3 * i + j));
    add_sphere(p, i, body);
  }
}

/* The cylinder, smooth: a contact with each sphere that is near it, n = -(x, y) / |(x, y)|. */
static int cylinder(double t, const double *q, const double *v, double reach,
                    nsdae_contact_list *list, void *user)
{
  const heap *p = user;
  int status = NSDAE_OK;
  (void)v;
  if (t >= p->cylinder.release) return NSDAE_OK;
  for (int i = 0; i < p->spheres && status >= 0; i++) {
    const double *x = q + 7 * i;
    double from = hypot(x[0], x[1]), gap = p->cylinder.radius - p->r - from;
    if (gap > reach || from == 0) continue;
    double n[2] = {-x[0] / from, -x[1] / from};
    status = nsdae_contact_add(
        list, &(nsdae_contact){.id = -1 - i,
                               .block = {NSDAE_GROUND, i},
                               .gap = gap,
                               .direction[1] = {{n[0], n[1], 0}, {-n[1], n[0], 0}, {0, 0, 1}}});
  }
  return status;
}

/* Sphere i, at a node of the grid, with a random velocity up to that of a fall by one radius: the
 * spheres then settle in disorder. */
static void pour(heap *p, int i, double x, double y, double z)
{
  const double node[3] = {x, y, z}, fast = sqrt(2 * p->g * p->r);
  uint32_t number = 6 * ((uint32_t)i + 1000003u * (uint32_t)p->cylinder.seed);
  nsdae_rigid_body body = {.mass = 0};
  for (uint32_t j = 0; j < 3; j++) {
    body.position[j] = node[j] + 0.1 * p->r * scatter(number + j);
    body.velocity[j] = fast * scatter(number + 3 + j);
  }
  add_sphere(p, i, body);
}

/* Fills a cylinder to the height of aspect radii, with a packing of 0.58 as of poured spheres. The
 * floor extends to twice the published runout. */
static void fill(heap *p)
{
  double step = 2.25 * p->r, R = p->r * cbrt(p->spheres / (0.75 * 0.58 * p->cylinder.aspect));
  int half = (int)(R / step) + 1, i = 0;
  p->cylinder.radius = R = fmax(R, 1.2 * p->r);
  if (p->rough) add_grit(p, (int)ceil(R * (1 + 2 * deposit_runout(p->cylinder.aspect)) / p->r));
  for (int k = 1; i < p->spheres; k++)
    for (int n = 0; n < (2 * half + 1) * (2 * half + 1) && i < p->spheres; n++) {
      double off = k % 2 ? 0 : 0.5, x = (n % (2 * half + 1) - half + off) * step;
      double y = (n / (2 * half + 1) - half + off) * step;
      if (hypot(x, y) <= R - 1.15 * p->r || (off == 0 && x == 0 && y == 0))
        pour(p, i++, x, y, k * step);
    }
  nsdae_bodies_set_user_rows(p->world, &(nsdae_user_rows){.contacts = cylinder, .user = p});
}

static int build(void *base, nsdae_system **system, nsdae_error *error)
{
  heap *p = base;
  int status = world_begin(&p->world, 3, p->g, p->mu, p->e_N, error);
  if (status < 0) return status;
  free(p->place);
  p->place = malloc(3 * (size_t)p->spheres * sizeof *p->place);
  if (!p->place) {
    snprintf(error->text, sizeof error->text, "out of memory");
    return error->status = NSDAE_E_MEMORY;
  }
  p->mass = 4 * pi / 3 * p->r * p->r * p->r * 1000;
  p->weight = p->mass * p->g * p->spheres;
  p->impulse = p->worst_momentum = p->cylinder.filled = 0;
  p->begun = 0;
  if (p->cylinder.aspect > 0)
    fill(p);
  else
    stack(p);
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

/* Places, momentum and slope; the height in the cylinder is twice that of the centre of mass. */
static void measure(heap *p, const nsdae_record *r)
{
  double top = 0, square = 0;
  p->momentum = 0;
  for (int i = 0; i < p->spheres; i++) {
    const double *x = r->q + 7 * i;
    for (int j = 0; j < 3; j++) p->place[3 * i + j] = x[j];
    p->momentum += p->mass * r->v[6 * i + 2];
    top += (x[2] - p->r) / p->spheres;
    square += (x[0] * x[0] + x[1] * x[1]) / p->spheres;
  }
  p->angle = atan2(4 * top, sqrt(10 * square / 3));
  if (p->cylinder.radius > 0 && r->time <= p->cylinder.release * (1 + 1e-12))
    p->cylinder.filled = 2 * (p->rough ? top : top + p->r) / p->cylinder.radius;
}

/* From the first record on: the start, or the record of a continued run. */
static void balance(heap *p, const nsdae_record *r)
{
  if (p->begun)
    p->impulse += world_ground_impulse(r);
  else {
    p->since = r->time;
    p->from = p->momentum;
    p->begun = 1;
  }
  double given = p->weight * (r->time - p->since) + p->momentum - p->from;
  p->worst_momentum = fmax(p->worst_momentum, fabs(p->impulse - given));
}

static void follow(void *base, const nsdae_record *r)
{
  heap *p = base;
  double overlap = 0;
  measure(p, r);
  balance(p, r);
  for (int i = 0; i < r->contacts.count; i++)
    if (r->contacts.gap[i] < 0) overlap += lens(p->r, -r->contacts.gap[i]);
  p->filled = overlap / p->spheres;
}

static void print_deposit(const heap *p)
{
  int seen = p->cylinder.filled > 0;
  double a = seen ? p->cylinder.filled : p->cylinder.aspect, R = p->cylinder.radius;
  deposit d;
  if (deposit_measure(p->spheres, p->r, p->place, &d) < 0) return;
  printf("column a = %.3f%s, of radius %.2f diameters; %d of %d spheres in one pile\n", a,
         seen ? "" : " (asked for)", R / (2 * p->r), d.pile, p->spheres);
  printf("runout / radius %.3f +- %.3f over the directions; of many grains %.3f (Lube et al. "
         "2004)\n",
         d.radius / R - 1, d.scatter / R, deposit_runout(a));
  /* over the tops of the floor's spheres, or the plane */
  printf("height / radius %.3f", (p->rough ? d.height : d.height + p->r) / R);
  if (deposit_height(a) > 0) printf("; of many grains %.3f", deposit_height(a));
  printf("\n");
}

static void conclude(const void *base)
{
  const heap *p = base;
  printf("%.1e of the volume lies in other spheres\n", p->filled);
  if (p->cylinder.aspect > 0) print_deposit(p);
  if (!p->rough) {
    printf("momentum balance %.1e of the floor's impulse\n",
           p->impulse > 0 ? p->worst_momentum / p->impulse : p->worst_momentum);
    return;
  }
  printf("slope of the heap %.1f degrees%s\n", p->angle * 180 / pi,
         p->cylinder.aspect > 0 ? "" : "; it grows with friction (Zhou et al. 2001)");
}

#define AT(field) offsetof(heap, field)

static const nsdae_param entries[] = {
    {"spheres", "1", "number of spheres", NSDAE_PARAM_INT, AT(spheres), 100, 1, 1e6, 0, NULL},
    {"r", "m", "radius", NSDAE_PARAM_REAL, AT(r), 0.01, 0, INFINITY, NSDAE_OPEN_MIN, NULL},
    {"rough", "1", "1: floor of spheres, 0: plane", NSDAE_PARAM_INT, AT(rough), 1, 0, 1, 0, NULL},
    {"aspect", "1",
     "height over radius of a cylinder that is lifted; 0: a loose column, no cylinder",
     NSDAE_PARAM_REAL, AT(cylinder.aspect), 0, 0.05, 20, NSDAE_OR_ZERO, NULL},
    {"release", "s", "time at which the cylinder is removed", NSDAE_PARAM_REAL,
     AT(cylinder.release), 0.2, 0, INFINITY, 0, NULL},
    {"seed", "1", "seed of the start positions in the cylinder", NSDAE_PARAM_INT, AT(cylinder.seed),
     0, 0, 1000, 0, NULL},
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
                                 .build = build,
                                 .start = start,
                                 .follow = follow,
                                 .conclude = conclude};
