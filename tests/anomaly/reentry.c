/* Calls on a simulation that is in a call: from each of its callbacks, from the function that is
 * asked for an interrupt, from an observer, and from other threads. They are NSDAE_E_STATE, and the
 * run has the same bits as without them. Simulations of one system are created and destroyed in
 * several threads at once: a sanitizer of threads looks for races (cmake --preset threads). */
#include "check.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>

#include <nsdae/nsdae.h>

#include "support/random.h"

enum { STEPS = 60 };

/* Each public function that uses a simulation, on the one under attack. */
typedef struct target {
  nsdae_system *system;
  nsdae_sim *sim;
  char *block;
  size_t size;
  int call;  /* which of calls[]; -1: none */
  long made; /* calls so far */
  int seen;  /* records, by an observer */
} target;

static int ignore(const nsdae_record *record, nsdae_error *error, void *user)
{
  (void)record, (void)error, (void)user;
  return 0;
}

static int never(void *user)
{
  (void)user;
  return 0;
}

static const double q_start = 1, v_start = 0;

#define CALL(name, body)                        \
  static int call_##name(target *at)            \
  {                                             \
    nsdae_sim *sim = at->sim;                   \
    double q = q_start, v = v_start;            \
    nsdae_sim_options options;                  \
    nsdae_record record;                        \
    nsdae_stats stats;                          \
    nsdae_step_friction friction;               \
    nsdae_lcp_problem lcp;                      \
    size_t size;                                \
    (void)sim, (void)q, (void)v, (void)options; \
    (void)record, (void)stats;                  \
    (void)friction, (void)lcp;                  \
    (void)size;                                 \
    nsdae_sim_options_default(&options);        \
    return body;                                \
  }

CALL(step, nsdae_sim_step(sim))
CALL(run, nsdae_sim_run(sim, 5))
CALL(run_to_event, nsdae_sim_run_to_event(sim, 5))
CALL(init, nsdae_sim_init(sim, 0, &q, &v))
CALL(project, nsdae_sim_project(sim, 0, &q, &v))
CALL(set_state, nsdae_sim_set_state(sim, at->block, at->size))
CALL(set_options, nsdae_sim_set_options(sim, &options))
CALL(set_contact, nsdae_sim_set_contact(sim, 0, 0, 0.1, 0))
CALL(set_frictional_joint, nsdae_sim_set_frictional_joint(sim, 0, 0.1))
CALL(set_control, nsdae_sim_set_control(sim, 0, 0.1))
CALL(set_user, nsdae_sim_set_user(sim, &options))
CALL(destroy, (nsdae_sim_destroy(&at->sim), at->sim ? NSDAE_E_STATE : NSDAE_OK))
CALL(interpolate, nsdae_sim_interpolate(sim, 0, &q, &v))
CALL(get_sensor, nsdae_sim_get_sensor(sim, 0, &q))
CALL(get_contact_forces, nsdae_sim_get_contact_forces(sim, &q, &v))
CALL(get_state, nsdae_sim_get_state(sim, at->block, at->size))
CALL(get_friction, nsdae_sim_get_friction(sim, &friction))
CALL(observe, nsdae_sim_observe(sim, ignore, NULL))
CALL(unobserve, nsdae_sim_unobserve(sim, ignore, NULL))
CALL(set_interrupt, nsdae_sim_set_interrupt(sim, never, NULL))
CALL(state_size, nsdae_sim_state_size(sim, &size))
CALL(get_record, nsdae_sim_get_record(sim, &record))
CALL(get_stats, nsdae_sim_get_stats(sim, &stats))
CALL(get_options, nsdae_sim_get_options(sim, &options))
CALL(get_failed_lcp, nsdae_sim_get_failed_lcp(sim, &lcp))

typedef struct call {
  const char *name;
  int (*make)(target *);
  int moves; /* refused to observers, too */
} call;

#define MOVE(name)                     \
  {                                    \
    "nsdae_sim_" #name, call_##name, 1 \
  }
#define LOOK(name)                     \
  {                                    \
    "nsdae_sim_" #name, call_##name, 0 \
  }
