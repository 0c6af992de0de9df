/* Points and forces of contacts in trajectory files: Newton's law of each ball in each step, of a
 * pile as a whole, equilibrium of a wall; resumed files, and what is refused. */
#include "check.h"

#include <hdf5.h>
#include <hdf5_hl.h>
#include <stdlib.h>

#include <nsdae/nsdae.h>

#include "bead.h"
#include "support/hung_bodies.h"
#include "support/random.h"

static const char path[] = "test_forces.h5", whole_path[] = "test_forces_whole.h5";

static const int methods[] = {NSDAE_METHOD_IMPLICIT, NSDAE_METHOD_MOREAU};
enum { METHODS = sizeof methods / sizeof *methods };

/* ---- simulations with files */

typedef struct fixture {
  nsdae_bodies *bodies;
  nsdae_system *system;
  nsdae_sim *sim;
  nsdae_trajectory *file;
  nsdae_trajectory_info info;
  nsdae_error error;
} fixture;

static fixture prepare(nsdae_bodies *b, int method, double dt)
{
  fixture f = {.bodies = b, .info = {.model = "forces", .contact_forces = 1}};
  nsdae_sim_options o;
  nsdae_dims d;
  nsdae_sim_options_default(&o);
  o.method = method;
  o.dt = dt;
  o.contact_tol = 1e-12;
  if (nsdae_bodies_system(b, &f.system) < 0) fail_msg("%s", nsdae_bodies_error(b)->text);
  nsdae_bodies_get_dims(b, &d);
  double *q = malloc((size_t)d.nq * sizeof *q), *v = malloc((size_t)d.nv * sizeof *v);
  assert_true(q && v);
  nsdae_bodies_get_start(b, q, v);
  assert_int_equal(nsdae_sim_create(f.system, &o, &f.sim, NULL), NSDAE_OK);
  if (nsdae_sim_init(f.sim, 0, q, v) < 0) fail_msg("%s", nsdae_sim_error(f.sim)->text);
  free(q), free(v);
  return f;
}

static void create_file(fixture *f, const char *name)
{
  if (nsdae_trajectory_create(f->sim, name, &f->info, &f->file, &f->error) < 0)
    fail_msg("%s", f->error.text);
}

static void finish(fixture *f, double t_end)
{
  if (nsdae_sim_run(f->sim, t_end) < 0) fail_msg("%s", nsdae_sim_error(f->sim)->text);
  assert_int_equal(nsdae_trajectory_close(&f->file, NSDAE_OK, NULL), NSDAE_OK);
  nsdae_sim_destroy(&f->sim);
  nsdae_system_destroy(&f->system);
  nsdae_bodies_destroy(&f->bodies);
}

/* ---- files as arrays */

/* Contact i of record k is row first(k) + i; its body: the block of the larger number, or i. */
typedef struct arrays {
  int records, fixed;
  double *time, *q, *v, *count, *first, *block, *normal, *point, *force;
} arrays;

static double *values(hid_t file, const char *name, int rank, hsize_t size[3])
{
  int has = -1;
  size[0] = size[1] = size[2] = 1;
  assert_true(H5LTget_dataset_ndims(file, name, &has) >= 0);
  assert_int_equal(has, rank);
  assert_true(H5LTget_dataset_info(file, name, size, NULL, NULL) >= 0);
  double *value = malloc((size_t)(size[0] * size[1] * size[2]) * sizeof *value + 1);
  assert_true(value && H5LTread_dataset_double(file, name, value) >= 0);
  return value;
}

static arrays read_file(const char *name)
{
  arrays a = {0};
  hsize_t size[3];
  hid_t file = H5Fopen(name, H5F_ACC_RDONLY, H5P_DEFAULT);
  assert_true(file >= 0);
  a.time = values(file, "/time", 1, size);
  a.records = (int)size[0];
  a.q = values(file, "/q", 2, size);
  a.v = values(file, "/v", 2, size);
  assert_true(H5LTget_attribute_int(file, "/contacts", "fixed", &a.fixed) >= 0);
  if (!a.fixed) {
    a.count = values(file, "/contacts/count", 1, size);
    a.first = values(file, "/contacts/first", 1, size);
    a.block = values(file, "/contacts/block", 2, size);
  }
  a.normal = values(file, "/contacts/normal_impulse", a.fixed ? 2 : 1, size);
  a.point = values(file, "/contacts/point", a.fixed ? 3 : 2, size);
  assert_int_equal(size[a.fixed ? 2 : 1], 3);
  a.force = values(file, "/contacts/force", a.fixed ? 3 : 2, size);
  H5Fclose(file);
  return a;
}

