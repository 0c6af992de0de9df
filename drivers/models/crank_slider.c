/* A crank, a connecting rod and a slider that rubs in its slot (Zhang, Gu and Sun, section 4.3).
 * q = [theta_1, theta_2], both from the slot's axis; gravity acts along the slot, so that the
 * mechanism hangs. With c = cos(theta_1 - theta_2), s = sin(theta_1 - theta_2):
 *
 *   M11 = (m1/3 + m2 + m3) L1^2,  M22 = (m2/3 + m3) L2^2,  M12 = (m2/2 + m3) L1 L2 c
 *   h1 = Q1 - (m2/2 + m3) L1 L2 s theta_2'^2,  h2 = Q2 + (m2/2 + m3) L1 L2 s theta_1'^2
 *   Q1 = P0 sin(w t) - [(m1/2 + m2 + m3) g + k u] L1 sin theta_1
 *   Q2 =             - [(m2/2 + m3) g + k u] L2 sin theta_2
 *   u = L1 + L2 - L1 cos theta_1 - L2 cos theta_2   (the spring's elongation)
 *   Phi = L1 sin theta_1 + L2 sin theta_2 = 0       (the slot, with friction)
 *   v_T = L1 sin theta_1 theta_1' + L2 sin theta_2 theta_2'   (velocity of the slider)
 *
 * At theta = 0 (dead centre) W_S is zero: there is nothing that friction could act on. */
#include "crank_slider.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

#include "model_names.h"
#include "outline.h"

static int mass(double t, const double *q, double *M, int ldm, void *user)
{
  const crank_slider *p = user;
  (void)t;
  M[0] = (p->m1 / 3 + p->m2 + p->m3) * p->L1 * p->L1;
  M[ldm + 1] = (p->m2 / 3 + p->m3) * p->L2 * p->L2;
  M[1] = M[ldm] = (p->m2 / 2 + p->m3) * p->L1 * p->L2 * cos(q[0] - q[1]);
  return 0;
}

static double elongation(const crank_slider *p, const double *q)
{
  return p->L1 + p->L2 - p->L1 * cos(q[0]) - p->L2 * cos(q[1]);
}

static int force(double t, const double *q, const double *v, double *F, void *user)
{
  const crank_slider *p = user;
  double coupling = (p->m2 / 2 + p->m3) * p->L1 * p->L2 * sin(q[0] - q[1]);
  double spring = p->k * elongation(p, q);
  F[0] = p->P0 * sin(p->w * t) - ((p->m1 / 2 + p->m2 + p->m3) * p->g + spring) * p->L1 * sin(q[0]) -
         coupling * v[1] * v[1];
  F[1] = -((p->m2 / 2 + p->m3) * p->g + spring) * p->L2 * sin(q[1]) + coupling * v[0] * v[0];
  return 0;
}

static int constraint(double t, const double *q, double *phi, void *user)
{
  const crank_slider *p = user;
  (void)t;
  phi[0] = p->L1 * sin(q[0]) + p->L2 * sin(q[1]);
  return 0;
}

static int constraint_jacobian(double t, const double *q, double *J, int ldj, void *user)
{
  const crank_slider *p = user;
  (void)t;
  J[0] = p->L1 * cos(q[0]);
  J[ldj] = p->L2 * cos(q[1]);
  return 0;
}

static int constraint_bias(double t, const double *q, const double *v, double *phi_t, double *omega,
                           void *user)
{
  const crank_slider *p = user;
  (void)t;
  (void)phi_t;
  omega[0] = -p->L1 * sin(q[0]) * v[0] * v[0] - p->L2 * sin(q[1]) * v[1] * v[1];
  return 0;
}

static int frictional_joint_tangent(double t, const double *q, double *W, int ldw, double *w,
                                    void *user)
{
  const crank_slider *p = user;
  (void)t;
  (void)ldw;
  (void)w;
  W[0] = p->L1 * sin(q[0]);
  W[1] = p->L2 * sin(q[1]);
  return 0;
}

static int potential(double t, const double *q, double *energy, void *user)
{
  const crank_slider *p = user;
  double u = elongation(p, q);
  (void)t;
  *energy = -(p->m1 / 2 + p->m2 + p->m3) * p->g * p->L1 * cos(q[0]) -
            (p->m2 / 2 + p->m3) * p->g * p->L2 * cos(q[1]) + p->k * u * u / 2;
  return 0;
}

static const model_name names[] = {
    {NSDAE_NAME_COORDINATE, "theta_1", "rad"},
    {NSDAE_NAME_COORDINATE, "theta_2", "rad"},
    {NSDAE_NAME_CONSTRAINT, "slot", "m"},
    {NSDAE_NAME_FRICTIONAL_JOINT, "slot", "m"},
};

static int build(void *base, nsdae_system **system, nsdae_error *error)
{
  const crank_slider *p = base;
  const nsdae_dims dims = {.nq = 2, .m = 1, .f = 1};
  int status = nsdae_system_create(&dims, system, error);
  if (status < 0) return status;
  nsdae_system_set_user(*system, base);
  MODEL_NAMES(*system, names);
  nsdae_system_set_mass(*system, mass);
  nsdae_system_set_force(*system, force);
  nsdae_system_set_constraint(*system, constraint);
  nsdae_system_set_constraint_jacobian(*system, constraint_jacobian);
  nsdae_system_set_constraint_bias(*system, constraint_bias);
  nsdae_system_set_frictional_joint_tangent(*system, frictional_joint_tangent);
  nsdae_system_set_potential(*system, potential);
  return nsdae_system_set_frictional_joint(*system, 0, 0, p->mu);
}

