/* Likely mistakes of a model that is made all the same: the warning of nsdae_bodies_system.
 *
 * An angle above a turn that is a multiple of 1/2 is taken for degrees: in radians such numbers
 * are rare. */
#include <math.h>
#include <stdio.h>

#include "bodies_impl.h"
#include "errors.h"
#include "mesh.h"
#include "words.h"

static int in_degrees(double angle)
{
  return fabs(angle) > 2 * nsdae_pi && isfinite(angle) && 2 * angle == rint(2 * angle);
}

static int note_angle(nsdae_bodies *b, const char *what, int i, const char *argument, double angle)
{
  nsdae_error_set(
      &b->error, NSDAE_WARN_MODEL, "nsdae_bodies_system", argument,
      "%s %d: %s = %g rad is %.3g turns: angles are in radians, and %g degrees are %.6g", what, i,
      argument, angle, angle / (2 * nsdae_pi), angle, angle * nsdae_pi / 180);
  return nsdae_error_at(&b->error, NSDAE_WARN_MODEL, i, NAN);
}

/* `body 0 "crank"` */
enum { CALLED = 16 + NSDAE_WORD };
static const char *called(const nsdae_bodies *b, int i, char text[CALLED])
{
  const char *name = nsdae_bodies_name_of(b, NSDAE_NAMED_BODY, i);
  snprintf(text, CALLED, "body %d%s%s%s", i, name ? " \"" : "", name ? name : "", name ? "\"" : "");
  return text;
}

static int note_numbers(nsdae_bodies *b, int i, const char *argument, const double *x, int count,
                        const char *why)
{
  char numbers[4 * 16], name[CALLED];
  for (int j = 0, used = 0; j < count; j++)
    used += snprintf(numbers + used, sizeof numbers - (size_t)used, j ? ", %.6g" : "%.6g", x[j]);
  nsdae_error_set(&b->error, NSDAE_WARN_MODEL, "nsdae_bodies_system", argument, "%s: %s %s%s%s %s",
                  called(b, i, name), argument, count > 1 ? "(" : "= ", numbers,
                  count > 1 ? ")" : "", why);
  return nsdae_error_at(&b->error, NSDAE_WARN_MODEL, i, NAN);
}

/* ---- numbers */

/* Numbers of the other dimension are not used. */
static int note_body(nsdae_bodies *b, int i)
{
  const nsdae_rigid_body *body = nsdae_body_at(b, i);
  const double *J = body->inertia, *p = body->quaternion;
  int planar = b->dimension == 2;
  double length = hypot(hypot(p[0], p[1]), hypot(p[2], p[3]));
  if (planar && in_degrees(body->angle)) return note_angle(b, "body", i, "angle", body->angle);
  if (planar && (J[0] != 0 || J[1] != 0))
    return note_numbers(b, i, "inertia", J, 3,
                        "has three numbers: the plane uses inertia[2] alone");
  if (!planar && length != 0 && fabs(length - 1) > 0.5)
    return note_numbers(
        b, i, "quaternion", p, 4,
        "has a length beyond 0.5 .. 1.5: its four entries are w, x, y, z, of length 1");
  if (!planar && length != 0 && fabs(p[3]) > 0.99 * length)
    return note_numbers(
        b, i, "quaternion", p, 4,
        "is half a turn about z: its entries are w, x, y, z, and (1, 0, 0, 0) is no "
        "rotation");
  return NSDAE_OK;
}

/* The mass of a body lies within its solids, at most a distance r from its centre: J <= m r^2. Some
 * solids are only the part of a body that touches, so that units alone are noted: inertia in
 * kg mm^2 or solids in mm are a factor of 1e3 in the radius of gyration. */
static int note_inertia(nsdae_bodies *b, int i)
{
  const double many = 100; /* between 1 and 1e3, in equal parts of their ratio rounded up */
  const nsdae_rigid_body *body = nsdae_body_at(b, i);
  double J = body->inertia[2], farthest = 0;
  char name[CALLED];
  for (int j = 0; j < 2 && b->dimension == 3; j++) J = fmax(J, body->inertia[j]);
  for (int j = 0; j < b->solid.count; j++) {
    const nsdae_solid_of *s = nsdae_solid_at(b, j);
    if (s->body == i) farthest = fmax(farthest, sqrt(nsdae_dot3(s->origin, s->origin)) + s->size);
  }
  double gyration = sqrt(J / body->mass);
  if (farthest == 0 || gyration <= many * farthest) return NSDAE_OK;
  nsdae_error_set(
      &b->error, NSDAE_WARN_MODEL, "nsdae_bodies_system", "inertia",
      "%s: the inertia %g kg m^2 of the mass %g kg has a radius of gyration of %.3g m, and "
      "its solids end %.3g m from its centre: use kg, m and kg m^2 for all",
      called(b, i, name), J, body->mass, gyration, farthest);
  return nsdae_error_at(&b->error, NSDAE_WARN_MODEL, i, NAN);
}

