#include "terms.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "listed.h"

void nsdae_terms_layout_rows(nsdae_rows *rows, const nsdae_blocks *blocks, long count, long begin,
                             long stride, nsdae_arena *arena)
{
  *rows = (nsdae_rows){.count = (int)count, .stride = (size_t)stride};
  rows->value = NSDAE_ARENA_DOUBLES(arena, count * blocks->first[blocks->count]);
  rows->first = NSDAE_ARENA_INTS(arena, count + 1);
  rows->block = NSDAE_ARENA_INTS(arena, count * blocks->count);
  rows->at = nsdae_arena_take(arena, count * blocks->count, sizeof *rows->at);
  if (!rows->first) return; /* measuring */
  for (long i = 0; i < count && blocks->count == 1; i++) {
    rows->first[i + 1] = (int)i + 1;
    rows->at[i] = (size_t)(i * begin);
  }
}

/* ---- rows of an array over several blocks */

/* Writes zeros, as a callback finds them: parts of before are where anything is. */
static void clear_parts(const nsdae_blocks *blocks, nsdae_rows *rows)
{
  for (int p = 0; p < rows->first[rows->count]; p++)
    for (int j = 0; j < nsdae_blocks_size(blocks, rows->block[p]); j++)
      rows->value[rows->at[p] + (size_t)j * rows->stride] = 0;
}

/* Whether these n entries from `at` on are zero: the second is faster, and sure of one sign. */
static int are_zero(const nsdae_rows *rows, size_t at, int n)
{
  int i = 0;
  while (i < n && rows->value[at + (size_t)i * rows->stride] == 0) i++;
  return i == n;
}

static int surely_zero(const double *a, size_t n)
{
  return n == 0 || (a[0] == 0 && memcmp(a, a + 1, (n - 1) * sizeof *a) == 0);
}

/* Whether each row has the parts of before, as mostly: between them memcmp is faster. */
static int same_parts(const nsdae_blocks *blocks, const nsdae_rows *rows, size_t begin)
{
  if (rows->stride != 1) return 0;
  for (int i = 0; i < rows->count; i++) {
    size_t done = (size_t)i * begin, end = done + (size_t)blocks->first[blocks->count];
    for (int p = rows->first[i]; p < rows->first[i + 1]; p++) {
      int n = nsdae_blocks_size(blocks, rows->block[p]);
      if (!surely_zero(rows->value + done, rows->at[p] - done)) return 0;
      if (are_zero(rows, rows->at[p], n)) return 0;
      done = rows->at[p] + (size_t)n;
    }
    if (!surely_zero(rows->value + done, end - done)) return 0;
  }
  return 1;
}

/* The parts of the rows: each block in which a row is not zero. */
static void find_parts(const nsdae_blocks *blocks, nsdae_rows *rows, size_t begin)
{
  int part = 0;
  if (same_parts(blocks, rows, begin)) return;
  for (int i = 0; i < rows->count; i++) {
    for (int b = 0; b < blocks->count; b++) {
      size_t at = (size_t)i * begin + (size_t)blocks->first[b] * rows->stride;
      if (are_zero(rows, at, nsdae_blocks_size(blocks, b))) continue;
      rows->block[part] = b;
      rows->at[part++] = at;
    }
    rows->first[i + 1] = part;
  }
}

static int parts_finite(const nsdae_blocks *blocks, const nsdae_rows *rows)
{
  double sum = 0;
  for (int p = 0; p < rows->first[rows->count]; p++)
    for (int j = 0; j < nsdae_blocks_size(blocks, rows->block[p]); j++)
      sum += 0 * rows->value[rows->at[p] + (size_t)j * rows->stride];
  return sum == 0;
}

/* ---- memory */

static void lay_out_rows(const nsdae_system *s, nsdae_row_list *list, int kind, nsdae_rows *rows,
                         nsdae_arena *arena)
{
  list->system = s;
  list->blocks = &s->blocks;
  list->kind = kind;
  list->rows = rows;
  rows->count = nsdae_system_count(s, kind);
  rows->stride = 1;
  rows->first = NSDAE_ARENA_INTS(arena, rows->count + 1L);
}

