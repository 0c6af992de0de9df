/* The kernels of friction on plain arrays: one contact by hand, the certificate beside that of
 * nsdae_friction_residual, sweeps and Newton's method beside each other and beside the chain, every
 * argument broken in turn. */
#include "check.h"

#include <nsdae/kernels.h>
#include <nsdae/nsdae.h>

#include "../linalg/random_matrices.h"

enum { MOST = 8, M = 3 * MOST, BODIES = 3, WORK = M * (M + 3) };

static random_state state_of_draws = {29};

static double draw(void)
{
  return random_number(&state_of_draws);
}

/* W = J J^T + C of contacts that touch a few bodies; dense, every pair listed for the chain. */
typedef struct sample {
  int nc, m, rows[MOST];
  double W[M * M], q[M], mu[MOST], r[M], u[M], work[WORK], residual;
  int first[MOST + 1], block[MOST * MOST], iterations, iwork[M];
  double value[M * M];
  nsdae_friction_problem problem;
} sample;

/* kinds 3: three rows each; 2, 1: no more than that, drawn. */
static void draw_sample(sample *s, int nc, int kinds, double compliance)
{
  static double J[M][6 * BODIES];
  memset(s, 0, sizeof *s);
  memset(J, 0, sizeof J);
  s->nc = nc;
  for (int c = 0; c < nc; c++) {
    s->rows[c] = kinds == 3 ? 3 : 1 + (int)(1.999 * fabs(draw())) * (kinds - 1);
    s->mu[c] = c % 3 == 2 ? 0 : 0.3 * (1 + draw());
    for (int k = 0; k < s->rows[c]; k++, s->m++)
      for (int d = 0; d < 6; d++) J[s->m][6 * (c % BODIES) + d] = draw();
  }
  for (int i = 0; i < s->m; i++) s->q[i] = draw();
  for (int j = 0; j < s->m; j++)
    for (int i = 0; i < s->m; i++) {
      double sum = i == j ? compliance : 0;
      for (int d = 0; d < 6 * BODIES; d++) sum += J[i][d] * J[j][d];
      s->W[j * s->m + i] = sum;
    }
}

static void make_problem(sample *s)
{
  int at = 0, count = 0;
  for (int c = 0, ci = 0; c < s->nc; ci += s->rows[c++]) {
    s->first[c] = count;
    for (int d = 0, di = 0; d < s->nc; di += s->rows[d++]) {
      s->block[count++] = d;
      for (int k = 0; k < s->rows[c]; k++)
        for (int l = 0; l < s->rows[d]; l++) s->value[at++] = s->W[(ci + k) * s->m + di + l];
    }
  }
  s->first[s->nc] = count;
  s->problem = (nsdae_friction_problem){.form = NSDAE_FRICTION_LOCAL,
                                        .contacts = s->nc,
                                        .rows = s->rows,
                                        .mu = s->mu,
                                        .w = s->q,
                                        .first = s->first,
                                        .block = s->block,
                                        .value = s->value};
}

static int sweeps(sample *s, double tol, int most)
{
  return nsdae_dfcbgs(s->nc, s->rows, s->W, s->m, s->q, s->mu, tol, most, s->r, &s->iterations,
                      &s->residual, s->work, WORK);
}

static int newton(sample *s, double alpha, double tol, int most)
{
  return nsdae_dfcnwt(s->nc, s->rows, s->W, s->m, s->q, s->mu, alpha, tol, most, s->r,
                      &s->iterations, &s->residual, s->work, WORK, s->iwork);
}

/* W = 2 on the normal, 1 along the tangents: it opens, sticks with r = -W^-1 q, and slides along
 * -q_T with r_N = 2 and |r_T| = mu r_N. */
static void test_one_contact(void **state)
{
  (void)state;
  const double W[9] = {2, 0, 0, 0, 1, 0, 0, 0, 1};
  const double q[3][3] = {{1, 3, 4}, {-4, 0.3, 0.4}, {-4, 3, 4}}, mu = 0.5;
  const double wanted[3][3] = {{0, 0, 0}, {2, -0.3, -0.4}, {2, -0.6, -0.8}};
  double r[3], u[3], residual;
  for (int k = 0; k < 3; k++) {
    assert_int_equal(nsdae_dfccon(3, W, 3, q[k], mu, r, u, &residual), 0);
    for (int i = 0; i < 3; i++) {
      assert_near(r[i], wanted[k][i], 1e-14);
      assert_near(u[i], W[4 * i] * wanted[k][i] + q[k][i], 1e-14);
    }
    assert_true(residual <= 1e-15);
    assert_int_equal(nsdae_dfccon(2, W, 3, q[k], mu, r, u, &residual), 0); /* its plane */
    assert_true(residual <= 1e-15);
    assert_int_equal(nsdae_dfccon(1, W, 3, q[k], NAN, r, u, &residual), 0);
    assert_near(r[0], fmax(0, -q[k][0] / 2), 0);
  }
}

