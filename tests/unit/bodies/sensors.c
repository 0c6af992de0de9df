/* Sensors against exact values by every method: reactions, contact forces, turns, points, energies;
 * as a part of the state, and what is refused. */
#include "check.h"

#include <nsdae/nsdae.h>

#include "support/hung_bodies.h"
#include "support/random.h"

static const double pi = 3.14159265358979324, g = 10;

static const int methods[] = {NSDAE_METHOD_IMPLICIT, NSDAE_METHOD_IMPLICIT_PRINTED,
                              NSDAE_METHOD_MOREAU, NSDAE_METHOD_PENALTY, NSDAE_METHOD_EVENT};
enum { METHODS = sizeof methods / sizeof *methods };

typedef struct machine {
  nsdae_bodies *bodies;
  nsdae_system *system;
  nsdae_sim *sim;
} machine;

static int add(nsdae_bodies *b, nsdae_sensor sensor)
{
  int number = nsdae_bodies_add_sensor(b, &sensor);
  if (number < 0) fail_msg("%s", nsdae_bodies_error(b)->text);
  return number;
}

static machine start(nsdae_bodies *b, int method, double dt)
{
  machine m = {.bodies = b};
  nsdae_sim_options o;
  double q[NQ_MAX], v[NV_MAX];
  if (nsdae_bodies_system(b, &m.system) < 0) fail_msg("%s", nsdae_bodies_error(b)->text);
  nsdae_bodies_get_start(b, q, v);
  nsdae_sim_options_default(&o);
  o.method = method;
  o.dt = dt;
  o.rtol = 1e-11;
  o.atol = 1e-12;
  o.contact_tol = 1e-12;
  assert_int_equal(nsdae_sim_create(m.system, &o, &m.sim, NULL), NSDAE_OK);
  if (nsdae_sim_init(m.sim, 0, q, v) < 0) fail_msg("%s", nsdae_sim_error(m.sim)->text);
  return m;
}

static void go(const machine *m, double t)
{
  if (nsdae_sim_run(m->sim, t) < 0) fail_msg("%s", nsdae_sim_error(m->sim)->text);
}

static void release(machine *m)
{
  nsdae_sim_destroy(&m->sim);
  nsdae_system_destroy(&m->system);
  nsdae_bodies_destroy(&m->bodies);
}

static const double *read(const machine *m, int sensor)
{
  static double value[NSDAE_VALUES_MAX];
  for (int i = 0; i < NSDAE_VALUES_MAX; i++) value[i] = 0;
  assert_int_equal(nsdae_sim_get_sensor(m->sim, sensor, value), NSDAE_OK);
  return value;
}

static void assert_vector(const machine *m, int sensor, double x, double y, double z, double tol)
{
  const double *value = read(m, sensor);
  assert_near(value[0], x, tol);
  assert_near(value[1], y, tol);
  assert_near(value[2], z, tol);
}

/* ---- reactions */

/* A weld carries 2 kg at the distance 0.3 from its point: the force m g and the moment 0.3 m g. */
static void test_hanging_weight(void **state)
{
  (void)state;
  for (int i = 0; i < METHODS; i++)
    for (int d = 2; d <= 3; d++)
      for (int swap = 0; swap <= 1; swap++) {
        nsdae_bodies *b = create(d, 0, d == 2 ? -g : 0, d == 3 ? -g : 0);
        nsdae_bodies_add(b,
                         &(nsdae_rigid_body){.mass = 2, .inertia = {1, 1, 1}, .position = {0.3}});
        nsdae_joint weld = {.kind = NSDAE_JOINT_WELD, .body = {NSDAE_GROUND, 0}};
        if (swap) weld.body[0] = 0, weld.body[1] = NSDAE_GROUND;
        nsdae_bodies_add_joint(b, &weld);
        int force = add(b, (nsdae_sensor){.kind = NSDAE_SENSOR_REACTION_FORCE});
        int moment = add(b, (nsdae_sensor){.kind = NSDAE_SENSOR_REACTION_MOMENT});
        machine m = start(b, methods[i], 0.01);
        double up = swap ? -2 * g : 2 * g;
        go(&m, 0.5);
        assert_vector(&m, force, 0, d == 2 ? up : 0, d == 3 ? up : 0, 1e-9);
        assert_vector(&m, moment, d == 2 ? 0.3 * up : 0, d == 3 ? -0.3 * up : 0, 0, 1e-9);
        release(&m);
      }
}

