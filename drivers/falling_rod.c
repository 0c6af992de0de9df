/* nsdae-falling-rod: see models/falling_rod.c. */
#include "falling_rod.h"

int main(int argc, char **argv)
{
  return driver_main(&falling_rod_model, argc, argv);
}
