/* The kit: bodies, gravity, start, and the system that is made of them. */
#include <math.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "broad_phase.h"
#include "errors.h"
#include "bodies_impl.h"
#include "mesh.h"

int nsdae_bodies_create(int dimension, nsdae_bodies **bodies, nsdae_error *error)
{
  nsdae_error_clear(error);
  if (!bodies)
    return nsdae_error_set(error, NSDAE_E_ARGUMENT, "nsdae_bodies_create", "bodies",
                           "bodies is NULL");
  *bodies = NULL;
  if (dimension != 2 && dimension != 3)
    return nsdae_error_set(error, NSDAE_E_ARGUMENT, "nsdae_bodies_create", "dimension",
                           "dimension = %d is neither 2 nor 3", dimension);
  nsdae_bodies *made = calloc(1, sizeof *made);
  if (!made) return nsdae_error_memory(error, "nsdae_bodies_create");
  made->dimension = dimension;
  atomic_init(&made->life.owners, 1);
  nsdae_error_clear(&made->error);
  *bodies = made;
  return NSDAE_OK;
}

void nsdae_bodies_let_go(const void *bodies)
{
  nsdae_bodies *b = (nsdae_bodies *)(uintptr_t)bodies;
  if (atomic_fetch_sub(&b->life.owners, 1) > 1) return;
  for (int i = 0; i < b->solid.count; i++) {
    free(nsdae_solid_at(b, i)->point);
    nsdae_hull_release(nsdae_solid_at(b, i)->hull);
    nsdae_mesh_release(nsdae_solid_at(b, i)->mesh);
  }
  nsdae_list *lists[] = {
      &b->body,         &b->constraint, &b->frictional_joint, &b->solid, &b->feature, &b->limit,
      &b->force.spring, &b->force.load, &b->force.target,     &b->pair,  &b->joint,   &b->name,
      &b->sensor};
  for (int i = 0; i < NSDAE_BROADS; i++) nsdae_broad_release(b->broad[i]);
  for (size_t i = 0; i < sizeof lists / sizeof *lists; i++) free(lists[i]->at);
  free(b);
}

void nsdae_bodies_destroy(nsdae_bodies **bodies)
{
  if (!bodies || !*bodies) return;
  nsdae_bodies_let_go(*bodies);
  *bodies = NULL;
}

/* The functions that have no handle to leave a record in. */
static const nsdae_error no_bodies = {.status = NSDAE_E_ARGUMENT,
                                      .index = -1,
                                      .argument = "bodies",
                                      .where = "nsdae_bodies",
                                      .text = "bodies is NULL: nsdae_bodies_create failed, or was "
                                              "not called"};

const nsdae_error *nsdae_bodies_error(const nsdae_bodies *bodies)
{
  return bodies ? &bodies->error : &no_bodies;
}

int nsdae_bodies_refuse(nsdae_bodies *b, int status, const char *what, const char *argument,
                        int index, const char *format, ...)
{
  char text[sizeof b->error.text];
  va_list values;
  if (b->error.status < 0) return b->error.status;
  va_start(values, format);
  vsnprintf(text, sizeof text, format, values);
  va_end(values);
  if (index < 0)
    nsdae_error_set(&b->error, status, "nsdae_bodies", argument, "%s: %s", what, text);
  else
    nsdae_error_set(&b->error, status, "nsdae_bodies", argument, "%s %d: %s", what, index, text);
  b->error.index = index;
  return status;
}

int nsdae_bodies_open(nsdae_bodies *b, const void *given, const char *what)
{
  if (!b) return NSDAE_E_ARGUMENT;
  if (b->error.status < 0) return b->error.status;
  if (b->life.made)
    return nsdae_error_set(&b->error, NSDAE_E_STATE, "nsdae_bodies", what,
                           "the system exists: add all objects before nsdae_bodies_system");
  if (!given)
    return nsdae_error_set(&b->error, NSDAE_E_ARGUMENT, "nsdae_bodies", what, "%s is NULL", what);
  return NSDAE_OK;
}

