#include "drop.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "random.h"

static double uniform(drop *d, double a, double b)
{
  return random_between(&d->seed, a, b);
}

static int one_of(drop *d, int n)
{
  return random_below(&d->seed, n);
}

/* R of body coordinates q: of an angle, or of the unit quaternion along q [3 .. 6]. */
static void rotation(const drop *of, const double *q, double R[3][3])
{
  if (!of->space) {
    double c = cos(q[2]), s = sin(q[2]), r[3][3] = {{c, -s, 0}, {s, c, 0}, {0, 0, 1}};
    memcpy(R, r, sizeof r);
    return;
  }
  const double *p = q + 3;
  double n = sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2] + p[3] * p[3]);
  double a = p[0] / n, b = p[1] / n, c = p[2] / n, d = p[3] / n;
  double r[3][3] = {{a * a + b * b - c * c - d * d, 2 * (b * c - a * d), 2 * (b * d + a * c)},
                    {2 * (b * c + a * d), a * a - b * b + c * c - d * d, 2 * (c * d - a * b)},
                    {2 * (b * d - a * c), 2 * (c * d + a * b), a * a - b * b - c * c + d * d}};
  memcpy(R, r, sizeof r);
}

/* The point in space from the centre. */
static void arm(const drop *d, double R[3][3], int point, double *r)
{
  const double *p = d->point[point];
  for (int i = 0; i < 3; i++) r[i] = R[i][0] * p[0] + R[i][1] * p[1] + R[i][2] * p[2];
}

static int mass(double t, const double *q, double *M, int ldm, void *user)
{
  const drop *d = user;
  (void)t;
  (void)q;
  for (int b = 0; b < d->bodies && !d->space; b++)
    for (int i = 0; i < 3; i++) M[(3 * b + i) * (ldm + 1)] = i < 2 ? d->m : d->J[2];
  for (int i = 0; i < 6 && d->space; i++) M[i * (ldm + 1)] = i < 3 ? d->m : d->J[i - 3];
  return 0;
}

static int force(double t, const double *q, const double *v, double *F, void *user)
{
  const drop *d = user;
  (void)t;
  (void)q;
  if (!d->space) {
    for (int b = 0; b < d->bodies; b++) F[3 * b + 1] = -d->m * d->g;
    return 0;
  }
  const double *w = v + 3, *J = d->J;
  F[2] = -d->m * d->g;
  F[3] = (J[1] - J[2]) * w[1] * w[2];
  F[4] = (J[2] - J[0]) * w[2] * w[0];
  F[5] = (J[0] - J[1]) * w[0] * w[1];
  return 0;
}

static int potential(double t, const double *q, double *V, void *user)
{
  const drop *d = user;
  (void)t;
  *V = 0;
  for (int b = 0; b < d->bodies; b++) *V += d->m * d->g * q[d->space ? 2 : 3 * b + 1];
  return 0;
}

static int kinematics(double t, const double *q, const double *v, double *qdot, void *user)
{
  const double *p = q + 3, *w = v + 3;
  (void)t;
  (void)user;
  for (int i = 0; i < 3; i++) qdot[i] = v[i];
  qdot[3] = (-p[1] * w[0] - p[2] * w[1] - p[3] * w[2]) / 2;
  qdot[4] = (p[0] * w[0] + p[2] * w[2] - p[3] * w[1]) / 2;
  qdot[5] = (p[0] * w[1] + p[3] * w[0] - p[1] * w[2]) / 2;
  qdot[6] = (p[0] * w[2] + p[1] * w[1] - p[2] * w[0]) / 2;
  return 0;
}

/* Contacts: every point of every body with every wall, then pairs of discs. */
static int gap(double t, const double *q, double *g, void *user)
{
  const drop *d = user;
  int c = 0;
  (void)t;
  for (int b = 0; b < d->bodies; b++) {
    double r[3], R[3][3];
    rotation(d, q + 3 * b, R);
    for (int p = 0; p < d->points; p++) {
      arm(d, R, p, r);
      for (int w = 0; w < d->walls; w++, c++) {
        g[c] = -d->radius;
        for (int i = 0; i < (d->space ? 3 : 2); i++)
          g[c] += d->normal[w][i] * (q[3 * b + i] + r[i]);
      }
    }
  }
  for (int a = 0; a < d->bodies; a++)
    for (int b = a + 1; b < d->bodies; b++)
      g[c++] = hypot(q[3 * a] - q[3 * b], q[3 * a + 1] - q[3 * b + 1]) - 2 * d->radius;
  return 0;
}

