#include "failing_system.h"

#include <string.h>

static int turn(failing_system *f, int term, int code)
{
  long call = f->calls[term]++;
  return code == 0 && term == f->term && call == f->at ? f->code : code;
}

static const double *place(failing_system *f, const double *q)
{
  if (f->shift == 0) return q;
  for (int i = 0; i < f->inner->dims.nq; i++) f->q[i] = q[i] - f->shift;
  return f->q;
}

/* name, its place, parameters after q, arguments after q */
#define CALLBACKS(C)                                                                              \
  C(mass, 0, (double t, const double *q, double *M, int ld, void *user), M, ld)                   \
  C(force, 1, (double t, const double *q, const double *v, double *F, void *user), v, F)          \
  C(constraint, 2, (double t, const double *q, double *phi, void *user), phi)                     \
  C(constraint_jacobian, 3, (double t, const double *q, double *J, int ld, void *user), J, ld)    \
  C(constraint_bias, 4,                                                                           \
    (double t, const double *q, const double *v, double *phi_t, double *omega, void *user), v,    \
    phi_t, omega)                                                                                 \
  C(gap, 5, (double t, const double *q, double *g, void *user), g)                                \
  C(gap_normal, 6, (double t, const double *q, double *W, int ld, void *user), W, ld)             \
  C(gap_tangent, 7, (double t, const double *q, double *W, int ld, void *user), W, ld)            \
  C(contact_bias, 8, (double t, const double *q, double *w_n, double *w_t, void *user), w_n, w_t) \
  C(contact_acceleration, 9,                                                                      \
    (double t, const double *q, const double *v, double *n, double *l, double *s, void *user), v, \
    n, l, s)                                                                                      \
  C(frictional_joint_tangent, 10,                                                                 \
    (double t, const double *q, double *W, int ld, double *w, void *user), W, ld, w)              \
  C(kinematics, 11, (double t, const double *q, const double *v, double *qdot, void *user), v,    \
    qdot)                                                                                         \
  C(potential, 12, (double t, const double *q, double *energy, void *user), energy)               \
  C(mass_blocks, 13, (double t, const double *q, double *M, void *user), M)                       \
  C(constraint_rows, 14, (double t, const double *q, nsdae_row_list *rows, void *user), rows)

#define DEFINE(name, term, parameters, ...)                                                 \
  static int name parameters                                                                \
  {                                                                                         \
    failing_system *f = user;                                                               \
    return turn(f, term, f->inner->call.name(t, place(f, q), __VA_ARGS__, f->inner->user)); \
  }
CALLBACKS(DEFINE)

static void set_blocks(nsdae_system *made, const nsdae_system *inner)
{
  int sizes[2][FAILING_NQ], count = inner->blocks.count;
  for (int b = 0; b < count; b++) {
    sizes[0][b] = nsdae_blocks_size(&inner->coordinates, b);
    sizes[1][b] = nsdae_blocks_size(&inner->blocks, b);
  }
  nsdae_system_set_blocks(made, count, sizes[0], sizes[1]);
}

nsdae_system *failing_system_make(failing_system *f, const nsdae_system *inner)
{
  nsdae_system *made = NULL;
  *f = (failing_system){.inner = inner, .term = -1};
  if (nsdae_system_create(&inner->dims, &made, NULL) < 0) return NULL;
  nsdae_system_set_user(made, f);
  if (inner->by_blocks) set_blocks(made, inner);
#define SET(name, ...) \
  if (inner->call.name) nsdae_system_set_##name(made, name);
  CALLBACKS(SET)
  for (int i = 0; i < inner->dims.k; i++) {
    const nsdae_coefficients *c = &inner->contact[i];
    nsdae_system_set_contact(made, i, c->mu, c->e_n, c->e_t);
  }
  for (int j = 0; j < inner->dims.f; j++) {
    const nsdae_frictional_joint *joint = &inner->frictional_joint[j];
    if (inner->dims.m > 0) nsdae_system_set_frictional_joint(made, j, joint->constraint, joint->mu);
    nsdae_system_set_friction_bound(made, j, joint->bound);
  }
  return made;
}

void failing_system_rewind(failing_system *f)
{
  memset(f->calls, 0, sizeof f->calls);
}

const char *failing_name(int term)
{
#define NAME(name, ...) #name,
  static const char *const names[] = {CALLBACKS(NAME)};
  return names[term];
}
