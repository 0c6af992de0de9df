/* Problems of the IFToMM library of computational benchmark problems
 * (www.iftomm-multibody.org/benchmark): A01, a pendulum in Cartesian coordinates, against its
 * exact solution; A04, Bricard's mechanism, whose constraints are redundant, against the geometry
 * of that linkage and LAPACK's least-norm solution. */
#include "check.h"

#include <gsl/gsl_sf_ellint.h>
#include <gsl/gsl_sf_elljac.h>
#include <lapacke.h>

#include "bricard.h"
#include "long_pendulum.h"

enum { N = BRICARD_NQ, M = BRICARD_M };

static nsdae_sim_options options_of(int method, double dt)
{
  nsdae_sim_options options;
  nsdae_sim_options_default(&options);
  options.method = method;
  options.dt = dt;
  options.redundant = NSDAE_REDUNDANT_LEAST_NORM;
  return options;
}

/* Runs to t_end and releases the system. */
static nsdae_stats integrate(nsdae_system *system, const nsdae_sim_options *options,
                             const double *q0, const double *v0, double t_end,
                             nsdae_observer_fn observe, void *user)
{
  nsdae_sim *sim;
  nsdae_stats stats;
  assert_int_equal(nsdae_sim_create(system, options, &sim, NULL), NSDAE_OK);
  assert_int_equal(nsdae_sim_init(sim, 0, q0, v0), NSDAE_OK);
  assert_int_equal(nsdae_sim_observe(sim, observe, user), NSDAE_OK);
  int status = nsdae_sim_run(sim, t_end);
  if (status < 0) print_message("%s\n", nsdae_sim_error(sim)->text);
  assert_int_equal(status, NSDAE_OK);
  nsdae_sim_get_stats(sim, &stats);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  return stats;
}

/* sin(theta / 2) = k sn(K - w t), k = sin(pi / 4), w^2 = g / L (Landau and Lifshitz, Mechanics,
 * section 11); x = L sin theta, y = -L cos theta = -L (1 - 2 k^2 sn^2). */
static double exact_height(const long_pendulum *p, double t)
{
  double k = sqrt(0.5), K = gsl_sf_ellint_Kcomp(k, GSL_PREC_DOUBLE), w = sqrt(p->g / p->L), sn, cn,
         dn;
  gsl_sf_elljac_e(K - w * t, k * k, &sn, &cn, &dn);
  return -p->L * (1 - 2 * k * k * sn * sn);
}

static void test_pendulum_closed_form(void **state)
{
  (void)state;
  long_pendulum p;
  long_pendulum_default(&p);
  double period = 4 * sqrt(p.L / p.g) * gsl_sf_ellint_Kcomp(sqrt(0.5), GSL_PREC_DOUBLE);
  assert_near(period, 2.3678419475762373, 1e-15);
  /* twelve digits are given */
  assert_near(exact_height(&p, 10), -0.961419205099, 0.5e-12);
  assert_near(exact_height(&p, period), 0, 1e-14);
  assert_near(exact_height(&p, period / 4), -p.L, 1e-14);
}

typedef struct swing {
  const long_pendulum *p;
  double y, worst_height, worst_tension, worst_energy;
} swing;

/* The tension of the rod is 3 m g cos theta = -3 m g y / L; the multiplier is its mean. */
static int follow_pendulum(const nsdae_record *r, nsdae_error *error, void *user)
{
  swing *s = user;
  (void)error;
  double energy = r->kinetic + r->potential, height = fabs(r->q[1] - exact_height(s->p, r->time));
  double tension = -3 * s->p->m * s->p->g * (r->q[1] + s->y) / (2 * s->p->L);
  s->worst_height = fmax(s->worst_height, height);
  s->worst_energy = fmax(s->worst_energy, fabs(energy));
  if (r->step > 0) s->worst_tension = fmax(s->worst_tension, fabs(r->multiplier[0] - tension));
  s->y = r->q[1];
  return 0;
}

