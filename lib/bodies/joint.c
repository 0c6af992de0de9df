/* Joints as elements, springs and torsions as what a force needs; all from points and axes in space
 * at the start. */
#include <math.h>
#include <stddef.h>

#include "bodies_impl.h"

/* A joint being taken apart: its frame a, b, c in space, a along the axis. */
typedef struct assembly {
  nsdae_bodies *bodies;
  const nsdae_joint *joint;
  double frame[3][3];
} assembly;

/* ---- constraints of a joint */

static nsdae_primitive *add_element(const assembly *s, nsdae_primitive_kind kind)
{
  nsdae_bodies *b = s->bodies;
  nsdae_primitive *e = nsdae_list_add(b, &b->element, sizeof *e);
  if (!e) return NULL;
  e->kind = kind;
  e->joint = b->joint.count;
  e->joint_kind = s->joint->kind;
  for (int i = 0; i < 2; i++) {
    e->body[i] = s->joint->body[i];
    nsdae_bodies_own_point(b, e->body[i], s->joint->point, e->point[i]);
  }
  return e;
}

static void set_drive(const assembly *s, nsdae_primitive *e)
{
  if (!e) return;
  e->drive = s->joint->drive;
  e->user = s->joint->user;
}

/* Both points keep together: along each axis of space. */
static void coincide(const assembly *s)
{
  for (int i = 0; i < s->bodies->dimension; i++) {
    nsdae_primitive *e = add_element(s, NSDAE_PRIMITIVE_ALONG);
    if (!e) return;
    e->in_space = 1;
    e->a[i] = 1;
  }
}

/* The point of body 1 keeps its place along axis i of the frame in body 0. */
static nsdae_primitive *keep_along(const assembly *s, int i)
{
  nsdae_primitive *e = add_element(s, NSDAE_PRIMITIVE_ALONG);
  if (e) nsdae_bodies_own_direction(s->bodies, e->body[0], s->frame[i], e->a);
  return e;
}

/* Axis i of the frame in body 0 stays at right angles to axis j of that in body 1. Driven, it is
 * turned about the third axis by f. */
static nsdae_primitive *keep_square(const assembly *s, int i, int j)
{
  nsdae_primitive *e = add_element(s, NSDAE_PRIMITIVE_BETWEEN);
  if (!e) return NULL;
  nsdae_bodies_own_direction(s->bodies, e->body[0], s->frame[j], e->a);
  nsdae_bodies_own_direction(s->bodies, e->body[0], s->frame[i], e->b);
  nsdae_bodies_own_direction(s->bodies, e->body[1], s->frame[j], e->c);
  return e;
}

/* theta_1 - theta_0 stays as it is, or what it is driven to. */
static nsdae_primitive *keep_angle(const assembly *s, double ratio)
{
  nsdae_primitive *e = add_element(s, NSDAE_PRIMITIVE_TURN);
  if (!e) return NULL;
  nsdae_pose pose0 = nsdae_bodies_start_pose(s->bodies, e->body[0]);
  nsdae_pose pose1 = nsdae_bodies_start_pose(s->bodies, e->body[1]);
  e->ratio = ratio;
  e->offset = pose1.angle - ratio * pose0.angle;
  return e;
}

static void no_turning(const assembly *s)
{
  if (s->bodies->dimension == 2) {
    keep_angle(s, 1);
    return;
  }
  keep_square(s, 1, 0);
  keep_square(s, 2, 0);
  keep_square(s, 2, 1);
}

/* ---- kinds of joints */

static void revolute(const assembly *s)
{
  coincide(s);
  if (s->bodies->dimension == 3) {
    keep_square(s, 1, 0);
    keep_square(s, 2, 0);
  }
  if (s->joint->drive)
    set_drive(s, s->bodies->dimension == 2 ? keep_angle(s, 1) : keep_square(s, 2, 1));
}

static void prismatic(const assembly *s)
{
  for (int i = 1; i < s->bodies->dimension; i++) keep_along(s, i);
  no_turning(s);
  if (s->joint->drive) set_drive(s, keep_along(s, 0));
}

static void weld(const assembly *s)
{
  coincide(s);
  no_turning(s);
}

