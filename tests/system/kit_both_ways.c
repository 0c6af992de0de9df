/* Mechanisms of the kit whose contacts are named (nsdae_bodies_add_contact), found by materials
 * (nsdae_bodies_set_pair), or both: the same motion and the same events. */
#include "check.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <nsdae/nsdae.h>

#include "random.h"

enum { SOLIDS_MAX = 8, NQ_MAX = 64 };

/* Every pair by its number; by materials; pairs with solid 0 by their number, the others by
 * materials. */
enum { FIXED, LISTED, MIXED, FORMS };

/* The pairs that may touch, and how their contacts are numbered; see nsdae_bodies_set_pair. */
typedef struct scene {
  nsdae_bodies *b;
  int form, solids, per_pair; /* per_pair: the C of the ids */
  double mu, e;
  int first[SOLIDS_MAX][SOLIDS_MAX]; /* of fixed contacts */
  int named;                         /* contacts of nsdae_bodies_add_contact in this form */
  int fixed;                         /* the same of the form FIXED */
} scene;

static scene begin(int dimension, int form, int per_pair, double mu, double e)
{
  scene s = {.form = form, .per_pair = per_pair, .mu = mu, .e = e};
  double gravity[3] = {0};
  gravity[dimension - 1] = -9.81;
  assert_int_equal(nsdae_bodies_create(dimension, &s.b, NULL), NSDAE_OK);
  nsdae_bodies_set_gravity(s.b, gravity);
  return s;
}

static int add_solid(scene *s, int body, nsdae_solid solid, int material)
{
  solid.material = material;
  s->solids++;
  return nsdae_bodies_add_solid(s->b, body, &solid);
}

/* Solids i < j may touch, in contacts of this number. */
static void touch(scene *s, int i, int j, int contacts)
{
  s->first[i][j] = s->fixed;
  s->fixed += contacts;
  if (s->form == LISTED || (s->form == MIXED && i > 0)) return;
  assert_int_equal(nsdae_bodies_add_contact(s->b, i, j, s->mu, s->e, 0), s->named);
  s->named += contacts;
}

/* Those of two materials touch. */
static void pair(scene *s, int material0, int material1)
{
  if (s->form != FIXED)
    assert_int_equal(nsdae_bodies_set_pair(s->b, material0, material1, s->mu, s->e, 0), NSDAE_OK);
}

/* The number of a contact among the fixed ones. */
static int number_of(const scene *s, long id)
{
  if (s->form == FIXED || id < s->named) return (int)id; /* pairs with solid 0 are named first */
  long number = (id - s->named) % s->per_pair, solids = (id - s->named) / s->per_pair;
  return s->first[solids / s->solids][solids % s->solids] + (int)number;
}

/* ---- scenes */

/* A box in the plane that turns, on the ground. */
static scene planar_box(int form)
{
  static const double corners[8] = {-0.2, -0.1, 0.2, -0.1, 0.2, 0.1, -0.2, 0.1};
  scene s = begin(2, form, 8, 0.3, 0.4);
  nsdae_bodies_add(s.b, &(nsdae_rigid_body){.mass = 1,
                                            .inertia = {0, 0, 0.02},
                                            .position = {0, 0.4},
                                            .angle = 0.3,
                                            .velocity = {0.5, 0},
                                            .spin = {0, 0, 1}});
  add_solid(&s, NSDAE_GROUND, (nsdae_solid){.shape = NSDAE_SHAPE_PLANE}, 0);
  add_solid(&s, 0, (nsdae_solid){.shape = NSDAE_SHAPE_POLYGON, .points = 4, .point = corners}, 1);
  touch(&s, 0, 1, 4);
  pair(&s, 0, 1);
  return s;
}