/* A pendulum, a point mass at the distance l with J about its centre: the mean reaction of a step
 * is m (v_1 - v_0) / h + m g. Between two records at the times t and t + h. */
static void test_pendulum(void **state)
{
  (void)state;
  for (int i = 0; i < METHODS; i++)
    for (int d = 2; d <= 3; d++) {
      int printed = methods[i] == NSDAE_METHOD_IMPLICIT_PRINTED;
      const double h = 1e-3, mass = 2;
      nsdae_bodies *b = create(d, 0, d == 2 ? -g : 0, d == 3 ? -g : 0);
      nsdae_bodies_add(
          b, &(nsdae_rigid_body){.mass = mass, .inertia = {0.1, 0.1, 0.1}, .position = {0.5}});
      nsdae_bodies_add_joint(b, &(nsdae_joint){.kind = NSDAE_JOINT_REVOLUTE,
                                               .body = {NSDAE_GROUND, 0},
                                               .axis = {0, -1, 0}});
      int force = add(b, (nsdae_sensor){.kind = NSDAE_SENSOR_REACTION_FORCE});
      int moment = add(b, (nsdae_sensor){.kind = NSDAE_SENSOR_REACTION_MOMENT});
      int centre = add(b, (nsdae_sensor){.kind = NSDAE_SENSOR_VELOCITY, .point = {0.5}});
      int kinetic = add(b, (nsdae_sensor){.kind = NSDAE_SENSOR_KINETIC_ENERGY});
      int potential = add(b, (nsdae_sensor){.kind = NSDAE_SENSOR_POTENTIAL_ENERGY});
      machine m = start(b, methods[i], h);
      double before[3];
      nsdae_record r;
      go(&m, 0.3);
      memcpy(before, read(&m, centre), sizeof before);
      assert_int_equal(nsdae_sim_step(m.sim), NSDAE_OK);
      const double *after = read(&m, centre);
      int up = d - 1;
      double mean[3] = {0};
      for (int j = 0; j < d; j++)
        mean[j] = mass * (after[j] - before[j]) / h + (j == up ? mass * g : 0);
      assert_vector(&m, force, mean[0], mean[1], mean[2], printed ? 0.1 : 1e-8);
      assert_vector(&m, moment, 0, 0, 0, 0.1); /* of the step's means at its end: of first order */
      /* ---- the energies of the record, the only body's */
      nsdae_sim_get_record(m.sim, &r);
      assert_near(*read(&m, kinetic), r.kinetic, 1e-13);
      assert_near(*read(&m, potential), r.potential, 1e-13);
      release(&m);
    }
}

/* ---- contacts */

/* A box of 2 kg on a floor, and one of 1 kg on it, smaller or of the same size, pushed by 3 N
 * within friction: by fixed contacts and by list. */
static int push(double t, const double x[3], const double v[3], double force[3], double moment[3],
                void *user)
{
  (void)t, (void)x, (void)v, (void)moment, (void)user;
  force[0] = 3;
  return 0;
}

/* The boxes rest: the forces of each body and their moments about its centre are in balance with
 * weight and push, and act at the corners of a face. */
static void check_corners(const machine *m, double half)
{
  const double expected[2][3] = {{-3, 0, 2 * g}, {0, 0, g}};
  double point[256][3], force[256][3], sum[2][3] = {{0}}, moment[2][3] = {{0}};
  nsdae_record r;
  nsdae_sim_get_record(m->sim, &r);
  assert_true(r.contacts.count <= 256);
  assert_int_equal(nsdae_sim_get_contact_forces(m->sim, *point, *force), NSDAE_OK);
  for (int i = 0; i < r.contacts.count; i++) {
    if (isnan(point[i][0])) {
      assert_true(r.contacts.normal_impulse[i] == 0 && force[i][2] == 0);
      continue;
    }
    int high = point[i][2] > 0.5; /* between the boxes: on box 1 */
    for (int j = 0; j < 2; j++) assert_near(fabs(point[i][j]), high ? half : 0.5, 1e-4);
    assert_near(point[i][2], high, 1e-4);
    for (int k = 0; k <= high; k++) {
      const double *q = r.q + 7 * k, *x = point[i], *f = force[i], sign = high && k == 0 ? -1 : 1;
      const double arm[3] = {x[0] - q[0], x[1] - q[1], x[2] - q[2]};
      for (int j = 0; j < 3; j++) {
        int a = (j + 1) % 3, b = (j + 2) % 3;
        sum[k][j] += sign * f[j];
        moment[k][j] += sign * (arm[a] * f[b] - arm[b] * f[a]);
      }
    }
  }
  for (int k = 0; k < 2; k++)
    for (int j = 0; j < 3; j++) {
      assert_near(sum[k][j], expected[k][j], 1e-7);
      assert_near(moment[k][j], 0, 1e-3);
    }
}

