/* Modes of contacts and slides from the problem of accelerations, which is asked again where its
 * answer is not what was assumed. */
#include <math.h>
#include <string.h>

#include "event_instant.h"
#include "vector.h"

enum { DIRECTIONS = 20 };

void nsdae_event_point_against(double *direction, int nt, const double *force)
{
  double size = 0;
  for (int l = 0; l < nt; l++) size = hypot(size, force[l]);
  for (int l = 0; l < nt; l++) direction[l] = size > 0 ? -force[l] / size : 0;
}

/* Mode of a contact that rests, under friction, from the problem's solution. */
static int resting_mode(nsdae_event_method *e, int a)
{
  const nsdae_contacts *c = &e->modes;
  int i = c->active[a], nt = e->stepper->system->dims.nt, mode = c->results->mode[i];
  const double *force = c->results->tangential + i * nt, *rate = c->results->after_t + i * nt;
  double *direction = e->direction + i * nt;
  if (nsdae_event_powerless(c, c->first_column[a] + 1)) return NSDAE_MODE_SLIDE;
  if (nt == 2 && mode == NSDAE_MODE_STICK &&
      hypot(force[0], force[1]) > e->stepper->system->contact[i].mu * c->results->normal[i])
    mode = NSDAE_MODE_SLIDE; /* outside the cone though inside the polygon around it */
  if (mode == NSDAE_MODE_SLIDE) nsdae_event_point_against(direction, nt, force);
  if (mode == NSDAE_MODE_SLIDE && nt == 2) {
    double speed = hypot(rate[0], rate[1]);
    for (int l = 0; l < nt && speed > nsdae_event_acceleration_size(e); l++)
      direction[l] = rate[l] / speed;
  }
  return mode;
}

static void read_contacts(nsdae_event_method *e)
{
  const nsdae_contacts *c = &e->modes;
  const nsdae_dims *d = &e->stepper->system->dims;
  double size = nsdae_event_acceleration_size(e);
  for (int i = 0; i < d->k; i++) e->mode[i] = NSDAE_MODE_OPEN;
  for (int a = 0; a < c->active_count; a++) {
    int i = c->active[a];
    if (!(c->results->normal[i] > 0) && c->results->after[i] > size) continue;
    e->mode[i] = NSDAE_MODE_SLIDE; /* also where it touches without a force */
    if (c->results->normal[i] > 0 && c->law[i].kind != NSDAE_SLIDING && c->law[i].columns > 1)
      e->mode[i] = resting_mode(e, a);
  }
}

static void read_slides(nsdae_event_method *e)
{
  const nsdae_contacts *c = &e->modes;
  const nsdae_system *s = e->stepper->system;
  for (int i = 0; i < c->slide_count; i++) {
    int j = c->slide[i];
    double force = c->results->slide_impulse[j], rate = c->results->slide_after[j];
    e->slide_mode[j] = c->results->slide_mode[j];
    e->slide_sense[j] = e->sliding_sense[j];
    if (!e->sliding_sense[j] && nsdae_event_powerless(c, c->columns - c->slide_count + i))
      e->slide_mode[j] = NSDAE_MODE_SLIDE, e->slide_sense[j] = (rate > 0) - (rate < 0);
    else if (!e->sliding_sense[j] && e->slide_mode[j] == NSDAE_MODE_SLIDE)
      e->slide_sense[j] = force != 0 ? (force < 0) - (force > 0) : (rate > 0) - (rate < 0);
    double normal = e->lambda[s->slide[j].constraint];
    int turned = e->found[2 * s->dims.k + j];
    e->normal_sense[j] = turned ? -e->normal_sense[j] : normal < 0 ? -1 : 1;
  }
}

/* Whether a contact that was let go would come back at once. */
static int comes_back(const nsdae_event_method *e)
{
  const nsdae_terms *T = nsdae_event_here(e);
  int n = T->system->dims.nv, any = 0;
  for (int i = 0; i < T->system->dims.k; i++) {
    if (!e->released[i]) continue;
    double rate = nsdae_dot(n, T->W_N + (size_t)(i * n), e->a) + T->omega_N[i];
    if (rate >= -nsdae_event_acceleration_size(e)) continue;
    e->released[i] = 0;
    e->candidate[i] = 1;
    any = 1;
  }
  return any;
}

/* Whether a contact or slide whose friction was used up would rather slide the other way: then it
 * is asked again without a direction. */
static int sticks_after_all(nsdae_event_method *e)
{
  const nsdae_contacts *c = &e->modes;
  const nsdae_dims *d = &e->stepper->system->dims;
  double size = nsdae_event_acceleration_size(e);
  int any = 0;
  for (int i = 0; i < d->k; i++) {
    double along = 0;
    for (int l = 0; l < d->nt; l++)
      along += e->direction[i * d->nt + l] * c->results->after_t[i * d->nt + l];
    if (!e->breakaway[i] || along >= -size) continue;
    e->breakaway[i] = 0;
    any = 1;
  }
  for (int j = 0; j < d->f; j++) {
    if (!e->slide_breakaway[j] || e->slide_sense[j] * c->results->slide_after[j] >= -size) continue;
    e->slide_breakaway[j] = 0;
    any = 1;
  }
  return any;
}

