/* Systems by blocks with a contact list: the same motion as when they are given dense, statics of
 * columns, balances of momentum and energy, and everything that can go wrong with a list. */
#include "check.h"

#include <stdlib.h>

#include "allocator.h"
#include "twin.h"

enum { METHODS = 3, STEPS = 60 };

static nsdae_sim *make(nsdae_system *system, int method, double dt)
{
  nsdae_sim_options options;
  nsdae_sim *sim;
  nsdae_error error;
  nsdae_sim_options_default(&options);
  options.projection = NSDAE_PROJECTION_NONE; /* its slop is of an island: of all, with one block */
  options.method = method;
  options.dt = dt;
  options.rank_tol = 1e-12;
  assert_non_null(system);
  if (nsdae_sim_create(system, &options, &sim, &error) < 0) fail_msg("%s", error.text);
  return sim;
}

static void start(nsdae_sim *sim, const double *q0, const double *v0)
{
  if (nsdae_sim_init(sim, 0, q0, v0) < 0) fail_msg("%s", nsdae_sim_error(sim)->text);
}

static void advance(nsdae_sim *sim)
{
  if (nsdae_sim_step(sim) < 0) fail_msg("%s", nsdae_sim_error(sim)->text);
}

/* ---- more rows than a dense island may have */

enum { POINTS = 300 };

static int points_mass(double t, const double *q, double *M, void *user)
{
  (void)t, (void)q, (void)user;
  for (int i = 0; i < POINTS; i++)
    for (int j = 0; j < 3; j++) M[9 * i + 4 * j] = 1;
  return 0;
}

static int points_force(double t, const double *q, const double *v, double *F, void *user)
{
  (void)t, (void)q, (void)v, (void)user;
  for (int i = 0; i < 3 * POINTS; i++) F[i] = i;
  return 0;
}

static int points_phi(double t, const double *q, double *phi, void *user)
{
  (void)t, (void)user;
  for (int i = 1; i < POINTS; i++)
    for (int j = 0; j < 2; j++) phi[2 * i - 2 + j] = q[3 * i + j] - q[3 * i - 3 + j];
  return 0;
}

static int points_rows(double t, const double *q, nsdae_row_list *rows, void *user)
{
  int status = 0;
  (void)t, (void)q, (void)user;
  for (int i = 1; i < POINTS; i++)
    for (int j = 0; j < 2 && status == 0; j++) {
      const double one[3] = {j == 0, j == 1, 0}, less[3] = {-one[0], -one[1], 0};
      status = nsdae_row_add(rows, 2 * i - 2 + j, i, one);
      if (status == 0) status = nsdae_row_add(rows, 2 * i - 2 + j, i - 1, less);
    }
  return status;
}

/* Points that go together along two axes: there each has the mean force, along the third its own.
 */
static void test_many_rows(void **state)
{
  const int m = 2 * (POINTS - 1), n = 3 * POINTS;
  const nsdae_dims dims = {.nq = n, .nv = n, .m = m};
  int size[POINTS];
  double *zero = calloc((size_t)n, sizeof *zero);
  (void)state;
  for (int i = 0; i < POINTS; i++) size[i] = 3;
  for (int method = 0; method < 2; method++) {
    nsdae_system *system = NULL;
    assert_int_equal(nsdae_system_create(&dims, &system, NULL), NSDAE_OK);
    nsdae_system_set_blocks(system, POINTS, size, size);
    nsdae_system_set_mass_blocks(system, points_mass);
    nsdae_system_set_force(system, points_force);
    nsdae_system_set_constraint(system, points_phi);
    nsdae_system_set_constraint_rows(system, points_rows);
    nsdae_sim *sim = make(system, method == 0 ? NSDAE_METHOD_MOREAU : NSDAE_METHOD_IMPLICIT, 1e-3);
    start(sim, zero, zero);
    advance(sim);
    nsdae_record r;
    nsdae_sim_get_record(sim, &r);
    for (int i = 0; i < n; i++) {
      double force = i % 3 == 2 ? i : 3 * (POINTS - 1) / 2.0 + i % 3;
      assert_near(r.v[i], 1e-3 * force, 1e-12 * POINTS);
    }
    nsdae_sim_destroy(&sim);
    nsdae_system_destroy(&system);
  }
  free(zero);
}

/* ---- columns */

typedef struct column {
  int balls;
  double ratio; /* of every other mass */
} column;

static double mass_of(const column *c, int i)
{
  return i % 2 ? c->ratio : 1;
}

static int column_mass(double t, const double *q, double *M, void *user)
{
  const column *c = user;
  (void)t;
  (void)q;
  for (int i = 0; i < c->balls; i++) M[i] = mass_of(c, i);
  return 0;
}

static int column_force(double t, const double *q, const double *v, double *F, void *user)
{
  const column *c = user;
  (void)t;
  (void)q;
  (void)v;
  for (int i = 0; i < c->balls; i++) F[i] = -9.81 * mass_of(c, i);
  return 0;
}

