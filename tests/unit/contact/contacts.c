/* Contact problems at velocity level against closed forms. */
#include "fixture.h"

/* Problems of a few rows with entries of order one: some roundings. */
static const double rounding = 1e-12;

/* A block of mass m on the plane y = 0:  q = [x, y]. */
static void block(fixture *f, double m, double mu, double e_n, double e_t)
{
  fixture_begin(f, (nsdae_dims){.nq = 2, .k = 1, .nt = 1});
  f->M[0] = f->M[3] = m;
  f->W_N[1] = f->W_T[0] = 1;
  assert_int_equal(nsdae_system_set_contact(f->system, 0, mu, e_n, e_t), NSDAE_OK);
  fixture_build(f, 8);
}

/* What Coulomb's and Newton's laws give a block without coupling: normal first, then tangential. */
static void expect_block(fixture *f, double m, double mu, double e_n, double e_t)
{
  double normal = fmax(0, -m * (f->free[1] + e_n * f->before[1]));
  double stick = -m * (f->free[0] + e_t * f->before[0]);
  double tangential = fmax(-mu * normal, fmin(mu * normal, stick));
  assert_int_equal(fixture_solve(f), NSDAE_OK);
  assert_near(f->impulses.normal[0], normal, rounding * m);
  assert_near(f->impulses.tangential[0], tangential, rounding * m);
  assert_near(f->v[0], f->free[0] + tangential / m, rounding);
  assert_near(f->v[1], f->free[1] + normal / m, rounding);
  assert_at_most(f->contacts.lcp.info.residual, f->contacts.lcp.options.tol);
  int mode = normal == 0                  ? NSDAE_MODE_OPEN
             : fabs(stick) <= mu * normal ? NSDAE_MODE_STICK
                                          : NSDAE_MODE_SLIP;
  assert_int_equal(f->impulses.mode[0], mode);
  fixture_expect_laws(f, rounding * (1 + m));
}

static void test_block(void **state)
{
  (void)state;
  const double m = 2.5, mu = 0.4, h = 0.01, g = 9.81;
  const double start[] = {0, 0.01, -0.01, 0.1, -0.1, 3, -3};
  fixture f;
  block(&f, m, mu, 0, 0);
  for (int i = 0; i < 7; i++)
    for (int push = -10; push <= 10; push++) { /* a force of push along x over h */
      f.before[0] = start[i];
      f.before[1] = 0;
      f.free[0] = start[i] + h * push / m;
      f.free[1] = -h * g;
      expect_block(&f, m, mu, 0, 0);
    }
  f.free[1] = 0.2; /* lifted */
  expect_block(&f, m, mu, 0, 0);
  assert_int_equal(f.impulses.mode[0], NSDAE_MODE_OPEN);
  fixture_end(&f);
}

static void test_block_impact(void **state)
{
  (void)state;
  const double masses[] = {1e-3, 1, 1e3}, es[] = {0, 0.3, 1}, mus[] = {0.05, 0.5, 2};
  for (int im = 0; im < 3; im++)
    for (int ie = 0; ie < 9; ie++)
      for (int iu = 0; iu < 3; iu++) {
        fixture f;
        double e_n = es[ie / 3], e_t = es[ie % 3];
        block(&f, masses[im], mus[iu], e_n, e_t);
        for (int i = 0; i < 12; i++) {
          f.before[0] = f.free[0] = 2 * cos(i + 0.5);
          f.before[1] = f.free[1] = -1 + 0.8 * sin(i);
          expect_block(&f, masses[im], mus[iu], e_n, e_t);
          assert_near(f.v[1], -e_n * f.before[1], rounding); /* Newton */
        }
        fixture_end(&f);
      }
}

