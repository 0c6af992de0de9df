/* A simulation: its making, its start and what can be asked of it. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "callback_guard.h"
#include "sim_impl.h"

void nsdae_sim_layout(void *object, nsdae_arena *arena)
{
  nsdae_sim *sim = object;
  for (int i = 0; i < (sim->aside ? 3 : 2); i++) nsdae_point_layout(&sim->point[i], arena);
  nsdae_units_layout(&sim->projection, arena);
  nsdae_arena_zeros(arena);
  nsdae_stepper_layout(&sim->stepper, arena);
  nsdae_projector_layout(&sim->projection, arena);
  if (nsdae_sim_projection(&sim->options) == NSDAE_PROJECTION_SLOP)
    nsdae_slop_layout(&sim->slop, &sim->model, arena);
  size_t size = nsdae_callback_guard_size(&sim->model),
         start = nsdae_initial_size(&sim->model.dims), watch = 2 * (size_t)sim->model.dims.nv;
  if (size < start) size = start;
  if (size < watch) size = watch;
  sim->probe = NSDAE_ARENA_DOUBLES(arena, size);
}

static int no_memory_for_sim(nsdae_sim *sim, nsdae_error *error)
{
  nsdae_sim_destroy(&sim);
  return nsdae_error_set(error, NSDAE_E_MEMORY, "nsdae_sim_create", "",
                         "out of memory for a simulation of this size");
}

/* The dense complementarity problem of all contacts together has its limit, whatever the memory. */
static int check_rows(const nsdae_system *system, const nsdae_sim_options *options,
                      nsdae_error *error)
{
  nsdae_sim_options defaults;
  nsdae_sim_options_default(&defaults);
  if (!options) options = &defaults;
  int edges = options->polygon, limit = nsdae_contacts_rows_limit();
  if (options->method == NSDAE_METHOD_EVENT) edges = nsdae_law_edges_to_start(edges);
  long rows = nsdae_contacts_rows(system, edges);
  if (rows <= limit) return NSDAE_OK;
  char fewer_edges[128] = "";
  if (edges > 0)
    snprintf(fewer_edges, sizeof fewer_edges,
             ", or a polygon of fewer edges (%d now, %d rows for a spatial contact with friction)",
             edges, edges + 2);
  return nsdae_error_set(error, NSDAE_E_ARGUMENT, "nsdae_sim_create", "k",
                         "k = %d contacts and f = %d frictional joints give %ld rows of the "
                         "complementarity problem, above the maximum %d: use fewer%s",
                         system->dims.k, system->dims.f, rows, limit, fewer_edges);
}

/* At first, of a method that tracks the contacts of a list. */
enum { SLOTS = 8 };

/* Position motors are rows of time stepping. */
static void set_position_motors(nsdae_sim *sim)
{
  const nsdae_maker *maker = &sim->system->maker;
  nsdae_gains gains;
  sim->control.user.rows = sim->method->closes;
  for (int j = 0; j < sim->model.dims.f; j++) {
    nsdae_frictional_joint *joint = &sim->model.frictional_joint[j];
    if (!maker->position(maker->of, j, &gains)) continue;
    joint->position = sim->method->closes ? NSDAE_POSITION_ROW : NSDAE_POSITION_FORCE;
    joint->kp = gains.kp;
    joint->kd = gains.kd;
    if (sim->method->closes) joint->bound = gains.limit;
  }
}

static int copy_controls(nsdae_sim *sim)
{
  const nsdae_maker *maker = &sim->system->maker;
  size_t n = (size_t)maker->controls;
  nsdae_controls *c = &sim->control;
  if (!maker->of) return NSDAE_OK;
  c->value = calloc(2 * n + 1, sizeof *c->value);
  if (!c->value) return NSDAE_E_MEMORY;
  if (n > 0) memcpy(c->value, maker->control, n * sizeof *c->value);
  c->before = c->value + n;
  c->user = (nsdae_maker_user){maker->of, c->value, 0};
  sim->model.user = &c->user;
  set_position_motors(sim);
  return NSDAE_OK;
}

