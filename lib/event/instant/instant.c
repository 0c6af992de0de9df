#include "instant.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "phase.h"
#include "errors.h"

/* Of the squared sines between the range of the constraints and that of the phase, the most. */
static const double TURNED = 0.25;

/* Of the tolerance: where a gap is projected back, and where it is an error. */
static const double STRAYED = 10, LOST = 1e5;

/* The same of what is closed and comes together: so fast a drift may be a kink. */
static const double SUSPECT = 1e3;

/* Of the tolerance of a velocity: up to there a body that begins to slide keeps its
 * direction, which would turn within its velocity's error. */
static const double HARDLY = 100;

/* What slides by a velocity just above zero may stop by the first projection, its neighbour then.
 */
enum { CHOICES = 3 };

/* Terms that say nothing of a deviation. */
static const unsigned BY_FORCES =
    NSDAE_TERM_MASS | NSDAE_TERM_FORCE | NSDAE_TERM_OMEGA | NSDAE_TERM_ACCELERATION;

/* Of the friction that there can be: shared friction is not told apart from all of it. */
static const double NEARLY_ALL = 0.01;

/* Whether the friction of contact i breaks away. Where how friction shares was chosen, a contact at
 * its limit is no reason to slide until all that stick are, or sharing anew left it there. */
static int breaks_away(const nsdae_event_roots *roots, const double *y, int i)
{
  const nsdae_event_modes *m = &roots->phase->modes;
  const nsdae_dims *d = &roots->phase->setting->system->dims;
  int shared = 0, all = 1;
  if (m->contact[i] != NSDAE_MODE_STICK) return 0;
  for (int j = 0; j < d->k; j++) {
    const nsdae_event_root *root = nsdae_event_root_of(roots, NSDAE_ROOT_TANGENT, j);
    if (m->contact[j] != NSDAE_MODE_STICK) continue;
    for (int l = 0; l < d->nt; l++)
      shared |= nsdae_event_is_related(roots->phase, d->k + j * d->nt + l);
    double most =
        roots->phase->setting->system->contact[j].mu * y[roots->phase->setting->at.normal + j];
    all &= root->found ||
           nsdae_event_stick_margin(roots->phase, y, j) <= fmax(root->size, NEARLY_ALL * most);
  }
  const nsdae_event_root *own = nsdae_event_root_of(roots, NSDAE_ROOT_TANGENT, i);
  return shared ? all || (own->found && own->state == NSDAE_ROOT_MASKED) : own->found;
}

/* What was found, in terms of the modes so far. */
static void sort_found(nsdae_event_instant *p, const double *y)
{
  const nsdae_event_phase *phase = p->roots->phase;
  const nsdae_event_places *at = &phase->setting->at;
  const nsdae_event_findings *is = &p->acceleration.is;
  nsdae_event_modes *m = &p->roots->phase->modes;
  const nsdae_dims *d = &phase->setting->system->dims;
  for (int i = 0; i < d->k; i++) {
    const nsdae_event_root *root = nsdae_event_root_of(p->roots, NSDAE_ROOT_NORMAL, i);
    int closed = m->contact[i] != NSDAE_MODE_OPEN;
    int presses = root->state == NSDAE_ROOT_MASKED && y[at->normal + i] > 0;
    int left = nsdae_event_root_of(p->roots, NSDAE_ROOT_HELD, i)->found;
    is->closed[i] = closed;
    is->touching[i] = closed || root->found;
    is->candidate[i] = closed;
    is->released[i] = closed && (left || (root->found && !presses));
    is->stopped[i] = nsdae_event_root_of(p->roots, NSDAE_ROOT_TANGENT, i)->found;
    is->breakaway[i] = breaks_away(p->roots, y, i);
    if (is->breakaway[i])
      nsdae_slip_direction_against(m->direction + i * d->nt, d->nt, y + at->tangential + i * d->nt);
  }
  for (int j = 0; j < d->f; j++) {
    double force = y[at->frictional_joint + j];
    is->slide_stopped[j] = nsdae_event_root_of(p->roots, NSDAE_ROOT_SLIP, j)->found;
    is->slide_turned[j] = nsdae_event_root_of(p->roots, NSDAE_ROOT_SIGN, j)->found;
    is->slide_breakaway[j] = is->slide_stopped[j] && m->frictional_joint[j] == NSDAE_MODE_STICK;
    if (is->slide_breakaway[j]) m->slide_sense[j] = (force < 0) - (force > 0);
  }
}