static void test_boxes(void **state)
{
  (void)state;
  for (int i = 0; i < METHODS; i++)
    for (int kind = 0; kind < 4; kind++) {
      int list = kind % 2;
      double less = kind < 2 ? 0.2 : 0;
      if (methods[i] == NSDAE_METHOD_PENALTY) continue; /* it has no stick */
      nsdae_bodies *b = create(3, 0, 0, -g);
      const double centre[3] = {0, 0, 0.5};
      int floor =
              nsdae_bodies_add_solid(b, NSDAE_GROUND, &(nsdae_solid){.shape = NSDAE_SHAPE_PLANE}),
          box[2];
      for (int k = 0; k < 2; k++) {
        nsdae_bodies_add(b, &(nsdae_rigid_body){.mass = 2 - k,
                                                .inertia = {1, 1, 1},
                                                .position = {0, 0, k ? 1.5 - less / 2 : 0.5}});
        box[k] = nsdae_bodies_add_solid(
            b, k,
            &(nsdae_solid){.shape = NSDAE_SHAPE_BOX,
                           .length = {1 - less * k, 1 - less * k, 1 - less * k}});
      }
      nsdae_bodies_add_load(b, 0, centre, push, NULL);
      if (list) {
        nsdae_bodies_set_pair(b, 0, 0, 0.5, 0, 0);
      } else {
        nsdae_bodies_add_contact(b, floor, box[0], 0.5, 0, 0);
        nsdae_bodies_add_contact(b, box[0], box[1], 0.5, 0, 0);
      }
      int low = add(b, (nsdae_sensor){.kind = NSDAE_SENSOR_CONTACT_FORCE});
      int high = add(b, (nsdae_sensor){.kind = NSDAE_SENSOR_CONTACT_FORCE, .body = 1});
      int from_floor =
          add(b, (nsdae_sensor){.kind = NSDAE_SENSOR_PAIR_FORCE, .solid = {floor, box[0]}});
      int on_floor =
          add(b, (nsdae_sensor){.kind = NSDAE_SENSOR_PAIR_FORCE, .solid = {box[0], floor}});
      int none = add(b, (nsdae_sensor){.kind = NSDAE_SENSOR_PAIR_FORCE, .solid = {box[1], floor}});
      machine m = start(b, methods[i], 0.01);
      assert_vector(&m, low, 0, 0, 0, 0); /* at the start */
      go(&m, 0.5);
      assert_vector(&m, low, -3, 0, 2 * g, 1e-7);
      assert_vector(&m, high, 0, 0, g, 1e-7);
      assert_vector(&m, from_floor, -3, 0, 3 * g, 1e-7);
      assert_vector(&m, on_floor, 3, 0, -3 * g, 1e-7);
      assert_vector(&m, none, 0, 0, 0, 0);
      check_corners(&m, (1 - less) / 2);
      release(&m);
    }
}

/* The force of a step is that of the momentum, m (v_1 - v_0) / h + m g: of a ball that bounces off
 * a floor, and of boxes that tumble on each other, to rounding in each step. */
