/* The option projection and nsdae_sim_project with contact lists: the same as with fixed contacts,
 * and by exact solutions; what can go wrong; no step allocates. */
#include "check.h"

#include <stdlib.h>

#include "allocator.h"
#include "as_list.h"
#include "random.h"
#include "random_system.h"
#include "rods.h"
#include "twin.h"

static const double DT = 2e-3;

static const int methods[] = {NSDAE_METHOD_IMPLICIT, NSDAE_METHOD_IMPLICIT_PRINTED,
                              NSDAE_METHOD_MOREAU};

static const int projections[] = {NSDAE_PROJECTION_CONSTRAINTS, NSDAE_PROJECTION_CONTACTS,
                                  NSDAE_PROJECTION_DEPTHS};

enum { EACH = 3, STEPS = 20 };

static nsdae_sim *make(const nsdae_system *system, int method, int projection, double dt)
{
  nsdae_sim_options options;
  nsdae_sim *sim = NULL;
  nsdae_error error;
  assert_non_null(system);
  nsdae_sim_options_default(&options);
  options.method = method;
  options.projection = projection;
  options.dt = dt;
  options.rank_tol = 1e-12;
  options.start_tol = 1;   /* starts overlap */
  options.start_check = 0; /* random directions may be equal */
  if (nsdae_sim_create(system, &options, &sim, &error) < 0) fail_msg("%s", error.text);
  return sim;
}

/* ---- both ways */

/* A model with fixed contacts and the same with a list. */
typedef struct pair {
  nsdae_system *system[2];
  int nq, nv;
  double *q, *v; /* a start of both */
} pair;

/* The largest difference relative to 1 + |x|. */
static double difference(int n, const double *a, const double *b)
{
  double most = 0;
  for (int i = 0; i < n; i++) most = fmax(most, fabs(a[i] - b[i]) / (1 + fabs(a[i])));
  return most;
}

/* The start by nsdae_sim_project, put back into the pair; the difference, -1: no such state. */
static double project_both(const pair *p)
{
  double *q[2], *v[2], off;
  int status[2];
  for (int i = 0; i < 2; i++) {
    nsdae_sim *sim = make(p->system[i], NSDAE_METHOD_MOREAU, NSDAE_PROJECTION_NONE, DT);
    q[i] = calloc((size_t)p->nq, sizeof **q), v[i] = calloc((size_t)p->nv, sizeof **v);
    memcpy(q[i], p->q, (size_t)p->nq * sizeof **q), memcpy(v[i], p->v, (size_t)p->nv * sizeof **v);
    status[i] = nsdae_sim_project(sim, 0, q[i], v[i]);
    nsdae_sim_destroy(&sim);
  }
  assert_int_equal(status[0], status[1]);
  off = fmax(difference(p->nq, q[0], q[1]), difference(p->nv, v[0], v[1]));
  memcpy(p->q, q[0], (size_t)p->nq * sizeof **q), memcpy(p->v, v[0], (size_t)p->nv * sizeof **v);
  for (int i = 0; i < 2; i++) free(q[i]), free(v[i]);
  return status[0] < 0 ? -1 : off;
}

/* Each step from the same state; the largest difference, and how many contacts were closed. The
 * implicit methods end their iterations by tolerances, and find impacts by a threshold, where
 * rounding decides: of those only that the rows are satisfied alike. */
static double step_both(const pair *p, int method, int projection, double dt, int *closed)
{
  nsdae_sim *sim[2];
  nsdae_record r[2];
  double off = 0;
  for (int i = 0; i < 2; i++) sim[i] = make(p->system[i], method, projection, dt);
  double *q = calloc((size_t)p->nq, sizeof *q), *v = calloc((size_t)p->nv, sizeof *v);
  memcpy(q, p->q, (size_t)p->nq * sizeof *q), memcpy(v, p->v, (size_t)p->nv * sizeof *v);
  for (int n = 0; n < STEPS; n++) {
    int status[2];
    for (int i = 0; i < 2; i++) {
      status[i] = nsdae_sim_init(sim[i], n * dt, q, v);
      if (status[i] >= 0) status[i] = nsdae_sim_step(sim[i]);
      nsdae_sim_get_record(sim[i], &r[i]);
    }
    int iterates = method != NSDAE_METHOD_MOREAU;
    if ((status[0] < 0) != (status[1] < 0) && !iterates)
      fail_msg("%s; %s", nsdae_sim_error(sim[0])->text, nsdae_sim_error(sim[1])->text);
    if (status[0] < 0 || status[1] < 0) break;
    if (!iterates) off = fmax(off, difference(p->nq, r[0].q, r[1].q));
    if (!iterates) off = fmax(off, difference(p->nv, r[0].v, r[1].v));
    assert_near(r[1].constraint_drift, r[0].constraint_drift, iterates ? 1e-10 : 1e-13);
    *closed += r[1].contacts.count;
    memcpy(q, r[0].q, (size_t)p->nq * sizeof *q), memcpy(v, r[0].v, (size_t)p->nv * sizeof *v);
  }
  for (int i = 0; i < 2; i++) nsdae_sim_destroy(&sim[i]);
  free(q), free(v);
  return off;
}

