/* MuJoCo is not installed. */
#include "walkers_rival.h"

int mujoco_walkers(int first, int last, double dt, double end, double *height, double *deepest)
{
  (void)first;
  (void)last;
  (void)dt;
  (void)end;
  (void)height;
  (void)deepest;
  return -1;
}
