/* The saddle-point matrix against LAPACK on the whole of it, and where Phi_q has deficient rank. */
#include "check.h"

#include <float.h>
#include <lapacke.h>
#include <nsdae/status.h>

#include "dense.h"
#include "kkt.h"
#include "support/random.h"

enum { N = 40, M = 50, LDM = N + 2, LDJ = M + 3, RHS = 3, ALL = N + M };

typedef struct problem {
  random_state random;
  int n, m;
  double mass[N * LDM], J[N * LDJ];
  double r[RHS * LDM], c[RHS * LDJ]; /* right-hand sides */
  double x[RHS * LDM], l[RHS * LDJ]; /* solutions */
  nsdae_kkt kkt;
  nsdae_arena arena;
} problem;

static problem p; /* large */

/* One block of n, and rows over it. */
static int ends[2], first[M + 1], block[M];
static size_t squares[2], at[M];
static const nsdae_blocks one = {1, ends, squares};

static nsdae_rows rows_of(double *J, int m, size_t stride)
{
  for (int i = 0; i < M; i++) {
    first[i + 1] = i + 1;
    at[i] = (size_t)i;
  }
  return (nsdae_rows){m, first, block, at, stride, J};
}

static void layout(void *object, nsdae_arena *arena)
{
  nsdae_kkt_layout(object, arena);
}

static void begin(int n, int m, double rank_tol)
{
  p.n = n;
  p.m = m;
  ends[1] = n;
  squares[1] = (size_t)(n * n);
  p.kkt = (nsdae_kkt){.n = n, .m = m, .blocks = &one, .rank_tol = rank_tol};
  assert_int_equal(nsdae_arena_build(&p.arena, layout, &p.kkt), NSDAE_OK);
}

static void end(void)
{
  nsdae_arena_release(&p.arena);
}

/* B^T B / n + 1, with eigenvalues 1 .. 5 or so. */
static void random_mass(void)
{
  static double B[N * N];
  int n = p.n;
  random_matrix(&p.random, n, n, B, N);
  for (int i = 0; i < n; i++)
    for (int j = 0; j < n; j++) {
      double sum = i == j;
      for (int k = 0; k < n; k++) sum += B[i * N + k] * B[j * N + k] / n;
      p.mass[j * LDM + i] = sum;
    }
}

/* m rows that are far from dependent: singular values of order one. */
static void random_rows(int m, double *J, int ldj)
{
  random_matrix(&p.random, m, p.n, J, ldj);
  for (int j = 0; j < p.n; j++)
    for (int i = 0; i < m; i++) J[j * ldj + i] = 0.5 * J[j * ldj + i] / sqrt(p.n) + (i == j);
}

static double at_J(int i, int j)
{
  return p.J[j * LDJ + i];
}

/* r at random, c = Phi_q x0, so that it is consistent. */
static void random_right_hand_side(void)
{
  double x0[N];
  random_matrix(&p.random, p.n, RHS, p.r, LDM);
  for (int k = 0; k < RHS; k++) {
    random_matrix(&p.random, p.n, 1, x0, N);
    for (int i = 0; i < p.m; i++) {
      double sum = 0;
      for (int j = 0; j < p.n; j++) sum += at_J(i, j) * x0[j];
      p.c[k * LDJ + i] = sum;
    }
  }
}

static double packed[N * N];

/* M one column behind another. */
static int factor(nsdae_kkt *kkt, double *J)
{
  const nsdae_rows rows = rows_of(J, kkt->m, LDJ);
  for (int j = 0; j < p.n; j++)
    memcpy(packed + j * p.n, p.mass + j * LDM, (size_t)p.n * sizeof *packed);
  return nsdae_kkt_factor(kkt, packed, &rows);
}

static void factor_and_solve(int rank)
{
  assert_int_equal(factor(&p.kkt, p.J), NSDAE_OK);
  assert_int_equal(p.kkt.rank, rank);
  memcpy(p.x, p.r, sizeof p.x);
  memcpy(p.l, p.c, sizeof p.l);
  assert_int_equal(nsdae_kkt_solve(&p.kkt, RHS, p.x, LDM, p.l, LDJ), NSDAE_OK);
}

static double size_of(const double *a, int n)
{
  double most = 0;
  for (int i = 0; i < n; i++) most = fmax(most, fabs(a[i]));
  return most;
}

