/* Frictional joints with a bound of their own, |F_S| <= b against v_S = W_S^T v + w_S, in machines
 * of which the motion is a formula: belts, brakes, motors and clutches. Masses are constant, forces
 * are f - k q. */
#include "check.h"

#include <nsdae/nsdae.h>

enum { MOST = 4 };

typedef struct machine {
  int n, f;
  double mass[MOST], stiffness[MOST], force[MOST];
  double W[MOST * MOST], w[MOST]; /* [n x f] */
  double bound[MOST];
  double e_n; /* > 0: mass 0 has a floor at q_0 = 0 */
  double (*vary)(double t, const double *q, const double *v); /* bound of joint 0, or NULL */
} machine;

static int mass(double t, const double *q, double *M, int ldm, void *user)
{
  const machine *m = user;
  (void)t, (void)q;
  for (int i = 0; i < m->n; i++) M[i * ldm + i] = m->mass[i];
  return 0;
}

static int force(double t, const double *q, const double *v, double *F, void *user)
{
  const machine *m = user;
  (void)t, (void)v;
  for (int i = 0; i < m->n; i++) F[i] = m->force[i] - m->stiffness[i] * q[i];
  return 0;
}

static int potential(double t, const double *q, double *U, void *user)
{
  const machine *m = user;
  (void)t;
  *U = 0;
  for (int i = 0; i < m->n; i++) *U += m->stiffness[i] * q[i] * q[i] / 2 - m->force[i] * q[i];
  return 0;
}

static int tangent(double t, const double *q, double *W, int ldw, double *w, void *user)
{
  const machine *m = user;
  (void)t, (void)q;
  for (int j = 0; j < m->f; j++) {
    for (int i = 0; i < m->n; i++) W[j * ldw + i] = m->W[j * m->n + i];
    w[j] = m->w[j];
  }
  return 0;
}

static int vary(double t, const double *q, const double *v, double *bound, void *user)
{
  bound[0] = ((const machine *)user)->vary(t, q, v);
  return 0;
}

static int gap(double t, const double *q, double *g, void *user)
{
  (void)t, (void)user;
  g[0] = q[0];
  return 0;
}

/* ---- runs */

static nsdae_system *system_of(machine *m)
{
  nsdae_system *s;
  const nsdae_dims dims = {.nq = m->n, .k = m->e_n > 0, .f = m->f};
  assert_int_equal(nsdae_system_create(&dims, &s, NULL), NSDAE_OK);
  nsdae_system_set_user(s, m);
  nsdae_system_set_mass(s, mass);
  nsdae_system_set_force(s, force);
  nsdae_system_set_potential(s, potential);
  nsdae_system_set_frictional_joint_tangent(s, tangent);
  for (int j = 0; j < m->f; j++)
    assert_int_equal(nsdae_system_set_friction_bound(s, j, m->bound[j]), NSDAE_OK);
  if (m->e_n > 0) nsdae_system_set_gap(s, gap);
  if (m->e_n > 0) nsdae_system_set_contact(s, 0, 0, m->e_n, 0);
  if (m->vary) nsdae_system_set_joint_friction_bound(s, vary);
  return s;
}

static nsdae_sim *begin(machine *m, int method, double dt, const double *q, const double *v)
{
  nsdae_sim *sim;
  nsdae_sim_options o;
  nsdae_error error;
  nsdae_system *s = system_of(m);
  nsdae_sim_options_default(&o);
  o.method = method;
  o.dt = dt;
  o.rtol = 1e-12;
  o.atol = 1e-13;
  if (nsdae_sim_create(s, &o, &sim, &error) < 0) print_error("%s\n", error.text);
  assert_non_null(sim);
  nsdae_system_destroy(&s);
  assert_int_equal(nsdae_sim_init(sim, 0, q, v), NSDAE_OK);
  return sim;
}

static nsdae_record go(nsdae_sim *sim, double t)
{
  nsdae_record r;
  int status = nsdae_sim_run(sim, t);
  if (status != NSDAE_OK) print_error("%s\n", nsdae_sim_error(sim)->text);
  assert_int_equal(status, NSDAE_OK);
  nsdae_sim_get_record(sim, &r);
  return r;
}

/* From where it is with another force on mass 0. */
static void push(nsdae_sim **sim, machine *m, int method, double dt, double force)
{
  nsdae_record r;
  double q[MOST], v[MOST];
  nsdae_sim_get_record(*sim, &r);
  memcpy(q, r.q, (size_t)m->n * sizeof *q);
  memcpy(v, r.v, (size_t)m->n * sizeof *v);
  nsdae_sim_destroy(sim);
  m->force[0] = force;
  *sim = begin(m, method, dt, q, v);
}

