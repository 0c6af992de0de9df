/* nsdae-arch: see models/arch.c. */
#include "arch.h"

int main(int argc, char **argv)
{
  return driver_main(&arch_model, argc, argv);
}
