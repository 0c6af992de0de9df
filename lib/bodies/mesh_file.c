/* Mesh files: triangles of Wavefront OBJ and of STL as a MESH.
 *
 *   OBJ         line*   'v' x y z ...   |   'f' corner corner corner+   |   anything else
 *               corner  i ['/' ...], a point's number from 1, or < 0: -1 is the last point so far
 *               A polygon is a fan of triangles about its first corner.
 *   STL text    ('solid' NAME  facet*  'endsolid' NAME)+
 *               facet   'facet normal' a b c 'outer loop' ('vertex' x y z){3} 'endloop endfacet'
 *   STL binary  80 bytes, uint32 n, n times: normal and three corners as 12 float32, 2 bytes;
 *               least significant byte first. A file of exactly 84 + 50 n bytes is binary.
 *
 * Sources: Wavefront Technologies, Advanced Visualizer Manual, appendix B1; M. Burns, Automated
 * Fabrication, 1993, 6.5. Normals of files are not used: the order of the corners is. */
#include <ctype.h>
#include <limits.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "errors.h"
#include "mesh.h"
#include "regular_file.h"
#include "space.h"
#include "words.h"

/* A number of 17 digits with sign and exponent has 24 characters. */
enum { WORD_SIZE = 64 };

static const char where[] = "nsdae_solid_read", byte_order_mark[] = "\xEF\xBB\xBF";

typedef struct reader {
  FILE *file;
  const char *path;
  double scale;
  double *point;                  /* points x 3 */
  int *triangle;                  /* triangles x 3 */
  int points, triangles, room[2]; /* room: of both */
  long line;                      /* 0: of a binary file */
  int last;                       /* character that ended the word */
  char word[WORD_SIZE];
  nsdae_error *error;
} reader;

/* "'PATH' line L: TEXT". The end of a long path. */
static int refuse(reader *r, int status, const char *format, ...)
{
  char text[200], place[32] = "";
  size_t length = strlen(r->path), most = 60;
  va_list values;
  va_start(values, format);
  vsnprintf(text, sizeof text, format, values);
  va_end(values);
  if (r->line > 0) snprintf(place, sizeof place, " line %ld", r->line);
  return nsdae_error_set(r->error, status, where, "path", "'%s'%s: %s",
                         r->path + (length > most ? length - most : 0), place, text);
}

/* ---- points and triangles */

/* Room for one more entry of three numbers. */
static int make_room(reader *r, nsdae_array array, int count, int *room, int most)
{
  if (count < *room) return NSDAE_OK;
  if (count == most)
    return refuse(r, NSDAE_E_ARGUMENT, "more than %d points or %d triangles: use a coarser mesh",
                  3 * NSDAE_TRIANGLES_MAX, NSDAE_TRIANGLES_MAX);
  int next = count == 0 ? 1024 : count > most / 2 ? most : 2 * count;
  if (nsdae_arrays_grow(&array, 1, (size_t)next) < 0) return nsdae_error_memory(r->error, where);
  *room = next;
  return NSDAE_OK;
}

static int add_point(reader *r, const double *x)
{
  const nsdae_array array = NSDAE_ARRAY(r->point, 3);
  int status = make_room(r, array, r->points, &r->room[0], 3 * NSDAE_TRIANGLES_MAX);
  for (int j = 0; j < 3 && status == NSDAE_OK; j++) {
    double scaled = r->scale * x[j];
    if (!isfinite(scaled))
      return refuse(r, NSDAE_E_NONFINITE, "point %d is at %g x %g, which is not a finite number",
                    r->points, r->scale, x[j]);
    r->point[3L * r->points + j] = scaled;
  }
  if (status == NSDAE_OK) r->points++;
  return status;
}

static int add_triangle(reader *r, int a, int b, int c)
{
  const nsdae_array array = NSDAE_ARRAY(r->triangle, 3);
  int status = make_room(r, array, r->triangles, &r->room[1], NSDAE_TRIANGLES_MAX);
  if (status < 0) return status;
  int *corner = r->triangle + 3L * r->triangles++;
  corner[0] = a;
  corner[1] = b;
  corner[2] = c;
  return NSDAE_OK;
}

/* ---- words */

static int is_end(int c)
{
  return c == '\n' || c == EOF;
}

static void skip_line(reader *r)
{
  while (!is_end(r->last)) r->last = getc(r->file);
}

