/* Long runs of every example by every time-stepping method end well: motions decay to rest and far
 * below, or never end; whatever they do, each step has a status that is none of a failure, its
 * contact problem is solved, and the state is finite.
 *
 * As it is: 20 000 steps, of models of hundreds of contacts 20, and 2000 of the same with few
 * bodies. NSDAE_LONG says how many instead, of those with few bodies (NSDAE_ONLY names one example,
 * NSDAE_METHOD one method; 1e8 steps take minutes to hours). A motion that has come to a rest of
 * which every further step would give the same bytes is not followed further. What can go wrong
 * late alone is tried from the start on: times so large that dt is a few units of their last digit,
 * and velocities where doubles lose digits. */
#include "check.h"

#include <stdlib.h>

#include "arch.h"
#include "bouncing_ball.h"
#include "clearance_hinge.h"
#include "column.h"
#include "crank_slider.h"
#include "dominoes.h"
#include "falling_rod.h"
#include "heap.h"
#include "incline.h"
#include "newtons_cradle.h"
#include "pendulum.h"
#include "rolling_ball.h"
#include "settings.h"
#include "shaken_ball.h"
#include "wall.h"
#include "woodpecker.h"
#include "support/random.h"

enum { NQ = 20000 };

/* LARGE: of hundreds of contacts, a step takes milliseconds; DRIVEN: by the time */
enum { LARGE = 1, DRIVEN = 2 };
enum { ENERGY = 1 }; /* of nsdae_stats.warnings: NSDAE_WARN_ENERGY was said */
static const struct {
  const driver_model *model;
  int kind;
  const char *few[2][2]; /* parameters of a LARGE one of few bodies */
} all[] = {{&bouncing_ball_model, 0, {{0}}},
           {&clearance_hinge_model, 0, {{0}}},
           {&crank_slider_model, DRIVEN, {{0}}},
           {&falling_rod_model, 0, {{0}}},
           {&incline_model, 0, {{0}}},
           {&newtons_cradle_model, 0, {{0}}},
           {&pendulum_model, 0, {{0}}},
           {&rolling_ball_model, 0, {{0}}},
           {&shaken_ball_model, DRIVEN, {{0}}},
           {&woodpecker_model, 0, {{0}}},
           {&arch_model, LARGE, {{"blocks", "7"}}},
           {&column_model, LARGE, {{"balls", "5"}}},
           {&dominoes_model, LARGE, {{"n", "6"}}},
           {&heap_model, LARGE, {{"spheres", "8"}}},
           {&wall_model, LARGE, {{"courses", "3"}, {"length", "3"}}}};

static const int method[] = {NSDAE_METHOD_IMPLICIT, NSDAE_METHOD_IMPLICIT_PRINTED,
                             NSDAE_METHOD_MOREAU};

/* Sets the i-th example's parameters, of a LARGE one of few bodies or as they are. */
static void make_ready(size_t i, int few)
{
  const driver_model *model = all[i].model;
  nsdae_params_default(model->parameters, model->base);
  for (int k = 0; k < 2 && few && all[i].few[k][0]; k++)
    assert_int_equal(
        nsdae_params_set(model->parameters, model->base, all[i].few[k][0], all[i].few[k][1], NULL),
        NSDAE_OK);
}

static int chosen(const char *variable, const char *name)
{
  const char *only = getenv(variable);
  return !only || strcmp(only, name) == 0;
}

/* The state as bytes, and in it what steps go on from: all behind the time, which q follows (what
 * stands before are counts and sums; behind it the method's memory, the lists of contacts). */
typedef struct image {
  unsigned char *block, *before;
  size_t size, rest;
} image;

static void take(nsdae_sim *sim, image *m)
{
  nsdae_record r;
  unsigned char key[2 * sizeof(double)];
  size_t size;
  assert_int_equal(nsdae_sim_get_record(sim, &r), NSDAE_OK);
  assert_int_equal(nsdae_sim_state_size(sim, &size), NSDAE_OK);
  if (size > m->size) {
    m->block = realloc(m->block, size);
    m->before = realloc(m->before, size);
    assert_true(m->block && m->before);
  }
  m->size = size;
  assert_int_equal(nsdae_sim_get_state(sim, m->block, size), NSDAE_OK);
  memcpy(key, &r.time, sizeof r.time);
  memcpy(key + sizeof r.time, r.q, sizeof *r.q);
  for (m->rest = 0; memcmp(m->block + m->rest, key, sizeof key) != 0; m->rest++)
    assert_true(m->rest + sizeof key < size);
  m->rest += sizeof r.time;
}

