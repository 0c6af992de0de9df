/* A ball that bounces on a vibrating table; q = [y], its height.
 *
 *   M = m,  F = -m g,  g_N = y - A sin(w t + phi_0),  w = 2 pi / T,  gamma = A w^2 / g
 *
 * gamma is the acceleration of the table over gravity. The classical example of period doublings to
 * chaos (Holmes, J. Sound Vib. 84 (1982) 173, who neglects the displacement of the table; it is
 * included here). The ball bounces once per period if each flight lasts T, so that v = g T / 2
 * leaves and -v arrives; with Newton's law
 *
 *   v = (1 + e) A w cos(phi) + e v,   cos(phi) = pi (1 - e) / ((1 + e) gamma),   phi = w t
 *
 * Flight and law, A sin(w t') = A sin(w t) + v (t' - t) - g/2 (t' - t)^2 and
 * v' = (1 + e) A w cos(w t') - e (v - g (t' - t)), linear in a disturbance dt, dv of that orbit,
 * with k = (1 + e) / g and S = (1 + e) A w^2 sin(phi):
 *
 *   dt' = dt + k dv,   dv' = -S dt + (e^2 - S k) dv,   trace 1 + e^2 - S k,   determinant e^2
 *
 * It grows with a change of sign each time, a period doubling, from 1 + trace + det = 0 on:
 * gamma sin(phi) = 2 (1 + e^2) / (1 + e)^2. So the orbit is stable for
 *
 *   G_1 < gamma < sqrt(G_1^2 + (2 (1 + e^2) / (1 + e)^2)^2),   G_1 = pi (1 - e) / (1 + e) */
#include "shaken_ball.h"

#include <math.h>
#include <stddef.h>

static const double pi = 3.14159265358979323846;

static double frequency(const shaken_ball *p)
{
  return 2 * pi / p->T;
}

/* Phase of the table at the start: that of the impacts of the orbit, if it exists. */
static double phase(const shaken_ball *p)
{
  double low, high;
  shaken_ball_stable(p, &low, &high);
  return low < p->gamma ? acos(low / p->gamma) : 0;
}

/* At the time t. */
static double angle(const shaken_ball *p, double t)
{
  return frequency(p) * t + phase(p);
}

double shaken_ball_amplitude(const shaken_ball *p)
{
  return p->gamma * p->ball.g / (frequency(p) * frequency(p));
}

void shaken_ball_stable(const shaken_ball *p, double *low, double *high)
{
  double e = p->ball.e_N, second = 2 * (1 + e * e) / ((1 + e) * (1 + e));
  *low = pi * (1 - e) / (1 + e);
  *high = sqrt(*low * *low + second * second);
}

/* h = A sin(angle); the ball is the first member of its parameters. */
static void move_table(const table_ball *b, double t, double h[3])
{
  const shaken_ball *p = (const shaken_ball *)(const void *)b;
  double A = shaken_ball_amplitude(p);
  h[0] = A * sin(angle(p, t));
  h[1] = A * frequency(p) * cos(angle(p, t));
  h[2] = -p->gamma * p->ball.g * sin(angle(p, t));
}

static int build(void *base, nsdae_system **system, nsdae_error *error)
{
  shaken_ball *p = base;
  p->ball.table = move_table;
  return table_ball_build(&p->ball, "table", system, error);
}

/* On the table, with the velocity after an impact of the orbit. The kick disturbs it to show
 * whether the orbit is stable. */
static void start(const void *base, double *q0, double *v0)
{
  const shaken_ball *p = base;
  q0[0] = shaken_ball_amplitude(p) * sin(phase(p));
  v0[0] = p->ball.g * p->T / 2 * p->kick;
}

static int bodies(const void *base, nsdae_trajectory *file, nsdae_error *error)
{
  const shaken_ball *p = base;
  const double size = p->ball.g * p->T * p->T / 50;
  const nsdae_body body[] = {
      {.name = "table",
       .shape = NSDAE_SHAPE_BOX,
       .size = {10 * size, size / 2, size},
       .position =
           {"0",
            "gamma*g*(T/(2*pi))^2*sin(2*pi/T*t+acos(min(1,pi*(1-e_N)/(1+e_N)/gamma)))-g*T^2/200"}},
      {.name = "ball",
       .shape = NSDAE_SHAPE_SPHERE,
       .size = {size},
       .position = {"0", "y+g*T^2/50"}},
  };
  return nsdae_trajectory_set_bodies(file, 2, body, error);
}

#define AT(field) offsetof(shaken_ball, field)

static const nsdae_param entries[] = {
    {"gamma", "1", "acceleration of the table over gravity", NSDAE_PARAM_REAL, AT(gamma), 1.2, 0,
     INFINITY, 0, NULL},
    {"e_N", "1", "restitution of the table", NSDAE_PARAM_REAL, AT(ball.e_N), 0.5, 0, 1, 0, NULL},
    {"T", "s", "period of the table", NSDAE_PARAM_REAL, AT(T), 0.02, 0, INFINITY, NSDAE_OPEN_MIN,
     NULL},
    {"m", "kg", "mass", NSDAE_PARAM_REAL, AT(ball.m), 0.001, 0, INFINITY, NSDAE_OPEN_MIN, NULL},
    {"g", "m/s^2", "gravity", NSDAE_PARAM_REAL, AT(ball.g), 9.81, 0, INFINITY, NSDAE_OPEN_MIN,
     NULL},
    {"kick", "1", "velocity at the start over that of the orbit of one bounce a period",
     NSDAE_PARAM_REAL, AT(kick), 1.01, 0, INFINITY, 0, NULL},
};

static const char *remark(const void *base)
{
  (void)base;
  return "the table does work: the energy balance is what it did";
}

static const nsdae_params table = {entries, (int)(sizeof entries / sizeof *entries)};
static shaken_ball parameters;

const driver_model shaken_ball_model = {.name = "shaken-ball",
                                        .summary = "a ball that bounces on a shaking table",
                                        .parameters = &table,
                                        .base = &parameters,
                                        .t_end = 2,
                                        .dt = 0.001,
                                        .build = build,
                                        .start = start,
                                        .remark = remark,
                                        .bodies = bodies};
