#include "acceleration.h"

#include <math.h>

enum { DIRECTIONS = 20 };

static double slip_rate(const nsdae_contacts *c, int i)
{
  int nt = c->system->dims.nt;
  return nsdae_norm(nt, c->results->after_t + i * nt);
}

/* Mode of a contact that rests, under friction, from the problem's solution. */
static int resting_mode(nsdae_event_acceleration *p, int a)
{
  const nsdae_contacts *c = &p->problem;
  int i = c->active[a], nt = c->system->dims.nt, mode = c->results->mode[i];
  const double *force = c->results->tangential + i * nt, *rate = c->results->after_t + i * nt;
  double *direction = p->phase->modes.direction + i * nt;
  if (nsdae_contacts_powerless(c, c->first_column[a] + 1)) return NSDAE_MODE_SLIP;
  if (nt == 2 && mode == NSDAE_MODE_STICK &&
      hypot(force[0], force[1]) > c->system->contact[i].mu * c->results->normal[i])
    mode = NSDAE_MODE_SLIP; /* outside the cone though inside the polygon around it */
  if (mode == NSDAE_MODE_SLIP) nsdae_slip_direction_against(direction, nt, force);
  if (mode == NSDAE_MODE_SLIP && nt == 2) {
    double speed = slip_rate(c, i);
    for (int l = 0; l < nt && speed > nsdae_event_acceleration_size(p); l++)
      direction[l] = rate[l] / speed;
  }
  return mode;
}

/* What touches without a force may get one by its neighbours: the way that it begins to slide. */
static void point_along(nsdae_event_acceleration *p, int i)
{
  const nsdae_contacts *c = &p->problem;
  int nt = c->system->dims.nt;
  double speed = slip_rate(c, i);
  for (int l = 0; l < nt && speed > nsdae_event_acceleration_size(p) && !p->is.moving[i]; l++)
    p->phase->modes.direction[i * nt + l] = c->results->after_t[i * nt + l] / speed;
}

static void read_contacts(nsdae_event_acceleration *p)
{
  const nsdae_contacts *c = &p->problem;
  int *mode = p->phase->modes.contact;
  double size = nsdae_event_acceleration_size(p);
  /* a force that is the error of a solved problem holds nothing */
  double none = c->lcp.options.tol * nsdae_largest(c->system->dims.k, c->results->normal);
  int parting = 0;
  for (int i = 0; i < c->system->dims.k; i++) {
    mode[i] = NSDAE_MODE_OPEN;
    parting |= p->is.released[i];
  }
  for (int a = 0; a < c->active_count; a++) {
    int i = c->active[a];
    if (!(c->results->normal[i] > 0) && c->results->after[i] > size) continue;
    /* one that opens is not replaced by another that has no force: they would take turns */
    if (parting && !p->is.closed[i] && !(c->results->normal[i] > none)) continue;
    mode[i] = NSDAE_MODE_SLIP; /* also where it touches without a force */
    if (!(c->results->normal[i] > none))
      point_along(p, i);
    else if (c->law[a].kind != NSDAE_SLIDING && c->law[a].columns > 1)
      mode[i] = resting_mode(p, a);
  }
}

/* What slides in the solution with the cones: d is against its friction, which is all used. */
static void read_cones(nsdae_event_acceleration *p)
{
  const nsdae_contacts *c = &p->problem;
  nsdae_event_modes *m = &p->phase->modes;
  double size = nsdae_event_acceleration_size(p);
  read_contacts(p);
  for (int a = 0; a < c->active_count; a++) {
    int i = c->active[a];
    if (m->contact[i] == NSDAE_MODE_OPEN || c->law[a].kind != NSDAE_POLYGON ||
        !(c->results->normal[i] > 0) || nsdae_contacts_powerless(c, c->first_column[a] + 1))
      continue;
    m->contact[i] = slip_rate(c, i) > size ? NSDAE_MODE_SLIP : NSDAE_MODE_STICK;
    if (m->contact[i] == NSDAE_MODE_SLIP)
      nsdae_slip_direction_against(m->direction + 2 * i, 2, c->results->tangential + 2 * i);
  }
}

