/* The paper's three systems, written with the kit, against those written by hand: with event at
 * rtol 1e-12, and step by step with moreau to rounding, for which both need the same coordinates
 * and gaps: crank and slider are written by hand once more in absolute coordinates here, and the
 * pendulum's gap where the tip is. */
#include "check.h"

#include <float.h>

#include "clearance_hinge.h"
#include "crank_slider.h"
#include "pendulum.h"

enum { NQ_MAX = 9 };

typedef struct outcome {
  double q[NQ_MAX], v[NQ_MAX];
  long impacts;
} outcome;

static outcome run(nsdae_system *system, const double *q0, const double *v0, int method, double dt,
                   double t_end)
{
  outcome out = {.impacts = 0};
  nsdae_sim *sim;
  nsdae_sim_options options;
  nsdae_record record;
  nsdae_stats stats;
  nsdae_dims dims;
  nsdae_error error;
  nsdae_sim_options_default(&options);
  options.method = method;
  options.dt = dt;
  options.rtol = 1e-12;
  options.atol = 1e-14;
  int status = nsdae_sim_create(system, &options, &sim, &error);
  if (status < 0) print_error("%s\n", error.text);
  assert_int_equal(status, NSDAE_OK);
  assert_int_equal(nsdae_sim_init(sim, 0, q0, v0), NSDAE_OK);
  status = nsdae_sim_run(sim, t_end);
  if (status < 0) print_error("%s\n", nsdae_sim_error(sim)->text);
  assert_true(status >= 0);
  nsdae_sim_get_record(sim, &record);
  nsdae_sim_get_stats(sim, &stats);
  nsdae_sim_get_dims(sim, &dims);
  memcpy(out.q, record.q, (size_t)dims.nq * sizeof *out.q);
  memcpy(out.v, record.v, (size_t)dims.nv * sizeof *out.v);
  out.impacts = stats.impacts;
  nsdae_sim_destroy(&sim);
  return out;
}

/* Steps of moreau from each state that the system written by hand comes through, taken by both:
 * the most that q and v, in parts of 1 + what they are, differ after one step. */
static double apart_in_a_step(nsdae_system *const system[2], const double *q0, const double *v0,
                              double dt, int steps)
{
  nsdae_sim *sim[2];
  nsdae_sim_options options;
  nsdae_record r[2];
  nsdae_dims d;
  double most = 0;
  nsdae_sim_options_default(&options);
  options.method = NSDAE_METHOD_MOREAU;
  options.projection = NSDAE_PROJECTION_NONE; /* one step of the scheme alone */
  options.dt = dt;
  options.contact_tol = 1e-14;
  options.start_tol = 1; /* the scheme drifts */
  options.start_check = 0;
  for (int k = 0; k < 2; k++)
    assert_int_equal(nsdae_sim_create(system[k], &options, &sim[k], NULL), NSDAE_OK);
  nsdae_sim_get_dims(sim[0], &d);
  assert_int_equal(nsdae_sim_init(sim[0], 0, q0, v0), NSDAE_OK);
  for (int i = 0; i < steps; i++) {
    double q[NQ_MAX], v[NQ_MAX];
    nsdae_sim_get_record(sim[0], &r[0]);
    double t = r[0].time;
    memcpy(q, r[0].q, (size_t)d.nq * sizeof *q);
    memcpy(v, r[0].v, (size_t)d.nq * sizeof *v);
    for (int k = 0; k < 2; k++) {
      assert_int_equal(nsdae_sim_init(sim[k], t, q, v), NSDAE_OK);
      assert_true(nsdae_sim_step(sim[k]) >= 0);
      nsdae_sim_get_record(sim[k], &r[k]);
    }
    assert_int_equal(r[0].impacts, r[1].impacts);
    for (int j = 0; j < d.nq; j++) {
      most = fmax(most, fabs(r[0].q[j] - r[1].q[j]) / (1 + fabs(r[0].q[j])));
      most = fmax(most, fabs(r[0].v[j] - r[1].v[j]) / (1 + fabs(r[0].v[j])));
    }
  }
  for (int k = 0; k < 2; k++) nsdae_sim_destroy(&sim[k]);
  return most;
}

/* What the model written by hand does. */
static outcome by_hand(const driver_model *model, int method, double dt, double t_end)
{
  nsdae_system *system;
  double q0[NQ_MAX] = {0}, v0[NQ_MAX] = {0};
  assert_int_equal(model->build(model->base, &system, NULL), NSDAE_OK);
  model->start(model->base, q0, v0);
  outcome out = run(system, q0, v0, method, dt, t_end);
  nsdae_system_destroy(&system);
  return out;
}

