/* The state as a value, and the step as a transaction, for every method on the examples and on
 * random systems: a state that is set elsewhere goes on with the same bytes, whatever fails leaves
 * no trace. */
#include "check.h"

#include <stdlib.h>

#include "backlash.h"
#include "bouncing_ball.h"
#include "clearance_hinge.h"
#include "crank_slider.h"
#include "disks.h"
#include "falling_rod.h"
#include "geneva.h"
#include "gripper.h"
#include "incline.h"
#include "newtons_cradle.h"
#include "pendulum.h"
#include "random_system.h"
#include "rolling_ball.h"
#include "woodpecker.h"

enum { STEPS = 60, TAKEN = 20, NQ = 12, SYSTEMS = 6, OBSERVERS = 3 };

static const driver_model *const models[] = {
    &backlash_model,        &geneva_model,       &gripper_model,      &bouncing_ball_model,
    &clearance_hinge_model, &crank_slider_model, &falling_rod_model,  &incline_model,
    &newtons_cradle_model,  &pendulum_model,     &rolling_ball_model, &woodpecker_model};
enum { MODELS = sizeof models / sizeof *models };

/* A system to run, an example or a random one. */
typedef struct bench {
  nsdae_system *system;
  nsdae_dims dims;
  nsdae_sim_options options;
  double q0[NQ], v0[NQ];
  random_system random; /* where there are no parameters */
} bench;

/* FNV-1a over all that the records of a run say. */
typedef struct transcript {
  nsdae_dims dims;
  uint64_t sum[STEPS + 1]; /* after each record */
  long records, last;
} transcript;

static uint64_t add(uint64_t sum, const void *bytes, size_t n)
{
  for (size_t i = 0; i < n; i++)
    sum = (sum ^ ((const unsigned char *)bytes)[i]) * UINT64_C(1099511628211);
  return sum;
}

static uint64_t add_doubles(uint64_t sum, const double *a, int n)
{
  return add(sum, a, (size_t)n * sizeof *a);
}

static uint64_t sum_of(const nsdae_record *r, const nsdae_dims *d)
{
  uint64_t sum = add(UINT64_C(14695981039346656037), &r->step, sizeof r->step);
  const double scalars[] = {r->time,       r->kinetic,      r->potential,
                            r->dissipated, r->lcp_residual, r->constraint_drift};
  sum = add_doubles(sum, scalars, 6);
  sum = add_doubles(sum, r->q, d->nq);
  sum = add_doubles(sum, r->v, d->nv);
  sum = add_doubles(sum, r->multiplier, d->m);
  sum = add_doubles(sum, r->normal_impulse, d->k);
  sum = add_doubles(sum, r->tangential_impulse, d->k * d->nt);
  sum = add_doubles(sum, r->frictional_joint_impulse, d->f);
  sum = add(sum, r->mode, (size_t)d->k * sizeof *r->mode);
  for (int i = 0; i < r->impacts; i++) {
    const nsdae_impact *p = &r->impact[i];
    const double all[] = {p->time, p->normal_impulse, p->velocity_before, p->velocity_after,
                          p->peak_force};
    sum = add_doubles(sum, all, 5);
  }
  return sum;
}

/* Each step once, in order. */
static int write_down(const nsdae_record *r, nsdae_error *error, void *user)
{
  transcript *t = user;
  (void)error;
  assert_int_equal(r->step, t->last + 1);
  t->last = r->step;
  t->sum[r->step] = sum_of(r, &t->dims);
  t->records++;
  return 0;
}

static void open_transcript(transcript *t, const bench *b, long after)
{
  *t = (transcript){.dims = b->dims, .last = after};
}

static void use_model(bench *b, const driver_model *model)
{
  *b = (bench){0};
  nsdae_params_default(model->parameters, model->base);
  assert_int_equal(model->build(model->base, &b->system, NULL), NSDAE_OK);
  model->start(model->base, b->q0, b->v0);
  nsdae_sim_options_default(&b->options);
  if (model->dt > 0) b->options.dt = model->dt;
  nsdae_system_get_dims(b->system, &b->dims);
}

