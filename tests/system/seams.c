/* Solids slide over tiles that lie flush, with every shape of tile and slider and phase of their
 * edges, many exactly on seams. A floor without steps has no force along it but friction:
 *
 *   v(t) = v(0) - mu g t,
 *
 * and nothing climbs. A tile that is higher stops what hits it. usage: seams [SEED COUNT] prints
 * how many of COUNT members fail by each method, and which. NSDAE_LONG: 400 of each. */
#include "check.h"

#include <stdlib.h>
#include <string.h>

#include <nsdae/nsdae.h>

#include "random.h"
#include "run_bodies.h"

static const double gravity = 9.81, thick = 0.3, way = 1.0;

enum { BOXES, MESHES, FIELDS, PRISMS, MIXED, TILES };
enum { BOX, SPHERE, CAPSULE, PRISM, TWO_BOXES, SLIDERS };
enum { OF_GROUND, OF_ONE_BODY, OF_EACH_BODY };

static const char *const tile_names[] = {"boxes", "meshes", "height fields", "prisms", "mixed"};
static const char *const slider_names[] = {"box", "sphere", "capsule", "prism", "two boxes"};

typedef struct member {
  uint64_t seed;
  int tiles, slider, carried, rows;
  double turn[4]; /* of the whole scene */
  double length;  /* of a tile; 0: each another */
  double skew;    /* of the seams across */
  double along;   /* y of the seam between two rows */
  double v, mu, drop, yaw, dt;
  double from;   /* x of the slider's foremost point */
  double higher; /* the tiles from x = 0.5 on */
  double carrier_speed;
} member;

/* ---- the scene turned as a whole */

static void multiply(const double *p, const double *q, double *r)
{
  r[0] = p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3];
  r[1] = p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2];
  r[2] = p[0] * q[2] - p[1] * q[3] + p[2] * q[0] + p[3] * q[1];
  r[3] = p[0] * q[3] + p[1] * q[2] - p[2] * q[1] + p[3] * q[0];
}

/* y := the vector x turned by p. */
static void turn(const double *p, const double *x, double *y)
{
  const double of[4] = {0, x[0], x[1], x[2]}, back[4] = {p[0], -p[1], -p[2], -p[3]};
  double half[4], all[4];
  multiply(p, of, half);
  multiply(half, back, all);
  memcpy(y, all + 1, 3 * sizeof *y);
}

static double along(const double *p, int axis, const double *x)
{
  double e[3] = {axis == 0, axis == 1, axis == 2}, y[3];
  turn(p, e, y);
  return x[0] * y[0] + x[1] * y[1] + x[2] * y[2];
}

/* ---- tiles */

/* A tile from x = a to b at y = low, skewed up to y = high, with its upper side at z. */
static void add_tile(nsdae_bodies *world, const member *m, int body, int kind, const double x[2],
                     const double y[2], double z, const double *origin)
{
  double middle[3] = {(x[0] + x[1]) / 2, (y[0] + y[1]) / 2, z - thick / 2}, heights[9] = {0};
  double point[24];
  const int triangle[6] = {0, 1, 2, 0, 2, 3};
  nsdae_solid s = {.material = 1, .length = {x[1] - x[0], y[1] - y[0], thick}};
  for (int i = 0; i < 8; i++) { /* anticlockwise, first the upper ones */
    int right = i % 4 == 1 || i % 4 == 2, far = i % 4 > 1;
    point[3 * i] = x[right] + m->skew * y[far];
    point[3 * i + 1] = y[far];
    point[3 * i + 2] = z - (i > 3) * thick;
    for (int j = 0; j < 3; j++) point[3 * i + j] -= origin[j];
  }
  s.shape = kind == BOXES    ? NSDAE_SHAPE_BOX
            : kind == MESHES ? NSDAE_SHAPE_MESH
            : kind == FIELDS ? NSDAE_SHAPE_HEIGHT_FIELD
                             : NSDAE_SHAPE_POLYHEDRON;
  if (kind == BOXES || kind == FIELDS) {
    if (kind == FIELDS) middle[2] = z;
    for (int j = 0; j < 3; j++) middle[j] -= origin[j];
    s.grid[0] = s.grid[1] = 3;
    s.point = heights;
    memcpy(s.position, middle, sizeof middle);
  } else {
    s.points = kind == MESHES ? 4 : 8;
    s.point = point;
    s.triangles = 2;
    s.triangle = triangle;
  }
  if (body == NSDAE_GROUND) {
    turn(m->turn, s.position, s.position);
    memcpy(s.quaternion, m->turn, sizeof s.quaternion);
  }
  nsdae_bodies_add_solid(world, body, &s);
}