/* One in space. */
static scene spatial_box(int form)
{
  scene s = begin(3, form, 2 * 8 + 12 * 12, 0.3, 0.4);
  nsdae_bodies_add(s.b, &(nsdae_rigid_body){.mass = 1,
                                            .inertia = {0.02, 0.03, 0.04},
                                            .position = {0, 0, 0.5},
                                            .quaternion = {0.95, 0.1, 0.2, 0.15},
                                            .velocity = {0.3, 0.1, 0},
                                            .spin = {1, 0.5, -0.4}});
  add_solid(&s, NSDAE_GROUND, (nsdae_solid){.shape = NSDAE_SHAPE_PLANE}, 0);
  add_solid(&s, 0, (nsdae_solid){.shape = NSDAE_SHAPE_BOX, .length = {0.4, 0.3, 0.2}}, 1);
  touch(&s, 0, 1, 8);
  pair(&s, 0, 1);
  return s;
}

/* Newton's cradle: discs on rods, the first is lifted. */
static scene cradle(int form)
{
  enum { BALLS = 4 };
  const double radius = 0.05, angle = 0.3;
  scene s = begin(2, form, 2, 0, 1);
  for (int i = 0; i < BALLS; i++) {
    double turned = i == 0 ? -angle : 0, x = 2 * radius * i;
    nsdae_rigid_body ball = {.mass = 1, .inertia = {0, 0, 0.001}};
    ball.position[0] = x + sin(turned), ball.position[1] = -cos(turned);
    nsdae_bodies_add(s.b, &ball);
    nsdae_joint rod = {.kind = NSDAE_JOINT_DISTANCE, .body = {NSDAE_GROUND, i}, .point = {x}};
    memcpy(rod.end, ball.position, sizeof rod.end);
    nsdae_bodies_add_joint(s.b, &rod);
    add_solid(&s, i, (nsdae_solid){.shape = NSDAE_SHAPE_DISC, .radius = radius}, 0);
  }
  for (int i = 0; i + 1 < BALLS; i++) touch(&s, i, i + 1, 1);
  pair(&s, 0, 0);
  return s;
}

/* A ball that slides, and rolls then. */
static scene rolling_ball(int form)
{
  scene s = begin(3, form, 2, 0.2, 0);
  nsdae_bodies_add(s.b, &(nsdae_rigid_body){.mass = 1,
                                            .inertia = {0.004, 0.004, 0.004},
                                            .position = {0, 0, 0.1},
                                            .velocity = {1, 0.2, 0},
                                            .spin = {0, 1, 2}});
  add_solid(&s, NSDAE_GROUND, (nsdae_solid){.shape = NSDAE_SHAPE_PLANE}, 0);
  add_solid(&s, 0, (nsdae_solid){.shape = NSDAE_SHAPE_SPHERE, .radius = 0.1}, 1);
  touch(&s, 0, 1, 1);
  pair(&s, 0, 1);
  return s;
}

static int shaken(double t, double drive[3], void *user)
{
  const double a = 0.02, w = 20;
  (void)user;
  drive[0] = a * sin(w * t), drive[1] = a * w * cos(w * t), drive[2] = -a * w * w * sin(w * t);
  return 0;
}

/* Two discs, one above the other, over a half-space that a drive shakes. */
static scene shaken_discs(int form)
{
  scene s = begin(2, form, 2, 0.2, 0.6);
  nsdae_bodies_add(s.b, &(nsdae_rigid_body){.mass = 5, .inertia = {0, 0, 1}});
  nsdae_bodies_add_joint(s.b, &(nsdae_joint){.kind = NSDAE_JOINT_PRISMATIC,
                                             .body = {NSDAE_GROUND, 0},
                                             .axis = {0, 1},
                                             .drive = shaken});
  add_solid(&s, 0, (nsdae_solid){.shape = NSDAE_SHAPE_PLANE}, 0);
  for (int i = 1; i < 3; i++) {
    nsdae_bodies_add(s.b, &(nsdae_rigid_body){.mass = 1,
                                              .inertia = {0, 0, 0.005},
                                              .position = {0.01 * i, 0.35 * i},
                                              .spin = {0, 0, 3 * i}});
    add_solid(&s, i, (nsdae_solid){.shape = NSDAE_SHAPE_DISC, .radius = 0.1}, 1);
  }
  touch(&s, 0, 1, 1), touch(&s, 0, 2, 1), touch(&s, 1, 2, 1);
  pair(&s, 0, 1), pair(&s, 1, 1);
  nsdae_bodies_set_gravity(s.b, (const double[]){0, -9.81, 0});
  return s;
}

