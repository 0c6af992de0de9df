/* Bilateral rows eliminated: W, q and the multipliers of random problems, against the equations by
 * blocks that are solved as one dense matrix. */
#include "check.h"

#include <nsdae/nsdae.h>
#include <stdlib.h>

#include "static_condensation.h"
#include "support/random.h"

enum { BLOCKS = 7, SIZE = 6, CONTACTS = 5, ROWS = 9, ITEMS = CONTACTS + ROWS, N = BLOCKS * SIZE };
enum { M = 3 * CONTACTS + ROWS, ALL = N + ROWS };

static uint64_t seed;

typedef struct sample {
  nsdae_friction_problem problem;
  int size[BLOCKS], first[ITEMS + 1], block[2 * ITEMS];
  double M[N * SIZE], f[N], w[M], mu[CONTACTS], compliance[M], value[2 * 3 * SIZE * M];
  double H[M][N]; /* the same, dense */
} sample;

static double number(void)
{
  return random_between(&seed, -1, 1);
}

/* Rows join blocks to a tree (or, loops, to any graph); contacts are between any two. */
static void draw(sample *s, int loops)
{
  memset(s, 0, sizeof *s);
  double *value = s->value;
  for (int b = 0; b < BLOCKS; b++) {
    double *own = s->M + b * SIZE * SIZE;
    s->size[b] = SIZE;
    for (int j = 0; j < SIZE; j++) own[j * (SIZE + 1)] = random_between(&seed, 0.5, 2);
    own[1] = own[SIZE] = 0.2 * number();
  }
  for (int j = 0; j < N; j++) s->f[j] = number();
  for (int i = 0, m = 0; i < ITEMS; i++) {
    int columns = i < CONTACTS ? 3 : 1, joint = (i - CONTACTS) / 2;
    int a = i < CONTACTS || loops ? random_below(&seed, BLOCKS) : joint + 1;
    int b = i < CONTACTS || loops ? random_below(&seed, BLOCKS) : random_below(&seed, joint + 1);
    s->first[i + 1] = s->first[i];
    for (int e = 0; e < (a == b ? 1 : 2); e++) {
      int of = e ? b : a;
      s->block[s->first[i + 1]++] = of;
      for (int k = 0; k < columns; k++)
        for (int j = 0; j < SIZE; j++) s->H[m + k][of * SIZE + j] = *value++ = number();
    }
    for (int k = 0; k < columns; k++) s->w[m++] = number();
    if (i < CONTACTS) s->mu[i] = 0.5;
  }
  s->problem = (nsdae_friction_problem){.form = NSDAE_FRICTION_GLOBAL,
                                        .contacts = CONTACTS,
                                        .bilateral = ROWS,
                                        .mu = s->mu,
                                        .w = s->w,
                                        .blocks = BLOCKS,
                                        .size = s->size,
                                        .M = s->M,
                                        .f = s->f,
                                        .first = s->first,
                                        .block = s->block,
                                        .value = s->value};
}

/* x := A^-1 x, by elimination with the largest pivot of each column. */
static void solve_dense(double A[ALL][ALL], double *x)
{
  for (int k = 0; k < ALL; k++) {
    int best = k;
    for (int i = k + 1; i < ALL; i++)
      if (fabs(A[i][k]) > fabs(A[best][k])) best = i;
    for (int j = 0; j < ALL; j++) {
      double t = A[k][j];
      A[k][j] = A[best][j], A[best][j] = t;
    }
    double t = x[k];
    x[k] = x[best], x[best] = t;
    for (int i = k + 1; i < ALL; i++) {
      double by = A[i][k] / A[k][k];
      for (int j = k; j < ALL; j++) A[i][j] -= by * A[k][j];
      x[i] -= by * x[k];
    }
  }
  for (int k = ALL - 1; k >= 0; k--) {
    for (int j = k + 1; j < ALL; j++) x[k] -= A[k][j] * x[j];
    x[k] /= A[k][k];
  }
}

/* x := v and the multipliers of M v = p + H_b l, H_b^T v + c = 0, with p and c in x. */
static void solve_joined(const sample *s, double *x)
{
  static double A[ALL][ALL];
  memset(A, 0, sizeof A);
  for (int b = 0; b < BLOCKS; b++)
    for (int i = 0; i < SIZE; i++)
      for (int j = 0; j < SIZE; j++)
        A[b * SIZE + i][b * SIZE + j] = s->M[b * SIZE * SIZE + j * SIZE + i];
  for (int l = 0; l < ROWS; l++) {
    for (int j = 0; j < N; j++) A[j][N + l] = -(A[N + l][j] = s->H[3 * CONTACTS + l][j]);
    x[N + l] = -x[N + l];
  }
  solve_dense(A, x);
}

