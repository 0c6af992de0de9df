/* Many bodies from a CSV file (docs/guide/scenes.md). The summary has the penetration and the CPU
 * time of a step, which includes the output of its record. */
#include "scene_file.h"

#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

#include "scene.h"

static int read_scene(void *base, double *dt, nsdae_error *error)
{
  scene_file *p = base;
  nsdae_scene_release(&p->scene);
  if (!p->file[0]) {
    snprintf(error->text, sizeof error->text,
             "no FILE given: nsdae-scene FILE.csv; --help lists the options");
    return error->status = NSDAE_E_ARGUMENT;
  }
  int status = nsdae_scene_read(p->file, &p->scene, error);
  if (status == NSDAE_OK && dt) *dt = p->scene.dt;
  return status;
}

/* "KIND:BODY,KIND:BODY": each has the name KIND_BODY in the file. */
static int add_sensors(scene_file *p, nsdae_error *error)
{
  static const struct {
    const char *name;
    int kind;
  } kinds[] = {{"contact_force", NSDAE_SENSOR_CONTACT_FORCE},
               {"position", NSDAE_SENSOR_POSITION},
               {"orientation", NSDAE_SENSOR_ORIENTATION},
               {"velocity", NSDAE_SENSOR_VELOCITY},
               {"angular_velocity", NSDAE_SENSOR_ANGULAR_VELOCITY},
               {"acceleration", NSDAE_SENSOR_ACCELERATION},
               {"kinetic_energy", NSDAE_SENSOR_KINETIC_ENERGY}};
  enum { KINDS = sizeof kinds / sizeof *kinds };
  char kind[32], name[64];
  for (const char *at = p->sensors; *at;) {
    int body = -1, used = 0, i = 0;
    sscanf(at, "%31[a-z_]:%d%n", kind, &body, &used);
    while (used > 0 && i < KINDS && strcmp(kinds[i].name, kind) != 0) i++;
    if (used == 0 || i == KINDS || (at[used] && at[used] != ',') || body < 0 ||
        body >= p->scene.bodies) {
      snprintf(error->text, sizeof error->text,
               "sensors: '%.40s' is not KIND:BODY with a body of 0 .. %d and a kind of "
               "contact_force, position, orientation, velocity, angular_velocity, acceleration, "
               "kinetic_energy",
               at, p->scene.bodies - 1);
      return error->status = NSDAE_E_ARGUMENT;
    }
    snprintf(name, sizeof name, "%s_%d", kind, body);
    nsdae_sensor s = {.name = name, .kind = kinds[i].kind, .body = body};
    memcpy(s.point, p->scene.body[body].position, sizeof s.point);
    nsdae_bodies_add_sensor(p->world, &s);
    at += used + (at[used] == ',');
  }
  return NSDAE_OK;
}

static int build(void *base, nsdae_system **system, nsdae_error *error)
{
  scene_file *p = base;
  nsdae_bodies_destroy(&p->world);
  int status = nsdae_bodies_create(3, &p->world, error);
  if (status < 0) return status;
  nsdae_bodies_add_scene(p->world, &p->scene);
  status = add_sensors(p, error);
  if (status < 0) return status;
  status = nsdae_bodies_system(p->world, system);
  if (status < 0) *error = *nsdae_bodies_error(p->world);
  p->deepest_ever = p->cpu = p->cpu_worst = 0;
  p->steps = -1;
  return status < 0 ? status : NSDAE_OK; /* a likely mistake is none here */
}

static void start(const void *base, double *q0, double *v0)
{
  const scene_file *p = base;
  nsdae_bodies_get_start(p->world, q0, v0);
}

static double cpu_now(void)
{
  struct timespec now;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* The floor is the only body below: its impulse is the weight times the time plus the change of
 * momentum along z. */
static void balance(scene_file *p, const nsdae_record *r)
{
  double momentum = 0, weight = 0;
  for (int i = 0; i < p->scene.bodies; i++) {
    momentum += p->scene.body[i].mass * r->v[6 * i + 2];
    weight += p->scene.body[i].mass * p->scene.g;
  }
  if (p->steps < 0) {
    p->impulse = p->given = 0;
    p->momentum = momentum;
    return;
  }
  p->impulse += world_ground_impulse(r);
  p->given += weight * r->duration + momentum - p->momentum;
  p->momentum = momentum;
}

static int figure(const void *base, driver_figure *f)
{
  const scene_file *p = base;
  *f = (driver_figure){"impulse of the floor", "N s", p->impulse, p->given};
  return !isfinite(p->scene.wall[0]); /* that of walls is not along z */
}

/* The first record, of the start or of a continued run, starts the clock. */
static void follow(void *base, const nsdae_record *r)
{
  scene_file *p = base;
  double now = cpu_now(), step = now - p->clock;
  p->clock = now;
  p->deepest = r->penetration;
  p->deepest_ever = fmax(p->deepest_ever, r->penetration);
  p->raised = r->projection_energy;
  balance(p, r);
  if (p->steps++ < 0) return;
  p->cpu += step;
  if (step <= p->cpu_worst) return;
  p->cpu_worst = step;
  p->worst = r->step;
}

static void conclude(const void *base)
{
  const scene_file *p = base;
  printf("%d bodies: penetration %.2e m at the end, %.2e m at most\n", p->scene.bodies, p->deepest,
         p->deepest_ever);
  printf("the projection added %.3e J\n", p->raised);
  if (p->steps > 0)
    printf("CPU time of a step: mean %.3g ms, worst %.3g ms (step %ld)\n",
           1e3 * p->cpu / (double)p->steps, 1e3 * p->cpu_worst, p->worst);
}

static const nsdae_param entries[] = {
    {"file", "", "the scene: a CSV file", NSDAE_PARAM_TEXT, offsetof(scene_file, file), 0, 0, 0, 0,
     NULL},
    {"sensors", "", "KIND:BODY,... in the file, such as contact_force:3", NSDAE_PARAM_TEXT,
     offsetof(scene_file, sensors), 0, 0, 0, 0, NULL}};

static const nsdae_params table = {entries, 2};
static scene_file parameters;

const driver_model scene_file_model = {.name = "scene",
                                       .summary = "bodies from a CSV file",
                                       .parameters = &table,
                                       .base = &parameters,
                                       .t_end = 1,
                                       .dt = 2e-3,
                                       .method = NSDAE_METHOD_MOREAU,
                                       .contact_work = 1e5, /* few steps need it, none more */
                                       .projection = NSDAE_PROJECTION_AUTO,
                                       .read = read_scene,
                                       .build = build,
                                       .start = start,
                                       .follow = follow,
                                       .figure = figure,
                                       .conclude = conclude};