static void use_random(bench *b, uint64_t seed)
{
  *b = (bench){0};
  random_system_draw(&b->random, seed, RANDOM_PLAIN);
  b->system = random_system_make(&b->random);
  assert_non_null(b->system);
  b->dims = b->random.dims;
  memcpy(b->q0, b->random.q0, sizeof b->random.q0);
  memcpy(b->v0, b->random.v0, sizeof b->random.v0);
  nsdae_sim_options_default(&b->options);
  b->options.dt = 0.02;
  b->options.penalty_stiffness = 1e5;
}

static void done(bench *b)
{
  nsdae_system_destroy(&b->system);
}

/* NULL where the method is not built. */
static nsdae_sim *make(bench *b, int method)
{
  nsdae_sim *sim = NULL;
  b->options.method = method;
  int status = nsdae_sim_create(b->system, &b->options, &sim, NULL);
  if (status != NSDAE_E_UNSUPPORTED) assert_int_equal(status, NSDAE_OK);
  return sim;
}

static nsdae_sim *start(bench *b, int method, transcript *t)
{
  nsdae_sim *sim = make(b, method);
  open_transcript(t, b, -1);
  if (!sim) return NULL;
  assert_int_equal(nsdae_sim_observe(sim, write_down, t), NSDAE_OK);
  assert_int_equal(nsdae_sim_init(sim, 0, b->q0, b->v0), NSDAE_OK);
  return sim;
}

static unsigned char *state_of(nsdae_sim *sim, size_t *size)
{
  assert_int_equal(nsdae_sim_state_size(sim, size), NSDAE_OK);
  unsigned char *block = malloc(*size);
  assert_non_null(block);
  assert_int_equal(nsdae_sim_get_state(sim, block, *size), NSDAE_OK);
  return block;
}

static void expect_state(nsdae_sim *sim, const unsigned char *block)
{
  size_t size;
  unsigned char *now = state_of(sim, &size);
  assert_memory_equal(now, block, size);
  free(now);
}

/* Every function on every system and method. */
static void each(void (*f)(bench *b, int method))
{
  static bench b;
  for (int method = 0; nsdae_method_name(method); method++) {
    for (int i = 0; i < MODELS; i++) {
      use_model(&b, models[i]);
      f(&b, method);
      done(&b);
    }
    for (uint64_t seed = 1; seed <= SYSTEMS; seed++) {
      use_random(&b, seed);
      f(&b, method);
      done(&b);
    }
  }
}

/* States of a run, taken between its steps, set into another simulation. */
static void elsewhere(bench *b, int method)
{
  static transcript whole, rest;
  unsigned char *taken[TAKEN], *last;
  long at[TAKEN];
  size_t size;
  nsdae_sim *sim = start(b, method, &whole), *other;
  if (!sim) return;
  for (int i = 0, s = 0; s < STEPS; s++) {
    if (s % (STEPS / TAKEN) == 0) {
      at[i] = s;
      taken[i++] = state_of(sim, &size);
    }
    assert_true(nsdae_sim_step(sim) >= 0);
  }
  last = state_of(sim, &size);
  for (int i = 0; i < TAKEN; i += test_share()) {
    other = make(b, method);
    open_transcript(&rest, b, i == 0 ? 0 : at[i]);
    nsdae_sim_observe(other, write_down, &rest);
    assert_int_equal(nsdae_sim_set_state(other, taken[i], size), NSDAE_OK);
    expect_state(other, taken[i]);
    for (long s = at[i]; s < STEPS; s++) assert_true(nsdae_sim_step(other) >= 0);
    for (long s = at[i] + 1; s <= STEPS; s++)
      if (rest.sum[s] != whole.sum[s])
        fail_msg("method %d nq %d: state of step %ld, step %ld differs", method, b->dims.nq, at[i],
                 s);
    expect_state(other, last);
    nsdae_sim_destroy(&other);
  }
  /* and back into the one that went on */
  assert_int_equal(nsdae_sim_set_state(sim, taken[TAKEN / 2], size), NSDAE_OK);
  whole.last = at[TAKEN / 2];
  for (long s = at[TAKEN / 2]; s < STEPS; s++) assert_true(nsdae_sim_step(sim) >= 0);
  expect_state(sim, last);
  for (int i = 0; i < TAKEN; i++) free(taken[i]);
  free(last);
  nsdae_sim_destroy(&sim);
}

static void test_elsewhere(void **state)
{
  (void)state;
  each(elsewhere);
}

/* Observers that fail once each, at a step of their own. */
typedef struct failing {
  long at;
  transcript *seen;
} failing;

