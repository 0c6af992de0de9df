/* Boxes that overlap: the kit's closed forms beside libccd (support functions: GJK with EPA, and
 * MPR) and ODE's collision part, both in Debian. Depth against separating axes by hand, how it
 * changes where edges come to be parallel and blocks lie flush, how many contacts a pair has, time
 * for a pair. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <ccd/ccd.h>
#include <ccd/quat.h>
#include <ode/ode.h>

#include <nsdae/nsdae.h>

#include "bodies_impl.h"
#include "../support/random.h"
#include "ratio.h"

enum { POSES = 20000, RUNS = 5 };

static uint64_t seed = 3;

static double uniform(double low, double high)
{
  return random_between(&seed, low, high);
}

static const double edge[2][3] = {{1, 0.8, 0.6}, {0.5, 0.9, 0.7}};

/* Two poses: position and unit quaternion each. */
typedef struct poses {
  double q[14];
} poses;

/* What one library says of one pair. */
typedef struct answer {
  double depth, normal[3];
  int contacts;
} answer;

typedef answer (*collide_fn)(void *world, const poses *p);

/* ---- by hand: the depth by the fifteen axes (Gottschalk, Lin, Manocha 1996) */

static void frame_of(const double *q, double *R)
{
  nsdae_rotation_spatial(q + 3, R);
}

static double depth_along(const double *n, const double *d, const double *R0, const double *R1)
{
  double sum = -fabs(nsdae_dot3(n, d));
  for (int i = 0; i < 3; i++)
    sum += edge[0][i] / 2 * fabs(nsdae_dot3(n, R0 + 3 * i)) +
           edge[1][i] / 2 * fabs(nsdae_dot3(n, R1 + 3 * i));
  return sum;
}

static double exact_depth(const poses *p)
{
  double R0[9], R1[9], d[3], least = INFINITY;
  frame_of(p->q, R0);
  frame_of(p->q + 7, R1);
  for (int i = 0; i < 3; i++) d[i] = p->q[7 + i] - p->q[i];
  for (int i = 0; i < 3; i++) {
    least = fmin(least, depth_along(R0 + 3 * i, d, R0, R1));
    least = fmin(least, depth_along(R1 + 3 * i, d, R0, R1));
    for (int j = 0; j < 3; j++) {
      double n[3];
      nsdae_cross3(R0 + 3 * i, R1 + 3 * j, n);
      double length = sqrt(nsdae_dot3(n, n));
      if (length < 1e-8) continue;
      for (int k = 0; k < 3; k++) n[k] /= length;
      least = fmin(least, depth_along(n, d, R0, R1));
    }
  }
  return least;
}

/* ---- the kit */

typedef struct kit {
  nsdae_bodies *bodies;
  nsdae_system *system;
  nsdae_pose pose[2];
  nsdae_meeting met;
  answer answer;
} kit;

static int look(void *to, const nsdae_feature *f)
{
  kit *k = to;
  nsdae_closest closest;
  if (!nsdae_feature_closest(f, &k->met, &closest)) return 0;
  const nsdae_couple two = nsdae_feature_couple(f, &k->met);
  const nsdae_still still = nsdae_closest_still(&closest, &two);
  if (still.gap > 0) return 0;
  k->answer.contacts++;
  if (-still.gap <= k->answer.depth) return 0;
  k->answer.depth = -still.gap;
  for (int i = 0; i < 3; i++) k->answer.normal[i] = still.normal[i];
  return 0;
}

static answer by_kit(void *world, const poses *p)
{
  kit *k = world;
  const nsdae_solid_of *s = k->bodies->solid.at;
  k->answer = (answer){.depth = 0};
  for (int i = 0; i < 2; i++) k->pose[i] = nsdae_pose_of(3, p->q + 7 * i, NULL);
  const nsdae_couple two = {{s, s + 1}, {&k->pose[0], &k->pose[1]}};
  nsdae_meet(&two, 0, &k->met);
  if (!k->met.far) nsdae_pair_features(s, 0, 1, &k->met, look, k);
  return k->answer;
}

