/* A system: its sizes, and setters that check each argument against its range. */
#include "system_impl.h"

#include <limits.h>
#include <math.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int bad_size(nsdae_error *error, const char *name, int value, const char *range)
{
  return nsdae_error_set(error, NSDAE_E_ARGUMENT, "nsdae_system_create", name,
                         "dims.%s = %d is outside its range: it must be %s", name, value, range);
}

int nsdae_system_create(const nsdae_dims *dims, nsdae_system **system, nsdae_error *error)
{
  nsdae_error_clear(error);
  if (!system || !dims)
    return nsdae_error_set(error, NSDAE_E_ARGUMENT, "nsdae_system_create", dims ? "system" : "dims",
                           "%s is NULL", dims ? "system" : "dims");
  *system = NULL;
  enum { MOST = 1 << 20 }; /* so that no index overflows an int */
  if (dims->nq < 1 || dims->nq > MOST) return bad_size(error, "nq", dims->nq, "1 .. 2^20");
  if (dims->nv < 0 || dims->nv > dims->nq) return bad_size(error, "nv", dims->nv, "0 .. nq");
  if (dims->m < 0 || dims->m > MOST) return bad_size(error, "m", dims->m, "0 .. 2^20");
  if (dims->k < 0 || dims->k > MOST) return bad_size(error, "k", dims->k, "0 .. 2^20");
  if (dims->nt < 0 || dims->nt > 2) return bad_size(error, "nt", dims->nt, "0, 1 or 2");
  if (dims->f < 0 || dims->f > MOST) return bad_size(error, "f", dims->f, "0 .. 2^20");
  nsdae_system *made = calloc(1, sizeof *made);
  if (made) atomic_init(&made->owners, 1);
  if (made) made->contact = calloc((size_t)dims->k + 1, sizeof *made->contact);
  if (made) made->frictional_joint = calloc((size_t)dims->f + 1, sizeof *made->frictional_joint);
  int nv = dims->nv == 0 ? dims->nq : dims->nv;
  if (!made || !made->contact || !made->frictional_joint ||
      nsdae_blocks_make(&made->blocks, 1, &nv) < 0 ||
      nsdae_blocks_make(&made->coordinates, 1, &dims->nq) < 0) {
    nsdae_system_destroy(&made);
    return nsdae_error_memory(error, "nsdae_system_create");
  }
  atomic_init(&made->late, NULL);
  nsdae_refusal_forget(made);
  made->dims = *dims;
  made->dims.nv = nv;
  nsdae_error_clear(&made->error);
  nsdae_error_clear(&made->refused);
  *system = made;
  return NSDAE_OK;
}

static void release(nsdae_system *system)
{
  if (atomic_fetch_sub(&system->owners, 1) > 1) return;
  for (int kind = 0; kind < NSDAE_NAME_KINDS; kind++) {
    free(system->label[kind]);
    free(system->size[kind]);
  }
  for (int i = 0; i < system->bodies; i++) free((void *)(uintptr_t)system->body[i].point);
  free(system->body);
  free(system->contact);
  free(system->frictional_joint);
  nsdae_blocks_release(&system->blocks);
  nsdae_blocks_release(&system->coordinates);
  if (system->maker.release) system->maker.release(system->maker.of);
  free(system);
}

void nsdae_system_destroy(nsdae_system **system)
{
  if (!system || !*system) return;
  nsdae_refusal_forget(*system);
  release(*system);
  *system = NULL;
}

/* Its number of owners is all that a simulation changes of a system. */
void nsdae_system_hold(const nsdae_system *system)
{
  atomic_fetch_add(&((nsdae_system *)system)->owners, 1);
}

void nsdae_system_let_go(const nsdae_system *system)
{
  if (system) release((nsdae_system *)system);
}

int nsdae_system_simulations(const nsdae_system *system)
{
  return system ? atomic_load(&((nsdae_system *)system)->owners) - 1 : 0;
}

enum { WHERE_SIZE = sizeof((nsdae_error *)0)->where };

