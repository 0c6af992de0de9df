/* The event-driven method on families, seeded, each held against an integration or closed form of
 * its own: rods that jam, lift off or stop; oscillators that graze a stop; systems made to chatter,
 * on which nothing is right but that time goes on. NSDAE_FAMILY is how many of each (60). */
#include "check.h"

#include <stdlib.h>

#include "drop.h"
#include "random_system.h"

static int family(void)
{
  const char *asked = getenv("NSDAE_FAMILY");
  return asked ? atoi(asked) : 60;
}

static double between(uint64_t *state, double a, double b)
{
  return a + (b - a) * random_uniform(state);
}

/* ---- a rod (length 2, m = 1, g = 10) whose end slides against the way that it leans ----
 *
 * With the force l at the end that slides with u < 0: phi'' = 3 l (mu sin(phi) - cos(phi)),
 * u' = mu l + sin(phi) phi'' + cos(phi) w^2, l = (g - w^2 sin(phi)) / A,
 * A = 1 + 3 cos(phi) (cos(phi) - mu sin(phi)) (Genot and Brogliato 1999). */

enum { G = 10 };

typedef struct rod {
  double mu, phi, w, u;
} rod;

static double yield_of(const rod *r)
{
  return 1 + 3 * cos(r->phi) * (cos(r->phi) - r->mu * sin(r->phi));
}

static double pull_of(const rod *r)
{
  return G - r->w * r->w * sin(r->phi);
}

static rod rate_of(const rod *r)
{
  double l = pull_of(r) / yield_of(r), turn = 3 * l * (r->mu * sin(r->phi) - cos(r->phi));
  return (rod){0, r->w, turn, r->mu * l + sin(r->phi) * turn + cos(r->phi) * r->w * r->w};
}

static rod ahead(const rod *r, double h, const rod *rate)
{
  return (rod){r->mu, r->phi + h * rate->phi, r->w + h * rate->w, r->u + h * rate->u};
}

/* Runge and Kutta's method of order 4. */
static rod step(const rod *r, double h)
{
  rod a = rate_of(r), x = ahead(r, h / 2, &a), b = rate_of(&x);
  x = ahead(r, h / 2, &b);
  rod c = rate_of(&x);
  x = ahead(r, h, &c);
  rod d = rate_of(&x);
  rod mean = {0, (a.phi + 2 * b.phi + 2 * c.phi + d.phi) / 6, (a.w + 2 * b.w + 2 * c.w + d.w) / 6,
              (a.u + 2 * b.u + 2 * c.u + d.u) / 6};
  return ahead(r, h, &mean);
}

typedef enum fate { GOES_ON, JAMS, LEAVES, STOPS, FALLS } fate;

/* What becomes of it up to t_end, and when; steps are shorter the nearer it is to its pole. */
static fate follow(rod *r, double t_end, double *when)
{
  double t = 0;
  fate f = GOES_ON;
  while (t < t_end && f == GOES_ON) {
    double h = fmin(2e-4 * fmin(1, yield_of(r)), t_end - t);
    rod next = step(r, h);
    if (yield_of(&next) < 1e-9)
      f = JAMS;
    else if (pull_of(&next) <= 0)
      f = LEAVES;
    else if (next.u >= 0)
      f = STOPS;
    else if (sin(next.phi) <= 0)
      f = FALLS;
    t += h;
    *r = next;
  }
  *when = t;
  return f;
}

static void make_rod(drop *d, const rod *r)
{
  *d = (drop){.bodies = 1, .points = 2, .walls = 1, .m = 1, .g = G, .mu = r->mu, .size = 1};
  d->J[2] = 1.0 / 3;
  d->normal[0][1] = 1;
  d->point[0][0] = -1;
  d->point[1][0] = 1;
  d->q0[1] = sin(r->phi);
  d->q0[2] = r->phi;
  d->v0[0] = r->u - sin(r->phi) * r->w;
  d->v0[1] = cos(r->phi) * r->w;
  d->v0[2] = r->w;
}

