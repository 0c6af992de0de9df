/* What trajectory files show: each solid, spring and rod with formulas of where it is, in the names
 * that the coordinates have. A body without solids is a point.
 *
 *   planar    x + c sx - s sy,  y + s sx + c sy,  with c, s of theta
 *   spatial   r + R(p) s with R for a quaternion p of any length, whose length drifts;  p p_s */
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

#include "words.h"
#include "bodies_impl.h"
#include "mesh.h"

enum { LENGTH = 256, NAME = 24 }; /* the longest formula of a file; x0, theta12 */

/* A formula being put together; digits: of its numbers, 0: as many as they have. */
typedef struct formula {
  char text[LENGTH];
  int used, digits;
} formula;

/* ---- texts */

static void append_text(formula *f, const char *format, ...)
{
  va_list values;
  if (f->used >= LENGTH) return;
  va_start(values, format);
  f->used += vsnprintf(f->text + f->used, (size_t)(LENGTH - f->used), format, values);
  va_end(values);
}

/* The number with its sign, which goes between two terms. */
static void append_number(formula *f, double value)
{
  char number[32];
  if (f->digits > 0)
    snprintf(number, sizeof number, "%.*g", f->digits, value);
  else
    nsdae_number_write(value, number, sizeof number);
  append_text(f, f->used > 0 && value >= 0 ? "+%s" : "%s", number);
}

/* + value * factor, where value is not zero. */
static void add_term(formula *f, double value, const char *factor)
{
  if (value == 0) return;
  if (value == 1 || value == -1)
    append_text(f, "%s%s", value < 0 ? "-" : f->used > 0 ? "+" : "", factor);
  else {
    append_number(f, value);
    append_text(f, "*%s", factor);
  }
}

static void add_number(formula *f, double value)
{
  if (value != 0) append_number(f, value);
  if (f->used == 0) append_text(f, "0");
}

/* The coordinates of a body by their names. */
typedef struct coordinates {
  char x[3][NAME], theta[NAME], p[4][NAME];
} coordinates;

/* ---- places and turns */

static coordinates name_coordinates(int body)
{
  static const char *const axes[3] = {"x", "y", "z"}, *const parts[4] = {"qw", "qx", "qy", "qz"};
  coordinates c;
  for (int i = 0; i < 3; i++) snprintf(c.x[i], NAME, "%s%d", axes[i], body);
  for (int i = 0; i < 4; i++) snprintf(c.p[i], NAME, "%s%d", parts[i], body);
  snprintf(c.theta, NAME, "theta%d", body);
  return c;
}

/* Row i of R(p) s, with j and k the axes after it:
 * (s_i (w^2 + p_i^2 - p_j^2 - p_k^2) + 2 s_j (p_i p_j - w p_k) + 2 s_k (p_i p_k + w p_j)) / p.p */
static void spatial_point(formula *f, const coordinates *c, int i, const double *s)
{
  int j = (i + 1) % 3, k = (i + 2) % 3;
  const char *w = c->p[0], *a = c->p[1 + i], *b = c->p[1 + j], *d = c->p[1 + k];
  char along[4 * NAME + 16], left[4 * NAME + 16], right[4 * NAME + 16];
  if (s[0] == 0 && s[1] == 0 && s[2] == 0) return;
  snprintf(along, sizeof along, "(%s^2+%s^2-%s^2-%s^2)", w, a, b, d);
  snprintf(left, sizeof left, "(%s*%s-%s*%s)", a, b, w, d);
  snprintf(right, sizeof right, "(%s*%s+%s*%s)", a, d, w, b);
  formula sum = {.digits = f->digits};
  add_term(&sum, s[i], along);
  add_term(&sum, 2 * s[j], left);
  add_term(&sum, 2 * s[k], right);
  append_text(f, "+(%s)/(%s^2+%s^2+%s^2+%s^2)", sum.text, w, a, b, d);
}

/* Where the point s of a body's frame is along an axis of space. */
static void write_place(formula *f, const nsdae_bodies *b, int body, const double *s, int axis)
{
  if (body == NSDAE_GROUND) {
    add_number(f, s[axis]);
    return;
  }
  coordinates c = name_coordinates(body);
  append_text(f, "%s", c.x[axis]);
  if (b->dimension == 3) {
    spatial_point(f, &c, axis, s);
    return;
  }
  char cosine[NAME + 8], sine[NAME + 8];
  snprintf(cosine, sizeof cosine, "cos(%s)", c.theta);
  snprintf(sine, sizeof sine, "sin(%s)", c.theta);
  add_term(f, s[axis], cosine);
  add_term(f, axis == 0 ? -s[1] : s[0], sine);
}