/* Row of direction n at the arm r of body b, which has turned by R. */
static void row(const drop *d, double R[3][3], int b, const double *n, const double *r, double sign,
                double *W)
{
  if (!d->space) {
    W[3 * b] += sign * n[0];
    W[3 * b + 1] += sign * n[1];
    W[3 * b + 2] += sign * (r[0] * n[1] - r[1] * n[0]);
    return;
  }
  double m[3] = {r[1] * n[2] - r[2] * n[1], r[2] * n[0] - r[0] * n[2], r[0] * n[1] - r[1] * n[0]};
  for (int i = 0; i < 3; i++) {
    W[i] = n[i];
    W[3 + i] = R[0][i] * m[0] + R[1][i] * m[1] + R[2][i] * m[2];
  }
}

/* Tangents of a unit normal. */
static void tangents(const drop *d, const double *n, double t[2][3])
{
  if (!d->space) {
    t[0][0] = n[1], t[0][1] = -n[0], t[0][2] = 0;
    return;
  }
  double s = hypot(n[1], n[2]);
  t[0][0] = 0, t[0][1] = n[2] / s, t[0][2] = -n[1] / s;
  t[1][0] = n[1] * t[0][2] - n[2] * t[0][1];
  t[1][1] = n[2] * t[0][0] - n[0] * t[0][2];
  t[1][2] = n[0] * t[0][1] - n[1] * t[0][0];
}

static void rows(const drop *d, const double *q, int tangential, double *W, int ldw)
{
  int c = 0, nt = d->space ? 2 : 1;
  double R[3][3];
  for (int b = 0; b < d->bodies; b++) {
    rotation(d, q + 3 * b, R);
    for (int p = 0; p < d->points; p++) {
      double r[3];
      arm(d, R, p, r);
      for (int w = 0; w < d->walls; w++) {
        double at[3];
        for (int i = 0; i < 3; i++) at[i] = r[i] - d->radius * d->normal[w][i];
        if (!tangential) row(d, R, b, d->normal[w], at, 1, W + (size_t)c++ * (size_t)ldw);
        for (int l = 0; l < nt && tangential; l++)
          row(d, R, b, d->tangent[w][l], at, 1, W + (size_t)c++ * (size_t)ldw);
      }
    }
  }
  for (int a = 0; a < d->bodies; a++)
    for (int b = a + 1; b < d->bodies; b++, c++) {
      double n[3] = {q[3 * a] - q[3 * b], q[3 * a + 1] - q[3 * b + 1], 0}, t[2][3];
      double s = hypot(n[0], n[1]);
      n[0] /= s, n[1] /= s;
      tangents(d, n, t);
      double ra[3] = {-d->radius * n[0], -d->radius * n[1], 0}, rb[3] = {-ra[0], -ra[1], 0};
      double *to = W + (size_t)c * (size_t)ldw;
      row(d, R, a, tangential ? t[0] : n, ra, 1, to);
      row(d, R, b, tangential ? t[0] : n, rb, -1, to);
    }
}

static int normals(double t, const double *q, double *W, int ldw, void *user)
{
  (void)t;
  rows(user, q, 0, W, ldw);
  return 0;
}

static int tangent(double t, const double *q, double *W, int ldw, void *user)
{
  (void)t;
  rows(user, q, 1, W, ldw);
  return 0;
}

/* Centripetal: a point at r from the centre of body b has omega x (omega x r). */
static void centripetal(const drop *d, double R[3][3], const double *v, int b, const double *r,
                        double *a)
{
  double w[3] = {0, 0, d->space ? 0 : v[3 * b + 2]};
  if (d->space) {
    for (int i = 0; i < 3; i++) w[i] = R[i][0] * v[3] + R[i][1] * v[4] + R[i][2] * v[5];
  }
  double along = w[0] * r[0] + w[1] * r[1] + w[2] * r[2];
  double square = w[0] * w[0] + w[1] * w[1] + w[2] * w[2];
  for (int i = 0; i < 3; i++) a[i] = w[i] * along - r[i] * square;
}

