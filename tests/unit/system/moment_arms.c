/* W_T against the geometry: two bodies in the plane, alike, one with two corners and a rim over a
 * slope and a wall, both with rims that touch. Right ones at random are left alone, and so is a
 * body that is grown, which no gap tells; an arm that is left out, too short or too long at a
 * corner, a sign of one arm, a gap that is no length, a force without its reaction are told by
 * the check. */
#include "check.h"

#include <stdint.h>

#include <nsdae/nsdae.h>

#include "support/random.h"

enum { NQ = 6 };

enum wrong {
  RIGHT,
  GROWN,
  NO_ARM,
  SHORT_ARM,
  LONG_ARM,
  OTHER_SIGN,
  RIM_SIGN,
  MILLIMETRES,
  NO_REACTION,
  WRONGS
};

typedef struct pair {
  int wrong, moves; /* the wall, by itself */
  double corner[2][2], rim[2], slope, wall;
} pair;

static int mass(double t, const double *q, double *M, int ldm, void *user)
{
  (void)t, (void)q, (void)user;
  for (int i = 0; i < NQ; i++) M[i * ldm + i] = i % 3 == 2 ? 0.4 : 2;
  return 0;
}

static int force(double t, const double *q, const double *v, double *F, void *user)
{
  (void)t, (void)q, (void)v, (void)user;
  F[1] = F[4] = -9.81;
  return 0;
}

/* From the centre to a corner, in space. */
static void arm_of(const pair *p, const double *q, int i, double r[2])
{
  double c = cos(q[2]), s = sin(q[2]);
  r[0] = c * p->corner[i][0] - s * p->corner[i][1];
  r[1] = s * p->corner[i][0] + c * p->corner[i][1];
}

static int gap(double t, const double *q, double *g, void *user)
{
  const pair *p = user;
  double n[2] = {-sin(p->slope), cos(p->slope)}, w[2] = {cos(p->wall), sin(p->wall)}, r[2];
  for (int i = 0; i < 2; i++) {
    arm_of(p, q, i, r);
    g[i] = n[0] * (q[0] + r[0]) + n[1] * (q[1] + r[1]);
  }
  g[2] = w[0] * q[0] + w[1] * q[1] + 3 - p->rim[0] + (p->moves ? 0.1 * sin(30 * t) : 0);
  g[3] = hypot(q[3] - q[0], q[4] - q[1]) - p->rim[0] - p->rim[1];
  if (p->wrong == MILLIMETRES) g[0] *= 1000;
  return 0;
}

/* t (v + omega x r) of body b, into column. */
static void add(double *column, int b, double sign, const double t[2], const double r[2])
{
  column[3 * b] += sign * t[0];
  column[3 * b + 1] += sign * t[1];
  column[3 * b + 2] += sign * (t[1] * r[0] - t[0] * r[1]);
}

static int tangent(double t, const double *q, double *W, int ldw, void *user)
{
  const pair *p = user;
  (void)t;
  double n[2] = {-sin(p->slope), cos(p->slope)}, w[2] = {cos(p->wall), sin(p->wall)}, r[2];
  double grown = p->wrong == GROWN ? 0.3 : 0;
  for (int i = 0; i < 2; i++) {
    arm_of(p, q, i, r);
    for (int j = 0; j < 2; j++) r[j] -= grown * n[j];
    add(W + i * ldw, 0, 1, (double[2]){n[1], -n[0]}, r);
  }
  add(W + 2 * ldw, 0, 1, (double[2]){-w[1], w[0]},
      (double[2]){-(p->rim[0] + grown) * w[0], -(p->rim[0] + grown) * w[1]});
  double d = hypot(q[3] - q[0], q[4] - q[1]), u[2] = {(q[3] - q[0]) / d, (q[4] - q[1]) / d};
  const double along[2] = {-u[1], u[0]};
  add(W + 3 * ldw, 0, -1, along,
      (double[2]){(p->rim[0] + grown) * u[0], (p->rim[0] + grown) * u[1]});
  add(W + 3 * ldw, 1, p->wrong == NO_REACTION ? -1 : 1, along,
      (double[2]){-p->rim[1] * u[0], -p->rim[1] * u[1]});
  if (p->wrong == NO_ARM) W[2] = 0;
  if (p->wrong == SHORT_ARM) W[2] *= 0.5;
  if (p->wrong == LONG_ARM) W[2] *= 1.5;
  if (p->wrong == OTHER_SIGN) W[ldw + 2] = -W[ldw + 2];
  if (p->wrong == RIM_SIGN) W[2 * ldw + 2] = -W[2 * ldw + 2];
  return 0;
}

