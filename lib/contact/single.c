#include "single.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "listed.h"

enum { WIDTH = NSDAE_CONTACT_WIDTH };

/* ---- G and b of one contact */

int nsdae_single_fits(const nsdae_island_equations *w, int island)
{
  const nsdae_contact_islands *is = w->islands;
  if (nsdae_members_count(&is->contact, island) != 1) return 0;
  if (nsdae_members_count(&is->row, island) + nsdae_members_count(&is->joint, island) > 0) return 0;
  if (nsdae_members_count(&is->block, island) > 2) return 0;
  int a = is->contact.of[is->contact.first[island]];
  if (w->system->dims.nt == 2 && w->law[a].mu > 0) return 0;
  for (int i = is->block.first[island]; i < is->block.first[island + 1]; i++)
    if (nsdae_blocks_size(&w->system->blocks, is->block.of[i]) > WIDTH) return 0;
  return 1;
}

/* The factor of M_b and the velocity without impulse; 0 where M_b is not positive definite. */
static int gather_side(const nsdae_island_equations *w, nsdae_single_side *s, int b)
{
  const nsdae_blocks *blocks = &w->system->blocks;
  s->b = b;
  s->n = nsdae_blocks_size(blocks, b);
  s->at = blocks->first[b];
  for (int j = 0; j < s->n; j++) s->v[j] = w->r[s->at + j];
  s->factor.L = s->L;
  if (nsdae_blocks_factor(blocks, b, w->M, &s->factor)) return 0;
  nsdae_blocks_solve(&s->factor, s->v);
  return 1;
}

/* Direction d of contact a on its blocks: U, and its part of G and b. */
static void gather_direction(nsdae_single *c, const nsdae_rows *rows, int row, int d)
{
  for (int p = rows->first[row]; p < rows->first[row + 1]; p++) {
    nsdae_single_side *s = &c->side[rows->block[p] == c->side[0].b ? 0 : 1];
    const double *W = rows->value + rows->at[p];
    for (int j = 0; j < s->n; j++) {
      s->U[d][j] = W[j];
      c->b[d] += W[j] * s->v[j];
    }
    nsdae_blocks_solve(&s->factor, s->U[d]);
    for (int e = 0; e <= d; e++) {
      double sum = 0;
      for (int j = 0; j < s->n; j++) sum += W[j] * s->U[e][j];
      c->G[d][e] += sum;
    }
  }
}

/* G = W^T M^-1 W and b of contact a, of one or two directions; 0 if M is not positive definite. */
static int gather(const nsdae_island_equations *w, nsdae_single *c, int island, int a)
{
  const nsdae_contact_islands *is = w->islands;
  const nsdae_terms *T = w->terms;
  const nsdae_coefficients *law = &w->law[a];
  c->contact = a;
  c->mu = law->mu;
  c->sides = 0;
  memset(c->G, 0, sizeof c->G);
  memset(c->b, 0, sizeof c->b);
  c->columns = law->mu > 0 ? 2 : 1;
  for (int i = is->block.first[island]; i < is->block.first[island + 1]; i++)
    if (!gather_side(w, &c->side[c->sides++], is->block.of[i])) return 0;
  gather_direction(c, &T->by.normal, a, 0);
  c->b[0] += T->w_N[a] + law->e_n * w->results->before[a];
  if (c->columns == 1) return 1;
  gather_direction(c, &T->by.tangent, a, 1);
  c->b[1] += T->w_T[a] + law->e_t * w->results->before_t[a];
  c->G[0][1] = c->G[1][0];
  return 1;
}

/* ---- solution by cases */

static int stick(nsdae_single *c)
{
  double det = c->G[0][0] * c->G[1][1] - c->G[0][1] * c->G[1][0];
  if (!(det > 16 * DBL_EPSILON * c->G[0][0] * c->G[1][1])) return 0;
  c->x[0] = (c->G[0][1] * c->b[1] - c->G[1][1] * c->b[0]) / det;
  c->x[1] = (c->G[1][0] * c->b[0] - c->G[0][0] * c->b[1]) / det;
  return c->x[0] > 0 && fabs(c->x[1]) <= c->mu * c->x[0];
}

