/* The stiff chain of tests/support by its own equations: derivatives against differences, and
 * planar states against the Lagrangian equations of the angles by the principle of d'Alembert,
 *
 *   T^T (M a - F) = 0,   v = T(theta) theta',   a = dv/dt along theta', theta''. */
#include "check.h"

#include <nsdae/nsdae.h>

#include "support/random.h"
#include "support/stiff_chain.h"
#include "system_impl.h"

enum { LINKS = 12 };

static const double damping = 10;

static void test_derivatives(void **state)
{
  (void)state;
  random_state r = {1};
  for (int n = 1; n <= LINKS; n++)
    for (int i = 0; i < 4; i++) {
      stiff_chain c = {.n = n, .damping = damping};
      nsdae_system *s = stiff_chain_system(&c, 1);
      double q[7 * LINKS], v[6 * LINKS];
      nsdae_check worst;
      stiff_chain_start(&c, q, v);
      for (int j = 0; j < 7 * n; j++) q[j] += random_number(&r) / 4;
      for (int j = 0; j < 6 * n; j++) v[j] = 2 * random_number(&r);
      int status = nsdae_system_check(s, 0, q, v, 1e-6, &worst);
      if (status < 0) print_error("%s\n", nsdae_system_error(s)->text);
      assert_int_equal(status, NSDAE_OK);
      nsdae_system_destroy(&s);
    }
}

/* a = (v(t + e) - v(t - e)) / 2e has e^2 = 1e-10 of theta'''' and 1e-16 / e; F has some 1e2. */
static void test_planar(void **state)
{
  (void)state;
  random_state r = {2};
  const double e = 1e-5;
  for (int n = 1; n <= LINKS; n++) {
    stiff_chain c = {.n = n, .damping = damping};
    nsdae_system *s = stiff_chain_system(&c, 0);
    double theta[LINKS], rate[LINKS], theta_dd[LINKS], M[36 * LINKS] = {0}, F[6 * LINKS] = {0};
    double q[7 * LINKS], v[2][6 * LINKS], side[2][LINKS], rates[2][LINKS], phi[3 * LINKS];
    for (int i = 0; i < n; i++) theta[i] = 3 * random_number(&r), rate[i] = random_number(&r);
    stiff_chain_accelerations(&c, theta, rate, theta_dd);
    for (int k = 0; k < 2; k++) {
      double ahead = k ? -e : e;
      for (int i = 0; i < n; i++) {
        side[k][i] = theta[i] + ahead * rate[i] + ahead * ahead / 2 * theta_dd[i];
        rates[k][i] = rate[i] + ahead * theta_dd[i];
      }
      stiff_chain_place(&c, side[k], rates[k], q, v[k]);
      assert_int_equal(s->call.constraint(0, q, phi, &c), 0);
      for (int i = 0; i < 3 * n; i++) assert_near(phi[i], 0, 1e-14);
    }
    double a[6 * LINKS], T[6 * LINKS], most = 0;
    for (int j = 0; j < 6 * n; j++) a[j] = (v[0][j] - v[1][j]) / (2 * e);
    stiff_chain_place(&c, theta, rate, q, T);
    s->call.mass_blocks(0, q, M, &c);
    s->call.force(0, q, T, F, &c);
    for (int j = 0; j < 6 * n; j++) most = fmax(most, fabs(a[j]));
    for (int i = 0; i < n; i++) {
      double unit[LINKS] = {0}, sum = 0;
      unit[i] = 1;
      stiff_chain_place(&c, theta, unit, q, T);
      for (int j = 0; j < 6 * n; j++) sum += T[j] * (M[36 * (j / 6) + 7 * (j % 6)] * a[j] - F[j]);
      assert_near(sum, 0, 1e-8 * n * (1 + most));
    }
    nsdae_system_destroy(&s);
  }
}

/* The reference itself: of order four, and the energy of a frictionless chain stays. */
static void test_reference(void **state)
{
  (void)state;
  const stiff_chain c = {.n = 5, .damping = damping};
  double theta[3][5], rate[3][5], error[2] = {0};
  for (int k = 0; k < 3; k++) {
    for (int i = 0; i < 5; i++) theta[k][i] = 0.3 * i, rate[k][i] = 0;
    stiff_chain_swing(&c, 0.1, 200L << k, theta[k], rate[k]);
  }
  for (int k = 0; k < 2; k++)
    for (int i = 0; i < 5; i++) error[k] = fmax(error[k], fabs(theta[k][i] - theta[k + 1][i]));
  assert_at_most(error[1], error[0] / 10);
  assert_at_most(error[1], 1e-7);
}

/* Time stepping of first order, with twice the steps half the error. */
static void test_steps(void **state)
{
  (void)state;
  stiff_chain c = {.n = 4, .damping = damping};
  const double T = 0.2;
  double theta[4] = {0.1, 0.6, -0.2, 0.4}, rate[4] = {0}, start[4], q[28], v[24], end[28], error[2];
  memcpy(start, theta, sizeof start);
  stiff_chain_swing(&c, T, 2000, theta, rate);
  stiff_chain_place(&c, theta, rate, end, v);
  for (int k = 0; k < 2; k++) {
    nsdae_system *s = stiff_chain_system(&c, 1);
    nsdae_sim_options options;
    nsdae_sim *sim;
    nsdae_record record;
    nsdae_sim_options_default(&options);
    options.method = NSDAE_METHOD_IMPLICIT;
    options.dt = k ? 5e-4 : 1e-3;
    assert_int_equal(nsdae_sim_create(s, &options, &sim, NULL), NSDAE_OK);
    for (int i = 0; i < 4; i++) rate[i] = 0;
    stiff_chain_place(&c, start, rate, q, v);
    assert_int_equal(nsdae_sim_init(sim, 0, q, v), NSDAE_OK);
    for (int i = 0; i < (k ? 400 : 200); i++) assert_int_equal(nsdae_sim_step(sim), NSDAE_OK);
    nsdae_sim_get_record(sim, &record);
    error[k] = 0;
    for (int j = 0; j < 28; j++)
      if (j % 7 < 3) error[k] = fmax(error[k], fabs(record.q[j] - end[j]));
    nsdae_sim_destroy(&sim);
    nsdae_system_destroy(&s);
  }
  assert_at_most(error[0], 1e-3);
  assert_at_most(error[1], 0.6 * error[0]);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_derivatives), cmocka_unit_test(test_planar),
      cmocka_unit_test(test_reference), cmocka_unit_test(test_steps)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
