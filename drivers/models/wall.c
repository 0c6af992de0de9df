/* A wall of blocks in running bond: each lies on halves of two below it; half blocks end every
 * second course. Blocks of a course do not touch. The wall is at rest: all velocities stay exactly
 * zero, and the force on the floor is the weight. The inner forces are not unique (hyperstatic:
 * each block has more contact rows than degrees of freedom). */
#include "wall.h"

#include <math.h>
#include <stddef.h>
#include <stdio.h>

#include "scene.h"

static int add_block(wall *p, double left, double right, int course)
{
  double low = course * p->height, high = low + p->height;
  const double corner[8] = {left + p->gap / 2,  low,  right - p->gap / 2, low,
                            right - p->gap / 2, high, left + p->gap / 2,  high};
  p->weight += (right - left - p->gap) * p->height * p->g;
  p->blocks++;
  return world_add_block(p->world, 4, corner);
}

/* Even courses have whole blocks, odd ones begin and end with a half. */
static int add_course(wall *p, int course)
{
  double shift = course % 2 ? p->width / 2 : 0, end = p->length * p->width;
  int status = NSDAE_OK;
  for (int i = 0; i < p->length + course % 2 && status >= 0; i++) {
    double left = i * p->width - shift;
    status = add_block(p, fmax(left, 0), fmin(left + p->width, end), course);
  }
  return status;
}

static int build(void *base, nsdae_system **system, nsdae_error *error)
{
  wall *p = base;
  int status = world_begin(&p->world, 2, p->g, p->mu, p->e_N, error);
  p->weight = p->fastest = p->carried = 0;
  p->blocks = 0;
  if (p->gap >= p->width / 2) {
    snprintf(error->text, sizeof error->text, "gap = %g m is not below half of width = %g m",
             p->gap, p->width);
    return error->status = NSDAE_E_ARGUMENT;
  }
  for (int i = 0; i < p->courses && status >= 0; i++) status = add_course(p, i);
  return world_end(p->world, status, system, error);
}

static void start(const void *base, double *q0, double *v0)
{
  const wall *p = base;
  nsdae_bodies_get_start(p->world, q0, v0);
}

static void follow(void *base, const nsdae_record *r)
{
  wall *p = base;
  if (r->step == 0) return;
  p->carried = world_ground_impulse(r) / r->duration;
  p->fastest = fmax(p->fastest, world_fastest(r, 3 * p->blocks));
}

static void conclude(const void *base)
{
  const wall *p = base;
  printf("%d blocks: fastest ever %g; floor carries %.12g N, they weigh %.12g N: %+.1e of it\n",
         p->blocks, p->fastest, p->carried, p->weight,
         p->weight > 0 ? p->carried / p->weight - 1 : 0);
}

static int figure(const void *base, driver_figure *f)
{
  const wall *p = base;
  *f = (driver_figure){"force of the floor", "N", p->carried, p->weight};
  return 1;
}

#define AT(field) offsetof(wall, field)

static const nsdae_param entries[] = {
    {"courses", "1", "number of courses", NSDAE_PARAM_INT, AT(courses), 10, 1, 1000, 0, NULL},
    {"length", "1", "blocks per course", NSDAE_PARAM_INT, AT(length), 10, 1, 1000, 0, NULL},
    {"width", "m", "width of a block", NSDAE_PARAM_REAL, AT(width), 0.4, 0, INFINITY,
     NSDAE_OPEN_MIN, NULL},
    {"height", "m", "height of a block", NSDAE_PARAM_REAL, AT(height), 0.2, 0, INFINITY,
     NSDAE_OPEN_MIN, NULL},
    {"gap", "m", "distance of blocks of a course", NSDAE_PARAM_REAL, AT(gap), 0.01, 0, INFINITY,
     NSDAE_OPEN_MIN, NULL},
    {"mu", "1", "friction", NSDAE_PARAM_REAL, AT(mu), 0.5, 0, INFINITY, 0, NULL},
    {"e_N", "1", "restitution", NSDAE_PARAM_REAL, AT(e_N), 0, 0, 1, 0, NULL},
    {"g", "m/s^2", "gravity", NSDAE_PARAM_REAL, AT(g), 9.81, 0, INFINITY, 0, NULL},
};

static const nsdae_params table = {entries, (int)(sizeof entries / sizeof *entries)};
static wall parameters;

const driver_model wall_model = {.name = "wall",
                                 .summary = "blocks in running bond, at rest",
                                 .parameters = &table,
                                 .base = &parameters,
                                 .t_end = 0.1,
                                 .dt = 1e-3,
                                 .method = NSDAE_METHOD_MOREAU,
                                 .build = build,
                                 .start = start,
                                 .follow = follow,
                                 .figure = figure,
                                 .conclude = conclude};
