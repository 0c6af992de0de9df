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

static int build(void *base, nsdae_system **system, nsdae_error *error)
{
  bouncing_ball *p = base;
  return table_ball_build(&p->ball, "floor", system, error);
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
  double fall = sqrt(2 * p->h0 / p->ball.g), power = 1, sum = 0;
  for (int i = 0; i < number; i++) {
    power *= p->ball.e_N;
    sum += power;
  }
  impact->time = fall * (1 + 2 * sum);
  impact->normal_impulse = p->ball.m * (1 + p->ball.e_N) * power * p->ball.g * fall;
  return power > 0;
}

double bouncing_ball_rest(const bouncing_ball *p)
{
  return sqrt(2 * p->h0 / p->ball.g) * (1 + p->ball.e_N) / (1 - p->ball.e_N);
}

void bouncing_ball_exact(const bouncing_ball *p, double t, double *y, double *v, int *impacts)
{
  double fall = sqrt(2 * p->h0 / p->ball.g), begin = -fall, up = p->ball.g * fall;
  int count = 0, resting = !(t < bouncing_ball_rest(p));
  /* a flight begins with the velocity up; the start is the top of one */
  while (!resting && t - begin >= 2 * up / p->ball.g) {
    begin += 2 * up / p->ball.g;
    up *= p->ball.e_N;
    count++;
    if (!(up > 0)) resting = 1;
  }
  double since = t - begin;
  if (y) *y = resting ? 0 : since * (up - p->ball.g / 2 * since);
  if (v) *v = resting ? 0 : up - p->ball.g * since;
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

/* The coordinate is the height of the ball's lowest point. */
static int bodies(const void *base, nsdae_trajectory *file, nsdae_error *error)
{
  const bouncing_ball *p = base;
  const nsdae_body body[] = {
      {.name = "floor", .shape = NSDAE_SHAPE_PLANE, .size = {0, 1, 0}},
      {.name = "ball",
       .shape = NSDAE_SHAPE_SPHERE,
       .size = {p->h0 / 20},
       .position = {"0", "y+h0/20"}},
  };
  return nsdae_trajectory_set_bodies(file, 2, body, error);
}

#define AT(field) offsetof(bouncing_ball, field)

static const nsdae_param entries[] = {
    {"h0", "m", "height at the start, at rest", NSDAE_PARAM_REAL, AT(h0), 1, 0, INFINITY,
     NSDAE_OPEN_MIN, NULL},
    {"m", "kg", "mass", NSDAE_PARAM_REAL, AT(ball.m), 1, 0, INFINITY, NSDAE_OPEN_MIN, NULL},
    {"e_N", "1", "restitution of the floor", NSDAE_PARAM_REAL, AT(ball.e_N), 0.9, 0, 1, 0, NULL},
    {"g", "m/s^2", "gravity", NSDAE_PARAM_REAL, AT(ball.g), 9.81, 0, INFINITY, NSDAE_OPEN_MIN,
     NULL},
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
                                          .bodies = bodies,
                                          .exact = exact,
                                          .state = state,
                                          .coordinates = 1};
