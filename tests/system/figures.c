/* The certificate of every record, computed again from q, v and the forces of the records by the
 * formulas of the models: exact cases, and random systems with moving constraints, moving contacts,
 * inertia that turns, dampers and slides, by every method. */
#include "check.h"

#include <nsdae/nsdae.h>

#include "disks.h"
#include "random_system.h"

static const double gravity = 9.81;

/* ---- Exact cases: a body at (x, y) of mass m over a floor y = 0, pushed along x, without a
 * potential unless that is asked for. */
typedef struct block {
  double m, mu, e, push;
  int potential;
  nsdae_system *system;
  nsdae_sim *sim;
} block;

static int block_mass(double t, const double *q, double *M, int ldm, void *user)
{
  const block *b = user;
  (void)t;
  (void)q;
  M[0] = M[ldm + 1] = b->m;
  return 0;
}

static int block_force(double t, const double *q, const double *v, double *F, void *user)
{
  const block *b = user;
  (void)t;
  (void)q;
  (void)v;
  F[0] = b->push;
  F[1] = -b->m * gravity;
  return 0;
}

static int block_potential(double t, const double *q, double *energy, void *user)
{
  const block *b = user;
  (void)t;
  *energy = b->m * gravity * q[1];
  return 0;
}

static int block_gap(double t, const double *q, double *g, void *user)
{
  (void)t;
  (void)user;
  g[0] = q[1];
  return 0;
}

static int block_normal(double t, const double *q, double *W, int ldw, void *user)
{
  (void)t;
  (void)q;
  (void)ldw;
  (void)user;
  W[1] = 1;
  return 0;
}

static int block_tangent(double t, const double *q, double *W, int ldw, void *user)
{
  (void)t;
  (void)q;
  (void)ldw;
  (void)user;
  W[0] = 1;
  return 0;
}

/* 0: the method is not built. */
static int block_start(block *b, const nsdae_sim_options *options, const double *q0,
                       const double *v0)
{
  const nsdae_dims dims = {.nq = 2, .nv = 2, .k = 1, .nt = 1};
  assert_int_equal(nsdae_system_create(&dims, &b->system, NULL), NSDAE_OK);
  nsdae_system_set_user(b->system, b);
  nsdae_system_set_mass(b->system, block_mass);
  nsdae_system_set_force(b->system, block_force);
  if (b->potential) nsdae_system_set_potential(b->system, block_potential);
  nsdae_system_set_gap(b->system, block_gap);
  nsdae_system_set_gap_normal(b->system, block_normal);
  nsdae_system_set_gap_tangent(b->system, block_tangent);
  nsdae_system_set_contact(b->system, 0, b->mu, b->e, 0);
  int status = nsdae_sim_create(b->system, options, &b->sim, NULL);
  if (status == NSDAE_E_UNSUPPORTED) return 0;
  assert_int_equal(status, NSDAE_OK);
  assert_int_equal(nsdae_sim_init(b->sim, 0, q0, v0), NSDAE_OK);
  return 1;
}

static void block_end(block *b)
{
  nsdae_sim_destroy(&b->sim);
  nsdae_system_destroy(&b->system);
}

/* energy = energy_start + work - dissipated + unexplained, in the statistics as in the record. */
static nsdae_certificate balance(const nsdae_sim *sim)
{
  nsdae_record r;
  nsdae_stats s;
  assert_int_equal(nsdae_sim_get_record(sim, &r), NSDAE_OK);
  assert_int_equal(nsdae_sim_get_stats(sim, &s), NSDAE_OK);
  const nsdae_certificate c = r.certificate;
  double size = fabs(s.energy_start) + fabs(c.energy) + fabs(c.work) + fabs(c.dissipated);
  assert_near(c.energy, r.kinetic + r.potential, 0);
  assert_near(c.dissipated, r.dissipated, 0);
  assert_near(c.energy, s.energy_start + c.work - c.dissipated + c.unexplained, 1e-13 * size);
  assert_near(s.certificate.unexplained, c.unexplained, 0);
  assert_near(s.certificate.work, c.work, 0);
  return c;
}