static int wall_rate(double t, const double *q, double *w_n, double *w_t, void *user)
{
  (void)q, (void)w_t, (void)user;
  w_n[2] = 3 * cos(30 * t);
  return 0;
}

/* A body whose corners are below its centre, in any turn of the whole. */
static void draw(pair *p, double q[NQ], uint64_t seed)
{
  *p = (pair){.slope = random_between(&seed, -3, 3), .wall = random_between(&seed, -3, 3)};
  for (int i = 0; i < 2; i++) {
    p->corner[i][0] = (i ? 1 : -1) * random_between(&seed, 0.1, 0.6);
    p->corner[i][1] = -random_between(&seed, 0.2, 0.6);
    p->rim[i] = random_between(&seed, 0.2, 0.6);
  }
  for (int i = 0; i < NQ; i++) q[i] = random_between(&seed, -1, 1) + (i == 3 ? 3 : 0);
  q[2] = p->slope + random_between(&seed, -0.1, 0.1);
}

static nsdae_system *make(pair *p)
{
  const nsdae_dims dims = {.nq = NQ, .k = 4, .nt = 1};
  nsdae_system *s;
  assert_int_equal(nsdae_system_create(&dims, &s, NULL), NSDAE_OK);
  nsdae_system_set_user(s, p);
  nsdae_system_set_mass(s, mass);
  nsdae_system_set_force(s, force);
  nsdae_system_set_gap(s, gap);
  nsdae_system_set_gap_tangent(s, tangent);
  for (int i = 0; i < 4; i++) nsdae_system_set_contact(s, i, 0.3, 0, 0);
  nsdae_system_set_name(s, NSDAE_NAME_CONTACT, 0, "toe", "m");
  nsdae_system_set_name(s, NSDAE_NAME_CONTACT, 1, "heel", "m");
  nsdae_system_set_name(s, NSDAE_NAME_CONTACT, 2, "rim", "m");
  if (p->moves) nsdae_system_set_contact_bias(s, wall_rate);
  nsdae_system_set_name(s, NSDAE_NAME_COORDINATE, 2, "theta", p->moves ? "1" : "rad");
  nsdae_system_set_name(s, NSDAE_NAME_COORDINATE, 3, "x_2", "m");
  return s;
}

static void test_family(void **state)
{
  (void)state;
  static const char *const said[WRONGS] = {[NO_ARM] = "\"toe\" along velocity 2 \"theta\"",
                                           [SHORT_ARM] = "\"toe\" along velocity 2 \"theta\"",
                                           [LONG_ARM] = "\"toe\" along velocity 2 \"theta\"",
                                           [OTHER_SIGN] = "the sign of its arm of contact 1",
                                           [RIM_SIGN] = "the sign of its arm of contact 2 \"rim\"",
                                           [MILLIMETRES] = "gradient of length 1000"};
  for (uint64_t seed = 1; seed <= 200; seed++)
    for (int wrong = 0; wrong < WRONGS; wrong++) {
      const double v[NQ] = {1, -2, 0.5, 0.3, 2, -1};
      double q[NQ];
      pair p;
      draw(&p, q, seed);
      p.wrong = wrong;
      p.moves = (int)(seed % 2);
      nsdae_system *s = make(&p);
      int status = nsdae_system_check(s, 0, q, v, 1e-5, NULL);
      const char *unseen = nsdae_system_unseen(s);
      if (status < 0 && wrong != NO_REACTION) fail_msg("%s", nsdae_system_error(s)->text);
      if (wrong == NO_REACTION) {
        assert_int_equal(status, NSDAE_E_DERIVATIVE);
        assert_non_null(strstr(nsdae_system_error(s)->text, "velocity 3 \"x_2\" move"));
      } else if (!said[wrong]) {
        if (strstr(unseen, "if this rotates the body") || strstr(unseen, "the sign of its arm"))
          fail_msg("seed %d: %s", (int)seed, unseen);
      } else if (!strstr(unseen, said[wrong])) {
        fail_msg("seed %d, wrong %d: %s", (int)seed, wrong, unseen);
      }
      nsdae_system_destroy(&s);
    }
}

