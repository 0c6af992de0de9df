/* A guess is never worse than none: seeded problems whose forces have changed a little, from the
 * impulses of before, by a residual of the test's own; and ten consecutive steps of a pile under
 * gravity that was tilted, with far less work than from nothing (skipped where they are not
 * there). */
#include "check.h"

#include <hdf5.h>
#include <nsdae/nsdae.h>
#include <stdio.h>
#include <stdlib.h>

#include "../unit/linalg/random.h"
#include "friction_families.h"

#ifndef NSDAE_TEST_SHARE
#define NSDAE_TEST_SHARE 1
#endif

enum { SEEDS = NSDAE_TEST_SHARE > 1 ? 12 : 48, LEAST = 30, MOST = 90, STEPS = 10 };

/* ROUNDING: what scaling changes of a residual (lib/friction/solve.c). */
static const double TOL = 1e-4, ROUNDING = 1e-9;

/* In sweeps: a Newton step costs less than a hundred of them. */
static double work(const nsdae_friction_info *info)
{
  return (double)info->sweeps + 100.0 * info->iterations;
}

static int solve(const nsdae_friction_problem *p, double *r, nsdae_friction_info *info)
{
  double *u = calloc(3 * (size_t)p->contacts + 1, sizeof *u);
  nsdae_friction_options options;
  nsdae_friction_options_default(&options);
  options.tol = TOL;
  int status = nsdae_friction_solve(p, &options, r, u, info);
  free(u);
  return status;
}

/* Every force by up to so much of itself. */
static void change_forces(friction_sample *s, double by, random_state *draws)
{
  int n = 0;
  for (int b = 0; b < s->problem.blocks; b++) n += s->problem.size[b];
  for (int i = 0; i < n; i++) s->f[i] *= 1 + by * random_number(draws);
}

static void test_changed(void **state)
{
  (void)state;
  random_state draws = {5};
  double warm_work = 0, cold_work = 0;
  int solved = 0;
  for (int seed = 0; seed < SEEDS; seed++) {
    friction_sample s = {0};
    nsdae_friction_info info, cold_info;
    friction_sample_draw(&s, seed % FRICTION_FAMILIES, LEAST + (MOST - LEAST) * seed / SEEDS,
                         (unsigned)seed);
    double *warm = calloc(3 * (size_t)s.problem.contacts + 1, sizeof *warm);
    double *cold = calloc(3 * (size_t)s.problem.contacts + 1, sizeof *cold);
    if (solve(&s.problem, warm, &info) == NSDAE_OK) {
      change_forces(&s, 0.02, &draws);
      int found = solve(&s.problem, warm, &info), nothing = solve(&s.problem, cold, &cold_info);
      assert_true(found == NSDAE_OK || nothing != NSDAE_OK);
      if (found == NSDAE_OK)
        assert_at_most(friction_sample_residual(&s, warm, NULL), TOL + ROUNDING);
      solved += found == NSDAE_OK;
      warm_work += work(&info);
      cold_work += work(&cold_info);
    }
    free(warm);
    free(cold);
    friction_sample_release(&s);
  }
  print_message("%d of %d, work warm / cold %.3f\n", solved, SEEDS, warm_work / cold_work);
  assert_true(solved >= 0.99 * SEEDS);
  assert_true(warm_work < cold_work);
}

/* A step of the sequence, and what makes a contact the same as before. */
typedef struct instant {
  nsdae_friction_file file;
  int contacts, *key[3]; /* the two bodies, and its number between them */
  double *r;
} instant;

static int read_keys(const char *path, instant *s)
{
  static const char *const names[] = {"/contacts/geom1", "/contacts/geom2", "/contacts/index"};
  hid_t file = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT);
  int good = file >= 0;
  for (int k = 0; k < 3 && good; k++) {
    hid_t set = H5Dopen2(file, names[k], H5P_DEFAULT);
    s->key[k] = calloc((size_t)s->contacts + 1, sizeof *s->key[k]);
    good = set >= 0 && H5Dread(set, H5T_NATIVE_INT, H5S_ALL, H5S_ALL, H5P_DEFAULT, s->key[k]) >= 0;
    if (set >= 0) H5Dclose(set);
  }
  if (file >= 0) H5Fclose(file);
  return good;
}

/* 0 where there is no such file. */
static int read_instant(int number, instant *s)
{
  char path[512];
  snprintf(path, sizeof path, "%s/friction/seq_mixed_1000/step%02d.hdf5", NSDAE_SHARED_DIR, number);
  FILE *stream = fopen(path, "rb");
  *s = (instant){.contacts = 0};
  if (!stream) return 0;
  fclose(stream);
  assert_int_equal(nsdae_friction_read(path, &s->file, NULL), NSDAE_OK);
  s->contacts = s->file.problem.contacts;
  s->r = calloc(3 * (size_t)s->contacts + 1, sizeof *s->r);
  assert_true(read_keys(path, s));
  return 1;
}

static void release_instant(instant *s)
{
  nsdae_friction_file_release(&s->file);
  for (int k = 0; k < 3; k++) free(s->key[k]);
  free(s->r);
}

/* Impulses of the contacts that there were before. */
static void hand_on(const instant *before, instant *s)
{
  for (int c = 0; c < s->contacts; c++)
    for (int b = 0; b < before->contacts; b++)
      if (s->key[0][c] == before->key[0][b] && s->key[1][c] == before->key[1][b] &&
          s->key[2][c] == before->key[2][b])
        memcpy(s->r + 3 * c, before->r + 3 * b, 3 * sizeof *s->r);
}

static void expect_solved(const instant *s, const double *r)
{
  double residual = 1;
  assert_int_equal(nsdae_friction_residual(&s->file.problem, r, NULL, &residual), NSDAE_OK);
  assert_at_most(residual, TOL);
}

static int compare(const void *a, const void *b)
{
  double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

/* From a solution that was found cold, and from one that was found so itself. */
static void follow(int from_cold)
{
  instant before, now;
  double ratio[STEPS];
  if (!read_instant(0, &before)) skip();
  nsdae_friction_info warm, cold;
  assert_int_equal(solve(&before.file.problem, before.r, &cold), NSDAE_OK);
  for (int k = 1; k < STEPS; k++) {
    assert_true(read_instant(k, &now));
    double *r = calloc(3 * (size_t)now.contacts + 1, sizeof *r);
    assert_int_equal(solve(&now.file.problem, r, &cold), NSDAE_OK);
    hand_on(&before, &now);
    assert_int_equal(solve(&now.file.problem, now.r, &warm), NSDAE_OK);
    expect_solved(&now, r);
    expect_solved(&now, now.r);
    ratio[k - 1] = work(&warm) / work(&cold);
    assert_true(ratio[k - 1] < 1);
    if (from_cold) memcpy(now.r, r, 3 * (size_t)now.contacts * sizeof *r);
    free(r);
    release_instant(&before);
    before = now;
  }
  release_instant(&before);
  qsort(ratio, STEPS - 1, sizeof *ratio, compare);
  print_message("work warm / cold %.3f in the median, %.3f at most\n", ratio[STEPS / 2 - 1],
                ratio[STEPS - 2]);
  assert_at_most(ratio[STEPS / 2 - 1], 0.1);
}

static void test_sequence(void **state)
{
  (void)state;
  if (NSDAE_TEST_SHARE > 1) skip();
  follow(1);
}

static void test_sequence_warm(void **state)
{
  (void)state;
  if (NSDAE_TEST_SHARE > 1) skip();
  follow(0);
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_changed),
                                     cmocka_unit_test(test_sequence),
                                     cmocka_unit_test(test_sequence_warm)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
