/* nsdae-incline: see models/incline.c. */
#include "incline.h"

int main(int argc, char **argv)
{
  return driver_main(&incline_model, argc, argv);
}
