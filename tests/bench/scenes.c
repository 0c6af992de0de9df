/* Time of a step of many bodies beside MuJoCo: walls, lattices that fall, a poured heap, chains and
 * ragdolls. Both codes run the whole motion, in turn, some steps each; ours is moreau with the
 * default of contact_tol. Means of the CPU time of a step, the worst, and the penetration at the
 * end, MuJoCo's by our geometry too. With an argument: cases whose names have that word. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include <nsdae/nsdae.h>

#include "random.h"
#include "ratio.h"
#include "scenes_rival.h"

enum { IN_TURN = 25, MOST_STEPS = 1000 };

static const double pi = 3.14159265358979323846;

/* ---- the mechanisms */

static void *grown(void *at, int count, size_t *room, size_t size)
{
  if ((size_t)count < *room) return at;
  *room = *room ? 2 * *room : 64;
  at = realloc(at, *room * size);
  if (!at) abort();
  return at;
}

/* A body of density 1000; a quaternion of four zeros: no rotation. */
static int add_body(mechanism *m, nsdae_solid solid, const double *position, const double *turn)
{
  nsdae_scene *s = &m->scene;
  nsdae_rigid_body b = {.quaternion = {1}};
  size_t room = m->body_room;
  s->body = grown(s->body, s->bodies, &room, sizeof *s->body);
  s->solid = grown(s->solid, s->bodies, &m->body_room, sizeof *s->solid);
  solid.material = 1;
  nsdae_solid_inertia(&solid, 1000, &b.mass, b.inertia, NULL);
  memcpy(b.position, position, sizeof b.position);
  if (turn) memcpy(b.quaternion, turn, sizeof b.quaternion);
  s->body[s->bodies] = b;
  s->solid[s->bodies] = solid;
  return s->bodies++;
}

static void add_joint(mechanism *m, nsdae_joint joint)
{
  m->joint = grown(m->joint, m->joints, &m->joint_room, sizeof *m->joint);
  m->joint[m->joints++] = joint;
}

static void random_turn(uint64_t *seed, double q[4])
{
  double u = random_uniform(seed), a = 2 * pi * random_uniform(seed);
  double b = 2 * pi * random_uniform(seed), s = sqrt(1 - u), c = sqrt(u);
  q[0] = c * cos(b), q[1] = s * sin(a), q[2] = s * cos(a), q[3] = c * sin(b);
}

/* x := R(q) x, by x + 2 w (u x x) + 2 u x (u x x). */
static void turn(const double q[4], double x[3])
{
  double y[3], z[3];
  for (int i = 0; i < 3; i++) {
    int j = (i + 1) % 3, k = (i + 2) % 3;
    y[i] = 2 * (q[1 + j] * x[k] - q[1 + k] * x[j]);
  }
  for (int i = 0; i < 3; i++) {
    int j = (i + 1) % 3, k = (i + 2) % 3;
    z[i] = q[1 + j] * y[k] - q[1 + k] * y[j];
  }
  for (int i = 0; i < 3; i++) x[i] += q[0] * y[i] + z[i];
}

static void product(const double a[4], const double b[4], double c[4])
{
  c[0] = a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3];
  for (int i = 0; i < 3; i++) {
    int j = (i + 1) % 3, k = (i + 2) % 3;
    c[1 + i] = a[0] * b[1 + i] + b[0] * a[1 + i] + a[1 + j] * b[1 + k] - a[1 + k] * b[1 + j];
  }
}

static mechanism empty(double wall, double mu, int steps)
{
  return (mechanism){.scene = {.wall = {-wall, wall}, .mu = mu, .g = 9.81, .dt = 2e-3},
                     .steps = steps};
}

/* Bricks in running bond. whole: half bricks end every second course; else bricks overhang there,
 * with the centre of mass of the topmost beyond its support. */
static mechanism wall(int length, int courses, int whole)
{
  mechanism m = empty(INFINITY, 0.6, 250);
  for (int k = 0; k < courses; k++) {
    int shifted = k % 2, halves = whole && shifted;
    for (int i = 0; i < length + halves; i++) {
      double left = 0.2 * i + (whole ? -0.1 : 0.1) * shifted, right = left + 0.2;
      if (halves) left = fmax(left, 0), right = fmin(right, 0.2 * length);
      const nsdae_solid brick = {.shape = NSDAE_SHAPE_BOX,
                                 .length = {right - left - 0.001, 0.1, 0.08}};
      add_body(&m, brick, (double[]){(left + right) / 2, 0, 0.08 * (k + 0.5)}, NULL);
    }
  }
  return m;
}