/* M x + Phi_q^T l = r and Phi_q x = c, relative to the sizes of their terms. */
static void expect_equations(double tol)
{
  for (int k = 0; k < RHS; k++) {
    const double *x = p.x + k * LDM, *l = p.l + k * LDJ;
    for (int i = 0; i < p.n; i++) {
      double sum = -p.r[k * LDM + i], size = 1;
      for (int j = 0; j < p.n; j++) sum += p.mass[j * LDM + i] * x[j];
      for (int j = 0; j < p.m; j++) {
        sum += at_J(j, i) * l[j];
        size = fmax(size, fabs(at_J(j, i) * l[j]));
      }
      assert_near(sum, 0, tol * size);
    }
    for (int i = 0; i < p.m; i++) {
      double sum = -p.c[k * LDJ + i], row = 0;
      for (int j = 0; j < p.n; j++) {
        sum += at_J(i, j) * x[j];
        row = fmax(row, fabs(at_J(i, j)));
      }
      assert_near(sum, 0, tol * row * (1 + size_of(x, p.n)));
    }
  }
}

/* The whole matrix, [n + m] squared. */
static int whole(double *K)
{
  int all = p.n + p.m;
  memset(K, 0, (size_t)all * (size_t)all * sizeof *K);
  for (int j = 0; j < p.n; j++) {
    for (int i = 0; i < p.n; i++) K[j * all + i] = p.mass[j * LDM + i];
    for (int i = 0; i < p.m; i++) K[j * all + p.n + i] = K[(p.n + i) * all + j] = at_J(i, j);
  }
  return all;
}

static void whole_right_hand_side(double *b)
{
  int all = p.n + p.m;
  for (int k = 0; k < RHS; k++) {
    memcpy(b + k * all, p.r + k * LDM, (size_t)p.n * sizeof *b);
    memcpy(b + k * all + p.n, p.c + k * LDJ, (size_t)p.m * sizeof *b);
  }
}

static void expect_solution(const double *b, double tol)
{
  int all = p.n + p.m;
  for (int k = 0; k < RHS; k++) {
    double size = 1 + size_of(b + k * all, all);
    for (int i = 0; i < p.n; i++) assert_near(p.x[k * LDM + i], b[k * all + i], tol * size);
    for (int i = 0; i < p.m; i++) assert_near(p.l[k * LDJ + i], b[k * all + p.n + i], tol * size);
  }
}

/* All these problems have a condition below 1e2: two stable ways differ by n eps cond. */
static const double well_conditioned = 1e-12;

static void test_against_dgesv(void **state)
{
  (void)state;
  static double K[ALL * ALL], b[RHS * ALL];
  static lapack_int pivot[ALL];
  p.random.seed = 11;
  for (int n = 1; n <= N; n++)
    for (int m = 0; m <= n; m += 1 + n / 10) {
      begin(n, m, 1e-8);
      random_mass();
      random_rows(m, p.J, LDJ);
      random_right_hand_side();
      factor_and_solve(m);
      expect_equations(well_conditioned);
      int all = whole(K);
      whole_right_hand_side(b);
      assert_int_equal(LAPACKE_dgesv(LAPACK_COL_MAJOR, all, RHS, K, all, pivot, b, all), 0);
      expect_solution(b, well_conditioned);
      end();
    }
}

/* The lower triangle of M is enough, and the rows between n and the leading dimension are not
 * read. */
static void test_reads_lower_triangle(void **state)
{
  (void)state;
  p.random.seed = 12;
  for (int n = 3; n <= N; n += 9) {
    begin(n, n / 2, 1e-8);
    random_mass();
    random_rows(n / 2, p.J, LDJ);
    random_right_hand_side();
    factor_and_solve(n / 2);
    double x[N];
    memcpy(x, p.x, (size_t)n * sizeof *x);
    for (int j = 0; j < n; j++) {
      for (int i = 0; i < j; i++) p.mass[j * LDM + i] = NAN;
      for (int i = n; i < LDM; i++) p.mass[j * LDM + i] = NAN;
      for (int i = n / 2; i < LDJ; i++) p.J[j * LDJ + i] = NAN;
    }
    factor_and_solve(n / 2);
    assert_memory_equal(x, p.x, (size_t)n * sizeof *x);
    end();
  }
}

