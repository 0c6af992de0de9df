/* Newton's cradle against Newton's law on all contacts at once, and against the chain of impacts
 * of two balls each. */
#include "check.h"

#include "newtons_cradle.h"

enum { METHODS = 3, N = NEWTONS_CRADLE_MAX };

typedef struct run {
  int impacts, order[64];
  double q[N], v[N], impulse[N], energy, start_energy;
  double worst_centre; /* change of the invariant of the centre of mass */
} run;

/* (X')^2 + (g / L) X^2 of the centre of mass X: no impact changes it. */
static double centre(const nsdae_record *r, const newtons_cradle *p)
{
  double X = 0, V = 0;
  for (int i = 0; i < p->n; i++) {
    X += r->q[i] / p->n;
    V += r->v[i] / p->n;
  }
  return V * V + p->g / p->L * X * X;
}

static int observe(const nsdae_record *r, nsdae_error *error, void *user)
{
  run *out = user;
  const newtons_cradle *p = newtons_cradle_model.base;
  double start = p->v0 * p->v0 / (p->n * p->n);
  (void)error;
  for (int i = 0; i < r->impacts && out->impacts < 64; i++)
    out->order[out->impacts++] = r->impact[i].contact;
  for (int i = 0; i < p->n; i++) {
    out->q[i] = r->q[i];
    out->v[i] = r->v[i];
    if (i < p->n - 1 && r->step == 1) out->impulse[i] = r->normal_impulse[i];
  }
  out->energy = r->kinetic + r->potential;
  if (r->step == 0) out->start_energy = out->energy;
  out->worst_centre = fmax(out->worst_centre, fabs(centre(r, p) / start - 1));
  return 0;
}

static run integrate(int method, double dt, double t_end)
{
  run out = {0};
  nsdae_system *system;
  nsdae_sim *sim;
  nsdae_sim_options options;
  double q0[N] = {0}, v0[N] = {0};
  nsdae_sim_options_default(&options);
  options.method = method;
  options.dt = dt;
  assert_int_equal(newtons_cradle_model.build(newtons_cradle_model.base, &system, NULL), NSDAE_OK);
  newtons_cradle_model.start(newtons_cradle_model.base, q0, v0);
  assert_int_equal(nsdae_sim_create(system, &options, &sim, NULL), NSDAE_OK);
  assert_int_equal(nsdae_sim_init(sim, 0, q0, v0), NSDAE_OK);
  assert_int_equal(nsdae_sim_observe(sim, observe, &out), NSDAE_OK);
  assert_int_equal(nsdae_sim_run(sim, t_end), NSDAE_OK);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  return out;
}

static int defaults(void **state)
{
  (void)state;
  nsdae_params_default(newtons_cradle_model.parameters, newtons_cradle_model.base);
  return 0;
}

static void test_derivatives(void **state)
{
  (void)state;
  const double q[] = {0.1, -0.2, 0.3, 0.05, 0.4}, v[] = {1, 2, -3, 0.5, 0.1};
  nsdae_system *system;
  assert_int_equal(newtons_cradle_model.build(newtons_cradle_model.base, &system, NULL), NSDAE_OK);
  assert_int_equal(nsdae_system_check(system, 0, q, v, 1e-6, NULL), NSDAE_OK);
  nsdae_system_destroy(&system);
}

/* The published values that the model's closed form must give. */
static void test_closed_form(void **state)
{
  (void)state;
  static const struct {
    int n;
    double e, first, others;
  } known[] = {
      {3, 1, -1 / 3.0, 2 / 3.0}, {3, 0, 1 / 3.0, 1 / 3.0}, {3, 0.5, 0, 0.5}, {5, 1, -0.6, 0.4}};
  newtons_cradle *p = newtons_cradle_model.base;
  for (size_t i = 0; i < sizeof known / sizeof *known; i++) {
    double v[N];
    p->n = known[i].n;
    p->e_N = known[i].e;
    newtons_cradle_exact(p, 0, v);
    assert_near(v[0], known[i].first, 2.3e-16);
    for (int j = 1; j < p->n; j++) assert_near(v[j], known[i].others, 2.3e-16);
  }
}

