/* nsdae-sweep: parameter sweeps of a model. See docs/sweep.md. */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "command.h"
#include "interrupt_signal.h"
#include "executor.h"

enum { DONE = 0, FAILED = 1, USAGE = 2 };

/* Everything that rank 0 holds. */
typedef struct sweep {
  job job;
  sweep_table *table;
  long *todo, left, done;
  table_failure *failure;
  long failures, room;
  bar bar;
  nsdae_error error;
} sweep;

static int complain(const nsdae_error *error, int status)
{
  if (ranks_rank() != 0) return status;
  fflush(stdout);
  fprintf(stderr, "nsdae-sweep: error: %s\n", error->text);
  return status;
}

static int no_memory(nsdae_error *error)
{
  snprintf(error->text, sizeof error->text, "out of memory");
  return error->status = NSDAE_E_MEMORY;
}

/* -------- starting the processes -------- */

/* Open MPI refuses root, and counts cores its own way; each of these is unknown to the others. */
static void prepare_mpirun(void)
{
  setenv("OMPI_ALLOW_RUN_AS_ROOT", "1", 0);
  setenv("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1", 0);
  setenv("OMPI_MCA_rmaps_base_oversubscribe", "1", 0);
  setenv("OMPI_MCA_hwloc_base_binding_policy", "none", 0);
  if (isatty(STDERR_FILENO)) setenv("NSDAE_SWEEP_TERMINAL", "1", 1);
}

/* argv of mpirun; NULL: no memory. The texts are the caller's. */
static char **mpirun_words(int argc, char **argv, char *count, char *self)
{
  char **words = calloc((size_t)argc + 5, sizeof *words);
  if (!words) return NULL;
  words[0] = "mpirun";
  words[1] = "-n";
  words[2] = count;
  words[3] = self;
  for (int i = 1; i < argc; i++) words[3 + i] = argv[i];
  return words;
}

/* Number of processes worth starting. */
static long processes_of(const sweep *s)
{
  long wanted = s->job.processes ? s->job.processes : sysconf(_SC_NPROCESSORS_ONLN);
  return wanted < s->left ? wanted : s->left;
}

/* Replaces this process by mpirun with one process per core. Returns if that is one, or if mpirun
 * is missing; the latter is an error if --processes was given. */
static int become_mpirun(sweep *s, int argc, char **argv)
{
  char count[24], self[4096] = "";
  long processes = processes_of(s);
  if (processes <= 1 || ranks_launched()) return NSDAE_OK;
  snprintf(count, sizeof count, "%ld", processes);
  if (ranks_available() && readlink("/proc/self/exe", self, sizeof self - 1) > 0) {
    char **words = mpirun_words(argc, argv, count, self);
    if (!words) return no_memory(&s->error);
    prepare_mpirun();
    fflush(NULL);
    execvp(words[0], words); /* the file is closed by it */
    free(words);
  }
  if (s->job.processes == 0) return NSDAE_OK; /* one will do */
  snprintf(s->error.text, sizeof s->error.text, "--processes %d needs %s", s->job.processes,
           ranks_available() ? "mpirun, which was not found" : "a build with MPI");
  return s->error.status = NSDAE_E_UNSUPPORTED;
}

/* -------- the work -------- */

static int work(void *user, long run, double *row, char reason[TABLE_REASON_SIZE])
{
  sweep *s = user;
  return job_run(&s->job, run, row, reason);
}

static int note_failure(sweep *s, long run, const char *reason)
{
  if (s->failures == s->room) {
    long room = 2 * s->room + 64;
    table_failure *more = realloc(s->failure, (size_t)room * sizeof *more);
    if (!more) return no_memory(&s->error);
    s->failure = more;
    s->room = room;
  }
  table_failure *f = &s->failure[s->failures++];
  memset(f, 0, sizeof *f);
  f->run = run;
  snprintf(f->reason, sizeof f->reason, "%s", reason);
  return NSDAE_OK;
}

static int take(void *user, long run, int status, const double *row, const char *reason)
{
  sweep *s = user;
  char what[64];
  s->done++;
  snprintf(what, sizeof what, "%ld of %ld runs", s->done, s->left);
  bar_show(&s->bar, (double)s->done / (double)s->left, what);
  if (status < 0 && note_failure(s, run, reason) < 0) return NSDAE_E_MEMORY;
  return table_put(s->table, run, status, row, &s->error);
}

static void describe(void *user, long run, char *text, size_t size)
{
  sweep *s = user;
  plan_describe(&s->job.plan, run, text, size);
}

static int list_todo(sweep *s)
{
  long runs = s->job.plan.runs;
  s->todo = malloc((size_t)runs * sizeof *s->todo);
  if (!s->todo) return no_memory(&s->error);
  for (long run = 0; run < runs; run++)
    if (!table_has(s->table, run)) s->todo[s->left++] = run;
  return NSDAE_OK;
}

