/* A four-bar linkage with clearance at three of its pins, each a disc in a hole, whose crank a
 * controller leads along theta_d = 6 sin(3 pi t / 4), against the reference results of the Siconos
 * project for it: see data/four_bar_clearance.csv. */
#include "check.h"

#include <nsdae/nsdae.h>

static const double crank = 1, coupler = 4, rocker = 2.5, ground = 3, g = 9.81, pin = 0.055,
                    hole = 0.06;

enum { ROWS = 20, WORDS = 7 };

/* t, angles of crank, coupler and rocker, and their rates. */
static double table[ROWS][WORDS];

static int read_table(void **state)
{
  FILE *file = fopen(NSDAE_DATA_DIR "/four_bar_clearance.csv", "r");
  char line[256];
  int rows = 0;
  (void)state;
  assert_non_null(file);
  while (rows < ROWS && fgets(line, sizeof line, file)) {
    double *r = table[rows];
    if (sscanf(line, "%lf,%lf,%lf,%lf,%lf,%lf,%lf", r, r + 1, r + 2, r + 3, r + 4, r + 5, r + 6) ==
        WORDS)
      rows++;
  }
  fclose(file);
  assert_int_equal(rows, ROWS);
  return 0;
}

/* Of the linkage without clearance at a crank angle: angles of coupler and rocker (as the rocker's
 * circle meets the coupler's), and their first and second derivatives by the crank's. */
typedef struct loop {
  double angle[2], first[2], second[2];
} loop;

static loop ideal(double theta)
{
  loop l;
  double x = crank * cos(theta), y = crank * sin(theta), dx = ground - x, square = dx * dx + y * y;
  double along = (coupler * coupler - rocker * rocker + square) / (2 * square);
  double across = sqrt(coupler * coupler / square - along * along);
  double px = x + along * dx + across * y, py = y - along * y + across * dx;
  double a = l.angle[0] = atan2(py - y, px - x), p = l.angle[1] = atan2(py, px - ground);
  double s = sin(a - p), by_a = crank / coupler, by_p = crank / rocker;
  l.first[0] = by_a * sin(p - theta) / s;
  l.first[1] = by_p * sin(a - theta) / s;
  double slope = cos(a - p) * (l.first[0] - l.first[1]) / s;
  l.second[0] = by_a * cos(p - theta) * (l.first[1] - 1) / s - l.first[0] * slope;
  l.second[1] = by_p * cos(a - theta) * (l.first[0] - 1) / s - l.first[1] * slope;
  return l;
}

/* A load on the crank's tip, which says its angle in 0 .. 2 pi. That of the results' source, letter
 * for letter: with M(theta) theta'' + M' theta'^2 / 2 + U' the
 * ideal linkage (but for the rocker's J in M', where its own about the centre stands), e = theta -
 * theta_d,
 *
 *   tau = M (theta_d'' - 10 e') + M' theta' (theta' - 10 e) / 2 - 200 (e' + 10 e) + U' */
static int control(double t, const double x[3], const double v[3], double force[3],
                   double torque[3], void *user)
{
  const double w = 0.75 * acos(-1), turn = x[1] < 0 ? 2 * acos(-1) : 0;
  const double theta = atan2(x[1], x[0]) + turn;
  const double rate = (x[0] * v[1] - x[1] * v[0]) / (crank * crank);
  const double J1 = crank * crank / 3 + crank * crank, J2 = coupler * coupler / 3,
               J3 = rocker * rocker / 3, J3c = rocker * rocker / 12, P = crank * coupler / 2;
  double e = theta - 6 * sin(w * t), de = rate - 6 * w * cos(w * t);
  loop l = ideal(theta);
  double a = l.first[0], b = l.first[1], c = cos(theta - l.angle[0]), s = sin(theta - l.angle[0]);
  double M = J1 + J2 * a * a + J3 * b * b + 2 * P * c * a;
  double half =
      J2 * a * l.second[0] + 2 * J3c * b * l.second[1] + P * (c * l.second[0] - s * (1 - a) * a);
  double U = g * (1.5 * crank * cos(theta) + a * coupler * cos(l.angle[0]) / 2 +
                  b * rocker * cos(l.angle[1]) / 2);
  (void)force, (void)user;
  torque[2] = M * (-6 * w * w * sin(w * t) - 10 * de) + half * rate * (rate - 10 * e) -
              200 * (de + 10 * e) + U;
  return 0;
}

/* Pin i is the disc of body[0], hole i that of body[1], in their own frames. */
static void add_pin(nsdae_bodies *b, const int body[2], double at0, double at1)
{
  int disc = nsdae_bodies_add_solid(
      b, body[0], &(nsdae_solid){.shape = NSDAE_SHAPE_DISC, .radius = pin, .position = {at0}});
  int eye = nsdae_bodies_add_solid(
      b, body[1],
      &(nsdae_solid){.shape = NSDAE_SHAPE_DISC, .radius = hole, .hollow = 1, .position = {at1}});
  nsdae_bodies_add_contact(b, eye, disc, 0.1, 0, 0);
}