/* Any symmetric positive definite block, with and without friction. */
static void test_random_contacts(void **state)
{
  (void)state;
  for (int k = 0; k < 300; k++) {
    sample s;
    draw_sample(&s, 1, 3, 1e-3);
    double mu = k % 4 == 0 ? 0 : k % 4 == 1 ? 10 : fabs(draw());
    assert_int_equal(nsdae_dfccon(3, s.W, 3, s.q, mu, s.r, s.u, &s.residual), 0);
    assert_true(s.residual <= 1e-12); /* d r may be 1e3 times q */
  }
}

static void test_residual(void **state)
{
  (void)state;
  for (int k = 0; k < 200; k++) {
    sample s;
    double other, v[M];
    draw_sample(&s, 1 + k % MOST, 1 + k % 3, 0);
    make_problem(&s);
    for (int i = 0; i < s.m; i++) s.r[i] = draw();
    assert_int_equal(nsdae_friction_residual(&s.problem, s.r, v, &other), NSDAE_OK);
    assert_int_equal(nsdae_dfcres(s.nc, s.rows, s.W, s.m, s.q, s.mu, s.r, s.u, &s.residual), 0);
    assert_near(s.residual, other, 1e-14 * (1 + other));
    for (int i = 0; i < s.m; i++) assert_near(s.u[i], v[i], 1e-13);
  }
}

/* With compliance the sweeps converge; Newton's method from where they are takes few steps. W is
 * well conditioned and friction small: the solution is one, and the chain's. */
static void test_methods_agree(void **state)
{
  (void)state;
  for (int k = 0; k < 100; k++) {
    sample s;
    double r[M] = {0}, u[M];
    draw_sample(&s, 1 + k % MOST, 1 + k % 3, 3);
    make_problem(&s);
    for (int c = 0; c < s.nc; c++) s.mu[c] *= 0.3;
    assert_int_equal(sweeps(&s, 1e-3, 1000), 0);
    assert_int_equal(newton(&s, 0, 1e-14, 20), 0);
    assert_true(s.iterations <= 10);
    assert_int_equal(nsdae_friction_solve(&s.problem, NULL, r, u, NULL), NSDAE_OK);
    for (int i = 0; i < s.m; i++) assert_near(s.r[i], r[i], 1e-8);
    memset(s.r, 0, sizeof s.r);
    assert_int_equal(sweeps(&s, 1e-13, 10000), 0);
    for (int i = 0; i < s.m; i++) assert_near(s.r[i], r[i], 1e-8);
  }
}

/* More rows than freedoms: W is singular, and the proximal term keeps the equations regular. */
static void test_singular(void **state)
{
  (void)state;
  int solved = 0;
  for (int k = 0; k < 60; k++) {
    sample s;
    draw_sample(&s, MOST, 3, 0);
    for (int c = 0; c < s.nc; c++) s.mu[c] = fmax(s.mu[c], 0.05);
    if (sweeps(&s, 1e-4, 3000) > 1) fail_msg("sweeps");
    int info = newton(&s, 1e-6, 1e-12, 100);
    assert_true(info == 0 || info == 1);
    assert_true((info == 0) == (s.residual <= 1e-12));
    solved += info == 0;
  }
  assert_true(solved >= 54); /* q is drawn anyhow: not every one need have a solution */
}

