/* Two gears of involute teeth: the mean ratio of their speeds is that of the teeth, and the
 * backlash is within its bound. See drivers/models/gears.c. */
#include "check.h"

#include "gears.h"
#include "simulation.h"

static int follow(const nsdae_record *r, nsdae_error *error, void *user)
{
  (void)error;
  gears_model.follow(user, r);
  return 0;
}

static void mesh(int method, int first, int second, double speed)
{
  nsdae_system *system = NULL;
  nsdae_sim *sim = NULL;
  nsdae_error error;
  nsdae_sim_options o;
  gears *p = gears_model.base;
  nsdae_params_default(gears_model.parameters, p);
  p->teeth[0] = first;
  p->teeth[1] = second;
  p->speed = speed;
  nsdae_sim_options_default(&o);
  o.method = method;
  o.dt = gears_model.dt;
  o.projection = gears_model.projection;
  if (simulation_make(&gears_model, &o, &system, &sim, &error) < 0) fail_msg("%s", error.text);
  nsdae_sim_observe(sim, follow, p);
  if (nsdae_sim_run(sim, 1.5) < 0) fail_msg("%s", nsdae_sim_error(sim)->text);
  double play = gears_bound(p, p->depth), ratio = -p->turned[1] / p->turned[0];
  print_message("%d and %d teeth, method %d: %.3f rad, ratio %.6f of %.6f, backlash %.4f of %.4f\n",
                first, second, method, p->turned[0], ratio, (double)first / second, p->error, play);
  assert_true(p->depth < 5e-5);
  assert_true(fabs(p->turned[0]) > 0.95 * fabs(speed) * 1.5);
  assert_true(p->error < play);
  assert_near(ratio, (double)first / second, play / second / fabs(p->turned[0]));
  simulation_release(&system, &sim);
}

static void test_gears(void **state)
{
  (void)state;
  if (test_share() == 1) mesh(NSDAE_METHOD_MOREAU, 18, 27, 6);
  mesh(NSDAE_METHOD_IMPLICIT, 18, 27, 6);
  mesh(NSDAE_METHOD_MOREAU, 25, 19, -4);
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_gears)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
