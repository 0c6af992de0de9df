/* The Lemke kernel, and the solver warm-started from a neighbouring problem, beside Siconos's
 * lexicographic Lemke: the same problems, in turns in the same run, medians over the problems of
 * each family and size. Times are those of the call alone; ratios are to Siconos's, on its failures
 * too, which are mostly early ends. Usage: bench_lcp [largest n [smallest n]] */
#define _POSIX_C_SOURCE 200809L
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <nsdae/kernels.h>
#include <nsdae/lcp.h>

#include "bench_lcp_families.h"
#include "lcp_rival.h"
#include "ratio.h"

enum { MOST_PROBLEMS = 60, ROUNDS = 5 };

/* A residual (nsdae_dlcpres) that counts as solved. */
static const double tolerance = 1e-10;

typedef struct bench {
  lcp_case problem;
  rival *rival;
  double *x, *y, *work, *solve_work;
  int lwork, solve_lwork, solve_liwork;
  int *basis, *warm, *iwork, *solve_iwork;
  int pivots;
} bench;

typedef struct result {
  double ours, rivals, warm; /* seconds */
  int solved, rival_solved, warm_solved;
  int pivots;
} result;

static void *space(int count, size_t size)
{
  void *p = calloc((size_t)count + 1, size);
  if (!p) abort();
  return p;
}

static bench bench_create(int family, int n, random_state *r)
{
  bench c = {.problem = lcp_case_create(family, n, r)};
  double size;
  nsdae_dlemke(n, NULL, n, NULL, NULL, 0, NULL, NULL, NULL, &size, -1, NULL);
  nsdae_lcp_workspace(n, &c.solve_lwork, &c.solve_liwork);
  c.lwork = (int)size;
  c.rival = rival_create(n, c.problem.A, c.problem.near);
  c.x = space(n, sizeof(double));
  c.y = space(n, sizeof(double));
  c.work = space(c.lwork, sizeof(double));
  c.solve_work = space(c.solve_lwork, sizeof(double));
  c.basis = space(n, sizeof(int));
  c.warm = space(n, sizeof(int));
  c.iwork = space(8 * n, sizeof(int));
  c.solve_iwork = space(c.solve_liwork, sizeof(int));
  return c;
}

static void bench_destroy(bench *c)
{
  rival_destroy(c->rival);
  lcp_case_destroy(&c->problem);
  free(c->x);
  free(c->y);
  free(c->work);
  free(c->solve_work);
  free(c->basis);
  free(c->warm);
  free(c->iwork);
  free(c->solve_iwork);
}

static int kernel(bench *c, const double *b)
{
  int n = c->problem.n;
  return nsdae_dlemke(n, c->problem.A, n, b, NULL, 50 * n + 100, c->x, c->basis, &c->pivots,
                      c->work, c->lwork, c->iwork);
}

static void run_ours(bench *c)
{
  kernel(c, c->problem.near);
}

static void run_rival(bench *c)
{
  rival_solve(c->rival, c->x, c->y);
}

static void run_warm(bench *c)
{
  int n = c->problem.n;
  nsdae_lcp_problem p = {.n = n, .A = c->problem.A, .lda = n, .b = c->problem.near};
  nsdae_lcp_options options;
  nsdae_lcp_info info;
  nsdae_lcp_options_default(&options);
  memcpy(c->basis, c->warm, (size_t)n * sizeof *c->basis);
  nsdae_lcp_solve_in(&p, &options, c->basis, c->x, c->y, &info, c->solve_work, c->solve_lwork,
                     c->solve_iwork, c->solve_liwork);
}

static int is_solved(bench *c)
{
  int n = c->problem.n;
  double residual;
  nsdae_dlcpres(n, c->problem.A, n, c->problem.near, c->x, c->y, &residual, c->work);
  return residual < tolerance;
}

static double time_of(void (*run)(bench *), bench *c, int repeats)
{
  double start = ratio_cpu();
  for (int i = 0; i < repeats; i++) run(c);
  return (ratio_cpu() - start) / repeats;
}

/* Calls in one timing, so that the clock does not count. */
static int repeats_of(void (*run)(bench *), bench *c)
{
  double once = time_of(run, c, 1);
  return once > 1e-4 ? 1 : (int)(1e-4 / (once + 1e-9)) + 1;
}

