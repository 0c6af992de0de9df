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

#include "errors.h"
#include "sim_impl.h"

static const double MANY = 10;
static const double PI = 3.14159265358979324;

typedef struct merged {
  double impacts;
  int contact, other; /* contact list: places among the closed ones */
} merged;

/* The closed contacts of a step: fixed ones of the last contact problem, or those of the contact
 * list. */
typedef struct closed_ones {
  const nsdae_contacts *numbered; /* NULL: a contact list */
  const nsdae_rows *normal;       /* of a contact list */
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

static double acceleration(const closed_ones *c, int a)
{
  const nsdae_contacts *k = c->numbered;
  double sum = 0;
  for (int b = 0; k && b < c->blocks->count; b++)
    sum += pushed(c, b,
                  k->delassus.W + (size_t)k->first_column[a] * (size_t)k->system->dims.nv +
                      c->blocks->first[b],
                  1);
  if (k) return sum;
  for (int p = c->normal->first[a]; p < c->normal->first[a + 1]; p++)
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

/* G_ab; of a contact list without the constraints. */
static double delassus(const closed_ones *c, int a, int b)
{
  const nsdae_contacts *k = c->numbered;
  if (k)
    return k->delassus
        .G[(size_t)k->first_column[a] * (size_t)k->columns + (size_t)k->first_column[b]];
  double sum = 0;
  for (int p = c->normal->first[a]; p < c->normal->first[a + 1]; p++)
    for (int q = c->normal->first[b]; q < c->normal->first[b + 1]; q++)
      if (c->normal->block[p] == c->normal->block[q]) sum += part(c, p, q);
  return sum;
}

static double restitution(const nsdae_sim *sim, const closed_ones *c, int a)
{
  return c->numbered ? sim->model.contact[c->numbered->active[a]].e_n
                     : sim->stepper.problem.law[a].e_n;
}

/* Whether contact a had an impulse, restitution, and a velocity that no force explains. */
static int acts(const nsdae_sim *sim, const closed_ones *c, const nsdae_impulses *r, int a,
                double length)
{
  int i = c->numbered ? c->numbered->active[a] : a;
  return r->normal[i] > 0 && restitution(sim, c, a) > 0 &&
         fabs(r->before[i]) > 2 * length * acceleration(c, a);
}

static int share_block(const nsdae_closed *closed, int a, int b)
{
  const int *x = closed->block + 2 * (size_t)a, *y = closed->block + 2 * (size_t)b;
  return (x[0] >= 0 && (x[0] == y[0] || x[0] == y[1])) ||
         (x[1] >= 0 && (x[1] == y[0] || x[1] == y[1]));
}

static void compare_pair(const nsdae_sim *sim, const closed_ones *c, const nsdae_result *r, int a,
                         double length, merged *most)
{
  int count = c->numbered ? c->numbered->active_count : r->closed.count;
  for (int b = 0; b < count; b++) {
    if (b == a || !(c->numbered || share_block(&r->closed, a, b))) continue;
    if (!acts(sim, c, &r->impulses, b, length)) continue;
    /* number of impacts that contacts a and b would have one after another */
    double ij = delassus(c, a, b), ii = delassus(c, a, a), jj = delassus(c, b, b);
    if (!(ij < 0 && ii > 0 && jj > 0)) continue;
    double impacts = PI / acos(fmin(-ij / sqrt(ii * jj), 1));
    double e = sqrt(restitution(sim, c, a) * restitution(sim, c, b));
    double impulse = e < 1 ? (1 - pow(e, impacts)) / (1 - e) : impacts;
    if (impulse >= MANY && impacts > most->impacts)
      *most = (merged){impacts, c->numbered ? c->numbered->active[a] : a,
                       c->numbered ? c->numbered->active[b] : b};
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
                  nsdae_terms_time(end),
                  s->by_list ? nsdae_system_called_id(s, id[m->contact], one)
                             : nsdae_system_called(s, NSDAE_NAME_CONTACT, m->contact, one),
                  s->by_list ? nsdae_system_called_id(s, id[m->other], other)
                             : nsdae_system_called(s, NSDAE_NAME_CONTACT, m->other, other),
                  m->impacts);
  return nsdae_error_at(end->error, NSDAE_WARN_IMPACTS, m->contact, nsdae_terms_time(end));
}

int nsdae_merged_report(const nsdae_sim *sim, const nsdae_point *before, nsdae_point *point)
{
  const nsdae_result *r = &point->result;
  const nsdae_problem *problem = &sim->stepper.problem;
  int listed = !problem->contacts;
  const nsdae_terms *T = &before->result.end;
  merged most = {0, -1, -1};
  if (r->located || r->counters.fallbacks > 0 || r->impacts == 0) return NSDAE_OK;
  if (!listed && !r->problem) return NSDAE_OK;
  const closed_ones c = {listed ? NULL : r->problem, listed ? &problem->home->by.normal : NULL,
                         &sim->model.blocks, T->M, T->F};
  for (int p = 0; p < r->impacts; p++) {
    /* place among the closed ones of the contact that an impact names */
    int contact = r->impact[p].contact, a = c.numbered ? 0 : contact;
    while (c.numbered && c.numbered->active[a] != contact) a++;
    if (acts(sim, &c, &r->impulses, a, point->record.duration))
      compare_pair(sim, &c, r, a, point->record.duration, &most);
  }
  return most.impacts > 0 ? report(point, &most) : NSDAE_OK;
}