/* Touching, not let go, without a velocity apart. */
static void choose_candidates(nsdae_event_instant *p, int impacted)
{
  const nsdae_event_setting *s = p->roots->phase->setting;
  const nsdae_terms *T = s->here;
  const nsdae_event_findings *is = &p->acceleration.is;
  double size = nsdae_event_velocity_size(s);
  for (int i = 0; i < T->system->dims.k; i++) {
    int parts = nsdae_terms_normal_rate(T, i, T->v) > size;
    if (impacted || parts) is->released[i] = 0; /* no acceleration brings it back */
    is->candidate[i] = is->touching[i] && !is->released[i] && !parts;
  }
}

/* A feature that comes to its end may be lost by the rounding of a projection. */
static void open_lost(nsdae_event_instant *p)
{
  const nsdae_event_setting *s = p->roots->phase->setting;
  const nsdae_event_findings *is = &p->acceleration.is;
  double most = LOST * nsdae_event_position_size(s);
  for (int i = 0; i < s->system->dims.k; i++) {
    if (!is->candidate[i] || !(s->here->gap[i] > most)) continue;
    is->touching[i] = is->candidate[i] = 0;
    p->roots->phase->modes.contact[i] = NSDAE_MODE_OPEN;
  }
}

/* Positions to what stays closed; everything at the point of y, with the matrices factored. */
static int bring(nsdae_event_instant *p, double t, double *y)
{
  nsdae_event_setting *s = p->roots->phase->setting;
  const nsdae_event_modes *m = &p->roots->phase->modes;
  int status = nsdae_event_project_positions(&p->projection, t, p->acceleration.is.candidate, y);
  if (status == NSDAE_OK) status = nsdae_terms_need(s->here, NSDAE_EVENT_TERMS);
  if (status == NSDAE_OK) status = nsdae_event_factor(s);
  if (status < 0) return status;
  open_lost(p);
  *m->redundant = s->kkt->m - s->kkt->rank;
  if (*m->redundant) nsdae_kkt_basis(s->kkt, m->basis);
  return NSDAE_OK;
}

static int arrive(nsdae_event_instant *p, double t, double *y)
{
  nsdae_event_setting *s = p->roots->phase->setting;
  const nsdae_event_findings *is = &p->acceleration.is;
  nsdae_event_move(s, t, y);
  int status = nsdae_terms_need(s->here, NSDAE_EVENT_TERMS);
  if (status < 0) return status;
  const nsdae_terms *T = s->here;
  double size = nsdae_event_position_size(s), fast = nsdae_event_velocity_size(s);
  for (int i = 0; i < s->system->dims.k; i++) {
    double gap = T->gap[i], rate = nsdae_terms_normal_rate(T, i, T->v);
    double rounding = 1e3 * DBL_EPSILON * fabs(t * rate); /* of the time where it was found */
    /* past a kink of its gap a contact parts, or another feature is the near one */
    if (is->closed[i] && (rate > LOST * fast || gap > LOST * size)) {
      is->touching[i] = is->candidate[i] = 0;
      p->roots->phase->modes.contact[i] = NSDAE_MODE_OPEN;
    }
    is->touching[i] |= nsdae_event_touches(s, i);
    is->candidate[i] |= (is->touching[i] && fabs(gap) <= 2 * size) || gap < -2 * size - rounding;
  }
  return bring(p, t, y);
}

/* Slower than this a body keeps the direction it slides in. */
static double hardly_sliding(const nsdae_event_phase *p)
{
  const nsdae_terms *T = p->setting->here;
  double size = nsdae_event_velocity_size(p->setting);
  int begins = 0, nt = T->system->dims.nt;
  for (int i = 0; i < T->system->dims.k && nt == 2; i++)
    begins |= p->modes.contact[i] == NSDAE_MODE_SLIP && nsdae_event_hardly_slides(p, i);
  return (begins ? HARDLY : 1) * size;
}

/* Modes of the next phase. Velocities that only errors tell from rest may have accelerations that
 * contradict each other, as of a rod that spins, wedged: where there is no solution, they are asked
 * of those at rest. */
