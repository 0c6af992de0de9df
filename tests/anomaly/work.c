/* The work of a step is bounded: random systems (random_system.h) by penalty with stiff contacts
 * take at most twelve evaluations of the forces for each of inner_steps_max, those of two steps of
 * the explicit pair, one of them refused. What takes more steps ends in NSDAE_E_CONVERGENCE, by
 * name. Seed 1461 does. */
#include "check.h"

#include <string.h>

#include "random_system.h"

enum { STEPS_MAX = 500, MOST = 12 * STEPS_MAX };

/* The forces' evaluations in the longest of some steps. */
static long most_of(random_system *r, int seed, int *ended)
{
  nsdae_sim_options o;
  nsdae_sim *sim = NULL;
  long most = 0;
  int status = NSDAE_OK;
  random_system_draw(r, (uint64_t)seed, seed % 2 ? RANDOM_EXTREME : RANDOM_PLAIN);
  nsdae_system *system = random_system_make(r);
  nsdae_sim_options_default(&o);
  o.method = NSDAE_METHOD_PENALTY;
  o.dt = 0.02;
  o.redundant = NSDAE_REDUNDANT_LEAST_NORM;
  o.penalty_law = seed % 5;
  o.penalty_stiffness = 1e9;
  o.inner_steps_max = STEPS_MAX;
  o.start_check = 0;
  if (nsdae_sim_create(system, &o, &sim, NULL) == NSDAE_OK)
    status = nsdae_sim_init(sim, 0, r->q0, r->v0);
  for (int i = 0; sim && i < 15 && status >= 0; i++) {
    long before = r->calls[RANDOM_FORCE];
    status = nsdae_sim_step(sim);
    if (r->calls[RANDOM_FORCE] - before > most) most = r->calls[RANDOM_FORCE] - before;
  }
  *ended += status == NSDAE_E_CONVERGENCE &&
            strstr(nsdae_sim_error(sim)->text, "inner_steps_max") != NULL;
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  return most;
}

static void test_work(void **state)
{
  static random_system random;
  static const int hard[] = {501, 1267, 1461};
  int ended = 0;
  (void)state;
  for (int i = 0; i < 3; i++) assert_true(most_of(&random, hard[i], &ended) <= MOST);
  assert_int_equal(ended, 1);
  for (int seed = 1; seed <= 60; seed++) assert_true(most_of(&random, seed, &ended) <= MOST);
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_work)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
