#include "scene.h"

#include <math.h>
#include <stdlib.h>

enum { CORNERS_MAX = 64 };

int world_begin(nsdae_bodies **world, int dimension, double g, double mu, double e_N,
                nsdae_error *error)
{
  const nsdae_solid floor = {.shape = NSDAE_SHAPE_PLANE};
  const double gravity[3] = {0, dimension == 2 ? -g : 0, dimension == 3 ? -g : 0};
  nsdae_bodies_destroy(world);
  int status = nsdae_bodies_create(dimension, world, error);
  if (status < 0) return status;
  nsdae_bodies_set_gravity(*world, gravity);
  nsdae_bodies_add_solid(*world, NSDAE_GROUND, &floor);
  nsdae_bodies_set_pair(*world, 0, 1, mu, e_N, 0);
  nsdae_bodies_set_pair(*world, 1, 1, mu, e_N, 0);
  return NSDAE_OK;
}

int world_end(nsdae_bodies *world, int status, nsdae_system **system, nsdae_error *error)
{
  if (status < 0 && nsdae_bodies_error(world)->status == NSDAE_OK) return status;
  status = nsdae_bodies_system(world, system);
  if (status < 0) *error = *nsdae_bodies_error(world);
  return status < 0 ? status : NSDAE_OK; /* a likely mistake is none here */
}

double world_ground_impulse(const nsdae_record *r)
{
  double sum = 0;
  for (int i = 0; i < r->contacts.count; i++)
    if (r->contacts.id[i] >= 0 &&
        (r->contacts.block[2 * i] < 0 || r->contacts.block[2 * i + 1] < 0))
      sum += r->contacts.normal_impulse[i];
  return sum;
}

double world_fastest(const nsdae_record *r, int n)
{
  double most = 0;
  for (int i = 0; i < n; i++) most = fmax(most, fabs(r->v[i]));
  return most;
}

/* Centroid: sum (a x b)(a + b) / 6 over the edges, by the area. */
static void centroid(int points, const double *corner, double *centre)
{
  double area = 0;
  centre[0] = centre[1] = 0;
  for (int i = 0; i < points; i++) {
    const double *a = corner + 2 * i, *b = corner + 2 * ((i + 1) % points);
    double cross = a[0] * b[1] - a[1] * b[0];
    area += cross / 2;
    for (int j = 0; j < 2; j++) centre[j] += cross * (a[j] + b[j]) / 6;
  }
  for (int j = 0; j < 2; j++) centre[j] /= area;
}

int world_add_block(nsdae_bodies *world, int points, const double *corner)
{
  double own[2 * CORNERS_MAX], centre[2];
  nsdae_rigid_body body = {.mass = 0};
  if (points > CORNERS_MAX) return NSDAE_E_ARGUMENT;
  centroid(points, corner, centre);
  for (int i = 0; i < 2 * points; i++) own[i] = corner[i] - centre[i % 2];
  nsdae_solid solid = {.shape = NSDAE_SHAPE_POLYGON, .points = points, .point = own, .material = 1};
  int status = nsdae_solid_inertia(&solid, 1, &body.mass, body.inertia, NULL);
  if (status < 0) return status;
  body.position[0] = centre[0];
  body.position[1] = centre[1];
  int number = nsdae_bodies_add(world, &body);
  if (number < 0) return number;
  status = nsdae_bodies_add_solid(world, number, &solid);
  return status < 0 ? status : number;
}
