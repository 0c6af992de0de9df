#include "state_projection.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "listed.h"
#include "system_impl.h"

enum {
  ROUNDS = 60, /* of Newton's method, and as many more for each contact */
  TERMS = NSDAE_TERM_MASS | NSDAE_TERM_PHI | NSDAE_TERM_JACOBIAN
};

/* Entries of H by blocks. */
static long moved(const nsdae_system *s)
{
  long sum = 0;
  for (int b = 0; b < s->blocks.count; b++)
    sum += (long)nsdae_blocks_size(&s->coordinates, b) * nsdae_blocks_size(&s->blocks, b);
  return sum;
}

void nsdae_units_layout(nsdae_projector *p, nsdae_arena *arena)
{
  int nq = p->tools->system->dims.nq;
  nsdae_units *const units[] = {&p->units, &p->other};
  for (int i = 0; i < 2; i++) {
    units[i]->of = NSDAE_ARENA_INTS(arena, nq);
    units[i]->length = NSDAE_ARENA_DOUBLES(arena, nq);
  }
  for (int i = 0; i < 2; i++) p->units.work[i] = NSDAE_ARENA_DOUBLES(arena, nq);
}

/* Whether contacts are found by id, at each point. */
static int finds_contacts(const nsdae_projector *p)
{
  return p->contacts.any && nsdae_terms_most(p->tools->system) == NSDAE_ANY_NUMBER;
}

static void lay_out_rows(void *object, nsdae_arena *arena)
{
  nsdae_projector *p = object;
  nsdae_projected *c = &p->contacts;
  long most = p->rows + c->room, k = p->tools->system->dims.k;
  nsdae_least_layout(&p->least, p->tools->system, (int)most, p->tools->options->rank_tol, arena);
  c->of_row = NSDAE_ARENA_INTS(arena, most);
  c->closed = NSDAE_ARENA_INTS(arena, k > c->room ? k : c->room);
  c->depth = NSDAE_ARENA_DOUBLES(arena, c->room);
  if (!finds_contacts(p)) return;
  c->id = nsdae_arena_take(arena, c->room, sizeof *c->id);
  c->id_depth = NSDAE_ARENA_DOUBLES(arena, c->room);
}

void nsdae_projector_layout(nsdae_projector *p, nsdae_arena *arena)
{
  const nsdae_dims *d = &p->tools->system->dims;
  p->total = NSDAE_ARENA_DOUBLES(arena, d->nv);
  p->q = NSDAE_ARENA_DOUBLES(arena, d->nq);
  p->v = NSDAE_ARENA_DOUBLES(arena, d->nv);
  p->qdot = NSDAE_ARENA_DOUBLES(arena, d->nq);
  p->H =
      NSDAE_ARENA_DOUBLES(arena, p->tools->system->call.kinematics ? moved(p->tools->system) : 0);
  p->length = NSDAE_ARENA_DOUBLES(arena, d->nq);
  p->start = NSDAE_ARENA_DOUBLES(arena, 3L * d->m);
  if (finds_contacts(p)) return;
  p->contacts.room = p->contacts.any ? d->k : 0;
  lay_out_rows(p, arena);
}

int nsdae_projector_grow(nsdae_projector *p, const nsdae_room *contacts, const nsdae_room *rows)
{
  const nsdae_system *s = p->tools->system;
  size_t m = (size_t)s->dims.m;
  nsdae_room parts = *rows;
  if (!finds_contacts(p)) return NSDAE_OK;
  if (!s->call.constraint_rows)
    parts = (nsdae_room){m * (size_t)s->blocks.count, m * (size_t)s->dims.nv};
  nsdae_projector made = *p;
  made.contacts.arena = (nsdae_arena){0};
  made.contacts.room = (int)contacts->entries;
  made.contacts.rows =
      (nsdae_room){parts.entries + 2 * contacts->entries, parts.values + contacts->values};
  made.least = (nsdae_least){.given = &made.contacts.rows};
  int status = nsdae_ids_grow(&p->contacts.ids, made.contacts.room);
  made.contacts.ids = p->contacts.ids;
  if (status == NSDAE_OK) status = nsdae_arena_build(&made.contacts.arena, lay_out_rows, &made);
  if (status < 0) return status;
  made.least.kkt.sparse = p->least.kkt.sparse; /* its memory */
  nsdae_arena_release(&p->contacts.arena);
  *p = made;
  p->least.given = &p->contacts.rows;
  return NSDAE_OK;
}

