/* Large mechanisms through the public calls: chains of revolute links, nets of spherical joints,
 * ladders whose loops have redundant rows. With a contact list (a pair of materials is set, which
 * nothing touches) and without, and as dense systems: the same motion. */
#include "check.h"

#include <float.h>

#include <nsdae/nsdae.h>
#include <stdlib.h>

#include "dense_copy.h"
#include "support/random.h"
#include "support/stiff_chain.h"

typedef struct mechanism {
  nsdae_bodies *bodies;
  nsdae_system *system, *dense;
  nsdae_sim *sim;
  nsdae_error error;
  int bodies_count, joints;
  uint64_t seed;
} mechanism;

static void begin(mechanism *m)
{
  const double gravity[3] = {0, 0, -9.81};
  *m = (mechanism){.seed = 17};
  assert_int_equal(nsdae_bodies_create(3, &m->bodies, NULL), NSDAE_OK);
  assert_int_equal(nsdae_bodies_set_gravity(m->bodies, gravity), NSDAE_OK);
}

/* Of a mass in 1/ratio .. ratio. */
static int add_body(mechanism *m, const double *at, double ratio)
{
  double mass = pow(ratio, random_between(&m->seed, -1, 1));
  const nsdae_rigid_body body = {.mass = mass,
                                 .inertia = {0.01 * mass, 0.02 * mass, 0.025 * mass},
                                 .position = {at[0], at[1], at[2]}};
  assert_true(nsdae_bodies_add(m->bodies, &body) >= 0);
  return m->bodies_count++;
}

/* axis NULL: spherical */
static void add_joint(mechanism *m, int a, int b, const double *point, const double *axis)
{
  nsdae_joint joint = {.kind = axis ? NSDAE_JOINT_REVOLUTE : NSDAE_JOINT_SPHERICAL,
                       .body = {a, b},
                       .point = {point[0], point[1], point[2]}};
  for (int i = 0; axis && i < 3; i++) joint.axis[i] = axis[i];
  assert_true(nsdae_bodies_add_joint(m->bodies, &joint) >= 0);
  m->joints++;
}

/* Links of half a metre: straight, about axes of one direction, or in a spiral, about axes that are
 * drawn. */
static void make_chain(mechanism *m, int links, int straight, double ratio)
{
  double end[3] = {0};
  begin(m);
  for (int i = 0; i < links; i++) {
    const double turned = straight ? 0 : 0.3 * i;
    const double way[3] = {0.25 * cos(turned), 0.25 * sin(turned), straight ? 0 : 0.05};
    double axis[3] = {0, 1, 0}, centre[3];
    for (int k = 0; k < 3 && !straight; k++) axis[k] = random_between(&m->seed, -1, 1);
    for (int k = 0; k < 3; k++) centre[k] = end[k] + way[k];
    int body = add_body(m, centre, ratio);
    add_joint(m, body - 1, body, end, axis); /* -1: the ground */
    for (int k = 0; k < 3; k++) end[k] += 2 * way[k];
  }
}

static void add_near(mechanism *m, int a, int b, double x, double y)
{
  const double at[3] = {x + random_between(&m->seed, -0.1, 0.1),
                        y + random_between(&m->seed, -0.1, 0.1),
                        random_between(&m->seed, -0.1, 0.1)};
  add_joint(m, a, b, at, NULL);
}

/* wide x wide bodies, half a metre apart, hung by a corner; joints about half way, of no symmetry.
 */
static void make_net(mechanism *m, int wide)
{
  begin(m);
  for (int k = 0; k < wide * wide; k++) {
    const double at[3] = {0.5 * (k % wide), 0.5 * (k - k % wide) / wide, 0};
    add_body(m, at, 1);
    if (k == 0) add_joint(m, NSDAE_GROUND, 0, at, NULL);
    if (k % wide > 0) add_near(m, k - 1, k, at[0] - 0.25, at[1]);
    if (k >= wide) add_near(m, k - wide, k, at[0], at[1] - 0.25);
  }
}

