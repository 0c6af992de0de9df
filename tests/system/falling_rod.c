/* The sliding and falling rod against the acceleration problem of its sliding end, inside and
 * outside Painleve's paradox, and against what energy and momentum say of its fall. */
#include "check.h"

#include "falling_rod.h"

typedef struct run {
  double t, q[3], v[3], impulse[2], friction[2];
  int mode[2], impacts;
  nsdae_impact first[2]; /* of each end; its time is 0 where there is none */
  double worst_energy;   /* |energy - start| before the first impact */
  double start_energy, worst_drift_x;
} run;

static int observe(const nsdae_record *r, nsdae_error *error, void *user)
{
  run *out = user;
  const falling_rod *p = falling_rod_model.base;
  double energy = r->kinetic + r->potential;
  (void)error;
  out->impacts += r->impacts;
  for (int i = 0; i < r->impacts; i++) {
    nsdae_impact *first = &out->first[r->impact[i].contact];
    if (first->time == 0) *first = r->impact[i];
  }
  if (r->step == 0) out->start_energy = energy;
  if (out->impacts == 0)
    out->worst_energy = fmax(out->worst_energy, fabs(energy - out->start_energy));
  out->worst_drift_x = fmax(out->worst_drift_x, fabs(r->v[0] - p->v_T));
  out->t = r->time;
  memcpy(out->q, r->q, sizeof out->q);
  memcpy(out->v, r->v, sizeof out->v);
  for (int i = 0; i < 2; i++) {
    out->impulse[i] = r->normal_impulse[i];
    out->friction[i] = r->tangential_impulse[i];
    out->mode[i] = r->mode[i];
  }
  return 0;
}

static run integrate(int method, double dt, double t_end)
{
  run out = {0};
  nsdae_system *system;
  nsdae_sim *sim;
  nsdae_sim_options options;
  double q0[3] = {0}, v0[3] = {0};
  nsdae_sim_options_default(&options);
  options.method = method;
  options.dt = dt;
  assert_int_equal(falling_rod_model.build(falling_rod_model.base, &system, NULL), NSDAE_OK);
  falling_rod_model.start(falling_rod_model.base, q0, v0);
  assert_int_equal(nsdae_sim_create(system, &options, &sim, NULL), NSDAE_OK);
  assert_int_equal(nsdae_sim_init(sim, 0, q0, v0), NSDAE_OK);
  assert_int_equal(nsdae_sim_observe(sim, observe, &out), NSDAE_OK);
  int status = nsdae_sim_run(sim, t_end);
  if (status < 0) print_message("%s\n", nsdae_sim_error(sim)->text);
  assert_int_equal(status, NSDAE_OK);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  return out;
}

static falling_rod *parameters(void)
{
  nsdae_params_default(falling_rod_model.parameters, falling_rod_model.base);
  return falling_rod_model.base;
}

static void test_derivatives(void **state)
{
  (void)state;
  const double q[] = {0.3, 1.2, 0.7}, v[] = {-1, 2, 3};
  nsdae_system *system;
  assert_int_equal(falling_rod_model.build(parameters(), &system, NULL), NSDAE_OK);
  assert_int_equal(nsdae_system_check(system, 0, q, v, 1e-6, NULL), NSDAE_OK);
  nsdae_system_destroy(&system);
}

/* Where the uniform rod's a is zero: at its least over phi for mu = 4/3, twice for mu = 5/3. */
static void test_paradox_bounds(void **state)
{
  (void)state;
  falling_rod *p = parameters();
  const double angle = atan(2), degree = 3.14159265358979324 / 180;
  p->mu = 4.0 / 3;
  assert_near(angle / degree, 63.435, 0.5e-3);
  assert_near(falling_rod_coefficient(p, angle, -1), 0, 1e-15);
  for (double off = -0.5; off <= 0.51; off += 0.1)
    if (fabs(off) > 1e-9) assert_true(falling_rod_coefficient(p, angle + off, -1) > 0);
  p->mu = 5.0 / 3;
  assert_near(falling_rod_coefficient(p, 45 * degree, -1), 0, 2e-15);
  assert_near(falling_rod_coefficient(p, atan(4), -1), 0, 2e-15);
  assert_near(atan(4) / degree, 75.964, 0.5e-3);
  assert_true(falling_rod_coefficient(p, 60 * degree, -1) < 0);
  assert_true(falling_rod_coefficient(p, 60 * degree, 1) > 0);
}

