/* The state as one block of bytes:
 *
 *   head      magic, byte order, version, size, checksum (FNV-1a over the rest), dims, method
 *   settings  every option that matters to the method, in the order of their table, as doubles;
 *             mu, e_N, e_T of the contacts, mu of the frictional joints
 *   epoch     t0 of the run, from which its times count
 *   accounts  number of the step, grid, work of contacts and forces, certificate, statistics but
 *             for the clock
 *   state     t, q, v, what is evaluated there; multipliers, impulses and modes of the last step
 *             (contact list: of the closed contacts, with their ids, blocks and gaps); angles of
 *             sensors with their turns
 *   memory    what the method keeps: its numbers, its integers (tracked contacts: of the slots up
 *             to the last that is used, so that it does not depend on the room)
 *   units     groups of coordinates of constant length, their lengths (where nv < nq)
 *   controls  targets of motors
 *
 * One function visits all of it, to measure, to write, to read and to compare, so that the layout
 * is written once. Nothing of a block is believed before its checksum, sizes and settings are
 * right, and nothing of the simulation changes before all of it was read and the terms of the
 * record were evaluated there. */
#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include "errors.h"
#include "listed.h"
#include "sim_impl.h"
#include "vector.h"

typedef struct head {
  char magic[8];
  uint32_t byte_order, version;
  uint64_t size, checksum;
  uint64_t reals, wholes;
  int32_t dims[6], method;
  int32_t closed; /* contacts of the list */
  int32_t slots;  /* whose memory is there: those that are used */
  int32_t controls, angles, none;
} head;

enum {
  OF_SLOTS = NSDAE_TERM_GAP | NSDAE_TERM_NORMAL | NSDAE_TERM_TANGENT | NSDAE_TERM_BIAS |
             NSDAE_TERM_ACCELERATION | NSDAE_TERM_CONTACTS
};

static const char MAGIC[8] = "nsdaest";
enum { BYTE_ORDER_MARK = 0x01020304, BLOCK_VERSION = 7 };

/* A place in a block: nothing is moved where both are NULL. Arrays may be NULL where they are
 * empty. */
typedef struct cursor {
  char *to;
  const char *from;
  size_t at;
} cursor;

static void visit(cursor *c, void *data, size_t bytes)
{
  if (bytes == 0) return;
  if (c->to) memcpy(c->to + c->at, data, bytes);
  if (c->from) memcpy(data, c->from + c->at, bytes);
  c->at += bytes;
}

/* long has 32 bits on some systems. */
static void visit_longs(cursor *c, long *a, int n)
{
  for (int i = 0; i < n; i++) {
    int64_t wide = c->to ? a[i] : 0;
    visit(c, &wide, sizeof wide);
    if (c->from) a[i] = (long)wide;
  }
}

static void visit_doubles(cursor *c, double *a, int n)
{
  visit(c, a, (size_t)n * sizeof *a);
}

static void visit_ints(cursor *c, int *a, int n)
{
  visit(c, a, (size_t)n * sizeof *a);
}

static void visit_certificate(cursor *c, nsdae_certificate *certificate)
{
  _Static_assert(sizeof *certificate == 10 * sizeof(double) + 6 * sizeof(int),
                 "padding of a certificate, which the state would keep");
  visit(c, certificate, sizeof *certificate);
}

/* Without the padding of the structs, so that equal states are equal bytes. */
static void visit_stats(cursor *c, nsdae_stats *s)
{
  long *const counts[] = {&s->steps,          &s->smooth_steps,
                          &s->contact_steps,  &s->lcps,
                          &s->lcp_pivots,     &s->iterations,
                          &s->mass_evals,     &s->force_evals,
                          &s->jacobian_evals, &s->impacts,
                          &s->events,         &s->accumulations,
                          &s->fallback_steps, &s->accumulations_early,
                          &s->frozen_steps,   &s->inexact_steps};
  double *const worst[] = {&s->worst_residual,    &s->contact_tol,   &s->worst_drift,
                           &s->worst_penetration, &s->energy_start,  &s->energy_balance,
                           &s->rank_retained,     &s->rank_discarded};
  /* all of them, and the clock; room in lists is the simulation's */
  _Static_assert(sizeof *s - sizeof counts / sizeof *counts * sizeof(long) -
                         sizeof worst / sizeof *worst * sizeof(double) - 7 * sizeof(int) -
                         sizeof s->wall_time - sizeof s->certificate <
                     sizeof(double),
                 "a statistic that the state does not keep");
  for (size_t i = 0; i < sizeof counts / sizeof *counts; i++) visit_longs(c, counts[i], 1);
  for (size_t i = 0; i < sizeof worst / sizeof *worst; i++) visit(c, worst[i], sizeof(double));
  visit(c, &s->rank, sizeof s->rank);
  visit(c, &s->rank_most, sizeof s->rank_most);
  visit(c, &s->warnings, sizeof s->warnings);
  visit(c, &s->islands, sizeof s->islands);
  visit(c, &s->island_contacts, sizeof s->island_contacts);
  visit_certificate(c, &s->certificate);
}

