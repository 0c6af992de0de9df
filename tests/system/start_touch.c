/* Starts of event whose contacts overlap by less than start_tol, at gradients of the gap of 1 to
 * 1e-4: the run begins at gap 0, and its end is known exactly. And overlaps beyond start_tol. */
#include "check.h"

#include <nsdae/nsdae.h>

#include "support/random.h"

enum { LEVERS_MOST = 3, SEEDS = 120 };

/* A lever turns by q, its load by p = q; the constraint is there `twice` or once. Contacts press on
 * gap = h (sin q + a), on twice that, and, far away, on h (2 - sin q). The moment is s t - 1. */
typedef struct lever {
  double h, a, s;
} lever;

typedef struct levers {
  int count, twice;
  double apart; /* of the two constraints: within start_tol */
  lever at[LEVERS_MOST];
} levers;

static const double inertia = 0.4, load = 0.6; /* of q and of p: 1 together */

static uint64_t seed;

static double uniform(double from, double to)
{
  return random_between(&seed, from, to);
}

static int mass(double t, const double *q, double *M, int ldm, void *user)
{
  const levers *l = user;
  (void)t, (void)q;
  for (int i = 0; i < 2 * l->count; i++) M[i * (ldm + 1)] = i % 2 ? load : inertia;
  return 0;
}

static int force(double t, const double *q, const double *v, double *F, void *user)
{
  const levers *l = user;
  (void)q, (void)v;
  for (int i = 0; i < l->count; i++) F[2 * i] = l->at[i].s * t - 1;
  return 0;
}

static int constraint(double t, const double *q, double *phi, void *user)
{
  const levers *l = user;
  int each = 1 + l->twice;
  (void)t;
  for (int i = 0; i < each * l->count; i++)
    phi[i] = q[2 * (i / each)] - q[2 * (i / each) + 1] + (i % each) * l->apart;
  return 0;
}

static int gap(double t, const double *q, double *g, void *user)
{
  const levers *l = user;
  (void)t;
  for (int i = 0; i < l->count; i++) {
    const lever *at = &l->at[i];
    g[3 * i] = at->h * (sin(q[2 * i]) + at->a);
    g[3 * i + 1] = 2 * g[3 * i];
    g[3 * i + 2] = at->h * (2 - sin(q[2 * i]));
  }
  return 0;
}

static nsdae_system *make(levers *l)
{
  const nsdae_dims dims = {.nq = 2 * l->count, .m = (1 + l->twice) * l->count, .k = 3 * l->count};
  nsdae_system *s;
  assert_int_equal(nsdae_system_create(&dims, &s, NULL), NSDAE_OK);
  nsdae_system_set_user(s, l);
  nsdae_system_set_mass(s, mass);
  nsdae_system_set_force(s, force);
  nsdae_system_set_constraint(s, constraint);
  nsdae_system_set_gap(s, gap);
  for (int i = 0; i < dims.k; i++) nsdae_system_set_contact(s, i, 0, 0.5, 0);
  return s;
}

/* Overlaps of the second contacts below their bounds, 1e-6 (1 + ...). */
static void draw(levers *l, double *q, double *v)
{
  *l = (levers){.count = 1 + (int)uniform(0, LEVERS_MOST), .twice = uniform(0, 1) < 0.5};
  if (l->twice && uniform(0, 1) < 0.5) l->apart = pow(10, uniform(-12, -7));
  for (int i = 0; i < l->count; i++) {
    lever *at = &l->at[i];
    *at = (lever){pow(10, uniform(-4, 0)), uniform(-0.5, 0.5), uniform(2, 5)};
    double overlap = uniform(0, 1) < 0.8 ? pow(10, uniform(-13, -6.1)) : 0;
    q[2 * i] = q[2 * i + 1] = asin(-at->a - overlap / (2 * at->h));
    v[2 * i] = v[2 * i + 1] = 0;
  }
}

static int beyond(const nsdae_record *r, nsdae_error *error, void *user)
{
  const levers *l = user;
  (void)error;
  for (int i = 0; i < 3 * l->count; i++)
    if (!(r->gap[i] >= -1e-14)) return 1;
  return 0;
}

/* Each lifts at t = 1 / s, when its moment turns: q = q_0 + s (t - 1 / s)^3 / 6. */
static void compare(const levers *l, const nsdae_record *r)
{
  for (int i = 0; i < l->count; i++) {
    const lever *at = &l->at[i];
    double late = r->time - 1 / at->s, q = asin(-at->a) + at->s * late * late * late / 6;
    assert_near(r->q[2 * i], q, 2e-7);
    assert_near(r->q[2 * i + 1], q, 2e-7 + l->apart);
    assert_near(r->v[2 * i], at->s * late * late / 2, 2e-6);
  }
}