/* M^-1 M x0 = x0, by both calls. */
static void test_mass_alone(void **state)
{
  (void)state;
  p.random.seed = 13;
  for (int n = 1; n <= N; n++) {
    double x0[N], r[N] = {0}, s[N];
    begin(n, 0, 1e-8);
    random_mass();
    random_matrix(&p.random, n, 1, x0, N);
    for (int j = 0; j < n; j++)
      for (int i = 0; i < n; i++) r[i] += p.mass[j * LDM + i] * x0[j];
    memcpy(s, r, sizeof s);
    assert_int_equal(factor(&p.kkt, p.J), NSDAE_OK);
    nsdae_kkt_solve_mass(&p.kkt, r);
    assert_int_equal(nsdae_kkt_solve(&p.kkt, 1, s, N, NULL, 1), NSDAE_OK);
    for (int i = 0; i < n; i++) assert_near(r[i], x0[i], well_conditioned);
    for (int i = 0; i < n; i++) assert_near(s[i], x0[i], well_conditioned);
    end();
  }
}

static void test_mass_not_positive_definite(void **state)
{
  (void)state;
  p.random.seed = 14;
  for (int n = 1; n <= N; n += 3)
    for (int i = 0; i < n; i++) {
      begin(n, 1, 1e-8);
      random_mass();
      random_rows(1, p.J, LDJ);
      p.mass[i * LDM + i] = -1;
      assert_int_equal(factor(&p.kkt, p.J), NSDAE_E_MASS);
      assert_int_equal(p.kkt.pivot, i + 1);
      end();
    }
}

/* Row i of Phi_q is scale[i] times row group[i] of the independent rows J0 [r x n]; the least-norm
 * forces are then  l_i = s_i l0_g / sum_{j in g} s_j^2  with the forces l0 of J0 alone. */
static void grouped(int r, const int *group, const double *scale, double tol, double tol_l)
{
  static double J0[N * LDJ], l0[RHS * LDJ], x0[RHS * LDM];
  double sum[N] = {0};
  int m = p.m;
  random_rows(r, J0, LDJ);
  memcpy(p.J, J0, sizeof J0);
  p.m = r;
  random_right_hand_side();
  nsdae_kkt plain = {.n = p.n, .m = r, .blocks = &one, .rank_tol = 1e-8};
  nsdae_arena arena;
  assert_int_equal(nsdae_arena_build(&arena, layout, &plain), NSDAE_OK);
  assert_int_equal(factor(&plain, J0), NSDAE_OK);
  assert_int_equal(plain.rank, r);
  memcpy(x0, p.r, sizeof x0);
  memcpy(l0, p.c, sizeof l0);
  assert_int_equal(nsdae_kkt_solve(&plain, RHS, x0, LDM, l0, LDJ),
                   NSDAE_OK); /* itself tested against dgesv */
  nsdae_arena_release(&arena);
  static double c0[RHS * LDJ];
  memcpy(c0, p.c, sizeof c0);
  p.m = m;
  for (int i = 0; i < m; i++) {
    sum[group[i]] += scale[i] * scale[i];
    for (int j = 0; j < p.n; j++) p.J[j * LDJ + i] = scale[i] * J0[j * LDJ + group[i]];
    for (int k = 0; k < RHS; k++) p.c[k * LDJ + i] = scale[i] * c0[k * LDJ + group[i]];
  }
  factor_and_solve(r);
  expect_equations(10 * tol); /* sums of up to m products */
  for (int k = 0; k < RHS; k++) {
    double expected[M], size = 1 + size_of(l0 + k * LDJ, r);
    for (int i = 0; i < p.n; i++) assert_near(p.x[k * LDM + i], x0[k * LDM + i], tol * size);
    for (int i = 0; i < m; i++) expected[i] = scale[i] * l0[k * LDJ + group[i]] / sum[group[i]];
    /* relative to the largest: a norm over several units tells no more */
    size = 1 + size_of(expected, m);
    for (int i = 0; i < m; i++) assert_near(p.l[k * LDJ + i], expected[i], tol_l * size);
  }
}