/* Small ones are dense inside, the last two sparse. */
static const twin_kind kinds[] = {
    {.blocks = 1, .largest = 3, .k = 2, .nt = 1, .friction = 0.3},
    {.blocks = 4, .largest = 3, .joined = 1, .k = 4, .nt = 1, .friction = 0.4, .restitution = 0.8},
    {.blocks = 5, .largest = 7, .joined = 1, .k = 5, .nt = 2},
    {.blocks = 6, .largest = 2, .joined = 1, .k = 6, .restitution = 1},
    {.blocks = 40, .largest = 3, .joined = 1, .k = 6, .nt = 1, .friction = 0.2, .restitution = 0.5},
    {.blocks = 40, .largest = 3, .k = 20, .restitution = 1}};

enum { KINDS = sizeof kinds / sizeof *kinds };

static void test_twins(void **state)
{
  static twin t;
  double projected = 0, stepped = 0;
  int closed = 0;
  (void)state;
  for (int kind = 0; kind < KINDS; kind++)
    for (uint64_t seed = 0; seed < 4; seed++)
      for (int i = 0; i < EACH * EACH; i++) {
        uint64_t noise = seed;
        twin_draw(&t, 3000 + 100 * (uint64_t)kind + seed, &kinds[kind]);
        for (int j = 0; j < t.nv; j++) t.q0[j] += random_between(&noise, -0.05, 0.05);
        pair p = {{twin_numbered(&t, TWIN_BY_ROWS), twin_blocks(&t)}, t.nv, t.nv, t.q0, t.v0};
        double off = project_both(&p);
        projected = fmax(projected, off);
        if (off >= 0)
          stepped =
              fmax(stepped, step_both(&p, methods[i / EACH], projections[i % EACH], DT, &closed));
        for (int s = 0; s < 2; s++) nsdae_system_destroy(&p.system[s]);
      }
  print_message("%d contacts in a step; %.2g projected, %.2g a step\n", closed, projected, stepped);
  assert_true(closed > 1000);
  assert_at_most(projected, 1e-13);
  assert_at_most(stepped, 1e-13);
}

/* Every feature at random; contacts, directions and velocities of the fixed system as a list. */
static void test_random(void **state)
{
  static random_system r;
  double projected = 0, stepped = 0;
  int closed = 0;
  (void)state;
  for (uint64_t seed = 0; seed < 300; seed++) {
    uint64_t noise = seed;
    random_system_draw(&r, seed, RANDOM_PLAIN);
    if (r.dims.k == 0 || r.dims.f > 0) continue;
    for (int j = 0; j < r.dims.nq; j++) r.q0[j] += random_between(&noise, -0.1, 0.1);
    nsdae_system *fixed = random_system_make(&r);
    as_list *copy = as_list_create(fixed, 1, &r.dims.nq, &r.dims.nv);
    pair p = {{fixed, as_list_system(copy)}, r.dims.nq, r.dims.nv, r.q0, r.v0};
    double off = project_both(&p);
    projected = fmax(projected, off);
    if (off >= 0)
      stepped = fmax(stepped, step_both(&p, methods[seed % EACH], projections[seed / EACH % EACH],
                                        DT, &closed));
    as_list_destroy(copy);
    nsdae_system_destroy(&fixed);
  }
  print_message("%d contacts in a step; %.2g projected, %.2g a step\n", closed, projected, stepped);
  assert_true(closed > 200);
  assert_at_most(projected, 1e-13);
  assert_at_most(stepped, 1e-13);
}

/* The rod falls on its stop, e = 0, and lies there: with contacts it ends on the surface, 16 eps (1
 * + |row| max |q|), and its energy is that of the stop's height. */
