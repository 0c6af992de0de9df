/* A semicircular arch of equal blocks with radial joints, on the floor. It is stable if a line
 * of thrust fits into it (J. Heyman, The stone skeleton, 1966) and no joint slips. For infinitely
 * many blocks this is a thickness t >= 0.1075 R (M. Milankovitch 1907; R: radius of the middle
 * line).
 *
 * Of n blocks hinges open at joints alone. With the thrust H at the crown, at the height y, the
 * moment of half the arch about a point (a_x, a_y) of a joint is
 *
 *   W (a_x - x_W) - H (y - a_y),   W and x_W: weight and centre of the blocks from crown to joint
 *
 * >= 0 about the outer end of every joint and <= 0 about the inner one: straight lines in the plane
 * of (H, H y). The arch is stable if a point satisfies all. */
#include "arch.h"

#include <math.h>
#include <stddef.h>
#include <stdio.h>

#include "scene.h"

static const double pi = 3.14159265358979323846;

/* Corners of block i, anticlockwise, from the right end on. */
static void corners_of(const arch *p, int i, double *corner)
{
  const double radius[4] = {1 - p->t / 2, 1 + p->t / 2, 1 + p->t / 2, 1 - p->t / 2};
  for (int j = 0; j < 4; j++) {
    double angle = pi * (i + j / 2) / p->blocks;
    corner[2 * j] = p->R * radius[j] * cos(angle);
    corner[2 * j + 1] = fmax(p->R * radius[j] * sin(angle), 0);
    if (i + j / 2 == p->blocks) corner[2 * j + 1] = 0;
  }
}

static int build(void *base, nsdae_system **system, nsdae_error *error)
{
  arch *p = base;
  int status = world_begin(&p->world, 2, p->g, p->mu, 0, error);
  for (int i = 0; i < p->blocks && status >= 0; i++) {
    double corner[8];
    corners_of(p, i, corner);
    status = world_add_block(p->world, 4, corner);
  }
  return world_end(p->world, status, system, error);
}

static void start(const void *base, double *q0, double *v0)
{
  const arch *p = base;
  nsdae_bodies_get_start(p->world, q0, v0);
}

static void follow(void *base, const nsdae_record *r)
{
  arch *p = base;
  int crown = p->blocks / 2;
  if (r->step == 0) p->crown = r->q[3 * crown + 1];
  p->moved = fabs(r->q[3 * crown + 1] - p->crown);
  p->fastest = world_fastest(r, 3 * p->blocks);
}

static void conclude(const void *base)
{
  const arch *p = base;
  printf("the crown has sunk by %.2e m, fastest at the end %.1e: it %s\n", p->moved, p->fastest,
         p->moved < 1e-3 * p->R ? "stands" : "falls");
  printf("least thickness of %d blocks %.5f R, of many 0.1075 R (Milankovitch); this one %.5f R\n",
         p->blocks, arch_least_thickness(p->blocks), p->t);
}

/* a H + b (H y) <= c */
typedef struct half_plane {
  double a, b, c;
} half_plane;

enum { PLANES_MAX = 2 * 512 + 4 };

/* The conditions of half an arch of R = 1, for both ends of each joint from the crown on, which is
 * the middle of a block where their number is odd. The weight of a sector of angle s between radii
 * in and out is s (out^2 - in^2) / 2, its centre at x = (out^3 - in^3) (cos - cos) / 3 over that.
 */
static int conditions(int blocks, double t, half_plane *plane)
{
  double in = 1 - t / 2, out = 1 + t / 2, area = (out * out - in * in) / 2;
  double moment = (out * out * out - in * in * in) / 3;
  int n = 0;
  for (double k = blocks % 2 ? 0.5 : 0; k <= blocks / 2.0 + 0.25; k++) {
    double angle = pi * k / blocks; /* from the crown */
    double W = area * angle, Wx = moment * (1 - cos(angle));
    for (int outer = 0; outer < 2; outer++) {
      double r = outer ? out : in, sign = outer ? -1 : 1;
      /* the thrust passes above the inner end and below the outer one */
      double ax = r * sin(angle), ay = r * cos(angle);
      plane[n++] = (half_plane){sign * ay, -sign, sign * (Wx - W * ax)};
    }
  }
  plane[n++] = (half_plane){-1, 0, 0}; /* H >= 0 */
  return n;
}

/* Whether a point satisfies all: tests the intersections of two lines. */
static int have_point(const half_plane *p, int n)
{
  for (int i = 0; i < n; i++)
    for (int j = i + 1; j < n; j++) {
      double det = p[i].a * p[j].b - p[j].a * p[i].b;
      if (fabs(det) < 1e-14) continue;
      double x = (p[i].c * p[j].b - p[j].c * p[i].b) / det;
      double y = (p[i].a * p[j].c - p[j].a * p[i].c) / det;
      int inside = 1;
      for (int k = 0; k < n && inside; k++) inside = p[k].a * x + p[k].b * y <= p[k].c + 1e-12;
      if (inside) return 1;
    }
  return 0;
}

double arch_least_thickness(int blocks)
{
  static half_plane plane[PLANES_MAX];
  double falls = 0.001, stands = 0.5;
  if (blocks > 200) return 0.1075;
  while (stands - falls > 1e-7) {
    double t = (falls + stands) / 2;
    if (have_point(plane, conditions(blocks, t, plane)))
      stands = t;
    else
      falls = t;
  }
  return stands;
}

#define AT(field) offsetof(arch, field)

static const nsdae_param entries[] = {
    {"blocks", "1", "number of blocks", NSDAE_PARAM_INT, AT(blocks), 31, 3, 1000, 0, NULL},
    {"R", "m", "radius of the middle line", NSDAE_PARAM_REAL, AT(R), 1, 0, INFINITY, NSDAE_OPEN_MIN,
     NULL},
    {"t", "1", "thickness over R", NSDAE_PARAM_REAL, AT(t), 0.12, 0, 1, NSDAE_OPEN_MIN, NULL},
    {"mu", "1", "friction", NSDAE_PARAM_REAL, AT(mu), 0.7, 0, INFINITY, 0, NULL},
    {"g", "m/s^2", "gravity", NSDAE_PARAM_REAL, AT(g), 9.81, 0, INFINITY, 0, NULL},
};

static const nsdae_params table = {entries, (int)(sizeof entries / sizeof *entries)};
static arch parameters;

const driver_model arch_model = {.name = "arch",
                                 .summary =
                                     "a semicircle of blocks, which stands if it is thick enough",
                                 .parameters = &table,
                                 .base = &parameters,
                                 .t_end = 1,
                                 .dt = 1e-3,
                                 .method = NSDAE_METHOD_MOREAU,
                                 .build = build,
                                 .start = start,
                                 .follow = follow,
                                 .conclude = conclude};
