#include "support.h"

#include <string.h>

#include "narrow_phase.h"

/* ---- points */

/* x += the foremost point of the ellipsoid about 0, or of the disc, of a smooth shape: feature.c.
 * If d is along the axis of a disc all of it is foremost, and its centre with it. */
static void round_off(const nsdae_solid_of *s, const double *d, double *x)
{
  double w[3], along = nsdae_dot3(d, s->R + 6), square = 0;
  if (s->shape != NSDAE_SHAPE_ELLIPSOID) {
    for (int i = 0; i < 3; i++) w[i] = d[i] - along * s->R[6 + i];
    double length = sqrt(nsdae_dot3(w, w));
    double scale = length > 1e-12 * fabs(along) ? s->half[0] / length : 0;
    for (int i = 0; i < 3; i++) x[i] += scale * w[i];
    return;
  }
  for (int j = 0; j < 3; j++) {
    w[j] = s->half[j] * s->half[j] * nsdae_dot3(d, s->R + 3 * j);
    square += w[j] * nsdae_dot3(d, s->R + 3 * j);
  }
  for (int j = 0; j < 3; j++)
    for (int i = 0; i < 3; i++) x[i] += w[j] / sqrt(square) * s->R[3 * j + i];
}

/* That of the discs, ellipsoid and apex of which it is the hull. Of the caps of a cylinder the axis
 * says which it is, without rounding. */
static void smooth_support(const nsdae_solid_of *s, const double *d, double *x)
{
  int top = s->shape == NSDAE_SHAPE_CYLINDER && nsdae_dot3(d, s->R + 6) >= 0;
  memcpy(x, s->point + (top ? 12 : 0), 3 * sizeof *x);
  round_off(s, d, x);
  if (s->shape == NSDAE_SHAPE_CONE && nsdae_dot3(d, s->point + 12) > nsdae_dot3(d, x))
    memcpy(x, s->point + 12, 3 * sizeof *x);
}

void nsdae_round_end(const nsdae_solid_of *s, const double *end, const double *d, double *x)
{
  for (int i = 0; i < 3; i++) x[i] = end[i] + s->radius * d[i];
  if (nsdae_solid_is_smooth(s)) round_off(s, d, x);
}

static int foremost(const nsdae_solid_of *s, const double *d)
{
  int best = 0;
  double most = -INFINITY;
  for (int i = 0; i < s->points; i++) {
    double along = nsdae_dot3(d, s->point + 3 * i);
    if (along <= most) continue;
    most = along;
    best = i;
  }
  return best;
}

void nsdae_support(const nsdae_solid_of *s, const double *d, double *x)
{
  if (nsdae_solid_is_smooth(s)) {
    smooth_support(s, d, x);
    return;
  }
  switch (s->shape) {
  case NSDAE_SHAPE_BOX:
    memcpy(x, s->origin, 3 * sizeof *x);
    for (int j = 0; j < 3; j++) {
      const double *axis = s->R + 3 * j;
      double side = nsdae_dot3(d, axis) < 0 ? -s->half[j] : s->half[j];
      for (int i = 0; i < 3; i++) x[i] += side * axis[i];
    }
    return;
  default:
    memcpy(x, s->point + 3 * foremost(s, d), 3 * sizeof *x);
  }
}

/* ---- faces */

static void add_point(nsdae_face *f, const double *x, int id)
{
  memcpy(f->x[f->count], x, sizeof f->x[0]);
  f->id[f->count++] = id;
}

/* Of a cap, base or disc four points of the rim that are fixed to it: the nearest contact has the
 * lowest one. */
static void face_of_disc(const nsdae_solid_of *s, int end, double side, nsdae_face *f)
{
  double x[3];
  f->disc = s->half[0];
  for (int j = 0; j < 3; j++) f->normal[j] = side * s->R[6 + j];
  for (int k = 0; k < 4; k++) { /* anticlockwise about the outer normal */
    const double *axis = s->R + 3 * (k % 2);
    double r = (k < 2 ? 1 : -1) * (k % 2 ? side : 1) * s->half[0];
    for (int j = 0; j < 3; j++) x[j] = s->point[3 * end + j] + r * axis[j];
    add_point(f, x, end + k);
  }
}

/* Of the side of a cylinder the line on the axis, of a cone that from the rim to the apex. */
static void face_of_smooth(const nsdae_solid_of *s, const double *n, nsdae_face *f)
{
  double along = nsdae_dot3(n, s->R + 6), across = sqrt(fmax(0, 1 - along * along)), x[3];
  int cone = s->shape == NSDAE_SHAPE_CONE, two = s->shape == NSDAE_SHAPE_CYLINDER;
  double r = cone ? s->half[0] : 0, h = 2 * s->half[2], side = hypot(r, h);
  if (s->shape == NSDAE_SHAPE_ELLIPSOID) return;
  if (across < NSDAE_TILT && !(cone && along > 0)) {
    face_of_disc(s, two && along > 0 ? 4 : 0, along < 0 ? -1 : 1, f);
  } else if (h > 0 && fabs(h * along - r * across) < NSDAE_TILT * side) {
    f->round = cone ? 0 : s->half[0];
    memcpy(x, s->point, sizeof x);
    if (cone) round_off(s, n, x);
    add_point(f, x, 0);
    add_point(f, s->point + 12, 4);
  }
}

/* The face whose normal is nearest to n, of many corners some; else of the edges at the foremost
 * corner that which is nearest to a right angle to n. */
static void face_of_hull(const nsdae_solid_of *s, const double *n, nsdae_face *f)
{
  const nsdae_hull *h = s->hull;
  double most = sqrt(1 - NSDAE_TILT * NSDAE_TILT), least = NSDAE_TILT;
  int best = -1, corner = foremost(s, n);
  for (int i = 0; i < h->faces; i++) {
    double along = nsdae_dot3(n, s->edge + 4 * i);
    if (along <= most) continue;
    most = along;
    best = i;
  }
  if (best >= 0) {
    int sides = h->first[best + 1] - h->first[best], stride = (sides - 1) / NSDAE_FACE + 1;
    memcpy(f->normal, s->edge + 4 * best, sizeof f->normal);
    for (int i = h->first[best]; i < h->first[best + 1]; i += stride)
      add_point(f, s->point + 3 * h->ring[i], h->ring[i]);
    return;
  }
  for (int i = 0; i < h->edges; i++) {
    const int *edge = h->edge[i];
    if (edge[0] != corner && edge[1] != corner) continue;
    double e[3];
    for (int j = 0; j < 3; j++) e[j] = s->point[3 * edge[1] + j] - s->point[3 * edge[0] + j];
    double sine = fabs(nsdae_dot3(e, n)) / sqrt(nsdae_dot3(e, e));
    if (sine >= least) continue;
    least = sine;
    best = i;
  }
  f->round = s->radius;
  for (int i = 0; i < 2 && best >= 0; i++)
    add_point(f, s->point + 3 * h->edge[best][i], h->edge[best][i]);
}

void nsdae_supporting_face(const nsdae_solid_of *s, const double *n, nsdae_face *f)
{
  f->count = 0;
  f->round = f->disc = 0;
  if (nsdae_solid_is_smooth(s))
    face_of_smooth(s, n, f);
  else if (s->hull)
    face_of_hull(s, n, f);
}
