/* A model with fixed contacts and the same as a contact list, of the same blocks and in the same
 * order, are one model: by every time-stepping method they have the same bytes, certificates of
 * laws and constraints included. */
#include "check.h"

#include <string.h>

#include "as_list.h"
#include "bouncing_ball.h"
#include "clearance_hinge.h"
#include "falling_rod.h"
#include "incline.h"
#include "newtons_cradle.h"
#include "pendulum.h"
#include "random_system.h"
#include "rolling_ball.h"
#include "twin.h"
#include "woodpecker.h"

static const driver_model *const models[] = {
    &bouncing_ball_model,  &clearance_hinge_model, &falling_rod_model,  &incline_model,
    &newtons_cradle_model, &pendulum_model,        &rolling_ball_model, &woodpecker_model};
enum { MODELS = sizeof models / sizeof *models, METHODS = 3, SEEDS = 120 };
/* Of directions by differences a list does not know: fixed contacts iterate as far as those are
 * good. */
static const double iteration_tol = 1e-9;
static const int methods[METHODS] = {NSDAE_METHOD_IMPLICIT, NSDAE_METHOD_IMPLICIT_PRINTED,
                                     NSDAE_METHOD_MOREAU};

static int apart(int n, const double *a, const double *b)
{
  return n > 0 && memcmp(a, b, (size_t)n * sizeof *a) != 0;
}

/* Impulses of the list by their ids. */
static void expect_same_contacts(const nsdae_dims *d, const nsdae_record *fixed,
                                 const nsdae_record *list)
{
  int listed = 0;
  for (int i = 0; i < d->k; i++) {
    int a = 0;
    while (a < list->contacts.count && list->contacts.id[a] != i) a++;
    listed += a < list->contacts.count;
    if (a == list->contacts.count) {
      assert_true(fixed->normal_impulse[i] == 0);
      continue;
    }
    assert_true(fixed->normal_impulse[i] == list->contacts.normal_impulse[a]);
    assert_int_equal(fixed->mode[i], list->contacts.mode[a]);
    assert_false(apart(d->nt, fixed->tangential_impulse + i * d->nt,
                       list->contacts.tangential_impulse + a * d->nt));
  }
  assert_int_equal(listed, list->contacts.count);
}

static void expect_same(const nsdae_dims *d, const nsdae_record *fixed, const nsdae_record *list)
{
  const nsdae_certificate *a = &fixed->certificate, *b = &list->certificate;
  assert_false(apart(d->nq, fixed->q, list->q));
  assert_false(apart(d->nv, fixed->v, list->v));
  assert_false(apart(d->m, fixed->multiplier, list->multiplier));
  assert_false(apart(d->f, fixed->frictional_joint_impulse, list->frictional_joint_impulse));
  expect_same_contacts(d, fixed, list);
  assert_true(fixed->lcp_residual == list->lcp_residual);
  assert_true(a->pull == b->pull && a->cone_excess == b->cone_excess);
  assert_true(a->complementarity == b->complementarity);
  assert_true(a->constraint_drift == b->constraint_drift);
  assert_int_equal(fixed->impacts, list->impacts);
}

/* Steps of both; the count, and how many had an impulse. */
static long compare(const nsdae_system *system, as_list *copy, const nsdae_sim_options *options,
                    const double *q0, const double *v0, long steps)
{
  nsdae_sim *sim[2];
  nsdae_record record[2];
  nsdae_dims d;
  const nsdae_system *of[2] = {system, as_list_system(copy)};
  int status[2];
  long pressed = 0;
  for (int i = 0; i < 2; i++) {
    assert_int_equal(nsdae_sim_create(of[i], options, &sim[i], NULL), NSDAE_OK);
    status[i] = nsdae_sim_init(sim[i], 0, q0, v0);
  }
  nsdae_sim_get_dims(sim[0], &d);
  assert_int_equal(status[0] < 0, status[1] < 0);
  for (long step = 0; step < steps && status[0] >= 0; step++) {
    for (int i = 0; i < 2; i++) status[i] = nsdae_sim_step(sim[i]);
    assert_int_equal(status[0] < 0, status[1] < 0);
    if (status[0] < 0) break;
    for (int i = 0; i < 2; i++) nsdae_sim_get_record(sim[i], &record[i]);
    expect_same(&d, &record[0], &record[1]);
    int any = 0;
    for (int i = 0; i < d.k; i++) any |= record[0].normal_impulse[i] > 0;
    pressed += any;
  }
  for (int i = 0; i < 2; i++) nsdae_sim_destroy(&sim[i]);
  return pressed;
}

