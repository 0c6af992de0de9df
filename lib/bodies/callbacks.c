/* The mechanism as the callbacks of a system: each walks its list and puts rows where their bodies
 * are. */
#include <stdio.h>

#include "world.h"

static int mass(double t, const double *q, double *M, int ldm, void *user)
{
  const nsdae_bodies *b = user;
  int nv = nsdae_body_nv(b), moving = b->dimension;
  (void)t;
  (void)q;
  for (int i = 0; i < b->body.count; i++)
    for (int j = 0; j < nv; j++) {
      size_t at = (size_t)i * (size_t)nv + (size_t)j;
      const nsdae_rigid_body *body = nsdae_body_at(b, i);
      int axis = b->dimension == 2 ? 2 : j - 3;
      M[at * ((size_t)ldm + 1)] = j < moving ? body->mass : body->inertia[axis];
    }
  return 0;
}

static int force(double t, const double *q, const double *v, double *F, void *user)
{
  return nsdae_bodies_forces(user, t, q, v, F);
}

static int potential(double t, const double *q, double *energy, void *user)
{
  (void)t;
  *energy = nsdae_bodies_energy(user, q);
  return 0;
}

/* x' = v; p' = p (0, omega) / 2 of the quaternion p */
static int kinematics(double t, const double *q, const double *v, double *qdot, void *user)
{
  const nsdae_bodies *b = user;
  (void)t;
  for (int i = 0; i < b->body.count; i++) {
    const double *p = q + 7 * i + 3, *w = v + 6 * i + 3;
    double *rate = qdot + 7 * i;
    for (int j = 0; j < 3; j++) rate[j] = v[6 * i + j];
    rate[3] = (-p[1] * w[0] - p[2] * w[1] - p[3] * w[2]) / 2;
    rate[4] = (p[0] * w[0] + p[2] * w[2] - p[3] * w[1]) / 2;
    rate[5] = (p[0] * w[1] + p[3] * w[0] - p[1] * w[2]) / 2;
    rate[6] = (p[0] * w[2] + p[1] * w[1] - p[2] * w[0]) / 2;
  }
  return 0;
}

static int element_at(const nsdae_bodies *b, const nsdae_element *e, double t, const double *q,
                      const double *v, nsdae_pose pose[2], nsdae_element_value *value)
{
  for (int i = 0; i < 2; i++) pose[i] = nsdae_bodies_pose(b, e->body[i], q, v);
  return nsdae_element_evaluate(e, t, &pose[0], &pose[1], value);
}

static const nsdae_element *element_of(const nsdae_bodies *b, int i)
{
  return (const nsdae_element *)b->element.at + i;
}

static int constraint(double t, const double *q, double *phi, void *user)
{
  const nsdae_bodies *b = user;
  nsdae_element_value value;
  nsdae_pose pose[2];
  for (int i = 0; i < b->element.count; i++) {
    int code = element_at(b, element_of(b, i), t, q, NULL, pose, &value);
    if (code) return code;
    phi[i] = value.phi.x;
  }
  return 0;
}

static int constraint_jacobian(double t, const double *q, double *J, int ldj, void *user)
{
  const nsdae_bodies *b = user;
  nsdae_element_value value;
  nsdae_pose pose[2];
  for (int i = 0; i < b->element.count; i++) {
    const nsdae_element *e = element_of(b, i);
    int code = element_at(b, e, t, q, NULL, pose, &value);
    if (code) return code;
    nsdae_bodies_scatter(b, e->body, &pose[0], &pose[1], &value.row, 1, J + i, ldj);
  }
  return 0;
}

static int constraint_bias(double t, const double *q, const double *v, double *phi_t, double *omega,
                           void *user)
{
  const nsdae_bodies *b = user;
  nsdae_element_value value;
  nsdae_pose pose[2];
  for (int i = 0; i < b->element.count; i++) {
    int code = element_at(b, element_of(b, i), t, q, v, pose, &value);
    if (code) return code;
    phi_t[i] = value.phi_t;
    omega[i] = value.phi.dd;
  }
  return 0;
}

static int slide_tangent(double t, const double *q, double *W, int ldw, double *w, void *user)
{
  const nsdae_bodies *b = user;
  nsdae_element_value value;
  nsdae_pose pose[2];
  (void)w; /* nothing moves by itself along a slot */
  for (int i = 0; i < b->slide.count; i++) {
    const nsdae_element *e = &((const nsdae_bodies_slide *)b->slide.at + i)->along;
    element_at(b, e, t, q, NULL, pose, &value);
    nsdae_bodies_scatter(b, e->body, &pose[0], &pose[1], &value.row, 1, W + (size_t)i * (size_t)ldw,
                         1);
  }
  return 0;
}

static const nsdae_feature *feature_of(const nsdae_bodies *b, int i)
{
  return (const nsdae_feature *)b->feature.at + i;
}

