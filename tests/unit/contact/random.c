/* Contact problems at random: the laws, the energy, and an enumeration of the modes. */
#include "fixture.h"

#include "support/random.h"

/* Entries of order one, up to twenty rows; the masses have a condition of ten or so. */
static const double rounding = 1e-10;

static random_state r;

/* M = B^T B / n + 1, W, J at random. */
static void random_model(fixture *f)
{
  int n = f->dims.nq;
  double B[MOST_V * MOST_V];
  random_matrix(&r, n, n, B, n);
  for (int i = 0; i < n; i++)
    for (int j = 0; j < n; j++) {
      f->M[j * n + i] = i == j;
      for (int k = 0; k < n; k++) f->M[j * n + i] += B[i * n + k] * B[j * n + k] / n;
    }
  random_matrix(&r, f->dims.m, n, f->J, f->dims.m);
  random_matrix(&r, n, f->dims.k, f->W_N, n);
  random_matrix(&r, n, f->dims.k * f->dims.nt, f->W_T, n);
}

static void random_velocity(fixture *f, double *v)
{
  random_matrix(&r, f->dims.nq, 1, v, MOST_V);
}

/* v := its part with J v = 0; the fixture is built. */
static void satisfy_constraints(fixture *f, double *v)
{
  int n = f->dims.nv;
  double r1[MOST_V] = {0}, c[MOST_M] = {0};
  fixture_add_mass(f, v, r1);
  fixture_factor(f);
  assert_int_equal(nsdae_kkt_solve(&f->kkt, 1, r1, n, c, f->dims.m), NSDAE_OK);
  memcpy(v, r1, (size_t)n * sizeof *v);
}

static void common_coefficients(fixture *f, double mu, double e)
{
  for (int i = 0; i < f->dims.k; i++)
    assert_int_equal(nsdae_system_set_contact(f->system, i, mu, e, e), NSDAE_OK);
}

/* With one coefficient e <= 1 in all directions an impact takes energy:
 * Lambda.(v+ + e v-) <= 0 and Lambda.(v+ - v-) = Lambda G Lambda >= 0 give
 * Lambda.(v+ + v-) / 2 <= (e / (1 + e) - 1/2) Lambda G Lambda <= 0. */
static void impacts(int nt, int polygon)
{
  for (int i = 0; i < 400; i++) {
    fixture f;
    int n = random_int(&r, 2, MOST_V), k = random_int(&r, 1, MOST_K);
    int m = random_int(&r, 0, n > 3 ? 2 : 0);
    double mu = 0.15 * random_int(&r, 1, 4), e = 0.25 * random_int(&r, 0, 4);
    fixture_begin(&f, (nsdae_dims){.nq = n, .m = m, .k = k, .nt = nt});
    random_model(&f);
    common_coefficients(&f, nt > 0 ? mu : 0, e);
    fixture_build(&f, polygon);
    for (int j = 0; j < k; j++) f.gap[j] = random_int(&r, -1, 2) * 0.1; /* a quarter are open */
    for (int repeat = 0; repeat < 3; repeat++) { /* from the last active set, too */
      random_velocity(&f, f.before);
      satisfy_constraints(&f, f.before);
      assert_int_equal(fixture_impact(&f), NSDAE_OK);
      fixture_expect_laws(&f, rounding);
      double work = nsdae_contacts_work(&f.contacts), largest = 1;
      double gained = fixture_kinetic(&f, f.v) - fixture_kinetic(&f, f.before);
      for (int j = 0; j < k; j++) largest = fmax(largest, f.impulses.normal[j]);
      assert_near(work, gained, rounding * largest);
      assert_at_most(work, rounding * largest);
    }
    fixture_end(&f);
  }
}

static void test_frictionless(void **state)
{
  (void)state;
  r.seed = 31;
  impacts(0, 8);
}

static void test_planar(void **state)
{
  (void)state;
  r.seed = 32;
  impacts(1, 8);
}

static void test_polygon(void **state)
{
  (void)state;
  r.seed = 33;
  impacts(2, 4);
}

static void test_cone(void **state)
{
  (void)state;
  r.seed = 36;
  impacts(2, 0);
}

/* G of one planar contact: [W_N W_T]^T M^-1 [W_N W_T], and b = W^T free + w + e before. */
static void reduced(fixture *f, double G[3], double b[2])
{
  const nsdae_coefficients *e = &f->system->contact[0];
  int n = f->dims.nv;
  double MW[2][MOST_V];
  const double *W[2] = {f->W_N, f->W_T};
  nsdae_kkt kkt = f->kkt; /* shares the factors of M */
  for (int j = 0; j < 2; j++) {
    memcpy(MW[j], W[j], sizeof MW[j]);
    nsdae_kkt_solve_mass(&kkt, MW[j]);
  }
  G[0] = fixture_dot(n, W[0], MW[0]);
  G[1] = fixture_dot(n, W[0], MW[1]);
  G[2] = fixture_dot(n, W[1], MW[1]);
  b[0] = fixture_dot(n, W[0], f->free) + f->w_n[0] +
         e->e_n * (fixture_dot(n, W[0], f->before) + f->w_n[0]);
  b[1] = fixture_dot(n, W[1], f->free) + f->w_t[0] +
         e->e_t * (fixture_dot(n, W[1], f->before) + f->w_t[0]);
}

