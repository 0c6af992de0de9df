/* Position motors, F = kp e + kd e' within a limit: against closed forms by event to 1e-10, by time
 * stepping with its order and, of stiff gains, without growth; on chains against event; and the law
 * of their rows, from recorded states alone. */
#include "check.h"

#include <nsdae/nsdae.h>

#include "support/hung_bodies.h"
#include "support/random.h"

static const double pi = 3.14159265358979324;
static const int stepping[] = {NSDAE_METHOD_IMPLICIT, NSDAE_METHOD_IMPLICIT_PRINTED,
                               NSDAE_METHOD_MOREAU};
enum { STEPPING = sizeof stepping / sizeof *stepping };
static const double mass = 2, moment = 0.5; /* of a slider, of a wheel: see hung_bodies.h */

static int add_motor(nsdae_bodies *b, nsdae_motor motor)
{
  int number = nsdae_bodies_add_motor(b, &motor);
  if (number < 0) fail_msg("%s", nsdae_bodies_error(b)->text);
  return number;
}

static int slider(nsdae_bodies *b, int d, double speed)
{
  nsdae_rigid_body body = {.mass = mass};
  body.velocity[d == 2 ? 0 : 2] = speed;
  return hang(b, d, NSDAE_JOINT_PRISMATIC, body);
}

/* ---- closed forms */

/* e(t) of m e'' + kd e' + kp e = 0 from e0, u0, and its rate. */
static void decay(double m, double kp, double kd, double t, const double start[2], double end[2])
{
  double a = kd / (2 * m), square = kp / m - a * a, e0 = start[0], u0 = start[1];
  if (fabs(square) <= 1e-12 * a * a) { /* critical */
    double c = u0 + a * e0;
    end[0] = exp(-a * t) * (e0 + c * t);
    end[1] = exp(-a * t) * (c - a * (e0 + c * t));
  } else if (square > 0) {
    double w = sqrt(square), c = (u0 + a * e0) / w;
    end[0] = exp(-a * t) * (e0 * cos(w * t) + c * sin(w * t));
    end[1] = exp(-a * t) * ((c * w - a * e0) * cos(w * t) - (e0 * w + a * c) * sin(w * t));
  } else { /* roots r < s < 0, r s = kp / m */
    double r = -a - sqrt(-square), s = kp / m / r, c = (u0 - s * e0) / (r - s);
    end[0] = c * exp(r * t) + (e0 - c) * exp(s * t);
    end[1] = c * r * exp(r * t) + (e0 - c) * s * exp(s * t);
  }
}

/* The target 1 from rest after two times 1 / omega: largest error of position and rate over omega.
 */
static double swing(int d, int method, double kp, double kd, double steps)
{
  const double w = sqrt(kp / mass), t = 2 / w, start[2] = {-1, 0};
  double exact[2];
  nsdae_bodies *b = create(d, 0, 0, 0);
  int axis = d == 2 ? 0 : 2;
  add_motor(b, (nsdae_motor){slider(b, d, 0), .kind = NSDAE_MOTOR_POSITION, .limit = INFINITY,
                             .target = 1, .kp = kp, .kd = kd});
  ending end = run(b, method, t / steps, t);
  decay(mass, kp, kd, t, start, exact);
  return fmax(fabs(end.q[axis] - 1 - exact[0]), fabs(end.v[axis] - exact[1]) / w);
}

static void test_closed_forms(void **state)
{
  (void)state;
  const double damping[] = {0, 0.4, 2, 10}; /* times sqrt(kp m): 2 is critical */
  for (int d = 2; d <= 3; d++)
    for (double kp = 1; kp < 2e8; kp *= 100)
      for (int i = 0; i < 4; i++) {
        double kd = damping[i] * sqrt(kp * mass);
        assert_at_most(swing(d, NSDAE_METHOD_EVENT, kp, kd, 4), 1e-10);
        for (int k = 0; k < STEPPING; k++) {
          double coarse = swing(d, stepping[k], kp, kd, 200),
                 fine = swing(d, stepping[k], kp, kd, 800);
          assert_at_most(coarse, 2e-3);
          assert_at_most(fine, coarse / 12); /* 16 of second order */
        }
      }
}

