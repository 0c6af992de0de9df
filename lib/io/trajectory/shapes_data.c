/* A row of /bodies for each body: texts, sizes, and its number of rows in the table of points; or,
 * of what is placed by coordinates alone, a row of /shapes: their numbers in place of formulas. */
#include "description.h"

#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

static const char *const shape_names[] = {
    "point", "disc",  "segment",    "polygon",  "path", "sphere",   "capsule",
    "box",   "plane", "polyhedron", "cylinder", "cone", "ellipsoid"};

enum { SHAPES = sizeof shape_names / sizeof *shape_names };

static int is_given(const char *text)
{
  return text && *text;
}

/* The texts of a body, in the order of their columns. The first two and the last are no formulas.
 */
enum { TEXTS = 14, FORMULAS = 2, SHAPE = 1, COLOUR = 13 };

#define PLACE      "formula of the place of the body's origin"
#define QUATERNION "formula: the quaternion that turns the body's frame; empty: none"
#define END        "formula of a segment's other end; empty: none"

static const struct column {
  const char *path, *field;
  size_t offset;
  const char *units, *description;
} columns[TEXTS] = {
    {"/bodies/name", "name", offsetof(nsdae_body, name), "", "names of the bodies"},
    {"/bodies/shape", "shape", 0, "", "their shapes"},
    {"/bodies/x", "position", offsetof(nsdae_body, position[0]), "m", PLACE},
    {"/bodies/y", "position", offsetof(nsdae_body, position[1]), "m", PLACE},
    {"/bodies/z", "position", offsetof(nsdae_body, position[2]), "m", PLACE},
    {"/bodies/angle", "angle", offsetof(nsdae_body, angle), "rad",
     "formula of the angle of the body's frame about z; empty: none"},
    {"/bodies/quaternion_w", "quaternion", offsetof(nsdae_body, quaternion[0]), "1", QUATERNION},
    {"/bodies/quaternion_x", "quaternion", offsetof(nsdae_body, quaternion[1]), "1", QUATERNION},
    {"/bodies/quaternion_y", "quaternion", offsetof(nsdae_body, quaternion[2]), "1", QUATERNION},
    {"/bodies/quaternion_z", "quaternion", offsetof(nsdae_body, quaternion[3]), "1", QUATERNION},
    {"/bodies/end_x", "end", offsetof(nsdae_body, end[0]), "m", END},
    {"/bodies/end_y", "end", offsetof(nsdae_body, end[1]), "m", END},
    {"/bodies/end_z", "end", offsetof(nsdae_body, end[2]), "m", END},
    {"/bodies/colour", "colour", offsetof(nsdae_body, colour), "",
     "#rrggbb; empty: none"}, /* if any has one */
};

/* As it is given, or NULL. */
static const char *given_text(const nsdae_body *b, int column)
{
  if (column == SHAPE) return shape_names[b->shape];
  return *(const char *const *)(const void *)((const char *)b + columns[column].offset);
}

static int count_given(const char *const *text, int n)
{
  int count = 0;
  for (int i = 0; i < n; i++) count += is_given(text[i]);
  return count;
}

/* ---- the check */

/* The first fault of all is reported. */
static int refuse_shape(nsdae_h5 *h5, const nsdae_body *body, int i, const char *field,
                        const char *wrong)
{
  if (h5->status < 0) return h5->status;
  h5->status =
      nsdae_error_set(h5->error, NSDAE_E_ARGUMENT, h5->where, field, "body %d '%.40s': %s: %.160s",
                      i, body[i].name ? body[i].name : "", field, wrong);
  if (h5->error) h5->error->index = i;
  return h5->status;
}

/* Every body has a name that no other has. */
static void check_names(nsdae_h5 *h5, int n, const nsdae_body *body)
{
  for (int i = 0; i < n; i++)
    if (!is_given(body[i].name)) refuse_shape(h5, body, i, "name", "it has none");
  nsdae_named *sorted = nsdae_h5_allocate(h5, (size_t)n, sizeof *sorted);
  for (int i = 0; sorted && i < n; i++) sorted[i] = (nsdae_named){body[i].name, i};
  if (sorted) qsort(sorted, (size_t)n, sizeof *sorted, nsdae_named_order);
  for (int i = 1; sorted && i < n; i++)
    if (strcmp(sorted[i - 1].name, sorted[i].name) == 0)
      refuse_shape(h5, body, sorted[i].number, "name", "another body has it already");
  free(sorted);
}

