/* Velocities of an island from its impulses, v = M^-1 (f + H r), and which of them are none. */
#include "cone_island.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* v += H r, and the sizes of its terms. */
void nsdae_cone_add_impulses(nsdae_cone_island *c, const nsdae_island_equations *w)
{
  const nsdae_blocks *blocks = &w->system->blocks;
  size_t at = 0;
  for (int i = 0, row = 0; i < c->items; i++) {
    int columns = i < c->problem.contacts ? c->at.rows[i] : 1;
    for (int e = c->at.first[i]; e < c->at.first[i + 1]; e++) {
      int b = c->at.member[c->at.block[e]], n = nsdae_blocks_size(blocks, b);
      double *v = w->v + blocks->first[b], *size = w->size + blocks->first[b];
      for (int d = 0; d < columns; d++, at += (size_t)n)
        for (int j = 0; j < n; j++) {
          double term = c->at.value[at + (size_t)j] * c->at.r[row + d];
          v[j] += term;
          size[j] += fabs(term);
        }
    }
    row += columns;
  }
}

/* |M^-1| times sizes, by the diagonal. */
static void sizes_of_velocity(const double *M, int n, double *size)
{
  for (int j = 0; j < n; j++) size[j] /= M[(size_t)j * (size_t)(n + 1)];
}

/* v := M^-1 v over the blocks of the problem. */
int nsdae_cone_solve_masses(const nsdae_cone_island *c, const nsdae_island_equations *w, double *L)
{
  nsdae_block_factor factor = {.L = L};
  for (int i = 0; i < c->problem.blocks; i++) {
    int b = c->at.member[i];
    if (nsdae_blocks_factor(&w->system->blocks, b, w->M, &factor) != 0) return NSDAE_E_MASS;
    nsdae_blocks_solve(&factor, w->v + w->system->blocks.first[b]);
  }
  return NSDAE_OK;
}

/* v := f, and the sizes of its terms. */
void nsdae_cone_begin_velocities(const nsdae_cone_island *c, const nsdae_island_equations *w)
{
  const double *f = c->at.f;
  for (int i = 0; i < c->problem.blocks; f += c->at.size[i++]) {
    int at = w->system->blocks.first[c->at.member[i]];
    for (int j = 0; j < c->at.size[i]; j++) {
      w->v[at + j] = f[j];
      w->size[at + j] = fabs(f[j]);
    }
  }
}

/* The largest entry of H along each velocity. */
static void levers(nsdae_cone_island *c, const nsdae_island_equations *w)
{
  const nsdae_blocks *blocks = &w->system->blocks;
  const double *value = c->at.value;
  for (int i = 0; i < c->problem.blocks; i++)
    memset(c->lever + blocks->first[c->at.member[i]], 0, (size_t)c->at.size[i] * sizeof *c->lever);
  for (int i = 0; i < c->items; i++) {
    int columns = i < c->problem.contacts ? c->at.rows[i] : 1;
    for (int e = c->at.first[i]; e < c->at.first[i + 1]; e++) {
      int b = c->at.block[e], n = c->at.size[b];
      double *lever = c->lever + blocks->first[c->at.member[b]];
      for (int d = 0; d < columns; d++, value += n)
        for (int j = 0; j < n; j++)
          lever[j] = fabs(value[j]) > lever[j] ? fabs(value[j]) : lever[j];
    }
  }
}

/* Whether entry j of v is none: it cancels to the rounding of its terms; or it moves no item of its
 * body by more than the digits of the solution times speed, and is no free motion, that moves none:
 * a spin about a contact's normal, a slide without friction, of which rounding may leave a lever.
 * Its own lever is its largest entry in a direction of an item, most that of all entries of its
 * body.
 */
static int stands(const nsdae_cone_island *c, const nsdae_island_equations *w, int j, double most,
                  double tol, double speed)
{
  double v = fabs(w->v[j]), digits = fmin(tol, NSDAE_STILL);
  if (v <= 32 * DBL_EPSILON * w->size[j]) return 1;
  return !c->driven && v * c->lever[j] <= digits * speed &&
         ((c->lever[j] > 0 && v * most <= digits * speed) || v <= digits * w->size[j]);
}

static void settle(const nsdae_cone_island *c, const nsdae_island_equations *w, int at, int n,
                   double tol, double speed)
{
  double most = 0;
  for (int j = at; j < at + n; j++) most = fmax(most, c->lever[j]);
  for (int j = at; j < at + n; j++)
    if (stands(c, w, j, most, tol, speed)) w->v[j] = 0;
}

/* v = M^-1 (f + H r), with the sizes of its terms and the levers. */
int nsdae_cone_form_velocities(nsdae_cone_island *c, const nsdae_island_equations *w, double *L)
{
  levers(c, w);
  nsdae_cone_begin_velocities(c, w);
  nsdae_cone_add_impulses(c, w);
  return nsdae_cone_solve_masses(c, w, L);
}

/* The same, and the items at rest; speed: of the fastest item without impulses, for which all are
 * scaled. */
int nsdae_cone_velocities(nsdae_cone_island *c, const nsdae_island_equations *w,
                          const nsdae_cone_work *work, double speed)
{
  const nsdae_blocks *blocks = &w->system->blocks;
  const double *M = c->at.M;
  c->slow = work->tol * speed;
  int status = nsdae_cone_form_velocities(c, w, work->L);
  for (int i = 0; i < c->problem.blocks && status == NSDAE_OK; i++) {
    int at = blocks->first[c->at.member[i]], n = c->at.size[i];
    sizes_of_velocity(M, n, w->size + at);
    settle(c, w, at, n, work->tol, speed);
    M += (size_t)n * (size_t)n;
  }
  return status;
}
