/* A run may start at any t0: random systems (random_system.h) that do not depend on t have the same
 * motion, bit by bit, from t0 = 0, 1e9 (a Unix time) and -1e9; times are t0 later. A restart there
 * ends in the same bytes. What cannot be resolved is refused at the start, with its reason: times
 * too near each other for dt, and for callbacks that depend on t and rtol; lengths below atol.
 * NSDAE_LATE is how many seeds are looked at (60), by every method. */
#include "check.h"

#include <stdlib.h>
#include <string.h>

#include "random_system.h"

static const double T = 0.5, DT = 0x1p-6;

enum { METHODS = NSDAE_METHOD_EVENT + 1, IMPACTS = 4096 };

typedef struct run {
  int status, impacts;
  long step;
  double time, impact[IMPACTS];
  double q[RANDOM_NQ], v[RANDOM_NQ], between[RANDOM_NQ];
  nsdae_error error;
} run;

static int note(const nsdae_record *record, nsdae_error *error, void *user)
{
  run *r = user;
  (void)error;
  for (int i = 0; i < record->impacts && r->impacts < IMPACTS; i++)
    r->impact[r->impacts++] = record->impact[i].time;
  return 0;
}

static nsdae_sim *make(const nsdae_system *system, int method)
{
  nsdae_sim *sim;
  nsdae_sim_options o;
  nsdae_sim_options_default(&o);
  o.method = method;
  o.dt = DT;
  o.rtol = 1e-7;
  o.start_check = 0; /* it looks at early starts only */
  assert_int_equal(nsdae_sim_create(system, &o, &sim, NULL), NSDAE_OK);
  return sim;
}

/* By a second simulation with another start, from the state on. */
static void restart(const nsdae_system *system, int method, const random_system *random,
                    nsdae_sim **sim)
{
  size_t size;
  nsdae_sim *other = make(system, method);
  assert_int_equal(nsdae_sim_init(other, 3, random->q0, random->v0), NSDAE_OK);
  assert_int_equal(nsdae_sim_state_size(*sim, &size), NSDAE_OK);
  void *block = malloc(size);
  assert_int_equal(nsdae_sim_get_state(*sim, block, size), NSDAE_OK);
  assert_int_equal(nsdae_sim_set_state(other, block, size), NSDAE_OK);
  free(block);
  nsdae_sim_destroy(sim);
  *sim = other;
}

static void read(nsdae_sim *sim, double t0, run *r)
{
  nsdae_record record;
  double v[RANDOM_NQ];
  nsdae_dims d;
  nsdae_sim_get_dims(sim, &d);
  r->error = *nsdae_sim_error(sim);
  if (nsdae_sim_get_record(sim, &record) < 0) return;
  r->step = record.step;
  r->time = record.time - t0;
  memcpy(r->q, record.q, (size_t)d.nq * sizeof *r->q);
  memcpy(r->v, record.v, (size_t)d.nv * sizeof *r->v);
  if (record.step > 0 && r->status >= 0)
    assert_true(nsdae_sim_interpolate(sim, record.time - DT / 2, r->between, v) >= 0);
}

static void go(random_system *random, int method, double t0, int restarts, run *r)
{
  nsdae_system *system = random_system_make(random);
  nsdae_sim *sim = make(system, method);
  memset(r, 0, sizeof *r);
  random_system_rewind(random);
  nsdae_sim_observe(sim, note, r);
  r->status = nsdae_sim_init(sim, t0, random->q0, random->v0);
  if (r->status >= 0) r->status = nsdae_sim_run(sim, t0 + T / 2);
  if (r->status >= 0 && restarts) {
    restart(system, method, random, &sim);
    nsdae_sim_observe(sim, note, r);
  }
  if (r->status >= 0) r->status = nsdae_sim_run(sim, t0 + T);
  read(sim, t0, r);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
}

/* Impacts are located: their times are rounded to the user's. */
static void assert_same(const run *a, const run *b, double t0)
{
  assert_int_equal(a->status, b->status);
  assert_int_equal(a->step, b->step);
  assert_true(a->time == b->time);
  assert_memory_equal(a->q, b->q, sizeof a->q);
  assert_memory_equal(a->v, b->v, sizeof a->v);
  assert_memory_equal(a->between, b->between, sizeof a->between);
  assert_int_equal(a->impacts, b->impacts);
  for (int i = 0; i < a->impacts; i++)
    assert_true(fabs(b->impact[i] - t0 - a->impact[i]) <= 2.3e-16 * fabs(t0));
}

