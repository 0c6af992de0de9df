/* Dominoes of height h and thickness d that stand s apart; the first is pushed. Each that has been
 * hit leans on the next, so that all behind the foremost fall together (J. M. J. van Leeuwen, The
 * domino effect, Am. J. Phys. 78, 2010): with theta_i the angle of domino i, which turns about its
 * lower front edge, the upper front edge of i slides along the back of i + 1,
 *
 *   h sin(theta_i - theta_(i+1)) = (s + d) cos theta_(i+1) - d
 *
 * so that the foremost angle gives all others. Between collisions the energy is kept; at a
 * collision (theta_n = asin(s / h)) the next one joins without rebound, the momentum of the new
 * freedom being kept:
 *
 *   theta_(n+1)' sum_(i<=n+1) c_i^2 = sum_(i<=n) theta_i' c_i,   c_i = d theta_i / d theta_(n+1) */
#include "dominoes.h"

#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include "scene.h"

static int build(void *base, nsdae_system **system, nsdae_error *error)
{
  dominoes *p = base;
  int status = world_begin(&p->world, 2, p->g, p->mu, 0, error);
  if (status < 0) return status;
  nsdae_bodies_set_pair(p->world, 0, 1, p->floor_mu, 0, 0);
  p->hit_first = p->hit_last = p->speed = 0;
  for (int i = 0; i < p->n && status >= 0; i++) {
    double x = i * (p->s + p->d);
    const double corner[8] = {x - p->d, 0, x, 0, x, p->h, x - p->d, p->h};
    status = world_add_block(p->world, 4, corner);
  }
  return world_end(p->world, status, system, error);
}

/* The first turns about its lower front edge. */
static void start(const void *base, double *q0, double *v0)
{
  const dominoes *p = base;
  nsdae_bodies_get_start(p->world, q0, v0);
  v0[0] = p->push * p->h / 2;
  v0[1] = p->push * p->d / 2;
  v0[2] = -p->push;
}

/* A domino is hit when it begins to turn. */
static void follow(void *base, const nsdae_record *r)
{
  dominoes *p = base;
  int first = p->n / 2, last = p->n - 2;
  const double turned = 1e-3;
  if (p->hit_first == 0 && r->q[3 * first + 2] < -turned) p->hit_first = r->time;
  if (p->hit_last == 0 && r->q[3 * last + 2] < -turned) p->hit_last = r->time;
  if (p->hit_last > p->hit_first)
    p->speed = (last - first) * (p->s + p->d) / (p->hit_last - p->hit_first);
}

/* theta_i and c_i = d theta_i / d theta_n of the dominoes behind the foremost, which is at theta;
 * those on the floor do not move. Returns their number. */
enum { CHAIN_MAX = 400 };

static int chain(const dominoes *p, double theta, int most, double *angle, double *rate)
{
  int n = 0;
  angle[0] = theta;
  rate[0] = 1;
  while (++n < most) {
    double before = angle[n - 1], s = ((p->s + p->d) * cos(before) - p->d) / p->h;
    double slope = 1 - (p->s + p->d) * sin(before) / p->h / sqrt(1 - s * s);
    angle[n] = before + asin(s);
    rate[n] = rate[n - 1] * slope;
  }
  return n;
}

/* Height of the centre of a domino that turned by theta about its edge. */
static double height(const dominoes *p, double theta)
{
  return (p->h * cos(theta) + p->d * sin(theta)) / 2;
}

static double potential(const dominoes *p, const double *angle, int n)
{
  double sum = 0;
  for (int i = 0; i < n; i++) sum += p->g * height(p, angle[i]);
  return sum;
}

static double inertia(const double *rate, int n)
{
  double sum = 0;
  for (int i = 0; i < n; i++) sum += rate[i] * rate[i];
  return sum;
}

/* theta' of the foremost when it has fallen from 0 to theta with the energy E of n dominoes of mass
 * 1: J theta'^2 sum c^2 / 2 + U = E; J about the edge. */
static double speed_at(const dominoes *p, double theta, int n, double E)
{
  double angle[CHAIN_MAX], rate[CHAIN_MAX], J = (p->h * p->h + p->d * p->d) / 3;
  n = chain(p, theta, n, angle, rate);
  return sqrt(fmax(2 * (E - potential(p, angle, n)), 0) / (J * inertia(rate, n)));
}

