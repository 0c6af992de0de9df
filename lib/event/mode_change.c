/* The events between the smooth phases: the transition (instant.h), its failures, the start of the
 * next phase, and contacts that chatter. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "acceleration.h"
#include "errors.h"
#include "event_method.h"

/* ---- kink */

/* Steps of the integrator follow a normal that turns by far less. */
static const double COSINE = 0.5;

/* The cosine between the normals of contact i at two points, in the metric of M^-1. */
static double cosine(nsdae_event_instant *p, const nsdae_terms *a, const nsdae_terms *b, int i)
{
  const nsdae_blocks *blocks = &a->system->blocks;
  const nsdae_rows *of[] = {&a->by.normal, &b->by.normal};
  double *z = p->acceleration.size, product[2][2];
  for (int l = 0; l < 2; l++) {
    memset(z, 0, (size_t)a->system->dims.nv * sizeof *z);
    nsdae_rows_add(blocks, of[l], i, 1, z);
    nsdae_kkt_solve_mass(p->roots->phase->setting->kkt, z);
    for (int j = 0; j < 2; j++) product[l][j] = nsdae_rows_dot(blocks, of[j], i, z);
  }
  return product[0][1] / sqrt(product[0][0] * product[1][1]);
}

/* The closed contact, or -1, whose normal turns on the way of that time from the point in work. The
 * end of the step that failed has room for a second point. */
static int find_kink(nsdae_event_instant *p, double *q, double time)
{
  const nsdae_event_phase *phase = p->roots->phase;
  nsdae_terms *here = phase->setting->here, *there = &phase->setting->result->end;
  double *qdot = p->projection.qdot;
  if (nsdae_terms_need(here, NSDAE_TERM_NORMAL) < 0 || nsdae_kinematics_at(here, here->v, qdot) < 0)
    return -1;
  for (int i = 0; i < here->system->dims.nq; i++) q[i] = here->q[i] + time * qdot[i];
  nsdae_terms_at(there, here->t, q, here->v);
  if (nsdae_terms_need(there, NSDAE_TERM_NORMAL) < 0) return -1;
  for (int i = 0; i < here->system->dims.k; i++)
    if (phase->modes.contact[i] != NSDAE_MODE_OPEN && cosine(p, here, there, i) < COSINE) return i;
  return -1;
}

int nsdae_event_explain_strayed(nsdae_event_instant *p, double *q)
{
  const nsdae_event_setting *s = p->roots->phase->setting;
  nsdae_error *error = s->error, kept = *error;
  char called[NSDAE_CALLED_SIZE];
  double dt = s->options->dt;
  int i = find_kink(p, q, -dt);
  if (i < 0) i = find_kink(p, q, dt);
  *error = kept;
  if (i < 0) return error->status;
  nsdae_error_set(error, NSDAE_E_CONVERGENCE, "nsdae_event", "gap_normal",
                  "%s: the gradient of its gap rotates by more than 60 degrees within dt = %g at t "
                  "= %.17g (for example an edge that becomes a flat contact): round the edge, use "
                  "more contacts, or a smaller dt",
                  nsdae_system_called(s->system, NSDAE_NAME_CONTACT, i, called), dt,
                  nsdae_terms_time(s->here));
  error->index = nsdae_system_index(s->system, NSDAE_NAME_CONTACT, i);
  error->time = nsdae_terms_time(s->here);
  return error->status;
}

/* Events without an impact or a change of mode before tolerances grow. */
enum { CHATTERS = 20, STILL = 16 };

/* An instant of a contact is soon after another within this number of accumulation_time. One of
 * friction that breaks away or stops before it has left zero leads nowhere and counts for STILL of
 * them. */
static const double SOON = 10;

/* Sines of rows that depend, in parts of the least one: from step to step, and at most. */
static const double LOOSER = 100, LOOSEST = 1e4;

/* The constraint that the others nearly determine at t, by a sine up to rtol^(1/2), at which an
 * error of rtol is all of it; or -1. */
