/* MuJoCo on the same bodies: elliptic cones, Newton or conjugate gradients, all else by default.
 * Joints make trees of its bodies, the form in which it is fastest. */
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include <mujoco/mujoco.h>

#include "scenes_rival.h"

enum { PER_BODY = 800, REST = 4000 };

typedef struct run {
  mjModel *model;
  mjData *data;
  int bodies;
} run;

/* ---- the model as XML */

typedef struct writer {
  const mechanism *m;
  char *xml;
  int used, room;
} writer;

static void put(writer *w, const char *format, ...)
{
  va_list values;
  if (w->used >= w->room) return;
  va_start(values, format);
  w->used += vsnprintf(w->xml + w->used, (size_t)(w->room - w->used), format, values);
  va_end(values);
}

static void put_plane(writer *w, int axis, double sign, double at)
{
  double x[3] = {0, 0, 0}, z[3] = {0, 0, 0};
  if (!isfinite(at)) return;
  x[axis] = at;
  z[axis] = sign;
  put(w, "<geom type='plane' size='0 0 1' pos='%.17g %.17g %.17g' zaxis='%g %g %g'/>", x[0], x[1],
      x[2], z[0], z[1], z[2]);
}

static void put_geom(writer *w, const nsdae_solid *s)
{
  if (s->shape == NSDAE_SHAPE_SPHERE) put(w, "<geom type='sphere' size='%.17g'/>", s->radius);
  if (s->shape == NSDAE_SHAPE_CYLINDER)
    put(w, "<geom type='cylinder' size='%.17g %.17g'/>", s->radius, s->length[2] / 2);
  if (s->shape == NSDAE_SHAPE_CAPSULE)
    put(w, "<geom type='capsule' size='%.17g %.17g'/>", s->radius, s->length[2] / 2);
  if (s->shape == NSDAE_SHAPE_BOX)
    put(w, "<geom type='box' size='%.17g %.17g %.17g'/>", s->length[0] / 2, s->length[1] / 2,
        s->length[2] / 2);
}

/* Position and rotation of a body in the frame of its parent (NULL: space). */
static void put_pose(writer *w, const nsdae_rigid_body *b, const nsdae_rigid_body *parent)
{
  mjtNum x[3], back[4], q[4];
  mju_copy(x, b->position, 3);
  mju_copy(q, b->quaternion, 4);
  if (parent) {
    mju_negQuat(back, parent->quaternion);
    mju_subFrom(x, parent->position, 3);
    mju_rotVecQuat(x, x, back);
    mju_mulQuat(q, back, b->quaternion);
  }
  put(w, " pos='%.17g %.17g %.17g' quat='%.17g %.17g %.17g %.17g'>", x[0], x[1], x[2], q[0], q[1],
      q[2], q[3]);
}

static void put_joint(writer *w, const nsdae_rigid_body *b, const nsdae_joint *j)
{
  mjtNum back[4], x[3], axis[3];
  mju_negQuat(back, b->quaternion);
  mju_sub(x, j->point, b->position, 3);
  mju_rotVecQuat(x, x, back);
  mju_rotVecQuat(axis, j->axis, back);
  put(w, "<joint pos='%.17g %.17g %.17g'", x[0], x[1], x[2]);
  if (j->kind == NSDAE_JOINT_SPHERICAL)
    put(w, " type='ball'/>");
  else
    put(w, " type='hinge' axis='%.17g %.17g %.17g'/>", axis[0], axis[1], axis[2]);
}

/* A body inside its parent, with all that hangs on it. */
static void put_body(writer *w, int i, const nsdae_joint *up)
{
  const nsdae_rigid_body *b = &w->m->scene.body[i];
  put(w, "<body name='b%d'", i);
  put_pose(w, b, up ? &w->m->scene.body[up->body[0]] : NULL);
  if (up)
    put_joint(w, b, up);
  else
    put(w, "<freejoint/>");
  put(w, "<inertial pos='0 0 0' mass='%.17g' diaginertia='%.17g %.17g %.17g'/>", b->mass,
      b->inertia[0], b->inertia[1], b->inertia[2]);
  put_geom(w, &w->m->scene.solid[i]);
  for (int k = 0; k < w->m->joints; k++)
    if (w->m->joint[k].body[0] == i) put_body(w, w->m->joint[k].body[1], &w->m->joint[k]);
  put(w, "</body>");
}