/* The first slide with two solutions, and the one that is taken. */
static void note_twofold(const nsdae_event_acceleration *p, int j)
{
  const nsdae_contacts *c = &p->problem;
  const nsdae_event_setting *s = p->phase->setting;
  nsdae_twofold *twofold = &s->result->twofold;
  int frictional_joint = c->slides.number[j];
  if (twofold->frictional_joint < 0 && !p->by_cones && nsdae_painleve_twofold(c, j))
    *twofold = (nsdae_twofold){frictional_joint, nsdae_terms_time(s->here),
                               p->lambda[c->system->frictional_joint[frictional_joint].constraint]};
}

static void read_slides(nsdae_event_acceleration *p)
{
  const nsdae_contacts *c = &p->problem;
  nsdae_event_modes *m = &p->phase->modes;
  for (int i = 0; i < c->slides.count; i++) {
    note_twofold(p, i);
    int j = c->slides.number[i], column = c->columns - c->slides.count + i;
    int powerless = nsdae_contacts_powerless(c, column);
    double force = powerless ? 0 : c->results->frictional_joint_impulse[j],
           rate = c->results->slide_after[j];
    m->frictional_joint[j] =
        p->sense[j] || !powerless ? c->results->frictional_joint_mode[j] : NSDAE_MODE_SLIP;
    m->slide_sense[j] = p->sense[j];
    if (!p->sense[j] && m->frictional_joint[j] == NSDAE_MODE_SLIP)
      m->slide_sense[j] = force != 0 ? (force < 0) - (force > 0) : (rate > 0) - (rate < 0);
    const nsdae_frictional_joint *joint = &c->system->frictional_joint[j];
    int sense = joint->mu > 0 && p->lambda[joint->constraint] < 0 ? -1 : 1;
    m->normal_sense[j] = p->is.slide_turned[j] ? -m->normal_sense[j] : sense;
  }
}

/* Whether a contact that was let go would come back at once. */
static int comes_back(nsdae_event_acceleration *p)
{
  const nsdae_terms *T = p->phase->setting->here;
  int any = 0;
  for (int i = 0; i < T->system->dims.k; i++) {
    if (!p->is.released[i]) continue;
    double rate = nsdae_terms_rate(T, &T->by.normal, T->omega.N, i, p->a);
    if (rate >= -nsdae_event_acceleration_size(p)) continue;
    p->is.released[i] = 0;
    p->is.candidate[i] = 1;
    any = 1;
  }
  return any;
}

/* Whether a contact or frictional joint whose friction was used up would rather slide the other
 * way: then it is asked again without a direction. */
static int sticks_after_all(nsdae_event_acceleration *p)
{
  const nsdae_contacts *c = &p->problem;
  const nsdae_event_modes *m = &p->phase->modes;
  const nsdae_dims *d = &c->system->dims;
  double size = nsdae_event_acceleration_size(p);
  int any = 0;
  for (int i = 0; i < d->k; i++) {
    int first = i * d->nt;
    if (!p->is.breakaway[i] ||
        nsdae_dot(d->nt, m->direction + first, c->results->after_t + first) >= -size)
      continue;
    p->is.breakaway[i] = 0;
    any = 1;
  }
  for (int j = 0; j < d->f; j++) {
    if (!p->is.slide_breakaway[j] || m->slide_sense[j] * c->results->slide_after[j] >= -size)
      continue;
    p->is.slide_breakaway[j] = 0;
    any = 1;
  }
  return any;
}

/* The direction of contact i that begins to slide: that of its own acceleration. Returns how much
 * it changed. */
