/* Semismooth Newton on the natural map (Qi and Sun, Math. Program. 58 (1993) 353) inside the
 * proximal point method (Rockafellar, SIAM J. Control Optim. 14 (1976) 877), which replaces u by
 * u + alpha (r - z), and z by the solution of that, with alpha -> 0. With more impulses than
 * freedoms each of these problems still has one solution near z. Steps are whole: each is a choice
 * of which items are open, stick and slide; a line search stalls at the first kink. The first alpha
 * is a share of the residual, as in Levenberg-Marquardt methods (Fan and Yuan, Computing 74 (2005)
 * 23). */
#include <math.h>
#include <string.h>

#include "solver_contract.h"

/* Steps of one problem. With 15, 30 and 60 of 40 seeded problems 39 are solved. */
enum { INNER = 30 };

/* Steps in which the residual has to be halved. With 75, 150 and 300 of 40 seeded problems 39, 39
 * and 40 are solved to 1e-8. */
enum { IDLE = 150 };

/* Reduction of the square of its map that solves a problem. With 1e-2, 1e-4 and 1e-6 39 of the 40
 * are solved. */
static const double GAIN = 1e-4;

/* The first alpha over the residual. With 1e-3, 1e-2, 0.1 and 1 of 60 seeded problems 51, 51, 50
 * and 52 are solved to 1e-8; from 0.1 on the last problem may leave 1e-10. */
static const double SHARE = 1e-2;

/* A proximal term that changes velocities by rounding, and keeps the matrix of a step from a
 * solution regular if that is degenerate; 1e-13 does not. */
static const double SLIGHT = 1e-10;

/* A failed problem is repeated with ten times alpha, up to this one. With 1e2, 1e3 and 1e4 39 of
 * the 40 are solved. */
static const double LARGEST = 1e3;

/* Solves with the centre at fc.r, or goes back there; returns the steps, 0 if it failed. */
static int solve_problem(nsdae_fc_island *s, nsdae_fc_iterate *it, const nsdae_fc_budget *b)
{
  nsdae_fc_newton *newton = &s->newton;
  memcpy(newton->centre, s->fc.r, nsdae_fc_bytes(s));
  double start = nsdae_fc_newton_map(newton, s->fc.r, s->fc.u, 0), now = start;
  double goal = fmax(GAIN * start, 1e-2 * b->tol * b->tol), most = 1e4 * fmax(start, 1e-3);
  int steps = 0;
  while (now > goal && now <= most && steps < INNER && nsdae_fc_spend_step(s, it, b)) {
    now = nsdae_fc_newton_step(newton, now);
    steps++;
  }
  if (now <= goal && steps > 0) return steps;
  nsdae_fc_set_point(s, newton->centre);
  return 0;
}

static void begin_proximal(nsdae_fc_newton *newton, double alpha)
{
  newton->alpha = alpha;
  newton->epsilon = 0;
  newton->search = 0;
}

double nsdae_fc_proximal_points(nsdae_fc_island *s, nsdae_fc_iterate *it, const nsdae_fc_budget *b)
{
  nsdae_fc_newton *newton = &s->newton;
  double factor = 0.1, half = INFINITY, best;
  int mark = it->work.steps;
  nsdae_fc_velocities(&s->fc, s->fc.r, s->fc.y, s->fc.u);
  double residual = best = nsdae_fc_offer(s, it);
  memcpy(s->point, s->fc.r, nsdae_fc_bytes(s));
  begin_proximal(newton, fmax(SHARE * residual, NSDAE_FC_REGULAR));
  while (!(residual <= b->tol) && it->work.steps - mark < IDLE) {
    if (it->work.steps >= b->steps || it->work.products >= b->products || it->work.interrupted)
      break;
    int steps = solve_problem(s, it, b);
    if (steps == 0) {
      newton->alpha *= 10;
      factor = sqrt(factor);
      if (newton->alpha > LARGEST) break;
      continue;
    }
    double before = residual;
    residual = nsdae_fc_offer(s, it);
    if (residual < best) {
      best = residual;
      memcpy(s->point, s->fc.r, nsdae_fc_bytes(s));
    }
    if (best < half) half = best / 2, mark = it->work.steps;
    if (steps <= 5 || residual > 0.3 * before)
      newton->alpha = fmax(newton->alpha * factor, NSDAE_FC_REGULAR);
    factor = fmax(factor * factor, 0.1);
  }
  if (!(residual <= best)) nsdae_fc_set_point(s, s->point);
  return best;
}

int nsdae_fc_semismooth_newton(nsdae_fc_island *s, nsdae_fc_iterate *it, const nsdae_fc_budget *b)
{
  if (!nsdae_fc_system_ready(s)) return NSDAE_FC_NO_MEMORY;
  memcpy(s->fc.r, it->r, nsdae_fc_bytes(s));
  nsdae_fc_proximal_points(s, it, b);
  return it->residual <= b->tol;
}

void nsdae_fc_polish(nsdae_fc_island *s, nsdae_fc_iterate *it, const nsdae_fc_budget *b, int steps)
{
  begin_proximal(&s->newton, SLIGHT);
  nsdae_fc_set_point(s, it->r);
  for (int k = 0; k < steps && it->residual > 0; k++) {
    double before = it->residual;
    memcpy(s->newton.centre, s->fc.r, nsdae_fc_bytes(s));
    if (!nsdae_fc_spend_step(s, it, b) || isnan(nsdae_fc_newton_step(&s->newton, INFINITY))) break;
    if (!(nsdae_fc_offer(s, it) < before)) break;
  }
}
