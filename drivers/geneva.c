/* nsdae-geneva: see models/geneva.c. */
#include "geneva.h"

int main(int argc, char **argv)
{
  return driver_main(&geneva_model, argc, argv);
}
