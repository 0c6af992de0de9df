/* Scene files: rigid bodies of one solid each as rows of numbers (docs/guide/scenes.md).
 *
 *   file      line*                          lines end with a line feed
 *   line      blank | '#' comment | '#' KEY ':' setting* | header | row
 *   setting   word* KEY word* number         KEY: walls (two numbers, or none), floor, mu, e_N, g,
 * dt header    the names of the columns row       kind ',' number ',' ...        one body
 *
 * Words between a key and its number are prose: "walls: planes at x, y = -1 and +1". */
#include <limits.h>
#include <math.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <nsdae/params.h>

#include "arena.h"
#include "bodies_impl.h"
#include "errors.h"
#include "regular_file.h"
#include "words.h"

enum { LINE_SIZE = 4096, WORD_SIZE = 64 };

static const char blanks[] = " \t\r,;:=";

/* ---- the tables of settings and of columns */

static const nsdae_param settings[] = {
    {"walls", "m", "x and y of two walls", NSDAE_PARAM_REAL, offsetof(nsdae_scene, wall[0]),
     -INFINITY, -INFINITY, INFINITY, 0, NULL},
    {"walls", "m", "x and y of the other two", NSDAE_PARAM_REAL, offsetof(nsdae_scene, wall[1]),
     INFINITY, -INFINITY, INFINITY, 0, NULL},
    {"floor", "m", "z of the floor", NSDAE_PARAM_REAL, offsetof(nsdae_scene, floor), 0, -INFINITY,
     INFINITY, 0, NULL},
    {"mu", "1", "friction", NSDAE_PARAM_REAL, offsetof(nsdae_scene, mu), 0, 0, INFINITY, 0, NULL},
    {"e_N", "1", "restitution", NSDAE_PARAM_REAL, offsetof(nsdae_scene, e_n), 0, 0, 1, 0, NULL},
    {"g", "m/s^2", "gravity along -z", NSDAE_PARAM_REAL, offsetof(nsdae_scene, g), 9.81, 0,
     INFINITY, 0, NULL},
    {"dt", "s", "time step", NSDAE_PARAM_REAL, offsetof(nsdae_scene, dt), 0.002, 0, INFINITY,
     NSDAE_OPEN_MIN, NULL},
};
enum { SETTINGS = sizeof settings / sizeof *settings, WALLS = 0, FLOOR = 2 };

typedef struct body_row {
  int kind;
  double size[3];
  nsdae_rigid_body body;
} body_row;

static const char *const kinds[] = {"sphere",      "capsule",      "box",         "cylinder",
                                    "cone",        "ellipsoid",    "tetrahedron", "octahedron",
                                    "icosahedron", "dodecahedron", NULL};

/* Of each kind; sizes: number of those used; corners: of a regular polyhedron. */
static const struct {
  int shape, sizes, corners;
} shape_of[] = {{NSDAE_SHAPE_SPHERE, 1, 0},      {NSDAE_SHAPE_CAPSULE, 2, 0},
                {NSDAE_SHAPE_BOX, 3, 0},         {NSDAE_SHAPE_CYLINDER, 2, 0},
                {NSDAE_SHAPE_CONE, 2, 0},        {NSDAE_SHAPE_ELLIPSOID, 3, 0},
                {NSDAE_SHAPE_POLYHEDRON, 1, 4},  {NSDAE_SHAPE_POLYHEDRON, 1, 6},
                {NSDAE_SHAPE_POLYHEDRON, 1, 12}, {NSDAE_SHAPE_POLYHEDRON, 1, 20}};

#define ANY(key, unit, field)                                                                   \
  {                                                                                             \
    key, unit, "", NSDAE_PARAM_REAL, offsetof(body_row, field), 0, -INFINITY, INFINITY, 0, NULL \
  }
#define ABOVE(key, unit, field)                                                                 \
  {                                                                                             \
    key, unit, "", NSDAE_PARAM_REAL, offsetof(body_row, field), 0, 0, INFINITY, NSDAE_OPEN_MIN, \
        NULL                                                                                    \
  }

