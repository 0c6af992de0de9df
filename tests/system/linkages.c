/* Mechanisms of the kit against references from elsewhere: spherical pendulums (elliptic
 * functions), a four-bar linkage (its geometry), the parallelogram of the IFToMM library's problem
 * A02 (a pendulum in disguise), Bricard's mechanism (problem A04: its geometry), and a slider-crank
 * with clearance at both pins (the geometry of the links and Earles and Wu's massless links). */
#include "check.h"

#include <float.h>

#include "bricard.h"
#include "parallelogram.h"

enum { NQ_MAX = 40 };

static const double g = 9.81;

/* sn(u, k) by Gauss's means: a' = (a + b) / 2, b' = sqrt(a b), c' = (a - b) / 2, and back
 * (Abramowitz and Stegun 16.4). K is the quarter period. */
static double jacobi_sn(double u, double k, double *K)
{
  double a[16] = {1}, c[16] = {k}, b = sqrt(1 - k * k), phi;
  int n = 0;
  while (fabs(c[n]) > DBL_EPSILON && n < 15) {
    a[n + 1] = (a[n] + b) / 2;
    c[n + 1] = (a[n] - b) / 2;
    b = sqrt(a[n] * b);
    n++;
  }
  *K = acos(-1) / (2 * a[n]);
  phi = ldexp(a[n] * u, n);
  for (; n > 0; n--) phi = (phi + asin(c[n] / a[n] * sin(phi))) / 2;
  return sin(phi);
}

static nsdae_bodies *world(int d)
{
  nsdae_bodies *b;
  const double down[3] = {0, d == 2 ? -g : 0, d == 3 ? -g : 0};
  assert_int_equal(nsdae_bodies_create(d, &b, NULL), NSDAE_OK);
  nsdae_bodies_set_gravity(b, down);
  return b;
}

static nsdae_sim_options options_of(int method, double dt)
{
  nsdae_sim_options options;
  nsdae_sim_options_default(&options);
  options.method = method;
  options.dt = dt;
  options.rtol = 1e-11;
  options.atol = 1e-13;
  return options;
}

/* Runs the world to t_end and releases it. */
static nsdae_stats run(nsdae_bodies *bodies, const nsdae_sim_options *options, double t_end,
                       nsdae_observer_fn observe, void *user)
{
  nsdae_system *system;
  nsdae_sim *sim;
  nsdae_stats stats;
  nsdae_error error;
  double q[NQ_MAX], v[NQ_MAX];
  int status = nsdae_bodies_system(bodies, &system);
  if (status < 0) print_error("%s\n", nsdae_bodies_error(bodies)->text);
  assert_true(status >= 0);
  nsdae_bodies_get_start(bodies, q, v);
  status = nsdae_sim_create(system, options, &sim, &error);
  if (status < 0) print_error("%s\n", error.text);
  assert_int_equal(status, NSDAE_OK);
  status = nsdae_sim_init(sim, 0, q, v);
  if (status < 0) print_error("%s\n", nsdae_sim_error(sim)->text);
  assert_int_equal(status, NSDAE_OK);
  nsdae_sim_observe(sim, observe, user);
  status = nsdae_sim_run(sim, t_end);
  if (status < 0) print_error("%s\n", nsdae_sim_error(sim)->text);
  assert_true(status >= 0);
  nsdae_sim_get_stats(sim, &stats);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  nsdae_bodies_destroy(&bodies);
  return stats;
}

/* ---- spherical pendulum */

/* Of length L, let go at the height z0 (given in L) horizontally with the speed v0: with z in L
 *   z'^2 = 2 g / L (z - z_a)(z - z_b)(z - z_c),  z_a < z < z_b < 1 < z_c
 *   z = z_a + (z_b - z_a) sn^2(sqrt(g (z_c - z_a) / (2 L)) t + phase),  k^2 = (z_b-z_a)/(z_c-z_a)
 * (E. T. Whittaker, Analytical Dynamics, 4th ed., section 55). One root is z0; the others are those
 * of z^2 + b z + c with b = z0 - E / (g L), c = b z0 - 1. */
typedef struct pendulum {
  double L, z0, v0;
  double scale; /* height of the body's centre over that of the pendulum's mass */
  double worst, turned;
} pendulum;

static double exact_height(const pendulum *p, double t)
{
  double z0 = p->z0 / p->L, E = p->v0 * p->v0 / 2 + g * p->z0, K;
  double b = z0 - E / (g * p->L), c = b * z0 - 1, root = sqrt(b * b / 4 - c);
  double other = -b / 2 - root, top = -b / 2 + root;
  double low = fmin(z0, other), high = fmax(z0, other), k = sqrt((high - low) / (top - low));
  jacobi_sn(0, k, &K);
  double u = sqrt(g * (top - low) / (2 * p->L)) * t + (z0 > other ? K : 0);
  double sn = jacobi_sn(u, k, &K);
  return p->L * (low + (high - low) * sn * sn);
}