static void distance(const assembly *s)
{
  const nsdae_joint *j = s->joint;
  nsdae_primitive *e = add_element(s, NSDAE_PRIMITIVE_DISTANCE);
  if (!e) return;
  nsdae_bodies_own_point(s->bodies, j->body[1], j->end, e->point[1]);
  double d[3] = {j->end[0] - j->point[0], j->end[1] - j->point[1], j->end[2] - j->point[2]};
  e->rest = sqrt(nsdae_dot3(d, d));
  set_drive(s, e);
}

/* The slide's velocity is the rate of the coordinate along the slot. */
static void slot(const assembly *s)
{
  nsdae_bodies *b = s->bodies;
  int constraint = b->element.count;
  keep_along(s, 1);
  if (s->joint->drive) set_drive(s, keep_along(s, 0));
  if (!(s->joint->mu > 0)) return;
  nsdae_primitive *along = keep_along(s, 0);
  nsdae_bodies_frictional_joint *frictional_joint =
      nsdae_list_add(b, &b->frictional_joint, sizeof *frictional_joint);
  if (!along || !frictional_joint) return;
  *frictional_joint = (nsdae_bodies_frictional_joint){constraint, *along, s->joint->mu};
  b->element.count--; /* it was made there, but is no constraint */
}

static void gear(const assembly *s)
{
  set_drive(s, keep_angle(s, s->joint->ratio));
}

static void cylindrical(const assembly *s)
{
  keep_along(s, 1);
  keep_along(s, 2);
  keep_square(s, 1, 0);
  keep_square(s, 2, 0);
  if (s->joint->drive) set_drive(s, keep_along(s, 0));
}

static void universal(const assembly *s)
{
  coincide(s);
  keep_square(s, 0, 1);
}

static const struct {
  const char *name;
  void (*assemble)(const assembly *);
  int planar, spatial, axis, driven;
} kinds[] = {
    [NSDAE_JOINT_REVOLUTE] = {"revolute", revolute, 1, 1, 0, 1},
    [NSDAE_JOINT_PRISMATIC] = {"prismatic", prismatic, 1, 1, 1, 1},
    [NSDAE_JOINT_WELD] = {"weld", weld, 1, 1, 0, 0},
    [NSDAE_JOINT_DISTANCE] = {"distance", distance, 1, 1, 0, 1},
    [NSDAE_JOINT_SLOT] = {"slot", slot, 1, 0, 1, 1},
    [NSDAE_JOINT_GEAR] = {"gear", gear, 1, 0, 0, 1},
    [NSDAE_JOINT_SPHERICAL] = {"spherical", coincide, 0, 1, 0, 0},
    [NSDAE_JOINT_CYLINDRICAL] = {"cylindrical", cylindrical, 0, 1, 1, 1},
    [NSDAE_JOINT_UNIVERSAL] = {"universal", universal, 0, 1, 1, 0},
};

const char *nsdae_joint_name(int kind)
{
  return kinds[kind].name;
}

/* ---- frame and checks */

/* The unit vector along x; 0 where x has no direction. */
static int unit(const double *x, double *a)
{
  double length = sqrt(nsdae_dot3(x, x));
  for (int i = 0; i < 3; i++) a[i] = x[i] / length;
  return length > 0 && isfinite(length);
}

/* The frame in space: a along the axis (by default z), b along cross for UNIVERSAL; in the
 * plane b is a turned to the left. */
