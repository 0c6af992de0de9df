/* Islands of a step on several threads: the same bits and the same errors for any number of them.
 * Under a sanitizer of threads (cmake --preset threads) the same program looks for races. */
#include "check.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "twin.h"
#include "support/random.h"

enum { NUMBERS = 4, STEPS = 40, STATES = 64 };

static const int numbers[NUMBERS] = {1, 2, 3, 8};

/* What a run leaves: sums of its bits step by step, and how it ended. */
typedef struct trace {
  uint64_t bits[STATES];
  int steps, status, islands, contacts;
  double residual;
  long lcps;
  nsdae_error error;
} trace;

/* FNV-1a, 64 bits. */
static uint64_t fold(uint64_t hash, const void *data, size_t bytes)
{
  const unsigned char *p = data;
  for (size_t i = 0; i < bytes; i++) hash = (hash ^ p[i]) * 1099511628211u;
  return hash;
}

static uint64_t bits_of(const nsdae_sim *sim, const nsdae_dims *dims)
{
  nsdae_record r;
  uint64_t hash = 14695981039346656037u;
  nsdae_sim_get_record(sim, &r);
  size_t k = (size_t)r.contacts.count, nt = (size_t)dims->nt;
  hash = fold(hash, r.q, (size_t)dims->nq * sizeof(double));
  hash = fold(hash, r.v, (size_t)dims->nv * sizeof(double));
  hash = fold(hash, r.multiplier, (size_t)dims->m * sizeof(double));
  hash = fold(hash, r.contacts.normal_impulse, k * sizeof(double));
  hash = fold(hash, r.contacts.tangential_impulse, k * nt * sizeof(double));
  return fold(hash, r.contacts.mode, k * sizeof(int));
}

/* A system, and where it starts. */
typedef struct scene {
  nsdae_system *system;
  nsdae_dims dims;
  const double *q0, *v0;
  int steps;   /* 0: STEPS */
  double give; /* contact_give; 0: 1, what is not solved fails */
} scene;

static void run(const scene *s, int method, int threads, double tol, trace *t)
{
  nsdae_sim_options options;
  nsdae_sim *sim;
  nsdae_stats stats;
  memset(t, 0, sizeof *t);
  nsdae_sim_options_default(&options);
  options.start_tol = 1; /* some begin deep in each other */
  options.method = method;
  options.dt = 2e-3;
  options.contact_tol = tol;
  options.contact_give = s->give > 0 ? s->give : 1;
  options.threads = threads;
  assert_int_equal(nsdae_sim_create(s->system, &options, &sim, NULL), NSDAE_OK);
  t->status = nsdae_sim_init(sim, 0, s->q0, s->v0);
  for (; t->steps < (s->steps > 0 ? s->steps : STEPS) && t->status >= 0; t->steps++) {
    t->status = nsdae_sim_step(sim);
    t->bits[t->steps] = bits_of(sim, &s->dims);
    nsdae_sim_get_stats(sim, &stats);
    if (stats.islands > t->islands) t->islands = stats.islands;
  }
  nsdae_sim_get_stats(sim, &stats);
  t->residual = stats.worst_residual;
  t->lcps = stats.lcps;
  t->contacts = stats.island_contacts;
  t->error = *nsdae_sim_error(sim);
  nsdae_sim_destroy(&sim);
}

static void same(const trace *a, const trace *b)
{
  assert_int_equal(a->status, b->status);
  assert_int_equal(a->steps, b->steps);
  assert_memory_equal(a->bits, b->bits, sizeof a->bits);
  assert_memory_equal(&a->residual, &b->residual, sizeof a->residual);
  assert_int_equal(a->lcps, b->lcps);
  assert_int_equal(a->islands, b->islands);
  assert_int_equal(a->contacts, b->contacts);
  assert_int_equal(a->error.index, b->error.index);
  assert_string_equal(a->error.text, b->error.text);
  assert_string_equal(a->error.where, b->error.where);
}

