/* The woodpecker toy (Glocker and Studer, Multibody System Dynamics 13, 2005,
 * doi 10.1007/s11044-005-2519-6; Leine, Glocker and van Campen, DETC 2001): a sleeve M that slides
 * down a pole of radius r_0, and on it a spring c that carries a woodpecker S. q = [y, phi_M,
 * phi_S]: height of the sleeve, tilt of the sleeve, tilt of the bird, all tilts small. With the
 * bird's centre at the height y_S = y + l_M phi_M + l_G phi_S, the spring's end at y + l_M phi_M,
 *
 *   T = (m_M y'^2 + J_M phi_M'^2 + m_S y_S'^2 + J_S phi_S'^2) / 2
 *   U = m_M g y + m_S g y_S + c (phi_M - phi_S)^2 / 2
 *
 *         [ m_S + m_M   m_S l_M               m_S l_G             ]
 *     M = [             J_M + m_S l_M^2       m_S l_M l_G         ]
 *         [ sym.                              J_S + m_S l_G^2     ]
 *
 *     F = -[ (m_S + m_M) g,  c (phi_M - phi_S) + m_S g l_M,  c (phi_S - phi_M) + m_S g l_G ]
 *
 * Contacts with the pole: the beak, the sleeve's lower and its upper edge,
 *
 *   g_N = [ l_M + l_G - l_S - r_0 - h_S phi_S,  r_M - r_0 + h_M phi_M,  r_M - r_0 - h_M phi_M ]
 *   v_T = [ y' + l_M phi_M' + (l_G - l_S) phi_S',  y' + r_M phi_M',  y' + r_M phi_M' ]
 *
 * From the start below it comes to a limit cycle of 0.145976 s. The published start is phi_M =
 * -0.1036, where the lower edge is 8.8e-7 m inside the pole; here the edge touches it. */
#include "woodpecker.h"

#include <math.h>
#include <stddef.h>

#include "model_names.h"
#include "outline.h"

/* Of the sleeve, where its edges touch the pole. */
static double tilt(const woodpecker *p)
{
  return (p->r_M - p->r_0) / p->h_M;
}

static int mass(double t, const double *q, double *M, int ldm, void *user)
{
  const woodpecker *p = user;
  const double arm[] = {1, p->l_M, p->l_G};
  (void)t;
  (void)q;
  for (int j = 0; j < 3; j++)
    for (int i = 0; i < 3; i++) M[j * ldm + i] = p->m_S * arm[i] * arm[j];
  M[0] += p->m_M;
  M[ldm + 1] += p->J_M;
  M[2 * ldm + 2] += p->J_S;
  return 0;
}

static int force(double t, const double *q, const double *v, double *F, void *user)
{
  const woodpecker *p = user;
  double moment = p->c * (q[1] - q[2]);
  (void)t;
  (void)v;
  F[0] = -(p->m_S + p->m_M) * p->g;
  F[1] = -moment - p->m_S * p->g * p->l_M;
  F[2] = moment - p->m_S * p->g * p->l_G;
  return 0;
}

static int gap(double t, const double *q, double *g_N, void *user)
{
  const woodpecker *p = user;
  (void)t;
  g_N[WOODPECKER_BEAK] = p->l_M + p->l_G - p->l_S - p->r_0 - p->h_S * q[2];
  g_N[WOODPECKER_LOWER_EDGE] = p->h_M * (tilt(p) + q[1]);
  g_N[WOODPECKER_UPPER_EDGE] = p->h_M * (tilt(p) - q[1]);
  return 0;
}

static int gap_normal(double t, const double *q, double *W, int ldw, void *user)
{
  const woodpecker *p = user;
  (void)t;
  (void)q;
  W[2] = -p->h_S;
  W[ldw + 1] = p->h_M;
  W[2 * ldw + 1] = -p->h_M;
  return 0;
}

static int gap_tangent(double t, const double *q, double *W, int ldw, void *user)
{
  const woodpecker *p = user;
  (void)t;
  (void)q;
  W[0] = W[ldw] = W[2 * ldw] = 1;
  W[1] = p->l_M;
  W[2] = p->l_G - p->l_S;
  W[ldw + 1] = W[2 * ldw + 1] = p->r_M;
  return 0;
}

static int contact_bias(double t, const double *q, double *w_n, double *w_t, void *user)
{
  (void)t;
  (void)q;
  (void)user;
  for (int i = 0; i < 3; i++) w_n[i] = w_t[i] = 0;
  return 0;
}

static int contact_acceleration(double t, const double *q, const double *v, double *omega_n,
                                double *omega_t, double *omega_s, void *user)
{
  (void)t;
  (void)q;
  (void)v;
  (void)omega_s;
  (void)user;
  for (int i = 0; i < 3; i++) omega_n[i] = omega_t[i] = 0;
  return 0;
}

static int potential(double t, const double *q, double *energy, void *user)
{
  const woodpecker *p = user;
  double y_S = q[0] + p->l_M * q[1] + p->l_G * q[2], turn = q[1] - q[2];
  (void)t;
  *energy = p->g * (p->m_M * q[0] + p->m_S * y_S) + p->c * turn * turn / 2;
  return 0;
}