static void test_momentum(void **state)
{
  enum { BODIES = 4, STEPS = 700 };
  const double side[3] = {0.3, 0.4, 0.5}, h = 1e-3;
  (void)state;
  for (int kind = 0; kind < 8; kind++) {
    int list = kind % 2, box = kind / 2 % 2, method = kind < 4 ? 0 : 2, solid[BODIES + 1];
    uint64_t seed = 7;
    double mass = 0, worst = 0, before[BODIES][3];
    nsdae_bodies *b = create(3, 0, 0, -g);
    nsdae_record r;
    solid[BODIES] =
        nsdae_bodies_add_solid(b, NSDAE_GROUND, &(nsdae_solid){.shape = NSDAE_SHAPE_PLANE});
    for (int i = 0; i < BODIES; i++) {
      nsdae_rigid_body body = {.position = {box ? 0 : i, 0, 0.6 + i}};
      nsdae_solid of = {.shape = box ? NSDAE_SHAPE_BOX : NSDAE_SHAPE_SPHERE, .radius = 0.2 * !box};
      for (int j = 0; j < 4; j++) body.quaternion[j] = random_between(&seed, -1, 1);
      for (int j = 0; j < 3 && box; j++) of.length[j] = side[j];
      nsdae_solid_inertia(&of, 20, &body.mass, body.inertia, NULL);
      mass = body.mass;
      nsdae_bodies_add(b, &body);
      solid[i] = nsdae_bodies_add_solid(b, i, &of);
      for (int j = 0; j < i && !list; j++)
        nsdae_bodies_add_contact(b, solid[i], solid[j], 0.5, 0.5, 0);
      if (!list) nsdae_bodies_add_contact(b, solid[BODIES], solid[i], 0.5, 0.5, 0);
      add(b, (nsdae_sensor){.kind = NSDAE_SENSOR_CONTACT_FORCE, .body = i});
    }
    if (list) nsdae_bodies_set_pair(b, 0, 0, 0.5, 0.5, 0);
    machine m = start(b, methods[method], h);
    for (int k = 0; k < STEPS; k++) {
      nsdae_sim_get_record(m.sim, &r);
      for (int i = 0; i < BODIES; i++) memcpy(before[i], r.v + 6 * i, sizeof before[i]);
      assert_true(nsdae_sim_step(m.sim) >= 0);
      nsdae_sim_get_record(m.sim, &r);
      for (int i = 0; i < BODIES; i++)
        for (int j = 0; j < 3; j++) {
          double force = mass * (r.v[6 * i + j] - before[i][j]) / h + (j == 2 ? mass * g : 0);
          double error = fabs(read(&m, i)[j] - force);
          worst = fmax(worst, error / (mass * g));
        }
    }
    assert_at_most(worst, 1e-8);
    release(&m);
  }
}

/* Discs of the plane bounce with spin on a floor, two of them against each other: in each step the
 * forces of a disc are m (v_1 - v_0) / h + m g, and their moments J (w_1 - w_0) / h. Contacts of
 * two discs turn in a step. */
static void test_spin(void **state)
{
  enum { DISCS = 4, STEPS = 600 };
  const double h = 1e-3, radius = 0.2;
  uint64_t seed = 3;
  (void)state;
  for (int kind = 0; kind < 4; kind++) {
    int method = kind < 2 ? 0 : 2, list = kind % 2, hits = 0;
    nsdae_bodies *b = create(2, 0, -g, 0);
    nsdae_rigid_body body[DISCS];
    double before[3 * DISCS], point[16][3], force[16][3];
    nsdae_record r;
    int floor = nsdae_bodies_add_solid(b, NSDAE_GROUND, &(nsdae_solid){.shape = NSDAE_SHAPE_PLANE});
    for (int i = 0; i < DISCS; i++) {
      nsdae_solid disc = {.shape = NSDAE_SHAPE_DISC, .radius = radius};
      body[i] =
          (nsdae_rigid_body){.position = {i, 0.4}, .spin = {0, 0, random_between(&seed, -20, 20)}};
      body[i].velocity[0] = i == 0 ? 1.5 : i == 1 ? -1.5 : 0;
      nsdae_solid_inertia(&disc, 20, &body[i].mass, body[i].inertia, NULL);
      nsdae_bodies_add(b, &body[i]);
      int solid = nsdae_bodies_add_solid(b, i, &disc);
      if (!list) nsdae_bodies_add_contact(b, floor, solid, 0.5, 0.5, 0);
    }
    if (!list) nsdae_bodies_add_contact(b, 2, 1, 0.5, 0.5, 0); /* discs 1 and 0 */
    if (list) nsdae_bodies_set_pair(b, 0, 0, 0.5, 0.5, 0);
    machine m = start(b, methods[method], h);
    for (int k = 0; k < STEPS; k++) {
      double pushed[DISCS][3] = {{0}};
      nsdae_sim_get_record(m.sim, &r);
      memcpy(before, r.v, sizeof before);
      assert_true(nsdae_sim_step(m.sim) >= 0);
      nsdae_sim_get_record(m.sim, &r);
      assert_int_equal(nsdae_sim_get_contact_forces(m.sim, *point, *force), NSDAE_OK);
      int meet[DISCS] = {0};
      for (int c = 0; c < r.contacts.count; c++) {
        if (isnan(point[c][0])) continue;
        const int *block = r.contacts.block + 2 * c;
        int pair = list ? block[0] >= 0 && block[1] >= 0 : c == DISCS;
        int on = list ? (block[0] > block[1] ? block[0] : block[1]) : pair ? 1 : c;
        assert_true(point[c][2] == 0 && force[c][2] == 0);
        for (int other = 0; other <= pair; other++) {
          int i = !other ? on : list ? (block[0] < block[1] ? block[0] : block[1]) : 0;
          double sign = other ? -1 : 1, x = point[c][0] - r.q[3 * i],
                 y = point[c][1] - r.q[3 * i + 1];
          double arm = hypot(x, y) / radius; /* 1 - half of the penetration, which has no moment */
          assert_near(arm, 1, 10 * h / 2 / radius); /* below 10 m/s */
          meet[i] |= pair;
          pushed[i][0] += sign * force[c][0];
          pushed[i][1] += sign * force[c][1];
          pushed[i][2] += sign * (x * force[c][1] - y * force[c][0]) / arm;
        }
      }
      for (int i = 0; i < DISCS; i++) {
        double scale = body[i].mass / h * (meet[i] ? 0.02 : 1e-5);
        hits += pushed[i][2] != 0;
        for (int j = 0; j < 2; j++)
          assert_near(pushed[i][j],
                      body[i].mass * ((r.v[3 * i + j] - before[3 * i + j]) / h + j * g), scale);
        assert_near(pushed[i][2], body[i].inertia[2] * (r.v[3 * i + 2] - before[3 * i + 2]) / h,
                    scale * radius);
      }
    }
    assert_true(hits > 10);
    release(&m);
  }
}