typedef struct scheme {
  int method;
  double dt, exact; /* error without an order */
} scheme;

/* A time step is a dyadic number, so that a sum of steps has no rounding. */
static const scheme schemes[] = {{NSDAE_METHOD_IMPLICIT, 1.0 / 128, 0},
                                 {NSDAE_METHOD_IMPLICIT_PRINTED, 1.0 / 128, 0},
                                 {NSDAE_METHOD_MOREAU, 1.0 / 128, 0},
                                 {NSDAE_METHOD_EVENT, 1.0 / 128, 1e-10}};
enum { SCHEMES = sizeof schemes / sizeof *schemes };

/* 256 steps with 8 roundings each of numbers up to 4 are off by 1e-12. */
static const double rounding = 1e-12;

/* ---- one joint */

/* A block on a belt: it is slowed by b / m until it has the belt's speed, and keeps that exactly. A
 * pull below b does not move it; one above accelerates it by (pull - b) / m. */
static void test_belt(void **state)
{
  (void)state;
  const double b = 3, m = 2, start = 1.75, belt = 0.25;
  for (int i = 0; i < SCHEMES; i++)
    for (int pull = -1; pull <= 1; pull++) {
      const double force = 4 * pull, x0 = 0;
      machine block = {.n = 1, .f = 1, .mass = {m}, .W = {1}, .w = {-belt}, .bound = {b}};
      nsdae_sim *sim = begin(&block, schemes[i].method, schemes[i].dt, &x0, &start);
      nsdae_record r = go(sim, 0.5);
      assert_near(r.v[0], start - b / m * 0.5, rounding);
      assert_int_equal(r.frictional_joint_mode[0], NSDAE_MODE_SLIP);
      assert_near(r.frictional_joint_force[0], -b, rounding);
      double rest = m * (start - belt) / b;
      r = go(sim, rest);
      assert_near(r.v[0], belt, rounding);
      r = go(sim, 2);
      assert_true(r.v[0] == belt);
      assert_near(r.q[0], start * rest - b / m * rest * rest / 2 + belt * (2 - rest), rounding);
      assert_int_equal(r.frictional_joint_mode[0], NSDAE_MODE_STICK);
      assert_near(r.frictional_joint_force[0], 0, rounding);
      push(&sim, &block, schemes[i].method, schemes[i].dt, force);
      r = go(sim, 1);
      double over = (force > b) * (force - b) + (force < -b) * (force + b);
      assert_near(r.v[0], belt + over / m, rounding);
      assert_near(r.certificate.unexplained, 0, 1e-12);
      nsdae_sim_destroy(&sim);
    }
}

/* A torque below the bound is held: the slip is 0.0 and the angle keeps all its digits. */
static void test_hold(void **state)
{
  (void)state;
  const double q = 0.1, v = 0;
  for (int i = 0; i < SCHEMES; i++)
    for (int huge = 0; huge <= 12; huge += 3) {
      machine disc = {.n = 1, .f = 1, .mass = {0.3}, .stiffness = {7}, .W = {1}};
      disc.bound[0] = 0.71 * pow(10, huge);
      nsdae_sim *sim = begin(&disc, schemes[i].method, 1e-2, &q, &v);
      nsdae_record r = go(sim, 10);
      assert_true(r.q[0] == q && r.v[0] == 0);
      assert_int_equal(r.frictional_joint_mode[0], NSDAE_MODE_STICK);
      assert_near(r.frictional_joint_force[0], 0.7, 1e-13);
      nsdae_sim_destroy(&sim);
    }
}

/* A motor with the torque b: b / J until it has its speed, which it keeps exactly. */
static void test_motor(void **state)
{
  (void)state;
  const double J = 0.5, b = 2, target = 3, q = 0, v = 0, reached = target * J / b;
  for (int i = 0; i < SCHEMES; i++)
    for (int sign = -1; sign <= 1; sign += 2) {
      machine motor = {.n = 1, .f = 1, .mass = {J}, .W = {1}, .w = {-sign * target}, .bound = {b}};
      nsdae_sim *sim = begin(&motor, schemes[i].method, 1.0 / 64, &q, &v);
      nsdae_record r = go(sim, 0.5);
      assert_near(r.v[0], sign * b / J * 0.5, rounding);
      assert_near(r.frictional_joint_force[0], sign * b, rounding);
      r = go(sim, reached);
      r = go(sim, 2);
      assert_true(r.v[0] == sign * target);
      assert_near(r.q[0], sign * target * (2 - reached / 2), 1e-12);
      assert_near(r.kinetic, J * target * target / 2, 1e-12);
      assert_near(r.certificate.unexplained, 0, 1e-12);
      /* under a load of 1.5 the speed is kept, with 2.5 it is lost */
      push(&sim, &motor, schemes[i].method, schemes[i].dt, -sign * 1.5);
      r = go(sim, 0.5);
      assert_true(r.v[0] == sign * target);
      assert_near(r.frictional_joint_force[0], sign * 1.5, rounding);
      push(&sim, &motor, schemes[i].method, schemes[i].dt, -sign * 2.5);
      r = go(sim, 0.5);
      assert_near(r.v[0], sign * (target - 0.5 / J * 0.5), rounding);
      assert_near(r.certificate.unexplained, 0, 1e-12);
      nsdae_sim_destroy(&sim);
    }
}