/* A wheel in a turn of 2.5: in space the target 2 pi - 2.5 is -2.5. */
static void test_turn(void **state)
{
  (void)state;
  for (int d = 2; d <= 3; d++)
    for (double kp = 1e2; kp < 2e8; kp *= 1000) {
      const double kd = kp / 5, target = d == 2 ? 9 : -2.5, t = 0.5, start[2] = {-target, 0};
      double exact[2];
      decay(moment, kp, kd, t, start, exact);
      for (int k = -1; k < STEPPING; k++) {
        nsdae_bodies *b = create(d, 0, 0, 0);
        int joint = hang(b, d, NSDAE_JOINT_REVOLUTE, (nsdae_rigid_body){.mass = mass});
        add_motor(b, (nsdae_motor){joint, .kind = NSDAE_MOTOR_POSITION, .limit = INFINITY,
                                   .target = d == 2 ? 9 : 2 * pi - 2.5, .kp = kp, .kd = kd});
        ending end = run(b, k < 0 ? NSDAE_METHOD_EVENT : stepping[k], k < 0 ? 0.1 : 1e-3, t);
        /* of stiff gains theta is near 1: first order, h kp / kd / 2 of the slow root */
        assert_near(angle_of(d, end.q), target + exact[0], k < 0 ? 1e-9 : 2 * 1e-3 * fabs(target));
      }
    }
}

/* From rest with the limit f: s = f t^2 / (2 m) until kp (target - s) - kd s' = f, then as without.
 */
static double saturated(int d, int method, double dt)
{
  const double kp = 50, kd = 100, f = 6, target = 4, a = f / mass, t = 3;
  const double first = (sqrt(kd * kd * a * a + 2 * kp * a * (kp * target - f)) - kd * a) / (kp * a),
               start[2] = {a * first * first / 2 - target, a * first};
  double exact[2];
  int axis = d == 2 ? 0 : 2;
  nsdae_bodies *b = create(d, 0, 0, 0);
  add_motor(b, (nsdae_motor){slider(b, d, 0), .kind = NSDAE_MOTOR_POSITION, .limit = f,
                             .target = target, .kp = kp, .kd = kd});
  ending end = run(b, method, dt, t);
  decay(mass, kp, kd, t - first, start, exact);
  assert_true(first < 2 && kp * fabs(exact[0]) > 1); /* both phases, and the error is to be seen */
  return fmax(fabs(end.q[axis] - target - exact[0]), fabs(end.v[axis] - exact[1]));
}

/* The limit is exact: far from a stiff target the acceleration is f / m, to rounding. */
static void test_limit(void **state)
{
  (void)state;
  for (int d = 2; d <= 3; d++) {
    judge(saturated, d, 20);
    for (int k = 0; k < STEPPING; k++) {
      nsdae_bodies *b = create(d, 0, 0, 0);
      add_motor(b, (nsdae_motor){slider(b, d, 0), .kind = NSDAE_MOTOR_POSITION, .limit = 6,
                                 .target = 100, .kp = 1e8, .kd = 1e4});
      ending end = run(b, stepping[k], 1e-2, 2);
      assert_near(end.q[d == 2 ? 0 : 2], 6 / mass * 2, 1e-12);
      assert_near(end.v[d == 2 ? 0 : 2], 6 / mass * 2, 1e-12);
    }
  }
}

/* ---- stiff gains */

typedef struct energies {
  double kp, start, last, worst;
} energies;

static double theta_of(double m, double kp, double kd, double h)
{
  double z = h * (kd + h * kp) / m;
  return (1 + z) / (2 + z);
}

static int follow_energy(const nsdae_record *r, nsdae_error *error, void *user)
{
  energies *e = user;
  (void)error;
  double h = 1e-3, theta = theta_of(mass, e->kp, 0, h),
         eps = r->q[0] - 1 + (theta - 0.5) * h * r->v[0],
         energy = e->kp * eps * eps + mass * r->v[0] * r->v[0];
  if (e->start == 0) e->start = e->last = energy;
  e->worst = fmax(e->worst, (energy - e->last) / e->start);
  e->last = energy;
  return 0;
}

/* Without damping kp eps^2 + m xi^2 does not grow in any step, eps = e + (theta - 1/2) h xi: the
 * law of the theta method. Of kp = 1e8 the target is reached in 20 steps, wherever the slider
 * starts. */
