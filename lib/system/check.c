/* Given derivatives against differences: see nsdae_system_check. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "check_blocks.h"
#include "check_forces.h"
#include "differences.h"
#include "contact_directions.h"
#include "errors.h"
#include "callback_guard.h"
#include "refusal.h"
#include "system_impl.h"

typedef struct check {
  nsdae_system *system;
  nsdae_differences differences;
  double t, tol;
  const double *q, *v;
  double *given, *differenced, *spare; /* one matrix each */
  nsdae_directions directions;         /* where there is friction */
  int code;                            /* of a callback that failed, and its name */
  const char *callback;
  nsdae_check worst;
  int worst_rows; /* of its matrix */
} check;

static long largest(const nsdae_system *system)
{
  const nsdae_dims *dims = &system->dims;
  long n = dims->nv, m = dims->m, k = (long)dims->k * (1 + dims->nt) + dims->f;
  long size = m > k ? m : k;
  if (system->call.mass && n * n > size) size = n * n;
  if (system->call.constraint_jacobian && n * m > size) size = n * m;
  return n * dims->k > size ? n * dims->k : size;
}

static void layout_check(void *object, nsdae_arena *arena)
{
  check *c = object;
  long size = largest(c->system);
  nsdae_differences_layout(&c->differences, arena);
  c->given = NSDAE_ARENA_DOUBLES(arena, size);
  c->differenced = NSDAE_ARENA_DOUBLES(arena, size);
  c->spare = NSDAE_ARENA_DOUBLES(arena, size);
  c->directions.differences = &c->differences;
  if (c->system->call.gap_tangent) nsdae_directions_layout(&c->directions, arena);
}

static int check_failed(check *c, int code, const char *callback)
{
  c->code = code;
  c->callback = callback;
  return code != 0;
}

/* The same of differences of a callback. */
static int difference_failed(check *c, int code, const char *callback)
{
  return check_failed(c, code, code && c->differences.failed ? c->differences.failed : callback);
}

/* Keeps the worst entry of given - differenced, [rows x columns]. */
static void compare_term(check *c, const char *term, int rows, int columns)
{
  double before = c->worst.error;
  for (long i = 0; i < (long)rows * columns; i++)
    nsdae_check_keep(&c->worst, term, (int)(i % rows), (int)(i / rows), c->given[i],
                     c->differenced[i]);
  if (c->worst.error > before) c->worst_rows = rows;
}

static void zero(double *a, int rows, int columns)
{
  memset(a, 0, (size_t)rows * (size_t)columns * sizeof *a);
}

static void check_mass(check *c)
{
  nsdae_system *s = c->system;
  int n = s->dims.nv;
  if (s->by_blocks) return; /* see check_blocks.h */
  zero(c->given, n, n);
  if (check_failed(c, s->call.mass(c->t, c->q, c->given, n, s->user), "mass")) return;
  for (int j = 0; j < n; j++)
    for (int i = 0; i < n; i++)
      c->differenced[(size_t)j * (size_t)n + (size_t)i] =
          c->given[(size_t)i * (size_t)n + (size_t)j];
  compare_term(c, "mass", n, n);
}

static void check_jacobian(check *c)
{
  nsdae_system *s = c->system;
  int m = s->dims.m, n = s->dims.nv;
  if (!s->call.constraint_jacobian) return;
  zero(c->given, m, n);
  if (check_failed(c, s->call.constraint_jacobian(c->t, c->q, c->given, m, s->user),
                   "constraint_jacobian"))
    return;
  int code = nsdae_differences_velocity(&c->differences, s->call.constraint, m, c->t, c->q,
                                        c->differenced, m, 0);
  if (!difference_failed(c, code, "constraint")) compare_term(c, "constraint_jacobian", m, n);
}

static void check_bias(check *c)
{
  nsdae_system *s = c->system;
  nsdae_differences *d = &c->differences;
  int m = s->dims.m;
  if (!s->call.constraint_bias) return;
  zero(c->given, m, 1);
  zero(c->spare, m, 1);
  if (check_failed(c, s->call.constraint_bias(c->t, c->q, c->v, c->given, c->spare, s->user),
                   "constraint_bias"))
    return;
  int code = nsdae_differences_time(d, s->call.constraint, m, c->t, c->q, c->differenced);
  if (difference_failed(c, code, "constraint")) return;
  compare_term(c, "constraint_bias phi_t", m, 1);
  memcpy(c->given, c->spare, (size_t)m * sizeof *c->given);
  code = nsdae_differences_second(d, s->call.constraint, m, c->t, c->q, c->v, c->differenced);
  if (!difference_failed(c, code, "constraint")) compare_term(c, "constraint_bias omega", m, 1);
}

