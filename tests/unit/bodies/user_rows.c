/* Coordinates and rows of one's own beside bodies: a bead that is written by hand hangs from the
 * tip of a rod of the kit and meets a wall, slides along a wire through a body, and does what a
 * body of the kit in its place does. */
#include "check.h"

#include <nsdae/nsdae.h>

#include "support/random.h"

static const double tip[3] = {0.5, 0, 0};

typedef struct bead {
  const nsdae_bodies *bodies;
  int d;
} bead;

enum { PLANAR = 2, SPATIAL = 3, NQ_MAX = 14 };

/* Where the coordinates and velocities of the bead begin: behind two bodies. */
static const double *bead_q(const bead *p, const double *q)
{
  return q + (p->d == PLANAR ? 6 : 14);
}

static int bead_first(const bead *p)
{
  return p->d == PLANAR ? 6 : 12;
}

static int mass(double t, const double *q, double *M, int ldm, void *user)
{
  const bead *p = user;
  (void)t;
  (void)q;
  for (int i = 0; i < p->d; i++) M[i * (ldm + 1)] = 2;
  return 0;
}

static int force(double t, const double *q, const double *v, double *F, void *user)
{
  const bead *p = user;
  (void)t;
  (void)q;
  (void)v;
  F[bead_first(p) + 1] -= 2 * 9.81;
  return 0;
}

static int potential(double t, const double *q, double *energy, void *user)
{
  (void)t;
  *energy = 2 * 9.81 * bead_q(user, q)[1];
  return 0;
}

/* The bead is at the tip of body 1. */
static int constraint(double t, const double *q, double *phi, void *user)
{
  const bead *p = user;
  double at[3];
  (void)t;
  nsdae_bodies_locate(p->bodies, q, 1, tip, at);
  for (int i = 0; i < p->d; i++) phi[i] = at[i] - bead_q(p, q)[i];
  return 0;
}

/* In the plane: tip' = r' + theta' (-s_y, s_x) with s the arm in space. */
static int constraint_jacobian(double t, const double *q, double *J, int ldj, void *user)
{
  const bead *p = user;
  double at[3];
  (void)t;
  nsdae_bodies_locate(p->bodies, q, 1, tip, at);
  for (int i = 0; i < 2; i++) {
    J[i + (3 + i) * ldj] = 1;
    J[i + (6 + i) * ldj] = -1;
  }
  J[0 + 5 * ldj] = -(at[1] - q[4]);
  J[1 + 5 * ldj] = at[0] - q[3];
  return 0;
}

static int constraint_bias(double t, const double *q, const double *v, double *phi_t, double *omega,
                           void *user)
{
  const bead *p = user;
  double at[3];
  (void)t;
  nsdae_bodies_locate(p->bodies, q, 1, tip, at);
  for (int i = 0; i < 2; i++) {
    phi_t[i] = 0;
    omega[i] = -v[5] * v[5] * (at[i] - q[3 + i]);
  }
  return 0;
}

/* The wall x = 0 for the bead. */
static int gap(double t, const double *q, double *g, void *user)
{
  (void)t;
  g[0] = bead_q(user, q)[0];
  return 0;
}

static int gap_normal(double t, const double *q, double *W, int ldw, void *user)
{
  (void)t;
  (void)q;
  (void)ldw;
  W[bead_first(user)] = 1;
  return 0;
}

static int gap_tangent(double t, const double *q, double *W, int ldw, void *user)
{
  const bead *p = user;
  (void)t;
  (void)q;
  for (int i = 1; i < p->d; i++) W[bead_first(p) + i + (i - 1) * ldw] = 1;
  return 0;
}

static int contact_bias(double t, const double *q, double *w_n, double *w_t, void *user)
{
  const bead *p = user;
  (void)t;
  (void)q;
  w_n[0] = 0;
  for (int i = 1; i < p->d; i++) w_t[i - 1] = 0;
  return 0;
}

static int contact_acceleration(double t, const double *q, const double *v, double *omega_n,
                                double *omega_t, double *omega_s, void *user)
{
  const bead *p = user;
  (void)t;
  (void)q;
  (void)v;
  assert_null(omega_s);
  omega_n[0] = 0;
  for (int i = 1; i < p->d; i++) omega_t[i - 1] = 0;
  return 0;
}