/* Contacts of the list, and the reach within which the next step finds them. */
static void visit_closed(cursor *c, nsdae_result *r, unsigned have)
{
  nsdae_closed *closed = &r->closed;
  int k = closed->count;
  int kept = (have & NSDAE_TERM_CONTACTS) && !r->end.system->tracked;
  double reach = kept ? r->end.by.reach : 0;
  visit_doubles(c, &reach, 1);
  if (c->from) r->end.by.reach = reach;
  visit_longs(c, closed->id, k);
  visit_ints(c, closed->block, 2 * k);
  visit_ints(c, closed->fresh, k);
  visit_ints(c, closed->basis, closed->rows * k);
  visit_ints(c, r->impulses.mode, k);
  visit_doubles(c, closed->gap, k);
  visit_doubles(c, r->impulses.normal, k);
  visit_doubles(c, r->impulses.tangential, k * closed->nt);
}

/* ---- memory of slots */

static int slots_of(const nsdae_sim *sim, const nsdae_point *p)
{
  return sim->model.tracked ? p->result.memory.slots : sim->model.dims.k;
}

/* Of this number of slots, in the arrays of a point that is not in use. */
static nsdae_memory memory_for(const nsdae_sim *sim, int slots)
{
  nsdae_memory m = sim->next->result.memory;
  nsdae_memory_part part = {.slots = (size_t)slots};
  sim->method->lay(&sim->stepper, &part);
  if (sim->aside) m = sim->aside->result.memory;
  m.reals = part.reals;
  m.wholes = part.wholes;
  return m;
}

/* have: which terms the next step finds there. */
static void visit_point(cursor *c, nsdae_point *p, double *epoch, double *t, unsigned *have)
{
  nsdae_result *r = &p->result;
  nsdae_accounts *a = &p->accounts;
  nsdae_dims dims = r->end.system->dims, *d = &dims;
  int tracked = r->end.system->tracked != NULL;
  if (tracked) d->k = 0;
  _Static_assert(sizeof *a - 2 * sizeof(long) - 3 * sizeof(double) - sizeof a->stats -
                         sizeof a->watch <
                     sizeof(double),
                 "an account that the state does not keep");
  visit_doubles(c, epoch, 1);
  visit_longs(c, &a->step, 1);
  visit_longs(c, &a->grid_count, 1);
  visit_doubles(c, &a->grid_start, 1);
  visit_doubles(c, &a->dissipated, 1);
  visit_doubles(c, &a->raised, 1);
  visit_stats(c, &a->stats);
  visit(c, &a->watch, sizeof a->watch);
  visit(c, &p->work, sizeof p->work);
  visit_certificate(c, &p->record.certificate);
  visit_doubles(c, t, 1);
  visit_doubles(c, r->end.q, d->nq);
  visit_doubles(c, r->end.v, d->nv);
  visit_doubles(c, &r->worst_residual, 1);
  visit_doubles(c, &r->contact_tol, 1);
  visit(c, have, sizeof *have);
  visit_doubles(c, r->multiplier, d->m);
  visit_doubles(c, r->impulses.normal, d->k);
  for (int l = 0; l < d->nt; l++)
    visit_doubles(c, r->impulses.tangential + (size_t)l * (size_t)d->k, d->k);
  visit_doubles(c, r->impulses.frictional_joint_impulse, d->f);
  visit_ints(c, r->impulses.mode, d->k);
  visit_ints(c, r->impulses.frictional_joint_mode, d->f);
  if (tracked || nsdae_terms_most(r->end.system) == NSDAE_ANY_NUMBER) visit_closed(c, r, *have);
  visit_doubles(c, p->angle, r->end.system->maker.sensors.angles);
  visit(c, r->memory.real, r->memory.reals * sizeof(double));
  visit(c, r->memory.whole, r->memory.wholes * sizeof(int));
}

