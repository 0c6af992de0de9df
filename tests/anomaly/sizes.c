/* What sinks in or drifts is measured by the bodies: a step far too long is a warning, a fine one
 * is none. Random solids of the kit fall on a plane at steps of all lengths, with fixed contacts
 * and by list; the test knows their widths itself. Chains and tops of the kit drift from their
 * joints. */
#include "check.h"

#include <string.h>

#include <nsdae/nsdae.h>

#include "random_system.h"

enum { PENETRATION = 2, DRIFT = 4 };

static double between(uint64_t *state, double low, double high)
{
  return low + (high - low) * random_uniform(state);
}

/* A solid of random shape, and how wide it is: the least distance of two parallel planes. */
static double draw_solid(uint64_t *state, int dimension, nsdae_solid *s, double *point)
{
  static const int planar[] = {NSDAE_SHAPE_DISC, NSDAE_SHAPE_SEGMENT, NSDAE_SHAPE_POLYGON};
  static const int spatial[] = {NSDAE_SHAPE_SPHERE, NSDAE_SHAPE_CAPSULE, NSDAE_SHAPE_BOX};
  double r = pow(10, between(state, -2, 0)), wide = r * between(state, 1, 3);
  memset(s, 0, sizeof *s);
  s->shape = (dimension == 2 ? planar : spatial)[random_below(state, 3)];
  if (s->shape == NSDAE_SHAPE_BOX) {
    for (int i = 0; i < 3; i++) s->length[i] = i == 1 ? r : wide;
    return r;
  }
  if (s->shape == NSDAE_SHAPE_POLYGON) { /* a right triangle: its height over the long edge */
    const double corner[6] = {-r / 3, -wide / 3, 2 * r / 3, -wide / 3, -r / 3, 2 * wide / 3};
    memcpy(point, corner, sizeof corner);
    s->points = 3;
    s->point = point;
    return r * wide / hypot(r, wide);
  }
  s->radius = r;
  if (s->shape == NSDAE_SHAPE_CAPSULE) s->length[2] = wide;
  if (s->shape == NSDAE_SHAPE_SEGMENT) s->length[0] = wide;
  return 2 * r;
}

static nsdae_bodies *thrown(uint64_t *state, int dimension, int by_list, double *width)
{
  double point[6], gravity[3] = {0};
  nsdae_bodies *b;
  nsdae_solid solid, plane = {.shape = NSDAE_SHAPE_PLANE};
  nsdae_rigid_body body = {0};
  assert_int_equal(nsdae_bodies_create(dimension, &b, NULL), NSDAE_OK);
  gravity[dimension - 1] = -9.81;
  nsdae_bodies_set_gravity(b, gravity);
  *width = draw_solid(state, dimension, &solid, point);
  body.mass = 1;
  for (int i = 0; i < 3; i++) body.inertia[i] = 0.2 * *width * *width;
  body.position[dimension - 1] = *width * between(state, 4, 20);
  if (dimension == 2) body.angle = between(state, -3, 3);
  for (int i = 0; i < 4 && dimension == 3; i++) body.quaternion[i] = between(state, -1, 1);
  nsdae_bodies_add(b, &body);
  int floor = nsdae_bodies_add_solid(b, NSDAE_GROUND, &plane),
      it = nsdae_bodies_add_solid(b, 0, &solid);
  double e = between(state, 0, 0.8);
  if (by_list)
    nsdae_bodies_set_pair(b, 0, 0, 0.3, e, 0);
  else
    nsdae_bodies_add_contact(b, floor, it, 0.3, e, 0);
  if (nsdae_bodies_error(b)->status < 0) fail_msg("%s", nsdae_bodies_error(b)->text);
  return b;
}

static nsdae_sim *start(const nsdae_bodies *b, nsdae_system **system, int method, double dt)
{
  double q[7 * 64], v[6 * 64];
  nsdae_sim *sim;
  nsdae_sim_options o;
  nsdae_sim_options_default(&o);
  o.method = method;
  o.dt = dt;
  o.start_check = 0;
  o.projection = NSDAE_PROJECTION_NONE; /* which leaves the drift */
  assert_true(nsdae_bodies_system((nsdae_bodies *)b, system) >= 0);
  assert_int_equal(nsdae_sim_create(*system, &o, &sim, NULL), NSDAE_OK);
  nsdae_bodies_get_start(b, q, v);
  assert_int_equal(nsdae_sim_init(sim, 0, q, v), NSDAE_OK);
  return sim;
}

