#include "integrator.h"

#include <math.h>
#include <string.h>

#include "errors.h"

/* Of the tolerance of a position: less deep between two steps a contact is none. */
static const double DEEP = 0.1;

/* Of 1 / alpha, the longest step: Baumgarte's terms make v' = -2 alpha v of a drift, and beyond the
 * border of stability (|h lambda| 3.3 and 6.1) the rounding of a body at rest would grow up to the
 * tolerance. */
static const double DAMPED = 1;

/* Of dt: a step that leads nowhere. */
static const double SHORT = 1e-6;

/* Of a step in which the forces have no solution: the next one. */
static const double SHORTER = 0.125;

/* The callbacks of the integrators, and of the search for falls. */
static int rate(double t, const double *state, double *ydot, int whole, void *user)
{
  nsdae_event_integrator *e = user;
  return nsdae_event_account_rate(e->account, t, state, whole, ydot);
}

static int powers(double t, const double *y, const double *ydot, double *power, void *user)
{
  nsdae_event_integrator *e = user;
  (void)ydot;
  return nsdae_event_account_powers(e->account, t, y, power);
}

static int residual(double t, const double *y, const double *ydot, double cj, double *r, void *user)
{
  nsdae_event_integrator *e = user;
  return nsdae_event_residual(t, y, ydot, cj, r, e->roots->phase);
}

static int setup(double t, const double *y, const double *ydot, double cj, void *user)
{
  nsdae_event_integrator *e = user;
  return nsdae_event_newton_setup(t, y, ydot, cj, e->roots->phase);
}

static int solve(double cj, double *r, double *x, void *user)
{
  nsdae_event_integrator *e = user;
  return nsdae_event_newton_solve(cj, r, x, e->roots->phase);
}

static int values(double t, double *g, void *user)
{
  nsdae_event_integrator *e = user;
  int status = nsdae_event_integrator_read(e, t, e->y);
  return status < 0 ? status : nsdae_event_root_values(e->roots, t, e->y, 0, g);
}

/* Gaps and their rates at t in the last step. */
static int look(double t, double *gap, double *rate, void *user)
{
  nsdae_event_integrator *e = user;
  nsdae_event_setting *s = e->roots->phase->setting;
  nsdae_terms *T = s->here;
  int k = s->system->dims.k, status = nsdae_event_integrator_read(e, t, e->y);
  if (status < 0) return status;
  nsdae_event_move(s, t, e->y);
  status = nsdae_terms_need(T, NSDAE_TERM_GAP | NSDAE_TERM_NORMAL | NSDAE_TERM_BIAS);
  if (status < 0) return status;
  memcpy(gap, T->gap, (size_t)k * sizeof *gap);
  for (int i = 0; i < k; i++) rate[i] = nsdae_terms_normal_rate(T, i, T->v);
  return NSDAE_OK;
}

/* Terms at t in the last step, to look for contacts. */
static int look_around(double t, nsdae_terms **terms, void *user)
{
  nsdae_event_integrator *e = user;
  nsdae_event_setting *s = e->roots->phase->setting;
  *terms = s->here;
  int status = nsdae_event_integrator_read(e, t, e->y);
  if (status == NSDAE_OK) nsdae_event_move(s, t, e->y);
  return status;
}

void nsdae_event_integrator_layout(nsdae_event_integrator *e, nsdae_arena *arena)
{
  const nsdae_event_setting *s = e->roots->phase->setting;
  e->smooth.steps = (nsdae_runge_kutta){.n = s->at.whole,
                                        .controlled = s->at.lambda,
                                        .positions = s->at.v,
                                        .forces = s->at.n - s->at.lambda,
                                        .rate = rate,
                                        .user = e};
  e->fall = (nsdae_fall){.count = e->roots->count, .values = values, .user = e};
  e->tracking = (nsdae_tracking){.model = s->system,
                                 .table = s->system->tracked,
                                 .error = s->error,
                                 .look = look_around,
                                 .user = e};
  e->dip = (nsdae_dip){.count = s->system->dims.k, .look = look, .user = e};
  e->smooth.implicit =
      (nsdae_ida_problem){.residual = residual, .setup = setup, .solve = solve, .user = e};
  e->smooth.powers = powers;
  nsdae_smooth_layout(&e->smooth, arena);
  nsdae_fall_layout(&e->fall, arena);
  nsdae_dip_layout(&e->dip, arena);
  if (s->system->tracked) nsdae_tracking_layout(&e->tracking, arena);
  e->y = NSDAE_ARENA_DOUBLES(arena, s->at.n);
  nsdae_arena_doubles(arena, s->at.whole, (double **[]){&e->z, &e->later, &e->end, NULL});
  e->fallen = NSDAE_ARENA_INTS(arena, e->roots->count);
}

