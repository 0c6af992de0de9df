/* nsdae-cam: see models/cam.c. */
#include "cam.h"

int main(int argc, char **argv)
{
  return driver_main(&cam_model, argc, argv);
}
