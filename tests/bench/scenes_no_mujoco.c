#include <stddef.h>

#include "scenes_rival.h"

void *mujoco_begin(const mechanism *m, const char *solver)
{
  (void)m, (void)solver;
  return NULL;
}

int mujoco_advance(void *run, int count, double *time)
{
  (void)run, (void)count, (void)time;
  return -1;
}

double mujoco_state(const void *run, double *q)
{
  (void)run, (void)q;
  return 0;
}

void mujoco_end(void *run)
{
  (void)run;
}