/* Lambda of the mode that is consistent: open, stick, slide to the right, slide to the left. */
static int by_modes(const double G[3], const double b[2], double mu, double L[2])
{
  L[0] = L[1] = 0;
  if (b[0] >= 0) return NSDAE_MODE_OPEN;
  double det = G[0] * G[2] - G[1] * G[1];
  L[0] = (-G[2] * b[0] + G[1] * b[1]) / det;
  L[1] = (G[1] * b[0] - G[0] * b[1]) / det;
  if (L[0] >= 0 && fabs(L[1]) <= mu * L[0]) return NSDAE_MODE_STICK;
  for (int side = -1; side <= 1; side += 2) {
    L[0] = -b[0] / (G[0] - side * mu * G[1]);
    L[1] = -side * mu * L[0];
    if (L[0] >= 0 && side * (G[1] * L[0] + G[2] * L[1] + b[1]) >= 0) return NSDAE_MODE_SLIP;
  }
  return -1;
}

/* One contact whose normal and tangent are coupled, as at the end of a rod: with
 * mu |G_NT| < G_NN the solution is unique (Jean and Pratt 1985), so the modes can be tried. */
static void test_coupled(void **state)
{
  (void)state;
  int seen[3] = {0};
  r.seed = 34;
  for (int i = 0; i < 3000; i++) {
    fixture f;
    double G[3], b[2], L[2], mu = 0.5 * (1 + random_number(&r));
    fixture_begin(&f, (nsdae_dims){.nq = random_int(&r, 2, 5), .k = 1, .nt = 1});
    random_model(&f);
    nsdae_system_set_contact(f.system, 0, mu, 0.5 * (1 + random_number(&r)),
                             0.5 * (1 + random_number(&r)));
    fixture_build(&f, 8);
    f.w_n[0] = 0.2 * random_number(&r);
    f.w_t[0] = 0.2 * random_number(&r);
    random_velocity(&f, f.before);
    random_velocity(&f, f.free);
    assert_int_equal(fixture_solve(&f), NSDAE_OK);
    reduced(&f, G, b);
    if (mu * fabs(G[1]) < 0.9 * G[0] && G[1] * G[1] < 0.99 * G[0] * G[2]) {
      int mode = by_modes(G, b, mu, L);
      assert_true(mode >= 0);
      seen[mode]++;
      /* 1 / (1 - 0.99) of the coupling */
      double tol = 100 * rounding * (1 + fabs(L[0]));
      assert_near(f.impulses.normal[0], L[0], tol);
      assert_near(f.impulses.tangential[0], L[1], tol);
      assert_int_equal(f.impulses.mode[0], mode);
      fixture_expect_laws(&f, rounding);
    }
    fixture_end(&f);
  }
  for (int mode = 0; mode < 3; mode++) assert_true(seen[mode] > 100);
}

/* Units do not matter: masses in tonnes or grams give the same velocities. */
static void test_units(void **state)
{
  (void)state;
  const double units[] = {1e-6, 1e-3, 1e3, 1e6};
  r.seed = 35;
  for (int i = 0; i < 100; i++) {
    fixture f;
    double v[MOST_V], L[MOST_K], M[MOST_V * MOST_V];
    fixture_begin(&f, (nsdae_dims){.nq = 6, .k = 3, .nt = 1});
    random_model(&f);
    common_coefficients(&f, 0.2, 0.5);
    fixture_build(&f, 8);
    random_velocity(&f, f.before);
    memcpy(M, f.M, sizeof M);
    assert_int_equal(fixture_impact(&f), NSDAE_OK);
    memcpy(v, f.v, sizeof v);
    memcpy(L, f.impulses.normal, 3 * sizeof *L);
    for (int u = 0; u < 4; u++) {
      for (int j = 0; j < 36; j++) f.M[j] = M[j] * units[u];
      fixture_forget(&f);
      assert_int_equal(fixture_impact(&f), NSDAE_OK);
      /* three contacts, six velocities, small friction: unique */
      for (int j = 0; j < 6; j++) assert_near(f.v[j], v[j], rounding * (1 + fabs(v[j])));
      for (int j = 0; j < 3; j++)
        assert_near(f.impulses.normal[j] / units[u], L[j], rounding * (1 + L[j]) * 10);
    }
    fixture_end(&f);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_frictionless), cmocka_unit_test(test_planar),
      cmocka_unit_test(test_polygon),      cmocka_unit_test(test_coupled),
      cmocka_unit_test(test_cone),         cmocka_unit_test(test_units),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