static int nearly_dependent(nsdae_event *e, double t, double *sine)
{
  nsdae_event_setting *s = &e->setting;
  int rank = s->system->dims.m - *e->phase.modes.redundant;
  if (rank < 2) return -1;
  nsdae_event_move(s, t, e->integrator.y);
  int status = nsdae_event_sine(s, rank - 1, sine);
  nsdae_error_clear(s->error);
  *sine = s->kkt->left;
  return status == NSDAE_OK && *sine <= sqrt(s->options->rtol) ? s->kkt->dependent : -1;
}

int nsdae_event_failed(nsdae_event *e, int status, double t)
{
  nsdae_error *error = e->setting.error;
  const char *cause = e->integrator.smooth.cause;
  if (error->status != NSDAE_OK) return error->status;
  status = status == NSDAE_E_CALLBACK ? NSDAE_E_CONVERGENCE : status; /* none failed */
  int contact = nsdae_event_unbounded(&e->roots, NSDAE_EVENT_POLE);
  if (contact >= 0)
    return nsdae_painleve_unbounded(&e->instant.acceleration.problem, contact, t,
                                    nsdae_event_yield(&e->phase, contact));
  if (nsdae_event_diagnose(&e->instant.acceleration, t, e->integrator.y) < 0)
    return NSDAE_E_PAINLEVE;
  char called[NSDAE_CALLED_SIZE], near[NSDAE_CALLED_SIZE + 80] = "";
  double sine, time = nsdae_system_time(e->setting.system, t);
  int row = nearly_dependent(e, t, &sine);
  if (row >= 0)
    snprintf(near, sizeof near, "; %s depends on the other constraints up to a sine of %.2g",
             nsdae_system_called(e->setting.system, NSDAE_NAME_CONSTRAINT, row, called), sine);
  nsdae_error_set(
      error, status, "nsdae_event", "rtol",
      "the integrator failed at t = %g: no step length satisfies rtol and atol%s%s%s; the "
      "equations may have no solution after this time: try a larger rtol, or method = implicit",
      time, *cause ? ", reason of SUNDIALS: " : "", cause, near);
  int index = row >= 0 ? nsdae_system_index(e->setting.system, NSDAE_NAME_CONSTRAINT, row) : -1;
  return nsdae_error_at(error, status, index, time);
}

void nsdae_event_set_integrator(nsdae_event *e)
{
  int integrator = e->setting.options->integrator;
  *e->phase.modes.integrator =
      integrator == NSDAE_INTEGRATOR_AUTO ? NSDAE_INTEGRATOR_DOPRI5 : integrator;
}

int nsdae_event_start(nsdae_event *e, double t)
{
  nsdae_event_save(&e->base, &e->integrator, t);
  int status = nsdae_event_integrator_start(&e->integrator, t);
  return status < 0 ? nsdae_event_failed(e, status, t) : status;
}

static int contradiction(nsdae_event *e, int entry, double t)
{
  t = nsdae_system_time(e->setting.system, t);
  const nsdae_event_root *root = &e->roots.entry[entry];
  int contact = root->kind <= NSDAE_ROOT_HELD;
  nsdae_error *error = e->setting.error;
  nsdae_error_set(error, NSDAE_E_CONVERGENCE, "nsdae_event", "rtol",
                  "forces contradict the contact modes at t = %g: %s is %.3g, below the bound "
                  "for rtol = %g (%.3g); the rows of closed contacts are nearly dependent: try "
                  "another rtol, or method = implicit",
                  t, root->kind == NSDAE_ROOT_NORMAL ? "a contact force" : "a friction margin",
                  root->start, e->setting.options->rtol, -root->size);
  nsdae_system_name_item(e->setting.system,
                         contact ? NSDAE_NAME_CONTACT : NSDAE_NAME_FRICTIONAL_JOINT, root->index,
                         error);
  error->time = t;
  return NSDAE_E_CONVERGENCE;
}

/* The instant t at the state of the integrator's y, and the start of the next phase. Rows that are
 * independent by little more than errors may have forces that contradict the modes: then more of
 * them depend on others. */
