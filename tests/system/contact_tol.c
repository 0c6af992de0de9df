/* contact_tol = auto: small islands are solved to 1e-10 and large ones of cones to 1e-4; each
 * record has the tolerance; bodies fall, come to rest and stay at rest as with 1e-4. */
#include "check.h"

#include <string.h>

#include <nsdae/nsdae.h>

#include "random.h"
#include "walls.h"

static const double G = 9.81, DT = 2e-3, SMALL = 1e-10, LARGE = 1e-4;

/* ---- the option */

static void test_option(void **state)
{
  nsdae_sim_options o;
  nsdae_error error;
  char text[32];
  (void)state;
  nsdae_sim_options_default(&o);
  const nsdae_param *p = nsdae_params_find(nsdae_sim_options_table(), "contact_tol");
  assert_true(o.contact_tol == 0);
  nsdae_params_format(p, &o, text, sizeof text);
  assert_string_equal(text, "auto");
  assert_int_equal(nsdae_sim_options_set(&o, "contact_tol", "1e-8", &error), NSDAE_OK);
  nsdae_params_format(p, &o, text, sizeof text);
  assert_true(o.contact_tol == 1e-8 && strcmp(text, "1e-08") == 0);
  assert_int_equal(nsdae_sim_options_set(&o, "contact_tol", "auto", &error), NSDAE_OK);
  assert_true(o.contact_tol == 0);
  const char *const bad[] = {"1e-17", "0.1", "-1", "automatic"};
  for (int i = 0; i < 4; i++) {
    assert_int_equal(nsdae_sim_options_set(&o, "contact_tol", bad[i], &error), NSDAE_E_ARGUMENT);
    assert_non_null(strstr(error.text, "auto"));
  }
}

/* ---- bodies */

static int add_box(nsdae_bodies *b, const double length[3], const nsdae_rigid_body *at)
{
  const double density = 1000;
  nsdae_solid solid = {.shape = NSDAE_SHAPE_BOX, .material = 1};
  nsdae_rigid_body body = *at;
  memcpy(solid.length, length, sizeof solid.length);
  assert_int_equal(nsdae_body_from_solids(1, &solid, &density, &body, NULL), NSDAE_OK);
  int number = nsdae_bodies_add(b, &body);
  nsdae_bodies_add_solid(b, number, &solid);
  return number;
}

enum { MOST = 64 };

typedef struct world {
  nsdae_bodies *bodies;
  nsdae_system *system;
  nsdae_sim *sim;
} world;

static void begin(world *w, int method, double tol)
{
  double q[7 * MOST], v[6 * MOST];
  nsdae_sim_options o;
  assert_int_equal(nsdae_bodies_get_start(w->bodies, q, v), NSDAE_OK);
  assert_true(nsdae_bodies_system(w->bodies, &w->system) >= 0);
  nsdae_sim_options_default(&o);
  o.method = method;
  o.dt = DT;
  o.contact_tol = tol;
  assert_int_equal(nsdae_sim_create(w->system, &o, &w->sim, NULL), NSDAE_OK);
  assert_int_equal(nsdae_sim_init(w->sim, 0, q, v), NSDAE_OK);
}

static void end(world *w)
{
  nsdae_sim_destroy(&w->sim);
  nsdae_system_destroy(&w->system);
  nsdae_bodies_destroy(&w->bodies);
}

/* A wall of bricks at rest, 4 by 4, and apart from it a brick of the same size that slides. */
static world wall_and_slider(double mu, double speed)
{
  const double brick[3] = {0.2, 0.1, 0.1};
  world w = {.bodies = floor_and_walls(mu, 0, 0, G)};
  for (int i = 0; i < 16; i++)
    add_box(w.bodies, brick,
            &(nsdae_rigid_body){
                .position = {(i % 4 + i / 4 % 2 * 0.5) * 0.2, 0, 0.05 + 0.1 * (i / 4)}});
  add_box(w.bodies, brick,
          &(nsdae_rigid_body){.position = {0, 5, 0.05}, .velocity = {0, speed, 0}});
  return w;
}

/* The slider has v = v_0 - mu g t and the wall has v = 0 exactly: the one to 1e-10 of its
 * velocities although the other is solved to 1e-4. */