int nsdae_event_integrator_make(nsdae_event_integrator *e)
{
  int status = nsdae_newton_kkt_make(&e->roots->phase->newton);
  if (status == NSDAE_OK)
    status = nsdae_smooth_make(&e->smooth, e->roots->phase->setting->options->integrator);
  if (status == NSDAE_OK) nsdae_event_integrator_prepare(e);
  return status;
}

void nsdae_event_integrator_release(nsdae_event_integrator *e)
{
  if (e->roots) nsdae_newton_kkt_release(&e->roots->phase->newton);
  nsdae_ida_destroy(&e->smooth.ida);
}

void nsdae_event_integrator_prepare(nsdae_event_integrator *e)
{
  const nsdae_sim_options *o = e->roots->phase->setting->options;
  e->smooth.steps.rtol = o->rtol;
  e->smooth.steps.atol = o->atol;
  e->smooth.steps.max_step = fmin(fmin(o->step_max, o->dt), DAMPED / o->baumgarte_alpha);
  e->smooth.steps.span = o->dt;
  nsdae_event_crossing_prepare(&e->roots->phase->crossing, o->rtol);
}

/* The largest force applied, or what would stop the bodies in a dt. */
static double force_of(const nsdae_event_integrator *e)
{
  const nsdae_terms *T = e->roots->phase->setting->here;
  const nsdae_blocks *b = &T->system->blocks;
  int n = T->system->dims.nv;
  double inertia = 0;
  for (size_t i = 0; i < b->square[b->count]; i++) inertia = fmax(inertia, fabs(T->M[i]));
  return fmax(nsdae_largest(n, T->F), inertia * nsdae_largest(n, T->v) / e->smooth.steps.span);
}

/* Where the phase that starts at t, with the forces in y, crosses a change point: its equations. By
 * an explicit pair, as the directions that are held have no unknowns of their own. */
static int cross_change_point(nsdae_event_integrator *e, double t)
{
  nsdae_event_phase *p = e->roots->phase;
  nsdae_event_crossing *c = &p->crossing;
  size_t size = (size_t)p->setting->system->dims.nv * sizeof *c->a;
  c->rank = p->setting->system->dims.m - *p->modes.redundant;
  c->width = c->tau;
  if (!(c->least < NSDAE_CROSSING_NEAR * c->tau)) return NSDAE_OK;
  memcpy(c->a, p->x, size);
  int crosses = 1;
  for (int again = 0; again < 2 && crosses > 0; again++) {
    memcpy(c->a_ahead, p->x, size);
    crosses = nsdae_event_foresee(c, p->setting, t, e->y, again);
    if (crosses > 0) crosses = nsdae_event_forces(p, t + c->span, c->room.ahead) == NSDAE_OK;
  }
  memcpy(c->a_ahead, p->x, size);
  if (crosses > 0) crosses = nsdae_event_is_straight(c, p->setting, e->y);
  if (crosses <= 0) nsdae_event_narrow(c);
  if (crosses > 0) crosses = nsdae_event_hold(c, p->setting, e->y);
  nsdae_error_clear(p->setting->error); /* terms that fail ahead: the motion does not go there */
  int status = NSDAE_OK;
  if (crosses > 0) {
    nsdae_crossed *crossed = &p->setting->result->crossed;
    if (crossed->constraint < 0 && !e->again)
      *crossed = (nsdae_crossed){p->setting->kkt->dependent, t + c->span / 2, 0};
    nsdae_event_begin_phase(p);
    nsdae_smooth_set(&e->smooth, NSDAE_INTEGRATOR_DOPRI5);
    status = nsdae_smooth_start(&e->smooth, t, e->end);
  }
  c->least = 1;
  return status < 0 ? status : nsdae_event_forces(p, t, e->y);
}

int nsdae_event_integrator_start(nsdae_event_integrator *e, double t)
{
  nsdae_event_phase *p = e->roots->phase;
  nsdae_error_clear(p->setting->error);
  nsdae_power_start(&e->account->power); /* a phase begins */
  memset(e->end, 0, (size_t)e->smooth.steps.n * sizeof *e->end);
  memcpy(e->end, e->y, (size_t)e->smooth.steps.controlled * sizeof *e->y);
  e->ahead = t;
  nsdae_dip_start(&e->dip);
  e->pending = e->roots->short_steps = 0;
  nsdae_smooth_set(&e->smooth, *p->modes.integrator);
  /* IDA needs the size of the forces; a pair evaluates a first step, beside which the roots need
   * the forces at t */
  p->crossing.count = 0;
  nsdae_event_begin_phase(p);
  int status = e->smooth.is_stiff ? NSDAE_OK : nsdae_smooth_start(&e->smooth, t, e->end);
  p->crossing.least = 1;
  if (status == NSDAE_OK) status = nsdae_event_forces(p, t, e->y);
  if (status == NSDAE_OK) status = cross_change_point(e, t);
  if (status == NSDAE_OK) e->smooth.steps.force = force_of(e);
  if (status == NSDAE_OK && e->smooth.is_stiff) status = nsdae_smooth_start(&e->smooth, t, e->end);
  if (status == NSDAE_OK) status = nsdae_event_set_roots(e->roots, t, e->y, p->x);
  if (status == NSDAE_OK && p->setting->system->tracked)
    nsdae_event_start_late(e->roots, t, e->late);
  return status;
}

