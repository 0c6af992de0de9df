#include "broad_phase.h"

#include "errors.h"
#include "mesh.h"
#include "narrow_phase.h"

#include <limits.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

/* Beyond this many times the median radius a solid is large. */
static const double ordinary = 4;

static int is_endless(const nsdae_solid_of *s)
{
  return s->shape == NSDAE_SHAPE_PLANE || s->hollow;
}

static int by_value(const void *a, const void *b)
{
  const double *x = a, *y = b;
  return (*x > *y) - (*x < *y);
}

long nsdae_broad_features(const nsdae_bodies *b)
{
  double corners = 1, edges = 0, parts = 0, smooth = 0;
  for (int i = 0; i < b->solid.count; i++) {
    const nsdae_solid_of *s = nsdae_solid_at(b, i);
    corners = fmax(corners, s->points);
    edges = fmax(edges, nsdae_solid_edges(s));
    if (s->mesh) parts = fmax(parts, (double)nsdae_mesh_parts(s->mesh));
    if (nsdae_solid_is_smooth(s)) smooth = 1;
  }
  double most = fmax(2 * corners + edges * edges, (1 + corners + edges) * parts);
  /* see support.h; of an edge of a mesh with two ends: see mesh_contact.c */
  most = fmax(most, smooth * (1 + corners) * fmax(1 + corners, 4 * parts));
  return (long)fmin(most, (double)(LONG_MAX / 2)); /* which nsdae_bodies_check_ids refuses */
}

/* ---- memory */

static void lay_out_broad(void *object, nsdae_arena *arena)
{
  nsdae_broad *p = object;
  long solids = p->b->solid.count;
  p->pose = nsdae_arena_take(arena, p->b->body.count + 1L, sizeof *p->pose);
  p->radius = NSDAE_ARENA_DOUBLES(arena, solids);
  p->centre = NSDAE_ARENA_DOUBLES(arena, 3 * solids);
  p->grid.cell = NSDAE_ARENA_INTS(arena, 3 * solids);
  p->grid.next = NSDAE_ARENA_INTS(arena, solids);
  p->large = NSDAE_ARENA_INTS(arena, solids);
  p->excluded = NSDAE_ARENA_DOUBLES(arena, p->excludes);
  p->grid.head = NSDAE_ARENA_INTS(arena, p->grid.buckets);
}

/* The radii, and which of them are large. */
static void measure(nsdae_broad *p)
{
  const nsdae_solid_of *s = p->b->solid.at;
  int count = p->b->solid.count, finite = 0;
  /* those of what is finite in order in centre, which has room for them */
  for (int i = 0; i < count; i++) {
    p->radius[i] = is_endless(&s[i]) ? INFINITY : s[i].size;
    if (isfinite(p->radius[i])) p->centre[finite++] = p->radius[i];
  }
  qsort(p->centre, (size_t)finite, sizeof *p->centre, by_value);
  double most = finite > 0 ? ordinary * p->centre[finite / 2] : 0;
  for (int i = 0; i < count; i++) {
    if (p->radius[i] <= most)
      p->usual = fmax(p->usual, p->radius[i]);
    else
      p->large[p->larges++] = i;
  }
}

/* Two bodies in nsdae_broad.excluded: below 0, other than pairs of solids. */
static double joined_pair(const nsdae_bodies *b, int i, int j)
{
  return -1 - ((i < j ? i : j) + 1.0) * (b->body.count + 1.0) - (i < j ? j : i);
}

/* Whether a joint excludes the contacts of its bodies. The ground is every floor and wall: a body
 * that is joined to it touches it. */
static int excludes(const nsdae_bodies_joint *joint)
{
  return !joint->collide_connected && joint->body[0] != NSDAE_GROUND &&
         joint->body[1] != NSDAE_GROUND;
}

static void exclude_pairs(nsdae_broad *p)
{
  const nsdae_feature *f = p->b->feature.at;
  p->excludes = 0;
  for (int i = 0; i < p->b->feature.count; i++)
    if (f[i].number == 0)
      p->excluded[p->excludes++] = (double)nsdae_broad_pair(p->b, f[i].solid[0], f[i].solid[1]);
  for (int i = 0; i < p->b->joint.count; i++) {
    const nsdae_bodies_joint *joint = nsdae_joint_at(p->b, i);
    if (excludes(joint))
      p->excluded[p->excludes++] = joined_pair(p->b, joint->body[0], joint->body[1]);
  }
  qsort(p->excluded, (size_t)p->excludes, sizeof *p->excluded, by_value);
}