static nsdae_user_rows bead_own(bead *p)
{
  return (nsdae_user_rows){.dims = {.nq = p->d, .m = p->d, .k = 1},
                           .mass = mass,
                           .force = force,
                           .potential = potential,
                           .constraint = constraint,
                           .constraint_jacobian = constraint_jacobian,
                           .constraint_bias = constraint_bias,
                           .gap = gap,
                           .gap_normal = gap_normal,
                           .gap_tangent = gap_tangent,
                           .contact_bias = contact_bias,
                           .contact_acceleration = contact_acceleration,
                           .user = p};
}

/* Two rods of 1 m in a row from the origin, the first hinged there, both free to touch the wall. */
static nsdae_bodies *rods(int d)
{
  nsdae_bodies *b;
  const double gravity[3] = {0, -9.81, 0};
  assert_int_equal(nsdae_bodies_create(d, &b, NULL), NSDAE_OK);
  nsdae_bodies_set_gravity(b, gravity);
  for (int i = 0; i < 2; i++) {
    nsdae_bodies_add(b, &(nsdae_rigid_body){
                            .mass = 1, .inertia = {0.1, 1. / 12, 1. / 12}, .position = {i + 0.5}});
    nsdae_bodies_add_joint(
        b, &(nsdae_joint){
               .kind = NSDAE_JOINT_REVOLUTE, .body = {i - 1, i}, .point = {i}, .axis = {0, 0, 1}});
  }
  return b;
}

/* The wall as a solid of the ground with its normal along x. */
static int add_wall(nsdae_bodies *b)
{
  return nsdae_bodies_add_solid(b, NSDAE_GROUND,
                                &(nsdae_solid){.shape = NSDAE_SHAPE_PLANE, .angle = -acos(-1) / 2});
}

typedef struct outcome {
  double q[NQ_MAX], energy;
  long impacts;
} outcome;

static outcome run(nsdae_system *system, int method, const double *q0, double t_end)
{
  outcome out = {.energy = 0};
  const double v0[NQ_MAX] = {0};
  nsdae_sim_options options;
  nsdae_sim *sim;
  nsdae_record r;
  nsdae_stats stats;
  nsdae_dims dims;
  nsdae_sim_options_default(&options);
  options.method = method;
  options.dt = 0.002;
  options.rtol = 1e-11;
  options.atol = 1e-13;
  nsdae_system_get_dims(system, &dims);
  int created = nsdae_sim_create(system, &options, &sim, NULL);
  if (created == NSDAE_E_UNSUPPORTED) { /* event, without SUNDIALS */
    out.impacts = -1;
    return out;
  }
  assert_int_equal(created, NSDAE_OK);
  assert_int_equal(nsdae_sim_init(sim, 0, q0, v0), NSDAE_OK);
  int status = nsdae_sim_run(sim, t_end);
  if (status < 0) print_error("%s\n", nsdae_sim_error(sim)->text);
  assert_true(status >= 0);
  nsdae_sim_get_record(sim, &r);
  nsdae_sim_get_stats(sim, &stats);
  memcpy(out.q, r.q, (size_t)dims.nq * sizeof *r.q);
  out.energy = r.kinetic + r.potential;
  out.impacts = stats.impacts;
  nsdae_sim_destroy(&sim);
  return out;
}

/* With the bead by hand, and with a body in its place, whose own turning nothing moves. Limits,
 * which are not reached, come before one's own contacts. */
static outcome swing(int by_hand, int limits, int method, double t_end)
{
  nsdae_bodies *b = rods(PLANAR);
  nsdae_system *system;
  double q[NQ_MAX], v[NQ_MAX];
  bead p = {b, PLANAR};
  for (int i = 0; i < limits; i++)
    assert_int_equal(nsdae_bodies_add_limit(b, &(nsdae_limit){i, 0, -20, 20, 0}), i);
  if (by_hand) {
    nsdae_user_rows own = bead_own(&p);
    assert_int_equal(nsdae_bodies_set_user_rows(b, &own), NSDAE_OK);
  } else {
    int body =
        nsdae_bodies_add(b, &(nsdae_rigid_body){.mass = 2, .inertia = {0, 0, 1}, .position = {2}});
    nsdae_bodies_add_joint(
        b, &(nsdae_joint){.kind = NSDAE_JOINT_REVOLUTE, .body = {1, body}, .point = {2}});
    int point = nsdae_bodies_add_solid(b, body, &(nsdae_solid){.shape = NSDAE_SHAPE_POINT});
    nsdae_bodies_add_contact(b, add_wall(b), point, 0.3, 0.5, 0);
  }
  assert_true(nsdae_bodies_system(b, &system) >= 0);
  if (by_hand)
    assert_int_equal(nsdae_system_set_contact(system, 2 * limits, 0.3, 0.5, 0), NSDAE_OK);
  nsdae_bodies_get_start(b, q, v);
  if (by_hand) q[6] = 2;
  outcome out = run(system, method, q, t_end);
  nsdae_system_destroy(&system);
  nsdae_bodies_destroy(&b);
  return out;
}