/* A block that slides to the right under a push p < mu m g: friction on its cone, the work of the
 * push p x, of friction mu m g x; the same at rest, where it does none. */
static void test_block(void **state)
{
  (void)state;
  for (int method = 0; nsdae_method_name(method); method++)
    for (int slides = 0; slides < 2; slides++) {
      block b = {.m = 3, .mu = 0.3, .push = 2};
      const double q0[2] = {0, 0}, v0[2] = {slides ? 5 : 0, 0};
      double weight = b.m * gravity, exact = method == NSDAE_METHOD_PENALTY ? 2e-2 : 1e-9;
      nsdae_sim_options options;
      nsdae_stats s;
      nsdae_record r;
      nsdae_sim_options_default(&options);
      options.method = method;
      options.dt = 1e-3;
      if (block_start(&b, &options, q0, v0)) {
        assert_true(nsdae_sim_run(b.sim, 1) >= 0);
        const nsdae_certificate c = balance(b.sim);
        nsdae_sim_get_stats(b.sim, &s);
        nsdae_sim_get_record(b.sim, &r);
        assert_near(s.certificate.pull, 0, 0);
        assert_int_equal(s.certificate.pull_contact, -1);
        assert_at_most(s.certificate.cone_excess, 1e-12 * weight * options.dt);
        assert_at_most(s.certificate.complementarity, 1e-9 * weight * options.dt);
        if (method != NSDAE_METHOD_PENALTY)
          assert_near(r.normal_impulse[0], weight * options.dt, 1e-9 * weight * options.dt);
        assert_near(c.work, b.push * r.q[0] - weight * r.q[1], exact);
        if (slides) assert_near(c.dissipated, b.mu * weight * r.q[0], exact * weight);
        assert_near(c.unexplained, 0, 1e-9);
      }
      block_end(&b);
    }
}

/* A ball that hits the floor with v: its law takes (1 - e^2) m v^2 / 2, and that is all. The
 * impulse of a time-stepping method has the weight of its step in it, m g h (1 - e) v / 2. */
static void test_bounce(void **state)
{
  static const double restitution[] = {0, 0.5, 1};
  (void)state;
  for (int method = 0; nsdae_method_name(method); method++)
    for (int i = 0; i < 3 && method != NSDAE_METHOD_PENALTY; i++) {
      block b = {.m = 2, .e = restitution[i], .potential = 1};
      const double q0[2] = {0, 1}, v0[2] = {1, 0};
      nsdae_sim_options options;
      nsdae_record r;
      nsdae_sim_options_default(&options);
      options.projection = NSDAE_PROJECTION_NONE; /* figures of the bare step */
      options.method = method;
      options.dt = 1e-3;
      if (block_start(&b, &options, q0, v0)) {
        do assert_true(nsdae_sim_step(b.sim) >= 0), nsdae_sim_get_record(b.sim, &r);
        while (r.impacts == 0);
        const nsdae_certificate c = balance(b.sim);
        double v = -r.impact[0].velocity_before, e = b.e;
        double h = method == NSDAE_METHOD_EVENT ? 0 : options.dt;
        double impulse = b.m * ((1 + e) * v + gravity * h);
        assert_near(c.dissipated, impulse * (1 - e) * v / 2, 1e-9);
        assert_near(c.unexplained, 0, 1e-11);
        assert_near(c.work, 0, 1e-8);
        assert_at_most(c.complementarity, 1e-13 * b.m * v * v);
      }
      block_end(&b);
    }
}

/* ---- A pendulum of such a body, |q| = 1. */
static int pendulum_rod(double t, const double *q, double *phi, void *user)
{
  (void)t;
  (void)user;
  phi[0] = (q[0] * q[0] + q[1] * q[1] - 1) / 2;
  return 0;
}

static int pendulum_jacobian(double t, const double *q, double *J, int ldj, void *user)
{
  (void)t;
  (void)user;
  J[0] = q[0];
  J[ldj] = q[1];
  return 0;
}