/* Parallelograms in the plane of x, z on each other; 3 of the 20 rows of each are redundant. */
static void make_ladder(mechanism *m, int loops)
{
  const double axis[3] = {0, 1, 0}, crank[3] = {0.25, 0, 0.3};
  double floor[3] = {0};
  int below = NSDAE_GROUND;
  begin(m);
  for (int l = 0; l < loops; l++) {
    const double top[3] = {floor[0] + crank[0], 0, floor[2] + crank[2]};
    int on = -1, crank_of[2];
    for (int s = 0; s < 2; s++) {
      double shift = 0.6 * s - 0.3;
      const double at[3] = {floor[0] + crank[0] / 2 + shift, 0, floor[2] + crank[2] / 2};
      crank_of[s] = add_body(m, at, 1);
    }
    on = add_body(m, top, 1);
    for (int s = 0; s < 2; s++) {
      double shift = 0.6 * s - 0.3;
      const double low[3] = {floor[0] + shift, 0, floor[2]}, high[3] = {top[0] + shift, 0, top[2]};
      add_joint(m, below, crank_of[s], low, axis);
      add_joint(m, crank_of[s], on, high, axis);
    }
    memcpy(floor, top, sizeof floor);
    below = on;
  }
}

/* Phi_q and M by blocks, with a contact list too, or dense. */
enum { BY_LIST, BY_BLOCKS, DENSE };

/* Makes the simulation and starts it; its status. */
static int start(mechanism *m, int form, int method, int redundant)
{
  nsdae_sim_options options;
  nsdae_dims dims;
  nsdae_sim_options_default(&options);
  options.method = method;
  options.redundant = redundant;
  options.dt = 1e-3;
  if (form == BY_LIST) assert_int_equal(nsdae_bodies_set_pair(m->bodies, 0, 0, 0, 0, 0), NSDAE_OK);
  assert_true(nsdae_bodies_system(m->bodies, &m->system) >= 0);
  if (form == DENSE) m->dense = dense_copy(m->system);
  nsdae_system *system = form == DENSE ? m->dense : m->system;
  assert_int_equal(nsdae_sim_create(system, &options, &m->sim, &m->error), NSDAE_OK);
  assert_int_equal(nsdae_bodies_get_dims(m->bodies, &dims), NSDAE_OK);
  double *q = calloc((size_t)dims.nq, sizeof *q), *v = calloc((size_t)dims.nv, sizeof *v);
  assert_int_equal(nsdae_bodies_get_start(m->bodies, q, v), NSDAE_OK);
  int status = nsdae_sim_init(m->sim, 0, q, v);
  free(q), free(v);
  return status;
}

static void run(mechanism *m, int steps)
{
  for (int i = 0; i < steps; i++) {
    int status = nsdae_sim_step(m->sim);
    if (status < 0) fail_msg("step %d: %s", i, nsdae_sim_error(m->sim)->text);
  }
}

static nsdae_record record_of(const mechanism *m)
{
  nsdae_record record;
  assert_int_equal(nsdae_sim_get_record(m->sim, &record), NSDAE_OK);
  return record;
}

static void end(mechanism *m)
{
  nsdae_sim_destroy(&m->sim);
  nsdae_system_destroy(&m->dense);
  nsdae_system_destroy(&m->system);
  nsdae_bodies_destroy(&m->bodies);
}

static const int methods[] = {NSDAE_METHOD_MOREAU, NSDAE_METHOD_IMPLICIT, NSDAE_METHOD_EVENT};

enum { METHODS = sizeof methods / sizeof *methods };

/* event takes no contact list. */
static int first_form(int method)
{
  return method == NSDAE_METHOD_EVENT ? BY_BLOCKS : BY_LIST;
}

/* A chain by blocks against the dense one, if asked for. Its energy is kept to the order of the
 * method and its joints are closed. */
