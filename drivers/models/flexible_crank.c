/* A slider crank with a flexible connecting rod (B. Simeon, Modelling a flexible slider crank
 * mechanism by a mixed system of DAEs and PDEs, Math. Modelling of Systems 2 (1996) 1; data of the
 * Test Set for IVP Solvers). q = [phi_1, phi_2, x_3, q_1 .. q_4]: angles of crank and rod from the
 * slot, place of the slider, deformation of the rod. The crank turns with constant velocity.
 *
 * A point x = s l_2 of the rod has the displacement u along it and w across it, by the first two
 * sines of bending and the quadratic polynomials with nodes at s = 1/2 and s = 1:
 *
 *   w = q_1 sin(pi s) + q_2 sin(2 pi s),   u = q_3 N_3 + q_4 N_4,   N_3 = 4 s (1 - s),
 *   N_4 = s (2 s - 1);   place: l_1 e(phi_1) + (x + u) e(phi_2) + w n(phi_2),   n = e'
 *
 * Over the rod with density rho and cross section b h (square, b = h):
 *
 *   c_1 q = int u,  c_2 q = int w,  c_12 q = int x u,  c_21 q = int x w,  q^T B q' = int u w' - w
 * u' M_q: q^T M_q q = rho int w^2 + axial rho int u^2,   K: E I int w_xx^2 + E A int u_x^2
 *
 * The consistent mass has axial = 1. The published problem and values have 15, because the factor
 * 1/15 of int N_i N_j = l_2 [8 1; 1 2] / 15 is missing there. With d = phi_1 - phi_2, S = sin d,
 * C = cos d, a = m_2 l_2 / 2 + rho c_1 q, b = rho c_2 q the kinetic energy is
 *
 *   T = (J_1 + m_2 l_1^2) phi_1'^2 / 2 + m_3 x_3'^2 / 2 + l_1 phi_1' phi_2' (C a + S b)
 *     + (J_2 + 2 rho c_12 q + q^T M_q q) phi_2'^2 / 2 + q'^T M_q q' / 2
 *     + rho l_1 phi_1' (C c_2 - S c_1) q' + rho phi_2' (c_21 q' + q^T B q')
 *
 * and Lagrange's equations give M and
 *
 *   F_1 = l_1 phi_2'^2 (C b - S a) - 2 rho l_1 phi_2' (C c_1 + S c_2) q'
 *   F_2 = l_1 phi_1'^2 (S a - C b) - 2 phi_2' (rho c_12 q' + q^T M_q q')
 *   F_q = phi_2'^2 (M_q q + rho c_12) + rho l_1 phi_1'^2 (C c_1 + S c_2) + 2 rho phi_2' B q' - K q
 *
 *   Phi = [l_1 sin phi_1 + l sin phi_2,  x_3 - l_1 cos phi_1 - l cos phi_2,  phi_1 - omega t],
 *   l = l_2 + q_4
 *
 * Nothing is damped; the natural frequencies of the rod are 1277, 5107, 6841 and 24613 rad/s. */
#include "flexible_crank.h"

#include <math.h>
#include <stddef.h>

#include "model_names.h"

static const double pi = 3.14159265358979323846;
static const double l_1 = 0.15, l_2 = 0.3, m_2 = 0.151104, m_3 = 0.075552, J_1 = 0.002727,
                    J_2 = 0.0045339259, E = 2e11, h = 0.008, rho = 7870;

/* rho c_1 .. rho c_21, rho B, M_q, K. */
typedef struct rod {
  double c_1[4], c_2[4], c_12[4], c_21[4], B[4][4], M[4][4], K[4][4];
} rod;

/* int s^n sin(pi s) = 2/pi, 1/pi, 1/pi - 4/pi^3 and int s^n sin(2 pi s) = 0, -1/(2 pi), -1/(2 pi)
 * for n = 0, 1, 2. */
static rod integrals(const flexible_crank *p)
{
  const double mass = rho * h * h * l_2, bend = E * pow(h, 4) / 12 / pow(l_2, 3) * pow(pi, 4) / 2;
  const double stretch = E * h * h / l_2 / 3, half = 4 / pow(pi, 3), end = 2 * half - 1 / pi;
  rod r = {.c_1 = {0, 0, mass * 2 / 3, mass / 6},
           .c_2 = {mass * 2 / pi},
           .c_12 = {0, 0, mass * l_2 / 3, mass * l_2 / 6},
           .c_21 = {mass * l_2 / pi, -mass * l_2 / (2 * pi)}};
  r.M[0][0] = r.M[1][1] = mass / 2;
  r.M[2][2] = p->axial * mass * 8 / 15;
  r.M[3][3] = p->axial * mass * 2 / 15;
  r.M[2][3] = r.M[3][2] = p->axial * mass / 15;
  r.K[0][0] = bend;
  r.K[1][1] = 16 * bend;
  r.K[2][2] = 16 * stretch;
  r.K[3][3] = 7 * stretch;
  r.K[2][3] = r.K[3][2] = -8 * stretch;
  r.B[0][2] = -mass * 4 * half;
  r.B[0][3] = mass * end;
  r.B[1][3] = mass / (2 * pi);
  for (int i = 0; i < 2; i++)
    for (int j = 2; j < 4; j++) r.B[j][i] = -r.B[i][j];
  return r;
}