static const call calls[] = {MOVE(step),          MOVE(run),           MOVE(run_to_event),
                             MOVE(init),          MOVE(project),       MOVE(set_state),
                             MOVE(set_options),   MOVE(set_contact),   MOVE(set_frictional_joint),
                             MOVE(set_control),   MOVE(set_user),      MOVE(destroy),
                             LOOK(interpolate),   LOOK(get_sensor),    LOOK(get_contact_forces),
                             LOOK(get_state),     LOOK(observe),       LOOK(get_friction),
                             LOOK(unobserve),     LOOK(state_size),    LOOK(get_record),
                             LOOK(get_stats),     LOOK(set_interrupt), LOOK(get_options),
                             LOOK(get_failed_lcp)};
enum { CALLS = sizeof calls / sizeof *calls };

static target the_target = {.call = -1};

/* Refused, with a record of its own that names the function. */
static void *refused_call(void *user)
{
  target *at = user;
  assert_int_equal(calls[at->call].make(at), NSDAE_E_STATE);
  assert_int_equal(nsdae_sim_error(at->sim)->status, NSDAE_E_STATE);
  assert_string_equal(nsdae_sim_error(at->sim)->where, calls[at->call].name);
  return NULL;
}

/* The first call and every 61st are in a thread of their own, the others in that of the callback.
 */
static void attack(void)
{
  target *at = &the_target;
  pthread_t other;
  if (at->call < 0) return;
  if (at->made++ % 61 != 0) {
    refused_call(at);
    return;
  }
  assert_int_equal(pthread_create(&other, NULL, refused_call, at), 0);
  pthread_join(other, NULL);
}

static int mass(double t, const double *q, double *M, int ldm, void *user)
{
  (void)t, (void)q, (void)ldm, (void)user;
  attack();
  M[0] = 1;
  return 0;
}

static int force(double t, const double *q, const double *v, double *F, void *user)
{
  (void)t, (void)q, (void)v, (void)user;
  attack();
  F[0] = -9.81;
  return 0;
}

static int gap(double t, const double *q, double *g, void *user)
{
  (void)t, (void)user;
  attack();
  g[0] = q[0];
  return 0;
}

static int gap_normal(double t, const double *q, double *W, int ldw, void *user)
{
  (void)t, (void)q, (void)ldw, (void)user;
  attack();
  W[0] = 1;
  return 0;
}

static int asked(void *user)
{
  (void)user;
  attack();
  return 0;
}

/* A ball over a floor; 0: the method is not built in. */
static int make(target *at, int method)
{
  const nsdae_dims dims = {.nq = 1, .k = 1};
  nsdae_sim_options options;
  *at = (target){.call = -1};
  assert_int_equal(nsdae_system_create(&dims, &at->system, NULL), NSDAE_OK);
  nsdae_system_set_mass(at->system, mass);
  nsdae_system_set_force(at->system, force);
  nsdae_system_set_gap(at->system, gap);
  nsdae_system_set_gap_normal(at->system, gap_normal);
  nsdae_system_set_contact(at->system, 0, 0, 0.5, 0);
  nsdae_sim_options_default(&options);
  options.method = method;
  options.dt = 0.01;
  int status = nsdae_sim_create(at->system, &options, &at->sim, NULL);
  if (status == NSDAE_E_UNSUPPORTED) return nsdae_system_destroy(&at->system), 0;
  assert_int_equal(status, NSDAE_OK);
  assert_int_equal(nsdae_sim_state_size(at->sim, &at->size), NSDAE_OK);
  assert_non_null(at->block = malloc(at->size));
  return 1;
}

static void drop(target *at)
{
  at->call = -1;
  nsdae_sim_destroy(&at->sim);
  assert_null(at->sim);
  nsdae_system_destroy(&at->system);
  free(at->block);
}

/* Starts and steps, attacked by a call or not: the state that is left. */
static void run(target *at, int attacked, char *state)
{
  at->call = attacked;
  assert_int_equal(nsdae_sim_init(at->sim, 0, &q_start, &v_start), NSDAE_OK);
  assert_int_equal(nsdae_sim_get_state(at->sim, at->block, at->size), NSDAE_OK);
  assert_int_equal(nsdae_sim_set_interrupt(at->sim, asked, NULL), NSDAE_OK);
  for (int i = 0; i < STEPS; i++) {
    int status = nsdae_sim_step(at->sim);
    assert_true(status >= 0);
    assert_int_equal(nsdae_sim_error(at->sim)->status, status < NSDAE_WARN_ENERGY ? 0 : status);
    if (attacked >= 0) {
      double q, v;
      assert_int_equal(nsdae_sim_interpolate(at->sim, 0.01 * i + 0.003, &q, &v), NSDAE_OK);
    }
  }
  assert_int_equal(nsdae_sim_get_state(at->sim, state, at->size), NSDAE_OK);
}

