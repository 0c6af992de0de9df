#include "contact_problem.h"

#include <math.h>
#include <string.h>

#include "arena.h"
#include "errors.h"

int nsdae_problem_make(nsdae_problem *p, const nsdae_system *system, int threads,
                       nsdae_error *error)
{
  p->system = system;
  p->error = error;
  return nsdae_island_dispatch_make(&p->dispatch, system, threads, error);
}

/* The arrays of the closed contacts. */
enum { ARRAYS = 5 };

#define EACH(p)                                                                    \
  {                                                                                \
    NSDAE_ARRAY((p)->dispatch.islands.contact.of, 1), NSDAE_ARRAY((p)->number, 1), \
        NSDAE_ARRAY((p)->picked.item, 1), NSDAE_ARRAY((p)->picked.place, 1),       \
        NSDAE_ARRAY((p)->picked.law, 1)                                            \
  }

void nsdae_problem_release(nsdae_problem *p)
{
  const nsdae_array each[ARRAYS] = EACH(p);
  nsdae_arrays_release(each, ARRAYS);
  nsdae_ids_release(&p->picked.ids);
  nsdae_island_dispatch_release(&p->dispatch);
}

void nsdae_problem_prepare(nsdae_problem *p, nsdae_contacts *contacts, double rank_tol,
                           int least_norm)
{
  p->contacts = contacts;
  p->law = p->system->contact;
  nsdae_island_dispatch_prepare(&p->dispatch, contacts, rank_tol, least_norm);
}

void nsdae_problem_layout(nsdae_problem *p, nsdae_arena *arena)
{
  const nsdae_system *s = p->system;
  p->hit = NSDAE_ARENA_INTS(arena, s->blocks.count);
  nsdae_arena_doubles(arena, s->dims.f, (double **[]){&p->joint_bound, &p->joint_own, NULL});
  p->beside = nsdae_arena_take(arena, s->dims.f, sizeof *p->beside);
  nsdae_island_dispatch_layout(&p->dispatch, s, arena);
}

/* Fixed contacts and rows of a matrix have all the room that they can take. */
int nsdae_problem_grow(nsdae_problem *p, const nsdae_room *contacts, const nsdae_room *rows)
{
  const nsdae_system *s = p->system;
  const nsdae_array each[ARRAYS] = EACH(p);
  size_t m = (size_t)s->dims.m;
  nsdae_room all = nsdae_terms_room(s, contacts),
             matrix = {m * (size_t)s->blocks.count, m * (size_t)s->dims.nv};
  size_t f = (size_t)s->dims.f;
  nsdae_room joints = {f * (size_t)s->blocks.count, f * (size_t)s->dims.nv};
  if (s->call.constraint_rows) matrix = *rows;
  if (s->call.joint_friction_rows) joints = *rows;
  matrix.entries += joints.entries;
  matrix.values += 2 * joints.values; /* a joint has two rows in a problem of cones */
  int status = nsdae_arrays_grow(each, ARRAYS, all.entries);
  if (status == NSDAE_OK) status = nsdae_ids_grow(&p->picked.ids, (int)all.entries);
  return status < 0 ? status : nsdae_island_dispatch_grow(&p->dispatch, s, &all, &matrix);
}

/* ---- what is closed */

static void recall(nsdae_problem *p, int a, const nsdae_closed *last, const nsdae_impulses *was,
                   int from)
{
  nsdae_closed *c = p->closed;
  size_t nt = (size_t)c->nt, rows = (size_t)c->rows, bytes = rows * sizeof *c->basis;
  int *basis = c->basis + (size_t)a * rows;
  c->fresh[a] = from < 0 || was->normal[from] == 0;
  if (from < 0) {
    memset(basis, 0, bytes);
    return;
  }
  memcpy(basis, last->basis + (size_t)from * rows, bytes);
  p->results->normal[a] = was->normal[from];
  memcpy(p->results->tangential + (size_t)a * nt, was->tangential + (size_t)from * nt,
         nt * sizeof *was->tangential);
}

