#include "stiff_chain.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double h = 0.25, m = 1, g = 9.81, J[3] = {0.004, 0.0228, 0.0228};

/* R of a quaternion of any length, column-major */
static void rotation(const double *p, double R[9])
{
  double s = 2 / (p[0] * p[0] + p[1] * p[1] + p[2] * p[2] + p[3] * p[3]);
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) {
      int k = 3 - i - j; /* the other axis; e = +1 if (i, j, k) is cyclic */
      double e = i == j ? 0 : (j - i + 3) % 3 == 1 ? 1 : -1;
      R[i + 3 * j] = s * p[1 + i] * p[1 + j] - (i == j ? 0 : s * e * p[0] * p[1 + k]);
    }
  for (int i = 0; i < 3; i++)
    R[4 * i] = 1 - s * (p[1] * p[1] + p[2] * p[2] + p[3] * p[3] - p[1 + i] * p[1 + i]);
}

static void cross(const double *a, const double *b, double *c)
{
  c[0] = a[1] * b[2] - a[2] * b[1];
  c[1] = a[2] * b[0] - a[0] * b[2];
  c[2] = a[0] * b[1] - a[1] * b[0];
}

/* x := R s, or R^T s */
static void turn(const double *R, const double *s, double *x)
{
  for (int i = 0; i < 3; i++) x[i] = R[i] * s[0] + R[3 + i] * s[1] + R[6 + i] * s[2];
}

static void turn_back(const double *R, const double *s, double *x)
{
  for (int i = 0; i < 3; i++) x[i] = R[3 * i] * s[0] + R[3 * i + 1] * s[1] + R[3 * i + 2] * s[2];
}

static int mass(double t, const double *q, double *M, void *user)
{
  const stiff_chain *c = user;
  (void)t, (void)q;
  for (int i = 0; i < c->n; i++, M += 36)
    for (int j = 0; j < 3; j++) M[7 * j] = m, M[7 * (3 + j)] = J[j];
  return 0;
}

static int kinematics(double t, const double *q, const double *v, double *qdot, void *user)
{
  const stiff_chain *c = user;
  (void)t;
  for (int i = 0; i < c->n; i++, q += 7, v += 6, qdot += 7) {
    const double *p = q + 3, *w = v + 3;
    double turned[3];
    cross(p + 1, w, turned);
    qdot[3] = -(p[1] * w[0] + p[2] * w[1] + p[3] * w[2]) / 2;
    for (int j = 0; j < 3; j++) {
      qdot[j] = v[j];
      qdot[4 + j] = (p[0] * w[j] + turned[j]) / 2;
    }
  }
  return 0;
}

static int force(double t, const double *q, const double *v, double *F, void *user)
{
  const stiff_chain *c = user;
  double R[2][9], u[3], before[3] = {0};
  (void)t;
  for (int i = 0; i < c->n; i++) {
    const double *w = v + 6 * i + 3, momentum[3] = {J[0] * w[0], J[1] * w[1], J[2] * w[2]};
    double spin[3], torque[3];
    F[6 * i + 2] = -m * g;
    cross(momentum, w, spin);
    rotation(q + 7 * i + 3, R[i % 2]);
    turn(R[i % 2], w, u);
    double slip[3] = {u[0] - before[0], u[1] - before[1], u[2] - before[2]};
    memcpy(before, u, sizeof u);
    turn_back(R[i % 2], slip, torque);
    for (int j = 0; j < 3; j++) F[6 * i + 3 + j] += spin[j] - c->damping * torque[j];
    if (i == 0) continue;
    turn_back(R[1 - i % 2], slip, torque);
    for (int j = 0; j < 3; j++) F[6 * i - 3 + j] += c->damping * torque[j];
  }
  return 0;
}

/* ---- D and K: the torque on link a of a joint is -d (w_a - R_a^T R_b w_b), for either of its two
 */

static int joint_derivatives(const stiff_chain *c, int along_q, int a, int b, const double *R_a,
                             const double *R_b, const double *v, nsdae_block_list *list)
{
  double d = c->damping, X[2][36] = {{0}}, u[3], other[3] = {0};
  if (b >= 0) {
    turn(R_b, v + 6 * b + 3, u);
    turn_back(R_a, u, other); /* R_a^T R_b w_b */
  }
  for (int j = 0; j < 3; j++) {
    const double e[3] = {j == 0, j == 1, j == 2};
    double x[3], y[3];
    cross(e, other, x);
    for (int i = 0; i < 3; i++) X[0][3 + i + 6 * (3 + j)] = d * (along_q ? x[i] : e[i]);
    if (b < 0) continue;
    cross(e, v + 6 * b + 3, x);
    turn(R_b, along_q ? x : e, y);
    turn_back(R_a, y, x);
    for (int i = 0; i < 3; i++) X[1][3 + i + 6 * (3 + j)] = -d * x[i];
  }
  int code = nsdae_block_add(list, a, a, X[0]);
  return code || b < 0 ? code : nsdae_block_add(list, a, b, X[1]);
}

