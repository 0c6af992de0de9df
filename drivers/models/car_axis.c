/* A car axis: a rod with two point masses M/2 on two springs, whose right foot moves over a bumpy
 * road (S. Schneider, 1994; Test Set for IVP Solvers). q = [x_l, y_l, x_r, y_r], the masses; the
 * left foot is the origin, the right one (x_b, y_b), in the distance L:
 *
 *   y_b = r sin(w t),   x_b = sqrt(L^2 - y_b^2)
 *   M/2 x'' = k (L_0 - l) (x - foot) / l + (0, -M g / 2) - Phi_q^T lambda,   l = |x - foot|
 *   Phi_1 = x_b x_l + y_b y_l           the left spring is perpendicular to the line of the feet
 *   Phi_2 = |x_l - x_r|^2 - L^2         the rod
 *
 * The first constraint depends on t. With b = (x_b, y_b), b' and b'':
 *
 *   Phi_1,t = b' x_l,   omega_1 = 2 b' x_l' + b'' x_l,   omega_2 = 2 |x_l' - x_r'|^2
 *   x_b' = -y_b y_b' / x_b,   x_b'' = -(y_b'^2 + y_b y_b'' + x_b'^2) / x_b
 *
 * Published with eps^2 = 1 / k: those equations are these times eps^2, and the sign of lambda is
 * the opposite. The road does work. */
#include "car_axis.h"

#include <math.h>
#include <stddef.h>

#include "model_names.h"

/* The right foot, its velocity and acceleration. */
static void foot(const car_axis *p, double t, double b[2], double b_t[2], double b_tt[2])
{
  b[1] = p->r * sin(p->omega * t);
  b_t[1] = p->r * p->omega * cos(p->omega * t);
  b_tt[1] = -p->omega * p->omega * b[1];
  b[0] = sqrt(p->L * p->L - b[1] * b[1]);
  b_t[0] = -b[1] * b_t[1] / b[0];
  b_tt[0] = -(b_t[1] * b_t[1] + b[1] * b_tt[1] + b_t[0] * b_t[0]) / b[0];
}

static int mass(double t, const double *q, double *M, int ldm, void *user)
{
  const car_axis *p = user;
  (void)t;
  (void)q;
  for (int i = 0; i < 4; i++) M[i * ldm + i] = p->M / 2;
  return 0;
}

static int force(double t, const double *q, const double *v, double *F, void *user)
{
  const car_axis *p = user;
  double b[2], b_t[2], b_tt[2];
  (void)v;
  foot(p, t, b, b_t, b_tt);
  for (int side = 0; side < 2; side++) {
    double x = q[2 * side] - side * b[0], y = q[2 * side + 1] - side * b[1];
    double pull = p->k * (p->L0 / hypot(x, y) - 1);
    F[2 * side] = pull * x;
    F[2 * side + 1] = pull * y - p->M * p->g / 2;
  }
  return 0;
}

static int potential(double t, const double *q, double *energy, void *user)
{
  const car_axis *p = user;
  double b[2], b_t[2], b_tt[2];
  foot(p, t, b, b_t, b_tt);
  *energy = 0;
  for (int side = 0; side < 2; side++) {
    double longer = hypot(q[2 * side] - side * b[0], q[2 * side + 1] - side * b[1]) - p->L0;
    *energy += p->k * longer * longer / 2 + p->M * p->g / 2 * q[2 * side + 1];
  }
  return 0;
}

static int constraint(double t, const double *q, double *phi, void *user)
{
  const car_axis *p = user;
  double b[2], b_t[2], b_tt[2], x = q[0] - q[2], y = q[1] - q[3];
  foot(p, t, b, b_t, b_tt);
  phi[0] = b[0] * q[0] + b[1] * q[1];
  phi[1] = x * x + y * y - p->L * p->L;
  return 0;
}

static int constraint_jacobian(double t, const double *q, double *J, int ldj, void *user)
{
  double b[2], b_t[2], b_tt[2];
  foot(user, t, b, b_t, b_tt);
  for (int i = 0; i < 2; i++) {
    J[i * ldj] = b[i];
    J[i * ldj + 1] = 2 * (q[i] - q[2 + i]);
    J[(2 + i) * ldj + 1] = -J[i * ldj + 1];
  }
  return 0;
}

static int constraint_bias(double t, const double *q, const double *v, double *phi_t, double *omega,
                           void *user)
{
  double b[2], b_t[2], b_tt[2], x = v[0] - v[2], y = v[1] - v[3];
  foot(user, t, b, b_t, b_tt);
  phi_t[0] = b_t[0] * q[0] + b_t[1] * q[1];
  omega[0] = 2 * (b_t[0] * v[0] + b_t[1] * v[1]) + b_tt[0] * q[0] + b_tt[1] * q[1];
  omega[1] = 2 * (x * x + y * y);
  return 0;
}