/* One argument broken at a time: nothing is done. */
static void test_arguments(void **state)
{
  (void)state;
  sample s;
  draw_sample(&s, 4, 3, 1);
  const double bad_mu[] = {0.1, -0.1, 0, 0}, nan[M * M] = {NAN};
  const int bad_rows[] = {3, 3, 4, 3};
  int n = s.nc, m = s.m, it;
  double *W = s.W, *q = s.q, *mu = s.mu, *r = s.r, *u = s.u, *work = s.work, e;
#define RES(nc, rows, a, lda, q, mu, r, u, e) nsdae_dfcres(nc, rows, a, lda, q, mu, r, u, e)
  assert_int_equal(RES(-1, NULL, W, m, q, mu, r, u, &e), -1);
  assert_int_equal(RES(n, bad_rows, W, m, q, mu, r, u, &e), -2);
  assert_int_equal(RES(n, NULL, NULL, m, q, mu, r, u, &e), -3);
  assert_int_equal(RES(n, NULL, W, m - 1, q, mu, r, u, &e), -4);
  assert_int_equal(RES(0, NULL, W, 0, q, mu, r, u, &e), -4);
  assert_int_equal(RES(n, NULL, W, m, NULL, mu, r, u, &e), -5);
  assert_int_equal(RES(n, NULL, W, m, q, NULL, r, u, &e), -6);
  assert_int_equal(RES(n, NULL, W, m, q, bad_mu, r, u, &e), -6);
  assert_int_equal(RES(n, NULL, W, m, q, nan, r, u, &e), -6);
  assert_int_equal(RES(n, NULL, W, m, q, mu, NULL, u, &e), -7);
  assert_int_equal(RES(n, NULL, W, m, q, mu, r, NULL, &e), -8);
  assert_int_equal(RES(n, NULL, W, m, q, mu, r, u, NULL), -9);
  assert_int_equal(RES(n, NULL, W, m, nan, mu, r, u, &e), 1);
  assert_int_equal(RES(n, NULL, W, m, q, mu, nan, u, &e), 1);
  assert_int_equal(RES(0, NULL, NULL, 1, NULL, NULL, NULL, NULL, &e), 0);
  assert_true(e == 0);
#define CON(rows, a, lda, q, mu, r, u, e) nsdae_dfccon(rows, a, lda, q, mu, r, u, e)
  assert_int_equal(CON(4, W, m, q, 0.5, r, u, &e), -1);
  assert_int_equal(CON(3, NULL, m, q, 0.5, r, u, &e), -2);
  assert_int_equal(CON(3, nan, 3, q, 0.5, r, u, &e), -2);
  assert_int_equal(CON(3, W, 2, q, 0.5, r, u, &e), -3);
  assert_int_equal(CON(3, W, m, NULL, 0.5, r, u, &e), -4);
  assert_int_equal(CON(3, W, m, nan, 0.5, r, u, &e), -4);
  assert_int_equal(CON(3, W, m, q, -0.5, r, u, &e), -5);
  assert_int_equal(CON(3, W, m, q, INFINITY, r, u, &e), -5);
  assert_int_equal(CON(3, W, m, q, 0.5, NULL, u, &e), -6);
  assert_int_equal(CON(3, W, m, q, 0.5, r, NULL, &e), -7);
  assert_int_equal(CON(3, W, m, q, 0.5, r, u, NULL), -8);
  const double singular[9] = {1, 1, 0, 1, 1, 0, 0, 0, 1}, negative[1] = {-1};
  assert_int_equal(CON(3, singular, 3, q, 0.5, r, u, &e), 1);
  assert_int_equal(CON(1, negative, 1, q, 0.5, r, u, &e), 1);
#define BGS(nc, rows, a, lda, q, mu, tol, most, r, it, e, work, lwork) \
  nsdae_dfcbgs(nc, rows, a, lda, q, mu, tol, most, r, it, e, work, lwork)
  assert_int_equal(BGS(-1, NULL, W, m, q, mu, 0, 1, r, &it, &e, work, WORK), -1);
  assert_int_equal(BGS(n, bad_rows, W, m, q, mu, 0, 1, r, &it, &e, work, WORK), -2);
  assert_int_equal(BGS(n, NULL, nan, m, q, mu, 0, 1, r, &it, &e, work, WORK), -3);
  assert_int_equal(BGS(n, NULL, W, 1, q, mu, 0, 1, r, &it, &e, work, WORK), -4);
  assert_int_equal(BGS(n, NULL, W, m, nan, mu, 0, 1, r, &it, &e, work, WORK), -5);
  assert_int_equal(BGS(n, NULL, W, m, q, bad_mu, 0, 1, r, &it, &e, work, WORK), -6);
  assert_int_equal(BGS(n, NULL, W, m, q, mu, NAN, 1, r, &it, &e, work, WORK), -7);
  assert_int_equal(BGS(n, NULL, W, m, q, mu, 0, -1, r, &it, &e, work, WORK), -8);
  assert_int_equal(BGS(n, NULL, W, m, q, mu, 0, 1, NULL, &it, &e, work, WORK), -9);
  assert_int_equal(BGS(n, NULL, W, m, q, mu, 0, 1, r, NULL, &e, work, WORK), -10);
  assert_int_equal(BGS(n, NULL, W, m, q, mu, 0, 1, r, &it, NULL, work, WORK), -11);
  assert_int_equal(BGS(n, NULL, W, m, q, mu, 0, 1, r, &it, &e, NULL, WORK), -12);
  assert_int_equal(BGS(n, NULL, W, m, q, mu, 0, 1, r, &it, &e, work, m + 12 * n - 1), -13);
  assert_int_equal(BGS(n, NULL, W, m, q, mu, 0, 1, r, &it, &e, work, m + 12 * n), 1);
  assert_int_equal(BGS(n, NULL, NULL, m, NULL, mu, 0, 1, NULL, NULL, NULL, work, -1), 0);
  assert_int_equal((int)work[0], m + 12 * n);
#define NWT(nc, rows, a, lda, q, mu, al, tol, most, r, it, e, work, lwork, iwork) \
  nsdae_dfcnwt(nc, rows, a, lda, q, mu, al, tol, most, r, it, e, work, lwork, iwork)
  int *iw = s.iwork;
  assert_int_equal(NWT(-1, NULL, W, m, q, mu, 0, 0, 1, r, &it, &e, work, WORK, iw), -1);
  assert_int_equal(NWT(n, bad_rows, W, m, q, mu, 0, 0, 1, r, &it, &e, work, WORK, iw), -2);
  assert_int_equal(NWT(n, NULL, nan, m, q, mu, 0, 0, 1, r, &it, &e, work, WORK, iw), -3);
  assert_int_equal(NWT(n, NULL, W, 1, q, mu, 0, 0, 1, r, &it, &e, work, WORK, iw), -4);
  assert_int_equal(NWT(n, NULL, W, m, nan, mu, 0, 0, 1, r, &it, &e, work, WORK, iw), -5);
  assert_int_equal(NWT(n, NULL, W, m, q, bad_mu, 0, 0, 1, r, &it, &e, work, WORK, iw), -6);
  assert_int_equal(NWT(n, NULL, W, m, q, mu, -1, 0, 1, r, &it, &e, work, WORK, iw), -7);
  assert_int_equal(NWT(n, NULL, W, m, q, mu, INFINITY, 0, 1, r, &it, &e, work, WORK, iw), -7);
  assert_int_equal(NWT(n, NULL, W, m, q, mu, 0, -1, 1, r, &it, &e, work, WORK, iw), -8);
  assert_int_equal(NWT(n, NULL, W, m, q, mu, 0, 0, -1, r, &it, &e, work, WORK, iw), -9);
  assert_int_equal(NWT(n, NULL, W, m, q, mu, 0, 0, 1, NULL, &it, &e, work, WORK, iw), -10);
  assert_int_equal(NWT(n, NULL, W, m, q, mu, 0, 0, 1, r, NULL, &e, work, WORK, iw), -11);
  assert_int_equal(NWT(n, NULL, W, m, q, mu, 0, 0, 1, r, &it, NULL, work, WORK, iw), -12);
  assert_int_equal(NWT(n, NULL, W, m, q, mu, 0, 0, 1, r, &it, &e, NULL, WORK, iw), -13);
  assert_int_equal(NWT(n, NULL, W, m, q, mu, 0, 0, 1, r, &it, &e, work, m, iw), -14);
  assert_int_equal(NWT(n, NULL, W, m, q, mu, 0, 0, 1, r, &it, &e, work, WORK, NULL), -15);
  assert_int_equal(NWT(n, NULL, NULL, m, NULL, mu, 0, 0, 1, NULL, NULL, NULL, work, -1, NULL), 0);
  assert_int_equal((int)work[0], m * (m + 3));
}

/* Products that overflow, impulses without bounds: said, never 0. */
static void test_overflow(void **state)
{
  (void)state;
  sample s;
  draw_sample(&s, 3, 3, 1);
  for (int i = 0; i < s.m * s.m; i++) s.W[i] *= 1e-300;
  for (int i = 0; i < s.m; i++) s.q[i] = -1e200;
  assert_int_equal(sweeps(&s, 0, 50), 3);
  memset(s.r, 0, sizeof s.r);
  assert_int_not_equal(newton(&s, 0, 0, 50), 0);
  assert_int_equal(nsdae_dfccon(3, s.W, s.m, s.q, 0.5, s.r, s.u, &s.residual), 2);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_one_contact), cmocka_unit_test(test_random_contacts),
      cmocka_unit_test(test_residual),    cmocka_unit_test(test_methods_agree),
      cmocka_unit_test(test_singular),    cmocka_unit_test(test_arguments),
      cmocka_unit_test(test_overflow),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