static outcome by_kit(nsdae_bodies *bodies, int method, double dt, double t_end)
{
  nsdae_system *system;
  double q0[NQ_MAX], v0[NQ_MAX];
  int status = nsdae_bodies_system(bodies, &system);
  if (status < 0) print_error("%s\n", nsdae_bodies_error(bodies)->text);
  assert_true(status >= 0);
  nsdae_bodies_get_start(bodies, q0, v0);
  outcome out = run(system, q0, v0, method, dt, t_end);
  nsdae_system_destroy(&system);
  nsdae_bodies_destroy(&bodies);
  return out;
}

static nsdae_bodies *world(double g)
{
  nsdae_bodies *b;
  const double gravity[3] = {0, -g, 0};
  assert_int_equal(nsdae_bodies_create(2, &b, NULL), NSDAE_OK);
  nsdae_bodies_set_gravity(b, gravity);
  return b;
}

/* A uniform rod of length L, from the point (x, y) down at theta from the vertical. */
static int add_rod(nsdae_bodies *b, double m, double L, double x, double y, double theta)
{
  return nsdae_bodies_add(
      b, &(nsdae_rigid_body){.mass = m,
                             .inertia = {0, 0, m * L * L / 12},
                             .position = {x + L / 2 * sin(theta), y - L / 2 * cos(theta)},
                             .angle = theta});
}

static nsdae_bodies *kit_pendulum(const pendulum *p)
{
  nsdae_bodies *b = world(p->g);
  int rod = add_rod(b, p->m, p->L, 0, 0, p->theta_0);
  nsdae_bodies_add_joint(b,
                         &(nsdae_joint){.kind = NSDAE_JOINT_REVOLUTE, .body = {NSDAE_GROUND, rod}});
  int wall = nsdae_bodies_add_solid(
      b, NSDAE_GROUND, &(nsdae_solid){.shape = NSDAE_SHAPE_PLANE, .angle = -acos(-1) / 2});
  int tip = nsdae_bodies_add_solid(
      b, rod, &(nsdae_solid){.shape = NSDAE_SHAPE_POINT, .position = {0, -p->L / 2}});
  nsdae_bodies_add_contact(b, wall, tip, 0, p->e_N, 0);
  return b;
}

static nsdae_bodies *kit_hinge(const clearance_hinge *p)
{
  nsdae_bodies *b = world(p->g);
  int rod = add_rod(b, p->m, p->l, p->dX, p->dY, p->theta_0);
  int hole = nsdae_bodies_add_solid(
      b, NSDAE_GROUND, &(nsdae_solid){.shape = NSDAE_SHAPE_DISC, .radius = p->R, .hollow = 1});
  int shaft = nsdae_bodies_add_solid(
      b, rod, &(nsdae_solid){.shape = NSDAE_SHAPE_DISC, .radius = p->r, .position = {0, p->l / 2}});
  nsdae_bodies_add_contact(b, hole, shaft, p->mu, p->e_N, p->e_T);
  return b;
}

static int crank_torque(double t, const double x[3], const double v[3], double force[3],
                        double torque[3], void *user)
{
  const crank_slider *p = user;
  (void)x;
  (void)v;
  (void)force;
  torque[2] = p->P0 * sin(p->w * t);
  return 0;
}

static nsdae_bodies *kit_crank_slider(crank_slider *p)
{
  nsdae_bodies *b = world(p->g);
  const double pin[3] = {0, -p->L1, 0}, end[3] = {0, -p->L1 - p->L2, 0};
  int crank = add_rod(b, p->m1, p->L1, 0, 0, 0), rod = add_rod(b, p->m2, p->L2, 0, -p->L1, 0);
  int slider = nsdae_bodies_add(
      b, &(nsdae_rigid_body){.mass = p->m3, .inertia = {0, 0, 1}, .position = {0, end[1]}});
  nsdae_bodies_add_joint(
      b, &(nsdae_joint){.kind = NSDAE_JOINT_REVOLUTE, .body = {NSDAE_GROUND, crank}});
  nsdae_bodies_add_joint(b, &(nsdae_joint){.kind = NSDAE_JOINT_REVOLUTE,
                                           .body = {crank, rod},
                                           .point = {pin[0], pin[1]}});
  nsdae_bodies_add_joint(b, &(nsdae_joint){.kind = NSDAE_JOINT_REVOLUTE,
                                           .body = {rod, slider},
                                           .point = {end[0], end[1]}});
  nsdae_bodies_add_joint(b, &(nsdae_joint){.kind = NSDAE_JOINT_SLOT,
                                           .body = {NSDAE_GROUND, slider},
                                           .point = {end[0], end[1]},
                                           .axis = {0, 1},
                                           .mu = p->mu});
  nsdae_bodies_add_spring(b, &(nsdae_spring){.body = {NSDAE_GROUND, slider},
                                             .point = {end[0], end[1] - 1},
                                             .end = {end[0], end[1]},
                                             .stiffness = p->k,
                                             .rest = 1});
  nsdae_bodies_add_load(b, crank, end, crank_torque, p);
  return b;
}