/* Second order over ten seconds, in the height, the energy, the force and the drift. */
static void test_pendulum(void **state)
{
  (void)state;
  long_pendulum p;
  swing s[2];
  double drift[2];
  long_pendulum_default(&p);
  for (int i = 0; i < 2; i++) {
    double q0[2], v0[2], dt = 1e-3 / (1 << 2 * i);
    nsdae_sim_options options = options_of(NSDAE_METHOD_IMPLICIT, dt);
    long_pendulum_start(&p, q0, v0);
    s[i] = (swing){.p = &p};
    drift[i] = integrate(long_pendulum_system(&p), &options, q0, v0, 10, follow_pendulum, &s[i])
                   .worst_drift;
    print_message("dt %-8g height %.2e m, force %.2e N, energy %.2e J, drift %.2e m\n", dt,
                  s[i].worst_height, s[i].worst_tension, s[i].worst_energy, drift[i]);
  }
  assert_near(log2(s[0].worst_height / s[1].worst_height) / 2, 2, 0.1);
  assert_near(log2(s[0].worst_tension / s[1].worst_tension) / 2, 2, 0.1);
  assert_near(log2(s[0].worst_energy / s[1].worst_energy) / 2, 2, 0.1);
  assert_near(log2(drift[0] / drift[1]) / 2, 2, 0.1);
}

static void test_derivatives(void **state)
{
  (void)state;
  long_pendulum p;
  bricard b;
  double q[N], v[N];
  long_pendulum_default(&p);
  bricard_default(&b);
  bricard_start(&b, q, v);
  for (int i = 0; i < N; i++) {
    q[i] += 0.1 * sin(i * i);
    v[i] = cos(3.0 * i * i);
  }
  nsdae_system *systems[] = {long_pendulum_system(&p), bricard_system(&b)};
  for (int i = 0; i < 2; i++) {
    assert_non_null(systems[i]);
    assert_int_equal(nsdae_system_check(systems[i], 0, q, v, 1e-6, NULL), NSDAE_OK);
    nsdae_system_destroy(&systems[i]);
  }
}

/* What a run of Bricard's mechanism shows. */
typedef struct linkage {
  const bricard *p;
  double dt, energy, q[N], v[N]; /* energy at the start; the record before */
  double worst_energy, worst_symmetry, worst_closure;
  double smallest, second; /* singular values of Phi_q: worst of all records */
  double worst_balance, worst_norm, worst_kinetic, fastest, force;
} linkage;

/* All turns of odd joints are equal, and all of even ones, phi and theta, with
 * cos phi + cos theta + cos phi cos theta = 0  (Y. Chen, Z. You, T. Tarnai, Threefold-symmetric
 * Bricard linkages for deployable structures, Int. J. Solids Struct. 42, 2005, for a twist of 90
 * deg). */
static void follow_geometry(linkage *l, const double *q)
{
  double c[6];
  for (int i = 0; i < 6; i++) c[i] = bricard_cosine(l->p, q, i);
  for (int i = 0; i < 4; i++) l->worst_symmetry = fmax(l->worst_symmetry, fabs(c[i] - c[i + 2]));
  l->worst_closure = fmax(l->worst_closure, fabs(c[0] + c[1] + c[0] * c[1]));
}

static void follow_rank(linkage *l, const double *q)
{
  double J[N * M], sigma[N], unused[N];
  bricard_jacobian(l->p, q, J);
  assert_int_equal(
      LAPACKE_dgesvd(LAPACK_COL_MAJOR, 'N', 'N', M, N, J, M, sigma, NULL, 1, NULL, 1, unused), 0);
  l->smallest = fmax(l->smallest, sigma[N - 1]);
  l->second = fmin(l->second, sigma[N - 2]);
}

/* y += scale A x or, transposed, scale A^T x, of [24 x 24]. */
static void multiply(const double *A, int transposed, double scale, const double *x, double *y)
{
  for (int i = 0; i < N; i++)
    for (int j = 0; j < N; j++) y[i] += scale * (transposed ? A[i * N + j] : A[j * N + i]) * x[j];
}

