/* nsdae-clearance-hinge: see models/clearance_hinge.c. */
#include "clearance_hinge.h"

int main(int argc, char **argv)
{
  return driver_main(&clearance_hinge_model, argc, argv);
}
