/* The part of a description that large systems have: blocks, and the callbacks by blocks and by
 * list. The derivatives of constraints are rows by blocks, a dense matrix or differences. */
#include <stdlib.h>
#include <string.h>

#include "system_impl.h"

int nsdae_blocks_make(nsdae_blocks *made, int count, const int *size)
{
  nsdae_blocks blocks = {count, malloc(((size_t)count + 1) * sizeof *blocks.first),
                         malloc(((size_t)count + 1) * sizeof *blocks.square)};
  if (!blocks.first || !blocks.square) {
    nsdae_blocks_release(&blocks);
    return NSDAE_E_MEMORY;
  }
  blocks.first[0] = 0;
  blocks.square[0] = 0;
  for (int b = 0; b < count; b++) {
    blocks.first[b + 1] = blocks.first[b] + size[b];
    blocks.square[b + 1] = blocks.square[b] + (size_t)size[b] * (size_t)size[b];
  }
  nsdae_blocks_release(made);
  *made = blocks;
  return NSDAE_OK;
}

void nsdae_blocks_release(nsdae_blocks *blocks)
{
  free(blocks->first);
  free(blocks->square);
  *blocks = (nsdae_blocks){0};
}

static int check_sizes(nsdae_system *s, int count, const int *nq, const int *nv)
{
  long sum_q = 0, sum_v = 0;
  for (int b = 0; b < count; b++) {
    if (nv[b] < 1 || nv[b] > nq[b])
      return nsdae_system_refuse(s, NSDAE_E_ARGUMENT, "blocks", "nv",
                                 "block %d has nq = %d, nv = %d: it must be 1 <= nv <= nq", b,
                                 nq[b], nv[b]);
    sum_q += nq[b];
    sum_v += nv[b];
  }
  if (sum_q == s->dims.nq && sum_v == s->dims.nv) return NSDAE_OK;
  return nsdae_system_refuse(
      s, NSDAE_E_ARGUMENT, "blocks", sum_q == s->dims.nq ? "nv" : "nq",
      "the blocks have %ld coordinates and %ld velocities, the system %d, %d", sum_q, sum_v,
      s->dims.nq, s->dims.nv);
}

int nsdae_system_set_blocks(nsdae_system *s, int count, const int *nq, const int *nv)
{
  if (!s) return NSDAE_E_ARGUMENT;
  const char *missing = nq ? "nv" : "nq";
  if (!nq || !nv)
    return nsdae_system_refuse(s, NSDAE_E_ARGUMENT, "blocks", missing, "%s is NULL", missing);
  if (count < 1)
    return nsdae_system_refuse(s, NSDAE_E_ARGUMENT, "blocks", "count",
                               "there must be at least one block");
  int status = check_sizes(s, count, nq, nv);
  if (status == NSDAE_OK) status = nsdae_system_open(s, "blocks");
  if (status < 0) return status;
  nsdae_blocks blocks = {0}, coordinates = {0};
  status = nsdae_blocks_make(&blocks, count, nv);
  if (status == NSDAE_OK) status = nsdae_blocks_make(&coordinates, count, nq);
  if (status < 0) {
    nsdae_blocks_release(&blocks);
    return nsdae_system_refuse(s, status, "blocks", "", "out of memory");
  }
  nsdae_blocks_release(&s->blocks);
  nsdae_blocks_release(&s->coordinates);
  s->blocks = blocks;
  s->coordinates = coordinates;
  s->by_blocks = 1;
  return NSDAE_OK;
}

int nsdae_system_get_blocks(const nsdae_system *s)
{
  return s ? s->blocks.count : 0;
}

static int may_set(nsdae_system *s, const char *name, int given)
{
  if (strcmp(name, "constraint_rows") == 0 && s->dims.m == 0)
    return nsdae_system_refuse(s, NSDAE_E_ARGUMENT, name, name,
                               "the system has no constraints (m = 0)");
  if (strcmp(name, "joint_friction_rows") == 0 && s->dims.f == 0)
    return nsdae_system_refuse(s, NSDAE_E_ARGUMENT, name, name,
                               "the system has no frictional joints (f = 0)");
  if (!given) return nsdae_system_refuse(s, NSDAE_E_ARGUMENT, name, name, "it is NULL");
  return nsdae_system_open(s, name);
}

#define SETTER(name, type)                                                   \
  int nsdae_system_set_##name(nsdae_system *s, type callback)                \
  {                                                                          \
    int status = s ? may_set(s, #name, callback != NULL) : NSDAE_E_ARGUMENT; \
    if (status == NSDAE_OK) s->call.name = callback;                         \
    return status;                                                           \
  }

SETTER(mass_blocks, nsdae_mass_blocks_fn)
SETTER(constraint_rows, nsdae_constraint_rows_fn)
SETTER(joint_friction_rows, nsdae_joint_friction_rows_fn)
SETTER(force_damping_blocks, nsdae_force_blocks_fn)
SETTER(force_stiffness_blocks, nsdae_force_blocks_fn)

int nsdae_system_set_contacts(nsdae_system *s, nsdae_contacts_fn callback)
{
  if (!s) return NSDAE_E_ARGUMENT;
  if (s->dims.k > 0)
    return nsdae_system_refuse(s, NSDAE_E_ARGUMENT, "contacts", "k",
                               "a contact list replaces fixed contacts: dims.k must be 0");
  int status = may_set(s, "contacts", callback != NULL);
  if (status < 0) return status;
  s->call.contacts = callback;
  s->by_list = 1;
  return NSDAE_OK;
}

void nsdae_system_track(nsdae_system *model, nsdae_tracked *table)
{
  model->by_list = 0;
  model->contact = NULL;
  model->tracked = table;
}

void nsdae_system_track_no_more(nsdae_system *model)
{
  if (!model->tracked) return;
  model->by_list = 1;
  model->dims.k = 0;
  model->tracked = NULL;
}

/* M, D and K are by blocks or dense; Phi_q and W_S of a system with blocks are either, too. */
static const char *misplaced(const nsdae_system *s)
{
  const nsdae_calls *c = &s->call;
  if (s->by_blocks)
    return c->mass                                                 ? "mass"
           : c->constraint_rows && c->constraint_jacobian          ? "constraint_jacobian"
           : c->joint_friction_rows && c->frictional_joint_tangent ? "frictional_joint_tangent"
           : c->force_damping                                      ? "force_damping"
           : c->force_stiffness                                    ? "force_stiffness"
                                                                   : NULL;
  return c->mass_blocks              ? "mass_blocks"
         : c->constraint_rows        ? "constraint_rows"
         : c->joint_friction_rows    ? "joint_friction_rows"
         : c->force_damping_blocks   ? "force_damping_blocks"
         : c->force_stiffness_blocks ? "force_stiffness_blocks"
         : c->contacts               ? "contacts"
                                     : NULL;
}

int nsdae_system_check_blocks(const nsdae_system *s, const char **missing, nsdae_error *error)
{
  const char *wrong = misplaced(s);
  if (s->by_blocks && !s->call.mass_blocks) *missing = "mass_blocks";
  if (!wrong) return NSDAE_OK;
  return nsdae_error_set(
      error, NSDAE_E_STATE, "nsdae_system", wrong,
      s->by_blocks ? "%s: a system with blocks has mass_blocks, force_damping_blocks, "
                     "force_stiffness_blocks, one of constraint_rows and constraint_jacobian, "
                     "and one of joint_friction_rows and frictional_joint_tangent"
                   : "%s needs blocks: call nsdae_system_set_blocks",
      wrong);
}
