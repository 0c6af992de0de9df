/* The origin may be anywhere: mechanisms by the time-stepping methods, and the same up to 10 km
 * away, where places have the rounding u = eps |q|. All steps are taken, and the motion is the same
 * to what rounding explains. Each step changes q by some u, and v by w u with angular velocities w
 * of some 10 rad/s; each change grows by at most as much as one of the start. That is measured at
 * the origin. */
#include "check.h"

#include <float.h>

#include "random.h"
#include "run_bodies.h"

enum { NQ = 7 * 8, GROUND = NSDAE_GROUND };

static int add(nsdae_bodies *b, double mass, double inertia, double x, double y)
{
  return nsdae_bodies_add(b, &(nsdae_rigid_body){.mass = mass,
                                                 .inertia = {inertia, inertia, inertia},
                                                 .position = {x, y},
                                                 .quaternion = {1}});
}

/* From x on, to a particle at x + l if the joint is a rod. */
static void join(nsdae_bodies *b, int kind, int first, int second, double x, double y, double l)
{
  const nsdae_joint joint = {
      .kind = kind, .body = {first, second}, .point = {x, y}, .end = {x + l, y}};
  assert_true(nsdae_bodies_add_joint(b, &joint) >= 0);
}

/* Eight rods; the tip is light and fast. */
static void chain(nsdae_bodies *b, int kind, double x, double y)
{
  for (int i = 0, last = GROUND; i < 8; i++) {
    double l = (1.5 - i / 8.0) / 8, m = 0.5 * pow(0.6, i);
    int rod = add(b, m, m * l * l / 12, x + l / 2, y);
    join(b, kind, last, rod, x, y, 0);
    last = rod, x += l;
  }
}

static void hinges(nsdae_bodies *b, double x, double y)
{
  chain(b, NSDAE_JOINT_REVOLUTE, x, y);
}

static void spheres(nsdae_bodies *b, double x, double y)
{
  chain(b, NSDAE_JOINT_SPHERICAL, x, y);
}

/* Phi_q of rods between particles is made of differences of places. */
static void particles(nsdae_bodies *b, double x, double y)
{
  const double l = 0.1;
  for (int i = 0, last = GROUND; i < 5; i++) {
    int one = add(b, 0.5, 0.01, x + l, y);
    join(b, NSDAE_JOINT_DISTANCE, last, one, x, y, l);
    last = one, x += l;
  }
}

/* A rope of links with a weight swings round a peg and hits it. */
static void rope(nsdae_bodies *b, double x, double y)
{
  const double l = 0.2, m = 0.1;
  int peg = nsdae_bodies_add_solid(
      b, GROUND,
      &(nsdae_solid){.shape = NSDAE_SHAPE_DISC, .radius = 0.05, .position = {x, y - 0.6}});
  for (int i = 0, last = GROUND; i < 6; i++) {
    int link = add(b, i < 5 ? m : 1, i < 5 ? m * l * l / 12 : 0.01, x + l / 2, y);
    int line = nsdae_bodies_add_solid(
        b, link, &(nsdae_solid){.shape = NSDAE_SHAPE_SEGMENT, .radius = 0.01, .length = {l}});
    join(b, NSDAE_JOINT_REVOLUTE, last, link, x, y, 0);
    assert_true(nsdae_bodies_add_contact(b, peg, line, 0.2, 0.1, 0) >= 0);
    last = link, x += l;
  }
}

static const struct scene {
  const char *name;
  int dimension;
  double t_end;
  void (*make)(nsdae_bodies *b, double x, double y);
} scenes[] = {{"hinges", 2, 0.8, hinges},
              {"spherical joints", 3, 0.8, spheres},
              {"particles on rods", 2, 0.8, particles},
              {"rope round a peg", 2, 0.7, rope}};

/* The end, without the shift. */
typedef struct ending {
  double q[NQ], v[NQ];
  long steps, contact_steps;
} ending;

