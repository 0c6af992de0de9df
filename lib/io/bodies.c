/* A row of /bodies for each body: texts, sizes, and its number of rows in the table of points. */
#include "bodies.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "errors.h"

static const char *const shape_names[] = {"point",  "disc",    "segment", "polygon", "path",
                                          "sphere", "capsule", "box",     "plane"};

enum { SHAPES = sizeof shape_names / sizeof *shape_names };

static int is_given(const char *text)
{
  return text && *text;
}

static int count_given(const char *const *text, int n)
{
  int count = 0;
  for (int i = 0; i < n; i++) count += is_given(text[i]);
  return count;
}

/* ---- the check */

/* Which body, for the error's text. */
typedef struct subject {
  const nsdae_body *body;
  int number;
  const nsdae_formula_names *names;
  nsdae_error *error;
} subject;

static int refuse(const subject *s, const char *field, const char *wrong)
{
  const char *name = s->body->name ? s->body->name : "";
  int status = nsdae_error_set(s->error, NSDAE_E_ARGUMENT, "nsdae_trajectory_set_bodies", field,
                               "body %d '%.40s': %s: %.160s", s->number, name, field, wrong);
  if (s->error) s->error->index = s->number;
  return status;
}

static int check_formula(const subject *s, const char *field, const char *text)
{
  char reason[NSDAE_FORMULA_REASON];
  if (!is_given(text) || nsdae_formula_check(text, s->names, reason) == NSDAE_OK) return NSDAE_OK;
  return refuse(s, field, reason);
}

static int check_formulas(const subject *s, const char *field, const char *const *text, int n)
{
  int status = NSDAE_OK;
  for (int i = 0; i < n && status == NSDAE_OK; i++) status = check_formula(s, field, text[i]);
  return status;
}

/* Names in order; of one name in the order of their bodies. */
static int by_name(const void *a, const void *b)
{
  const nsdae_body *const *left = a, *const *right = b;
  int order = strcmp((*left)->name, (*right)->name);
  return order ? order : (*left > *right) - (*left < *right);
}

static int check_names(int n, const nsdae_body *body, nsdae_error *error)
{
  for (int i = 0; i < n; i++) {
    const subject s = {&body[i], i, NULL, error};
    if (!is_given(body[i].name)) return refuse(&s, "name", "it has none");
  }
  const nsdae_body **sorted = malloc((size_t)n * sizeof *sorted);
  if (!sorted)
    return nsdae_error_set(error, NSDAE_E_MEMORY, "nsdae_trajectory_set_bodies", "",
                           "out of memory");
  for (int i = 0; i < n; i++) sorted[i] = &body[i];
  qsort(sorted, (size_t)n, sizeof *sorted, by_name);
  int status = NSDAE_OK;
  for (int i = 1; i < n && status == NSDAE_OK; i++) {
    const subject s = {sorted[i], (int)(sorted[i] - body), NULL, error};
    if (strcmp(sorted[i - 1]->name, sorted[i]->name) == 0)
      status = refuse(&s, "name", "another body has it already");
  }
  free(sorted);
  return status;
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
  if (round && size[0] == 0) return "its radius must be greater than 0";
  if (shape == NSDAE_SHAPE_DISC && size[1] >= size[0])
    return "the radius of its hole must be less than its own";
  if (shape == NSDAE_SHAPE_BOX && (size[0] == 0 || size[1] == 0 || size[2] == 0))
    return "its edges must be greater than 0";
  return NULL;
}

static const char *points_fault(const nsdae_body *b)
{
  int least = b->shape == NSDAE_SHAPE_POLYGON ? 3 : b->shape == NSDAE_SHAPE_PATH ? 2 : 0;
  if (b->points < least) return least == 3 ? "a polygon needs three" : "a path needs two";
  if (least == 0 && b->points != 0) return "only a polygon and a path have any";
  if (b->points > 0 && !b->point) return "point is NULL";
  for (size_t i = 0; i < 3 * (size_t)b->points; i++)
    if (!isfinite(b->point[i])) return "a value is not finite";
  return NULL;
}

static int check_shape(const subject *s)
{
  const nsdae_body *b = s->body;
  if (b->shape < 0 || b->shape >= SHAPES) return refuse(s, "shape", "there is no such shape");
  const char *fault = size_fault(b->shape, b->size);
  if (fault) return refuse(s, "size", fault);
  fault = points_fault(b);
  return fault ? refuse(s, "points", fault) : NSDAE_OK;
}

static int check_place(const subject *s)
{
  const nsdae_body *b = s->body;
  int parts = count_given(b->quaternion, 4), ends = count_given(b->end, 3);
  if (parts > 0 && parts < 4) return refuse(s, "quaternion", "it has four parts");
  if (parts > 0 && is_given(b->angle)) return refuse(s, "angle", "it has a quaternion too");
  if (b->shape == NSDAE_SHAPE_SEGMENT && ends == 0)
    return refuse(s, "end", "a segment needs its other end");
  if (b->shape != NSDAE_SHAPE_SEGMENT && ends > 0)
    return refuse(s, "end", "only a segment has one");
  if (b->shape == NSDAE_SHAPE_SEGMENT && (parts > 0 || is_given(b->angle)))
    return refuse(s, "angle", "a segment lies between its ends");
  int status = check_formulas(s, "position", b->position, 3);
  if (status == NSDAE_OK) status = check_formula(s, "angle", b->angle);
  if (status == NSDAE_OK) status = check_formulas(s, "quaternion", b->quaternion, 4);
  return status < 0 ? status : check_formulas(s, "end", b->end, 3);
}