static int all_joints(const stiff_chain *c, int along_q, const double *q, const double *v,
                      nsdae_block_list *list)
{
  double R[2][9] = {{0}};
  int code = 0;
  for (int i = 0; i < c->n && !code; i++) {
    double *here = R[i % 2], *before = R[1 - i % 2];
    rotation(q + 7 * i + 3, here);
    code = joint_derivatives(c, along_q, i, i - 1, here, before, v, list);
    if (!code && i > 0) code = joint_derivatives(c, along_q, i - 1, i, before, here, v, list);
  }
  return code;
}

static int damping(double t, const double *q, const double *v, nsdae_block_list *list, void *user)
{
  const stiff_chain *c = user;
  int code = all_joints(c, 0, q, v, list);
  (void)t;
  for (int b = 0; b < c->n && !code; b++) { /* of the spin (J w) x w */
    const double *w = v + 6 * b + 3, momentum[3] = {J[0] * w[0], J[1] * w[1], J[2] * w[2]};
    double D[36] = {0};
    for (int j = 0; j < 3; j++) {
      const double e[3] = {j == 0, j == 1, j == 2}, Je[3] = {J[0] * e[0], J[1] * e[1], J[2] * e[2]};
      double first[3], second[3];
      cross(Je, w, first);
      cross(momentum, e, second);
      for (int i = 0; i < 3; i++) D[3 + i + 6 * (3 + j)] = -first[i] - second[i];
    }
    code = nsdae_block_add(list, b, b, D);
  }
  return code;
}

static int stiffness(double t, const double *q, const double *v, nsdae_block_list *list, void *user)
{
  (void)t;
  return all_joints(user, 1, q, v, list);
}

/* ---- joints */

static int constraint(double t, const double *q, double *phi, void *user)
{
  const stiff_chain *c = user;
  double end[3] = {0};
  (void)t;
  for (int i = 0; i < c->n; i++, q += 7) {
    double R[9];
    rotation(q + 3, R);
    for (int j = 0; j < 3; j++) {
      phi[3 * i + j] = q[j] - h * R[j] - end[j];
      end[j] = q[j] + h * R[j];
    }
  }
  return 0;
}

/* Row j of joint i: e_j . (v_i - h R_i (w_i x e_x)) - e_j . (v_i-1 + h R_i-1 (w_i-1 x e_x)) with
 * w x e_x = (0, w_z, -w_y) */
static int rows(double t, const double *q, nsdae_row_list *list, void *user)
{
  const stiff_chain *c = user;
  (void)t;
  for (int i = 0; i < c->n; i++)
    for (int j = 0; j < 3; j++)
      for (int b = i; b >= 0 && b >= i - 1; b--) {
        double R[9], row[6] = {0}, sign = b == i ? 1 : -1;
        rotation(q + 7 * b + 3, R);
        row[j] = sign;
        row[4] = h * R[6 + j];
        row[5] = -h * R[3 + j];
        int code = nsdae_row_add(list, 3 * i + j, b, row);
        if (code) return code;
      }
  return 0;
}

static int bias(double t, const double *q, const double *v, double *phi_t, double *omega,
                void *user)
{
  const stiff_chain *c = user;
  const double x[3] = {1, 0, 0};
  double before[3] = {0};
  (void)t, (void)phi_t;
  for (int i = 0; i < c->n; i++) {
    double R[9], first[3], second[3], there[3];
    rotation(q + 7 * i + 3, R);
    cross(v + 6 * i + 3, x, first);
    cross(v + 6 * i + 3, first, second);
    turn(R, second, there);
    for (int j = 0; j < 3; j++) omega[3 * i + j] = -h * (there[j] + before[j]);
    memcpy(before, there, sizeof there);
  }
  return 0;
}

nsdae_system *stiff_chain_system(stiff_chain *c, int derivatives)
{
  const nsdae_dims dims = {.nq = 7 * c->n, .nv = 6 * c->n, .m = 3 * c->n};
  nsdae_system *s = NULL;
  int *size = malloc(2 * (size_t)c->n * sizeof *size);
  if (!size || nsdae_system_create(&dims, &s, NULL) < 0) {
    free(size);
    return NULL;
  }
  for (int i = 0; i < c->n; i++) size[i] = 7, size[c->n + i] = 6;
  nsdae_system_set_user(s, c);
  nsdae_system_set_blocks(s, c->n, size, size + c->n);
  nsdae_system_set_mass_blocks(s, mass);
  nsdae_system_set_force(s, force);
  nsdae_system_set_kinematics(s, kinematics);
  nsdae_system_set_constraint(s, constraint);
  nsdae_system_set_constraint_rows(s, rows);
  nsdae_system_set_constraint_bias(s, bias);
  if (derivatives) nsdae_system_set_force_damping_blocks(s, damping);
  if (derivatives) nsdae_system_set_force_stiffness_blocks(s, stiffness);
  free(size);
  return s;
}