void nsdae_projector_release(nsdae_projector *p)
{
  nsdae_least_release(&p->least);
  nsdae_ids_release(&p->contacts.ids);
  nsdae_arena_release(&p->contacts.arena);
}

/* ---- coordinates of unit length */

/* Block b of q and v: its kinematics is evaluated alone, for dq/dt of a block is of v of
 * that block. One of all where no blocks were set. */
typedef struct part {
  int first, nq, nv; /* where its coordinates begin */
  double *H;         /* nq x nv */
} part;

/* The block behind, of one with p->H alone the first; or 0. */
static int next_part(const nsdae_projector *p, part *b, int number)
{
  const nsdae_system *s = p->tools->system;
  if (number >= s->blocks.count) return 0;
  b->H += (size_t)b->nq * (size_t)b->nv;
  b->first = s->coordinates.first[number];
  b->nq = nsdae_blocks_size(&s->coordinates, number);
  b->nv = nsdae_blocks_size(&s->blocks, number);
  return 1;
}

/* H at a point beside q that is nothing special, column j of every block in one call; a callback's
 * code. */
static int read_beside(nsdae_projector *p, double t, const double *q, double away)
{
  const nsdae_system *s = p->tools->system;
  int widest = 0, code = 0;
  for (int i = 0; i < s->dims.nq; i++)
    p->q[i] = q[i] + away * (0.3 + fmod(0.618034 * (i + 1), 1)) * (1 + fabs(q[i]));
  for (int b = 0; b < s->blocks.count; b++)
    if (nsdae_blocks_size(&s->blocks, b) > widest) widest = nsdae_blocks_size(&s->blocks, b);
  for (int j = 0; j < widest && !code; j++) {
    memset(p->v, 0, (size_t)s->dims.nv * sizeof *p->v);
    memset(p->qdot, 0, (size_t)s->dims.nq * sizeof *p->qdot);
    for (int b = 0; b < s->blocks.count; b++)
      if (j < nsdae_blocks_size(&s->blocks, b)) p->v[s->blocks.first[b] + j] = 1;
    code = nsdae_kinematics(s, t, p->q, p->v, p->qdot);
    part b = {.H = p->H};
    for (int i = 0; next_part(p, &b, i); i++)
      if (j < b.nv)
        memcpy(b.H + (size_t)j * (size_t)b.nq, p->qdot + b.first, (size_t)b.nq * sizeof *b.H);
  }
  return code;
}

/* The same nearer where it refuses one so far away; > 0 where it refuses that, too. */
static int read_kinematics(nsdae_projector *p, double t, const double *q, double away)
{
  int code = read_beside(p, t, q, away);
  for (int nearer = 0; nearer < 2 && code > 0; nearer++) code = read_beside(p, t, q, away *= 0.1);
  return code;
}

/* Whether group g at the point q, of the block, keeps its length and has the sizes of a rotation.
 */
static int keeps_length(const part *b, const int *of, const double *q, int g)
{
  int size = 0, movers = 0;
  for (int i = 0; i < b->nq; i++) size += of[i] == g;
  for (int j = 0; j < b->nv; j++) {
    double along = 0, terms = 0;
    for (int i = 0; i < b->nq; i++) {
      if (of[i] != g) continue;
      double term = q[i] * b->H[(size_t)j * (size_t)b->nq + (size_t)i];
      along += term;
      terms += fabs(term);
    }
    movers += terms > 0;
    if (fabs(along) > 64 * DBL_EPSILON * terms) return 0;
  }
  return (size == 4 && movers == 3) || (size == 2 && movers == 1);
}

