#include "smooth.h"

#include <math.h>
#include <string.h>

#include "vector.h"

static int integrals(const nsdae_smooth *g)
{
  return g->steps.n - g->steps.controlled;
}

void nsdae_smooth_layout(nsdae_smooth *g, nsdae_arena *arena)
{
  g->implicit.differential = g->steps.controlled;
  g->implicit.positions = g->steps.positions;
  g->implicit.n = g->steps.controlled + g->steps.forces;
  nsdae_runge_kutta_layout(&g->steps, arena);
  for (int i = 0; i < 2; i++) g->sum[i] = NSDAE_ARENA_DOUBLES(arena, integrals(g));
  nsdae_arena_doubles(arena, g->steps.n, (double **[]){&g->y, &g->ydot, NULL});
  g->power = NSDAE_ARENA_DOUBLES(arena, 3L * (integrals(g) - g->steps.forces));
}

int nsdae_smooth_make(nsdae_smooth *g, int integrator)
{
  g->cause = "";
  int status = nsdae_ida_create(&g->implicit, &g->ida), needed = integrator == NSDAE_INTEGRATOR_IDA;
  return status == NSDAE_E_UNSUPPORTED && !needed ? NSDAE_OK : status;
}

/* y and y' of the forces that f gives at q, v; the rates of the forces are taken for zero, which no
 * equation has. */
static int start_ida(nsdae_smooth *g, double t, const double *qv)
{
  const nsdae_runge_kutta *s = &g->steps;
  const nsdae_ida_tolerances tolerances = {s->rtol, s->atol, s->span, s->force,
                                           fmin(s->max_step, s->span)};
  size_t controlled = (size_t)s->controlled, forces = (size_t)s->forces;
  memset(g->y, 0, (size_t)s->n * sizeof *qv);
  memcpy(g->y, qv, controlled * sizeof *qv);
  int code = s->rate(t, g->y, g->ydot, 1, s->user);
  if (code != 0) return nsdae_progress_status(code);
  memcpy(g->y + controlled, g->ydot + controlled, forces * sizeof *qv);
  memset(g->ydot + controlled, 0, forces * sizeof *qv);
  return nsdae_ida_start(g->ida, &tolerances, t, g->y, g->ydot, g->first);
}

int nsdae_smooth_start(nsdae_smooth *g, double t, const double *qv)
{
  g->from = g->to = t;
  g->cause = "";
  for (int i = 0; i < 2; i++) memset(g->sum[i], 0, (size_t)integrals(g) * sizeof *qv);
  if (g->is_stiff) return start_ida(g, t, qv);
  memset(g->y, 0, (size_t)g->steps.n * sizeof *qv);
  memcpy(g->y, qv, (size_t)g->steps.controlled * sizeof *qv);
  return nsdae_runge_kutta_start(&g->steps, t, g->y);
}

/* Gauss's nodes and weights in [-1, 1]: 0 and +- sqrt(3 / 5). */
static const double node[] = {-0.77459666924148337704, 0, 0.77459666924148337704};
static const double weight[] = {5.0 / 9, 8.0 / 9, 5.0 / 9};

static double node_in(double a, double b, int i)
{
  return (a + b) / 2 + node[i] * (b - a) / 2;
}

/* The rates of the further integrals at the nodes of the last step of IDA. */
static int find_powers(nsdae_smooth *g)
{
  int further = integrals(g) - g->steps.forces;
  for (int i = 0; i < 3 && further > 0; i++) {
    double t = node_in(g->from, g->to, i);
    int status = nsdae_ida_read(g->ida, t, 0, g->y);
    if (status == NSDAE_OK) status = nsdae_ida_read(g->ida, t, 1, g->ydot);
    if (status < 0) return status;
    int code = g->powers(t, g->y, g->ydot, g->power + i * further, g->steps.user);
    if (code != 0) return nsdae_progress_status(code);
  }
  return NSDAE_OK;
}

/* sum := the integrals up to t within the last step of IDA. Of forces Gauss's sum from its start to
 * t; of powers the integral of the parabola through those at the nodes of the step, which is
 * Gauss's sum at its end. */
static int quadrature(nsdae_smooth *g, double t, double *sum)
{
  int forces = g->steps.forces, further = integrals(g) - forces;
  double h = (t - g->from) / 2;
  memcpy(sum, g->sum[0], (size_t)integrals(g) * sizeof *sum);
  if (!(g->to > g->from)) return NSDAE_OK; /* a step of IDA below the rounding of t */
  for (int i = 0; i < 3 && forces > 0; i++) {
    int status = nsdae_ida_read(g->ida, node_in(g->from, t, i), 0, g->y);
    if (status < 0) return status;
    nsdae_add(forces, weight[i] * h, g->y + g->steps.controlled, sum);
  }
  /* with x in [-1, 1] over the step, the integrals from -1 to x of Lagrange's polynomials */
  double x = 2 * (t - g->from) / (g->to - g->from) - 1, s = node[2];
  double square = (x * x * x + 1) / 3, line = (x * x - 1) / 2;
  const double part[] = {(square - s * line) / (2 * s * s), x + 1 - square / (s * s),
                         (square + s * line) / (2 * s * s)};
  for (int i = 0; i < 3; i++)
    nsdae_add(further, part[i] * (g->to - g->from) / 2, g->power + i * further, sum + forces);
  return NSDAE_OK;
}

int nsdae_smooth_advance(nsdae_smooth *g)
{
  int status;
  g->from = g->to;
  if (g->is_stiff) {
    status = nsdae_ida_advance(g->ida, &g->to);
    g->cause = status < 0 ? nsdae_ida_failure(g->ida) : "";
    if (status < 0) return status;
    memcpy(g->sum[0], g->sum[1], (size_t)integrals(g) * sizeof *g->sum[0]);
    status = find_powers(g);
    return status < 0 ? status : quadrature(g, g->to, g->sum[1]);
  }
  status = nsdae_runge_kutta_advance(&g->steps);
  g->from = g->steps.from; /* it may have gone back */
  g->to = g->steps.t;
  return status;
}

int nsdae_smooth_read(nsdae_smooth *g, double t, int count, double *z)
{
  int controlled = g->steps.controlled, first = count < controlled ? count : controlled;
  if (!g->is_stiff) return nsdae_runge_kutta_read(&g->steps, t, count, z);
  int status = nsdae_ida_read(g->ida, t, 0, g->y);
  if (status < 0) return status;
  memcpy(z, g->y, (size_t)first * sizeof *z);
  if (count == first) return NSDAE_OK;
  if (t > g->from && t < g->to) return quadrature(g, t, z + controlled);
  memcpy(z + controlled, g->sum[t == g->to], (size_t)integrals(g) * sizeof *z);
  return NSDAE_OK;
}
