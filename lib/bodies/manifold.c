/* Contacts of two convex solids of which one is curved, for time stepping. The nearest points are
 * one (gjk.c). Where faces or edges of both lie along each other (support.h) it is not enough, and
 * they touch at the corners of their intersection, seen along the normal n:
 *
 *   corner on a face       gap and normal of the face's plane
 *   edge across an edge    of two lines, with their roundings
 *   end along an edge      of edges that are parallel: of the end and the other's line
 *
 * (as contact clipping of Box2D and Bullet, but each with a gap that is a distance, whose rate is
 * that of its points along its own normal). Numbers of contacts: 0 the nearest points; then corners
 * of solid 0, corners of solid 1, and pairs of edges by the corners at which they begin. */
#include "narrow_phase.h"

#include <string.h>

#include "separating_axis.h"
#include "support.h"

/* The faces in space, from the origin of body 0, and in two coordinates across n. */
typedef struct side {
  const nsdae_solid_of *solid;
  const nsdae_pose *pose;
  nsdae_face face;
  double x[NSDAE_FACE][3], flat[NSDAE_FACE][2], normal[3];
} side;

typedef struct clip {
  side of[2];
  const nsdae_still *nearest;
  double beside;
  nsdae_manifold *to;
} clip;

static void place_side(const nsdae_couple *two, int s, clip *c)
{
  side *p = &c->of[s];
  const double *n = c->nearest->normal;
  double b[3], t[3], own[3];
  p->solid = two->solid[s];
  p->pose = two->pose[s];
  nsdae_turn_back(p->pose->R, n, own);
  for (int i = 0; i < 3 && s; i++) own[i] = -own[i];
  nsdae_supporting_face(p->solid, own, &p->face);
  nsdae_turn(p->pose->R, p->face.normal, p->normal);
  nsdae_complete_frame(n, b, t);
  for (int k = 0; k < p->face.count; k++) {
    nsdae_turn(p->pose->R, p->face.x[k], p->x[k]);
    for (int i = 0; i < 3; i++) p->x[k][i] += p->pose->r[i] - two->pose[0]->r[i];
    p->flat[k][0] = nsdae_dot3(b, p->x[k]);
    p->flat[k][1] = nsdae_dot3(t, p->x[k]);
  }
}

/* n is from 0 to 1 along a, or along -a. x_s are the surface points. */
static void add(clip *c, int number, double sign, const double *a, double gap, const double *x0,
                const double *x1)
{
  nsdae_manifold *m = c->to;
  if (m->count == NSDAE_MANIFOLD) return;
  nsdae_still *s = &m->at[m->count];
  m->number[m->count++] = number;
  s->gap = gap;
  for (int i = 0; i < 3; i++) {
    s->normal[i] = sign * a[i];
    s->at[0][i] = c->of[0].pose->r[i] + x0[i];
    s->at[1][i] = c->of[0].pose->r[i] + x1[i];
  }
}

/* Whether a point is over a polygon, or beside it by a little; a disc counts up to its rim, beyond
 * the polygon. */
static int is_over(const side *p, const double *x, const double *y, double beside)
{
  if (p->face.disc > 0) {
    double d[3], across[3];
    for (int i = 0; i < 3; i++) d[i] = x[i] - (p->x[0][i] + p->x[2][i]) / 2;
    nsdae_cross3(p->normal, d, across);
    return sqrt(nsdae_dot3(across, across)) <= p->face.disc + beside;
  }
  for (int k = 0; k < p->face.count; k++) {
    const double *a = p->flat[k], *b = p->flat[(k + 1) % p->face.count];
    const double *beyond = p->flat[(k + 2) % p->face.count];
    double e[2] = {b[0] - a[0], b[1] - a[1]};
    double in = e[0] * (beyond[1] - a[1]) - e[1] * (beyond[0] - a[0]);
    double at = e[0] * (y[1] - a[1]) - e[1] * (y[0] - a[0]);
    if (at * (in < 0 ? -1 : 1) < -beside * hypot(e[0], e[1])) return 0;
  }
  return 1;
}

