/* nsdae-wall: see models/wall.c. */
#include "wall.h"

int main(int argc, char **argv)
{
  return driver_main(&wall_model, argc, argv);
}