/* What is wrong with the size, or NULL. */
static const char *size_fault(int shape, const double *size)
{
  for (int i = 0; i < 3; i++)
    if (!isfinite(size[i])) return "a value is not finite";
  if (shape == NSDAE_SHAPE_PLANE)
    return size[0] != 0 || size[1] != 0 || size[2] != 0 ? NULL : "its normal is zero";
  for (int i = 0; i < 3; i++)
    if (size[i] < 0) return "a length is negative";
  int round =
      shape == NSDAE_SHAPE_DISC || shape == NSDAE_SHAPE_SPHERE || shape == NSDAE_SHAPE_CAPSULE;
  int turned = shape == NSDAE_SHAPE_CYLINDER || shape == NSDAE_SHAPE_CONE;
  if (turned && (size[0] == 0 || size[1] == 0))
    return "its radius and length must be greater than 0";
  if (round && size[0] == 0) return "its radius must be greater than 0";
  if (shape == NSDAE_SHAPE_DISC && size[1] >= size[0])
    return "the radius of its hole must be less than its own";
  int flat = size[0] == 0 || size[1] == 0 || size[2] == 0;
  if (shape == NSDAE_SHAPE_BOX && flat) return "its edges must be greater than 0";
  if (shape == NSDAE_SHAPE_ELLIPSOID && flat) return "its axes must be greater than 0";
  return NULL;
}

static const char *points_fault(const nsdae_body *b)
{
  int solid = b->shape == NSDAE_SHAPE_POLYHEDRON, least = b->shape == NSDAE_SHAPE_POLYGON ? 3
                                                          : b->shape == NSDAE_SHAPE_PATH  ? 2
                                                          : solid                         ? 3
                                                                                          : 0;
  if (solid && (b->points < least || b->points % 3 != 0))
    return "a polyhedron needs three for each of its triangles, of which it has at least one";
  if (b->points < least) return least == 3 ? "a polygon needs three" : "a path needs two";
  if (least == 0 && b->points != 0) return "only a polygon, a path and a polyhedron have any";
  if (b->points > 0 && !b->point) return "point is NULL";
  for (size_t i = 0; i < 3 * (size_t)b->points; i++)
    if (!isfinite(b->point[i])) return "a value is not finite";
  return NULL;
}

static int is_colour(const char *text)
{
  return *text == '#' && strlen(text) == 7 && strspn(text + 1, "0123456789abcdefABCDEF") == 6;
}

static int check_shape(nsdae_h5 *h5, const nsdae_body *body, int i)
{
  const nsdae_body *b = &body[i];
  if (is_given(b->colour) && !is_colour(b->colour))
    return refuse_shape(h5, body, i, "colour", "it must be # and six hexadecimal digits");
  if (b->shape < 0 || b->shape >= SHAPES)
    return refuse_shape(h5, body, i, "shape", "there is no such shape");
  const char *of_size = size_fault(b->shape, b->size), *of_points = points_fault(b);
  if (of_size) refuse_shape(h5, body, i, "size", of_size);
  if (of_points) refuse_shape(h5, body, i, "points", of_points);
  return h5->status;
}

static void check_place(nsdae_h5 *h5, const nsdae_body *body, int i,
                        const nsdae_formula_names *names)
{
  const nsdae_body *b = &body[i];
  int parts = count_given(b->quaternion, 4), ends = count_given(b->end, 3);
  int segment = b->shape == NSDAE_SHAPE_SEGMENT;
  if (parts > 0 && parts < 4) refuse_shape(h5, body, i, "quaternion", "it has four parts");
  if (parts > 0 && is_given(b->angle))
    refuse_shape(h5, body, i, "angle", "it has a quaternion too");
  if (segment && ends == 0) refuse_shape(h5, body, i, "end", "a segment needs its other end");
  if (!segment && ends > 0) refuse_shape(h5, body, i, "end", "only a segment has one");
  if (segment && (parts > 0 || is_given(b->angle)))
    refuse_shape(h5, body, i, "angle", "a segment lies between its ends");
  for (int c = FORMULAS; c < COLOUR && h5->status == NSDAE_OK; c++) {
    char reason[NSDAE_FORMULA_REASON];
    const char *text = given_text(b, c);
    if (is_given(text) && nsdae_formula_check(text, names, reason) < 0)
      refuse_shape(h5, body, i, columns[c].field, reason);
  }
}