static void test_rod(void **state)
{
  (void)state;
  for (int i = 0; i < EACH; i++) {
    rod r = {.wall = 0.3};
    nsdae_system *fixed = rod_system(&r);
    as_list *copy = as_list_create(fixed, 0, NULL, NULL);
    nsdae_sim *sim = make(as_list_system(copy), methods[i], NSDAE_PROJECTION_CONTACTS, 4e-3);
    const int printed = methods[i] == NSDAE_METHOD_IMPLICIT_PRINTED;
    double q[3], v[3];
    nsdae_record now;
    nsdae_stats stats;
    rod_start(1, 0, q, v);
    assert_int_equal(nsdae_sim_init(sim, 0, q, v), NSDAE_OK);
    assert_true(nsdae_sim_run(sim, 2) >= 0);
    nsdae_sim_get_record(sim, &now);
    nsdae_sim_get_stats(sim, &stats);
    assert_at_most(now.penetration, printed ? 0.75 * 9.81 * 16e-6 : 1.2e-14);
    assert_at_most(stats.worst_drift, 1.2e-14);
    if (!printed) assert_near(now.kinetic, 0, 1e-20);
    if (!printed) assert_near(now.potential, -9.81 * sqrt(1 - 0.09) / 2, 1e-13);
    nsdae_sim_destroy(&sim);
    as_list_destroy(copy);
    nsdae_system_destroy(&fixed);
  }
}

/* ---- columns that overlap, by isotonic regression */

enum { BALLS = 120 };

static double masses[BALLS];

static int column_mass(double t, const double *q, double *M, void *user)
{
  (void)t, (void)q, (void)user;
  memcpy(M, masses, sizeof masses);
  return 0;
}

static int no_force(double t, const double *q, const double *v, double *F, void *user)
{
  (void)t, (void)q, (void)v, (void)F, (void)user;
  return 0;
}

static int weight(double t, const double *q, const double *v, double *F, void *user)
{
  (void)t, (void)q, (void)v, (void)user;
  for (int i = 0; i < BALLS; i++) F[i] = -9.81 * masses[i];
  return 0;
}

/* The model is what it lists: an id that is there twice, or one that fails. */
typedef struct fault {
  long id, calls, at;
  int code;
  double gap;
} fault;

static int column_contacts(double t, const double *q, const double *v, double reach,
                           nsdae_contact_list *list, void *user)
{
  fault *f = user;
  int failing = f->calls++ >= f->at;
  (void)t, (void)v;
  if (failing && f->code) return f->code;
  for (int i = 0; i < BALLS; i++) {
    double gap = i > 0 ? q[i] - q[i - 1] - 1 : q[0];
    nsdae_contact c = {.id = 7 + 2L * i, .block = {i, i - 1}, .gap = gap};
    if (failing && i == BALLS / 2) c.gap += f->gap;
    if (failing && i == BALLS / 2 && f->id) c.id = f->id;
    c.direction[0][0][0] = 1;
    c.direction[1][0][0] = -1;
    if (!(gap > reach)) nsdae_contact_add(list, &c);
  }
  return 0;
}

static nsdae_system *column(fault *f)
{
  const nsdae_dims dims = {.nq = BALLS};
  nsdae_system *s = NULL;
  int ones[BALLS];
  for (int i = 0; i < BALLS; i++) ones[i] = 1;
  assert_int_equal(nsdae_system_create(&dims, &s, NULL), NSDAE_OK);
  assert_int_equal(nsdae_system_set_blocks(s, BALLS, ones, ones), NSDAE_OK);
  nsdae_system_set_user(s, f);
  nsdae_system_set_mass_blocks(s, column_mass);
  nsdae_system_set_force(s, no_force);
  nsdae_system_set_contacts(s, column_contacts);
  return s;
}

/* min sum m (x_i - q_i)^2 with x_0 >= 0, x_i >= x_(i-1) + 1: with y_i = x_i - i the regression of
 * q_i - i that ascends, by pooling neighbours that do not, and not below 0 (Barlow, Bartholomew,
 * Bremner and Brunk, Statistical Inference under Order Restrictions, 1972). */