static void check_normal(check *c)
{
  nsdae_system *s = c->system;
  int k = s->dims.k, n = s->dims.nv;
  if (!s->call.gap_normal) return;
  zero(c->given, n, k);
  if (check_failed(c, s->call.gap_normal(c->t, c->q, c->given, n, s->user), "gap_normal")) return;
  int code =
      nsdae_differences_velocity(&c->differences, s->call.gap, k, c->t, c->q, c->differenced, n, 1);
  if (!difference_failed(c, code, "gap")) compare_term(c, "gap_normal", n, k);
}

static void check_contact_bias(check *c)
{
  nsdae_system *s = c->system;
  int k = s->dims.k;
  if (!s->call.contact_bias) return;
  zero(c->given, k, 1);
  double *w_t = s->dims.nt > 0 ? c->spare : NULL;
  if (check_failed(c, s->call.contact_bias(c->t, c->q, c->given, w_t, s->user), "contact_bias"))
    return;
  int code = nsdae_differences_time(&c->differences, s->call.gap, k, c->t, c->q, c->differenced);
  if (!difference_failed(c, code, "gap")) compare_term(c, "contact_bias w_n", k, 1);
}

static void check_contact_acceleration(check *c)
{
  nsdae_system *s = c->system;
  int k = s->dims.k, kt = k * s->dims.nt, f = s->dims.f;
  if (!s->call.contact_acceleration || c->worst.error > c->tol) return; /* it rests on the others */
  zero(c->given, k + kt + f, 1);
  if (check_failed(c,
                   s->call.contact_acceleration(c->t, c->q, c->v, k ? c->given : NULL,
                                                kt ? c->given + k : NULL,
                                                f ? c->given + k + kt : NULL, s->user),
                   "contact_acceleration"))
    return;
  int code = nsdae_differences_contacts(&c->differences, c->t, c->q, c->v, c->differenced,
                                        c->differenced + k, c->differenced + k + kt);
  if (!difference_failed(c, code, "contact_bias"))
    compare_term(c, "contact_acceleration", k + kt + f, 1);
}

static int bad_tangent(check *c, int contact, int column, const char *why)
{
  nsdae_system *s = c->system;
  char called[NSDAE_CALLED_SIZE];
  c->worst = (nsdae_check){.term = "gap_tangent", .column = column, .error = INFINITY};
  return nsdae_error_set(&s->error, NSDAE_E_DERIVATIVE, "nsdae_system_check", "gap_tangent",
                         "gap_tangent: column %d (%s) %s", column,
                         nsdae_system_called(s, NSDAE_NAME_CONTACT, contact, called), why);
}

/* Directions of friction, and what of them is doubtful. */
static int check_tangents(check *c)
{
  nsdae_system *s = c->system;
  nsdae_directions *d = &c->directions;
  char why[NSDAE_TANGENT_TEXT];
  if (!s->call.gap_tangent || c->code) return NSDAE_OK;
  int code = nsdae_directions_at(d, c->t, c->q), column = -1;
  if (!code) column = nsdae_directions_wrong(d, c->tol, why);
  if (column >= 0) return bad_tangent(c, column / s->dims.nt, column, why);
  if (!code) code = nsdae_directions_doubt(d, c->tol, s->doubt, sizeof s->doubt);
  if (check_failed(c, code, d->callback))
    return nsdae_system_callback_status(code, c->callback, c->t, &s->error);
  return NSDAE_OK;
}

/* What the worst entry belongs to. The rows of contact_acceleration are those of all its outputs,
 * one behind the other; those of a list are its places. */
