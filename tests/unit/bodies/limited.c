/* Motors and dry friction with limits of 1e-2 to 1e4 weights under stacks and in grippers: each
 * step is judged by the law of the joint, by the momentum of all bodies and by its status. Small
 * islands are dense, those of more than 150 rows are problems of cones. */
#include "check.h"

#include <nsdae/nsdae.h>

#include "support/hung_bodies.h"
#include "support/random.h"

enum { BOXES = 16, DENSE = 5, LARGE = 14, STEPS = 12 };

static const double g = 9.81;

typedef struct scene {
  nsdae_bodies *b;
  nsdae_system *system;
  nsdae_sim *sim;
  double tol, dt, mass; /* of all bodies but the jaws of a gripper */
} scene;

static int add_box(nsdae_bodies *b, const double length[3], double x, double z, double mass,
                   int material)
{
  nsdae_solid box = {.shape = NSDAE_SHAPE_BOX, .material = material};
  nsdae_rigid_body body = {.mass = mass, .position = {x, 0, z}};
  double all;
  for (int i = 0; i < 3; i++) box.length[i] = length[i];
  double density = mass / (length[0] * length[1] * length[2]);
  assert_int_equal(nsdae_solid_inertia(&box, density, &all, body.inertia, NULL), NSDAE_OK);
  int number = nsdae_bodies_add(b, &body);
  assert_true(nsdae_bodies_add_solid(b, number, &box) >= 0);
  return number;
}

static void add_ball(nsdae_bodies *b, double radius, double z, double mass)
{
  const double I = 0.4 * mass * radius * radius;
  nsdae_rigid_body body = {.mass = mass, .inertia = {I, I, I}, .position = {0, 0, z}};
  nsdae_solid ball = {.shape = NSDAE_SHAPE_SPHERE, .radius = radius, .material = 1};
  assert_true(nsdae_bodies_add_solid(b, nsdae_bodies_add(b, &body), &ball) >= 0);
}

/* A speed motor along an axis, from the ground; with the target 0 it is dry friction. */
static void drive(nsdae_bodies *b, int body, int along, double target, double limit)
{
  nsdae_joint joint = {.kind = NSDAE_JOINT_PRISMATIC, .body = {NSDAE_GROUND, body}};
  joint.axis[along] = 1;
  nsdae_motor motor = {.joint = nsdae_bodies_add_joint(b, &joint),
                       .kind = NSDAE_MOTOR_SPEED,
                       .target = target,
                       .limit = limit};
  if (nsdae_bodies_add_motor(b, &motor) < 0) fail_msg("%s", nsdae_bodies_error(b)->text);
}

/* up: added to the velocities of all bodies. */
static void begin(scene *s, int method, double up)
{
  nsdae_sim_options o;
  nsdae_dims dims;
  double q[7 * BOXES], v[6 * BOXES];
  if (nsdae_bodies_system(s->b, &s->system) < 0) fail_msg("%s", nsdae_bodies_error(s->b)->text);
  nsdae_bodies_get_dims(s->b, &dims);
  nsdae_bodies_get_start(s->b, q, v);
  for (int i = 0; i < dims.nv / 6; i++) v[6 * i + 2] += up;
  nsdae_sim_options_default(&o);
  o.method = method;
  o.dt = s->dt;
  o.contact_tol = s->tol;
  o.projection = NSDAE_PROJECTION_NONE;
  assert_int_equal(nsdae_sim_create(s->system, &o, &s->sim, NULL), NSDAE_OK);
  if (nsdae_sim_init(s->sim, 0, q, v) < 0) fail_msg("%s", nsdae_sim_error(s->sim)->text);
}

static void end(scene *s)
{
  nsdae_sim_destroy(&s->sim);
  nsdae_system_destroy(&s->system);
  nsdae_bodies_destroy(&s->b);
}

/* Runs that ended since a contact problem was not solved, which the status says. */
static int unsolved;