/* With every derivative: the steps of differences grow with t. */
static void draw(random_system *random, int seed)
{
  random_system_draw(random, (uint64_t)seed, RANDOM_PLAIN);
  random->given = ~0u;
}

static int seeds_of(void)
{
  const char *asked = getenv("NSDAE_LATE");
  return asked ? atoi(asked) : 60;
}

static void test_any_start(void **state)
{
  static random_system random;
  static run zero, late;
  static const double starts[] = {1e9, -1e9};
  int seeds = seeds_of(), compared = 0;
  (void)state;
  for (int seed = 1; seed <= seeds; seed++) {
    draw(&random, seed);
    if (random.rheonomic) continue;
    int method = seed % METHODS;
    go(&random, method, 0, 0, &zero);
    for (int i = 0; i < 2; i++) {
      go(&random, method, starts[i], 0, &late);
      assert_same(&zero, &late, starts[i]);
      if (zero.status != NSDAE_OK) continue;
      go(&random, method, starts[i], 1, &late);
      assert_same(&zero, &late, starts[i]);
    }
    compared++;
  }
  print_message("%d systems, %d compared\n", seeds, compared);
  assert_true(compared >= seeds / 8);
}

/* Constraints and gaps that move: what has a tolerance sees that times are 1e-7 apart. */
static void test_moving(void **state)
{
  static random_system random;
  static run r;
  int seeds = seeds_of(), refused = 0;
  (void)state;
  for (int seed = 1; seed <= seeds; seed++) {
    draw(&random, seed);
    if (!random.rheonomic || random.dims.m + random.dims.k == 0) continue;
    for (int j = 0; j < random.dims.m; j++) random.phi[j].offset -= random.phi[j].rate * 1e9;
    for (int i = 0; i < random.dims.k; i++) random.gap[i].offset -= random.gap[i].rate * 1e9;
    int method = seed % METHODS;
    int tolerant = method == NSDAE_METHOD_EVENT || method == NSDAE_METHOD_PENALTY;
    go(&random, method, 1e9, 0, &r);
    if (r.status >= 0) assert_false(tolerant);
    if (!tolerant) continue;
    assert_int_equal(r.status, NSDAE_E_ARGUMENT);
    assert_string_equal(r.error.argument, "t0");
    assert_non_null(strstr(r.error.text, "callbacks depend on t"));
    refused++;
  }
  assert_true(refused >= seeds / 10);
}

static void test_short_steps(void **state)
{
  static random_system random;
  nsdae_sim_options o;
  (void)state;
  draw(&random, 1);
  nsdae_system *system = random_system_make(&random);
  nsdae_sim_options_default(&o);
  for (int k = -2; k <= 2; k++) { /* 2^-23 at 2^29, and next to it */
    nsdae_sim *sim;
    o.dt = 0x1p-23 * (1 + 1e-9 * k);
    assert_int_equal(nsdae_sim_create(system, &o, &sim, NULL), NSDAE_OK);
    int status = nsdae_sim_init(sim, 0x1p29, random.q0, random.v0);
    assert_int_equal(status, k < 0 ? NSDAE_E_ARGUMENT : NSDAE_OK);
    if (k < 0) assert_string_equal(nsdae_sim_error(sim)->argument, "dt");
    nsdae_sim_destroy(&sim);
  }
  nsdae_system_destroy(&system);
}

/* ---- a ball that is thrown at a floor, in other units: lengths L, times S */

typedef struct ball {
  double length, gravity;
} ball;

static int ball_mass(double t, const double *q, double *M, int ldm, void *user)
{
  const ball *b = user;
  (void)t;
  (void)q;
  M[0] = M[ldm + 1] = 1;
  M[2 * ldm + 2] = 0.004 * b->length * b->length;
  return 0;
}

static int ball_force(double t, const double *q, const double *v, double *F, void *user)
{
  (void)t;
  (void)q;
  (void)v;
  F[1] = -((const ball *)user)->gravity;
  return 0;
}

