/* A homogeneous ball that starts sliding and spinning on a plane and ends rolling.
 * q = [x, y, z, e_0, e]: its centre and the unit quaternion (e_0, e) of its orientation; v = [x',
 * y', z', w]: with the angular velocity w in the axes of space (Shabana, Dynamics of Multibody
 * Systems, section 2.6).
 *
 *   e_0' = -e . w / 2,  e' = (e_0 w + w x e) / 2
 *   M = diag(m, m, m, J, J, J),  J = 2 m r^2 / 5,  g_N = z - r
 *   v_T = (x' - r w_y, y' + r w_x)
 *
 * Friction acts at the contact, so (5 v + 2 r (w_y, -w_x)) / 7 never changes: it is the velocity of
 * the rolling that it ends in, after t = 2 |v_T| / (7 mu g). */
#include "rolling_ball.h"

#include <math.h>
#include <stddef.h>

#include "model_names.h"

static int mass(double t, const double *q, double *M, int ldm, void *user)
{
  const rolling_ball *p = user;
  (void)t;
  (void)q;
  for (int i = 0; i < 6; i++) M[i * ldm + i] = i < 3 ? p->m : 0.4 * p->m * p->r * p->r;
  return 0;
}

static int force(double t, const double *q, const double *v, double *F, void *user)
{
  const rolling_ball *p = user;
  (void)t;
  (void)q;
  (void)v;
  F[2] = -p->m * p->g;
  return 0;
}

static int kinematics(double t, const double *q, const double *v, double *qdot, void *user)
{
  const double *e = q + 4, *w = v + 3;
  (void)t;
  (void)user;
  for (int i = 0; i < 3; i++) {
    int j = (i + 1) % 3, k = (i + 2) % 3;
    qdot[i] = v[i];
    qdot[4 + i] = (q[3] * w[i] + w[j] * e[k] - w[k] * e[j]) / 2;
  }
  qdot[3] = -(e[0] * w[0] + e[1] * w[1] + e[2] * w[2]) / 2;
  return 0;
}

static int gap(double t, const double *q, double *g_N, void *user)
{
  const rolling_ball *p = user;
  (void)t;
  g_N[0] = q[2] - p->r;
  return 0;
}

static int gap_normal(double t, const double *q, double *W, int ldw, void *user)
{
  (void)t;
  (void)q;
  (void)ldw;
  (void)user;
  W[2] = 1;
  return 0;
}

static int gap_tangent(double t, const double *q, double *W, int ldw, void *user)
{
  const rolling_ball *p = user;
  (void)t;
  (void)q;
  W[0] = W[ldw + 1] = 1;
  W[4] = -p->r;
  W[ldw + 3] = p->r;
  return 0;
}

static int contact_bias(double t, const double *q, double *w_n, double *w_t, void *user)
{
  (void)t;
  (void)q;
  (void)user;
  w_n[0] = w_t[0] = w_t[1] = 0;
  return 0;
}

static int potential(double t, const double *q, double *energy, void *user)
{
  const rolling_ball *p = user;
  (void)t;
  *energy = p->m * p->g * q[2];
  return 0;
}

static const model_name names[] = {
    {NSDAE_NAME_COORDINATE, "x", "m"},     {NSDAE_NAME_COORDINATE, "y", "m"},
    {NSDAE_NAME_COORDINATE, "z", "m"},     {NSDAE_NAME_COORDINATE, "e_0", "1"},
    {NSDAE_NAME_COORDINATE, "e_x", "1"},   {NSDAE_NAME_COORDINATE, "e_y", "1"},
    {NSDAE_NAME_COORDINATE, "e_z", "1"},   {NSDAE_NAME_VELOCITY, "v_x", "m/s"},
    {NSDAE_NAME_VELOCITY, "v_y", "m/s"},   {NSDAE_NAME_VELOCITY, "v_z", "m/s"},
    {NSDAE_NAME_VELOCITY, "w_x", "rad/s"}, {NSDAE_NAME_VELOCITY, "w_y", "rad/s"},
    {NSDAE_NAME_VELOCITY, "w_z", "rad/s"}, {NSDAE_NAME_CONTACT, "plane", "m"},
};