static void regression(const double *q, double *x)
{
  double mean[BALLS], mass[BALLS];
  int size[BALLS], pools = 0;
  for (int i = 0; i < BALLS; i++) {
    mean[pools] = q[i] - i, mass[pools] = masses[i], size[pools++] = 1;
    while (pools > 1 && mean[pools - 2] >= mean[pools - 1]) {
      double sum = mass[pools - 2] + mass[pools - 1];
      mean[pools - 2] =
          (mass[pools - 2] * mean[pools - 2] + mass[pools - 1] * mean[pools - 1]) / sum;
      mass[pools - 2] = sum;
      size[pools - 2] += size[pools - 1];
      pools--;
    }
  }
  for (int p = 0, i = 0; p < pools; p++)
    for (int j = 0; j < size[p]; j++, i++) x[i] = fmax(mean[p], 0) + i;
}

static void draw_column(uint64_t seed, double *q)
{
  for (int i = 0; i < BALLS; i++) {
    masses[i] = pow(10, random_between(&seed, -1, 1));
    q[i] = i + random_between(&seed, -0.6, 0.9);
  }
}

static void test_columns(void **state)
{
  (void)state;
  fault none = {.at = 1L << 40};
  nsdae_system *system = column(&none);
  for (uint64_t seed = 1; seed < 6; seed++) {
    double q[BALLS], v[BALLS] = {0}, x[BALLS];
    draw_column(seed, q);
    regression(q, x);
    nsdae_sim *sim = make(system, NSDAE_METHOD_MOREAU, NSDAE_PROJECTION_NONE, DT);
    if (nsdae_sim_project(sim, 0, q, v) < 0) fail_msg("%s", nsdae_sim_error(sim)->text);
    for (int i = 0; i < BALLS; i++) assert_near(q[i], x[i], 1e-12 * BALLS);
    assert_int_equal(nsdae_sim_init(sim, 0, q, v), NSDAE_OK);
    nsdae_sim_destroy(&sim);
  }
  nsdae_system_destroy(&system);
}

/* A column that rests with overlaps: with contacts it ends on the surfaces, with depths it stays.
 */
static void test_depths(void **state)
{
  (void)state;
  fault none = {.at = 1L << 40};
  nsdae_system *system = column(&none);
  nsdae_system_set_force(system, weight);
  for (int i = 0; i < EACH; i++)
    for (int p = 1; p < EACH; p++) {
      double q[BALLS], v[BALLS] = {0};
      nsdae_record r;
      draw_column(9, q);
      for (int j = 0; j < BALLS; j++) q[j] = 0.9 * j - 0.1;
      nsdae_sim *sim = make(system, methods[i], projections[p], DT);
      assert_true(nsdae_sim_init(sim, 0, q, v) >= 0);
      assert_true(nsdae_sim_step(sim) >= 0);
      nsdae_sim_get_record(sim, &r);
      assert_int_equal(r.contacts.count, BALLS);
      for (int j = 0; j < BALLS; j++) {
        double gap = projections[p] == NSDAE_PROJECTION_DEPTHS ? -0.1 : 0;
        assert_near(r.contacts.gap[j], gap, 1e-13 * BALLS);
        assert_near(r.q[j], (1 + gap) * j + gap, 1e-12 * BALLS);
      }
      nsdae_sim_destroy(&sim);
    }
  nsdae_system_destroy(&system);
}

/* Event starts at gaps >= 0: within start_tol by the same regression, beyond it is refused. */
static void test_event(void **state)
{
  (void)state;
  fault none = {.at = 1L << 40};
  nsdae_system *system = column(&none);
  nsdae_sim_options options;
  nsdae_sim *sim;
  double q[BALLS], v[BALLS] = {0}, x[BALLS];
  nsdae_record r;
  nsdae_sim_options_default(&options);
  options.method = NSDAE_METHOD_EVENT;
  draw_column(12, q);
  for (int i = 0; i < BALLS; i++) q[i] = 1.5 * i + (i % 3 ? 1e-7 * (q[i] - i) - 0.5 * (i % 3) : 0);
  regression(q, x);
  int status = nsdae_sim_create(system, &options, &sim, NULL);
  if (status == NSDAE_OK) {
    if (nsdae_sim_init(sim, 0, q, v) < 0) fail_msg("%s", nsdae_sim_error(sim)->text);
    nsdae_sim_get_record(sim, &r);
    for (int i = 0; i < BALLS; i++) assert_near(r.q[i], x[i], 1e-12 * BALLS);
    q[40] = q[39] + 0.9;
    assert_int_equal(nsdae_sim_init(sim, 0, q, v), NSDAE_E_ARGUMENT);
    assert_non_null(strstr(nsdae_sim_error(sim)->text, "contact of id 87 overlaps by 0.1"));
    assert_int_equal(nsdae_sim_project(sim, 0, q, v), NSDAE_OK);
    assert_int_equal(nsdae_sim_init(sim, 0, q, v), NSDAE_OK);
    nsdae_sim_destroy(&sim);
  }
  nsdae_system_destroy(&system);
}

