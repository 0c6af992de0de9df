/* The event-driven method with its default options, or those at which it once failed, against
 * answers worked out apart: the rest of a rocking block by quadrature, a top that flies and tips by
 * its closed motion and the cone of one contact, a parallelogram by arithmetic-geometric means, and
 * dropped boxes by where they must lie. */
#include "check.h"

#include "drop.h"
#include "parallelogram.h"

enum { KEPT = 64 };

static const double g = 9.81;

typedef struct kept {
  int impacts;
  nsdae_impact impact[KEPT]; /* that come faster than 1e-3 m/s */
  double end;                /* of the last accumulation */
} kept;

static int keep(const nsdae_record *record, nsdae_error *error, void *user)
{
  kept *k = user;
  (void)error;
  for (int i = 0; i < record->impacts; i++) {
    const nsdae_impact *impact = &record->impact[i];
    if (impact->accumulation) k->end = impact->time;
    if (impact->velocity_before < -1e-3 && k->impacts < KEPT) k->impact[k->impacts++] = *impact;
  }
  return 0;
}

static nsdae_sim_options defaults(void)
{
  nsdae_sim_options o;
  nsdae_sim_options_default(&o);
  o.method = NSDAE_METHOD_EVENT;
  return o;
}

/* Runs it to t_end, releases all, with NSDAE_OK. */
static void go(nsdae_system *system, const nsdae_sim_options *o, const double *q0, const double *v0,
               double t_end, kept *k, double *q, double *v)
{
  nsdae_dims dims;
  nsdae_record record;
  nsdae_sim *sim;
  nsdae_stats stats;
  *k = (kept){0};
  nsdae_system_get_dims(system, &dims);
  assert_int_equal(nsdae_sim_create(system, o, &sim, NULL), NSDAE_OK);
  nsdae_sim_observe(sim, keep, k);
  assert_int_equal(nsdae_sim_init(sim, 0, q0, v0), NSDAE_OK);
  assert_int_equal(nsdae_sim_run(sim, t_end), NSDAE_OK);
  nsdae_sim_get_record(sim, &record);
  nsdae_sim_get_stats(sim, &stats);
  assert_int_equal(stats.fallback_steps, 0);
  assert_at_most(stats.worst_penetration, 100 * o->rtol);
  memcpy(q, record.q, (size_t)dims.nq * sizeof *q);
  memcpy(v, record.v, (size_t)dims.nv * sizeof *v);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
}

static void drop_it(drop *d, const nsdae_sim_options *o, double t_end, kept *k, double *q,
                    double *v)
{
  d->g = g;
  d->bodies = 1;
  go(drop_system(d), o, d->q0, d->v0, t_end, k, q, v);
}

static void floor_below(drop *d, int up)
{
  d->walls = 1;
  d->normal[0][up] = 1;
}

/* ---- Housner's block (Bull. Seism. Soc. Am. 53, 1963): 0.025 by 0.1 m, released at 8 degrees ----
 */

/* Time from theta, at rest, to the flat: w^2 = 3 g / (2 R) (cos(al - th) - cos(al - x)) x: the
 * angle. x = theta (1 - u^2) takes the root out of the integrand, which Simpson's rule then takes
 * to rounding. */
static double swing(double R, double al, double theta)
{
  const int n = 2000;
  double sum = 0;
  for (int i = 0; i <= n; i++) {
    double u = (double)i / n, x = theta * (1 - u * u);
    /* cos(al - theta) - cos(al - x), over u^2 */
    double mean = al - (theta + x) / 2, half = theta * u * u / 2;
    double fall = i == 0 ? theta * sin(mean) : 2 * sin(mean) * sin(half) / (u * u);
    double f = 2 * theta / sqrt(3 * g / (2 * R) * fall);
    sum += f * (i == 0 || i == n ? 1 : i % 2 ? 4 : 2);
  }
  return sum / (3 * n);
}

/* All swings: from one side to the other, cos(al - theta) - cos(al) falls by the square of
 * 1 - 3/2 sin^2(al). */
