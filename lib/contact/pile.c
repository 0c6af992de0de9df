#include "pile.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include <nsdae/sim.h>

#include "errors.h"
#include "grow.h"
#include "listed.h"

/* A velocity below the tolerance of its terms is none; where few digits are asked for, below this.
 */
static const double least_digits = 1e-9;

void nsdae_pile_layout(nsdae_pile *c, const nsdae_system *system, nsdae_arena *arena)
{
  const nsdae_blocks *blocks = &system->blocks;
  size_t most = 0;
  for (int b = 0; b < blocks->count; b++) {
    size_t square = blocks->square[b + 1] - blocks->square[b];
    if (square > most) most = square;
  }
  c->number = NSDAE_ARENA_INTS(arena, blocks->count);
  c->member = NSDAE_ARENA_INTS(arena, blocks->count);
  c->size = NSDAE_ARENA_INTS(arena, blocks->count);
  c->M = NSDAE_ARENA_DOUBLES(arena, blocks->square[blocks->count]);
  c->f = NSDAE_ARENA_DOUBLES(arena, system->dims.nv);
  c->L = NSDAE_ARENA_DOUBLES(arena, most);
  c->lever = NSDAE_ARENA_DOUBLES(arena, system->dims.nv);
}

int nsdae_pile_grow(nsdae_pile *c, const nsdae_system *system, const nsdae_room *contacts,
                    const nsdae_room *rows)
{
  size_t m = (size_t)system->dims.m, columns = (size_t)(1 + system->dims.nt);
  size_t items = contacts->entries + m;
  const nsdae_grown by_item[] = {NSDAE_GROWN(c->item, 1),        NSDAE_GROWN(c->rows, 1),
                                 NSDAE_GROWN(c->mu, 1),          NSDAE_GROWN(c->w, columns),
                                 NSDAE_GROWN(c->r, columns),     NSDAE_GROWN(c->u, columns),
                                 NSDAE_GROWN(c->guess, columns), NSDAE_GROWN(c->first, 1)};
  const nsdae_grown by_part[] = {NSDAE_GROWN(c->block, 1)};
  const nsdae_grown by_value[] = {NSDAE_GROWN(c->value, 1)};
  int status = c->solver ? NSDAE_OK : nsdae_friction_create(&c->solver);
  if (status == NSDAE_OK) status = nsdae_grow(by_item, sizeof by_item / sizeof *by_item, items + 1);
  if (status == NSDAE_OK) status = nsdae_grow(by_part, 1, 2 * contacts->entries + rows->entries);
  return status < 0 ? status : nsdae_grow(by_value, 1, contacts->values + rows->values);
}

void nsdae_pile_release(nsdae_pile *c)
{
  const nsdae_grown all[] = {NSDAE_GROWN(c->item, 1),  NSDAE_GROWN(c->rows, 1),
                             NSDAE_GROWN(c->mu, 1),    NSDAE_GROWN(c->w, 1),
                             NSDAE_GROWN(c->r, 1),     NSDAE_GROWN(c->u, 1),
                             NSDAE_GROWN(c->guess, 1), NSDAE_GROWN(c->first, 1),
                             NSDAE_GROWN(c->block, 1), NSDAE_GROWN(c->value, 1)};
  nsdae_grown_release(all, sizeof all / sizeof *all);
  nsdae_friction_destroy(&c->solver);
}

void nsdae_pile_begin(nsdae_pile *c)
{
  c->problem = (nsdae_friction_problem){.form = NSDAE_FRICTION_GLOBAL};
  c->items = c->m = c->parts = 0;
  c->values = c->squares = 0;
  c->first[0] = 0;
}