static int add_carrier(nsdae_bodies *world, const member *m, const double *middle, double length,
                       double mass)
{
  const double w = 2, h = thick, v[3] = {m->carrier_speed, 0, 0};
  nsdae_rigid_body b = {.mass = mass,
                        .inertia = {mass * (w * w + h * h) / 12,
                                    mass * (length * length + h * h) / 12,
                                    mass * (w * w + length * length) / 12}};
  turn(m->turn, middle, b.position);
  turn(m->turn, v, b.velocity);
  memcpy(b.quaternion, m->turn, sizeof b.quaternion);
  return nsdae_bodies_add(world, &b);
}

/* Rows of tiles from x = -0.5 on. */
static void add_tiles(nsdae_bodies *world, const member *m)
{
  const double end = 2.6, one[3] = {(end - 0.5) / 2, 0, -thick / 2};
  uint64_t state = m->seed ^ 0x5eed;
  int body = m->carried == OF_ONE_BODY ? add_carrier(world, m, one, end + 0.5, 60) : NSDAE_GROUND;
  for (int row = 0; row < m->rows; row++) {
    double y[2] = {row ? m->along : -1, row || m->rows == 1 ? 1 : m->along};
    double x[2] = {-0.5, -0.5}, origin[3] = {0, 0, 0};
    if (m->rows > 1 && row && m->length == 0) x[0] = x[1] -= random_between(&state, 0, 0.2);
    while (x[0] < end) {
      x[1] = x[0] + (m->length > 0 ? m->length : random_between(&state, 0.15, 0.6));
      if (m->higher > 0 && x[0] < 0.5 && x[1] > 0.4) x[1] = 0.5;
      if (m->carried == OF_ONE_BODY && x[1] > end) x[1] = end;
      double z = m->higher > 0 && x[0] >= 0.5 ? m->higher : 0;
      int kind = m->tiles == MIXED ? random_below(&state, MIXED) : m->tiles;
      if (m->carried == OF_ONE_BODY) memcpy(origin, one, sizeof origin);
      if (m->carried == OF_EACH_BODY) {
        const double middle[3] = {(x[0] + x[1]) / 2, (y[0] + y[1]) / 2, -thick / 2};
        memcpy(origin, middle, sizeof origin);
        body = add_carrier(world, m, middle, x[1] - x[0], 20);
      }
      add_tile(world, m, body, kind, x, y, z, origin);
      x[0] = x[1];
    }
  }
  if (m->carried == OF_GROUND) return;
  const double floor[3] = {0, 0, -thick};
  nsdae_solid plane = {.shape = NSDAE_SHAPE_PLANE, .material = 2};
  turn(m->turn, floor, plane.position);
  memcpy(plane.quaternion, m->turn, sizeof plane.quaternion);
  nsdae_bodies_add_solid(world, NSDAE_GROUND, &plane);
  nsdae_bodies_set_pair(world, 1, 2, 0, 0, 0);
}

/* ---- the slider */

static const double low[] = {0.05, 0.1, 0.08, 0.05, 0.05}; /* of its centre when it lies */

