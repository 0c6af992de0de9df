/* Mechanisms of the kit at their start: its own formulas are not checked as a user's, those of the
 * user beside them are, and what is degenerate is named as a joint, spring, load or contact. */
#include "check.h"

#include <nsdae/nsdae.h>

#include "support/random.h"

static const double gravity[2][3] = {{0, -9.81, 0}, {0, 0, -9.81}};

typedef struct world {
  nsdae_bodies *bodies;
  nsdae_system *system;
  nsdae_sim *sim;
  double q[64], v[64];
  int own_contact; /* the last is the user's */
} world;

static world begin(int dimension)
{
  world w = {.bodies = NULL};
  assert_int_equal(nsdae_bodies_create(dimension, &w.bodies, NULL), NSDAE_OK);
  nsdae_bodies_set_gravity(w.bodies, gravity[dimension - 2]);
  return w;
}

static int body(world *w, double x, double y, double z)
{
  return nsdae_bodies_add(w->bodies, &(nsdae_rigid_body){.mass = 2,
                                                         .inertia = {0.1, 0.2, 0.3},
                                                         .position = {x, y, z},
                                                         .quaternion = {1, 0, 0, 0}});
}

static int start(world *w, int method, int start_check)
{
  nsdae_sim_options o;
  nsdae_error error;
  nsdae_dims dims;
  int status = nsdae_bodies_system(w->bodies, &w->system);
  if (status < 0) print_error("%s\n", nsdae_bodies_error(w->bodies)->text);
  assert_true(status >= 0);
  nsdae_bodies_get_dims(w->bodies, &dims);
  if (w->own_contact) nsdae_system_set_contact(w->system, dims.k - 1, 0.1, 0, 0);
  nsdae_sim_options_default(&o);
  o.method = method;
  o.dt = 1e-2;
  o.start_check = start_check;
  assert_int_equal(nsdae_sim_create(w->system, &o, &w->sim, &error), NSDAE_OK);
  nsdae_bodies_get_start(w->bodies, w->q, w->v);
  return nsdae_sim_init(w->sim, 0, w->q, w->v);
}

static void end(world *w)
{
  nsdae_sim_destroy(&w->sim);
  nsdae_system_destroy(&w->system);
  nsdae_bodies_destroy(&w->bodies);
}

static void named(const world *w, int status, const char *argument, int index, const char *text)
{
  const nsdae_error *e = nsdae_sim_error(w->sim);
  if (e->status != status || !strstr(e->text, text)) print_error("%d: %s\n", e->status, e->text);
  assert_int_equal(e->status, status);
  assert_non_null(strstr(e->text, text));
  assert_string_equal(e->argument, argument);
  assert_int_equal(e->index, index);
}

/* ---- rows of blocks on a floor, any two of which may touch */

static uint64_t seed;

static double uniform(double from, double to)
{
  return random_between(&seed, from, to);
}

enum { BLOCKS_MOST = 4 };

/* Blocks of one size, or of two, that are apart by multiples of a quarter of a width: their edges
 * are equally near, and touch at a distance of 0. */
static void row_of_blocks(world *w, int dimension)
{
  const double width = 0.1, height[2] = {0.5, uniform(0, 1) < 0.5 ? 0.5 : 0.25};
  int count = 2 + (int)uniform(0, BLOCKS_MOST - 1), solid[BLOCKS_MOST];
  double x = uniform(-1, 1);
  int floor =
      nsdae_bodies_add_solid(w->bodies, NSDAE_GROUND, &(nsdae_solid){.shape = NSDAE_SHAPE_PLANE});
  for (int i = 0; i < count; i++) {
    double h = height[i % 2], a = width / 2, b = h / 2;
    const double corner[8] = {-a, -b, a, -b, a, b, -a, b};
    int number = dimension == 2 ? body(w, x, b, 0) : body(w, x, 0, b);
    solid[i] = nsdae_bodies_add_solid(
        w->bodies, number,
        &(nsdae_solid){.shape = dimension == 2 ? NSDAE_SHAPE_POLYGON : NSDAE_SHAPE_BOX,
                       .points = 4,
                       .point = corner,
                       .length = {width, width, h}});
    x += width * (1 + 0.25 * (1 + (int)uniform(0, 8)));
    nsdae_bodies_add_contact(w->bodies, floor, solid[i], 0.4, 0, 0);
    if (i > 0) nsdae_bodies_add_contact(w->bodies, solid[i - 1], solid[i], 0.2, 0, 0);
  }
}

