/* Random pairs are joined; which numbers are in one set is told by a matrix of who reaches whom. */
#include "check.h"

#include <string.h>

#include "disjoint_sets.h"
#include "support/random.h"

enum { N = 40 };

static void join_in_matrix(int in[N][N], int a, int b)
{
  int both[N];
  for (int i = 0; i < N; i++) both[i] = in[a][i] || in[b][i];
  for (int i = 0; i < N; i++)
    if (both[i]) memcpy(in[i], both, sizeof both);
}

static void test_sets(void **state)
{
  uint64_t random = 1;
  (void)state;
  for (int run = 0; run < 200; run++) {
    int parent[N], in[N][N] = {{0}};
    nsdae_sets_begin(parent, N);
    for (int i = 0; i < N; i++) in[i][i] = 1;
    for (int pairs = random_below(&random, 2 * N); pairs > 0; pairs--) {
      int a = random_below(&random, N), b = random_below(&random, N);
      join_in_matrix(in, a, b);
      assert_true(in[a][nsdae_sets_join(parent, a, b)]);
    }
    for (int i = 0; i < N; i++) {
      int least = 0;
      while (!in[i][least]) least++;
      assert_int_equal(nsdae_sets_root(parent, i), least);
    }
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_sets)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
