#include "acceleration.h"

#include <math.h>
#include <string.h>

#include "dense.h"
#include "errors.h"
#include "system_impl.h"

static const double margins[] = {1e-10, 1e-3};

static const char without_bound[] = "an unbounded contact force";

/* Of a contact or a slide. */
static int tell(const nsdae_contacts *c, int kind, int item, double t, const char *what,
                double coefficient)
{
  char called[NSDAE_CALLED_SIZE];
  t = nsdae_system_time(c->system, t);
  nsdae_error_set(c->error, NSDAE_E_PAINLEVE, "nsdae_event", "mu",
                  "%s has %s at t = %.17g (Painleve's paradox: friction increases the normal "
                  "force, coefficient %.3g): reduce mu, or use method = implicit (impulses)",
                  nsdae_system_called(c->system, kind, item, called), what, t, coefficient);
  c->error->index = nsdae_system_index(c->system, kind, item);
  c->error->time = t;
  return NSDAE_E_PAINLEVE;
}

/* Of the solved complementarity problem: what a unit of the force in that row gives of y there,
 * with all else that presses held; 0 where that is singular. It works in what the solver worked in.
 */
static double yield_of(const nsdae_contacts *c, int row)
{
  const nsdae_contact_lcp *lcp = &c->lcp;
  int n = c->rows, count = 0, *pressed = lcp->iwork, *pivot = pressed + n;
  double *A = lcp->work, *unit = A + (size_t)n * (size_t)n;
  if (lcp->liwork < 2 * n || lcp->lwork < n * (n + 1)) return INFINITY; /* no reason to doubt it */
  for (int i = 0; i < n; i++)
    if (i == row || lcp->x[i] > lcp->y[i]) pressed[count++] = i;
  for (int j = 0; j < count; j++) {
    unit[j] = pressed[j] == row;
    for (int i = 0; i < count; i++)
      A[(size_t)j * (size_t)count + (size_t)i] =
          lcp->A[(size_t)pressed[j] * (size_t)n + (size_t)pressed[i]];
  }
  if (nsdae_la_lu(count, A, count, pivot) != 0) return 0;
  nsdae_la_lu_solve(count, A, count, pivot, unit);
  for (int i = 0; i < count; i++)
    if (pressed[i] == row && unit[i] != 0) return 1 / unit[i];
  return INFINITY;
}

/* Whether the solved problem has another solution with x_i = 0 and y_i > 0 for i = row: one of
 * the problem without this row and column, here y_i = x_i + 1. */
static int has_open_solution(const nsdae_contacts *c, int row)
{
  const nsdae_contact_lcp *lcp = &c->lcp;
  size_t n = (size_t)c->rows, i = (size_t)row;
  double *A = lcp->A, *along = lcp->other, *down = along + n, *x = down + n, *y = x + n;
  double b = lcp->b[i], size = nsdae_largest(c->rows, lcp->b);
  const nsdae_lcp_problem problem = {.n = c->rows, .A = A, .lda = c->rows, .b = lcp->b};
  nsdae_lcp_info info;
  memcpy(down, A + i * n, n * sizeof *A);
  memset(A + i * n, 0, n * sizeof *A);
  for (size_t j = 0; j < n; j++) along[j] = j == i ? down[i] : A[j * n + i], A[j * n + i] = j == i;
  lcp->b[i] = 1;
  memset(x, 0, n * sizeof *x);
  memset(lcp->basis, 0, n * sizeof *lcp->basis);
  int status = nsdae_lcp_solve_in(&problem, &lcp->options, lcp->basis, x, y, &info, lcp->work,
                                  lcp->lwork, lcp->iwork, lcp->liwork);
  for (size_t j = 0; j < n; j++) A[j * n + i] = along[j];
  memcpy(A + i * n, down, n * sizeof *A);
  lcp->b[i] = b;
  return status == NSDAE_OK && b + nsdae_dot(c->rows, along, x) > lcp->options.tol * size;
}

/* Of the j-th slide of the problem: 1 - |D_SS mu|, of what a unit of its multiplier calls for in
 * friction, and that in turn of its multiplier: see slides.h. Up to 0 a slide of known direction
 * has no multiplier, or two. */
static double slide_coefficient(const nsdae_contacts *c, int j)
{
  size_t f = (size_t)c->slides.count, column = (size_t)c->columns - f + (size_t)j;
  return 1 - fabs(c->map.D_S[column * f + (size_t)j] *
                  c->system->frictional_joint[c->slides.number[j]].mu);
}

static int slides(const nsdae_contacts *c, int j)
{
  return c->slides.sense && c->slides.sense[c->slides.number[j]];
}

int nsdae_painleve_twofold(const nsdae_contacts *c, int j)
{
  double coefficient = slides(c, j) ? slide_coefficient(c, j) : 1;
  return coefficient < -margins[NSDAE_PAINLEVE_EXACT] && !(yield_of(c, c->slides.row[j]) > 0);
}

/* The slide that feeds its own multiplier most is to blame. */
static int judge_slides(const nsdae_contacts *c, int status, nsdae_painleve_margin margin, double t)
{
  int unsolved = status == NSDAE_E_LCP || status == NSDAE_E_INFEASIBLE, worst = -1;
  for (int j = 0; j < c->slides.count; j++)
    if (slides(c, j) && (worst < 0 || slide_coefficient(c, j) < slide_coefficient(c, worst)))
      worst = j;
  if (worst < 0) return status;
  double coefficient = slide_coefficient(c, worst);
  int near = fabs(coefficient) <= margins[margin];
  if (unsolved ? coefficient > margins[margin] : margin == NSDAE_PAINLEVE_EXACT || !near)
    return status;
  return tell(c, NSDAE_NAME_FRICTIONAL_JOINT, c->slides.number[worst], t,
              near ? without_bound : "no friction force that solves the equations", coefficient);
}

int nsdae_painleve_judge(const nsdae_contacts *c, int status, int by_rows,
                         nsdae_painleve_margin margin, double t)
{
  int unsolved = status == NSDAE_E_LCP || status == NSDAE_E_INFEASIBLE;
  for (int a = 0; a < c->active_count; a++) {
    int row = c->first_row[a];
    double coefficient = c->lcp.A[(size_t)row * (size_t)c->rows + (size_t)row];
    double least =
        margins[margin] * c->delassus.G[(size_t)c->first_column[a] * (size_t)(c->columns + 1)];
    if (c->law[a].kind != NSDAE_SLIDING || (coefficient > least && !unsolved)) continue;
    if (status == NSDAE_OK && by_rows && yield_of(c, row) > least) continue;
    if (status == NSDAE_OK && margin == NSDAE_PAINLEVE_EXACT && !has_open_solution(c, row))
      continue;
    return tell(c, NSDAE_NAME_CONTACT, c->active[a], t,
                margin == NSDAE_PAINLEVE_NEAR ? without_bound
                : unsolved                    ? "no contact force that solves the equations"
                                              : "two solutions",
                coefficient);
  }
  return judge_slides(c, status, margin, t);
}

int nsdae_painleve_unbounded(const nsdae_contacts *c, int contact, double t, double coefficient)
{
  return tell(c, NSDAE_NAME_CONTACT, contact, t, without_bound, coefficient);
}
