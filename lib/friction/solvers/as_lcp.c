/* A small island whose contacts are frictionless or planar is a linear complementarity problem, and
 * pivoting solves that exactly. With r_T = a - b, a, b >= 0 and l = |u_T| a planar contact is
 *
 *   u_N >= 0,  u_T + l >= 0,  l - u_T >= 0,  mu r_N - a - b >= 0,
 *
 * each complementary to r_N, a, b, l (Stewart and Trinkle, Int. J. Numer. Methods Eng. 39 (1996)
 * 2673), a frictionless one u_N alone. Bilateral rows B are eliminated before, W_BB = L L^T:
 *
 *   X = L^-1 [W_BI q_B],   W_II - X_I^T X_I,   q_I - X_I^T X_q,   r_B = -L^-T (X_I r_I + X_q) */
#include "solver_contract.h"

#include <nsdae/lcp.h>
#include <string.h>

#include "cone.h"
#include "dense.h"
#include "vector.h"

/* Unknowns up to which pivoting costs no more than the sweeps that it saves. */
enum { LARGEST = 48 };

/* Room goes with the number of items, not with what they are: a solver that has memory for their
 * number has it for these. */
void nsdae_fc_as_lcp_layout(nsdae_fc_as_lcp *s, const nsdae_fc_scaled *fc, nsdae_arena *arena)
{
  int n = 4 * fc->n < LARGEST ? 4 * fc->n : LARGEST,
      m = 2 * fc->n < 2 * LARGEST ? 2 * fc->n : 2 * LARGEST;
  const nsdae_friction_problem *p = fc->global->view.p;
  int fits = 1; /* all cones are polyhedra, and there are few unknowns */
  s->m = s->bilateral = s->n = 0;
  for (int k = 0; k < fc->n && fits; k++) {
    int i = nsdae_fc_member(fc, k), rows = nsdae_fc_rows(p, i), one = rows == 2 ? 4 : -1;
    if (i >= p->contacts)
      one = 0;
    else if (rows == 1 || p->mu[i] == 0)
      one = 1;
    s->bilateral += one == 0;
    s->m += one == 4 ? 2 : 1;
    s->n += one;
    fits = one >= 0 && s->n <= LARGEST && s->bilateral <= LARGEST;
  }
  if (!fits) s->n = s->m = 0;
  nsdae_lcp_workspace(n, &s->lwork, &s->liwork);
  s->row = NSDAE_ARENA_INTS(arena, m);
  s->W = NSDAE_ARENA_DOUBLES(arena, m * (m + 1L));
  s->A = NSDAE_ARENA_DOUBLES(arena, (long)n * n);
  nsdae_arena_doubles(arena, n, (double **[]){&s->b, &s->x, &s->y, NULL});
  s->basis = NSDAE_ARENA_INTS(arena, n);
  s->work = NSDAE_ARENA_DOUBLES(arena, s->lwork);
  s->iwork = NSDAE_ARENA_INTS(arena, s->liwork);
}

/* ---- W of the rows */

/* Of the rows that take part, the bilateral ones first. Column by column: y := J e of that row, and
 * its velocities; in the local form y is the column. */
static void fill_W(nsdae_fc_as_lcp *s, const nsdae_fc_scaled *fc, double *y)
{
  const nsdae_fc_parts *parts = &fc->parts;
  int at = 0;
  for (int k = 0; k < fc->n; k++)
    if (fc->items.kind[k] == NSDAE_FC_BILATERAL) s->row[at++] = 3 * k;
  for (int k = 0; k < fc->n; k++) {
    if (fc->items.kind[k] != NSDAE_FC_BILATERAL) s->row[at++] = 3 * k;
    if (fc->items.kind[k] == NSDAE_FC_CONE) s->row[at++] = 3 * k + 1;
  }
  for (int j = 0; j < s->m; j++) {
    double *column = s->W + (size_t)j * (size_t)s->m;
    int from = s->row[j];
    memset(y, 0, (size_t)fc->ny * sizeof *y);
    for (int e = parts->first[from / 3]; e < parts->first[from / 3 + 1]; e++) {
      int n = parts->size[parts->block[e]];
      memcpy(y + parts->offset[parts->block[e]], nsdae_fc_part(fc, e) + from % 3 * n,
             (size_t)n * sizeof *y);
    }
    for (int i = 0; i < s->m; i++) {
      int row = s->row[i];
      column[i] = fc->local ? y[row] : 0;
      for (int e = parts->first[row / 3]; e < parts->first[row / 3 + 1] && !fc->local; e++) {
        int n = parts->size[parts->block[e]];
        column[i] +=
            nsdae_dot(n, nsdae_fc_part(fc, e) + row % 3 * n, y + parts->offset[parts->block[e]]);
      }
    }
    column[j] += fc->items.C[s->row[j]];
    s->W[(size_t)s->m * (size_t)s->m + (size_t)j] = fc->items.q[s->row[j]];
  }
}

