/* The solver: one stage after the other until the residual, computed afresh from A and b, is
 * below the tolerance.
 *
 * Rows and columns are scaled by powers of two first where their sizes differ much: with R, C > 0
 * diagonal, (R A C, R b) has the solution C^-1 x, R y, and no rounding is added. */
#include <math.h>
#include <nsdae/kernels.h>
#include <nsdae/lcp.h>
#include <stddef.h>
#include <string.h>

#include "dense.h"
#include "fischer.h"

enum { COVERINGS = 12 };

/* The problem at work. */
typedef struct chain {
  const nsdae_lcp_problem *problem;
  const nsdae_lcp_options *options;
  nsdae_lcp_info *info;
  int n;
  int *basis;
  double *x, *y;
  double *A, *b;        /* scaled: n x n, n */
  double *row, *column; /* R and C */
  double *cover;        /* n */
  double *sizes;        /* n: workspace of the residual */
  double *best;         /* n: the best point so far */
  double *lu, *rhs;     /* n x n, n */
  double *lemke;        /* lemke_size(n) */
  double *scaled;       /* 2 n: x and y of the semismooth Newton method */
  double *newton;       /* 2 n^2 + 4 n: its workspace */
  int *trial, *pivot;   /* n, n */
  int *index;           /* 2 n + 1 */
} chain;

static int lemke_size(int n)
{
  double size = 0;
  nsdae_dlemke(n, NULL, n, NULL, NULL, 0, NULL, NULL, NULL, &size, -1, NULL);
  return (int)size;
}

int nsdae_lcp_workspace(int n, int *lwork, int *liwork)
{
  if (n < 0 || n > 20000 || !lwork || !liwork) return NSDAE_E_ARGUMENT;
  *lwork = 4 * n * n + 13 * n + 1 + lemke_size(n);
  *liwork = 4 * n + 1;
  return NSDAE_OK;
}

static void lay_out(chain *c, double *work, int *iwork)
{
  size_t n = (size_t)c->n;
  c->A = work;
  c->lu = c->A + n * n;
  c->lemke = c->lu + n * n;
  c->b = c->lemke + lemke_size(c->n);
  c->row = c->b + n;
  c->column = c->row + n;
  c->cover = c->column + n;
  c->best = c->cover + n;
  c->rhs = c->best + n;
  c->scaled = c->rhs + n;
  c->newton = c->scaled + 2 * n;
  c->sizes = c->newton + 2 * n * n + 4 * n;
  c->trial = iwork;
  c->pivot = c->trial + n;
  c->index = c->pivot + n;
}

/* Power of two near 1 / sqrt(size). */
static double root_scale(double size)
{
  int exponent;
  if (!(size > 0)) return 1;
  frexp(size, &exponent);
  return ldexp(1, -exponent / 2);
}

static double largest_in_row(const chain *c, int i)
{
  double most = 0;
  for (int j = 0; j < c->n; j++)
    most = fmax(most, fabs(c->A[(size_t)j * (size_t)c->n + (size_t)i]));
  return most;
}

static double largest_in_column(const chain *c, int j)
{
  double most = 0;
  for (int i = 0; i < c->n; i++)
    most = fmax(most, fabs(c->A[(size_t)j * (size_t)c->n + (size_t)i]));
  return most;
}

static void scale_once(chain *c)
{
  size_t n = (size_t)c->n;
  for (size_t i = 0; i < n; i++) c->rhs[i] = root_scale(largest_in_row(c, (int)i));
  for (size_t j = 0; j < n; j++) c->cover[j] = root_scale(largest_in_column(c, (int)j));
  for (size_t j = 0; j < n; j++)
    for (size_t i = 0; i < n; i++) c->A[j * n + i] *= c->rhs[i] * c->cover[j];
  for (size_t i = 0; i < n; i++) {
    c->row[i] *= c->rhs[i];
    c->column[i] *= c->cover[i];
    c->b[i] *= c->rhs[i];
  }
}

/* Ruiz's equilibration (RAL-TR-2001-034), only where it is needed. */
static void scale(chain *c)
{
  int n = c->n, uneven = 0;
  for (int i = 0; i < n; i++) {
    memcpy(c->A + (size_t)i * (size_t)n, c->problem->A + (size_t)i * (size_t)c->problem->lda,
           (size_t)n * sizeof *c->A);
    c->row[i] = c->column[i] = 1;
  }
  memcpy(c->b, c->problem->b, (size_t)n * sizeof *c->b);
  for (int i = 0; i < n; i++) {
    double r = largest_in_row(c, i), s = largest_in_column(c, i);
    uneven |= r > 256 || r < 1.0 / 256 || s > 256 || s < 1.0 / 256;
  }
  for (int round = 0; uneven && round < 4; round++) scale_once(c);
}