static int follow_pendulum(const nsdae_record *r, nsdae_error *error, void *user)
{
  pendulum *p = user;
  (void)error;
  p->worst = fmax(p->worst, fabs(r->q[2] - p->scale * exact_height(p, r->time)));
  return 0;
}

/* A ball on a rod of length L. */
static pendulum swing_ball(double z0, double v0, const nsdae_sim_options *options)
{
  pendulum p = {.L = 1.3, .z0 = z0 * 1.3, .v0 = v0, .scale = 1};
  z0 = p.z0;
  nsdae_bodies *b = world(3);
  int ball = nsdae_bodies_add(b, &(nsdae_rigid_body){.mass = 2,
                                                     .inertia = {1, 2, 3},
                                                     .position = {sqrt(p.L * p.L - z0 * z0), 0, z0},
                                                     .velocity = {0, v0, 0}});
  nsdae_bodies_add_joint(b, &(nsdae_joint){.kind = NSDAE_JOINT_DISTANCE,
                                           .body = {NSDAE_GROUND, ball},
                                           .end = {sqrt(p.L * p.L - z0 * z0), 0, z0}});
  run(b, options, 4, follow_pendulum, &p);
  return p;
}

/* A slender top that does not spin about its axis (its own x), on a spherical joint: a pendulum of
 * length J / (m l), J about the joint. */
static pendulum swing_top(double z0, double v0, const nsdae_sim_options *options)
{
  const double m = 2, l = 0.7, J = 0.3 + m * l * l, h = z0;
  pendulum p = {.L = J / (m * l), .z0 = z0 * J / (m * l), .v0 = v0, .scale = m * l * l / J};
  double across = sqrt(1 - h * h), w = v0 / p.L; /* speed v0 = w L across the axis */
  double half = asin(-h) / 2;                    /* x turned down about y */
  nsdae_bodies *b = world(3);
  int top = nsdae_bodies_add(b, &(nsdae_rigid_body){.mass = m,
                                                    .inertia = {0.05, 0.3, 0.3},
                                                    .position = {l * across, 0, l * h},
                                                    .quaternion = {cos(half), 0, sin(half), 0},
                                                    .velocity = {0, l * w, 0},
                                                    .spin = {0, 0, w}});
  nsdae_bodies_add_joint(
      b, &(nsdae_joint){.kind = NSDAE_JOINT_SPHERICAL, .body = {NSDAE_GROUND, top}});
  run(b, options, 4, follow_pendulum, &p);
  return p;
}

static void test_spherical_pendulum(void **state)
{
  const double start[4][2] = {{-0.3, 1.2}, {-0.8, 0.8}, {0.4, 2}, {-0.6, 4}};
  (void)state;
  for (int i = 0; i < 4; i++) {
    nsdae_sim_options exact = options_of(NSDAE_METHOD_EVENT, 0.02);
    assert_near(swing_ball(start[i][0], start[i][1], &exact).worst, 0, 1e-8);
    assert_near(swing_top(start[i][0], start[i][1], &exact).worst, 0, 1e-8);
    nsdae_sim_options coarse = options_of(NSDAE_METHOD_IMPLICIT, 2e-3), fine = coarse;
    fine.dt /= 4;
    pendulum a = swing_ball(start[i][0], start[i][1], &coarse);
    pendulum b = swing_ball(start[i][0], start[i][1], &fine);
    assert_near(log2(a.worst / b.worst) / 2, 2, 0.1);
  }
}

/* ---- four-bar */

/* Crank a from (0, 0), coupler b, rocker c to (d, 0); the crank turns at w. */
typedef struct four_bar {
  double a, b, c, d, w, first;
  double work, worst_angle, worst_speed, worst_work, energy, dt;
} four_bar;

/* Angles of crank, coupler and rocker (from its ground end): the joint of coupler and rocker is
 * where their circles meet; rates from the loop's velocity,
 * b coupler' (-sin, cos) - c rocker' (-sin, cos) = -a w (-sin, cos). */
static void loop(const four_bar *f, double t, double *angle, double *rate)
{
  double x = f->a * cos(f->first + f->w * t), y = f->a * sin(f->first + f->w * t);
  double dx = f->d - x, dy = -y, square = dx * dx + dy * dy;
  double along = (f->b * f->b - f->c * f->c + square) / (2 * square);
  double across = sqrt(f->b * f->b / square - along * along);
  double px = x + along * dx - across * dy, py = y + along * dy + across * dx;
  angle[0] = f->first + f->w * t;
  angle[1] = atan2(py - y, px - x);
  angle[2] = atan2(py, px - f->d);
  rate[0] = f->w;
  double sine = sin(angle[2] - angle[1]);
  rate[1] = f->a * f->w * sin(angle[0] - angle[2]) / (f->b * sine);
  rate[2] = f->a * f->w * sin(angle[0] - angle[1]) / (f->c * sine);
}