static void expect_same(const outcome *a, const outcome *b, int n, double tol)
{
  for (int i = 0; i < n; i++) {
    assert_near(a->q[i], b->q[i], tol);
    assert_near(a->v[i], b->v[i], tol * 100); /* velocities here are up to 100 times larger */
  }
  assert_int_equal(a->impacts, b->impacts);
}

/* Both from the kit's start, step by step: a step is some tens of roundings. */
static void expect_same_steps(nsdae_system *hand, nsdae_bodies *bodies, double dt, int steps)
{
  nsdae_system *system[2] = {hand};
  double q0[NQ_MAX], v0[NQ_MAX];
  assert_true(nsdae_bodies_system(bodies, &system[1]) >= 0);
  nsdae_bodies_get_start(bodies, q0, v0);
  double most = apart_in_a_step(system, q0, v0, dt, steps);
  print_message("%d steps of moreau: at most %.1e apart after one\n", steps, most);
  assert_at_most(most, 50 * DBL_EPSILON);
  for (int k = 0; k < 2; k++) nsdae_system_destroy(&system[k]);
  nsdae_bodies_destroy(&bodies);
}

/* The kit's gap is where the tip is, that of the model L sin theta: the same but for the drift. */
static int tip_gap(double t, const double *q, double *g, void *user)
{
  const pendulum *p = user;
  (void)t;
  g[0] = q[0] + p->L / 2 * sin(q[2]);
  return 0;
}

static int tip_normal(double t, const double *q, double *W, int ldw, void *user)
{
  const pendulum *p = user;
  (void)t, (void)ldw;
  W[0] = 1;
  W[2] = p->L / 2 * cos(q[2]);
  return 0;
}

static int tip_acceleration(double t, const double *q, const double *v, double *n, double *l,
                            double *s, void *user)
{
  const pendulum *p = user;
  (void)t, (void)l, (void)s;
  n[0] = -p->L / 2 * sin(q[2]) * v[2] * v[2];
  return 0;
}

static void test_pendulum(void **state)
{
  pendulum *p = pendulum_model.base;
  nsdae_system *hand;
  (void)state;
  nsdae_params_default(pendulum_model.parameters, p);
  assert_int_equal(pendulum_model.build(p, &hand, NULL), NSDAE_OK);
  nsdae_system_set_gap(hand, tip_gap);
  nsdae_system_set_gap_normal(hand, tip_normal);
  nsdae_system_set_contact_acceleration(hand, tip_acceleration);
  /* through several impacts */
  expect_same_steps(hand, kit_pendulum(p), 0.005, 1000);
  outcome by = by_hand(&pendulum_model, NSDAE_METHOD_EVENT, 0.01, 1);
  outcome kit = by_kit(kit_pendulum(p), NSDAE_METHOD_EVENT, 0.01, 1);
  expect_same(&by, &kit, 3, 1e-10);
}

static void test_hinge(void **state)
{
  clearance_hinge *p = clearance_hinge_model.base;
  nsdae_system *system;
  (void)state;
  nsdae_params_default(clearance_hinge_model.parameters, p);
  assert_int_equal(clearance_hinge_model.build(p, &system, NULL), NSDAE_OK);
  expect_same_steps(system, kit_hinge(p), 0.005, 1000);
  outcome hand = by_hand(&clearance_hinge_model, NSDAE_METHOD_EVENT, 0.005, 0.2);
  outcome kit = by_kit(kit_hinge(p), NSDAE_METHOD_EVENT, 0.005, 0.2);
  expect_same(&hand, &kit, 3, 1e-10);
}

/* The crank, the rod and the slider by hand in the kit's coordinates, x, y, theta of each centre,
 * theta from where they hang:
 *
 *   Phi = crank's upper end, lower end against rod's upper, lower end against slider, x of slider
 *   F = weights, P0 sin(w t) on the crank, the spring's k (l - 1) towards a point 1 m below where
 *   the slider begins;  v_T = y' of the slider */