static int note_gravity(nsdae_bodies *b)
{
  const double *g = b->force.gravity;
  if (b->dimension == 2 || g[0] != 0 || g[1] == 0 || g[2] != 0) return NSDAE_OK;
  return nsdae_error_set(&b->error, NSDAE_WARN_MODEL, "nsdae_bodies_system", "gravity",
                         "gravity (0, %g, 0) of a model in space is along y: z is upwards there",
                         g[1]);
}

/* nsdae_maker.idle */
int nsdae_bodies_are_idle(const void *of)
{
  const nsdae_bodies *b = of;
  const double *g = b->force.gravity;
  int acts = b->force.load.count + b->force.spring.count + b->frictional_joint.count +
             b->own.dims.nq + b->own.dims.m + b->own.dims.k + b->own.dims.f +
             (b->own.force != NULL);
  for (int i = 0; i < b->constraint.count; i++) acts += nsdae_constraint_at(b, i)->drive != NULL;
  return b->body.count > 0 && acts == 0 && g[0] == 0 && g[1] == 0 && g[2] == 0;
}

/* Triangles of both orders: beneath one of them there is no material. */
static int note_mesh(nsdae_bodies *b, int i)
{
  const nsdae_solid_of *s = nsdae_solid_at(b, i);
  if (!s->mesh || s->filter.exclude == -1 || s->mesh->turned[0] == s->mesh->turned[1])
    return NSDAE_OK;
  nsdae_error_set(
      &b->error, NSDAE_WARN_MODEL, "nsdae_bodies_system", "triangle",
      "solid %d: triangles %d and %d run along their common side in the same direction: "
      "one of them is not anticlockwise seen from outside, and bodies fall through it",
      i, s->mesh->turned[0], s->mesh->turned[1]);
  return nsdae_error_at(&b->error, NSDAE_WARN_MODEL, i, NAN);
}

/* A segment without thickness is the surface of what is below it, a floor. */
static int note_segment(nsdae_bodies *b, int i)
{
  const nsdae_solid_of *s = nsdae_solid_at(b, i);
  if (s->shape != NSDAE_SHAPE_SEGMENT || s->radius > 0 || s->body == NSDAE_GROUND ||
      s->filter.exclude == -1)
    return NSDAE_OK;
  nsdae_error_set(
      &b->error, NSDAE_WARN_MODEL, "nsdae_bodies_system", "radius",
      "solid %d: a segment of radius 0 is a floor with material below it (y < 0 in its frame): "
      "body %d passes through those below; give it a radius",
      i, s->body);
  return nsdae_error_at(&b->error, NSDAE_WARN_MODEL, i, NAN);
}

static int note_given(nsdae_bodies *b)
{
  int status = note_gravity(b);
  for (int i = 0; i < b->body.count && status == NSDAE_OK; i++) {
    status = note_body(b, i);
    if (status == NSDAE_OK) status = note_inertia(b, i);
  }
  for (int i = 0; i < b->solid.count && status == NSDAE_OK && b->dimension == 2; i++)
    if (in_degrees(nsdae_solid_at(b, i)->turn[0]))
      status = note_angle(b, "solid", i, "angle", nsdae_solid_at(b, i)->turn[0]);
  for (int i = 0; i < b->solid.count && status == NSDAE_OK; i++) {
    status = note_mesh(b, i);
    if (status == NSDAE_OK) status = note_segment(b, i);
  }
  for (int i = 0; i < b->limit.count && status == NSDAE_OK; i++) {
    const nsdae_bodies_limit *l = nsdae_limit_at(b, i);
    if (l->value.kind == NSDAE_PRIMITIVE_TURN && in_degrees(l->bound))
      status = note_angle(b, "limit", i, l->sign > 0 ? "low" : "high", l->bound);
  }
  return status;
}

/* ---- contacts */

static int is_joined(const nsdae_bodies *b, int body0, int body1)
{
  for (int i = 0; i < b->joint.count && body0 != NSDAE_GROUND && body1 != NSDAE_GROUND; i++) {
    const nsdae_bodies_joint *j = nsdae_joint_at(b, i);
    int same = (j->body[0] == body0 && j->body[1] == body1) ||
               (j->body[0] == body1 && j->body[1] == body0);
    if (same && !j->collide_connected) return 1;
  }
  return 0;
}

/* Whether any solid may touch this one. A solid that excludes all is for pictures alone. The search
 * begins at *last, the partner of a solid before: a floor is that of many. *empty: a solid that
 * only its shape keeps from it. */