/* Link i with this quaternion at the end of those before it. */
static void append_link(const double p[4], double end[3], double *q)
{
  double R[9];
  memcpy(q + 3, p, 4 * sizeof *p);
  rotation(p, R);
  for (int j = 0; j < 3; j++) {
    q[j] = end[j] + h * R[j];
    end[j] += 2 * h * R[j];
  }
}

void stiff_chain_start(const stiff_chain *c, double *q, double *v)
{
  double end[3] = {0};
  for (int i = 0; i < c->n; i++) {
    double half = i % 2 ? 0.25 : -0.25,
           axis = 2.399963 * i; /* the golden angle: no two are alike */
    const double p[4] = {cos(half), 0, sin(half) * cos(axis), sin(half) * sin(axis)};
    append_link(p, end, q + 7 * i);
  }
  memset(v, 0, 6 * (size_t)c->n * sizeof *v);
}

/* ---- in the plane, by angles */

void stiff_chain_place(const stiff_chain *c, const double *theta, const double *rate, double *q,
                       double *v)
{
  double end[3] = {0}, velocity[2] = {0}; /* of the end: x, z */
  for (int i = 0; i < c->n; i++, v += 6) {
    const double p[4] = {cos(theta[i] / 2), 0, sin(theta[i] / 2), 0};
    append_link(p, end, q + 7 * i);
    double x = -h * sin(theta[i]) * rate[i], z = -h * cos(theta[i]) * rate[i];
    const double of_link[6] = {velocity[0] + x, 0, velocity[1] + z, 0, rate[i], 0};
    memcpy(v, of_link, sizeof of_link);
    velocity[0] += 2 * x;
    velocity[1] += 2 * z;
  }
}

/* a_ij = sum_k c_ki c_kj: the links beyond the outer of both, and that one */
static double lever(int n, int i, int j)
{
  int outer = i > j ? i : j;
  return h * h * ((i == j ? 1 : 2) + 4 * (n - 1 - outer));
}

/* x := A^-1 x, A [n x n] is destroyed: Cholesky */
static void solve(int n, double *A, double *x)
{
  for (int j = 0; j < n; j++)
    for (int i = j; i < n; i++) {
      double sum = A[i + j * n];
      for (int k = 0; k < j; k++) sum -= A[i + k * n] * A[j + k * n];
      A[i + j * n] = i == j ? sqrt(sum) : sum / A[j + j * n];
    }
  for (int i = 0; i < n; i++) {
    for (int k = 0; k < i; k++) x[i] -= A[i + k * n] * x[k];
    x[i] /= A[i + i * n];
  }
  for (int i = n - 1; i >= 0; i--) {
    for (int k = i + 1; k < n; k++) x[i] -= A[k + i * n] * x[k];
    x[i] /= A[i + i * n];
  }
}

void stiff_chain_accelerations(const stiff_chain *c, const double *theta, const double *rate,
                               double *theta_dd)
{
  int n = c->n;
  double *M = malloc((size_t)n * (size_t)n * sizeof *M);
  if (!M) abort();
  for (int i = 0; i < n; i++) {
    double below = i > 0 ? rate[i - 1] : 0;
    theta_dd[i] = m * g * h * (1 + 2 * (n - 1 - i)) * cos(theta[i]);
    theta_dd[i] -= c->damping * (rate[i] - below);
    if (i + 1 < n) theta_dd[i] += c->damping * (rate[i + 1] - rate[i]);
    for (int j = 0; j < n; j++) {
      M[i + j * n] = m * lever(n, i, j) * cos(theta[i] - theta[j]) + (i == j ? J[1] : 0);
      theta_dd[i] -= m * lever(n, i, j) * sin(theta[i] - theta[j]) * rate[j] * rate[j];
    }
  }
  solve(n, M, theta_dd);
  free(M);
}

void stiff_chain_swing(const stiff_chain *c, double T, long steps, double *theta, double *rate)
{
  static const double at[4] = {0, 0.5, 0.5, 1}, weight[4] = {1. / 6, 1. / 3, 1. / 3, 1. / 6};
  int n = c->n;
  double dt = T / (double)steps, *w = calloc(6 * (size_t)n, sizeof *w);
  if (!w) abort();
  double *there = w + 2 * n, *sum = w + 4 * n; /* w: theta', theta'' of the last stage */
  for (long step = 0; step < steps; step++) {
    memset(sum, 0, 2 * (size_t)n * sizeof *sum);
    for (int stage = 0; stage < 4; stage++) {
      double ahead = stage > 0 ? at[stage] * dt : 0;
      for (int i = 0; i < n; i++) {
        there[i] = theta[i] + ahead * w[i];
        there[n + i] = rate[i] + ahead * w[n + i];
      }
      memcpy(w, there + n, (size_t)n * sizeof *w);
      stiff_chain_accelerations(c, there, there + n, w + n);
      for (int i = 0; i < 2 * n; i++) sum[i] += weight[stage] * dt * w[i];
    }
    for (int i = 0; i < n; i++) theta[i] += sum[i], rate[i] += sum[n + i];
  }
  free(w);
}
