/* Solves a frictional contact problem from a file of FCLIB and prints the certificate. */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include <nsdae/nsdae.h>

#include "progress.h"
#include "interrupt_signal.h"
#include "safe_read.h"
#include "tool.h"

/* Settings of --set. */
typedef struct settings {
  double tol, budget;
  int max_sweeps, max_iterations, refine;
  char stages[NSDAE_PARAM_TEXT_SIZE];
} settings;

typedef struct job {
  tool_arguments arguments;
  const char *solution, *output;
  int cold, twice, tol_given, refine_given;
  settings settings;
  nsdae_friction_options options;
  nsdae_friction_file file;
  int rows; /* of the problem */
} job;

static const nsdae_param entries[] = {
    {"tol", "1", "bound on the residual of a solution (default: the file's, else 1e-10)",
     NSDAE_PARAM_REAL, offsetof(settings, tol), 1e-10, 0, 1, NSDAE_OPEN_MIN, NULL},
    {"budget", "1", "multiplications by J or W on an island; 0: about a minute at most",
     NSDAE_PARAM_REAL, offsetof(settings, budget), 0, 0, 1e18, 0, NULL},
    {"max_sweeps", "1", "sweeps of block Gauss-Seidel on an island; 0: by the budget",
     NSDAE_PARAM_INT, offsetof(settings, max_sweeps), 0, 0, 1e9, 0, NULL},
    {"max_iterations", "1", "Newton and interior-point steps on an island; 0: by the budget",
     NSDAE_PARAM_INT, offsetof(settings, max_iterations), 0, 0, 1e9, 0, NULL},
    {"refine", "1", "Newton steps after a solution (default: the file's, else 0)", NSDAE_PARAM_INT,
     offsetof(settings, refine), 0, 0, 1000, 0, NULL},
    {"stages", "", "runs only these stages, separated by commas", NSDAE_PARAM_TEXT,
     offsetof(settings, stages), 0, 0, 0, 0, NULL}};
static const nsdae_params table = {entries, sizeof entries / sizeof *entries};

/* The solution; low is NULL without --twice. */
typedef struct point {
  double *r, *low, *u;
} point;

static int set(void *object, int option, const char *value);
static const char *const options[] = {"--set", "--solution", "--output", "--cold", "--twice", NULL};
static const tool own = {"nsdae-friction", options, 3, set};

static const char usage[] =
    "nsdae-friction: solves a frictional contact problem and prints the certificate\n"
    "\n"
    "usage: nsdae-friction [OPTION]... FILE\n"
    "\n"
    "  FILE               HDF5 in the layout of FCLIB, local (W, q, mu) or global (M, H, f, w, "
    "mu)\n"
    "  --set NAME=VALUE   an option by its name; repeatable\n";

static void print_usage(void)
{
  fputs(usage, stdout);
  for (int i = 0; i < table.n; i++) printf("      %-15s %s\n", entries[i].key, entries[i].help);
  fputs("     ", stdout);
  tool_print_stages(NSDAE_FRICTION_ALL, nsdae_friction_stage_name);
  puts("  --cold             starts at zero, not at the guess of the file\n"
       "  --twice            computes a double-double solution r + low\n"
       "  --solution FILE    writes r, one number a line, three (two, one) lines a contact; with\n"
       "                     --twice two numbers, r and low\n"
       "  --output FILE      writes the problem and its solution, in the layout of FCLIB\n"
       "  --help, -h         this text\n"
       "  --version          version and build\n"
       "\n"
       "Exit status: 0 solved, 1 no solution found, 2 wrong usage.");
}

static int set_entry(job *j, const char *text)
{
  char key[64];
  nsdae_error error;
  const char *value = strchr(text, '=');
  if (!value) return tool_complain(&own, "--set '%s': must be NAME=VALUE", text);
  snprintf(key, sizeof key, "%.*s", (int)(value - text < 63 ? value - text : 63), text);
  if (nsdae_params_set(&table, &j->settings, key, value + 1, &error) < 0)
    return tool_complain(&own, "--set %s: %s", text, error.text);
  j->tol_given |= strcmp(key, "tol") == 0;
  j->refine_given |= strcmp(key, "refine") == 0;
  return TOOL_SOLVED;
}

