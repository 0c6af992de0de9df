#include "hyperstatic.h"

#include <math.h>
#include <string.h>

#include "vector.h"

enum { ROUNDS = 50 };

/* Of the friction there can be: more than that is nearly all. */
static const double NEARLY_ALL = 0.99;

/* Of the largest weight. */
static const double LEAST_WEIGHT = 1e-6;

/* The Delassus matrix has squared what rank_tol is meant for. */
static const double LEAST_SINE = 1e-6;

void nsdae_hyperstatic_layout(nsdae_hyperstatic *s, const nsdae_dims *d, nsdae_arena *arena)
{
  long k = d->k, n = k * (1 + d->nt) + d->f;
  int **of_column[] = {&s->normal, &s->force_number, &s->pivot};
  double **square[] = {&s->relation, &s->system};
  double **line[] = {&s->force, &s->weight, &s->solved, &s->shift};
  nsdae_rank_revealing_layout(&s->rows, n, arena);
  for (int i = 0; i < 3; i++) *of_column[i] = NSDAE_ARENA_INTS(arena, n);
  for (int i = 0; i < 2; i++) *square[i] = NSDAE_ARENA_DOUBLES(arena, n * n);
  for (int i = 0; i < 4; i++) *line[i] = NSDAE_ARENA_DOUBLES(arena, n);
  s->solved_mode = NSDAE_ARENA_INTS(arena, k);
  s->emphasis = NSDAE_ARENA_DOUBLES(arena, k);
}

static const nsdae_contacts *problem_of(const nsdae_hyperstatic *s)
{
  return s->of->problem;
}

static const nsdae_system *system_of(const nsdae_hyperstatic *s)
{
  return s->of->problem->system;
}

static double *row_of(const nsdae_hyperstatic *s, double *matrix, int column)
{
  return matrix + (size_t)column * (size_t)problem_of(s)->columns;
}

/* Columns of contacts: those of frictional joints come after them. */
static int contact_columns(const nsdae_hyperstatic *s)
{
  return problem_of(s)->columns - problem_of(s)->slides.count;
}

/* ---- relations of dependent forces */

/* r of p, and so the weights of the equation F_p - sum r_l F_l = 0. */
static void even_relation(nsdae_hyperstatic *s, int p)
{
  double *r = row_of(s, s->relation, p), *c = row_of(s, s->rows.combination, p);
  int normal = s->normal[p] == p;
  for (int l = 0; l < contact_columns(s); l++)
    r[l] = (s->normal[l] == l) == normal ? c[l] * s->weight[l] / s->weight[p] : 0;
}

static void kept_relation(nsdae_hyperstatic *s, int p)
{
  double *r = row_of(s, s->relation, p), sum = 0;
  memset(r, 0, (size_t)problem_of(s)->columns * sizeof *r);
  if (s->normal[p] != p) {
    r[s->normal[p]] = s->force[p] / s->force[s->normal[p]];
    return;
  }
  for (int l = 0; l < s->rows.taken_count; l++)
    if (s->normal[s->rows.taken[l]] == s->rows.taken[l]) sum += s->force[s->rows.taken[l]];
  for (int l = 0; l < s->rows.taken_count && sum > 0; l++)
    if (s->normal[s->rows.taken[l]] == s->rows.taken[l]) r[s->rows.taken[l]] = s->force[p] / sum;
}

/* The forces along the columns z of the dependent that fulfil their relations:
 * (F + Z a)_p - sum r_l (F + Z a)_l = 0. */
static int fulfil_relations(nsdae_hyperstatic *s)
{
  int count = s->rows.dependent_count, n = problem_of(s)->columns;
  for (int i = 0; i < count; i++) {
    int p = s->rows.dependent[i];
    const double *r = row_of(s, s->relation, p);
    s->shift[i] = nsdae_dot(n, r, s->force) - s->force[p];
    for (int j = 0; j < count; j++) {
      int q = s->rows.dependent[j];
      double entry = nsdae_dot(n, r, row_of(s, s->rows.combination, q)) - r[q] + (p == q);
      s->system[(size_t)j * (size_t)count + (size_t)i] = entry;
    }
  }
  if (nsdae_la_lu(count, s->system, count, s->pivot) != 0) return 0;
  nsdae_la_lu_solve(count, s->system, count, s->pivot, s->shift);
  for (int i = 0; i < count; i++) {
    const double *c = row_of(s, s->rows.combination, s->rows.dependent[i]);
    s->force[s->rows.dependent[i]] += s->shift[i];
    for (int l = 0; l < n; l++) s->force[l] -= s->shift[i] * c[l];
  }
  return 1;
}

