/* Iterative refinement as for linear systems (Wilkinson, "Rounding Errors in Algebraic Processes",
 * 1963; of systems with extra precision Demmel et al., ACM Trans. Math. Softw. 32 (2006) 325): the
 * velocities of a point are those of the data as given, its impulses in two parts; from it on the
 * problem is solved for what is still missing, small and of the velocities at hand:
 *
 *   u = u_0 + W' dr,   0 = r_0 + dr - P(r_0 + dr - u^)
 *
 * in which an error of W' = J'^T J', rounded, is one of dr. Where r_0 lies outside the cone is a
 * difference of what is large, and alone needs twice the precision (cone.h). */
#include "precise.h"

#include <math.h>
#include <string.h>

#include "certificate.h"
#include "twice.h"

/* Newton steps of a correction, and proximal problems of it that may fail. */
enum { STEPS = 100, FAILURES = 6 };

/* Steps of an interior point; how many of them are tried that do not make the residual less by a
 * factor; corrections from each, of which one leaves a quarter less than the one before, or, past a
 * kink, some times as much. */
enum { MIDDLE = 300, FRUITLESS = 4, CORRECTIONS = 10 };
static const double FRUIT = 0.7;

/* The first proximal term, and how closely the problem with rounded data is solved. */
static const double ALPHA = 1e-8, AIM = 0.1;

void nsdae_fc_precise_layout(nsdae_fc_precise *p, const nsdae_fc *fc, nsdae_arena *arena)
{
  p->high = NSDAE_ARENA_DOUBLES(arena, 3L * fc->n);
  p->low = NSDAE_ARENA_DOUBLES(arena, 3L * fc->n);
  p->best = NSDAE_ARENA_DOUBLES(arena, 3L * fc->n);
  p->best_low = NSDAE_ARENA_DOUBLES(arena, 3L * fc->n);
  p->q = NSDAE_ARENA_DOUBLES(arena, 3L * fc->n);
  p->held = NSDAE_ARENA_DOUBLES(arena, 3L * fc->n);
}

/* The part that one double holds, and what is left. */
static void normalise(nsdae_fc_precise *p, int m)
{
  for (int i = 0; i < m; i++) {
    double sum = p->high[i] + p->low[i];
    p->low[i] -= sum - p->high[i];
    p->high[i] = sum;
  }
}

/* The island as it is from high + low on: r = 0, and q the velocities of that. */
static void relocate(nsdae_fc_precise *p, nsdae_fc *c)
{
  const nsdae_fc_whole *w = c->whole;
  nsdae_fc_scatter(c, p->high, w->r);
  nsdae_fc_scatter(c, p->low, w->r_low);
  nsdae_fc_island_velocities(w, c->label, w->r, w->r_low, w->u);
  nsdae_fc_gather(c, w->u, c->items.q);
  memset(c->r, 0, 3 * (size_t)c->n * sizeof *c->r);
  nsdae_fc_velocities(c, c->r, c->y, c->u);
}

/* The correction fc->r becomes part of the point. */
static void add(nsdae_fc_precise *p, const nsdae_fc *c)
{
  for (int i = 0; i < 3 * c->n; i++) nsdae_twice_add(1, c->r[i], p->high + i, p->low + i);
  normalise(p, 3 * c->n);
}

/* At most so many steps. */
static void correct(nsdae_fc_precise *p, nsdae_fc_newton *s, int most, double tol)
{
  s->most = s->steps + most;
  s->failures = FAILURES;
  nsdae_fc_proximal(s, ALPHA, AIM * tol);
  add(p, s->fc);
}

/* While its base is the point, the island has other velocities of its own, and another r. */
static void begin(nsdae_fc_precise *p, nsdae_fc *c)
{
  memcpy(p->q, c->items.q, 3 * (size_t)c->n * sizeof *p->q);
  memcpy(p->held, c->r, 3 * (size_t)c->n * sizeof *p->held);
  c->base = p->high;
  c->base_low = p->low;
}

