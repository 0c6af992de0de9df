/* Andrews' squeezing mechanism: seven bodies in the plane that move one point P, driven by a motor
 * (Schiehlen, Multibody Systems Handbook, 1990; Hairer and Wanner, Solving Ordinary Differential
 * Equations II, section VII.7; data of the Test Set for IVP Solvers).
 *
 * q = [beta, Theta, gamma, phi, delta, Omega, epsilon]. P is the end of three chains of two links
 * and of one lever. With e(x) = (cos x, sin x), the chain i has the angle a of its first link and b
 * between the links; h_1, h_2 are quarter turns:
 *
 *   P = O_i + l_1 e(a + h_1) + l_2 e(a + b + h_2),   P = B + s e(gamma - pi/2)
 *   Phi = [P_1 - P_lever, P_1 - P_2, P_1 - P_3] = 0
 *
 * The second link has mass m and its centre in the distance c from the joint; A and B are moments
 * of inertia: A of the first link about O_i and of m at the joint, B of the second link about the
 * joint. The kinetic energy of a chain and its equations of motion (Lagrange) are
 *
 *   T = A a'^2 / 2 + B (a' + b')^2 / 2 + C a' (a' + b'),   C(b) = m l_1 c cos(b + h_2 - h_1)
 *   (A + B + 2 C) a'' + (B + C) b'' = Q_a - C_b b' (2 a' + b')
 *           (B + C) a'' +       B b'' = Q_b + C_b a'^2
 *
 * A spring pulls from D = B + sd e(gamma) + sc e(gamma - pi/2) to the fixed point C; the motor
 * turns beta by a constant torque, with potential -torque beta: the energy is conserved. */
#include "squeezer.h"

#include <math.h>
#include <stddef.h>

#include "model_names.h"

enum { BETA, THETA, GAMMA, PHI, DELTA, OMEGA, EPSILON, CHAINS = 3 };

typedef struct chain {
  int a, b;                /* coordinates */
  double x, y;             /* O_i */
  double l_1, l_2, c;      /* c from the joint, towards P if l_2 > 0 */
  int h_1, h_2;            /* quarter turns */
  double m, first, second; /* mass of the second link; A without m l_1^2; B without m c^2 */
} chain;

/* Masses [kg], centres and lengths [m], moments of inertia [kg m^2] of K1 and K2, K5 and K4, K7 and
 * K6 as published. */
static const chain chains[CHAINS] = {
    {BETA, THETA, 0, 0, 7e-3, 28e-3, 115e-4, 0, 2, .00365, .04325 * 92e-5 * 92e-5 + 2.194e-6,
     4.410e-7},
    {DELTA, PHI, -.06934, -.00227, 4e-2, 2e-2, 2e-2 - 1421e-5, 0, -1, .00706,
     .07050 * (2308e-5 * 2308e-5 + 916e-5 * 916e-5) + 1.169e-5, 5.667e-7},
    {EPSILON, OMEGA, -.06934, -.00227, 4e-2, 2e-2, 2e-2 - 1421e-5, -1, 0, .00706,
     .05498 * (1228e-5 * 1228e-5 + 449e-5 * 449e-5) + 1.912e-5, 5.667e-7},
};
/* Lever K3: its joint B and length s, the spring's end D on it, moment of inertia about B; point C.
 */
static const double B[2] = {-.03635, .03273}, s = 35e-3, sd = 2e-2, sc = 18e-3;
static const double lever = .02373 * (1874e-5 * 1874e-5 + 1043e-5 * 1043e-5) + 5.255e-6;
static const double C[2] = {14e-3, 72e-3};

/* e(x + quarters pi/2), without rounding of the quarter turns. */
static void direction(double x, int quarters, double e[2])
{
  const double c = cos(x), n = sin(x);
  const double values[4][2] = {{c, n}, {-n, c}, {-c, -n}, {n, -c}};
  e[0] = values[quarters & 3][0];
  e[1] = values[quarters & 3][1];
}

/* Directions of both links. */
static void directions(const chain *k, const double *q, double e_1[2], double e_2[2])
{
  direction(q[k->a], k->h_1, e_1);
  direction(q[k->a] + q[k->b], k->h_2, e_2);
}

/* C(b) and its derivative. */
static double coupling(const chain *k, const double *q, double *C_b)
{
  double e[2], factor = k->m * k->l_1 * k->c;
  direction(q[k->b], k->h_2 - k->h_1, e);
  *C_b = -factor * e[1];
  return factor * e[0];
}

static int mass(double t, const double *q, double *M, int ldm, void *user)
{
  (void)t;
  (void)user;
  for (const chain *k = chains; k < chains + CHAINS; k++) {
    double C_b, c = coupling(k, q, &C_b), second = k->second + k->m * k->c * k->c;
    M[k->a * ldm + k->a] = k->first + k->m * k->l_1 * k->l_1 + second + 2 * c;
    M[k->a * ldm + k->b] = M[k->b * ldm + k->a] = second + c;
    M[k->b * ldm + k->b] = second;
  }
  M[GAMMA * ldm + GAMMA] = lever;
  return 0;
}

