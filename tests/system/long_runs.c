/* Long runs of every example by every time-stepping method end well: 20 000 steps here, so many as
 * NSDAE_LONG says elsewhere (1e8 take minutes each; NSDAE_ONLY names one example). Motions decay to
 * rest and far below, or never end; whatever they do, each step has a status that is none of a
 * failure, its contact problem is solved, and the state is finite. */
#include "check.h"

#include <stdlib.h>

#include "arch.h"
#include "bouncing_ball.h"
#include "clearance_hinge.h"
#include "column.h"
#include "crank_slider.h"
#include "dominoes.h"
#include "falling_rod.h"
#include "heap.h"
#include "incline.h"
#include "newtons_cradle.h"
#include "pendulum.h"
#include "rolling_ball.h"
#include "shaken_ball.h"
#include "wall.h"
#include "woodpecker.h"

enum { NQ = 20000 };

/* large: one of hundreds of contacts, of which a step takes milliseconds */
static const struct {
  const driver_model *model;
  int large;
} all[] = {{&bouncing_ball_model, 0}, {&clearance_hinge_model, 0},
           {&crank_slider_model, 0},  {&falling_rod_model, 0},
           {&incline_model, 0},       {&newtons_cradle_model, 0},
           {&pendulum_model, 0},      {&rolling_ball_model, 0},
           {&shaken_ball_model, 0},   {&woodpecker_model, 0},
           {&arch_model, 1},          {&column_model, 1},
           {&dominoes_model, 1},      {&heap_model, 1},
           {&wall_model, 1}};

static const int method[] = {NSDAE_METHOD_IMPLICIT, NSDAE_METHOD_IMPLICIT_PRINTED,
                             NSDAE_METHOD_MOREAU};

static long steps_of(int large)
{
  const char *many = getenv("NSDAE_LONG");
  double steps = many ? strtod(many, NULL) : 20000;
  if (steps < 20000) steps = 20000;
  return (long)(large ? steps / 1000 : steps);
}

static void expect_well(const nsdae_sim *sim, long steps, double tol)
{
  nsdae_record r;
  nsdae_dims d;
  nsdae_stats stats;
  assert_int_equal(nsdae_sim_get_record(sim, &r), NSDAE_OK);
  assert_int_equal(nsdae_sim_get_dims(sim, &d), NSDAE_OK);
  assert_int_equal(nsdae_sim_get_stats(sim, &stats), NSDAE_OK);
  assert_int_equal(r.step, steps);
  for (int i = 0; i < d.nq; i++) assert_true(isfinite(r.q[i]));
  for (int i = 0; i < d.nv; i++) assert_true(isfinite(r.v[i]));
  assert_true(isfinite(r.kinetic) && isfinite(r.potential) && isfinite(r.dissipated));
  assert_at_most(stats.worst_residual, tol);
  assert_at_most(r.constraint_drift, 0.02); /* pendulum by moreau: h^2 of its first swings */
}

static void run(const driver_model *model, int method_number, double dt, long steps)
{
  static double q0[NQ], v0[NQ];
  nsdae_sim_options options;
  nsdae_system *system;
  nsdae_sim *sim;
  nsdae_sim_options_default(&options);
  options.method = method_number;
  if (dt > 0) options.dt = dt;
  if (model->lcp_tol > 0) options.lcp_tol = model->lcp_tol;
  assert_int_equal(model->build(model->base, &system, NULL), NSDAE_OK);
  memset(q0, 0, sizeof q0);
  memset(v0, 0, sizeof v0);
  model->start(model->base, q0, v0);
  assert_int_equal(nsdae_sim_create(system, &options, &sim, NULL), NSDAE_OK);
  int status = nsdae_sim_init(sim, 0, q0, v0);
  for (long i = 0; i < steps && status >= 0; i++) status = nsdae_sim_step(sim);
  if (status < 0)
    fail_msg("%s by %s: %s", model->name, nsdae_method_name(method_number),
             nsdae_sim_error(sim)->text);
  expect_well(sim, steps, options.lcp_tol);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
}

static void test_examples(void **state)
{
  (void)state;
  const char *only = getenv("NSDAE_ONLY");
  for (size_t i = 0; i < sizeof all / sizeof *all; i++)
    for (size_t k = 0; k < sizeof method / sizeof *method; k++) {
      const driver_model *model = all[i].model;
      if (only && strcmp(only, model->name) != 0) continue;
      nsdae_params_default(model->parameters, model->base);
      run(model, method[k], model->dt, steps_of(all[i].large));
    }
}

/* An explicit step makes the quaternion of a ball that spins longer, by 1 + (h w / 4)^2: at 50 000
 * a second with h = 5 ms it would be beyond all numbers in 80 steps. */
static void test_quaternions(void **state)
{
  (void)state;
  for (size_t k = 0; k < sizeof method / sizeof *method; k++) {
    nsdae_params_default(rolling_ball_model.parameters, rolling_ball_model.base);
    rolling_ball *p = rolling_ball_model.base;
    p->mu = 0, p->vx = 1, p->wx = p->wy = 50000;
    if (method[k] == NSDAE_METHOD_MOREAU) run(&rolling_ball_model, method[k], 5e-3, 20000);
    p->wx = p->wy = 100; /* what the iterated steps converge for */
    run(&rolling_ball_model, method[k], 5e-3, 20000);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_examples),
                                     cmocka_unit_test(test_quaternions)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
