/* Which of the rows that are closed or stick have an equation of their own. Where a body rests on
 * more points than it has freedoms, the rows w of W_C depend on each other: the motion is
 * determined, how its forces share is not. The rows are taken in turn, contacts by their normal
 * force and what sticks after them; one depends on those taken, w_p = sum c_l w_l, where the pivot
 * of a Cholesky factor of W_C^T P W_C is none. The forces z_p = (1 in p, -c_l in l) then move
 * nothing, and in place of its row p has a relation F_p = sum r_l F_l:
 *
 *   even   r_l = c_l D_l / D_p       z_p^T D F = 0, so that F^T D F is least; D = 1 for normal
 *                                    forces, 1 / (mu F_N) for friction
 *   kept   F_N = s sum F_N of those taken, F_T = r F_N: the parts that the problem of
 *          accelerations gave it
 *
 * Even is tried first, and taken if with F + Z a that fulfils it nothing pulls and no friction
 * leaves its cone. Each of them is a solution. Where the dependence ends, the gap of such a contact
 * leaves zero and ends the phase. */
#include <math.h>
#include <string.h>

#include "dense.h"
#include "errors.h"
#include "event_instant.h"
#include "vector.h"

enum { ROUNDS = 50 };

/* Of the friction there can be: more than that is nearly all. */
static const double NEARLY_ALL = 0.99;

/* The Delassus matrix has squared what rank_tol is meant for. */
static const double LEAST_SINE = 1e-6;

static double *row_of(const nsdae_event_method *e, double *matrix, int column)
{
  return matrix + (size_t)column * (size_t)e->modes.columns;
}

/* A further row of the Cholesky factor of G, unless it depends on those before it. */
static void take_row(nsdae_event_method *e, int column)
{
  nsdae_row_set *s = &e->rows;
  const double *G = row_of(e, e->modes.delassus.G, column);
  double *row = row_of(e, s->factor, column), rest = G[column];
  double sine = fmax(e->stepper->options->rank_tol, LEAST_SINE);
  for (int j = 0; j < s->taken_count; j++) {
    const double *other = row_of(e, s->factor, s->taken[j]);
    row[j] = (G[s->taken[j]] - nsdae_dot(j, row, other)) / other[j];
    rest -= row[j] * row[j];
  }
  s->rank_before[column] = s->taken_count;
  if (!(rest > sine * sine * G[column])) {
    s->dependent[s->dependent_count++] = column;
    return;
  }
  row[s->taken_count] = sqrt(rest);
  s->taken[s->taken_count++] = column;
}

/* c by L^T c = row p of the factor. */
static void find_combination(nsdae_event_method *e, int p)
{
  nsdae_row_set *s = &e->rows;
  double *c = row_of(e, s->combination, p), *row = row_of(e, s->factor, p);
  memset(c, 0, (size_t)e->modes.columns * sizeof *c);
  for (int l = s->rank_before[p] - 1; l >= 0; l--) {
    double sum = row[l];
    for (int i = l + 1; i < s->rank_before[p]; i++)
      sum -= row_of(e, s->factor, s->taken[i])[l] * c[s->taken[i]];
    c[s->taken[l]] = sum / row_of(e, s->factor, s->taken[l])[l];
  }
}

/* r of p, and so the weights of the equation F_p - sum r_l F_l = 0. */
static void even_relation(nsdae_event_method *e, int p)
{
  nsdae_row_set *s = &e->rows;
  double *r = row_of(e, s->relation, p), *c = row_of(e, s->combination, p);
  int normal = s->normal[p] == p;
  for (int l = 0; l < s->columns; l++)
    r[l] = (s->normal[l] == l) == normal ? c[l] * s->weight[l] / s->weight[p] : 0;
}

