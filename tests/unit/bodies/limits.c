/* Limits, joint springs, couplers, screws and ropes against closed forms: by event to 1e-10, by
 * time stepping with its order. */
#include "check.h"

#include <nsdae/nsdae.h>

#include "support/hung_bodies.h"

static const double pi = 3.14159265358979324;

/* ---- limits */

enum { FIXED, LISTED };
static int listed;

/* Solids that never meet, of materials that touch: the limits are in a contact list. */
static void make_list(nsdae_bodies *b)
{
  if (listed != LISTED) return;
  const double far[2] = {50, -50};
  for (int i = 0; i < 2; i++)
    nsdae_bodies_add_solid(b, i - 1,
                           &(nsdae_solid){.shape = NSDAE_SHAPE_POINT, .position = {0, far[i], 0}});
  assert_int_equal(nsdae_bodies_set_pair(b, 0, 0, 0.3, 0, 0), NSDAE_OK);
}

/* A pendulum without gravity between -0.6 and 1, from angle 0 with speed 3: speeds 3, 3 e, 3 e^2,
 * e = 0.8; impacts at 1/3, 1/3 + 1.6 / (3 e), ... */
static double bouncing(int d, int method, double dt)
{
  const double low = -0.6, high = 1, e = 0.8, t_end = 2.5;
  nsdae_bodies *b = create(d, 0, 0, 0);
  nsdae_rigid_body rod = {.position = {0.5}, .velocity = {0, 1.5}, .spin = {0, 0, 3}};
  int joint = hang(b, d, NSDAE_JOINT_REVOLUTE, rod);
  assert_int_equal(nsdae_bodies_add_limit(b, &(nsdae_limit){joint, 0, low, high, e}), 0);
  make_list(b);
  ending end = run(b, method, dt, t_end);
  double t = 0, angle = 0, rate = 3, last = -1;
  int impacts = 0;
  for (;;) {
    double hit = t + ((rate > 0 ? high : low) - angle) / rate;
    if (hit > t_end) break;
    last = t = hit;
    angle = rate > 0 ? high : low;
    rate *= -e;
    impacts++;
  }
  assert_int_equal(end.impacts, impacts);
  angle += rate * (t_end - t);
  return fmax(fmax(fabs(angle_of(d, end.q) - angle), fabs(end.v[d == 2 ? 2 : 5] - rate)),
              method == NSDAE_METHOD_EVENT ? fabs(end.last - last) : 0);
}

static void test_bouncing(void **state)
{
  (void)state;
  for (listed = FIXED; listed <= LISTED; listed++)
    for (int d = 2; d <= 3; d++) judge(bouncing, d, 20);
  listed = FIXED;
}

/* A slider of 2 kg on a spring of 50 N/m, free at x = 0 with speed 1, stopped at x <= 0.1 and e =
 * 0.5: x = a sin(w t), w = 5; the impact is at w t = asin(0.1 w), after it the half period ... */
static double sprung(int d, int method, double dt)
{
  const double w = 5, high = 0.1, e = 0.5, t_end = 0.6;
  nsdae_bodies *b = create(d, 0, 0, 0);
  int axis = d == 2 ? 0 : 2;
  nsdae_rigid_body body = {.mass = 2};
  body.velocity[axis] = 1;
  int joint = hang(b, d, NSDAE_JOINT_PRISMATIC, body);
  assert_true(nsdae_bodies_add_joint_spring(b, &(nsdae_joint_spring){joint, 0, 50, 0, 0}) >= 0);
  assert_int_equal(nsdae_bodies_add_limit(b, &(nsdae_limit){joint, 0, -INFINITY, high, e}), 0);
  make_list(b);
  ending end = run(b, method, dt, t_end);
  /* x = high cos(w s) + u / w sin(w s) from the impact on */
  double hit = asin(high * w) / w, u = -e * sqrt(1 - high * high * w * w), s = t_end - hit;
  assert_int_equal(end.impacts, 1);
  return fmax(fabs(end.q[axis] - high * cos(w * s) - u / w * sin(w * s)),
              fabs(end.v[axis] + high * w * sin(w * s) - u * cos(w * s)));
}

