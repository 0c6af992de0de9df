/* Problems that have no solution, whatever the friction: bodies between walls that close in on
 * them, at any angle and in rows; bilateral rows that contradict each other. Each proof is checked
 * here in long double. The same problems with walls that leave room are never said to have none. */
#include "check.h"

#include <nsdae/nsdae.h>

#include "../unit/linalg/random_matrices.h"

enum { MOST = 40, DOFS = 3 };

static random_state state_of_draws = {7};

static double draw(void)
{
  return random_number(&state_of_draws);
}

/* Points of three freedoms; contact c touches one or two of them along its frame. */
typedef struct cage {
  nsdae_friction_problem p;
  int size[MOST], first[2 * MOST + 1], block[4 * MOST], parts, rows;
  double M[9 * MOST], f[3 * MOST], mu[2 * MOST], w[6 * MOST], value[36 * MOST];
  double compliance[6 * MOST], r[6 * MOST], u[6 * MOST];
  nsdae_friction_info info;
} cage;

static void begin(cage *s, int bodies)
{
  memset(s, 0, sizeof *s);
  for (int b = 0; b < bodies; b++) {
    s->size[b] = DOFS;
    for (int d = 0; d < DOFS; d++) {
      s->M[9 * b + 4 * d] = 1 + b % 3;
      s->f[3 * b + d] = draw();
    }
  }
  s->p = (nsdae_friction_problem){.mu = s->mu,
                                  .w = s->w,
                                  .blocks = bodies,
                                  .size = s->size,
                                  .M = s->M,
                                  .f = s->f,
                                  .first = s->first,
                                  .block = s->block,
                                  .value = s->value,
                                  .compliance = s->compliance};
}

/* Any two directions across n. */
static void frame(const double *n, double *t)
{
  int k = fabs(n[0]) < 0.6 ? 0 : 1;
  double e[3] = {k == 0, k == 1, 0}, length = 0;
  for (int i = 0; i < 3; i++) t[i] = e[i] - n[k] * n[i];
  for (int i = 0; i < 3; i++) length += t[i] * t[i];
  for (int i = 0; i < 3; i++) t[i] /= sqrt(length);
  for (int i = 0; i < 3; i++)
    t[3 + i] = n[(i + 1) % 3] * t[(i + 2) % 3] - n[(i + 2) % 3] * t[(i + 1) % 3];
}

/* A contact of body b, that moves along n against body a (-1: a wall), which comes with -w. With v
 * [3] the wall moves along with it: at that velocity of b against a there is no slip, and u_N = w.
 */
static void touch(cage *s, int a, int b, const double *n, double w, double mu, const double *v)
{
  double directions[9];
  memcpy(directions, n, 3 * sizeof *n);
  frame(n, directions + 3);
  int c = s->p.contacts++;
  s->mu[c] = mu;
  s->w[3 * c] = w;
  for (int k = 0; k < 9 && v; k++) s->w[3 * c + k / 3] -= directions[k] * v[k % 3];
  for (int side = 0; side < 2; side++) {
    int body = side == 0 ? b : a;
    if (body < 0) continue;
    for (int k = 0; k < 9; k++)
      s->value[9 * s->parts + k] = side == 0 ? directions[k] : -directions[k];
    s->block[s->parts++] = body;
  }
  s->first[c + 1] = s->parts;
}

static int solve(cage *s)
{
  int m = 3 * s->p.contacts + s->p.bilateral;
  memset(s->r, 0, sizeof s->r);
  for (int i = 0; i < m; i++) s->u[i] = NAN;
  return nsdae_friction_solve(&s->p, NULL, s->r, s->u, &s->info);
}

/* l >= 0 in normal rows, zero in tangential ones; H l = 0 to rounding, w . l < 0. */
static void check_proof(const cage *s)
{
  long double sum[3 * MOST] = {0}, product = 0, most = 0;
  int at = 0;
  assert_int_equal(s->info.outcome, NSDAE_OUTCOME_INFEASIBLE);
  assert_int_equal(s->info.proof, NSDAE_PROOF_FARKAS);
  assert_int_equal(s->info.stage, NSDAE_FRICTION_FARKAS);
  for (int i = 0, row = 0; i < s->p.contacts + s->p.bilateral; i++) {
    int rows = i < s->p.contacts ? 3 : 1;
    if (rows == 3) assert_true(s->r[row] >= 0 && s->r[row + 1] == 0 && s->r[row + 2] == 0);
    assert_true(s->r[row] == 0 || s->compliance[row] == 0);
    product += (long double)s->w[row] * s->r[row];
    most = fmaxl(most, fabsl((long double)s->r[row]));
    for (int e = s->first[i]; e < s->first[i + 1]; e++, at += 3 * rows)
      for (int d = 0; d < DOFS; d++)
        sum[3 * s->block[e] + d] += (long double)s->value[at + d] * s->r[row];
    row += rows;
  }
  assert_true(product < 0);
  for (int d = 0; d < 3 * s->p.blocks; d++) assert_true(fabsl(sum[d]) <= 1e-14L * most);
}

static void check_solved(const cage *s, int status)
{
  assert_int_equal(status, NSDAE_OK);
  assert_true(s->info.residual <= 1e-10);
}