static void test_no_growth(void **state)
{
  (void)state;
  for (int k = 0; k < STEPPING; k++)
    for (double kp = 1; kp < 2e12; kp *= 10) {
      energies e = {.kp = kp};
      nsdae_system *system;
      nsdae_sim *sim;
      nsdae_record r;
      nsdae_sim_options o;
      double q[3], v[3];
      nsdae_bodies *b = create(2, 0, 0, 0);
      add_motor(b, (nsdae_motor){slider(b, 2, 3), .kind = NSDAE_MOTOR_POSITION, .limit = INFINITY,
                                 .target = 1, .kp = kp});
      assert_true(nsdae_bodies_system(b, &system) >= 0);
      nsdae_bodies_get_start(b, q, v);
      nsdae_sim_options_default(&o);
      o.method = stepping[k];
      o.dt = 1e-3;
      assert_int_equal(nsdae_sim_create(system, &o, &sim, NULL), NSDAE_OK);
      nsdae_sim_observe(sim, follow_energy, &e);
      assert_int_equal(nsdae_sim_init(sim, 0, q, v), NSDAE_OK);
      assert_int_equal(nsdae_sim_run(sim, 0.02), NSDAE_OK);
      nsdae_sim_get_record(sim, &r);
      assert_at_most(e.worst, 1e-13);
      if (kp > 5e7) assert_near(r.q[0], 1, 1e-12);
      nsdae_sim_destroy(&sim);
      nsdae_system_destroy(&system);
      nsdae_bodies_destroy(&b);
    }
}

/* Two motors on one joint: they rest between their targets, in parts of their gains. One at its
 * limit of 5 N holds the other, of 1e2 N/m, 0.05 m away from its target. */
static void test_two_on_one(void **state)
{
  (void)state;
  const double gains[] = {1e2, 1e8};
  for (int d = 2; d <= 3; d++)
    for (int i = 0; i < 4 * STEPPING; i++) {
      double kp = gains[i % 2], other = gains[i / 2 % 2];
      for (int limited = 0; limited <= 1; limited++) {
        nsdae_bodies *b = create(d, 0, 0, 0);
        int joint = slider(b, d, 1);
        add_motor(b, (nsdae_motor){joint, .kind = NSDAE_MOTOR_POSITION, .limit = INFINITY,
                                   .target = 1, .kp = kp, .kd = 2 * sqrt(kp * mass)});
        add_motor(b, (nsdae_motor){joint, .kind = NSDAE_MOTOR_POSITION,
                                   .limit = limited ? 5 : INFINITY, .target = 2, .kp = other});
        ending end = run(b, stepping[i / 4], 1e-2, 8);
        double rest = limited ? 1 + 5 / kp : (kp + 2 * other) / (kp + other);
        assert_near(end.q[d == 2 ? 0 : 2], rest, 1e-9);
      }
    }
}

/* ---- chains */

/* An arm of two links of 1 m in the plane, its motors with a gain in parts of 5e2; under gravity.
 */
static ending arm(int method, double dt, double stiff, double g)
{
  nsdae_bodies *b = create(2, 0, -g, 0);
  int above = NSDAE_GROUND;
  for (int i = 0; i < 2; i++) {
    int link = nsdae_bodies_add(
        b, &(nsdae_rigid_body){.mass = 1, .inertia = {0, 0, 1.0 / 12}, .position = {i + 0.5, 0}});
    int joint = nsdae_bodies_add_joint(
        b, &(nsdae_joint){.kind = NSDAE_JOINT_REVOLUTE, .body = {above, link}, .point = {i, 0}});
    add_motor(b, (nsdae_motor){joint, .kind = NSDAE_MOTOR_POSITION, .limit = INFINITY,
                               .target = i ? -1.2 : 0.7, .kp = 5e2 * stiff, .kd = 20 * stiff});
    above = link;
  }
  return run(b, method, dt, 0.5);
}

static double apart(const ending *a, const ending *b)
{
  double most = 0;
  for (int i = 0; i < 6; i++) most = fmax(most, fabs(a->q[i] - b->q[i]));
  return most;
}

