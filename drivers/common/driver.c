#include "driver.h"

#include <signal.h>
#include <stdio.h>
#include <stdlib.h>

#include "compare.h"
#include "report.h"
#include "settings.h"

/* Ctrl-C ends the run after the step, with the file closed. */
static volatile sig_atomic_t interrupted;

static void interrupt(int signal_number)
{
  (void)signal_number;
  interrupted = 1;
}

static int stop_when_interrupted(const nsdae_record *record, nsdae_error *error, void *user)
{
  (void)record;
  (void)error;
  (void)user;
  return interrupted;
}

/* Everything that a run holds. */
typedef struct job {
  const driver_model *model;
  settings settings;
  nsdae_system *system;
  nsdae_sim *sim;
  nsdae_trajectory *trajectory;
  report report;
  nsdae_error error;
} job;

static int complain(const job *j, int exit_status)
{
  fflush(stdout);
  fprintf(stderr, "nsdae-%s: error: %s\n", j->model->name, j->error.text);
  return exit_status;
}

/* A wrong value is the user's; what else fails is the computation's. */
static int exit_status_of(int status)
{
  return status == NSDAE_E_ARGUMENT || status == NSDAE_E_OPTION ? DRIVER_USAGE : DRIVER_FAILED;
}

static int init(job *j)
{
  nsdae_dims dims;
  nsdae_sim_get_dims(j->sim, &dims);
  double *q0 = calloc((size_t)dims.nq + (size_t)dims.nv, sizeof *q0), *v0 = q0 + dims.nq;
  if (!q0) {
    snprintf(j->error.text, sizeof j->error.text, "out of memory");
    return NSDAE_E_MEMORY;
  }
  j->model->start(j->model->base, q0, v0);
  int status = nsdae_sim_init(j->sim, 0, q0, v0);
  if (status < 0) j->error = *nsdae_sim_error(j->sim);
  free(q0);
  return status;
}

static int prepare(job *j)
{
  int status = j->model->build(j->model->base, &j->system, &j->error);
  if (status == NSDAE_OK)
    status = nsdae_sim_create(j->system, &j->settings.options, &j->sim, &j->error);
  return status < 0 ? status : init(j);
}

static int open_trajectory(job *j)
{
  const nsdae_trajectory_info info = {.model = j->model->name,
                                      .parameters = j->model->parameters,
                                      .parameters_base = j->model->base,
                                      .live = j->settings.live};
  if (!j->settings.output[0]) return NSDAE_OK;
  int status =
      nsdae_trajectory_create(j->sim, j->settings.output, &info, &j->trajectory, &j->error);
  /* a library without HDF5 still runs the examples, unless a file was asked for */
  if (status != NSDAE_E_UNSUPPORTED || j->settings.output_named) return status;
  if (!j->settings.quiet) printf("no trajectory: %s\n", j->error.text);
  return NSDAE_OK;
}

/* The problem of a step that failed on it, into the file that was asked for. */
static void dump_lcp(job *j)
{
  nsdae_lcp_problem problem;
  nsdae_record record;
  nsdae_error error;
  if (!j->settings.lcp_dump[0] || nsdae_sim_get_failed_lcp(j->sim, &problem) != NSDAE_OK) return;
  nsdae_sim_get_record(j->sim, &record);
  const nsdae_lcp_origin origin = {.time = record.time,
                                   .step = record.step + 1,
                                   .tol = j->settings.options.lcp_tol,
                                   .method = nsdae_method_name(j->settings.options.method)};
  if (nsdae_lcp_write(j->settings.lcp_dump, &problem, &origin, &error) != NSDAE_OK) {
    fflush(stdout);
    fprintf(stderr, "nsdae-%s: warning: lcp_dump: %s\n", j->model->name, error.text);
  } else if (!j->settings.quiet)
    printf("problem of the failed step in %s: nsdae-lcp solves it alone\n", j->settings.lcp_dump);
}

static int run(job *j)
{
  nsdae_sim_observe(j->sim, report_observe, &j->report);
  nsdae_sim_observe(j->sim, stop_when_interrupted, NULL);
  signal(SIGINT, interrupt);
  signal(SIGTERM, interrupt);
  report_begin(&j->report, &j->settings, j->sim);
  int status = nsdae_sim_run(j->sim, j->settings.t_end);
  report_end(&j->report, j->sim);
  if (status < 0) j->error = *nsdae_sim_error(j->sim);
  if (status < 0) dump_lcp(j);
  if (status == NSDAE_STOPPED) {
    nsdae_record record;
    nsdae_sim_get_record(j->sim, &record);
    snprintf(j->error.text, sizeof j->error.text, "interrupted at t = %g s", record.time);
    status = NSDAE_E_STATE;
  }
  return status;
}

/* The first failure is the one that is told. */
static int close_trajectory(job *j, int status)
{
  nsdae_error error;
  if (!j->trajectory) return status;
  int closed = nsdae_trajectory_close(&j->trajectory, status, &error);
  if (closed < 0 && status >= 0) j->error = error;
  if (closed == NSDAE_OK && !j->settings.quiet) printf("trajectory in %s\n", j->settings.output);
  return status < 0 ? status : closed;
}

static void release(job *j)
{
  nsdae_sim_destroy(&j->sim);
  nsdae_system_destroy(&j->system);
}

int driver_main(const driver_model *model, int argc, char **argv)
{
  job j = {.model = model};
  settings_default(&j.settings, model);
  int status = settings_parse(&j.settings, argc, argv, &j.error);
  if (status < 0) return complain(&j, DRIVER_USAGE);
  if (j.settings.help) {
    settings_default(&j.settings, model);
    settings_usage(&j.settings);
    return DRIVER_DONE;
  }
  if (j.settings.version) {
    printf("nsdae-%s %s\n", model->name, nsdae_build_info());
    return DRIVER_DONE;
  }
  status = prepare(&j);
  if (status == NSDAE_OK) status = open_trajectory(&j);
  if (status == NSDAE_OK) {
    status = run(&j);
    if (status == NSDAE_OK && j.settings.compare)
      status = compare_all(&j.settings, j.trajectory, &j.error);
    status = close_trajectory(&j, status);
  }
  int exit_status = status < 0 ? complain(&j, exit_status_of(status)) : DRIVER_DONE;
  release(&j);
  return exit_status;
}
