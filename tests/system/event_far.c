/* The origin may be anywhere: random systems (random_system.h) by the event-driven method, and the
 * same 10 km away in every coordinate, where rtol of a place is no measure of a gap or of a step.
 * Both have the same motion, to what rtol of the motion explains: where tolerances of a tenth leave
 * it as it is, so that it is neither chaotic nor about to take another order of impacts, they end
 * at the same place. Derivatives by differences are worth (eps |q|)^(2/3) there (differences.h).
 * NSDAE_FAR is how many seeds are looked at (100), at rtol 1e-6 and 1e-8. */
#include "check.h"

#include <stdlib.h>

#include "failing_system.h"
#include "random_system.h"

static const double T = 1, AWAY = 1e4;

typedef struct end {
  int status, differences;
  nsdae_stats stats;
  double q[RANDOM_NQ], v[RANDOM_NQ]; /* as seen from where it started */
} end;

static void read(nsdae_sim *sim, const nsdae_dims *d, double shift, end *e)
{
  nsdae_record r;
  if (nsdae_sim_get_record(sim, &r) < 0) return; /* a start that was refused has none */
  nsdae_sim_get_stats(sim, &e->stats);
  for (int i = 0; i < d->nq; i++) e->q[i] = r.q[i] - shift;
  for (int i = 0; i < d->nv; i++) e->v[i] = r.v[i];
}

static end go(uint64_t seed, double rtol, double shift)
{
  static random_system random;
  static failing_system there;
  double q0[RANDOM_NQ];
  nsdae_sim *sim;
  nsdae_sim_options o;
  end e = {0};
  random_system_draw(&random, seed, RANDOM_PLAIN);
  nsdae_system *inner = random_system_make(&random), *system = failing_system_make(&there, inner);
  there.shift = shift;
  for (int i = 0; i < random.dims.nq; i++) q0[i] = random.q0[i] + shift;
  nsdae_sim_options_default(&o);
  o.method = NSDAE_METHOD_EVENT;
  o.dt = 0.02;
  o.rtol = rtol;
  o.atol = 1e-3 * rtol;
  e.differences = nsdae_system_differences(system)[0] != 0;
  assert_int_equal(nsdae_sim_create(system, &o, &sim, NULL), NSDAE_OK);
  e.status = nsdae_sim_init(sim, 0, q0, random.v0);
  if (e.status >= 0) e.status = nsdae_sim_run(sim, T);
  read(sim, &random.dims, shift, &e);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  nsdae_system_destroy(&inner);
  return e;
}

static double distance(const end *a, const end *b)
{
  double most = 0;
  for (int i = 0; i < RANDOM_NQ; i++)
    most = fmax(most, fmax(fabs(a->q[i] - b->q[i]), fabs(a->v[i] - b->v[i])));
  return most;
}

/* Whether a tenth of the tolerances makes no other motion of it. */
static int is_tame(const end *a, const end *b, double rtol)
{
  return a->status >= 0 && a->status == b->status && a->stats.impacts == b->stats.impacts &&
         a->stats.fallback_steps == 0 && distance(a, b) < 1e3 * rtol;
}

static void look(int seeds, double rtol)
{
  int compared = 0, bad = 0;
  for (int seed = 1; seed <= seeds; seed++) {
    end here = go((uint64_t)seed, rtol, 0), finer = go((uint64_t)seed, rtol / 10, 0);
    if (!is_tame(&here, &finer, rtol)) continue;
    end there = go((uint64_t)seed, rtol, AWAY);
    double off = distance(&here, &there), differences = pow(2.2e-16 * AWAY, 2.0 / 3);
    double most = 10 * distance(&here, &finer) + 100 * (rtol + here.differences * differences);
    compared++;
    if (there.status >= 0 && off <= most) continue;
    print_message("seed %d: status %d, %.3g off, of %.3g\n", seed, there.status, off, most);
    bad++;
  }
  print_message("rtol %g: %d systems, %d compared, %d bad\n", rtol, seeds, compared, bad);
  assert_true(compared >= seeds / 2);
  assert_int_equal(bad, 0);
}

static void test_far(void **state)
{
  (void)state;
  const char *asked = getenv("NSDAE_FAR");
  look(asked ? atoi(asked) : 100, 1e-6);
  look(asked ? atoi(asked) : 100, 1e-8);
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_far)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
