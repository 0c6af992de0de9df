/* Event on contact lists: the same systems with fixed contacts, which are tracked in slots then,
 * have the same motion and the same events; growth and a state put back change no bit. */
#include "check.h"

#include <math.h>
#include <stdlib.h>

#include "as_list.h"
#include "arch.h"
#include "bouncing_ball.h"
#include "clearance_hinge.h"
#include "column.h"
#include "crank_slider.h"
#include "dominoes.h"
#include "falling_rod.h"
#include "heap.h"
#include "incline.h"
#include "newtons_cradle.h"
#include "random_system.h"
#include "rolling_ball.h"
#include "shaken_ball.h"
#include "woodpecker.h"

/* Of the largest number that is compared, for the order of contacts may differ; and if the adapter
 * differences what it lists, without the steps that event tunes. */
static const double NEAR = 1e-10, DIFFERENCED = 1e-6;

enum { SIZE = 2048, STEPS = 120, SEEDS = 60 };

typedef struct scene {
  nsdae_system *system; /* with fixed contacts */
  nsdae_sim_options options;
  double q[SIZE], v[SIZE];
} scene;

typedef struct run {
  nsdae_sim *sim;
  nsdae_dims dims;
  nsdae_record record;
  nsdae_error error;
  int status;
} run;

static void begin(run *r, const nsdae_system *system, const scene *at)
{
  *r = (run){0};
  r->status = nsdae_sim_create(system, &at->options, &r->sim, &r->error);
  if (r->status == NSDAE_OK) r->status = nsdae_sim_init(r->sim, 0, at->q, at->v);
  if (!r->sim) return;
  nsdae_sim_get_dims(r->sim, &r->dims);
  nsdae_sim_get_record(r->sim, &r->record);
}

static void step(run *r)
{
  r->status = nsdae_sim_step(r->sim);
  nsdae_sim_get_record(r->sim, &r->record);
}

/* The larger of `most` and the largest difference in parts of the largest number and one. */
static double apart(const double *a, const double *b, int n, double most)
{
  double size = 1, off = 0;
  for (int i = 0; i < n; i++) {
    size = fmax(size, fabs(a[i]));
    off = fmax(off, fabs(a[i] - b[i]));
  }
  return fmax(most, off / size);
}

/* The place of a contact in the list; -1: it is not there. */
static int place_of(const nsdae_record *list, long id)
{
  for (int a = 0; a < list->contacts.count; a++)
    if (list->contacts.id[a] == id) return a;
  return -1;
}

/* Impulses and modes of all contacts; what is not in the list has none. */
static double compare_contacts(const run *fixed, const run *list)
{
  const nsdae_record *r = &fixed->record, *s = &list->record;
  int nt = fixed->dims.nt;
  double most = 0;
  for (int i = 0; i < fixed->dims.k; i++) {
    static const double none[2];
    int a = place_of(s, i);
    double normal = a < 0 ? 0 : s->contacts.normal_impulse[a];
    most = apart(r->normal_impulse + i, &normal, 1, most);
    most = apart(r->tangential_impulse + i * nt,
                 a < 0 ? none : s->contacts.tangential_impulse + a * nt, nt, most);
    assert_int_equal(a < 0 ? NSDAE_MODE_OPEN : s->contacts.mode[a], r->mode[i]);
    if (a >= 0) most = apart(r->gap + i, s->contacts.gap + a, 1, most);
  }
  return most;
}

static double off_by(const nsdae_impact *p, const nsdae_impact *o)
{
  return fabs(o->time - p->time) + fabs(o->velocity_before - p->velocity_before);
}

/* Those of one instant are in the order of the slots: the nearest of the contact. */
static double compare_impact(const nsdae_impact *p, const nsdae_record *list, double most)
{
  const nsdae_impact *o = NULL;
  for (int j = 0; j < list->impacts; j++) {
    const nsdae_impact *other = &list->impact[j];
    if (other->id == p->contact && (!o || off_by(p, other) < off_by(p, o))) o = other;
  }
  assert_non_null(o);
  assert_int_equal(list->contacts.id[o->contact], p->contact);
  assert_int_equal(o->accumulation, p->accumulation);
  most = apart(&p->time, &o->time, 1, most);
  most = apart(&p->normal_impulse, &o->normal_impulse, 1, most);
  return apart(&p->velocity_before, &o->velocity_before, 1, most);
}