/* Runs it to t_end; its state, and where it failed. */
static int frictional_joint(const rod *from, double rtol, double t_end, rod *to, double *failed)
{
  drop d;
  nsdae_sim_options o;
  nsdae_record record;
  nsdae_sim *sim;
  make_rod(&d, from);
  nsdae_system *system = drop_system(&d);
  nsdae_sim_options_default(&o);
  o.method = NSDAE_METHOD_EVENT;
  o.rtol = rtol;
  o.atol = 1e-2 * rtol;
  assert_int_equal(nsdae_sim_create(system, &o, &sim, NULL), NSDAE_OK);
  int status = nsdae_sim_init(sim, 0, d.q0, d.v0);
  if (status >= 0) status = nsdae_sim_run(sim, t_end);
  *failed = nsdae_sim_error(sim)->time;
  if (nsdae_sim_get_record(sim, &record) >= 0)
    *to = (rod){from->mu, record.q[2], record.v[2], record.v[0] + sin(record.q[2]) * record.v[2]};
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  return status;
}

static void test_rods(void **state)
{
  (void)state;
  int fates[5] = {0};
  const double T = 0.6;
  for (int seed = 1; seed <= family(); seed++) {
    uint64_t s = (uint64_t)seed;
    rod from = {between(&s, 1.4, 2.5), between(&s, 0.2, 0.9), between(&s, -2, 3),
                -pow(10, between(&s, -0.3, 1.5))},
        to = from, found;
    double rtol = pow(10, between(&s, -10, -5)), when, failed;
    if (fabs(yield_of(&from)) < 0.05 || fabs(pull_of(&from)) < 0.1) continue;
    if (yield_of(&from) < 0 && pull_of(&from) > 0) { /* it has none from the start on */
      assert_int_equal(frictional_joint(&from, rtol, T, &found, &failed), NSDAE_E_PAINLEVE);
      assert_near(failed, 0, 1e-12);
      continue;
    }
    if (yield_of(&from) < 0 || pull_of(&from) < 0) continue;
    fate f = follow(&to, T, &when);
    fates[f]++;
    print_message("seed %d: mu %.3g phi %.3g w %.3g u %.3g rtol %.1e: fate %d at %.8f\n", seed,
                  from.mu, from.phi, from.w, from.u, rtol, (int)f, when);
    if (f == JAMS) {
      assert_int_equal(frictional_joint(&from, rtol, T, &found, &failed), NSDAE_E_PAINLEVE);
      assert_near(failed, when, 1e3 * rtol + 1e-7);
    }
    /* before that, the same motion */
    rod expected = from;
    double until = 0.9 * when, unused;
    follow(&expected, until, &unused);
    assert_true(frictional_joint(&from, rtol, until, &found, &failed) >= 0);
    assert_near(found.phi, expected.phi, 1e3 * rtol + 1e-9);
    assert_near(found.w, expected.w, 1e4 * rtol + 1e-8);
  }
  print_message("%d go on, %d jam, %d leave, %d stop, %d fall\n", fates[0], fates[1], fates[2],
                fates[3], fates[4]);
  if (family() >= 60) assert_true(fates[JAMS] >= 4 && fates[LEAVES] + fates[STOPS] >= 5);
}

/* ---- an oscillator q'' = -q against a stop at 1 - deep, just within its reach ---- */

static int unit_mass(double t, const double *q, double *M, int ldm, void *user)
{
  (void)t, (void)q, (void)user;
  M[0] = 1;
  (void)ldm;
  return 0;
}

static int spring(double t, const double *q, const double *v, double *F, void *user)
{
  (void)t, (void)v, (void)user;
  F[0] = -q[0];
  return 0;
}

static int stop(double t, const double *q, double *gap, void *user)
{
  (void)t;
  gap[0] = 1 - *(const double *)user - q[0];
  return 0;
}

enum { HITS = 12 };

typedef struct hits {
  int count;
  double time[HITS], speed[HITS];
} hits;

static int keep_hits(const nsdae_record *record, nsdae_error *error, void *user)
{
  hits *h = user;
  (void)error;
  for (int i = 0; i < record->impacts && h->count < HITS; i++, h->count++) {
    h->time[h->count] = record->impact[i].time;
    h->speed[h->count] = -record->impact[i].velocity_before;
  }
  return 0;
}