static int turn_crank(double t, double drive[3], void *user)
{
  const four_bar *f = user;
  drive[0] = f->w * t;
  drive[1] = f->w;
  drive[2] = 0;
  return 0;
}

/* The drive's row is the last but four: crank 2 + 1, coupler 2, rocker 2, ground 2. Its work is
 * what the energy changes by. */
static int follow_four_bar(const nsdae_record *r, nsdae_error *error, void *user)
{
  four_bar *f = user;
  double angle[3], rate[3], energy = r->kinetic + r->potential;
  (void)error;
  loop(f, r->time, angle, rate);
  for (int i = 0; i < 3; i++) {
    f->worst_angle =
        fmax(f->worst_angle, fabs(remainder(r->q[3 * i + 2] - angle[i], 2 * acos(-1))));
    f->worst_speed = fmax(f->worst_speed, fabs(r->v[3 * i + 2] - rate[i]));
  }

  if (r->step == 0) f->energy = energy;
  if (r->step > 0) f->work -= r->multiplier[2] * f->w * r->duration;

  f->worst_work = fmax(f->worst_work, fabs(energy - f->energy - f->work));
  return 0;
}

/* A rod from (x, y) at angle turning at rate, whose first end moves with (vx, vy). */
static int add_rod(nsdae_bodies *b, double m, double L, const double *from, const double *speed,
                   double angle, double rate)
{
  double cosine = cos(angle), sine = sin(angle);
  return nsdae_bodies_add(
      b, &(nsdae_rigid_body){
             .mass = m,
             .inertia = {0, 0, m * L * L / 12},
             .position = {from[0] + L / 2 * cosine, from[1] + L / 2 * sine},
             .angle = angle,
             .velocity = {speed[0] - L / 2 * sine * rate, speed[1] + L / 2 * cosine * rate},
             .spin = {0, 0, rate}});
}

static void hinge(nsdae_bodies *b, int body0, int body1, double x, double y)
{
  nsdae_bodies_add_joint(
      b, &(nsdae_joint){.kind = NSDAE_JOINT_REVOLUTE, .body = {body0, body1}, .point = {x, y}});
}

static four_bar turn_four_bar(const nsdae_sim_options *options, double t_end)
{
  four_bar f = {.a = 0.5, .b = 1.5, .c = 1.2, .d = 2, .w = 4, .first = 0.3};
  double angle[3], rate[3];
  loop(&f, 0, angle, rate);
  nsdae_bodies *b = world(2);
  const double from[3][2] = {{0, 0}, {f.a * cos(f.first), f.a * sin(f.first)}, {f.d, 0}};
  const double rest[2] = {0, 0}, pin[2] = {-from[1][1] * f.w, from[1][0] * f.w};
  int crank = add_rod(b, 1, f.a, from[0], rest, angle[0], rate[0]);
  int coupler = add_rod(b, 3, f.b, from[1], pin, angle[1], rate[1]);
  int rocker = add_rod(b, 2, f.c, from[2], rest, angle[2], rate[2]);
  nsdae_bodies_add_joint(b, &(nsdae_joint){.kind = NSDAE_JOINT_REVOLUTE,
                                           .body = {NSDAE_GROUND, crank},
                                           .drive = turn_crank,
                                           .user = &f});
  hinge(b, crank, coupler, from[1][0], from[1][1]);
  hinge(b, coupler, rocker, f.d + f.c * cos(angle[2]), f.c * sin(angle[2]));
  hinge(b, NSDAE_GROUND, rocker, f.d, 0);
  run(b, options, t_end, follow_four_bar, &f);
  return f;
}

static void test_four_bar(void **state)
{
  (void)state;
  nsdae_sim_options exact = options_of(NSDAE_METHOD_EVENT, 0.01);
  four_bar f = turn_four_bar(&exact, 3);
  assert_near(f.worst_angle, 0, 1e-9);
  assert_near(f.worst_speed, 0, 1e-7);
  assert_near(turn_four_bar(&exact, 1).worst_work, 0, 1e-6);
  nsdae_sim_options coarse = options_of(NSDAE_METHOD_IMPLICIT, 4e-3), fine = coarse;
  fine.dt /= 4;
  four_bar c = turn_four_bar(&coarse, 3), d = turn_four_bar(&fine, 3);
  assert_near(log2(c.worst_angle / d.worst_angle) / 2, 2, 0.1);
  assert_near(log2(c.worst_work / d.worst_work) / 2, 2, 0.2);
}