static double compare_change(const nsdae_change *p, const nsdae_record *list, double most)
{
  const nsdae_change *o = NULL;
  for (int j = 0; j < list->changes; j++) {
    const nsdae_change *other = &list->change[j];
    if (other->id == p->id && other->mode_before == p->mode_before &&
        (!o || fabs(other->time - p->time) < fabs(o->time - p->time)))
      o = other;
  }
  assert_non_null(o);
  assert_int_equal(o->mode_after, p->mode_after);
  return apart(&p->time, &o->time, 1, most);
}

static double compare(const run *fixed, const run *list)
{
  const nsdae_record *r = &fixed->record, *s = &list->record;
  double most = apart(r->q, s->q, fixed->dims.nq, 0);
  most = apart(r->v, s->v, fixed->dims.nv, most);
  most = apart(r->multiplier, s->multiplier, fixed->dims.m, most);
  most = apart(&r->time, &s->time, 1, most);
  most = apart(&r->dissipated, &s->dissipated, 1, most);
  assert_int_equal(s->impacts, r->impacts);
  assert_int_equal(s->changes, r->changes);
  for (int i = 0; i < r->impacts; i++) most = compare_impact(&r->impact[i], s, most);
  for (int i = 0; i < r->changes; i++) most = compare_change(&r->change[i], s, most);
  return fmax(most, compare_contacts(fixed, list));
}

static long fallbacks; /* of the list that was followed last */

/* The largest difference in a number of steps; counts impacts and changes. */
static double follow(const char *name, const scene *s, int steps, double near, int *events)
{
  run a, b;
  double most = 0;
  nsdae_dims d;
  nsdae_system_get_dims(s->system, &d);
  as_list *copy = as_list_create(s->system, 1, &d.nq, &d.nv);
  assert_non_null(copy);
  begin(&a, s->system, s);
  begin(&b, as_list_system(copy), s);
  if (a.status != b.status)
    print_message("%s: %d and %d: %s\n", name, a.status, b.status,
                  b.sim ? nsdae_sim_error(b.sim)->text : b.error.text);
  if (a.status == NSDAE_E_DERIVATIVE) /* of fixed contacts alone it is looked for */
    a.status = b.status = NSDAE_E_DERIVATIVE;
  assert_int_equal(a.status, b.status);
  for (int i = 0; i < steps && a.status >= 0; i++) {
    step(&a), step(&b);
    if (a.status != b.status)
      print_message("%s, step %d: %d and %d: %s\n", name, i, a.status, b.status,
                    nsdae_sim_error(b.sim)->text);
    assert_int_equal(b.status, a.status);
    if (a.status < 0) break;
    most = fmax(most, compare(&a, &b));
    *events += a.record.impacts + a.record.changes;
    if (!(most <= near)) print_message("%s, step %d: %.3g apart\n", name, i, most);
    assert_true(most <= near);
  }
  nsdae_stats of[2] = {{0}};
  if (a.sim) nsdae_sim_get_stats(a.sim, &of[0]);
  if (b.sim) nsdae_sim_get_stats(b.sim, &of[1]);
  assert_int_equal(of[0].fallback_steps, of[1].fallback_steps);
  fallbacks = of[1].fallback_steps;
  nsdae_sim_destroy(&a.sim);
  nsdae_sim_destroy(&b.sim);
  as_list_destroy(copy);
  return most;
}

/* ---- the examples */

static void make_model(scene *s, const driver_model *m)
{
  nsdae_error error;
  *s = (scene){0};
  nsdae_sim_options_default(&s->options);
  s->options.method = NSDAE_METHOD_EVENT;
  if (m->dt > 0) s->options.dt = m->dt;
  nsdae_params_default(m->parameters, m->base);
  assert_int_equal(m->build(m->base, &s->system, &error), NSDAE_OK);
  m->start(m->base, s->q, s->v);
}

static void test_examples(void **state)
{
  static const driver_model *const models[] = {
      &bouncing_ball_model, &clearance_hinge_model, &crank_slider_model,   &dominoes_model,
      &falling_rod_model,   &incline_model,         &newtons_cradle_model, &rolling_ball_model,
      &shaken_ball_model,   &woodpecker_model};
  (void)state;
  for (size_t i = 0; i < sizeof models / sizeof *models; i++) {
    static scene s;
    int events = 0;
    make_model(&s, models[i]);
    nsdae_dims dims;
    nsdae_system_get_dims(s.system, &dims);
    if (dims.f > 0 || dims.k == 0) {
      nsdae_system_destroy(&s.system);
      continue;
    }
    double most = follow(models[i]->name, &s, STEPS, NEAR, &events);
    print_message("%-20s %3d events, %.2g apart\n", models[i]->name, events, most);
    nsdae_system_destroy(&s.system);
  }
}

/* ---- random systems */