/* Before and after are not the same contact velocity when the step has a force, too. */
static void test_open_by_gap(void **state)
{
  (void)state;
  fixture f;
  block(&f, 1, 0.3, 0.5, 0);
  f.gap[0] = 1e-14; /* above rounding is open */
  f.before[1] = f.free[1] = -1;
  assert_int_equal(fixture_solve(&f), NSDAE_OK);
  assert_true(f.v[1] == -1 && f.impulses.normal[0] == 0 && f.contacts.active_count == 0);
  assert_int_equal(f.impulses.mode[0], NSDAE_MODE_OPEN);
  f.gap[0] = 1e-17; /* touches */
  assert_int_equal(fixture_solve(&f), NSDAE_OK);
  assert_near(f.v[1], 0.5, rounding);
  f.gap[0] = 0;
  assert_int_equal(fixture_solve(&f), NSDAE_OK);
  assert_near(f.v[1], 0.5, rounding);
  f.gap[0] = -0.1;
  assert_int_equal(fixture_solve(&f), NSDAE_OK);
  assert_near(f.v[1], 0.5, rounding);
  fixture_end(&f);
}

/* n equal balls in a row that touch; the first comes with 1. Newton's law at all contacts at once
 * (not the cradle's real answer, which it cannot give). */
static void cradle(int n, double e, double *v)
{
  fixture f;
  fixture_begin(&f, (nsdae_dims){.nq = n, .k = n - 1});
  for (int i = 0; i < n - 1; i++) {
    f.W_N[i * n + i] = -1;
    f.W_N[i * n + i + 1] = 1;
    nsdae_system_set_contact(f.system, i, 0, e, 0);
  }
  fixture_build(&f, 8);
  f.before[0] = 1;
  assert_int_equal(fixture_impact(&f), NSDAE_OK);
  fixture_expect_laws(&f, rounding);
  assert_near(nsdae_contacts_work(&f.contacts),
              fixture_kinetic(&f, f.v) - fixture_kinetic(&f, f.before), rounding);
  memcpy(v, f.v, (size_t)n * sizeof *v);
  fixture_end(&f);
}

static void test_cradle(void **state)
{
  (void)state;
  const double es[] = {1, 0, 0.5};
  const double expected[][3] = {
      {-1 / 3.0, 2 / 3.0, 2 / 3.0}, {1 / 3.0, 1 / 3.0, 1 / 3.0}, {0, 0.5, 0.5}};
  double v[MOST_V];
  for (int i = 0; i < 3; i++) {
    cradle(3, es[i], v);
    for (int j = 0; j < 3; j++) assert_near(v[j], expected[i][j], rounding);
  }
  /* the same for any n: the others move on as one,  v_1 - v_0 = e,  v_0 + (n-1) v_1 = 1 */
  for (int n = 2; n <= 7; n++)
    for (int i = 0; i < 3; i++) {
      cradle(n, es[i], v);
      assert_near(v[0], (1 - (n - 1) * es[i]) / n, rounding);
      for (int j = 1; j < n; j++) assert_near(v[j], (1 + es[i]) / n, rounding);
    }
}

/* A floor that moves up with r: w_N = -r. In its frame it is a floor at rest. */
static void test_moving_floor(void **state)
{
  (void)state;
  const double m = 2, r = 0.7;
  for (int i = 0; i <= 4; i++) {
    double e = 0.25 * i, coming = -1.3;
    fixture f;
    block(&f, m, 0, e, 0);
    f.w_n[0] = -r;
    f.before[1] = coming;
    assert_int_equal(fixture_impact(&f), NSDAE_OK);
    assert_near(f.v[1], r - e * (coming - r), rounding);
    assert_near(f.impulses.normal[0], m * (1 + e) * (r - coming), rounding);
    assert_near(f.impulses.before[0], coming - r, rounding);
    assert_near(f.impulses.after[0], -e * (coming - r), rounding);
    /* the work in the floor's frame is what is lost there */
    assert_near(nsdae_contacts_work(&f.contacts),
                -m / 2 * (1 - e * e) * (r - coming) * (r - coming), rounding * 10);
    fixture_expect_laws(&f, rounding * 10);
    fixture_end(&f);
  }
  fixture f; /* slower than the floor, at rest: taken along */
  block(&f, m, 0, 0.5, 0);
  f.w_n[0] = -r;
  f.before[1] = f.free[1] = r;
  f.free[1] -= 0.1; /* gravity's work in the step */
  assert_int_equal(fixture_solve(&f), NSDAE_OK);
  assert_near(f.v[1], r, rounding);
  fixture_end(&f);
}