static int has_partner(const nsdae_bodies *b, int i, int touches[NSDAE_MATERIALS][NSDAE_MATERIALS],
                       int *last, int *empty)
{
  const nsdae_solid_of *s = nsdae_solid_at(b, i);
  if (s->filter.exclude == -1) return 1;
  for (int k = 0; k < b->solid.count; k++) {
    int j = (*last + k) % b->solid.count;
    const nsdae_solid_of *other = nsdae_solid_at(b, j);
    if (s->body != other->body && touches[s->filter.material][other->filter.material] &&
        !((s->filter.group & other->filter.exclude) | (other->filter.group & s->filter.exclude)) &&
        !is_joined(b, s->body, other->body)) {
      if (nsdae_pair_is_empty(s, other)) {
        *empty = j;
        continue;
      }
      *last = j;
      return 1;
    }
  }
  for (int j = 0; j < b->feature.count; j++)
    if (nsdae_feature_at(b, j)->solid[0] == i || nsdae_feature_at(b, j)->solid[1] == i) return 1;
  return 0;
}

/* Whether no solid of the body of solid i may touch anything. */
static int is_alone(const nsdae_bodies *b, int i, int touches[NSDAE_MATERIALS][NSDAE_MATERIALS],
                    int *last, int *empty)
{
  int body = nsdae_solid_at(b, i)->body, of_others;
  *empty = -1;
  if (body == NSDAE_GROUND || has_partner(b, i, touches, last, empty)) return 0;
  for (int j = 0; j < b->solid.count; j++)
    if (nsdae_solid_at(b, j)->body == body && has_partner(b, j, touches, last, &of_others))
      return 0;
  return 1;
}

/* The first body of whose solids none may touch anything. */
static int note_contacts(nsdae_bodies *b)
{
  int touches[NSDAE_MATERIALS][NSDAE_MATERIALS] = {{0}}, first = 0, last = 0, empty = -1;
  for (int i = 0; i < b->pair.count; i++) {
    const int *material = ((const nsdae_bodies_pair *)b->pair.at + i)->material;
    touches[material[0]][material[1]] = touches[material[1]][material[0]] = 1;
  }
  while (first < b->solid.count && !is_alone(b, first, touches, &last, &empty)) first++;
  if (first == b->solid.count || b->own.contacts) return NSDAE_OK;
  int alone = nsdae_solid_at(b, first)->body;
  char name[CALLED];
  if (empty >= 0) {
    nsdae_error_set(&b->error, NSDAE_WARN_MODEL, "nsdae_bodies_system", "solid",
                    "%s has nothing to touch: %s (solid %d) and %s (solid %d) have no "
                    "contacts, as both have no corners or are points: choose other shapes",
                    called(b, alone, name), nsdae_solid_name(nsdae_solid_at(b, first)->shape),
                    first, nsdae_solid_name(nsdae_solid_at(b, empty)->shape), empty);
    return nsdae_error_at(&b->error, NSDAE_WARN_MODEL, alone, NAN);
  }
  nsdae_error_set(&b->error, NSDAE_WARN_MODEL, "nsdae_bodies_system", "solid",
                  "%s has solids and nothing to touch: call nsdae_bodies_add_contact or "
                  "nsdae_bodies_set_pair, or set exclude = -1 if they are for pictures alone",
                  called(b, alone, name));
  return nsdae_error_at(&b->error, NSDAE_WARN_MODEL, alone, NAN);
}

/* A named material of no solid: a name is misspelt. */
static int note_material(nsdae_bodies *b)
{
  const nsdae_bodies_name *name = b->name.at;
  for (int i = 0; i < b->name.count; i++) {
    int used = name[i].kind != NSDAE_NAMED_MATERIAL;
    nsdae_suggest meant = nsdae_suggest_start(name[i].text);
    for (int j = 0; j < b->solid.count && !used; j++)
      used = nsdae_solid_at(b, j)->filter.material == name[i].i;
    for (int j = 0; j < b->name.count && !used; j++)
      if (j != i && name[j].kind == NSDAE_NAMED_MATERIAL) nsdae_suggest_try(&meant, name[j].text);
    if (used) continue;
    const char *other = nsdae_suggest_end(&meant);
    nsdae_error_set(&b->error, NSDAE_WARN_MODEL, "nsdae_bodies_system", "material",
                    "material '%s' has no solid%s%s%s", name[i].text,
                    other ? "; did you mean '" : "", other ? other : "", other ? "'?" : "");
    return nsdae_error_at(&b->error, NSDAE_WARN_MODEL, name[i].i, NAN);
  }
  return NSDAE_OK;
}

int nsdae_bodies_note(nsdae_bodies *b)
{
  int status = note_given(b);
  if (status == NSDAE_OK) status = note_material(b);
  return status == NSDAE_OK ? note_contacts(b) : status;
}
