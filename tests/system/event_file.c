/* What the event-driven method leaves in a file, read back with HDF5's own interface: exact
 * impacts, samples at the requested times, a certificate. The ball has a closed form for all of it.
 */
#include "check.h"

#include <hdf5.h>
#include <hdf5_hl.h>

#include "bouncing_ball.h"

enum { STEPS = 1000, MOST = 256, ROWS = STEPS + 8 };

static const char path[] = "test_event_file.h5";
static const double DT = 0.01;

static void write_file(bouncing_ball *ball)
{
  const driver_model *model = &bouncing_ball_model;
  const nsdae_trajectory_info info = {
      .model = model->name, .parameters = model->parameters, .parameters_base = ball};
  nsdae_sim_options options;
  nsdae_system *system;
  nsdae_sim *sim;
  nsdae_trajectory *file;
  double q0 = 0, v0 = 0;
  nsdae_sim_options_default(&options);
  options.method = NSDAE_METHOD_EVENT;
  options.dt = DT;
  options.rtol = 1e-11;
  options.atol = 1e-13;
  assert_int_equal(model->build(ball, &system, NULL), NSDAE_OK);
  model->start(ball, &q0, &v0);
  assert_int_equal(nsdae_sim_create(system, &options, &sim, NULL), NSDAE_OK);
  assert_int_equal(nsdae_sim_init(sim, 0, &q0, &v0), NSDAE_OK);
  assert_int_equal(nsdae_trajectory_create(sim, path, &info, &file, NULL), NSDAE_OK);
  int status = nsdae_sim_run(sim, STEPS * DT);
  assert_int_equal(status, NSDAE_OK);
  assert_int_equal(nsdae_trajectory_close(&file, status, NULL), NSDAE_OK);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
}

static int rows_of(hid_t file, const char *name)
{
  hsize_t dims[3] = {0};
  assert_true(H5LTget_dataset_info(file, name, dims, NULL, NULL) >= 0);
  return (int)dims[0];
}

/* Returns the number of rows. */
static int read(hid_t file, const char *name, int most, double *a)
{
  int rows = rows_of(file, name);
  assert_in_range(rows, 0, most);
  assert_true(H5LTread_dataset_double(file, name, a) >= 0);
  return rows;
}

static hid_t open_file(void)
{
  hid_t file = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT);
  assert_true(file >= 0);
  return file;
}

/* At t_k = t_1 (1 + 2 (e + ... + e^k)) with the velocity e^k v_1 and the impulse m (1 + e) e^k v_1;
 * the last one stands for all that follow, at the time of rest. */
static void test_impacts(void **state)
{
  const bouncing_ball *ball = *state;
  double time[MOST], impulse[MOST], before[MOST], after[MOST], accumulation[MOST];
  double e = ball->ball.e_N, v = sqrt(2 * ball->ball.g * ball->h0), t = v / ball->ball.g;
  hid_t file = open_file();
  int n = read(file, "/impact/time", MOST, time);
  assert_int_equal(read(file, "/impact/normal_impulse", MOST, impulse), n);
  assert_int_equal(read(file, "/impact/velocity_before", MOST, before), n);
  assert_int_equal(read(file, "/impact/velocity_after", MOST, after), n);
  assert_int_equal(read(file, "/impact/accumulation", MOST, accumulation), n);
  assert_in_range(n, 45, MOST);
  for (int i = 0; i + 1 < n; i++) {
    /* a hundred times the tolerance, for the errors of all flights before */
    assert_near(time[i], t, 1e-9 * t);
    assert_near(before[i], -v, 1e-9);
    assert_near(after[i], e * v, 1e-9);
    assert_near(impulse[i], ball->ball.m * (1 + e) * v, 1e-9);
    assert_true(accumulation[i] == 0);
    v *= e;
    t += 2 * v / ball->ball.g;
  }
  assert_true(accumulation[n - 1] == 1);
  assert_near(time[n - 1], bouncing_ball_rest(ball), 1e-8);
  H5Fclose(file);
}