/* A bar on a pin, a disc that slides along it with friction to a stop on the ground. */
static scene slot(int form)
{
  scene s = begin(2, form, 2, 0.3, 0.5);
  nsdae_bodies_add(s.b, &(nsdae_rigid_body){.mass = 2, .inertia = {0, 0, 0.2}});
  nsdae_bodies_add(
      s.b, &(nsdae_rigid_body){.mass = 1, .inertia = {0, 0, 0.005}, .position = {0.2, -0.1}});
  nsdae_bodies_add_joint(s.b, &(nsdae_joint){.kind = NSDAE_JOINT_REVOLUTE,
                                             .body = {NSDAE_GROUND, 0},
                                             .point = {-0.5, 0.25}});
  nsdae_bodies_add_joint(s.b, &(nsdae_joint){.kind = NSDAE_JOINT_SLOT,
                                             .body = {0, 1},
                                             .point = {0.2, -0.1},
                                             .axis = {2, -1},
                                             .mu = 0.2});
  add_solid(&s, NSDAE_GROUND,
            (nsdae_solid){.shape = NSDAE_SHAPE_PLANE, .position = {0, -0.6}, .angle = -0.1}, 0);
  add_solid(&s, 1, (nsdae_solid){.shape = NSDAE_SHAPE_DISC, .radius = 0.1}, 1);
  touch(&s, 0, 1, 1);
  pair(&s, 0, 1);
  return s;
}

/* Two boxes, drawn, over a plane and each other. */
static uint64_t drawn;

static scene two_boxes(int form)
{
  enum { BOX_BOX = 2 * 8 + 12 * 12 };
  scene s = begin(3, form, BOX_BOX, 0.3, 0.4);
  uint64_t random = drawn;
  add_solid(&s, NSDAE_GROUND, (nsdae_solid){.shape = NSDAE_SHAPE_PLANE}, 0);
  for (int i = 0; i < 2; i++) {
    nsdae_rigid_body box = {.mass = 1, .inertia = {0.01, 0.012, 0.015}};
    for (int j = 0; j < 2; j++) box.position[j] = random_between(&random, -0.1, 0.1);
    box.position[2] = 0.3 + 0.4 * i;
    for (int j = 0; j < 2; j++) box.velocity[j] = random_between(&random, -1, 1);
    for (int j = 0; j < 4; j++) box.quaternion[j] = random_between(&random, -1, 1);
    for (int j = 0; j < 3; j++) box.spin[j] = random_between(&random, -4, 4);
    nsdae_bodies_add(s.b, &box);
    add_solid(&s, i, (nsdae_solid){.shape = NSDAE_SHAPE_BOX, .length = {0.3, 0.25, 0.2}}, 1);
  }
  touch(&s, 0, 1, 8), touch(&s, 0, 2, 8), touch(&s, 1, 2, BOX_BOX);
  pair(&s, 0, 1), pair(&s, 1, 1);
  return s;
}

/* Two or three boxes, drawn, that lie flush on a plane and on each other, some with a gap between
 * them; some slide. Most of their contacts are redundant, and features of two boxes coincide. */
static scene flush_boxes(int form)
{
  enum { BOX_BOX = 2 * 8 + 12 * 12 };
  uint64_t random = drawn;
  int boxes = random_uniform(&random) < 0.5 ? 2 : 3;
  double height = 0, mu = random_uniform(&random) < 0.3 ? 0 : random_between(&random, 0.1, 0.8);
  double e = random_uniform(&random) < 0.5 ? 0 : random_between(&random, 0, 0.8);
  scene s = begin(3, form, BOX_BOX, mu, e);
  add_solid(&s, NSDAE_GROUND, (nsdae_solid){.shape = NSDAE_SHAPE_PLANE}, 0);
  for (int i = 0; i < boxes; i++) {
    nsdae_solid solid = {.shape = NSDAE_SHAPE_BOX};
    nsdae_rigid_body box = {.inertia = {0.01, 0.012, 0.015}};
    box.mass = random_between(&random, 0.5, 2);
    for (int j = 0; j < 3; j++) solid.length[j] = 0.1 * (1 + random_below(&random, 4));
    for (int j = 0; j < 2; j++) box.position[j] = 0.05 * (random_below(&random, 3) - 1);
    if (random_uniform(&random) < 0.3) height += 0.05;
    box.position[2] = height + solid.length[2] / 2;
    height += solid.length[2];
    for (int j = 0; j < 2 && random_uniform(&random) < 0.3; j++)
      box.velocity[j] = random_between(&random, -1, 1);
    nsdae_bodies_add(s.b, &box);
    add_solid(&s, i, solid, 1);
  }
  for (int i = 0; i <= boxes; i++)
    for (int j = i + 1; j <= boxes; j++) touch(&s, i, j, i == 0 ? 8 : BOX_BOX);
  pair(&s, 0, 1), pair(&s, 1, 1);
  return s;
}