/* A disc of the plane in a corner at 45 degrees: each side carries m g / sqrt 2. */
static void test_corner(void **state)
{
  (void)state;
  for (int i = 0; i < METHODS; i++) {
    nsdae_bodies *b = create(2, 0, -g, 0);
    int side[2], penalty = methods[i] == NSDAE_METHOD_PENALTY;
    nsdae_bodies_add(
        b, &(nsdae_rigid_body){.mass = 2, .inertia = {0, 0, 1}, .position = {0, sqrt(2)}});
    for (int k = 0; k < 2; k++)
      side[k] = nsdae_bodies_add_solid(
          b, NSDAE_GROUND,
          &(nsdae_solid){.shape = NSDAE_SHAPE_PLANE, .angle = k ? pi / 4 : -pi / 4});
    int disc = nsdae_bodies_add_solid(b, 0, &(nsdae_solid){.shape = NSDAE_SHAPE_DISC, .radius = 1});
    for (int k = 0; k < 2; k++) nsdae_bodies_add_contact(b, disc, side[k], 0, 0.5, 0);
    int all = add(b, (nsdae_sensor){.kind = NSDAE_SENSOR_CONTACT_FORCE});
    int left = add(b, (nsdae_sensor){.kind = NSDAE_SENSOR_PAIR_FORCE, .solid = {side[0], disc}});
    machine m = start(b, methods[i], 0.01);
    go(&m, penalty ? 5 : 0.5);
    assert_vector(&m, all, 0, 2 * g, 0, penalty ? 0.5 : 1e-8);
    assert_vector(&m, left, g, g, 0, penalty ? 0.5 : 1e-8);
    release(&m);
  }
}

/* ---- turns */

/* A wheel of 7 rad/s and a torque of 0.5 about its axis, over more than ten turns; in space, too,
 * and from a state on; steps of event of up to two turns. */
