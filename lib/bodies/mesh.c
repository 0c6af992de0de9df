/* Meshes: what is connected with what, faces, sharp edges and corners, and the tree of boxes. The
 * tree is a complete binary one over the triangles in Morton order (C. Lauterbach et al., Fast BVH
 * construction on GPUs, Eurographics 2009): one sort, no pointers. */
#include "mesh.h"

#include <float.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "disjoint_sets.h"
#include "errors.h"

static const char where[] = "nsdae_solid";

/* Triangles in a leaf of the tree. */
enum { LEAF = 4 };

/* In parts of the largest coordinate: of files with numbers of single precision, 2^-24 of each
 * coordinate; and the least height of a triangle, whose normal then is known to 1e-6, the slack of
 * contacts (separating_axis.h): DBL_EPSILON / 1e-6. */
static const double single_precision = 1.2e-7, least_height = 2.2e-10;

/* ---- triangles */

static int check_surface(const nsdae_surface *s, nsdae_error *error)
{
  if (s->points < 3 || s->points > 3 * NSDAE_TRIANGLES_MAX || !s->point || s->triangles < 1 ||
      s->triangles > NSDAE_TRIANGLES_MAX || !s->triangle)
    return nsdae_error_set(error, NSDAE_E_ARGUMENT, where, "triangles",
                           "a mesh of %d points and %d triangles: it must have 3 .. %d points "
                           "and 1 .. %d triangles, none of them NULL",
                           s->points, s->triangles, 3 * NSDAE_TRIANGLES_MAX, NSDAE_TRIANGLES_MAX);
  for (long i = 0; i < 3L * s->points; i++)
    if (!isfinite(s->point[i]))
      return nsdae_error_set(error, NSDAE_E_NONFINITE, where, "point",
                             "point %ld of the mesh is at %g, which is not a finite number", i / 3,
                             s->point[i]);
  for (long i = 0; i < 3L * s->triangles; i++)
    if (s->triangle[i] < 0 || s->triangle[i] >= s->points)
      return nsdae_error_set(error, NSDAE_E_ARGUMENT, where, "triangle",
                             "corner %ld of triangle %ld is point %d: there are %d, from 0", i % 3,
                             i / 3, s->triangle[i], s->points);
  return NSDAE_OK;
}

/* The surface of a grid of heights. */
static int make_grid(const nsdae_solid *s, nsdae_surface *made, nsdae_error *error)
{
  const int *n = s->grid;
  if (n[0] < 2 || n[1] < 2 || !s->point || n[0] > NSDAE_TRIANGLES_MAX / 2 / n[1])
    return nsdae_error_set(error, NSDAE_E_ARGUMENT, where, "grid",
                           "grid = %d x %d of a height field is less than 2 x 2 or has more than "
                           "%d heights, or point is NULL",
                           n[0], n[1], NSDAE_TRIANGLES_MAX / 2);
  made->points = n[0] * n[1];
  made->triangles = 2 * (n[0] - 1) * (n[1] - 1);
  size_t numbers = 3 * (size_t)made->points, corners = 3 * (size_t)made->triangles;
  made->memory = malloc(numbers * sizeof(double) + corners * sizeof(int));
  if (!made->memory) return nsdae_error_memory(error, where);
  double *x = made->memory;
  int *c = (int *)(void *)(x + numbers);
  made->point = x;
  made->triangle = c;
  for (int j = 0; j < n[1]; j++)
    for (int i = 0; i < n[0]; i++) {
      int p = j * n[0] + i;
      *x++ = s->length[0] * ((double)i / (n[0] - 1) - 0.5);
      *x++ = s->length[1] * ((double)j / (n[1] - 1) - 0.5);
      *x++ = s->point[p];
      if (i + 1 == n[0] || j + 1 == n[1]) continue;
      const int two[6] = {p, p + 1, p + n[0] + 1, p, p + n[0] + 1, p + n[0]};
      memcpy(c, two, sizeof two);
      c += 6;
    }
  return NSDAE_OK;
}

int nsdae_surface_of(const nsdae_solid *s, nsdae_surface *made, nsdae_error *error)
{
  *made = (nsdae_surface){s->points, s->triangles, s->point, s->triangle, NULL};
  int status = s->shape == NSDAE_SHAPE_MESH ? NSDAE_OK : make_grid(s, made, error);
  return status < 0 ? status : check_surface(made, error);
}

