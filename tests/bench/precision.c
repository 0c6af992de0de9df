/* Work against precision on the pendulum with a stop: error of the first impulse and of the angle
 * one second after the start, once past the impact, against the time that it took. Times are the
 * least of several runs, ratios are to the event-driven method at rtol 1e-8 in the same run.
 * usage: bench_precision [FILE.csv] */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include <gsl/gsl_sf_elljac.h>

#include "pendulum.h"
#include "ratio.h"

enum { RUNS = 5 };

typedef struct sample {
  int method;
  double dt, rtol;
  double seconds, impulse, angle; /* least time; relative error; error [rad] */
} sample;

typedef struct first_impact {
  int known;
  double impulse;
} first_impact;

static int observe(const nsdae_record *r, nsdae_error *error, void *user)
{
  first_impact *first = user;
  (void)error;
  if (r->impacts > 0 && !first->known) *first = (first_impact){1, r->impact[0].normal_impulse};
  return 0;
}

static const double t_end = 1;

/* After the first impact, at t1 with the speed w: sin(theta / 2) = k sn(sqrt(c) (t - t1)),
 * k = w / (2 sqrt(c)), c = 3 g / 2 L. */
static double exact_angle(const pendulum *p)
{
  driver_exact first;
  double c = 1.5 * p->g / p->L, sn, cn, dn;
  double w = p->e_N * sqrt(2 * c * (1 - cos(p->theta_0)));
  pendulum_model.exact(p, 0, &first);
  double k = w / (2 * sqrt(c));
  gsl_sf_elljac_e(sqrt(c) * (t_end - first.time), k * k, &sn, &cn, &dn);
  return 2 * asin(k * sn);
}

static void run_once(const pendulum *p, nsdae_system *system, sample *s)
{
  nsdae_sim_options options;
  nsdae_sim *sim;
  nsdae_record record;
  driver_exact exact;
  first_impact first = {0};
  double q0[3] = {0}, v0[3] = {0};
  nsdae_sim_options_default(&options);
  options.method = s->method;
  options.dt = s->dt;
  options.rtol = s->rtol;
  options.atol = s->rtol / 100;
  pendulum_model.start(p, q0, v0);
  if (nsdae_sim_create(system, &options, &sim, NULL) < 0) return;
  nsdae_sim_observe(sim, observe, &first);
  nsdae_sim_init(sim, 0, q0, v0);
  double start = ratio_cpu();
  if (nsdae_sim_run(sim, t_end) == NSDAE_OK) {
    s->seconds = fmin(s->seconds, ratio_cpu() - start);
    nsdae_sim_get_record(sim, &record);
    pendulum_model.exact(p, 0, &exact);
    s->impulse = fabs(first.impulse / exact.normal_impulse - 1);
    s->angle = fabs(record.q[2] - exact_angle(p));
  }
  nsdae_sim_destroy(&sim);
}

static int make_samples(sample *all)
{
  int count = 0;
  for (double rtol = 1e-4; rtol > 5e-13; rtol /= 10)
    all[count++] = (sample){.method = NSDAE_METHOD_EVENT, .dt = 0.05, .rtol = rtol};
  for (int method = NSDAE_METHOD_IMPLICIT; method <= NSDAE_METHOD_MOREAU;
       method += NSDAE_METHOD_MOREAU)
    for (double dt = 0.02; dt > 5e-6; dt /= 4)
      all[count++] = (sample){.method = method, .dt = dt, .rtol = 1e-8};
  return count;
}

static void print(const sample *all, int count, FILE *csv)
{
  double unit = INFINITY;
  for (int i = 0; i < count; i++)
    if (all[i].method == NSDAE_METHOD_EVENT && fabs(log10(all[i].rtol) + 8) < 0.5)
      unit = all[i].seconds;
  printf("%-10s %10s %10s %10s %8s %12s %12s\n", "method", "dt [s]", "rtol", "time [ms]", "ratio",
         "impulse", "angle [rad]");
  if (csv) fprintf(csv, "method,dt_s,rtol,time_s,ratio,impulse_error,angle_error_rad\n");
  for (int i = 0; i < count; i++) {
    const sample *s = &all[i];
    const char *name = nsdae_method_name(s->method);
    printf("%-10s %10.3g %10.0e %10.3f %8.2f %12.1e %12.1e\n", name, s->dt, s->rtol,
           1e3 * s->seconds, s->seconds / unit, s->impulse, s->angle);
    if (csv)
      fprintf(csv, "%s,%.6g,%.0e,%.4g,%.4g,%.3e,%.3e\n", name, s->dt, s->rtol, s->seconds,
              s->seconds / unit, s->impulse, s->angle);
  }
}

int main(int argc, char **argv)
{
  sample all[64];
  nsdae_system *system;
  pendulum *p = pendulum_model.base;
  nsdae_params_default(pendulum_model.parameters, p);
  if (pendulum_model.build(p, &system, NULL) < 0) return 1;
  int count = make_samples(all);
  for (int i = 0; i < count; i++) all[i].seconds = INFINITY;
  for (int run = 0; run < RUNS; run++)
    for (int i = 0; i < count; i++) run_once(p, system, &all[i]);
  nsdae_system_destroy(&system);
  FILE *csv = argc > 1 ? fopen(argv[1], "w") : NULL;
  if (argc > 1 && !csv) {
    fprintf(stderr, "cannot write '%s'\n", argv[1]);
    return 1;
  }
  print(all, count, csv);
  return csv && fclose(csv) != 0;
}