static void test_models(void **state)
{
  (void)state;
  for (int m = 0; m < MODELS * METHODS; m++) {
    const driver_model *model = models[m / METHODS];
    nsdae_system *system;
    nsdae_sim_options options;
    double q0[32] = {0}, v0[32] = {0};
    nsdae_params_default(model->parameters, model->base);
    assert_int_equal(model->build(model->base, &system, NULL), NSDAE_OK);
    model->start(model->base, q0, v0);
    nsdae_sim_options_default(&options);
    options.method = methods[m % METHODS];
    options.dt = 1e-3;
    options.iteration_tol = iteration_tol;
    as_list *copy = as_list_create(system, 0, NULL, NULL);
    assert_non_null(copy);
    compare(system, copy, &options, q0, v0, 1000);
    as_list_destroy(copy);
    nsdae_system_destroy(&system);
  }
}

/* With the cone or polygons of two tangential directions. */
static long compare_random(int polygon)
{
  long pressed = 0;
  for (uint64_t seed = 1; seed <= SEEDS; seed++)
    for (int m = 0; m < METHODS; m++) {
      random_system r;
      nsdae_sim_options options;
      random_system_draw(&r, seed, RANDOM_PLAIN);
      if (r.dims.k == 0) continue;
      if (r.by_blocks) continue; /* lists have none of more than two blocks */
      if (polygon > 0 && r.dims.nt < 2) continue;
      nsdae_system *system = random_system_make(&r);
      as_list *copy = as_list_create(system, 0, NULL, NULL);
      nsdae_sim_options_default(&options);
      options.method = methods[m];
      options.dt = 1e-2;
      options.iteration_tol = iteration_tol;
      options.polygon = polygon;
      options.start_check = 0; /* a list is not compared with its directions */
      pressed += compare(system, copy, &options, r.q0, r.v0, 60);
      as_list_destroy(copy);
      nsdae_system_destroy(&system);
    }
  return pressed;
}

static void test_random(void **state)
{
  (void)state;
  assert_true(compare_random(0) > 1000);
}

static void test_polygons(void **state)
{
  (void)state;
  assert_true(compare_random(8) > 100);
}

/* Many blocks, constraints between them, contacts of two. */
static void test_twins(void **state)
{
  (void)state;
  long pressed = 0;
  static twin t;
  for (uint64_t seed = 1; seed <= 24; seed++)
    for (int m = 0; m < METHODS; m++) {
      const twin_kind kind = {.blocks = 3 + (int)(seed % 9),
                              .largest = 3,
                              .joined = seed % 2 == 0,
                              .k = 4 + (int)(seed % 7),
                              .nt = (int)(seed / 3 % 2),
                              .friction = 0.5,
                              .restitution = 0.5};
      nsdae_sim_options options;
      twin_draw(&t, seed, &kind);
      nsdae_system *system = twin_numbered(&t, TWIN_BY_ROWS);
      as_list *copy = as_list_create(system, 0, NULL, NULL);
      nsdae_sim_options_default(&options);
      options.method = methods[m];
      options.dt = 1e-2;
      options.iteration_tol = iteration_tol;
      pressed += compare(system, copy, &options, t.q0, t.v0, 100);
      as_list_destroy(copy);
      nsdae_system_destroy(&system);
    }
  assert_true(pressed > 1000);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_models),
      cmocka_unit_test(test_random),
      cmocka_unit_test(test_polygons),
      cmocka_unit_test(test_twins),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
