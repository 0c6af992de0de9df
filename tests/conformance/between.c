/* What runs need, on every method: the state within a step, settings that change between steps,
 * runs that stop at events, users of a simulation's own, means of the record. */
#include "check.h"

#include <stdlib.h>

#include <nsdae/nsdae.h>

/* A ball over a floor, z'' = -g (1 + c sin t), and how often it asked; user: ball. */
typedef struct ball {
  double gravity;
  long calls;
} ball;

static int mass(double t, const double *q, double *M, int ldm, void *user)
{
  (void)t;
  (void)q;
  (void)user;
  M[0] = M[ldm + 1] = 2;
  return 0;
}

static int force(double t, const double *q, const double *v, double *F, void *user)
{
  ball *b = user;
  (void)t;
  (void)q;
  (void)v;
  b->calls++;
  F[1] = -2 * b->gravity;
  return 0;
}

static int gap(double t, const double *q, double *g, void *user)
{
  (void)t;
  (void)user;
  g[0] = q[1];
  return 0;
}

static int normal(double t, const double *q, double *W, int ldw, void *user)
{
  (void)t;
  (void)q;
  (void)user;
  (void)ldw;
  W[1] = 1;
  return 0;
}

static int tangent(double t, const double *q, double *W, int ldw, void *user)
{
  (void)t;
  (void)q;
  (void)user;
  (void)ldw;
  W[0] = 1;
  return 0;
}

static nsdae_system *make_system(ball *b)
{
  nsdae_system *system = NULL;
  const nsdae_dims dims = {.nq = 2, .k = 1, .nt = 1};
  assert_int_equal(nsdae_system_create(&dims, &system, NULL), NSDAE_OK);
  nsdae_system_set_user(system, b);
  nsdae_system_set_mass(system, mass);
  nsdae_system_set_force(system, force);
  nsdae_system_set_gap(system, gap);
  nsdae_system_set_gap_normal(system, normal);
  nsdae_system_set_gap_tangent(system, tangent);
  assert_int_equal(nsdae_system_set_contact(system, 0, 0.2, 0.5, 0), NSDAE_OK);
  return system;
}

static nsdae_sim_options options_of(int method)
{
  nsdae_sim_options o;
  nsdae_sim_options_default(&o);
  o.method = method;
  o.dt = 0.01;
  o.penalty_stiffness = 1e6;
  o.penalty_law = NSDAE_PENALTY_KELVIN_VOIGT; /* gives the restitution asked, up to 0.14 */
  return o;
}

/* NULL where the method is not built; from height h with velocity u along the floor. */
static nsdae_sim *make(nsdae_system *system, const nsdae_sim_options *o, double h, double u)
{
  nsdae_sim *sim = NULL;
  const double q0[] = {0, h}, v0[] = {u, 0};
  int status = nsdae_sim_create(system, o, &sim, NULL);
  if (status == NSDAE_E_UNSUPPORTED) return NULL;
  assert_int_equal(status, NSDAE_OK);
  assert_int_equal(nsdae_sim_init(sim, 0, q0, v0), NSDAE_OK);
  return sim;
}

static void each(void (*f)(nsdae_system *system, ball *b, nsdae_sim_options o))
{
  for (int method = 0; nsdae_method_name(method); method++) {
    ball b = {.gravity = 9.81};
    nsdae_system *system = make_system(&b);
    f(system, &b, options_of(method));
    nsdae_system_destroy(&system);
  }
}

/* A fall is q = h - g t^2 / 2: the parabola's own, so that every method has it but for its order.
 */
static void fall(nsdae_system *system, ball *b, nsdae_sim_options o)
{
  double q[2], v[2], first = o.method == NSDAE_METHOD_MOREAU ? 0.5 * 9.81 * o.dt * o.dt : 0;
  nsdae_sim *sim = make(system, &o, 10, 1);
  nsdae_record r;
  (void)b;
  if (!sim) return;
  assert_int_equal(nsdae_sim_interpolate(sim, 0, q, v), NSDAE_E_STATE);
  for (int s = 0; s < 20; s++) assert_int_equal(nsdae_sim_step(sim), NSDAE_OK);
  nsdae_sim_get_record(sim, &r);
  assert_near(r.duration, o.dt, 1e-15);
  assert_near(r.acceleration[0], 0, 1e-10);
  assert_near(r.acceleration[1], -9.81, 1e-6);
  for (int i = 0; i <= 10; i++) {
    double t = r.time - o.dt + i * o.dt / 10;
    if (i == 10) t = r.time;
    assert_int_equal(nsdae_sim_interpolate(sim, t, q, v), NSDAE_OK);
    assert_near(q[0], t, 1e-9);
    assert_near(q[1], 10 - 9.81 * t * t / 2, 1e-6 + 21 * first); /* 100 rtol */
    assert_near(v[1], -9.81 * t, 1e-6);
  }
  assert_memory_equal(q, r.q, sizeof q);
  assert_memory_equal(v, r.v, sizeof v);
  assert_int_equal(nsdae_sim_interpolate(sim, r.time + 1e-6, q, v), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_sim_interpolate(sim, r.time - 2 * o.dt, q, v), NSDAE_E_ARGUMENT);
  assert_string_equal(nsdae_sim_error(sim)->argument, "t");
  nsdae_sim_destroy(&sim);
}