static void make_kit(kit *k)
{
  const nsdae_rigid_body body = {.mass = 1, .inertia = {1, 1, 1}};
  nsdae_bodies_create(3, &k->bodies, NULL);
  for (int i = 0; i < 2; i++) {
    nsdae_solid box = {.shape = NSDAE_SHAPE_BOX};
    memcpy(box.length, edge[i], sizeof box.length);
    nsdae_bodies_add(k->bodies, &body);
    nsdae_bodies_add_solid(k->bodies, i, &box);
  }
  nsdae_bodies_add_contact(k->bodies, 0, 1, 0, 0, 0);
}

/* ---- libccd: a box by its support function */

typedef struct ccd_box {
  const double *q, *edge;
} ccd_box;

static void support(const void *object, const ccd_vec3_t *direction, ccd_vec3_t *v)
{
  const ccd_box *box = object;
  double R[9], own[3], x[3];
  const double d[3] = {ccdVec3X(direction), ccdVec3Y(direction), ccdVec3Z(direction)};
  frame_of(box->q, R);
  nsdae_turn_back(R, d, own);
  for (int i = 0; i < 3; i++) own[i] = own[i] < 0 ? -box->edge[i] / 2 : box->edge[i] / 2;
  nsdae_turn(R, own, x);
  ccdVec3Set(v, x[0] + box->q[0], x[1] + box->q[1], x[2] + box->q[2]);
}

static void centre(const void *object, ccd_vec3_t *v)
{
  const ccd_box *box = object;
  ccdVec3Set(v, box->q[0], box->q[1], box->q[2]);
}

static answer by_ccd(const poses *p, int mpr)
{
  const ccd_box box[2] = {{p->q, edge[0]}, {p->q + 7, edge[1]}};
  answer a = {.depth = 0};
  ccd_t ccd;
  ccd_real_t depth = 0;
  ccd_vec3_t n, place;
  CCD_INIT(&ccd);
  ccd.support1 = ccd.support2 = support;
  ccd.center1 = ccd.center2 = centre;
  ccd.max_iterations = 1000;
  ccd.epa_tolerance = ccd.mpr_tolerance = 1e-10;
  int found = mpr ? ccdMPRPenetration(&box[0], &box[1], &ccd, &depth, &n, &place)
                  : ccdGJKPenetration(&box[0], &box[1], &ccd, &depth, &n, &place);
  if (found != 0) return a;
  a = (answer){depth, {ccdVec3X(&n), ccdVec3Y(&n), ccdVec3Z(&n)}, 1};
  return a;
}

static answer by_gjk(void *world, const poses *p)
{
  (void)world;
  return by_ccd(p, 0);
}

static answer by_mpr(void *world, const poses *p)
{
  (void)world;
  return by_ccd(p, 1);
}

/* ---- ODE */

static answer by_ode(void *world, const poses *p)
{
  dGeomID *box = world;
  dContactGeom contact[16];
  answer a = {.depth = 0};
  for (int i = 0; i < 2; i++) {
    const double *q = p->q + 7 * i;
    const dQuaternion turn = {(dReal)q[3], (dReal)q[4], (dReal)q[5], (dReal)q[6]};
    dGeomSetPosition(box[i], (dReal)q[0], (dReal)q[1], (dReal)q[2]);
    dGeomSetQuaternion(box[i], turn);
  }
  a.contacts = dCollide(box[0], box[1], 16, contact, sizeof *contact);
  for (int i = 0; i < a.contacts; i++) {
    if (contact[i].depth <= a.depth) continue;
    a.depth = contact[i].depth;
    for (int j = 0; j < 3; j++) a.normal[j] = -contact[i].normal[j];
  }
  return a;
}

/* ---- poses: turned at random; flush, an edge along an edge */

static void random_turn(double *p)
{
  double square = 0;
  for (int i = 0; i < 4; i++) p[i] = uniform(-1, 1), square += p[i] * p[i];
  for (int i = 0; i < 4; i++) p[i] /= sqrt(square);
}

/* Overlapping by depth along the axis of least depth, but for what the search leaves. */
static poses random_pose(double depth)
{
  poses p;
  memset(&p, 0, sizeof p);
  double way[3];
  for (int i = 0; i < 2; i++) random_turn(p.q + 7 * i + 3);
  do
    for (int i = 0; i < 3; i++) way[i] = uniform(-1, 1);
  while (nsdae_dot3(way, way) < 0.01);
  double low = 0, high = 10;
  for (int k = 0; k < 60; k++) {
    double middle = (low + high) / 2;
    for (int i = 0; i < 3; i++) p.q[7 + i] = middle * way[i];
    *(exact_depth(&p) > depth ? &low : &high) = middle;
  }
  return p;
}