/* Returns its body; *front: how far it is ahead of its centre. */
static int add_slider(nsdae_bodies *world, const member *m, double *front)
{
  double c = cos(m->yaw), s = sin(m->yaw), own[4] = {cos(m->yaw / 2), 0, 0, sin(m->yaw / 2)};
  double prism[36];
  nsdae_solid part[2] = {{.shape = NSDAE_SHAPE_BOX, .length = {0.2, 0.2, 0.1}}};
  int parts = 1;
  nsdae_rigid_body b = {.mass = 1, .inertia = {0.005, 0.005, 0.005}};
  *front = 0.1 * (fabs(c) + fabs(s));
  if (m->slider == SPHERE) {
    part[0] = (nsdae_solid){.shape = NSDAE_SHAPE_SPHERE, .radius = 0.1};
    for (int j = 0; j < 3; j++) b.inertia[j] = 0.004;
    *front = 0.1;
  }
  if (m->slider == CAPSULE) {
    part[0] = (nsdae_solid){.shape = NSDAE_SHAPE_CAPSULE,
                            .radius = 0.08,
                            .length = {0, 0, 0.2},
                            .quaternion = {sqrt(0.5), 0, sqrt(0.5), 0}};
    *front = 0.08 + 0.1 * fabs(c);
  }
  if (m->slider == PRISM) {
    *front = 0;
    for (int i = 0; i < 12; i++) {
      double angle = (i % 6) * 1.0471975511965976, r = 0.12;
      prism[3 * i] = r * cos(angle);
      prism[3 * i + 1] = r * sin(angle);
      prism[3 * i + 2] = i < 6 ? -0.05 : 0.05;
      *front = fmax(*front, r * cos(angle + m->yaw));
    }
    part[0] = (nsdae_solid){.shape = NSDAE_SHAPE_POLYHEDRON, .points = 12, .point = prism};
  }
  if (m->slider == TWO_BOXES) {
    parts = 2;
    part[1] = part[0];
    for (int i = 0; i < 2; i++) {
      part[i].length[0] = 0.1;
      part[i].position[0] = i ? 0.05 : -0.05;
    }
  }
  const double x[3] = {m->from - *front, 0, low[m->slider] + m->drop}, v[3] = {m->v, 0, 0};
  turn(m->turn, x, b.position);
  turn(m->turn, v, b.velocity);
  multiply(m->turn, own, b.quaternion);
  int body = nsdae_bodies_add(world, &b);
  for (int i = 0; i < parts; i++) nsdae_bodies_add_solid(world, body, &part[i]);
  return body;
}

/* ---- runs */

typedef struct outcome {
  int status;
  double error; /* of velocities, in parts of v */
  double climb; /* from where it lies, at the end */
  double ahead; /* x of its foremost point, the largest */
  char text[300];
} outcome;

static outcome run(const member *m, int method, double duration)
{
  nsdae_bodies *world;
  nsdae_system *system;
  nsdae_sim_options o;
  nsdae_record r;
  outcome is = {.ahead = -INFINITY};
  double front, down[3] = {0, 0, -gravity}, g[3];
  assert_int_equal(nsdae_bodies_create(3, &world, NULL), NSDAE_OK);
  turn(m->turn, down, g);
  nsdae_bodies_set_gravity(world, g);
  nsdae_bodies_set_pair(world, 0, 1, m->mu, 0, 0);
  int body = add_slider(world, m, &front);
  add_tiles(world, m);
  nsdae_sim_options_default(&o);
  o.method = method;
  o.dt = m->dt;
  o.contact_tol = 1e-10; /* of islands with more than 11 contacts, too */
  nsdae_sim *sim = start(world, &o, &system);
  for (int i = 0, steps = (int)(duration / m->dt); i < steps && is.status >= 0; i++) {
    is.status = nsdae_sim_step(sim);
    nsdae_sim_get_record(sim, &r);
    is.ahead = fmax(is.ahead, along(m->turn, 0, r.q + 7 * body) + front);
  }
  if (is.status < 0) snprintf(is.text, sizeof is.text, "%s", nsdae_sim_error(sim)->text);
  const double *v = r.v + 6 * body, t = r.time, M = 60;
  double right = m->v - (m->mu > 0 ? m->mu * gravity * t : 0);
  is.error = fmax(fabs(along(m->turn, 0, v) - right), fabs(along(m->turn, 1, v))) / m->v;
  is.climb = along(m->turn, 2, r.q + 7 * body) - low[m->slider];
  if (m->carried == OF_ONE_BODY) {
    double carrier = m->carrier_speed + m->mu * gravity * t / M;
    is.error = fmax(is.error, fabs(along(m->turn, 0, r.v + 6) - carrier) / m->v);
  }
  end(world, system, sim);
  return is;
}

