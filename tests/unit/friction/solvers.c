/* Each solver alone, by the contract and by its bit of options.stages, on seeded problems whose
 * solution is known: W positive definite, r and u drawn so that they obey Coulomb's law, q = u - W
 * r. What every solver owes: the iterate gets no worse, its residual is that of its point, and the
 * budget is kept to a step. */
#include "solver_island.h"

#include "../linalg/random_matrices.h"
#include "friction_families.h"

enum { CONTACTS = 6, ROWS = 3 * CONTACTS, SEEDS = 40 };

/* What a solution may hold: every state, or no sliding contact (s = 0), or no second tangent. */
enum { ANY = 0, NO_SLIP = 1, PLANAR = 2 };

typedef struct known {
  int rows[CONTACTS], first[CONTACTS + 1], block[CONTACTS * CONTACTS];
  double mu[CONTACTS], W[ROWS * ROWS], value[ROWS * ROWS], q[ROWS], r[ROWS], u[ROWS];
  nsdae_friction_problem p;
  int per; /* rows of a contact */
} known;

/* Open: r = 0, u in K*. Stick: r inside K, u = 0. Slide: r on the edge of K, u against its
 * tangential part. */
static void draw_contact(known *k, int c, int states, random_state *draws)
{
  const int state = random_int(draws, 0, states & NO_SLIP ? 1 : 2);
  const double angle = k->per == 3 ? 3 * random_number(draws) : 0, mu = k->mu[c];
  const double d[2] = {cos(angle), sin(angle)}, size = 0.5 + fabs(random_number(draws));
  double *r = k->r + k->per * c, *u = k->u + k->per * c;
  const double share = state == 2 ? 1 : 0.9 * fabs(random_number(draws));
  r[0] = state == 0 ? 0 : size;
  u[0] = state == 0 ? size + 0.1 : 0;
  for (int j = 1; j < k->per; j++) {
    r[j] = mu * share * r[0] * d[j - 1];
    u[j] = state == 0 ? 0.5 * size * random_number(draws) : state == 2 ? -size * d[j - 1] : 0;
  }
}

static void draw(known *k, int states, unsigned seed)
{
  random_state draws = {seed};
  const int per = states & PLANAR ? 2 : 3, m = per * CONTACTS;
  double B[ROWS * ROWS];
  memset(k, 0, sizeof *k);
  k->per = per;
  random_matrix(&draws, m, m, B, m);
  for (int i = 0; i < m; i++)
    for (int j = 0; j < m; j++) {
      k->W[j * m + i] = i == j;
      for (int l = 0; l < m; l++) k->W[j * m + i] += 0.1 * B[l * m + i] * B[l * m + j];
    }
  for (int c = 0; c < CONTACTS; c++) {
    k->rows[c] = per;
    k->mu[c] = 0.1 + 0.2 * fabs(random_number(&draws));
    draw_contact(k, c, states, &draws);
  }
  double *to = k->value;
  for (int c = 0; c <= CONTACTS; c++) k->first[c] = c * CONTACTS;
  for (int c = 0; c < CONTACTS; c++)
    for (int b = 0; b < CONTACTS; b++) {
      k->block[c * CONTACTS + b] = b;
      for (int j = per * c; j < per * (c + 1); j++)
        for (int i = per * b; i < per * (b + 1); i++) *to++ = k->W[j * m + i];
    }
  for (int i = 0; i < m; i++) {
    k->q[i] = k->u[i];
    for (int j = 0; j < m; j++) k->q[i] -= k->W[j * m + i] * k->r[j];
  }
  k->p = (nsdae_friction_problem){.form = NSDAE_FRICTION_LOCAL,
                                  .contacts = CONTACTS,
                                  .rows = k->rows,
                                  .mu = k->mu,
                                  .w = k->q,
                                  .first = k->first,
                                  .block = k->block,
                                  .value = k->value};
}

/* Largest entry of r - the solution. */
static double distance(const known *k, const double *r)
{
  double most = 0;
  for (int i = 0; i < k->per * CONTACTS; i++) most = fmax(most, fabs(r[i] - k->r[i]));
  return most;
}

/* A solver, its bit, the solutions it is for, and how near it begins. */
typedef struct solver {
  const char *name;
  nsdae_fc_solve *solve;
  int bit, states;
  double begin; /* relative to the solution; 0: at r = 0 */
  double tol;
} solver;

static const solver solvers[] = {
    {"nsgs", nsdae_fc_nsgs, NSDAE_FRICTION_NSGS, ANY, 0, 1e-11},
    {"nsgs", nsdae_fc_nsgs_plain, 0, ANY, 0, 1e-11},
    {"semismooth-newton", nsdae_fc_semismooth_newton, NSDAE_FRICTION_SEMISMOOTH_NEWTON, ANY, 0,
     1e-12},
    {"smoothing-homotopy", nsdae_fc_smoothing_homotopy, NSDAE_FRICTION_SMOOTHING_HOMOTOPY, ANY, 0,
     1e-12},
    {"aclm", nsdae_fc_aclm, NSDAE_FRICTION_ACLM, ANY, 0, 1e-12},
    {"socp-interior-point", nsdae_fc_socp_interior_point, NSDAE_FRICTION_SOCP_INTERIOR_POINT,
     NO_SLIP, 0, 1e-7},
    {"as-lcp", nsdae_fc_lcp, NSDAE_FRICTION_AS_LCP, PLANAR, 0, 1e-12},
    {"iterative-refinement", nsdae_fc_refine, 0, ANY, 1e-8, 1e-15},
};
enum { SOLVERS = sizeof solvers / sizeof *solvers };

