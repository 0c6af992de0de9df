/* Mechanisms whose rows depend on each other only where their constraints hold: loops of Bennett
 * and Sarrus, spherical and planar four-bars of revolute joints in space, pairs of joints on one
 * axis. A time-stepping method looks at them beside that place, and the axes are off by a little.
 * Each has to move as by method event, which stays on the constraints: a row that became
 * independent by drift would stop it in the air. */
#include "check.h"

#include <nsdae/nsdae.h>
#include <stdlib.h>

#include "support/random.h"

static double length3(const double *x)
{
  return sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]);
}

enum { NQ_MAX = 7 * 8, LOOP = 4 };

enum kind { BENNETT, SPHERICAL, PLANAR, SARRUS, HINGES, SLIDING, BALLS, SCREWS, LONG, KINDS };

static const char *const names[KINDS] = {
    "Bennett",       "spherical four-bar", "planar four-bar",
    "Sarrus",        "two revolutes",      "revolute and cylindrical",
    "two spherical", "two screws",         "eight double hinges"};

/* How far points and axes are off, by seed. */
enum { OFFS = 7 };

static const double offs[OFFS] = {0, 1e-12, 1e-10, 1e-9, 1e-8, 1e-7, 1e-6};

typedef struct mechanism {
  nsdae_bodies *bodies;
  uint64_t seed;
  double off; /* of points and axes */
  int once;   /* of two joints on one axis the first alone */
  int count;  /* bodies */
} mechanism;

static int add_body(mechanism *m, const double *from, const double *to)
{
  double mass = random_between(&m->seed, 0.5, 2);
  nsdae_rigid_body body = {.mass = mass};
  for (int i = 0; i < 3; i++) {
    body.position[i] = (from[i] + to[i]) / 2;
    body.inertia[i] = mass * random_between(&m->seed, 0.03, 0.05);
  }
  assert_true(nsdae_bodies_add(m->bodies, &body) >= 0);
  return m->count++;
}

/* Draws the same numbers if it is left out. */
static void join(mechanism *m, int out, int kind, int a, int b, const double *point,
                 const double *axis)
{
  nsdae_joint joint = {.kind = kind, .body = {a, b}, .ratio = kind == NSDAE_JOINT_SCREW ? 0.05 : 0};
  double away = m->off * (1 + length3(point));
  for (int i = 0; i < 3; i++) joint.point[i] = point[i] + away * random_between(&m->seed, -1, 1);
  for (int i = 0; i < 3 && kind != NSDAE_JOINT_SPHERICAL; i++)
    joint.axis[i] = axis[i] + m->off * random_between(&m->seed, -1, 1);
  if (!out) assert_true(nsdae_bodies_add_joint(m->bodies, &joint) >= 0);
}

/* Ground, links from each point to the next but the last, ground. */
static void make_loop(mechanism *m, double point[LOOP][3], double axis[LOOP][3])
{
  int last = NSDAE_GROUND;
  for (int i = 0; i < LOOP; i++) {
    int next = i < LOOP - 1 ? add_body(m, point[i], point[i + 1]) : NSDAE_GROUND;
    join(m, 0, NSDAE_JOINT_REVOLUTE, last, next, point[i], axis[i]);
    last = next;
  }
}

/* frame := frame Rot_z(turn) Trans_z(0) Trans_x(length) Rot_x(twist), columns x, y, z, origin */
static void denavit(double frame[4][3], double turn, double twist, double length)
{
  double x[3], y[3];
  for (int i = 0; i < 3; i++) {
    x[i] = cos(turn) * frame[0][i] + sin(turn) * frame[1][i];
    y[i] = cos(turn) * frame[1][i] - sin(turn) * frame[0][i];
  }
  for (int i = 0; i < 3; i++) {
    double z = frame[2][i];
    frame[3][i] += length * x[i];
    frame[0][i] = x[i];
    frame[1][i] = cos(twist) * y[i] + sin(twist) * z;
    frame[2][i] = cos(twist) * z - sin(twist) * y[i];
  }
}

/* sin a / A = sin b / B, and tan(t_1 / 2) tan(t_2 / 2) is a constant (G. T. Bennett, Engineering
 * 76, 1903); t_3 = -t_1, t_4 = -t_2. */
