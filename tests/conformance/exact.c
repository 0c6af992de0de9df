/* Every method on the exact cases of data/conformance, with its own order: event to its tolerance,
 * time-stepping to an error in proportion to dt. */
#include "check.h"

#include <stdlib.h>
#include <string.h>

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

/* ---- block.csv: a rectangle with points along its base, whose forces may depend on each other,
 * that rocks, or that jams */

typedef struct block {
  char name[64];
  double a, b, points, tilt, mu, g, phi0, v0, w0, t_end, x, phi, vx, w, t_jam; /* NAN: not given */
} block;

/* Point i from the centre: half the base a, half the height b. */
static void arm(const block *b, int i, double phi, double *r)
{
  double X = b->a * (2 * i / (b->points - 1) - 1);
  r[0] = X * cos(phi) + b->b * sin(phi);
  r[1] = X * sin(phi) - b->b * cos(phi);
}

static int block_mass(double t, const double *q, double *M, int ldm, void *user)
{
  const block *b = user;
  (void)t;
  (void)q;
  M[0] = M[ldm + 1] = 1;
  M[2 * ldm + 2] = (b->a * b->a + b->b * b->b) / 3;
  return 0;
}

static int block_force(double t, const double *q, const double *v, double *F, void *user)
{
  const block *b = user;
  (void)t;
  (void)q;
  (void)v;
  F[0] = b->g * sin(b->tilt);
  F[1] = -b->g * cos(b->tilt);
  return 0;
}

static int block_gap(double t, const double *q, double *distance, void *user)
{
  const block *b = user;
  double r[2];
  (void)t;
  for (int i = 0; i < b->points; i++) {
    arm(b, i, q[2], r);
    distance[i] = q[1] + r[1];
  }
  return 0;
}

static int block_normal(double t, const double *q, double *W, int ldw, void *user)
{
  const block *b = user;
  double r[2];
  (void)t;
  for (int i = 0; i < b->points; i++) {
    arm(b, i, q[2], r);
    W[i * ldw + 1] = 1;
    W[i * ldw + 2] = r[0];
  }
  return 0;
}

static int block_tangent(double t, const double *q, double *W, int ldw, void *user)
{
  const block *b = user;
  double r[2];
  (void)t;
  for (int i = 0; i < b->points; i++) {
    arm(b, i, q[2], r);
    W[i * ldw] = 1;
    W[i * ldw + 2] = -r[1];
  }
  return 0;
}

static nsdae_system *block_system(block *b)
{
  const nsdae_dims dims = {.nq = 3, .k = (int)b->points, .nt = 1};
  nsdae_system *system;
  assert_int_equal(nsdae_system_create(&dims, &system, NULL), NSDAE_OK);
  nsdae_system_set_user(system, b);
  nsdae_system_set_mass(system, block_mass);
  nsdae_system_set_force(system, block_force);
  nsdae_system_set_gap(system, block_gap);
  nsdae_system_set_gap_normal(system, block_normal);
  nsdae_system_set_gap_tangent(system, block_tangent);
  for (int i = 0; i < dims.k; i++) nsdae_system_set_contact(system, i, b->mu, 0, 0);
  return system;
}

static nsdae_sim *block_start(const block *b, nsdae_system *system, const char *method, double dt)
{
  double r[2], q0[3] = {0, 0, b->phi0}, v0[3] = {0, 0, b->w0};
  nsdae_sim_options o;
  nsdae_sim *sim;
  arm(b, 0, b->phi0, r); /* the lowest */
  q0[1] = -r[1];
  v0[0] = b->v0 + r[1] * b->w0;
  v0[1] = -r[0] * b->w0;
  nsdae_sim_options_default(&o);
  assert_int_equal(nsdae_sim_options_set(&o, "method", method, NULL), NSDAE_OK);
  o.dt = dt;
  o.rtol = 1e-10;
  o.atol = 1e-12;
  assert_int_equal(nsdae_sim_create(system, &o, &sim, NULL), NSDAE_OK);
  assert_int_equal(nsdae_sim_init(sim, 0, q0, v0), NSDAE_OK);
  return sim;
}

/* Error at the end of what is given, the largest; angles as ways of a corner. */
static double block_error(block *b, const char *method, double dt)
{
  nsdae_record r;
  nsdae_system *system = block_system(b);
  nsdae_sim *sim = block_start(b, system, method, dt);
  assert_true(nsdae_sim_run(sim, b->t_end) >= NSDAE_OK);
  nsdae_sim_get_record(sim, &r);
  double R = hypot(b->a, b->b), worst = 0;
  double off[] = {r.q[0] - b->x, R * (r.q[2] - b->phi), r.v[0] - b->vx, R * (r.v[2] - b->w)};
  for (int i = 0; i < 4; i++) worst = fmax(worst, fabs(off[i])); /* without NAN */
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  return worst;
}

/* How far the time is off at which the forces are found to be without bound. */
static double jam_error(block *b)
{
  nsdae_system *system = block_system(b);
  nsdae_sim *sim = block_start(b, system, "event", 5e-3);
  assert_int_equal(nsdae_sim_run(sim, b->t_jam + 0.1), NSDAE_E_PAINLEVE);
  double off = fabs(nsdae_sim_error(sim)->time - b->t_jam);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  return off;
}

/* The numbers of a line behind the name; NAN where there is none. */
static void read_block(char *line, block *b)
{
  double *to = &b->a;
  char *at = strchr(line, ',');
  assert_non_null(at);
  snprintf(b->name, sizeof b->name, "%.*s", (int)(at - line), line);
  for (int i = 0; i < 15; i++) {
    char *end;
    assert_non_null(at);
    to[i] = strtod(at + 1, &end);
    if (end == at + 1) to[i] = NAN;
    at = strchr(at + 1, ',');
  }
  assert_null(at);
}

static void test_block(void **state)
{
  (void)state;
  FILE *file = fopen(NSDAE_DATA_DIR "/conformance/block.csv", "r");
  char line[512];
  int cases = 0;
  assert_non_null(file);
  assert_non_null(fgets(line, sizeof line, file));
  for (; fgets(line, sizeof line, file); cases++) {
    block b;
    read_block(line, &b);
    double event = block_error(&b, "event", 5e-3), implicit = block_error(&b, "implicit", 1e-4),
           moreau = block_error(&b, "moreau", 1e-4), jam = isnan(b.t_jam) ? 0 : jam_error(&b),
           printed = block_error(&b, "implicit-printed", 1e-4),
           penalty = block_error(&b, "penalty", 1e-3);
    print_message("%-30s event %.1e, dt 1e-4: implicit %.1e, printed %.1e, moreau %.1e; penalty "
                  "%.1e",
                  b.name, event, implicit, printed, moreau, penalty);
    print_message(isnan(b.t_jam) ? "\n" : ", jams %.1e\n", jam);
    assert_at_most(event, 1e-9); /* ten times rtol */
    assert_at_most(implicit, 100 * 1e-4);
    assert_at_most(moreau, 100 * 1e-4);
    assert_at_most(printed, 100 * 1e-4);
    /* friction that holds creeps by up to friction_velocity, an impact lasts a millisecond of g */
    assert_at_most(penalty, 1e-3 * b.t_end + 1e-3 * b.g);
    assert_at_most(jam, 1e-8);
  }
  fclose(file);
  assert_true(cases >= 12);
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_ball), cmocka_unit_test(test_block)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
