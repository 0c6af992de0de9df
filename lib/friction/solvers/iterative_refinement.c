/* Iterative refinement as for linear systems (Wilkinson, "Rounding Errors in Algebraic Processes",
 * 1963; with extra precision: Demmel et al., ACM Trans. Math. Softw. 32 (2006) 325). The velocities
 * u_0 of a point r_0 are those of the data as given, r_0 in double-double arithmetic; the problem
 * is solved for what r_0 lacks, by semismooth Newton, and if that no longer helps by aclm:
 *
 *   u = u_0 + W' dr,   0 = r_0 + dr - P(r_0 + dr - u^)
 *
 * in which an error of W' = J'^T J', rounded, is one of dr. By how much r_0 lies outside the cone
 * is a difference of large numbers, and alone needs double-double arithmetic (cone.h). */
#include <math.h>
#include <string.h>

#include "double_double.h"
#include "solver_contract.h"

/* Corrections are solved with rounded data to this part of tol: to rounding, if that is 1e-12,
 * since the last step of Newton's method reaches it. */
static const double AIM = 1e-3;

void nsdae_fc_refinement_layout(nsdae_fc_refinement *p, const nsdae_fc_scaled *fc,
                                nsdae_arena *arena)
{
  nsdae_arena_doubles(
      arena, 3L * fc->n,
      (double **[]){&p->high, &p->low, &p->best, &p->best_low, &p->q, &p->correction, NULL});
}

/* The residual of high + low, of the data as given. The island is at r = 0 then, its q the
 * velocities of high + low. */
static double relocate(nsdae_fc_island *s)
{
  nsdae_fc_refinement *p = &s->refinement;
  nsdae_fc_scaled *c = &s->fc;
  const nsdae_fc_global *w = c->global;
  nsdae_fc_scatter(c, p->high, w->r);
  nsdae_fc_scatter(c, p->low, w->r_low);
  nsdae_fc_island_velocities(w, c->label, w->r, w->r_low, w->u);
  nsdae_fc_gather(c, w->u, c->items.q);
  memset(c->r, 0, nsdae_fc_bytes(s));
  nsdae_fc_velocities(c, c->r, c->y, c->u);
  return nsdae_fc_residual(c, c->r, c->u);
}

/* Corrections as long as each halves the residual, and once a solver does not, by the next one; the
 * best point into best. Returns its residual. */
static double correct_all(nsdae_fc_island *s, nsdae_fc_iterate *it, const nsdae_fc_budget *b)
{
  static nsdae_fc_solve *const by[] = {nsdae_fc_semismooth_newton, nsdae_fc_aclm};
  nsdae_fc_refinement *p = &s->refinement;
  double best = INFINITY, before = INFINITY;
  for (int k = 0; k < 2;) {
    double residual = relocate(s);
    if (residual < best) {
      best = residual;
      memcpy(p->best, p->high, nsdae_fc_bytes(s));
      memcpy(p->best_low, p->low, nsdae_fc_bytes(s));
    } else {
      memcpy(p->high, p->best, nsdae_fc_bytes(s));
      memcpy(p->low, p->best_low, nsdae_fc_bytes(s));
      relocate(s);
    }
    if (best <= b->tol || !nsdae_fc_spend(s, it, b, 0)) break;
    if (!(best <= 0.5 * before) && ++k == 2) break;
    before = best;
    /* The problem for what the point lacks, from zero on, by this solver. */
    nsdae_fc_budget closer = *b;
    nsdae_fc_iterate inner = {.r = p->correction, .residual = best, .work = it->work};
    memset(p->correction, 0, nsdae_fc_bytes(s));
    closer.tol = AIM * b->tol;
    (void)by[k](s, &inner, &closer);
    memcpy(s->fc.r, p->correction, nsdae_fc_bytes(s));
    it->work = inner.work;
    for (int i = 0; i < 3 * s->fc.n; i++) { /* high + low += the correction */
      nsdae_dd_add(1, s->fc.r[i], p->high + i, p->low + i);
      double sum = p->high[i] + p->low[i];
      p->low[i] -= sum - p->high[i];
      p->high[i] = sum;
    }
  }
  return best;
}

/* The best point is the iterate if it, or its leading part alone, has a smaller residual. */
static void hand_over(nsdae_fc_island *s, nsdae_fc_iterate *it, const nsdae_fc_budget *b,
                      double residual, double given)
{
  nsdae_fc_refinement *p = &s->refinement;
  it->residual = given;
  memcpy(p->high, p->best, nsdae_fc_bytes(s));
  memset(p->low, 0, nsdae_fc_bytes(s));
  double leading = relocate(s);
  const int both = b->double_double && leading > b->tol && residual < given;
  if (!both && !(leading < given)) return;
  it->residual = both ? residual : leading;
  memcpy(it->r, p->best, nsdae_fc_bytes(s));
  if (both)
    memcpy(it->low, p->best_low, nsdae_fc_bytes(s));
  else
    memset(it->low, 0, nsdae_fc_bytes(s));
}

int nsdae_fc_refine(nsdae_fc_island *s, nsdae_fc_iterate *it, const nsdae_fc_budget *b)
{
  nsdae_fc_refinement *p = &s->refinement;
  if (!nsdae_fc_system_ready(s)) return NSDAE_FC_NO_MEMORY;
  memcpy(p->q, s->fc.items.q, nsdae_fc_bytes(s));
  memcpy(p->high, it->r, nsdae_fc_bytes(s));
  memcpy(p->low, it->low, nsdae_fc_bytes(s));
  s->fc.base = (nsdae_fc_base){p->high, p->low};
  double given = relocate(s), residual = correct_all(s, it, b);
  hand_over(s, it, b, residual, given);
  s->fc.base = (nsdae_fc_base){NULL, NULL};
  memcpy(s->fc.items.q, p->q, nsdae_fc_bytes(s));
  return it->residual <= b->tol;
}
