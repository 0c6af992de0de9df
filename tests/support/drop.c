#include "drop.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* splitmix64, Steele, Lea and Flood 2014 */
static unsigned long next(drop *d)
{
  unsigned long z = d->seed += 0x9e3779b97f4a7c15UL;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9UL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebUL;
  return z ^ (z >> 31);
}

static double uniform(drop *d, double a, double b)
{
  return a + (b - a) * (double)(next(d) >> 11) / 9007199254740992.0;
}

static int one_of(drop *d, int n)
{
  return (int)(next(d) % (unsigned long)n);
}

/* R of the unit quaternion along p [4], columns of body axes. */
static void rotation(const double *p, double R[3][3])
{
  double n = sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2] + p[3] * p[3]);
  double a = p[0] / n, b = p[1] / n, c = p[2] / n, d = p[3] / n;
  double r[3][3] = {{a * a + b * b - c * c - d * d, 2 * (b * c - a * d), 2 * (b * d + a * c)},
                    {2 * (b * c + a * d), a * a - b * b + c * c - d * d, 2 * (c * d - a * b)},
                    {2 * (b * d - a * c), 2 * (c * d + a * b), a * a - b * b - c * c + d * d}};
  memcpy(R, r, sizeof r);
}

/* The point in space from the centre. */
static void arm(const drop *d, const double *q, int point, double *r)
{
  const double *p = d->point[point];
  if (!d->space) {
    double c = cos(q[2]), s = sin(q[2]);
    r[0] = c * p[0] - s * p[1];
    r[1] = s * p[0] + c * p[1];
    r[2] = 0;
    return;
  }
  double R[3][3];
  rotation(q + 3, R);
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
  for (int b = 0; b < d->bodies; b++)
    for (int p = 0; p < d->points; p++) {
      double r[3];
      arm(d, q + 3 * b, p, r);
      for (int w = 0; w < d->walls; w++, c++) {
        g[c] = -d->radius;
        for (int i = 0; i < (d->space ? 3 : 2); i++)
          g[c] += d->normal[w][i] * (q[3 * b + i] + r[i]);
      }
    }
  for (int a = 0; a < d->bodies; a++)
    for (int b = a + 1; b < d->bodies; b++)
      g[c++] = hypot(q[3 * a] - q[3 * b], q[3 * a + 1] - q[3 * b + 1]) - 2 * d->radius;
  return 0;
}

