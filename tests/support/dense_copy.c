#include "dense_copy.h"

#include <stdlib.h>
#include <string.h>

#include "lists.h"
#include "system_impl.h"

static const nsdae_system *of; /* the system at hand */

static int mass(double t, const double *q, double *M, int ldm, void *user)
{
  const nsdae_blocks *blocks = &of->blocks;
  double *squares = calloc(blocks->square[blocks->count], sizeof *squares);
  int code = squares ? of->call.mass_blocks(t, q, squares, user) : -1;
  for (int b = 0; b < blocks->count && code == 0; b++) {
    int n = nsdae_blocks_size(blocks, b), first = blocks->first[b];
    for (int j = 0; j < n; j++)
      memcpy(M + (size_t)(first + j) * (size_t)ldm + first,
             squares + blocks->square[b] + (size_t)(j * n), (size_t)n * sizeof *M);
  }
  free(squares);
  return code;
}

/* Row i of Phi_q, or of W_S^T with w, to out + i step, its entries apart by stride. */
static int gather(int kind, int count, double t, const double *q, double *out, size_t step,
                  size_t stride, double *w, void *user)
{
  const nsdae_room most = {(size_t)count * (size_t)of->blocks.count,
                           (size_t)count * (size_t)of->dims.nv};
  nsdae_rows rows = {.count = count, .stride = 1};
  nsdae_row_list list = {.system = of, .blocks = &of->blocks, .kind = kind, .rows = &rows};
  rows.first = calloc((size_t)count + 1, sizeof *rows.first);
  int code = rows.first && nsdae_row_list_grow(&list, &most) == NSDAE_OK ? 0 : -1;
  if (code == 0) {
    nsdae_row_list_clear(&list);
    code = w ? of->call.joint_friction_rows(t, q, &list, w, user)
             : of->call.constraint_rows(t, q, &list, user);
    nsdae_row_list_close(&list);
  }
  for (int i = 0; i < count && code == 0; i++)
    nsdae_rows_gather(&of->blocks, &rows, i, of->blocks.first, out + (size_t)i * step, stride);
  nsdae_row_list_release(&list);
  free(rows.first);
  return code;
}

static int jacobian(double t, const double *q, double *J, int ldj, void *user)
{
  return gather(NSDAE_NAME_CONSTRAINT, of->dims.m, t, q, J, 1, (size_t)ldj, NULL, user);
}

static int joint_tangent(double t, const double *q, double *W, int ldw, double *w, void *user)
{
  return gather(NSDAE_NAME_FRICTIONAL_JOINT, of->dims.f, t, q, W, (size_t)ldw, 1, w, user);
}

nsdae_system *dense_copy(const nsdae_system *system)
{
  nsdae_system *copy;
  const nsdae_dims *d = &system->dims;
  if (system->by_list || nsdae_system_create(d, &copy, NULL) < 0) return NULL;
  of = system;
  copy->user = system->user;
  copy->call = system->call;
  copy->call.mass_blocks = NULL;
  copy->call.constraint_rows = NULL;
  copy->call.joint_friction_rows = NULL;
  copy->call.force_damping_blocks = NULL;
  copy->call.force_stiffness_blocks = NULL;
  nsdae_system_set_mass(copy, mass);
  if (system->call.constraint_rows) nsdae_system_set_constraint_jacobian(copy, jacobian);
  if (system->call.joint_friction_rows)
    nsdae_system_set_frictional_joint_tangent(copy, joint_tangent);
  memcpy(copy->contact, system->contact, (size_t)d->k * sizeof *copy->contact);
  memcpy(copy->frictional_joint, system->frictional_joint,
         (size_t)d->f * sizeof *copy->frictional_joint);
  copy->maker = system->maker;
  copy->maker.release = NULL; /* the system owns its bodies */
  return copy;
}
