/* A heap of balls written with the kit (nsdae/bodies.h: contacts by materials)
 * and by hand (blocks, contacts by list, every pair looked at): whole steps of
 * Moreau's scheme in runs that take turns. Both begin alike and are to come to
 * the same. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <nsdae/nsdae.h>

#include "ratio.h"

#include "../support/random.h"

enum { BALLS = 150, RUNS = 7, STEPS = 150 };

static const double radius = 0.1, mass_of_ball = 1, gravity = 9.81, mu = 0.5, dt = 2e-3;

static uint64_t seed = 5;

static double uniform(double low, double high)
{
  return random_between(&seed, low, high);
}

/* ---- with the kit: these lines are the whole of it */

static int by_kit(nsdae_bodies **bodies, nsdae_system **system, const double (*at)[3])
{
  const double J = 0.4 * mass_of_ball * radius * radius;
  if (nsdae_bodies_create(3, bodies, NULL) < 0) return -1;
  nsdae_bodies_set_gravity(*bodies, (const double[]){0, 0, -gravity});
  nsdae_bodies_add_solid(*bodies, NSDAE_GROUND, &(nsdae_solid){.shape = NSDAE_SHAPE_PLANE});
  for (int i = 0; i < BALLS; i++) {
    nsdae_rigid_body ball = {.mass = mass_of_ball, .inertia = {J, J, J}};
    memcpy(ball.position, at[i], sizeof ball.position);
    nsdae_bodies_add(*bodies, &ball);
    nsdae_bodies_add_solid(
        *bodies, i, &(nsdae_solid){.shape = NSDAE_SHAPE_SPHERE, .radius = radius, .material = 1});
  }
  nsdae_bodies_set_pair(*bodies, 0, 1, mu, 0, 0);
  nsdae_bodies_set_pair(*bodies, 1, 1, mu, 0, 0);
  return nsdae_bodies_system(*bodies, system);
}

/* ---- by hand */

static int mass(double t, const double *q, double *M, void *user)
{
  (void)t;
  (void)q;
  (void)user;
  for (int i = 0; i < BALLS; i++, M += 36)
    for (int j = 0; j < 6; j++)
      M[7 * j] = j < 3 ? mass_of_ball : 0.4 * mass_of_ball * radius * radius;
  return 0;
}

static int force(double t, const double *q, const double *v, double *F, void *user)
{
  (void)t;
  (void)q;
  (void)v;
  (void)user;
  for (int i = 0; i < BALLS; i++) F[6 * i + 2] = -mass_of_ball * gravity;
  return 0;
}

static int kinematics(double t, const double *q, const double *v, double *qdot, void *user)
{
  (void)t;
  (void)user;
  for (int i = 0; i < BALLS; i++) {
    const double *p = q + 7 * i + 3, *w = v + 6 * i + 3;
    double *d = qdot + 7 * i;
    memcpy(d, v + 6 * i, 3 * sizeof *d);
    d[3] = (-p[1] * w[0] - p[2] * w[1] - p[3] * w[2]) / 2;
    d[4] = (p[0] * w[0] + p[2] * w[2] - p[3] * w[1]) / 2;
    d[5] = (p[0] * w[1] + p[3] * w[0] - p[1] * w[2]) / 2;
    d[6] = (p[0] * w[2] + p[1] * w[1] - p[2] * w[0]) / 2;
  }
  return 0;
}