/* Rows of which each has at most two parts, in a list. */
static void lay_out_slot_rows(nsdae_rows *rows, long count, nsdae_arena *arena)
{
  *rows = (nsdae_rows){.count = (int)count, .stride = 1};
  rows->first = NSDAE_ARENA_INTS(arena, count + 1);
  rows->block = NSDAE_ARENA_INTS(arena, 2 * count);
  rows->at = nsdae_arena_take(arena, 2 * count, sizeof *rows->at);
}

static void lay_out_contacts(nsdae_terms *terms, nsdae_arena *arena)
{
  const nsdae_system *s = terms->system;
  long n = s->dims.nv, k = s->dims.k, nt = s->dims.nt;
  nsdae_arena_doubles(arena, k, (double **[]){&terms->gap, &terms->w_N, &terms->omega.N, NULL});
  nsdae_arena_doubles(arena, k * nt, (double **[]){&terms->w_T, &terms->omega.T, NULL});
  if (s->tracked) {
    lay_out_slot_rows(&terms->by.normal, k, arena);
    lay_out_slot_rows(&terms->by.tangent, k * nt, arena);
    terms->by.place = NSDAE_ARENA_INTS(arena, k);
    return;
  }
  nsdae_terms_layout_rows(&terms->by.normal, &s->blocks, k, n, 1, arena);
  nsdae_terms_layout_rows(&terms->by.tangent, &s->blocks, k * nt, n, 1, arena);
}

static unsigned absent(const nsdae_dims *d)
{
  unsigned of_constraints =
      NSDAE_TERM_PHI | NSDAE_TERM_JACOBIAN | NSDAE_TERM_PHI_T | NSDAE_TERM_OMEGA;
  unsigned of_contacts = NSDAE_TERM_GAP | NSDAE_TERM_NORMAL | NSDAE_TERM_TANGENT | NSDAE_TERM_BIAS;
  return (d->m == 0 ? of_constraints : 0u) | (d->k == 0 ? of_contacts : 0u) |
         (d->f == 0 ? (unsigned)NSDAE_TERM_SLIDE | NSDAE_TERM_BOUND : 0u) |
         (d->k + d->f == 0 ? (unsigned)NSDAE_TERM_ACCELERATION : 0u);
}

void nsdae_terms_layout(nsdae_terms *terms, nsdae_arena *arena)
{
  const nsdae_dims *dims = &terms->system->dims;
  const nsdae_blocks *blocks = &terms->system->blocks;
  long n = dims->nv, m = dims->m;
  terms->by.list.blocks = blocks;
  terms->by.list.nt = dims->nt;
  terms->by.normal.stride = terms->by.tangent.stride = 1;
  terms->absent = absent(dims);
  terms->q = NSDAE_ARENA_DOUBLES(arena, dims->nq);
  nsdae_arena_doubles(arena, n, (double **[]){&terms->v, &terms->F, &terms->by.work, NULL});
  terms->M = NSDAE_ARENA_DOUBLES(arena, blocks->square[blocks->count]);
  nsdae_arena_doubles(arena, m,
                      (double **[]){&terms->constraint.phi, &terms->constraint.phi_t,
                                    &terms->constraint.omega, NULL});
  if (terms->system->call.constraint_rows)
    lay_out_rows(terms->system, &terms->by.rows, NSDAE_NAME_CONSTRAINT, &terms->by.jacobian, arena);
  else
    nsdae_terms_layout_rows(&terms->by.jacobian, blocks, m, 1, m, arena);
  if (!terms->system->by_list) lay_out_contacts(terms, arena); /* else they grow with the list */
  if (terms->system->call.joint_friction_rows)
    lay_out_rows(terms->system, &terms->by.joint_rows, NSDAE_NAME_FRICTIONAL_JOINT,
                 &terms->by.frictional_joint, arena);
  else
    nsdae_terms_layout_rows(&terms->by.frictional_joint, blocks, dims->f, n, 1, arena);
  terms->frictional_joint.w = NSDAE_ARENA_DOUBLES(arena, dims->f);
  terms->frictional_joint.omega = NSDAE_ARENA_DOUBLES(arena, dims->f);
  terms->frictional_joint.bound = NSDAE_ARENA_DOUBLES(arena, dims->f);
}