void nsdae_event_open_fresh(nsdae_event_integrator *e)
{
  nsdae_event_modes *m = &e->roots->phase->modes;
  int nt = e->tracking.model->dims.nt;
  for (int i = 0; i < e->tracking.model->dims.k; i++) {
    if (!e->tracking.fresh[i]) continue;
    m->contact[i] = NSDAE_MODE_OPEN;
    m->blur[i] = 1;
    memset(m->direction + i * nt, 0, (size_t)nt * sizeof *m->direction);
  }
}

/* Contacts that are new in their slots are open from t on. */
static int begin_slots(nsdae_event_integrator *e, double t)
{
  nsdae_terms *T;
  int k = e->tracking.model->dims.k;
  for (int i = 0; i < k; i++) e->late[i] |= e->tracking.fresh[i];
  nsdae_event_open_fresh(e);
  nsdae_event_start_late(e->roots, t, e->tracking.fresh);
  int status = look_around(t, &T, e);
  if (status == NSDAE_OK) status = nsdae_terms_need(T, NSDAE_TERM_GAP);
  for (int i = 0; i < k && status == NSDAE_OK; i++) {
    nsdae_event_root *root = nsdae_event_root_of(e->roots, NSDAE_ROOT_NORMAL, i);
    if (e->tracking.fresh[i] && T->gap[i] <= root->size) root->state = NSDAE_ROOT_MASKED;
  }
  return status;
}

/* Whether a wider reach has contacts at the start of the step that were not listed there. */
static int has_unlisted(const nsdae_event_integrator *e)
{
  const nsdae_tracked *tracked = e->tracking.table;
  int any = 0;
  for (int i = 0; e->fall.count > 0 && i < e->tracking.model->dims.k; i++)
    any |= tracked->used[i] && !(e->fall.low[i] < NSDAE_FAR);
  return any;
}

/* Functions at the start of the step, with contacts that have a slot or are listed there now. */
static int look_again(nsdae_event_integrator *e, double from)
{
  nsdae_terms *T;
  nsdae_dip_start(&e->dip);
  int status = look_around(from, &T, e);
  if (status < 0 || e->fall.count == 0) return status;
  return nsdae_event_root_values(e->roots, from, e->y, 0, e->fall.low) < 0 ? NSDAE_E_CONVERGENCE
                                                                           : NSDAE_OK;
}

/* After a step: contacts that are near in it have slots, and roots from its start on. NSDAE_OK or a
 * status. */
static int look_for_contacts(nsdae_event_integrator *e, double from)
{
  nsdae_event_setting *s = e->roots->phase->setting;
  if (!s->system->tracked || e->again) return NSDAE_OK;
  nsdae_event_move(s, from, e->y);
  e->tracking.near = NSDAE_EVENT_NEAR * nsdae_event_position_size(s);
  e->tracking.longest = e->smooth.steps.max_step;
  int dense = e->smooth.steps.is_dense;
  double reach = e->tracking.table->reach;
  int added = nsdae_tracking_cover(&e->tracking, from, e->ahead);
  if (!dense) e->smooth.steps.is_dense = 0; /* what is rough does not depend on looking */
  int status = added > 0 ? begin_slots(e, from) : added;
  int wider = e->tracking.table->reach > reach && has_unlisted(e);
  return status == NSDAE_OK && (added > 0 || wider) ? look_again(e, from) : status;
}

/* A step of the integrator at work; its end is in `end`. */
static int step(nsdae_event_integrator *e)
{
  int status = nsdae_smooth_advance(&e->smooth);
  if (status < 0) return status;
  e->ahead = e->smooth.to;
  return nsdae_smooth_read(&e->smooth, e->ahead, e->smooth.steps.controlled, e->end);
}

/* Whether a step in which the forces have no solution may be tried again, shorter: as where a gap
 * has a kink in it. */
static int can_retreat(const nsdae_event_integrator *e)
{
  const nsdae_event_setting *s = e->roots->phase->setting;
  return s->error->status == NSDAE_OK && !e->smooth.is_stiff &&
         e->smooth.steps.last > SHORT * s->options->dt;
}

/* A force that falls may have jumped, as where a ball rolls from a face to an edge: beyond, the
 * forces of the phase are none, and the impulses of a step to there are not those up to here. So
 * such a step is taken again, to here. 0: it has to be shorter. */
