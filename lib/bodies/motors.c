/* Motors along a coordinate s of a joint:
 *
 *   FORCE      F = target(t)                                   within -limit .. limit
 *   POSITION   F = kp (target - s) + kd (target' - s')         within -limit .. limit
 *   SPEED      s' = target(t) by a force within -limit .. limit: a frictional joint with
 *              v_S = s' - target(t) and the bound limit; with the target 0 it is dry friction
 *
 * POSITION is a force of event and penalty. Of time stepping it is a frictional joint, too, with
 * v_S = s' - target'(t), whose row is implicit in the step: see lib/contact/slides.h.
 *
 * A rotation in space is known up to turns: target - s is the nearest to 0. */
#include <math.h>

#include "bodies_impl.h"

static const char *const what = "motor";

/* A target and its rates: the control, or of a drive; 0, or what this returned. */
static int target_of(double control, nsdae_drive_fn drive, void *user, double t, double f[3])
{
  f[0] = control;
  f[1] = f[2] = 0;
  return drive ? drive(t, f, user) : 0;
}

/* target - s */
static double error_of(const nsdae_bodies_spring *spring, double target, double s)
{
  int turns = spring->owner == NSDAE_POSITION_MOTOR && nsdae_primitive_is_periodic(&spring->value);
  return turns ? remainder(target - s, 2 * nsdae_pi) : target - s;
}

int nsdae_spring_force(const nsdae_bodies_spring *spring, const double *control, double t, double s,
                       double rate, double force[3])
{
  double f[3], given = spring->owner >= NSDAE_FORCE_MOTOR ? control[spring->number] : 0;
  int code = target_of(given, spring->drive, spring->user, t, f);
  int direct = spring->owner == NSDAE_FORCE_MOTOR;
  double off = direct ? 0 : error_of(spring, f[0], s);
  force[0] = spring->stiffness * off + spring->damping * (f[1] - rate) + (direct ? f[0] : 0);
  int limited = fabs(force[0]) > spring->limit;
  force[1] = limited ? 0 : spring->stiffness;
  force[2] = limited ? 0 : spring->damping;
  if (limited) force[0] = copysign(spring->limit, force[0]);
  int motor =
      spring->owner >= NSDAE_FORCE_MOTOR; /* a trial state that overflowed: a shorter step */
  return code || !motor || isfinite(s + rate) ? code : 1;
}

static int check_motor(nsdae_bodies *b, int index, const nsdae_motor *m)
{
  if (m->kind < NSDAE_MOTOR_FORCE || m->kind > NSDAE_MOTOR_POSITION)
    return nsdae_bodies_refuse(b, NSDAE_E_ARGUMENT, what, "kind", index,
                               "kind = %d is not one of enum nsdae_motor_kind", m->kind);
  if (!isfinite(m->target))
    return nsdae_bodies_refuse(b, NSDAE_E_NONFINITE, what, "target", index,
                               "target = %g is not a finite number", m->target);
  int speed = m->kind == NSDAE_MOTOR_SPEED, position = m->kind == NSDAE_MOTOR_POSITION;
  if (!(speed ? m->limit >= 0 && isfinite(m->limit) : m->limit > 0))
    return nsdae_bodies_refuse(b, NSDAE_E_ARGUMENT, what, "limit", index,
                               speed ? "limit = %g of a speed motor must be at least 0, and finite"
                                     : "limit = %g must be above 0; INFINITY: without a limit",
                               m->limit);
  if (speed && m->limit == 0 && !m->vary && (m->drive || m->target != 0))
    return nsdae_bodies_refuse(b, NSDAE_E_ARGUMENT, what, "limit", index,
                               "limit = 0 of a speed motor with a target must be above 0, or give "
                               "vary");
  if (m->vary && !speed)
    return nsdae_bodies_refuse(b, NSDAE_E_ARGUMENT, what, "vary", index,
                               "vary is for speed motors: limit it in the target");
  nsdae_bodies_check_least(b, what, "kp", index, m->kp, 0, 0);
  nsdae_bodies_check_least(b, what, "kd", index, m->kd, 0, 0);
  if (position && m->kp == 0 && m->kd == 0)
    return nsdae_bodies_refuse(b, NSDAE_E_ARGUMENT, what, "kp", index,
                               "kp = 0, kd = 0 of a position motor: one of them must be above 0");
  if (position || (m->kp == 0 && m->kd == 0)) return b->error.status;
  return nsdae_bodies_refuse(b, NSDAE_E_ARGUMENT, what, "kp", index,
                             "kp = %g, kd = %g are of position motors: they must be 0", m->kp,
                             m->kd);
}

/* Some motors are frictional joints, some are springs. */
const char *nsdae_motor_fixed(const void *bodies, int i)
{
  const nsdae_bodies *b = bodies;
  int driven = 0;
  for (int j = 0; j < b->frictional_joint.count; j++)
    driven |= nsdae_frictional_joint_at(b, j)->motor == i && nsdae_frictional_joint_at(b, j)->drive;
  for (int j = 0; j < b->force.spring.count; j++) {
    const nsdae_bodies_spring *s = nsdae_spring_at(b, j);
    driven |= s->owner >= NSDAE_FORCE_MOTOR && s->number == i && s->drive;
  }
  return driven ? "the target of this motor is its drive: make the motor without one" : NULL;
}

