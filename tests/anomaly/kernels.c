/* Every kernel with each argument broken in turn, asked for its workspace, at n = 0, and with NaN
 * and infinities in its data: the documented info, never 0 with a NaN out, never an endless run. */
#include "check.h"

#include <nsdae/kernels.h>

enum { N = 3, WORK = N * (N + 2), IWORK = 3 * N };

/* All arguments of all kernels. */
typedef struct call {
  int n, lda, max, block, lwork;
  double omega, tol;
  double a_[N * N], b_[N], d_[N], x_[N], y_[N], work_[WORK], residual_;
  int basis_[N], iwork_[IWORK], count_, set_;
  double *a, *b, *d, *x, *y, *work, *residual;
  int *basis, *iwork, *count, *set;
} call;

/* Solution x = (1, 0, 2), y = (0, 1, 0). */
static void begin(call *c)
{
  const double A[N * N] = {4, 1, 1, 1, 5, -1, 1, -1, 6}, b[N] = {-6, 2, -13};
  memset(c, 0, sizeof *c);
  c->n = c->lda = N;
  c->max = 100;
  c->block = 10;
  c->lwork = WORK;
  c->omega = 1;
  c->tol = 1e-12;
  memcpy(c->a_, A, sizeof A);
  memcpy(c->b_, b, sizeof b);
  for (int i = 0; i < N; i++) c->d_[i] = 1;
  c->a = c->a_, c->b = c->b_, c->d = c->d_, c->x = c->x_, c->y = c->y_, c->work = c->work_;
  c->residual = &c->residual_, c->basis = c->basis_, c->iwork = c->iwork_, c->count = &c->count_;
  c->set = &c->set_;
}

static int residual(call *c)
{
  return nsdae_dlcpres(c->n, c->a, c->lda, c->b, c->x, c->y, c->residual, c->work);
}

static int lemke(call *c)
{
  return nsdae_dlemke(c->n, c->a, c->lda, c->b, c->d, c->max, c->x, c->basis, c->count, c->work,
                      c->lwork, c->iwork);
}

static int pgs(call *c)
{
  return nsdae_dlcppgs(c->n, c->a, c->lda, c->b, c->omega, c->tol, c->max, c->x, c->count,
                       c->residual, c->work, c->lwork);
}

static int principal(call *c)
{
  return nsdae_dlcpppm(c->n, c->a, c->lda, c->b, c->tol, c->block, c->max, c->x, c->basis, c->count,
                       c->residual, c->work, c->lwork, c->iwork);
}

static int enumerate(call *c)
{
  return nsdae_dlcpenum(c->n, c->a, c->lda, c->b, c->tol, c->set, c->x, c->residual, c->work,
                        c->lwork, c->iwork);
}

/* One way to break an argument: POINTER sets it to NULL, INT and REAL store the value in it, ENTRY
 * in the first entry of the array that it points to. */
enum kind { POINTER, INT, REAL, ENTRY, INT_ENTRY };
typedef struct way {
  int argument;
  enum kind kind;
  size_t at;
  double value;
} way;

static void break_argument(call *c, const way *w)
{
  void *at = (char *)c + w->at;
  switch (w->kind) {
  case POINTER:
    memset(at, 0, sizeof(double *));
    break;
  case INT:
    *(int *)at = (int)w->value;
    break;
  case REAL:
    *(double *)at = w->value;
    break;
  case ENTRY:
    **(double **)at = w->value;
    break;
  case INT_ENTRY:
    **(int **)at = (int)w->value;
    break;
  }
}

#define IN(member) offsetof(call, member)
#define NULL_(i, member)      \
  {                           \
    i, POINTER, IN(member), 0 \
  }
#define INT_(i, member, value) \
  {                            \
    i, INT, IN(member), value  \
  }
#define REAL_(i, member, value) \
  {                             \
    i, REAL, IN(member), value  \
  }
#define ENTRY_(i, member, value) \
  {                              \
    i, ENTRY, IN(member), value  \
  }
