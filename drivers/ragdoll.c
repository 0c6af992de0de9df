/* nsdae-ragdoll: see models/ragdoll.c. */
#include "ragdoll.h"

int main(int argc, char **argv)
{
  return driver_main(&ragdoll_model, argc, argv);
}
