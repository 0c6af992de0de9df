/* A processor that can do more gets there sooner, not elsewhere: seeded problems solved with what
 * the one at hand has, and as on one that has nothing, end with the same bytes, warm, cold and in
 * both forms. */
#include "check.h"

#include <stdlib.h>

#include <nsdae/nsdae.h>

#include "dispatch.h"
#include "friction_families.h"

typedef struct answer {
  int status, m;
  double *r, *u;
  nsdae_friction_info info;
} answer;

/* From the guess of r = factor times that of before, if there is one. */
static answer solve(const nsdae_friction_problem *p, double tol, const answer *before,
                    double factor, int plain)
{
  nsdae_friction_options options;
  answer a = {.m = 3 * p->contacts};
  nsdae_friction_options_default(&options);
  options.tol = tol;
  a.r = calloc((size_t)a.m, sizeof *a.r);
  a.u = calloc((size_t)a.m, sizeof *a.u);
  for (int i = 0; i < a.m && before; i++) a.r[i] = factor * before->r[i];
  nsdae_dispatch_plain = plain;
  a.status = nsdae_friction_solve(p, &options, a.r, a.u, &a.info);
  nsdae_dispatch_plain = 0;
  return a;
}

static void release(answer *a)
{
  free(a->r);
  free(a->u);
}

static void check_alike(const answer *a, const answer *b)
{
  size_t bytes = (size_t)a->m * sizeof *a->r;
  assert_int_equal(a->status, b->status);
  assert_memory_equal(a->r, b->r, bytes);
  assert_memory_equal(a->u, b->u, bytes);
  assert_memory_equal(&a->info.residual, &b->info.residual, sizeof a->info.residual);
  assert_int_equal(a->info.sweeps, b->info.sweeps);
}

static void check_problem(const nsdae_friction_problem *p, double tol)
{
  answer cold = solve(p, tol, NULL, 0, 0), plain = solve(p, tol, NULL, 0, 1);
  check_alike(&cold, &plain);
  answer warm = solve(p, tol, &cold, 0.9, 0), warm_plain = solve(p, tol, &cold, 0.9, 1);
  check_alike(&warm, &warm_plain);
  release(&cold);
  release(&plain);
  release(&warm);
  release(&warm_plain);
}

static void test_alike(void **state)
{
  (void)state;
  for (int seed = 0; seed < 12; seed++) {
    friction_sample s = {0};
    friction_local local;
    friction_sample_draw(&s, seed % FRICTION_FAMILIES, 60, (unsigned)seed + 77);
    friction_sample_local(&s, &local);
    for (int k = 0; k < 2; k++) {
      double tol = k ? 1e-9 : 1e-4;
      check_problem(&s.problem, tol);
      check_problem(&local.problem, tol);
    }
    friction_local_release(&local);
    friction_sample_release(&s);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_alike)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
