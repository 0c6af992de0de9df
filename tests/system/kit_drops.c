/* Discs, convex polygons and rounded segments of the kit that fall into a box, by the event-driven
 * method, seeded. Corners slide past the ends of edges, faces lie flush, light bodies are between
 * heavy ones. Every run with a status >= 0 is judged without the library: energy by its own formula
 * never grows, no corner is below the floor or behind a wall, no contact pulls, no friction leaves
 * its cone. Runs that are refused are few. */
#include "check.h"

#include <stdlib.h>
#include <string.h>

#include <nsdae/nsdae.h>

#include "random_system.h"

enum { BODIES = 3, CORNERS = 6 };

static const double gravity = 9.81, half_width = 0.6;

typedef struct dropped {
  int bodies, corners[BODIES]; /* a disc has one */
  double corner[BODIES][2 * CORNERS], radius[BODIES], mass[BODIES], inertia[BODIES];
  double mu, e;
} dropped;

/* What no record may hold. */
typedef struct judged {
  const dropped *d;
  int k;                            /* contacts */
  double most, size;                /* energy: the least bound so far, of all at the start */
  double gain, depth, pull, excess; /* the worst */
  double impulse;                   /* the largest */
} judged;

static double energy_of(const dropped *d, const double *q, const double *v)
{
  double sum = 0;
  for (int i = 0; i < d->bodies; i++) {
    const double *x = q + 3 * i, *u = v + 3 * i;
    sum += d->mass[i] * ((u[0] * u[0] + u[1] * u[1]) / 2 + gravity * x[1]);
    sum += d->inertia[i] * u[2] * u[2] / 2;
  }
  return sum;
}

static double depth_of(const dropped *d, const double *q)
{
  double most = 0;
  for (int i = 0; i < d->bodies; i++)
    for (int j = 0; j < d->corners[i]; j++) {
      const double *x = q + 3 * i, *p = d->corner[i] + 2 * j, c = cos(x[2]), s = sin(x[2]);
      double at[2] = {x[0] + c * p[0] - s * p[1], x[1] + s * p[0] + c * p[1]};
      most = fmax(most, d->radius[i] - fmin(at[1], half_width - fabs(at[0])));
    }
  return most;
}

static int judge(const nsdae_record *r, nsdae_error *error, void *user)
{
  judged *j = user;
  double energy = energy_of(j->d, r->q, r->v);
  (void)error;
  if (r->step == 0) j->most = energy, j->size = fabs(energy);
  j->gain = fmax(j->gain, energy - j->most);
  j->most = fmin(j->most, energy);
  j->depth = fmax(j->depth, depth_of(j->d, r->q));
  return 0;
}

static int judge_contacts(const nsdae_record *r, nsdae_error *error, void *user)
{
  judged *j = user;
  (void)error;
  for (int i = 0; i < j->k; i++) {
    double P = r->normal_impulse[i], T = fabs(r->tangential_impulse[i]);
    j->impulse = fmax(j->impulse, P);
    j->pull = fmax(j->pull, -P);
    j->excess = fmax(j->excess, T - j->d->mu * P);
  }
  return 0;
}

/* The certificate has the same figures; what it calls unexplained is an error of the integrator. */
static void expect_figures(const nsdae_sim *sim, const judged *j)
{
  nsdae_record r;
  nsdae_stats s;
  if (nsdae_sim_get_record(sim, &r) < 0) return; /* the start was refused */
  nsdae_sim_get_stats(sim, &s);
  assert_near(s.certificate.pull, j->pull, 0);
  assert_near(s.certificate.cone_excess, j->excess, 0);
  assert_at_most(j->depth, s.certificate.penetration + 1e-14); /* of the walls alone */
  assert_near(r.certificate.energy, energy_of(j->d, r.q, r.v), 1e-12 * (1 + j->size));
  assert_near(r.certificate.unexplained, 0, 1e-6 * (1 + j->size));
  assert_near(r.certificate.work, 0, 1e-5 * (1 + j->size)); /* gravity has a potential */
}

/* A convex polygon about its centroid, on an ellipse. */
static void draw_polygon(uint64_t *s, double *corner, int n)
{
  double angle[CORNERS], area = 0, centre[2] = {0, 0};
  double flat = 0.4 + 0.6 * random_uniform(s), turn = random_uniform(s);
  for (int i = 0; i < n; i++) {
    angle[i] = 2 * acos(-1) * (i + turn + 0.6 * (random_uniform(s) - 0.5)) / n;
    corner[2 * i] = 0.2 * cos(angle[i]);
    corner[2 * i + 1] = 0.2 * flat * sin(angle[i]);
  }
  for (int i = 0; i < n; i++) {
    const double *a = corner + 2 * i, *b = corner + 2 * ((i + 1) % n);
    double cross = a[0] * b[1] - b[0] * a[1];
    area += cross / 2;
    for (int l = 0; l < 2; l++) centre[l] += (a[l] + b[l]) * cross / 6;
  }
  for (int i = 0; i < 2 * n; i++) corner[i] -= centre[i % 2] / area;
}

