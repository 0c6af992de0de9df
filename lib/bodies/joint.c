/* Joints: a table of their kinds, each made of groups of rows and of coordinates; all from points
 * and axes in space at the start. */
#include <math.h>
#include <stddef.h>

#include "bodies_impl.h"

/* ---- kinds of joints, in a frame a, b, c with a along the axis; i in body i */

enum {
  POINT = 1,   /* a common point: along each axis of space */
  LINE = 2,    /* the point of body 1 is on the line along a */
  TILT = 4,    /* spatial: the axes a keep together: a_1 at right angles to b_0 and c_0 */
  TURNING = 8, /* no rotation about a (planar: at all) */
  CROSS = 16,  /* a_0 at right angles to b_1 */
  LENGTH = 32, /* the distance of point and end */
  RATIO = 64,  /* planar: theta_1 - ratio theta_0 */
  THREAD = 128 /* displacement - pitch / (2 pi) rotation */
};

enum { PLANAR = 1, SPATIAL = 2, BOTH = 3 };

/* Coordinates. */
enum { NONE, DISPLACEMENT, ROTATION, CROSS_ROTATION, ANY_ROTATION };

static const struct {
  const char *name;
  int rows;
  int exists, axis; /* in PLANAR, SPATIAL: it exists; it needs an axis */
  int coordinate[NSDAE_COORDINATES];
} kinds[] = {
    [NSDAE_JOINT_REVOLUTE] = {"revolute", POINT | TILT, BOTH, SPATIAL, {ROTATION}},
    [NSDAE_JOINT_PRISMATIC] = {"prismatic", LINE | TILT | TURNING, BOTH, BOTH, {DISPLACEMENT}},
    [NSDAE_JOINT_WELD] = {"weld", POINT | TILT | TURNING, BOTH, 0, {NONE}},
    [NSDAE_JOINT_DISTANCE] = {"distance", LENGTH, BOTH, 0, {NONE}},
    [NSDAE_JOINT_SLOT] = {"slot", LINE, PLANAR, PLANAR, {DISPLACEMENT, ROTATION}},
    [NSDAE_JOINT_GEAR] = {"gear", RATIO, PLANAR, 0, {NONE}},
    [NSDAE_JOINT_SPHERICAL] = {"spherical", POINT, SPATIAL, 0, {ANY_ROTATION}},
    [NSDAE_JOINT_CYLINDRICAL] =
        {"cylindrical", LINE | TILT, SPATIAL, SPATIAL, {DISPLACEMENT, ROTATION}},
    [NSDAE_JOINT_UNIVERSAL] =
        {"universal", POINT | CROSS, SPATIAL, SPATIAL, {ROTATION, CROSS_ROTATION}},
    [NSDAE_JOINT_SCREW] =
        {"screw", LINE | TILT | THREAD, SPATIAL, SPATIAL, {DISPLACEMENT, ROTATION}},
};

/* A distance and a gear have a drive of their row, the others of coordinate 0. */
static int is_driven(int kind)
{
  int first = kinds[kind].coordinate[0];
  return (kinds[kind].rows & (LENGTH | RATIO)) || (first != NONE && first != ANY_ROTATION);
}

const char *nsdae_joint_name(int kind)
{
  return kinds[kind].name;
}

/* ---- primitives of a joint */

/* A joint being taken apart, with its frame in space. */
typedef struct assembly {
  nsdae_bodies *bodies;
  const nsdae_joint *joint;
  double frame[3][3];
} assembly;

static nsdae_primitive primitive(const assembly *s, nsdae_primitive_kind kind)
{
  nsdae_primitive p = {.kind = kind, .ratio = 1};
  for (int i = 0; i < 2; i++) {
    p.body[i] = s->joint->body[i];
    nsdae_bodies_own_point(s->bodies, p.body[i], s->joint->point, p.point[i]);
  }
  return p;
}

