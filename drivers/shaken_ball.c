/* nsdae-shaken-ball: see models/shaken_ball.c. */
#include "shaken_ball.h"

int main(int argc, char **argv)
{
  return driver_main(&shaken_ball_model, argc, argv);
}
