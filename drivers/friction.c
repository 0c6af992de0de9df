/* Solves a frictional contact problem from a file of FCLIB and prints the certificate. */
#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include <nsdae/nsdae.h>

#include "probe.h"

enum { SOLVED, NOT_SOLVED, USAGE };

/* What --set sets. */
typedef struct settings {
  double tol;
  int max_sweeps, max_iterations, refine;
  char stages[NSDAE_PARAM_TEXT_SIZE];
} settings;

typedef struct job {
  const char *path, *solution, *output;
  int help, version, cold, tol_given, refine_given;
  settings settings;
  nsdae_friction_options options;
  nsdae_friction_file file;
  int rows; /* of the problem */
} job;

static const nsdae_param entries[] = {
    {"tol", "1", "bound on the residual of a solution (default: the file's, else 1e-10)",
     NSDAE_PARAM_REAL, offsetof(settings, tol), 1e-10, 0, 1, NSDAE_OPEN_MIN, NULL},
    {"max_sweeps", "1", "of block Gauss-Seidel over an island; 0: as many as seem fit",
     NSDAE_PARAM_INT, offsetof(settings, max_sweeps), 0, 0, 1e9, 0, NULL},
    {"max_iterations", "1", "Newton and interior-point steps on an island; 0: as above",
     NSDAE_PARAM_INT, offsetof(settings, max_iterations), 0, 0, 1e9, 0, NULL},
    {"refine", "1", "Newton steps from a solution on (default: the file's, else 0)",
     NSDAE_PARAM_INT, offsetof(settings, refine), 0, 0, 1000, 0, NULL},
    {"stages", "", "only these, separated by commas", NSDAE_PARAM_TEXT, offsetof(settings, stages),
     0, 0, 0, 0, NULL}};
static const nsdae_params table = {entries, sizeof entries / sizeof *entries};

static int complain(const char *format, ...)
{
  va_list args;
  fflush(stdout);
  fprintf(stderr, "nsdae-friction: error: ");
  va_start(args, format);
  vfprintf(stderr, format, args);
  va_end(args);
  fputc('\n', stderr);
  return USAGE;
}

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
  for (int stage = 1; stage <= NSDAE_FRICTION_ALL; stage *= 2)
    printf(" %s", nsdae_friction_stage_name(stage));
  puts("\n"
       "  --cold             begins at zero, not at the guess that the file may hold\n"
       "  --solution FILE    writes r, one number a line, three (two, one) lines a contact\n"
       "  --output FILE      writes the problem and its solution, in the layout of FCLIB\n"
       "  --help, -h         this text\n"
       "  --version          version and build\n"
       "\n"
       "Exit status: 0 solved, 1 no solution found, 2 wrong usage.");
}

/* Adds the stage of that name. */
static int add_stage(job *j, const char *name)
{
  const char *names[32] = {0};
  int count = 0;
  for (int stage = 1; stage <= NSDAE_FRICTION_ALL; stage *= 2) {
    names[count] = nsdae_friction_stage_name(stage);
    if (strcmp(name, names[count++]) != 0) continue;
    j->options.stages |= stage;
    return SOLVED;
  }
  const char *near = nsdae_nearest_name(name, names);
  if (near) return complain("unknown stage '%s'; did you mean '%s'?", name, near);
  return complain("unknown stage '%s'; --help lists all", name);
}

static int set_stages(job *j)
{
  if (!j->settings.stages[0]) return SOLVED;
  j->options.stages = 0;
  for (const char *at = j->settings.stages;; at++) {
    char name[32];
    size_t length = strcspn(at, ",");
    snprintf(name, sizeof name, "%.*s", (int)(length < 31 ? length : 31), at);
    if (add_stage(j, name) != SOLVED) return USAGE;
    at += length;
    if (!*at) return SOLVED;
  }
}

static int set(job *j, const char *text)
{
  char key[64];
  nsdae_error error;
  const char *value = strchr(text, '=');
  if (!value) return complain("--set '%s': must be NAME=VALUE", text);
  snprintf(key, sizeof key, "%.*s", (int)(value - text < 63 ? value - text : 63), text);
  if (nsdae_params_set(&table, &j->settings, key, value + 1, &error) < 0)
    return complain("--set %s: %s", text, error.text);
  j->tol_given |= strcmp(key, "tol") == 0;
  j->refine_given |= strcmp(key, "refine") == 0;
  return SOLVED;
}

static int unknown_option(const char *word)
{
  const char *const names[] = {"--set",  "--cold",    "--solution", "--output",
                               "--help", "--version", NULL};
  const char *near = nsdae_nearest_name(word, names);
  if (near) return complain("unknown option '%s'; did you mean '%s'?", word, near);
  return complain("unknown option '%s'; --help lists all", word);
}

/* An option that takes a value, as "--set X" or "--set=X". */
static int parse_valued(job *j, int argc, char **argv, int *i)
{
  static const char *const names[] = {"--set", "--solution", "--output"};
  char *word = argv[*i], *value = strchr(word, '=');
  size_t length = value ? (size_t)(value - word) : strlen(word), k = 0;
  while (k < 3 && (strlen(names[k]) != length || strncmp(word, names[k], length) != 0)) k++;
  if (k == 3) return unknown_option(word);
  if (!value && *i + 1 >= argc) return complain("%s needs a value", word);
  const char *text = value ? value + 1 : argv[++*i];
  if (k == 0) return set(j, text);
  *(k == 1 ? &j->solution : &j->output) = text;
  return SOLVED;
}

