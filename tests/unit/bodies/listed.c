/* Contacts by materials: the broad phase against every pair by force, the systems against those
 * with numbered contacts, coordinates of one's own and joints by blocks. */
#include "check.h"

#include <nsdae/nsdae.h>

#include "broad_phase.h"
#include "space.h"
#include "support/feature_touch.h"
#include "support/random.h"

enum { NQ_MAX = 80, SOLIDS_MAX = 120 };

static uint64_t seed;

static double uniform(double low, double high)
{
  return random_between(&seed, low, high);
}

static const double corners[8] = {-0.5, -0.4, 0.6, -0.3, 0.5, 0.5, -0.4, 0.3};

/* A solid of any shape: most of size one, some ten times that. */
static nsdae_solid random_solid(int d)
{
  static const int planar[5] = {NSDAE_SHAPE_POINT, NSDAE_SHAPE_DISC, NSDAE_SHAPE_SEGMENT,
                                NSDAE_SHAPE_POLYGON, NSDAE_SHAPE_PLANE};
  static const int spatial[5] = {NSDAE_SHAPE_POINT, NSDAE_SHAPE_SPHERE, NSDAE_SHAPE_CAPSULE,
                                 NSDAE_SHAPE_BOX, NSDAE_SHAPE_PLANE};
  double size = uniform(0, 1) < 0.1 ? 10 : 1;
  int shape = (int)uniform(0, uniform(0, 1) < 0.1 ? 5 : 4);
  nsdae_solid s = {.shape = (d == 2 ? planar : spatial)[shape],
                   .radius = size * uniform(0.1, 0.5),
                   .length = {size * uniform(0.5, 2), uniform(0.5, 2), uniform(0.5, 2)},
                   .hollow = uniform(0, 1) < 0.1,
                   .points = 4,
                   .point = corners,
                   .material = (int)uniform(0, 3)};
  if (shape == 0 || shape == 3) s.radius = 0;
  if (uniform(0, 1) < 0.5) s.group = 1 << (int)uniform(0, 3);
  if (uniform(0, 1) < 0.3) s.exclude = 1 << (int)uniform(0, 3);
  for (int i = 0; i < d; i++) s.position[i] = uniform(-0.5, 0.5);
  for (int i = 0; i < 4; i++) s.quaternion[i] = uniform(-1, 1);
  if (d == 2) memset(s.quaternion, 0, sizeof s.quaternion);
  return s;
}

/* Bodies with up to three solids each, the ground among them; materials 0 and 0, 0 and 2, 1 and 2
 * touch. */
static nsdae_bodies *scene(int d, int bodies)
{
  nsdae_bodies *b;
  assert_int_equal(nsdae_bodies_create(d, &b, NULL), NSDAE_OK);
  for (int i = 0; i < bodies; i++) {
    nsdae_rigid_body body = {.mass = 1, .inertia = {1, 1, 1}, .angle = uniform(-3, 3)};
    for (int j = 0; j < d; j++) body.position[j] = uniform(-4, 4);
    for (int j = 0; j < 4; j++) body.quaternion[j] = uniform(-1, 1);
    if (d == 2) memset(body.quaternion, 0, sizeof body.quaternion);
    if (d == 3) body.angle = 0;
    assert_int_equal(nsdae_bodies_add(b, &body), i);
  }
  for (int i = -1; i < bodies; i++)
    for (int j = (int)uniform(0, 4); j > 0; j--) {
      nsdae_solid s = random_solid(d);
      assert_true(nsdae_bodies_add_solid(b, i, &s) >= 0);
    }
  const int pair[3][2] = {{0, 0}, {2, 0}, {1, 2}};
  for (int i = 0; i < 3; i++)
    assert_int_equal(nsdae_bodies_set_pair(b, pair[i][0], pair[i][1], 0.3, 0, 0), NSDAE_OK);
  return b;
}

typedef struct nearest_gap {
  const nsdae_bodies *bodies;
  const double *q;
  double least;
} nearest_gap;