/* Torsional pendulum with Coulomb damping: between its stops at n pi / omega it swings about
 * +-b / k, so that the amplitude falls by 2 b / k from one to the next, until it is below b / k. */
static double amplitude(double A, double shift, int stops)
{
  for (int i = 0; i < stops && A > shift; i++) A -= 2 * shift;
  return A;
}

static double swing(int method, double dt, double *rest)
{
  const double J = 0.5, k = 8, b = 1.2, A = 1, v = 0; /* shift 0.15: it rests at 0.1 */
  const double half = acos(-1) / sqrt(k / J);
  machine disc = {.n = 1, .f = 1, .mass = {J}, .stiffness = {k}, .W = {1}, .bound = {b}};
  nsdae_sim *sim = begin(&disc, method, dt, &A, &v);
  double off = 0;
  for (int i = 1; i <= 3; i++) {
    nsdae_record r = go(sim, i * half);
    off = fmax(off, fabs(r.q[0] - (i % 2 ? -1 : 1) * amplitude(A, b / k, i)));
    off = fmax(off, fabs(r.v[0]));
  }
  nsdae_record r = go(sim, 4 * half);
  *rest = fabs(r.q[0] + 0.1);
  assert_true(r.v[0] == 0);
  assert_int_equal(r.frictional_joint_mode[0], NSDAE_MODE_STICK);
  assert_near(r.frictional_joint_force[0], k * r.q[0], 1e-12);
  nsdae_sim_destroy(&sim);
  return off;
}

static void test_pendulum(void **state)
{
  (void)state;
  for (int i = 0; i < SCHEMES; i++) {
    double rest[2], off[2];
    for (int j = 0; j < 2; j++) off[j] = swing(schemes[i].method, 1e-3 / (1 + 7 * j), &rest[j]);
    assert_at_most(off[1], fmax(off[0] / 4, schemes[i].exact));
    assert_at_most(rest[1], 1e-3);
  }
}

/* ---- more */

/* Two discs and a clutch: the common speed is that of all angular momentum, after |v_1 - v_2| J_r /
 * b. Then a torque on the first one accelerates both, up to b (J_1 + J_2) / J_2. */
static void test_clutch(void **state)
{
  (void)state;
  const double J[2] = {0.5, 1.5}, b = 0.75, q[2] = {0, 0}, v[2] = {4, 1};
  const double common = (J[0] * v[0] + J[1] * v[1]) / (J[0] + J[1]),
               together = (v[0] - v[1]) * J[0] * J[1] / (J[0] + J[1]) / b;
  for (int i = 0; i < SCHEMES; i++) {
    machine clutch = {.n = 2, .f = 1, .mass = {J[0], J[1]}, .W = {1, -1}, .bound = {b}};
    nsdae_sim *sim = begin(&clutch, schemes[i].method, 1.0 / 64, q, v);
    nsdae_record r = go(sim, 1);
    assert_near(r.v[0], v[0] - b / J[0], rounding);
    assert_near(r.v[1], v[1] + b / J[1], rounding);
    assert_true(together < 2);
    r = go(sim, 2);
    assert_near(r.v[0], common, rounding);
    assert_near(r.v[1], common, rounding);
    assert_near(r.dissipated, J[0] * J[1] / (J[0] + J[1]) * 4.5, 1e-12);
    push(&sim, &clutch, schemes[i].method, schemes[i].dt, 0.9);
    r = go(sim, 1);
    assert_near(r.v[0], common + 0.9 / 2, rounding);
    assert_near(r.v[0] - r.v[1], 0, rounding);
    push(&sim, &clutch, schemes[i].method, schemes[i].dt, 1.1);
    r = go(sim, 1);
    assert_near(r.v[0], common + 0.45 + (1.1 - b) / J[0], rounding);
    assert_near(r.v[1], common + 0.45 + b / J[1], rounding);
    /* it opens */
    push(&sim, &clutch, schemes[i].method, schemes[i].dt, 0);
    assert_int_equal(nsdae_sim_set_friction_bound(sim, 0, 0), NSDAE_OK);
    nsdae_sim_get_record(sim, &r);
    double before[2] = {r.v[0], r.v[1]};
    r = go(sim, 1);
    for (int l = 0; l < 2; l++) assert_near(r.v[l], before[l], rounding);
    nsdae_sim_destroy(&sim);
  }
}