#define FINITE_(i, member) ENTRY_(i, member, NAN), ENTRY_(i, member, -INFINITY)
#define MATRIX             INT_(1, n, -1), NULL_(2, a), INT_(3, lda, 2), INT_(3, lda, 0), NULL_(4, b)
#define FINITE_MATRIX      MATRIX, FINITE_(2, a), FINITE_(4, b)

static const way of_residual[] = {MATRIX, NULL_(5, x), NULL_(6, y), NULL_(7, residual),
                                  NULL_(8, work)};
static const way of_lemke[] = {MATRIX,           INT_(1, n, 40000),         ENTRY_(5, d, 0),
                               ENTRY_(5, d, -1), ENTRY_(5, d, NAN),         INT_(6, max, -1),
                               NULL_(7, x),      NULL_(8, basis),           NULL_(9, count),
                               NULL_(10, work),  INT_(11, lwork, WORK - 1), INT_(11, lwork, -2),
                               NULL_(12, iwork)};
static const way of_pgs[] = {
    FINITE_MATRIX,        INT_(1, n, 2147483647), REAL_(5, omega, 0),
    REAL_(5, omega, 2),   REAL_(5, omega, -1),    REAL_(5, omega, NAN),
    REAL_(6, tol, -1e-9), REAL_(6, tol, NAN),     INT_(7, max, -1),
    NULL_(8, x),          FINITE_(8, x),          NULL_(9, count),
    NULL_(10, residual),  NULL_(11, work),        INT_(12, lwork, 2 * N - 1),
    INT_(12, lwork, -2)};
static const way of_principal[] = {FINITE_MATRIX,
                                   INT_(1, n, 40000),
                                   REAL_(5, tol, -1e-9),
                                   REAL_(5, tol, NAN),
                                   INT_(6, block, -1),
                                   INT_(7, max, -1),
                                   NULL_(8, x),
                                   NULL_(9, basis),
                                   {9, INT_ENTRY, IN(basis), 2},
                                   {9, INT_ENTRY, IN(basis), -1},
                                   NULL_(10, count),
                                   NULL_(11, residual),
                                   NULL_(12, work),
                                   INT_(13, lwork, WORK - 1),
                                   INT_(13, lwork, -2),
                                   NULL_(14, iwork)};
static const way of_enumerate[] = {FINITE_MATRIX,
                                   INT_(1, n, 21),
                                   REAL_(5, tol, -1e-9),
                                   REAL_(5, tol, NAN),
                                   NULL_(6, set),
                                   {6, INT_ENTRY, IN(set), -1},
                                   {6, INT_ENTRY, IN(set), (1 << N) + 1},
                                   NULL_(7, x),
                                   NULL_(8, residual),
                                   NULL_(9, work),
                                   INT_(10, lwork, WORK - 1),
                                   INT_(10, lwork, -2),
                                   NULL_(11, iwork)};

#define WAYS(of) of, sizeof of / sizeof *of
static const struct {
  const char *name;
  int (*run)(call *);
  const way *ways;
  size_t count;
  int arguments, work, solves;
} kernels[] = {
    {"nsdae_dlcpres", residual, WAYS(of_residual), 8, 0, 0},
    {"nsdae_dlemke", lemke, WAYS(of_lemke), 12, WORK, 1},
    {"nsdae_dlcppgs", pgs, WAYS(of_pgs), 12, 2 * N, 1},
    {"nsdae_dlcpppm", principal, WAYS(of_principal), 14, WORK, 1},
    {"nsdae_dlcpenum", enumerate, WAYS(of_enumerate), 11, WORK, 1},
};
enum { KERNELS = sizeof kernels / sizeof *kernels };

static void test_good(void **state)
{
  (void)state;
  const double solution[N] = {1, 0, 2};
  for (int k = 0; k < KERNELS; k++) {
    call c;
    begin(&c);
    if (!kernels[k].solves) memcpy(c.x_, solution, sizeof solution);
    assert_int_equal(kernels[k].run(&c), 0);
    for (int i = 0; i < N; i++) assert_near(c.x_[i], solution[i], 1e-11);
    assert_true(c.residual_ <= c.tol);
  }
}