void nsdae_surface_release(nsdae_surface *surface)
{
  free(surface->memory);
}

typedef struct place {
  double x[3];
  int i;
} place;

static int by_place(const void *a, const void *b)
{
  const place *p = a, *q = b;
  for (int j = 0; j < 3; j++)
    if (p->x[j] != q->x[j]) return p->x[j] < q->x[j] ? -1 : 1;
  return p->i - q->i;
}

/* Points in the same place are one: corners have the first of them. 0: no memory. */
static int weld(nsdae_mesh *m)
{
  place *at = malloc((size_t)m->points * sizeof *at);
  int *first = malloc((size_t)m->points * sizeof *first);
  for (int i = 0; at && i < m->points; i++) {
    memcpy(at[i].x, m->point + 3 * (size_t)i, sizeof at[i].x);
    at[i].i = i;
  }
  if (at && first) {
    qsort(at, (size_t)m->points, sizeof *at, by_place);
    for (int i = 0, start = 0; i < m->points; i++) {
      for (int j = 0; j < 3; j++)
        if (at[i].x[j] != at[start].x[j]) start = i;
      first[at[i].i] = at[start].i;
    }
    for (int t = 0; t < m->triangles; t++)
      for (int k = 0; k < 3; k++) m->corner[t][k] = first[m->corner[t][k]];
  }
  int done = at && first;
  free(at);
  free(first);
  return done;
}

/* Normals; rounding and flat by the largest coordinate. */
static int measure(nsdae_mesh *m, nsdae_error *error)
{
  double most = 0;
  for (long i = 0; i < 3L * m->points; i++) most = fmax(most, fabs(m->point[i]));
  m->rounding = 64 * DBL_EPSILON * most;
  m->flat = single_precision * most;
  for (int t = 0; t < m->triangles; t++) {
    double e[3][3], n[3], longest = 0;
    for (int k = 0; k < 3; k++) {
      for (int j = 0; j < 3; j++)
        e[k][j] = nsdae_mesh_corner(m, t, k + 1)[j] - nsdae_mesh_corner(m, t, k)[j];
      longest = fmax(longest, sqrt(nsdae_dot3(e[k], e[k])));
    }
    nsdae_cross3(e[0], e[1], n);
    double area = sqrt(nsdae_dot3(n, n));
    if (!(area > least_height * most * longest) || !nsdae_unit_vector(n, m->normal + 3L * t))
      return nsdae_error_set(error, NSDAE_E_ARGUMENT, where, "triangle",
                             "triangle %d (points %d, %d, %d) has no area, or coordinates whose "
                             "squares overflow: leave it out, or change the unit of length",
                             t, m->corner[t][0], m->corner[t][1], m->corner[t][2]);
  }
  return NSDAE_OK;
}

/* ---- neighbours */

typedef struct side {
  int low, high, at; /* points; 3 triangle + k */
} side;

static int by_points(const void *a, const void *b)
{
  const side *s = a, *t = b;
  if (s->low != t->low) return s->low < t->low ? -1 : 1;
  if (s->high != t->high) return s->high < t->high ? -1 : 1;
  return s->at - t->at;
}

/* How far the third corner of the triangle across side k is above a triangle's plane. */
static double rise(const nsdae_mesh *m, int t, int k)
{
  int other = m->beside[t][k];
  const double *a = nsdae_mesh_corner(m, t, k), *n = m->normal + 3L * t;
  double most = 0;
  for (int j = 0; j < 3; j++) {
    const double *x = nsdae_mesh_corner(m, other, j);
    const double d[3] = {x[0] - a[0], x[1] - a[1], x[2] - a[2]};
    double height = nsdae_dot3(n, d);
    if (fabs(height) > fabs(most)) most = height;
  }
  return most;
}

/* The sides in order, of which those of one edge follow each other; two of opposite directions are
 * neighbours. NULL: no memory. */
