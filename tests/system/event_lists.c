/* The event-driven method on contact lists, against the same systems with fixed contacts: thrown,
 * grazing and spinning bodies, seeded. Both have the same impacts and changes of mode, of the same
 * contacts at the same times, and the same states, whichever contact comes near first. A list that
 * names a contact too late, or a bound of speeds that is none, is found. The environment's
 * NSDAE_DROPS is how many (100), NSDAE_DROPS_FROM the first. */
#include "check.h"

#include <stdio.h>
#include <stdlib.h>

#include "as_list.h"
#include "drop.h"
#include "random.h"

enum { KEPT = 4000 };

/* Of a run; chaos makes 1e-13 of rounding some 1e-10 in it. */
static const double LENGTH = 0.7;

/* Over a run. Velocities before and after an impact, or modes. */
typedef struct event {
  double time, before, after, around; /* around: of an accumulation's end, which is foreseen */
  long id;
} event;

typedef struct run {
  int status, impacts, changes;
  event impact[KEPT], change[KEPT];
  double t, q[DROP_NQ], v[DROP_NV], accumulation_time;
  nsdae_stats stats;
  nsdae_error error;
} run;

static int look(const nsdae_record *r, nsdae_error *error, void *user)
{
  run *to = user;
  (void)error;
  for (int i = 0; i < r->impacts && to->impacts < KEPT; i++) {
    const nsdae_impact *p = &r->impact[i];
    double around = p->accumulation ? to->accumulation_time : 0;
    to->impact[to->impacts++] =
        (event){p->time, p->velocity_before, p->velocity_after, around, p->id};
  }
  for (int i = 0; i < r->changes && to->changes < KEPT; i++) {
    const nsdae_change *p = &r->change[i];
    to->change[to->changes++] = (event){p->time, p->mode_before, p->mode_after, 0, p->id};
  }
  to->t = r->time;
  return 0;
}

static void set_options(nsdae_sim_options *o)
{
  nsdae_sim_options_default(o);
  o->method = NSDAE_METHOD_EVENT;
  o->rtol = 1e-10;
  o->atol = 1e-12;
}

static void do_run(run *to, const drop *d, nsdae_system *system, double t_end)
{
  nsdae_sim_options o;
  nsdae_sim *sim;
  nsdae_record record = {0};
  *to = (run){0};
  set_options(&o);
  to->accumulation_time = o.accumulation_time;
  to->status = nsdae_sim_create(system, &o, &sim, &to->error);
  if (to->status < 0) return;
  nsdae_sim_observe(sim, look, to);
  to->status = nsdae_sim_init(sim, 0, d->q0, d->v0);
  if (to->status == NSDAE_OK) to->status = nsdae_sim_run(sim, t_end);
  to->error = *nsdae_sim_error(sim);
  nsdae_sim_get_record(sim, &record);
  nsdae_sim_get_stats(sim, &to->stats);
  nsdae_dims dims;
  nsdae_system_get_dims(system, &dims);
  if (record.q) memcpy(to->q, record.q, (size_t)dims.nq * sizeof *to->q);
  if (record.v) memcpy(to->v, record.v, (size_t)dims.nv * sizeof *to->v);
  nsdae_sim_destroy(&sim);
}

/* Whether every event of one has its own in the other: at the same time, of the same contact, with
 * the same values, in any order of what is at one time. */
static int same_events(const event *a, const event *b, int count, double tol, int show)
{
  static int taken[KEPT];
  memset(taken, 0, sizeof taken);
  for (int i = 0; i < count; i++) {
    int j = 0;
    while (j < count &&
           (taken[j] || a[i].id != b[j].id || fabs(a[i].time - b[j].time) > tol + a[i].around ||
            fabs(a[i].before - b[j].before) > tol || fabs(a[i].after - b[j].after) > tol))
      j++;
    if (j == count && show)
      print_message("  alone: t = %.15g contact %ld: %.12g -> %.12g\n", a[i].time, a[i].id,
                    a[i].before, a[i].after);
    if (j == count) return 0;
    taken[j] = 1;
  }
  return 1;
}

static double largest_difference(const double *a, const double *b, int n)
{
  double most = 0;
  for (int i = 0; i < n; i++) most = fmax(most, fabs(a[i] - b[i]));
  return most;
}

static long number_of(const char *name, long otherwise)
{
  const char *asked = getenv(name);
  return asked ? atol(asked) : otherwise;
}

/* ---- comparison */

static run fixed, listed;