static ending go(const struct scene *s, int method, double dt, double shift, double change)
{
  ending e = {.steps = 0};
  nsdae_bodies *b;
  nsdae_system *system;
  nsdae_sim_options o;
  nsdae_record r;
  nsdae_stats stats;
  nsdae_dims d;
  nsdae_sim *sim;
  uint64_t seed = 7;
  const double at[2] = {shift, -2 * shift};
  int places = s->dimension == 2 ? 3 : 7;
  assert_int_equal(nsdae_bodies_create(s->dimension, &b, NULL), NSDAE_OK);
  nsdae_bodies_set_gravity(b, (const double[]){0, -9.81, 0});
  s->make(b, at[0], at[1]);
  if (nsdae_bodies_system(b, &system) < 0) fail_msg("%s", nsdae_bodies_error(b)->text);
  nsdae_bodies_get_dims(b, &d);
  nsdae_bodies_get_start(b, e.q, e.v);
  for (int i = 0; i < d.nq; i++) e.q[i] += random_between(&seed, -change, change);
  for (int i = 0; i < d.nv; i++) e.v[i] += random_between(&seed, -10 * change, 10 * change);
  nsdae_sim_options_default(&o);
  o.method = method;
  o.dt = dt;
  assert_int_equal(nsdae_sim_create(system, &o, &sim, NULL), NSDAE_OK);
  if (nsdae_sim_init(sim, 0, e.q, e.v) < 0 || nsdae_sim_run(sim, s->t_end) < 0)
    fail_msg("%s at %g m: %s", s->name, shift, nsdae_sim_error(sim)->text);
  nsdae_sim_get_record(sim, &r);
  nsdae_sim_get_stats(sim, &stats);
  e.steps = stats.steps, e.contact_steps = stats.contact_steps;
  for (int i = 0; i < d.nq; i++) e.q[i] = r.q[i] - (i % places < 2 ? at[i % places] : 0);
  memcpy(e.v, r.v, (size_t)d.nv * sizeof *e.v);
  end(b, system, sim);
  return e;
}

static double difference(const ending *a, const ending *b)
{
  double most = 0;
  for (int i = 0; i < NQ; i++)
    most = fmax(most, fmax(fabs(a->q[i] - b->q[i]), fabs(a->v[i] - b->v[i])));
  return most;
}

/* In the quick form a scene by a method has one of the shifts, another one for each. */
static void compare(const struct scene *s, int method, double dt)
{
  static const double shifts[] = {300, 1000, 1e4};
  ending here = go(s, method, dt, 0, 0);
  for (int i = 0; i < 3; i++) {
    if (test_share() > 1 && i != (s - scenes + method) % 3) continue;
    double u = 2 * DBL_EPSILON * shifts[i];
    ending there = go(s, method, dt, shifts[i], 0), changed = go(s, method, dt, 0, u);
    double off = difference(&here, &there), grown = difference(&here, &changed);
    print_message("%s, method %d, dt %g, at %g m: off %.1e, a change of %.1e grows to %.1e\n",
                  s->name, method, dt, shifts[i], off, u, grown);
    assert_at_most(off, (double)here.steps * grown);
    if (s->make == rope) assert_true(here.contact_steps > 0);
  }
}

static void test_far(void **state)
{
  (void)state;
  for (size_t i = 0; i < sizeof scenes / sizeof *scenes; i++)
    for (double dt = 1e-3; dt > (test_share() > 1 ? 9e-4 : 4e-4); dt /= 2) {
      compare(&scenes[i], NSDAE_METHOD_IMPLICIT, dt);
      compare(&scenes[i], NSDAE_METHOD_MOREAU, dt);
    }
}

static int one(double t, const double *q, double *M, int ldm, void *user)
{
  (void)t, (void)q, (void)ldm, (void)user;
  M[0] = 1;
  return 0;
}

/* A spring with noise: the last digit of q decides. */
static int noisy(double t, const double *q, const double *v, double *F, void *user)
{
  (void)t, (void)v, (void)user;
  F[0] = -q[0] + 1e-7 * sin(1e17 * q[0]);
  return 0;
}

/* Near the origin noise of forces is no rounding of q: the step fails, and its remedy helps. */
static void test_noise(void **state)
{
  const double q = 1, v = 0;
  (void)state;
  for (int remedy = 0; remedy < 2; remedy++) {
    nsdae_system *system;
    nsdae_sim *sim;
    nsdae_sim_options o;
    assert_int_equal(nsdae_system_create(&(nsdae_dims){.nq = 1, .nv = 1}, &system, NULL), NSDAE_OK);
    nsdae_system_set_mass(system, one);
    nsdae_system_set_force(system, noisy);
    nsdae_sim_options_default(&o);
    if (remedy) o.iteration_tol = 1e-9;
    assert_int_equal(nsdae_sim_create(system, &o, &sim, NULL), NSDAE_OK);
    assert_int_equal(nsdae_sim_init(sim, 0, &q, &v), NSDAE_OK);
    int status = nsdae_sim_run(sim, 1);
    assert_int_equal(status, remedy ? NSDAE_OK : NSDAE_E_CONVERGENCE);
    if (!remedy) {
      print_message("%s\n", nsdae_sim_error(sim)->text);
      assert_string_equal(nsdae_sim_error(sim)->argument, "iteration_tol");
      assert_non_null(strstr(nsdae_sim_error(sim)->text, "make iteration_tol larger"));
    }
    nsdae_sim_destroy(&sim);
    nsdae_system_destroy(&system);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_far), cmocka_unit_test(test_noise)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