static int look(void *to, const nsdae_feature *f)
{
  nearest_gap *n = to;
  const nsdae_solid_of *s = n->bodies->solid.at;
  nsdae_pose pose[2];
  for (int i = 0; i < 2; i++)
    pose[i] = nsdae_bodies_pose(n->bodies, s[f->solid[i]].body, n->q, NULL);
  nsdae_touch touch;
  if (feature_touch(s, f, pose, &touch)) n->least = fmin(n->least, touch.gap.x);
  return 0;
}

typedef struct visits {
  int times[SOLIDS_MAX][SOLIDS_MAX], count, order[20000];
} visits;

static int visit(void *to, const nsdae_broad *broad, int i, int j)
{
  visits *v = to;
  (void)broad;
  assert_true(i < j);
  v->times[i][j]++;
  if (v->count < 20000) v->order[v->count++] = i * SOLIDS_MAX + j;
  return 0;
}

static void visit_all(nsdae_broad *broad, double reach, visits *v)
{
  int passes = nsdae_broad_sort(broad, reach);
  for (int i = 0; i < passes; i++)
    assert_int_equal(nsdae_broad_pairs(broad, i, reach, visit, v), 0);
}

/* Every pair within reach is visited, once; no other of materials or bodies that do not touch. */
static void check_scene(int d, int bodies)
{
  static visits seen, again;
  nsdae_bodies *b = scene(d, bodies);
  const nsdae_solid_of *s = b->solid.at;
  double q[NQ_MAX * 7], v[NQ_MAX * 6], reach = uniform(0, 0.5);
  int touching = 0;
  assert_true(b->solid.count <= SOLIDS_MAX);
  nsdae_bodies_get_start(b, q, v);
  nsdae_broad *broad = nsdae_broad_take(b);
  assert_non_null(broad);
  memset(&seen, 0, sizeof seen);
  memset(&again, 0, sizeof again);
  nsdae_broad_place(broad, q, NULL);
  visit_all(broad, reach, &seen);
  visit_all(broad, reach, &again);
  assert_memory_equal(&seen, &again, sizeof seen);
  for (int i = 0; i < b->solid.count; i++)
    for (int j = i + 1; j < b->solid.count; j++) {
      int m = s[i].filter.material * 3 + s[j].filter.material;
      int may = s[i].body != s[j].body && (m == 0 || m == 2 || m == 6 || m == 5 || m == 7) &&
                (s[i].filter.group & s[j].filter.exclude) == 0 &&
                (s[j].filter.group & s[i].filter.exclude) == 0;
      int endless = (s[i].shape == NSDAE_SHAPE_PLANE || s[i].hollow) &&
                    (s[j].shape == NSDAE_SHAPE_PLANE || s[j].hollow);
      nearest_gap near = {b, q, INFINITY};
      assert_true(seen.times[i][j] <= (may && !endless));
      if (!may || endless) continue;
      nsdae_pair_features(s, i, j, NULL, look, &near);
      if (near.least <= reach) assert_int_equal(seen.times[i][j], 1);
      touching += near.least <= reach;
    }
  assert_true(touching == 0 || seen.count >= touching);
  nsdae_broad_give_back(b, broad);
  nsdae_bodies_destroy(&b);
}

static void test_broad(void **state)
{
  (void)state;
  seed = 5;
  for (int i = 0; i < 200; i++) check_scene(2 + i % 2, 1 + i % 40);
}

/* Two discs of equal masses that a prismatic joint guides towards each other with 1 m/s. Without
 * restitution a contact brings them to rest; without a contact they pass through each other. */
typedef struct guided {
  int body[2];           /* of the joint; the second disc is body 1 or the ground */
  int collide_connected; /* of the joint; 2: of a slot, but not of a gear beside it */
  int named;             /* a contact of nsdae_bodies_add_contact */
  int group[2], exclude[2];
  int touch;
} guided;