/* They stay where they are. */
static void test_rows_of_blocks(void **state)
{
  (void)state;
  const int methods[] = {NSDAE_METHOD_EVENT, NSDAE_METHOD_IMPLICIT, NSDAE_METHOD_MOREAU};
  for (int i = 0; i < 24; i++) {
    int dimension = i % 8 == 7 ? 3 : 2, nq = dimension == 2 ? 3 : 7;
    seed = 100 + (unsigned)i;
    world w = begin(dimension);
    nsdae_record r;
    row_of_blocks(&w, dimension);
    int status = start(&w, methods[i % 3], 1);
    if (status == NSDAE_OK) status = nsdae_sim_run(w.sim, 0.05);
    if (status != NSDAE_OK) print_error("%d: %s\n", i, nsdae_sim_error(w.sim)->text);
    assert_int_equal(status, NSDAE_OK);
    nsdae_sim_get_record(w.sim, &r);
    for (int j = 0; j < 2 * nq; j++) assert_near(r.q[j], w.q[j], 1e-12);
    end(&w);
  }
}

/* ---- a pin in a hole */

static void pin(world *w, int dimension, double off)
{
  int hole = nsdae_bodies_add_solid(
      w->bodies, NSDAE_GROUND,
      &(nsdae_solid){.shape = dimension == 2 ? NSDAE_SHAPE_DISC : NSDAE_SHAPE_SPHERE,
                     .radius = 0.0505,
                     .hollow = dimension == 2});
  int disc = nsdae_bodies_add_solid(
      w->bodies, body(w, off, 0, 0),
      &(nsdae_solid){.shape = dimension == 2 ? NSDAE_SHAPE_DISC : NSDAE_SHAPE_SPHERE,
                     .radius = 0.05});
  nsdae_bodies_add_contact(w->bodies, hole, disc, 0.1, 0.5, 0);
}

static void test_pin(void **state)
{
  (void)state;
  const int methods[] = {NSDAE_METHOD_EVENT, NSDAE_METHOD_IMPLICIT, NSDAE_METHOD_MOREAU};
  for (int i = 0; i < 9; i++) {
    const double off[3] = {0, 1e-9, -3e-12};
    world w = begin(2);
    pin(&w, 2, off[i / 3]);
    int status = start(&w, methods[i % 3], 1);
    assert_int_equal(status, i < 3 ? NSDAE_E_ARGUMENT : NSDAE_OK);
    if (i < 3)
      named(&w, status, "contact", 0,
            "contact 0 (hole 0 of the ground, disc 1 of body 0): the centres coincide: no normal");
    else
      assert_int_equal(nsdae_sim_run(w.sim, 0.5), NSDAE_OK);
    end(&w);
    w = begin(2);
    pin(&w, 2, off[i / 3]);
    assert_int_equal(start(&w, methods[i % 3], 0), NSDAE_OK);
    end(&w);
  }
  const nsdae_solid plane = {.shape = NSDAE_SHAPE_PLANE},
                    disc = {.shape = NSDAE_SHAPE_DISC, .radius = 1};
  world w = begin(2); /* the centre of a disc on a plane's origin is an overlap: it has a normal */
  int floor = nsdae_bodies_add_solid(w.bodies, NSDAE_GROUND, &plane);
  nsdae_bodies_add_contact(w.bodies, floor,
                           nsdae_bodies_add_solid(w.bodies, body(&w, 0, 0, 0), &disc), 0, 0, 0);
  assert_int_equal(start(&w, NSDAE_METHOD_MOREAU, 1), NSDAE_E_ARGUMENT);
  named(&w, NSDAE_E_ARGUMENT, "q0", 0, "overlaps by 1 at the start: it must be at most 0.2");
  end(&w);
  w = begin(3);
  pin(&w, 3, 0);
  assert_int_equal(start(&w, NSDAE_METHOD_MOREAU, 1), NSDAE_E_ARGUMENT);
  named(&w, NSDAE_E_ARGUMENT, "contact", 0, "(sphere 0 of the ground, sphere 1 of body 0)");
  end(&w);
}

