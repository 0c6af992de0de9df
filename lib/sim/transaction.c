/* Steps: a method fills the next point from the state, which is committed here, or dropped. */
#include <math.h>
#include <string.h>

#include "clock.h"
#include "errors.h"
#include "listed.h"
#include "sim_impl.h"

void nsdae_sim_commit(nsdae_sim *sim)
{
  nsdae_point *old = sim->now;
  sim->now = sim->next;
  sim->next = old;
  sim->stage.between = sim->stage.waiting;
  sim->stage.waiting = 0;
}

/* Times come from the grid, not from adding dt up. */
static double grid_time(const nsdae_sim *sim, long ahead)
{
  const nsdae_accounts *a = &sim->now->accounts;
  return a->grid_start + (double)(a->grid_count + ahead) * sim->options.dt;
}

/* What a time may be off the grid, as the end of a run that is as good as on it. */
static double hair(const nsdae_sim *sim)
{
  return 1e-9 * sim->options.dt;
}

/* A rest of the run shorter than this share of dt is part of the step before it, as SUNDIALS joins
 * a tstop within 100 eps |t|. A sum of n steps in t_end is off by up to n eps |t| / 2, which any
 * multiple of eps |t| falls below; a step that is longer by the share r has an error larger by
 * (1 + r)^3 - 1 = 3 r, here 0.3 %. */
static const double NO_STEP = 1e-3;

/* Of the step from the state to t1. On the grid it is dt, whatever the difference of two rounded
 * times is: so a body at a fixed point of the step stays there at all times. */
static double length_of(const nsdae_sim *sim, double t1)
{
  double t0 = sim->now->result.end.t, most = hair(sim);
  int whole = fabs(t0 - grid_time(sim, 0)) <= most && fabs(t1 - grid_time(sim, 1)) <= most;
  return whole ? sim->options.dt : t1 - t0;
}

/* The method's step; where it gives up, implicit's from the same state. */
static int advance_method(nsdae_sim *sim, double t1, double length)
{
  nsdae_result *result = &sim->next->result;
  const nsdae_memory *memory = &sim->now->result.memory;
  const nsdae_state state = {&sim->now->result.end,         memory,
                             &sim->now->result.closed,      &sim->now->result.impulses,
                             sim->now->accounts.grid_start, length};
  nsdae_result_begin(result, sim->method->closes);
  nsdae_memory_copy(&result->memory, memory);
  nsdae_stepper_count(&sim->stepper, &state, result);
  int status = sim->method->advance(sim->own, &state, t1, result);
  if (status < 0 || !result->given_up) return status;
  nsdae_counters spent = result->counters;
  nsdae_result_clear(result);
  result->counters = spent;
  result->counters.events = result->counters.accumulations = 0;
  result->counters.fallbacks = 1;
  nsdae_memory_copy(&result->memory, memory);
  result->memory.stamp = -1;
  status = nsdae_sim_track(sim, state.terms, length);
  if (status < 0) return status;
  return nsdae_stepping_implicit.advance(&sim->stepper, &state, t1, result);
}

static int energy(nsdae_terms *T, double *value)
{
  int status = nsdae_terms_need(T, NSDAE_TERM_MASS | NSDAE_TERM_POTENTIAL);
  *value = nsdae_terms_energy(T, T->v) + T->potential;
  return status;
}

/* The closed contacts of a list at the end of the step: twice the way of the fastest. */
static int list_closed(nsdae_sim *sim, double length)
{
  nsdae_result *r = &sim->next->result;
  double fastest = 0;
  if (r->closed.count == 0) return NSDAE_OK;
  for (int a = 0; a < r->closed.count; a++)
    fastest = fmax(fastest, fmax(fabs(r->impulses.before[a]), fabs(r->impulses.after[a])));
  sim->projection.contacts.reach = nsdae_terms_touch(&r->end) + 2 * length * fastest;
  return nsdae_problem_update(&sim->stepper.problem, &r->end, sim->projection.contacts.reach);
}