static void test_sprung(void **state)
{
  (void)state;
  for (listed = FIXED; listed <= LISTED; listed++)
    for (int d = 2; d <= 3; d++) judge(sprung, d, 20);
  listed = FIXED;
}

/* In the plane turns are counted: three and a half of them, and back. */
static void test_turns(void **state)
{
  (void)state;
  nsdae_bodies *b = create(2, 0, 0, 0);
  int joint = hang(b, 2, NSDAE_JOINT_REVOLUTE, (nsdae_rigid_body){.spin = {0, 0, 10}});
  nsdae_bodies_add_limit(b, &(nsdae_limit){joint, 0, -INFINITY, 7 * pi, 1});
  ending end = run(b, NSDAE_METHOD_EVENT, 0.1, 3);
  assert_near(end.q[2], 14 * pi - 30, 1e-10);
}

/* In space the range is up to a turn, anywhere: 0 .. 6 rad, from angle 0 forth and back. */
static void test_wide(void **state)
{
  (void)state;
  nsdae_bodies *b = create(3, 0, 0, 0);
  int joint = hang(b, 3, NSDAE_JOINT_REVOLUTE, (nsdae_rigid_body){.spin = {0, 0, 4}});
  nsdae_bodies_add_limit(b, &(nsdae_limit){joint, 0, -0.1, 6, 0.5});
  ending end = run(b, NSDAE_METHOD_EVENT, 0.1, 2);
  assert_int_equal(end.impacts, 1);
  assert_near(end.last, 1.5, 1e-10);
  assert_near(angle_of(3, end.q), 5, 1e-10); /* 6 - 2 (2 - 1.5) */
}

/* ---- springs with rest */

/* Kinds with a displacement, and the mass along it: of a screw of pitch h = 0.3 m, m + J (2 pi /
 * h)^2. */
static const struct {
  int d, kind;
} sliders[] = {{2, NSDAE_JOINT_PRISMATIC},
               {2, NSDAE_JOINT_SLOT},
               {3, NSDAE_JOINT_PRISMATIC},
               {3, NSDAE_JOINT_CYLINDRICAL},
               {3, NSDAE_JOINT_SCREW}};
enum { SLIDERS = sizeof sliders / sizeof *sliders };
static int slider;

static nsdae_bodies *on_spring(double damping, double *mass)
{
  const double m = 2, J = 0.01, turn = 2 * pi / 0.3;
  int d = sliders[slider].d, kind = sliders[slider].kind;
  nsdae_bodies *b = create(d, 0, 0, 0);
  int joint = hang(b, d, kind, (nsdae_rigid_body){.mass = m, .inertia = {J, J, J}});
  nsdae_joint_spring s = {joint, .stiffness = 100, .damping = damping, .rest = 0.5};
  assert_true(nsdae_bodies_add_joint_spring(b, &s) >= 0);
  *mass = m + (kind == NSDAE_JOINT_SCREW ? J * turn * turn : 0);
  return b;
}

/* Damped, it comes to s = rest. */
static void test_rest(void **state)
{
  (void)state;
  for (slider = 0; slider < SLIDERS; slider++)
    for (int method = NSDAE_METHOD_IMPLICIT; method <= NSDAE_METHOD_EVENT; method++) {
      if (test_share() > 1 && (slider + method) % 2) continue; /* each by half of the methods */
      double mass;
      ending end = run(on_spring(20, &mass), method, 0.01, 20);
      assert_near(end.q[sliders[slider].d == 2 ? 0 : 2], 0.5, 1e-10);
    }
}

/* Without damping s = rest (1 - cos(w t)), which keeps the energy. */
static double swinging(int d, int method, double dt)
{
  const double t = 1.5, rest = 0.5;
  int axis = sliders[slider].d == 2 ? 0 : 2;
  double mass;
  nsdae_bodies *b = on_spring(0, &mass);
  ending end = run(b, method, dt, t);
  double w = sqrt(100 / mass);
  (void)d;
  return fmax(fabs(end.q[axis] - rest * (1 - cos(w * t))),
              fabs(end.v[axis] - rest * w * sin(w * t)));
}