void nsdae_terms_at(nsdae_terms *terms, double t, const double *q, const double *v)
{
  const nsdae_dims *dims = &terms->system->dims;
  terms->t = t;
  memcpy(terms->q, q, (size_t)dims->nq * sizeof *q);
  memcpy(terms->v, v, (size_t)dims->nv * sizeof *v);
  nsdae_terms_forget(terms);
}

void nsdae_terms_set_velocity(nsdae_terms *terms, const double *v)
{
  memcpy(terms->v, v, (size_t)terms->system->dims.nv * sizeof *v);
  terms->have &=
      ~(unsigned)(NSDAE_TERM_FORCE | NSDAE_TERM_OMEGA | NSDAE_TERM_ACCELERATION | NSDAE_TERM_BOUND);
  if (terms->system->tracked) terms->have &= ~(unsigned)NSDAE_TERM_CONTACTS; /* with omega */
  terms->have |= terms->absent;
}

static inline void zero(double *a, long count)
{
  if (count > 4)
    memset(a, 0, (size_t)count * sizeof *a);
  else
    while (count > 0) a[--count] = 0;
}

/* The outcome of a callback on its output: the term is there, or what is wrong with it. */
static inline int outcome(nsdae_terms *T, unsigned term, int code, const char *callback,
                          const double *a, int rows, int columns)
{
  if (code || !nsdae_all_finite((size_t)rows * (size_t)columns, a))
    return nsdae_terms_outcome(T, code, callback, a, rows, columns);
  T->have |= term;
  return NSDAE_OK;
}

/* Zeros for the callback of rows of an array. */
static inline void clear_rows(const nsdae_terms *T, nsdae_rows *of)
{
  if (T->system->blocks.count > 1)
    clear_parts(&T->system->blocks, of);
  else
    zero(of->value, (long)of->count * T->system->dims.nv);
}

/* Outcome of rows of an array [rows x columns], begin apart. */
static int parts_outcome(nsdae_terms *T, unsigned term, int code, const char *callback,
                         nsdae_rows *of, int rows, int columns, int begin)
{
  const nsdae_blocks *blocks = &T->system->blocks;
  find_parts(blocks, of, (size_t)begin);
  if (code || !parts_finite(blocks, of))
    return nsdae_terms_outcome(T, code, callback, of->value, rows, columns);
  T->have |= term;
  return NSDAE_OK;
}

static inline int rows_outcome(nsdae_terms *T, unsigned term, int code, const char *callback,
                               nsdae_rows *of, int rows, int columns)
{
  if (T->system->blocks.count > 1)
    return parts_outcome(T, term, code, callback, of, rows, columns, of->stride == 1 ? rows : 1);
  return outcome(T, term, code, callback, of->value, rows, columns);
}

/* The callback that failed, of differences of one. */
static const char *differenced(const nsdae_terms *T, int code, const char *callback)
{
  return code && T->differences->failed ? T->differences->failed : callback;
}

/* Of what is no dense output: the term is there, unless it failed. */
static int there(nsdae_terms *T, unsigned term, int status)
{
  if (status == NSDAE_OK) T->have |= term;
  return status;
}

static int mass(nsdae_terms *T)
{
  const nsdae_system *s = T->system;
  int n = s->dims.nv;
  if (s->by_blocks) return there(T, NSDAE_TERM_MASS, nsdae_terms_mass_blocks(T));
  zero(T->M, (long)n * n);
  T->evals->mass++;
  return outcome(T, NSDAE_TERM_MASS, s->call.mass(nsdae_terms_time(T), T->q, T->M, n, s->user),
                 "mass", T->M, n, n);
}

static int force(nsdae_terms *T)
{
  const nsdae_system *s = T->system;
  zero(T->F, s->dims.nv);
  T->evals->force++;
  return outcome(T, NSDAE_TERM_FORCE, s->call.force(nsdae_terms_time(T), T->q, T->v, T->F, s->user),
                 "force", T->F, s->dims.nv, 1);
}

/* phi or the gaps: count values at (t, q). */
static int values_at(nsdae_terms *T, unsigned term, nsdae_position_fn call, const char *callback,
                     double *out, int count)
{
  zero(out, count);
  return outcome(T, term, call(nsdae_terms_time(T), T->q, out, T->system->user), callback, out,
                 count, 1);
}