/* A brake holds a force of 1; then its bound becomes 1/2, and it slips from there, v = t / 2. */
static void test_brake_yields(void **state)
{
  (void)state;
  const double q = 0, v = 0;
  for (int i = 0; i < SCHEMES; i++) {
    machine block = {.n = 1, .f = 1, .mass = {1}, .W = {1}, .bound = {5}, .force = {1}};
    nsdae_sim *sim = begin(&block, schemes[i].method, 1.0 / 64, &q, &v);
    assert_true(go(sim, 0.5).v[0] == 0);
    assert_int_equal(nsdae_sim_set_friction_bound(sim, 0, 0.5), NSDAE_OK);
    nsdae_record r = go(sim, 1);
    assert_near(r.v[0], 0.25, rounding);
    assert_true(r.certificate.cone_excess == 0);
    nsdae_sim_destroy(&sim);
  }
}

/* A bound that varies: the impulse of the time t is the integral of b. */
static double ramp(double t, const double *q, const double *v)
{
  (void)q, (void)v;
  return 2 * t;
}

static void test_ramp(void **state)
{
  (void)state;
  const double q = 0, v = 5;
  for (int i = 0; i < SCHEMES; i++) {
    machine block = {.n = 1, .f = 1, .mass = {1}, .W = {1}, .vary = ramp};
    nsdae_sim *sim = begin(&block, schemes[i].method, 1.0 / 64, &q, &v);
    nsdae_record r = go(sim, 2);
    int printed = schemes[i].method == NSDAE_METHOD_IMPLICIT_PRINTED; /* of first order */
    assert_near(r.v[0], 1 + (printed ? 2.0 / 64 : 0), rounding);
    r = go(sim, 3);
    assert_true(r.v[0] == 0);
    nsdae_sim_destroy(&sim);
  }
}

/* The bound becomes another one between two steps, and the state of a run goes on elsewhere with
 * the same bytes, if the bound is the same there. */
static void test_set_bound(void **state)
{
  (void)state;
  const double q = 0, v = 3;
  for (int i = 0; i < SCHEMES; i++) {
    machine block = {.n = 1, .f = 1, .mass = {1}, .W = {1}, .bound = {2}};
    nsdae_sim *sim = begin(&block, schemes[i].method, 1.0 / 64, &q, &v),
              *other = begin(&block, schemes[i].method, 1.0 / 64, &q, &v);
    size_t size;
    go(sim, 0.5);
    assert_int_equal(nsdae_sim_set_friction_bound(sim, 0, 1), NSDAE_OK);
    nsdae_record r = go(sim, 1);
    assert_near(r.v[0], 1.5, rounding);
    assert_int_equal(nsdae_sim_state_size(sim, &size), NSDAE_OK);
    char *block_of_state = malloc(size);
    assert_non_null(block_of_state);
    assert_int_equal(nsdae_sim_get_state(sim, block_of_state, size), NSDAE_OK);
    assert_int_equal(nsdae_sim_set_state(other, block_of_state, size), NSDAE_E_ARGUMENT);
    assert_string_equal(nsdae_sim_error(other)->argument, "bound");
    assert_int_equal(nsdae_sim_set_friction_bound(other, 0, 1), NSDAE_OK);
    assert_int_equal(nsdae_sim_set_state(other, block_of_state, size), NSDAE_OK);
    r = go(sim, 2.2);
    nsdae_record s = go(other, 2.2);
    assert_memory_equal(r.q, s.q, sizeof q);
    assert_memory_equal(r.v, s.v, sizeof v);
    assert_near(r.v[0], 0.3, rounding);
    r = go(sim, 3);
    assert_true(r.v[0] == 0);
    assert_true(r.certificate.cone_excess == 0);
    free(block_of_state);
    nsdae_sim_destroy(&other);
    nsdae_sim_destroy(&sim);
  }
}

