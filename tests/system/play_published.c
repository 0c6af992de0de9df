/* Mechanisms whose joints have play against published results, those of the Siconos project (see
 * the heads of data/slider_crank_clearance.csv and data/four_bar_clearance.csv): a slider-crank
 * whose slider has play in its guide, and a four-bar linkage of which three pins are discs in
 * holes, whose crank a controller leads along theta_d = 6 sin(3 pi t / 4). */
#include "check.h"

#include <nsdae/nsdae.h>
#include <stdlib.h>

enum { ROWS_MAX = 20, WORDS_MAX = 7 };

/* Rows of numbers, the time first. */
typedef struct series {
  int rows;
  double is[ROWS_MAX][WORDS_MAX];
} series;

typedef struct mechanism {
  const char *file;
  int words; /* of a row */
  nsdae_bodies *(*build)(void);
  void (*read)(const nsdae_record *record, double *row); /* what the file's words are */
  series published;
} mechanism;

static void read_published(mechanism *m)
{
  char line[512];
  FILE *file = fopen(m->file, "r");
  series *s = &m->published;
  assert_non_null(file);
  s->rows = 0;
  while (s->rows < ROWS_MAX && fgets(line, sizeof line, file)) {
    char *at = line, *end = line;
    int word = 0;
    for (; word < m->words; word++, at = end + 1) {
      s->is[s->rows][word] = strtod(at, &end);
      if (end == at || *end != (word + 1 < m->words ? ',' : '\n')) break;
    }
    s->rows += word == m->words;
  }
  fclose(file);
  assert_true(s->rows > 10);
}

typedef struct following {
  const mechanism *m;
  series found;
} following;

static int follow(const nsdae_record *r, nsdae_error *error, void *user)
{
  following *f = user;
  series *s = &f->found;
  (void)error;
  if (s->rows == f->m->published.rows || fabs(r->time - f->m->published.is[s->rows][0]) > 1e-9)
    return 0;
  f->m->read(r, s->is[s->rows++]);
  return 0;
}

static series simulate(const mechanism *m, int method, double dt)
{
  nsdae_bodies *b = m->build();
  nsdae_system *system;
  nsdae_sim *sim;
  following f = {.m = m};
  double q[9], v[9];
  nsdae_sim_options options;
  nsdae_sim_options_default(&options);
  options.projection = NSDAE_PROJECTION_NONE; /* the methods as published */
  options.method = method;
  options.dt = dt;
  options.rtol = 1e-10;
  options.atol = 1e-12;
  assert_true(nsdae_bodies_system(b, &system) >= 0);
  nsdae_bodies_get_start(b, q, v);
  assert_int_equal(nsdae_sim_create(system, &options, &sim, NULL), NSDAE_OK);
  int status = nsdae_sim_init(sim, 0, q, v);
  nsdae_sim_observe(sim, follow, &f);
  if (status >= 0) status = nsdae_sim_run(sim, m->published.is[m->published.rows - 1][0]);
  if (status < 0) print_error("%s\n", nsdae_sim_error(sim)->text);
  assert_true(status >= 0);
  assert_int_equal(f.found.rows, m->published.rows);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  nsdae_bodies_destroy(&b);
  return f.found;
}

/* The most that words of the rows from first to last differ. */
static double apart(const series *a, const series *b, int first, int last, int word, int words)
{
  double most = 0;
  for (int i = first; i <= last; i++)
    for (int j = word; j < word + words; j++) most = fmax(most, fabs(a->is[i][j] - b->is[i][j]));
  return most;
}

/* ---- slider-crank: P. Flores, R. Leine, C. Glocker, Multibody System Dynamics 23, 2010 */

static const double crank_length = 0.153, rod_length = 0.306, half_length = 0.05,
                    half_height = 0.025, play = 0.001;

static int add_link(nsdae_bodies *b, double m, double J, double x, double length, double speed,
                    double rate)
{
  return nsdae_bodies_add(b, &(nsdae_rigid_body){.mass = m,
                                                 .inertia = {0, 0, J},
                                                 .position = {x + length / 2},
                                                 .velocity = {0, speed + rate * length / 2},
                                                 .spin = {0, 0, rate}});
}

static void hinge(nsdae_bodies *b, int body0, int body1, double x)
{
  nsdae_bodies_add_joint(
      b, &(nsdae_joint){.kind = NSDAE_JOINT_REVOLUTE, .body = {body0, body1}, .point = {x}});
}

