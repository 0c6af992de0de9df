/* Given derivatives against differences: see nsdae_system_check. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "callback_guard.h"
#include "derivative_check.h"
#include "errors.h"

typedef nsdae_derivative_check check;

static void layout_check(void *object, nsdae_arena *arena)
{
  check *c = object;
  const nsdae_system *s = c->system;
  const nsdae_dims *dims = &s->dims;
  long n = dims->nv, size = n;
  const long sizes[] = {2L * dims->m, (long)dims->k * (1 + dims->nt) + dims->f,
                        (long)s->blocks.square[s->blocks.count],
                        s->call.constraint_jacobian ? n * dims->m : 0, n * dims->k};
  for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++)
    if (sizes[i] > size) size = sizes[i];
  nsdae_differences_layout(&c->differences, arena);
  nsdae_arena_doubles(arena, size, (double **[]){&c->given, &c->differenced, &c->spare, NULL});
  c->trial = NSDAE_ARENA_DOUBLES(arena, n);
  c->first = NSDAE_ARENA_INTS(arena, dims->m + 1L);
  c->directions.differences = &c->differences;
  if (s->call.gap_tangent) nsdae_directions_layout(&c->directions, arena);
}

int nsdae_check_callback(check *c, int code, const char *callback)
{
  return nsdae_system_callback_status(code, callback, c->t, &c->system->error);
}

int nsdae_check_difference(check *c, int code, const char *callback)
{
  return nsdae_check_callback(c, code,
                              code && c->differences.failed ? c->differences.failed : callback);
}

void nsdae_check_keep(check *c, const char *term, int row, int column, double given,
                      double difference)
{
  double error = fabs(given - difference) / (1 + fabs(difference));
  if (error <= c->worst.error) return; /* so that NaN is kept as the worst */
  c->worst = (nsdae_check){.row = row,
                           .column = column,
                           .given = given,
                           .difference = difference,
                           .error = isnan(error) ? INFINITY : error};
  snprintf(c->worst.term, sizeof c->worst.term, "%s", term);
}

/* ---- terms of dense callbacks */

enum { MASS, JACOBIAN, PHI_T, OMEGA, NORMAL, W_N, ACCELERATIONS, TERMS };

/* Outputs of callbacks, and of what they are derivatives. */
static const struct {
  const char *callback, *name, *of;
  int output;
} terms[TERMS] = {
    [MASS] = {"mass", "mass", "", 0},
    [JACOBIAN] = {"constraint_jacobian", "constraint_jacobian", "constraint", 0},
    [PHI_T] = {"constraint_bias", "constraint_bias phi_t", "constraint", 0},
    [OMEGA] = {"constraint_bias", "constraint_bias omega", "constraint", 1},
    [NORMAL] = {"gap_normal", "gap_normal", "gap", 0},
    [W_N] = {"contact_bias", "contact_bias w_n", "gap", 0},
    [ACCELERATIONS] = {"contact_acceleration", "contact_acceleration", "contact_bias", 0},
};

/* A term by differences, into differenced; M is compared with its transpose. */
static int find_difference(check *c, int term)
{
  nsdae_differences *d = &c->differences;
  const nsdae_calls *call = &c->system->call;
  int n = c->system->dims.nv, m = c->system->dims.m, k = c->system->dims.k;
  double *out = c->differenced;
  switch (term) {
  case MASS:
    for (int j = 0; j < n; j++)
      for (int i = 0; i < n; i++)
        out[(size_t)j * (size_t)n + (size_t)i] = c->given[(size_t)i * (size_t)n + (size_t)j];
    return 0;
  case JACOBIAN:
    return nsdae_differences_velocity(d, call->constraint, m, c->t, c->q, out, m, 0);
  case PHI_T:
    return nsdae_differences_time(d, call->constraint, m, c->t, c->q, out);
  case OMEGA:
    return nsdae_differences_second(d, call->constraint, m, c->t, c->q, c->v, out);
  case NORMAL:
    return nsdae_differences_velocity(d, call->gap, k, c->t, c->q, out, n, 1);
  case W_N:
    return nsdae_differences_time(d, call->gap, k, c->t, c->q, out);
  default:
    return nsdae_differences_contacts(d, c->t, c->q, c->v, out, out + k,
                                      out + k + k * c->system->dims.nt);
  }
}

/* All outputs of a callback, one behind the other, into given. */
static int call_given(check *c, const nsdae_callback *of)
{
  const nsdae_place at = {c->t, c->q, c->v};
  double *out[NSDAE_OUTPUTS_MAX] = {NULL};
  int ld[NSDAE_OUTPUTS_MAX] = {0};
  size_t used = 0;
  for (int i = 0; i < of->outputs; i++) {
    const nsdae_output *o = &of->output[i];
    ld[i] = nsdae_output_extent(c->system, o, o->row);
    size_t size = (size_t)ld[i] * (size_t)nsdae_output_extent(c->system, o, o->column);
    out[i] = size > 0 ? c->given + used : NULL;
    used += size;
  }
  memset(c->given, 0, used * sizeof *c->given);
  return of->call(c->system, &at, out, ld);
}