/* ---- IFToMM A02: windows of equal bars of 1 m and 1 kg, all upright, which turn over at 1 m/s.
 * The bars stay parallel: n + 1 uprights turn about their feet, n bars on top go round with them,
 *   ((n + 1) / 3 + n) theta'' = -g ((n + 1) / 2 + n) sin theta   (theta from below)
 * a pendulum that turns over: sin(theta / 2) = sn(w_max t / 2, 2 w_0 / w_max) from below. Twice a
 * turn all bars lie in one line, where Phi_q loses rank. */
typedef struct windows {
  int n;
  double worst, energy, worst_energy;
} windows;

static double windows_angle(const windows *w, double t)
{
  double w0 = sqrt(g * ((w->n + 1) / 2. + w->n) / ((w->n + 1) / 3. + w->n));
  double most = sqrt(1 + 4 * w0 * w0), K, k = 2 * w0 / most;
  jacobi_sn(0, k, &K);
  double u = most * t / 2 + K; /* from above: a quarter later */
  double turns = floor((u + K) / (2 * K)), sn = jacobi_sn(u - 2 * K * turns, k, &K);
  return acos(-1) * (2 * turns) + 2 * asin(sn);
}

static int follow_windows(const nsdae_record *r, nsdae_error *error, void *user)
{
  windows *w = user;
  double exact = windows_angle(w, r->time), energy = r->kinetic + r->potential;
  (void)error;
  if (r->step == 0) w->energy = energy;
  w->worst_energy = fmax(w->worst_energy, fabs(energy - w->energy));
  for (int i = 0; i <= w->n; i++) /* uprights first; their angles from x, clockwise is < 0 */
    w->worst = fmax(w->worst, fabs(r->q[3 * i + 2] - acos(-1) / 2 + (exact - acos(-1))));
  return 0;
}

static windows turn_windows(int n, const nsdae_sim_options *options, double t_end)
{
  windows w = {.n = n};
  nsdae_bodies *b = world(2);
  int upright[8];
  const double rest[2] = {0, 0}, speed[2] = {1, 0};
  for (int i = 0; i <= n; i++) {
    const double foot[2] = {i, 0};
    upright[i] = add_rod(b, 1, 1, foot, rest, acos(-1) / 2, -1);
    hinge(b, NSDAE_GROUND, upright[i], i, 0);
  }
  for (int i = 0; i < n; i++) {
    const double end[2] = {i, 1};
    int top = add_rod(b, 1, 1, end, speed, 0, 0);
    hinge(b, upright[i], top, i, 1);
    hinge(b, top, upright[i + 1], i + 1, 1);
  }
  run(b, options, t_end, follow_windows, &w);
  return w;
}

static nsdae_sim_options redundant(int method, double dt)
{
  nsdae_sim_options options = options_of(method, dt);
  options.redundant = NSDAE_REDUNDANT_LEAST_NORM;
  return options;
}

/* All go over the lines, again and again (tests/system/change_points.c). event's error grows with
 * that of its energy, rtol^(1/2) / 10 squared at each line. */
static void test_windows(void **state)
{
  (void)state;
  for (int n = 1; n <= (test_share() > 1 ? 3 : 5); n += 2) {
    nsdae_sim_options coarse = redundant(NSDAE_METHOD_MOREAU, 1e-3), fine = coarse;
    fine.dt /= 4;
    windows a = turn_windows(n, &coarse, 2.5), b = turn_windows(n, &fine, 2.5);
    assert_near(log2(a.worst / b.worst) / 2, 1, 0.1);
    assert_near(log2(a.worst_energy / b.worst_energy) / 2, 1, 0.1);
    coarse = redundant(NSDAE_METHOD_IMPLICIT, 2e-3), fine = redundant(NSDAE_METHOD_IMPLICIT, 5e-4);
    a = turn_windows(n, &coarse, 2.5), b = turn_windows(n, &fine, 2.5);
    assert_true(log2(a.worst / b.worst) / 2 > 1.9); /* 2.1 to 2.6 */
    nsdae_sim_options exact = redundant(NSDAE_METHOD_EVENT, 0.01);
    assert_near(turn_windows(n, &exact, 2.5).worst, 0, 1e-7); /* 7e-9 */
  }
}

/* ---- Bricard's mechanism: five rods and the ground along six edges of a cube of 1 m, six revolute
 * joints; one degree of freedom where Gruebler's formula counts none */

enum { RODS = 5, JOINTS = 6 };

static const double corner[JOINTS][3] = {{0, 0, 0},  {1, 0, 0},  {1, -1, 0},
                                         {1, -1, 1}, {0, -1, 1}, {0, 0, 1}};