static double turn(nsdae_event_acceleration *p, int i, int round)
{
  const nsdae_contacts *c = &p->problem;
  double *d = p->phase->modes.direction + 2 * i, *rate = p->problem.results->after_t + 2 * i;
  double speed = slip_rate(c, i), moved = 0;
  if (round > 0 && p->law[i].kind == NSDAE_SLIDING && p->is.candidate[i] == 2 &&
      speed > nsdae_event_acceleration_size(p)) {
    moved = hypot(rate[0] / speed - d[0], rate[1] / speed - d[1]);
    for (int l = 0; l < 2; l++) d[l] = rate[l] / speed;
  }
  if (p->law[i].kind == NSDAE_POLYGON) {
    p->is.candidate[i] = 2; /* its direction follows its acceleration */
    moved = 1;
  }
  p->law[i] = nsdae_law_sliding(2, c->system->contact[i].mu, d);
  return moved;
}

/* A resting contact with two directions slides along its own acceleration: d = v_T' / |v_T'|, found
 * by substitution. */
static int settle_directions(nsdae_event_acceleration *p)
{
  const nsdae_system *s = p->problem.system;
  int status = NSDAE_OK;
  for (int round = 0; s->dims.nt == 2 && round < DIRECTIONS && status == NSDAE_OK; round++) {
    double moved = 0;
    for (int i = 0; i < s->dims.k; i++)
      if (p->is.candidate[i] && p->phase->modes.contact[i] == NSDAE_MODE_SLIP &&
          s->contact[i].mu > 0)
        moved = fmax(moved, turn(p, i, round));
    if (!(moved > 1e-13)) break;
    status = nsdae_event_accelerate(p, NSDAE_PAINLEVE_EXACT);
    if (status == NSDAE_OK) p->by_cones ? read_cones(p) : read_contacts(p);
  }
  return status;
}

/* Whether a contact at rest starts in a direction that is not known to be right. */
static int begins_to_slide(const nsdae_event_acceleration *p)
{
  const nsdae_contacts *c = &p->problem;
  int any = 0;
  for (int i = 0; i < c->system->dims.k && c->system->dims.nt == 2; i++)
    any |= p->phase->modes.contact[i] == NSDAE_MODE_SLIP && !p->is.moving[i] &&
           slip_rate(c, i) > nsdae_event_acceleration_size(p);
  return any;
}

/* How what was solved shares between the contacts, into the modes. */
static int share(nsdae_event_acceleration *p)
{
  const nsdae_event_setting *s = p->phase->setting;
  const nsdae_event_modes *m = &p->phase->modes;
  const nsdae_shared of = {.problem = &p->problem,
                           .lambda = p->lambda,
                           .rank_tol = s->options->rank_tol,
                           .none = nsdae_event_acceleration_size(p),
                           .looser = p->looser,
                           .mode = m->contact,
                           .moving = p->is.moving,
                           .breakaway = p->is.breakaway,
                           .frictional_joint_mode = m->frictional_joint,
                           .slide_sense = m->slide_sense,
                           .related = m->related,
                           .relation = m->relation,
                           .slide_row = m->slide_row,
                           .slide_part = m->slide_part};
  if (nsdae_share(&p->sharing, &of)) return NSDAE_OK;
  nsdae_error_set(s->error, NSDAE_E_CONVERGENCE, "nsdae_event", "polygon",
                  "no friction forces of the sticking contacts were found at t = %g: try more "
                  "edges of the polygon, or method = implicit",
                  nsdae_terms_time(s->here));
  return nsdae_error_at(s->error, NSDAE_E_CONVERGENCE, -1, nsdae_terms_time(s->here));
}

int nsdae_event_choose_modes(nsdae_event_acceleration *p, int impacted)
{
  int status;
  do {
    nsdae_event_set_laws(p, impacted, nsdae_event_velocity_size(p->phase->setting));
    status = nsdae_event_accelerate(p, NSDAE_PAINLEVE_EXACT);
    if (status < 0) return status;
  } while (comes_back(p) || (!impacted && sticks_after_all(p)));
  read_contacts(p);
  read_slides(p);
  if (!p->by_cones && !begins_to_slide(p) && share(p) == NSDAE_OK) return NSDAE_OK;
  if (p->by_cones || nsdae_projected_gauss_seidel(&p->problem, p->phase->modes.direction, p->force,
                                                  p->xi, p->a, p->lambda))
    read_cones(p);
  else
    status = settle_directions(p);
  return status < 0 ? status : share(p);
}
