/* Arrays between guards. The guards and, in the second call, the arrays themselves hold a
 * signalling NaN of a payload of its own: no arithmetic makes that pattern, so that a write is
 * seen, and an entry that still holds it was never written. Guards are as long as the array,
 * GUARD_MOST at most, and GUARD more on either side, so that an index that is one row or column off
 * stays inside of them. */
#include "callback_guard.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

#include "errors.h"

/* ---- callbacks */

#define IN_BRACKETS(...) __VA_ARGS__

#define CALL(name, type, of, arguments, ...)                                               \
  static int has_##name(const nsdae_system *s)                                             \
  {                                                                                        \
    return s->call.name != NULL;                                                           \
  }                                                                                        \
  static int call_##name(const nsdae_system *s, const nsdae_place *at, double *const *out, \
                         const int *ld)                                                    \
  {                                                                                        \
    (void)ld;                                                                              \
    return s->call.name(at->t, at->q, IN_BRACKETS arguments, s->user);                     \
  }

NSDAE_CALLBACKS(CALL)

#define COORDINATE       NSDAE_NAME_COORDINATE
#define VELOCITY         NSDAE_NAME_VELOCITY
#define CONSTRAINT       NSDAE_NAME_CONSTRAINT
#define CONTACT          NSDAE_NAME_CONTACT
#define FRICTIONAL_JOINT NSDAE_NAME_FRICTIONAL_JOINT

#define ENTRY(name, type, of, arguments, ...) {#name, has_##name, call_##name, __VA_ARGS__},

const nsdae_callback nsdae_callbacks[] = {NSDAE_CALLBACKS(ENTRY)};

const int nsdae_callbacks_count = (int)(sizeof nsdae_callbacks / sizeof *nsdae_callbacks);

const nsdae_callback *nsdae_callback_of(const char *name)
{
  for (int c = 0; c < nsdae_callbacks_count; c++)
    if (strcmp(nsdae_callbacks[c].name, name) == 0) return &nsdae_callbacks[c];
  return NULL;
}

int nsdae_output_extent(const nsdae_system *system, const nsdae_output *output, int kind)
{
  int each = kind < 0 ? 1 : nsdae_system_count(system, kind);
  return output->directions && kind == NSDAE_NAME_CONTACT ? each * system->dims.nt : each;
}

enum { GUARD = 64, GUARD_MOST = 8192 };

static const uint64_t mark = 0x7ff4c0dedeadbeefULL;

typedef struct array {
  double *block, *first; /* the guard before, the array */
  size_t size, guard;
  int rows;
} array;

typedef struct probe {
  const nsdae_callback_guard *of;
  const nsdae_callback *callback;
  array array[NSDAE_OUTPUTS_MAX];
} probe;

/* Of the count entries the first that holds the mark (or does not); count where there is none. */
static size_t find_mark(const double *a, size_t count, int marked)
{
  size_t i = 0;
  while (i < count && (memcmp(&a[i], &mark, sizeof mark) == 0) != marked) i++;
  return i;
}

static array output_shape(const nsdae_system *system, const nsdae_output *o)
{
  array a = {.rows = nsdae_output_extent(system, o, o->row)};
  a.size = (size_t)a.rows * (size_t)nsdae_output_extent(system, o, o->column);
  a.guard = (a.size < GUARD_MOST ? a.size : GUARD_MOST) + GUARD;
  return a;
}

static size_t whole(const array *a)
{
  return a->size + 2 * a->guard;
}

size_t nsdae_callback_guard_size(const nsdae_system *system)
{
  size_t most = 0;
  for (int c = 0; c < nsdae_callbacks_count; c++) {
    size_t sum = 0;
    for (int i = 0; i < nsdae_callbacks[c].outputs; i++) {
      const array a = output_shape(system, &nsdae_callbacks[c].output[i]);
      sum += whole(&a);
    }
    if (nsdae_callbacks[c].given(system) && sum > most) most = sum;
  }
  return most;
}

static int call(probe *p, int marked)
{
  const nsdae_callback *c = p->callback;
  double *out[NSDAE_OUTPUTS_MAX] = {NULL};
  int ld[NSDAE_OUTPUTS_MAX] = {0};
  for (int i = 0; i < c->outputs; i++) {
    array *a = &p->array[i];
    for (size_t j = 0; j < whole(a); j++) memcpy(&a->block[j], &mark, sizeof mark);
    if (!marked) memset(a->first, 0, a->size * sizeof *a->first);
    out[i] = a->size > 0 || !c->output[i].nullable ? a->first : NULL;
    ld[i] = a->rows > 0 ? a->rows : 1;
  }
  const nsdae_callback_guard *of = p->of;
  const nsdae_place at = {of->t, of->q, of->v};
  int code = c->call(of->system, &at, out, ld);
  int status = nsdae_system_callback_status(code, c->name, of->t, of->error);
  if (status < 0) nsdae_system_explain(of->system, of->t, of->q, of->v, of->error);
  return status;
}