/* Phi_q, W_N or W_T: rows of an array by their callback, or by differences of the values, in the
 * rows (0) or the columns (1) of the array; by neither they are zero. */
static int rows_at(nsdae_terms *T, unsigned term, nsdae_rows *of, nsdae_gap_normal_fn call,
                   const char *callback, nsdae_position_fn values, const char *of_values,
                   int columns)
{
  int n = T->system->dims.nv, ld = columns ? n : of->count, code = 0;
  double t = nsdae_terms_time(T);
  clear_rows(T, of);
  if (call) {
    code = call(t, T->q, of->value, ld, T->system->user);
  } else if (values) {
    code = nsdae_differences_velocity(T->differences, values, of->count, t, T->q, of->value, ld,
                                      columns);
    callback = differenced(T, code, of_values);
  }
  return rows_outcome(T, term, code, callback, of, ld, columns ? of->count : n);
}

static int jacobian(nsdae_terms *T)
{
  const nsdae_system *s = T->system;
  if (s->call.constraint_rows)
    return there(T, NSDAE_TERM_JACOBIAN, nsdae_terms_rows(T, &T->by.rows));
  T->evals->jacobian++;
  return rows_at(T, NSDAE_TERM_JACOBIAN, &T->by.jacobian, s->call.constraint_jacobian,
                 "constraint_jacobian", s->call.constraint, "constraint", 0);
}

/* phi_t or omega, which the callback gives together. */
static int constraint_bias(nsdae_terms *T, unsigned term, double *out)
{
  const nsdae_calls *call = &T->system->call;
  static const char *const callback = "constraint_bias";
  int m = T->system->dims.m, code;
  double t = nsdae_terms_time(T), *phi_t = T->constraint.phi_t, *omega = T->constraint.omega;
  if (call->constraint_bias) {
    zero(phi_t, m);
    zero(omega, m);
    code = call->constraint_bias(t, T->q, T->v, phi_t, omega, T->system->user);
    int status = outcome(T, 0, code, callback, phi_t, m, 1);
    if (status < 0) return status;
    return outcome(T, NSDAE_TERM_PHI_T | NSDAE_TERM_OMEGA, 0, callback, omega, m, 1);
  }
  if (term == NSDAE_TERM_PHI_T)
    code = nsdae_differences_time(T->differences, call->constraint, m, t, T->q, out);
  else
    code = nsdae_differences_second(T->differences, call->constraint, m, t, T->q, T->v, out);
  return outcome(T, term, code, differenced(T, code, "constraint"), out, m, 1);
}

static int bias(nsdae_terms *T)
{
  const nsdae_system *s = T->system;
  int k = s->dims.k, nt = s->dims.nt, code;
  zero(T->w_N, k);
  zero(T->w_T, (long)k * nt);
  if (!s->call.contact_bias) {
    code =
        nsdae_differences_time(T->differences, s->call.gap, k, nsdae_terms_time(T), T->q, T->w_N);
    return outcome(T, NSDAE_TERM_BIAS, code, "gap", T->w_N, k, 1);
  }
  code = s->call.contact_bias(nsdae_terms_time(T), T->q, T->w_N, nt > 0 ? T->w_T : NULL, s->user);
  int status = outcome(T, 0, code, "contact_bias", T->w_N, k, 1);
  return status < 0 ? status : outcome(T, NSDAE_TERM_BIAS, 0, "contact_bias", T->w_T, k * nt, 1);
}

static int frictional_joint(nsdae_terms *T)
{
  const nsdae_system *s = T->system;
  int f = s->dims.f, n = s->dims.nv, code = 0;
  double *W = T->by.frictional_joint.value, *w = T->frictional_joint.w;
  const char *callback = nsdae_system_joint_friction_name(s);
  zero(w, f);
  if (s->call.joint_friction_rows) {
    int status = nsdae_terms_rows(T, &T->by.joint_rows);
    return status < 0 ? status : outcome(T, NSDAE_TERM_SLIDE, 0, callback, w, f, 1);
  }
  clear_rows(T, &T->by.frictional_joint); /* may be missing if no joint has friction */
  if (s->call.frictional_joint_tangent)
    code = s->call.frictional_joint_tangent(nsdae_terms_time(T), T->q, W, n, w, s->user);
  int status = rows_outcome(T, 0, code, callback, &T->by.frictional_joint, n, f);
  return status < 0 ? status : outcome(T, NSDAE_TERM_SLIDE, 0, callback, w, f, 1);
}