static const nsdae_param columns[] = {
    {"kind", "", "", NSDAE_PARAM_CHOICE, offsetof(body_row, kind), 0, 0, 0, 0, kinds},
    ANY("size0", "m", size[0]),
    ANY("size1", "m", size[1]),
    ANY("size2", "m", size[2]),
    ABOVE("mass", "kg", body.mass),
    ABOVE("I1", "kg m^2", body.inertia[0]),
    ABOVE("I2", "kg m^2", body.inertia[1]),
    ABOVE("I3", "kg m^2", body.inertia[2]),
    ANY("x", "m", body.position[0]),
    ANY("y", "m", body.position[1]),
    ANY("z", "m", body.position[2]),
    ANY("qw", "1", body.quaternion[0]),
    ANY("qx", "1", body.quaternion[1]),
    ANY("qy", "1", body.quaternion[2]),
    ANY("qz", "1", body.quaternion[3]),
    ANY("vx", "m/s", body.velocity[0]),
    ANY("vy", "m/s", body.velocity[1]),
    ANY("vz", "m/s", body.velocity[2]),
    ANY("w1", "rad/s", body.spin[0]),
    ANY("w2", "rad/s", body.spin[1]),
    ANY("w3", "rad/s", body.spin[2]),
};
enum { COLUMNS = sizeof columns / sizeof *columns, SIZE0 = 1, MOMENT0 = 5, QW = 11 };

typedef struct reader {
  FILE *file;
  const char *path;
  nsdae_scene *scene;
  int room;            /* of scene->body and scene->solid */
  int line, header;    /* number of the line; whether the header was read */
  int given[SETTINGS]; /* whether the setting was */
  nsdae_error *error;
} reader;

/* "'PATH' line L, column C (KEY): TEXT"; column < 0: of the whole line. The end of a long path. */
static int refuse(reader *r, int column, const char *format, ...)
{
  char text[160], place[48] = "";
  size_t length = strlen(r->path), most = 60;
  va_list values;
  va_start(values, format);
  vsnprintf(text, sizeof text, format, values);
  va_end(values);
  if (column >= 0)
    snprintf(place, sizeof place, ", column %d (%s)", column + 1, columns[column].key);
  return nsdae_error_set(r->error, NSDAE_E_ARGUMENT, "nsdae_scene_read",
                         column >= 0 ? columns[column].key : "path", "'%s' line %d%s: %s",
                         r->path + (length > most ? length - most : 0), r->line, place, text);
}

/* Sets the field of one entry from text. */
static int set(reader *r, const nsdae_param *entry, int column, void *base, const char *word)
{
  const nsdae_params table = {entry, 1};
  nsdae_error error;
  if (nsdae_params_set(&table, base, entry->key, word, &error) == NSDAE_OK) return NSDAE_OK;
  return refuse(r, column, "%s", error.text);
}

/* ---- settings */

static int setting_of(const char *word)
{
  int i = 0;
  while (i < SETTINGS && strcmp(settings[i].key, word) != 0) i++;
  return i < SETTINGS ? i : -1;
}

/* One word of a setting line. *at: the setting that waits for its number, or -1. */
static int read_word(reader *r, const char *word, int *at)
{
  double number;
  int key = setting_of(word), status;
  if (key >= 0 && *at >= 0)
    return refuse(r, -1, "%s has no number before '%s'", settings[*at].key, word);
  if (key >= 0 && r->given[key]) return refuse(r, -1, "%s is given twice: leave one out", word);
  if (key >= 0) r->given[ *at = key] = 1;
  if (*at == WALLS && strcmp(word, "none") == 0) *at = -1;
  if (!nsdae_number_read(word, &number)) return NSDAE_OK;
  if (*at < 0) return refuse(r, -1, "the number %.32s belongs to no setting: leave it out", word);
  status = set(r, &settings[*at], -1, r->scene, word);
  *at = *at == WALLS ? WALLS + 1 : -1;
  return status;
}

/* Cuts the next word off; NULL at the end. */
static char *next_word(char **rest)
{
  char *word = *rest + strspn(*rest, blanks), *end = word + strcspn(word, blanks);
  *rest = *end ? end + 1 : end;
  *end = '\0';
  return *word ? word : NULL;
}

