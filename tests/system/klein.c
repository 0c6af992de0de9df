/* Klein's apparatus: a rod between two masses on parallel rails, the first of which is rough
 * (Klein, 1909). With the slope r = tan phi, M = m_0 + m_1, the loads P_0, P_1 and s = sign v its
 * normal force N satisfies
 *
 *   N + a |N| = N_free,   a = r mu s m_1 / M,   N_free = -r (P_1 - m_1 (P_0 + P_1) / M),
 *
 * so that it is unique for |a| < 1; beyond, there is none or there are two. */
#include "check.h"

#include <nsdae/nsdae.h>

#include "support/random.h"

typedef struct klein {
  double mass[2], load[2], slope, mu, v;
} klein;

static uint64_t seed;

static double uniform(double from, double to)
{
  return random_between(&seed, from, to);
}

static klein draw(void)
{
  klein k = {.mu = uniform(0.05, 3), .v = uniform(0, 1) < 0.5 ? -1 : 1};
  k.slope = pow(2, uniform(-2, 2)) * (uniform(0, 1) < 0.5 ? -1 : 1);
  for (int i = 0; i < 2; i++) {
    k.mass[i] = uniform(0.5, 2);
    k.load[i] = uniform(-1, 1);
  }
  return k;
}

/* The accelerations of all solutions, and the value of N_free and a. */
static int solve(const klein *k, double acceleration[2], double *feed)
{
  double M = k->mass[0] + k->mass[1], P = k->load[0] + k->load[1];
  double N_free = -k->slope * (k->load[1] - k->mass[1] * P / M);
  int count = 0;
  *feed = k->slope * k->mu * k->v * k->mass[1] / M;
  for (int sign = -1; sign <= 1; sign += 2) {
    double N = N_free / (1 + sign * *feed);
    if (sign * N > 0) acceleration[count++] = (P - k->v * k->mu * fabs(N)) / M;
  }
  return count;
}

static int pull(double t, const double position[3], const double velocity[3], double force[3],
                double torque[3], void *user)
{
  (void)t, (void)position, (void)velocity, (void)torque;
  force[0] = *(double *)user;
  return 0;
}

static nsdae_bodies *build(klein *k)
{
  nsdae_bodies *b;
  const double height = 1, end[2][3] = {{0, 0, 0}, {height / k->slope, height, 0}};
  assert_int_equal(nsdae_bodies_create(2, &b, NULL), NSDAE_OK);
  for (int i = 0; i < 2; i++) {
    nsdae_bodies_add(b, &(nsdae_rigid_body){.mass = k->mass[i],
                                            .inertia = {1, 1, 1},
                                            .position = {end[i][0], end[i][1]},
                                            .velocity = {k->v}});
    nsdae_bodies_add_joint(b, &(nsdae_joint){.kind = NSDAE_JOINT_SLOT,
                                             .body = {NSDAE_GROUND, i},
                                             .point = {end[i][0], end[i][1]},
                                             .axis = {1},
                                             .mu = i == 0 ? k->mu : 0});
    nsdae_bodies_add_load(b, i, end[i], pull, &k->load[i]);
  }
  nsdae_bodies_add_joint(
      b,
      &(nsdae_joint){.kind = NSDAE_JOINT_DISTANCE, .body = {0, 1}, .end = {end[1][0], end[1][1]}});
  return b;
}

/* T is before the slide can stop: |v| = 1, and the acceleration is below 40 for |1 - |a|| > 0.1. */
static int run(klein *k, double T, nsdae_error *error, double *acceleration)
{
  nsdae_bodies *b = build(k);
  nsdae_system *system;
  nsdae_sim *sim;
  nsdae_sim_options o;
  nsdae_record r;
  double q[6], v[6];
  assert_true(nsdae_bodies_system(b, &system) >= 0);
  nsdae_sim_options_default(&o);
  o.method = NSDAE_METHOD_EVENT;
  o.dt = 1e-2;
  assert_int_equal(nsdae_sim_create(system, &o, &sim, NULL), NSDAE_OK);
  nsdae_bodies_get_start(b, q, v);
  int status = nsdae_sim_init(sim, 0, q, v);
  if (status == NSDAE_OK) status = nsdae_sim_run(sim, T);
  *error = *nsdae_sim_error(sim);
  nsdae_sim_get_record(sim, &r);
  *acceleration = (r.v[0] - k->v) / T;
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  nsdae_bodies_destroy(&b);
  return status;
}