/* Whether a step changes nothing that the next one depends on; it is taken. */
static int stands_still(nsdae_sim *sim, image *m, int *status)
{
  take(sim, m);
  size_t size = m->size, rest = m->rest;
  unsigned char *last = m->before;
  m->before = m->block;
  m->block = last;
  *status = nsdae_sim_step(sim);
  if (*status < 0) return 0;
  take(sim, m);
  return m->size == size && m->rest == rest &&
         memcmp(m->block + rest, m->before + rest, size - rest) == 0;
}

/* Times are rounded, the lengths of steps are not: whether q and v stand still at those to come,
 * too, for a thousand steps from every power of two on. */
static int stays(const nsdae_sim *sim, long steps)
{
  enum { LOOKED = 1000 };
  nsdae_sim_options options;
  nsdae_sim *later;
  nsdae_record from, to;
  int still = 1;
  nsdae_sim_get_options(sim, &options);
  nsdae_sim_get_record(sim, &from);
  options.start_tol = 1, options.start_check = 0;
  assert_int_equal(nsdae_sim_create(nsdae_sim_get_system(sim), &options, &later, NULL), NSDAE_OK);
  nsdae_dims d;
  nsdae_sim_get_dims(sim, &d);
  for (double t = exp2(ceil(log2(from.time))); t < options.dt * (double)steps && still; t *= 2) {
    assert_int_equal(nsdae_sim_init(later, t, from.q, from.v), NSDAE_OK);
    for (int i = 0; i < LOOKED && still; i++) {
      still = nsdae_sim_step(later) >= 0;
      nsdae_sim_get_record(later, &to);
      still = still && memcmp(to.q, from.q, (size_t)d.nq * sizeof *to.q) == 0 &&
              memcmp(to.v, from.v, (size_t)d.nv * sizeof *to.v) == 0;
    }
  }
  nsdae_sim_destroy(&later);
  return still;
}

/* Steps until so many are done or every further one would be the same; returns how many. */
static long walk(nsdae_sim *sim, int autonomous, long steps, int *status)
{
  image m = {0};
  long i = 0, look = 1000;
  int still = 0;
  while (i < steps && *status >= 0 && !still) {
    if (autonomous && i == look) {
      still = stands_still(sim, &m, status) && stays(sim, steps);
      look += look / 8;
    } else {
      *status = nsdae_sim_step(sim);
    }
    i++;
  }
  free(m.block);
  free(m.before);
  return i;
}

/* What no step may do, however many there are. Without a drive nothing gives energy: T + U stays
 * below its start, up to what each method makes of an impact by taking it up to a step late
 * (moreau: m g h v, of both signs; implicit-printed, of first order, more: Newton's cradle, whose
 * balls never come to rest, gains half a joule in 1e6 steps, and goes on, and is warned of it).
 * Rounding: of the work that is done.
 * What overlaps was found so, in one step; it is no deeper than in a short run, of metres nowhere.
 */
static void expect_bounded(const nsdae_sim *sim, int kind)
{
  nsdae_sim_options options;
  nsdae_record r;
  nsdae_stats stats;
  nsdae_sim_get_options(sim, &options);
  nsdae_sim_get_record(sim, &r);
  nsdae_sim_get_stats(sim, &stats);
  double gained = r.kinetic + r.potential - stats.energy_start;
  double late = options.method == NSDAE_METHOD_IMPLICIT_PRINTED ? 0.5 : 1e-6;
  if (options.method == NSDAE_METHOD_IMPLICIT_PRINTED && (stats.warnings & ENERGY))
    late += 1e-7 * (double)stats.steps; /* twice what it was in 5e6 steps */
  if (!(kind & DRIVEN)) assert_at_most(gained, late + 1e-9 * fabs(stats.energy_start));
  assert_at_most(stats.worst_penetration, 0.02); /* of a rod's end at 3 m/s in 5 ms */
}

