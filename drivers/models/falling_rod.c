/* A rod of length 2 l that stands on the floor with one end, slides and falls (P. Painleve, 1895;
 * F. Genot and B. Brogliato, European Journal of Mechanics A 18, 1999). q = [x, y, phi]: its centre
 * and its angle from the floor; contact 0 is its first end, contact 1 its second.
 *
 *   M = diag(m, m, J),  F = [0, -m g, 0]
 *   g_N = y -+ l sin phi,   v_T = x' +- l sin phi phi'          (upper sign: the first end)
 *
 * With the first end on the floor, sliding in the direction s = sign v_T = +-1, friction is
 * -mu s lambda_N and the end's normal acceleration is
 *
 *   g_N'' = W_N^T M^-1 (W_N - mu s W_T) lambda_N + W_N^T M^-1 F + l sin phi phi'^2 = a lambda_N + b
 *   W_N = [0, 1, -l cos phi],  W_T = [1, 0, l sin phi]
 *   a = 1/m + (l^2 / J) cos phi (cos phi + mu s sin phi),   b = -g + l sin phi phi'^2
 *
 * Friction feeds the normal force where s sin phi cos phi < 0: for 0 < phi < pi / 2 when the end
 * slides away from under the centre, s = -1. A uniform rod, J = m l^2 / 3, has then
 *
 *   m a = 1 + 3 cos phi (cos phi - mu sin phi)
 *
 * which with t = tan phi is negative for mu > (4 + t^2) / (3 t), that is from mu = 4/3 on, at
 * tan phi = 2 (63.435 deg), and for mu = 5/3 between tan phi = 1 and 4 (45 and 75.964 deg).
 * If a < 0 and b < 0 there is no lambda_N >= 0. The end stops by an impact without collision, which
 * time-stepping methods include. If a < 0 and b > 0 there are two solutions, contact and
 * separation. */
#include "falling_rod.h"

#include <math.h>
#include <stddef.h>

#include "model_names.h"
#include "outline.h"

/* Of the first and of the second end, from the centre. */
static const double side[] = {-1, 1};

static int mass(double t, const double *q, double *M, int ldm, void *user)
{
  const falling_rod *p = user;
  (void)t;
  (void)q;
  M[0] = M[ldm + 1] = p->m;
  M[2 * ldm + 2] = p->J;
  return 0;
}

static int force(double t, const double *q, const double *v, double *F, void *user)
{
  const falling_rod *p = user;
  (void)t;
  (void)q;
  (void)v;
  F[1] = -p->m * p->g;
  return 0;
}

static int gap(double t, const double *q, double *g_N, void *user)
{
  const falling_rod *p = user;
  (void)t;
  for (int i = 0; i < 2; i++) g_N[i] = q[1] + side[i] * p->l * sin(q[2]);
  return 0;
}

static int gap_normal(double t, const double *q, double *W, int ldw, void *user)
{
  const falling_rod *p = user;
  (void)t;
  for (int i = 0; i < 2; i++) {
    W[i * ldw + 1] = 1;
    W[i * ldw + 2] = side[i] * p->l * cos(q[2]);
  }
  return 0;
}

static int gap_tangent(double t, const double *q, double *W, int ldw, void *user)
{
  const falling_rod *p = user;
  (void)t;
  for (int i = 0; i < 2; i++) {
    W[i * ldw] = 1;
    W[i * ldw + 2] = -side[i] * p->l * sin(q[2]);
  }
  return 0;
}

static int contact_bias(double t, const double *q, double *w_n, double *w_t, void *user)
{
  (void)t;
  (void)q;
  (void)user;
  for (int i = 0; i < 2; i++) w_n[i] = w_t[i] = 0;
  return 0;
}

static int contact_acceleration(double t, const double *q, const double *v, double *omega_n,
                                double *omega_t, double *omega_s, void *user)
{
  const falling_rod *p = user;
  (void)t;
  (void)omega_s;
  for (int i = 0; i < 2; i++) {
    omega_n[i] = -side[i] * p->l * sin(q[2]) * v[2] * v[2];
    omega_t[i] = -side[i] * p->l * cos(q[2]) * v[2] * v[2];
  }
  return 0;
}

static int potential(double t, const double *q, double *energy, void *user)
{
  const falling_rod *p = user;
  (void)t;
  *energy = p->m * p->g * q[1];
  return 0;
}

static const model_name names[] = {
    {NSDAE_NAME_COORDINATE, "x", "m"},       {NSDAE_NAME_COORDINATE, "y", "m"},
    {NSDAE_NAME_COORDINATE, "phi", "rad"},   {NSDAE_NAME_CONTACT, "first_end", "m"},
    {NSDAE_NAME_CONTACT, "second_end", "m"},
};

