/* Impacts that a step merges.
 *
 * A light body between two heavy ones that approach each other hits one, then the other, and again.
 * In x = M^(1/2) v an elastic impact at contact i is a reflection at the plane of normal M^(-1/2)
 * W_i. The planes of two contacts include the angle theta, cos theta = -G_ij / sqrt(G_ii G_jj), and
 * the reflections end after pi / theta of them (Galperin's billiard), sqrt(M / m) for the light
 * body. A step finds both contacts closed if the time of flight between them is below dt. It then
 * solves one problem, with one impulse for each.
 *
 * Counted are pairs of which one is hit and the other parts or is hit too, both faster than forces
 * make them in the two steps that an impact may be late. A contact that touched already (v_N(-) =
 * 0: stacks, cradles) is hit at the same instant at every dt, and Newton's law is made for that.
 * Each impact has e = (e_i e_j)^(1/2) of the one before, so that n impacts have the impulse of
 * (1 - e^n) / (1 - e) first ones. Reported is one order of magnitude: an impulse of ten. In heaps
 * of e <= 0.9 it never is. */
#include <math.h>
#include <string.h>

#include "errors.h"
#include "sim_impl.h"

static const double MANY = 10;
static const double PI = 3.14159265358979324;

typedef struct merged {
  double impacts;
  int contact, other; /* numbers of closed contacts */
} merged;

/* The closed contacts of a step. */
typedef struct closed_ones {
  const nsdae_problem *problem;
  const nsdae_contacts *dense;   /* the problem of all of them; NULL: none */
  const nsdae_coefficients *law; /* by number */
  const nsdae_rows *normal;      /* the same, where they were found closed */
  const nsdae_blocks *blocks;
  const double *M, *F;
} closed_ones;

/* sum |W_j F_j| / M_jj over block b: F gives W no larger acceleration, or one of that size. */
static double pushed(const closed_ones *c, int b, const double *W, size_t stride)
{
  double sum = 0;
  int first = c->blocks->first[b], n = nsdae_blocks_size(c->blocks, b);
  const double *M = c->M + c->blocks->square[b];
  for (int j = 0; j < n; j++)
    sum += fabs(W[(size_t)j * stride] * c->F[first + j]) / M[(size_t)j * (size_t)(n + 1)];
  return sum;
}

static double acceleration(const closed_ones *c, int i)
{
  double sum = 0;
  for (int p = c->normal->first[i]; p < c->normal->first[i + 1]; p++)
    sum += pushed(c, c->normal->block[p], c->normal->value + c->normal->at[p], c->normal->stride);
  return sum;
}

/* W_p^T M_b^-1 W_q of parts p, q on the same block. */
static double part(const closed_ones *c, int p, int q)
{
  const nsdae_rows *rows = c->normal;
  double L[NSDAE_CONTACT_WIDTH * NSDAE_CONTACT_WIDTH], u[NSDAE_CONTACT_WIDTH], sum = 0;
  int n = nsdae_blocks_size(c->blocks, rows->block[p]);
  nsdae_block_factor factor = {.L = L};
  if (n > NSDAE_CONTACT_WIDTH) return 0;
  if (nsdae_blocks_factor(c->blocks, rows->block[p], c->M, &factor)) return 0;
  for (int j = 0; j < n; j++) u[j] = rows->value[rows->at[q] + (size_t)j * rows->stride];
  nsdae_blocks_solve(&factor, u);
  for (int j = 0; j < n; j++) sum += rows->value[rows->at[p] + (size_t)j * rows->stride] * u[j];
  return sum;
}

/* G of the closed contacts at places a and b; where they were not one problem, without the
 * constraints. */
static double delassus(const closed_ones *c, int a, int b)
{
  const nsdae_contacts *k = c->dense;
  const nsdae_rows *N = c->normal;
  if (k)
    return k->delassus
        .G[(size_t)k->first_column[a] * (size_t)k->columns + (size_t)k->first_column[b]];
  int i = c->problem->number[a], j = c->problem->number[b];
  double sum = 0;
  for (int p = N->first[i]; p < N->first[i + 1]; p++)
    for (int q = N->first[j]; q < N->first[j + 1]; q++)
      if (N->block[p] == N->block[q]) sum += part(c, p, q);
  return sum;
}