/* ---- what can go wrong */

static void expect(const fault *f, int contacts_max, int status, const char *argument,
                   const char *text)
{
  nsdae_sim_options options;
  double q[BALLS], v[BALLS] = {0}, before[BALLS];
  draw_column(4, q);
  memcpy(before, q, sizeof q);
  fault model = *f;
  nsdae_system *system = column(&model);
  nsdae_sim *sim;
  nsdae_sim_options_default(&options);
  options.contacts_max = contacts_max;
  assert_int_equal(nsdae_sim_create(system, &options, &sim, NULL), NSDAE_OK);
  assert_int_equal(nsdae_sim_project(sim, 0, q, v), status);
  const nsdae_error *error = nsdae_sim_error(sim);
  if (strcmp(error->argument, argument) != 0 || !strstr(error->text, text))
    fail_msg("%s: %s", error->argument, error->text);
  assert_memory_equal(q, before, sizeof q);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
}

static void test_faults(void **state)
{
  (void)state;
  for (long at = 0; at < 8; at++) {
    expect(&(fault){.at = at, .id = 7}, 1000, NSDAE_E_ARGUMENT, "id", "the id 7 ");
    expect(&(fault){.at = at, .code = -3}, 1000, NSDAE_E_CALLBACK, "contacts", "returned -3");
    expect(&(fault){.at = at, .code = 2}, 1000, NSDAE_E_CALLBACK, "contacts", "returned 2");
    expect(&(fault){.at = at, .gap = NAN}, 1000, NSDAE_E_NONFINITE, "gap", "contact of id 127");
  }
  expect(&(fault){.at = 1000}, 10, NSDAE_E_ARGUMENT, "contacts_max", "more than contacts_max = 10");
}

/* A disc between two walls that leave no room, and one that is not put right by its start. */
static int walls(double t, const double *q, const double *v, double reach, nsdae_contact_list *list,
                 void *user)
{
  (void)t, (void)v, (void)user;
  for (int i = 0; i < 2; i++) {
    nsdae_contact c = {.id = 31 + i, .block = {0, -1}, .gap = i ? -0.5 - q[0] : q[0]};
    c.direction[0][0][0] = i ? -1 : 1;
    if (c.gap <= reach) nsdae_contact_add(list, &c);
  }
  return 0;
}

static int one_mass(double t, const double *q, double *M, void *user)
{
  (void)t, (void)q, (void)user;
  M[0] = 1;
  return 0;
}

static void test_no_room(void **state)
{
  (void)state;
  const int one = 1;
  double q[1] = {-0.1}, v[1] = {0.3};
  nsdae_system *s;
  nsdae_sim *sim;
  assert_int_equal(nsdae_system_create(&(nsdae_dims){.nq = 1}, &s, NULL), NSDAE_OK);
  nsdae_system_set_blocks(s, 1, &one, &one);
  nsdae_system_set_mass_blocks(s, one_mass);
  nsdae_system_set_force(s, no_force);
  nsdae_system_set_contacts(s, walls);
  nsdae_sim_options o;
  nsdae_sim_options_default(&o);
  for (int slop = 0; slop < 2; slop++) {
    o.projection = slop ? NSDAE_PROJECTION_SLOP : NSDAE_PROJECTION_NONE;
    assert_int_equal(nsdae_sim_create(s, &o, &sim, NULL), NSDAE_OK);
    assert_int_equal(nsdae_sim_project(sim, 0, q, v), NSDAE_E_CONVERGENCE);
    assert_non_null(strstr(nsdae_sim_error(sim)->text, "contact of id 3"));
    assert_true(q[0] == -0.1 && v[0] == 0.3);
    assert_int_equal(nsdae_sim_init(sim, 0, q, v), slop ? NSDAE_E_ARGUMENT : NSDAE_OK);
    if (!slop) assert_int_equal(nsdae_sim_step(sim), NSDAE_WARN_PENETRATION); /* of the start */
    assert_non_null(strstr(nsdae_sim_error(sim)->text, "contact of id 32 overlaps by 0.4"));
    nsdae_sim_destroy(&sim);
  }
  nsdae_system_destroy(&s);
}