static int set_frame(assembly *s, int index)
{
  const nsdae_joint *j = s->joint;
  const double z[3] = {0, 0, 1}, x[3] = {1, 0, 0};
  int planar = s->bodies->dimension == 2;
  int needs = kinds[j->kind].axis || (!planar && j->kind == NSDAE_JOINT_REVOLUTE);
  if (!unit(needs ? j->axis : planar ? x : z, s->frame[0]))
    return nsdae_bodies_refuse(s->bodies, NSDAE_E_ARGUMENT, "joint", "axis", index,
                               "a %s joint needs an axis: (%g, %g, %g) has no direction",
                               kinds[j->kind].name, j->axis[0], j->axis[1], j->axis[2]);
  nsdae_complete_frame(s->frame[0], s->frame[1], s->frame[2]);
  if (planar) {
    const double left[3] = {-s->frame[0][1], s->frame[0][0], 0};
    for (int i = 0; i < 3; i++) s->frame[1][i] = left[i];
  }
  if (j->kind != NSDAE_JOINT_UNIVERSAL) return NSDAE_OK;
  double cosine = unit(j->cross, s->frame[1]) ? nsdae_dot3(s->frame[0], s->frame[1]) : 1;
  if (fabs(cosine) <= 1e-12) return NSDAE_OK;
  return nsdae_bodies_refuse(s->bodies, NSDAE_E_ARGUMENT, "joint", "cross", index,
                             "cross and axis of a universal joint must be perpendicular: their "
                             "cosine is %g and must be within 1e-12 of 0",
                             cosine);
}

/* Whether the kind exists in this dimension, with this drive and friction. */
static int check_kind(nsdae_bodies *b, int index, const nsdae_joint *j)
{
  int known = j->kind >= 0 && j->kind < (int)(sizeof kinds / sizeof *kinds);
  if (!known)
    return nsdae_bodies_refuse(b, NSDAE_E_ARGUMENT, "joint", "kind", index,
                               "kind = %d is not one of enum nsdae_joint_kind", j->kind);
  const char *name = kinds[j->kind].name;
  if (b->dimension == 2 ? !kinds[j->kind].planar : !kinds[j->kind].spatial)
    return nsdae_bodies_refuse(b, NSDAE_E_ARGUMENT, "joint", "kind", index,
                               "a %s joint does not exist in %d dimensions", name, b->dimension);
  if (j->drive && !kinds[j->kind].driven)
    return nsdae_bodies_refuse(b, NSDAE_E_ARGUMENT, "joint", "drive", index,
                               "a %s joint cannot be driven", name);
  if (j->mu != 0 && j->kind != NSDAE_JOINT_SLOT)
    return nsdae_bodies_refuse(
        b, NSDAE_E_ARGUMENT, "joint", "mu", index,
        "mu = %g, but a %s joint supports no friction: it must be 0 (a slot supports it)", j->mu,
        name);
  if (j->mu > 0 && j->drive)
    return nsdae_bodies_refuse(b, NSDAE_E_ARGUMENT, "joint", "mu", index,
                               "mu = %g of a slot with a drive: it must be 0", j->mu);
  return NSDAE_OK;
}

/* All fields of a joint; the first failure is recorded. */
static int check_joint(nsdae_bodies *b, int index, const nsdae_joint *j)
{
  const char *what = "joint";
  if (check_kind(b, index, j) < 0 || nsdae_bodies_check_pair(b, what, index, j->body) < 0)
    return b->error.status;
  nsdae_bodies_check_vector(b, what, "point", index, j->point, 1);
  nsdae_bodies_check_vector(b, what, "end", index, j->end, 1);
  nsdae_bodies_check_vector(b, what, "axis", index, j->axis, kinds[j->kind].axis);
  nsdae_bodies_check_vector(b, what, "cross", index, j->cross, 1);
  nsdae_bodies_check_least(b, what, "mu", index, j->mu, 0, 0);
  if (j->kind == NSDAE_JOINT_GEAR && !(isfinite(j->ratio) && j->ratio != 0))
    nsdae_bodies_refuse(b, NSDAE_E_ARGUMENT, what, "ratio", index,
                        "ratio = %g of a gear is not a finite number other than 0", j->ratio);
  double d[3] = {j->end[0] - j->point[0], j->end[1] - j->point[1], j->end[2] - j->point[2]};
  if (j->kind == NSDAE_JOINT_DISTANCE && !(nsdae_dot3(d, d) > 0))
    nsdae_bodies_refuse(b, NSDAE_E_ARGUMENT, what, "end", index,
                        "point and end of a distance joint coincide: it has no direction");
  return b->error.status;
}