/* A conveyor belt: w_T = -s. The block sticks to it or slides on it. */
static void test_moving_belt(void **state)
{
  (void)state;
  const double m = 2, mu = 0.5, s = 0.02;
  for (int i = 0; i < 2; i++) {
    fixture f;
    block(&f, m, mu, 0, 0);
    f.w_t[0] = i == 0 ? -s : -50 * s;
    f.free[1] = -0.1;
    assert_int_equal(fixture_solve(&f), NSDAE_OK);
    assert_near(f.v[0], i == 0 ? s : mu * 0.1, rounding);
    assert_int_equal(f.impulses.mode[0], i == 0 ? NSDAE_MODE_STICK : NSDAE_MODE_SLIP);
    fixture_expect_laws(&f, rounding);
    fixture_end(&f);
  }
}

/* A block on the plane z = 0, pushed along a corner of the friction polygon: as in the plane. */
static void test_polygon(void **state)
{
  (void)state;
  const double m = 2, mu = 0.3, down = -0.5;
  const int polygons[] = {4, 6, 8, 12, 32};
  for (int p = 0; p < 5; p++)
    for (int corner = 0; corner < polygons[p]; corner++)
      for (int fast = 0; fast < 2; fast++) {
        fixture f;
        fixture_begin(&f, (nsdae_dims){.nq = 3, .k = 1, .nt = 2});
        f.M[0] = f.M[4] = f.M[8] = m;
        f.W_N[2] = f.W_T[0] = f.W_T[3 + 1] = 1;
        nsdae_system_set_contact(f.system, 0, mu, 0, 0);
        fixture_build(&f, polygons[p]);
        double angle = 2 * acos(-1) * corner / polygons[p], speed = fast ? 1 : 0.1;
        f.free[0] = speed * cos(angle);
        f.free[1] = speed * sin(angle);
        f.free[2] = down;
        assert_int_equal(fixture_solve(&f), NSDAE_OK);
        double left = fast ? speed + mu * down : 0; /* mu Lambda_N / m is 0.15 */
        assert_near(f.v[0], left * cos(angle), rounding);
        assert_near(f.v[1], left * sin(angle), rounding);
        assert_near(f.v[2], 0, rounding);
        assert_near(f.impulses.normal[0], -m * down, rounding);
        assert_int_equal(f.impulses.mode[0], fast ? NSDAE_MODE_SLIP : NSDAE_MODE_STICK);
        fixture_expect_laws(&f, rounding);
        fixture_end(&f);
      }
}

/* Between the corners the friction is the nearest corner's, or on the edge between two. */
static void test_polygon_between(void **state)
{
  (void)state;
  for (int p = 4; p <= 32; p += 4)
    for (int i = 0; i < 40; i++) {
      fixture f;
      fixture_begin(&f, (nsdae_dims){.nq = 3, .k = 1, .nt = 2});
      f.W_N[2] = f.W_T[0] = f.W_T[3 + 1] = 1;
      nsdae_system_set_contact(f.system, 0, 0.3, 0, 0);
      fixture_build(&f, p);
      f.free[0] = 0.3 * cos(0.17 * i);
      f.free[1] = 0.3 * sin(0.17 * i);
      f.free[2] = -0.1 * (i % 4);
      assert_int_equal(fixture_solve(&f), NSDAE_OK);
      fixture_expect_laws(&f, rounding);
      fixture_end(&f);
    }
}

/* A mass on a rod that cannot lengthen, thrown against a wall that leans: the impulse is shared
 * with the bilateral constraint x = 0, which leaves y alone. */