/* ---- the family */

static double one_of(uint64_t *state, const double *values, int count)
{
  return values[random_below(state, count)];
}

/* Half of all lengths are such that edges and ends of steps are on seams. */
static member member_of(uint64_t seed)
{
  static const double lengths[] = {0.25, 0.5, 0}, speeds[] = {0.5, 1, 2};
  static const double seams[] = {0, 0.1, -0.1, 0.05}, drops[] = {0, 0, 1e-3, 1e-9};
  uint64_t s = seed;
  member m = {.seed = seed, .turn = {1, 0, 0, 0}};
  m.tiles = random_below(&s, TILES);
  m.slider = random_below(&s, SLIDERS);
  m.carried = random_below(&s, 4) ? OF_GROUND : 1 + random_below(&s, 2);
  m.rows = 1 + random_below(&s, 2);
  m.length = one_of(&s, lengths, 3);
  m.along = one_of(&s, seams, 4);
  m.v = random_below(&s, 2) ? one_of(&s, speeds, 3) : random_between(&s, 0.4, 3);
  m.drop = one_of(&s, drops, 4);
  m.yaw = random_below(&s, 2) ? 0 : random_between(&s, -1.6, 1.6);
  m.from = random_below(&s, 2) ? 0.25 : random_between(&s, 0.1, 0.4);
  m.dt = m.v < 1 ? 2e-3 : 1e-3;
  if ((m.tiles == MESHES || m.tiles == PRISMS) && random_below(&s, 2))
    m.skew = random_between(&s, -1, 1);
  if (m.carried != OF_GROUND) { /* what moves is convex */
    m.tiles = random_below(&s, 2) || m.skew != 0 ? PRISMS : BOXES;
    m.rows = 1;
    m.length = 0.5;
    m.carrier_speed = random_between(&s, -0.5, 0.5);
    if (m.carried == OF_EACH_BODY) m.skew = m.carrier_speed = 0;
  }
  if (random_below(&s, 3) ==
      0) { /* sliding up to the end: v(t) >= 0.3 v; a ball slides to 5 v / 7 */
    m.mu = random_between(&s, 0.02, m.slider == SPHERE ? 0.25 : 0.7) * m.v * m.v / (gravity * way);
    m.drop = 0;
    if (m.slider == CAPSULE) m.yaw = 0;
    if (m.carried == OF_EACH_BODY) m.mu = 0;
  }
  double square = 0;
  for (int i = 0; i < 4 && random_below(&s, 3) == 0; i++) {
    for (int j = 0; j < 4; j++) m.turn[j] = random_between(&s, -1, 1);
    i = 4;
  }
  for (int j = 0; j < 4; j++) square += m.turn[j] * m.turn[j];
  for (int j = 0; j < 4; j++) m.turn[j] /= sqrt(square);
  return m;
}

/* Bounds of the error. By event all is known to rounding, with friction to a tenth of rtol. By the
 * others residuals of the contact problem are 1e-10 of a step's impulse. What moves tilts within
 * the slop: a carrier under what slides on it, up to 4e-5 rad, g 4e-5 for a second; a slider by its
 * friction 1e-4 rad, whose part of mu g t is as much of v. */
static double bound_of(const member *m, int method)
{
  if (method == NSDAE_METHOD_EVENT) return m->mu > 0 ? 1e-9 : 1e-12;
  return m->carried != OF_GROUND ? 4e-4 / m->v : m->mu > 0 ? 1e-5 : 1e-6;
}

static int is_right(const member *m, int method, const outcome *is)
{
  double climb = method == NSDAE_METHOD_EVENT ? 1e-7 : 1e-6; /* drift; residuals */
  return is->status >= 0 && is->error <= bound_of(m, method) && is->climb <= climb &&
         is->climb >= -3e-4;
}