static void name_worst(const check *c, nsdae_error *error)
{
  const nsdae_dims *d = &c->system->dims;
  int row = c->worst.row, column = c->worst.column, kt = d->k * d->nt;
  char callback[sizeof c->worst.term];
  snprintf(callback, sizeof callback, "%.*s", (int)strcspn(c->worst.term, " "), c->worst.term);
  if (strcmp(callback, "constraint_rows") == 0)
    nsdae_system_name_entry(c->system, "constraint_jacobian", d->m, row, column, error);
  else if (strcmp(callback, "mass_blocks") == 0 || strncmp(callback, "force_", 6) == 0)
    nsdae_system_name_entry(c->system, "mass", d->nv, row, column, error);
  else if (strcmp(callback, "contact_acceleration") != 0)
    nsdae_system_name_entry(c->system, callback, c->worst_rows, row, column, error);
  else if (row < d->k)
    nsdae_system_name_item(c->system, NSDAE_NAME_CONTACT, row, error);
  else if (row < d->k + kt)
    nsdae_system_name_item(c->system, NSDAE_NAME_CONTACT, (row - d->k) / d->nt, error);
  else
    nsdae_system_name_item(c->system, NSDAE_NAME_FRICTIONAL_JOINT, row - d->k - kt, error);
}

static int verdict(check *c, double tol)
{
  nsdae_error *error = &c->system->error;
  const nsdae_check *w = &c->worst;
  if (c->code) return nsdae_system_callback_status(c->code, c->callback, c->t, error);
  if (w->error <= tol) return check_tangents(c);
  nsdae_error_set(error, NSDAE_E_DERIVATIVE, "nsdae_system_check", w->term,
                  "%s: entry (%d, %d) is %.10g, differences give %.10g (error %.3g, tol %.3g)",
                  w->term, w->row, w->column, w->given, w->difference, w->error, tol);
  name_worst(c, error);
  return NSDAE_E_DERIVATIVE;
}

static int check_arguments(nsdae_system *system, const double *q, const double *v, double tol)
{
  const char *missing = !q ? "q" : !v ? "v" : NULL;
  if (missing)
    return nsdae_error_set(&system->error, NSDAE_E_ARGUMENT, "nsdae_system_check", missing,
                           "%s is NULL", missing);
  if (!(tol > 0))
    return nsdae_error_set(&system->error, NSDAE_E_ARGUMENT, "nsdae_system_check", "tol",
                           "tol = %g is outside its range: it must be greater than 0", tol);
  return nsdae_system_complete(system, &system->error);
}

/* Each callback alone. */
static int check_alone(nsdae_system *system, double t, const double *q, const double *v)
{
  double *work = malloc((nsdae_callback_guard_size(system) + 1) * sizeof *work);
  if (!work) return nsdae_error_memory(&system->error, "nsdae_system_check");
  int status = nsdae_callback_guard_callbacks(
      &(nsdae_callback_guard){system, "nsdae_system_check", t, q, v, work, &system->error, 1});
  free(work);
  return status;
}

int nsdae_system_check(nsdae_system *system, double t, const double *q, const double *v, double tol,
                       nsdae_check *worst)
{
  static void (*const all[])(check *) = {check_mass,         check_jacobian,
                                         check_bias,         check_normal,
                                         check_contact_bias, check_contact_acceleration};
  if (!system) return NSDAE_E_ARGUMENT;
  nsdae_refusal_forget(system);
  nsdae_error_clear(&system->error);
  int status = check_arguments(system, q, v, tol);
  if (worst) *worst = (nsdae_check){0};
  system->doubt[0] = '\0';
  if (status == NSDAE_OK) status = check_alone(system, t, q, v);
  if (status < 0) return status;
  check c = {.system = system, .t = t, .tol = tol, .q = q, .v = v};
  c.differences.system = system;
  nsdae_arena arena;
  if (nsdae_arena_build(&arena, layout_check, &c) < 0)
    return nsdae_error_memory(&system->error, "nsdae_system_check");
  for (size_t i = 0; i < sizeof all / sizeof *all && !c.code; i++) all[i](&c);
  if (system->by_blocks && !c.code)
    status = nsdae_system_check_lists(system, &c.differences, t, q, v, &c.worst);
  if (status == NSDAE_OK && !c.code)
    status = nsdae_system_check_forces(system, &c.differences, t, q, v, &c.worst);
  if (status == NSDAE_OK) status = verdict(&c, tol);
  nsdae_arena_release(&arena);
  if (worst) *worst = c.worst;
  return status;
}