static int same_runs(const run *a, const run *b, double tol)
{
  return a->status == b->status && a->impacts == b->impacts && a->changes == b->changes &&
         fabs(a->t - b->t) <= tol && largest_difference(a->q, b->q, DROP_NQ) <= tol &&
         largest_difference(a->v, b->v, DROP_NV) <= tol &&
         same_events(a->impact, b->impact, a->impacts, tol, 0) &&
         same_events(a->change, b->change, a->changes, tol, 0);
}

static void print_difference(const drop *d)
{
  print_message("drop %s: status %d %d, impacts %d %d, changes %d %d, t %.15g %.15g\n", d->name,
                fixed.status, listed.status, fixed.impacts, listed.impacts, fixed.changes,
                listed.changes, fixed.t, listed.t);
  if (fixed.status < 0) print_message("fixed: %s\n", fixed.error.text);
  if (listed.status < 0) print_message("listed: %s\n", listed.error.text);
  print_message("  fallback %ld %ld iterations %ld %ld\n", fixed.stats.fallback_steps,
                listed.stats.fallback_steps, fixed.stats.iterations, listed.stats.iterations);
  print_message("  q %.2g v %.2g\n", largest_difference(fixed.q, listed.q, DROP_NQ),
                largest_difference(fixed.v, listed.v, DROP_NV));
  if (fixed.impacts == listed.impacts) {
    same_events(fixed.impact, listed.impact, fixed.impacts, 1e-10, 1);
    same_events(listed.impact, fixed.impact, fixed.impacts, 1e-10, 1);
  }
  if (fixed.changes == listed.changes) {
    same_events(fixed.change, listed.change, fixed.changes, 1e-10, 1);
    same_events(listed.change, fixed.change, fixed.changes, 1e-10, 1);
  }
}

/* ---- bounds of the speed */

/* So fast that every contact has a slot from the start. */
static int very_fast(double t, const double *q, const double *v, double *speed, void *user)
{
  (void)t, (void)q, (void)v, (void)user;
  *speed = 1e6;
  return 0;
}

static drop drawn;

/* The two fastest bodies, each at its farthest point. */
static int fastest(double t, const double *q, const double *v, double *speed, void *user)
{
  double most = 0, second = 0, arm = 0;
  (void)t, (void)q, (void)user;
  for (int p = 0; p < drawn.points; p++)
    arm = fmax(arm, hypot(hypot(drawn.point[p][0], drawn.point[p][1]), drawn.point[p][2]));
  for (int b = 0; b < drawn.bodies; b++) {
    const double *u = v + 3 * b;
    double spin = drawn.space ? sqrt(v[3] * v[3] + v[4] * v[4] + v[5] * v[5]) : fabs(u[2]);
    double s = sqrt(u[0] * u[0] + u[1] * u[1] + (drawn.space ? u[2] * u[2] : 0)) + spin * arm;
    second = fmax(second, fmin(s, most));
    most = fmax(s, most);
  }
  *speed = most + second;
  return 0;
}

/* By list with that bound; NULL: estimated. */
static void run_listed(nsdae_system *system, nsdae_contact_speed_fn bound, double length)
{
  static const int three[DROP_THROWN] = {3, 3, 3, 3, 3, 3, 3, 3};
  as_list *copy = as_list_create(system, drawn.bodies > 1 ? drawn.bodies : 0, three, three);
  assert_non_null(copy);
  if (bound) nsdae_system_set_contact_speed(as_list_system(copy), bound);
  do_run(&listed, &drawn, as_list_system(copy), length);
  as_list_destroy(copy);
}

/* Whether both are the same. */
static int run_one(unsigned long seed, nsdae_contact_speed_fn bound)
{
  (seed % 4 == 3 ? drop_throw : drop_make)(&drawn, seed);
  nsdae_system *system = drop_system(&drawn);
  do_run(&fixed, &drawn, system, LENGTH);
  run_listed(system, bound, LENGTH);
  nsdae_system_destroy(&system);
  int same = same_runs(&fixed, &listed, 1e-10);
  if (!same) print_difference(&drawn);
  return same;
}

/* The quick form has other drops for each bound. */
static void run_family(nsdae_contact_speed_fn bound)
{
  static long other;
  const long stride = 2 * test_share() - 1;
  long many = number_of("NSDAE_DROPS", 100), from = number_of("NSDAE_DROPS_FROM", 0), differ = 0;
  for (long i = from + other % stride; i < from + many; i += stride)
    differ += !run_one((unsigned long)i, bound);
  other += 2;
  print_message("one in %ld of %ld drops from %ld: %ld differ\n", stride, many, from, differ);
  assert_int_equal(differ, 0);
}