/* Ids that are asked for in about the order of a list: mostly the one behind the last. */
typedef struct search {
  nsdae_ids *ids;
  int count, next, filled;
  const long *id;
} search;

/* The place of an id, or -1. */
static int find(search *s, long id)
{
  int i = s->next < s->count && s->id[s->next] == id ? s->next : -1;
  if (i < 0 && s->count > 0) {
    if (!s->filled) nsdae_ids_fill(s->ids, s->count, s->id);
    s->filled = 1;
    i = nsdae_ids_find(s->ids, id);
  }
  if (i >= 0) s->next = i + 1;
  return i;
}

/* The entries with a gap up to touch. */
static void pick(nsdae_problem *p, const nsdae_contact_list *list, double touch)
{
  nsdae_closed *c = p->closed;
  c->count = 0;
  for (int i = 0; i < list->count; i++) {
    if (list->gap[i] > touch) continue;
    int a = c->count++;
    c->id[a] = list->id[i];
    c->gap[a] = list->gap[i];
    memcpy(c->block + 2 * (size_t)a, list->block + 2 * (size_t)i, 2 * sizeof *c->block);
    p->picked.item[a] = i;
    p->picked.law[a] = list->law[i];
    p->number[a] = a;
  }
}

static int close_list(nsdae_problem *p, nsdae_terms *terms, double touch, const nsdae_closed *last,
                      const nsdae_impulses *was)
{
  pick(p, &terms->by.list, touch);
  p->law = p->picked.law;
  p->warm.basis = p->closed->basis;
  /* No two of one id: seen at once where they ascend. */
  const nsdae_closed *c = p->closed;
  int i = 1;
  while (i < c->count && c->id[i - 1] < c->id[i]) i++;
  int twice = i < c->count ? nsdae_ids_fill(&p->picked.ids, c->count, c->id) : -1;
  int status = twice < 0 ? NSDAE_OK : nsdae_terms_id_twice(terms, c->id[twice]);
  if (status < 0) return status;
  nsdae_closed_clear(p->closed, p->results);
  /* What each did in the step before. */
  search before = {.ids = &p->picked.ids, .count = last->count, .id = last->id};
  for (int a = 0; a < p->closed->count; a++)
    recall(p, a, last, was, find(&before, p->closed->id[a]));
  nsdae_terms_select(terms, p->closed->count, p->picked.item);
  p->count = p->closed->count;
  return NSDAE_OK;
}

/* Where the impulses before have contact i: of slots, they are by place in a list; -1: nowhere. */
static int place_before(const nsdae_problem *p, int i, const nsdae_closed *last)
{
  const nsdae_tracked *tracked = p->system->tracked;
  if (!tracked) return i;
  int from = last->count - 1;
  while (from >= 0 && last->id[from] != tracked->id[i]) from--;
  return from;
}

static void recall_fixed(nsdae_problem *p, int i, const nsdae_impulses *was, int from)
{
  int nt = p->system->dims.nt;
  p->number[p->count++] = i;
  p->closed->fresh[i] = from < 0 || was->normal[from] == 0;
  if (from < 0) return;
  p->results->normal[i] = was->normal[from];
  for (int j = 0; j < nt; j++) p->results->tangential[i * nt + j] = was->tangential[from * nt + j];
}

/* One that is open forgets its basis, as one that leaves a list. */
static void close_fixed(nsdae_problem *p, const nsdae_terms *terms, double touch,
                        const nsdae_closed *last, const nsdae_impulses *was)
{
  int k = p->system->dims.k, rows = p->contacts->rows_most, *basis = p->warm.basis;
  p->law = p->system->contact;
  for (int i = 0; i < k; i++, basis += rows) {
    if (!(terms->gap[i] > touch))
      recall_fixed(p, i, was, place_before(p, i, last));
    else
      for (int l = 0; l < rows; l++) basis[l] = 0;
  }
}