static int column_contacts(double t, const double *q, const double *v, double reach,
                           nsdae_contact_list *list, void *user)
{
  const column *c = user;
  (void)t;
  (void)v;
  for (int i = 0; i < c->balls; i++) {
    double gap = i > 0 ? q[i] - q[i - 1] - 1 : q[0] - 0.5;
    nsdae_contact contact = {.id = i, .block = {i, i - 1}, .gap = gap};
    contact.direction[0][0][0] = 1;
    contact.direction[1][0][0] = -1;
    if (gap <= reach) nsdae_contact_add(list, &contact);
  }
  return 0;
}

/* The same contacts, all of one id. */
static int twice(double t, const double *q, const double *v, double reach, nsdae_contact_list *list,
                 void *user)
{
  nsdae_contact contact = {.id = 4, .block = {-1, 1}, .gap = 0};
  (void)t;
  (void)q;
  (void)v;
  (void)reach;
  (void)user;
  nsdae_contact_add(list, &contact);
  contact.block[1] = 2;
  nsdae_contact_add(list, &contact);
  return 0;
}

/* Each four times over: at most as many as there are, at least what is within reach. */
static int many_contacts(double t, const double *q, const double *v, double reach,
                         nsdae_contact_list *list, void *user)
{
  const column *c = user;
  (void)t;
  (void)v;
  for (int i = 0; i < 4 * c->balls; i++) {
    int ball = i % c->balls;
    double gap = ball > 0 ? q[ball] - q[ball - 1] - 1 : q[0] - 0.5;
    nsdae_contact contact = {.id = i, .block = {ball, ball - 1}, .gap = gap};
    contact.direction[0][0][0] = 1;
    contact.direction[1][0][0] = -1;
    if (gap <= reach) nsdae_contact_add(list, &contact);
  }
  return 0;
}

static nsdae_system *column_system(column *c)
{
  const nsdae_dims dims = {.nq = c->balls};
  nsdae_system *s = NULL;
  int *ones = malloc((size_t)c->balls * sizeof *ones);
  for (int i = 0; i < c->balls; i++) ones[i] = 1;
  assert_int_equal(nsdae_system_create(&dims, &s, NULL), NSDAE_OK);
  nsdae_system_set_user(s, c);
  assert_int_equal(nsdae_system_set_blocks(s, c->balls, ones, ones), NSDAE_OK);
  assert_int_equal(nsdae_system_get_blocks(s), c->balls);
  nsdae_system_set_mass_blocks(s, column_mass);
  nsdae_system_set_force(s, column_force);
  nsdae_system_set_contacts(s, column_contacts);
  free(ones);
  return s;
}

/* Ball i carries what is above it: Lambda_i = h g sum of the masses i, i + 1, ... */
static void expect_weights(const column *c, const nsdae_record *r, double h)
{
  double above = 0;
  assert_int_equal(r->contacts.count, c->balls);
  for (int i = c->balls - 1; i >= 0; i--) {
    above += 9.81 * mass_of(c, i) * h;
    assert_int_equal(r->contacts.id[i], i);
    assert_near(r->contacts.normal_impulse[i], above, 1e-10 * above);
  }
}

static void stand(int balls, double ratio, int method, int steps)
{
  column c = {balls, ratio};
  double *q0 = calloc((size_t)balls, sizeof *q0), *v0 = calloc((size_t)balls, sizeof *v0);
  nsdae_system *system = column_system(&c);
  nsdae_sim *sim = make(system, method, 1e-3);
  nsdae_record r;
  for (int i = 0; i < balls; i++) q0[i] = i + 0.5;
  start(sim, q0, v0);
  for (int i = 0; i < steps; i++) advance(sim);
  nsdae_sim_get_record(sim, &r);
  expect_weights(&c, &r, 1e-3);
  for (int i = 0; i < balls; i++) assert_near(r.v[i], 0, 1e-10);
  free(q0);
  free(v0);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
}

static void test_columns_stand(void **state)
{
  (void)state;
  for (int method = 0; method < METHODS; method++) {
    stand(1, 1, method, 20);
    stand(7, 1000, method, 20);
    stand(40, 1000, method, 10); /* dense */
    stand(120, 1, method, 10);   /* by blocks */
    stand(120, 1000, method, 5);
  }
  stand(1000, 1, NSDAE_METHOD_MOREAU, 5);
  stand(1000, 1000, NSDAE_METHOD_MOREAU, 2);
}

/* ---- dense and by blocks */