static void make_bennett(mechanism *m)
{
  double alpha = random_between(&m->seed, 0.4, 0.8), beta = random_between(&m->seed, 1, 1.4);
  double length[2] = {0.5, 0.5 * sin(beta) / sin(alpha)}, twist[2] = {alpha, beta};
  double turn[2] = {random_between(&m->seed, 0.9, 1.6), 0};
  turn[1] = 2 * atan(sin((alpha + beta) / 2) / sin((beta - alpha) / 2) / tan(turn[0] / 2));
  double frame[4][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0}}, point[LOOP][3], axis[LOOP][3];
  for (int i = 0; i < LOOP; i++) {
    for (int k = 0; k < 3; k++) point[i][k] = frame[3][k], axis[i][k] = frame[2][k];
    denavit(frame, i < 2 ? turn[i] : -turn[i - 2], twist[i % 2], length[i % 2]);
  }
  for (int k = 0; k < 3; k++) assert_near(frame[3][k], 0, 1e-14); /* it is closed */
  make_loop(m, point, axis);
}

static void make_four_bar(mechanism *m, int spherical)
{
  double point[LOOP][3], axis[LOOP][3];
  const double planar[LOOP][3] = {{0, 0, 0}, {0.3, 0, 0.5}, {1.1, 0, 0.6}, {1, 0, -0.2}};
  for (int i = 0; i < LOOP; i++) {
    double polar = random_between(&m->seed, 0.5, 1), at = acos(0) * i;
    const double ray[3] = {sin(polar) * cos(at), sin(polar) * sin(at), cos(polar)};
    for (int k = 0; k < 3; k++) {
      axis[i][k] = spherical ? ray[k] : k == 1;
      point[i][k] = spherical ? 0.8 * ray[k] : planar[i][k] + random_between(&m->seed, -0.1, 0.1);
    }
  }
  make_loop(m, point, axis);
}

/* A platform on two legs of three parallel hinges each, which goes straight up and down. */
static void make_sarrus(mechanism *m)
{
  double out = random_between(&m->seed, 0.3, 0.6);
  const double centre[3] = {0, 0, 1};
  int platform = add_body(m, centre, centre);
  for (int leg = 0; leg < 2; leg++) {
    const double foot[3] = {leg == 0, leg == 1, 0}, top[3] = {leg == 0, leg == 1, 1};
    const double knee[3] = {leg == 0 ? 1 + out : 0, leg == 1 ? 1 + out : 0, 0.5};
    const double axis[3] = {leg == 1, leg == 0, 0};
    int low = add_body(m, foot, knee), high = add_body(m, knee, top);
    join(m, 0, NSDAE_JOINT_REVOLUTE, NSDAE_GROUND, low, foot, axis);
    join(m, 0, NSDAE_JOINT_REVOLUTE, low, high, knee, axis);
    join(m, 0, NSDAE_JOINT_REVOLUTE, high, platform, top, axis);
  }
}

/* A chain of links with two joints on the axis of each. */
static void make_pairs(mechanism *m, int links, int first, int second, double apart)
{
  int last = NSDAE_GROUND;
  for (int i = 0; i < links; i++) {
    const double from[3] = {i, 0, 0}, to[3] = {i + 1, 0, 0};
    double axis[3] = {0.3 * (i % 2), 1, 0.2}, other[3];
    for (int k = 0; k < 3; k++) other[k] = from[k] + apart * axis[k];
    int next = add_body(m, from, to);
    join(m, 0, first, last, next, from, axis);
    join(m, m->once, second, last, next, other, axis);
    last = next;
  }
}

static void make(mechanism *m, enum kind kind, int seed, int once)
{
  double g[3], size;
  *m = (mechanism){.seed = 1 + (uint64_t)seed, .off = offs[seed % OFFS], .once = once};
  for (int i = 0; i < 10; i++) random_between(&m->seed, 0, 1);
  do {
    for (int i = 0; i < 3; i++) g[i] = random_between(&m->seed, -1, 1);
    size = length3(g);
  } while (size < 0.1 || size > 1 || fabs(g[2]) < size / 2);
  for (int i = 0; i < 3; i++) g[i] *= 9.81 / size;
  if (kind == SARRUS) g[2] = -fabs(g[2]);
  assert_int_equal(nsdae_bodies_create(3, &m->bodies, NULL), NSDAE_OK);
  assert_int_equal(nsdae_bodies_set_gravity(m->bodies, g), NSDAE_OK);
  if (kind == BENNETT) make_bennett(m);
  if (kind == SPHERICAL || kind == PLANAR) make_four_bar(m, kind == SPHERICAL);
  if (kind == SARRUS) make_sarrus(m);
  if (kind == HINGES) make_pairs(m, 2, NSDAE_JOINT_REVOLUTE, NSDAE_JOINT_REVOLUTE, 0.2);
  if (kind == SLIDING) make_pairs(m, 2, NSDAE_JOINT_REVOLUTE, NSDAE_JOINT_CYLINDRICAL, 0);
  if (kind == BALLS) make_pairs(m, 2, NSDAE_JOINT_SPHERICAL, NSDAE_JOINT_SPHERICAL, 0.3);
  if (kind == SCREWS) make_pairs(m, 2, NSDAE_JOINT_SCREW, NSDAE_JOINT_SCREW, 0.2);
  if (kind == LONG) make_pairs(m, 8, NSDAE_JOINT_REVOLUTE, NSDAE_JOINT_CYLINDRICAL, 0);
}