static const double along[JOINTS][3] = {{0, 1, 0}, {0, 0, 1}, {1, 0, 0},
                                        {0, 1, 0}, {0, 0, 1}, {1, 0, 0}};

typedef struct linkage {
  const nsdae_bodies *bodies;
  double cosine[JOINTS]; /* of the turn from one link to the next, of the last record */
  double worst_symmetry, worst_closure, energy, worst_energy;
} linkage;

/* All turns of odd joints are equal, and all of even ones, phi and theta, with
 * cos phi + cos theta + cos phi cos theta = 0  (Y. Chen, Z. You, T. Tarnai, Int. J. Solids Struct.
 * 42, 2005, for a twist of 90 deg). */
static int follow_linkage(const nsdae_record *r, nsdae_error *error, void *user)
{
  linkage *l = user;
  double way[JOINTS][3], *c = l->cosine, energy = r->kinetic + r->potential;
  (void)error;
  for (int k = 0; k < JOINTS; k++) {
    double own[3];
    for (int i = 0; i < 3; i++) way[k][i] = own[i] = corner[(k + 1) % JOINTS][i] - corner[k][i];
    if (k == RODS) continue;
    nsdae_bodies_locate(l->bodies, r->q, k, own, way[k]);
    for (int i = 0; i < 3; i++) way[k][i] -= r->q[7 * k + i];
  }
  for (int k = 0; k < JOINTS; k++) {
    const double *a = way[(k + RODS) % JOINTS], *b = way[k];
    c[k] = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  }
  for (int k = 0; k < 4; k++) l->worst_symmetry = fmax(l->worst_symmetry, fabs(c[k] - c[k + 2]));
  l->worst_closure = fmax(l->worst_closure, fabs(c[0] + c[1] + c[0] * c[1]));
  if (r->step == 0) l->energy = energy;
  l->worst_energy = fmax(l->worst_energy, fabs(energy - l->energy));
  return 0;
}

static linkage run_linkage(const bricard *p, const nsdae_sim_options *options)
{
  nsdae_bodies *b;
  linkage l = {.energy = 0};
  const double down[3] = {0, -p->g, 0};
  assert_int_equal(nsdae_bodies_create(3, &b, NULL), NSDAE_OK);
  nsdae_bodies_set_gravity(b, down);
  for (int k = 0; k < RODS; k++) {
    nsdae_rigid_body rod = {.mass = p->m};
    for (int i = 0; i < 3; i++) {
      double way = corner[k + 1][i] - corner[k][i];
      rod.position[i] = (corner[k + 1][i] + corner[k][i]) / 2;
      rod.inertia[i] = p->m * (p->a * p->a + (way != 0 ? p->a * p->a : p->L * p->L)) / 12;
    }
    nsdae_bodies_add(b, &rod);
  }
  for (int k = 0; k < JOINTS; k++) {
    nsdae_joint joint = {.kind = NSDAE_JOINT_REVOLUTE,
                         .body = {k - 1, k < RODS ? k : NSDAE_GROUND}};
    memcpy(joint.point, corner[k], sizeof joint.point);
    memcpy(joint.axis, along[k], sizeof joint.axis);
    nsdae_bodies_add_joint(b, &joint);
  }
  l.bodies = b;
  nsdae_stats stats = run(b, options, 1, follow_linkage, &l);
  assert_int_equal(stats.rank, 29);
  return l;
}

/* The same in natural coordinates, written by hand: the turns at its last record. */
typedef struct by_hand {
  const bricard *p;
  double cosine[JOINTS];
} by_hand;

static int follow_hand(const nsdae_record *r, nsdae_error *error, void *user)
{
  by_hand *h = user;
  (void)error;
  for (int k = 0; k < JOINTS; k++) h->cosine[k] = bricard_cosine(h->p, r->q, k);
  return 0;
}

static by_hand run_hand(bricard *p, const nsdae_sim_options *options)
{
  by_hand h = {.p = p};
  nsdae_sim *sim;
  double q[BRICARD_NQ], v[BRICARD_NQ];
  nsdae_system *system = bricard_system(p);
  bricard_start(p, q, v);
  assert_int_equal(nsdae_sim_create(system, options, &sim, NULL), NSDAE_OK);
  assert_int_equal(nsdae_sim_init(sim, 0, q, v), NSDAE_OK);
  nsdae_sim_observe(sim, follow_hand, &h);
  assert_true(nsdae_sim_run(sim, 1) >= 0);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  return h;
}