static result measure(bench *c)
{
  result m = {.ours = INFINITY, .rivals = INFINITY, .warm = INFINITY};
  void (*const run[3])(bench *) = {run_ours, run_rival, run_warm};
  double *const best[3] = {&m.ours, &m.rivals, &m.warm};
  int repeats[3], rounds = c->problem.n > 200 ? 2 : ROUNDS;
  m.warm_solved = kernel(c, c->problem.b) == 0; /* the neighbour that the warm start comes from */
  memcpy(c->warm, c->basis, (size_t)c->problem.n * sizeof *c->warm);
  for (int i = 0; i < 3; i++) {
    if (i == 1 && !c->rival) continue;
    repeats[i] = repeats_of(run[i], c);
    *(i == 0 ? &m.solved : i == 1 ? &m.rival_solved : &m.warm_solved) = is_solved(c);
    if (i == 0) m.pivots = c->pivots;
  }
  for (int round = 0; round < rounds; round++)
    for (int i = 0; i < 3; i++)
      if (i != 1 || c->rival) *best[i] = fmin(*best[i], time_of(run[i], c, repeats[i]));
  return m;
}

/* Medians, as they are sorted: cold, and warm from a neighbour. */
static int leave(int family, int n, int problems, double *ours, double *warm, double *rivals)
{
  char title[80];
  double peers = 1e-6 * ratio_median(problems, rivals);
  snprintf(title, sizeof title, "LCP, %s, n = %d, cold", lcp_family_names[family], n);
  if (ratio_add(title, 1e-6 * ratio_median(problems, ours), "Siconos", peers) < 0) return -1;
  snprintf(title, sizeof title, "LCP, %s, n = %d, warm", lcp_family_names[family], n);
  return ratio_add(title, 1e-6 * ratio_median(problems, warm), "Siconos", peers);
}

/* One line of the table; -1 where what it says cannot be written to the file. */
static int compare(int family, int n, int problems)
{
  double ours[MOST_PROBLEMS], rivals[MOST_PROBLEMS], ratio[MOST_PROBLEMS], warm[MOST_PROBLEMS];
  double warm_ratio[MOST_PROBLEMS];
  double pivots[MOST_PROBLEMS];
  int solved[3] = {0};
  random_state r = {1000003u * (unsigned)n + (unsigned)family};
  for (int i = 0; i < problems; i++) {
    bench c = bench_create(family, n, &r);
    result m = measure(&c);
    ours[i] = 1e6 * m.ours;
    rivals[i] = 1e6 * m.rivals;
    ratio[i] = m.ours / m.rivals;
    warm[i] = 1e6 * m.warm;
    warm_ratio[i] = m.warm / m.rivals;
    pivots[i] = m.pivots;
    solved[0] += m.solved;
    solved[1] += m.rival_solved;
    solved[2] += m.warm_solved;
    bench_destroy(&c);
  }
  printf("%5d  %-12s %8d %6.0f %9.2f %9.2f", n, lcp_family_names[family], problems,
         ratio_median(problems, pivots), ratio_median(problems, ours),
         ratio_median(problems, warm));
  if (isfinite(rivals[0]))
    printf(" %10.2f %6.3f %6.3f", ratio_median(problems, rivals), ratio_median(problems, ratio),
           ratio_median(problems, warm_ratio));
  else
    printf(" %10s %6s %6s", "-", "-", "-");
  printf("   %3d %3d %3d\n", solved[0], solved[2], solved[1]);
  fflush(stdout);
  return leave(family, n, problems, ours, warm, rivals);
}

int main(int argc, char **argv)
{
  static const int sizes[] = {3, 9, 30, 99, 300, 999}, problems[] = {60, 60, 60, 30, 9, 3};
  int most = argc > 1 ? atoi(argv[1]) : 999, least = argc > 2 ? atoi(argv[2]) : 0;
  printf("Medians, times in us; solved: residual below %g.\n", tolerance);
  printf("    n  family       problems pivots    kernel      warm    Siconos  ratio   warm   "
         "solved: kernel, warm, Siconos\n");
  for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++)
    for (int family = 0; family < LCP_FAMILIES && sizes[i] <= most && sizes[i] >= least; family++)
      if (compare(family, sizes[i], problems[i]) < 0) return 1;
  return 0;
}
