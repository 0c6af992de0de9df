/* A column of balls at rest, every second one ratio times as heavy as the others. The force on the
 * floor is the weight for every ratio,
 *
 *   F = g sum m_i */
#include "column.h"

#include <math.h>
#include <stddef.h>
#include <stdio.h>

#include "scene.h"

static double mass_of(const column *p, int i)
{
  return i % 2 ? p->ratio * p->m : p->m;
}

static int build(void *base, nsdae_system **system, nsdae_error *error)
{
  column *p = base;
  int status = world_begin(&p->world, 3, p->g, p->mu, p->e_N, error);
  if (status < 0) return status;
  p->weight = 0;
  for (int i = 0; i < p->balls; i++) {
    double m = mass_of(p, i), J = 0.4 * m * p->r * p->r;
    int ball = nsdae_bodies_add(
        p->world, &(nsdae_rigid_body){
                      .mass = m, .inertia = {J, J, J}, .position = {0, 0, (2 * i + 1) * p->r}});
    nsdae_bodies_add_solid(
        p->world, ball, &(nsdae_solid){.shape = NSDAE_SHAPE_SPHERE, .radius = p->r, .material = 1});
    p->weight += m * p->g;
  }
  return world_end(p->world, NSDAE_OK, system, error);
}

static void start(const void *base, double *q0, double *v0)
{
  const column *p = base;
  nsdae_bodies_get_start(p->world, q0, v0);
}

static void follow(void *base, const nsdae_record *r)
{
  column *p = base;
  if (r->step == 0) return;
  p->carried = world_ground_impulse(r) / r->duration;
  p->fastest = world_fastest(r, 6 * p->balls);
}

static void conclude(const void *base)
{
  const column *p = base;
  printf("floor carries %.12g N, the balls weigh %.12g N: %+.1e of it; fastest at the end %.1e\n",
         p->carried, p->weight, p->weight > 0 ? p->carried / p->weight - 1 : 0, p->fastest);
}

static int figure(const void *base, driver_figure *f)
{
  const column *p = base;
  *f = (driver_figure){"force of the floor", "N", p->carried, p->weight};
  return 1;
}

#define AT(field) offsetof(column, field)

static const nsdae_param entries[] = {
    {"balls", "1", "number of balls", NSDAE_PARAM_INT, AT(balls), 100, 1, 1e5, 0, NULL},
    {"m", "kg", "mass of balls 0, 2, 4, ...", NSDAE_PARAM_REAL, AT(m), 1, 0, INFINITY,
     NSDAE_OPEN_MIN, NULL},
    {"ratio", "1", "mass ratio of the other balls", NSDAE_PARAM_REAL, AT(ratio), 1000, 0, INFINITY,
     NSDAE_OPEN_MIN, NULL},
    {"r", "m", "radius of a ball", NSDAE_PARAM_REAL, AT(r), 0.1, 0, INFINITY, NSDAE_OPEN_MIN, NULL},
    {"mu", "1", "friction", NSDAE_PARAM_REAL, AT(mu), 0, 0, INFINITY, 0, NULL},
    {"e_N", "1", "restitution", NSDAE_PARAM_REAL, AT(e_N), 0, 0, 1, 0, NULL},
    {"g", "m/s^2", "gravity", NSDAE_PARAM_REAL, AT(g), 9.81, 0, INFINITY, 0, NULL},
};

static const nsdae_params table = {entries, (int)(sizeof entries / sizeof *entries)};
static column parameters;

const driver_model column_model = {.name = "column",
                                   .summary = "balls that rest on each other, heavy on light ones",
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
