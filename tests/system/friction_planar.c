/* Planar and frictionless problems are complementarity problems too: what one chain solves, the
 * other one's certificate says is solved, and where the solution is unique both hand over the same.
 *
 * For contacts of rows N and T with u = W r + q the unknowns of the complementarity problem are
 * r_N, beta+, beta- >= 0 with r_T = beta+ - beta-, and lambda = |u_T| (Stewart and Trinkle, Int. J.
 * Numer. Methods Eng. 39 (1996) 2673): u_N,  u_T + lambda,  -u_T + lambda,  mu r_N - beta+ - beta-
 * >= 0, complementary to them. */
#include "check.h"

#include <nsdae/kernels.h>
#include <nsdae/nsdae.h>
#include <stdlib.h>

enum { MOST = 12, DOFS = 3, ROUNDS = 600 };

/* Two residuals of the same point, one per row and one per contact: each within tol by its own
 * scale, which differ by the ratio of the sizes of the rows, below 1e3 here. */
static const double other = 1e-7;

/* Contacts with W = J M^-1 J^T + C; items are dense. */
typedef struct planar {
  int contacts, rows; /* 1 or 2 each */
  double W[2 * MOST * 2 * MOST], q[2 * MOST], mu[MOST];
  int of[MOST], first[MOST + 1], block[MOST * MOST];
  double value[2 * MOST * 2 * MOST];
  nsdae_friction_problem friction;
  double A[4 * MOST * 4 * MOST], b[4 * MOST];
  nsdae_lcp_problem lcp;
} planar;

static double uniform(unsigned long long *state, double low, double high)
{
  *state ^= *state >> 12;
  *state ^= *state << 25;
  *state ^= *state >> 27;
  return low + (high - low) * ((double)((*state * 2685821657736338717ull) >> 11) * 0x1p-53);
}

/* Bodies of three freedoms of which each contact touches two, or one and the ground; regular: W is
 * positive definite. */
static void draw(planar *p, int contacts, int rows, int regular, unsigned long long *state)
{
  static double J[2 * MOST][DOFS * MOST], inverse[DOFS * MOST];
  int m = contacts * rows, bodies = regular ? contacts : 1 + contacts / 2;
  *p = (planar){.contacts = contacts, .rows = rows};
  memset(J, 0, sizeof J);
  for (int k = 0; k < DOFS * bodies; k++) inverse[k] = uniform(state, 0.5, 2);
  for (int i = 0; i < m; i++)
    for (int side = 0; side < 2; side++) {
      int body = (int)uniform(state, 0, bodies);
      for (int d = 0; d < DOFS; d++) J[i][DOFS * body + d] = uniform(state, -1, 1);
    }
  for (int i = 0; i < m; i++)
    for (int j = 0; j < m; j++) {
      double sum = regular && i == j ? 0.3 : 0;
      for (int k = 0; k < DOFS * bodies; k++) sum += J[i][k] * inverse[k] * J[j][k];
      p->W[j * m + i] = sum;
    }
  for (int c = 0; c < contacts; c++) p->mu[c] = uniform(state, 0, 0.4);
  /* u = J v of some velocity, so that there is a solution without friction */
  for (int i = 0; i < m; i++) p->q[i] = 0;
  for (int k = 0; k < DOFS * bodies; k++) {
    double v = uniform(state, -1, 1);
    for (int i = 0; i < m; i++) p->q[i] += J[i][k] * v;
  }
}

/* Whether contacts i and j have something to do with each other. */
static int joined(const planar *p, int i, int j)
{
  int m = p->contacts * p->rows, any = i == j;
  for (int c = 0; c < p->rows; c++)
    for (int r = 0; r < p->rows; r++) any |= p->W[(i * p->rows + c) * m + j * p->rows + r] != 0;
  return any;
}

static void make_friction(planar *p)
{
  int m = p->contacts * p->rows, at = 0, count = 0;
  for (int i = 0; i < p->contacts; i++) {
    p->of[i] = p->rows;
    p->first[i] = count;
    for (int j = 0; j < p->contacts; j++) {
      if (!joined(p, i, j)) continue;
      p->block[count++] = j;
      for (int c = 0; c < p->rows; c++)
        for (int r = 0; r < p->rows; r++)
          p->value[at++] = p->W[(i * p->rows + c) * m + j * p->rows + r];
    }
  }
  p->first[p->contacts] = count;
  p->friction = (nsdae_friction_problem){.form = NSDAE_FRICTION_LOCAL,
                                         .contacts = p->contacts,
                                         .rows = p->of,
                                         .mu = p->mu,
                                         .w = p->q,
                                         .first = p->first,
                                         .block = p->block,
                                         .value = p->value};
}

