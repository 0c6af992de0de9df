#include "support.h"

#include <string.h>

/* A contact beyond the nearest one is found up to a tilt of this sine. Its gap is there already the
 * sine times the length of the face; a body that turns by 10 rad/s tilts by a fifth of it in a step
 * of 2 ms. Piles of tests/system/pairs.c rest with 0.03, 0.1 and 0.3. */
static const double tilt_sine = 0.1;

/* ---- points */

static void round_off(const double *end, const double *axis, double radius, const double *d,
                      double *x)
{
  double w[3], along = nsdae_dot3(d, axis);
  for (int i = 0; i < 3; i++) w[i] = d[i] - along * axis[i];
  double length = sqrt(nsdae_dot3(w, w));
  /* along the axis all points of the rim are foremost, and the middle of the cap with them */
  double scale = length > 1e-12 * fabs(along) ? radius / length : 0;
  for (int i = 0; i < 3; i++) x[i] = end[i] + scale * w[i];
}

void nsdae_round_end(const nsdae_solid_of *s, const double *end, const double *d, double *x)
{
  if (s->shape == NSDAE_SHAPE_CYLINDER) {
    round_off(end, s->R + 6, s->half[0], d, x);
    return;
  }
  for (int i = 0; i < 3; i++) x[i] = end[i] + s->radius * d[i];
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

/* The centre of a cap, on side 1 or -1. */
static void cap_of(const nsdae_solid_of *s, double side, double *x)
{
  for (int i = 0; i < 3; i++) x[i] = s->origin[i] + side * s->half[2] * s->R[6 + i];
}

void nsdae_support(const nsdae_solid_of *s, const double *d, double *x)
{
  double end[3];
  switch (s->shape) {
  case NSDAE_SHAPE_CYLINDER:
    cap_of(s, nsdae_dot3(d, s->R + 6) < 0 ? -1 : 1, end);
    round_off(end, s->R + 6, s->half[0], d, x);
    return;
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

/* Of a cap four points of the rim that are fixed to it: the nearest contact has the lowest one. Of
 * the side the line on the axis. */
static void face_of_cylinder(const nsdae_solid_of *s, const double *n, nsdae_face *f)
{
  double along = nsdae_dot3(n, s->R + 6), side = along < 0 ? -1 : 1, end[3], x[3];
  if (1 - along * along < tilt_sine * tilt_sine) {
    cap_of(s, side, end);
    for (int j = 0; j < 3; j++) f->normal[j] = side * s->R[6 + j];
    for (int k = 0; k < 4; k++) { /* anticlockwise about the outer normal */
      const double *axis = s->R + 3 * (k % 2);
      double r = (k < 2 ? 1 : -1) * (k % 2 ? side : 1) * s->half[0];
      for (int j = 0; j < 3; j++) x[j] = end[j] + r * axis[j];
      add_point(f, x, (side < 0 ? 0 : 4) + k);
    }
  } else if (fabs(along) < tilt_sine) {
    f->round = s->half[0];
    for (int i = 0; i < 2; i++) {
      cap_of(s, i ? 1 : -1, end);
      add_point(f, end, 4 * i);
    }
  }
}

/* The face whose normal is nearest to n, of many corners some; else of the edges at the foremost
 * corner that which is nearest to a right angle to n. */
static void face_of_hull(const nsdae_solid_of *s, const double *n, nsdae_face *f)
{
  const nsdae_hull *h = s->hull;
  double most = sqrt(1 - tilt_sine * tilt_sine), least = tilt_sine;
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
  f->round = 0;
  if (s->shape == NSDAE_SHAPE_CYLINDER)
    face_of_cylinder(s, n, f);
  else if (s->hull)
    face_of_hull(s, n, f);
}