static void add_guide(nsdae_bodies *b, const guided *g, int kind, int collide_connected)
{
  const nsdae_joint guide = {.kind = kind,
                             .body = {g->body[0], g->body[1]},
                             .axis = {1, 0, 0},
                             .ratio = 1,
                             .collide_connected = collide_connected};
  assert_true(nsdae_bodies_add_joint(b, &guide) >= 0);
}

static void check_guided(const guided *g)
{
  nsdae_bodies *b;
  nsdae_system *system;
  nsdae_sim *sim;
  nsdae_record r;
  nsdae_sim_options options;
  double q[6], v[6];
  assert_int_equal(nsdae_bodies_create(2, &b, NULL), NSDAE_OK);
  for (int i = 0; i < 2; i++) {
    int body = i == 0 ? 0 : g->body[1];
    if (body != NSDAE_GROUND)
      nsdae_bodies_add(b, &(nsdae_rigid_body){.mass = 1,
                                              .inertia = {0, 0, 1},
                                              .position = {i ? 0.5 : -0.5},
                                              .velocity = {i ? -1 : 1}});
    nsdae_bodies_add_solid(b, body,
                           &(nsdae_solid){.shape = NSDAE_SHAPE_DISC,
                                          .radius = 0.25,
                                          .position = {body == NSDAE_GROUND ? 0.5 : 0},
                                          .group = g->group[i],
                                          .exclude = g->exclude[i]});
  }
  if (g->collide_connected == 2) {
    add_guide(b, g, NSDAE_JOINT_SLOT, 1);
    add_guide(b, g, NSDAE_JOINT_GEAR, 0);
  } else {
    add_guide(b, g, NSDAE_JOINT_PRISMATIC, g->collide_connected);
  }
  if (g->named) nsdae_bodies_add_contact(b, 0, 1, 0, 0, 0);
  nsdae_bodies_set_pair(b, 0, 0, 0, 0, 0);
  assert_true(nsdae_bodies_system(b, &system) >= 0);
  nsdae_bodies_get_start(b, q, v);
  nsdae_sim_options_default(&options);
  options.method = NSDAE_METHOD_MOREAU;
  options.dt = 0.01;
  assert_int_equal(nsdae_sim_create(system, &options, &sim, NULL), NSDAE_OK);
  assert_int_equal(nsdae_sim_init(sim, 0, q, v), NSDAE_OK);
  assert_true(nsdae_sim_run(sim, 1) >= 0);
  nsdae_sim_get_record(sim, &r);
  assert_near(r.v[0], g->touch ? 0 : 1, 1e-12);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  nsdae_bodies_destroy(&b);
}

static void test_neighbours(void **state)
{
  (void)state;
  const guided cases[] = {
      {.body = {0, 1}},
      {.body = {1, 0}},
      {.body = {0, 1}, .collide_connected = 1, .touch = 1},
      {.body = {0, 1}, .collide_connected = 2},
      {.body = {0, 1}, .named = 1, .touch = 1},
      {.body = {0, NSDAE_GROUND}, .touch = 1},
      {.body = {0, NSDAE_GROUND}, .group = {1, 4}, .exclude = {6, 2}},
      {.body = {0, NSDAE_GROUND}, .group = {1, 4}, .exclude = {2, 1}},
      {.body = {0, NSDAE_GROUND}, .group = {1, 4}, .exclude = {2, 8}, .touch = 1},
      {.body = {0, NSDAE_GROUND}, .named = 1, .group = {1, 4}, .exclude = {6, 2}, .touch = 1},
  };
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) check_guided(&cases[i]);
}

