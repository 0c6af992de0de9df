/* A uniform rod that swings about one end and hits a stop at its lowest position (Zhang, Gu and
 * Sun, section 4.1). q = [x, y, theta]: its centre and its angle from the vertical.
 *
 *   M = diag(m, m, m L^2/12),  F = [0, -m g, 0]
 *   Phi = [x - (L/2) sin theta, y + (L/2) cos theta],  g_N = L sin theta */
#include "pendulum.h"

#include <math.h>
#include <stddef.h>

#include "model_names.h"
#include "outline.h"

static int mass(double t, const double *q, double *M, int ldm, void *user)
{
  const pendulum *p = user;
  (void)t;
  (void)q;
  M[0] = M[ldm + 1] = p->m;
  M[2 * ldm + 2] = p->m * p->L * p->L / 12;
  return 0;
}

static int force(double t, const double *q, const double *v, double *F, void *user)
{
  const pendulum *p = user;
  (void)t;
  (void)q;
  (void)v;
  F[1] = -p->m * p->g;
  return 0;
}

static int constraint(double t, const double *q, double *phi, void *user)
{
  const pendulum *p = user;
  (void)t;
  phi[0] = q[0] - p->L / 2 * sin(q[2]);
  phi[1] = q[1] + p->L / 2 * cos(q[2]);
  return 0;
}

static int constraint_jacobian(double t, const double *q, double *J, int ldj, void *user)
{
  const pendulum *p = user;
  (void)t;
  J[0] = J[ldj + 1] = 1;
  J[2 * ldj] = -p->L / 2 * cos(q[2]);
  J[2 * ldj + 1] = -p->L / 2 * sin(q[2]);
  return 0;
}

static int constraint_bias(double t, const double *q, const double *v, double *phi_t, double *omega,
                           void *user)
{
  const pendulum *p = user;
  (void)t;
  (void)phi_t;
  omega[0] = p->L / 2 * sin(q[2]) * v[2] * v[2];
  omega[1] = -p->L / 2 * cos(q[2]) * v[2] * v[2];
  return 0;
}

static int gap(double t, const double *q, double *g_N, void *user)
{
  const pendulum *p = user;
  (void)t;
  g_N[0] = p->L * sin(q[2]);
  return 0;
}

static int gap_normal(double t, const double *q, double *W, int ldw, void *user)
{
  const pendulum *p = user;
  (void)t;
  (void)ldw;
  W[2] = p->L * cos(q[2]);
  return 0;
}

static int contact_bias(double t, const double *q, double *w_n, double *w_t, void *user)
{
  (void)t;
  (void)q;
  (void)w_t;
  (void)user;
  w_n[0] = 0;
  return 0;
}

static int potential(double t, const double *q, double *energy, void *user)
{
  const pendulum *p = user;
  (void)t;
  *energy = p->m * p->g * q[1];
  return 0;
}

static const model_name names[] = {
    {NSDAE_NAME_COORDINATE, "x", "m"},       {NSDAE_NAME_COORDINATE, "y", "m"},
    {NSDAE_NAME_COORDINATE, "theta", "rad"}, {NSDAE_NAME_CONSTRAINT, "pivot_x", "m"},
    {NSDAE_NAME_CONSTRAINT, "pivot_y", "m"}, {NSDAE_NAME_CONTACT, "stop", "m"},
};

static int build(void *base, nsdae_system **system, nsdae_error *error)
{
  const pendulum *p = base;
  const nsdae_dims dims = {.nq = 3, .m = 2, .k = 1};
  int status = nsdae_system_create(&dims, system, error);
  if (status < 0) return status;
  nsdae_system_set_user(*system, base);
  MODEL_NAMES(*system, names);
  nsdae_system_set_mass(*system, mass);
  nsdae_system_set_force(*system, force);
  nsdae_system_set_constraint(*system, constraint);
  nsdae_system_set_constraint_jacobian(*system, constraint_jacobian);
  nsdae_system_set_constraint_bias(*system, constraint_bias);
  nsdae_system_set_gap(*system, gap);
  nsdae_system_set_gap_normal(*system, gap_normal);
  nsdae_system_set_contact_bias(*system, contact_bias);
  nsdae_system_set_potential(*system, potential);
  return nsdae_system_set_contact(*system, 0, 0, p->e_N, 0);
}

