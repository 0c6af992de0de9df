/* The event-driven method over the examples at several tolerances, for two libraries to be held
 * against each other: evaluations of the model's forces, time (the least of several runs), and
 * where it ends, which is the same program's at rtol 1e-13 but for the error. phases.py makes a
 * table of it. usage: bench_phases > FILE.csv */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "bouncing_ball.h"
#include "clearance_hinge.h"
#include "crank_slider.h"
#include "newtons_cradle.h"
#include "pendulum.h"
#include "rolling_ball.h"
#include "woodpecker.h"

enum { RUNS = 5, NQ = 16 };

static void run(const char *name, nsdae_system *system, const nsdae_sim_options *o,
                const double *q0, const double *v0, double t_end)
{
  nsdae_dims dims;
  nsdae_stats stats;
  nsdae_record record;
  double seconds = INFINITY;
  nsdae_system_get_dims(system, &dims);
  for (int i = 0; i < RUNS; i++) {
    nsdae_sim *sim;
    if (nsdae_sim_create(system, o, &sim, NULL) < 0) return;
    if (nsdae_sim_init(sim, 0, q0, v0) < 0 || nsdae_sim_run(sim, t_end) < 0) seconds = NAN;
    nsdae_sim_get_stats(sim, &stats);
    nsdae_sim_get_record(sim, &record);
    seconds = fmin(seconds, stats.wall_time);
    if (i == RUNS - 1) {
      printf("%s,%.0e,%ld,%.6g", name, o->rtol, stats.force_evals, seconds);
      for (int j = 0; j < dims.nq; j++) printf(",%.17g", record.q[j]);
      printf("\n");
    }
    nsdae_sim_destroy(&sim);
  }
}

int main(void)
{
  const driver_model *const models[] = {
      &bouncing_ball_model, &newtons_cradle_model,  &crank_slider_model, &pendulum_model,
      &rolling_ball_model,  &clearance_hinge_model, &woodpecker_model};
  const double rtols[] = {1e-4, 1e-6, 1e-8, 1e-10, 1e-13};
  for (size_t m = 0; m < sizeof models / sizeof *models; m++) {
    const driver_model *model = models[m];
    nsdae_system *system;
    nsdae_params_default(model->parameters, model->base);
    if (model->build(model->base, &system, NULL) < 0) return 1;
    for (size_t i = 0; i < sizeof rtols / sizeof *rtols; i++) {
      double q0[NQ] = {0}, v0[NQ] = {0};
      nsdae_sim_options o;
      nsdae_sim_options_default(&o);
      nsdae_sim_options_set(&o, "method", "event", NULL);
      o.dt = 0.005;
      o.rtol = rtols[i];
      o.atol = rtols[i] / 100;
      nsdae_sim_options_set(&o, "inner_steps_max", "10000000", NULL); /* not in all versions */
      model->start(model->base, q0, v0);
      run(model->name, system, &o, q0, v0, model == &newtons_cradle_model ? 2 : 3);
    }
    nsdae_system_destroy(&system);
  }
  return 0;
}