/* Of the joints; a negative one is refused. */
static int bound(nsdae_terms *T)
{
  const nsdae_system *s = T->system;
  static const char *const callback = "joint_friction_bound";
  double *b = T->frictional_joint.bound, t = nsdae_terms_time(T);
  int f = s->dims.f, code = 0, negative = -1;
  zero(b, f);
  if (s->call.joint_friction_bound) code = s->call.joint_friction_bound(t, T->q, T->v, b, s->user);
  int status = outcome(T, NSDAE_TERM_BOUND, code, callback, b, f, 1);
  for (int j = 0; j < f && status == NSDAE_OK && negative < 0; j++)
    if (b[j] < 0) negative = j;
  double value = negative < 0 ? 0 : b[negative];
  for (int j = 0; j < f; j++) b[j] += s->frictional_joint[j].bound;
  if (negative < 0) return status;
  T->have &= ~(unsigned)NSDAE_TERM_BOUND;
  nsdae_error_set(T->error, NSDAE_E_CALLBACK, "nsdae_terms", callback,
                  "%s gives a negative bound %g at t = %g: it must be at least 0", callback, value,
                  t);
  if (nsdae_system_explain(s, t, T->q, T->v, T->error)) return NSDAE_E_CALLBACK;
  nsdae_system_name_item(s, NSDAE_NAME_FRICTIONAL_JOINT, negative, T->error);
  return nsdae_error_at(T->error, NSDAE_E_CALLBACK, negative, t);
}

/* Contraction by 0.6 to 1e-13. */
enum { CIRCLE_ROUNDS = 60 };

nsdae_circles nsdae_circles_begin(const nsdae_terms *T, const double *own, const double *lambda,
                                  double part, double size, double *bound)
{
  for (int j = 0; j < T->system->dims.f; j++)
    bound[j] = (own ? own[j] : 0) + (lambda ? nsdae_terms_circle(T->system, j, lambda) : 0);
  return (nsdae_circles){T, own, part, size, bound, 0, NULL};
}

int nsdae_circles_again(nsdae_circles *c, const double *lambda, int *status)
{
  const nsdae_terms *T = c->terms;
  const nsdae_system *s = T->system;
  int moves = -1;
  for (int j = 0; j < s->dims.f && *status >= 0; j++) {
    double circle = nsdae_terms_circle(s, j, lambda), to = circle + (c->own ? c->own[j] : 0);
    double none = c->part * to + 1e3 * DBL_EPSILON * s->frictional_joint[j].radius * c->size;
    double friction = c->friction ? fabs(c->friction[j]) : INFINITY;
    int sticks = friction < to && friction < NSDAE_AT_BOUND * c->bound[j];
    if (!sticks && to != c->bound[j] && !(fabs(to - c->bound[j]) <= none)) moves = j; /* INFINITY */
    c->bound[j] = to;
  }
  if (moves < 0 || c->rounds++ < CIRCLE_ROUNDS) return moves >= 0;
  nsdae_error_set(
      T->error, NSDAE_E_CONVERGENCE, "nsdae_terms", "radius",
      "the friction circle of radius %g did not converge in %d rounds: friction changes "
      "the force on the pin as much as the force changes friction: make mu r smaller",
      s->frictional_joint[moves].radius, CIRCLE_ROUNDS);
  nsdae_system_name_item(s, NSDAE_NAME_FRICTIONAL_JOINT, moves, T->error);
  *status = nsdae_error_at(T->error, NSDAE_E_CONVERGENCE, moves, nsdae_terms_time(T));
  return 0;
}