static void make_random(scene *s, random_system *r, uint64_t seed, int integrator)
{
  *s = (scene){0};
  nsdae_sim_options_default(&s->options);
  s->options.method = NSDAE_METHOD_EVENT;
  s->options.integrator = integrator;
  random_system_draw(r, seed, RANDOM_PLAIN);
  s->system = random_system_make(r);
  memcpy(s->q, r->q0, sizeof r->q0);
  memcpy(s->v, r->v0, sizeof r->v0);
}

/* Whether no derivative of it is differenced. */
static int is_exact(const random_system *r)
{
  const unsigned contacts =
                     1u << RANDOM_NORMAL | 1u << RANDOM_CONTACT_BIAS | 1u << RANDOM_ACCELERATION,
                 constraints = 1u << RANDOM_JACOBIAN | 1u << RANDOM_BIAS;
  unsigned needed = contacts | (r->dims.m > 0 ? constraints : 0);
  return (r->given & needed) == needed;
}

static void test_random(void **state)
{
  int events = 0, systems = 0;
  double most = 0;
  (void)state;
  for (uint64_t seed = 0; seed < SEEDS; seed++) {
    static scene s;
    random_system r;
    char name[32];
    snprintf(name, sizeof name, "seed %d", (int)seed);
    make_random(&s, &r, seed, NSDAE_INTEGRATOR_AUTO);
    if (r.dims.k > 0 && r.dims.f == 0) {
      int exact = is_exact(&r);
      double off = follow(name, &s, STEPS / 2, exact ? NEAR : DIFFERENCED, &events);
      if (exact) most = fmax(most, off);
      systems++;
    }
    nsdae_system_destroy(&s.system);
  }
  print_message("%d random systems: %d events, %.2g apart\n", systems, events, most);
  assert_true(events > 50);
}

/* ---- steps by implicit where event gives up, and event after them */

static void test_fallbacks(void **state)
{
  int events = 0;
  long steps = 0;
  (void)state;
  for (uint64_t seed = 0; seed < 3 * SEEDS; seed++) {
    static scene s;
    random_system r;
    char name[32];
    snprintf(name, sizeof name, "few instants, seed %d", (int)seed);
    make_random(&s, &r, seed, NSDAE_INTEGRATOR_AUTO);
    s.options.events_max = 1;
    if (r.dims.k > 0 && r.dims.f == 0 && is_exact(&r)) {
      follow(name, &s, STEPS / 2, NEAR, &events);
      steps += fallbacks;
    }
    nsdae_system_destroy(&s.system);
  }
  print_message("%ld steps by implicit\n", steps);
  assert_true(steps > 10);
}

/* ---- a state put back */

/* Where a simulation of the same list goes on from a block it has the same bytes. */
static void test_resumed(void **state)
{
  static const driver_model *const models[] = {&bouncing_ball_model, &newtons_cradle_model,
                                               &dominoes_model, &woodpecker_model, &column_model};
  (void)state;
  for (size_t i = 0; i < sizeof models / sizeof *models; i++) {
    static scene s;
    run a, b;
    size_t size = 0, other = 0;
    make_model(&s, models[i]);
    as_list *copy = as_list_create(s.system, 0, NULL, NULL);
    begin(&a, as_list_system(copy), &s);
    for (int kill = 0; kill < 6 && a.status >= 0; kill++) {
      for (int n = 0; n < (models[i] == &column_model ? 2 : 17) && a.status >= 0; n++) step(&a);
      assert_int_equal(nsdae_sim_state_size(a.sim, &size), NSDAE_OK);
      char *block = malloc(size), *again = malloc(2 * size);
      assert_int_equal(nsdae_sim_get_state(a.sim, block, size), NSDAE_OK);
      begin(&b, as_list_system(copy), &s);
      assert_int_equal(nsdae_sim_set_state(b.sim, block, size), NSDAE_OK);
      assert_int_equal(nsdae_sim_state_size(b.sim, &other), NSDAE_OK);
      assert_int_equal(other, size);
      assert_int_equal(nsdae_sim_get_state(b.sim, again, size), NSDAE_OK);
      assert_memory_equal(again, block, size);
      for (int n = 0; n < 9 && a.status >= 0; n++) step(&a), step(&b);
      assert_int_equal(nsdae_sim_state_size(a.sim, &size), NSDAE_OK);
      assert_int_equal(nsdae_sim_state_size(b.sim, &other), NSDAE_OK);
      assert_int_equal(other, size);
      block = realloc(block, size), again = realloc(again, size);
      assert_int_equal(nsdae_sim_get_state(a.sim, block, size), NSDAE_OK);
      assert_int_equal(nsdae_sim_get_state(b.sim, again, size), NSDAE_OK);
      assert_memory_equal(again, block, size);
      free(block), free(again);
      nsdae_sim_destroy(&b.sim);
    }
    nsdae_sim_destroy(&a.sim);
    as_list_destroy(copy);
    nsdae_system_destroy(&s.system);
  }
}