static void test_levers(void **state)
{
  (void)state;
  for (seed = 1; seed <= SEEDS; seed++) {
    unsigned long long start = seed;
    levers l;
    double q[2 * LEVERS_MOST], v[2 * LEVERS_MOST];
    nsdae_sim_options o;
    nsdae_sim *sim;
    nsdae_record r;
    draw(&l, q, v);
    nsdae_system *system = make(&l);
    nsdae_sim_options_default(&o);
    o.method = NSDAE_METHOD_EVENT;
    o.dt = 0.02;
    o.redundant = l.twice ? NSDAE_REDUNDANT_LEAST_NORM : NSDAE_REDUNDANT_ERROR;
    assert_int_equal(nsdae_sim_create(system, &o, &sim, NULL), NSDAE_OK);
    nsdae_sim_observe(sim, beyond, &l);
    int status = nsdae_sim_init(sim, 0, q, v);
    if (status == NSDAE_OK) status = nsdae_sim_run(sim, 0.7);
    if (status != NSDAE_OK) print_error("seed %llu: %s\n", start, nsdae_sim_error(sim)->text);
    assert_int_equal(status, NSDAE_OK);
    nsdae_sim_get_record(sim, &r);
    compare(&l, &r);
    nsdae_sim_destroy(&sim);
    nsdae_system_destroy(&system);
    seed = start;
  }
}

/* The least change in the metric of M: two coordinates of masses 1 and 4 share one gap
 * h (x + y) = -e, so that they move by e / h times (4, 1) / 5. */
static int pair_mass(double t, const double *q, double *M, int ldm, void *user)
{
  (void)t, (void)q, (void)user;
  M[0] = 1;
  M[ldm + 1] = 4;
  return 0;
}

static int pair_force(double t, const double *q, const double *v, double *F, void *user)
{
  (void)t, (void)q, (void)v, (void)user;
  F[0] = -1;
  return 0;
}

static int pair_gap(double t, const double *q, double *g, void *user)
{
  (void)t;
  g[0] = *(double *)user * (q[0] + q[1]);
  return 0;
}

static nsdae_sim *pair(double *h, int method, nsdae_system **system)
{
  const nsdae_dims dims = {.nq = 2, .k = 1};
  nsdae_sim_options o;
  nsdae_sim *sim;
  assert_int_equal(nsdae_system_create(&dims, system, NULL), NSDAE_OK);
  nsdae_system_set_user(*system, h);
  nsdae_system_set_mass(*system, pair_mass);
  nsdae_system_set_force(*system, pair_force);
  nsdae_system_set_gap(*system, pair_gap);
  nsdae_system_set_contact(*system, 0, 0, 0, 0);
  nsdae_sim_options_default(&o);
  o.method = method;
  assert_int_equal(nsdae_sim_create(*system, &o, &sim, NULL), NSDAE_OK);
  return sim;
}

static void test_least_change(void **state)
{
  (void)state;
  for (double h = 1; h > 5e-5; h /= 10) {
    nsdae_system *system;
    nsdae_sim *sim = pair(&h, NSDAE_METHOD_EVENT, &system);
    nsdae_record r;
    const double overlap = 9e-7, way = overlap / h, q[2] = {0.3, -0.3 - way}, v[2] = {0};
    assert_int_equal(nsdae_sim_init(sim, 0, q, v), NSDAE_OK);
    nsdae_sim_get_record(sim, &r);
    assert_near(r.q[0], q[0] + 0.8 * way, 1e-9 * way + 1e-15);
    assert_near(r.q[1], q[1] + 0.2 * way, 1e-9 * way + 1e-15);
    assert_near(r.gap[0], 0, 1e-15);
    nsdae_sim_destroy(&sim);
    nsdae_system_destroy(&system);
  }
}

/* Beyond start_tol: event refuses it by contact and depth, time stepping reports it once and keeps
 * it. */
static void test_deep(void **state)
{
  (void)state;
  double h = 1;
  const int methods[] = {NSDAE_METHOD_EVENT, NSDAE_METHOD_IMPLICIT, NSDAE_METHOD_IMPLICIT_PRINTED,
                         NSDAE_METHOD_MOREAU};
  for (int i = 0; i < 4; i++) {
    nsdae_system *system;
    nsdae_sim *sim = pair(&h, methods[i], &system);
    nsdae_stats stats;
    const double q[2] = {0.3, -0.3125}, v[2] = {0};
    const nsdae_error *error = nsdae_sim_error(sim);
    int status = nsdae_sim_init(sim, 0, q, v);
    assert_int_equal(status, i == 0 ? NSDAE_E_ARGUMENT : NSDAE_OK);
    if (i > 0) assert_int_equal(nsdae_sim_step(sim), NSDAE_WARN_PENETRATION);
    assert_non_null(strstr(error->text, "contact 0 overlaps by 0.0125 at the start"));
    assert_non_null(strstr(error->text, "nsdae_sim_project"));
    assert_int_equal(error->index, 0);
    assert_string_equal(error->argument, "q0");
    if (i > 0) {
      assert_int_equal(nsdae_sim_run(sim, 0.1), NSDAE_OK);
      nsdae_sim_get_stats(sim, &stats);
      assert_int_equal(stats.warnings, 2);
      assert_near(stats.worst_penetration, 0.0125, 1e-15);
      assert_int_equal(nsdae_sim_init(sim, 0, q, v), NSDAE_OK);
      assert_int_equal(nsdae_sim_run(sim, 0.1), NSDAE_WARN_PENETRATION); /* anew */
    }
    nsdae_sim_destroy(&sim);
    nsdae_system_destroy(&system);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_levers),
                                     cmocka_unit_test(test_least_change),
                                     cmocka_unit_test(test_deep)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