/* ---- state and memory */

/* Saved half way and taken up by another simulation, whose lists have less room: the same bytes. */
static void test_restart(void **state)
{
  static twin t;
  (void)state;
  for (int kind = 1; kind < KINDS; kind++)
    for (int i = 0; i < EACH * EACH; i++) {
      twin_draw(&t, 3500 + (uint64_t)kind, &kinds[kind]);
      nsdae_system *s = twin_blocks(&t);
      nsdae_sim *sim[2];
      nsdae_record r[2];
      for (int n = 0; n < 2; n++) sim[n] = make(s, methods[i / EACH], projections[i % EACH], DT);
      assert_true(nsdae_sim_init(sim[0], 0, t.q0, t.v0) >= 0);
      for (int n = 0; n < STEPS; n++) assert_true(nsdae_sim_step(sim[0]) >= 0);
      size_t size = 0;
      assert_int_equal(nsdae_sim_state_size(sim[0], &size), NSDAE_OK);
      void *block = malloc(size);
      assert_int_equal(nsdae_sim_get_state(sim[0], block, size), NSDAE_OK);
      assert_int_equal(nsdae_sim_set_state(sim[1], block, size), NSDAE_OK);
      for (int n = 0; n < 2; n++) {
        for (int j = 0; j < STEPS; j++) assert_true(nsdae_sim_step(sim[n]) >= 0);
        nsdae_sim_get_record(sim[n], &r[n]);
      }
      assert_memory_equal(r[0].q, r[1].q, (size_t)t.nv * sizeof(double));
      assert_memory_equal(r[0].v, r[1].v, (size_t)t.nv * sizeof(double));
      for (int n = 0; n < 2; n++) nsdae_sim_destroy(&sim[n]);
      nsdae_system_destroy(&s);
      free(block);
    }
}

/* Steps do not allocate unless their lists grow, or a sparse island or projection has a new
 * pattern; every lost allocation is survived and leaks nothing. */
static int life(twin *t, int method, int projection)
{
  nsdae_sim_options options;
  nsdae_sim *sim = NULL;
  nsdae_stats before, after;
  nsdae_system *system = twin_blocks(t);
  int dense = t->nv + t->m < 80;
  nsdae_sim_options_default(&options);
  options.method = method;
  options.projection = projection;
  options.dt = DT;
  options.start_tol = 1;
  if (!system) return NSDAE_E_MEMORY;
  int status = nsdae_sim_create(system, &options, &sim, NULL);
  if (status == NSDAE_OK) status = nsdae_sim_init(sim, 0, t->q0, t->v0);
  for (int n = 0; n < STEPS && status >= 0; n++) {
    long calls = the_allocator.calls;
    nsdae_sim_get_stats(sim, &before);
    status = nsdae_sim_step(sim);
    nsdae_sim_get_stats(sim, &after);
    int grew = before.contact_growths != after.contact_growths;
    if (status >= 0 && dense && !grew) assert_int_equal(the_allocator.calls, calls);
  }
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  return status < 0 ? status : NSDAE_OK;
}

static void test_allocations(void **state)
{
  static twin t;
  (void)state;
  for (int kind = 1; kind < KINDS; kind++)
    for (int i = 0; i < EACH * EACH; i++) {
      int status = NSDAE_E_MEMORY;
      long tried = -1;
      twin_draw(&t, 3600 + (uint64_t)kind, &kinds[kind]);
      for (; status < 0; tried++) {
        allocator_reset(tried);
        status = life(&t, methods[i / EACH], projections[i % EACH]);
        if (status != NSDAE_OK) assert_int_equal(status, NSDAE_E_MEMORY);
        assert_int_equal(the_allocator.live, 0);
        if (tried < 0) status = NSDAE_E_MEMORY; /* the first loses none */
      }
      allocator_reset(-1);
    }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_twins),   cmocka_unit_test(test_random),
      cmocka_unit_test(test_rod),     cmocka_unit_test(test_columns),
      cmocka_unit_test(test_depths),  cmocka_unit_test(test_event),
      cmocka_unit_test(test_faults),  cmocka_unit_test(test_no_room),
      cmocka_unit_test(test_restart), cmocka_unit_test(test_allocations)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
