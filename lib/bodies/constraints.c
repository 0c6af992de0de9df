/* Constraints and frictional joints as callbacks: each walks its rows, Phi = s - f(t) or s -
 * p(s_0), and puts them where their bodies are; rows of one's own follow. */
#include <math.h>

#include "bodies_impl.h"

void nsdae_bodies_coordinate(const nsdae_bodies *b, const nsdae_primitive *p, const double *q,
                             const double *v, nsdae_places *at, nsdae_primitive_value *value)
{
  nsdae_bodies_place(b, p->body, q, v, at);
  nsdae_primitive_evaluate(p, at->pose, value);
}

/* A row of Phi where it is. Its row of Phi_q is that of s, and -slope times that of s_0. */
typedef struct constraint_value {
  nsdae_jet phi;
  double phi_t, slope;
  nsdae_places at[2];
  nsdae_primitive_value s[2]; /* s and s_0 */
} constraint_value;

/* p(s) and its derivatives, by Horner's scheme. */
static nsdae_jet polynomial(const double *p, nsdae_jet s, double *slope)
{
  double value = 0, first = 0, second = 0;
  for (int i = NSDAE_DEGREE; i >= 0; i--) {
    second = second * s.x + 2 * first;
    first = first * s.x + value;
    value = value * s.x + p[i];
  }
  *slope = first;
  return nsdae_jet_chain(s, value, first, second);
}

/* 0, or what the drive returned. */
static int evaluate(const nsdae_bodies *b, const nsdae_bodies_constraint *c, double t,
                    const double *q, const double *v, constraint_value *value)
{
  nsdae_jet aim = nsdae_jet_of(c->p[0]);
  nsdae_bodies_coordinate(b, &c->value, q, v, &value->at[0], &value->s[0]);
  value->phi_t = 0;
  if (c->drive) {
    double f[3] = {0, 0, 0};
    int code = c->drive(t, f, c->user);
    if (code) return code;
    aim = (nsdae_jet){f[0], f[1], f[2]};
    value->phi_t = -f[1];
  } else if (c->master >= 0) {
    const nsdae_bodies_joint *joint = nsdae_joint_at(b, c->master / NSDAE_COORDINATES);
    nsdae_bodies_coordinate(b, &joint->coordinate[c->master % NSDAE_COORDINATES], q, v,
                            &value->at[1], &value->s[1]);
    aim = polynomial(c->p, value->s[1].phi, &value->slope);
  }
  value->phi = nsdae_jet_sub(value->s[0].phi, aim);
  if (c->period > 0) value->phi.x -= c->period * round(value->phi.x / c->period);
  return 0;
}

static int constraint(double t, const double *q, double *phi, void *user)
{
  const nsdae_bodies *b = nsdae_bodies_of(user);
  const nsdae_user_rows *own = &b->own;
  constraint_value value = {.at = {nsdae_nowhere, nsdae_nowhere}};
  for (int i = 0; i < b->constraint.count; i++) {
    int code = evaluate(b, nsdae_constraint_at(b, i), t, q, NULL, &value);
    if (code) return code;
    phi[i] = value.phi.x;
  }
  return own->constraint ? own->constraint(t, q, phi + b->constraint.count, own->user) : 0;
}

/* The parts of a row, each block once: two coordinates may have a body in common. */
typedef struct row_parts {
  int count, body[4];
  double value[4][6];
} row_parts;

static void add_parts(const nsdae_bodies *b, const nsdae_places *at, const nsdae_velocity_row *row,
                      double scale, row_parts *parts)
{
  for (int j = 0; j < 2; j++) {
    double part[6];
    int k = 0, n = nsdae_body_nv(b);
    if (at->body[j] == NSDAE_GROUND) continue;
    nsdae_bodies_part(b, row, j, &at->pose[j], part);
    while (k < parts->count && parts->body[k] != at->body[j]) k++;
    for (int i = 0; i < n && k == parts->count; i++) parts->value[k][i] = 0;
    if (k == parts->count) parts->body[parts->count++] = at->body[j];
    for (int i = 0; i < n; i++) parts->value[k][i] += scale * part[i];
  }
}

static int put_row(const row_parts *parts, int row, nsdae_row_list *rows)
{
  int code = 0;
  for (int k = 0; k < parts->count && code == 0; k++)
    code = nsdae_row_add(rows, row, parts->body[k], parts->value[k]);
  return code;
}

static int constraint_rows(double t, const double *q, nsdae_row_list *rows, void *user)
{
  const nsdae_bodies *b = nsdae_bodies_of(user);
  constraint_value value = {.at = {nsdae_nowhere, nsdae_nowhere}};
  int code = 0;
  for (int i = 0; i < b->constraint.count && code == 0; i++) {
    const nsdae_bodies_constraint *c = nsdae_constraint_at(b, i);
    row_parts parts = {.count = 0};
    code = evaluate(b, c, t, q, NULL, &value);
    if (code) return code;
    add_parts(b, &value.at[0], &value.s[0].row, 1, &parts);
    if (c->master >= 0) add_parts(b, &value.at[1], &value.s[1].row, -value.slope, &parts);
    code = put_row(&parts, i, rows);
  }
  if (code || !b->own.constraint_rows) return code;
  return b->own.constraint_rows(t, q, rows, b->own.user);
}