static void test_same_as_a_body(void **state)
{
  static const int methods[] = {NSDAE_METHOD_IMPLICIT, NSDAE_METHOD_MOREAU, NSDAE_METHOD_EVENT};
  (void)state;
  for (int i = 0; i < 6; i++) {
    int limits = i / 3, method = methods[i % 3];
    outcome hand = swing(1, limits, method, 0.9), kit = swing(0, limits, method, 0.9);
    if (hand.impacts < 0) continue;
    assert_true(hand.impacts >= 1);
    assert_int_equal(hand.impacts, kit.impacts);
    /* the rows come in another order; 450 steps and an impact of a double pendulum */
    for (int j = 0; j < 8; j++) assert_near(hand.q[j], kit.q[j], 1e-9);
    assert_near(hand.energy, kit.energy, 1e-8);
  }
}

static uint64_t seed = 11;

static double uniform(double low, double high)
{
  return random_between(&seed, low, high);
}

/* All that is given is exact; what is missing is filled by differences, also of the bodies' rows.
 */
static void test_derivatives(void **state)
{
  (void)state;
  for (int i = 0; i < 40; i++) {
    int missing = i % 5;
    nsdae_bodies *b = rods(PLANAR);
    nsdae_system *system;
    nsdae_check worst;
    double q[NQ_MAX], v[NQ_MAX];
    bead p = {b, PLANAR};
    nsdae_user_rows own = bead_own(&p);
    if (missing == 1) own.constraint_jacobian = NULL;
    if (missing == 2) own.constraint_bias = NULL;
    if (missing == 3) own.gap_normal = NULL;
    if (missing == 4) own.contact_acceleration = NULL;
    int point = nsdae_bodies_add_solid(
        b, 0, &(nsdae_solid){.shape = NSDAE_SHAPE_POINT, .position = {0.3, 0.1}});
    assert_int_equal(nsdae_bodies_add_contact(b, add_wall(b), point, 0, 0, 0), 0);
    assert_int_equal(nsdae_bodies_set_user_rows(b, &own), NSDAE_OK);
    assert_true(nsdae_bodies_system(b, &system) >= 0);
    assert_int_equal(nsdae_system_set_contact(system, 1, 0.3, 0.5, 0), NSDAE_OK);
    for (int j = 0; j < 8; j++) {
      q[j] = uniform(-1, 1);
      v[j] = uniform(-1, 1);
    }
    int status = nsdae_system_check(system, 0.1, q, v, 1e-7, &worst);
    if (status < 0) print_error("%s\n", nsdae_system_error(system)->text);
    assert_int_equal(status, NSDAE_OK);
    nsdae_system_destroy(&system);
    nsdae_bodies_destroy(&b);
  }
}

/* In space, with differences for the coupling: the energy is kept as well as the method keeps it,
 * and the bead stays at the tip. */
static void test_space(void **state)
{
  nsdae_bodies *b = rods(SPATIAL);
  nsdae_system *system;
  double q[17] = {0}, v[15] = {0}, at[3];
  bead p = {b, SPATIAL};
  nsdae_user_rows own = bead_own(&p);
  (void)state;
  own.constraint_jacobian = NULL;
  own.constraint_bias = NULL;
  assert_int_equal(nsdae_bodies_set_user_rows(b, &own), NSDAE_OK);
  assert_true(nsdae_bodies_system(b, &system) >= 0);
  assert_int_equal(nsdae_system_set_contact(system, 0, 0.3, 0.5, 0), NSDAE_OK);
  nsdae_bodies_get_start(b, q, v);
  q[14] = 2;
  nsdae_sim *sim;
  nsdae_record r;
  nsdae_sim_options options;
  nsdae_sim_options_default(&options);
  options.dt = 1e-3;
  assert_int_equal(nsdae_sim_create(system, &options, &sim, NULL), NSDAE_OK);
  assert_int_equal(nsdae_sim_init(sim, 0, q, v), NSDAE_OK);
  assert_true(nsdae_sim_run(sim, 0.5) >= 0);
  nsdae_sim_get_record(sim, &r);
  nsdae_bodies_locate(b, r.q, 1, tip, at);
  for (int i = 0; i < 3; i++) assert_near(at[i], r.q[14 + i], 1e-4);
  assert_near(r.kinetic + r.potential, 0, 1e-2); /* of 40 J that were turned over */
  assert_true(r.kinetic > 20);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  nsdae_bodies_destroy(&b);
}