void *nsdae_list_add(nsdae_bodies *b, nsdae_list *list, size_t size)
{
  if (list->count == list->room) {
    int room = list->room > 0 ? 2 * list->room : 8;
    void *at = list->room > INT32_MAX / 2 ? NULL : realloc(list->at, (size_t)room * size);
    if (!at) {
      nsdae_error_memory(&b->error, "nsdae_bodies");
      return NULL;
    }
    list->at = at;
    list->room = room;
  }
  void *entry = (char *)list->at + (size_t)list->count++ * size;
  memset(entry, 0, size);
  return entry;
}

static int check_finite(nsdae_bodies *b, const char *what, const char *argument, int index,
                        const double *x, int count)
{
  for (int i = 0; i < count; i++)
    if (!isfinite(x[i]))
      return nsdae_bodies_refuse(b, NSDAE_E_NONFINITE, what, argument, index,
                                 "%s[%d] = %g is not a finite number", argument, i, x[i]);
  return NSDAE_OK;
}

int nsdae_bodies_check_vector(nsdae_bodies *b, const char *what, const char *argument, int index,
                              const double *x, int planar_zero)
{
  int status = check_finite(b, what, argument, index, x, 3);
  if (status < 0 || !planar_zero || b->dimension == 3 || x[2] == 0) return status;
  return nsdae_bodies_refuse(b, NSDAE_E_ARGUMENT, what, argument, index,
                             "%s[2] = %g lies outside of the plane: it must be 0", argument, x[2]);
}

int nsdae_bodies_check_least(nsdae_bodies *b, const char *what, const char *argument, int index,
                             double x, double least, int open)
{
  if (isfinite(x) && (open ? x > least : x >= least)) return NSDAE_OK;
  return nsdae_bodies_refuse(b, NSDAE_E_ARGUMENT, what, argument, index,
                             "%s = %g is not a finite number %s %g", argument, x,
                             open ? "above" : "of at least", least);
}

int nsdae_bodies_check_turn(nsdae_bodies *b, const char *what, int index, double angle,
                            const double *quaternion)
{
  if (!isfinite(angle))
    return nsdae_bodies_refuse(b, NSDAE_E_NONFINITE, what, "angle", index,
                               "angle = %g is not a finite number", angle);
  int status = check_finite(b, what, "quaternion", index, quaternion, 4),
      planar = b->dimension == 2;
  const double *p = quaternion;
  if (status == NSDAE_OK && planar && (p[1] != 0 || p[2] != 0 || p[3] != 0))
    return nsdae_bodies_refuse(b, NSDAE_E_ARGUMENT, what, "quaternion", index,
                               "quaternion (%g, %g, %g, %g) has no effect in the plane: give angle",
                               p[0], p[1], p[2], p[3]);
  if (status == NSDAE_OK && !planar && angle != 0)
    return nsdae_bodies_refuse(b, NSDAE_E_ARGUMENT, what, "angle", index,
                               "angle = %g has no effect in space: give quaternion", angle);
  return status;
}

/* Eigenvalues of T, ascending, by cyclic Jacobi rotations (Golub and Van Loan, Matrix Computations,
 * 8.5.3): a sweep squares what is off the diagonal once it is small, so six reach rounding. */
static void principal_moments(double T[3][3], double moment[3])
{
  for (int turn = 0; turn < 18; turn++) {
    int p = turn % 3 == 2, q = turn % 3 == 0 ? 1 : 2, r = 3 - p - q;
    if (T[p][q] == 0) continue;
    double c = (T[q][q] - T[p][p]) / 2, x = T[r][p], y = T[r][q];
    double tangent = T[p][q] / (c + copysign(hypot(c, T[p][q]), c)),
           cosine = 1 / sqrt(1 + tangent * tangent);
    T[p][p] -= tangent * T[p][q];
    T[q][q] += tangent * T[p][q];
    T[p][q] = T[q][p] = 0;
    T[r][p] = T[p][r] = cosine * (x - tangent * y);
    T[r][q] = T[q][r] = cosine * (y + tangent * x);
  }
  for (int i = 0; i < 3; i++) {
    int at = i;
    for (; at > 0 && moment[at - 1] > T[i][i]; at--) moment[at] = moment[at - 1];
    moment[at] = T[i][i];
  }
}