static void visit_units(cursor *c, const nsdae_dims *d, nsdae_units *units)
{
  if (d->nq == d->nv) return;
  visit_ints(c, &units->count, 1);
  visit_ints(c, units->of, d->nq);
  visit_doubles(c, units->length, d->nq);
}

/* The i-th setting: an option, a coefficient. 0 past the last. */
typedef struct setting {
  const char *name;
  int kind, index; /* of the contact or frictional joint, -1: an option */
  int matters;
  double value;
} setting;

static int setting_at(const nsdae_sim *sim, int i, setting *s)
{
  static const char *const coefficients[] = {"mu", "e_N", "e_T"};
  const nsdae_params *table = nsdae_sim_options_table();
  const nsdae_dims *d = &sim->system->dims;
  if (i < table->n) {
    const nsdae_param *p = &table->entry[i];
    *s = (setting){p->key, -1, -1, nsdae_sim_option_matters(p->key, sim->options.method),
                   nsdae_sim_option_value(&sim->options, p)};
    return 1;
  }
  i -= table->n;
  if (i < 3 * d->k) {
    const nsdae_coefficients *c = &sim->model.contact[i / 3];
    const double values[] = {c->mu, c->e_n, c->e_t};
    *s = (setting){coefficients[i % 3], NSDAE_NAME_CONTACT, i / 3, 1, values[i % 3]};
    return 1;
  }
  i -= 3 * d->k;
  if (i >= 2 * d->f) return 0;
  const nsdae_frictional_joint *joint = &sim->model.frictional_joint[i / 2];
  *s = (setting){i % 2 ? "bound" : "mu", NSDAE_NAME_FRICTIONAL_JOINT, i / 2, 1,
                 i % 2 ? joint->bound : joint->mu};
  return 1;
}

static void visit_controls(cursor *c, const nsdae_sim *sim)
{
  visit_doubles(c, sim->control.value, sim->system->maker.controls);
}

static void visit_settings(cursor *c, const nsdae_sim *sim)
{
  setting s;
  for (int i = 0; setting_at(sim, i, &s); i++) visit_doubles(c, &s.value, 1);
}

static int check_settings(nsdae_sim *sim, cursor *c)
{
  setting s;
  for (int i = 0; setting_at(sim, i, &s); i++) {
    double theirs = 0;
    char of[NSDAE_CALLED_SIZE + 4] = "", called[NSDAE_CALLED_SIZE];
    visit_doubles(c, &theirs, 1);
    if (!s.matters || theirs == s.value) continue;
    if (s.index >= 0)
      snprintf(of, sizeof of, " of %s", nsdae_system_called(sim->system, s.kind, s.index, called));
    nsdae_error_set(&sim->error, NSDAE_E_ARGUMENT, "nsdae_sim_set_state", s.name,
                    "%s%s is %.17g here and %.17g in the block: a state requires the same settings",
                    s.name, of, s.value, theirs);
    return nsdae_error_at(&sim->error, NSDAE_E_ARGUMENT, s.index, NAN);
  }
  return NSDAE_OK;
}

static head make_head(const nsdae_sim *sim, size_t size, int slots)
{
  const nsdae_dims *d = &sim->system->dims;
  const nsdae_memory memory = memory_for(sim, slots), *m = &memory;
  head h = {.byte_order = BYTE_ORDER_MARK,
            .version = BLOCK_VERSION,
            .size = size,
            .reals = m->reals,
            .wholes = m->wholes,
            .dims = {d->nq, d->nv, d->m, d->k, d->nt, d->f},
            .method = sim->options.method,
            .closed = nsdae_sim_shown(sim)->result.closed.count,
            .slots = slots,
            .controls = sim->system->maker.controls,
            .angles = sim->system->maker.sensors.angles};
  memcpy(h.magic, MAGIC, sizeof h.magic);
  return h;
}

/* FNV-1a, 64 bits. */
static uint64_t checksum(const char *bytes, size_t n)
{
  uint64_t sum = UINT64_C(14695981039346656037);
  for (size_t i = 0; i < n; i++) sum = (sum ^ (unsigned char)bytes[i]) * UINT64_C(1099511628211);
  return sum;
}

/* Of the whole block but the place of the checksum itself. */
static uint64_t checksum_of(const char *block, size_t size)
{
  size_t at = offsetof(head, checksum), after = at + sizeof(uint64_t);
  return checksum(block, at) ^ checksum(block + after, size - after);
}

