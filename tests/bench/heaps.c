/* Time of a step of a heap of spheres with friction, with the default of contact_tol, beside
 * MuJoCo's CG with elliptic cones, whose contacts are soft; then how the cost grows with the
 * contacts, and what a hundred thousand take. Medians of the processor's time of steps, once the
 * heap has settled. With an argument: heaps up to that many contacts. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <time.h>

#include <nsdae/nsdae.h>

#include "heaps_rival.h"
#include "ratio.h"

enum { MOST_STEPS = 200 };

/* Floor and walls. */
static void add_box(nsdae_bodies *world, const packing *p)
{
  double half = packing_box(p) / 2;
  nsdae_bodies_add_solid(world, NSDAE_GROUND, &(nsdae_solid){.shape = NSDAE_SHAPE_PLANE});
  for (int i = 0; i < 4; i++) {
    const double sign = i % 2 ? 1 : -1, turn = sqrt(0.5);
    nsdae_solid wall = {.shape = NSDAE_SHAPE_PLANE};
    wall.position[i / 2] = sign * half;
    wall.quaternion[0] = turn; /* a quarter turn brings z to -x, x, -y or y */
    wall.quaternion[i / 2 == 0 ? 2 : 1] = (i / 2 == 0 ? -sign : sign) * turn;
    nsdae_bodies_add_solid(world, NSDAE_GROUND, &wall);
  }
}

static nsdae_bodies *build(const packing *p)
{
  double J = 0.4 * p->mass * p->radius * p->radius;
  nsdae_bodies *world;
  if (nsdae_bodies_create(3, &world, NULL) < 0) return NULL;
  nsdae_bodies_set_gravity(world, (double[3]){0, 0, -p->gravity});
  nsdae_bodies_set_pair(world, 0, 1, p->mu, 0, 0);
  nsdae_bodies_set_pair(world, 1, 1, p->mu, 0, 0);
  add_box(world, p);
  for (int layer = 0; layer < p->layers; layer++) {
    int count = packing_count(p, layer + 1) - packing_count(p, layer);
    for (int i = 0; i < count; i++) {
      nsdae_rigid_body body = {.mass = p->mass, .inertia = {J, J, J}};
      packing_place(p, layer, i, body.position);
      int number = nsdae_bodies_add(world, &body);
      nsdae_bodies_add_solid(
          world, number,
          &(nsdae_solid){.shape = NSDAE_SHAPE_SPHERE, .radius = p->radius, .material = 1});
    }
  }
  return world;
}

static double now(void)
{
  struct timespec t;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* Steps one by one; worst: the residual of the worst; work: sweeps and factorisations a step. */
static double advance(nsdae_sim *sim, const packing *p, int *contacts, double *worst, double *work)
{
  double time[MOST_STEPS];
  nsdae_record record;
  nsdae_stats stats;
  long before = 0;
  for (int i = -p->settle; i < p->steps; i++) {
    if (i == 0) nsdae_sim_get_stats(sim, &stats), before = stats.lcp_pivots;
    double began = now();
    if (nsdae_sim_step(sim) < 0) {
      fprintf(stderr, "%s\n", nsdae_sim_error(sim)->text);
      return -1;
    }
    if (i >= 0) time[i] = now() - began;
  }
  nsdae_sim_get_record(sim, &record);
  nsdae_sim_get_stats(sim, &stats);
  *contacts = record.contacts.count;
  *worst = stats.worst_residual;
  *work = (double)(stats.lcp_pivots - before) / p->steps;
  return ratio_median(p->steps, time);
}

static double own_packing(const packing *p, int *contacts, double *worst, double *work)
{
  nsdae_bodies *world = build(p);
  nsdae_system *system = NULL;
  nsdae_sim_options options;
  nsdae_sim *sim = NULL;
  double time = -1;
  size_t n = 7 * (size_t)packing_count(p, p->layers);
  double *q0 = calloc(n, sizeof *q0), *v0 = calloc(n, sizeof *v0);
  nsdae_sim_options_default(&options);
  options.method = NSDAE_METHOD_MOREAU;
  options.dt = p->dt;
  if (q0 && v0 && world && nsdae_bodies_system(world, &system) >= 0 &&
      nsdae_bodies_get_start(world, q0, v0) >= 0 &&
      nsdae_sim_create(system, &options, &sim, NULL) >= 0 && nsdae_sim_init(sim, 0, q0, v0) >= 0)
    time = advance(sim, p, contacts, worst, work);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  nsdae_bodies_destroy(&world);
  free(q0);
  free(v0);
  return time;
}

/* Of log time over log contacts, by least squares. */
static double slope(int count, const double *contacts, const double *time)
{
  double x = 0, y = 0, xx = 0, xy = 0;
  for (int i = 0; i < count; i++) {
    double a = log(contacts[i]), b = log(time[i]);
    x += a, y += b, xx += a * a, xy += a * b;
  }
  return (count * xy - x * y) / (count * xx - x * x);
}

static int compare(const packing *p, int contacts, double own)
{
  char title[80];
  int theirs = 0;
  double peer = mujoco_packing(p, &theirs);
  if (peer < 0) return printf("  MuJoCo: not here\n") < 0;
  printf("  MuJoCo %.3f ms at %d contacts, ratio %.3f\n", 1e3 * peer, theirs, own / peer);
  snprintf(title, sizeof title, "step, heap of spheres, %d contacts", contacts);
  return ratio_add(title, own, "MuJoCo", peer);
}

int main(int argc, char **argv)
{
  /* about 5e2, 5e3, 5e4 and 1e5 contacts */
  const packing all[] = {{6, 5, 0.01, 4e-3, 0.5, 9.81, 2e-3, 40, 40},
                         {13, 9, 0.01, 4e-3, 0.5, 9.81, 2e-3, 60, 30},
                         {28, 17, 0.01, 4e-3, 0.5, 9.81, 2e-3, 60, 15},
                         {36, 20, 0.01, 4e-3, 0.5, 9.81, 2e-3, 40, 9}};
  const double most = argc > 1 ? atof(argv[1]) : INFINITY;
  double size[4], time[4];
  int count = 0;
  printf("Heaps of spheres, mu 0.5, time of a step; ratio: ours to theirs, medians.\n");
  for (; count < 4; count++) {
    const packing *p = &all[count];
    int contacts = 0;
    double worst = 0, work = 0;
    if (3.9 * packing_count(p, p->layers) > most) break;
    time[count] = own_packing(p, &contacts, &worst, &work);
    if (time[count] < 0) return 1;
    size[count] = contacts;
    printf("%d contacts, %d spheres: nsdae %.3f ms, %.0f sweeps, worst residual %.1e\n", contacts,
           packing_count(p, p->layers), 1e3 * time[count], work, worst);
    fflush(stdout);
    if (count < 3 && compare(p, contacts, time[count]) < 0) return 1;
  }
  if (count > 1) printf("cost grows with contacts to the power %.2f\n", slope(count, size, time));
  struct rusage usage;
  getrusage(RUSAGE_SELF, &usage);
  printf("memory, the peer's included: %ld MB\n", usage.ru_maxrss / 1024);
  return 0;
}