/* M (v_1 - v_0) / dt + (J_0 + J_1)^T lambda / 2 - F: the scheme's own balance of forces. */
static void follow_balance(linkage *l, const nsdae_record *r)
{
  double A[N * N], rest[N], change[N];
  bricard_force(l->p, rest);
  for (int i = 0; i < N; i++) {
    rest[i] = -rest[i];
    change[i] = (r->v[i] - l->v[i]) / l->dt;
    l->force = fmax(l->force, fabs(r->multiplier[i]));
  }
  bricard_mass(l->p, A);
  multiply(A, 0, 1, change, rest);
  bricard_jacobian(l->p, l->q, A);
  multiply(A, 1, 0.5, r->multiplier, rest);
  bricard_jacobian(l->p, r->q, A);
  multiply(A, 1, 0.5, r->multiplier, rest);
  for (int i = 0; i < N; i++) l->worst_balance = fmax(l->worst_balance, fabs(rest[i]));
}

/* Among all lambda with the same Phi_q^T lambda at the end of the step it is LAPACK's. */
static void follow_norm(linkage *l, const nsdae_record *r)
{
  double J[N * M], A[N * M], x[N] = {0};
  int pivots[N] = {0}, rank;
  bricard_jacobian(l->p, r->q, J);
  for (int i = 0; i < N; i++)
    for (int j = 0; j < M; j++) A[j * N + i] = J[i * M + j];
  multiply(J, 1, 1, r->multiplier, x);
  assert_int_equal(LAPACKE_dgelsy(LAPACK_COL_MAJOR, N, M, 1, A, N, x, N, pivots, 1e-4, &rank), 0);
  assert_int_equal(rank, BRICARD_RANK);
  for (int i = 0; i < M; i++) l->worst_norm = fmax(l->worst_norm, fabs(x[i] - r->multiplier[i]));
}

static void cross(const double *x, const double *y, double *z)
{
  for (int i = 0; i < 3; i++)
    z[i] = x[(i + 1) % 3] * y[(i + 2) % 3] - x[(i + 2) % 3] * y[(i + 1) % 3];
}

/* Energy of a free rod k = 1 .. 3 as a rigid body: m |v_c|^2 / 2 + w . I w / 2, with the angular
 * velocity w = sum e_i x e_i' / 2 of its triad, I = m a^2 / 6 along it and m (L^2 + a^2) / 12
 * across. */
static double rigid_energy(const bricard *p, const double *q, const double *v, int k)
{
  const double *P = q + 3 * (k - 1), *u = q + 12 + 3 * (k - 1);
  const double *Pv = v + 3 * (k - 1), *uv = v + 12 + 3 * (k - 1);
  double e[3], ev[3], w[3] = {0}, z[3], along = 0, square = 0, centre = 0;
  for (int i = 0; i < 3; i++) {
    e[i] = (P[i + 3] - P[i]) / p->L;
    ev[i] = (Pv[i + 3] - Pv[i]) / p->L;
    centre += (Pv[i] + Pv[i + 3]) * (Pv[i] + Pv[i + 3]) / 4;
  }
  const double *triad[] = {e, u, u + 3}, *rates[] = {ev, uv, uv + 3};
  for (int j = 0; j < 3; j++) {
    cross(triad[j], rates[j], z);
    for (int i = 0; i < 3; i++) w[i] += z[i] / 2;
  }
  for (int i = 0; i < 3; i++) {
    along += w[i] * e[i];
    square += w[i] * w[i];
  }
  return p->m * centre / 2 + p->m * p->a * p->a / 12 * along * along +
         p->m * (p->L * p->L + p->a * p->a) / 24 * (square - along * along);
}

/* All five rods: the ground's ends are put around q and v. */
static double kinetic(const bricard *p, const double *q, const double *v)
{
  double whole[2][36] = {{0}}, sum = 0;
  const double *part[] = {q, v};
  for (int i = 0; i < 2; i++) {
    memcpy(whole[i] + 3, part[i], 12 * sizeof *q);
    memcpy(whole[i] + 21, part[i] + 12, 12 * sizeof *q);
  }
  whole[0][17] = p->L;                 /* P_5 */
  whole[0][18 + 1] = whole[0][33] = 1; /* u_0, u_5 */
  for (int k = 0; k < 5; k++) {
    double rod[2][24];
    for (int i = 0; i < 2; i++) {
      memcpy(rod[i], whole[i] + 3 * k, 6 * sizeof *q);
      memcpy(rod[i] + 12, whole[i] + 18 + 3 * k, 6 * sizeof *q);
    }
    sum += rigid_energy(p, rod[0], rod[1], 1);
  }
  return sum;
}