/* implicit is of second order, the others of first with constraints. */
static void test_arm(void **state)
{
  (void)state;
  ending exact = arm(NSDAE_METHOD_EVENT, 0.05, 1, 9.81);
  for (int k = 0; k < STEPPING; k++) {
    ending coarse = arm(stepping[k], 2e-3, 1, 9.81), fine = arm(stepping[k], 5e-4, 1, 9.81);
    int second = stepping[k] == NSDAE_METHOD_IMPLICIT;
    assert_at_most(apart(&coarse, &exact), second ? 2e-3 : 2e-2);
    assert_at_most(apart(&fine, &exact), apart(&coarse, &exact) / (second ? 11 : 2.5));
  }
  for (int k = 0; k < STEPPING; k++) { /* at once there, without gravity to stay exactly */
    ending stiff = arm(stepping[k], 1e-3, 1e8, 0);
    assert_near(stiff.q[2], 0.7, 1e-3); /* kd / kp = 0.04 s: e^-12.5 of it is left */
    assert_near(stiff.q[5], -0.5, 1e-3);
  }
}

/* ---- with contacts and dry friction */

/* A slider is driven at 0.5 m/s against the dry friction of a motor of 3 N and pushes a block of 1
 * kg, which rubs on the floor with mu 0.3: it lags by (3 + 0.3 g) / kp, at any dt. */
static void test_pushes(void **state)
{
  (void)state;
  const double g = 10, kp = 1e6;
  static const double square[8] = {-0.1, -0.1, 0.1, -0.1, 0.1, 0.1, -0.1, 0.1};
  for (int d = 2; d <= 3; d++)
    for (int k = 0; k < STEPPING; k++) {
      nsdae_bodies *b = create(d, 0, d == 2 ? -g : 0, d == 3 ? -g : 0);
      const nsdae_solid box = d == 2
                                  ? (nsdae_solid){NSDAE_SHAPE_POLYGON, .points = 4, .point = square}
                                  : (nsdae_solid){NSDAE_SHAPE_BOX, .length = {0.2, 0.2, 0.2}};
      const nsdae_solid knob = {d == 2 ? NSDAE_SHAPE_DISC : NSDAE_SHAPE_SPHERE, .radius = 0.05};
      nsdae_bodies_add(
          b, &(nsdae_rigid_body){.mass = mass, .inertia = {1, 1, 1}, .position = {-0.15}});
      nsdae_bodies_add(b, &(nsdae_rigid_body){.mass = 1, .inertia = {0.007, 0.007, 0.007}});
      int joint = nsdae_bodies_add_joint(b, &(nsdae_joint){.kind = NSDAE_JOINT_PRISMATIC,
                                                           .body = {NSDAE_GROUND, 0},
                                                           .axis = {1, 0, 0}});
      add_motor(b, (nsdae_motor){joint, .kind = NSDAE_MOTOR_SPEED, .limit = 3});
      int motor = add_motor(b, (nsdae_motor){joint, .kind = NSDAE_MOTOR_POSITION, .limit = INFINITY,
                                             .kp = kp, .kd = 1e3});
      nsdae_solid plane = {.shape = NSDAE_SHAPE_PLANE};
      plane.position[d - 1] = -0.1;
      int floor = nsdae_bodies_add_solid(b, NSDAE_GROUND, &plane),
          pushed = nsdae_bodies_add_solid(b, 1, &box), pusher = nsdae_bodies_add_solid(b, 0, &knob);
      nsdae_bodies_add_contact(b, floor, pushed, 0.3, 0, 0);
      nsdae_bodies_add_contact(b, pusher, pushed, 0, 0, 0);
      nsdae_system *system;
      nsdae_sim *sim;
      nsdae_record r;
      nsdae_sim_options o;
      double q[14], v[12];
      if (nsdae_bodies_system(b, &system) < 0) fail_msg("%s", nsdae_bodies_error(b)->text);
      nsdae_bodies_get_start(b, q, v);
      nsdae_sim_options_default(&o);
      o.method = stepping[k];
      o.dt = 2e-3;
      assert_int_equal(nsdae_sim_create(system, &o, &sim, NULL), NSDAE_OK);
      assert_int_equal(nsdae_sim_init(sim, 0, q, v), NSDAE_OK);
      for (int i = 0; i < 500; i++) { /* the target rests in a step, and then moves by 1 mm */
        nsdae_sim_set_control(sim, motor, 1e-3 * i);
        int status = nsdae_sim_step(sim);
        if (status < 0) fail_msg("%s", nsdae_sim_error(sim)->text);
      }
      nsdae_sim_get_record(sim, &r);
      assert_near(r.frictional_joint_force[1], 3 + 0.3 * g, 1e-6 * kp * 1e-3);
      assert_near(r.v[0], 0.5, 1e-6);
      nsdae_sim_destroy(&sim);
      nsdae_system_destroy(&system);
      nsdae_bodies_destroy(&b);
    }
}