static side *sort_sides(nsdae_mesh *m)
{
  int count = 3 * m->triangles;
  side *s = malloc((size_t)count * sizeof *s);
  if (!s) return NULL;
  for (int i = 0; i < count; i++) {
    int a = m->corner[i / 3][i % 3], b = m->corner[i / 3][(i + 1) % 3];
    s[i] = (side){a < b ? a : b, a < b ? b : a, i};
    m->beside[i / 3][i % 3] = -1;
  }
  qsort(s, (size_t)count, sizeof *s, by_points);
  for (int i = 0, next; i < count; i = next) {
    for (next = i + 1; next < count && s[next].low == s[i].low && s[next].high == s[i].high;)
      next++;
    int t = s[i].at / 3, k = s[i].at % 3, u = s[next - 1].at / 3, l = s[next - 1].at % 3;
    if (next - i != 2) continue;
    if (m->corner[t][k] == m->corner[u][l]) {
      m->turned[0] = t;
      m->turned[1] = u;
      continue;
    }
    m->beside[t][k] = u;
    m->beside[u][l] = t;
  }
  return s;
}

/* Faces grow from their first triangles, as far as all corners are in its plane. todo: triangles.
 */
static void grow_faces(nsdae_mesh *m, int *todo)
{
  for (int t = 0; t < m->triangles; t++) m->face[t] = -1;
  for (int first = 0; first < m->triangles; first++) {
    const double *n = m->normal + 3L * first, *o = nsdae_mesh_corner(m, first, 0);
    int count = 0;
    if (m->face[first] >= 0) continue;
    m->face[first] = first;
    todo[count++] = first;
    while (count > 0) {
      const int *beside = m->beside[todo[--count]];
      for (int k = 0; k < 3; k++) {
        int t = beside[k], within = t >= 0 && m->face[t] < 0;
        /* a sliver across the plane is no part of it */
        within = within && nsdae_dot3(n, m->normal + 3L * t) > 0.5;
        for (int j = 0; j < 3 && within; j++) {
          const double *x = nsdae_mesh_corner(m, t, j);
          const double d[3] = {x[0] - o[0], x[1] - o[1], x[2] - o[2]};
          within = fabs(nsdae_dot3(n, d)) <= m->flat;
        }
        if (!within) continue;
        m->face[t] = first;
        todo[count++] = t;
      }
    }
  }
}

/* Valleys, and what is sharp: edges of one triangle, of several, and convex ones; their ends. */
static void mark_sharp(nsdae_mesh *m, const side *s, char *sharp)
{
  int count = 3 * m->triangles;
  for (int i = 0, next; i < count; i = next) {
    for (next = i + 1; next < count && s[next].low == s[i].low && s[next].high == s[i].high;)
      next++;
    int t = s[i].at / 3, k = s[i].at % 3, u = s[next - 1].at / 3, l = s[next - 1].at % 3;
    if (m->beside[t][k] >= 0) {
      if (m->face[t] == m->face[u]) continue;
      if (rise(m, t, k) > 0) {
        m->mark[t] |= (unsigned short)(NSDAE_VALLEY << k);
        m->mark[u] |= (unsigned short)(NSDAE_VALLEY << l);
        continue;
      }
    }
    m->mark[t] |= (unsigned short)(NSDAE_SHARP_SIDE << k);
    sharp[s[i].low] = sharp[s[i].high] = 1;
  }
  for (int i = 0; i < count; i++) {
    int p = m->corner[i / 3][i % 3];
    if (sharp[p]) m->mark[i / 3] |= (unsigned short)(NSDAE_SHARP_CORNER << i % 3);
    sharp[p] = 0;
  }
}

static void find_pieces(nsdae_mesh *m)
{
  nsdae_sets_begin(m->piece, m->points);
  for (int t = 0; t < m->triangles; t++)
    for (int k = 1; k < 3; k++) nsdae_sets_join(m->piece, m->corner[t][0], m->corner[t][k]);
  for (int i = 0; i < m->points; i++) m->piece[i] = nsdae_sets_root(m->piece, i);
}

static int connect(nsdae_mesh *m)
{
  side *s = sort_sides(m);
  int *todo = malloc((size_t)m->triangles * sizeof *todo);
  char *sharp = calloc((size_t)m->points, sizeof *sharp);
  int done = s && todo && sharp;
  if (done) {
    grow_faces(m, todo);
    mark_sharp(m, s, sharp);
    find_pieces(m);
  }
  free(s);
  free(todo);
  free(sharp);
  return done;
}

/* ---- the tree */

typedef struct key {
  uint64_t code;
  int t;
} key;

