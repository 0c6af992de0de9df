/* A model with derivatives by hand: a planar body whose orientation is the unit vector (c, s), so
 * that nq = 4 and nv = 3; its constraints and gaps are nonlinear and depend on time.
 *
 *   q = [x, y, c, s],  v = [vx, vy, w],  dq/dt = [vx, vy, -s w, c w],  P = (x + a c, y + a s)
 *   Phi_0 = (P_x - sin t)^2 + 2 P_y^2 - 1 - t/10      P is on an ellipse that moves and grows
 *   Phi_1 = x c + y s + y sin t
 *   g_0   = 3 - cos t - P_x - P_y^2/10                a bent wall that moves
 *   g_1   = P_y - sin(P_x)/5 + t^2/2                  a wavy floor that sinks */
#ifndef NSDAE_TESTS_PLANAR_H
#define NSDAE_TESTS_PLANAR_H

#include <math.h>
#include <stddef.h>
#include <string.h>

#include <nsdae/system.h>

enum { PLANAR_NQ = 4, PLANAR_NV = 3, PLANAR_M = 2, PLANAR_K = 2 };

/* The user data: what is wrong. */
typedef struct planar {
  const char *term; /* e.g. "mass"; NULL: nothing */
  int entry;
  double amount; /* is added to that entry */
  int code;      /* is returned */
} planar;

#define PLANAR_ARM 0.4

static inline int planar_spoil(const void *user, const char *term, double *a)
{
  const planar *wrong = user;
  if (!wrong || !wrong->term || strcmp(wrong->term, term) != 0) return 0;
  a[wrong->entry] += wrong->amount;
  return wrong->code;
}

static inline double planar_px(const double *q)
{
  return q[0] + PLANAR_ARM * q[2];
}

static inline double planar_py(const double *q)
{
  return q[1] + PLANAR_ARM * q[3];
}

static inline int planar_kinematics(double t, const double *q, const double *v, double *qdot,
                                    void *user)
{
  (void)t;
  qdot[0] = v[0];
  qdot[1] = v[1];
  qdot[2] = -q[3] * v[2];
  qdot[3] = q[2] * v[2];
  return planar_spoil(user, "kinematics", qdot);
}

static inline int planar_mass(double t, const double *q, double *M, int ldm, void *user)
{
  (void)t;
  M[0] = 2;
  M[ldm + 1] = 3;
  M[2 * ldm + 2] = 0.5 + 0.1 * q[2];
  M[2] = M[2 * ldm] = -0.3 * q[3];
  return planar_spoil(user, "mass", M);
}

static inline int planar_force(double t, const double *q, const double *v, double *F, void *user)
{
  (void)t;
  (void)q;
  F[1] = -9.81 - 0.1 * v[1];
  return planar_spoil(user, "force", F);
}

/* -dF/dv, and -(dF/dq) H = 0 */
static inline int planar_damping(double t, const double *q, const double *v, double *D, int ldd,
                                 void *user)
{
  (void)t, (void)q, (void)v;
  D[ldd + 1] = 0.1;
  return planar_spoil(user, "force_damping", D);
}

static inline int planar_stiffness(double t, const double *q, const double *v, double *K, int ldk,
                                   void *user)
{
  (void)t, (void)q, (void)v, (void)ldk;
  return planar_spoil(user, "force_stiffness", K);
}

static inline int planar_constraint(double t, const double *q, double *phi, void *user)
{
  double X = planar_px(q) - sin(t), Y = planar_py(q);
  phi[0] = X * X + 2 * Y * Y - 1 - t / 10;
  phi[1] = q[0] * q[2] + q[1] * q[3] + q[1] * sin(t);
  return planar_spoil(user, "constraint", phi);
}

static inline int planar_jacobian(double t, const double *q, double *J, int ldj, void *user)
{
  const double a = PLANAR_ARM, *c = q + 2, *s = q + 3;
  double X = planar_px(q) - sin(t), Y = planar_py(q);
  J[0] = 2 * X;
  J[ldj] = 4 * Y;
  J[2 * ldj] = a * (4 * Y * *c - 2 * X * *s);
  J[1] = *c;
  J[ldj + 1] = *s + sin(t);
  J[2 * ldj + 1] = q[1] * *c - q[0] * *s;
  return planar_spoil(user, "constraint_jacobian", J);
}

static inline int planar_bias(double t, const double *q, const double *v, double *phi_t,
                              double *omega, void *user)
{
  const double a = PLANAR_ARM, c = q[2], s = q[3], w = v[2];
  double X = planar_px(q) - sin(t), Y = planar_py(q);
  double X1 = v[0] - a * s * w - cos(t), Y1 = v[1] + a * c * w; /* first derivatives */
  double X2 = -a * c * w * w + sin(t), Y2 = -a * s * w * w;     /* second, v constant */
  phi_t[0] = -2 * X * cos(t) - 0.1;
  phi_t[1] = q[1] * cos(t);
  /* Phi'' = omega: Phi_q v' = 0 with v constant, and both halves of Phi_tt are in X2 */
  omega[0] = 2 * X1 * X1 + 2 * X * X2 + 4 * Y1 * Y1 + 4 * Y * Y2;
  omega[1] = 2 * w * (v[1] * c - v[0] * s) - w * w * (q[0] * c + q[1] * s) + 2 * v[1] * cos(t) -
             q[1] * sin(t);
  int code = planar_spoil(user, "constraint_bias phi_t", phi_t);
  return code ? code : planar_spoil(user, "constraint_bias omega", omega);
}