/* Outside the paradox a first short step has lambda_N = -b / a, friction -mu s lambda_N: the matrix
 * entries of the callbacks against the formula of the model's head. The error is dt times a rate
 * of the system, all of which are below 100/s. */
static void test_sliding(void **state)
{
  (void)state;
  falling_rod *p = parameters();
  double worst = 0;
  for (p->mu = 0; p->mu < 1.3; p->mu += 0.4)
    for (p->p0 = 0.2; p->p0 < 3; p->p0 += 0.2)
      for (p->v_T = -1; p->v_T < 2; p->v_T += 2)
        for (p->omega = 0; p->omega < 2.5; p->omega += 1) {
          const double dt = 1e-7;
          double a = falling_rod_coefficient(p, p->p0, p->v_T > 0 ? 1 : -1);
          double b = falling_rod_free(p, p->p0, p->omega);
          run r = integrate(NSDAE_METHOD_IMPLICIT, dt, dt);
          double error = r.impulse[0] / dt / (-b / a) - 1;
          assert_true(a > 0 && b < 0);
          worst = fmax(worst, fabs(error));
          assert_near(error, 0, 100 * dt);
          /* impulses come from velocities of order one */
          assert_near(r.friction[0], -p->mu * p->v_T * r.impulse[0], 1e-15);
        }
  print_message("worst relative error of the normal force %.2e\n", worst);
}

/* Inside the paradox the end that slides stops at once: with G = W^T M^-1 W of its contact,
 * G Lambda = (0, -v_T), whatever the step. It lies in the cone: |Lambda_T| / Lambda_N =
 * G_NN / |G_NT| < mu because a = G_NN - mu |G_NT| < 0. */
static void test_impact_without_collision(void **state)
{
  (void)state;
  falling_rod *p = parameters();
  p->mu = 5.0 / 3;
  for (int method = 0; method < 3; method++)
    for (p->p0 = 0.8; p->p0 < 1.32; p->p0 += 0.04) {
      const double dt = 1e-7;
      double c = cos(p->p0), s = sin(p->p0), arm = p->l * p->l / p->J;
      double G_NN = 1 / p->m + arm * c * c, G_TT = 1 / p->m + arm * s * s, G_NT = -arm * s * c;
      double det = G_NN * G_TT - G_NT * G_NT;
      run r = integrate(method, dt, dt);
      assert_true(falling_rod_coefficient(p, p->p0, -1) < 0);
      /* gravity adds impulses of g dt over the reciprocal condition, at most 10 here */
      assert_near(r.impulse[0], G_NT * p->v_T / det, 100 * p->g * dt);
      assert_near(r.friction[0], -G_NN * p->v_T / det, 100 * p->g * dt);
      assert_near(r.v[0] + p->l * s * r.v[2], 0, 1e-6); /* v_T, at the old angle */
      assert_int_equal(r.mode[0], NSDAE_MODE_STICK);
    }
}

/* Without friction from rest the centre falls straight and the first end stays on the floor:
 * (J + m l^2 cos^2 phi) omega^2 / 2 = m g l (sin p0 - sin phi), to the square of dt. */