/* What is lost by q and v of the record, whatever the library says. */
static int judge_pendulum(const nsdae_record *r, nsdae_error *error, void *user)
{
  double *worst = user;
  double energy = (r->v[0] * r->v[0] + r->v[1] * r->v[1]) / 2 + gravity * r->q[1];
  double rate = r->q[0] * r->v[0] + r->q[1] * r->v[1];
  double phi = (r->q[0] * r->q[0] + r->q[1] * r->q[1] - 1) / 2;
  (void)error;
  worst[0] = fmax(worst[0], fabs(energy - r->certificate.unexplained)); /* at the start 0 */
  worst[1] = fmax(worst[1], fabs(fabs(rate) - r->certificate.constraint_rate));
  worst[2] = fmax(worst[2], fabs(fabs(phi) - r->certificate.constraint_drift));
  worst[3] = energy;
  return 0;
}

/* Moreau's loss at dt is the energy of the state; so is the error of the others, which keep their
 * rates at the end. */
static void test_loss(void **state)
{
  (void)state;
  for (int method = 0; nsdae_method_name(method); method++) {
    const nsdae_dims dims = {.nq = 2, .nv = 2, .m = 1};
    const double q0[2] = {1, 0}, v0[2] = {0, 0};
    double worst[4] = {0};
    block bob = {.m = 1};
    nsdae_system *system;
    nsdae_sim *sim;
    nsdae_sim_options options;
    nsdae_sim_options_default(&options);
    options.method = method;
    options.dt = 1e-2;
    assert_int_equal(nsdae_system_create(&dims, &system, NULL), NSDAE_OK);
    nsdae_system_set_user(system, &bob);
    nsdae_system_set_mass(system, block_mass);
    nsdae_system_set_force(system, block_force);
    nsdae_system_set_constraint(system, pendulum_rod);
    nsdae_system_set_constraint_jacobian(system, pendulum_jacobian);
    if (nsdae_sim_create(system, &options, &sim, NULL) == NSDAE_OK) {
      nsdae_sim_init(sim, 0, q0, v0);
      nsdae_sim_observe(sim, judge_pendulum, worst);
      assert_true(nsdae_sim_run(sim, 2) >= 0);
      nsdae_sim_destroy(&sim);
      int moreau = method == NSDAE_METHOD_MOREAU;
      /* of moreau the rate is that of the middle, which is kept */
      if (moreau) assert_at_most(worst[3], -1e-2);
      /* without a potential gravity is a load, so that energy - work is the whole of the error */
      assert_at_most(worst[0], moreau ? 1e-12 : 1e-7); /* of their iterations and tolerances */
      if (!moreau) assert_at_most(worst[1], 1e-14);
      assert_at_most(worst[2], 1e-15);
    }
    nsdae_system_destroy(&system);
  }
}

/* ---- Random systems */

enum { SEEDS = 60, STEPS = 60 };

static const double step_length = 2e-3;

/* What a run is judged by: the record before, and the sums so far. */
typedef struct judge {
  random_system *r;
  int method, potential, records;
  double q[RANDOM_NQ], v[RANDOM_NQ];
  double work, start, size;       /* of all forces; kinetic energy at the start; of energies */
  double off[6];                  /* from the figures of the certificate: the worst */
  double unexplained, violations; /* of event and penalty; figures that were not 0 */
  nsdae_certificate most;
} judge;

static double row_value(const random_system *r, const random_row *w, double t, const double *q)
{
  double value = -w->rate * t - w->offset, bend = 0;
  for (int i = 0; i < r->dims.nq; i++) value += w->c[i] * q[i], bend += w->B[i] * q[i];
  return value + w->b * sin(bend);
}

static double row_rate(const random_system *r, const random_row *w, const double *q,
                       const double *v)
{
  double rate = -w->rate, bend = 0;
  for (int i = 0; i < r->dims.nq; i++) bend += w->B[i] * q[i];
  for (int i = 0; i < r->dims.nq; i++)
    rate += (w->c[i] + w->b * cos(bend) * w->B[i]) * r->h[i] * v[i];
  return rate;
}