/* Gap of closed contact i at the begin of the step; of a list, one that it does not name is open.
 */
static double gap_before(const nsdae_sim *sim, int i)
{
  const nsdae_terms *start = &sim->now->result.end;
  if (sim->system->dims.k > 0) return start->gap[i];
  int entry = nsdae_ids_find(&sim->projection.contacts.ids, sim->next->result.closed.id[i]);
  return entry < 0 ? INFINITY : start->by.list.gap[entry];
}

/* Which contacts that were closed in the step are moved, and how deep they may be. With depths, one
 * that is found in it stays where it was found. That it sinks in from there is Newton's law: on a
 * surface of radius r the normal turns, so that it comes at u = -h v^2 / r and leaves at -e_N u,
 * and gets h (1 - e_N) |u| / 2 deeper. */
static int choose_contacts(nsdae_sim *sim, double length)
{
  nsdae_result *r = &sim->next->result;
  nsdae_terms *start = &sim->now->result.end;
  nsdae_projected *c = &sim->projection.contacts;
  int lasting = sim->options.projection == NSDAE_PROJECTION_DEPTHS;
  int fixed = sim->system->dims.k, by_id = lasting && r->closed.count > 0;
  int status = nsdae_terms_need(&r->end, NSDAE_TERM_GAP);
  nsdae_projector_clear(&sim->projection);
  if (!c->any) return status;
  if (status == NSDAE_OK) status = list_closed(sim, length);
  if (status == NSDAE_OK && by_id) status = nsdae_terms_contacts(start, nsdae_terms_touch(start));
  if (status < 0) return status;
  if (by_id) nsdae_ids_fill(&c->ids, start->by.list.count, start->by.list.id);
  for (int i = 0; i < fixed + r->closed.count; i++) {
    double gap = lasting ? gap_before(sim, i) : 0, depth = fmin(gap, 0);
    int chosen = r->impulses.mode[i] != NSDAE_MODE_OPEN && r->end.gap[i] < depth && !(gap > 0);
    if (fixed > 0) c->depth[i] = depth;
    if (fixed > 0) c->closed[i] = chosen;
    if (fixed > 0 || !chosen) continue;
    c->id[c->kept] = r->closed.id[i];
    c->id_depth[c->kept++] = depth;
  }
  return NSDAE_OK;
}

static int has_loaded_joints(const nsdae_system *s)
{
  int any = 0;
  for (int j = 0; j < s->dims.f; j++)
    any |= s->frictional_joint[j].rows > 0 || s->frictional_joint[j].mu > 0;
  return any;
}

/* Velocities of the new place. With moreau they are those of the middle of the step, and the
 * impulse of this projection is half of that which turns them: it is part of the mean force of the
 * step. Velocities stay if friction needs all of that force. */
static int project_velocities(nsdae_sim *sim, double length)
{
  nsdae_result *r = &sim->next->result;
  if (has_loaded_joints(sim->system)) return NSDAE_OK;
  int status = nsdae_project_velocities(&sim->projection, &r->end);
  for (int i = 0; i < sim->system->dims.m && status == NSDAE_OK; i++)
    r->multiplier[i] += sim->projection.least.c[i] / length;
  return status;
}

/* The option projection, of the time-stepping methods: the end of the step is moved to the
 * constraints, and the contacts that were closed in it to touching, or to the depth that they had;
 * what that does to the energy is work on the system. */
static int project(nsdae_sim *sim, double length)
{
  nsdae_result *r = &sim->next->result;
  nsdae_projector *p = &sim->projection;
  double before, moved = 0, after = 0;
  int status = energy(&r->end, &before);
  if (status == NSDAE_OK) status = choose_contacts(sim, length);
  if (status == NSDAE_OK) status = nsdae_project_positions(p, &r->end, 0);
  if (status == NSDAE_OK && p->contacts.any) status = list_closed(sim, length);
  if (status == NSDAE_OK) status = energy(&r->end, &moved);
  if (status == NSDAE_OK) status = project_velocities(sim, length);
  if (status == NSDAE_OK) status = energy(&r->end, &after);
  if (status < 0) return status;
  r->work += after - before;
  r->lifted += moved - before;
  return NSDAE_OK;
}