static int fail_once(const nsdae_record *r, nsdae_error *error, void *user)
{
  failing *f = user;
  if (r->step == f->at) {
    f->at = -1;
    return NSDAE_E_IO;
  }
  return write_down(r, error, f->seen);
}

/* At each step of the run; in the quick form at a few, which begin at another one for each system.
 */
static void observed(bench *b, int method)
{
  static long rotation;
  const int stride = test_share() > 1 ? 3 * test_share() : 1;
  static transcript whole, seen[OBSERVERS];
  size_t size;
  nsdae_sim *sim = start(b, method, &whole);
  if (!sim) return;
  for (int s = 0; s < STEPS; s++) assert_true(nsdae_sim_step(sim) >= 0);
  unsigned char *last = state_of(sim, &size);
  nsdae_sim_destroy(&sim);
  for (long at = 4 * rotation++ % stride; at < STEPS; at += stride) {
    failing f[OBSERVERS];
    int failures = 0;
    sim = make(b, method);
    for (int i = 0; i < OBSERVERS; i++) {
      open_transcript(&seen[i], b, -1);
      f[i] = (failing){at + i % 2, &seen[i]};
      assert_int_equal(nsdae_sim_observe(sim, fail_once, &f[i]), NSDAE_OK);
    }
    assert_int_equal(nsdae_sim_init(sim, 0, b->q0, b->v0), NSDAE_OK);
    for (int s = 0; s < STEPS; s++) {
      int status = nsdae_sim_step(sim);
      if (status >= 0) continue;
      assert_int_equal(status, NSDAE_E_IO);
      failures++;
      s--;
    }
    assert_int_equal(failures, OBSERVERS);
    for (int i = 0; i < OBSERVERS; i++) {
      assert_int_equal(seen[i].records, STEPS + 1);
      assert_memory_equal(seen[i].sum, whole.sum, sizeof whole.sum);
    }
    expect_state(sim, last);
    nsdae_sim_destroy(&sim);
  }
  free(last);
}

static void test_observers(void **state)
{
  (void)state;
  each(observed);
}

/* Refused with the argument that is wrong, and the simulation is as it was. */
static void refuse(nsdae_sim *sim, const unsigned char *block, size_t size, const char *argument)
{
  size_t own;
  unsigned char *before = state_of(sim, &own);
  int status = nsdae_sim_set_state(sim, block, size);
  assert_true(status == NSDAE_E_ARGUMENT || status == NSDAE_E_NONFINITE);
  assert_string_equal(nsdae_sim_error(sim)->argument, argument);
  expect_state(sim, before);
  free(before);
}

/* The block's checksum, as the head of lib/sim/snapshot.c says: FNV-1a of what is before its place
 * xor that of what is after. */
static void put_checksum(unsigned char *block, size_t size)
{
  enum { PLACE = 24 };
  const uint64_t basis = UINT64_C(14695981039346656037);
  uint64_t sum =
      add(basis, block, PLACE) ^ add(basis, block + PLACE + sizeof sum, size - PLACE - sizeof sum);
  memcpy(block + PLACE, &sum, sizeof sum);
}

/* A pendulum with this method and option, some steps from its start. */
static nsdae_sim *swing(bench *b, int method, const char *key, const char *value)
{
  use_model(b, &pendulum_model);
  if (key) assert_int_equal(nsdae_sim_options_set(&b->options, key, value, NULL), NSDAE_OK);
  nsdae_sim *sim = make(b, method);
  if (!sim) return NULL;
  assert_int_equal(nsdae_sim_init(sim, 0, b->q0, b->v0), NSDAE_OK);
  for (int i = 0; i < 10; i++) assert_true(nsdae_sim_step(sim) >= 0);
  return sim;
}

static void refuse_in(int method, const char *key, const char *value, const unsigned char *block,
                      size_t size)
{
  static bench b;
  nsdae_sim *sim = swing(&b, method, key, value);
  if (sim) refuse(sim, block, size, key ? key : "method");
  nsdae_sim_destroy(&sim);
  done(&b);
}

