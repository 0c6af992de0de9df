/* The pendulum with a stop against its exact solution (closed form, elliptic functions). */
#include "check.h"

#include <stdlib.h>

#include <gsl/gsl_sf_ellint.h>
#include <gsl/gsl_sf_elljac.h>

#include "pendulum.h"

enum { METHODS = 3, IMPACTS = 8 };

/* What a run leaves. */
typedef struct run {
  int impacts;
  nsdae_impact impact[64];
  double theta, omega, velocity_residual, energy, gain; /* gain: worst growth over an impact step */
  nsdae_stats stats;
} run;

static double energy_of(const nsdae_record *r)
{
  return r->kinetic + r->potential;
}

/* max |Phi_q v| of the pendulum, Phi_q written out. */
static double velocity_residual(const double *q, const double *v, double L)
{
  double x = v[0] - L / 2 * cos(q[2]) * v[2], y = v[1] - L / 2 * sin(q[2]) * v[2];
  return fmax(fabs(x), fabs(y));
}

static int observe(const nsdae_record *r, nsdae_error *error, void *user)
{
  run *out = user;
  const pendulum *p = pendulum_model.base;
  (void)error;
  for (int i = 0; i < r->impacts && out->impacts < 64; i++)
    out->impact[out->impacts++] = r->impact[i];
  if (r->impacts > 0) out->gain = fmax(out->gain, energy_of(r) - out->energy);
  out->energy = energy_of(r);
  out->theta = r->q[2];
  out->omega = r->v[2];
  out->velocity_residual = fmax(out->velocity_residual, velocity_residual(r->q, r->v, p->L));
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
  pendulum *p = pendulum_model.base;
  out.gain = -INFINITY;
  assert_int_equal(pendulum_model.build(p, &system, NULL), NSDAE_OK);
  pendulum_model.start(p, q0, v0);
  assert_int_equal(nsdae_sim_create(system, &options, &sim, NULL), NSDAE_OK);
  assert_int_equal(nsdae_sim_init(sim, 0, q0, v0), NSDAE_OK);
  assert_int_equal(nsdae_sim_observe(sim, observe, &out), NSDAE_OK);
  assert_int_equal(nsdae_sim_run(sim, t_end), NSDAE_OK);
  assert_int_equal(nsdae_sim_get_stats(sim, &out.stats), NSDAE_OK);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  return out;
}

static int defaults(void **state)
{
  (void)state;
  nsdae_params_default(pendulum_model.parameters, pendulum_model.base);
  return 0;
}

/* theta(t) and omega(t) before the first impact: sin(theta/2) = k sn(K - w t), w^2 = 3 g / 2 L. */
static void swing(double t, double *theta, double *omega)
{
  const pendulum *p = pendulum_model.base;
  double w = sqrt(3 * p->g / (2 * p->L)), k = sin(p->theta_0 / 2), sn, cn, dn;
  double K = gsl_sf_ellint_Kcomp(k, GSL_PREC_DOUBLE);
  gsl_sf_elljac_e(K - w * t, k * k, &sn, &cn, &dn);
  *theta = 2 * asin(k * sn);
  *omega = -2 * k * w * cn;
}

/* The driver's closed form against the table of data/, which was made by another program. */
static void test_closed_form(void **state)
{
  (void)state;
  FILE *file = fopen(NSDAE_DATA_DIR "/pendulum_impacts.csv", "r");
  char line[256];
  int rows = 0;
  assert_non_null(file);
  while (fgets(line, sizeof line, file)) {
    int number;
    double time, impulse;
    driver_exact exact;
    if (sscanf(line, "%d,%lf,%*f,%*f,%lf", &number, &time, &impulse) != 3) continue;
    assert_int_equal(pendulum_model.exact(pendulum_model.base, number - 1, &exact), 1);
    /* the table has 15 digits */
    assert_near(exact.time, time, 1e-14 * time);
    assert_near(exact.normal_impulse, impulse, 1e-14 * 16);
    rows++;
  }
  fclose(file);
  assert_int_equal(rows, IMPACTS);
}

/* Values of an independent program for Moreau's rule at dt 0.005, given to 4 decimals. */
static void test_moreau_published(void **state)
{
  (void)state;
  const double impulse[] = {13.6877, 7.6258, 4.2631}, time[] = {0.490, 1.350, 2.185};
  run r = integrate(NSDAE_METHOD_MOREAU, 0.005, 2.5);
  assert_int_equal(r.impacts, 3);
  for (int i = 0; i < 3; i++) {
    assert_near(r.impact[i].normal_impulse, impulse[i], 0.5e-4);
    assert_near(r.impact[i].time, time[i], 1e-12);
  }
}

/* Worst relative error of the impulses of the first three impacts. */
static double impulse_error(int method, double dt)
{
  run r = integrate(method, dt, 2.5);
  double worst = 0;
  assert_true(r.impacts >= 3);
  for (int i = 0; i < 3; i++) {
    driver_exact exact;
    pendulum_model.exact(pendulum_model.base, i, &exact);
    worst = fmax(worst, fabs(r.impact[i].normal_impulse / exact.normal_impulse - 1));
  }
  return worst;
}

