#include "sweep.h"

#include <math.h>
#include <string.h>

#include "cone.h"
#include "coulomb.h"

/* A proximal term that leaves fixed points where they are makes singular diagonal blocks regular.
 */
static const double PROXIMAL = 1e-9;

/* u = J^T y + q + C r of item k */
static inline void gather(const nsdae_fc *c, int k, double *u)
{
  const double *r = c->r + 3 * k;
  for (int j = 0; j < 3; j++) u[j] = c->q[3 * k + j] + c->C[3 * k + j] * r[j];
  for (int e = c->first[k]; e < c->first[k + 1]; e++) {
    const double *J = nsdae_fc_part(c, e), *y = c->y + c->offset[c->block[e]];
    int n = c->size[c->block[e]];
    double a = 0, b = 0, d = 0;
    for (int l = 0; l < n; l++) {
      a += J[l] * y[l];
      b += J[n + l] * y[l];
      d += J[2 * n + l] * y[l];
    }
    u[0] += a, u[1] += b, u[2] += d;
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
    for (int l = 0; l < n; l++) y[l] += J[l] * dr[0] + J[n + l] * dr[1] + J[2 * n + l] * dr[2];
  }
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
  nsdae_fc_turn(c->turn + 2 * k, 1, q);
  nsdae_fc_turn(c->turn + 2 * k, 1, old);
  for (int j = 0; j < 3; j++)
    q[j] -= D[3 * j] * old[0] + D[3 * j + 1] * old[1] + D[3 * j + 2] * old[2];
  nsdae_fc_solve_contact(D, q, c->mu[k], slip + k, r);
  nsdae_fc_turn(c->turn + 2 * k, -1, r);
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
