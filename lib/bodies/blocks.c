/* The mechanism by blocks: a body is one, coordinates of one's own are the last; rows over them;
 * and contacts by list, found by the broad phase. */
#include <stdlib.h>
#include <string.h>

#include "broad.h"
#include "errors.h"
#include "touch.h"

static int mass_blocks(double t, const double *q, double *M, void *user)
{
  const nsdae_bodies *b = user;
  int nv = nsdae_body_nv(b);
  for (int i = 0; i < b->body.count; i++, M += nv * nv) {
    const nsdae_rigid_body *body = nsdae_body_at(b, i);
    for (int j = 0; j < b->dimension; j++) M[j * (nv + 1)] = body->mass;
    for (int j = b->dimension; j < nv; j++)
      M[j * (nv + 1)] = body->inertia[b->dimension == 2 ? 2 : j - 3];
  }
  return b->own.mass ? b->own.mass(t, q, M, b->own.dims.nv, b->own.user) : 0;
}

static int constraint_rows(double t, const double *q, nsdae_row_list *rows, void *user)
{
  const nsdae_bodies *b = user;
  for (int i = 0; i < b->element.count; i++) {
    const nsdae_element *e = (const nsdae_element *)b->element.at + i;
    nsdae_element_value value;
    nsdae_pose pose[2];
    int code = nsdae_bodies_element(b, e, t, q, NULL, pose, &value);
    for (int j = 0; j < 2 && code == 0; j++) {
      double part[6];
      if (e->body[j] == NSDAE_GROUND) continue;
      nsdae_bodies_part(b, &value.row, j, &pose[j], part);
      code = nsdae_row_add(rows, i, e->body[j], part);
    }
    if (code) return code;
  }
  return b->own.constraint_rows ? b->own.constraint_rows(t, q, rows, b->own.user) : 0;
}

/* A pair on its way into the list. */
typedef struct listing {
  const nsdae_bodies *bodies;
  const nsdae_broad *broad;
  nsdae_contact_list *list;
  double reach;
  long id; /* of the pair's first feature */
  const nsdae_bodies_pair *pair;
  int first;            /* the pair's first solid */
  int flat;             /* whether both are of the plane and have corners: met is filled */
  nsdae_meeting met[2]; /* as seen from the first solid, and from the other */
} listing;

/* d[0] = n, and the tangents of contacts.c: n turned to the left; in space e x n of the coordinate
 * axis e that n is least along, and n x that. */
static void set_frame(int dimension, const double *n, double d[3][3])
{
  double e[3] = {0, 0, 0};
  int least = 2;
  memcpy(d[0], n, sizeof d[0]);
  if (dimension == 2) {
    d[1][0] = -n[1], d[1][1] = n[0];
    return;
  }
  for (int i = 0; i < 3; i++)
    if (fabs(n[i]) < fabs(n[least])) least = i;
  e[least] = 1;
  nsdae_cross3(e, n, d[1]);
  double length = sqrt(nsdae_dot3(d[1], d[1]));
  for (int i = 0; i < 3; i++) d[1][i] /= length;
  nsdae_cross3(n, d[1], d[2]);
}

/* What a unit impulse along sign d at the place c does to a body: sign d, and arm x sign d about
 * its centre, in space in the body's own axes. */
static void set_part(int dimension, const nsdae_pose *pose, const double *place, const double *d,
                     double sign, double part[6])
{
  double arm[3], turning[3];
  for (int i = 0; i < 3; i++) arm[i] = sign * (place[i] - pose->r[i]);
  for (int i = 0; i < dimension; i++) part[i] = sign * d[i];
  if (dimension == 2) {
    part[2] = arm[0] * d[1] - arm[1] * d[0];
    return;
  }
  nsdae_cross3(arm, d, turning);
  nsdae_turn_back(pose->R, turning, part + 3);
}

/* Directions push body 1 and hold body 0. */
static int add_contact(const listing *l, const nsdae_feature *f, const nsdae_pose *const pose[2],
                       const nsdae_still *still)
{
  const nsdae_solid_of *solid = l->bodies->solid.at;
  int dimension = l->bodies->dimension;
  double d[3][3];
  nsdae_contact c = {.id = l->id + f->number,
                     .block = {solid[f->solid[0]].body, solid[f->solid[1]].body},
                     .gap = still->gap,
                     .mu = l->pair->mu,
                     .e_n = l->pair->e_n,
                     .e_t = l->pair->e_t};
  set_frame(dimension, still->normal, d);
  for (int i = 0; i < 2; i++)
    for (int k = 0; k < dimension && c.block[i] != NSDAE_GROUND; k++)
      set_part(dimension, pose[i], still->at[i], d[k], i ? 1 : -1, c.direction[i][k]);
  return nsdae_contact_add(l->list, &c);
}