/* Rank 0: the file and its pending runs. */
static int open_table(sweep *s)
{
  const job *j = &s->job;
  nsdae_system *system = NULL;
  char *setting = job_setting(j);
  if (!setting) return no_memory(&s->error);
  int status = j->settings.model->build(j->settings.model->base, &system, &s->error);
  const table_about about = {.model = j->settings.model->name,
                             .method = nsdae_method_name(j->settings.options.method),
                             .setting = setting,
                             .system = system,
                             .parameters = j->settings.model->parameters};
  if (status == NSDAE_OK)
    status = table_open(j->settings.output, &j->plan, &j->keep, &about, &s->table, &s->error);
  if (status == NSDAE_OK && !table_complete(s->table)) status = list_todo(s);
  nsdae_system_destroy(&system);
  free(setting);
  return status;
}

static void announce(const sweep *s)
{
  const job *j = &s->job;
  if (j->settings.quiet || s->left == 0) return;
  printf("%s: %ld runs, %s, dt %g s, to %g s", j->settings.model->name, j->plan.runs,
         nsdae_method_name(j->settings.options.method), j->settings.options.dt, j->settings.t_end);
  if (s->left < j->plan.runs) printf("; continued: %ld runs remain", s->left);
  if (ranks_size() > 1) printf("; %d processes", ranks_size());
  printf("\n");
  fflush(stdout);
}

/* The summary, with the first failures. */
static void summarize(const sweep *s)
{
  char what[256];
  if (s->job.settings.quiet) return;
  for (long i = 0; i < s->failures && i < 3; i++) {
    plan_describe(&s->job.plan, s->failure[i].run, what, sizeof what);
    printf("run %ld (%s) failed: %s\n", s->failure[i].run, what, s->failure[i].reason);
  }
  if (s->failures > 0) printf("%ld of %ld runs failed, see /failure\n", s->failures, s->done);
  printf("sweep in %s%s\n", s->job.settings.output,
         table_complete(s->table) ? ", already complete" : "");
}

static int go(sweep *s)
{
  const ranks_job ranks = {
      .user = s, .width = s->job.keep.width, .work = work, .take = take, .describe = describe};
  if (ranks_rank() == 0) {
    announce(s);
    bar_begin(&s->bar, s->job.settings.quiet);
    if (getenv("NSDAE_SWEEP_TERMINAL")) s->bar.terminal = !s->job.settings.quiet;
  }
  interrupt_catch();
  int status = ranks_go(&ranks, s->todo, s->left);
  bar_clear(&s->bar);
  if (ranks_rank() != 0) return status;
  if (status == NSDAE_E_INTERRUPTED)
    snprintf(s->error.text, sizeof s->error.text,
             "interrupted after %ld of %ld runs; the same command continues the sweep", s->done,
             s->left);
  if (status < 0 || table_complete(s->table)) return status;
  return table_finish(s->table, s->failure, s->failures, &s->error);
}

static int sweep_main(sweep *s, int argc, char **argv)
{
  int status = job_prepare(&s->job, &s->error);
  if (status < 0) return complain(&s->error, USAGE);
  status = ranks_agree(ranks_rank() == 0 ? open_table(s) : NSDAE_OK);
  if (status < 0) return complain(&s->error, status == NSDAE_E_ARGUMENT ? USAGE : FAILED);
  if (s->left > 0 && become_mpirun(s, argc, argv) < 0) return complain(&s->error, FAILED);
  status = go(s);
  if (status < 0) return complain(&s->error, FAILED);
  if (ranks_rank() == 0) summarize(s);
  return DONE; /* runs that failed are results too */
}

int main(int argc, char **argv)
{
  static sweep s;
  interrupt_not_by_size();
  ranks_begin(&argc, &argv);
  int exit_status = DONE, what = command_parse(&s.job, argc, argv, &s.error);
  if (what < 0)
    exit_status = complain(&s.error, USAGE);
  else if (what == COMMAND_HELP)
    command_usage();
  else if (what == COMMAND_VERSION)
    printf("nsdae-sweep %s\n", nsdae_build_info());
  else
    exit_status = sweep_main(&s, argc, argv);
  table_close(&s.table);
  job_release(&s.job);
  free(s.todo);
  free(s.failure);
  if ((fflush(stdout) != 0 || ferror(stdout)) && exit_status == DONE) {
    fputs("nsdae-sweep: error: cannot write to standard output\n", stderr);
    exit_status = FAILED;
  }
  ranks_end(exit_status == DONE ? 0 : NSDAE_OK);
  return exit_status;
}
