/* Every method on the exact cases of data/conformance/ball.csv, with its own order: event to its
 * tolerance, time-stepping to an error in proportion to dt. */
#include "check.h"

#include <stdlib.h>

#include <nsdae/nsdae.h>

typedef struct ball {
  char name[64];
  double tilt, mu, e, h, v0, w0, t_end, q[2], v[3]; /* q, v: x, y; vx, vy, w at t_end */
} ball;

static const double radius = 0.1, g = 9.81;

static int mass(double t, const double *q, double *M, int ldm, void *user)
{
  (void)t;
  (void)q;
  (void)user;
  M[0] = M[ldm + 1] = 1;
  M[2 * ldm + 2] = 0.4 * radius * radius;
  return 0;
}

static int force(double t, const double *q, const double *v, double *F, void *user)
{
  const ball *b = user;
  (void)t;
  (void)q;
  (void)v;
  F[0] = g * sin(b->tilt);
  F[1] = -g * cos(b->tilt);
  return 0;
}

static int gap(double t, const double *q, double *distance, void *user)
{
  (void)t;
  (void)user;
  distance[0] = q[1];
  return 0;
}

static int normal(double t, const double *q, double *W, int ldw, void *user)
{
  (void)t;
  (void)q;
  (void)ldw;
  (void)user;
  W[1] = 1;
  return 0;
}

static int tangent(double t, const double *q, double *W, int ldw, void *user)
{
  (void)t;
  (void)q;
  (void)ldw;
  (void)user;
  W[0] = 1;
  W[2] = radius;
  return 0;
}

/* Error of positions and velocities at the end, the largest. */
static double error_of(ball *b, const char *method, double dt)
{
  const nsdae_dims dims = {.nq = 3, .k = 1, .nt = 1};
  double q0[3] = {0, b->h, 0}, v0[3] = {b->v0, 0, b->w0}, worst = 0;
  nsdae_sim_options o;
  nsdae_system *system;
  nsdae_sim *sim;
  nsdae_record r;
  nsdae_sim_options_default(&o);
  assert_int_equal(nsdae_sim_options_set(&o, "method", method, NULL), NSDAE_OK);
  o.dt = dt;
  o.rtol = 1e-10;
  o.atol = 1e-12;
  assert_int_equal(nsdae_system_create(&dims, &system, NULL), NSDAE_OK);
  nsdae_system_set_user(system, b);
  nsdae_system_set_mass(system, mass);
  nsdae_system_set_force(system, force);
  nsdae_system_set_gap(system, gap);
  nsdae_system_set_gap_normal(system, normal);
  nsdae_system_set_gap_tangent(system, tangent);
  nsdae_system_set_contact(system, 0, b->mu, b->e, 0);
  assert_int_equal(nsdae_sim_create(system, &o, &sim, NULL), NSDAE_OK);
  assert_int_equal(nsdae_sim_init(sim, 0, q0, v0), NSDAE_OK);
  assert_int_equal(nsdae_sim_run(sim, b->t_end), NSDAE_OK);
  nsdae_sim_get_record(sim, &r);
  for (int i = 0; i < 2; i++) worst = fmax(worst, fabs(r.q[i] - b->q[i]));
  for (int i = 0; i < 3; i++) worst = fmax(worst, fabs(r.v[i] - b->v[i]) * (i == 2 ? radius : 1));
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  return worst;
}

static void test_ball(void **state)
{
  (void)state;
  FILE *file = fopen(NSDAE_DATA_DIR "/conformance/ball.csv", "r");
  char line[512];
  int cases = 0;
  assert_non_null(file);
  assert_non_null(fgets(line, sizeof line, file));
  for (; fgets(line, sizeof line, file); cases++) {
    ball b = {0};
    assert_int_equal(sscanf(line, "%63[^,],%lf,%lf,%lf,%lf,%lf,%lf,%lf,%lf,%lf,%lf,%lf,%lf", b.name,
                            &b.tilt, &b.mu, &b.e, &b.h, &b.v0, &b.w0, &b.t_end, &b.q[0], &b.q[1],
                            &b.v[0], &b.v[1], &b.v[2]),
                     13);
    double event = error_of(&b, "event", 5e-3), implicit = error_of(&b, "implicit", 1e-4),
           moreau = error_of(&b, "moreau", 1e-4);
    print_message("%-22s event %.1e, dt 1e-4: implicit %.1e, moreau %.1e\n", b.name, event,
                  implicit, moreau);
    assert_at_most(event, 1e-9); /* ten times rtol */
    /* an impact is up to one dt late, times the jump of the velocity and, at the end, g */
    assert_at_most(implicit, 100 * 1e-4);
    assert_at_most(moreau, 100 * 1e-4);
  }
  fclose(file);
  assert_true(cases >= 13);
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_ball)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