static void start(const void *base, double *q0, double *v0)
{
  const pendulum *p = base;
  (void)v0;
  q0[0] = p->L / 2 * sin(p->theta_0);
  q0[1] = -p->L / 2 * cos(p->theta_0);
  q0[2] = p->theta_0;
}

/* K(k) = pi / (2 M(1, sqrt(1 - k^2))) with the arithmetic-geometric mean M (Gauss; Abramowitz and
 * Stegun, 17.6), each round of which doubles the digits. */
static double quarter_period(double k)
{
  double a = 1, b = sqrt((1 - k) * (1 + k));
  if (b == 0) return INFINITY;
  for (int round = 0; round < 60 && fabs(a - b) > 1e-15 * a; round++) {
    double mean = (a + b) / 2;
    b = sqrt(a * b);
    a = mean;
  }
  return acos(-1) / (2 * a);
}

/* theta'' = -(3 g / 2 L) sin theta. A swing of amplitude theta_m from rest to the stop takes
 * sqrt(2 L / 3 g) K(k), k = sin(theta_m / 2) (Landau and Lifshitz, Mechanics, section 11); it
 * arrives with omega = k sqrt(6 g / L) and leaves with e_N omega, so with the amplitude e_N k.
 * The impulse at the tip is (m L^2 / 3) (1 + e_N) omega / L. */
static int exact(const void *base, int number, driver_exact *impact)
{
  const pendulum *p = base;
  double quarter = sqrt(2 * p->L / (3 * p->g)), k = sin(p->theta_0 / 2);
  double time = quarter * quarter_period(k);
  for (int i = 0; i < number; i++) {
    k *= p->e_N;
    time += 2 * quarter * quarter_period(k);
  }
  impact->time = time;
  impact->normal_impulse = p->m * p->L / 3 * (1 + p->e_N) * k * sqrt(6 * p->g / p->L);
  return k > 0;
}

/* The right face of the stop touches the left face of the hanging rod. */
static int bodies(const void *base, nsdae_trajectory *file, nsdae_error *error)
{
  const pendulum *p = base;
  double width = p->L / 20, rod[12], stop[12];
  outline_box(0, 0, width, p->L, rod);
  outline_box(-width, -p->L, width, 2 * width, stop);
  const nsdae_body body[] = {
      {.name = "pivot", .shape = NSDAE_SHAPE_DISC, .size = {width}},
      {.name = "stop", .shape = NSDAE_SHAPE_POLYGON, .points = OUTLINE_BOX, .point = stop},
      {.name = "rod",
       .shape = NSDAE_SHAPE_POLYGON,
       .points = OUTLINE_BOX,
       .point = rod,
       .position = {"x", "y"},
       .angle = "theta"},
  };
  return nsdae_trajectory_set_bodies(file, 3, body, error);
}

#define AT(field) offsetof(pendulum, field)

static const nsdae_param entries[] = {
    {"L", "m", "length of the rod", NSDAE_PARAM_REAL, AT(L), 1, 0, INFINITY, NSDAE_OPEN_MIN, NULL},
    {"m", "kg", "mass of the rod", NSDAE_PARAM_REAL, AT(m), 4.9, 0, INFINITY, NSDAE_OPEN_MIN, NULL},
    {"g", "m/s^2", "gravity", NSDAE_PARAM_REAL, AT(g), 9.8, 0, INFINITY, NSDAE_OPEN_MIN, NULL},
    {"e_N", "1", "restitution at the stop", NSDAE_PARAM_REAL, AT(e_N), 0.56, 0, 1, 0, NULL},
    {"theta_0", "rad", "angle at the start, from the vertical, at rest", NSDAE_PARAM_REAL,
     AT(theta_0), 1.57, 0, 3.1415926535897931, NSDAE_OPEN_MIN | NSDAE_OPEN_MAX, NULL},
};

static const nsdae_params table = {entries, (int)(sizeof entries / sizeof *entries)};
static pendulum parameters;

const driver_model pendulum_model = {.name = "pendulum",
                                     .summary = "a uniform rod that swings and hits a stop",
                                     .parameters = &table,
                                     .base = &parameters,
                                     .t_end = 7,
                                     .build = build,
                                     .start = start,
                                     .bodies = bodies,
                                     .exact = exact};