static void expect_chain(int links, int straight, double ratio, int method, int steps, int form,
                         int dense)
{
  mechanism sparse, other;
  make_chain(&sparse, links, straight, ratio);
  assert_int_equal(start(&sparse, form, method, NSDAE_REDUNDANT_ERROR), NSDAE_OK);
  run(&sparse, steps);
  nsdae_record r = record_of(&sparse);
  nsdae_stats stats;
  assert_int_equal(nsdae_sim_get_stats(sparse.sim, &stats), NSDAE_OK);
  assert_int_equal(stats.rank, 5 * links);
  assert_int_equal(stats.rank_most, 5 * links);
  assert_true(stats.rank_retained > 1e-4 && stats.rank_retained < 1 && stats.rank_discarded == 0);
  assert_true(r.constraint_drift < 1e-3);
  /* the error of energy is that of dt^2 */
  assert_true(fabs(r.certificate.unexplained) < 1e-3 * r.kinetic);
  if (dense) {
    make_chain(&other, links, straight, ratio);
    assert_int_equal(start(&other, DENSE, method, NSDAE_REDUNDANT_ERROR), NSDAE_OK);
    run(&other, steps);
    nsdae_record s = record_of(&other);
    for (int j = 0; j < 7 * links; j++) assert_near(r.q[j], s.q[j], 1e-11);
    for (int j = 0; j < 6 * links; j++) assert_near(r.v[j], s.v[j], 1e-8);
    end(&other);
  }
  end(&sparse);
}

/* In the quick form the longer chains are straight by list and bent by blocks. */
static void test_chains(void **state)
{
  const int whole = test_share() == 1;
  (void)state;
  for (int i = 0; i < METHODS; i++) {
    for (int form = first_form(methods[i]); form <= BY_BLOCKS; form++) {
      expect_chain(whole ? 40 : 20, 1, 1, methods[i], 20, form, 1);
      expect_chain(whole ? 40 : 20, 0, 1e3, methods[i], 5, form, 1);
      if (whole || form == BY_LIST) expect_chain(200, 1, 1, methods[i], 20, form, 0);
      if (whole || form == BY_BLOCKS) expect_chain(200, 0, 1e3, methods[i], 5, form, 0);
    }
  }
  expect_chain(whole ? 1000 : 400, 0, 1e3, NSDAE_METHOD_EVENT, 2, BY_BLOCKS, 0);
}

static void expect_net(int form, int method)
{
  mechanism m;
  make_net(&m, 20);
  assert_int_equal(start(&m, form, method, NSDAE_REDUNDANT_ERROR), NSDAE_OK);
  run(&m, method == NSDAE_METHOD_EVENT ? 5 : 20);
  nsdae_record r = record_of(&m);
  nsdae_stats stats;
  assert_int_equal(nsdae_sim_get_stats(m.sim, &stats), NSDAE_OK);
  assert_int_equal(stats.rank, 3 * m.joints);
  assert_true(r.constraint_drift < 1e-3);
  assert_true(fabs(r.certificate.unexplained) < 1e-2 * r.kinetic);
  end(&m);
}

static void test_nets(void **state)
{
  (void)state;
  expect_net(BY_LIST, NSDAE_METHOD_MOREAU);
  expect_net(BY_BLOCKS, NSDAE_METHOD_MOREAU);
  expect_net(BY_BLOCKS, NSDAE_METHOD_EVENT);
}

/* 33 loops: refused with the name of a row, or solved with the rank of the mechanism. Couplers of
 * parallelograms do not turn. */