/* Blocks of an island that has one in the problem are all there. */
static void add_blocks(nsdae_pile *c, const nsdae_whole *w, int island)
{
  const nsdae_blocks *blocks = &w->system->blocks;
  const nsdae_members *members = &w->islands->block;
  int at = 0; /* of f */
  for (int i = 0; i < c->problem.blocks; i++) at += c->size[i];
  for (int i = members->first[island]; i < members->first[island + 1]; i++) {
    int b = members->of[i], n = nsdae_blocks_size(blocks, b), number = c->problem.blocks++;
    size_t square = (size_t)n * (size_t)n;
    c->number[b] = number;
    c->member[number] = b;
    c->size[number] = n;
    memcpy(c->M + c->squares, w->M + blocks->square[b], square * sizeof *c->M);
    memcpy(c->f + at, w->r + blocks->first[b], (size_t)n * sizeof *c->f);
    c->squares += square;
    at += n;
  }
}

/* Part p of row i, of so many columns one behind the other. */
static void add_part(nsdae_pile *c, const nsdae_whole *w, const nsdae_rows *rows, int p,
                     int columns)
{
  int b = rows->block[p];
  size_t count = (size_t)nsdae_blocks_size(&w->system->blocks, b) * (size_t)columns;
  c->block[c->parts++] = c->number[b];
  memcpy(c->value + c->values, rows->value + rows->at[p], count * sizeof *c->value);
  c->values += count;
}

/* Part of row i whose block has the least number above last. */
static int next_part(const nsdae_pile *c, const nsdae_rows *rows, int i, int last)
{
  int next = -1;
  for (int p = rows->first[i]; p < rows->first[i + 1]; p++) {
    int number = c->number[rows->block[p]];
    if (number > last && (next < 0 || number < c->number[rows->block[next]])) next = p;
  }
  return next;
}

/* Its parts in the order of their blocks, as files have them: sums then round alike. */
static void add_item(nsdae_pile *c, const nsdae_whole *w, const nsdae_rows *rows, int i,
                     int columns)
{
  for (int p = next_part(c, rows, i, -1); p >= 0;
       p = next_part(c, rows, i, c->number[rows->block[p]]))
    add_part(c, w, rows, p, columns);
  c->item[c->items++] = i;
  c->first[c->items] = c->parts;
  c->m += columns;
}

/* The directions of a contact are one behind the other in its list. */
static void add_contact(nsdae_pile *c, const nsdae_whole *w, int a)
{
  const nsdae_coefficients *law = &w->law[a];
  const nsdae_terms *T = w->terms;
  const nsdae_impulses *r = w->results;
  int nt = w->system->dims.nt, columns = law->mu > 0 ? 1 + nt : 1;
  c->rows[c->problem.contacts] = columns;
  c->mu[c->problem.contacts++] = law->mu;
  c->w[c->m] = T->w_N[a] + law->e_n * r->before[a];
  c->r[c->m] = r->normal[a];
  for (int d = 1; d < columns; d++) {
    int j = a * nt + d - 1;
    c->w[c->m + d] = T->w_T[j] + law->e_t * r->before_t[j];
    c->r[c->m + d] = r->tangential[j];
  }
  add_item(c, w, &T->by.normal, a, columns);
}

void nsdae_pile_add_contacts(nsdae_pile *c, const nsdae_whole *w, int island)
{
  const nsdae_members *members = &w->islands->contact;
  add_blocks(c, w, island);
  for (int i = members->first[island]; i < members->first[island + 1]; i++)
    add_contact(c, w, members->of[i]);
}

void nsdae_pile_add_rows(nsdae_pile *c, const nsdae_whole *w, int island)
{
  const nsdae_members *members = &w->islands->row;
  for (int i = members->first[island]; i < members->first[island + 1]; i++) {
    int row = members->of[i];
    c->w[c->m] = -w->lambda[row];
    c->r[c->m] = 0;
    c->problem.bilateral++;
    add_item(c, w, &w->terms->by.jacobian, row, 1);
  }
}