/* Impulses of numbered contacts are those by id. */
static void same_impulses(const twin *t, const nsdae_record *dense, const nsdae_record *listed,
                          double tol)
{
  int closed = 0;
  for (int i = 0; i < listed->contacts.count; i++) {
    int number = (int)((t->id_of_first - listed->contacts.id[i]) / 3);
    assert_near(listed->contacts.normal_impulse[i], dense->normal_impulse[number], tol);
    assert_int_equal(listed->contacts.block[2 * i], t->gap[number].block[0]);
    for (int d = 0; d < t->nt; d++)
      assert_near(listed->contacts.tangential_impulse[i * t->nt + d],
                  dense->tangential_impulse[number * t->nt + d], tol);
    closed += listed->contacts.normal_impulse[i] > 0;
  }
  for (int i = 0; i < t->k; i++) closed -= dense->normal_impulse[i] > 0;
  if (tol < 1e-6) assert_int_equal(closed, 0);
}

/* One mechanism both ways; returns the impacts, or -1 where the dense one cannot be solved, which
 * the other then cannot either. */
static long compare(twin *t, int method, double tol)
{
  nsdae_system *systems[2] = {twin_dense(t), twin_blocks(t)};
  nsdae_sim *sims[2];
  nsdae_record r[2];
  nsdae_stats stats[2];
  for (int i = 0; i < 2; i++) sims[i] = make(systems[i], method, 2e-3);
  if (nsdae_sim_project(sims[0], 0, t->q0, t->v0) < 0) fail_msg("no start");
  for (int i = 0; i < 2; i++) start(sims[i], t->q0, t->v0);
  int status[2] = {0};
  for (int n = 0; n < STEPS && status[0] >= 0; n++) {
    for (int i = 0; i < 2; i++) {
      status[i] = nsdae_sim_step(sims[i]);
      nsdae_sim_get_record(sims[i], &r[i]);
    }
    for (int i = 0; i < 2; i++)
      if (status[i] < 0 && status[1 - i] >= 0) fail_msg("%s", nsdae_sim_error(sims[i])->text);
    for (int j = 0; j < t->nv; j++) {
      assert_near(r[1].q[j], r[0].q[j], tol);
      assert_near(r[1].v[j], r[0].v[j], 100 * tol);
    }
    for (int i = 0; i < t->m && status[0] >= 0; i++)
      assert_near(r[1].multiplier[i], r[0].multiplier[i], 1e6 * tol);
    if (status[0] >= 0) same_impulses(t, &r[0], &r[1], 1e3 * tol);
  }
  for (int i = 0; i < 2; i++) nsdae_sim_get_stats(sims[i], &stats[i]);
  if (tol < 1e-9) assert_int_equal(stats[0].impacts, stats[1].impacts);
  assert_near(stats[1].energy_balance, stats[0].energy_balance, 1e3 * tol);
  for (int i = 0; i < 2; i++) {
    nsdae_sim_destroy(&sims[i]);
    nsdae_system_destroy(&systems[i]);
  }
  return status[0] < 0 ? -1 : stats[0].impacts;
}

static void test_small_both_ways(void **state)
{
  static const twin_kind kinds[] = {
      {.blocks = 1, .largest = 3, .k = 1},
      {.blocks = 4,
       .largest = 3,
       .joined = 1,
       .k = 4,
       .nt = 1,
       .friction = 0.4,
       .restitution = 0.8},
      {.blocks = 5, .largest = 7, .joined = 1, .k = 5, .nt = 1, .friction = 0.2},
      {.blocks = 6, .largest = 2, .joined = 1, .k = 6, .restitution = 1},
      {.blocks = 4, .largest = 6, .joined = 1, .k = 3, .nt = 2},
      {.blocks = 3, .largest = 3, .joined = 1}};
  long impacts = 0, solved = 0;
  (void)state;
  for (size_t kind = 0; kind < sizeof kinds / sizeof *kinds; kind++)
    for (uint64_t seed = 0; seed < 12; seed++)
      for (int method = 0; method < METHODS; method++) {
        static twin t;
        twin_draw(&t, 100 * kind + seed, &kinds[kind]);
        long found = compare(&t, method, 1e-10);
        if (found < 0) continue;
        impacts += found;
        solved++;
      }
  print_message("%ld runs, %ld impacts\n", solved, impacts);
  assert_true(impacts > 200 && solved > 190);
}

/* Parts that nothing joins: each is an island of its own, whatever the others do. */
static void test_islands_both_ways(void **state)
{
  static const twin_kind kinds[] = {
      {.blocks = 24, .largest = 3, .k = 24, .nt = 1, .friction = 0.4, .restitution = 0.5},
      {.blocks = 12, .largest = 7, .k = 5, .restitution = 0.5}};
  long impacts = 0;
  (void)state;
  for (size_t kind = 0; kind < sizeof kinds / sizeof *kinds; kind++)
    for (uint64_t seed = 0; seed < 8; seed++)
      for (int method = 0; method < METHODS; method++) {
        static twin t;
        twin_draw(&t, 1000 + 100 * kind + seed, &kinds[kind]);
        impacts += compare(&t, method, 1e-10);
      }
  assert_true(impacts > 100);
}

/* Islands past the size of dense ones are solved as cones, to contact_tol. Without friction the
 * velocities are unique. Without contacts they are sparse equations, solved to rounding. */