/* All numbers of threads; returns the most islands of a step. */
static int compare(const scene *s, int method, double tol, int *status)
{
  static trace first, other;
  run(s, method, numbers[0], tol, &first);
  for (int i = 1; i < NUMBERS; i++) {
    run(s, method, numbers[i], tol, &other);
    same(&first, &other);
  }
  *status = first.status;
  if (first.status < 0) print_message("%s\n", first.error.text);
  return first.islands;
}

/* Its start onto its constraints. */
static void project(twin *t)
{
  nsdae_system *dense = twin_dense(t);
  nsdae_sim *sim;
  assert_int_equal(nsdae_sim_create(dense, NULL, &sim, NULL), NSDAE_OK);
  assert_true(nsdae_sim_project(sim, 0, t->q0, t->v0) >= 0);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&dense);
}

/* Joined by constraints or not, planar, frictionless, cones: whatever a mechanism is. */
static void test_mechanisms(void **state)
{
  static const twin_kind kinds[] = {
      {.blocks = 48, .largest = 3, .k = 40, .nt = 1, .friction = 0.4, .restitution = 0.5},
      {.blocks = 48, .largest = 3, .k = 40, .restitution = 0.5},
      {.blocks = 24, .largest = 6, .k = 60, .nt = 2, .friction = 0.6, .restitution = 0.2},
      {.blocks = 40, .largest = 3, .joined = 1, .k = 60, .nt = 1, .friction = 0.3}};
  int most = 0, status;
  (void)state;
  for (size_t kind = 0; kind < sizeof kinds / sizeof *kinds; kind++)
    for (uint64_t seed = 0; seed < 3; seed++)
      for (int method = NSDAE_METHOD_IMPLICIT; method <= NSDAE_METHOD_MOREAU; method += 2) {
        static twin t;
        twin_draw(&t, 500 * kind + seed, &kinds[kind]);
        scene s = {.system = twin_blocks(&t), .q0 = t.q0, .v0 = t.v0};
        s.dims = (nsdae_dims){.nq = t.nv, .nv = t.nv, .m = t.m, .nt = t.nt};
        assert_non_null(s.system);
        project(&t);
        int islands = compare(&s, method, 1e-8, &status);
        if (islands > most) most = islands;
        nsdae_system_destroy(&s.system);
      }
  print_message("at most %d islands\n", most);
  assert_true(most > 4);
}

/* Two blocks without mass: the one of the first island is told, whoever met the other sooner. */
static void test_errors(void **state)
{
  static const twin_kind kind = {.blocks = 48, .largest = 3, .k = 64, .nt = 1, .friction = 0.4};
  int failed = 0, status;
  (void)state;
  for (uint64_t seed = 0; seed < 6; seed++) {
    static twin t;
    twin_draw(&t, 9000 + seed, &kind);
    t.M[11 + seed][0] = t.M[30 - seed][0] = t.M[40][0] = -1;
    scene s = {.system = twin_blocks(&t), .q0 = t.q0, .v0 = t.v0};
    s.dims = (nsdae_dims){.nq = t.nv, .nv = t.nv, .m = t.m, .nt = t.nt};
    compare(&s, NSDAE_METHOD_MOREAU, 1e-8, &status);
    failed += status < 0;
    nsdae_system_destroy(&s.system);
  }
  assert_int_equal(failed, 6);
}

static int add_sphere(nsdae_bodies *world, const double *at, int material)
{
  nsdae_rigid_body body = {.mass = 1, .inertia = {4e-3, 4e-3, 4e-3}};
  memcpy(body.position, at, sizeof body.position);
  int number = nsdae_bodies_add(world, &body);
  nsdae_bodies_add_solid(
      world, number,
      &(nsdae_solid){.shape = NSDAE_SHAPE_SPHERE, .radius = 0.1, .material = material});
  return number;
}

/* A loose heap of so many over x. */
static void add_heap(nsdae_bodies *world, double x, int spheres, int material, uint64_t *seed)
{
  for (int i = 0; i < spheres; i++) {
    double at[3] = {x + 0.22 * (i & 1), 0.22 * (i >> 1 & 1), 0.111 + 0.22 * (i >> 2)};
    for (int j = 0; j < 3; j++) at[j] += 0.02 * (random_uniform(seed) - 0.5);
    add_sphere(world, at, material);
  }
}

