/* The solver, cold, beside Siconos's lexicographic Lemke on problems from files, in the same run.
 * usage: bench_lcp_file FILE... (what nsdae-lcp reads; no file: nothing to do) */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "lcp_file.h"
#include "lcp_rival.h"

static double now(void)
{
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

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

static void compare(const char *path, const lcp_file *file)
{
  nsdae_lcp_problem problem = {.n = file->n, .A = file->A, .lda = file->n, .b = file->b};
  nsdae_lcp_info info;
  double *x = calloc((size_t)file->n + 1, sizeof *x), *y = calloc((size_t)file->n + 1, sizeof *y);
  const char *name = strrchr(path, '/');
  if (!x || !y) abort();
  double start = now();
  nsdae_lcp_solve(&problem, NULL, x, y, &info);
  double ours = now() - start;
  printf("%-40s n %5d  ours %-10s %10.4f s, residual %.1e", name ? name + 1 : path, file->n,
         nsdae_outcome_name(info.outcome), ours, natural_residual(file, x));
  rival *peer = rival_create(file->n, file->A, file->b);
  if (peer) {
    memset(x, 0, (size_t)file->n * sizeof *x);
    start = now();
    int failed = rival_solve(peer, x, y);
    double theirs = now() - start;
    printf(";  Siconos %-6s %10.4f s, residual %.1e; ratio %.4f", failed ? "failed" : "solved",
           theirs, natural_residual(file, x), ours / theirs);
  }
  printf("\n");
  rival_destroy(peer);
  free(x);
  free(y);
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
    compare(argv[i], &file);
    lcp_file_release(&file);
  }
  return 0;
}
