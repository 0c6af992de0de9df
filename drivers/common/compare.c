#include "compare.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "progress.h"
#include "interrupt_signal.h"
#include "simulation.h"

/* Progress over all methods. */
typedef struct progress {
  bar bar;
  int methods, done;
} progress;

/* Follows a run: its impacts, and its state at the times of the reference. */
typedef struct follower {
  const driver_model *model;
  comparison_run *run;
  int state;                 /* number of the next reference state */
  double last_time, last[8]; /* of the record before: the first coordinates */
  double t_end;
  progress *progress; /* or NULL */
} follower;

/* Coordinate of a reference state, between the last record and this one. */
static double value_at(const follower *f, const nsdae_record *r, const driver_state *state)
{
  double now = r->q[state->coordinate], then = f->last[state->coordinate];
  if (r->time == f->last_time) return now;
  double part = (state->time - f->last_time) / (r->time - f->last_time);
  return then + part * (now - then);
}

static int follow(const nsdae_record *r, nsdae_error *error, void *user)
{
  follower *f = user;
  comparison_run *run = f->run;
  driver_state state;
  (void)error;
  for (int i = 0; i < r->impacts && run->impacts < COMPARE_IMPACTS; i++)
    run->impact[run->impacts++] = r->impact[i];
  while (f->model->state && f->model->state(f->model->base, f->state, &state) &&
         state.time <= r->time + 1e-9) {
    double off = fabs(value_at(f, r, &state) - state.value);
    run->state_error = f->state == 0 ? off : fmax(run->state_error, off);
    f->state++;
  }
  f->last_time = r->time;
  memcpy(f->last, r->q, (size_t)f->model->coordinates * sizeof *r->q);
  if (f->progress)
    bar_move(&f->progress->bar, (f->progress->done + r->time / f->t_end) / f->progress->methods,
             r->time);
  return 0;
}

static void judge_impacts(const driver_model *model, comparison_run *run)
{
  driver_exact exact;
  run->first_impulse = run->impacts > 0 ? run->impact[0].normal_impulse : NAN;
  run->first_error = run->impulse_error = run->time_error = NAN;
  for (int i = 0; i < run->impacts && model->exact && model->exact(model->base, i, &exact); i++) {
    double impulse = fabs(run->impact[i].normal_impulse / exact.normal_impulse - 1);
    double time = fabs(run->impact[i].time - exact.time);
    if (i == 0) run->first_error = impulse;
    run->impulse_error = i == 0 ? impulse : fmax(run->impulse_error, impulse);
    run->time_error = i == 0 ? time : fmax(run->time_error, time);
  }
}

/* With many bodies the methods that follow every impact take hours: only by name. */
static int is_left_out(const nsdae_system *system, int method)
{
  nsdae_dims dims;
  nsdae_system_get_dims(system, &dims);
  return (method == NSDAE_METHOD_EVENT || method == NSDAE_METHOD_PENALTY) && dims.k == 0 &&
         nsdae_system_get_blocks(system) > 1;
}

static int integrate(const settings *s, const nsdae_sim_options *options, follower *f,
                     nsdae_error *error)
{
  nsdae_system *system;
  nsdae_sim *sim;
  int status = simulation_make(s->model, options, &system, &sim, error);
  if (status == NSDAE_OK && is_left_out(system, options->method)) {
    status = NSDAE_E_UNSUPPORTED;
    snprintf(error->text, sizeof error->text, "not compared with many bodies: use --method %s",
             nsdae_method_name(options->method));
  }
  if (status == NSDAE_OK) {
    nsdae_sim_observe(sim, follow, f);
    status = simulation_run(sim, s->t_end, error);
    nsdae_sim_get_stats(sim, &f->run->stats);
  }
  simulation_release(&system, &sim);
  return status;
}

static void run_method(const settings *s, int method, comparison_run *run, progress *shown)
{
  nsdae_sim_options options = s->options;
  nsdae_error error = {0};
  *run = (comparison_run){.state_error = NAN};
  follower f = {.model = s->model, .run = run, .progress = shown, .t_end = s->t_end};
  settings_choose_method(s, method, &options);
  run->status = integrate(s, &options, &f, &error);
  snprintf(run->text, sizeof run->text, "%s", error.text);
  judge_impacts(s->model, run);
}

void compare_one(const settings *s, int method, comparison_run *run)
{
  run_method(s, method, run, NULL);
}

/* A number; a dash for NaN. */
static void print_number(double value, const char *format, int width)
{
  char text[32] = "-";
  if (!isnan(value)) snprintf(text, sizeof text, format, value);
  printf(" %*s", width, text);
}

