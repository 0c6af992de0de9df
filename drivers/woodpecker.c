/* nsdae-woodpecker: see models/woodpecker.c. */
#include "woodpecker.h"

int main(int argc, char **argv)
{
  return driver_main(&woodpecker_model, argc, argv);
}