static void test_swinging(void **state)
{
  (void)state;
  for (slider = 0; slider < SLIDERS; slider++) judge(swinging, sliders[slider].d, 100);
}

/* A spring of J w^2 in space, from s = 0 with the spin u: x = s - rest = A sin(p) with p' = w. If A
 * > pi, it turns over: p is wrapped to -p_c .. p_c with A sin(p_c) = pi. The energy J (v^2 + w^2
 * x^2) / 2 = J w^2 A^2 / 2 is that of the start. */
static double spin, rest;
static int by_torsion;

static double turning(int d, int method, double dt)
{
  const double t_end = 4, w = 1.1, stiffness = 0.5 * w * w;
  nsdae_bodies *b = create(d, 0, 0, 0);
  int joint = hang(b, d, NSDAE_JOINT_REVOLUTE, (nsdae_rigid_body){.spin = {0, 0, spin}});
  nsdae_joint_spring s = {joint, .stiffness = stiffness, .rest = rest};
  nsdae_torsion torsion = {
      .body = {NSDAE_GROUND, 0}, .axis = {0, 0, 2}, .stiffness = stiffness, .rest = rest};
  int status =
      by_torsion ? nsdae_bodies_add_torsion(b, &torsion) : nsdae_bodies_add_joint_spring(b, &s);
  assert_true(status >= 0);
  ending end = run(b, method, dt, t_end);
  double A = copysign(sqrt(rest * rest + spin * spin / (w * w)), spin);
  double p = atan2(-copysign(rest, rest * spin), fabs(spin) / w) + w * t_end;
  if (fabs(A) > pi) p = remainder(p, 2 * asin(pi / fabs(A)));
  double wrong = remainder(angle_of(d, end.q) - rest - A * sin(p), 2 * pi);
  return fmax(fabs(wrong), fabs(end.v[5] - A * w * cos(p)));
}

/* The force jumps as it turns over: event finds the place by the size of its steps alone, to its
 * local tolerance 1e-12 times the number of steps. */
static void test_turning(void **state)
{
  (void)state;
  const double rests[] = {0, 1, -2, 3};
  for (by_torsion = 0; by_torsion <= 1; by_torsion++)
    for (int i = 0; i < 4; i++)
      for (spin = -2; spin <= 5; spin += 7) {
        if (test_share() > 1 && (spin > 0) != (i + by_torsion) % 2) continue; /* one way round */
        rest = rests[i];
        if (hypot(rest, spin / 1.1) < pi) judge(turning, 3, 100);
        assert_at_most(turning(3, NSDAE_METHOD_EVENT, 0.05), 1e-8);
        for (double dt = 2e-3; dt > smallest_step(); dt /= 4) {
          assert_at_most(turning(3, NSDAE_METHOD_MOREAU, dt), 100 * dt);
          assert_at_most(turning(3, NSDAE_METHOD_IMPLICIT, dt), 100 * dt);
        }
      }
}

/* ---- damping: s' = s'(0) exp(-c t / inertia) of every coordinate */

static void decays(int d, int kind, int coordinate, nsdae_rigid_body body, int velocity)
{
  nsdae_bodies *b = create(d, 0, 0, 0);
  const double inertia[3] = {0.5, 0.5, 0.5};
  memcpy(body.inertia, inertia, sizeof inertia);
  body.mass = 0.5;
  int joint = hang(b, d, kind, body);
  nsdae_joint_spring s = {.joint = joint, .coordinate = coordinate, .damping = 0.8};
  assert_true(nsdae_bodies_add_joint_spring(b, &s) >= 0);
  double start = velocity < d ? body.velocity[velocity] : body.spin[d == 2 ? 2 : velocity - 3];
  ending end = run(b, NSDAE_METHOD_EVENT, 0.1, 1);
  assert_near(end.v[velocity], start * exp(-0.8 / 0.5), 1e-10);
}