/* Groups of the block that keep their length here; the others are numbered nq. */
static void keep_here(nsdae_projector *p, const part *b)
{
  int *of = p->units.of + b->first;
  /* of[i]: the first coordinate of the block that is moved together with i. */
  for (int i = 0; i < b->nq; i++) of[i] = i;
  for (int j = 0; j < b->nv; j++) {
    int first = -1;
    for (int i = 0; i < b->nq; i++) {
      if (b->H[(size_t)j * (size_t)b->nq + (size_t)i] == 0) continue;
      if (first < 0) first = of[i];
      int from = of[i] > first ? of[i] : first, to = of[i] > first ? first : of[i];
      for (int l = 0; l < b->nq; l++)
        if (of[l] == from) of[l] = to;
      first = to;
    }
  }
  for (int g = 0; g < b->nq; g++)
    if (!keeps_length(b, of, p->q + b->first, g))
      for (int i = 0; i < b->nq; i++)
        if (of[i] == g) of[i] = b->nq; /* none of them */
}

/* Those that do so here, too, get the numbers that come next; all others -1. */
static void keep_there(nsdae_projector *p, const part *b, int same)
{
  nsdae_units *u = &p->units;
  int *of = u->of + b->first;
  for (int g = 0; g < b->nq; g++) {
    int keeps = same && keeps_length(b, of, p->q + b->first, g);
    for (int i = 0; i < b->nq; i++)
      if (of[i] == g) of[i] = keeps ? -2 - u->count : b->nq;
    u->count += keeps;
  }
  for (int i = 0; i < b->nq; i++) of[i] = of[i] < 0 ? -2 - of[i] : -1;
}

/* length [count]: of the groups of q. */
static void measure_groups(const nsdae_units *units, int nq, const double *q, double *length)
{
  memset(length, 0, (size_t)units->count * sizeof *length);
  for (int i = 0; i < nq; i++)
    if (units->of[i] >= 0) length[units->of[i]] += q[i] * q[i];
  for (int g = 0; g < units->count; g++) length[g] = sqrt(length[g]);
}

/* Groups that keep their length at one point and at another get the numbers 0, 1, ... */
int nsdae_units_find(nsdae_projector *p, double t, const double *q)
{
  int nq = p->tools->system->dims.nq;
  nsdae_units *u = &p->units;
  part b = {.H = p->H};
  u->count = 0;
  for (int i = 0; i < nq; i++) u->of[i] = -1;
  if (nq == p->tools->system->dims.nv) return NSDAE_OK;
  int code = read_kinematics(p, t, q, 0.11);
  if (code < 0) return nsdae_system_callback_status(code, "kinematics", t, p->tools->error);
  if (code > 0) return NSDAE_OK;
  for (int i = 0; next_part(p, &b, i); i++) keep_here(p, &b);
  code = read_kinematics(p, t, q, -0.07);
  b = (part){.H = p->H};
  for (int i = 0; next_part(p, &b, i); i++) keep_there(p, &b, code == 0);
  measure_groups(u, nq, q, u->length);
  return code < 0 ? nsdae_system_callback_status(code, "kinematics", t, p->tools->error) : NSDAE_OK;
}

static void restore_lengths(nsdae_projector *p)
{
  int nq = p->tools->system->dims.nq;
  const nsdae_units *u = &p->units;
  if (u->count > 0) measure_groups(u, nq, p->q, p->length);
  for (int i = 0; i < nq && u->count > 0; i++) {
    int g = u->of[i];
    if (g >= 0 && p->length[g] > 0) p->q[i] *= u->length[g] / p->length[g];
  }
}

int nsdae_units_strayed(nsdae_projector *p, const nsdae_terms *T)
{
  const nsdae_units *u = &p->units;
  if (u->count == 0) return 0;
  measure_groups(u, T->system->dims.nq, T->q, p->length);
  for (int g = 0; g < u->count; g++)
    if (p->length[g] > 2 * u->length[g] || p->length[g] < u->length[g] / 2) return 1;
  return 0;
}

void nsdae_units_restore(nsdae_projector *p, nsdae_terms *T)
{
  memcpy(p->q, T->q, (size_t)T->system->dims.nq * sizeof *p->q);
  memcpy(p->v, T->v, (size_t)T->system->dims.nv * sizeof *p->v);
  restore_lengths(p);
  nsdae_terms_at(T, T->t, p->q, p->v);
}