int nsdae_problem_close(nsdae_problem *p, nsdae_terms *terms, nsdae_closed *closed,
                        nsdae_impulses *results, const nsdae_closed *last,
                        const nsdae_impulses *was)
{
  size_t f = (size_t)p->system->dims.f;
  p->closed = closed;
  p->results = results;
  p->home = terms;
  p->warm = p->contacts->warm;
  p->dispatch.factorisation.closed++;
  p->count = 0;
  nsdae_impulses_clear(results, &p->system->dims);
  if (f > 0)
    memcpy(results->frictional_joint_impulse, was->frictional_joint_impulse, f * sizeof(double));
  if (nsdae_terms_most(p->system) == 0) return NSDAE_OK;
  double touch = nsdae_terms_touch(terms);
  const nsdae_contact_list *list;
  int status = nsdae_terms_find(terms, touch, &list);
  if (status < 0) return status;
  if (list) return close_list(p, terms, touch, last, was);
  close_fixed(p, terms, touch, last, was);
  return NSDAE_OK;
}

int nsdae_problem_update(nsdae_problem *p, nsdae_terms *terms, double reach)
{
  nsdae_contact_list *list = &terms->by.list;
  int missing = 0;
  if (terms == p->home) return NSDAE_OK;
  int status = nsdae_terms_contacts(terms, reach);
  if (status < 0) return status;
  search here = {.ids = &p->picked.ids, .count = list->count, .id = list->id};
  for (int a = 0; a < p->closed->count; a++) {
    p->picked.place[a] = find(&here, p->closed->id[a]);
    missing += p->picked.place[a] < 0;
  }
  for (int a = 0; missing > 0 && a < p->closed->count; a++) {
    if (p->picked.place[a] >= 0) continue;
    p->picked.place[a] = list->count;
    nsdae_contact_list_copy(list, &p->home->by.list, p->picked.item[a], reach);
  }
  status = nsdae_differences_room(terms->differences, 0, &list->room, &list->taken);
  if (status < 0) {
    terms->have &= ~(unsigned)NSDAE_TERM_CONTACTS;
    return status;
  }
  nsdae_terms_select(terms, p->closed->count, p->picked.place);
  memcpy(p->closed->gap, terms->gap, (size_t)p->closed->count * sizeof *terms->gap);
  return NSDAE_OK;
}

void nsdae_problem_before(nsdae_problem *p, const nsdae_terms *T, const double *v, int impacts_only)
{
  const nsdae_contact_islands *is = &p->dispatch.islands;
  nsdae_contacts_approach(T, p->count, p->number, v, impacts_only, p->results);
  for (int i = 0; i < is->joints && !impacts_only; i++) {
    int j = is->joint_number[i];
    p->results->slide_before[j] = nsdae_terms_slide_rate(T, j, v);
  }
}

/* ---- the equations */

void nsdae_problem_bound(nsdae_problem *p, double share, const nsdae_terms *T, double others,
                         const nsdae_terms *other)
{
  for (int j = 0; j < p->system->dims.f; j++)
    p->joint_bound[j] = p->joint_own[j] =
        share * T->frictional_joint.bound[j] +
        (others > 0 ? others * other->frictional_joint.bound[j] : 0); /* INFINITY, of motors */
}

/* Gains below it would overflow as a compliance; their forces are none. */
static const double NO_GAIN = 1e-200;

/* The row of a position motor of error e_m and rate xi_0, of 1 / m = mobility. */
static nsdae_joint_row position_row(const nsdae_frictional_joint *motor, double h, double mobility,
                                    double e, double rate)
{
  double z = h * (motor->kd + h * motor->kp) * mobility, back = 1 / (2 + z), theta = 1 - back;
  double c = 1 / fmax(theta * (motor->kd + theta * h * motor->kp), NO_GAIN),
         s = sqrt(1 / (1 + c / h / mobility));
  double r = c * motor->kp * (e - h * back * back * rate) + c * motor->kd * back * rate;
  return (nsdae_joint_row){s * s * c / h, s * r, s};
}