/* ---- derivatives of the user's beside those of the kit */

static double sign;  /* of what the user gives: -1 is wrong */
static double level; /* of the user's constraint at the start */

static int own_gap(double t, const double *q, double *g, void *user)
{
  (void)t, (void)user;
  g[0] = 3 + q[1] + q[0] * q[0];
  return 0;
}

static int own_normal(double t, const double *q, double *W, int ldw, void *user)
{
  (void)t, (void)ldw, (void)user;
  W[0] = 2 * q[0];
  W[1] = sign;
  return 0;
}

static int own_tangent(double t, const double *q, double *W, int ldw, void *user)
{
  (void)t, (void)q, (void)ldw, (void)user;
  W[0] = 1;
  return 0;
}

static int own_bias(double t, const double *q, double *w_n, double *w_t, void *user)
{
  (void)t, (void)q, (void)w_n, (void)w_t, (void)user;
  return 0;
}

static int own_acceleration(double t, const double *q, const double *v, double *n, double *tt,
                            double *s, void *user)
{
  (void)t, (void)q, (void)tt, (void)s, (void)user;
  n[0] = sign * 2 * v[0] * v[0];
  return 0;
}

static int own_constraint(double t, const double *q, double *phi, void *user)
{
  (void)t, (void)user;
  phi[0] = q[3] - 2 * q[0] - level;
  return 0;
}

static int own_jacobian(double t, const double *q, double *J, int ldj, void *user)
{
  (void)t, (void)q, (void)user;
  J[0] = -2;
  J[3 * ldj] = sign;
  return 0;
}

static int own_constraint_bias(double t, const double *q, const double *v, double *phi_t,
                               double *omega, void *user)
{
  (void)t, (void)q, (void)v, (void)phi_t, (void)omega, (void)user;
  return 0;
}

static int drive(double t, double f[3], void *user)
{
  (void)user;
  f[0] = 1 - cos(3 * t);
  f[1] = 3 * sin(3 * t);
  f[2] = sign * 9 * cos(3 * t);
  return 0;
}

enum { NORMAL, ACCELERATION, JACOBIAN, DRIVE, MISTAKES };

/* Two blocks of equally near edges, and the user's part. */
static void own_part(world *w, int mistake)
{
  nsdae_user_rows own = {.dims = {0}};
  seed = 7;
  row_of_blocks(w, 2);
  if (mistake == NORMAL || mistake == ACCELERATION) {
    own.dims.k = w->own_contact = 1;
    own.gap = own_gap;
    own.gap_normal = mistake == NORMAL ? own_normal : NULL;
    own.gap_tangent = own_tangent;
    own.contact_bias = own_bias;
    own.contact_acceleration = own_acceleration;
  }
  if (mistake == JACOBIAN) {
    own.dims.m = 1;
    own.constraint = own_constraint;
    own.constraint_jacobian = own_jacobian;
    own.constraint_bias = own_constraint_bias;
  }
  nsdae_bodies_get_start(w->bodies, w->q, w->v);
  level = w->q[3] - 2 * w->q[0];
  if (mistake != DRIVE) assert_int_equal(nsdae_bodies_set_user_rows(w->bodies, &own), NSDAE_OK);
  int extra = body(w, 3, 4, 0);
  if (mistake == DRIVE)
    nsdae_bodies_add_joint(w->bodies, &(nsdae_joint){.kind = NSDAE_JOINT_PRISMATIC,
                                                     .body = {NSDAE_GROUND, extra},
                                                     .point = {3, 4},
                                                     .axis = {1},
                                                     .drive = drive});
}

