/* Hulls: the edges and checks of what Qhull finds. */
#include "hull.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "errors.h"
#include "space.h"

static const char where[] = "nsdae_solid";

/* In parts of the size of a hull: its width at least, and how far a corner is above a face at most.
 * The tolerances of contacts are 1e-6 of the size (separating_axis.h). */
static const double narrow = 1e-5, rounding = 1e-9;

/* ---- of a box and a capsule */

static int box_first[] = {0, 4, 8, 12, 16, 20, 24};
static int box_ring[] = {0, 4, 6, 2, 1, 3, 7, 5, 0, 1, 5, 4, 2, 6, 7, 3, 0, 2, 3, 1, 4, 5, 7, 6};
static int box_edge[][4] = {{0, 1, 2, 4}, {2, 3, 4, 3}, {4, 5, 5, 2}, {6, 7, 3, 5},
                            {0, 2, 4, 0}, {4, 6, 0, 5}, {1, 3, 1, 4}, {5, 7, 5, 1},
                            {0, 4, 0, 2}, {1, 5, 2, 1}, {2, 6, 3, 0}, {3, 7, 1, 3}};
static int capsule_edge[][4] = {{0, 1, -1, -1}};

const nsdae_hull nsdae_box_hull = {8, 6, 12, NULL, box_first, box_ring, box_edge};
const nsdae_hull nsdae_capsule_hull = {.corners = 2, .edges = 1, .edge = capsule_edge};

/* ---- edges of the rings of faces */

/* The face that has corner `to` after `from` in its ring; -1: none. */
static int face_along(const nsdae_hull *h, int from, int to)
{
  for (int f = 0; f < h->faces; f++)
    for (int i = h->first[f], last = h->first[f + 1] - 1; i <= last; i++)
      if (h->ring[i] == from && h->ring[i < last ? i + 1 : h->first[f]] == to) return f;
  return -1;
}

/* Two faces share each edge, which they run along in opposite directions. 0: they do not. */
static int find_edges(const nsdae_hull *h, int (*edge)[4])
{
  int count = 0;
  for (int f = 0; f < h->faces; f++)
    for (int i = h->first[f], last = h->first[f + 1] - 1; i <= last; i++) {
      int from = h->ring[i], to = h->ring[i < last ? i + 1 : h->first[f]];
      if (from > to) continue;
      const int made[4] = {from, to, f, face_along(h, to, from)};
      if (made[3] < 0 || count == h->edges) return 0;
      memcpy(edge[count++], made, sizeof made);
    }
  return count == h->edges;
}

/* ---- checks */

/* The unit normal of a face: sum of p_i x p_(i+1) (M. E. Newell). */
int nsdae_hull_normal(const nsdae_hull *h, const double *corner, int f, double n[3])
{
  double sum[3] = {0, 0, 0};
  const double *o = corner + 3 * h->ring[h->first[f]];
  for (int i = h->first[f] + 1; i + 1 < h->first[f + 1]; i++) {
    double a[3], b[3], c[3];
    for (int j = 0; j < 3; j++) {
      a[j] = corner[3 * h->ring[i] + j] - o[j];
      b[j] = corner[3 * h->ring[i + 1] + j] - o[j];
    }
    nsdae_cross3(a, b, c);
    for (int j = 0; j < 3; j++) sum[j] += c[j];
  }
  return nsdae_unit_vector(sum, n);
}

/* No corner is above a face; the least width across a face. */
static int check_convex(const nsdae_hull *h, nsdae_error *error)
{
  double size = 0, width = INFINITY;
  for (int i = 0; i < h->corners; i++)
    for (int j = 0; j < 3; j++) size = fmax(size, fabs(h->corner[3 * i + j] - h->corner[j]));
  for (int f = 0; f < h->faces; f++) {
    double n[3], above = -INFINITY, below = 0;
    int flat = !nsdae_hull_normal(h, h->corner, f, n);
    const double *o = h->corner + 3 * h->ring[h->first[f]];
    for (int i = 0; i < h->corners && !flat; i++) {
      const double *p = h->corner + 3 * i;
      const double d[3] = {p[0] - o[0], p[1] - o[1], p[2] - o[2]};
      above = fmax(above, nsdae_dot3(n, d));
      below = fmax(below, -nsdae_dot3(n, d));
    }
    if (flat || above > rounding * size)
      return nsdae_error_set(
          error, NSDAE_E_ARGUMENT, where, "point",
          "face %d of the polyhedron has no area or a corner above it: leave out "
          "points that are nearer to each other than %g",
          f, narrow * size);
    width = fmin(width, below);
  }
  if (width >= narrow * size) return NSDAE_OK;
  return nsdae_error_set(error, NSDAE_E_ARGUMENT, where, "point",
                         "the width of the polyhedron is %g, below %g (%g of its size): the points "
                         "must not lie in a plane",
                         width, narrow * size, narrow);
}

nsdae_hull *nsdae_hull_new(int corners, int faces, int sides)
{
  size_t numbers = 3 * (size_t)corners, edges = (size_t)sides / 2;
  size_t ints = (size_t)faces + 1 + (size_t)sides + 4 * edges;
  nsdae_hull *h = calloc(1, sizeof *h + numbers * sizeof(double) + ints * sizeof(int));
  if (!h) return NULL;
  double *corner = (double *)(void *)(h + 1);
  int *first = (int *)(void *)(corner + numbers), *ring = first + faces + 1;
  *h = (nsdae_hull){
      corners, faces, (int)edges, corner, first, ring, (int(*)[4])(void *)(ring + sides)};
  return h;
}

int nsdae_hull_close(nsdae_hull *h, nsdae_error *error)
{
  if (find_edges(h, h->edge) && h->corners - h->edges + h->faces == 2)
    return check_convex(h, error);
  return nsdae_error_set(error, NSDAE_E_ARGUMENT, where, "point",
                         "the faces of the polyhedron are not closed: leave out points that nearly "
                         "coincide");
}

void nsdae_hull_release(const nsdae_hull *hull)
{
  if (hull && hull->corner) free((nsdae_hull *)(uintptr_t)hull);
}

int nsdae_hull_triangles(const nsdae_hull *h, const double *corner, double *to)
{
  int count = 0;
  for (int f = 0; f < h->faces; f++)
    for (int i = h->first[f] + 1; i + 1 < h->first[f + 1]; i++, count++) {
      const int of[3] = {h->ring[h->first[f]], h->ring[i], h->ring[i + 1]};
      for (int j = 0; j < 9; j++) *to++ = corner[3 * of[j / 3] + j % 3];
    }
  return count;
}
