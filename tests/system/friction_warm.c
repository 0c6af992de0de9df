/* A guess helps: seeded problems whose forces have changed a little, from the impulses of before,
 * by a residual of the test's own; and ten consecutive steps of a pile that slides, from the guess
 * of the simulation, with far less work than from nothing. */
#include "check.h"

#include <nsdae/nsdae.h>
#include <stdlib.h>

#include "friction_families.h"
#include "random.h"
#include "run_bodies.h"
#include "walls.h"

enum { SEEDS = 48, LEAST = 30, MOST = 90, STEPS = 10, BOXES = 60 };

/* ROUNDING: what scaling changes of a residual (lib/friction/driver/solve.c). */
static const double TOL = 1e-4, ROUNDING = 1e-9;

/* In sweeps, one at least: a Newton step costs less than a hundred of them. */
static double work(const nsdae_friction_info *info)
{
  return fmax(1, (double)info->sweeps + 100.0 * info->iterations);
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

/* Solved wherever it is from nothing, and with a tenth of the work as a rule: the geometric mean,
 * since sums are those of the hardest one. Spheres take more than from nothing now and then, which
 * is little. */
static void test_changed(void **state)
{
  (void)state;
  double sum = 0;
  int count = 0, solved = 0;
  for (int seed = 0; seed < SEEDS; seed += test_share(), count++) {
    friction_sample s = {0};
    nsdae_friction_info info, cold_info;
    friction_sample_draw(&s, seed % FRICTION_FAMILIES, LEAST + (MOST - LEAST) * seed / SEEDS,
                         (unsigned)seed);
    double *warm = calloc(3 * (size_t)s.problem.contacts + 1, sizeof *warm);
    double *cold = calloc(3 * (size_t)s.problem.contacts + 1, sizeof *cold);
    if (solve(&s.problem, warm, &info) == NSDAE_OK) {
      friction_sample_change(&s, 0.02);
      int found = solve(&s.problem, warm, &info), nothing = solve(&s.problem, cold, &cold_info);
      assert_true(found == NSDAE_OK || nothing != NSDAE_OK);
      if (found == NSDAE_OK)
        assert_at_most(friction_sample_residual(&s, warm, NULL), TOL + ROUNDING);
      solved += found == NSDAE_OK;
      sum += log(work(&info) / work(&cold_info));
    }
    free(warm);
    free(cold);
    friction_sample_release(&s);
  }
  const double mean = exp(sum / solved);
  print_message("%d of %d, work warm / cold %.3f\n", solved, count, mean);
  assert_true(solved >= 0.99 * count);
  assert_at_most(mean, 0.25);
}

static int compare(const void *a, const void *b)
{
  double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

/* Boxes of several sizes in layers of 3 x 4 between walls, every second layer shifted by half a
 * box, each turned about the vertical, under gravity that is tilted by 20 degrees. */
static nsdae_bodies *make_pile(void)
{
  const double g = 9.81, tilt = 0.35;
  nsdae_bodies *b = floor_and_walls(0.5, 4, 0.3, g);
  uint64_t seed = 11;
  nsdae_bodies_set_gravity(b, (double[3]){g * sin(tilt), 0, -g * cos(tilt)});
  for (int i = 0; i < BOXES; i++) {
    const double density = 700, turn = random_between(&seed, -0.2, 0.2);
    nsdae_solid box = {.shape = NSDAE_SHAPE_BOX, .material = 1};
    nsdae_rigid_body body = {.quaternion = {cos(turn / 2), 0, 0, sin(turn / 2)}};
    for (int j = 0; j < 3; j++) box.length[j] = random_between(&seed, 0.06, j < 2 ? 0.1 : 0.08);
    body.position[0] = 0.12 * (i % 3 - 1) + 0.06 * (i / 12 % 2);
    body.position[1] = 0.12 * (i / 3 % 4 - 1.5) + 0.06 * (i / 12 % 2);
    body.position[2] = 0.04 + 0.085 * (i / 12);
    assert_int_equal(nsdae_body_from_solids(1, &box, &density, &body, NULL), NSDAE_OK);
    if (nsdae_bodies_add_solid(b, nsdae_bodies_add(b, &body), &box) < 0)
      fail_msg("%s", nsdae_bodies_error(b)->text);
  }
  return b;
}

static void expect_solved(const nsdae_friction_problem *p, const double *r)
{
  double residual = 1;
  assert_int_equal(nsdae_friction_residual(p, r, NULL, &residual), NSDAE_OK);
  assert_at_most(residual, TOL);
}

/* Work of the last step's problem from the guess of the simulation, in sweeps; cold: from nothing.
 */
static double work_of_step(nsdae_sim *sim, double *cold)
{
  nsdae_step_friction s;
  nsdae_friction_info from_guess, from_nothing;
  assert_int_equal(nsdae_sim_get_friction(sim, &s), NSDAE_OK);
  const size_t rows = 3 * (size_t)s.problem.contacts;
  double *warm = calloc(rows + 1, sizeof *warm), *nothing = calloc(rows + 1, sizeof *nothing);
  memcpy(warm, s.guess, rows * sizeof *warm);
  assert_int_equal(solve(&s.problem, nothing, &from_nothing), NSDAE_OK);
  assert_int_equal(solve(&s.problem, warm, &from_guess), NSDAE_OK);
  expect_solved(&s.problem, nothing);
  expect_solved(&s.problem, warm);
  print_message("%d contacts, %.0f sweeps, from nothing %.0f\n", s.problem.contacts,
                work(&from_guess), work(&from_nothing));
  assert_true(work(&from_guess) < work(&from_nothing));
  free(warm);
  free(nothing);
  *cold = work(&from_nothing);
  return work(&from_guess);
}

static void test_steps(void **state)
{
  nsdae_system *system;
  nsdae_sim_options o;
  double warm[STEPS], cold[STEPS];
  (void)state;
  nsdae_bodies *b = make_pile();
  nsdae_sim_options_default(&o);
  o.method = NSDAE_METHOD_MOREAU;
  o.dt = 2e-3;
  o.contact_tol = TOL;
  nsdae_sim *sim = start(b, &o, &system);
  for (int k = -100; k < STEPS; k++) {
    if (nsdae_sim_step(sim) < 0) fail_msg("%s", nsdae_sim_error(sim)->text);
    if (k >= 0) warm[k] = work_of_step(sim, &cold[k]);
  }
  end(b, system, sim);
  qsort(warm, STEPS, sizeof *warm, compare);
  qsort(cold, STEPS, sizeof *cold, compare);
  print_message("sweeps in the median: %.0f, from nothing %.0f\n", warm[STEPS / 2],
                cold[STEPS / 2]);
  assert_at_most(warm[STEPS / 2], 0.25 * cold[STEPS / 2]);
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_changed), cmocka_unit_test(test_steps)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