/* The system with coefficients of its own, in blocks of their own: their number sizes the arena. */
static int copy_system(nsdae_sim *sim)
{
  const nsdae_system *from = sim->system;
  size_t k = (size_t)from->dims.k, f = (size_t)from->dims.f;
  memcpy(&sim->model, from, offsetof(nsdae_system, owners));
  sim->model.frictional_joint = calloc(f + 1, sizeof *sim->model.frictional_joint);
  if (from->call.contacts && sim->method->tracks) {
    nsdae_system_track(&sim->model, &sim->tracked);
    if (nsdae_sim_make_slots(sim, SLOTS) < 0) return NSDAE_E_MEMORY;
  } else {
    sim->model.contact = calloc(k + 1, sizeof *sim->model.contact);
  }
  if (!sim->model.contact || !sim->model.frictional_joint) return NSDAE_E_MEMORY;
  if (k > 0) memcpy(sim->model.contact, from->contact, k * sizeof *from->contact);
  if (f > 0)
    memcpy(sim->model.frictional_joint, from->frictional_joint, f * sizeof *from->frictional_joint);
  return copy_controls(sim);
}

/* Lists begin with room for a contact of each block and for two blocks of each row, of Phi_q or of
 * W_S^T, which has no more. */
static int first_room(nsdae_sim *sim)
{
  const nsdae_dims *d = &sim->system->dims;
  size_t blocks = (size_t)sim->system->blocks.count, columns = (size_t)(1 + d->nt);
  size_t most = (size_t)sim->options.contacts_max, pairs = blocks < most ? blocks : most;
  nsdae_room contacts = {pairs, 2 * columns * (size_t)d->nv};
  nsdae_room rows = {2 * (size_t)d->m, 12 * (size_t)d->m};
  if (!sim->system->call.contacts) contacts = (nsdae_room){0};
  if (!sim->system->call.constraint_rows && !sim->system->call.joint_friction_rows)
    rows = (nsdae_room){0};
  return nsdae_sim_make_room(sim, &contacts, &rows);
}

void nsdae_sim_measure(nsdae_sim *sim)
{
  nsdae_stepper_prepare(&sim->stepper);
  /* Which rows are projected, by the option projection and at the start of event: none,
   * constraints, or the contacts too. Event with a contact list projects its start by terms of
   * their own. */
  nsdae_projector *p = &sim->projection;
  const nsdae_sim_options *o = &sim->options;
  int event = o->method == NSDAE_METHOD_EVENT && !sim->model.tracked;
  int projection = nsdae_sim_projection(o);
  p->tools = &sim->stepper;
  p->rows = event || projection != NSDAE_PROJECTION_NONE ? sim->system->dims.m : 0;
  p->contacts.any =
      event || projection == NSDAE_PROJECTION_CONTACTS || projection == NSDAE_PROJECTION_DEPTHS;
  for (int i = 0; i < 3; i++) {
    nsdae_memory *memory = &sim->point[i].result.memory;
    nsdae_memory_part part = {.slots = (size_t)sim->model.dims.k};
    sim->method->lay(&sim->stepper, &part);
    memory->reals = part.reals;
    memory->wholes = part.wholes;
  }
}

int nsdae_sim_make_method(nsdae_sim *sim)
{
  if (sim->method->create) return sim->method->create(&sim->stepper, &sim->own);
  sim->own = &sim->stepper;
  return NSDAE_OK;
}

/* Everything that has a size, and the method. */
static int build(nsdae_sim *sim)
{
  nsdae_stepper *stepper = &sim->stepper;
  stepper->system = &sim->model;
  stepper->options = &sim->options;
  stepper->error = &sim->error;
  stepper->units = &sim->projection.units;
  if (nsdae_problem_make(&stepper->problem, &sim->model, sim->options.threads, &sim->error) < 0)
    return nsdae_error_set(&sim->error, NSDAE_E_MEMORY, "nsdae_sim_create", "threads",
                           "out of memory, or of threads of the system, for threads = %d",
                           sim->options.threads);
  sim->projection.tools = stepper;
  sim->now = &sim->point[0];
  sim->next = &sim->point[1];
  sim->aside = sim->method->settle ? &sim->point[2] : NULL;
  nsdae_sim_measure(sim);
  for (int i = 0; i < 3; i++) nsdae_stepper_prepare_terms(stepper, &sim->point[i].result.end);
  for (int i = 0; i < 3; i++)
    sim->point[i].result.closed.rows = nsdae_law_rows(sim->model.dims.nt, 1, sim->options.polygon);
  if (nsdae_arena_build(&sim->arena, nsdae_sim_layout, sim) < 0)
    return nsdae_error_set(&sim->error, NSDAE_E_MEMORY, "nsdae_sim_create", "",
                           "out of memory for a simulation of this size");
  int status = first_room(sim);
  return status < 0 ? status : nsdae_sim_make_method(sim);
}

