/* The kit of bodies under attack: each allocation lost in turn, each callback of the user's failing
 * in turn, contacts by name and by materials, in the plane and in space: a status with a text, the
 * state of before, nothing leaked; and the next try succeeds. */
#include "check.h"

#include <nsdae/nsdae.h>

#include "allocator.h"

enum { MOST = 32 };

/* The call of the user's callbacks, counted over all of them, that returns code, or leaves a value.
 */
typedef struct faults {
  long calls, at;
  int code, first_own, d, spoils;
  double value;
} faults;

/* out: what the callback gives. */
static int fails(faults *f, double *out)
{
  if (f->spoils && f->calls == f->at) *out = f->value;
  return f->calls++ == f->at ? f->code : 0;
}

static int drive(double t, double motion[3], void *user)
{
  motion[0] = sqrt(2) + 0.05 * t * t, motion[1] = 0.1 * t, motion[2] = 0.1;
  return fails(user, &motion[0]);
}

static int load(double t, const double x[3], const double v[3], double F[3], double T[3],
                void *user)
{
  (void)t, (void)x, (void)T;
  for (int i = 0; i < 3; i++) F[i] = -0.1 * v[i];
  return fails(user, &F[0]);
}

static int own_mass(double t, const double *q, double *M, int ldm, void *user)
{
  (void)t, (void)q, (void)ldm;
  M[0] = 1;
  return fails(user, &M[0]);
}

static int own_force(double t, const double *q, const double *v, double *F, void *user)
{
  faults *f = user;
  (void)t, (void)q, (void)v;
  F[f->first_own] -= 1;
  return fails(f, &F[f->first_own]);
}

/* One's own coordinate is held, by a row of one's own. */
static int own_constraint(double t, const double *q, double *phi, void *user)
{
  const faults *f = user;
  (void)t;
  phi[0] = q[f->d == 2 ? 6 : 14];
  return fails(user, &phi[0]);
}

static int own_jacobian(double t, const double *q, double *J, int ldj, void *user)
{
  const faults *f = user;
  (void)t, (void)q;
  J[(size_t)f->first_own * (size_t)ldj] = 1;
  return fails(user, &J[(size_t)f->first_own * (size_t)ldj]);
}

static int own_rows(double t, const double *q, nsdae_row_list *rows, void *user)
{
  double one = 1;
  (void)t, (void)q;
  int code = fails(user, &one);
  nsdae_row_add(rows, 1, 2, &one); /* behind the drive's */
  return code;
}

static int own_bias(double t, const double *q, const double *v, double *phi_t, double *omega,
                    void *user)
{
  (void)t, (void)q, (void)v, (void)phi_t, (void)omega;
  return fails(user, &omega[0]);
}

static int own_kinematics(double t, const double *q, const double *v, double *qdot, void *user)
{
  const faults *f = user;
  (void)t, (void)q;
  qdot[0] = v[f->first_own];
  return fails(user, &qdot[0]);
}

static int own_potential(double t, const double *q, double *energy, void *user)
{
  (void)t, (void)q;
  *energy += 0;
  return fails(user, energy);
}

/* Two balls, one driven along a guide's length from the ground and the other falling to the ground
 * beside it, with a spring, a load and one coordinate of one's own. */