static void test_bricard(void **state)
{
  bricard p;
  (void)state;
  bricard_default(&p);
  nsdae_sim_options coarse = redundant(NSDAE_METHOD_MOREAU, 2e-3), fine = coarse;
  fine.dt /= 2;
  linkage a = run_linkage(&p, &coarse), b = run_linkage(&p, &fine);
  assert_near(log2(a.worst_energy / b.worst_energy), 1, 0.1);
  nsdae_sim_options exact = redundant(NSDAE_METHOD_EVENT, 0.01);
  linkage kit = run_linkage(&p, &exact);
  by_hand hand = run_hand(&p, &exact);
  assert_near(kit.worst_closure, 0, 1e-8);
  assert_near(kit.worst_symmetry, 0, 1e-8);
  for (int k = 0; k < JOINTS; k++) assert_near(kit.cosine[k], hand.cosine[k], 1e-8);
}

/* implicit is of second order. Which constraint is left out stays within a step, or the iteration
 * would go to and fro by what the drift leaves of it. */
static void test_bricard_implicit(void **state)
{
  bricard p;
  linkage l[2];
  (void)state;
  bricard_default(&p);
  for (int i = 0; i < 2; i++) {
    nsdae_sim_options options = redundant(NSDAE_METHOD_IMPLICIT, 2e-3 / (1 << i));
    l[i] = run_linkage(&p, &options);
  }
  assert_near(log2(l[0].worst_energy / l[1].worst_energy), 2, 0.1);
  assert_near(log2(l[0].worst_closure / l[1].worst_closure), 2, 0.2);
}

/* ---- slider-crank with clearance at both pins, of the size that P. Flores, J. Ambrosio, J. C. P.
 * Claro and H. M. Lankarani study (Proc. IMechE Part K 220, 2006): crank 0.05 m, rod 0.12 m,
 * clearances of 0.5 mm. A disc in a hole each. */
typedef struct play {
  double crank, rod, c, w, first; /* lengths, clearance, crank's speed and first angle */
  double turn[2];                 /* where pins lie in their holes at the start */
  double worst_slider, worst_play, least_play, slider;
  int by_links;
} play;

static int drive_crank(double t, double drive[3], void *user)
{
  const play *p = user;
  drive[0] = p->w * t;
  drive[1] = p->w;
  drive[2] = 0;
  return 0;
}

/* Centre of the crank's pin. */
static void crank_pin(const play *p, double t, double *x)
{
  x[0] = p->crank * cos(p->first + p->w * t);
  x[1] = p->crank * sin(p->first + p->w * t);
}

/* How far the pins' centres are from those of their holes; the slider where no play would put it,
 * which is at most 2 c / cos(psi) away, psi the rod's slope: the rod's end is on a circle about a
 * point that is within 2 c of the crank's pin. */
static int follow_play(const nsdae_record *r, nsdae_error *error, void *user)
{
  play *p = user;
  double pin[2], half = p->rod / 2, cosine = cos(r->q[5]), sine = sin(r->q[5]);
  (void)error;
  crank_pin(p, r->time, pin);
  double first[2] = {r->q[3] - half * cosine - pin[0], r->q[4] - half * sine - pin[1]};
  double second[2] = {r->q[3] + half * cosine - r->q[6], r->q[4] + half * sine - r->q[7]};
  double most = fmax(hypot(first[0], first[1]), hypot(second[0], second[1]));
  double least = fmin(hypot(first[0], first[1]), hypot(second[0], second[1]));
  double ideal = pin[0] + sqrt(p->rod * p->rod - pin[1] * pin[1]);
  double steep = (fabs(pin[1]) + 2 * most) / p->rod;
  double bound = 2 * most / sqrt(1 - steep * steep);
  p->worst_slider = fmax(p->worst_slider, fabs(r->q[6] - ideal) / bound);
  p->worst_play = fmax(p->worst_play, most);
  if (r->step == 0) p->least_play = least;
  p->least_play = fmin(p->least_play, least);
  p->slider = r->q[6];
  return 0;
}