/* The impact is found up to a step late, at a place that jumps with dt: so the mean over eleven
 * steps around dt. */
static double mean_impulse_error(int method, double dt)
{
  double sum = 0;
  for (int i = 0; i < 11; i++) sum += impulse_error(method, dt * (0.9 + 0.02 * i));
  return sum / 11;
}

/* Order 1 or better: over a factor of eight in dt the error falls by at least eight, but for the
 * jumps that the mean leaves (a factor of 0.75 in the exponent's base: 6). */
static void test_impulse_order(void **state)
{
  (void)state;
  for (int method = 0; method < METHODS; method++) {
    double coarse = mean_impulse_error(method, 0.008), fine = mean_impulse_error(method, 0.001);
    print_message("%-17s impulse error %.3e at dt 0.008, %.3e at 0.001\n",
                  nsdae_method_name(method), coarse, fine);
    assert_at_most(fine, coarse / 6);
    /* and it is that of the exact solution: 4 dt covers the worst, Moreau's 2.1 dt per impact,
     * which three impacts add up */
    assert_at_most(fine, 4 * 0.001);
  }
}

static double swing_error(int method, double dt)
{
  double theta, omega;
  run r = integrate(method, dt, 0.44);
  swing(0.44, &theta, &omega);
  return fmax(fabs(r.theta - theta), fabs(r.omega - omega));
}

/* Order of the smooth motion, from four halvings of dt. */
static void test_smooth_order(void **state)
{
  (void)state;
  const double order[METHODS] = {
      [NSDAE_METHOD_IMPLICIT] = 2, [NSDAE_METHOD_IMPLICIT_PRINTED] = 2, [NSDAE_METHOD_MOREAU] = 1};
  for (int method = 0; method < METHODS; method++) {
    double measured = log2(swing_error(method, 0.01) / swing_error(method, 0.000625)) / 4;
    print_message("%-17s smooth order %.3f\n", nsdae_method_name(method), measured);
    assert_near(measured, order[method], 0.15);
  }
}

/* Drift of implicit: order 2; v stays on the constraint to rounding. The printed scheme is shown
 * as it is: its drift is larger, and its velocity leaves the constraint. */
static void test_drift(void **state)
{
  (void)state;
  double drift[4];
  for (int i = 0; i < 4; i++) {
    run r = integrate(NSDAE_METHOD_IMPLICIT, 0.01 / (1 << i), 3);
    drift[i] = r.stats.worst_drift;
    /* |v| is at most 5.4; the velocity comes from one solve */
    assert_at_most(r.velocity_residual, 1e-14 * 6);
  }
  double order = log2(drift[0] / drift[3]) / 3;
  run printed = integrate(NSDAE_METHOD_IMPLICIT_PRINTED, 0.005, 3);
  print_message("drift of implicit %.3e, order %.3f; of implicit-printed %.3e at dt 0.005\n",
                drift[1], order, printed.stats.worst_drift);
  assert_near(order, 2, 0.15);
  assert_true(printed.stats.worst_drift > drift[1]);
  assert_true(printed.velocity_residual > 1e-6);
}

/* Total energy never grows over an impact with e <= 1. implicit keeps it exactly at e = 1 by
 * construction (see implicit.c): 1e-12 of the 13 J that turn over is rounding. The other two take
 * Phi_q where v(-) does not satisfy it, and lose some. */
static void test_impact_energy(void **state)
{
  (void)state;
  const double e[] = {0, 0.56, 1};
  pendulum *p = pendulum_model.base;
  for (int method = 0; method < METHODS; method++)
    for (int i = 0; i < 3; i++)
      for (double dt = 0.01; dt > 0.001; dt /= 2) {
        p->e_N = e[i];
        run r = integrate(method, dt, 3);
        assert_true(r.impacts > 0);
        print_message("%-17s e %.2f dt %.4f gain %.3e\n", nsdae_method_name(method), e[i], dt,
                      r.gain);
        assert_at_most(r.gain, 1e-12 * 13);
      }
}

/* Complementarity: every impact leaves with -e times the velocity it came with. */
static void test_newton_law(void **state)
{
  (void)state;
  for (int method = 0; method < METHODS; method++) {
    run r = integrate(method, 0.005, 3);
    for (int i = 0; i < r.impacts; i++)
      assert_near(r.impact[i].velocity_after, -0.56 * r.impact[i].velocity_before, 1e-14 * 6);
    assert_at_most(r.stats.worst_residual, 1e-10);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup(test_closed_form, defaults),
      cmocka_unit_test_setup(test_moreau_published, defaults),
      cmocka_unit_test_setup(test_impulse_order, defaults),
      cmocka_unit_test_setup(test_smooth_order, defaults),
      cmocka_unit_test_setup(test_drift, defaults),
      cmocka_unit_test_setup(test_impact_energy, defaults),
      cmocka_unit_test_setup(test_newton_law, defaults),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