static void cross(const double *a, const double *b, double *c)
{
  for (int i = 0; i < 3; i++)
    c[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
}

/* out := R^T x of the unit quaternion p */
static void turn_back(const double *p, const double *x, double *out)
{
  double u[3], w[3];
  cross(x, p + 1, u); /* x - 2 p0 (p x x) + 2 p x (p x x) */
  cross(p + 1, u, w);
  for (int i = 0; i < 3; i++) out[i] = x[i] + 2 * p[0] * u[i] - 2 * w[i];
}

/* The contact of ball i with ball j (or the floor, j < 0): n towards i. */
static int touch(nsdae_contact_list *list, const double *q, int i, int j, double gap,
                 const double *n)
{
  nsdae_contact c = {.id = (long)i * (BALLS + 1) + j + 1, .block = {i, j}, .gap = gap, .mu = mu};
  double d[3][3], e[3] = {0, 0, 0}, length = 0;
  int least = fabs(n[0]) < fabs(n[1]) ? 0 : 1;
  if (fabs(n[2]) < fabs(n[least])) least = 2;
  e[least] = 1;
  memcpy(d[0], n, sizeof d[0]);
  cross(e, n, d[1]);
  for (int l = 0; l < 3; l++) length += d[1][l] * d[1][l];
  for (int l = 0; l < 3; l++) d[1][l] /= sqrt(length);
  cross(n, d[1], d[2]);
  for (int k = 0; k < 3; k++) {
    double torque[3]; /* of both: arm x d = -radius n x d, and for j (radius n)
                         x (-d) */
    cross(n, d[k], torque);
    for (int l = 0; l < 3; l++) torque[l] *= -radius;
    memcpy(c.direction[0][k], d[k], sizeof d[k]);
    turn_back(q + 7 * i + 3, torque, c.direction[0][k] + 3);
    if (j < 0) continue;
    for (int l = 0; l < 3; l++) c.direction[1][k][l] = -d[k][l];
    turn_back(q + 7 * j + 3, torque, c.direction[1][k] + 3);
  }
  return nsdae_contact_add(list, &c);
}

static int contacts(double t, const double *q, const double *v, double reach,
                    nsdae_contact_list *list, void *user)
{
  const double up[3] = {0, 0, 1};
  (void)t;
  (void)v;
  (void)user;
  for (int i = 0; i < BALLS; i++) {
    const double *x = q + 7 * i;
    if (x[2] - radius <= reach) touch(list, q, i, -1, x[2] - radius, up);
    for (int j = 0; j < i; j++) {
      const double *y = q + 7 * j;
      double n[3] = {x[0] - y[0], x[1] - y[1], x[2] - y[2]}, most = 2 * radius + reach;
      double square = n[0] * n[0] + n[1] * n[1] + n[2] * n[2];
      if (square > most * most) continue;
      double length = sqrt(square);
      for (int l = 0; l < 3; l++) n[l] /= length;
      touch(list, q, i, j, length - 2 * radius, n);
    }
  }
  return 0;
}

static int by_hand(nsdae_system **system)
{
  static int sizes[2][BALLS];
  for (int i = 0; i < BALLS; i++) {
    sizes[0][i] = 7;
    sizes[1][i] = 6;
  }
  const nsdae_dims dims = {.nq = 7 * BALLS, .nv = 6 * BALLS, .nt = 2};
  if (nsdae_system_create(&dims, system, NULL) < 0) return -1;
  nsdae_system_set_blocks(*system, BALLS, sizes[0], sizes[1]);
  nsdae_system_set_mass_blocks(*system, mass);
  nsdae_system_set_force(*system, force);
  nsdae_system_set_kinematics(*system, kinematics);
  return nsdae_system_set_contacts(*system, contacts);
}

/* ---- both */

/* Time of STEPS steps, or -1; q at the end. */
static double run(const nsdae_system *system, const double (*at)[3], double *q)
{
  static double v[6 * BALLS];
  nsdae_sim *sim;
  nsdae_record r;
  nsdae_sim_options options;
  nsdae_sim_options_default(&options);
  options.method = NSDAE_METHOD_MOREAU;
  options.dt = dt;
  for (int i = 0; i < BALLS; i++) {
    memset(q + 7 * i, 0, 7 * sizeof *q);
    memcpy(q + 7 * i, at[i], 3 * sizeof *q);
    q[7 * i + 3] = 1;
  }
  if (nsdae_sim_create(system, &options, &sim, NULL) < 0) return -1;
  double from = ratio_cpu();
  int status = nsdae_sim_init(sim, 0, q, v);
  for (int i = 0; i < STEPS && status >= 0; i++) status = nsdae_sim_step(sim);
  double took = status < 0 ? -1 : ratio_cpu() - from;
  if (status < 0) printf("%s\n", nsdae_sim_error(sim)->text);
  nsdae_sim_get_record(sim, &r);
  memcpy(q, r.q, 7 * BALLS * sizeof *q);
  nsdae_sim_destroy(&sim);
  return took;
}

static int compare(const void *a, const void *b)
{
  const double *x = a, *y = b;
  return (*x > *y) - (*x < *y);
}

int main(void)
{
  static double at[BALLS][3], q[2][7 * BALLS];
  double took[2][RUNS], apart = 0;
  nsdae_bodies *bodies;
  nsdae_system *system[2];
  for (int i = 0; i < BALLS; i++) { /* layers of five by five, a little out of line */
    at[i][0] = 2.2 * radius * (i % 5) + uniform(-0.1, 0.1) * radius;
    at[i][1] = 2.2 * radius * (i / 5 % 5) + uniform(-0.1, 0.1) * radius;
    at[i][2] = radius + 2.05 * radius * (i / 25);
  }
  if (by_kit(&bodies, &system[0], (const double(*)[3])at) < 0 || by_hand(&system[1]) < 0) return 1;
  for (int i = 0; i < RUNS; i++)
    for (int k = 0; k < 2; k++) {
      took[k][i] = run(system[k], (const double(*)[3])at, q[k]);
      if (took[k][i] < 0) return 1;
    }
  for (int i = 0; i < 7 * BALLS; i++) apart = fmax(apart, fabs(q[0][i] - q[1][i]));
  for (int k = 0; k < 2; k++) qsort(took[k], RUNS, sizeof(double), compare);
  printf("%d balls, %d steps of moreau, medians of %d runs that take turns\n", BALLS, STEPS, RUNS);
  printf("  with the kit %.3f ms a step, by hand %.3f: ratio %.3f; coordinates "
         "differ by %.1e at the end\n",
         1e3 * took[0][RUNS / 2] / STEPS, 1e3 * took[1][RUNS / 2] / STEPS,
         took[0][RUNS / 2] / took[1][RUNS / 2], apart);
  for (int k = 0; k < 2; k++) nsdae_system_destroy(&system[k]);
  nsdae_bodies_destroy(&bodies);
  return 0;
}