/* Whether the contacts of the system have the rates that the method needs. */
static int check_contacts(const nsdae_system *system, const nsdae_sim_options *options,
                          nsdae_error *error)
{
  const nsdae_maker *maker = &system->maker;
  nsdae_sim_options defaults;
  nsdae_sim_options_default(&defaults);
  int method = options ? options->method : defaults.method;
  return maker->check_rates && !nsdae_stepping_of(method)->closes
             ? maker->check_rates(maker->of, error)
             : NSDAE_OK;
}

int nsdae_sim_create(const nsdae_system *system, const nsdae_sim_options *options, nsdae_sim **sim,
                     nsdae_error *error)
{
  nsdae_error_clear(error);
  if (!system || !sim)
    return nsdae_error_set(error, NSDAE_E_ARGUMENT, "nsdae_sim_create", system ? "sim" : "system",
                           "%s is NULL", system ? "sim" : "system");
  *sim = NULL;
  int status = options ? nsdae_sim_options_check(options, error) : NSDAE_OK;
  if (status == NSDAE_OK) status = nsdae_system_complete(system, error);
  if (status == NSDAE_OK) status = nsdae_system_told(system, error);
  if (status == NSDAE_OK) status = check_rows(system, options, error);
  if (status == NSDAE_OK) status = check_contacts(system, options, error);
  if (status < 0) return status;
  nsdae_sim *made = calloc(1, sizeof *made);
  if (!made) return no_memory_for_sim(NULL, error);
  nsdae_system_hold(system);
  made->system = system;
  if (options)
    made->options = *options;
  else
    nsdae_sim_options_default(&made->options);
  made->method = nsdae_stepping_of(made->options.method);
  nsdae_refusal_forget(made);
  nsdae_error_clear(&made->error);
  if (copy_system(made) < 0) return no_memory_for_sim(made, error);
  status = build(made);
  if (status < 0) {
    if (error) *error = made->error;
    nsdae_sim_destroy(&made);
    return status;
  }
  *sim = made;
  return NSDAE_OK;
}

void nsdae_sim_destroy(nsdae_sim **handle)
{
  if (!handle) return;
  nsdae_sim *sim = *handle;
  nsdae_call call = NSDAE_CALL(NSDAE_END, "nsdae_sim_destroy");
  if (nsdae_sim_enter(&call) < 0) return;
  const nsdae_stepping *method = sim->method;
  if (method && method->destroy) method->destroy(sim->own);
  nsdae_kkt_release(&sim->stepper.kkt);
  nsdae_projector_release(&sim->projection);
  nsdae_slop_release(&sim->slop);
  nsdae_terms_release(&sim->stepper.middle);
  for (int i = 0; i < 3; i++) nsdae_result_release(&sim->point[i].result);
  nsdae_problem_release(&sim->stepper.problem);
  nsdae_arena_release(&sim->arena);
  free(sim->model.contact);
  free(sim->model.frictional_joint);
  free(sim->control.value);
  free(sim->tracked.id);
  free(sim->tracked.used);
  free(sim->tracked.block);
  free(sim->tracked.order);
  nsdae_system_let_go(sim->system);
  nsdae_refusal_forget(sim);
  free(sim);
  *handle = NULL;
}