/* x on the active set of basis: A_BB x_B = -b_B, all else zero. Returns 0, or 1 where singular. */
static int solve_basis(chain *c, const int *basis, double *x)
{
  int n = c->n, size = 0;
  for (int i = 0; i < n; i++)
    if (basis[i]) c->index[size++] = i;
  for (int j = 0; j < size; j++) {
    const double *from = c->A + (size_t)c->index[j] * (size_t)n;
    for (int i = 0; i < size; i++) c->lu[(size_t)j * (size_t)size + (size_t)i] = from[c->index[i]];
    c->rhs[j] = -c->b[c->index[j]];
  }
  if (nsdae_la_lu(size, c->lu, size, c->pivot) != 0) return 1;
  nsdae_la_lu_solve(size, c->lu, size, c->pivot, c->rhs);
  memset(x, 0, (size_t)n * sizeof *x);
  for (int j = 0; j < size; j++) x[c->index[j]] = fmax(c->rhs[j], 0) * c->column[c->index[j]];
  return 0;
}

/* Residual of c->x, in scaled rows and columns; c->y := A x + b. */
static double residual_of(chain *c)
{
  double residual;
  size_t n = (size_t)c->n;
  for (size_t i = 0; i < n; i++) c->rhs[i] = c->x[i] / c->column[i];
  nsdae_dlcpres(c->n, c->A, c->n, c->b, c->rhs, c->y, &residual, c->sizes);
  for (size_t i = 0; i < n; i++) c->y[i] /= c->row[i];
  return residual;
}

/* Judges the point c->x; keeps the best one. Returns whether it solves the problem. */
static int judge(chain *c, int stage)
{
  double residual = residual_of(c);
  if (!(residual < c->info->residual)) return 0;
  c->info->residual = residual;
  memcpy(c->best, c->x, (size_t)c->n * sizeof *c->best);
  if (residual > c->options->tol) return 0;
  c->info->outcome = NSDAE_LCP_SOLVED;
  c->info->stage = stage;
  return 1;
}

static int judge_basis(chain *c, const int *basis, int stage)
{
  if (solve_basis(c, basis, c->x) != 0 || !judge(c, stage)) return 0;
  for (int i = 0; i < c->n; i++) c->basis[i] = basis[i] && c->x[i] > 0;
  return 1;
}

static int trivial(chain *c)
{
  for (int i = 0; i < c->n; i++)
    if (c->b[i] < 0) return 0;
  memset(c->basis, 0, (size_t)c->n * sizeof *c->basis);
  memset(c->x, 0, (size_t)c->n * sizeof *c->x);
  return judge(c, NSDAE_LCP_TRIVIAL);
}

static int warm(chain *c)
{
  int any = 0;
  for (int i = 0; i < c->n; i++) any |= c->basis[i];
  return any && judge_basis(c, c->basis, NSDAE_LCP_WARM);
}

static int lemke_with(chain *c, const double *cover, int stage)
{
  int n = c->n, pivots = 0;
  int most = c->options->max_pivots > 0 ? c->options->max_pivots : 50 * n + 100;
  int info = nsdae_dlemke(n, c->A, n, c->b, cover, most, c->x, c->trial, &pivots, c->lemke,
                          lemke_size(n), c->index);
  c->info->pivots += pivots;
  if (info != 0) return 0;
  for (int i = 0; i < n; i++) c->x[i] *= c->column[i];
  if (judge(c, stage)) memcpy(c->basis, c->trial, (size_t)n * sizeof *c->basis);
  /* the basis solved at once has less rounding than a hundred pivots */
  if (c->info->outcome != NSDAE_LCP_SOLVED || pivots > n) judge_basis(c, c->trial, stage);
  return c->info->outcome == NSDAE_LCP_SOLVED;
}

static int lemke(chain *c)
{
  return lemke_with(c, NULL, NSDAE_LCP_LEMKE);
}

/* Entries in (0, 1] from a linear congruential generator (Knuth's MMIX). */
static void random_cover(chain *c, unsigned long long *seed)
{
  for (int i = 0; i < c->n; i++) {
    *seed = *seed * 6364136223846793005ull + 1442695040888963407ull;
    c->cover[i] = ((double)(*seed >> 40) + 1) / 16777216.0;
  }
}