static void test_damping(void **state)
{
  (void)state;
  const nsdae_rigid_body moved = {.velocity = {1, 0, 0}}, turned = {.spin = {0, 0, 1}};
  const nsdae_rigid_body up = {.velocity = {0, 0, 1}}, rolled = {.spin = {1, 0, 0}};
  decays(2, NSDAE_JOINT_REVOLUTE, 0, turned, 2);
  decays(2, NSDAE_JOINT_PRISMATIC, 0, moved, 0);
  decays(2, NSDAE_JOINT_SLOT, 0, moved, 0);
  decays(2, NSDAE_JOINT_SLOT, 1, turned, 2);
  decays(3, NSDAE_JOINT_REVOLUTE, 0, turned, 5);
  decays(3, NSDAE_JOINT_PRISMATIC, 0, up, 2);
  decays(3, NSDAE_JOINT_CYLINDRICAL, 0, up, 2);
  decays(3, NSDAE_JOINT_CYLINDRICAL, 1, turned, 5);
  decays(3, NSDAE_JOINT_UNIVERSAL, 0, turned, 5);
  decays(3, NSDAE_JOINT_UNIVERSAL, 1, rolled, 3);
  decays(3, NSDAE_JOINT_SPHERICAL, 0, turned, 5);
  decays(3, NSDAE_JOINT_SPHERICAL, 0, rolled, 3);
}

/* ---- screws, racks, gears */

/* A nut of 2 kg and 0.5 kg m^2 on a screw of pitch h = 0.3 m: a = g m / (m + J (2 pi / h)^2). In 4
 * s it makes several turns. */
static double screw(int d, int method, double dt)
{
  const double t = 4, h = 0.3, m = 2, J = 0.5, w = 2 * pi / h;
  nsdae_bodies *b = create(d, 0, 0, -100);
  hang(b, 3, NSDAE_JOINT_SCREW, (nsdae_rigid_body){.mass = m});
  ending end = run(b, method, dt, t);
  double a = -100 * m / (m + J * w * w);
  assert_true(fabs(a * t * t / 2) > 5 * h);
  return fmax(fabs(end.q[2] - a * t * t / 2), fabs(end.v[5] - w * a * t) / w);
}

/* A pinion of J = 0.5 and radius 0.2, a rack of 2 kg under g = 10: a = m g / (m + J / r^2). */
static double rack(int d, int method, double dt)
{
  const double t = 4, r = 0.2, m = 2, J = 0.5;
  nsdae_bodies *b = create(d, d == 2 ? 10 : 0, 0, d == 2 ? 0 : 10);
  int pinion = hang(b, d, NSDAE_JOINT_REVOLUTE, (nsdae_rigid_body){.mass = 1});
  int rail = hang(b, d, NSDAE_JOINT_PRISMATIC, (nsdae_rigid_body){.mass = m});
  nsdae_coupler c = {.joint = {pinion, rail}, .p = {0, r}};
  assert_int_equal(nsdae_bodies_add_coupler(b, &c), 0);
  ending end = run(b, method, dt, t);
  double a = m * 10 / (m + J / (r * r));
  assert_true(a * t * t / 2 / r > 20); /* several turns */
  int nq = d == 2 ? 3 : 7;
  return fmax(fabs(end.q[nq + (d == 2 ? 0 : 2)] - a * t * t / 2),
              fabs(end.v[d == 2 ? 2 : 5] - a * t / r));
}

static int torque(double t, const double x[3], const double v[3], double force[3], double moment[3],
                  void *user)
{
  (void)t, (void)x, (void)v, (void)force, (void)user;
  moment[2] = 2;
  return 0;
}

/* Two gears of 0.5 and 0.8 kg m^2 with 21 and 30 teeth, a torque on the first: alpha = T / (J_0 +
 * (21/30)^2 J_1). */
