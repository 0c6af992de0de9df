#include "integrator.h"

#include <math.h>
#include <string.h>

#include "errors.h"

/* Of a time in a step: to the last digits. */
enum { BISECTIONS = 60 };

/* Backward differences lose that much more over many steps than the other method. */
static const double STIFF_TOLERANCE = 0.1;

/* Of what counts as zero for a position: less deep between two steps a contact is none. */
static const double DEEP = 0.1;

/* The callbacks of the integrators, and of the search for falls. */
static int rate(double t, const double *state, double *ydot, void *user)
{
  nsdae_event_integrator *e = user;
  return nsdae_event_account_rate(e->account, t, state, ydot);
}

static int near(double t, const double *from, const double *state, double *ydot, void *user)
{
  nsdae_event_integrator *e = user;
  nsdae_event_phase *p = e->roots->phase;
  int status = nsdae_event_linearise(p, t, from);
  int code = status < 0 ? nsdae_event_code(p->setting, status) : rate(t, state, ydot, e);
  p->linear = 0;
  return code;
}

static int values(double t, double *g, void *user)
{
  nsdae_event_integrator *e = user;
  int status = nsdae_event_integrator_read(e, t, e->y);
  return status < 0 ? status : nsdae_event_root_values(e->roots, t, e->y, g);
}

void nsdae_event_integrator_layout(nsdae_event_integrator *e, nsdae_arena *arena)
{
  const nsdae_event_setting *s = e->roots->phase->setting;
  e->steps =
      (nsdae_runge_kutta){.n = s->at.n + 1, .controlled = s->at.lambda, .rate = rate, .user = e};
  e->fall = (nsdae_fall){.count = e->roots->count, .values = values, .user = e};
  nsdae_runge_kutta_layout(&e->steps, arena);
  nsdae_fall_layout(&e->fall, arena);
  e->y = NSDAE_ARENA_DOUBLES(arena, s->at.n);
  e->z = NSDAE_ARENA_DOUBLES(arena, s->at.n + 1L);
  e->end = NSDAE_ARENA_DOUBLES(arena, s->at.n + 1L);
  e->fallen = NSDAE_ARENA_INTS(arena, e->roots->count);
  e->gap = NSDAE_ARENA_DOUBLES(arena, 4L * s->system->dims.k);
  e->rate = NSDAE_ARENA_DOUBLES(arena, 4L * s->system->dims.k);
}

int nsdae_event_integrator_make(nsdae_event_integrator *e)
{
  const nsdae_event_setting *s = e->roots->phase->setting;
  const nsdae_ode_problem problem = {
      .n = s->at.n + 1, .controlled = s->at.lambda, .rate = rate, .near = near, .user = e};
  int status = nsdae_ode_create(&problem, s->options->rtol, s->options->atol, &e->stiff);
  if (status == NSDAE_OK) nsdae_event_integrator_prepare(e);
  return status;
}

void nsdae_event_integrator_prepare(nsdae_event_integrator *e)
{
  const nsdae_sim_options *o = e->roots->phase->setting->options;
  e->steps.rtol = o->rtol;
  e->steps.atol = o->atol;
  e->steps.max_step = o->dt;
  nsdae_ode_tolerances(e->stiff, STIFF_TOLERANCE * o->rtol, STIFF_TOLERANCE * o->atol);
}

int nsdae_event_integrator_start(nsdae_event_integrator *e, double t)
{
  nsdae_event_phase *p = e->roots->phase;
  nsdae_event_begin_phase(p);
  nsdae_error_clear(p->setting->error);
  memset(e->end, 0, (size_t)e->steps.n * sizeof *e->end);
  memcpy(e->end, e->y, (size_t)e->steps.controlled * sizeof *e->y);
  e->ahead = t;
  e->known = NAN;
  e->pending = 0;
  int status = *e->is_stiff ? nsdae_ode_start(e->stiff, t, e->end)
                            : nsdae_runge_kutta_start(&e->steps, t, e->end);
  if (status == NSDAE_OK) status = nsdae_event_forces(p, t, e->y);
  return status < 0 ? status : nsdae_event_set_roots(e->roots, t, e->y, p->x);
}

