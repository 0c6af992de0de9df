#include "smooth.h"

#include <math.h>
#include <string.h>

/* The error of backward differences of variable order, which change sign from step to step less
 * often than those of the pairs, adds up over a run to more than rtol: their tolerances are smaller
 * by this factor (measured on a stiff chain and on sliding blocks: 0.03 to 0.3 for equal errors at
 * the end). */
static const double STIFF_TOLERANCE = 0.1;

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
  g->y = NSDAE_ARENA_DOUBLES(arena, g->steps.n);
  g->ydot = NSDAE_ARENA_DOUBLES(arena, g->steps.n);
}

int nsdae_smooth_make(nsdae_smooth *g)
{
  g->cause = "";
  return nsdae_ida_create(&g->implicit, &g->ida);
}

void nsdae_smooth_destroy(nsdae_smooth *g)
{
  nsdae_ida_destroy(&g->ida);
}

/* y and y' of the forces that f gives at q, v; the rates of the forces are taken for zero, which no
 * equation has. */
static int start_ida(nsdae_smooth *g, double t, const double *qv)
{
  const nsdae_runge_kutta *s = &g->steps;
  const nsdae_ida_tolerances tolerances = {STIFF_TOLERANCE * s->rtol, STIFF_TOLERANCE * s->atol,
                                           s->max_step, s->force, s->max_step};
  size_t controlled = (size_t)s->controlled, forces = (size_t)s->forces;
  memset(g->y, 0, (size_t)s->n * sizeof *qv);
  memcpy(g->y, qv, controlled * sizeof *qv);
  if (s->rate(t, g->y, g->ydot, 1, s->user) != 0) return NSDAE_E_CALLBACK;
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

/* sum += the integrals from a to b within the last step of IDA. */
static int quadrature(nsdae_smooth *g, double a, double b, double *sum)
{
  static const double node[] = {-0.77459666924148337704, 0, 0.77459666924148337704}; /* sqrt(3/5) */
  static const double weight[] = {5.0 / 9, 8.0 / 9, 5.0 / 9};
  const nsdae_runge_kutta *s = &g->steps;
  int further = integrals(g) - s->forces;
  for (int i = 0; i < 3; i++) {
    double t = (a + b) / 2 + node[i] * (b - a) / 2, part = weight[i] * (b - a) / 2;
    double *forces = g->y + s->controlled, *powers = g->ydot + g->implicit.n;
    int status = nsdae_ida_read(g->ida, t, 0, g->y);
    if (status == NSDAE_OK && further > 0) status = nsdae_ida_read(g->ida, t, 1, g->ydot);
    if (status < 0) return status;
    if (further > 0 && g->powers(t, g->y, g->ydot, powers, s->user) != 0) return NSDAE_E_CALLBACK;
    for (int j = 0; j < s->forces; j++) sum[j] += part * forces[j];
    for (int j = 0; j < further; j++) sum[s->forces + j] += part * powers[j];
  }
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
    return quadrature(g, g->from, g->to, g->sum[1]);
  }
  status = nsdae_runge_kutta_advance(&g->steps);
  g->to = g->steps.t;
  return status;
}

int nsdae_smooth_read(nsdae_smooth *g, double t, int count, double *z)
{
  int controlled = g->steps.controlled, first = count < controlled ? count : controlled;
  if (!g->is_stiff) {
    nsdae_runge_kutta_read(&g->steps, t, count, z);
    return NSDAE_OK;
  }
  int status = nsdae_ida_read(g->ida, t, 0, g->y);
  if (status < 0) return status;
  memcpy(z, g->y, (size_t)first * sizeof *z);
  if (count == first) return NSDAE_OK;
  memcpy(z + controlled, g->sum[t == g->to], (size_t)integrals(g) * sizeof *z);
  return t > g->from && t < g->to ? quadrature(g, g->from, t, z + controlled) : NSDAE_OK;
}