static int set_path(job *j, const char *word)
{
  if (j->path) return complain("'%s' and '%s': one FILE at a time", j->path, word);
  j->path = word;
  return SOLVED;
}

static int parse(job *j, int argc, char **argv)
{
  for (int i = 1; i < argc; i++) {
    int status = SOLVED;
    if (strcmp(argv[i], "--help") == 0 || strcmp(argv[i], "-h") == 0)
      j->help = 1;
    else if (strcmp(argv[i], "--version") == 0)
      j->version = 1;
    else if (strcmp(argv[i], "--cold") == 0)
      j->cold = 1;
    else if (argv[i][0] == '-')
      status = parse_valued(j, argc, argv, &i);
    else
      status = set_path(j, argv[i]);
    if (status != SOLVED) return status;
  }
  if (j->help || j->version) return SOLVED;
  if (!j->path) return complain("no FILE given: nsdae-friction FILE; --help says what it may be");
  return set_stages(j);
}

static int try_file(const char *path, void *user, nsdae_error *error)
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
  if (probe(j->path, try_file, NULL, &error) < 0 ||
      nsdae_friction_read(j->path, &j->file, &error) < 0)
    return complain("%s; --help says what a file may be", error.text);
  for (int c = 0; c < p->contacts; c++) j->rows += p->rows ? p->rows[c] : 3;
  j->rows += p->bilateral;
  j->options.tol =
      j->file.tol > 0 && j->file.tol <= 1 && !j->tol_given ? j->file.tol : j->settings.tol;
  j->options.max_sweeps = j->settings.max_sweeps;
  j->options.max_iterations = j->settings.max_iterations;
  j->options.refine = j->refine_given ? j->settings.refine : j->file.refine;
  return SOLVED;
}

static void print_certificate(const job *j, const nsdae_friction_info *info, double seconds)
{
  const nsdae_friction_problem *p = &j->file.problem;
  printf("outcome: %s\n", nsdae_outcome_name(info->outcome));
  printf("residual: %.2g\n", info->residual);
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

/* r as text. */
static int write_text(const job *j, const double *r)
{
  FILE *stream = fopen(j->solution, "w");
  int number = errno, failed = !stream;
  for (int i = 0; !failed && i < j->rows; i++) failed = fprintf(stream, "%.17g\n", r[i]) < 0;
  if (stream && fclose(stream) != 0) failed = 1;
  if (!failed) return SOLVED;
  complain("cannot write '%s': %s", j->solution, strerror(stream ? errno : number));
  return NOT_SOLVED;
}

static int keep(const job *j, const double *guess, const double *r, const double *u)
{
  nsdae_error error;
  const nsdae_friction_points points = {.guess = guess, .r = r, .u = u};
  const nsdae_friction_origin origin = {.tol = j->options.tol, .refine = j->options.refine};
  if (j->solution && write_text(j, r) != SOLVED) return NOT_SOLVED;
  if (!j->output) return SOLVED;
  if (nsdae_friction_write(j->output, &j->file.problem, &points, &origin, &error) == NSDAE_OK)
    return SOLVED;
  complain("%s", error.text);
  return NOT_SOLVED;
}

static double clock_now(void)
{
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static int solve(const job *j, double *r, double *u)
{
  nsdae_error error;
  nsdae_friction_info info;
  const nsdae_friction_problem *p = &j->file.problem;
  const double *guess = j->cold ? NULL : j->file.guess;
  if (nsdae_friction_check(p, &error) < 0) return complain("'%s': %s", j->path, error.text);
  for (int i = 0; i < j->rows; i++) r[i] = guess ? guess[i] : 0;
  double start = clock_now();
  int status = nsdae_friction_solve(p, &j->options, r, u, &info);
  if (status != NSDAE_OK && status != NSDAE_E_LCP && status != NSDAE_E_INFEASIBLE) {
    complain("'%s': %s", j->path, nsdae_status_message(status));
    return NOT_SOLVED;
  }
  print_certificate(j, &info, clock_now() - start);
  if (status != NSDAE_OK) return NOT_SOLVED;
  return keep(j, guess, r, u);
}

static int run(job *j)
{
  int status = read_file(j);
  if (status != SOLVED) return status;
  double *r = calloc(2 * (size_t)j->rows + 1, sizeof *r);
  if (r)
    status = solve(j, r, r + j->rows);
  else {
    complain("'%s': out of memory", j->path);
    status = NOT_SOLVED;
  }
  free(r);
  return status;
}

/* A certificate that did not get out is none. */
static int flush(int status)
{
  if (fflush(stdout) == 0 && !ferror(stdout)) return status;
  complain("cannot write the result: %s", strerror(errno));
  return NOT_SOLVED;
}

int main(int argc, char **argv)
{
  job j = {0};
  nsdae_params_default(&table, &j.settings);
  nsdae_friction_options_default(&j.options);
  int status = parse(&j, argc, argv);
  if (status != SOLVED) return status;
  if (j.help)
    print_usage();
  else if (j.version)
    printf("nsdae-friction %s\n", nsdae_build_info());
  else
    status = run(&j);
  nsdae_friction_file_release(&j.file);
  return flush(status);
}