static void test_callbacks(void **state)
{
  (void)state;
  for (int method = 0; nsdae_method_name(method); method++) {
    target *at = &the_target;
    if (!make(at, method)) continue;
    char *alone = malloc(at->size), *attacked = malloc(at->size);
    run(at, -1, alone);
    for (int i = 0; i < CALLS; i += test_share()) {
      run(at, i, attacked);
      assert_true(at->made > STEPS);
      assert_memory_equal(alone, attacked, at->size);
      at->made = 0;
    }
    free(alone);
    free(attacked);
    drop(at);
  }
}

/* A call that works on the state works from an observer, too; but not from a callback under it. */
static int look(const nsdae_record *record, nsdae_error *error, void *user)
{
  target *at = user;
  int i = (int)(record->step % CALLS);
  nsdae_record mine;
  double q, v, t = record->time - 0.3 * record->duration;
  (void)error;
  at->call = -1;
  at->seen++;
  assert_int_equal(nsdae_sim_error(at->sim)->status, NSDAE_OK); /* not a callback's refusal */
  int status = calls[i].make(at);
  if (calls[i].moves) {
    assert_int_equal(status, NSDAE_E_STATE);
    assert_string_equal(nsdae_sim_error(at->sim)->where, calls[i].name);
  }
  at->call = i;
  if (record->step > 0) assert_int_equal(nsdae_sim_interpolate(at->sim, t, &q, &v), NSDAE_OK);
  at->call = -1;
  assert_int_equal(nsdae_sim_get_record(at->sim, &mine), NSDAE_OK);
  assert_true(mine.step == record->step && mine.q == record->q);
  at->call = i;
  return 0;
}

static void test_observer(void **state)
{
  (void)state;
  for (int method = 0; nsdae_method_name(method); method++) {
    target *at = &the_target;
    if (!make(at, method)) continue;
    assert_int_equal(nsdae_sim_observe(at->sim, look, at), NSDAE_OK);
    assert_int_equal(nsdae_sim_init(at->sim, 0, &q_start, &v_start), NSDAE_OK);
    assert_true(nsdae_sim_run(at->sim, 0.01 * STEPS) >= 0);
    assert_int_equal(at->seen, STEPS + 1);
    drop(at);
  }
}

/* Several threads on one simulation: each call is done or refused, and the steps that were done are
 * the run. Under a sanitizer of threads the same program looks for races. */
enum { THREADS = 4, TRIES = 2000, BLOCK_MOST = 4096 };

static target shared;
static atomic_long steps_done;
static atomic_long refused;

static void *hammer(void *seed)
{
  uint64_t state = *(uint64_t *)seed;
  for (int i = 0; i < TRIES / test_share(); i++) {
    uint64_t draw = random_next(&state);
    target own = shared;
    char block[BLOCK_MOST];
    own.block = block;
    const call *other = &calls[(draw >> 16) % CALLS];
    if ((draw >> 8) % 16 == 0) { /* what all of them share */
      assert_int_equal(nsdae_system_set_contact(shared.system, 0, 0, 0.1, 0), NSDAE_E_STATE);
      assert_string_equal(nsdae_system_error(shared.system)->where, "nsdae_system_set_contact");
    }
    int step = draw >> 63 || other->moves;
    int status = step ? nsdae_sim_step(shared.sim) : other->make(&own);
    if (!step) continue;
    assert_true(status >= 0 || status == NSDAE_E_STATE);
    atomic_fetch_add(status >= 0 ? &steps_done : &refused, 1);
    if (status < 0) assert_string_equal(nsdae_sim_error(shared.sim)->where, "nsdae_sim_step");
  }
  return NULL;
}