static void release(arrays *a)
{
  double *all[] = {a->time,  a->q,      a->v,     a->count, a->first,
                   a->block, a->normal, a->point, a->force};
  for (size_t i = 0; i < sizeof all / sizeof *all; i++) free(all[i]);
}

static int count_of(const arrays *a, int record)
{
  return a->fixed ? a->fixed : (int)a->count[record];
}

static int row_of(const arrays *a, int record, int contact)
{
  return contact + (a->fixed ? record * a->fixed : (int)a->first[record]);
}

/* Without an impulse: no point and no force. */
static int acts(const arrays *a, int row)
{
  const double *point = a->point + 3 * row, *force = a->force + 3 * row;
  if (a->normal[row] != 0) return 1;
  for (int j = 0; j < 3; j++) assert_true(isnan(point[j]) && force[j] == 0);
  return 0;
}

/* ---- balls on a plane */

enum { BALLS = 5, ROWS = 801 };
static const double h = 1e-3;

typedef struct rain {
  int d;
  double g[3], mass[BALLS], inertia[BALLS], radius[BALLS];
} rain;

/* Balls, discs if d = 2, that bounce, slip and roll with spin, far from each other, on the plane
 * z = 0 (y = 0): its normal is constant, so that a step has no other direction than its end. */
static nsdae_bodies *make_rain(rain *r, uint64_t *seed, int d, int list)
{
  int up = d - 1;
  *r = (rain){.d = d, .g = {random_between(seed, -3, 3)}};
  r->g[up] = -10;
  nsdae_bodies *b = create(d, r->g[0], r->g[1], r->g[2]);
  int plane = nsdae_bodies_add_solid(b, NSDAE_GROUND, &(nsdae_solid){.shape = NSDAE_SHAPE_PLANE});
  for (int i = 0; i < BALLS; i++) {
    nsdae_rigid_body body = {.position = {100 * i}};
    nsdae_solid ball = {.shape = d == 2 ? NSDAE_SHAPE_DISC : NSDAE_SHAPE_SPHERE,
                        .radius = random_between(seed, 0.05, 0.5)};
    body.position[up] = ball.radius + random_between(seed, 0, 0.3);
    for (int j = 0; j < d; j++) body.velocity[j] = random_between(seed, -2, 2);
    for (int j = d == 2 ? 2 : 0; j < 3; j++) body.spin[j] = random_between(seed, -20, 20);
    nsdae_solid_inertia(&ball, 20, &body.mass, body.inertia, NULL);
    r->mass[i] = body.mass;
    r->inertia[i] = body.inertia[2];
    r->radius[i] = ball.radius;
    nsdae_bodies_add(b, &body);
    int solid = nsdae_bodies_add_solid(b, i, &ball);
    if (!list) nsdae_bodies_add_contact(b, plane, solid, random_uniform(seed), 0.5, 0);
  }
  if (list) nsdae_bodies_set_pair(b, 0, 0, random_uniform(seed), 0.5, 0);
  return b;
}

/* Ball i in the step that ends at record k: F = m (dv / h - g), and I dw / h = r x F, in space its
 * length, because w is in the axes of the body, up to (h w)^2. */