enum { SET, SOLUTION, OUTPUT, COLD, TWICE };

static int set(void *object, int option, const char *value)
{
  job *j = object;
  if (option == SET) return set_entry(j, value);
  if (option == SOLUTION) j->solution = value;
  if (option == OUTPUT) j->output = value;
  if (option == COLD) j->cold = 1;
  if (option == TWICE) j->twice = 1;
  return TOOL_SOLVED;
}

static int parse(job *j, int argc, char **argv)
{
  int status = tool_parse(&own, argc, argv, j, &j->arguments);
  if (status != TOOL_SOLVED || !j->arguments.path || !j->settings.stages[0]) return status;
  return tool_stages(&own, j->settings.stages, NSDAE_FRICTION_ALL, nsdae_friction_stage_name,
                     &j->options.stages);
}

static int try_read(const char *path, void *user, nsdae_error *error)
{
  nsdae_friction_file file;
  (void)user;
  int status = nsdae_friction_read(path, &file, error);
  nsdae_friction_file_release(&file);
  return status;
}

static int read_file(job *j)
{
  nsdae_error error;
  const nsdae_friction_problem *p = &j->file.problem;
  int status = probe(j->arguments.path, try_read, NULL, &error); /* the file may be damaged */
  if (status == NSDAE_OK) status = nsdae_friction_read(j->arguments.path, &j->file, &error);
  if (status < 0) return tool_complain(&own, "%s; --help describes the format", error.text);
  for (int c = 0; c < p->contacts; c++) j->rows += p->rows ? p->rows[c] : 3;
  j->rows += p->bilateral;
  j->options.tol =
      j->file.tol > 0 && j->file.tol <= 1 && !j->tol_given ? j->file.tol : j->settings.tol;
  j->options.budget = j->settings.budget;
  j->options.max_sweeps = j->settings.max_sweeps;
  j->options.max_iterations = j->settings.max_iterations;
  j->options.refine = j->refine_given ? j->settings.refine : j->file.refine;
  return TOOL_SOLVED;
}

/* How many parts the point has. */
static int parts(const job *j, const double *low)
{
  for (int i = 0; i < j->rows; i++)
    if (low[i] != 0) return 2;
  return 1;
}

static void print_certificate(const job *j, const nsdae_friction_info *info, const double *low,
                              double seconds)
{
  const nsdae_friction_problem *p = &j->file.problem;
  printf("outcome: %s\n", nsdae_outcome_name(info->outcome));
  printf("residual: %.2g\n", info->residual);
  if (low) printf("parts: %d\n", parts(j, low));
  printf("stage: %s\n", nsdae_friction_stage_name(info->stage));
  if (info->proof != NSDAE_PROOF_NONE) printf("proof: %s\n", nsdae_proof_name(info->proof));
  printf("form: %s\n", p->form == NSDAE_FRICTION_LOCAL ? "local" : "global");
  printf("contacts: %d\n", p->contacts);
  if (p->bilateral > 0) printf("bilateral: %d\n", p->bilateral);
  printf("islands: %d\n", info->islands);
  printf("sweeps: %ld\n", info->sweeps);
  printf("iterations: %d\n", info->iterations);
  if (j->file.asymmetry > 0)
    printf("asymmetry: %.2g (%s)\n", j->file.asymmetry,
           p->form == NSDAE_FRICTION_LOCAL ? "solved with (W + W^T) / 2"
                                           : "solved with (M + M^T) / 2");
  printf("tol: %g\n", j->options.tol);
  printf("time: %.3g s\n", seconds);
}

