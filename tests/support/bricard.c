/* Natural coordinates (J. Garcia de Jalon and E. Bayo, Kinematic and Dynamic Simulation of
 * Multibody Systems, 1994): the joints P_0 .. P_5 and their axes u_0 .. u_5, unit vectors, which
 * neighbouring rods share. P_0, P_5, u_0, u_5 belong to the ground; q = [P_1 .. P_4, u_1 .. u_4].
 * Rod k = 0 .. 4 has the axes u_k, u_(k+1) at right angles to d = P_(k+1) - P_k and to each other:
 *
 *   (|d|^2 - L^2) / 2 = 0,  d . u_k = 0,  d . u_(k+1) = 0,  u_k . u_(k+1) = 0      k = 0 .. 4
 *   (|u_k|^2 - 1) / 2 = 0                                                          k = 1 .. 4
 *
 * A point of the rod is (1-s) P_k + s P_(k+1) + y u_k + z u_(k+1), with s in 0 .. 1 and y, z in
 * -a/2 .. a/2, so that the mass matrix is constant: m/3 for each of its P, m/6 between them, and
 * m a^2 / 12 for each of its u.
 *
 * Every constraint is c + X . Y of two linear forms in q; what is fixed has no columns. */
#include "bricard.h"

#include <stddef.h>
#include <string.h>

enum { RODS = 5, JOINTS = 6, NQ = BRICARD_NQ };

/* P_i or u_i of q: the ground's from the table, which is of a cube with the edge L. */
static const double ground_point[JOINTS][3] = {[0] = {0, 0, 0}, [5] = {0, 0, 1}};
static const double ground_axis[JOINTS][3] = {[0] = {0, 1, 0}, [5] = {1, 0, 0}};

/* First column of P_i, u_i; -1 for the ground's. */
static int point_column(int i)
{
  return i == 0 || i == JOINTS - 1 ? -1 : 3 * (i - 1);
}

static int axis_column(int i)
{
  return i == 0 || i == JOINTS - 1 ? -1 : 12 + 3 * (i - 1);
}

static void get(const double *q, int column, const double *ground, double scale, double *x)
{
  for (int j = 0; j < 3; j++) x[j] = column < 0 ? scale * ground[j] : q[column + j];
}

/* d of rod k (k = 5: of the ground) and the axes; scale = 0 for velocities: the ground has none. */
static void rod(const bricard *p, const double *q, int k, double scale, double *d)
{
  double from[3], to[3];
  int next = (k + 1) % JOINTS;
  get(q, point_column(k), ground_point[k], scale * p->L, from);
  get(q, point_column(next), ground_point[next], scale * p->L, to);
  for (int j = 0; j < 3; j++) d[j] = to[j] - from[j];
}

static void axis(const double *q, int k, double scale, double *u)
{
  get(q, axis_column(k), ground_axis[k], scale, u);
}

static double dot(const double *x, const double *y)
{
  return x[0] * y[0] + x[1] * y[1] + x[2] * y[2];
}

/* The products of all constraints: scale = 1 of a position, 0 of a velocity. */
static void products(const bricard *p, const double *q, double scale, double *out)
{
  for (int k = 0; k < RODS; k++) {
    double d[3], u[3], w[3];
    rod(p, q, k, scale, d);
    axis(q, k, scale, u);
    axis(q, k + 1, scale, w);
    *out++ = dot(d, d) / 2;
    *out++ = dot(d, u);
    *out++ = dot(d, w);
    *out++ = dot(u, w);
    if (k > 0) *out++ = dot(u, u) / 2;
  }
}

static int constraint(double t, const double *q, double *phi, void *user)
{
  const bricard *p = user;
  int row = 0;
  (void)t;
  products(p, q, 1, phi);
  for (int k = 0; k < RODS; k++) {
    phi[row] -= p->L * p->L / 2;
    row += 4;
    if (k > 0) phi[row++] -= 0.5;
  }
  return 0;
}

/* Row += x along the columns of a point or an axis. */
static void add(double *J, int ldj, int row, int column, double scale, const double *x)
{
  for (int j = 0; j < 3 && column >= 0; j++) J[(column + j) * ldj + row] += scale * x[j];
}

/* Row += x . delta d of rod k. */
static void add_rod(double *J, int ldj, int row, int k, const double *x)
{
  add(J, ldj, row, point_column(k), -1, x);
  add(J, ldj, row, point_column(k + 1), 1, x);
}