/* Slots in the order of the numbers: the same bits. */
static void test_same_order(void **state)
{
  (void)state;
  run_family(very_fast);
}

static void test_bounded(void **state)
{
  (void)state;
  run_family(fastest);
}

static void test_estimated(void **state)
{
  (void)state;
  run_family(NULL);
}

/* A bound that is none: the run fails with the id of a contact that is faster, or misses nothing.
 */
static double part_of_speed;

static int too_slow(double t, const double *q, const double *v, double *speed, void *user)
{
  fastest(t, q, v, speed, user);
  *speed *= part_of_speed;
  return 0;
}

static void test_too_slow(void **state)
{
  (void)state;
  int named = 0;
  for (unsigned long seed = 0; seed < 40; seed++) {
    drop_make(&drawn, seed);
    part_of_speed = seed % 2 ? 0.2 : 0.01;
    nsdae_system *system = drop_system(&drawn);
    do_run(&fixed, &drawn, system, 0.5);
    run_listed(system, too_slow, 0.5);
    nsdae_system_destroy(&system);
    if (listed.status >= 0) {
      double most = 1e-8 * fmax(1, drawn.size);
      assert_true(listed.stats.worst_penetration <= most);
      continue;
    }
    if (listed.status == fixed.status) continue;
    assert_int_equal(listed.status, NSDAE_E_CALLBACK);
    assert_non_null(strstr(listed.error.text, "contact of id "));
    named++;
  }
  assert_true(named > 20);
}

static nsdae_sim *start(nsdae_system *system)
{
  nsdae_sim_options o;
  nsdae_sim *sim;
  set_options(&o);
  assert_int_equal(nsdae_sim_create(system, &o, &sim, NULL), NSDAE_OK);
  assert_int_equal(nsdae_sim_init(sim, 0, drawn.q0, drawn.v0), NSDAE_OK);
  return sim;
}

/* A contact that is not listed until it is deep: the run goes on without it, and fails with its id
 * as soon as it is listed. */
static void test_hidden(void **state)
{
  (void)state;
  int named = 0;
  for (unsigned long seed = 0; seed < 40; seed++) {
    drop_make(&drawn, seed);
    nsdae_system *system = drop_system(&drawn);
    as_list *copy = as_list_create(system, 0, NULL, NULL);
    do_run(&fixed, &drawn, system, 0.5);
    if (fixed.impacts > 0 && drawn.bodies == 1) {
      long id = fixed.impact[0].id;
      char called[40];
      snprintf(called, sizeof called, "contact of id %ld ", id);
      nsdae_sim *sim = start(as_list_system(copy));
      as_list_hide(copy, (int)id);
      int status = nsdae_sim_run(sim, fixed.impact[0].time + 0.01);
      as_list_hide(copy, -1);
      if (status == NSDAE_OK) status = nsdae_sim_run(sim, fixed.impact[0].time + 0.03);
      if (status < 0) assert_int_equal(status, NSDAE_E_CALLBACK);
      if (status < 0) assert_non_null(strstr(nsdae_sim_error(sim)->text, called));
      named += status < 0;
      nsdae_sim_destroy(&sim);
    }
    as_list_destroy(copy);
    nsdae_system_destroy(&system);
  }
  assert_true(named > 15);
}

/* ---- features that follow each other */

static int point_mass(double t, const double *q, double *M, void *user)
{
  (void)t, (void)q, (void)user;
  M[0] = M[3] = 1;
  return 0;
}

static int weight(double t, const double *q, const double *v, double *F, void *user)
{
  (void)t, (void)q, (void)v, (void)user;
  F[1] = -9.81;
  return 0;
}

/* The ground is in pieces of length 1, each with its own id; only the one below is listed. */
static int pieces(double t, const double *q, const double *v, double reach,
                  nsdae_contact_list *list, void *user)
{
  const double *mu = user;
  nsdae_contact c = {.id = (long)floor(q[0]), .block = {0, -1}, .gap = q[1], .mu = *mu};
  (void)t, (void)v;
  c.direction[0][0][1] = c.direction[0][1][0] = 1;
  return c.gap <= reach && nsdae_contact_add(list, &c) < 0 ? -1 : 0;
}

