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

/* Solids that may cover places of both of a pair; more are looked for at each place. */
enum { NEAR = 24 };
typedef struct covers {
  int count, solid[NEAR]; /* -1: not known */
} covers;

/* The side of a contact that is on a solid. */
typedef struct place {
  const nsdae_broad *p;
  const covers *covers;
  int of, other; /* the solid; the one that touches it */
  double n[3];   /* out of it */
  int face;
  double share; /* eps in parts of the size */
  double angle; /* up to which n is known; 0: rounding */
} place;

/* ---- a solid as planes
 *
 * Plane i, in the frame of its body: outer normal n and n . x of its points. */

static int planes_of(const nsdae_solid_of *s)
{
  int planar = s->points > 1 && !s->hull && !nsdae_solid_is_smooth(s);
  if (s->shape == NSDAE_SHAPE_PLANE) return 1;
  if (s->radius > 0) return 0;
  return s->hull ? s->hull->faces : !planar ? 0 : s->points > 2 ? s->points : 3;
}

/* Whether it can cover a place. */
static int is_flat(const nsdae_solid_of *s)
{
  return s->mesh != NULL || planes_of(s) > 0;
}

static void plane_of(const nsdae_solid_of *s, int i, double *plane)
{
  if (s->hull) {
    for (int j = 0; j < 4; j++) plane[j] = s->edge[4 * i + j];
    return;
  }
  const double *at = s->points > 0 ? s->point + 3 * (i % s->points) : s->origin;
  for (int j = 0; j < 3; j++)
    plane[j] = s->shape == NSDAE_SHAPE_PLANE ? s->R[6 + j]
               : s->points > 2               ? s->edge[4 * i + j]
               : i == 2 ? s->R[3 + j] /* a line: its ends, and its upper side */
                        : (i ? 1 : -1) * s->R[j];
  plane[3] = nsdae_dot3(plane, at);
}

/* The largest n . (y - x) of its corners y. */
static double beyond(const nsdae_solid_of *s, const double *x, const double *n)
{
  double most = -INFINITY;
  for (int i = 0; i < s->points; i++) most = fmax(most, nsdae_dot3(n, nsdae_solid_corner(s, i)));
  return most - nsdae_dot3(n, x);
}

/* Whether x is in a solid, or beside it by no more than eps. */
static int holds(const nsdae_solid_of *s, const double *x, double eps);

typedef struct search {
  const place *a;
  const nsdae_solid_of *s;
  const nsdae_pose *pose;
  const double *x, *n; /* in the frame of its body */
  double eps;
  double more, off; /* how far it goes beyond x along n; x from its faces, of those within eps */
  double slack;     /* of more */
  double rounding;  /* of places */
  int ways, into;
  int of_mesh; /* the place is on one, whose faces nothing covers */
} search;

static int holds_it(void *to, int t)
{
  const search *s = to;
  const nsdae_mesh *m = s->s->mesh;
  return nsdae_mesh_is_beneath(m, t, s->x, s->eps);
}

static int holds(const nsdae_solid_of *s, const double *x, double eps)
{
  int planes = planes_of(s), in = planes > 0;
  search about = {.s = s, .x = x, .eps = eps};
  if (s->mesh) return nsdae_mesh_about(s->mesh, x, eps, holds_it, &about);
  for (int i = 0; i < planes && in; i++) {
    double plane[4];
    plane_of(s, i, plane);
    in = nsdae_dot3(plane, x) - plane[3] <= eps;
  }
  return in;
}

/* ---- what covers a place */

/* How large its parts are that can cover. */
static double extent(const nsdae_solid_of *s)
{
  return s->shape == NSDAE_SHAPE_PLANE ? INFINITY : s->size;
}

static int is_hidden(const place *a, const double *x, int ways);

/* Whether the solid of the place comes out of s at a face of it, of the normal m and `height` of x
 * over it: at x + (2 eps - height) t / |t|^2 with t the part of m across n. */
