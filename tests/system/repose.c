/* What holds spheres up is exact where they are few: slopes on which one rests in a dimple of
 * others that stand still, how it rolls out of it, and the friction that a pyramid needs.
 *
 * Sphere of radius r on k of radius R, whose centres are the corners of a regular polygon, c from
 * its middle: it lies h = sqrt((r + R)^2 - c^2) above them. It rests while its weight passes inside
 * of the polygon's edges; tilted by theta in a direction that is phi off the normal of an edge, it
 * leaves over that edge from
 *
 *   tan theta = c cos(pi / k) / (h cos phi),   |phi| <= pi / k
 *
 * on (the criterion of R. Albert, I. Albert, D. Hornbaker, P. Schiffer, A.-L. Barabasi, Maximum
 * angle of stability in wet and dry spherical granular media, Phys. Rev. E 56, R6271, 1997), which
 * comes to 19.5 to 35.3 degrees on three of its own size, 23.8 in the mean of all directions.
 * Friction plays no part, up to mu = h / c: only beyond can a contact behind pull the sphere down,
 * and wedge it.
 *
 * It leaves over two supports, P = sqrt((r + R)^2 - (c sin(pi / k))^2) from the line of their
 * centres, and, where it rolls, rho = P r / (r + R) from the line of the contacts about which it
 * turns; psi being the angle of that arm with the vertical, the energy says
 *
 *   v^2 (1 + 2 r^2 / (5 rho^2)) = 2 g P (cos psi_0 - cos psi)
 *
 * A pyramid: the k spheres lie on a plane, and one on them, whose contacts are theta off the
 * vertical, sin theta = c / (r + R). Friction F is the same above and below a lower sphere (moments
 * about its centre), N sin theta = F (1 + cos theta) (no force outwards), so that it stands from
 *
 *   mu = F / N = tan(theta / 2)
 *
 * on, whatever the weights; the floor is asked for less, being pressed on by the lower sphere too.
 * For four equal spheres that is sqrt(3) - sqrt(2). */
#include "check.h"

#include <nsdae/nsdae.h>

#include "support/random.h"

static const double pi = 3.14159265358979323846, g = 9.81;

typedef struct dimple {
  int k;
  double r, R, c; /* as above */
} dimple;

static double depth(const dimple *d)
{
  return sqrt((d->r + d->R) * (d->r + d->R) - d->c * d->c);
}

/* Slope from which on it leaves in the direction that is phi off the normal of an edge. */
static double steepest(const dimple *d, double phi)
{
  return atan(d->c * cos(pi / d->k) / depth(d) / cos(phi));
}

/* Where a sphere is after a run, how fast, and the fastest that it was, its rim included. */
typedef struct end {
  double r, x[3], v[6], fastest;
} end;

static double norm(const double *x)
{
  return sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]);
}

enum { BODIES_MAX = 6 };

static int look(const nsdae_record *record, nsdae_error *error, void *user)
{
  end *e = user;
  (void)error;
  for (int i = 0; i < 3; i++) e->x[i] = record->q[i];
  for (int i = 0; i < 6; i++) e->v[i] = record->v[i];
  e->fastest = fmax(e->fastest, fmax(norm(e->v), e->r * norm(e->v + 3)));
  return 0;
}

static void add_ball(nsdae_bodies *b, double mass, double r, double x, double y, double z)
{
  double J = 0.4 * mass * r * r;
  int body = nsdae_bodies_add(
      b, &(nsdae_rigid_body){.mass = mass, .inertia = {J, J, J}, .position = {x, y, z}});
  nsdae_bodies_add_solid(b, body, &(nsdae_solid){.shape = NSDAE_SHAPE_SPHERE, .radius = r});
}

/* The normal of edge 0 is x; the supports' centres lie in z = 0. */
static nsdae_bodies *tilted(const dimple *d, double mu, double theta, double phi)
{
  nsdae_bodies *b;
  const double gravity[3] = {g * sin(theta) * cos(phi), g * sin(theta) * sin(phi), -g * cos(theta)};
  assert_int_equal(nsdae_bodies_create(3, &b, NULL), NSDAE_OK);
  nsdae_bodies_set_gravity(b, gravity);
  add_ball(b, 1, d->r, 0, 0, depth(d));
  for (int i = 0; i < d->k; i++) {
    double at = (2 * i + 1) * pi / d->k;
    nsdae_bodies_add_solid(b, NSDAE_GROUND,
                           &(nsdae_solid){.shape = NSDAE_SHAPE_SPHERE,
                                          .radius = d->R,
                                          .position = {d->c * cos(at), d->c * sin(at), 0}});
  }
  nsdae_bodies_set_pair(b, 0, 0, mu, 0, 0);
  return b;
}

