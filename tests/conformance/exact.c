/* Every method on the exact cases of data/conformance, each with its own order, in two finenesses:
 * event to its tolerance, time-stepping to an error in proportion to dt, penalty to one that falls
 * with the duration of its impacts and the velocity over which it has friction. */
#include "check.h"

#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "parallelogram.h"

enum { METHODS = 5, EVENT = 0, PENALTY = 4, FINENESSES = 2 };

static const char *const methods[METHODS] = {"event", "implicit", "moreau", "implicit-printed",
                                             "penalty"};

/* rtol; dt; and the stiffness, 32 times as much of which makes an impact a quarter as long. */
static const double tolerance[FINENESSES] = {1e-6, 1e-10}, step[FINENESSES] = {1e-3, 1e-4},
                    stiffness[FINENESSES] = {1e8, 32e8}, creeping[FINENESSES] = {1e-3, 2.5e-4};

/* c of c - ln(1 + c) = -c e - ln(1 - c e), which is 8 (1 - x) / (5 x): the law of Flores and others
 * (Multibody Syst. Dyn. 25, 2011) with x has the restitution e, whatever the stiffness. */
static double flores(double e)
{
  double low = 1e-9, high = e > 0 ? fmin(1e4, (1 - 1e-12) / e) : 1e4;
  for (int i = 0; i < 200; i++) {
    double c = (low + high) / 2;
    *(c - log1p(c) + c * e + log1p(-c * e) > 0 ? &low : &high) = c;
  }
  return 8 / (5 * low + 8);
}

static nsdae_sim_options options_of(int method, int fine)
{
  nsdae_sim_options o;
  nsdae_sim_options_default(&o);
  assert_int_equal(nsdae_sim_options_set(&o, "method", methods[method], NULL), NSDAE_OK);
  o.dt = method == EVENT ? 5e-3 : method == PENALTY ? 1e-3 : step[fine];
  o.rtol = method == EVENT ? tolerance[fine] : 1e-10;
  o.atol = 1e-2 * o.rtol;
  o.penalty_law = NSDAE_PENALTY_FLORES;
  o.penalty_stiffness = stiffness[fine];
  o.friction_velocity = creeping[fine];
  return o;
}

/* Errors of a case by all methods. */
typedef double errors[METHODS][FINENESSES];

static void print_errors(const char *name, errors of)
{
  print_message("%-30s", name);
  for (int m = 0; m < METHODS; m++) print_message("  %s %.1e %.1e", methods[m], of[m][0], of[m][1]);
  print_message("\n");
}

/* creeps: how fast and how long friction that holds does in penalty, and impacts, each of which
 * lasts a millisecond and a half of g at the first stiffness. */
static void judge(errors of, double t_end, double g, int impacts)
{
  for (int fine = 0; fine < FINENESSES; fine++) {
    assert_at_most(of[EVENT][fine], 10 * tolerance[fine]);
    /* an impact is up to one dt late, times the jump of the velocity and, at the end, g */
    for (int m = EVENT + 1; m < PENALTY; m++) assert_at_most(of[m][fine], 100 * step[fine]);
    double lasts = 1.5e-3 / (fine ? 4 : 1);
    assert_at_most(of[PENALTY][fine], creeping[fine] * t_end + lasts * g * (1 + impacts));
  }
}

static void add(errors to, errors of)
{
  for (int m = 0; m < METHODS; m++)
    for (int fine = 0; fine < FINENESSES; fine++) to[m][fine] += of[m][fine];
}

/* Of all cases together: a tenth of dt leaves a tenth, and must leave a quarter; a quarter of what
 * penalty smears must leave a half. */
static void judge_orders(errors sum)
{
  print_errors("all", sum);
  for (int m = EVENT + 1; m < METHODS; m++)
    assert_at_most(sum[m][1], sum[m][0] / (m == PENALTY ? 2 : 4));
}

/* The numbers of a line behind the name, count of them; NAN where there is none. */
static void read_case(char *line, char *name, double *to, int count)
{
  char *at = strchr(line, ',');
  assert_non_null(at);
  snprintf(name, 64, "%.*s", (int)(at - line), line);
  for (int i = 0; i < count; i++) {
    char *end;
    assert_non_null(at);
    to[i] = strtod(at + 1, &end);
    if (end == at + 1) to[i] = NAN;
    at = strchr(at + 1, ',');
  }
  assert_null(at);
}

