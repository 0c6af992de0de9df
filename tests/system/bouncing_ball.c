/* The bouncing ball against its closed form. */
#include "check.h"

#include "bouncing_ball.h"

enum { METHODS = 3, KEPT = 8 };

typedef struct run {
  int impacts;
  nsdae_impact impact[KEPT];
  double y, v, start_energy, energy_change, worst_flight;
} run;

/* A record before the first impact must lie on the parabola. */
static int observe(const nsdae_record *r, nsdae_error *error, void *user)
{
  run *out = user;
  double y, v, energy = r->kinetic + r->potential;
  (void)error;
  for (int i = 0; i < r->impacts; i++, out->impacts++)
    if (out->impacts < KEPT) out->impact[out->impacts] = r->impact[i];
  bouncing_ball_exact(bouncing_ball_model.base, r->time, &y, &v, NULL);
  if (out->impacts == 0 && y > 0.1)
    out->worst_flight = fmax(out->worst_flight, fmax(fabs(r->q[0] - y), fabs(r->v[0] - v)));
  if (r->step == 0) out->start_energy = energy;
  out->energy_change = fmax(out->energy_change, fabs(energy - out->start_energy));
  out->y = r->q[0];
  out->v = r->v[0];
  return 0;
}

static run integrate(int method, double dt, double t_end)
{
  run out = {0};
  nsdae_system *system;
  nsdae_sim *sim;
  nsdae_sim_options options;
  double q0 = 0, v0 = 0;
  nsdae_sim_options_default(&options);
  options.method = method;
  options.dt = dt;
  assert_int_equal(bouncing_ball_model.build(bouncing_ball_model.base, &system, NULL), NSDAE_OK);
  bouncing_ball_model.start(bouncing_ball_model.base, &q0, &v0);
  assert_int_equal(nsdae_sim_create(system, &options, &sim, NULL), NSDAE_OK);
  assert_int_equal(nsdae_sim_init(sim, 0, &q0, &v0), NSDAE_OK);
  assert_int_equal(nsdae_sim_observe(sim, observe, &out), NSDAE_OK);
  assert_int_equal(nsdae_sim_run(sim, t_end), NSDAE_OK);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  return out;
}

static int defaults(void **state)
{
  (void)state;
  nsdae_params_default(bouncing_ball_model.parameters, bouncing_ball_model.base);
  return 0;
}

static void test_derivatives(void **state)
{
  (void)state;
  const double q = 0.3, v = -2;
  nsdae_system *system;
  assert_int_equal(bouncing_ball_model.build(bouncing_ball_model.base, &system, NULL), NSDAE_OK);
  assert_int_equal(nsdae_system_check(system, 0, &q, &v, 1e-6, NULL), NSDAE_OK);
  nsdae_system_destroy(&system);
}

/* The closed form against itself: height and velocity at its times of impact, the law of
 * restitution there, the time of rest, and values of an independent program at 8.5 s. */
static void test_closed_form(void **state)
{
  (void)state;
  const bouncing_ball *p = bouncing_ball_model.base;
  driver_exact impact = {0};
  double y, v, last = sqrt(2 * p->h0 * p->ball.g) / p->ball.e_N;
  int count;
  for (int i = 0; i < 44; i++) {
    assert_int_equal(bouncing_ball_model.exact(p, i, &impact), 1);
    assert_near(impact.normal_impulse, p->ball.m * (1 + p->ball.e_N) * p->ball.e_N * last,
                1e-14 * 16);
    last *= p->ball.e_N;
    bouncing_ball_exact(p, impact.time - 1e-12, &y, &v, &count);
    assert_int_equal(count, i);
    assert_near(v, -last, 2e-11);
    bouncing_ball_exact(p, impact.time + 1e-12, &y, &v, &count);
    assert_int_equal(count, i + 1);
    assert_near(v, p->ball.e_N * last, 2e-11);
    assert_near(y, 0, 1e-11);
  }
  /* ten digits are given; the sum of 44 flights rounds to 44 ulp of 8 s at most */
  const double rounding = 44 * 8.9e-16;
  bouncing_ball_exact(p, 8.5, &y, &v, &count);
  assert_int_equal(count, 44);
  assert_near(y, 5.565551009e-6, 0.5e-15 + 0.042 * rounding);
  assert_near(v, -4.166519581e-2, 0.5e-11 + p->ball.g * rounding);
  assert_near(bouncing_ball_rest(p), 8.578949178728887, 1e-14);
  bouncing_ball_exact(p, 8.58, &y, &v, &count);
  assert_true(y == 0 && v == 0 && count > 1000000);
}

/* Both schemes follow a parabola exactly: rounding of a hundred steps. */
static void test_flight(void **state)
{
  (void)state;
  for (int method = 0; method < METHODS; method++)
    assert_at_most(integrate(method, 0.005, 1).worst_flight, 100 * 4 * 2.3e-16);
}