/* With amplitude a it comes at the stop x with sqrt(a^2 - x^2), pi + 2 asin(x / a) after the last
 * time; from q = 0, v = 1 the first time at asin(x). */
static void expect_hits(const hits *h, double deep, double e, double rtol, double t_end)
{
  double x = 1 - deep, speed = sqrt(deep * (2 - deep)), t = asin(x);
  for (int n = 0; n < HITS && t < t_end; n++) {
    if (speed < 1e2 * sqrt(rtol)) return; /* it grazes by less than can be told */
    assert_true(n < h->count);
    assert_near(h->speed[n], speed, 1e3 * rtol / speed);
    assert_near(h->time[n], t, 1e3 * rtol * (1 + t) / speed);
    speed *= e;
    t += acos(-1) + 2 * asin(x / hypot(x, speed));
  }
}

static void test_grazing(void **state)
{
  (void)state;
  const nsdae_dims dims = {.nq = 1, .k = 1};
  for (int seed = 1; seed <= family(); seed++) {
    uint64_t s = (uint64_t)seed;
    double deep = pow(10, between(&s, -7, -0.5)), q0 = 0, v0 = 1;
    double e = random_below(&s, 2) ? 1 : between(&s, 0.5, 1), t_end = 60;
    hits h = {0};
    nsdae_sim_options o;
    nsdae_system *system;
    nsdae_sim *sim;
    nsdae_sim_options_default(&o);
    o.method = NSDAE_METHOD_EVENT;
    o.dt = pow(10, between(&s, -2.5, 1));
    o.rtol = pow(10, between(&s, -11, -8));
    o.atol = 1e-2 * o.rtol;
    assert_int_equal(nsdae_system_create(&dims, &system, NULL), NSDAE_OK);
    nsdae_system_set_user(system, &deep);
    nsdae_system_set_mass(system, unit_mass);
    nsdae_system_set_force(system, spring);
    nsdae_system_set_gap(system, stop);
    nsdae_system_set_contact(system, 0, 0, e, 0);
    assert_int_equal(nsdae_sim_create(system, &o, &sim, NULL), NSDAE_OK);
    nsdae_sim_observe(sim, keep_hits, &h);
    assert_int_equal(nsdae_sim_init(sim, 0, &q0, &v0), NSDAE_OK);
    assert_int_equal(nsdae_sim_run(sim, t_end), NSDAE_OK);
    nsdae_sim_destroy(&sim);
    nsdae_system_destroy(&system);
    expect_hits(&h, deep, e, o.rtol, t_end);
  }
}

/* ---- two bodies made to chatter: a force that jumps with the sign of velocities and of time, a
 * floor that is saw-toothed, coefficients near those that lose nothing ---- */

typedef struct chatter {
  double jump, tooth, pitch, stiff, e, mu;
} chatter;

static int chatter_mass(double t, const double *q, double *M, int ldm, void *user)
{
  (void)t, (void)q, (void)user;
  M[0] = M[ldm + 1] = 1;
  M[2 * (ldm + 1)] = 1e-3;
  return 0;
}

static double sign(double x)
{
  return (x > 0) - (x < 0);
}

static int chatter_force(double t, const double *q, const double *v, double *F, void *user)
{
  const chatter *c = user;
  F[0] = -c->jump * sign(v[0]) + sin(7 * t);
  F[1] = -9.81 - c->stiff * (q[1] - q[2]) - c->jump * sign(v[1] - v[2]);
  F[2] = -9.81e-3 + c->stiff * (q[1] - q[2]);
  return 0;
}

static int chatter_gap(double t, const double *q, double *gap, void *user)
{
  const chatter *c = user;
  double x = q[0] / c->pitch;
  (void)t;
  gap[0] = q[2] - c->tooth * fabs(x - floor(x) - 0.5);
  gap[1] = q[1] - q[2] + 0.05;
  gap[2] = 0.2 - q[1];
  return 0;
}

static int chatter_tangent(double t, const double *q, double *W, int ldw, void *user)
{
  (void)t, (void)q, (void)user;
  for (int i = 0; i < 3; i++) W[i * ldw] = 1;
  return 0;
}

typedef struct progress {
  double time, dt;
  long grid, records, most; /* dt in work, records in it, the most of any */
} progress;