/* Spheres on one string, askew, that falls. */
static void add_chain(nsdae_bodies *world, double x, int spheres, int material)
{
  for (int i = 0, last = -1; i < spheres; i++) {
    const double at[3] = {x, 0.24 * i, 0.105 + 0.02 * i};
    int number = add_sphere(world, at, material);
    nsdae_joint joint = {.kind = NSDAE_JOINT_SPHERICAL,
                         .body = {last, number},
                         .point = {x, 0.24 * i - 0.12, 0.095 + 0.02 * i}};
    if (i > 0) nsdae_bodies_add_joint(world, &joint);
    last = number;
  }
}

enum { PARTS = 24 };

/* Rough and smooth heaps on a floor and chains, apart from each other, of one sphere and of many:
 * all that an island can be. */
static nsdae_bodies *draw_world(int with_chains)
{
  const nsdae_solid floor = {.shape = NSDAE_SHAPE_PLANE};
  nsdae_bodies *world;
  uint64_t seed = 5;
  assert_int_equal(nsdae_bodies_create(3, &world, NULL), NSDAE_OK);
  nsdae_bodies_set_gravity(world, (double[3]){0, 0, -9.81});
  nsdae_bodies_add_solid(world, NSDAE_GROUND, &floor);
  for (int material = 1; material <= 2; material++) {
    double mu = material == 1 ? 0.5 : 0;
    nsdae_bodies_set_pair(world, 0, material, mu, 0.1, 0);
    nsdae_bodies_set_pair(world, material, material, mu, 0.1, 0);
  }
  for (int i = 0; i < PARTS; i++) {
    add_heap(world, i, 1 + i % 12, 1 + i % 2, &seed);
    if (with_chains) add_chain(world, -1 - i, 2 + i % 14, 1 + i % 2);
  }
  return world;
}

/* The worst residual that contact_tol allows and less than rounding: there islands fail. */
static void spread(int with_chains, int method, double tol, int fails)
{
  static double q0[7 * PARTS * 28], v0[6 * PARTS * 28];
  nsdae_bodies *world = draw_world(with_chains);
  scene s = {.q0 = q0, .v0 = v0};
  int status;
  assert_int_equal(nsdae_bodies_get_dims(world, &s.dims), NSDAE_OK);
  assert_true(s.dims.nq <= (int)(sizeof q0 / sizeof *q0));
  assert_true(nsdae_bodies_system(world, &s.system) >= 0);
  nsdae_bodies_get_start(world, q0, v0);
  int islands = compare(&s, method, tol, &status);
  assert_true(islands > PARTS / 2);
  assert_int_equal(status < 0, fails);
  nsdae_system_destroy(&s.system);
  nsdae_bodies_destroy(&world);
}

static void test_spread(void **state)
{
  (void)state;
  spread(1, NSDAE_METHOD_MOREAU, 1e-6, 0);
  spread(0, NSDAE_METHOD_IMPLICIT, 1e-8, 0);
  spread(1, NSDAE_METHOD_MOREAU, 2.3e-16, 1);
}

/* Spheres, capsules and boxes in a lattice that falls into a tray: pairs by the grid, planes, one
 * island with all bodies, and lists that grow from nothing. */
enum { SIDE = 6, LAYERS = 6, LATTICE = SIDE * SIDE * LAYERS };

static void add_lattice_body(nsdae_bodies *world, int i, uint64_t *seed)
{
  static const int shapes[] = {NSDAE_SHAPE_SPHERE, NSDAE_SHAPE_CAPSULE, NSDAE_SHAPE_BOX,
                               NSDAE_SHAPE_BOX, NSDAE_SHAPE_BOX};
  const int place[] = {i % SIDE, i / SIDE % SIDE, i / SIDE / SIDE};
  nsdae_rigid_body body = {
      .mass = 1, .inertia = {4e-3, 4e-3, 3e-3}, .velocity = {-0.2, -0.2, -1 - 0.6 * place[2]}};
  nsdae_solid solid = {.shape = shapes[random_below(seed, 5)], .radius = 0.1, .material = 1};
  for (int j = 0; j < 3; j++)
    body.position[j] = 0.205 * place[j] + 0.11 + 0.004 * (random_uniform(seed) - 0.5);
  if (solid.shape == NSDAE_SHAPE_CAPSULE) solid.radius = 0.08, solid.length[2] = 0.04;
  if (solid.shape == NSDAE_SHAPE_BOX) {
    solid.radius = 0;
    for (int j = 0; j < 3; j++) solid.length[j] = 0.2;
  }
  nsdae_bodies_add_solid(world, nsdae_bodies_add(world, &body), &solid);
}