/* ---- names */

/* A start that overlaps: the contact is named by its id, whatever its slot. */
static void test_named(void **state)
{
  static scene s;
  nsdae_error error;
  nsdae_sim *sim = NULL;
  (void)state;
  make_model(&s, &newtons_cradle_model);
  as_list *copy = as_list_create(s.system, 0, NULL, NULL);
  as_list_hide(copy, 0); /* contact 1 is in the first slot */
  s.q[1] += 0.5;
  assert_int_equal(nsdae_sim_create(as_list_system(copy), &s.options, &sim, &error), NSDAE_OK);
  assert_int_equal(nsdae_sim_init(sim, 0, s.q, s.v), NSDAE_E_ARGUMENT);
  assert_non_null(strstr(nsdae_sim_error(sim)->text, "contact of id 1"));
  assert_int_equal(nsdae_sim_error(sim)->index, 1);
  nsdae_sim_destroy(&sim);
  as_list_destroy(copy);
  nsdae_system_destroy(&s.system);
}

/* ---- a bead on the hill y = -x^2 / 2, which begins at x = 0: the list has nothing behind */

static int hill_mass(double t, const double *q, double *M, void *user)
{
  (void)t, (void)q, (void)user;
  M[0] = M[3] = 1;
  return 0;
}

static int hill_weight(double t, const double *q, const double *v, double *F, void *user)
{
  (void)t, (void)q, (void)v, (void)user;
  F[1] = -9.81;
  return 0;
}

static int hill(double t, const double *q, const double *v, double reach, nsdae_contact_list *list,
                void *user)
{
  nsdae_contact c = {.block = {0, -1}, .gap = q[1] + q[0] * q[0] / 2};
  (void)t, (void)v, (void)user;
  c.direction[0][0][0] = q[0];
  c.direction[0][0][1] = 1;
  return q[0] >= 0 && c.gap <= reach && nsdae_contact_add(list, &c) < 0 ? -1 : 0;
}

/* Slower than sqrt(g R), R = 1, it stays on the hill: the rate of the gap, whose differences at the
 * start are those of points ahead alone, falls by v^2 / R. So nothing happens but that the contact
 * is closed at the start. */
static void test_nothing_behind(void **state)
{
  (void)state;
  const double parts[] = {0.3, 0.5, 0.7, 0.9}; /* of g R */
  for (int i = 0; i < 4; i++) {
    const nsdae_dims dims = {.nq = 2};
    const int two = 2;
    const double q[2] = {0, 0}, v[2] = {sqrt(parts[i] * 9.81), 0};
    nsdae_system *system;
    nsdae_sim *sim;
    nsdae_sim_options o;
    nsdae_record r;
    nsdae_stats stats;
    assert_int_equal(nsdae_system_create(&dims, &system, NULL), NSDAE_OK);
    assert_int_equal(nsdae_system_set_blocks(system, 1, &two, &two), NSDAE_OK);
    nsdae_system_set_mass_blocks(system, hill_mass);
    nsdae_system_set_force(system, hill_weight);
    nsdae_system_set_contacts(system, hill);
    nsdae_sim_options_default(&o);
    o.method = NSDAE_METHOD_EVENT;
    o.dt = 0.01;
    assert_int_equal(nsdae_sim_create(system, &o, &sim, NULL), NSDAE_OK);
    assert_int_equal(nsdae_sim_init(sim, 0, q, v), NSDAE_OK);
    assert_int_equal(nsdae_sim_run(sim, 0.05), NSDAE_OK);
    nsdae_sim_get_record(sim, &r);
    nsdae_sim_get_stats(sim, &stats);
    assert_int_equal(stats.events, 1);
    assert_int_equal(stats.impacts, 0);
    assert_near(r.q[1] + r.q[0] * r.q[0] / 2, 0, 1e-9); /* rtol is 1e-8, the way 0.1 m */
    nsdae_sim_destroy(&sim);
    nsdae_system_destroy(&system);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_examples),  cmocka_unit_test(test_random),
      cmocka_unit_test(test_fallbacks), cmocka_unit_test(test_resumed),
      cmocka_unit_test(test_named),     cmocka_unit_test(test_nothing_behind)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
