/* Bodies that turn by up to 1.5 rad per step by moreau, against invariants: a free body keeps
 * w^T J w and |J w|; contacts take energy; a rotor on a hinge keeps its speed. By every
 * time-stepping method: a wheel turns by its rate times the time, quaternions have length 1. */
#include "check.h"

#include <stdlib.h>
#include <string.h>

#include <nsdae/nsdae.h>

#include "random.h"

static const double density = 1000;

static const nsdae_solid box = {
    .shape = NSDAE_SHAPE_BOX, .length = {0.3, 0.1, 0.02}, .material = 1};
static const nsdae_solid plate = {
    .shape = NSDAE_SHAPE_CYLINDER, .radius = 0.1, .length = {0, 0, 0.002}, .material = 1};

typedef struct run {
  nsdae_bodies *bodies;
  nsdae_system *system;
  nsdae_sim *sim;
  nsdae_record record;
} run;

/* body: with mass and inertia of the solid. */
static run make(const nsdae_solid *solid, nsdae_rigid_body *body, double g)
{
  const double gravity[3] = {0, 0, -g};
  run r;
  nsdae_solid own = *solid;
  assert_int_equal(nsdae_body_from_solids(1, &own, &density, body, NULL), NSDAE_OK);
  assert_int_equal(nsdae_bodies_create(3, &r.bodies, NULL), NSDAE_OK);
  nsdae_bodies_set_gravity(r.bodies, gravity);
  assert_int_equal(nsdae_bodies_add(r.bodies, body), 0);
  return r;
}

static void begin_by(run *r, int method, double dt)
{
  nsdae_sim_options o;
  nsdae_error error;
  double q[7], v[6];
  nsdae_sim_options_default(&o);
  o.method = method;
  o.dt = dt;
  o.start_tol = 1; /* some begin deep in each other */
  if (nsdae_bodies_system(r->bodies, &r->system) < 0)
    fail_msg("%s", nsdae_bodies_error(r->bodies)->text);
  nsdae_bodies_get_start(r->bodies, q, v);
  if (nsdae_sim_create(r->system, &o, &r->sim, &error) < 0) fail_msg("%s", error.text);
  if (nsdae_sim_init(r->sim, 0, q, v) < 0) fail_msg("%s", nsdae_sim_error(r->sim)->text);
  nsdae_sim_get_record(r->sim, &r->record);
}

static void begin(run *r, double dt)
{
  begin_by(r, NSDAE_METHOD_MOREAU, dt);
}

static void step(run *r)
{
  if (nsdae_sim_step(r->sim) < 0) fail_msg("%s", nsdae_sim_error(r->sim)->text);
  nsdae_sim_get_record(r->sim, &r->record);
}

static void end(run *r)
{
  nsdae_sim_destroy(&r->sim);
  nsdae_system_destroy(&r->system);
  nsdae_bodies_destroy(&r->bodies);
}

static double momentum(const double *J, const double *w)
{
  return sqrt(pow(J[0] * w[0], 2) + pow(J[1] * w[1], 2) + pow(J[2] * w[2], 2));
}

/* w_x + i w_y turns by (C - A) / A w_z: by the midpoint rule 2 atan(h/2 of it) in a step. */
static void test_symmetric_top(void **state)
{
  double off[2];
  (void)state;
  for (int k = 0; k < 2; k++) {
    const double dt = 4e-3 / (k + 1), spin = 20, t = 2;
    nsdae_rigid_body body = {.spin = {3, 0, spin}};
    run r = make(&plate, &body, 0);
    begin(&r, dt);
    for (int i = 0; i < (int)lround(t / dt); i++) step(&r);
    double rate = (body.inertia[2] - body.inertia[0]) / body.inertia[0] * spin;
    off[k] = hypot(r.record.v[3] - 3 * cos(rate * t), r.record.v[4] - 3 * sin(rate * t));
    assert_near(r.record.v[5], spin, 1e-10);
    end(&r);
  }
  print_message("symmetric top: off by %.2e, %.2e rad/s\n", off[0], off[1]);
  assert_true(off[1] < 0.27 * off[0] && off[0] < 0.1);
}