/* ---- contacts of a list */

/* At a point that has its list: the numbers of those that were kept. */
static int count_missing(nsdae_projected *c, int mark)
{
  int missing = 0;
  for (int i = 0; i < c->kept; i++) {
    int entry = nsdae_ids_find(&c->ids, c->id[i]);
    missing += entry < 0;
    if (entry < 0 || !mark) continue;
    c->closed[entry] = 1;
    c->depth[entry] = c->id_depth[i];
  }
  return missing;
}

/* Contacts of the list at the terms' point, with the rows of their entries. The way of a step is
 * that of its linear part: one that has gone further is looked for within 4, 16 and 64 times
 * that, and is open if it is not listed then. */
static int find_contacts(nsdae_projector *p, nsdae_terms *T)
{
  nsdae_projected *c = &p->contacts;
  const nsdae_contact_list *list = &T->by.list;
  double reach = fmax(c->reach, nsdae_terms_touch(T));
  if (!finds_contacts(p)) return NSDAE_OK;
  for (int further = 0, missing = 1; further < 4 && missing > 0; further++, reach *= 4) {
    int status = nsdae_terms_contacts(T, reach);
    if (status < 0) return status;
    int twice = nsdae_ids_fill(&c->ids, list->count, list->id);
    if (twice >= 0) return nsdae_terms_id_twice(T, list->id[twice]);
    missing = count_missing(c, 0);
  }
  memset(c->closed, 0, (size_t)list->count * sizeof *c->closed);
  memset(c->depth, 0, (size_t)list->count * sizeof *c->depth);
  count_missing(c, 1);
  nsdae_terms_select(T, list->count, NULL);
  return NSDAE_OK;
}

/* Those that take part, for this point again or for the one that is `change` away: within twice the
 * way of the furthest. */
static void keep_contacts(nsdae_projector *p, const nsdae_terms *T, int moving)
{
  nsdae_projected *c = &p->contacts;
  double furthest = 0;
  if (!finds_contacts(p)) return;
  c->kept = 0;
  for (int i = 0; i < T->by.normal.count; i++) {
    if (!c->closed[i]) continue;
    c->id[c->kept] = T->by.list.id[i];
    c->id_depth[c->kept++] = c->depth[i];
    furthest =
        fmax(furthest, nsdae_rows_dot_sizes(&T->system->blocks, &T->by.normal, i, p->least.change));
  }
  c->reach = moving ? nsdae_terms_touch(T) + 2 * furthest : 0;
}

void nsdae_projector_clear(nsdae_projector *p)
{
  nsdae_projected *c = &p->contacts;
  c->kept = 0;
  c->reach = 0;
  memset(c->closed, 0, (size_t)c->room * sizeof *c->closed);
  memset(c->depth, 0, (size_t)c->room * sizeof *c->depth);
}

/* ---- constraints and contacts */

static int count_contacts(const nsdae_projector *p, const nsdae_terms *T)
{
  return p->contacts.any ? T->by.normal.count : 0;
}

/* Rows W_i . d = -c; worst: the largest |c| in units of its rounding, that of the terms it is made
 * of: eps (1 + |W_i|_1 max |x|). */
static int position_rows(nsdae_projector *p, const nsdae_terms *T, double *worst, int *worst_row)
{
  const nsdae_dims *d = &T->system->dims;
  const nsdae_projected *c = &p->contacts;
  double x = nsdae_largest(d->nq, T->q);
  nsdae_least_start(&p->least);
  *worst = 0;
  for (int i = 0; i < d->m + count_contacts(p, T); i++) {
    int contact = i - d->m;
    if (contact >= 0 && !c->closed[contact]) continue;
    c->of_row[p->least.rows] = contact >= 0 ? contact : -1;
    const nsdae_rows *rows = contact < 0 ? &T->by.jacobian : &T->by.normal;
    double missing = contact < 0 ? T->constraint.phi[i] : T->gap[contact] - c->depth[contact];
    int row = contact < 0 ? i : contact;
    nsdae_least_append(&p->least, rows, row, missing);
    double sum = nsdae_rows_sum(&p->tools->system->blocks, rows, row);
    double off = fabs(missing) / (DBL_EPSILON * (1 + sum * x));
    if (contact < 0 && c->alone) off = 0;
    if (off > *worst || p->least.rows == 1) *worst_row = p->least.rows - 1;
    *worst = fmax(*worst, off);
  }
  return p->least.rows;
}

