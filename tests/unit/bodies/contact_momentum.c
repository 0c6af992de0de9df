/* The contact forces of sensors are the change of momentum: in each step, of each body without
 * joints,
 *
 *   m (v_1 - v_0) = h (f + m g)
 *
 * to rounding, whatever its shapes, edges and frictions are: seeded families in the plane and in
 * space, by fixed contacts and by list, by every method. NSDAE_SEED: another first seed. */
#include "check.h"

#include <stdlib.h>

#include <nsdae/nsdae.h>

#include "support/hung_bodies.h"
#include "support/random.h"

static const double g = 9.81;

static const int methods[] = {NSDAE_METHOD_EVENT, NSDAE_METHOD_MOREAU, NSDAE_METHOD_IMPLICIT,
                              NSDAE_METHOD_PENALTY, NSDAE_METHOD_IMPLICIT_PRINTED};

/* Of the largest velocity that a contact gives in a step, 2 to 10 m/s: some hundred roundings. Time
 * stepping puts to rest what is slower than contact_tol, here the same. */
static const double tolerance = 1e-12;

enum { BODIES_MAX = 3, CASES = 140, METHODS = sizeof methods / sizeof *methods };

typedef struct heap {
  nsdae_sim *sim;
  int d, bodies;
  double mass[BODIES_MAX], v[6 * BODIES_MAX], worst, largest;
} heap;

/* A convex shape with corners, or a round one. */
static int add_shape(nsdae_bodies *b, int body, uint64_t *seed, int d)
{
  enum { CORNERS = 6 };
  const int planar[] = {NSDAE_SHAPE_POLYGON, NSDAE_SHAPE_SEGMENT, NSDAE_SHAPE_DISC};
  const int spatial[] = {NSDAE_SHAPE_BOX, NSDAE_SHAPE_CAPSULE, NSDAE_SHAPE_POLYHEDRON,
                         NSDAE_SHAPE_SPHERE};
  double point[3 * CORNERS];
  nsdae_solid s = {.shape = d == 2 ? planar[random_below(seed, 3)] : spatial[random_below(seed, 4)],
                   .radius = random_between(seed, 0.05, 0.2)};
  for (int i = 0; i < 3; i++) s.length[i] = random_between(seed, 0.2, 0.5);
  const double lengths[] = {s.length[0], s.length[1], s.length[2]};
  for (int i = 0; i < CORNERS; i++) /* on an ellipse or an ellipsoid */
    for (int j = 0; j < d; j++)
      point[i * d + j] = d == 2 ? lengths[j] / 2 * (j == 0 ? cos(i) : sin(i))
                                : lengths[j] / 2 * (i % 3 == j ? (i < 3 ? 1 : -1) : 0.1);
  s.points = s.shape == NSDAE_SHAPE_POLYGON || s.shape == NSDAE_SHAPE_POLYHEDRON ? CORNERS : 0;
  int own = s.shape;
  if (own == NSDAE_SHAPE_POLYGON || own == NSDAE_SHAPE_BOX || own == NSDAE_SHAPE_POLYHEDRON)
    s.radius = 0;
  for (int i = 0; i < 3; i++)
    if (own != NSDAE_SHAPE_BOX && !(own == NSDAE_SHAPE_SEGMENT && i == 0) &&
        !(own == NSDAE_SHAPE_CAPSULE && i == 2))
      s.length[i] = 0;
  s.point = s.points > 0 ? point : NULL;
  int solid = nsdae_bodies_add_solid(b, body, &s);
  if (solid == NSDAE_E_UNSUPPORTED) {
    s.shape = NSDAE_SHAPE_BOX;
    memcpy(s.length, lengths, sizeof lengths);
    s.points = 0;
    solid = nsdae_bodies_add_solid(b, body, &s);
  }
  if (solid < 0) fail_msg("%s", nsdae_bodies_error(b)->text);
  return solid;
}

static int observe(const nsdae_record *r, nsdae_error *error, void *user)
{
  heap *h = user;
  int nv = h->d == 2 ? 3 : 6;
  (void)error;
  for (int i = 0; i < h->bodies; i++) {
    double f[NSDAE_VALUES_MAX];
    assert_int_equal(nsdae_sim_get_sensor(h->sim, i, f), NSDAE_OK);
    for (int j = 0; j < h->d && r->duration > 0; j++) {
      double given = r->duration * (f[j] - (j == h->d - 1 ? h->mass[i] * g : 0));
      double change = h->mass[i] * (r->v[nv * i + j] - h->v[nv * i + j]);
      h->worst = fmax(h->worst, fabs(given - change) / h->mass[i]);
      h->largest = fmax(h->largest, fabs(f[j]) * r->duration / h->mass[i]);
    }
  }
  memcpy(h->v, r->v, (size_t)(nv * h->bodies) * sizeof *h->v);
  return 0;
}