/* A point slides from piece to piece: x = 0.5 + 3 t - mu g t^2 / 2, y = 0; at each border one
 * contact opens and the next one closes, without an impact. */
static void test_pieces(void **state)
{
  (void)state;
  for (int i = 0; i < 3; i++) {
    double mu = 0.05 * i, x = 3.2;
    const nsdae_dims dims = {.nq = 2, .nt = 1};
    static const int two = 2;
    nsdae_system *s;
    assert_int_equal(nsdae_system_create(&dims, &s, NULL), NSDAE_OK);
    nsdae_system_set_user(s, &mu);
    nsdae_system_set_blocks(s, 1, &two, &two);
    nsdae_system_set_mass_blocks(s, point_mass);
    nsdae_system_set_force(s, weight);
    nsdae_system_set_contacts(s, pieces);
    memset(&drawn, 0, sizeof drawn);
    drawn.q0[0] = 0.5;
    drawn.v0[0] = 3;
    double a = mu * 9.81, t_end = a > 0 ? (3 - sqrt(9 - 2 * a * (x - 0.5))) / a : (x - 0.5) / 3;
    do_run(&listed, &drawn, s, t_end);
    if (listed.status < 0) print_message("%s\n", listed.error.text);
    assert_int_equal(listed.status, NSDAE_OK);
    assert_near(listed.q[0], x, 1e-9);
    assert_near(listed.q[1], 0, 1e-12);
    assert_int_equal(listed.impacts, 0);
    assert_int_equal(listed.changes, 6);
    for (int border = 1; border <= 3; border++) {
      double way = border - 0.5, t = a > 0 ? (3 - sqrt(9 - 2 * a * way)) / a : way / 3;
      assert_near(listed.change[2 * border - 2].time, t, 1e-8);
      assert_near(listed.change[2 * border - 1].time, t, 1e-8);
    }
    nsdae_system_destroy(&s);
  }
}

/* ---- slots that are free */

enum { POINTS = 3 };

static int points_mass(double t, const double *q, double *M, void *user)
{
  (void)t, (void)q, (void)user;
  for (int i = 0; i < POINTS; i++)
    for (int j = 0; j < 3; j++) M[9 * i + 4 * j] = 1;
  return 0;
}

static int points_weight(double t, const double *q, const double *v, double *F, void *user)
{
  (void)t, (void)q, (void)v, (void)user;
  for (int i = 0; i < POINTS; i++) F[3 * i + 2] = -9.81;
  return 0;
}

static int floor_below(double t, const double *q, const double *v, double reach,
                       nsdae_contact_list *list, void *user)
{
  (void)t, (void)v, (void)user;
  for (int i = 0; i < POINTS; i++) {
    nsdae_contact c = {.id = i, .block = {i, -1}, .gap = q[3 * i + 2], .mu = 0.3, .e_n = i == 2};
    c.direction[0][0][2] = c.direction[0][1][0] = c.direction[0][2][1] = 1;
    if (c.gap <= reach && nsdae_contact_add(list, &c) < 0) return -1;
  }
  return 0;
}

/* Two points slide by v / (2 mu g) and stop at v / (mu g) = 0.34 s, as a third one bounces at 0.143
 * s alone. A second simulation goes on at 0.2 s from the state block, which holds the directions of
 * the slides: with the same bits. */
