/* nsdae-car-axis: see models/car_axis.c. */
#include "car_axis.h"

int main(int argc, char **argv)
{
  return driver_main(&car_axis_model, argc, argv);
}