static const model_name names[] = {
    {NSDAE_NAME_COORDINATE, "y", "m"},       {NSDAE_NAME_COORDINATE, "phi_M", "rad"},
    {NSDAE_NAME_COORDINATE, "phi_S", "rad"}, {NSDAE_NAME_CONTACT, "beak", "m"},
    {NSDAE_NAME_CONTACT, "lower_edge", "m"}, {NSDAE_NAME_CONTACT, "upper_edge", "m"},
};

static int build(void *base, nsdae_system **system, nsdae_error *error)
{
  woodpecker *p = base;
  const nsdae_dims dims = {.nq = 3, .k = 3, .nt = 1};
  p->pecks = 0;
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
  for (int i = 0; i < 3 && status == NSDAE_OK; i++)
    status = nsdae_system_set_contact(*system, i, p->mu,
                                      i == WOODPECKER_BEAK ? p->e_beak : p->e_sleeve, p->e_T);
  return status;
}

static void start(const void *base, double *q0, double *v0)
{
  const woodpecker *p = base;
  q0[1] = -tilt(p);
  q0[2] = p->phi_S;
  v0[0] = p->v;
  v0[2] = p->omega_S;
}

static void follow(void *base, const nsdae_record *r)
{
  woodpecker *p = base;
  for (int i = 0; i < r->impacts; i++) {
    if (r->impact[i].contact != WOODPECKER_BEAK) continue;
    if (p->pecks++ == WOODPECKER_SETTLED) p->settled = r->impact[i].time;
    p->last = r->impact[i].time;
  }
}

/* The period of the limit cycle, as the event-driven method has it to 1e-6 s. */
static int figure(const void *base, driver_figure *f)
{
  const woodpecker *p = base;
  int cycles = p->pecks - 1 - WOODPECKER_SETTLED;
  *f = (driver_figure){"mean period of a peck", "s", (p->last - p->settled) / cycles, 0.145976};
  return cycles > 0;
}

enum { OVAL = 16 };

/* An oval part of the bird about (x, y), of these half axes, in units of l_S and h_S; it leans with
 * its top to the pole. */
static void oval(const woodpecker *p, double x, double y, double high, double wide,
                 double corner[3 * OVAL])
{
  for (int i = 0; i < OVAL; i++) {
    double angle = 2 * 3.14159265358979323846 * i / OVAL;
    double up = high * sin(angle), aside = wide * cos(angle);
    corner[3 * i] = p->l_S * (x + 0.95 * aside - 0.3 * up);
    corner[3 * i + 1] = p->h_S * (y + 0.3 * aside + 0.95 * up);
    corner[3 * i + 2] = 0;
  }
}

/* Tilts are small in the model, and real rotations here. So that what touches in the model touches
 * in the picture, the sleeve turns by asin(phi_M) and moves by r_M (1 - cos) along x, which leaves
 * the edges of its right wall at r_M +- h_M phi_M, and the bird moves so that its beak, at (-l_S,
 * h_S) from its centre, is at -l_S - h_S phi_S. */
static int bodies(const void *base, nsdae_trajectory *file, nsdae_error *error)
{
  const woodpecker *p = base;
  double left[12], right[12];
  const double beak[9] = {-p->l_S,        p->h_S, 0, -0.15 * p->l_S, 0.8 * p->h_S, 0,
                          -0.15 * p->l_S, p->h_S, 0};
  double bird[3 * OVAL], head[3 * OVAL], wing[3 * OVAL];
  oval(p, 0.3, -0.1, 1.1, 0.4, bird);
  oval(p, -0.12, 0.88, 0.38, 0.34, head);
  oval(p, 0.42, -0.25, 0.75, 0.22, wing);
  outline_box(-1.25 * p->r_M, 0, 0.5 * p->r_M, 2 * p->h_M, left);
  outline_box(1.25 * p->r_M, 0, 0.5 * p->r_M, 2 * p->h_M, right);
  nsdae_body wall = {.shape = NSDAE_SHAPE_POLYGON,
                     .points = OUTLINE_BOX,
                     .position = {"r_M*(1-sqrt(1-phi_M^2))", "y"},
                     .angle = "asin(phi_M)"};
  nsdae_body body[] = {
      {.name = "pole",
       .shape = NSDAE_SHAPE_SEGMENT,
       .size = {2 * p->r_0},
       .position = {"0", "0.06"},
       .end = {"0", "-2"}},
      wall,
      wall,
      {.name = "spring",
       .shape = NSDAE_SHAPE_SEGMENT,
       .size = {p->r_0 / 2},
       .position = {"l_M", "y+l_M*phi_M"},
       .end = {"l_M+l_G", "y+l_M*phi_M+l_G*phi_S"}},
      {.name = "bird", .points = OVAL, .point = bird, .colour = "#39424e"},
      {.name = "beak", .points = 3, .point = beak, .colour = "#d9a441"},
      {.name = "head", .points = OVAL, .point = head, .colour = "#b0302a"},
      {.name = "wing", .points = OVAL, .point = wing, .colour = "#8fa0b3"},
  };
  for (int i = 4; i < 8; i++) {
    body[i].shape = NSDAE_SHAPE_POLYGON;
    body[i].position[0] = "l_M+l_G+l_S*(cos(phi_S)-1)+h_S*(sin(phi_S)-phi_S)";
    body[i].position[1] = "y+l_M*phi_M+l_G*phi_S";
    body[i].angle = "phi_S";
  }
  body[1].name = "sleeve, left";
  body[1].point = left;
  body[2].name = "sleeve, right";
  body[2].point = right;
  return nsdae_trajectory_set_bodies(file, 8, body, error);
}