/* Without it: the integrators of event and penalty let the length of a quaternion drift by their
 * tolerance in each step. It turns as much at any length, so that long ones are put back before;
 * here too what that does to the energy is work. */
static int keep_lengths(nsdae_sim *sim)
{
  nsdae_result *r = &sim->next->result;
  double before, after;
  if (sim->projection.units.count == 0 || !nsdae_units_strayed(&sim->projection, &r->end))
    return NSDAE_OK;
  int status = energy(&r->end, &before);
  if (status < 0) return status;
  nsdae_units_restore(&sim->projection, &r->end);
  status = energy(&r->end, &after);
  r->work += after - before;
  r->lifted += after - before;
  return status;
}

/* Drift of a constraint relative to its size, see nsdae_system_set_size. The size is an arm, half
 * of a link of a chain: a link is off by at most 5e-5 of its length. */
static const double far_off = 1e-4;

/* Whether a constraint of known size has drifted further than that. Near a change point, at that
 * sine, a drift d moves the pose by d / sine and the acceleration by d / sine^3: less is left. */
static int find_drift(nsdae_terms *T, double sine, int *drifted)
{
  double most = sine > 0 ? far_off * sine * sine : far_off;
  const double *size = T->system->size[NSDAE_NAME_CONSTRAINT];
  *drifted = 0;
  if (!size) return NSDAE_OK;
  int status = nsdae_terms_need(T, NSDAE_TERM_PHI);
  for (int i = 0; i < T->system->dims.m && status == NSDAE_OK; i++)
    *drifted |= size[i] > 0 && fabs(T->constraint.phi[i]) > most * size[i];
  return status;
}

/* What projection = slop needs at the end of the step. */
static int need_end(nsdae_terms *end)
{
  unsigned terms = NSDAE_TERM_MASS | NSDAE_TERM_JACOBIAN | NSDAE_TERM_SLIDE;
  if (nsdae_terms_most(end->system) != NSDAE_ANY_NUMBER)
    terms |= NSDAE_TERM_GAP | NSDAE_TERM_NORMAL | NSDAE_TERM_TANGENT | NSDAE_TERM_BIAS;
  return nsdae_terms_need(end, terms);
}

/* Moves the end of the step to the slop and to its constraints: these drifted, or the change moved
 * them by the second order. Velocities stay; with constraints they are projected to those of the
 * new place, which only lowers the kinetic energy. The reach is twice the deepest: a rod that is
 * pushed at one end goes back half as far at the other, and its neighbour may do the same. */
static int move_by(nsdae_sim *sim, double deepest, int drifted, double h, double length)
{
  nsdae_result *r = &sim->next->result;
  nsdae_terms *end = &r->end;
  double before = 0, moved = 0, after = 0;
  int islands = 0, status = need_end(end);
  if (status == NSDAE_OK && deepest > 0)
    islands = nsdae_slop_solve(&sim->slop, &sim->stepper.problem, end,
                               nsdae_terms_touch(end) + 2 * deepest, h);
  if (status < 0 || islands < 0) return status < 0 ? status : islands;
  if (islands == 0 && !drifted) return NSDAE_OK;
  status = energy(end, &before);
  double potential = end->potential;
  if (status == NSDAE_OK && islands > 0)
    status = nsdae_project_change(&sim->projection, end, end, sim->slop.change);
  if (status == NSDAE_OK && islands > 0)
    nsdae_slop_moved(&sim->slop, &sim->stepper.problem, end, sim->projection.least.change);
  if (status == NSDAE_OK && sim->system->dims.m > 0)
    status = nsdae_project_positions(&sim->projection, end, 0);
  if (status == NSDAE_OK) status = energy(end, &moved);
  if (status == NSDAE_OK) status = project_velocities(sim, length);
  if (status == NSDAE_OK) status = energy(end, &after);
  if (status < 0) return status;
  r->counters.moved = islands > 0;
  if (sim->system->dims.m > 0) r->rate.known = 0; /* it was of the velocities before */
  r->work += after - before;
  r->lifted += moved - before;
  r->raised += end->potential - potential;
  return NSDAE_OK;
}