/* Nothing is done: what came in is as it was. */
static void test_each_argument(void **state)
{
  (void)state;
  for (int k = 0; k < KERNELS; k++) {
    unsigned broken = 0;
    for (size_t i = 0; i < kernels[k].count; i++) {
      const way *w = &kernels[k].ways[i];
      call c, before;
      begin(&c);
      break_argument(&c, w);
      before = c;
      int info = kernels[k].run(&c);
      if (info != -w->argument)
        fail_msg("%s, argument %d, way %d: info %d", kernels[k].name, w->argument, (int)i, info);
      assert_memory_equal(&c, &before, sizeof c);
      broken |= 1u << w->argument;
    }
    assert_int_equal(broken, (1u << (kernels[k].arguments + 1)) - 2); /* each was */
  }
}

/* The query needs n and work alone. */
static void test_workspace(void **state)
{
  (void)state;
  for (int k = 0; k < KERNELS; k++) {
    call c;
    if (!kernels[k].solves) continue;
    begin(&c);
    c.lwork = -1;
    c.a = c.b = c.d = c.x = c.residual = NULL;
    c.basis = c.iwork = c.count = c.set = NULL;
    assert_int_equal(kernels[k].run(&c), 0);
    assert_int_equal((int)c.work_[0], kernels[k].work);
    begin(&c);
    c.lwork = kernels[k].work; /* and that is enough */
    assert_int_equal(kernels[k].run(&c), 0);
  }
}

static void test_empty(void **state)
{
  (void)state;
  for (int k = 0; k < KERNELS; k++) {
    call c;
    begin(&c);
    c.n = 0;
    c.lda = 1;
    c.a = c.b = c.d = c.x = c.y = NULL;
    c.basis = NULL;
    c.lwork = 0;
    c.residual_ = 7;
    c.count_ = 7;
    assert_int_equal(kernels[k].run(&c), 0);
    if (kernels[k].run != lemke) assert_true(c.residual_ == 0);
    if (kernels[k].run != residual && kernels[k].run != enumerate) assert_int_equal(c.count_, 0);
    c.lda = 0;
    assert_int_equal(kernels[k].run(&c), -3);
  }
}

/* NaN and infinities in every entry of A, b and x in turn; x only where it comes in. */
static void test_not_finite(void **state)
{
  (void)state;
  const double bad[] = {NAN, INFINITY, -INFINITY};
  for (int k = 0; k < KERNELS; k++)
    for (int i = 0; i < 3 * (N * N + N + N); i++) {
      int at = i / 3, in_x = at >= N * N + N;
      if (in_x && kernels[k].run != residual && kernels[k].run != pgs) continue;
      call c;
      begin(&c);
      *(at < N * N ? &c.a_[at] : in_x ? &c.x_[at - N * N - N] : &c.b_[at - N * N]) = bad[i % 3];
      int info = kernels[k].run(&c);
      if (info == 0)
        fail_msg("%s, entry %d of A, b, x is %g: info 0", kernels[k].name, at, bad[i % 3]);
    }
}

/* Finite data whose products overflow. */
static void test_overflow(void **state)
{
  (void)state;
  for (int k = 0; k < KERNELS; k++) {
    call c;
    begin(&c);
    for (int i = 0; i < N * N; i++) c.a_[i] *= 1e200;
    for (int i = 0; i < N; i++) c.x_[i] = 1e200;
    if (kernels[k].solves) {
      for (int i = 0; i < N * N; i++) c.a_[i] *= 1e-300;
      for (int i = 0; i < N; i++) c.b_[i] *= 1e250;
    }
    int info = kernels[k].run(&c);
    for (int i = 0; i < N && info == 0; i++) assert_true(isfinite(c.x_[i]));
    assert_true(info != 0);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_good),       cmocka_unit_test(test_each_argument),
      cmocka_unit_test(test_workspace),  cmocka_unit_test(test_empty),
      cmocka_unit_test(test_not_finite), cmocka_unit_test(test_overflow),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