/* implicit finds the contact at the start t_k of a step, t_1 <= t_k < t_1 + dt, and its step ends
 * at t_k + dt with Lambda = m (1 + e) g t_k + m g dt; moreau half a step earlier. */
static void test_first_impact(void **state)
{
  (void)state;
  const bouncing_ball *p = bouncing_ball_model.base;
  driver_exact exact;
  bouncing_ball_model.exact(p, 0, &exact);
  for (int method = 0; method < METHODS; method++)
    for (double dt = 0.01; dt > 1e-4; dt /= 3) {
      run r = integrate(method, dt, 0.6);
      double late = r.impact[0].time - exact.time;
      double more = r.impact[0].normal_impulse - exact.normal_impulse;
      assert_true(r.impacts >= 1);
      assert_true(late >= (method == NSDAE_METHOD_MOREAU ? 0 : dt) && late <= 2 * dt);
      assert_near(more, 0, (2 + p->ball.e_N) * p->ball.m * p->ball.g * dt);
    }
}

/* Errors of the first five impacts, averaged over 16 steps near dt, whose phases differ. */
static void mean_error(int method, double dt, double *time, double *impulse)
{
  *time = *impulse = 0;
  for (int j = 0; j < 16; j++) {
    run r = integrate(method, dt * (1 + j / 64.0), 3.4);
    assert_true(r.impacts >= 5);
    for (int i = 0; i < 5; i++) {
      driver_exact exact;
      bouncing_ball_model.exact(bouncing_ball_model.base, i, &exact);
      *time += fabs(r.impact[i].time - exact.time) / 80;
      *impulse += fabs(r.impact[i].normal_impulse / exact.normal_impulse - 1) / 80;
    }
  }
}

/* First order. The averages still have a spread of some per cent, which over a factor of 16 in dt
 * is less than 0.1 in the order. */
static void test_order(void **state)
{
  (void)state;
  for (int method = 0; method < METHODS; method++) {
    double coarse_time, fine_time, coarse, fine;
    mean_error(method, 4e-3, &coarse_time, &coarse);
    mean_error(method, 2.5e-4, &fine_time, &fine);
    double time_order = log2(coarse_time / fine_time) / 4, order = log2(coarse / fine) / 4;
    print_message("%-17s impulses %.2e -> %.2e, order %.3f; times %.2e -> %.2e, order %.3f\n",
                  nsdae_method_name(method), coarse, fine, order, coarse_time, fine_time,
                  time_order);
    assert_near(time_order, 1, 0.1);
    assert_near(order, 1, 0.1);
  }
}

/* With e = 1 a bounce turns v round and leaves y where it is, and a flight keeps the energy: so
 * does the whole run, to rounding of 9.81 J over 20000 steps. */
static void test_energy(void **state)
{
  (void)state;
  bouncing_ball *p = bouncing_ball_model.base;
  p->ball.e_N = 1;
  for (int method = 0; method < METHODS; method++) {
    run r = integrate(method, 0.001, 20);
    print_message("%-17s energy change %.2e J, %d impacts\n", nsdae_method_name(method),
                  r.energy_change, r.impacts);
    assert_int_equal(r.impacts, 22); /* (20 / t_1 + 1) / 2 */
    assert_at_most(r.energy_change, 20000 * 2.3e-16 * 9.81);
  }
}

/* With e < 1 it lies still, no deeper than a step of the velocity of the first impact. */
static void test_rest(void **state)
{
  (void)state;
  for (int method = 0; method < METHODS; method++) {
    run r = integrate(method, 0.001, 9);
    assert_true(r.v == 0);
    assert_true(r.y <= 0 && r.y >= -4.43 * 0.001);
  }
}

/* ---- a bead of 1 kg in a hoop of 1 m, e_N = 1/2 */

static const double hoop_g = 9.81;

static int bead_mass(double t, const double *q, double *M, int ldm, void *user)
{
  (void)t, (void)q, (void)user;
  M[0] = M[ldm + 1] = 1;
  return 0;
}

static int bead_weight(double t, const double *q, const double *v, double *F, void *user)
{
  (void)t, (void)q, (void)v, (void)user;
  F[1] = -hoop_g;
  return 0;
}

static int hoop(double t, const double *q, double *gap, void *user)
{
  (void)t, (void)user;
  gap[0] = 1 - hypot(q[0], q[1]);
  return 0;
}

static int hoop_normal(double t, const double *q, double *W, int ldw, void *user)
{
  (void)t, (void)ldw, (void)user;
  for (int i = 0; i < 2; i++) W[i] = -q[i] / hypot(q[0], q[1]);
  return 0;
}

