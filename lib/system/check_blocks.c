/* Entries of M against the transposed ones, of Phi_q against differences of Phi along each
 * velocity, and the rate of each gap in a list, W_N v + w, against differences of the gap of the
 * same id along two trial velocities, and omega where it is given: what is listed at the point,
 * within a tenth of 1 + max |q|. Rows of frictional joints have no position: they are called alone.
 */
#include <float.h>
#include <math.h>
#include <string.h>

#include "block_list.h"
#include "derivative_check.h"
#include "errors.h"
#include "lists.h"

typedef nsdae_derivative_check check;

/* What the callbacks fill. */
typedef struct context {
  check *c;
  nsdae_row_list rows, joints; /* into jacobian, into directions */
  nsdae_rows jacobian, directions;
  nsdae_contact_list list, ahead, back;
} context;

/* The rows, with as much room as they take; of W_S^T with w_S in given. */
static int list_rows(check *c, nsdae_row_list *rows, const char *callback)
{
  const nsdae_system *s = c->system;
  for (int round = 0; round < 2; round++) {
    nsdae_row_list_clear(rows);
    memset(c->given, 0, (size_t)rows->rows->count * sizeof *c->given);
    int code = rows->kind == NSDAE_NAME_CONSTRAINT
                   ? s->call.constraint_rows(c->t, c->q, rows, s->user)
                   : s->call.joint_friction_rows(c->t, c->q, rows, c->given, s->user);
    nsdae_row_list_close(rows);
    if (rows->status < 0) return rows->status;
    int status = nsdae_check_callback(c, code, callback);
    if (status < 0 || nsdae_room_enough(&rows->room, &rows->taken)) return status;
    status = nsdae_row_list_grow(rows, &rows->taken);
    if (status < 0) return status;
  }
  return nsdae_error_set(&c->system->error, NSDAE_E_CALLBACK, "nsdae_system_check", callback,
                         "%s gave more rows when it was called again", callback);
}

/* The rows alone, and that w_S is finite: no position is theirs. */
static int check_joints(context *x)
{
  static const char *const callback = "joint_friction_rows";
  nsdae_system *s = x->c->system;
  int status = list_rows(x->c, &x->joints, callback);
  return status < 0
             ? status
             : nsdae_system_finite(s, x->c->given, s->dims.f, 1, callback, x->c->t, &s->error);
}

/* Column by column: the product with a unit vector. */
static int check_rows(context *x)
{
  check *c = x->c;
  const nsdae_system *s = c->system;
  int status = list_rows(c, &x->rows, "constraint_rows");
  for (int j = 0; j < s->dims.nv && status == NSDAE_OK; j++) {
    memset(c->trial, 0, (size_t)s->dims.nv * sizeof *c->trial);
    c->trial[j] = 1;
    int code = nsdae_differences_along(&c->differences, s->call.constraint, s->dims.m, c->t, c->q,
                                       c->trial, c->differenced);
    status = nsdae_check_difference(c, code, "constraint");
    for (int i = 0; i < s->dims.m && status == NSDAE_OK; i++)
      nsdae_check_keep(c, "constraint_rows", i, j,
                       nsdae_rows_dot(&s->blocks, &x->jacobian, i, c->trial), c->differenced[i]);
  }
  return status;
}

/* A list, with as much room as it takes. */
static int list_contacts(check *c, nsdae_contact_list *list, double t, const double *q,
                         double reach)
{
  for (int round = 0; round < 2; round++) {
    nsdae_contact_list_clear(list);
    int code = c->system->call.contacts(t, q, c->v, reach, list, c->system->user);
    if (list->status < 0) return list->status;
    int status = nsdae_check_callback(c, code, "contacts");
    if (status < 0 || nsdae_room_enough(&list->room, &list->taken)) return status;
    status = nsdae_contact_list_grow(list, &list->taken);
    if (status < 0) return status;
  }
  return nsdae_error_set(&c->system->error, NSDAE_E_CALLBACK, "nsdae_system_check", "contacts",
                         "contacts gave a longer list when it was called again");
}

static int find_contact(const nsdae_contact_list *list, long id, int likely)
{
  if (likely < list->count && list->id[likely] == id) return likely;
  for (int i = 0; i < list->count; i++)
    if (list->id[i] == id) return i;
  return -1;
}

