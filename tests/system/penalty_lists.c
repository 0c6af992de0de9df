/* Penalty on contact lists: against the same systems with fixed contacts, where a run stops and
 * goes on, with contacts that are not listed in time and laws that are not known at the start. */
#include "as_list.h"
#include "check.h"
#include "clearance_hinge.h"
#include "pendulum.h"
#include "random_system.h"
#include "twin.h"

enum { STEPS = 60, SEEDS = 60, WIDE = 64 };

static const int integrators[] = {NSDAE_INTEGRATOR_AUTO, NSDAE_INTEGRATOR_DOPRI5,
                                  NSDAE_INTEGRATOR_DOP853, NSDAE_INTEGRATOR_IDA};

static int has_integrator(int integrator)
{
  return integrator != NSDAE_INTEGRATOR_IDA || !strstr(nsdae_build_info(), "SUNDIALS none");
}

/* A bound with which every contact is near: slots are in the order of the list. */
static int very_fast(double t, const double *q, const double *v, double *speed, void *user)
{
  (void)t, (void)q, (void)v, (void)user;
  *speed = 1e6;
  return 0;
}

typedef struct run {
  nsdae_system *fixed;
  as_list *list;
  nsdae_system *system; /* one of them */
  nsdae_sim *sim;
  nsdae_dims dims; /* of the fixed contacts */
  nsdae_record record;
  int status;
} run;

enum { FIXED, LISTED, IN_ORDER };

/* fixed becomes the run's. */
static void begin(run *r, nsdae_system *fixed, int how, const nsdae_sim_options *options,
                  const double *q0, const double *v0)
{
  *r = (run){.fixed = fixed, .system = fixed};
  nsdae_system_get_dims(fixed, &r->dims);
  r->list = how == FIXED ? NULL : as_list_create(fixed, 0, NULL, NULL);
  if (r->list) r->system = as_list_system(r->list);
  if (how == IN_ORDER) nsdae_system_set_contact_speed(r->system, very_fast);
  nsdae_error error = {0};
  r->status = nsdae_sim_create(r->system, options, &r->sim, &error);
  if (r->status < 0) print_message("%s\n", error.text);
  if (r->status == NSDAE_OK && q0) r->status = nsdae_sim_init(r->sim, 0, q0, v0);
}

static void step(run *r)
{
  r->status = nsdae_sim_step(r->sim);
  nsdae_sim_get_record(r->sim, &r->record);
}

static void end(run *r)
{
  nsdae_sim_destroy(&r->sim);
  as_list_destroy(r->list);
  nsdae_system_destroy(&r->fixed);
}

static nsdae_sim_options penalty_by(int integrator)
{
  nsdae_sim_options o;
  nsdae_sim_options_default(&o);
  o.method = NSDAE_METHOD_PENALTY;
  o.integrator = integrator;
  return o;
}

/* ---- against fixed contacts */

static double difference(int count, const double *a, const double *b)
{
  double most = 0;
  for (int i = 0; i < count; i++) most = fmax(most, fabs(a[i] - b[i]) / (1 + fabs(a[i])));
  return most;
}

/* Of what contact i did: 0 if it is not in the list. */
static double of_contact(const run *fixed, const run *list, int i)
{
  const nsdae_record *r = &fixed->record;
  const nsdae_contact_set *s = &list->record.contacts;
  const double none[3] = {0};
  int nt = fixed->dims.nt, at = 0;
  while (at < s->count && s->id[at] != i) at++;
  int is_there = at < s->count;
  if (is_there) assert_near(s->gap[at], r->gap[i], 1e-4);
  if (!is_there) assert_int_equal(r->mode[i], NSDAE_MODE_OPEN);
  double off = difference(1, r->normal_impulse + i, is_there ? s->normal_impulse + at : none);
  return fmax(off, difference(nt, r->tangential_impulse + i * nt,
                              is_there ? s->tangential_impulse + at * nt : none));
}