static void expect_ladder(int form, int method)
{
  mechanism m;
  nsdae_stats stats;
  make_ladder(&m, 33);
  int status = start(&m, form, method, NSDAE_REDUNDANT_ERROR);
  const nsdae_error *error = nsdae_sim_error(m.sim);
  if (status == NSDAE_OK) status = nsdae_sim_step(m.sim);
  assert_int_equal(status, NSDAE_E_RANK);
  assert_non_null(strstr(error->text, "rank 561 of 660"));
  assert_non_null(strstr(error->text, "joint"));
  end(&m);
  make_ladder(&m, 33);
  assert_int_equal(start(&m, form, method, NSDAE_REDUNDANT_LEAST_NORM), NSDAE_OK);
  run(&m, 20);
  assert_int_equal(nsdae_sim_get_stats(m.sim, &stats), NSDAE_OK);
  assert_int_equal(stats.rank, 561);
  assert_int_equal(stats.rank_most, 561);
  assert_true(stats.rank_retained > 1e-4 && stats.rank_discarded < 1e-8);
  nsdae_record r = record_of(&m);
  for (int l = 0; l < 33; l++) assert_near(r.v[6 * (3 * l + 2) + 4], 0, 1e-9);
  assert_true(fabs(r.v[0]) > 1e-3); /* it moves */
  end(&m);
}

static void test_ladders(void **state)
{
  (void)state;
  for (int i = 0; i < METHODS; i++)
    for (int form = first_form(methods[i]); form <= BY_BLOCKS; form++)
      expect_ladder(form, methods[i]);
}

/* The first crank rests on the floor by a sphere: the island has a contact with friction, too. */
static void rest_on_floor(mechanism *m)
{
  const nsdae_solid sphere = {.shape = NSDAE_SHAPE_SPHERE, .radius = 0.15, .material = 1};
  const nsdae_solid plane = {.shape = NSDAE_SHAPE_PLANE, .material = 2};
  assert_true(nsdae_bodies_add_solid(m->bodies, 0, &sphere) >= 0);
  assert_true(nsdae_bodies_add_solid(m->bodies, NSDAE_GROUND, &plane) >= 0);
  assert_int_equal(nsdae_bodies_set_pair(m->bodies, 1, 2, 0.3, 0, 0), NSDAE_OK);
}

static void test_ladder_in_contact(void **state)
{
  (void)state;
  mechanism m;
  nsdae_stats stats;
  make_ladder(&m, 33);
  rest_on_floor(&m);
  int status = start(&m, BY_BLOCKS, NSDAE_METHOD_MOREAU, NSDAE_REDUNDANT_ERROR);
  if (status == NSDAE_OK) status = nsdae_sim_step(m.sim);
  assert_int_equal(status, NSDAE_E_RANK);
  assert_non_null(strstr(nsdae_sim_error(m.sim)->text, "rank 561 of 660"));
  end(&m);
  make_ladder(&m, 33);
  rest_on_floor(&m);
  assert_int_equal(start(&m, BY_BLOCKS, NSDAE_METHOD_MOREAU, NSDAE_REDUNDANT_LEAST_NORM), NSDAE_OK);
  run(&m, 3);
  assert_int_equal(nsdae_sim_get_stats(m.sim, &stats), NSDAE_OK);
  assert_true(stats.contact_steps > 0);
  assert_int_equal(stats.rank, 561);
  assert_int_equal(stats.rank_most, 561);
  end(&m);
}

/* ---- all joints, planar and spatial, with springs, a slot with friction and a floor */

enum { PLANAR_KINDS = NSDAE_JOINT_GEAR + 1, ALL_KINDS = NSDAE_JOINT_UNIVERSAL + 1 };

static void add_any_joint(mechanism *m, int dimension, int kind, int a, int b, const double *at)
{
  nsdae_joint j = {.kind = kind, .body = {a, b}, .ratio = 1.5};
  for (int k = 0; k < dimension; k++) {
    j.point[k] = at[k];
    j.end[k] = at[k] + 0.3;
    j.axis[k] = random_between(&m->seed, 0.2, 1);
  }
  if (dimension == 3) j.cross[0] = j.axis[1], j.cross[1] = -j.axis[0];
  if (kind == NSDAE_JOINT_SLOT) j.mu = 0.2;
  assert_true(nsdae_bodies_add_joint(m->bodies, &j) >= 0);
}

