/* The signed distance of two convex solids from their support maps. Along a unit vector n from
 * solid 0 to solid 1 they are apart by
 *
 *   s(n) = min n . x_1 - max n . x_0,     g = max s(n) over |n| = 1
 *
 * which is their distance or minus the least way that parts them. s is concave, as a minimum of
 * linear functions. Where g > 0 the maximum is unique, and the algorithm of Gilbert, Johnson and
 * Keerthi finds it (IEEE J. Robotics Automation 4, 1988): z = x_1 - x_0 is nearest to 0 on a
 * simplex of support points, and every n proves the bound s(n).
 *
 * Where they overlap s is maximised on the sphere, where it is not concave, by the concave-convex
 * procedure (A. L. Yuille, A. Rangarajan, Neural Computation 15, 2003): for a shift t with
 * s(n_k) + t > 0
 *
 *   n_{k+1} = argmax s(n) + t n . n_k,    s(n_{k+1}) >= s(n_k) + t (1 - n_k . n_{k+1}) >= s(n_k)
 *
 * is the distance of solids of which one is shifted by t n_k, again by GJK. Near a maximum with the
 * radii of curvature R the error falls by t / (t + R) at each, for depths of 1e-4 of the size by as
 * much; at faces the first is exact. It begins with solids that are shrunk about their origins, and
 * again with the best of the axes and faces of both if that is better: a local maximum, which is
 * the largest one of shallow overlaps but near corners. */
#include "narrow_phase.h"

#include <string.h>

#include "support.h"

/* In parts of the sizes: of bounds, for the rounding of a few products; below it directions are
 * rounding, as 1e-16 / 1e-6 is the least error of one. */
static const double rounding = 4e-15, touching = 1e-6;

/* Support points x_0, x_1 from the origin of body 0, and z = x_1 - x_0 + shift. */
typedef struct vertex {
  double z[3], x[2][3], part;
} vertex;

typedef struct pairing {
  const nsdae_couple *two;
  double between[3], shift[3], shrink, size, enough;
  int count;
  vertex simplex[4];
  double bound, normal[3], x[2][3]; /* the best so far */
} pairing;

static void find_vertex(const pairing *p, const double *n, vertex *w)
{
  for (int s = 0; s < 2; s++) {
    const nsdae_solid_of *solid = p->two->solid[s];
    const nsdae_pose *pose = p->two->pose[s];
    double d[3], own[3], x[3];
    for (int i = 0; i < 3; i++) d[i] = s ? -n[i] : n[i];
    nsdae_turn_back(pose->R, d, own);
    nsdae_support(solid, own, x);
    for (int i = 0; i < 3; i++) x[i] -= p->shrink * (x[i] - solid->origin[i]);
    nsdae_turn(pose->R, x, w->x[s]);
  }
  for (int i = 0; i < 3; i++) {
    w->x[1][i] += p->between[i];
    w->z[i] = w->x[1][i] - w->x[0][i] + p->shift[i];
  }
}

/* ---- the nearest point of a simplex */

/* 1 / 2 / 3 vertices: their parts in the point of their line or plane that is nearest to 0. 0: it
 * is outside of them, or they are in a line. */
static int parts_of(const vertex *const w[3], int count, double *part, double *v)
{
  double e[2][3], n[3], a[3];
  const double *z = w[0]->z;
  memcpy(v, z, sizeof e[0]);
  part[0] = 1;
  for (int k = 1; k < count; k++)
    for (int i = 0; i < 3; i++) e[k - 1][i] = w[k]->z[i] - z[i];
  if (count == 2) {
    part[1] = -nsdae_dot3(z, e[0]) / nsdae_dot3(e[0], e[0]);
    part[0] = 1 - part[1];
    for (int i = 0; i < 3; i++) v[i] += part[1] * e[0][i];
    return part[1] > 0 && part[0] > 0;
  }
  if (count < 2) return 1;
  nsdae_cross3(e[0], e[1], n);
  double square = nsdae_dot3(n, n), flat = nsdae_dot3(e[0], e[0]) * nsdae_dot3(e[1], e[1]);
  nsdae_cross3(e[1], z, a);
  part[1] = nsdae_dot3(n, a) / square;
  nsdae_cross3(z, e[0], a);
  part[2] = nsdae_dot3(n, a) / square;
  part[0] = 1 - part[1] - part[2];
  double height = nsdae_dot3(n, z) / square;
  for (int i = 0; i < 3; i++) v[i] = height * n[i];
  /* an angle of 1e-10 is rounding of edges of 1e-6 */
  return square > 1e-20 * flat && part[0] > 0 && part[1] > 0 && part[2] > 0;
}

