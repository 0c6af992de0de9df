#include "sharing.h"

#include <math.h>
#include <string.h>

#include "dense.h"
#include "errors.h"

enum { ROUNDS = 50 };

/* Of the friction there can be: more than that is nearly all. */
static const double NEARLY_ALL = 0.99;

/* Of the largest weight. */
static const double LEAST_WEIGHT = 1e-6;

/* The Delassus matrix has squared what rank_tol is meant for. */
static const double LEAST_SINE = 1e-6;

void nsdae_event_sharing_layout(nsdae_event_sharing *s, nsdae_arena *arena)
{
  const nsdae_dims *d = &s->acceleration->phase->setting->system->dims;
  long k = d->k, n = k * (1 + d->nt) + d->f;
  int **of_column[] = {&s->taken,  &s->dependent,    &s->rank_before, &s->seen,
                       &s->normal, &s->force_number, &s->pivot};
  double **square[] = {&s->factor, &s->combination, &s->relation, &s->system};
  double **line[] = {&s->force, &s->weight, &s->solved, &s->shift};
  for (int i = 0; i < 7; i++) *of_column[i] = NSDAE_ARENA_INTS(arena, n);
  for (int i = 0; i < 4; i++) *square[i] = NSDAE_ARENA_DOUBLES(arena, n * n);
  for (int i = 0; i < 4; i++) *line[i] = NSDAE_ARENA_DOUBLES(arena, n);
  s->solved_mode = NSDAE_ARENA_INTS(arena, k);
  s->emphasis = NSDAE_ARENA_DOUBLES(arena, k);
}

static const nsdae_contacts *problem_of(const nsdae_event_sharing *s)
{
  return &s->acceleration->problem;
}

static nsdae_event_modes *modes_of(const nsdae_event_sharing *s)
{
  return &s->acceleration->phase->modes;
}

static const nsdae_system *system_of(const nsdae_event_sharing *s)
{
  return s->acceleration->phase->setting->system;
}

static double *row_of(const nsdae_event_sharing *s, double *matrix, int column)
{
  return matrix + (size_t)column * (size_t)problem_of(s)->columns;
}

/* The row of the Cholesky factor of G for a column after those taken; what it leaves of the
 * diagonal entry. */
static double factor_row(nsdae_event_sharing *s, int column)
{
  const double *G = row_of(s, problem_of(s)->delassus.G, column);
  double *row = row_of(s, s->factor, column), rest = G[column];
  for (int j = 0; j < s->taken_count; j++) {
    const double *other = row_of(s, s->factor, s->taken[j]);
    row[j] = (G[s->taken[j]] - nsdae_dot(j, row, other)) / other[j];
    rest -= row[j] * row[j];
  }
  return rest;
}

/* A further row, unless it depends on those before it. */
static void take_row(nsdae_event_sharing *s, int column)
{
  double rest = factor_row(s, column), entry = row_of(s, problem_of(s)->delassus.G, column)[column];
  double sine = fmax(s->acceleration->phase->setting->options->rank_tol, LEAST_SINE);
  s->seen[column] = 1;
  s->rank_before[column] = s->taken_count;
  if (!(rest > sine * sine * entry)) {
    s->dependent[s->dependent_count++] = column;
    return;
  }
  row_of(s, s->factor, column)[s->taken_count] = sqrt(rest);
  s->taken[s->taken_count++] = column;
}

/* c by L^T c = row p of the factor. */
static void find_combination(nsdae_event_sharing *s, int p)
{
  double *c = row_of(s, s->combination, p), *row = row_of(s, s->factor, p);
  memset(c, 0, (size_t)problem_of(s)->columns * sizeof *c);
  for (int l = s->rank_before[p] - 1; l >= 0; l--) {
    double sum = row[l];
    for (int i = l + 1; i < s->rank_before[p]; i++)
      sum -= row_of(s, s->factor, s->taken[i])[l] * c[s->taken[i]];
    c[s->taken[l]] = sum / row_of(s, s->factor, s->taken[l])[l];
  }
}

/* Columns of contacts: those of slides come after them. */
static int contact_columns(const nsdae_event_sharing *s)
{
  return problem_of(s)->columns - problem_of(s)->slide_count;
}

/* r of p, and so the weights of the equation F_p - sum r_l F_l = 0. */
static void even_relation(nsdae_event_sharing *s, int p)
{
  double *r = row_of(s, s->relation, p), *c = row_of(s, s->combination, p);
  int normal = s->normal[p] == p;
  for (int l = 0; l < contact_columns(s); l++)
    r[l] = (s->normal[l] == l) == normal ? c[l] * s->weight[l] / s->weight[p] : 0;
}