static void check_small_beside_large(int method)
{
  const double mu = 0.3, speed = 2;
  world w = wall_and_slider(mu, speed);
  nsdae_record r;
  nsdae_stats stats;
  begin(&w, method, 0);
  for (int i = 1; i <= 150; i++) {
    int status = nsdae_sim_step(w.sim);
    if (status != NSDAE_OK) fail_msg("%s", nsdae_sim_error(w.sim)->text);
    nsdae_sim_get_record(w.sim, &r);
    assert_true(r.contact_tol == LARGE && r.lcp_residual <= LARGE);
    assert_near(r.v[6 * 16 + 1], speed - mu * G * DT * i, 1e-9 * speed);
    for (int j = 0; j < 6 * 16 && i > 10; j++) assert_true(r.v[j] == 0);
  }
  nsdae_sim_get_stats(w.sim, &stats);
  assert_true(stats.contact_tol == LARGE && stats.inexact_steps == 0);
  assert_true(stats.island_contacts > 11);
  end(&w);
}

static void test_small_beside_large(void **state)
{
  (void)state;
  check_small_beside_large(NSDAE_METHOD_MOREAU);
  check_small_beside_large(NSDAE_METHOD_IMPLICIT);
}

/* One brick alone: no step of it is solved to more than 1e-10. */
static void test_small(void **state)
{
  world w = {.bodies = floor_and_walls(0.3, 0, 0, G)};
  nsdae_record r;
  (void)state;
  add_box(w.bodies, (double[3]){0.3, 0.2, 0.1},
          &(nsdae_rigid_body){.position = {0, 0, 0.4},
                              .quaternion = {0.8, 0.36, 0.48, 0},
                              .velocity = {1, 0.2, 0},
                              .spin = {3, -2, 5}});
  begin(&w, NSDAE_METHOD_MOREAU, 0);
  for (int i = 0; i < 400; i++) {
    assert_true(nsdae_sim_step(w.sim) >= 0);
    nsdae_sim_get_record(w.sim, &r);
    assert_true(r.contact_tol == (r.contacts.count > 0 ? SMALL : 0));
    assert_at_most(r.lcp_residual, SMALL);
  }
  end(&w);
}

/* ---- tumbled boxes that fall on each other */

enum { SIDE = 3, BOXES = SIDE * SIDE * SIDE, STEPS = 500 };

static world lattice(uint64_t seed)
{
  const double cell = 0.11, half = SIDE * cell / 2;
  world w = {.bodies = floor_and_walls(0.5, 4, half, G)};
  for (int i = 0; i < BOXES; i++) {
    const int place[3] = {i % SIDE, i / SIDE % SIDE, i / SIDE / SIDE};
    const double size = random_between(&seed, 0.8, 1) * 0.05;
    nsdae_rigid_body body = {.quaternion = {0}};
    for (int j = 0; j < 4; j++) body.quaternion[j] = random_between(&seed, -1, 1);
    for (int j = 0; j < 3; j++) body.position[j] = cell * (place[j] + 0.5) - (j < 2 ? half : 0);
    add_box(w.bodies, (double[3]){1.3 * size, 1.1 * size, 0.95 * size}, &body);
  }
  return w;
}

/* Runs 1 s, and on until the boxes are at rest, when that is depends on rounding: 3 s at most. A
 * step above its tolerance is counted, and the first is a warning; the depth at the end is that of
 * bodies at rest on each other, g dt^2 (see the slop), and a tenth for its tolerance; energy is not
 * gained. */
static void check_lattice(int method)
{
  const double at_rest = 1e-6; /* J, of 27 boxes of 0.1 kg */
  world w = lattice(3);
  nsdae_record r = {.kinetic = 1};
  nsdae_stats stats;
  long above = 0, large = 0, warnings = 0;
  begin(&w, method, 0);
  for (int i = 0; i < STEPS || (i < 3 * STEPS && r.kinetic > at_rest); i++) {
    int status = nsdae_sim_step(w.sim);
    if (status < 0) fail_msg("%s", nsdae_sim_error(w.sim)->text);
    warnings += status == NSDAE_WARN_CONTACT;
    nsdae_sim_get_record(w.sim, &r);
    assert_true(r.contact_tol == 0 || r.contact_tol == SMALL || r.contact_tol == LARGE);
    above += r.lcp_residual > r.contact_tol;
    large += r.contact_tol == LARGE;
    nsdae_sim_get_stats(w.sim, &stats);
    assert_int_equal(stats.inexact_steps, above);
  }
  assert_int_equal(warnings, above > 0);
  assert_true(large > STEPS / 2);
  assert_at_most(r.penetration, 2.2 * G * DT * DT);
  assert_false(stats.warnings & 1);
  assert_at_most(r.kinetic, at_rest);
  end(&w);
}

static void test_lattice(void **state)
{
  (void)state;
  check_lattice(NSDAE_METHOD_MOREAU);
  check_lattice(NSDAE_METHOD_IMPLICIT);
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_option), cmocka_unit_test(test_small),
                                     cmocka_unit_test(test_small_beside_large),
                                     cmocka_unit_test(test_lattice)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