int nsdae_event_restart(nsdae_event *e, double t)
{
  int status, wrong = -1;
  double *looser = &e->instant.acceleration.looser;
  for (*looser = 1; *looser <= LOOSEST; *looser *= LOOSER) {
    status = nsdae_event_pass(&e->instant, t, e->integrator.y);
    nsdae_event_set_integrator(e);
    if (status == NSDAE_OK) status = nsdae_event_start(e, t);
    wrong = status < 0 ? -1 : nsdae_event_inconsistent(&e->roots);
    if (wrong < 0) break;
    for (int i = 0; i < e->roots.count; i++) e->roots.entry[i].found = 0;
  }
  e->setting.result->counters.events++;
  ++*e->base.instants;
  return wrong < 0 ? status : contradiction(e, wrong, t);
}

/* Whether a contact force changed its sign without a zero: from one end of the doubles to the
 * other. */
static int has_jumped(const nsdae_event *e)
{
  int any = 0;
  for (int i = 0; i < e->setting.system->dims.k; i++) {
    const nsdae_event_root *root = nsdae_event_root_of(&e->roots, NSDAE_ROOT_NORMAL, i);
    double force = fabs(e->integrator.y[e->setting.at.normal + i]);
    any |= root->found && e->phase.modes.contact[i] != NSDAE_MODE_OPEN && force > root->size;
  }
  return any;
}

/* The contact that slides and has met the pole of its force, or -1: see nsdae_root_kind. What
 * hardly slides has stopped. */
static int meets_pole(const nsdae_event *e)
{
  int met = nsdae_event_root_of(&e->roots, NSDAE_ROOT_JAM, 0)->found || has_jumped(e);
  int i = met ? nsdae_event_unbounded(&e->roots, NSDAE_EVENT_POLE) : -1;
  if (i < 0 || e->setting.system->dims.nt < 2 || !nsdae_event_hardly_slides(&e->phase, i)) return i;
  nsdae_event_root_of(&e->roots, NSDAE_ROOT_TANGENT, i)->found = 1;
  return -1;
}

/* NSDAE_E_PAINLEVE if the modes that are chosen at the pole of contact i are those of an unbounded
 * force, or if i opens with no acceleration: the force is needed (Genot and Brogliato 1999). */
static int jammed(const nsdae_event *e, double t, int i, double coefficient)
{
  const nsdae_terms *T = e->setting.here;
  const double *a = e->instant.acceleration.a;
  int worst = nsdae_event_unbounded(&e->roots, NSDAE_EVENT_POLE);
  double size = fabs(T->omega.N[i]) + nsdae_rows_dot_sizes(&T->system->blocks, &T->by.normal, i, a);
  double apart = nsdae_terms_rate(T, &T->by.normal, T->omega.N, i, a);
  int opens = e->phase.modes.contact[i] == NSDAE_MODE_OPEN && apart > NSDAE_EVENT_POLE * size;
  if (worst < 0 && (opens || e->phase.modes.contact[i] != NSDAE_MODE_OPEN)) return NSDAE_OK;
  return nsdae_painleve_unbounded(&e->instant.acceleration.problem, i, t, coefficient);
}

/* Where friction turns faster than a body gets away from zero, or is at its limit however it
 * shares, instant follows instant and nothing is decided. Past CHATTERS of them the tolerance
 * for friction doubles with every eighth, until time goes on: as Filippov's solution does. The same
 * of a contact that rattles, as one that friction throws back, and of its impacts. */
void nsdae_event_blur(nsdae_event *e)
{
  double idle = nsdae_chattering_growth(*e->base.idle, CHATTERS, 8);
  e->instant.impacts.accumulation.rattles = e->base.rattle.count;
  for (int i = 0; i < e->setting.system->dims.k; i++) {
    e->instant.impacts.blur[i] = nsdae_chattering_blur(&e->base.rattle, i);
    e->phase.modes.blur[i] = fmax(idle, e->instant.impacts.blur[i]);
  }
}