static double power(const random_system *r, const double *q, const double *v)
{
  double sum = 0;
  for (int i = 0; i < r->dims.nq; i++)
    sum -= v[i] *
           (r->h[i] * (r->m[i] * r->a[i] * cos(q[i]) * v[i] * v[i] / 2 + r->g[i] + r->s[i] * q[i]) +
            r->damp[i] * v[i]);
  return sum;
}

static double kinetic(const random_system *r, const double *q, const double *v)
{
  double sum = 0;
  for (int i = 0; i < r->dims.nq; i++) sum += r->m[i] * (1 + r->a[i] * sin(q[i])) * v[i] * v[i] / 2;
  return sum;
}

static double potential(const random_system *r, const double *q)
{
  double sum = 0;
  for (int i = 0; i < r->dims.nq; i++) sum += (r->g[i] + r->s[i] * q[i] / 2) * q[i];
  return sum;
}

/* The work that is not of the potential, of the step from the record before, by the trapezoid. */
static double work_of(const judge *j, const nsdae_record *r)
{
  const random_system *of = j->r;
  int nt = of->dims.nt;
  double h = r->duration, work = h / 2 * (power(of, j->q, j->v) + power(of, r->q, r->v));
  for (int i = 0; i < of->dims.nq; i++) {
    double vm = (j->v[i] + r->v[i]) / 2;
    work += of->m[i] * of->a[i] * (sin(r->q[i]) - sin(j->q[i])) * vm * vm / 2;
  }
  for (int i = 0; i < of->dims.m; i++) work -= h * r->multiplier[i] * of->phi[i].rate;
  for (int i = 0; i < of->dims.k; i++) work += r->normal_impulse[i] * of->gap[i].rate;
  /* without the callback tangents stand still */
  for (int i = 0; i < of->dims.k * nt && of->given >> RANDOM_CONTACT_BIAS & 1; i++)
    work -= r->tangential_impulse[i] * of->w_T[i];
  for (int i = 0; i < of->dims.f; i++) work -= r->frictional_joint_impulse[i] * of->w_S[i];
  return work;
}

static void compare(judge *j, int figure, double mine, double theirs, double size, int item)
{
  j->off[figure] = fmax(j->off[figure], fabs(mine - theirs) / size);
  if ((theirs > 0) != (item >= 0)) j->off[figure] = INFINITY; /* an index without a figure */
  j->violations += theirs > 0;
}

/* Of moreau the rates are those of the middle, by the velocity of the end. */
static double worst_rate(const judge *j, const nsdae_record *r)
{
  double middle[RANDOM_NQ], most = 0;
  const double *q = r->q;
  for (int i = 0; i < j->r->dims.nq; i++)
    middle[i] = j->q[i] + r->duration / 2 * j->r->h[i] * j->v[i];
  if (j->method == NSDAE_METHOD_MOREAU && j->records > 0) q = middle;
  for (int i = 0; i < j->r->dims.m; i++)
    most = fmax(most, fabs(row_rate(j->r, &j->r->phi[i], q, r->v)));
  return most;
}