static int add_body(nsdae_bodies *b, dropped *d, uint64_t *s)
{
  int i = d->bodies++, kind = (int)(3 * random_uniform(s));
  double density = random_uniform(s) < 0.3 ? 1e4 : 10, inertia[3];
  nsdae_solid solid = {.radius = 0.15};
  nsdae_rigid_body body = {.position = {0.6 * (random_uniform(s) - 0.5), 0.5 + 0.6 * i, 0},
                           .angle = 6 * (random_uniform(s) - 0.5),
                           .velocity = {2 * random_uniform(s) - 1, 2 * random_uniform(s) - 1, 0},
                           .spin = {0, 0, 10 * (random_uniform(s) - 0.5)}};
  d->corners[i] = 1;
  d->radius[i] = 0.15;
  solid.shape = NSDAE_SHAPE_DISC;
  if (kind == 1) {
    d->corners[i] = 3 + (int)(4 * random_uniform(s));
    draw_polygon(s, d->corner[i], d->corners[i]);
    solid =
        (nsdae_solid){.shape = NSDAE_SHAPE_POLYGON, .points = d->corners[i], .point = d->corner[i]};
    d->radius[i] = 0;
  }
  assert_int_equal(nsdae_solid_inertia(&solid, density, &d->mass[i], inertia, NULL), NSDAE_OK);
  d->inertia[i] = inertia[2];
  if (kind == 2) {
    solid = (nsdae_solid){.shape = NSDAE_SHAPE_SEGMENT, .radius = 0.05, .length = {0.4}};
    d->corners[i] = 2;
    d->corner[i][0] = -0.2, d->corner[i][2] = 0.2;
    d->radius[i] = 0.05;
    d->inertia[i] = d->mass[i] * 0.4 * 0.4 / 12;
  }
  body.mass = d->mass[i];
  body.inertia[2] = d->inertia[i];
  assert_int_equal(nsdae_bodies_add(b, &body), i);
  return nsdae_bodies_add_solid(b, i, &solid);
}

/* Whether the run with this seed is refused; the rest is asserted. */
static int run(unsigned long seed)
{
  static const double mus[] = {0, 0.2, 0.5, 1}, es[] = {0, 0, 0.2, 0.5, 0.8};
  uint64_t s = seed * 2654435761u + 88172645463325252u;
  for (int i = 0; i < 8; i++) random_uniform(&s);
  dropped d = {.mu = mus[(int)(4 * random_uniform(&s))], .e = es[(int)(5 * random_uniform(&s))]};
  int bodies = 1 + (int)(BODIES * random_uniform(&s)), solid[BODIES], wall[3];
  nsdae_bodies *b;
  nsdae_system *system;
  nsdae_sim_options o;
  double q[3 * BODIES], v[3 * BODIES];
  assert_int_equal(nsdae_bodies_create(2, &b, NULL), NSDAE_OK);
  nsdae_bodies_set_gravity(b, (const double[3]){0, -gravity, 0});
  for (int i = 0; i < bodies; i++) solid[i] = add_body(b, &d, &s);
  for (int i = 0; i < 3; i++) {
    nsdae_solid plane = {.shape = NSDAE_SHAPE_PLANE,
                         .position = {half_width * (i == 1 ? -1 : i == 2), 0, 0},
                         .angle = acos(-1) / 2 * (i == 1 ? -1 : i == 2)};
    wall[i] = nsdae_bodies_add_solid(b, NSDAE_GROUND, &plane);
  }
  for (int i = 0; i < bodies; i++) {
    for (int j = 0; j < 3; j++) nsdae_bodies_add_contact(b, wall[j], solid[i], d.mu, d.e, 0);
    for (int j = 0; j < i; j++) nsdae_bodies_add_contact(b, solid[j], solid[i], d.mu, d.e, 0);
  }
  assert_true(nsdae_bodies_system(b, &system) >= 0);
  nsdae_bodies_get_start(b, q, v);
  nsdae_sim_options_default(&o);
  o.method = NSDAE_METHOD_EVENT;
  nsdae_dims dims;
  nsdae_sim *sim;
  nsdae_bodies_get_dims(b, &dims);
  judged found = {.d = &d, .k = dims.k}, *is = &found;
  assert_int_equal(nsdae_sim_create(system, &o, &sim, NULL), NSDAE_OK);
  nsdae_sim_observe(sim, judge, is);
  nsdae_sim_observe(sim, judge_contacts, is);
  int status = nsdae_sim_init(sim, 0, q, v);
  if (status >= 0) status = nsdae_sim_run(sim, 1);
  int wrong = is->gain > 1e-6 * is->size || is->depth > 1e-6 ||
              is->pull > 1e-7 * (1 + is->impulse) || is->excess > 1e-6 * (1e-6 + is->impulse);
  if (status < 0 || wrong)
    print_message("%lu: status %d gain %.2g depth %.2g pull %.2g excess %.2g of %.2g: %s\n", seed,
                  status, is->gain / is->size, is->depth, is->pull, is->excess, is->impulse,
                  nsdae_sim_error(sim)->text);
  assert_true(status < 0 || !wrong);
  expect_figures(sim, is);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  nsdae_bodies_destroy(&b);
  return status < 0;
}

/* NSDAE_DROPS: how many; NSDAE_DROPS_FROM: the first. */
static void test_drops(void **state)
{
  const char *many = getenv("NSDAE_DROPS"), *from = getenv("NSDAE_DROPS_FROM");
  unsigned long count = many ? strtoul(many, NULL, 10) : 60;
  unsigned long first = from ? strtoul(from, NULL, 10) : 1;
  int refused = 0;
  (void)state;
  for (unsigned long i = first; i < first + count; i++) refused += run(i);
  print_message("%lu drops, %d refused\n", count, refused);
  assert_at_most(refused, 2 + 0.03 * (double)count);
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_drops)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