/* One simultaneous impact on a table, all n and four e: velocities and impulses to the rounding of
 * an LCP with n - 1 rows, whose matrix tridiag(-1, 2, -1) / m has a condition of 0.4 n^2. */
static void test_impact(void **state)
{
  (void)state;
  newtons_cradle *p = newtons_cradle_model.base;
  const double e[] = {0, 0.25, 0.5, 1}, tol = 0.4 * (double)(N * N) * 2.3e-16;
  double worst = 0;
  p->g = 0;
  for (int method = 0; method < METHODS; method++)
    for (p->n = 2; p->n <= N; p->n++)
      for (int j = 0; j < 4; j++) {
        double exact[N], kinetic = 0;
        p->e_N = e[j];
        run r = integrate(method, 0.01, 0.01);
        newtons_cradle_exact(p, 0, exact);
        assert_int_equal(r.impacts, 1);
        assert_int_equal(r.order[0], 0);
        for (int i = 0; i < p->n; i++) {
          worst = fmax(worst, fabs(r.v[i] - exact[i]));
          assert_near(r.v[i], exact[i], tol);
          kinetic += p->m * exact[i] * exact[i] / 2;
        }
        for (int i = 0; i < p->n - 1; i++)
          assert_near(r.impulse[i], (p->n - 1 - i) * p->m * (1 + p->e_N) / p->n, tol);
        assert_near(r.energy, kinetic, tol);
        if (e[j] == 1) assert_near(r.energy, r.start_energy, tol);
      }
  print_message("worst velocity error %.2e\n", worst);
}

/* With gaps the first ball's velocity runs down the row: each impact of two balls leaves (1-e)/2
 * to the one and (1+e)/2 to the other. */
static void test_chain(void **state)
{
  (void)state;
  newtons_cradle *p = newtons_cradle_model.base;
  const double e[] = {0.9, 1};
  p->g = 0;
  p->gap = 0.01;
  for (int method = 0; method < METHODS; method++)
    for (int j = 0; j < 2; j++) {
      p->e_N = e[j];
      run r = integrate(method, 1e-4, 0.07);
      assert_true(r.impacts >= p->n - 1);
      for (int i = 0; i < p->n - 1; i++) assert_int_equal(r.order[i], i);
      assert_near(r.v[p->n - 1], pow((1 + p->e_N) / 2, p->n - 1) * p->v0, 1e-14);
      for (int i = 0; i < p->n - 1 && p->e_N == 1; i++) assert_near(r.v[i], 0, 1e-14);
    }
}

/* The centre of mass swings as if there were no impacts. implicit, the trapezoidal rule on a
 * linear oscillator, keeps its invariant but for iteration_tol (1e-12) a step. */
static void test_centre(void **state)
{
  (void)state;
  newtons_cradle *p = newtons_cradle_model.base;
  const double gaps[] = {0, 1e-3};
  for (int j = 0; j < 2; j++)
    for (p->e_N = 0; p->e_N <= 1; p->e_N += 0.5) {
      p->gap = gaps[j];
      run r = integrate(NSDAE_METHOD_IMPLICIT, 1e-3, 2);
      assert_true(r.impacts > 0);
      print_message("gap %g e %.1f: %d impacts, centre %.2e, energy change %+.2e J\n", p->gap,
                    p->e_N, r.impacts, r.worst_centre, r.energy - r.start_energy);
      assert_at_most(r.worst_centre, 2000 * 1e-12);
      assert_at_most(r.energy - r.start_energy, 2000 * 1e-12 * r.start_energy);
      if (p->e_N == 1) assert_near(r.energy, r.start_energy, 2000 * 1e-12 * r.start_energy);
    }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup(test_derivatives, defaults),
      cmocka_unit_test_setup(test_closed_form, defaults),
      cmocka_unit_test_setup(test_impact, defaults),
      cmocka_unit_test_setup(test_chain, defaults),
      cmocka_unit_test_setup(test_centre, defaults),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