static void judge_contacts(judge *j, const nsdae_record *r)
{
  const nsdae_certificate *c = &r->certificate;
  double pull = 0, excess = 0, depth = 0, drift = 0, impulse = 1;
  for (int i = 0; i < j->r->dims.k; i++) {
    const double *T = r->tangential_impulse + i * j->r->dims.nt;
    double along = 0, mu = j->r->dims.nt ? j->r->mu[i] : 0;
    for (int l = 0; l < j->r->dims.nt; l++) along = hypot(along, T[l]);
    pull = fmax(pull, -r->normal_impulse[i]);
    excess = fmax(excess, along - mu * r->normal_impulse[i]);
    depth = fmax(depth, -row_value(j->r, &j->r->gap[i], r->time, r->q));
    impulse = fmax(impulse, fabs(r->normal_impulse[i]));
  }
  int joint = c->cone_contact < 0 && c->cone_excess > excess; /* it has no number of a contact */
  for (int i = 0; i < j->r->dims.m; i++)
    drift = fmax(drift, fabs(row_value(j->r, &j->r->phi[i], r->time, r->q)));
  compare(j, 0, pull, c->pull, impulse, c->pull_contact);
  if (!joint) compare(j, 1, excess, c->cone_excess, impulse, c->cone_contact);
  if (joint) assert_at_most(c->cone_excess, 1e-10 * impulse);
  compare(j, 2, depth, c->penetration, 1, c->penetration_contact);
  compare(j, 3, drift, c->constraint_drift, 1, c->drift_constraint);
  compare(j, 4, worst_rate(j, r), c->constraint_rate, 1, c->rate_constraint);
  if (c->pull_contact >= 0)
    j->off[0] = fmax(j->off[0], fabs(c->pull + r->normal_impulse[c->pull_contact]));
  if (c->penetration_contact >= 0)
    j->off[2] = fmax(j->off[2], fabs(c->penetration + r->gap[c->penetration_contact]));
}

static void raise_to(double *most, double value)
{
  *most = fmax(*most, value);
}

static int judge_record(const nsdae_record *r, nsdae_error *error, void *user)
{
  judge *j = user;
  const nsdae_certificate *c = &r->certificate;
  double T = kinetic(j->r, r->q, r->v), U = j->potential ? potential(j->r, r->q) : 0;
  int integrated = j->method == NSDAE_METHOD_PENALTY || j->method == NSDAE_METHOD_EVENT;
  (void)error;
  if (j->records == 0) j->start = T;
  if (j->records > 0) j->work += work_of(j, r);
  j->size = fmax(j->size, 1 + T + fabs(U) + fabs(r->dissipated) + fabs(j->work));
  judge_contacts(j, r);
  double mine = T - j->start + r->dissipated - j->work;
  if (!integrated) {
    j->off[5] = fmax(j->off[5], fabs(mine - c->unexplained) / j->size);
    j->off[5] = fmax(j->off[5], fabs(T + U - c->energy) / j->size);
  }
  j->unexplained = fmax(j->unexplained, fabs(c->unexplained) / j->size);
  raise_to(&j->most.pull, c->pull);
  raise_to(&j->most.cone_excess, c->cone_excess);
  raise_to(&j->most.penetration, c->penetration);
  raise_to(&j->most.constraint_drift, c->constraint_drift);
  raise_to(&j->most.constraint_rate, c->constraint_rate);
  raise_to(&j->most.complementarity, c->complementarity);
  memcpy(j->q, r->q, (size_t)j->r->dims.nq * sizeof *j->q);
  memcpy(j->v, r->v, (size_t)j->r->dims.nv * sizeof *j->v);
  j->records++;
  return 0;
}

/* The statistics have the largest of all records. */
static void expect_most(const nsdae_sim *sim, const judge *j)
{
  nsdae_stats s;
  nsdae_sim_get_stats(sim, &s);
  assert_near(s.certificate.pull, j->most.pull, 0);
  assert_near(s.certificate.cone_excess, j->most.cone_excess, 0);
  assert_near(s.certificate.penetration, j->most.penetration, 0);
  assert_near(s.certificate.constraint_drift, j->most.constraint_drift, 0);
  assert_near(s.certificate.constraint_rate, j->most.constraint_rate, 0);
  assert_near(s.certificate.complementarity, j->most.complementarity, 0);
  assert_near(s.certificate.penetration, s.worst_penetration, 0);
  assert_near(s.certificate.constraint_drift, s.worst_drift, 0);
}