/* Pairs of bodies with joints, at random: excluded are their solids, and no others. */
static void check_joined(int d, int bodies)
{
  nsdae_bodies *b = scene(d, bodies);
  const nsdae_solid_of *s = b->solid.at;
  int joined[NQ_MAX][NQ_MAX] = {{0}};
  for (int i = 0; i < bodies; i++) {
    int body[2] = {(int)uniform(0, bodies), (int)uniform(0, bodies + 1) - 1};
    if (body[0] == body[1]) continue;
    int collide = uniform(0, 1) < 0.3;
    nsdae_joint j = {.kind = NSDAE_JOINT_WELD, .collide_connected = collide};
    for (int l = 0; l < 2; l++) j.body[l] = body[i % 2 ? 1 - l : l];
    assert_true(nsdae_bodies_add_joint(b, &j) >= 0);
    if (!collide && body[1] >= 0) joined[body[0]][body[1]] = joined[body[1]][body[0]] = 1;
  }
  nsdae_broad *broad = nsdae_broad_take(b);
  assert_non_null(broad);
  for (int i = 0; i < b->solid.count; i++)
    for (int j = 0; j < b->solid.count; j++) {
      int both = s[i].body >= 0 && s[j].body >= 0;
      if (i != j && s[i].body != s[j].body)
        assert_int_equal(nsdae_broad_is_excluded(broad, i, j),
                         both && joined[s[i].body][s[j].body]);
    }
  nsdae_broad_give_back(b, broad);
  nsdae_bodies_destroy(&b);
}

static void test_joined(void **state)
{
  (void)state;
  seed = 6;
  for (int i = 0; i < 100; i++) check_joined(2 + i % 2, 2 + i % 40);
}

/* Balls (or discs) that fall into a corner of planes: with their contacts numbered, or by list. */
static void fall(int d, int by_list, double mu, double *q, int *contacts)
{
  enum { BALLS = 8 };
  nsdae_bodies *b;
  nsdae_system *system;
  nsdae_sim *sim;
  nsdae_record r;
  nsdae_dims dims;
  nsdae_error error;
  double q0[NQ_MAX], v0[NQ_MAX], gravity[3] = {0, 0, 0};
  gravity[d - 1] = -9.81;
  seed = 99;
  assert_int_equal(nsdae_bodies_create(d, &b, NULL), NSDAE_OK);
  nsdae_bodies_set_gravity(b, gravity);
  for (int i = 0; i < BALLS; i++) {
    nsdae_rigid_body body = {.mass = 1, .inertia = {0.1, 0.1, 0.1}};
    for (int j = 0; j < d; j++) body.position[j] = uniform(-0.05, 0.05);
    body.position[d - 1] = 0.6 + 1.1 * i;
    nsdae_bodies_add(b, &body);
    nsdae_bodies_add_solid(b, i,
                           &(nsdae_solid){.shape = d == 2 ? NSDAE_SHAPE_DISC : NSDAE_SHAPE_SPHERE,
                                          .radius = 0.5,
                                          .material = 1});
  }
  int floor = nsdae_bodies_add_solid(b, NSDAE_GROUND, &(nsdae_solid){.shape = NSDAE_SHAPE_PLANE});
  for (int i = 0; i < BALLS && !by_list; i++) {
    nsdae_bodies_add_contact(b, floor, i, mu, 0.2, 0);
    for (int j = 0; j < i; j++) nsdae_bodies_add_contact(b, j, i, mu, 0.2, 0);
  }
  if (by_list) {
    nsdae_bodies_set_pair(b, 1, 1, mu, 0.2, 0);
    nsdae_bodies_set_pair(b, 0, 1, mu, 0.2, 0);
  }
  int status = nsdae_bodies_system(b, &system);
  if (status < 0) print_error("%s\n", nsdae_bodies_error(b)->text);
  assert_true(status >= 0);
  nsdae_bodies_get_dims(b, &dims);
  assert_int_equal(dims.k, by_list ? 0 : BALLS * (BALLS + 1) / 2);
  assert_int_equal(dims.nt, d - 1);
  nsdae_bodies_get_start(b, q0, v0);
  nsdae_sim_options options;
  nsdae_sim_options_default(&options);
  options.method = NSDAE_METHOD_MOREAU;
  options.dt = 2e-3;
  assert_int_equal(nsdae_sim_create(system, &options, &sim, &error), NSDAE_OK);
  assert_int_equal(nsdae_sim_init(sim, 0, q0, v0), NSDAE_OK);
  status = nsdae_sim_run(sim, 0.3);
  if (status < 0) print_error("%s\n", nsdae_sim_error(sim)->text);
  assert_true(status >= 0);
  nsdae_sim_get_record(sim, &r);
  memcpy(q, r.q, (size_t)dims.nq * sizeof *q);
  *contacts = by_list ? r.contacts.count : 0;
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  nsdae_bodies_destroy(&b);
}