/* ---- what the forces of a solution obey */

/* Zero for a force of the a-th closed contact: up to the error of a solved complementarity problem,
 * and up to what gives its row l no acceleration, G_ll F_l <= none. Bodies that fall together have
 * such forces alone. */
static double rounding_size(const nsdae_hyperstatic *s, int a)
{
  const nsdae_contacts *c = problem_of(s);
  double rounding = c->lcp.options.tol * nsdae_largest(c->columns, s->force);
  for (int l = c->first_column[a]; l < c->first_column[a + 1]; l++) {
    double G = row_of(s, c->delassus.G, l)[l];
    if (G > 0) rounding = fmax(rounding, s->of->none / G);
  }
  return rounding;
}

/* Whether no contact pulls. */
static int pushes(const nsdae_hyperstatic *s)
{
  const nsdae_contacts *c = problem_of(s);
  int all = 1;
  for (int a = 0; a < c->active_count; a++)
    all &= s->force[c->first_column[a]] >= -rounding_size(s, a);
  return all;
}

/* |F_T|, and the most that there can be, of the a-th closed contact. */
static double friction_of(const nsdae_hyperstatic *s, int a)
{
  const nsdae_contacts *c = problem_of(s);
  int first = c->first_column[a] + 1;
  return nsdae_norm(c->first_column[a + 1] - first, s->force + first);
}

static double most_friction(const nsdae_hyperstatic *s, int a)
{
  const nsdae_contacts *c = problem_of(s);
  return system_of(s)->contact[c->active[a]].mu * s->force[c->first_column[a]];
}

static int sticks(const nsdae_hyperstatic *s, int a)
{
  return s->of->mode[problem_of(s)->active[a]] == NSDAE_MODE_STICK;
}

/* Whether, of what sticks, nothing leaves its cone. */
static int holds(const nsdae_hyperstatic *s)
{
  int all = 1;
  for (int a = 0; a < problem_of(s)->active_count; a++)
    all &= !sticks(s, a) || friction_of(s, a) <= most_friction(s, a) + rounding_size(s, a);
  return all;
}

/* ---- order of the columns */

static void gather_forces(nsdae_hyperstatic *s)
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
      s->force_number[l] = i * (1 + d->nt) + l - column;
    }
  }
}