/* The next word of the line, which is empty at its end; it is cut to WORD_SIZE - 1 characters.
 * Comments and ends of lines behind a backslash are blanks. */
static void next_word(reader *r)
{
  int length = 0, c = r->last;
  while (!is_end(c)) {
    c = getc(r->file);
    if (c == '\\') {
      int next = getc(r->file);
      if (next == '\r') next = getc(r->file);
      if (next == '\n') {
        r->line++;
        c = ' ';
      } else {
        ungetc(next, r->file);
      }
    }
    if (c == '#' && length == 0)
      while (!is_end(c)) c = getc(r->file);
    if (c == EOF || isspace(c)) {
      if (length > 0) break;
    } else if (length < WORD_SIZE - 1) {
      r->word[length++] = c ? (char)c : '?'; /* a NUL byte ends no number */
    }
  }
  r->last = c;
  r->word[length] = '\0';
}

/* Begins the next line; 0: there is none. */
static int next_line(reader *r)
{
  if (r->last == EOF) return 0;
  r->last = ' ';
  r->line++;
  return 1;
}

/* The next word of the file; empty: its end. */
static void next_word_of_file(reader *r)
{
  for (next_word(r); !r->word[0] && next_line(r);) next_word(r);
}

static int is_word(const char *word, const char *name)
{
  while (*word && tolower((unsigned char)*word) == *name) word++, name++;
  return *word == *name;
}

static int read_number(reader *r, double *x)
{
  if (strlen(r->word) < WORD_SIZE - 1 && nsdae_number_read(r->word, x)) return NSDAE_OK;
  return refuse(r, NSDAE_E_ARGUMENT, "'%.40s' instead of a coordinate", r->word);
}

/* ---- OBJ */

static int read_obj_point(reader *r)
{
  double x[3];
  for (int j = 0; j < 3; j++) {
    next_word(r);
    int status = read_number(r, &x[j]);
    if (status < 0) return status;
  }
  return add_point(r, x);
}

/* The word as a corner. */
static int read_corner(reader *r, int *point)
{
  char *end;
  long i = strtol(r->word, &end, 10);
  if (end == r->word || (*end && *end != '/') || i == 0 || i > r->points || i < -r->points)
    return refuse(r, NSDAE_E_ARGUMENT,
                  "corner '%.40s' of a face: there are %d points so far, 1 .. %d or -1 .. -%d",
                  r->word, r->points, r->points, r->points);
  *point = (int)(i > 0 ? i - 1 : r->points + i);
  return NSDAE_OK;
}

/* Twice the area of a triangle as a vector. */
static void cross_of(const reader *r, const int *corner, double *cross)
{
  const double *a = r->point + 3L * corner[0], *b = r->point + 3L * corner[1];
  const double *c = r->point + 3L * corner[2];
  const double u[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]};
  const double v[3] = {c[0] - a[0], c[1] - a[1], c[2] - a[2]};
  nsdae_cross3(u, v, cross);
}

/* A fan covers a polygon once if no triangle is turned against their sum (M. E. Newell). */
static int check_fan(reader *r, int first)
{
  double sum[3] = {0, 0, 0}, one[3];
  for (int t = first; t < r->triangles; t++) {
    cross_of(r, r->triangle + 3L * t, one);
    for (int j = 0; j < 3; j++) sum[j] += one[j];
  }
  for (int t = first; t < r->triangles; t++) {
    cross_of(r, r->triangle + 3L * t, one);
    if (nsdae_dot3(one, sum) < 0)
      return refuse(r, NSDAE_E_ARGUMENT,
                    "a face of %d corners is not convex: export the mesh as triangles",
                    r->triangles - first + 2);
  }
  return NSDAE_OK;
}

static int read_obj_face(reader *r)
{
  int corner[3] = {0}, count = 0, first = r->triangles;
  for (next_word(r); r->word[0]; next_word(r)) {
    corner[1] = corner[2];
    int status = read_corner(r, &corner[count == 0 ? 0 : 2]);
    if (status == NSDAE_OK && ++count >= 3)
      status = add_triangle(r, corner[0], corner[1], corner[2]);
    if (status < 0) return status;
  }
  if (count >= 3) return check_fan(r, first);
  return refuse(r, NSDAE_E_ARGUMENT, "a face of %d corners: it has at least 3", count);
}

