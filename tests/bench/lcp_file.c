/* The solver, cold, beside Siconos's lexicographic Lemke on problems from files, in the same run.
 * usage: bench_lcp_file FILE... (what nsdae-lcp reads; no file: nothing to do) */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "lcp_arguments.h"
#include "lcp_rival.h"
#include "ratio.h"

enum { RUNS = 3 };

/* Largest |min(x_i, y_i)| with y = A x + b, of what either solver handed over. */
static double natural_residual(const lcp_file *file, const double *x)
{
  double worst = 0;
  for (int i = 0; i < file->n; i++) {
    double y = file->b[i];
    for (int j = 0; j < file->n; j++) y += file->A[(size_t)j * (size_t)file->n + (size_t)i] * x[j];
    worst = fmax(worst, fabs(fmin(x[i], y)));
  }
  return worst;
}

/* Seconds of one cold solution. */
static double time_ours(const lcp_file *file, double *x, double *y, nsdae_lcp_info *info)
{
  nsdae_lcp_problem problem = {.n = file->n, .A = file->A, .lda = file->n, .b = file->b};
  double start = ratio_cpu();
  nsdae_lcp_solve(&problem, NULL, x, y, info);
  return ratio_cpu() - start;
}

static double time_peer(rival *peer, const lcp_file *file, double *x, double *y, int *failed)
{
  memset(x, 0, (size_t)file->n * sizeof *x);
  double start = ratio_cpu();
  *failed = rival_solve(peer, x, y);
  return ratio_cpu() - start;
}

/* What the file of ratios gets: where it was not solved, nothing. */
static int compare(const char *path, const lcp_file *file)
{
  double ours[RUNS], theirs[RUNS], x_ours = 0, x_theirs = 0;
  nsdae_lcp_info info = {0};
  int failed = 0;
  double *x = calloc((size_t)file->n + 1, sizeof *x), *y = calloc((size_t)file->n + 1, sizeof *y);
  const char *slash = strrchr(path, '/'), *name = slash ? slash + 1 : path;
  rival *peer = rival_create(file->n, file->A, file->b);
  if (!x || !y) abort();
  for (int i = 0; i < RUNS; i++) {
    ours[i] = time_ours(file, x, y, &info);
    x_ours = natural_residual(file, x);
    theirs[i] = peer ? time_peer(peer, file, x, y, &failed) : NAN;
    x_theirs = natural_residual(file, x);
  }
  printf("%-40s n %5d  ours %-10s %10.4f s, residual %.1e", name, file->n,
         nsdae_outcome_name(info.outcome), ratio_median(RUNS, ours), x_ours);
  if (peer)
    printf(";  Siconos %-6s %10.4f s, residual %.1e; ratio %.4f", failed ? "failed" : "solved",
           ratio_median(RUNS, theirs), x_theirs,
           ratio_median(RUNS, ours) / ratio_median(RUNS, theirs));
  printf("\n");
  rival_destroy(peer);
  free(x);
  free(y);
  return failed || info.outcome != NSDAE_OUTCOME_SOLVED
             ? 0
             : ratio_add(name, ratio_median(RUNS, ours), "Siconos", ratio_median(RUNS, theirs));
}

int main(int argc, char **argv)
{
  for (int i = 1; i < argc; i++) {
    lcp_file file;
    nsdae_error error;
    if (lcp_file_read(argv[i], &file, &error) < 0) {
      fprintf(stderr, "%s\n", error.text);
      return 1;
    }
    int written = compare(argv[i], &file);
    lcp_file_release(&file);
    if (written < 0) return 1;
  }
  return 0;
}