static void expect_well(const nsdae_sim *sim, long steps)
{
  nsdae_record r;
  nsdae_dims d;
  nsdae_stats stats;
  assert_int_equal(nsdae_sim_get_record(sim, &r), NSDAE_OK);
  assert_int_equal(nsdae_sim_get_dims(sim, &d), NSDAE_OK);
  assert_int_equal(nsdae_sim_get_stats(sim, &stats), NSDAE_OK);
  assert_int_equal(r.step, steps);
  for (int i = 0; i < d.nq; i++) assert_true(isfinite(r.q[i]));
  for (int i = 0; i < d.nv; i++) assert_true(isfinite(r.v[i]));
  assert_true(isfinite(r.kinetic) && isfinite(r.potential) && isfinite(r.dissipated));
  assert_at_most(stats.worst_residual, stats.contact_tol);
  assert_at_most(r.constraint_drift, 0.02); /* pendulum by moreau: h^2 of its first swings */
}

static void tell(const driver_model *model, const nsdae_sim *sim, long done, long steps)
{
  nsdae_sim_options options;
  nsdae_stats stats;
  nsdae_record r;
  nsdae_sim_get_options(sim, &options);
  nsdae_sim_get_stats(sim, &stats);
  nsdae_sim_get_record(sim, &r);
  print_message("%s by %s: %ld steps", model->name, nsdae_method_name(options.method), steps);
  if (done < steps) print_message(", from %ld on each the one before", done);
  print_message("; T %.3g J, gained %.3g J, balance %.3g J, drift %.3g, overlap %.3g (worst %.3g), "
                "warnings %d, "
                "%.3g s\n",
                r.kinetic, r.kinetic + r.potential - stats.energy_start, stats.energy_balance,
                r.constraint_drift, r.penetration, stats.worst_penetration, stats.warnings,
                stats.wall_time);
}

static void run(const driver_model *model, int method_number, double dt, long steps, int kind)
{
  static double q0[NQ], v0[NQ];
  nsdae_sim_options options;
  nsdae_system *system;
  nsdae_sim *sim;
  nsdae_sim_options_default(&options);
  settings_choose_method(&(settings){.model = model}, method_number, &options);
  if (dt > 0) options.dt = dt;
  assert_int_equal(model->build(model->base, &system, NULL), NSDAE_OK);
  memset(q0, 0, sizeof q0);
  memset(v0, 0, sizeof v0);
  model->start(model->base, q0, v0);
  assert_int_equal(nsdae_sim_create(system, &options, &sim, NULL), NSDAE_OK);
  int status = nsdae_sim_init(sim, 0, q0, v0);
  long done = walk(sim, !(kind & DRIVEN), steps, &status);
  if (status < 0)
    fail_msg("%s by %s: %s", model->name, nsdae_method_name(method_number),
             nsdae_sim_error(sim)->text);
  expect_well(sim, done);
  expect_bounded(sim, kind);
  if (getenv("NSDAE_LONG")) tell(model, sim, done, steps);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
}

static void test_examples(void **state)
{
  const char *many = getenv("NSDAE_LONG");
  (void)state;
  for (size_t i = 0; i < sizeof all / sizeof *all; i++)
    for (size_t k = 0; k < sizeof method / sizeof *method; k++) {
      const driver_model *model = all[i].model;
      int large = all[i].kind & LARGE;
      if (!chosen("NSDAE_ONLY", model->name) ||
          !chosen("NSDAE_METHOD", nsdae_method_name(method[k])))
        continue;
      make_ready(i, 1);
      run(model, method[k], model->dt,
          many    ? (long)strtod(many, NULL)
          : large ? share_of(2000)
                  : share_of(20000),
          all[i].kind);
      if (!large || many) continue;
      make_ready(i, 0);
      run(model, method[k], model->dt, 20, all[i].kind);
    }
}

/* A simulation of the model made ready at t0, started with velocities of this size at random in
 * place of its own where size > 0; the last status of so many steps. */