static void kept_relation(nsdae_event_sharing *s, int p)
{
  double *r = row_of(s, s->relation, p), sum = 0;
  memset(r, 0, (size_t)problem_of(s)->columns * sizeof *r);
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
static int fulfil_relations(nsdae_event_sharing *s)
{
  int count = s->dependent_count, n = problem_of(s)->columns;
  for (int i = 0; i < count; i++) {
    int p = s->dependent[i];
    const double *r = row_of(s, s->relation, p);
    s->shift[i] = nsdae_dot(n, r, s->force) - s->force[p];
    for (int j = 0; j < count; j++) {
      int q = s->dependent[j];
      double entry = nsdae_dot(n, r, row_of(s, s->combination, q)) - r[q] + (p == q);
      s->system[(size_t)j * (size_t)count + (size_t)i] = entry;
    }
  }
  if (nsdae_la_lu(count, s->system, count, s->pivot) != 0) return 0;
  nsdae_la_lu_solve(count, s->system, count, s->pivot, s->shift);
  for (int i = 0; i < count; i++) {
    const double *c = row_of(s, s->combination, s->dependent[i]);
    s->force[s->dependent[i]] += s->shift[i];
    for (int l = 0; l < n; l++) s->force[l] -= s->shift[i] * c[l];
  }
  return 1;
}

/* Zero for a force, but for the error of a solved complementarity problem. */
static double rounding_size(const nsdae_event_sharing *s)
{
  return s->acceleration->phase->setting->options->lcp_tol *
         nsdae_event_largest(problem_of(s)->columns, s->force);
}

/* Whether no contact pulls. */
static int pushes(const nsdae_event_sharing *s)
{
  const nsdae_contacts *c = problem_of(s);
  int all = 1;
  for (int a = 0; a < c->active_count; a++)
    all &= s->force[c->first_column[a]] >= -rounding_size(s);
  return all;
}

/* |F_T|, and the most that there can be, of the a-th closed contact. */
static double friction_of(const nsdae_event_sharing *s, int a)
{
  const nsdae_contacts *c = problem_of(s);
  double friction = 0;
  for (int l = c->first_column[a] + 1; l < c->first_column[a + 1]; l++)
    friction = hypot(friction, s->force[l]);
  return friction;
}

static double most_friction(const nsdae_event_sharing *s, int a)
{
  const nsdae_contacts *c = problem_of(s);
  return system_of(s)->contact[c->active[a]].mu * s->force[c->first_column[a]];
}

static int sticks(const nsdae_event_sharing *s, int a)
{
  return modes_of(s)->contact[problem_of(s)->active[a]] == NSDAE_MODE_STICK;
}

/* Whether, of what sticks, nothing leaves its cone. */
static int holds(const nsdae_event_sharing *s)
{
  int all = 1;
  for (int a = 0; a < problem_of(s)->active_count; a++)
    all &= !sticks(s, a) || friction_of(s, a) <= most_friction(s, a) + rounding_size(s);
  return all;
}

static void gather_forces(nsdae_event_sharing *s)
{
  const nsdae_contacts *c = problem_of(s);
  const nsdae_dims *d = &system_of(s)->dims;
  memcpy(s->force, c->delassus.impulse, (size_t)c->columns * sizeof *s->force);
  for (int a = 0; a < c->active_count; a++) {
    int column = c->first_column[a], i = c->active[a];
    double most = system_of(s)->contact[i].mu * c->results->normal[i];
    for (int l = column; l < c->first_column[a + 1]; l++) {
      s->normal[l] = column;
      s->weight[l] = l > column && most > 0 ? s->emphasis[a] / most : 1;
      s->force_number[l] = l == column ? i : d->k + i * d->nt + l - column - 1;
    }
  }
}

static void scatter_forces(nsdae_event_sharing *s)
{
  nsdae_contacts *c = &s->acceleration->problem;
  int nt = system_of(s)->dims.nt;
  memcpy(c->delassus.impulse, s->force, (size_t)c->columns * sizeof *c->delassus.impulse);
  for (int a = 0; a < c->active_count; a++) {
    int column = c->first_column[a], i = c->active[a];
    c->results->normal[i] = c->delassus.impulse[column];
    for (int l = column + 1; l < c->first_column[a + 1]; l++)
      c->results->tangential[i * nt + l - column - 1] = c->delassus.impulse[l];
  }
}

/* The closed contact with the largest normal force of those not seen; -1 past the last. */
static int next_normal(const nsdae_event_sharing *s)
{
  const nsdae_contacts *c = problem_of(s);
  int next = -1;
  for (int a = 0; a < c->active_count; a++) {
    int column = c->first_column[a];
    if (modes_of(s)->contact[c->active[a]] == NSDAE_MODE_OPEN || s->seen[column]) continue;
    if (next < 0 || s->force[column] > s->force[next]) next = column;
  }
  return next;
}

static void take_normals(nsdae_event_sharing *s)
{
  s->taken_count = s->dependent_count = 0;
  memset(s->seen, 0, (size_t)problem_of(s)->columns * sizeof *s->seen);
  for (int column = next_normal(s); column >= 0; column = next_normal(s)) take_row(s, column);
}

/* The column of what sticks that depends least on those taken; -1 past the last. A row that nearly
 * depends, taken early, would make the rounding of the next ones look like rows. */
static int next_sticking(nsdae_event_sharing *s)
{
  const nsdae_contacts *c = problem_of(s);
  int next = -1;
  double most = -INFINITY;
  for (int a = 0; a < c->active_count; a++)
    for (int l = c->first_column[a] + 1; l < c->first_column[a + 1] && sticks(s, a); l++) {
      if (s->seen[l]) continue;
      double part = factor_row(s, l) / row_of(s, c->delassus.G, l)[l];
      if (next >= 0 && !(part > most)) continue;
      next = l;
      most = part;
    }
  return next;
}

static void take_sticking(nsdae_event_sharing *s)
{
  for (int column = next_sticking(s); column >= 0; column = next_sticking(s)) take_row(s, column);
}

/* Friction of what slides is in the columns of normal forces: then their z are others. */
static int any_sliding(const nsdae_event_sharing *s)
{
  int any = 0;
  for (int i = 0; i < system_of(s)->dims.k; i++)
    any |= modes_of(s)->contact[i] != NSDAE_MODE_OPEN && s->acceleration->is.moving[i];
  return any;
}

/* Relations and forces of all that depend: normal forces even or kept, friction even or kept. */
static int relate(nsdae_event_sharing *s, int even_normal, int even_friction)
{
  gather_forces(s);
  for (int i = 0; i < s->dependent_count; i++) {
    int p = s->dependent[i], even = s->normal[p] == p ? even_normal : even_friction;
    if (even)
      even_relation(s, p);
    else
      kept_relation(s, p);
  }
  return fulfil_relations(s) && pushes(s);
}

/* Friction that is used of what there can be, of the a-th closed contact. */
static double share_used(const nsdae_event_sharing *s, int a)
{
  double most = most_friction(s, a);
  return sticks(s, a) && most > 0 ? friction_of(s, a) / most : 0;
}

/* Each weight times what its contact uses, the largest 1. Those that get none would leave relations
 * that rounding rules. */
static void emphasise(nsdae_event_sharing *s)
{
  double most = 0;
  int count = problem_of(s)->active_count;
  for (int a = 0; a < count; a++) most = fmax(most, s->emphasis[a] *= share_used(s, a));
  for (int a = 0; a < count && most > 0; a++)
    s->emphasis[a] = fmax(s->emphasis[a] / most, LEAST_WEIGHT);
}

/* Where friction is nearly used up somewhere, weights that ask for the least |F_T| / (mu F_N) of
 * the largest: each times that of its contact (Lawson 1961). So that no contact is at its limit
 * before all must be. */
static int relate_friction(nsdae_event_sharing *s, int even_normal)
{
  int related = 0;
  double worst = 1;
  for (int round = 0; round < ROUNDS && worst > NEARLY_ALL; round++) {
    related = relate(s, even_normal, 1);
    if (!related) break;
    worst = 0;
    for (int a = 0; a < problem_of(s)->active_count; a++) worst = fmax(worst, share_used(s, a));
    emphasise(s);
  }
  return related;
}

static void find_combinations(nsdae_event_sharing *s)
{
  for (int i = 0; i < s->dependent_count; i++) find_combination(s, s->dependent[i]);
}

static void restore_solution(nsdae_event_sharing *s)
{
  size_t k = (size_t)system_of(s)->dims.k, columns = (size_t)problem_of(s)->columns;
  memcpy(modes_of(s)->contact, s->solved_mode, k * sizeof *s->solved_mode);
  memcpy(s->force, s->solved, columns * sizeof *s->force);
  scatter_forces(s);
}

static double slip_rate(const nsdae_contacts *c, int i)
{
  int nt = c->system->dims.nt;
  double rate = 0;
  for (int l = 0; l < nt; l++) rate = hypot(rate, c->results->after_t[i * nt + l]);
  return rate;
}

void nsdae_event_hold_resting(nsdae_event_acceleration *p)
{
  const nsdae_contacts *c = &p->problem;
  int *mode = p->phase->modes.contact, any = 0;
  double size = nsdae_event_acceleration_size(p);
  for (int i = 0; i < c->system->dims.k; i++) any |= p->is.breakaway[i];
  for (int a = 0; a < c->active_count && !any; a++) {
    int i = c->active[a];
    if (mode[i] != NSDAE_MODE_SLIDE || p->is.moving[i] || !(c->results->normal[i] > 0)) continue;
    if (c->law[i].columns == 1 || nsdae_event_powerless(c, c->first_column[a] + 1)) continue;
    if (slip_rate(c, i) <= size) mode[i] = NSDAE_MODE_STICK;
  }
}

/* From the modes and forces of the problem's solution. */
static int try_forces(nsdae_event_sharing *s, int even_normal, int even_friction)
{
  restore_solution(s);
  for (int a = 0; a < problem_of(s)->active_count; a++) s->emphasis[a] = 1;
  gather_forces(s);
  take_normals(s);
  find_combinations(s);
  if (even_normal && (any_sliding(s) || !relate(s, 1, 0))) return 0;
  scatter_forces(s);
  nsdae_event_hold_resting(s->acceleration);
  gather_forces(s);
  take_normals(s);
  take_sticking(s);
  find_combinations(s);
  int related = even_friction ? relate_friction(s, even_normal) : relate(s, even_normal, 0);
  return related && holds(s);
}

/* The relations by the numbers of the phase's forces. */
static void hand_over(nsdae_event_sharing *s)
{
  nsdae_event_modes *m = modes_of(s);
  const nsdae_dims *d = &system_of(s)->dims;
  size_t all = (size_t)(d->k * (1 + d->nt));
  memset(m->related, 0, all * sizeof *m->related);
  for (int i = 0; i < s->dependent_count; i++) {
    int p = s->dependent[i];
    double *r = m->relation + (size_t)s->force_number[p] * all;
    m->related[s->force_number[p]] = 1;
    memset(r, 0, all * sizeof *r);
    for (int l = 0; l < contact_columns(s); l++)
      r[s->force_number[l]] = row_of(s, s->relation, p)[l];
  }
}

/* Slides come last; one that depends keeps its part of |lambda|. */
static void take_slides(nsdae_event_sharing *s)
{
  const nsdae_contacts *c = problem_of(s);
  nsdae_event_modes *m = modes_of(s);
  const double *lambda = s->acceleration->lambda;
  for (int i = 0; i < c->slide_count; i++) {
    int j = c->slide[i], taken = s->taken_count;
    double most = system_of(s)->slide[j].mu * fabs(lambda[system_of(s)->slide[j].constraint]);
    m->slide_part[j] = m->slide_sense[j];
    if (m->slide[j] != NSDAE_MODE_STICK) continue;
    take_row(s, contact_columns(s) + i);
    m->slide_row[j] = s->taken_count > taken;
    m->slide_part[j] = most > 0 ? -c->results->slide_impulse[j] / most : 0;
  }
}

int nsdae_event_share(nsdae_event_sharing *s)
{
  static const int even[4][2] = {{1, 1}, {1, 0}, {0, 1}, {0, 0}};
  const nsdae_event_setting *setting = s->acceleration->phase->setting;
  const nsdae_contacts *c = problem_of(s);
  int found = 0;
  memcpy(s->solved_mode, modes_of(s)->contact, (size_t)c->system->dims.k * sizeof(int));
  memcpy(s->solved, c->delassus.impulse, (size_t)c->columns * sizeof *s->solved);
  for (int i = 0; i < 4 && !found; i++) found = try_forces(s, even[i][0], even[i][1]);
  if (!found) {
    restore_solution(s);
    nsdae_error_set(setting->error, NSDAE_E_CONVERGENCE, "nsdae_event", "polygon",
                    "no friction of the contacts that stick at t = %.17g was found that holds "
                    "them: try more edges of the polygon, or method = implicit",
                    setting->here->t);
    setting->error->time = setting->here->t;
    return NSDAE_E_CONVERGENCE;
  }
  scatter_forces(s);
  hand_over(s);
  take_slides(s);
  return NSDAE_OK;
}
