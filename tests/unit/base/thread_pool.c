/* Threads that share the passes of a loop: every pass once, the least that fails is told. */
#include "check.h"

#include <math.h>
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

/* Each item once, by ranges; the largest value, and NaN. */
static void count_items(void *shared, int from, int to)
{
  job *j = shared;
  for (int i = from; i < to; i++) atomic_fetch_add(&j->times[i], 1);
}

static double largest(void *shared, int from, int to)
{
  const job *j = shared;
  double most = 0;
  for (int i = from; i < to && most == most; i++)
    if (!(j->result[i] <= most)) most = j->result[i];
  return most;
}

static void test_ranges(void **state)
{
  static job j;
  uint64_t seed = 3;
  (void)state;
  for (int size = 0; size <= 5; size++) { /* 0: no pool */
    nsdae_thread_pool *pool = size > 0 ? nsdae_thread_pool_make(size) : NULL;
    assert_int_equal(nsdae_thread_pool_size(pool), size > 0 ? size : 1);
    for (int count = 0; count <= MOST; count += 1 + count / 2) {
      double most = 0;
      clear(&j, size);
      nsdae_thread_pool_for(pool, count, 1 + count % 9, count_items, &j);
      for (int i = 0; i < MOST; i++) {
        assert_int_equal(atomic_load(&j.times[i]), i < count);
        j.result[i] = random_uniform(&seed) * (i + 1);
        if (i < count && j.result[i] > most) most = j.result[i];
      }
      assert_true(nsdae_thread_pool_most(pool, count, 1 + count % 9, largest, &j) == most);
      if (count == 0) continue;
      j.result[random_below(&seed, count)] = NAN;
      assert_true(isnan(nsdae_thread_pool_most(pool, count, 1 + count % 9, largest, &j)));
    }
    nsdae_thread_pool_release(pool);
  }
}

/* A loop within a pass is done by its thread. */
static int nested(void *shared, int worker, int i)
{
  nsdae_thread_pool **pool = shared;
  static job inner[8];
  (void)worker;
  clear(&inner[i], 1);
  int failed = nsdae_thread_pool_run(*pool, 0, 100, 1, pass, &inner[i]);
  return failed == -1 ? 0 : -1;
}

static void test_nested(void **state)
{
  nsdae_thread_pool *pool = nsdae_thread_pool_make(3);
  (void)state;
  for (int round = 0; round < 20; round++)
    assert_int_equal(nsdae_thread_pool_run(pool, 0, 8, 1, nested, &pool), -1);
  nsdae_thread_pool_release(pool);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_every_pass_once),
      cmocka_unit_test(test_least_failure),
      cmocka_unit_test(test_ranges),
      cmocka_unit_test(test_nested),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