static void test_repeated_rows(void **state)
{
  (void)state;
  p.random.seed = 15;
  for (int n = 1; n <= N; n += 1 + n / 8)
    for (int m = 2; m <= M; m += 1 + m / 5) { /* m > n too */
      int r = m / 2 < n ? m / 2 : n, group[M];
      double scale[M];
      for (int i = 0; i < m; i++) {
        group[i] = i < r ? i : random_int(&p.random, 0, r - 1);
        scale[i] = i < r ? 1 : random_int(&p.random, 1, 3);
      }
      begin(n, m, 1e-8);
      random_mass();
      grouped(r, group, scale, well_conditioned, well_conditioned);
      end();
    }
}

static void test_zero_rows(void **state)
{
  (void)state;
  p.random.seed = 16;
  for (int n = 2; n <= N; n += 1 + n / 8)
    for (int zero = 0; zero <= n; zero++) {
      int group[M];
      double scale[M];
      for (int i = 0; i <= n; i++) { /* n independent rows, and a zero row among them */
        group[i] = i < zero ? i : i == zero ? 0 : i - 1;
        scale[i] = i != zero;
      }
      begin(n, n + 1, 1e-8);
      random_mass();
      grouped(n, group, scale, well_conditioned, well_conditioned);
      end();
    }
}

static void test_only_zero_rows(void **state)
{
  (void)state;
  p.random.seed = 17;
  begin(5, 3, 1e-8);
  random_mass();
  memset(p.J, 0, sizeof p.J);
  random_right_hand_side();
  factor_and_solve(0);
  expect_equations(well_conditioned);
  for (int i = 0; i < 3; i++) assert_true(p.l[i] == 0);
  end();
}

/* Rows in units of their own, 1e-6 .. 1e6: rank and motion do not depend on them. */
static void test_scaled_rows(void **state)
{
  (void)state;
  const double unit[] = {1e-6, 1, 1e6, 1e-3};
  p.random.seed = 18;
  for (int n = 2; n <= N; n += 1 + n / 8) {
    int m = n + 2, group[M];
    double scale[M];
    for (int i = 0; i < m; i++) {
      group[i] = i % n;
      scale[i] = unit[i % 4];
    }
    begin(n, m, 1e-8);
    random_mass();
    /* how the forces are shared is a question of 1e12 squared in condition; the motion is not */
    grouped(n, group, scale, well_conditioned, 1e-8);
    end();
  }
}

/* The same of full rank: no reason to lose anything. */
static void test_scaled_independent_rows(void **state)
{
  (void)state;
  const double unit[] = {1e-6, 1, 1e6, 1e-3};
  p.random.seed = 19;
  for (int n = 1; n <= N; n += 1 + n / 8) {
    int group[M];
    double scale[M];
    for (int i = 0; i < n; i++) {
      group[i] = i;
      scale[i] = unit[i % 4];
    }
    begin(n, n, 1e-8);
    random_mass();
    grouped(n, group, scale, well_conditioned, well_conditioned);
    end();
  }
}

/* Rows that depend on each other in no simple way, Phi_q = C J0, against LAPACK's least norm. */
static void test_against_dgelsd(void **state)
{
  (void)state;
  static double K[ALL * ALL], b[RHS * ALL], J0[N * LDJ], C[N * LDJ], sigma[ALL];
  p.random.seed = 20;
  for (int n = 1; n <= N; n += 1 + n / 6)
    for (int r = 1; r <= n; r += 1 + n / 6) {
      int m = r + random_int(&p.random, 1, M - N);
      begin(n, m, 1e-8);
      random_mass();
      random_rows(r, J0, LDJ);
      random_matrix(&p.random, m, r, C, LDJ);
      for (int i = 0; i < r; i++) C[i * LDJ + i] += 3;
      for (int i = 0; i < m; i++)
        for (int j = 0; j < n; j++) {
          p.J[j * LDJ + i] = 0;
          for (int k = 0; k < r; k++) p.J[j * LDJ + i] += C[k * LDJ + i] * J0[j * LDJ + k];
        }
      random_right_hand_side();
      factor_and_solve(r);
      expect_equations(1e-10); /* cond of C is up to 1e2 or so, and S has its square */
      int all = whole(K);
      lapack_int rank;
      whole_right_hand_side(b);
      /* the gap between the singular values is from 1e-2 to 1e-14 */
      assert_int_equal(
          LAPACKE_dgelsd(LAPACK_COL_MAJOR, all, all, RHS, K, all, b, all, sigma, 1e-10, &rank), 0);
      assert_int_equal(rank, n + r);
      expect_solution(b, 1e-10);
      end();
    }
}