/* With this number of listed contacts and of slots. */
static size_t state_bytes(const nsdae_sim *sim, int closed, int slots)
{
  nsdae_point measured = *sim->now;
  cursor c = {0};
  unsigned have = 0;
  double epoch = 0, t = 0;
  c.at = sizeof(head);
  measured.result.closed.count = closed;
  measured.result.memory = memory_for(sim, slots);
  visit_settings(&c, sim);
  visit_point(&c, &measured, &epoch, &t, &have);
  visit_units(&c, &sim->system->dims, &(nsdae_units){0});
  visit_controls(&c, sim);
  return c.at;
}

NSDAE_SIM_CALL(NSDAE_READ, nsdae_sim_state_size, (const nsdae_sim *sim, size_t *size), sim, size)
{
  if (!size) return NSDAE_E_ARGUMENT;
  const nsdae_point *shown = nsdae_sim_shown(sim);
  *size = state_bytes(sim, shown->result.closed.count, slots_of(sim, shown));
  return NSDAE_OK;
}

static int check_size(nsdae_sim *sim, const char *where, const void *block, size_t size, int closed,
                      int slots)
{
  size_t needed = state_bytes(sim, closed, slots);
  if (!block)
    return nsdae_error_set(&sim->error, NSDAE_E_ARGUMENT, where, "block", "block is NULL");
  if (size == needed) return NSDAE_OK;
  return nsdae_error_set(&sim->error, NSDAE_E_ARGUMENT, where, "size",
                         "size = %zu bytes, and a state of this simulation has %zu "
                         "(nsdae_sim_state_size)",
                         size, needed);
}

NSDAE_SIM_CALL(NSDAE_ASK, nsdae_sim_get_state, (nsdae_sim * sim, void *block, size_t size), sim,
               block, size)
{
  if (!sim->observers.telling) nsdae_error_clear(&sim->error);
  if (!sim->stage.started)
    return nsdae_error_set(&sim->error, NSDAE_E_STATE, "nsdae_sim_get_state", "",
                           "the simulation has no state: call nsdae_sim_init first");
  nsdae_point shown = *nsdae_sim_shown(sim); /* what is visited is not changed */
  int slots = slots_of(sim, &shown);
  int status =
      check_size(sim, "nsdae_sim_get_state", block, size, shown.result.closed.count, slots);
  if (status < 0) return status;
  if (sim->model.tracked) {
    nsdae_memory packed = memory_for(sim, slots);
    nsdae_sim_carry_memory(sim, &shown.result.memory, sim->model.dims.k, &packed, slots);
    shown.result.memory = packed;
  }
  if (!(shown.result.end.have & NSDAE_TERM_CONTACTS))
    shown.result.end.by.reach = 0; /* of no list */
  double epoch = sim->model.epoch, t = shown.result.end.t;
  unsigned have = shown.result.end.have;
  if (sim->model.tracked) have &= ~(unsigned)OF_SLOTS; /* the next step asks the list */
  head h = make_head(sim, size, slots);
  cursor c = {.to = block};
  visit(&c, &h, sizeof h);
  visit_settings(&c, sim);
  visit_point(&c, &shown, &epoch, &t, &have);
  visit_units(&c, &sim->system->dims, &sim->projection.units);
  visit_controls(&c, sim);
  h.checksum = checksum_of(block, size);
  memcpy(block, &h, sizeof h);
  return NSDAE_OK;
}

static int refuse_state(nsdae_sim *sim, const char *argument, const char *what)
{
  return nsdae_error_set(&sim->error, NSDAE_E_ARGUMENT, "nsdae_sim_set_state", argument, "%s",
                         what);
}

static int check_dims(nsdae_sim *sim, const head *theirs, const head *ours)
{
  static const char *const names[] = {"nq", "nv", "m", "k", "nt", "f"};
  for (int i = 0; i < 6; i++)
    if (theirs->dims[i] != ours->dims[i])
      return nsdae_error_set(&sim->error, NSDAE_E_ARGUMENT, "nsdae_sim_set_state", names[i],
                             "%s is %d here and %d in the block: it is of another system", names[i],
                             ours->dims[i], theirs->dims[i]);
  if (theirs->controls != ours->controls || theirs->angles != ours->angles)
    return nsdae_error_set(&sim->error, NSDAE_E_ARGUMENT, "nsdae_sim_set_state", "controls",
                           "the system has %d controls and %d sensors that count turns here, and "
                           "%d, %d in the block: it is of another system",
                           ours->controls, ours->angles, theirs->controls, theirs->angles);
  if (theirs->method != ours->method) {
    const char *name = nsdae_method_name(theirs->method);
    return nsdae_error_set(&sim->error, NSDAE_E_ARGUMENT, "nsdae_sim_set_state", "method",
                           "the method is %s here and %s in the block",
                           nsdae_method_name(ours->method), name ? name : "unknown");
  }
  return NSDAE_OK;
}