/* Of body 0 of the world, r its radius; takes the world. */
static end run(nsdae_bodies *b, double r, double dt, double t_end)
{
  nsdae_system *system;
  nsdae_sim *sim;
  nsdae_sim_options options;
  double q[7 * BODIES_MAX], v[6 * BODIES_MAX];
  end e = {.r = r};
  nsdae_sim_options_default(&options);
  options.method = NSDAE_METHOD_MOREAU;
  options.dt = dt;
  options.contact_tol = 1e-10; /* also of pyramids with more than 11 contacts */
  assert_true(nsdae_bodies_system(b, &system) >= 0);
  assert_int_equal(nsdae_sim_create(system, &options, &sim, NULL), NSDAE_OK);
  nsdae_bodies_get_start(b, q, v);
  assert_int_equal(nsdae_sim_init(sim, 0, q, v), NSDAE_OK);
  assert_int_equal(nsdae_sim_observe(sim, look, &e), NSDAE_OK);
  int status = nsdae_sim_run(sim, t_end);
  if (status < 0) print_error("%s\n", nsdae_sim_error(sim)->text);
  assert_true(status >= 0);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  nsdae_bodies_destroy(&b);
  return e;
}

/* Equal spheres side by side, as in the paper and as in the rough floor of a heap. */
static void test_published(void **state)
{
  const dimple three = {3, 1, 1, 2 / sqrt(3)}, four = {4, 1, 1, sqrt(2)};
  double sum = 0;
  (void)state;
  assert_near(steepest(&three, 0), asin(1.0 / 3), 1e-15); /* of a tetrahedron */
  assert_near(steepest(&three, pi / 3), acos(sqrt(2.0 / 3)), 1e-15);
  assert_near(steepest(&four, 0), acos(sqrt(2.0 / 3)), 1e-15); /* of an octahedron */
  for (int i = 0; i < 1000; i++) sum += steepest(&three, (i + 0.5) / 1000 * pi / 3) / 1000;
  assert_near(sum * 180 / pi, 23.8, 0.05);
}

/* Three to five supports that touch each other, or stand apart so that the sphere lies deeper;
 * somewhat smaller or larger than it. */
static dimple draw(int i, uint64_t *seed)
{
  dimple d = {.k = 3 + i % 3, .r = 0.01, .R = 0.01 * (0.6 + 0.6 * random_uniform(seed))};
  double touching = d.R / sin(pi / d.k), apart = 0.95 * (d.r + d.R);
  d.c = i % 2 ? touching : touching + (apart - touching) * random_uniform(seed);
  return d;
}

/* Any dimple, direction and friction below h / c: a thousandth less steep it rests, but for what
 * the tolerance of 1e-10 leaves of the velocity of a step's free fall; a thousandth steeper it
 * leaves, over the edge that theory says. */
static void test_slopes(void **state)
{
  uint64_t seed = 1;
  (void)state;
  for (int i = 0; i < 96; i += test_share()) {
    dimple d = draw(i, &seed);
    double phi = (2 * random_uniform(&seed) - 1) * 0.95 * pi / d.k;
    double mu = i % 4 ? 0.95 * random_uniform(&seed) * depth(&d) / d.c : 0,
           most = steepest(&d, phi);
    end rests = run(tilted(&d, mu, 0.999 * most, phi), d.r, 1e-3, 0.1);
    end leaves = run(tilted(&d, mu, 1.001 * most, phi), d.r, 1e-3, 1);
    assert_at_most(rests.fastest, 1e-9 * g * 1e-3);
    assert_true(leaves.x[0] > d.c * cos(pi / d.k));
  }
}

/* Straight over an edge, with friction enough to roll, from 0.05 beyond the steepest slope on and
 * as far as the supports carry it. The energy's error is of the first order: a fifth of dt over the
 * time sqrt(P / g) of the motion at most. It rolls but for the free fall of one step, in which a
 * contact may just have opened. */
static void test_rolls_out(void **state)
{
  (void)state;
  for (int i = 0; i < 12; i++) {
    const double dt = 1e-3 / (1 << i / 3), R = 0.005 * (1 + i % 3);
    const dimple d = {.k = 3 + i % 2, .r = 0.01, .R = R, .c = R / sin(pi / (3 + i % 2))};
    double arm = d.c * cos(pi / d.k), P = hypot(depth(&d), arm), rho = P * d.r / (d.r + d.R);
    double theta = steepest(&d, 0) + 0.05;
    end e = run(tilted(&d, 0.9 * depth(&d) / d.c, theta, 0), d.r, dt, 0.13);
    double psi = atan2(e.x[0] - arm, e.x[2]) + theta, v = norm(e.v), rim = d.r * norm(e.v + 3);
    assert_true(psi > 0.2 && psi < 0.8);
    assert_near((v * v + 0.4 * rim * rim) / (2 * g * P * (cos(0.05) - cos(psi))), 1,
                0.2 * dt * sqrt(g / P));
    assert_near(rim * rho / d.r, v, g * dt);
  }
}

/* The upper sphere is body 0, of mass 1. */
static nsdae_bodies *pyramid(const dimple *d, double mass, double mu)
{
  nsdae_bodies *b;
  const double gravity[3] = {0, 0, -g};
  assert_int_equal(nsdae_bodies_create(3, &b, NULL), NSDAE_OK);
  nsdae_bodies_set_gravity(b, gravity);
  nsdae_bodies_add_solid(b, NSDAE_GROUND, &(nsdae_solid){.shape = NSDAE_SHAPE_PLANE});
  add_ball(b, 1, d->r, 0, 0, d->R + depth(d));
  for (int i = 0; i < d->k; i++) {
    double at = 2 * i * pi / d->k;
    add_ball(b, mass, d->R, d->c * cos(at), d->c * sin(at), d->R);
  }
  nsdae_bodies_set_pair(b, 0, 0, mu, 0, 0);
  return b;
}

