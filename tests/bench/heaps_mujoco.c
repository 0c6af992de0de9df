/* MuJoCo's step with the fastest of its solvers here: conjugate gradients with elliptic cones, what
 * else it has by default. */
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include <mujoco/mujoco.h>

#include "heaps_rival.h"
#include "ratio.h"

enum { PER_SPHERE = 200, REST = 2000, MOST_STEPS = 200 };

static int write_walls(const packing *p, char *xml, int room)
{
  double half = packing_box(p) / 2;
  return snprintf(xml, (size_t)room,
                  "<mujoco><size memory='2G'/><option timestep='%g' gravity='0 0 %g' solver='CG' "
                  "cone='elliptic'/><default><geom friction='%g 0 0' condim='3'/></default>"
                  "<worldbody><geom type='plane' size='0 0 1'/>"
                  "<geom type='plane' size='0 0 1' pos='%.17g 0 0' zaxis='-1 0 0'/>"
                  "<geom type='plane' size='0 0 1' pos='%.17g 0 0' zaxis='1 0 0'/>"
                  "<geom type='plane' size='0 0 1' pos='0 %.17g 0' zaxis='0 -1 0'/>"
                  "<geom type='plane' size='0 0 1' pos='0 %.17g 0' zaxis='0 1 0'/>",
                  p->dt, -p->gravity, p->mu, half, -half, half, -half);
}

static int write_model(const packing *p, char *xml, int room)
{
  double at[3];
  int n = write_walls(p, xml, room);
  for (int layer = 0; layer < p->layers; layer++) {
    int count = packing_count(p, layer + 1) - packing_count(p, layer);
    for (int i = 0; i < count && n < room; i++) {
      packing_place(p, layer, i, at);
      n += snprintf(xml + n, (size_t)(room - n),
                    "<body pos='%.17g %.17g %.17g'><freejoint/>"
                    "<geom type='sphere' size='%g' mass='%g'/></body>",
                    at[0], at[1], at[2], p->radius, p->mass);
    }
  }
  if (n < room) n += snprintf(xml + n, (size_t)(room - n), "</worldbody></mujoco>");
  return n < room ? n : 0;
}

static mjModel *load(const packing *p)
{
  static char text[1000];
  int room = PER_SPHERE * packing_count(p, p->layers) + REST;
  char *xml = malloc((size_t)room);
  mjModel *model = NULL;
  mjVFS files;
  int n = xml ? write_model(p, xml, room) : 0;
  mj_defaultVFS(&files);
  if (n > 0 && mj_addBufferVFS(&files, "heap.xml", xml, n) == 0)
    model = mj_loadXML("heap.xml", &files, text, sizeof text);
  if (!model) fprintf(stderr, "MuJoCo: %s\n", text);
  mj_deleteVFS(&files);
  free(xml);
  return model;
}

static double timed_step(const mjModel *model, mjData *data)
{
  struct timespec began, ended;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &began);
  mj_step(model, data);
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &ended);
  return (double)(ended.tv_sec - began.tv_sec) + 1e-9 * (double)(ended.tv_nsec - began.tv_nsec);
}

double mujoco_packing(const packing *p, int *contacts)
{
  double time[MOST_STEPS];
  mjModel *model = load(p);
  mjData *data = model ? mj_makeData(model) : NULL;
  if (!data || p->steps > MOST_STEPS) return -1;
  for (int i = 0; i < p->settle; i++) mj_step(model, data);
  for (int i = 0; i < p->steps; i++) time[i] = timed_step(model, data);
  *contacts = data->ncon;
  mj_deleteData(data);
  mj_deleteModel(model);
  return ratio_median(p->steps, time);
}