/* What the block says of itself. */
static int check_head(nsdae_sim *sim, const char *block, size_t size)
{
  head h, ours = make_head(sim, size, 0);
  if (size < sizeof h) return refuse_state(sim, "size", "the block is shorter than its header");
  memcpy(&h, block, sizeof h);
  if (memcmp(h.magic, MAGIC, sizeof h.magic) != 0)
    return refuse_state(sim, "block",
                        "the block is no state of a simulation (nsdae_sim_get_state)");
  if (h.byte_order != ours.byte_order)
    return refuse_state(sim, "block", "the state is of a machine with another byte order");
  if (h.version != ours.version)
    return refuse_state(sim, "block", "the state is of another version of this library");
  int status = check_dims(sim, &h, &ours);
  if (status < 0) return status;
  int tracked = sim->model.tracked != NULL;
  int most = tracked ? nsdae_sim_most_slots(sim) : sim->options.contacts_max;
  if (h.closed < 0 || h.closed > most || (h.closed > 0 && !sim->system->call.contacts) ||
      h.slots < 0 || (tracked ? h.slots > most : h.slots != sim->model.dims.k))
    return refuse_state(sim, "block",
                        "the state has an invalid number of contacts in the contact list");
  ours = make_head(sim, size, h.slots);
  if (h.size != size || h.reals != ours.reals || h.wholes != ours.wholes ||
      size != state_bytes(sim, h.closed, h.slots))
    return check_size(sim, "nsdae_sim_set_state", block, size, h.closed, h.slots) < 0
               ? NSDAE_E_ARGUMENT
               : refuse_state(sim, "size", "the state is of a system of other sizes");
  if (h.checksum != checksum_of(block, size))
    return refuse_state(sim, "block", "the state is damaged: its checksum differs");
  return NSDAE_OK;
}

/* Infinite is allowed: nothing yet happened. */
static int any_nan(const double *a, size_t n)
{
  for (size_t i = 0; i < n; i++)
    if (isnan(a[i])) return 1;
  return 0;
}

static int are_finite(const double *a, int n)
{
  return nsdae_all_finite((size_t)n, a);
}

/* What was read into next. */
static int check_values(nsdae_sim *sim)
{
  const nsdae_point *p = sim->next;
  const nsdae_result *r = &p->result;
  const nsdae_dims *d = &sim->system->dims;
  const nsdae_stats *s = &p->accounts.stats;
  const nsdae_certificate *c = &p->record.certificate;
  const double sums[] = {nsdae_terms_time(&r->end),
                         p->accounts.grid_start,
                         p->accounts.dissipated,
                         p->accounts.raised,
                         p->work.sum,
                         s->energy_start,
                         s->energy_balance,
                         c->energy,
                         c->work,
                         c->unexplained};
  const double certificate[] = {
      r->worst_residual, r->contact_tol,       s->worst_residual, s->contact_tol,
      s->worst_drift,    s->worst_penetration, c->pull,           c->cone_excess,
      c->penetration,    c->constraint_rate,   c->complementarity};
  /* the listed contacts */
  int count = r->closed.count, right = count == 0 || r->end.by.reach >= 0;
  for (int i = 0; i < 2 * count; i++)
    right &= r->closed.block[i] >= -1 && r->closed.block[i] < sim->system->blocks.count;
  if (count > 0)
    right &= are_finite(r->impulses.normal, count) && are_finite(r->closed.gap, count) &&
             are_finite(r->impulses.tangential, count * r->closed.nt);
  if (right && are_finite(sums, (int)(sizeof sums / sizeof *sums)) && are_finite(r->end.q, d->nq) &&
      are_finite(r->end.v, d->nv) && are_finite(r->multiplier, d->m) &&
      are_finite(r->impulses.normal, d->k) && are_finite(r->impulses.tangential, d->k * d->nt) &&
      are_finite(r->impulses.frictional_joint_impulse, d->f) &&
      !any_nan(certificate, sizeof certificate / sizeof *certificate) &&
      !any_nan(r->memory.real, r->memory.reals) &&
      are_finite(sim->control.value, sim->system->maker.controls) &&
      are_finite(p->angle, sim->system->maker.sensors.angles))
    return NSDAE_OK;
  return nsdae_error_set(&sim->error, NSDAE_E_NONFINITE, "nsdae_sim_set_state", "block",
                         "the state has a number that is not finite");
}