/* About its middle axis a body turns over again and again (Poinsot). */
static void test_free_body(void **state)
{
  const struct {
    const nsdae_solid *solid;
    double spin[3], dt;
    int steps;
  } cases[] = {{&box, {0.01, 10, 0.01}, 1e-2, 100000}, {&plate, {90, 0, 300}, 5e-3, 20000}};
  (void)state;
  for (int c = 0; c < 2; c++) {
    nsdae_rigid_body body = {.spin = {cases[c].spin[0], cases[c].spin[1], cases[c].spin[2]}};
    run r = make(cases[c].solid, &body, 0);
    begin(&r, cases[c].dt);
    double energy = r.record.kinetic, L = momentum(body.inertia, r.record.v + 3), most = 0;
    int overs = 0;
    for (int i = 0; i < cases[c].steps; i++) {
      double before = r.record.v[4];
      step(&r);
      overs += c == 0 && before * r.record.v[4] < 0;
      most = fmax(most, fabs(r.record.kinetic / energy - 1));
      most = fmax(most, fabs(momentum(body.inertia, r.record.v + 3) / L - 1));
    }
    print_message("free body %d: invariants change by %.1e, turned over %d times\n", c, most,
                  overs);
    assert_true(most < 1e-7); /* steps times iteration_tol */
    assert_true(c > 0 || overs > 50);
    end(&r);
  }
}

/* With u of the step without contacts, contacts with e = 0 leave T_1 <= T_u - |v_1 - u|^2 / 2, and
 * gravity did m g h (u - v_1)_z / 2 more than the potential shows: E rises by at most
 * m (g h)^2 / 8 in a step. */
static void test_dropped(void **state)
{
  const double g = 9.81, dt = 5e-3;
  double most = 0;
  (void)state;
  for (uint64_t n = 0; n < 216; n++) {
    uint64_t seed = n + 1;
    const int kind = (int)(n % 6), form = (int)(n / 6 % 3);
    const double length[3][3] = {{0.2, 0.2, 0.002}, {0.2, 0.2, 0.02}, {0.01, 0.01, 0.4}},
                 *a = length[form], spin = n / 18 % 2 ? 20 : 300, mu = (double)(n / 36 % 3) / 2;
    static const int shapes[6] = {NSDAE_SHAPE_ELLIPSOID, NSDAE_SHAPE_CYLINDER,
                                  NSDAE_SHAPE_CONE,      NSDAE_SHAPE_BOX,
                                  NSDAE_SHAPE_DISC,      NSDAE_SHAPE_POLYHEDRON};
    double point[24];
    for (int j = 0; j < 24; j++)
      point[j] = a[j % 3] * (j / 3 >> j % 3 & 1 ? random_between(&seed, 0.3, 0.5)
                                                : random_between(&seed, -0.5, -0.3));
    nsdae_solid solid = {.shape = shapes[kind], .material = 1};
    if (kind == 1 || kind == 2 || kind == 4) solid.radius = a[0] / 2;
    for (int j = 0; j < 3; j++)
      solid.length[j] = kind == 5 || kind == 4 || (solid.radius > 0 && j < 2) ? 0 : a[j];
    if (kind == 5) solid.points = 8, solid.point = point;
    nsdae_rigid_body body = {.position = {0, 0, 0.25}};
    for (int j = 0; j < 4; j++) body.quaternion[j] = random_between(&seed, -1, 1);
    for (int j = 0; j < 3; j++) body.spin[j] = random_between(&seed, -spin, spin);
    /* a disc has no volume: that of a thin cylinder */
    nsdae_solid heavy = solid;
    if (kind == 4) heavy.shape = NSDAE_SHAPE_CYLINDER, heavy.length[2] = 1e-3;
    run r = make(&heavy, &body, g);
    nsdae_bodies_add_solid(r.bodies, NSDAE_GROUND, &(nsdae_solid){.shape = NSDAE_SHAPE_PLANE});
    assert_true(nsdae_bodies_add_solid(r.bodies, 0, &solid) >= 0);
    nsdae_bodies_set_pair(r.bodies, 0, 1, mu, 0, 0);
    begin(&r, dt);
    double bound = body.mass * pow(g * dt, 2) / 8, scale = r.record.kinetic + r.record.potential;
    for (int i = 0; i < 150; i++) {
      double before = r.record.kinetic + r.record.potential - r.record.projection_energy;
      step(&r);
      double rise = r.record.kinetic + r.record.potential - r.record.projection_energy - before;
      most = fmax(most, rise / bound);
      if (rise > bound + 1e-9 * scale)
        fail_msg("body %d: the energy rises by %g J, bound %g J, at %g s", (int)n, rise, bound,
                 r.record.time);
    }
    end(&r);
  }
  print_message("dropped: the energy rises by at most %.2f of m (g h)^2 / 8 in a step\n", most);
}

