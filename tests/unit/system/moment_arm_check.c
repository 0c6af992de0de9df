/* W_T against the geometry in space: two bodies with quaternions, the first with a corner over a
 * slope and a rim over a wall, both with rims that touch; angular velocities in the body's axes or
 * in those of space, the scalar first or last. Right ones at random are left alone; arms that are
 * left out, of one direction with the other sign, in the other axes, or of a ball inside out, are
 * told. */
#include "check.h"

#include <stdint.h>

#include <nsdae/nsdae.h>

#include "support/random.h"

enum { NQ = 14, NV = 12, K = 3 };

enum wrong { RIGHT, NO_ARMS, ONE_ARM, ONE_SIGN, OTHER_AXES, BALL_SIGN, BALL_SIGNS, SECOND, WRONGS };

typedef struct pair {
  int wrong, in_space, last; /* axes of w; where the scalar is */
  double corner[3], rim[2], n[2][3];
} pair;

static void cross(const double *a, const double *b, double *c)
{
  for (int i = 0; i < 3; i++) {
    int j = (i + 1) % 3, k = (i + 2) % 3;
    c[i] = a[j] * b[k] - a[k] * b[j];
  }
}

static double dot(const double *a, const double *b)
{
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static int mass(double t, const double *q, double *M, int ldm, void *user)
{
  (void)t, (void)q, (void)user;
  for (int i = 0; i < NV; i++) M[i * ldm + i] = i % 6 < 3 ? 2 + i / 6 : 0.1 * (1 + i);
  return 0;
}

static int force(double t, const double *q, const double *v, double *F, void *user)
{
  (void)t, (void)q, (void)v, (void)user;
  F[2] = F[8] = -9.81;
  return 0;
}

/* Scalar first, whatever q has. */
static void attitude(const pair *p, const double *q, int body, double e[4])
{
  for (int i = 0; i < 4; i++) e[(i + p->last) % 4] = q[7 * body + 3 + i];
}

/* e' = e o (0, w) / 2, or (0, w) o e / 2 */
static int kinematics(double t, const double *q, const double *v, double *qdot, void *user)
{
  const pair *p = user;
  (void)t;
  for (int b = 0; b < 2; b++) {
    const double *w = v + 6 * b + 3;
    double e[4], turn[3], de[4];
    attitude(p, q, b, e);
    cross(e + 1, w, turn);
    de[0] = -dot(e + 1, w) / 2;
    for (int i = 0; i < 3; i++) de[1 + i] = (e[0] * w[i] + (p->in_space ? -turn[i] : turn[i])) / 2;
    for (int i = 0; i < 3; i++) qdot[7 * b + i] = v[6 * b + i];
    for (int i = 0; i < 4; i++) qdot[7 * b + 3 + i] = de[(i + p->last) % 4];
  }
  return 0;
}

/* R a, or R^T a with sign -1, of the body. */
static void turned(const pair *p, const double *q, int body, double sign, const double *a,
                   double *b)
{
  double e[4], once[3], twice[3], size;
  attitude(p, q, body, e);
  size = e[0] * e[0] + dot(e + 1, e + 1);
  cross(e + 1, a, once);
  cross(e + 1, once, twice);
  for (int i = 0; i < 3; i++) b[i] = a[i] + 2 / size * (sign * e[0] * once[i] + twice[i]);
}

static int gap(double t, const double *q, double *g, void *user)
{
  const pair *p = user;
  (void)t;
  double r[3], d[3];
  turned(p, q, 0, 1, p->corner, r);
  g[0] = dot(p->n[0], q) + dot(p->n[0], r);
  g[1] = dot(p->n[1], q) + 3 - p->rim[0];
  for (int i = 0; i < 3; i++) d[i] = q[7 + i] - q[i];
  g[2] = sqrt(dot(d, d)) - p->rim[0] - p->rim[1];
  return 0;
}

static void directions(const double *n, double t[2][3])
{
  int least = fabs(n[0]) < fabs(n[1]) ? 0 : 1;
  double axis[3] = {least == 0, least == 1, 0};
  cross(n, axis, t[0]);
  double size = sqrt(dot(t[0], t[0]));
  for (int i = 0; i < 3; i++) t[0][i] /= size;
  cross(n, t[0], t[1]);
}

/* sign t (v + w x r) of the body, into a column. */
static void add(const pair *p, const double *q, double *column, int b, double sign, const double *t,
                const double *r, int other_axes)
{
  double arm[3], own[3];
  cross(r, t, arm);
  turned(p, q, b, -1, arm, own);
  int in_space = p->in_space != other_axes;
  for (int i = 0; i < 3; i++) {
    column[6 * b + i] += sign * t[i];
    column[6 * b + 3 + i] += sign * (in_space ? arm[i] : own[i]);
  }
}

static void spoil(const pair *p, double *W, int ldw)
{
  double *corner = W + 3, *ball = W + 2 * ldw + 3, *second = W + 4 * ldw + 9;
  for (int i = 0; i < 3; i++) {
    if (p->wrong == NO_ARMS) corner[i] = corner[ldw + i] = 0;
    if (p->wrong == ONE_ARM) corner[i] = 0;
    if (p->wrong == ONE_SIGN) corner[i] = -corner[i];
    if (p->wrong == BALL_SIGN) ball[i] = -ball[i];
    if (p->wrong == BALL_SIGNS) ball[i] = -ball[i], ball[ldw + i] = -ball[ldw + i];
    if (p->wrong == SECOND) second[i] = -second[i], second[ldw + i] = -second[ldw + i];
  }
}

static int tangent(double time, const double *q, double *W, int ldw, void *user)
{
  const pair *p = user;
  double r[3], t[2][3], u[3], s[3];
  (void)time;
  turned(p, q, 0, 1, p->corner, r);
  directions(p->n[0], t);
  for (int j = 0; j < 2; j++) add(p, q, W + j * ldw, 0, 1, t[j], r, p->wrong == OTHER_AXES);
  directions(p->n[1], t);
  for (int i = 0; i < 3; i++) r[i] = -p->rim[0] * p->n[1][i];
  for (int j = 0; j < 2; j++) add(p, q, W + (2 + j) * ldw, 0, 1, t[j], r, 0);
  for (int i = 0; i < 3; i++) u[i] = q[7 + i] - q[i];
  double d = sqrt(dot(u, u));
  for (int i = 0; i < 3; i++) u[i] /= d, r[i] = p->rim[0] * u[i], s[i] = -p->rim[1] * u[i];
  directions(u, t);
  for (int j = 0; j < 2; j++) {
    add(p, q, W + (4 + j) * ldw, 0, -1, t[j], r, 0);
    add(p, q, W + (4 + j) * ldw, 1, 1, t[j], s, 0);
  }
  spoil(p, W, ldw);
  return 0;
}

static void draw(pair *p, double q[NQ], uint64_t seed)
{
  *p = (pair){.in_space = (int)(seed % 2), .last = (int)(seed / 2 % 2)};
  for (int i = 0; i < 3; i++) p->corner[i] = random_between(&seed, 0.2, 0.6);
  for (int b = 0; b < 2; b++) {
    double size = 0;
    p->rim[b] = random_between(&seed, 0.2, 0.6);
    while (!(size > 0.3)) {
      for (int i = 0; i < 3; i++) p->n[b][i] = random_between(&seed, -1, 1);
      size = sqrt(dot(p->n[b], p->n[b]));
    }
    for (int i = 0; i < 3; i++) p->n[b][i] /= size;
    for (int i = 0; i < 7; i++)
      q[7 * b + i] = random_between(&seed, 0.2, 1) + 3 * (b == 1 && i == 0);
  }
}

static nsdae_system *make(pair *p)
{
  static const char *const names[K] = {"corner", "wall", "balls"};
  const nsdae_dims dims = {.nq = NQ, .nv = NV, .k = K, .nt = 2};
  nsdae_system *s;
  assert_int_equal(nsdae_system_create(&dims, &s, NULL), NSDAE_OK);
  nsdae_system_set_user(s, p);
  nsdae_system_set_mass(s, mass);
  nsdae_system_set_force(s, force);
  nsdae_system_set_kinematics(s, kinematics);
  nsdae_system_set_gap(s, gap);
  nsdae_system_set_gap_tangent(s, tangent);
  for (int i = 0; i < K; i++) {
    nsdae_system_set_contact(s, i, 0.3, 0, 0);
    nsdae_system_set_name(s, NSDAE_NAME_CONTACT, i, names[i], "m");
  }
  nsdae_system_set_name(s, NSDAE_NAME_VELOCITY, 3, "w_x", "rad/s");
  return s;
}

static void test_family(void **state)
{
  (void)state;
  static const char *const said[WRONGS] = {"",
                                           "arms of contact 0 \"corner\" along velocity 3 \"w_x\"",
                                           "contact 0 \"corner\"",
                                           "contact 0 \"corner\"",
                                           "contact 0 \"corner\"",
                                           "contact 1 \"wall\"",
                                           "signs of its arms of contact 1 \"wall\"",
                                           "arms of contact 2 \"balls\" along velocity 9"};
  for (uint64_t seed = 1; seed <= 200; seed++)
    for (int wrong = 0; wrong < WRONGS; wrong++) {
      const double v[NV] = {1, -2, 0.5, 0.3, 2, -1, 0.7, 0.2, -0.4, 1.2, -0.6, 0.9};
      double q[NQ];
      pair p;
      draw(&p, q, seed);
      p.wrong = wrong;
      nsdae_system *s = make(&p);
      int status = nsdae_system_check(s, 0, q, v, 1e-5, NULL);
      const char *unseen = nsdae_system_unseen(s);
      if (status < 0) fail_msg("%s", nsdae_system_error(s)->text);
      if (wrong == RIGHT && strstr(unseen, "if those turn"))
        fail_msg("seed %d: %s", (int)seed, unseen);
      if (wrong != RIGHT && !strstr(unseen, said[wrong]))
        fail_msg("seed %d, wrong %d: %s", (int)seed, wrong, unseen);
      nsdae_system_destroy(&s);
    }
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_family)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