static int absolute_mass(double t, const double *q, double *M, int ldm, void *user)
{
  const crank_slider *p = user;
  const double m[3] = {p->m1, p->m2, p->m3},
               J[3] = {p->m1 * p->L1 * p->L1 / 12, p->m2 * p->L2 * p->L2 / 12, 1};
  (void)t, (void)q;
  for (int i = 0; i < 9; i++) M[i * (ldm + 1)] = i % 3 == 2 ? J[i / 3] : m[i / 3];
  return 0;
}

static int absolute_force(double t, const double *q, const double *v, double *F, void *user)
{
  const crank_slider *p = user;
  const double below = -p->L1 - p->L2 - 1, l = hypot(q[6], q[7] - below), f = p->k * (l - 1) / l;
  (void)v;
  F[1] = -p->m1 * p->g;
  F[2] = p->P0 * sin(p->w * t);
  F[4] = -p->m2 * p->g;
  F[6] = -f * q[6];
  F[7] = -p->m3 * p->g - f * (q[7] - below);
  return 0;
}

static int absolute_constraint(double t, const double *q, double *phi, void *user)
{
  const crank_slider *p = user;
  const double a = p->L1 / 2, b = p->L2 / 2;
  (void)t;
  phi[0] = q[0] - a * sin(q[2]);
  phi[1] = q[1] + a * cos(q[2]);
  phi[2] = q[3] - b * sin(q[5]) - q[0] - a * sin(q[2]);
  phi[3] = q[4] + b * cos(q[5]) - q[1] + a * cos(q[2]);
  phi[4] = q[6] - q[3] - b * sin(q[5]);
  phi[5] = q[7] - q[4] + b * cos(q[5]);
  phi[6] = q[6];
  return 0;
}

static int absolute_jacobian(double t, const double *q, double *J, int ldj, void *user)
{
  const crank_slider *p = user;
  const double ac = p->L1 / 2 * cos(q[2]), as = p->L1 / 2 * sin(q[2]), bc = p->L2 / 2 * cos(q[5]),
               bs = p->L2 / 2 * sin(q[5]);
  const struct {
    int row, column;
    double value;
  } entry[] = {{0, 0, 1},   {0, 2, -ac}, {1, 1, 1},   {1, 2, -as}, {2, 3, 1},
               {2, 5, -bc}, {2, 0, -1},  {2, 2, -ac}, {3, 4, 1},   {3, 5, -bs},
               {3, 1, -1},  {3, 2, -as}, {4, 6, 1},   {4, 3, -1},  {4, 5, -bc},
               {5, 7, 1},   {5, 4, -1},  {5, 5, -bs}, {6, 6, 1}};
  (void)t;
  for (size_t i = 0; i < sizeof entry / sizeof *entry; i++)
    J[entry[i].row + entry[i].column * ldj] = entry[i].value;
  return 0;
}

static int absolute_bias(double t, const double *q, const double *v, double *phi_t, double *omega,
                         void *user)
{
  const crank_slider *p = user;
  const double a = p->L1 / 2 * v[2] * v[2], b = p->L2 / 2 * v[5] * v[5];
  (void)t, (void)phi_t;
  omega[0] = a * sin(q[2]);
  omega[1] = -a * cos(q[2]);
  omega[2] = b * sin(q[5]) + a * sin(q[2]);
  omega[3] = -b * cos(q[5]) - a * cos(q[2]);
  omega[4] = b * sin(q[5]);
  omega[5] = -b * cos(q[5]);
  return 0;
}

static int absolute_slide(double t, const double *q, double *W, int ldw, double *w, void *user)
{
  (void)t, (void)q, (void)ldw, (void)w, (void)user;
  W[7] = 1;
  return 0;
}

static nsdae_system *absolute_crank_slider(crank_slider *p)
{
  const nsdae_dims dims = {.nq = 9, .m = 7, .f = 1};
  nsdae_system *s;
  assert_int_equal(nsdae_system_create(&dims, &s, NULL), NSDAE_OK);
  nsdae_system_set_user(s, p);
  nsdae_system_set_mass(s, absolute_mass);
  nsdae_system_set_force(s, absolute_force);
  nsdae_system_set_constraint(s, absolute_constraint);
  nsdae_system_set_constraint_jacobian(s, absolute_jacobian);
  nsdae_system_set_constraint_bias(s, absolute_bias);
  nsdae_system_set_frictional_joint_tangent(s, absolute_slide);
  assert_int_equal(nsdae_system_set_frictional_joint(s, 0, 6, p->mu), NSDAE_OK);
  return s;
}

