#include "slides.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "dense.h"
#include "system_impl.h"

#define AT(A, ld, i, j) (A)[(size_t)(j) * (size_t)(ld) + (size_t)(i)]

enum { L_PLUS = 0, LAMBDA_R = 1, XI_L = 2 }; /* rows of a frictional joint */

/* ---- frictional joints */

static const nsdae_frictional_joint *slide_of(const nsdae_contacts *c, int j)
{
  return &c->system->frictional_joint[c->slides.number[j]];
}

/* The known direction of sliding, +1 or -1; 0: not known. */
static int sense_of(const nsdae_contacts *c, int j)
{
  return c->slides.sense ? c->slides.sense[c->slides.number[j]] : 0;
}

/* mu and the bound, or s times these where the direction is known. */
static double signed_mu(const nsdae_contacts *c, int j)
{
  return sense_of(c, j) < 0 ? -slide_of(c, j)->mu : slide_of(c, j)->mu;
}

static double signed_limit(const nsdae_contacts *c, int j)
{
  return sense_of(c, j) < 0 ? -c->slides.limit[j] : c->slides.limit[j];
}

/* Whether a multiplier adds to its bound: then it has a row l+. */
static int loaded(const nsdae_contacts *c, int j)
{
  return slide_of(c, j)->mu > 0;
}

int nsdae_slides_rows(const nsdae_contacts *c, int j)
{
  return (loaded(c, j) ? 1 : 0) + (sense_of(c, j) ? 0 : 2);
}

static int row_of(const nsdae_contacts *c, int j, int which)
{
  return c->slides.row[j] + which - (loaded(c, j) ? 0 : 1);
}

static int column_of(const nsdae_contacts *c, int j)
{
  return c->columns - c->slides.count + j;
}

/* ---- elimination */

/* Z_b: E_Q of the contacts, Lambda_T = Lambda_R - mu l+ (- b) of the frictional joints. */
static void basic_map(nsdae_contacts *c)
{
  memset(c->map.Z, 0, (size_t)c->columns * (size_t)c->rows * sizeof *c->map.Z);
  for (int a = 0; a < c->active_count; a++) {
    const nsdae_law *law = &c->law[a];
    for (int l = 0; l < law->columns; l++) {
      double unit[NSDAE_LAW_COLUMNS] = {l == 0, l == 1, l == 2}, row[NSDAE_LAW_ROWS];
      nsdae_law_times_impulse(law, unit, 1, row);
      for (int j = 0; j < law->rows; j++)
        AT(c->map.Z, c->columns, c->first_column[a] + l, c->first_row[a] + j) = row[j];
    }
  }
  for (int j = 0; j < c->slides.count; j++) {
    if (loaded(c, j))
      AT(c->map.Z, c->columns, column_of(c, j), row_of(c, j, L_PLUS)) = -signed_mu(c, j);
    if (!sense_of(c, j)) AT(c->map.Z, c->columns, column_of(c, j), row_of(c, j, LAMBDA_R)) = 1;
  }
}

/* Q = 1 - D_SS mu, K := S - D_S Z_b, k0 := D_S b - lambda_free; of mu = 0: Q = 1, K = k0 = 0. */
static void constraint_rows(nsdae_contacts *c, const double *lambda)
{
  int f = c->slides.count, m = c->part.m;
  for (int i = 0; i < f; i++) {
    for (int j = 0; j < c->columns; j++)
      AT(c->map.D_S, f, i, j) = loaded(c, i) ? AT(c->delassus.D, m, c->slides.constraint[i], j) : 0;
    c->map.k0[i] = loaded(c, i) ? -lambda[c->slides.constraint[i]] : 0;
    for (int j = 0; j < f; j++) {
      double D = AT(c->map.D_S, f, i, column_of(c, j));
      AT(c->map.Q, f, i, j) = (i == j) - D * signed_mu(c, j);
      c->map.k0[i] += D * signed_limit(c, j);
    }
  }
  for (int j = 0; j < c->rows; j++)
    for (int i = 0; i < f; i++) {
      double sum = loaded(c, i) && j == row_of(c, i, L_PLUS);
      for (int l = 0; l < c->columns; l++)
        sum -= AT(c->map.D_S, f, i, l) * AT(c->map.Z, c->columns, l, j);
      AT(c->map.K, f, i, j) = sum;
    }
}