static int ball_gap(double t, const double *q, double *g, void *user)
{
  (void)t;
  g[0] = q[1] - 0.1 * ((const ball *)user)->length;
  return 0;
}

static int ball_normal(double t, const double *q, double *W, int ldw, void *user)
{
  (void)t;
  (void)q;
  (void)ldw;
  (void)user;
  W[1] = 1;
  return 0;
}

static int ball_tangent(double t, const double *q, double *W, int ldw, void *user)
{
  (void)t;
  (void)q;
  (void)ldw;
  W[0] = 1;
  W[2] = 0.1 * ((const ball *)user)->length;
  return 0;
}

/* out [3]: place and angle after two of its times S. NSDAE_OK, or what it was refused with. */
static int throw_ball(double L, double S, double spin, double atol, double *out, nsdae_error *error)
{
  const nsdae_dims dims = {.nq = 3, .k = 1, .nt = 1};
  ball b = {L, 9.81 * L / (S * S)};
  const double q[] = {0, 0.5 * L, 0}, v[] = {2 * L / S, -L / S, spin / S};
  nsdae_system *system;
  nsdae_sim *sim;
  nsdae_sim_options o;
  nsdae_record r;
  assert_int_equal(nsdae_system_create(&dims, &system, NULL), NSDAE_OK);
  nsdae_system_set_user(system, &b);
  nsdae_system_set_mass(system, ball_mass);
  nsdae_system_set_force(system, ball_force);
  nsdae_system_set_gap(system, ball_gap);
  nsdae_system_set_gap_normal(system, ball_normal);
  nsdae_system_set_gap_tangent(system, ball_tangent);
  nsdae_system_set_contact(system, 0, 0.3, 0.5, 0);
  nsdae_sim_options_default(&o);
  o.method = NSDAE_METHOD_EVENT;
  o.dt = 0x1p-7 * S;
  o.atol = atol;
  o.impact_velocity = 0;
  o.accumulation_time = 1e-5 * S;
  assert_int_equal(nsdae_sim_create(system, &o, &sim, NULL), NSDAE_OK);
  int status = nsdae_sim_init(sim, 0, q, v);
  if (status >= 0) status = nsdae_sim_run(sim, 2 * S);
  *error = *nsdae_sim_error(sim);
  if (status >= 0 && nsdae_sim_get_record(sim, &r) >= 0)
    for (int i = 0; i < 3; i++) out[i] = i < 2 ? r.q[i] / L : r.q[i];
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  return status;
}

/* The same motion in every unit, or a refusal that names a tolerance. */
static void test_units(void **state)
{
  uint64_t random = 20;
  int refused = 0, resolved = 0, ended = 0; /* by the energy check, on the way */
  (void)state;
  for (int i = 0; i < 200; i++) {
    double exponent = -14 * random_uniform(&random), L = pow(10, exponent);
    double S = pow(10, exponent * random_uniform(&random)),
           atol = pow(10, -8 - 14 * random_uniform(&random));
    double spin = random_below(&random, 2) * 50 * random_uniform(&random), reference[3] = {0},
           out[3] = {0};
    nsdae_error error;
    assert_true(throw_ball(1, 1, spin, 1e-10, reference, &error) >= 0);
    int status = throw_ball(L, S, spin, atol, out, &error);
    if (status < 0) {
      assert_true(status == NSDAE_E_ARGUMENT || status == NSDAE_E_CONVERGENCE);
      assert_string_equal(error.argument, status == NSDAE_E_ARGUMENT ? "atol" : "rtol");
      ended += status == NSDAE_E_CONVERGENCE;
      if (status == NSDAE_E_CONVERGENCE) assert_non_null(strstr(error.text, "kinetic energy"));
      refused++;
      continue;
    }
    resolved++;
    for (int j = 0; j < 3; j++) assert_near(out[j], reference[j], 1e-3);
  }
  print_message("%d resolved, %d refused, %d of them on the way\n", resolved, refused, ended);
  assert_true(resolved >= 40 && refused >= 40);
}

/* A body of the kit, as wide as 0.1, that slides along a wall with distance `gap` and starts
 * `beside` 0 in that direction, towards it; the wall is met, or not, as from 0. */