static int frictional_joint(nsdae_single *c, double s)
{
  double normal = c->G[0][0] - s * c->mu * c->G[0][1];
  if (!(normal > 16 * DBL_EPSILON * c->G[0][0])) return 0;
  c->x[0] = -c->b[0] / normal;
  c->x[1] = -s * c->mu * c->x[0];
  return s * (c->b[1] + c->G[1][0] * c->x[0] + c->G[1][1] * c->x[1]) >= 0;
}

/* enum nsdae_mode; -1: in none. */
static int solve(nsdae_single *c)
{
  c->x[0] = c->x[1] = 0;
  if (c->b[0] >= 0) return NSDAE_MODE_OPEN;
  if (!(c->G[0][0] > 0)) return -1;
  if (c->columns == 1) {
    c->x[0] = -c->b[0] / c->G[0][0];
    return NSDAE_MODE_SLIP;
  }
  if (stick(c)) return NSDAE_MODE_STICK;
  return frictional_joint(c, 1) || frictional_joint(c, -1) ? NSDAE_MODE_SLIP : -1;
}

/* ---- velocities */

/* v(+) of a side. What cancels to rounding is zero, as in contacts.c. */
static void scatter_side(const nsdae_island_equations *w, const nsdae_single *c,
                         const nsdae_single_side *s)
{
  const double rounding = 32 * DBL_EPSILON;
  double size_x = fmax(fabs(c->x[0]), fabs(c->x[1]));
  for (int j = 0; j < s->n; j++) {
    double v = s->v[j], size = 2 * fabs(v);
    for (int d = 0; d < c->columns; d++) {
      v += s->U[d][j] * c->x[d];
      size += fabs(s->U[d][j]) * size_x;
    }
    w->v[s->at + j] = fabs(v) <= rounding * size ? 0 : v;
    w->size[s->at + j] = size;
  }
}

/* The residual at the velocities xi that v has now. */
static nsdae_natural_residual left_over(const nsdae_single *c, const double xi[2])
{
  nsdae_natural_residual residual = {0};
  double d = c->columns == 2 ? (c->G[0][0] + c->G[1][1]) / 2 : c->G[0][0];
  const double x[2] = {d * c->x[0], d * c->x[1]};
  for (int i = 0; i < c->columns; i++) nsdae_natural_residual_speed(&residual, c->b[i]);
  nsdae_natural_residual_row(&residual, c->columns == 2 ? nsdae_natural_planar(c->mu, x, xi)
                                                        : nsdae_natural_normal(x[0], xi[0]));
  return residual;
}

int nsdae_single_solve(nsdae_single *c, const nsdae_island_equations *w, int island,
                       nsdae_natural_residual *residual)
{
  const double most = 1e-13;
  int a = w->islands->contact.of[w->islands->contact.first[island]], nt = w->system->dims.nt;
  nsdae_impulses *to = w->results;
  int mode = gather(w, c, island, a) ? solve(c) : -1;
  if (mode < 0 || !isfinite(c->x[0]) || !isfinite(c->x[1])) return 0;
  for (int i = 0; i < c->sides; i++) scatter_side(w, c, &c->side[i]);
  to->normal[a] = c->x[0];
  to->mode[a] = mode;
  nsdae_terms_contact_rates(w->terms, a, w->v, to->after, to->after_t);
  for (int j = a * nt; j < (a + 1) * nt; j++)
    to->tangential[j] = j == a * nt && c->columns == 2 ? c->x[1] : 0;
  double xi[2] = {to->after[a] + w->law[a].e_n * to->before[a]};
  if (c->columns == 2) xi[1] = to->after_t[a * nt] + w->law[a].e_t * to->before_t[a * nt];
  *residual = left_over(c, xi);
  return nsdae_natural_residual_scaled(residual) <= most;
}
