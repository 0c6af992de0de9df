/* Many runs of one walker in threads, control set each step, beside MuJoCo: steps and simulated
 * seconds per second of wall time, the depth of feet and the drift of joints. moreau with its
 * default tolerance. Arguments: walkers, threads, seconds. */
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include <nsdae/nsdae.h>

#include "ratio.h"
#include "walkers_rival.h"

enum { BODIES = 1 + 2 * WALKER_LEGS, MOST_THREADS = 64, RUNS = 3 };

/* ---- the walker */

static int add(nsdae_bodies *b, nsdae_solid solid, const double position[3])
{
  nsdae_rigid_body body = {.position = {position[0], position[1], position[2]}};
  solid.exclude = -1;
  nsdae_solid_inertia(&solid, 1000, &body.mass, body.inertia, NULL);
  int number = nsdae_bodies_add(b, &body);
  nsdae_bodies_add_solid(b, number, &solid);
  return number;
}

static int add_link(nsdae_bodies *b, int above, int leg, int knee)
{
  const double x = walker_hip[leg][0], y = walker_hip[leg][1],
               z = walker_height - knee * walker_link;
  const nsdae_solid link = {
      .shape = NSDAE_SHAPE_CAPSULE, .radius = knee ? 0.025 : 0.03, .length = {0, 0, 0.2}};
  int body = add(b, link, (double[]){x, y, z - walker_link / 2});
  int joint = nsdae_bodies_add_joint(b, &(nsdae_joint){.kind = NSDAE_JOINT_REVOLUTE,
                                                       .body = {above, body},
                                                       .point = {x, y, z},
                                                       .axis = {0, -1, 0}});
  nsdae_bodies_add_limit(
      b, &(nsdae_limit){.joint = joint, .low = knee ? -0.1 : -1.2, .high = knee ? 2 : 1.2});
  nsdae_bodies_add_motor(b, &(nsdae_motor){.joint = joint,
                                           .kind = NSDAE_MOTOR_POSITION,
                                           .limit = walker_torque,
                                           .kp = walker_kp,
                                           .kd = walker_kd});
  return body;
}

static nsdae_bodies *walker(void)
{
  nsdae_bodies *b;
  if (nsdae_bodies_create(3, &b, NULL) < 0) return NULL;
  nsdae_bodies_set_gravity(b, (double[]){0, 0, -9.81});
  int floor = nsdae_bodies_add_solid(b, NSDAE_GROUND, &(nsdae_solid){.shape = NSDAE_SHAPE_PLANE});
  int trunk = add(b, (nsdae_solid){.shape = NSDAE_SHAPE_BOX, .length = {0.5, 0.2, 0.1}},
                  (double[]){0, 0, walker_height});
  for (int leg = 0; leg < WALKER_LEGS; leg++) {
    int thigh = add_link(b, trunk, leg, 0), shin = add_link(b, thigh, leg, 1);
    int foot = nsdae_bodies_add_solid(
        b, shin,
        &(nsdae_solid){.shape = NSDAE_SHAPE_SPHERE, .radius = 0.025, .position = {0, 0, -0.1}});
    nsdae_bodies_add_contact(b, floor, foot, walker_mu, 0, 0);
  }
  return b;
}

/* ---- runs in threads: one system, a simulation in each thread */

typedef struct job {
  const nsdae_system *system;
  const double *q, *v; /* at the start */
  int peer, first, last;
  double dt, end, height, deepest, drift; /* figures of the last walker and the worst of all */
  int measure, status;
} job;

static int run_one(nsdae_sim *sim, int i, job *j)
{
  double target[WALKER_MOTORS];
  nsdae_record r;
  nsdae_stats stats;
  if (nsdae_sim_init(sim, 0, j->q, j->v) < 0) return -1;
  for (long n = lround(j->end / j->dt), k = 0; k < n; k++) {
    walker_steer(i, (double)k * j->dt, target);
    for (int m = 0; m < WALKER_MOTORS; m++) nsdae_sim_set_control(sim, m, target[m]);
    if (nsdae_sim_step(sim) < 0) return fprintf(stderr, "%s\n", nsdae_sim_error(sim)->text), -1;
    if (j->measure && (double)k * j->dt > walker_landed && nsdae_sim_get_record(sim, &r) >= 0)
      j->deepest = fmax(j->deepest, r.penetration);
  }
  nsdae_sim_get_record(sim, &r);
  nsdae_sim_get_stats(sim, &stats);
  j->height = r.q[2];
  j->drift = fmax(j->drift, stats.worst_drift);
  return 0;
}