/* Accelerations with the constraints at home, of slop_projection.h, in a step of length h. */
static int hold(nsdae_sim *sim, const nsdae_terms *home, double h)
{
  nsdae_least *least = &sim->projection.least;
  const nsdae_terms *start = &sim->now->result.end, *end = &sim->next->result.end;
  const nsdae_blocks *blocks = &sim->system->blocks;
  const nsdae_rows *J = &home->by.jacobian;
  nsdae_least_start(least);
  for (int i = 0; i < sim->system->dims.m; i++)
    nsdae_least_append(
        least, J, i,
        (nsdae_rows_dot(blocks, J, i, start->v) - nsdae_rows_dot(blocks, J, i, end->v)) / h);
  memcpy(least->change, home->F, (size_t)sim->system->dims.nv * sizeof *least->change);
  return nsdae_least_solve(least, home);
}

/* By how much the deepest closed contact is too deep, h: of the slop. Both methods closed them at
 * home: moreau moves from there by h/2 v_1, implicit by h (v_0 + v_1) / 2. Most are not too deep
 * without the constraints, which spares their solution. */
static int find_deepest(nsdae_sim *sim, double h, double length, double *deepest)
{
  nsdae_stepper *s = &sim->stepper;
  nsdae_terms *end = &sim->next->result.end, *start = &sim->now->result.end;
  nsdae_terms *home = s->problem.home == start ? start : &s->middle;
  const unsigned terms = NSDAE_TERM_MASS | NSDAE_TERM_FORCE | NSDAE_TERM_GAP | NSDAE_TERM_NORMAL |
                         NSDAE_TERM_TANGENT | NSDAE_TERM_BIAS | NSDAE_TERM_JACOBIAN;
  double rest = end->t - home->t;
  *deepest = 0;
  if (s->problem.count == 0) return NSDAE_OK;
  int status = nsdae_terms_need(home, terms);
  if (status < 0) return status;
  for (int j = 0; j < sim->system->dims.nv; j++)
    s->v_other[j] = home == start ? (start->v[j] + end->v[j]) / 2 : end->v[j];
  *deepest = nsdae_slop_find(&sim->slop, &s->problem, home, s->v_other, NULL, rest, h);
  if (*deepest == 0 || sim->system->dims.m == 0) return NSDAE_OK;
  status = hold(sim, home, length);
  if (status < 0) return status;
  const double *held = sim->projection.least.change;
  *deepest = nsdae_slop_find(&sim->slop, &s->problem, home, s->v_other, held, rest, h);
  return NSDAE_OK;
}

/* projection = slop: contacts that are too deep are moved to the slop, and constraints that have
 * drifted are projected. */
static int move_to_slop(nsdae_sim *sim, double length)
{
  double h = fmax(length, sim->options.dt), deepest; /* a short step has the slop of dt */
  int drifted = 0, status = find_deepest(sim, h, length, &deepest);
  if (status == NSDAE_OK)
    status = find_drift(&sim->next->result.end, sim->next->result.crossed.sine, &drifted);
  if (status < 0) return status;
  return deepest > 0 || drifted ? move_by(sim, deepest, drifted, h, length) : NSDAE_OK;
}

static int correct(nsdae_sim *sim, double length)
{
  switch (nsdae_sim_projection(&sim->options)) {
  case NSDAE_PROJECTION_NONE:
    return keep_lengths(sim);
  case NSDAE_PROJECTION_SLOP:
    return move_to_slop(sim, length);
  default:
    return project(sim, length);
  }
}

