/* nsdae-gripper: see models/gripper.c. */
#include "gripper.h"

int main(int argc, char **argv)
{
  return driver_main(&gripper_model, argc, argv);
}