static const double t_end = 0.3, fine = 1e-3, acceleration = 9.81;

typedef struct outcome {
  int status, nq;
  double q[NQ_MAX], moved; /* at the end; the most that a coordinate did */
} outcome;

static outcome run(enum kind kind, int seed, int once, int method)
{
  outcome r = {0};
  mechanism m;
  nsdae_sim_options o;
  nsdae_system *system;
  nsdae_sim *sim;
  nsdae_record record;
  double start[NQ_MAX], v[NQ_MAX];
  make(&m, kind, seed, once);
  r.nq = 7 * m.count;
  nsdae_sim_options_default(&o);
  o.method = method;
  o.dt = method == NSDAE_METHOD_EVENT ? 10 * fine : fine;
  o.rtol = 1e-9;
  o.atol = 1e-11;
  o.redundant = NSDAE_REDUNDANT_LEAST_NORM;
  if (m.off > 1e-8) o.rank_tol = 100 * m.off; /* the axes are not known better */
  assert_int_equal(nsdae_bodies_system(m.bodies, &system), NSDAE_OK);
  assert_int_equal(nsdae_sim_create(system, &o, &sim, NULL), NSDAE_OK);
  nsdae_bodies_get_start(m.bodies, start, v);
  r.status = nsdae_sim_init(sim, 0, start, v);
  if (r.status >= 0) r.status = nsdae_sim_run(sim, t_end);
  assert_int_equal(nsdae_sim_get_record(sim, &record), NSDAE_OK);
  for (int i = 0; i < r.nq; i++) {
    r.q[i] = record.q[i];
    r.moved = fmax(r.moved, fabs(r.q[i] - start[i]));
  }
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  nsdae_bodies_destroy(&m.bodies);
  return r;
}

static double distance(const outcome *a, const outcome *b)
{
  double most = 0;
  for (int i = 0; i < a->nq; i++) most = fmax(most, fabs(a->q[i] - b->q[i]));
  return most;
}

/* The reference is event's, of pairs on one axis without the second joint. First order: the fall
 * of a step is off by what gravity adds in it, h g t. Second order: (omega h)^2 m with 10 rad/s.
 * Axes that are off turn the motion by that, and the way is a metre; a hinge that is off by more
 * than the other is on the way in between. */
static int expect(enum kind kind, int seed)
{
  const int methods[] = {NSDAE_METHOD_MOREAU, NSDAE_METHOD_IMPLICIT, NSDAE_METHOD_EVENT};
  const double tols[] = {fine * acceleration * t_end, 100 * fine * fine, 1e-6};
  outcome exact = run(kind, seed, kind >= HINGES && kind != BALLS, NSDAE_METHOD_EVENT);
  assert_true(exact.status >= 0);
  if (!(exact.moved > 2 * tols[0])) return 0; /* it stands still by weight alone */
  for (int i = 0; i < 3; i++) {
    outcome now = run(kind, seed, 0, methods[i]);
    double off = distance(&now, &exact), bound = tols[i] + 10 * offs[seed % OFFS];
    int refused = kind == LONG && i == 2 && now.status < 0; /* event may say that it cannot */
    if (refused || (now.status >= 0 && off <= bound)) continue;
    print_error("%s, seed %d, method %d: status %d, off by %.3g, above %.3g, moved %.3g of %.3g\n",
                names[kind], seed, methods[i], now.status, off, bound, now.moved, exact.moved);
    fail();
  }
  return 1;
}

/* NSDAE_SEED: the first of the members. */
static void test_family(void **state)
{
  (void)state;
  const char *given = getenv("NSDAE_SEED");
  int first = given ? atoi(given) : 0;
  for (int kind = 0; kind < KINDS; kind++) {
    int moving = 0, members = 0;
    for (int seed = first; seed < first + OFFS; seed++) {
      /* the quick form has two of each kind, of the longest one, and each of offs by two kinds */
      int turn = (seed + kind) % OFFS;
      if (test_share() > 1 && turn != 0 && (turn != 4 || kind == LONG)) continue;
      moving += expect((enum kind)kind, seed);
      members++;
    }
    assert_true(2 * moving > members);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_family)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
