/* nsdae-flexible-crank: see models/flexible_crank.c. */
#include "flexible_crank.h"

int main(int argc, char **argv)
{
  return driver_main(&flexible_crank_model, argc, argv);
}