static int check_vector(nsdae_sim *sim, const char *where, const char *name, int kind,
                        const double *a)
{
  int n = nsdae_system_count(sim->system, kind);
  char called[NSDAE_CALLED_SIZE];
  if (!a) return nsdae_error_set(&sim->error, NSDAE_E_ARGUMENT, where, name, "%s is NULL", name);
  for (int i = 0; i < n; i++) {
    if (isfinite(a[i])) continue;
    nsdae_error_set(&sim->error, NSDAE_E_NONFINITE, where, name,
                    "%s[%d] = %g is not a finite number (%s)", name, i, a[i],
                    nsdae_system_called(sim->system, kind, i, called));
    return nsdae_error_at(&sim->error, NSDAE_E_NONFINITE, i, NAN);
  }
  return NSDAE_OK;
}

int nsdae_sim_check_state(nsdae_sim *sim, const char *where, double t0, const double *q0,
                          const double *v0)
{
  if (!isfinite(t0))
    return nsdae_error_set(&sim->error, NSDAE_E_NONFINITE, where, "t0",
                           "t0 = %g is not a finite number", t0);
  int status = check_vector(sim, where, "q0", NSDAE_NAME_COORDINATE, q0);
  return status < 0 ? status : check_vector(sim, where, "v0", NSDAE_NAME_VELOCITY, v0);
}

/* Every term once, so that what is wrong with a model shows here. */
static int start_at(nsdae_sim *sim, double t0, const double *q0, const double *v0)
{
  nsdae_result *r = &sim->next->result;
  const nsdae_state state = {.terms = &r->end, .memory = &r->memory};
  nsdae_result_clear(r);
  memset(r->memory.real, 0, r->memory.reals * sizeof *r->memory.real);
  memset(r->memory.whole, 0, r->memory.wholes * sizeof *r->memory.whole);
  r->memory.stamp = r->memory.slots = 0;
  nsdae_stepper_count(&sim->stepper, &state, r);
  nsdae_terms_at(&r->end, 0, q0, v0);
  int status = nsdae_sim_track(sim, &r->end, sim->options.dt);
  if (status == NSDAE_OK) status = nsdae_point_start(sim, sim->next);
  if (status == NSDAE_OK) status = nsdae_units_find(&sim->projection, t0, q0);
  if (status == NSDAE_OK) status = nsdae_start_resolved(sim, &r->end);
  if (status == NSDAE_OK) status = nsdae_initial_check(&sim->projection, &r->end, sim->probe);
  if (status < 0) return status;
  sim->stage.start = sim->error;
  if (status > 0) sim->next->accounts.stats.warnings |= NSDAE_MONITORS_PENETRATION;
  if (nsdae_initial_law(&sim->model, &sim->options, NULL, &sim->stage.start) > 0)
    sim->next->accounts.stats.warnings |= NSDAE_MONITORS_RESTITUTION; /* penalty has no other */
  const nsdae_maker *maker = &sim->system->maker;
  if (sim->stage.start.status == NSDAE_OK && maker->idle && maker->idle(maker->of) &&
      nsdae_largest(sim->system->dims.nv, v0) == 0)
    nsdae_error_set(&sim->stage.start, NSDAE_WARN_MODEL, "nsdae_sim_init", "gravity",
                    "nothing moves: gravity is 0, no body has a velocity, and there is no load, "
                    "spring, motor or drive");
  nsdae_error_clear(&sim->error);
  status = nsdae_initial_touch(sim, &r->end);
  return status > 0 ? nsdae_point_start(sim, sim->next) : status;
}

/* Memory of the sparse factors of Phi_q at the start: no step allocates for them. */
static int reserve_factors(nsdae_sim *sim, const nsdae_terms *start)
{
  nsdae_stepper *s = &sim->stepper;
  if (!(start->have & NSDAE_TERM_JACOBIAN)) return NSDAE_OK;
  int status = nsdae_island_dispatch_reserve(&s->problem.dispatch, start);
  if (status == NSDAE_OK && sim->aside) status = nsdae_kkt_reserve(&s->kkt, &start->by.jacobian);
  return status < 0 ? nsdae_error_memory(&sim->error, "nsdae_sim_init") : NSDAE_OK;
}