/* A ball on a guide that rubs with b falls with g - b / m, leaves the floor with e_N times its
 * speed, for b has no impulse in an impact, and rises against g + b / m. */
static void test_impact(void **state)
{
  (void)state;
  const double g = 10, m = 2, b = 4, e = 0.5, height = 1, v = 0, floor = 0;
  const double hits = sqrt(2 * height / (g - b / m)), speed = e * (g - b / m) * hits;
  machine ball = {.n = 1, .f = 1, .mass = {m}, .force = {-m * g}, .W = {1}, .bound = {b}, .e_n = e};
  nsdae_sim *sim = begin(&ball, NSDAE_METHOD_EVENT, 1e-2, &height, &v);
  double top = speed / (g + b / m);
  nsdae_record r = go(sim, hits + top);
  assert_near(r.q[0], speed * top / 2, 1e-10);
  assert_near(r.v[0], 0, 1e-9);
  assert_near(r.certificate.unexplained, 0, 1e-9);
  nsdae_sim_destroy(&sim);
  /* it rests on the floor; b may carry a part of its weight */
  sim = begin(&ball, NSDAE_METHOD_EVENT, 1e-2, &floor, &v);
  r = go(sim, 1);
  assert_near(r.q[0], 0, 1e-13);
  assert_near(r.v[0], 0, 1e-13);
  nsdae_sim_destroy(&sim);
}

/* A mass on a belt of speed w and a spring: it sticks until k x = b, at t_1 = b / (k w). Then it
 * swings, x = b / k + w / omega sin(omega (t - t_1)). */
static void test_spring_on_belt(void **state)
{
  (void)state;
  const double m = 0.5, k = 8, b = 1.2, w = 0.3, q = 0, omega = sqrt(k / m), first = b / (k * w);
  machine block = {
      .n = 1, .f = 1, .mass = {m}, .stiffness = {k}, .W = {1}, .w = {-w}, .bound = {b}};
  for (int i = 0; i < SCHEMES; i++) {
    double off[2], last = first + 0.9 * 2 * acos(-1) / omega;
    for (int j = 0; j < 2; j++) {
      nsdae_sim *sim = begin(&block, schemes[i].method, 1e-3 / (1 + 7 * j), &q, &w);
      nsdae_record r = go(sim, 0.9 * first);
      assert_near(r.q[0], 0.9 * first * w, 1e-12);
      assert_int_equal(r.frictional_joint_mode[0], NSDAE_MODE_STICK);
      r = go(sim, last);
      off[j] = fabs(r.q[0] - b / k - w / omega * sin(omega * (last - first)));
      off[j] = fmax(off[j], fabs(r.v[0] - w * cos(omega * (last - first))));
      nsdae_sim_destroy(&sim);
    }
    assert_at_most(off[1], fmax(off[0] / 4, schemes[i].exact));
    assert_at_most(off[1], 1e-3);
  }
}

/* ---- by blocks */

/* A stack of discs on one shaft, each a block: the clutch between two neighbours has the bound b,
 * the first disc a motor with a bound that is far above that. The first disc has its speed at once;
 * all others turn together, driven by b, until they have it too. With many rows the island is a
 * problem of cones. */
enum { DISCS = 120 };

static int discs_mass(double t, const double *q, double *M, void *user)
{
  (void)t, (void)q;
  for (int i = 0; i < *(int *)user; i++) M[i] = 0.5;
  return 0;
}

static int no_force(double t, const double *q, const double *v, double *F, void *user)
{
  (void)t, (void)q, (void)v, (void)F, (void)user;
  return 0;
}

static int discs_rows(double t, const double *q, nsdae_row_list *rows, double *w, void *user)
{
  const double one = 1, minus = -1;
  (void)t, (void)q;
  w[0] = -2;
  nsdae_row_add(rows, 0, 0, &one);
  for (int j = 1; j < *(int *)user; j++) {
    nsdae_row_add(rows, j, j - 1, &one);
    nsdae_row_add(rows, j, j, &minus);
  }
  return 0;
}