/* Bodies of random sizes and rotations in cells; kind: 0 spheres, 1 capsules, 2 boxes, 3 all of
 * these, 4 capsules, boxes and cylinders. */
static mechanism lattice(int side, int layers, int kind, int steps)
{
  const double widest = 0.05, cell = kind == 0 ? 1.9 * widest : 2.2 * widest;
  mechanism m = empty(side * cell / 2, 0.5, steps);
  uint64_t seed = 1;
  for (int i = 0; i < side * side * layers; i++) {
    const int at[3] = {i % side, i / side % side, i / side / side};
    int what = kind < 3 ? kind : random_below(&seed, 3) + kind - 3;
    double r = widest * random_between(&seed, 0.8, 1), q[4], x[3];
    nsdae_solid s = {.shape = NSDAE_SHAPE_SPHERE, .radius = 0.8 * r};
    if (what == 1)
      s = (nsdae_solid){.shape = NSDAE_SHAPE_CAPSULE, .radius = 0.6 * r, .length = {0, 0, 0.8 * r}};
    if (what == 2)
      s = (nsdae_solid){.shape = NSDAE_SHAPE_BOX, .length = {1.3 * r, 1.1 * r, 0.95 * r}};
    if (what == 3)
      s = (nsdae_solid){
          .shape = NSDAE_SHAPE_CYLINDER, .radius = 0.6 * r, .length = {0, 0, 1.2 * r}};
    for (int j = 0; j < 3; j++)
      x[j] = cell * (at[j] + 0.5) - (j < 2 ? side * cell / 2 : 0) +
             (j < 2 ? random_between(&seed, -0.001, 0.001) : 0);
    random_turn(&seed, q);
    add_body(&m, s, x, q);
  }
  return m;
}

/* Capsules with spherical joints, nearly upright, on the floor. */
static mechanism chain(int links)
{
  const double length = 0.1, radius = 0.02, tilt = 0.05;
  const double q[4] = {cos(tilt / 2), 0, sin(tilt / 2), 0}, way[3] = {sin(tilt), 0, cos(tilt)};
  const nsdae_solid link = {
      .shape = NSDAE_SHAPE_CAPSULE, .radius = radius, .length = {0, 0, length - 2 * radius}};
  mechanism m = empty(INFINITY, 0.5, 500);
  for (int i = 0; i < links; i++) {
    double x[3], joint[3];
    for (int j = 0; j < 3; j++) {
      joint[j] = way[j] * i * length + (j == 2 ? radius : 0);
      x[j] = joint[j] + way[j] * length / 2;
    }
    add_body(&m, link, x, q);
    if (i > 0)
      add_joint(&m, (nsdae_joint){.kind = NSDAE_JOINT_SPHERICAL,
                                  .body = {i - 1, i},
                                  .point = {joint[0], joint[1], joint[2]}});
  }
  return m;
}

/* A ragdoll of ten capsules about 0.65 m high: centre, direction (0: x, 2: z), radius, length
 * between the centres of its ends; parent and joint, a hinge about y or x at elbows and knees. */
static const struct {
  double x, z, radius, length, joint_x, joint_z;
  int along, parent, hinge;
} part[] = {
    {0, 0, 0.1, 0.25, 0, 0, 2, -1, 0},
    {0, 0.33, 0.08, 0.04, 0, 0.24, 2, 0, 0},
    {0.27, 0.12, 0.04, 0.2, 0.14, 0.12, 0, 0, 0},
    {-0.27, 0.12, 0.04, 0.2, -0.14, 0.12, 0, 0, 0},
    {0.54, 0.12, 0.035, 0.2, 0.405, 0.12, 0, 2, 1},
    {-0.54, 0.12, 0.035, 0.2, -0.405, 0.12, 0, 3, 1},
    {0.09, -0.37, 0.055, 0.25, 0.09, -0.2, 2, 0, 0},
    {-0.09, -0.37, 0.055, 0.25, -0.09, -0.2, 2, 0, 0},
    {0.09, -0.72, 0.045, 0.25, 0.09, -0.545, 2, 6, 1},
    {-0.09, -0.72, 0.045, 0.25, -0.09, -0.545, 2, 7, 1},
};
enum { PARTS = sizeof part / sizeof *part };

