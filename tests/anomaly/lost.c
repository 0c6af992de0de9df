/* Lost allocations, those inside libraries included: malloc and its family are replaced for the
 * process, and each call in turn fails, from the making of the system to the end of a run, for
 * every method and both linear solvers. NSDAE_E_MEMORY comes back, nothing is left behind, nothing
 * printed; and once a simulation has started, nobody allocates.
 *
 * The calls of SUNContext_Create are exempt: see process_allocator.h. */
#define _POSIX_C_SOURCE 200809L /* dup2, fileno */
#include "check.h"

#include <unistd.h>

#include "process_allocator.h"
#include "random_system.h"

#if !NSDAE_PROCESS_ALLOCATOR
int main(void)
{
  return 77; /* skipped: the sanitizer has malloc, or there is no other way to it */
}
#else

__attribute__((weak)) void *__real_IDACreate(void *context); /* none without SUNDIALS */
void *__wrap_IDACreate(void *context);

static int may_print; /* the call that failed may print */

void *__wrap_IDACreate(void *context)
{
  void *made = __real_IDACreate(context);
  may_print |= !made;
  return made;
}

enum { BALLS = 8 };

typedef struct life {
  int method, integrator;
  long made, ran;         /* allocations until the simulation started, and after */
  int spare, spared;      /* a run may end well without one of them; how many times it did */
  double end[13 * BALLS]; /* of the heap: q and v */
  int again;              /* its run was called twice */
} life;

/* Makes, runs and releases everything; the first status below zero. */
static int live(life *l, random_system *r)
{
  nsdae_sim_options options;
  nsdae_sim *sim = NULL;
  nsdae_sim_options_default(&options);
  options.method = l->method;
  options.integrator = l->integrator;
  random_system_rewind(r);
  nsdae_system *system = random_system_make(r);
  if (!system) return NSDAE_E_MEMORY;
  int status = nsdae_sim_create(system, &options, &sim, NULL);
  if (status == NSDAE_OK) status = nsdae_sim_init(sim, 0, r->q0, r->v0);
  l->made = the_process.calls;
  if (status == NSDAE_OK) status = nsdae_sim_run(sim, 0.3);
  l->ran = the_process.calls - l->made;
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  return status < 0 ? status : NSDAE_OK;
}

/* What was printed to stderr between the two. */
static int stderr_kept = -1;
static FILE *printed;

static void catch_stderr(void)
{
  fflush(stderr);
  printed = tmpfile();
  stderr_kept = dup(2);
  dup2(fileno(printed), 2);
}

static long release_stderr(void)
{
  fflush(stderr);
  long bytes = lseek(2, 0, SEEK_END);
  dup2(stderr_kept, 2);
  close(stderr_kept);
  fclose(printed);
  return bytes;
}

static void add_balls(nsdae_bodies *heap)
{
  const double J = 0.004;
  for (int i = 0; i < BALLS; i++) {
    nsdae_rigid_body ball = {.mass = 1,
                             .inertia = {J, J, J},
                             .position = {0.05 * (i % 3), 0.04 * (i % 2), 0.1 + 0.21 * (i / 2)}};
    ball.position[i % 2] += 0.15;
    nsdae_bodies_add(heap, &ball);
    nsdae_bodies_add_solid(heap, i, &(nsdae_solid){.shape = NSDAE_SHAPE_SPHERE, .radius = 0.1});
  }
}

/* Sensors of a contact force and of a place, read in the run. */
static int look(const nsdae_record *record, nsdae_error *error, void *user)
{
  double value[NSDAE_VALUES_MAX];
  (void)record, (void)error;
  for (int i = 0; i < 2; i++)
    if (nsdae_sim_get_sensor(user, i, value) < 0) return NSDAE_E_STATE;
  return 0;
}

/* The same of balls that fall into a heap: contacts by list, which grows in the run, islands on two
 * threads. */
static int live_in_heap(life *l, random_system *unused)
{
  nsdae_sim_options options;
  nsdae_sim *sim = NULL;
  nsdae_bodies *heap = NULL;
  nsdae_system *system = NULL;
  nsdae_record record;
  double q0[7 * BALLS], v0[6 * BALLS];
  (void)unused;
  l->again = 0;
  nsdae_sim_options_default(&options);
  options.method = l->method;
  options.threads = 2;
  int status = nsdae_bodies_create(3, &heap, NULL);
  nsdae_bodies_set_gravity(heap, (const double[]){0, 0, -9.81});
  nsdae_bodies_add_solid(heap, NSDAE_GROUND, &(nsdae_solid){.shape = NSDAE_SHAPE_PLANE});
  nsdae_bodies_set_pair(heap, 0, 0, 0.5, 0, 0);
  add_balls(heap);
  nsdae_bodies_add_sensor(heap,
                          &(nsdae_sensor){.name = "push", .kind = NSDAE_SENSOR_CONTACT_FORCE});
  nsdae_bodies_add_sensor(heap, &(nsdae_sensor){.kind = NSDAE_SENSOR_POSITION, .body = 1});
  if (status == NSDAE_OK) status = nsdae_bodies_system(heap, &system);
  if (status == NSDAE_OK) status = nsdae_sim_create(system, &options, &sim, NULL);
  l->made = the_process.calls;
  if (status == NSDAE_OK) status = nsdae_bodies_get_start(heap, q0, v0);
  if (status == NSDAE_OK) status = nsdae_sim_observe(sim, look, sim);
  if (status == NSDAE_OK) status = nsdae_sim_init(sim, 0, q0, v0);
  if (status == NSDAE_OK) {
    status = nsdae_sim_run(sim, 0.15);
    l->again = status < 0;
    if (status < 0 && nsdae_sim_run(sim, 0.15) < 0) status = NSDAE_E_STATE; /* it is to go on */
    nsdae_sim_get_record(sim, &record);
    memcpy(l->end, record.q, sizeof q0);
    memcpy(l->end + 7 * BALLS, record.v, sizeof v0);
  }
  l->ran = the_process.calls - l->made;
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  nsdae_bodies_destroy(&heap);
  return status < 0 ? status : NSDAE_OK;
}