static void test_discs(void **state)
{
  (void)state;
  const double J = 0.5, b = 0.8, speed = 2, rest[DISCS] = {0};
  const int methods[] = {NSDAE_METHOD_IMPLICIT, NSDAE_METHOD_MOREAU, NSDAE_METHOD_EVENT};
  int sizes[DISCS];
  for (int i = 0; i < DISCS; i++) sizes[i] = 1;
  for (int i = 0; i < 3; i++) {
    int event = methods[i] == NSDAE_METHOD_EVENT, count = event ? 12 : DISCS;
    const nsdae_dims dims = {.nq = count, .f = count};
    const double together = speed * J * (count - 1) / b;
    nsdae_system *s;
    nsdae_sim *sim;
    nsdae_sim_options o;
    assert_int_equal(nsdae_system_create(&dims, &s, NULL), NSDAE_OK);
    assert_int_equal(nsdae_system_set_blocks(s, count, sizes, sizes), NSDAE_OK);
    nsdae_system_set_user(s, &count);
    nsdae_system_set_mass_blocks(s, discs_mass);
    nsdae_system_set_force(s, no_force);
    nsdae_system_set_joint_friction_rows(s, discs_rows);
    for (int j = 0; j < count; j++) nsdae_system_set_friction_bound(s, j, j == 0 ? 1e4 : b);
    nsdae_sim_options_default(&o);
    o.method = methods[i];
    o.dt = 1.0 / 8;
    assert_int_equal(nsdae_sim_create(s, &o, &sim, NULL), NSDAE_OK);
    nsdae_system_destroy(&s);
    assert_int_equal(nsdae_sim_init(sim, 0, rest, rest), NSDAE_OK);
    nsdae_record r = go(sim, 8);
    for (int j = 0; j < count; j++) /* a motor of 1e4 N m needs 1e-4 s */
      assert_near(r.v[j], j == 0 ? speed : b / (J * (count - 1)) * 8, event ? 1e-4 : 1e-9);
    r = go(sim, together + 1);
    for (int j = 0; j < count; j++) assert_near(r.v[j], speed, 1e-9);
    nsdae_sim_destroy(&sim);
  }
}

/* Particles on a floor with friction, in a row: between two neighbours a row with a bound along x.
 * Each is a block, then the island is a problem of cones by blocks; or all are one block, then it
 * is dense. Both have the same velocities; forces between particles that stick are not unique. */
enum { PARTICLES = 40 };

static int particles_mass(double t, const double *q, double *M, int ldm, void *user)
{
  (void)t, (void)q, (void)user;
  for (int i = 0; i < 3 * PARTICLES; i++) M[i * ldm + i] = 1 + i / 3 % 3;
  return 0;
}

static int particles_mass_blocks(double t, const double *q, double *M, void *user)
{
  (void)t, (void)q, (void)user;
  for (int i = 0; i < 3 * PARTICLES; i++) M[9 * (i / 3) + 4 * (i % 3)] = 1 + i / 3 % 3;
  return 0;
}

static int particles_force(double t, const double *q, const double *v, double *F, void *user)
{
  (void)q, (void)v, (void)user;
  for (int i = 0; i < PARTICLES; i++) {
    F[3 * i] = 6 * sin(i * i + 3 * t);
    F[3 * i + 1] = 4 * cos(3 * i - t);
    F[3 * i + 2] = -10;
  }
  return 0;
}

static int particles_gap(double t, const double *q, double *g, void *user)
{
  (void)t, (void)user;
  for (int i = 0; i < PARTICLES; i++) g[i] = q[3 * i + 2];
  return 0;
}

static int particles_normal(double t, const double *q, double *W, int ldw, void *user)
{
  (void)t, (void)q, (void)user;
  for (int i = 0; i < PARTICLES; i++) W[i * ldw + 3 * i + 2] = 1;
  return 0;
}

static int particles_tangent(double t, const double *q, double *W, int ldw, void *user)
{
  (void)t, (void)q, (void)user;
  for (int i = 0; i < PARTICLES; i++) W[2 * i * ldw + 3 * i] = W[(2 * i + 1) * ldw + 3 * i + 1] = 1;
  return 0;
}

static int particles_joints(double t, const double *q, double *W, int ldw, double *w, void *user)
{
  (void)t, (void)q, (void)w, (void)user;
  for (int j = 0; j < PARTICLES - 1; j++) {
    W[j * ldw + 3 * j] = 1;
    W[j * ldw + 3 * j + 3] = -1;
  }
  return 0;
}

