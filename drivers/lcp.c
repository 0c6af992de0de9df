/* Solves a complementarity problem from a file and prints the certificate. */
#include <errno.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <nsdae/nsdae.h>

#include "lcp_file.h"
#include "probe.h"

enum { SOLVED, NOT_SOLVED, USAGE };

typedef struct job {
  const char *path;
  int solution, help, version;
  int tol_given;
  nsdae_lcp_options options;
  nsdae_lcp_file file;
  int contacts;
} job;

static int complain(const char *format, ...)
{
  va_list args;
  fflush(stdout);
  fprintf(stderr, "nsdae-lcp: error: ");
  va_start(args, format);
  vfprintf(stderr, format, args);
  va_end(args);
  fputc('\n', stderr);
  return USAGE;
}

static const char usage[] =
    "nsdae-lcp: solves a linear complementarity problem and prints the certificate\n"
    "\n"
    "usage: nsdae-lcp [OPTION]... FILE\n"
    "\n"
    "  FILE            HDF5 with the datasets A [n,n] and b [n], or text: n, storage, matrix, q\n"
    "  --tol X         residual of a solution, above 0 and at most 1 (default: the file's, else\n"
    "                  1e-10)\n"
    "  --stages LIST   only these, separated by commas:\n"
    "                 ";

static void print_usage(void)
{
  fputs(usage, stdout);
  for (int stage = 1; stage <= NSDAE_LCP_ALL; stage *= 2)
    printf(" %s", nsdae_lcp_stage_name(stage));
  puts("\n"
       "  --solution      print x after the certificate, one value a line\n"
       "  --help          this text\n"
       "  --version       version and build\n"
       "\n"
       "Exit status: 0 solved, 1 no solution found, 2 wrong usage.");
}

/* Adds the stage of that name. */
static int add_stage(job *j, const char *name)
{
  const char *names[16] = {0};
  int count = 0;
  for (int stage = 1; stage <= NSDAE_LCP_ALL; stage *= 2) {
    names[count] = nsdae_lcp_stage_name(stage);
    if (strcmp(name, names[count++]) != 0) continue;
    j->options.stages |= stage;
    return SOLVED;
  }
  const char *near = nsdae_nearest_name(name, names);
  if (near) return complain("unknown stage '%s'; did you mean '%s'?", name, near);
  return complain("unknown stage '%s'; --help lists all", name);
}

static int set_stages(job *j, const char *list)
{
  j->options.stages = 0;
  for (const char *at = list;; at++) {
    char name[32];
    size_t length = strcspn(at, ",");
    snprintf(name, sizeof name, "%.*s", (int)(length < 31 ? length : 31), at);
    if (add_stage(j, name) != SOLVED) return USAGE;
    at += length;
    if (!*at) return SOLVED;
  }
}

static int set_tol(job *j, const char *text)
{
  char *end;
  double tol = strtod(text, &end);
  if (end == text || *end) return complain("--tol '%s' is not a number", text);
  if (!(tol > 0 && tol <= 1))
    return complain("--tol %s is outside its range: it must be above 0 and at most 1", text);
  j->options.tol = tol;
  j->tol_given = 1;
  return SOLVED;
}

static int unknown_option(const char *word)
{
  const char *const names[] = {"--tol", "--stages", "--solution", "--help", "--version", NULL};
  const char *near = nsdae_nearest_name(word, names);
  if (near) return complain("unknown option '%s'; did you mean '%s'?", word, near);
  return complain("unknown option '%s'; --help lists all", word);
}

static int set_path(job *j, const char *word)
{
  if (j->path) return complain("'%s' and '%s': one FILE at a time", j->path, word);
  j->path = word;
  return SOLVED;
}

/* An option that takes a value, as "--tol X" or "--tol=X". */
static int parse_valued(job *j, int argc, char **argv, int *i)
{
  char *word = argv[*i], *value = strchr(word, '=');
  size_t length = value ? (size_t)(value - word) : strlen(word);
  int is_tol = length == 5 && strncmp(word, "--tol", length) == 0;
  if (!is_tol && !(length == 8 && strncmp(word, "--stages", length) == 0))
    return unknown_option(word);
  if (!value && *i + 1 >= argc) return complain("%s needs a value", word);
  const char *text = value ? value + 1 : argv[++*i];
  return is_tol ? set_tol(j, text) : set_stages(j, text);
}

static int parse(job *j, int argc, char **argv)
{
  for (int i = 1; i < argc; i++) {
    int status = SOLVED;
    if (strcmp(argv[i], "--solution") == 0)
      j->solution = 1;
    else if (strcmp(argv[i], "--help") == 0)
      j->help = 1;
    else if (strcmp(argv[i], "--version") == 0)
      j->version = 1;
    else if (argv[i][0] == '-')
      status = parse_valued(j, argc, argv, &i);
    else
      status = set_path(j, argv[i]);
    if (status != SOLVED) return status;
  }
  return j->help || j->version || j->path ? SOLVED
                                          : complain("no FILE given: nsdae-lcp FILE; --help "
                                                     "says what it may be");
}