static int by_code(const void *a, const void *b)
{
  const key *k = a, *l = b;
  if (k->code != l->code) return k->code < l->code ? -1 : 1;
  return k->t - l->t;
}

/* The box of a triangle and of what is beneath it. */
static void add_to_box(const nsdae_mesh *m, int t, double *box)
{
  for (int k = 0; k < 3; k++)
    for (int j = 0; j < 3; j++) {
      double x = nsdae_mesh_corner(m, t, k)[j], y = x - m->thickness * m->normal[3L * t + j];
      box[j] = fmin(box[j], fmin(x, y));
      box[3 + j] = fmax(box[3 + j], fmax(x, y));
    }
}

static void clear_box(double *box)
{
  for (int j = 0; j < 6; j++) box[j] = j < 3 ? INFINITY : -INFINITY;
}

/* Morton codes: 21 bits of each coordinate of the centroid, one of each axis in turn. */
static int sort_triangles(nsdae_mesh *m)
{
  key *keys = malloc((size_t)m->triangles * sizeof *keys);
  double all[6], wide = 0;
  if (!keys) return 0;
  clear_box(all);
  for (int t = 0; t < m->triangles; t++) add_to_box(m, t, all);
  for (int j = 0; j < 3; j++) wide = fmax(wide, all[3 + j] - all[j]);
  for (int t = 0; t < m->triangles; t++) {
    keys[t] = (key){0, t};
    for (int j = 0; j < 3; j++) {
      double x = 0;
      for (int k = 0; k < 3; k++) x += (nsdae_mesh_corner(m, t, k)[j] - all[j]) / 3;
      uint32_t cell = (uint32_t)(x / wide * ((1 << 21) - 1));
      for (int bit = 0; bit < 21; bit++)
        keys[t].code |= (uint64_t)(cell >> bit & 1) << (3 * bit + j);
    }
  }
  qsort(keys, (size_t)m->triangles, sizeof *keys, by_code);
  for (int t = 0; t < m->triangles; t++) m->order[t] = keys[t].t;
  free(keys);
  return 1;
}

static void build_tree(nsdae_mesh *m)
{
  for (int node = 2 * m->leaves - 2; node >= 0; node--) {
    double *box = m->box + 6L * node;
    int from = (node - m->leaves + 1) * LEAF;
    clear_box(box);
    for (int i = from; node >= m->leaves - 1 && i < from + LEAF && i < m->triangles; i++)
      add_to_box(m, m->order[i], box);
    for (int j = 0; node < m->leaves - 1 && j < 6; j++) {
      double a = m->box[6L * (2 * node + 1) + j], b = m->box[6L * (2 * node + 2) + j];
      box[j] = j < 3 ? fmin(a, b) : fmax(a, b);
    }
  }
}

/* A query as it goes down. */
typedef struct query {
  const nsdae_mesh *mesh;
  const double *low, *high;
  nsdae_mesh_fn visit;
  void *to;
} query;

static int descend(const query *q, int node)
{
  const nsdae_mesh *m = q->mesh;
  const double *box = m->box + 6L * node;
  int from = (node - m->leaves + 1) * LEAF, code = 0;
  for (int j = 0; j < 3; j++)
    if (!(box[j] <= q->high[j] && box[3 + j] >= q->low[j])) return 0;
  if (node < m->leaves - 1) {
    code = descend(q, 2 * node + 1);
    return code ? code : descend(q, 2 * node + 2);
  }
  for (int i = from; i < from + LEAF && i < m->triangles && !code; i++)
    code = q->visit(q->to, m->order[i]);
  return code;
}

int nsdae_mesh_visit(const nsdae_mesh *m, const double *low, const double *high,
                     nsdae_mesh_fn visit, void *to)
{
  const query q = {m, low, high, visit, to};
  return descend(&q, 0);
}

int nsdae_mesh_about(const nsdae_mesh *m, const double *x, double within, nsdae_mesh_fn visit,
                     void *to)
{
  double low[3], high[3];
  for (int j = 0; j < 3; j++) {
    low[j] = x[j] - within;
    high[j] = x[j] + within;
  }
  return nsdae_mesh_visit(m, low, high, visit, to);
}

double nsdae_mesh_height(const nsdae_mesh *m, int t, const double *x)
{
  const double *a = nsdae_mesh_corner(m, t, 0), d[3] = {x[0] - a[0], x[1] - a[1], x[2] - a[2]};
  return nsdae_dot3(m->normal + 3L * t, d);
}