/* Number of impacts that contacts at a and b would have one after another; 0: few. */
static double follow(const closed_ones *c, int a, int b)
{
  double ij = delassus(c, a, b), ii = delassus(c, a, a), jj = delassus(c, b, b);
  if (!(ij < 0 && ii > 0 && jj > 0)) return 0;
  double n = PI / acos(fmin(-ij / sqrt(ii * jj), 1));
  double e = sqrt(c->law[c->problem->number[a]].e_n * c->law[c->problem->number[b]].e_n);
  double impulse = e < 1 ? (1 - pow(e, n)) / (1 - e) : n;
  return impulse >= MANY ? n : 0;
}

/* Whether contact i had an impulse, restitution, and a velocity that no force explains. */
static int acts(const closed_ones *c, const nsdae_impulses *r, int i, double length)
{
  return r->normal[i] > 0 && c->law[i].e_n > 0 &&
         fabs(r->before[i]) > 2 * length * acceleration(c, i);
}

/* Whether contacts i and j touch the same block. */
static int share_block(const nsdae_rows *N, int i, int j)
{
  for (int p = N->first[i]; p < N->first[i + 1]; p++)
    for (int q = N->first[j]; q < N->first[j + 1]; q++)
      if (N->block[p] == N->block[q]) return 1;
  return 0;
}

static void compare_pairs(const closed_ones *c, const nsdae_result *r, int i, double length,
                          merged *most)
{
  int a = 0;
  while (c->problem->number[a] != i) a++;
  for (int b = 0; b < c->problem->count; b++) {
    int other = c->problem->number[b];
    if (b == a || !share_block(c->normal, i, other) || !acts(c, &r->impulses, other, length))
      continue;
    double impacts = follow(c, a, b);
    if (impacts > most->impacts) *most = (merged){impacts, i, other};
  }
}

static int report(nsdae_point *point, const merged *m)
{
  const nsdae_terms *end = &point->result.end;
  const nsdae_system *s = end->system;
  char one[NSDAE_CALLED_SIZE], other[NSDAE_CALLED_SIZE];
  const long *id = point->result.closed.id;
  point->accounts.stats.warnings |= NSDAE_MONITORS_IMPACTS;
  nsdae_error_set(end->error, NSDAE_WARN_IMPACTS, "nsdae_sim", "dt",
                  "impacts are merged in the step to t = %.6g: %s and %s have up to %.3g "
                  "consecutive impacts: make dt smaller, or use method = event",
                  nsdae_terms_time(end), nsdae_system_called_contact(s, id, m->contact, one),
                  nsdae_system_called_contact(s, id, m->other, other), m->impacts);
  return nsdae_error_at(end->error, NSDAE_WARN_IMPACTS,
                        nsdae_system_index(s, NSDAE_NAME_CONTACT, m->contact),
                        nsdae_terms_time(end));
}

int nsdae_merged_report(const nsdae_sim *sim, const nsdae_point *before, nsdae_point *point)
{
  const nsdae_result *r = &point->result;
  const nsdae_problem *problem = &sim->stepper.problem;
  const nsdae_terms *T = &before->result.end;
  merged most = {0, -1, -1};
  if (r->located || r->counters.fallbacks > 0 || r->impacts == 0) return NSDAE_OK;
  const closed_ones c = {problem,
                         r->problem && r->problem->active_count == problem->count ? r->problem
                                                                                  : NULL,
                         problem->law,
                         &problem->home->by.normal,
                         &sim->model.blocks,
                         T->M,
                         T->F};
  for (int p = 0; p < r->impacts; p++)
    if (acts(&c, &r->impulses, r->impact[p].contact, point->record.duration))
      compare_pairs(&c, r, r->impact[p].contact, point->record.duration, &most);
  return most.impacts > 0 ? report(point, &most) : NSDAE_OK;
}