static double gears(int d, int method, double dt)
{
  const double t = 4, ratio = -21. / 30;
  nsdae_bodies *b = create(d, 0, 0, 0);
  const double origin[3] = {0, 0, 0};
  int first = hang(b, d, NSDAE_JOINT_REVOLUTE, (nsdae_rigid_body){.mass = 1});
  int second =
      hang(b, d, NSDAE_JOINT_REVOLUTE, (nsdae_rigid_body){.mass = 1, .inertia = {1, 1, 0.8}});
  nsdae_bodies_add_load(b, 0, origin, torque, NULL);
  nsdae_coupler c = {.joint = {first, second}, .p = {0, ratio}};
  assert_int_equal(nsdae_bodies_add_coupler(b, &c), 0);
  ending end = run(b, method, dt, t);
  double alpha = 2 / (0.5 + ratio * ratio * 0.8), angle = ratio * alpha * t * t / 2;
  int nq = d == 2 ? 3 : 7, nv = d == 2 ? 3 : 6;
  double error = remainder(angle_of(d, end.q + nq) - angle, 2 * pi);
  return fmax(fabs(error), fabs(end.v[nv + (d == 2 ? 2 : 5)] - ratio * alpha * t));
}

static void test_couplers(void **state)
{
  (void)state;
  judge(screw, 3, 10);
  for (int d = 2; d <= 3; d++) {
    judge(rack, d, 100);
    judge(gears, d, 100);
  }
}

/* Screw and rack in space, with the points at the centres of the bodies, turn by 0.2 rad in a step.
 * The drift is projected to 1e-4 of the displacement per radian. */
static void test_drift(void **state)
{
  (void)state;
  const double w = 20, r = 0.2, h = 0.3;
  for (int method = NSDAE_METHOD_IMPLICIT; method <= NSDAE_METHOD_MOREAU;
       method += NSDAE_METHOD_MOREAU - NSDAE_METHOD_IMPLICIT) {
    nsdae_bodies *b = create(3, 0, 0, 0);
    double up = w * h / (2 * pi);
    hang(b, 3, NSDAE_JOINT_SCREW, (nsdae_rigid_body){.spin = {0, 0, w}, .velocity = {0, 0, up}});
    ending end = run(b, method, 0.01, 10);
    assert_at_most(end.drift, 1e-4 * h / (2 * pi));
    b = create(3, 0, 0, 0);
    int pinion = hang(b, 3, NSDAE_JOINT_REVOLUTE, (nsdae_rigid_body){.spin = {0, 0, w}});
    int rail = hang(b, 3, NSDAE_JOINT_PRISMATIC, (nsdae_rigid_body){.velocity = {0, 0, w * r}});
    nsdae_coupler c = {.joint = {pinion, rail}, .p = {0, r}};
    assert_int_equal(nsdae_bodies_add_coupler(b, &c), 0);
    end = run(b, method, 0.01, 10);
    assert_at_most(end.drift, 1e-4 * r);
  }
}

/* Two sliders along x and y (along z) with s_1 = s_0 + 2 s_0^2 - s_0^3: the energy (m_0 + m_1 p'^2)
 * s_0'^2 / 2 and the relation stay. */
static void test_polynomial(void **state)
{
  (void)state;
  nsdae_bodies *b = create(2, 0, 0, 0);
  nsdae_bodies_add(b, &(nsdae_rigid_body){.mass = 2, .inertia = {0, 0, 1}, .velocity = {1}});
  nsdae_bodies_add(b, &(nsdae_rigid_body){.mass = 3, .inertia = {0, 0, 1}, .velocity = {0, 1}});
  for (int i = 0; i < 2; i++)
    nsdae_bodies_add_joint(b, &(nsdae_joint){.kind = NSDAE_JOINT_PRISMATIC,
                                             .body = {NSDAE_GROUND, i},
                                             .axis = {i == 0, i == 1}});
  nsdae_bodies_add_coupler(b, &(nsdae_coupler){.joint = {0, 1}, .p = {0, 1, 2, -1}});
  ending end = run(b, NSDAE_METHOD_EVENT, 0.1, 1.5);
  double s = end.q[0], slope = 1 + 4 * s - 3 * s * s;
  assert_near(end.q[4], s + 2 * s * s - s * s * s, 1e-10);
  assert_near(end.v[4], slope * end.v[0], 1e-10);
  assert_near((2 + 3 * slope * slope) * end.v[0] * end.v[0], 5, 1e-9);
  assert_true(s > 0.3);
}