static void test_large_both_ways(void **state)
{
  static const twin_kind kinds[] = {
      {.blocks = 40, .largest = 3, .joined = 1, .k = 60, .restitution = 0.5},
      {.blocks = 40, .largest = 3, .joined = 1}};
  (void)state;
  for (size_t kind = 0; kind < sizeof kinds / sizeof *kinds; kind++)
    for (uint64_t seed = 0; seed < 3; seed++) {
      static twin t;
      for (int method = 0; method < METHODS; method++) {
        twin_draw(&t, 2000 + 100 * kind + seed, &kinds[kind]);
        assert_true(compare(&t, method, t.k > 0 ? 1e-8 : 1e-12) >= 0);
      }
    }
}

/* ---- balances */

enum { DISKS = 40 };

/* Disks of mass m and radius 1/2 in the plane, not pulled by anything. */
static int disk_mass(double t, const double *q, double *M, void *user)
{
  (void)t;
  (void)q;
  (void)user;
  for (int i = 0; i < DISKS; i++) {
    M[9 * i] = M[9 * i + 4] = 1 + i % 3;
    M[9 * i + 8] = (1 + i % 3) / 8.0;
  }
  return 0;
}

static int nothing(double t, const double *q, const double *v, double *F, void *user)
{
  (void)t;
  (void)q;
  (void)v;
  (void)F;
  (void)user;
  return 0;
}

static int disk_contacts(double t, const double *q, const double *v, double reach,
                         nsdae_contact_list *list, void *user)
{
  const double *mu_and_e = user;
  (void)t;
  (void)v;
  for (int a = 0; a < DISKS; a++)
    for (int b = a + 1; b < DISKS; b++) {
      double x = q[3 * a] - q[3 * b], y = q[3 * a + 1] - q[3 * b + 1], d = hypot(x, y);
      if (d - 1 > reach) continue;
      nsdae_contact c = {.id = a * DISKS + b,
                         .block = {a, b},
                         .gap = d - 1,
                         .mu = mu_and_e[0],
                         .e_n = mu_and_e[1],
                         .direction = {{{x / d, y / d, 0}, {-y / d, x / d, -0.5}},
                                       {{-x / d, -y / d, 0}, {y / d, -x / d, -0.5}}}};
      nsdae_contact_add(list, &c);
    }
  return 0;
}

/* Momentum stays, and kinetic energy is what the contacts have not taken: to rounding, over 10^4
 * steps with impacts of one, two and many at once. */
static void expect_balances(int method, double mu, double e)
{
  double user[] = {mu, e}, q0[3 * DISKS], v0[3 * DISKS], p[2] = {0}, now[2] = {0};
  int threes[DISKS];
  nsdae_system *s;
  nsdae_stats stats;
  nsdae_record r;
  const nsdae_dims dims = {.nq = 3 * DISKS, .nt = 1};
  for (int i = 0; i < DISKS; i++) threes[i] = 3;
  assert_int_equal(nsdae_system_create(&dims, &s, NULL), NSDAE_OK);
  nsdae_system_set_user(s, user);
  nsdae_system_set_blocks(s, DISKS, threes, threes);
  nsdae_system_set_mass_blocks(s, disk_mass);
  nsdae_system_set_force(s, nothing);
  nsdae_system_set_contacts(s, disk_contacts);
  for (int i = 0; i < DISKS; i++) { /* a ring of rings that closes in on itself */
    double angle = 2.4 * i, radius = 1.5 + 0.6 * i;
    q0[3 * i] = radius * cos(angle), q0[3 * i + 1] = radius * sin(angle), q0[3 * i + 2] = 0;
    v0[3 * i] = -2 * cos(angle + 0.1 * (i % 5)), v0[3 * i + 1] = -2 * sin(angle + 0.1 * (i % 7));
    v0[3 * i + 2] = i % 4;
    for (int d = 0; d < 2; d++) p[d] += (1 + i % 3) * v0[3 * i + d];
  }
  nsdae_sim *sim = make(s, method, 2e-3);
  start(sim, q0, v0);
  for (int n = 0; n < 10000; n++) advance(sim);
  nsdae_sim_get_record(sim, &r);
  nsdae_sim_get_stats(sim, &stats);
  for (int i = 0; i < DISKS; i++)
    for (int d = 0; d < 2; d++) now[d] += (1 + i % 3) * r.v[3 * i + d];
  for (int d = 0; d < 2; d++) assert_near(now[d], p[d], 1e-10);
  assert_near(stats.energy_balance, 0, 1e-10 * stats.energy_start);
  if (e == 1 && mu == 0) assert_near(r.kinetic, stats.energy_start, 1e-10 * stats.energy_start);
  assert_true(stats.impacts > 20);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&s);
}

static void test_balances(void **state)
{
  (void)state;
  expect_balances(NSDAE_METHOD_MOREAU, 0, 1);
  expect_balances(NSDAE_METHOD_MOREAU, 0.4, 0.5);
  expect_balances(NSDAE_METHOD_MOREAU, 0.4, 0);
}