/* ---- the law of a row, from the states before and after a step */

enum { LINKS = 5 };
typedef struct random_chain {
  int d;
  int motors, joint[LINKS]; /* the link of each motor */
  double kp[LINKS], kd[LINKS], limit[LINKS], target[LINKS];
  double inertia[LINKS], h;
  nsdae_bodies *b;
} random_chain;

/* In space it moves in the plane of x and z, with spheres whose friction is a cone. */
static random_chain make_chain(uint64_t *seed, int d)
{
  random_chain c = {.d = d, .h = pow(10, random_between(seed, -4, -2))};
  c.b = create(d, 0, d == 2 ? -9.81 : 0, d == 3 ? -9.81 : 0);
  int links = 1 + random_below(seed, LINKS), above = NSDAE_GROUND;
  nsdae_solid plane = {.shape = NSDAE_SHAPE_PLANE}, ball = {.radius = 0.05};
  plane.position[d - 1] = -0.3;
  ball.shape = d == 2 ? NSDAE_SHAPE_DISC : NSDAE_SHAPE_SPHERE;
  int floor = nsdae_bodies_add_solid(c.b, NSDAE_GROUND, &plane);
  for (int i = 0; i < links; i++) {
    double J = c.inertia[i] = pow(10, random_between(seed, -3, 0));
    int link =
        nsdae_bodies_add(c.b, &(nsdae_rigid_body){.mass = pow(10, random_between(seed, -1, 1)),
                                                  .inertia = {J, J, J},
                                                  .position = {0.2 * i + 0.1, 0}});
    int joint = nsdae_bodies_add_joint(c.b, &(nsdae_joint){.kind = NSDAE_JOINT_REVOLUTE,
                                                           .body = {above, link},
                                                           .point = {0.2 * i, 0},
                                                           .axis = {0, 1, 0}});
    above = link;
    if (random_below(seed, 4) > 0) {
      int n = c.motors++;
      c.joint[n] = i;
      c.kp[n] = random_below(seed, 4) ? pow(10, random_between(seed, -1, 8)) : 0;
      c.kd[n] = c.kp[n] == 0 || random_below(seed, 2) ? pow(10, random_between(seed, -2, 5)) : 0;
      c.limit[n] = random_below(seed, 2) ? INFINITY : pow(10, random_between(seed, 0, 3));
      c.target[n] = random_between(seed, -0.1, 0.1); /* stiff gains move by it in a step */
      add_motor(c.b, (nsdae_motor){joint, .kind = NSDAE_MOTOR_POSITION, .limit = c.limit[n],
                                   .target = c.target[n], .kp = c.kp[n], .kd = c.kd[n]});
    }
    if (random_below(seed, 3) == 0)
      nsdae_bodies_add_limit(c.b, &(nsdae_limit){joint, .low = -0.15, .high = 0.15});
    if (random_below(seed, 2) == 0)
      nsdae_bodies_add_contact(c.b, floor, nsdae_bodies_add_solid(c.b, link, &ball), 0.5, 0, 0);
  }
  return c;
}

/* Rotation of link i relative to that above, and its rate. */
static void relative(const random_chain *c, int i, const double *q, const double *v, double to[2])
{
  to[0] = to[1] = 0;
  for (int k = 0; k < 2 && k <= i; k++) {
    const double *own = q + (c->d == 2 ? 3 : 7) * (i - k);
    to[0] += (k ? -1 : 1) * (c->d == 2 ? own[2] : 2 * atan2(own[5], own[3]));
    to[1] += (k ? -1 : 1) * v[c->d == 2 ? 3 * (i - k) + 2 : 6 * (i - k) + 4];
  }
  to[0] = remainder(to[0], 2 * pi);
}