/* Time of the fall from 0 to the next one: the integral of 1 / theta' by Gauss's rule of two
 * points. */
static double fall_time(const dominoes *p, int n, double E)
{
  enum { PARTS = 200 };
  double end = asin(p->s / p->h), width = end / (double)PARTS, time = 0;
  for (int i = 0; i < PARTS; i++)
    for (int side = -1; side <= 1; side += 2)
      time += width / 2 / speed_at(p, (i + 0.5 + side / sqrt(12)) * width, n, E);
  return time;
}

double dominoes_theory(const dominoes *p)
{
  double angle[CHAIN_MAX], rate[CHAIN_MAX], J = (p->h * p->h + p->d * p->d) / 3;
  double w = p->push, time = 0, end = asin(p->s / p->h);
  int stages = p->n < 100 ? p->n : 100;
  for (int n = 1; n <= stages; n++) {
    chain(p, 0, n, angle, rate);
    double E = J * w * w * inertia(rate, n) / 2 + potential(p, angle, n);
    time = fall_time(p, n, E);
    double fast = speed_at(p, end, n, E), momentum = 0;
    chain(p, end, n, angle, rate);
    /* rates by the new foremost one: c of the chain behind it at 0, whose next angle is end */
    double next[CHAIN_MAX], by_next[CHAIN_MAX];
    chain(p, 0, n + 1, next, by_next);
    for (int i = 0; i < n; i++) momentum += fast * rate[i] * by_next[i + 1];
    w = momentum / inertia(by_next, n + 1);
  }
  return (p->s + p->d) / time;
}

static void conclude(const void *base)
{
  const dominoes *p = base;
  double scale = sqrt(p->g * p->h), theory = dominoes_theory(p);
  if (p->speed > 0)
    printf("wave: %.4f m/s, %.4f sqrt(g h); ", p->speed, p->speed / scale);
  else
    printf("the wave has not come to the end; ");
  printf("theory (van Leeuwen 2010; smooth, no sliding on the floor) %.4f m/s, %.4f sqrt(g h)\n",
         theory, theory / scale);
}

static int figure(const void *base, driver_figure *f)
{
  const dominoes *p = base;
  *f = (driver_figure){"speed of the wave", "m/s", p->speed, dominoes_theory(p)};
  return p->speed > 0;
}

#define AT(field) offsetof(dominoes, field)

static const nsdae_param entries[] = {
    {"n", "1", "number of dominoes", NSDAE_PARAM_INT, AT(n), 40, 4, CHAIN_MAX - 1, 0, NULL},
    {"h", "m", "height", NSDAE_PARAM_REAL, AT(h), 0.048, 0, INFINITY, NSDAE_OPEN_MIN, NULL},
    {"d", "m", "thickness", NSDAE_PARAM_REAL, AT(d), 0.0075, 0, INFINITY, NSDAE_OPEN_MIN, NULL},
    {"s", "m", "distance of two dominoes, less than h", NSDAE_PARAM_REAL, AT(s), 0.024, 0, INFINITY,
     NSDAE_OPEN_MIN, NULL},
    {"mu", "1", "friction between them", NSDAE_PARAM_REAL, AT(mu), 0, 0, INFINITY, 0, NULL},
    {"floor_mu", "1", "friction on the floor", NSDAE_PARAM_REAL, AT(floor_mu), 2, 0, INFINITY, 0,
     NULL},
    {"push", "rad/s", "angular velocity of the first at the start", NSDAE_PARAM_REAL, AT(push), 10,
     0, INFINITY, NSDAE_OPEN_MIN, NULL},
    {"g", "m/s^2", "gravity", NSDAE_PARAM_REAL, AT(g), 9.81, 0, INFINITY, NSDAE_OPEN_MIN, NULL},
};

static const nsdae_params table = {entries, (int)(sizeof entries / sizeof *entries)};
static dominoes parameters;

const driver_model dominoes_model = {.name = "dominoes",
                                     .summary = "a row of dominoes, of which the first is pushed",
                                     .parameters = &table,
                                     .base = &parameters,
                                     .t_end = 1.6,
                                     .dt = 2e-4,
                                     .method = NSDAE_METHOD_MOREAU,
                                     .build = build,
                                     .start = start,
                                     .follow = follow,
                                     .figure = figure,
                                     .conclude = conclude};