static void test_refused(void **state)
{
  static bench b, other;
  size_t size;
  (void)state;
  nsdae_sim *sim = swing(&b, NSDAE_METHOD_MOREAU, NULL, NULL);
  unsigned char *block = state_of(sim, &size);
  assert_true(nsdae_sim_step(sim) >= 0);
  for (size_t i = 0; i < size; i++) { /* one bit in each byte */
    block[i] ^= (unsigned char)(1 << i % 8);
    assert_int_equal(nsdae_sim_set_state(sim, block, size), NSDAE_E_ARGUMENT);
    block[i] ^= (unsigned char)(1 << i % 8);
  }
  refuse(sim, block, size - 1, "size");
  refuse(sim, block, 3, "size");
  refuse(sim, block, size + 1, "size");
  refuse(sim, NULL, size, "block");
  const double nan_ = NAN;
  int refused = 0;
  size_t i = size - sizeof nan_;
  for (int settings = 0; !settings; i -= 8) { /* from the end to the settings, which say so */
    unsigned char *bad = malloc(size);
    assert_non_null(bad);
    memcpy(bad, block, size);
    memcpy(bad + i, &nan_, sizeof nan_);
    put_checksum(bad, size);
    int status = nsdae_sim_set_state(sim, bad, size);
    nsdae_record r;
    nsdae_sim_get_record(sim, &r);
    refused += status == NSDAE_E_NONFINITE;
    settings = status == NSDAE_E_ARGUMENT && strstr(nsdae_sim_error(sim)->text, "same settings");
    assert_true(settings || status == NSDAE_OK || status == NSDAE_E_NONFINITE);
    assert_true(isfinite(r.q[0]) && isfinite(r.v[0]) && isfinite(r.time));
    free(bad);
  }
  assert_true(i < size / 2); /* what precedes them is less than what follows */
  assert_true(refused >= 2 * b.dims.nq + b.dims.m + b.dims.k);
  refuse_in(NSDAE_METHOD_MOREAU, "dt", "0.003", block, size);
  refuse_in(NSDAE_METHOD_MOREAU, "contact_tol", "1e-9", block, size);
  refuse_in(NSDAE_METHOD_IMPLICIT, NULL, NULL, block, size);
  /* what moreau does not look at may be another */
  nsdae_sim *same = swing(&other, NSDAE_METHOD_MOREAU, "rtol", "1e-5");
  assert_int_equal(nsdae_sim_set_state(same, block, size), NSDAE_OK);
  nsdae_sim_destroy(&same);
  done(&other);
  use_model(&other, &crank_slider_model);
  same = make(&other, NSDAE_METHOD_MOREAU);
  assert_int_equal(nsdae_sim_set_state(same, block, size), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_sim_get_state(same, block, size), NSDAE_E_STATE);
  nsdae_sim_destroy(&same);
  done(&other);
  free(block);
  nsdae_sim_destroy(&sim);
  done(&b);
}

/* A number that is none, in each array of the last step's impulses. */
static void test_refused_impulses(void **state)
{
  static bench b;
  size_t size;
  nsdae_record r;
  (void)state;
  const driver_model *const rubbing[] = {&incline_model, &crank_slider_model};
  for (int model = 0; model < 2; model++) {
    use_model(&b, rubbing[model]);
    nsdae_sim *sim = make(&b, NSDAE_METHOD_MOREAU);
    assert_int_equal(nsdae_sim_init(sim, 0, b.q0, b.v0), NSDAE_OK);
    for (int s = 0; s < 20; s++) assert_true(nsdae_sim_step(sim) >= 0);
    nsdae_sim_get_record(sim, &r);
    double impulse = model == 0 ? r.tangential_impulse[0] : r.frictional_joint_impulse[0],
           infinite = -INFINITY;
    assert_true(impulse != 0);
    unsigned char *block = state_of(sim, &size);
    int found = 0;
    for (size_t i = 0; i + sizeof impulse <= size; i++) {
      if (memcmp(block + i, &impulse, sizeof impulse) != 0) continue;
      memcpy(block + i, &infinite, sizeof infinite);
      put_checksum(block, size);
      found += nsdae_sim_set_state(sim, block, size) == NSDAE_E_NONFINITE;
      memcpy(block + i, &impulse, sizeof impulse);
    }
    assert_true(found >= 1);
    free(block);
    nsdae_sim_destroy(&sim);
    done(&b);
  }
}

