#include "seams.h"

#include <float.h>

#include "mesh.h"
#include "separating_axis.h"

/* In parts of eps: where n goes into a solid; how far out of it is not flush; how deep beneath its
 * face that is looked for. And solids that cover each other's ways out: of a corner three. */
static const double into = 2, out = 2, deep = 8;
enum { WAYS = 3 };

/* Cosine of two faces of a solid that are not one. */
static const double upright = 0.5;

/* How well a normal is known: of flat parts with the drift that event allows; of a manifold, whose
 * places are known to 1e-9 (gjk.c). Of a ball it is exact: on a seam it would roll off to its side
 * otherwise. */
static const double drift = 1e-9, nearly = 1e-6;

/* The pair whose contacts are looked for, and solids that may cover places of it, which are in a
 * ball; more than these, and beyond it, are looked for at each place. */
enum { NEAR = 24 };
typedef struct sieve {
  const nsdae_broad *p;
  int solid[2];                /* in the order of the pair */
  int covers, cover[NEAR];     /* covers -1: not known */
  double middle[3], ball, eps; /* eps: of the larger solid */
  double reach, share;         /* share: eps in parts of the size */
  nsdae_seen_fn add;
  void *to;
} sieve;

/* The side of a contact that is on a solid. */
typedef struct place {
  const sieve *s;
  int of, other; /* the solid; the one that touches it */
  double n[3];   /* out of it */
  double eps;    /* of the solid */
  int face;
  double angle; /* up to which n is known; 0: rounding */
} place;

/* A place in the frame of the body of a solid. */
typedef struct view {
  const place *a;
  const nsdae_solid_of *s;
  const nsdae_pose *pose;
  const double *at; /* the place itself */
  double x[3], n[3];
  double eps, slack, rounding; /* slack: of n . y; rounding: of places */
  double more, off; /* the largest n . y of it; how far x is from its faces, of those within eps */
  int into, ways, beside; /* beside: stands_beside */
} view;

/* ---- a solid as planes, in the frame of its body */

static inline int planes_of(const nsdae_solid_of *s)
{
  if (s->shape == NSDAE_SHAPE_PLANE) return 1;
  if (s->radius > 0) return 0;
  if (s->hull) return s->hull->faces;
  return s->points < 2 || nsdae_solid_is_smooth(s) ? 0 : s->points > 2 ? s->points : 3;
}

/* Whether it can cover a place. */
static inline int is_flat(const nsdae_solid_of *s)
{
  return s->mesh != NULL || planes_of(s) > 0;
}

/* The outer normal of plane i, and the height of x over it. May use room. */
static inline const double *plane_of(const nsdae_solid_of *s, int i, const double *x,
                                     double *height, double room[3])
{
  const double *n = s->R + 6, *at = s->origin; /* of a plane */
  if (s->hull) {
    n = s->edge + 4L * i;
    *height = nsdae_dot3(n, x) - n[3];
    return n;
  }
  if (s->points > 0) at = nsdae_solid_corner(s, i % s->points);
  if (s->points > 2) n = s->edge + 4L * i;
  if (s->points == 2) { /* a line: its ends, and its upper side */
    n = i == 2 ? s->R + 3 : room;
    for (int j = 0; j < 3; j++) room[j] = (i ? 1 : -1) * s->R[j];
  }
  *height = nsdae_dot3(n, x) - nsdae_dot3(n, at);
  return n;
}

static int holds_it(void *to, int t)
{
  const view *v = to;
  return nsdae_mesh_is_beneath(v->s->mesh, t, v->x, v->eps);
}

/* Whether x is in a solid, or beside it by no more than eps. */
static int holds(view *v)
{
  int planes = planes_of(v->s), in = planes > 0;
  double height, room[3];
  if (v->s->mesh) return nsdae_mesh_about(v->s->mesh, v->x, v->eps, holds_it, v);
  for (int i = 0; i < planes && in; i++) {
    plane_of(v->s, i, v->x, &height, room);
    in = height <= v->eps;
  }
  return in;
}

/* ---- what covers a place */

/* How large its parts are that can cover. */
static inline double extent(const nsdae_solid_of *s)
{
  return s->shape == NSDAE_SHAPE_PLANE ? INFINITY : s->size;
}

/* Its place from solid i. */
static void put_place(view *v, const place *a, int i, const double *at)
{
  const nsdae_broad *p = a->s->p;
  double d[3];
  v->a = a;
  v->s = nsdae_solid_at(p->b, i);
  v->pose = nsdae_broad_pose(p, v->s->body);
  v->at = at;
  for (int j = 0; j < 3; j++) d[j] = at[j] - v->pose->r[j];
  nsdae_turn_back(v->pose->R, d, v->x);
  v->eps = a->s->share * 2 * extent(v->s);
  if (!(v->eps < a->eps)) v->eps = a->eps;
}