/* The model has angles alone, which are the kit's. */
static void test_crank_slider(void **state)
{
  crank_slider *p = crank_slider_model.base;
  (void)state;
  nsdae_params_default(crank_slider_model.parameters, p);
  expect_same_steps(absolute_crank_slider(p), kit_crank_slider(p), 0.005, 2400);
  outcome hand = by_hand(&crank_slider_model, NSDAE_METHOD_EVENT, 0.01, 4);
  outcome kit = by_kit(kit_crank_slider(p), NSDAE_METHOD_EVENT, 0.01, 4);
  for (int i = 0; i < 2; i++) {
    assert_near(kit.q[3 * i + 2], hand.q[i], 1e-10);
    assert_near(kit.v[3 * i + 2], hand.v[i], 1e-9);
  }
}

/* K(k) = pi / (2 agm(1, sqrt(1 - k^2))), Gauss's arithmetic-geometric mean. */
static double complete_elliptic(double k)
{
  double a = 1, b = sqrt(1 - k * k);
  while (fabs(a - b) > 4 * DBL_EPSILON) {
    double mean = (a + b) / 2;
    b = sqrt(a * b);
    a = mean;
  }
  return acos(-1) / (a + b);
}

/* Columns: the axes that the unit quaternion p turns those of space into. */
static void rotation(const double *p, double *R)
{
  for (int j = 0; j < 3; j++) {
    double e[3] = {0, 0, 0}, u[3], cross[3];
    e[j] = 1;
    /* e + 2 w (x X e) + 2 x X (x X e) */
    for (int i = 0; i < 3; i++) {
      int k = (i + 1) % 3, l = (i + 2) % 3;
      u[i] = p[1 + k] * e[l] - p[1 + l] * e[k];
    }
    for (int i = 0; i < 3; i++) {
      int k = (i + 1) % 3, l = (i + 2) % 3;
      cross[i] = p[1 + k] * u[l] - p[1 + l] * u[k];
      R[3 * j + i] = e[i] + 2 * p[0] * u[i] + 2 * cross[i];
    }
  }
}

/* A free body of three different moments of inertia: energy and angular momentum stay, and omega
 * comes back after the period of Jacobi's functions (Landau and Lifshitz, Mechanics, section 37):
 * with J_1 < J_2 < J_3, M^2 > 2 E J_2,
 *   T = 4 K(k) sqrt(J_1 J_2 J_3 / ((J_3 - J_2) (M^2 - 2 E J_1))),
 *   k^2 = (J_2 - J_1) (2 E J_3 - M^2) / ((J_3 - J_2) (M^2 - 2 E J_1)) */
static void test_polhode(void **state)
{
  const double J[3] = {1, 2, 3}, w[3] = {0.3, 0.2, 1};
  nsdae_bodies *b;
  nsdae_system *system;
  double q[7], v[6], twice_E = 0, square = 0;
  (void)state;
  assert_int_equal(nsdae_bodies_create(3, &b, NULL), NSDAE_OK);
  nsdae_rigid_body body = {.mass = 1, .velocity = {0.1, 0, 0}};
  for (int i = 0; i < 3; i++) {
    body.inertia[i] = J[i];
    body.spin[i] = w[i];
    twice_E += J[i] * w[i] * w[i];
    square += J[i] * J[i] * w[i] * w[i];
  }
  assert_int_equal(nsdae_bodies_add(b, &body), 0);
  assert_true(nsdae_bodies_system(b, &system) >= 0);
  nsdae_bodies_get_start(b, q, v);
  double speed = (J[2] - J[1]) * (square - twice_E * J[0]);
  double k = sqrt((J[1] - J[0]) * (twice_E * J[2] - square) / speed);
  double period = 4 * complete_elliptic(k) * sqrt(J[0] * J[1] * J[2] / speed);
  outcome out = run(system, q, v, NSDAE_METHOD_EVENT, period / 50, period);
  for (int i = 0; i < 3; i++) assert_near(out.v[3 + i], w[i], 1e-9);
  /* angular momentum in space: R J omega, as at the start where R = 1 */
  double momentum[3], R[9];
  const double *p = out.q + 3, size = p[0] * p[0] + p[1] * p[1] + p[2] * p[2] + p[3] * p[3];
  assert_near(size, 1, 1e-9);
  rotation(p, R);
  for (int i = 0; i < 3; i++) {
    momentum[i] = 0;
    for (int j = 0; j < 3; j++) momentum[i] += R[3 * j + i] * J[j] * out.v[3 + j];
    assert_near(momentum[i], J[i] * w[i], 1e-9);
  }
  assert_near(out.q[0], 0.1 * period, 1e-9);
  nsdae_system_destroy(&system);
  nsdae_bodies_destroy(&b);
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_pendulum), cmocka_unit_test(test_hinge),
                                     cmocka_unit_test(test_crank_slider),
                                     cmocka_unit_test(test_polhode)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
