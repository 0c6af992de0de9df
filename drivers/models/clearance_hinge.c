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
#include <stdio.h>
#include <string.h>

#include "outline.h"

#include "compare.h"
#include "model_names.h"

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

/* The shaft is thinner than the hole and starts in it; that it touches may be off by rounding. */
static int check(const clearance_hinge *p, nsdae_error *error)
{
  double off = hypot(p->dX, p->dY), clearance = p->R - p->r;
  if (clearance > 0 && off <= clearance + 1e-15 * p->R) return NSDAE_OK;
  snprintf(error->argument, sizeof error->argument, clearance > 0 ? "dX" : "r");
  if (clearance > 0)
    snprintf(error->text, sizeof error->text,
             "the shaft starts %g m from the hole's centre (dX, dY): it must be at most R - r = %g",
             off, clearance);
  else
    snprintf(error->text, sizeof error->text,
             "r = %g is outside its range: it must be less than R = %g", p->r, p->R);
  return error->status = NSDAE_E_ARGUMENT;
}

static const model_name names[] = {
    {NSDAE_NAME_COORDINATE, "x", "m"},
    {NSDAE_NAME_COORDINATE, "y", "m"},
    {NSDAE_NAME_COORDINATE, "theta", "rad"},
    {NSDAE_NAME_CONTACT, "shaft", "m"},
};