static int unsolved(const nsdae_pile *c, const nsdae_whole *w, int status, nsdae_error *error)
{
  long id = c->problem.contacts > 0 ? w->closed->id[c->item[0]] : -1;
  nsdae_error_set(error, status, "nsdae_contacts", "",
                  "contact problem of %d contacts (first id %ld) and %d constraints at t = %.17g: "
                  "%s, residual %.3g above %.3g; a smaller dt or less friction may help",
                  c->problem.contacts, id, c->problem.bilateral, w->terms->t,
                  nsdae_status_message(status), c->info.residual, c->options.tol);
  error->time = w->terms->t;
  return status;
}

/* Of contact i of the problem, whose velocities after are known. */
static int mode_of(const nsdae_pile *c, const nsdae_whole *w, int i, int row)
{
  const nsdae_impulses *r = w->results;
  int a = c->item[i], nt = w->system->dims.nt;
  double slip = 0;
  if (!(c->r[row] > 0)) return NSDAE_MODE_OPEN;
  for (int j = a * nt; j < (a + 1) * nt; j++)
    slip = hypot(slip, r->after_t[j] + w->law[a].e_t * r->before_t[j]);
  return c->rows[i] > 1 && !(slip > c->slow) ? NSDAE_MODE_STICK : NSDAE_MODE_SLIDE;
}

/* Momentum f + H r in f, and in u (whose place is free then) nothing; sizes of its terms in size
 * of the whole. */
