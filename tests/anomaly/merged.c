/* Impacts that follow one another within a step: a light body between two heavy ones that approach
 * each other hits them in turn, and elastic impacts of three bodies on a line are counted exactly.
 * A time-stepping method that finds fewer than half of them warns; one that finds all does not. Nor
 * do motions that settle or touch: balls that come to rest, stacks, heaps. */
#include "check.h"

#include <stdlib.h>
#include <string.h>

#include <nsdae/nsdae.h>

#include "random_system.h"

enum { IMPACTS = 16, N = 3, MOST = 40 };

static double between(uint64_t *state, double low, double high)
{
  return low + (high - low) * random_uniform(state);
}

/* Masses on a line. */
typedef struct line {
  int count;
  double m[MOST], q[MOST], v[MOST], weight;
} line;

static int mass(double t, const double *q, double *M, int ldm, void *user)
{
  const line *l = user;
  (void)t, (void)q;
  for (int i = 0; i < l->count; i++) M[i * ldm + i] = l->m[i];
  return 0;
}

static int force(double t, const double *q, const double *v, double *F, void *user)
{
  const line *l = user;
  (void)t, (void)q, (void)v;
  for (int i = 0; i < l->count; i++) F[i] = -l->weight * l->m[i];
  return 0;
}

/* Of neighbours; with weight the first is on a floor. */
static int gap(double t, const double *q, double *g, void *user)
{
  const line *l = user;
  (void)t;
  if (l->weight > 0) *g++ = q[0];
  for (int i = 0; i + 1 < l->count; i++) g[i] = q[i + 1] - q[i];
  return 0;
}

static nsdae_sim *start(line *l, int method, double dt, double e, nsdae_system **system)
{
  const nsdae_dims d = {.nq = l->count, .k = l->count - 1 + (l->weight > 0)};
  nsdae_sim_options o;
  nsdae_sim *sim;
  assert_int_equal(nsdae_system_create(&d, system, NULL), NSDAE_OK);
  nsdae_system_set_user(*system, l);
  nsdae_system_set_mass(*system, mass);
  nsdae_system_set_force(*system, force);
  nsdae_system_set_gap(*system, gap);
  for (int i = 0; i < d.k; i++) nsdae_system_set_contact(*system, i, 0, e, 0);
  nsdae_sim_options_default(&o);
  o.method = method;
  o.dt = dt;
  assert_int_equal(nsdae_sim_create(*system, &o, &sim, NULL), NSDAE_OK);
  assert_int_equal(nsdae_sim_init(sim, 0, l->q, l->v), NSDAE_OK);
  return sim;
}

/* Elastic impacts of three masses in turn, until none approaches; when the last is. */
static long count_exactly(line l, double *t)
{
  long impacts = 0;
  *t = 0;
  for (;; impacts++) {
    double u[2] = {l.v[0] - l.v[1], l.v[1] - l.v[2]}, next = INFINITY;
    int at = -1;
    for (int i = 0; i < 2; i++) {
      double wait = u[i] > 0 ? fmax(0, l.q[i + 1] - l.q[i]) / u[i] : INFINITY;
      if (wait < next) next = wait, at = i;
    }
    if (at < 0) return impacts;
    *t += next;
    for (int i = 0; i < N; i++) l.q[i] += next * l.v[i];
    double p = 2 * u[at] / (1 / l.m[at] + 1 / l.m[at + 1]);
    l.v[at] -= p / l.m[at];
    l.v[at + 1] += p / l.m[at + 1];
    l.q[at + 1] = fmax(l.q[at + 1], l.q[at]); /* the one that hit is not hit again by rounding */
  }
}

static line between_heavy_ones(uint64_t *random)
{
  line l = {.count = N};
  l.m[0] = between(random, 0.5, 2);
  l.m[2] = between(random, 0.5, 2);
  l.m[1] = pow(10, -between(random, 0, 6));
  for (int i = 0; i < N; i++) l.q[i] = i - 1 + between(random, -0.4, 0.4);
  l.v[0] = between(random, 0.2, 2);
  l.v[2] = -between(random, 0.2, 2);
  return l;
}

static void test_count(void **state)
{
  uint64_t random = 7;
  int warned = 0, all_found = 0;
  (void)state;
  for (int run = 0; run < 300; run++) {
    double t, dt = pow(10, -between(&random, 1.5, 4));
    line l = between_heavy_ones(&random);
    long exact = count_exactly(l, &t);
    nsdae_system *system;
    nsdae_stats stats;
    nsdae_sim *sim = start(&l, run % 3, dt, 1, &system);
    double expected =
        3.14159265358979324 / atan(sqrt(l.m[1] * (l.m[0] + l.m[1] + l.m[2]) / (l.m[0] * l.m[2])));
    int status = NSDAE_OK, said = 0;
    nsdae_record now = {0};
    while (now.time < t + 100 * dt && status >= 0) {
      status = nsdae_sim_step(sim);
      if (status == NSDAE_WARN_IMPACTS) {
        const char *at = strstr(nsdae_sim_error(sim)->text, "up to ");
        said++;
        assert_non_null(at);
        assert_near(strtod(at + 6, NULL), expected, 0.006 * expected); /* three digits */
        assert_true(fabs(expected - (double)exact) <= 1 + 1e-9);
      }
      nsdae_sim_get_record(sim, &now);
    }
    nsdae_sim_get_stats(sim, &stats);
    assert_int_equal(said, (stats.warnings & IMPACTS) != 0);
    if (2 * stats.impacts < exact && exact >= 20) assert_true(stats.warnings != 0);
    if (said) assert_true(stats.impacts < exact);
    warned += said;
    all_found += stats.impacts >= exact;
    nsdae_sim_destroy(&sim);
    nsdae_system_destroy(&system);
  }
  print_message("%d warned, %d found all\n", warned, all_found);
  assert_true(warned > 40 && all_found > 100);
}