/* Bodies in a row, the first on the ground, each on the one before by a joint of this kind (or, if
 * none holds the plane or space, of any other), above a floor that discs or spheres touch. */
static void make_row(mechanism *m, int dimension, int kind, int bodies, uint64_t seed)
{
  const double gravity[3] = {0.5, dimension == 2 ? -9.81 : 0.3, dimension == 2 ? 0 : -9.81};
  const nsdae_solid plane = {.shape = NSDAE_SHAPE_PLANE};
  *m = (mechanism){.seed = seed};
  assert_int_equal(nsdae_bodies_create(dimension, &m->bodies, NULL), NSDAE_OK);
  assert_int_equal(nsdae_bodies_set_gravity(m->bodies, gravity), NSDAE_OK);
  int floor = nsdae_bodies_add_solid(m->bodies, NSDAE_GROUND, &plane);
  assert_true(floor >= 0);
  for (int i = 0; i < bodies; i++) {
    const double r = 0.2, up = r + (i % 3) * 5e-4;
    double at[3] = {0.6 * i, dimension == 2 ? up : 0.1 * i, dimension == 2 ? 0 : up}, joint[3];
    const nsdae_solid round = {.shape = dimension == 2 ? NSDAE_SHAPE_DISC : NSDAE_SHAPE_SPHERE,
                               .radius = r};
    add_body(m, at, 3);
    int solid = nsdae_bodies_add_solid(m->bodies, i, &round);
    if (kind != NSDAE_JOINT_WELD) /* welded bodies have no motion that a contact could change */
      assert_true(nsdae_bodies_add_contact(m->bodies, floor, solid, 0.3, 0.5, 0) >= 0);
    for (int k = 0; k < 3; k++) joint[k] = at[k] - (k == 0 ? 0.3 : 0);
    add_any_joint(m, dimension, kind, i - 1, i, joint);
    const nsdae_spring spring = {.body = {i - 1, i},
                                 .point = {at[0] - 0.9, at[1] + 0.2, at[2]},
                                 .end = {at[0], at[1] - 0.1, at[2]},
                                 .stiffness = 5,
                                 .damping = 0.2,
                                 .rest = 0.7};
    assert_true(nsdae_bodies_add_spring(m->bodies, &spring) >= 0);
  }
}

/* The same motion: to the rounding of its sums, of an integrator to its rtol of 1e-8 times the
 * steps and the stiffness of a contact. A contact whose row depends on those of joints up to a
 * sine s has G = s^2 / m: an impulse is known to eps v / G, a velocity to eps v / s. Below s =
 * sqrt(eps) the row is rounding, so that a time step is known to sqrt(eps) times the root of the
 * roundings that add up along the row, one a velocity, and the next one adds its own.
 * implicit-printed has one, contact 0 of 20 bodies with joint 6 in space: its impulse differs by
 * 7 %. */
static void expect_same_steps(int dimension, int kind, int bodies, int method)
{
  mechanism m[2];
  nsdae_dims dims;
  nsdae_record r[2];
  int integrates = method == NSDAE_METHOD_EVENT || method == NSDAE_METHOD_PENALTY;
  int printed = method == NSDAE_METHOD_IMPLICIT_PRINTED; /* see above */
  double apart = integrates ? 1e-5 : 1e-8, places = integrates ? 1e-7 : 1e-11;
  for (int i = 0; i < 2; i++) {
    make_row(&m[i], dimension, kind, bodies, 40 + (uint64_t)kind);
    assert_int_equal(start(&m[i], i ? DENSE : BY_BLOCKS, method, NSDAE_REDUNDANT_LEAST_NORM),
                     NSDAE_OK);
  }
  assert_int_equal(nsdae_bodies_get_dims(m[0].bodies, &dims), NSDAE_OK);
  for (int n = 0; n < 10; n++) {
    int status[2];
    for (int i = 0; i < 2; i++) {
      status[i] = nsdae_sim_step(m[i].sim);
      r[i] = record_of(&m[i]);
    }
    for (int i = 0; i < 2; i++)
      if (status[i] < 0 && status[1 - i] >= 0)
        fail_msg("joint %d in %d dimensions, %d bodies, step %d: %s", kind, dimension, bodies, n,
                 nsdae_sim_error(m[i].sim)->text);
    if (status[0] < 0) break;
    if (printed) apart = (n + 1) * sqrt(6 * bodies * DBL_EPSILON);
    if (printed) places = 1e-11 + r[0].time * apart;
    for (int j = 0; j < dims.nq; j++) assert_near(r[1].q[j], r[0].q[j], places);
    for (int j = 0; j < dims.nv; j++) assert_near(r[1].v[j], r[0].v[j], apart);
  }
  for (int i = 0; i < 2; i++) end(&m[i]);
}

