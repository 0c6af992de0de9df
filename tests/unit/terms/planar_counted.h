/* The planar model with every call counted, and any one callback failing. */
#ifndef NSDAE_TESTS_PLANAR_COUNTED_H
#define NSDAE_TESTS_PLANAR_COUNTED_H

#include "../system/planar.h"

enum {
  COUNTED_MASS,
  COUNTED_FORCE,
  COUNTED_CONSTRAINT,
  COUNTED_JACOBIAN,
  COUNTED_BIAS,
  COUNTED_GAP,
  COUNTED_NORMAL,
  COUNTED_TANGENT,
  COUNTED_CONTACT_BIAS,
  COUNTED_SLIDE,
  COUNTED_KINEMATICS,
  COUNTED_POTENTIAL,
  COUNTED
};

static const char *const counted_names[COUNTED] = {
    "mass",       "force",      "constraint",  "constraint_jacobian", "constraint_bias",
    "gap",        "gap_normal", "gap_tangent", "contact_bias",        "frictional_joint_tangent",
    "kinematics", "potential"};

/* Sizes of the first outputs. */
static const int counted_rows[COUNTED] = {3, 3, 2, 2, 2, 2, 3, 3, 2, 3, 4, 1};
static const int counted_entries[COUNTED] = {9, 3, 2, 6, 2, 2, 6, 6, 2, 3, 4, 1};

typedef struct counted {
  int calls[COUNTED];
  int fail;   /* callback that is to fail; < 0: none */
  int code;   /* what it returns; with 0 it writes value to the entry */
  int second; /* of its second output */
  int entry;
  double value;
} counted;

static inline int counted_done(counted *user, int callback, double *first, double *second)
{
  user->calls[callback]++;
  if (user->fail != callback) return 0;
  if (user->code == 0) (user->second ? second : first)[user->entry] = user->value;
  return user->code;
}

static inline int counted_mass(double t, const double *q, double *M, int ldm, void *user)
{
  planar_mass(t, q, M, ldm, NULL);
  return counted_done(user, COUNTED_MASS, M, NULL);
}

static inline int counted_force(double t, const double *q, const double *v, double *F, void *user)
{
  planar_force(t, q, v, F, NULL);
  return counted_done(user, COUNTED_FORCE, F, NULL);
}

static inline int counted_constraint(double t, const double *q, double *phi, void *user)
{
  planar_constraint(t, q, phi, NULL);
  return counted_done(user, COUNTED_CONSTRAINT, phi, NULL);
}

static inline int counted_jacobian(double t, const double *q, double *J, int ldj, void *user)
{
  planar_jacobian(t, q, J, ldj, NULL);
  return counted_done(user, COUNTED_JACOBIAN, J, NULL);
}

static inline int counted_bias(double t, const double *q, const double *v, double *phi_t,
                               double *omega, void *user)
{
  planar_bias(t, q, v, phi_t, omega, NULL);
  return counted_done(user, COUNTED_BIAS, phi_t, omega);
}

static inline int counted_gap(double t, const double *q, double *g, void *user)
{
  planar_gap(t, q, g, NULL);
  return counted_done(user, COUNTED_GAP, g, NULL);
}

static inline int counted_normal(double t, const double *q, double *W, int ldw, void *user)
{
  planar_normal(t, q, W, ldw, NULL);
  return counted_done(user, COUNTED_NORMAL, W, NULL);
}

static inline int counted_tangent(double t, const double *q, double *W, int ldw, void *user)
{
  planar_tangent(t, q, W, ldw, NULL);
  return counted_done(user, COUNTED_TANGENT, W, NULL);
}

static inline int counted_contact_bias(double t, const double *q, double *w_n, double *w_t,
                                       void *user)
{
  planar_contact_bias(t, q, w_n, w_t, NULL);
  return counted_done(user, COUNTED_CONTACT_BIAS, w_n, w_t);
}

static inline int counted_slide(double t, const double *q, double *W, int ldw, double *w,
                                void *user)
{
  (void)ldw;
  W[0] = q[2];
  W[1] = q[3];
  w[0] = 0.1 * t;
  return counted_done(user, COUNTED_SLIDE, W, w);
}

static inline int counted_kinematics(double t, const double *q, const double *v, double *qdot,
                                     void *user)
{
  planar_kinematics(t, q, v, qdot, NULL);
  return counted_done(user, COUNTED_KINEMATICS, qdot, NULL);
}

static inline int counted_potential(double t, const double *q, double *energy, void *user)
{
  planar_potential(t, q, energy, NULL);
  return counted_done(user, COUNTED_POTENTIAL, energy, NULL);
}

/* Whether the terms call it at all: kinematics only where there are differences to take, and the
 * derivatives only where they are given. */
static inline int counted_is_used(int callback, int derivatives)
{
  switch (callback) {
  case COUNTED_KINEMATICS:
    return !derivatives;
  case COUNTED_JACOBIAN:
  case COUNTED_BIAS:
  case COUNTED_NORMAL:
  case COUNTED_CONTACT_BIAS:
    return derivatives;
  default:
    return 1;
  }
}

static inline nsdae_system *counted_system(counted *user, int derivatives)
{
  const nsdae_dims dims = {
      .nq = PLANAR_NQ, .nv = PLANAR_NV, .m = PLANAR_M, .k = PLANAR_K, .nt = 1, .f = 1};
  nsdae_system *s;
  if (nsdae_system_create(&dims, &s, NULL) < 0) return NULL;
  nsdae_system_set_user(s, user);
  nsdae_system_set_kinematics(s, counted_kinematics);
  nsdae_system_set_mass(s, counted_mass);
  nsdae_system_set_force(s, counted_force);
  nsdae_system_set_constraint(s, counted_constraint);
  nsdae_system_set_gap(s, counted_gap);
  nsdae_system_set_gap_tangent(s, counted_tangent);
  nsdae_system_set_frictional_joint_tangent(s, counted_slide);
  nsdae_system_set_potential(s, counted_potential);
  if (!derivatives) return s;
  nsdae_system_set_constraint_jacobian(s, counted_jacobian);
  nsdae_system_set_constraint_bias(s, counted_bias);
  nsdae_system_set_gap_normal(s, counted_normal);
  nsdae_system_set_contact_bias(s, counted_contact_bias);
  return s;
}

#endif