static double of_impacts(const nsdae_record *r, const nsdae_record *s)
{
  double most = 0;
  assert_int_equal(s->impacts, r->impacts);
  for (int i = 0; i < r->impacts; i++) {
    int at = 0;
    while (at < s->impacts && (s->impact[at].id != r->impact[i].contact ||
                               fabs(s->impact[at].time - r->impact[i].time) > 1e-5))
      at++;
    assert_true(at < s->impacts);
    most = fmax(most, difference(1, &r->impact[i].time, &s->impact[at].time));
    most = fmax(most, difference(1, &r->impact[i].peak_force, &s->impact[at].peak_force));
    most = fmax(most, difference(1, &r->impact[i].velocity_before, &s->impact[at].velocity_before));
  }
  return most;
}

static double of_step(const run *fixed, const run *list)
{
  const nsdae_record *r = &fixed->record, *s = &list->record;
  double off = fmax(difference(fixed->dims.nq, r->q, s->q), difference(fixed->dims.nv, r->v, s->v));
  off = fmax(off, difference(fixed->dims.m, r->multiplier, s->multiplier));
  off = fmax(off, difference(1, &r->dissipated, &s->dissipated));
  for (int i = 0; i < fixed->dims.k; i++) off = fmax(off, of_contact(fixed, list, i));
  return fmax(off, of_impacts(r, s));
}

/* Inside the last step, and the steps after it are those of before. */
static double between(const run *fixed, const run *list)
{
  double q[2][WIDE], v[2][WIDE], t = fixed->record.time - 0.3 * fixed->record.duration;
  assert_int_equal(nsdae_sim_interpolate(fixed->sim, t, q[0], v[0]), NSDAE_OK);
  assert_int_equal(nsdae_sim_interpolate(list->sim, t, q[1], v[1]), NSDAE_OK);
  return fmax(difference(fixed->dims.nq, q[0], q[1]), difference(fixed->dims.nv, v[0], v[1]));
}

/* The largest difference over a run; *impacts more. */
static double of_runs(run *fixed, run *list, int steps, int *impacts)
{
  double most = 0;
  if (fixed->status < 0) return 0;
  assert_int_equal(list->status, fixed->status);
  for (int i = 0; i < steps && fixed->status >= 0; i++) {
    step(fixed), step(list);
    assert_int_equal(list->status < 0, fixed->status < 0); /* warnings come as contacts are near */
    if (fixed->status >= 0) most = fmax(most, of_step(fixed, list));
    if (fixed->status >= 0 && i % 5 == 0) most = fmax(most, between(fixed, list));
    *impacts += fixed->record.impacts;
  }
  return most;
}

/* Of lists with frictional joints and of contacts of more than two blocks there is none. */
static int can_be_listed(const random_system *r)
{
  return r->dims.f == 0 && !r->by_blocks;
}

/* In the order of the fixed contacts the same bytes. In that in which they come near, sums have
 * other roundings, of which a first step after a restart makes 1e-7 of its length: within the
 * integrator's tolerance. */
static void test_random(void **state)
{
  (void)state;
  for (int i = 0; i < 4; i++)
    for (int how = LISTED; how <= IN_ORDER && has_integrator(integrators[i]); how++) {
      if (test_share() > 1 && (i + how) % 2) continue; /* each integrator one way */
      double most = 0;
      int impacts = 0, same = 0, all = 0;
      for (uint64_t seed = (uint64_t)i; seed < SEEDS; seed += (uint64_t)test_share()) {
        random_system a, b;
        run fixed, list;
        const nsdae_sim_options o = penalty_by(integrators[i]);
        random_system_draw(&a, seed, RANDOM_PLAIN);
        random_system_draw(&b, seed, RANDOM_PLAIN);
        if (!can_be_listed(&a)) continue;
        begin(&fixed, random_system_make(&a), FIXED, &o, a.q0, a.v0);
        begin(&list, random_system_make(&b), how, &o, b.q0, b.v0);
        double off = of_runs(&fixed, &list, STEPS, &impacts);
        most = fmax(most, off);
        same += off == 0;
        all++;
        end(&fixed), end(&list);
      }
      print_message("integrator %d: %d of %d with the same bytes, others off by %.1e, %d impacts\n",
                    integrators[i], same, all, most, impacts);
      assert_true(impacts > share_of(10) && all > 20 / test_share());
      assert_true(same >= all - share_of(3));
      assert_at_most(most, how == IN_ORDER ? 0 : 1e-5);
    }
}