int nsdae_bodies_add_motor(nsdae_bodies *b, const nsdae_motor *m)
{
  int status = nsdae_bodies_open(b, m, what);
  if (status < 0) return status;
  int index = b->force.target.count;
  const nsdae_primitive *of =
      nsdae_bodies_joint_coordinate(b, what, index, m->joint, m->coordinate, 0);
  if (!of || check_motor(b, index, m) < 0) return b->error.status;
  const nsdae_primitive value = *of;
  int position = m->kind == NSDAE_MOTOR_POSITION;
  double *target = nsdae_list_add(b, &b->force.target, sizeof *target);
  if (!target) return NSDAE_E_MEMORY;
  *target = m->target;
  if (position || m->kind == NSDAE_MOTOR_SPEED) {
    nsdae_bodies_frictional_joint *f = nsdae_list_add(b, &b->frictional_joint, sizeof *f);
    if (!f) return NSDAE_E_MEMORY;
    *f = (nsdae_bodies_frictional_joint){.constraint = -1,
                                         .joint = m->joint,
                                         .motor = index,
                                         .position = position ? b->force.spring.count : -1,
                                         .along = value,
                                         .bound = m->limit,
                                         .drive = m->drive,
                                         .vary = m->vary,
                                         .user = m->user,
                                         .vary_user = m->vary_user};
    if (!position) return index;
  }
  nsdae_bodies_spring *s = nsdae_list_add(b, &b->force.spring, sizeof *s);
  if (!s) return NSDAE_E_MEMORY;
  *s = (nsdae_bodies_spring){.value = value,
                             .owner = position ? NSDAE_POSITION_MOTOR : NSDAE_FORCE_MOTOR,
                             .number = index,
                             .stiffness = m->kp,
                             .damping = m->kd,
                             .limit = m->limit,
                             .drive = m->drive,
                             .user = m->user};
  return index;
}

/* ---- as frictional joints */

int nsdae_motor_target(const nsdae_bodies_frictional_joint *f, const double *control, double t,
                       double target[3])
{
  int code = target_of(f->motor < 0 ? 0 : control[f->motor], f->drive, f->user, t, target);
  if (f->position < 0) return code;
  target[0] = target[1];
  target[1] = target[2];
  return code;
}

int nsdae_motor_position(const void *bodies, int j, nsdae_gains *gains)
{
  const nsdae_bodies *b = bodies;
  int i = j < b->frictional_joint.count ? nsdae_frictional_joint_at(b, j)->position : -1;
  if (i < 0) return 0;
  const nsdae_bodies_spring *s = nsdae_spring_at(b, i);
  *gains = (nsdae_gains){s->stiffness, s->damping, s->limit};
  return 1;
}

int nsdae_motor_errors(double t, const double *q, double *e, const void *user)
{
  const nsdae_bodies *b = nsdae_bodies_of(user);
  nsdae_places at = nsdae_nowhere;
  nsdae_primitive_value s;
  double f[3];
  for (int j = 0; j < b->frictional_joint.count; j++) {
    const nsdae_bodies_frictional_joint *m = nsdae_frictional_joint_at(b, j);
    if (m->position < 0) continue;
    nsdae_bodies_coordinate(b, &m->along, q, NULL, &at, &s);
    int code = target_of(nsdae_control_of(user)[m->motor], m->drive, m->user, t, f);
    if (code) return code;
    e[j] = -error_of(nsdae_spring_at(b, m->position), f[0], s.phi.x);
  }
  return 0;
}

static int bounds(double t, const double *q, const double *v, double *bound, void *user)
{
  const nsdae_bodies *b = nsdae_bodies_of(user);
  (void)q, (void)v;
  for (int i = 0; i < b->frictional_joint.count; i++) {
    const nsdae_bodies_frictional_joint *f = nsdae_frictional_joint_at(b, i);
    double limit[3] = {0, 0, 0};
    int code = f->vary ? f->vary(t, limit, f->vary_user) : 0;
    if (code) return code;
    bound[i] = limit[0];
  }
  return 0;
}

int nsdae_bodies_set_motors(const nsdae_bodies *b, nsdae_system *system)
{
  int status = NSDAE_OK, varies = 0;
  for (int i = 0; i < b->frictional_joint.count && status == NSDAE_OK; i++) {
    const nsdae_bodies_frictional_joint *f = nsdae_frictional_joint_at(b, i);
    varies |= f->vary != NULL;
    if (f->position >= 0) /* its limit is of time stepping alone */
      status = nsdae_system_set_frictional_joint(system, i, 0, 0);
    else
      status = f->motor < 0 ? nsdae_system_set_frictional_joint(system, i, f->constraint, f->mu)
                            : nsdae_system_set_friction_bound(system, i, f->vary ? 0 : f->bound);
  }
  return status < 0 || !varies ? status : nsdae_system_set_joint_friction_bound(system, bounds);
}