/* 1: the file begins as HDF5 does; 0: it does not; -1: it cannot be read, which was said. */
static int is_hdf5(const char *path)
{
  char head[8] = {0};
  FILE *stream = fopen(path, "rb");
  size_t got = stream ? fread(head, 1, sizeof head, stream) : 0;
  int failed = !stream || ferror(stream), number = errno;
  if (stream) fclose(stream);
  if (failed) {
    complain("cannot read '%s': %s", path, strerror(number));
    return -1;
  }
  return got == sizeof head && memcmp(head, "\x89HDF\r\n\x1a\n", sizeof head) == 0;
}

static int try_hdf5(const char *path, void *user, nsdae_error *error)
{
  nsdae_lcp_file file;
  (void)user;
  int status = nsdae_lcp_read(path, &file, error);
  nsdae_lcp_file_release(&file);
  return status;
}

/* A file may be damaged. */
static int read_hdf5(job *j, nsdae_error *error)
{
  int status = probe(j->path, try_hdf5, NULL, error);
  return status < 0 ? status : nsdae_lcp_read(j->path, &j->file, error);
}

static int read_text(job *j, nsdae_error *error)
{
  lcp_file text;
  int status = lcp_file_read(j->path, &text, error);
  if (status < 0) return status;
  j->file = (nsdae_lcp_file){.n = text.n, .A = text.A, .b = text.b};
  j->contacts = text.contacts;
  return NSDAE_OK;
}

static int read_file(job *j)
{
  nsdae_error error;
  int hdf5 = is_hdf5(j->path);
  if (hdf5 < 0) return USAGE;
  int status = hdf5 ? read_hdf5(j, &error) : read_text(j, &error);
  if (status < 0) return complain("%s; --help says what a file may be", error.text);
  if (j->file.tol > 0 && j->file.tol <= 1 && !j->tol_given) j->options.tol = j->file.tol;
  return SOLVED;
}

static void print_certificate(const job *j, const nsdae_lcp_info *info)
{
  printf("outcome: %s\n", nsdae_outcome_name(info->outcome));
  printf("residual: %.2g\n", info->residual);
  printf("stage: %s\n", nsdae_lcp_stage_name(info->stage));
  if (info->proof != NSDAE_PROOF_NONE) printf("proof: %s\n", nsdae_proof_name(info->proof));
  if (info->ray != NSDAE_LCP_RAY_NOTHING) printf("ray: %s\n", nsdae_lcp_ray_name(info->ray));
  printf("n: %d\n", j->file.n);
  if (j->contacts > 0) printf("contacts: %d\n", j->contacts);
  printf("pivots: %d\n", info->pivots);
  printf("tol: %g\n", j->options.tol);
}

static int solve(const job *j, double *x, double *y)
{
  const nsdae_lcp_file *f = &j->file;
  nsdae_lcp_problem problem = {.n = f->n, .A = f->A, .lda = f->n > 0 ? f->n : 1, .b = f->b};
  nsdae_lcp_info info;
  int status = nsdae_lcp_solve(&problem, &j->options, x, y, &info);
  if (status == NSDAE_E_NONFINITE)
    return complain("'%s' has a NaN or an infinity in A or b: every entry must be finite", j->path);
  if (status != NSDAE_OK && status != NSDAE_E_LCP && status != NSDAE_E_INFEASIBLE) {
    complain("'%s': %s", j->path, nsdae_status_message(status));
    return NOT_SOLVED;
  }
  print_certificate(j, &info);
  if (status != NSDAE_OK) return NOT_SOLVED;
  for (int i = 0; j->solution && i < f->n; i++) printf("%.17g\n", x[i]);
  return SOLVED;
}

static int run(job *j)
{
  int status = read_file(j);
  if (status != SOLVED) return status;
  double *x = calloc(2 * (size_t)j->file.n + 1, sizeof *x);
  if (x)
    status = solve(j, x, x + j->file.n);
  else {
    complain("'%s': out of memory", j->path);
    status = NOT_SOLVED;
  }
  free(x);
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
  nsdae_lcp_options_default(&j.options);
  int status = parse(&j, argc, argv);
  if (status != SOLVED) return status;
  if (j.help)
    print_usage();
  else if (j.version)
    printf("nsdae-lcp %s\n", nsdae_build_info());
  else
    status = run(&j);
  nsdae_lcp_file_release(&j.file);
  return flush(status);
}