static int run_own(job *j)
{
  nsdae_sim_options options;
  nsdae_sim *sim = NULL;
  nsdae_sim_options_default(&options);
  options.method = NSDAE_METHOD_MOREAU;
  options.dt = j->dt;
  int status = nsdae_sim_create(j->system, &options, &sim, NULL);
  for (int i = j->first; i < j->last && status >= 0; i++) status = run_one(sim, i, j);
  nsdae_sim_destroy(&sim);
  return status;
}

static void *work(void *data)
{
  job *j = data;
  j->status = j->peer ? mujoco_walkers(j->first, j->last, j->dt, j->end, &j->height,
                                       j->measure ? &j->deepest : NULL)
                      : run_own(j);
  return NULL;
}

/* Wall time [s] of all walkers in threads; NAN if one failed. */
static double run_all(job *total, int threads)
{
  pthread_t thread[MOST_THREADS];
  job part[MOST_THREADS];
  struct timespec began, ended;
  int status = 0, count = total->last;
  clock_gettime(CLOCK_MONOTONIC, &began);
  for (int i = 0; i < threads; i++) {
    part[i] = *total;
    part[i].first = i * count / threads, part[i].last = (i + 1) * count / threads;
    if (pthread_create(&thread[i], NULL, work, &part[i]) != 0) return NAN;
  }
  for (int i = 0; i < threads; i++) {
    pthread_join(thread[i], NULL);
    status |= part[i].status < 0;
    total->height = part[i].height;
    total->deepest = fmax(total->deepest, part[i].deepest);
    total->drift = fmax(total->drift, part[i].drift);
  }
  clock_gettime(CLOCK_MONOTONIC, &ended);
  double taken =
      (double)(ended.tv_sec - began.tv_sec) + 1e-9 * (double)(ended.tv_nsec - began.tv_nsec);
  return status ? NAN : taken;
}

/* Throughput by wall time; the ratio by CPU time, which another load of the machine does not
 * change. */
static void compare(job base, double dt, int threads)
{
  double wall[2][RUNS], cpu[2][RUNS], median[2];
  char title[64];
  base.dt = dt;
  job j[2] = {base, base};
  j[1].peer = 1;
  for (int k = 0; k < 2; k++) j[k].measure = 1, run_all(&j[k], threads), j[k].measure = 0;
  for (int i = 0; i < RUNS; i++)
    for (int k = 0; k < 2; k++) {
      double began = ratio_cpu();
      wall[k][i] = run_all(&j[k], threads);
      cpu[k][i] = isnan(wall[k][i]) ? NAN : ratio_cpu() - began;
    }
  for (int k = 0; k < 2; k++) {
    const double simulated = base.last * base.end / ratio_median(RUNS, wall[k]);
    median[k] = ratio_median(RUNS, cpu[k]) * dt / (base.last * base.end);
    printf("  %-6s %5.1f us a step, %7.0f steps/s, %4.0f simulated s/s; trunk %.3f m high, feet "
           "%.1e m "
           "deep, joints %.1e m open\n",
           k ? "MuJoCo" : "nsdae", 1e6 * median[k], simulated / dt, simulated, j[k].height,
           j[k].deepest, j[k].drift);
  }
  printf("  ratio of CPU times %.2f\n", median[0] / median[1]);
  snprintf(title, sizeof title, "walkers in threads, dt %g ms", 1e3 * dt);
  ratio_add(title, median[0], "MuJoCo", median[1]);
}

int main(int argc, char **argv)
{
  const int count = argc > 1 ? atoi(argv[1]) : 100, threads = argc > 2 ? atoi(argv[2]) : 2;
  const double end = argc > 3 ? atof(argv[3]) : 0.5, dt[] = {1e-3, 2e-3};
  double q[7 * BODIES], v[6 * BODIES];
  nsdae_system *system = NULL;
  nsdae_bodies *bodies = walker();
  int failed = threads < 1 || threads > MOST_THREADS || !bodies ||
               nsdae_bodies_system(bodies, &system) < 0 || nsdae_bodies_get_start(bodies, q, v) < 0;
  const job base = {.system = system, .q = q, .v = v, .last = count, .end = end};
  for (int i = 0; i < 2 && !failed; i++) {
    printf("%d walkers of %d bodies and %d motors, %g s each, %d threads, dt %g ms\n", count,
           BODIES, WALKER_MOTORS, end, threads, 1e3 * dt[i]);
    compare(base, dt[i], threads);
  }
  nsdae_system_destroy(&system);
  nsdae_bodies_destroy(&bodies);
  return failed;
}
