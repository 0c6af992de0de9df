/* Named sensors in a trajectory: their values, units and shapes, and what a resumed run adds. */
#include "check.h"

#include <hdf5.h>
#include <hdf5_hl.h>

#include <nsdae/nsdae.h>

#include "support/hung_bodies.h"

static const char path[] = "test_sensors.h5";
enum { ROWS = 11 };

/* A wheel of 40 rad/s in space: ten records of four turns in all. */
static nsdae_bodies *wheel(const char *name)
{
  nsdae_bodies *b = create(3, 0, 0, 0);
  hang(b, 3, NSDAE_JOINT_REVOLUTE, (nsdae_rigid_body){.spin = {0, 0, 40}});
  nsdae_bodies_add_sensor(b, &(nsdae_sensor){.name = name, .kind = NSDAE_SENSOR_COORDINATE});
  nsdae_bodies_add_sensor(b, &(nsdae_sensor){.kind = NSDAE_SENSOR_RATE});
  nsdae_bodies_add_sensor(
      b, &(nsdae_sensor){.name = "rim velocity", .kind = NSDAE_SENSOR_VELOCITY, .point = {0.5}});
  nsdae_bodies_add_sensor(b, &(nsdae_sensor){.name = "pose", .kind = NSDAE_SENSOR_ORIENTATION});
  return b;
}

static void run_into(nsdae_bodies *b, int resumed, double t_end)
{
  nsdae_system *system;
  nsdae_sim *sim;
  nsdae_sim_options o;
  nsdae_trajectory *file;
  nsdae_trajectory_info info = {.model = "wheel"};
  nsdae_error error;
  double q[7], v[6];
  assert_true(nsdae_bodies_system(b, &system) >= 0);
  nsdae_bodies_get_start(b, q, v);
  nsdae_sim_options_default(&o);
  o.method = NSDAE_METHOD_EVENT;
  o.dt = 0.1;
  assert_int_equal(nsdae_sim_create(system, &o, &sim, NULL), NSDAE_OK);
  if (!resumed) assert_int_equal(nsdae_sim_init(sim, 0, q, v), NSDAE_OK);
  int status = resumed ? nsdae_trajectory_resume(sim, path, &info, &file, &error)
                       : nsdae_trajectory_create(sim, path, &info, &file, &error);
  if (status < 0) fail_msg("%s", error.text);
  if (nsdae_sim_run(sim, t_end) < 0) fail_msg("%s", nsdae_sim_error(sim)->text);
  assert_int_equal(nsdae_trajectory_close(&file, NSDAE_OK, &error), NSDAE_OK);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  nsdae_bodies_destroy(&b);
}

static void expect_units(hid_t file, const char *name, const char *unit)
{
  char *text = NULL;
  hid_t set = H5Dopen2(file, name, H5P_DEFAULT), attribute = H5Aopen(set, "units", H5P_DEFAULT);
  hid_t type = H5Aget_type(attribute);
  assert_true(H5Aread(attribute, type, &text) >= 0);
  assert_string_equal(text, unit);
  H5free_memory(text);
  H5Tclose(type);
  H5Aclose(attribute);
  H5Dclose(set);
}

static void read(hid_t file, const char *name, const char *unit, int width, double *value)
{
  hsize_t size[2] = {0, 1};
  assert_true(H5LTget_dataset_info(file, name, size, NULL, NULL) >= 0);
  assert_int_equal(size[0], ROWS);
  assert_int_equal(size[1], width);
  assert_true(H5LTread_dataset_double(file, name, value) >= 0);
  expect_units(file, name, unit);
}

static void test_file(void **state)
{
  (void)state;
  double turned[ROWS], velocity[3 * ROWS], pose[4 * ROWS];
  run_into(wheel("turned"), 0, 0.6);
  run_into(wheel("turned"), 1, 1);
  hid_t file = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT);
  assert_true(file >= 0);
  read(file, "/sensor/turned", "rad", 1, turned);
  read(file, "/sensor/rim velocity", "m/s", 3, velocity);
  read(file, "/sensor/pose", "1", 4, pose);
  for (int i = 0; i < ROWS; i++) {
    double angle = 4.0 * i;
    assert_near(turned[i], angle, 1e-6);
    assert_near(velocity[3 * i], -20 * sin(angle), 1e-5);
    assert_near(velocity[3 * i + 1], 20 * cos(angle), 1e-5);
    assert_near(fabs(pose[4 * i]), fabs(cos(angle / 2)), 1e-6);
  }
  hid_t group = H5Gopen2(file, "/sensor", H5P_DEFAULT);
  H5G_info_t info;
  assert_true(H5Gget_info(group, &info) >= 0);
  assert_int_equal(info.nlinks, 3); /* not of the one without a name */
  H5Gclose(group);
  H5Fclose(file);
  remove(path);
}

/* Units of gaps and impulses of limits and motors, of rotations, of displacements, and of both. */
static void test_units(void **state)
{
  (void)state;
  for (int both = 0; both <= 1; both++)
    for (int list = 0; list <= 1; list++) {
      nsdae_bodies *b = create(3, 0, 0, 0);
      int joint = hang(b, 3, NSDAE_JOINT_CYLINDRICAL, (nsdae_rigid_body){.spin = {0, 0, 1}});
      for (int i = 1 - both; i < 2; i++) {
        nsdae_bodies_add_limit(b, &(nsdae_limit){joint, i, -2, 2, 1});
        nsdae_bodies_add_motor(b, &(nsdae_motor){joint, i, NSDAE_MOTOR_SPEED, .limit = 1e-3});
      }
      if (list) nsdae_bodies_set_pair(b, 0, 0, 0, 0, 0);
      run_into(b, 0, 1);
      hid_t file = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT);
      assert_true(file >= 0);
      expect_units(file, "/frictional_joint/impulse", both ? "N s, N m s" : "N m s");
      expect_units(file, "/contacts/gap", both || list ? "m, rad" : "rad");
      expect_units(file, "/contacts/normal_impulse", both || list ? "N s, N m s" : "N m s");
      expect_units(file, "/impact/velocity_before", both || list ? "m/s, rad/s" : "rad/s");
      H5Fclose(file);
      remove(path);
    }
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_file), cmocka_unit_test(test_units)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