static int comes_out(const search *s, const double *m, double height)
{
  const place *a = s->a;
  const nsdae_solid_of *of = nsdae_solid_at(a->p->b, a->of);
  double along = nsdae_dot3(m, s->n), square = 1 - along * along, way, y[3], there[3], d[3];
  if (height < -deep * s->eps || height > s->eps || !(square > DBL_EPSILON)) return 0;
  way = (out * s->eps - height) / square;
  for (int j = 0; j < 3; j++) y[j] = s->x[j] + way * (m[j] - along * s->n[j]);
  nsdae_pose_put(s->pose, y, there);
  const nsdae_pose *pose = nsdae_broad_pose(a->p, of->body);
  for (int j = 0; j < 3; j++) d[j] = there[j] - pose->r[j];
  nsdae_turn_back(pose->R, d, y);
  return holds(of, y, s->rounding) && !is_hidden(a, there, s->ways - 1);
}

static int measure_triangle(void *to, int t)
{
  search *s = to;
  const nsdae_mesh *m = s->s->mesh;
  const double *n = m->normal + 3L * t;
  double height = nsdae_mesh_height(m, t, s->x), y[3];
  if (!nsdae_mesh_is_beneath(m, t, s->x, s->eps)) return 0;
  if (fabs(height) <= s->eps) s->off = fmax(s->off, fabs(height));
  for (int k = 0; k < 3; k++) {
    for (int j = 0; j < 3; j++) y[j] = nsdae_mesh_corner(m, t, k)[j] - s->x[j];
    s->more = fmax(s->more, nsdae_dot3(s->n, y));
  }
  s->into |= height + into * s->eps * nsdae_dot3(n, s->n) <= s->eps;
  return 0;
}

static int comes_out_of_triangle(void *to, int t)
{
  const search *s = to;
  const nsdae_mesh *m = s->s->mesh;
  return nsdae_mesh_is_beneath(m, t, s->x, s->eps) &&
         comes_out(s, m->normal + 3L * t, nsdae_mesh_height(m, t, s->x));
}

/* Whether n goes into a solid from x, which it holds. */
static int goes_into(search *s)
{
  double plane[4];
  s->into = s->s->mesh == NULL;
  s->more = -INFINITY;
  if (s->s->mesh) nsdae_mesh_about(s->s->mesh, s->x, s->eps, measure_triangle, s);
  for (int i = 0; i < planes_of(s->s); i++) {
    plane_of(s->s, i, plane);
    double height = nsdae_dot3(plane, s->x) - plane[3], along = nsdae_dot3(plane, s->n);
    if (fabs(height) <= s->eps) s->off = fmax(s->off, fabs(height));
    s->into &= height + into * s->eps * along <= s->eps;
    if (s->s->shape == NSDAE_SHAPE_PLANE) s->more = 1 - along; /* of a length of 1 */
  }
  if (s->s->points > 0) s->more = beyond(s->s, s->x, s->n);
  return s->a->face ? s->into && !s->of_mesh : s->more > s->off + s->slack;
}

/* x and n in the frame of a solid's body; tolerances. */
typedef struct put {
  double x[3], n[3];
} put;

static search look_from(const place *a, int i, const double *x, put *own)
{
  const nsdae_solid_of *of = nsdae_solid_at(a->p->b, a->of), *s = nsdae_solid_at(a->p->b, i);
  search c = {.a = a, .s = s, .pose = nsdae_broad_pose(a->p, s->body), .x = own->x, .n = own->n};
  double d[3], at = 0, size = isfinite(extent(s)) ? extent(s) : of->size;
  for (int j = 0; j < 3; j++) {
    d[j] = x[j] - c.pose->r[j];
    at += fabs(x[j]) + fabs(c.pose->r[j]);
  }
  nsdae_turn_back(c.pose->R, d, own->x);
  nsdae_turn_back(c.pose->R, a->n, own->n);
  c.of_mesh = of->mesh != NULL;
  c.eps = a->share * 2 * fmin(extent(of), extent(s));
  double least = 64 * DBL_EPSILON * (at + size);
  c.rounding = (a->angle == nearly ? 10 * drift : 0) * size + least;
  c.slack = a->angle * size + least;
  return c;
}

/* Whether all of the solid that touches is beyond plane f of the other, at which x is: what covers
 * that face bears it. f is not the face of the contact. */