static double rocking_rest(double a, double b, double theta)
{
  double R = hypot(a, b), al = atan2(a, b), r = 1 - 1.5 * pow(sin(al), 2);
  double t = swing(R, al, theta);
  for (int i = 0; i < 2000 && theta > 0; i++) {
    /* 1 - cos(al - theta) + cos(al) in small numbers: 2 sin(al - theta / 2) sin(theta / 2) */
    double high = r * r * 2 * sin(al - theta / 2) * sin(theta / 2), low = 0, up = theta;
    for (int j = 0; j < 200; j++) {
      double x = (low + up) / 2;
      *(2 * sin(al - x / 2) * sin(x / 2) < high ? &low : &up) = x;
    }
    theta = up;
    double both = 2 * swing(R, al, theta);
    t += both;
    if (theta < 1e-12)
      return t + both * r / (1 - r); /* of ever smaller swings, as roots of theta */
  }
  return t;
}

static void test_block(void **state)
{
  (void)state;
  const double a = 0.0125, b = 0.05, tilt = 8 * acos(-1) / 180, rest = rocking_rest(a, b, tilt);
  assert_near(rest, 1.8833874, 5e-8); /* as printed elsewhere */
  for (int fine = 0; fine < 2; fine++) {
    drop d = {.points = 2, .m = 1, .mu = 0.3};
    nsdae_sim_options o = defaults();
    kept k;
    double q[3], v[3];
    if (fine) o.rtol = 1e-11, o.atol = 1e-13;
    d.J[2] = (a * a + b * b) / 3;
    floor_below(&d, 1);
    for (int p = 0; p < 2; p++) d.point[p][0] = p ? a : -a, d.point[p][1] = -b;
    d.q0[1] = a * sin(tilt) + b * cos(tilt);
    d.q0[2] = tilt;
    drop_it(&d, &o, 2.5, &k, q, v);
    print_message("block: rests at %.12f, exact %.12f\n", k.end, rest);
    assert_near(k.end, rest, 100 * o.rtol);
    assert_near(q[1], b, 100 * o.rtol);
    for (int j = 0; j < 3; j++) assert_near(v[j], 0, 100 * o.rtol);
  }
}

/* ---- boxes that are dropped lie on a face, on all its corners ---- */

static void expect_flat(const drop *d, const double *q, const double *v, double tol)
{
  drop_terms at;
  int down = 0;
  drop_find_terms(d, q, v, &at);
  for (int i = 0; i < at.count; i++) down += fabs(at.gap[i]) <= tol;
  assert_int_equal(down, d->points / 2);
  for (int i = 0; i < (d->space ? 6 : 3); i++) assert_near(v[i], 0, tol);
}

static void test_boxes(void **state)
{
  (void)state;
  nsdae_sim_options o = defaults();
  drop d = {.points = 4, .m = 1, .mu = 1, .size = 0.3};
  kept k;
  double q[7], v[6];
  const double tilt = 0.1;
  floor_below(&d, 1);
  for (int p = 0; p < 4; p++)
    for (int i = 0; i < 2; i++) d.point[p][i] = p >> i & 1 ? 0.05 : -0.05;
  d.J[2] = 0.05 * 0.05 * 2 / 3;
  d.q0[1] = 0.2 + 0.05 * (sin(tilt) + cos(tilt));
  d.q0[2] = tilt;
  drop_it(&d, &o, 6, &k, q, v);
  expect_flat(&d, q, v, 100 * o.rtol);

  d = (drop){.space = 1, .points = 8, .m = 2, .mu = 0.8, .size = 1};
  const double half[3] = {0.2, 0.15, 0.1}, p0[4] = {1, 0.3, 0.2, 0.1}, length = sqrt(1.14);
  floor_below(&d, 2);
  for (int i = 0; i < 3; i++) {
    double x = half[(i + 1) % 3], y = half[(i + 2) % 3];
    for (int p = 0; p < 8; p++) d.point[p][i] = p >> i & 1 ? half[i] : -half[i];
    d.J[i] = d.m / 3 * (x * x + y * y);
  }
  for (int i = 0; i < 4; i++) d.q0[3 + i] = p0[i] / length;
  const double v0[6] = {1, 0.5, 0, 1, -2, 3};
  memcpy(d.v0, v0, sizeof v0);
  d.q0[2] = 0.7;
  drop_it(&d, &o, 4, &k, q, v);
  expect_flat(&d, q, v, 100 * o.rtol);
}

/* ---- a ball that slips through its impact: the friction is mu P against its slip ---- */

