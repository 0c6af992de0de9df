/* nsdae-crank-slider: see models/crank_slider.c. */
#include "crank_slider.h"

int main(int argc, char **argv)
{
  return driver_main(&crank_slider_model, argc, argv);
}