static int check_ball(const rain *r, const arrays *a, int k, int i, const double force[3])
{
  int d = r->d, up = d - 1, nv = d == 2 ? 3 : 6;
  const double *v = a->v + (k * BALLS + i) * nv, *before = v - BALLS * nv;
  double most = r->mass[i] * 10, turned = 0, spin = 1, step = a->time[k] - a->time[k - 1];
  for (int j = 0; j < d; j++) most += fabs(force[j]);
  for (int j = 0; j < d; j++)
    assert_near(force[j], r->mass[i] * ((v[j] - before[j]) / step - r->g[j]), 1e-9 * most);
  for (int j = d; j < nv; j++) {
    turned += (v[j] - before[j]) * (v[j] - before[j]);
    spin += v[j] * v[j];
  }
  if (d == 2)
    assert_near(r->radius[i] * force[0], r->inertia[i] * (v[2] - before[2]) / step, 1e-9 * most);
  else
    assert_near(r->radius[i] * hypot(force[0], force[1]), r->inertia[i] * sqrt(turned) / step,
                step * step * spin * most);
  return force[up] > 0;
}

static void test_balls(void **state)
{
  uint64_t seed = 1;
  (void)state;
  for (int kind = 0; kind < 8; kind++) {
    rain r;
    int d = 2 + kind % 2, list = kind / 2 % 2, hits = 0, up = d - 1, nq = d == 2 ? 3 : 7;
    fixture f = prepare(make_rain(&r, &seed, d, list), methods[kind / 4], h);
    create_file(&f, path);
    finish(&f, (ROWS - 1) * h);
    arrays a = read_file(path);
    assert_int_equal(a.records, ROWS);
    for (int k = 1; k < ROWS; k++) {
      double force[BALLS][3] = {{0}};
      for (int c = 0; c < count_of(&a, k); c++) {
        int row = row_of(&a, k, c);
        if (!acts(&a, row)) continue;
        int ball = list ? (int)fmax(a.block[2 * row], a.block[2 * row + 1]) : c;
        const double *q = a.q + (k * BALLS + ball) * nq;
        for (int j = 0; j < 3; j++) force[ball][j] += a.force[3 * row + j];
        for (int j = 0; j < 3; j++)
          assert_near(a.point[3 * row + j],
                      j == up ? (q[j] - r.radius[ball]) / 2
                      : j < d ? q[j]
                              : 0,
                      1e-12 * (1 + fabs(q[0])));
      }
      for (int i = 0; i < BALLS; i++) hits += check_ball(&r, &a, k, i, force[i]);
    }
    assert_true(hits > 100);
    release(&a);
  }
}

/* ---- piles */

enum { PILE = 16 };

/* Balls and boxes that fall on a plane and each other. Internal forces cancel, and the normal of
 * the plane is constant: in each step the forces of the ground are the sum of m (dv / h - g). */
static void test_pile(void **state)
{
  uint64_t seed = 5;
  const double g[3] = {0.5, 0, -10};
  (void)state;
  for (int kind = 0; kind < METHODS; kind++) {
    double mass[PILE];
    int inner = 0, outer = 0;
    nsdae_bodies *b = create(3, g[0], g[1], g[2]);
    nsdae_bodies_add_solid(b, NSDAE_GROUND, &(nsdae_solid){.shape = NSDAE_SHAPE_PLANE});
    for (int i = 0; i < PILE; i++) {
      nsdae_rigid_body body = {.position = {0.25 * (i % 2), 0.25 * (i / 2 % 2), 0.3 + 0.11 * i}};
      nsdae_solid solid = {.shape = i % 3 ? NSDAE_SHAPE_BOX : NSDAE_SHAPE_SPHERE};
      if (i % 3)
        for (int j = 0; j < 3; j++) solid.length[j] = random_between(&seed, 0.1, 0.2);
      else
        solid.radius = random_between(&seed, 0.05, 0.12);
      for (int j = 0; j < 4; j++) body.quaternion[j] = random_between(&seed, -1, 1);
      nsdae_solid_inertia(&solid, 500, &body.mass, body.inertia, NULL);
      mass[i] = body.mass;
      nsdae_bodies_add(b, &body);
      nsdae_bodies_add_solid(b, i, &solid);
    }
    nsdae_bodies_set_pair(b, 0, 0, 0.5, 0.3, 0);
    fixture f = prepare(b, methods[kind], h);
    create_file(&f, path);
    finish(&f, 0.6);
    arrays a = read_file(path);
    for (int k = 1; k < a.records; k++) {
      double sum[3] = {0}, most = 0;
      for (int c = 0; c < count_of(&a, k); c++) {
        int row = row_of(&a, k, c);
        int ground = a.block[2 * row] < 0 || a.block[2 * row + 1] < 0;
        if (!acts(&a, row)) continue;
        inner += !ground, outer += ground;
        for (int j = 0; j < 3 && ground; j++) sum[j] += a.force[3 * row + j];
      }
      for (int j = 0; j < 3; j++) {
        double expected = 0, step = a.time[k] - a.time[k - 1];
        for (int i = 0; i < PILE; i++) {
          const double *v = a.v + 6 * (k * PILE + i) + j, *before = v - 6 * PILE;
          expected += mass[i] * ((*v - *before) / step - g[j]);
          most += mass[i] * (10 + fabs(*v - *before) / step);
        }
        assert_near(sum[j], expected, 1e-9 * most);
      }
    }
    assert_true(inner > 200 && outer > 500);
    release(&a);
  }
}