/* ---- runs */

typedef struct run {
  scene scene;
  nsdae_system *system;
  nsdae_sim *sim;
  nsdae_record record;
  nsdae_dims dims;
} run;

static int polygon; /* the option */

static int steps = 80;

static void start(run *r, scene (*make)(int), int form, int method)
{
  double q[NQ_MAX], v[NQ_MAX];
  nsdae_sim_options options;
  nsdae_error error;
  r->scene = make(form);
  int status = nsdae_bodies_system(r->scene.b, &r->system);
  if (status < 0) print_error("%s\n", nsdae_bodies_error(r->scene.b)->text);
  assert_true(status >= 0);
  nsdae_bodies_get_dims(r->scene.b, &r->dims);
  nsdae_bodies_get_start(r->scene.b, q, v);
  if (r->dims.m > 0 && make == shaken_discs) v[1] = 0.4; /* of the drive */
  nsdae_sim_options_default(&options);
  options.method = method;
  options.dt = 1e-2;
  options.polygon = polygon;
  status = nsdae_sim_create(r->system, &options, &r->sim, &error);
  if (status < 0) print_error("%s\n", error.text);
  assert_int_equal(status, NSDAE_OK);
  assert_int_equal(nsdae_sim_init(r->sim, 0, q, v), NSDAE_OK);
}

static void step(run *r)
{
  int status = nsdae_sim_step(r->sim);
  if (status < 0) print_error("%s\n", nsdae_sim_error(r->sim)->text);
  assert_true(status >= 0);
  nsdae_sim_get_record(r->sim, &r->record);
}

static void end(run *r)
{
  nsdae_sim_destroy(&r->sim);
  nsdae_system_destroy(&r->system);
  nsdae_bodies_destroy(&r->scene.b);
}

/* Of q, v, times and impulses, which are of order one; and of what rounding alone is: contacts that
 * are at rest in an impact of others may have such an impulse, or none. */
static const double near = 1e-10, rounding = 1e-15;

static int count_impacts(const nsdae_record *r)
{
  int count = 0;
  for (int i = 0; i < r->impacts; i++) count += r->impact[i].normal_impulse > rounding;
  return count;
}

/* Events of the same contact at the same time, with the same values; those of one time, which may
 * be several of one contact, may come in another order. */
static void compare_impacts(const run *a, const run *b)
{
  const nsdae_record *r = &a->record, *s = &b->record;
  assert_int_equal(count_impacts(s), count_impacts(r));
  for (int i = 0; i < s->impacts; i++) {
    if (s->impact[i].normal_impulse <= rounding) continue;
    const nsdae_impact *given = &s->impact[i];
    int number = number_of(&b->scene, given->id), found = 0;
    for (int j = 0; j < r->impacts && !found; j++) {
      const nsdae_impact *other = &r->impact[j];
      found = other->id == number && fabs(other->time - given->time) <= near &&
              fabs(other->normal_impulse - given->normal_impulse) <= near &&
              fabs(other->velocity_before - given->velocity_before) <= near &&
              other->accumulation == given->accumulation;
    }
    assert_true(found);
  }
}