/* C - D, and its derivative with respect to gamma. */
static double spring(const double *q, double vector[2], double derivative[2])
{
  double along[2], across[2];
  direction(q[GAMMA], 0, along);
  direction(q[GAMMA], -1, across);
  for (int i = 0; i < 2; i++) {
    vector[i] = C[i] - B[i] - sd * along[i] - sc * across[i];
    derivative[i] = sd * across[i] - sc * along[i];
  }
  return hypot(vector[0], vector[1]);
}

static int force(double t, const double *q, const double *v, double *F, void *user)
{
  const squeezer *p = user;
  double vector[2], derivative[2], length = spring(q, vector, derivative);
  (void)t;
  for (const chain *k = chains; k < chains + CHAINS; k++) {
    double C_b, a = v[k->a], b = v[k->b];
    coupling(k, q, &C_b);
    F[k->a] = -C_b * b * (2 * a + b);
    F[k->b] = C_b * a * a;
  }
  F[BETA] += p->torque;
  F[GAMMA] = -p->stiffness * (1 - p->rest / length) *
             (vector[0] * derivative[0] + vector[1] * derivative[1]);
  return 0;
}

static int potential(double t, const double *q, double *energy, void *user)
{
  const squeezer *p = user;
  double vector[2], derivative[2], longer = spring(q, vector, derivative) - p->rest;
  (void)t;
  *energy = p->stiffness * longer * longer / 2 - p->torque * q[BETA];
  return 0;
}

static int constraint(double t, const double *q, double *phi, void *user)
{
  double e_1[2], e_2[2], P[2];
  (void)t;
  (void)user;
  for (int k = 0; k < CHAINS; k++) {
    const chain *c = &chains[k];
    directions(c, q, e_1, e_2);
    for (int i = 0; i < 2; i++) {
      double end = (i == 0 ? c->x : c->y) + c->l_1 * e_1[i] + c->l_2 * e_2[i];
      if (k == 0)
        P[i] = end;
      else
        phi[2 * k + i] = P[i] - end;
    }
  }
  direction(q[GAMMA], -1, e_1);
  for (int i = 0; i < 2; i++) phi[i] = P[i] - B[i] - s * e_1[i];
  return 0;
}

/* e' is e turned by a quarter. */
static int constraint_jacobian(double t, const double *q, double *J, int ldj, void *user)
{
  double first[2], second[2];
  (void)t;
  (void)user;
  for (int k = 0; k < CHAINS; k++) {
    const chain *c = &chains[k];
    direction(q[c->a], c->h_1 + 1, first);
    direction(q[c->a] + q[c->b], c->h_2 + 1, second);
    for (int row = 0; row < 6; row++) {
      int i = row % 2;
      if (k > 0 && row / 2 != k) continue;
      double sign = k == 0 ? 1 : -1;
      J[c->a * ldj + row] = sign * (c->l_1 * first[i] + c->l_2 * second[i]);
      J[c->b * ldj + row] = sign * c->l_2 * second[i];
    }
  }
  direction(q[GAMMA], 0, first);
  for (int i = 0; i < 2; i++) J[GAMMA * ldj + i] = -s * first[i];
  return 0;
}

/* e'' = -e. */
static int constraint_bias(double t, const double *q, const double *v, double *phi_t, double *omega,
                           void *user)
{
  double e_1[2], e_2[2], P[2];
  (void)t;
  (void)phi_t;
  (void)user;
  for (int k = 0; k < CHAINS; k++) {
    const chain *c = &chains[k];
    double a = v[c->a], both = v[c->a] + v[c->b];
    directions(c, q, e_1, e_2);
    for (int i = 0; i < 2; i++) {
      double end = -c->l_1 * e_1[i] * a * a - c->l_2 * e_2[i] * both * both;
      if (k == 0)
        P[i] = end;
      else
        omega[2 * k + i] = P[i] - end;
    }
  }
  direction(q[GAMMA], -1, e_1);
  for (int i = 0; i < 2; i++) omega[i] = P[i] + s * e_1[i] * v[GAMMA] * v[GAMMA];
  return 0;
}

static const model_name names[] = {
    {NSDAE_NAME_COORDINATE, "beta", "rad"},    {NSDAE_NAME_COORDINATE, "theta", "rad"},
    {NSDAE_NAME_COORDINATE, "gamma", "rad"},   {NSDAE_NAME_COORDINATE, "phi", "rad"},
    {NSDAE_NAME_COORDINATE, "delta", "rad"},   {NSDAE_NAME_COORDINATE, "omega", "rad"},
    {NSDAE_NAME_COORDINATE, "epsilon", "rad"}, {NSDAE_NAME_CONSTRAINT, "lever_x", "m"},
    {NSDAE_NAME_CONSTRAINT, "lever_y", "m"},   {NSDAE_NAME_CONSTRAINT, "chain_2_x", "m"},
    {NSDAE_NAME_CONSTRAINT, "chain_2_y", "m"}, {NSDAE_NAME_CONSTRAINT, "chain_3_x", "m"},
    {NSDAE_NAME_CONSTRAINT, "chain_3_y", "m"},
};