static int build(void *base, nsdae_system **system, nsdae_error *error)
{
  const rolling_ball *p = base;
  const nsdae_dims dims = {.nq = 7, .nv = 6, .k = 1, .nt = 2};
  int status = nsdae_system_create(&dims, system, error);
  if (status < 0) return status;
  nsdae_system_set_user(*system, base);
  MODEL_NAMES(*system, names);
  nsdae_system_set_kinematics(*system, kinematics);
  nsdae_system_set_mass(*system, mass);
  nsdae_system_set_force(*system, force);
  nsdae_system_set_gap(*system, gap);
  nsdae_system_set_gap_normal(*system, gap_normal);
  nsdae_system_set_gap_tangent(*system, gap_tangent);
  nsdae_system_set_contact_bias(*system, contact_bias);
  nsdae_system_set_potential(*system, potential);
  return nsdae_system_set_contact(*system, 0, p->mu, 0, 0);
}

static void start(const void *base, double *q0, double *v0)
{
  const rolling_ball *p = base;
  q0[2] = p->r;
  q0[3] = 1;
  v0[0] = p->vx;
  v0[1] = p->vy;
  v0[3] = p->wx;
  v0[4] = p->wy;
}

static int bodies(const void *base, nsdae_trajectory *file, nsdae_error *error)
{
  const rolling_ball *p = base;
  const nsdae_body body[] = {
      {.name = "plane", .shape = NSDAE_SHAPE_PLANE, .size = {0, 0, 1}},
      {.name = "ball",
       .shape = NSDAE_SHAPE_SPHERE,
       .size = {p->r},
       .position = {"x", "y", "z"},
       .quaternion = {"e_0", "e_x", "e_y", "e_z"}},
  };
  return nsdae_trajectory_set_bodies(file, 2, body, error);
}

#define AT(field) offsetof(rolling_ball, field)

static const nsdae_param entries[] = {
    {"m", "kg", "mass", NSDAE_PARAM_REAL, AT(m), 0.17, 0, INFINITY, NSDAE_OPEN_MIN, NULL},
    {"r", "m", "radius", NSDAE_PARAM_REAL, AT(r), 0.028, 0, INFINITY, NSDAE_OPEN_MIN, NULL},
    {"g", "m/s^2", "gravity", NSDAE_PARAM_REAL, AT(g), 9.81, 0, INFINITY, 0, NULL},
    {"mu", "1", "friction", NSDAE_PARAM_REAL, AT(mu), 0.2, 0, INFINITY, 0, NULL},
    {"vx", "m/s", "velocity at the start", NSDAE_PARAM_REAL, AT(vx), 2, -INFINITY, INFINITY, 0,
     NULL},
    {"vy", "m/s", "velocity at the start", NSDAE_PARAM_REAL, AT(vy), 0, -INFINITY, INFINITY, 0,
     NULL},
    {"wx", "rad/s", "spin at the start", NSDAE_PARAM_REAL, AT(wx), 40, -INFINITY, INFINITY, 0,
     NULL},
    {"wy", "rad/s", "spin at the start", NSDAE_PARAM_REAL, AT(wy), -50, -INFINITY, INFINITY, 0,
     NULL},
};

static const nsdae_params table = {entries, (int)(sizeof entries / sizeof *entries)};
static rolling_ball parameters;

const driver_model rolling_ball_model = {.name = "rolling-ball",
                                         .summary = "a ball that slides, spins and ends rolling",
                                         .parameters = &table,
                                         .base = &parameters,
                                         .t_end = 1,
                                         .build = build,
                                         .start = start,
                                         .bodies = bodies};