/* W without the bilateral rows, X above it; 1 if those depend on each other. */
static int eliminate(nsdae_fc_as_lcp *s)
{
  size_t m = (size_t)s->m, nb = (size_t)s->bilateral;
  if (nb == 0) return 0;
  if (nsdae_la_cholesky((int)nb, s->W, s->m) != 0) return 1;
  nsdae_la_solve_lower((int)nb, (int)(m + 1 - nb), s->W, s->m, s->W + nb * m, s->m);
  for (size_t j = nb; j <= m; j++)
    for (size_t i = nb; i < m; i++)
      s->W[j * m + i] -= nsdae_dot((int)nb, s->W + i * m, s->W + j * m);
  return 0;
}

/* ---- the LCP */

/* Unknown z of the problem takes part in the velocity of row i of W as W's column j, with a sign.
 */
static void put(nsdae_fc_as_lcp *s, int unknown, int j, double sign)
{
  const double *column = s->W + (size_t)j * (size_t)s->m;
  double *A = s->A + (size_t)unknown * (size_t)s->n;
  for (int i = s->bilateral, row = 0; i < s->m; i++, row++) {
    A[row] += sign * column[i];
    if (i + 1 == s->m || s->row[i + 1] != s->row[i] + 1) continue; /* no tangential row follows */
    i++;
    A[++row] += sign * column[i];
    A[++row] -= sign * column[i];
    row++;
  }
}

/* A and b, contact by contact. */
static void fill_problem(nsdae_fc_as_lcp *s, const nsdae_fc_scaled *fc)
{
  const double *q = s->W + (size_t)s->m * (size_t)s->m;
  size_t n = (size_t)s->n, at = 0;
  memset(s->A, 0, n * n * sizeof *s->A);
  memset(s->b, 0, n * sizeof *s->b);
  for (int j = s->bilateral; j < s->m; j++) {
    int k = s->row[j] / 3;
    s->b[at] = q[j];
    put(s, (int)at, j, 1);
    if (fc->items.kind[k] != NSDAE_FC_CONE) {
      at++;
      continue;
    }
    j++;
    s->b[at + 1] = q[j];
    s->b[at + 2] = -q[j];
    put(s, (int)at + 1, j, 1);
    put(s, (int)at + 2, j, -1);
    s->A[at * n + at + 3] = fc->items.mu[k];
    s->A[(at + 1) * n + at + 3] = s->A[(at + 2) * n + at + 3] = -1;
    s->A[(at + 3) * n + at + 1] = s->A[(at + 3) * n + at + 2] = 1;
    at += 4;
  }
}

/* ---- solution */

int nsdae_fc_lcp(nsdae_fc_island *island, nsdae_fc_iterate *it, const nsdae_fc_budget *b)
{
  nsdae_fc_as_lcp *s = &island->as_lcp;
  nsdae_fc_scaled *fc = &island->fc;
  if (s->m == 0 || !nsdae_fc_spend(island, it, b, s->m)) return it->residual <= b->tol;
  fill_W(s, fc, island->newton.y);
  if (eliminate(s) != 0) return it->residual <= b->tol;
  fill_problem(s, fc);
  nsdae_lcp_options options;
  nsdae_lcp_options_default(&options);
  options.tol = b->tol;
  options.stages = NSDAE_LCP_TRIVIAL | NSDAE_LCP_LEMKE | NSDAE_LCP_COVERING;
  memset(s->basis, 0, (size_t)s->n * sizeof *s->basis);
  const nsdae_lcp_problem problem = {.n = s->n, .A = s->A, .lda = s->n > 0 ? s->n : 1, .b = s->b};
  if (nsdae_lcp_solve_in(&problem, &options, s->basis, s->x, s->y, NULL, s->work, s->lwork,
                         s->iwork, s->liwork) != NSDAE_OK)
    return it->residual <= b->tol;
  /* r of the unknowns; those of the bilateral rows from X. */
  size_t m = (size_t)s->m, nb = (size_t)s->bilateral, at = 0;
  double *X = s->W + m * m; /* becomes r_B */
  memset(fc->r, 0, nsdae_fc_bytes(island));
  for (size_t j = nb; j < m; j++) {
    int row = s->row[j], cone = fc->items.kind[row / 3] == NSDAE_FC_CONE;
    fc->r[row] = row % 3 == 0 ? s->x[at] : s->x[at + 1] - s->x[at + 2];
    at += !cone ? 1 : row % 3 == 0 ? 0 : 4;
    for (size_t i = 0; i < nb; i++) X[i] += s->W[j * m + i] * fc->r[row];
  }
  if (nb > 0) nsdae_la_solve_lower_transposed((int)nb, 1, s->W, s->m, X, s->m);
  for (size_t i = 0; i < nb; i++) fc->r[s->row[i]] = -X[i];
  nsdae_fc_set_point(island, fc->r);
  nsdae_fc_offer(island, it);
  return it->residual <= b->tol;
}
