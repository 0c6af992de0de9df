/* Bounces that come to rest by the event-driven method, seeded: at a stop of a joint, and beside a
 * fast rotor. The row of a stop of angles has
 * no part of the weight: the bearing, or a body that lies on a lever, brings it there. */
#include "check.h"

#include <stdlib.h>
#include <string.h>

#include <nsdae/nsdae.h>

#include "random.h"

typedef struct ended {
  int status, impacts, accumulations, early;
  double time, turn; /* of the last impact; the rate at the end */
} ended;

static int family(void)
{
  const char *asked = getenv("NSDAE_FAMILY");
  return asked ? atoi(asked) : 40;
}

static int keep(const nsdae_record *r, nsdae_error *error, void *user)
{
  ended *e = user;
  (void)error;
  for (int i = 0; i < r->impacts; i++) e->time = r->impact[i].time;
  e->impacts += r->impacts;
  return 0;
}

/* Runs and destroys the bodies; the first has the rate that is looked at. */
static ended fall(nsdae_bodies *b, int rate, double rtol, double t_end)
{
  nsdae_system *system;
  nsdae_sim *sim;
  nsdae_sim_options o;
  nsdae_stats stats;
  nsdae_record r;
  ended e = {.time = -1};
  double q[14], v[12];
  if (nsdae_bodies_system(b, &system) != NSDAE_OK) fail_msg("%s", nsdae_bodies_error(b)->text);
  nsdae_bodies_get_start(b, q, v);
  nsdae_sim_options_default(&o);
  o.method = NSDAE_METHOD_EVENT;
  o.rtol = rtol;
  o.atol = rtol / 100;
  assert_int_equal(nsdae_sim_create(system, &o, &sim, NULL), NSDAE_OK);
  nsdae_sim_observe(sim, keep, &e);
  int status = nsdae_sim_init(sim, 0, q, v);
  if (status >= 0) status = nsdae_sim_run(sim, t_end);
  if (status < 0) fail_msg("%s", nsdae_sim_error(sim)->text);
  if (status == NSDAE_WARN_RESTITUTION) {
    assert_string_equal(nsdae_sim_error(sim)->argument, "rtol");
    assert_non_null(strstr(nsdae_sim_error(sim)->text, "contact 0"));
    assert_non_null(strstr(nsdae_sim_error(sim)->text, "theta0"));
  } else
    assert_int_equal(status, NSDAE_OK);
  e.status = status;
  nsdae_sim_get_stats(sim, &stats);
  nsdae_sim_get_record(sim, &r);
  e.accumulations = (int)stats.accumulations;
  e.early = (int)stats.accumulations_early;
  e.turn = r.v[rate];
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  nsdae_bodies_destroy(&b);
  return e;
}

/* theta'' = -c cos theta from (theta, w) down to `low` by the classical method of Runge and Kutta;
 * the last step ends there by Newton's method. Returns the time; *w is the rate there. */
static double flight(double c, double low, double theta, double *w, double h)
{
  double t = 0;
  for (int near = 0; near < 5;) {
    double k1 = -c * cos(theta), k2 = -c * cos(theta + h / 2 * *w);
    double k3 = -c * cos(theta + h / 2 * *w + h * h / 4 * k1);
    double k4 = -c * cos(theta + h * *w + h * h / 2 * k2);
    double next = theta + h * *w + h * h / 6 * (k1 + k2 + k3);
    double rate = *w + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
    if (near > 0 || (next <= low && rate < 0)) {
      if (++near == 5) {
        *w = rate;
        return t + h;
      }
      h += (low - next) / rate;
      continue;
    }
    t += h;
    theta = next;
    *w = rate;
  }
  return t;
}

/* A rod that falls onto its stop: the time at which it rests is that of the sum of its flights, and
 * it is closed as soon as less than accumulation_time is left, T = 2 e w / (a (1 - e)). */