static void test_turns(void **state)
{
  (void)state;
  for (int i = 0; i < METHODS; i++)
    for (int d = 2; d <= 3; d++) {
      int event = methods[i] >= NSDAE_METHOD_PENALTY && methods[i] != NSDAE_METHOD_MOREAU;
      const double t = 12, w = 7, a = 0.5 / 0.5, angle = w * t + a * t * t / 2;
      nsdae_bodies *b = create(d, 0, 0, 0), *c = create(d, 0, 0, 0);
      machine m[2];
      size_t size;
      for (int k = 0; k < 2; k++) {
        nsdae_bodies *of = k ? c : b;
        hang(of, d, NSDAE_JOINT_REVOLUTE, (nsdae_rigid_body){.spin = {0, 0, w}});
        nsdae_bodies_add_motor(of, &(nsdae_motor){.target = 0.5, .limit = INFINITY});
        add(of, (nsdae_sensor){.name = "angle", .kind = NSDAE_SENSOR_COORDINATE});
        add(of, (nsdae_sensor){.name = "rate", .kind = NSDAE_SENSOR_RATE});
        m[k] = start(of, methods[i], event ? 1.0 : 0.01);
      }
      assert_near(*read(&m[0], 0), 0, 1e-14);
      go(&m[0], 5);
      assert_int_equal(nsdae_sim_state_size(m[0].sim, &size), NSDAE_OK);
      char *block = malloc(size), *other = malloc(size);
      assert_true(block && other);
      assert_int_equal(nsdae_sim_get_state(m[0].sim, block, size), NSDAE_OK);
      assert_int_equal(nsdae_sim_set_state(m[1].sim, block, size), NSDAE_OK);
      for (int k = 0; k < 2; k++) {
        go(&m[k], t);
        assert_near(*read(&m[k], 0), angle, event ? 1e-8 : 0.1);
        assert_near(*read(&m[k], 1), w + a * t, event ? 1e-8 : 0.02);
      }
      assert_int_equal(nsdae_sim_get_state(m[0].sim, block, size), NSDAE_OK);
      assert_int_equal(nsdae_sim_get_state(m[1].sim, other, size), NSDAE_OK);
      assert_memory_equal(block, other, size);
      free(block), free(other);
      for (int k = 0; k < 2; k++) release(&m[k]);
    }
}

/* ---- points */

/* A body that turns about z with 3 rad/s, and its point at the distance 2: x = 2 (cos, sin), x' and
 * x'' of it; and a free body that spins with a thrust: w^2 r + F / m. */
static void test_points(void **state)
{
  (void)state;
  for (int i = 0; i < METHODS; i++)
    for (int d = 2; d <= 3; d++) {
      const double w = 3, t = 0.7, c = cos(w * t), s = sin(w * t);
      nsdae_bodies *b = create(d, 0.25, 0, 0);
      nsdae_bodies_add(b, &(nsdae_rigid_body){.mass = 2, .inertia = {1, 1, 1}, .spin = {0, 0, w}});
      int place = add(b, (nsdae_sensor){.kind = NSDAE_SENSOR_POSITION, .point = {2}});
      int velocity = add(b, (nsdae_sensor){.kind = NSDAE_SENSOR_VELOCITY, .point = {2}});
      int acceleration = add(b, (nsdae_sensor){.kind = NSDAE_SENSOR_ACCELERATION, .point = {2}});
      int turned = add(b, (nsdae_sensor){.kind = NSDAE_SENSOR_ORIENTATION});
      int spin = add(b, (nsdae_sensor){.kind = NSDAE_SENSOR_ANGULAR_VELOCITY});
      machine m = start(b, methods[i], 1e-3);
      double tol =
          methods[i] == NSDAE_METHOD_EVENT || methods[i] == NSDAE_METHOD_PENALTY ? 1e-8 : 2e-2;
      go(&m, t);
      assert_vector(&m, place, 2 * c + 0.125 * t * t, 2 * s, 0, tol);
      assert_vector(&m, velocity, -2 * w * s + 0.25 * t, 2 * w * c, 0, tol);
      assert_vector(&m, acceleration, -2 * w * w * c + 0.25, -2 * w * w * s, 0, 10 * tol);
      const double *value = read(&m, turned);
      assert_near(d == 2 ? value[0] : value[0] * value[0] - value[3] * value[3], d == 2 ? w * t : c,
                  tol);
      assert_near(read(&m, spin)[d == 2 ? 0 : 2], w, 1e-9);
      assert_int_equal(nsdae_system_sensor_size(m.system, turned), d == 2 ? 1 : 4);
      assert_int_equal(nsdae_system_sensor_size(m.system, spin), d == 2 ? 1 : 3);
      assert_int_equal(nsdae_system_sensor_size(m.system, place), d);
      assert_int_equal(nsdae_system_sensor_size(m.system, 5), 0);
      release(&m);
    }
}

/* A body that spins freely about axes that are not principal: T is constant, and the sum of the
 * bodies that of all. */