/* ---- ropes */

/* A mass falls from (0.6, 0) on a rope of 1 m at the origin: taut at y = -0.8, the radial velocity
 * is lost, then it is a pendulum. theta'' = -g sin theta (theta from the vertical) is integrated
 * here by Runge and Kutta's method of order 4. */
static double rope(int d, int method, double dt)
{
  const double g = 10, taut = sqrt(2 * 0.8 / g), t_end = 1;
  nsdae_bodies *b = create(d, 0, -g, 0);
  nsdae_bodies_add(b, &(nsdae_rigid_body){.mass = 2, .inertia = {1, 1, 1}, .position = {0.6}});
  nsdae_rope r = {.body = {NSDAE_GROUND, 0}, .end = {0.6}, .length = 1};
  assert_int_equal(nsdae_bodies_add_rope(b, &r), 0);
  make_list(b);
  ending end = run(b, method, dt, t_end);
  if (method == NSDAE_METHOD_EVENT) assert_near(end.last, taut, 1e-10);
  /* at (sin, -cos) the velocity (0, -g t) has the tangential part -g t sin */
  double y[2] = {atan2(0.6, 0.8), -g * taut * 0.6}, h = (t_end - taut) / 20000;
  for (int i = 0; i < 20000; i++) {
    double k[5][2] = {{0}}, sum[2] = {0, 0};
    for (int j = 1; j <= 4; j++) {
      double c = j == 1 ? 0 : j == 4 ? h : h / 2;
      k[j][0] = y[1] + c * k[j - 1][1];
      k[j][1] = -g * sin(y[0] + c * k[j - 1][0]);
      for (int l = 0; l < 2; l++) sum[l] += k[j][l] * (j == 2 || j == 3 ? 2 : 1) / 6;
    }
    for (int l = 0; l < 2; l++) y[l] += h * sum[l];
  }
  return fmax(fmax(fabs(end.q[0] - sin(y[0])), fabs(end.q[1] + cos(y[0]))),
              fabs(end.v[0] - cos(y[0]) * y[1]));
}

static void test_rope(void **state)
{
  (void)state;
  for (listed = FIXED; listed <= LISTED; listed++)
    for (int d = 2; d <= 3; d++) judge(rope, d, 20);
  listed = FIXED;
}

/* A rope whose ends coincide at the start has no direction, and needs none. */
static void test_slack(void **state)
{
  (void)state;
  for (int d = 2; d <= 3; d++) {
    nsdae_bodies *b = create(d, 0, -10, 0);
    nsdae_bodies_add(b, &(nsdae_rigid_body){.mass = 2, .inertia = {1, 1, 1}});
    nsdae_bodies_add_rope(b, &(nsdae_rope){.body = {NSDAE_GROUND, 0}, .length = 5, .e_n = 1});
    ending end = run(b, NSDAE_METHOD_EVENT, 0.1, 1.5);
    assert_near(end.last, 1, 1e-10);
    assert_near(end.q[1], -5 + 10 * 0.5 - 1.25, 1e-9);
  }
}

/* ---- beside contacts with friction: fixed and listed are the same numbers */

