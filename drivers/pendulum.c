/* nsdae-pendulum: see models/pendulum.c. */
#include "pendulum.h"

int main(int argc, char **argv)
{
  return driver_main(&pendulum_model, argc, argv);
}