static void test_ball(void **state)
{
  (void)state;
  drop d = {.space = 1, .points = 1, .m = 0.7, .radius = 0.11, .mu = 0.25, .e = 0.5};
  const double spin[3] = {-13, 7, 21}, v0[3] = {1.3, -0.4, 0}, h = 0.1;
  nsdae_sim_options o = defaults();
  kept k;
  double q[7], v[6];
  floor_below(&d, 2);
  for (int i = 0; i < 3; i++) d.J[i] = 0.4 * d.m * d.radius * d.radius;
  d.q0[2] = d.radius + h;
  d.q0[3] = 1; /* the same whichever way it is turned */
  memcpy(d.v0, v0, sizeof v0);
  memcpy(d.v0 + 3, spin, sizeof spin);
  drop_it(&d, &o, 0.2, &k, q, v);
  double slip[2] = {v0[0] - d.radius * spin[1], v0[1] + d.radius * spin[0]};
  double P = (1 + d.e) * d.m * sqrt(2 * g * h), speed = hypot(slip[0], slip[1]);
  assert_true(3.5 * d.mu * P / d.m < speed);
  assert_near(-d.mu * P * slip[0] / speed, -0.1023, 5e-5); /* as printed elsewhere */
  assert_near(-d.mu * P * slip[1] / speed, 0.3532, 5e-5);
  assert_int_equal(k.impacts, 1);
  assert_near(k.impact[0].normal_impulse, P, 100 * o.rtol);
  double along[2] = {k.impact[0].tangential_impulse[0], k.impact[0].tangential_impulse[1]};
  for (int i = 0; i < 2; i++) { /* of the walls' tangents */
    double T = along[0] * d.tangent[0][0][i] + along[1] * d.tangent[0][1][i];
    assert_near(T, -d.mu * P * slip[i] / speed, 100 * o.rtol);
  }
}

/* ---- a symmetric top with a tip at both ends, in space ---- */

/* x, v, the axis e and the angular momentum H about the centre, all in space, at a time. */
typedef struct top {
  double m, I1, I3, L, mu, restitution;
  double t, x[3], v[3], e[3], H[3];
} top;

