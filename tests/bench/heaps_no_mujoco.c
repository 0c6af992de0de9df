#include "heaps_rival.h"

double mujoco_packing(const packing *p, int *contacts)
{
  (void)p;
  (void)contacts;
  return -1;
}