static void kept_relation(nsdae_event_method *e, int p)
{
  nsdae_row_set *s = &e->rows;
  double *r = row_of(e, s->relation, p), sum = 0;
  memset(r, 0, (size_t)e->modes.columns * sizeof *r);
  if (s->normal[p] != p) {
    r[s->normal[p]] = s->force[p] / s->force[s->normal[p]];
    return;
  }
  for (int l = 0; l < s->taken_count; l++)
    if (s->normal[s->taken[l]] == s->taken[l]) sum += s->force[s->taken[l]];
  for (int l = 0; l < s->taken_count && sum > 0; l++)
    if (s->normal[s->taken[l]] == s->taken[l]) r[s->taken[l]] = s->force[p] / sum;
}

/* The forces along the columns z of the dependent that fulfil their relations:
 * (F + Z a)_p - sum r_l (F + Z a)_l = 0. */
static int fulfil_relations(nsdae_event_method *e)
{
  nsdae_row_set *s = &e->rows;
  int count = s->dependent_count, n = e->modes.columns;
  for (int i = 0; i < count; i++) {
    int p = s->dependent[i];
    const double *r = row_of(e, s->relation, p);
    s->shift[i] = nsdae_dot(n, r, s->force) - s->force[p];
    for (int j = 0; j < count; j++) {
      int q = s->dependent[j];
      double entry = nsdae_dot(n, r, row_of(e, s->combination, q)) - r[q] + (p == q);
      s->system[(size_t)j * (size_t)count + (size_t)i] = entry;
    }
  }
  if (nsdae_la_lu(count, s->system, count, s->pivot) != 0) return 0;
  nsdae_la_lu_solve(count, s->system, count, s->pivot, s->shift);
  for (int i = 0; i < count; i++) {
    const double *c = row_of(e, s->combination, s->dependent[i]);
    s->force[s->dependent[i]] += s->shift[i];
    for (int l = 0; l < n; l++) s->force[l] -= s->shift[i] * c[l];
  }
  return 1;
}

/* Whether no contact pulls and, of what sticks, none leaves its cone, but for the error of a solved
 * complementarity problem. */
static int pushes(const nsdae_event_method *e, double size)
{
  const nsdae_contacts *c = &e->modes;
  int all = 1;
  for (int a = 0; a < c->active_count; a++) all &= e->rows.force[c->first_column[a]] >= -size;
  return all;
}

static double friction_of(const nsdae_event_method *e, int a)
{
  const nsdae_contacts *c = &e->modes;
  double friction = 0;
  for (int l = c->first_column[a] + 1; l < c->first_column[a + 1]; l++)
    friction = hypot(friction, e->rows.force[l]);
  return friction;
}

static double most_friction(const nsdae_event_method *e, int a)
{
  const nsdae_contacts *c = &e->modes;
  return e->stepper->system->contact[c->active[a]].mu * e->rows.force[c->first_column[a]];
}

static int holds(const nsdae_event_method *e, double size)
{
  const nsdae_contacts *c = &e->modes;
  int all = 1;
  for (int a = 0; a < c->active_count; a++)
    all &= e->mode[c->active[a]] != NSDAE_MODE_STICK ||
           friction_of(e, a) <= most_friction(e, a) + size;
  return all;
}

/* Of what sticks, the part of the friction there can be. */
static double used_friction(const nsdae_event_method *e, int a)
{
  double most = most_friction(e, a);
  return e->mode[e->modes.active[a]] == NSDAE_MODE_STICK && most > 0 ? friction_of(e, a) / most : 0;
}

static double rounding_size(const nsdae_event_method *e)
{
  double most = 0;
  for (int l = 0; l < e->modes.columns; l++) most = fmax(most, fabs(e->rows.force[l]));
  return e->stepper->options->lcp_tol * most;
}