/* A heap of disks whose contacts come by list, after some steps. */
static nsdae_sim *heap_of(int method, disks *d, nsdae_system **system)
{
  enum { DISKS = 6 };
  double q0[3 * DISKS], v0[3 * DISKS];
  nsdae_sim_options o;
  nsdae_sim *sim;
  disks_create(d, DISKS, 3);
  *system = disks_system(d);
  nsdae_sim_options_default(&o);
  o.method = method;
  o.dt = 2e-3;
  disks_start(d, q0, v0);
  assert_int_equal(nsdae_sim_create(*system, &o, &sim, NULL), NSDAE_OK);
  assert_int_equal(nsdae_sim_init(sim, 0, q0, v0), NSDAE_OK);
  assert_true(nsdae_sim_run(sim, 0.3) >= 0);
  return sim;
}

/* Each word of a state with contacts by list, or of its last ones, in turn made another, with a
 * checksum that fits: the block is refused and nothing has changed, or it is a state, from which a
 * step ends with a status and finite numbers. The good one afterwards goes on with the same bytes.
 */
static void damage_list(int method, size_t last)
{
  enum { HOSTILE = 5 };
  static const uint32_t hostile[HOSTILE] = {0x7ff80000, 0xfffffffb, 0x7fffffff, 0, 0x40000000};
  disks d;
  nsdae_system *system;
  nsdae_record r;
  size_t size;
  int refused = 0;
  nsdae_sim *sim = heap_of(method, &d, &system);
  nsdae_sim_get_record(sim, &r);
  assert_true(r.contacts.count > 3);
  unsigned char *block = state_of(sim, &size), *bad = malloc(size);
  assert_non_null(bad);
  assert_true(nsdae_sim_step(sim) >= 0);
  size_t length;
  unsigned char *next = state_of(sim, &length);
  for (size_t i = last > 0 ? size - 4 * last : 0; i + 4 <= size; i += 4)
    for (size_t h = 0; h < HOSTILE; h++) {
      if (test_share() > 1 && h != (i / 4 + i / 8) % HOSTILE) continue; /* in rotation */
      memcpy(bad, block, size);
      memcpy(bad + i, &hostile[h], 4);
      put_checksum(bad, size);
      assert_int_equal(nsdae_sim_set_state(sim, block, size), NSDAE_OK);
      if (nsdae_sim_set_state(sim, bad, size) == NSDAE_OK)
        nsdae_sim_step(sim);
      else
        refused++, expect_state(sim, block);
      nsdae_sim_get_record(sim, &r);
      assert_true(isfinite(r.time) && isfinite(r.q[0]) && isfinite(r.kinetic));
    }
  assert_true(refused > (last > 0 ? 10 : 100) / (test_share() > 1 ? HOSTILE : 1));
  assert_int_equal(nsdae_sim_set_state(sim, block, size), NSDAE_OK);
  assert_true(nsdae_sim_step(sim) >= 0);
  expect_state(sim, next);
  free(next);
  free(bad);
  free(block);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  disks_destroy(&d);
}

static void test_damaged_list(void **state)
{
  (void)state;
  damage_list(NSDAE_METHOD_MOREAU, 0);
  damage_list(NSDAE_METHOD_PENALTY, 40);
  damage_list(NSDAE_METHOD_EVENT, 40);
}

static int is_an_option(const char *key)
{
  return nsdae_params_find(nsdae_sim_options_table(), key) != NULL;
}

/* Another value of an option than its own, as text; 0: there is none. */
static int another(const nsdae_param *p, const nsdae_sim_options *o, char *text)
{
  double value;
  int whole;
  if (p->type == NSDAE_PARAM_REAL) {
    memcpy(&value, (const char *)o + p->offset, sizeof value);
    double half = value > 0 ? value / 2 : p->open & NSDAE_OR_ZERO ? p->max : 1;
    return snprintf(text, 32, "%.17g", half > p->min ? half : 1.5 * value);
  }
  memcpy(&whole, (const char *)o + p->offset, sizeof whole);
  if (p->type == NSDAE_PARAM_CHOICE) return snprintf(text, 32, "%s", p->choices[whole == 0]);
  return snprintf(text, 32, "%d", whole + 4);
}

/* Every option: where it matters to the method a state is refused by its name; where it does not,
 * the run has the same bytes. Every field of the struct is in the table. */
