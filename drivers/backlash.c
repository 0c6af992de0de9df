/* nsdae-backlash: see models/backlash.c. */
#include "backlash.h"

int main(int argc, char **argv)
{
  return driver_main(&backlash_model, argc, argv);
}