static void test_threads(void **state)
{
  (void)state;
  pthread_t thread[THREADS];
  uint64_t seed[THREADS];
  for (int method = 0; nsdae_method_name(method); method++) {
    if (!make(&shared, method)) continue;
    assert_true(shared.size <= BLOCK_MOST);
    assert_int_equal(nsdae_sim_init(shared.sim, 0, &q_start, &v_start), NSDAE_OK);
    atomic_store(&steps_done, 0);
    atomic_store(&refused, 0);
    for (unsigned i = 0; i < THREADS; i++) {
      seed[i] = 7 * (unsigned)method + i;
      assert_int_equal(pthread_create(&thread[i], NULL, hammer, &seed[i]), 0);
    }
    for (int i = 0; i < THREADS; i++) pthread_join(thread[i], NULL);
    nsdae_record r;
    assert_int_equal(nsdae_sim_get_record(shared.sim, &r), NSDAE_OK);
    print_message("%s: %ld steps, %ld calls refused\n", nsdae_method_name(method), r.step,
                  atomic_load(&refused));
    assert_int_equal(r.step, atomic_load(&steps_done));
    nsdae_sim *later;
    nsdae_error error;
    assert_int_equal(nsdae_sim_create(shared.system, NULL, &later, &error), NSDAE_E_STATE);
    assert_string_equal(error.where, "nsdae_system_set_contact");
    nsdae_system_clear_error(shared.system);
    assert_int_equal(nsdae_sim_create(shared.system, NULL, &later, &error), NSDAE_OK);
    nsdae_sim_destroy(&later);
    target alone;
    nsdae_record s;
    assert_true(make(&alone, method));
    assert_int_equal(nsdae_sim_init(alone.sim, 0, &q_start, &v_start), NSDAE_OK);
    for (long i = 0; i < r.step; i++) assert_true(nsdae_sim_step(alone.sim) >= 0);
    assert_int_equal(nsdae_sim_get_record(alone.sim, &s), NSDAE_OK);
    assert_memory_equal(r.q, s.q, sizeof *r.q);
    assert_memory_equal(r.v, s.v, sizeof *r.v);
    drop(&alone);
    drop(&shared);
  }
}

/* ---- simulations of one system, created and destroyed in several threads at once */

enum { LIVES = 8, FALL = 10 };

/* The method of the thread; each step of its simulations has the bits of the first. */
static void *live(void *user)
{
  const nsdae_system *system = user;
  nsdae_sim_options options;
  double first = NAN;
  nsdae_sim_options_default(&options);
  options.dt = 0.01;
  for (int life = 0; life < LIVES; life++) {
    nsdae_sim *sim;
    nsdae_error error;
    nsdae_record r;
    double q[7] = {0, 0, 0.15, 1}, v[6] = {0.1};
    options.method = life % 2 == 0 ? NSDAE_METHOD_IMPLICIT : NSDAE_METHOD_MOREAU;
    int status = nsdae_sim_create(system, &options, &sim, &error);
    if (status < 0) print_error("%s\n", error.text);
    assert_int_equal(status, NSDAE_OK);
    assert_true(nsdae_sim_init(sim, 0, q, v) >= 0);
    for (int i = 0; i < FALL; i++) assert_true(nsdae_sim_step(sim) >= 0);
    assert_int_equal(nsdae_sim_get_record(sim, &r), NSDAE_OK);
    if (life == 0) first = r.q[0];
    if (life % 2 == 0) assert_memory_equal(&first, &r.q[0], sizeof first);
    nsdae_sim_destroy(&sim);
  }
  return NULL;
}

/* A ball above a floor by the kit, whose handle is destroyed before. */
static void test_creation(void **state)
{
  (void)state;
  nsdae_bodies *b;
  nsdae_system *system;
  pthread_t thread[THREADS];
  const double gravity[3] = {0, 0, -9.81};
  assert_int_equal(nsdae_bodies_create(3, &b, NULL), NSDAE_OK);
  nsdae_bodies_set_gravity(b, gravity);
  nsdae_bodies_add(b, &(nsdae_rigid_body){.mass = 1, .inertia = {0.1, 0.1, 0.1}});
  nsdae_bodies_add_solid(b, NSDAE_GROUND, &(nsdae_solid){.shape = NSDAE_SHAPE_PLANE});
  nsdae_bodies_add_solid(b, 0, &(nsdae_solid){.shape = NSDAE_SHAPE_SPHERE, .radius = 0.1});
  nsdae_bodies_set_pair(b, 0, 0, 0.3, 0.5, 0);
  assert_true(nsdae_bodies_system(b, &system) >= 0);
  nsdae_bodies_destroy(&b);
  for (int i = 0; i < THREADS; i++)
    assert_int_equal(pthread_create(&thread[i], NULL, live, system), 0);
  for (int i = 0; i < THREADS; i++) pthread_join(thread[i], NULL);
  assert_int_equal(nsdae_system_simulations(system), 0);
  nsdae_system_destroy(&system);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_creation), cmocka_unit_test(test_callbacks),
      cmocka_unit_test(test_observer), cmocka_unit_test(test_threads)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