/* Whether 0 is within four vertices. */
static int is_inside(const vertex *w)
{
  double first = 0;
  for (int k = 0; k < 4; k++) { /* the volume with 0 in place of vertex k */
    const double *a = w[(k + 1) % 4].z, *b = w[(k + 2) % 4].z, *c = w[(k + 3) % 4].z;
    double n[3], side;
    nsdae_cross3(b, c, n);
    side = (k % 2 ? -1 : 1) * nsdae_dot3(a, n);
    if (k == 0) first = side;
    if (!(side * first > 0)) return 0;
  }
  return 1;
}

/* The simplex becomes the least that has its point v nearest to 0: with the last vertex, since that
 * is nearer than the plane through the others. */
static double reduce(pairing *p, double *v)
{
  const int last = p->count - 1;
  double least = INFINITY, part[3], best[3] = {0}, to[3];
  int chosen = 0;
  for (int mask = 0; mask < 1 << last; mask++) {
    const vertex *w[4] = {&p->simplex[last]};
    int count = 1;
    for (int k = 0; k < last; k++)
      if (mask >> k & 1) w[count++] = &p->simplex[k];
    if (count > 3 || !parts_of(w, count, part, to) || !(nsdae_dot3(to, to) < least)) continue;
    least = nsdae_dot3(to, to);
    chosen = mask;
    memcpy(v, to, sizeof to);
    memcpy(best, part, sizeof best);
  }
  const vertex end = p->simplex[last];
  int count = 0;
  for (int k = 0; k < last; k++)
    if (chosen >> k & 1) {
      p->simplex[count] = p->simplex[k];
      p->simplex[count].part = best[count + 1];
      count++;
    }
  p->simplex[count] = end;
  p->simplex[count].part = best[0];
  p->count = count + 1;
  return least;
}

/* ---- the distance */

enum { OVERLAP, APART, FAR };

/* The nearest points of the simplex; its direction n, if that has a better bound s(n). */
static void keep(pairing *p, double bound, const double *n)
{
  memset(p->x, 0, sizeof p->x);
  for (int k = 0; k < p->count; k++)
    for (int s = 0; s < 2; s++)
      for (int i = 0; i < 3; i++) p->x[s][i] += p->simplex[k].part * p->simplex[k].x[s][i];
  if (!(bound > p->bound)) return;
  p->bound = bound;
  memcpy(p->normal, n, sizeof p->normal);
}

static int is_known(const pairing *p, const vertex *w)
{
  int known = 0;
  for (int i = 0; i < p->count; i++) known |= memcmp(p->simplex[i].z, w->z, sizeof w->z) == 0;
  return known;
}

/* From the direction p->normal on. Each step is nearer to 0, up to the rounding of triangles that
 * have become narrow: then from the best direction anew. */
static int gjk(pairing *p)
{
  double v[3], n[3], square = INFINITY, all = INFINITY;
  const double least = touching * touching * p->size * p->size * 1e-6;
  memcpy(n, p->normal, sizeof n);
  p->count = 0;
  p->bound = -INFINITY;
  for (int k = 0; k < 128; k++) {
    vertex *w = &p->simplex[p->count];
    find_vertex(p, n, w);
    double bound = nsdae_dot3(n, w->z);
    if (p->count > 0 && square < all) {
      keep(p, bound, n);
      all = square;
    }
    if (bound > p->enough) return FAR;
    if (sqrt(all) - p->bound <= rounding * p->size || is_known(p, w)) break;
    p->count++;
    if (p->count == 4 && is_inside(p->simplex)) return OVERLAP;
    double next = reduce(p, v);
    if (next < least) return OVERLAP;
    if (next >= square) {
      p->count = 0;
      square = INFINITY;
      memcpy(n, p->normal, sizeof n);
      continue;
    }
    square = next;
    for (int i = 0; i < 3; i++) n[i] = v[i] / sqrt(square);
  }
  return APART;
}

