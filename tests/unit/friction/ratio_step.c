/* The stride along a drift: to the first change of state of those that drift much and no further,
 * inside the cones, y with it; and none where sweeps do not drift. */
#include "check.h"

#include <nsdae/nsdae.h>
#include <stdlib.h>

#include "anderson.h"
#include "cone.h"
#include "friction_families.h"
#include "solver_island.h"

#include "../linalg/random_matrices.h"

enum { CONTACTS = 80, ENOUGH = 20, SEEDS = 200 };

typedef struct island {
  solver_island at;
  nsdae_arena work;
  nsdae_fc_anderson anderson;
  double *old, *way; /* 3 n: r before the stride, and along what */
} island;

static random_state draws = {11};

static void lay_out(void *object, nsdae_arena *arena)
{
  island *s = object;
  nsdae_fc_anderson_layout(&s->anderson, &s->at.run.island.fc, arena);
  s->old = NSDAE_ARENA_DOUBLES(arena, 3L * s->at.run.island.fc.n);
  s->way = NSDAE_ARENA_DOUBLES(arena, 3L * s->at.run.island.fc.n);
}

/* A point of the cones: inside, on them, or zero. */
static void draw_impulse(double mu, double *r)
{
  double angle = 4 * random_number(&draws), place = random_number(&draws);
  double share = place > 0.2 ? 1 : 0.9 * fabs(random_number(&draws));
  r[0] = place < -0.6 ? 0 : 0.1 + fabs(random_number(&draws));
  r[1] = share * mu * r[0] * cos(angle);
  r[2] = share * mu * r[0] * sin(angle);
  nsdae_fc_project(mu, r);
}

/* At random impulses, with a drift of which items have parts of any size. */
static void make(island *s, const friction_sample *sample)
{
  *s = (island){.old = NULL};
  solver_island_make(&s->at, &sample->problem);
  assert_int_equal(nsdae_arena_fit(&s->work, lay_out, s), NSDAE_OK);
  nsdae_fc_scaled *c = &s->at.run.island.fc;
  double size = pow(10, -1.5 + 1.5 * random_number(&draws));
  for (int k = 0; k < c->n; k++) {
    draw_impulse(c->items.mu[k], c->r + 3 * k);
    for (int j = 0; j < 3; j++)
      s->way[3 * k + j] = size * pow(0.3, k % 4) * random_number(&draws) / c->items.weight[k];
  }
  size_t bytes = 3 * (size_t)c->n * sizeof *c->r;
  memcpy(s->old, c->r, bytes);
  nsdae_fc_anderson_begin(&s->anderson);
  memcpy(s->anderson.before, s->way, bytes);
  memset(s->anderson.share, 0, sizeof s->anderson.share);
  s->anderson.held = NSDAE_FC_WINDOW;
  s->anderson.begun = 1;
  s->anderson.left = 1;
  nsdae_fc_velocities(c, c->r, c->y, c->u);
}

static void release(island *s)
{
  nsdae_arena_release(&s->work);
  solver_island_release(&s->at);
}

static double drift_of(const island *s, int k)
{
  double most = 0;
  for (int j = 0; j < 3; j++)
    most = fmax(most, s->at.run.island.fc.items.weight[k] * fabs(s->way[3 * k + j]));
  return most;
}

/* Whether item k is inside its cone after t sweeps, mu r_N - |r_T| >= 0. */
static int inside(const island *s, int k, double t)
{
  double x[3], mu = s->at.run.island.fc.items.mu[k];
  for (int j = 0; j < 3; j++) x[j] = s->old[3 * k + j] + t * s->way[3 * k + j];
  return x[0] >= 0 && hypot(x[1], x[2]) <= mu * x[0];
}

/* Whether one of those that drift much has changed its state after t sweeps: opened, or, of those
 * that did not slide, left its cone. */