static void test_same_as_numbered(void **state)
{
  (void)state;
  for (int d = 2; d <= 3; d++)
    for (int i = 0; i < 2; i++) {
      double numbered[NQ_MAX], listed[NQ_MAX];
      int none, closed;
      fall(d, 0, 0.3 * i, numbered, &none);
      fall(d, 1, 0.3 * i, listed, &closed);
      assert_true(closed >= 2);
      for (int j = 0; j < 8 * (d == 2 ? 3 : 7); j++) assert_near(listed[j], numbered[j], 1e-7);
    }
}

/* A drum of one's own by blocks: see the guide; the load hangs beside a heap that it never meets.
 */
static int drum_mass(double t, const double *q, double *M, int ldm, void *user)
{
  (void)t;
  (void)q;
  (void)user;
  assert_int_equal(ldm, 1);
  M[0] = 0.5;
  return 0;
}

static int rope(double t, const double *q, double *phi, void *user)
{
  (void)t;
  (void)user;
  phi[0] = q[1] + q[6];
  return 0;
}

static int rope_rows(double t, const double *q, nsdae_row_list *rows, void *user)
{
  const double load[3] = {0, 1, 0}, drum[1] = {1};
  (void)t;
  (void)q;
  (void)user;
  int status = nsdae_row_add(rows, 2, 0, load); /* behind the two of the hinge */
  return status < 0 ? status : nsdae_row_add(rows, 2, 2, drum);
}

static int rope_bias(double t, const double *q, const double *v, double *phi_t, double *omega,
                     void *user)
{
  (void)t;
  (void)q;
  (void)v;
  (void)user;
  phi_t[0] = omega[0] = 0;
  return 0;
}

static nsdae_bodies *load_and_pendulum(const nsdae_user_rows *own)
{
  nsdae_bodies *b;
  const double gravity[3] = {0, -10, 0};
  assert_int_equal(nsdae_bodies_create(2, &b, NULL), NSDAE_OK);
  nsdae_bodies_set_gravity(b, gravity);
  nsdae_bodies_add(b, &(nsdae_rigid_body){.mass = 2, .inertia = {0, 0, 1}});
  nsdae_bodies_add(b, &(nsdae_rigid_body){.mass = 1, .inertia = {0, 0, 1}, .position = {50}});
  nsdae_bodies_add_joint(
      b, &(nsdae_joint){.kind = NSDAE_JOINT_REVOLUTE, .body = {NSDAE_GROUND, 1}, .point = {50, 1}});
  nsdae_bodies_add_solid(b, 0, &(nsdae_solid){.shape = NSDAE_SHAPE_POINT});
  nsdae_bodies_add_solid(b, NSDAE_GROUND,
                         &(nsdae_solid){.shape = NSDAE_SHAPE_PLANE, .position = {0, -100}});
  assert_int_equal(nsdae_bodies_set_pair(b, 0, 0, 0.5, 0, 0), NSDAE_OK);
  assert_int_equal(nsdae_bodies_set_user_rows(b, own), NSDAE_OK);
  return b;
}

static int rope_jacobian(double t, const double *q, double *J, int ldj, void *user)
{
  (void)t;
  (void)q;
  (void)user;
  J[ldj] = J[6 * ldj] = 1;
  return 0;
}