/* A ball and a wall of bricks at rest: the forces are those of the weights, and so are the moments
 * about the origin; the ball's acts at its foot, those of a brick within its faces. */
static void test_rest(void **state)
{
  enum { BRICKS = 9 };
  const double size[3] = {0.4, 0.2, 0.1}, at[3] = {3, 2, 0.25};
  (void)state;
  double sum[3] = {0}, moment[3] = {0}, expected[3] = {0}, weight = 10 * 2;
  nsdae_bodies *b = create(3, 0, 0, -10);
  nsdae_bodies_add_solid(b, NSDAE_GROUND, &(nsdae_solid){.shape = NSDAE_SHAPE_PLANE});
  nsdae_rigid_body ball = {.mass = 2, .inertia = {0.05, 0.05, 0.05}, .position = {3, 2, 0.25}};
  nsdae_bodies_add(b, &ball);
  nsdae_bodies_add_solid(b, 0, &(nsdae_solid){.shape = NSDAE_SHAPE_SPHERE, .radius = 0.25});
  expected[0] = weight * at[1], expected[1] = -weight * at[0];
  for (int i = 0; i < BRICKS; i++) { /* three courses in running bond */
    nsdae_solid brick = {.shape = NSDAE_SHAPE_BOX, .length = {size[0], size[1], size[2]}};
    nsdae_rigid_body body = {
        .position = {0.41 * (i % 3) + 0.2 * (i / 3 % 2), 0, size[2] * (0.5 + i / 3)}};
    nsdae_solid_inertia(&brick, 1000, &body.mass, body.inertia, NULL);
    weight += 10 * body.mass;
    expected[1] -= 10 * body.mass * body.position[0];
    nsdae_bodies_add(b, &body);
    nsdae_bodies_add_solid(b, i + 1, &brick);
  }
  nsdae_bodies_set_pair(b, 0, 0, 0.5, 0, 0);
  fixture f = prepare(b, NSDAE_METHOD_IMPLICIT, h);
  f.info.every = 100;
  create_file(&f, path);
  finish(&f, 0.3);
  arrays a = read_file(path);
  assert_int_equal(a.records, 4);
  for (int c = 0; c < count_of(&a, 3); c++) {
    int row = row_of(&a, 3, c);
    if (!acts(&a, row)) continue;
    const double *p = a.point + 3 * row, *force = a.force + 3 * row, *block = a.block + 2 * row;
    if (block[0] >= 0 && block[1] >= 0) continue; /* between bricks */
    int body = (int)fmax(block[0], block[1]);
    const double *q = a.q + 7 * (3 * (BRICKS + 1) + body);
    assert_near(p[2], 0, 1e-4);
    for (int j = 0; j < 2; j++)
      if (body == 0)
        assert_near(p[j], at[j], 1e-9);
      else
        assert_true(fabs(p[j] - q[j]) < size[j] / 2 + 1e-4);
    if (body == 0) assert_near(force[2], 20, 1e-6);
    for (int j = 0; j < 3; j++) {
      int x = (j + 1) % 3, y = (j + 2) % 3;
      sum[j] += force[j];
      moment[j] += p[x] * force[y] - p[y] * force[x];
    }
  }
  for (int j = 0; j < 3; j++) {
    assert_near(sum[j], j == 2 ? weight : 0, 1e-6 * weight);
    assert_near(moment[j], expected[j], 1e-4 * weight);
  }
  release(&a);
}

