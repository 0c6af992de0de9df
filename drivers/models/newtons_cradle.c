/* Newton's cradle: n equal balls in a row on strings of length L, which swing little. q_i is how
 * far ball i is from where it hangs; gap is between the balls that hang.
 *
 *   M = m 1,  F_i = -m (g / L) q_i,  g_Ni = gap + q_(i+1) - q_i          (g = 0: balls on a table)
 *
 * They start where they hang, the first with the velocity v_0. Newton's law on all contacts at
 * once is W^T v(+) = -e W^T v(-) where there is an impulse. Balls that touch (gap = 0): the others
 * leave together with u, and from momentum and u - v_1 = e v_0
 *
 *   v_1 = (1 - (n-1) e) v_0 / n,   u = (1 + e) v_0 / n
 *
 * All swing with the same period and meet again after half of it, reversed. By induction, with
 * s = (-1)^j, impact j = 0, 1, ... at j pi sqrt(L / g) leaves
 *
 *   v_1 = (s - (n-1) e^(j+1)) v_0 / n,   u = (s + e^(j+1)) v_0 / n
 *   Lambda_i = (n - 1 - i) m (1 + e) e^j v_0 / n        contact i = 0 .. n-2
 *
 * All Lambda_i are positive and M is positive definite: the solution is the only one. The toy
 * behaves differently: its balls do not quite touch. With gap > 0 the impacts follow each other and
 * only the last ball leaves. Touching balls are not the limit of gap -> 0; from the second impact
 * on rounding decides which contacts are closed. */
#include "newtons_cradle.h"

#include <math.h>
#include <stddef.h>
#include <stdio.h>

static int mass(double t, const double *q, double *M, int ldm, void *user)
{
  const newtons_cradle *p = user;
  (void)t;
  (void)q;
  for (int i = 0; i < p->n; i++) M[i * ldm + i] = p->m;
  return 0;
}

static int force(double t, const double *q, const double *v, double *F, void *user)
{
  const newtons_cradle *p = user;
  (void)t;
  (void)v;
  for (int i = 0; i < p->n; i++) F[i] = -p->m * p->g / p->L * q[i];
  return 0;
}

static int gap(double t, const double *q, double *g_N, void *user)
{
  const newtons_cradle *p = user;
  (void)t;
  for (int i = 0; i < p->n - 1; i++) g_N[i] = p->gap + (q[i + 1] - q[i]);
  return 0;
}

static int gap_normal(double t, const double *q, double *W, int ldw, void *user)
{
  const newtons_cradle *p = user;
  (void)t;
  (void)q;
  for (int i = 0; i < p->n - 1; i++) {
    W[i * ldw + i] = -1;
    W[i * ldw + i + 1] = 1;
  }
  return 0;
}

static int contact_bias(double t, const double *q, double *w_n, double *w_t, void *user)
{
  const newtons_cradle *p = user;
  (void)t;
  (void)q;
  (void)w_t;
  for (int i = 0; i < p->n - 1; i++) w_n[i] = 0;
  return 0;
}

static int contact_acceleration(double t, const double *q, const double *v, double *omega_n,
                                double *omega_t, double *omega_s, void *user)
{
  const newtons_cradle *p = user;
  (void)t;
  (void)q;
  (void)v;
  (void)omega_t;
  (void)omega_s;
  for (int i = 0; i < p->n - 1; i++) omega_n[i] = 0;
  return 0;
}

static int potential(double t, const double *q, double *energy, void *user)
{
  const newtons_cradle *p = user;
  (void)t;
  *energy = 0;
  for (int i = 0; i < p->n; i++) *energy += p->m * p->g / p->L * q[i] * q[i] / 2;
  return 0;
}

/* Balls 0 .. n-1, and contact i between balls i and i + 1. */
static void name_balls(nsdae_system *system, int n)
{
  char name[32];
  for (int i = 0; i < n; i++) {
    snprintf(name, sizeof name, "x_%d", i);
    nsdae_system_set_name(system, NSDAE_NAME_COORDINATE, i, name, "m");
  }
  for (int i = 0; i < n - 1; i++) {
    snprintf(name, sizeof name, "balls_%d_%d", i, i + 1);
    nsdae_system_set_name(system, NSDAE_NAME_CONTACT, i, name, "m");
  }
}

static int build(void *base, nsdae_system **system, nsdae_error *error)
{
  const newtons_cradle *p = base;
  const nsdae_dims dims = {.nq = p->n, .k = p->n - 1};
  int status = nsdae_system_create(&dims, system, error);
  if (status < 0) return status;
  nsdae_system_set_user(*system, base);
  name_balls(*system, p->n);
  nsdae_system_set_mass(*system, mass);
  nsdae_system_set_force(*system, force);
  nsdae_system_set_gap(*system, gap);
  nsdae_system_set_gap_normal(*system, gap_normal);
  nsdae_system_set_contact_bias(*system, contact_bias);
  nsdae_system_set_contact_acceleration(*system, contact_acceleration);
  nsdae_system_set_potential(*system, potential);
  for (int i = 0; i < p->n - 1 && status == NSDAE_OK; i++)
    status = nsdae_system_set_contact(*system, i, 0, p->e_N, 0);
  return status;
}