static void print_run(const char *name, const comparison_run *run)
{
  const nsdae_stats *st = &run->stats;
  printf("%-17s", name);
  if (run->status < 0) {
    printf(" failed: %s\n", run->text);
    return;
  }
  printf(" %8ld %8ld", st->steps, st->impacts);
  print_number(run->first_impulse, "%.6f", 11);
  print_number(100 * run->first_error, "%.4f", 10);
  print_number(100 * run->impulse_error, "%.4f", 10);
  print_number(run->time_error, "%.2e", 10);
  print_number(run->state_error, "%.2e", 10);
  print_number(st->worst_drift, "%.2e", 10);
  print_number(st->energy_balance, "%+.2e", 10);
  print_number(st->worst_residual, "%.1e", 10);
  print_number(1e3 * st->wall_time, "%.3f", 10);
  printf("\n");
}

static void print_table(const settings *s, const comparison_run *runs, int methods)
{
  printf("\nall methods, dt %g s, to %g s\n%-17s %8s %8s %11s %10s %10s %10s %10s %10s %10s %10s "
         "%10s\n",
         s->options.dt, s->t_end, "method", "steps", "impacts", "1st impulse", "1st %", "worst %",
         "times [s]", "states", "drift", "balance J", "LCP", "time [ms]");
  for (int i = 0; i < methods; i++) print_run(nsdae_method_name(i), &runs[i]);
  printf(
      "1st %%, worst %%, times, states: errors against the reference, impact by impact in order\n"
      "(a method that merges two impacts in a step has wrong errors from there on); time: of "
      "this run, not repeatable\n");
}

/* One column of the table as a dataset of the file. */
static int put(nsdae_trajectory *t, const char *name, const comparison_run *runs, int methods,
               size_t offset, const char *units, const char *description, nsdae_error *error)
{
  double column[COMPARE_METHODS];
  char path[64];
  snprintf(path, sizeof path, "/compare/%s", name);
  for (int i = 0; i < methods; i++)
    column[i] =
        runs[i].status < 0 ? NAN : *(const double *)(const void *)((const char *)&runs[i] + offset);
  return nsdae_trajectory_put(t, path, methods, column, units, description, error);
}

static int put_table(nsdae_trajectory *t, const comparison_run *runs, int methods,
                     nsdae_error *error)
{
  static const struct {
    const char *name, *units, *description;
    size_t offset;
  } columns[] = {
      {"first_impulse", "N s", "normal impulse of the first impact",
       offsetof(comparison_run, first_impulse)},
      {"first_error", "1", "relative error of the first impulse",
       offsetof(comparison_run, first_error)},
      {"impulse_error", "1", "worst relative error of the impulses with a reference",
       offsetof(comparison_run, impulse_error)},
      {"time_error", "s", "worst error of the times of impact",
       offsetof(comparison_run, time_error)},
      {"state_error", "of the model", "worst error of the reference's states",
       offsetof(comparison_run, state_error)},
      {"constraint_drift", "of the model", "max |Phi|",
       offsetof(comparison_run, stats.worst_drift)},
      {"energy_balance", "J", "energy + dissipated - start",
       offsetof(comparison_run, stats.energy_balance)},
      {"lcp_residual", "1", "worst scaled natural residual",
       offsetof(comparison_run, stats.worst_residual)},
      {"wall_time", "s", "time of this run", offsetof(comparison_run, stats.wall_time)},
  };
  const char *names[COMPARE_METHODS];
  for (int i = 0; i < methods; i++) names[i] = nsdae_method_name(i);
  int status = nsdae_trajectory_put_texts(t, "/compare/method", methods, names, "methods", error);
  for (size_t i = 0; i < sizeof columns / sizeof *columns && status == NSDAE_OK; i++)
    status = put(t, columns[i].name, runs, methods, columns[i].offset, columns[i].units,
                 columns[i].description, error);
  return status;
}

/* Stops at the run that was interrupted. */
static int run_all(const settings *s, comparison_run *runs, int methods, nsdae_error *error)
{
  progress shown = {.methods = methods};
  bar_begin(&shown.bar, s->quiet);
  for (int i = 0; i < methods && !interrupt_came(); i++) {
    shown.done = i;
    run_method(s, i, &runs[i], &shown);
  }
  bar_clear(&shown.bar);
  return compare_status(error);
}

int compare_status(nsdae_error *error)
{
  if (!interrupt_came()) return NSDAE_OK;
  snprintf(error->text, sizeof error->text, "interrupted while comparing the methods");
  return error->status = NSDAE_E_STATE;
}

int compare_all(const settings *s, nsdae_trajectory *trajectory, nsdae_error *error)
{
  static comparison_run runs[COMPARE_METHODS];
  int methods = 0;
  while (methods < COMPARE_METHODS && nsdae_method_name(methods)) methods++;
  int status = run_all(s, runs, methods, error);
  if (status == NSDAE_OK && !s->quiet) print_table(s, runs, methods);
  if (status == NSDAE_OK && trajectory) status = put_table(trajectory, runs, methods, error);
  if (status == NSDAE_OK && s->model->compare_more)
    status = s->model->compare_more(s, trajectory, error);
  return status;
}
