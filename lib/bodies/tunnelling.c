/* Tunnelling: a time-stepping method finds a contact a step late, when bodies may have passed
 * through each other. Of two solids of widths w_i (sizes.c) the nearest surface is the opposite
 * one as soon as they overlap by (w_0 + w_1) / 2. A contact of gap g and rate u that closes in the
 * step, 0 < g < -h u, is therefore reported if
 *
 *   -h u > share (w_0 + w_1),
 *
 * with 1/share twice the steps that the overlap may last. A plane has no opposite surface; lines
 * and meshes have no width. Two solids without width are left out. */
#include "maker.h"
#include "seams.h"

typedef struct search {
  const nsdae_bodies *b;
  const double *v;
  double h, share;
  double least; /* share (w_0 + w_1) of the pair */
  long id;      /* of the pair's first contact */
  nsdae_tunnelling *worst;
} search;

/* How far a point of the solid moves at most. */
static double way_of(const nsdae_bodies *b, const nsdae_solid_of *s, const double *v, double h)
{
  double linear = 0, angular = 0;
  if (s->body == NSDAE_GROUND) return 0;
  v += nsdae_body_nv(b) * s->body;
  for (int j = 0; j < nsdae_body_nv(b); j++)
    *(j < b->dimension ? &linear : &angular) += v[j] * v[j];
  return h * (sqrt(linear) + sqrt(angular) * (sqrt(nsdae_dot3(s->origin, s->origin)) + s->size));
}

/* g' = n . (c_1' - c_0') */
static double rate_of(const nsdae_still *at, const nsdae_couple *two)
{
  double rate = 0;
  for (int i = 0; i < 2; i++) {
    const nsdae_pose *pose = two->pose[i];
    double arm[3], u[3];
    for (int j = 0; j < 3; j++) arm[j] = at->at[i][j] - pose->r[j];
    nsdae_cross3(pose->w, arm, u);
    for (int j = 0; j < 3; j++) rate += (i ? 1 : -1) * at->normal[j] * (pose->v[j] + u[j]);
  }
  return rate;
}

static int compare(void *to, long number, const nsdae_closest *closest, const nsdae_still *at,
                   const nsdae_couple *two)
{
  const search *s = to;
  double way = -s->h * rate_of(at, two);
  (void)closest;
  if (at->gap > 0 && at->gap < way && way > s->least && way > s->worst->way)
    *s->worst = (nsdae_tunnelling){s->id + number, way, s->least};
  return 0;
}

static int compare_named(void *to, long number, const nsdae_closest *closest,
                         const nsdae_couple *two)
{
  const nsdae_still at = nsdae_closest_still(closest, two);
  return compare(to, number, closest, &at, two);
}

/* How far the gap of two solids closes in the step at most; 0: not enough. */
static double closes(search *s, int i, int j)
{
  const nsdae_solid_of *solids = s->b->solid.at;
  double way = way_of(s->b, &solids[i], s->v, s->h) + way_of(s->b, &solids[j], s->v, s->h);
  s->least = s->share * (solids[i].width + solids[j].width);
  return s->least > 0 && way > s->least ? way : 0;
}

static int look_at(search *s, int i, int j, const nsdae_pose *pose_i, const nsdae_pose *pose_j)
{
  const nsdae_solid_of *solids = s->b->solid.at;
  double way = closes(s, i, j);
  if (!(way > 0)) return 0;
  int turned = nsdae_pair_is_turned(&solids[i], &solids[j]);
  const nsdae_couple two = {{&solids[turned ? j : i], &solids[turned ? i : j]},
                            {turned ? pose_j : pose_i, turned ? pose_i : pose_j}};
  return nsdae_pair_contacts(solids, i, j, &two, way, compare_named, s);
}

static int look_at_pair(void *to, const nsdae_broad *p, int i, int j)
{
  search *s = to;
  if (p->excludes > 0 && nsdae_broad_is_excluded(p, i, j)) return 0;
  s->id = p->b->feature.count + nsdae_broad_pair(p->b, i, j) * p->features;
  double way = closes(s, i, j);
  return way > 0 ? nsdae_seen_contacts(p, i, j, way, 0, compare, s) : 0;
}

/* The ways of the two fastest solids in a step; their sum is how far a gap closes at most. */
typedef struct ways {
  double first, second;
} ways;

static void add_way(ways *w, double way)
{
  w->second = fmax(w->second, fmin(w->first, way));
  w->first = fmax(w->first, way);
}

/* The slop is at least h^2 |g| / 2: what a body falls from rest. */
int nsdae_bodies_may_enter(const double *v, double h, const void *user)
{
  const nsdae_bodies *b = nsdae_bodies_of(user);
  double slop = h * h / 2 * sqrt(nsdae_dot3(b->force.gravity, b->force.gravity));
  ways w = {0, 0};
  for (int i = 0; i < b->solid.count; i++) add_way(&w, way_of(b, nsdae_solid_at(b, i), v, h));
  return w.first + w.second > slop;
}

int nsdae_bodies_find_tunnelling(const double *q, const double *v, double h, double share,
                                 nsdae_tunnelling *worst, const void *user)
{
  nsdae_bodies *b = nsdae_bodies_of(user);
  ways w = {0, 0};
  int fast = 0;
  *worst = (nsdae_tunnelling){-1, 0, 0};
  for (int i = 0; i < b->solid.count; i++) {
    const nsdae_solid_of *s = nsdae_solid_at(b, i);
    double way = way_of(b, s, v, h);
    fast |= way > share * s->width;
    add_way(&w, way);
  }
  search s = {.b = b, .v = v, .h = h, .share = share, .worst = worst};
  for (int i = 0; fast && i < b->feature.count; i++) {
    const nsdae_feature *f = nsdae_feature_at(b, i);
    if (f->number > 0) continue;
    nsdae_pose pose[2];
    for (int j = 0; j < 2; j++)
      pose[j] = nsdae_bodies_pose(b, nsdae_solid_at(b, f->solid[j])->body, q, v);
    s.id = i;
    look_at(&s, f->solid[0], f->solid[1], &pose[0], &pose[1]);
  }
  if (!fast || !nsdae_bodies_has_list(b)) return NSDAE_OK;
  nsdae_broad *broad = nsdae_broad_take(b);
  if (!broad) return NSDAE_E_MEMORY;
  nsdae_broad_place(broad, q, v);
  int passes = nsdae_broad_sort(broad, w.first + w.second);
  for (int i = 0; i < passes; i++)
    nsdae_broad_pairs(broad, i, w.first + w.second, look_at_pair, &s);
  nsdae_broad_give_back(b, broad);
  return NSDAE_OK;
}