int nsdae_problem_position(nsdae_problem *p, const nsdae_terms *T, double h, double ahead)
{
  const nsdae_system *s = p->system;
  int f = s->dims.f;
  double *e = p->results->slide_after; /* until the solution */
  for (int j = 0; j < f; j++) p->beside[j] = (nsdae_joint_row){0, 0, 1};
  if (f == 0 || !s->maker.errors) return NSDAE_OK;
  int code = s->maker.errors(nsdae_terms_time(T), T->q, e, s->user);
  int status = nsdae_terms_outcome(T, code, nsdae_system_joint_friction_name(s), e, f, 1);
  for (int j = 0; j < f && status == NSDAE_OK; j++) {
    const nsdae_frictional_joint *motor = &s->frictional_joint[j];
    double rate = p->results->slide_before[j];
    if (motor->position == NSDAE_POSITION_ROW)
      p->beside[j] =
          position_row(motor, h, nsdae_terms_mobility(T, T->M, &T->by.frictional_joint, j),
                       e[j] + ahead * rate, rate);
  }
  return status;
}

static int no_block(nsdae_problem *p, const nsdae_terms *T, int row)
{
  char called[NSDAE_CALLED_SIZE];
  nsdae_error_set(p->error, NSDAE_E_RANK, "nsdae_terms", "constraint_rows",
                  "constraint_rows has no entry for %s at t = %g",
                  nsdae_system_called(p->system, NSDAE_NAME_CONSTRAINT, row, called),
                  nsdae_terms_time(T));
  return nsdae_error_at(p->error, NSDAE_E_RANK, row, nsdae_terms_time(T));
}

int nsdae_problem_factor(nsdae_problem *p, const nsdae_terms *T, int hold)
{
  nsdae_island_dispatch *d = &p->dispatch;
  const nsdae_rows *J = &T->by.jacobian;
  for (int i = 0; T->system->call.constraint_rows && i < J->count; i++)
    if (J->first[i] == J->first[i + 1]) return no_block(p, T, i);
  d->factorisation.number++;
  d->factorisation.hold = hold;
  if (!hold && d->factorisation.dropped) {
    for (int i = 0; i < J->count; i++) d->factorisation.held[i] = 1;
    d->factorisation.dropped = 0;
  }
  nsdae_contact_islands_find(&d->islands, T, p->count, p->number);
  for (int i = 0; i < d->islands.count; i++) p->hit[i] = 0;
  return NSDAE_OK;
}

void nsdae_problem_mark_hit(nsdae_problem *p, const nsdae_terms *T)
{
  for (int a = 0; a < p->count; a++) {
    int i = p->number[a];
    if (p->results->impact[i]) p->hit[nsdae_island_of_contact(&p->dispatch.islands, T, i)] = 1;
  }
}

int nsdae_problem_solve(nsdae_problem *p, const nsdae_terms *terms, const double *M,
                        const double *r, int with_contacts, double *v, double *size, double *lambda)
{
  nsdae_island_equations whole = {.system = p->system,
                                  .islands = &p->dispatch.islands,
                                  .terms = terms,
                                  .law = p->law,
                                  .id = p->closed->id,
                                  .joint_bound = p->joint_bound,
                                  .beside = p->beside,
                                  .warm = p->warm,
                                  .factorisation = &p->dispatch.factorisation,
                                  .M = M,
                                  .r = r,
                                  .results = p->results,
                                  .v = v,
                                  .size = size,
                                  .lambda = lambda,
                                  .with_contacts = with_contacts};
  return nsdae_island_dispatch_solve(&p->dispatch, &whole);
}

/* ---- what the impulses did */

void nsdae_problem_add_constraints(const nsdae_problem *p, const nsdae_terms *T, double scale,
                                   int any_impact, const double *lambda, double *y)
{
  const nsdae_rows *J = &T->by.jacobian;
  for (int i = 0; i < J->count; i++)
    if (!any_impact || !p->hit[nsdae_island_of_row(&p->dispatch.islands, T, i)])
      nsdae_rows_add(&p->system->blocks, J, i, scale * lambda[i], y);
}