static int start_and_step(const driver_model *model, int method_number, double t0, double size,
                          int steps, nsdae_sim **sim, nsdae_system **system)
{
  static double q0[NQ], v0[NQ];
  uint64_t seed = 7;
  nsdae_sim_options options;
  nsdae_dims d;
  nsdae_sim_options_default(&options);
  settings_choose_method(&(settings){.model = model}, method_number, &options);
  if (model->dt > 0) options.dt = model->dt;
  options.start_tol = 1; /* what is driven is elsewhere at t0 */
  options.start_check = 0;
  assert_int_equal(model->build(model->base, system, NULL), NSDAE_OK);
  memset(q0, 0, sizeof q0);
  memset(v0, 0, sizeof v0);
  model->start(model->base, q0, v0);
  assert_int_equal(nsdae_sim_create(*system, &options, sim, NULL), NSDAE_OK);
  nsdae_sim_get_dims(*sim, &d);
  for (int i = 0; i < d.nv && size > 0; i++) {
    v0[i] = size * (random_uniform(&seed) - 0.5);
  }
  int status = nsdae_sim_init(*sim, t0 * options.dt, q0, v0);
  for (int i = 0; i < steps && status >= 0; i++) status = nsdae_sim_step(*sim);
  return status;
}

/* What stands in q and v, compared bit by bit. */
static void expect_same_motion(nsdae_sim *sim, nsdae_sim *early)
{
  nsdae_record r, e;
  nsdae_dims d;
  assert_int_equal(nsdae_sim_get_record(sim, &r), NSDAE_OK);
  assert_int_equal(nsdae_sim_get_record(early, &e), NSDAE_OK);
  assert_int_equal(nsdae_sim_get_dims(sim, &d), NSDAE_OK);
  assert_memory_equal(r.q, e.q, (size_t)d.nq * sizeof *r.q);
  assert_memory_equal(r.v, e.v, (size_t)d.nv * sizeof *r.v);
}

/* After 1e8 steps a time has eight digits of dt, after 2^50 two bits; a step is as long as ever,
 * and what does not ask for the time moves as from zero on, to the last bit. After 2^55 steps a
 * time has no bit of dt: said so. */
static void late(size_t i, int method_number)
{
  const double begin[] = {0, 1e8, exp2(40), exp2(50), exp2(55)};
  nsdae_system *system[5];
  nsdae_sim *sim[5];
  int steps = (all[i].kind & LARGE ? 200 : 1000) / (test_share() > 1 ? 2 : 1);
  for (int j = 0; j < 5; j++) {
    make_ready(i, 1);
    int status =
        start_and_step(all[i].model, method_number, begin[j], 0, steps, &sim[j], &system[j]);
    if (j == 4) {
      assert_int_equal(status, NSDAE_E_ARGUMENT);
      assert_non_null(strstr(nsdae_sim_error(sim[j])->text, "lost in rounding"));
      break;
    }
    if (status < 0)
      fail_msg("%s by %s from step %g on: %s", all[i].model->name, nsdae_method_name(method_number),
               begin[j], nsdae_sim_error(sim[j])->text);
    expect_well(sim[j], steps);
    if (all[i].kind & DRIVEN) continue;
    expect_bounded(sim[j], all[i].kind);
    expect_same_motion(sim[j], sim[0]);
  }
  for (int j = 0; j < 5; j++) {
    nsdae_sim_destroy(&sim[j]);
    nsdae_system_destroy(&system[j]);
  }
}

static void test_late(void **state)
{
  (void)state;
  for (size_t i = 0; i < sizeof all / sizeof *all; i++)
    for (size_t k = 0; k < sizeof method / sizeof *method; k++)
      if (chosen("NSDAE_ONLY", all[i].model->name)) late(i, method[k]);
}

/* Velocities from where the squares vanish to where there is one bit left. */
static void test_slow(void **state)
{
  const double size[] = {1e-150, 1e-200, 1e-290, 1e-308, 1e-313, 1e-322};
  (void)state;
  for (size_t i = 0; i < sizeof all / sizeof *all; i++)
    for (size_t k = 0; k < sizeof method / sizeof *method; k++)
      for (size_t j = 0; j < sizeof size / sizeof *size; j++) {
        if (test_share() > 1 && (i + k + j) % 3 > 0) continue; /* each has two of the sizes */
        const driver_model *model = all[i].model;
        nsdae_system *system;
        nsdae_sim *sim;
        int steps = all[i].kind & LARGE ? 100 : 1000;
        if (!chosen("NSDAE_ONLY", model->name)) continue;
        make_ready(i, 1);
        int status = start_and_step(model, method[k], 0, size[j], steps, &sim, &system);
        if (status < 0)
          fail_msg("%s by %s from velocities of %g on: %s", model->name,
                   nsdae_method_name(method[k]), size[j], nsdae_sim_error(sim)->text);
        expect_well(sim, steps);
        if (!(all[i].kind & DRIVEN)) expect_bounded(sim, all[i].kind);
        nsdae_sim_destroy(&sim);
        nsdae_system_destroy(&system);
      }
}