/* About an axis that is none of its inertia J w x w is balanced by the hinge. */
static void test_rotor(void **state)
{
  (void)state;
  nsdae_rigid_body body = {.spin = {30, 30, 30}};
  run r = make(&box, &body, 0);
  const nsdae_joint hinge = {
      .kind = NSDAE_JOINT_REVOLUTE, .body = {NSDAE_GROUND, 0}, .axis = {1, 1, 1}};
  assert_int_equal(nsdae_bodies_add_joint(r.bodies, &hinge), 0);
  begin(&r, 1e-2);
  double energy = r.record.kinetic;
  for (int i = 0; i < 1000; i++) step(&r);
  assert_near(r.record.kinetic / energy, 1, 1e-10);
  end(&r);
}

/* A symmetric body on a ball joint at its centre keeps the energy J (w_1^2 + w_2^2) / 2 across its
 * spin. moreau takes its gyroscopic term by Euler's rule: each step multiplies it by 1 +
 * (Omega h)^2. As soon as it is wrong by a tenth the run says so, by omega dt; the other methods
 * have no such error. Seeded: needles and plates, slow and fast. */
static void test_across_the_spin(void **state)
{
  enum { TOPS = 140, STEPS = 400 };
  static const int by[] = {NSDAE_METHOD_MOREAU, NSDAE_METHOD_IMPLICIT, NSDAE_METHOD_EVENT};
  const char *text = getenv("NSDAE_SEED");
  uint64_t seed = text ? strtoull(text, NULL, 10) : 5;
  int wrong = 0, count = share_of(TOPS);
  (void)state;
  for (int k = 0; k < count; k++) {
    const double J = 0.1, ratio = random_between(&seed, 0.01, 1.9), h = 1e-3;
    const double spin = pow(10, random_between(&seed, 0, 2)), tilt = random_between(&seed, 0.1, 2);
    for (int m = 0; m < 3; m++) {
      nsdae_bodies *b;
      nsdae_system *system;
      nsdae_sim *sim;
      nsdae_sim_options o;
      nsdae_record r;
      double q[7], v[6];
      int status = NSDAE_OK;
      assert_int_equal(nsdae_bodies_create(3, &b, NULL), NSDAE_OK);
      nsdae_bodies_add(
          b, &(nsdae_rigid_body){.mass = 1, .inertia = {J, J, ratio * J}, .spin = {tilt, 0, spin}});
      nsdae_bodies_add_joint(
          b, &(nsdae_joint){.kind = NSDAE_JOINT_SPHERICAL, .body = {NSDAE_GROUND, 0}});
      assert_int_equal(nsdae_bodies_system(b, &system), NSDAE_OK);
      nsdae_bodies_get_start(b, q, v);
      nsdae_sim_options_default(&o);
      o.method = by[m];
      o.dt = h;
      assert_int_equal(nsdae_sim_create(system, &o, &sim, NULL), NSDAE_OK);
      assert_int_equal(nsdae_sim_init(sim, 0, q, v), NSDAE_OK);
      for (int i = 0; i < STEPS && status == NSDAE_OK; i++) status = nsdae_sim_step(sim);
      nsdae_sim_get_record(sim, &r);
      double grown = (r.v[3] * r.v[3] + r.v[4] * r.v[4]) / (tilt * tilt) - 1;
      if (status != NSDAE_OK) {
        const nsdae_error *said = nsdae_sim_error(sim);
        if (m > 0 || !strstr(said->text, "body 0 has omega dt = ")) fail_msg("%s", said->text);
        assert_int_equal(status, NSDAE_WARN_ENERGY);
        assert_true(grown > 0.1 && said->index == 0);
        wrong++;
      }
      /* a gain is seen when it is a tenth of what is there then, after the step that makes it */
      double once = fabs(ratio - 1) * spin * h;
      assert_true(status == NSDAE_OK ? fabs(grown) < 1 / 0.9 - 1 + once * once
                                     : grown < (1 / 0.9) * (1 + once * once) * (1 + once * once));
      nsdae_sim_destroy(&sim);
      nsdae_system_destroy(&system);
      nsdae_bodies_destroy(&b);
    }
  }
  assert_true(wrong > 0 && wrong < count);
}

static double length_of(const double *p)
{
  return sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2] + p[3] * p[3]);
}