/* The rates along one trial velocity; a contact that is not in all three lists says nothing. */
static int check_rates(context *x, double reach)
{
  check *c = x->c;
  nsdae_differences *d = &c->differences;
  int nq = c->system->dims.nq;
  int code = nsdae_kinematics(c->system, c->t, c->q, c->trial, d->qdot);
  int status = nsdae_check_callback(c, code, "kinematics");
  if (status < 0) return status;
  double s = nsdae_differences_step(nq, c->t, c->q, d->qdot, cbrt(DBL_EPSILON));
  nsdae_move(nq, c->q, s, d->qdot, d->q);
  status = list_contacts(c, &x->ahead, c->t + s, d->q, reach);
  nsdae_move(nq, c->q, -s, d->qdot, d->q);
  if (status == NSDAE_OK) status = list_contacts(c, &x->back, c->t - s, d->q, reach);
  for (int i = 0; i < x->list.count && status == NSDAE_OK; i++) {
    int a = find_contact(&x->ahead, x->list.id[i], i), b = find_contact(&x->back, x->list.id[i], i);
    if (a < 0 || b < 0) continue;
    nsdae_check_keep(c, "contacts", i, 0, nsdae_contact_list_velocity(&x->list, i, 0, c->trial),
                     (x->ahead.gap[a] - x->back.gap[b]) / (2 * s));
  }
  return status;
}

/* omega of direction d of entry i, by differences of the velocities in the four lists along the
 * motion; NaN where one of them has no such contact. */
static double difference(context *x, const nsdae_contact_list *near, double s, int i, int d)
{
  static const double weight[4] = {1, -8, 8, -1};
  double sum = 0;
  for (int n = 0; n < 4; n++) {
    int entry = find_contact(&near[n], x->list.id[i], i);
    sum += entry < 0 ? NAN : weight[n] * nsdae_contact_list_velocity(&near[n], entry, d, x->c->v);
  }
  return sum / (12 * s);
}

/* Accelerations at v' = 0 where they are given, along the motion. */
static int check_accelerations(context *x, double reach)
{
  check *c = x->c;
  nsdae_differences *d = &c->differences;
  nsdae_contact_list near[4];
  int rows = 1 + c->system->dims.nt, nq = c->system->dims.nq;
  int status =
      nsdae_check_callback(c, nsdae_kinematics(c->system, c->t, c->q, c->v, d->qdot), "kinematics");
  double s = nsdae_differences_acceleration_step(d, c->t, c->q);
  for (int n = 0; n < 4; n++) {
    static const int at[4] = {-2, -1, 1, 2};
    near[n] =
        (nsdae_contact_list){.blocks = x->list.blocks, .nt = x->list.nt, .error = x->list.error};
    nsdae_move(nq, c->q, at[n] * s, d->qdot, d->q);
    if (status == NSDAE_OK) status = list_contacts(c, &near[n], c->t + at[n] * s, d->q, reach);
  }
  for (int i = 0; i < x->list.count && status == NSDAE_OK; i++)
    for (int row = 0; row < rows && x->list.omega_given[i]; row++) {
      double differenced = difference(x, near, s, i, row);
      if (isfinite(differenced))
        nsdae_check_keep(c, "contacts", i, row, x->list.omega[i * rows + row], differenced);
    }
  for (int n = 0; n < 4; n++) nsdae_contact_list_release(&near[n]);
  return status;
}

int nsdae_check_lists(check *c)
{
  nsdae_system *s = c->system;
  const nsdae_contact_list empty = {.blocks = &s->blocks, .nt = s->dims.nt, .error = &s->error};
  context x = {.c = c, .list = empty, .ahead = empty, .back = empty};
  x.jacobian = (nsdae_rows){.count = s->dims.m, .stride = 1, .first = c->first};
  x.directions = (nsdae_rows){.count = s->dims.f, .stride = 1, .first = c->first};
  x.rows = x.joints = (nsdae_row_list){.system = s, .blocks = &s->blocks, .error = &s->error};
  x.rows.kind = NSDAE_NAME_CONSTRAINT;
  x.rows.rows = &x.jacobian;
  x.joints.kind = NSDAE_NAME_FRICTIONAL_JOINT;
  x.joints.rows = &x.directions;
  /* The mass against its transpose. */
  memset(c->given, 0, s->blocks.square[s->blocks.count] * sizeof *c->given);
  int code = s->call.mass_blocks(c->t, c->q, c->given, s->user);
  int status = nsdae_check_callback(c, code, "mass_blocks");
  for (int b = 0; b < s->blocks.count && status == NSDAE_OK; b++) {
    int n = nsdae_blocks_size(&s->blocks, b), at = s->blocks.first[b];
    const double *M = c->given + s->blocks.square[b];
    for (int j = 0; j < n; j++)
      for (int i = 0; i < n; i++)
        nsdae_check_keep(c, "mass_blocks", at + i, at + j, M[j * n + i], M[i * n + j]);
  }
  if (status == NSDAE_OK && s->call.joint_friction_rows) status = check_joints(&x);
  if (status == NSDAE_OK && s->call.constraint_rows) status = check_rows(&x);
  double reach = 0.1 * (1 + nsdae_largest(s->dims.nq, c->q));
  if (status == NSDAE_OK && s->call.contacts) status = list_contacts(c, &x.list, c->t, c->q, reach);
  for (int number = 0; number < 2 && s->call.contacts && status == NSDAE_OK; number++) {
    for (int j = 0; j < s->dims.nv; j++) c->trial[j] = cos(1 + number + 2.399963 * (j + 1));
    status = check_rates(&x, reach);
  }
  int given = 0;
  for (int i = 0; i < x.list.count; i++) given |= x.list.omega_given[i];
  if (given && status == NSDAE_OK) status = check_accelerations(&x, reach);
  if (status == NSDAE_E_MEMORY) nsdae_error_memory(&s->error, "nsdae_system_check");
  nsdae_contact_list_release(&x.list);
  nsdae_contact_list_release(&x.ahead);
  nsdae_contact_list_release(&x.back);
  nsdae_row_list_release(&x.rows);
  nsdae_row_list_release(&x.joints);
  return status;
}