static int coverings(chain *c)
{
  unsigned long long seed = 1;
  for (int k = 0; k < COVERINGS; k++) {
    random_cover(c, &seed);
    if (lemke_with(c, c->cover, NSDAE_LCP_COVERING)) return 1;
  }
  return 0;
}

/* Starts of the semismooth Newton method. */
enum { FURTHER_STARTS = 24, FURTHER_ITERATIONS = 60 };

/* Scaled x of the start of that number: zero, the size of b, then at random up to it. */
static void start_further(chain *c, int number, unsigned long long *seed, double *x)
{
  double most = 0;
  random_cover(c, seed);
  for (int i = 0; i < c->n; i++) most = fmax(most, fabs(c->b[i]));
  for (int i = 0; i < c->n; i++)
    x[i] = number == 0 ? 0 : number == 1 ? fmax(-c->b[i], 0) : most * c->cover[i];
}

/* What the iterate takes for positive, solved at once. */
static int judge_iterate(chain *c, const double *x, const double *y)
{
  for (int i = 0; i < c->n; i++) c->trial[i] = x[i] > y[i];
  return judge_basis(c, c->trial, NSDAE_LCP_FURTHER);
}

static int further(chain *c)
{
  unsigned long long seed = 7;
  double *x = c->scaled, *y = c->scaled + c->n;
  for (int k = 0; k < FURTHER_STARTS; k++) {
    start_further(c, k, &seed, x);
    nsdae_fischer(c->n, c->A, c->b, FURTHER_ITERATIONS, x, y, c->newton);
    if (judge_iterate(c, x, y)) return 1;
    for (int i = 0; i < c->n; i++) c->x[i] = fmax(x[i], 0) * c->column[i];
    if (!judge(c, NSDAE_LCP_FURTHER)) continue;
    for (int i = 0; i < c->n; i++) c->basis[i] = x[i] > y[i];
    return 1;
  }
  return 0;
}

static int enumerate(chain *c)
{
  if (c->n > c->options->enumerate_max) return 0;
  for (long set = 0; set < 1L << c->n; set++) {
    for (int i = 0; i < c->n; i++) c->trial[i] = (int)(set >> i & 1);
    if (judge_basis(c, c->trial, NSDAE_LCP_ENUMERATE)) return 1;
  }
  return 0;
}

static int run_chain(chain *c)
{
  static const struct {
    int stage;
    int (*run)(chain *);
  } all[] = {{NSDAE_LCP_TRIVIAL, trivial}, {NSDAE_LCP_WARM, warm},
             {NSDAE_LCP_LEMKE, lemke},     {NSDAE_LCP_COVERING, coverings},
             {NSDAE_LCP_FURTHER, further}, {NSDAE_LCP_ENUMERATE, enumerate}};
  for (size_t i = 0; i < sizeof all / sizeof *all; i++)
    if ((c->options->stages & all[i].stage) && all[i].run(c)) return NSDAE_OK;
  return NSDAE_E_LCP;
}

static int finite(const nsdae_lcp_problem *p)
{
  for (int j = 0; j < p->n; j++) {
    if (!isfinite(p->b[j])) return 0;
    for (int i = 0; i < p->n; i++)
      if (!isfinite(p->A[(size_t)j * (size_t)p->lda + (size_t)i])) return 0;
  }
  return 1;
}

void nsdae_lcp_options_default(nsdae_lcp_options *options)
{
  *options = (nsdae_lcp_options){.tol = 1e-10, .stages = 63, .enumerate_max = 12};
}

int nsdae_lcp_solve_in(const nsdae_lcp_problem *problem, const nsdae_lcp_options *options,
                       int *basis, double *x, double *y, nsdae_lcp_info *info, double *work,
                       int lwork, int *iwork, int liwork)
{
  (void)lwork;
  (void)liwork;
  chain c = {.problem = problem,
             .options = options,
             .info = info,
             .n = problem->n,
             .basis = basis,
             .x = x,
             .y = y};
  *info = (nsdae_lcp_info){.residual = INFINITY};
  if (!finite(problem)) return NSDAE_E_NONFINITE;
  lay_out(&c, work, iwork);
  scale(&c);
  int status = run_chain(&c);
  if (c.info->residual < INFINITY) memcpy(x, c.best, (size_t)c.n * sizeof *x);
  residual_of(&c);
  return status;
}