static nsdae_sim *particles(int blocks)
{
  const nsdae_dims dims = {.nq = 3 * PARTICLES, .k = PARTICLES, .nt = 2, .f = PARTICLES - 1};
  const double zero[3 * PARTICLES] = {0};
  int sizes[PARTICLES];
  nsdae_system *s;
  nsdae_sim *sim;
  nsdae_sim_options o;
  for (int i = 0; i < PARTICLES; i++) sizes[i] = 3;
  assert_int_equal(nsdae_system_create(&dims, &s, NULL), NSDAE_OK);
  if (blocks) nsdae_system_set_blocks(s, PARTICLES, sizes, sizes);
  if (blocks) nsdae_system_set_mass_blocks(s, particles_mass_blocks);
  if (!blocks) nsdae_system_set_mass(s, particles_mass);
  nsdae_system_set_force(s, particles_force);
  nsdae_system_set_gap(s, particles_gap);
  nsdae_system_set_gap_normal(s, particles_normal);
  nsdae_system_set_gap_tangent(s, particles_tangent);
  nsdae_system_set_frictional_joint_tangent(s, particles_joints);
  for (int i = 0; i < PARTICLES; i++) nsdae_system_set_contact(s, i, 0.1 + 0.01 * (i % 7), 0, 0);
  for (int j = 0; j < PARTICLES - 1; j++)
    nsdae_system_set_friction_bound(s, j, j % 9 == 0 ? 1e6 : 0.4 * (j % 5));
  nsdae_sim_options_default(&o);
  o.dt = 0.01;
  o.contact_tol = 1e-12;
  assert_int_equal(nsdae_sim_create(s, &o, &sim, NULL), NSDAE_OK);
  nsdae_system_destroy(&s);
  assert_int_equal(nsdae_sim_init(sim, 0, zero, zero), NSDAE_OK);
  return sim;
}

static void test_particles(void **state)
{
  (void)state;
  nsdae_sim *sim[2] = {particles(0), particles(1)};
  int sticks = 0, slips = 0;
  for (int step = 1; step <= 40; step++) {
    nsdae_record r = go(sim[0], 0.01 * step), s = go(sim[1], 0.01 * step);
    for (int i = 0; i < 3 * PARTICLES; i++) assert_near(r.v[i], s.v[i], 1e-8);
    for (int j = 0; j < PARTICLES - 1; j++) {
      slips += s.frictional_joint_mode[j] == NSDAE_MODE_SLIP;
      sticks += s.frictional_joint_mode[j] == NSDAE_MODE_STICK;
    }
    assert_at_most(s.certificate.cone_excess, 1e-9);
  }
  assert_true(sticks > 100 && slips > 100);
  for (int i = 0; i < 2; i++) nsdae_sim_destroy(&sim[i]);
}

/* Without gravity a particle touches a floor that turns under it, by a motor; it has the speed of
 * the motor, so that nothing acts any more and all rates are rounding. */
static int turning_gap(double t, const double *q, double *g, void *user)
{
  (void)t, (void)user;
  g[0] = q[2];
  return 0;
}

static int turning_normal(double t, const double *q, double *W, int ldw, void *user)
{
  (void)t, (void)q, (void)user, (void)ldw;
  W[2] = 1;
  return 0;
}

static int turning_tangent(double t, const double *q, double *W, int ldw, void *user)
{
  (void)t, (void)q, (void)user;
  W[0] = W[ldw + 1] = 1;
  W[3] = -0.7;
  return 0;
}

static void test_steady(void **state)
{
  (void)state;
  const nsdae_dims dims = {.nq = 4, .k = 1, .nt = 2, .f = 1};
  const double q[4] = {0}, v[4] = {0.7 / 3, 0, 0, 0};
  machine m = {
      .n = 4, .f = 1, .mass = {1, 1, 1, 0.3}, .W = {0, 0, 0, 1}, .w = {-1.0 / 3}, .bound = {50}};
  nsdae_system *s;
  nsdae_sim *sim;
  nsdae_sim_options o;
  assert_int_equal(nsdae_system_create(&dims, &s, NULL), NSDAE_OK);
  nsdae_system_set_user(s, &m);
  nsdae_system_set_mass(s, mass);
  nsdae_system_set_force(s, force);
  nsdae_system_set_gap(s, turning_gap);
  nsdae_system_set_gap_normal(s, turning_normal);
  nsdae_system_set_gap_tangent(s, turning_tangent);
  nsdae_system_set_contact(s, 0, 0.4, 0, 0);
  nsdae_system_set_frictional_joint_tangent(s, tangent);
  nsdae_system_set_friction_bound(s, 0, m.bound[0]);
  nsdae_sim_options_default(&o);
  o.dt = 0.01;
  assert_int_equal(nsdae_sim_create(s, &o, &sim, NULL), NSDAE_OK);
  nsdae_system_destroy(&s);
  assert_int_equal(nsdae_sim_init(sim, 0, q, v), NSDAE_OK);
  nsdae_record r = go(sim, 5);
  assert_near(r.v[0], 0.7 / 3, 1e-12);
  assert_near(r.v[3], 1.0 / 3, 1e-12);
  nsdae_sim_destroy(&sim);
}