static int is_closed(const nsdae_closed *closed, long id)
{
  int any = 0;
  for (int a = 0; a < closed->count && !any; a++) any = closed->id[a] == id;
  return any;
}

/* v_N of entry i of the list. */
static double rate_of(const nsdae_terms *T, int i)
{
  const nsdae_contact_list *list = &T->by.list;
  const nsdae_blocks *blocks = &T->system->blocks;
  double rate = list->w[(size_t)i * (size_t)(1 + list->nt)];
  for (int s = 2 * i; s < 2 * i + 2; s++)
    if (list->block[s] >= 0)
      rate += nsdae_dot(nsdae_blocks_size(blocks, list->block[s]), list->value + list->at[s],
                        T->v + blocks->first[list->block[s]]);
  return rate;
}

/* What a contact list of the end of the step has: the gaps of the contacts that the step closed,
 * and the deepest that it did not. implicit begins its next step with this list. */
static int look_at_end(nsdae_sim *sim, double length)
{
  nsdae_result *r = &sim->next->result;
  const nsdae_system *s = sim->system;
  const nsdae_contact_list *list = &r->end.by.list;
  const double *v[] = {sim->now->result.end.v, r->end.v};
  r->entered = (nsdae_entered){0};
  if (!sim->method->closes || nsdae_terms_most(s) != NSDAE_ANY_NUMBER) return NSDAE_OK;
  if (s->maker.may_enter && !s->maker.may_enter(v[0], length, s->user) &&
      !s->maker.may_enter(v[1], length, s->user))
    return NSDAE_OK;
  double touch = nsdae_terms_touch(&r->end);
  int status =
      r->closed.count > 0 ? list_closed(sim, length) : nsdae_terms_contacts(&r->end, touch);
  for (int i = 0; i < list->count && status == NSDAE_OK; i++) {
    if (-list->gap[i] <= fmax(touch, r->entered.depth) || is_closed(&r->closed, list->id[i]))
      continue;
    r->entered = (nsdae_entered){.depth = -list->gap[i],
                                 .rate = rate_of(&r->end, i),
                                 .id = list->id[i],
                                 .block = {list->block[2 * i], list->block[2 * i + 1]}};
  }
  return status;
}

/* With redundant rows: whether the rank is above that of the run before by rows whose sine the
 * drift of the constraints explains, but which is too large to tell. They would lock the mechanism.
 */
static int find_risen_rank(nsdae_sim *sim)
{
  const nsdae_counters *c = &sim->next->result.counters;
  nsdae_terms *start = &sim->now->result.end;
  int was = sim->now->accounts.stats.rank, worst;
  if (sim->options.redundant != NSDAE_REDUNDANT_LEAST_NORM || !sim->method->closes ||
      c->rank_most <= was)
    return NSDAE_OK;
  int status = nsdae_terms_need(start, NSDAE_TERM_PHI | NSDAE_TERM_JACOBIAN);
  if (status < 0) return status;
  double drift = nsdae_least_drift(start, &worst), t = nsdae_terms_time(start);
  if (c->rank_retained > nsdae_least_turned(drift)) return NSDAE_OK;
  nsdae_error_set(&sim->error, NSDAE_E_RANK, "nsdae_sim", "projection",
                  "the rank of Phi_q was %d and is %d at t = %g, by a sine of %.2g, where the "
                  "constraints are off by %.2g of their arms: as much is drift, and would lock the "
                  "mechanism: set projection = constraints, or make dt smaller; off by most is",
                  was, c->rank_most, t, c->rank_retained, drift);
  sim->error.time = t;
  nsdae_system_name_item(sim->system, NSDAE_NAME_CONSTRAINT, worst, &sim->error);
  return NSDAE_E_RANK;
}

/* A step that diverges, or gains energy, by an element that is too stiff for it: that is the cause,
 * not the callback which had infinite coordinates. */
