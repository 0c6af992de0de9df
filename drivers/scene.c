/* nsdae-scene: see models/scene_file.c. */
#include "scene_file.h"

int main(int argc, char **argv)
{
  return driver_main(&scene_file_model, argc, argv);
}
