/* nsdae-dominoes: see models/dominoes.c. */
#include "dominoes.h"

int main(int argc, char **argv)
{
  return driver_main(&dominoes_model, argc, argv);
}