/* Dense, with the dense rows of one's own. */
static int constraint_jacobian(double t, const double *q, double *J, int ldj, void *user)
{
  const nsdae_bodies *b = nsdae_bodies_of(user);
  const nsdae_user_rows *own = &b->own;
  constraint_value value = {.at = {nsdae_nowhere, nsdae_nowhere}};
  for (int i = 0; i < b->constraint.count; i++) {
    const nsdae_bodies_constraint *c = nsdae_constraint_at(b, i);
    int code = evaluate(b, c, t, q, NULL, &value);
    if (code) return code;
    nsdae_bodies_scatter(b, &value.at[0], &value.s[0].row, 1, J + i, ldj);
    if (c->master >= 0)
      nsdae_bodies_scatter(b, &value.at[1], &value.s[1].row, -value.slope, J + i, ldj);
  }
  return own->constraint_jacobian(t, q, J + b->constraint.count, ldj, own->user);
}

static int constraint_bias(double t, const double *q, const double *v, double *phi_t, double *omega,
                           void *user)
{
  const nsdae_bodies *b = nsdae_bodies_of(user);
  const nsdae_user_rows *own = &b->own;
  constraint_value value = {.at = {nsdae_nowhere, nsdae_nowhere}};
  for (int i = 0; i < b->constraint.count; i++) {
    int code = evaluate(b, nsdae_constraint_at(b, i), t, q, v, &value);
    if (code) return code;
    phi_t[i] = value.phi_t;
    omega[i] = value.phi.dd;
  }
  int m = b->constraint.count;
  return own->constraint_bias ? own->constraint_bias(t, q, v, phi_t + m, omega + m, own->user) : 0;
}

/* A slot does not move with v = 0; w of a motor is minus its target. */
static int joint_friction_rows(double t, const double *q, nsdae_row_list *rows, double *w,
                               void *user)
{
  const nsdae_bodies *b = nsdae_bodies_of(user);
  nsdae_places at = nsdae_nowhere;
  nsdae_primitive_value value;
  int code = 0;
  for (int i = 0; i < b->frictional_joint.count && code == 0; i++) {
    row_parts parts = {.count = 0};
    double target[3];
    code = nsdae_motor_target(nsdae_frictional_joint_at(b, i), nsdae_control_of(user), t, target);
    if (code) return code;
    w[i] = -target[0];
    nsdae_bodies_coordinate(b, &nsdae_frictional_joint_at(b, i)->along, q, NULL, &at, &value);
    add_parts(b, &at, &value.row, 1, &parts);
    code = put_row(&parts, i, rows);
  }
  return code;
}

/* Dense, with those of the user rows. */
static int frictional_joint_tangent(double t, const double *q, double *W, int ldw, double *w,
                                    void *user)
{
  const nsdae_bodies *b = nsdae_bodies_of(user);
  int f = b->frictional_joint.count;
  nsdae_primitive_value value;
  nsdae_places at = nsdae_nowhere;
  for (int i = 0; i < f; i++, W += ldw) {
    double target[3];
    int code =
        nsdae_motor_target(nsdae_frictional_joint_at(b, i), nsdae_control_of(user), t, target);
    if (code) return code;
    w[i] = -target[0];
    nsdae_bodies_coordinate(b, &nsdae_frictional_joint_at(b, i)->along, q, NULL, &at, &value);
    nsdae_bodies_scatter(b, &at, &value.row, 1, W, 1);
  }
  return b->own.frictional_joint_tangent(t, q, W, ldw, w + f, b->own.user);
}

/* What rows of one's own lack of a derivative is left to the system, for all rows. */
int nsdae_bodies_set_constraints(const nsdae_bodies *b, nsdae_system *system)
{
  const nsdae_user_rows *own = &b->own;
  int m = b->constraint.count + own->dims.m, f = b->frictional_joint.count + own->dims.f;
  int none = own->dims.m == 0, status = NSDAE_OK;
  if (m > 0) status = nsdae_system_set_constraint(system, constraint);
  if (m > 0 && status == NSDAE_OK && (none || own->constraint_rows))
    status = nsdae_system_set_constraint_rows(system, constraint_rows);
  else if (m > 0 && status == NSDAE_OK && own->constraint_jacobian)
    status = nsdae_system_set_constraint_jacobian(system, constraint_jacobian);
  if (m > 0 && status == NSDAE_OK && (none || own->constraint_bias))
    status = nsdae_system_set_constraint_bias(system, constraint_bias);
  if (f > 0 && status == NSDAE_OK)
    status = own->dims.f > 0
                 ? nsdae_system_set_frictional_joint_tangent(system, frictional_joint_tangent)
                 : nsdae_system_set_joint_friction_rows(system, joint_friction_rows);
  if (status == NSDAE_OK) status = nsdae_bodies_set_motors(b, system);
  for (int j = 0; j < b->frictional_joint.count && status == NSDAE_OK; j++) {
    const nsdae_bodies_frictional_joint *pin = nsdae_frictional_joint_at(b, j);
    if (pin->circle > 0)
      status =
          nsdae_system_set_friction_circle(system, j, pin->constraint, b->dimension, pin->circle);
  }
  return status;
}