/* Three directions and what balances them: a ball between walls that close in, or make room. */
static void test_corners(void **state)
{
  (void)state;
  for (int k = 0; k < 400; k++) {
    cage s;
    double n[4][3], last[3] = {0}, l[3], length = 0;
    begin(&s, 1);
    for (int i = 0; i < 3; i++) {
      double size = 0;
      l[i] = 1.2 + draw();
      for (int d = 0; d < 3; d++) n[i][d] = draw() + (d == i);
      for (int d = 0; d < 3; d++) size += n[i][d] * n[i][d];
      for (int d = 0; d < 3; d++) last[d] -= l[i] * (n[i][d] /= sqrt(size));
    }
    for (int d = 0; d < 3; d++) length += last[d] * last[d];
    for (int d = 0; d < 3; d++) n[3][d] = last[d] / sqrt(length);
    double v[3] = {draw(), draw(), draw()}, room = k % 2 == 0 ? -0.1 : 0.1;
    for (int i = 0; i < 4; i++) touch(&s, -1, 0, n[i], room, 0.3 * (k % 5), v);
    int status = solve(&s);
    if (room > 0)
      check_solved(&s, status);
    else {
      assert_int_equal(status, NSDAE_E_INFEASIBLE);
      check_proof(&s);
    }
  }
}

/* A row of balls between two walls, in any direction; other balls beside it, one on the row. A
 * contact that gives way makes room. */
static void test_rows(void **state)
{
  (void)state;
  for (int k = 0; k < 60; k++) {
    cage s;
    int bodies = 1 + k % 20;
    double n[3] = {draw(), draw(), draw()}, back[3], up[3] = {0, 0, 1}, size = 0;
    for (int d = 0; d < 3; d++) size += n[d] * n[d];
    for (int d = 0; d < 3; d++) back[d] = -(n[d] /= sqrt(size));
    begin(&s, bodies + 1);
    double closing = k % 3 == 1 ? 0.2 : -0.2;
    touch(&s, -1, 0, n, closing, 0.5, NULL);
    for (int b = 1; b < bodies; b++) touch(&s, b - 1, b, n, 0, 0.5, NULL);
    touch(&s, -1, bodies - 1, back, 0, 0.5, NULL);
    touch(&s, 0, bodies, up, 0, 0.5, NULL);
    if (k % 3 == 2) s.compliance[0] = 0.01;
    int status = solve(&s);
    if (k % 3 != 0)
      check_solved(&s, status);
    else {
      assert_int_equal(status, NSDAE_E_INFEASIBLE);
      check_proof(&s);
    }
  }
}

/* One direction held at two velocities, or at one. */
static void test_bilateral(void **state)
{
  (void)state;
  for (int k = 0; k < 20; k++) {
    cage s;
    begin(&s, 1);
    const double up[3] = {0, 0, 1};
    double n[3] = {draw(), draw(), 1};
    touch(&s, -1, 0, up, 0, 0.5, NULL);
    for (int i = 0; i < 2; i++) {
      for (int d = 0; d < 3; d++) s.value[9 + 3 * i + d] = (1 + i) * n[d];
      s.block[s.parts++] = 0;
      s.first[2 + i] = s.parts;
      s.w[3 + i] = -(1 + i + (k % 2) * 0.5 * i);
    }
    s.p.bilateral = 2;
    int status = solve(&s);
    if (k % 2 == 0)
      check_solved(&s, status);
    else {
      assert_int_equal(status, NSDAE_E_INFEASIBLE);
      check_proof(&s);
    }
  }
}

/* The local form: u_1 + u_2 = -2 whatever r; with a third one that is not in it. */
static void test_local(void **state)
{
  (void)state;
  const int rows[] = {1, 1, 1}, first[] = {0, 2, 4, 5}, block[] = {0, 1, 0, 1, 2};
  const double W[] = {1, -1, -1, 1, 1}, mu[3] = {0};
  for (int k = 0; k < 2; k++) {
    const double q[] = {-1, k == 0 ? -1 : 2, -1};
    double r[3] = {0}, u[3];
    nsdae_friction_info info;
    nsdae_friction_problem p = {.form = NSDAE_FRICTION_LOCAL,
                                .contacts = 3,
                                .rows = rows,
                                .mu = mu,
                                .w = q,
                                .first = first,
                                .block = block,
                                .value = W};
    int status = nsdae_friction_solve(&p, NULL, r, u, &info);
    assert_int_equal(status, k == 0 ? NSDAE_E_INFEASIBLE : NSDAE_OK);
    if (k == 1) continue;
    assert_true(r[0] > 0 && r[0] == r[1] && r[2] == 0);
    for (int i = 0; i < 3; i++) assert_near(u[i], q[i], 0); /* those of r = 0 */
  }
}

/* v = v* leaves room in every contact, by little, and slips in none: there is a solution (Acary,
 * Cadoux, Lemarechal, Malick 2011), never is it said that there is none. */
static void test_feasible(void **state)
{
  (void)state;
  int solved = 0;
  for (int k = 0; k < 200; k++) {
    cage s;
    begin(&s, 3);
    double v[9], room = pow(10, -(k % 9));
    for (int d = 0; d < 9; d++) v[d] = draw();
    for (int c = 0; c < 14; c++) {
      double n[3] = {draw(), draw(), draw()}, against[3], size = 0, w = room * (1 + draw());
      int b = c % 3, a = c < 6 ? -1 : (b + 1) % 3;
      for (int d = 0; d < 3; d++) size += n[d] * n[d];
      for (int d = 0; d < 3; d++) {
        n[d] /= sqrt(size);
        against[d] = v[3 * b + d] - (a < 0 ? 0 : v[3 * a + d]);
      }
      touch(&s, a, b, n, w, 0.3, against);
    }
    int status = solve(&s);
    assert_true(status == NSDAE_OK || status == NSDAE_E_LCP);
    solved += status == NSDAE_OK;
  }
  print_message("%d of 200 solved\n", solved);
  assert_true(solved >= 190);
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_corners), cmocka_unit_test(test_rows),
                                     cmocka_unit_test(test_bilateral), cmocka_unit_test(test_local),
                                     cmocka_unit_test(test_feasible)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