static int build(faults *f, int d, int listed, int own, nsdae_bodies **b, nsdae_system **system)
{
  nsdae_error error;
  const int shape = d == 2 ? NSDAE_SHAPE_DISC : NSDAE_SHAPE_SPHERE, up = d - 1;
  nsdae_rigid_body body = {.mass = 1, .inertia = {d == 3 ? 0.1 : 0, d == 3 ? 0.1 : 0, 0.1}};
  const nsdae_solid ground = {.shape = NSDAE_SHAPE_PLANE}, ball = {.shape = shape, .radius = 0.1};
  nsdae_joint joint = {
      .kind = NSDAE_JOINT_DISTANCE, .body = {NSDAE_GROUND, 1}, .drive = drive, .user = f};
  nsdae_spring spring = {.body = {0, 1}, .stiffness = 1, .damping = 0.1, .rest = 1};
  const double gravity[3] = {0, d == 2 ? -9.81 : 0, d == 3 ? -9.81 : 0}, centre[3] = {0};
  f->d = d, f->first_own = d == 2 ? 6 : 12;
  *system = NULL;
  int status = nsdae_bodies_create(d, b, &error);
  if (status < 0) return status;
  body.position[up] = 0.11;
  nsdae_bodies_add(*b, &body);
  body.position[0] = spring.end[0] = joint.end[0] = 1;
  body.position[up] = spring.end[up] = joint.end[up] = 1;
  spring.point[up] = 0.11;
  nsdae_bodies_add(*b, &body);
  nsdae_bodies_add_joint(*b, &joint);
  nsdae_bodies_add_spring(*b, &spring);
  nsdae_bodies_add_load(*b, 0, centre, load, f);
  nsdae_bodies_set_gravity(*b, gravity);
  nsdae_bodies_add_solid(*b, NSDAE_GROUND, &ground);
  for (int i = 0; i < 2; i++) nsdae_bodies_add_solid(*b, i, &ball);
  if (listed) nsdae_bodies_set_pair(*b, 0, 0, 0.3, 0.5, 0); /* the second; the first is named */
  for (int i = 1; i < (listed ? 2 : 3); i++) nsdae_bodies_add_contact(*b, 0, i, 0.3, 0.5, 0);
  nsdae_user_rows mine = {.dims = {.nq = 1, .m = 1},
                          .mass = own_mass,
                          .force = own_force,
                          .constraint = own_constraint,
                          .constraint_bias = own_bias,
                          .kinematics = own_kinematics,
                          .potential = own_potential,
                          .user = f};
  if (listed) mine.constraint_rows = own_rows;
  if (!listed) mine.constraint_jacobian = own_jacobian;
  if (own) nsdae_bodies_set_user_rows(*b, &mine);
  return nsdae_bodies_system(*b, system);
}

typedef struct world {
  nsdae_bodies *bodies;
  nsdae_system *system;
  nsdae_sim *sim;
} world;

static void drop(world *w)
{
  nsdae_sim_destroy(&w->sim);
  nsdae_system_destroy(&w->system);
  nsdae_bodies_destroy(&w->bodies);
}

static int make(world *w, faults *f, int d, int listed, int own, int method)
{
  nsdae_sim_options options;
  double q[MOST], v[MOST];
  *w = (world){NULL, NULL, NULL};
  nsdae_sim_options_default(&options);
  options.method = method;
  int status = build(f, d, listed, own, &w->bodies, &w->system);
  if (status == NSDAE_OK) status = nsdae_sim_create(w->system, &options, &w->sim, NULL);
  if (status < 0) return status;
  nsdae_bodies_get_start(w->bodies, q, v);
  return nsdae_sim_init(w->sim, 0, q, v);
}

static void test_lost_allocations(void **state)
{
  (void)state;
  for (int form = 0; form < 8; form++) {
    int d = form & 1 ? 3 : 2, listed = form >> 1 & 1, own = form >> 2;
    long at = 0;
    for (;; at++) {
      faults f = {.at = -1};
      world w;
      allocator_reset(at);
      int status = make(&w, &f, d, listed, own, NSDAE_METHOD_MOREAU);
      for (int i = 0; i < 40 && status >= 0; i++) status = nsdae_sim_step(w.sim);
      int met = the_allocator.calls > at;
      if (!met && status < 0)
        fail_msg("form %d: %s", form,
                 w.sim ? nsdae_sim_error(w.sim)->text : nsdae_bodies_error(w.bodies)->text);
      if (w.bodies && met && !w.system)
        assert_int_equal(nsdae_bodies_error(w.bodies)->status, NSDAE_E_MEMORY);
      drop(&w);
      long live = the_allocator.live;
      allocator_reset(-1);
      if (live != 0) fail_msg("form %d, allocation %ld: %ld left", form, at, live);
      if (!met) break;
      if (d == 3 && status >= 0) continue; /* a contact problem that was solved without */
      if (status != NSDAE_E_MEMORY) fail_msg("form %d, allocation %ld: %d", form, at, status);
    }
    assert_true(at > 20);
  }
}

