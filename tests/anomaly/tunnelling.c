/* Balls that are thrown at thin walls by the time-stepping methods, at steps of all lengths. Every
 * ball that passes has a warning; below the step of the warning's text no ball passes. What moves
 * fast and cannot pass has no warning of tunnelling. What enters a plane is in the certificate of
 * that step. NSDAE_TUNNELLING is how many balls (400). */
#include "check.h"

#include <stdlib.h>

#include "random.h"
#include "run_bodies.h"

typedef struct ball {
  int dimension, listed, method;
  double radius, thick, speed, gap, dt, e_n; /* gap: at the start */
} ball;

static ball draw(uint64_t *seed)
{
  static const int methods[] = {NSDAE_METHOD_IMPLICIT, NSDAE_METHOD_IMPLICIT_PRINTED,
                                NSDAE_METHOD_MOREAU};
  ball b = {.dimension = 2 + random_below(seed, 2), .listed = random_below(seed, 2)};
  b.method = methods[random_below(seed, 3)];
  b.radius = pow(10, random_between(seed, -2, 0));
  b.thick = b.radius * random_between(seed, 0.01, 2);
  b.speed = pow(10, random_between(seed, 0, 2));
  double steps = random_between(seed, 0.1, 3); /* of all widths in one */
  b.dt = steps * (2 * b.radius + b.thick) / b.speed;
  b.gap = b.speed * b.dt * random_between(seed, 0.05, 4);
  b.e_n = random_below(seed, 3) / 2.0;
  return b;
}

/* Where a gap that closes by more in a step is reported: docs/methods/warnings.md. */
static double least_way(const ball *b)
{
  return (2 * b->radius + b->thick) / (b->method == NSDAE_METHOD_MOREAU ? 2 : 4);
}

enum { PASSED = 1, WARNED = 2, TUNNELLING = 4 };

/* plane: in place of the wall; aside: how far the ball flies beside it. */
static int throw(const ball *b, int plane, double aside)
{
  const double x[2] = {-b->thick / 2, b->thick / 2}, wide = 20 * b->radius;
  const double corner[8] = {x[0], -wide, x[1], -wide, x[1], wide, x[0], wide};
  nsdae_solid wall = {.shape = NSDAE_SHAPE_BOX, .length = {b->thick, 2 * wide, 2 * wide}};
  if (b->dimension == 2)
    wall = (nsdae_solid){.shape = NSDAE_SHAPE_POLYGON, .points = 4, .point = corner};
  if (plane) {
    const nsdae_solid turned[2] = {{.angle = acos(0)},
                                   {.quaternion = {sqrt(0.5), 0, -sqrt(0.5), 0}}};
    wall = turned[b->dimension - 2];
    wall.shape = NSDAE_SHAPE_PLANE;
    wall.position[0] = x[0];
  }
  nsdae_bodies *bodies;
  nsdae_system *system;
  nsdae_sim_options o;
  nsdae_record r;
  assert_int_equal(nsdae_bodies_create(b->dimension, &bodies, NULL), NSDAE_OK);
  int of_wall = nsdae_bodies_add_solid(bodies, NSDAE_GROUND, &wall);
  int body =
      nsdae_bodies_add(bodies, &(nsdae_rigid_body){.mass = 1,
                                                   .inertia = {1, 1, 1},
                                                   .position = {x[0] - b->radius - b->gap, aside},
                                                   .quaternion = {1},
                                                   .velocity = {b->speed}});
  int of_ball = nsdae_bodies_add_solid(
      bodies, body,
      &(nsdae_solid){.shape = b->dimension == 2 ? NSDAE_SHAPE_DISC : NSDAE_SHAPE_SPHERE,
                     .radius = b->radius});
  if (b->listed)
    nsdae_bodies_set_pair(bodies, 0, 0, 0, b->e_n, 0);
  else if (nsdae_bodies_add_contact(bodies, of_wall, of_ball, 0, b->e_n, 0) < 0)
    fail_msg("%s", nsdae_bodies_error(bodies)->text);
  nsdae_sim_options_default(&o);
  o.method = b->method;
  o.dt = b->dt;
  nsdae_sim *sim = start(bodies, &o, &system);
  int found = 0;
  for (int i = 0; i < 12 + b->gap / (b->speed * b->dt); i++) {
    int status = nsdae_sim_step(sim);
    const nsdae_error *e = nsdae_sim_error(sim);
    if (status < 0) fail_msg("%s", e->text);
    if (status == NSDAE_WARN_PENETRATION)
      found |= WARNED | (strstr(e->text, "(tunnelling); make dt smaller") ? TUNNELLING : 0);
  }
  nsdae_sim_get_record(sim, &r);
  if (r.q[0] > x[1]) found |= PASSED;
  end(bodies, system, sim);
  return found;
}