/* Regularised over v_r: the motor creeps by v_r F / sqrt(b^2 - F^2) under the load F. */
static void test_penalty(void **state)
{
  (void)state;
  const double J = 0.5, b = 2, load = 1.2, q = 0, v = 0, v_r = 1e-4;
  const int integrators[] = {NSDAE_INTEGRATOR_DOPRI5, NSDAE_INTEGRATOR_IDA};
  for (int i = 0; i < 2; i++) {
    machine motor = {.n = 1, .f = 1, .mass = {J}, .force = {-load}, .W = {1}, .w = {-3}};
    nsdae_sim *sim;
    nsdae_sim_options o;
    motor.bound[0] = b;
    nsdae_system *s = system_of(&motor);
    nsdae_sim_options_default(&o);
    o.method = NSDAE_METHOD_PENALTY;
    o.integrator = integrators[i];
    o.dt = 0.01;
    o.friction_velocity = v_r;
    o.rtol = o.atol = 1e-10;
    int status = nsdae_sim_create(s, &o, &sim, NULL);
    nsdae_system_destroy(&s);
    if (status == NSDAE_E_UNSUPPORTED) continue; /* without SUNDIALS */
    assert_int_equal(status, NSDAE_OK);
    assert_int_equal(nsdae_sim_init(sim, 0, &q, &v), NSDAE_OK);
    nsdae_record r = go(sim, 0.5);
    assert_near(r.v[0], (b - load) / J * 0.5, 1e-6);
    r = go(sim, 4);
    assert_near(r.v[0], 3 - v_r * load / sqrt(b * b - load * load), 1e-8);
    assert_near(r.frictional_joint_force[0], load, 1e-6);
    assert_near(r.certificate.unexplained, 0, 1e-4);
    nsdae_sim_destroy(&sim);
  }
}

/* ---- what is refused */

static void test_refusals(void **state)
{
  (void)state;
  const double q = 0, v = 1;
  machine block = {.n = 1, .f = 1, .mass = {1}, .W = {1}, .bound = {1}};
  nsdae_system *s = system_of(&block);
  const double bad[] = {-1, NAN, INFINITY};
  for (int i = 0; i < 3; i++)
    assert_int_equal(nsdae_system_set_friction_bound(s, 0, bad[i]), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_system_set_friction_bound(s, 1, 1), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_system_set_friction_bound(NULL, 0, 1), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_system_set_friction_circle(s, 0, 0, 1, 1), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_system_set_friction_circle(s, 0, 0, 0, 1), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_system_set_friction_circle(s, 1, 0, 1, 1), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_system_set_friction_circle(NULL, 0, 0, 1, 1), NSDAE_E_ARGUMENT);
  nsdae_system_destroy(&s);
  nsdae_sim *sim = begin(&block, NSDAE_METHOD_IMPLICIT, 0.1, &q, &v);
  for (int i = 0; i < 3; i++)
    assert_int_equal(nsdae_sim_set_friction_bound(sim, 0, bad[i]), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_sim_set_friction_bound(sim, 1, 1), NSDAE_E_ARGUMENT);
  nsdae_sim_destroy(&sim);
}

static double negative(double t, const double *q, const double *v)
{
  (void)q, (void)v;
  return t < 0.45 ? 1 : -1;
}

static void test_negative(void **state)
{
  (void)state;
  const double q = 0, v = 1;
  machine block = {.n = 1, .f = 1, .mass = {1}, .W = {1}, .vary = negative};
  for (int i = 0; i < SCHEMES; i++) {
    nsdae_sim *sim = begin(&block, schemes[i].method, 0.1, &q, &v);
    assert_int_equal(nsdae_sim_run(sim, 1), NSDAE_E_CALLBACK);
    assert_non_null(
        strstr(nsdae_sim_error(sim)->text, "joint_friction_bound gives a negative bound"));
    assert_int_equal(nsdae_sim_error(sim)->index, 0);
    nsdae_sim_destroy(&sim);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_belt),      cmocka_unit_test(test_hold),
      cmocka_unit_test(test_motor),     cmocka_unit_test(test_pendulum),
      cmocka_unit_test(test_clutch),    cmocka_unit_test(test_ramp),
      cmocka_unit_test(test_set_bound), cmocka_unit_test(test_brake_yields),
      cmocka_unit_test(test_impact),    cmocka_unit_test(test_spring_on_belt),
      cmocka_unit_test(test_penalty),   cmocka_unit_test(test_discs),
      cmocka_unit_test(test_particles), cmocka_unit_test(test_steady),
      cmocka_unit_test(test_refusals),  cmocka_unit_test(test_negative),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