/* The place of the point of body 1 along axis i of the frame in body 0. */
static nsdae_primitive along(const assembly *s, int i)
{
  nsdae_primitive p = primitive(s, NSDAE_PRIMITIVE_ALONG);
  nsdae_bodies_own_direction(s->bodies, p.body[0], s->frame[i], p.a);
  return p;
}

/* The cosine of axis i of the frame in body 0 and axis j of that in body 1. */
static nsdae_primitive square(const assembly *s, int i, int j)
{
  nsdae_primitive p = primitive(s, NSDAE_PRIMITIVE_SQUARE);
  nsdae_bodies_own_direction(s->bodies, p.body[0], s->frame[i], p.a);
  nsdae_bodies_own_direction(s->bodies, p.body[1], s->frame[j], p.c);
  return p;
}

/* theta_1 - ratio theta_0 since the start */
static nsdae_primitive turn(const assembly *s, double ratio)
{
  nsdae_primitive p = primitive(s, NSDAE_PRIMITIVE_TURN);
  p.ratio = ratio;
  p.offset = nsdae_bodies_start_pose(s->bodies, p.body[1]).angle -
             ratio * nsdae_bodies_start_pose(s->bodies, p.body[0]).angle;
  return p;
}

/* The angle of body 1 about a_0. About b_1 of a universal joint it is seen from body 1: there a_0
 * turns backwards, about a x c = -b. */
static nsdae_primitive rotation(const assembly *s, int about_cross)
{
  if (s->bodies->dimension == 2) return turn(s, 1);
  nsdae_primitive p = primitive(s, NSDAE_PRIMITIVE_ANGLE);
  const double *hand = s->frame[about_cross ? 0 : 1];
  for (int i = 0; i < 2; i++) p.body[i] = s->joint->body[about_cross ? 1 - i : i];
  nsdae_bodies_own_direction(s->bodies, p.body[0], hand, p.a);
  nsdae_bodies_own_direction(s->bodies, p.body[0], s->frame[2], p.b);
  nsdae_bodies_own_direction(s->bodies, p.body[1], hand, p.c);
  return p;
}

/* ---- rows of a joint */

static nsdae_bodies_constraint *add_row(const assembly *s, nsdae_primitive value)
{
  nsdae_bodies *b = s->bodies;
  nsdae_bodies_constraint *c = nsdae_list_add(b, &b->constraint, sizeof *c);
  if (c) *c = (nsdae_bodies_constraint){.value = value, .joint = b->joint.count, .master = -1};
  return c;
}

static void set_drive(const assembly *s, nsdae_bodies_constraint *c)
{
  if (!c || !s->joint->drive) return;
  c->drive = s->joint->drive;
  c->user = s->joint->user;
  if (nsdae_primitive_is_periodic(&c->value)) c->period = 2 * nsdae_pi;
}

nsdae_primitive nsdae_bodies_distance(const nsdae_bodies *b, const int body[2], const double *point,
                                      const double *end)
{
  nsdae_primitive p = {.kind = NSDAE_PRIMITIVE_DISTANCE, .body = {body[0], body[1]}};
  nsdae_bodies_own_point(b, body[0], point, p.point[0]);
  nsdae_bodies_own_point(b, body[1], end, p.point[1]);
  return p;
}

static void add_length(const assembly *s)
{
  const nsdae_joint *j = s->joint;
  double d[3] = {j->end[0] - j->point[0], j->end[1] - j->point[1], j->end[2] - j->point[2]};
  nsdae_bodies_constraint *c =
      add_row(s, nsdae_bodies_distance(s->bodies, j->body, j->point, j->end));
  if (c) c->p[0] = sqrt(nsdae_dot3(d, d));
  set_drive(s, c);
}

/* displacement = p_1 rotation, p_1 = pitch / (2 pi); a turn is a pitch */
static void add_thread(const assembly *s)
{
  nsdae_bodies_constraint *c = add_row(s, along(s, 0));
  if (!c) return;
  c->master = NSDAE_COORDINATES * s->bodies->joint.count + 1;
  c->p[1] = s->joint->ratio / (2 * nsdae_pi);
  c->period = fabs(s->joint->ratio);
}