/* Coordinates alone, without any body: a bead that falls. */
static int falling(double t, const double *q, const double *v, double *F, void *user)
{
  (void)t;
  (void)q;
  (void)v;
  (void)user;
  F[0] = -2 * 9.81;
  return 0;
}

static int one_mass(double t, const double *q, double *M, int ldm, void *user)
{
  (void)t;
  (void)q;
  (void)ldm;
  (void)user;
  M[0] = 2;
  return 0;
}

static void test_alone(void **state)
{
  nsdae_bodies *b;
  nsdae_system *system;
  const nsdae_user_rows own = {.dims = {.nq = 1}, .mass = one_mass, .force = falling};
  const double q[1] = {0};
  (void)state;
  assert_int_equal(nsdae_bodies_create(2, &b, NULL), NSDAE_OK);
  assert_int_equal(nsdae_bodies_set_user_rows(b, &own), NSDAE_OK);
  assert_true(nsdae_bodies_system(b, &system) >= 0);
  outcome out = run(system, NSDAE_METHOD_IMPLICIT, q, 1);
  assert_near(out.q[0], -9.81 / 2, 1e-12);
  nsdae_system_destroy(&system);
  nsdae_bodies_destroy(&b);
}

static void refuse(nsdae_user_rows own, const char *argument)
{
  nsdae_bodies *b;
  nsdae_system *system;
  assert_int_equal(nsdae_bodies_create(2, &b, NULL), NSDAE_OK);
  assert_int_equal(nsdae_bodies_set_user_rows(b, &own), NSDAE_E_ARGUMENT);
  assert_string_equal(nsdae_bodies_error(b)->argument, argument);
  assert_int_equal(nsdae_bodies_system(b, &system), NSDAE_E_ARGUMENT);
  assert_null(system);
  nsdae_bodies_destroy(&b);
}

static void test_refused(void **state)
{
  bead p = {NULL, PLANAR};
  const nsdae_user_rows good = bead_own(&p);
  (void)state;
#define WITHOUT(field)          \
  do {                          \
    nsdae_user_rows own = good; \
    own.field = NULL;           \
    refuse(own, #field);        \
  } while (0)
#define WITH(field, value, named) \
  do {                            \
    nsdae_user_rows own = good;   \
    own.field = value;            \
    refuse(own, named);           \
  } while (0)
  WITHOUT(mass);
  WITHOUT(constraint);
  WITHOUT(gap);
  WITHOUT(gap_tangent);
  WITH(dims.nq, -1, "nq");
  WITH(dims.nv, 3, "nv");
  WITH(dims.nv, 1, "kinematics");
  WITH(dims.m, 0, "constraint");
  WITH(dims.k, 0, "gap");
  WITH(dims.k, 1 << 21, "k");
  WITH(dims.f, 1, "frictional_joint_tangent");
  WITH(dims.f, -1, "f");
  nsdae_bodies *b = rods(PLANAR);
  assert_int_equal(nsdae_bodies_set_user_rows(b, NULL), NSDAE_E_ARGUMENT);
  nsdae_bodies_destroy(&b);
  b = rods(PLANAR);
  assert_int_equal(nsdae_bodies_set_user_rows(b, &good), NSDAE_OK);
  assert_int_equal(nsdae_bodies_set_user_rows(b, &good), NSDAE_E_STATE);
  nsdae_bodies_destroy(&b);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_same_as_a_body), cmocka_unit_test(test_derivatives),
      cmocka_unit_test(test_space), cmocka_unit_test(test_alone), cmocka_unit_test(test_refused)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
