/* Writes that are held back, against an array of bytes: what lies over the file is what was written
 * last, and no byte is in two blocks. */
#include "check.h"

#include <stdlib.h>

#include "crash_safe_vfd.h"
#include "support/random.h"

enum { SIZE = 64, UNSET = 0xee };

typedef struct reference {
  unsigned char byte[SIZE], set[SIZE];
} reference;

static void write_both(nsdae_write_queue *p, reference *r, uint64_t at, size_t size,
                       unsigned char with)
{
  unsigned char bytes[SIZE];
  memset(bytes, with, size);
  assert_int_equal(nsdae_write_queue_add(p, at, size, 0, bytes), 0);
  memset(r->byte + at, with, size);
  memset(r->set + at, 1, size);
}

static void expect_same(const nsdae_write_queue *p, const reference *r)
{
  unsigned char buffer[SIZE], wanted[SIZE];
  int held[SIZE] = {0};
  for (size_t i = 0; i < p->count; i++) {
    assert_true(p->block[i].size > 0);
    for (size_t k = 0; k < p->block[i].size; k++) held[p->block[i].at + k]++;
  }
  for (size_t i = 0; i < SIZE; i++) assert_int_equal(held[i], r->set[i]);
  for (size_t at = 0; at < SIZE; at += 7)
    for (size_t size = 1; at + size <= SIZE; size += 5) {
      memset(buffer, UNSET, sizeof buffer);
      nsdae_write_queue_overlay(p, at, size, buffer);
      for (size_t i = 0; i < size; i++) wanted[i] = r->set[at + i] ? r->byte[at + i] : UNSET;
      assert_memory_equal(buffer, wanted, size);
    }
}

/* Before, behind, over and inside one that is there. */
static void test_each_way(void **state)
{
  (void)state;
  const struct {
    uint64_t at;
    size_t size;
  } second[] = {{0, 10}, {15, 10}, {20, 10}, {22, 4}, {25, 10}, {18, 14}, {35, 5}, {30, 3}};
  for (size_t i = 0; i < sizeof second / sizeof *second; i++) {
    nsdae_write_queue p = {0};
    reference r = {0};
    write_both(&p, &r, 20, 10, 1);
    write_both(&p, &r, second[i].at, second[i].size, 2);
    expect_same(&p, &r);
    nsdae_write_queue_release(&p);
  }
}

static void test_random(void **state)
{
  (void)state;
  uint64_t seed = 1;
  for (int round = 0; round < 200; round++) {
    nsdae_write_queue p = {0};
    reference r = {0};
    for (unsigned char with = 1; with < 20; with++) {
      uint64_t at = random_next(&seed) % SIZE;
      size_t size = 1 + random_next(&seed) % (SIZE - at);
      write_both(&p, &r, at, size < 24 ? size : 24, with);
      expect_same(&p, &r);
    }
    nsdae_write_queue_sort(&p);
    for (size_t i = 1; i < p.count; i++) assert_true(p.block[i - 1].at < p.block[i].at);
    expect_same(&p, &r);
    nsdae_write_queue_clear(&p);
    assert_int_equal(p.count, 0);
    nsdae_write_queue_release(&p);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_each_way),
                                     cmocka_unit_test(test_random)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
