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

/* mu, or s mu where the direction is known. */
static double signed_mu(const nsdae_contacts *c, int j)
{
  return sense_of(c, j) < 0 ? -slide_of(c, j)->mu : slide_of(c, j)->mu;
}

int nsdae_slides_rows(const nsdae_contacts *c, int j)
{
  return sense_of(c, j) ? 1 : 3;
}

static int row_of(const nsdae_contacts *c, int j, int which)
{
  return c->slides.row[j] + which;
}

static int column_of(const nsdae_contacts *c, int j)
{
  return c->columns - c->slides.count + j;
}

/* ---- elimination */

/* Z_b: E_Q of the contacts, Lambda_T = Lambda_R - mu l+ of the frictional joints. */
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
    AT(c->map.Z, c->columns, column_of(c, j), row_of(c, j, L_PLUS)) = -signed_mu(c, j);
    if (!sense_of(c, j)) AT(c->map.Z, c->columns, column_of(c, j), row_of(c, j, LAMBDA_R)) = 1;
  }
}

/* Q = 1 - D_SS mu, K := S - D_S Z_b, k0 := -lambda_free. */
static void constraint_rows(nsdae_contacts *c, const double *lambda)
{
  int f = c->slides.count, m = c->part.m;
  for (int i = 0; i < f; i++) {
    for (int j = 0; j < c->columns; j++)
      AT(c->map.D_S, f, i, j) = AT(c->delassus.D, m, c->slides.constraint[i], j);
    for (int j = 0; j < f; j++)
      AT(c->map.Q, f, i, j) = (i == j) - AT(c->map.D_S, f, i, column_of(c, j)) * signed_mu(c, j);
    c->map.k0[i] = -lambda[c->slides.constraint[i]];
  }
  for (int j = 0; j < c->rows; j++)
    for (int i = 0; i < f; i++) {
      double sum = j == row_of(c, i, L_PLUS);
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

/* Z = Z_b - mu K, z0 = -mu k0 on the frictional joints; then G Z, and G z0 into the offsets. */
static void whole_map(nsdae_contacts *c)
{
  memset(c->map.z0, 0, (size_t)c->columns * sizeof *c->map.z0);
  for (int i = 0; i < c->slides.count; i++) {
    double mu = signed_mu(c, i);
    for (int j = 0; j < c->rows; j++)
      AT(c->map.Z, c->columns, column_of(c, i), j) -= mu * AT(c->map.K, c->slides.count, i, j);
    c->map.z0[column_of(c, i)] = -mu * c->map.k0[i];
  }
  /* G = W^T P W is symmetric */
  nsdae_la_multiply_transposed(c->columns, c->columns, c->rows, c->delassus.G, c->columns, c->map.Z,
                               c->columns, 0, c->map.GZ, c->columns);
  nsdae_la_multiply_transposed(c->columns, c->columns, 1, c->delassus.G, c->columns, c->map.z0,
                               c->columns, 1, c->delassus.offset, c->columns);
}

/* ---- rows of the problem */

static void contact_rows(nsdae_contacts *c, int a)
{
  const nsdae_law *law = &c->law[a];
  int row = c->first_row[a], column = c->first_column[a];
  for (int j = 0; j < c->rows; j++)
    nsdae_law_velocity(law, &AT(c->map.GZ, c->columns, column, j), &AT(c->lcp.A, c->rows, row, j));
  nsdae_law_velocity(law, c->delassus.offset + column, c->lcp.b + row);
  nsdae_law_add_coupling(law, c->lcp.A + (size_t)row * (size_t)c->rows + row, c->rows);
}

static void slide_rows(nsdae_contacts *c, int i)
{
  int row = row_of(c, i, 0), column = column_of(c, i);
  double mu = slide_of(c, i)->mu;
  c->lcp.b[row + L_PLUS] = c->map.k0[i];
  for (int j = 0; j < c->rows; j++) {
    double K = AT(c->map.K, c->slides.count, i, j);
    AT(c->lcp.A, c->rows, row + L_PLUS, j) = K;
    if (sense_of(c, i)) continue;
    AT(c->lcp.A, c->rows, row + LAMBDA_R, j) =
        AT(c->map.GZ, c->columns, column, j) + (j == row + XI_L);
    AT(c->lcp.A, c->rows, row + XI_L, j) =
        2 * mu * ((j == row + L_PLUS) + K) - (j == row + LAMBDA_R);
  }
  if (sense_of(c, i)) return;
  c->lcp.b[row + LAMBDA_R] = c->delassus.offset[column];
  c->lcp.b[row + XI_L] = 2 * mu * c->map.k0[i];
}

int nsdae_slides_assemble(nsdae_contacts *c, const double *lambda)
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

/* Lambda = Z x + z0. */
void nsdae_slides_scatter(nsdae_contacts *c)
{
  for (int i = 0; i < c->slides.count; i++) {
    int row = row_of(c, i, 0), column = column_of(c, i);
    double sum = c->map.z0[column], size = fabs(c->map.z0[column]);
    for (int j = 0; j < c->rows; j++) {
      double term = AT(c->map.Z, c->columns, column, j) * c->lcp.x[j];
      sum += term;
      size += fabs(term);
    }
    c->delassus.impulse_size[column] = size;
    int sticking = !sense_of(c, i) && c->lcp.x[row + LAMBDA_R] > 0 && c->lcp.x[row + XI_L] == 0;
    c->delassus.impulse[column] = sum;
    c->results->frictional_joint_impulse[c->slides.number[i]] = sum;
    c->results->frictional_joint_mode[c->slides.number[i]] =
        sticking ? NSDAE_MODE_STICK : NSDAE_MODE_SLIP;
  }
}