/* The tensor J of a body is int (r.r 1 - r r^T) dm, so its principal moments are
 *
 *   J_i > 0,   J_2 <= J_0 + J_1,   ascending; equal if the mass lies in a plane
 *
 * as J_0 + J_1 - J_2 = 2 int r_2^2 dm. Moments are taken with five digits. */
static int check_inertia(nsdae_bodies *b, int index, const nsdae_rigid_body *body)
{
  const char *what = "body", *name = "inertia";
  const double *J = body->inertia, *P = body->product;
  double T[3][3] = {{J[0], P[0], P[1]}, {P[0], J[1], P[2]}, {P[1], P[2], J[2]}}, principal[3];
  for (int i = b->dimension == 2 ? 2 : 0; i < 3; i++)
    if (!(isfinite(J[i]) && J[i] > 0))
      return nsdae_bodies_refuse(b, NSDAE_E_ARGUMENT, what, name, index,
                                 "inertia[%d] = %g is not a finite number above 0", i, J[i]);
  int status = check_finite(b, what, "product", index, P, 3);
  if (status < 0) return status;
  if (b->dimension == 2 && (P[0] != 0 || P[1] != 0 || P[2] != 0))
    return nsdae_bodies_refuse(b, NSDAE_E_ARGUMENT, what, "product", index,
                               "product (%g, %g, %g) in the plane must be 0", P[0], P[1], P[2]);
  if (b->dimension == 2) return NSDAE_OK;
  principal_moments(T, principal);
  if (!(principal[0] > 0))
    return nsdae_bodies_refuse(b, NSDAE_E_ARGUMENT, what, "product", index,
                               "the inertia tensor has the principal moment %g: it must be above 0",
                               principal[0]);
  if (nsdae_is_moment(principal[2], principal[0], principal[1])) return NSDAE_OK;
  return nsdae_bodies_refuse(b, NSDAE_E_ARGUMENT, what, name, index,
                             "no body has the principal moments of inertia %g, %g, %g: the largest "
                             "must be at most the sum of the others, %g",
                             principal[0], principal[1], principal[2], principal[0] + principal[1]);
}

int nsdae_bodies_check_pair(nsdae_bodies *b, const char *what, int index, const int *body)
{
  for (int i = 0; i < 2; i++)
    if (body[i] < NSDAE_GROUND || body[i] >= b->body.count)
      return nsdae_bodies_refuse(b, NSDAE_E_ARGUMENT, what, "body", index,
                                 "body = %d is not a body: there are %d, from 0, and the ground "
                                 "(%d)",
                                 body[i], b->body.count, NSDAE_GROUND);
  if (body[0] != body[1]) return NSDAE_OK;
  return nsdae_bodies_refuse(b, NSDAE_E_ARGUMENT, what, "body", index,
                             "both are body %d: they must be two different bodies", body[0]);
}

int nsdae_bodies_add(nsdae_bodies *b, const nsdae_rigid_body *body)
{
  int status = nsdae_bodies_open(b, body, "body");
  if (status < 0) return status;
  int index = b->body.count;
  const char *what = "body";
  nsdae_bodies_check_least(b, what, "mass", index, body->mass, 0, 1);
  check_inertia(b, index, body);
  nsdae_bodies_check_vector(b, what, "position", index, body->position, 1);
  nsdae_bodies_check_vector(b, what, "velocity", index, body->velocity, 1);
  nsdae_bodies_check_vector(b, what, "spin", index, body->spin, 0);
  nsdae_bodies_check_turn(b, what, index, body->angle, body->quaternion);
  status = b->error.status;
  if (status < 0) return status;
  nsdae_rigid_body *added = nsdae_list_add(b, &b->body, sizeof *added);
  if (!added) return NSDAE_E_MEMORY;
  *added = *body;
  return index;
}