/* And its direction and tolerances. */
static void put_direction(view *v)
{
  const place *a = v->a;
  double most = 0, size = extent(v->s);
  if (isinf(size)) size = nsdae_solid_at(a->s->p->b, a->of)->size;
  for (int j = 0; j < 3; j++) most += fabs(v->at[j]) + fabs(v->pose->r[j]);
  double least = 64 * DBL_EPSILON * (most + size);
  nsdae_turn_back(v->pose->R, a->n, v->n);
  v->rounding = (a->angle == nearly ? 10 * drift : 0) * size + least;
  v->slack = a->angle * size + least;
}

static int is_hidden(const place *a, const double *x, int ways);

/* Whether the solid of the place comes out of s at a face of it, of the normal m and `height` of x
 * over it: at x + (2 eps - height) t / |t|^2 with t the part of m across n. */
static int comes_out(const view *v, const double *m, double height)
{
  const place *a = v->a;
  if (height < -deep * v->eps || height > v->eps) return 0;
  double along = nsdae_dot3(m, v->n), square = 1 - along * along, y[3], there[3];
  if (!(square > DBL_EPSILON)) return 0;
  double way = (out * v->eps - height) / square;
  view of;
  for (int j = 0; j < 3; j++) y[j] = v->x[j] + way * (m[j] - along * v->n[j]);
  nsdae_pose_put(v->pose, y, there);
  put_place(&of, a, a->of, there);
  of.eps = v->rounding;
  return holds(&of) && !is_hidden(a, there, v->ways - 1);
}

static int comes_out_of_triangle(void *to, int t)
{
  const view *v = to;
  const nsdae_mesh *m = v->s->mesh;
  return nsdae_mesh_is_beneath(m, t, v->x, v->eps) &&
         comes_out(v, m->normal + 3L * t, nsdae_mesh_height(m, t, v->x));
}

/* Of a face of the normal m: for a place on a face whether n goes into it, else what is off. */
static inline void measure_face(view *v, const double *m, double height)
{
  if (v->a->face) {
    int goes = height + into * v->eps * nsdae_dot3(m, v->n) <= v->eps;
    v->into = v->s->mesh ? v->into || goes : v->into && goes;
  } else if (fabs(height) <= v->eps) {
    v->off = nsdae_more_of(v->off, fabs(height));
  }
}

static int measure_triangle(void *to, int t)
{
  view *v = to;
  const nsdae_mesh *m = v->s->mesh;
  if (!nsdae_mesh_is_beneath(m, t, v->x, v->eps)) return 0;
  measure_face(v, m->normal + 3L * t, nsdae_mesh_height(m, t, v->x));
  for (int k = 0; k < 3; k++)
    v->more = nsdae_more_of(v->more, nsdae_dot3(v->n, nsdae_mesh_corner(m, t, k)));
  return 0;
}

/* Whether n goes into a solid from x, which it holds. Nothing covers faces of a mesh. */
static int goes_into(view *v)
{
  const nsdae_solid_of *s = v->s;
  int planes = planes_of(s);
  double height, room[3], from = nsdae_dot3(v->n, v->x);
  if (v->a->face && nsdae_solid_at(v->a->s->p->b, v->a->of)->mesh) return 0;
  v->into = s->mesh == NULL;
  v->off = 0;
  v->more = -INFINITY;
  if (s->mesh) nsdae_mesh_about(s->mesh, v->x, v->eps, measure_triangle, v);
  for (int i = 0; i < planes; i++) {
    const double *n = plane_of(s, i, v->x, &height, room);
    measure_face(v, n, height);
    if (s->shape == NSDAE_SHAPE_PLANE) v->more = from + 1 - nsdae_dot3(n, v->n); /* a length of 1 */
  }
  if (v->a->face) return v->into;
  from += v->off + v->slack;
  for (int i = 0; i < s->points && v->more <= from; i++)
    v->more = nsdae_dot3(v->n, nsdae_solid_corner(s, i));
  return v->more > from;
}

/* Whether all of the solid that touches is beyond plane f of the other, at which x is: what covers
 * that face bears it. f is not the face of the contact. */