static int choose(nsdae_event_instant *p, int impacted, double *y)
{
  nsdae_event_phase *phase = p->roots->phase;
  const nsdae_event_findings *is = &p->acceleration.is;
  int status = nsdae_event_choose_modes(&p->acceleration, impacted);
  if (status != NSDAE_E_LCP && status != NSDAE_E_PAINLEVE) return status;
  for (int i = 0; i < phase->setting->system->dims.k; i++)
    phase->modes.contact[i] = !is->candidate[i] ? NSDAE_MODE_OPEN
                              : is->moving[i] || !(phase->setting->system->contact[i].mu > 0)
                                  ? NSDAE_MODE_SLIP
                                  : NSDAE_MODE_STICK;
  nsdae_error_clear(phase->setting->error);
  status = nsdae_event_project_velocities(&p->projection, NULL, y);
  if (status == NSDAE_OK) status = nsdae_terms_need(phase->setting->here, NSDAE_EVENT_TERMS);
  return status < 0 ? status : nsdae_event_choose_modes(&p->acceleration, impacted);
}

/* Velocities back to what was closed or stuck in the phase, if they have drifted: an error of the
 * integration, or of derivatives by differences, is neither an impact nor a contact that parts. */
static int bring_velocities(nsdae_event_instant *p, double *y)
{
  const nsdae_event_phase *phase = p->roots->phase;
  const nsdae_terms *T = phase->setting->here;
  double fast = nsdae_event_velocity_size(phase->setting), drift = 0;
  for (int i = 0; i < T->system->dims.k; i++)
    if (phase->modes.contact[i] != NSDAE_MODE_OPEN && !nsdae_event_is_related(phase, i))
      drift = fmax(drift, fabs(nsdae_terms_normal_rate(T, i, T->v)));
  int status = drift > fast && drift <= SUSPECT * fast
                   ? nsdae_event_project_velocities(&p->projection, NULL, y)
                   : NSDAE_OK;
  return status < 0 ? status : nsdae_terms_need(phase->setting->here, NSDAE_EVENT_TERMS);
}

/* Whether a contact was chosen to slide by a velocity that was only what has been projected. */
static int has_stopped(const nsdae_event_instant *p)
{
  const nsdae_event_phase *phase = p->roots->phase;
  const nsdae_event_setting *s = phase->setting;
  double size = nsdae_event_velocity_size(s);
  int any = 0;
  for (int i = 0; i < s->system->dims.k; i++)
    any |= phase->modes.contact[i] == NSDAE_MODE_SLIP && p->acceleration.is.moving[i] &&
           !p->acceleration.is.breakaway[i] && nsdae_terms_slip(s->here, i, s->here->v) <= size;
  return any;
}

/* Modes of the next phase and the velocities that they allow. */
static int choose_and_project(nsdae_event_instant *p, int impacted, double *y)
{
  nsdae_event_setting *s = p->roots->phase->setting;
  int status = NSDAE_OK, again = 1;
  for (int round = 0; round < CHOICES && again && status == NSDAE_OK; round++) {
    status = nsdae_terms_need(s->here, NSDAE_EVENT_TERMS);
    if (status == NSDAE_OK) status = choose(p, impacted, y);
    if (status == NSDAE_OK)
      status = nsdae_event_project_velocities(&p->projection, p->acceleration.is.moving, y);
    again = status == NSDAE_OK && has_stopped(p);
  }
  return status;
}

int nsdae_event_pass(nsdae_event_instant *p, double t, double *y)
{
  nsdae_event_phase *phase = p->roots->phase;
  phase->crossing.at_border = nsdae_event_root_of(p->roots, NSDAE_ROOT_CHANGE, 0)->found;
  sort_found(p, y);
  int status = arrive(p, t, y);
  if (status == NSDAE_OK) status = bring_velocities(p, y);
  const nsdae_counters *counters = &phase->setting->result->counters;
  long ended = counters->accumulations;
  int impacts = status < 0 ? status : nsdae_event_collide(&p->impacts, y);
  if (impacts < 0) return impacts;
  choose_candidates(p, impacts > 0);
  if (counters->accumulations > ended) status = bring(p, t, y);
  if (status == NSDAE_OK) status = choose_and_project(p, impacts > 0, y);
  phase->modes.slow = hardly_sliding(phase);
  phase->modes.none = nsdae_event_acceleration_size(&p->acceleration);
  return status;
}