static void prepare(const sample *s, nsdae_fc_global *global, nsdae_arena *memory)
{
  *global = (nsdae_fc_global){.view.p = &s->problem};
  assert_int_equal(nsdae_fc_problem_check(&s->problem, NULL), NSDAE_OK);
  assert_int_equal(nsdae_arena_build(memory, nsdae_fc_global_layout, global), NSDAE_OK);
  assert_int_equal(nsdae_fc_global_fill(global, NULL), NSDAE_OK);
}

/* Velocities of the contacts with impulses r, and the multipliers behind them. */
static void reference(const sample *s, const double *r, double *u)
{
  double x[ALL];
  memcpy(x, s->f, sizeof s->f);
  for (int k = 0; k < 3 * CONTACTS; k++)
    for (int j = 0; j < N; j++) x[j] += s->H[k][j] * r[k];
  for (int l = 0; l < ROWS; l++) x[N + l] = s->w[3 * CONTACTS + l];
  solve_joined(s, x);
  for (int k = 0; k < 3 * CONTACTS; k++) {
    u[k] = s->w[k];
    for (int j = 0; j < N; j++) u[k] += s->H[k][j] * x[j];
  }
  for (int l = 0; l < ROWS; l++) u[3 * CONTACTS + l] = x[N + l];
}

/* W r + q and the multipliers of the impulses r are those of the reference. */
static void check_equations(const sample *s, const nsdae_fc_condensed *c, double *r)
{
  double expected[M];
  const double *W = c->problem.value;
  reference(s, r, expected);
  for (int i = 0; i < CONTACTS; i++) {
    double u[3];
    memcpy(u, c->problem.w + 3 * i, sizeof u);
    for (int e = c->problem.first[i]; e < c->problem.first[i + 1]; e++)
      for (int k = 0; k < 3; k++)
        for (int l = 0; l < 3; l++) u[k] += *W++ * r[3 * c->problem.block[e] + l];
    for (int k = 0; k < 3; k++) assert_near(u[k], expected[3 * i + k], 1e-9);
  }
  nsdae_fc_condensed_multipliers(c, r);
  for (int l = 3 * CONTACTS; l < M; l++) assert_near(r[l], expected[l], 1e-9);
}

/* Also about any impulses with their velocities. */
static void check_sample(int loops)
{
  static sample s;
  nsdae_fc_global global;
  nsdae_fc_condensed c = {0};
  nsdae_arena memory = {0};
  double r[M] = {0}, u[M], residual;
  draw(&s, loops);
  prepare(&s, &global, &memory);
  assert_int_equal(nsdae_fc_condense(&c, &global), 1);
  for (int k = 0; k < 3 * CONTACTS; k++) r[k] = number();
  check_equations(&s, &c, r);
  for (int k = 0; k < M; k++) r[k] = number();
  assert_int_equal(nsdae_friction_residual(&s.problem, r, u, &residual), NSDAE_OK);
  nsdae_fc_condensed_correct(&c, r, u);
  for (int k = 0; k < 3 * CONTACTS; k++) r[k] = number();
  check_equations(&s, &c, r);
  nsdae_fc_condensed_release(&c);
  nsdae_arena_release(&memory);
}

static void test_equations(void **state)
{
  (void)state;
  seed = 3;
  for (int i = 0; i < 400; i++) check_sample(i % 2);
}

/* What is left to the other solvers: dependent rows, one block, no rows, no contacts. */
static void test_left(void **state)
{
  static sample s;
  nsdae_fc_condensed c = {0};
  (void)state;
  seed = 4;
  for (int i = 0; i < 4; i++) {
    nsdae_fc_global global;
    nsdae_arena memory = {0};
    draw(&s, 0);
    if (i == 0) { /* the last row is that before it */
      int e = s.first[ITEMS - 2];
      double *value = s.value + SIZE * (3 * s.first[CONTACTS] + e - s.first[CONTACTS]);
      memcpy(value + 2 * SIZE, value, 2 * SIZE * sizeof *value);
      for (int j = 0; j < 2; j++) s.block[e + 2 + j] = s.block[e + j];
    }
    if (i == 1) s.problem.bilateral = 0;
    if (i == 2) s.problem.contacts = 0, s.problem.bilateral = 0;
    if (i == 3) s.problem.blocks = 1, s.problem.bilateral = 0, s.problem.contacts = 0;
    prepare(&s, &global, &memory);
    assert_int_equal(nsdae_fc_condense(&c, &global), 0);
    nsdae_arena_release(&memory);
  }
  nsdae_fc_condensed_release(&c);
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_equations), cmocka_unit_test(test_left)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