static void test_fall(void **state)
{
  (void)state;
  each(fall);
}

/* The observer asks for what is within the step that it sees, through impacts: the run does not
 * notice. */
typedef struct asking {
  nsdae_sim *sim;
  double last;
  int asked;
} asking;

static int ask(const nsdae_record *r, nsdae_error *error, void *user)
{
  asking *a = user;
  double q[2], v[2];
  (void)error;
  if (r->step > 0) {
    for (int i = 0; i < 3; i++) {
      double t = a->last + (r->time - a->last) * (i + 1) / 4;
      assert_int_equal(nsdae_sim_interpolate(a->sim, t, q, v), NSDAE_OK);
      assert_true(isfinite(q[0]) && q[1] > -0.2 && fabs(v[1]) < 10);
      a->asked++;
    }
    assert_int_equal(nsdae_sim_step(a->sim), NSDAE_E_STATE); /* not from here */
  }
  a->last = r->time;
  return 0;
}

static void undisturbed(nsdae_system *system, ball *b, nsdae_sim_options o)
{
  nsdae_record r, other;
  double q[2];
  (void)b;
  nsdae_sim *sim = make(system, &o, 0.3, 1);
  if (!sim) return;
  nsdae_sim *asked = make(system, &o, 0.3, 1);
  asking a = {.sim = asked};
  assert_int_equal(nsdae_sim_observe(asked, ask, &a), NSDAE_OK);
  assert_int_equal(nsdae_sim_run(sim, 0.9), NSDAE_OK);
  assert_int_equal(nsdae_sim_run(asked, 0.9), NSDAE_OK);
  nsdae_sim_get_record(sim, &r);
  memcpy(q, r.q, sizeof q);
  nsdae_sim_get_record(asked, &other);
  assert_int_equal(a.asked, 3 * other.step);
  assert_memory_equal(other.q, q, sizeof q);
  assert_memory_equal(other.v, r.v, sizeof q);
  nsdae_sim_destroy(&sim);
  nsdae_sim_destroy(&asked);
}

static void test_undisturbed(void **state)
{
  (void)state;
  each(undisturbed);
}

/* It stops after the first impact, and then after the second. */
static void to_event(nsdae_system *system, ball *b, nsdae_sim_options o)
{
  nsdae_record r;
  nsdae_sim *sim = make(system, &o, 1, 0);
  if (!sim) return;
  double first = sqrt(2 / b->gravity), second = first + 2 * 0.5 * b->gravity * first / b->gravity;
  const double at[] = {first, second};
  for (int i = 0; i < 2; i++) {
    int status = nsdae_sim_run_to_event(sim, 5);
    assert_int_equal(status, NSDAE_EVENT);
    nsdae_sim_get_record(sim, &r);
    assert_int_equal(r.impacts, 1);
    /* the restitution of a continuous contact is only about e */
    if (i == 0 || o.method != NSDAE_METHOD_PENALTY) assert_near(r.time, at[i], 3 * o.dt);
  }
  assert_int_equal(nsdae_sim_run_to_event(sim, r.time + 3 * o.dt), NSDAE_OK);
  assert_int_equal(nsdae_sim_run_to_event(sim, 0), NSDAE_E_ARGUMENT);
  assert_string_equal(nsdae_sim_error(sim)->where, "nsdae_sim_run_to_event");
  nsdae_sim_destroy(&sim);
}

static void test_to_event(void **state)
{
  (void)state;
  each(to_event);
}

/* A user of its own: other gravity, and it alone is asked. */
static void user(nsdae_system *system, ball *b, nsdae_sim_options o)
{
  ball own = {.gravity = 1.62};
  nsdae_record r;
  nsdae_sim *sim = make(system, &o, 10, 0);
  if (!sim) return;
  const double q0[] = {0, 10}, v0[] = {0, 0};
  assert_int_equal(nsdae_sim_set_user(sim, &own), NSDAE_OK);
  assert_int_equal(nsdae_sim_init(sim, 0, q0, v0), NSDAE_OK);
  long before = b->calls;
  assert_int_equal(nsdae_sim_run(sim, 0.5), NSDAE_OK);
  nsdae_sim_get_record(sim, &r);
  assert_near(r.v[1], -1.62 * 0.5, 1e-7);
  assert_int_equal(b->calls, before);
  assert_true(own.calls > 0);
  nsdae_sim_destroy(&sim);
}

static void test_user(void **state)
{
  (void)state;
  each(user);
}

/* dt, tolerances and coefficients changed on the way: the motion is that of the new ones, and a
 * state taken afterwards goes on with the same bytes. */
