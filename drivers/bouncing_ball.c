/* nsdae-bouncing-ball: see models/bouncing_ball.c. */
#include "bouncing_ball.h"

int main(int argc, char **argv)
{
  return driver_main(&bouncing_ball_model, argc, argv);
}