static void test_rods(void **state)
{
  (void)state;
  for (int seed = 1; seed <= family(); seed++) {
    uint64_t s = (uint64_t)seed;
    int d = 2 + random_below(&s, 2);
    double m = pow(10, random_between(&s, -3, 3)), L = random_between(&s, 0.1, 2), g = 9.81;
    double inertia = m * L * L * pow(10, random_between(&s, -3, 1));
    double e_n = random_between(&s, 0.05, 0.7), low = random_between(&s, -1.3, -0.1);
    double c = m * g * L / (inertia + m * L * L), a = c * cos(low), w = 0;
    nsdae_bodies *b;
    assert_int_equal(nsdae_bodies_create(d, &b, NULL), NSDAE_OK);
    nsdae_bodies_set_gravity(b, d == 2 ? (double[]){0, -g, 0} : (double[]){0, 0, -g});
    nsdae_bodies_add(
        b, &(nsdae_rigid_body){.mass = m,
                               .inertia = {d == 3 ? inertia : 0, d == 3 ? inertia : 0, inertia},
                               .position = {L, 0, 0}});
    int joint = nsdae_bodies_add_joint(b, &(nsdae_joint){.kind = NSDAE_JOINT_REVOLUTE,
                                                         .body = {NSDAE_GROUND, 0},
                                                         .axis = {0, d == 3 ? -1 : 0}});
    nsdae_bodies_add_limit(b, &(nsdae_limit){joint, 0, low, 2, e_n});
    double t = flight(c, low, 0, &w, 1e-3);
    int impacts = 1;
    for (; 2 * e_n * -w / (a * (1 - e_n)) > 1e-5; impacts++) {
      double length = 2 * e_n * -w / a; /* about */
      w *= -e_n;
      t += flight(c, low, low, &w, length / 400);
    }
    t += 2 * e_n * -w / (a * (1 - e_n));
    ended is = fall(b, d == 2 ? 2 : 4, 1e-8, 1.2 * t + 0.1);
    assert_int_equal(is.status, NSDAE_OK);
    print_message("seed %d: d %d, e %.3f: %d impacts, rests at %.9f s\n", seed, d, e_n, impacts, t);
    assert_int_equal(is.accumulations, 1);
    assert_int_equal(is.early, 0);
    /* errors of 1e-8 of the rates decide where T is within 1e-8 of accumulation_time: rare */
    assert_in_range(is.impacts, impacts - 1, impacts + 1);
    assert_near(is.time, t, 1e-7 * (1 + t)); /* rtol = 1e-8 in each flight */
    assert_near(is.turn, 0, 1e-9);
  }
}

/* A lever on a bearing through its centre, with a ball of e_N = 0 on its arm that alone presses it
 * onto the stop. It loses e_N^2 or more of its energy in each bounce, so that 1e-10 of it are left
 * after log 1e-5 / log e_N; then it rests. */
static void test_levers(void **state)
{
  (void)state;
  for (int seed = 1; seed <= family(); seed++) {
    uint64_t s = (uint64_t)seed;
    double m = pow(10, random_between(&s, -2, 2)), arm = random_between(&s, 0.2, 1);
    double inertia = m * pow(10, random_between(&s, -4, 0)), r = 0.1;
    double e_n = random_between(&s, 0.1, 0.5);
    nsdae_bodies *b;
    assert_int_equal(nsdae_bodies_create(2, &b, NULL), NSDAE_OK);
    nsdae_bodies_set_gravity(b, (double[]){0, -9.81, 0});
    nsdae_bodies_add(b, &(nsdae_rigid_body){.mass = m, .inertia = {0, 0, inertia}});
    nsdae_bodies_add(b, &(nsdae_rigid_body){.mass = m, .inertia = {0, 0, m}, .position = {arm, r}});
    int joint = nsdae_bodies_add_joint(
        b, &(nsdae_joint){.kind = NSDAE_JOINT_REVOLUTE, .body = {NSDAE_GROUND, 0}});
    nsdae_bodies_add_limit(b, &(nsdae_limit){joint, 0, -0.02, 2, e_n});
    int plane = nsdae_bodies_add_solid(b, 0, &(nsdae_solid){.shape = NSDAE_SHAPE_PLANE});
    int ball = nsdae_bodies_add_solid(b, 1, &(nsdae_solid){.shape = NSDAE_SHAPE_DISC, .radius = r});
    assert_true(nsdae_bodies_add_contact(b, plane, ball, 0, 0.5, 0) >= 0);
    ended is = fall(b, 2, 1e-8, 0.4);
    assert_int_equal(is.status, NSDAE_OK);
    print_message("seed %d: e %.3f, %d impacts, %d accumulations\n", seed, e_n, is.impacts,
                  is.accumulations);
    assert_true(is.accumulations >= 1);
    assert_in_range(is.impacts, 2, 4 + 3 * (int)(log(1e-5) / log(e_n)));
    assert_near(is.turn, 0, 1e-7);
  }
}