double nsdae_mesh_beyond(const nsdae_mesh *m, int t, int k, const double *x)
{
  const double *a = nsdae_mesh_corner(m, t, k), *b = nsdae_mesh_corner(m, t, k + 1);
  const double e[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]};
  const double d[3] = {x[0] - a[0], x[1] - a[1], x[2] - a[2]};
  double out[3];
  nsdae_cross3(e, m->normal + 3L * t, out);
  return nsdae_dot3(out, d) / sqrt(nsdae_dot3(e, e));
}

int nsdae_mesh_is_beneath(const nsdae_mesh *m, int t, const double *x, double within)
{
  double height = nsdae_mesh_height(m, t, x);
  int in = height <= within && height >= -m->thickness;
  for (int k = 0; k < 3 && in; k++) in = nsdae_mesh_beyond(m, t, k, x) <= within;
  return in;
}

void nsdae_mesh_extent(const nsdae_mesh *m, double *middle, double *size)
{
  double square = 0;
  for (int j = 0; j < 3; j++) {
    middle[j] = m->box[j] / 2 + m->box[3 + j] / 2;
    square += (m->box[3 + j] - middle[j]) * (m->box[3 + j] - middle[j]);
  }
  *size = sqrt(square);
}

int nsdae_mesh_triangles(const nsdae_mesh *m, double *to)
{
  for (int t = 0; t < m->triangles; t++)
    for (int j = 0; j < 9; j++) *to++ = nsdae_mesh_corner(m, t, j / 3)[j % 3];
  return m->triangles;
}

/* ---- memory */

void nsdae_mesh_release(const nsdae_mesh *mesh)
{
  nsdae_mesh *m = (nsdae_mesh *)(uintptr_t)mesh;
  if (!m) return;
  void *const arrays[] = {m->point, m->normal, m->box,   m->corner, m->beside,
                          m->face,  m->piece,  m->order, m->mark};
  for (size_t i = 0; i < sizeof arrays / sizeof *arrays; i++) free(arrays[i]);
  free(m);
}

static nsdae_mesh *allocate(int points, int triangles)
{
  nsdae_mesh *m = calloc(1, sizeof *m);
  size_t p = (size_t)points, t = (size_t)triangles;
  if (!m) return NULL;
  m->points = points;
  m->triangles = triangles;
  for (m->leaves = 1; m->leaves * LEAF < triangles;) m->leaves *= 2;
  m->point = malloc(3 * p * sizeof *m->point);
  m->normal = malloc(3 * t * sizeof *m->normal);
  m->box = malloc(12 * (size_t)m->leaves * sizeof *m->box);
  m->corner = malloc(t * sizeof *m->corner);
  m->beside = malloc(t * sizeof *m->beside);
  m->face = malloc(t * sizeof *m->face);
  m->piece = malloc(p * sizeof *m->piece);
  m->order = malloc(t * sizeof *m->order);
  m->mark = calloc(t, sizeof *m->mark);
  if (m->point && m->normal && m->box && m->corner && m->beside && m->face && m->piece &&
      m->order && m->mark)
    return m;
  nsdae_mesh_release(m);
  return NULL;
}

int nsdae_mesh_create(const nsdae_surface *of, double thickness, const double *R,
                      const double *origin, const nsdae_mesh **mesh, nsdae_error *error)
{
  nsdae_mesh *m = allocate(of->points, of->triangles);
  if (!m) return nsdae_error_memory(error, where);
  m->thickness = thickness;
  memcpy(m->corner, of->triangle, (size_t)of->triangles * sizeof *m->corner);
  for (long i = 0; i < of->points; i++) {
    nsdae_turn(R, of->point + 3 * i, m->point + 3 * i);
    for (int j = 0; j < 3; j++) m->point[3 * i + j] += origin[j];
  }
  int status = weld(m) ? measure(m, error) : nsdae_error_memory(error, where);
  if (status == NSDAE_OK && !(connect(m) && sort_triangles(m)))
    status = nsdae_error_memory(error, where);
  if (status < 0) {
    nsdae_mesh_release(m);
    return status;
  }
  build_tree(m);
  *mesh = m;
  return NSDAE_OK;
}