static double of_model(const driver_model *m, int integrator, int steps, int *impacts)
{
  static double q[WIDE], v[WIDE];
  run fixed, list;
  nsdae_sim_options o = penalty_by(integrator);
  nsdae_system *system[2];
  if (m->dt > 0) o.dt = m->dt;
  nsdae_params_default(m->parameters, m->base);
  for (int i = 0; i < 2; i++) assert_int_equal(m->build(m->base, &system[i], NULL), NSDAE_OK);
  m->start(m->base, q, v);
  begin(&fixed, system[0], FIXED, &o, q, v);
  begin(&list, system[1], IN_ORDER, &o, q, v);
  double off = of_runs(&fixed, &list, steps, impacts);
  end(&fixed), end(&list);
  return off;
}

static void test_examples(void **state)
{
  (void)state;
  const driver_model *models[] = {&pendulum_model, &clearance_hinge_model};
  for (int i = 0; i < 4; i++)
    for (int j = 0; j < 2 && has_integrator(integrators[i]); j++) {
      int impacts = 0;
      double off = of_model(models[j], integrators[i], test_share() > 1 ? 100 : 300, &impacts);
      print_message("%s, integrator %d: off by %g, %d impacts\n", models[j]->name, integrators[i],
                    off, impacts);
      assert_true(off == 0);
    }
}

/* ---- a state put back */

static char *state_of(nsdae_sim *sim, size_t *size)
{
  assert_int_equal(nsdae_sim_state_size(sim, size), NSDAE_OK);
  char *block = malloc(*size);
  assert_non_null(block);
  assert_int_equal(nsdae_sim_get_state(sim, block, *size), NSDAE_OK);
  return block;
}

static void expect_same_state(nsdae_sim *a, nsdae_sim *b)
{
  size_t size, other;
  char *block = state_of(a, &size), *again = state_of(b, &other);
  assert_int_equal(other, size);
  assert_memory_equal(again, block, size);
  free(block), free(again);
}

/* A simulation of the same list that goes on from the state of this one, some steps later. */
static void go_on(run *a, const nsdae_sim_options *options, int steps)
{
  size_t size;
  run b = {.dims = a->dims};
  char *block = state_of(a->sim, &size);
  assert_int_equal(nsdae_sim_create(a->system, options, &b.sim, NULL), NSDAE_OK);
  assert_int_equal(nsdae_sim_set_state(b.sim, block, size), NSDAE_OK);
  expect_same_state(a->sim, b.sim);
  for (int i = 0; i < steps && a->status >= 0; i++) {
    step(a), step(&b);
    assert_int_equal(b.status < 0, a->status < 0);
    if (a->status >= 0) expect_same_state(a->sim, b.sim);
  }
  free(block);
  nsdae_sim_destroy(&b.sim);
}

static void test_go_on(void **state)
{
  (void)state;
  for (int i = 0; i < 4; i++)
    for (uint64_t seed = (uint64_t)i; seed < SEEDS && has_integrator(integrators[i]);
         seed += (uint64_t)test_share()) {
      random_system data;
      run a;
      const nsdae_sim_options o = penalty_by(integrators[i]);
      random_system_draw(&data, seed, RANDOM_PLAIN);
      if (!can_be_listed(&data)) continue;
      begin(&a, random_system_make(&data), LISTED, &o, data.q0, data.v0);
      for (int part = 0; part < 6 && a.status >= 0; part++) go_on(&a, &o, 5);
      end(&a);
    }
}

/* ---- room: a list of many contacts, with ids of their own */