/* Stretched out, the crank at 150 rad/s and the rod at -75 rad/s: the slider stands still. */
static nsdae_bodies *build_slider_crank(void)
{
  nsdae_bodies *b;
  const double w = 150, end = crank_length + rod_length;
  const double corner[8] = {-half_length, -half_height, half_length,  -half_height,
                            half_length,  half_height,  -half_length, half_height};
  assert_int_equal(nsdae_bodies_create(2, &b, NULL), NSDAE_OK);
  nsdae_bodies_set_gravity(b, (const double[]){0, -9.81, 0});
  int crank = add_link(b, 0.038, 7.4e-5, 0, crank_length, 0, w);
  int rod = add_link(b, 0.038, 5.9e-4, crank_length, rod_length, w * crank_length, -w / 2);
  int slider = nsdae_bodies_add(
      b, &(nsdae_rigid_body){.mass = 0.076, .inertia = {0, 0, 2.7e-6}, .position = {end}});
  hinge(b, NSDAE_GROUND, crank, 0);
  hinge(b, crank, rod, crank_length);
  hinge(b, rod, slider, end);
  int block = nsdae_bodies_add_solid(
      b, slider, &(nsdae_solid){.shape = NSDAE_SHAPE_POLYGON, .points = 4, .point = corner});
  for (int side = -1; side <= 1; side += 2) { /* the guide below and above */
    int guide = nsdae_bodies_add_solid(b, NSDAE_GROUND,
                                       &(nsdae_solid){.shape = NSDAE_SHAPE_PLANE,
                                                      .position = {0, side * (half_height + play)},
                                                      .angle = side > 0 ? acos(-1) : 0});
    nsdae_bodies_add_contact(b, guide, block, 0.01, 0.4, 0);
  }
  return b;
}

static void read_slider_crank(const nsdae_record *r, double *row)
{
  const double is[] = {r->time,       r->q[2] / (2 * acos(-1)), r->q[5], r->v[2], r->v[5],
                       r->q[7] / play};
  memcpy(row, is, sizeof is);
}

/* The published numbers are those of a scheme of first order in steps of 1e-4 s: they are to be as
 * near to the solution as Moreau's scheme comes with that step, but for their constants, before the
 * first impact, in the bounces, resting on the guide, leaving it, and past the other dead centre.
 * There Moreau's scheme in steps of 1e-6 s is about a hundred times as near. */
static void test_slider_crank(void **state)
{
  const int from[] = {0, 5, 8, 11, 14}, to[] = {4, 7, 10, 13, 16};
  mechanism m = {.file = NSDAE_DATA_DIR "/slider_crank_clearance.csv",
                 .words = 6,
                 .build = build_slider_crank,
                 .read = read_slider_crank};
  (void)state;
  read_published(&m);
  series event = simulate(&m, NSDAE_METHOD_EVENT, 1e-4);
  series moreau = simulate(&m, NSDAE_METHOD_MOREAU, 1e-4);
  series fine = simulate(&m, NSDAE_METHOD_MOREAU, 1e-6);
  assert_int_equal(event.rows, to[4] + 1);
  for (int part = 0; part < 5; part++)
    for (int word = 1; word < m.words; word++) {
      double theirs = apart(&m.published, &event, from[part], to[part], word, 1);
      double ours = apart(&moreau, &event, from[part], to[part], word, 1);
      assert_at_most(theirs, 4 * ours);
      assert_at_most(apart(&fine, &event, from[part], to[part], word, 1), ours / 40);
    }
}

/* ---- four-bar linkage: N. Akhadkar, V. Acary, B. Brogliato, Multibody System Dynamics 38, 2016 */

static const double crank = 1, coupler = 4, rocker = 2.5, ground = 3, g = 9.81, pin = 0.055,
                    hole = 0.06;

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
static nsdae_bodies *build_four_bar(void)
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

static void read_four_bar(const nsdae_record *r, double *row)
{
  const double is[] = {r->time, r->q[2], r->q[5], r->q[8], r->v[2], r->v[5], r->v[8]};
  memcpy(row, is, sizeof is);
}

/* The published numbers are those of a scheme of first order in steps of 1e-4 s, whose smooth part
 * is of second order: they come nearer to the solution than Moreau's scheme with that step, which
 * with a tenth of it is nearer by about ten. */
static void test_four_bar(void **state)
{
  mechanism m = {.file = NSDAE_DATA_DIR "/four_bar_clearance.csv",
                 .words = 7,
                 .build = build_four_bar,
                 .read = read_four_bar};
  (void)state;
  read_published(&m);
  series event = simulate(&m, NSDAE_METHOD_EVENT, 1e-4);
  series coarse = simulate(&m, NSDAE_METHOD_MOREAU, 1e-4);
  series fine = simulate(&m, NSDAE_METHOD_MOREAU, 1e-5);
  for (int word = 1; word < m.words; word += 3) { /* angles, rates */
    double theirs = apart(&m.published, &event, 0, event.rows - 1, word, 3);
    double ours = apart(&coarse, &event, 0, event.rows - 1, word, 3);
    double finer = apart(&fine, &event, 0, event.rows - 1, word, 3);
    print_message("published %.1e, moreau %.1e, in a tenth of the step %.1e\n", theirs, ours,
                  finer);
    assert_at_most(theirs, ours / 4);
    assert_at_most(finer, ours / 5);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_slider_crank),
                                     cmocka_unit_test(test_four_bar)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