/* A thousandth more friction than that and it stands, a thousandth less and it falls. */
static void test_pyramid(void **state)
{
  uint64_t seed = 2;
  (void)state;
  for (int i = 0; i < 48; i += test_share()) {
    dimple d = i == 0 ? (dimple){3, 0.01, 0.01, 0.02 / sqrt(3)} : draw(i, &seed);
    double theta = asin(d.c / (d.r + d.R)), mass = i == 0 ? 1 : exp(4 * random_uniform(&seed) - 2);
    double least = tan(theta / 2), high = d.R + depth(&d);
    if (i == 0) assert_near(least, sqrt(3) - sqrt(2), 1e-15);
    end stands = run(pyramid(&d, mass, 1.001 * least), d.r, 1e-3, 0.1);
    end falls = run(pyramid(&d, mass, 0.999 * least), d.r, 1e-3, 1);
    assert_at_most(stands.fastest, 1e-9 * g * 1e-3);
    assert_true(falls.x[2] < 0.99 * high); /* heavy ones are slow to go */
  }
}

/* ---- a plate on ice, with balls on it */

/* The plate weighs 1 kg and rests without friction on four corners, the balls of 1 kg on it with
 * friction: in the record the former slip, for nothing holds them, and the latter stick. */
static void test_modes(void **state)
{
  (void)state;
  for (int method = NSDAE_METHOD_IMPLICIT; method <= NSDAE_METHOD_MOREAU; method++) {
    const double gravity[3] = {0, 0, -g}, inertia = 0.004; /* of a ball */
    enum { BALLS = 2, NQ = 7 * (1 + BALLS) };
    double q[NQ], v[NQ], weight = 0;
    nsdae_bodies *b;
    nsdae_system *system;
    nsdae_sim *sim;
    nsdae_sim_options o;
    nsdae_record r;
    int slip = 0, stick = 0;
    assert_int_equal(nsdae_bodies_create(3, &b, NULL), NSDAE_OK);
    nsdae_bodies_set_gravity(b, gravity);
    nsdae_bodies_set_pair(b, 0, 1, 0, 0, 0);
    nsdae_bodies_set_pair(b, 1, 2, 0.5, 0, 0);
    nsdae_solid ice = {.shape = NSDAE_SHAPE_PLANE},
                plate = {.shape = NSDAE_SHAPE_BOX, .length = {2, 2, 0.2}, .material = 1},
                ball = {.shape = NSDAE_SHAPE_SPHERE, .radius = 0.1, .material = 2};
    nsdae_rigid_body body = {.mass = 1, .inertia = {1, 1, 1}, .position = {0, 0, 0.1}};
    nsdae_bodies_add_solid(b, NSDAE_GROUND, &ice);
    nsdae_bodies_add_solid(b, nsdae_bodies_add(b, &body), &plate);
    for (int i = 0; i < BALLS; i++) {
      body = (nsdae_rigid_body){
          .mass = 1, .inertia = {inertia, inertia, inertia}, .position = {0.3 * i, 0.1, 0.3}};
      nsdae_bodies_add_solid(b, nsdae_bodies_add(b, &body), &ball);
    }
    assert_true(nsdae_bodies_system(b, &system) >= 0);
    nsdae_bodies_get_start(b, q, v);
    nsdae_sim_options_default(&o);
    o.method = method;
    o.dt = 1e-3;
    assert_int_equal(nsdae_sim_create(system, &o, &sim, NULL), NSDAE_OK);
    assert_int_equal(nsdae_sim_init(sim, 0, q, v), NSDAE_OK);
    for (int i = 0; i < 3; i++) assert_int_equal(nsdae_sim_step(sim), NSDAE_OK);
    nsdae_sim_get_record(sim, &r);
    for (int i = 0; i < r.contacts.count; i++) {
      int on_ice = r.contacts.block[2 * i] < 0 || r.contacts.block[2 * i + 1] < 0;
      weight += on_ice ? r.contacts.normal_impulse[i] : 0;
      if (r.contacts.mode[i] == NSDAE_MODE_SLIP) slip += on_ice;
      if (r.contacts.mode[i] == NSDAE_MODE_STICK) stick += !on_ice;
    }
    assert_int_equal(slip, 4);
    assert_int_equal(stick, BALLS);
    /* the tolerance of a small problem is 1e-10 of its largest impulse */
    assert_near(weight, 3 * g * o.dt, 1e-9 * 3 * g * o.dt);
    nsdae_sim_destroy(&sim);
    nsdae_system_destroy(&system);
    nsdae_bodies_destroy(&b);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_published),
                                     cmocka_unit_test(test_slopes),
                                     cmocka_unit_test(test_rolls_out),
                                     cmocka_unit_test(test_pyramid), cmocka_unit_test(test_modes)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