/* The change d of the rows. With least the change since the beginning, total + d, is the least, and
 * l is what it takes: M (total + d) + J^T l = 0. */
static int solve_projection(nsdae_projector *p, const nsdae_terms *T, int least)
{
  int n = T->system->dims.nv;
  double *change = p->least.change;
  const nsdae_sim_options *o = p->tools->options;
  int worst;
  if (T->system->dims.m > 0 && o->redundant == NSDAE_REDUNDANT_LEAST_NORM)
    p->least.kkt.rank_tol = nsdae_least_sine(o->rank_tol, nsdae_least_drift(T, &worst));
  if (least) nsdae_blocks_add_product(&T->system->blocks, T->M, p->total, change);
  for (int j = 0; j < n; j++) change[j] = -change[j];
  return nsdae_least_solve(&p->least, T);
}

/* The contact that overlaps most, by more than rounding, takes part from here on: one at a time,
 * for what puts it right may put others right. Returns whether there is one. */
static int close_deepest(nsdae_projector *p, const nsdae_terms *T)
{
  int deepest = -1;
  double gap = -nsdae_terms_touch(T);
  for (int i = 0; i < count_contacts(p, T); i++) {
    if (p->contacts.closed[i] || T->gap[i] >= gap) continue;
    gap = T->gap[i];
    deepest = i;
  }
  if (deepest >= 0) p->contacts.closed[deepest] = 1;
  return deepest >= 0;
}

static int move(nsdae_projector *p, nsdae_terms *T)
{
  int nq = T->system->dims.nq;
  int status = nsdae_kinematics_at(T, p->least.change, p->qdot);
  if (status < 0) return status;
  for (int i = 0; i < nq; i++) p->q[i] = T->q[i] + p->qdot[i];
  for (int j = 0; j < T->system->dims.nv; j++) p->total[j] += p->least.change[j];
  memcpy(p->v, T->v, (size_t)T->system->dims.nv * sizeof *p->v);
  restore_lengths(p);
  nsdae_terms_at(T, T->t, p->q, p->v);
  return NSDAE_OK;
}

static int not_converged(const nsdae_projector *p, const nsdae_terms *T, int row)
{
  char called[NSDAE_CALLED_SIZE];
  int contact = p->contacts.of_row[row];
  int kind = contact < 0 ? NSDAE_NAME_CONSTRAINT : NSDAE_NAME_CONTACT;
  int i = contact < 0 ? row : contact; /* constraints come first, all of them */
  nsdae_error_set(T->error, NSDAE_E_CONVERGENCE, "nsdae_sim", "projection",
                  "no state near this one satisfies all constraints at t = %g: %s is violated "
                  "by %.3g; check for contradictory constraints",
                  nsdae_terms_time(T), nsdae_terms_called(T, kind, i, called),
                  contact < 0 ? T->constraint.phi[i] : T->gap[i] - p->contacts.depth[i]);
  return nsdae_error_at(T->error, NSDAE_E_CONVERGENCE, nsdae_system_index(T->system, kind, i),
                        nsdae_terms_time(T));
}

/* Whether the rows are satisfied: to their rounding, a few eps of their terms; where constants that
 * are not seen in those make it more, Newton's method stands still, and 10^4 times as much is as
 * near as numbers come. A least change has also come to rest: then its square is nothing. */
static int converged(const nsdae_projector *p, const nsdae_terms *T, int least, double worst,
                     double before)
{
  const double rounding = 16, still = 16e4, rest = 1e-9;
  double moved = nsdae_largest(T->system->dims.nv, p->least.change),
         size = 1 + nsdae_largest(T->system->dims.nq, T->q);
  if (least && moved > rest * size) return 0;
  return worst <= rounding || (worst <= still && worst > before / 2);
}

