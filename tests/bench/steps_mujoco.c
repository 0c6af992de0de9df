#include <stdio.h>

#include <mujoco/mujoco.h>

#include "steps_rival.h"
#include "ratio.h"

/* The model as MuJoCo's XML; returns its length, or 0 where the room is too small. */
static int write_model(const column *c, char *xml, int room)
{
  int n =
      snprintf(xml, (size_t)room,
               "<mujoco><option timestep='%g' gravity='0 0 %g'><flag energy='disable'/></option>"
               "<worldbody><geom type='plane' size='1 1 1' condim='1'/>",
               c->dt, -c->gravity);
  for (int i = 0; i < c->balls && n < room; i++)
    n += snprintf(xml + n, (size_t)(room - n),
                  "<body pos='0 0 %.17g'><joint type='slide' axis='0 0 1'/>"
                  "<geom type='sphere' size='%g' mass='%g' condim='1'/></body>",
                  column_height(c, i), c->radius, c->mass);
  if (n < room) n += snprintf(xml + n, (size_t)(room - n), "</worldbody></mujoco>");
  return n < room ? n : 0;
}

static mjModel *load(const column *c)
{
  static char xml[1 << 18], text[1000];
  mjVFS files;
  int n = write_model(c, xml, sizeof xml);
  mj_defaultVFS(&files);
  if (n == 0 || mj_addBufferVFS(&files, "column.xml", xml, n) != 0) return NULL;
  mjModel *model = mj_loadXML("column.xml", &files, text, sizeof text);
  mj_deleteVFS(&files);
  return model;
}

double mujoco_column(const column *c, double *top)
{
  mjModel *model = load(c);
  mjData *data = model ? mj_makeData(model) : NULL;
  if (!data) return -1;
  double start = ratio_cpu();
  for (int i = 0; i < c->steps; i++) mj_step(model, data);
  double taken = ratio_cpu() - start;
  *top = column_height(c, c->balls - 1) + data->qpos[c->balls - 1];
  mj_deleteData(data);
  mj_deleteModel(model);
  return taken;
}
