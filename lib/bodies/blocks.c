/* The mechanism by blocks: a body is one, coordinates of one's own are the last; rows over them;
 * and contacts by list, found by the broad phase. */
#include <stdlib.h>

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

static void set_direction(const listing *l, const nsdae_touch *touch, const nsdae_pose pose[2],
                          nsdae_jet3 direction, int number, nsdae_contact *c)
{
  nsdae_velocity_row row = nsdae_contact_row(touch, pose, direction);
  for (int i = 0; i < 2; i++)
    nsdae_bodies_part(l->bodies, &row, i, &pose[i], c->direction[i][number]);
}

static nsdae_contact begin(const listing *l, const nsdae_feature *f)
{
  const nsdae_solid_of *solid = l->bodies->solid.at;
  return (nsdae_contact){.id = l->id + f->number,
                         .block = {solid[f->solid[0]].body, solid[f->solid[1]].body},
                         .mu = l->pair->mu,
                         .e_n = l->pair->e_n,
                         .e_t = l->pair->e_t};
}

/* n and t = (-n_y, n_x), which push body 1 and hold body 0: d, and arm x d about its centre. */
static int list_flat(listing *l, const nsdae_feature *f, const nsdae_solid_of *const s[2],
                     const nsdae_meeting *met)
{
  if (nsdae_height_above(met->above[0], s[1]->point + 3 * f->part[1]) >
      l->reach + s[0]->radius + s[1]->radius)
    return 0;
  const nsdae_pose *pose[2] = {nsdae_broad_pose(l->broad, s[0]->body),
                               nsdae_broad_pose(l->broad, s[1]->body)};
  nsdae_flat flat = nsdae_polygon_flat(s[0], s[1], f->part[1], pose[0], pose[1], met);
  if (flat.far || flat.gap > l->reach) return 0;
  nsdae_contact c = begin(l, f);
  const double d[2][2] = {{flat.normal[0], flat.normal[1]}, {-flat.normal[1], flat.normal[0]}};
  c.gap = flat.gap;
  for (int i = 0; i < 2; i++)
    for (int k = 0; k < 2; k++) {
      double sign = i ? 1 : -1, *row = c.direction[i][k];
      row[0] = sign * d[k][0];
      row[1] = sign * d[k][1];
      row[2] = sign * ((flat.at[i][0] - pose[i]->r[0]) * d[k][1] -
                       (flat.at[i][1] - pose[i]->r[1]) * d[k][0]);
    }
  return nsdae_contact_add(l->list, &c);
}

static int list_feature(void *to, const nsdae_feature *f)
{
  listing *l = to;
  const nsdae_solid_of *solid = l->bodies->solid.at;
  const nsdae_solid_of *const s[2] = {&solid[f->solid[0]], &solid[f->solid[1]]};
  const nsdae_meeting *met = l->flat ? &l->met[f->solid[0] != l->first] : NULL;
  if (met && isfinite(met->value[0])) return list_flat(l, f, s, met);
  const nsdae_pose pose[2] = {*nsdae_broad_pose(l->broad, s[0]->body),
                              *nsdae_broad_pose(l->broad, s[1]->body)};
  nsdae_touch touch = nsdae_feature_touch(f, s[0], s[1], &pose[0], &pose[1], met);
  if (touch.far || touch.gap.x > l->reach) return 0;
  nsdae_contact c = begin(l, f);
  nsdae_jet3 tangent[2];
  nsdae_contact_tangents(l->bodies->dimension, touch.normal, tangent);
  c.gap = touch.gap.x;
  set_direction(l, &touch, pose, touch.normal, 0, &c);
  for (int i = 1; i < l->bodies->dimension; i++)
    set_direction(l, &touch, pose, tangent[i - 1], i, &c);
  return nsdae_contact_add(l->list, &c);
}

/* Whether two solids of the plane are apart by more than the reach along a normal of either. */
static int is_out_of_reach(listing *l, const nsdae_solid_of *s0, const nsdae_solid_of *s1,
                           const nsdae_pose *const pose[2])
{
  l->flat = l->bodies->dimension == 2 && s0->points > 1 && s1->points > 1;
  if (!l->flat) return 0;
  nsdae_meeting m = l->met[0] = nsdae_find_meeting(s0, s1, pose[0], pose[1]);
  l->met[1] = nsdae_meeting_turned(&m);
  return fmax(m.value[0], m.value[1]) - s0->radius - s1->radius > l->reach;
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