/* An explicit step makes the quaternion of a ball that spins longer, by 1 + (h w / 4)^2: at 50 000
 * a second with h = 5 ms it would be beyond all numbers in 80 steps. */
static void test_quaternions(void **state)
{
  (void)state;
  for (size_t k = 0; k < sizeof method / sizeof *method; k++) {
    nsdae_params_default(rolling_ball_model.parameters, rolling_ball_model.base);
    rolling_ball *p = rolling_ball_model.base;
    p->mu = 0, p->vx = 1, p->wx = p->wy = 50000;
    if (method[k] == NSDAE_METHOD_MOREAU) run(&rolling_ball_model, method[k], 5e-3, 20000, 0);
    p->wx = p->wy = 100; /* what the iterated steps converge for */
    run(&rolling_ball_model, method[k], 5e-3, 20000, 0);
  }
}

/* Body i turns about its axis i alone, as fast as ever, with a quaternion that can be used. */
static void expect_spins(const nsdae_record *r, int i)
{
  const double *p = r->q + 7 * i + 3;
  double length = sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2] + p[3] * p[3]);
  assert_true(length > 0.5);
  assert_at_most(length, 2.1);
  for (int j = 0; j < 3; j++)
    if (j != i) assert_near(p[1 + j], 0, 0);
  assert_near(r->v[6 * i + 3 + i], 100, 1e-8);
}

/* The same of bodies whose contacts come by list. Each turns about an axis of its own inertia, so
 * that w is constant, and beside it falls nothing: no gravity. */
static void test_quaternions_listed(void **state)
{
  enum { BODIES = 3, STEPS = 20000 };
  const nsdae_solid ball = {.shape = NSDAE_SHAPE_SPHERE, .radius = 0.1};
  nsdae_system *system;
  double q0[7 * BODIES], v0[6 * BODIES];
  (void)state;
  for (size_t k = 0; k < sizeof method / sizeof *method; k++) {
    nsdae_bodies *world;
    nsdae_sim_options options;
    nsdae_sim *sim;
    nsdae_record r;
    assert_int_equal(nsdae_bodies_create(3, &world, NULL), NSDAE_OK);
    for (int i = 0; i < BODIES; i++) {
      nsdae_rigid_body body = {.mass = 1, .inertia = {1, 2, 3}, .position = {i}};
      body.spin[i] = 100;
      assert_int_equal(nsdae_bodies_add(world, &body), i);
      assert_true(nsdae_bodies_add_solid(world, i, &ball) >= 0);
    }
    nsdae_bodies_set_pair(world, 0, 0, 0.5, 0, 0);
    assert_true(nsdae_bodies_system(world, &system) >= 0);
    assert_int_equal(nsdae_bodies_get_start(world, q0, v0), NSDAE_OK);
    nsdae_sim_options_default(&options);
    options.method = method[k];
    options.dt = 5e-3;
    assert_int_equal(nsdae_sim_create(system, &options, &sim, NULL), NSDAE_OK);
    assert_int_equal(nsdae_sim_init(sim, 0, q0, v0), NSDAE_OK);
    for (int n = 0; n < STEPS; n++) assert_true(nsdae_sim_step(sim) >= 0);
    nsdae_sim_get_record(sim, &r);
    for (int i = 0; i < BODIES; i++) expect_spins(&r, i);
    nsdae_sim_destroy(&sim);
    nsdae_system_destroy(&system);
    nsdae_bodies_destroy(&world);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_examples), cmocka_unit_test(test_late), cmocka_unit_test(test_slow),
      cmocka_unit_test(test_quaternions), cmocka_unit_test(test_quaternions_listed)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
