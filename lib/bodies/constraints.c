/* Constraints and frictional joints as callbacks: each walks its elements and puts rows where their
 * bodies are; rows of one's own follow. */
#include "bodies_impl.h"

int nsdae_bodies_element(const nsdae_bodies *b, const nsdae_primitive *e, double t, const double *q,
                         const double *v, nsdae_places *at, nsdae_primitive_value *value)
{
  nsdae_bodies_place(b, e->body, q, v, at);
  return nsdae_primitive_evaluate(e, t, at->pose, value);
}

static int constraint(double t, const double *q, double *phi, void *user)
{
  const nsdae_bodies *b = user;
  const nsdae_user_rows *own = &b->own;
  nsdae_primitive_value value;
  nsdae_places at = nsdae_nowhere;
  for (int i = 0; i < b->element.count; i++) {
    int code = nsdae_bodies_element(b, nsdae_element_at(b, i), t, q, NULL, &at, &value);
    if (code) return code;
    phi[i] = value.phi.x;
  }
  return own->constraint ? own->constraint(t, q, phi + b->element.count, own->user) : 0;
}

/* The row of an element over the blocks of its bodies. */
static int add_row(const nsdae_bodies *b, const nsdae_primitive *e, int row, double t,
                   const double *q, nsdae_places *at, nsdae_row_list *rows)
{
  nsdae_primitive_value value;
  int code = nsdae_bodies_element(b, e, t, q, NULL, at, &value);
  for (int j = 0; j < 2 && code == 0; j++) {
    double part[6];
    if (e->body[j] == NSDAE_GROUND) continue;
    nsdae_bodies_part(b, &value.row, j, &at->pose[j], part);
    code = nsdae_row_add(rows, row, e->body[j], part);
  }
  return code;
}

static int constraint_rows(double t, const double *q, nsdae_row_list *rows, void *user)
{
  const nsdae_bodies *b = user;
  nsdae_places at = nsdae_nowhere;
  int code = 0;
  for (int i = 0; i < b->element.count && code == 0; i++)
    code = add_row(b, nsdae_element_at(b, i), i, t, q, &at, rows);
  if (code || !b->own.constraint_rows) return code;
  return b->own.constraint_rows(t, q, rows, b->own.user);
}

/* Dense, with the dense rows of one's own. */
static int constraint_jacobian(double t, const double *q, double *J, int ldj, void *user)
{
  const nsdae_bodies *b = user;
  const nsdae_user_rows *own = &b->own;
  nsdae_primitive_value value;
  nsdae_places at = nsdae_nowhere;
  for (int i = 0; i < b->element.count; i++) {
    int code = nsdae_bodies_element(b, nsdae_element_at(b, i), t, q, NULL, &at, &value);
    if (code) return code;
    nsdae_bodies_scatter(b, &at, &value.row, 1, J + i, ldj);
  }
  return own->constraint_jacobian(t, q, J + b->element.count, ldj, own->user);
}

static int constraint_bias(double t, const double *q, const double *v, double *phi_t, double *omega,
                           void *user)
{
  const nsdae_bodies *b = user;
  const nsdae_user_rows *own = &b->own;
  nsdae_primitive_value value;
  nsdae_places at = nsdae_nowhere;
  for (int i = 0; i < b->element.count; i++) {
    int code = nsdae_bodies_element(b, nsdae_element_at(b, i), t, q, v, &at, &value);
    if (code) return code;
    phi_t[i] = value.phi_t;
    omega[i] = value.phi.dd;
  }
  int m = b->element.count;
  return own->constraint_bias ? own->constraint_bias(t, q, v, phi_t + m, omega + m, own->user) : 0;
}

/* A slot does not move with v = 0: w stays 0. */
static int joint_friction_rows(double t, const double *q, nsdae_row_list *rows, double *w,
                               void *user)
{
  const nsdae_bodies *b = user;
  nsdae_places at = nsdae_nowhere;
  int code = 0;
  (void)w;
  for (int i = 0; i < b->frictional_joint.count && code == 0; i++)
    code = add_row(b, &nsdae_frictional_joint_at(b, i)->along, i, t, q, &at, rows);
  return code;
}

/* Dense, with those of the user rows. */
static int frictional_joint_tangent(double t, const double *q, double *W, int ldw, double *w,
                                    void *user)
{
  const nsdae_bodies *b = user;
  int f = b->frictional_joint.count;
  nsdae_primitive_value value;
  nsdae_places at = nsdae_nowhere;
  for (int i = 0; i < f; i++, W += ldw) {
    nsdae_bodies_element(b, &nsdae_frictional_joint_at(b, i)->along, t, q, NULL, &at, &value);
    nsdae_bodies_scatter(b, &at, &value.row, 1, W, 1);
  }
  return b->own.frictional_joint_tangent(t, q, W, ldw, w + f, b->own.user);
}

/* What rows of one's own lack of a derivative is left to the system, for all rows. */
int nsdae_bodies_set_constraints(const nsdae_bodies *b, nsdae_system *system)
{
  const nsdae_user_rows *own = &b->own;
  int m = b->element.count + own->dims.m, f = b->frictional_joint.count + own->dims.f;
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
  for (int i = 0; i < b->frictional_joint.count && status == NSDAE_OK; i++) {
    const nsdae_bodies_frictional_joint *s = nsdae_frictional_joint_at(b, i);
    status = nsdae_system_set_frictional_joint(system, i, s->constraint, s->mu);
  }
  return status;
}
