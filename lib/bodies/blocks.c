/* The blocks of a mechanism: a body is one, coordinates of one's own are the last; and contacts by
 * list, found by the broad phase. */
#include <stdlib.h>

#include "broad_phase.h"

static int mass_blocks(double t, const double *q, double *M, void *user)
{
  const nsdae_bodies *b = user;
  int nv = nsdae_body_nv(b), d = b->dimension;
  for (int i = 0; i < b->body.count; i++, M += nv * nv)
    for (int j = 0; j < nv; j++) {
      const nsdae_rigid_body *body = nsdae_body_at(b, i);
      M[j * (nv + 1)] = j < d ? body->mass : body->inertia[d == 2 ? 2 : j - 3];
    }
  return b->own.mass ? b->own.mass(t, q, M, b->own.dims.nv, b->own.user) : 0;
}

/* Pairs on their way into the list. */
typedef struct listing {
  const nsdae_bodies *bodies;
  const nsdae_broad *broad;
  nsdae_contact_list *list;
  double reach;
  long id; /* of the pair's first feature */
  const nsdae_bodies_pair *pair;
} listing;

static nsdae_couple couple_of(const listing *l, int i, int j)
{
  const nsdae_solid_of *s = l->bodies->solid.at;
  return (nsdae_couple){
      {s + i, s + j},
      {nsdae_broad_pose(l->broad, s[i].body), nsdae_broad_pose(l->broad, s[j].body)}};
}

/* What a unit impulse along n and along t, n turned to the left, does to a body: +-d, and arm x +-d
 * about its centre. Directions push body 1 and hold body 0. */
static void set_planar(const nsdae_still *still, const nsdae_couple *two, nsdae_contact *c)
{
  for (int i = 0; i < 2; i++) {
    double sign = i ? 1 : -1, x = sign * still->normal[0], y = sign * still->normal[1];
    const double *at = still->at[i], *r = two->pose[i]->r, arm[2] = {at[0] - r[0], at[1] - r[1]};
    double *n = c->direction[i][0], *t = c->direction[i][1];
    if (c->block[i] == NSDAE_GROUND) continue;
    n[0] = x, n[1] = y, n[2] = arm[0] * y - arm[1] * x;
    t[0] = -y, t[1] = x, t[2] = arm[0] * x + arm[1] * y;
  }
}

/* The same in space, the moment in the body's own axes. */
static void set_spatial(const nsdae_still *still, const nsdae_couple *two, nsdae_contact *c)
{
  double d[3][3], arm[3], moment[3];
  /* d_0 = n, d_1 along e x n (see nsdae_tangent_axis), d_2 = n x d_1. */
  double e[3] = {0, 0, 0};
  e[nsdae_tangent_axis(still->normal[2])] = 1;
  for (int i = 0; i < 3; i++) d[0][i] = still->normal[i];
  nsdae_cross3(e, still->normal, d[1]);
  double length = sqrt(nsdae_dot3(d[1], d[1]));
  for (int i = 0; i < 3; i++) d[1][i] /= length;
  nsdae_cross3(still->normal, d[1], d[2]);
  for (int i = 0; i < 2; i++) {
    double sign = i ? 1 : -1;
    if (c->block[i] == NSDAE_GROUND) continue;
    for (int j = 0; j < 3; j++) arm[j] = sign * (still->at[i][j] - two->pose[i]->r[j]);
    for (int k = 0; k < 3; k++) {
      for (int j = 0; j < 3; j++) c->direction[i][k][j] = sign * d[k][j];
      nsdae_cross3(arm, d[k], moment);
      nsdae_turn_back(two->pose[i]->R, moment, c->direction[i][k] + 3);
    }
  }
}

static int add_contact(const listing *l, int number, const nsdae_couple *two,
                       const nsdae_still *still)
{
  nsdae_contact c = {.id = l->id + number,
                     .block = {two->solid[0]->body, two->solid[1]->body},
                     .gap = still->gap,
                     .mu = l->pair->mu,
                     .e_n = l->pair->e_n,
                     .e_t = l->pair->e_t};
  if (l->bodies->dimension == 2)
    set_planar(still, two, &c);
  else
    set_spatial(still, two, &c);
  return nsdae_contact_add(l->list, &c);
}

static int list_feature(void *to, const nsdae_feature *f)
{
  const listing *l = to;
  const nsdae_couple two = couple_of(l, f->solid[0], f->solid[1]);
  nsdae_still still;
  if (!f->edges && two.solid[0]->points <= 1) {
    still = nsdae_round_still(&two, f->part[1]);
  } else {
    nsdae_touch touch = nsdae_feature_touch(f, &two);
    still = nsdae_still_of(&touch);
  }
  return still.far || still.gap > l->reach ? 0 : add_contact(l, f->number, &two, &still);
}