static int jacobian(double t, const double *q, double *J, int ldj, void *user)
{
  const bricard *p = user;
  int row = 0;
  (void)t;
  for (int k = 0; k < RODS; k++) {
    double d[3], u[3], w[3];
    rod(p, q, k, 1, d);
    axis(q, k, 1, u);
    axis(q, k + 1, 1, w);
    add_rod(J, ldj, row++, k, d);
    add_rod(J, ldj, row, k, u);
    add(J, ldj, row++, axis_column(k), 1, d);
    add_rod(J, ldj, row, k, w);
    add(J, ldj, row++, axis_column(k + 1), 1, d);
    add(J, ldj, row, axis_column(k), 1, w);
    add(J, ldj, row++, axis_column(k + 1), 1, u);
    if (k > 0) add(J, ldj, row++, axis_column(k), 1, u);
  }
  return 0;
}

/* Second derivative along v of a product of two linear forms: twice their product at v. */
static int bias(double t, const double *q, const double *v, double *phi_t, double *omega,
                void *user)
{
  (void)t;
  (void)q;
  (void)phi_t;
  products(user, v, 0, omega);
  for (int i = 0; i < BRICARD_M; i++) omega[i] *= 2;
  return 0;
}

static void add_mass(double *M, int ldm, int row, int column, double value)
{
  for (int j = 0; j < 3 && row >= 0 && column >= 0; j++) M[(column + j) * ldm + row + j] += value;
}

static int mass(double t, const double *q, double *M, int ldm, void *user)
{
  const bricard *p = user;
  (void)t;
  (void)q;
  for (int k = 0; k < RODS; k++) {
    int P = point_column(k), Q = point_column(k + 1);
    add_mass(M, ldm, P, P, p->m / 3);
    add_mass(M, ldm, Q, Q, p->m / 3);
    add_mass(M, ldm, P, Q, p->m / 6);
    add_mass(M, ldm, Q, P, p->m / 6);
    for (int i = k; i < k + 2; i++)
      add_mass(M, ldm, axis_column(i), axis_column(i), p->m * p->a * p->a / 12);
  }
  return 0;
}

static int force(double t, const double *q, const double *v, double *F, void *user)
{
  const bricard *p = user;
  (void)t;
  (void)q;
  (void)v;
  for (int i = 1; i < JOINTS - 1; i++) F[point_column(i) + 1] = -p->m * p->g;
  return 0;
}

static int potential(double t, const double *q, double *energy, void *user)
{
  const bricard *p = user;
  (void)t;
  *energy = 0;
  for (int i = 1; i < JOINTS - 1; i++) *energy += p->m * p->g * q[point_column(i) + 1];
  return 0;
}

void bricard_mass(const bricard *p, double *M)
{
  bricard copy = *p;
  memset(M, 0, NQ * NQ * sizeof *M);
  mass(0, NULL, M, NQ, &copy);
}

void bricard_force(const bricard *p, double *F)
{
  bricard copy = *p;
  memset(F, 0, NQ * sizeof *F);
  force(0, NULL, NULL, F, &copy);
}

void bricard_jacobian(const bricard *p, const double *q, double *J)
{
  bricard copy = *p;
  memset(J, 0, NQ * BRICARD_M * sizeof *J);
  jacobian(0, q, J, BRICARD_M, &copy);
}

double bricard_cosine(const bricard *p, const double *q, int joint)
{
  double before[3], after[3];
  rod(p, q, (joint + RODS) % JOINTS, 1, before);
  rod(p, q, joint, 1, after);
  return dot(before, after) / (p->L * p->L);
}

void bricard_default(bricard *p)
{
  *p = (bricard){.L = 1, .m = 1, .a = 0.1, .g = 9.81};
}

nsdae_system *bricard_system(bricard *p)
{
  const nsdae_dims dims = {.nq = NQ, .m = BRICARD_M};
  nsdae_system *s;
  if (nsdae_system_create(&dims, &s, NULL) < 0) return NULL;
  nsdae_system_set_user(s, p);
  nsdae_system_set_mass(s, mass);
  nsdae_system_set_force(s, force);
  nsdae_system_set_constraint(s, constraint);
  nsdae_system_set_constraint_jacobian(s, jacobian);
  nsdae_system_set_constraint_bias(s, bias);
  nsdae_system_set_potential(s, potential);
  return s;
}

/* Along the edges x, -y, z, -x, y (and the ground -z); the axes are those of the third kind. */
void bricard_start(const bricard *p, double q0[NQ], double v0[NQ])
{
  static const double point[4][3] = {{1, 0, 0}, {1, -1, 0}, {1, -1, 1}, {0, -1, 1}};
  static const double axes[4][3] = {{0, 0, 1}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  for (int i = 0; i < 4; i++)
    for (int j = 0; j < 3; j++) {
      q0[3 * i + j] = p->L * point[i][j];
      q0[12 + 3 * i + j] = axes[i][j];
    }
  memset(v0, 0, NQ * sizeof *v0);
}