/* Keeps the worst entry of given - differenced. The second output of a callback is there with its
 * first; accelerations rest on the other terms, and have all outputs as rows. */
static int check_term(check *c, int term)
{
  const nsdae_dims *d = &c->system->dims;
  const nsdae_callback *of = nsdae_callback_of(terms[term].callback);
  const nsdae_output *o = &of->output[terms[term].output];
  int rows = nsdae_output_extent(c->system, o, o->row), status = NSDAE_OK;
  double before = c->worst.error, *given = c->given + terms[term].output * rows;
  if (!of->given(c->system) || (term == ACCELERATIONS && before > c->tol)) return NSDAE_OK;
  if (given == c->given) status = nsdae_check_callback(c, call_given(c, of), of->name);
  if (status == NSDAE_OK)
    status = nsdae_check_difference(c, find_difference(c, term), terms[term].of);
  if (status < 0) return status;
  if (term == ACCELERATIONS) rows = d->k * (1 + d->nt) + d->f;
  long entries = (long)rows * nsdae_output_extent(c->system, o, o->column);
  for (long i = 0; i < entries; i++)
    nsdae_check_keep(c, terms[term].name, (int)(i % rows), (int)(i / rows), given[i],
                     c->differenced[i]);
  if (c->worst.error > before) c->worst_rows = rows;
  return NSDAE_OK;
}

/* ---- directions of friction */

/* Directions of friction, and what of them is doubtful. */
static int check_tangents(check *c)
{
  nsdae_system *s = c->system;
  nsdae_directions *d = &c->directions;
  char why[NSDAE_TANGENT_TEXT], called[NSDAE_CALLED_SIZE];
  if (!s->call.gap_tangent) return NSDAE_OK;
  int code = nsdae_directions_at(d, c->t, c->q), column = -1;
  if (!code) column = nsdae_directions_wrong(d, c->tol, why);
  if (column >= 0) {
    int contact = column / s->dims.nt;
    c->worst = (nsdae_check){.term = "gap_tangent", .column = column, .error = INFINITY};
    return nsdae_error_set(&s->error, NSDAE_E_DERIVATIVE, "nsdae_system_check", "gap_tangent",
                           "gap_tangent: column %d (%s) %s", column,
                           nsdae_system_called(s, NSDAE_NAME_CONTACT, contact, called), why);
  }
  if (!code) code = nsdae_directions_doubt(d, c->tol, s->doubt, sizeof s->doubt);
  return nsdae_check_difference(c, code, "gap");
}

/* ---- all of it */

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

static int verdict(check *c)
{
  double tol = c->tol;
  nsdae_error *error = &c->system->error;
  const nsdae_check *w = &c->worst;
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
  if (missing) return nsdae_error_null(&system->error, "nsdae_system_check", missing);
  if (!(tol > 0))
    return nsdae_error_set(&system->error, NSDAE_E_ARGUMENT, "nsdae_system_check", "tol",
                           "tol = %g is outside its range: it must be greater than 0", tol);
  return nsdae_system_complete(system, &system->error);
}

int nsdae_system_check(nsdae_system *system, double t, const double *q, const double *v, double tol,
                       nsdae_check *worst)
{
  if (!system) return NSDAE_E_ARGUMENT;
  nsdae_refusal_forget(system);
  nsdae_error_clear(&system->error);
  int status = check_arguments(system, q, v, tol);
  if (worst) *worst = (nsdae_check){0};
  system->doubt[0] = '\0';
  if (status < 0) return status;
  /* Each callback alone. */
  double *work = malloc((nsdae_callback_guard_size(system) + 1) * sizeof *work);
  if (!work) return nsdae_error_memory(&system->error, "nsdae_system_check");
  status = nsdae_callback_guard_callbacks(
      &(nsdae_callback_guard){system, "nsdae_system_check", t, q, v, work, &system->error, 1});
  free(work);
  if (status < 0) return status;
  check c = {.system = system, .t = t, .tol = tol, .q = q, .v = v};
  c.differences.system = system;
  nsdae_arena arena;
  if (nsdae_arena_build(&arena, layout_check, &c) < 0)
    return nsdae_error_memory(&system->error, "nsdae_system_check");
  if (system->by_blocks) status = nsdae_check_lists(&c);
  for (int i = 0; i < TERMS && status == NSDAE_OK; i++) status = check_term(&c, i);
  if (status == NSDAE_OK) status = nsdae_check_forces(&c);
  if (status == NSDAE_OK) status = verdict(&c);
  nsdae_arena_release(&arena);
  if (worst) *worst = c.worst;
  return status;
}
