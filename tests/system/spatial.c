/* Spatial friction: Coulomb's cone (polygon = 0), and the friction polygon against it. */
#include "check.h"

#include "incline.h"
#include "rolling_ball.h"

enum { METHODS = 3 };

static const double pi = 3.14159265358979324;

/* Runs the model to t_end; every record goes to the observer. */
static void integrate(const driver_model *model, int method, int edges, double dt, double t_end,
                      nsdae_observer_fn observe, void *user)
{
  nsdae_system *system;
  nsdae_sim *sim;
  nsdae_sim_options options;
  double q0[7] = {0}, v0[6] = {0};
  nsdae_sim_options_default(&options);
  options.method = method;
  options.dt = dt;
  options.polygon = edges;
  assert_int_equal(model->build(model->base, &system, NULL), NSDAE_OK);
  assert_int_equal(nsdae_sim_create(system, &options, &sim, NULL), NSDAE_OK);
  model->start(model->base, q0, v0);
  assert_int_equal(nsdae_sim_init(sim, 0, q0, v0), NSDAE_OK);
  nsdae_sim_observe(sim, observe, user);
  int status = nsdae_sim_run(sim, t_end);
  if (status < 0) print_message("%s\n", nsdae_sim_error(sim)->text);
  assert_int_equal(status, NSDAE_OK);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
}

typedef struct last {
  double t, q[7], v[7], fastest; /* fastest: of all records */
  double worst_friction;         /* largest |Lambda_T| / Lambda_N */
  double rolling;                /* time of the first record that sticks */
  int modes[3];
} last;

static int keep(const nsdae_record *r, nsdae_error *error, void *user)
{
  last *l = user;
  (void)error;
  l->t = r->time;
  for (int i = 0; i < 3; i++) {
    l->q[i] = r->q[i];
    l->v[i] = r->v[i];
    l->fastest = fmax(l->fastest, fabs(r->v[i]));
  }
  if (r->step == 0) return 0;
  l->modes[r->mode[0]]++;
  if (r->mode[0] == NSDAE_MODE_STICK && l->rolling == 0) l->rolling = r->time;
  if (r->normal_impulse[0] > 0)
    l->worst_friction =
        fmax(l->worst_friction,
             hypot(r->tangential_impulse[0], r->tangential_impulse[1]) / r->normal_impulse[0]);
  return 0;
}

/* Below the angle of friction of the polygon the block stays: velocity exactly zero, whatever the
 * direction of the fall. */
static void test_block_stays(void **state)
{
  (void)state;
  incline *p = incline_model.base;
  for (int method = 0; method < METHODS; method++)
    for (int edges = 3; edges <= 16; edges += edges < 8 ? 1 : 8)
      for (double turn = 0; turn < 6.3; turn += 0.37) {
        last l = {0};
        nsdae_params_default(incline_model.parameters, p);
        p->vx = p->vy = 0;
        p->turn = turn;
        p->mu = 0.3;
        p->slope = atan(0.99 * p->mu * cos(pi / edges));
        integrate(&incline_model, method, edges, 0.01, 1, keep, &l);
        /* the printed scheme sums its last velocity up anew: rounding of g dt */
        if (method == NSDAE_METHOD_IMPLICIT_PRINTED)
          assert_at_most(l.fastest, 1e-15);
        else
          assert_true(l.fastest == 0);
        assert_int_equal(l.modes[NSDAE_MODE_STICK], 100);
      }
}

/* Above it slides down with the acceleration of Coulomb's law: exactly along an edge direction,
 * with friction between mu cos(pi / p) and mu elsewhere. */
static void test_block_slides(void **state)
{
  (void)state;
  incline *p = incline_model.base;
  for (int method = 0; method < METHODS; method++)
    for (int edges = 4; edges <= 16; edges *= 2) {
      last l = {0};
      nsdae_params_default(incline_model.parameters, p);
      p->vx = p->vy = 0;
      p->slope = 0.6;
      p->turn = 2 * pi / edges;
      integrate(&incline_model, method, edges, 0.01, 1, keep, &l);
      double a = p->g * (sin(p->slope) - p->mu * cos(p->slope));
      /* constant acceleration: exact for every method, to rounding of 100 steps */
      assert_near(hypot(l.v[0], l.v[1]), a, 1e-13);
      assert_near(atan2(l.v[1], l.v[0]), p->turn, 1e-13);
      assert_near(l.worst_friction, p->mu, 1e-13);
      l = (last){0};
      p->turn = 0.7 * pi / edges;
      integrate(&incline_model, method, edges, 0.01, 1, keep, &l);
      double speed = hypot(l.v[0], l.v[1]);
      double least = p->g * (sin(p->slope) - p->mu * cos(p->slope));
      double most = p->g * (sin(p->slope) - p->mu * cos(pi / edges) * cos(p->slope));
      assert_true(speed >= least - 1e-12 && speed <= most * 1.02);
      assert_at_most(l.worst_friction, p->mu * (1 + 1e-13));
    }
}