/* Entry i of an output, counted from its first; also before and behind it. */
static int found(probe *p, int output, long i, int status, const char *what)
{
  const nsdae_output *o = &p->callback->output[output];
  const array *a = &p->array[output];
  nsdae_error *error = p->of->error;
  int inside = i >= 0 && (size_t)i < a->size;
  int row = inside ? (int)i % a->rows : 0, column = inside ? (int)i / a->rows : 0;
  if (inside)
    nsdae_error_set(error, status, p->of->where, p->callback->name,
                    "callback %s %s entry (%d, %d) of %s", p->callback->name, what, row, column,
                    o->name);
  else
    nsdae_error_set(error, status, p->of->where, p->callback->name,
                    "callback %s wrote beyond its array: at %s[%ld], which has %zu entries%s",
                    p->callback->name, o->name, i, a->size,
                    o->column < 0 ? "" : " by columns: entry (i, j) is at i + j ld");
  if (inside) nsdae_output_name_entry(p->of->system, o, row, column, error);
  return nsdae_error_at(error, status, (int)i, p->of->t);
}

static int check_guards(probe *p)
{
  for (int i = 0; i < p->callback->outputs; i++) {
    const array *a = &p->array[i];
    size_t before = find_mark(a->block, a->guard, 0),
           behind = find_mark(a->first + a->size, a->guard, 0);
    if (before < a->guard) return found(p, i, (long)before - (long)a->guard, NSDAE_E_CALLBACK, "");
    if (behind < a->guard) return found(p, i, (long)(a->size + behind), NSDAE_E_CALLBACK, "");
  }
  return NSDAE_OK;
}

static int is_among(const char *callback, const char *const names[], size_t count)
{
  size_t i = 0;
  while (i < count && strcmp(callback, names[i]) != 0) i++;
  return i < count;
}

static int check_finite(probe *p)
{
  /* derivatives that are compared with differences afterwards are judged there */
  static const char *const names[] = {"mass",           "constraint_jacobian",  "constraint_bias",
                                      "gap_normal",     "contact_acceleration", "force_damping",
                                      "force_stiffness"};
  const char *callback = p->callback->name;
  if (is_among(callback, names, sizeof names / sizeof *names)) return NSDAE_OK;
  for (int i = strcmp(callback, "contact_bias") == 0; i < p->callback->outputs; i++) {
    const array *a = &p->array[i];
    size_t entry = 0;
    while (entry < a->size && isfinite(a->first[entry])) entry++;
    if (entry == a->size) continue;
    int status = found(p, i, (long)entry, NSDAE_E_NONFINITE,
                       isnan(a->first[entry]) ? "gave NaN in" : "gave an infinity in");
    nsdae_system_explain(p->of->system, p->of->t, p->of->q, p->of->v, p->of->error);
    return status;
  }
  return NSDAE_OK;
}

int nsdae_callback_guard_callbacks(const nsdae_callback_guard *of)
{
  static const char *const names[] = {"constraint", "gap", "kinematics", "potential",
                                      "contact_speed"};
  int status = NSDAE_OK;
  for (int c = 0; c < nsdae_callbacks_count && status == NSDAE_OK; c++) {
    probe p = {.of = of, .callback = &nsdae_callbacks[c]};
    double *next = of->work;
    if (!p.callback->given(of->system)) continue;
    for (int i = 0; i < p.callback->outputs; i++) {
      array *a = &p.array[i];
      *a = output_shape(of->system, &p.callback->output[i]);
      a->block = next;
      a->first = next + a->guard;
      next += whole(a);
    }
    status = call(&p, 0);
    if (status == NSDAE_OK) status = check_guards(&p);
    if (status == NSDAE_OK && of->finite) status = check_finite(&p);
    /* Positions, gaps and rates are all of something: there a zero that was never written is a
     * mistake, while a matrix or a force may well be written where it is not zero. */
    if (status < 0 || !is_among(p.callback->name, names, sizeof names / sizeof *names)) continue;
    status = call(&p, 1);
    if (status < 0) continue;
    size_t entry = find_mark(p.array[0].first, p.array[0].size, 1);
    if (entry < p.array[0].size) status = found(&p, 0, (long)entry, NSDAE_E_CALLBACK, "never set");
  }
  return status;
}
