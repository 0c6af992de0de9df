/* A tippe top: a ball of radius R whose centre of mass is alpha R from its centre, spun on a floor
 * with friction. Whatever force acts at the place of contact, a from the centre of mass,
 *
 *   lambda = -a . L = R (L_z - alpha L_3)                 (J. H. Jellett, A treatise on the theory
 * of friction, 1872): lambda' = -a . (a x F) - a' . L = 0,  as a' = alpha R omega x e_3 is at right
 *   angles to e_3, omega and so to L of a body that is symmetric about e_3
 *
 * is the same for ever. Energy is lost in sliding alone, and is never below its least value at
 * this lambda and any tilt, with c its cosine,
 *
 *   E(c) = lambda^2 / (2 R^2 D(c)) + m g R (1 - alpha c),  D = I_1 (1 - c^2) + I_3 (c - alpha)^2
 *
 * (S. Rauch-Wojciechowski, M. Skoldstam, T. Glad, Regular and Chaotic Dynamics 10, 2005). As soon
 * as it rolls, energy stays, and so does (E. J. Routh, Dynamics of a system of rigid bodies, 1905)
 *
 *   omega_3^2 (I_1 I_3 + m R^2 I_1 (1 - c^2) + m R^2 I_3 (alpha - c)^2) */
#include "check.h"

#include <nsdae/nsdae.h>

typedef struct top {
  double m, R, alpha, I1, I3, g, mu;
  double lambda, worst_lambda, energy, worst_gain, least_tilt, most_tilt;
  double rolls_from; /* the time from which it is to roll */
  double routh, worst_routh, rolling, worst_rolling;
} top;

static top usual(void)
{
  top p = {
      .m = 0.02, .R = 0.02, .alpha = 0.3, .g = 9.81, .mu = 0.3, .least_tilt = 1, .most_tilt = -1};
  p.I3 = 2. / 5 * p.m * p.R * p.R;
  p.I1 = 131. / 350 * p.m * p.R * p.R;
  return p;
}

/* The least energy that it can have with its lambda. */
static double least_energy(const top *p)
{
  double least = INFINITY;
  for (int i = 0; i <= 20000; i++) {
    double c = 1 - 1e-4 * i, D = p->I1 * (1 - c * c) + p->I3 * pow(c - p->alpha, 2);
    double E =
        p->lambda * p->lambda / (2 * p->R * p->R * D) + p->m * p->g * p->R * (1 - p->alpha * c);
    least = fmin(least, E);
  }
  return least;
}

/* The third rows of the rotation and of L: e_i . z of the own axes. */
static void upward(const double *q, double *z)
{
  const double *p = q + 3;
  z[0] = 2 * (p[1] * p[3] - p[0] * p[2]);
  z[1] = 2 * (p[2] * p[3] + p[0] * p[1]);
  z[2] = 1 - 2 * (p[1] * p[1] + p[2] * p[2]);
}

static double routh(const top *p, double omega3, double c)
{
  double m = p->m * p->R * p->R;
  return omega3 * omega3 *
         (p->I1 * p->I3 + m * p->I1 * (1 - c * c) + m * p->I3 * pow(p->alpha - c, 2));
}

/* Rolling: energy and Routh's constant against those at its first record. */
static void follow_rolling(top *p, const nsdae_record *r, double energy, double c)
{
  double now = routh(p, r->v[5], c);
  if (r->time < p->rolls_from) return;
  if (p->routh == 0) {
    p->routh = now;
    p->rolling = energy;
  }
  assert_int_equal(r->mode[0], NSDAE_MODE_STICK);
  p->worst_routh = fmax(p->worst_routh, fabs(now / p->routh - 1));
  p->worst_rolling = fmax(p->worst_rolling, fabs(energy / p->rolling - 1));
}

static int follow(const nsdae_record *r, nsdae_error *error, void *user)
{
  top *p = user;
  double z[3], energy = r->kinetic + r->potential;
  const double *w = r->v + 3;
  (void)error;
  upward(r->q, z);
  double L_z = p->I1 * (w[0] * z[0] + w[1] * z[1]) + p->I3 * w[2] * z[2];
  double lambda = p->R * (L_z - p->alpha * p->I3 * w[2]);
  if (r->step == 0) {
    p->lambda = lambda;
    p->energy = energy;
  }
  p->worst_lambda = fmax(p->worst_lambda, fabs(lambda / p->lambda - 1));
  p->worst_gain = fmax(p->worst_gain, energy / p->energy - 1);
  p->least_tilt = fmin(p->least_tilt, z[2]);
  p->most_tilt = fmax(p->most_tilt, z[2]);
  p->energy = energy;
  if (p->rolls_from > 0) follow_rolling(p, r, energy, z[2]);
  return 0;
}