static void test_with_constraint(void **state)
{
  (void)state;
  const double m = 3, e = 0.5, a = 0.6, b = 0.8; /* the wall's normal (a, b) */
  fixture f;
  fixture_begin(&f, (nsdae_dims){.nq = 2, .m = 1, .k = 1});
  f.M[0] = f.M[3] = m;
  f.J[0] = 1;
  f.W_N[0] = a;
  f.W_N[1] = b;
  nsdae_system_set_contact(f.system, 0, 0, e, 0);
  fixture_build(&f, 8);
  f.before[1] = -2;
  assert_int_equal(fixture_impact(&f), NSDAE_OK);
  double normal = m * 2 * (1 + e) / b; /* b Lambda_N = m (v+ - v-), v+ = -e v- */
  assert_near(f.v[0], 0, rounding);
  assert_near(f.v[1], 2 * e, rounding);
  assert_near(f.impulses.normal[0], normal, rounding * 10);
  assert_near(f.lambda[0], a * normal, rounding * 10); /* M v + J^T lambda = W_N Lambda_N */
  fixture_expect_laws(&f, rounding * 10);
  fixture_end(&f);
}

/* Three contacts at one corner of a block with two degrees of freedom: forces not unique, motion
 * is. */
static void test_redundant_contacts(void **state)
{
  (void)state;
  fixture f;
  fixture_begin(&f, (nsdae_dims){.nq = 2, .k = 3, .nt = 1});
  for (int i = 0; i < 3; i++) {
    f.W_N[2 * i + 1] = f.W_T[2 * i] = 1;
    nsdae_system_set_contact(f.system, i, 0.3, 0, 0);
  }
  fixture_build(&f, 8);
  f.free[0] = 1;
  f.free[1] = -1;
  assert_int_equal(fixture_solve(&f), NSDAE_OK);
  assert_near(f.v[0], 0.7, rounding);
  assert_near(f.v[1], 0, rounding);
  assert_near(f.impulses.normal[0] + f.impulses.normal[1] + f.impulses.normal[2], 1, rounding);
  fixture_expect_laws(&f, rounding);
  fixture_end(&f);
}

/* A mechanism that is driven into a wall, J v = 1 with the wall's normal along -J: no impulse can
 * stop it. W^T P W is zero but for rounding, which must not be taken for a mass of 1e17. */
static void test_jammed(void **state)
{
  (void)state;
  for (int i = 0; i < 50; i++) {
    fixture f;
    double J[3] = {cos(i), sin(i) * cos(3.0 * i), sin(i) * sin(3.0 * i)};
    fixture_begin(&f, (nsdae_dims){.nq = 3, .m = 1, .k = 1});
    f.M[0] = 2;
    f.M[4] = 3;
    f.M[1] = f.M[3] = 0.3;
    memcpy(f.J, J, sizeof J);
    for (int j = 0; j < 3; j++) f.W_N[j] = -1.7 * J[j];
    fixture_build(&f, 8);
    memcpy(f.before, J, sizeof J);
    memcpy(f.free, J, sizeof J);
    int status = fixture_solve(&f);
    if (status >= 0)
      fail_msg("case %d: status %d, impulse %g, residual %g", i, status, f.impulses.normal[0],
               f.contacts.lcp.info.residual);
    assert_true(status == NSDAE_E_INFEASIBLE || status == NSDAE_E_LCP);
    fixture_end(&f);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_block),           cmocka_unit_test(test_block_impact),
      cmocka_unit_test(test_open_by_gap),     cmocka_unit_test(test_cradle),
      cmocka_unit_test(test_moving_floor),    cmocka_unit_test(test_moving_belt),
      cmocka_unit_test(test_polygon),         cmocka_unit_test(test_polygon_between),
      cmocka_unit_test(test_with_constraint), cmocka_unit_test(test_redundant_contacts),
      cmocka_unit_test(test_jammed),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