/* A box slides on a floor, with an arm that has limits, a motor and a rope. */
static ending slide(int d, int method, int by_list)
{
  static const double corners[] = {-0.5, -0.2, 0.5, -0.2, 0.5, 0.2, -0.5, 0.2};
  nsdae_bodies *b = create(d, 0, d == 2 ? -9.81 : 0, d == 3 ? -9.81 : 0);
  nsdae_rigid_body box = {.mass = 5, .inertia = {0.4, 0.5, 0.6}, .velocity = {1}};
  nsdae_rigid_body arm = {
      .mass = 1, .inertia = {0.1, 0.1, 0.1}, .position = {0.5}, .velocity = {1}};
  nsdae_joint hinge = {.kind = NSDAE_JOINT_REVOLUTE, .body = {0, 1}, .axis = {0, d == 3, 0}};
  nsdae_rope rope = {.body = {NSDAE_GROUND, 1}, .end = {0.5}, .length = 1.1};
  box.position[d - 1] = 0.2;
  arm.position[d - 1] = hinge.point[d - 1] = rope.end[d - 1] = 0.6;
  rope.point[d - 1] = 1.5;
  nsdae_bodies_add(b, &box);
  nsdae_bodies_add(b, &arm);
  int joint = nsdae_bodies_add_joint(b, &hinge);
  nsdae_bodies_add_limit(b, &(nsdae_limit){joint, 0, -0.8, 0.8, 0.4});
  nsdae_bodies_add_motor(
      b, &(nsdae_motor){joint, .kind = NSDAE_MOTOR_SPEED, .limit = 0.7, .target = 0.3});
  nsdae_bodies_add_rope(b, &rope);
  nsdae_solid solid = {.shape = d == 2 ? NSDAE_SHAPE_POLYGON : NSDAE_SHAPE_BOX,
                       .length = {1, 0.6, 0.4},
                       .points = 4,
                       .point = corners};
  nsdae_solid plane = {.shape = NSDAE_SHAPE_PLANE, .material = 1};
  int first = nsdae_bodies_add_solid(b, 0, &solid);
  int second = nsdae_bodies_add_solid(b, NSDAE_GROUND, &plane);
  if (by_list)
    nsdae_bodies_set_pair(b, 0, 1, 0.3, 0, 0);
  else
    nsdae_bodies_add_contact(b, second, first, 0.3, 0, 0);
  return run(b, method, 2e-3, 0.6);
}

static void test_beside_friction(void **state)
{
  (void)state;
  for (int d = 2; d <= 3; d++)
    for (int method = NSDAE_METHOD_IMPLICIT; method <= NSDAE_METHOD_MOREAU; method++) {
      ending fixed = slide(d, method, 0), by_list = slide(d, method, 1);
      assert_true(fixed.impacts > 0);
      for (int i = 0; i < 2 * (d == 2 ? 3 : 7); i++) assert_near(by_list.q[i], fixed.q[i], 1e-12);
    }
}

/* A box that slides on a floor with an arm that rattles on its limit, until both are at rest: where
 * the box is then. */
static double arm(int method, double rtol)
{
  static double corners[] = {-0.5, -0.2, 0.5, -0.2, 0.5, 0.2, -0.5, 0.2};
  nsdae_bodies *b = create(2, 0, -9.81, 0);
  nsdae_rigid_body box = {.mass = 5, .inertia = {0, 0, 0.6}, .position = {0, 0.2}, .velocity = {1}};
  nsdae_rigid_body bar = {
      .mass = 1, .inertia = {0, 0, 0.1}, .position = {0.5, 0.6}, .velocity = {1}};
  nsdae_bodies_add(b, &box);
  nsdae_bodies_add(b, &bar);
  int joint = nsdae_bodies_add_joint(
      b, &(nsdae_joint){.kind = NSDAE_JOINT_REVOLUTE, .body = {0, 1}, .point = {0, 0.6}});
  nsdae_bodies_add_limit(b, &(nsdae_limit){joint, 0, -0.8, 0.8, 0.4});
  nsdae_bodies_add_solid(
      b, 0, &(nsdae_solid){.shape = NSDAE_SHAPE_POLYGON, .points = 4, .point = corners});
  nsdae_bodies_add_solid(b, -1, &(nsdae_solid){.shape = NSDAE_SHAPE_PLANE, .material = 1});
  nsdae_bodies_add_contact(b, 1, 0, 0.3, 0, 0);
  nsdae_system *system;
  nsdae_sim *sim;
  nsdae_sim_options o;
  nsdae_record r;
  double q[6], v[6];
  if (nsdae_bodies_system(b, &system) < 0) fail_msg("%s", nsdae_bodies_error(b)->text);
  nsdae_bodies_get_start(b, q, v);
  nsdae_sim_options_default(&o);
  o.method = method;
  o.dt = method == NSDAE_METHOD_EVENT ? 0.05 : 1e-4; /* of event: of the records */
  o.rtol = rtol;
  o.atol = rtol / 100;
  assert_int_equal(nsdae_sim_create(system, &o, &sim, NULL), NSDAE_OK);
  int status = nsdae_sim_init(sim, 0, q, v);
  if (status >= 0) status = nsdae_sim_run(sim, 1);
  if (status < 0) fail_msg("rtol %g: %s", rtol, nsdae_sim_error(sim)->text);
  nsdae_sim_get_record(sim, &r);
  for (int i = 0; i < 6; i++) assert_near(r.v[i], 0, 1e-6);
  double x = r.q[0];
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  nsdae_bodies_destroy(&b);
  return x;
}

