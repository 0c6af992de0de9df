/* A part of an island solved by itself: impulses outside stay to the bit, and inside the laws hold
 * with those, by a residual of the test's own; where there is nothing to be had nothing changes. */
#include "check.h"

#include <stdlib.h>

#include <nsdae/nsdae.h>

#include "friction_families.h"
#include "region.h"

enum { CONTACTS = 120, SEEDS = 24 };

typedef struct island {
  nsdae_arena whole_memory, memory;
  nsdae_fc_whole whole;
  nsdae_fc fc;
  double *r, *before; /* of the whole; before: of the island */
} island;

/* Of the problem's only island, at the solution to 1e-9. */
static int make_island(island *s, const friction_sample *sample)
{
  int m = 3 * sample->problem.contacts;
  double *u = calloc((size_t)m, sizeof *u);
  nsdae_friction_options options;
  nsdae_friction_options_default(&options);
  options.tol = 1e-9;
  s->r = calloc((size_t)m, sizeof *s->r);
  s->before = calloc((size_t)m, sizeof *s->before);
  int status = nsdae_friction_solve(&sample->problem, &options, s->r, u, NULL);
  free(u);
  s->whole = (nsdae_fc_whole){.view.p = &sample->problem};
  assert_int_equal(nsdae_arena_fit(&s->whole_memory, nsdae_fc_whole_layout, &s->whole), NSDAE_OK);
  assert_int_equal(nsdae_fc_whole_fill(&s->whole, NULL), NSDAE_OK);
  s->fc = (nsdae_fc){.whole = &s->whole};
  assert_int_equal(nsdae_arena_fit(&s->memory, nsdae_fc_layout, &s->fc), NSDAE_OK);
  nsdae_fc_fill(&s->fc, s->r);
  return status == NSDAE_OK && s->whole.islands.count == 1;
}

static void release_island(island *s)
{
  free(s->r);
  free(s->before);
  nsdae_arena_release(&s->whole_memory);
  nsdae_arena_release(&s->memory);
}

/* Impulses of the items on block b, or of all of them, are off. */
static void disturb(nsdae_fc *c, int b)
{
  for (int k = 0; k < c->n; k++)
    for (int e = c->parts.first[k]; e < c->parts.first[k + 1]; e++)
      if (b < 0 || c->parts.block[e] == b) c->r[3 * k] = 1.5 * c->r[3 * k] + 1;
}

/* Largest entry of x - P(x - y) of item k, y = u + mu |u_T| e_N, with P as it is defined. */
static double natural(const nsdae_fc *c, int k)
{
  double mu = c->items.mu[k], x[3], z[3], most = 0;
  const double *u = c->u + 3 * k;
  for (int j = 0; j < 3; j++) {
    x[j] = c->items.rho[k] * c->r[3 * k + j];
    z[j] = x[j] - u[j] - (j == 0 ? mu * hypot(u[1], u[2]) : 0);
  }
  double t = hypot(z[1], z[2]), n = fmax(0, (z[0] + mu * t) / (1 + mu * mu));
  if (z[0] < 0 || t > mu * z[0]) {
    z[0] = n;
    z[1] *= t > 0 ? mu * n / t : 0;
    z[2] *= t > 0 ? mu * n / t : 0;
  }
  for (int j = 0; j < 3; j++) most = fmax(most, fabs(x[j] - z[j]));
  return c->items.weight[k] * most;
}

/* 1 where the region was solved. */
static int solve_around(nsdae_fc_region *g, island *s, int b, double tol)
{
  nsdae_fc *c = &s->fc;
  nsdae_friction_info info = {0};
  size_t bytes = 3 * (size_t)c->n * sizeof *c->r;
  nsdae_fc_fill(c, s->r);
  disturb(c, b);
  nsdae_fc_velocities(c, c->r, c->y, c->u);
  memcpy(s->before, c->r, bytes);
  int found = nsdae_fc_region_solve(g, c, s->before, tol, &info);
  if (found <= 0) {
    assert_memory_equal(c->r, s->before, bytes);
    return 0;
  }
  int inside = 0;
  nsdae_fc_velocities(c, c->r, c->y, c->u);
  for (int k = 0; k < c->n; k++) {
    inside += g->mark[k];
    if (g->mark[k])
      assert_at_most(natural(c, k), tol);
    else
      assert_memory_equal(c->r + 3 * k, s->before + 3 * k, 3 * sizeof *c->r);
  }
  assert_true(inside > 0 && inside < c->n);
  return 1;
}

static void test_regions(void **state)
{
  nsdae_fc_region region = {0};
  int tried = 0, solved = 0;
  (void)state;
  for (int seed = 0; seed < SEEDS; seed++) {
    friction_sample sample = {0};
    island s = {0};
    friction_sample_draw(&sample, seed % FRICTION_FAMILIES, CONTACTS, (unsigned)seed + 5);
    if (make_island(&s, &sample)) {
      for (int b = 0; b < s.fc.blocks; b += 1 + s.fc.blocks / 8, tried++)
        solved += solve_around(&region, &s, b, seed % 2 ? 1e-4 : 1e-6);
      assert_int_equal(solve_around(&region, &s, -1, 1e-4), 0); /* most of the island */
    }
    release_island(&s);
    friction_sample_release(&sample);
  }
  nsdae_fc_region_release(&region);
  print_message("%d of %d regions\n", solved, tried);
  assert_true(solved > 50);
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_regions)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
