/* Random drops by the event-driven method, seeded: boxes, rods, discs and groups of them, in the
 * plane and in space, on floors, in grooves and corners, with e from 0 to 1, mu from 0 to 2 and
 * rtol from 1e-4 to 1e-11. Every run ends; one that says it went well has no drift, penetration or
 * gain of energy beyond 100 rtol. The environment's NSDAE_DROPS is how many (40). */
#include "check.h"

#include <stdlib.h>

#include "drop.h"

typedef struct seen {
  double start, most; /* energy: at the start, the most at any record */
} seen;

static int look(const nsdae_record *record, nsdae_error *error, void *user)
{
  seen *s = user;
  double energy = record->kinetic + record->potential;
  (void)error;
  if (record->step == 0) s->start = s->most = energy;
  s->most = fmax(s->most, energy);
  return 0;
}

static void expect_true(int holds, const drop *d, const char *what, double value)
{
  if (!holds) print_message("drop %s: %s %.3g\n", d->name, what, value);
  assert_true(holds);
}

/* Jamming ends a run, as there is no force that solves the equations; else nothing may. */
static void check_failure(const drop *d, const nsdae_sim *sim, int status)
{
  const nsdae_error *error = nsdae_sim_error(sim);
  if (status != NSDAE_E_PAINLEVE) print_message("drop %s: %s\n", d->name, error->text);
  assert_int_equal(status, NSDAE_E_PAINLEVE);
  assert_true(error->text[0] != 0 && error->time > 0);
}

static int run(drop *d)
{
  nsdae_sim_options o;
  nsdae_sim *sim;
  nsdae_stats stats;
  seen energy = {0};
  nsdae_system *system = drop_system(d);
  nsdae_sim_options_default(&o);
  o.method = NSDAE_METHOD_EVENT;
  o.rtol = d->rtol;
  o.atol = fmin(o.atol, d->rtol * 1e-2);
  assert_int_equal(nsdae_sim_create(system, &o, &sim, NULL), NSDAE_OK);
  nsdae_sim_observe(sim, look, &energy);
  assert_int_equal(nsdae_sim_init(sim, 0, d->q0, d->v0), NSDAE_OK);
  int status = nsdae_sim_run(sim, 1.5);
  nsdae_sim_get_stats(sim, &stats);
  double scale = d->m * d->g * (1 + d->size) + fabs(energy.start), most = 100 * d->rtol;
  if (status < 0) check_failure(d, sim, status);
  if (status >= 0 && stats.fallback_steps == 0) {
    double penetration = stats.worst_penetration, balance = fabs(stats.energy_balance);
    double gain = energy.most - energy.start;
    expect_true(penetration <= most * fmax(1, d->size), d, "penetration", penetration);
    expect_true(balance <= most * scale, d, "energy balance", balance);
    expect_true(gain <= most * scale, d, "gain of energy", gain);
  }
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  return stats.fallback_steps > 0;
}

static void test_drops(void **state)
{
  (void)state;
  const char *asked = getenv("NSDAE_DROPS");
  int count = asked ? atoi(asked) : 40, fallbacks = 0;
  for (int i = 0; i < count; i++) {
    drop d;
    drop_make(&d, (unsigned long)i);
    fallbacks += run(&d);
  }
  print_message("%d drops, %d with steps by implicit\n", count, fallbacks);
  assert_at_most(fallbacks, 1 + 0.02 * count);
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_drops)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
