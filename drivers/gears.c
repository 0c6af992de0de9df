/* nsdae-gears: see models/gears.c. */
#include "gears.h"

int main(int argc, char **argv)
{
  return driver_main(&gears_model, argc, argv);
}
