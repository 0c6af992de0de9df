/* A mechanism of every shape, in the plane or in space, its trajectory, and beside it where the
 * four points (0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1) of each solid's frame are at every record,
 * found from the body's coordinates by nsdae_bodies_locate: for shown_check.py, which has it of the
 * formulas of the file. usage: shown 2|3 FILE.h5 SEED */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <nsdae/nsdae.h>

#include "support/random.h"

enum { SOLIDS = 10, RECORDS = 21, FRAME = 4, NQ_MAX = 70 };

static uint64_t seed;

static double uniform(double low, double high)
{
  return random_between(&seed, low, high);
}

typedef struct witness {
  nsdae_bodies *bodies;
  int d, solids, body[SOLIDS], records;
  nsdae_solid solid[SOLIDS];
  double at[RECORDS][SOLIDS][FRAME][3];
} witness;

/* x := the point e of the solid's frame, in its body's. */
static void in_body(const nsdae_solid *s, int d, const double *e, double *x)
{
  if (d == 2) {
    double c = cos(s->angle), sine = sin(s->angle);
    x[0] = s->position[0] + c * e[0] - sine * e[1];
    x[1] = s->position[1] + sine * e[0] + c * e[1];
    x[2] = 0;
    return;
  }
  /* e + 2 w (u X e) + 2 u X (u X e), over the square of the length */
  const double *p = s->quaternion, *u = p + 1;
  double square = p[0] * p[0] + u[0] * u[0] + u[1] * u[1] + u[2] * u[2], a[3];
  for (int i = 0; i < 3; i++)
    a[i] = u[(i + 1) % 3] * e[(i + 2) % 3] - u[(i + 2) % 3] * e[(i + 1) % 3];
  for (int i = 0; i < 3; i++) {
    double b = u[(i + 1) % 3] * a[(i + 2) % 3] - u[(i + 2) % 3] * a[(i + 1) % 3];
    x[i] = s->position[i] + e[i] + 2 * (p[0] * a[i] + b) / square;
  }
}

static int see(const nsdae_record *r, nsdae_error *error, void *user)
{
  witness *w = user;
  (void)error;
  for (int i = 0; i < w->solids && w->records < RECORDS; i++)
    for (int j = 0; j < FRAME; j++) {
      double e[3] = {j == 1, j == 2, j == 3}, x[3];
      in_body(&w->solid[i], w->d, e, x);
      nsdae_bodies_locate(w->bodies, r->q, w->body[i], x, w->at[w->records][i][j]);
    }
  w->records++;
  return 0;
}

static void add_body(witness *w)
{
  nsdae_rigid_body b = {.mass = 1, .inertia = {1, 2, 3}, .angle = uniform(-3, 3)};
  for (int i = 0; i < w->d; i++) {
    b.position[i] = uniform(-3, 3);
    b.velocity[i] = uniform(-1, 1);
  }
  for (int i = 0; i < 4; i++) b.quaternion[i] = uniform(-1, 1);
  if (w->d == 2) memset(b.quaternion, 0, sizeof b.quaternion);
  if (w->d == 3) b.angle = 0;
  for (int i = w->d == 2 ? 2 : 0; i < 3; i++) b.spin[i] = uniform(-3, 3);
  nsdae_bodies_add(w->bodies, &b);
}

static void add_solid(witness *w, int body, int shape)
{
  static const double corners[8] = {-0.5, -0.4, 0.6, -0.3, 0.5, 0.5, -0.4, 0.3};
  nsdae_solid *s = &w->solid[w->solids];
  *s = (nsdae_solid){.shape = shape,
                     .radius = uniform(0.1, 0.5),
                     .length = {uniform(0.5, 2), uniform(0.5, 2), uniform(0.5, 2)},
                     .points = 4,
                     .hollow = uniform(0, 1) < 0.5,
                     .point = corners,
                     .angle = uniform(-3, 3)};
  for (int i = 0; i < w->d; i++) s->position[i] = uniform(-1, 1);
  for (int i = 0; i < 4; i++) s->quaternion[i] = uniform(-1, 1);
  if (w->d == 2) memset(s->quaternion, 0, sizeof s->quaternion);
  if (w->d == 3) s->angle = 0;
  w->body[w->solids++] = body;
  nsdae_bodies_add_solid(w->bodies, body, s);
}

static void build(witness *w)
{
  static const int planar[5] = {NSDAE_SHAPE_POINT, NSDAE_SHAPE_DISC, NSDAE_SHAPE_SEGMENT,
                                NSDAE_SHAPE_POLYGON, NSDAE_SHAPE_PLANE};
  static const int spatial[5] = {NSDAE_SHAPE_POINT, NSDAE_SHAPE_SPHERE, NSDAE_SHAPE_CAPSULE,
                                 NSDAE_SHAPE_BOX, NSDAE_SHAPE_PLANE};
  nsdae_bodies_create(w->d, &w->bodies, NULL);
  for (int i = 0; i < 4; i++) add_body(w); /* the last has no solid */
  for (int i = 0; i < 5; i++) {
    add_solid(w, i % 3, (w->d == 2 ? planar : spatial)[i]);
    add_solid(w, NSDAE_GROUND, (w->d == 2 ? planar : spatial)[i]);
  }
  nsdae_bodies_add_spring(w->bodies, &(nsdae_spring){.body = {NSDAE_GROUND, 0},
                                                     .point = {1, 2},
                                                     .end = {0.5, 0.5},
                                                     .stiffness = 1,
                                                     .rest = 1});
  nsdae_bodies_add_joint(w->bodies, &(nsdae_joint){.kind = NSDAE_JOINT_DISTANCE,
                                                   .body = {1, 2},
                                                   .point = {1, 2},
                                                   .end = {-1, 0.5}});
}

static int fail(const char *why)
{
  fprintf(stderr, "shown: %s\n", why);
  return 1;
}

int main(int argc, char **argv)
{
  static witness w;
  nsdae_system *system;
  nsdae_sim *sim;
  nsdae_trajectory *file;
  nsdae_error error;
  double q[NQ_MAX], v[NQ_MAX];
  if (argc != 4) return fail("usage: shown 2|3 FILE.h5 SEED");
  w.d = atoi(argv[1]);
  seed = strtoull(argv[3], NULL, 10);
  build(&w);
  if (nsdae_bodies_system(w.bodies, &system) < 0) return fail(nsdae_bodies_error(w.bodies)->text);
  nsdae_bodies_get_start(w.bodies, q, v);
  if (nsdae_sim_create(system, NULL, &sim, &error) < 0) return fail(error.text);
  if (nsdae_sim_project(sim, 0, q, v) < 0 || nsdae_sim_init(sim, 0, q, v) < 0)
    return fail(nsdae_sim_error(sim)->text);
  const nsdae_trajectory_info info = {.model = "shown"};
  if (nsdae_trajectory_create(sim, argv[2], &info, &file, &error) < 0) return fail(error.text);
  nsdae_sim_observe(sim, see, &w);
  int status = nsdae_sim_run(sim, 0.1);
  if (status < 0) return fail(nsdae_sim_error(sim)->text);
  if (w.records != RECORDS) return fail("another number of records");
  nsdae_trajectory_put(file, "/seen", RECORDS * SOLIDS * FRAME * 3, &w.at[0][0][0][0], "m", "",
                       &error);
  if (nsdae_trajectory_close(&file, status, &error) < 0) return fail(error.text);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  nsdae_bodies_destroy(&w.bodies);
  return 0;
}