/* J^T = L Y with the columns of Y unit vectors: y_0 = e_0, y_1 = e_1, ..., and the last one at the
 * angle asin(sine) to the span of the others. */
static void rows_at_angle(int m, double sine)
{
  static double L[N * N], Y[N * N];
  int n = p.n;
  memset(Y, 0, sizeof Y);
  for (int j = 0; j + 1 < m; j++) Y[j * N + j] = 1;
  for (int i = 0; i + 1 < m; i++) Y[(m - 1) * N + i] = sqrt((1 - sine * sine) / (m - 1));
  Y[(m - 1) * N + m - 1] = sine;
  for (int j = 0; j < n; j++)
    for (int i = j; i < n; i++) L[j * N + i] = p.mass[j * LDM + i];
  assert_int_equal(nsdae_la_cholesky(n, L, N), 0);
  for (int i = 0; i < m; i++)
    for (int j = 0; j < n; j++) {
      double sum = 0;
      for (int k = 0; k <= j; k++) sum += L[k * N + j] * Y[i * N + k];
      p.J[j * LDJ + i] = sum;
    }
}

static void test_near_dependent(void **state)
{
  (void)state;
  const double sines[] = {1e-4, 1e-7, 1e-10}, tols[] = {1e-3, 1e-5, 1e-8, 1e-11};
  p.random.seed = 21;
  for (int s = 0; s < 3; s++)
    for (int t = 0; t < 4; t++)
      for (int n = 2; n <= N; n += 1 + n / 4)
        for (int m = 2; m <= n; m += 1 + n / 4) {
          begin(n, m, tols[t]);
          random_mass();
          rows_at_angle(m, sines[s]);
          random_right_hand_side();
          factor_and_solve(sines[s] > tols[t] ? m : m - 1);
          /* x has the condition 1 / sine of Y where the row counts; where it does not count, its
           * equation may be missed by the sine (and c is its other half) */
          if (sines[s] > tols[t])
            expect_equations(100 * n * DBL_EPSILON / sines[s]);
          else
            expect_equations(10 * m * sines[s]);
          end();
        }
}

static void diagonal_mass(void)
{
  memset(p.mass, 0, sizeof p.mass);
  for (int i = 0; i < p.n; i++) p.mass[i * LDM + i] = 0.5 + i % 7;
}

/* A diagonal M goes its own way. The entries above the diagonal are not read. */
static void test_diagonal_mass(void **state)
{
  (void)state;
  p.random.seed = 23;
  for (int n = 1; n <= N; n += 3)
    for (int m = 0; m <= n; m += 1 + n / 3) {
      begin(n, m, 1e-8);
      diagonal_mass();
      for (int i = 1; i < n; i++) p.mass[i * LDM] = NAN;
      random_rows(m, p.J, LDJ);
      random_right_hand_side();
      factor_and_solve(m);
      for (int i = 1; i < n; i++) p.mass[i * LDM] = 0;
      expect_equations(100 * n * DBL_EPSILON);
      double r[N];
      memcpy(r, p.r, (size_t)n * sizeof *r);
      nsdae_kkt_solve_mass(&p.kkt, r);
      for (int i = 0; i < n; i++)
        assert_near(r[i] * p.mass[i * LDM + i], p.r[i], 4 * DBL_EPSILON * fabs(p.r[i]));
      end();
    }
}

static void test_diagonal_mass_not_positive(void **state)
{
  (void)state;
  const double wrong[] = {0, -1, NAN, INFINITY};
  for (int i = 0; i < 4; i++)
    for (int n = 1; n <= N; n += 13) {
      begin(n, 0, 1e-8);
      diagonal_mass();
      p.mass[(n - 1) * (LDM + 1)] = wrong[i];
      assert_int_equal(factor(&p.kkt, p.J), NSDAE_E_MASS);
      assert_int_equal(p.kkt.pivot, n);
      end();
    }
}

static void test_nan_does_not_hang(void **state)
{
  (void)state;
  p.random.seed = 22;
  for (int n = 2; n <= N; n += 5) {
    begin(n, 2, 1e-8);
    random_mass();
    random_rows(2, p.J, LDJ);
    p.J[0] = NAN;
    assert_int_equal(factor(&p.kkt, p.J), NSDAE_OK);
    assert_true(p.kkt.rank < 2); /* whatever is said of it, not that all is well */
    p.mass[0] = NAN;
    assert_int_equal(factor(&p.kkt, p.J), NSDAE_E_MASS);
    end();
  }
}