NSDAE_SIM_CALL(NSDAE_MOVE, nsdae_sim_init,
               (nsdae_sim * sim, double t0, const double *q0, const double *v0), sim, t0, q0, v0)
{
  nsdae_error_clear(&sim->error);
  sim->stage.started = sim->stage.failed = sim->stage.waiting = sim->stage.between = 0;
  int status = nsdae_sim_check_state(sim, "nsdae_sim_init", t0, q0, v0);
  /* What the callbacks write beyond their arrays or leave out, before anything stands beside them.
   */
  if (status == NSDAE_OK && sim->options.start_check)
    status = nsdae_callback_guard_callbacks(&(nsdae_callback_guard){
        &sim->model, "nsdae_sim_init", t0, q0, v0, sim->probe, &sim->error, 0});
  sim->model.epoch = t0;
  while (status == NSDAE_OK && (status = start_at(sim, t0, q0, v0)) == NSDAE_ARRAYS_GROW)
    status = nsdae_sim_grow(sim);
  if (status == NSDAE_OK)
    status = nsdae_least_reserve(&sim->projection.least, &sim->next->result.end,
                                 sim->projection.contacts.any ? NSDAE_LEAST_NORMALS
                                                              : NSDAE_LEAST_CONSTRAINTS);
  if (status == NSDAE_OK) status = reserve_factors(sim, &sim->next->result.end);
  if (status == NSDAE_OK && sim->method->start)
    status = sim->method->start(sim->own, &sim->next->result.end);
  if (status < 0) return status;
  sim->stage.warning.status = NSDAE_OK;
  nsdae_sim_commit(sim);
  sim->wall_time = 0;
  sim->observers.turn = sim->observers.stop = sim->stage.told = 0;
  sim->stage.started = 1;
  return NSDAE_OK;
}

NSDAE_SIM_CALL(NSDAE_ASK, nsdae_sim_set_interrupt,
               (nsdae_sim * sim, nsdae_interrupt_fn asked, void *user), sim, asked, user)
{
  sim->stepper.interrupt = (nsdae_interrupt){asked, user};
  return NSDAE_OK;
}

NSDAE_SIM_CALL(NSDAE_READ, nsdae_sim_get_record, (const nsdae_sim *sim, nsdae_record *record), sim,
               record)
{
  if (!record) return NSDAE_E_ARGUMENT;
  if (!sim->stage.started) return NSDAE_E_STATE;
  *record = nsdae_sim_shown(sim)->record;
  return NSDAE_OK;
}

NSDAE_SIM_CALL(NSDAE_ASK, nsdae_sim_get_sensor, (nsdae_sim * sim, int i, double *value), sim, i,
               value)
{
  const nsdae_maker *maker = &sim->system->maker;
  const char *where = "nsdae_sim_get_sensor";
  if (!sim->observers.telling) nsdae_error_clear(&sim->error);
  if (!sim->stage.started)
    return nsdae_error_set(&sim->error, NSDAE_E_STATE, where, "",
                           "the simulation has no state: call nsdae_sim_init first");
  if (!value)
    return nsdae_error_set(&sim->error, NSDAE_E_ARGUMENT, where, "value", "value is NULL");
  if (i < 0 || i >= maker->sensors.count)
    return nsdae_error_set(&sim->error, NSDAE_E_ARGUMENT, where, "i",
                           "i = %d is outside its range: there are %d sensors", i,
                           maker->sensors.count);
  const nsdae_point *shown = nsdae_sim_shown(sim);
  maker->sensors.sense(maker->of, i, &shown->record, shown->result.impulses.linear, shown->angle,
                       value);
  return NSDAE_OK;
}