static int follow_linkage(const nsdae_record *r, nsdae_error *error, void *user)
{
  linkage *l = user;
  double energy = r->kinetic + r->potential;
  (void)error;
  if (r->step == 0) l->energy = energy;
  l->worst_energy = fmax(l->worst_energy, fabs(energy - l->energy));
  l->fastest = fmax(l->fastest, r->kinetic);
  follow_geometry(l, r->q);
  follow_rank(l, r->q);
  l->worst_kinetic = fmax(l->worst_kinetic, fabs(r->kinetic - kinetic(l->p, r->q, r->v)));
  if (r->step > 0) {
    follow_balance(l, r);
    follow_norm(l, r);
  }
  memcpy(l->q, r->q, sizeof l->q);
  memcpy(l->v, r->v, sizeof l->v);
  return 0;
}

static linkage run_bricard(const bricard *p, nsdae_sim_options *options, nsdae_stats *stats)
{
  double q0[N], v0[N];
  linkage l = {.p = p, .dt = options->dt, .second = INFINITY};
  bricard copy = *p;
  bricard_start(p, q0, v0);
  *stats = integrate(bricard_system(&copy), options, q0, v0, 1, follow_linkage, &l);
  assert_int_equal(stats->rank, BRICARD_RANK);
  return l;
}

static void assert_order(double coarse, double fine, double order)
{
  assert_near(log2(coarse / fine) / 2, order, 0.1);
}

/* implicit for one second: order 2 in the energy, the drift and the geometry. Its steps end where
 * Phi_q is singular to rounding, though the constraints have drifted. */
static void test_bricard(void **state)
{
  (void)state;
  bricard p;
  linkage l[2];
  nsdae_stats stats[2];
  bricard_default(&p);
  for (int i = 0; i < 2; i++) {
    nsdae_sim_options options = options_of(NSDAE_METHOD_IMPLICIT, 2e-3 / (1 << 2 * i));
    l[i] = run_bricard(&p, &options, &stats[i]);
    double drift = stats[i].worst_drift;
    print_message("dt %-6g energy %.2e of %.2f J, drift %.2e, symmetry %.2e, closure %.2e\n"
                  "  singular values %.1e, %.3f; balance %.1e N, least norm %.1e of %.1f N\n",
                  options.dt, l[i].worst_energy, l[i].fastest, drift, l[i].worst_symmetry,
                  l[i].worst_closure, l[i].smallest, l[i].second, l[i].worst_balance,
                  l[i].worst_norm, l[i].force);
    assert_at_most(l[i].smallest, 1e-13);
    assert_true(l[i].second > 0.1);
    /* velocities of order one, divided by dt; iteration_tol (1e-12) times a force */
    assert_at_most(l[i].worst_balance, 10 * 2.3e-16 / options.dt + 1e-12 * l[i].force);
    /* rounding of a force times the condition of the rank-23 part, below 10 */
    assert_at_most(l[i].worst_norm, 10 * N * 2.3e-16 * l[i].force);
    /* a rod is rigid but for the drift */
    assert_at_most(l[i].worst_kinetic, 4 * drift * l[i].fastest);
  }
  assert_order(l[0].worst_energy, l[1].worst_energy, 2);
  assert_order(stats[0].worst_drift, stats[1].worst_drift, 2);
  assert_order(l[0].worst_symmetry, l[1].worst_symmetry, 2);
  assert_order(l[0].worst_closure, l[1].worst_closure, 2);
}

/* Of a run with moreau, whose drift makes Phi_q regular: the energy alone. */
static int follow_energy(const nsdae_record *r, nsdae_error *error, void *user)
{
  linkage *l = user;
  (void)error;
  if (r->step == 0) l->energy = r->kinetic + r->potential;
  l->worst_energy = fmax(l->worst_energy, fabs(r->kinetic + r->potential - l->energy));
  return 0;
}

/* moreau is of first order; its drift of up to 2e-3 has to stay below rank_tol, or the redundant
 * constraint counts as one of its own and the mechanism locks. */