/* One step, whose status says what its residual is; 0: it was not solved. */
static int step(scene *s, nsdae_record *r)
{
  nsdae_stats before, after;
  nsdae_sim_get_stats(s->sim, &before);
  int status = nsdae_sim_step(s->sim);
  unsolved += status == NSDAE_E_LCP;
  if (status == NSDAE_E_LCP) return 0;
  if (status < 0) fail_msg("%s", nsdae_sim_error(s->sim)->text);
  nsdae_sim_get_record(s->sim, r);
  nsdae_sim_get_stats(s->sim, &after);
  assert_at_most(r->lcp_residual, 100 * s->tol);
  assert_int_equal(after.inexact_steps - before.inexact_steps, r->lcp_residual > s->tol);
  return 1;
}

/* ---- a plate on a motor along z, with boxes on it */

/* factor: the limit in weights. */
static void lift(scene *s, int boxes, double plate, double heavy, double factor, double target)
{
  const double flat[3] = {2, 2, 0.1}, cube[3] = {0.5, 0.5, 0.5};
  s->b = create(3, 0, 0, -g);
  nsdae_bodies_set_pair(s->b, 0, 1, 0.5, 0, 0);
  nsdae_bodies_set_pair(s->b, 1, 1, 0.5, 0, 0);
  add_box(s->b, flat, 0, 2, plate, 0);
  s->mass = plate + boxes * heavy;
  for (int i = 0; i < boxes; i++) add_box(s->b, cube, 0.1, 2.3 + 0.5 * i, heavy, 1);
  drive(s->b, 0, 2, target, factor * s->mass * g);
}

/* The force holds the speed, or is the limit against it; and it moves all bodies. */
static void judge_lift(const scene *s, const nsdae_record *r, double before, int boxes,
                       double plate, double limit, double target)
{
  double heavy = (s->mass - plate) / boxes, momentum = plate * r->v[2];
  double scale = g * s->dt + fabs(target) + fabs(r->v[2]), F = r->frictional_joint_force[0];
  double u = r->v[2] - target, digits = fmax(s->tol, r->lcp_residual) * 1e2 * scale;
  for (int i = 1; i <= boxes; i++) momentum += heavy * r->v[6 * i + 2];
  assert_at_most(fabs(F), limit * (1 + 1e-12));
  if (fabs(u) > digits) assert_near(F, copysign(limit, -u), 1e-6 * limit);
  assert_near(momentum - before, s->dt * (F - s->mass * g),
              1e-11 * (s->mass * (scale + g) + s->dt * fabs(F)));
}

static void ride(uint64_t *seed, int boxes)
{
  scene s = {.tol = pow(10, -6 - random_below(seed, 5)), .dt = random_below(seed, 2) ? 1e-2 : 1e-3};
  double plate = pow(10, random_between(seed, -1, 3)), heavy = pow(10, random_between(seed, 0, 3));
  double factor = pow(10, random_between(seed, -2, 4));
  int method = random_below(seed, 2);
  double target = random_below(seed, 4) == 0 ? 0 : random_between(seed, -0.2, 0.2),
         up = factor > 1 ? target : 0;
  lift(&s, boxes, plate, heavy, factor, target);
  begin(&s, method ? NSDAE_METHOD_IMPLICIT : NSDAE_METHOD_MOREAU, up);
  double momentum = s.mass * up;
  nsdae_record r;
  for (int i = 0; i < STEPS && step(&s, &r); i++) {
    judge_lift(&s, &r, momentum, boxes, plate, factor * s.mass * g, target);
    momentum = plate * r.v[2];
    for (int j = 1; j <= boxes; j++) momentum += heavy * r.v[6 * j + 2];
  }
  end(&s);
}

static void test_lifts(void **state)
{
  const char *full = getenv("NSDAE_LONG");
  uint64_t seed = 43;
  (void)state;
  for (int i = 0; i < (full ? 2000 : 30); i++) ride(&seed, 1 + random_below(&seed, DENSE));
  for (int i = 0; i < (full ? 100 : 3); i++) ride(&seed, LARGE);
  assert_true(unsolved <= (full ? 20 : 0));
}

/* ---- a box between two jaws on motors along x */