static int changed(const island *s, double t)
{
  double most = 0;
  for (int k = 0; k < s->at.run.island.fc.n; k++) most = fmax(most, drift_of(s, k));
  for (int k = 0; k < s->at.run.island.fc.n; k++) {
    const double *r = s->old + 3 * k, mu = s->at.run.island.fc.items.mu[k];
    if (drift_of(s, k) < 0.1 * most || !(r[0] > 0)) continue;
    if (r[0] + t * s->way[3 * k] < 0) return 1;
    if (hypot(r[1], r[2]) < 0.99 * mu * r[0] && !inside(s, k, t)) return 1;
  }
  return 0;
}

/* The sweeps of the stride, of the first item that went straight on; 0: there is none. */
static double length(const island *s)
{
  for (int k = 0; k < s->at.run.island.fc.n; k++) {
    const double *r = s->at.run.island.fc.r + 3 * k, *old = s->old + 3 * k, *way = s->way + 3 * k;
    const double t = (r[0] - old[0]) / way[0];
    if (t > 0 && fabs(r[1] - old[1] - t * way[1]) + fabs(r[2] - old[2] - t * way[2]) <= 1e-9)
      return t;
  }
  return 0;
}

static void check_stride(const island *s)
{
  const nsdae_fc_scaled *c = &s->at.run.island.fc;
  const double t = length(s);
  double *y = calloc((size_t)c->ny, sizeof *y), *u = calloc(3 * (size_t)c->n, sizeof *u);
  assert_true(t > 1 && t <= 300 * (1 + 1e-9));
  assert_false(changed(s, 0.999 * t));
  assert_true(changed(s, 1.001 * t) || t > 299.9);
  for (int k = 0; k < c->n; k++) {
    double x[3];
    for (int j = 0; j < 3; j++) x[j] = s->old[3 * k + j] + t * s->way[3 * k + j];
    nsdae_fc_project(c->items.mu[k], x);
    for (int j = 0; j < 3; j++) assert_near(c->r[3 * k + j], x[j], 1e-9 * (1 + t * drift_of(s, k)));
  }
  nsdae_fc_velocities(c, c->r, y, u);
  double most = 0;
  for (int i = 0; i < c->ny; i++) most = fmax(most, fabs(y[i]));
  for (int i = 0; i < c->ny; i++) assert_near(c->y[i], y[i], 1e-12 * most);
  assert_int_equal(s->anderson.held, 0);
  assert_int_equal(s->anderson.begun, 0);
  free(y);
  free(u);
}

/* 1 where r went on, 0 where the first change was too near. */
static int stride(island *s)
{
  nsdae_fc_ratio_step(&s->anderson, &s->at.run.island.fc);
  if (s->at.run.island.fc.n < ENOUGH)
    return -1; /* a part of the sample: who goes straight on may be nobody */
  if (memcmp(s->at.run.island.fc.r, s->old, 3 * (size_t)s->at.run.island.fc.n * sizeof *s->old) !=
      0) {
    check_stride(s);
    return 1;
  }
  assert_true(changed(s, 1.001));
  return 0;
}

static void test_strides(void **state)
{
  (void)state;
  int strides = 0, far = 0, none = 0;
  for (unsigned seed = 0; seed < SEEDS; seed++) {
    friction_sample sample = {0};
    island s;
    friction_sample_draw(&sample, (int)seed % FRICTION_FAMILIES, CONTACTS, seed);
    make(&s, &sample);
    int found = stride(&s);
    strides += found == 1;
    none += found == 0;
    far += found == 1 && length(&s) > 10;
    release(&s);
    friction_sample_release(&sample);
  }
  print_message("%d strides, %d of more than ten sweeps, %d too short\n", strides, far, none);
  assert_true(strides > SEEDS / 4 && far > 0 && none > 0);
}

/* Too few sweeps remembered, a sweep of which much was taken, or NaN: none; and where all is as it
 * should be, one. */