static void settings(nsdae_system *system, ball *b, nsdae_sim_options o)
{
  nsdae_record r;
  size_t size;
  (void)b;
  nsdae_sim *sim = make(system, &o, 0.5, 1);
  if (!sim) return;
  assert_int_equal(nsdae_sim_run(sim, 0.2), NSDAE_OK);
  nsdae_sim_options finer = o;
  finer.dt = o.dt / 4;
  finer.rtol = 1e-7;
  finer.contact_tol = 1e-9;
  assert_int_equal(nsdae_sim_set_options(sim, &finer), NSDAE_OK);
  assert_int_equal(nsdae_sim_set_contact(sim, 0, 0.1, 0, 0), NSDAE_OK);
  assert_true(nsdae_sim_step(sim) >= 0);
  nsdae_sim_get_record(sim, &r);
  assert_near(r.time, 0.2 + finer.dt, 1e-15);
  assert_near(r.q[1], 0.5 - 9.81 * r.time * r.time / 2, 0.02);

  nsdae_sim *other = make(system, &finer, 1, 0);
  assert_int_equal(nsdae_sim_set_contact(other, 0, 0.1, 0, 0), NSDAE_OK);
  nsdae_sim_state_size(sim, &size);
  unsigned char *block = malloc(size), *end = malloc(size);
  assert_true(block && end);
  assert_int_equal(nsdae_sim_get_state(sim, block, size), NSDAE_OK);
  assert_int_equal(nsdae_sim_set_state(other, block, size), NSDAE_OK);
  assert_int_equal(nsdae_sim_run(sim, 1), NSDAE_OK);
  assert_int_equal(nsdae_sim_run(other, 1), NSDAE_OK);
  nsdae_sim_get_state(sim, block, size);
  nsdae_sim_get_state(other, end, size);
  assert_memory_equal(block, end, size);

  /* mu 0.1 and e = 0: it slides on, and loses mu (g t + the impact) of its speed */
  nsdae_sim_get_record(sim, &r);
  double hit = sqrt(2 * 0.5 / 9.81);
  double lost = 0.1 * (9.81 * hit + 9.81 * (r.time - hit));
  if (o.method != NSDAE_METHOD_PENALTY) assert_near(r.v[0], fmax(0, 1 - lost), 0.02);
  assert_at_most(fabs(r.q[1]), 0.05);

  finer.polygon = 16;
  assert_int_equal(nsdae_sim_set_options(sim, &finer), NSDAE_E_ARGUMENT);
  assert_string_equal(nsdae_sim_error(sim)->argument, "polygon");
  finer.polygon = o.polygon;
  finer.dt = -1;
  assert_int_equal(nsdae_sim_set_options(sim, &finer), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_sim_set_options(sim, NULL), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_sim_set_contact(sim, 1, 0, 0, 0), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_sim_set_contact(sim, 0, NAN, 0, 0), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_sim_set_contact(sim, 0, 0.1, 2, 0), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_sim_set_frictional_joint(sim, 0, 0.1), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_sim_set_contact(sim, 0, 0, 0.5, 0), NSDAE_OK); /* no friction any more */
  assert_true(nsdae_sim_step(sim) >= 0);
  nsdae_sim_get_state(sim, block, size);
  assert_int_equal(nsdae_sim_set_state(other, block, size), NSDAE_E_ARGUMENT);
  assert_string_equal(nsdae_sim_error(other)->argument, "mu");
  free(block);
  free(end);
  nsdae_sim_destroy(&sim);
  nsdae_sim_destroy(&other);
}

static void test_settings(void **state)
{
  (void)state;
  each(settings);
}

/* Settings that the method cannot take, and a state that cannot be settled, leave the old ones. */
static void refused_settings(nsdae_system *system, ball *b, nsdae_sim_options o)
{
  size_t size;
  (void)b;
  nsdae_sim *sim = make(system, &o, 0.5, 1);
  if (!sim) return;
  assert_int_equal(nsdae_sim_run(sim, 0.35), NSDAE_OK);
  nsdae_sim_state_size(sim, &size);
  unsigned char *before = malloc(size), *after = malloc(size);
  assert_true(before && after);
  if (o.method == NSDAE_METHOD_PENALTY) { /* the law flores divides by e_N */
    nsdae_sim_options flores = o;
    flores.penalty_law = NSDAE_PENALTY_FLORES;
    assert_int_equal(nsdae_sim_set_options(sim, &flores), NSDAE_OK);
    nsdae_sim_get_state(sim, before, size);
    assert_int_equal(nsdae_sim_set_contact(sim, 0, 0.1, 0, 0), NSDAE_E_ARGUMENT);
    assert_string_equal(nsdae_sim_error(sim)->argument, "e_n");
    assert_int_equal(nsdae_sim_set_options(sim, &o), NSDAE_OK);
    assert_int_equal(nsdae_sim_set_contact(sim, 0, 0.1, 0, 0), NSDAE_OK);
    assert_int_equal(nsdae_sim_set_options(sim, &flores), NSDAE_E_ARGUMENT);
    assert_string_equal(nsdae_sim_error(sim)->argument, "e_n");
  }
  nsdae_sim_get_state(sim, before, size);
  nsdae_sim_options same = o;
  assert_int_equal(nsdae_sim_set_contact(sim, -1, 0, 0, 0), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_sim_set_contact(sim, 0, INFINITY, 0, 0), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_sim_set_contact(sim, 0, -0.1, 0, 0), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_sim_set_contact(sim, 0, 0.1, -1, 0), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_sim_set_contact(sim, 0, 0.1, 0, -1), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_sim_set_contact(sim, 0, 0.1, 0, 1.5), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_sim_set_frictional_joint(sim, -1, 0.1), NSDAE_E_ARGUMENT);
  same.method = o.method == NSDAE_METHOD_MOREAU ? NSDAE_METHOD_IMPLICIT : NSDAE_METHOD_MOREAU;
  assert_int_equal(nsdae_sim_set_options(sim, &same), NSDAE_E_ARGUMENT);
  assert_string_equal(nsdae_sim_error(sim)->argument, "method");
  nsdae_sim_get_state(sim, after, size);
  assert_memory_equal(before, after, size);
  assert_true(nsdae_sim_step(sim) >= 0);
  free(before);
  free(after);
  nsdae_sim_destroy(&sim);
}