void nsdae_bodies_check(nsdae_h5 *h5, int n, const nsdae_body *body,
                        const nsdae_formula_names *names)
{
  check_names(h5, n, body);
  for (int i = 0; i < n && h5->status == NSDAE_OK; i++)
    if (check_shape(h5, body, i) == NSDAE_OK) check_place(h5, body, i, names);
}

/* ---- the group */

/* A formula that is not given is zero if it places the body or the end of a segment. */
static const char *text_of(const nsdae_body *b, int column)
{
  const char *text = given_text(b, column);
  int place = column < 5 || (column >= 10 && column < COLOUR && b->shape == NSDAE_SHAPE_SEGMENT);
  return is_given(text) ? text : place ? "0" : "";
}

/* Bodies of one of the two groups, and memory for their columns. */
typedef struct column_set {
  nsdae_h5 *h5;
  const char *group;
  int n;
  const nsdae_body *const *body;
  const char **text; /* n */
  int *number;       /* n */
  double *row;       /* 3 of n, or of all points */
} column_set;

static void write_matrix(const column_set *s, const char *name, size_t rows, const char *what)
{
  char path[NSDAE_H5_PATH];
  const hsize_t size[2] = {rows, 3};
  nsdae_h5_array(s->h5, nsdae_h5_join(path, s->group, name), H5T_NATIVE_DOUBLE, 2, size, s->row,
                 "m", what);
}

static void write_ints(const column_set *s, const char *name, const char *what)
{
  char path[NSDAE_H5_PATH];
  nsdae_h5_vector(s->h5, nsdae_h5_join(path, s->group, name), H5T_NATIVE_INT, (hsize_t)s->n,
                  s->number, "1", what);
}

/* Sizes; how many points each body has, and all of them one after another. */
static void write_points(column_set *s)
{
  size_t points = 0;
  for (int i = 0; i < s->n; i++)
    memcpy(s->row + 3 * (size_t)i, s->body[i]->size, sizeof s->body[i]->size);
  write_matrix(s, "size", (size_t)s->n, "by the shape");
  for (int i = 0; i < s->n; i++) {
    size_t own = (size_t)s->body[i]->points;
    s->number[i] = s->body[i]->points;
    if (own > 0) memcpy(s->row + 3 * points, s->body[i]->point, 3 * sizeof *s->row * own);
    points += own;
  }
  write_ints(s, "points", "rows of point in this group that each has, in order");
  if (points > 0)
    write_matrix(s, "point", points,
                 "corners of polygons, paths and triangles of polyhedra in their bodies' frames");
}

static void write_text(column_set *s, const char *path, int c)
{
  for (int i = 0; i < s->n; i++) s->text[i] = text_of(s->body[i], c);
  nsdae_h5_vector(s->h5, path, H5T_C_S1, (hsize_t)s->n, s->text, columns[c].units,
                  columns[c].description);
}

/* If a body has one. */
static void write_colours(column_set *s)
{
  char path[NSDAE_H5_PATH];
  int any = 0;
  for (int i = 0; i < s->n; i++) any |= is_given(s->body[i]->colour);
  if (any) write_text(s, nsdae_h5_join(path, s->group, "colour"), COLOUR);
}

static void write_texts(column_set *s)
{
  for (int c = 0; c < COLOUR; c++) write_text(s, columns[c].path, c);
}

/* ---- what is placed by coordinates alone */

/* Numbers of coordinates: of x, the next ones being y (and z); of the angle, or of w, the next ones
 * being x, y, z of the quaternion. */
typedef struct placed {
  int dimension, position, turn; /* 2 or 3; turn -1: none */
} placed;