int nsdae_bodies_add_load(nsdae_bodies *b, int body, const double *point, nsdae_load_fn call,
                          void *user)
{
  int status = nsdae_bodies_open(b, point, "point");
  if (status < 0) return status;
  int index = b->force.load.count;
  const int pair[2] = {NSDAE_GROUND, body};
  if (!call) return nsdae_bodies_refuse(b, NSDAE_E_ARGUMENT, "load", "load", index, "load is NULL");
  status = nsdae_bodies_check_pair(b, "load", index, pair);
  if (status == NSDAE_OK) status = nsdae_bodies_check_vector(b, "load", "point", index, point, 1);
  if (status < 0) return status;
  nsdae_load *load = nsdae_list_add(b, &b->force.load, sizeof *load);
  if (!load) return NSDAE_E_MEMORY;
  *load = (nsdae_load){.body = body, .call = call, .user = user};
  nsdae_bodies_own_point(b, body, point, load->point);
  return index;
}

int nsdae_bodies_set_gravity(nsdae_bodies *b, const double *gravity)
{
  int status = nsdae_bodies_open(b, gravity, "gravity");
  if (status == NSDAE_OK)
    status = nsdae_bodies_check_vector(b, "bodies", "gravity", -1, gravity, 1);
  if (status == NSDAE_OK) memcpy(b->force.gravity, gravity, sizeof b->force.gravity);
  return status;
}

nsdae_pose nsdae_bodies_pose(const nsdae_bodies *b, int body, const double *q, const double *v)
{
  if (body == NSDAE_GROUND) return nsdae_pose_ground();
  return nsdae_pose_of(b->dimension, q + nsdae_body_nq(b) * body,
                       v ? v + nsdae_body_nv(b) * body : NULL);
}

/* Its q and v at the start. */
static void body_start(const nsdae_bodies *b, int body, double *q, double *v)
{
  const nsdae_rigid_body *at = nsdae_body_at(b, body);
  int d = b->dimension;
  memcpy(q, at->position, (size_t)d * sizeof *q);
  memcpy(v, at->velocity, (size_t)d * sizeof *v);
  if (d == 2) {
    q[2] = at->angle;
    v[2] = at->spin[2];
  } else {
    memcpy(q + 3, at->quaternion, sizeof at->quaternion);
    nsdae_unit_quaternion(q + 3);
    memcpy(v + 3, at->spin, sizeof at->spin);
  }
}

nsdae_pose nsdae_bodies_start_pose(const nsdae_bodies *b, int body)
{
  double q[7], v[6];
  if (body == NSDAE_GROUND) return nsdae_pose_ground();
  body_start(b, body, q, v);
  return nsdae_pose_of(b->dimension, q, v);
}

void nsdae_bodies_own_point(const nsdae_bodies *b, int body, const double *x, double *s)
{
  nsdae_pose pose = nsdae_bodies_start_pose(b, body);
  const double from[3] = {x[0] - pose.r[0], x[1] - pose.r[1], x[2] - pose.r[2]};
  nsdae_turn_back(pose.R, from, s);
}

void nsdae_bodies_own_direction(const nsdae_bodies *b, int body, const double *x, double *s)
{
  nsdae_pose pose = nsdae_bodies_start_pose(b, body);
  nsdae_turn_back(pose.R, x, s);
}

void nsdae_bodies_part(const nsdae_bodies *b, const nsdae_velocity_row *row, int i,
                       const nsdae_pose *pose, double part[6])
{
  part[0] = row->linear[i][0];
  part[1] = row->linear[i][1];
  part[2] = b->dimension == 2 ? row->angular[i][2] : row->linear[i][2];
  if (b->dimension == 3) nsdae_turn_back(pose->R, row->angular[i], part + 3);
}

void nsdae_bodies_place(const nsdae_bodies *b, const int body[2], const double *q, const double *v,
                        nsdae_places *at)
{
  for (int i = 0; i < 2; i++) {
    if (at->body[i] == body[i]) continue;
    at->pose[i] = at->body[1] == body[i] ? at->pose[1] : nsdae_bodies_pose(b, body[i], q, v);
    at->body[i] = body[i];
  }
}

