/* The blocks of a mechanism: a body is one, coordinates of one's own are the last; and contacts by
 * list, found by the broad phase. */
#include <limits.h>
#include <stdlib.h>

#include "errors.h"
#include "maker.h"
#include "seams.h"
#include "separating_axis.h"

static int mass_blocks(double t, const double *q, double *M, void *user)
{
  const nsdae_bodies *b = nsdae_bodies_of(user);
  int nv = nsdae_body_nv(b), d = b->dimension;
  for (int i = 0; i < b->body.count; i++, M += nv * nv) {
    const nsdae_rigid_body *body = nsdae_body_at(b, i);
    for (int j = 0; j < nv; j++)
      M[j * (nv + 1)] = j < d ? body->mass : body->inertia[d == 2 ? 2 : j - 3];
    for (int j = 0; j < 3 && d == 3; j++) { /* entries (0, 1), (0, 2), (1, 2) of the tensor */
      int row = 3 + (j == 2), column = 4 + (j > 0);
      M[row + nv * column] = M[column + nv * row] = body->product[j];
    }
  }
  return b->own.mass ? b->own.mass(t, q, M, b->own.dims.nv, b->own.user) : 0;
}

/* Pairs on their way into the list. */
typedef struct listing {
  const nsdae_broad *broad;
  nsdae_contact_list *list;
  double reach;
  int omega; /* is asked for */
  long id;   /* of the pair's first feature */
  nsdae_bodies_pair law;
} listing;

static int list_closest(void *to, long number, const nsdae_closest *closest, const nsdae_still *at,
                        const nsdae_couple *two)
{
  const listing *l = to;
  int dimension = l->broad->b->dimension;
  nsdae_contact c = {.id = l->id + number,
                     .gap = at->gap,
                     .mu = l->law.mu,
                     .e_n = l->law.e_n,
                     .e_t = l->law.e_t,
                     .omega_given = l->omega && nsdae_pair_is_exact(two->solid[0], two->solid[1])};
  nsdae_bodies_contact_rows(dimension, two, at, dimension, &c);
  if (c.omega_given) {
    const nsdae_touch touch = nsdae_closest_touch(closest, two);
    nsdae_bodies_contact_omega(dimension, two, &touch, c.omega);
  }
  return nsdae_contact_add(l->list, &c);
}

static int list_pair(void *to, const nsdae_broad *p, int i, int j)
{
  listing *l = to;
  const nsdae_solid_of *s = p->b->solid.at;
  if (p->excludes > 0 && nsdae_broad_is_excluded(p, i, j)) return 0;
  l->law = *p->pair[s[i].filter.material][s[j].filter.material];
  l->id = p->b->feature.count + nsdae_broad_pair(p->b, i, j) * p->features;
  return nsdae_seen_contacts(p, i, j, l->reach, l->omega, list_closest, l);
}

/* The contacts of nsdae_bodies_add_contact, as features i and behind. */
static int list_named(listing *l)
{
  const nsdae_feature *f = l->broad->b->feature.at;
  int status = 0;
  for (int i = 0; i < l->broad->b->feature.count && status >= 0; i++) {
    const int *solid = f[i].solid;
    if (f[i].number > 0 || !nsdae_broad_near(l->broad, solid[0], solid[1], l->reach)) continue;
    l->law = (nsdae_bodies_pair){.mu = f[i].mu, .e_n = f[i].e_n, .e_t = f[i].e_t};
    l->id = i;
    status = nsdae_named_contacts(l->broad, solid[0], solid[1], l->reach, list_closest, l);
  }
  return status;
}

long nsdae_bodies_limit_id(const nsdae_bodies *b)
{
  return b->feature.count + (long)b->solid.count * b->solid.count * nsdae_broad_features(b);
}

int nsdae_bodies_check_ids(nsdae_bodies *b)
{
  double solids = b->solid.count, features = (double)nsdae_broad_features(b);
  double ids = b->feature.count + solids * solids * features + b->limit.count;
  if (ids < (double)LONG_MAX) return NSDAE_OK;
  return nsdae_error_set(&b->error, NSDAE_E_ARGUMENT, "nsdae_bodies_system", "solid",
                         "%d solids of which two have up to %.0f contacts need %.3g ids, more than "
                         "%ld: give fewer solids, or polyhedra with fewer corners",
                         b->solid.count, features, ids, LONG_MAX);
}

/* The limits whose gap is at most reach; their tangents are zero. */
static int list_limits(const listing *l)
{
  const nsdae_bodies *b = l->broad->b;
  long first = nsdae_bodies_limit_id(b);
  int status = 0;
  for (int i = 0; i < b->limit.count && status >= 0; i++) {
    const nsdae_bodies_limit *limit = nsdae_limit_at(b, i);
    const int *body = limit->value.body;
    const nsdae_pose pose[2] = {*nsdae_broad_pose(l->broad, body[0]),
                                *nsdae_broad_pose(l->broad, body[1])};
    nsdae_primitive_value value;
    nsdae_bodies_limit_value(limit, pose, &value);
    if (value.phi.x > l->reach) continue;
    nsdae_contact c = {.id = first + i,
                       .block = {body[0], body[1]},
                       .gap = value.phi.x,
                       .e_n = limit->e_n,
                       .omega = {value.phi.dd},
                       .omega_given = l->omega};
    for (int j = 0; j < 2; j++)
      if (body[j] != NSDAE_GROUND) nsdae_bodies_part(b, &value.row, j, &pose[j], c.direction[j][0]);
    status = nsdae_contact_add(l->list, &c);
  }
  return status;
}

