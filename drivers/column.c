/* nsdae-column: see models/column.c. */
#include "column.h"

int main(int argc, char **argv)
{
  return driver_main(&column_model, argc, argv);
}