/* data/crank_slider_states.csv: mu, t, theta_1, omega_1 of the parameters in data/. */
typedef struct reference {
  double mu, t, theta, omega;
} reference;

static const reference references[] = {
#include "crank_slider_states.inc"
};

/* The reference holds for the published parameters alone, with any of its mu. */
static int published(const crank_slider *p)
{
  crank_slider other;
  nsdae_params_default(crank_slider_model.parameters, &other);
  other.mu = p->mu;
  return memcmp(&other, p, sizeof other) == 0;
}

static int state(const void *base, int number, driver_state *out)
{
  const crank_slider *p = base;
  int found = 0;
  if (!published(p)) return 0;
  for (size_t i = 0; i < sizeof references / sizeof *references; i++) {
    const reference *r = &references[i];
    if (fabs(r->mu - p->mu) > 1e-12 || found++ != number) continue;
    *out = (driver_state){.time = r->t, .value = r->theta, .coordinate = 0};
    return 1;
  }
  return 0;
}

/* At rest in dead centre. */
static void start(const void *base, double *q0, double *v0)
{
  (void)base;
  (void)q0;
  (void)v0;
}

#define LENGTH(field, value, help)                                                          \
  {                                                                                         \
#field, "m", help, NSDAE_PARAM_REAL, offsetof(crank_slider, field), value, 0, INFINITY, \
        NSDAE_OPEN_MIN, NULL                                                                \
  }
#define MASS(field, value, help)                                                             \
  {                                                                                          \
#field, "kg", help, NSDAE_PARAM_REAL, offsetof(crank_slider, field), value, 0, INFINITY, \
        NSDAE_OPEN_MIN, NULL                                                                 \
  }

static int bodies(const void *base, nsdae_trajectory *file, nsdae_error *error)
{
  const crank_slider *p = base;
  double width = (p->L1 + p->L2) / 40, low = p->L1 + p->L2 + 3 * width, left[12], right[12];
  outline_box(-2 * width, p->L1 / 4 - low, width, p->L1 / 2, left);
  outline_box(2 * width, p->L1 / 4 - low, width, p->L1 / 2, right);
  static const char pin_x[] = "L1*sin(theta_1)", pin_y[] = "-L1*cos(theta_1)";
  static const char slider_x[] = "L1*sin(theta_1)+L2*sin(theta_2)",
                    slider_y[] = "-L1*cos(theta_1)-L2*cos(theta_2)";
  const nsdae_body body[] = {
      {.name = "left guide", .shape = NSDAE_SHAPE_POLYGON, .points = OUTLINE_BOX, .point = left},
      {.name = "right guide", .shape = NSDAE_SHAPE_POLYGON, .points = OUTLINE_BOX, .point = right},
      {.name = "crank", .shape = NSDAE_SHAPE_SEGMENT, .size = {width}, .end = {pin_x, pin_y}},
      {.name = "rod",
       .shape = NSDAE_SHAPE_SEGMENT,
       .size = {width},
       .position = {pin_x, pin_y},
       .end = {slider_x, slider_y}},
      {.name = "slider",
       .shape = NSDAE_SHAPE_BOX,
       .size = {3 * width, 4 * width, 3 * width},
       .position = {slider_x, slider_y}},
  };
  return nsdae_trajectory_set_bodies(file, 5, body, error);
}

static const nsdae_param entries[] = {
    LENGTH(L1, 1, "length of the crank"),
    LENGTH(L2, 2, "length of the connecting rod"),
    MASS(m1, 1, "mass of the crank"),
    MASS(m2, 2, "mass of the connecting rod"),
    MASS(m3, 1, "mass of the slider"),
    {"k", "N/m", "stiffness of the spring", NSDAE_PARAM_REAL, offsetof(crank_slider, k), 5, 0,
     INFINITY, 0, NULL},
    {"P0", "N m", "amplitude of the torque on the crank", NSDAE_PARAM_REAL,
     offsetof(crank_slider, P0), 10, -INFINITY, INFINITY, 0, NULL},
    {"w", "rad/s", "angular frequency of the torque", NSDAE_PARAM_REAL, offsetof(crank_slider, w),
     0.52359877559829887, 0, INFINITY, 0, NULL},
    {"g", "m/s^2", "gravity, along the slot", NSDAE_PARAM_REAL, offsetof(crank_slider, g), 9.8, 0,
     INFINITY, 0, NULL},
    {"mu", "1", "friction of the slider in its slot", NSDAE_PARAM_REAL, offsetof(crank_slider, mu),
     0.3, 0, INFINITY, 0, NULL},
};

static const char *remark(const void *base)
{
  const crank_slider *p = base;
  return p->P0 != 0 ? "the torque on the crank does work: the energy balance is what it did" : NULL;
}

static const nsdae_params table = {entries, (int)(sizeof entries / sizeof *entries)};
static crank_slider parameters;

const driver_model crank_slider_model = {.name = "crank-slider",
                                         .summary = "a driven crank whose slider sticks and slips",
                                         .parameters = &table,
                                         .base = &parameters,
                                         .t_end = 12,
                                         .build = build,
                                         .start = start,
                                         .remark = remark,
                                         .bodies = bodies,
                                         .state = state,
                                         .coordinates = 1};