static int is_beyond(const view *v, const double *f, double height)
{
  if (fabs(height) > v->slack || nsdae_dot3(f, v->n) > upright) return 0;
  const nsdae_broad *p = v->a->s->p;
  const nsdae_solid_of *other = nsdae_solid_at(p->b, v->a->other);
  const nsdae_pose *pose = nsdae_broad_pose(p, other->body);
  double m[3], own[3], least = -v->slack - height;
  if (other->radius > 0 || other->points < 2 || nsdae_solid_is_smooth(other)) return 0;
  nsdae_turn(v->pose->R, f, m);
  nsdae_turn_back(pose->R, m, own);
  for (int j = 0; j < 3; j++) least -= m[j] * (pose->r[j] - v->at[j]);
  for (int i = 0; i < other->points; i++)
    if (nsdae_dot3(own, nsdae_solid_corner(other, i)) < least) return 0;
  return 1;
}

static int is_beyond_border(void *to, int t)
{
  const view *v = to;
  const nsdae_mesh *m = v->s->mesh;
  int beyond = 0;
  for (int k = 0; k < 3 && !beyond; k++) {
    double e[3], f[3];
    if (m->beside[t][k] >= 0) continue;
    for (int j = 0; j < 3; j++)
      e[j] = nsdae_mesh_corner(m, t, k + 1)[j] - nsdae_mesh_corner(m, t, k)[j];
    nsdae_cross3(e, m->normal + 3L * t, f);
    beyond = nsdae_unit_vector(f, f) && is_beyond(v, f, nsdae_mesh_beyond(m, t, k, v->x));
  }
  return beyond;
}

/* The same for a plane that is covered, or a border of a mesh. */
static int stands_beside(view *v)
{
  int planes = planes_of(v->s), beyond = 0;
  double height, room[3];
  if (v->s->mesh) return nsdae_mesh_about(v->s->mesh, v->x, v->slack, is_beyond_border, v);
  for (int i = 0; i < planes && !beyond; i++) {
    const double *n = plane_of(v->s, i, v->x, &height, room);
    beyond = fabs(height) <= v->slack && is_beyond(v, n, height);
  }
  return beyond;
}

/* Whether solid i hides a place, of which its own solid's view is given: 1, or 0. */
static int hides(void *to, int i)
{
  view *of = to, v;
  const place *a = of->a;
  const nsdae_broad *p = a->s->p;
  double height, room[3];
  if (i == a->of || i == a->other || !is_flat(nsdae_solid_at(p->b, i))) return 0;
  put_place(&v, a, i, of->at);
  if (!holds(&v) || !nsdae_broad_touches(p, i, a->other)) return 0;
  if (!of->s) { /* the first that holds it */
    put_place(of, a, a->of, of->at);
    put_direction(of);
    of->beside = of->ways == WAYS && stands_beside(of);
  }
  if (of->beside) return 1;
  put_direction(&v);
  v.ways = of->ways;
  if (!goes_into(&v)) return !a->face && goes_into(of);
  if (v.ways == 0) return 1;
  if (v.s->mesh) return !nsdae_mesh_about(v.s->mesh, v.x, v.eps, comes_out_of_triangle, &v);
  int planes = planes_of(v.s), comes = 0;
  for (int f = 0; f < planes && !comes; f++) {
    const double *n = plane_of(v.s, f, v.x, &height, room);
    comes = height >= -deep * v.eps && comes_out(&v, n, height);
  }
  return !comes;
}

static int is_hidden(const place *a, const double *x, int ways)
{
  const sieve *s = a->s;
  double d[3] = {x[0] - s->middle[0], x[1] - s->middle[1], x[2] - s->middle[2]};
  int code = 0;
  view of;
  of.a = a;
  of.s = NULL;
  of.at = x;
  of.ways = ways;
  if (s->covers > NEAR || nsdae_dot3(d, d) > s->ball * s->ball)
    return nsdae_broad_about(s->p, x, a->eps, hides, &of);
  for (int i = 0; i < s->covers && !code; i++)
    if (nsdae_broad_is_about(s->p, s->cover[i], x, a->eps)) code = hides(&of, s->cover[i]);
  return code;
}

/* ---- contacts of a pair */

/* Whether a place is on a face, further inside its edges than eps. */
static int is_inside(const place *a, const double *x)
{
  double height, room[3];
  view v;
  put_place(&v, a, a->of, x);
  nsdae_turn_back(v.pose->R, a->n, v.n);
  int planes = planes_of(v.s), in = planes > 0;
  for (int i = 0; i < planes && in; i++) {
    const double *n = plane_of(v.s, i, v.x, &height, room);
    in = height <= -v.eps || nsdae_dot3(n, v.n) > 1 - nearly;
  }
  return in;
}

/* Solid i may cover places of the pair: part of it is in their ball. */
static int gather(void *to, int i)
{
  sieve *s = to;
  place a = {.s = s, .eps = s->eps};
  view v;
  if (i == s->solid[0] || i == s->solid[1] || !is_flat(nsdae_solid_at(s->p->b, i))) return 0;
  put_place(&v, &a, i, s->middle);
  v.eps += s->ball;
  if (!v.s->mesh && !holds(&v)) return 0;
  if (s->covers < NEAR) s->cover[s->covers] = i;
  return ++s->covers > NEAR;
}