/* s(n) */
static double separation(const pairing *p, const double *n)
{
  vertex w;
  find_vertex(p, n, &w);
  return nsdae_dot3(n, w.z);
}

/* The concave-convex procedure from p->normal on; p->bound = s there. Each step is lengthened as
 * long as s increases: alone they come to the maximum as slowly as the depth is large. */
static void ascend(pairing *p)
{
  double s = separation(p, p->normal);
  for (int k = 0; k < 64; k++) {
    double t = fmax(fabs(s), touching * p->size) - s, before[3], n[3];
    memcpy(before, p->normal, sizeof before);
    for (int i = 0; i < 3; i++) p->shift[i] = t * p->normal[i];
    int found = gjk(p);
    memset(p->shift, 0, sizeof p->shift);
    double next = separation(p, p->normal);
    if (found != APART || !(next - s > rounding * p->size)) break;
    for (double by = 1;; by *= 2) {
      for (int i = 0; i < 3; i++) n[i] = p->normal[i] + by * (p->normal[i] - before[i]);
      if (!nsdae_unit_vector(n, n)) break;
      double further = separation(p, n);
      if (!(further > next)) break;
      next = further;
      memcpy(before, p->normal, sizeof before);
      memcpy(p->normal, n, sizeof n);
    }
    s = next;
  }
  p->bound = separation(p, p->normal);
}

/* best := the one with the largest s of itself and a direction of solid `side`. */
static void try(const pairing *p, int side, const double *own, double sign, double *most,
                double *best)
{
  double n[3];
  nsdae_turn(p->two->pose[side]->R, own, n);
  for (int i = 0; i < 3; i++) n[i] *= sign;
  double s = separation(p, n);
  if (!(s > *most + rounding * p->size)) return;
  *most = s;
  memcpy(best, n, sizeof n);
}

/* From the normal of the shrunk solids, and from the best axis or normal of a face if that is
 * better. */
static void maximise(pairing *p)
{
  p->shrink = 0.1; /* parts solids that overlap by a tenth of the distance of their origins */
  gjk(p);
  p->shrink = 0;
  ascend(p);
  double most = p->bound, best[3];
  for (int s = 0; s < 2; s++) {
    const nsdae_solid_of *solid = p->two->solid[s];
    for (int k = 0; k < 6; k++) try(p, s, solid->R + 3 * (k / 2), k % 2 ? -1 : 1, &most, best);
    for (int f = 0; solid->shape == NSDAE_SHAPE_POLYHEDRON && f < solid->hull->faces; f++)
      try(p, s, solid->edge + 4 * f, s ? -1 : 1, &most, best);
  }
  if (most == p->bound) return;
  memcpy(p->normal, best, sizeof best);
  ascend(p);
}

int nsdae_signed_distance(const nsdae_couple *two, double enough, nsdae_still *at)
{
  const nsdae_solid_of *const *s = two->solid;
  double round[2] = {s[0]->radius, s[1]->radius}, to[2][3];
  pairing p = {.two = two, .size = s[0]->size + s[1]->size, .enough = INFINITY};
  for (int i = 0; i < 2; i++) nsdae_turn(two->pose[i]->R, s[i]->origin, to[i]);
  for (int i = 0; i < 3; i++) {
    p.between[i] = two->pose[1]->r[i] - two->pose[0]->r[i];
    at->normal[i] = p.between[i] + to[1][i] - to[0][i];
  }
  if (!nsdae_unit_vector(at->normal, p.normal)) p.normal[0] = 1, p.normal[1] = p.normal[2] = 0;
  p.enough = enough + round[0] + round[1];
  int found = gjk(&p);
  p.enough = INFINITY;
  if (found == FAR) return 0;
  if (found == OVERLAP || p.bound < touching * p.size) maximise(&p);
  at->gap = p.bound - round[0] - round[1];
  memcpy(at->normal, p.normal, sizeof p.normal);
  for (int k = 0; k < 2; k++)
    for (int i = 0; i < 3; i++)
      at->at[k][i] = two->pose[0]->r[i] + p.x[k][i] + (k ? -1 : 1) * round[k] * p.normal[i];
  return 1;
}