typedef int (*life_fn)(life *, random_system *);

/* A heap's end is that of the run that lost nothing: to the bit where the step that failed was done
 * again; within what the tolerance of friction makes of it in 30 steps where a stage was left out.
 */
static void expect_end(const life *l, const life *whole, long place)
{
  if (l->again) {
    assert_memory_equal(l->end, whole->end, sizeof l->end);
    return;
  }
  for (int i = 0; i < 13 * BALLS; i++)
    if (!(fabs(l->end[i] - whole->end[i]) <= 1e-6))
      fail_msg("heap by %s, place %ld: %.17g at %d, not %.17g", nsdae_method_name(l->method), place,
               l->end[i], i, whole->end[i]);
}

/* Returns how many places there are. */
static long every_place(life_fn of, life *l, random_system *r, uint64_t seed)
{
  long place = 0, failed = 1;
  const life whole = *l;
  while (failed) {
    catch_stderr();
    may_print = 0;
    process_allocator_reset(place);
    int status = of(l, r);
    long left = the_process.live;
    failed = the_process.failed;
    process_allocator_reset(-1);
    long bytes = release_stderr();
    int well = l->spare && failed && status == NSDAE_OK && place >= whole.made;
    l->spared += well;
    if ((!well && status != (failed ? NSDAE_E_MEMORY : NSDAE_OK)) || left != 0 ||
        (bytes != 0 && !may_print))
      fail_msg(
          "%s, integrator %d, seed %d, place %ld: status %d, %ld blocks left, %ld bytes on stderr",
          nsdae_method_name(l->method), l->integrator, (int)seed, place, status, left, bytes);
    if (status == NSDAE_OK || l->again) expect_end(l, &whole, place);
    place += failed * test_share();
  }
  return place;
}

/* A seed whose system has constraints, contacts with friction and a slide. */
static uint64_t seed_of(random_system *r, uint64_t from, int method)
{
  life l = {.method = method};
  for (;; from++) {
    random_system_draw(r, from, RANDOM_PLAIN);
    if (r->dims.m == 0 || r->dims.k == 0 || r->dims.nt == 0 || r->dims.f == 0) continue;
    int status = live(&l, r);
    if (status == NSDAE_E_UNSUPPORTED) untested("no SUNDIALS");
    if (status == NSDAE_OK) return from;
  }
}

static void test_every_place(void **state)
{
  (void)state;
  for (int method = 0; nsdae_method_name(method); method++)
    for (int last = method == NSDAE_METHOD_EVENT ? NSDAE_INTEGRATOR_IDA : NSDAE_INTEGRATOR_AUTO,
             integrator = NSDAE_INTEGRATOR_AUTO;
         integrator <= last; integrator++) {
      life l = {.method = method, .integrator = integrator};
      if (integrator == NSDAE_INTEGRATOR_IDA && strstr(nsdae_build_info(), "SUNDIALS none")) break;
      random_system r;
      uint64_t seed = seed_of(&r, 1, method);
      long places = every_place(live, &l, &r, seed);
      print_message("%s %d: %ld places, %ld in the run\n", nsdae_method_name(method), integrator,
                    places, l.ran);
      assert_true(places > 5);
      assert_int_equal(l.ran, 0);
    }
}

static void test_heap(void **state)
{
  const int methods[] = {NSDAE_METHOD_IMPLICIT, NSDAE_METHOD_MOREAU, NSDAE_METHOD_EVENT};
  (void)state;
  for (int i = 0; i < 3; i++) {
    /* friction is solved without a stage that there is no memory for, to the same tolerance */
    life l = {.method = methods[i], .spare = 1};
    /* glibc keeps the stack of a thread that ended, and a block for it, for the next one */
    assert_int_equal(live_in_heap(&l, NULL), NSDAE_OK);
    long places = every_place(live_in_heap, &l, NULL, 0);
    print_message("heap by %s: %ld places, %ld in the run, %d to spare\n",
                  nsdae_method_name(methods[i]), places, l.ran, l.spared);
    assert_true(places > 20);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_every_place),
                                     cmocka_unit_test(test_heap)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}

#endif