static int land(nsdae_event_integrator *e)
{
  const int *mode = e->roots->phase->modes.contact;
  int force = 0;
  for (int i = 0; i < e->roots->count; i++) {
    const nsdae_event_root *root = &e->roots->entry[i];
    force |=
        e->fallen[i] && root->kind == NSDAE_ROOT_NORMAL && mode[root->index] != NSDAE_MODE_OPEN;
  }
  if (!force || e->smooth.is_stiff || !(e->ahead < e->smooth.steps.t)) return 1;
  return nsdae_runge_kutta_land(&e->smooth.steps, e->ahead) == 0;
}

/* A step that ends at the first fall of a root; returns how many fell, or a status. */
static int step_to_fall(nsdae_event_integrator *e)
{
  nsdae_runge_kutta *s = &e->smooth.steps;
  double from = e->ahead;
  nsdae_event_crossing *c = &e->roots->phase->crossing;
  memcpy(e->y, e->end, (size_t)s->controlled * sizeof *e->y);
  if (c->count == 0 && !e->smooth.is_stiff) nsdae_event_widen(c);
  c->least = 1;
  if (e->fall.count > 0 && nsdae_event_root_values(e->roots, from, e->y, 1, e->fall.low) < 0)
    return NSDAE_E_CONVERGENCE;
  for (;;) {
    int status = step(e), fell = 0;
    if (e->smooth.is_stiff) c->least = 0; /* its steps do not ask for forces */
    if (status == NSDAE_OK) status = look_for_contacts(e, from);
    if (status < 0 || e->fall.count == 0) return status;
    fell = nsdae_fall_find(&e->fall, from, &e->ahead, e->fallen);
    int rough = nsdae_runge_kutta_is_rough(s) && can_retreat(e);
    if (!rough && (fell == 0 || (fell > 0 && land(e)))) return fell;
    e->ahead = from;
    if (!can_retreat(e)) return NSDAE_E_CONVERGENCE;
    nsdae_runge_kutta_retreat(s, SHORTER);
  }
}

/* Open contacts that close at the end of a step: those that fell, or that one; each listed in time.
 */
static int close_listed(nsdae_event_integrator *e, double from, int fell, int contact)
{
  nsdae_event_setting *s = e->roots->phase->setting;
  if (!s->system->tracked || e->again) return NSDAE_OK;
  for (int i = 0; i < s->system->dims.k; i++) /* the first entries of roots are of kind normal */
    e->tracking.closes[i] = e->roots->phase->modes.contact[i] == NSDAE_MODE_OPEN &&
                            (i == contact || (fell && e->fallen[i]));
  return nsdae_tracking_close(&e->tracking, from, e->ahead);
}

int nsdae_event_integrator_advance(nsdae_event_integrator *e)
{
  nsdae_event_setting *s = e->roots->phase->setting;
  int contact = -1;
  double from = e->ahead, hidden;
  nsdae_error_clear(s->error);
  int fell = step_to_fall(e);
  if (fell < 0) return fell;
  /* a contact that closes and opens again between two steps is none of the roots */
  int found = nsdae_dip_find(&e->dip, from, e->ahead, nsdae_smooth_pieces(&e->smooth),
                             e->roots->phase->modes.contact, DEEP * nsdae_event_position_size(s),
                             &hidden, &contact);
  if (found < 0) return found;
  if (contact >= 0) e->ahead = hidden, fell = 0;
  int status = close_listed(e, from, fell, contact);
  if (status == NSDAE_OK) status = nsdae_event_integrator_read(e, e->ahead, e->y);
  e->roots->short_steps += e->ahead - from < SHORT * s->options->dt;
  int watched = status < 0 ? status : nsdae_event_watch_roots(e->roots, e->ahead, e->y);
  if (watched < 0) return watched;
  s->result->counters.iterations++;
  for (int i = 0; fell && i < e->roots->count; i++) e->roots->entry[i].found |= e->fallen[i];
  if (contact >= 0) nsdae_event_root_of(e->roots, NSDAE_ROOT_NORMAL, contact)->found = 1;
  e->pending = fell || watched > 0 || contact >= 0;
  return NSDAE_OK;
}

int nsdae_event_integrator_read(nsdae_event_integrator *e, double t, double *y)
{
  return nsdae_smooth_read(&e->smooth, t, e->smooth.steps.controlled, y);
}

int nsdae_event_integrator_account(nsdae_event_integrator *e, double from, double to)
{
  int n = e->smooth.steps.n, status = nsdae_smooth_read(&e->smooth, to, n, e->later);
  if (status == NSDAE_OK) status = nsdae_smooth_read(&e->smooth, from, n, e->z);
  if (status == NSDAE_OK) nsdae_event_account_phase(e->account, e->z, e->later);
  return status;
}