static void start(const void *base, double *q0, double *v0)
{
  const newtons_cradle *p = base;
  (void)q0;
  v0[0] = p->v0;
}

static const char *remark(const void *base)
{
  const newtons_cradle *p = base;
  if (p->gap > 0) return NULL;
  return "balls that touch: Newton's law for all contacts at once, so that all the others leave\n"
         "together; the toy's balls do not quite touch and the last one leaves alone: --set "
         "gap=1e-5";
}

void newtons_cradle_exact(const newtons_cradle *p, int impact, double *v)
{
  double s = impact % 2 ? -1 : 1, power = pow(p->e_N, impact + 1);
  v[0] = (s - (p->n - 1) * power) * p->v0 / p->n;
  for (int i = 1; i < p->n; i++) v[i] = (s + power) * p->v0 / p->n;
}

/* Of contact 0, the first that closes with a velocity; later impacts: see the file head. Over a gap
 * the first ball swings alone, and hits one ball of its mass. */
static int exact(const void *base, int number, driver_exact *impact)
{
  const newtons_cradle *p = base;
  const double rate = sqrt(p->g / p->L), part = p->gap * rate / p->v0;
  impact->time = p->gap / p->v0;
  impact->normal_impulse = (p->n - 1) * p->m * (1 + p->e_N) * p->v0 / p->n;
  if (p->gap > 0) impact->normal_impulse = p->m * (1 + p->e_N) / 2 * p->v0 * sqrt(1 - part * part);
  if (p->gap > 0 && p->g > 0) impact->time = asin(part) / rate;
  return part < 1 && number == 0;
}

/* Of ball or string number i. */
typedef struct hanging {
  char name[24], pivot[32], x[40], y[32];
} hanging;

/* Balls of radius L / 10; they rise by q^2 / 2 L, as their potential has it. */
static void hang(const newtons_cradle *p, const char *name, int i, hanging *h)
{
  snprintf(h->name, sizeof h->name, "%s %d", name, i);
  snprintf(h->pivot, sizeof h->pivot, "%d*(L/5+gap)", i);
  snprintf(h->x, sizeof h->x, "%d*(L/5+gap)+q%d", i, i);
  snprintf(h->y, sizeof h->y, p->g > 0 ? "q%d^2/(2*L)" : "0*q%d", i);
}

/* Balls on a table have no strings. */
static int bodies(const void *base, nsdae_trajectory *file, nsdae_error *error)
{
  const newtons_cradle *p = base;
  hanging string[NEWTONS_CRADLE_MAX], ball[NEWTONS_CRADLE_MAX];
  nsdae_body body[2 * NEWTONS_CRADLE_MAX];
  int n = 0;
  for (int i = 0; i < p->n && p->g > 0; i++) {
    hang(p, "string", i, &string[i]);
    body[n++] = (nsdae_body){.name = string[i].name,
                             .shape = NSDAE_SHAPE_SEGMENT,
                             .position = {string[i].pivot, "L"},
                             .end = {string[i].x, string[i].y}};
  }
  for (int i = 0; i < p->n; i++) {
    hang(p, "ball", i, &ball[i]);
    body[n++] = (nsdae_body){.name = ball[i].name,
                             .shape = NSDAE_SHAPE_SPHERE,
                             .size = {p->L / 10},
                             .position = {ball[i].x, ball[i].y}};
  }
  return nsdae_trajectory_set_bodies(file, n, body, error);
}

#define AT(field) offsetof(newtons_cradle, field)

static const nsdae_param entries[] = {
    {"n", "1", "balls", NSDAE_PARAM_INT, AT(n), 5, 2, NEWTONS_CRADLE_MAX, 0, NULL},
    {"m", "kg", "mass of a ball", NSDAE_PARAM_REAL, AT(m), 0.1, 0, INFINITY, NSDAE_OPEN_MIN, NULL},
    {"L", "m", "length of the strings", NSDAE_PARAM_REAL, AT(L), 0.2, 0, INFINITY, NSDAE_OPEN_MIN,
     NULL},
    {"g", "m/s^2", "gravity; 0: balls on a table", NSDAE_PARAM_REAL, AT(g), 9.81, 0, INFINITY, 0,
     NULL},
    {"gap", "m", "between balls that hang; 0: they touch", NSDAE_PARAM_REAL, AT(gap), 0, 0,
     INFINITY, 0, NULL},
    {"v0", "m/s", "velocity of the first ball at the start", NSDAE_PARAM_REAL, AT(v0), 1, 0,
     INFINITY, NSDAE_OPEN_MIN, NULL},
    {"e_N", "1", "restitution", NSDAE_PARAM_REAL, AT(e_N), 1, 0, 1, 0, NULL},
};

static const nsdae_params table = {entries, (int)(sizeof entries / sizeof *entries)};
static newtons_cradle parameters;

const driver_model newtons_cradle_model = {.name = "newtons-cradle",
                                           .summary = "a row of balls on strings, the first of "
                                                      "which hits the others",
                                           .parameters = &table,
                                           .base = &parameters,
                                           .t_end = 2,
                                           .dt = 5e-4,
                                           .build = build,
                                           .start = start,
                                           .bodies = bodies,
                                           .remark = remark,
                                           .exact = exact};
