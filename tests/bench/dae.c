/* Work and precision of the integrators on the mechanisms of the Test Set for IVP Solvers:
 * evaluations of the forces, least CPU time of several runs, correct digits of q and of v at the
 * published end. dae.py draws the picture. usage: bench_dae [FILE.csv] */
#include <math.h>
#include <stdio.h>

#include "car_axis.h"
#include "flexible_crank.h"
#include "squeezer.h"
#include "ratio.h"

enum { RUNS = 3 };

/* Returns the status; *time is the least of the runs [ms]. */
static int run(const driver_model *model, const nsdae_sim_options *o, double *time,
               nsdae_stats *stats, double *q, double *v, nsdae_error *error)
{
  nsdae_system *system;
  nsdae_record record;
  nsdae_dims dims;
  *time = INFINITY;
  nsdae_params_default(model->parameters, model->base);
  int status = model->build(model->base, &system, error);
  nsdae_system_get_dims(system, &dims);
  for (int i = 0; i < RUNS && status == NSDAE_OK; i++) {
    nsdae_sim *sim = NULL;
    double q0[PUBLISHED_MAX] = {0}, v0[PUBLISHED_MAX] = {0};
    model->start(model->base, q0, v0);
    status = nsdae_sim_create(system, o, &sim, error);
    if (status == NSDAE_OK) status = nsdae_sim_init(sim, 0, q0, v0);
    double start = 1e3 * ratio_cpu();
    if (status == NSDAE_OK) status = nsdae_sim_run(sim, model->t_end);
    *time = fmin(*time, 1e3 * ratio_cpu() - start);
    if (status < 0 && sim) *error = *nsdae_sim_error(sim);
    if (status == NSDAE_OK) status = nsdae_sim_get_stats(sim, stats);
    if (status == NSDAE_OK) status = nsdae_sim_get_record(sim, &record);
    for (int j = 0; j < dims.nq && status == NSDAE_OK; j++) q[j] = record.q[j], v[j] = record.v[j];
    nsdae_sim_destroy(&sim);
  }
  nsdae_system_destroy(&system);
  return status;
}

int main(int argc, char **argv)
{
  static const struct {
    const driver_model *model;
    const published *published;
  } problems[] = {{&squeezer_model, &squeezer_published},
                  {&car_axis_model, &car_axis_published},
                  {&flexible_crank_model, &flexible_crank_published}};
  static const char *const integrators[] = {"dopri5", "dop853", "ida"};
  FILE *file = argc > 1 ? fopen(argv[1], "w") : NULL;
  if (argc > 1 && !file) return perror(argv[1]), 1;
  if (file) fprintf(file, "problem,integrator,rtol,forces,ms,digits_q,digits_v\n");
  printf("%-16s %-8s %7s %8s %9s %6s %6s\n", "problem", "integr.", "rtol", "forces", "time [ms]",
         "q", "v");
  for (size_t p = 0; p < sizeof problems / sizeof *problems; p++)
    for (size_t i = 0; i < sizeof integrators / sizeof *integrators; i++)
      for (int digits = 4; digits <= 12; digits += 2) {
        nsdae_sim_options o;
        nsdae_stats stats;
        nsdae_error error;
        const driver_model *model = problems[p].model;
        double time, q[PUBLISHED_MAX], v[PUBLISHED_MAX], rtol = pow(10, -digits);
        nsdae_sim_options_default(&o);
        nsdae_sim_options_set(&o, "method", "event", NULL);
        if (nsdae_sim_options_set(&o, "integrator", integrators[i], &error) < 0) continue;
        o.dt = model->t_end / 10;
        o.rtol = rtol;
        o.atol = 1e-5 * rtol;
        o.inner_steps_max = 1000000;
        int status = run(model, &o, &time, &stats, q, v, &error);
        if (status < 0) {
          printf("%-16s %-8s %7.0e %s\n", model->name, integrators[i], rtol, error.text);
          continue;
        }
        double of_q = published_digits(problems[p].published, "q", q);
        double of_v = published_digits(problems[p].published, "v", v);
        printf("%-16s %-8s %7.0e %8ld %9.2f %6.1f %6.1f\n", model->name, integrators[i], rtol,
               stats.force_evals, time, of_q, of_v);
        if (file)
          fprintf(file, "%s,%s,%.0e,%ld,%.4g,%.2f,%.2f\n", model->name, integrators[i], rtol,
                  stats.force_evals, time, of_q, of_v);
      }
  if (file && fclose(file) != 0) return perror(argv[1]), 1;
  return 0;
}
