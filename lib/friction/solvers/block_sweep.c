/* One sweep of nonlinear block Gauss-Seidel: each contact in turn is solved exactly (one_contact.c)
 * with the velocities u = J y + q of the impulses found so far. */
#include <math.h>
#include <string.h>

#include "cone.h"
#include "one_contact.h"
#include "simd.h"
#include "solver_contract.h"
#include "vector.h"

/* Its square is a normal number. */
static const double TINY = 1e-150;

enum { BODY = 6, PART = 3 * BODY }; /* size of most blocks, values of their parts */

/* ---- products with parts of J */

/* u += J^T y of one part, [n x 3] column-major. */
static inline void gather_part(int n, const double *J, const double *y, double *u)
{
  double a = 0, b = 0, d = 0;
  for (int l = 0; l < n; l++) {
    a += J[l] * y[l];
    b += J[n + l] * y[l];
    d += J[2 * n + l] * y[l];
  }
  u[0] += a, u[1] += b, u[2] += d;
}

/* y += J dr of one part */
static inline void apply_part(int n, const double *restrict J, const double *restrict dr,
                              double *restrict y)
{
  for (int l = 0; l < n; l++) y[l] += J[l] * dr[0] + J[n + l] * dr[1] + J[2 * n + l] * dr[2];
}

#define FOUR(x) (*(const nsdae_four *)(x))

/* The same of all parts of item k if they are bodies: six velocities are four lanes and two. */
NSDAE_INLINED void gather_bodies(const nsdae_fc_scaled *c, int k, double *u)
{
  nsdae_four s[3] = {{0}};
  nsdae_pair t[3] = {{0}};
  const double *J = c->parts.J + PART * (size_t)c->parts.first[k];
  for (int e = c->parts.first[k]; e < c->parts.first[k + 1]; e++, J += PART) {
    const double *y = c->y + BODY * (size_t)c->parts.block[e];
    for (int j = 0; j < 3; j++) {
      s[j] += FOUR(J + BODY * j) * FOUR(y);
      t[j] += nsdae_pair_of(J + BODY * j + 4) * nsdae_pair_of(y + 4);
    }
  }
  for (int j = 0; j < 3; j++) {
    t[j] += (nsdae_pair){s[j][0], s[j][1]} + (nsdae_pair){s[j][2], s[j][3]};
    u[j] += t[j][0] + t[j][1];
  }
}

NSDAE_INLINED void add_bodies(nsdae_fc_scaled *c, int k, const double *dr)
{
  const double *J = c->parts.J + PART * (size_t)c->parts.first[k];
  for (int e = c->parts.first[k]; e < c->parts.first[k + 1]; e++, J += PART) {
    double *y = c->y + BODY * (size_t)c->parts.block[e];
    *(nsdae_four *)y += FOUR(J) * dr[0] + FOUR(J + BODY) * dr[1] + FOUR(J + 2 * BODY) * dr[2];
    *(nsdae_pair *)(y + 4) += nsdae_pair_of(J + 4) * dr[0] + nsdae_pair_of(J + BODY + 4) * dr[1] +
                              nsdae_pair_of(J + 2 * BODY + 4) * dr[2];
  }
}

/* u = J^T y + q + C r of item k */
NSDAE_INLINED void gather_block(const nsdae_fc_scaled *c, int bodies, int k, double *u)
{
  const double *r = c->r + 3 * k;
  for (int j = 0; j < 3; j++) u[j] = c->items.q[3 * k + j] + c->items.C[3 * k + j] * r[j];
  if (bodies) {
    gather_bodies(c, k, u);
    return;
  }
  for (int e = c->parts.first[k]; e < c->parts.first[k + 1]; e++)
    gather_part(c->parts.size[c->parts.block[e]], nsdae_fc_part(c, e),
                c->y + c->parts.offset[c->parts.block[e]], u);
}

/* y += J dr of item k */
NSDAE_INLINED void add_parts(nsdae_fc_scaled *c, int bodies, int k, const double *dr)
{
  if (bodies) {
    add_bodies(c, k, dr);
    return;
  }
  for (int e = c->parts.first[k]; e < c->parts.first[k + 1]; e++)
    apply_part(c->parts.size[c->parts.block[e]], nsdae_fc_part(c, e), dr,
               c->y + c->parts.offset[c->parts.block[e]]);
}

/* ---- one contact */

/* Whether item k, of which u are the velocities, sticks: it closes without an impulse, and with
 * u_T = 0 and u_N = 0, r - (D + e)^-1 u is inside its cone. The usual case, and cheap. */
NSDAE_INLINED int sticks(const nsdae_fc_scaled *c, int k, const double *u, double *r)
{
  const double *S = c->items.S + 9 * (size_t)k, *D = S + 6, *old = c->r + 3 * k;
  r[0] = old[0] - (S[0] * u[0] + S[1] * u[1] + S[2] * u[2]);
  r[1] = old[1] - (S[1] * u[0] + S[3] * u[1] + S[4] * u[2]);
  r[2] = old[2] - (S[2] * u[0] + S[4] * u[1] + S[5] * u[2]);
  const double most = c->items.mu[k] * r[0]; /* so that no root is needed; whose square is not 0 */
  const double closing = D[0] * old[0] + D[1] * old[1] + D[2] * old[2] - u[0];
  return closing + NSDAE_FC_PROXIMAL * old[0] > 0 && most > TINY &&
         r[1] * r[1] + r[2] * r[2] <= most * most;
}