static void gather_forces(nsdae_event_method *e)
{
  const nsdae_contacts *c = &e->modes;
  nsdae_row_set *s = &e->rows;
  const nsdae_dims *d = &e->stepper->system->dims;
  s->columns = c->columns - c->slide_count;
  memcpy(s->force, c->delassus.impulse, (size_t)c->columns * sizeof *s->force);
  for (int a = 0; a < c->active_count; a++) {
    int column = c->first_column[a], i = c->active[a];
    double most = e->stepper->system->contact[i].mu * c->results->normal[i];
    for (int l = column; l < c->first_column[a + 1]; l++) {
      s->normal[l] = column;
      s->weight[l] = l > column && most > 0 ? s->emphasis[a] / most : 1;
      s->unknown[l] = l == column ? nsdae_at_normal(d) + i
                                  : nsdae_at_tangential(d) + i * d->nt + l - column - 1;
    }
  }
}

static void scatter_forces(nsdae_event_method *e)
{
  nsdae_contacts *c = &e->modes;
  int nt = e->stepper->system->dims.nt;
  memcpy(c->delassus.impulse, e->rows.force, (size_t)c->columns * sizeof *c->delassus.impulse);
  for (int a = 0; a < c->active_count; a++) {
    int column = c->first_column[a], i = c->active[a];
    c->results->normal[i] = c->delassus.impulse[column];
    for (int l = column + 1; l < c->first_column[a + 1]; l++)
      c->results->tangential[i * nt + l - column - 1] = c->delassus.impulse[l];
  }
}

/* The closed contact with the largest normal force of those not seen; -1 past the last. */
static int next_normal(const nsdae_event_method *e)
{
  const nsdae_contacts *c = &e->modes;
  int next = -1;
  for (int a = 0; a < c->active_count; a++) {
    int column = c->first_column[a];
    if (e->mode[c->active[a]] == NSDAE_MODE_OPEN || e->rows.seen[column]) continue;
    if (next < 0 || e->rows.force[column] > e->rows.force[next]) next = column;
  }
  return next;
}

static void take_normals(nsdae_event_method *e)
{
  nsdae_row_set *s = &e->rows;
  s->taken_count = s->dependent_count = 0;
  memset(s->seen, 0, (size_t)e->modes.columns * sizeof *s->seen);
  for (int column = next_normal(e); column >= 0; column = next_normal(e)) {
    s->seen[column] = 1;
    take_row(e, column);
  }
}

static void take_sticking(nsdae_event_method *e)
{
  const nsdae_contacts *c = &e->modes;
  for (int a = 0; a < c->active_count; a++)
    for (int l = c->first_column[a] + 1; l < c->first_column[a + 1]; l++)
      if (e->mode[c->active[a]] == NSDAE_MODE_STICK) take_row(e, l);
}

/* Friction of what slides is in the columns of normal forces: then their z are others. */
static int any_sliding(const nsdae_event_method *e)
{
  int any = 0;
  for (int i = 0; i < e->stepper->system->dims.k; i++)
    any |= e->mode[i] != NSDAE_MODE_OPEN && e->moving[i];
  return any;
}

/* Relations and forces of all that depend: normal forces even or kept, friction even or kept. */
static int relate(nsdae_event_method *e, int even_normal, int even_friction)
{
  nsdae_row_set *s = &e->rows;
  gather_forces(e);
  for (int i = 0; i < s->dependent_count; i++) {
    int p = s->dependent[i], even = s->normal[p] == p ? even_normal : even_friction;
    if (even)
      even_relation(e, p);
    else
      kept_relation(e, p);
  }
  return fulfil_relations(e) && pushes(e, rounding_size(e));
}

/* Where friction is nearly used up somewhere, weights that ask for the least |F_T| / (mu F_N) of
 * the largest: each times that of its contact (Lawson 1961). So that no contact is at its limit
 * before all must be. */
static int relate_friction(nsdae_event_method *e, int even_normal)
{
  const nsdae_contacts *c = &e->modes;
  int related = 0;
  double worst = 1;
  for (int round = 0; round < ROUNDS && worst > NEARLY_ALL; round++) {
    related = relate(e, even_normal, 1);
    worst = 0;
    for (int a = 0; a < c->active_count && related; a++) {
      double used = used_friction(e, a);
      e->rows.emphasis[a] *= fmax(used, 1e-3);
      worst = fmax(worst, used);
    }
  }
  return related;
}

