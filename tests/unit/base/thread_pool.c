/* Threads that share the passes of a loop: every pass once, the least that fails is told. */
#include "check.h"

#include <stdatomic.h>
#include <stdint.h>

#include "thread_pool.h"
#include "support/random.h"

enum { MOST = 3000 };

typedef struct job {
  atomic_int times[MOST];
  double result[MOST]; /* each pass its own */
  int bad[MOST];
  int workers;
} job;

static int pass(void *shared, int worker, int i)
{
  job *j = shared;
  double sum = 0;
  assert_in_range(worker, 0, j->workers - 1);
  atomic_fetch_add(&j->times[i], 1);
  for (int k = 1; k < 20 + i % 50; k++) sum += 1.0 / k / (i + 1);
  j->result[i] = sum;
  return j->bad[i] ? -1 : 0;
}

static void clear(job *j, int workers)
{
  for (int i = 0; i < MOST; i++) {
    atomic_store(&j->times[i], 0);
    j->result[i] = -1;
    j->bad[i] = 0;
  }
  j->workers = workers;
}

static void test_every_pass_once(void **state)
{
  static job alone, shared;
  const int sizes[] = {1, 2, 3, 7}, portions[] = {1, 5, 64};
  (void)state;
  clear(&alone, 1);
  for (int i = 0; i < MOST; i++) pass(&alone, 0, i);
  for (int s = 0; s < 4; s++) {
    nsdae_thread_pool *crew = nsdae_thread_pool_make(sizes[s]);
    assert_non_null(crew);
    for (int round = 0; round < 60; round++) { /* the same crew, loops of many lengths */
      int count = round * 50;
      clear(&shared, sizes[s]);
      assert_int_equal(
          nsdae_thread_pool_run(crew, round % 7 == 3, count, portions[round % 3], pass, &shared),
          -1);
      for (int i = 0; i < MOST; i++) {
        assert_int_equal(atomic_load(&shared.times[i]), i < count);
        if (i < count) assert_memory_equal(&shared.result[i], &alone.result[i], sizeof(double));
      }
    }
    nsdae_thread_pool_release(crew);
  }
  nsdae_thread_pool_release(NULL);
}

static void test_least_failure(void **state)
{
  static job j;
  uint64_t seed = 1;
  (void)state;
  for (int size = 1; size <= 5; size += 2) {
    nsdae_thread_pool *crew = nsdae_thread_pool_make(size);
    assert_non_null(crew);
    for (int round = 0; round < 100; round++) {
      int least = MOST;
      clear(&j, size);
      for (int k = 0; k < 4; k++) {
        int at = random_below(&seed, MOST);
        j.bad[at] = 1;
        if (at < least) least = at;
      }
      assert_int_equal(nsdae_thread_pool_run(crew, 0, MOST, 1 + round % 9, pass, &j), least);
      for (int i = 0; i <= least; i++) assert_int_equal(atomic_load(&j.times[i]), 1);
    }
    nsdae_thread_pool_release(crew);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_every_pass_once),
      cmocka_unit_test(test_least_failure),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