static void test_options(void **state)
{
  const nsdae_params *table = nsdae_sim_options_table();
  static bench b, other;
  size_t bytes = sizeof(unsigned), size;
  char text[32];
  (void)state;
  for (int i = 0; i < table->n; i++)
    bytes += table->entry[i].type == NSDAE_PARAM_REAL ? sizeof(double) : sizeof(int);
  assert_true(sizeof(nsdae_sim_options) - bytes < 4 * sizeof(double)); /* padding */
  assert_true(is_an_option("dt") && !is_an_option("nothing"));
  for (int method = 0; nsdae_method_name(method); method++)
    for (int i = 0; i < table->n; i++) {
      const nsdae_param *p = &table->entry[i];
      nsdae_sim *sim = swing(&b, method, NULL, NULL);
      if (!sim || strcmp(p->key, "method") == 0 || !another(p, &b.options, text)) {
        nsdae_sim_destroy(&sim);
        done(&b);
        continue;
      }
      unsigned char *block = state_of(sim, &size);
      use_model(&other, &pendulum_model);
      if (nsdae_sim_options_set(&other.options, p->key, text, NULL) < 0)
        fail_msg("%s = %s was refused", p->key, text);
      other.options.method = method;
      nsdae_sim *changed = NULL;
      int status = nsdae_sim_create(other.system, &other.options, &changed, NULL);
      if (status == NSDAE_OK) {
        status = nsdae_sim_set_state(changed, block, size);
        if (status < 0) assert_string_equal(nsdae_sim_error(changed)->argument, p->key);
        for (int s = 0; s < 20 && status == NSDAE_OK; s++) {
          assert_int_equal(nsdae_sim_step(sim), nsdae_sim_step(changed));
          nsdae_record r, q;
          nsdae_sim_get_record(sim, &r);
          nsdae_sim_get_record(changed, &q);
          if (memcmp(r.q, q.q, (size_t)b.dims.nq * sizeof *r.q) != 0)
            fail_msg("%s: %s was said not to matter", nsdae_method_name(method), p->key);
        }
      } else { /* refused from the start, by name */
        assert_string_equal(p->key, "projection");
        assert_true(method >= NSDAE_METHOD_PENALTY);
      }
      free(block);
      nsdae_sim_destroy(&sim);
      nsdae_sim_destroy(&changed);
      done(&b);
      done(&other);
    }
}

/* Of the first 600 steps every other one ends off the grid. */
static void long_step(nsdae_sim *sim, int s, double dt)
{
  nsdae_record r;
  nsdae_sim_get_record(sim, &r);
  int status = s < 600 && s % 2 ? nsdae_sim_run(sim, r.time + 0.6 * dt) : nsdae_sim_step(sim);
  assert_true(status >= 0);
}

/* So many steps that an integrator starts anew for the length of its replay alone: penalty after
 * 4096 steps, or 128 that are off the grid, event after 5000 of its own. */
static void test_long(void **state)
{
  static const int taken[] = {254, 255, 256, 257, 601, 4000, 4608, 5010, 5011};
  static bench b;
  size_t size;
  (void)state;
  for (int method = 0; nsdae_method_name(method); method++) {
    int most = method < NSDAE_METHOD_PENALTY ? 700 : 5100;
    use_model(&b, &crank_slider_model);
    b.options.dt = 4e-7; /* before its first contact */
    nsdae_sim *sim = make(&b, method), *other = make(&b, method);
    if (sim) {
      assert_int_equal(nsdae_sim_init(sim, 0, b.q0, b.v0), NSDAE_OK);
      for (int s = 0, next = 0; s < most; s++) {
        long_step(sim, s, b.options.dt);
        if (next == sizeof taken / sizeof *taken || s != taken[next]) continue;
        unsigned char *block = state_of(sim, &size);
        if (next > 0) expect_state(other, block);
        assert_int_equal(nsdae_sim_set_state(other, block, size), NSDAE_OK);
        free(block);
        int upto = ++next == sizeof taken / sizeof *taken ? most : taken[next] + 1;
        for (int i = s + 1; i < upto && i < most; i++) long_step(other, i, b.options.dt);
      }
      unsigned char *last = state_of(sim, &size);
      expect_state(other, last);
      free(last);
    }
    nsdae_sim_destroy(&sim);
    nsdae_sim_destroy(&other);
    done(&b);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_elsewhere),    cmocka_unit_test(test_observers),
      cmocka_unit_test(test_refused),      cmocka_unit_test(test_refused_impulses),
      cmocka_unit_test(test_damaged_list), cmocka_unit_test(test_options),
      cmocka_unit_test(test_long),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