static int is_beyond(const search *s, const double *f, double height)
{
  const place *a = s->a;
  const nsdae_solid_of *other = nsdae_solid_at(a->p->b, a->other);
  const nsdae_pose *pose = nsdae_broad_pose(a->p, other->body);
  if (fabs(height) > s->slack || nsdae_dot3(f, s->n) > upright || other->radius > 0) return 0;
  for (int i = 0; i < other->points; i++) {
    double y[3], d[3], own[3];
    nsdae_pose_put(pose, nsdae_solid_corner(other, i), y);
    for (int j = 0; j < 3; j++) d[j] = y[j] - s->pose->r[j];
    nsdae_turn_back(s->pose->R, d, own);
    for (int j = 0; j < 3; j++) d[j] = own[j] - s->x[j];
    if (nsdae_dot3(f, d) + height < -s->slack) return 0;
  }
  return other->points > 1 && !nsdae_solid_is_smooth(other);
}

static int is_beyond_border(void *to, int t)
{
  const search *s = to;
  const nsdae_mesh *m = s->s->mesh;
  int beyond = 0;
  for (int k = 0; k < 3 && !beyond; k++) {
    double e[3], f[3];
    if (m->beside[t][k] >= 0) continue;
    for (int j = 0; j < 3; j++)
      e[j] = nsdae_mesh_corner(m, t, k + 1)[j] - nsdae_mesh_corner(m, t, k)[j];
    nsdae_cross3(e, m->normal + 3L * t, f);
    beyond = nsdae_unit_vector(f, f) && is_beyond(s, f, nsdae_mesh_beyond(m, t, k, s->x));
  }
  return beyond;
}

/* The same for a plane that is covered, or a border of a mesh. */
static int stands_beside(search *s)
{
  if (s->s->mesh) return nsdae_mesh_about(s->s->mesh, s->x, s->slack, is_beyond_border, s);
  for (int i = 0; i < planes_of(s->s); i++) {
    double plane[4];
    plane_of(s->s, i, plane);
    if (is_beyond(s, plane, nsdae_dot3(plane, s->x) - plane[3])) return 1;
  }
  return 0;
}

typedef struct look {
  const place *a;
  const double *x;
  int ways;
} look;

/* Whether solid i hides a place: 1, or 0. */
static int hides(void *to, int i)
{
  const look *l = to;
  const place *a = l->a;
  const nsdae_solid_of *s = nsdae_solid_at(a->p->b, i);
  put own, its;
  if (i == a->of || i == a->other || !is_flat(s)) return 0;
  search c = look_from(a, i, l->x, &its);
  c.ways = l->ways;
  if (!holds(s, c.x, c.eps) || !nsdae_broad_touches(a->p, i, a->other)) return 0;
  search of = look_from(a, a->of, l->x, &own);
  if (l->ways == WAYS && stands_beside(&of)) return 1;
  if (!goes_into(&c)) return !a->face && goes_into(&of);
  if (l->ways == 0) return 1;
  if (s->mesh) return !nsdae_mesh_about(s->mesh, c.x, c.eps, comes_out_of_triangle, &c);
  for (int f = 0; f < planes_of(s); f++) {
    double plane[4];
    plane_of(s, f, plane);
    if (comes_out(&c, plane, nsdae_dot3(plane, c.x) - plane[3])) return 0;
  }
  return 1;
}

static int is_hidden(const place *a, const double *x, int ways)
{
  look l = {a, x, ways};
  double within = a->share * 2 * extent(nsdae_solid_at(a->p->b, a->of));
  int code = 0;
  if (a->covers->count > NEAR) return nsdae_broad_about(a->p, x, within, hides, &l);
  for (int i = 0; i < a->covers->count && !code; i++)
    if (nsdae_broad_is_about(a->p, a->covers->solid[i], x, within))
      code = hides(&l, a->covers->solid[i]);
  return code;
}

/* ---- contacts of a pair */

typedef struct sieve {
  const nsdae_broad *p;
  covers covers;
  int solid[2]; /* in the order of the pair */
  double reach, share;
  nsdae_seen_fn add;
  void *to;
} sieve;