/* The residual of the iterate, anew. */
static double residual_of(solver_island *s)
{
  double r[ROWS], low[ROWS], residual;
  memset(low, 0, sizeof low);
  nsdae_fc_scatter(&s->run.island.fc, s->run.iterate.r, r);
  nsdae_fc_scatter(&s->run.island.fc, s->run.iterate.low, low);
  assert_int_equal(nsdae_friction_residual_twice(s->global.view.p, r, low, NULL, &residual),
                   NSDAE_OK);
  return residual;
}

static void begin_near(solver_island *s, const known *k, double by)
{
  double r[ROWS];
  for (int i = 0; i < k->per * CONTACTS; i++) r[i] = by > 0 ? k->r[i] * (1 + by * (i % 3 - 1)) : 0;
  nsdae_fc_fill(&s->run.island.fc, r);
  memcpy(s->run.iterate.r, s->run.island.fc.r, nsdae_fc_bytes(&s->run.island));
  nsdae_fc_set_point(&s->run.island, s->run.iterate.r);
  s->run.iterate.residual = INFINITY;
  nsdae_fc_offer(&s->run.island, &s->run.iterate);
}

static void check_known(const solver *of, unsigned seed)
{
  known k;
  solver_island s;
  double r[ROWS], tol = of->tol;
  draw(&k, of->states, seed);
  solver_island_make(&s, &k.p);
  begin_near(&s, &k, of->begin);
  const nsdae_fc_budget budget = unbounded(tol);
  const double before = s.run.iterate.residual;
  if (!(before <= tol)) assert_int_equal(of->solve(&s.run.island, &s.run.iterate, &budget), 1);
  assert_at_most(s.run.iterate.residual, tol);
  assert_near(residual_of(&s), s.run.iterate.residual, 1e-14 + 1e-3 * s.run.iterate.residual);
  nsdae_fc_scatter(&s.run.island.fc, s.run.iterate.r, r);
  assert_at_most(distance(&k, r), 100 * tol + 1e-12);
  assert_null(s.run.island.fc.base.high);
  solver_island_release(&s);
}

static void test_known(void **state)
{
  (void)state;
  for (int i = 0; i < SOLVERS; i++)
    for (unsigned seed = 1; seed <= SEEDS; seed++) check_known(&solvers[i], seed);
}

/* The same by its bit alone: the solution is found, and named as that solver's. */
static void test_bits(void **state)
{
  (void)state;
  for (int i = 0; i < SOLVERS; i++)
    for (unsigned seed = 1; seed <= SEEDS && solvers[i].bit; seed++) {
      known k;
      double r[ROWS] = {0}, u[ROWS];
      nsdae_friction_info info;
      nsdae_friction_options options;
      nsdae_friction_options_default(&options);
      draw(&k, solvers[i].states, seed);
      options.tol = 1.3 * solvers[i].tol; /* an island is solved to 0.8 of it */
      options.stages = solvers[i].bit;
      assert_int_equal(nsdae_friction_solve(&k.p, &options, r, u, &info), NSDAE_OK);
      assert_string_equal(nsdae_friction_stage_name(info.stage), solvers[i].name);
      assert_at_most(distance(&k, r), 200 * solvers[i].tol + 1e-12);
    }
}

/* On problems of rigid bodies with more rows than freedoms: whatever the budget, the iterate gets
 * no worse, and the budget is exceeded by no more than the last step or evaluation. */
static void test_budgets(void **state)
{
  (void)state;
  for (unsigned seed = 1; seed <= 12; seed++) {
    friction_sample sample;
    solver_island s;
    friction_sample_draw(&sample, (int)(seed % FRICTION_FAMILIES), 40, seed);
    solver_island_make(&s, &sample.problem);
    assert_true(nsdae_fc_system_ready(&s.run.island));
    const double step = 20 + 2 * s.system.cost;
    for (int i = 0; i < SOLVERS; i++)
      for (double products = 1; products < 3e4; products *= 5) {
        nsdae_fc_budget budget = unbounded(1e-12);
        const double before = s.run.iterate.residual;
        budget.products = s.run.iterate.work.products + products;
        int ended = solvers[i].solve(&s.run.island, &s.run.iterate, &budget);
        assert_true(s.run.iterate.residual <= before || solvers[i].solve == nsdae_fc_refine);
        assert_int_equal(ended == 1, s.run.iterate.residual <= budget.tol);
        const int sweeps =
            solvers[i].solve == nsdae_fc_nsgs || solvers[i].solve == nsdae_fc_nsgs_plain;
        assert_true(s.run.iterate.work.products <= budget.products + (sweeps ? 2 : step));
      }
    solver_island_release(&s);
    friction_sample_release(&sample);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_known), cmocka_unit_test(test_bits),
                                     cmocka_unit_test(test_budgets)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