/* None of these is for an observer, nor for no simulation at all. */
static int meddle(const nsdae_record *r, nsdae_error *error, void *user)
{
  nsdae_sim *sim = user;
  nsdae_sim_options o = options_of(NSDAE_METHOD_MOREAU);
  double q[2] = {0, 1}, v[2] = {0, 0};
  (void)r;
  (void)error;
  assert_int_equal(nsdae_sim_set_user(sim, NULL), NSDAE_E_STATE);
  assert_int_equal(nsdae_sim_set_options(sim, &o), NSDAE_E_STATE);
  assert_int_equal(nsdae_sim_set_contact(sim, 0, 0, 0, 0), NSDAE_E_STATE);
  assert_int_equal(nsdae_sim_set_frictional_joint(sim, 0, 0), NSDAE_E_STATE);
  assert_int_equal(nsdae_sim_set_state(sim, q, sizeof q), NSDAE_E_STATE);
  assert_int_equal(nsdae_sim_init(sim, 0, q, v), NSDAE_E_STATE);
  assert_int_equal(nsdae_sim_run(sim, 9), NSDAE_E_STATE);
  return 0;
}

static void test_refused_settings(void **state)
{
  (void)state;
  double q[2], v[2];
  size_t size;
  each(refused_settings);
  assert_int_equal(nsdae_sim_set_user(NULL, NULL), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_sim_set_options(NULL, NULL), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_sim_set_contact(NULL, 0, 0, 0, 0), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_sim_set_frictional_joint(NULL, 0, 0), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_sim_interpolate(NULL, 0, q, v), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_sim_state_size(NULL, &size), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_sim_get_state(NULL, q, sizeof q), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_sim_set_state(NULL, q, sizeof q), NSDAE_E_ARGUMENT);
  assert_int_equal(nsdae_sim_run_to_event(NULL, 1), NSDAE_E_ARGUMENT);
  ball b = {.gravity = 9.81};
  nsdae_system *system = make_system(&b);
  nsdae_sim_options o = options_of(NSDAE_METHOD_MOREAU);
  nsdae_sim *sim = make(system, &o, 1, 0);
  assert_int_equal(nsdae_sim_observe(sim, meddle, sim), NSDAE_OK);
  for (int s = 0; s < 2; s++) assert_true(nsdae_sim_step(sim) >= 0);
  assert_int_equal(nsdae_sim_interpolate(sim, 0, NULL, v), NSDAE_E_ARGUMENT);
  assert_string_equal(nsdae_sim_error(sim)->argument, "q");
  assert_int_equal(nsdae_sim_interpolate(sim, 0, q, NULL), NSDAE_E_ARGUMENT);
  assert_string_equal(nsdae_sim_error(sim)->argument, "v");
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
}

/* A slide in this simulation: its friction is another, or stays out. */
static int slot(double t, const double *q, double *phi, void *user)
{
  (void)t;
  (void)user;
  phi[0] = q[1];
  return 0;
}

static int along(double t, const double *q, double *W, int ldw, double *w, void *user)
{
  (void)t;
  (void)q;
  (void)ldw;
  (void)user;
  (void)w;
  W[0] = 1;
  return 0;
}

