/* Factorisations by fronts against dense ones: random graphs of blocks of random sizes. */
#include "check.h"

#include "allocator.h"
#include "dense.h"
#include "multifrontal.h"
#include "support/random.h"

enum { MOST = 40, WIDE = 6, ORDER = MOST * WIDE };

typedef struct sample {
  int n, order, size[MOST], place[MOST], first[MOST + 1], index[MOST * MOST];
  double A[ORDER * ORDER];
} sample;

static random_state state_of_draws = {7};

static double draw(void)
{
  return random_number(&state_of_draws);
}

/* A graph of n blocks where each pair is joined with this probability. */
static void draw_graph(sample *s, int n, double joined)
{
  static char edge[MOST][MOST];
  s->n = n;
  s->order = 0;
  for (int i = 0; i < n; i++) {
    s->size[i] = random_int(&state_of_draws, 1, WIDE);
    s->place[i] = s->order;
    s->order += s->size[i];
    for (int j = 0; j < i; j++) edge[i][j] = edge[j][i] = draw() < 2 * joined - 1;
  }
  s->first[0] = 0;
  for (int i = 0; i < n; i++) {
    s->first[i + 1] = s->first[i];
    for (int j = 0; j < n; j++)
      if (i != j && edge[i][j]) s->index[s->first[i + 1]++] = j;
  }
}

/* Fills block (i, j) of the fronts and of the dense matrix. */
static void draw_block(sample *s, int i, int j, double *block)
{
  for (int c = 0; c < s->size[j]; c++)
    for (int r = 0; r < s->size[i]; r++) {
      double value = draw();
      block[c * s->size[i] + r] = value;
      s->A[(size_t)(s->place[j] + c) * (size_t)s->order + (size_t)(s->place[i] + r)] = value;
    }
}

static void copy_block(sample *s, int i, int j, double *block)
{
  for (int c = 0; c < s->size[j]; c++)
    for (int r = 0; r < s->size[i]; r++)
      block[c * s->size[i] + r] =
          s->A[(size_t)(s->place[j] + c) * (size_t)s->order + (size_t)(s->place[i] + r)];
}

/* Random entries; symmetric ones are mirrored; the diagonal makes both kinds regular, and the part
 * of the blocks from f->negative on negative definite. */
static void draw_values(sample *s, nsdae_multifrontal *f, int symmetric)
{
  memset(s->A, 0, sizeof s->A);
  for (int i = 0; i < s->n; i++) {
    draw_block(s, i, i, f->A + f->graph.diagonal[i]);
    for (int a = s->first[i]; a < s->first[i + 1]; a++)
      draw_block(s, s->index[a], i, f->A + f->graph.at[a]);
  }
  int negative = f->negative > 0 && f->negative < s->n ? s->place[f->negative] : s->order;
  for (int j = 0; j < s->order; j++)
    for (int i = 0; i <= j; i++) {
      double *upper = s->A + (size_t)j * (size_t)s->order + i;
      double *lower = s->A + (size_t)i * (size_t)s->order + j;
      if (symmetric) *upper = *lower;
      if (i == j) *upper += j < negative ? s->order : -s->order;
    }
  for (int i = 0; i < s->n; i++) {
    copy_block(s, i, i, f->A + f->graph.diagonal[i]);
    for (int a = s->first[i]; a < s->first[i + 1]; a++)
      copy_block(s, s->index[a], i, f->A + f->graph.at[a]);
  }
}

static void check(sample *s, nsdae_multifrontal *f, int symmetric)
{
  static double b[ORDER], x[ORDER];
  int pivot[ORDER];
  assert_int_equal(nsdae_multifrontal_analyse(f, s->n, s->size, s->first, s->index), 0);
  draw_values(s, f, symmetric);
  assert_int_equal(nsdae_multifrontal_factor(f, symmetric), 0);
  for (int i = 0; i < s->order; i++) b[i] = x[i] = draw();
  nsdae_multifrontal_solve(f, x);
  assert_int_equal(nsdae_la_lu(s->order, s->A, s->order, pivot), 0);
  nsdae_la_lu_solve(s->order, s->A, s->order, pivot, b);
  /* |x| <= 1, condition below 10 */
  for (int i = 0; i < s->order; i++) assert_near(x[i], b[i], 1e-13);
}

/* One struct for all: the memory of one analysis serves the next, or grows. */
static void test_random(void **state)
{
  (void)state;
  static sample s;
  nsdae_multifrontal f = {0};
  for (int k = 0; k < 300; k++) {
    draw_graph(&s, random_int(&state_of_draws, 1, MOST), k % 5 * 0.05);
    check(&s, &f, 0);
    check(&s, &f, 1); /* the same graph: not analysed again */
  }
  nsdae_multifrontal_release(&f);
}

/* L S L^T of quasi-definite matrices. */
static void test_negative(void **state)
{
  (void)state;
  static sample s;
  nsdae_multifrontal f = {0};
  for (int k = 0; k < 60; k++) {
    draw_graph(&s, random_int(&state_of_draws, 1, MOST), k % 5 * 0.05);
    f.negative = (s.n + 1) / 2; /* of n alone: a graph that is kept has the same */
    check(&s, &f, 1);
  }
  nsdae_multifrontal_release(&f);
}

static void test_singular(void **state)
{
  (void)state;
  const int size[2] = {2, 1}, first[3] = {0, 1, 2}, index[2] = {1, 0};
  nsdae_multifrontal f = {0};
  assert_int_equal(nsdae_multifrontal_analyse(&f, 2, size, first, index), 0);
  memset(f.A, 0, f.values * sizeof *f.A);
  assert_true(nsdae_multifrontal_factor(&f, 0) > 0);
  assert_true(nsdae_multifrontal_factor(&f, 1) > 0);
  f.A[f.graph.diagonal[0]] = NAN;
  assert_true(nsdae_multifrontal_factor(&f, 1) > 0);
  nsdae_multifrontal_release(&f);
}

/* An analysis that lost an allocation knows no graph: neither that of the call before nor its own,
 * of which it has parts. */
static void test_lost(void **state)
{
  (void)state;
  static sample s[2];
  for (int j = 0; j < 2; j++) draw_graph(&s[j], MOST, 0.6 + 0.2 * j);
  for (long lost = 0, failed = 1; failed; lost++) {
    nsdae_multifrontal f = {0};
    check(&s[0], &f, 1);
    allocator_reset(lost);
    failed = nsdae_multifrontal_analyse(&f, s[1].n, s[1].size, s[1].first, s[1].index) != 0;
    allocator_reset(-1);
    check(&s[lost % 2], &f, 1);
    check(&s[1 - lost % 2], &f, 0);
    nsdae_multifrontal_release(&f);
    allocator_reset(lost); /* and of the first */
    failed |= nsdae_multifrontal_analyse(&f, s[0].n, s[0].size, s[0].first, s[0].index) != 0;
    allocator_reset(-1);
    check(&s[0], &f, 1);
    nsdae_multifrontal_release(&f);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_random), cmocka_unit_test(test_negative),
                                     cmocka_unit_test(test_singular), cmocka_unit_test(test_lost)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