static FILE *open_cases(const char *name)
{
  char path[512], line[512];
  snprintf(path, sizeof path, "%s/conformance/%s", NSDAE_DATA_DIR, name);
  FILE *file = fopen(path, "r");
  assert_non_null(file);
  assert_non_null(fgets(line, sizeof line, file));
  return file;
}

/* ---- ball.csv: a ball on a plane ---- */

typedef struct ball {
  char name[64];
  double tilt, mu, e, h, v0, w0, t_end, q[2], v[3]; /* q, v: x, y; vx, vy, w at t_end */
  double t_rest;                                    /* NAN: it does not come to rest */
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

static nsdae_system *ball_system(ball *b)
{
  const nsdae_dims dims = {.nq = 3, .k = 1, .nt = 1};
  nsdae_system *system;
  assert_int_equal(nsdae_system_create(&dims, &system, NULL), NSDAE_OK);
  nsdae_system_set_user(system, b);
  nsdae_system_set_mass(system, mass);
  nsdae_system_set_force(system, force);
  nsdae_system_set_gap(system, gap);
  nsdae_system_set_gap_normal(system, normal);
  nsdae_system_set_gap_tangent(system, tangent);
  nsdae_system_set_contact(system, 0, b->mu, b->e, 0);
  return system;
}

typedef struct rest {
  int impacts;
  double time; /* of the last end of an accumulation */
} rest;

static int keep_rest(const nsdae_record *record, nsdae_error *error, void *user)
{
  rest *r = user;
  (void)error;
  for (int i = 0; i < record->impacts; i++)
    if (record->impact[i].accumulation) r->time = record->impact[i].time;
  r->impacts += record->impacts;
  return 0;
}

/* Error of positions and velocities at the end, the largest. */
static double ball_error(ball *b, int method, int fine, rest *found)
{
  double q0[3] = {0, b->h, 0}, v0[3] = {b->v0, 0, b->w0}, worst = 0;
  nsdae_sim_options o = options_of(method, fine);
  nsdae_sim *sim;
  nsdae_record r;
  nsdae_system *system = ball_system(b);
  *found = (rest){0};
  if (method == PENALTY) nsdae_system_set_contact(system, 0, b->mu, flores(b->e), 0);
  assert_int_equal(nsdae_sim_create(system, &o, &sim, NULL), NSDAE_OK);
  nsdae_sim_observe(sim, keep_rest, found);
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
  FILE *file = open_cases("ball.csv");
  errors sum = {{0}};
  char line[512];
  int cases = 0;
  for (; fgets(line, sizeof line, file); cases++) {
    ball b;
    rest found, of_event[FINENESSES];
    errors of;
    double numbers[13];
    if (test_share() > 1 && cases % 3 == 1) continue;
    read_case(line, b.name, numbers, 13);
    memcpy((char *)&b + offsetof(ball, tilt), numbers, sizeof numbers);
    for (int m = 0; m < METHODS; m++)
      for (int fine = 0; fine < FINENESSES; fine++) {
        of[m][fine] = ball_error(&b, m, fine, &found);
        if (m == EVENT) of_event[fine] = found;
      }
    print_errors(b.name, of);
    judge(of, b.t_end, g, of_event[1].impacts);
    for (int fine = 0; fine < FINENESSES; fine++)
      if (!isnan(b.t_rest)) assert_near(of_event[fine].time, b.t_rest, 10 * tolerance[fine]);
    add(sum, of);
  }
  fclose(file);
  assert_true(cases >= 13);
  judge_orders(sum);
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

static nsdae_system *block_system(block *b, double e)
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
  for (int i = 0; i < dims.k; i++) nsdae_system_set_contact(system, i, b->mu, e, 0);
  return system;
}

static nsdae_sim *block_start(const block *b, nsdae_system *system, int method, int fine)
{
  double r[2], q0[3] = {0, 0, b->phi0}, v0[3] = {0, 0, b->w0};
  nsdae_sim_options o = options_of(method, fine);
  nsdae_sim *sim;
  arm(b, 0, b->phi0, r); /* the lowest */
  q0[1] = -r[1];
  v0[0] = b->v0 + r[1] * b->w0;
  v0[1] = -r[0] * b->w0;
  assert_int_equal(nsdae_sim_create(system, &o, &sim, NULL), NSDAE_OK);
  assert_int_equal(nsdae_sim_init(sim, 0, q0, v0), NSDAE_OK);
  return sim;
}

/* Error at the end of what is given, the largest; angles as ways of a corner. */
static double block_error(block *b, int method, int fine, long *impacts)
{
  nsdae_record r;
  nsdae_stats stats;
  nsdae_system *system = block_system(b, method == PENALTY ? flores(0) : 0);
  nsdae_sim *sim = block_start(b, system, method, fine);
  assert_int_equal(nsdae_sim_run(sim, b->t_end), NSDAE_OK);
  nsdae_sim_get_record(sim, &r);
  nsdae_sim_get_stats(sim, &stats);
  if (method == EVENT) *impacts = stats.impacts;
  double R = hypot(b->a, b->b), worst = 0;
  double off[] = {r.q[0] - b->x, R * (r.q[2] - b->phi), r.v[0] - b->vx, R * (r.v[2] - b->w)};
  for (int i = 0; i < 4; i++) worst = fmax(worst, fabs(off[i])); /* without NAN */
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  return worst;
}

/* How far the time is off at which the forces are found to be without bound. */
static double jam_error(block *b, int fine)
{
  nsdae_system *system = block_system(b, 0);
  nsdae_sim *sim = block_start(b, system, EVENT, fine);
  assert_int_equal(nsdae_sim_run(sim, b->t_jam + 0.1), NSDAE_E_PAINLEVE);
  double off = fabs(nsdae_sim_error(sim)->time - b->t_jam);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  return off;
}

static void test_block(void **state)
{
  (void)state;
  FILE *file = open_cases("block.csv");
  errors sum = {{0}};
  char line[512];
  int cases = 0;
  for (; fgets(line, sizeof line, file); cases++) {
    block b;
    errors of;
    long impacts = 0;
    double numbers[15];
    if (test_share() > 1 && cases % 3 == 2) continue;
    read_case(line, b.name, numbers, 15);
    memcpy((char *)&b + offsetof(block, a), numbers, sizeof numbers);
    for (int m = 0; m < METHODS; m++)
      for (int fine = 0; fine < FINENESSES; fine++)
        of[m][fine] = block_error(&b, m, fine, &impacts);
    print_errors(b.name, of);
    judge(of, b.t_end, b.g, (int)impacts);
    add(sum, of);
    for (int fine = 0; fine < FINENESSES && !isnan(b.t_jam); fine++) {
      double jam = jam_error(&b, fine);
      print_message("  jams: off by %.1e\n", jam);
      assert_at_most(jam, 100 * tolerance[fine]);
    }
  }
  fclose(file);
  assert_true(cases >= 12);
  judge_orders(sum);
}

/* ---- cranks.csv: a bar on more cranks than it needs (parallelogram.h) ---- */

typedef struct hung {
  char name[64];
  double cranks, phi0, e, t_end, phi, w;
} hung;

static double hung_error(const hung *h, int method, int fine)
{
  parallelogram p = {.cranks = (int)h->cranks, .given = 1};
  double q0[PARALLELOGRAM_NQ], v0[PARALLELOGRAM_NQ] = {0}, worst = 0;
  nsdae_sim_options o = options_of(method, fine);
  nsdae_sim *sim;
  nsdae_record r;
  p.e = method == PENALTY ? flores(h->e) : h->e;
  nsdae_system *system = parallelogram_system(&p);
  parallelogram_start(&p, h->phi0, q0);
  o.redundant = NSDAE_REDUNDANT_LEAST_NORM;
  assert_int_equal(nsdae_sim_create(system, &o, &sim, NULL), NSDAE_OK);
  assert_int_equal(nsdae_sim_init(sim, 0, q0, v0), NSDAE_OK);
  assert_int_equal(nsdae_sim_run(sim, h->t_end), NSDAE_OK);
  nsdae_sim_get_record(sim, &r);
  for (int i = 0; i < p.cranks; i++)
    worst = fmax(worst, fmax(fabs(r.q[3 * i + 2] - h->phi), fabs(r.v[3 * i + 2] - h->w)));
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  return worst;
}

static void test_cranks(void **state)
{
  (void)state;
  FILE *file = open_cases("cranks.csv");
  errors sum = {{0}};
  char line[512];
  int cases = 0;
  for (; fgets(line, sizeof line, file); cases++) {
    hung h;
    errors of;
    double numbers[6];
    if (test_share() > 1 && cases > 0) continue; /* the others take seconds each */
    read_case(line, h.name, numbers, 6);
    memcpy((char *)&h + offsetof(hung, cranks), numbers, sizeof numbers);
    for (int m = 0; m < METHODS; m++)
      for (int fine = 0; fine < FINENESSES; fine++) of[m][fine] = hung_error(&h, m, fine);
    print_errors(h.name, of);
    judge(of, h.t_end, 20, 4); /* p^2 of some 20 / s^2, at most four impacts */
    add(sum, of);
  }
  fclose(file);
  assert_true(cases >= 4);
  if (test_share() == 1) judge_orders(sum); /* of impacts, which the first has not */
}

/* ---- plate.csv: a ball on a plate that shakes ---- */

typedef struct shaken {
  char name[64];
  double A, w, e, t_end, y, v, t_lift, impacts;
} shaken;

static int shaken_mass(double t, const double *q, double *M, int ldm, void *user)
{
  (void)t, (void)q, (void)ldm, (void)user;
  M[0] = 1;
  return 0;
}

static int shaken_weight(double t, const double *q, const double *v, double *F, void *user)
{
  (void)t, (void)q, (void)v, (void)user;
  F[0] = -9.81;
  return 0;
}

static int shaken_gap(double t, const double *q, double *gap, void *user)
{
  const shaken *p = user;
  gap[0] = q[0] - p->A * sin(p->w * t);
  return 0;
}

static int shaken_bias(double t, const double *q, double *w_n, double *w_t, void *user)
{
  const shaken *p = user;
  (void)q, (void)w_t;
  w_n[0] = -p->A * p->w * cos(p->w * t);
  return 0;
}

/* Accelerations by differences. The lift-off and the number of impacts are exact for event. */
static double shaken_error(shaken *p, int method, int fine)
{
  nsdae_sim_options o = options_of(method, fine);
  nsdae_system *system;
  nsdae_sim *sim;
  nsdae_record r;
  nsdae_stats stats;
  double q0 = 0, v0 = p->A * p->w;
  assert_int_equal(nsdae_system_create(&(nsdae_dims){.nq = 1, .k = 1}, &system, NULL), NSDAE_OK);
  nsdae_system_set_user(system, p);
  nsdae_system_set_mass(system, shaken_mass);
  nsdae_system_set_force(system, shaken_weight);
  nsdae_system_set_gap(system, shaken_gap);
  nsdae_system_set_gap_normal(system, shaken_mass); /* 1, too */
  nsdae_system_set_contact_bias(system, shaken_bias);
  nsdae_system_set_contact(system, 0, 0, method == PENALTY ? flores(p->e) : p->e, 0);
  assert_int_equal(nsdae_sim_create(system, &o, &sim, NULL), NSDAE_OK);
  assert_int_equal(nsdae_sim_init(sim, 0, &q0, &v0), NSDAE_OK);
  int status = nsdae_sim_run(sim, p->t_end);
  assert_true(status >= 0);
  nsdae_sim_get_record(sim, &r);
  nsdae_sim_get_stats(sim, &stats);
  double worst = fmax(fabs(r.q[0] - p->y), fabs(r.v[0] - p->v));
  if (method == EVENT) assert_int_equal(stats.impacts, (long)p->impacts);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  return worst;
}

static void test_plate(void **state)
{
  (void)state;
  FILE *file = open_cases("plate.csv");
  char line[512];
  int cases = 0;
  for (; fgets(line, sizeof line, file); cases++) {
    shaken p;
    errors of;
    double numbers[8];
    if (test_share() > 1 && cases % 2 > 0) continue;
    read_case(line, p.name, numbers, 8);
    memcpy((char *)&p + offsetof(shaken, A), numbers, sizeof numbers);
    for (int m = 0; m < METHODS; m++)
      for (int fine = 0; fine < FINENESSES; fine++) of[m][fine] = shaken_error(&p, m, fine);
    print_errors(p.name, of);
    judge(of, p.t_end, 9.81 + p.A * p.w * p.w, (int)p.impacts);
  }
  fclose(file);
  assert_true(cases >= 6);
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_ball), cmocka_unit_test(test_block),
                                     cmocka_unit_test(test_cranks), cmocka_unit_test(test_plate)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