static void name_setter(const char *setter, char where[WHERE_SIZE])
{
  snprintf(where, WHERE_SIZE, "nsdae_system_%s%s", strncmp(setter, "add_", 4) ? "set_" : "",
           setter);
}

/* Simulations may read the system in other threads: of it, nothing but the name of the first such
 * setter is changed then. */
int nsdae_system_refuse(nsdae_system *system, int status, const char *setter, const char *argument,
                        const char *format, ...)
{
  char where[WHERE_SIZE], why[sizeof system->error.text];
  const char *none = NULL;
  int late = nsdae_system_simulations(system) > 0;
  nsdae_error *error = late ? nsdae_refusal_on(system) : &system->error;
  va_list values;
  va_start(values, format);
  vsnprintf(why, sizeof why, format, values);
  va_end(values);
  name_setter(setter, where);
  nsdae_error_set(error, status, where, argument, "%s", why);
  if (late) {
    atomic_compare_exchange_strong(&system->late, &none, setter);
    return status;
  }
  nsdae_refusal_forget(system);
  if (system->refused.status == NSDAE_OK) system->refused = system->error;
  return status;
}

int nsdae_system_open(nsdae_system *system, const char *setter)
{
  int simulations = nsdae_system_simulations(system);
  if (simulations == 0) {
    nsdae_refusal_forget(system);
    nsdae_error_clear(&system->error);
    return NSDAE_OK;
  }
  return nsdae_system_refuse(
      system, NSDAE_E_STATE, setter, "system",
      "the system is constant while it has simulations (%d now): destroy them before you change "
      "it, "
      "make another system, or change it in one of them (nsdae_sim_set_user, "
      "nsdae_sim_set_contact, nsdae_sim_set_frictional_joint, nsdae_sim_set_friction_bound)",
      simulations);
}

void nsdae_system_clear_error(nsdae_system *system)
{
  if (!system) return;
  nsdae_refusal_forget(system);
  atomic_store(&system->late, NULL);
  nsdae_error_clear(&system->error);
  nsdae_error_clear(&system->refused);
}

int nsdae_system_set_user(nsdae_system *system, void *user)
{
  if (!system) return NSDAE_E_ARGUMENT;
  int status = nsdae_system_open(system, "user");
  if (status == NSDAE_OK) system->user = user;
  return status;
}

/* What a system must have for a callback. */
enum { ANY, CONSTRAINTS, CONTACTS, DIRECTIONS, JOINTS, SLIDING };

/* Whether a callback may be set. */
static int open_callback(nsdae_system *system, const char *name, int given, int of)
{
  static const char *const what[] = {[CONSTRAINTS] = "constraints (m = 0)",
                                     [CONTACTS] = "contacts (k = 0)",
                                     [DIRECTIONS] = "tangential directions (k nt = 0)",
                                     [JOINTS] = "frictional joints (f = 0)",
                                     [SLIDING] = "contacts or frictional joints (k = f = 0)"};
  if (!system) return NSDAE_E_ARGUMENT;
  const nsdae_dims *d = &system->dims;
  const int count[] = {1, d->m, d->k, d->k * d->nt, d->f, d->k + d->f};
  if (given && count[of] > 0) return nsdae_system_open(system, name);
  return nsdae_system_refuse(system, NSDAE_E_ARGUMENT, name, name, "%s: %s%s", name,
                             given ? "the system has no " : "it is NULL", given ? what[of] : "");
}