void nsdae_bodies_scatter(const nsdae_bodies *b, const nsdae_places *at,
                          const nsdae_velocity_row *row, double scale, double *out, int stride)
{
  for (int i = 0; i < 2; i++) {
    double part[6];
    if (at->body[i] == NSDAE_GROUND) continue;
    nsdae_bodies_part(b, row, i, &at->pose[i], part);
    size_t nv = (size_t)nsdae_body_nv(b), first = (size_t)at->body[i] * nv;
    for (size_t j = 0; j < nv; j++) out[(first + j) * (size_t)stride] += scale * part[j];
  }
}

int nsdae_bodies_get_dims(const nsdae_bodies *b, nsdae_dims *dims)
{
  if (!b || !dims) return NSDAE_E_ARGUMENT;
  const nsdae_dims *own = &b->own.dims;
  int k = nsdae_bodies_fixed(b) + own->k;
  *dims = (nsdae_dims){.nq = b->body.count * nsdae_body_nq(b) + own->nq,
                       .nv = b->body.count * nsdae_body_nv(b) + own->nv,
                       .m = b->constraint.count + own->m,
                       .k = k,
                       .nt = nsdae_bodies_nt(b),
                       .f = b->frictional_joint.count + own->f};
  return NSDAE_OK;
}

int nsdae_bodies_get_start(const nsdae_bodies *b, double *q, double *v)
{
  if (!b || !q || !v) return NSDAE_E_ARGUMENT;
  for (int i = 0; i < b->body.count; i++)
    body_start(b, i, q + i * nsdae_body_nq(b), v + i * nsdae_body_nv(b));
  for (int i = 0; i < b->own.dims.nq; i++) q[b->body.count * nsdae_body_nq(b) + i] = 0;
  for (int i = 0; i < b->own.dims.nv; i++) v[b->body.count * nsdae_body_nv(b) + i] = 0;
  return NSDAE_OK;
}

int nsdae_bodies_locate(const nsdae_bodies *b, const double *q, int body, const double *local,
                        double *point)
{
  if (!b || !q || !local || !point || body < NSDAE_GROUND || body >= b->body.count)
    return NSDAE_E_ARGUMENT;
  nsdae_pose pose = nsdae_bodies_pose(b, body, q, NULL);
  nsdae_turn(pose.R, local, point);
  for (int i = 0; i < 3; i++) point[i] += pose.r[i];
  return NSDAE_OK;
}

int nsdae_bodies_system(nsdae_bodies *b, nsdae_system **system)
{
  nsdae_dims dims;
  if (system) *system = NULL;
  int status = nsdae_bodies_open(b, system, "system");
  if (status < 0) return status;
  if (b->body.count + b->own.dims.nq == 0)
    return nsdae_error_set(&b->error, NSDAE_E_STATE, "nsdae_bodies_system", "body",
                           "there is no body: call nsdae_bodies_add first");
  if (nsdae_bodies_has_list(b) && b->own.dims.k > 0)
    return nsdae_error_set(&b->error, NSDAE_E_STATE, "nsdae_bodies_system", "pair",
                           "the system has a contact list: the user rows have %d fixed contacts; "
                           "list them with their callback contacts",
                           b->own.dims.k);
  if (nsdae_bodies_has_list(b) && (status = nsdae_bodies_check_ids(b)) < 0) return status;
  if (nsdae_bodies_has_list(b) && (status = nsdae_bodies_check_shapes(b)) < 0) return status;
  nsdae_bodies_get_dims(b, &dims);
  status = nsdae_system_create(&dims, system, &b->error);
  if (status < 0) return status;
  nsdae_bodies_sign(b, *system);
  status = nsdae_bodies_set_callbacks(b, *system);
  if (status == NSDAE_OK) status = nsdae_bodies_name_sensors(b, *system);
  if (status == NSDAE_OK) status = nsdae_bodies_show(b, *system);
  if (status < 0) {
    b->error = *nsdae_system_error(*system);
    if (b->error.status == NSDAE_OK)
      nsdae_error_set(&b->error, status, "nsdae_bodies_system", "", "out of memory");
    nsdae_system_destroy(system);
    return status;
  }
  b->life.made = 1;
  return nsdae_bodies_note(b);
}