static void add_impulses(nsdae_pile *c, const nsdae_whole *w)
{
  const nsdae_blocks *blocks = &w->system->blocks;
  size_t at = 0;
  for (int i = 0, row = 0; i < c->items; i++) {
    int columns = i < c->problem.contacts ? c->rows[i] : 1;
    for (int e = c->first[i]; e < c->first[i + 1]; e++) {
      int b = c->member[c->block[e]], n = nsdae_blocks_size(blocks, b);
      double *v = w->v + blocks->first[b], *size = w->size + blocks->first[b];
      for (int d = 0; d < columns; d++, at += (size_t)n)
        for (int j = 0; j < n; j++) {
          double term = c->value[at + (size_t)j] * c->r[row + d];
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
static int solve_masses(nsdae_pile *c, const nsdae_whole *w)
{
  nsdae_block_factor factor = {.L = c->L};
  for (int i = 0; i < c->problem.blocks; i++) {
    int b = c->member[i];
    if (nsdae_blocks_factor(&w->system->blocks, b, w->M, &factor) != 0) return NSDAE_E_MASS;
    nsdae_blocks_solve(&factor, w->v + w->system->blocks.first[b]);
  }
  return NSDAE_OK;
}

/* v := f, and the sizes of its terms. */
static void begin_velocities(const nsdae_pile *c, const nsdae_whole *w)
{
  const double *f = c->f;
  for (int i = 0; i < c->problem.blocks; f += c->size[i++]) {
    int at = w->system->blocks.first[c->member[i]];
    for (int j = 0; j < c->size[i]; j++) {
      w->v[at + j] = f[j];
      w->size[at + j] = fabs(f[j]);
    }
  }
}

/* The largest velocity of an item without impulses, |H^T v + w|, for which all are scaled; and the
 * largest entry of H along each velocity. */
static double speed_without(nsdae_pile *c, const nsdae_whole *w)
{
  const nsdae_blocks *blocks = &w->system->blocks;
  double fastest = 0;
  size_t at = 0;
  memset(c->lever, 0, (size_t)w->system->dims.nv * sizeof *c->lever);
  for (int i = 0, row = 0; i < c->items; i++) {
    int columns = i < c->problem.contacts ? c->rows[i] : 1;
    double u[3] = {0};
    for (int d = 0; d < columns; d++) u[d] = c->w[row + d];
    for (int e = c->first[i]; e < c->first[i + 1]; e++) {
      int b = c->member[c->block[e]], n = nsdae_blocks_size(blocks, b), first = blocks->first[b];
      for (int d = 0; d < columns; d++, at += (size_t)n) {
        u[d] += nsdae_dot(n, c->value + at, w->v + first);
        for (int j = 0; j < n; j++)
          c->lever[first + j] = fmax(c->lever[first + j], fabs(c->value[at + (size_t)j]));
      }
    }
    for (int d = 0; d < columns; d++) fastest = fmax(fastest, fabs(u[d]));
    row += columns;
  }
  return fastest;
}

/* v = M^-1 (f + H r). An entry that moves no item by more than the tolerance of the problem is
 * zero: what stands, stands. */
static int velocities(nsdae_pile *c, const nsdae_whole *w)
{
  const nsdae_blocks *blocks = &w->system->blocks;
  const double *M = c->M;
  begin_velocities(c, w);
  int status = solve_masses(c, w);
  double speed = speed_without(c, w), slow = fmin(c->options.tol, least_digits) * speed;
  c->slow = c->options.tol * speed;
  begin_velocities(c, w);
  add_impulses(c, w);
  if (status == NSDAE_OK) status = solve_masses(c, w);
  for (int i = 0; i < c->problem.blocks && status == NSDAE_OK; i++) {
    int at = blocks->first[c->member[i]], n = c->size[i];
    sizes_of_velocity(M, n, w->size + at);
    for (int j = at; j < at + n; j++)
      if (fabs(w->v[j]) * c->lever[j] <= slow || fabs(w->v[j]) <= 32 * DBL_EPSILON * w->size[j])
        w->v[j] = 0;
    M += (size_t)n * (size_t)n;
  }
  return status;
}

static void scatter(const nsdae_pile *c, const nsdae_whole *w)
{
  nsdae_impulses *to = w->results;
  const nsdae_terms *T = w->terms;
  int nt = w->system->dims.nt, row = 0;
  for (int i = 0; i < c->problem.contacts; row += c->rows[i++]) {
    int a = c->item[i];
    to->normal[a] = c->r[row];
    to->after[a] = nsdae_terms_normal_rate(T, a, w->v);
    for (int d = 1; d <= nt; d++) {
      int j = a * nt + d - 1;
      to->tangential[j] = d < c->rows[i] ? c->r[row + d] : 0;
      to->after_t[j] = nsdae_terms_tangent_rate(T, j, w->v);
    }
    to->mode[a] = mode_of(c, w, i, row);
  }
  for (int i = c->problem.contacts; i < c->items; i++) w->lambda[c->item[i]] = -c->r[row++];
}

/* Solves it, and keeps with what and from where. */
static int solve_with(nsdae_pile *c, const nsdae_friction_options *options)
{
  c->last = *options;
  memcpy(c->guess, c->r, (size_t)c->m * sizeof *c->guess);
  return nsdae_friction_solver_solve(c->solver, &c->problem, options, c->r, c->u, &c->info);
}

/* From the best point on: a solution of fewer digits, refined as far as it goes. */
static int polish(nsdae_pile *c)
{
  nsdae_friction_options loose = c->options;
  loose.tol = fmin(1e4 * c->options.tol, 1e-5);
  loose.refine = 30;
  int status = solve_with(c, &loose);
  return status == NSDAE_OK && !(c->info.residual <= c->options.tol) ? NSDAE_E_LCP : status;
}

int nsdae_pile_solve(nsdae_pile *c, const nsdae_whole *w, double tol, nsdae_error *error)
{
  c->info = (nsdae_friction_info){.residual = 0};
  if (c->items == 0) return NSDAE_OK;
  nsdae_friction_problem *p = &c->problem;
  p->rows = c->rows, p->mu = c->mu, p->w = c->w;
  p->size = c->size, p->M = c->M, p->f = c->f;
  p->first = c->first, p->block = c->block, p->value = c->value;
  nsdae_friction_options_default(&c->options);
  c->options.tol = tol;
  int status = solve_with(c, &c->options);
  if (status == NSDAE_E_LCP) status = polish(c);
  if (status < 0) return unsolved(c, w, status, error);
  status = velocities(c, w);
  if (status == NSDAE_OK) scatter(c, w);
  return status;
}
