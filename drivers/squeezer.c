/* nsdae-squeezer: see models/squeezer.c. */
#include "squeezer.h"

int main(int argc, char **argv)
{
  return driver_main(&squeezer_model, argc, argv);
}
