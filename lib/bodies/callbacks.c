/* The mechanism as the callbacks of a system: forces, kinematics, names. */
#include <stdio.h>

#include "bodies_impl.h"

static int force(double t, const double *q, const double *v, double *F, void *user)
{
  const nsdae_bodies *b = nsdae_bodies_of(user);
  int code = nsdae_bodies_force(user, t, q, v, F);
  return code || !b->own.force ? code : b->own.force(t, q, v, F, b->own.user);
}

static int potential(double t, const double *q, double *energy, void *user)
{
  const nsdae_bodies *b = nsdae_bodies_of(user);
  double more = 0;
  int code = b->own.potential ? b->own.potential(t, q, &more, b->own.user) : 0;
  *energy = nsdae_bodies_energy(b, q) + more;
  return code;
}

/* p' = p (0, omega) / 2 of a quaternion p. Coordinates of one's own are the last; without
 * kinematics of their own their rates are v. */
static int kinematics(double t, const double *q, const double *v, double *qdot, void *user)
{
  const nsdae_bodies *b = nsdae_bodies_of(user);
  int nq = nsdae_body_nq(b), nv = nsdae_body_nv(b), n = b->body.count;
  for (int i = 0; i < n; i++, qdot += nq) {
    for (int j = 0; j < 3; j++) qdot[j] = v[nv * i + j];
    if (b->dimension == 2) continue;
    const double *p = q + nq * i + 3, *w = v + nv * i + 3;
    qdot[3] = (-p[1] * w[0] - p[2] * w[1] - p[3] * w[2]) / 2;
    qdot[4] = (p[0] * w[0] + p[2] * w[2] - p[3] * w[1]) / 2;
    qdot[5] = (p[0] * w[1] + p[3] * w[0] - p[1] * w[2]) / 2;
    qdot[6] = (p[0] * w[2] + p[1] * w[1] - p[2] * w[0]) / 2;
  }
  if (b->own.kinematics) return b->own.kinematics(t, q, v, qdot, b->own.user);
  for (int i = 0; i < b->own.dims.nq; i++) qdot[i] = v[nv * n + i];
  return 0;
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

/* joint0_0, joint0_1, ... and coupler0, ... in the units of their coordinates; a frictional joint
 * is named after its joint or motor; fixed limits are limit0, rope1, ... */
static int set_joint_names(const nsdae_bodies *b, nsdae_system *system)
{
  const nsdae_bodies_constraint *c = b->constraint.at;
  const nsdae_bodies_frictional_joint *s = b->frictional_joint.at;
  int status = NSDAE_OK, row = 0;
  char name[NSDAE_NAME_SIZE];
  for (int i = 0; i < b->constraint.count && status == NSDAE_OK; i++) {
    row = i > 0 && c[i].joint == c[i - 1].joint ? row + 1 : 0;
    if (c[i].joint < 0)
      snprintf(name, sizeof name, "coupler%d", -1 - c[i].joint);
    else
      snprintf(name, sizeof name, "joint%d_%d", c[i].joint, row);
    status = nsdae_system_set_name(system, NSDAE_NAME_CONSTRAINT, i, name,
                                   nsdae_primitive_unit(&c[i].value));
  }
  for (int i = 0; i < b->frictional_joint.count && status == NSDAE_OK; i++) {
    int motor = s[i].motor >= 0;
    snprintf(name, sizeof name, motor ? "motor%d" : "joint%d", motor ? s[i].motor : s[i].joint);
    status = nsdae_system_set_name(system, NSDAE_NAME_FRICTIONAL_JOINT, i, name,
                                   nsdae_primitive_unit(&s[i].along));
  }
  int limits = nsdae_bodies_has_list(b) ? 0 : b->limit.count;
  for (int i = 0; i < limits && status == NSDAE_OK; i++) {
    const nsdae_bodies_limit *l = nsdae_limit_at(b, i);
    snprintf(name, sizeof name, l->joint == NSDAE_ROPE ? "rope%d" : "limit%d", i);
    status = nsdae_system_set_name(system, NSDAE_NAME_CONTACT, b->feature.count + i, name,
                                   nsdae_primitive_unit(&l->value));
  }
  return status;
}

int nsdae_bodies_set_callbacks(nsdae_bodies *b, nsdae_system *system)
{
  b->force.user = (nsdae_maker_user){b, b->force.target.at, 0};
  int status = nsdae_system_set_user(system, &b->force.user);
  if (status == NSDAE_OK) status = set_names(b, system);
  if (status == NSDAE_OK) status = set_joint_names(b, system);
  if (status == NSDAE_OK) status = nsdae_bodies_set_blocks(b, system);
  if (status == NSDAE_OK) status = nsdae_system_set_force(system, force);
  if (status == NSDAE_OK) status = nsdae_system_set_potential(system, potential);
  if (status == NSDAE_OK && (b->dimension == 3 || b->own.kinematics))
    status = nsdae_system_set_kinematics(system, kinematics);
  if (status == NSDAE_OK) status = nsdae_bodies_set_constraints(b, system);
  if (status == NSDAE_OK) status = nsdae_bodies_set_contacts(b, system);
  if (status == NSDAE_OK && nsdae_bodies_has_list(b))
    status = nsdae_bodies_set_contact_list(b, system);
  return status < 0 ? status : nsdae_bodies_set_sizes(b, system);
}
