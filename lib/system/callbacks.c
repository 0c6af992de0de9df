#include "callbacks.h"

#include <string.h>

#define CALL(name, ...)                                                                    \
  static int has_##name(const nsdae_system *s)                                             \
  {                                                                                        \
    return s->call.name != NULL;                                                           \
  }                                                                                        \
  static int call_##name(const nsdae_system *s, const nsdae_place *at, double *const *out, \
                         const int *ld)                                                    \
  {                                                                                        \
    (void)ld;                                                                              \
    return s->call.name(at->t, at->q, __VA_ARGS__, s->user);                               \
  }

/* callbacks.list: calls_in_c */
CALL(mass, out[0], ld[0])
CALL(force, at->v, out[0])
CALL(force_damping, at->v, out[0], ld[0])
CALL(force_stiffness, at->v, out[0], ld[0])
CALL(constraint, out[0])
CALL(constraint_jacobian, out[0], ld[0])
CALL(constraint_bias, at->v, out[0], out[1])
CALL(gap, out[0])
CALL(gap_normal, out[0], ld[0])
CALL(gap_tangent, out[0], ld[0])
CALL(contact_bias, out[0], out[1])
CALL(contact_acceleration, at->v, out[0], out[1], out[2])
CALL(frictional_joint_tangent, out[0], ld[0], out[1])
CALL(joint_friction_bound, at->v, out[0])
CALL(kinematics, at->v, out[0])
CALL(potential, out[0])
CALL(contact_speed, at->v, out[0])
/* callbacks.list: end */

#define COORDINATE       NSDAE_NAME_COORDINATE
#define VELOCITY         NSDAE_NAME_VELOCITY
#define CONSTRAINT       NSDAE_NAME_CONSTRAINT
#define CONTACT          NSDAE_NAME_CONTACT
#define FRICTIONAL_JOINT NSDAE_NAME_FRICTIONAL_JOINT

const nsdae_callback nsdae_callbacks[] = {
    /* callbacks.list: outputs */
    /* clang-format off */
    {"mass", has_mass, call_mass, 1,
     {{"M", VELOCITY, VELOCITY, 0, 0}}},
    {"force", has_force, call_force, 1,
     {{"F", VELOCITY, -1, 0, 0}}},
    {"force_damping", has_force_damping, call_force_damping, 1,
     {{"D", VELOCITY, VELOCITY, 0, 0}}},
    {"force_stiffness", has_force_stiffness, call_force_stiffness, 1,
     {{"K", VELOCITY, VELOCITY, 0, 0}}},
    {"constraint", has_constraint, call_constraint, 1,
     {{"phi", CONSTRAINT, -1, 0, 0}}},
    {"constraint_jacobian", has_constraint_jacobian, call_constraint_jacobian, 1,
     {{"J", CONSTRAINT, VELOCITY, 0, 0}}},
    {"constraint_bias", has_constraint_bias, call_constraint_bias, 2,
     {{"phi_t", CONSTRAINT, -1, 0, 0}, {"omega", CONSTRAINT, -1, 0, 0}}},
    {"gap", has_gap, call_gap, 1,
     {{"g", CONTACT, -1, 0, 0}}},
    {"gap_normal", has_gap_normal, call_gap_normal, 1,
     {{"W", VELOCITY, CONTACT, 0, 0}}},
    {"gap_tangent", has_gap_tangent, call_gap_tangent, 1,
     {{"W", VELOCITY, CONTACT, 1, 0}}},
    {"contact_bias", has_contact_bias, call_contact_bias, 2,
     {{"w_n", CONTACT, -1, 0, 0}, {"w_t", CONTACT, -1, 1, 1}}},
    {"contact_acceleration", has_contact_acceleration, call_contact_acceleration, 3,
     {{"omega_n", CONTACT, -1, 0, 1}, {"omega_t", CONTACT, -1, 1, 1},
      {"omega_s", FRICTIONAL_JOINT, -1, 0, 1}}},
    {"frictional_joint_tangent", has_frictional_joint_tangent, call_frictional_joint_tangent, 2,
     {{"W", VELOCITY, FRICTIONAL_JOINT, 0, 0}, {"w_s", FRICTIONAL_JOINT, -1, 0, 0}}},
    {"joint_friction_bound", has_joint_friction_bound, call_joint_friction_bound, 1,
     {{"bound", FRICTIONAL_JOINT, -1, 0, 0}}},
    {"kinematics", has_kinematics, call_kinematics, 1,
     {{"qdot", COORDINATE, -1, 0, 0}}},
    {"potential", has_potential, call_potential, 1,
     {{"energy", -1, -1, 0, 0}}},
    {"contact_speed", has_contact_speed, call_contact_speed, 1,
     {{"speed", -1, -1, 0, 0}}},
    /* clang-format on */
    /* callbacks.list: end */
};

const int nsdae_callbacks_count = (int)(sizeof nsdae_callbacks / sizeof *nsdae_callbacks);

const nsdae_callback *nsdae_callback_of(const char *name)
{
  for (int c = 0; c < nsdae_callbacks_count; c++)
    if (strcmp(nsdae_callbacks[c].name, name) == 0) return &nsdae_callbacks[c];
  return NULL;
}

int nsdae_output_extent(const nsdae_system *system, const nsdae_output *output, int kind)
{
  int each = kind < 0 ? 1 : nsdae_system_count(system, kind);
  return output->directions && kind == NSDAE_NAME_CONTACT ? each * system->dims.nt : each;
}
