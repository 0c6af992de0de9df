/* The examples of joints, motors and contacts against their closed forms: a gripper at its limit
 * of friction, a Geneva drive, gears with backlash, a cam, and a ragdoll by its invariants. */
#include "check.h"

#include "backlash.h"
#include "cam.h"
#include "geneva.h"
#include "gripper.h"
#include "ragdoll.h"
#include "simulation.h"
#include "support/random.h"

static int follow(const nsdae_record *r, nsdae_error *error, void *user)
{
  const driver_model *model = user;
  (void)error;
  model->follow(model->base, r);
  return 0;
}

/* Runs the model with the parameters at its base. */
static nsdae_stats run(const driver_model *model, int method, double dt, double t_end)
{
  nsdae_system *system = NULL;
  nsdae_sim *sim = NULL;
  nsdae_stats stats;
  nsdae_error error;
  nsdae_sim_options options;
  nsdae_sim_options_default(&options);
  options.method = method;
  options.dt = dt;
  int status = simulation_make(model, &options, &system, &sim, &error);
  if (status < 0) print_error("%s: %s\n", model->name, error.text);
  assert_true(status >= 0);
  assert_int_equal(nsdae_sim_observe(sim, follow, (void *)(uintptr_t)model), NSDAE_OK);
  status = nsdae_sim_run(sim, t_end);
  if (status < 0) print_error("%s: %s\n", model->name, nsdae_sim_error(sim)->text);
  assert_true(status >= 0);
  nsdae_sim_get_stats(sim, &stats);
  simulation_release(&system, &sim);
  return stats;
}

/* Stick is exact: in 100 s the box moves beside the fingers by rounding of its coordinates alone,
 * steps of 1e-16 m at most, also 1 % above the least force. 1 % below it slips. */
static void test_gripper(void **state)
{
  static const struct {
    int method;
    double dt, t_end;
  } runs[] = {{NSDAE_METHOD_MOREAU, 5e-3, 100},
              {NSDAE_METHOD_IMPLICIT, 5e-3, 100},
              {NSDAE_METHOD_EVENT, 1e-2, 2}};
  gripper *p = gripper_model.base;
  (void)state;
  for (int i = 0; i < 3; i++)
    for (int part = -1; part <= 1; part++) {
      nsdae_params_default(gripper_model.parameters, p);
      if (part) p->force = (1 + 0.01 * part) * gripper_least_force(p);
      double t_end =
          part ? fmin(runs[i].t_end, 2) : fmin(runs[i].t_end, test_share() > 1 ? 20 : 100);
      run(&gripper_model, runs[i].method, runs[i].dt, t_end);
      if (part >= 0) assert_at_most(p->slip, 1e-16 * t_end / runs[i].dt);
      assert_int_equal(p->slip > 1e-6, part < 0);
    }
}

/* With a brake that is stronger than J phi'' the pin pushes all the time, with a weaker one it goes
 * over to the other side of its slot. The wheel is within the play of the closed form, and what
 * the method lets bodies overlap. It has turned by 2 pi / n a turn, and in dwells it is at rest. */
static void test_geneva(void **state)
{
  static const int methods[] = {NSDAE_METHOD_MOREAU, NSDAE_METHOD_IMPLICIT, NSDAE_METHOD_EVENT};
  geneva *p = geneva_model.base;
  uint64_t seed = 3;
  (void)state;
  for (int i = 0; i<12; i += test_share()> 1 ? 5 : 1) { /* each method */
    nsdae_params_default(geneva_model.parameters, p);
    p->slots = 3 + i % 6;
    p->play = pow(10, random_between(&seed, -5, -3));
    p->brake = i % 4 ? 0.25 : 0.01;
    double turn = 2 * 3.14159265358979323846 / p->speed, dt = 1e-3;
    const int turns = test_share() > 1 ? 1 : 3;
    nsdae_stats s = run(&geneva_model, methods[i % 3], dt, turns * turn);
    double bound = geneva_bound(p, s.worst_penetration) + 1e-12;
    assert_at_most(p->error, bound);
    assert_near(p->turned, turns * 2 * 3.14159265358979323846 / p->slots, bound);
    assert_at_most(p->moving, 1e-12);
  }
}

/* The load follows the play operator, with the least brake too. A time step finds a stop up to a
 * step late and a reversal within a step. So each is off by at most two steps of the gear's
 * fastest. */