/* The list of a twin; contact i has the id id_of_first - 3 i. */
static void test_twins(void **state)
{
  static const twin_kind kinds[] = {
      {.blocks = 4,
       .largest = 3,
       .joined = 1,
       .k = 4,
       .nt = 1,
       .friction = 0.4,
       .restitution = 0.8},
      {.blocks = 5, .largest = 7, .joined = 1, .k = 5, .nt = 2, .friction = 0.2},
      {.blocks = 20,
       .largest = 3,
       .joined = 1,
       .k = 20,
       .nt = 1,
       .friction = 0.2,
       .restitution = 1}};
  (void)state;
  for (int kind = 0; kind < 3; kind++)
    for (uint64_t seed = 0; seed < 4; seed++) {
      static twin t;
      run fixed = {0}, list = {0};
      double most = 0;
      int impacts = 0;
      nsdae_sim_options o = penalty_by(NSDAE_INTEGRATOR_DOPRI5);
      o.dt = 2e-3, o.rank_tol = 1e-12, o.start_tol = 1;
      twin_draw(&t, 500 + 100 * (uint64_t)kind + seed, &kinds[kind]);
      begin(&fixed, twin_numbered(&t, TWIN_BY_ROWS), FIXED, &o, t.q0, t.v0);
      begin(&list, twin_blocks(&t), FIXED, &o, t.q0, t.v0);
      for (int i = 0; i < 30 && fixed.status >= 0; i++) {
        step(&fixed), step(&list);
        assert_int_equal(list.status < 0, fixed.status < 0);
        if (fixed.status < 0) break;
        most = fmax(most, difference(t.nv, fixed.record.q, list.record.q));
        assert_int_equal(list.record.impacts, fixed.record.impacts);
        for (int j = 0; j < list.record.impacts; j++) {
          long place = t.id_of_first - list.record.impact[j].id;
          assert_true(place % 3 == 0 && place / 3 >= 0 && place / 3 < t.k);
        }
        impacts += fixed.record.impacts;
      }
      /* there the room is that of the slots in use, here it grew from eight */
      if (list.status >= 0) go_on(&list, &o, 10);
      print_message("twin %d %d: off by %.1e, %d impacts\n", kind, (int)seed, most, impacts);
      assert_at_most(most, 1e-6);
      end(&fixed), end(&list);
    }
}

/* ---- what is not known at the start */

static int unit_mass(double t, const double *q, double *M, int ldm, void *user)
{
  (void)t, (void)q, (void)ldm, (void)user;
  M[0] = 1;
  return 0;
}

static int no_force(double t, const double *q, const double *v, double *F, void *user)
{
  (void)t, (void)q, (void)v, (void)F, (void)user;
  return 0;
}

static int height(double t, const double *q, double *g, void *user)
{
  (void)t, (void)user;
  g[0] = q[0];
  return 0;
}

static int upwards(double t, const double *q, double *W, int ldw, void *user)
{
  (void)t, (void)q, (void)ldw, (void)user;
  W[0] = 1;
  return 0;
}

/* A ball that flies with speed 1 to the floor, ten steps away: farther than the first step looks.
 */
static void begin_ball(run *r, int law, double e_n)
{
  const nsdae_dims dims = {.nq = 1, .k = 1};
  const double q0 = 0.01, v0 = -1;
  nsdae_sim_options o = penalty_by(NSDAE_INTEGRATOR_DOPRI5);
  nsdae_system *system;
  o.dt = 1e-3;
  o.penalty_law = law;
  assert_int_equal(nsdae_system_create(&dims, &system, NULL), NSDAE_OK);
  nsdae_system_set_mass(system, unit_mass);
  nsdae_system_set_force(system, no_force);
  nsdae_system_set_gap(system, height);
  nsdae_system_set_gap_normal(system, upwards);
  nsdae_system_set_contact(system, 0, 0, e_n, 0);
  begin(r, system, LISTED, &o, &q0, &v0);
  assert_int_equal(r->status, NSDAE_OK);
}