/* Q^-1 on K and k0. */
static int eliminate(nsdae_contacts *c)
{
  int f = c->slides.count;
  double largest = 0;
  for (size_t i = 0; i < (size_t)f * (size_t)f; i++) largest = fmax(largest, fabs(c->map.Q[i]));
  if (nsdae_la_lu(f, c->map.Q, f, c->map.pivot) != 0) return NSDAE_E_LCP;
  for (int i = 0; i < f; i++)
    if (!(fabs(AT(c->map.Q, f, i, i)) > f * 8 * DBL_EPSILON * fmax(largest, 1))) return NSDAE_E_LCP;
  for (int j = 0; j < c->rows; j++)
    nsdae_la_lu_solve(f, c->map.Q, f, c->map.pivot, c->map.K + (size_t)j * (size_t)f);
  nsdae_la_lu_solve(f, c->map.Q, f, c->map.pivot, c->map.k0);
  return NSDAE_OK;
}

/* Z = Z_b - mu K, z0 = -mu k0 - b on the frictional joints; then G Z, and the offsets + G z0. */
static void whole_map(nsdae_contacts *c)
{
  memset(c->map.z0, 0, (size_t)c->columns * sizeof *c->map.z0);
  for (int i = 0; i < c->slides.count; i++) {
    double mu = signed_mu(c, i);
    for (int j = 0; j < c->rows; j++)
      AT(c->map.Z, c->columns, column_of(c, i), j) -= mu * AT(c->map.K, c->slides.count, i, j);
    c->map.z0[column_of(c, i)] = -mu * c->map.k0[i] - signed_limit(c, i);
  }
  memcpy(c->map.offset, c->delassus.offset, (size_t)c->columns * sizeof *c->map.offset);
  /* G = W^T P W is symmetric */
  nsdae_la_multiply_transposed(c->columns, c->columns, c->rows, 1, c->delassus.G, c->columns,
                               c->map.Z, c->columns, 0, c->map.GZ, c->columns);
  nsdae_la_multiply_transposed(c->columns, c->columns, 1, 1, c->delassus.G, c->columns, c->map.z0,
                               c->columns, 1, c->map.offset, c->columns);
}

/* ---- rows of the problem */

static void contact_rows(nsdae_contacts *c, int a)
{
  const nsdae_law *law = &c->law[a];
  int row = c->first_row[a], column = c->first_column[a];
  for (int j = 0; j < c->rows; j++)
    nsdae_law_velocity(law, &AT(c->map.GZ, c->columns, column, j), &AT(c->lcp.A, c->rows, row, j));
  nsdae_law_velocity(law, c->map.offset + column, c->lcp.b + row);
  nsdae_law_add_coupling(law, c->lcp.A + (size_t)row * (size_t)c->rows + row, c->rows);
}

static void slide_rows(nsdae_contacts *c, int i)
{
  int row = row_of(c, i, 0), column = column_of(c, i), load = loaded(c, i);
  double mu = slide_of(c, i)->mu;
  if (load) c->lcp.b[row + L_PLUS] = c->map.k0[i];
  for (int j = 0; j < c->rows; j++) {
    double K = AT(c->map.K, c->slides.count, i, j);
    if (load) AT(c->lcp.A, c->rows, row + L_PLUS, j) = K;
    if (sense_of(c, i)) continue;
    AT(c->lcp.A, c->rows, row + LAMBDA_R, j) =
        AT(c->map.GZ, c->columns, column, j) + (j == row + XI_L);
    AT(c->lcp.A, c->rows, row + XI_L, j) =
        2 * mu * ((load && j == row + L_PLUS) + K) - (j == row + LAMBDA_R);
  }
  if (sense_of(c, i)) return;
  c->lcp.b[row + LAMBDA_R] = c->map.offset[column];
  c->lcp.b[row + XI_L] = 2 * (mu * c->map.k0[i] + c->slides.limit[i]);
}