/* Row i of the complementarity problem: sign times row `of` of u, and lambda. */
static void velocity_row(planar *p, int row, int of, double sign, int lambda)
{
  int m = 2 * p->contacts, n = 4 * p->contacts;
  for (int c = 0; c < p->contacts; c++) {
    double normal = p->W[(2 * c) * m + of], along = p->W[(2 * c + 1) * m + of];
    p->A[(4 * c) * n + row] = sign * normal;
    p->A[(4 * c + 1) * n + row] = sign * along;
    p->A[(4 * c + 2) * n + row] = -sign * along;
  }
  p->b[row] = sign * p->q[of];
  if (lambda >= 0) p->A[lambda * n + row] = 1;
}

static void make_lcp(planar *p)
{
  int n = p->rows == 1 ? p->contacts : 4 * p->contacts;
  memset(p->A, 0, sizeof p->A);
  if (p->rows == 1) {
    memcpy(p->A, p->W, (size_t)n * (size_t)n * sizeof *p->A);
    memcpy(p->b, p->q, (size_t)n * sizeof *p->b);
  }
  for (int c = 0; p->rows == 2 && c < p->contacts; c++) {
    velocity_row(p, 4 * c, 2 * c, 1, -1);
    velocity_row(p, 4 * c + 1, 2 * c + 1, 1, 4 * c + 3);
    velocity_row(p, 4 * c + 2, 2 * c + 1, -1, 4 * c + 3);
    p->A[(4 * c) * n + 4 * c + 3] = p->mu[c];
    p->A[(4 * c + 1) * n + 4 * c + 3] = p->A[(4 * c + 2) * n + 4 * c + 3] = -1;
    p->b[4 * c + 3] = 0;
  }
  p->lcp = (nsdae_lcp_problem){.n = n, .A = p->A, .lda = n, .b = p->b};
}

/* From the unknowns of one to those of the other. */
static void to_impulses(const planar *p, const double *x, double *r)
{
  for (int c = 0; c < p->contacts; c++) {
    r[c * p->rows] = x[p->rows == 1 ? c : 4 * c];
    if (p->rows == 2) r[2 * c + 1] = x[4 * c + 1] - x[4 * c + 2];
  }
}

static void to_unknowns(const planar *p, const double *r, const double *u, double *x)
{
  for (int c = 0; c < p->contacts; c++) {
    x[p->rows == 1 ? c : 4 * c] = fmax(r[c * p->rows], 0);
    if (p->rows == 1) continue;
    x[4 * c + 1] = fmax(r[2 * c + 1], 0);
    x[4 * c + 2] = fmax(-r[2 * c + 1], 0);
    x[4 * c + 3] = fabs(u[2 * c + 1]);
  }
}

typedef struct tally {
  int both, only_lcp, only_friction, neither, pivoted;
} tally;

/* The friction chain's own way into the other one: solved by its certificate, exactly. */
static int pivots(const nsdae_friction_problem *p, double *r, double *u)
{
  nsdae_friction_options options;
  nsdae_friction_info info;
  nsdae_friction_options_default(&options);
  options.tol = 1e-12;
  options.stages = NSDAE_FRICTION_TRIVIAL | NSDAE_FRICTION_AS_LCP;
  if (nsdae_friction_solve(p, &options, r, u, &info) != NSDAE_OK) return 0;
  assert_int_equal(info.sweeps + info.iterations, 0);
  return 1;
}