/* Bodies above a floor, or above a fixed box whose edges they meet. */
static nsdae_bodies *drop(uint64_t seed, heap *h)
{
  int d = h->d = 2 + random_below(&seed, 2), list = random_below(&seed, 2);
  double mu = random_between(&seed, 0, 1) * (random_below(&seed, 4) > 0);
  double e = random_between(&seed, 0, 0.9) * (random_below(&seed, 3) > 0);
  nsdae_bodies *b = create(d, 0, d == 2 ? -g : 0, d == 3 ? -g : 0);
  nsdae_solid ground = {.shape = NSDAE_SHAPE_PLANE};
  const double square[] = {-0.2, -0.2, 0.2, -0.2, 0.2, 0.2, -0.2, 0.2};
  if (random_below(&seed, 2))
    ground = (nsdae_solid){.shape = d == 2 ? NSDAE_SHAPE_POLYGON : NSDAE_SHAPE_BOX,
                           .length = {0.4, 0.4, 0.4},
                           .points = d == 2 ? 4 : 0,
                           .point = d == 2 ? square : NULL};
  int floor = nsdae_bodies_add_solid(b, NSDAE_GROUND, &ground), solid[BODIES_MAX];
  h->bodies = 1 + random_below(&seed, BODIES_MAX);
  for (int i = 0; i < h->bodies; i++) {
    nsdae_rigid_body body = {.inertia = {0.01, 0.01, 0.01}};
    body.mass = h->mass[i] = random_between(&seed, 0.5, 3);
    body.position[0] = random_between(&seed, -0.15, 0.15);
    body.position[d - 1] = 0.6 + 0.8 * i;
    if (d == 2) body.angle = random_between(&seed, -3, 3);
    for (int j = 0; j < 4 && d == 3; j++) body.quaternion[j] = random_between(&seed, -1, 1);
    for (int j = 0; j < 3; j++) body.inertia[j] = body.mass * random_between(&seed, 0.02, 0.03);
    for (int j = d == 2 ? 2 : 0; j < 3; j++) body.spin[j] = random_between(&seed, -5, 5);
    assert_int_equal(nsdae_bodies_add(b, &body), i);
    solid[i] = add_shape(b, i, &seed, d);
    for (int j = 0; j < i && !list; j++) nsdae_bodies_add_contact(b, solid[j], solid[i], mu, e, 0);
    if (!list) nsdae_bodies_add_contact(b, floor, solid[i], mu, e, 0);
    nsdae_bodies_add_sensor(b, &(nsdae_sensor){.kind = NSDAE_SENSOR_CONTACT_FORCE, .body = i});
  }
  if (list) nsdae_bodies_set_pair(b, 0, 0, mu, e, 0);
  return b;
}

/* 1: it was judged; 0: refused. */
static int run_heap(uint64_t seed, int method, double *worst, double *largest)
{
  heap h = {0};
  nsdae_system *system;
  nsdae_sim_options o;
  double q[NQ_MAX];
  nsdae_bodies *b = drop(seed, &h);
  if (nsdae_bodies_system(b, &system) < 0) fail_msg("%s", nsdae_bodies_error(b)->text);
  nsdae_bodies_get_start(b, q, h.v);
  nsdae_sim_options_default(&o);
  o.method = method;
  o.dt = method == NSDAE_METHOD_EVENT || method == NSDAE_METHOD_PENALTY ? 5e-3 : 2e-3;
  o.integrator = NSDAE_INTEGRATOR_DOPRI5; /* IDA: to its tolerance */
  o.contact_tol = tolerance;
  o.penalty_stiffness = 1e4;
  assert_int_equal(nsdae_sim_create(system, &o, &h.sim, NULL), NSDAE_OK);
  nsdae_sim_observe(h.sim, observe, &h);
  int status = nsdae_sim_init(h.sim, 0, q, h.v);
  if (status >= 0) status = nsdae_sim_run(h.sim, 0.6);
  if (status < 0)
    print_message("seed %llu method %d: %s\n", (unsigned long long)seed, method,
                  nsdae_sim_error(h.sim)->text);
  *worst = h.worst;
  *largest = fmax(*largest, h.largest);
  nsdae_sim_destroy(&h.sim);
  nsdae_system_destroy(&system);
  nsdae_bodies_destroy(&b);
  return status >= 0;
}

static void test_momentum(void **state)
{
  const char *text = getenv("NSDAE_SEED");
  uint64_t first = text ? strtoull(text, NULL, 10) : 1;
  (void)state;
  for (int m = 0; m < METHODS; m++) {
    int penalty = methods[m] == NSDAE_METHOD_PENALTY; /* its steps are short */
    int judged = 0, cases = share_of(penalty ? CASES / 10 : CASES);
    double largest = 0, most = 0;
    for (int i = 0; i < cases; i++) {
      double worst;
      judged += run_heap(first + (uint64_t)i, methods[m], &worst, &largest);
      if (worst > tolerance)
        print_message("seed %llu method %d: %.3g m/s\n", (unsigned long long)(first + (uint64_t)i),
                      methods[m], worst);
      most = fmax(most, worst);
    }
    assert_true(largest > 1);
    assert_true(judged > 0.9 * cases);
    assert_at_most(most, 2 * tolerance * largest);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_momentum)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
