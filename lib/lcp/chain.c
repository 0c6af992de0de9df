/* The solver: one stage after the other until the residual, computed afresh from A and b, is
 * below the tolerance. */
#include "chain.h"

#include <limits.h>
#include <math.h>
#include <nsdae/kernels.h>
#include <stddef.h>
#include <string.h>

#include "dictionary.h"
#include "equilibrate.h"
#include "fischer.h"
#include "judge.h"
#include "lemke.h"
#include "proof.h"
#include "ray.h"
#include "transform.h"

enum { COVERINGS = 12 };

/* Residual of a solution that cannot be better. */
static const double ROUNDING = 1e-15;

/* The workspace that nsdae_dlemke asks for. */
static int lemke_size(int n)
{
  return nsdae_dictionary_size(n, nsdae_lemke_block(n));
}

double nsdae_chain_size(int n)
{
  return 4.0 * n * n + 13.0 * n + lemke_size(n) + 1;
}

int nsdae_chain_sizes(int n, int *lwork, int *liwork)
{
  *lwork = (int)fmin(nsdae_chain_size(n) + (double)n * (n + 3), INT_MAX);
  *liwork = 11 * n + 1;
  return NSDAE_OK;
}

void nsdae_chain_lay_out(nsdae_chain *c, double *work, int *iwork)
{
  size_t n = (size_t)c->n;
  c->lemke_size = lemke_size(c->n);
  c->A = work;
  c->lu = c->A + n * n;
  c->wide = c->lu + n * n;
  c->b = c->wide + 2 * n * n + 4 * n;
  c->row = c->b + n;
  c->column = c->row + n;
  c->cover = c->column + n;
  c->best = c->cover + n;
  c->rhs = c->best + n;
  c->sizes = c->rhs + n;
  c->point = c->sizes + n;
  c->lemke = c->point + 2 * n;
  c->trial = iwork;
  c->pivot = c->trial + n;
  c->index = c->pivot + n;
  c->allowed = c->index + 2 * n + 1;
  c->label = iwork + 9 * n + 1; /* behind the basis and what an island works in */
  c->member = c->label + n;
}

void nsdae_chain_equilibrate(nsdae_chain *c)
{
  size_t n = (size_t)c->n;
  for (size_t j = 0; j < n; j++)
    memcpy(c->A + j * n, c->problem->A + j * (size_t)c->problem->lda, n * sizeof *c->A);
  for (size_t i = 0; i < n; i++) c->b[i] = c->problem->b[i];
  nsdae_equilibrate(c->n, c->A, c->b, c->row, c->column, c->point, c->index);
  double before = 0, after = 0;
  for (size_t i = 0; i < n; i++) {
    before = fmax(before, fabs(c->problem->b[i]));
    after = fmax(after, fabs(c->b[i]));
  }
  c->out_of_range = before > 0 && !(after > 0x1p-900 && after < 0x1p900);
}

static int trivial(nsdae_chain *c)
{
  for (int i = 0; i < c->n; i++)
    if (c->b[i] < 0) return 0;
  memset(c->trial, 0, (size_t)c->n * sizeof *c->trial);
  memset(c->x, 0, (size_t)c->n * sizeof *c->x);
  return nsdae_chain_judge(c, c->trial, NSDAE_LCP_TRIVIAL);
}

static int warm(nsdae_chain *c)
{
  int any = 0;
  for (int i = 0; i < c->n; i++) any |= c->basis[i];
  return any && nsdae_chain_judge_basis(c, c->basis, NSDAE_LCP_WARM);
}

/* Lemke's method; c->x and c->trial are its end. */
static int run_lemke(nsdae_chain *c, const double *cover, int *pivots)
{
  int n = c->n;
  int most = c->options->max_pivots > 0 ? c->options->max_pivots : 50 * n + 100;
  return nsdae_dlemke(n, c->A, n, c->b, cover, most, c->x, c->trial, pivots, c->lemke,
                      c->lemke_size, c->index);
}