/* B J = J for the range of J, trace B = rank, and a range has all its dimensions in common with
 * itself; with one that lost a direction, one less. */
static void test_range(void **state)
{
  static double B[M * M];
  (void)state;
  for (int rank = 2; rank <= 6; rank++) {
    begin(10, 9, 1e-8);
    random_mass();
    random_rows(rank, p.J, LDJ);
    for (int i = rank; i < p.m; i++) {
      double share[2];
      random_matrix(&p.random, 2, 1, share, 2);
      for (int j = 0; j < p.n; j++)
        p.J[j * LDJ + i] = share[0] * at_J(i % rank, j) + share[1] * at_J((i + 1) % rank, j);
    }
    assert_int_equal(factor(&p.kkt, p.J), NSDAE_OK);
    assert_int_equal(p.kkt.rank, rank);
    nsdae_kkt_basis(&p.kkt, B);
    for (int j = 0; j < p.n; j++)
      for (int i = 0; i < p.m; i++) {
        double sum = 0;
        for (int l = 0; l < p.m; l++) sum += B[l * p.m + i] * at_J(l, j);
        assert_near(sum, at_J(i, j), 1e-12);
      }
    double trace = 0;
    for (int i = 0; i < p.m; i++) trace += B[i * p.m + i];
    assert_near(trace, rank, 1e-12);
    assert_near(nsdae_kkt_common(&p.kkt, B), rank, 1e-12);
    for (int j = 0; j < p.n; j++) /* columns 1 .. rank-1 alone */
      for (int i = 0; i < p.m && (j == 0 || j >= rank); i++) p.J[j * LDJ + i] = 0;
    assert_int_equal(factor(&p.kkt, p.J), NSDAE_OK);
    assert_int_equal(p.kkt.rank, rank - 1);
    assert_near(nsdae_kkt_common(&p.kkt, B), rank - 1, 1e-12);
    end();
  }
}

/* With the basis of its own rank a factorisation has the same solution; moved within that rank, the
 * equations of the combinations hold and l is one of them. Also if Cholesky's method sees no sine.
 */
static void test_factor_in(void **state)
{
  static double B[M * M];
  (void)state;
  p.random.seed = 29;
  for (int rank = 1; rank <= 6; rank++)
    for (int bad = 0; bad < 2; bad++) {
      double scale = bad ? 1e-2 : 1, x[RHS * LDM], l[RHS * LDJ];
      begin(12, 9, 1e-10);
      random_mass();
      random_rows(rank, p.J, LDJ);
      for (int j = 0; j < p.n; j++) /* two rows at a small angle */
        if (rank > 1) p.J[j * LDJ + 1] = at_J(0, j) + scale * at_J(1, j);
      for (int i = rank; i < p.m; i++)
        for (int j = 0; j < p.n; j++) p.J[j * LDJ + i] = at_J(i % rank, j) - 0.5 * at_J(0, j);
      random_right_hand_side();
      factor_and_solve(rank);
      memcpy(x, p.x, sizeof x);
      memcpy(l, p.l, sizeof l);
      assert_int_equal(nsdae_kkt_basis_size(&p.kkt), p.m * p.m);
      nsdae_kkt_basis(&p.kkt, B);
      const nsdae_rows rows = rows_of(p.J, p.m, LDJ);
      assert_int_equal(nsdae_kkt_factor_coupled(&p.kkt, packed, NULL, &rows, B, rank), NSDAE_OK);
      memcpy(p.x, p.r, sizeof p.x);
      memcpy(p.l, p.c, sizeof p.l);
      assert_int_equal(nsdae_kkt_solve(&p.kkt, RHS, p.x, LDM, p.l, LDJ), NSDAE_OK);
      double size = 1;
      for (int k = 0; k < RHS; k++) size = fmax(size, size_of(l + k * LDJ, p.m));
      for (int k = 0; k < RHS; k++) {
        for (int j = 0; j < p.n; j++) assert_near(p.x[k * LDM + j], x[k * LDM + j], 1e-12 * size);
        for (int i = 0; i < p.m; i++)
          assert_near(p.l[k * LDJ + i], l[k * LDJ + i], 1e-12 / scale * size);
      }
      end();
    }
}