#define AT(field) offsetof(woodpecker, field)

static const nsdae_param entries[] = {
    {"r_0", "m", "radius of the pole", NSDAE_PARAM_REAL, AT(r_0), 0.0025, 0, INFINITY,
     NSDAE_OPEN_MIN, NULL},
    {"r_M", "m", "radius of the sleeve's hole", NSDAE_PARAM_REAL, AT(r_M), 0.0031, 0, INFINITY,
     NSDAE_OPEN_MIN, NULL},
    {"h_M", "m", "half the height of the sleeve", NSDAE_PARAM_REAL, AT(h_M), 0.0058, 0, INFINITY,
     NSDAE_OPEN_MIN, NULL},
    {"l_M", "m", "pole to spring", NSDAE_PARAM_REAL, AT(l_M), 0.010, 0, INFINITY, 0, NULL},
    {"l_G", "m", "spring to the bird's centre", NSDAE_PARAM_REAL, AT(l_G), 0.015, 0, INFINITY, 0,
     NULL},
    {"h_S", "m", "height of the beak above the centre", NSDAE_PARAM_REAL, AT(h_S), 0.02, 0,
     INFINITY, NSDAE_OPEN_MIN, NULL},
    {"l_S", "m", "length of the beak from the centre", NSDAE_PARAM_REAL, AT(l_S), 0.0201, 0,
     INFINITY, 0, NULL},
    {"m_M", "kg", "mass of the sleeve", NSDAE_PARAM_REAL, AT(m_M), 0.0003, 0, INFINITY,
     NSDAE_OPEN_MIN, NULL},
    {"m_S", "kg", "mass of the bird", NSDAE_PARAM_REAL, AT(m_S), 0.0045, 0, INFINITY,
     NSDAE_OPEN_MIN, NULL},
    {"J_M", "kg m^2", "inertia of the sleeve", NSDAE_PARAM_REAL, AT(J_M), 5e-9, 0, INFINITY,
     NSDAE_OPEN_MIN, NULL},
    {"J_S", "kg m^2", "inertia of the bird", NSDAE_PARAM_REAL, AT(J_S), 7e-7, 0, INFINITY,
     NSDAE_OPEN_MIN, NULL},
    {"c", "N m", "stiffness of the spring, per rad", NSDAE_PARAM_REAL, AT(c), 0.0056, 0, INFINITY,
     0, NULL},
    {"g", "m/s^2", "gravity", NSDAE_PARAM_REAL, AT(g), 9.81, 0, INFINITY, 0, NULL},
    {"e_beak", "1", "normal restitution of the beak", NSDAE_PARAM_REAL, AT(e_beak), 0.5, 0, 1, 0,
     NULL},
    {"e_sleeve", "1", "normal restitution of the sleeve", NSDAE_PARAM_REAL, AT(e_sleeve), 0, 0, 1,
     0, NULL},
    {"e_T", "1", "tangential restitution", NSDAE_PARAM_REAL, AT(e_T), 0, 0, 1, 0, NULL},
    {"mu", "1", "friction", NSDAE_PARAM_REAL, AT(mu), 0.3, 0, INFINITY, 0, NULL},
    {"phi_S", "rad", "tilt of the bird at the start", NSDAE_PARAM_REAL, AT(phi_S), -0.2788,
     -INFINITY, INFINITY, 0, NULL},
    {"v", "m/s", "velocity of the sleeve at the start", NSDAE_PARAM_REAL, AT(v), -0.3411, -INFINITY,
     INFINITY, 0, NULL},
    {"omega_S", "rad/s", "turning of the bird at the start", NSDAE_PARAM_REAL, AT(omega_S), -7.4583,
     -INFINITY, INFINITY, 0, NULL},
};

static const nsdae_params table = {entries, (int)(sizeof entries / sizeof *entries)};
static woodpecker parameters;

const driver_model woodpecker_model = {.name = "woodpecker",
                                       .summary = "the toy that pecks its way down a pole",
                                       .parameters = &table,
                                       .base = &parameters,
                                       .t_end = 3,
                                       .dt = 1e-4,
                                       .build = build,
                                       .start = start,
                                       .bodies = bodies,
                                       .follow = follow,
                                       .figure = figure};