static void step_to(run *r, double height_below)
{
  r->status = NSDAE_OK;
  for (int i = 0; i < 100 && (r->status == NSDAE_OK || r->status == NSDAE_EVENT); i++) {
    step(r);
    if (r->record.q[0] < height_below) break;
  }
}

static void test_not_in_time(void **state)
{
  run r;
  (void)state;
  begin_ball(&r, NSDAE_PENALTY_HERTZ, 1);
  as_list_hide(r.list, 0);
  step_to(&r, -0.0035);
  assert_int_equal(r.status, NSDAE_OK);
  as_list_hide(r.list, -1);
  step(&r);
  const nsdae_error *error = nsdae_sim_error(r.sim);
  assert_int_equal(r.status, NSDAE_E_CALLBACK);
  assert_non_null(strstr(error->text, "contact of id 0"));
  assert_string_equal(error->argument, "contacts");
  assert_int_equal(error->index, 0);
  end(&r);
}

/* A run that is started again while a contact is deep is as the first one. */
static void test_again(void **state)
{
  const double q0 = 0.01, v0 = -1;
  (void)state;
  run a, b;
  begin_ball(&a, NSDAE_PENALTY_HERTZ, 1);
  begin_ball(&b, NSDAE_PENALTY_HERTZ, 1);
  step_to(&a, -1e-5);
  assert_true(a.record.q[0] < -1e-5);
  assert_int_equal(nsdae_sim_init(a.sim, 0, &q0, &v0), NSDAE_OK);
  for (int i = 0; i < 40; i++) {
    step(&a), step(&b);
    assert_int_equal(a.status, b.status);
    expect_same_state(a.sim, b.sim);
  }
  end(&a), end(&b);
}

/* The warning comes with the impact, once. */
static void test_restitution(void **state)
{
  run r;
  nsdae_stats stats;
  (void)state;
  begin_ball(&r, NSDAE_PENALTY_HUNT_CROSSLEY, 0);
  step_to(&r, -1);
  const nsdae_error *error = nsdae_sim_error(r.sim);
  nsdae_sim_get_stats(r.sim, &stats);
  assert_int_equal(r.status, NSDAE_WARN_RESTITUTION);
  assert_int_equal(stats.warnings, 32);
  assert_near(r.record.time, 0.0105, 0.00051);
  assert_non_null(strstr(error->text, "contact of id 0 has e_N = 0, "));
  assert_int_equal(error->index, 0);
  step_to(&r, -1);
  assert_int_equal(r.status, NSDAE_OK);
  nsdae_sim_get_stats(r.sim, &stats);
  assert_int_equal(stats.warnings, 32);
  assert_true(r.record.v[0] > 0.4);
  end(&r);
}

static void test_flores(void **state)
{
  run r;
  (void)state;
  begin_ball(&r, NSDAE_PENALTY_FLORES, 0);
  step_to(&r, -1);
  const nsdae_error *error = nsdae_sim_error(r.sim);
  assert_int_equal(r.status, NSDAE_E_ARGUMENT);
  assert_non_null(strstr(error->text, "e_n = 0"));
  assert_non_null(strstr(error->text, "contact of id 0"));
  assert_true(r.record.q[0] > 0);
  end(&r);
}

/* ---- features */

/* A ball that rolls over tiles, a contact of each: its id is the tile's, and one is listed. */
static int tiles(double t, const double *q, const double *v, double reach, nsdae_contact_list *list,
                 void *user)
{
  const int *many = user;
  nsdae_contact c = {.id = *many ? (long)floor(q[0] / 0.01) : 0,
                     .block = {0, -1},
                     .gap = q[1] + 0.002 * sin(20 * q[0]),
                     .mu = 0.1,
                     .e_n = 1};
  double slope = 0.04 * cos(20 * q[0]), size = sqrt(1 + slope * slope);
  (void)t, (void)v;
  if (c.gap > reach) return 0;
  c.direction[0][0][0] = slope, c.direction[0][0][1] = 1;
  c.direction[0][1][0] = 1 / size, c.direction[0][1][1] = -slope / size;
  nsdae_contact_add(list, &c);
  return 0;
}