static int build(void *base, nsdae_system **system, nsdae_error *error)
{
  const falling_rod *p = base;
  const nsdae_dims dims = {.nq = 3, .k = 2, .nt = 1};
  int status = nsdae_system_create(&dims, system, error);
  if (status < 0) return status;
  nsdae_system_set_user(*system, base);
  MODEL_NAMES(*system, names);
  nsdae_system_set_mass(*system, mass);
  nsdae_system_set_force(*system, force);
  nsdae_system_set_gap(*system, gap);
  nsdae_system_set_gap_normal(*system, gap_normal);
  nsdae_system_set_gap_tangent(*system, gap_tangent);
  nsdae_system_set_contact_bias(*system, contact_bias);
  nsdae_system_set_contact_acceleration(*system, contact_acceleration);
  nsdae_system_set_potential(*system, potential);
  for (int i = 0; i < 2 && status == NSDAE_OK; i++)
    status = nsdae_system_set_contact(*system, i, p->mu, p->e_N, 0);
  return status;
}

/* The first end slides with v_T and has no normal velocity. */
static void start(const void *base, double *q0, double *v0)
{
  const falling_rod *p = base;
  q0[1] = p->l * sin(p->p0) + p->h;
  q0[2] = p->p0;
  v0[0] = p->v_T - p->l * sin(p->p0) * p->omega;
  v0[1] = p->l * cos(p->p0) * p->omega;
  v0[2] = p->omega;
}

double falling_rod_coefficient(const falling_rod *p, double phi, int slip)
{
  return 1 / p->m + p->l * p->l / p->J * cos(phi) * (cos(phi) + p->mu * slip * sin(phi));
}

double falling_rod_free(const falling_rod *p, double phi, double omega)
{
  return -p->g + p->l * sin(phi) * omega * omega;
}

static int bodies(const void *base, nsdae_trajectory *file, nsdae_error *error)
{
  const falling_rod *p = base;
  double rod[12];
  outline_box(0, 0, 2 * p->l, p->l / 40, rod);
  const nsdae_body body[] = {
      {.name = "floor", .shape = NSDAE_SHAPE_PLANE, .size = {0, 1, 0}},
      {.name = "rod",
       .shape = NSDAE_SHAPE_POLYGON,
       .points = OUTLINE_BOX,
       .point = rod,
       .position = {"x", "y"},
       .angle = "phi"},
  };
  return nsdae_trajectory_set_bodies(file, 2, body, error);
}

#define AT(field) offsetof(falling_rod, field)

static const nsdae_param entries[] = {
    {"m", "kg", "mass", NSDAE_PARAM_REAL, AT(m), 1, 0, INFINITY, NSDAE_OPEN_MIN, NULL},
    {"l", "m", "half the length", NSDAE_PARAM_REAL, AT(l), 1, 0, INFINITY, NSDAE_OPEN_MIN, NULL},
    {"J", "kg m^2", "inertia; m l^2 / 3 for a uniform rod", NSDAE_PARAM_REAL, AT(J), 1.0 / 3, 0,
     INFINITY, NSDAE_OPEN_MIN, NULL},
    {"g", "m/s^2", "gravity", NSDAE_PARAM_REAL, AT(g), 10, 0, INFINITY, 0, NULL},
    {"mu", "1", "friction", NSDAE_PARAM_REAL, AT(mu), 0.3, 0, INFINITY, 0, NULL},
    {"e_N", "1", "normal restitution", NSDAE_PARAM_REAL, AT(e_N), 0, 0, 1, 0, NULL},
    {"p0", "rad", "angle from the floor at the start", NSDAE_PARAM_REAL, AT(p0), 1, 0,
     3.1415926535897931, 0, NULL},
    {"v_T", "m/s", "slip of the lower end at the start; below 0 it feeds the normal force",
     NSDAE_PARAM_REAL, AT(v_T), -1, -INFINITY, INFINITY, 0, NULL},
    {"omega", "rad/s", "angular velocity at the start", NSDAE_PARAM_REAL, AT(omega), 0, -INFINITY,
     INFINITY, 0, NULL},
    {"h", "m", "height of the lower end at the start", NSDAE_PARAM_REAL, AT(h), 0, 0, INFINITY, 0,
     NULL},
};

static const nsdae_params table = {entries, (int)(sizeof entries / sizeof *entries)};
static falling_rod parameters;

const driver_model falling_rod_model = {.name = "falling-rod",
                                        .summary =
                                            "a rod that slides on the floor and falls (Painleve)",
                                        .parameters = &table,
                                        .base = &parameters,
                                        .t_end = 2,
                                        .dt = 1e-3,
                                        .build = build,
                                        .start = start,
                                        .bodies = bodies};