/* A line after its '#': settings if its first word is a key with a colon, else a comment. */
static int read_comment(reader *r, char *text)
{
  int at = -1, status = NSDAE_OK;
  text += strspn(text, " \t");
  if (text[strcspn(text, blanks)] != ':') return NSDAE_OK;
  char *word = next_word(&text);
  if (!word || setting_of(word) < 0) return NSDAE_OK;
  for (; word && status == NSDAE_OK; word = next_word(&text)) status = read_word(r, word, &at);
  if (status < 0 || at < 0) return status;
  return refuse(r, -1, "%s lacks a number: it needs %s", settings[at].key,
                at <= WALLS + 1 ? "two, or the word none" : "one");
}

/* ---- rows */

/* Cuts a line at its commas into COLUMNS fields without blanks around them. */
static int split(reader *r, char *text, char *field[COLUMNS])
{
  int count = 0;
  for (char *end = text; end; text = end + 1) {
    end = strchr(text, ',');
    if (end) *end = '\0';
    text += strspn(text, " \t\r");
    size_t length = strlen(text);
    while (length > 0 && strchr(" \t\r", text[length - 1])) text[--length] = '\0';
    if (count < COLUMNS) field[count] = text;
    count++;
    if (!end) break;
  }
  if (count == COLUMNS) return NSDAE_OK;
  return refuse(r, -1, "%d column%s: a line has %d, kind,size0,...,w3, with commas between them",
                count, count == 1 ? "" : "s", COLUMNS);
}

static int read_header(reader *r, char *const field[COLUMNS])
{
  for (int c = 0; c < COLUMNS; c++)
    if (strcmp(field[c], columns[c].key) != 0)
      return refuse(r, c, "'%.32s' in the header: it must be '%s'", field[c], columns[c].key);
  r->header = 1;
  return NSDAE_OK;
}

static int add(reader *r, const body_row *row)
{
  nsdae_scene *s = r->scene;
  if (s->bodies == r->room) {
    size_t room = r->room > 0 ? 2 * (size_t)r->room : 64;
    const nsdae_array both[] = {NSDAE_ARRAY(s->body, 1), NSDAE_ARRAY(s->solid, 1)};
    if (room > INT_MAX || nsdae_arrays_grow(both, 2, room) < 0)
      return nsdae_error_memory(r->error, "nsdae_scene_read");
    r->room = (int)room;
  }
  nsdae_solid solid = {.shape = shape_of[row->kind].shape, .material = 1};
  solid.points = shape_of[row->kind].corners;
  if (shape_of[row->kind].sizes == 2)
    solid.length[2] = row->size[1];
  else if (shape_of[row->kind].sizes == 3)
    memcpy(solid.length, row->size, sizeof solid.length);
  if (shape_of[row->kind].sizes < 3) solid.radius = row->size[0]; /* of corners: see add_corners */
  if (solid.shape == NSDAE_SHAPE_CONE) solid.position[2] = solid.length[2] / 4;
  s->body[s->bodies] = row->body;
  s->solid[s->bodies++] = solid;
  return NSDAE_OK;
}

static int read_row(reader *r, char *const field[COLUMNS])
{
  body_row row = {.kind = 0};
  int turned = 0;
  for (int c = 0; c < COLUMNS; c++) {
    if (strlen(field[c]) >= WORD_SIZE)
      return refuse(r, c, "more than %d characters: shorten it", WORD_SIZE - 1);
    int status = set(r, &columns[c], c, &row, field[c]);
    if (status < 0) return status;
  }
  for (int i = 0; i < 3; i++) {
    int used = i < shape_of[row.kind].sizes;
    if (used ? !(row.size[i] > 0) : row.size[i] != 0)
      return refuse(r, SIZE0 + i, "size%d = %g of a%s %s must be %s", i, row.size[i],
                    strchr("eio", kinds[row.kind][0]) ? "n" : "", kinds[row.kind],
                    used ? "greater than 0" : "0: it has no such size");
  }
  for (int i = 0; i < 3; i++) {
    const double *J = row.body.inertia, j = J[(i + 1) % 3], k = J[(i + 2) % 3];
    if (!nsdae_is_moment(J[i], j, k))
      return refuse(r, MOMENT0 + i, "I%d = %g of no body: it must be at most I%d + I%d = %g", i + 1,
                    J[i], 1 + (i + 1) % 3, 1 + (i + 2) % 3, j + k);
  }
  for (int i = 0; i < 4; i++) turned |= row.body.quaternion[i] != 0;
  if (!turned) return refuse(r, QW, "the quaternion is 0 0 0 0: 1 0 0 0 is no rotation");
  return add(r, &row);
}