static void add_rows(const assembly *s, int rows)
{
  int d = s->bodies->dimension;
  for (int i = 0; i < d && (rows & POINT); i++) {
    nsdae_primitive p = primitive(s, NSDAE_PRIMITIVE_ALONG);
    p.in_space = 1;
    p.a[i] = 1;
    add_row(s, p);
  }
  for (int i = 1; i < d && (rows & LINE); i++) add_row(s, along(s, i));
  for (int i = 1; i < d && d == 3 && (rows & TILT); i++) add_row(s, square(s, i, 0));
  if (rows & TURNING) add_row(s, d == 2 ? turn(s, 1) : square(s, 2, 1));
  if (rows & CROSS) add_row(s, square(s, 0, 1));
  if (rows & LENGTH) add_length(s);
  if (rows & RATIO) set_drive(s, add_row(s, turn(s, s->joint->ratio)));
  if (rows & THREAD) add_thread(s);
}

static void add_joint(const assembly *s)
{
  nsdae_bodies *b = s->bodies;
  const nsdae_joint *j = s->joint;
  const int *of = kinds[j->kind].coordinate;
  nsdae_bodies_joint joint = {
      .kind = j->kind, .body = {j->body[0], j->body[1]}, .collide_connected = j->collide_connected};
  for (int i = 0; i < NSDAE_COORDINATES && of[i] != NONE; i++, joint.coordinates++)
    joint.coordinate[i] = of[i] == DISPLACEMENT   ? along(s, 0)
                          : of[i] == ANY_ROTATION ? primitive(s, NSDAE_PRIMITIVE_SPIN)
                                                  : rotation(s, of[i] == CROSS_ROTATION);
  int first = b->constraint.count;
  add_rows(s, kinds[j->kind].rows);
  if (joint.coordinates > 0 && j->drive) set_drive(s, add_row(s, joint.coordinate[0]));
  if (j->mu > 0) { /* a slot or a pin: the velocity of sliding is the rate of its coordinate */
    nsdae_bodies_frictional_joint *f = nsdae_list_add(b, &b->frictional_joint, sizeof *f);
    if (f)
      *f = (nsdae_bodies_frictional_joint){.constraint = first,
                                           .position = -1,
                                           .joint = b->joint.count,
                                           .motor = -1,
                                           .along = joint.coordinate[0],
                                           .mu = j->kind == NSDAE_JOINT_SLOT ? j->mu : 0,
                                           .circle = j->mu * j->radius};
  }
  nsdae_bodies_joint *added = nsdae_list_add(b, &b->joint, sizeof *added);
  if (added) *added = joint;
}

/* ---- frame and checks */

/* The frame in space: a along the axis (by default z), b along cross for UNIVERSAL; in the
 * plane b is a turned to the left. */
