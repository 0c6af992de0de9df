/* Solves a complementarity problem from a file and prints the certificate. */
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <nsdae/nsdae.h>

#include "lcp_arguments.h"
#include "safe_read.h"
#include "tool.h"

typedef struct job {
  tool_arguments arguments;
  int solution, tol_given;
  nsdae_lcp_options options;
  nsdae_lcp_file file;
  int contacts;
} job;

static int set(void *object, int option, const char *value);
static const char *const options[] = {"--tol", "--stages", "--solution", NULL};
static const tool own = {"nsdae-lcp", options, 2, set};

static const char usage[] =
    "nsdae-lcp: solves a linear complementarity problem and prints the certificate\n"
    "\n"
    "usage: nsdae-lcp [OPTION]... FILE\n"
    "\n"
    "  FILE            HDF5 with the datasets A [n,n] and b [n], or text: n, storage, matrix, q\n"
    "  --tol X         residual of a solution, above 0 and at most 1 (default: the file's, else\n"
    "                  1e-10)\n"
    "  --stages LIST   runs only these stages, separated by commas:\n"
    "                 ";

static void print_usage(void)
{
  fputs(usage, stdout);
  tool_print_stages(NSDAE_LCP_ALL, nsdae_lcp_stage_name);
  puts("  --solution      prints x after the certificate, one value a line\n"
       "  -h, --help      this text\n"
       "  --version       version and build\n"
       "\n"
       "Exit status: 0 solved, 1 no solution found, 2 wrong usage.");
}

static int set_tol(job *j, const char *text)
{
  char *end;
  double tol = strtod(text, &end);
  if (end == text || *end) return tool_complain(&own, "--tol '%s' is not a number", text);
  if (!(tol > 0 && tol <= 1))
    return tool_complain(&own, "--tol %s is outside its range: it must be above 0 and at most 1",
                         text);
  j->options.tol = tol;
  j->tol_given = 1;
  return TOOL_SOLVED;
}

enum { TOL, STAGES, SOLUTION };

static int set(void *object, int option, const char *value)
{
  job *j = object;
  if (option == TOL) return set_tol(j, value);
  if (option == STAGES)
    return tool_stages(&own, value, NSDAE_LCP_ALL, nsdae_lcp_stage_name, &j->options.stages);
  j->solution = 1;
  return TOOL_SOLVED;
}

/* 1: the file begins as HDF5 does; 0: it does not; -1: it cannot be read (reported). */
static int is_hdf5(const char *path)
{
  char head[8] = {0};
  const char *why;
  FILE *stream = open_regular(path, &why);
  size_t got = stream ? fread(head, 1, sizeof head, stream) : 0;
  if (stream && ferror(stream)) why = strerror(errno);
  int failed = !stream || ferror(stream);
  if (stream) fclose(stream);
  if (failed) {
    tool_complain(&own, "cannot read '%s': %s", path, why);
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
  int status = probe(j->arguments.path, try_hdf5, NULL, error);
  return status < 0 ? status : nsdae_lcp_read(j->arguments.path, &j->file, error);
}

static int read_text(job *j, nsdae_error *error)
{
  lcp_file text;
  int status = lcp_file_read(j->arguments.path, &text, error);
  if (status < 0) return status;
  j->file = (nsdae_lcp_file){.n = text.n, .A = text.A, .b = text.b};
  j->contacts = text.contacts;
  return NSDAE_OK;
}

static int read_file(job *j)
{
  nsdae_error error;
  int hdf5 = is_hdf5(j->arguments.path);
  if (hdf5 < 0) return TOOL_USAGE;
  int status = hdf5 ? read_hdf5(j, &error) : read_text(j, &error);
  if (status < 0) return tool_complain(&own, "%s; --help describes the format", error.text);
  if (j->file.tol > 0 && j->file.tol <= 1 && !j->tol_given) j->options.tol = j->file.tol;
  return TOOL_SOLVED;
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
    return tool_complain(&own,
                         "'%s' has a NaN or an infinity in A or b: every entry must be finite",
                         j->arguments.path);
  if (status != NSDAE_OK && status != NSDAE_E_LCP && status != NSDAE_E_INFEASIBLE) {
    tool_complain(&own, "'%s': %s", j->arguments.path, nsdae_status_message(status));
    return TOOL_NOT_SOLVED;
  }
  print_certificate(j, &info);
  if (status != NSDAE_OK) return TOOL_NOT_SOLVED;
  for (int i = 0; j->solution && i < f->n; i++) printf("%.17g\n", x[i]);
  return TOOL_SOLVED;
}

static int run(job *j)
{
  int status = read_file(j);
  if (status != TOOL_SOLVED) return status;
  double *x = calloc(2 * (size_t)j->file.n + 1, sizeof *x);
  if (x)
    status = solve(j, x, x + j->file.n);
  else {
    tool_complain(&own, "'%s': out of memory", j->arguments.path);
    status = TOOL_NOT_SOLVED;
  }
  free(x);
  return status;
}

int main(int argc, char **argv)
{
  job j = {0};
  nsdae_lcp_options_default(&j.options);
  int status = tool_parse(&own, argc, argv, &j, &j.arguments);
  if (status != TOOL_SOLVED) return status;
  if (j.arguments.help)
    print_usage();
  else if (j.arguments.version)
    printf("nsdae-lcp %s\n", nsdae_build_info());
  else
    status = run(&j);
  nsdae_lcp_file_release(&j.file);
  return tool_finish(&own, status);
}