static void test_slides(void **state)
{
  const nsdae_dims dims = {.nq = 2, .m = 1, .f = 1};
  const double q0[] = {0, 0}, v0[] = {3, 0};
  (void)state;
  for (int method = 0; nsdae_method_name(method); method++) {
    ball b = {.gravity = 9.81};
    nsdae_system *system = NULL;
    nsdae_sim *sim = NULL;
    nsdae_record r;
    nsdae_sim_options o = options_of(method);
    assert_int_equal(nsdae_system_create(&dims, &system, NULL), NSDAE_OK);
    nsdae_system_set_user(system, &b);
    nsdae_system_set_mass(system, mass);
    nsdae_system_set_force(system, force);
    nsdae_system_set_constraint(system, slot);
    nsdae_system_set_frictional_joint_tangent(system, along);
    nsdae_system_set_frictional_joint(system, 0, 0, 0.2);
    if (nsdae_sim_create(system, &o, &sim, NULL) == NSDAE_OK) {
      assert_int_equal(nsdae_sim_set_frictional_joint(sim, 1, 0.1), NSDAE_E_ARGUMENT);
      assert_int_equal(nsdae_sim_set_frictional_joint(sim, 0, 0), NSDAE_E_ARGUMENT);
      assert_int_equal(nsdae_sim_set_frictional_joint(sim, 0, NAN), NSDAE_E_ARGUMENT);
      assert_non_null(strstr(nsdae_sim_error(sim)->text, "frictional joint 0"));
      assert_int_equal(nsdae_sim_init(sim, 0, q0, v0), NSDAE_OK);
      assert_int_equal(nsdae_sim_run(sim, 0.3), NSDAE_OK);
      assert_int_equal(nsdae_sim_set_frictional_joint(sim, 0, 0.1), NSDAE_OK);
      assert_int_equal(nsdae_sim_run(sim, 0.6), NSDAE_OK);
      nsdae_sim_get_record(sim, &r); /* braked by 0.2 g, then by 0.1 g */
      assert_near(r.v[0], 3 - 0.3 * 9.81 * (0.2 + 0.1), 1e-3);
      nsdae_sim_destroy(&sim);
    }
    nsdae_system_destroy(&system);
  }
}

/* Between impacts the parabola through a step is of third order in q and of second in v
 * (the straight line), the integrators' own solution is to their tolerance: a pendulum's swing. */
static int swing_force(double t, const double *q, const double *v, double *F, void *user)
{
  (void)t;
  (void)v;
  (void)user;
  F[0] = -2 * 9.0 * q[0]; /* M = 2: q = cos 3 t */
  F[1] = -2 * 9.0 * q[1];
  return 0;
}

static void worst_between(nsdae_sim *sim, double worst[2])
{
  const double q0[] = {1, 0}, v0[] = {0, 3};
  nsdae_record r;
  worst[0] = worst[1] = 0;
  assert_int_equal(nsdae_sim_init(sim, 0, q0, v0), NSDAE_OK);
  while (nsdae_sim_get_record(sim, &r), r.time < 0.5) {
    assert_int_equal(nsdae_sim_step(sim), NSDAE_OK);
    nsdae_sim_get_record(sim, &r);
    double start = r.time - r.duration, q[2], v[2], h = r.duration;
    double at[2], left[2]; /* errors of the ends, which are the method's, taken off by lines */
    for (int e = 0; e < 2; e++) {
      double t = e ? r.time : start;
      assert_int_equal(nsdae_sim_interpolate(sim, t, q, v), NSDAE_OK);
      (e ? left : at)[0] = q[0] - cos(3 * t);
      (e ? left : at)[1] = v[0] + 3 * sin(3 * t);
    }
    for (int i = 1; i < 8; i++) {
      double s = i / 8.0, t = start + s * h;
      assert_int_equal(nsdae_sim_interpolate(sim, t, q, v), NSDAE_OK);
      double of_q = q[0] - cos(3 * t) - (1 - s) * at[0] - s * left[0];
      double of_v = v[0] + 3 * sin(3 * t) - (1 - s) * at[1] - s * left[1];
      worst[0] = fmax(worst[0], fabs(of_q));
      worst[1] = fmax(worst[1], fabs(of_v));
    }
  }
}

static void test_order_between(void **state)
{
  const nsdae_dims dims = {.nq = 2};
  (void)state;
  for (int method = 0; nsdae_method_name(method); method++) {
    double coarse[2], fine[2];
    nsdae_system *system = NULL;
    nsdae_sim *sim = NULL;
    nsdae_sim_options o = options_of(method);
    assert_int_equal(nsdae_system_create(&dims, &system, NULL), NSDAE_OK);
    nsdae_system_set_mass(system, mass);
    nsdae_system_set_force(system, swing_force);
    o.dt = 0.02;
    if (nsdae_sim_create(system, &o, &sim, NULL) == NSDAE_OK) {
      worst_between(sim, coarse);
      o.dt = 0.01;
      assert_int_equal(nsdae_sim_set_options(sim, &o), NSDAE_OK);
      worst_between(sim, fine);
      nsdae_sim_destroy(&sim);
      print_message("%s: %.2g %.2g, %.2g %.2g\n", nsdae_method_name(method), coarse[0], fine[0],
                    coarse[1], fine[1]);
      if (method >= NSDAE_METHOD_PENALTY) {
        assert_at_most(fine[0], 100 * o.rtol);
        assert_at_most(fine[1], 300 * o.rtol);
      } else {
        double order_q = log2(coarse[0] / fine[0]), order_v = log2(coarse[1] / fine[1]);
        assert_near(order_v, 2, 0.1);
        assert_near(order_q, 3, 0.2);
      }
    }
    nsdae_system_destroy(&system);
  }
}

/* Ball A falls onto the floor and its accumulation is closed at once; in the next dt ball B, kicked
 * then, hits two walls by turns more often than events_max allows, and the step is implicit's: what
 * is told of it is nothing of the step before. */