static const int statuses[3] = {NSDAE_E_PAINLEVE, NSDAE_OK, NSDAE_WARN_PAINLEVE};

static void test_family(void **state)
{
  (void)state;
  int met[3] = {0};
  for (int i = 0; i < 300; i++) {
    seed = (unsigned)i + 1;
    klein k = draw();
    double exact[2], feed, acceleration;
    nsdae_error error;
    int count = solve(&k, exact, &feed);
    if (fabs(1 - fabs(feed)) < 0.1) continue;
    int status = run(&k, 0.02, &error, &acceleration);
    if (status != statuses[count])
      print_error("%d: %d solutions, a = %g: %s\n", i, count, feed, error.text);
    assert_int_equal(status, statuses[count]);
    met[count]++;
    if (count != 1) {
      assert_non_null(strstr(error.text, "frictional joint 0 \"joint0\" (slot joint 0 of body 0"));
      assert_int_equal(error.index, 0);
    }
    if (count == 0) continue;
    double off = fabs(acceleration - exact[0]);
    if (count == 2) off = fmin(off, fabs(acceleration - exact[1]));
    assert_at_most(off, 1e-6);
  }
  for (int count = 0; count < 3; count++) assert_true(met[count] >= 20);
}

/* The text names the multiplier of the motion: |N| = (P - M x'') / (mu s). */
static void test_named(void **state)
{
  (void)state;
  for (int sign = -1; sign <= 1; sign += 2) {
    klein k = {.mass = {1, 1}, .load = {0, 0}, .slope = 2, .mu = 1.5, .v = 1};
    double acceleration, lambda = 0;
    nsdae_error error;
    k.v = sign;
    k.load[sign < 0] = 1;
    assert_int_equal(run(&k, 0.02, &error, &acceleration), NSDAE_WARN_PAINLEVE);
    const char *at = strstr(error.text, "multiplier ");
    assert_non_null(at);
    assert_int_equal(sscanf(at, "multiplier %lf", &lambda), 1);
    assert_near(fabs(lambda), (1 - 2 * acceleration) / (k.mu * k.v), 1e-5);
  }
}

/* data/conformance/klein.csv */
static void test_published_cases(void **state)
{
  (void)state;
  FILE *file = fopen(NSDAE_DATA_DIR "/conformance/klein.csv", "r");
  char line[256];
  int cases = 0;
  assert_non_null(file);
  assert_non_null(fgets(line, sizeof line, file));
  while (fgets(line, sizeof line, file)) {
    klein k;
    double t_end, v[2] = {NAN, NAN}, acceleration;
    int solutions;
    nsdae_error error;
    int read =
        sscanf(line, "%*[^,],%lf,%lf,%lf,%lf,%lf,%lf,%lf,%lf,%d,%lf,%lf", &k.mass[0], &k.mass[1],
               &k.load[0], &k.load[1], &k.slope, &k.mu, &k.v, &t_end, &solutions, &v[0], &v[1]);
    assert_int_equal(read, 9 + solutions);
    assert_int_equal(run(&k, t_end, &error, &acceleration), statuses[solutions]);
    cases++;
    if (solutions == 0) continue;
    double end = k.v + acceleration * t_end;
    assert_at_most(fmin(fabs(end - v[0]), solutions == 2 ? fabs(end - v[1]) : INFINITY), 1e-8);
  }
  fclose(file);
  assert_int_equal(cases, 8);
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_family), cmocka_unit_test(test_named),
                                     cmocka_unit_test(test_published_cases)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