/* ---- a wall: bricks 2 x 1 in running bond, two contacts where one lies on another */

typedef struct wall {
  int rows, width;
  int bad; /* this brick's inertia is negative; 0: of none */
} wall;

static int wall_mass(double t, const double *q, double *M, void *user)
{
  const wall *w = user;
  (void)t;
  (void)q;
  for (int i = 0; i < w->rows * w->width; i++) {
    M[9 * i] = M[9 * i + 4] = 2;
    M[9 * i + 8] = 2 * 5.0 / 12;
  }
  if (w->bad > 0) M[9 * w->bad + 8] = -1;
  return 0;
}

static int wall_force(double t, const double *q, const double *v, double *F, void *user)
{
  const wall *w = user;
  (void)t;
  (void)q;
  (void)v;
  for (int i = 0; i < w->rows * w->width; i++) F[3 * i + 1] = -2 * 9.81;
  return 0;
}

/* Point (rx, ry) of brick i. */
static void corner(const double *q, int i, double rx, double ry, double *x, double *y)
{
  double c = cos(q[3 * i + 2]), s = sin(q[3 * i + 2]);
  *x = q[3 * i] + c * rx - s * ry;
  *y = q[3 * i + 1] + s * rx + c * ry;
}

static void lie(const double *q, long id, int a, int b, double rx, double reach,
                nsdae_contact_list *list)
{
  double x, y, below = 0, unused;
  corner(q, a, rx, -0.5, &x, &y);
  if (b >= 0) corner(q, b, x - q[3 * b], 0.5, &unused, &below);
  nsdae_contact c = {.id = id, .block = {a, b}, .gap = y - below, .mu = 0.5};
  for (int s = 0; s < 2; s++) {
    int i = s == 0 ? a : b;
    double sign = s == 0 ? 1 : -1;
    if (i < 0) continue;
    c.direction[s][0][1] = c.direction[s][1][0] = sign;
    c.direction[s][0][2] = sign * (x - q[3 * i]);
    c.direction[s][1][2] = -sign * (y - q[3 * i + 1]);
  }
  if (c.gap <= reach) nsdae_contact_add(list, &c);
}

static int wall_contacts(double t, const double *q, const double *v, double reach,
                         nsdae_contact_list *list, void *user)
{
  const wall *w = user;
  (void)t;
  (void)v;
  for (int i = 0; i < w->rows * w->width; i++) {
    int row = i / w->width, place = i % w->width;
    for (int k = 0; k < 4; k++) {
      int half = k / 2, under = place + (row % 2 ? half : half - 1);
      if (row > 0 && (under < 0 || under >= w->width)) continue;
      if (row == 0 && half == 1) continue;
      double rx = row == 0 ? 2 * k - 1 : half - 1 + k % 2;
      lie(q, 8L * i + k, i, row > 0 ? (row - 1) * w->width + under : -1, rx, reach, list);
    }
  }
  return 0;
}

/* What stands still has velocities 0.0, and stays where it is to the last bit. */
static void expect_still(int rows, int width, int steps)
{
  wall w = {rows, width, 0};
  int bricks = rows * width;
  const nsdae_dims dims = {.nq = 3 * bricks, .nt = 1};
  nsdae_system *s;
  nsdae_record r;
  double *q0 = calloc((size_t)bricks * 3, sizeof *q0), *v0 = calloc((size_t)bricks * 3, sizeof *v0);
  int *threes = malloc((size_t)bricks * sizeof *threes);
  double floor = 0;
  for (int i = 0; i < bricks; i++) {
    threes[i] = 3;
    q0[3 * i] = 2 * (i % width) + i / width % 2;
    q0[3 * i + 1] = i / width + 0.5;
  }
  assert_int_equal(nsdae_system_create(&dims, &s, NULL), NSDAE_OK);
  nsdae_system_set_user(s, &w);
  nsdae_system_set_blocks(s, bricks, threes, threes);
  nsdae_system_set_mass_blocks(s, wall_mass);
  nsdae_system_set_force(s, wall_force);
  nsdae_system_set_contacts(s, wall_contacts);
  nsdae_sim *sim = make(s, NSDAE_METHOD_MOREAU, 1e-3);
  start(sim, q0, v0);
  for (int i = 0; i < steps; i++) assert_int_equal(nsdae_sim_step(sim), NSDAE_OK);
  nsdae_sim_get_record(sim, &r);
  w.bad = bricks / 2;
  assert_int_equal(nsdae_sim_step(sim), NSDAE_E_MASS);
  assert_int_equal(nsdae_sim_error(sim)->index, 3 * w.bad + 2);
  nsdae_sim_get_record(sim, &r);
  for (int j = 0; j < 3 * bricks; j++) assert_true(r.v[j] == 0);
  assert_memory_equal(r.q, q0, (size_t)bricks * 3 * sizeof *q0);
  for (int i = 0; i < r.contacts.count; i++)
    if (r.contacts.block[2 * i + 1] < 0) floor += r.contacts.normal_impulse[i];
  assert_near(floor, bricks * 2 * 9.81 * 1e-3, 1e-9 * bricks);
  free(q0);
  free(v0);
  free(threes);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&s);
}