/* A sliding and spinning ball ends rolling with (5 v + 2 r (w_y, -w_x)) / 7, whatever the polygon:
 * the moment about the contact is zero. */
static void test_ball(void **state)
{
  (void)state;
  rolling_ball *p = rolling_ball_model.base;
  for (int method = 0; method < METHODS; method++)
    for (int edges = 0; edges <= 32; edges = edges == 0 ? 4 : 2 * edges) {
      last l = {0};
      const double dt = 0.001;
      nsdae_params_default(rolling_ball_model.parameters, p);
      integrate(&rolling_ball_model, method, edges, dt, 1, keep, &l);
      double slip = hypot(p->vx - p->r * p->wy, p->vy + p->r * p->wx);
      /* rounding of a thousand steps */
      assert_near(l.v[0], (5 * p->vx + 2 * p->r * p->wy) / 7, 1e-13);
      assert_near(l.v[1], (5 * p->vy - 2 * p->r * p->wx) / 7, 1e-13);
      /* a solved LCP has a residual of 1e-10 at most */
      assert_at_most(l.worst_friction, p->mu * (1 + 1e-10));
      /* rolling begins on time but for the polygon, whose friction is mu cos(pi/p) .. mu */
      double begins = 2 * slip / (7 * p->mu * p->g);
      double least = edges > 0 ? cos(pi / edges) : 1;
      assert_true(l.rolling >= begins - dt && l.rolling <= begins / least + 2 * dt);
    }
}

/* With the cone a block stays below the angle of friction itself, in every direction. */
static void test_block_stays_in_cone(void **state)
{
  (void)state;
  incline *p = incline_model.base;
  for (int method = 0; method < METHODS; method++)
    for (double turn = 0; turn < 6.3; turn += 0.37) {
      last l = {0};
      nsdae_params_default(incline_model.parameters, p);
      p->vx = p->vy = 0;
      p->turn = turn;
      p->slope = atan(p->mu * (1 - 1e-9));
      integrate(&incline_model, method, 0, 0.01, 1, keep, &l);
      if (method == NSDAE_METHOD_IMPLICIT_PRINTED)
        assert_at_most(l.fastest, 1e-15);
      else
        assert_true(l.fastest == 0);
      assert_int_equal(l.modes[NSDAE_MODE_STICK], 100);
    }
}

/* Down the fall line, whatever its direction: the block keeps it, and has the acceleration of
 * Coulomb's law. */
static void test_block_keeps_direction(void **state)
{
  (void)state;
  incline *p = incline_model.base;
  for (int method = 0; method < METHODS; method++)
    for (double turn = 0; turn < 6.3; turn += 0.31) {
      last l = {0};
      nsdae_params_default(incline_model.parameters, p);
      p->slope = 0.6;
      p->turn = turn;
      p->vx = 0.5 * cos(turn);
      p->vy = 0.5 * sin(turn);
      integrate(&incline_model, method, 0, 0.01, 1, keep, &l);
      double along = cos(turn) * l.v[0] + sin(turn) * l.v[1];
      double across = cos(turn) * l.v[1] - sin(turn) * l.v[0];
      assert_near(across / along, 0, 1e-10);
      assert_near(along, 0.5 + p->g * (sin(p->slope) - p->mu * cos(p->slope)), 1e-10);
      assert_near(l.worst_friction, p->mu, 1e-12);
      assert_int_equal(l.modes[NSDAE_MODE_SLIP], 100);
    }
}

/* Thrown obliquely on a level plane it goes straight on until it stops, after v^2 / (2 mu g). */
static void test_block_goes_straight(void **state)
{
  (void)state;
  incline *p = incline_model.base;
  for (int method = 0; method < METHODS; method++)
    for (double turn = 0.1; turn < 6.3; turn += 0.7) {
      last l = {0};
      const double speed = 0.5, dt = 1e-3;
      nsdae_params_default(incline_model.parameters, p);
      p->slope = 0;
      p->vx = speed * cos(turn);
      p->vy = speed * sin(turn);
      integrate(&incline_model, method, 0, dt, 0.5, keep, &l);
      double way = hypot(l.q[0], l.q[1]), across = cos(turn) * l.q[1] - sin(turn) * l.q[0];
      assert_near(across / way, 0, 1e-10);
      assert_near(way, speed * speed / (2 * p->mu * p->g), speed * dt);
      assert_true(method == NSDAE_METHOD_IMPLICIT_PRINTED || (l.v[0] == 0 && l.v[1] == 0));
      assert_int_equal(l.modes[NSDAE_MODE_OPEN], 0);
    }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_block_stays),
      cmocka_unit_test(test_block_slides),
      cmocka_unit_test(test_ball),
      cmocka_unit_test(test_block_stays_in_cone),
      cmocka_unit_test(test_block_keeps_direction),
      cmocka_unit_test(test_block_goes_straight),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
