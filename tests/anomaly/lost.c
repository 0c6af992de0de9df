/* Lost allocations, those inside libraries included: malloc and its family are replaced for the
 * process, and each call in turn fails, from the making of the system to the end of a run, for
 * every method and both linear solvers. NSDAE_E_MEMORY comes back, nothing is left behind, nothing
 * printed; and once a simulation is made, nobody allocates.
 *
 * One place cannot be helped from outside: SUNContext_Create of SUNDIALS 6.4.1 does not look
 * whether its logger's table was allocated (sundials_logger.c, SUNLogger_Create) and follows the
 * null pointer. Exactly that call is exempt. */
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

int __real_SUNContext_Create(void *comm, void *context);
int __wrap_SUNContext_Create(void *comm, void *context);

void *__real_CVodeCreate(int lmm, void *context);
void *__wrap_CVodeCreate(int lmm, void *context);

static int may_print; /* the call that failed may print */

int __wrap_SUNContext_Create(void *comm, void *context)
{
  the_process.exempt = 1;
  int status = __real_SUNContext_Create(comm, context);
  the_process.exempt = 0;
  return status;
}

void *__wrap_CVodeCreate(int lmm, void *context)
{
  void *made = __real_CVodeCreate(lmm, context);
  may_print |= !made;
  return made;
}

typedef struct life {
  int method, linear_solver;
  long made, ran; /* allocations until the simulation was made, and after */
} life;

/* Makes, runs and releases everything; the first status below zero. */
static int live(life *l, random_system *r)
{
  nsdae_sim_options options;
  nsdae_sim *sim = NULL;
  nsdae_sim_options_default(&options);
  options.method = l->method;
  options.linear_solver = l->linear_solver;
  random_system_rewind(r);
  nsdae_system *system = random_system_make(r);
  if (!system) return NSDAE_E_MEMORY;
  int status = nsdae_sim_create(system, &options, &sim, NULL);
  l->made = the_process.calls;
  if (status == NSDAE_OK) status = nsdae_sim_init(sim, 0, r->q0, r->v0);
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

/* Returns how many places there are. */
static long every_place(life *l, random_system *r, uint64_t seed)
{
  long place = 0, failed = 1;
  while (failed) {
    catch_stderr();
    may_print = 0;
    process_allocator_reset(place);
    int status = live(l, r);
    long left = the_process.live;
    failed = the_process.failed;
    process_allocator_reset(-1);
    long bytes = release_stderr();
    if (status != (failed ? NSDAE_E_MEMORY : NSDAE_OK) || left != 0 || (bytes != 0 && !may_print))
      fail_msg("%s, %s, seed %d, place %ld: status %d, %ld blocks left, %ld bytes on stderr",
               nsdae_method_name(l->method), l->linear_solver ? "sparse" : "dense", (int)seed,
               place, status, left, bytes);
    place += failed;
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
    if (status == NSDAE_E_UNSUPPORTED) skip();
    if (status == NSDAE_OK) return from;
  }
}

static void test_every_place(void **state)
{
  (void)state;
  for (int method = 0; nsdae_method_name(method); method++)
    for (int solver = 0; solver <= (method == NSDAE_METHOD_EVENT); solver++) {
      life l = {.method = method, .linear_solver = solver};
      random_system r;
      uint64_t seed = seed_of(&r, 1, method);
      long places = every_place(&l, &r, seed);
      print_message("%s %d: %ld places, %ld in the run\n", nsdae_method_name(method), solver,
                    places, l.ran);
      assert_true(places > 5);
      assert_int_equal(l.ran, 0);
    }
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_every_place)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}

#endif