/* Whether the texts are coordinates one after another; the number of the first in *first. */
static int in_a_row(const char *const *text, int n, const nsdae_formula_names *names, int *first)
{
  if (!is_given(text[0])) return 0;
  *first = nsdae_formula_coordinate(text[0], names);
  for (int i = 1; i < n; i++)
    if (!is_given(text[i]) || nsdae_formula_coordinate(text[i], names) != *first + i) return 0;
  return *first >= 0;
}

static int find_place(const nsdae_body *b, const nsdae_formula_names *names, placed *p)
{
  *p = (placed){.dimension = is_given(b->position[2]) ? 3 : 2, .turn = -1};
  if (b->shape == NSDAE_SHAPE_SEGMENT || !in_a_row(b->position, p->dimension, names, &p->position))
    return 0;
  if (is_given(b->angle)) return p->dimension == 2 && in_a_row(&b->angle, 1, names, &p->turn);
  if (!is_given(b->quaternion[0])) return 1;
  return p->dimension == 3 && in_a_row(b->quaternion, 4, names, &p->turn);
}

/* Names and shapes, and three columns of numbers: which coordinates place each body. */
static void write_shapes(column_set *s, const nsdae_formula_names *names)
{
  static const char *const name[] = {"dimension", "position", "turn"},
                           *const what[] = {
                               "2: in the plane, 3: in space",
                               "coordinate, from 0, that is x of the origin; y, z come after it",
                               ("coordinate, from 0, that is the angle about z, or in space w of "
                                "the quaternion, whose x, y, z come after it; -1: not turned")};
  for (int i = 0; i < s->n; i++) {
    s->text[i] = s->body[i]->name;
    s->number[i] = s->body[i]->shape;
  }
  nsdae_h5_vector(s->h5, "/shapes/name", H5T_C_S1, (hsize_t)s->n, s->text, "",
                  "names of what is placed by coordinates alone");
  write_ints(s, "shape",
             "0 point, 1 disc, 3 polygon, 4 path, 5 sphere, 6 capsule, 7 box, 8 plane, 9 "
             "polyhedron, 10 cylinder, 11 cone, 12 ellipsoid");
  for (int c = 0; c < 3; c++) {
    for (int i = 0; i < s->n; i++) {
      placed p;
      find_place(s->body[i], names, &p);
      s->number[i] = c == 0 ? p.dimension : c == 1 ? p.position : p.turn;
    }
    write_ints(s, name[c], what[c]);
  }
}

/* names: of formulas, for /shapes; NULL: /bodies. */
static void write_group(nsdae_h5 *h5, int n, const nsdae_body *const *body,
                        const nsdae_formula_names *names)
{
  size_t rows = (size_t)n, points = 0;
  column_set s = {.h5 = h5, .group = names ? "/shapes" : "/bodies", .n = n, .body = body};
  for (int i = 0; i < n; i++) points += (size_t)body[i]->points;
  if (points > rows) rows = points;
  s.text = nsdae_h5_allocate(h5, (size_t)n, sizeof *s.text);
  s.number = nsdae_h5_allocate(h5, (size_t)n, sizeof *s.number);
  s.row = nsdae_h5_allocate(h5, 3 * rows, sizeof *s.row);
  if (s.row && n > 0) {
    if (names)
      write_shapes(&s, names);
    else
      write_texts(&s);
    write_points(&s);
    write_colours(&s);
  }
  free(s.text);
  free(s.number);
  free(s.row);
}

void nsdae_bodies_write(nsdae_h5 *h5, int n, const nsdae_body *body,
                        const nsdae_formula_names *names, int apart)
{
  int in_shapes = 0, in_bodies = 0;
  placed p;
  const nsdae_body **shapes = nsdae_h5_allocate(h5, (size_t)n, sizeof *shapes);
  const nsdae_body **bodies = nsdae_h5_allocate(h5, (size_t)n, sizeof *bodies);
  for (int i = 0; bodies && i < n; i++) {
    if (apart && find_place(&body[i], names, &p))
      shapes[in_shapes++] = &body[i];
    else
      bodies[in_bodies++] = &body[i];
  }
  write_group(h5, in_bodies, bodies, NULL);
  write_group(h5, in_shapes, shapes, names);
  free(shapes);
  free(bodies);
}