int nsdae_bodies_check(int n, const nsdae_body *body, const nsdae_formula_names *names,
                       nsdae_error *error)
{
  int status = n > 0 ? check_names(n, body, error) : NSDAE_OK;
  for (int i = 0; i < n && status == NSDAE_OK; i++) {
    const subject s = {&body[i], i, names, error};
    status = check_shape(&s);
    if (status == NSDAE_OK) status = check_place(&s);
  }
  return status;
}

/* ---- the group */

/* The texts of a body, in the order of their columns. */
enum { TEXTS = 13 };

static const struct {
  const char *path, *units, *description;
} columns[TEXTS] = {
    {"/bodies/name", "", "names of the bodies"},
    {"/bodies/shape", "", "their shapes"},
    {"/bodies/x", "m", "formula of the place of the body's origin"},
    {"/bodies/y", "m", "formula of the place of the body's origin"},
    {"/bodies/z", "m", "formula of the place of the body's origin"},
    {"/bodies/angle", "rad", "formula of the angle of the body's frame about z; empty: none"},
    {"/bodies/quaternion_w", "1",
     "formula: the quaternion that turns the body's frame; empty: none"},
    {"/bodies/quaternion_x", "1",
     "formula: the quaternion that turns the body's frame; empty: none"},
    {"/bodies/quaternion_y", "1",
     "formula: the quaternion that turns the body's frame; empty: none"},
    {"/bodies/quaternion_z", "1",
     "formula: the quaternion that turns the body's frame; empty: none"},
    {"/bodies/end_x", "m", "formula of a segment's other end; empty: none"},
    {"/bodies/end_y", "m", "formula of a segment's other end; empty: none"},
    {"/bodies/end_z", "m", "formula of a segment's other end; empty: none"},
};

static const char *or_else(const char *text, const char *otherwise)
{
  return is_given(text) ? text : otherwise;
}

static const char *text_of(const nsdae_body *b, int column)
{
  if (column == 0) return b->name;
  if (column == 1) return shape_names[b->shape];
  if (column < 5) return or_else(b->position[column - 2], "0");
  if (column == 5) return or_else(b->angle, "");
  if (column < 10) return or_else(b->quaternion[column - 6], "");
  return or_else(b->end[column - 10], b->shape == NSDAE_SHAPE_SEGMENT ? "0" : "");
}

static int write_texts(nsdae_h5 *h5, int n, const nsdae_body *body, const char **text)
{
  int status = NSDAE_OK;
  for (int c = 0; c < TEXTS && status == NSDAE_OK; c++) {
    for (int i = 0; i < n; i++) text[i] = text_of(&body[i], c);
    status = nsdae_h5_vector(h5, columns[c].path, H5T_C_S1, (hsize_t)n, text, columns[c].units,
                             columns[c].description);
  }
  return status;
}

static size_t all_points(int n, const nsdae_body *body)
{
  size_t all = 0;
  for (int i = 0; i < n; i++) all += (size_t)body[i].points;
  return all;
}

static int write_numbers(nsdae_h5 *h5, int n, const nsdae_body *body, double *rows, int *count)
{
  double *at = rows;
  for (int i = 0; i < n; i++) {
    memcpy(rows + 3 * i, body[i].size, sizeof body[i].size);
    count[i] = body[i].points;
  }
  int status = nsdae_h5_matrix(h5, "/bodies/size", (hsize_t)n, 3, rows, "m", "by the shape");
  if (status == NSDAE_OK)
    status = nsdae_h5_vector(h5, "/bodies/points", H5T_NATIVE_INT, (hsize_t)n, count, "1",
                             "rows of /bodies/point that each body has, in order");
  for (int i = 0; i < n; i++) {
    if (body[i].points == 0) continue;
    memcpy(at, body[i].point, 3 * sizeof *at * (size_t)body[i].points);
    at += 3 * body[i].points;
  }
  if (status == NSDAE_OK && at > rows)
    status = nsdae_h5_matrix(h5, "/bodies/point", (hsize_t)(at - rows) / 3, 3, rows, "m",
                             "corners of polygons and paths in their bodies' frames");
  return status;
}

int nsdae_bodies_write(nsdae_h5 *h5, int n, const nsdae_body *body)
{
  size_t points = all_points(n, body), count = (size_t)n;
  if (n == 0) return NSDAE_OK;
  const char **text = malloc(count * sizeof *text);
  int *numbers = malloc(count * sizeof *numbers);
  double *rows = malloc(3 * (points > count ? points : count) * sizeof *rows);
  int status = NSDAE_E_MEMORY;
  if (text && numbers && rows) {
    status = write_texts(h5, n, body, text);
    if (status == NSDAE_OK) status = write_numbers(h5, n, body, rows, numbers);
  } else
    nsdae_error_set(h5->error, status, "nsdae_trajectory_set_bodies", "", "out of memory");
  free(text);
  free(numbers);
  free(rows);
  return status;
}
