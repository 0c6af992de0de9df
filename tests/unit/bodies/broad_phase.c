/* Solids about a place, of random sizes from millimetres to metres: those that a loop over all has,
 * each once, whether the ball about the place has few cells of the grid or more than there are
 * solids. */
#include "check.h"

#include <nsdae/nsdae.h>

#include "broad_phase.h"
#include "support/random.h"

enum { SOLIDS = 200, PLACES = 400 };

static uint64_t seed = 5;

static int count_it(void *to, int i)
{
  ((int *)to)[i]++;
  return 0;
}

static int is_it(void *to, int i)
{
  return i == *(int *)to;
}

static void test_about(void **state)
{
  (void)state;
  nsdae_bodies *b;
  double q[7 * SOLIDS], v[6 * SOLIDS];
  int found = 0;
  assert_int_equal(nsdae_bodies_create(3, &b, NULL), NSDAE_OK);
  for (int i = 0; i < SOLIDS; i++) {
    nsdae_rigid_body body = {.mass = 1, .inertia = {1, 1, 1}};
    nsdae_solid ball = {.shape = NSDAE_SHAPE_SPHERE,
                        .radius = i % 20 == 0 ? random_between(&seed, 0.5, 3)
                                              : random_between(&seed, 1e-3, 2e-2)};
    for (int j = 0; j < 3; j++) body.position[j] = random_between(&seed, -2, 2);
    nsdae_bodies_add_solid(b, nsdae_bodies_add(b, &body), &ball);
  }
  assert_int_equal(nsdae_bodies_get_start(b, q, v), NSDAE_OK);
  nsdae_broad *broad = nsdae_broad_take(b);
  assert_non_null(broad);
  nsdae_broad_place(broad, q, NULL);
  nsdae_broad_sort(broad, 1e-3);
  assert_true(broad->larges > 0 && broad->larges < SOLIDS / 2);
  for (int place = 0; place < PLACES; place++) {
    double x[3], within = pow(10, random_between(&seed, -4, place % 2 ? -1.5 : 1));
    int seen[SOLIDS] = {0}, last = -1;
    for (int j = 0; j < 3; j++) x[j] = random_between(&seed, -2.5, 2.5);
    assert_int_equal(nsdae_broad_about(broad, x, within, count_it, seen), 0);
    for (int i = 0; i < SOLIDS; i++) {
      assert_int_equal(seen[i], nsdae_broad_is_about(broad, i, x, within));
      if (seen[i]) last = i;
      found += seen[i];
    }
    if (last >= 0) assert_int_equal(nsdae_broad_about(broad, x, within, is_it, &last), 1);
  }
  assert_true(found > PLACES);
  nsdae_broad_give_back(b, broad);
  nsdae_bodies_destroy(&b);
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_about)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