static const int time_stepping[] = {NSDAE_METHOD_IMPLICIT, NSDAE_METHOD_IMPLICIT_PRINTED,
                                    NSDAE_METHOD_MOREAU};

/* On a hinge through its axis and without forces it turns by w t, whatever the angle of a step. */
static void test_wheel(void **state)
{
  const double dt = 5e-3, rates[] = {40, 100, 400, 1000, 3000};
  (void)state;
  for (int k = 0; k < 3; k++)
    for (int l = 0; l < 5; l++) {
      nsdae_rigid_body body = {.spin = {0, 0, rates[l]}};
      run r = make(&plate, &body, 0);
      const nsdae_joint hinge = {
          .kind = NSDAE_JOINT_REVOLUTE, .body = {NSDAE_GROUND, 0}, .axis = {0, 0, 1}};
      assert_int_equal(nsdae_bodies_add_joint(r.bodies, &hinge), 0);
      begin_by(&r, time_stepping[k], dt);
      for (int i = 0; i < 200; i++) step(&r);
      double angle = rates[l] * r.record.time;
      assert_near(r.record.q[3], cos(angle / 2), 1e-10);
      assert_near(r.record.q[6], sin(angle / 2), 1e-10);
      end(&r);
    }
}

/* An axisymmetric body without forces: precession about its momentum L = J w with the rate |L| / A,
 * and rotation about its axis by (1 - C / A) w_z:
 *
 *   p(t) = exp(t L / (2 A)) exp(t (1 - C / A) w_z e_z / 2)
 *
 * Returns the error of p after 1 s, |p - p(t)|; its length is 1. */
static double error_of_top(int method, double dt)
{
  nsdae_rigid_body body = {.spin = {3, 0, 20}};
  run r = make(&plate, &body, 0);
  const double *J = body.inertia, t = 1, L[2] = {J[0] * 3, J[2] * 20};
  begin_by(&r, method, dt);
  double size = sqrt(L[0] * L[0] + L[1] * L[1]), a = t * size / J[0] / 2,
         b = t * (1 - J[2] / J[0]) * 20 / 2, sum = 0;
  const double x = sin(a) * L[0] / size, z = sin(a) * L[1] / size, c = cos(a);
  const double p[4] = {c * cos(b) - z * sin(b), x * cos(b), -x * sin(b), z * cos(b) + c * sin(b)};
  for (int i = 0; i < (int)(t / dt + 0.5); i++) {
    step(&r);
    assert_near(length_of(r.record.q + 3), 1, 1e-13);
  }
  for (int i = 0; i < 4; i++) sum += pow(r.record.q[3 + i] - p[i], 2);
  end(&r);
  return sqrt(sum);
}

static void test_order(void **state)
{
  (void)state;
  for (int k = 0; k < 3; k++) {
    double coarse = error_of_top(time_stepping[k], 2e-3),
           fine = error_of_top(time_stepping[k], 1e-3);
    print_message("%d: errors %.2g, %.2g\n", k, coarse, fine);
    assert_near(coarse / fine, 4, 0.2);
  }
}

static int unit_masses(double t, const double *q, double *M, int ldm, void *user)
{
  (void)t, (void)q, (void)user;
  for (int i = 0; i < 4; i++) M[i * (ldm + 1)] = 1;
  return 0;
}

static int no_force(double t, const double *q, const double *v, double *F, void *user)
{
  (void)t, (void)q, (void)v, (void)F, (void)user;
  return 0;
}

/* q = (c, p_w, s, p_x, p_y, p_z):  (c, s)' = v_0 (2 + c) (-s, c),  p' = (0, w) p / 2,  w = (v_1,
 * v_2, v_3) in the axes of space */
static int circle_and_rotation(double t, const double *q, const double *v, double *qdot, void *user)
{
  const double rate = v[0] * (2 + q[0]);
  (void)t, (void)user;
  qdot[0] = -q[2] * rate;
  qdot[2] = q[0] * rate;
  qdot[1] = -(v[1] * q[3] + v[2] * q[4] + v[3] * q[5]) / 2;
  qdot[3] = (v[1] * q[1] + v[2] * q[5] - v[3] * q[4]) / 2;
  qdot[4] = (v[2] * q[1] + v[3] * q[3] - v[1] * q[5]) / 2;
  qdot[5] = (v[3] * q[1] + v[1] * q[4] - v[2] * q[3]) / 2;
  return 0;
}