static int keep_progress(const nsdae_record *record, nsdae_error *error, void *user)
{
  progress *p = user;
  (void)error;
  if (record->step > 0) assert_true(record->time > p->time); /* per step */
  long grid = (long)ceil(record->time / p->dt - 1e-9);
  p->records = grid == p->grid ? p->records + 1 : 1;
  p->grid = grid;
  p->time = record->time;
  p->most = p->records > p->most ? p->records : p->most;
  return 0;
}

static nsdae_system *chatter_system(chatter *c)
{
  const nsdae_dims dims = {.nq = 3, .k = 3, .nt = 1};
  nsdae_system *s;
  assert_int_equal(nsdae_system_create(&dims, &s, NULL), NSDAE_OK);
  nsdae_system_set_user(s, c);
  nsdae_system_set_mass(s, chatter_mass);
  nsdae_system_set_force(s, chatter_force);
  nsdae_system_set_gap(s, chatter_gap);
  nsdae_system_set_gap_tangent(s, chatter_tangent);
  for (int i = 0; i < 3; i++) nsdae_system_set_contact(s, i, c->mu, c->e, 0);
  return s;
}

static chatter draw_chatter(uint64_t *s)
{
  return (chatter){.jump = random_below(s, 3) ? pow(10, between(s, -1, 2)) : 0,
                   .tooth = random_below(s, 3) ? pow(10, between(s, -4, -1)) : 0,
                   .pitch = pow(10, between(s, -4, -1)),
                   .stiff = random_below(s, 2) ? pow(10, between(s, 0, 8)) : 0,
                   .e = random_below(s, 2) ? 1 : between(s, 0.9, 1),
                   .mu = random_below(s, 2) ? between(s, 0, 2) : 0};
}

static nsdae_sim_options draw_bounds(uint64_t *s)
{
  nsdae_sim_options o;
  nsdae_sim_options_default(&o);
  o.method = NSDAE_METHOD_EVENT;
  o.start_check = 0;
  o.dt = pow(10, between(s, -3, -1));
  o.rtol = pow(10, between(s, -10, -4));
  o.atol = 1e-2 * o.rtol;
  o.events_max = 1 + random_below(s, 300);
  o.inner_steps_max = 100 + random_below(s, 3000);
  return o;
}

/* It ends, at its end or with a status; every step goes on; a dt has so many instants as events_max
 * says and no more steps than that, so that a run has no more than these times its dt. */
static void test_progress(void **state)
{
  (void)state;
  const double T = 0.5;
  int done = 0, fallen = 0;
  for (int seed = 1; seed <= family(); seed++) {
    uint64_t s = (uint64_t)seed;
    chatter c = draw_chatter(&s);
    nsdae_sim_options o = draw_bounds(&s);
    double q0[3] = {between(&s, -1, 1), 0.16, 0.15}, v0[3] = {between(&s, -1, 1)};
    nsdae_stats stats;
    nsdae_sim *sim;
    progress p = {.dt = o.dt};
    nsdae_system *system = chatter_system(&c);
    assert_int_equal(nsdae_sim_create(system, &o, &sim, NULL), NSDAE_OK);
    nsdae_sim_observe(sim, keep_progress, &p);
    int status = nsdae_sim_init(sim, 0, q0, v0);
    if (status >= 0) status = nsdae_sim_run(sim, T);
    nsdae_sim_get_stats(sim, &stats);
    if (status < 0) assert_true(nsdae_sim_error(sim)->text[0] != 0);
    if (status >= 0) assert_near(p.time, T, 1e-12);
    assert_at_most((double)p.most, o.events_max + 2);
    assert_at_most((double)stats.events, (o.events_max + 2) * (ceil(T / o.dt) + 1));
    done += status >= 0, fallen += stats.fallback_steps > 0;
    nsdae_sim_destroy(&sim);
    nsdae_system_destroy(&system);
  }
  print_message("%d of %d done, %d with steps by implicit\n", done, family(), fallen);
  if (family() >= 60) assert_true(done >= 20 && fallen >= 5);
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_rods), cmocka_unit_test(test_grazing),
                                     cmocka_unit_test(test_progress)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