/* A resting contact with two directions slides along its own acceleration: d = v_T' / |v_T'|, found
 * by substitution. */
static int settle_directions(nsdae_event_method *e, double t)
{
  const nsdae_system *s = e->stepper->system;
  int nt = s->dims.nt, status = NSDAE_OK;
  for (int round = 0; nt == 2 && round < DIRECTIONS && status == NSDAE_OK; round++) {
    double moved = 0;
    for (int i = 0; i < s->dims.k; i++) {
      double *d = e->direction + 2 * i, *rate = e->modes.results->after_t + 2 * i;
      double speed = hypot(rate[0], rate[1]);
      if (!e->candidate[i] || e->mode[i] != NSDAE_MODE_SLIDE || !(s->contact[i].mu > 0)) continue;
      if (round > 0 && e->law[i].kind == NSDAE_SLIDING && e->candidate[i] == 2 &&
          speed > nsdae_event_acceleration_size(e)) {
        moved = fmax(moved, hypot(rate[0] / speed - d[0], rate[1] / speed - d[1]));
        d[0] = rate[0] / speed;
        d[1] = rate[1] / speed;
      }
      if (e->law[i].kind == NSDAE_POLYGON) {
        e->candidate[i] = 2; /* its direction follows its acceleration */
        moved = 1;
      }
      e->law[i] = nsdae_law_sliding(nt, s->contact[i].mu, d);
    }
    if (!(moved > 1e-13)) break;
    status = nsdae_event_accelerate(e, t);
    if (status == NSDAE_OK) read_contacts(e);
  }
  return status;
}

static double slip_rate(const nsdae_event_method *e, int i)
{
  int nt = e->stepper->system->dims.nt;
  double rate = 0;
  for (int l = 0; l < nt; l++) rate = hypot(rate, e->modes.results->after_t[i * nt + l]);
  return rate;
}

/* Others hold it. Where one just broke away its neighbours are about to. */
void nsdae_event_hold_resting(nsdae_event_method *e)
{
  const nsdae_contacts *c = &e->modes;
  int any = 0;
  double size = nsdae_event_acceleration_size(e);
  for (int i = 0; i < e->stepper->system->dims.k; i++) any |= e->breakaway[i];
  for (int a = 0; a < c->active_count && !any; a++) {
    int i = c->active[a];
    if (e->mode[i] != NSDAE_MODE_SLIDE || e->moving[i] || !(c->results->normal[i] > 0)) continue;
    if (c->law[i].columns == 1 || nsdae_event_powerless(c, c->first_column[a] + 1)) continue;
    if (slip_rate(e, i) <= size) e->mode[i] = NSDAE_MODE_STICK;
  }
}

/* Whether a contact at rest starts in a direction that is not known to be right. */
static int begins_to_slide(const nsdae_event_method *e)
{
  const nsdae_dims *d = &e->stepper->system->dims;
  double size = nsdae_event_acceleration_size(e);
  int any = 0;
  for (int i = 0; i < d->k && d->nt == 2; i++)
    any |= e->mode[i] == NSDAE_MODE_SLIDE && !e->moving[i] && slip_rate(e, i) > size;
  return any;
}

/* What slides in the solution with the cones: d is against its friction, which is all used. */
static void read_cones(nsdae_event_method *e)
{
  const nsdae_contacts *c = &e->modes;
  double size = nsdae_event_acceleration_size(e);
  read_contacts(e);
  for (int a = 0; a < c->active_count; a++) {
    int i = c->active[a];
    if (e->mode[i] == NSDAE_MODE_OPEN || c->law[i].kind != NSDAE_POLYGON ||
        !(c->results->normal[i] > 0))
      continue;
    if (nsdae_event_powerless(c, c->first_column[a] + 1)) continue;
    e->mode[i] = slip_rate(e, i) > size ? NSDAE_MODE_SLIDE : NSDAE_MODE_STICK;
    if (e->mode[i] == NSDAE_MODE_SLIDE)
      nsdae_event_point_against(e->direction + 2 * i, 2, c->results->tangential + 2 * i);
  }
}

int nsdae_event_find_modes(nsdae_event_method *e, double t, int impacted)
{
  int status;
  do {
    nsdae_event_set_laws(e, impacted);
    status = nsdae_event_accelerate(e, t);
    if (status < 0) return status;
  } while (comes_back(e) || (!impacted && sticks_after_all(e)));
  read_contacts(e);
  read_slides(e);
  if (!begins_to_slide(e) && nsdae_event_find_rows(e, t) == NSDAE_OK) return NSDAE_OK;
  if (nsdae_event_solve_cones(e))
    read_cones(e);
  else
    status = settle_directions(e, t);
  return status < 0 ? status : nsdae_event_find_rows(e, t);
}