/* Whether a place is on a face, further inside its edges than eps. */
static int is_inside(const sieve *s, const nsdae_solid_of *of, const nsdae_pose *pose,
                     const double *x, const double *n)
{
  double own[3], d[3], out_of[3], eps = s->share * 2 * of->size;
  for (int j = 0; j < 3; j++) d[j] = x[j] - pose->r[j];
  nsdae_turn_back(pose->R, d, own);
  nsdae_turn_back(pose->R, n, out_of);
  for (int i = 0; i < planes_of(of); i++) {
    double plane[4];
    plane_of(of, i, plane);
    if (nsdae_dot3(plane, out_of) > 1 - nearly) continue;
    if (nsdae_dot3(plane, own) - plane[3] > -eps) return 0;
  }
  return planes_of(of) > 0;
}

/* Solid i may cover places of the pair. */
static int gather(void *to, int i)
{
  sieve *s = to;
  const nsdae_solid_of *of = nsdae_solid_at(s->p->b, i);
  int other = s->solid[s->p->radius[s->solid[0]] <= s->p->radius[s->solid[1]]];
  double within = s->p->radius[other] + s->share * 2 * of->size;
  if (i == s->solid[0] || i == s->solid[1] || !is_flat(of)) return 0;
  if (!nsdae_broad_is_about(s->p, i, s->p->centre + 3 * other, within)) return 0;
  if (s->covers.count < NEAR) s->covers.solid[s->covers.count] = i;
  return ++s->covers.count > NEAR;
}

static void find_covers(sieve *s)
{
  int least = s->solid[s->p->radius[s->solid[0]] > s->p->radius[s->solid[1]]];
  double radius = s->p->radius[least];
  s->covers.count = 0;
  nsdae_broad_about(s->p, s->p->centre + 3 * least, (1 + 2 * s->share) * radius, gather, s);
}

static int sift(void *to, long number, const nsdae_closest *closest, const nsdae_couple *two)
{
  sieve *s = to;
  const nsdae_still at = nsdae_closest_still(closest, two);
  if (at.gap > s->reach) return 0;
  int turned = two->solid[0] != nsdae_solid_at(s->p->b, s->solid[0]);
  int exact = nsdae_pair_is_exact(two->solid[0], two->solid[1]);
  int face = exact && closest->kind == NSDAE_PLANE_POINT;
  int ball = closest->kind == NSDAE_POINT_POINT || closest->kind == NSDAE_LINE_POINT;
  int plane = two->solid[0]->shape == NSDAE_SHAPE_PLANE || s->share == 0;
  if (!plane && s->covers.count < 0) find_covers(s);
  int any = !plane && s->covers.count > 0;
  int inside = any && face && is_inside(s, two->solid[0], two->pose[0], at.at[0], at.normal);
  for (int i = inside; i < 2 && any; i++) {
    const nsdae_solid_of *of = two->solid[i];
    if (!is_flat(of)) continue;
    place a = {.p = s->p,
               .covers = &s->covers,
               .of = s->solid[i ^ turned],
               .other = s->solid[1 - (i ^ turned)],
               .face = face && i == 0,
               .share = s->share,
               .angle = !exact ? nearly
                        : ball ? 0
                               : drift};
    for (int j = 0; j < 3; j++) a.n[j] = i ? -at.normal[j] : at.normal[j];
    if (is_hidden(&a, at.at[i], WAYS)) return 0;
  }
  return s->add(s->to, number, closest, &at, two);
}

/* share 0: nothing hides them. */
static int find_contacts(const nsdae_broad *p, int i, int j, double reach, double share,
                         nsdae_seen_fn add, void *to)
{
  const nsdae_solid_of *solids = p->b->solid.at;
  int turned = nsdae_pair_is_turned(&solids[i], &solids[j]);
  sieve s = {.p = p,
             .covers.count = is_flat(&solids[i]) || is_flat(&solids[j]) ? -1 : 0,
             .solid = {turned ? j : i, turned ? i : j},
             .reach = reach,
             .share = share,
             .add = add,
             .to = to};
  nsdae_couple two;
  for (int k = 0; k < 2; k++) {
    two.solid[k] = &solids[s.solid[k]];
    two.pose[k] = nsdae_broad_pose(p, two.solid[k]->body);
  }
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