static double dot(const double *x, const double *y)
{
  return x[0] * y[0] + x[1] * y[1] + x[2] * y[2] + x[3] * y[3];
}

static int mass(double t, const double *q, double *M, int ldm, void *user)
{
  const rod r = integrals(user);
  const double *deformed = q + 3, S = sin(q[0] - q[1]), C = cos(q[0] - q[1]);
  (void)t;
  M[0] = J_1 + m_2 * l_1 * l_1;
  M[1] = l_1 * (C * (m_2 * l_2 / 2 + dot(r.c_1, deformed)) + S * dot(r.c_2, deformed));
  M[ldm + 1] = J_2 + 2 * dot(r.c_12, deformed);
  M[2 * ldm + 2] = m_3;
  for (int i = 0; i < 4; i++) {
    M[3 + i] = l_1 * (C * r.c_2[i] - S * r.c_1[i]);
    M[ldm + 3 + i] = r.c_21[i] - dot(r.B[i], deformed);
    M[ldm + 1] += deformed[i] * dot(r.M[i], deformed);
    for (int j = 0; j < 4; j++) M[(3 + i) * ldm + 3 + j] = r.M[i][j];
  }
  for (int i = 1; i < 7; i++)
    for (int j = 0; j < i && j < 2; j++) M[i * ldm + j] = M[j * ldm + i];
  return 0;
}

static int force(double t, const double *q, const double *v, double *F, void *user)
{
  const rod r = integrals(user);
  const double *deformed = q + 3, *rate = v + 3, S = sin(q[0] - q[1]), C = cos(q[0] - q[1]);
  const double a = m_2 * l_2 / 2 + dot(r.c_1, deformed), b = dot(r.c_2, deformed);
  (void)t;
  F[0] = l_1 * v[1] * v[1] * (C * b - S * a) -
         2 * l_1 * v[1] * (C * dot(r.c_1, rate) + S * dot(r.c_2, rate));
  F[1] = l_1 * v[0] * v[0] * (S * a - C * b) - 2 * v[1] * dot(r.c_12, rate);
  for (int i = 0; i < 4; i++) {
    F[1] -= 2 * v[1] * rate[i] * dot(r.M[i], deformed);
    F[3 + i] = v[1] * v[1] * (dot(r.M[i], deformed) + r.c_12[i]) +
               l_1 * v[0] * v[0] * (C * r.c_1[i] + S * r.c_2[i]) + 2 * v[1] * dot(r.B[i], rate) -
               dot(r.K[i], deformed);
  }
  return 0;
}

static int potential(double t, const double *q, double *energy, void *user)
{
  const rod r = integrals(user);
  (void)t;
  *energy = 0;
  for (int i = 0; i < 4; i++) *energy += q[3 + i] * dot(r.K[i], q + 3) / 2;
  return 0;
}

static int constraint(double t, const double *q, double *phi, void *user)
{
  const flexible_crank *p = user;
  double l = l_2 + q[6];
  phi[0] = l_1 * sin(q[0]) + l * sin(q[1]);
  phi[1] = q[2] - l_1 * cos(q[0]) - l * cos(q[1]);
  phi[2] = q[0] - p->omega * t;
  return 0;
}

static int constraint_jacobian(double t, const double *q, double *J, int ldj, void *user)
{
  double l = l_2 + q[6];
  (void)t;
  (void)user;
  J[0] = l_1 * cos(q[0]);
  J[1] = l_1 * sin(q[0]);
  J[2] = 1;
  J[ldj] = l * cos(q[1]);
  J[ldj + 1] = l * sin(q[1]);
  J[2 * ldj + 1] = 1;
  J[6 * ldj] = sin(q[1]);
  J[6 * ldj + 1] = -cos(q[1]);
  return 0;
}

static int constraint_bias(double t, const double *q, const double *v, double *phi_t, double *omega,
                           void *user)
{
  const flexible_crank *p = user;
  double l = l_2 + q[6], crank = l_1 * v[0] * v[0], turn = l * v[1] * v[1], both = 2 * v[1] * v[6];
  (void)t;
  phi_t[2] = -p->omega;
  omega[0] = -crank * sin(q[0]) - turn * sin(q[1]) + both * cos(q[1]);
  omega[1] = crank * cos(q[0]) + turn * cos(q[1]) + both * sin(q[1]);
  return 0;
}