static void test_walls_stand_still(void **state)
{
  (void)state;
  expect_still(3, 3, 20);
  expect_still(40, 25, 20);
}

/* ---- what can go wrong with a list */

static const twin_kind plain = {
    .blocks = 6, .largest = 3, .k = 9, .nt = 1, .friction = 0.3, .restitution = 0.5};

/* The call of the list that is spoiled, then the same without: the run goes on as if nothing had
 * been. */
static void fail_once(int code, const nsdae_contact *spoil, int status, const char *argument)
{
  for (int method = 0; method < METHODS; method++) {
    twin t;
    nsdae_record r;
    double q[TWIN_V], expected[TWIN_V];
    for (int round = 0; round < 2; round++) { /* without, with the fault */
      twin_draw(&t, 7, &plain);
      nsdae_system *system = twin_blocks(&t);
      nsdae_sim *sim = make(system, method, 2e-3);
      start(sim, t.q0, t.v0);
      for (int n = 0; n < 30; n++) advance(sim);
      if (round == 1) {
        t.fail_at = t.calls;
        t.fail_code = code;
        if (spoil) t.spoil = *spoil;
        nsdae_sim_get_record(sim, &r);
        memcpy(q, r.q, (size_t)t.nv * sizeof *q);
        assert_int_equal(nsdae_sim_step(sim), status);
        assert_string_equal(nsdae_sim_error(sim)->argument, argument);
        nsdae_sim_get_record(sim, &r);
        assert_int_equal(r.step, 30);
        assert_memory_equal(r.q, q, (size_t)t.nv * sizeof *q);
      }
      for (int n = 0; n < 30; n++) advance(sim);
      nsdae_sim_get_record(sim, &r);
      if (round == 1) assert_memory_equal(r.q, expected, (size_t)t.nv * sizeof *q);
      memcpy(expected, r.q, (size_t)t.nv * sizeof *q);
      nsdae_sim_destroy(&sim);
      nsdae_system_destroy(&system);
    }
  }
}

static void test_failing_lists(void **state)
{
  (void)state;
  const nsdae_contact good = {.id = 5, .block = {0, -1}, .gap = 1, .mu = 0.1};
  nsdae_contact bad = good;
  fail_once(-3, NULL, NSDAE_E_CALLBACK, "contacts");
  fail_once(1, NULL, NSDAE_E_CALLBACK, "contacts");
  bad.block[1] = 0;
  fail_once(0, &bad, NSDAE_E_ARGUMENT, "block");
  bad.block[1] = 6;
  fail_once(0, &bad, NSDAE_E_ARGUMENT, "block");
  bad = good, bad.gap = NAN;
  fail_once(0, &bad, NSDAE_E_NONFINITE, "gap");
  bad = good, bad.mu = -1;
  fail_once(0, &bad, NSDAE_E_ARGUMENT, "mu");
  bad = good, bad.e_n = 2;
  fail_once(0, &bad, NSDAE_E_ARGUMENT, "e_n");
  bad = good, bad.e_t = NAN;
  fail_once(0, &bad, NSDAE_E_ARGUMENT, "e_t");
  bad = good, bad.w[1] = INFINITY;
  fail_once(0, &bad, NSDAE_E_NONFINITE, "w");
  bad = good, bad.direction[0][1][0] = NAN;
  fail_once(0, &bad, NSDAE_E_NONFINITE, "direction");
}

static void expect_refused(nsdae_system *system, int status, const char *argument)
{
  nsdae_sim *sim;
  nsdae_error error;
  assert_int_equal(nsdae_sim_create(system, NULL, &sim, &error), status);
  assert_string_equal(error.argument, argument);
}

static int no_mass(double t, const double *q, double *M, int ldm, void *user)
{
  (void)t;
  (void)q;
  (void)M;
  (void)ldm;
  (void)user;
  return 0;
}

