/* MuJoCo's walkers: reduced coordinates, implicitfast (its damping is implicit), elliptic cones;
 * all else by default. Each call has its own data; the model is shared, as in its rollout. */
#include <pthread.h>
#include <stdarg.h>
#include <stdio.h>

#include <mujoco/mujoco.h>

#include "walkers_rival.h"

typedef struct writer {
  char xml[1 << 13];
  int used;
} writer;

static void put(writer *w, const char *format, ...)
{
  va_list values;
  va_start(values, format);
  w->used += vsnprintf(w->xml + w->used, sizeof w->xml - (size_t)w->used, format, values);
  va_end(values);
}

static void put_link(writer *w, const char *name, int leg, double radius, double low, double high)
{
  put(w,
      "<joint name='%s%d' type='hinge' axis='0 -1 0' pos='0 0 %g' range='%g %g'/>"
      "<geom type='capsule' size='%g 0.1' contype='0' conaffinity='0'/>",
      name, leg, walker_link / 2, low, high, radius);
}

static void put_leg(writer *w, int leg)
{
  put(w, "<body pos='%g %g %g'>", walker_hip[leg][0], walker_hip[leg][1], -walker_link / 2);
  put_link(w, "hip", leg, 0.03, -1.2, 1.2);
  put(w, "<body pos='0 0 %g'>", -walker_link);
  put_link(w, "knee", leg, 0.025, -0.1, 2);
  put(w, "<geom name='foot%d' type='sphere' size='0.025' pos='0 0 -0.1' mass='0'/></body></body>",
      leg);
}

static void put_motors(writer *w, int leg)
{
  for (int k = 0; k < 2; k++)
    put(w, "<position joint='%s%d' kp='%g' kv='%g' forcerange='-%g %g'/>", k ? "knee" : "hip", leg,
        walker_kp, walker_kd, walker_torque, walker_torque);
}

static mjModel *load(void)
{
  static writer w;
  static char text[1000];
  mjVFS files;
  w.used = 0;
  put(&w,
      "<mujoco><compiler angle='radian' autolimits='true'/><option integrator='implicitfast' "
      "cone='elliptic' gravity='0 0 -9.81'/><default><geom friction='%g 0 0' condim='3' "
      "density='1000'/></default><worldbody><geom name='floor' type='plane' size='0 0 1'/>"
      "<body name='trunk' pos='0 0 %g'><freejoint/>"
      "<geom type='box' size='0.25 0.1 0.05' contype='0' conaffinity='0'/>",
      walker_mu, walker_height);
  for (int leg = 0; leg < WALKER_LEGS; leg++) put_leg(&w, leg);
  put(&w, "</body></worldbody><actuator>");
  for (int leg = 0; leg < WALKER_LEGS; leg++) put_motors(&w, leg);
  put(&w, "</actuator></mujoco>");
  mj_defaultVFS(&files);
  mjModel *model = NULL;
  if (mj_addBufferVFS(&files, "walker.xml", w.xml, w.used) == 0)
    model = mj_loadXML("walker.xml", &files, text, sizeof text);
  if (!model) fprintf(stderr, "MuJoCo: %s\n", text);
  mj_deleteVFS(&files);
  return model;
}

static mjModel *shared;

static void load_once(void)
{
  shared = load();
}

static double depth(const mjModel *model, const mjData *data)
{
  double worst = 0;
  for (int leg = 0; leg < WALKER_LEGS; leg++) {
    char name[16];
    snprintf(name, sizeof name, "foot%d", leg);
    worst = fmax(worst, 0.025 - data->geom_xpos[3 * mj_name2id(model, mjOBJ_GEOM, name) + 2]);
  }
  return worst;
}

int mujoco_walkers(int first, int last, double dt, double end, double *height, double *deepest)
{
  static pthread_once_t once = PTHREAD_ONCE_INIT;
  pthread_once(&once, load_once);
  mjData *data = shared ? mj_makeData(shared) : NULL;
  if (!data) return -1;
  mjModel *model = mj_copyModel(NULL, shared);
  model->opt.timestep = dt;
  for (int i = first; i < last; i++) {
    mj_resetData(model, data);
    for (long n = lround(end / dt), k = 0; k < n; k++) {
      walker_steer(i, (double)k * dt, data->ctrl);
      mj_step(model, data);
      if (deepest && (double)k * dt > walker_landed) *deepest = fmax(*deepest, depth(model, data));
    }
    *height = data->qpos[2];
  }
  mj_deleteModel(model);
  mj_deleteData(data);
  return 0;
}