static const model_name names[] = {
    {NSDAE_NAME_COORDINATE, "phi_1", "rad"}, {NSDAE_NAME_COORDINATE, "phi_2", "rad"},
    {NSDAE_NAME_COORDINATE, "x_3", "m"},     {NSDAE_NAME_COORDINATE, "q_1", "m"},
    {NSDAE_NAME_COORDINATE, "q_2", "m"},     {NSDAE_NAME_COORDINATE, "q_3", "m"},
    {NSDAE_NAME_COORDINATE, "q_4", "m"},     {NSDAE_NAME_CONSTRAINT, "slot_y", "m"},
    {NSDAE_NAME_CONSTRAINT, "slot_x", "m"},  {NSDAE_NAME_CONSTRAINT, "motor", "rad"},
};

static int build(void *base, nsdae_system **system, nsdae_error *error)
{
  const nsdae_dims dims = {.nq = 7, .m = 3};
  int status = nsdae_system_create(&dims, system, error);
  if (status < 0) return status;
  nsdae_system_set_user(*system, base);
  MODEL_NAMES(*system, names);
  nsdae_system_set_mass(*system, mass);
  nsdae_system_set_force(*system, force);
  nsdae_system_set_constraint(*system, constraint);
  nsdae_system_set_constraint_jacobian(*system, constraint_jacobian);
  nsdae_system_set_constraint_bias(*system, constraint_bias);
  return nsdae_system_set_potential(*system, potential);
}

/* Close to the smooth motion, as published, in dead centre: deformation and its rate, and phi_2',
 * x_3, x_3' from the constraints. The published ones have nine digits. */
static void start(const void *base, double *q0, double *v0)
{
  const flexible_crank *p = base;
  q0[5] = .103339863e-4;
  q0[6] = .169327969e-4;
  q0[2] = l_1 + l_2 + q0[6];
  v0[0] = p->omega;
  v0[3] = .444896105;
  v0[4] = .463434311e-2;
  v0[5] = -.178591076e-5;
  v0[6] = -.268938672e-5;
  v0[1] = -l_1 * v0[0] / (l_2 + q0[6]);
  v0[2] = v0[6];
}

static const published_value values[] = {
#include "flexible_crank_end.inc"
};
const published flexible_crank_published = {0.1, (int)(sizeof values / sizeof *values), values};

/* They hold for the published parameters alone. */
static int is_published(const flexible_crank *p)
{
  return p->omega == 150 && p->axial == 15;
}

static int state(const void *base, int number, driver_state *out)
{
  return is_published(base) && published_state(&flexible_crank_published, number, out);
}

static void follow(void *base, const nsdae_record *record)
{
  flexible_crank *p = base;
  published_follow(&p->last, 7, record);
}

static void conclude(const void *base)
{
  const flexible_crank *p = base;
  if (is_published(p)) published_print(&flexible_crank_published, &p->last);
}

#define PIN_X "0.15*cos(phi_1)"
#define PIN_Y "0.15*sin(phi_1)"

static int bodies(const void *base, nsdae_trajectory *file, nsdae_error *error)
{
  const nsdae_body body[] = {
      {.name = "crank", .shape = NSDAE_SHAPE_SEGMENT, .size = {h}, .end = {PIN_X, PIN_Y}},
      {.name = "rod",
       .shape = NSDAE_SHAPE_SEGMENT,
       .size = {h},
       .position = {PIN_X, PIN_Y},
       .end = {"x_3", "0"}},
      {.name = "slider",
       .shape = NSDAE_SHAPE_BOX,
       .size = {6 * h, 4 * h, 4 * h},
       .position = {"x_3", "0"}},
  };
  (void)base;
  return nsdae_trajectory_set_bodies(file, 3, body, error);
}

static const char *remark(const void *base)
{
  (void)base;
  return "the motor does work: the energy balance is what it did";
}

#define AT(field) offsetof(flexible_crank, field)

static const nsdae_param entries[] = {
    {"omega", "rad/s", "angular velocity of the crank", NSDAE_PARAM_REAL, AT(omega), 150, -INFINITY,
     INFINITY, 0, NULL},
    {"axial", "1", "mass of axial deformation over the consistent one; published: 15",
     NSDAE_PARAM_REAL, AT(axial), 15, 0, INFINITY, NSDAE_OPEN_MIN, NULL},
};

static const nsdae_params table = {entries, (int)(sizeof entries / sizeof *entries)};
static flexible_crank parameters;

const driver_model flexible_crank_model = {.name = "flexible-crank",
                                           .summary =
                                               "a slider crank with a flexible connecting rod",
                                           .parameters = &table,
                                           .base = &parameters,
                                           .t_end = 0.1,
                                           .dt = 1e-4,
                                           .method = NSDAE_METHOD_EVENT,
                                           .build = build,
                                           .start = start,
                                           .remark = remark,
                                           .follow = follow,
                                           .conclude = conclude,
                                           .bodies = bodies,
                                           .state = state,
                                           .coordinates = 7};