/* A prism stands on its base of CORNERS corners, more than one pass over the features of a pair
 * takes: each contact acts at a corner of its own, and together they carry weight and no moment. */
static void test_many_corners(void **state)
{
  enum { CORNERS = 40 };
  (void)state;
  for (int list = 0; list <= 1; list++) {
    double corner[6 * CORNERS], sum[3] = {0};
    int acting = 0, last = 10;
    for (int i = 0; i < 2 * CORNERS; i++) {
      double angle = 2 * acos(-1) * i / CORNERS;
      const double at[3] = {cos(angle), sin(angle), i < CORNERS ? -0.5 : 0.5};
      memcpy(corner + 3 * i, at, sizeof at);
    }
    const nsdae_solid prism = {
        .shape = NSDAE_SHAPE_POLYHEDRON, .points = 2 * CORNERS, .point = corner};
    nsdae_bodies *b = create(3, 0, 0, -10);
    nsdae_bodies_add_solid(b, NSDAE_GROUND, &(nsdae_solid){.shape = NSDAE_SHAPE_PLANE});
    nsdae_bodies_add(b,
                     &(nsdae_rigid_body){.mass = 2, .inertia = {1, 1, 1}, .position = {0, 0, 0.5}});
    nsdae_bodies_add_solid(b, 0, &prism);
    if (list)
      nsdae_bodies_set_pair(b, 0, 0, 0.5, 0, 0);
    else
      nsdae_bodies_add_contact(b, 0, 1, 0.5, 0, 0);
    fixture f = prepare(b, NSDAE_METHOD_IMPLICIT, h);
    create_file(&f, path);
    finish(&f, last * h);
    arrays a = read_file(path);
    assert_in_range(count_of(&a, last), CORNERS, 3 * CORNERS);
    for (int i = 0; i < count_of(&a, last); i++) {
      const double *p = a.point + 3 * row_of(&a, last, i),
                   *force = a.force + 3 * row_of(&a, last, i);
      if (!acts(&a, row_of(&a, last, i))) continue;
      acting++;
      assert_near(hypot(p[0], p[1]), 1, 1e-9);
      for (int j = 0; j < i; j++) {
        const double *other = a.point + 3 * row_of(&a, last, j);
        assert_true(isnan(other[0]) || hypot(p[0] - other[0], p[1] - other[1]) > 0.1);
      }
      sum[0] += p[1] * force[2];
      sum[1] += p[0] * force[2];
      sum[2] += force[2];
    }
    assert_true(acting > CORNERS / 2);
    for (int j = 0; j < 3; j++) assert_near(sum[j], j == 2 ? 20 : 0, 1e-6);
    release(&a);
  }
}

/* ---- resumed files, other files */

static void expect_same(const char *dataset)
{
  hsize_t one[3], other[3];
  hid_t a = H5Fopen(whole_path, H5F_ACC_RDONLY, H5P_DEFAULT);
  hid_t b = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT);
  int rank = 0;
  assert_true(H5LTget_dataset_ndims(a, dataset, &rank) >= 0);
  double *x = values(a, dataset, rank, one), *y = values(b, dataset, rank, other);
  size_t n = (size_t)(one[0] * one[1] * one[2]);
  assert_true(n > 0 && other[0] * other[1] * other[2] == n);
  assert_memory_equal(x, y, n * sizeof *x);
  free(x), free(y);
  H5Fclose(a);
  H5Fclose(b);
}

/* In parts as in one run; the second part need not ask for forces. */
static void test_parts(void **state)
{
  (void)state;
  for (int kind = 0; kind < 8; kind++) {
    int list = kind % 2;
    rain r;
    for (int parts = 1; parts <= 3; parts += 2)
      for (int i = 0; i < parts; i++) {
        uint64_t seed = 9;
        fixture f = prepare(make_rain(&r, &seed, 3, list), NSDAE_METHOD_MOREAU, h);
        f.info.every = kind & 2 ? 7 : 1;
        f.info.compress = kind & 4 ? 2 : 0;
        if (i == 0) create_file(&f, parts == 1 ? whole_path : path);
        if (i > 0) f.info.contact_forces = i == 1;
        if (i > 0 && nsdae_trajectory_resume(f.sim, path, &f.info, &f.file, &f.error) < 0)
          fail_msg("%s", f.error.text);
        finish(&f, (parts == 1 ? 300 : 100 * (i + 1)) * h);
      }
    expect_same("/contacts/point");
    expect_same("/contacts/force");
    expect_same("/contacts/normal_impulse");
  }
}