/* All rows without a decision: dependent up to 1e-9 they are solved; exactly, refused. */
static void test_factor_in_all_rows(void **state)
{
  (void)state;
  p.random.seed = 30;
  const double sines[] = {1, 1e-4, 1e-7, 1e-9};
  for (int s = 0; s < 4; s++)
    for (int m = 2; m <= 12; m += 2) {
      begin(20, m, 1e-8);
      random_mass();
      rows_at_angle(m, sines[s]);
      random_right_hand_side();
      const nsdae_rows rows = rows_of(p.J, m, LDJ);
      for (int j = 0; j < p.n; j++)
        memcpy(packed + j * p.n, p.mass + j * LDM, (size_t)p.n * sizeof *packed);
      assert_int_equal(nsdae_kkt_factor_coupled(&p.kkt, packed, NULL, &rows, NULL, m), NSDAE_OK);
      memcpy(p.x, p.r, sizeof p.x);
      memcpy(p.l, p.c, sizeof p.l);
      assert_int_equal(nsdae_kkt_solve(&p.kkt, RHS, p.x, LDM, p.l, LDJ), NSDAE_OK);
      expect_equations(100 * p.n * DBL_EPSILON / sines[s]);
      for (int j = 0; j < p.n; j++) p.J[j * LDJ] = 0;
      assert_int_equal(nsdae_kkt_factor_coupled(&p.kkt, packed, NULL, &rows, NULL, m),
                       NSDAE_E_CONVERGENCE);
      end();
    }
}

/* The multipliers of least norm have the same J^T l, and are shortest: adding what J^T takes to
 * nothing, l - l', to them makes them longer as in a right angle. */
static void test_least_norm(void **state)
{
  static double J[N * M], r[N], given[M], l[M];
  (void)state;
  for (int rank = 2; rank <= 6; rank++) {
    begin(12, 9, 1e-8);
    random_mass();
    random_rows(rank, p.J, LDJ);
    for (int i = rank; i < p.m; i++)
      for (int j = 0; j < p.n; j++)
        p.J[j * LDJ + i] = at_J(i % rank, j) - 0.5 * at_J((i + 1) % rank, j);
    for (int i = 0; i < p.m; i++)
      for (int j = 0; j < p.n; j++) J[j * p.m + i] = at_J(i, j);
    assert_int_equal(factor(&p.kkt, p.J), NSDAE_OK);
    assert_int_equal(p.kkt.rank, rank);
    random_matrix(&p.random, p.m, 1, given, M);
    memcpy(l, given, sizeof l);
    const nsdae_rows rows = rows_of(J, p.m, (size_t)p.m);
    assert_int_equal(nsdae_kkt_least_norm(&p.kkt, &rows, l, r), NSDAE_OK);
    for (int j = 0; j < p.n; j++) {
      double before = 0, after = 0;
      for (int i = 0; i < p.m; i++) before += at_J(i, j) * given[i], after += at_J(i, j) * l[i];
      assert_near(after, before, 1e-12);
    }
    double angle = 0;
    for (int i = 0; i < p.m; i++) angle += l[i] * (given[i] - l[i]);
    assert_near(angle, 0, 1e-12);
    end();
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_against_dgesv),
      cmocka_unit_test(test_reads_lower_triangle),
      cmocka_unit_test(test_mass_alone),
      cmocka_unit_test(test_mass_not_positive_definite),
      cmocka_unit_test(test_repeated_rows),
      cmocka_unit_test(test_zero_rows),
      cmocka_unit_test(test_only_zero_rows),
      cmocka_unit_test(test_scaled_rows),
      cmocka_unit_test(test_scaled_independent_rows),
      cmocka_unit_test(test_against_dgelsd),
      cmocka_unit_test(test_near_dependent),
      cmocka_unit_test(test_diagonal_mass),
      cmocka_unit_test(test_diagonal_mass_not_positive),
      cmocka_unit_test(test_nan_does_not_hang),
      cmocka_unit_test(test_range),
      cmocka_unit_test(test_least_norm),
      cmocka_unit_test(test_factor_in),
      cmocka_unit_test(test_factor_in_all_rows),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