static void test_state_of_slides(void **state)
{
  (void)state;
  static const int sizes[POINTS] = {3, 3, 3};
  static const double q0[3 * POINTS] = {0, 0, 0, 5, 0, 0, 9, 0, 0.1},
                             v0[3 * POINTS] = {0.6, -0.8, 0, 0.8, 0.6, 0, 0, 0, 0};
  const nsdae_dims dims = {.nq = 3 * POINTS, .nt = 2};
  nsdae_system *s;
  nsdae_sim *first, *second;
  nsdae_sim_options o;
  nsdae_record r;
  double q[3 * POINTS];
  size_t size;
  assert_int_equal(nsdae_system_create(&dims, &s, NULL), NSDAE_OK);
  nsdae_system_set_blocks(s, POINTS, sizes, sizes);
  nsdae_system_set_mass_blocks(s, points_mass);
  nsdae_system_set_force(s, points_weight);
  nsdae_system_set_contacts(s, floor_below);
  set_options(&o);
  assert_int_equal(nsdae_sim_create(s, &o, &first, NULL), NSDAE_OK);
  assert_int_equal(nsdae_sim_create(s, &o, &second, NULL), NSDAE_OK);
  assert_int_equal(nsdae_sim_init(first, 0, q0, v0), NSDAE_OK);
  assert_int_equal(nsdae_sim_run(first, 0.2), NSDAE_OK);
  assert_int_equal(nsdae_sim_state_size(first, &size), NSDAE_OK);
  void *block = malloc(size);
  assert_non_null(block);
  assert_int_equal(nsdae_sim_get_state(first, block, size), NSDAE_OK);
  assert_int_equal(nsdae_sim_set_state(second, block, size), NSDAE_OK);
  assert_int_equal(nsdae_sim_run(first, 0.4), NSDAE_OK);
  assert_int_equal(nsdae_sim_run(second, 0.4), NSDAE_OK);
  nsdae_sim_get_record(first, &r);
  memcpy(q, r.q, sizeof q);
  nsdae_sim_get_record(second, &r);
  assert_memory_equal(r.q, q, sizeof q);
  double way = 1 / (2 * 0.3 * 9.81);
  for (int i = 0; i < 2; i++)
    for (int j = 0; j < 3; j++) {
      /* 1e-10 of rtol, and no slower than 1e-10 when it stops */
      assert_near(r.q[3 * i + j], q0[3 * i + j] + way * v0[3 * i + j], 1e-9);
      assert_near(r.v[3 * i + j], 0, 1e-9);
    }
  free(block);
  nsdae_sim_destroy(&first);
  nsdae_sim_destroy(&second);
  nsdae_system_destroy(&s);
}

/* ---- an id of two pairs of bodies */

static int two_masses(double t, const double *q, double *M, void *user)
{
  point_mass(t, q, M, user);
  return point_mass(t, q, M + 4, user);
}

static int two_weights(double t, const double *q, const double *v, double *F, void *user)
{
  weight(t, q, v, F, user);
  return weight(t, q, v, F + 2, user);
}

/* Until the time of the user the body 0 has the id 5, then the body 1. */
static int one_id(double t, const double *q, const double *v, double reach,
                  nsdae_contact_list *list, void *user)
{
  const double *until = user;
  int body = t > *until;
  nsdae_contact c = {.id = 5, .block = {body, -1}, .gap = q[2 * body + 1], .mu = 0.1};
  (void)v;
  c.direction[0][0][1] = c.direction[0][1][0] = 1;
  return c.gap <= reach && nsdae_contact_add(list, &c) < 0 ? -1 : 0;
}

static void test_moved_id(void **state)
{
  (void)state;
  /* between steps, and within one */
  static const double times[] = {0.02, 0.0213};
  for (int n = 0; n < 4; n++) {
    double until = times[n / 2];
    const nsdae_dims dims = {.nq = 4, .nt = 1};
    static const int two[2] = {2, 2};
    static const double q0[4] = {0, 0, 1, 0}, v0[4] = {0};
    nsdae_sim_options o;
    nsdae_system *s;
    nsdae_sim *sim;
    assert_int_equal(nsdae_system_create(&dims, &s, NULL), NSDAE_OK);
    nsdae_system_set_user(s, &until);
    nsdae_system_set_blocks(s, 2, two, two);
    nsdae_system_set_mass_blocks(s, two_masses);
    nsdae_system_set_force(s, two_weights);
    nsdae_system_set_contacts(s, one_id);
    nsdae_sim_options_default(&o);
    o.method = n % 2 ? NSDAE_METHOD_PENALTY : NSDAE_METHOD_EVENT;
    assert_int_equal(nsdae_sim_create(s, &o, &sim, NULL), NSDAE_OK);
    assert_int_equal(nsdae_sim_init(sim, 0, q0, v0), NSDAE_OK);
    assert_int_equal(nsdae_sim_run(sim, 0.1), NSDAE_E_CALLBACK);
    const nsdae_error *error = nsdae_sim_error(sim);
    assert_int_equal(error->index, 5);
    assert_true(error->time > until && error->time < until + 0.01);
    assert_non_null(strstr(error->text, "the contact of id 5 is between blocks 1 and -1"));
    assert_non_null(strstr(error->text, "use another id"));
    nsdae_sim_destroy(&sim);
    nsdae_system_destroy(&s);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_same_order),      cmocka_unit_test(test_bounded),
      cmocka_unit_test(test_estimated),       cmocka_unit_test(test_too_slow),
      cmocka_unit_test(test_hidden),          cmocka_unit_test(test_pieces),
      cmocka_unit_test(test_state_of_slides), cmocka_unit_test(test_moved_id),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