static const model_name names[] = {
    {NSDAE_NAME_COORDINATE, "x_l", "m"},           {NSDAE_NAME_COORDINATE, "y_l", "m"},
    {NSDAE_NAME_COORDINATE, "x_r", "m"},           {NSDAE_NAME_COORDINATE, "y_r", "m"},
    {NSDAE_NAME_CONSTRAINT, "right_angle", "m^2"}, {NSDAE_NAME_CONSTRAINT, "rod", "m^2"},
};

static int build(void *base, nsdae_system **system, nsdae_error *error)
{
  const nsdae_dims dims = {.nq = 4, .m = 2};
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

/* Both springs upright without force; Phi_1' = 0 gives x_l' = -r w L_0 / L. */
static void start(const void *base, double *q0, double *v0)
{
  const car_axis *p = base;
  q0[1] = q0[3] = p->L0;
  q0[2] = p->L;
  v0[0] = v0[2] = -p->r * p->omega * p->L0 / p->L;
}

static const published_value values[] = {
#include "car_axis_end.inc"
};
const published car_axis_published = {3, (int)(sizeof values / sizeof *values), values};

/* They hold for the published parameters alone. */
static int is_published(const car_axis *p)
{
  return p->M == 10 && p->k == 1e4 && p->L == 1 && p->L0 == 0.5 && p->r == 0.1 && p->omega == 10 &&
         p->g == 1;
}

static int state(const void *base, int number, driver_state *out)
{
  return is_published(base) && published_state(&car_axis_published, number, out);
}

static void follow(void *base, const nsdae_record *record)
{
  car_axis *p = base;
  published_follow(&p->last, 4, record);
}

static void conclude(const void *base)
{
  const car_axis *p = base;
  if (is_published(p)) published_print(&car_axis_published, &p->last);
}

#define FOOT_Y "r*sin(omega*t)"
#define FOOT_X "sqrt(L^2-(" FOOT_Y ")^2)"

static int bodies(const void *base, nsdae_trajectory *file, nsdae_error *error)
{
  const car_axis *p = base;
  const double width = p->L / 40;
  const nsdae_body body[] = {
      {.name = "left spring", .shape = NSDAE_SHAPE_SEGMENT, .size = {width}, .end = {"x_l", "y_l"}},
      {.name = "right spring",
       .shape = NSDAE_SHAPE_SEGMENT,
       .size = {width},
       .position = {FOOT_X, FOOT_Y},
       .end = {"x_r", "y_r"}},
      {.name = "axis",
       .shape = NSDAE_SHAPE_SEGMENT,
       .size = {2 * width},
       .position = {"x_l", "y_l"},
       .end = {"x_r", "y_r"}},
  };
  return nsdae_trajectory_set_bodies(file, 3, body, error);
}

static const char *remark(const void *base)
{
  (void)base;
  return "the road does work: the energy balance is what it did";
}

#define AT(field) offsetof(car_axis, field)

static const nsdae_param entries[] = {
    {"M", "kg", "mass of the car", NSDAE_PARAM_REAL, AT(M), 10, 0, INFINITY, NSDAE_OPEN_MIN, NULL},
    {"k", "N/m", "stiffness of a spring", NSDAE_PARAM_REAL, AT(k), 1e4, 0, INFINITY, 0, NULL},
    {"L", "m", "length of the axis, distance of the feet", NSDAE_PARAM_REAL, AT(L), 1, 0, INFINITY,
     NSDAE_OPEN_MIN, NULL},
    {"L0", "m", "length of a spring without force", NSDAE_PARAM_REAL, AT(L0), 0.5, 0, INFINITY,
     NSDAE_OPEN_MIN, NULL},
    {"r", "m", "amplitude of the road, less than L", NSDAE_PARAM_REAL, AT(r), 0.1, 0, INFINITY, 0,
     NULL},
    {"omega", "rad/s", "angular frequency of the road", NSDAE_PARAM_REAL, AT(omega), 10, 0,
     INFINITY, 0, NULL},
    {"g", "m/s^2", "gravity", NSDAE_PARAM_REAL, AT(g), 1, 0, INFINITY, 0, NULL},
};

static const nsdae_params table = {entries, (int)(sizeof entries / sizeof *entries)};
static car_axis parameters;

const driver_model car_axis_model = {.name = "car-axis",
                                     .summary = "a car axis on a bumpy road",
                                     .parameters = &table,
                                     .base = &parameters,
                                     .t_end = 3,
                                     .dt = 0.01,
                                     .method = NSDAE_METHOD_EVENT,
                                     .build = build,
                                     .start = start,
                                     .remark = remark,
                                     .follow = follow,
                                     .conclude = conclude,
                                     .bodies = bodies,
                                     .state = state,
                                     .coordinates = 4};