/* The user's rows by blocks, or as a matrix over all velocities. */
static void run_own(int dense)
{
  const nsdae_user_rows own = {.dims = {.nq = 1, .m = 1},
                               .mass = drum_mass,
                               .constraint = rope,
                               .constraint_rows = dense ? NULL : rope_rows,
                               .constraint_jacobian = dense ? rope_jacobian : NULL,
                               .constraint_bias = rope_bias};
  nsdae_bodies *b = load_and_pendulum(&own);
  nsdae_system *system;
  nsdae_sim *sim;
  nsdae_record r;
  double q[7], v[7];
  assert_true(nsdae_bodies_system(b, &system) >= 0);
  assert_int_equal(nsdae_system_get_blocks(system), 3);
  nsdae_bodies_get_start(b, q, v);
  assert_int_equal(nsdae_sim_create(system, NULL, &sim, NULL), NSDAE_OK);
  assert_int_equal(nsdae_sim_init(sim, 0, q, v), NSDAE_OK);
  int status = nsdae_sim_run(sim, 1);
  if (status < 0) print_error("%s\n", nsdae_sim_error(sim)->text);
  assert_true(status >= 0);
  nsdae_sim_get_record(sim, &r);
  assert_near(r.q[1], -4, 1e-10); /* 2 g / 2.5 */
  assert_near(r.q[6], 4, 1e-10);
  assert_near(hypot(r.q[3] - 50, r.q[4] - 1), 1, 1e-6);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  nsdae_bodies_destroy(&b);
}

static void test_own_by_blocks(void **state)
{
  (void)state;
  for (int dense = 0; dense < 2; dense++) run_own(dense);
}

static void refused(nsdae_bodies *b, int status, const char *argument)
{
  nsdae_system *system;
  assert_int_equal(nsdae_bodies_system(b, &system), status);
  assert_string_equal(nsdae_bodies_error(b)->argument, argument);
  nsdae_bodies_destroy(&b);
}

static nsdae_bodies *two_points(void)
{
  nsdae_bodies *b;
  assert_int_equal(nsdae_bodies_create(2, &b, NULL), NSDAE_OK);
  for (int i = 0; i < 2; i++) {
    nsdae_bodies_add(b, &(nsdae_rigid_body){.mass = 1, .inertia = {0, 0, 1}, .position = {i}});
    nsdae_bodies_add_solid(b, i, &(nsdae_solid){.shape = NSDAE_SHAPE_POINT});
  }
  return b;
}

static int own_gap(double t, const double *q, double *g, void *user)
{
  (void)t, (void)user;
  *g = q[0];
  return 0;
}

static int own_tangent(double t, const double *q, double *W, int ldw, void *user)
{
  (void)t, (void)q, (void)ldw, (void)user;
  W[1] = 1;
  return 0;
}

static void test_refused(void **state)
{
  (void)state;
  nsdae_bodies *b = two_points();
  assert_true(nsdae_bodies_set_pair(b, 0, NSDAE_MATERIALS, 0, 0, 0) == NSDAE_E_ARGUMENT);
  refused(b, NSDAE_E_ARGUMENT, "material");
  b = two_points();
  assert_true(nsdae_bodies_set_pair(b, -1, 0, 0, 0, 0) == NSDAE_E_ARGUMENT);
  refused(b, NSDAE_E_ARGUMENT, "material");
  b = two_points();
  assert_true(nsdae_bodies_set_pair(b, 0, 0, 0, 2, 0) == NSDAE_E_ARGUMENT);
  refused(b, NSDAE_E_ARGUMENT, "e_n");
  b = two_points();
  assert_true(
      nsdae_bodies_add_solid(b, 0, &(nsdae_solid){.shape = NSDAE_SHAPE_POINT, .material = -1}) ==
      NSDAE_E_ARGUMENT);
  refused(b, NSDAE_E_ARGUMENT, "material");
  b = two_points();
  nsdae_bodies_set_pair(b, 0, 0, 0, 0, 0);
  nsdae_bodies_set_user_rows(
      b, &(nsdae_user_rows){.dims = {.k = 1}, .gap = own_gap, .gap_tangent = own_tangent});
  refused(b, NSDAE_E_STATE, "pair");
}

/* A ball on a ball, or on a column of them: what spins about the normals of its contacts goes on,
 * with friction (a point has none against that) and without, and stands otherwise. */