/* Column by column, e the unit vector of a velocity:
 *
 *   D e = -(F(v + s e) - F(v - s e)) / 2s,   K e = -(F(q + s H e) - F(q - s H e)) / 2s
 *
 * with s ~ eps^(1/3). F is known to eps |F|, so that a difference of less than 4 eps |F| / s is
 * rounding: next to a stiff spring it is more than the tolerance. */

typedef nsdae_derivative_check check;

/* One of the two matrices: its callback, one of both. */
typedef struct derivative {
  const char *name, *name_blocks;
  nsdae_force_damping_fn dense;
  nsdae_force_blocks_fn blocks;
  int along_q;
} derivative;

static int force_displaced(check *c, int along_q, double s, double *F)
{
  const nsdae_dims *dims = &c->system->dims;
  nsdae_differences *d = &c->differences;
  for (int i = 0; i < dims->nq; i++) d->q[i] = c->q[i] + (along_q ? s * d->qdot[i] : 0);
  for (int j = 0; j < dims->nv; j++) c->trial[j] = c->v[j] + (along_q ? 0 : s * d->unit[j]);
  memset(F, 0, (size_t)dims->nv * sizeof *F);
  return nsdae_check_callback(c, c->system->call.force(c->t, d->q, c->trial, F, c->system->user),
                              "force");
}

static int check_column(check *c, const derivative *x, int j)
{
  const nsdae_dims *dims = &c->system->dims;
  nsdae_differences *d = &c->differences;
  double *plus = c->differenced, *minus = c->spare;
  const double *given = x->dense ? c->given + (size_t)j * (size_t)dims->nv : c->given;
  memset(d->unit, 0, (size_t)dims->nv * sizeof *d->unit);
  d->unit[j] = 1;
  int code = nsdae_kinematics(c->system, c->t, c->q, d->unit, d->qdot);
  int status = nsdae_check_callback(c, code, "kinematics");
  if (status < 0) return status;
  double s = x->along_q ? nsdae_differences_step(dims->nq, 0, c->q, d->qdot, cbrt(DBL_EPSILON))
                        : ldexp(0x1p-17, ilogb(fmax(1, nsdae_largest(dims->nv, c->v))));
  status = force_displaced(c, x->along_q, s, plus);
  if (status == NSDAE_OK) status = force_displaced(c, x->along_q, -s, minus);
  if (status == NSDAE_OK && !x->dense) { /* its column into given */
    nsdae_block_list list = {.system = c->system,
                             .callback = x->name_blocks,
                             .error = &c->system->error,
                             .x = d->unit,
                             .product = c->given};
    memset(c->given, 0, (size_t)dims->nv * sizeof *c->given);
    code = x->blocks(c->t, c->q, c->v, &list, c->system->user);
    status = list.status < 0 ? list.status : nsdae_check_callback(c, code, x->name_blocks);
  }
  for (int i = 0; i < dims->nv && status == NSDAE_OK; i++) {
    double difference = (minus[i] - plus[i]) / (2 * s);
    double rounding = 2 * DBL_EPSILON * (fabs(plus[i]) + fabs(minus[i])) / s;
    if (fabs(given[i] - difference) <= rounding) continue;
    nsdae_check_keep(c, x->dense ? x->name : x->name_blocks, i, j, given[i], difference);
  }
  return status;
}

static int check_derivative(check *c, const derivative *x)
{
  int n = c->system->dims.nv, status = NSDAE_OK;
  if (!x->dense && !x->blocks) return NSDAE_OK;
  if (x->dense) {
    memset(c->given, 0, (size_t)n * (size_t)n * sizeof *c->given);
    int code = x->dense(c->t, c->q, c->v, c->given, n, c->system->user);
    status = nsdae_check_callback(c, code, x->name);
  }
  for (int j = 0; j < n && status == NSDAE_OK; j++) status = check_column(c, x, j);
  return status;
}

int nsdae_check_forces(check *c)
{
  const nsdae_calls *call = &c->system->call;
  const derivative damping = {"force_damping", "force_damping_blocks", call->force_damping,
                              call->force_damping_blocks, 0};
  const derivative stiffness = {"force_stiffness", "force_stiffness_blocks", call->force_stiffness,
                                call->force_stiffness_blocks, 1};
  int status = check_derivative(c, &damping);
  return status < 0 ? status : check_derivative(c, &stiffness);
}
