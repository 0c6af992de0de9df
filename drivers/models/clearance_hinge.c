/* A rod whose hinge has play: a shaft of radius r, fixed to the rod's end, moves in a hole of
 * radius R (Zhang, Gu and Sun, section 4.2). q = [x, y, theta]: the rod's centre and its angle from
 * the negative y axis; the shaft's centre, from the hole's, is
 *
 *   O1 = (x - (l/2) sin theta, y + (l/2) cos theta),   n = O1 / |O1|,   t = (-n_y, n_x)
 *   g_N = (R - r) - |O1|
 *   v_T = t . O1' + r theta'       slip = surface_slip: the slip of the two surfaces
 *   v_T = R t . O1' / |O1|         slip = hinge_angle: the source's g_T = R phi */
#include "clearance_hinge.h"

#include <math.h>
#include <stddef.h>

typedef struct direction {
  double x, y, distance; /* n and |O1| */
} direction;

/* In the hole's centre every direction is as good: the gap is open there. */
static direction shaft(const clearance_hinge *p, const double *q)
{
  double x = q[0] - p->l / 2 * sin(q[2]), y = q[1] + p->l / 2 * cos(q[2]);
  double distance = hypot(x, y);
  if (distance == 0) return (direction){1, 0, 0};
  return (direction){x / distance, y / distance, distance};
}

static int mass(double t, const double *q, double *M, int ldm, void *user)
{
  const clearance_hinge *p = user;
  (void)t;
  (void)q;
  M[0] = M[ldm + 1] = p->m;
  M[2 * ldm + 2] = p->m * p->l * p->l / 12;
  return 0;
}

static int force(double t, const double *q, const double *v, double *F, void *user)
{
  const clearance_hinge *p = user;
  (void)t;
  (void)q;
  (void)v;
  F[1] = -p->m * p->g;
  return 0;
}

static int gap(double t, const double *q, double *g_N, void *user)
{
  const clearance_hinge *p = user;
  (void)t;
  g_N[0] = p->R - p->r - shaft(p, q).distance;
  return 0;
}

static int gap_normal(double t, const double *q, double *W, int ldw, void *user)
{
  const clearance_hinge *p = user;
  direction n = shaft(p, q);
  (void)t;
  (void)ldw;
  W[0] = -n.x;
  W[1] = -n.y;
  W[2] = p->l / 2 * (n.x * cos(q[2]) + n.y * sin(q[2]));
  return 0;
}

static int gap_tangent(double t, const double *q, double *W, int ldw, void *user)
{
  const clearance_hinge *p = user;
  direction n = shaft(p, q);
  double scale = p->slip == SURFACE_SLIP ? 1 : n.distance > 0 ? p->R / n.distance : 0;
  (void)t;
  (void)ldw;
  W[0] = -n.y * scale;
  W[1] = n.x * scale;
  W[2] = p->l / 2 * (n.y * cos(q[2]) - n.x * sin(q[2])) * scale;
  if (p->slip == SURFACE_SLIP) W[2] += p->r;
  return 0;
}

static int contact_bias(double t, const double *q, double *w_n, double *w_t, void *user)
{
  (void)t;
  (void)q;
  (void)user;
  w_n[0] = w_t[0] = 0;
  return 0;
}

static int potential(double t, const double *q, double *energy, void *user)
{
  const clearance_hinge *p = user;
  (void)t;
  *energy = p->m * p->g * q[1];
  return 0;
}

static int build(void *base, nsdae_system **system, nsdae_error *error)
{
  const clearance_hinge *p = base;
  const nsdae_dims dims = {.nq = 3, .k = 1, .nt = 1};
  int status = nsdae_system_create(&dims, system, error);
  if (status < 0) return status;
  nsdae_system_set_user(*system, base);
  nsdae_system_set_mass(*system, mass);
  nsdae_system_set_force(*system, force);
  nsdae_system_set_gap(*system, gap);
  nsdae_system_set_gap_normal(*system, gap_normal);
  nsdae_system_set_gap_tangent(*system, gap_tangent);
  nsdae_system_set_contact_bias(*system, contact_bias);
  nsdae_system_set_potential(*system, potential);
  return nsdae_system_set_contact(*system, 0, p->mu, p->e_N, p->e_T);
}

static void start(const void *base, double *q0, double *v0)
{
  const clearance_hinge *p = base;
  (void)v0;
  q0[0] = p->dX + p->l / 2 * sin(p->theta_0);
  q0[1] = p->dY - p->l / 2 * cos(p->theta_0);
  q0[2] = p->theta_0;
}

#define AT(field) offsetof(clearance_hinge, field)

static const char *const slips[] = {"surface_slip", "hinge_angle", NULL};

static const nsdae_param entries[] = {
    {"l", "m", "length of the rod", NSDAE_PARAM_REAL, AT(l), 0.5, 0, INFINITY, NSDAE_OPEN_MIN,
     NULL},
    {"m", "kg", "mass of the rod", NSDAE_PARAM_REAL, AT(m), 6.817, 0, INFINITY, NSDAE_OPEN_MIN,
     NULL},
    {"R", "m", "radius of the hole", NSDAE_PARAM_REAL, AT(R), 0.030, 0, INFINITY, NSDAE_OPEN_MIN,
     NULL},
    {"r", "m", "radius of the shaft", NSDAE_PARAM_REAL, AT(r), 0.016, 0, INFINITY, NSDAE_OPEN_MIN,
     NULL},
    {"mu", "1", "friction", NSDAE_PARAM_REAL, AT(mu), 0.15, 0, INFINITY, 0, NULL},
    {"dX", "m", "shaft in the hole at the start", NSDAE_PARAM_REAL, AT(dX), 0.005, -INFINITY,
     INFINITY, 0, NULL},
    {"dY", "m", "shaft in the hole at the start", NSDAE_PARAM_REAL, AT(dY), 0, -INFINITY, INFINITY,
     0, NULL},
    {"theta_0", "rad", "angle at the start, at rest", NSDAE_PARAM_REAL, AT(theta_0), 1.571,
     -INFINITY, INFINITY, 0, NULL},
    {"e_N", "1", "normal restitution", NSDAE_PARAM_REAL, AT(e_N), 0.56, 0, 1, 0, NULL},
    {"e_T", "1", "tangential restitution", NSDAE_PARAM_REAL, AT(e_T), 0, 0, 1, 0, NULL},
    {"g", "m/s^2", "gravity", NSDAE_PARAM_REAL, AT(g), 9.8, 0, INFINITY, 0, NULL},
    {"slip", "", "what slides: the surfaces, or the hinge's angle", NSDAE_PARAM_CHOICE, AT(slip),
     SURFACE_SLIP, 0, 1, 0, slips},
};

static const nsdae_params table = {entries, (int)(sizeof entries / sizeof *entries)};
static clearance_hinge parameters;

const driver_model clearance_hinge_model = {.name = "clearance-hinge",
                                            .summary = "a rod on a hinge with play and friction",
                                            .parameters = &table,
                                            .base = &parameters,
                                            .t_end = 3,
                                            .build = build,
                                            .start = start};