static void test_spin_stays(void **state)
{
  (void)state;
  for (int count = 2; count <= 24; count += 11)
    for (int form = 0; form < 6; form++) {
      int rough = form % 3, frictional_joint = rough == 0;
      double tilt = form < 3 ? 0 : 1e-14;
      nsdae_bodies *b;
      nsdae_system *system;
      nsdae_sim *sim;
      nsdae_record r;
      nsdae_sim_options options;
      double q0[7 * 24], v0[6 * 24];
      nsdae_bodies_create(3, &b, NULL);
      nsdae_bodies_set_gravity(b, (const double[]){0, 0, -9.81});
      nsdae_bodies_add_solid(
          b, NSDAE_GROUND,
          &(nsdae_solid){.shape = NSDAE_SHAPE_PLANE, .quaternion = {1, tilt / 2, 0, 0}});
      nsdae_bodies_set_pair(b, 0, 0, rough > 0 ? 0.5 : 0, 0, 0);
      nsdae_bodies_set_pair(b, 0, 1, rough > 1 ? 0.5 : 0, 0, 0);
      for (int i = 0; i < count; i++) {
        nsdae_bodies_add(b, &(nsdae_rigid_body){.mass = 1,
                                                .inertia = {0.004, 0.004, 0.004},
                                                .position = {0, 0, 0.1 + 0.2 * i},
                                                .velocity = {0, frictional_joint, 0},
                                                .spin = {0, 0, i % 2 ? 10 : -3}});
        nsdae_bodies_add_solid(
            b, i,
            &(nsdae_solid){.shape = NSDAE_SHAPE_SPHERE, .radius = 0.1, .material = i == count - 1});
      }
      assert_true(nsdae_bodies_system(b, &system) >= 0);
      nsdae_bodies_get_start(b, q0, v0);
      nsdae_sim_options_default(&options);
      options.method = NSDAE_METHOD_MOREAU;
      options.dt = 1e-3;
      assert_int_equal(nsdae_sim_create(system, &options, &sim, NULL), NSDAE_OK);
      assert_int_equal(nsdae_sim_init(sim, 0, q0, v0), NSDAE_OK);
      for (int n = 0; n < 20; n++) assert_true(nsdae_sim_step(sim) >= 0);
      nsdae_sim_get_record(sim, &r);
      assert_int_equal(r.contacts.count, count);
      for (int i = 0; i < count; i++)
        for (int j = 0; j < 6; j++)
          assert_near(r.v[6 * i + j],
                      j == 5   ? (i % 2 ? 10 : -3)
                      : j == 1 ? frictional_joint
                               : 0,
                      j == 5 || tilt > 0 ? 1e-12 : 0);
      nsdae_sim_destroy(&sim);
      nsdae_system_destroy(&system);
      nsdae_bodies_destroy(&b);
    }
}

/* Contacts of a lattice: each direction with all signs and in all orders. */
static const double packings[][3] = {{0, 0, 1}, {0, 1, 1},     {1, 1, 1},
                                     {0, 1, 2}, {1, 1, 1.414}, {0, 1, 1.414},
                                     {1, 2, 2}, {0, 1, 1.732}, {1, 1.732, 3.266}};

