#include "solver_contract.h"

#include <math.h>
#include <string.h>

/* Products of the evaluation of a point and its residual: J and J^T in double-double arithmetic
 * alone take 1.2 to 1.9. The assembly of a matrix and its solves are counted as much again, each:
 * all of a step but its operations in LAPACK, see newton_system.c. */
static const double EVALUATION = 4;

/* Work between two calls of the caller, products times items: 0.05 to 0.1 s at 0.024 to 0.047 us.
 */
static const double BETWEEN = 2e6;

int nsdae_fc_spend(const nsdae_fc_island *s, nsdae_fc_iterate *it, const nsdae_fc_budget *b,
                   double products)
{
  const double every = BETWEEN / s->fc.n, before = floor(it->work.products / every);
  it->work.products += products;
  if (b->watch && floor(it->work.products / every) > before)
    it->work.interrupted |= b->watch(it, b->user) != 0;
  return !it->work.interrupted && it->work.products < b->products;
}

int nsdae_fc_spend_sweep(const nsdae_fc_island *s, nsdae_fc_iterate *it, const nsdae_fc_budget *b)
{
  if (it->work.sweeps >= b->sweeps || !nsdae_fc_spend(s, it, b, 2)) return 0;
  it->work.sweeps++;
  return 1;
}

int nsdae_fc_spend_step(const nsdae_fc_island *s, nsdae_fc_iterate *it, const nsdae_fc_budget *b)
{
  if (it->work.steps >= b->steps || !nsdae_fc_spend(s, it, b, 3 * EVALUATION + s->system->cost))
    return 0;
  it->work.steps++;
  return 1;
}

void nsdae_fc_set_point(nsdae_fc_island *s, const double *r)
{
  if (r != s->fc.r) memcpy(s->fc.r, r, nsdae_fc_bytes(s));
  nsdae_fc_velocities(&s->fc, s->fc.r, s->fc.y, s->fc.u);
}

double nsdae_fc_offer(nsdae_fc_island *s, nsdae_fc_iterate *it)
{
  double residual = nsdae_fc_residual(&s->fc, s->fc.r, s->fc.u);
  if (residual < it->residual) {
    it->residual = residual;
    memcpy(it->r, s->fc.r, nsdae_fc_bytes(s));
    if (it->low) memset(it->low, 0, nsdae_fc_bytes(s));
  }
  return residual;
}

int nsdae_fc_system_ready(nsdae_fc_island *s)
{
  if (!s->analysed) s->analysed = nsdae_fc_system_analyse(s->system, &s->fc) == NSDAE_OK;
  s->newton.system = s->system;
  return s->analysed;
}

int nsdae_fc_trivial(nsdae_fc_island *s, nsdae_fc_iterate *it, const nsdae_fc_budget *b)
{
  memset(s->fc.r, 0, nsdae_fc_bytes(s));
  nsdae_fc_set_point(s, s->fc.r);
  (void)nsdae_fc_spend(s, it, b, EVALUATION);
  nsdae_fc_offer(s, it);
  return it->residual <= b->tol;
}

int nsdae_fc_infeasible(nsdae_fc_island *s, nsdae_fc_iterate *it, const nsdae_fc_budget *b)
{
  (void)it;
  (void)b;
  int found = nsdae_fc_farkas_find(s->farkas, &s->fc, s->proof);
  return found < 0 ? NSDAE_FC_NO_MEMORY : found ? NSDAE_FC_INFEASIBLE : NSDAE_FC_UNSOLVED;
}
