#include "driver.h"

#include <ctype.h>
#include <stdio.h>

#include "compare.h"
#include "export.h"
#include "interrupt_signal.h"
#include "safe_read.h"
#include "report.h"
#include "settings.h"
#include "simulation.h"

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

/* One line: control characters of quoted words are replaced. */
static int complain(job *j, int exit_status)
{
  for (char *c = j->error.text; *c; c++)
    if (iscntrl((unsigned char)*c)) *c = '?';
  fflush(stdout);
  fprintf(stderr, "nsdae-%s: error: %s\n", j->model->name, j->error.text);
  return exit_status;
}

/* Usage error for wrong values, else a failed computation. */
static int exit_status_of(int status)
{
  return status == NSDAE_E_ARGUMENT || status == NSDAE_E_OPTION ? DRIVER_USAGE : DRIVER_FAILED;
}

/* With all its digits. */
static void write_time(double time, char text[NSDAE_PARAM_TEXT_SIZE])
{
  const settings at = {.t_end = time};
  nsdae_params_format(nsdae_params_find(&settings_run_table, "t_end"), &at, text,
                      NSDAE_PARAM_TEXT_SIZE);
}

static int no_way_back(job *j, const char *time)
{
  char t_end[NSDAE_PARAM_TEXT_SIZE];
  write_time(j->settings.t_end, t_end);
  nsdae_trajectory_close(&j->trajectory, NSDAE_OK, NULL);
  snprintf(j->error.text, sizeof j->error.text, "'%.90s' is at t = %.30s s, past t_end = %.30s s",
           j->settings.restart, time, t_end);
  return j->error.status = NSDAE_E_ARGUMENT;
}

/* Trial of a resume, up to changes of the file beyond its status. */
typedef struct attempt {
  job *job;
  const nsdae_trajectory_info *info;
} attempt;

static int try_resume(const char *path, void *user, nsdae_error *error)
{
  attempt *a = user;
  int status = nsdae_trajectory_resume(a->job->sim, path, a->info, &a->job->trajectory, error);
  return status < 0 ? status : nsdae_trajectory_flush(a->job->trajectory, error);
}

static int resume(job *j, const nsdae_trajectory_info *info)
{
  nsdae_record record;
  char time[NSDAE_PARAM_TEXT_SIZE];
  attempt first = {j, info};
  int status = probe(j->settings.restart, try_resume, &first, &j->error);
  if (status == NSDAE_OK)
    status = nsdae_trajectory_resume(j->sim, j->settings.restart, info, &j->trajectory, &j->error);
  if (status < 0) return status;
  nsdae_sim_get_record(j->sim, &record);
  write_time(record.time, time);
  if (j->settings.t_end < record.time) return no_way_back(j, time);
  if (!j->settings.quiet) printf("continues at t = %s s in %s\n", time, j->settings.restart);
  return NSDAE_OK;
}

static int open_trajectory(job *j)
{
  const nsdae_trajectory_info info = {.model = j->model->name,
                                      .parameters = j->model->parameters,
                                      .parameters_base = j->model->base,
                                      .live = j->settings.live,
                                      .every = j->settings.every,
                                      .compress = j->settings.compress,
                                      .t_end = j->settings.t_end,
                                      .contact_forces = j->settings.contact_forces};
  if (!j->settings.output[0]) return NSDAE_OK;
  if (j->settings.restart[0]) return resume(j, &info);
  int status =
      nsdae_trajectory_create(j->sim, j->settings.output, &info, &j->trajectory, &j->error);
  if (status == NSDAE_OK && j->model->bodies)
    status = j->model->bodies(j->model->base, j->trajectory, &j->error);
  /* without HDF5 the examples run, unless a file was requested */
  if (status != NSDAE_E_UNSUPPORTED || j->settings.output_named) return status;
  if (!j->settings.quiet) printf("no trajectory: %s\n", j->error.text);
  return NSDAE_OK;
}

static int run(job *j)
{
  dump kept;
  nsdae_sim_observe(j->sim, report_observe, &j->report);
  dump_begin(&kept, j->sim, &j->settings);
  interrupt_catch();
  report_begin(&j->report, &j->settings, j->sim);
  int status = simulation_run(j->sim, j->settings.t_end, &j->error);
  report_end(&j->report, j->sim, j->system);
  dump_end(&kept, status);
  return status;
}

/* The first failure is reported. */
static int close_trajectory(job *j, int status)
{
  nsdae_error error;
  if (!j->trajectory) return status;
  int closed = nsdae_trajectory_close(&j->trajectory, status, &error);
  if (closed < 0 && status >= 0) j->error = error;
  if (closed == NSDAE_OK && !j->settings.quiet) printf("trajectory in %s\n", j->settings.output);
  return status < 0 ? status : closed;
}

/* Standard output must be written: a full disk is an error. */
static int leave(const job *j, int exit_status)
{
  int flushed = fflush(stdout);
  if (exit_status != DRIVER_DONE || (flushed == 0 && !ferror(stdout))) return exit_status;
  fprintf(stderr, "nsdae-%s: error: cannot write to standard output: is its disk full?\n",
          j->model->name);
  return DRIVER_FAILED;
}

int driver_main(const driver_model *model, int argc, char **argv)
{
  job j = {.model = model};
  interrupt_not_by_size();
  settings_default(&j.settings, model);
  int status = settings_parse(&j.settings, argc, argv, &j.error);
  if (status < 0) return complain(&j, DRIVER_USAGE);
  if (j.settings.help) {
    settings_default(&j.settings, model);
    settings_usage(&j.settings);
    return leave(&j, DRIVER_DONE);
  }
  if (j.settings.version) {
    printf("nsdae-%s %s\n", model->name, nsdae_build_info());
    return leave(&j, DRIVER_DONE);
  }
  if (model->read)
    status =
        model->read(model->base, j.settings.dt_named ? NULL : &j.settings.options.dt, &j.error);
  if (status < 0) return complain(&j, DRIVER_USAGE);
  status = simulation_make(model, &j.settings.options, &j.system, &j.sim, &j.error);
  if (status == NSDAE_OK) status = open_trajectory(&j);
  if (status == NSDAE_OK) {
    status = run(&j);
    if (status == NSDAE_OK && j.settings.compare)
      status = compare_all(&j.settings, j.trajectory, &j.error);
    status = close_trajectory(&j, status);
  }
  int exit_status = status < 0 ? complain(&j, exit_status_of(status)) : DRIVER_DONE;
  simulation_release(&j.system, &j.sim);
  return leave(&j, exit_status);
}