/* How many records were judged; their violations are added. */
static int judge_run(uint64_t seed, int method, double *violations)
{
  random_system r;
  nsdae_sim_options options;
  nsdae_sim *sim = NULL;
  random_system_draw(&r, seed, RANDOM_PLAIN);
  nsdae_system *system = random_system_make(&r);
  judge j = {.r = &r, .method = method, .potential = (int)(r.given >> RANDOM_POTENTIAL & 1)};
  nsdae_sim_options_default(&options);
  options.projection = NSDAE_PROJECTION_NONE; /* figures of the bare step */
  options.method = method;
  options.dt = step_length;
  options.start_tol = 1e-3;
  int status = nsdae_sim_create(system, &options, &sim, NULL);
  if (status == NSDAE_OK) status = nsdae_sim_init(sim, 0, r.q0, r.v0);
  if (status == NSDAE_OK) status = nsdae_sim_observe(sim, judge_record, &j);
  if (status == NSDAE_OK) nsdae_sim_run(sim, STEPS * step_length);
  if (j.records > 0) {
    int differences = ~r.given & (1 << RANDOM_JACOBIAN | 1 << RANDOM_BIAS | 1 << RANDOM_NORMAL |
                                  1 << RANDOM_CONTACT_BIAS);
    double tol = differences ? 1e-6 : 1e-11; /* of rates by differences */
    balance(sim);
    expect_most(sim, &j);
    for (int i = 0; i < 6; i++) {
      if (!(j.off[i] <= (i < 4 ? 1e-13 : tol)))
        print_error("seed %d, %s: figure %d is off by %.3g\n", (int)seed, nsdae_method_name(method),
                    i, j.off[i]);
      assert_at_most(j.off[i], i < 4 ? 1e-13 : tol);
    }
    if (method == NSDAE_METHOD_PENALTY || method == NSDAE_METHOD_EVENT)
      assert_at_most(j.unexplained, method == NSDAE_METHOD_EVENT ? 1e-8 : 1e-5);
    *violations += j.violations;
  }
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  return j.records;
}

static void test_random(void **state)
{
  (void)state;
  for (int method = 0; nsdae_method_name(method); method++) {
    double violations = 0;
    int records = 0;
    for (uint64_t seed = 1; seed <= SEEDS; seed++) records += judge_run(seed, method, &violations);
    if (records > 0) assert_true(records > SEEDS * STEPS / 2 && violations > 100); /* built */
  }
}

/* ---- Contacts by list: with a loose tolerance they pull, and leave their cones. */

enum { DISKS = 30 };

typedef struct heap {
  const disks *d;
  double off, pull, excess, depth, apart; /* apart: of overlaps by places */
  int entered;
} heap;

static int judge_heap(const nsdae_record *r, nsdae_error *error, void *user)
{
  heap *h = user;
  const nsdae_contact_set *s = &r->contacts;
  const nsdae_certificate *c = &r->certificate;
  double pull = 0, excess = 0, depth = 0;
  (void)error;
  /* the certificate also has contacts that the step did not close: those of the places */
  const double *q = r->q;
  double overlap = 0;
  for (int i = 0; i < h->d->n; i++) {
    overlap =
        fmax(overlap, h->d->radius - fmin(q[3 * i + 1], fmin(q[3 * i], h->d->width - q[3 * i])));
    for (int j = 0; j < i; j++)
      overlap =
          fmax(overlap, 2 * h->d->radius - hypot(q[3 * i] - q[3 * j], q[3 * i + 1] - q[3 * j + 1]));
  }
  for (int i = 0; i < s->count; i++) {
    pull = fmax(pull, -s->normal_impulse[i]);
    excess = fmax(excess, fabs(s->tangential_impulse[i]) - h->d->mu * s->normal_impulse[i]);
    depth = fmax(depth, -s->gap[i]);
  }
  if (r->step > 0)
    h->off = fmax(h->off, fabs(pull - c->pull) + fabs(excess - c->cone_excess) +
                              (c->penetration_contact >= 0 ? fabs(depth - c->penetration) : 0));
  if (r->step > 0) h->apart = fmax(h->apart, fabs(overlap - c->penetration));
  h->entered += c->penetration_contact < 0 && c->penetration > 0;
  if (pull > 0 && s->normal_impulse[c->pull_contact] != -pull) h->off = INFINITY;
  if (c->penetration_contact >= 0 && s->gap[c->penetration_contact] != -depth) h->off = INFINITY;
  h->pull = fmax(h->pull, pull);
  h->excess = fmax(h->excess, excess);
  h->depth = fmax(h->depth, depth);
  return 0;
}