static int push(double t, const double *q, const double *v, double *F, void *user)
{
  const double *kick = user; /* from when on */
  (void)q;
  (void)v;
  F[0] = -2 * 9.81;
  F[1] = 2e6 * fmin(1, fmax(0, (t - *kick) / 0.001));
  return 0;
}

static int three_gaps(double t, const double *q, double *g, void *user)
{
  (void)t;
  (void)user;
  g[0] = q[0];
  g[1] = 0.25 - q[1];
  g[2] = 0.25 + q[1];
  return 0;
}

static int plain_mass(double t, const double *q, double *M, int ldm, void *user)
{
  (void)t;
  (void)q;
  (void)user;
  M[0] = M[ldm + 1] = 2;
  return 0;
}

static nsdae_system *balls_between(double *kick)
{
  const nsdae_dims dims = {.nq = 2, .k = 3};
  nsdae_system *system = NULL;
  assert_int_equal(nsdae_system_create(&dims, &system, NULL), NSDAE_OK);
  nsdae_system_set_user(system, kick);
  nsdae_system_set_mass(system, plain_mass);
  nsdae_system_set_force(system, push);
  nsdae_system_set_gap(system, three_gaps);
  nsdae_system_set_contact(system, 0, 0, 0.5, 0);
  nsdae_system_set_contact(system, 1, 0, 1, 0);
  nsdae_system_set_contact(system, 2, 0, 1, 0);
  return system;
}

static nsdae_sim_options few_events(void)
{
  nsdae_sim_options o = options_of(NSDAE_METHOD_EVENT);
  o.dt = 0.02;
  o.events_max = 1;
  o.accumulation_time = 0.5;
  return o;
}

/* A step says NSDAE_ZENO where it closed an accumulation, and only there; of these runs every one
 * has a step by implicit, and 4 of the 12 said it falsely while a step's results were left over. */
static void test_accumulations_are_the_steps_own(void **state)
{
  const nsdae_sim_options o = few_events();
  const double v0[] = {0, 0};
  double kick = 0;
  nsdae_system *system = balls_between(&kick);
  nsdae_sim *sim = NULL;
  (void)state;
  for (int i = 0; i < 12; i++) {
    const double q0[] = {3e-3 * pow(3, i % 3), 0};
    nsdae_stats stats = {0};
    kick = 0.06 + 0.02 * (i / 3);
    if (nsdae_sim_create(system, &o, &sim, NULL) < 0) break; /* not built in */
    assert_int_equal(nsdae_sim_init(sim, 0, q0, v0), NSDAE_OK);
    for (int step = 0; step < 12; step++) {
      long before = stats.accumulations;
      int status = nsdae_sim_step(sim);
      nsdae_sim_get_stats(sim, &stats);
      assert_true(status >= 0 && (status == NSDAE_ZENO) == (stats.accumulations > before));
    }
    assert_true(stats.fallback_steps > 0);
    nsdae_sim_destroy(&sim);
  }
  nsdae_system_destroy(&system);
}

static void test_no_false_accumulation(void **state)
{
  const double q0[] = {1e-3, 0}, v0[] = {0, 0};
  double kick = 0.02;
  nsdae_system *system = balls_between(&kick);
  nsdae_sim *sim = NULL;
  nsdae_stats stats;
  const nsdae_sim_options o = few_events();
  (void)state;
  if (nsdae_sim_create(system, &o, &sim, NULL) == NSDAE_OK) {
    assert_int_equal(nsdae_sim_init(sim, 0, q0, v0), NSDAE_OK);
    assert_int_equal(nsdae_sim_step(sim), NSDAE_ZENO);
    for (int i = 1; i < 4; i++) {
      int status = nsdae_sim_step(sim);
      assert_true(status >= 0 && status != NSDAE_ZENO);
    }
    nsdae_sim_get_stats(sim, &stats);
    assert_int_equal(stats.accumulations, 1);
    assert_true(stats.fallback_steps >= 1);
    nsdae_sim_destroy(&sim);
  }
  nsdae_system_destroy(&system);
}

/* Forces are the impulses over the step, accelerations what they do: m a = F + W f. */
static void means(nsdae_system *system, ball *b, nsdae_sim_options o)
{
  nsdae_record r;
  nsdae_sim *sim = make(system, &o, 0.05, 1);
  if (!sim) return;
  for (int s = 0; s < 40; s++) {
    assert_true(nsdae_sim_step(sim) >= 0);
    nsdae_sim_get_record(sim, &r);
    assert_near(r.normal_force[0] * r.duration, r.normal_impulse[0], 1e-12);
    assert_near(r.tangential_force[0] * r.duration, r.tangential_impulse[0], 1e-12);
    double scale = 1e-6 * (1 + fabs(r.normal_force[0]));
    assert_near(2 * r.acceleration[0], r.tangential_force[0], scale);
    assert_near(2 * r.acceleration[1], r.normal_force[0] - 2 * b->gravity, scale);
  }
  nsdae_sim_destroy(&sim);
}

static void test_means(void **state)
{
  (void)state;
  each(means);
}