/* r as text; low is a second column. */
static int write_text(const job *j, const point *at)
{
  FILE *stream = fopen(j->solution, "w");
  int number = errno, failed = !stream;
  for (int i = 0; !failed && i < j->rows; i++)
    failed = (at->low ? fprintf(stream, "%.17g %.17g\n", at->r[i], at->low[i])
                      : fprintf(stream, "%.17g\n", at->r[i])) < 0;
  if (stream && fclose(stream) != 0) failed = 1;
  if (!failed) return TOOL_SOLVED;
  tool_complain(&own, "cannot write '%s': %s", j->solution, strerror(stream ? errno : number));
  return TOOL_NOT_SOLVED;
}

static int keep(const job *j, const double *guess, const point *at)
{
  nsdae_error error;
  const nsdae_friction_points points = {.guess = guess, .r = at->r, .u = at->u, .low = at->low};
  const nsdae_friction_origin origin = {.tol = j->options.tol, .refine = j->options.refine};
  if (j->solution && write_text(j, at) != TOOL_SOLVED) return TOOL_NOT_SOLVED;
  if (!j->output) return TOOL_SOLVED;
  if (nsdae_friction_write(j->output, &j->file.problem, &points, &origin, &error) == NSDAE_OK)
    return TOOL_SOLVED;
  tool_complain(&own, "%s", error.text);
  return TOOL_NOT_SOLVED;
}

static double clock_now(void)
{
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* Draws the bar; Ctrl-C interrupts. */
static int show_progress(const nsdae_friction_progress *now, void *shown)
{
  char what[96];
  snprintf(what, sizeof what, "%s, island %d of %d, residual %.1e",
           nsdae_friction_stage_name(now->stage), now->island + 1, now->islands, now->residual);
  bar_show(shown, now->share, what);
  return interrupt_came();
}

static int solve(job *j, const point *at)
{
  bar progress;
  nsdae_error error;
  nsdae_friction_info info;
  const nsdae_friction_problem *p = &j->file.problem;
  const double *guess = j->cold ? NULL : j->file.guess;
  if (nsdae_friction_check(p, &error) < 0)
    return tool_complain(&own, "'%s': %s", j->arguments.path, error.text);
  for (int i = 0; i < j->rows; i++) at->r[i] = guess ? guess[i] : 0;
  j->options.progress = show_progress;
  j->options.user = &progress;
  interrupt_catch();
  bar_begin(&progress, 0);
  double start = clock_now();
  int status = nsdae_friction_solve_twice(p, &j->options, at->r, at->low, at->u, &info);
  bar_clear(&progress);
  if (status == NSDAE_E_INTERRUPTED) tool_complain(&own, "interrupted");
  if (status != NSDAE_OK && status != NSDAE_E_LCP && status != NSDAE_E_INFEASIBLE &&
      status != NSDAE_E_INTERRUPTED) {
    tool_complain(&own, "'%s': %s", j->arguments.path, nsdae_status_message(status));
    return TOOL_NOT_SOLVED;
  }
  print_certificate(j, &info, at->low, clock_now() - start);
  if (status != NSDAE_OK) return TOOL_NOT_SOLVED;
  return keep(j, guess, at);
}

static int run(job *j)
{
  int status = read_file(j);
  if (status != TOOL_SOLVED) return status;
  double *r = calloc(3 * (size_t)j->rows + 1, sizeof *r);
  if (r) {
    const point at = {r, j->twice ? r + 2 * (size_t)j->rows : NULL, r + j->rows};
    status = solve(j, &at);
  } else {
    tool_complain(&own, "'%s': out of memory", j->arguments.path);
    status = TOOL_NOT_SOLVED;
  }
  free(r);
  return status;
}

int main(int argc, char **argv)
{
  job j = {0};
  nsdae_params_default(&table, &j.settings);
  nsdae_friction_options_default(&j.options);
  int status = parse(&j, argc, argv);
  if (status != TOOL_SOLVED) return status;
  if (j.arguments.help)
    print_usage();
  else if (j.arguments.version)
    printf("nsdae-friction %s\n", nsdae_build_info());
  else
    status = run(&j);
  nsdae_friction_file_release(&j.file);
  return tool_finish(&own, status);
}