/* Discs of masses up to 1000 apart fall on a floor between walls, in contacts by list. */
static nsdae_bodies *heap(uint64_t *random, double e)
{
  nsdae_bodies *b;
  assert_int_equal(nsdae_bodies_create(2, &b, NULL), NSDAE_OK);
  nsdae_bodies_set_gravity(b, (const double[]){0, -9.81, 0});
  for (int i = -1; i <= 1; i++) {
    const nsdae_solid plane = {
        .shape = NSDAE_SHAPE_PLANE, .position = {0.5 * i}, .angle = 1.5707963267948966 * i};
    nsdae_bodies_add_solid(b, NSDAE_GROUND, &plane);
  }
  for (int i = 0; i < 24; i++) {
    double r = between(random, 0.05, 0.08), m = pow(10, between(random, -3, 0));
    const nsdae_solid disc = {.shape = NSDAE_SHAPE_DISC, .radius = r};
    const nsdae_rigid_body body = {
        .mass = m,
        .inertia = {0, 0, m * r * r / 2},
        .position = {0.23 * (i % 4) - between(random, 0.33, 0.35), 0.1 + 0.2 * (i / 4)}};
    nsdae_bodies_add(b, &body);
    nsdae_bodies_add_solid(b, i, &disc);
  }
  nsdae_bodies_set_pair(b, 0, 0, 0.3, e, 0);
  return b;
}

/* Bits of the warnings of a run. */
static int run_bodies(nsdae_bodies *b, int method, double dt, double t_end)
{
  double q[3 * MOST], v[3 * MOST];
  nsdae_system *system;
  nsdae_sim *sim;
  nsdae_sim_options o;
  nsdae_stats stats;
  nsdae_sim_options_default(&o);
  o.method = method;
  o.dt = dt;
  assert_true(nsdae_bodies_system(b, &system) >= 0);
  assert_int_equal(nsdae_sim_create(system, &o, &sim, NULL), NSDAE_OK);
  nsdae_bodies_get_start(b, q, v);
  assert_int_equal(nsdae_sim_init(sim, 0, q, v), NSDAE_OK);
  assert_true(nsdae_sim_run(sim, t_end) >= 0);
  nsdae_sim_get_stats(sim, &stats);
  assert_true(stats.impacts > 0);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  nsdae_bodies_destroy(&b);
  return stats.warnings;
}

static void test_heaps(void **state)
{
  uint64_t random = 3;
  (void)state;
  for (int run = 0; run < 12; run += test_share())
    assert_false(run_bodies(heap(&random, 0.2 * (run % 4)), run % 3, 2e-3, 1) & IMPACTS);
}

/* The light disc and the two heavy ones of the kit, by list. */
static void test_list(void **state)
{
  (void)state;
  for (int light = 0; light < 2; light++) {
    nsdae_bodies *b;
    assert_int_equal(nsdae_bodies_create(2, &b, NULL), NSDAE_OK);
    for (int i = 0; i < 3; i++) {
      const nsdae_solid disc = {.shape = NSDAE_SHAPE_DISC, .radius = 0.3};
      const nsdae_rigid_body body = {.mass = i == 1 && light ? 1e-4 : 1,
                                     .inertia = {0, 0, 1},
                                     .position = {i - 1.0},
                                     .velocity = {1.0 - i}};
      nsdae_bodies_add(b, &body);
      nsdae_bodies_add_solid(b, i, &disc);
    }
    nsdae_bodies_set_pair(b, 0, 0, 0, 1, 0);
    assert_int_equal(run_bodies(b, NSDAE_METHOD_IMPLICIT, 1.1e-3, 1), light ? IMPACTS : 0);
  }
}

/* Balls on a floor under weight, masses up to 1e6 apart: at rest from the start, or one that
 * bounces until it rests. */
static void test_rest(void **state)
{
  uint64_t random = 9;
  (void)state;
  for (int run = 0; run < 100; run++) {
    line l = {.count = run % 2 ? 1 : 4, .weight = 9.81};
    nsdae_system *system;
    nsdae_stats stats;
    for (int i = 0; i < l.count; i++) l.m[i] = pow(10, -between(&random, 0, 6));
    if (run % 2) l.q[0] = between(&random, 0.1, 1);
    nsdae_sim *sim =
        start(&l, run % 3, pow(10, -between(&random, 2, 3)), between(&random, 0, 1), &system);
    if (nsdae_sim_run(sim, 2) < 0) fail_msg("run %d: %s", run, nsdae_sim_error(sim)->text);
    nsdae_sim_get_stats(sim, &stats);
    assert_int_equal(stats.warnings & IMPACTS, 0);
    nsdae_sim_destroy(&sim);
    nsdae_system_destroy(&system);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_count), cmocka_unit_test(test_heaps),
                                     cmocka_unit_test(test_list), cmocka_unit_test(test_rest)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
