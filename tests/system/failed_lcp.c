/* A step whose contact problem has no solution: the problem is handed out, goes through a file and
 * is found without solution by nsdae-lcp. A particle between a ceiling at 1 m and a floor that
 * rises at 1 m/s: once it touches both, v >= 1 and v <= 0. */
#include "check.h"

#include <nsdae/nsdae.h>
#include <stdlib.h>
#include <sys/wait.h>

static int mass(double t, const double *q, double *M, int ldm, void *user)
{
  (void)t, (void)q, (void)ldm, (void)user;
  M[0] = 2;
  return 0;
}

static int force(double t, const double *q, const double *v, double *F, void *user)
{
  (void)t, (void)q, (void)v, (void)user;
  F[0] = 0;
  return 0;
}

static int gap(double t, const double *q, double *g, void *user)
{
  (void)user;
  g[0] = q[0] - t;
  g[1] = 1 - q[0];
  return 0;
}

static nsdae_system *press(void)
{
  nsdae_system *system;
  const nsdae_dims dims = {.nq = 1, .k = 2};
  assert_int_equal(nsdae_system_create(&dims, &system, NULL), NSDAE_OK);
  nsdae_system_set_mass(system, mass);
  nsdae_system_set_force(system, force);
  nsdae_system_set_gap(system, gap);
  return system;
}

/* Both rows: x_1 / m - x_2 / m + b_1 >= 0 and its opposite, with b_1 + b_2 < 0. */
static void expect_press(const nsdae_lcp_problem *p)
{
  assert_int_equal(p->n, 2);
  for (int j = 0; j < 2; j++)
    for (int i = 0; i < 2; i++)
      assert_near(p->A[j * p->lda + i], i == j ? 0.5 : -0.5, 1e-6); /* W by differences */
  assert_near(p->b[0] + p->b[1], -1, 1e-6);
}

static int run_program(const char *options, const char *words)
{
  char command[512];
  snprintf(command, sizeof command, "%s/nsdae-lcp %s failed_lcp.h5 | grep -q '%s'", NSDAE_BIN_DIR,
           options, words);
  int status = system(command);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

static void test_press(void **state)
{
  (void)state;
  const double q0 = 0.5, v0 = 0;
  const int methods[] = {NSDAE_METHOD_MOREAU, NSDAE_METHOD_IMPLICIT};
  for (int i = 0; i < 2; i++) {
    nsdae_system *system = press();
    nsdae_sim_options options;
    nsdae_lcp_problem problem;
    nsdae_lcp_file file;
    nsdae_record record;
    nsdae_sim *sim;
    nsdae_sim_options_default(&options);
    options.contact_tol = 1e-10;
    options.method = methods[i];
    assert_int_equal(nsdae_sim_create(system, &options, &sim, NULL), NSDAE_OK);
    assert_int_equal(nsdae_sim_get_failed_lcp(sim, &problem), NSDAE_E_STATE);
    assert_int_equal(nsdae_sim_init(sim, 0, &q0, &v0), NSDAE_OK);
    assert_int_equal(nsdae_sim_step(sim), NSDAE_OK);
    assert_int_equal(nsdae_sim_get_failed_lcp(sim, &problem), NSDAE_E_STATE);
    assert_int_equal(nsdae_sim_run(sim, 2), NSDAE_E_INFEASIBLE);
    assert_int_equal(nsdae_sim_get_failed_lcp(sim, &problem), NSDAE_OK);
    assert_int_equal(nsdae_sim_get_failed_lcp(sim, NULL), NSDAE_E_ARGUMENT);
    assert_int_equal(nsdae_sim_get_failed_lcp(NULL, &problem), NSDAE_E_ARGUMENT);
    expect_press(&problem);
    nsdae_sim_get_record(sim, &record);
    assert_near(record.time, 1, 2 * options.dt);
    const nsdae_lcp_origin origin = {record.time, record.step + 1, options.contact_tol, "moreau"};
    int written = nsdae_lcp_write("failed_lcp.h5", &problem, &origin, NULL);
    if (written != NSDAE_E_UNSUPPORTED) {
      assert_int_equal(written, NSDAE_OK);
      assert_int_equal(nsdae_lcp_read("failed_lcp.h5", &file, NULL), NSDAE_OK);
      assert_true(file.tol == options.contact_tol);
      assert_memory_equal(file.A, problem.A, 4 * sizeof *file.A);
      assert_memory_equal(file.b, problem.b, 2 * sizeof *file.b);
      nsdae_lcp_file_release(&file);
      assert_int_equal(run_program("", "outcome: infeasible"), 0);
      assert_int_equal(run_program("", "proof: farkas"), 0);
      remove("failed_lcp.h5");
    }
    assert_int_equal(nsdae_sim_init(sim, 0, &q0, &v0), NSDAE_OK);
    assert_int_equal(nsdae_sim_get_failed_lcp(sim, &problem), NSDAE_E_STATE);
    nsdae_sim_destroy(&sim);
    nsdae_system_destroy(&system);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_press)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
