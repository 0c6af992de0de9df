/* nsdae-rolling-ball: see models/rolling_ball.c. */
#include "rolling_ball.h"

int main(int argc, char **argv)
{
  return driver_main(&rolling_ball_model, argc, argv);
}