static void slide_beside(int d, double beside, double gap)
{
  const int normal = d - 1;
  nsdae_bodies *b;
  nsdae_system *system;
  nsdae_sim *sim;
  nsdae_sim_options o;
  nsdae_record r;
  double q[7], v[6];
  nsdae_rigid_body body = {.mass = 1, .inertia = {d == 3, d == 3, 1}, .velocity = {1.2}};
  nsdae_solid wall = {.shape = NSDAE_SHAPE_PLANE},
              disc = {.shape = d == 2 ? NSDAE_SHAPE_DISC : NSDAE_SHAPE_SPHERE, .radius = 0.05};
  wall.position[normal] = -0.05 - gap;
  body.position[normal] = beside;
  body.velocity[normal] = -beside;
  assert_int_equal(nsdae_bodies_create(d, &b, NULL), NSDAE_OK);
  nsdae_bodies_add(b, &body);
  int one = nsdae_bodies_add_solid(b, NSDAE_GROUND, &wall);
  assert_true(nsdae_bodies_add_contact(b, one, nsdae_bodies_add_solid(b, 0, &disc), 0, 1, 0) >= 0);
  assert_int_equal(nsdae_bodies_system(b, &system), NSDAE_OK);
  nsdae_bodies_get_start(b, q, v);
  nsdae_sim_options_default(&o);
  o.method = NSDAE_METHOD_EVENT;
  assert_int_equal(nsdae_sim_create(system, &o, &sim, NULL), NSDAE_OK);
  int status = nsdae_sim_init(sim, 0, q, v);
  if (status >= 0) status = nsdae_sim_run(sim, 0.5);
  if (status != NSDAE_OK)
    fail_msg("beside %g, gap %g: %s", beside, gap, nsdae_sim_error(sim)->text);
  nsdae_sim_get_record(sim, &r);
  assert_near(r.q[0], 0.6, 1e-9);
  assert_near(r.q[normal], beside, fabs(beside));
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  nsdae_bodies_destroy(&b);
}

/* Rounding of a place is no length: the gap and the width of the body are. */
static void test_beside_the_origin(void **state)
{
  uint64_t random = 7;
  (void)state;
  for (int i = 0; i < 100; i++) {
    double beside = pow(10, random_between(&random, -20, -9));
    slide_beside(2 + random_below(&random, 2), i % 2 ? beside : -beside,
                 i % 3 ? 0.75 * random_uniform(&random) : 2e-9);
  }
}

/* What starts at the origin shows no lengths: it is not refused, however fast it slides. Nor is
 * what starts there by the rounding of where it is along the wall. */
static void start_at_origin(const double *q, const double *v)
{
  const nsdae_dims dims = {.nq = 3, .k = 1, .nt = 1};
  ball b = {1, 9.81};
  nsdae_system *system;
  nsdae_sim *sim;
  nsdae_sim_options o;
  assert_int_equal(nsdae_system_create(&dims, &system, NULL), NSDAE_OK);
  nsdae_system_set_user(system, &b);
  nsdae_system_set_mass(system, ball_mass);
  nsdae_system_set_force(system, ball_force);
  nsdae_system_set_gap(system, ball_gap);
  nsdae_system_set_gap_normal(system, ball_normal);
  nsdae_system_set_gap_tangent(system, ball_tangent);
  nsdae_system_set_contact(system, 0, 0.3, 0.5, 0);
  nsdae_sim_options_default(&o);
  o.method = NSDAE_METHOD_EVENT;
  o.start_tol = 1; /* it overlaps */
  assert_int_equal(nsdae_sim_create(system, &o, &sim, NULL), NSDAE_OK);
  assert_int_equal(nsdae_sim_init(sim, 0, q, v), NSDAE_OK);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
}

static void test_origin(void **state)
{
  (void)state;
  start_at_origin((double[]){0, 0, 0}, (double[]){1e6, 0, 0});
  start_at_origin((double[]){3, 7e-17, 0}, (double[]){1e6, 0, 0});
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_any_start),         cmocka_unit_test(test_moving),
      cmocka_unit_test(test_short_steps),       cmocka_unit_test(test_units),
      cmocka_unit_test(test_beside_the_origin), cmocka_unit_test(test_origin)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