static void test_bricard_moreau(void **state)
{
  (void)state;
  bricard p;
  linkage l[2];
  bricard_default(&p);
  for (int i = 0; i < 2; i++) {
    double q0[N], v0[N];
    nsdae_sim_options options = options_of(NSDAE_METHOD_MOREAU, 2e-3 / (1 << 2 * i));
    options.rank_tol = 1e-2;
    bricard_start(&p, q0, v0);
    l[i] = (linkage){.p = &p};
    nsdae_stats stats = integrate(bricard_system(&p), &options, q0, v0, 1, follow_energy, &l[i]);
    print_message("moreau dt %-6g energy %.2e J, drift %.2e\n", options.dt, l[i].worst_energy,
                  stats.worst_drift);
    assert_int_equal(stats.rank, BRICARD_RANK);
  }
  assert_order(l[0].worst_energy, l[1].worst_energy, 1);
}

/* Of a run with event: the part of the reactions along the null vector of Phi_q^T in mid-step. */
typedef struct self_stress {
  const bricard *p;
  double before[N]; /* q at the start of the step */
  double worst, force;
} self_stress;

static int follow_stress(const nsdae_record *r, nsdae_error *error, void *user)
{
  self_stress *s = user;
  double J[N * M], U[M * M], sigma[N], unused[N], middle[N], along = 0;
  (void)error;
  for (int i = 0; i < N; i++) middle[i] = (s->before[i] + r->q[i]) / 2;
  memcpy(s->before, r->q, sizeof s->before);
  if (r->step == 0) return 0;
  bricard_jacobian(s->p, middle, J);
  assert_int_equal(
      LAPACKE_dgesvd(LAPACK_COL_MAJOR, 'A', 'N', M, N, J, M, sigma, U, M, NULL, 1, unused), 0);
  for (int i = 0; i < M; i++) {
    along += U[(N - 1) * M + i] * r->multiplier[i];
    s->force = fmax(s->force, fabs(r->multiplier[i]));
  }
  s->worst = fmax(s->worst, fabs(along));
  return 0;
}

static self_stress run_stress(bricard *p, double dt)
{
  nsdae_sim *sim;
  double q0[N], v0[N];
  nsdae_sim_options options = options_of(NSDAE_METHOD_EVENT, dt);
  self_stress s = {.p = p};
  options.rtol = 1e-11;
  options.atol = 1e-12;
  bricard_start(p, q0, v0);
  nsdae_system *system = bricard_system(p);
  if (nsdae_sim_create(system, &options, &sim, NULL) == NSDAE_E_UNSUPPORTED) {
    nsdae_system_destroy(&system);
    untested("no SUNDIALS");
  }
  nsdae_sim_destroy(&sim);
  integrate(system, &options, q0, v0, 1, follow_stress, &s);
  print_message("event: dt %g, %.2e of %.1f N along the null vector\n", dt, s.worst, s.force);
  return s;
}

/* What event reports is the mean of reactions that are of least norm at every time. In mid-step
 * none of it lies along the null vector but for what both turn within the step: second order. */
static void test_bricard_event(void **state)
{
  (void)state;
  bricard p;
  bricard_default(&p);
  self_stress coarse = run_stress(&p, 8e-3), fine = run_stress(&p, 2e-3);
  assert_order(coarse.worst, fine.worst, 2);
}

/* Where redundant constraints were not asked for, the rank is an error that says so. */
static void test_bricard_refused(void **state)
{
  (void)state;
  bricard p;
  nsdae_sim *sim;
  double q0[N], v0[N];
  bricard_default(&p);
  bricard_start(&p, q0, v0);
  nsdae_system *system = bricard_system(&p);
  assert_int_equal(nsdae_sim_create(system, NULL, &sim, NULL), NSDAE_OK);
  int status = nsdae_sim_init(sim, 0, q0, v0);
  if (status == NSDAE_OK) status = nsdae_sim_run(sim, 1);
  assert_int_equal(status, NSDAE_E_RANK);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_pendulum_closed_form), cmocka_unit_test(test_pendulum),
      cmocka_unit_test(test_derivatives),          cmocka_unit_test(test_bricard),
      cmocka_unit_test(test_bricard_moreau),       cmocka_unit_test(test_bricard_event),
      cmocka_unit_test(test_bricard_refused),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