static nsdae_bodies *draw_lattice(void)
{
  const double half = 0.5 * 0.205 * SIDE, turn = sqrt(0.5);
  nsdae_bodies *world;
  uint64_t seed = 11;
  assert_int_equal(nsdae_bodies_create(3, &world, NULL), NSDAE_OK);
  nsdae_bodies_set_gravity(world, (double[3]){0, 0, -9.81});
  nsdae_bodies_set_pair(world, 0, 1, 0.4, 0.1, 0);
  nsdae_bodies_set_pair(world, 1, 1, 0.4, 0.1, 0);
  nsdae_bodies_add_solid(world, NSDAE_GROUND, &(nsdae_solid){.shape = NSDAE_SHAPE_PLANE});
  for (int i = 0; i < 2; i++) { /* walls at x = 0 and y = 0, the normal inwards */
    nsdae_solid wall = {.shape = NSDAE_SHAPE_PLANE, .quaternion = {turn}};
    wall.position[1 - i] = half;
    wall.quaternion[i == 0 ? 2 : 1] = i == 0 ? turn : -turn;
    nsdae_bodies_add_solid(world, NSDAE_GROUND, &wall);
  }
  for (int i = 0; i < LATTICE; i++) add_lattice_body(world, i, &seed);
  return world;
}

static void test_large_island(void **state)
{
  static double q0[7 * LATTICE], v0[6 * LATTICE];
  static const int methods[] = {NSDAE_METHOD_MOREAU, NSDAE_METHOD_IMPLICIT};
  static trace first, other;
  (void)state;
  for (int m = 0; m < 2; m++) {
    nsdae_bodies *world = draw_lattice();
    scene s = {.q0 = q0, .v0 = v0, .steps = test_share() == 1 ? 40 : m == 0 ? 33 : 26, .give = 100};
    assert_int_equal(nsdae_bodies_get_dims(world, &s.dims), NSDAE_OK);
    assert_true(nsdae_bodies_system(world, &s.system) >= 0);
    nsdae_bodies_get_start(world, q0, v0);
    run(&s, methods[m], 1, 1e-4, &first);
    print_message("%d contacts in an island, %d steps, %s\n", first.contacts, first.steps,
                  first.error.text);
    assert_true(first.contacts >= (m == 0 ? 256 : 64));
    for (int i = test_share() > 1 ? 2 + m : 1; i < NUMBERS; i += test_share()) {
      run(&s, methods[m], numbers[i], 1e-4, &other);
      same(&first, &other);
    }
    nsdae_system_destroy(&s.system);
    nsdae_bodies_destroy(&world);
  }
}

/* As said by its key; none and too many are refused by it. */
static void test_option(void **state)
{
  nsdae_sim_options options;
  nsdae_error error;
  (void)state;
  nsdae_sim_options_default(&options);
  assert_int_equal(options.threads, 1);
  assert_int_equal(nsdae_sim_options_set(&options, "threads", "3", &error), NSDAE_OK);
  assert_int_equal(options.threads, 3);
  assert_int_equal(nsdae_sim_options_set(&options, "threads", "0", &error), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_sim_options_set(&options, "threads", "257", &error), NSDAE_E_ARGUMENT);
  assert_string_equal(error.argument, "threads");
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_mechanisms), cmocka_unit_test(test_errors),
      cmocka_unit_test(test_spread),     cmocka_unit_test(test_large_island),
      cmocka_unit_test(test_option),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