static int assemble(nsdae_contacts *c, const double *lambda)
{
  basic_map(c);
  constraint_rows(c, lambda);
  int status = eliminate(c);
  if (status < 0) return status;
  whole_map(c);
  for (int a = 0; a < c->active_count; a++) contact_rows(c, a);
  for (int i = 0; i < c->slides.count; i++) slide_rows(c, i);
  return NSDAE_OK;
}

/* ---- solution */

/* The limits of the problem: the bounds, at most this many times the impulse that stops the fastest
 * column. Returns how many are less than their bounds. */
static int set_limits(nsdae_contacts *c, double times)
{
  double fastest = nsdae_largest(c->columns, c->delassus.offset);
  int less = 0;
  /* where a motor has its speed, offsets are rounding, to be left within the tolerance */
  fastest = fmax(fastest, 32 * DBL_EPSILON * c->slides.terms / c->lcp.options.tol);
  c->slides.fastest = fastest;
  for (int j = 0; j < c->slides.count; j++) {
    int column = column_of(c, j);
    double bound = nsdae_slides_bound(c, j);
    double most = times * fastest / AT(c->delassus.G, c->columns, column, column);
    c->slides.limit[j] = nsdae_slides_limit(bound, most);
    less += c->slides.limit[j] < bound;
  }
  return less;
}

static double impulse_of(const nsdae_contacts *c, int i, double *size)
{
  double sum = c->map.z0[column_of(c, i)];
  *size = fabs(sum);
  for (int j = 0; j < c->rows; j++) {
    double term = AT(c->map.Z, c->columns, column_of(c, i), j) * c->lcp.x[j];
    sum += term;
    *size += fabs(term);
  }
  return sum;
}

/* Whether an impulse is at a limit that is less than its bound. */
static int reaches_limit(const nsdae_contacts *c)
{
  for (int j = 0; j < c->slides.count; j++) {
    double limit = c->slides.limit[j];
    if (limit < nsdae_slides_bound(c, j) &&
        fabs(c->delassus.impulse[column_of(c, j)]) > NSDAE_AT_BOUND * limit)
      return 1;
  }
  return 0;
}

int nsdae_slides_limited(nsdae_contacts *c, const double *lambda, double times,
                         nsdae_slides_solver *solve)
{
  for (;; times *= NSDAE_BOUND_FURTHER) {
    int less = set_limits(c, times), status = solve(c, lambda);
    if (!less || (status == NSDAE_OK && !reaches_limit(c))) return status;
  }
}

int nsdae_slides_loaded(const nsdae_contacts *c)
{
  int count = 0;
  for (int j = 0; j < c->slides.count; j++) count += loaded(c, j);
  return count;
}

/* Lambda = Z x + z0. */
static void scatter(nsdae_contacts *c)
{
  for (int i = 0; i < c->slides.count; i++) {
    int row = row_of(c, i, 0), column = column_of(c, i);
    double sum = impulse_of(c, i, &c->delassus.impulse_size[column]);
    int sticking = !sense_of(c, i) && c->lcp.x[row + LAMBDA_R] > 0 && c->lcp.x[row + XI_L] == 0;
    c->delassus.impulse[column] = sum;
    c->results->frictional_joint_impulse[c->slides.number[i]] =
        sum * nsdae_slides_beside(c, i).scale;
    c->results->frictional_joint_mode[c->slides.number[i]] =
        sticking ? NSDAE_MODE_STICK : NSDAE_MODE_SLIP;
  }
}

static int solve_lcp(nsdae_contacts *c, const double *lambda)
{
  int status = assemble(c, lambda);
  /* all may slide in known directions */
  if (status == NSDAE_OK && c->rows > 0) status = nsdae_contacts_solve_lcp(c);
  if (status == NSDAE_OK) scatter(c);
  return status;
}

int nsdae_slides_solve(nsdae_contacts *c, const double *lambda)
{
  return nsdae_slides_limited(c, lambda, NSDAE_BOUND_FIRST, solve_lcp);
}
