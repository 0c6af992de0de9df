/* A ball that falls from the height h0 and bounces on the floor; q = [y], its height.
 *
 *   M = m,  F = -m g,  g_N = y
 *
 * The first impact is at t_1 = sqrt(2 h0 / g) with the velocity V = g t_1. Impact n leaves with
 * e^n V, so that its flight lasts 2 e^n t_1 and
 *
 *   t_n = t_1 (1 + 2 (e + e^2 + ... + e^(n-1))),   Lambda_n = m (1 + e) e^(n-1) V
 *
 * For e < 1 the sum is bounded: infinitely many impacts until t_1 (1 + e) / (1 - e), then rest. */
#include "bouncing_ball.h"

#include <limits.h>
#include <math.h>
#include <stddef.h>

#include "names.h"

static int mass(double t, const double *q, double *M, int ldm, void *user)
{
  const bouncing_ball *p = user;
  (void)t;
  (void)q;
  (void)ldm;
  M[0] = p->m;
  return 0;
}

static int force(double t, const double *q, const double *v, double *F, void *user)
{
  const bouncing_ball *p = user;
  (void)t;
  (void)q;
  (void)v;
  F[0] = -p->m * p->g;
  return 0;
}

static int gap(double t, const double *q, double *g_N, void *user)
{
  (void)t;
  (void)user;
  g_N[0] = q[0];
  return 0;
}

static int gap_normal(double t, const double *q, double *W, int ldw, void *user)
{
  (void)t;
  (void)q;
  (void)ldw;
  (void)user;
  W[0] = 1;
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

static int contact_acceleration(double t, const double *q, const double *v, double *omega_n,
                                double *omega_t, double *omega_s, void *user)
{
  (void)t;
  (void)q;
  (void)v;
  (void)omega_t;
  (void)omega_s;
  (void)user;
  omega_n[0] = 0;
  return 0;
}

static int potential(double t, const double *q, double *energy, void *user)
{
  const bouncing_ball *p = user;
  (void)t;
  *energy = p->m * p->g * q[0];
  return 0;
}

static const model_name names[] = {
    {NSDAE_NAME_COORDINATE, "y", "m"},
    {NSDAE_NAME_CONTACT, "floor", "m"},
};

static int build(void *base, nsdae_system **system, nsdae_error *error)
{
  const bouncing_ball *p = base;
  const nsdae_dims dims = {.nq = 1, .k = 1};
  int status = nsdae_system_create(&dims, system, error);
  if (status < 0) return status;
  nsdae_system_set_user(*system, base);
  MODEL_NAMES(*system, names);
  nsdae_system_set_mass(*system, mass);
  nsdae_system_set_force(*system, force);
  nsdae_system_set_gap(*system, gap);
  nsdae_system_set_gap_normal(*system, gap_normal);
  nsdae_system_set_contact_bias(*system, contact_bias);
  nsdae_system_set_contact_acceleration(*system, contact_acceleration);
  nsdae_system_set_potential(*system, potential);
  return nsdae_system_set_contact(*system, 0, 0, p->e_N, 0);
}

static void start(const void *base, double *q0, double *v0)
{
  const bouncing_ball *p = base;
  (void)v0;
  q0[0] = p->h0;
}

static int exact(const void *base, int number, driver_exact *impact)
{
  const bouncing_ball *p = base;
  double fall = sqrt(2 * p->h0 / p->g), power = 1, sum = 0;
  for (int i = 0; i < number; i++) {
    power *= p->e_N;
    sum += power;
  }
  impact->time = fall * (1 + 2 * sum);
  impact->normal_impulse = p->m * (1 + p->e_N) * power * p->g * fall;
  return power > 0;
}

double bouncing_ball_rest(const bouncing_ball *p)
{
  return sqrt(2 * p->h0 / p->g) * (1 + p->e_N) / (1 - p->e_N);
}

void bouncing_ball_exact(const bouncing_ball *p, double t, double *y, double *v, int *impacts)
{
  double fall = sqrt(2 * p->h0 / p->g), begin = -fall, up = p->g * fall;
  int count = 0, resting = !(t < bouncing_ball_rest(p));
  /* a flight begins with the velocity up; the start is the top of one */
  while (!resting && t - begin >= 2 * up / p->g) {
    begin += 2 * up / p->g;
    up *= p->e_N;
    count++;
    if (!(up > 0)) resting = 1;
  }
  double since = t - begin;
  if (y) *y = resting ? 0 : since * (up - p->g / 2 * since);
  if (v) *v = resting ? 0 : up - p->g * since;
  if (impacts) *impacts = resting ? INT_MAX : count;
}

/* Every half second to 10 s. */
static int state(const void *base, int number, driver_state *state)
{
  state->time = 0.5 * (number + 1);
  state->coordinate = 0;
  bouncing_ball_exact(base, state->time, &state->value, NULL, NULL);
  return number < 20;
}

#define AT(field) offsetof(bouncing_ball, field)

static const nsdae_param entries[] = {
    {"h0", "m", "height at the start, at rest", NSDAE_PARAM_REAL, AT(h0), 1, 0, INFINITY,
     NSDAE_OPEN_MIN, NULL},
    {"m", "kg", "mass", NSDAE_PARAM_REAL, AT(m), 1, 0, INFINITY, NSDAE_OPEN_MIN, NULL},
    {"e_N", "1", "restitution of the floor", NSDAE_PARAM_REAL, AT(e_N), 0.9, 0, 1, 0, NULL},
    {"g", "m/s^2", "gravity", NSDAE_PARAM_REAL, AT(g), 9.81, 0, INFINITY, NSDAE_OPEN_MIN, NULL},
};

static const nsdae_params table = {entries, (int)(sizeof entries / sizeof *entries)};
static bouncing_ball parameters;

const driver_model bouncing_ball_model = {.name = "bouncing-ball",
                                          .summary = "a ball that bounces until it lies still",
                                          .parameters = &table,
                                          .base = &parameters,
                                          .t_end = 10,
                                          .build = build,
                                          .start = start,
                                          .exact = exact,
                                          .state = state,
                                          .coordinates = 1};