static void put_model(writer *w, const char *solver)
{
  const nsdae_scene *s = &w->m->scene;
  char *child = calloc((size_t)s->bodies, 1);
  put(w,
      "<mujoco><size memory='2G'/><compiler balanceinertia='true'/><option timestep='%g' "
      "gravity='0 0 %g' solver='%s' cone='elliptic'/><default><geom friction='%g 0 0' condim='3'/>"
      "</default><worldbody>",
      s->dt, -s->g, solver, s->mu);
  put_plane(w, 2, 1, s->floor);
  for (int i = 0; i < 4; i++) put_plane(w, i / 2, i % 2 ? -1 : 1, s->wall[i % 2]);
  for (int k = 0; child && k < w->m->joints; k++) child[w->m->joint[k].body[1]] = 1;
  for (int i = 0; child && i < s->bodies; i++)
    if (!child[i]) put_body(w, i, NULL);
  put(w, "</worldbody></mujoco>");
  free(child);
}

static mjModel *load(const mechanism *m, const char *solver)
{
  static char text[1000];
  writer w = {.m = m, .room = PER_BODY * m->scene.bodies + REST};
  mjModel *model = NULL;
  mjVFS files;
  w.xml = malloc((size_t)w.room);
  if (w.xml) put_model(&w, solver);
  mj_defaultVFS(&files);
  if (w.xml && w.used < w.room && mj_addBufferVFS(&files, "scene.xml", w.xml, w.used) == 0)
    model = mj_loadXML("scene.xml", &files, text, sizeof text);
  if (!model) fprintf(stderr, "MuJoCo: %s\n", text);
  mj_deleteVFS(&files);
  free(w.xml);
  return model;
}

/* ---- a run */

/* mujoco_advance returns what a warning is about; by default it goes to a file. */
static void ignore(const char *warning)
{
  (void)warning;
}

void *mujoco_begin(const mechanism *m, const char *solver)
{
  run *r = calloc(1, sizeof *r);
  if (!r) return NULL;
  mju_user_warning = ignore;
  r->bodies = m->scene.bodies;
  r->model = load(m, solver);
  r->data = r->model ? mj_makeData(r->model) : NULL;
  if (r->data) return r;
  mujoco_end(r);
  return NULL;
}

int mujoco_advance(void *peer, int count, double *time)
{
  run *r = peer;
  struct timespec began, ended;
  for (int i = 0; i < count; i++) {
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &began);
    mj_step(r->model, r->data);
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &ended);
    time[i] =
        (double)(ended.tv_sec - began.tv_sec) + 1e-9 * (double)(ended.tv_nsec - began.tv_nsec);
  }
  return r->data->warning[mjWARN_BADQPOS].number + r->data->warning[mjWARN_BADQVEL].number +
                     r->data->warning[mjWARN_BADQACC].number >
                 0
             ? -1
             : 0;
}

double mujoco_state(const void *peer, double *q)
{
  const run *r = peer;
  double fastest = 0;
  mj_kinematics(r->model, r->data);
  for (int i = 0; i < r->bodies; i++) {
    char name[16];
    snprintf(name, sizeof name, "b%d", i);
    int id = mj_name2id(r->model, mjOBJ_BODY, name);
    mju_copy(q + 7 * i, r->data->xpos + 3 * id, 3);
    mju_copy(q + 7 * i + 3, r->data->xquat + 4 * id, 4);
  }
  for (int i = 0; i < r->model->nv; i++) fastest = fmax(fastest, fabs(r->data->qvel[i]));
  return fastest;
}

void mujoco_end(void *peer)
{
  run *r = peer;
  if (!r) return;
  mj_deleteData(r->data);
  mj_deleteModel(r->model);
  free(r);
}