/* The new r of item k, which does not stick and of which u are the velocities. */
static void solve_item(const nsdae_fc_scaled *c, int k, const double *u, double *slip, double *r)
{
  const double *D = c->items.D + 9 * (size_t)k, *turn = c->items.turn + 2 * k;
  double old[3] = {c->r[3 * k], c->r[3 * k + 1], c->r[3 * k + 2]}, q[3] = {u[0], u[1], u[2]};
  if (c->items.kind[k] != NSDAE_FC_CONE) {
    r[0] = old[0] - u[0] / D[0];
    r[1] = r[2] = 0;
    if (c->items.kind[k] == NSDAE_FC_NORMAL && !(r[0] > 0)) r[0] = 0;
    return;
  }
  if (old[0] == 0 && old[1] == 0 && old[2] == 0 && u[0] >= 0) {
    r[0] = r[1] = r[2] = 0; /* nothing presses and it does not approach */
    return;
  }
  nsdae_fc_turn(turn, 1, q);
  nsdae_fc_turn(turn, 1, old);
  q[0] -= D[0] * old[0] + D[1] * old[1] + D[2] * old[2];
  q[1] -= D[3] * old[0] + D[4] * old[1];
  q[2] -= D[6] * old[0] + D[8] * old[2];
  nsdae_fc_solve_contact(D, q, c->items.mu[k], c->exact, slip + k, r);
  nsdae_fc_turn(turn, -1, r);
}

/* ---- sweeps */

void nsdae_fc_sweep_begin(nsdae_fc_scaled *c)
{
  if (c->local) return;
  memset(c->y, 0, (size_t)c->ny * sizeof *c->y);
  for (int k = 0; k < c->n; k++) add_parts(c, c->parts.bodies, k, c->r + 3 * k);
}

NSDAE_INLINED void sweep_items(nsdae_fc_scaled *c, int bodies, double *slip, double *change)
{
  for (int k = 0; k < c->n; k++) {
    double u[3], r[3];
    gather_block(c, bodies, k, u);
    if (c->items.kind[k] == NSDAE_FC_CONE && sticks(c, k, u, r))
      slip[k] = 0;
    else
      solve_item(c, k, u, slip, r);
    for (int j = 0; j < 3; j++) r[j] -= c->r[3 * k + j];
    double most = nsdae_larger(nsdae_larger(fabs(r[0]), fabs(r[1])), fabs(r[2]));
    if (most == 0) continue;
    *change = nsdae_larger(*change, c->items.weight[k] * most);
    for (int j = 0; j < 3; j++) c->r[3 * k + j] += r[j];
    if (!c->local) add_parts(c, bodies, k, r);
  }
}

NSDAE_INLINED void sweep_all_bodies(nsdae_fc_scaled *c, double *slip, double *change)
{
  sweep_items(c, 1, slip, change);
}

NSDAE_DISPATCH("avx2", sweep_bodies, sweep_all_bodies,
               (nsdae_fc_scaled * c, double *slip, double *change), (c, slip, change))

double nsdae_fc_sweep(nsdae_fc_scaled *c, double *slip)
{
  double change = 0;
  if (c->parts.bodies)
    sweep_bodies(c, slip, &change);
  else
    sweep_items(c, 0, slip, &change);
  return change;
}

/* Whether the residual of each item is at most tol, to plain rounding; fc->y is current. Checks
 * item *first first, and stores the one that failed: most checks end with it. */
static int sweep_converged(const nsdae_fc_scaled *c, double tol, int *seen)
{
  for (int i = 0; i < c->n; i++) {
    int k = *seen + i < c->n ? *seen + i : *seen + i - c->n;
    double u[3];
    gather_block(c, c->parts.bodies, k, u);
    if (nsdae_fc_item_residual(c, k, c->r, u) <= tol) continue;
    *seen = k;
    return 0;
  }
  return 1;
}

/* Nonlinear block Gauss-Seidel (Moreau 1999; Jourdan, Alart, Jean, Comput. Methods Appl. Mech. Eng.
 * 155 (1998) 31): each contact is solved exactly in turn, the others fixed,
 *
 *   r_c := the solution of Coulomb's law with u_c = W_cc r_c + (q_c + sum W_cj r_j, j != c).
 *
 * nsdae_fc_nsgs extrapolates after every other sweep (anderson.h) and follows rays (ratio_step.c).
 * nsdae_fc_nsgs_plain does neither: if many contacts slide, extrapolation diverges. */

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
    if (sweep_converged(&s->fc, b->tol, &checked) || done - evaluated >= BETWEEN) {
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
    idle += (double)BETWEEN;
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
  return sweep_converged(&s->fc, b->tol, &seen) && evaluate(s, it) <= b->tol;
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
