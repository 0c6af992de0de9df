/* One block of memory per handle. */
#include "check.h"

#include <limits.h>
#include <nsdae/status.h>

#include "arena.h"

enum { ARRAYS = 6 };

typedef struct holder {
  const long *count; /* of each array */
  double *real[ARRAYS];
  int *whole;
  char *odd;
  int passes;
  size_t used[2]; /* after each pass */
} holder;

static void layout(void *object, nsdae_arena *arena)
{
  holder *h = object;
  for (int i = 0; i < ARRAYS; i++) h->real[i] = NSDAE_ARENA_DOUBLES(arena, h->count[i]);
  h->whole = NSDAE_ARENA_INTS(arena, 3);
  h->odd = nsdae_arena_take(arena, 7, 13);
  if (h->passes < 2) h->used[h->passes] = arena->used;
  h->passes++;
}

static const long counts[ARRAYS] = {1, 0, 7, 8, 9, 1000};

static void test_aligned_and_zeroed(void **state)
{
  (void)state;
  nsdae_arena arena;
  holder h = {.count = counts};
  assert_int_equal(nsdae_arena_build(&arena, layout, &h), NSDAE_OK);
  for (int i = 0; i < ARRAYS; i++) {
    assert_int_equal((uintptr_t)h.real[i] % 64, 0);
    for (long j = 0; j < counts[i]; j++) assert_true(h.real[i][j] == 0);
  }
  assert_int_equal((uintptr_t)h.whole % 64, 0);
  assert_int_equal((uintptr_t)h.odd % 64, 0);
  for (int j = 0; j < 7 * 13; j++) assert_int_equal(h.odd[j], 0);
  nsdae_arena_release(&arena);
}

static void test_measured_is_used(void **state)
{
  (void)state;
  nsdae_arena arena;
  holder h = {.count = counts};
  assert_int_equal(nsdae_arena_build(&arena, layout, &h), NSDAE_OK);
  assert_int_equal(h.passes, 2);
  assert_int_equal(h.used[0], h.used[1]);
  assert_int_equal(h.used[0], arena.used);
  nsdae_arena_release(&arena);
}

/* Writing each array to its last byte leaves the others alone (the sanitizer sees the end). */
static void test_apart(void **state)
{
  (void)state;
  nsdae_arena arena;
  holder h = {.count = counts};
  assert_int_equal(nsdae_arena_build(&arena, layout, &h), NSDAE_OK);
  for (int i = 0; i < ARRAYS; i++)
    for (long j = 0; j < counts[i]; j++) h.real[i][j] = i + 1;
  memset(h.whole, 0xff, 3 * sizeof *h.whole);
  memset(h.odd, 0x7f, 7 * 13);
  for (int i = 0; i < ARRAYS; i++)
    for (long j = 0; j < counts[i]; j++) assert_true(h.real[i][j] == i + 1);
  nsdae_arena_release(&arena);
}

static void test_overflow(void **state)
{
  (void)state;
  const long bad[] = {-1, LONG_MIN, LONG_MAX, LONG_MAX / 8, LONG_MAX / 16};
  for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
    nsdae_arena arena;
    long count[ARRAYS] = {1, 2, bad[i], bad[i], 0, 0};
    holder h = {.count = count};
    assert_int_equal(nsdae_arena_build(&arena, layout, &h), NSDAE_E_MEMORY);
    assert_null(arena.base);
    nsdae_arena_release(&arena); /* of nothing */
  }
}

static void test_empty(void **state)
{
  (void)state;
  nsdae_arena arena;
  const long none[ARRAYS] = {0};
  holder h = {.count = none};
  assert_int_equal(nsdae_arena_build(&arena, layout, &h), NSDAE_OK);
  assert_non_null(arena.base);
  nsdae_arena_release(&arena);
  assert_null(arena.base);
  nsdae_arena_release(&arena); /* twice is harmless */
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_aligned_and_zeroed),
      cmocka_unit_test(test_measured_is_used),
      cmocka_unit_test(test_apart),
      cmocka_unit_test(test_overflow),
      cmocka_unit_test(test_empty),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