static void turned_direction(const double *of, int order, double *n)
{
  static const int all[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
  double length = sqrt(nsdae_dot3(of, of));
  for (int i = 0; i < 3; i++)
    n[i] = (order >> i & 1 ? -1 : 1) * of[all[order / 8][i]] / length + uniform(-1e-4, 1e-4);
}

/* Of normals of packings the frames do not turn over by rounding, and no frame is nearly flat. */
static void test_frames_follow(void **state)
{
  (void)state;
  seed = 3;
  for (size_t k = 0; k < sizeof packings / sizeof *packings; k++)
    for (int order = 0; order < 48; order++) {
      double n[3], near[3];
      turned_direction(packings[k], order, n);
      for (int i = 0; i < 20; i++) {
        turned_direction(packings[k], order, near);
        assert_int_equal(nsdae_tangent_axis(near[2]), nsdae_tangent_axis(n[2]));
      }
      assert_true(fabs(n[nsdae_tangent_axis(n[2])]) < 0.96);
    }
}

/* Layers of balls in a box, each in the hollows of the one below: no two of a layer touch. */
static nsdae_bodies *packed(int side, int layers)
{
  const double r = 0.01, J = 0.4 * 4e-3 * r * r, half = ((side - 1) * 1.01 + 1.005) * r;
  nsdae_bodies *b;
  nsdae_bodies_create(3, &b, NULL);
  nsdae_bodies_set_gravity(b, (const double[]){0, 0, -9.81});
  nsdae_bodies_set_pair(b, 0, 0, 0.5, 0, 0);
  nsdae_bodies_add_solid(b, NSDAE_GROUND, &(nsdae_solid){.shape = NSDAE_SHAPE_PLANE});
  for (int i = 0; i < 4; i++) { /* a quarter turn brings z to where a wall looks */
    nsdae_solid wall = {.shape = NSDAE_SHAPE_PLANE, .quaternion = {sqrt(0.5)}};
    wall.position[i / 2] = i % 2 ? half : -half;
    wall.quaternion[i < 2 ? 2 : 1] = (i % 2 == i / 2 ? 1 : -1) * sqrt(0.5);
    nsdae_bodies_add_solid(b, NSDAE_GROUND, &wall);
  }
  for (int layer = 0, n = 0; layer < layers; layer++)
    for (int i = 0, across = side - layer % 2; i < across * across; i++) {
      nsdae_rigid_body body = {.mass = 4e-3, .inertia = {J, J, J}};
      body.position[0] = 2.02 * r * (i % across - (across - 1) / 2.0);
      body.position[1] = 2.02 * r * (i / across - (across - 1) / 2.0);
      body.position[2] = r * (1.005 + 1.415 * layer);
      nsdae_bodies_add(b, &body);
      nsdae_bodies_add_solid(b, n++, &(nsdae_solid){.shape = NSDAE_SHAPE_SPHERE, .radius = r});
    }
  return b;
}

/* A regular heap that stands: what a step begins with is its solution, or near it. */
static void test_standing_heap_begins_well(void **state)
{
  enum { SETTLE = 60, STEPS = 40 };
  nsdae_bodies *b = packed(5, 3);
  nsdae_system *system;
  nsdae_sim *sim;
  nsdae_sim_options options;
  nsdae_stats before, after;
  double q0[7 * 66], v0[6 * 66];
  (void)state;
  assert_true(nsdae_bodies_system(b, &system) >= 0);
  nsdae_bodies_get_start(b, q0, v0);
  nsdae_sim_options_default(&options);
  options.method = NSDAE_METHOD_MOREAU;
  options.dt = 2e-3;
  options.contact_tol = 1e-4;
  assert_int_equal(nsdae_sim_create(system, &options, &sim, NULL), NSDAE_OK);
  assert_int_equal(nsdae_sim_init(sim, 0, q0, v0), NSDAE_OK);
  for (int i = 0; i < SETTLE; i++) assert_true(nsdae_sim_step(sim) >= 0);
  nsdae_sim_get_stats(sim, &before);
  for (int i = 0; i < STEPS; i++) assert_true(nsdae_sim_step(sim) >= 0);
  nsdae_sim_get_stats(sim, &after);
  assert_true(after.lcp_pivots - before.lcp_pivots <= 3 * STEPS);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  nsdae_bodies_destroy(&b);
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_broad),
                                     cmocka_unit_test(test_neighbours),
                                     cmocka_unit_test(test_joined),
                                     cmocka_unit_test(test_same_as_numbered),
                                     cmocka_unit_test(test_own_by_blocks),
                                     cmocka_unit_test(test_spin_stays),
                                     cmocka_unit_test(test_refused),
                                     cmocka_unit_test(test_frames_follow),
                                     cmocka_unit_test(test_standing_heap_begins_well)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