/* Pins in holes, or links of the length of the clearance in their places. */
static nsdae_bodies *build_play(play *p, double e)
{
  nsdae_bodies *b;
  double pin[2], half = p->rod / 2;
  const double radius = 0.01;
  assert_int_equal(nsdae_bodies_create(2, &b, NULL), NSDAE_OK);
  crank_pin(p, 0, pin);
  /* the first hole's centre, and the rod from there to within c of the slider's line */
  double from[2] = {pin[0] + p->c * cos(p->turn[0]), pin[1] + p->c * sin(p->turn[0])};
  double end = p->c * sin(p->turn[1]), angle = asin((end - from[1]) / p->rod);
  double tip[2] = {from[0] + p->rod * cos(angle), end};
  double slider_x = tip[0] - p->c * cos(p->turn[1]);
  /* all moves as if no play had speed: the rod's first end with the pin, its other along x */
  double speed[2] = {-pin[1] * p->w, pin[0] * p->w};
  double rate = -speed[1] / (p->rod * cos(angle));
  int crank = nsdae_bodies_add(b, &(nsdae_rigid_body){.mass = 0.3,
                                                      .inertia = {0, 0, 1e-4},
                                                      .position = {pin[0] / 2, pin[1] / 2},
                                                      .angle = p->first,
                                                      .velocity = {speed[0] / 2, speed[1] / 2},
                                                      .spin = {0, 0, p->w}});
  int rod = nsdae_bodies_add(
      b, &(nsdae_rigid_body){
             .mass = 0.21,
             .inertia = {0, 0, 2.5e-4},
             .position = {from[0] + half * cos(angle), from[1] + half * sin(angle)},
             .angle = angle,
             .velocity = {speed[0] - half * sin(angle) * rate, speed[1] + half * cos(angle) * rate},
             .spin = {0, 0, rate}});
  int slider = nsdae_bodies_add(
      b, &(nsdae_rigid_body){.mass = 0.14,
                             .inertia = {0, 0, 1e-4},
                             .position = {slider_x, 0},
                             .velocity = {speed[0] - p->rod * sin(angle) * rate, 0}});
  nsdae_bodies_add_joint(b, &(nsdae_joint){.kind = NSDAE_JOINT_REVOLUTE,
                                           .body = {NSDAE_GROUND, crank},
                                           .drive = drive_crank,
                                           .user = p});
  nsdae_bodies_add_joint(b, &(nsdae_joint){.kind = NSDAE_JOINT_PRISMATIC,
                                           .body = {NSDAE_GROUND, slider},
                                           .point = {slider_x, 0},
                                           .axis = {1, 0}});
  const int body[2] = {crank, slider};
  const double at[2][2] = {{pin[0], pin[1]}, {slider_x, 0}},
               to[2][2] = {{from[0], from[1]}, {tip[0], tip[1]}};
  for (int i = 0; i < 2; i++) {
    if (p->by_links) {
      nsdae_bodies_add_joint(b, &(nsdae_joint){.kind = NSDAE_JOINT_DISTANCE,
                                               .body = {body[i], rod},
                                               .point = {at[i][0], at[i][1]},
                                               .end = {to[i][0], to[i][1]}});
      continue;
    }
    int hole = nsdae_bodies_add_solid(b, rod,
                                      &(nsdae_solid){.shape = NSDAE_SHAPE_DISC,
                                                     .radius = radius,
                                                     .hollow = 1,
                                                     .position = {i ? half : -half}});
    int disc = nsdae_bodies_add_solid(b, body[i],
                                      &(nsdae_solid){.shape = NSDAE_SHAPE_DISC,
                                                     .radius = radius - p->c,
                                                     .position = {i ? 0 : p->crank / 2}});
    nsdae_bodies_add_contact(b, hole, disc, 0, e, 0);
  }
  return b;
}

/* Pins that stay at their holes' walls move as massless links would in tension (S. W. E. Earles and
 * C. L. S. Wu, Motion analysis of a rigid link mechanism with clearance at a bearing using
 * Lagrangian mechanics and digital computation, IMechE, Mechanisms, 1972): contacts and bilateral
 * constraints give the same motion. */
static void test_massless_links(void **state)
{
  (void)state;
  for (int i = 0; i < 3; i++) {
    nsdae_sim_options options = options_of(NSDAE_METHOD_EVENT, 2e-5);
    play pins = {.crank = 0.05, .rod = 0.12, .c = 5e-4, .w = 100 + 100 * i, .first = 0.2};
    /* the rod pulls the slider back: the holes are outwards of the crank's pin, inwards of the
     * other */
    pins.turn[0] = 0.1;
    pins.turn[1] = acos(-1) - 0.1;
    play links = pins;
    links.by_links = 1;
    options.start_check = 0; /* its differences take steps that are long for a link of 0.5 mm */
    double t_end = 0.5 / pins.w;
    run(build_play(&pins, 0), &options, t_end, follow_play, &pins);
    run(build_play(&links, 0), &options, t_end, follow_play, &links);
    assert_near(pins.least_play, pins.c, 1e-10);
    assert_near(pins.worst_play, pins.c, 1e-10);
    assert_near(links.slider, pins.slider, 1e-10);
  }
}