static int build(void *base, nsdae_system **system, nsdae_error *error)
{
  const nsdae_dims dims = {.nq = 7, .m = 6};
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

/* At rest with Theta = 0; the other angles close the chains, as published. */
static void start(const void *base, double *q0, double *v0)
{
  static const double angles[] = {
      -0.0617138900142764496358948458001, 0,
      0.455279819163070380255912382449,   0.222668390165885884674473185609,
      0.487364979543842550225598953530,   -0.222668390165885884674473185609,
      1.23054744454982119249735015568};
  (void)base;
  (void)v0;
  for (size_t i = 0; i < sizeof angles / sizeof *angles; i++) q0[i] = angles[i];
}

static const published_value values[] = {
#include "squeezer_end.inc"
};
const published squeezer_published = {0.03, (int)(sizeof values / sizeof *values), values};

/* They hold for the published parameters alone. */
static int is_published(const squeezer *p)
{
  return p->torque == 0.033 && p->stiffness == 4530 && p->rest == 0.07785;
}

static int state(const void *base, int number, driver_state *out)
{
  return is_published(base) && published_state(&squeezer_published, number, out);
}

static void follow(void *base, const nsdae_record *record)
{
  squeezer *p = base;
  published_follow(&p->last, 7, record);
}

static void conclude(const void *base)
{
  const squeezer *p = base;
  if (is_published(p)) published_print(&squeezer_published, &p->last);
}

/* Expressions of the joints, for the segments. */
#define F_X "7e-3*cos(beta)"
#define F_Y "7e-3*sin(beta)"
#define P_X F_X "-28e-3*cos(beta+theta)"
#define P_Y F_Y "-28e-3*sin(beta+theta)"
#define G_X "-0.06934+4e-2*cos(delta)"
#define G_Y "-0.00227+4e-2*sin(delta)"
#define H_X "-0.06934+4e-2*sin(epsilon)"
#define H_Y "-0.00227-4e-2*cos(epsilon)"
#define D_X "-0.03635+2e-2*cos(gamma)+18e-3*sin(gamma)"
#define D_Y "0.03273+2e-2*sin(gamma)-18e-3*cos(gamma)"

static int bodies(const void *base, nsdae_trajectory *file, nsdae_error *error)
{
  enum { BODIES = 8 };
  static const struct {
    const char *name, *from[2], *to[2];
  } links[BODIES] = {
      {"K1", {"0", "0"}, {F_X, F_Y}},
      {"K2", {F_X, F_Y}, {P_X, P_Y}},
      {"K3", {"-0.03635", "0.03273"}, {P_X, P_Y}},
      {"K3, arm", {"-0.03635", "0.03273"}, {D_X, D_Y}},
      {"K4", {G_X, G_Y}, {P_X, P_Y}},
      {"K5", {"-0.06934", "-0.00227"}, {G_X, G_Y}},
      {"K6", {H_X, H_Y}, {P_X, P_Y}},
      {"K7", {"-0.06934", "-0.00227"}, {H_X, H_Y}},
  };
  nsdae_body body[BODIES];
  (void)base;
  for (int i = 0; i < BODIES; i++)
    body[i] = (nsdae_body){.name = links[i].name,
                           .shape = NSDAE_SHAPE_SEGMENT,
                           .size = {1e-3},
                           .position = {links[i].from[0], links[i].from[1]},
                           .end = {links[i].to[0], links[i].to[1]}};
  return nsdae_trajectory_set_bodies(file, BODIES, body, error);
}

#define AT(field) offsetof(squeezer, field)

static const nsdae_param entries[] = {
    {"torque", "N m", "constant torque of the motor", NSDAE_PARAM_REAL, AT(torque), 0.033,
     -INFINITY, INFINITY, 0, NULL},
    {"stiffness", "N/m", "stiffness of the spring", NSDAE_PARAM_REAL, AT(stiffness), 4530, 0,
     INFINITY, 0, NULL},
    {"rest", "m", "length of the spring without force", NSDAE_PARAM_REAL, AT(rest), 0.07785, 0,
     INFINITY, NSDAE_OPEN_MIN, NULL},
};

static const nsdae_params table = {entries, (int)(sizeof entries / sizeof *entries)};
static squeezer parameters;

const driver_model squeezer_model = {.name = "squeezer",
                                     .summary = "Andrews' squeezing mechanism of seven bodies",
                                     .parameters = &table,
                                     .base = &parameters,
                                     .t_end = 0.03,
                                     .dt = 1e-4,
                                     .method = NSDAE_METHOD_EVENT,
                                     .build = build,
                                     .start = start,
                                     .follow = follow,
                                     .conclude = conclude,
                                     .bodies = bodies,
                                     .state = state,
                                     .coordinates = 7};