/* Warned of if and only if it was deeper than a quarter. */
static void test_widths(void **state)
{
  uint64_t random = 5;
  int said = 0, quiet = 0;
  (void)state;
  for (int i = 0; i < 300; i++) {
    double width, deepest = 0, dt = pow(10, between(&random, -4, -0.5));
    int dimension = 2 + random_below(&random, 2), by_list = random_below(&random, 2);
    int warned = 0, deeper = 0;
    int method = random_below(&random, 3);
    nsdae_system *system;
    nsdae_bodies *b = thrown(&random, dimension, by_list, &width);
    nsdae_sim *sim = start(b, &system, method, dt);
    for (int n = 0; n < 200 && nsdae_sim_step(sim) >= 0; n++) {
      nsdae_record r;
      nsdae_stats stats;
      nsdae_sim_get_record(sim, &r);
      nsdae_sim_get_stats(sim, &stats);
      deepest = fmax(deepest, r.penetration);
      warned = (stats.warnings & PENETRATION) != 0;
      /* one warning a step: another may come first */
      deeper = r.penetration > 0.25 * width * (1 + 1e-12) ? deeper + 1 : 0;
      if (warned) assert_true(deepest > 0.25 * width * (1 - 1e-12));
      if (deeper > 1) assert_true(warned);
    }
    said += warned;
    quiet += !warned && deepest > 0;
    nsdae_sim_destroy(&sim);
    nsdae_system_destroy(&system);
    nsdae_bodies_destroy(&b);
  }
  print_message("%d said, %d touch and are not\n", said, quiet);
  assert_true(said > 50 && quiet > 30);
}

/* Links of 10 cm on a pivot, that fall from almost upright, or a top of 0.4 m on its tip. */
static nsdae_bodies *chain(int links)
{
  nsdae_bodies *b;
  assert_int_equal(nsdae_bodies_create(2, &b, NULL), NSDAE_OK);
  nsdae_bodies_set_gravity(b, (const double[]){0, -9.81, 0});
  for (int i = 0; i < links; i++) {
    nsdae_rigid_body body = {.mass = 0.1, .inertia = {0, 0, 1e-4}};
    nsdae_joint joint = {.kind = NSDAE_JOINT_REVOLUTE, .body = {i - 1, i}};
    body.position[0] = joint.point[0] = 1e-3 * i;
    body.position[1] = 0.05 + (joint.point[1] = 0.1 * i);
    nsdae_bodies_add(b, &body);
    assert_true(nsdae_bodies_add_joint(b, &joint) >= 0);
  }
  return b;
}

static nsdae_bodies *top(int spin)
{
  nsdae_bodies *b;
  const double tilt = 0.3;
  nsdae_rigid_body body = {.mass = 1,
                           .inertia = {0.02, 0.02, 0.01},
                           .position = {0.4 * sin(tilt), 0, 0.4 * cos(tilt)},
                           .quaternion = {cos(tilt / 2), 0, sin(tilt / 2), 0},
                           .spin = {0, 0, spin}};
  nsdae_joint tip = {.kind = NSDAE_JOINT_SPHERICAL, .body = {NSDAE_GROUND, 0}};
  assert_int_equal(nsdae_bodies_create(3, &b, NULL), NSDAE_OK);
  nsdae_bodies_set_gravity(b, (const double[]){0, 0, -9.81});
  nsdae_bodies_add(b, &body);
  assert_true(nsdae_bodies_add_joint(b, &tip) >= 0);
  return b;
}

/* Warned of if and only if a joint is off by a tenth of its arm; how many. */
static int drift(nsdae_bodies *b, int method, double dt, double arm, double t_end)
{
  nsdae_system *system;
  nsdae_stats stats;
  nsdae_sim *sim = start(b, &system, method, dt);
  int status = NSDAE_OK;
  for (int n = 0; n * dt < t_end && status >= 0; n++) status = nsdae_sim_step(sim);
  nsdae_sim_get_stats(sim, &stats);
  int warned = (stats.warnings & DRIFT) != 0;
  assert_int_equal(warned, stats.worst_drift > 0.1 * arm);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  nsdae_bodies_destroy(&b);
  return warned;
}

static void test_arms(void **state)
{
  int said = 0;
  (void)state;
  for (int method = 0; method < 3; method++)
    for (double dt = 1e-2; dt > 1e-3; dt /= 3) {
      said += drift(chain(6), method, dt, 0.05, 1);
      for (int spin = 10; spin <= 1000; spin *= 10) said += drift(top(spin), method, dt, 0.4, 1);
    }
  assert_true(said >= 5 && said < 30);
}

/* A point mass that falls on a floor, in coordinates of its own: nothing has a size. */
static int unit_mass(double t, const double *q, double *M, int ldm, void *user)
{
  (void)t, (void)q, (void)ldm, (void)user;
  M[0] = 1;
  return 0;
}