/* ---- the file */

/* 1: a line is in text; 0: the end; < 0. */
static int next_line(reader *r, char text[LINE_SIZE])
{
  int length = 0, c;
  r->line++;
  while ((c = getc(r->file)) != EOF && c != '\n') {
    if (c == 0) return refuse(r, -1, "a NUL byte: the file must be text");
    if (length == LINE_SIZE - 1)
      return refuse(r, -1, "more than %d characters: shorten it", LINE_SIZE - 1);
    text[length++] = (char)c;
  }
  text[length] = '\0';
  if (ferror(r->file))
    return nsdae_error_set(r->error, NSDAE_E_IO, "nsdae_scene_read", "path",
                           "cannot read '%.90s': it must be a text file", r->path);
  return c != EOF || length > 0;
}

static int read_line(reader *r, char *text)
{
  char *field[COLUMNS];
  if (r->line == 1 && strncmp(text, "\xEF\xBB\xBF", 3) == 0) text += 3; /* byte order mark */
  text += strspn(text, " \t\r");
  if (*text == '#') return read_comment(r, text + 1);
  if (!*text) return NSDAE_OK;
  int status = split(r, text, field);
  if (status < 0) return status;
  return r->header ? read_row(r, field) : read_header(r, field);
}

/* All settings but the floor must be given: none is taken silently. */
static int check_complete(reader *r)
{
  r->line--;
  for (int i = 0; i < SETTINGS; i++)
    if (i != WALLS + 1 && i != FLOOR && !r->given[i])
      return refuse(r, -1, "the file ends without the setting %s: add a line '# %s: %s'",
                    settings[i].key, settings[i].key, i == WALLS ? "none" : "NUMBER");
  if (!(r->scene->wall[0] < r->scene->wall[1]))
    return refuse(r, -1, "walls at %g and %g: the first must be less", r->scene->wall[0],
                  r->scene->wall[1]);
  if (r->scene->bodies > 0) return NSDAE_OK;
  return refuse(r, -1, "the file ends without a body: add a row for each");
}

/* ---- regular polyhedra */

/* The corners of that number on a sphere about the origin: with g the golden ratio, cyclically,
 *
 *   tetrahedron    (+-1, +-1, +-1), their product 1   octahedron     (+-1, 0, 0)
 *   dodecahedron   (+-1, +-1, +-1), (0, +-1/g, +-g)   icosahedron    (0, +-1, +-g)            */
static void set_corners(int corners, double radius, double *x)
{
  const double g = (1 + sqrt(5)) / 2, first = corners == 20 ? 1 / g : corners == 12;
  int n = 0;
  for (int i = 0; i < 8 && (corners == 4 || corners == 20); i++)
    for (int j = 0; j < 3 && (corners == 20 || i == 0 || i == 3 || i == 5 || i == 6); j++)
      x[n++] = i >> j & 1 ? -1 : 1;
  for (int i = 0; n < 3 * corners; i++) { /* an axis, two signs */
    int axis = i / 4, one = corners == 6;
    if (one && i % 2) continue;
    x[n + axis] = 0;
    x[n + (axis + 1) % 3] = (i & 1 ? -1 : 1) * first;
    x[n + (axis + 2) % 3] = (i & 2 ? -1 : 1) * (one ? 1 : g);
    n += 3;
  }
  double length = sqrt(nsdae_dot3(x, x));
  for (int i = 0; i < n; i++) x[i] *= radius / length;
}

/* Behind the solids, in one piece with them. */
static int add_corners(reader *r)
{
  nsdae_scene *s = r->scene;
  size_t points = 0;
  for (int i = 0; i < s->bodies; i++) points += (size_t)s->solid[i].points;
  if (points == 0) return NSDAE_OK;
  nsdae_solid *solid =
      realloc(s->solid, (size_t)s->bodies * sizeof *solid + 3 * points * sizeof *solid->point);
  if (!solid) return nsdae_error_memory(r->error, "nsdae_scene_read");
  s->solid = solid;
  double *at = (double *)(solid + s->bodies);
  for (int i = 0; i < s->bodies; i++) {
    if (solid[i].points == 0) continue;
    set_corners(solid[i].points, solid[i].radius, at);
    solid[i].radius = 0;
    solid[i].point = at;
    at += 3 * solid[i].points;
  }
  return NSDAE_OK;
}