static void test_refusals(void **state)
{
  const int sizes[] = {1, 2}, wrong[] = {1, 1}, none[] = {0, 3};
  nsdae_dims dims = {.nq = 3};
  nsdae_system *s;
  twin t;
  (void)state;
  twin_draw(&t, 7, &plain);
  s = twin_blocks(&t);
  nsdae_system_set_mass(s, no_mass);
  expect_refused(s, NSDAE_E_STATE, "mass");
  nsdae_system_destroy(&s);
  assert_int_equal(nsdae_system_create(&dims, &s, NULL), NSDAE_OK);
  assert_int_equal(nsdae_system_get_blocks(s), 1);
  assert_int_equal(nsdae_system_set_blocks(s, 2, wrong, wrong), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_system_set_blocks(s, 2, sizes, none), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_system_set_blocks(s, 0, sizes, sizes), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_system_set_blocks(s, 2, NULL, sizes), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_system_set_contacts(s, NULL), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_system_set_constraint_rows(s, NULL), NSDAE_E_ARGUMENT);
  nsdae_system_clear_error(s);
  assert_int_equal(nsdae_system_set_blocks(s, 2, sizes, sizes), NSDAE_OK);
  nsdae_system_set_force(s, column_force);
  expect_refused(s, NSDAE_E_STATE, "mass_blocks");
  nsdae_system_destroy(&s);
  dims.k = 1;
  assert_int_equal(nsdae_system_create(&dims, &s, NULL), NSDAE_OK);
  assert_int_equal(nsdae_system_set_blocks(s, 2, sizes, sizes), NSDAE_OK);
  assert_int_equal(nsdae_system_set_contacts(s, column_contacts), NSDAE_E_ARGUMENT);
  assert_string_equal(nsdae_system_error(s)->argument, "k");
  nsdae_system_destroy(&s);
}

/* Right descriptions pass; one wrong entry is found, wherever it is. */
static void test_check(void **state)
{
  static const twin_kind kinds[] = {
      {.blocks = 5, .largest = 7, .joined = 1, .k = 9, .nt = 1, .friction = 0.3},
      {.blocks = 3, .largest = 3, .joined = 1},
      {.blocks = 3, .largest = 6, .k = 5, .nt = 2}};
  nsdae_check worst;
  (void)state;
  for (size_t kind = 0; kind < sizeof kinds / sizeof *kinds; kind++)
    for (uint64_t seed = 0; seed < 5; seed++) {
      twin t;
      twin_draw(&t, 3000 + 10 * kind + seed, &kinds[kind]);
      nsdae_system *s = twin_blocks(&t);
      if (nsdae_system_check(s, 0.1, t.q0, t.v0, 1e-6, &worst) < 0)
        fail_msg("%s", nsdae_system_error(s)->text);
      t.M[1][t.size[1] * t.size[1] > 1 ? 1 : 0] += 0.01;
      if (t.size[1] > 1) {
        assert_int_equal(nsdae_system_check(s, 0.1, t.q0, t.v0, 1e-6, &worst), NSDAE_E_DERIVATIVE);
        assert_string_equal(worst.term, "mass_blocks");
        t.M[1][1] -= 0.01;
      }
      if (t.m > 0) {
        t.wrong_row = 1;
        assert_int_equal(nsdae_system_check(s, 0.1, t.q0, t.v0, 1e-6, &worst), NSDAE_E_DERIVATIVE);
        assert_string_equal(worst.term, "constraint_rows");
        assert_int_equal(worst.row, 1);
        assert_int_equal(worst.column, t.first[1]);
        t.wrong_row = -1;
      }
      if (t.k > 0) {
        t.wrong_contact = 2;
        assert_int_equal(nsdae_system_check(s, 0.1, t.q0, t.v0, 1e-6, &worst), NSDAE_E_DERIVATIVE);
        assert_string_equal(worst.term, "contacts");
      }
      nsdae_system_destroy(&s);
    }
}

/* One id twice is an error where both are closed. */
static void test_ids_are_distinct(void **state)
{
  column c = {3, 1};
  (void)state;
  nsdae_system *system = column_system(&c);
  nsdae_system_set_contacts(system, twice);
  nsdae_sim *sim = make(system, NSDAE_METHOD_MOREAU, 1e-3);
  const double q0[] = {0.5, 1.5, 2.5}, v0[3] = {0};
  assert_int_equal(nsdae_sim_init(sim, 0, q0, v0), NSDAE_E_ARGUMENT);
  assert_string_equal(nsdae_sim_error(sim)->argument, "id");
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
}

/* ---- room */

/* Balls that fall on one another: the list is longer at every step that adds a contact. */
static void test_lists_grow(void **state)
{
  enum { BALLS = 64 };
  column c = {BALLS, 1};
  double q0[BALLS], v0[BALLS] = {0};
  nsdae_stats stats;
  nsdae_sim_options options;
  nsdae_sim *sim;
  (void)state;
  nsdae_system *system = column_system(&c);
  nsdae_system_set_contacts(system, many_contacts);
  for (int i = 0; i < BALLS; i++) q0[i] = i + 0.5 + 1e-3 * (i + 1);
  nsdae_sim_options_default(&options);
  options.dt = 1e-3;
  options.method = NSDAE_METHOD_MOREAU;
  assert_int_equal(nsdae_sim_create(system, &options, &sim, NULL), NSDAE_OK);
  start(sim, q0, v0);
  nsdae_sim_get_stats(sim, &stats);
  assert_int_equal(stats.contact_growths, 0);
  int capacity = stats.contact_capacity;
  for (int i = 0; i < 100; i++) advance(sim);
  nsdae_sim_get_stats(sim, &stats);
  assert_true(stats.contact_growths > 0 && stats.contact_capacity > capacity);
  options.contacts_max = 16; /* the limit has a name */
  nsdae_sim_set_options(sim, &options);
  nsdae_sim_destroy(&sim);
  options.contacts_max = 20;
  assert_int_equal(nsdae_sim_create(system, &options, &sim, NULL), NSDAE_OK);
  start(sim, q0, v0);
  int status = NSDAE_OK;
  for (int i = 0; i < 100 && status >= 0; i++) status = nsdae_sim_step(sim);
  assert_int_equal(status, NSDAE_E_ARGUMENT);
  assert_string_equal(nsdae_sim_error(sim)->argument, "contacts_max");
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
}

