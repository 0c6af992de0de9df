/* Stiff chains (stiff_chain.h) by event: auto finds that they are stiff and takes IDA. A planar one
 * against the equations of its angles, one in space against the explicit pair at a smaller
 * tolerance, which is another method. */
#include "check.h"

#include "stiff_chain.h"

enum { MOST = 30 };

typedef struct run {
  double q[7 * MOST], v[6 * MOST];
  long evaluations, steps;
  int status;
} run;

static void go(const stiff_chain *chain, int integrator, int derivatives, double rtol, double t,
               run *r)
{
  stiff_chain of = *chain;
  nsdae_sim_options o;
  nsdae_sim *sim;
  nsdae_record record;
  nsdae_stats stats;
  nsdae_system *system = stiff_chain_system(&of, derivatives);
  assert_non_null(system);
  nsdae_sim_options_default(&o);
  o.method = NSDAE_METHOD_EVENT;
  o.integrator = integrator;
  o.rtol = rtol;
  o.atol = rtol / 100;
  assert_int_equal(nsdae_sim_create(system, &o, &sim, NULL), NSDAE_OK);
  assert_int_equal(nsdae_sim_init(sim, 0, r->q, r->v), NSDAE_OK);
  r->status = nsdae_sim_run(sim, t);
  assert_int_equal(r->status, NSDAE_OK);
  nsdae_sim_get_record(sim, &record);
  nsdae_sim_get_stats(sim, &stats);
  memcpy(r->q, record.q, (size_t)(7 * chain->n) * sizeof *r->q);
  memcpy(r->v, record.v, (size_t)(6 * chain->n) * sizeof *r->v);
  r->evaluations = stats.force_evals;
  r->steps = stats.iterations;
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
}

static double off(int count, const double *a, const double *b)
{
  double most = 0;
  for (int i = 0; i < count; i++) most = fmax(most, fabs(a[i] - b[i]));
  return most;
}

/* rtol is 1e-6 a step, and the error of all of them stays below ten times that. */
static void test_planar(void **state)
{
  (void)state;
  static run r, angles;
  const stiff_chain chain = {.n = 5, .damping = 10};
  const double theta_0[] = {0.4, -0.2, 0.3, 0.1, -0.3}, rate_0[5] = {0};
  double theta[5], rate[5], t = 0.5;
  memcpy(theta, theta_0, sizeof theta);
  memcpy(rate, rate_0, sizeof rate);
  stiff_chain_swing(&chain, t, 20000, theta, rate);
  stiff_chain_place(&chain, theta, rate, angles.q, angles.v);
  int last =
      strstr(nsdae_build_info(), "SUNDIALS none") ? NSDAE_INTEGRATOR_DOP853 : NSDAE_INTEGRATOR_IDA;
  for (int integrator = 0; integrator <= last; integrator++)
    for (int derivatives = 0; derivatives < 2; derivatives++) {
      stiff_chain_place(&chain, theta_0, rate_0, r.q, r.v);
      go(&chain, integrator, derivatives, 1e-6, t, &r);
      assert_near(off(7 * chain.n, r.q, angles.q), 0, 1e-5);
      assert_near(off(6 * chain.n, r.v, angles.v), 0, 1e-4);
    }
}

/* Rates of the chain reach 4 damping / J, which bound the steps of the explicit pair. */
static void test_space(void **state)
{
  (void)state;
  static run exact, r;
  const stiff_chain chain = {.n = MOST, .damping = 10};
  stiff_chain_start(&chain, exact.q, exact.v);
  r = exact;
  go(&chain, NSDAE_INTEGRATOR_DOPRI5, 1, 1e-9, 0.5, &exact);
  go(&chain, NSDAE_INTEGRATOR_AUTO, 1, 1e-6, 0.5, &r);
  print_message("explicit %ld evaluations, auto %ld in %ld steps\n", exact.evaluations,
                r.evaluations, r.steps);
  assert_near(off(7 * chain.n, r.q, exact.q), 0, 1e-5);
  if (!strstr(nsdae_build_info(), "SUNDIALS none"))
    assert_true(3 * r.evaluations < exact.evaluations);
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_planar), cmocka_unit_test(test_space)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