static void test_no_drift(void **state)
{
  (void)state;
  const double left[] = {1, 0.97, NAN, 0.99};
  for (int k = 0; k < 4; k++) {
    friction_sample sample = {0};
    island s;
    friction_sample_draw(&sample, FRICTION_WALL, CONTACTS, 3);
    draws.seed = 7;
    make(&s, &sample);
    int held = s.anderson.held -= k == 0;
    s.anderson.left = left[k];
    nsdae_fc_ratio_step(&s.anderson, &s.at.run.island.fc);
    int same =
        memcmp(s.at.run.island.fc.r, s.old, 3 * (size_t)s.at.run.island.fc.n * sizeof *s.old) == 0;
    assert_int_equal(same, k < 3);
    assert_int_equal(s.anderson.held, k < 3 ? held : 0);
    release(&s);
    friction_sample_release(&sample);
  }
}

static double dot(int n, const double *a, const double *b)
{
  double sum = 0;
  for (int i = 0; i < n; i++) sum += a[i] * b[i];
  return sum;
}

/* x without its part along each of the columns, which are made orthogonal on the way. */
static void leave_out(int n, int columns, double *A, double *x)
{
  for (int k = 0; k < columns; k++) {
    double *a = A + (size_t)k * (size_t)n;
    for (int pass = 0; pass < 2; pass++)
      for (int j = 0; j < k; j++) {
        const double *b = A + (size_t)j * (size_t)n, by = dot(n, a, b) / dot(n, b, b);
        for (int i = 0; i < n; i++) a[i] -= by * b[i];
      }
    const double by = dot(n, a, x) / dot(n, a, a);
    for (int i = 0; i < n; i++) x[i] -= by * a[i];
  }
}

/* What is left of a sweep is what none of the differences of the sweeps before makes up. */
static void check_left(island *s, int n, double *f[], int done)
{
  int held = s->anderson.held;
  double *A = calloc((size_t)(held * n) + 1, sizeof *A), *x = calloc((size_t)n, sizeof *x);
  for (int k = 0; k < held; k++)
    for (int i = 0; i < n; i++) A[k * n + i] = f[done - k][i] - f[done - k - 1][i];
  memcpy(x, f[done], (size_t)n * sizeof *x);
  leave_out(n, held, A, x);
  const double square = dot(n, f[done], f[done]);
  assert_near(s->anderson.left, dot(n, x, x) / square, 1e-6);
  nsdae_fc_anderson_remainder(&s->anderson, &s->at.run.island.fc);
  for (int i = 0; i < n; i++) assert_near(s->anderson.before[i], x[i], 1e-4 * sqrt(square));
  free(A);
  free(x);
}

/* Of real sweeps, whose f the test takes itself. */
static void test_left(void **state)
{
  (void)state;
  enum { SWEEPS = 30 };
  int full = 0;
  for (unsigned seed = 0; seed < 12; seed++) {
    friction_sample sample = {0};
    island s;
    double *f[SWEEPS];
    friction_sample_draw(&sample, (int)seed % FRICTION_FAMILIES, CONTACTS, seed);
    make(&s, &sample);
    const int n = 3 * s.at.run.island.fc.n;
    int done = 0;
    double *slip = calloc((size_t)s.at.run.island.fc.n, sizeof *slip);
    nsdae_fc_sweep_begin(&s.at.run.island.fc);
    nsdae_fc_anderson_begin(&s.anderson);
    for (int k = 0; k < SWEEPS; k++) {
      f[k] = calloc((size_t)n, sizeof *f[k]);
      memcpy(s.old, s.at.run.island.fc.r, (size_t)n * sizeof *s.old);
      nsdae_fc_anderson_sweep(&s.anderson, &s.at.run.island.fc, slip);
      for (int i = 0; i < n; i++) f[k][i] = s.at.run.island.fc.r[i] - s.old[i];
      done++;
      if (!(dot(n, f[k], f[k]) > 1e-16)) break;
      nsdae_fc_anderson_extrapolate(&s.anderson, &s.at.run.island.fc);
      if (s.anderson.held > 0) check_left(&s, n, f, k);
      full += s.anderson.held == NSDAE_FC_WINDOW;
    }
    for (int k = 0; k < done; k++) free(f[k]);
    free(slip);
    release(&s);
    friction_sample_release(&sample);
  }
  assert_true(full > 50);
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_strides),
                                     cmocka_unit_test(test_no_drift), cmocka_unit_test(test_left)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