/* += share W Lambda of contact i */
static void add_linear(const nsdae_problem *p, const nsdae_terms *T, int i, double share)
{
  const nsdae_impulses *r = p->results;
  int nt = p->system->dims.nt;
  if (p->system->maker.sensors.contact_forces)
    nsdae_terms_add_linear(T, i, share, r->normal[i], r->tangential + i * nt, r->linear + 3 * i);
}

void nsdae_problem_add_impulse(const nsdae_problem *p, const nsdae_terms *T, double scale,
                               int skip_impacts, double *y)
{
  const nsdae_impulses *r = p->results;
  const nsdae_blocks *blocks = &p->system->blocks;
  const nsdae_contact_islands *is = &p->dispatch.islands;
  int nt = p->system->dims.nt;
  for (int a = 0; a < p->count; a++) {
    int i = p->number[a];
    if (r->normal[i] == 0 || (skip_impacts && r->impact[i])) continue;
    nsdae_rows_add(blocks, &T->by.normal, i, scale * r->normal[i], y);
    for (int j = i * nt; j < (i + 1) * nt; j++)
      nsdae_rows_add(blocks, &T->by.tangent, j, scale * r->tangential[j], y);
    add_linear(p, T, i, scale);
  }
  for (int i = 0; i < is->joints; i++) {
    int j = is->joint_number[i];
    if (skip_impacts && p->hit[nsdae_island_of_joint(is, T, i)]) continue;
    nsdae_rows_add(blocks, &T->by.frictional_joint, j, scale * r->frictional_joint_impulse[j], y);
  }
}

void nsdae_problem_no_linear(nsdae_problem *p)
{
  double *linear = p->results->linear;
  for (int a = 0; a < p->count; a++) memset(linear + 3 * p->number[a], 0, 3 * sizeof *linear);
}

void nsdae_problem_add_linear(nsdae_problem *p, const nsdae_terms *T)
{
  for (int a = 0; a < p->count; a++) add_linear(p, T, p->number[a], 1);
}

double nsdae_problem_work(const nsdae_problem *p, double *motors)
{
  const nsdae_contact_islands *is = &p->dispatch.islands;
  const int *joint = is->joint_number;
  *motors = 0;
  for (int i = 0; i < is->joints; i++)
    if (p->system->frictional_joint[joint[i]].position)
      *motors += nsdae_impulses_work(p->results, 0, 0, NULL, 1, joint + i);
  return nsdae_impulses_work(p->results, p->system->dims.nt, p->count, p->number, is->joints,
                             joint) -
         *motors;
}

double nsdae_problem_carried(const nsdae_problem *p, const nsdae_terms *T)
{
  int k = p->closed->count;
  return nsdae_dot(k, p->results->normal, T->w_N) +
         nsdae_dot(k * p->system->dims.nt, p->results->tangential, T->w_T);
}

/* Of the dense island of the first worker, which has room for the description. */
int nsdae_problem_describe(nsdae_problem *p, const nsdae_contacts *dense,
                           const nsdae_single *single, const nsdae_cone_island *l,
                           nsdae_step_friction *friction)
{
  nsdae_contacts *c = &p->dispatch.worker[0].dense.contacts;
  const nsdae_cones *s = &c->cones;
  if (l) {
    *friction = (nsdae_step_friction){l->problem, l->options, l->at.guess, l->at.r, l->at.u};
    return NSDAE_OK;
  }
  if (single) {
    double G[4];
    for (int i = 0; i < single->columns; i++)
      for (int j = 0; j < single->columns; j++) G[i * single->columns + j] = single->G[i][j];
    nsdae_cones_describe_one(&c->cones, single->columns, single->mu, G, single->b, single->x);
  } else if (dense != c || c->active_count == 0 || nsdae_cones_describe(c) < 0) {
    return NSDAE_E_STATE;
  }
  *friction = (nsdae_step_friction){s->problem, s->options, s->guess, s->r, s->u};
  return NSDAE_OK;
}