int nsdae_scene_read(const char *path, nsdae_scene *scene, nsdae_error *error)
{
  const nsdae_params table = {settings, SETTINGS};
  char text[LINE_SIZE];
  nsdae_error_clear(error);
  if (!path || !scene) return nsdae_error_null(error, "nsdae_scene_read", path ? "scene" : "path");
  *scene = (nsdae_scene){.bodies = 0};
  nsdae_params_default(&table, scene);
  const char *why;
  reader r = {.file = nsdae_regular_file(path, &why), .path = path, .scene = scene, .error = error};
  if (!r.file)
    return nsdae_error_set(error, NSDAE_E_IO, "nsdae_scene_read", "path", "cannot read '%.90s': %s",
                           path, why);
  int status;
  while ((status = next_line(&r, text)) > 0 && (status = read_line(&r, text)) == NSDAE_OK) continue;
  if (status == 0) status = check_complete(&r);
  if (status == 0) status = add_corners(&r);
  fclose(r.file);
  if (status < 0) nsdae_scene_release(scene);
  return status;
}

void nsdae_scene_release(nsdae_scene *scene)
{
  if (!scene) return;
  free(scene->body);
  free(scene->solid);
  *scene = (nsdae_scene){.bodies = 0};
}

/* ---- a scene as a mechanism */

/* A half-space of the ground whose normal is along `axis`, towards `sign`. */
static void add_plane(nsdae_bodies *b, int axis, double sign, double at)
{
  const double half = sqrt(0.5);
  nsdae_solid plane = {.shape = NSDAE_SHAPE_PLANE, .quaternion = {half}};
  if (!isfinite(at)) return; /* no wall */
  plane.position[axis] = at;
  /* by 90 degrees about y, z comes to x; by -90 degrees about x, to y */
  if (axis == 0) plane.quaternion[2] = sign * half;
  if (axis == 1) plane.quaternion[1] = -sign * half;
  if (axis == 2) plane.quaternion[0] = 1;
  nsdae_bodies_add_solid(b, NSDAE_GROUND, &plane);
}

/* The bounds of a file hold for a struct, and an infinite wall is none. */
static int check_scene(nsdae_bodies *b, const nsdae_scene *s)
{
  const nsdae_params table = {settings + FLOOR, SETTINGS - FLOOR};
  const char *where = "nsdae_bodies_add_scene", *missing = s->body ? "solid" : "body";
  if (b->dimension == 2)
    return nsdae_error_set(&b->error, NSDAE_E_ARGUMENT, where, "dimension",
                           "dimension = 2: a scene needs a model of dimension 3");
  if (s->bodies < 0)
    return nsdae_error_set(&b->error, NSDAE_E_ARGUMENT, where, "bodies",
                           "bodies = %d must be at least 0", s->bodies);
  if (s->bodies > 0 && !(s->body && s->solid)) return nsdae_error_null(&b->error, where, missing);
  if (!(s->wall[0] < s->wall[1]))
    return nsdae_error_set(&b->error, NSDAE_E_ARGUMENT, where, "wall",
                           "wall[0] = %g must be below wall[1] = %g; -INFINITY, INFINITY: none",
                           s->wall[0], s->wall[1]);
  return nsdae_params_check(&table, s, &b->error);
}

int nsdae_bodies_add_scene(nsdae_bodies *b, const nsdae_scene *s)
{
  int status = nsdae_bodies_open(b, s, "scene");
  if (status == NSDAE_OK) status = check_scene(b, s);
  if (status < 0) return status;
  nsdae_bodies_set_gravity(b, (const double[]){0, 0, -s->g});
  add_plane(b, 2, 1, s->floor);
  for (int axis = 0; axis < 2; axis++)
    for (int i = 0; i < 2; i++) add_plane(b, axis, i ? -1 : 1, s->wall[i]);
  for (int i = 0; i < s->bodies; i++)
    nsdae_bodies_add_solid(b, nsdae_bodies_add(b, &s->body[i]), &s->solid[i]);
  for (int i = 0; i < 2; i++) nsdae_bodies_set_pair(b, i, 1, s->mu, s->e_n, 0);
  return b->error.status;
}