static inline int planar_gap(double t, const double *q, double *g, void *user)
{
  double X = planar_px(q), Y = planar_py(q);
  g[0] = 3 - cos(t) - X - Y * Y / 10;
  g[1] = Y - sin(X) / 5 + t * t / 2;
  return planar_spoil(user, "gap", g);
}

static inline int planar_normal(double t, const double *q, double *W, int ldw, void *user)
{
  const double a = PLANAR_ARM, c = q[2], s = q[3];
  double X = planar_px(q), Y = planar_py(q);
  (void)t;
  W[0] = -1;
  W[1] = -Y / 5;
  W[2] = a * s - a * c * Y / 5;
  W[ldw] = -cos(X) / 5;
  W[ldw + 1] = 1;
  W[ldw + 2] = a * c + a * s * cos(X) / 5;
  return planar_spoil(user, "gap_normal", W);
}

static inline int planar_tangent(double t, const double *q, double *W, int ldw, void *user)
{
  (void)t;
  W[1] = 1;
  W[2] = PLANAR_ARM * q[2];
  W[ldw] = 1;
  W[ldw + 2] = -PLANAR_ARM * q[3];
  return planar_spoil(user, "gap_tangent", W);
}

static inline int planar_contact_bias(double t, const double *q, double *w_n, double *w_t,
                                      void *user)
{
  (void)q;
  w_n[0] = sin(t);
  w_n[1] = t;
  w_t[1] = 0.1 * t;
  return planar_spoil(user, "contact_bias w_n", w_n);
}

/* X1, Y1, X2, Y2 as in planar_bias but of P itself */
static inline int planar_acceleration(double t, const double *q, const double *v, double *omega_n,
                                      double *omega_t, double *omega_s, void *user)
{
  const double a = PLANAR_ARM, c = q[2], s = q[3], w = v[2];
  double X = planar_px(q), Y = planar_py(q), X1 = v[0] - a * s * w, Y1 = v[1] + a * c * w;
  double X2 = -a * c * w * w, Y2 = -a * s * w * w;
  (void)omega_s;
  omega_n[0] = cos(t) - X2 - (Y1 * Y1 + Y * Y2) / 5;
  omega_n[1] = Y2 + (sin(X) * X1 * X1 - cos(X) * X2) / 5 + 1;
  omega_t[0] = Y2;
  omega_t[1] = X2 + 0.1;
  return planar_spoil(user, "contact_acceleration", omega_n);
}

static inline int planar_potential(double t, const double *q, double *energy, void *user)
{
  (void)t;
  *energy = 9.81 * q[1];
  return planar_spoil(user, "potential", energy);
}

/* Everything given; wrong may be NULL. */
static inline nsdae_system *planar_system(planar *wrong)
{
  const nsdae_dims dims = {.nq = PLANAR_NQ, .nv = PLANAR_NV, .m = PLANAR_M, .k = PLANAR_K, .nt = 1};
  nsdae_system *s;
  if (nsdae_system_create(&dims, &s, NULL) < 0) return NULL;
  nsdae_system_set_user(s, wrong);
  nsdae_system_set_kinematics(s, planar_kinematics);
  nsdae_system_set_mass(s, planar_mass);
  nsdae_system_set_force(s, planar_force);
  nsdae_system_set_force_damping(s, planar_damping);
  nsdae_system_set_force_stiffness(s, planar_stiffness);
  nsdae_system_set_constraint(s, planar_constraint);
  nsdae_system_set_constraint_jacobian(s, planar_jacobian);
  nsdae_system_set_constraint_bias(s, planar_bias);
  nsdae_system_set_gap(s, planar_gap);
  nsdae_system_set_gap_normal(s, planar_normal);
  nsdae_system_set_gap_tangent(s, planar_tangent);
  nsdae_system_set_contact_bias(s, planar_contact_bias);
  nsdae_system_set_contact_acceleration(s, planar_acceleration);
  nsdae_system_set_potential(s, planar_potential);
  return s;
}

/* A point of the kind that a run meets, the i-th of many. */
static inline void planar_point(int i, double *t, double q[PLANAR_NQ], double v[PLANAR_NV])
{
  double angle = 0.7 * i;
  *t = 0.3 * (i % 7);
  q[0] = 2 * sin(1.1 * i);
  q[1] = 1.5 * cos(1.7 * i);
  q[2] = cos(angle);
  q[3] = sin(angle);
  v[0] = 3 * cos(0.9 * i);
  v[1] = 2 * sin(2.3 * i);
  v[2] = 4 * sin(0.5 * i + 1);
}

#endif