/* The contact of feature i; its bodies and their poses. */
static nsdae_touch touch_at(const nsdae_bodies *b, int i, const double *q, const double *v,
                            int body[2], nsdae_pose pose[2])
{
  const nsdae_feature *f = feature_of(b, i);
  const nsdae_solid_of *solid[2];
  for (int j = 0; j < 2; j++) {
    solid[j] = (const nsdae_solid_of *)b->solid.at + f->solid[j];
    body[j] = solid[j]->body;
    pose[j] = nsdae_bodies_pose(b, body[j], q, v);
  }
  return nsdae_feature_touch(f, solid[0], solid[1], &pose[0], &pose[1]);
}

static int gap(double t, const double *q, double *g, void *user)
{
  const nsdae_bodies *b = user;
  int body[2];
  nsdae_pose pose[2];
  (void)t;
  for (int i = 0; i < b->feature.count; i++) g[i] = touch_at(b, i, q, NULL, body, pose).gap.x;
  return 0;
}

/* The row of n . xi or t . xi, into a column. */
static void put_column(const nsdae_bodies *b, const nsdae_touch *touch, const int body[2],
                       const nsdae_pose pose[2], nsdae_jet3 direction, double *column)
{
  double x[2][3], n[3];
  for (int i = 0; i < 3; i++) {
    x[0][i] = touch->at[0].at[i].x;
    x[1][i] = touch->at[1].at[i].x;
    n[i] = direction.at[i].x;
  }
  nsdae_velocity_row row = nsdae_relative_row(&pose[0], &pose[1], x[0], x[1], n);
  nsdae_bodies_scatter(b, body, &pose[0], &pose[1], &row, 1, column, 1);
}

static int gap_normal(double t, const double *q, double *W, int ldw, void *user)
{
  const nsdae_bodies *b = user;
  int body[2];
  nsdae_pose pose[2];
  (void)t;
  for (int i = 0; i < b->feature.count; i++) {
    nsdae_touch touch = touch_at(b, i, q, NULL, body, pose);
    if (!touch.far) put_column(b, &touch, body, pose, touch.normal, W + (size_t)i * (size_t)ldw);
  }
  return 0;
}

/* t_1 (and in space t_2 = n x t_1) at right angles to n: in the plane n turned to the left, in
 * space e x n of the coordinate axis e that n is least along. */
static void tangents(int dimension, nsdae_jet3 n, nsdae_jet3 t[2])
{
  double e[3] = {0, 0, 0};
  int least = 2;
  for (int i = 0; i < 3 && dimension == 3; i++)
    if (fabs(n.at[i].x) < fabs(n.at[least].x)) least = i;
  e[least] = 1;
  t[0] = nsdae_jet3_cross(nsdae_jet3_of(e), n);
  t[0] = nsdae_jet3_times(nsdae_jet_inverse(nsdae_jet3_length(t[0])), t[0]);
  t[1] = nsdae_jet3_cross(n, t[0]);
}

static int gap_tangent(double t, const double *q, double *W, int ldw, void *user)
{
  const nsdae_bodies *b = user;
  int body[2], nt = b->dimension - 1;
  nsdae_pose pose[2];
  (void)t;
  for (int i = 0; i < b->feature.count; i++) {
    nsdae_touch touch = touch_at(b, i, q, NULL, body, pose);
    nsdae_jet3 direction[2];
    tangents(b->dimension, touch.normal, direction);
    for (int j = 0; j < nt; j++)
      put_column(b, &touch, body, pose, direction[j],
                 W + ((size_t)i * (size_t)nt + (size_t)j) * (size_t)ldw);
  }
  return 0;
}

/* Solids move with their bodies alone. */
static int contact_bias(double t, const double *q, double *w_n, double *w_t, void *user)
{
  (void)t;
  (void)q;
  (void)w_n;
  (void)w_t;
  (void)user;
  return 0;
}

/* xi, and its rate with v' = 0: see feature.h. */
static nsdae_jet3 relative_velocity(const nsdae_touch *touch, const nsdae_pose pose[2])
{
  nsdae_jet3 xi = {{{0, 0, 0}}};
  for (int i = 0; i < 2; i++) {
    double arm[3], wander[3], turning[3], rate[3], sign = i ? 1 : -1;
    for (int j = 0; j < 3; j++) arm[j] = touch->at[i].at[j].x - pose[i].r[j];
    nsdae_cross3(pose[i].w, arm, turning);
    for (int j = 0; j < 3; j++) wander[j] = touch->at[i].at[j].d - pose[i].v[j];
    nsdae_cross3(pose[i].w, wander, rate);
    for (int j = 0; j < 3; j++) {
      xi.at[j].x += sign * (pose[i].v[j] + turning[j]);
      xi.at[j].d += sign * rate[j];
    }
  }
  return xi;
}