static void expect_error(const fixture *f, int status, int expected, const char *words)
{
  assert_int_equal(status, expected);
  assert_null(f->file);
  if (!strstr(f->error.text, words)) fail_msg("%s", f->error.text);
}

static void test_refused(void **state)
{
  (void)state;
  rain r;
  uint64_t seed = 2;
  bead plain_bead;
  double q0[3], v0[3];
  /* ---- a value out of range, and a system of callbacks */
  fixture f = prepare(make_rain(&r, &seed, 3, 1), NSDAE_METHOD_MOREAU, h);
  f.info.contact_forces = 2;
  remove(path);
  expect_error(&f, nsdae_trajectory_create(f.sim, path, &f.info, &f.file, &f.error),
               NSDAE_E_ARGUMENT, "contact_forces = 2 0 or 1");
  assert_string_equal(f.error.argument, "contact_forces");
  bead_default(&plain_bead);
  bead_start(&plain_bead, q0, v0);
  fixture plain = {.system = bead_system(&plain_bead),
                   .info = {.model = "bead", .contact_forces = 1}};
  assert_int_equal(nsdae_sim_create(plain.system, NULL, &plain.sim, NULL), NSDAE_OK);
  assert_int_equal(nsdae_sim_init(plain.sim, 0, q0, v0), NSDAE_OK);
  expect_error(&plain,
               nsdae_trajectory_create(plain.sim, path, &plain.info, &plain.file, &plain.error),
               NSDAE_E_ARGUMENT, "contact_forces = 1, but the system of sim has no solids");
  assert_string_equal(plain.error.where, "nsdae_trajectory_create");
  nsdae_sim_destroy(&plain.sim);
  nsdae_system_destroy(&plain.system);
  assert_null(fopen(path, "r"));
  /* ---- a file without forces */
  f.info.contact_forces = 0;
  create_file(&f, path);
  finish(&f, 0.1);
  seed = 2;
  f = prepare(make_rain(&r, &seed, 3, 1), NSDAE_METHOD_MOREAU, h);
  hid_t file = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT);
  assert_true(H5Lexists(file, "/contacts/point", H5P_DEFAULT) == 0);
  H5Fclose(file);
  expect_error(&f, nsdae_trajectory_resume(f.sim, path, &f.info, &f.file, &f.error),
               NSDAE_E_ARGUMENT, "it has contact_forces 0, this run 1");
  /* ---- a hostile file: forces of two components */
  create_file(&f, path);
  finish(&f, 0.1);
  file = H5Fopen(path, H5F_ACC_RDWR, H5P_DEFAULT);
  assert_true(H5Ldelete(file, "/contacts/force", H5P_DEFAULT) >= 0);
  const hsize_t wrong[2] = {1000, 2};
  double *zero = calloc(2000, sizeof *zero);
  assert_true(H5LTmake_dataset_double(file, "/contacts/force", 2, wrong, zero) >= 0);
  free(zero);
  H5Fclose(file);
  seed = 2;
  f = prepare(make_rain(&r, &seed, 3, 1), NSDAE_METHOD_MOREAU, h);
  expect_error(&f, nsdae_trajectory_resume(f.sim, path, &f.info, &f.file, &f.error), NSDAE_E_IO,
               "/contacts/force has rows of another length");
  create_file(&f, path);
  finish(&f, 0.01);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_balls), cmocka_unit_test(test_pile),
      cmocka_unit_test(test_rest),  cmocka_unit_test(test_many_corners),
      cmocka_unit_test(test_parts), cmocka_unit_test(test_refused)};
  H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
  int failed = cmocka_run_group_tests(tests, NULL, NULL);
  remove(path);
  remove(whole_path);
  return failed;
}
