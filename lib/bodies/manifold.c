/* Contacts of two convex solids of which one is curved, for time stepping. The nearest points are
 * one (gjk.c). Where faces or edges of both lie along each other (support.h) it is not enough, and
 * they touch at the corners of their intersection, seen along the normal n:
 *
 *   corner on a face       gap and normal of the face's plane
 *   edge across an edge    of two lines or rims, with their roundings
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
  int cone; /* a line on the side of one, from the rim to the apex: see aim */
} side;

typedef struct clip {
  side of[2];
  const nsdae_still *nearest;
  double beside;
  nsdae_manifold *to;
} clip;

/* From the frame of its body into space, from the origin of body 0. */
static void put(const clip *c, const side *p, const double *own, double *x)
{
  nsdae_turn(p->pose->R, own, x);
  for (int i = 0; i < 3; i++) x[i] += p->pose->r[i] - c->of[0].pose->r[i];
}

/* The line of the side of a cone is that on whose side of the axis d is. */
static void aim(const clip *c, side *p, const double *d)
{
  double own[3], x[3];
  if (!p->cone) return;
  nsdae_turn_back(p->pose->R, d, own);
  nsdae_round_end(p->solid, p->solid->point, own, x);
  put(c, p, x, p->x[0]);
}

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
  p->cone = p->face.count == 2 && p->solid->shape == NSDAE_SHAPE_CONE;
  nsdae_turn(p->pose->R, p->face.normal, p->normal);
  nsdae_complete_frame(n, b, t);
  for (int k = 0; k < p->face.count; k++) {
    put(c, p, p->face.x[k], p->x[k]);
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

/* Of a disc. */
static void centre_of(const side *p, double *centre)
{
  for (int i = 0; i < 3; i++) centre[i] = (p->x[0][i] + p->x[2][i]) / 2;
}

/* Whether a point is over a polygon, or beside it by a little; a disc counts up to its rim, beyond
 * the polygon. */
static int is_over(const side *p, const double *x, const double *y, double beside)
{
  if (p->face.disc > 0) {
    double d[3], across[3];
    centre_of(p, d);
    for (int i = 0; i < 3; i++) d[i] = x[i] - d[i];
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
static void surface(const clip *c, side *p, int k, const double *along, double *x)
{
  double d[3], own[3];
  aim(c, p, along);
  memcpy(x, p->x[k], 3 * sizeof *x);
  if (p->face.round == 0) return;
  nsdae_turn_back(p->pose->R, along, d);
  nsdae_round_end(p->solid, p->face.x[k], d, own);
  for (int i = 0; i < 3; i++) own[i] -= p->face.x[k][i];
  nsdae_turn(p->pose->R, own, d);
  for (int i = 0; i < 3; i++) x[i] += d[i];
}

/* The middle of the rim of an end. */
static void middle_of(const clip *c, const side *p, int k, double *x)
{
  put(c, p, p->cone && k == 0 ? p->solid->point : p->face.x[k], x);
}

/* Corners of side s on the polygon of the other. */
static void add_corners(clip *c, int s)
{
  side *p = &c->of[s];
  const side *base = &c->of[1 - s];
  const double down[3] = {-base->normal[0], -base->normal[1], -base->normal[2]};
  int first = 1 + (s ? c->of[0].solid->points : 0);
  if (base->face.count < 3) return;
  for (int k = 0; k < p->face.count; k++) {
    double x[3], foot[3];
    if (!is_over(base, p->x[k], p->flat[k], c->beside)) continue;
    surface(c, p, k, down, x);
    double height = nsdae_dot3(base->normal, x) - nsdae_dot3(base->normal, base->x[0]);
    for (int i = 0; i < 3; i++) foot[i] = x[i] - height * base->normal[i];
    add(c, first + p->face.id[k], s ? 1 : -1, base->normal, height, s ? foot : x, s ? x : foot);
  }
}

/* ---- edges across edges
 *
 * Lines and rims have the unit tangents e_s and the curvatures k_s towards N_s. They are nearest to
 * each other, or at a stationary distance, where d = x_1 - x_0 is at right angles to both:
 *
 *   e_0 . d = 0,  e_1 . d = 0     derivatives by the arc length of each:
 *
 *   ( k_0 N_0 . d - 1     e_0 . e_1       )
 *   ( - e_0 . e_1         1 + k_1 N_1 . d )
 *
 * Newton's method begins where they cross, seen along the normal. Of lines its first step is exact;
 * of contacts of a gap below a tenth of the radius four give all digits. */
enum { NEWTON_STEPS = 6 };
static const double converged = 1e-13; /* of the sizes: a few hundred roundings */

/* x := the point of the rim that is nearest to x, e its tangent, bend = N / r. */
static void to_rim(const side *p, double *x, double *e, double *bend)
{
  double centre[3], d[3];
  centre_of(p, centre);
  for (int i = 0; i < 3; i++) d[i] = x[i] - centre[i];
  double height = nsdae_dot3(d, p->normal);
  for (int i = 0; i < 3; i++) d[i] -= height * p->normal[i];
  nsdae_unit_vector(d, d);
  for (int i = 0; i < 3; i++) {
    x[i] = centre[i] + p->face.disc * d[i];
    bend[i] = -d[i] / p->face.disc;
  }
  nsdae_cross3(p->normal, d, e);
}

/* Edge k from its corner on along the unit vector e; its length. */
static double line_of(const side *p, int k, double *from, double *e)
{
  memcpy(from, p->x[k], 3 * sizeof *from);
  for (int i = 0; i < 3; i++) e[i] = p->x[(k + 1) % p->face.count][i] - from[i];
  double length = sqrt(nsdae_dot3(e, e));
  for (int i = 0; i < 3; i++) e[i] /= length;
  return length;
}

/* The line of the side of a cone that a line along e crosses is that whose normal is at right
 * angles to it. With the radius r, the height h and the axis u that is n ~ h e_r + r u:
 *
 *   h e . e_r = - r e . u
 *
 * for two e_r, of which one is on the side of out. 0: e is along none. */
static int aim_across(const clip *c, side *p, const double *e, const double *out)
{
  const double *u = p->solid->R + 6, r = p->solid->half[0], h = 2 * p->solid->half[2];
  double own[3], to[3], w[3], beside[3], d[3], x[3];
  nsdae_turn_back(p->pose->R, e, own);
  nsdae_turn_back(p->pose->R, out, to);
  double along = nsdae_dot3(own, u);
  for (int i = 0; i < 3; i++) w[i] = own[i] - along * u[i];
  double cosine = -r * along / (h * sqrt(nsdae_dot3(w, w)));
  if (!(fabs(cosine) < 1) || !nsdae_unit_vector(w, w)) return 0;
  nsdae_cross3(u, w, beside);
  double sine = sqrt(1 - cosine * cosine) * (nsdae_dot3(beside, to) < 0 ? -1 : 1);
  for (int i = 0; i < 3; i++) d[i] = cosine * w[i] + sine * beside[i];
  nsdae_turn(p->pose->R, d, x);
  aim(c, p, x);
  return 1;
}

/* Where a line crosses a rim, seen along the normal of that: |from + t e - centre| = r across it,
 * the larger or the smaller t. 0: it does not. */
static int line_on_rim(const side *rim, int larger, double *x, const double *e)
{
  double centre[3], d[3], a[3], b[3];
  centre_of(rim, centre);
  for (int i = 0; i < 3; i++) d[i] = x[i] - centre[i];
  nsdae_cross3(rim->normal, e, a);
  nsdae_cross3(rim->normal, d, b);
  double square = nsdae_dot3(a, a), half = nsdae_dot3(a, b) / square;
  double left = half * half - (nsdae_dot3(b, b) - rim->face.disc * rim->face.disc) / square;
  if (!(left > 0)) return 0;
  double t = -half + (larger ? sqrt(left) : -sqrt(left));
  for (int i = 0; i < 3; i++) x[i] += t * e[i];
  return 1;
}

/* Where two rims cross, seen along the normal n: at a along the way between their centres, of
 * length d, and h beside it. */
static int rim_on_rim(const clip *c, int larger, double *x)
{
  const double *n = c->nearest->normal, r0 = c->of[0].face.disc, r1 = c->of[1].face.disc;
  double centre[2][3], way[3], beside[3];
  for (int s = 0; s < 2; s++) centre_of(&c->of[s], centre[s]);
  for (int i = 0; i < 3; i++) way[i] = centre[1][i] - centre[0][i];
  double height = nsdae_dot3(n, way);
  for (int i = 0; i < 3; i++) way[i] -= height * n[i];
  double d = sqrt(nsdae_dot3(way, way)), a = (d * d + r0 * r0 - r1 * r1) / (2 * d);
  if (!(fabs(a) < r0) || !nsdae_unit_vector(way, way)) return 0;
  double h = (larger ? 1 : -1) * sqrt(r0 * r0 - a * a);
  nsdae_cross3(n, way, beside);
  for (int i = 0; i < 3; i++) x[i] = centre[0][i] + a * way[i] + h * beside[i];
  return 1;
}

/* Edge at[0] of side 0 and at[1] of side 1, of a rim its first or second crossing, at more than the
 * angle of the tilt: else their ends touch; within both by more than a little: beyond, a corner is
 * over the other. See line_line in narrow_phase.c. */
static void add_crossing(clip *c, const int at[2])
{
  const double *n = c->nearest->normal;
  double x[2][3], e[2][3], bend[2][3] = {{0}}, from[2][3], length[2], d[3], m[3], turned[3],
                           gap = 0;
  const double size = c->of[0].solid->size + c->of[1].solid->size;
  int rims = 0;
  for (int s = 0; s < 2; s++) {
    if (c->of[s].face.disc > 0) {
      rims |= 1 << s;
      continue;
    }
    length[s] = line_of(&c->of[s], at[s], x[s], e[s]);
    memcpy(from[s], x[s], sizeof d);
  }
  if (rims == 3 && !rim_on_rim(c, at[0], x[0])) return;
  if (rims == 1 && !line_on_rim(&c->of[0], at[0], x[1], e[1])) return;
  if (rims == 2 && !line_on_rim(&c->of[1], at[1], x[0], e[0])) return;
  for (int s = 0; s < 2; s++) {
    if (!(rims >> s & 1)) continue;
    memcpy(x[s], x[rims == 3 ? 0 : 1 - s], sizeof d);
    to_rim(&c->of[s], x[s], e[s], bend[s]);
  }
  for (int step = 0; step < (rims ? NEWTON_STEPS : 1); step++) {
    for (int s = 0; s < 2; s++) {
      const double out[3] = {s ? -n[0] : n[0], s ? -n[1] : n[1], s ? -n[2] : n[2]};
      if (!c->of[s].cone) continue;
      if (!aim_across(c, &c->of[s], e[1 - s], out)) return;
      length[s] = line_of(&c->of[s], 0, from[s], e[s]);
      memcpy(x[s], from[s], sizeof d);
    }
    for (int i = 0; i < 3; i++) d[i] = x[1][i] - x[0][i];
    double cosine = nsdae_dot3(e[0], e[1]), f[2] = {nsdae_dot3(e[0], d), nsdae_dot3(e[1], d)};
    double j0 = nsdae_dot3(bend[0], d) - 1, j1 = nsdae_dot3(bend[1], d) + 1;
    double determinant = j0 * j1 + cosine * cosine;
    if (!(determinant < -NSDAE_TILT * NSDAE_TILT)) return; /* of lines -sin^2 */
    const double along[2] = {(cosine * f[1] - j1 * f[0]) / determinant,
                             -(j0 * f[1] + cosine * f[0]) / determinant};
    for (int s = 0; s < 2; s++) {
      for (int i = 0; i < 3; i++) x[s][i] += along[s] * e[s][i];
      if (rims >> s & 1) to_rim(&c->of[s], x[s], e[s], bend[s]);
    }
  }
  nsdae_cross3(e[0], e[1], m);
  double sign = nsdae_dot3(m, n) < 0 ? -1 : 1;
  if (!nsdae_unit_vector(m, m)) return;
  for (int i = 0; i < 3; i++) {
    m[i] *= sign;
    d[i] = x[1][i] - x[0][i];
  }
  if (nsdae_dot3(m, n) < 1 - NSDAE_TILT * NSDAE_TILT) return;
  nsdae_cross3(m, d, turned);
  if (nsdae_dot3(turned, turned) > converged * converged * size * size) return;
  for (int s = 0; s < 2; s++) {
    if (rims >> s & 1) continue;
    for (int i = 0; i < 3; i++) d[i] = x[s][i] - from[s][i];
    double along = nsdae_dot3(d, e[s]);
    if (fmin(along, length[s] - along) <= c->beside) return;
  }
  for (int i = 0; i < 3; i++) {
    for (int s = 0; s < 2; s++) x[s][i] += (s ? -1 : 1) * c->of[s].face.round * m[i];
    gap += m[i] * (x[1][i] - x[0][i]);
  }
  int ids[2] = {c->of[0].solid->points, c->of[1].solid->points};
  add(c, 1 + ids[0] + ids[1] + c->of[0].face.id[at[0]] * ids[1] + c->of[1].face.id[at[1]], 1, m,
      gap, x[0], x[1]);
}

/* Edges of a face: one of a segment; of a rim the crossings of it, two. */
static int edges_of(const nsdae_face *f)
{
  return f->count == 2 ? 1 : f->disc > 0 ? 2 : f->count;
}

/* Two rims cross at the two places alone. */
static void add_crossings(clip *c)
{
  const nsdae_face *f[2] = {&c->of[0].face, &c->of[1].face};
  int rims = f[0]->disc > 0 && f[1]->disc > 0;
  for (int k = 0; k < edges_of(f[0]); k++)
    for (int l = rims ? k : 0; l < (rims ? k + 1 : edges_of(f[1])); l++)
      add_crossing(c, (const int[]){k, l});
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
  side *p = &c->of[s], *other = &c->of[1 - s];
  double a[3], x[3], foot[3], middle[3], sign = s ? -1 : 1;
  for (int k = 0; k < 2; k++) {
    middle_of(c, p, k, middle);
    if (foot_on(other, p->x[k], foot) > c->beside) continue;
    for (int pass = 0; pass < 5; pass++) {
      for (int i = 0; i < 3; i++) a[i] = foot[i] - middle[i];
      if (!nsdae_unit_vector(a, a)) memcpy(a, c->nearest->normal, sizeof a);
      surface(c, p, k, a, x);
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

/* The same along the side of a cone, at a plane that is tangent to it. Its line at e_r about the
 * axis u has the normal n ~ h e_r + r u. The point x of the end, of a rim of the radius R, is
 * foremost along -n:
 *
 *   F = (x - base) . t = 0,  t = u x e_r,     F' = - (x - base) . e_r - R up to the tilt
 *
 * by the angle of e_r. Each pass of Newton's method reduces the error by the tilt. */
enum { CONE_PASSES = 12 };

static void add_ends_on_cone(clip *c, int s)
{
  side *p = &c->of[s], *cone = &c->of[1 - s];
  const double r = cone->solid->half[0], h = 2 * cone->solid->half[2], side_length = hypot(r, h);
  double base[3], u[3], start[3], sign = s ? 1 : -1;
  put(c, cone, cone->solid->point, base);
  nsdae_turn(cone->pose->R, cone->solid->R + 6, u);
  for (int i = 0; i < 3; i++) start[i] = (cone->x[0][i] - base[i]) / r;
  for (int k = 0; k < 2; k++) {
    double e[3], t[3], n[3], x[3], back[3], foot[3], height = 0;
    double rim = p->cone ? (k == 0) * p->solid->half[0] : p->face.round;
    memcpy(e, start, sizeof e);
    for (int pass = 0;; pass++) {
      double F = 0, out = 0;
      for (int i = 0; i < 3; i++) {
        n[i] = (h * e[i] + r * u[i]) / side_length;
        back[i] = -n[i];
      }
      surface(c, p, k, back, x);
      if (pass == CONE_PASSES) break;
      nsdae_cross3(u, e, t);
      for (int i = 0; i < 3; i++) {
        F += (x[i] - base[i]) * t[i];
        out += (x[i] - base[i]) * e[i];
      }
      for (int i = 0; i < 3; i++) e[i] += F / (fmax(out, 0) + rim + c->beside) * t[i];
      nsdae_unit_vector(e, e);
    }
    aim(c, cone, e);
    if (foot_on(cone, x, foot) > c->beside) continue;
    for (int i = 0; i < 3; i++) height += n[i] * (x[i] - cone->x[0][i]);
    for (int i = 0; i < 3; i++) foot[i] = x[i] - height * n[i];
    add(c, 1 + (s ? c->of[0].solid->points : 0) + p->face.id[k], sign, n, height, s ? foot : x,
        s ? x : foot);
  }
  aim(c, cone, start);
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
      (c.of[1 - s].cone ? add_ends_on_cone : add_ends)(&c, s);
  }
  if (!segments) add_crossings(&c);
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