static void test_own_parts_are_checked(void **state)
{
  (void)state;
  static const char *const callback[MISTAKES] = {"gap_normal", "contact_acceleration",
                                                 "constraint_jacobian", "joint"};
  for (int mistake = 0; mistake < MISTAKES; mistake++)
    for (sign = -1; sign <= 1; sign += 2) {
      world w = begin(2);
      own_part(&w, mistake);
      int status = start(&w, NSDAE_METHOD_EVENT, 1);
      const nsdae_error *e = nsdae_sim_error(w.sim);
      if (sign < 0) {
        assert_int_equal(status, NSDAE_E_DERIVATIVE);
        assert_string_equal(e->argument, callback[mistake]);
        if (mistake == DRIVE) assert_non_null(strstr(e->text, "prismatic joint 0 of body"));
      } else {
        assert_int_equal(status, NSDAE_OK);
      }
      end(&w);
    }
}

/* ---- what is degenerate, in the words of the kit */

typedef enum failing { FAILS_NOT, RETURNS, GIVES_NAN } failing;

static int failing_drive(double t, double f[3], void *user)
{
  const failing *how = user;
  (void)t;
  f[0] = 1;
  if (*how == GIVES_NAN) f[2] = NAN;
  return *how == RETURNS ? -7 : 0;
}

static int vanishing_drive(double t, double f[3], void *user)
{
  (void)user;
  f[0] = 1 - t;
  f[1] = -1;
  return 0;
}

static int failing_load(double t, const double position[3], const double velocity[3],
                        double force[3], double torque[3], void *user)
{
  const failing *how = user;
  (void)t, (void)position, (void)velocity;
  force[0] = 1;
  if (*how == GIVES_NAN) torque[2] = INFINITY;
  return *how == RETURNS ? -7 : 0;
}

static void test_drives_and_loads(void **state)
{
  (void)state;
  for (failing how = RETURNS; how <= GIVES_NAN; how++) {
    int status = how == RETURNS ? NSDAE_E_CALLBACK : NSDAE_E_NONFINITE;
    world w = begin(3);
    const double point[3] = {0, 0, 1};
    body(&w, 5, 5, 5);
    nsdae_bodies_add_joint(w.bodies, &(nsdae_joint){.kind = NSDAE_JOINT_SPHERICAL,
                                                    .body = {NSDAE_GROUND, 0},
                                                    .point = {5, 5, 5}});
    nsdae_bodies_add_joint(w.bodies, &(nsdae_joint){.kind = NSDAE_JOINT_DISTANCE,
                                                    .body = {body(&w, 0, 0, 1), 0},
                                                    .point = {0, 0, 1},
                                                    .end = {4, 5, 5},
                                                    .drive = failing_drive,
                                                    .user = &how});
    assert_int_equal(start(&w, NSDAE_METHOD_MOREAU, 1), status);
    named(&w, status, "joint", 1,
          how == RETURNS ? "the drive of distance joint 1 of bodies 1, 0 returned -7"
                         : "the drive of distance joint 1 of bodies 1, 0 gave f'' = nan");
    end(&w);
    w = begin(3);
    failing not = FAILS_NOT;
    body(&w, 0, 0, 1);
    nsdae_bodies_add_load(w.bodies, 0, point, failing_load, &not );
    nsdae_bodies_add_load(w.bodies, 0, point, failing_load, &how);
    assert_int_equal(start(&w, NSDAE_METHOD_MOREAU, 1), status);
    named(&w, status, "load", 1,
          how == RETURNS ? "load 1 of body 0 returned -7"
                         : "load 1 of body 0 gave torque[2] = inf");
    end(&w);
  }
}