static int build(void *base, nsdae_system **system, nsdae_error *error)
{
  const clearance_hinge *p = base;
  const nsdae_dims dims = {.nq = 3, .k = 1, .nt = 1};
  int status = check(p, error);
  if (status == NSDAE_OK) status = nsdae_system_create(&dims, system, error);
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

/* data/clearance_hinge_impacts.csv, of the parameters in data/. */
typedef struct reference {
  const char *slip;
  double r;
  int impact;
  double t, normal, tangential, theta, omega;
} reference;

static const reference references[] = {
#include "clearance_hinge_impacts.inc"
};

/* data/clearance_hinge_table4.csv: published forces [N]. */
static const struct {
  double r, continuous, paper, moreau;
} table4[] = {
#include "clearance_hinge_table4.inc"
};

enum { RADII = sizeof table4 / sizeof *table4 };

/* The reference holds for the published parameters alone, with its radii and both slips. */
static int published(const clearance_hinge *p)
{
  clearance_hinge o;
  nsdae_params_default(clearance_hinge_model.parameters, &o);
  return p->l == o.l && p->m == o.m && p->R == o.R && p->mu == o.mu && p->dX == o.dX &&
         p->dY == o.dY && p->theta_0 == o.theta_0 && p->e_N == o.e_N && p->e_T == o.e_T &&
         p->g == o.g;
}

static int exact(const void *base, int number, driver_exact *impact)
{
  const clearance_hinge *p = base;
  const char *slip = p->slip == SURFACE_SLIP ? "surface_slip" : "hinge_angle";
  if (!published(p)) return 0;
  for (size_t i = 0; i < sizeof references / sizeof *references; i++) {
    const reference *r = &references[i];
    if (strcmp(r->slip, slip) != 0 || fabs(r->r - p->r) > 1e-12 || r->impact != number + 1)
      continue;
    *impact = (driver_exact){.time = r->t, .normal_impulse = r->normal};
    return 1;
  }
  return 0;
}

/* Peak of the first impact's continuous force. */
static double first_peak(const settings *s, double stiffness)
{
  static comparison_run run;
  settings own = *s;
  own.options.penalty_stiffness = stiffness;
  compare_one(&own, NSDAE_METHOD_PENALTY, &run);
  return run.status < 0 || run.impacts == 0 ? NAN : run.impact[0].peak_force;
}

/* Exponent of the law in use: Kelvin and Voigt's is linear. */
static double exponent(const settings *s)
{
  return s->options.penalty_law == NSDAE_PENALTY_KELVIN_VOIGT ? 1 : s->options.penalty_exponent;
}

/* The one stiffness that gives the first published force. The peak of a Hertz contact goes with
 * K^(2/5) where n = 3/2, in general with K^(1 / (n + 1)). */
static double fitted_stiffness(const settings *s)
{
  double K = 1e10;
  for (int i = 0; i < 6; i++) K *= pow(table4[0].continuous / first_peak(s, K), exponent(s) + 1);
  return K;
}

/* Columns of Table 4 beside ours. */
enum { R, CONTINUOUS, PAPER, MOREAU, EXACT, OURS, PEAK = OURS + 3, PEAK_ERROR, COLUMNS };

static void fill_row(const settings *s, double stiffness, int i, double row[COLUMNS])
{
  static comparison_run run;
  clearance_hinge *p = s->model->base;
  const int methods[] = {NSDAE_METHOD_MOREAU, NSDAE_METHOD_IMPLICIT_PRINTED, NSDAE_METHOD_IMPLICIT};
  driver_exact first = {NAN, NAN};
  p->r = row[R] = table4[i].r;
  row[CONTINUOUS] = table4[i].continuous;
  row[PAPER] = table4[i].paper;
  row[MOREAU] = table4[i].moreau;
  exact(p, 0, &first);
  row[EXACT] = first.normal_impulse;
  for (int j = 0; j < 3; j++) {
    compare_one(s, methods[j], &run);
    row[OURS + j] = run.status < 0 ? NAN : run.first_impulse;
  }
  row[PEAK] = first_peak(s, stiffness);
  row[PEAK_ERROR] = row[PEAK] / row[CONTINUOUS] - 1;
}

static void print_row(const double row[COLUMNS])
{
  printf("%6.3f  %9.2f %9.2f %9.2f  %9.5f", row[R] / 0.030, row[CONTINUOUS], row[PAPER],
         row[MOREAU], row[EXACT]);
  for (int j = 0; j < 3; j++)
    printf("  %7.4f %+6.1f%%", row[OURS + j], 100 * (row[OURS + j] / row[EXACT] - 1));
  printf("  %9.2f %+6.1f%%\n", row[PEAK], 100 * row[PEAK_ERROR]);
}

static int put_columns(nsdae_trajectory *t, double rows[RADII][COLUMNS], nsdae_error *error)
{
  static const char *const name[COLUMNS][3] = {
      {"shaft_radius", "m", "radius of the shaft"},
      {"published_continuous_force", "N", "source paper, commercial code"},
      {"published_paper_force", "N", "source paper, its method"},
      {"published_moreau_force", "N", "source paper, Moreau's rule"},
      {"exact_impulse", "N s", "normal impulse of the first impact"},
      {"moreau_impulse", "N s", "normal impulse of the first impact"},
      {"implicit_printed_impulse", "N s", "normal impulse of the first impact"},
      {"implicit_impulse", "N s", "normal impulse of the first impact"},
      {"penalty_peak_force", "N", "peak of the first impact, stiffness fitted to the first row"},
      {"penalty_peak_error", "1", "of the peak, relative to the commercial code's force"}};
  int status = NSDAE_OK;
  for (int j = 0; j < COLUMNS && status == NSDAE_OK; j++) {
    double column[RADII];
    char path[64];
    for (int i = 0; i < RADII; i++) column[i] = rows[i][j];
    snprintf(path, sizeof path, "/compare/table4/%s", name[j][0]);
    status = nsdae_trajectory_put(t, path, RADII, column, name[j][1], name[j][2], error);
  }
  return status;
}

static void print_table4(const settings *s, double stiffness, double rows[RADII][COLUMNS])
{
  enum { MISPRINT = 3 }; /* the row r/R 0.733 */
  double others = 0;
  printf("\nfirst impact, Table 4 of the source paper (forces, as published) beside impulses at dt "
         "%g s\nand the peak of a continuous force with K = %.4g N/m^%g, fitted to the first row\n"
         "%6s  %9s %9s %9s  %9s  %15s  %15s  %15s  %17s\n",
         s->options.dt, stiffness, exponent(s), "r/R", "contin. N", "paper N", "Moreau N",
         "exact N s", "moreau N s", "printed N s", "implicit N s", "penalty peak N");
  for (int i = 0; i < RADII; i++) {
    print_row(rows[i]);
    if (i != MISPRINT) others = fmax(others, fabs(rows[i][PEAK_ERROR]));
  }
  printf("No impulse divided by dt gives the published forces: they are peaks of a continuous "
         "force.\n");
  if (others < 0.04 && fabs(rows[MISPRINT][PEAK_ERROR]) > 0.2)
    printf("r/R 0.733 alone is off by more than 4 %%: a misprint of the source.\n");
}

/* Table 4 of the source paper beside exact values and ours: first impacts only. */
static int compare_table4(const settings *s, nsdae_trajectory *trajectory, nsdae_error *error)
{
  clearance_hinge *p = s->model->base, kept = *p;
  settings own = *s;
  double rows[RADII][COLUMNS];
  if (!published(p)) return NSDAE_OK;
  own.t_end = 0.07; /* the latest first impact is at 0.052 s */
  p->r = table4[0].r;
  double stiffness = fitted_stiffness(&own);
  for (int i = 0; i < RADII; i++) fill_row(&own, stiffness, i, rows[i]);
  *p = kept;
  int status = compare_status(error);
  if (status == NSDAE_OK && !s->quiet) print_table4(s, stiffness, rows);
  return status == NSDAE_OK && trajectory ? put_columns(trajectory, rows, error) : status;
}

static int bodies(const void *base, nsdae_trajectory *file, nsdae_error *error)
{
  const clearance_hinge *p = base;
  double rod[12];
  outline_box(0, 0, p->r, p->l, rod);
  const nsdae_body body[] = {
      {.name = "hole", .shape = NSDAE_SHAPE_DISC, .size = {1.3 * p->R, p->R}},
      {.name = "rod",
       .shape = NSDAE_SHAPE_POLYGON,
       .points = OUTLINE_BOX,
       .point = rod,
       .position = {"x", "y"},
       .angle = "theta"},
      {.name = "shaft",
       .shape = NSDAE_SHAPE_DISC,
       .size = {p->r},
       .position = {"x-l/2*sin(theta)", "y+l/2*cos(theta)"},
       .angle = "theta"},
  };
  return nsdae_trajectory_set_bodies(file, 3, body, error);
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
                                            .projection = NSDAE_PROJECTION_DEPTHS,
                                            .build = build,
                                            .start = start,
                                            .bodies = bodies,
                                            .exact = exact,
                                            .compare_more = compare_table4};