/* Each jaw presses with its limit L: the body is held if 2 mu L is at least its weight, else it
 * falls with g - 2 mu L / m. A box, whose contacts share the load in many ways, may turn then, and
 * falls no slower. The jaws overlap it, so that moreau sees them closed in every step. */
static void grip(uint64_t *seed, int ball)
{
  const double jaw[3] = {0.2, 0.5, 0.5}, cube[3] = {0.5, 0.5, 0.5}, mu = 0.5;
  scene s = {.tol = pow(10, -8 - random_below(seed, 3)), .dt = 1e-3};
  double mass = pow(10, random_between(seed, 0, 3)),
         heavy = pow(10, random_between(seed, getenv("NSDAE_LONG") ? -1 : 0, 3));
  double limit = pow(10, random_between(seed, -2, 4)) * mass * g, a = 2 * mu * limit / mass - g;
  int method = random_below(seed, 2) ? NSDAE_METHOD_IMPLICIT : NSDAE_METHOD_MOREAU;
  s.b = create(3, 0, 0, -g);
  nsdae_bodies_set_pair(s.b, 0, 1, mu, 0, 0);
  for (int side = -1; side <= 1; side += 2)
    drive(s.b, add_box(s.b, jaw, (0.35 - 1e-6) * side, 2, heavy, 0), 0, -0.1 * side, limit);
  /* a residual is a velocity, of the jaws too: [N s] */
  double digits = 1e2 * s.tol * (0.1 + fabs(a) * s.dt) * (mass + heavy);
  if (ball)
    add_ball(s.b, 0.25, 2, mass);
  else
    add_box(s.b, cube, 0, 2, mass, 1);
  begin(&s, method, 0);
  nsdae_record r;
  for (int i = 1; i <= STEPS && step(&s, &r); i++) {
    double falls = r.v[12 + 2], should = fmin(a, 0) * i * s.dt;
    if (ball || a >= 0)
      assert_near(falls, should, i * digits / mass);
    else
      assert_at_most(falls, should + i * digits / mass);
    assert_near(r.frictional_joint_force[0], limit, digits / s.dt);
    assert_near(r.frictional_joint_force[1], -limit, digits / s.dt);
  }
  end(&s);
}

static void test_grippers(void **state)
{
  const char *full = getenv("NSDAE_LONG");
  uint64_t seed = 44;
  (void)state;
  for (int i = 0; i < (full ? 2000 : 40); i++) grip(&seed, i % 2);
  seed = 100; /* one of these has a solution with all load at a corner, about which the box turns */
  for (int i = 0; i < 40; i++) grip(&seed, 0);
  assert_true(unsolved <= (full ? 40 : 0));
}

/* ---- limits far from the load */

/* The velocities after some steps of a large island, and the force. */
static double carried(double factor, double *v)
{
  scene s = {.tol = 1e-10, .dt = 1e-2};
  nsdae_record r;
  lift(&s, LARGE, 1, 125, factor, 0.1);
  begin(&s, NSDAE_METHOD_MOREAU, factor > 1 ? 0.1 : 0);
  for (int i = 0; i < 3; i++) assert_true(step(&s, &r));
  memcpy(v, r.v, 6 * (LARGE + 1) * sizeof *v);
  double force = r.frictional_joint_force[0] / (s.mass * g);
  end(&s);
  return force;
}

/* A limit that is not reached changes nothing, one that is reached is the force. */
static void test_large(void **state)
{
  double v[6 * (LARGE + 1)], other[6 * (LARGE + 1)];
  (void)state;
  assert_near(carried(1.5, v), 1, 1e-8);
  for (double factor = 1e2; factor < 1e9; factor *= 1e3) {
    assert_near(carried(factor, other), 1, 1e-8);
    for (int i = 0; i < 6 * (LARGE + 1); i++) assert_near(other[i], v[i], 1e-9);
  }
  for (double factor = 1e-6; factor < 1; factor *= 1e2)
    assert_near(carried(factor, v), factor, 1e-14 * factor);
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_lifts), cmocka_unit_test(test_grippers),
                                     cmocka_unit_test(test_large)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