/* An observer that takes itself out costs the next one no record. */
typedef struct counted {
  nsdae_sim *sim;
  int records, leaves_at;
} counted;

static int count(const nsdae_record *r, nsdae_error *error, void *user)
{
  counted *c = user;
  (void)error;
  c->records++;
  if (r->step == c->leaves_at) assert_int_equal(nsdae_sim_unobserve(c->sim, count, c), NSDAE_OK);
  return 0;
}

static void test_leaving(void **state)
{
  ball b = {.gravity = 9.81};
  nsdae_system *system = make_system(&b);
  nsdae_sim_options o = options_of(NSDAE_METHOD_MOREAU);
  nsdae_sim *sim = make(system, &o, 1, 0);
  counted c[3] = {{sim, 0, -1}, {sim, 0, 5}, {sim, 0, -1}};
  (void)state;
  for (int i = 0; i < 3; i++) assert_int_equal(nsdae_sim_observe(sim, count, &c[i]), NSDAE_OK);
  for (int s = 0; s < 10; s++) assert_true(nsdae_sim_step(sim) >= 0);
  assert_int_equal(c[0].records, 11);
  assert_int_equal(c[1].records, 6);
  assert_int_equal(c[2].records, 11);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
}

/* Where a size is capped that is said, with the bound, and at once. */
static void test_limit(void **state)
{
  nsdae_error error;
  nsdae_sim *sim = NULL;
  nsdae_sim_options o = options_of(NSDAE_METHOD_MOREAU);
  const nsdae_dims most[] = {
      {.nq = 3, .k = 2001, .nt = 2}, {.nq = 3, .k = 1 << 20}, {.nq = 3, .k = 6667, .nt = 2}};
  const char *const rows[] = {"20010 rows", "1048576 rows", "20001 rows"};
  (void)state;
  for (int i = 0; i < 3; i++) {
    nsdae_system *system = NULL;
    assert_int_equal(nsdae_system_create(&most[i], &system, NULL), NSDAE_OK);
    nsdae_system_set_mass(system, mass);
    nsdae_system_set_force(system, force);
    nsdae_system_set_gap(system, gap);
    nsdae_system_set_gap_normal(system, normal);
    if (most[i].nt > 0) nsdae_system_set_gap_tangent(system, tangent);
    for (int j = 0; j < most[i].k && most[i].nt > 0; j++)
      nsdae_system_set_contact(system, j, 0.3, 0, 0);
    o.polygon = i == 0 ? 8 : 0;
    assert_int_equal(nsdae_sim_create(system, &o, &sim, &error), NSDAE_E_ARGUMENT);
    assert_string_equal(error.argument, "k");
    assert_non_null(strstr(error.text, rows[i]));
    assert_non_null(strstr(error.text, "the maximum 20000"));
    assert_null(sim);
    nsdae_system_destroy(&system);
  }
}

/* Steps that are no whole ones, where times are so large that dt has few digits of them: each is as
 * long as its times say, and the ball has come as far as the clock. */
static void part_steps(nsdae_system *system, ball *b, nsdae_sim_options o)
{
  const double late[][3] = {{1e9, 1e-6, 0.8}, {1e6, 1e-9, 0.6}, {1e3, 1e-2, 0.3}, {0, 1e-2, 0.7}};
  const double q0[] = {0, 10}, v0[] = {1, 0};
  if (o.method == NSDAE_METHOD_PENALTY || o.method == NSDAE_METHOD_EVENT) return;
  b->gravity = 0;
  for (int i = 0; i < 4; i++) {
    nsdae_sim *sim;
    nsdae_record r;
    double t = late[i][0];
    o.dt = late[i][1];
    assert_int_equal(nsdae_sim_create(system, &o, &sim, NULL), NSDAE_OK);
    assert_int_equal(nsdae_sim_init(sim, t, q0, v0), NSDAE_OK);
    for (int n = 1; n <= 100; n++)
      assert_int_equal(nsdae_sim_run(sim, t + n * late[i][2] * o.dt), NSDAE_OK);
    nsdae_sim_get_record(sim, &r);
    assert_true(r.time > t);
    assert_near(r.q[0], r.time - t, 1e-12 * (r.time - t));
    nsdae_sim_destroy(&sim);
  }
}

static void test_part_steps(void **state)
{
  (void)state;
  each(part_steps);
}

static int refuse_once(const nsdae_record *r, nsdae_error *error, void *user)
{
  int *left = user;
  (void)error;
  if (r->step != 1 || *left == 0) return 0;
  --*left;
  return NSDAE_E_IO;
}

/* A body that overlaps is warned of in the first step, which an observer refuses. Done again, or
 * another in its place, it is warned of there, at its own time; a start elsewhere is not warned of
 * what the dropped one did. */