/* Spun at 150 rad/s about its axis, which is tilted. */
static void spin_top(top *p, const nsdae_sim_options *options, double t_end)
{
  nsdae_bodies *b;
  nsdae_system *system;
  nsdae_sim *sim;
  double q[7], v[6], tilt = 0.5;
  const double down[3] = {0, 0, -p->g};
  assert_int_equal(nsdae_bodies_create(3, &b, NULL), NSDAE_OK);
  nsdae_bodies_set_gravity(b, down);
  nsdae_bodies_add(b, &(nsdae_rigid_body){.mass = p->m,
                                          .inertia = {p->I1, p->I1, p->I3},
                                          .position = {0, 0, p->R * (1 - p->alpha * cos(tilt))},
                                          .quaternion = {cos(tilt / 2), sin(tilt / 2), 0, 0},
                                          .spin = {0, 0, 150}});
  int ball = nsdae_bodies_add_solid(b, 0,
                                    &(nsdae_solid){.shape = NSDAE_SHAPE_SPHERE,
                                                   .radius = p->R,
                                                   .position = {0, 0, p->alpha * p->R}});
  int floor = nsdae_bodies_add_solid(b, NSDAE_GROUND, &(nsdae_solid){.shape = NSDAE_SHAPE_PLANE});
  nsdae_bodies_add_contact(b, floor, ball, p->mu, 0, 0);
  assert_true(nsdae_bodies_system(b, &system) >= 0);
  nsdae_bodies_get_start(b, q, v);
  assert_int_equal(nsdae_sim_create(system, options, &sim, NULL), NSDAE_OK);
  assert_int_equal(nsdae_sim_init(sim, 0, q, v), NSDAE_OK);
  nsdae_sim_observe(sim, follow, p);
  int status = nsdae_sim_run(sim, t_end);
  if (status < 0) print_error("%s\n", nsdae_sim_error(sim)->text);
  assert_true(status >= 0);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  nsdae_bodies_destroy(&b);
  print_message("lambda changes by %.1e, energy gains %.1e, rolling changes it by %.1e and Routh's "
                "constant by %.1e; cosine %.3f .. %.3f\n",
                p->worst_lambda, p->worst_gain, p->worst_rolling, p->worst_routh, p->least_tilt,
                p->most_tilt);
}

static nsdae_sim_options options_of(int method, double dt)
{
  nsdae_sim_options options;
  nsdae_sim_options_default(&options);
  options.method = method;
  options.dt = dt;
  options.rtol = 1e-10;
  options.atol = 1e-12;
  return options;
}

/* It slides at first, then rolls and nods. */
static void test_event(void **state)
{
  nsdae_sim_options options = options_of(NSDAE_METHOD_EVENT, 1e-2);
  top p = usual();
  (void)state;
  p.rolls_from = 1;
  spin_top(&p, &options, 2);
  assert_at_most(p.worst_lambda, 1e-8);
  assert_at_most(p.worst_gain, 1e-10);
  assert_true(p.energy > least_energy(&p));
  assert_at_most(p.worst_routh, 1e-8);
  assert_at_most(p.worst_rolling, 1e-8);
  assert_true(p.most_tilt - p.least_tilt > 0.01);
}

/* Almost without friction it slides all the time. */
static void test_sliding(void **state)
{
  nsdae_sim_options options = options_of(NSDAE_METHOD_EVENT, 1e-2);
  top p = usual();
  (void)state;
  p.mu = 0.02;
  spin_top(&p, &options, 0.5);
  assert_at_most(p.worst_lambda, 1e-7);
  assert_at_most(p.worst_gain, 1e-10);
}

/* Moreau's scheme is of first order in lambda. */
static void test_moreau(void **state)
{
  double worst[2];
  (void)state;
  for (int i = 0; i < 2; i++) {
    nsdae_sim_options options = options_of(NSDAE_METHOD_MOREAU, 2e-5 / (1 << 2 * i));
    options.projection = NSDAE_PROJECTION_NONE; /* the scheme alone */
    top p = usual();
    spin_top(&p, &options, 0.1);
    worst[i] = p.worst_lambda;
  }
  assert_near(log2(worst[0] / worst[1]) / 2, 1, 0.15);
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_event), cmocka_unit_test(test_sliding),
                                     cmocka_unit_test(test_moreau)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
