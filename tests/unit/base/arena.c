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

/* Longer and shorter arrays begin with what they had; what comes after the call is zeros. */
typedef struct sized {
  long count, other;
  double *kept[3], *scratch;
  int *whole;
} sized;

static void layout_sized(void *object, nsdae_arena *arena)
{
  sized *s = object;
  for (int i = 0; i < 3; i++) s->kept[i] = NSDAE_ARENA_DOUBLES(arena, (i + 1) * s->count);
  s->whole = NSDAE_ARENA_INTS(arena, s->count);
  nsdae_arena_zeros(arena);
  s->scratch = NSDAE_ARENA_DOUBLES(arena, s->count);
}

static void change_sized(void *object, int back)
{
  sized *s = object;
  (void)back;
  long count = s->count;
  s->count = s->other;
  s->other = count;
}

static void fill_sized(sized *s)
{
  for (int i = 0; i < 3; i++)
    for (long j = 0; j < (i + 1) * s->count; j++) s->kept[i][j] = (double)(i + 10 * j + 1);
  for (long j = 0; j < s->count; j++) s->scratch[j] = s->whole[j] = (int)j + 1;
}

static void check_sized(const sized *s, long had, int scratch)
{
  for (int i = 0; i < 3; i++)
    for (long j = 0; j < (i + 1) * s->count; j++)
      assert_true(s->kept[i][j] == (j < (i + 1) * had ? (double)(i + 10 * j + 1) : 0));
  for (long j = 0; j < s->count; j++) assert_int_equal(s->whole[j], j < had ? (int)j + 1 : 0);
  for (long j = 0; j < s->count; j++) assert_true(s->scratch[j] == (scratch ? (double)j + 1 : 0));
}

static void test_resized(void **state)
{
  static const long to[] = {5, 6, 0, 100, 3};
  (void)state;
  for (int i = 0; i < 5; i++) {
    sized s = {.count = 5, .other = to[i]};
    nsdae_arena arena, old;
    assert_int_equal(nsdae_arena_build(&arena, layout_sized, &s), NSDAE_OK);
    fill_sized(&s);
    assert_int_equal(nsdae_arena_resize(&arena, layout_sized, change_sized, &s, &old), NSDAE_OK);
    assert_int_equal(s.count, to[i]);
    check_sized(&s, 5, 0);
    nsdae_arena_restore(&arena, layout_sized, change_sized, &s, &old);
    assert_int_equal(s.count, 5);
    check_sized(&s, 5, 1);
    s.other = -1; /* has no length */
    assert_int_equal(nsdae_arena_resize(&arena, layout_sized, change_sized, &s, &old),
                     NSDAE_E_MEMORY);
    assert_null(old.base);
    assert_int_equal(s.count, 5);
    check_sized(&s, 5, 1);
    nsdae_arena_release(&arena);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_aligned_and_zeroed),
      cmocka_unit_test(test_measured_is_used),
      cmocka_unit_test(test_apart),
      cmocka_unit_test(test_resized),
      cmocka_unit_test(test_overflow),
      cmocka_unit_test(test_empty),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