#define SETTER(name, type, of, ...)                              \
  int nsdae_system_set_##name(nsdae_system *system, type name)   \
  {                                                              \
    int status = open_callback(system, #name, name != NULL, of); \
    if (status == NSDAE_OK) system->call.name = name;            \
    return status;                                               \
  }

NSDAE_CALLBACKS(SETTER)

static int bad_coefficient(nsdae_system *system, const char *setter, const char *name, double value,
                           const char *range)
{
  return nsdae_system_refuse(system, NSDAE_E_ARGUMENT, setter, name,
                             "%s = %g is outside its range: it must be %s", name, value, range);
}

static int bad_index(nsdae_system *system, const char *setter, const char *name, int index,
                     int count)
{
  return nsdae_system_refuse(system, NSDAE_E_ARGUMENT, setter, name,
                             count > 0 ? "%s = %d is outside its range: it must be 0 .. %d"
                                       : "%s = %d: the system has none of these",
                             name, index, count - 1);
}

int nsdae_system_set_contact(nsdae_system *system, int i, double mu, double e_n, double e_t)
{
  if (!system) return NSDAE_E_ARGUMENT;
  if (i < 0 || i >= system->dims.k) return bad_index(system, "contact", "i", i, system->dims.k);
  char called[NSDAE_CALLED_SIZE];
  /* conditions are written so that NaN fails */
  if (!(mu >= 0) || isinf(mu))
    return bad_coefficient(system, "contact", "mu", mu, "at least 0, finite");
  if (!(e_n >= 0 && e_n <= 1)) return bad_coefficient(system, "contact", "e_n", e_n, "0 .. 1");
  if (!(e_t >= 0 && e_t <= 1)) return bad_coefficient(system, "contact", "e_t", e_t, "0 .. 1");
  if (system->dims.nt == 0 && mu > 0)
    return nsdae_system_refuse(
        system, NSDAE_E_ARGUMENT, "contact", "mu",
        "mu = %g, but the system has no tangential directions: make it with dims.nt = 1 (plane) or "
        "2 (space) (%s)",
        mu, nsdae_system_called(system, NSDAE_NAME_CONTACT, i, called));
  int status = nsdae_system_open(system, "contact");
  if (status == NSDAE_OK) system->contact[i] = (nsdae_coefficients){mu, e_n, e_t, 1};
  return status;
}

int nsdae_system_set_frictional_joint(nsdae_system *system, int j, int constraint, double mu)
{
  if (!system) return NSDAE_E_ARGUMENT;
  if (j < 0 || j >= system->dims.f)
    return bad_index(system, "frictional_joint", "j", j, system->dims.f);
  if (constraint < 0 || constraint >= system->dims.m)
    return bad_index(system, "frictional_joint", "constraint", constraint, system->dims.m);
  if (!(mu >= 0) || isinf(mu))
    return bad_coefficient(system, "frictional_joint", "mu", mu, "at least 0, finite");
  int status = nsdae_system_open(system, "frictional_joint");
  if (status < 0) return status;
  nsdae_frictional_joint *joint = &system->frictional_joint[j];
  joint->constraint = constraint;
  joint->mu = mu;
  joint->told = 1;
  return NSDAE_OK;
}

int nsdae_system_set_friction_circle(nsdae_system *system, int j, int constraint, int rows,
                                     double radius)
{
  const char *what = "friction_circle";
  if (!system) return NSDAE_E_ARGUMENT;
  if (j < 0 || j >= system->dims.f) return bad_index(system, what, "j", j, system->dims.f);
  if (rows < 1 || rows > 3)
    return nsdae_system_refuse(system, NSDAE_E_ARGUMENT, what, "rows",
                               "rows = %d is outside its range: it must be 1 .. 3", rows);
  if (constraint < 0 || constraint > system->dims.m - rows)
    return bad_index(system, what, "constraint", constraint, system->dims.m - rows + 1);
  if (!(radius >= 0) || isinf(radius))
    return bad_coefficient(system, what, "radius", radius, "at least 0, finite");
  int status = nsdae_system_open(system, what);
  if (status < 0) return status;
  nsdae_frictional_joint *joint = &system->frictional_joint[j];
  joint->first = constraint;
  joint->rows = radius > 0 ? rows : 0;
  joint->radius = radius;
  joint->told = 1;
  return NSDAE_OK;
}

int nsdae_system_set_friction_bound(nsdae_system *system, int j, double bound)
{
  if (!system) return NSDAE_E_ARGUMENT;
  if (j < 0 || j >= system->dims.f)
    return bad_index(system, "friction_bound", "j", j, system->dims.f);
  if (!(bound >= 0) || isinf(bound))
    return bad_coefficient(system, "friction_bound", "bound", bound, "at least 0, finite");
  int status = nsdae_system_open(system, "friction_bound");
  if (status < 0) return status;
  nsdae_frictional_joint *joint = &system->frictional_joint[j];
  joint->bound = bound;
  joint->bounded = joint->told = 1;
  return NSDAE_OK;
}

const nsdae_error *nsdae_system_error(const nsdae_system *system)
{
  static const nsdae_error none = {
      .status = NSDAE_E_ARGUMENT,
      .index = -1,
      .time = NAN,
      .argument = "system",
      .where = "nsdae_system_error",
      .text = "there is no system: it was not made (the last argument of nsdae_system_create says "
              "why), or it was destroyed"};
  if (!system) return &none;
  const nsdae_error *refusal = nsdae_refusal_of(system);
  return refusal ? refusal : &system->error;
}

int nsdae_system_get_dims(const nsdae_system *system, nsdae_dims *dims)
{
  if (!system || !dims) return NSDAE_E_ARGUMENT;
  *dims = system->dims;
  return NSDAE_OK;
}

typedef struct remark {
  const char *text;
  int holds;
} remark;

/* The texts of those that hold, one behind the other. */
static const char *join(char *text, size_t size, const remark *remarks, size_t count,
                        const char *separator)
{
  *text = '\0';
  for (size_t i = 0; i < count; i++) {
    size_t used = strlen(text);
    if (remarks[i].holds)
      snprintf(text + used, size - used, "%s%s", used ? separator : "", remarks[i].text);
  }
  return text;
}

const char *nsdae_system_differences(nsdae_system *system)
{
  if (!system) return "";
  const nsdae_dims *d = &system->dims;
  const remark filled[] = {
      {"constraint_jacobian", d->m > 0 && !nsdae_system_has_jacobian(system)},
      {"constraint_bias", d->m > 0 && !system->call.constraint_bias},
      {"gap_normal", d->k > 0 && !system->call.gap_normal},
      {"contact_bias", d->k > 0 && !system->call.contact_bias},
      {"contact_acceleration", d->k + d->f > 0 && !system->call.contact_acceleration},
  };
  return join(system->differences, sizeof system->differences, filled,
              sizeof filled / sizeof *filled, " ");
}

static int any_friction(const nsdae_system *system)
{
  for (int i = 0; i < system->dims.k; i++)
    if (system->contact[i].mu > 0) return 1;
  return 0;
}

const char *nsdae_system_unseen(nsdae_system *system)
{
  if (!system) return "";
  int moves = system->call.contact_bias != NULL, untold = 0;
  for (int i = 0; i < system->dims.k; i++) untold |= !system->contact[i].told;
  const remark unseen[] = {
      {"mass: its values, except symmetry", system->call.mass || system->call.mass_blocks},
      {"force: its values and signs", system->call.force != NULL},
      {"constraint: whether it is the one that is meant", system->call.constraint != NULL},
      {"gap: whether it is the distance, its sign and its unit", system->call.gap != NULL},
      {"gap_tangent: a common sign of all arms of a body and a common constant in them, except for "
       "doubts of the last check; length and perpendicularity of its directions on bodies that M "
       "does not show to be free",
       system->call.gap_tangent != NULL},
      {"contact_bias: w_t", moves && system->dims.nt > 0},
      {"contact_bias is missing: that no contact surface has a prescribed tangential velocity",
       !moves && any_friction(system)},
      {"nsdae_system_set_contact: that e_n = mu = 0 for contacts without a call", untold},
      {"frictional_joint_tangent: its values", system->call.frictional_joint_tangent != NULL},
      {"joint_friction_rows: its values", system->call.joint_friction_rows != NULL},
      {"joint_friction_bound: its values", system->call.joint_friction_bound != NULL},
      {"potential: whether the force is its gradient (the energy balance of a run shows that)",
       system->call.potential != NULL},
      {system->doubt, system->doubt[0] != '\0'},
  };
  return join(system->unseen, sizeof system->unseen, unseen, sizeof unseen / sizeof *unseen, "; ");
}

static int refuse_untold(const nsdae_system *system, const char *setter, const char *callback,
                         int kind, int i, nsdae_error *error)
{
  nsdae_error_set(error, NSDAE_E_STATE, "nsdae_system", setter,
                  "%s gives the directions of friction, but its coefficient is not set: call "
                  "nsdae_system_set_%s (mu = 0: no friction)",
                  callback, setter);
  nsdae_system_name_item(system, kind, i, error);
  return NSDAE_E_STATE;
}

int nsdae_system_told(const nsdae_system *system, nsdae_error *error)
{
  for (int i = 0; system->call.gap_tangent && i < system->dims.k; i++)
    if (!system->contact[i].told)
      return refuse_untold(system, "contact", "gap_tangent", NSDAE_NAME_CONTACT, i, error);
  for (int j = 0; nsdae_system_has_joint_friction(system) && j < system->dims.f; j++)
    if (!system->frictional_joint[j].told && !system->call.joint_friction_bound)
      return refuse_untold(system, "frictional_joint", nsdae_system_joint_friction_name(system),
                           NSDAE_NAME_FRICTIONAL_JOINT, j, error);
  return NSDAE_OK;
}

int nsdae_system_complete(const nsdae_system *system, nsdae_error *error)
{
  const nsdae_dims *dims = &system->dims;
  const nsdae_error *refused = &system->refused;
  const char *missing = NULL;
  if (refused->status < 0)
    return nsdae_error_set(error, refused->status, refused->where, refused->argument,
                           "%s was refused: %s", refused->where, refused->text);
  const char *late = atomic_load(&((nsdae_system *)system)->late);
  char where[WHERE_SIZE];
  if (late) { /* as of any other setter that was refused */
    name_setter(late, where);
    return nsdae_error_set(error, NSDAE_E_STATE, where, "system",
                           "%s was refused while the system had simulations", where);
  }
  int status = nsdae_system_check_blocks(system, &missing, error);
  if (status < 0) return status;
  if (!system->by_blocks && !system->call.mass) missing = "mass";
  if (!system->call.force) missing = "force";
  if (dims->m > 0 && !system->call.constraint) missing = "constraint";
  if (dims->k > 0 && !system->call.gap) missing = "gap";
  if (dims->k > 0 && dims->nt > 0 && any_friction(system) && !system->call.gap_tangent)
    missing = "gap_tangent";
  for (int j = 0; j < dims->f && !nsdae_system_has_joint_friction(system); j++)
    if (nsdae_system_joint_rubs(system, j))
      missing = system->by_blocks ? "joint_friction_rows" : "frictional_joint_tangent";
  if (dims->nq != dims->nv && !system->call.kinematics) missing = "kinematics";
  if (!missing) return nsdae_names_distinct(system, error);
  return nsdae_error_set(error, NSDAE_E_STATE, "nsdae_system", missing,
                         "the system needs the callback %s: call nsdae_system_set_%s", missing,
                         missing);
}

int nsdae_system_callback_failed(int code, const char *callback, double t, nsdae_error *error)
{
  nsdae_error_set(error, NSDAE_E_CALLBACK, callback, callback,
                  "callback %s returned %d (%s) at t = %g", callback, code,
                  code > 0 ? "recoverable: a smaller step may help" : "fatal", t);
  if (error) error->code = code;
  return nsdae_error_at(error, NSDAE_E_CALLBACK, -1, t);
}

int nsdae_system_not_finite(const nsdae_system *system, const double *a, int rows,
                            const char *callback, double t, nsdae_error *error)
{
  size_t n = (size_t)rows, i = 0;
  while (isfinite(a[i])) i++;
  nsdae_error_set(error, NSDAE_E_NONFINITE, callback, callback,
                  "callback %s gave %g in entry (%zu, %zu) at t = %g", callback,
                  isnan(a[i]) ? fabs(a[i]) : a[i], i % n, i / n, t);
  nsdae_system_name_entry(system, callback, rows, (int)(i % n), (int)(i / n), error);
  return nsdae_error_at(error, NSDAE_E_NONFINITE, i > INT_MAX ? INT_MAX : (int)i, t);
}
