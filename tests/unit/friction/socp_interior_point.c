/* The equations of a step where most items are locked: how well what is found solves them, in long
 * double, with refinement and without. And the convex problem with a fixed shift, by its own
 * natural map. */
#include "check.h"

#include <float.h>
#include <stdlib.h>
#include <string.h>

#include "../linalg/random_matrices.h"
#include "cone.h"
#include "friction_families.h"
#include "solver_island.h"

enum { CONTACTS = 200, SEEDS = 24 };

/* What rounding leaves of dr without refinement is 1e-16 / ALPHA of it, and with it the square. */
static const double ALPHA = 1e-10;

/* How far outside a cone a point may be by rounding, of itself. */
static const double EDGE = 8 * DBL_EPSILON;

typedef struct equations {
  solver_island at;
  nsdae_arena work;
  double *b, *dr;
} equations;

static nsdae_fc_scaled *scaled(const equations *s)
{
  return (nsdae_fc_scaled *)(uintptr_t)&s->at.run.island.fc;
}

static void lay_out(void *object, nsdae_arena *arena)
{
  equations *s = object;
  s->b = NSDAE_ARENA_DOUBLES(arena, 3L * scaled(s)->n);
  s->dr = NSDAE_ARENA_DOUBLES(arena, 3L * scaled(s)->n);
}

static void make(equations *s, const friction_sample *sample)
{
  *s = (equations){.b = NULL};
  solver_island_make(&s->at, &sample->problem);
  assert_true(nsdae_fc_system_ready(&s->at.run.island));
  assert_int_equal(nsdae_arena_fit(&s->work, lay_out, s), NSDAE_OK);
}

static void release(equations *s)
{
  nsdae_arena_release(&s->work);
  solver_island_release(&s->at);
}

/* A few items open, E = 1 and A = 0, and the others locked, E = ALPHA and A = 1; b what impulses in
 * them do. */
static void draw(equations *s, random_state *draws)
{
  const int m = 3 * s->at.run.island.fc.n;
  memset(s->at.run.island.newton.E, 0,
         9 * (size_t)s->at.run.island.fc.n * sizeof *s->at.run.island.newton.E);
  memset(s->at.run.island.newton.A, 0,
         9 * (size_t)s->at.run.island.fc.n * sizeof *s->at.run.island.newton.A);
  for (int i = 0; i < m; i++) {
    const int open = i / 3 % 5 == 0, at = 9 * (i / 3) + 4 * (i % 3);
    s->at.run.island.newton.E[at] = open ? 1 : ALPHA;
    s->at.run.island.newton.A[at] = !open;
    s->dr[i] = open ? 0 : random_number(draws);
  }
  nsdae_fc_response(&s->at.run.island.fc, s->dr, s->at.run.island.newton.y, s->b);
  for (int i = 0; i < m; i++) s->b[i] *= i / 3 % 5 != 0;
}

/* Largest entry of b - E dr - A J^T J dr. */
static double rest(const equations *s)
{
  const nsdae_fc_scaled *c = &s->at.run.island.fc;
  long double *y = calloc((size_t)c->ny, sizeof *y), most = 0;
  for (int k = 0; k < c->n; k++)
    for (int e = c->parts.first[k]; e < c->parts.first[k + 1]; e++) {
      const int size = c->parts.size[c->parts.block[e]], at = c->parts.offset[c->parts.block[e]];
      for (int i = 0; i < 3 * size; i++)
        y[at + i % size] += (long double)nsdae_fc_part(c, e)[i] * s->dr[3 * k + i / size];
    }
  for (int k = 0; k < c->n; k++)
    for (int j = 0; j < 3; j++) {
      const int i = 3 * k + j;
      long double u = 0;
      for (int e = c->parts.first[k]; e < c->parts.first[k + 1]; e++) {
        const int size = c->parts.size[c->parts.block[e]], at = c->parts.offset[c->parts.block[e]];
        for (int l = 0; l < size; l++) u += nsdae_fc_part(c, e)[j * size + l] * y[at + l];
      }
      const size_t at = 9 * (size_t)k + 4 * (size_t)j;
      most = fmaxl(most, fabsl(s->b[i] - (long double)s->at.run.island.newton.E[at] * s->dr[i] -
                               s->at.run.island.newton.A[at] * u));
    }
  free(y);
  return (double)most;
}

static void test_refined(void **state)
{
  random_state draws = {7};
  double worst = 0, plain = 0;
  (void)state;
  for (int seed = 0; seed < SEEDS; seed++) {
    friction_sample sample = {0};
    equations s;
    friction_sample_draw(&sample, seed % FRICTION_FAMILIES, CONTACTS, (unsigned)seed + 1);
    make(&s, &sample);
    draw(&s, &draws);
    assert_int_equal(
        nsdae_fc_system_factor(&s.at.system, s.at.run.island.newton.E, s.at.run.island.newton.A),
        0);
    nsdae_fc_system_solve(&s.at.system, s.b, s.dr);
    plain = fmax(plain, rest(&s));
    nsdae_fc_newton_solve(&s.at.run.island.newton, s.b, s.dr);
    worst = fmax(worst, rest(&s));
    release(&s);
    friction_sample_release(&sample);
  }
  print_message("rest %.1e, refined %.1e\n", plain, worst);
  assert_true(plain > 1e-6);
  assert_at_most(worst, 1e-3 * plain);
}

