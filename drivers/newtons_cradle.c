/* nsdae-newtons-cradle: see models/newtons_cradle.c. */
#include "newtons_cradle.h"

int main(int argc, char **argv)
{
  return driver_main(&newtons_cradle_model, argc, argv);
}