static int read_obj(reader *r)
{
  int status = NSDAE_OK;
  while (status == NSDAE_OK && next_line(r)) {
    next_word(r);
    if (r->line == 1 && strncmp(r->word, byte_order_mark, 3) == 0)
      memmove(r->word, r->word + 3, WORD_SIZE - 3);
    if (!r->word[0]) next_word(r); /* blanks behind the mark */
    if (strcmp(r->word, "v") == 0) status = read_obj_point(r);
    if (strcmp(r->word, "f") == 0) status = read_obj_face(r);
    if (status == NSDAE_OK) skip_line(r);
  }
  return status;
}

/* ---- STL */

static int read_facet(reader *r)
{
  static const char *const words[] = {
      "facet",  "normal", NULL, NULL, NULL,     "outer", "loop", "vertex", "",        "",        "",
      "vertex", "",       "",   "",   "vertex", "",      "",     "",       "endloop", "endfacet"};
  double x[9];
  int count = 0, status = NSDAE_OK;
  for (size_t i = 0; i < sizeof words / sizeof *words && status == NSDAE_OK; i++) {
    if (i > 0) next_word_of_file(r);
    if (!words[i]) continue;
    if (!words[i][0])
      status = read_number(r, &x[count++]);
    else if (!is_word(r->word, words[i]))
      status = refuse(r, NSDAE_E_ARGUMENT, "'%.40s' instead of '%s' in triangle %d", r->word,
                      words[i], r->triangles);
  }
  for (int k = 0; k < 3 && status == NSDAE_OK; k++) status = add_point(r, x + 3 * k);
  int n = r->points;
  return status < 0 ? status : add_triangle(r, n - 3, n - 2, n - 1);
}

static int read_stl_text(reader *r)
{
  int status = NSDAE_OK, inside = 0;
  for (next_word_of_file(r); r->word[0] && status == NSDAE_OK; next_word_of_file(r)) {
    int ends = inside && is_word(r->word, "endsolid");
    if (ends || (!inside && is_word(r->word, "solid"))) {
      inside = !inside;
      skip_line(r);
    } else if (inside) {
      status = read_facet(r);
    } else {
      status = refuse(r, NSDAE_E_ARGUMENT, "'%.40s' instead of 'solid'", r->word);
    }
  }
  if (status == NSDAE_OK && inside)
    status = refuse(r, NSDAE_E_ARGUMENT, "the file ends before 'endsolid': is it cut off?");
  return status;
}

static uint32_t word_of(const unsigned char *byte)
{
  return (uint32_t)byte[0] | (uint32_t)byte[1] << 8 | (uint32_t)byte[2] << 16 |
         (uint32_t)byte[3] << 24;
}

static int read_stl_binary(reader *r, uint32_t count)
{
  unsigned char byte[50];
  for (uint32_t i = 0; i < count; i++) {
    if (fread(byte, 1, sizeof byte, r->file) != sizeof byte)
      return refuse(r, NSDAE_E_IO, "the file ends within triangle %d", r->triangles);
    for (int k = 0; k < 3; k++) {
      double x[3];
      for (int j = 0; j < 3; j++) {
        uint32_t bits = word_of(byte + 12 + 12 * k + 4 * j);
        float value;
        memcpy(&value, &bits, sizeof value);
        x[j] = value;
      }
      int status = add_point(r, x);
      if (status < 0) return status;
    }
    int n = r->points, status = add_triangle(r, n - 3, n - 2, n - 1);
    if (status < 0) return status;
  }
  return NSDAE_OK;
}

static int read_stl(reader *r)
{
  unsigned char head[84] = {0};
  size_t got = fread(head, 1, sizeof head, r->file);
  uint32_t count = word_of(head + 80);
  long size = fseek(r->file, 0, SEEK_END) == 0 ? ftell(r->file) : -1;
  int binary = got == sizeof head && (uint64_t)size == 84 + 50 * (uint64_t)count;
  if (size < 0 || fseek(r->file, binary ? (long)sizeof head : 0, SEEK_SET) != 0)
    return refuse(r, NSDAE_E_IO, "cannot read it: it must be a regular file");
  if (binary) return read_stl_binary(r, count);
  size_t start = 0;
  while (start < got && isspace(head[start])) start++;
  char first[6] = "";
  for (size_t i = 0; i < 5 && start + i < got; i++) first[i] = (char)head[start + i];
  if (!is_word(first, "solid"))
    return refuse(r, NSDAE_E_ARGUMENT,
                  "%ld bytes are no STL file: one of text begins with 'solid', a binary one of %lu "
                  "triangles has %llu bytes",
                  size, (unsigned long)count, 84 + 50 * (unsigned long long)count);
  next_line(r);
  return read_stl_text(r);
}