/* A disc that falls onto a floor beside a rotor, whose speed sets the tolerance of velocities: all
 * impacts until less than accumulation_time is left are found, or a warning names contact and
 * rotor. */
static void test_beside_a_rotor(void **state)
{
  int warned = 0, found = 0;
  (void)state;
  for (int seed = 1; seed <= family(); seed++) {
    uint64_t s = (uint64_t)seed;
    double g = 9.81, r = 0.1, rtol = pow(10, random_between(&s, -11, -5));
    double spin = random_below(&s, 4) ? pow(10, random_between(&s, 0, 4)) : 0;
    double e_n = random_between(&s, 0.1, 0.7), v = sqrt(2 * g * 1e-3);
    nsdae_bodies *b;
    if (10 * rtol * spin > 0.01) continue; /* lengths of the start are not resolved */
    assert_int_equal(nsdae_bodies_create(2, &b, NULL), NSDAE_OK);
    nsdae_bodies_set_gravity(b, (double[]){0, -g, 0});
    nsdae_bodies_add(b,
                     &(nsdae_rigid_body){
                         .mass = 1, .inertia = {0, 0, 1}, .position = {5}, .spin = {0, 0, spin}});
    nsdae_bodies_add(
        b, &(nsdae_rigid_body){.mass = 1, .inertia = {0, 0, 0.1}, .position = {0, r + 1e-3}});
    nsdae_bodies_add_joint(
        b, &(nsdae_joint){.kind = NSDAE_JOINT_REVOLUTE, .body = {NSDAE_GROUND, 0}, .point = {5}});
    int floor = nsdae_bodies_add_solid(b, NSDAE_GROUND, &(nsdae_solid){.shape = NSDAE_SHAPE_PLANE});
    int disc = nsdae_bodies_add_solid(b, 1, &(nsdae_solid){.shape = NSDAE_SHAPE_DISC, .radius = r});
    assert_true(nsdae_bodies_add_contact(b, floor, disc, 0, e_n, 0) >= 0);
    int impacts = 1;
    for (double u = v; 2 * e_n * u / (g * (1 - e_n)) > 1e-5; impacts++) u *= e_n;
    ended is = fall(b, 4, rtol, 0.2);
    print_message("seed %d: rtol %.1e, spin %.3g, e %.3f: status %d, %d impacts of %d\n", seed,
                  rtol, spin, e_n, is.status, is.impacts, impacts);
    if (is.status == NSDAE_OK) assert_in_range(is.impacts, impacts - 1, impacts + 1);
    /* the last flight before accumulation_time begins with g 1e-5 (1 - e) / 2 */
    if (40 * rtol * fmax(spin, v) < g * 1e-5 * (1 - e_n) / 2) {
      assert_int_equal(is.status, NSDAE_OK);
      found++;
    }
    warned += is.status != NSDAE_OK;
  }
  assert_true(warned >= family() / 10 && found >= family() / 10);
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_rods), cmocka_unit_test(test_levers),
                                     cmocka_unit_test(test_beside_a_rotor)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