static void find_combinations(nsdae_event_method *e)
{
  for (int i = 0; i < e->rows.dependent_count; i++) find_combination(e, e->rows.dependent[i]);
}

static void restore_solution(nsdae_event_method *e)
{
  const nsdae_row_set *s = &e->rows;
  memcpy(e->mode, s->solved_mode, (size_t)e->stepper->system->dims.k * sizeof *e->mode);
  memcpy(s->force, s->solved, (size_t)e->modes.columns * sizeof *s->force);
  scatter_forces(e);
}

/* From the modes and forces of the problem's solution. */
static int try_forces(nsdae_event_method *e, int even_normal, int even_friction)
{
  restore_solution(e);
  for (int a = 0; a < e->modes.active_count; a++) e->rows.emphasis[a] = 1;
  gather_forces(e);
  take_normals(e);
  find_combinations(e);
  if (even_normal && (any_sliding(e) || !relate(e, 1, 0))) return 0;
  scatter_forces(e);
  nsdae_event_hold_resting(e);
  gather_forces(e);
  take_normals(e);
  take_sticking(e);
  find_combinations(e);
  int related = even_friction ? relate_friction(e, even_normal) : relate(e, even_normal, 0);
  return related && holds(e, rounding_size(e));
}

static void mark_rows(nsdae_event_method *e)
{
  const nsdae_row_set *s = &e->rows;
  const nsdae_dims *d = &e->stepper->system->dims;
  for (int i = 0; i < d->k * (1 + d->nt); i++) e->relation[i] = -1;
  for (int i = 0; i < s->dependent_count; i++)
    e->relation[s->unknown[s->dependent[i]] - nsdae_at_normal(d)] = s->dependent[i];
}

/* Slides come last; one that depends keeps its part of |lambda|. */
static void take_slides(nsdae_event_method *e)
{
  const nsdae_contacts *c = &e->modes;
  const nsdae_system *s = e->stepper->system;
  for (int i = 0; i < c->slide_count; i++) {
    int j = c->slide[i], taken = e->rows.taken_count;
    double most = s->slide[j].mu * fabs(e->lambda[s->slide[j].constraint]);
    e->slide_part[j] = e->slide_sense[j];
    if (e->slide_mode[j] != NSDAE_MODE_STICK) continue;
    take_row(e, c->columns - c->slide_count + i);
    e->slide_row[j] = e->rows.taken_count > taken;
    e->slide_part[j] = most > 0 ? -c->results->slide_impulse[j] / most : 0;
  }
}

int nsdae_event_find_rows(nsdae_event_method *e, double t)
{
  static const int even[4][2] = {{1, 1}, {1, 0}, {0, 1}, {0, 0}};
  nsdae_row_set *s = &e->rows;
  int found = 0;
  memcpy(s->solved_mode, e->mode, (size_t)e->stepper->system->dims.k * sizeof *e->mode);
  memcpy(s->solved, e->modes.delassus.impulse, (size_t)e->modes.columns * sizeof *s->solved);
  for (int i = 0; i < 4 && !found; i++) found = try_forces(e, even[i][0], even[i][1]);
  if (!found) {
    restore_solution(e);
    nsdae_error_set(e->stepper->error, NSDAE_E_CONVERGENCE, "nsdae_event", "polygon",
                    "no friction of the contacts that stick at t = %.17g was found that holds "
                    "them: try more edges of the polygon, or method = implicit",
                    t);
    e->stepper->error->time = t;
    return NSDAE_E_CONVERGENCE;
  }
  scatter_forces(e);
  mark_rows(e);
  take_slides(e);
  return NSDAE_OK;
}
