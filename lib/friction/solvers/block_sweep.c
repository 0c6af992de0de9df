/* One sweep of nonlinear block Gauss-Seidel: each contact in turn is solved exactly (one_contact.c)
 * with the velocities u = J y + q of the impulses found so far. */
#include "anderson.h"

#include <math.h>
#include <string.h>

#include "cone.h"
#include "one_contact.h"
#include "simd.h"
#include "vector.h"

/* Its square is a normal number. */
static const double TINY = 1e-150;

enum { BODY = 6 }; /* the size of most blocks: its loops are laid out flat */

/* ---- products with parts of J */

/* u += J^T y of one part, [n x 3] column-major. */
static inline void gather_part(int n, const double *J, const double *y, double *u)
{
  double a = 0, b = 0, d = 0;
  for (int l = 0; l < n; l++) {
    a += J[l] * y[l];
    b += J[n + l] * y[l];
    d += J[2 * n + l] * y[l];
  }
  u[0] += a, u[1] += b, u[2] += d;
}

/* The same of a body: sums of every other term. */
static inline void gather_body(const double *J, const double *y, double *u)
{
  nsdae_pair y0 = nsdae_pair_of(y), y2 = nsdae_pair_of(y + 2), y4 = nsdae_pair_of(y + 4);
  for (int j = 0; j < 3; j++, J += BODY) {
    nsdae_pair sum = nsdae_pair_of(J) * y0 + nsdae_pair_of(J + 2) * y2 + nsdae_pair_of(J + 4) * y4;
    u[j] += sum[0] + sum[1];
  }
}

/* y += J dr of one part */
static inline void apply_part(int n, const double *restrict J, const double *restrict dr,
                              double *restrict y)
{
  for (int l = 0; l < n; l++) y[l] += J[l] * dr[0] + J[n + l] * dr[1] + J[2 * n + l] * dr[2];
}

/* u = J^T y + q + C r of item k */
static inline void gather_block(const nsdae_fc_scaled *c, int k, double *u)
{
  const double *r = c->r + 3 * k;
  for (int j = 0; j < 3; j++) u[j] = c->items.q[3 * k + j] + c->items.C[3 * k + j] * r[j];
  for (int e = c->parts.first[k]; e < c->parts.first[k + 1]; e++) {
    const double *J = nsdae_fc_part(c, e), *y = c->y + c->parts.offset[c->parts.block[e]];
    int n = c->parts.size[c->parts.block[e]];
    if (n == BODY)
      gather_body(J, y, u);
    else
      gather_part(n, J, y, u);
  }
}

/* y += J dr of item k */
static inline void add_parts(nsdae_fc_scaled *c, int k, const double *dr)
{
  for (int e = c->parts.first[k]; e < c->parts.first[k + 1]; e++) {
    const double *J = nsdae_fc_part(c, e);
    double *y = c->y + c->parts.offset[c->parts.block[e]];
    int n = c->parts.size[c->parts.block[e]];
    if (n == BODY)
      apply_part(BODY, J, dr, y);
    else
      apply_part(n, J, dr, y);
  }
}

/* ---- one contact */

/* Whether item k, of which u are the velocities, sticks: it closes without an impulse, and with
 * u_T = 0 and u_N = 0, r - (D + e)^-1 u is inside its cone. The usual case, and cheap. */
static inline int sticks(const nsdae_fc_scaled *c, int k, const double *u, double *r)
{
  const double *S = c->items.S + 9 * (size_t)k, *D = S + 6, *old = c->r + 3 * k;
  r[0] = old[0] - (S[0] * u[0] + S[1] * u[1] + S[2] * u[2]);
  r[1] = old[1] - (S[1] * u[0] + S[3] * u[1] + S[4] * u[2]);
  r[2] = old[2] - (S[2] * u[0] + S[4] * u[1] + S[5] * u[2]);
  const double most = c->items.mu[k] * r[0]; /* so that no root is needed; whose square is not 0 */
  const double closing = D[0] * old[0] + D[1] * old[1] + D[2] * old[2] - u[0];
  return closing + NSDAE_FC_PROXIMAL * old[0] > 0 && most > TINY &&
         r[1] * r[1] + r[2] * r[2] <= most * most;
}

/* The new r of item k, of which u are the velocities. */
static void solve_item(const nsdae_fc_scaled *c, int k, const double *u, double *slip, double *r)
{
  double D[9], q[3] = {u[0], u[1], u[2]}, old[3];
  if (c->items.kind[k] == NSDAE_FC_CONE && sticks(c, k, u, r)) {
    slip[k] = 0;
    return;
  }
  memcpy(old, c->r + 3 * k, sizeof old);
  if (c->items.kind[k] == NSDAE_FC_CONE && old[0] == 0 && old[1] == 0 && old[2] == 0 && u[0] >= 0) {
    r[0] = r[1] = r[2] = 0; /* nothing presses and it does not approach */
    return;
  }
  memcpy(D, c->items.D + 9 * (size_t)k, sizeof D);
  for (int j = 0; j < 3; j++) D[4 * j] += NSDAE_FC_PROXIMAL;
  r[1] = r[2] = 0;
  if (c->items.kind[k] != NSDAE_FC_CONE) {
    r[0] = old[0] - u[0] / D[0];
    if (c->items.kind[k] == NSDAE_FC_NORMAL && !(r[0] > 0)) r[0] = 0;
    return;
  }
  nsdae_fc_turn(c->items.turn + 2 * k, 1, q);
  nsdae_fc_turn(c->items.turn + 2 * k, 1, old);
  for (int j = 0; j < 3; j++)
    q[j] -= D[3 * j] * old[0] + D[3 * j + 1] * old[1] + D[3 * j + 2] * old[2];
  nsdae_fc_solve_contact(D, q, c->items.mu[k], c->exact, slip + k, r);
  nsdae_fc_turn(c->items.turn + 2 * k, -1, r);
}

/* ---- sweeps */

void nsdae_fc_sweep_begin(nsdae_fc_scaled *c)
{
  if (c->local) return;
  memset(c->y, 0, (size_t)c->ny * sizeof *c->y);
  for (int k = 0; k < c->n; k++) add_parts(c, k, c->r + 3 * k);
}

double nsdae_fc_sweep(nsdae_fc_scaled *c, double *slip)
{
  double change = 0;
  for (int k = 0; k < c->n; k++) {
    double u[3], r[3];
    gather_block(c, k, u);
    solve_item(c, k, u, slip, r);
    for (int j = 0; j < 3; j++) r[j] -= c->r[3 * k + j];
    double most = nsdae_larger(nsdae_larger(fabs(r[0]), fabs(r[1])), fabs(r[2]));
    if (most == 0) continue;
    change = nsdae_larger(change, c->items.weight[k] * most);
    for (int j = 0; j < 3; j++) c->r[3 * k + j] += r[j];
    if (!c->local) add_parts(c, k, r);
  }
  return change;
}

int nsdae_fc_sweep_converged(const nsdae_fc_scaled *c, double tol, int *seen)
{
  for (int i = 0; i < c->n; i++) {
    int k = *seen + i < c->n ? *seen + i : *seen + i - c->n;
    double u[3];
    gather_block(c, k, u);
    if (nsdae_fc_item_residual(c, k, c->r, u) <= tol) continue;
    *seen = k;
    return 0;
  }
  return 1;
}