/* Every record is where the closed form has it, and there is one at every requested time; some more
 * only where impacts come so fast that a step has no room for all of them. */
static void test_samples(void **state)
{
  const bouncing_ball *ball = *state;
  static double t[ROWS], q[ROWS], v[ROWS], mode[ROWS];
  hid_t file = open_file();
  int rows = read(file, "/time", ROWS, t), requested = 0;
  assert_int_equal(read(file, "/q", ROWS, q), rows);
  assert_int_equal(read(file, "/v", ROWS, v), rows);
  assert_int_equal(read(file, "/contacts/mode", ROWS, mode), rows);
  for (int i = 0; i < rows; i++) {
    double height, velocity;
    requested += fabs(t[i] - requested * DT) < 1e-14;
    bouncing_ball_exact(ball, t[i], &height, &velocity, NULL);
    /* within accumulation_time, 1e-5 s, of the end of the accumulation it is taken for ended */
    double closed = fabs(t[i] - bouncing_ball_rest(ball)) <= 1e-5 ? 1e-5 * ball->ball.g : 1e-8;
    assert_near(q[i], height, 1e-9);
    assert_near(v[i], velocity, closed);
    assert_true((mode[i] != NSDAE_MODE_OPEN) == (t[i] > bouncing_ball_rest(ball) - 1e-5));
  }
  assert_int_equal(requested, STEPS + 1);
  H5Fclose(file);
}

/* Energy and what the impacts took of it are constant together; nothing lies below the floor. */
static void test_certificate(void **state)
{
  const bouncing_ball *ball = *state;
  static double kinetic[ROWS], potential[ROWS], dissipated[ROWS], residual[ROWS], penetration[ROWS];
  hid_t file = open_file();
  int rows = read(file, "/energy/kinetic", ROWS, kinetic);
  assert_int_equal(read(file, "/energy/potential", ROWS, potential), rows);
  assert_int_equal(read(file, "/energy/dissipated", ROWS, dissipated), rows);
  assert_int_equal(read(file, "/certificate/lcp_residual", ROWS, residual), rows);
  assert_int_equal(read(file, "/certificate/penetration", ROWS, penetration), rows);
  for (int i = 0; i < rows; i++) {
    assert_near(kinetic[i] + potential[i] + dissipated[i], ball->ball.m * ball->ball.g * ball->h0,
                1e-8);
    assert_true(i == 0 || dissipated[i] >= dissipated[i - 1]);
    assert_at_most(residual[i], 1e-10);
    assert_at_most(penetration[i], 1e-10);
  }
  H5Fclose(file);
}

/* The contact opens at every impact but the last, so that one change says that it stays closed. */
static void test_change(void **state)
{
  const bouncing_ball *ball = *state;
  double time[MOST], contact[MOST], frictional_joint[MOST], before[MOST], after[MOST];
  hid_t file = open_file();
  assert_int_equal(read(file, "/change/time", MOST, time), 1);
  read(file, "/change/id", MOST, contact);
  read(file, "/change/frictional_joint", MOST, frictional_joint);
  read(file, "/change/mode_before", MOST, before);
  read(file, "/change/mode_after", MOST, after);
  /* accumulation_time, 1e-5 s, is the most by which it is closed early */
  assert_near(time[0], bouncing_ball_rest(ball), 1e-5);
  assert_true(contact[0] == 0 && frictional_joint[0] == -1);
  assert_true(before[0] == NSDAE_MODE_OPEN && after[0] != NSDAE_MODE_OPEN);
  H5Fclose(file);
}

static int start(void **state)
{
  bouncing_ball *ball = bouncing_ball_model.base;
  nsdae_params_default(bouncing_ball_model.parameters, ball);
  *state = ball;
  write_file(ball);
  return 0;
}

static int end(void **state)
{
  (void)state;
  remove(path);
  return 0;
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_impacts),
      cmocka_unit_test(test_samples),
      cmocka_unit_test(test_certificate),
      cmocka_unit_test(test_change),
  };
  return cmocka_run_group_tests(tests, start, end);
}