/* Call `at` fails: the step is dropped, and the next one is done as if nothing had been. */
static int fail_call(int form, int method, long at, int code)
{
  int d = form & 1 ? 3 : 2, listed = form >> 1 & 1, own = form >> 2;
  faults f = {.at = at, .code = code};
  nsdae_record r;
  world w;
  double q[MOST], time = 0;
  int status = make(&w, &f, d, listed, own, method), steps = 0, nq = (d == 2 ? 6 : 14) + own;
  if (status == NSDAE_OK) {
    while (steps < 40 && status >= 0) {
      nsdae_sim_get_record(w.sim, &r);
      memcpy(q, r.q, (size_t)nq * sizeof *q);
      time = r.time;
      status = nsdae_sim_step(w.sim);
      steps += status >= 0;
    }
    nsdae_sim_get_record(w.sim, &r);
    if (status < 0) {
      assert_int_equal(r.step, steps);
      assert_true(r.time == time);
      assert_memory_equal(r.q, q, (size_t)nq * sizeof *q);
      assert_int_equal(nsdae_sim_error(w.sim)->code, code);
      assert_true(nsdae_sim_step(w.sim) >= 0);
    }
  }
  if (status < 0 && status != NSDAE_E_CALLBACK)
    fail_msg("form %d, method %d, call %ld: %s", form, method, at,
             w.sim ? nsdae_sim_error(w.sim)->text : nsdae_bodies_error(w.bodies)->text);
  drop(&w);
  return f.calls > at;
}

static void test_failing_callbacks(void **state)
{
  (void)state;
  for (int form = 0; form < 8; form++)
    for (int method = NSDAE_METHOD_IMPLICIT; method <= NSDAE_METHOD_EVENT; method++)
      for (long at = 0; fail_call(form, method, at, at % 2 ? 2 : -2);
           at += 1 + at * test_share() / 8)
        continue;
}

static int all_finite(const double *x, int n)
{
  for (int i = 0; i < n; i++)
    if (!isfinite(x[i])) return 0;
  return 1;
}

/* What a record has, listed contacts included. */
static int is_finite(const nsdae_record *r, const nsdae_dims *d)
{
  const double energies[] = {r->kinetic, r->potential, r->dissipated, r->constraint_drift,
                             r->penetration};
  return all_finite(r->q, d->nq) && all_finite(r->v, d->nv) && all_finite(r->multiplier, d->m) &&
         all_finite(energies, 5) && all_finite(r->contacts.normal_impulse, r->contacts.count) &&
         all_finite(r->gap, d->k) && all_finite(r->normal_impulse, d->k);
}

/* Call `at` leaves a value that is not to be: an error with a text and the state of before, or a
 * finite record (where nothing came of the value). */
static int spoil_call(int form, int method, long at, double value)
{
  int d = form & 1 ? 3 : 2, listed = form >> 1 & 1, own = form >> 2;
  faults f = {.at = at, .spoils = 1, .value = value};
  nsdae_record r;
  nsdae_dims dims;
  world w;
  double q[MOST];
  int status = make(&w, &f, d, listed, own, method);
  if (w.sim) nsdae_sim_get_dims(w.sim, &dims);
  for (int steps = 0; steps < 40 && status >= 0; steps++) {
    nsdae_sim_get_record(w.sim, &r);
    if (!is_finite(&r, &dims))
      fail_msg("form %d, method %d, call %ld, %g: not finite", form, method, at, value);
    memcpy(q, r.q, (size_t)dims.nq * sizeof *q);
    status = nsdae_sim_step(w.sim);
    if (status >= 0) continue;
    nsdae_sim_get_record(w.sim, &r);
    assert_int_equal(r.step, steps);
    assert_memory_equal(r.q, q, (size_t)dims.nq * sizeof *q);
  }
  if (status < 0 && w.sim &&
      (nsdae_sim_error(w.sim)->status != status || !nsdae_sim_error(w.sim)->text[0]))
    fail_msg("form %d, method %d, call %ld, %g: no text", form, method, at, value);
  drop(&w);
  return f.calls > at;
}

static void test_spoiled_callbacks(void **state)
{
  const double value[] = {NAN, INFINITY, 1e308, -1e308, 1e-310};
  (void)state;
  for (int form = 0; form < 8; form++)
    for (int method = NSDAE_METHOD_IMPLICIT; method <= NSDAE_METHOD_EVENT; method++)
      for (long at = 0; spoil_call(form, method, at, value[at % 5]);
           at += 1 + at * test_share() / 8)
        continue;
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_lost_allocations),
                                     cmocka_unit_test(test_failing_callbacks),
                                     cmocka_unit_test(test_spoiled_callbacks)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