/* No step allocates but where a list grows; every lost allocation is survived and leaks nothing. */
static int life(twin *t, int method, long *calls)
{
  nsdae_sim_options options;
  nsdae_sim *sim = NULL;
  nsdae_stats stats = {0};
  nsdae_system *system = twin_blocks(t);
  nsdae_sim_options_default(&options);
  options.method = method;
  options.dt = 2e-3;
  if (!system) return NSDAE_E_MEMORY;
  int status = nsdae_sim_create(system, &options, &sim, NULL);
  if (status == NSDAE_OK) status = nsdae_sim_init(sim, 0, t->q0, t->v0);
  long before = the_allocator.calls;
  for (int n = 0; n < 40 && status >= 0; n++) status = nsdae_sim_step(sim);
  *calls = the_allocator.calls - before;
  if (sim) nsdae_sim_get_stats(sim, &stats);
  if (status >= 0 && stats.contact_growths == 0) assert_int_equal(*calls, 0);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  return status < 0 ? status : NSDAE_OK;
}

static void test_allocations(void **state)
{
  twin t;
  (void)state;
  for (int method = 0; method < METHODS; method++) {
    int status = NSDAE_E_MEMORY;
    long tried = 0, calls;
    twin_draw(&t, 7, &plain);
    for (; status < 0; tried++) {
      allocator_reset(tried);
      status = life(&t, method, &calls);
      assert_true(status == NSDAE_OK || status == NSDAE_E_MEMORY);
      assert_int_equal(the_allocator.live, 0);
    }
    assert_true(tried > 30);
    allocator_reset(-1);
  }
}

/* ---- the state as a value */

static void test_state_goes_on(void **state)
{
  (void)state;
  for (int method = 0; method < METHODS; method++) {
    twin t;
    nsdae_record r[2];
    size_t size, again;
    twin_draw(&t, 11, &plain);
    nsdae_system *system = twin_blocks(&t);
    nsdae_sim *sim = make(system, method, 2e-3), *other = make(system, method, 2e-3);
    start(sim, t.q0, t.v0);
    for (r[0].contacts.count = 0; r[0].contacts.count == 0; nsdae_sim_get_record(sim, &r[0]))
      advance(sim);
    nsdae_sim_state_size(sim, &size);
    char *block = malloc(size);
    assert_int_equal(nsdae_sim_get_state(sim, block, size), NSDAE_OK);
    assert_int_equal(nsdae_sim_set_state(other, block, size), NSDAE_OK);
    nsdae_sim_get_record(other, &r[1]);
    nsdae_sim_get_record(sim, &r[0]);
    assert_int_equal(r[1].contacts.count, r[0].contacts.count);
    assert_true(r[0].contacts.count > 0);
    for (int n = 0; n < 50; n++) {
      advance(sim);
      advance(other);
      nsdae_sim_get_record(sim, &r[0]);
      nsdae_sim_get_record(other, &r[1]);
      assert_memory_equal(r[0].q, r[1].q, (size_t)t.nv * sizeof(double));
      assert_memory_equal(r[0].v, r[1].v, (size_t)t.nv * sizeof(double));
    }
    nsdae_sim_state_size(sim, &size);
    nsdae_sim_state_size(other, &again);
    assert_int_equal(size, again);
    char *end[2] = {malloc(size), malloc(size)};
    assert_int_equal(nsdae_sim_get_state(sim, end[0], size), NSDAE_OK);
    assert_int_equal(nsdae_sim_get_state(other, end[1], size), NSDAE_OK);
    assert_memory_equal(end[0], end[1], size);
    free(block);
    free(end[0]);
    free(end[1]);
    nsdae_sim_destroy(&sim);
    nsdae_sim_destroy(&other);
    nsdae_system_destroy(&system);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_small_both_ways),   cmocka_unit_test(test_islands_both_ways),
      cmocka_unit_test(test_large_both_ways),   cmocka_unit_test(test_balances),
      cmocka_unit_test(test_walls_stand_still), cmocka_unit_test(test_failing_lists),
      cmocka_unit_test(test_refusals),          cmocka_unit_test(test_check),
      cmocka_unit_test(test_ids_are_distinct),  cmocka_unit_test(test_lists_grow),
      cmocka_unit_test(test_allocations),       cmocka_unit_test(test_state_goes_on),
      cmocka_unit_test(test_columns_stand),     cmocka_unit_test(test_many_rows),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