/* The end of a solid's segment that is foremost along a unit vector, or the corner of a face. */
static void surface(const side *p, int k, const double *along, double *x)
{
  double d[3], own[3];
  memcpy(x, p->x[k], 3 * sizeof *x);
  if (p->face.round == 0) return;
  nsdae_turn_back(p->pose->R, along, d);
  nsdae_round_end(p->solid, p->face.x[k], d, own);
  for (int i = 0; i < 3; i++) own[i] -= p->face.x[k][i];
  nsdae_turn(p->pose->R, own, d);
  for (int i = 0; i < 3; i++) x[i] += d[i];
}

/* Corners of side s on the polygon of the other. */
static void add_corners(clip *c, int s)
{
  const side *p = &c->of[s], *base = &c->of[1 - s];
  int first = 1 + (s ? c->of[0].solid->points : 0);
  if (base->face.count < 3) return;
  for (int k = 0; k < p->face.count; k++) {
    double down[3], x[3], foot[3];
    if (!is_over(base, p->x[k], p->flat[k], c->beside)) continue;
    for (int i = 0; i < 3; i++) down[i] = -base->normal[i];
    surface(p, k, down, x);
    double height = nsdae_dot3(base->normal, x) - nsdae_dot3(base->normal, base->x[0]);
    for (int i = 0; i < 3; i++) foot[i] = x[i] - height * base->normal[i];
    add(c, first + p->face.id[k], s ? 1 : -1, base->normal, height, s ? foot : x, s ? x : foot);
  }
}

/* Edge k of side 0 and l of side 1, at more than the angle of the tilt: else their ends touch;
 * within both by more than a little: beyond, a corner is over the other. See line_line in
 * narrow_phase.c. */
static void add_crossing(clip *c, int k, int l)
{
  const int at[2] = {k, l};
  double e[2][3], d[3], m[3], turned[3], x[2][3];
  for (int s = 0; s < 2; s++) {
    const side *p = &c->of[s];
    const double *from = p->x[at[s]], *end = p->x[(at[s] + 1) % p->face.count];
    memcpy(x[s], from, sizeof d);
    for (int i = 0; i < 3; i++) e[s][i] = end[i] - from[i];
  }
  for (int i = 0; i < 3; i++) d[i] = x[1][i] - x[0][i];
  nsdae_cross3(e[0], e[1], m);
  double square = nsdae_dot3(m, m);
  if (!(square > NSDAE_TILT * NSDAE_TILT * nsdae_dot3(e[0], e[0]) * nsdae_dot3(e[1], e[1]))) return;
  double sign = (nsdae_dot3(m, c->nearest->normal) < 0 ? -1 : 1) / sqrt(square), gap = 0;
  for (int i = 0; i < 3; i++) m[i] *= sign;
  if (nsdae_dot3(m, c->nearest->normal) < 1 - NSDAE_TILT * NSDAE_TILT) return;
  for (int s = 0; s < 2; s++) {
    nsdae_cross3(d, e[1 - s], turned);
    double along = sign * nsdae_dot3(m, turned);
    if (fmin(along, 1 - along) * sqrt(nsdae_dot3(e[s], e[s])) <= c->beside) return;
    for (int i = 0; i < 3; i++)
      x[s][i] += along * e[s][i] + (s ? -1 : 1) * c->of[s].face.round * m[i];
  }
  for (int i = 0; i < 3; i++) gap += m[i] * (x[1][i] - x[0][i]);
  int ids[2] = {c->of[0].solid->points, c->of[1].solid->points};
  add(c, 1 + ids[0] + ids[1] + c->of[0].face.id[k] * ids[1] + c->of[1].face.id[l], 1, m, gap, x[0],
      x[1]);
}

/* foot := the point of a segment's line that is nearest to x; returns how far beyond its ends. */
static double foot_on(const side *p, const double *x, double *foot)
{
  double e[3], d[3];
  for (int i = 0; i < 3; i++) {
    e[i] = p->x[1][i] - p->x[0][i];
    d[i] = x[i] - p->x[0][i];
  }
  double square = nsdae_dot3(e, e), along = nsdae_dot3(e, d) / square;
  for (int i = 0; i < 3; i++) foot[i] = p->x[0][i] + along * e[i];
  return (fabs(along - 0.5) - 0.5) * sqrt(square);
}