static void name_stiff(nsdae_sim *sim, int status, double length)
{
  const nsdae_maker *maker = &sim->system->maker;
  const nsdae_terms *start = &sim->now->result.end;
  nsdae_reason reason;
  int of_callback = status == NSDAE_E_NONFINITE && strncmp(sim->error.where, "force", 5) != 0;
  int diverged = status == NSDAE_E_CONVERGENCE || status == NSDAE_E_NONFINITE;
  if (!(diverged || status == NSDAE_WARN_ENERGY) || of_callback || !sim->method->closes ||
      !maker->stiff || !maker->stiff(start->q, start->v, length, &reason, sim->model.user))
    return;
  nsdae_error_set(&sim->error, status, "nsdae_sim", "dt", "at t = %g %s", nsdae_terms_time(start),
                  reason.text);
  nsdae_error_at(&sim->error, status, reason.index, nsdae_terms_time(start));
}

/* A step to t1 into next, complete except for its observers. */
static int try_step(nsdae_sim *sim, double t1, double length)
{
  nsdae_point *now = sim->now, *next = sim->next;
  int status = advance_method(sim, t1, length);
  int problem = status == NSDAE_E_LCP || status == NSDAE_E_INFEASIBLE || status == NSDAE_E_PAINLEVE;
  sim->stage.failed = problem && (next->result.problem || next->result.cones);
  if (status == NSDAE_OK) status = find_risen_rank(sim);
  if (status == NSDAE_OK) status = correct(sim, length);
  if (status == NSDAE_OK) status = look_at_end(sim, length);
  if (next->result.end.t < t1) length = next->result.end.t - now->result.end.t; /* so far it came */
  if (status == NSDAE_OK) status = nsdae_point_follow(sim, now, next, length);
  if (status == NSDAE_OK) status = nsdae_certificate_energy(sim, now, next);
  if (status == NSDAE_OK) status = nsdae_monitors_step(sim, now, next);
  if (status != NSDAE_OK) name_stiff(sim, status, length);
  if (status < 0 || !sim->model.tracked) return status;
  nsdae_point_list(next, sim->projection.contacts.closed);
  int finite = nsdae_point_finite(next);
  return finite < 0 ? finite : status;
}

/* Fills next with a step to t1, or finds it there, waiting for an observer that failed. */
static int prepare_step(nsdae_sim *sim, double t1)
{
  double t0 = sim->now->result.end.t;
  if (sim->stage.waiting && sim->stage.asked == t1) return NSDAE_OK;
  sim->stage.waiting = sim->stage.between = 0;
  if (!(t1 > t0))
    return nsdae_error_set(&sim->error, NSDAE_E_ARGUMENT, "nsdae_sim", "dt",
                           "dt = %g is lost in rounding at t = %.17g: make it larger",
                           sim->options.dt, nsdae_system_time(&sim->model, t0));
  unsigned have = sim->now->result.end.have;
  double length = length_of(sim, t1);
  int status =
      nsdae_interrupted(&sim->stepper.interrupt, &sim->error, nsdae_system_time(&sim->model, t0));
  while (status == NSDAE_OK && (status = try_step(sim, t1, length)) == NSDAE_ARRAYS_GROW)
    status = nsdae_sim_grow(sim); /* and once more */
  if (status < 0) {
    sim->now->result.end.have = have; /* what a dropped step evaluated is not counted either */
    return status;
  }
  sim->stage.warning = status > 0 ? sim->error : sim->stage.start; /* observers clear the first */
  if (status == NSDAE_OK) sim->stage.start.status = NSDAE_OK;
  sim->next->accounts.grid_count += sim->next->result.end.t >= t1;
  sim->stage.asked = t1;
  sim->observers.turn = sim->observers.stop = 0;
  sim->stage.waiting = 1;
  return NSDAE_OK;
}

/* One step to t1: it is the state when it is whole and every observer has seen it. off_grid: a new
 * grid of steps starts at t1. */