/* Part i of the body's quaternion times the solid's. */
static formula quaternion(int body, const double *turn, int i)
{
  static const struct {
    int of[4];
    double sign[4];
  } product[4] = {{{0, 1, 2, 3}, {1, -1, -1, -1}},
                  {{1, 0, 3, 2}, {1, 1, 1, -1}},
                  {{2, 3, 0, 1}, {1, -1, 1, 1}},
                  {{3, 2, 1, 0}, {1, 1, -1, 1}}};
  formula f = {.digits = 0};
  if (body == NSDAE_GROUND) {
    add_number(&f, turn[i]);
    return f;
  }
  coordinates c = name_coordinates(body);
  for (int j = 0; j < 4; j++) add_term(&f, product[i].sign[j] * turn[product[i].of[j]], c.p[j]);
  return f;
}

/* A body of the file with the texts that it points to. */
typedef struct portrait {
  nsdae_body body;
  char name[64];
  formula position[3], end[3], angle, turn[4];
} portrait;

/* ---- solids, springs, rods */

/* Formulas of where the point s of a body's frame is, and their texts. */
static void set_point(const nsdae_bodies *b, int body, const double *s, formula f[3],
                      const char *text[3])
{
  for (int i = 0; i < b->dimension; i++) {
    f[i] = (formula){.digits = 0};
    write_place(&f[i], b, body, s, i);
    if (f[i].used >= LENGTH) { /* with nine digits where there is no room for all */
      f[i] = (formula){.digits = 9};
      write_place(&f[i], b, body, s, i);
    }
    text[i] = f[i].text;
  }
}

static void set_position(portrait *p, const nsdae_bodies *b, int body, const double *s)
{
  set_point(b, body, s, p->position, p->body.position);
}

/* The body's frame; in space turned on by the solid's quaternion. */
static void set_frame(portrait *p, const nsdae_bodies *b, int body, double angle,
                      const double *turn)
{
  if (b->dimension == 2) {
    if (body != NSDAE_GROUND) append_text(&p->angle, "theta%d", body);
    add_number(&p->angle, angle);
    p->body.angle = p->angle.text;
    return;
  }
  for (int i = 0; i < 4; i++) {
    p->turn[i] = quaternion(body, turn, i);
    p->body.quaternion[i] = p->turn[i].text;
  }
}

/* The name; or by shape and number, of a solid behind the name of its body. */
static int show(portrait *p, nsdae_system *system, const char *name, const char *body,
                const char *what, int number)
{
  if (name)
    snprintf(p->name, sizeof p->name, "%s", name);
  else
    snprintf(p->name, sizeof p->name, "%s%s%s %d", body ? body : "", body ? " " : "", what, number);
  p->body.name = p->name;
  return nsdae_system_add_body(system, &p->body);
}

/* A distance: a line from the point of the one body to that of the other. */
static int show_length(const nsdae_bodies *b, nsdae_system *system, const nsdae_primitive *e,
                       const char *what, int number)
{
  if (e->kind != NSDAE_PRIMITIVE_DISTANCE) return NSDAE_OK;
  portrait p = {.body = {.shape = NSDAE_SHAPE_SEGMENT}};
  set_position(&p, b, e->body[0], e->point[0]);
  set_point(b, e->body[1], e->point[1], p.end, p.body.end);
  return show(&p, system, NULL, NULL, what, number);
}