static void test_no_length(void **state)
{
  (void)state;
  world w = begin(2);
  body(&w, 1, 2, 0);
  nsdae_bodies_add_spring(w.bodies,
                          &(nsdae_spring){.body = {NSDAE_GROUND, 0}, .point = {9}, .stiffness = 1});
  nsdae_bodies_add_spring(
      w.bodies,
      &(nsdae_spring){
          .body = {NSDAE_GROUND, 0}, .point = {1, 2}, .end = {1.5, 2}, .stiffness = 1, .rest = 1});
  assert_int_equal(start(&w, NSDAE_METHOD_MOREAU, 0), NSDAE_OK);
  w.q[0] -= 0.5; /* the end at the point */
  int status = nsdae_sim_init(w.sim, 0, w.q, w.v);
  if (status == NSDAE_OK) status = nsdae_sim_step(w.sim);
  assert_int_equal(status, NSDAE_E_NONFINITE);
  named(&w, NSDAE_E_NONFINITE, "spring", 1,
        "spring 1 of body 0 and the ground: its ends coincide, its force has no direction");
  end(&w);
  w = begin(2);
  body(&w, 0, 0, 0);
  nsdae_bodies_add_joint(w.bodies, &(nsdae_joint){.kind = NSDAE_JOINT_DISTANCE,
                                                  .body = {NSDAE_GROUND, 0},
                                                  .end = {1},
                                                  .drive = vanishing_drive});
  assert_int_equal(start(&w, NSDAE_METHOD_MOREAU, 0), NSDAE_E_ARGUMENT); /* v0 = 0 */
  named(&w, NSDAE_E_ARGUMENT, "v0", 0, "(distance joint 0 of body 0 and the ground)");
  w.q[0] = -1; /* the point (1, 0) of the body at the origin */
  assert_int_equal(nsdae_sim_init(w.sim, 0, w.q, w.v), NSDAE_E_NONFINITE);
  named(&w, NSDAE_E_NONFINITE, "joint", 0,
        "distance joint 0 of body 0 and the ground: its ends coincide, it has no direction");
  end(&w);
}

/* Rows that depend on each other, overlaps, contacts of a list. */
static void test_words(void **state)
{
  (void)state;
  world w = begin(2);
  body(&w, 0, 0, 0);
  for (int i = 0; i < 2; i++)
    nsdae_bodies_add_joint(w.bodies,
                           &(nsdae_joint){.kind = NSDAE_JOINT_REVOLUTE, .body = {NSDAE_GROUND, 0}});
  assert_int_equal(start(&w, NSDAE_METHOD_IMPLICIT, 1), NSDAE_E_RANK);
  assert_non_null(strstr(nsdae_sim_error(w.sim)->text, "(revolute joint"));
  end(&w);
  for (int k = 0; k < 4; k++) { /* a tenth of a disc is 0.2 */
    const int listed = k % 2, deep = k / 2;
    const nsdae_solid ball = {.shape = NSDAE_SHAPE_DISC, .radius = 1};
    w = begin(2);
    for (int i = 0; i < 3; i++)
      nsdae_bodies_add_solid(w.bodies, body(&w, (deep ? 1.5 : 1.9) * i * i, 0, 0), &ball);
    if (listed) nsdae_bodies_set_pair(w.bodies, 0, 0, 0, 0, 0);
    if (!listed) nsdae_bodies_add_contact(w.bodies, 0, 1, 0, 0, 0);
    int status = deep ? NSDAE_E_ARGUMENT : NSDAE_WARN_PENETRATION;
    assert_int_equal(start(&w, NSDAE_METHOD_MOREAU, 1), deep ? status : NSDAE_OK);
    if (!deep) assert_int_equal(nsdae_sim_step(w.sim), status);
    named(&w, status, "q0", 0,
          deep ? "(disc 0 of body 0, disc 1 of body 1) overlaps by 0.5 at the start: it must be at "
                 "most 0.2, a tenth of its size"
               : "(disc 0 of body 0, disc 1 of body 1) overlaps by 0.1 at the start");
    end(&w);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_rows_of_blocks),
                                     cmocka_unit_test(test_pin),
                                     cmocka_unit_test(test_own_parts_are_checked),
                                     cmocka_unit_test(test_drives_and_loads),
                                     cmocka_unit_test(test_no_length),
                                     cmocka_unit_test(test_words)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