/* Long rows are sparse: in the quick form each joint by one method, each method with some joints.
 */
static void test_joints(void **state)
{
  (void)state;
  for (int dimension = 2; dimension <= 3; dimension++)
    for (int kind = 0; kind < (dimension == 2 ? PLANAR_KINDS : ALL_KINDS); kind++) {
      if (dimension == 3 && (kind == NSDAE_JOINT_SLOT || kind == NSDAE_JOINT_GEAR)) continue;
      for (int method = NSDAE_METHOD_IMPLICIT; method <= NSDAE_METHOD_EVENT; method++) {
        expect_same_steps(dimension, kind, 2, method);
        if (test_share() == 1 || (kind + method) % 5 == 0)
          expect_same_steps(dimension, kind, test_share() == 1 || dimension == 2 ? 20 : 12, method);
      }
    }
}

/* ---- minimal coordinates */

/* A planar swing of links on spherical joints by event, against that of their angles. Some 100
 * steps have errors of rtol each, and the chain spreads errors by less than 10 in that time. */
static void test_angles(void **state)
{
  enum { LINKS = 30 };
  (void)state;
  for (int n = 2; n <= LINKS; n += 14) {
    stiff_chain chain = {n, 0.01};
    double theta[LINKS], rate[LINKS] = {0}, q[2][7 * LINKS], v[2][6 * LINKS];
    uint64_t seed = (uint64_t)n;
    nsdae_sim_options options;
    nsdae_sim *sim;
    nsdae_system *system = stiff_chain_system(&chain, 0);
    assert_non_null(system);
    for (int i = 0; i < n; i++) theta[i] = random_between(&seed, 0.2, 0.8);
    stiff_chain_place(&chain, theta, rate, q[0], v[0]);
    nsdae_sim_options_default(&options);
    options.method = NSDAE_METHOD_EVENT;
    options.dt = 0.02;
    options.rtol = 1e-9;
    options.atol = 1e-11;
    assert_int_equal(nsdae_sim_create(system, &options, &sim, NULL), NSDAE_OK);
    assert_int_equal(nsdae_sim_init(sim, 0, q[0], v[0]), NSDAE_OK);
    for (int i = 0; i < 5; i++) assert_true(nsdae_sim_step(sim) >= 0);
    nsdae_record r;
    assert_int_equal(nsdae_sim_get_record(sim, &r), NSDAE_OK);
    stiff_chain_swing(&chain, r.time, 2000, theta, rate);
    stiff_chain_place(&chain, theta, rate, q[1], v[1]);
    for (int j = 0; j < 7 * n; j++) assert_near(r.q[j], q[1][j], 1e-6);
    for (int j = 0; j < 6 * n; j++) assert_near(r.v[j], v[1][j], 1e-6 * (1 + fabs(v[1][j])));
    nsdae_sim_destroy(&sim);
    nsdae_system_destroy(&system);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_chains),  cmocka_unit_test(test_nets),
      cmocka_unit_test(test_ladders), cmocka_unit_test(test_ladder_in_contact),
      cmocka_unit_test(test_joints),  cmocka_unit_test(test_angles),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