static int show_solid(const nsdae_bodies *b, nsdae_system *system, int i)
{
  const double no_turn[4] = {1, 0, 0, 0}, centre[3] = {0, 0, 0};
  const nsdae_solid_of *s = nsdae_solid_at(b, i);
  portrait p = {.body = {.shape = s->shape}};
  double *size = p.body.size, *triangles = NULL;
  size[0] = s->shape == NSDAE_SHAPE_SEGMENT ? 2 * s->radius : s->radius;
  if (s->hollow) { /* drawn as a ring */
    size[0] = 1.15 * s->radius;
    size[1] = s->radius;
  }
  int axes = s->shape == NSDAE_SHAPE_BOX || s->shape == NSDAE_SHAPE_ELLIPSOID;
  int smooth = nsdae_solid_is_smooth(s);
  if (smooth) size[0] = s->half[0];
  if (smooth || s->shape == NSDAE_SHAPE_CAPSULE) size[1] = 2 * s->half[2];
  for (int j = 0; j < 3 && axes; j++) size[j] = 2 * s->half[j];
  for (int j = 0; j < 3 && s->shape == NSDAE_SHAPE_PLANE; j++) size[j] = s->R[6 + j];
  if (s->shape == NSDAE_SHAPE_SEGMENT) {
    set_position(&p, b, s->body, s->point);
    set_point(b, s->body, s->point + 3, p.end, p.body.end);
  } else if (s->shape == NSDAE_SHAPE_POLYGON || s->shape == NSDAE_SHAPE_POLYHEDRON || s->mesh) {
    /* its corners are in the body's frame */
    size_t most = s->mesh ? (size_t)s->mesh->triangles : 2 * (size_t)s->points;
    p.body.points = s->points;
    p.body.point = s->point;
    if (s->hull || s->mesh) {
      p.body.shape = NSDAE_SHAPE_POLYHEDRON; /* a surface of triangles */
      p.body.point = triangles = malloc(9 * most * sizeof *triangles);
      if (!triangles) return NSDAE_E_MEMORY;
      p.body.points = 3 * (s->mesh ? nsdae_mesh_triangles(s->mesh, triangles)
                                   : nsdae_hull_triangles(s->hull, s->point, triangles));
    }
    set_position(&p, b, s->body, centre);
    set_frame(&p, b, s->body, 0, no_turn);
  } else {
    int flat = s->shape == NSDAE_SHAPE_PLANE; /* its normal is in the body's frame */
    set_position(&p, b, s->body, s->origin);
    set_frame(&p, b, s->body, flat ? 0 : atan2(s->R[1], s->R[0]), flat ? no_turn : s->turn);
  }
  p.body.colour = nsdae_bodies_name_of(b, NSDAE_COLOUR_OF + NSDAE_NAMED_SOLID, i);
  if (!p.body.colour)
    p.body.colour = nsdae_bodies_name_of(b, NSDAE_COLOUR_OF + NSDAE_NAMED_BODY, s->body);
  int status =
      show(&p, system, nsdae_bodies_name_of(b, NSDAE_NAMED_SOLID, i),
           nsdae_bodies_name_of(b, NSDAE_NAMED_BODY, s->body), nsdae_solid_name(s->shape), i);
  free(triangles);
  return status;
}

/* Bodies of which nothing else is seen. */
static int show_bare(const nsdae_bodies *b, nsdae_system *system)
{
  const double no_turn[4] = {1, 0, 0, 0}, centre[3] = {0, 0, 0};
  char *seen = calloc((size_t)b->body.count, sizeof *seen);
  int status = seen ? NSDAE_OK : NSDAE_E_MEMORY;
  for (int i = 0; i < b->solid.count && seen; i++) {
    int body = nsdae_solid_at(b, i)->body;
    if (body != NSDAE_GROUND) seen[body] = 1;
  }
  for (int i = 0; i < b->body.count && status == NSDAE_OK; i++) {
    portrait p = {.body = {.shape = NSDAE_SHAPE_POINT}};
    if (seen[i]) continue;
    set_position(&p, b, i, centre);
    set_frame(&p, b, i, 0, no_turn);
    p.body.colour = nsdae_bodies_name_of(b, NSDAE_COLOUR_OF + NSDAE_NAMED_BODY, i);
    status = show(&p, system, nsdae_bodies_name_of(b, NSDAE_NAMED_BODY, i), NULL, "body", i);
  }
  free(seen);
  return status;
}

int nsdae_bodies_show(const nsdae_bodies *b, nsdae_system *system)
{
  int status = NSDAE_OK;
  for (int i = 0; i < b->solid.count && status == NSDAE_OK; i++) status = show_solid(b, system, i);
  if (status == NSDAE_OK) status = show_bare(b, system);
  for (int i = 0; i < b->force.spring.count && status == NSDAE_OK; i++)
    status = show_length(b, system, &nsdae_spring_at(b, i)->value, "spring",
                         nsdae_spring_at(b, i)->number);
  for (int i = 0, rods = 0; i < b->constraint.count && status == NSDAE_OK; i++) {
    const nsdae_primitive *p = &nsdae_constraint_at(b, i)->value;
    status = show_length(b, system, p, "rod", rods);
    rods += p->kind == NSDAE_PRIMITIVE_DISTANCE;
  }
  for (int i = 0; i < b->limit.count && status == NSDAE_OK; i++)
    status = show_length(b, system, &nsdae_limit_at(b, i)->value, "rope", i);
  return status;
}