static void test_backlash(void **state)
{
  static const int methods[] = {NSDAE_METHOD_EVENT, NSDAE_METHOD_MOREAU, NSDAE_METHOD_IMPLICIT};
  backlash *p = backlash_model.base;
  uint64_t seed = 5;
  (void)state;
  for (int i = 0; i<12; i += test_share()> 1 ? 5 : 1) { /* each method */
    const double dt = i % 2 ? 1e-3 : 2e-3;
    nsdae_params_default(backlash_model.parameters, p);
    p->amplitude = random_between(&seed, -2, 2);
    p->teeth[0] = 10 + random_below(&seed, 40);
    p->play = random_between(&seed, 0.01, 0.5);
    p->brake = (i % 4 ? 2 : 1.001) * backlash_least_brake(p);
    double a = fabs(p->amplitude) * p->teeth[0] / p->teeth[1];
    nsdae_stats s = run(&backlash_model, methods[i % 3], dt, 8);
    assert_at_most(p->error,
                   methods[i % 3] == NSDAE_METHOD_EVENT ? 1e-10 : 2 * a * p->frequency * dt);
    assert_int_equal(s.impacts > 0, a > p->play / 2);
  }
}

/* The lift of random cams: what it is off by is that of chords and penetration; by event it is that
 * of the chords. With less than the least preload the follower leaves the cam. */
static void test_cam(void **state)
{
  static const struct {
    int method;
    double dt;
  } runs[] = {
      {NSDAE_METHOD_MOREAU, 1e-4}, {NSDAE_METHOD_IMPLICIT, 1e-4}, {NSDAE_METHOD_EVENT, 1e-3}};
  cam *p = cam_model.base;
  uint64_t seed = 5;
  (void)state;
  for (int i = 0; i<9; i += test_share()> 1 ? 4 : 1) { /* each method, with both preloads */
    nsdae_params_default(cam_model.parameters, p);
    p->rise = random_between(&seed, 1.9, 3.1);
    p->lift = random_between(&seed, 0.2, 0.9) * p->radius * p->rise * p->rise / (2 * acos(-1));
    p->corners = 90 + 30 * (i % 3);
    int leaves = i >= 6, event = runs[i % 3].method == NSDAE_METHOD_EVENT;
    if (leaves) p->speed = 40;
    p->preload = leaves ? 0.3 * cam_least_preload(p) : 3 + 3 * cam_least_preload(p);
    run(&cam_model, runs[i % 3].method, runs[i % 3].dt, 0.32);
    print_message("cam: off by %.2e m, chords %.2e m, penetration %.1e m, preload %.3g of %.3g N\n",
                  p->error, cam_bound(p), p->depth, p->preload, cam_least_preload(p));
    if (leaves)
      assert_true(p->error > 10 * (cam_bound(p) + p->depth));
    else
      assert_at_most(p->error, cam_bound(p) + p->depth + (event ? 1e-9 : 0));
  }
}

/* Falls on stairs of all kinds: no joint is off by more than 1e-3 of its link, of which the
 * shortest is 0.2 m, and the energy grows by no more than the record of the projection explains, up
 * to the 1e-3 of explicit gyroscopic terms. */
static void test_ragdoll(void **state)
{
  static const int methods[] = {NSDAE_METHOD_MOREAU, NSDAE_METHOD_IMPLICIT};
  ragdoll *p = ragdoll_model.base;
  uint64_t seed = 11;
  (void)state;
  for (int i = 0; i < (test_share() > 1 ? 2 : 6); i++) { /* each method */
    nsdae_params_default(ragdoll_model.parameters, p);
    p->steps = random_below(&seed, 8);
    p->rise = random_between(&seed, 0.1, 0.3);
    p->push = random_between(&seed, -2, 2);
    p->friction = i % 3 ? random_between(&seed, 0, 20) : 0;
    p->mu = random_between(&seed, 0, 1);
    run(&ragdoll_model, methods[i % 2], i % 4 < 2 ? 2e-3 : 1e-3, test_share() > 1 ? 0.6 : 1);
    assert_at_most(p->drift, 1e-3 * 0.2);
    assert_at_most(p->growth, 1e-3 * p->start);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_gripper), cmocka_unit_test(test_geneva),
                                     cmocka_unit_test(test_backlash), cmocka_unit_test(test_cam),
                                     cmocka_unit_test(test_ragdoll)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
