/* One contact, in its own frame: D = [w b^T; b S], S = diag(s), with everything else held
 * (Jourdan, Alart, Jean, Comput. Methods Appl. Mech. Eng. 155 (1998) 31). Where it slides,
 * u_T = -l r_T with l > 0, so that
 *
 *   r_T = -(S + l)^-1 (q_T + b r_N),   u_N = 0:  r_N = (b . p - q_N) / (w - b . g),
 *   p = (S + l)^-1 q_T,  g = (S + l)^-1 b,   and l is the root of  |r_T| - mu r_N,
 *
 * which is > 0 at l = 0, as it does not stick there, and < 0 at infinity. The root is kept in a
 * bracket and approached by secants (regula falsi of Illinois: Dowell and Jarratt, BIT 11 (1971)
 * 168), from the root of the sweep before: two or three values as a rule. */
#include "sweep.h"

#include <math.h>
#include <string.h>

#include "cone.h"

/* A proximal term that leaves fixed points where they are makes singular diagonal blocks regular.
 */
static const double PROXIMAL = 1e-9;

/* |r_T| - mu r_N at l, with r. */
static double excess(const double *D, const double *q, double mu, double l, double *r)
{
  double s1 = 1 / (D[4] + l), s2 = 1 / (D[8] + l);
  double p1 = s1 * q[1], p2 = s2 * q[2], g1 = s1 * D[1], g2 = s2 * D[2];
  r[0] = (D[1] * p1 + D[2] * p2 - q[0]) / (D[0] - D[1] * g1 - D[2] * g2);
  r[1] = -p1 - g1 * r[0];
  r[2] = -p2 - g2 * r[0];
  return nsdae_fc_length(r[1], r[2]) - mu * r[0];
}

/* An upper end of the bracket, from the guess on. */
static double bracket(const double *D, const double *q, double mu, double l, double *f, double *r)
{
  if (!(l > 0)) l = D[4] + D[8];
  *f = excess(D, q, mu, l, r);
  for (int k = 0; k < 200 && *f > 0; k++) {
    l *= 16;
    *f = excess(D, q, mu, l, r);
  }
  return l;
}

static double slide(const double *D, const double *q, double mu, double at_low, double guess,
                    double *r)
{
  double low = 0, at_high, high = bracket(D, q, mu, guess, &at_high, r);
  int side = 0;
  for (int k = 0; k < 60; k++) {
    double l = (low * at_high - high * at_low) / (at_high - at_low);
    if (!(l > low && l < high)) break;
    double f = excess(D, q, mu, l, r);
    if (fabs(f) <= 1e-15 * mu * r[0]) return l;
    if (f > 0) {
      if (side == 1) at_high /= 2;
      low = l, at_low = f, side = 1;
    } else {
      if (side == -1) at_low /= 2;
      high = l, at_high = f, side = -1;
    }
  }
  return high;
}

void nsdae_fc_solve_contact(const double *D, const double *q, double mu, double *slip, double *r)
{
  if (q[0] >= 0) {
    r[0] = r[1] = r[2] = 0;
    return;
  }
  double f = excess(D, q, mu, 0, r);
  if (f <= 0) {
    *slip = 0;
    return;
  }
  *slip = slide(D, q, mu, f, *slip, r);
}

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

/* y += J dr of one part */
static inline void apply_part(int n, const double *restrict J, const double *restrict dr,
                              double *restrict y)
{
  for (int l = 0; l < n; l++) y[l] += J[l] * dr[0] + J[n + l] * dr[1] + J[2 * n + l] * dr[2];
}

enum { BODY = 6 }; /* the size of most blocks: its loops are laid out flat */

/* u = J^T y + q + C r of item k */
static inline void gather(const nsdae_fc *c, int k, double *u)
{
  const double *r = c->r + 3 * k;
  for (int j = 0; j < 3; j++) u[j] = c->q[3 * k + j] + c->C[3 * k + j] * r[j];
  for (int e = c->first[k]; e < c->first[k + 1]; e++) {
    const double *J = nsdae_fc_part(c, e), *y = c->y + c->offset[c->block[e]];
    int n = c->size[c->block[e]];
    if (n == BODY)
      gather_part(BODY, J, y, u);
    else
      gather_part(n, J, y, u);
  }
}

/* r += dr, y += J dr */
static inline void apply(nsdae_fc *c, int k, const double *dr)
{
  for (int j = 0; j < 3; j++) c->r[3 * k + j] += dr[j];
  if (c->local) return;
  for (int e = c->first[k]; e < c->first[k + 1]; e++) {
    const double *J = nsdae_fc_part(c, e);
    double *y = c->y + c->offset[c->block[e]];
    int n = c->size[c->block[e]];
    if (n == BODY)
      apply_part(BODY, J, dr, y);
    else
      apply_part(n, J, dr, y);
  }
}

/* x_T turned into the frame of D, or back (sign -1). */
static inline void turn(const double *by, double sign, double *x)
{
  double held = x[1];
  x[1] = by[0] * held + sign * by[1] * x[2];
  x[2] = by[0] * x[2] - sign * by[1] * held;
}

/* The new r of item k, of which u are the velocities. */
static void solve_item(const nsdae_fc *c, int k, const double *u, double *slip, double *r)
{
  double D[9], q[3] = {u[0], u[1], u[2]}, old[3];
  memcpy(D, c->D + 9 * (size_t)k, sizeof D);
  memcpy(old, c->r + 3 * k, sizeof old);
  for (int j = 0; j < 3; j++) D[4 * j] += PROXIMAL;
  r[1] = r[2] = 0;
  if (c->kind[k] != NSDAE_FC_CONE) {
    r[0] = old[0] - u[0] / D[0];
    if (c->kind[k] == NSDAE_FC_NORMAL && !(r[0] > 0)) r[0] = 0;
    return;
  }
  turn(c->turn + 2 * k, 1, q);
  turn(c->turn + 2 * k, 1, old);
  for (int j = 0; j < 3; j++)
    q[j] -= D[3 * j] * old[0] + D[3 * j + 1] * old[1] + D[3 * j + 2] * old[2];
  nsdae_fc_solve_contact(D, q, c->mu[k], slip + k, r);
  turn(c->turn + 2 * k, -1, r);
}

double nsdae_fc_sweep(nsdae_fc *c, int sweeps, double *slip)
{
  double change = 0;
  for (int s = 0; s < sweeps; s++) {
    change = 0;
    for (int k = 0; k < c->n; k++) {
      double u[3], r[3];
      gather(c, k, u);
      solve_item(c, k, u, slip, r);
      for (int j = 0; j < 3; j++) r[j] -= c->r[3 * k + j];
      double most = fmax(fabs(r[0]), fmax(fabs(r[1]), fabs(r[2])));
      if (most == 0) continue;
      change = fmax(change, c->weight[k] * most);
      apply(c, k, r);
    }
  }
  return change;
}
