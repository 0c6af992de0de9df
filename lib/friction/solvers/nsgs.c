/* Nonlinear block Gauss-Seidel (Moreau 1999; Jourdan, Alart, Jean, Comput. Methods Appl. Mech. Eng.
 * 155 (1998) 31): each contact is solved exactly in turn, the others fixed,
 *
 *   r_c := the solution of Coulomb's law with u_c = W_cc r_c + (q_c + sum W_cj r_j, j != c).
 *
 * nsdae_fc_nsgs extrapolates after every other sweep (anderson.h) and follows rays (ratio_step.c).
 * nsdae_fc_nsgs_plain does neither: if many contacts slide, extrapolation diverges. */
#include <math.h>
#include <string.h>

#include "solver_contract.h"

/* Sweeps between two evaluations of the residual, each of which costs two sweeps: 5 % of them. With
 * 20, 40 and 80 40, 39 and 40 of 40 seeded problems are solved to 1e-8. */
enum { BETWEEN = 40 };

/* Sweeps whose changes may stagnate: those of sliding heaps do until contacts change their state.
 * Of 1600 steps of two heaps of spheres with 500 sweeps at most 173 are unsolved, 348 without it.
 */
enum { PLATEAU = 500 };

/* Sweeps between two extrapolations (alternating Anderson: Pratapa, Suryanarayana, Pask, J. Comput.
 * Phys. 306 (2016) 43). Of 114 warm starts of a sliding heap with 500 sweeps at most, 1, 2 and 3
 * leave 22, 20 and 22 unsolved after 158, 159 and 166 sweeps in the mean; one costs a third of a
 * sweep. */
enum { EACH = 2 };

/* Sweeps that the budget still allows. */
static double left(const nsdae_fc_iterate *it, const nsdae_fc_budget *b)
{
  return fmin((double)(b->sweeps - it->work.sweeps), (b->products - it->work.products) / 2);
}

static double evaluate(nsdae_fc_island *s, nsdae_fc_iterate *it)
{
  nsdae_fc_velocities(&s->fc, s->fc.r, s->fc.y, s->fc.u);
  return nsdae_fc_offer(s, it);
}

/* Ends if the changes of sweeps are zero, or stagnate: one that has not been halved for since >
 * PLATEAU sweeps does not reach tol, at that rate, in the sweeps that the budget still allows. */
static int accelerated(nsdae_fc_island *s, nsdae_fc_iterate *it, const nsdae_fc_budget *b)
{
  double mark = INFINITY;
  int checked = 0, evaluated = 0, since = 0;
  nsdae_fc_anderson_begin(&s->anderson);
  for (int done = 1; nsdae_fc_spend_sweep(s, it, b); done++, since++) {
    double change = nsdae_fc_anderson_sweep(&s->anderson, &s->fc, s->slip);
    if (nsdae_fc_sweep_converged(&s->fc, b->tol, &checked) || done - evaluated >= BETWEEN) {
      if (evaluate(s, it) <= b->tol) return 1;
      evaluated = done;
    }
    if (change <= 0.5 * mark) mark = change, since = 0;
    if (!(change > 0) || left(it, b) < 1) break;
    if (since > PLATEAU && since * log2(fmax(2, mark / b->tol)) > left(it, b)) break;
    if (done % EACH != 0) continue;
    nsdae_fc_anderson_extrapolate(&s->anderson, &s->fc);
    nsdae_fc_ratio_step(&s->anderson, &s->fc);
  }
  return evaluate(s, it) <= b->tol;
}

/* Ends if half of the sweeps that the budget allowed have not halved the residual. */
static int plain(nsdae_fc_island *s, nsdae_fc_iterate *it, const nsdae_fc_budget *b)
{
  double mark = it->residual, idle = 0, most = left(it, b) / 2, change = 1;
  while (idle <= most && change > 0) {
    for (int k = 0; k < BETWEEN; k++) {
      if (!nsdae_fc_spend_sweep(s, it, b)) return 0;
      change = nsdae_fc_sweep(&s->fc, s->slip);
    }
    if (evaluate(s, it) <= b->tol) return 1;
    idle += BETWEEN;
    if (it->residual <= 0.5 * mark) mark = it->residual, idle = 0;
  }
  return 0;
}

/* From the iterate; 1: it is a solution. */
static int begin_sweeps(nsdae_fc_island *s, nsdae_fc_iterate *it, const nsdae_fc_budget *b)
{
  int seen = 0;
  memset(s->slip, 0, (size_t)s->fc.n * sizeof *s->slip);
  memcpy(s->fc.r, it->r, nsdae_fc_bytes(s));
  nsdae_fc_sweep_begin(&s->fc);
  return nsdae_fc_sweep_converged(&s->fc, b->tol, &seen) && evaluate(s, it) <= b->tol;
}

int nsdae_fc_nsgs(nsdae_fc_island *s, nsdae_fc_iterate *it, const nsdae_fc_budget *b)
{
  (void)(begin_sweeps(s, it, b) || accelerated(s, it, b));
  return it->residual <= b->tol;
}

int nsdae_fc_nsgs_plain(nsdae_fc_island *s, nsdae_fc_iterate *it, const nsdae_fc_budget *b)
{
  (void)(begin_sweeps(s, it, b) || plain(s, it, b));
  return it->residual <= b->tol;
}