static nsdae_broad *make(const nsdae_bodies *b)
{
  nsdae_broad *p = calloc(1, sizeof *p);
  if (!p) return NULL;
  p->b = b;
  for (int i = 0; i < b->feature.count; i++) p->excludes += nsdae_feature_at(b, i)->number == 0;
  for (int i = 0; i < b->joint.count; i++) p->excludes += excludes(nsdae_joint_at(b, i));
  for (p->grid.buckets = 1; p->grid.buckets < 2 * b->solid.count;) p->grid.buckets *= 2;
  if (nsdae_arena_build(&p->arena, lay_out_broad, p) < 0) {
    free(p);
    return NULL;
  }
  p->pose[b->body.count] = nsdae_pose_ground();
  p->features = nsdae_broad_features(b);
  measure(p);
  exclude_pairs(p);
  for (int i = 0; i < b->pair.count; i++) {
    const nsdae_bodies_pair *pair = (const nsdae_bodies_pair *)b->pair.at + i;
    p->pair[pair->material[0]][pair->material[1]] = pair;
    p->pair[pair->material[1]][pair->material[0]] = pair;
  }
  return p;
}

void nsdae_broad_release(nsdae_broad *p)
{
  if (!p) return;
  nsdae_arena_release(&p->arena);
  free(p);
}

/* The mechanism is one for many threads: each call takes what no other one has. */
nsdae_broad *nsdae_broad_take(nsdae_bodies *b)
{
  for (int i = 0; i < NSDAE_BROADS; i++) {
    nsdae_broad *p = atomic_exchange(&b->broad[i], NULL);
    if (p) return p;
  }
  return make(b);
}

void nsdae_broad_give_back(nsdae_bodies *b, nsdae_broad *p)
{
  for (int i = 0; i < NSDAE_BROADS; i++) {
    nsdae_broad *none = NULL;
    if (atomic_compare_exchange_strong(&b->broad[i], &none, p)) return;
  }
  nsdae_broad_release(p);
}

/* ---- large solids */

static inline int may_touch(const nsdae_broad *p, const nsdae_solid_of *s, int i, int j)
{
  return s[i].body != s[j].body && p->pair[s[i].filter.material][s[j].filter.material] != NULL &&
         !((s[i].filter.group & s[j].filter.exclude) | (s[j].filter.group & s[i].filter.exclude));
}

static int are_near(const nsdae_broad *p, int i, int j, double reach)
{
  double d[3], most = p->radius[i] + p->radius[j] + reach;
  for (int l = 0; l < 3; l++) d[l] = p->centre[3 * j + l] - p->centre[3 * i + l];
  return nsdae_dot3(d, d) <= most * most;
}

/* Whether x is within of a plane's surface, or beyond it; or of the rim of a hole. */
static int is_near_base(const nsdae_broad *p, int number, const double *x, double within)
{
  const nsdae_solid_of *base = nsdae_solid_at(p->b, number);
  double d[3], n[3];
  for (int l = 0; l < 3; l++) d[l] = x[l] - p->centre[3 * number + l];
  if (base->hollow) return sqrt(nsdae_dot3(d, d)) + within >= base->radius;
  nsdae_turn(nsdae_broad_pose(p, base->body)->R, base->R + 6, n);
  return nsdae_dot3(n, d) <= within;
}

static int contains(const nsdae_broad *p, double pair)
{
  return bsearch(&pair, p->excluded, (size_t)p->excludes, sizeof *p->excluded, by_value) != NULL;
}

int nsdae_broad_is_excluded(const nsdae_broad *p, int i, int j)
{
  const nsdae_solid_of *s = p->b->solid.at;
  return contains(p, (double)nsdae_broad_pair(p->b, i, j)) ||
         contains(p, joined_pair(p->b, s[i].body, s[j].body));
}

int nsdae_broad_touches(const nsdae_broad *p, int i, int j)
{
  const nsdae_solid_of *s = p->b->solid.at;
  if (s[i].body == s[j].body) return 0;
  if (p->excludes > 0 && contains(p, (double)nsdae_broad_pair(p->b, i, j))) return 1;
  return may_touch(p, s, i, j) &&
         !(p->excludes > 0 && contains(p, joined_pair(p->b, s[i].body, s[j].body)));
}

int nsdae_broad_near(const nsdae_broad *p, int i, int j, double reach)
{
  const nsdae_solid_of *s = p->b->solid.at;
  return is_endless(&s[i])   ? is_near_base(p, i, p->centre + 3L * j, p->radius[j] + reach)
         : is_endless(&s[j]) ? is_near_base(p, j, p->centre + 3L * i, p->radius[i] + reach)
                             : are_near(p, i, j, reach);
}