static int set_frame(assembly *s, int index)
{
  const nsdae_joint *j = s->joint;
  const double z[3] = {0, 0, 1}, x[3] = {1, 0, 0};
  int planar = s->bodies->dimension == 2;
  int needs = kinds[j->kind].axis & (planar ? PLANAR : SPATIAL);
  if (!nsdae_unit_vector(needs ? j->axis : planar ? x : z, s->frame[0]))
    return nsdae_bodies_refuse(s->bodies, NSDAE_E_ARGUMENT, "joint", "axis", index,
                               "a %s joint needs an axis: (%g, %g, %g) has no direction",
                               kinds[j->kind].name, j->axis[0], j->axis[1], j->axis[2]);
  nsdae_complete_frame(s->frame[0], s->frame[1], s->frame[2]);
  if (planar) {
    const double left[3] = {-s->frame[0][1], s->frame[0][0], 0};
    for (int i = 0; i < 3; i++) s->frame[1][i] = left[i];
  }
  if (j->kind != NSDAE_JOINT_UNIVERSAL) return NSDAE_OK;
  double cosine =
      nsdae_unit_vector(j->cross, s->frame[1]) ? nsdae_dot3(s->frame[0], s->frame[1]) : 1;
  nsdae_cross3(s->frame[0], s->frame[1], s->frame[2]);
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
  if (!(kinds[j->kind].exists & (b->dimension == 2 ? PLANAR : SPATIAL)))
    return nsdae_bodies_refuse(b, NSDAE_E_ARGUMENT, "joint", "kind", index,
                               "a %s joint does not exist in %d dimensions", name, b->dimension);
  if (j->drive && !is_driven(j->kind))
    return nsdae_bodies_refuse(b, NSDAE_E_ARGUMENT, "joint", "drive", index,
                               "a %s joint cannot be driven", name);
  int pin = j->kind == NSDAE_JOINT_REVOLUTE;
  if (j->mu != 0 && j->kind != NSDAE_JOINT_SLOT && !pin)
    return nsdae_bodies_refuse(b, NSDAE_E_ARGUMENT, "joint", "mu", index,
                               "mu = %g, but a %s joint supports no friction by its load: it must "
                               "be 0 (slots and revolute joints support it)",
                               j->mu, name);
  if (!(pin && j->mu > 0 ? j->radius > 0 && isfinite(j->radius) : pin || j->radius == 0))
    return nsdae_bodies_refuse(
        b, NSDAE_E_ARGUMENT, "joint", "radius", index,
        pin ? "radius = %g of a pin with friction must be above 0, and finite"
            : "radius = %g is of revolute joints: it must be 0",
        j->radius);
  if (j->mu > 0 && j->drive)
    return nsdae_bodies_refuse(b, NSDAE_E_ARGUMENT, "joint", "mu", index,
                               "mu = %g of a joint with a drive: it must be 0", j->mu);
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
  nsdae_bodies_check_vector(b, what, "axis", index, j->axis, kinds[j->kind].axis & PLANAR);
  nsdae_bodies_check_vector(b, what, "cross", index, j->cross, 1);
  nsdae_bodies_check_least(b, what, "mu", index, j->mu, 0, 0);
  if ((kinds[j->kind].rows & (RATIO | THREAD)) && !(isfinite(j->ratio) && j->ratio != 0))
    nsdae_bodies_refuse(b, NSDAE_E_ARGUMENT, what, "ratio", index,
                        "ratio = %g of a %s is not a finite number other than 0", j->ratio,
                        kinds[j->kind].name);
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
  add_joint(&s);
  return b->error.status < 0 ? b->error.status : index;
}

const nsdae_primitive *nsdae_bodies_joint_coordinate(nsdae_bodies *b, const char *what, int index,
                                                     int joint, int coordinate, int any)
{
  const nsdae_bodies_joint *j =
      joint >= 0 && joint < b->joint.count ? nsdae_joint_at(b, joint) : NULL;
  if (!j) {
    nsdae_bodies_refuse(b, NSDAE_E_ARGUMENT, what, "joint", index,
                        "joint = %d is not a joint: there are %d, from 0", joint, b->joint.count);
    return NULL;
  }
  int exists = coordinate >= 0 && coordinate < j->coordinates;
  if (exists && (any || j->coordinate[coordinate].kind != NSDAE_PRIMITIVE_SPIN))
    return &j->coordinate[coordinate];
  if (exists)
    nsdae_bodies_refuse(b, NSDAE_E_ARGUMENT, what, "coordinate", index,
                        "the rotation of a %s joint (joint %d) is not a coordinate: it can have "
                        "damping only",
                        kinds[j->kind].name, joint);
  else
    nsdae_bodies_refuse(b, NSDAE_E_ARGUMENT, what, "coordinate", index,
                        "coordinate = %d of joint %d: a %s joint has %d coordinate(s), from 0",
                        coordinate, joint, kinds[j->kind].name, j->coordinates);
  return NULL;
}