int nsdae_bodies_add_joint(nsdae_bodies *b, const nsdae_joint *joint)
{
  int status = nsdae_bodies_open(b, joint, "joint");
  if (status < 0) return status;
  int index = b->joint.count;
  assembly s = {.bodies = b, .joint = joint};
  status = check_joint(b, index, joint);
  if (status == NSDAE_OK) status = set_frame(&s, index);
  if (status < 0) return status;
  kinds[joint->kind].assemble(&s);
  nsdae_bodies_joint *added = nsdae_list_add(b, &b->joint, sizeof *added);
  if (added)
    *added = (nsdae_bodies_joint){{joint->body[0], joint->body[1]}, joint->collide_connected};
  return b->error.status < 0 ? b->error.status : index;
}

/* ---- springs */

int nsdae_bodies_add_spring(nsdae_bodies *b, const nsdae_spring *spring)
{
  int status = nsdae_bodies_open(b, spring, "spring");
  if (status < 0) return status;
  int index = b->spring.count;
  const char *what = "spring";
  if (nsdae_bodies_check_pair(b, what, index, spring->body) < 0) return b->error.status;
  nsdae_bodies_check_vector(b, what, "point", index, spring->point, 1);
  nsdae_bodies_check_vector(b, what, "end", index, spring->end, 1);
  nsdae_bodies_check_least(b, what, "stiffness", index, spring->stiffness, 0, 0);
  nsdae_bodies_check_least(b, what, "damping", index, spring->damping, 0, 0);
  nsdae_bodies_check_least(b, what, "rest", index, spring->rest, 0, 0);
  if (b->error.status < 0) return b->error.status;
  nsdae_bodies_spring *s = nsdae_list_add(b, &b->spring, sizeof *s);
  if (!s) return NSDAE_E_MEMORY;
  s->stiffness = spring->stiffness;
  s->damping = spring->damping;
  s->length.kind = NSDAE_PRIMITIVE_DISTANCE;
  s->length.rest = spring->rest;
  for (int i = 0; i < 2; i++) {
    s->length.body[i] = spring->body[i];
    nsdae_bodies_own_point(b, spring->body[i], i ? spring->end : spring->point, s->length.point[i]);
  }
  return index;
}

int nsdae_bodies_add_torsion(nsdae_bodies *b, const nsdae_torsion *torsion)
{
  int status = nsdae_bodies_open(b, torsion, "torsion");
  if (status < 0) return status;
  int index = b->torsion.count;
  const double z[3] = {0, 0, 1};
  double axis[3], zero[3], third[3];
  const char *what = "torsion";
  if (nsdae_bodies_check_pair(b, what, index, torsion->body) < 0) return b->error.status;
  nsdae_bodies_check_least(b, what, "stiffness", index, torsion->stiffness, 0, 0);
  nsdae_bodies_check_least(b, what, "damping", index, torsion->damping, 0, 0);
  if (!isfinite(torsion->rest))
    nsdae_bodies_refuse(b, NSDAE_E_NONFINITE, what, "rest", index,
                        "rest = %g is not a finite number", torsion->rest);
  if (b->error.status < 0) return b->error.status;
  if (!unit(b->dimension == 2 ? z : torsion->axis, axis))
    return nsdae_bodies_refuse(b, NSDAE_E_ARGUMENT, "torsion", "axis", index,
                               "axis (%g, %g, %g) has no direction", torsion->axis[0],
                               torsion->axis[1], torsion->axis[2]);
  nsdae_bodies_torsion *s = nsdae_list_add(b, &b->torsion, sizeof *s);
  if (!s) return NSDAE_E_MEMORY;
  nsdae_complete_frame(axis, zero, third);
  nsdae_pose pose0 = nsdae_bodies_start_pose(b, torsion->body[0]);
  nsdae_pose pose1 = nsdae_bodies_start_pose(b, torsion->body[1]);
  *s = (nsdae_bodies_torsion){.body = {torsion->body[0], torsion->body[1]},
                              .stiffness = torsion->stiffness,
                              .damping = torsion->damping,
                              .rest = torsion->rest,
                              .offset = pose1.angle - pose0.angle};
  nsdae_turn_back(pose0.R, axis, s->axis);
  nsdae_turn_back(pose0.R, zero, s->zero);
  nsdae_turn_back(pose1.R, zero, s->hand);
  return index;
}