static void add_ragdoll(mechanism *m, const double at[3], const double q[4])
{
  const double scale = 0.5, h = sqrt(0.5), along_x[4] = {h, 0, h, 0}, along_z[4] = {1, 0, 0, 0};
  int first = m->scene.bodies;
  for (int i = 0; i < PARTS; i++) {
    const nsdae_solid s = {.shape = NSDAE_SHAPE_CAPSULE,
                           .radius = scale * part[i].radius,
                           .length = {0, 0, scale * part[i].length}};
    double x[3] = {scale * part[i].x, 0, scale * part[i].z}, turned[4];
    nsdae_joint joint = {.kind = part[i].hinge ? NSDAE_JOINT_REVOLUTE : NSDAE_JOINT_SPHERICAL,
                         .body = {first + part[i].parent, first + i},
                         .point = {scale * part[i].joint_x, 0, scale * part[i].joint_z}};
    joint.axis[part[i].along == 0] = 1;
    turn(q, x), turn(q, joint.point), turn(q, joint.axis);
    for (int j = 0; j < 3; j++) x[j] += at[j], joint.point[j] += at[j];
    product(q, part[i].along == 0 ? along_x : along_z, turned);
    add_body(m, s, x, turned);
    if (part[i].parent >= 0) add_joint(m, joint);
  }
}

static mechanism ragdolls(int count, int side)
{
  const double cell = 0.8;
  mechanism m = empty(side * cell / 2, 0.5, 500);
  uint64_t seed = 3;
  for (int i = 0; i < count; i++) {
    const int at[3] = {i % side, i / side % side, i / side / side};
    double q[4], x[3];
    for (int j = 0; j < 3; j++) x[j] = cell * (at[j] + 0.5) - (j < 2 ? side * cell / 2 : 0);
    random_turn(&seed, q);
    add_ragdoll(&m, x, q);
  }
  return m;
}

static void release(mechanism *m)
{
  nsdae_scene_release(&m->scene);
  free(m->joint);
}

/* ---- ours */

typedef struct own {
  nsdae_bodies *world;
  nsdae_system *system;
  nsdae_sim *sim;
  double *q, *v; /* at the start */
} own;

static void own_end(own *o)
{
  nsdae_sim_destroy(&o->sim);
  nsdae_system_destroy(&o->system);
  nsdae_bodies_destroy(&o->world);
  free(o->q);
  free(o->v);
}

static int own_begin(own *o, const mechanism *m)
{
  nsdae_sim_options options;
  nsdae_sim_options_default(&options);
  options.method = NSDAE_METHOD_MOREAU;
  options.dt = m->scene.dt;
  o->q = calloc((size_t)m->scene.bodies, 7 * sizeof *o->q);
  o->v = calloc((size_t)m->scene.bodies, 6 * sizeof *o->v);
  if (!o->q || !o->v || nsdae_bodies_create(3, &o->world, NULL) < 0) return -1;
  nsdae_bodies_add_scene(o->world, &m->scene);
  for (int i = 0; i < m->joints; i++) nsdae_bodies_add_joint(o->world, &m->joint[i]);
  if (nsdae_bodies_system(o->world, &o->system) < 0 ||
      nsdae_bodies_get_start(o->world, o->q, o->v) < 0 ||
      nsdae_sim_create(o->system, &options, &o->sim, NULL) < 0)
    return -1;
  return nsdae_sim_init(o->sim, 0, o->q, o->v);
}

static int own_advance(own *o, int count, double *time)
{
  struct timespec began, ended;
  for (int i = 0; i < count; i++) {
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &began);
    int status = nsdae_sim_step(o->sim);
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &ended);
    if (status < 0) return status;
    time[i] =
        (double)(ended.tv_sec - began.tv_sec) + 1e-9 * (double)(ended.tv_nsec - began.tv_nsec);
  }
  return 0;
}

/* ---- beside each other */

static double mean(int count, const double *time, double *worst)
{
  double sum = 0;
  *worst = 0;
  for (int i = 0; i < count; i++) sum += time[i], *worst = fmax(*worst, time[i]);
  return sum / count;
}

/* Penetration and drift at coordinates of the peer, by our geometry: a start there. */
static void print_peer(const char *solver, const mechanism *m, void *peer, const double *time,
                       double ours)
{
  own at = {.system = NULL};
  nsdae_record r;
  double worst, average = mean(m->steps, time, &worst);
  printf("  MuJoCo %-6s mean %7.3f ms, worst %6.1f ms", solver, 1e3 * average, 1e3 * worst);
  if (own_begin(&at, m) >= 0) {
    double fastest = mujoco_state(peer, at.q);
    if (nsdae_sim_init(at.sim, 0, at.q, at.v) >= 0 && nsdae_sim_get_record(at.sim, &r) >= 0)
      printf(", penetration %.1e m, fastest %.1e", r.penetration, fastest);
  }
  printf("; ratio %.2f\n", ours / average);
  own_end(&at);
}