/* The ball has the places of both: these are in the balls of radii r <= R about the solids, whose
 * spheres meet in a circle, in a plane that is a from the middle of the smaller one:
 *
 *   a = (d^2 + r^2 - R^2) / (2 d),   radius^2 = r^2 - a^2,   or all of the smaller one if a < 0. */
static void find_covers(sieve *s)
{
  const nsdae_broad *p = s->p;
  int least = s->solid[p->radius[s->solid[0]] > p->radius[s->solid[1]]];
  int other = s->solid[least == s->solid[0]];
  double eps = s->share * 2 * p->radius[least], more = s->reach + (deep + out) * eps;
  double r = p->radius[least] + more, R = p->radius[other] + more, d[3];
  for (int j = 0; j < 3; j++) d[j] = p->centre[3 * other + j] - p->centre[3 * least + j];
  double square = nsdae_dot3(d, d), part = fmax(0, (square + r * r - R * R) / (2 * square));
  if (!(square > 0)) part = 0;
  s->ball = sqrt(fmax(0, r * r - part * part * square));
  for (int j = 0; j < 3; j++) s->middle[j] = p->centre[3 * least + j] + part * d[j];
  s->covers = 0;
  s->eps = s->share * 2 * nsdae_solid_at(p->b, other)->size;
  nsdae_broad_about(p, s->middle, s->ball + s->eps, gather, s);
}

/* Whether one side of a contact is hidden. */
static int is_covered(const sieve *s, const nsdae_closest *closest, const nsdae_still *at,
                      const nsdae_couple *two)
{
  int turned = two->solid[0] != nsdae_solid_at(s->p->b, s->solid[0]), hidden = 0;
  int exact = nsdae_pair_is_exact(two->solid[0], two->solid[1]);
  int face = exact && closest->kind == NSDAE_PLANE_POINT;
  int ball = closest->kind == NSDAE_POINT_POINT || closest->kind == NSDAE_LINE_POINT;
  for (int i = 0; i < 2 && !hidden; i++) {
    place a = {.s = s,
               .of = s->solid[i ^ turned],
               .other = s->solid[1 - (i ^ turned)],
               .face = face && i == 0,
               .eps = s->share * 2 * two->solid[i]->size,
               .angle = !exact ? nearly
                        : ball ? 0
                               : drift};
    for (int j = 0; j < 3; j++) a.n[j] = i ? -at->normal[j] : at->normal[j];
    hidden = is_flat(two->solid[i]) && !(a.face && is_inside(&a, at->at[i])) &&
             is_hidden(&a, at->at[i], WAYS);
  }
  return hidden;
}

static int sift(void *to, long number, const nsdae_closest *closest, const nsdae_couple *two)
{
  sieve *s = to;
  const nsdae_still at = nsdae_closest_still(closest, two);
  if (at.gap > s->reach) return 0;
  if (s->covers < 0) find_covers(s);
  if (s->covers > 0 && is_covered(s, closest, &at, two)) return 0;
  return s->add(s->to, number, closest, &at, two);
}

/* share 0: nothing hides them. */
static int find_contacts(const nsdae_broad *p, int i, int j, double reach, double share,
                         nsdae_seen_fn add, void *to)
{
  const nsdae_solid_of *solids = p->b->solid.at;
  int turned = nsdae_pair_is_turned(&solids[i], &solids[j]);
  sieve s = {.p = p, .solid = {turned ? j : i, turned ? i : j}, .reach = reach, .share = share};
  nsdae_couple two;
  for (int k = 0; k < 2; k++) {
    two.solid[k] = &solids[s.solid[k]];
    two.pose[k] = nsdae_broad_pose(p, two.solid[k]->body);
  }
  s.add = add;
  s.to = to;
  if (share > 0 && two.solid[0]->shape != NSDAE_SHAPE_PLANE)
    s.covers = is_flat(two.solid[0]) || is_flat(two.solid[1]) ? -1 : 0;
  return nsdae_pair_contacts(solids, i, j, &two, reach, sift, &s);
}

int nsdae_seen_contacts(const nsdae_broad *p, int i, int j, double reach, int fine,
                        nsdae_seen_fn add, void *to)
{
  return find_contacts(p, i, j, reach, fine ? NSDAE_SLACK : NSDAE_BESIDE, add, to);
}

int nsdae_named_contacts(const nsdae_broad *p, int i, int j, double reach, nsdae_seen_fn add,
                         void *to)
{
  return find_contacts(p, i, j, reach, 0, add, to);
}
