#include "natural_map.h"

#include <math.h>
#include <string.h>

#include "cone.h"

/* Rows 1 and 2 of an item that has none, or whose tangential impulse is zero: r = 0. */
static void nothing(int from, const double *r, double *F, double *B, double *A)
{
  memset(A, 0, 9 * sizeof *A);
  memset(B, 0, 9 * sizeof *B);
  for (int j = from; j < 3; j++) {
    F[j] = r[j];
    B[4 * j] = 1;
  }
}

/* The derivative G of P at z. On the cone, with d = z_T / |z_T|, w = (1, mu d) / sqrt(1 + mu^2):
 * G = w w^T + mu n / |z_T| (1 - d d^T) in the tangential plane, n the normal part of P(z). */
static void slope_of_projection(double mu, const nsdae_fc_place *p, double *G)
{
  double P[3] = {p->z[0], p->z[1], p->z[2]}, t = p->t;
  memset(G, 0, 9 * sizeof *G);
  if (p->inside) {
    G[0] = G[4] = G[8] = 1;
    return;
  }
  nsdae_fc_project(mu, P);
  if (p->polar || P[0] == 0) return;
  double root = 1 / sqrt(1 + mu * mu), bend = mu * P[0] / t, d[2] = {p->z[1] / t, p->z[2] / t};
  double w[3] = {root, mu * root * d[0], mu * root * d[1]};
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) G[3 * i + j] = w[i] * w[j];
  G[4] += bend * (1 - d[0] * d[0]);
  G[8] += bend * (1 - d[1] * d[1]);
  G[5] -= bend * d[0] * d[1];
  G[7] -= bend * d[0] * d[1];
}

void nsdae_fc_natural_map(int kind, double mu, const double *r, const double *low, const double *u,
                          double *F, double *B, double *A)
{
  double slip = nsdae_fc_length(u[1], u[2]), y[3] = {u[0] + mu * slip, u[1], u[2]}, G[9];
  if (kind != NSDAE_FC_CONE) {
    int closed = kind == NSDAE_FC_BILATERAL || r[0] - u[0] > 0;
    nothing(1, r, F, B, A);
    F[0] = closed ? u[0] : r[0];
    A[0] = closed;
    B[0] = !closed;
    return;
  }
  const nsdae_fc_place p = nsdae_fc_place_of(mu, r, low, y);
  nsdae_fc_map_of_place(mu, &p, r, y, F);
  slope_of_projection(mu, &p, G);
  for (int i = 0; i < 9; i++) {
    B[i] = (i % 4 == 0) - G[i];
    A[i] = G[i];
  }
  for (int i = 0; i < 3; i++)
    for (int j = 1; j < 3 && slip > 0; j++) A[3 * i + j] += G[3 * i] * mu * (u[j] / slip);
}

/* (l + sqrt(l^2 + 4 e^2)) / 2 and its derivative, without cancellation. */
static double plus(double l, double e, double *slope)
{
  double root = sqrt(l * l + 4 * e * e), value = l > 0 ? (l + root) / 2 : 2 * e * e / (root - l);
  *slope = value / root;
  return value;
}

/* a - plus(a - b), which is also b - plus(b - a): the one without cancellation. */
static double smooth_min(double a, double b, double e, double *slope)
{
  double l = a - b, ignored;
  (void)plus(l, e, slope);
  return l > 0 ? b - plus(-l, e, &ignored) : a - plus(l, e, &ignored);
}

/* a - P(a - b), P the smoothed projection onto the second-order cone {|x_T| <= x_N}, and the
 * derivative of P: by the eigenvalues x_N +- |x_T| of x = a - b, those of a and b along the same
 * vectors, and what both have across them, where x has nothing: as the smaller has it. */
static void smooth_cone(double e, const double *a, const double *b, double *F, double *G)
{
  double x[3] = {a[0] - b[0], a[1] - b[1], a[2] - b[2]}, t = nsdae_fc_length(x[1], x[2]), slope[2];
  double d[2] = {t > 0 ? x[1] / t : 1, t > 0 ? x[2] / t : 0};
  double at = d[0] * a[1] + d[1] * a[2], bt = d[0] * b[1] + d[1] * b[2];
  double high = smooth_min(a[0] + at, b[0] + bt, e, slope);
  double low = smooth_min(a[0] - at, b[0] - bt, e, slope + 1), ignored;
  double mean = (slope[0] + slope[1]) / 2, half = (slope[0] - slope[1]) / 2;
  double spread = plus(x[0] + t, e, &ignored) - plus(x[0] - t, e, &ignored);
  double bend = t > 1e-8 * e ? spread / (2 * t) : slope[0];
  int of_a = fabs(a[1]) + fabs(a[2]) < fabs(b[1]) + fabs(b[2]);
  const double *small = of_a ? a : b;
  double along = of_a ? at : bt;
  F[0] = (high + low) / 2;
  G[0] = mean;
  for (int i = 0; i < 2; i++) {
    F[i + 1] = (high - low) / 2 * d[i] + (small[i + 1] - along * d[i]);
    G[i + 1] = G[3 * i + 3] = half * d[i];
    for (int j = 0; j < 2; j++)
      G[3 * i + j + 4] = mean * d[i] * d[j] + bend * ((i == j) - d[i] * d[j]);
  }
}

/* In rows scaled by S = (sqrt(mu), 1 / sqrt(mu), 1 / sqrt(mu)), the cone is the second-order cone
 * for S r and its own dual for S^-1 u^, u^ = u + mu |u_T| e_N with |u_T| smoothed. */
void nsdae_fc_smooth_map(int kind, double mu, double e, const double *r, const double *u, double *F,
                         double *B, double *A)
{
  if (kind == NSDAE_FC_BILATERAL) {
    nsdae_fc_natural_map(kind, mu, r, NULL, u, F, B, A);
    return;
  }
  if (kind == NSDAE_FC_NORMAL) {
    double slope;
    nothing(1, r, F, B, A);
    F[0] = smooth_min(r[0], u[0], e, &slope);
    B[0] = 1 - slope;
    A[0] = slope;
    return;
  }
  double square = u[1] * u[1] + u[2] * u[2], slip = sqrt(square + e * e);
  double S[3] = {sqrt(mu), 1 / sqrt(mu), 1 / sqrt(mu)}, G[9];
  double a[3] = {S[0] * r[0], S[1] * r[1], S[2] * r[2]};
  double b[3] = {(u[0] + mu * (square / (slip + e))) / S[0], u[1] / S[1], u[2] / S[2]};
  smooth_cone(e, a, b, F, G);
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) {
      B[3 * i + j] = ((i == j) - G[3 * i + j]) * S[j];
      A[3 * i + j] = G[3 * i + j] / S[j];
      if (j > 0) A[3 * i + j] += A[3 * i] * mu * (u[j] / slip);
    }
}