static void test_energies(void **state)
{
  (void)state;
  nsdae_bodies *b = create(3, 0, 0, -g);
  nsdae_bodies_add(
      b, &(nsdae_rigid_body){
             .mass = 2, .inertia = {1, 2, 2.5}, .product = {0.1, -0.2, 0.3}, .spin = {1, 2, 3}});
  nsdae_bodies_add(b, &(nsdae_rigid_body){
                          .mass = 3, .inertia = {1, 1, 1}, .velocity = {0, 0, 5}, .position = {1}});
  for (int k = 0; k < 4; k++)
    add(b,
        (nsdae_sensor){.kind = k % 2 ? NSDAE_SENSOR_POTENTIAL_ENERGY : NSDAE_SENSOR_KINETIC_ENERGY,
                       .body = k / 2});
  machine m = start(b, NSDAE_METHOD_EVENT, 0.05);
  nsdae_record r;
  const double t = 0.4;
  go(&m, t);
  nsdae_sim_get_record(m.sim, &r);
  double value[4];
  for (int k = 0; k < 4; k++) value[k] = *read(&m, k);
  assert_near(value[0], (1 + 2 * 4 + 2.5 * 9) / 2 + 0.1 * 2 - 0.2 * 3 + 0.3 * 6 + g * g * t * t,
              1e-8);
  assert_near(value[1], -2 * g * g * t * t / 2, 1e-9);
  assert_near(value[2] + value[3], 3 * 25 / 2.0, 1e-8);
  assert_near(value[0] + value[2], r.kinetic, 1e-11);
  assert_near(value[1] + value[3], r.potential, 1e-11);
  release(&m);
}

/* A point mass hangs on a rope of 1 m: a contact without a point. */
static void test_no_point(void **state)
{
  (void)state;
  double point[3], force[3];
  nsdae_bodies *b = create(2, 0, -g, 0);
  nsdae_record r;
  nsdae_bodies_add(b, &(nsdae_rigid_body){.mass = 1, .inertia = {0, 0, 1}, .position = {0, -1}});
  nsdae_bodies_add_rope(b, &(nsdae_rope){.body = {NSDAE_GROUND, 0}, .end = {0, -1}, .length = 1});
  machine m = start(b, NSDAE_METHOD_IMPLICIT, 0.01);
  go(&m, 0.1);
  nsdae_sim_get_record(m.sim, &r);
  assert_near(r.contacts.normal_impulse[0], 0.01 * g, 1e-9);
  assert_int_equal(nsdae_sim_get_contact_forces(m.sim, point, force), NSDAE_OK);
  for (int j = 0; j < 3; j++) assert_true(isnan(point[j]) && force[j] == 0);
  assert_int_equal(nsdae_sim_get_contact_forces(m.sim, NULL, force), NSDAE_E_ARGUMENT);
  assert_string_equal(nsdae_sim_error(m.sim)->text, "point is NULL");
  assert_int_equal(nsdae_sim_get_contact_forces(m.sim, point, NULL), NSDAE_E_ARGUMENT);
  assert_string_equal(nsdae_sim_error(m.sim)->text, "force is NULL");
  release(&m);
}

/* ---- names and errors */

static void refuse(nsdae_sensor sensor, const char *words)
{
  nsdae_bodies *b = create(2, 0, 0, 0);
  hang(b, 2, NSDAE_JOINT_WELD, (nsdae_rigid_body){.mass = 1});
  for (int k = 0; k < 2; k++)
    nsdae_bodies_add_solid(b, 0, &(nsdae_solid){.shape = NSDAE_SHAPE_DISC, .radius = 1});
  add(b, (nsdae_sensor){.name = "first", .kind = NSDAE_SENSOR_POSITION});
  assert_true(nsdae_bodies_add_sensor(b, &sensor) < 0);
  if (!strstr(nsdae_bodies_error(b)->text, words)) fail_msg("%s", nsdae_bodies_error(b)->text);
  nsdae_bodies_destroy(&b);
}