static int step_to(nsdae_sim *sim, double t1, int off_grid)
{
  int status = prepare_step(sim, t1);
  if (status < 0) return status;
  if (off_grid && sim->next->result.end.t >= t1) {
    sim->next->accounts.grid_start = t1;
    sim->next->accounts.grid_count = 0;
  }
  if (sim->observers.count > 0 || sim->observers.stop)
    status = nsdae_observers_tell(sim, &sim->next->record);
  if (status >= 0) nsdae_sim_commit(sim);
  return status;
}

static int begin_step(nsdae_sim *sim)
{
  nsdae_error_clear(&sim->error);
  if (!sim->stage.started)
    return nsdae_error_set(&sim->error, NSDAE_E_STATE, "nsdae_sim", "",
                           "the simulation has no state: call nsdae_sim_init first");
  if (sim->stage.told) return NSDAE_OK;
  int status = nsdae_observers_tell(sim, &sim->now->record);
  sim->stage.told = status >= 0;
  return status;
}

static int happened(const nsdae_result *result)
{
  if (result->counters.accumulations > 0) return NSDAE_ZENO;
  return result->impacts > 0 || result->changes > 0 ? NSDAE_EVENT : NSDAE_OK;
}

NSDAE_SIM_CALL(NSDAE_MOVE, nsdae_sim_step, (nsdae_sim * sim), sim)
{
  double began = nsdae_wall_clock();
  int status = begin_step(sim);
  if (status != NSDAE_OK) return status;
  status = step_to(sim, grid_time(sim, 1), 0);
  sim->wall_time += nsdae_wall_clock() - began;
  if (status != NSDAE_OK) return status;
  if (sim->stage.warning.status <= 0) return happened(&sim->now->result);
  sim->error = sim->stage.warning; /* of a step that was done */
  return sim->stage.warning.status;
}

/* to_event: until one happens. */
static int run_to(nsdae_sim *sim, const char *where, double t_end, int to_event)
{
  double began = nsdae_wall_clock(),
         t = sim->stage.started ? nsdae_terms_time(&sim->now->result.end) : 0;
  nsdae_error_clear(&sim->error);
  if (!isfinite(t_end) || (sim->stage.started && t_end < t))
    return nsdae_error_set(&sim->error, NSDAE_E_ARGUMENT, where, "t_end",
                           "t_end = %g is outside its range: it must be finite and at least the "
                           "time reached, %g",
                           t_end, t);
  nsdae_error warning = {0}; /* the first of the run */
  int status = begin_step(sim);
  while (status == NSDAE_OK && nsdae_terms_time(&sim->now->result.end) < t_end) {
    /* to the first of the simulation's times that is seen at t_end or later; a step that would end
     * just before t_end ends there */
    double t1 = grid_time(sim, 1), end = t_end - sim->model.epoch, rest = NO_STEP * sim->options.dt;
    while (nsdae_system_time(&sim->model, end) < t_end) end = nextafter(end, INFINITY);
    int on_grid = t1 < end - rest || nsdae_system_time(&sim->model, t1) == t_end;
    status = step_to(sim, on_grid ? t1 : end, !on_grid && fabs(t1 - end) > hair(sim));
    if (status >= 0 && sim->stage.warning.status > 0 && warning.status == NSDAE_OK)
      warning = sim->stage.warning;
    if (status == NSDAE_OK && to_event) status = happened(&sim->now->result);
  }
  sim->wall_time += nsdae_wall_clock() - began;
  if (status != NSDAE_OK || warning.status == NSDAE_OK) return status;
  sim->error = warning;
  return warning.status;
}

NSDAE_SIM_CALL(NSDAE_MOVE, nsdae_sim_run, (nsdae_sim * sim, double t_end), sim, t_end)
{
  return run_to(sim, "nsdae_sim_run", t_end, 0);
}

NSDAE_SIM_CALL(NSDAE_MOVE, nsdae_sim_run_to_event, (nsdae_sim * sim, double t_end), sim, t_end)
{
  return run_to(sim, "nsdae_sim_run_to_event", t_end, 1);
}
