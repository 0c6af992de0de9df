/* Springs and dampers, each along a coordinate of two bodies: the distance of two points, an angle,
 * a coordinate of a joint:
 *
 *   F = -stiffness (s - rest) - damping s',     U = stiffness (s - rest)^2 / 2
 *
 * A rotation in space has the cut opposite of rest: there s - rest is -pi or pi, of equal U. */
#include <math.h>

#include "bodies_impl.h"

/* Stiffness and damping of at least 0, and a finite rest. */
static int check_spring(nsdae_bodies *b, const char *what, int index, double stiffness,
                        double damping, double rest)
{
  nsdae_bodies_check_least(b, what, "stiffness", index, stiffness, 0, 0);
  nsdae_bodies_check_least(b, what, "damping", index, damping, 0, 0);
  if (!isfinite(rest))
    nsdae_bodies_refuse(b, NSDAE_E_NONFINITE, what, "rest", index,
                        "rest = %g is not a finite number", rest);
  return b->error.status;
}

/* value := value - rest. The turns of a rotation in space are not counted: rest neither. */
static int set_rest(nsdae_bodies *b, const char *what, int index, nsdae_primitive *value,
                    double rest)
{
  int periodic = nsdae_primitive_is_periodic(value);
  if (periodic && fabs(rest) > nsdae_pi)
    return nsdae_bodies_refuse(b, NSDAE_E_ARGUMENT, what, "rest", index,
                               "rest = %g of a rotation in space must be -pi .. pi, because its "
                               "turns are not counted",
                               rest);
  if (periodic) nsdae_primitive_turn_cut(value, rest);
  value->offset += rest;
  return NSDAE_OK;
}

static int add(nsdae_bodies *b, int owner, int number, nsdae_primitive value, double stiffness,
               double damping)
{
  nsdae_bodies_spring *s = nsdae_list_add(b, &b->force.spring, sizeof *s);
  if (!s) return NSDAE_E_MEMORY;
  *s = (nsdae_bodies_spring){.value = value,
                             .owner = owner,
                             .number = number,
                             .stiffness = stiffness,
                             .damping = damping,
                             .limit = INFINITY};
  return NSDAE_OK;
}

/* The number of the next one of an owner. */
static int next_number(const nsdae_bodies *b, int owner)
{
  int n = 0;
  for (int i = 0; i < b->force.spring.count; i++)
    if (nsdae_spring_at(b, i)->owner == owner) n = nsdae_spring_at(b, i)->number + 1;
  return n;
}

int nsdae_bodies_add_spring(nsdae_bodies *b, const nsdae_spring *spring)
{
  int status = nsdae_bodies_open(b, spring, "spring");
  if (status < 0) return status;
  int index = next_number(b, NSDAE_SPRING);
  const char *what = "spring";
  if (nsdae_bodies_check_pair(b, what, index, spring->body) < 0) return b->error.status;
  nsdae_bodies_check_vector(b, what, "point", index, spring->point, 1);
  nsdae_bodies_check_vector(b, what, "end", index, spring->end, 1);
  nsdae_bodies_check_least(b, what, "rest", index, spring->rest, 0, 0);
  status = check_spring(b, what, index, spring->stiffness, spring->damping, spring->rest);
  if (status < 0) return status;
  const double *x = spring->point, *y = spring->end;
  if (x[0] == y[0] && x[1] == y[1] && x[2] == y[2])
    return nsdae_bodies_refuse(
        b, NSDAE_E_ARGUMENT, what, "end", index,
        "point and end coincide at (%g, %g, %g): the spring has no direction", x[0], x[1], x[2]);
  nsdae_primitive length = nsdae_bodies_distance(b, spring->body, spring->point, spring->end);
  length.offset = spring->rest;
  status = add(b, NSDAE_SPRING, index, length, spring->stiffness, spring->damping);
  return status < 0 ? status : index;
}

/* In space the angle, in a range of a turn about rest, of a direction of body 1 in the frame of
 * body 0. */
int nsdae_bodies_add_torsion(nsdae_bodies *b, const nsdae_torsion *torsion)
{
  int status = nsdae_bodies_open(b, torsion, "torsion");
  if (status < 0) return status;
  int index = next_number(b, NSDAE_TORSION), planar = b->dimension == 2;
  const double z[3] = {0, 0, 1};
  double axis[3], zero[3], quarter[3];
  const char *what = "torsion";
  if (nsdae_bodies_check_pair(b, what, index, torsion->body) < 0) return b->error.status;
  status = check_spring(b, what, index, torsion->stiffness, torsion->damping, torsion->rest);
  if (status < 0) return status;
  const double *given = torsion->axis;
  status = nsdae_bodies_check_vector(b, what, "axis", index, given, 0);
  if (status < 0) return status;
  if (planar && (given[0] != 0 || given[1] != 0))
    return nsdae_bodies_refuse(b, NSDAE_E_ARGUMENT, what, "axis", index,
                               "axis (%g, %g, %g) has no effect in the plane: leave it out",
                               given[0], given[1], given[2]);
  if (!nsdae_unit_vector(planar ? z : given, axis))
    return nsdae_bodies_refuse(b, NSDAE_E_ARGUMENT, what, "axis", index,
                               "axis (%g, %g, %g) has no direction", given[0], given[1], given[2]);
  nsdae_complete_frame(axis, zero, quarter);
  nsdae_primitive angle = {.kind = planar ? NSDAE_PRIMITIVE_TURN : NSDAE_PRIMITIVE_ANGLE,
                           .body = {torsion->body[0], torsion->body[1]},
                           .ratio = 1};
  if (planar)
    angle.offset = nsdae_bodies_start_pose(b, torsion->body[1]).angle -
                   nsdae_bodies_start_pose(b, torsion->body[0]).angle;
  nsdae_bodies_own_direction(b, torsion->body[0], zero, angle.a);
  nsdae_bodies_own_direction(b, torsion->body[0], quarter, angle.b);
  nsdae_bodies_own_direction(b, torsion->body[1], zero, angle.c);
  status = set_rest(b, what, index, &angle, torsion->rest);
  if (status == NSDAE_OK)
    status = add(b, NSDAE_TORSION, index, angle, torsion->stiffness, torsion->damping);
  return status < 0 ? status : index;
}

/* Of a spherical joint dampers along three axes of body 0: -damping (w_1 - w_0). */
int nsdae_bodies_add_joint_spring(nsdae_bodies *b, const nsdae_joint_spring *spring)
{
  int status = nsdae_bodies_open(b, spring, "spring");
  if (status < 0) return status;
  int index = next_number(b, NSDAE_JOINT_SPRING);
  const char *what = "joint spring";
  int spherical = spring->stiffness == 0 && spring->coordinate == 0;
  const nsdae_primitive *of =
      nsdae_bodies_joint_coordinate(b, what, index, spring->joint, spring->coordinate, spherical);
  if (!of) return b->error.status;
  status = check_spring(b, what, index, spring->stiffness, spring->damping, spring->rest);
  if (status < 0) return status;
  nsdae_primitive value = *of;
  status = set_rest(b, what, index, &value, spring->rest);
  for (int i = 0; i < (value.kind == NSDAE_PRIMITIVE_SPIN ? 3 : 1) && status == NSDAE_OK; i++) {
    if (value.kind == NSDAE_PRIMITIVE_SPIN)
      for (int j = 0; j < 3; j++) value.a[j] = i == j;
    status = add(b, NSDAE_JOINT_SPRING, index, value, spring->stiffness, spring->damping);
  }
  return status < 0 ? status : index;
}