static void note_rattle(const nsdae_event *e, double t, int i, int many)
{
  nsdae_chattering_note(&e->base.rattle, i, t, SOON * e->setting.options->accumulation_time, many);
}

/* At the instant t, with the impacts from `first` on. */
static void note_rattles(const nsdae_event *e, double t, int first)
{
  const nsdae_result *r = e->setting.result;
  for (int i = 0; i < e->setting.system->dims.k; i++) {
    int any = e->mode_before[i] != e->phase.modes.contact[i];
    for (int j = first; j < r->impacts; j++) any |= r->impact[j].contact == i;
    if (any) note_rattle(e, t, i, 1);
  }
}

/* Differences for the motion at the point in work, and the most that they leave of velocities and
 * accelerations here and where they were tuned before. */
int nsdae_event_tune(nsdae_event *e, double t)
{
  nsdae_differences *d = &e->tools->differences;
  const double *y = e->integrator.y;
  if (!nsdae_differences_used(e->setting.system)) return NSDAE_OK;
  double error[2], time = nsdae_system_time(e->setting.system, t);
  int code = nsdae_differences_tune(d, time, y, y + e->setting.at.v, error);
  for (int i = 0; i < 2; i++) {
    e->base.finer[i] = d->finer[i];
    e->base.difference_error[i] = fmax(e->base.difference_error[i], error[i]);
    e->setting.error_by_differences[i] = e->base.difference_error[i];
  }
  return nsdae_differences_status(d, code, "gap", time, e->setting.error);
}

int nsdae_event_change_modes(nsdae_event *e, double t)
{
  nsdae_result *r = e->setting.result;
  const nsdae_dims *d = &e->setting.system->dims;
  const nsdae_event_modes *m = &e->phase.modes;
  memcpy(e->mode_before, m->contact, (size_t)d->k * sizeof *m->contact);
  memcpy(e->slide_mode_before, m->frictional_joint, (size_t)d->f * sizeof *m->frictional_joint);
  int first = r->impacts, before = r->impacts + r->changes, found = 0;
  for (int i = 0; i < e->roots.count; i++) {
    const nsdae_event_root *root = &e->roots.entry[i];
    found |= root->found;
    if (root->kind == NSDAE_ROOT_TANGENT && root->found && !root->moved)
      note_rattle(e, t, root->index, STILL);
  }
  nsdae_event_blur(e);
  int status = nsdae_event_slots_add(e, t);
  /* Contacts that were open have no solution to start from, whether they had a slot or not. */
  size_t rows = (size_t)e->tools->contacts.rows_most;
  for (int i = 0; i < e->setting.system->dims.k; i++)
    for (int l = 0; l < 2 && e->phase.modes.contact[i] == NSDAE_MODE_OPEN; l++)
      memset(e->base.basis[l] + (size_t)i * rows, 0, rows * sizeof *e->base.basis[l]);
  if (status == NSDAE_OK && !found) status = nsdae_event_tune(e, t); /* it has strayed */
  if (status == NSDAE_OK) status = nsdae_event_restart(e, t);
  note_rattles(e, t, first);
  for (int n = 0; n < d->k && status == NSDAE_OK; n++) {
    int i = nsdae_system_contact(e->setting.system, n);
    nsdae_result_change(r, t, i, -1, e->mode_before[i], m->contact[i]);
  }
  for (int j = 0; j < d->f && status == NSDAE_OK; j++)
    nsdae_result_change(r, t, -1, j, e->slide_mode_before[j], m->frictional_joint[j]);
  *e->base.idle += found && r->impacts + r->changes == before;
  return status;
}

int nsdae_event_go_through(nsdae_event *e, double t)
{
  int solved = nsdae_event_forces(&e->phase, t, e->integrator.y), pole = meets_pole(e);
  double coefficient = pole < 0 ? 0 : nsdae_event_yield(&e->phase, pole);
  int status = solved < 0 ? nsdae_event_failed(e, solved, t) : nsdae_event_change_modes(e, t);
  return status == NSDAE_OK && pole >= 0 ? jammed(e, t, pole, coefficient) : status;
}