static void refused_warning(nsdae_system *system, ball *b, nsdae_sim_options o)
{
  int left;
  nsdae_stats stats;
  (void)b;
  if (o.method == NSDAE_METHOD_PENALTY || o.method == NSDAE_METHOD_EVENT) return;
  o.start_tol = 1e300;
  o.projection = NSDAE_PROJECTION_NONE; /* it would be put right */
  for (int way = 0; way < 3; way++) {
    nsdae_sim *sim = make(system, &o, -0.5, 0);
    left = 1;
    assert_int_equal(nsdae_sim_observe(sim, refuse_once, &left), NSDAE_OK);
    assert_int_equal(nsdae_sim_step(sim), NSDAE_E_IO);
    nsdae_sim_get_stats(sim, &stats);
    assert_int_equal(stats.warnings, 0);
    if (way < 2) {
      int status = way == 0 ? nsdae_sim_step(sim) : nsdae_sim_run(sim, 0.4 * o.dt);
      assert_int_equal(status, NSDAE_WARN_PENETRATION);
      assert_near(nsdae_sim_error(sim)->time, way == 0 ? o.dt : 0.4 * o.dt, 1e-15);
    } else {
      assert_int_equal(nsdae_sim_init(sim, 0, (const double[]){0, 1}, (const double[]){0, 0}),
                       NSDAE_OK);
      assert_int_equal(nsdae_sim_step(sim), NSDAE_OK);
    }
    nsdae_sim_get_stats(sim, &stats);
    assert_int_equal(stats.warnings, way < 2 ? 2 : 0);
    assert_true(nsdae_sim_step(sim) < NSDAE_WARN_ENERGY); /* said once */
    nsdae_sim_destroy(&sim);
  }
}

static void test_refused_warning(void **state)
{
  (void)state;
  each(refused_warning);
}

/* Two constraints that are one until t = 0.1: x = 0, x + a(t) y = 0. */
static double slope(double t)
{
  return t > 0.1 ? t - 0.1 : 0;
}

static int constraints(double t, const double *q, double *phi, void *user)
{
  (void)user;
  phi[0] = q[0];
  phi[1] = q[0] + slope(t) * q[1];
  return 0;
}

static int rows(double t, const double *q, double *J, int ldj, void *user)
{
  (void)q;
  (void)user;
  J[0] = J[1] = 1;
  J[ldj + 1] = slope(t);
  return 0;
}

static int bias(double t, const double *q, const double *v, double *phi_t, double *omega,
                void *user)
{
  (void)user;
  phi_t[1] = (t > 0.1) * q[1];
  omega[1] = 2 * (t > 0.1) * v[1];
  return 0;
}

static int nothing(double t, const double *q, const double *v, double *F, void *user)
{
  (void)t;
  (void)q;
  (void)v;
  (void)user;
  F[0] = 1;
  return 0;
}

/* The smallest and the largest rank that was met, in smooth steps too. */
static void test_rank(void **state)
{
  const double zero[2] = {0, 0};
  const nsdae_dims dims = {.nq = 2, .m = 2};
  (void)state;
  for (int method = NSDAE_METHOD_IMPLICIT; method <= NSDAE_METHOD_MOREAU; method++) {
    nsdae_system *system = NULL;
    nsdae_sim *sim = NULL;
    nsdae_stats stats;
    nsdae_sim_options o = options_of(method);
    o.redundant = NSDAE_REDUNDANT_LEAST_NORM;
    assert_int_equal(nsdae_system_create(&dims, &system, NULL), NSDAE_OK);
    nsdae_system_set_mass(system, mass);
    nsdae_system_set_force(system, nothing);
    nsdae_system_set_constraint(system, constraints);
    nsdae_system_set_constraint_jacobian(system, rows);
    nsdae_system_set_constraint_bias(system, bias);
    assert_int_equal(nsdae_sim_create(system, &o, &sim, NULL), NSDAE_OK);
    assert_int_equal(nsdae_sim_init(sim, 0, zero, zero), NSDAE_OK);
    assert_int_equal(nsdae_sim_run(sim, 0.05), NSDAE_OK);
    nsdae_sim_get_stats(sim, &stats);
    assert_true(stats.rank == 1 && stats.rank_most == 1);
    assert_true(stats.rank_retained > 0.1 && stats.rank_discarded <= o.rank_tol); /* the gap */
    assert_int_equal(nsdae_sim_run(sim, 0.3), NSDAE_OK);
    nsdae_sim_get_stats(sim, &stats);
    assert_true(stats.rank == 1 && stats.rank_most == 2);
    nsdae_sim_destroy(&sim);
    nsdae_system_destroy(&system);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_fall),
      cmocka_unit_test(test_undisturbed),
      cmocka_unit_test(test_to_event),
      cmocka_unit_test(test_user),
      cmocka_unit_test(test_settings),
      cmocka_unit_test(test_means),
      cmocka_unit_test(test_leaving),
      cmocka_unit_test(test_limit),
      cmocka_unit_test(test_refused_warning),
      cmocka_unit_test(test_part_steps),
      cmocka_unit_test(test_rank),
      cmocka_unit_test(test_refused_settings),
      cmocka_unit_test(test_slides),
      cmocka_unit_test(test_order_between),
      cmocka_unit_test(test_no_false_accumulation),
      cmocka_unit_test(test_accumulations_are_the_steps_own),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
