/* The event-driven method over the examples, by each integrator at several tolerances: evaluations
 * of the model's forces, time (the least of several runs), and the state at the end. phases.py
 * makes a table and a picture of it; the error is that against dopri5 at rtol 1e-13. usage:
 * bench_phases > FILE.csv */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bouncing_ball.h"
#include "clearance_hinge.h"
#include "crank_slider.h"
#include "newtons_cradle.h"
#include "pendulum.h"
#include "rolling_ball.h"
#include "woodpecker.h"
#include "ratio.h"

enum { RUNS = 5, NQ = 16 };

static void run(const char *name, const char *integrator, nsdae_system *system,
                const nsdae_sim_options *o, const double *q0, const double *v0, double t_end)
{
  nsdae_dims dims;
  nsdae_stats stats;
  nsdae_record record;
  double seconds = INFINITY;
  nsdae_system_get_dims(system, &dims);
  for (int i = 0; i < RUNS; i++) {
    nsdae_sim *sim;
    if (nsdae_sim_create(system, o, &sim, NULL) < 0) return;
    double start = ratio_cpu();
    if (nsdae_sim_init(sim, 0, q0, v0) < 0 || nsdae_sim_run(sim, t_end) < 0)
      fprintf(stderr, "%s %s %.0e: %s\n", name, integrator, o->rtol, nsdae_sim_error(sim)->text);
    seconds = fmin(seconds, ratio_cpu() - start);
    nsdae_sim_get_stats(sim, &stats);
    nsdae_sim_get_record(sim, &record);
    if (i == RUNS - 1) {
      printf("%s,%s,%.0e,%ld,%.6g", name, integrator, o->rtol, stats.force_evals, seconds);
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
  static const char *const integrators[] = {"dopri5", "dop853", "auto", "ida"};
  const double rtols[] = {1e-4, 1e-6, 1e-8, 1e-10, 1e-13};
  for (size_t m = 0; m < sizeof models / sizeof *models; m++) {
    const driver_model *model = models[m];
    nsdae_system *system;
    nsdae_params_default(model->parameters, model->base);
    if (model->build(model->base, &system, NULL) < 0) return 1;
    for (size_t j = 0; j < sizeof integrators / sizeof *integrators; j++)
      for (size_t i = 0; i < sizeof rtols / sizeof *rtols; i++) {
        double q0[NQ] = {0}, v0[NQ] = {0};
        nsdae_sim_options o;
        if (rtols[i] < 1e-12 && strcmp(integrators[j], "dopri5") != 0) continue;
        nsdae_sim_options_default(&o);
        nsdae_sim_options_set(&o, "method", "event", NULL);
        nsdae_sim_options_set(&o, "integrator", integrators[j], NULL);
        o.dt = 0.005;
        o.rtol = rtols[i];
        o.atol = rtols[i] / 100;
        o.inner_steps_max = 10000000;
        model->start(model->base, q0, v0);
        run(model->name, integrators[j], system, &o, q0, v0,
            model == &newtons_cradle_model ? 2 : 3);
      }
    nsdae_system_destroy(&system);
  }
  return 0;
}