static int check_slide(uint64_t seed, int method)
{
  const member m = member_of(seed);
  const outcome is = run(&m, method, way / m.v);
  if (is_right(&m, method, &is)) return 1;
  print_message(
      "seed %llu, %s: %s on %s (carried %d, rows %d, length %g, skew %g, yaw %g, drop %g, "
      "mu %g, v %g, turned %d): error %.2e, climb %.2e, status %d %s\n",
      (unsigned long long)seed, nsdae_method_name(method), slider_names[m.slider],
      tile_names[m.tiles], m.carried, m.rows, m.length, m.skew, m.yaw, m.drop, m.mu, m.v,
      m.turn[0] != 1, is.error, is.climb, is.status, is.text);
  return 0;
}

/* A step of 2 to 60 mm: nothing that is as slow gets over it, though a ball lies over its edge and
 * what turns there has another foremost point. It would be at 0.8 m. */
static int check_step(uint64_t seed, int method)
{
  uint64_t s = seed ^ 0x57e9;
  member m = member_of(seed);
  m.carried = OF_GROUND;
  if (method == NSDAE_METHOD_EVENT) m.tiles = m.tiles % 2 ? PRISMS : BOXES; /* a mesh has no side */
  m.higher = 2e-3 * pow(30, random_uniform(&s));
  m.skew = m.mu = m.drop = m.carrier_speed = 0;
  m.v = 0.1;
  m.dt = 4e-3;
  m.from = random_between(&s, 0.42, 0.48);
  const outcome is = run(&m, method, 4);
  if (is.status >= 0 && is.ahead <= 0.62 && is.ahead >= 0.499) return 1;
  print_message(
      "step: seed %llu, %s: %s on %s (rows %d, yaw %g, height %g): up to %.6f, status %d %s\n",
      (unsigned long long)seed, nsdae_method_name(method), slider_names[m.slider],
      tile_names[m.tiles], m.rows, m.yaw, m.higher, is.ahead, is.status, is.text);
  return 0;
}

static const int methods[] = {NSDAE_METHOD_IMPLICIT, NSDAE_METHOD_MOREAU, NSDAE_METHOD_EVENT};

static int count_of(int quick)
{
  return getenv("NSDAE_LONG") ? 400 : quick;
}

static void check_all(int (*check)(uint64_t seed, int method), uint64_t seed, int method, int count)
{
  int wrong = 0;
  for (int i = 0; i < count; i++) wrong += !check(seed + (uint64_t)i, method);
  if (wrong) fail_msg("%d of %d are wrong by %s", wrong, count, nsdae_method_name(method));
}

static void test_seams_by_implicit(void **state)
{
  (void)state;
  check_all(check_slide, 1000, NSDAE_METHOD_IMPLICIT, count_of(12));
}

static void test_seams_by_moreau(void **state)
{
  (void)state;
  check_all(check_slide, 2000, NSDAE_METHOD_MOREAU, count_of(12));
}

static void test_seams_by_event(void **state)
{
  (void)state;
  check_all(check_slide, 3000, NSDAE_METHOD_EVENT, count_of(1));
}

static void test_steps_stop(void **state)
{
  (void)state;
  check_all(check_step, 4000, NSDAE_METHOD_IMPLICIT, count_of(2));
  check_all(check_step, 5000, NSDAE_METHOD_MOREAU, count_of(2));
  check_all(check_step, 6000, NSDAE_METHOD_EVENT, count_of(1));
}

int main(int argc, char **argv)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_seams_by_implicit),
      cmocka_unit_test(test_seams_by_moreau),
      cmocka_unit_test(test_seams_by_event),
      cmocka_unit_test(test_steps_stop),
  };
  if (argc < 3) return cmocka_run_group_tests(tests, NULL, NULL);
  uint64_t seed = strtoull(argv[1], NULL, 10);
  int count = atoi(argv[2]), wrong = 0;
  for (int k = 0; k < (int)(sizeof methods / sizeof *methods); k++)
    for (int step = 0; step < 2; step++) {
      int bad = 0;
      if (argc > 3 && strcmp(argv[3], nsdae_method_name(methods[k])) != 0) continue;
      for (int i = 0; i < count; i++)
        bad += !(step ? check_step : check_slide)(seed + (uint64_t)i, methods[k]);
      printf("%s, %s: %d of %d wrong\n", nsdae_method_name(methods[k]), step ? "steps" : "seams",
             bad, count);
      wrong += bad;
    }
  return wrong > 0;
}