static int acceleration(double t, const double *q, const double *v, double *omega_n,
                        double *omega_t, double *omega_s, void *user)
{
  const drop *d = user;
  int c = 0, nt = d->space ? 2 : 1;
  (void)t;
  (void)omega_s;
  double R[3][3];
  for (int b = 0; b < d->bodies; b++) {
    rotation(d, q + 3 * b, R);
    for (int p = 0; p < d->points; p++) {
      double r[3], a[3];
      arm(d, R, p, r);
      centripetal(d, R, v, b, r, a);
      for (int w = 0; w < d->walls; w++, c++) {
        const double *n = d->normal[w];
        const double(*dir)[3] = (const double(*)[3])d->tangent[w];
        omega_n[c] = a[0] * n[0] + a[1] * n[1] + a[2] * n[2];
        for (int l = 0; l < nt; l++)
          omega_t[c * nt + l] = a[0] * dir[l][0] + a[1] * dir[l][1] + a[2] * dir[l][2];
      }
    }
  }
  for (int a = 0; a < d->bodies; a++)
    for (int b = a + 1; b < d->bodies; b++, c++) { /* n' = (1 - n n^T) dv / |dx| */
      double n[2] = {q[3 * a] - q[3 * b], q[3 * a + 1] - q[3 * b + 1]}, s = hypot(n[0], n[1]);
      double u[2] = {v[3 * a] - v[3 * b], v[3 * a + 1] - v[3 * b + 1]};
      n[0] /= s, n[1] /= s;
      double along = n[0] * u[0] + n[1] * u[1];
      double turn[2] = {(u[0] - n[0] * along) / s, (u[1] - n[1] * along) / s};
      omega_n[c] = turn[0] * u[0] + turn[1] * u[1];
      omega_t[c] = turn[1] * u[0] - turn[0] * u[1];
    }
  return 0;
}

static void make_walls(drop *d)
{
  d->walls = 1 + one_of(d, d->space ? 3 : 2);
  double tilt = d->walls == 1 ? (one_of(d, 2) ? 0 : uniform(d, -0.3, 0.3)) : uniform(d, 0.3, 1.2);
  int up = d->space ? 2 : 1;
  for (int w = 0; w < d->walls; w++) {
    double turn = 2 * acos(-1) * w / d->walls;
    d->normal[w][up] = cos(tilt);
    d->normal[w][0] = sin(tilt) * cos(turn);
    if (d->space) d->normal[w][1] = sin(tilt) * sin(turn);
  }
}

static void make_body(drop *d)
{
  int kind = one_of(d, 4); /* box, box, rod, disc or ball */
  for (int i = 0; i < 3; i++) d->half[i] = uniform(d, 0.02, 0.3);
  d->m = uniform(d, 0.2, 5);
  d->bodies = d->points = 1;
  if (kind == 3) {
    d->radius = d->half[0];
    d->bodies = d->space ? 1 : 1 + one_of(d, DROP_BODIES);
    for (int i = 0; i < 3; i++) d->J[i] = (d->space ? 0.4 : 0.5) * d->m * d->radius * d->radius;
    return;
  }
  if (kind == 2) {
    d->half[1] = d->half[2] = d->radius = uniform(d, 0.005, 0.03);
    d->points = 2;
    d->point[0][0] = -d->half[0];
    d->point[1][0] = d->half[0];
  } else {
    d->points = d->space ? 8 : 4;
    for (int p = 0; p < d->points; p++)
      for (int i = 0; i < (d->space ? 3 : 2); i++)
        d->point[p][i] = (p >> i & 1) ? d->half[i] : -d->half[i];
  }
  const double *h = d->half;
  d->J[0] = d->m * (h[1] * h[1] + h[2] * h[2]) / 3;
  d->J[1] = d->m * (h[0] * h[0] + h[2] * h[2]) / 3;
  d->J[2] = d->m * (h[0] * h[0] + h[1] * h[1]) / 3;
}

static void make_start(drop *d)
{
  int up = d->space ? 2 : 1, flat = one_of(d, 4) == 0;
  double g[64], lowest = INFINITY, spread = one_of(d, 3) ? 1 : 0;
  for (int b = 0; b < d->bodies; b++) {
    double *q = d->q0 + 3 * b, *v = d->v0 + 3 * b;
    q[0] = d->bodies > 1 ? uniform(d, -0.01, 0.01) * spread : 0;
    q[up] = 2.3 * d->radius * b;
    if (!d->space) q[2] = flat ? 0 : uniform(d, -3, 3);
    for (int i = 0; i < (d->space ? 6 : 3); i++) v[i] = spread * uniform(d, -1, 1);
  }
  if (d->space) {
    double *p = d->q0 + 3, s = 0;
    p[0] = 1;
    for (int i = 1; i < 4 && !flat; i++) p[i] = uniform(d, -1, 1);
    for (int i = 0; i < 4; i++) s += p[i] * p[i];
    for (int i = 0; i < 4; i++) p[i] /= sqrt(s);
  }
  gap(0, d->q0, g, d);
  int k = d->bodies * d->points * d->walls;
  for (int i = 0; i < k; i++) lowest = fmin(lowest, g[i] / d->normal[i % d->walls][up]);
  double height = one_of(d, 4) ? uniform(d, 0.01, 0.5) : 0;
  for (int b = 0; b < d->bodies; b++) d->q0[3 * b + up] += height - lowest;
}