static void test_frictionless_fall(void **state)
{
  (void)state;
  falling_rod *p = parameters();
  p->mu = 0;
  double error[2];
  for (int i = 0; i < 2; i++) {
    run r = integrate(NSDAE_METHOD_IMPLICIT, 0.004 / (1 << 3 * i), 0.5);
    double c = p->l * cos(r.q[2]), fallen = p->l * (sin(p->p0) - sin(r.q[2]));
    double omega = -sqrt(2 * p->m * p->g * fallen / (p->J + p->m * c * c));
    assert_int_equal(r.impacts, 0);
    assert_true(r.worst_drift_x == 0);
    error[i] = fabs(r.v[2] - omega);
  }
  print_message("omega %.2e -> %.2e, order %.3f\n", error[0], error[1],
                log2(error[0] / error[1]) / 3);
  assert_near(log2(error[0] / error[1]) / 3, 2, 0.1);
}

/* It arrives flat with omega^2 = 2 m g l sin p0 / (J + m l^2); with e = 0 both ends stop, and
 * Lambda_0,1 = (m l -+ J / l) |omega| / 2. First order in dt, which is late by up to two steps. */
static void test_flat_impact(void **state)
{
  (void)state;
  falling_rod *p = parameters();
  p->mu = 0;
  double omega = sqrt(2 * p->m * p->g * p->l * sin(p->p0) / (p->J + p->m * p->l * p->l));
  for (int method = 0; method < 3; method += 2)
    for (double dt = 1e-3; dt > 1e-5; dt /= 4) {
      run r = integrate(method, dt, 1);
      double error = r.first[1].normal_impulse - (p->m * p->l + p->J / p->l) * omega / 2;
      print_message("%-9s dt %-10g error of the impulse %+.2e N s = %.2f g dt\n",
                    nsdae_method_name(method), dt, error, error / (p->m * p->g * dt));
      assert_near(error, 0, 2 * p->m * p->g * dt);
      assert_near(r.v[1], 0, 1e-12);
      assert_near(r.v[2], 0, 1e-12);
    }
}

/* Dropped from h without turning, e: the impulse of the first end is (1 + e) V / G_NN, of a step
 * that starts up to dt late and has g dt in it. */
static void test_drop(void **state)
{
  (void)state;
  falling_rod *p = parameters();
  p->mu = 0;
  p->h = 0.5;
  for (int method = 0; method < 3; method++)
    for (p->e_N = 0; p->e_N <= 1; p->e_N += 0.5)
      for (double dt = 0.01; dt > 1e-4; dt /= 3) {
        double G_NN = falling_rod_coefficient(p, p->p0, 1), V = sqrt(2 * p->g * p->h);
        run r = integrate(method, dt, 0.4);
        assert_near(r.first[0].normal_impulse, (1 + p->e_N) * V / G_NN,
                    (2 + p->e_N) * p->g * dt / G_NN);
      }
}

/* It comes to rest flat, bouncing or not, inside the paradox or not. */
static void test_rest(void **state)
{
  (void)state;
  falling_rod *p = parameters();
  const double mu[] = {0.3, 5.0 / 3};
  for (int method = 0; method < 3; method++)
    for (p->e_N = 0; p->e_N < 0.9; p->e_N += 0.4)
      for (int j = 0; j < 2; j++) {
        const double dt = 1e-3;
        p->mu = mu[j];
        run r = integrate(method, dt, 8);
        for (int i = 0; i < 3; i++) assert_near(r.v[i], 0, 1e-12);
        /* no deeper than a step of its fastest, 2 l omega < 12 m/s */
        assert_near(r.q[1], 0, 12 * dt);
        assert_near(r.q[2], 0, 12 * dt);
      }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_derivatives),
      cmocka_unit_test(test_paradox_bounds),
      cmocka_unit_test(test_sliding),
      cmocka_unit_test(test_impact_without_collision),
      cmocka_unit_test(test_frictionless_fall),
      cmocka_unit_test(test_flat_impact),
      cmocka_unit_test(test_drop),
      cmocka_unit_test(test_rest),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