static int acceleration(nsdae_terms *T)
{
  const nsdae_system *s = T->system;
  int k = s->tracked ? 0 : s->dims.k, kt = k * s->dims.nt, f = s->dims.f, code;
  const char *callback = "contact_acceleration";
  if (s->tracked) {
    int listed = nsdae_terms_slot_accelerations(T);
    if (listed < 0 || f == 0) return there(T, NSDAE_TERM_ACCELERATION, listed);
  }
  zero(T->omega.N, k);
  zero(T->omega.T, kt);
  zero(T->frictional_joint.omega, f);
  if (s->call.contact_acceleration) {
    code = s->call.contact_acceleration(nsdae_terms_time(T), T->q, T->v, k ? T->omega.N : NULL,
                                        kt ? T->omega.T : NULL,
                                        f ? T->frictional_joint.omega : NULL, s->user);
  } else {
    code = nsdae_differences_contacts(T->differences, nsdae_terms_time(T), T->q, T->v, T->omega.N,
                                      T->omega.T, T->frictional_joint.omega);
    if (code || T->differences->bad) callback = code ? T->differences->failed : T->differences->bad;
  }
  int status = outcome(T, 0, code, callback, T->omega.N, k, 1);
  if (status == NSDAE_OK) status = outcome(T, 0, 0, callback, T->omega.T, kt, 1);
  return status < 0
             ? status
             : outcome(T, NSDAE_TERM_ACCELERATION, 0, callback, T->frictional_joint.omega, f, 1);
}

static int potential(nsdae_terms *T)
{
  const nsdae_system *s = T->system;
  T->potential = 0;
  if (!s->call.potential) return there(T, NSDAE_TERM_POTENTIAL, NSDAE_OK);
  return outcome(T, NSDAE_TERM_POTENTIAL,
                 s->call.potential(nsdae_terms_time(T), T->q, &T->potential, s->user), "potential",
                 &T->potential, 1, 1);
}

enum {
  KINETIC_TERMS = NSDAE_TERM_MASS | NSDAE_TERM_FORCE,
  CONSTRAINT_TERMS = NSDAE_TERM_PHI | NSDAE_TERM_JACOBIAN | NSDAE_TERM_PHI_T | NSDAE_TERM_OMEGA,
  CONTACT_TERMS = NSDAE_TERM_GAP | NSDAE_TERM_NORMAL | NSDAE_TERM_TANGENT | NSDAE_TERM_BIAS
};

static int constraint_terms(nsdae_terms *T, unsigned left)
{
  const nsdae_system *s = T->system;
  int status = NSDAE_OK;
  if (left & NSDAE_TERM_PHI)
    status = values_at(T, NSDAE_TERM_PHI, s->call.constraint, "constraint", T->constraint.phi,
                       s->dims.m);
  if (status == NSDAE_OK && (left & NSDAE_TERM_JACOBIAN)) status = jacobian(T);
  if (status == NSDAE_OK && (left & NSDAE_TERM_PHI_T))
    status = constraint_bias(T, NSDAE_TERM_PHI_T, T->constraint.phi_t);
  if (status == NSDAE_OK && (left & ~T->have & NSDAE_TERM_OMEGA))
    status = constraint_bias(T, NSDAE_TERM_OMEGA, T->constraint.omega);
  return status;
}

static int contact_terms(nsdae_terms *T, unsigned left)
{
  const nsdae_system *s = T->system;
  int status = NSDAE_OK;
  if (s->tracked) return nsdae_terms_slots(T);
  if (left & NSDAE_TERM_GAP)
    status = values_at(T, NSDAE_TERM_GAP, s->call.gap, "gap", T->gap, s->dims.k);
  if (status == NSDAE_OK && (left & NSDAE_TERM_NORMAL))
    status = rows_at(T, NSDAE_TERM_NORMAL, &T->by.normal, s->call.gap_normal, "gap_normal",
                     s->call.gap, "gap", 1);
  if (status == NSDAE_OK && (left & NSDAE_TERM_TANGENT)) /* zero if no contact has friction */
    status = rows_at(T, NSDAE_TERM_TANGENT, &T->by.tangent, s->call.gap_tangent, "gap_tangent",
                     NULL, NULL, 1);
  return status == NSDAE_OK && (left & NSDAE_TERM_BIAS) ? bias(T) : status;
}