static int two_masses(double t, const double *q, double *M, void *user)
{
  (void)t, (void)q, (void)user;
  M[0] = M[3] = 1;
  return 0;
}

static int weight(double t, const double *q, const double *v, double *F, void *user)
{
  (void)t, (void)q, (void)v, (void)user;
  F[1] = -10;
  return 0;
}

/* A simulation takes its own state, whatever its option contacts_max is. */
static void put_back(nsdae_sim *sim)
{
  size_t size;
  char *block = state_of(sim, &size);
  int status = nsdae_sim_set_state(sim, block, size);
  if (status < 0) print_message("%s\n", nsdae_sim_error(sim)->text);
  assert_int_equal(status, NSDAE_OK);
  free(block);
}

static void roll(int many, int integrator, double *q, int *impacts, int *ids)
{
  const nsdae_dims dims = {.nq = 2, .nt = 1};
  const double q0[] = {0.0003, 1e-5}, v0[] = {0.5, 0};
  const int two = 2;
  nsdae_sim_options o = penalty_by(integrator);
  nsdae_system *system;
  nsdae_sim *sim;
  nsdae_record r;
  long last = -1;
  o.dt = 2e-3, o.rtol = 1e-9, o.atol = 1e-12;
  o.penalty_law = NSDAE_PENALTY_HERTZ;
  o.penalty_stiffness = 1e7;
  o.contacts_max = 1; /* a step has two */
  assert_int_equal(nsdae_system_create(&dims, &system, NULL), NSDAE_OK);
  nsdae_system_set_user(system, &many);
  nsdae_system_set_blocks(system, 1, &two, &two);
  nsdae_system_set_mass_blocks(system, two_masses);
  nsdae_system_set_force(system, weight);
  nsdae_system_set_contacts(system, tiles);
  assert_int_equal(nsdae_sim_create(system, &o, &sim, NULL), NSDAE_OK);
  assert_int_equal(nsdae_sim_init(sim, 0, q0, v0), NSDAE_OK);
  *impacts = *ids = 0;
  for (int i = 0; i < 100; i++) {
    int status = nsdae_sim_step(sim);
    if (status < 0) print_message("step %d: %s\n", i, nsdae_sim_error(sim)->text);
    assert_true(status >= 0);
    nsdae_sim_get_record(sim, &r);
    put_back(sim);
    *impacts += r.impacts;
    for (int j = 0; j < r.contacts.count; j++) *ids += r.contacts.id[j] > last;
    for (int j = 0; j < r.contacts.count; j++)
      if (r.contacts.id[j] > last) last = r.contacts.id[j];
  }
  assert_int_equal(nsdae_sim_set_contact(sim, 0, 0.1, 1, 0), NSDAE_E_ARGUMENT); /* none is fixed */
  assert_string_equal(nsdae_sim_error(sim)->argument, "i");
  memcpy(q, r.q, 2 * sizeof *q);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
}

/* The force of Hertz does not depend on how the contact began: the same motion as on one contact,
 * to the integrator's tolerance over some thousand steps. */
static void test_features(void **state)
{
  (void)state;
  for (int i = 0; i < 4; i++) {
    double one[2], many[2];
    int impacts, ids;
    if (!has_integrator(integrators[i])) continue;
    roll(0, integrators[i], one, &impacts, &ids);
    roll(1, integrators[i], many, &impacts, &ids);
    print_message("integrator %d: %d tiles, %d impacts, off by %.1e, %.1e\n", integrators[i], ids,
                  impacts, many[0] - one[0], many[1] - one[1]);
    assert_true(ids > 5);
    assert_near(many[0], one[0], 1e-6);
    assert_near(many[1], one[1], 1e-6);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_random),      cmocka_unit_test(test_examples),
      cmocka_unit_test(test_go_on),       cmocka_unit_test(test_twins),
      cmocka_unit_test(test_not_in_time), cmocka_unit_test(test_restitution),
      cmocka_unit_test(test_flores),      cmocka_unit_test(test_features),
      cmocka_unit_test(test_again),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