static int contact_acceleration(double t, const double *q, const double *v, double *omega_n,
                                double *omega_t, double *omega_s, void *user)
{
  const nsdae_bodies *b = user;
  int body[2], nt = b->dimension - 1;
  nsdae_pose pose[2];
  for (int i = 0; i < b->feature.count; i++) {
    nsdae_touch touch = touch_at(b, i, q, v, body, pose);
    nsdae_jet3 direction[2];
    omega_n[i] = touch.gap.dd;
    if (!omega_t) continue;
    tangents(b->dimension, touch.normal, direction);
    nsdae_jet3 xi = relative_velocity(&touch, pose);
    for (int j = 0; j < nt; j++) omega_t[i * nt + j] = nsdae_jet3_dot(direction[j], xi).d;
  }
  for (int i = 0; i < b->slide.count; i++) {
    nsdae_element_value value;
    element_at(b, &((const nsdae_bodies_slide *)b->slide.at + i)->along, t, q, v, pose, &value);
    omega_s[i] = value.phi.dd;
  }
  return 0;
}

static int set_contacts(nsdae_bodies *b, nsdae_system *system)
{
  int status = nsdae_system_set_gap(system, gap);
  if (status == NSDAE_OK) status = nsdae_system_set_gap_normal(system, gap_normal);
  if (status == NSDAE_OK) status = nsdae_system_set_gap_tangent(system, gap_tangent);
  if (status == NSDAE_OK) status = nsdae_system_set_contact_bias(system, contact_bias);
  for (int i = 0; i < b->feature.count && status == NSDAE_OK; i++) {
    const nsdae_feature *f = feature_of(b, i);
    status = nsdae_system_set_contact(system, i, f->mu, f->e_n, f->e_t);
  }
  return status;
}

static int set_slides(nsdae_bodies *b, nsdae_system *system)
{
  int status = nsdae_system_set_slide_tangent(system, slide_tangent);
  for (int i = 0; i < b->slide.count && status == NSDAE_OK; i++) {
    const nsdae_bodies_slide *s = (const nsdae_bodies_slide *)b->slide.at + i;
    status = nsdae_system_set_slide(system, i, s->constraint, s->mu);
  }
  return status;
}

static int set_constraints(nsdae_system *system)
{
  int status = nsdae_system_set_constraint(system, constraint);
  if (status == NSDAE_OK)
    status = nsdae_system_set_constraint_jacobian(system, constraint_jacobian);
  if (status == NSDAE_OK) status = nsdae_system_set_constraint_bias(system, constraint_bias);
  return status;
}

/* Coordinates are x0, y0, theta0, x1, ...; in space x0, y0, z0, qw0, qx0, qy0, qz0, ... and the
 * velocities of turning wx0, wy0, wz0. */
static int set_names(const nsdae_bodies *b, nsdae_system *system)
{
  static const char *const planar[3] = {"x", "y", "theta"};
  static const char *const spatial[7] = {"x", "y", "z", "qw", "qx", "qy", "qz"};
  static const char *const speeds[6] = {"vx", "vy", "vz", "wx", "wy", "wz"};
  int d = b->dimension, nq = nsdae_body_nq(b), status = NSDAE_OK;
  char name[NSDAE_NAME_SIZE];
  for (int i = 0; i < b->body.count * nq && status == NSDAE_OK; i++) {
    int j = i % nq;
    snprintf(name, sizeof name, "%s%d", (d == 2 ? planar : spatial)[j], i / nq);
    status = nsdae_system_set_name(system, NSDAE_NAME_COORDINATE, i, name,
                                   j < d    ? "m"
                                   : d == 2 ? "rad"
                                            : "1");
  }
  for (int i = 0; d == 3 && i < 6 * b->body.count && status == NSDAE_OK; i++) {
    snprintf(name, sizeof name, "%s%d", speeds[i % 6], i / 6);
    status =
        nsdae_system_set_name(system, NSDAE_NAME_VELOCITY, i, name, i % 6 < 3 ? "m/s" : "rad/s");
  }
  return status;
}

int nsdae_bodies_set_callbacks(nsdae_bodies *b, nsdae_system *system)
{
  int status = nsdae_system_set_user(system, b);
  if (status == NSDAE_OK) status = set_names(b, system);
  if (status == NSDAE_OK) status = nsdae_system_set_mass(system, mass);
  if (status == NSDAE_OK) status = nsdae_system_set_force(system, force);
  if (status == NSDAE_OK) status = nsdae_system_set_potential(system, potential);
  if (status == NSDAE_OK && b->dimension == 3)
    status = nsdae_system_set_kinematics(system, kinematics);
  if (status == NSDAE_OK && b->element.count > 0) status = set_constraints(system);
  if (status == NSDAE_OK && b->feature.count > 0) status = set_contacts(b, system);
  if (status == NSDAE_OK && b->slide.count > 0) status = set_slides(b, system);
  if (status == NSDAE_OK && b->feature.count + b->slide.count > 0)
    status = nsdae_system_set_contact_acceleration(system, contact_acceleration);
  return status;
}