NSDAE_SIM_CALL(NSDAE_ASK, nsdae_sim_get_contact_forces,
               (nsdae_sim * sim, double *point, double *force), sim, point, force)
{
  const nsdae_maker *maker = &sim->system->maker;
  const char *where = "nsdae_sim_get_contact_forces", *missing = point ? "force" : "point";
  if (!sim->observers.telling) nsdae_error_clear(&sim->error);
  if (!sim->stage.started)
    return nsdae_error_set(&sim->error, NSDAE_E_STATE, where, "",
                           "the simulation has no state: call nsdae_sim_init first");
  const nsdae_point *shown = nsdae_sim_shown(sim);
  const nsdae_record *record = &shown->record;
  if (record->contacts.count > 0 && (!point || !force))
    return nsdae_error_set(&sim->error, NSDAE_E_ARGUMENT, where, missing, "%s is NULL", missing);
  if (!maker->sensors.contact_forces)
    return nsdae_error_set(&sim->error, NSDAE_E_ARGUMENT, where, "sim",
                           "the system of sim has no solids: nsdae_bodies_system makes such a one");
  maker->sensors.contact_forces(maker->of, record, shown->result.impulses.linear, point, force);
  return NSDAE_OK;
}

NSDAE_SIM_CALL(NSDAE_READ, nsdae_sim_get_failed_lcp,
               (const nsdae_sim *sim, nsdae_lcp_problem *problem), sim, problem)
{
  if (!problem) return NSDAE_E_ARGUMENT;
  const nsdae_contacts *c = sim->next->result.problem;
  if (!sim->stage.failed || !c) return NSDAE_E_STATE;
  if (nsdae_cones_any(c)) return NSDAE_E_STATE; /* see nsdae_sim_get_friction */
  *problem = (nsdae_lcp_problem){.n = c->rows, .A = c->lcp.A, .lda = c->rows, .b = c->lcp.b};
  return NSDAE_OK;
}

NSDAE_SIM_CALL(NSDAE_ASK, nsdae_sim_get_friction, (nsdae_sim * sim, nsdae_step_friction *friction),
               sim, friction)
{
  if (!friction) return NSDAE_E_ARGUMENT;
  if (!sim->stage.started) return NSDAE_E_STATE;
  const nsdae_point *last = sim->stage.failed ? sim->next : sim->now;
  return nsdae_problem_describe(&sim->stepper.problem, last->result.problem, last->result.single,
                                last->result.cones, friction);
}

NSDAE_SIM_CALL(NSDAE_READ, nsdae_sim_get_stats, (const nsdae_sim *sim, nsdae_stats *stats), sim,
               stats)
{
  if (!stats) return NSDAE_E_ARGUMENT;
  *stats = nsdae_sim_shown(sim)->accounts.stats;
  stats->wall_time = sim->wall_time;
  stats->contact_capacity = (int)sim->lists.contacts.entries;
  stats->contact_growths = sim->lists.growths;
  return NSDAE_OK;
}

int nsdae_sim_get_dims(const nsdae_sim *sim, nsdae_dims *dims)
{
  if (!sim || !dims) return NSDAE_E_ARGUMENT;
  *dims = sim->system->dims;
  return NSDAE_OK;
}

int nsdae_sim_has_potential(const nsdae_sim *sim)
{
  return sim && sim->system->call.potential;
}

NSDAE_SIM_CALL(NSDAE_READ, nsdae_sim_get_options,
               (const nsdae_sim *sim, nsdae_sim_options *options), sim, options)
{
  if (!options) return NSDAE_E_ARGUMENT;
  *options = sim->options;
  return NSDAE_OK;
}

const nsdae_error *nsdae_sim_error(const nsdae_sim *sim)
{
  static const nsdae_error none = {
      .status = NSDAE_E_ARGUMENT,
      .index = -1,
      .time = NAN,
      .argument = "sim",
      .where = "nsdae_sim_error",
      .text = "there is no simulation: it was not made (the last argument of nsdae_sim_create says "
              "why), or it was destroyed"};
  if (!sim) return &none;
  const nsdae_error *refusal = nsdae_refusal_of(sim);
  return refusal ? refusal : &sim->error;
}

const nsdae_system *nsdae_sim_get_system(const nsdae_sim *sim)
{
  return sim ? sim->system : NULL;
}

const char *nsdae_method_name(int method)
{
  const nsdae_stepping *named = nsdae_stepping_of(method);
  return named ? named->name : NULL;
}

const char *nsdae_method_summary(int method)
{
  const nsdae_stepping *named = nsdae_stepping_of(method);
  return named ? named->summary : NULL;
}