static void compare(planar *p, int unique, tally *t)
{
  double x[4 * MOST] = {0}, y[4 * MOST], r[2 * MOST] = {0}, u[2 * MOST], z[4 * MOST];
  double mapped[2 * MOST], work[4 * MOST], residual;
  make_friction(p);
  make_lcp(p);
  nsdae_friction_options options;
  nsdae_friction_options_default(&options);
  options.tol = 1e-12;
  options.stages = NSDAE_FRICTION_ALL & ~NSDAE_FRICTION_AS_LCP; /* which is the other chain */
  int of_lcp = nsdae_lcp_solve(&p->lcp, NULL, x, y, NULL);
  int of_friction = nsdae_friction_solve(&p->friction, &options, r, u, NULL);
  to_impulses(p, x, mapped);
  if (of_lcp == NSDAE_OK) {
    assert_int_equal(nsdae_friction_residual(&p->friction, mapped, NULL, &residual), NSDAE_OK);
    assert_true(residual <= other);
    assert_int_not_equal(of_friction, NSDAE_E_INFEASIBLE);
  }
  if (of_friction == NSDAE_OK) {
    to_unknowns(p, r, u, z);
    assert_int_equal(nsdae_dlcpres(p->lcp.n, p->A, p->lcp.n, p->b, z, y, &residual, work), 0);
    assert_true(residual <= other);
    assert_int_not_equal(of_lcp, NSDAE_E_INFEASIBLE);
  }
  int both = of_lcp == NSDAE_OK && of_friction == NSDAE_OK;
  for (int i = 0; unique && both && i < p->contacts * p->rows; i++)
    assert_near(r[i], mapped[i], 1e-8);
  int pivoted = pivots(&p->friction, mapped, u);
  t->pivoted += pivoted;
  for (int i = 0; unique && pivoted && i < p->contacts * p->rows; i++)
    assert_near(r[i], mapped[i], 1e-8);
  t->both += both;
  t->only_lcp += of_lcp == NSDAE_OK && !both;
  t->only_friction += of_friction == NSDAE_OK && !both;
  t->neither += of_lcp != NSDAE_OK && of_friction != NSDAE_OK;
}

/* Frictionless and regular: one solution. Planar: r need not be unique. */
static void test_agree(void **state)
{
  (void)state;
  static planar p;
  unsigned long long seed = 20;
  for (int rows = 1; rows <= 2; rows++)
    for (int regular = 0; regular < 2; regular++) {
      tally t = {0};
      for (int k = 0; k < ROUNDS; k++) {
        int contacts = 1 + (int)uniform(&seed, 0, MOST);
        draw(&p, contacts, rows, regular, &seed);
        compare(&p, rows == 1 && regular, &t);
      }
      print_message("%d rows, %s: %d by both, %d and %d by one, %d by none; %d by pivoting\n", rows,
                    regular ? "regular" : "singular", t.both, t.only_lcp, t.only_friction,
                    t.neither, t.pivoted);
      assert_true(t.both >= 0.98 * ROUNDS && t.pivoted >= 0.98 * ROUNDS);
    }
}

/* Bilateral rows beside frictionless contacts, W positive definite: one solution. */
static void test_bilateral(void **state)
{
  (void)state;
  static planar p;
  unsigned long long seed = 41;
  for (int k = 0; k < ROUNDS; k++) {
    double r[MOST], u[MOST], pivoted[MOST];
    int contacts = 2 + (int)uniform(&seed, 0, MOST - 1), bilateral = 1 + k % (contacts - 1);
    draw(&p, contacts, 1, 1, &seed);
    make_friction(&p);
    p.friction.contacts -= bilateral;
    p.friction.bilateral = bilateral;
    nsdae_friction_options options;
    nsdae_friction_options_default(&options);
    options.tol = 1e-12;
    options.stages = NSDAE_FRICTION_ALL & ~NSDAE_FRICTION_AS_LCP;
    memset(r, 0, sizeof r);
    assert_int_equal(nsdae_friction_solve(&p.friction, &options, r, u, NULL), NSDAE_OK);
    assert_true(pivots(&p.friction, pivoted, u));
    for (int i = 0; i < contacts; i++) assert_near(r[i], pivoted[i], 1e-8);
  }
}

/* u_1 + u_2 = -2 < 0 whatever r: neither has a solution. */
static void test_neither(void **state)
{
  (void)state;
  planar p = {.contacts = 2, .rows = 1, .W = {1, -1, -1, 1}, .q = {-1, -1}};
  double x[2] = {0}, y[2], r[2] = {0}, u[2];
  make_friction(&p);
  make_lcp(&p);
  assert_int_equal(nsdae_lcp_solve(&p.lcp, NULL, x, y, NULL), NSDAE_E_INFEASIBLE);
  int status = nsdae_friction_solve(&p.friction, NULL, r, u, NULL);
  assert_int_equal(status, NSDAE_E_INFEASIBLE);
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_agree), cmocka_unit_test(test_bilateral),
                                     cmocka_unit_test(test_neither)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