/* Gaps and their rates at t in the last step, as the point number of it. */
static int look(nsdae_event_integrator *e, double t, int point)
{
  nsdae_event_setting *s = e->roots->phase->setting;
  nsdae_terms *T = s->here;
  int k = s->system->dims.k, status = nsdae_event_integrator_read(e, t, e->y);
  if (status < 0) return status;
  nsdae_event_move(s, t, e->y);
  status = nsdae_terms_need(T, NSDAE_TERM_GAP | NSDAE_TERM_NORMAL | NSDAE_TERM_BIAS);
  for (int i = 0; i < k && status == NSDAE_OK; i++) {
    e->gap[point * k + i] = T->gap[i];
    e->rate[point * k + i] = nsdae_terms_rate(T, T->W_N, T->w_N, i, T->v);
  }
  return status;
}

/* The gap of contact i at t in the last step; its rate in *rate. */
static double gap_at(nsdae_event_integrator *e, int i, double t, double *rate, int *status)
{
  *status = look(e, t, 3);
  *rate = e->rate[3 * e->roots->phase->setting->system->dims.k + i];
  return e->gap[3 * e->roots->phase->setting->system->dims.k + i];
}

/* Where the gap of contact i, above zero and falling at a, is below at b, or, above and rising
 * there, is below zero in between: its fall through zero, or INFINITY. The lowest point is where
 * the rate changes its sign; both by bisection. */
static double hidden_fall(nsdae_event_integrator *e, int i, double a, double b, int *status)
{
  double low = a, rate = 0, gap = gap_at(e, i, b, &rate, status);
  double deep = -DEEP * nsdae_event_position_size(e->roots->phase->setting);
  for (int n = 0; n < BISECTIONS && gap > deep && *status == NSDAE_OK; n++) {
    double t = (a + b) / 2;
    gap = gap_at(e, i, t, &rate, status);
    *(rate < 0 ? &a : &b) = t;
    if (gap <= deep) b = t;
  }
  if (gap > deep || *status < 0) return INFINITY;
  for (int n = 0; n < BISECTIONS && *status == NSDAE_OK; n++) {
    double t = (low + b) / 2;
    *(gap_at(e, i, t, &rate, status) > 0 ? &low : &b) = t;
  }
  return b;
}

/* Whether the parabola through what is known at both ends, points first and first + 1 of the step,
 * could come near zero in between. */
static int may_touch(const nsdae_event_integrator *e, int i, int first, double h)
{
  int k = e->roots->phase->setting->system->dims.k;
  const double *gap = e->gap + first * k + i, *rate = e->rate + first * k + i;
  if (first == 0 && gap[0] > 0 && gap[k] <= 0) return 1;
  if (!(gap[0] > 0 && gap[k] > 0 && rate[0] < 0 && rate[k] > 0)) return 0;
  return fmin(gap[0], gap[k]) < h * fmax(-rate[0], rate[k]);
}

/* Whether, at the rates of the step's ends, contact i could come to zero within h. */
static int may_reach(const nsdae_event_integrator *e, int i, double h)
{
  int k = e->roots->phase->setting->system->dims.k;
  double fastest = fmax(fabs(e->rate[i]), fabs(e->rate[2 * k + i]));
  return fmin(e->gap[i], e->gap[2 * k + i]) < h * fastest;
}

/* The ends of the last step: its start is where the one before ended, if it is known. */
static int look_at_ends(nsdae_event_integrator *e, double from)
{
  size_t size = (size_t)e->roots->phase->setting->system->dims.k * sizeof *e->gap;
  int status = NSDAE_OK;
  if (e->known == from) {
    memcpy(e->gap, e->gap + 2 * size / sizeof *e->gap, size);
    memcpy(e->rate, e->rate + 2 * size / sizeof *e->rate, size);
  } else {
    status = look(e, from, 0);
  }
  e->known = e->ahead;
  return status < 0 ? status : look(e, e->ahead, 2);
}

/* A contact that closes and opens again between two steps of the integrator is none of its roots.
 * Returns the first such fall in the last step, from `from` to `ahead`, and its contact; INFINITY
 * where there is none. */