typedef int (*pair_fn)(const nsdae_solid_of *solid0, const nsdae_solid_of *solid1);

/* The first pair by material for which a test of two solids is true, of smooth shapes alone. */
static int find_pair(nsdae_bodies *b, pair_fn is, int pair[2], nsdae_error *error)
{
  const nsdae_solid_of *s = b->solid.at;
  nsdae_broad *p = NULL;
  int found = 0;
  for (int i = 0; i < b->solid.count && !found; i++)
    for (int j = 0; nsdae_solid_is_smooth(&s[i]) && j < b->solid.count && !found; j++) {
      if (!is(&s[i], &s[j])) continue;
      if (!p && !(p = nsdae_broad_take(b))) return nsdae_error_memory(error, "nsdae_bodies");
      found = may_touch(p, s, i, j) && !nsdae_broad_is_excluded(p, i, j);
      pair[0] = i;
      pair[1] = j;
    }
  if (p) nsdae_broad_give_back(b, p);
  return found;
}

int nsdae_bodies_check_shapes(nsdae_bodies *b)
{
  int pair[2] = {0, 0}, found = find_pair(b, nsdae_pair_has_none, pair, &b->error);
  return found > 0 ? nsdae_bodies_refuse_pair(b, "solid", pair[0], pair[0], pair[1]) : found;
}

static int is_inexact(const nsdae_solid_of *s0, const nsdae_solid_of *s1)
{
  return !nsdae_pair_is_exact(s0, s1);
}

int nsdae_bodies_check_rates(const void *bodies, nsdae_error *error)
{
  nsdae_bodies *b = (nsdae_bodies *)(uintptr_t)bodies;
  const nsdae_solid_of *s = b->solid.at;
  int pair[2] = {0, 0}, found = 0;
  for (int i = 0; i < b->feature.count && !found; i++) {
    memcpy(pair, nsdae_feature_at(b, i)->solid, sizeof pair);
    found = is_inexact(&s[pair[0]], &s[pair[1]]);
  }
  if (!found && nsdae_bodies_has_list(b)) found = find_pair(b, is_inexact, pair, error);
  if (found <= 0) return found;
  return nsdae_error_set(error, NSDAE_E_ARGUMENT, "nsdae_sim_create", "method",
                         "solids %d and %d: %s and %s have contacts for time stepping alone: "
                         "choose moreau, implicit "
                         "or implicit-printed, or make the curved one a polyhedron with many sides",
                         pair[0], pair[1], nsdae_solid_name(s[pair[0]].shape),
                         nsdae_solid_name(s[pair[1]].shape));
}

/* A large solid with every other one; of two large ones that which comes first. */
static int visit_large(const nsdae_broad *p, int i, double reach, nsdae_broad_fn visit, void *to)
{
  const nsdae_solid_of *s = p->b->solid.at;
  int status = 0;
  for (int j = 0; j < p->b->solid.count && status >= 0; j++) {
    int both = p->radius[j] > p->usual, endless = is_endless(&s[i]) && is_endless(&s[j]);
    if (!may_touch(p, s, i, j) || (both && j < i) || endless) continue;
    if (nsdae_broad_near(p, i, j, reach)) status = visit(to, p, i < j ? i : j, i < j ? j : i);
  }
  return status;
}

/* ---- a hashed grid of the others */

static inline int bucket_of(const nsdae_broad *p, const int *cell)
{
  uint32_t hash =
      (uint32_t)cell[0] * 73856093u ^ (uint32_t)cell[1] * 19349663u ^ (uint32_t)cell[2] * 83492791u;
  return (int)(hash & (uint32_t)(p->grid.buckets - 1));
}

/* Solid i with those from j on in the bucket of a cell. */
static int visit_cell(const nsdae_broad *p, int i, int j, const int *cell, double reach,
                      nsdae_broad_fn visit, void *to)
{
  const nsdae_solid_of *s = p->b->solid.at;
  int status = 0;
  for (; j >= 0 && status >= 0; j = p->grid.next[j]) {
    const int *other = p->grid.cell + 3 * j;
    if (other[0] != cell[0] || other[1] != cell[1] || other[2] != cell[2]) continue;
    if (are_near(p, i, j, reach) && may_touch(p, s, i, j))
      status = visit(to, p, i < j ? i : j, i < j ? j : i);
  }
  return status;
}

/* With those put before it into its own cell, and with all of the neighbours on one side: the other
 * side's look at it. */