/* The error after 0.5 s of the point on the circle, tan(angle / 2) = 3^(1/2) tan(3^(1/2) t / 2);
 * that of the rotation is none: p = (cos(|w| t / 2), sin(|w| t / 2) w / |w|). */
static double error_of_circle(int method, double dt)
{
  const nsdae_dims dims = {.nq = 6, .nv = 4};
  const double q[6] = {1, 1}, v[4] = {1, 20, 40, -40}, w = 60, t = 0.5;
  nsdae_system *system;
  nsdae_sim_options o;
  nsdae_sim *sim;
  nsdae_record now;
  assert_int_equal(nsdae_system_create(&dims, &system, NULL), NSDAE_OK);
  nsdae_system_set_mass(system, unit_masses);
  nsdae_system_set_kinematics(system, circle_and_rotation);
  nsdae_system_set_force(system, no_force);
  nsdae_sim_options_default(&o);
  o.method = method;
  o.dt = dt;
  o.start_tol = 1; /* some begin deep in each other */
  nsdae_error error;
  if (nsdae_sim_create(system, &o, &sim, &error) < 0) fail_msg("%s", error.text);
  assert_int_equal(nsdae_sim_init(sim, 0, q, v), NSDAE_OK);
  assert_true(nsdae_sim_run(sim, t) >= 0);
  nsdae_sim_get_record(sim, &now);
  double angle = 2 * atan(sqrt(3) * tan(sqrt(3) / 2 * t)), off = atan2(now.q[2], now.q[0]) - angle;
  assert_near(hypot(now.q[0], now.q[2]), 1, 1e-13);
  assert_near(now.q[1], cos(w * t / 2), 1e-11);
  for (int i = 0; i < 3; i++) assert_near(now.q[3 + i], sin(w * t / 2) * v[1 + i] / w, 1e-11);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  return fabs(off);
}

/* Of second order; moreau of first, as H is that of q_0, then that of q_m. */
static void test_kinematics(void **state)
{
  (void)state;
  for (int k = 0; k < 3; k++) {
    double coarse = error_of_circle(time_stepping[k], 5e-3),
           fine = error_of_circle(time_stepping[k], 2.5e-3);
    print_message("%d: errors %.2g, %.2g\n", k, coarse, fine);
    assert_near(coarse / fine, time_stepping[k] == NSDAE_METHOD_MOREAU ? 2 : 4, 0.1);
  }
}

/* v' = (b 1 + a X) v with a^2 + b^2 > 1: |F v| overflows before v^T v does, with both signs. */
static int unit_mass(double t, const double *q, double *M, int ldm, void *user)
{
  (void)t, (void)q, (void)user;
  M[0] = M[ldm + 1] = 1;
  return 0;
}

static int growing_force(double t, const double *q, const double *v, double *F, void *user)
{
  const double a = 1000, b = 500;
  (void)t, (void)q, (void)user;
  F[0] = b * v[0] + a * v[1];
  F[1] = b * v[1] - a * v[0];
  return 0;
}

static void test_overflow(void **state)
{
  const nsdae_dims dims = {.nq = 2, .nv = 2};
  const double q[2] = {0}, v[2] = {1};
  nsdae_system *system;
  nsdae_sim_options o;
  nsdae_sim *sim;
  int status = NSDAE_OK;
  (void)state;
  assert_int_equal(nsdae_system_create(&dims, &system, NULL), NSDAE_OK);
  nsdae_system_set_mass(system, unit_mass);
  nsdae_system_set_force(system, growing_force);
  nsdae_sim_options_default(&o);
  o.method = NSDAE_METHOD_MOREAU;
  o.dt = 0.01;
  assert_int_equal(nsdae_sim_create(system, &o, &sim, NULL), NSDAE_OK);
  assert_int_equal(nsdae_sim_init(sim, 0, q, v), NSDAE_OK);
  for (int i = 0; i < 200 && status >= 0; i++) status = nsdae_sim_step(sim);
  const char *text = nsdae_sim_error(sim)->text;
  print_message("%s\n", text);
  assert_int_equal(status, NSDAE_E_NONFINITE);
  assert_non_null(strstr(text, "work of the forces overflows"));
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_symmetric_top),  cmocka_unit_test(test_free_body),
      cmocka_unit_test(test_dropped),        cmocka_unit_test(test_rotor),
      cmocka_unit_test(test_wheel),          cmocka_unit_test(test_order),
      cmocka_unit_test(test_kinematics),     cmocka_unit_test(test_overflow),
      cmocka_unit_test(test_across_the_spin)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