/* ---- files */

/* Points in the same place become one, as of the mesh of the ground, which checks them. Points of
 * no triangle are left out. */
static int weld_surface(reader *r)
{
  const double same[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1}, zero[3] = {0, 0, 0};
  const nsdae_solid solid = {.shape = NSDAE_SHAPE_MESH,
                             .points = r->points,
                             .point = r->point,
                             .triangles = r->triangles,
                             .triangle = r->triangle};
  nsdae_surface surface;
  const nsdae_mesh *mesh = NULL;
  nsdae_error error;
  int count = 0, status = nsdae_surface_of(&solid, &surface, &error);
  if (status == NSDAE_OK) status = nsdae_mesh_create(&surface, 1, same, zero, &mesh, &error);
  int *number = status < 0 ? NULL : calloc((size_t)r->points, sizeof *number);
  if (status == NSDAE_E_MEMORY || (status == NSDAE_OK && !number))
    status = nsdae_error_memory(r->error, where);
  else if (status < 0)
    status = refuse(r, status, "%s", error.text);
  for (long i = 0; status == NSDAE_OK && i < 3L * r->triangles; i++)
    number[mesh->corner[i / 3][i % 3]] = 1;
  for (long i = 0; status == NSDAE_OK && i < r->points; i++) {
    if (!number[i]) continue;
    memmove(r->point + 3L * count, r->point + 3 * i, 3 * sizeof *r->point);
    number[i] = count++;
  }
  for (long i = 0; status == NSDAE_OK && i < 3L * r->triangles; i++)
    r->triangle[i] = number[mesh->corner[i / 3][i % 3]];
  if (status == NSDAE_OK) r->points = count;
  free(number);
  nsdae_mesh_release(mesh);
  return status;
}

static int check_arguments(const char *path, double scale, const nsdae_solid *solid,
                           nsdae_error *error)
{
  if (!path || !solid) return nsdae_error_null(error, where, path ? "solid" : "path");
  if (scale > 0 && isfinite(scale)) return NSDAE_OK;
  return nsdae_error_set(error, NSDAE_E_ARGUMENT, where, "scale",
                         "scale = %g must be a finite number > 0: metres in a unit of the file, "
                         "0.001 for millimetres",
                         scale);
}

static int read_file(reader *r)
{
  const char *dot = strrchr(r->path, '.');
  int obj = dot && is_word(dot, ".obj"), stl = dot && is_word(dot, ".stl");
  if (!obj && !stl) return refuse(r, NSDAE_E_ARGUMENT, "the name must end in .obj or .stl");
  const char *why;
  r->file = nsdae_regular_file(r->path, &why);
  if (!r->file) return refuse(r, NSDAE_E_IO, "cannot read it: %s", why);
  int status = obj ? read_obj(r) : read_stl(r);
  if (ferror(r->file)) status = refuse(r, NSDAE_E_IO, "cannot read it: it must be a regular file");
  fclose(r->file);
  if (status < 0) return status;
  r->line = 0;
  if (r->triangles == 0) return refuse(r, NSDAE_E_ARGUMENT, "the file has no triangles");
  return weld_surface(r);
}

int nsdae_solid_read(const char *path, double scale, nsdae_solid *solid, nsdae_error *error)
{
  nsdae_error_clear(error);
  if (solid) *solid = (nsdae_solid){.shape = NSDAE_SHAPE_MESH};
  int status = check_arguments(path, scale, solid, error);
  if (status < 0) return status;
  reader r = {.path = path, .scale = scale, .last = '\n', .error = error};
  status = read_file(&r);
  if (status < 0) {
    free(r.point);
    free(r.triangle);
    return status;
  }
  solid->points = r.points;
  solid->point = r.point;
  solid->triangles = r.triangles;
  solid->triangle = r.triangle;
  return NSDAE_OK;
}

void nsdae_solid_release(nsdae_solid *solid)
{
  if (!solid) return;
  free((void *)(uintptr_t)solid->point);
  free((void *)(uintptr_t)solid->triangle);
  *solid = (nsdae_solid){.shape = NSDAE_SHAPE_MESH};
}