static int visit_usual(const nsdae_broad *p, int i, double reach, nsdae_broad_fn visit, void *to)
{
  const int *cell = p->grid.cell + 3 * i, all = p->b->dimension == 2 ? 9 : 27;
  int status = visit_cell(p, i, p->grid.next[i], cell, reach, visit, to);
  for (int n = all / 2 + 1; n < all && status >= 0; n++) {
    const int beside[3] = {cell[0] + n % 3 - 1, cell[1] + n / 3 % 3 - 1,
                           all == 9 ? cell[2] : cell[2] + n / 9 - 1};
    status = visit_cell(p, i, p->grid.head[bucket_of(p, beside)], beside, reach, visit, to);
  }
  return status;
}

/* The cell of a coordinate. */
static int cell_of(const nsdae_broad *p, double x)
{
  double at = floor(x / p->grid.width);
  return (int)(at > -1e9 ? (at < 1e9 ? at : 1e9) : -1e9); /* NaN too */
}

int nsdae_broad_about(const nsdae_broad *p, const double *x, double within, nsdae_about_fn visit,
                      void *to)
{
  int low[3], high[3], at[3], code = 0;
  double cells = 1;
  for (int k = 0; k < p->larges && !code; k++) {
    int i = p->large[k], endless = is_endless(nsdae_solid_at(p->b, i));
    if (endless ? is_near_base(p, i, x, within) : nsdae_broad_is_about(p, i, x, within))
      code = visit(to, i);
  }
  for (int l = 0; l < 3; l++) {
    low[l] = cell_of(p, x[l] - p->usual - within);
    high[l] = cell_of(p, x[l] + p->usual + within);
    cells *= (double)high[l] - low[l] + 1;
  }
  if (!(cells <= p->b->solid.count)) { /* a ball about large solids: all are fewer than its cells */
    for (int i = 0; i < p->b->solid.count && !code; i++)
      if (p->radius[i] <= p->usual && nsdae_broad_is_about(p, i, x, within)) code = visit(to, i);
    return code;
  }
  for (at[2] = low[2]; at[2] <= high[2] && !code; at[2]++)
    for (at[1] = low[1]; at[1] <= high[1] && !code; at[1]++)
      for (at[0] = low[0]; at[0] <= high[0] && !code; at[0]++)
        for (int i = p->grid.head[bucket_of(p, at)]; i >= 0 && !code; i = p->grid.next[i])
          if (nsdae_broad_is_about(p, i, x, within) && p->grid.cell[3 * i] == at[0] &&
              p->grid.cell[3 * i + 1] == at[1] && p->grid.cell[3 * i + 2] == at[2])
            code = visit(to, i);
  return code;
}

/* ---- all pairs */

void nsdae_broad_place(nsdae_broad *p, const double *q, const double *v)
{
  const nsdae_bodies *b = p->b;
  int nq = nsdae_body_nq(b), nv = nsdae_body_nv(b);
  for (int i = 0; i < b->body.count; i++) {
    nsdae_pose_place(b->dimension, q + i * nq, &p->pose[i]);
    if (v) nsdae_pose_move(b->dimension, v + i * nv, &p->pose[i]);
  }
  for (int i = 0; i < b->solid.count; i++) {
    const nsdae_solid_of *s = nsdae_solid_at(b, i);
    const nsdae_pose *pose = nsdae_broad_pose(p, s->body);
    nsdae_turn(pose->R, s->origin, p->centre + 3 * i);
    for (int j = 0; j < 3; j++) p->centre[3 * i + j] += pose->r[j];
  }
}

/* Cells are as wide as two of the largest radius and reach, so that only neighbours can touch. */
int nsdae_broad_sort(nsdae_broad *p, double reach)
{
  int solids = p->b->solid.count;
  p->grid.width = 2 * p->usual + reach;
  if (!(p->grid.width > 0)) p->grid.width = 1; /* points alone */
  for (int i = 0; i < p->grid.buckets; i++) p->grid.head[i] = -1;
  for (int i = 0; i < solids; i++) {
    int *cell = p->grid.cell + 3 * i;
    if (p->radius[i] > p->usual) continue;
    for (int l = 0; l < 3; l++) cell[l] = cell_of(p, p->centre[3 * i + l]);
    int *head = &p->grid.head[bucket_of(p, cell)];
    p->grid.next[i] = *head;
    *head = i;
  }
  return p->larges + solids;
}

/* The large ones first, then the others. */
int nsdae_broad_pairs(const nsdae_broad *p, int pass, double reach, nsdae_broad_fn visit, void *to)
{
  int i = pass - p->larges;
  if (i < 0) return visit_large(p, p->large[pass], reach, visit, to);
  return p->radius[i] <= p->usual ? visit_usual(p, i, reach, visit, to) : 0;
}
