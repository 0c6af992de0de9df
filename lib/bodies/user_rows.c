/* Coordinates and rows of one's own: what is given must fit the sizes. */
#include "bodies_impl.h"

static const char what[] = "user rows";

typedef struct callback_need {
  const char *name;
  int given, needed, called; /* called: there is something that it would fill */
} callback_need;

static int check_dims(nsdae_bodies *b, const nsdae_dims *d)
{
  const int size[5] = {d->nq, d->nv, d->m, d->k, d->f};
  static const char *const name[5] = {"nq", "nv", "m", "k", "f"};
  for (int i = 0; i < 5; i++)
    if (size[i] < 0 || size[i] > 1 << 20)
      return nsdae_bodies_refuse(b, NSDAE_E_ARGUMENT, what, name[i], -1,
                                 "dims.%s = %d is outside its range: it must be 0 .. 2^20", name[i],
                                 size[i]);
  if (d->nv > d->nq)
    return nsdae_bodies_refuse(b, NSDAE_E_ARGUMENT, what, "nv", -1,
                               "dims.nv = %d is more than dims.nq = %d", d->nv, d->nq);
  return NSDAE_OK;
}

/* Callbacks that the sizes need are given, and none that is never called. */
static int check_callbacks(nsdae_bodies *b, const nsdae_user_rows *o)
{
  const nsdae_dims *d = &o->dims;
  const callback_need needs[] = {
      {"mass", o->mass != NULL, d->nv > 0, d->nv > 0},
      {"constraint", o->constraint != NULL, d->m > 0, d->m > 0},
      {"constraint_jacobian", o->constraint_jacobian != NULL, 0, d->m > 0},
      {"constraint_bias", o->constraint_bias != NULL, 0, d->m > 0},
      {"constraint_rows", o->constraint_rows != NULL, 0, d->m > 0},
      {"gap", o->gap != NULL, d->k > 0, d->k > 0},
      {"gap_normal", o->gap_normal != NULL, 0, d->k > 0},
      {"gap_tangent", o->gap_tangent != NULL, d->k > 0, d->k > 0},
      {"contact_bias", o->contact_bias != NULL, 0, d->k > 0},
      {"contact_acceleration", o->contact_acceleration != NULL, 0, d->k + d->f > 0},
      {"frictional_joint_tangent", o->frictional_joint_tangent != NULL, d->f > 0, d->f > 0},
      {"kinematics", o->kinematics != NULL, d->nv != d->nq, d->nv > 0},
  };
  for (size_t i = 0; i < sizeof needs / sizeof *needs; i++) {
    if (needs[i].needed && !needs[i].given)
      return nsdae_bodies_refuse(b, NSDAE_E_ARGUMENT, what, needs[i].name, -1,
                                 "the callback %s is missing", needs[i].name);
    if (needs[i].given && !needs[i].called)
      return nsdae_bodies_refuse(b, NSDAE_E_ARGUMENT, what, needs[i].name, -1,
                                 "%s is never called: by dims its outputs are empty",
                                 needs[i].name);
  }
  return NSDAE_OK;
}

int nsdae_bodies_set_user_rows(nsdae_bodies *b, const nsdae_user_rows *own)
{
  int status = nsdae_bodies_open(b, own, "own");
  if (status < 0) return status;
  const nsdae_user_rows *o = &b->own;
  if (o->dims.nq + o->dims.m + o->dims.k > 0 || o->force || o->contacts || o->potential)
    return nsdae_bodies_refuse(b, NSDAE_E_STATE, what, "own", -1, "they are set already");
  nsdae_user_rows copy = *own;
  if (copy.dims.nv == 0) copy.dims.nv = copy.dims.nq;
  status = check_dims(b, &copy.dims);
  if (status == NSDAE_OK) status = check_callbacks(b, &copy);
  if (status == NSDAE_OK) b->own = copy;
  return status;
}