static void cross(const double *a, const double *b, double *c)
{
  for (int i = 0; i < 3; i++)
    c[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
}

static double dot(const double *a, const double *b)
{
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* In flight the axis turns about H, which stays, by |H| / I1. */
static top fly(const top *from, double t)
{
  top to = *from;
  double h = t - from->t, H = sqrt(dot(from->H, from->H)), turn = H / from->I1 * h, n[3], across[3];
  for (int i = 0; i < 3; i++) n[i] = from->H[i] / H;
  cross(n, from->e, across);
  double along = dot(n, from->e);
  to.t = t;
  for (int i = 0; i < 3; i++) {
    to.e[i] = n[i] * along + (from->e[i] - n[i] * along) * cos(turn) + across[i] * sin(turn);
    to.x[i] += h * from->v[i];
  }
  to.x[2] -= g * h * h / 2;
  to.v[2] -= g * h;
  return to;
}

static double lowest(const top *p, int *tip)
{
  double up = p->x[2] + p->L * p->e[2], down = p->x[2] - p->L * p->e[2];
  *tip = down < up;
  return fmin(up, down);
}

/* The next touch: small ways, then bisection. */
static top land(const top *from, int *tip)
{
  double low = from->t + 1e-7, high = low;
  top p = fly(from, high);
  while (lowest(&p, tip) > 0) {
    low = high;
    p = fly(from, high += 1e-4);
  }
  for (int i = 0; i < 100; i++) {
    double t = (low + high) / 2;
    p = fly(from, t);
    *(lowest(&p, tip) > 0 ? &low : &high) = t;
  }
  return fly(from, high);
}

/* What an impulse P at the arm r makes of the velocity there: P / m + (I^-1 (r x P)) x r. */
static void yield(const top *p, const double *r, const double *P, double *dv)
{
  double moment[3], spin[3];
  cross(r, P, moment);
  double along = dot(p->e, moment);
  for (int i = 0; i < 3; i++)
    spin[i] = (moment[i] - p->e[i] * along) / p->I1 + p->e[i] * along / p->I3;
  cross(spin, r, dv);
  for (int i = 0; i < 3; i++) dv[i] += P[i] / p->m;
}

static void velocity_at(const top *p, const double *r, double *u)
{
  double along = dot(p->e, p->H), spin[3];
  for (int i = 0; i < 3; i++)
    spin[i] = (p->H[i] - p->e[i] * along) / p->I1 + p->e[i] * along / p->I3;
  cross(spin, r, u);
  for (int i = 0; i < 3; i++) u[i] += p->v[i];
}

/* The slip across d after an impulse with friction against d: zero where d is the way it slips
 * after it. P [3] is that impulse, u [3] the velocity. */
static double across(const top *p, const double *r, const double *u, double angle, double *P,
                     double *after)
{
  double unit[3] = {-p->mu * cos(angle), -p->mu * sin(angle), 1}, dv[3];
  yield(p, r, unit, dv);
  double size = -(1 + p->restitution) * u[2] / dv[2];
  for (int i = 0; i < 3; i++) {
    P[i] = size * unit[i];
    after[i] = u[i] + size * dv[i];
  }
  return after[1] * cos(angle) - after[0] * sin(angle);
}

/* P that leaves no slip: dv = D P by Cramer's rule. */
static void hold(const top *p, const double *r, const double *u, double *P)
{
  double D[3][3], b[3] = {-u[0], -u[1], -(1 + p->restitution) * u[2]}, c[3];
  for (int j = 0; j < 3; j++) {
    double unit[3] = {j == 0, j == 1, j == 2};
    yield(p, r, unit, D[j]);
  }
  cross(D[1], D[2], c);
  double det = dot(D[0], c);
  for (int j = 0; j < 3; j++) {
    double column[3];
    memcpy(column, D[j], sizeof column);
    memcpy(D[j], b, sizeof b);
    cross(D[1], D[2], c);
    P[j] = dot(D[0], c) / det;
    memcpy(D[j], column, sizeof column);
  }
}

/* Newton's restitution and Coulomb's friction at the tip: P. */
static void hit(top *p, int tip, double *P)
{
  const double pi = acos(-1);
  double r[3], u[3], after[3], moment[3], low = NAN, high = NAN;
  for (int i = 0; i < 3; i++) r[i] = (tip ? -1 : 1) * p->L * p->e[i];
  velocity_at(p, r, u);
  for (int i = 0; i < 3600; i++) { /* of the zeros, the one that slips along d */
    double a = i * pi / 1800, b = (i + 1) * pi / 1800;
    double at_a = across(p, r, u, a, P, after), forward = after[0] * cos(a) + after[1] * sin(a);
    if (forward > 0 && at_a * across(p, r, u, b, P, after) <= 0) low = a, high = b;
  }
  hold(p, r, u, P);
  int holds = hypot(P[0], P[1]) <= p->mu * P[2];
  assert_true(holds != (low < high)); /* one or the other */
  double at_low = holds ? 0 : across(p, r, u, low, P, after);
  for (int i = 0; i < 100 && !holds; i++) {
    double middle = (low + high) / 2;
    *(at_low * across(p, r, u, middle, P, after) > 0 ? &low : &high) = middle;
  }
  cross(r, P, moment);
  for (int i = 0; i < 3; i++) {
    p->v[i] += P[i] / p->m;
    p->H[i] += moment[i];
  }
}

/* R of a unit quaternion, its columns the axes of the body. */
static void axes(const double *p, double R[3][3])
{
  double a = p[0], b = p[1], c = p[2], d = p[3];
  double r[3][3] = {{a * a + b * b - c * c - d * d, 2 * (b * c - a * d), 2 * (b * d + a * c)},
                    {2 * (b * c + a * d), a * a - b * b + c * c - d * d, 2 * (c * d - a * b)},
                    {2 * (b * d - a * c), 2 * (c * d + a * b), a * a - b * b - c * c + d * d}};
  memcpy(R, r, sizeof r);
}

static top throw(const drop *d)
{
  top p = {.m = d->m,
           .I1 = d->J[0],
           .I3 = d->J[2],
           .L = d->point[0][2],
           .mu = d->mu,
           .restitution = d->e};
  double R[3][3];
  axes(d->q0 + 3, R);
  for (int i = 0; i < 3; i++) {
    p.x[i] = d->q0[i];
    p.v[i] = d->v0[i];
    p.e[i] = R[i][2];
    for (int j = 0; j < 3; j++) p.H[i] += R[i][j] * d->J[j] * d->v0[3 + j];
  }
  return p;
}

/* Times and impulses of all that it hits in 0.9 s, and the angle of the friction of the first. */
static void test_top(void **state)
{
  (void)state;
  for (int fine = 0; fine < 2; fine++) {
    drop d = {.space = 1, .points = 2, .m = 1.3, .mu = 0.1, .e = 0.7};
    const double J[3] = {0.02, 0.02, 0.008}, p0[4] = {1, 0.2, -0.3, 0.5},
                 v0[6] = {0.5, -0.2, 0.1, 3, -2, 9};
    nsdae_sim_options o = defaults();
    kept k;
    double q[7], v[6], P[3], growth = 1;
    if (fine) o.rtol = 1e-11, o.atol = 1e-13;
    floor_below(&d, 2);
    memcpy(d.J, J, sizeof J);
    memcpy(d.v0, v0, sizeof v0);
    d.point[0][2] = 0.3;
    d.point[1][2] = -0.3;
    d.q0[2] = 1.2;
    for (int i = 0; i < 4; i++) d.q0[3 + i] = p0[i] / sqrt(1.38);
    top p = throw(&d);
    drop_it(&d, &o, 0.9, &k, q, v);
    assert_true(k.impacts >= 1);
    for (int i = 0; i < k.impacts; i++, growth *= 10) {
      int tip;
      p = land(&p, &tip);
      hit(&p, tip, P);
      const nsdae_impact *of = &k.impact[i];
      double T[2] = {0};
      for (int l = 0; l < 2; l++)
        for (int j = 0; j < 2; j++) T[j] += of->tangential_impulse[l] * d.tangent[0][l][j];
      print_message("top: %.12f s, off by %.1e; friction at %.6f degrees, off by %.1e\n", of->time,
                    of->time - p.t, atan2(T[1], T[0]) * 180 / acos(-1),
                    (atan2(T[1], T[0]) - atan2(P[1], P[0])) * 180 / acos(-1));
      assert_int_equal(of->contact, tip);
      assert_near(of->time, p.t, growth * 100 * o.rtol);
      assert_near(of->normal_impulse, P[2], growth * 100 * o.rtol);
      for (int j = 0; j < 2; j++) assert_near(T[j], P[j], growth * 100 * o.rtol);
    }
  }
}

/* ---- a parallelogram on three cranks, one constraint of which says nothing ---- */

/* Biases by differences and given, at tolerances down to where the rank was once found anew. */
static void test_parallelogram(void **state)
{
  (void)state;
  const double phi = 1, rtols[] = {1e-6, 1e-8, 1e-9, 1e-10, 1e-11}, length = 0.5;
  for (int i = 0; i < 10; i++) {
    parallelogram p = {.cranks = 3, .given = i % 2, .e = 0.6};
    double q0[PARALLELOGRAM_NQ], v0[PARALLELOGRAM_NQ] = {0}, q[PARALLELOGRAM_NQ],
                                 v[PARALLELOGRAM_NQ], k0 = sin(phi / 2),
                                 t = parallelogram_quarter(&p, k0);
    nsdae_sim_options o = defaults();
    kept k;
    o.rtol = rtols[i / 2];
    o.atol = o.rtol / 100;
    o.dt = 0.05; /* of the records */
    o.redundant = NSDAE_REDUNDANT_LEAST_NORM;
    parallelogram_start(&p, phi, q0);
    go(parallelogram_system(&p), &o, q0, v0, 3, &k, q, v);
    assert_true(k.impacts >= 4);
    for (int n = 0; n < k.impacts; n++) {
      double speed = 2 * parallelogram_frequency(&p) * k0 * length;
      assert_near(k.impact[n].time, t, 100 * o.rtol + 1e-10); /* of a root of a velocity of 1 m/s */
      assert_near(k.impact[n].velocity_before, -speed, 100 * o.rtol + 1e-10);
      k0 *= p.e;
      t += 2 * parallelogram_quarter(&p, k0);
    }
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_block), cmocka_unit_test(test_boxes),
                                     cmocka_unit_test(test_ball), cmocka_unit_test(test_top),
                                     cmocka_unit_test(test_parallelogram)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