/* Reads the block into next, with the terms that the next step is to find; and its epoch. */
static int read_block(nsdae_sim *sim, const void *block)
{
  nsdae_point *p = sim->next;
  nsdae_result *r = &p->result;
  const nsdae_state state = {.terms = &r->end, .memory = &r->memory};
  cursor c = {.from = block, .at = sizeof(head)};
  unsigned have = 0;
  head h;
  memcpy(&h, block, sizeof h);
  nsdae_result_clear(r);
  r->closed.count = h.closed;
  int status = check_settings(sim, &c), k = sim->model.dims.k;
  nsdae_memory all = r->memory;
  if (sim->model.tracked) r->memory = memory_for(sim, h.slots);
  visit_point(&c, p, &sim->model.epoch, &r->end.t, &have);
  if (sim->model.tracked) {
    nsdae_sim_carry_memory(sim, &r->memory, h.slots, &all, k);
    r->memory = all;
    r->memory.slots = h.slots;
    memset(sim->tracked.used, 0, (size_t)k * sizeof *sim->tracked.used); /* until it goes on */
  }
  visit_units(&c, &sim->system->dims, &sim->projection.other);
  visit_controls(&c, sim);
  r->memory.stamp = p->accounts.step == 0 ? 0 : -1; /* all zero before the first */
  nsdae_terms_forget(&r->end);
  if (status == NSDAE_OK) status = check_values(sim);
  if (status == NSDAE_OK && sim->method->check && sim->method->check(sim->own, &r->memory) < 0)
    status = refuse_state(sim, "block", "the state has an invalid number of steps, slot or block");
  nsdae_stepper_count(&sim->stepper, &state, r);
  if (status == NSDAE_OK) status = nsdae_point_show(p, have);
  if (sim->model.tracked) nsdae_terms_forget_slots(&r->end);
  return status;
}

NSDAE_SIM_CALL(NSDAE_MOVE, nsdae_sim_set_state, (nsdae_sim * sim, const void *block, size_t size),
               sim, block, size)
{
  nsdae_error_clear(&sim->error);
  int status = block ? check_head(sim, block, size) : refuse_state(sim, "block", "block is NULL");
  if (status < 0) return status;
  sim->stage.waiting = sim->stage.between = 0;
  double epoch = sim->model.epoch;
  size_t controls = (size_t)sim->system->maker.controls * sizeof *sim->control.value;
  if (controls > 0) memcpy(sim->control.before, sim->control.value, controls);
  /* Room for the listed contacts of the block; of tracked ones as many as slots. */
  head h;
  memcpy(&h, block, sizeof h);
  int tracked = sim->model.tracked != NULL, slots = h.slots;
  if (tracked && h.closed > slots) slots = h.closed;
  const nsdae_room contacts = {(size_t)h.closed, 0}, rows = {0};
  if (!tracked && (size_t)h.closed > sim->lists.contacts.entries)
    status = nsdae_sim_make_room(sim, &contacts, &rows);
  if (status == NSDAE_OK && slots > sim->model.dims.k) status = nsdae_sim_make_slots(sim, slots);
  while (status == NSDAE_OK && (status = read_block(sim, block)) == NSDAE_ARRAYS_GROW)
    status = nsdae_sim_grow(sim);
  if (status == NSDAE_OK && sim->method->start)
    status = sim->method->start(sim->own, &sim->next->result.end);
  if (status < 0) {
    sim->model.epoch = epoch;
    if (controls > 0) memcpy(sim->control.value, sim->control.before, controls);
    return status;
  }
  nsdae_sim_commit(sim);
  nsdae_units *units = &sim->projection.units, *other = &sim->projection.other;
  size_t nq = (size_t)sim->system->dims.nq;
  units->count = other->count;
  memcpy(units->of, other->of, nq * sizeof *units->of);
  memcpy(units->length, other->length, nq * sizeof *units->length);
  sim->stage.started = sim->stage.told = 1;
  sim->stage.failed = 0;
  sim->stage.warning.status = sim->stage.start.status = NSDAE_OK;
  sim->observers.turn = sim->observers.stop = 0;
  return NSDAE_OK;
}