int nsdae_event_turned(const nsdae_event_instant *p, double t, const double *y)
{
  nsdae_event_setting *s = p->roots->phase->setting;
  const nsdae_event_modes *m = &p->roots->phase->modes;
  if (!*m->redundant || p->roots->phase->crossing.count > 0) return 0;
  nsdae_event_move(s, t, y);
  int status = nsdae_terms_need(s->here, NSDAE_TERM_MASS | NSDAE_TERM_JACOBIAN);
  if (status == NSDAE_OK) status = nsdae_event_factor(s);
  if (status < 0) return status;
  return s->kkt->rank < s->kkt->m && nsdae_kkt_common(s->kkt, m->basis) < s->kkt->rank - TURNED;
}

/* Deviation of constraints, and of closed contacts with a row of their own, in units of the
 * tolerance. A gap that leaves zero with its rate, or loses its gradient, has a kink here: the
 * corner that slides comes to the end of its edge, and another feature is the near one. */
typedef struct deviation {
  double position, velocity; /* of constraints */
  double gap, rate;          /* of contacts */
  double together;           /* of a rate below zero: what is closed would hit itself */
  double unexplained;        /* of the gap, where the rate is zero and there is a gradient */
} deviation;

static deviation deviation_at(const nsdae_event_phase *phase)
{
  const nsdae_terms *T = phase->setting->here;
  const nsdae_dims *d = &T->system->dims;
  double far = nsdae_event_position_size(phase->setting);
  double fast = nsdae_event_velocity_size(phase->setting);
  deviation is = {.position = nsdae_largest(d->m, T->constraint.phi) / far};
  for (int i = 0; i < d->m; i++)
    is.velocity = fmax(is.velocity, fabs(nsdae_terms_constraint_rate(T, i, T->v)) / fast);
  for (int i = 0; i < d->k; i++) {
    if (phase->modes.contact[i] == NSDAE_MODE_OPEN) continue;
    if (nsdae_event_is_related(phase, i)) { /* it moves with others, until a list has it no more */
      if (!(T->gap[i] < NSDAE_FAR)) is.gap = INFINITY;
      continue;
    }
    double gap = fabs(T->gap[i]) / far, rate = fabs(nsdae_terms_normal_rate(T, i, T->v)) / fast;
    int has_normal = nsdae_rows_largest(&T->system->blocks, &T->by.normal, i) > 0;
    is.gap = fmax(is.gap, gap);
    is.rate = fmax(is.rate, rate);
    if (nsdae_terms_normal_rate(T, i, T->v) < 0) is.together = fmax(is.together, rate);
    if (has_normal && rate <= STRAYED) is.unexplained = fmax(is.unexplained, gap);
  }
  return is;
}

int nsdae_event_strayed(const nsdae_event_instant *p, double t, const double *y)
{
  nsdae_event_setting *s = p->roots->phase->setting;
  int closed = (p->roots->phase->terms & NSDAE_TERM_NORMAL) != 0;
  if (s->system->dims.m == 0 && !closed) return 0;
  nsdae_event_move(s, t, y);
  int status = nsdae_terms_need(s->here, p->roots->phase->terms & ~BY_FORCES);
  if (status < 0) return status;
  deviation is = deviation_at(p->roots->phase);
  double lost = fmax(fmax(is.unexplained, is.together), fmax(is.position, is.velocity));
  if (!(lost > LOST))
    return (fmax(lost, fmax(is.gap, is.rate)) > STRAYED) + (is.together > SUSPECT);
  nsdae_error_set(
      s->error, NSDAE_E_CONVERGENCE, "nsdae_event", "rtol",
      "constraints, closed contacts or their velocities have %.3g times the error that rtol = %g "
      "allows at t = %g: check their derivatives (nsdae_system_check), or make rtol larger",
      lost, s->options->rtol, nsdae_terms_time(s->here));
  return nsdae_error_at(s->error, NSDAE_E_CONVERGENCE, -1, nsdae_terms_time(s->here));
}