static void test_lists(void **state)
{
  static double q0[3 * DISKS], v0[3 * DISKS];
  disks d;
  heap h = {.d = &d};
  nsdae_sim *sim;
  nsdae_stats stats;
  nsdae_sim_options options;
  (void)state;
  disks_create(&d, DISKS, 5);
  nsdae_system *system = disks_system(&d);
  disks_start(&d, q0, v0);
  nsdae_sim_options_default(&options);
  options.dt = 2e-3;
  options.contact_tol = 1e-3;
  options.iteration_tol = 1e-3;
  assert_int_equal(nsdae_sim_create(system, &options, &sim, NULL), NSDAE_OK);
  assert_int_equal(nsdae_sim_init(sim, 0, q0, v0), NSDAE_OK);
  nsdae_sim_observe(sim, judge_heap, &h);
  assert_true(nsdae_sim_run(sim, 0.6) >= 0);
  nsdae_sim_get_stats(sim, &stats);
  balance(sim);
  assert_near(h.off, 0, 0);
  assert_near(h.apart, 0, 1e-14); /* rounding of places below 1 m */
  assert_true(h.excess > 0 && h.depth > 0 && h.entered > 0);
  assert_near(stats.certificate.pull, h.pull, 0);
  assert_near(stats.certificate.cone_excess, h.excess, 0);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  disks_destroy(&d);
}

/* ---- As a value: the state that goes on has the certificate of its record, and the same ones
 * after it. */
static int keep_last(const nsdae_record *r, nsdae_error *error, void *user)
{
  (void)error;
  *(nsdae_certificate *)user = r->certificate;
  return 0;
}

static void test_state(void **state)
{
  static char bytes[1 << 16];
  (void)state;
  for (int method = 0; nsdae_method_name(method); method++) {
    random_system r;
    nsdae_sim_options options;
    nsdae_sim *sim[2] = {NULL, NULL};
    nsdae_certificate last = {0}, again = {0};
    nsdae_record now;
    size_t size;
    random_system_draw(&r, 17, RANDOM_PLAIN);
    nsdae_system *system = random_system_make(&r);
    nsdae_sim_options_default(&options);
    options.projection = NSDAE_PROJECTION_NONE; /* figures of the bare step */
    options.method = method;
    options.dt = step_length;
    options.start_tol = 1e-3;
    int status = nsdae_sim_create(system, &options, &sim[0], NULL);
    if (status == NSDAE_OK) {
      assert_int_equal(nsdae_sim_create(system, &options, &sim[1], NULL), NSDAE_OK);
      assert_int_equal(nsdae_sim_init(sim[0], 0, r.q0, r.v0), NSDAE_OK);
      assert_true(nsdae_sim_run(sim[0], 20 * step_length) >= 0);
      assert_int_equal(nsdae_sim_state_size(sim[0], &size), NSDAE_OK);
      assert_true(size <= sizeof bytes);
      assert_int_equal(nsdae_sim_get_state(sim[0], bytes, size), NSDAE_OK);
      assert_int_equal(nsdae_sim_set_state(sim[1], bytes, size), NSDAE_OK);
      nsdae_sim_get_record(sim[0], &now);
      last = now.certificate;
      nsdae_sim_get_record(sim[1], &now);
      assert_memory_equal(&last, &now.certificate, sizeof last);
      nsdae_sim_observe(sim[0], keep_last, &last);
      nsdae_sim_observe(sim[1], keep_last, &again);
      for (int i = 0; i < 2; i++) assert_true(nsdae_sim_run(sim[i], 40 * step_length) >= 0);
      assert_memory_equal(&last, &again, sizeof last);
    }
    for (int i = 0; i < 2; i++) nsdae_sim_destroy(&sim[i]);
    nsdae_system_destroy(&system);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_block), cmocka_unit_test(test_bounce),
                                     cmocka_unit_test(test_loss),  cmocka_unit_test(test_random),
                                     cmocka_unit_test(test_lists), cmocka_unit_test(test_state)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