/* The hoop turns the bead's velocity in every step, which is no impact: it slides to and fro and
 * keeps its energy, up to that of the speed that a step of gravity gives. Bounces would take their
 * (1 - e^2) of (v^2 dt / R)^2 / 2 a step, of first order: 0.3 J here. */
static void test_hoop(void **state)
{
  const nsdae_dims dims = {.nq = 2, .k = 1};
  const double start = 1.2, dt = 1e-3, q[2] = {sin(start), -cos(start)}, v[2] = {0};
  nsdae_system *system;
  nsdae_sim *sim;
  nsdae_sim_options options;
  nsdae_record r;
  (void)state;
  assert_int_equal(nsdae_system_create(&dims, &system, NULL), NSDAE_OK);
  nsdae_system_set_mass(system, bead_mass);
  nsdae_system_set_force(system, bead_weight);
  nsdae_system_set_gap(system, hoop);
  nsdae_system_set_gap_normal(system, hoop_normal);
  nsdae_system_set_contact(system, 0, 0, 0.5, 0);
  nsdae_sim_options_default(&options);
  options.method = NSDAE_METHOD_IMPLICIT;
  options.dt = dt;
  assert_int_equal(nsdae_sim_create(system, &options, &sim, NULL), NSDAE_OK);
  assert_int_equal(nsdae_sim_init(sim, 0, q, v), NSDAE_OK);
  assert_true(nsdae_sim_run(sim, 5) >= 0);
  nsdae_sim_get_record(sim, &r);
  assert_near(r.kinetic + hoop_g * (r.q[1] - q[1]), 0, hoop_g * dt * hoop_g * dt / 2);
  assert_near(hypot(r.q[0], r.q[1]), 1, hoop_g * dt * dt); /* the way of a step of gravity, twice */
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
}

/* ---- a bead of 1 kg that 3 N press on a wall which swings, x = 0.2 m sin(3 t), by a list */

static int listed_mass(double t, const double *q, double *M, void *user)
{
  (void)t, (void)q, (void)user;
  M[0] = 1;
  return 0;
}

static int press(double t, const double *q, const double *v, double *F, void *user)
{
  (void)t, (void)q, (void)v, (void)user;
  F[0] = -3;
  return 0;
}

static int swings(double t, const double *q, const double *v, double reach,
                  nsdae_contact_list *list, void *user)
{
  nsdae_contact c = {
      .block = {0, -1}, .gap = q[0] - 0.2 * sin(3 * t), .w = {-0.6 * cos(3 * t)}, .e_n = 0.5};
  (void)v, (void)user;
  c.direction[0][0][0] = 1;
  return c.gap <= reach && nsdae_contact_add(list, &c) < 0 ? -1 : 0;
}

/* The wall never falls as fast as the bead would, so that they stay together, up to the way of a
 * step at their largest relative acceleration, 3 + 0.2 * 3^2 m/s^2. */
static void test_swing(void **state)
{
  (void)state;
  for (int method = NSDAE_METHOD_IMPLICIT; method <= NSDAE_METHOD_MOREAU; method += 2) {
    const nsdae_dims dims = {.nq = 1};
    const int one = 1;
    const double q = 0, v = 0.6, dt = 0.005;
    nsdae_system *system;
    nsdae_sim *sim;
    nsdae_sim_options options;
    nsdae_record r = {.time = 0};
    assert_int_equal(nsdae_system_create(&dims, &system, NULL), NSDAE_OK);
    assert_int_equal(nsdae_system_set_blocks(system, 1, &one, &one), NSDAE_OK);
    nsdae_system_set_mass_blocks(system, listed_mass);
    nsdae_system_set_force(system, press);
    nsdae_system_set_contacts(system, swings);
    nsdae_sim_options_default(&options);
    options.method = method;
    options.dt = dt;
    assert_int_equal(nsdae_sim_create(system, &options, &sim, NULL), NSDAE_OK);
    assert_int_equal(nsdae_sim_init(sim, 0, &q, &v), NSDAE_OK);
    while (r.time < 4) {
      assert_true(nsdae_sim_step(sim) >= 0);
      nsdae_sim_get_record(sim, &r);
      assert_near(r.q[0], 0.2 * sin(3 * r.time), (3 + 0.2 * 9) * dt * dt);
    }
    nsdae_sim_destroy(&sim);
    nsdae_system_destroy(&system);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup(test_derivatives, defaults),
      cmocka_unit_test_setup(test_closed_form, defaults),
      cmocka_unit_test_setup(test_flight, defaults),
      cmocka_unit_test_setup(test_first_impact, defaults),
      cmocka_unit_test_setup(test_order, defaults),
      cmocka_unit_test_setup(test_energy, defaults),
      cmocka_unit_test_setup(test_rest, defaults),
      cmocka_unit_test(test_hoop),
      cmocka_unit_test(test_swing),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
