/* nsdae-pendulum: see models/pendulum.c. */
#include <gsl/gsl_errno.h>

#include "pendulum.h"

int main(int argc, char **argv)
{
  gsl_set_error_handler_off();
  return driver_main(&pendulum_model, argc, argv);
}