static int lemke_with(nsdae_chain *c, const double *cover, int stage)
{
  int pivots = 0, info = run_lemke(c, cover, &pivots);
  c->info->pivots += pivots;
  if (!cover) c->ray = info == 1;
  if (info != 0) return 0;
  nsdae_chain_judge(c, c->trial, stage);
  /* the basis solved at once has less rounding than its pivots */
  if (!(c->info->residual < ROUNDING)) nsdae_chain_judge_basis(c, c->trial, stage);
  return nsdae_chain_is_settled(c);
}

static int lemke(nsdae_chain *c)
{
  return lemke_with(c, NULL, NSDAE_LCP_LEMKE);
}

/* The ray again, from which a later stage took the arrays. */
static void read_ray(nsdae_chain *c)
{
  int pivots;
  if (run_lemke(c, NULL, &pivots) == 1) nsdae_chain_read_ray(c);
}

/* Entries in (0, 1] from a linear congruential generator (Knuth's MMIX). */
static void random_cover(nsdae_chain *c, unsigned long long *seed)
{
  for (int i = 0; i < c->n; i++) {
    *seed = *seed * 6364136223846793005ull + 1442695040888963407ull;
    c->cover[i] = ((double)(*seed >> 40) + 1) / 16777216.0;
  }
}

static int coverings(nsdae_chain *c)
{
  unsigned long long seed = 1;
  for (int k = 0; k < COVERINGS; k++) {
    random_cover(c, &seed);
    if (lemke_with(c, c->cover, NSDAE_LCP_COVERING)) return 1;
  }
  return 0;
}

/* Starts of the semismooth Newton method. */
enum { FURTHER_STARTS = 24, FURTHER_EARLY = 4, FURTHER_ITERATIONS = 60, LARGE = 100 };

/* Scaled x of the start of that number: zero, the size of b, then at random up to it. */
static void start_further(nsdae_chain *c, int number, unsigned long long *seed, double *x)
{
  double most = 0;
  random_cover(c, seed);
  for (int i = 0; i < c->n; i++) most = fmax(most, fabs(c->b[i]));
  for (int i = 0; i < c->n; i++)
    x[i] = number == 0 ? 0 : number == 1 ? fmax(-c->b[i], 0) : most * c->cover[i];
}

/* Lemke's method from the active set in c->trial, which need not be right: on the problem in which
 * its x and y have changed places. */
static int lemke_from_trial(nsdae_chain *c)
{
  int n = c->n, pivots = 0;
  int most = c->options->max_pivots > 0 ? c->options->max_pivots : 50 * n + 100;
  int *set = c->allowed;
  double *T = c->wide, *t = c->point;
  memcpy(set, c->trial, (size_t)n * sizeof *set);
  if (nsdae_lcp_transform(n, c->A, c->b, set, T, t, T + (size_t)n * (size_t)n, c->pivot,
                          c->index) != 0)
    return 0;
  int info = nsdae_dlemke(n, T, n, t, NULL, most, c->x, c->trial, &pivots, c->lemke, c->lemke_size,
                          c->index);
  c->info->pivots += pivots;
  if (info != 0) return 0;
  for (int i = 0; i < n; i++) c->trial[i] = c->trial[i] != (set[i] != 0);
  return nsdae_chain_judge_basis(c, c->trial, NSDAE_LCP_FURTHER);
}

/* The iterate itself, and what it takes for positive, solved at once. */
static int judge_iterate(nsdae_chain *c, const double *x, const double *y)
{
  for (int i = 0; i < c->n; i++) c->trial[i] = x[i] > y[i];
  if (nsdae_chain_judge_basis(c, c->trial, NSDAE_LCP_FURTHER)) return 1;
  for (int i = 0; i < c->n; i++) c->x[i] = fmax(x[i], 0);
  return nsdae_chain_judge(c, c->trial, NSDAE_LCP_FURTHER);
}

/* The method from the starts first .. end - 1. */
static int further_from(nsdae_chain *c, int first, int end)
{
  unsigned long long seed = 7 + (unsigned long long)first;
  double *x = c->point, *y = c->point + c->n;
  for (int k = first; k < end; k++) {
    start_further(c, k, &seed, x);
    int memory = k % 2 == 0 ? 1 : NSDAE_FISCHER_MEMORY;
    nsdae_fischer(c->n, c->A, c->b, FURTHER_ITERATIONS, memory, x, y, c->wide);
    if (judge_iterate(c, x, y) || lemke_from_trial(c)) return 1;
  }
  return 0;
}

