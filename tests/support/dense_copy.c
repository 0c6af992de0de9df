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

static int jacobian(double t, const double *q, double *J, int ldj, void *user)
{
  const nsdae_room most = {(size_t)of->dims.m * (size_t)of->blocks.count,
                           (size_t)of->dims.m * (size_t)of->dims.nv};
  nsdae_rows rows = {.count = of->dims.m, .stride = 1};
  nsdae_row_list list = {
      .system = of, .blocks = &of->blocks, .kind = NSDAE_NAME_CONSTRAINT, .rows = &rows};
  rows.first = calloc((size_t)of->dims.m + 1, sizeof *rows.first);
  int code = rows.first && nsdae_row_list_grow(&list, &most) == NSDAE_OK ? 0 : -1;
  if (code == 0) {
    nsdae_row_list_clear(&list);
    code = of->call.constraint_rows(t, q, &list, user);
    nsdae_row_list_close(&list);
  }
  for (int i = 0; i < rows.count && code == 0; i++)
    nsdae_rows_gather(&of->blocks, &rows, i, of->blocks.first, J + i, (size_t)ldj);
  nsdae_row_list_release(&list);
  free(rows.first);
  return code;
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
  copy->call.force_damping_blocks = NULL;
  copy->call.force_stiffness_blocks = NULL;
  nsdae_system_set_mass(copy, mass);
  if (system->call.constraint_rows) nsdae_system_set_constraint_jacobian(copy, jacobian);
  memcpy(copy->contact, system->contact, (size_t)d->k * sizeof *copy->contact);
  memcpy(copy->frictional_joint, system->frictional_joint,
         (size_t)d->f * sizeof *copy->frictional_joint);
  copy->maker = system->maker;
  return copy;
}