/* The largest entry of r - P(r - u^) of item k, u^ = u + shift e_N, P the projection onto the cone
 * as it is defined. */
static double convex_residual(const equations *s, int k)
{
  const nsdae_fc_scaled *c = &s->at.run.island.fc;
  const int cone = c->items.kind[k] == NSDAE_FC_CONE;
  const double *r = c->r + 3 * k, *u = c->u + 3 * k, mu = cone ? c->items.mu[k] : 0;
  double z[3] = {r[0] - u[0] - (cone ? s->at.run.island.socp.s[k] : 0), cone ? r[1] - u[1] : 0,
                 cone ? r[2] - u[2] : 0};
  double t = hypot(z[1], z[2]), most = 0;
  if (z[0] < 0 || t > mu * z[0]) {
    double n = fmax(0, (z[0] + mu * t) / (1 + mu * mu));
    z[0] = n;
    for (int j = 1; j < 3; j++) z[j] *= t > 0 ? mu * n / t : 0;
  }
  for (int j = 0; j < 3; j++) most = fmax(most, fabs(r[j] - z[j]));
  return most;
}

/* What r and b, inside their cones but for EDGE of themselves, allow it to be. If they are, p = P(r
 * - b) has (r - b - p) . (r - p) <= 0, since r is in the cone; so |r - p|^2 <= b . (r - p) <= b .
 * r, since b is in the dual cone and p in the cone. P enlarges neither what they are moved by to be
 * inside nor what u^ differs from b by. */
static double allowed(const equations *s, int k)
{
  const double *a = s->at.run.island.socp.a + 3 * k, *b = s->at.run.island.socp.b + 3 * k;
  double product = 2 * EDGE * a[0] * b[0], gap = 0, moved;
  for (int i = 0; i < 3; i++) {
    product += a[i] * b[i];
    gap += s->at.run.island.socp.gap[3 * k + i] * s->at.run.island.socp.gap[3 * k + i];
  }
  moved = EDGE * (2 * s->at.run.island.fc.r[3 * k] + fabs(s->at.run.island.fc.u[3 * k]) +
                  s->at.run.island.socp.s[k]);
  return sqrt(product) + sqrt(gap) + moved;
}

static int in_cone(const double *x)
{
  return x[0] > 0 && hypot(x[1], x[2]) <= (1 + EDGE) * x[0];
}

/* The largest residual; each is what r . b allows, whose mean is what counts as solved. */
static double check_convex(const equations *s)
{
  double worst = 0, sum = 0;
  for (int k = 0; k < s->at.run.island.fc.n; k++) {
    const double *a = s->at.run.island.socp.a + 3 * k, *b = s->at.run.island.socp.b + 3 * k;
    assert_true(in_cone(a) && in_cone(b));
    assert_at_most(convex_residual(s, k), allowed(s, k));
    worst = fmax(worst, convex_residual(s, k));
    for (int i = 0; i < 3; i++) sum += a[i] * b[i];
  }
  assert_at_most(sum / s->at.run.island.fc.n, 1e-6);
  return worst;
}

/* Whatever the shift, the problem has a solution, from the solution of another shift as from r = 0.
 * As a rule r . b ends at 1e-12, at most at a tenth of them before, where the step of a contact
 * whose slack and impulse are both zero is of rounding. */
static void test_convex(void **state)
{
  random_state draws = {11};
  double worst = 0;
  int inexact = 0;
  (void)state;
  for (int seed = 0; seed < SEEDS; seed++) {
    friction_sample sample = {0};
    equations s;
    friction_sample_draw(&sample, seed % FRICTION_FAMILIES, CONTACTS, (unsigned)seed + 1);
    make(&s, &sample);
    for (int again = 0; again < 3; again++) {
      for (int k = 0; k < s.at.run.island.fc.n; k++)
        s.at.run.island.socp.s[k] = again == 0 ? 0 : fabs(random_number(&draws));
      const nsdae_fc_budget budget = unbounded(1e-7);
      assert_int_equal(nsdae_fc_socp_run(&s.at.run.island, &s.at.run.iterate, &budget), 1);
      double residual = check_convex(&s);
      worst = fmax(worst, residual);
      inexact += residual > 1e-6;
    }
    release(&s);
    friction_sample_release(&sample);
  }
  print_message("residual %.1e, %d of %d above 1e-6\n", worst, inexact, 3 * SEEDS);
  assert_true(10 * inexact <= 3 * SEEDS);
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_refined), cmocka_unit_test(test_convex)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