/* A feature of two solids with these poses. met: NULL, or of planar ones. */
static nsdae_still find_still(const listing *l, const nsdae_feature *f,
                              const nsdae_solid_of *const s[2], const nsdae_pose *const pose[2],
                              const nsdae_meeting *met)
{
  if (met && isfinite(met->value[0])) {
    double height = nsdae_height_above(met->above[0], s[1]->point + 3 * f->part[1]);
    if (height > l->reach + s[0]->radius + s[1]->radius) return (nsdae_still){.far = 1};
    return nsdae_polygon_still(s[0], s[1], f->part[1], pose[0], pose[1], met);
  }
  if (!f->edges && s[0]->points <= 1)
    return nsdae_round_still(s[0], s[1], f->part[1], pose[0], pose[1]);
  nsdae_touch touch = nsdae_feature_touch(f, s[0], s[1], pose[0], pose[1], met);
  return nsdae_still_of(&touch);
}

static int list_feature(void *to, const nsdae_feature *f)
{
  const listing *l = to;
  const nsdae_solid_of *solid = l->bodies->solid.at;
  const nsdae_solid_of *const s[2] = {&solid[f->solid[0]], &solid[f->solid[1]]};
  const nsdae_pose *const pose[2] = {nsdae_broad_pose(l->broad, s[0]->body),
                                     nsdae_broad_pose(l->broad, s[1]->body)};
  const nsdae_meeting *met = l->flat ? &l->met[f->solid[0] != l->first] : NULL;
  nsdae_still still = find_still(l, f, s, pose, met);
  return still.far || still.gap > l->reach ? 0 : add_contact(l, f, pose, &still);
}

/* Whether two solids of the plane are apart by more than the reach along a normal of either. */
static int is_out_of_reach(listing *l, const nsdae_solid_of *s0, const nsdae_solid_of *s1,
                           const nsdae_pose *const pose[2])
{
  l->flat = l->bodies->dimension == 2 && s0->points > 1 && s1->points > 1;
  if (!l->flat) return 0;
  double enough = l->reach + s0->radius + s1->radius;
  l->met[0] = nsdae_find_meeting(s0, s1, pose[0], pose[1], enough);
  if (l->met[0].value[0] > enough || l->met[0].value[1] > enough) return 1;
  l->met[1] = nsdae_meeting_turned(&l->met[0]);
  return 0;
}

static int list_pair(void *to, nsdae_broad *broad, int i, int j)
{
  listing *l = to;
  const nsdae_solid_of *solid = l->bodies->solid.at;
  l->pair = broad->pair[solid[i].material][solid[j].material];
  l->id = ((long)i * broad->solids + j) * broad->features;
  const nsdae_pose *const pose[2] = {nsdae_broad_pose(broad, solid[i].body),
                                     nsdae_broad_pose(broad, solid[j].body)};
  l->first = i;
  if (is_out_of_reach(l, &solid[i], &solid[j], pose)) return 0;
  return nsdae_pair_features(solid, i, j, pose, list_feature, l);
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

static int set_partition(const nsdae_bodies *b, nsdae_system *system)
{
  int own = b->own.dims.nq > 0, count = b->body.count + own;
  int *sizes = calloc(2 * (size_t)count, sizeof *sizes);
  if (!sizes) return NSDAE_E_MEMORY;
  for (int i = 0; i < b->body.count; i++) {
    sizes[i] = nsdae_body_nq(b);
    sizes[count + i] = nsdae_body_nv(b);
  }
  if (own) {
    sizes[count - 1] = b->own.dims.nq;
    sizes[2 * count - 1] = b->own.dims.nv;
  }
  int status = nsdae_system_set_blocks(system, count, sizes, sizes + count);
  free(sizes);
  return status;
}

int nsdae_bodies_set_blocks(nsdae_bodies *b, nsdae_system *system)
{
  int status = set_partition(b, system);
  if (status == NSDAE_OK) status = nsdae_system_set_mass_blocks(system, mass_blocks);
  if (status == NSDAE_OK && b->element.count + b->own.dims.m > 0)
    status = nsdae_system_set_constraint_rows(system, constraint_rows);
  if (status == NSDAE_OK) status = nsdae_system_set_contacts(system, contacts);
  nsdae_broad *broad = status == NSDAE_OK ? nsdae_broad_take(b) : NULL;
  if (status == NSDAE_OK && !broad) status = NSDAE_E_MEMORY;
  if (broad) nsdae_broad_give_back(b, broad); /* the first simulation allocates none */
  return status;
}