static void compare_changes(const run *a, const run *b)
{
  const nsdae_record *r = &a->record, *s = &b->record;
  assert_int_equal(s->changes, r->changes);
  for (int i = 0; i < s->changes; i++) {
    const nsdae_change *given = &s->change[i];
    int number = number_of(&b->scene, given->id), found = 0;
    for (int j = 0; j < r->changes && !found; j++)
      found = r->change[j].id == number && fabs(r->change[j].time - given->time) <= near &&
              r->change[j].mode_after == given->mode_after &&
              r->change[j].mode_before == given->mode_before;
    assert_true(found);
  }
}

/* events: 1 there are some, -1 there may be, 0 they are not compared. */
static void check_scene(scene (*make)(int), int method, int events)
{
  const double bound = method <= NSDAE_METHOD_MOREAU ? 0 : near;
  long impacts = 0, changes = 0;
  for (int form = LISTED; form < FORMS; form++) {
    run a, b;
    start(&a, make, FIXED, method);
    start(&b, make, form, method);
    assert_true(a.dims.k == a.scene.fixed && b.dims.k == 0);
    for (int i = 0; i < steps; i++) {
      step(&a), step(&b);
      for (int j = 0; j < a.dims.nq; j++) assert_near(b.record.q[j], a.record.q[j], bound);
      for (int j = 0; j < a.dims.nv; j++) assert_near(b.record.v[j], a.record.v[j], bound);
      if (!events) continue;
      compare_impacts(&a, &b);
      compare_changes(&a, &b);
      impacts += a.record.impacts;
      changes += a.record.changes;
    }
    end(&a), end(&b);
  }
  assert_true(events <= 0 || impacts + changes > 0);
}

static void check_all(int method, int events)
{
  check_scene(planar_box, method, events);
  check_scene(spatial_box, method, events);
  check_scene(cradle, method, events);
  check_scene(rolling_ball, method, events && method == NSDAE_METHOD_EVENT); /* mode transitions */
  check_scene(shaken_discs, method, events);
  check_scene(slot, method, events);
}

/* Time stepping: the same bytes, by the cone and by polygons. */
static void test_time_stepping(void **state)
{
  (void)state;
  for (polygon = 0; polygon <= 8; polygon += 4)
    for (int method = NSDAE_METHOD_IMPLICIT; method <= NSDAE_METHOD_MOREAU; method++)
      check_all(method, 0);
  polygon = 0;
}

static void test_event(void **state)
{
  (void)state;
  check_all(NSDAE_METHOD_EVENT, 1);
}

static void test_penalty(void **state)
{
  (void)state;
  check_all(NSDAE_METHOD_PENALTY, 1);
}

/* Steps of the integrator that go beyond an impact: there the boxes overlap, and features of them
 * are listed first that are deep. By penalty for some steps after that alone: a record within an
 * impact has the rounding of its time, times its forces. */
static void test_beyond_an_impact(void **state)
{
  static const struct {
    uint64_t seed;
    int method, steps;
  } of[] = {
      {2, NSDAE_METHOD_EVENT, 35},    {12, NSDAE_METHOD_EVENT, 35}, {15, NSDAE_METHOD_EVENT, 35},
      {31, NSDAE_METHOD_EVENT, 35},   {54, NSDAE_METHOD_EVENT, 35}, {12, NSDAE_METHOD_PENALTY, 26},
      {18, NSDAE_METHOD_PENALTY, 23},
  };
  const int usual = steps;
  (void)state;
  for (size_t i = 0; i<sizeof of / sizeof *of; i += test_share()> 1 ? 3 : 1) {
    drawn = of[i].seed;
    steps = of[i].steps;
    check_scene(two_boxes, of[i].method, of[i].method == NSDAE_METHOD_EVENT);
  }
  steps = usual;
}

static void test_flush(void **state)
{
  const int usual = steps;
  (void)state;
  steps = 12;
  for (drawn = 1; drawn <= 20; drawn += test_share() > 1 ? 20 : 1)
    check_scene(flush_boxes, NSDAE_METHOD_EVENT, -1);
  steps = usual;
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_time_stepping),
                                     cmocka_unit_test(test_event), cmocka_unit_test(test_penalty),
                                     cmocka_unit_test(test_flush),
                                     cmocka_unit_test(test_beyond_an_impact)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