static double find_hidden(nsdae_event_integrator *e, double from, int *contact, int *status)
{
  const nsdae_event_modes *m = &e->roots->phase->modes;
  double first = INFINITY, h = (e->ahead - from) / 2;
  int k = e->roots->phase->setting->system->dims.k, any = 0;
  for (int i = 0; i < k; i++) any |= m->contact[i] == NSDAE_MODE_OPEN;
  if (any) *status = look_at_ends(e, from);
  any = 0;
  for (int i = 0; i < k && *status == NSDAE_OK; i++)
    any |= m->contact[i] == NSDAE_MODE_OPEN && may_reach(e, i, 2 * h);
  if (any) *status = look(e, from + h, 1);
  if (!any || *status < 0) return first;
  for (int i = 0; i < k && *status == NSDAE_OK; i++)
    for (int half = 0; half < 2 && m->contact[i] == NSDAE_MODE_OPEN; half++) {
      if (!may_touch(e, i, half, h)) continue;
      double a = from + half * h, t = hidden_fall(e, i, a, half ? e->ahead : a + h, status);
      if (t < first) first = t, *contact = i;
    }
  return first;
}

/* A step of the integrator at work; its end is in `end`. */
static int step(nsdae_event_integrator *e)
{
  int what = NSDAE_ODE_STEP;
  if (*e->is_stiff)
    return nsdae_ode_advance(e->stiff, e->ahead + e->steps.max_step, &e->ahead, e->end, &what, NULL,
                             &e->code);
  int status = nsdae_runge_kutta_advance(&e->steps);
  if (status < 0) return status;
  e->ahead = e->steps.t;
  nsdae_runge_kutta_read(&e->steps, e->ahead, e->end);
  return NSDAE_OK;
}

/* A step that ends at the first fall of a root; returns how many fell, or a status. */
static int step_to_fall(nsdae_event_integrator *e)
{
  double from = e->ahead;
  memcpy(e->y, e->end, (size_t)e->steps.controlled * sizeof *e->y);
  if (e->fall.count > 0 && nsdae_event_root_values(e->roots, from, e->y, e->fall.low) < 0)
    return NSDAE_E_CONVERGENCE;
  int status = step(e);
  int fell =
      status < 0 || e->fall.count == 0 ? 0 : nsdae_fall_find(&e->fall, from, &e->ahead, e->fallen);
  return status < 0 ? status : fell < 0 ? NSDAE_E_CONVERGENCE : fell;
}

int nsdae_event_integrator_advance(nsdae_event_integrator *e)
{
  int contact = -1, found = NSDAE_OK;
  double from = e->ahead;
  nsdae_error_clear(e->roots->phase->setting->error);
  int fell = step_to_fall(e);
  if (fell < 0) return fell;
  double hidden = find_hidden(e, from, &contact, &found);
  if (found < 0) return found;
  if (contact >= 0) e->ahead = hidden, fell = 0;
  int status = nsdae_event_integrator_read(e, e->ahead, e->y);
  int watched = status < 0 ? status : nsdae_event_watch_roots(e->roots, e->ahead, e->y);
  if (watched < 0) return watched;
  e->roots->phase->setting->result->counters.iterations++;
  for (int i = 0; fell && i < e->roots->count; i++) e->roots->entry[i].found |= e->fallen[i];
  if (contact >= 0) nsdae_event_root_of(e->roots, NSDAE_ROOT_NORMAL, contact)->found = 1;
  e->pending = fell || watched > 0 || contact >= 0;
  return NSDAE_OK;
}

static int read_all(nsdae_event_integrator *e, double t, double *z)
{
  if (*e->is_stiff) return nsdae_ode_read(e->stiff, t, z);
  nsdae_runge_kutta_read(&e->steps, t, z);
  return NSDAE_OK;
}

int nsdae_event_integrator_read(nsdae_event_integrator *e, double t, double *y)
{
  int status = read_all(e, t, e->z);
  memcpy(y, e->z, (size_t)e->steps.controlled * sizeof *y);
  return status;
}

int nsdae_event_integrator_account(nsdae_event_integrator *e, double from, double to)
{
  int status = read_all(e, from, e->z);
  if (status == NSDAE_OK) status = read_all(e, to, e->account->y);
  if (status == NSDAE_OK) nsdae_event_account_phase(e->account, e->z, e->account->y);
  return status;
}