/* Each pass with a listing of its own. */
static int list_pass(void *to, nsdae_contact_list *list, int pass)
{
  const listing *from = to;
  listing l = {.broad = from->broad, .list = list, .reach = from->reach, .omega = from->omega};
  return nsdae_broad_pairs(l.broad, pass, l.reach, list_pair, &l);
}

static int contacts(double t, const double *q, const double *v, double reach,
                    nsdae_contact_list *list, void *user)
{
  nsdae_bodies *b = nsdae_bodies_of(user);
  nsdae_broad *broad = nsdae_broad_take(b);
  if (!broad) return -1;
  listing l = {
      .broad = broad, .list = list, .reach = reach, .omega = nsdae_contact_list_reads_omega(list)};
  nsdae_broad_place(broad, q, l.omega ? v : NULL);
  int passes = nsdae_broad_sort(broad, reach), status = list_named(&l);
  if (status >= 0) status = nsdae_contact_list_share(list, passes, list_pass, &l);
  if (status >= 0) status = list_limits(&l);
  nsdae_broad_give_back(b, broad);
  if (status < 0) return -1;
  return b->own.contacts ? b->own.contacts(t, q, v, reach, list, b->own.user) : 0;
}

/* ---- bound of the rates of gaps
 *
 *   g' = n . (x_1' - x_0'),  |g'| <= sum_i |v_i| + |w_i| |x - r_i|
 *
 * for any point x on the line of n through the contact: a rounding counts for nothing. x is in the
 * core of a solid, or beside it by NSDAE_BESIDE of both sizes; for a plane it is in the other. */

/* Largest |x - r| of a solid's body. */
static double largest_arm(const nsdae_bodies *b, const nsdae_solid_of *s, const double *q)
{
  if (s->shape != NSDAE_SHAPE_PLANE) {
    double core = s->hollow ? 0 : s->size - s->radius;
    return sqrt(nsdae_dot3(s->origin, s->origin)) + core;
  }
  const nsdae_pose plane = nsdae_bodies_pose(b, s->body, q, NULL);
  double most = 0;
  for (int i = 0; i < b->solid.count; i++) {
    const nsdae_solid_of *other = nsdae_solid_at(b, i);
    double x[3];
    if (other->body == s->body || other->shape == NSDAE_SHAPE_PLANE) continue;
    nsdae_bodies_locate(b, q, other->body, other->origin, x);
    for (int j = 0; j < 3; j++) x[j] -= plane.r[j];
    most = fmax(most, sqrt(nsdae_dot3(x, x)) + other->size);
  }
  return most;
}

/* The sum over the two fastest bodies, and the rates of limits. */
static int contact_speed(double t, const double *q, const double *v, double *speed, void *user)
{
  const nsdae_bodies *b = nsdae_bodies_of(user);
  int nv = nsdae_body_nv(b), d = b->dimension, fastest = NSDAE_GROUND;
  double size = 0, first = 0, second = 0;
  (void)t;
  for (int i = 0; i < b->solid.count; i++)
    if (!nsdae_solid_at(b, i)->hollow && !nsdae_solid_at(b, i)->mesh)
      size = fmax(size, nsdae_solid_at(b, i)->size);
  for (int i = 0; i < b->solid.count; i++) {
    const nsdae_solid_of *s = nsdae_solid_at(b, i);
    if (s->body == NSDAE_GROUND) continue;
    const double *u = v + nv * s->body;
    double linear = 0, angular = 0;
    for (int j = 0; j < nv; j++) *(j < d ? &linear : &angular) += u[j] * u[j];
    double arm = angular > 0 ? largest_arm(b, s, q) + 2 * NSDAE_BESIDE * size : 0;
    double this = sqrt(linear) + sqrt(angular) * arm;
    if (s->body != fastest) second = fmax(second, fmin(first, this));
    if (this > first) first = this, fastest = s->body;
  }
  *speed = first + second;
  nsdae_places at = nsdae_nowhere;
  nsdae_primitive_value value;
  for (int i = 0; i < b->limit.count; i++) {
    nsdae_bodies_place(b, nsdae_limit_at(b, i)->value.body, q, v, &at);
    nsdae_bodies_limit_value(nsdae_limit_at(b, i), at.pose, &value);
    *speed = fmax(*speed, fabs(value.phi.d));
  }
  return 0;
}

/* ---- setters */

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
  if (status == NSDAE_OK && !b->own.contacts)
    status = nsdae_system_set_contact_speed(system, contact_speed);
  nsdae_broad *broad = status == NSDAE_OK ? nsdae_broad_take(b) : NULL;
  if (status == NSDAE_OK && !broad) status = NSDAE_E_MEMORY;
  if (broad) nsdae_broad_give_back(b, broad); /* the first simulation allocates none */
  return status;
}