/* Ends of the segment of side s along that of the other, at a small angle. The point x of the end's
 * rim and its foot f on the line are nearest where x - c is along the part of f - c in the plane of
 * the rim, c its middle. As the line is nearly across that plane, f hardly depends on x: each pass
 * reduces the error by the square of the sine. */
static void add_ends(clip *c, int s)
{
  const side *p = &c->of[s], *other = &c->of[1 - s];
  double a[3], x[3], foot[3], sign = s ? -1 : 1;
  for (int k = 0; k < 2; k++) {
    if (foot_on(other, p->x[k], foot) > c->beside) continue;
    for (int pass = 0; pass < 5; pass++) {
      for (int i = 0; i < 3; i++) a[i] = foot[i] - p->x[k][i];
      if (!nsdae_unit_vector(a, a)) memcpy(a, c->nearest->normal, sizeof a);
      surface(p, k, a, x);
      foot_on(other, x, foot);
    }
    for (int i = 0; i < 3; i++) a[i] = foot[i] - x[i];
    if (!nsdae_unit_vector(a, a)) memcpy(a, c->nearest->normal, sizeof a);
    double facing = sign * nsdae_dot3(a, c->nearest->normal) < 0 ? -1 : 1, gap = 0;
    for (int i = 0; i < 3; i++) {
      foot[i] -= facing * other->face.round * a[i];
      gap += facing * a[i] * (foot[i] - x[i]);
    }
    add(c, 1 + (s ? c->of[0].solid->points : 0) + p->face.id[k], sign * facing, a, gap,
        s ? foot : x, s ? x : foot);
  }
}

static int are_parallel(const clip *c)
{
  double e[2][3], m[3];
  for (int s = 0; s < 2; s++)
    for (int i = 0; i < 3; i++) e[s][i] = c->of[s].x[1][i] - c->of[s].x[0][i];
  nsdae_cross3(e[0], e[1], m);
  return nsdae_dot3(m, m) <
         NSDAE_TILT * NSDAE_TILT * nsdae_dot3(e[0], e[0]) * nsdae_dot3(e[1], e[1]);
}

/* Edges of a face: one of a segment. */
static int edges_of(const nsdae_face *f)
{
  return f->count == 2 ? 1 : f->count;
}

int nsdae_find_manifold(const nsdae_couple *two, double enough, nsdae_manifold *m)
{
  nsdae_still nearest;
  m->count = 0;
  if (!nsdae_signed_distance(two, enough, &nearest)) return 0;
  double size = two->solid[0]->size + two->solid[1]->size, least = INFINITY;
  clip c = {.nearest = &nearest, .beside = NSDAE_SLACK * size, .to = m};
  for (int s = 0; s < 2; s++) place_side(two, s, &c);
  const nsdae_face *f[2] = {&c.of[0].face, &c.of[1].face};
  int segments = f[0]->count == 2 && f[1]->count == 2;
  for (int s = 0; s < 2 && f[1 - s]->count > 0; s++) {
    if (!segments)
      add_corners(&c, s);
    else if (are_parallel(&c))
      add_ends(&c, s);
  }
  for (int k = 0; k < edges_of(f[0]) && !segments; k++)
    for (int l = 0; l < edges_of(f[1]); l++) add_crossing(&c, k, l);
  for (int i = 0; i < m->count; i++) least = fmin(least, m->at[i].gap);
  if (least <= nearest.gap + c.beside) return 1; /* one of them is the nearest */
  m->number[m->count] = 0;
  m->at[m->count++] = nearest;
  return 1;
}

int nsdae_manifold_closest(const nsdae_meeting *met, int number, nsdae_closest *c)
{
  const nsdae_manifold *m = &met->manifold;
  int i = 0;
  while (i < m->count && m->number[i] != number) i++;
  if (i == m->count) return 0;
  c->kind = NSDAE_PLANE_POINT;
  c->side = 1;
  c->radius[0] = c->radius[1] = 0;
  for (int s = 0; s < 2; s++) {
    const nsdae_pose *pose = met->two.pose[s];
    double d[3];
    for (int j = 0; j < 3; j++) d[j] = m->at[i].at[s][j] - pose->r[j];
    nsdae_turn_back(pose->R, d, c->x[s]);
  }
  nsdae_turn_back(met->two.pose[0]->R, m->at[i].normal, c->u[0]);
  return 1;
}