static int print_own(const own *o, const mechanism *m, const double *time, double *average)
{
  double worst, fastest = 0;
  nsdae_record r;
  nsdae_stats stats;
  *average = mean(m->steps, time, &worst);
  nsdae_sim_get_record(o->sim, &r);
  nsdae_sim_get_stats(o->sim, &stats);
  for (int i = 0; i < 6 * m->scene.bodies; i++) fastest = fmax(fastest, fabs(r.v[i]));
  printf("  nsdae         mean %7.3f ms, worst %6.1f ms, penetration %.1e m, fastest %.1e, %d "
         "contacts, ",
         1e3 * *average, 1e3 * worst, r.penetration, fastest, r.contacts.count);
  return printf("drift %.0e m, %ld steps above their tolerance\n", stats.worst_drift,
                stats.inexact_steps);
}

/* solvers: 1 Newton, 2 CG, on which spheres are faster. */
static int compare(const char *name, const mechanism *m, int solvers)
{
  static const char *const solver[] = {"Newton", "CG"};
  static double time[3][MOST_STEPS];
  void *peer[2] = {NULL, NULL};
  own o = {.system = NULL};
  int status = own_begin(&o, m), fails[2] = {0, 0};
  double ours = NAN, worst;
  for (int k = 0; k < 2; k++)
    if (solvers >> k & 1) peer[k] = mujoco_begin(m, solver[k]);
  printf("%s, %d bodies, %d steps\n", name, m->scene.bodies, m->steps);
  for (int i = 0; i < m->steps && status >= 0; i += IN_TURN) {
    status = own_advance(&o, IN_TURN, time[0] + i);
    for (int k = 0; k < 2; k++)
      if (peer[k]) fails[k] |= mujoco_advance(peer[k], IN_TURN, time[1 + k] + i);
  }
  if (status >= 0)
    print_own(&o, m, time[0], &ours);
  else
    printf("  nsdae: %s\n", o.sim ? nsdae_sim_error(o.sim)->text : "no simulation");
  for (int k = 0; k < 2; k++) {
    char title[80];
    if (peer[k] && status >= 0) print_peer(solver[k], m, peer[k], time[1 + k], ours);
    if (fails[k]) printf("  MuJoCo %s became unstable and began anew\n", solver[k]);
    snprintf(title, sizeof title, "step, %s", name);
    if (peer[k] && !fails[k] && status >= 0)
      ratio_add(title, ours, k ? "MuJoCo CG" : "MuJoCo Newton",
                mean(m->steps, time[1 + k], &worst));
    mujoco_end(peer[k]);
  }
  if (!peer[0] && !peer[1]) printf("  MuJoCo: not here\n");
  fflush(stdout);
  own_end(&o);
  return status;
}

int main(int argc, char **argv)
{
  struct {
    const char *name;
    mechanism made;
    int solvers;
  } all[] = {
      {"wall of 205 boxes at rest", wall(20, 10, 1), 1},
      {"wall of 200 boxes, its ends fall", wall(20, 10, 0), 1},
      {"wall of 320 boxes, its ends fall", wall(40, 8, 0), 1},
      {"falling lattice of 125 boxes", lattice(5, 5, 2, 500), 1},
      {"falling lattice of 600 boxes", lattice(10, 6, 2, 300), 1},
      {"falling lattice of 125 spheres", lattice(5, 5, 0, 500), 3},
      {"falling lattice of 125 spheres, capsules, boxes", lattice(5, 5, 3, 500), 1},
      {"bin of 300 capsules, boxes, cylinders", lattice(10, 3, 4, 300), 1},
      {"poured heap of 384 spheres", lattice(8, 6, 0, 400), 2},
      {"chain of 50 capsules", chain(50), 1},
      {"one ragdoll", ragdolls(1, 1), 1},
      {"heap of 20 ragdolls", ragdolls(20, 3), 1},
  };
  int failed = 0;
  printf("Many bodies, dt 2 ms, moreau; ratio: ours to theirs, of the means.\n");
  for (size_t i = 0; i < sizeof all / sizeof *all; i++) {
    if (argc < 2 || strstr(all[i].name, argv[1]))
      failed += compare(all[i].name, &all[i].made, all[i].solvers) < 0;
    release(&all[i].made);
  }
  if (failed) printf("%d of ours stopped\n", failed);
  return 0;
}
