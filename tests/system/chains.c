/* Chains and ragdolls that fall on a floor and on themselves, by both methods of the default
 * projection: every run ends, no joint is off by more than 1e-3 of its link, and the energy grows
 * by no more than the record of the projection explains. */
#include "check.h"

#include "support/articulated.h"

static const double link_length = 0.1;

typedef struct fall {
  nsdae_bodies *bodies;
  nsdae_system *system;
  nsdae_sim *sim;
  double link, e0;
} fall;

static void begin(fall *f, nsdae_bodies *b, int method, double dt, double link)
{
  nsdae_sim_options options;
  nsdae_dims dims;
  nsdae_record r;
  nsdae_error error;
  *f = (fall){.bodies = b, .link = link};
  int status = nsdae_bodies_system(b, &f->system);
  if (status < 0) print_error("%s\n", nsdae_bodies_error(b)->text);
  assert_true(status >= 0);
  nsdae_bodies_get_dims(b, &dims);
  double *q = test_calloc((size_t)(dims.nq + dims.nv), sizeof *q), *v = q + dims.nq;
  nsdae_bodies_get_start(b, q, v);
  nsdae_sim_options_default(&options);
  options.method = method;
  options.dt = dt;
  options.contact_tol = 1e-4;
  assert_int_equal(nsdae_sim_create(f->system, &options, &f->sim, &error), NSDAE_OK);
  status = nsdae_sim_init(f->sim, 0, q, v);
  if (status < 0) print_error("%s\n", nsdae_sim_error(f->sim)->text);
  assert_true(status >= 0);
  test_free(q);
  nsdae_sim_get_record(f->sim, &r);
  f->e0 = r.kinetic + r.potential;
}

/* The rotations of moreau's explicit gyroscopic terms gain up to 1e-3 of the energy. */
static void run(fall *f, double t_end)
{
  nsdae_record r;
  nsdae_stats stats;
  for (double t = 0; t < t_end; t = r.time) {
    int status = nsdae_sim_step(f->sim);
    if (status < 0) print_error("t = %g: %s\n", t, nsdae_sim_error(f->sim)->text);
    assert_true(status >= 0);
    nsdae_sim_get_record(f->sim, &r);
    if (!(r.constraint_drift <= 1e-3 * f->link)) print_error("t = %g\n", r.time);
    assert_true(r.constraint_drift <= 1e-3 * f->link);
    assert_true(r.kinetic + r.potential <= f->e0 + r.projection_energy + 1e-3 * f->e0);
  }
  nsdae_sim_get_stats(f->sim, &stats);
  assert_int_equal(stats.warnings & 4, 0); /* of drift */
  nsdae_sim_destroy(&f->sim);
  nsdae_system_destroy(&f->system);
  nsdae_bodies_destroy(&f->bodies);
}

static void test_chains(void **state)
{
  static const double along[4][3] = {{0, 0, 1}, {1, 0, 0}, {0, 0, -1}, {0.8, 0, 0.6}};
  static const int methods[2] = {NSDAE_METHOD_MOREAU, NSDAE_METHOD_IMPLICIT};
  uint64_t seed = 7;
  (void)state;
  for (int i = 0; i < 24; i += test_share()) {
    int links = 4 + random_below(&seed, 16), way = i % 4;
    int kind = i % 3 ? NSDAE_JOINT_SPHERICAL : NSDAE_JOINT_REVOLUTE, pinned = i % 5 == 0;
    const double from[3] = {0, 0, way == 2 ? (links + 1) * link_length : 2 * link_length};
    nsdae_bodies *b = articulated_world(random_between(&seed, 0, 0.8));
    fall f;
    articulated_chain(b, kind, links, link_length, from, along[way], pinned, &seed);
    begin(&f, b, methods[i / 4 % 2], i % 6 ? 2e-3 : 5e-4, link_length);
    run(&f, i % 6 ? 0.8 : 0.3);
  }
}

static void test_ragdolls(void **state)
{
  uint64_t seed = 8;
  (void)state;
  for (int i = 0; i < 4; i++) {
    nsdae_bodies *b = articulated_world(0.5);
    fall f;
    for (int l = 0; l < 3; l++) {
      const double centre[3] = {random_between(&seed, -0.2, 0.2), random_between(&seed, -0.2, 0.2),
                                1.4 + 1.9 * l};
      articulated_ragdoll(b, centre, random_between(&seed, 0, 6), i / 2);
    }
    begin(&f, b, i % 2 ? NSDAE_METHOD_MOREAU : NSDAE_METHOD_IMPLICIT, 2e-3, 0.3);
    run(&f, 1);
  }
}

/* Bodies that fall freely in contact have no velocities against each other but roundings. */
static void test_free_fall_in_contact(void **state)
{
  const double up[3] = {0, 0, 1};
  uint64_t seed = 9;
  (void)state;
  for (int i = 0; i < 2; i++) {
    nsdae_bodies *b = articulated_world(0.5);
    fall f;
    for (int l = 0; l < 2; l++) {
      const double from[3] = {0.5 * l, 0.39 * link_length * l, 3};
      articulated_chain(b, NSDAE_JOINT_SPHERICAL, 6, link_length, from, up, 0, &seed);
    }
    const double across[3] = {1, 0, 0}, from[3] = {-0.1, -0.39 * link_length, 3.3};
    articulated_chain(b, NSDAE_JOINT_SPHERICAL, 6, link_length, from, across, 0, &seed);
    begin(&f, b, i ? NSDAE_METHOD_MOREAU : NSDAE_METHOD_IMPLICIT, 2e-3, link_length);
    run(&f, 0.2);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_chains), cmocka_unit_test(test_ragdolls),
                                     cmocka_unit_test(test_free_fall_in_contact)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