/* Corners of the second solid against edges of the first, numbered from first on. */
static int list_corners(const listing *l, int first, const nsdae_couple *two,
                        const nsdae_meeting *met)
{
  double most = l->reach + two->solid[0]->radius + two->solid[1]->radius;
  int status = 0;
  for (int i = 0; i < two->solid[1]->points && status >= 0; i++) {
    if (nsdae_height_above(met->by[0].above, two->solid[1]->point + 3 * i) > most) continue;
    nsdae_still still = nsdae_polygon_still(two, i, met);
    if (!still.far && still.gap <= l->reach) status = add_contact(l, first + i, two, &still);
  }
  return status;
}

/* Corners of the second solid against a plane; most of a body's are too high. */
static int list_plane(const listing *l, const nsdae_couple *two)
{
  const nsdae_solid_of *plane = two->solid[0], *solid = two->solid[1];
  const nsdae_pose *from = two->pose[0], *to = two->pose[1];
  double n[3], x[3], above[3], height = 0;
  int status = 0;
  nsdae_turn(from->R, plane->R + 6, n);
  nsdae_turn(from->R, plane->origin, x);
  nsdae_turn_back(to->R, n, above);
  for (int i = 0; i < 3; i++) height += n[i] * (to->r[i] - from->r[i] - x[i]);
  for (int i = 0; i < solid->points && status >= 0; i++) {
    const double *p = solid->point + 3 * i, h = height + nsdae_dot3(above, p);
    if (h - solid->radius > l->reach) continue;
    nsdae_still still = {.normal = {n[0], n[1], n[2]}};
    nsdae_turn(to->R, p, x);
    for (int j = 0; j < 3; j++) x[j] += to->r[j];
    nsdae_still_place(&still, x, h, 0, solid->radius);
    status = add_contact(l, i, two, &still);
  }
  return status;
}

static int list_pair(void *to, nsdae_broad *broad, int i, int j)
{
  listing *l = to;
  const nsdae_couple two = couple_of(l, i, j);
  l->pair = broad->pair[two.solid[0]->material][two.solid[1]->material];
  l->id = ((long)i * broad->solids + j) * broad->features;
  const nsdae_couple other = {{two.solid[1], two.solid[0]}, {two.pose[1], two.pose[0]}};
  if (nsdae_has_edges(two.solid[0]) && nsdae_has_edges(two.solid[1])) {
    /* Of the plane, with features in the order of nsdae_pair_features. Nothing where they are apart
     * by more than the reach along a normal of either. */
    double enough = l->reach + two.solid[0]->radius + two.solid[1]->radius;
    const nsdae_meeting met = nsdae_find_meeting(&two, enough);
    if (met.by[0].value > enough || met.by[1].value > enough) return 0;
    const nsdae_meeting turned = {{met.by[1], met.by[0]}};
    int status = list_corners(l, 0, &two, &met);
    return status < 0 ? status : list_corners(l, two.solid[1]->points, &other, &turned);
  }
  if (two.solid[0]->shape == NSDAE_SHAPE_PLANE) return list_plane(l, &two);
  if (two.solid[1]->shape == NSDAE_SHAPE_PLANE) return list_plane(l, &other);
  return nsdae_pair_features(l->bodies->solid.at, i, j, two.pose, list_feature, l);
}

static int contacts(double t, const double *q, const double *v, double reach,
                    nsdae_contact_list *list, void *user)
{
  nsdae_bodies *b = user;
  nsdae_broad *broad = nsdae_broad_take(b);
  if (!broad) return -1;
  listing l = {.bodies = b, .broad = broad, .list = list, .reach = reach};
  int status = nsdae_broad_pairs(broad, b, q, reach, list_pair, &l);
  nsdae_broad_give_back(b, broad);
  if (status < 0) return -1;
  return b->own.contacts ? b->own.contacts(t, q, v, reach, list, b->own.user) : 0;
}

int nsdae_bodies_set_blocks(const nsdae_bodies *b, nsdae_system *system)
{
  int own = b->own.dims.nq > 0, count = b->body.count + own;
  int *sizes = calloc(2 * (size_t)count, sizeof *sizes);
  if (!sizes) return NSDAE_E_MEMORY;
  for (int i = 0; i < count; i++) {
    sizes[i] = i < b->body.count ? nsdae_body_nq(b) : b->own.dims.nq;
    sizes[count + i] = i < b->body.count ? nsdae_body_nv(b) : b->own.dims.nv;
  }
  int status = nsdae_system_set_blocks(system, count, sizes, sizes + count);
  free(sizes);
  if (status == NSDAE_OK) status = nsdae_system_set_mass_blocks(system, mass_blocks);
  return status < 0 ? status : nsdae_bodies_set_force_derivatives(b, system);
}

int nsdae_bodies_set_contact_list(nsdae_bodies *b, nsdae_system *system)
{
  int status = nsdae_system_set_contacts(system, contacts);
  nsdae_broad *broad = status == NSDAE_OK ? nsdae_broad_take(b) : NULL;
  if (status == NSDAE_OK && !broad) status = NSDAE_E_MEMORY;
  if (broad) nsdae_broad_give_back(b, broad); /* the first simulation allocates none */
  return status;
}