static void test_refused(void **state)
{
  (void)state;
  char name[NSDAE_NAME_SIZE + 1];
  memset(name, 'x', NSDAE_NAME_SIZE);
  name[NSDAE_NAME_SIZE] = '\0';
  refuse((nsdae_sensor){.kind = 99}, "sensor 1: kind = 99 is not one of enum nsdae_sensor_kind");
  refuse((nsdae_sensor){.kind = -1}, "sensor 1: kind = -1");
  refuse((nsdae_sensor){.kind = NSDAE_SENSOR_POSITION, .body = 1},
         "sensor 1: body = 1 is outside its range: there are 1");
  refuse((nsdae_sensor){.kind = NSDAE_SENSOR_POSITION, .body = -1}, "sensor 1: body = -1");
  refuse((nsdae_sensor){.kind = NSDAE_SENSOR_REACTION_FORCE, .joint = 1},
         "sensor 1: joint = 1 is outside");
  refuse((nsdae_sensor){.kind = NSDAE_SENSOR_PAIR_FORCE, .solid = {0, 2}},
         "sensor 1: solid = 2 is outside");
  refuse((nsdae_sensor){.kind = NSDAE_SENSOR_PAIR_FORCE, .solid = {0, 1}},
         "belong to the same body");
  refuse((nsdae_sensor){.kind = NSDAE_SENSOR_RATE}, "sensor 1:");
  refuse((nsdae_sensor){.kind = NSDAE_SENSOR_POSITION, .point = {NAN}}, "sensor 1: point[0] = nan");
  refuse((nsdae_sensor){.kind = NSDAE_SENSOR_POSITION, .point = {0, 0, 1}}, "outside of the plane");
  refuse((nsdae_sensor){.kind = NSDAE_SENSOR_POSITION, .name = "first"},
         "name 'first' is that of sensor 0");
  refuse((nsdae_sensor){.kind = NSDAE_SENSOR_POSITION, .name = "a/b"}, "name 'a/b' has a /");
  refuse((nsdae_sensor){.kind = NSDAE_SENSOR_POSITION, .name = name}, "is too long");
}

static void test_names(void **state)
{
  (void)state;
  nsdae_bodies *b = create(2, 0, 0, 0);
  nsdae_sim *none = NULL;
  double value[NSDAE_VALUES_MAX];
  hang(b, 2, NSDAE_JOINT_REVOLUTE, (nsdae_rigid_body){.mass = 1});
  add(b, (nsdae_sensor){.name = "turned", .kind = NSDAE_SENSOR_COORDINATE});
  add(b, (nsdae_sensor){.kind = NSDAE_SENSOR_RATE});
  add(b, (nsdae_sensor){.name = "rate", .kind = NSDAE_SENSOR_RATE});
  add(b, (nsdae_sensor){.name = "theta", .kind = NSDAE_SENSOR_ORIENTATION});
  machine m = start(b, NSDAE_METHOD_IMPLICIT, 0.01);
  assert_string_equal(nsdae_system_get_name(m.system, NSDAE_NAME_SENSOR, 0), "turned");
  assert_string_equal(nsdae_system_get_unit(m.system, NSDAE_NAME_SENSOR, 0), "rad");
  assert_string_equal(nsdae_system_get_name(m.system, NSDAE_NAME_SENSOR, 1), "");
  assert_string_equal(nsdae_system_get_unit(m.system, NSDAE_NAME_SENSOR, 2), "rad/s");
  assert_string_equal(nsdae_system_get_unit(m.system, NSDAE_NAME_SENSOR, 3), "rad");
  assert_int_equal(nsdae_sim_get_sensor(m.sim, 4, value), NSDAE_E_ARGUMENT);
  assert_string_equal(nsdae_sim_error(m.sim)->text,
                      "i = 4 is outside its range: there are 4 sensors");
  assert_int_equal(nsdae_sim_get_sensor(m.sim, -1, value), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_sim_get_sensor(m.sim, 0, NULL), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_sim_get_sensor(none, 0, value), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_sim_create(m.system, NULL, &none, NULL), NSDAE_OK);
  assert_int_equal(nsdae_sim_get_sensor(none, 0, value), NSDAE_E_STATE);
  assert_int_equal(nsdae_sim_get_contact_forces(none, value, value), NSDAE_E_STATE);
  assert_int_equal(nsdae_sim_get_contact_forces(m.sim, NULL, NULL), NSDAE_OK); /* no contacts */
  nsdae_sim_destroy(&none);
  release(&m);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_hanging_weight), cmocka_unit_test(test_pendulum),
      cmocka_unit_test(test_boxes),          cmocka_unit_test(test_momentum),
      cmocka_unit_test(test_spin),           cmocka_unit_test(test_no_point),
      cmocka_unit_test(test_corner),         cmocka_unit_test(test_turns),
      cmocka_unit_test(test_points),         cmocka_unit_test(test_energies),
      cmocka_unit_test(test_refused),        cmocka_unit_test(test_names)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