/* Of a large problem, the first starts before all that takes as many runs of Lemke's method. */
static int further_early(nsdae_chain *c)
{
  return c->n >= LARGE && further_from(c, 0, FURTHER_EARLY);
}

static int further(nsdae_chain *c)
{
  return further_from(c, c->n >= LARGE ? FURTHER_EARLY : 0, FURTHER_STARTS);
}

/* With a solution at hand, if a doubted one, there is nothing to be proved. */
static int prove(nsdae_chain *c)
{
  return c->info->outcome != NSDAE_LCP_SOLVED && nsdae_chain_prove(c);
}

static int enumerate(nsdae_chain *c)
{
  if (c->n > c->options->enumerate_max) return 0;
  if (c->info->outcome != NSDAE_LCP_SOLVED && nsdae_chain_prove_all(c)) return 1;
  for (long set = 0; set < 1L << c->n; set++) {
    for (int i = 0; i < c->n; i++) c->trial[i] = (int)(set >> i & 1);
    if (nsdae_chain_judge_basis(c, c->trial, NSDAE_LCP_ENUMERATE)) return 1;
  }
  return 0;
}

/* Every stage returns whether the chain ends with it: with a proof, or settled. */
static int run_stages(nsdae_chain *c)
{
  static const struct {
    int stage;
    int (*run)(nsdae_chain *);
  } all[] = {{NSDAE_LCP_TRIVIAL, trivial},    {NSDAE_LCP_WARM, warm},
             {NSDAE_LCP_LEMKE, lemke},        {NSDAE_LCP_FURTHER, further_early},
             {NSDAE_LCP_COVERING, coverings}, {NSDAE_LCP_PROVE, prove},
             {NSDAE_LCP_FURTHER, further},    {NSDAE_LCP_ENUMERATE, enumerate}};
  for (size_t i = 0; i < sizeof all / sizeof *all; i++)
    if ((c->options->stages & all[i].stage) && all[i].run(c)) break;
  if (c->info->outcome == NSDAE_LCP_SOLVED) return NSDAE_OK;
  return c->info->outcome == NSDAE_LCP_INFEASIBLE ? NSDAE_E_INFEASIBLE : NSDAE_E_LCP;
}

/* Rows and columns as the problem was given; y is that of x as it can be written. */
static void scale_back(nsdae_chain *c)
{
  int rounded = 0;
  double residual;
  for (int i = 0; i < c->n; i++) {
    double x = c->x[i] * c->column[i];
    rounded |= x / c->column[i] != c->x[i];
    c->rhs[i] = x / c->column[i];
  }
  if (rounded) nsdae_dlcpres(c->n, c->A, c->n, c->b, c->rhs, c->y, &residual, c->sizes);
  for (int i = 0; i < c->n; i++) {
    c->x[i] *= c->column[i];
    c->y[i] /= c->row[i];
  }
}

void nsdae_chain_hand_over(nsdae_chain *c)
{
  int found = c->info->residual < INFINITY, proof = c->info->proof == NSDAE_LCP_PROOF_FARKAS;
  if (c->info->outcome != NSDAE_LCP_SOLVED ||
      memcmp(c->x, c->best, (size_t)c->n * sizeof *c->x) != 0) { /* else y is that of x */
    for (int i = 0; i < c->n; i++) c->x[i] = found ? c->best[i] : 0;
    c->info->residual = nsdae_chain_residual(c);
  }
  scale_back(c);
  for (int i = 0; proof && i < c->n; i++) c->y[i] = c->point[i];
}

int nsdae_chain_run_whole(nsdae_chain *c)
{
  nsdae_chain_equilibrate(c);
  int status = run_stages(c);
  if (status != NSDAE_OK && c->ray && c->n <= NSDAE_RAY_MAX) read_ray(c);
  nsdae_chain_hand_over(c);
  return status;
}