/* One on the other, edges along edges, overlapping by 1e-3 but for a turn of the size tilt. */
static poses flush_pose(double tilt)
{
  poses p = {.q = {0, 0, 0, 1, 0, 0, 0, 0.25, -0.05, 0.649, 1, 0, 0, 0}};
  for (int i = 0; i < 3; i++) p.q[11 + i] = tilt * uniform(-1, 1);
  double square = 0;
  for (int i = 0; i < 4; i++) square += p.q[10 + i] * p.q[10 + i];
  for (int i = 0; i < 4; i++) p.q[10 + i] /= sqrt(square);
  return p;
}

typedef struct library {
  const char *name;
  collide_fn collide;
  void *world;
  double median[RUNS];
} library;

static void measure(const library *l, const char *what, const poses *p, int count)
{
  double worst = 0;
  long wrong = 0, missed = 0, contacts = 0;
  for (int i = 0; i < count; i++) {
    answer a = l->collide(l->world, &p[i]);
    double exact = exact_depth(&p[i]), error = fabs(a.depth - exact);
    contacts += a.contacts;
    missed += a.contacts == 0;
    if (a.contacts == 0) continue;
    worst = fmax(worst, error);
    wrong += error > 1e-6;
  }
  printf("  %-14s %-22s %9.1e %8.3f %% %8.3f %% %8.2f\n", l->name, what, worst,
         100. * (double)wrong / count, 100. * (double)missed / count, (double)contacts / count);
}

static int compare(const void *a, const void *b)
{
  const double *x = a, *y = b;
  return (*x > *y) - (*x < *y);
}

int main(void)
{
  static poses deep[POSES], thin[POSES], flush[POSES];
  kit k;
  dInitODE2(0);
  dGeomID geom[2];
  make_kit(&k);
  for (int i = 0; i < 2; i++)
    geom[i] = dCreateBox(NULL, (dReal)edge[i][0], (dReal)edge[i][1], (dReal)edge[i][2]);
  library libraries[] = {{"nsdae", by_kit, &k, {0}},
                         {"libccd GJK/EPA", by_gjk, NULL, {0}},
                         {"libccd MPR", by_mpr, NULL, {0}},
                         {"ODE dBoxBox", by_ode, geom, {0}}};
  for (int i = 0; i < POSES; i++) {
    deep[i] = random_pose(uniform(0.01, 0.2));
    thin[i] = random_pose(1e-4);
    flush[i] = flush_pose(pow(10, uniform(-14, -3)));
  }
  printf("two boxes that overlap, %d poses of each kind; depth against separating axes\n", POSES);
  printf("  %-14s %-22s %9s %10s %10s %8s\n", "", "", "worst [m]", "> 1e-6", "missed", "contacts");
  for (int l = 0; l < 4; l++) {
    measure(&libraries[l], "deep 0.01 .. 0.2 m", deep, POSES);
    measure(&libraries[l], "thin 1e-4 m", thin, POSES);
    measure(&libraries[l], "flush 1e-3 m", flush, POSES);
  }
  for (int run = 0; run < RUNS; run++)
    for (int l = 0; l < 4; l++) {
      double from = ratio_cpu(), sum = 0;
      for (int i = 0; i < POSES; i++)
        sum += libraries[l].collide(libraries[l].world, &thin[i]).depth;
      libraries[l].median[run] = sum >= 0 ? (ratio_cpu() - from) / POSES : 0;
    }
  for (int l = 0; l < 4; l++) {
    qsort(libraries[l].median, RUNS, sizeof(double), compare);
    printf("  %-14s %.2f us a pair\n", libraries[l].name, 1e6 * libraries[l].median[RUNS / 2]);
  }
  for (int l = 1; l < 4; l++)
    ratio_add("contacts of two boxes", libraries[0].median[RUNS / 2], libraries[l].name,
              libraries[l].median[RUNS / 2]);
  nsdae_bodies_destroy(&k.bodies);
  dCloseODE();
  return 0;
}