/* Row of direction n at the arm r of body b. */
static void row(const drop *d, const double *q, int b, const double *n, const double *r,
                double sign, double *W)
{
  if (!d->space) {
    W[3 * b] += sign * n[0];
    W[3 * b + 1] += sign * n[1];
    W[3 * b + 2] += sign * (r[0] * n[1] - r[1] * n[0]);
    return;
  }
  double R[3][3];
  double m[3] = {r[1] * n[2] - r[2] * n[1], r[2] * n[0] - r[0] * n[2], r[0] * n[1] - r[1] * n[0]};
  rotation(q + 3, R);
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
  for (int b = 0; b < d->bodies; b++)
    for (int p = 0; p < d->points; p++) {
      double r[3], t[2][3];
      arm(d, q + 3 * b, p, r);
      for (int w = 0; w < d->walls; w++) {
        double at[3];
        for (int i = 0; i < 3; i++) at[i] = r[i] - d->radius * d->normal[w][i];
        tangents(d, d->normal[w], t);
        if (!tangential) row(d, q, b, d->normal[w], at, 1, W + (size_t)c++ * (size_t)ldw);
        for (int l = 0; l < nt && tangential; l++)
          row(d, q, b, t[l], at, 1, W + (size_t)c++ * (size_t)ldw);
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
      row(d, q, a, tangential ? t[0] : n, ra, 1, to);
      row(d, q, b, tangential ? t[0] : n, rb, -1, to);
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
static void centripetal(const drop *d, const double *q, const double *v, int b, const double *r,
                        double *a)
{
  double w[3] = {0, 0, d->space ? 0 : v[3 * b + 2]}, R[3][3];
  if (d->space) {
    rotation(q + 3, R);
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
  for (int b = 0; b < d->bodies; b++)
    for (int p = 0; p < d->points; p++) {
      double r[3], a[3], dir[2][3];
      arm(d, q + 3 * b, p, r);
      centripetal(d, q, v, b, r, a);
      for (int w = 0; w < d->walls; w++, c++) {
        const double *n = d->normal[w];
        tangents(d, n, dir);
        omega_n[c] = a[0] * n[0] + a[1] * n[1] + a[2] * n[2];
        for (int l = 0; l < nt; l++)
          omega_t[c * nt + l] = a[0] * dir[l][0] + a[1] * dir[l][1] + a[2] * dir[l][2];
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

nsdae_system *drop_system(drop *d)
{
  int n = d->bodies, pairs = n * (n - 1) / 2, k = n * d->points * d->walls + pairs;
  nsdae_dims dims = {
      .nq = d->space ? 7 : 3 * n, .nv = d->space ? 6 : 3 * n, .k = k, .nt = d->space ? 2 : 1};
  nsdae_system *s = NULL;
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

enum { JAM_MOST = 10, JAM_CONTACTS = 64 };

/* det of the rows and columns of A [n x n] in the set. */
static double minor_of(const double *A, int n, unsigned set)
{
  double m[JAM_MOST][JAM_MOST], det = 1;
  int at[JAM_MOST], size = 0;
  for (int i = 0; i < n; i++)
    if (set >> i & 1) at[size++] = i;
  for (int i = 0; i < size; i++)
    for (int j = 0; j < size; j++) m[i][j] = A[at[i] * n + at[j]];
  for (int k = 0; k < size; k++) {
    int pivot = k;
    for (int i = k + 1; i < size; i++)
      if (fabs(m[i][k]) > fabs(m[pivot][k])) pivot = i;
    if (m[pivot][k] == 0) return 0;
    if (pivot != k) det = -det;
    for (int j = 0; j < size; j++) {
      double swap = m[k][j];
      m[k][j] = m[pivot][j];
      m[pivot][j] = swap;
    }
    det *= m[k][k];
    for (int i = k + 1; i < size; i++)
      for (int j = size - 1; j >= k; j--) m[i][j] -= m[i][k] / m[k][k] * m[k][j];
  }
  return det;
}

/* Of what touches, count of them: W_N^T M^-1 W_N, W_N^T M^-1 W_T, and the directions of sliding,
 * those that are free to be the worst. */
typedef struct jam {
  int count, nt, free[JAM_MOST];
  double normal[JAM_MOST * JAM_MOST], tangent[2][JAM_MOST * JAM_MOST], d[JAM_MOST][2];
} jam;

/* a^T M^-1 b */
static double mobility(const drop *d, const double *a, const double *b)
{
  double sum = 0;
  for (int i = 0; i < (d->space ? 6 : 3 * d->bodies); i++)
    sum += a[i] * b[i] / (d->space ? (i < 3 ? d->m : d->J[i - 3]) : (i % 3 < 2 ? d->m : d->J[2]));
  return sum;
}

/* Where contact j slides faster than `slow` its direction is known. */
static void direct(jam *p, int j, const double *W_T, int n, const double *v, double slow)
{
  double slip[2] = {0}, most = 0, speed = 0;
  for (int l = 0; l < p->nt; l++) {
    for (int i = 0; i < n; i++) slip[l] += W_T[l * n + i] * v[i];
    speed = hypot(speed, slip[l]);
    most = hypot(most, p->tangent[l][j * p->count + j]);
  }
  p->free[j] = !(speed > slow);
  for (int l = 0; l < p->nt; l++)
    p->d[j][l] = !p->free[j] ? slip[l] / speed
                 : most > 0  ? p->tangent[l][j * p->count + j] / most
                             : 0;
}

/* The minor of the set, of W_N^T M^-1 (W_N - mu W_T d). */
static double jam_minor(const jam *p, double mu, unsigned set)
{
  double A[JAM_MOST * JAM_MOST];
  for (int i = 0; i < p->count; i++)
    for (int j = 0; j < p->count; j++) {
      A[i * p->count + j] = p->normal[i * p->count + j];
      for (int l = 0; l < p->nt; l++)
        A[i * p->count + j] -= mu * p->tangent[l][i * p->count + j] * p->d[j][l];
    }
  return minor_of(A, p->count, set);
}

/* The least of the directions that are free: in each of them it is affine, so that one after the
 * other is turned to where it falls. */
static double worst_minor(jam p, double mu, unsigned set)
{
  for (int round = 0; round < 4; round++)
    for (int j = 0; j < p.count; j++) {
      double slope[2] = {0}, steepest = 0;
      if (!p.free[j] || !(set >> j & 1)) continue;
      for (int l = 0; l < p.nt; l++) {
        p.d[j][0] = l == 0, p.d[j][1] = l == 1;
        slope[l] = jam_minor(&p, mu, set);
      }
      p.d[j][0] = p.d[j][1] = 0;
      double still = jam_minor(&p, mu, set);
      for (int l = 0; l < p.nt; l++) steepest = hypot(steepest, slope[l] - still);
      for (int l = 0; l < p.nt && steepest > 0; l++) p.d[j][l] = (still - slope[l]) / steepest;
    }
  return jam_minor(&p, mu, set);
}

/* The contacts within `near` into at; whether something is still open there. */
static int find_near(const drop *d, const double *q, const int *mode, double near, jam *p, int *at)
{
  double g[JAM_CONTACTS];
  int k = d->bodies * d->points * d->walls + d->bodies * (d->bodies - 1) / 2, hit = 0;
  gap(0, q, g, (void *)d);
  for (int c = 0; c < k && p->count < JAM_MOST; c++) {
    if (g[c] > near) continue;
    hit |= mode[c] == NSDAE_MODE_OPEN; /* an impact turns what slides */
    at[p->count++] = c;
  }
  return hit;
}

int drop_may_jam(const drop *d, const double *q, const double *v, const int *mode, double near)
{
  double W_N[JAM_CONTACTS * DROP_NV] = {0}, W_T[2 * JAM_CONTACTS * DROP_NV] = {0};
  int n = d->space ? 6 : 3 * d->bodies, at[JAM_MOST];
  jam p = {.nt = d->space ? 2 : 1};
  int hit = find_near(d, q, mode, near, &p, at);
  rows(d, q, 0, W_N, n);
  rows(d, q, 1, W_T, n);
  for (int i = 0; i < p.count; i++)
    for (int j = 0; j < p.count; j++) {
      p.normal[i * p.count + j] = mobility(d, W_N + at[i] * n, W_N + at[j] * n);
      for (int l = 0; l < p.nt; l++)
        p.tangent[l][i * p.count + j] = mobility(d, W_N + at[i] * n, W_T + (at[j] * p.nt + l) * n);
    }
  for (int j = 0; j < p.count; j++)
    direct(&p, j, W_T + at[j] * p.nt * n, n, v, hit ? INFINITY : 1e-8);
  for (unsigned set = 1; set < 1u << p.count; set++) {
    double scale = 1;
    for (int i = 0; i < p.count; i++)
      if (set >> i & 1) scale *= p.normal[i * p.count + i];
    if (worst_minor(p, d->mu, set) <= 1e-3 * scale) return 1;
  }
  return 0;
}
