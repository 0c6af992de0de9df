/* Seeded piles, walls and towers (support/friction_families.h): what is called solved is solved by
 * an independent residual, in long double; nearly all are, to 1e-10; warm starts and local forms
 * agree. */
#include "check.h"

#include <stdlib.h>

#include <nsdae/nsdae.h>

#include "friction_families.h"

enum { SAMPLES = 48, LEAST_SOLVED = 44 };

static int solve(const nsdae_friction_problem *p, double tol, double *r, nsdae_friction_info *info)
{
  nsdae_friction_options options;
  nsdae_friction_options_default(&options);
  options.tol = tol;
  double *u = calloc(3 * (size_t)p->contacts, sizeof *u);
  int status = nsdae_friction_solve(p, &options, r, u, info);
  free(u);
  return status;
}

/* The residual of the library is that of the sample, but for the rounding of r d / s. */
static void check_residual(const friction_sample *s, const double *r, double residual)
{
  assert_near(friction_sample_residual(s, r, NULL), residual, 1e-3 * residual + 1e-11);
}

/* From the solution the warm start ends at once. */
static void check_warm(const friction_sample *s, double *r)
{
  nsdae_friction_info info;
  assert_int_equal(solve(&s->problem, 1e-9, r, &info), NSDAE_OK);
  assert_true(info.stage <= NSDAE_FRICTION_WARM);
  assert_int_equal(info.sweeps, 0);
}

static int check_sample(int family, int contacts, unsigned seed)
{
  friction_sample s;
  nsdae_friction_info info;
  memset(&s, 0, sizeof s);
  friction_sample_draw(&s, family, contacts, seed);
  double *r = calloc(3 * (size_t)s.problem.contacts, sizeof *r);
  int status = solve(&s.problem, 1e-10, r, &info);
  assert_true(status == NSDAE_OK || status == NSDAE_E_LCP);
  assert_int_equal(status == NSDAE_OK, info.residual <= 1e-10);
  check_residual(&s, r, info.residual);
  if (status == NSDAE_OK) check_warm(&s, r);
  free(r);
  friction_sample_release(&s);
  return status == NSDAE_OK;
}

static void test_families(void **state)
{
  (void)state;
  int solved = 0;
  for (int k = 0; k < SAMPLES; k += test_share())
    solved += check_sample(k % FRICTION_FAMILIES, 20 + 2 * k, (unsigned)k);
  print_message("%d of %d solved\n", solved, share_of(SAMPLES));
  assert_true(solved >= LEAST_SOLVED * share_of(SAMPLES) / SAMPLES);
}

/* Both forms of a problem have the solution of one as a solution. */
static void test_forms(void **state)
{
  (void)state;
  for (unsigned k = 0; k < 8; k++) {
    friction_sample s;
    friction_local local;
    nsdae_friction_info info;
    memset(&s, 0, sizeof s);
    friction_sample_draw(&s, (int)k % FRICTION_FAMILIES, 30, 100 + k);
    friction_sample_local(&s, &local);
    double *r = calloc(3 * (size_t)s.problem.contacts, sizeof *r);
    if (solve(&local.problem, 1e-9, r, &info) == NSDAE_OK)
      assert_at_most(friction_sample_residual(&s, r, NULL),
                     1e-8); /* W is rounded: 1e-16 of its terms */
    free(r);
    friction_local_release(&local);
    friction_sample_release(&s);
  }
}

/* Length of the part of item k at entry e: its block's rows times three directions. */
static size_t part_size(const nsdae_friction_problem *p, int e)
{
  return 3 * (size_t)p->size[p->block[e]];
}

/* The contacts of a problem in another order. */
typedef struct shuffled {
  nsdae_friction_problem problem;
  int *first, *block;
  double *mu, *w, *value;
} shuffled;

static void shuffle(const nsdae_friction_problem *p, const int *order, shuffled *s)
{
  int entries = p->first[p->contacts], used = 0;
  size_t *from = calloc((size_t)entries + 1, sizeof *from), n = (size_t)p->contacts;
  for (int e = 0; e < entries; e++) from[e + 1] = from[e] + part_size(p, e);
  s->mu = calloc(n, sizeof *s->mu);
  s->w = calloc(3 * n, sizeof *s->w);
  s->value = calloc(from[entries], sizeof *s->value);
  s->first = calloc(n + 1, sizeof *s->first);
  s->block = calloc((size_t)entries, sizeof *s->block);
  double *next = s->value;
  for (int i = 0; i < p->contacts; i++) {
    int k = order[i];
    s->mu[i] = p->mu[k];
    memcpy(s->w + 3 * i, p->w + 3 * k, 3 * sizeof *s->w);
    for (int e = p->first[k]; e < p->first[k + 1]; e++) {
      s->block[used++] = p->block[e];
      memcpy(next, p->value + from[e], part_size(p, e) * sizeof *next);
      next += part_size(p, e);
    }
    s->first[i + 1] = used;
  }
  free(from);
  s->problem = *p;
  s->problem.mu = s->mu, s->problem.w = s->w, s->problem.value = s->value;
  s->problem.first = s->first, s->problem.block = s->block;
}

static void free_shuffled(shuffled *s)
{
  free(s->mu);
  free(s->w);
  free(s->value);
  free(s->first);
  free(s->block);
}

static int solve_in_order(const friction_sample *s, const int *order)
{
  nsdae_friction_info info;
  shuffled other;
  shuffle(&s->problem, order, &other);
  size_t m = 3 * (size_t)s->problem.contacts;
  double *r = calloc(m, sizeof *r), *back = calloc(m, sizeof *back);
  int status = solve(&other.problem, 1e-4, r, &info);
  for (int i = 0; i < s->problem.contacts; i++)
    memcpy(back + 3 * (size_t)order[i], r + 3 * (size_t)i, 3 * sizeof *back);
  assert_int_equal(status, NSDAE_OK);
  assert_at_most(friction_sample_residual(s, back, NULL), 1e-4 * (1 + 1e-9));
  free(r);
  free(back);
  free_shuffled(&other);
  return info.stage;
}

/* To a rough tolerance sweeps and Newton's method in turn: whatever the order in which contacts are
 * given, and so which of them sweeps meet first, each is solved. */
static void test_orders(void **state)
{
  (void)state;
  int stages = 0;
  for (unsigned k = 1; k < 9; k++) {
    friction_sample s;
    memset(&s, 0, sizeof s);
    friction_sample_draw(&s, (int)k % FRICTION_FAMILIES, 150, 300 + k);
    int n = s.problem.contacts, *order = calloc((size_t)n, sizeof *order);
    for (int i = 0; i < n; i++) order[i] = i;
    for (unsigned turn = 0; turn < 3; turn++) {
      stages |= solve_in_order(&s, order);
      for (int i = n - 1; i > 0; i--) {
        int j = (int)((2654435761u * (unsigned)(i + 1) + 40503u * (turn + k)) % (unsigned)(i + 1));
        int held = order[i];
        order[i] = order[j];
        order[j] = held;
      }
    }
    free(order);
    friction_sample_release(&s);
  }
  assert_true(stages & NSDAE_FRICTION_NSGS); /* both of the ways were taken */
  assert_true(stages & NSDAE_FRICTION_SMOOTHING_HOMOTOPY);
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_families), cmocka_unit_test(test_forms),
                                     cmocka_unit_test(test_orders)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