void drop_make(drop *d, unsigned long seed)
{
  static const double some_e[] = {0, 0, 0.05, 0.2, 0.5, 0.8, 0.95, 1};
  static const double some_mu[] = {0, 0.05, 0.2, 0.5, 1, 2};
  memset(d, 0, sizeof *d);
  d->seed = seed;
  d->g = 9.81;
  d->space = one_of(d, 2);
  make_walls(d);
  make_body(d);
  d->e = one_of(d, 2) ? some_e[one_of(d, 8)] : uniform(d, 0, 1);
  d->mu = one_of(d, 2) ? some_mu[one_of(d, 6)] : uniform(d, 0, 2);
  d->rtol = one_of(d, 2) ? 1e-8 : pow(10, uniform(d, -11, -4));
  make_start(d);
  for (int i = 0; i < 7; i++) d->size = fmax(d->size, fabs(d->q0[i]));
  snprintf(d->name, sizeof d->name,
           "%lu: %s bodies %d points %d walls %d mu %.3g e %.3g rtol %.1e size %.2g", seed,
           d->space ? "space" : "plane", d->bodies, d->points, d->walls, d->mu, d->e, d->rtol,
           d->size);
}

void drop_throw(drop *d, unsigned long seed)
{
  do drop_make(d, seed++);
  while (d->space);
  d->bodies = DROP_THROWN;
  d->points = 1;
  memset(d->point, 0, sizeof d->point);
  d->radius = uniform(d, 0.05, 0.2);
  d->J[2] = 0.5 * d->m * d->radius * d->radius;
  d->size = 1;
  for (int b = 0; b < d->bodies; b++) {
    double *q = d->q0 + 3 * b, *v = d->v0 + 3 * b;
    q[0] = (b % 4 - 1.5) * 0.6 + uniform(d, -0.09, 0.09);
    q[1] = 2 + (double)(b / 4) * 0.6 + uniform(d, -0.09, 0.09);
    q[2] = 0;
    v[0] = -q[0] * uniform(d, 0, 8);
    v[1] = uniform(d, -5, 2);
    v[2] = uniform(d, -30, 30);
  }
  snprintf(d->name, sizeof d->name, "thrown %lu: walls %d mu %.3g e %.3g radius %.2g", seed,
           d->walls, d->mu, d->e, d->radius);
}

nsdae_system *drop_system(drop *d)
{
  int n = d->bodies, pairs = n * (n - 1) / 2, k = n * d->points * d->walls + pairs;
  nsdae_dims dims = {
      .nq = d->space ? 7 : 3 * n, .nv = d->space ? 6 : 3 * n, .k = k, .nt = d->space ? 2 : 1};
  nsdae_system *s = NULL;
  for (int w = 0; w < d->walls; w++) tangents(d, d->normal[w], d->tangent[w]);
  if (nsdae_system_create(&dims, &s, NULL) < 0) return NULL;
  nsdae_system_set_user(s, d);
  nsdae_system_set_mass(s, mass);
  nsdae_system_set_force(s, force);
  nsdae_system_set_potential(s, potential);
  if (d->space) nsdae_system_set_kinematics(s, kinematics);
  nsdae_system_set_gap(s, gap);
  nsdae_system_set_gap_normal(s, normals);
  nsdae_system_set_gap_tangent(s, tangent);
  nsdae_system_set_contact_acceleration(s, acceleration);
  for (int i = 0; i < k; i++) nsdae_system_set_contact(s, i, d->mu, d->e, 0);
  return s;
}

void drop_find_terms(const drop *d, const double *q, const double *v, drop_terms *to)
{
  memset(to, 0, sizeof *to);
  to->count = d->bodies * d->points * d->walls + d->bodies * (d->bodies - 1) / 2;
  gap(0, q, to->gap, (void *)d);
  rows(d, q, 0, to->W_N[0], DROP_NV);
  rows(d, q, 1, to->W_T[0], DROP_NV);
  acceleration(0, q, v, to->omega_N, to->omega_T, NULL, (void *)d);
  force(0, q, v, to->F, (void *)d);
}