/* Slips that turn within the tolerance of what rattles are located at every rtol. */
static void test_rattling(void **state)
{
  (void)state;
  double x = arm(NSDAE_METHOD_EVENT, 1e-10);
  if (test_share() > 1) {
    assert_near(arm(NSDAE_METHOD_EVENT, 1e-7), x, 1e-6);
    return;
  }
  for (double rtol = 1e-9; rtol < 2e-6; rtol *= 10)
    assert_near(arm(NSDAE_METHOD_EVENT, rtol), x, 1e-6);
  assert_near(arm(NSDAE_METHOD_IMPLICIT, 1e-6), x, 1e-3);
}

/* ---- starts that do not fit: refused by name and distance */

static void refused(int method, double x, double angle, const char *words)
{
  nsdae_system *system;
  nsdae_sim *sim;
  nsdae_sim_options o;
  nsdae_bodies *b = create(2, 0, 0, 0);
  int joint = hang(b, 2, NSDAE_JOINT_REVOLUTE, (nsdae_rigid_body){.position = {1}});
  nsdae_bodies_add_limit(b, &(nsdae_limit){joint, 0, -1, 1, 0.5});
  assert_true(nsdae_bodies_system(b, &system) >= 0);
  nsdae_sim_options_default(&o);
  o.method = method;
  assert_int_equal(nsdae_sim_create(system, &o, &sim, NULL), NSDAE_OK);
  double q[3] = {cos(angle) + x, sin(angle), angle}, v[3] = {0, 0, 0};
  assert_int_equal(nsdae_sim_init(sim, 0, q, v), NSDAE_E_ARGUMENT);
  if (!strstr(nsdae_sim_error(sim)->text, words)) fail_msg("%s", nsdae_sim_error(sim)->text);
  assert_int_equal(nsdae_sim_project(sim, 0, q, v), NSDAE_OK);
  assert_int_equal(nsdae_sim_init(sim, 0, q, v), NSDAE_OK);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  nsdae_bodies_destroy(&b);
}

static void test_starts(void **state)
{
  (void)state;
  refused(NSDAE_METHOD_IMPLICIT, 0.01, 0.5,
          "(revolute joint 0 of body 0 and the ground) is violated by 0.01 ");
  refused(NSDAE_METHOD_EVENT, 0, 1.25,
          "(high limit 1 of revolute joint 0 of body 0 and the ground) overlaps by 0.25 ");
  refused(NSDAE_METHOD_EVENT, 0, -1.5,
          "(low limit 0 of revolute joint 0 of body 0 and the ground) overlaps by 0.5 ");
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_bouncing),   cmocka_unit_test(test_sprung),
      cmocka_unit_test(test_turns),      cmocka_unit_test(test_wide),
      cmocka_unit_test(test_damping),    cmocka_unit_test(test_rest),
      cmocka_unit_test(test_swinging),   cmocka_unit_test(test_turning),
      cmocka_unit_test(test_drift),      cmocka_unit_test(test_couplers),
      cmocka_unit_test(test_polynomial), cmocka_unit_test(test_rope),
      cmocka_unit_test(test_slack),      cmocka_unit_test(test_beside_friction),
      cmocka_unit_test(test_rattling),   cmocka_unit_test(test_starts)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