static void end(nsdae_fc_precise *p, nsdae_fc *c)
{
  memcpy(c->items.q, p->q, 3 * (size_t)c->n * sizeof *p->q);
  c->base = c->base_low = NULL;
  memcpy(c->r, p->held, 3 * (size_t)c->n * sizeof *c->r);
  nsdae_fc_velocities(c, c->r, c->y, c->u);
}

static double look(nsdae_fc_precise *p, nsdae_fc *c)
{
  relocate(p, c);
  return nsdae_fc_residual(c, c->r, c->u);
}

double nsdae_fc_precise_residual(nsdae_fc_precise *p, nsdae_fc *c)
{
  begin(p, c);
  double residual = look(p, c);
  end(p, c);
  return residual;
}

/* Keeps the point where it is better than all before. */
static void judge(nsdae_fc_precise *p, nsdae_fc *c, double *best)
{
  const size_t bytes = 3 * (size_t)c->n * sizeof *p->high;
  double residual = look(p, c);
  if (!(residual < *best)) return;
  memcpy(p->best, p->high, bytes);
  memcpy(p->best_low, p->low, bytes);
  *best = residual;
}

static void back_to_best(nsdae_fc_precise *p, const nsdae_fc *c)
{
  const size_t bytes = 3 * (size_t)c->n * sizeof *p->high;
  memcpy(p->high, p->best, bytes);
  memcpy(p->low, p->best_low, bytes);
}

/* Through the middles of convex problems, each with the shift of the one before, and corrections
 * from each, as long as that leads to better points. */
static void go_through_middles(nsdae_fc_precise *p, nsdae_fc_newton *s, nsdae_fc_interior *interior,
                               double tol, double *best)
{
  nsdae_fc *c = s->fc;
  double least = *best;
  back_to_best(p, c);
  look(p, c);
  nsdae_fc_shift(c, interior->shift);
  for (int since = 0; since < FRUITLESS && tol < *best; since++) {
    s->most = s->steps + MIDDLE;
    if (!nsdae_fc_interior_run(interior, s)) return;
    add(p, c);
    judge(p, c, best);
    nsdae_fc_shift(c, interior->shift);
    for (int k = 0; k < CORRECTIONS && tol < *best; k++) {
      correct(p, s, STEPS, tol);
      judge(p, c, best);
    }
    if (*best < FRUIT * least) least = *best, since = -1;
  }
}

/* From the best point: where items are locked in one another the correction is not small, and
 * creeping ends where r alone has no more digits. */
static void creep_on(nsdae_fc_precise *p, nsdae_fc_newton *s, int most, double tol)
{
  back_to_best(p, s->fc);
  look(p, s->fc);
  s->most = s->steps + most;
  nsdae_fc_creep(s, most, tol);
  add(p, s->fc);
}

/* How often it may creep on: not where it does not get to tol at the pace it had. */
static int once_more(double before, double now, int times, double tol)
{
  return log(before / now) * times >= log(now / tol) ? times : 0;
}

double nsdae_fc_precise_run(nsdae_fc_precise *p, nsdae_fc_newton *s, nsdae_fc_interior *interior,
                            double tol, int creep, int times)
{
  nsdae_fc *c = s->fc;
  const int most = s->most < STEPS ? s->most : STEPS;
  double before, best = INFINITY;
  begin(p, c);
  s->steps = 0;
  judge(p, c, &best);
  do {
    before = best;
    if (!(best > tol && best < INFINITY)) break;
    correct(p, s, most, tol);
    judge(p, c, &best);
    if (best <= 0.5 * before || times == 0) continue;
    if (interior) go_through_middles(p, s, interior, tol, &best);
    interior = NULL;
    if (best <= 0.5 * before) continue;
    creep_on(p, s, creep, tol);
    judge(p, c, &best);
    times = once_more(before, best, times - 1, tol);
  } while (best <= 0.5 * before || times > 0);
  if (best < INFINITY) back_to_best(p, c);
  end(p, c);
  return best;
}