static void scatter_forces(nsdae_hyperstatic *s)
{
  nsdae_contacts *c = s->of->problem;
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
static int next_normal(const nsdae_hyperstatic *s)
{
  const nsdae_contacts *c = problem_of(s);
  int next = -1;
  for (int a = 0; a < c->active_count; a++) {
    int column = c->first_column[a];
    if (s->of->mode[c->active[a]] == NSDAE_MODE_OPEN || s->rows.seen[column]) continue;
    if (next < 0 || s->force[column] > s->force[next]) next = column;
  }
  return next;
}

static void take_normals(nsdae_hyperstatic *s)
{
  s->rows.sine = fmax(s->of->rank_tol, LEAST_SINE * s->of->looser);
  nsdae_rank_revealing_start(&s->rows, problem_of(s)->columns, problem_of(s)->delassus.G);
  for (int column = next_normal(s); column >= 0; column = next_normal(s))
    nsdae_rank_revealing_take(&s->rows, column);
}

/* The column of what sticks that depends least on those taken; -1 past the last. A row that nearly
 * depends, taken early, would make the rounding of the next ones look like rows. */
static int next_sticking(nsdae_hyperstatic *s)
{
  const nsdae_contacts *c = problem_of(s);
  int next = -1;
  double most = -INFINITY;
  for (int a = 0; a < c->active_count; a++)
    for (int l = c->first_column[a] + 1; l < c->first_column[a + 1] && sticks(s, a); l++) {
      if (s->rows.seen[l]) continue;
      double part = nsdae_rank_revealing_rest(&s->rows, l);
      if (next >= 0 && !(part > most)) continue;
      next = l;
      most = part;
    }
  return next;
}

/* ---- equal shares */

/* Whether the a-th closed contact slides, or begins to, with friction. */
static int slides(const nsdae_hyperstatic *s, int a)
{
  const nsdae_contacts *c = problem_of(s);
  int i = c->active[a], nt = system_of(s)->dims.nt;
  if (s->of->mode[i] == NSDAE_MODE_OPEN || s->of->moving[i])
    return s->of->mode[i] != NSDAE_MODE_OPEN;
  return s->of->mode[i] == NSDAE_MODE_SLIP && friction_of(s, a) > 0 &&
         nsdae_norm(nt, c->results->after_t + i * nt) > s->of->none;
}

static int any_sliding(const nsdae_hyperstatic *s)
{
  int any = 0;
  for (int a = 0; a < problem_of(s)->active_count; a++) any |= slides(s, a);
  return any;
}

/* Whether the normal forces of what slides are those of the solution: their friction would follow
 * them, and what changes only how forces share would move something. */
static int keeps_sliding(const nsdae_hyperstatic *s)
{
  const nsdae_contacts *c = problem_of(s);
  int all = 1;
  for (int a = 0; a < c->active_count; a++) {
    int column = c->first_column[a];
    all &= !slides(s, a) || fabs(s->force[column] - s->solved[column]) <= rounding_size(s, a);
  }
  return all;
}

/* Relations and forces of all that depend: normal forces even or kept, friction even or kept. */
static int relate(nsdae_hyperstatic *s, int even_normal, int even_friction)
{
  gather_forces(s);
  for (int i = 0; i < s->rows.dependent_count; i++) {
    int p = s->rows.dependent[i], even = s->normal[p] == p ? even_normal : even_friction;
    if (even)
      even_relation(s, p);
    else
      kept_relation(s, p);
  }
  return fulfil_relations(s) && pushes(s);
}

/* ---- friction within its bound */

/* Friction that is used of what there can be, of the a-th closed contact. */
static double share_used(const nsdae_hyperstatic *s, int a)
{
  double most = most_friction(s, a);
  return sticks(s, a) && most > 0 ? friction_of(s, a) / most : 0;
}

/* Where friction is nearly used up somewhere, weights that ask for the least |F_T| / (mu F_N) of
 * the largest: each times that of its contact (Lawson 1961). So that no contact is at its limit
 * before all must be. */
static int relate_friction(nsdae_hyperstatic *s, int even_normal)
{
  int related = 0;
  double worst = 1;
  for (int round = 0; round < ROUNDS && worst > NEARLY_ALL; round++) {
    related = relate(s, even_normal, 1);
    if (!related) break;
    worst = 0;
    for (int a = 0; a < problem_of(s)->active_count; a++) worst = fmax(worst, share_used(s, a));
    /* Each weight times what its contact uses, the largest 1. Those that get none would leave
     * relations that rounding rules. */
    double most = 0;
    int count = problem_of(s)->active_count;
    for (int a = 0; a < count; a++) most = fmax(most, s->emphasis[a] *= share_used(s, a));
    for (int a = 0; a < count && most > 0; a++)
      s->emphasis[a] = fmax(s->emphasis[a] / most, LEAST_WEIGHT);
  }
  return related;
}

/* ---- the forces of a solution */

static void restore_solution(nsdae_hyperstatic *s)
{
  size_t k = (size_t)system_of(s)->dims.k, columns = (size_t)problem_of(s)->columns;
  memcpy(s->of->mode, s->solved_mode, k * sizeof *s->solved_mode);
  memcpy(s->force, s->solved, columns * sizeof *s->force);
  scatter_forces(s);
}

/* A contact at rest whose friction is all used, and which does not begin to slide, sticks: others
 * hold it. Where one just broke away its neighbours are about to. */
static void hold_resting(const nsdae_hyperstatic *s)
{
  const nsdae_contacts *c = problem_of(s);
  int *mode = s->of->mode, any = 0, nt = system_of(s)->dims.nt;
  for (int i = 0; i < c->system->dims.k; i++) any |= s->of->breakaway[i];
  for (int a = 0; a < c->active_count && !any; a++) {
    int i = c->active[a];
    if (mode[i] != NSDAE_MODE_SLIP || s->of->moving[i] || !(c->results->normal[i] > 0)) continue;
    if (c->law[a].columns == 1 || nsdae_contacts_powerless(c, c->first_column[a] + 1)) continue;
    if (nsdae_norm(nt, c->results->after_t + i * nt) <= s->of->none) mode[i] = NSDAE_MODE_STICK;
  }
}

/* From the modes and forces of the problem's solution. */
static int try_forces(nsdae_hyperstatic *s, int even_normal, int even_friction)
{
  restore_solution(s);
  for (int a = 0; a < problem_of(s)->active_count; a++) s->emphasis[a] = 1;
  gather_forces(s);
  take_normals(s);
  nsdae_rank_revealing_combine(&s->rows);
  if (even_normal && (any_sliding(s) || !relate(s, 1, 0))) return 0;
  scatter_forces(s);
  hold_resting(s);
  gather_forces(s);
  take_normals(s);
  for (int column = next_sticking(s); column >= 0; column = next_sticking(s))
    nsdae_rank_revealing_take(&s->rows, column);
  nsdae_rank_revealing_combine(&s->rows);
  int related = even_friction ? relate_friction(s, even_normal) : relate(s, even_normal, 0);
  return related && holds(s) && keeps_sliding(s);
}

/* ---- relations for a phase */

static void hand_over(nsdae_hyperstatic *s)
{
  const nsdae_shared *m = s->of;
  const nsdae_dims *d = &system_of(s)->dims;
  int all = d->k * (1 + d->nt);
  memset(m->related, 0, (size_t)all * sizeof *m->related);
  for (int i = 0; i < s->rows.dependent_count; i++) {
    int p = s->rows.dependent[i], force = s->force_number[p];
    m->related[force] = 1;
    for (int l = 0; l < all; l++) m->relation[nsdae_relation_at(d->nt, force, l)] = 0;
    for (int l = 0; l < contact_columns(s); l++)
      m->relation[nsdae_relation_at(d->nt, force, s->force_number[l])] =
          row_of(s, s->relation, p)[l];
  }
}

/* Slides come last; one that depends keeps its part of its limit. */
static void take_slides(nsdae_hyperstatic *s)
{
  const nsdae_contacts *c = problem_of(s);
  const nsdae_shared *m = s->of;
  for (int i = 0; i < c->slides.count; i++) {
    int j = c->slides.number[i];
    const nsdae_frictional_joint *joint = &system_of(s)->frictional_joint[j];
    double load = joint->mu > 0 ? joint->mu * fabs(m->lambda[joint->constraint]) : 0,
           most = c->slides.bound[j] + load;
    m->slide_part[j] = m->slide_sense[j];
    if (m->frictional_joint_mode[j] != NSDAE_MODE_STICK) continue;
    m->slide_row[j] = nsdae_rank_revealing_take(&s->rows, contact_columns(s) + i);
    m->slide_part[j] = most > 0 ? -c->results->frictional_joint_impulse[j] / most : 0;
  }
}

int nsdae_share(nsdae_hyperstatic *s, const nsdae_shared *of)
{
  static const int even[4][2] = {{1, 1}, {1, 0}, {0, 1}, {0, 0}};
  const nsdae_contacts *c = of->problem;
  int found = 0;
  s->of = of;
  memcpy(s->solved_mode, of->mode, (size_t)c->system->dims.k * sizeof(int));
  memcpy(s->solved, c->delassus.impulse, (size_t)c->columns * sizeof *s->solved);
  for (int i = 0; i < 4 && !found; i++) found = try_forces(s, even[i][0], even[i][1]);
  if (found) {
    scatter_forces(s);
    hand_over(s);
    take_slides(s);
  } else {
    restore_solution(s);
  }
  return found;
}