static int weight(double t, const double *q, const double *v, double *F, void *user)
{
  (void)t, (void)q, (void)v, (void)user;
  F[0] = -9.81;
  return 0;
}

static int height(double t, const double *q, double *g, void *user)
{
  (void)t, (void)user;
  g[0] = q[0];
  return 0;
}

/* Its bits after 10 steps, and how deep it was. */
static int fall(int method, double dt, double from, double *deepest)
{
  const nsdae_dims d = {.nq = 1, .k = 1};
  const double at_rest = 0;
  nsdae_system *system;
  nsdae_sim *sim;
  nsdae_sim_options o;
  nsdae_stats stats;
  nsdae_sim_options_default(&o);
  o.method = method;
  o.dt = dt;
  assert_int_equal(nsdae_system_create(&d, &system, NULL), NSDAE_OK);
  nsdae_system_set_mass(system, unit_mass);
  nsdae_system_set_force(system, weight);
  nsdae_system_set_gap(system, height);
  nsdae_system_set_contact(system, 0, 0, 0.5, 0);
  assert_int_equal(nsdae_sim_create(system, &o, &sim, NULL), NSDAE_OK);
  assert_int_equal(nsdae_sim_init(sim, 0, &from, &at_rest), NSDAE_OK);
  assert_true(nsdae_sim_run(sim, 10 * dt) >= 0);
  nsdae_sim_get_stats(sim, &stats);
  *deepest = stats.worst_penetration;
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  return stats.warnings;
}

/* Deeper than it was ever high, if and only if it is warned of; one at rest at the start is not. */
static void test_without_sizes(void **state)
{
  uint64_t random = 17;
  int said = 0;
  double deep;
  (void)state;
  for (int run = 0; run < 300; run++) {
    double from = pow(10, between(&random, -2, 2)), dt = pow(10, between(&random, -3, 1));
    int warned = fall(run % 3, dt, from, &deep) & PENETRATION;
    if (dt * dt * 9.81 < from / 10) assert_false(warned);
    if (deep > 2 * from) assert_true(warned);
    said += warned != 0;
    assert_false(fall(run % 3, dt, 0, &deep) & PENETRATION);
  }
  assert_true(said > 50 && said < 250);
  assert_true(fall(0, 10, 1, &deep) & PENETRATION);
}

/* A ball of the kit falls on a plane at dt 10 s, a disc of 0.1 m at 0.1 s; a chain of 50 links of
 * 10 cm by moreau; a top on its tip, in all of which bodies or joints are far off. */
static void test_far_too_long(void **state)
{
  (void)state;
  for (int disc = 0; disc < 2; disc++) {
    nsdae_bodies *b;
    nsdae_system *system;
    nsdae_stats stats;
    const nsdae_solid plane = {.shape = NSDAE_SHAPE_PLANE},
                      ball = {.shape = disc ? NSDAE_SHAPE_DISC : NSDAE_SHAPE_SPHERE, .radius = 0.1};
    nsdae_rigid_body body = {.mass = 1, .inertia = {0.004, 0.004, 0.004}};
    assert_int_equal(nsdae_bodies_create(3 - disc, &b, NULL), NSDAE_OK);
    nsdae_bodies_set_gravity(b,
                             disc ? (const double[]){0, -9.81, 0} : (const double[]){0, 0, -9.81});
    body.position[2 - disc] = 2;
    nsdae_bodies_add(b, &body);
    nsdae_bodies_add_contact(b, nsdae_bodies_add_solid(b, NSDAE_GROUND, &plane),
                             nsdae_bodies_add_solid(b, 0, &ball), 0.3, 0.5, 0);
    nsdae_sim *sim = start(b, &system, NSDAE_METHOD_IMPLICIT, disc ? 0.1 : 10);
    assert_int_equal(nsdae_sim_run(sim, disc ? 2 : 100), NSDAE_WARN_PENETRATION);
    nsdae_sim_get_stats(sim, &stats);
    assert_true(stats.worst_penetration > (disc ? 0.2 : 40));
    nsdae_sim_destroy(&sim);
    nsdae_system_destroy(&system);
    nsdae_bodies_destroy(&b);
  }
  assert_true(drift(chain(50), NSDAE_METHOD_MOREAU, 1e-3, 0.05, 1));
  assert_true(drift(top(300), NSDAE_METHOD_MOREAU, 1e-2, 0.4, 1));
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_widths), cmocka_unit_test(test_arms),
                                     cmocka_unit_test(test_without_sizes),
                                     cmocka_unit_test(test_far_too_long)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
