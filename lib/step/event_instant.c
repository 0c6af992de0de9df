/* What happens at an instant, in this order: positions are brought back to the constraints and to
 * what is closed; contacts that approach are an impact, one problem of velocities for all that
 * touch (Newton's restitution, Coulomb's friction with impulses); contacts left without approach
 * are closed or let go by one problem of accelerations,
 *
 *   0 <= F_N  _|_  g'' = W_N^T a + omega_N >= 0,   friction as in law.h, on sliding velocities
 * where there are any and on their rates where they are zero (Pfeiffer and Glocker, "Multibody
 * Dynamics with Unilateral Contacts", 1996, chapters 5 and 8)
 *
 * which also gives the modes; velocities are brought to what is closed and what sticks. */
#include <math.h>
#include <string.h>

#include "event_instant.h"

/* Whether the friction of contact i breaks away. Where how friction shares was chosen, a contact at
 * its limit is no reason to slide until all that stick are. */
static int breaks_away(const nsdae_event_method *e, int i)
{
  const nsdae_dims *d = &e->stepper->system->dims;
  int shared = 0, all = 1;
  if (e->mode[i] != NSDAE_MODE_STICK) return 0;
  for (int j = 0; j < d->k; j++) {
    if (e->mode[j] != NSDAE_MODE_STICK) continue;
    for (int l = 0; l < d->nt; l++) shared |= nsdae_event_related(e, d->k + j * d->nt + l);
    all &= e->found[d->k + j] || nsdae_event_stick_margin(e, e->y, j) <= e->root[d->k + j].size;
  }
  return shared ? all : e->found[d->k + i];
}

/* What was found, in terms of the modes so far. */
static void sort_found(nsdae_event_method *e)
{
  const nsdae_dims *d = &e->stepper->system->dims;
  for (int i = 0; i < d->k; i++) {
    int closed = e->mode[i] != NSDAE_MODE_OPEN;
    int undecided =
        closed && e->root[i].state == NSDAE_ROOT_MASKED && e->y[nsdae_at_normal(d) + i] > 0;
    e->touching[i] = closed || e->found[i];
    e->candidate[i] = closed;
    e->released[i] = closed && e->found[i] && !undecided;
    e->breakaway[i] = breaks_away(e, i);
    if (e->breakaway[i])
      nsdae_event_point_against(e->direction + i * d->nt, d->nt,
                                e->y + nsdae_at_tangential(d) + i * d->nt);
  }
  for (int j = 0; j < d->f; j++) {
    double force = e->y[nsdae_at_slide(d) + j];
    e->slide_breakaway[j] = e->found[2 * d->k + d->f + j] && e->slide_mode[j] == NSDAE_MODE_STICK;
    if (e->slide_breakaway[j]) e->slide_sense[j] = (force < 0) - (force > 0);
  }
}

static void add_touching(nsdae_event_method *e)
{
  const nsdae_terms *T = nsdae_event_here(e);
  double x_size = nsdae_event_position_size(e, T);
  for (int i = 0; i < T->system->dims.k; i++) {
    if (nsdae_event_touches(e, i)) e->touching[i] = 1;
    if (e->touching[i] && fabs(T->gap[i]) <= 2 * x_size) e->candidate[i] = 1;
  }
}

/* Touching, not let go, without a velocity apart. */
static void choose_candidates(nsdae_event_method *e, int impacted)
{
  const nsdae_terms *T = nsdae_event_here(e);
  const double *v = e->y + T->system->dims.nq;
  double size = nsdae_event_velocity_size(e, T);
  for (int i = 0; i < T->system->dims.k; i++) {
    if (impacted) e->released[i] = 0;
    e->candidate[i] =
        e->touching[i] && !e->released[i] && !(nsdae_event_normal_velocity(T, i, v) > size);
  }
}

static void find_independent(nsdae_event_method *e)
{
  const nsdae_kkt *kkt = &e->stepper->kkt;
  for (int i = 0; i < kkt->m; i++) e->independent[i] = kkt->rank == kkt->m;
  for (int i = 0; i < kkt->rank && kkt->rank < kkt->m; i++) e->independent[kkt->column[i] - 1] = 1;
}

/* y' and the forces of the new phase. Of the redundant constraints' multipliers only those of the
 * independent ones are guessed here; nsdae_dae_start solves for them. */
static int fill_state(nsdae_event_method *e, double t)
{
  const nsdae_terms *T = nsdae_event_here(e);
  const nsdae_dims *d = &T->system->dims;
  const nsdae_contacts *c = &e->modes;
  double *force = e->y + nsdae_at_lambda(d);
  memset(e->yp, 0, (size_t)e->n * sizeof *e->yp);
  memset(force, 0, (size_t)(e->n - nsdae_at_lambda(d)) * sizeof *force);
  memcpy(e->yp + d->nq, e->a, (size_t)d->nv * sizeof *e->a);
  memcpy(force, e->lambda, (size_t)d->m * sizeof *force);
  for (int i = 0; i < d->m; i++)
    if (!e->independent[i]) force[i] = 0;
  for (int i = 0; i < d->k; i++) {
    if (e->mode[i] == NSDAE_MODE_OPEN) continue;
    e->y[nsdae_at_normal(d) + i] = c->results->normal[i];
    for (int j = i * d->nt; j < (i + 1) * d->nt; j++)
      e->y[nsdae_at_tangential(d) + j] = c->results->tangential[j];
  }
  for (int j = 0; j < d->f; j++) e->y[nsdae_at_slide(d) + j] = c->results->slide_impulse[j];
  return nsdae_stepper_kinematics(e->stepper, t, T->q, e->y + d->nq, e->yp);
}

/* Everything at the point of e->y, with the matrices factored. */
static int arrive(nsdae_event_method *e, double t)
{
  nsdae_terms *T = nsdae_event_here(e);
  const nsdae_dims *d = &T->system->dims;
  nsdae_terms_at(T, t, e->y, e->y + d->nq);
  int status = nsdae_terms_need(T, NSDAE_EVENT_TERMS);
  if (status < 0) return status;
  add_touching(e);
  status = nsdae_event_project_positions(e, t);
  if (status == NSDAE_OK) status = nsdae_terms_need(T, NSDAE_EVENT_TERMS);
  if (status == NSDAE_OK) status = nsdae_stepper_factor(e->stepper, T, T->M);
  if (status == NSDAE_OK) find_independent(e);
  return status;
}

int nsdae_event_instant(nsdae_event_method *e, double t)
{
  sort_found(e);
  int status = arrive(e, t);
  if (status < 0) return status;
  int impacted = 0;
  status = nsdae_event_impacts(e, t, &impacted);
  if (status < 0) return status;
  choose_candidates(e, impacted);
  status = nsdae_event_find_modes(e, t, impacted);
  if (status < 0) return status;
  memcpy(e->stepper->v, e->a, (size_t)e->stepper->system->dims.nv * sizeof *e->a);
  status = nsdae_event_project_velocities(e);
  memcpy(e->a, e->stepper->v, (size_t)e->stepper->system->dims.nv * sizeof *e->a);
  if (status == NSDAE_OK) status = fill_state(e, t);
  e->slow = nsdae_event_velocity_size(e, nsdae_event_here(e));
  e->instant = t;
  e->changes++;
  return status;
}