static void test_walls(void **state)
{
  const char *asked = getenv("NSDAE_TUNNELLING");
  int passed = 0, warned = 0, balls = asked ? atoi(asked) : 400;
  uint64_t seed = 11;
  (void)state;
  for (int i = 0; i < balls; i++) {
    ball b = draw(&seed);
    int found = throw(&b, 0, 0);
    passed += !!(found & PASSED), warned += !!(found & WARNED);
    if ((found & PASSED) && !(found & WARNED)) fail_msg("ball %d passes without a warning", i);
    if (b.speed * b.dt > least_way(&b) && !(found & WARNED)) fail_msg("ball %d: no warning", i);
    if (b.speed * b.dt < least_way(&b) && (found & TUNNELLING)) fail_msg("ball %d: warning", i);
    b.dt *= 0.99 * fmin(1, least_way(&b) / (b.speed * b.dt));
    found = throw(&b, 0, 0);
    if (found & (PASSED | TUNNELLING)) fail_msg("ball %d passes at a short step", i);
  }
  print_message("%d balls: %d pass, %d with a warning\n", balls, passed, warned);
  assert_true(passed > balls / 4);
}

/* A ball that falls on a plane: after each step the certificate has its overlap at the end of that
 * step, as fixed contact and by list, also of the step that enters; above a quarter of its width
 * there is a warning. Rounding of positions: 1e-15 of the way. */
static void drop(const ball *b, uint64_t *seed)
{
  double height = b->radius + b->gap;
  nsdae_bodies *bodies;
  nsdae_system *system;
  nsdae_sim_options o;
  nsdae_record r;
  nsdae_stats stats;
  assert_int_equal(nsdae_bodies_create(b->dimension, &bodies, NULL), NSDAE_OK);
  int up = b->dimension - 1;
  double gravity[3] = {0}, position[3] = {0}, velocity[3] = {0};
  gravity[up] = -9.81, position[up] = height, velocity[up] = -b->speed;
  velocity[0] = random_between(seed, -1, 1);
  nsdae_bodies_set_gravity(bodies, gravity);
  int plane =
      nsdae_bodies_add_solid(bodies, NSDAE_GROUND, &(nsdae_solid){.shape = NSDAE_SHAPE_PLANE});
  nsdae_rigid_body body = {.mass = 1, .inertia = {1, 1, 1}, .quaternion = {1}};
  memcpy(body.position, position, sizeof position);
  memcpy(body.velocity, velocity, sizeof velocity);
  int of_ball = nsdae_bodies_add_solid(
      bodies, nsdae_bodies_add(bodies, &body),
      &(nsdae_solid){.shape = b->dimension == 2 ? NSDAE_SHAPE_DISC : NSDAE_SHAPE_SPHERE,
                     .radius = b->radius});
  int status = b->listed ? nsdae_bodies_set_pair(bodies, 0, 0, 0.3, b->e_n, 0)
                         : nsdae_bodies_add_contact(bodies, plane, of_ball, 0.3, b->e_n, 0);
  if (status < 0) fail_msg("%s", nsdae_bodies_error(bodies)->text);
  nsdae_sim_options_default(&o);
  o.method = b->method;
  o.dt = b->dt;
  if (random_below(seed, 2)) o.projection = NSDAE_PROJECTION_NONE;
  nsdae_sim *sim = start(bodies, &o, &system);
  /* moreau reads gaps at the middle of a step in which nothing moves by the slop, h^2 g / 2 */
  double deepest = 0,
         late = b->listed && b->method == NSDAE_METHOD_MOREAU ? 9.81 * b->dt * b->dt / 4 : 0;
  for (int i = 0; i < 30; i++) {
    if (nsdae_sim_step(sim) < 0) fail_msg("%s", nsdae_sim_error(sim)->text);
    nsdae_sim_get_record(sim, &r);
    double depth = fmax(0, b->radius - r.q[up]), way = height + fabs(r.q[up]) + b->radius;
    deepest = fmax(deepest, depth);
    assert_near(r.certificate.penetration, depth, 1e-14 * way + late);
  }
  nsdae_sim_get_stats(sim, &stats);
  if (deepest > b->radius / 2) assert_true(stats.warnings & 2);
  end(bodies, system, sim);
}

static void test_entered(void **state)
{
  uint64_t seed = 13;
  (void)state;
  for (int i = 0; i < 300; i += test_share()) {
    ball b = draw(&seed);
    drop(&b, &seed);
  }
}

/* A plane has no opposite side; beside the wall, by more than the way of a step, is nothing. */
static void test_none(void **state)
{
  uint64_t seed = 12;
  (void)state;
  for (int i = 0; i < 200; i++) {
    ball b = draw(&seed);
    assert_int_equal(throw(&b, 1, 0) & TUNNELLING, 0);
    assert_int_equal(throw(&b, 0, 21 * b.radius + 1.01 * b.speed * b.dt) & WARNED, 0);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_walls), cmocka_unit_test(test_none),
                                     cmocka_unit_test(test_entered)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