/* Right models that are not a free body over a fixed wall: neither the check nor a start says
 * anything of them. Each coordinate has mass 1, but the box 3. */
enum right { BOX, WHEEL, SCALED, SHAKEN, CUBE, RIGHTS };

typedef struct guided {
  int kind, nq, nv, k, nt;
  const char *unit[3];
} guided;

static int guided_mass(double t, const double *q, double *M, int ldm, void *user)
{
  const guided *g = user;
  (void)t, (void)q;
  for (int i = 0; i < g->nv; i++) M[i * ldm + i] = i > 2 ? 0.2 : g->kind == BOX && i == 2 ? 3 : 1;
  return 0;
}

static int guided_force(double t, const double *q, const double *v, double *F, void *user)
{
  (void)t, (void)q, (void)v, (void)user;
  F[1] = -9.81;
  return 0;
}

/* A corner of the cube, in space: R(e) as textbooks have it, for quaternions of length one. */
static void cube_corner(const double *e, double R[3][3], double r[3])
{
  const double w = e[0], x = e[1], y = e[2], z = e[3];
  const double rows[3][3] = {{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
                             {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
                             {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}};
  memcpy(R, rows, sizeof rows);
  for (int i = 0; i < 3; i++) r[i] = (rows[i][0] - rows[i][1] - rows[i][2]) / 2;
}

static int guided_kinematics(double t, const double *q, const double *v, double *qdot, void *user)
{
  const double *e = q + 3, *w = v + 3;
  (void)t, (void)user;
  for (int i = 0; i < 3; i++) qdot[i] = v[i];
  qdot[3] = -(e[1] * w[0] + e[2] * w[1] + e[3] * w[2]) / 2;
  qdot[4] = (e[0] * w[0] + e[2] * w[2] - e[3] * w[1]) / 2;
  qdot[5] = (e[0] * w[1] + e[3] * w[0] - e[1] * w[2]) / 2;
  qdot[6] = (e[0] * w[2] + e[1] * w[1] - e[2] * w[0]) / 2;
  return 0;
}

/* BOX: a bead between floor and ceiling of a box that slides along x; WHEEL: in a vertical guide,
 * above the floor, of radius 0.1; SCALED: a bead, gap and direction in tenths; SHAKEN: a rod in mm
 * over a table that shakes; CUBE: one corner. */
static int guided_gap(double t, const double *q, double *g, void *user)
{
  double R[3][3], r[3];
  switch (((const guided *)user)->kind) {
  case BOX:
    g[0] = q[1], g[1] = 2 - q[1];
    break;
  case SCALED:
    g[0] = 10 * q[1];
    break;
  case SHAKEN:
    g[0] = q[1] - 500 * cos(q[2]) - cos(300 * t);
    break;
  case CUBE:
    cube_corner(q + 3, R, r), g[0] = q[2] + r[2];
    break;
  default:
    g[0] = q[0] - 0.1;
    break;
  }
  return 0;
}

static int guided_tangent(double t, const double *q, double *W, int ldw, void *user)
{
  (void)t;
  double R[3][3], r[3];
  switch (((const guided *)user)->kind) {
  case BOX:
    W[0] = 1, W[2] = -1, W[ldw] = -1, W[ldw + 2] = 1;
    break;
  case WHEEL:
    W[1] = 0.1;
    break;
  case SCALED:
    W[0] = 10;
    break;
  case SHAKEN:
    W[0] = 1, W[2] = 500 * cos(q[2]);
    break;
  default:
    cube_corner(q + 3, R, r);
    for (int j = 0; j < 2; j++) { /* t = x, y: r x t, in the cube's own axes */
      const double m[3] = {j ? -r[2] : 0, j ? 0 : r[2], j ? r[0] : -r[1]};
      W[j * ldw + j] = 1;
      for (int i = 0; i < 3; i++)
        W[j * ldw + 3 + i] = R[0][i] * m[0] + R[1][i] * m[1] + R[2][i] * m[2];
    }
  }
  return 0;
}

static int shaken_table(double t, const double *q, double *w_n, double *w_t, void *user)
{
  (void)q, (void)w_t, (void)user;
  w_n[0] = 300 * sin(300 * t);
  return 0;
}

static nsdae_system *make_guided(guided *g)
{
  const nsdae_dims dims = {.nq = g->nq, .nv = g->nv, .k = g->k, .nt = g->nt};
  nsdae_system *s;
  assert_int_equal(nsdae_system_create(&dims, &s, NULL), NSDAE_OK);
  nsdae_system_set_user(s, g);
  nsdae_system_set_mass(s, guided_mass);
  nsdae_system_set_force(s, guided_force);
  nsdae_system_set_gap(s, guided_gap);
  nsdae_system_set_gap_tangent(s, guided_tangent);
  if (g->kind == SHAKEN) nsdae_system_set_contact_bias(s, shaken_table);
  if (g->kind == CUBE) nsdae_system_set_kinematics(s, guided_kinematics);
  for (int i = 0; i < g->k; i++) nsdae_system_set_contact(s, i, 0.3, 0, 0);
  for (int i = 0; i < 3 && g->unit[i]; i++)
    nsdae_system_set_name(s, NSDAE_NAME_COORDINATE, i, (const char *[]){"a", "b", "c"}[i],
                          g->unit[i]);
  return s;
}

static void test_right_models(void **state)
{
  (void)state;
  guided all[RIGHTS] = {[BOX] = {BOX, 3, 3, 2, 1, {"m", "m", "m"}},
                        [WHEEL] = {WHEEL, 2, 2, 1, 1, {"m", "rad"}},
                        [SCALED] = {SCALED, 2, 2, 1, 1, {NULL}},
                        [SHAKEN] = {SHAKEN, 3, 3, 1, 1, {NULL}},
                        [CUBE] = {CUBE, 7, 6, 1, 2, {NULL}}};
  for (int i = 0; i < RIGHTS; i++) {
    const double tilt[7] = {0.3, 0.2, 5, 1.1, 0.3, -0.4, 0.2}, flat[7] = {0.4, 0.9, 0.7};
    const double v[6] = {0.1, -0.2, 0.3, 0.5, -0.6, 0.4}, rest[6] = {0};
    const double *q = i == CUBE ? tilt : flat, away[7] = {0, 600, 0.5}, upright[7] = {0, 0, 5, 1};
    nsdae_system *s = make_guided(&all[i]);
    nsdae_sim *sim;
    if (nsdae_system_check(s, 0.1, q, v, 1e-4, NULL) < 0)
      fail_msg("%d: %s", i, nsdae_system_error(s)->text);
    const char *unseen = nsdae_system_unseen(s);
    if (strstr(unseen, "; gap_tangent: its") || strstr(unseen, "; gap_tangent: the sign") ||
        strstr(unseen, "; gap: that"))
      fail_msg("%d: %s", i, unseen);
    assert_int_equal(nsdae_sim_create(s, NULL, &sim, NULL), NSDAE_OK);
    q = i == SHAKEN ? away : i == CUBE ? upright : flat;
    if (nsdae_sim_init(sim, 0, q, rest) != NSDAE_OK) fail_msg("%s", nsdae_sim_error(sim)->text);
    nsdae_sim_destroy(&sim);
    nsdae_system_destroy(&s);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_family),
                                     cmocka_unit_test(test_right_models)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