/* F of motor n in the step from q, v to r: h F is its impulse. Its row is constant. */
static void assert_law(const random_chain *c, int n, const double *q, const double *v,
                       const nsdae_record *r)
{
  int i = c->joint[n];
  double from[2], to[2];
  relative(c, i, q, v, from);
  relative(c, i, r->q, r->v, to);
  double e = remainder(from[0] - c->target[n], 2 * pi), xi0 = from[1], xi1 = to[1], h = c->h,
         kp = c->kp[n], kd = c->kd[n];
  double m = 1 / (1 / c->inertia[i] + (i ? 1 / c->inertia[i - 1] : 0)),
         theta = theta_of(m, kp, kd, h), back = 1 - theta;
  double F = -kp * (e + h / 2 * xi0 + h * theta * theta * xi1 - h * back * back * xi0) -
             kd * (theta * xi1 + back * xi0);
  double size = kp * (fabs(e) + h * (fabs(xi0) + fabs(xi1))) + kd * (fabs(xi0) + fabs(xi1));
  double law = fmax(-c->limit[n], fmin(c->limit[n], F)), is = r->frictional_joint_force[n];
  /* xi_1 has an error of contact_tol and rounding in parts of the velocities without impulses,
   * which the force of a motor is in part of */
  double slack = 1e-8 * (size + fabs(is)) + 1e-7 * (kp * h + kd);
  assert_true(fabs(is) <= c->limit[n] * (1 + 1e-12));
  assert_near(is, law, slack);
  if (fabs(F) < c->limit[n] - slack)
    assert_int_equal(r->frictional_joint_mode[n], NSDAE_MODE_STICK);
  if (fabs(F) > c->limit[n] + slack) assert_int_equal(r->frictional_joint_mode[n], NSDAE_MODE_SLIP);
}

/* Returns how many motors of its steps were at their limits; steps: of how many. */
static int check_family(uint64_t *seed, int d, int method, int *steps)
{
  random_chain c = make_chain(seed, d);
  nsdae_system *system;
  nsdae_sim *sim;
  nsdae_record r;
  nsdae_sim_options o;
  nsdae_dims dims;
  double q[7 * LINKS], v[6 * LINKS];
  int at_limit = 0;
  if (nsdae_bodies_system(c.b, &system) < 0) fail_msg("%s", nsdae_bodies_error(c.b)->text);
  nsdae_bodies_get_dims(c.b, &dims);
  nsdae_bodies_get_start(c.b, q, v);
  nsdae_sim_options_default(&o);
  o.method = method;
  o.dt = c.h;
  o.projection = NSDAE_PROJECTION_NONE; /* it changes the state after the solution */
  assert_int_equal(nsdae_sim_create(system, &o, &sim, NULL), NSDAE_OK);
  assert_true(nsdae_sim_init(sim, 0, q, v) >= 0);
  for (int i = 0; i < 40; i++) {
    nsdae_sim_get_record(sim, &r);
    memcpy(q, r.q, (size_t)dims.nq * sizeof *q);
    memcpy(v, r.v, (size_t)dims.nv * sizeof *v);
    if (nsdae_sim_step(sim) < 0) fail_msg("step %d: %s", i, nsdae_sim_error(sim)->text);
    nsdae_sim_get_record(sim, &r);
    for (int n = 0; n < c.motors; n++, ++*steps) {
      assert_law(&c, n, q, v, &r);
      at_limit += r.frictional_joint_mode[n] == NSDAE_MODE_SLIP;
    }
  }
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  nsdae_bodies_destroy(&c.b);
  return at_limit;
}

/* moreau in the plane alone: in space the error at the middle of the step is that of q_m. */
static void test_law(void **state)
{
  (void)state;
  uint64_t seed = 20260101;
  int at_limit = 0, steps = 0;
  for (int family = 0; family < 180; family++)
    at_limit += check_family(&seed, family % 3 == 2 ? 3 : 2,
                             family % 3 ? NSDAE_METHOD_IMPLICIT : NSDAE_METHOD_MOREAU, &steps);
  assert_true(at_limit > steps / 20 && at_limit < steps / 2);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_closed_forms), cmocka_unit_test(test_turn),
      cmocka_unit_test(test_limit),        cmocka_unit_test(test_no_growth),
      cmocka_unit_test(test_two_on_one),   cmocka_unit_test(test_arm),
      cmocka_unit_test(test_pushes),       cmocka_unit_test(test_law)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