/* Moreau's scheme comes to the same slider, by the first order. */
static void test_methods(void **state)
{
  play p[3];
  (void)state;
  for (int i = 0; i < 3; i++) {
    double dt = i == 0 ? 2e-5 : i == 1 ? 1e-5 : 2.5e-6;
    nsdae_sim_options options = options_of(i == 0 ? NSDAE_METHOD_EVENT : NSDAE_METHOD_MOREAU, dt);
    options.projection = NSDAE_PROJECTION_NONE; /* the scheme alone */
    p[i] = (play){.crank = 0.05, .rod = 0.12, .c = 5e-4, .w = 200, .first = 0.2};
    p[i].turn[0] = 0.1;
    p[i].turn[1] = acos(-1) - 0.1;
    run(build_play(&p[i], 0), &options, 0.5 / p[i].w, follow_play, &p[i]);
  }
  print_message("slider %.3e, %.3e m from the event's\n", p[1].slider - p[0].slider,
                p[2].slider - p[0].slider);
  assert_near(log2((p[1].slider - p[0].slider) / (p[2].slider - p[0].slider)) / 2, 1, 0.15);
}

/* As the clearance goes to zero the slider comes to where it is without, by no more than twice the
 * clearance over the cosine of the rod's slope: follow_play's bound. */
static void test_play(void **state)
{
  (void)state;
  for (int i = test_share() > 1 ? 2 : 0; i<5; i += test_share()> 1 ? 2 : 1) {
    nsdae_sim_options options = options_of(NSDAE_METHOD_MOREAU, i < 3 ? 1e-5 : 1e-6);
    play p = {.crank = 0.05,
              .rod = 0.12,
              .c = i < 3   ? 5e-4
                   : i < 4 ? 5e-5
                           : 5e-6,
              .w = i < 3 ? 50 + 225 * i : 50,
              .first = 0.2};
    double turns = i < 3 ? 2 : test_share() > 1 ? 0.25 : 0.5;
    nsdae_stats stats =
        run(build_play(&p, 0.9), &options, 2 * acos(-1) * turns / p.w, follow_play, &p);
    assert_true(stats.impacts > 50);
    /* a pin is found to overlap after a step: by less than its way against its hole in it, for
     * which twice the crank pin's is ample */
    assert_at_most(p.worst_play, p.c + 2 * p.w * p.crank * options.dt);
    assert_at_most(p.worst_slider, 1);
    assert_true(p.worst_slider > 0.9);
  }
}

/* A parallelogram on three or four cranks that starts past its change points, where the cranks and
 * the bar are in one line and the rank falls by one more. It swings through with its energy, which
 * the pose gives, or ends with a status; until its stop is hit nothing takes any. */
static void test_change_points(void **state)
{
  (void)state;
  int through = 0, refused = 0;
  for (int seed = 0; seed<36; seed += test_share()> 1 ? 19 : 1) { /* each number of cranks */
    parallelogram p = {.cranks = 3 + seed % 4 / 3, .given = seed % 5 / 4, .e = 0.6};
    double phi = 2 + 0.025 * seed, q[PARALLELOGRAM_NQ], v[PARALLELOGRAM_NQ] = {0};
    nsdae_system *system = parallelogram_system(&p);
    nsdae_sim_options o = options_of(NSDAE_METHOD_EVENT, 5e-3);
    nsdae_sim *sim;
    nsdae_record r;
    nsdae_stats stats;
    o.rtol = pow(10, -5 - seed % 3);
    o.atol = 1e-2 * o.rtol;
    o.redundant = NSDAE_REDUNDANT_LEAST_NORM;
    parallelogram_start(&p, phi, q);
    assert_int_equal(nsdae_sim_create(system, &o, &sim, NULL), NSDAE_OK);
    int status = nsdae_sim_init(sim, 0, q, v);
    double frequency = parallelogram_frequency(&p), most = 0;
    nsdae_sim_get_stats(sim, &stats);
    while (status >= 0 && stats.impacts == 0) {
      nsdae_sim_get_record(sim, &r);
      /* phi'^2 / 2 = p^2 (cos phi - cos phi_0), of the first crank */
      double rate = 2 * frequency * frequency * (cos(r.q[2]) - cos(phi));
      most = fmax(most, fabs(r.v[2] * r.v[2] - rate) / (4 * frequency * frequency));
      if (r.time > 2) break;
      status = nsdae_sim_step(sim);
      nsdae_sim_get_stats(sim, &stats);
    }
    if (status >= 0) assert_at_most(most, 1e-2);
    if (status >= 0) assert_true(stats.impacts > 0);
    through += status >= 0, refused += status < 0;
    nsdae_sim_destroy(&sim);
    nsdae_system_destroy(&system);
  }
  print_message("%d swing through, %d are refused\n", through, refused);
  assert_true(through >= refused); /* a method that refuses all would not do */
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_spherical_pendulum),
                                     cmocka_unit_test(test_four_bar),
                                     cmocka_unit_test(test_windows),
                                     cmocka_unit_test(test_bricard),
                                     cmocka_unit_test(test_bricard_implicit),
                                     cmocka_unit_test(test_massless_links),
                                     cmocka_unit_test(test_methods),
                                     cmocka_unit_test(test_play),
                                     cmocka_unit_test(test_change_points)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