int nsdae_terms_evaluate(nsdae_terms *T, unsigned which)
{
  const nsdae_dims *d = &T->system->dims;
  unsigned left = which & ~T->have;
  int status = left & NSDAE_TERM_MASS ? mass(T) : NSDAE_OK;
  if (status == NSDAE_OK && (left & NSDAE_TERM_FORCE)) status = force(T);
  if (!(left & ~(unsigned)KINETIC_TERMS)) return status;
  if (status == NSDAE_OK && d->m > 0 && (left & CONSTRAINT_TERMS))
    status = constraint_terms(T, left);
  if (status == NSDAE_OK && d->k > 0 && (left & CONTACT_TERMS)) status = contact_terms(T, left);
  if (status == NSDAE_OK && d->f > 0 && (left & NSDAE_TERM_SLIDE)) status = frictional_joint(T);
  if (status == NSDAE_OK && d->f > 0 && (left & NSDAE_TERM_BOUND)) status = bound(T);
  if (status == NSDAE_OK && (left & NSDAE_TERM_POTENTIAL)) status = potential(T);
  if (status == NSDAE_OK && d->k + d->f > 0 && (left & NSDAE_TERM_ACCELERATION))
    status = acceleration(T);
  return status;
}

int nsdae_kinematics_at(const nsdae_terms *T, const double *v, double *qdot)
{
  const nsdae_system *s = T->system;
  int nq = s->dims.nq, code = 0;
  double sum = 0;
  if (s->call.kinematics) {
    code = s->call.kinematics(nsdae_terms_time(T), T->q, v, qdot, s->user);
    sum = code == 0 && nsdae_all_finite((size_t)nq, qdot) ? 0 : NAN;
  } else {
    for (int i = 0; i < nq; i++) sum += qdot[i] = v[i];
  }
  return isfinite(sum) ? NSDAE_OK : nsdae_terms_outcome(T, code, "kinematics", qdot, nq, 1);
}

double nsdae_terms_touch(const nsdae_terms *terms)
{
  double size = 1;
  const double *q = terms->q, *end = q + terms->system->dims.nq;
  for (; q < end; q++) size = nsdae_larger(size, 1 + fabs(*q));
  return 8 * DBL_EPSILON * size;
}

double nsdae_terms_mobility(const nsdae_terms *T, const double *M, const nsdae_rows *rows, int i)
{
  const nsdae_blocks *blocks = &T->system->blocks;
  double sum = 0;
  for (int p = rows->first[i]; p < rows->first[i + 1]; p++) {
    int b = rows->block[p], n = nsdae_blocks_size(blocks, b);
    const double *W = rows->value + rows->at[p], *of = M + blocks->square[b];
    for (int l = 0; l < n; l++) {
      double entry = W[(size_t)l * rows->stride];
      sum += entry * entry / of[(size_t)l * (size_t)(n + 1)];
    }
  }
  return sum > 0 ? sum : 1;
}

static void add_last_part(const nsdae_terms *T, const nsdae_rows *rows, int i, double size,
                          double *linear)
{
  int p = rows->first[i + 1] - 1;
  if (p < rows->first[i] || size == 0) return;
  const double *W = rows->value + rows->at[p];
  int n = nsdae_blocks_size(&T->system->blocks, rows->block[p]), width = T->system->dims.nt + 1;
  for (int l = 0; l < width && l < n; l++) linear[l] += size * W[(size_t)l * rows->stride];
}

void nsdae_terms_add_linear(const nsdae_terms *T, int i, double share, double normal,
                            const double *tangential, double *linear)
{
  int nt = T->system->dims.nt;
  add_last_part(T, &T->by.normal, i, share * normal, linear);
  for (int j = 0; j < nt; j++)
    add_last_part(T, &T->by.tangent, i * nt + j, share * tangential[j], linear);
}

void nsdae_terms_add_all_linear(const nsdae_terms *T, const double *normal,
                                const double *tangential, double *linear)
{
  const nsdae_system *s = T->system;
  for (int n = 0; n < s->dims.k && s->maker.sensors.contact_forces; n++) {
    int i = nsdae_system_contact(s, n);
    if (normal[i] != 0)
      nsdae_terms_add_linear(T, i, 1, normal[i], tangential + i * s->dims.nt, linear + 3 * i);
  }
}
