/* A block on an incline, in space: q = [x, y, z] along and normal to the plane, which falls by the
 * angle slope in the direction at the angle turn from x.
 *
 *   F = m g (sin slope cos turn, sin slope sin turn, -cos slope),  g_N = z,  v_T = (x', y')
 *
 * With tan slope < mu it sticks. A friction polygon of p edges (polygon = p) sticks up to tan slope
 * = mu cos(pi / p) in every direction, and up to mu along an edge direction. */
#include "incline.h"

#include <math.h>
#include <stddef.h>
#include <stdio.h>

#include "model_names.h"

static int mass(double t, const double *q, double *M, int ldm, void *user)
{
  const incline *p = user;
  (void)t;
  (void)q;
  for (int i = 0; i < 3; i++) M[i * ldm + i] = p->m;
  return 0;
}

static int force(double t, const double *q, const double *v, double *F, void *user)
{
  const incline *p = user;
  (void)t;
  (void)q;
  (void)v;
  F[0] = p->m * p->g * sin(p->slope) * cos(p->turn);
  F[1] = p->m * p->g * sin(p->slope) * sin(p->turn);
  F[2] = -p->m * p->g * cos(p->slope);
  return 0;
}

static int gap(double t, const double *q, double *g_N, void *user)
{
  (void)t;
  (void)user;
  g_N[0] = q[2];
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
  (void)t;
  (void)q;
  (void)user;
  W[0] = W[ldw + 1] = 1;
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
  const incline *p = user;
  double down = cos(p->turn) * q[0] + sin(p->turn) * q[1];
  (void)t;
  *energy = p->m * p->g * (cos(p->slope) * q[2] - sin(p->slope) * down);
  return 0;
}

static const model_name names[] = {
    {NSDAE_NAME_COORDINATE, "x", "m"},
    {NSDAE_NAME_COORDINATE, "y", "m"},
    {NSDAE_NAME_COORDINATE, "z", "m"},
    {NSDAE_NAME_CONTACT, "plane", "m"},
};

static int build(void *base, nsdae_system **system, nsdae_error *error)
{
  const incline *p = base;
  const nsdae_dims dims = {.nq = 3, .k = 1, .nt = 2};
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
  nsdae_system_set_potential(*system, potential);
  return nsdae_system_set_contact(*system, 0, p->mu, 0, 0);
}

static void start(const void *base, double *q0, double *v0)
{
  const incline *p = base;
  (void)q0;
  v0[0] = p->vx;
  v0[1] = p->vy;
}

/* In space, with z upwards: the plane's axes turned by the slope about the horizontal line in it.
 * How far the block is along the fall line, along the level line and off the plane: */
#define ALONG  "(x*cos(turn)+y*sin(turn))"
#define ACROSS "(y*cos(turn)-x*sin(turn))"
#define ABOVE  "(z+%g)"

/* A block of a size for the eye. */
static int bodies(const void *base, nsdae_trajectory *file, nsdae_error *error)
{
  const incline *p = base;
  double way = p->g > 0 ? (p->vx * p->vx + p->vy * p->vy) / p->g : 0, size = fmax(0.02, way / 25);
  char x[160], y[160], z[160];
  snprintf(x, sizeof x,
           ALONG "*cos(turn)*cos(slope)-" ACROSS "*sin(turn)+" ABOVE "*cos(turn)*sin(slope)",
           size / 2);
  snprintf(y, sizeof y,
           ALONG "*sin(turn)*cos(slope)+" ACROSS "*cos(turn)+" ABOVE "*sin(turn)*sin(slope)",
           size / 2);
  snprintf(z, sizeof z, ABOVE "*cos(slope)-" ALONG "*sin(slope)", size / 2);
  const nsdae_body body[] = {
      {.name = "plane",
       .shape = NSDAE_SHAPE_PLANE,
       .size = {sin(p->slope) * cos(p->turn), sin(p->slope) * sin(p->turn), cos(p->slope)}},
      {.name = "block",
       .shape = NSDAE_SHAPE_BOX,
       .size = {size, size, size},
       .position = {x, y, z},
       .quaternion = {"cos(slope/2)", "-sin(slope/2)*sin(turn)", "sin(slope/2)*cos(turn)", "0"}},
  };
  return nsdae_trajectory_set_bodies(file, 2, body, error);
}

#define AT(field) offsetof(incline, field)

static const nsdae_param entries[] = {
    {"m", "kg", "mass", NSDAE_PARAM_REAL, AT(m), 1, 0, INFINITY, NSDAE_OPEN_MIN, NULL},
    {"g", "m/s^2", "gravity", NSDAE_PARAM_REAL, AT(g), 9.81, 0, INFINITY, 0, NULL},
    {"slope", "rad", "of the plane", NSDAE_PARAM_REAL, AT(slope), 0.2, 0, 1.5707963267948966,
     NSDAE_OPEN_MAX, NULL},
    {"turn", "rad", "direction of the fall, from x", NSDAE_PARAM_REAL, AT(turn), 0.3, -INFINITY,
     INFINITY, 0, NULL},
    {"mu", "1", "friction", NSDAE_PARAM_REAL, AT(mu), 0.3, 0, INFINITY, 0, NULL},
    {"vx", "m/s", "velocity at the start", NSDAE_PARAM_REAL, AT(vx), 0.5, -INFINITY, INFINITY, 0,
     NULL},
    {"vy", "m/s", "velocity at the start", NSDAE_PARAM_REAL, AT(vy), 0, -INFINITY, INFINITY, 0,
     NULL},
};

static const nsdae_params table = {entries, (int)(sizeof entries / sizeof *entries)};
static incline parameters;

const driver_model incline_model = {.name = "incline",
                                    .summary = "a block that slides on an incline and sticks",
                                    .parameters = &table,
                                    .base = &parameters,
                                    .t_end = 2,
                                    .build = build,
                                    .start = start,
                                    .bodies = bodies};