/* Whether rows that count as dependent are the only ones that contradict each other: up to ten
 * times the sine at which they do, as axes that are off by that are once the mechanism has moved.
 */
static int contradict_little(const nsdae_projector *p, const nsdae_terms *T)
{
  const nsdae_least *l = &p->least;
  double sine = nsdae_least_sine(p->tools->options->rank_tol, 0);
  int worst;
  return l->rows == T->system->dims.m && l->kkt.rank < l->rows &&
         nsdae_least_drift(T, &worst) <= 10 * sine;
}

/* Newton's method at first aims at the least change; far from the constraints that may not come to
 * rest, and then each step is the least one. */
int nsdae_project_positions(nsdae_projector *p, nsdae_terms *T, int penetrating)
{
  unsigned terms = TERMS;
  double worst = INFINITY, before = INFINITY;
  int row = 0, rounds = ROUNDS;
  if (p->contacts.any) terms |= NSDAE_TERM_GAP | NSDAE_TERM_NORMAL;
  memset(p->least.change, 0, (size_t)T->system->dims.nv * sizeof *p->least.change);
  memset(p->total, 0, (size_t)T->system->dims.nv * sizeof *p->total);
  int status = p->units.count > 0 ? move(p, T) : NSDAE_OK;
  for (int round = 0; round < rounds && status == NSDAE_OK; round++) {
    status = nsdae_terms_need(T, terms);
    if (status == NSDAE_OK) status = find_contacts(p, T);
    if (status < 0) return status;
    int most = ROUNDS * (1 + count_contacts(p, T));
    if (penetrating && most > rounds) rounds = most;
    int least = penetrating && round < rounds / 2;
    int rows = position_rows(p, T, &worst, &row);
    int still = !least && worst > before / 2 && contradict_little(p, T);
    if (rows == 0 || still || converged(p, T, least, worst, before)) {
      if (!penetrating || !close_deepest(p, T)) return NSDAE_OK;
      before = INFINITY;
      rows = position_rows(p, T, &worst, &row);
    }
    before = worst;
    status = solve_projection(p, T, least);
    int opened = 0; /* contacts that would pull */
    for (int i = 0; i < rows && status == NSDAE_OK; i++) {
      if (p->contacts.of_row[i] < 0 || !(p->least.c[i] > 0)) continue;
      p->contacts.closed[p->contacts.of_row[i]] = 0;
      opened++;
    }
    keep_contacts(p, T, opened == 0);
    if (status == NSDAE_OK && opened == 0) status = move(p, T);
  }
  return status < 0 ? status : not_converged(p, T, row);
}

int nsdae_project_change(nsdae_projector *p, nsdae_terms *T, const nsdae_terms *by,
                         const double *change)
{
  const nsdae_dims *d = &T->system->dims;
  int status = NSDAE_OK;
  nsdae_least_start(&p->least);
  for (int i = 0; i < d->m; i++) {
    double moved = nsdae_rows_dot(&T->system->blocks, &by->by.jacobian, i, change);
    nsdae_least_append(&p->least, &by->by.jacobian, i, moved);
  }
  if (d->m > 0) status = nsdae_least_solve(&p->least, by);
  for (int j = 0; j < d->nv; j++) p->least.change[j] += change[j];
  return status < 0 ? status : move(p, T);
}

int nsdae_project_velocities(nsdae_projector *p, nsdae_terms *T)
{
  const nsdae_dims *d = &T->system->dims;
  if (d->m == 0) return NSDAE_OK;
  int status = nsdae_terms_need(T, TERMS | NSDAE_TERM_PHI_T);
  if (status < 0) return status;
  nsdae_least_start(&p->least);
  for (int i = 0; i < d->m; i++)
    nsdae_least_append(&p->least, &T->by.jacobian, i, nsdae_terms_constraint_rate(T, i, T->v));
  status = solve_projection(p, T, 0);
  if (status < 0) return status;
  for (int j = 0; j < d->nv; j++) p->v[j] = T->v[j] + p->least.change[j];
  nsdae_terms_set_velocity(T, p->v);
  return NSDAE_OK;
}