/* At rest; the pins are about in the middle of their holes. */
static nsdae_bodies *build(void)
{
  const double angle[3] = {1.570823772407980, 0.3532842020624460, 1.264872058968431},
               at[3][2] = {{crank / 2 * cos(angle[0]), crank / 2 * sin(angle[0])},
                           {1.876454585097650, 1.691962091335582},
                           {ground + 0.3764686197082958, 1.191962183453451}},
               length[3] = {crank, coupler, rocker};
  nsdae_bodies *b;
  assert_int_equal(nsdae_bodies_create(2, &b, NULL), NSDAE_OK);
  nsdae_bodies_set_gravity(b, (const double[]){0, -g, 0});
  for (int i = 0; i < 3; i++)
    nsdae_bodies_add(b, &(nsdae_rigid_body){.mass = 1,
                                            .inertia = {0, 0, length[i] * length[i] / 12},
                                            .position = {at[i][0], at[i][1]},
                                            .angle = angle[i]});
  nsdae_bodies_add_joint(b,
                         &(nsdae_joint){.kind = NSDAE_JOINT_REVOLUTE, .body = {NSDAE_GROUND, 0}});
  add_pin(b, (const int[]){0, 1}, crank / 2, -coupler / 2);
  add_pin(b, (const int[]){1, 2}, coupler / 2, rocker / 2);
  add_pin(b, (const int[]){2, NSDAE_GROUND}, -rocker / 2, ground);
  nsdae_bodies_add_load(b, 0, (const double[]){2 * at[0][0], 2 * at[0][1], 0}, control, NULL);
  return b;
}

typedef struct run {
  double is[ROWS][WORDS];
  int rows;
} run;

static int follow(const nsdae_record *r, nsdae_error *error, void *user)
{
  run *out = user;
  (void)error;
  if (out->rows == ROWS || fabs(r->time - table[out->rows][0]) > 1e-9) return 0;
  const double is[WORDS] = {r->time, r->q[2], r->q[5], r->q[8], r->v[2], r->v[5], r->v[8]};
  memcpy(out->is[out->rows++], is, sizeof is);
  return 0;
}

static run simulate(int method, double dt)
{
  nsdae_bodies *b = build();
  nsdae_system *system;
  nsdae_sim *sim;
  run out = {.rows = 0};
  double q[9], v[9];
  nsdae_sim_options options;
  nsdae_sim_options_default(&options);
  options.method = method;
  options.dt = dt;
  options.rtol = 1e-10;
  options.atol = 1e-12;
  assert_int_equal(nsdae_bodies_system(b, &system), NSDAE_OK);
  nsdae_bodies_get_start(b, q, v);
  assert_int_equal(nsdae_sim_create(system, &options, &sim, NULL), NSDAE_OK);
  int status = nsdae_sim_init(sim, 0, q, v);
  if (status < 0) print_error("%s\n", nsdae_sim_error(sim)->text);
  assert_int_equal(status, NSDAE_OK);
  nsdae_sim_observe(sim, follow, &out);
  status = nsdae_sim_run(sim, table[ROWS - 1][0]);
  if (status < 0) print_error("%s\n", nsdae_sim_error(sim)->text);
  assert_true(status >= 0);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  nsdae_bodies_destroy(&b);
  assert_int_equal(out.rows, ROWS);
  return out;
}

/* The most that angles (word 1) or rates (word 4) differ in all rows. */
static double apart(const run *a, const double (*b)[WORDS], int word)
{
  double most = 0;
  for (int i = 0; i < ROWS; i++)
    for (int j = word; j < word + 3; j++) most = fmax(most, fabs(a->is[i][j] - b[i][j]));
  return most;
}

/* The published numbers are those of a scheme of first order in steps of 1e-4 s, whose smooth part
 * is of second order: they come nearer to the solution than Moreau's scheme with that step, which
 * with a tenth of it is nearer by about ten. */
static void test_published(void **state)
{
  (void)state;
  run event = simulate(NSDAE_METHOD_EVENT, 1e-4), coarse = simulate(NSDAE_METHOD_MOREAU, 1e-4);
  run fine = simulate(NSDAE_METHOD_MOREAU, 1e-5);
  for (int word = 1; word < WORDS; word += 3) {
    double theirs = apart(&event, (const double(*)[WORDS])table, word);
    double ours = apart(&event, (const double(*)[WORDS])coarse.is, word);
    double finer = apart(&event, (const double(*)[WORDS])fine.is, word);
    print_message("published %.1e, moreau %.1e, in a tenth of the step %.1e\n", theirs, ours,
                  finer);
    assert_at_most(theirs, ours / 4);
    assert_at_most(finer, ours / 5);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_published)};
  return cmocka_run_group_tests(tests, read_table, NULL);
}
